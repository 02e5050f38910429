//! Quaternion interpolation of key orientations: the baseline of the comparison.
//!
//! Source: Ho M.-C., Hwang Y.-R., Hu C.-H. (2003), Five-axis tool orientation smoothing using quaternion
//! interpolation algorithm, Int. J. Mach. Tools Manuf. 43, 1259-1267. The orientation is kept at key blocks;
//! between two of them it runs on the great circle in proportion to arc length: `V = [sin((1-l) w) V_e +
//! sin(l w) V_f] / sin w`, `cos w = V_e . V_f`.
//!
//! A great circle between vectors of equal inclination to the table axis leaves that inclination
//! slightly, and with it the constant head angle of a four-axis path. For such a path the angle in
//! the section plane is interpolated instead, which is the same formula for planar vectors. Number
//! and places of the keys are not published: the count is a parameter, and keys are at equal arc
//! lengths.

use proveout_geom::Vector;

use super::s_theta::{curve, rescheduled, study};
use super::{
    Channel, CurveKind, CuttingRun, Figure, Method, RescheduleError, Rescheduled, STHETA_DEFAULTS, SectionPath,
    Surroundings,
};

/// Sine of the angle between two axes below which they count as one.
const SAME_AXIS: f64 = 1e-12;

/// Parameters of the baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion {
    /// Key blocks of a whole layer, both ends counted.
    pub keys: usize,
    /// Clearance of the channel that is shown, radian; the method itself does not look at it.
    pub clearance: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { keys: 15, clearance: STHETA_DEFAULTS.clearance }
    }
}

/// Great circle from `from` to `to` at fraction `l`; unit vectors. Between opposite vectors no great circle
/// is defined; the first one stays.
pub fn slerp(from: &Vector, to: &Vector, l: f64) -> Vector {
    let sine = from.cross(to).norm();
    let angle = sine.atan2(from.dot(to));
    if sine < SAME_AXIS {
        return if l < 1.0 { *from } else { *to };
    }
    (from * ((1.0 - l) * angle).sin() + to * (l * angle).sin()) / sine
}

impl Method for Quaternion {
    fn name(&self) -> &'static str {
        "quaternion"
    }

    fn source(&self) -> &'static str {
        "Ho, Hwang, Hu 2003, Int. J. Mach. Tools Manuf. 43, 1259-1267"
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        if !(2..=1_000_000).contains(&self.keys) {
            return Err(RescheduleError::new(
                "reschedule-option",
                0,
                format!("{} key blocks a layer", self.keys),
                "give at least two and at most a million",
            ));
        }
        let path = SectionPath::new(run, around)?;
        let total = path.arc[path.len() - 1];
        let intervals = (total / path.period * (self.keys - 1) as f64).round().max(1.0) as usize;
        let mut keys: Vec<usize> = (0..=intervals)
            .map(|k| {
                let wanted = total * k as f64 / intervals as f64;
                let i = path.arc.partition_point(|&s| s < wanted).min(path.len() - 1);
                if i > 0 && wanted - path.arc[i - 1] < path.arc[i] - wanted { i - 1 } else { i }
            })
            .collect();
        keys.dedup();
        let mut angles = path.axis_angle.clone();
        for pair in keys.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let (from, to) = (path.axis_angle[a], path.axis_angle[b]);
            for (angle, s) in angles[a..=b].iter_mut().zip(&path.arc[a..=b]) {
                let l = (s - path.arc[a]) / (path.arc[b] - path.arc[a]);
                *angle = from + (to - from) * l;
            }
        }
        let channel = Channel::tabulated(&path, self.clearance, f64::MIN)?;
        let mut study = study(&path, &channel, &angles);
        let points: Vec<[f64; 2]> = keys.iter().map(|&i| [path.arc[i], path.axis_angle[i]]).collect();
        study.figures.push(Figure { name: "key points", unit: "", value: keys.len() as f64 });
        study.curves.push(curve("key points", CurveKind::KeyPoints, points));
        Ok(rescheduled(run, &path, &channel, angles, study))
    }
}
