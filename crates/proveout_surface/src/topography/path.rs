//! The swept surface of a known piece of motion and of those that go on from it.
//!
//! The stock remembers which piece of motion made a point. From there the exact surface between the rays is
//! found without a search over all pieces: the height of the cutter over a line is lowest somewhere on the
//! path near the contact that is known, and is followed from piece to piece while it falls.

use proveout_geom::{Point, ToolPose, Vector};
use proveout_tool::Profile;
use rayon::prelude::*;

use super::{
    CutterPiece, MOST_RADIUS, NOT_ZERO,
    envelope::{NormalLine, descend, touch},
    motion::SweptPiece,
    outline::{CutterBody, CutterOutline},
};

/// Pieces that a contact is followed over.
const MOST_STEPS: usize = 2000;
/// A piece goes on where the other ends when tips and axes differ by less, mm and 1.
const JOINED: f64 = 1e-6;
/// Heights that differ by less are one, mm.
const SAME: f64 = 1e-12;
/// Largest turn of a part of a piece that is searched at once, radian: bends of 0.5 r 0.0009 / 4, below a
/// micrometer at 8 mm from the axis of the turn; and most parts.
const TURN: f64 = 0.03;
const MOST_PARTS: f64 = 256.0;
/// Pieces whose bounds are asked together.
const GROUP: usize = 64;
/// Sine between axes below which a piece does not turn. As the stock: opposite axes have no great circle, the
/// axis stays.
const NO_TURN: f64 = 1e-12;
/// A part with less way and less turn stands, mm and radian.
const STANDS: f64 = 1e-12;

/// A cutter at rest.
#[derive(Debug)]
pub struct StandingCutter {
    piece: SweptPiece,
    body: CutterBody,
}

impl StandingCutter {
    /// A cutter with its tip and its axis (unit vector from tip to holder).
    pub fn new(profile: &Profile, tip: Point, axis: Vector) -> Self {
        let pose = ToolPose { tip, axis };
        Self { piece: piece(0, &pose, &pose), body: CutterBody::Outline(CutterOutline::new(profile)) }
    }

    /// The height along `normal` at which a line through `point` meets it first; none where it passes by.
    pub fn height(&self, point: &Point, normal: &Vector) -> Option<f64> {
        touch(&ray(point, normal), &self.piece, &self.body, 0.0, 0.0).map(|t| t.height)
    }
}

fn ray(point: &Point, normal: &Vector) -> NormalLine {
    NormalLine { point: point.coords, normal: *normal }
}

/// A motion in the form in which it is searched; time runs from 0 to 1.
fn piece(number: u32, from: &ToolPose, to: &ToolPose) -> SweptPiece {
    let z = from.axis;
    let least = if z.x.abs() <= z.y.abs() && z.x.abs() <= z.z.abs() {
        Vector::x()
    } else if z.y.abs() <= z.z.abs() {
        Vector::y()
    } else {
        Vector::z()
    };
    let x = least.cross(&z).normalize();
    let over = z.cross(&to.axis);
    let sine = over.norm();
    let turn = if sine < NO_TURN { Vector::zeros() } else { over * (sine.atan2(z.dot(&to.axis)) / sine) };
    SweptPiece::new(&CutterPiece {
        time: [0.0, 1.0],
        tip: [from.tip, to.tip],
        housing: [x, z.cross(&x), z],
        turn,
        azimuth: 0.0,
        azimuth_rate: 0.0,
        motion: number,
    })
}

/// A piece of motion of a cutter, in the frame of the design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPiece {
    /// Tip and axis at its begin.
    pub from: ToolPose,
    /// At its end: the tip runs straight, the axis on the great circle, both evenly.
    pub to: ToolPose,
    /// Which of the cutters moves; none for a motion that cuts nothing.
    pub cutter: Option<u32>,
}

/// Where a cutter comes lowest over a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathContact {
    /// Height along the line, mm.
    pub height: f64,
    /// Number of the piece.
    pub piece: u32,
    /// Part of the piece that has passed, 0 to 1.
    pub at: f64,
}

/// What a contact looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactDirections {
    /// Outward unit normal of the material that is left: against that of the cutter.
    pub normal: Vector,
    /// Velocity of the cutter's point there over the piece, mm: way of the piece if it went on evenly.
    pub way: Vector,
    /// Unit vector of the cutter's axis.
    pub axis: Vector,
}

/// All motion of a run, by the numbers that the stock remembers, with the cutters.
#[derive(Debug)]
pub struct SweptPath {
    pieces: Vec<PathPiece>,
    /// The convex bodies of each cutter, with the distance of their farthest point from the tip.
    cutters: Vec<(Vec<CutterBody>, f64)>,
    /// Bounds of the tips of each group of pieces: middle, radius, and the farthest reach of a cutter.
    groups: Vec<(Vector, f64)>,
}

impl SweptPath {
    /// A path; `cutters` holds the convex bodies of each cutter.
    pub fn new(pieces: Vec<PathPiece>, cutters: &[Vec<Profile>]) -> Self {
        let reach = |p: &Profile| p.max_radius().hypot(p.z_max().abs().max(p.z_min().abs()));
        let cutters: Vec<(Vec<CutterBody>, f64)> = cutters
            .iter()
            .map(|bodies| {
                let far = bodies.iter().map(reach).fold(0.0, f64::max);
                (bodies.iter().map(|p| CutterBody::Outline(CutterOutline::new(p))).collect(), far)
            })
            .collect();
        let group = |of: &[PathPiece]| {
            let tips = || of.iter().filter(|p| p.cutter.is_some()).flat_map(|p| [p.from.tip.coords, p.to.tip.coords]);
            let low = tips().fold(Vector::repeat(f64::INFINITY), |a, t| a.inf(&t));
            let high = tips().fold(Vector::repeat(f64::NEG_INFINITY), |a, t| a.sup(&t));
            let far = of.iter().filter_map(|p| cutters.get(p.cutter? as usize)).map(|c| c.1).fold(0.0, f64::max);
            ((low + high) * 0.5, if low.x <= high.x { (high - low).norm() * 0.5 + far } else { f64::NEG_INFINITY })
        };
        let groups = pieces.chunks(GROUP).map(group).collect();
        Self { pieces, cutters, groups }
    }

    /// Its pieces.
    pub fn pieces(&self) -> &[PathPiece] {
        &self.pieces
    }

    fn of(&self, number: u32) -> Option<(&PathPiece, &[CutterBody])> {
        let piece = self.pieces.get(number as usize)?;
        let (bodies, _) = self.cutters.get(piece.cutter? as usize)?;
        Some((piece, bodies))
    }

    /// The lowest place of one piece over a line, searched from a height and a part of the piece.
    ///
    /// The height over a line is a convex function of time while the cutter runs straight; a turn by an angle
    /// bends it by reach times angle squared, so that a piece that turns far may have several lowest places.
    /// It is searched in parts that turn by 0.03 radian at most.
    pub fn contact(&self, number: u32, point: &Point, normal: &Vector, near: (f64, f64)) -> Option<PathContact> {
        let (known, bodies) = self.of(number)?;
        let line = ray(point, normal);
        let parts = (known.from.angle_to(&known.to) / TURN).ceil().clamp(1.0, MOST_PARTS);
        let mut best: Option<PathContact> = None;
        let mut from = known.from;
        for k in 0..parts as usize {
            let begin = k as f64 / parts;
            let to = if k + 1 == parts as usize {
                known.to
            } else {
                known.from.interpolated(&known.to, (k + 1) as f64 / parts)
            };
            let moving = piece(number, &from, &to);
            let stands = moving.travel() < STANDS && moving.angle() < STANDS;
            // Within the part where it is thought to be; of the others the middle.
            let at = (near.1 - begin) * parts;
            let guess = (if (0.0..=1.0).contains(&at) { at } else { f64::NAN }, near.0);
            for body in bodies {
                let found = if stands {
                    touch(&line, &moving, body, 0.0, near.0).map(|t| (t.height, 0.0))
                } else {
                    over_part(&line, &moving, body, guess)
                };
                if let Some((height, at)) = found
                    && best.is_none_or(|b| height < b.height)
                {
                    best = Some(PathContact { height, piece: number, at: begin + at / parts });
                }
            }
            from = to;
        }
        best
    }

    /// Whether the cutter goes on from piece `a` to piece `b`, its neighbor.
    fn joined(&self, a: u32, b: u32) -> bool {
        let (Some(p), Some(q)) = (self.pieces.get(a.min(b) as usize), self.pieces.get(a.max(b) as usize)) else {
            return false;
        };
        p.cutter.is_some()
            && p.cutter == q.cutter
            && (p.to.tip - q.from.tip).norm() <= JOINED
            && (p.to.axis - q.from.axis).norm() <= JOINED
    }

    /// A pause of the motion.
    fn is_pause(&self, number: u32) -> bool {
        self.pieces
            .get(number as usize)
            .is_some_and(|p| (p.to.tip - p.from.tip).norm() + (p.to.axis - p.from.axis).norm() < JOINED)
    }

    /// The lowest place over a line on the path that goes on from a contact in both directions, as long as it
    /// falls.
    pub fn follow(&self, from: &PathContact, point: &Point, normal: &Vector) -> Option<PathContact> {
        let mut best = self.contact(from.piece, point, normal, (from.height, from.at));
        let start = best.map_or(from.piece, |b| b.piece);
        for forward in [true, false] {
            let mut here = start;
            let mut own = best.filter(|b| b.piece == start).or(best);
            for _ in 0..MOST_STEPS {
                // Its neighbors are asked even where it is lowest inside: a bend of the path may hide a lower
                // place.
                let next = if forward { here.checked_add(1) } else { here.checked_sub(1) };
                let Some(next) = next.filter(|n| self.joined(here, *n)) else { break };
                let guess = (best.map_or(from.height, |b| b.height), if forward { 0.0 } else { 1.0 });
                let found = self.contact(next, point, normal, guess);
                let falls = match (found, best) {
                    (Some(f), Some(b)) => f.height < b.height - SAME,
                    (found, _) => found.is_some(),
                };
                if falls {
                    best = found;
                } else if own.is_some() && !self.is_pause(next) {
                    break;
                }
                (here, own) = (next, found);
            }
        }
        best
    }

    /// What the cutter does at a contact over a line.
    pub fn touching(&self, contact: &PathContact, point: &Point, normal: &Vector) -> Option<ContactDirections> {
        let (known, bodies) = self.of(contact.piece)?;
        let moving = piece(contact.piece, &known.from, &known.to);
        let line = ray(point, normal);
        let each = bodies.iter().filter_map(|body| touch(&line, &moving, body, contact.at, contact.height));
        let touch = each.min_by(|a, b| a.height.total_cmp(&b.height))?;
        let state = moving.state(contact.at);
        let place = state.point(&(line.point + line.normal * touch.height));
        let rate = moving.rate(&state, &place);
        let way = -(state.frame[0] * rate.x + state.frame[1] * rate.y + state.frame[2] * rate.z);
        Some(ContactDirections { normal: -touch.normal, way, axis: state.frame[2] })
    }

    /// Numbers of the pieces whose cutter may come nearer to a point than `range`, mm.
    pub fn near(&self, point: &Point, range: f64) -> Vec<u32> {
        let far = |k: usize| {
            let (middle, radius) = self.groups[k];
            (point.coords - middle).norm() > radius + range
        };
        let groups: Vec<usize> = (0..self.groups.len()).filter(|k| !far(*k)).collect();
        let of_group = |k: usize| -> Vec<u32> {
            let end = ((k + 1) * GROUP).min(self.pieces.len());
            (k * GROUP..end).map(|n| n as u32).filter(|n| self.comes_near(*n, point, range)).collect()
        };
        groups.into_par_iter().with_min_len(64).flat_map_iter(of_group).collect()
    }

    fn comes_near(&self, number: u32, point: &Point, range: f64) -> bool {
        let Some((known, bodies)) = self.of(number) else { return false };
        // Its pose half way; no point of it moves farther from there than half of its path.
        let half = known.from.interpolated(&known.to, 0.5);
        let q = point - half.tip;
        let z = q.dot(&half.axis);
        let r = (q.norm_squared() - z * z).max(0.0).sqrt();
        let way = 0.5 * ((known.to.tip - known.from.tip).norm() + known.from.angle_to(&known.to) * q.norm());
        bodies.iter().any(|b| b.distance(r, z).0 <= way + range)
    }

    /// The lowest of some pieces over a line; the first of those that are as low.
    pub fn lowest_of(&self, pieces: &[u32], point: &Point, normal: &Vector, height: f64) -> Option<PathContact> {
        let each = pieces.iter().filter_map(|n| self.contact(*n, point, normal, (height, f64::NAN)));
        each.reduce(|a, b| if b.height < a.height { b } else { a })
    }
}

/// The lowest touch of a part of a piece. Without a guess of the time, a straight part starts at the lowest
/// of some touches: where the tip, or the middle of the smallest rounding, passes the line, and at
/// quarters. What is not found is reported as not followed.
fn over_part(line: &NormalLine, moving: &SweptPiece, body: &CutterBody, guess: (f64, f64)) -> Option<(f64, f64)> {
    if moving.turns() {
        return descend(line, moving, body, guess).0;
    }
    if !guess.0.is_nan()
        && let (found, true) = descend(line, moving, body, guess)
    {
        return found;
    }
    let [begin, end] = moving.time;
    let (from, to) = (moving.state(begin), moving.state(end));
    let across = |v: Vector| v - line.normal * line.normal.dot(&v);
    let way = across(to.tip - from.tip);
    let passes = [0.0, body.smallest_radius().min(MOST_RADIUS)].map(|z| {
        let left = across(line.point - (from.tip + from.frame[2] * z));
        left.dot(&way) / way.norm_squared().max(NOT_ZERO)
    });
    let times =
        passes.into_iter().chain([0.0, 0.25, 0.5, 0.75, 1.0]).map(|part| begin + (end - begin) * part.clamp(0.0, 1.0));
    let touches = times.filter_map(|time| Some((touch(line, moving, body, time, guess.1)?.height, time)));
    let mut best = touches.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (found, certain) = descend(line, moving, body, (best.1, best.0));
    if certain {
        return found;
    }
    // Golden sections round the lowest touch (Kiefer 1953), where the height is a convex function of time;
    // wide, then narrow.
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for wide in [0.25, 0.01] {
        let reach = wide * (end - begin);
        let (mut a, mut b) = ((best.1 - reach).max(begin), (best.1 + reach).min(end));
        for _ in 0..40 {
            let times = [b - ratio * (b - a), a + ratio * (b - a)];
            let heights = times.map(|t| touch(line, moving, body, t, best.0).map_or(f64::INFINITY, |t| t.height));
            for (height, time) in heights.into_iter().zip(times) {
                if height < best.0 {
                    best = (height, time);
                }
            }
            if heights[0] <= heights[1] { b = times[1] } else { a = times[0] }
        }
    }
    Some(found.filter(|f| f.0 < best.0).unwrap_or(best))
}

#[cfg(test)]
mod tests {
    use proveout_tool::Cutter;

    use super::*;

    /// A ball on a circle of many short pieces about the z axis: its lowest place over a line is followed
    /// round the circle.
    #[test]
    fn a_contact_is_followed_over_the_pieces() {
        let (count, radius, ball) = (720, 20.0, 3.0);
        let pose = |k: usize| {
            let (s, c) = (k as f64 * std::f64::consts::TAU / f64::from(count)).sin_cos();
            ToolPose { tip: Point::new(radius * c, radius * s, 0.0), axis: Vector::z() }
        };
        let pieces = (0..count as usize).map(|k| PathPiece { from: pose(k), to: pose(k + 1), cutter: Some(0) });
        let bodies = Cutter::ball(2.0 * ball).and_then(|c| c.bodies(10.0)).expect("a ball end");
        let path = SweptPath::new(pieces.collect(), &[bodies]);
        let from = PathContact { height: 0.0, piece: 10, at: 0.5 };
        for degrees in [5.2, 8.1, 40.0, 100.3, 359.0_f64] {
            let (s, c) = degrees.to_radians().sin_cos();
            let aside = 0.4;
            let point = Point::new((radius + aside) * c, (radius + aside) * s, 0.0);
            let found = path.follow(&from, &point, &Vector::z()).expect("under the path");
            let exact = ball - (ball * ball - aside * aside).sqrt();
            // The chords lie up to r (1 - cos(pi / n)) inside of the circle.
            let chord = radius * (1.0 - (std::f64::consts::PI / f64::from(count)).cos());
            let bound = chord * aside / ball * 1.1 + 1e-12;
            if degrees < 180.0 {
                assert!((found.height - exact).abs() < bound, "{degrees}: {} {exact}", found.height);
            } else {
                // From piece 10 the height does not fall all the way round: the start of the path ends the
                // search.
                assert!(found.height >= exact - bound);
            }
            let near = path.near(&point, 0.1);
            let all = path.lowest_of(&near, &point, &Vector::z(), 0.0).expect("near");
            assert!((all.height - exact).abs() < bound, "{degrees}: {} {exact}", all.height);
            assert!(near.len() < 300, "{}", near.len());
        }
    }
}
