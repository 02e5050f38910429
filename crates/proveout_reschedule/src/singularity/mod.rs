//! Smoothing of tool axes near the pole of the rotary table.
//!
//! Source: Cui C., Zhu Z., Chen S., Zheng Q., Chai J., Li X. (2022), A tool orientation smoothing method for
//! five-axis machining to avoid singularity problems. Angles of an axis: equations (2.2) to (2.4), corrected.
//! Runs near the pole, linear or through it: section 2.5, steps 1 to 11, corrected. Junctions: equation
//! (2.6), corrected. Tip from contact: equations (2.7) to (2.9), corrected and for any cutter of revolution
//! ([`PathCutter::touch`]).
//!
//! Where the axis comes near the table's axis the table swings by up to half a turn within a few
//! blocks. There the angles to and about the pole become linear in the arc length of the contact,
//! between the last block outside before and the first one outside after it. Where the azimuths
//! differ by more than a quarter turn the pole itself is crossed, so that the head changes its sign
//! and the table goes on. The contact stays; the axis changes by about its distance from the pole.
//!
//! Switch at 90 degrees, junctions of five blocks: as published. The threshold of the cone is one of the two
//! published values, the other (10 degrees) has a text of 3 degrees that contradicts it (erratum SG-4). The
//! unit of the table's rate is not printed; it is read as degrees for a mm.
//!
//! The new angles are returned as joints: read back from a vector, the table's angle at the pole is
//! lost. So the method writes programs that give rotary axes.

mod pole;

use proveout_geom::{ToolPose, Vector};
use proveout_machine::{Carries, JointValues, Machine};
use proveout_path::PathCutter;

use super::{
    Curve, CurveKind, CuttingRun, Figure, Method, Quantity, RescheduleError, Rescheduled, Study, Surroundings,
    touching::contacts,
};

pub use pole::{Junction, PoleAngles, PoleStretch, between, fitted, pole_angles};
use pole::{Rules, treated};

/// Sine of the angle between two directions below which they count as parallel.
const PARALLEL: f64 = 1e-9;
/// Axes nearer than this are the same, radian.
const SAME_AXIS: f64 = 1e-9;
/// Way from block to block at least, mm: some only turn the tool.
const LEAST_STEP_MM: f64 = 1e-9;
/// A joint that moves by no more than this does not turn back, radian.
const SAME_PLACE: f64 = 1e-9;

/// Parameters of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// Blocks whose axis is nearer to the table's axis than this are looked at, radian.
    pub cone: f64,
    /// They are changed where the table turns by more than this for a mm of contact path, rad/mm.
    pub rate: f64,
    /// How junctions are smoothed.
    pub junction: Junction,
}

impl Default for Singularity {
    fn default() -> Self {
        Self { cone: 5.0_f64.to_radians(), rate: 1.0_f64.to_radians(), junction: Junction::Free }
    }
}

/// The two rotary joints of a machine as angles to and about the table's axis.
struct TableTilt<'a> {
    machine: &'a Machine,
    table: usize,
    tilt: usize,
    /// Position of the tilt joint with the tool axis on the table's axis.
    upright: f64,
    /// Azimuth for a tilt above that with the table at zero, and how the table's position grows with the
    /// azimuth.
    azimuth: f64,
    sense: f64,
    /// From the frame of the pole (z) to the frame of the run.
    basis: [Vector; 3],
}

impl<'a> TableTilt<'a> {
    fn new(machine: &'a Machine, pole: Vector) -> Option<Self> {
        let &[a, b] = machine.rotary_joints() else { return None };
        let table = machine.work_chain.iter().rfind(|&&j| machine.joints[j].is_rotary()).copied()?;
        let tilt = if table == a { b } else { a };
        let joint = &machine.joints[table];
        if (table != a && table != b)
            || joint.carries != Carries::Workpiece
            || joint.direction.cross(&pole).norm() > PARALLEL
        {
            return None;
        }
        let helper = if pole.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        let u = (helper - pole * helper.dot(&pole)).normalize();
        let basis = [u, pole.cross(&u), pole];
        let axis = |t: f64, c: f64| {
            let mut q = machine.home();
            (q[tilt], q[table]) = (t, c);
            machine.forward(&q, 0.0).axis
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let upright = (0..4).map(|k| quarter * f64::from(k)).find(|t| (axis(*t, 0.0) - pole).norm() < SAME_AXIS)?;
        let leaned = axis(upright + 0.5, 0.0);
        let azimuth = leaned.dot(&basis[1]).atan2(leaned.dot(&basis[0]));
        let sense = -joint.sense * joint.direction.dot(&pole).signum();
        let head = Self { machine, table, tilt, upright, azimuth, sense, basis };
        // The formula holds for a tilt at right angles to the table's axis, which three places show.
        let holds = [(0.3, 1.0), (-0.8, 0.4), (1.1, -2.0)].into_iter().all(|(polar, azimuth)| {
            let angles = PoleAngles { polar, azimuth };
            let q = head.joints(&angles);
            (axis(q[tilt], q[table]) - head.axis(&angles)).norm() < SAME_AXIS
        });
        holds.then_some(head)
    }

    fn axis(&self, angles: &PoleAngles) -> Vector {
        let local = angles.axis();
        self.basis[0] * local.x + self.basis[1] * local.y + self.basis[2] * local.z
    }

    fn joints(&self, angles: &PoleAngles) -> JointValues {
        let mut q = self.machine.home();
        q[self.tilt] = self.upright + angles.polar;
        q[self.table] = self.sense * (angles.azimuth - self.azimuth);
        q
    }

    fn angles(&self, q: &JointValues) -> PoleAngles {
        let turn = std::f64::consts::TAU;
        let polar = q[self.tilt] - self.upright;
        PoleAngles { polar: polar - turn * (polar / turn).round(), azimuth: self.azimuth + self.sense * q[self.table] }
    }
}

impl Singularity {
    fn check(&self) -> Result<(), RescheduleError> {
        let fits = self.cone > 0.0 && self.cone <= 45.0_f64.to_radians() && self.rate >= 0.0 && self.rate.is_finite();
        if fits {
            return Ok(());
        }
        Err(RescheduleError::new(
            "reschedule-option",
            0,
            format!(
                "a cone of {} degrees and a rate of {} degrees for a mm",
                self.cone.to_degrees(),
                self.rate.to_degrees()
            ),
            "give a cone above 0 and up to 45 degrees, and a rate of at least zero",
        ))
    }

    /// Angles of a row of contacts near the pole z, and the stretches that were changed. `crossing`
    /// says whether the polar angle may change its sign.
    pub fn row(&self, row: &[PoleAngles], arc: &[f64], crossing: bool) -> (Vec<PoleAngles>, Vec<PoleStretch>) {
        let &Self { cone, rate, junction } = self;
        treated(row, arc, &Rules { cone, rate, junction, crossing })
    }
}

impl Method for Singularity {
    fn name(&self) -> &'static str {
        "singularity"
    }

    fn source(&self) -> &'static str {
        "Cui et al. 2022, A tool orientation smoothing method for five-axis machining to avoid singularity problems"
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        self.check()?;
        let line = |i: usize| run.blocks.get(i).map_or(0, |b| b.line);
        let machine = around.machine;
        let head = machine.and_then(|m| TableTilt::new(m, around.table_axis)).ok_or_else(|| {
            let message = "the machine has no table under a head or trunnion that tilts at right angles to the table's axis and \
                           stands upright on it";
            RescheduleError::new("reschedule-path", line(0), message, "the method is for such machines: choose another")
        })?;
        let cutter = PathCutter::new(around.cutter.clone());
        let contacts = contacts(run, &cutter, around)?;
        let mut arc = vec![0.0; run.blocks.len()];
        for i in 1..arc.len() {
            let step = (contacts[i].place.point - contacts[i - 1].place.point).norm();
            // Blocks that only turn the tool have no length of their own.
            arc[i] = arc[i - 1] + step.max(LEAST_STEP_MM);
        }
        let local = |v: &Vector| Vector::new(v.dot(&head.basis[0]), v.dot(&head.basis[1]), v.dot(&head.basis[2]));
        let axes: Vec<Vector> = run.blocks.iter().map(|b| local(&b.pose.axis)).collect();
        let first =
            run.blocks.first().and_then(|b| head.machine.inverse_nearest(&b.pose, 0.0, &head.machine.home()).ok());
        let start = first.map_or(PoleAngles { polar: 0.1, azimuth: head.azimuth }, |s| head.angles(&s.q));
        let row = pole_angles(&axes, start);
        let fits = |row: &[PoleAngles]| {
            let over = |p: &PoleAngles| head.machine.joints[head.tilt].travel_violation(head.joints(p)[head.tilt]);
            row.iter().all(|p| over(p).is_none())
        };
        let (mut new, mut stretches) = self.row(&row, &arc, true);
        if !fits(&new) {
            (new, stretches) = self.row(&row, &arc, false);
        }
        let table = &head.machine.joints[head.table];
        for (i, angles) in new.iter().enumerate() {
            if let (Some(limit), Some([low, high])) =
                (table.travel_violation(head.joints(angles)[head.table]), table.travel)
            {
                let message = format!(
                    "the new orientation is out of reach: {} would have to go past {:.1} degrees; its travel is {:.1} to {:.1} degrees",
                    table.name,
                    limit.to_degrees(),
                    low.to_degrees(),
                    high.to_degrees()
                );
                let help = "split the path before this block, or take a machine with a table without end stops";
                return Err(RescheduleError::new("reschedule-range", line(i), message, help));
            }
        }
        let poses: Vec<ToolPose> = run
            .blocks
            .iter()
            .zip(&contacts)
            .zip(row.iter().zip(&new))
            .map(|((block, at), (old, angles))| {
                if old.axis() == angles.axis() {
                    return block.pose;
                }
                let axis = head.axis(angles);
                match cutter.ball_radius() {
                    Some(radius) => ToolPose { tip: at.place.point - axis * radius, axis },
                    None => ToolPose { tip: cutter.touch(&at.place, &axis, 0.0, None).pose.tip + at.off, axis },
                }
            })
            .collect();
        let study = study(&arc, [&row, &new], &stretches);
        let rotary = Some(new.iter().map(|p| head.joints(p)).collect());
        Ok(Rescheduled { stretch: 0..poses.len(), poses, rotary, channel: None, study })
    }
}

/// Sum of the turns of the table, its largest rate, how often the polar angle turns back, the largest jump of
/// the table's rate from block to block, and how often the table turns back.
fn row_figures(row: &[PoleAngles], arc: &[f64]) -> [f64; 5] {
    let steps = || row.windows(2).zip(arc.windows(2));
    let travel: f64 = steps().map(|(p, _)| (p[1].azimuth - p[0].azimuth).abs()).sum();
    let rate = steps().map(|(p, s)| ((p[1].azimuth - p[0].azimuth) / (s[1] - s[0])).abs()).fold(0.0, f64::max);
    let reversals = |of: fn(&PoleAngles) -> f64| {
        let (mut last, mut count) = (0.0, 0.0);
        for step in row.windows(2).map(|p| of(&p[1]) - of(&p[0])).filter(|s| s.abs() > SAME_PLACE) {
            if last * step < 0.0 {
                count += 1.0;
            }
            last = step;
        }
        count
    };
    let rates: Vec<f64> = steps().map(|(p, s)| (p[1].azimuth - p[0].azimuth) / (s[1] - s[0])).collect();
    let jump = rates.windows(2).map(|r| (r[1] - r[0]).abs()).fold(0.0, f64::max);
    let [tilt, table] = [reversals(|p| p.polar), reversals(|p| p.azimuth)];
    [travel.to_degrees(), rate.to_degrees(), tilt, jump.to_degrees(), table]
}

fn study(arc: &[f64], [row, new]: [&[PoleAngles]; 2], stretches: &[PoleStretch]) -> Study {
    let curve = |name, kind, quantity, of: fn(&PoleAngles) -> f64, values: &[PoleAngles]| Curve {
        name,
        kind,
        axes: [Quantity { name: "path length of the contact", unit: "mm" }, Quantity { name: quantity, unit: "deg" }],
        points: arc.iter().zip(values).map(|(s, p)| [*s, of(p).to_degrees()]).collect(),
    };
    let polar: fn(&PoleAngles) -> f64 = |p| p.polar;
    let azimuth: fn(&PoleAngles) -> f64 = |p| p.azimuth;
    let (to, about) = ("angle to the table's axis", "angle about the table's axis");
    let figure = |name, unit, value| Figure { name, unit, value };
    let [before, after] = [row, new].map(|r| row_figures(r, arc));
    let change = row.iter().zip(new).map(|(a, b)| a.axis().cross(&b.axis()).norm().atan2(a.axis().dot(&b.axis())));
    let crossed = stretches.iter().filter(|s| s.crossed).count();
    let kept_back = stretches.iter().filter(|s| s.kept_back).count();
    Study {
        curves: vec![
            curve("original", CurveKind::Original, to, polar, row),
            curve("new", CurveKind::Result, to, polar, new),
            curve("original", CurveKind::Original, about, azimuth, row),
            curve("new", CurveKind::Result, about, azimuth, new),
        ],
        figures: vec![
            figure("stretches near the pole", "", stretches.len() as f64),
            figure("stretches through the pole", "", crossed as f64),
            figure("stretches kept on one side for lack of travel", "", kept_back as f64),
            figure("turns of the table before", "deg", before[0]),
            figure("turns of the table", "deg", after[0]),
            figure("largest rate of the table before", "deg/mm", before[1]),
            figure("largest rate of the table", "deg/mm", after[1]),
            figure("largest jump of the table's rate before", "deg/mm", before[3]),
            figure("largest jump of the table's rate", "deg/mm", after[3]),
            figure("reversals of the tilt before", "", before[2]),
            figure("reversals of the tilt", "", after[2]),
            figure("reversals of the table before", "", before[4]),
            figure("reversals of the table", "", after[4]),
            figure("largest change of the tool axis", "deg", change.fold(0.0, f64::max).to_degrees()),
        ],
        ..Study::default()
    }
}
