//! Contacts of an edge with the normal of a design point, one a revolution.

use proveout_geom::Vector;

use super::{
    edge::Edge,
    envelope::Ray,
    motion::{Piece, State},
};

/// Steps of Newton's method; from a start within some hundredths of a revolution four do.
const STEPS: usize = 12;
/// End of the search in height, mm.
const CLOSE: f64 = 1e-13;

/// Pieces that follow one another without gap in time, tip and azimuth, each with a height below which it does not come anywhere
/// in the part of the lattice that is searched.
pub(crate) struct Run {
    pub pieces: Vec<Piece>,
    pub floors: Vec<f64>,
    /// Lowest of the floors.
    pub lowest: f64,
    /// Largest jump of velocity (mm/s) and of rotation (rad/s) from one piece to the next, and the shortest piece, s.
    jump: (f64, f64),
    shortest: f64,
}

/// The lowest contact found so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lowest {
    /// mm; infinity without contact.
    pub height: f64,
    /// s.
    pub time: f64,
    /// The motion of the piece, as the caller counts.
    pub motion: u32,
    /// Tooth.
    pub edge: usize,
}

impl Lowest {
    pub(crate) const NONE: Self = Self { height: f64::INFINITY, time: f64::NAN, motion: u32::MAX, edge: usize::MAX };
}

impl Run {
    pub(crate) fn new(pieces: Vec<Piece>, floors: Vec<f64>) -> Self {
        let jump = pieces.windows(2).fold((0.0_f64, 0.0_f64), |a, w| {
            let (v, r) = w[0].jump_to(&w[1]);
            (a.0.max(v), a.1.max(r))
        });
        let shortest = pieces.iter().fold(f64::INFINITY, |a, p| a.min(p.duration()));
        let lowest = floors.iter().copied().fold(f64::INFINITY, f64::min);
        Self { pieces, floors, lowest, jump, shortest }
    }

    /// What the distance from a circle may lose within a span of time beyond what its rate says, mm: jumps at the joints of pieces, and
    /// the acceleration of a resting point in a turning housing, w^2 |q| + 2 w v.
    fn bent(&self, span: f64, piece: &Piece, q: &Vector, speed: f64) -> f64 {
        let turning = piece.spin.norm() + self.jump.1;
        let joints = 1.0 + (span / self.shortest).min(self.pieces.len() as f64);
        let jumps = (self.jump.0 + self.jump.1 * q.norm()) * joints * span;
        jumps + 0.5 * turning * (turning * q.norm() + 2.0 * speed) * span * span
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

    /// The piece of a time, searched from one near it.
    #[inline]
    fn piece_at(&self, time: f64, near: usize) -> usize {
        let mut k = near;
        while k > 0 && time < self.pieces[k].time[0] {
            k -= 1;
        }
        while k + 1 < self.pieces.len() && time > self.pieces[k].time[1] {
            k += 1;
        }
        k
    }

    /// Searches the contacts of edge `index` on both sides of `middle`, and lowers `best`.
    ///
    /// # Why none is lost
    ///
    /// The azimuth of the point as seen in the housing changes by v / rho at most, that of the tooth by the rate of the spindle w. While
    /// w rho > 4 v, their difference is monotone: there is one contact for each whole turn of it. From one contact the next lies one
    /// revolution on, -+ a quarter; there the tooth is lined up with the point by one step, which leaves a few hundredths of that, and
    /// Newton's method in time and height ends at this contact. The march goes outward from the middle in both directions to the ends of
    /// the run. It leaves out pieces whose floor lies above what was found, and revolutions whose circle does not reach below it.
    /// Where the point comes so near to the axis that w rho < 4 v, the revolution is searched by itself ([`Self::near_axis`]).
    pub(crate) fn search(&self, ray: &Ray, edge: &Edge, index: usize, middle: f64, best: &mut Lowest) {
        let middle = middle.clamp(self.begin(), self.end());
        self.march(ray, edge, index, middle, true, best);
        self.march(ray, edge, index, middle, false, best);
    }

    /// Follows the contact of a neighboring point.
    pub(crate) fn follow(&self, ray: &Ray, edge: &Edge, neighbor: &Lowest, best: &mut Lowest) {
        let near = self.piece_of(neighbor.time);
        if let Some((time, height, at)) = self.contact(ray, edge, neighbor.time, neighbor.height, near)
            && height < best.height
            && time >= self.begin()
            && time <= self.end()
        {
            *best = Lowest { height, time, motion: self.pieces[at].motion, edge: neighbor.edge };
        }
    }

    fn piece_of(&self, time: f64) -> usize {
        self.pieces.partition_point(|p| p.time[1] < time).min(self.pieces.len() - 1)
    }

    /// Time from `time` to the next contact forward, or to the last one backward, s; and the piece there.
    fn lag(&self, ray: &Ray, edge: &Edge, time: f64, height: f64, near: usize, forward: bool) -> Option<f64> {
        let piece = &self.pieces[near];
        let w = piece.azimuth_rate;
        if w == 0.0 || !w.is_finite() {
            return None;
        }
        let state = piece.state(time);
        let q = state.point(&(ray.point + ray.normal * height));
        let psi = state.azimuth + edge.azimuth + (q.z - edge.center_height + edge.radius) * edge.lead;
        let turns = ((q.y.atan2(q.x) - psi) / w).rem_euclid(std::f64::consts::TAU / w.abs());
        Some(if forward { turns } else { turns - std::f64::consts::TAU / w.abs() })
    }

    fn march(&self, ray: &Ray, edge: &Edge, index: usize, from: f64, forward: bool, best: &mut Lowest) {
        let (begin, end) = (self.begin(), self.end());
        let mut k = self.piece_of(from);
        let mut begins = Some(from);
        let mut guess = from;
        // What the point's own motion may have put between the guess and a contact, in turns.
        let mut drift = 0.0;
        loop {
            let height = if best.height.is_finite() { best.height } else { 0.0 };
            if let Some(time) = begins.take() {
                let Some(lag) = self.lag(ray, edge, time, height, k, forward) else { return };
                guess = time + lag;
            }
            let turn = std::f64::consts::TAU / self.pieces[k].azimuth_rate.abs();
            // One more beyond the end: its start may lie there while the contact does not.
            if guess > end + 0.25 * turn || guess < begin - 0.25 * turn {
                return;
            }
            let time = guess.clamp(begin, end);
            k = self.piece_at(time, k);
            if self.floors[k] >= best.height {
                // Nothing below the best height as far as the next piece that comes so low.
                let next = if forward {
                    (k + 1..self.pieces.len()).find(|&i| self.floors[i] < best.height)
                } else {
                    (0..k).rev().find(|&i| self.floors[i] < best.height)
                };
                let Some(next) = next else { return };
                k = next;
                begins = Some(self.pieces[k].time[usize::from(!forward)]);
                continue;
            }
            let piece = &self.pieces[k];
            let w = piece.azimuth_rate;
            let turn = if forward { std::f64::consts::TAU / w.abs() } else { -std::f64::consts::TAU / w.abs() };
            let state = piece.state(time);
            let q = state.point(&(ray.point + ray.normal * height));
            let rate = piece.rate(&state, &q);
            let rho2 = q.x * q.x + q.y * q.y;
            let rho = rho2.sqrt();
            // The circle of the edge's arc, turned about the axis: how far the point is outside of it, and how that changes.
            let (side, up) = (rho - edge.center_radius, q.z - edge.center_height);
            let length = (side * side + up * up).sqrt().max(1e-12);
            let gap = length - edge.radius;
            let speed = rate.norm();
            let ratio = speed / (rho * w.abs()).max(1e-300);
            let gap_rate = (side * (q.x * rate.x + q.y * rate.y) / rho.max(1e-300) + up * rate.z) / length;
            // Within half a revolution, wherever the tooth is, the circle does not come to the best height: outside of its ring the
            // distance is convex in time along a straight motion, and its rate bounds what it loses.
            let span = 0.5 * turn.abs();
            let lost =
                if side >= 0.0 { gap_rate.abs() * span + self.bent(span, piece, &q, speed) } else { speed * span };
            if best.height.is_finite() && gap > lost + 1e-9 {
                guess = time + turn;
                drift += ratio;
                if drift > 0.2 {
                    drift = 0.0;
                    let next = time + 0.5 * turn;
                    if next <= begin || next >= end {
                        return;
                    }
                    k = self.piece_at(next, k);
                    begins = Some(next);
                }
                continue;
            }
            if ratio > 0.25 {
                self.near_axis(ray, edge, index, [guess - 0.5 * turn, guess + 0.5 * turn], k, best);
                // Past the axis the point is seen from the other side: count anew from the end of what was searched.
                let next = guess + 0.5 * turn;
                if next <= begin || next >= end {
                    return;
                }
                k = self.piece_at(next, k);
                begins = Some(next);
                continue;
            }
            let residual = edge.residual(&q, state.azimuth);
            // Until the tooth is at the point: the angle between them over the rate at which it changes.
            let seen_rate = (q.x * rate.y - q.y * rate.x) / rho2;
            let step = residual.across.atan2(residual.along) / (w - seen_rate);
            let aligned = time + step;
            drift = 0.0;
            // The circle when the tooth is at the point.
            let gap = gap + gap_rate * step;
            if best.height.is_finite()
                && gap > 0.5 * (gap_rate * step).abs() + self.bent(step.abs(), piece, &q, speed) + 1e-9
            {
                guess = aligned + turn;
                continue;
            }
            guess = aligned + turn;
            if let Some((time, height, at)) = self.contact(ray, edge, aligned, height, k) {
                // Errors of the start do not add up.
                if (time - aligned).abs() < 0.5 * turn.abs() {
                    guess = time + turn;
                }
                if height < best.height && time >= begin && time <= end {
                    *best = Lowest { height, time, motion: self.pieces[at].motion, edge: index };
                }
            }
        }
    }

    /// Newton's method in time and height from a start near a contact.
    fn contact(&self, ray: &Ray, edge: &Edge, time: f64, height: f64, near: usize) -> Option<(f64, f64, usize)> {
        let (mut t, mut h, mut k) = (time, height, near);
        let mut reach = 0.0;
        for _ in 0..STEPS {
            k = self.piece_at(t, k);
            let piece = &self.pieces[k];
            let state = piece.state(t);
            let (residual, [pt, at], [ph, ah]) = derivatives(ray, edge, piece, &state, h);
            let det = pt * ah - ph * at;
            if det.abs() < 1e-12 {
                return None;
            }
            let dt = -(residual.plane * ah - ph * residual.arc) / det;
            let dh = -(pt * residual.arc - at * residual.plane) / det;
            t += dt;
            // A step larger than the arc has left it; come back slowly.
            h += dh.clamp(-0.5 * edge.radius, 0.5 * edge.radius);
            reach = f64::max(reach, dh.abs());
            if dh.abs() <= CLOSE * (1.0 + h.abs()) && (dt * piece.azimuth_rate).abs() < 1e-11 {
                // Coming from inside of the design the arc is entered, on the side of the tooth, in its range.
                let entered = ah < 0.0;
                return (entered && (residual.along >= 0.0 || residual.side >= 0.0) && edge.holds(&residual))
                    .then_some((t, h, k));
            }
        }
        None
    }

    /// Contacts in one revolution of a point near the axis.
    ///
    /// Here the tooth passes the point at a speed like that of the feed, perhaps several times or not at all. In coordinates across
    /// the tooth the point moves on a circle of radius rho about a slowly moving center, so that its distance from the plane of the
    /// edge is nearly a sine of one period: each change of its sign over 32 parts of the revolution is followed. Two contacts within one
    /// such part, where the distance touches zero, are seen as none; this concerns points within 4 v / w of the path of the axis
    /// (half of the feed a revolution), and only cutters whose axis stands on the surface.
    fn near_axis(&self, ray: &Ray, edge: &Edge, index: usize, span: [f64; 2], near: usize, best: &mut Lowest) {
        const PARTS: usize = 32;
        let (begin, end) = (self.begin(), self.end());
        let (from, to) = (span[0].min(span[1]).max(begin), span[0].max(span[1]).min(end));
        if from >= to {
            return;
        }
        let start = if best.height.is_finite() { best.height } else { 0.0 };
        let at = |i: usize| from + (to - from) * i as f64 / PARTS as f64;
        let plane = |t: f64| {
            let piece = &self.pieces[self.piece_at(t, near)];
            derivatives(ray, edge, piece, &piece.state(t), start).0.plane
        };
        let mut last = plane(from);
        for i in 1..=PARTS {
            let value = plane(at(i));
            if last * value <= 0.0 {
                let (mut a, mut b) = (at(i - 1), at(i));
                for _ in 0..30 {
                    let m = 0.5 * (a + b);
                    if plane(m) * last > 0.0 { a = m } else { b = m }
                }
                if let Some((time, height, piece)) = self.contact(ray, edge, 0.5 * (a + b), start, near)
                    && height < best.height
                    && time >= begin
                    && time <= end
                {
                    *best = Lowest { height, time, motion: self.pieces[piece].motion, edge: index };
                }
            }
            last = value;
        }
    }
}

#[inline]
fn derivatives(
    ray: &Ray,
    edge: &Edge,
    piece: &Piece,
    state: &State,
    height: f64,
) -> (super::edge::Residual, [f64; 2], [f64; 2]) {
    let q: Vector = state.point(&(ray.point + ray.normal * height));
    let residual = edge.residual(&q, state.azimuth);
    let by_time = residual.along_rate(&piece.rate(state, &q), piece.azimuth_rate);
    let by_height = residual.along_rate(&state.direction(&ray.normal), 0.0);
    (residual, by_time, by_height)
}
