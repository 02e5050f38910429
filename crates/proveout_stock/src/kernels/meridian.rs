//! A profile compiled for the sweep: one convex function whose zero set is the body.
//!
//! A convex body of revolution is the intersection of the bodies of its supporting lines in the half plane
//! (r, z). With the outward normals `n(u)` of the generating curve and its support function `h`,
//!
//! ```text
//!     F(r, z) = max over u of  n_r(u) r + n_z(u) z - h(u)          n_r >= 0 on a convex body of revolution
//!
//!       z ^    ____ plane: F = z - c
//!         |   |    \   cone: F = n . p - c
//!         |   |     |  cylinder: F = r - c
//!         |   |    /
//!         |   |___/    arc: F = |p - center| - radius where p lies in the sector of the arc's normals,
//!         +-----------> r                    the tangent line at the nearer end elsewhere
//! ```
//!
//! is zero on the skin, negative inside and positive outside. In space `r` is a convex function of the point
//! and `n_r` is not negative, so F is convex; its gradient is a unit vector, so F never exceeds the distance,
//! equals it wherever the nearest skin point is smooth, and its value and gradient at any point give a half
//! space that holds the whole body. The sweep needs nothing else from a body.

use proveout_tool::{Profile, Segment};

/// The body is taken smaller by this (mm), so that a body that only touches a face overlaps nothing.
pub(crate) const TOUCH: f64 = 1e-7;
/// Square of the distance from the center of an arc below which no direction leads away from it, mm^2.
pub(crate) const AT_CENTER: f64 = 1e-24;
/// A face is the end of an arc when their normals, and their supports, mm, differ by less.
const SAME_NORMAL: f64 = 1e-12;
const SAME_SUPPORT: f64 = 1e-11;
/// A corner lies in a tube, a center on the axis and a ball in its body within this, mm: rounding of the
/// outline.
const WITHIN: f64 = 1e-9;
/// Normals that differ by more jump: an edge is between them.
const JUMP: f64 = 1e-6;

#[derive(Clone, Copy, Debug)]
pub(crate) enum MeridianPiece {
    /// Normal and support.
    Line { nr: f64, nz: f64, c: f64 },
    /// Arc with its first and last normal.
    Arc { center: [f64; 2], radius: f64, first: [f64; 2], last: [f64; 2] },
}

impl MeridianPiece {
    fn of(s: &Segment) -> Self {
        match *s {
            Segment::Line { from, to } => {
                let (dr, dz) = (to[0] - from[0], to[1] - from[1]);
                let length = dr.hypot(dz);
                // Counter-clockwise travel: the outside is on the right.
                let (nr, nz) = (dz / length, -dr / length);
                Self::Line { nr: nr.max(0.0), nz, c: nr * from[0] + nz * from[1] - TOUCH }
            }
            Segment::Arc { center, radius, from, to } => {
                let normal = |p: [f64; 2]| {
                    let (r, z) = (p[0] - center[0], p[1] - center[1]);
                    let length = r.hypot(z);
                    [(r / length).max(0.0), z / length]
                };
                Self::Arc { center, radius: radius - TOUCH, first: normal(from), last: normal(to) }
            }
        }
    }

    /// Value and gradient (d/dr, d/dz).
    #[inline]
    pub(crate) fn eval(&self, r: f64, z: f64) -> (f64, f64, f64) {
        match *self {
            Self::Line { nr, nz, c } => (nr * r + nz * z - c, nr, nz),
            Self::Arc { center, radius, first, last } => {
                let (x, y) = (r - center[0], z - center[1]);
                if first[0] * y - first[1] * x >= 0.0 && x * last[1] - y * last[0] >= 0.0 {
                    let square = x * x + y * y;
                    if square > AT_CENTER {
                        let length = square.sqrt();
                        let inverse = 1.0 / length;
                        return (length - radius, x * inverse, y * inverse);
                    }
                }
                let (a, b) = (first[0] * x + first[1] * y, last[0] * x + last[1] * y);
                if a > b { (a - radius, first[0], first[1]) } else { (b - radius, last[0], last[1]) }
            }
        }
    }
}

/// Leaves out the lines that continue an arc: its tangents at its ends are the same.
fn needed(pieces: Vec<MeridianPiece>) -> Vec<MeridianPiece> {
    let arcs: Vec<MeridianPiece> = pieces.iter().filter(|p| matches!(p, MeridianPiece::Arc { .. })).copied().collect();
    let mut kept = pieces;
    kept.retain(|piece| {
        let MeridianPiece::Line { nr, nz, c } = *piece else { return true };
        !arcs.iter().any(|arc| {
            let MeridianPiece::Arc { center, radius, first, last } = *arc else { return false };
            [first, last].iter().any(|n| {
                let support = n[0] * center[0] + n[1] * center[1] + radius;
                (n[0] - nr).hypot(n[1] - nz) < SAME_NORMAL && (support - c).abs() < SAME_SUPPORT
            })
        })
    });
    kept
}

/// Arcs as tubes, and the corners that no arc rounds.
fn tubes(segments: &[Segment]) -> Vec<[f64; 4]> {
    let mut tubes: Vec<[f64; 4]> = Vec::new();
    for s in segments {
        if let Segment::Arc { center, radius, .. } = *s {
            // A point of the tube is one of its circle and the radius along the normal; where the center lies
            // beyond the axis there is no such circle, and the points of the arc count.
            let reach = if center[0] >= 0.0 {
                center[0].hypot(center[1])
            } else {
                (center[0] + radius).max(0.0).hypot(s.from()[1].abs().max(s.to()[1].abs()))
            };
            tubes.push([center[0], center[1], radius, reach]);
        }
    }
    for p in segments.iter().flat_map(|s| [s.from(), s.to()]) {
        let inside = |t: &[f64; 4]| (p[0] - t[0]).hypot(p[1] - t[1]) <= t[2] + WITHIN;
        if !tubes.iter().any(inside) {
            tubes.push([p[0], p[1], 0.0, p[0].hypot(p[1])]);
        }
    }
    // What lies in the hull of another is of no interest: its support is nowhere larger, on the outside where
    // the sine is not negative.
    let mut kept: Vec<[f64; 4]> = Vec::new();
    for (k, a) in tubes.iter().enumerate() {
        let within = |b: &[f64; 4]| {
            let (r, z) = (a[0] - b[0], a[1] - b[1]);
            (if r > 0.0 { r.hypot(z) } else { z.abs() }) <= b[2] - a[2] && a[3] <= b[3]
        };
        let in_other = tubes.iter().enumerate().any(|(i, b)| i != k && within(b) && (i < k || *a != *b));
        if !in_other {
            kept.push(*a);
        }
    }
    kept
}

/// An arc from straight down to straight out, as that of a bull-nose; the other pieces of a body
/// are evaluated separately.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quarter {
    pub center: [f64; 2],
    pub radius: f64,
    /// Height below which the arc alone makes the function, mm.
    pub alone_below: f64,
}

impl Quarter {
    /// The first such arc, and the other pieces.
    fn of(pieces: &[MeridianPiece]) -> (Option<Self>, Vec<MeridianPiece>) {
        let arc = |p: &MeridianPiece| match *p {
            MeridianPiece::Arc { center, radius, first, last } if first == [0.0, -1.0] && last == [1.0, 0.0] => {
                Some((center, radius))
            }
            _ => None,
        };
        let Some((at, (center, radius))) = pieces.iter().enumerate().find_map(|(k, p)| Some((k, arc(p)?))) else {
            return (None, pieces.to_vec());
        };
        let mut others = pieces.to_vec();
        others.remove(at);
        // The arc's function is nowhere below that of its last tangent on the axis; a plane across the axis
        // stays below that as far from itself.
        let deepest = -center[0] - radius;
        let alone_below = others.iter().fold(f64::INFINITY, |below, p| match *p {
            MeridianPiece::Line { nr: 0.0, nz: 1.0, c } => below.min(c + deepest),
            _ => f64::NEG_INFINITY,
        });
        (Some(Self { center, radius, alone_below }), others)
    }
}

/// The convex function of a body, and the ball that makes up its lower end if there is one.
#[derive(Clone, Debug)]
pub(crate) struct Meridian {
    pub pieces: Vec<MeridianPiece>,
    /// A quarter of a circle among them, and the others.
    pub quarter: Option<Quarter>,
    pub others: Vec<MeridianPiece>,
    /// Circles about the axis, (r, z, radius, reach): the support function of the body is at most the largest
    /// of `r sin + z cos + radius`. Reach: how far from the tip a point is that turning moves off the chord
    /// of its way, mm.
    pub tubes: Vec<[f64; 4]>,
    /// Height of the center and radius of a ball that lies in the body and holds all of it below `pieces`.
    pub ball: Option<[f64; 2]>,
    /// False when the ball is all there is.
    pub has_rest: bool,
    /// Largest radius, lowest and highest point, mm.
    pub radius: f64,
    pub z: [f64; 2],
    /// Lowest point of what `pieces` describe, mm.
    pub rest_z: f64,
    /// Largest distance of a point of the body from the tip, mm.
    pub reach: f64,
    /// Heights between which the skin has no edge (mm), and the largest curvature of the meridian there
    /// (1/mm).
    pub smooth: [f64; 2],
    pub bend: f64,
}

/// Distance from an edge beyond which F is smooth as far as 0.01 mm off the skin, mm: the ridge of F at an
/// edge runs along the bisector of both normals, whose angle with either is below 84 degrees on a body of
/// more than a knife's edge.
const EDGE: f64 = 0.1;

/// The widest range of heights without edges, `EDGE` away from them, and the largest curvature of the
/// meridian.
fn smooth(segments: &[Segment]) -> ([f64; 2], f64) {
    let normals: Vec<[[f64; 2]; 2]> = segments
        .iter()
        .map(|s| match MeridianPiece::of(s) {
            MeridianPiece::Line { nr, nz, .. } => [[nr, nz]; 2],
            MeridianPiece::Arc { first, last, .. } => [first, last],
        })
        .collect();
    let jumps = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) > JUMP;
    let mut edges: Vec<f64> = Vec::new();
    for (k, s) in segments.iter().enumerate() {
        let before = if k > 0 { normals[k - 1][1] } else { [0.0, -1.0] };
        if jumps(before, normals[k][0]) {
            edges.push(s.from()[1]);
        }
    }
    if let (Some(s), Some(n)) = (segments.last(), normals.last())
        && jumps(n[1], [0.0, 1.0])
    {
        edges.push(s.to()[1]);
    }
    edges.sort_by(f64::total_cmp);
    let bend = segments.iter().fold(0.0, |bend: f64, s| match s {
        Segment::Arc { radius, .. } => bend.max(1.0 / radius),
        Segment::Line { .. } => bend,
    });
    let (low, high) = (segments.first().map_or(0.0, |s| s.from()[1]), segments.last().map_or(0.0, |s| s.to()[1]));
    let (mut best, mut width) = ([f64::INFINITY, f64::NEG_INFINITY], 0.0);
    for k in 0..=edges.len() {
        let from = if k > 0 { edges[k - 1] } else { f64::NEG_INFINITY };
        let to = edges.get(k).copied().unwrap_or(f64::INFINITY);
        if to.min(high) - from.max(low) > width {
            (best, width) = ([from + EDGE, to - EDGE], to.min(high) - from.max(low));
        }
    }
    (best, bend)
}

impl Meridian {
    /// The whole body as one function.
    pub(crate) fn whole(profile: &Profile) -> Self {
        let (smooth, bend) = smooth(profile.segments());
        let pieces = needed(profile.segments().iter().map(MeridianPiece::of).collect());
        let (quarter, others) = Quarter::of(&pieces);
        Self {
            smooth,
            bend,
            pieces,
            quarter,
            others,
            tubes: tubes(profile.segments()),
            ball: None,
            has_rest: true,
            radius: profile.max_radius(),
            z: [profile.z_min(), profile.z_max()],
            rest_z: profile.z_min(),
            reach: profile.max_radius().hypot(profile.z_min().abs().max(profile.z_max().abs())),
        }
    }

    /// The body with a ball end split off, whose sweep has a closed form.
    pub(crate) fn split(profile: &Profile) -> Self {
        let whole = Self::whole(profile);
        let Some(Segment::Arc { center, radius, to, .. }) = profile.segments().first() else { return whole };
        // The whole ball must lie in the body: its support may not pass that of any other piece.
        let mut pieces: Vec<MeridianPiece> = profile.segments()[1..].iter().map(MeridianPiece::of).collect();
        let inside = pieces.iter().all(|p| p.eval(0.0, center[1]).0 <= -radius + WITHIN + TOUCH);
        if center[0].abs() > WITHIN || !inside {
            return whole;
        }
        let has_rest = !pieces.is_empty();
        pieces.push(MeridianPiece::Line { nr: 0.0, nz: -1.0, c: -to[1] });
        let tubes = tubes(&profile.segments()[1..]);
        // The plane that closes the rest below makes an edge.
        let smooth = [whole.smooth[0].max(to[1] + EDGE), whole.smooth[1]];
        let pieces = needed(pieces);
        let (quarter, others) = Quarter::of(&pieces);
        Self {
            pieces,
            quarter,
            others,
            tubes,
            ball: Some([center[1], radius - TOUCH]),
            has_rest,
            rest_z: to[1],
            smooth,
            ..whole
        }
    }

    /// Value and gradient (d/dr, d/dz) at r >= 0.
    #[inline]
    pub(crate) fn eval(&self, r: f64, z: f64) -> (f64, f64, f64) {
        let mut best = (f64::NEG_INFINITY, 0.0, 1.0);
        for p in &self.pieces {
            let here = p.eval(r, z);
            if here.0 > best.0 {
                best = here;
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bull() -> Profile {
        Profile::new(vec![
            Segment::Line { from: [0.0, 0.0], to: [2.0, 0.0] },
            Segment::Arc { center: [2.0, 3.0], radius: 3.0, from: [2.0, 0.0], to: [5.0, 3.0] },
            Segment::Line { from: [5.0, 3.0], to: [5.0, 30.0] },
            Segment::Line { from: [5.0, 30.0], to: [0.0, 30.0] },
        ])
        .expect("convex")
    }

    #[test]
    fn the_function_is_the_distance_off_the_edges_and_has_its_sign_everywhere() {
        let profile = bull();
        let m = Meridian::whole(&profile);
        for k in 0..4000 {
            let p = [f64::from(k % 63) * 0.13, f64::from(k / 63) * 0.6 - 3.0];
            let (f, nr, nz) = m.eval(p[0], p[1]);
            let d = profile.signed_distance(p);
            assert!(f <= d + 2e-7 || d < 0.0, "F must not pass the distance at {p:?}: {f} {d}");
            assert!((f > 1e-6) == (d > 1e-6), "sign at {p:?}: {f} {d}");
            assert!((nr.hypot(nz) - 1.0).abs() < 1e-12);
            if p[1] < 30.0 {
                assert!((f - d).abs() < 2e-7, "at {p:?}: {f} {d}");
            }
        }
    }

    #[test]
    fn lines_beside_an_arc_are_left_out_and_edges_end_the_smooth_range() {
        let m = Meridian::whole(&bull());
        // The arc covers the bottom and the side; the top has an edge.
        assert_eq!(m.pieces.len(), 2);
        assert_eq!(m.tubes.len(), 2);
        assert_eq!((m.smooth[0], m.smooth[1], m.bend), (f64::NEG_INFINITY, 30.0 - EDGE, 1.0 / 3.0));
        let corner = Segment::Line { from: [0.0, 0.0], to: [5.0, 0.0] };
        let flat = Profile::new(vec![
            corner,
            Segment::Line { from: [5.0, 0.0], to: [5.0, 30.0] },
            Segment::Line { from: [5.0, 30.0], to: [0.0, 30.0] },
        ])
        .expect("convex");
        assert_eq!(Meridian::whole(&flat).smooth, [EDGE, 30.0 - EDGE]);
    }

    #[test]
    fn only_a_ball_that_fits_is_split_off() {
        let ball = |length: f64| {
            Profile::new(vec![
                Segment::Arc { center: [0.0, 4.0], radius: 4.0, from: [0.0, 0.0], to: [4.0, 4.0] },
                Segment::Line { from: [4.0, 4.0], to: [4.0, length] },
                Segment::Line { from: [4.0, length], to: [0.0, length] },
            ])
            .expect("convex")
        };
        assert!(Meridian::split(&ball(20.0)).ball.is_some());
        assert!(Meridian::split(&ball(6.0)).ball.is_none());
        assert!(Meridian::split(&bull()).ball.is_none());
    }
}
