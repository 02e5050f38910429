//! Contacts of an edge with the normal of a design point: the lowest one over a run of pieces.
//!
//! # Why none is lost
//!
//! The arc of an edge lies within a convex body of revolution, its hull (`Hull`). Let d(h, t) be the signed
//! distance of the point at height h on the normal from the hull at time t. Along a straight piece the hull
//! is carried without turning, so that d is convex in (h, t) together, and its tangent plane at (h0, t0)
//! bounds it from below:
//!
//! ```text
//!   d(h, t) >= d0 + d_h (h - h0) + d_t (t - t0) - K (t - t0)^2 / 2
//!   K       =  w^2 |q| + 2 w v   (turning piece, rate w, speed v)
//! ```
//!
//! (in the turning housing the fixed point q accelerates by K at most, and d is 1-Lipschitz). With `d_h` <=
//! 0 the second term only helps for h <= h0, so that no contact below h0 exists while `d0 + d_t (t - t0) - K
//! (t - t0)^2 / 2 > 0`. With h0 the lowest height known, this time is leapt over
//! ([`ContactWalk::clear_time`]). Inside of a ring of inserts (nearer to the axis than the arc's center) the
//! hull says nothing, and the distance from the ring, which loses no more than the way that the point goes,
//! is used instead.
//!
//! Where nothing can be leapt over, contacts are met one after the other. Let alpha be the angle from the
//! tooth to the point where the arc's circle, turned about the axis, meets the normal. It changes at w +- u /
//! rho, u the speed of that point on the circle's surface and rho its distance from the axis. While u is
//! below three tenths of w rho it falls evenly enough that one contact belongs to each turn, and the next
//! lies where alpha says, -+ three tenths of a turn; Newton's method in (t, h) must end within three tenths.
//! Everything else (points near the axis, where the tooth passes several times a revolution or not at all;
//! normals that graze; starts from which Newton's method goes astray) is searched over the revolution in
//! parts ([`ContactWalk::revolution`]).

use std::f64::consts::TAU;

use proveout_geom::Vector;

use super::{
    AT_CENTER, NOT_ZERO,
    edge::{Edge, Residual},
    envelope::NormalLine,
    motion::{CutterState, SweptPiece},
};

/// Steps of Newton's method; from a start within some hundredths of a revolution four do.
const STEPS: usize = 14;
/// End of the search in height, mm.
const CLOSE: f64 = 1e-13;
/// Rounding of a distance, mm: what is nearer than this to the best height is looked at.
const ROUNDING: f64 = 1e-12;
/// Largest share of the tooth's angular rate by which that of the point may differ where contacts are met one
/// by one: two of them are then three quarters of a turn apart at least, and a guess cannot lead to the one
/// after the next.
const STEADY: f64 = 0.3;
/// Parts of a revolution that is searched by itself.
const PARTS: usize = 16;
/// Square of the least distance from the axis within the plane of a turned nose, mm^2: beyond it the arc's
/// circle does not come.
const LEAST_SQUARE: f64 = 1e-12;
/// Leaps below this part of a turn are not worth their price: contacts are met one by one then.
const SHORT_LEAP: f64 = 1e-3;
/// Part of a turn by which a root may lie behind the place from which it is looked for: rounding.
const BEHIND: f64 = 1e-5;
/// Part of a turn by which a contact at the very begin may seem to be passed: rounding.
const AT_BEGIN: f64 = 1e-6;
/// Error of a guess at least, in turns.
const LEAST_SPREAD: f64 = 1e-3;
/// Part of a turn by which a root may lie outside of its piece: no joint of two pieces loses one.
const RIM: f64 = 1e-7;
/// Last step to the circle on the normal, in radii of the arc: for a guess, and for a meeting.
const GUESSED: f64 = 1e-4;
const MET: f64 = 1e-5;
/// Determinant of Newton's equations below which a root is none that can be followed.
const SINGULAR: f64 = 1e-12;
/// Last step in time, as the angle that the spindle turns meanwhile, radian.
const SETTLED_RAD: f64 = 1e-11;
/// A bracket, radian, or a distance from the plane of the edge, mm, from which Newton's method takes over.
const NARROW_RAD: f64 = 1e-4;
const NEAR_PLANE: f64 = 1e-7;

/// Pieces that follow one another without gap in time, tip and azimuth, each with a height below which it
/// does not come anywhere in the part of the lattice that is searched.
pub(crate) struct PieceRun {
    pub pieces: Vec<SweptPiece>,
    pub floors: Vec<f64>,
    /// Lowest of the floors.
    pub lowest: f64,
}

/// The lowest contact found so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LowestContact {
    /// mm; infinity without contact.
    pub height: f64,
    /// s.
    pub time: f64,
    /// The motion of the piece, as the caller counts.
    pub motion: u32,
    /// Tooth.
    pub edge: usize,
}

impl LowestContact {
    pub(crate) const NONE: Self = Self { height: f64::INFINITY, time: f64::NAN, motion: u32::MAX, edge: usize::MAX };
}

/// An edge with the convex body of revolution that holds its arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hull {
    pub edge: Edge,
    /// By how much the arc leaves the body: only where it crosses the axis.
    margin: f64,
    /// Distance from the axis within which the arc lies on the other side of it.
    behind: f64,
    /// Sine and cosine of the nose turn.
    nose: (f64, f64),
}

/// A point seen from a hull.
struct HullPoint {
    rho: f64,
    /// Distance from the hull, mm, and its gradient in housing coordinates.
    distance: f64,
    gradient: Vector,
}

impl Hull {
    pub(crate) fn new(edge: &Edge) -> Self {
        let behind = edge.behind_axis();
        Self { edge: *edge, margin: edge.margin(), behind, nose: edge.nose_turn.sin_cos() }
    }

    #[inline]
    fn hull_point(&self, q: &Vector) -> HullPoint {
        let rho = (q.x * q.x + q.y * q.y).sqrt();
        let (mut out, mut up) = (rho - self.edge.center_radius, q.z - self.edge.center_height);
        if self.edge.center_radius >= 0.0 {
            (out, up) = (out.max(0.0), up.min(0.0));
        }
        let length = (out * out + up * up).sqrt().max(AT_CENTER);
        let radial = out / (length * rho.max(NOT_ZERO));
        HullPoint {
            rho,
            distance: length - self.edge.radius - self.margin,
            gradient: Vector::new(radial * q.x, radial * q.y, up / length),
        }
    }

    /// Distance from the arc turned about the axis (in the plane of the edge), and its gradient.
    ///
    /// With the plane of the edge turned by g about the nose, a point at distance `side` from the nose line
    /// is rho from the axis with rho^2 = c^2 + 2 c side cos g + side^2.
    #[inline]
    fn ring(&self, q: &Vector) -> (f64, Vector) {
        let (c, up) = (self.edge.center_radius, q.z - self.edge.center_height);
        let rho2 = q.x * q.x + q.y * q.y;
        let rho = rho2.sqrt();
        let (out, by_rho) = if self.edge.nose_turn == 0.0 {
            (rho - c, 1.0)
        } else {
            let (sin, cos) = self.nose;
            let root = (rho2 - c * c * sin * sin).max(LEAST_SQUARE).sqrt();
            (root - c * cos, rho / root)
        };
        let length = (out * out + up * up).sqrt().max(AT_CENTER);
        let radial = out * by_rho / (length * rho.max(NOT_ZERO));
        (length - self.edge.radius, Vector::new(radial * q.x, radial * q.y, up / length))
    }
}

impl PieceRun {
    pub(crate) fn new(pieces: Vec<SweptPiece>, floors: Vec<f64>) -> Self {
        let lowest = floors.iter().copied().fold(f64::INFINITY, f64::min);
        Self { pieces, floors, lowest }
    }

    /// Middle of the piece with the lowest floor, s.
    pub(crate) fn middle_of_lowest(&self) -> f64 {
        let k = self.floors.iter().position(|f| *f <= self.lowest).unwrap_or(0);
        self.pieces.get(k).map_or(0.0, |p| 0.5 * (p.time[0] + p.time[1]))
    }

    pub(crate) fn begin(&self) -> f64 {
        self.pieces.first().map_or(0.0, |p| p.time[0])
    }

    pub(crate) fn end(&self) -> f64 {
        self.pieces.last().map_or(0.0, |p| p.time[1])
    }

    fn piece_of(&self, time: f64) -> usize {
        self.pieces.partition_point(|p| p.time[1] < time).min(self.pieces.len().saturating_sub(1))
    }

    /// Lowers `best` by the contacts of edge `index`, searched outward from `from`; heights above `cap` do
    /// not count.
    pub(crate) fn search(
        &self,
        ray: &NormalLine,
        hull: &Hull,
        index: usize,
        from: f64,
        cap: f64,
        best: &mut LowestContact,
    ) {
        if self.pieces.is_empty() || !from.is_finite() {
            return;
        }
        let middle = self.piece_of(from);
        let mut walk = |k: usize, from: f64, forward: bool| {
            if self.floors[k] < best.height.min(cap) {
                ContactWalk { ray, hull, index, piece: &self.pieces[k], forward, cap }.walk(from, best);
            }
        };
        let [begin, end] = self.pieces[middle].time;
        let from = from.clamp(begin, end);
        walk(middle, from, true);
        if from > begin {
            walk(middle, from, false);
        }
        for k in middle + 1..self.pieces.len() {
            walk(k, self.pieces[k].time[0], true);
        }
        for k in (0..middle).rev() {
            walk(k, self.pieces[k].time[1], false);
        }
    }

    /// Follows the contact of a neighboring point.
    pub(crate) fn follow(
        &self,
        ray: &NormalLine,
        hull: &Hull,
        neighbor: &LowestContact,
        cap: f64,
        best: &mut LowestContact,
    ) {
        let Some(piece) = self.pieces.get(self.piece_of(neighbor.time)) else { return };
        let walk = ContactWalk { ray, hull, index: neighbor.edge, piece, forward: true, cap };
        if let Some(root) = walk.root(neighbor.time, neighbor.height) {
            walk.take_if_lower(&root, best);
        }
    }
}

/// A place where the normal meets the arc's circle in the plane of the edge.
struct EdgeCrossing {
    time: f64,
    height: f64,
    /// It lies on the arc, which is entered there from inside of the design.
    on_edge: bool,
}

/// The height at which the turned circle meets the normal at a time, and the tooth there.
struct Meeting {
    time: f64,
    height: f64,
    /// Plane of the edge: distance, and its rate along the circle's surface.
    plane: f64,
    rate: f64,
}

/// A walk over one piece in one direction.
struct ContactWalk<'a> {
    ray: &'a NormalLine,
    hull: &'a Hull,
    index: usize,
    piece: &'a SweptPiece,
    forward: bool,
    cap: f64,
}

impl ContactWalk<'_> {
    fn walk(&self, from: f64, best: &mut LowestContact) {
        let w = self.piece.azimuth_rate;
        if w == 0.0 || !w.is_finite() {
            return;
        }
        let (direction, stop) = if self.forward { (1.0, self.piece.time[1]) } else { (-1.0, self.piece.time[0]) };
        let turn = TAU / w.abs();
        let mut time = from;
        // Whether `time` is a contact that is dealt with.
        let mut at_root = false;
        loop {
            let left = (stop - time) * direction;
            // The end of the piece belongs to it; the next piece begins there.
            if left < 0.0 || (left == 0.0 && at_root) {
                return;
            }
            let height = best.height.min(self.cap);
            let state = self.piece.state(time);
            let q = state.point(&(self.ray.point + self.ray.normal * height));
            let normal = state.direction(&self.ray.normal);
            let velocity = self.piece.rate(&state, &q);
            let look = self.hull.hull_point(&q);
            let leap = self.clear_time(&q, &normal, &velocity, &look, direction, height);
            if leap > SHORT_LEAP * turn {
                time += direction * leap;
                at_root = false;
                continue;
            }
            let Some((guess, spread)) = self.next(&q, &state, height, time, direction, at_root) else {
                time = self.search_revolution(time, stop, direction, height, best);
                at_root = false;
                continue;
            };
            if (guess.0 - stop) * direction > spread {
                return;
            }
            match self.root(guess.0, guess.1) {
                Some(root)
                    if (root.time - guess.0).abs() < 0.3 * turn && (root.time - time) * direction > -BEHIND * turn =>
                {
                    self.take_if_lower(&root, best);
                    time = root.time;
                    at_root = true;
                }
                _ => {
                    time = self.search_revolution(time, stop, direction, height, best);
                    at_root = false;
                }
            }
        }
    }

    /// Searches a revolution in parts, less what can be leapt over from its end; returns the time after the
    /// revolution.
    fn search_revolution(&self, time: f64, stop: f64, direction: f64, height: f64, best: &mut LowestContact) -> f64 {
        let turn = TAU / self.piece.azimuth_rate.abs();
        let behind = time + direction * turn;
        let mut until = if (stop - behind) * direction < 0.0 { stop } else { behind };
        for _ in 0..4 {
            let state = self.piece.state(until);
            let q = state.point(&(self.ray.point + self.ray.normal * height));
            let normal = state.direction(&self.ray.normal);
            let velocity = self.piece.rate(&state, &q);
            let leap = self.clear_time(&q, &normal, &velocity, &self.hull.hull_point(&q), -direction, height);
            if leap <= 0.02 * turn {
                break;
            }
            until -= direction * leap;
            if (until - time) * direction <= 0.0 {
                return behind;
            }
        }
        self.revolution(time, until, height, best);
        behind
    }

    /// Time over which no contact lies below the height of `q`, s; zero if that is not known.
    #[inline]
    fn clear_time(
        &self,
        q: &Vector,
        normal: &Vector,
        velocity: &Vector,
        look: &HullPoint,
        direction: f64,
        height: f64,
    ) -> f64 {
        let along = look.gradient.dot(normal);
        let spin = self.piece.spin.norm();
        let mut leap = 0.0_f64;
        if along < 0.0 {
            let d = look.distance - ROUNDING;
            let rate = look.gradient.dot(velocity) * direction;
            let bend = spin * (spin * (q.norm() + self.piece.travel()) + 2.0 * self.piece.speed());
            if d > 0.0 || (d > -2.0 * ROUNDING && rate > 0.0) {
                let d = d.max(0.0);
                leap = if bend > 0.0 {
                    // The positive root of d + rate t - bend t^2 / 2.
                    let root = (rate * rate + 2.0 * bend * d).sqrt();
                    if rate >= 0.0 { (rate + root) / bend } else { 2.0 * d / (root - rate) }
                } else if rate >= 0.0 {
                    f64::INFINITY
                } else {
                    -d / rate
                };
            }
        } else if look.distance > 0.0 {
            // Past the cutter; so must the design point be: its cutter came from within.
            let design = self.hull.hull_point(&(q - normal * height));
            if design.distance > 0.0 && design.gradient.dot(normal) >= 0.0 {
                leap = look.distance.min(design.distance) / (velocity.norm() + spin * q.norm()).max(NOT_ZERO);
            }
        }
        // Inside of a ring nothing below this height comes nearer to its circle than its own distance, unless
        // the normal leans toward it.
        let inside = self.hull.edge.center_radius - look.rho;
        let below = self.hull.edge.center_height - q.z;
        if inside > 0.0 && below > 0.0 && normal.z > 0.0 {
            let (r, across) = (self.hull.edge.radius + ROUNDING, normal.x.hypot(normal.y));
            let turning = spin * q.norm();
            let (outward, upward) = (velocity.x.hypot(velocity.y) + turning, velocity.z.abs() + turning);
            let room = normal.z * below - across * inside;
            let free = inside * inside + below * below - r * r;
            if room >= 0.0 && free > 0.0 {
                // (inside - outward t)^2 + (below - upward t)^2 = r^2, where that comes before the ring's
                // circle is under the point.
                let under = inside / outward.max(NOT_ZERO);
                let first = if below - upward * under > r {
                    (below - r) / upward.max(NOT_ZERO)
                } else {
                    let (a, b) = (outward * outward + upward * upward, inside * outward + below * upward);
                    free / (b + (b * b - a * free).max(0.0).sqrt()).max(NOT_ZERO)
                };
                let upright = room / (normal.z * upward).max(NOT_ZERO);
                leap = leap.max(first.min(upright));
            } else if room < 0.0 {
                let distance = inside * normal.z + below * across - r;
                leap = leap.max(distance / (outward + upward).max(NOT_ZERO));
            }
        }
        leap
    }

    /// Time and height of the next contact, and the possible error of its time; `None` where they cannot be
    /// determined.
    #[inline]
    fn next(
        &self,
        q: &Vector,
        state: &CutterState,
        height: f64,
        time: f64,
        direction: f64,
        at_root: bool,
    ) -> Option<((f64, f64), f64)> {
        let edge = &self.hull.edge;
        let w = self.piece.azimuth_rate;
        let normal = state.direction(&self.ray.normal);
        // The circle on the normal, by two steps of Newton's method.
        let (mut q, mut height) = (*q, height);
        let mut gradient = Vector::zeros();
        for _ in 0..3 {
            let (distance, g) = self.hull.ring(&q);
            gradient = g;
            let along = g.dot(&normal);
            if along > -0.2 {
                return None;
            }
            let step = (-distance / along).clamp(-0.5 * edge.radius, 0.5 * edge.radius);
            q += normal * step;
            height += step;
            if step.abs() < GUESSED * edge.radius {
                break;
            }
        }
        let rate = self.piece.rate(state, &q);
        let along = gradient.dot(&normal);
        // Of the point where they meet.
        let met = rate - normal * (gradient.dot(&rate) / along);
        let rho2 = q.x * q.x + q.y * q.y;
        let rho = rho2.sqrt();
        let speed = met.norm();
        // Nearest to the axis on the way over this turn and the quarter that the next contact may lie beyond
        // it.
        let (run, over) = ((q.x * met.x + q.y * met.y) * direction, 1.25 * TAU / w.abs());
        let flat = met.x * met.x + met.y * met.y;
        let until = (-run / flat.max(NOT_ZERO)).clamp(0.0, over);
        let nearest = (rho2 + (2.0 * run + flat * until) * until).max(0.0).sqrt();
        if speed > STEADY * w.abs() * nearest || nearest < 2.0 * self.hull.behind {
            return None;
        }
        let residual = edge.residual(&q, state.azimuth);
        let mut alpha = residual.across.atan2(residual.along);
        if edge.nose_turn != 0.0 {
            // rho sin(alpha - g) = - c sin g in the plane of the edge.
            let s = edge.center_radius * edge.nose_turn.sin() / rho;
            if s.abs() > 0.9 {
                return None;
            }
            alpha -= edge.nose_turn - s.asin();
            alpha -= TAU * (alpha / TAU).round();
        }
        let seen = (q.x * met.y - q.y * met.x) / rho2 - edge.lead * met.z;
        let close = w - seen;
        let turn = TAU / close.abs();
        let ahead = if at_root {
            turn
        } else {
            // A contact at the very begin is not passed over.
            (alpha / close * direction + AT_BEGIN * turn).rem_euclid(turn) - AT_BEGIN * turn
        };
        let guess = time + direction * ahead;
        let climb = -gradient.dot(&rate) / along;
        let spread = (0.02 + speed / (w.abs() * nearest)) * ahead.abs() + LEAST_SPREAD * turn;
        Some(((guess, height + climb * direction * ahead), spread))
    }

    /// Takes a root if it is lower, on the edge and within the piece.
    fn take_if_lower(&self, root: &EdgeCrossing, best: &mut LowestContact) {
        let [begin, end] = self.piece.time;
        let rim = RIM * TAU / self.piece.azimuth_rate.abs();
        if root.on_edge && root.height < best.height && root.time >= begin - rim && root.time <= end + rim {
            let time = root.time.clamp(begin, end);
            *best = LowestContact { height: root.height, time, motion: self.piece.motion, edge: self.index };
        }
    }

    /// Newton's method in time and height.
    fn root(&self, time: f64, height: f64) -> Option<EdgeCrossing> {
        let edge = &self.hull.edge;
        let (mut t, mut h) = (time, height);
        for _ in 0..STEPS {
            let state = self.piece.state(t);
            let (residual, [pt, at], [ph, ah]) = self.derivatives(&state, h);
            let det = pt * ah - ph * at;
            if det.abs() < SINGULAR {
                return None;
            }
            let dt = -(residual.plane * ah - ph * residual.arc) / det;
            let dh = -(pt * residual.arc - at * residual.plane) / det;
            t += dt;
            // A step larger than the arc has left it; come back slowly.
            h += dh.clamp(-0.5 * edge.radius, 0.5 * edge.radius);
            if !(t.is_finite() && h.is_finite()) {
                return None;
            }
            // Near a simple root the next step is the square of this one, times the size of the cutter: it
            // need not be taken.
            let step = (dt * self.piece.azimuth_rate).abs() + dh.abs() / edge.radius;
            let simple = det.abs() > 0.1 * (pt.abs() + at.abs());
            let next = 4.0 * step * step * (edge.radius + edge.center_radius.abs());
            let settled = dh.abs() <= CLOSE * (1.0 + h.abs()) && (dt * self.piece.azimuth_rate).abs() < SETTLED_RAD;
            if settled || simple && next <= CLOSE {
                // Coming from inside of the design the arc is entered, on the side of the tooth, in its
                // range.
                let on_edge = ah < 0.0 && (residual.along >= 0.0 || residual.side >= 0.0) && edge.holds(&residual);
                return Some(EdgeCrossing { time: t, height: h, on_edge });
            }
        }
        None
    }

    #[inline]
    fn derivatives(&self, state: &CutterState, height: f64) -> (Residual, [f64; 2], [f64; 2]) {
        let q = state.point(&(self.ray.point + self.ray.normal * height));
        let residual = self.hull.edge.residual(&q, state.azimuth);
        let by_time = residual.along_rate(&self.piece.rate(state, &q), self.piece.azimuth_rate);
        let by_height = residual.along_rate(&state.direction(&self.ray.normal), 0.0);
        (residual, by_time, by_height)
    }

    /// Where the turned circle meets the normal at a time; `height` is near.
    fn meeting(&self, time: f64, height: f64) -> Option<Meeting> {
        let edge = &self.hull.edge;
        let state = self.piece.state(time);
        let normal = state.direction(&self.ray.normal);
        let mut h = height;
        for _ in 0..16 {
            let q = state.point(&(self.ray.point + self.ray.normal * h));
            let (distance, g) = self.hull.ring(&q);
            let along = g.dot(&normal);
            if along > -0.02 {
                // Deep in the cutter, or past it.
                if self.hull.hull_point(&q).distance > 0.0 {
                    return None;
                }
                h -= 0.5 * edge.radius;
                continue;
            }
            let step = (-distance / along).clamp(-0.5 * edge.radius, 0.5 * edge.radius);
            h += step;
            // The next step would be the square of this one over the radius. The residual is small enough
            // to give the side of the plane; roots are polished.
            if step.abs() < MET * edge.radius {
                let (residual, [pt, _], [ph, _]) = self.derivatives(&state, h);
                let rate = self.piece.rate(&state, &q);
                return Some(Meeting { time, height: h, plane: residual.plane, rate: pt - ph * g.dot(&rate) / along });
            }
        }
        None
    }

    /// All contacts between two times, no more than a revolution apart, wherever the axis is.
    ///
    /// The distance of the meeting point from the plane of the edge is nearly a sine of one period whose
    /// amplitude and offset change slowly. In each of [`PARTS`] of a revolution a change of its sign is
    /// narrowed to its root; where the sign stays, but the rate turns from toward zero to away from it, the
    /// turning point is sought first, and the two roots on its sides after it.
    fn revolution(&self, a: f64, b: f64, height: f64, best: &mut LowestContact) {
        let (from, to) = (a.min(b), a.max(b));
        if !(to - from).is_finite() {
            return;
        }
        let turn = TAU / self.piece.azimuth_rate.abs();
        // A way of a twentieth of the arc's radius is as small a part, where the spindle hardly turns.
        let ways = (self.piece.travel() + self.piece.angle() * self.hull.edge.radius) / (0.05 * self.hull.edge.radius);
        let share = (to - from) / self.piece.duration().max(NOT_ZERO);
        let parts = ((to - from) / turn * PARTS as f64).max(ways * share).ceil().clamp(1.0, 4096.0) as usize;
        let mut last: Option<Meeting> = None;
        let mut start = height;
        for i in 0..=parts {
            let time = if i == parts { to } else { from + (to - from) * i as f64 / parts as f64 };
            let here = self.meeting(time, start).or_else(|| self.meeting(time, height));
            start = here.as_ref().map_or(start, |m| m.height);
            match (&last, &here) {
                (Some(x), Some(y)) => self.between(x, y, best),
                // The normal enters or leaves the circle within this part.
                (Some(m), None) | (None, Some(m)) => self.polish(m.time, m.height, best),
                (None, None) => {}
            }
            last = here;
        }
    }

    fn polish(&self, time: f64, height: f64, best: &mut LowestContact) {
        if let Some(root) = self.root(time, height) {
            self.take_if_lower(&root, best);
        }
    }

    /// The contacts between two times that are a small part of a revolution apart.
    fn between(&self, x: &Meeting, y: &Meeting, best: &mut LowestContact) {
        if x.plane * y.plane <= 0.0 {
            return self.contact_between(x, y, best);
        }
        if x.plane * x.rate < 0.0 && y.plane * y.rate > 0.0 {
            // Toward zero and away again: the nearest place by halving the rate.
            let (mut a, mut b) = (x.time, y.time);
            for _ in 0..40 {
                let Some(m) = self.meeting(0.5 * (a + b), x.height) else { return };
                if m.plane * x.plane <= 0.0 {
                    self.contact_between(x, &m, best);
                    return self.contact_between(&m, y, best);
                }
                if m.rate * x.rate > 0.0 {
                    a = m.time
                } else {
                    b = m.time
                }
                // What the plane can still lose on the way.
                if (m.rate * (b - a)).abs() < m.plane.abs() {
                    return;
                }
            }
        }
    }

    /// The contact between two times with different signs, by regula falsi with halving (Illinois) and
    /// Newton's method at the end.
    fn contact_between(&self, x: &Meeting, y: &Meeting, best: &mut LowestContact) {
        let (mut a, mut b, mut fa, mut fb) = (x.time, y.time, x.plane, y.plane);
        let (mut at, mut height, mut side) = (if fa.abs() < fb.abs() { a } else { b }, x.height, 0);
        for _ in 0..30 {
            if fa == fb || (b - a).abs() * self.piece.azimuth_rate.abs() < NARROW_RAD {
                break;
            }
            at = (a * fb - b * fa) / (fb - fa);
            let Some(m) = self.meeting(at, height) else { break };
            height = m.height;
            if m.plane.abs() < NEAR_PLANE {
                break;
            }
            if m.plane * fb > 0.0 {
                (b, fb) = (at, m.plane);
                if side == 1 {
                    fa *= 0.5;
                }
                side = 1;
            } else {
                (a, fa) = (at, m.plane);
                if side == -1 {
                    fb *= 0.5;
                }
                side = -1;
            }
        }
        self.polish(at, height, best);
    }
}
