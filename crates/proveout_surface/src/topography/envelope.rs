//! Where the nominal cutter of a piece meets the normal of a design point.

use proveout_geom::Vector;

use super::{AT_CENTER, LARGEST, MOST_RADIUS, NOT_ZERO, motion::SweptPiece, outline::CutterBody};

/// A line through a design point along its normal; heights are counted along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalLine {
    pub point: Vector,
    pub normal: Vector,
}

impl NormalLine {
    pub(crate) fn is_finite(&self) -> bool {
        self.point.iter().chain(self.normal.iter()).all(|v| v.abs() < LARGEST)
    }
}

/// The height at which a cutter in one position meets a ray first, coming from inside of the design.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutterTouch {
    /// mm.
    pub height: f64,
    /// Its derivative with time, mm/s.
    pub rate: f64,
    /// Outward unit normal of the cutter there, in W.
    pub normal: Vector,
    /// Distance of the place from the tip, mm.
    pub reach: f64,
}

/// Newton's method on a convex function ends in a few steps; more mean a ray that misses.
const STEPS: usize = 40;
/// Change of height at which the search ends, mm: rounding of coordinates of 100 mm.
const CLOSE: f64 = 1e-13;
/// Change of the distance with height from which on the ray has passed the middle of the body, or misses it.
const PASSED: f64 = 1e-9;
/// Part of a piece below which a step in time is as good as none: the distance changes by less than rounding.
const LEAST_STEP: f64 = 1e-7;
/// A height that can fall by less than this, mm, is closed in on from the other side.
const CLOSING: f64 = 1e-12;

/// The touch at a time; none where the ray misses the body.
///
/// The distance to a convex body is a convex function of the height. From outside and below, Newton's method
/// comes to its first zero without passing it; a start inside is thrown out below in one step (the tangent
/// lies under the function).
pub(crate) fn touch(
    ray: &NormalLine,
    piece: &SweptPiece,
    body: &CutterBody,
    time: f64,
    start: f64,
) -> Option<CutterTouch> {
    let state = piece.state(time);
    let base = state.point(&ray.point);
    let direction = state.direction(&ray.normal);
    let mut height = start;
    for _ in 0..STEPS {
        let q = base + direction * height;
        let r = (q.x * q.x + q.y * q.y).sqrt();
        let (distance, [gr, gz]) = body.distance(r, q.z);
        let radial = if r > AT_CENTER { [q.x / r, q.y / r] } else { [0.0, 0.0] };
        let gradient = Vector::new(gr * radial[0], gr * radial[1], gz);
        let along = gradient.dot(&direction);
        if along >= -PASSED {
            // Past the middle of the body, or the line misses it.
            if distance >= 0.0 {
                return None;
            }
            height -= 2.0 * distance.abs().max(body.smallest_radius().min(1.0));
            continue;
        }
        let step = -distance / along;
        height += step;
        if step.abs() <= CLOSE * (1.0 + height.abs()) {
            let rate = -gradient.dot(&piece.rate(&state, &q)) / along;
            let normal = state.frame[0] * gradient.x + state.frame[1] * gradient.y + state.frame[2] * gradient.z;
            return Some(CutterTouch { height, rate, normal, reach: q.norm() });
        }
    }
    None
}

impl CutterTouch {
    /// Tangent of the angle between the cutter's normal and a ray.
    pub(crate) fn slope(&self, ray: &NormalLine) -> f64 {
        let along = self.normal.dot(&ray.normal);
        (1.0 - along * along).max(0.0).sqrt() / -along
    }
}

/// A touch lower by less may be left out where a piece turns, mm. With less, leaps begin shorter.
const CERTAIN: f64 = 1e-9;

/// Values of one place on a ray at one time.
struct RaySample {
    distance: f64,
    /// Distance from the tip.
    reach: f64,
    /// Derivatives of the distance with height and time.
    by_height: f64,
    by_time: f64,
}

fn sample(ray: &NormalLine, piece: &SweptPiece, body: &CutterBody, time: f64, height: f64) -> RaySample {
    let state = piece.state(time);
    let q = state.point(&(ray.point + ray.normal * height));
    let r = (q.x * q.x + q.y * q.y).sqrt();
    let (distance, [gr, gz]) = body.distance(r, q.z);
    let over = if r > AT_CENTER { gr / r } else { 0.0 };
    let gradient = Vector::new(over * q.x, over * q.y, gz);
    RaySample {
        distance,
        reach: q.norm(),
        by_height: gradient.dot(&state.direction(&ray.normal)),
        by_time: gradient.dot(&piece.rate(&state, &q)),
    }
}

/// The lowest touch of a piece below a height, and when: (height, time). `near` is a time and a height to
/// begin with.
///
/// A convex body that moves straight makes the height a convex function of time, and [`descend`] finds its
/// lowest place. Where the piece turns, or the body leaves the ray within the piece, there may be several:
/// the whole piece is then gone through by leaps. With d(h, t) the distance of the body from the place at
/// height h, bounded from below by its tangent plane less K (t - t0)^2 / 2 (K as in `edge_contact`), no touch
/// lies below h0 while `d0 + d_t (t - t0) - K (t - t0)^2 / 2 > 0`, provided that d falls with h. So that
/// leaps have a length at the lowest place too, h0 is taken [`CERTAIN`] lower: a touch that is lower by less
/// may be left out.
pub(crate) fn lowest(
    ray: &NormalLine,
    piece: &SweptPiece,
    body: &CutterBody,
    near: (f64, f64),
    below: f64,
) -> Option<(f64, f64)> {
    let [begin, end] = piece.time;
    let mut near = near;
    if !(begin..=end).contains(&near.0) {
        // Most pieces near the one that cuts are ruled out after one or two leaps, from their end next to
        // it or from their middle.
        let from = match near.0 {
            t if t > end && t - end < piece.duration() => end,
            t if t < begin && begin - t < piece.duration() => begin,
            _ => 0.5 * (begin + end),
        };
        let (height, time) = lower_touch(ray, piece, body, from, below)?;
        near = (time, height);
    }
    let (mut best, certain) = descend(ray, piece, body, near);
    if certain && !piece.turns() {
        return best;
    }
    // Each round lowers the best touch by [`CERTAIN`] at least; the count only guards against rounding.
    for _ in 0..1000 {
        let level = best.map_or(below, |b| b.0.min(below));
        let from = best.map_or(piece.time[0], |b| b.1);
        let Some(found) = lower_touch(ray, piece, body, from, level) else { break };
        best = Some(valley(ray, piece, body, found));
    }
    best
}

/// A low place of a piece whose height has several, from a touch of it: the lowest of some touches over the
/// piece, and from there golden sections. What it misses is found by the leaps of [`lowest`].
fn valley(ray: &NormalLine, piece: &SweptPiece, body: &CutterBody, found: (f64, f64)) -> (f64, f64) {
    const TOUCHES: usize = 16;
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let [begin, end] = piece.time;
    let mut best = found;
    let mut at = |time: f64| {
        let height = touch(ray, piece, body, time, best.0).map_or(f64::INFINITY, |t| t.height);
        if height < best.0 {
            best = (height, time);
        }
        (height, time)
    };
    let step = (end - begin) / TOUCHES as f64;
    let low = (0..=TOUCHES).map(|i| at(begin + step * i as f64)).fold(found, |a, b| if b.0 < a.0 { b } else { a });
    let (mut a, mut b) = ((low.1 - step).max(begin), (low.1 + step).min(end));
    let (mut x, mut y) = (at(b - (b - a) * GOLDEN), at(a + (b - a) * GOLDEN));
    // The bracket shrinks to a millionth, whose square is rounding in height.
    for _ in 0..40 {
        if x.0 < y.0 {
            b = y.1;
            (y, x) = (x, at(b - (b - a) * GOLDEN));
        } else {
            a = x.1;
            (x, y) = (y, at(a + (b - a) * GOLDEN));
        }
    }
    best
}

/// A touch of the piece below a height, searched to both sides of a time by leaps.
fn lower_touch(ray: &NormalLine, piece: &SweptPiece, body: &CutterBody, from: f64, level: f64) -> Option<(f64, f64)> {
    let search =
        TouchSearch { ray, piece, body, height: level - CERTAIN, spin: piece.spin.norm(), speed: piece.speed() };
    let here = search.at(from);
    search.toward(from, &here, 1.0).or_else(|| search.toward(from, &here, -1.0))
}

/// A search for touches below a height.
struct TouchSearch<'a> {
    ray: &'a NormalLine,
    piece: &'a SweptPiece,
    body: &'a CutterBody,
    height: f64,
    spin: f64,
    speed: f64,
}

/// What one time says about those around it: no touch lies below the height while its tangent plane is above
/// it.
enum TimeNeighborhood {
    /// The distance at a place whose depth under the height is given, and what the tangent there leaves at
    /// the height.
    Tangent { below: RaySample, free: f64, depth: f64 },
    /// For so long nothing comes near.
    Clear(f64),
    /// A touch may be right here.
    Touch,
}

impl TouchSearch<'_> {
    fn at(&self, time: f64) -> TimeNeighborhood {
        let Self { ray, piece, body, height, .. } = *self;
        let s = sample(ray, piece, body, time, height);
        if s.distance <= 0.0 {
            return TimeNeighborhood::Touch;
        }
        if s.by_height < 0.0 {
            return TimeNeighborhood::Tangent { free: s.distance, below: s, depth: 0.0 };
        }
        // Past the body: that lies between the height and the design, or was never on this side of the
        // design.
        let floor = height.min(0.0);
        let design = sample(ray, piece, body, time, floor);
        if design.by_height >= 0.0 {
            let free = s.distance.min(design.distance);
            return TimeNeighborhood::Clear(free / (self.speed + self.spin * s.reach).max(NOT_ZERO));
        }
        let (below, depth, free) = falling(ray, piece, body, time, (floor, design), (height, s));
        TimeNeighborhood::Tangent { below, free, depth }
    }

    /// Where Newton's method on the height begins: inside of the body, or where the distance still falls.
    fn start(&self, around: &TimeNeighborhood) -> f64 {
        if let TimeNeighborhood::Tangent { depth, .. } = around { self.height - depth } else { self.height }
    }

    /// For how long no touch comes below the height, in one direction of time.
    fn clear_time(&self, around: &TimeNeighborhood, direction: f64) -> f64 {
        let (s, free, depth) = match around {
            TimeNeighborhood::Touch => return 0.0,
            TimeNeighborhood::Clear(time) => return *time,
            TimeNeighborhood::Tangent { below, free, depth } => (below, *free, *depth),
        };
        let bend = self.spin * (self.spin * (s.reach + depth + self.piece.travel()) + 2.0 * self.speed);
        let rate = s.by_time * direction;
        // The positive root of d + d_t t - K t^2 / 2.
        let root = (rate * rate + 2.0 * bend * free).sqrt();
        match (bend > 0.0, rate >= 0.0) {
            _ if free <= 0.0 => 0.0,
            (true, true) => (rate + root) / bend,
            (true, false) => 2.0 * free / (root - rate),
            (false, true) => f64::INFINITY,
            (false, false) => -free / rate,
        }
    }

    /// The first touch from a time on; `around` is what that time says.
    fn toward(&self, from: f64, around: &TimeNeighborhood, direction: f64) -> Option<(f64, f64)> {
        let piece = self.piece;
        let least = LEAST_STEP * piece.duration();
        let end = if direction > 0.0 { piece.time[1] } else { piece.time[0] };
        let mut time = from;
        let (mut leap, mut start) = (self.clear_time(around, direction), self.start(around));
        loop {
            if (leap <= least || leap.is_nan())
                && let Some(t) = touch(self.ray, piece, self.body, time, start)
                && t.height < self.height
            {
                return Some((t.height, time));
            }
            let left = (end - time) * direction;
            if left <= 0.0 || left.is_nan() {
                return None;
            }
            let next = time + direction * leap.max(least);
            // The end of the piece itself is looked at.
            time = if (end - next) * direction > 0.0 { next } else { end };
            let around = self.at(time);
            (leap, start) = (self.clear_time(&around, direction), self.start(&around));
        }
    }
}

/// A place under a level where the distance still falls with height, near its minimum: its sample, its
/// depth under the level, and what the tangent there leaves at the level, mm.
///
/// ```text
///  d |\               /        `low` falls, `high` rises, the body lies between or is passed beside:
///    | \ low         / high    d >= d(low) + d_h (h - low) for every h. The place is moved up until
///    |  `-.._____..-'          that is half of d at the level as well, or a place inside is found.
///    +------------------ h
/// ```
fn falling(
    ray: &NormalLine,
    piece: &SweptPiece,
    body: &CutterBody,
    time: f64,
    low: (f64, RaySample),
    high: (f64, RaySample),
) -> (RaySample, f64, f64) {
    let level = high.0;
    let (mut low, mut high) = (low, high);
    let mut free = low.1.distance + low.1.by_height * (level - low.0);
    for round in 0..60 {
        if low.1.distance <= 0.0 || free >= 0.5 * low.1.distance {
            break;
        }
        // Where both tangents cross; every third time the middle, so that neither side is stuck.
        let slopes = high.1.by_height - low.1.by_height;
        let crossing =
            (low.1.distance - high.1.distance + high.1.by_height * high.0 - low.1.by_height * low.0) / slopes;
        let inside = crossing > low.0 && crossing < high.0 && round % 3 != 2;
        let h = if inside { crossing } else { 0.5 * (low.0 + high.0) };
        let s = sample(ray, piece, body, time, h);
        if s.distance <= 0.0 || s.by_height < 0.0 {
            free = if s.distance <= 0.0 { 0.0 } else { s.distance + s.by_height * (level - h) };
            low = (h, s);
        } else {
            high = (h, s);
        }
    }
    (low.1, level - low.0, free)
}

/// The nearest lowest touch, and whether it is the only one of a straight piece.
///
/// Height and time are improved together, one evaluation a step: the height by Newton's method, the time by
/// the secant of its rate, kept between the last times with a falling and with a rising height. What does not
/// settle, as where the body leaves the ray within the piece, goes to [`lowest_slowly`].
pub(crate) fn descend(
    ray: &NormalLine,
    piece: &SweptPiece,
    body: &CutterBody,
    near: (f64, f64),
) -> (Option<(f64, f64)>, bool) {
    let [begin, end] = piece.time;
    let (mut low, mut high) = (begin, end);
    let mut time = if near.0.is_nan() { 0.5 * (begin + end) } else { near.0.clamp(begin, end) };
    let mut height = near.1;
    // Second derivative of the height to begin with: that of a ball of the smallest radius.
    let speed = piece.travel() / piece.duration();
    let mut bend = speed * speed / body.smallest_radius().min(MOST_RADIUS);
    // By how much the rate changes with height, 1/s.
    let turning = speed / body.smallest_radius().min(MOST_RADIUS) + piece.spin.norm();
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..24 {
        let s = sample(ray, piece, body, time, height);
        if s.by_height > -0.05 {
            break;
        }
        let up = -s.distance / s.by_height;
        height += up;
        let rate = -s.by_time / s.by_height;
        let settled = up.abs() <= CLOSE * (1.0 + height.abs());
        // Toward the lower side; at an end that is the lowest nothing moves.
        if (time <= begin && rate >= 0.0) || (time >= end && rate <= 0.0) {
            if settled {
                return (Some((height, time)), true);
            }
            continue;
        }
        // A rate away from the touch has the sign of the rate there only if the way to it cannot turn it.
        if settled || 4.0 * up.abs() * turning < rate.abs() {
            if rate < 0.0 { low = time } else { high = time }
        }
        // A convex height cannot fall by more on the way to the zero of its rate, which lies between `low`
        // and `high`.
        if settled && (rate * (high - low)).abs() <= CLOSE {
            return (Some((height, time)), true);
        }
        if let Some((t, r)) = before
            && t != time
        {
            let secant = (rate - r) / (time - t);
            if secant > 0.0 {
                bend = secant;
            }
        }
        before = Some((time, rate));
        // Where little is left to fall, twice the step: that closes the bracket from the other side, or shows
        // that the bend was too large.
        let closing = (rate * rate / bend).abs() <= CLOSING;
        let mut next = time - rate / bend * if closing { 2.0 } else { 1.0 };
        if !(next >= low && next <= high) {
            // Beyond what is known: to the end if nothing was seen there, else halfway.
            next = match (rate < 0.0, low > begin, high < end) {
                (true, _, false) => end,
                (false, false, _) => begin,
                _ => 0.5 * (low + high),
            };
        }
        height += rate * (next - time) + 0.5 * bend * (next - time) * (next - time);
        time = next;
    }
    (lowest_slowly(ray, piece, body, 0.0), false)
}

/// The same by halving between touches that are each found to the end.
fn lowest_slowly(ray: &NormalLine, piece: &SweptPiece, body: &CutterBody, start: f64) -> Option<(f64, f64)> {
    let [mut a, mut b] = piece.time;
    let (ta, tb) = (touch(ray, piece, body, a, start), touch(ray, piece, body, b, start));
    let (first, last) = match (ta, tb) {
        (Some(x), Some(y)) => (x, y),
        // The body leaves the ray within the piece: it is met again at the middle or nowhere.
        (x, y) => {
            let ends = [(x, a), (y, b)].into_iter().filter_map(|(t, time)| t.map(|t| (t.height, time)));
            let middle = 0.5 * (a + b);
            let at = touch(ray, piece, body, middle, start).map(|t| (t.height, middle));
            return ends.chain(at).min_by(|x, y| x.0.total_cmp(&y.0));
        }
    };
    if first.rate >= 0.0 && last.rate >= 0.0 {
        return Some((first.height, a));
    }
    if first.rate <= 0.0 && last.rate <= 0.0 {
        return Some((last.height, b));
    }
    if first.rate > 0.0 {
        // Only a turning piece has its lowest places at both ends.
        return Some(if first.height <= last.height { (first.height, a) } else { (last.height, b) });
    }
    // The rate is zero between: regula falsi with halving (Illinois).
    let (mut ra, mut rb) = (first.rate, last.rate);
    let mut best = if first.height < last.height { (first.height, a) } else { (last.height, b) };
    let mut side = 0;
    for _ in 0..60 {
        let t = (a * rb - b * ra) / (rb - ra);
        let Some(here) = touch(ray, piece, body, t, best.0) else { break };
        if here.height < best.0 {
            best = (here.height, t);
        }
        // What the height can still fall on the way to the zero of its rate.
        if (here.rate * (b - a)).abs() <= CLOSE {
            break;
        }
        if here.rate < 0.0 {
            (a, ra) = (t, here.rate);
            if side == -1 {
                rb *= 0.5;
            }
            side = -1;
        } else {
            (b, rb) = (t, here.rate);
            if side == 1 {
                ra *= 0.5;
            }
            side = 1;
        }
    }
    Some(best)
}
