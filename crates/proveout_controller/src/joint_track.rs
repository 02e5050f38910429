//! What a path asks of the joints when the ball center (or the tip) runs along it at constant speed: the *demand*, which knows
//! no control, no limits and no corner rounding.
//!
//! ```text
//!   poses of blocks      o-----o------o----o-----o      ball centers joined by straight lines, axes by great circles
//!   samples              |   |   |   |   |   |   |      every `step` of the ball center's path
//!   joints               q0  q1  q2  q3                 v = dq / dt, a = d2q / dt2 by differences over dt = step / speed
//! ```
//!
//! The acceleration of a path whose orientation is only continuous is no number: differences grow as 1 / step. Programs are
//! compared at one step, which belongs to the result.

use proveout_geom::ToolPose;
use proveout_machine::{JointValues, KinematicsError, Machine};

/// Motion back over less than this is no reversal, mm and radian. Text with four decimals of a position and eight of a tool
/// vector moves joints that stand by 1e-4 mm and 1e-8 radian; no drive shows a motion of 1e-6 radian (0.2 arc seconds).
const REVERSAL: (f64, f64) = (1e-3, 1e-6);

/// How a track is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackSettings {
    /// Length of the tool from the gauge line to the tip, mm.
    pub gauge_length: f64,
    /// Distance of the point that runs at constant speed from the tip along the axis, mm: the radius of a ball end mill.
    pub center: f64,
    /// Distance of samples along the path of that point, mm.
    pub step: f64,
    /// Its speed, mm/s.
    pub speed: f64,
}

/// Joint positions at equal steps of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTrack {
    /// How it was taken.
    pub settings: TrackSettings,
    /// Joints at the samples.
    pub positions: Vec<JointValues>,
    /// Motion back that is no reversal, for each joint.
    dead_band: JointValues,
}

/// Extremes of a joint; mm or radian, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointDemand {
    /// Lowest position.
    pub min: f64,
    /// Highest position.
    pub max: f64,
    /// Highest speed.
    pub velocity: f64,
    /// Highest acceleration.
    pub acceleration: f64,
    /// Changes of the direction of motion; motion back by less than a micrometer or 1e-6 radian does not count.
    pub reversals: u32,
}

impl JointTrack {
    /// Samples the joints along a path of poses in the frame of the table. Two poses at one place are one sample apart by
    /// nothing: they are passed over.
    ///
    /// # Errors
    /// A rotary joint cannot take an axis. Travel of slides is not looked at: it is judged when the program runs.
    pub fn new(machine: &Machine, poses: &[ToolPose], settings: TrackSettings) -> Result<Self, KinematicsError> {
        let mut positions = Vec::new();
        let mut q = machine.home();
        let mut take = |pose: &ToolPose| -> Result<(), KinematicsError> {
            q = match machine.inverse_nearest(pose, settings.gauge_length, &q) {
                Ok(solution) => solution.q,
                Err(KinematicsError::OverTravel { rotary: false, solution, .. }) => solution.q,
                Err(e) => return Err(e),
            };
            positions.push(q);
            Ok(())
        };
        // Distance from the last sample to the beginning of the segment.
        let mut walked = 0.0;
        if let Some(first) = poses.first() {
            take(first)?;
        }
        for pair in poses.windows(2) {
            let [from, to] =
                [0, 1].map(|k| ToolPose { tip: pair[k].tip + pair[k].axis * settings.center, axis: pair[k].axis });
            let length = (to.tip - from.tip).norm();
            let mut at = settings.step - walked;
            while at <= length && settings.step > 0.0 {
                let pose = from.interpolated(&to, at / length);
                take(&ToolPose { tip: pose.tip - pose.axis * settings.center, axis: pose.axis })?;
                at += settings.step;
            }
            walked = length - (at - settings.step);
        }
        let mut dead_band = JointValues::ZERO;
        for (band, joint) in dead_band.0.iter_mut().zip(&machine.joints) {
            *band = if joint.is_rotary() { REVERSAL.1 } else { REVERSAL.0 };
        }
        Ok(Self { settings, positions, dead_band })
    }

    /// Time between two samples, s.
    fn cycle(&self) -> f64 {
        self.settings.step / self.settings.speed
    }

    /// Length of the path up to the last sample, mm.
    pub fn length(&self) -> f64 {
        self.settings.step * self.positions.len().saturating_sub(1) as f64
    }

    /// Speed of a joint between each two samples, per second.
    pub fn velocities(&self, joint: usize) -> impl Iterator<Item = f64> + '_ {
        let cycle = self.cycle();
        self.positions.windows(2).map(move |w| (w[1][joint] - w[0][joint]) / cycle)
    }

    /// Acceleration of a joint at each inner sample.
    pub fn accelerations(&self, joint: usize) -> impl Iterator<Item = f64> + '_ {
        let square = self.cycle() * self.cycle();
        self.positions.windows(3).map(move |w| (w[2][joint] - 2.0 * w[1][joint] + w[0][joint]) / square)
    }

    /// Extremes of a joint.
    pub fn demand(&self, joint: usize) -> JointDemand {
        let high = |m: f64, v: f64| m.max(v.abs());
        let values = || self.positions.iter().map(|q| q[joint]);
        JointDemand {
            min: values().fold(f64::INFINITY, f64::min),
            max: values().fold(f64::NEG_INFINITY, f64::max),
            velocity: self.velocities(joint).fold(0.0, high),
            acceleration: self.accelerations(joint).fold(0.0, high),
            reversals: reversals(values(), self.dead_band[joint]),
        }
    }

    /// Time for the path when the speed is reduced interval by interval until no joint passes its velocity in `limits`
    /// (infinite: no limit), s. Accelerations are not looked at.
    pub fn time_within(&self, limits: &JointValues) -> f64 {
        let cycle = self.cycle();
        let needed = |w: &[JointValues]| {
            let part = (w[1] - w[0]).zip_map(*limits, |d, limit| if d == 0.0 { 0.0 } else { d.abs() / limit });
            cycle.max(part.max_abs())
        };
        self.positions.windows(2).map(needed).sum()
    }
}

/// Changes of direction of a row of positions.
fn reversals(positions: impl Iterator<Item = f64>, dead_band: f64) -> u32 {
    let mut count = 0;
    let mut direction = 0.0;
    let mut extreme: Option<f64> = None;
    for x in positions {
        let Some(last) = extreme else {
            extreme = Some(x);
            continue;
        };
        let moved = x - last;
        if moved * direction > 0.0 {
            extreme = Some(x);
        } else if moved.abs() > dead_band {
            count += u32::from(direction != 0.0);
            direction = moved.signum();
            extreme = Some(x);
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proveout_geom::{Point, Vector};

    use super::*;

    fn machine() -> Machine {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/starrag-lx-451");
        Machine::read(&folder).expect("library machine")
    }

    const SETTINGS: TrackSettings = TrackSettings { gauge_length: 100.0, center: 8.0, step: 0.5, speed: 10.0 };

    /// Ball centers on a circle about the table axis with the tool along the radius: A turns evenly, nothing else moves.
    fn circle(radius: f64, blocks: u32) -> Vec<ToolPose> {
        (0..=blocks)
            .map(|i| {
                let (s, c) = (f64::from(i) * 1e-3).sin_cos();
                let axis = Vector::new(0.0, -s, c);
                ToolPose { tip: Point::from(axis * radius) + Vector::new(300.0, 0.0, 0.0) - axis * 8.0, axis }
            })
            .collect()
    }

    #[test]
    fn a_circle_about_the_table_axis_asks_for_an_even_turn() {
        let machine = machine();
        let a = machine.joint("A").expect("A");
        let track = JointTrack::new(&machine, &circle(50.0, 3000), SETTINGS).expect("in reach");
        // 3000 chords of 0.05 mm: 149.99999 mm, so 299 whole steps and the first sample.
        assert_eq!(track.positions.len(), 300);
        assert!((track.length() - 149.5).abs() < 1e-9);
        let demand = track.demand(a);
        // Chords are shorter than the arc by 1e-3^2 / 24 of it.
        assert!((demand.velocity - 10.0 / 50.0).abs() < 1e-7, "{demand:?}");
        assert!(demand.acceleration < 1e-6 && demand.reversals == 0, "{demand:?}");
        let z = track.demand(machine.joint("Z").expect("Z"));
        assert!(z.max - z.min < 1e-4 && z.reversals == 0, "{z:?}");
        // Half of the speed that the path asks for: twice the time; more than it: the time at constant speed.
        let mut limits = JointValues([f64::INFINITY; proveout_machine::MAX_JOINTS]);
        limits[a] = 0.1;
        assert!((track.time_within(&limits) / (2.0 * 14.95) - 1.0).abs() < 1e-6);
        limits[a] = 1.0;
        assert!((track.time_within(&limits) - 14.95).abs() < 1e-9);
    }

    #[test]
    fn the_track_does_not_hang_on_how_the_path_is_cut_into_blocks() {
        let machine = machine();
        let fine = circle(50.0, 3000);
        let mut state = 5_u64;
        let coarse: Vec<ToolPose> = fine
            .iter()
            .enumerate()
            .filter(|(i, _)| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                *i == 0 || *i == 3000 || state >> 62 == 0
            })
            .map(|(_, pose)| *pose)
            .collect();
        assert!(coarse.len() > 500 && coarse.len() < 1000);
        let [fine, coarse] = [fine, coarse].map(|p| JointTrack::new(&machine, &p, SETTINGS).expect("in reach"));
        for (p, q) in fine.positions.iter().zip(&coarse.positions) {
            // Gaps of up to some 40 points are chords of 2 mm: 0.01 mm off the circle.
            assert!((*p - *q).max_abs() < 0.02, "{p:?} {q:?}");
        }
    }

    #[test]
    fn only_motion_back_beyond_the_dead_band_is_a_reversal() {
        let count = |row: &[f64]| reversals(row.iter().copied(), 1e-3);
        assert_eq!(count(&[0.0, 1.0, 2.0, 1.9995, 2.5]), 0);
        assert_eq!(count(&[0.0, 1.0, 0.5, 1.0]), 2);
        assert_eq!(count(&[0.0, 1.0, 0.9995, 0.999, 0.9985, 0.998]), 1, "slowly back counts too");
        assert_eq!(count(&[3.0, 3.0004, 2.9996, 3.0]), 0, "noise at standstill");
        assert_eq!(count(&[]), 0);
    }
}
