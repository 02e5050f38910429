//! Probing motions (G31, G38, MEAS).
//!
//! A motion that is answered ends where the probe has switched; the reader has put that place into its end.
//! One that is asked for stops the control at its start: [`Controller::take_asked`] hands its way out, and
//! the reader goes on when it has the answer. Without answers a probe runs as a straight motion to its end.

use proveout_geom::ToolPose;
use proveout_nc::{Command, Contact, Location, ProbeMotion, SpindleDirection};

use super::{Controller, pace::Pace};
use crate::{error::ControlError, mapping::Mapping, motion::BlockPath};

/// The tip leaves the chord between two poses of a way by no more than this, mm: a hundredth of a micrometer,
/// a tenth of what a probe repeats.
const STRAIGHT_MM: f64 = 1e-5;
/// A tool axis that turns by more does not stand, radian: 0.3 micrometers at a stylus 300 mm long.
const TURNS: f64 = 1e-9;
/// Halvings of a way: 2^12 chords are more than any table of geometric errors bends it.
const DEEPEST: u32 = 12;

/// The way of a probing motion that waits for its answer, in the table frame K.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeWay {
    /// Its block.
    pub location: Location,
    /// Index of the tool in the spindle in the library; none for an empty spindle.
    pub tool: Option<usize>,
    /// It ends where the probe leaves the surface.
    pub away: bool,
    /// The spindle turns.
    pub spindle_turns: bool,
    /// Tip and tool axis as the actual machine brings them, after each part (0 to 1) of the way; straight
    /// between two of them.
    pub poses: Vec<(f64, ToolPose)>,
}

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    pub(super) fn probe(&mut self, probe: &ProbeMotion, location: &Location) -> Result<(), Box<ControlError>> {
        let (mapping, path) = {
            let context = self.context(probe.motion.machine_coordinates, location);
            (context.mapping, context.straight(&probe.motion, &self.state.position)?)
        };
        if probe.contact == Contact::Asked {
            return self.ask(probe, location, mapping, &path);
        }
        self.motion(&probe.motion, Pace::Probe { contact: probe.contact }, location, mapping, path)
    }

    /// The probing motion before which the control waits, once: the reader must have its answer before the
    /// next chunk is asked for.
    pub fn take_asked(&mut self) -> Option<ProbeWay> {
        self.asked.take().map(|way| *way)
    }

    fn ask(
        &mut self,
        probe: &ProbeMotion,
        location: &Location,
        mapping: Mapping,
        path: &BlockPath,
    ) -> Result<(), Box<ControlError>> {
        self.feed(Pace::Probe { contact: Contact::Asked }, path, mapping, location)?;
        self.stop_run();
        self.ready = true;
        if self.cut_short.is_some() {
            return Ok(());
        }
        let mut poses = Vec::new();
        let kinematics = self.device.frame(mapping).kinematics;
        for part in &path.parts {
            let [from, to] = part.t;
            let pose = |share: f64| {
                let task = part.shape.jet(part.length * share).0[0];
                kinematics.pose(&kinematics.position(&task))
            };
            let at = |share: f64| (from + (to - from) * share, pose(share));
            if poses.is_empty() {
                poses.push(at(0.0));
            }
            chords(&at, [0.0, 1.0], [&pose(0.0), &pose(1.0)], 0, &mut poses);
        }
        if poses.windows(2).any(|pair| pair[0].1.angle_to(&pair[1].1) > TURNS) {
            let message = "the tool axis turns while it probes".to_owned();
            let help = "turn the rotary axes first, and probe with the linear axes alone";
            return Err(Box::new(ControlError::at(location, "control-probe", message, help)));
        }
        self.asked = Some(Box::new(ProbeWay {
            location: location.clone(),
            tool: self.state.tool,
            away: probe.away,
            spindle_turns: self.state.spindle.direction != SpindleDirection::Off,
            poses,
        }));
        Ok(())
    }
}

/// Adds the ends of chords that the tip leaves by less than [`STRAIGHT_MM`].
fn chords(
    at: &dyn Fn(f64) -> (f64, ToolPose),
    [a, b]: [f64; 2],
    [from, to]: [&ToolPose; 2],
    depth: u32,
    out: &mut Vec<(f64, ToolPose)>,
) {
    let half = 0.5 * (a + b);
    let off = |share: f64| {
        let part = (share - a) / (b - a);
        (at(share).1.tip - (from.tip + (to.tip - from.tip) * part)).norm()
    };
    let worst = [0.25, 0.5, 0.75].map(|part| off(a + (b - a) * part)).into_iter().fold(0.0, f64::max);
    if worst <= STRAIGHT_MM || depth >= DEEPEST {
        out.push(at(b));
        return;
    }
    let middle = at(half).1;
    chords(at, [a, half], [from, &middle], depth + 1, out);
    chords(at, [half, b], [&middle, to], depth + 1, out);
}
