//! Contacts along a line: the step from the chord error, the tool axis from its rule, the cutter location
//! from the contact.
//!
//! A control leads the tip straight and the axis on a great circle from one contact to the next.
//! The error at a contact between them is the signed distance of the cutter, in its pose there,
//! from the tangent plane of the surface: exact for any convex cutter ([`PathCutter::gap`]), of
//! second order in the step, and negative where it is a gouge. The distance of the contact from the
//! chord of the contacts is computed as well. Both stay within the chord error.
//!
//! The step comes from the circle: an arc of radius rho leaves its chord by e where the chord is
//! `2 sqrt(2 rho e - e^2)` (Lu et al. 2022, section 4), and a curve that is bent by `1/rho` at most
//! leaves it by no more (Schur 1921). rho is the radius of the path of the contacts, or of the path
//! of the cutter where that is sharper: over a convex section of curvature k the center of a cutter
//! of radius R moves by the factor 1 + k R faster, so that its chord cuts deeper by this factor.
//! The step is then measured at its middle and its quarters, and halved where the error is too
//! large.

use proveout_blade::ParametricSurface;
use proveout_geom::ToolPose;

use super::{
    AxisRule, CutterTouch, FlankError, Line, PathCutter, PathError,
    cutter::{envelope_across, overlap},
    error::MOST_POINTS,
    place::PathPoint,
};

/// How far apart contacts lie along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepRule {
    /// As far as the chord error allows.
    Chord {
        /// Largest distance between the surface and what the straight motion leaves, mm.
        error: f64,
        /// Longest step, mm.
        longest: f64,
    },
    /// Equal parts of the line's length, no longer than this, mm.
    Length(f64),
}

/// A contact of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathContact {
    /// Where.
    pub place: PathPoint,
    /// Pose of the cutter and its contact.
    pub touch: CutterTouch,
    /// Length of the line up to here, mm.
    pub length: f64,
    /// Largest error of the straight motion that ends here, mm; 0 for the first contact.
    pub chord_error: f64,
    /// Distance to the next line, mm, where there is one.
    pub side_step: Option<f64>,
    /// Scallop to the next line as computed, mm.
    pub scallop: Option<f64>,
    /// What the flank does along its ruling, where one lies along it.
    pub flank: Option<FlankError>,
}

impl PathContact {
    /// Curvature across the feed of the surface that the cutter leaves, 1/mm.
    pub fn envelope(&self) -> Option<f64> {
        envelope_across(&self.touch.form, &self.place.form)
    }
}

/// The contacts of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct LineContacts {
    /// Name of the line.
    pub name: String,
    /// Material left on the surface, mm.
    pub allowance: f64,
    /// The cutter comes from the line before without a retract.
    pub joined: bool,
    /// In the order of travel.
    pub contacts: Vec<PathContact>,
}

/// What makes contacts of lines.
#[derive(Clone, Copy, Debug)]
pub struct Sampler<'a> {
    /// The surface.
    pub surface: &'a dyn ParametricSurface,
    /// The cutter.
    pub cutter: &'a PathCutter,
    /// The axis.
    pub rule: &'a AxisRule,
    /// The step.
    pub step: StepRule,
}

/// Shortest step, mm: a line that needs shorter ones has a corner, which no step resolves.
const SHORTEST: f64 = 1e-6;
/// Part of the chord error that a step is planned for: the rest covers what its curvature does between the
/// places where it is looked at.
const PLANNED: f64 = 0.9;
/// Pieces of the length table of a line.
const PIECES: usize = 256;
/// Smallest chord error that can be asked for, mm.
const CHORD_ERROR_MM: f64 = 1e-6;
/// Range of the longest step, mm.
const LONGEST_MM: [f64; 2] = [1e-3, 1e3];
/// Range of equal steps, mm.
const EQUAL_MM: [f64; 2] = [1e-4, 1e3];
/// Rounding of the height of the cutter's top, mm.
const ROUNDING_MM: f64 = 1e-9;
/// Least way for each unit of t, mm: a step stays finite.
const SLOWEST: f64 = 1e-12;
/// Curvature times chord error below which a line is straight.
const STRAIGHT: f64 = 1e-15;
/// A count of steps that is above a whole number by no more than this is that number: rounding.
pub(super) const WHOLE: f64 = 1e-9;
/// Error of the place at a length at which its search ends, part of the line.
const AT_LENGTH: f64 = 1e-12;

impl Sampler<'_> {
    /// Checks the numbers.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn check(&self) -> Result<(), PathError> {
        self.rule.check()?;
        match self.step {
            StepRule::Chord { error, longest } => {
                PathError::within("the chord error in mm", error, CHORD_ERROR_MM, 1.0)?;
                PathError::within("the longest step in mm", longest, LONGEST_MM[0], LONGEST_MM[1])?;
            }
            StepRule::Length(step) => {
                PathError::within("the step in mm", step, EQUAL_MM[0], EQUAL_MM[1])?;
            }
        }
        Ok(())
    }

    /// The contacts of a line in its direction. Scallops are not filled in.
    ///
    /// # Errors
    /// The cutter does not fit, or the rule gives no axis, at a named place.
    pub fn line(&self, line: &Line) -> Result<LineContacts, PathError> {
        let ruler = match (self.step, self.rule) {
            (StepRule::Chord { .. }, rule) if !matches!(rule, AxisRule::Interpolated(_)) => None,
            _ => Some(Ruler::new(self.surface, line)),
        };
        let contacts = match (self.step, &ruler) {
            (StepRule::Length(step), Some(ruler)) => self.equal_steps(line, ruler, step)?,
            (StepRule::Chord { error, longest }, _) => self.chord_steps(line, ruler.as_ref(), error, longest)?,
            (StepRule::Length(_), None) => Vec::new(),
        };
        Ok(LineContacts { name: line.name.clone(), allowance: line.allowance, joined: line.joined, contacts })
    }

    /// The cutter at t of a line; `before` is the contact before.
    fn touch(
        &self,
        line: &Line,
        place: &PathPoint,
        part: f64,
        before: Option<&CutterTouch>,
    ) -> Result<CutterTouch, PathError> {
        if let AxisRule::Ruling { points } = self.rule {
            let Some(ruling) = &line.ruling else {
                let what = "an axis along the ruling belongs to the flank of a cutter".to_owned();
                return Err(PathError::NoLine { what, section: self.at(place).section });
            };
            return ruling.touch(self.surface, self.cutter, *points, place, line.allowance);
        }
        let axis = self.rule.axis(place, part).ok_or_else(|| PathError::NoAxis { at: self.at(place) })?;
        Ok(self.cutter.touch(place, &axis, line.allowance, before.map(|b| b.radial)))
    }

    fn at(&self, place: &PathPoint) -> super::BladeLocation {
        place.named(&self.surface.domain())
    }

    /// What must hold at every contact; the error of a flank.
    fn judge(&self, line: &Line, place: &PathPoint, touch: &CutterTouch) -> Result<Option<FlankError>, PathError> {
        if let Some(ruling) = &line.ruling {
            let error = ruling.error(self.surface, self.cutter, &touch.pose, place.uv, line.allowance);
            let FlankError { gouge, left, twist } = error;
            if gouge.max(left) > ruling.limit {
                return Err(PathError::Flank {
                    at: self.at(place),
                    gouge_mm: gouge,
                    left_mm: left,
                    limit_mm: ruling.limit,
                    twist_deg: twist.to_degrees(),
                });
            }
            return Ok(Some(error));
        }
        if let Some([cutter, hollow]) = overlap(&touch.form, &place.form) {
            return Err(PathError::CutterTooLarge { at: self.at(place), cutter_1_mm: cutter, surface_1_mm: hollow });
        }
        if touch.on_profile[1] >= self.cutter.profile().z_max() - ROUNDING_MM {
            let angle = place.normal.dot(&touch.pose.axis).clamp(-1.0, 1.0).acos();
            return Err(PathError::AxisBelowSurface { at: self.at(place), angle_deg: angle.to_degrees() });
        }
        Ok(None)
    }

    /// Error of the straight motion between two poses at a place between them, mm.
    fn error_at(&self, line: &Line, ends: [(&PathPoint, &ToolPose); 2], between: &PathPoint) -> f64 {
        let [(from, from_pose), (to, to_pose)] = ends;
        let chord = to.point - from.point;
        let length2 = chord.norm_squared();
        let way = between.point - from.point;
        let part = if length2 > 0.0 { (way.dot(&chord) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let pose = from_pose.interpolated(to_pose, part);
        if let (Some(ruling), AxisRule::Ruling { points }) = (&line.ruling, self.rule) {
            let there = ruling.touch(self.surface, self.cutter, *points, between, line.allowance);
            return there.map_or(f64::INFINITY, |t| {
                ruling.moved(self.surface, self.cutter, [&pose, &t.pose], between.uv, line.allowance)
            });
        }
        let contact = between.point + between.normal * line.allowance;
        self.cutter.gap(&pose, &contact, &between.normal).abs().max((way - chord * part).norm())
    }

    fn chord_steps(
        &self,
        line: &Line,
        ruler: Option<&Ruler>,
        error: f64,
        longest: f64,
    ) -> Result<Vec<PathContact>, PathError> {
        let [start, end] = line.curve.range();
        let part = |t: f64| ruler.map_or(0.0, |r| r.part(self.surface, line, t));
        let place = PathPoint::on(self.surface, &line.curve, start);
        let touch = self.touch(line, &place, part(start), None)?;
        let flank = self.judge(line, &place, &touch)?;
        let first = PathContact { place, touch, length: 0.0, chord_error: 0.0, side_step: None, scallop: None, flank };
        let mut contacts = vec![first];
        let mut from = first;
        let mut guess = f64::INFINITY;
        while from.place.t < end {
            let rest = end - from.place.t;
            let allowed = self.allowed(&from, PLANNED * error)?.min(longest);
            let mut dt = (allowed / from.place.speed.max(SLOWEST)).min(guess).min(rest);
            // A last step that is a sliver is shared with the one before it.
            if dt < rest && dt > 0.5 * rest {
                dt = 0.5 * rest;
            }
            let mut next = loop {
                let t = if dt >= rest { end } else { from.place.t + dt };
                let to = PathPoint::on(self.surface, &line.curve, t);
                let touch = self.touch(line, &to, part(t), Some(&from.touch))?;
                let ends = [(&from.place, &from.touch.pose), (&to, &touch.pose)];
                let middle = PathPoint::on(self.surface, &line.curve, 0.5 * (from.place.t + t));
                let mut worst = self.error_at(line, ends, &middle);
                let sharpest = from.place.path_curvature.max(middle.path_curvature).max(to.path_curvature);
                let length = (from.place.speed + 4.0 * middle.speed + to.speed) * (t - from.place.t) / 6.0;
                let by_circle = 0.125 * sharpest * length * length;
                // Where the middle is far below the bound the quarters cannot reach it.
                if worst > 0.5 * error {
                    for quarter in [0.25, 0.75] {
                        let between =
                            PathPoint::on(self.surface, &line.curve, from.place.t + quarter * (t - from.place.t));
                        worst = worst.max(self.error_at(line, ends, &between));
                    }
                }
                if worst <= PLANNED * error && by_circle <= error && length <= 1.001 * longest {
                    guess = 2.0 * dt;
                    break PathContact {
                        place: to,
                        touch,
                        length: from.length + length,
                        chord_error: worst,
                        side_step: None,
                        scallop: None,
                        flank: None,
                    };
                }
                let over = (worst.max(PLANNED * by_circle) / (PLANNED * error)).sqrt().max(length / longest);
                dt *= (0.98 / over).clamp(0.1, 0.9);
                if dt * from.place.speed < SHORTEST {
                    return Err(PathError::NoLine {
                        what: format!("the line {} has a corner at {}", line.name, self.at(&from.place)),
                        section: self.at(&from.place).section,
                    });
                }
            };
            next.flank = self.judge(line, &next.place, &next.touch)?;
            contacts.push(next);
            from = next;
            if contacts.len() > MOST_POINTS {
                return Err(PathError::TooLong);
            }
        }
        Ok(contacts)
    }

    /// The chord that an error allows at a contact, mm.
    fn allowed(&self, at: &PathContact, error: f64) -> Result<f64, PathError> {
        let along = at.place.form[0];
        let cutter = at.touch.form[0];
        let offset = if cutter > 0.0 { along.abs() * (1.0 + along / cutter).max(0.0) } else { along.abs() };
        let curvature = at.place.path_curvature.max(offset);
        if curvature * error <= STRAIGHT {
            return Ok(f64::INFINITY);
        }
        let radius = 1.0 / curvature;
        if error >= radius {
            return Err(PathError::StepLongerThanRadius { at: self.at(&at.place), step_mm: error, radius_mm: radius });
        }
        Ok(2.0 * (2.0 * radius * error - error * error).sqrt())
    }

    fn equal_steps(&self, line: &Line, ruler: &Ruler, step: f64) -> Result<Vec<PathContact>, PathError> {
        let count = (ruler.total() / step - WHOLE).ceil().max(1.0);
        if count > MOST_POINTS as f64 {
            return Err(PathError::TooLong);
        }
        let count = count as usize;
        let mut contacts: Vec<PathContact> = Vec::with_capacity(count + 1);
        for k in 0..=count {
            let length = ruler.total() * k as f64 / count as f64;
            let t = ruler.at_length(self.surface, line, length);
            let place = PathPoint::on(self.surface, &line.curve, t);
            let touch = self.touch(line, &place, k as f64 / count as f64, contacts.last().map(|c| &c.touch))?;
            let flank = self.judge(line, &place, &touch)?;
            let radius = 1.0 / place.path_curvature;
            if ruler.total() / count as f64 > radius {
                let step_mm = ruler.total() / count as f64;
                return Err(PathError::StepLongerThanRadius { at: self.at(&place), step_mm, radius_mm: radius });
            }
            let mut chord_error = 0.0_f64;
            if let Some(from) = contacts.last() {
                for quarter in [0.25, 0.5, 0.75] {
                    let t = from.place.t + quarter * (t - from.place.t);
                    let between = PathPoint::on(self.surface, &line.curve, t);
                    let ends = [(&from.place, &from.touch.pose), (&place, &touch.pose)];
                    chord_error = chord_error.max(self.error_at(line, ends, &between));
                }
            }
            contacts.push(PathContact { place, touch, length, chord_error, side_step: None, scallop: None, flank });
        }
        Ok(contacts)
    }
}

/// Length along a line, by Gauss's rule of five points on equal pieces of t.
#[derive(Clone, Debug)]
pub(crate) struct Ruler {
    start: f64,
    piece: f64,
    lengths: Vec<f64>,
}

/// Nodes and weights of Gauss's rule of five points on -1 to 1.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

fn way(surface: &dyn ParametricSurface, line: &Line, from: f64, to: f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let speed = |t: f64| {
        let at = line.curve.at(t);
        let [su, sv] = surface.local(at.u[0], at.v[0]).first;
        (su * at.u[1] + sv * at.v[1]).norm()
    };
    half * GAUSS.iter().map(|(x, weight)| weight * speed(middle + half * x)).sum::<f64>()
}

impl Ruler {
    pub(crate) fn new(surface: &dyn ParametricSurface, line: &Line) -> Self {
        let [start, end] = line.curve.range();
        let piece = (end - start) / PIECES as f64;
        let mut lengths = vec![0.0];
        let mut sum = 0.0;
        for k in 0..PIECES {
            sum += way(surface, line, start + piece * k as f64, start + piece * (k + 1) as f64);
            lengths.push(sum);
        }
        Self { start, piece, lengths }
    }

    /// mm.
    pub(crate) fn total(&self) -> f64 {
        self.lengths[PIECES]
    }

    fn part(&self, surface: &dyn ParametricSurface, line: &Line, t: f64) -> f64 {
        let k = ((t - self.start) / self.piece).clamp(0.0, (PIECES - 1) as f64) as usize;
        let from = self.start + self.piece * k as f64;
        ((self.lengths[k] + way(surface, line, from, t)) / self.total()).clamp(0.0, 1.0)
    }

    /// t at a length from the start, mm.
    pub(crate) fn at_length(&self, surface: &dyn ParametricSurface, line: &Line, length: f64) -> f64 {
        let k = self.lengths.partition_point(|&l| l <= length).clamp(1, PIECES) - 1;
        let from = self.start + self.piece * k as f64;
        let whole = self.lengths[k + 1] - self.lengths[k];
        let mut t = from + self.piece * if whole > 0.0 { (length - self.lengths[k]) / whole } else { 0.0 };
        for _ in 0..4 {
            let off = self.lengths[k] + way(surface, line, from, t) - length;
            let speed = whole / self.piece;
            if off.abs() <= AT_LENGTH * self.total() || speed <= 0.0 {
                break;
            }
            t -= off / speed;
        }
        t
    }
}
