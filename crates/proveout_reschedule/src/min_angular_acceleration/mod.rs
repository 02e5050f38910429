//! Tool axes of least angular acceleration along rows of a ball end mill.
//!
//! Source: Ma J., Hu G., Qin F., Li G., Qu Z., Liu Y. (2020), Global optimization method of tool axis vector
//! based on the minimum angular acceleration of rotary feed axis, Int. J. Adv. Manuf. Technol. 107,
//! 2121-2136, doi:10.1007/s00170-020-05171-7. Profile and its derivatives: equations (26) and (27),
//! corrected. Law between keys: equations (35), (40), (41), corrected (as printed the ratio of arc lengths is
//! always one).
//!
//! The row is cut where its profile, height along the table's axis over the horizontal way, changes
//! between convex and concave. Each cut and both ends have a key axis: the initial one, turned
//! towards the table's axis until its lean is below a cap. Between two keys the axis runs on their
//! great circle in proportion to arc length, which is the least sum of squared changes of angular
//! speed with both ends free in speed. At a key the speed jumps: there a cubic that keeps value and
//! speed at both ends replaces the law in a window. It is drawn in the plane that touches the
//! sphere at the key, in which both great circles are straight.
//!
//! Chosen, since nothing is published: cap 47 degrees, windows of 6 mm on each side.
//!
//! Two choices of this project: key axes may be *searched* in the free cells of their contacts, by the
//! paper's own sum (`keys.rs`; its text leaves open how they are found); and in place of the law between keys
//! the axes with the least of that sum over the whole row may be taken (`spline.rs`), of which the law is the
//! least for one pair of keys only. Whether all new axes are free is looked at where the surroundings know
//! it.

mod keys;
mod spline;

use std::f64::consts::FRAC_PI_2;

use proveout_geom::{Point, ToolPose, Vector};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{
    Curve, CurveKind, CuttingRun, Figure, Method, Quantity, RescheduleError, Rescheduled, Study, Surroundings,
    meeting::newly_met, slerp,
};

use self::keys::{KeyPlace, KeySearch};
pub use self::spline::true_minimum;

/// Part of the largest second derivative of the profile below which it counts as straight.
const STRAIGHT: f64 = 1e-3;
/// Shortest row, blocks.
const SHORTEST: usize = 5;
/// Shorter ways from block to block are none, mm.
const SHORTEST_MM: f64 = 1e-9;
/// Turns below this are none, radian.
const NO_TURN: f64 = 1e-12;
/// Cosine below which two key axes count as opposite: no great circle is between them.
const OPPOSITE: f64 = -1.0 + 1e-9;

/// What the axes between keys are the least of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// The sum of the paper between two keys each, with windows at the keys.
    Paper,
    /// That sum over the whole row.
    TrueMinimum,
}

impl Criterion {
    /// Every criterion with its name.
    pub const NAMES: [(&'static str, Self); 2] = [("paper", Self::Paper), ("true-minimum", Self::TrueMinimum)];
}

/// Parameters of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinAngularAcceleration {
    /// Largest lean of a key axis from the table's axis, radian.
    pub cap: f64,
    /// Half of the window at a key, mm; zero for none. The true minimum has none.
    pub window: f64,
    /// What the axes between keys are the least of.
    pub criterion: Criterion,
    /// Key axes are looked for in the free cells of their contacts; else they are the program's.
    pub search: bool,
}

impl Default for MinAngularAcceleration {
    fn default() -> Self {
        Self { cap: 47.0_f64.to_radians(), window: 6.0, criterion: Criterion::Paper, search: false }
    }
}

/// Blocks at which the profile of a row changes between convex and concave: the one nearest to the change.
pub fn inflections(points: &[Point], up: &Vector) -> Vec<usize> {
    let n = points.len();
    if n < 3 {
        return Vec::new();
    }
    let height: Vec<f64> = points.iter().map(|p| p.coords.dot(up)).collect();
    let level = |i: usize| {
        let way = points[i] - points[i - 1];
        (way - up * way.dot(up)).norm()
    };
    // Equation (27), corrected for unequal steps: zero on a straight line.
    let bend: Vec<f64> = (1..n - 1)
        .map(|i| {
            let (a, b) = (level(i), level(i + 1));
            if a < SHORTEST_MM || b < SHORTEST_MM {
                return 0.0;
            }
            2.0 * ((height[i + 1] - height[i]) / b - (height[i] - height[i - 1]) / a) / (a + b)
        })
        .collect();
    let band = STRAIGHT * bend.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
    let mut cuts = Vec::new();
    let mut last: Option<usize> = None;
    for (i, b) in bend.iter().enumerate().filter(|(_, b)| b.abs() > band) {
        if let Some(k) = last.filter(|&k| bend[k] * b < 0.0) {
            // Where the straight line between both is zero.
            let part = bend[k].abs() / (bend[k].abs() + b.abs());
            cuts.push(1 + k + ((i - k) as f64 * part).round() as usize);
        }
        last = Some(i);
    }
    cuts
}

/// Axes at arc lengths from key axes at some of them, rising, the first and the last of all among them.
pub fn between_keys(arc: &[f64], keys: &[(usize, Vector)], window: f64) -> Vec<Vector> {
    let Some(first) = keys.first() else { return Vec::new() };
    let mut axes = vec![first.1; arc.len()];
    for pair in keys.windows(2) {
        let (e, f) = (pair[0].0, pair[1].0);
        for (axis, s) in axes[e..=f].iter_mut().zip(&arc[e..=f]) {
            *axis = slerp(&pair[0].1, &pair[1].1, (s - arc[e]) / (arc[f] - arc[e]));
        }
    }
    for k in 1..keys.len() - 1 {
        let (key, at) = (keys[k].1, arc[keys[k].0]);
        let [before, behind] = [at - arc[keys[k - 1].0], arc[keys[k + 1].0] - at];
        // Two windows share the way between their keys; at an end of the row there is no other
        // window.
        let room = |way: f64, end: bool| if end { way } else { 0.5 * way };
        let half = window.min(room(before, k == 1)).min(room(behind, k + 2 == keys.len()));
        if half <= 0.0 {
            continue;
        }
        // Turns for a mm of way in the plane that touches the sphere at the key: from the one before, and to
        // the next.
        let [came, goes] = [touching(&key, &keys[k - 1].1) / -before, touching(&key, &keys[k + 1].1) / behind];
        let (from, to) = (came * -half, goes * half);
        for (axis, s) in axes.iter_mut().zip(arc).filter(|(_, s)| (*s - at).abs() < half) {
            let t = (s - at + half) / (2.0 * half);
            let (r, span) = (1.0 - t, 2.0 * half);
            let turned = from * (r * r * (1.0 + 2.0 * t)) + to * (t * t * (3.0 - 2.0 * t)) + came * (span * t * r * r)
                - goes * (span * t * t * r);
            *axis = turned_by(&key, &turned);
        }
    }
    axes
}

/// From an axis to another as a vector across it: direction of the great circle, length its angle.
fn touching(from: &Vector, to: &Vector) -> Vector {
    let across = to - from * to.dot(from);
    let sine = across.norm();
    if sine < NO_TURN { Vector::zeros() } else { across * (sine.atan2(to.dot(from)) / sine) }
}

fn turned_by(from: &Vector, by: &Vector) -> Vector {
    let angle = by.norm();
    if angle < NO_TURN { *from } else { from * angle.cos() + by * (angle.sin() / angle) }
}

/// The axis turned towards `up` until its lean is no more than the cap.
pub fn capped(axis: &Vector, up: &Vector, cap: f64) -> Vector {
    let lean = axis.cross(up).norm().atan2(axis.dot(up));
    if lean <= cap { *axis } else { slerp(up, axis, cap / lean) }
}

impl MinAngularAcceleration {
    fn check(&self) -> Result<(), RescheduleError> {
        if self.cap > 0.0 && self.cap < FRAC_PI_2 && self.window >= 0.0 && self.window.is_finite() {
            return Ok(());
        }
        Err(RescheduleError::new(
            "reschedule-option",
            0,
            format!("a cap of {} degrees and windows of {} mm", self.cap.to_degrees(), self.window),
            "give a cap above 0 and below 90 degrees, and windows of at least zero",
        ))
    }
}

impl MinAngularAcceleration {
    /// Looks for the axes of the keys between both ends.
    fn find_keys(
        &self,
        keys: &mut [(usize, Vector)],
        run: &CuttingRun,
        centers: &[Point],
        arc: &[f64],
        around: &Surroundings<'_>,
    ) -> Result<(), RescheduleError> {
        let (Some(first), Some(last)) = (keys.first().copied(), keys.last().copied()) else { return Ok(()) };
        let line = |k: usize| keys.get(k).and_then(|(i, _)| run.blocks.get(*i)).map_or(0, |b| b.line);
        if keys.len() < 3 {
            return Ok(());
        }
        let Some(region) = around.region else {
            let message = "what the tool must keep away from is not known, so no key can be searched for";
            let help = "give the scene a part or fixtures, or take the program's own axes as keys (key_axes=program)";
            return Err(RescheduleError::new("reschedule-channel", line(1), message, help));
        };
        let place = |(i, _): &(usize, Vector)| KeyPlace {
            center: centers[*i],
            normal: around.surface.and_then(|s| s.contact(&centers[*i])).map(|c| c.normal),
        };
        let places: Vec<KeyPlace> = keys[1..keys.len() - 1].iter().map(place).collect();
        let ways: Vec<f64> = keys.windows(2).map(|k| arc[k[1].0] - arc[k[0].0]).collect();
        let search = KeySearch { region, up: around.table_axis, cap: self.cap };
        match search.keys([first.1, last.1], &places, &ways) {
            None => {
                let message = "the free axes of this tool cannot be computed, so no key can be searched for";
                let help = "take a ball end mill, or the program's own axes as keys (key_axes=program)";
                Err(RescheduleError::new("reschedule-tool", line(1), message, help))
            }
            Some(Err(k)) => {
                let message = format!(
                    "no axis that leans by at most {:.1} degrees from the table's axis is free at this key",
                    self.cap.to_degrees()
                );
                let help = "set a larger max_key_lean_deg, or take a slimmer or longer tool";
                Err(RescheduleError::new("reschedule-channel", line(k + 1), message, help))
            }
            Some(Ok(found)) => {
                keys[1..].iter_mut().zip(found).for_each(|(key, axis)| key.1 = axis);
                Ok(())
            }
        }
    }
}

impl Method for MinAngularAcceleration {
    fn name(&self) -> &'static str {
        "min-angular-acceleration"
    }

    fn source(&self) -> &'static str {
        "Ma et al. 2020, doi:10.1007/s00170-020-05171-7"
    }

    fn needs_region(&self) -> bool {
        true
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        self.check()?;
        let first = run.blocks.first().map_or(0, |b| b.line);
        let Some(radius) = around.cutter.ball_radius() else {
            let help = "this method keeps ball centers; use a ball end mill, or another method";
            return Err(RescheduleError::new("reschedule-tool", first, "the tool is not a ball end mill", help));
        };
        let n = run.blocks.len();
        if n < SHORTEST {
            let message = format!("the row has only {n} blocks");
            return Err(RescheduleError::new("reschedule-layers", first, message, "give a row of five blocks or more"));
        }
        let up = around.table_axis;
        let centers: Vec<Point> = run.blocks.iter().map(|b| b.pose.tip + b.pose.axis * radius).collect();
        let contact = |center: &Point| match around.surface {
            Some(surface) => surface.contact(center).map(|c| c.point),
            None => Some(*center),
        };
        let mut row = Vec::with_capacity(n);
        for (block, center) in run.blocks.iter().zip(&centers) {
            let Some(point) = contact(center) else {
                let message = "the surface of the part does not reach to this block";
                let help = "re-schedule rows on the surface that the scene describes";
                return Err(RescheduleError::new("reschedule-path", block.line, message, help));
            };
            row.push(point);
        }
        let mut arc = vec![0.0; n];
        for i in 1..n {
            let step = (row[i] - row[i - 1]).norm();
            if step < SHORTEST_MM {
                let message = "two blocks follow each other with the tool at the same place";
                return Err(RescheduleError::new("reschedule-path", run.blocks[i].line, message, "remove one of them"));
            }
            arc[i] = arc[i - 1] + step;
        }
        let cuts = inflections(&row, &up);
        let mut at: Vec<usize> = [0].into_iter().chain(cuts.iter().copied()).chain([n - 1]).collect();
        at.dedup();
        let mut keys: Vec<(usize, Vector)> =
            at.iter().map(|&i| (i, capped(&run.blocks[i].pose.axis, &up, self.cap))).collect();
        if self.search {
            self.find_keys(&mut keys, run, &centers, &arc, around)?;
        }
        if let Some(pair) = keys.windows(2).find(|p| p[0].1.dot(&p[1].1) < OPPOSITE) {
            let line = run.blocks[pair[1].0].line;
            let message = "two key axes are opposite to each other: no great circle is between them";
            return Err(RescheduleError::new("reschedule-path", line, message, "set a smaller cap"));
        }
        let axes = match self.criterion {
            Criterion::Paper => between_keys(&arc, &keys, self.window),
            Criterion::TrueMinimum => true_minimum(&arc, &keys, between_keys(&arc, &keys, 0.0)).0,
        };
        let poses: Vec<ToolPose> =
            centers.iter().zip(&axes).map(|(c, axis)| ToolPose { tip: c - axis * radius, axis: *axis }).collect();
        if let Some(region) = around.region {
            for (block, pose) in run.blocks.iter().zip(&poses) {
                if let Some(deep) = newly_met(region, pose, &block.pose) {
                    let message = format!("the new axis makes shank or holder collide: {deep} along the tool axis");
                    let help = "set another cap, or give the tool a slimmer shank and holder";
                    return Err(RescheduleError::new("reschedule-channel", block.line, message, help));
                }
            }
        }
        let study = study(run, &arc, &axes, &keys, &up);
        Ok(Rescheduled { stretch: 0..n, poses, rotary: None, channel: None, study })
    }
}

fn study(run: &CuttingRun, arc: &[f64], axes: &[Vector], keys: &[(usize, Vector)], up: &Vector) -> Study {
    let lean = |axis: &Vector| axis.cross(up).norm().atan2(axis.dot(up)).to_degrees();
    let curve = |name, kind, points: Vec<[f64; 2]>| Curve {
        name,
        kind,
        axes: [
            Quantity { name: "path length", unit: "mm" },
            Quantity { name: "lean of the tool axis from the table's axis", unit: "deg" },
        ],
        points,
    };
    let over = |axes: &mut dyn Iterator<Item = &Vector>| arc.iter().zip(axes).map(|(s, a)| [*s, lean(a)]).collect();
    // Largest change of the turn of the axis for a mm of way.
    let change = |axes: &[Vector]| {
        let turn = |i: usize| touching(&axes[i], &axes[i + 1]).norm() / (arc[i + 1] - arc[i]);
        (1..axes.len() - 1)
            .map(|i| 2.0 * (turn(i) - turn(i - 1)).abs() / (arc[i + 1] - arc[i - 1]))
            .fold(0.0, f64::max)
            .to_degrees()
    };
    // The paper's sum (28), the turn for a mm of way as a vector.
    let squares = |axes: &[Vector]| {
        let weight: Vec<f64> = arc.windows(2).map(|s| 1.0 / (s[1] - s[0])).collect();
        (1..axes.len() - 1)
            .map(|i| touching(&axes[i], &axes[i + 1]) * weight[i] + touching(&axes[i], &axes[i - 1]) * weight[i - 1])
            .map(|change| change.norm_squared())
            .sum::<f64>()
            * 1_f64.to_degrees().powi(2)
    };
    let before: Vec<Vector> = run.blocks.iter().map(|b| b.pose.axis).collect();
    let figure = |name, unit, value| Figure { name, unit, value };
    Study {
        curves: vec![
            curve("original", CurveKind::Original, over(&mut before.iter())),
            curve("new", CurveKind::Result, over(&mut axes.iter())),
            curve("key axes", CurveKind::KeyPoints, keys.iter().map(|(i, a)| [arc[*i], lean(a)]).collect()),
        ],
        figures: vec![
            figure("key axes", "", keys.len() as f64),
            figure("largest change of turning before", "deg/mm2", change(&before)),
            figure("largest change of turning", "deg/mm2", change(axes)),
            figure("sum of squared changes of turning before", "deg2/mm2", squares(&before)),
            figure("sum of squared changes of turning", "deg2/mm2", squares(axes)),
        ],
        ..Study::default()
    }
}
