//! Ball centers of a cutting run in the plane across the table axis: arc length, chord angles, altered
//! points, layers.
//!
//! ```text
//!        f_i  outgoing chord           The positive sense of angles is the one in which the path turns
//!   Q_i o------> o Q_{i+1}             on the whole (a closed convex section turns by +360 degrees a
//!      /  g_i    incoming chord        layer). The basis (u, v) of the plane is chosen so that this
//!     o Q_{i-1}                        sense is from u to v.
//! ```
//!
//! Li et al. 2022 (doi:10.3390/machines10100953), section 3.1 of the specification; equation (1) for the ball
//! centers.

use std::{
    collections::BTreeMap,
    f64::consts::{PI, TAU},
    ops::Range,
};

use proveout_geom::{Point, Vector};

use super::{CuttingRun, RescheduleError, Surroundings};

/// Samples on each side over which a sign of curvature is decided.
const WINDOW: usize = 5;
/// Curvature below which a path counts as straight, rad/mm.
const STRAIGHT: f64 = 1e-5;
/// Part of the path before a base point in which its hollow lies.
const HOLLOW_SHARE: f64 = 0.1;
/// Base points whose chord angles differ by less than this part of a turn are at the same place of the
/// section.
const SAME_PLACE: f64 = 0.1;
/// A turn between two chords above which the path is not smooth, radian.
const SHARP: f64 = 0.6;
/// Blocks at each end in which a sharp turn is the joint with a lead-in or lead-out.
const LEAD_BLOCKS: usize = 20;
/// Rounding of the angle of a chord, radian.
const ROUNDED: f64 = 1e-9;
/// Shorter chords have no direction, mm.
const SHORTEST_MM: f64 = 1e-9;

/// A layer: from one base point to the next, as indices of blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockLayer {
    /// Block of the base point where it begins; the first block of the path for the first layer.
    pub first: usize,
    /// Block of the base point where it ends; the last block of the path for the last layer.
    pub last: usize,
    /// It begins at a base point.
    pub starts_at_base: bool,
    /// It ends at a base point.
    pub ends_at_base: bool,
}

/// Ball centers of a run with what the S-theta plane needs.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionPath {
    /// Ball centers, mm, without lead-in and lead-out.
    pub centers: Vec<Point>,
    /// Arc length from the first center, mm.
    pub arc: Vec<f64>,
    /// Unwrapped angle of the incoming chord, radian; for the first block that of the outgoing one.
    pub incoming: Vec<f64>,
    /// Unwrapped angle of the outgoing chord, radian; for the last block that of the incoming one.
    pub outgoing: Vec<f64>,
    /// Angle of the tool axis in the plane, radian, within half a turn of the outward normal of the path.
    pub axis_angle: Vec<f64>,
    /// Sine of the inclination of the tool axis towards the table axis.
    pub axial: Vec<f64>,
    /// Arc length of a layer, mm.
    pub period: f64,
    /// The layers.
    pub layers: Vec<BlockLayer>,
    /// Blocks before the first center of this path: the lead-in.
    pub lead_in: usize,
    /// Lines of the blocks.
    pub lines: Vec<u32>,
    /// Plane: first axis, second axis, table axis.
    pub basis: [Vector; 3],
    /// Radius of the ball, mm.
    pub ball_radius: f64,
}

/// Angle nearest to another one.
fn near(angle: f64, to: f64) -> f64 {
    angle - TAU * ((angle - to) / TAU).round()
}

impl SectionPath {
    /// Ball centers, chord angles and layers of a run.
    ///
    /// # Errors
    /// The tool is not a ball; the path has fewer than two blocks, repeated points, sharp corners, or no
    /// whole layer.
    pub fn new(run: &CuttingRun, around: &Surroundings<'_>) -> Result<Self, RescheduleError> {
        let first_line = run.blocks.first().map_or(0, |b| b.line);
        let Some(ball_radius) = around.cutter.ball_radius() else {
            return Err(RescheduleError::new(
                "reschedule-tool",
                first_line,
                "the tool is not a ball end mill",
                "this method keeps ball centers; use a ball end mill, or another method",
            ));
        };
        let axis = around.table_axis;
        let centers: Vec<Point> = run.blocks.iter().map(|b| b.pose.tip + b.pose.axis * ball_radius).collect();
        if centers.iter().any(|p| !p.coords.iter().all(|v| v.is_finite())) || !(0.99..1.01).contains(&axis.norm()) {
            let message = "a pose or the table axis is not a number";
            return Err(RescheduleError::new("reschedule-path", first_line, message, "repair the program"));
        }
        let [u, v] = plane(&axis);
        let flat = |p: &Point| [p.coords.dot(&u), p.coords.dot(&v)];
        let (from, to) = without_leads(&centers.iter().map(flat).collect::<Vec<_>>());
        let kept = &run.blocks[from..to];
        let centers = centers[from..to].to_vec();
        let lines: Vec<u32> = kept.iter().map(|b| b.line).collect();
        let angles = chord_angles(&centers.iter().map(flat).collect::<Vec<_>>(), &lines)?;
        // The sense in which the path turns on the whole is the positive one.
        let turned = angles.last().copied().unwrap_or_default() - angles.first().copied().unwrap_or_default();
        let sense = if turned < 0.0 { -1.0 } else { 1.0 };
        let angles: Vec<f64> = angles.iter().map(|a| a * sense).collect();
        let basis = [u, v * sense, axis];
        let n = centers.len();
        let incoming: Vec<f64> = (0..n).map(|i| angles[i.max(1) - 1]).collect();
        let outgoing: Vec<f64> = (0..n).map(|i| angles[i.min(n - 2)]).collect();
        let mut arc = Vec::with_capacity(n);
        let mut sum = 0.0;
        for i in 0..n {
            if i > 0 {
                sum += (centers[i] - centers[i - 1]).norm();
            }
            arc.push(sum);
        }
        let axis_angle = (0..n)
            .map(|i| {
                let t = &kept[i].pose.axis;
                let angle = t.dot(&basis[1]).atan2(t.dot(&basis[0]));
                near(angle, 0.5 * (incoming[i] + outgoing[i]) - 0.5 * PI)
            })
            .collect();
        let axial = kept.iter().map(|b| b.pose.axis.dot(&axis).clamp(-1.0, 1.0)).collect();
        let mut path = Self {
            centers,
            arc,
            incoming,
            outgoing,
            axis_angle,
            axial,
            period: 0.0,
            layers: Vec::new(),
            lead_in: from,
            lines,
            basis,
            ball_radius,
        };
        path.find_layers()?;
        Ok(path)
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// There is no block.
    pub fn is_empty(&self) -> bool {
        self.centers.is_empty()
    }

    /// Mean curvature in the plane over a window about block i, rad/mm.
    fn bend(&self, i: usize) -> f64 {
        let last = self.len() - 1;
        let (a, b) = (i.saturating_sub(WINDOW), (i + WINDOW).min(last));
        let middle = |i: usize, j: usize| 0.5 * (self.arc[i] + self.arc[j]);
        let span = middle(b, (b + 1).min(last)) - middle(a.saturating_sub(1), a);
        if span > 0.0 { (self.outgoing[b] - self.incoming[a]) / span } else { 0.0 }
    }

    /// Altered points from concave to convex, where a layer begins: the smallest chord angle near the change
    /// of sign.
    fn base_points(&self) -> Vec<usize> {
        let last = self.len() - 1;
        let mut bases = Vec::new();
        let mut concave = false;
        for i in 0..self.len() {
            let bend = self.bend(i);
            if bend < -STRAIGHT {
                concave = true;
            } else if bend > STRAIGHT && concave {
                concave = false;
                let near = i.saturating_sub(2 * WINDOW)..=(i + 2 * WINDOW).min(last);
                let lowest = near.min_by(|&a, &b| self.outgoing[a].total_cmp(&self.outgoing[b])).unwrap_or(i);
                if lowest > 0 && lowest < last {
                    bases.push(lowest);
                }
            }
        }
        bases
    }

    /// Blocks at which the path has turned by whole turns since its first block: layers of a section without
    /// altered points.
    fn turns(&self) -> Vec<usize> {
        let start = self.outgoing[0];
        let mut turns = Vec::new();
        for (i, angle) in self.outgoing.iter().enumerate() {
            if *angle >= start + TAU * turns.len() as f64 - ROUNDED {
                turns.push(i);
            }
        }
        turns
    }

    /// Of base points of a section that is concave in several places of a turn, those at one of
    /// these places: the one after the deepest hollow. Its chord angle comes again a whole turn
    /// later.
    fn one_a_turn(&self, bases: Vec<usize>) -> Vec<usize> {
        // How far the path turns back on its way to a base point.
        let hollow = |base: usize| {
            let from = self.arc.partition_point(|s| *s < self.arc[base] - HOLLOW_SHARE * self.arc[self.len() - 1]);
            let highest = self.outgoing[from..=base].iter().copied().fold(f64::MIN, f64::max);
            highest - self.outgoing[base]
        };
        let Some(main) = bases.iter().copied().max_by(|a, b| hollow(*a).total_cmp(&hollow(*b))) else { return bases };
        let angle = self.outgoing[main];
        let mut kept: BTreeMap<i64, (f64, usize)> = BTreeMap::new();
        for base in bases {
            let turns = (self.outgoing[base] - angle) / TAU;
            let off = (turns - turns.round()).abs();
            let nearest = kept.entry(turns.round() as i64).or_insert((off, base));
            if off < nearest.0 {
                *nearest = (off, base);
            }
        }
        kept.into_values().filter(|(off, _)| *off < SAME_PLACE).map(|(_, base)| base).collect()
    }

    fn find_layers(&mut self) -> Result<(), RescheduleError> {
        let turned = self.outgoing[self.len() - 1] - self.outgoing[0];
        if turned < TAU - 0.1 {
            return Err(RescheduleError::new(
                "reschedule-layers",
                self.lines[0],
                format!(
                    "the path turns by {:.1} degrees in the plane across the table axis and has no whole layer",
                    turned.to_degrees()
                ),
                "a layer is one turn about the blade; give a path of one turn or more",
            ));
        }
        let concave = (0..self.len()).any(|i| self.bend(i) < -STRAIGHT);
        let mut bases = self.base_points();
        if !concave {
            bases = self.turns();
        } else if bases.len() as f64 > turned / TAU + 1.0 {
            bases = self.one_a_turn(bases);
        }
        self.period = match (bases.first(), bases.last()) {
            (Some(&a), Some(&b)) if b > a => {
                let turns = ((self.outgoing[b] - self.outgoing[a]) / TAU).round().max(1.0);
                (self.arc[b] - self.arc[a]) / turns
            }
            _ => {
                let start = self.outgoing[0];
                let end = self.outgoing.iter().position(|a| *a >= start + TAU - 0.1).unwrap_or(self.len() - 1);
                self.arc[end]
            }
        };
        bases.retain(|&b| b > 0 && b < self.len() - 1);
        let mut marks = vec![0];
        marks.extend(bases);
        marks.push(self.len() - 1);
        marks.dedup();
        let count = marks.len() - 1;
        self.layers = (0..count)
            .map(|k| BlockLayer {
                first: marks[k],
                last: marks[k + 1],
                starts_at_base: k > 0,
                ends_at_base: k + 1 < count,
            })
            .collect();
        Ok(())
    }

    /// The blocks of the run that this path holds.
    pub fn stretch(&self) -> Range<usize> {
        self.lead_in..self.lead_in + self.len()
    }

    /// Unit vector of the plane at an angle, with the inclination of block i kept.
    pub fn axis_at(&self, i: usize, angle: f64) -> Vector {
        let (s, c) = angle.sin_cos();
        let axial = self.axial[i];
        let across = (1.0 - axial * axial).max(0.0).sqrt();
        self.basis[0] * (across * c) + self.basis[1] * (across * s) + self.basis[2] * axial
    }
}

/// Two unit vectors across an axis: y and z for the X axis.
fn plane(axis: &Vector) -> [Vector; 2] {
    let helper = if axis.y.abs() < 0.9 { Vector::y() } else { Vector::z() };
    let u = (helper - axis * helper.dot(axis)).normalize();
    [u, axis.cross(&u)]
}

/// Turn from one chord to the next.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
    (p[0] * q[1] - p[1] * q[0]).atan2(p[0] * q[0] + p[1] * q[1])
}

/// Range of blocks without lead-in and lead-out: after the last sharp turn near the start, before
/// the first near the end.
fn without_leads(points: &[[f64; 2]]) -> (usize, usize) {
    let n = points.len();
    let sharp = |i: usize| i > 0 && i + 1 < n && turn(points[i - 1], points[i], points[i + 1]).abs() > SHARP;
    let from = (1..n.min(LEAD_BLOCKS)).rev().find(|&i| sharp(i)).unwrap_or(0);
    let to = (n.saturating_sub(LEAD_BLOCKS).max(from + 1)..n).find(|&i| sharp(i)).map_or(n, |i| i + 1);
    (from, to)
}

/// Unwrapped angles of the chords.
fn chord_angles(points: &[[f64; 2]], lines: &[u32]) -> Result<Vec<f64>, RescheduleError> {
    let mut angles: Vec<f64> = Vec::with_capacity(points.len());
    for i in 1..points.len() {
        let chord = [points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]];
        if chord[0].hypot(chord[1]) < SHORTEST_MM {
            return Err(RescheduleError::new(
                "reschedule-path",
                lines[i],
                "two blocks follow each other with the ball at the same place in the section",
                "remove one of the two blocks",
            ));
        }
        let angle = chord[1].atan2(chord[0]);
        let angle = angles.last().map_or(angle, |&last| near(angle, last));
        if let Some(&last) = angles.last()
            && (angle - last).abs() > SHARP
        {
            return Err(RescheduleError::new(
                "reschedule-path",
                lines[i],
                format!("the path of the ball center turns by {:.0} degrees in one block", (angle - last).to_degrees()),
                "re-schedule smooth paths; put lead-ins and links into rapid blocks, or write shorter blocks",
            ));
        }
        angles.push(angle);
    }
    if angles.len() < 3 {
        let line = lines.first().copied().unwrap_or_default();
        let message = format!("the path has only {} blocks", points.len());
        return Err(RescheduleError::new("reschedule-layers", line, message, "give a path of one turn or more"));
    }
    Ok(angles)
}
