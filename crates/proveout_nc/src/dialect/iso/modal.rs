//! What stays in force from block to block.

use super::flavor::Flavor;
use crate::control::{Centers, Control, StartFeed, StartMotion};
use crate::frame::Frame;
use crate::g_code::{G0, G1, G80, GCode};
use crate::{CompSide, PathMode};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionMode {
    Rapid,
    Linear,
    Clockwise,
    CounterClockwise,
    /// G33
    Thread,
    /// G5, G5.1 of `LinuxCNC`.
    Spline,
    /// G5.2, G5.3 of `LinuxCNC`.
    Nurbs,
    /// G38.2 to G38.5: the code times ten. The mode holds for one block.
    Probe,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FeedMode {
    PerTime,
    PerRevolution,
    InverseTime,
}

/// Tool length compensation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Length {
    Off,
    /// The offset with this number.
    Edge(u32),
    /// A length that the program itself gives; the value is in [`Frames::length`].
    Programmed(u32),
}

/// Offsets of X, Y, Z in mm and of A, B, C in radian.
pub(crate) type Shift = [f64; 6];

fn shifted(shift: &Shift) -> Frame {
    let [x, y, z, a, b, c] = *shift;
    Frame { rotary: [a, b, c], ..Frame::translation([x, y, z]) }
}

/// Frames of the control from the base to the work coordinates.
///
/// ```text
/// Fanuc, Haas  base = length * external * G54 * G92 * G52 * plane (G68.2, G254) * rotation (G68)
///                     * mirror * work
/// `LinuxCNC`     base = length * G54 * rotation (G10 L2 R) * G92 * work
/// ```
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    /// Tool length that the program gives (G43.1, G10 L10), as a shift of the axes.
    pub(crate) length: [f64; 3],
    /// G10 L2 P0.
    pub(crate) external: Shift,
    pub(crate) settable: Shift,
    /// Rotation of the work offset, degrees (`LinuxCNC`, G10 L2 R).
    pub(crate) turn: f64,
    /// G92.
    pub(crate) shift: Shift,
    /// G92 offsets out of effect by G92.2.
    pub(crate) kept_shift: Option<Shift>,
    /// G52 of Fanuc and Haas.
    pub(crate) local: Shift,
    pub(crate) plane: Frame,
    /// G51 of a Haas.
    pub(crate) scale: Frame,
    pub(crate) rotation: Frame,
    pub(crate) mirror: Frame,
}

impl Frames {
    fn new() -> Self {
        Self {
            length: [0.0; 3],
            external: [0.0; 6],
            settable: [0.0; 6],
            turn: 0.0,
            shift: [0.0; 6],
            kept_shift: None,
            local: [0.0; 6],
            plane: Frame::IDENTITY,
            scale: Frame::IDENTITY,
            rotation: Frame::IDENTITY,
            mirror: Frame::IDENTITY,
        }
    }

    pub(crate) fn total(&self, flavor: Flavor) -> Frame {
        let outer = Frame::translation(self.length).then(&shifted(&self.external)).then(&shifted(&self.settable));
        if flavor.is_linuxcnc() {
            return outer.then(&Frame::rotation(2, self.turn)).then(&shifted(&self.shift));
        }
        outer
            .then(&shifted(&self.shift))
            .then(&shifted(&self.local))
            .then(&self.plane)
            .then(&self.scale)
            .then(&self.rotation)
            .then(&self.mirror)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Modal {
    /// None where no motion word is in force: at the start, on a `LinuxCNC` after G80.
    pub(crate) motion: Option<MotionMode>,
    /// The motion or probing word.
    pub(crate) motion_code: GCode,
    /// The drilling cycle in force.
    pub(crate) cycle: Option<GCode>,
    /// Index of the axis normal to the working plane: 2 for G17, 1 for G18, 0 for G19.
    pub(crate) normal: usize,
    pub(crate) incremental: bool,
    /// G90.1
    pub(crate) absolute_centers: bool,
    /// None before G20 or G21.
    pub(crate) inch: Option<bool>,
    pub(crate) feed_mode: FeedMode,
    /// G99: cycles return to the R plane; none before the first word.
    pub(crate) return_to_r: Option<bool>,
    /// Level of G71, and whether M53 (true) or M54 has said where cycles come back to, on a control with
    /// these words.
    pub(crate) stated_level: Option<f64>,
    pub(crate) back_to_level: Option<bool>,
    pub(crate) path_mode: Option<PathMode>,
    pub(crate) offset: String,
    /// G16: radius and angle in mm and degrees, as far as programmed.
    pub(crate) polar: bool,
    pub(crate) polar_radius: Option<f64>,
    pub(crate) polar_angle: Option<f64>,
    pub(crate) comp: CompSide,
    pub(crate) length: Length,
    /// G43.4, G43.5, G234: the tool center point is controlled.
    pub(crate) tcp: bool,
    /// G43.5: the orientation comes as I J K.
    pub(crate) vectors: bool,
    /// Surface speed of G96, m/min, and the highest spindle speed.
    pub(crate) surface: Option<(f64, f64)>,
    pub(crate) rigid: bool,
    /// G63 has fixed the overrides.
    pub(crate) tapping: bool,
    pub(crate) frames: Frames,
    /// State of G68.2, and with it whether base coordinates are those of the table.
    pub(crate) plane: Plane,
}

/// Tilted working plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plane {
    Off,
    /// G68.2 without a motion of linear axes yet.
    Defined,
    /// Base coordinates are those of the table.
    Engaged,
    /// G254: the plane follows the rotary axes.
    Dynamic,
}

impl Modal {
    /// G2 or G3 is in force.
    pub(crate) fn is_arc(&self) -> bool {
        matches!(self.motion, Some(MotionMode::Clockwise | MotionMode::CounterClockwise))
    }

    /// Power-on state: G17, G90, G94, G98, G40, G49, G54; no motion word, no unit. What the control states
    /// goes before.
    pub(crate) fn new(control: &Control) -> Self {
        let start = &control.start;
        let (motion, motion_code) = match start.motion {
            Some(StartMotion::Rapid) => (Some(MotionMode::Rapid), G0),
            Some(StartMotion::Linear) => (Some(MotionMode::Linear), G1),
            Some(StartMotion::None) | None => (None, G80),
        };
        Self {
            motion,
            motion_code,
            cycle: None,
            normal: start.normal.unwrap_or(2),
            incremental: start.incremental.unwrap_or(false),
            absolute_centers: control.centers == Centers::Absolute,
            inch: start.inch,
            feed_mode: match start.feed {
                Some(StartFeed::PerRevolution) => FeedMode::PerRevolution,
                Some(StartFeed::InverseTime) => FeedMode::InverseTime,
                Some(StartFeed::PerMinute) | None => FeedMode::PerTime,
            },
            return_to_r: None,
            stated_level: None,
            back_to_level: None,
            path_mode: None,
            offset: "G54".to_owned(),
            polar: false,
            polar_radius: None,
            polar_angle: None,
            comp: CompSide::Off,
            length: Length::Off,
            tcp: false,
            vectors: false,
            surface: None,
            rigid: false,
            tapping: false,
            frames: Frames::new(),
            plane: Plane::Off,
        }
    }

    /// First and second axis of the plane and its normal, right-handed.
    pub(crate) fn plane_axes(&self) -> [usize; 3] {
        [(self.normal + 1) % 3, (self.normal + 2) % 3, self.normal]
    }

    /// mm for one unit of length of the program.
    pub(crate) fn unit(&self) -> f64 {
        if self.inch == Some(true) { 25.4 } else { 1.0 }
    }

    /// Base coordinates are those of the table.
    pub(crate) fn in_table(&self) -> bool {
        self.tcp || matches!(self.plane, Plane::Engaged | Plane::Dynamic)
    }
}

/// Values of a drilling cycle that stay in force with it: mm, seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CycleValues {
    /// Words Z (depth) and R as programmed, mm, and whether under G91.
    pub(crate) z: Option<(f64, bool)>,
    pub(crate) r: Option<(f64, bool)>,
    pub(crate) q: Option<f64>,
    pub(crate) p: Option<f64>,
    /// I, J, K of peck drilling (Haas) or of the shift of boring.
    pub(crate) ijk: [Option<f64>; 3],
    /// mm of one unit of length in the blocks of the cycle so far.
    pub(crate) unit: Option<f64>,
    /// Level of the tool when the first cycle of the sequence began.
    pub(crate) initial: Option<f64>,
}
