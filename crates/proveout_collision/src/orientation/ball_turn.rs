//! One free angle: at which angles of a turn about a direction the tool is free, for all ball centers near
//! one.
//!
//! A table turns the tool axis on a circle of equal inclination to its own, `V(a) = c (b_0 cos a + b_1 sin
//! a) + s b_2`, while the center Q of a ball end is held. A ball of the solids' tree that is seen from Q
//! under the direction u, at the distance r, with the radius rho, forbids axes that are nearer to u than `h
//! = hi(r - rho .. r + rho) + asin(rho / r)` (`extent.rs`), and those of the circle among them are
//!
//! ```text
//!   c p cos(a - f) + s (b_2 . u) >= cos h        p, f: length and angle of u in the plane of b_0 and b_1
//! ```
//!
//! an interval about f. All that is forbidden is the union of these intervals, so that no cells of angles are
//! needed: a ball whose interval lies in the union adds nothing, one that does not is opened, and what is
//! small is added as it is. Skin points that are surely too near (`in` of `extent.rs`) fill the union early.
//! What is left is free, with proof; what is added is too much by no more than the angle under which the
//! smallest pieces are seen.
//!
//! *All centers within a distance d of Q*: a place then moves against the tool by at most d, so that every
//! ball is taken as larger by d. *All axes within an angle of the circle*: h grows by it. With both, one call
//! holds for a whole block of a program, at whose middle it is made.

use std::f64::consts::{PI, TAU};

use proveout_geom::{AxisTurn, Point, Vector};

use super::BALL_ROUNDING;
use super::extent::Extent;
use super::obstacle_solids::{ObstacleSolid, closest};
use super::space::OrientationSpace;

/// Pieces seen under a smaller angle than this are not divided, radian: half a degree.
const FINE: f64 = 0.008;
/// Nor those that are smaller than this part of the distance that centers may be off.
const OF_DRIFT: f64 = 0.5;
/// Nor those seen under less than the axes that are meant are off: what they add too much is no more than
/// that.
const OF_SPREAD: f64 = 1.0;
/// A piece under this angle at most that makes the union larger by less than the other is added as it is,
/// radian.
const SMALL: f64 = 0.06;
const HARDLY: f64 = 0.004;
/// Rounding, radian.
const ROUNDING: f64 = 1e-9;
/// A place this near to the center has no direction, mm.
const CENTER_MM: f64 = 1e-9;
/// Angles begin on the axis where their largest cosine is less than one by no more than this.
const ON_AXIS: f64 = 1e-9;
/// Vectors of a basis may be this far from length one.
const UNIT: f64 = 1e-9;

/// Angles from 0 to a turn, in order and apart.
#[derive(Debug, Default)]
struct Union(Vec<[f64; 2]>);

impl Union {
    /// Pieces of an interval within 0 .. a turn.
    fn pieces(middle: f64, half: f64) -> [Option<[f64; 2]>; 2] {
        if half >= PI {
            return [Some([0.0, TAU]), None];
        }
        let from = (middle - half).rem_euclid(TAU);
        let to = from + 2.0 * half;
        if to <= TAU { [Some([from, to]), None] } else { [Some([from, TAU]), Some([0.0, to - TAU])] }
    }

    /// What of an interval is not in the union, radian.
    fn missing(&self, middle: f64, half: f64) -> f64 {
        Self::pieces(middle, half)
            .into_iter()
            .flatten()
            .map(|[a, b]| {
                let held: f64 = self.0.iter().map(|[x, y]| (b.min(*y) - a.max(*x)).max(0.0)).sum();
                b - a - held
            })
            .sum()
    }

    fn add(&mut self, middle: f64, half: f64) {
        for [mut a, mut b] in Self::pieces(middle, half).into_iter().flatten() {
            self.0.retain(|[x, y]| {
                let apart = *y < a || *x > b;
                if !apart {
                    (a, b) = (a.min(*x), b.max(*y));
                }
                apart
            });
            let at = self.0.partition_point(|[x, _]| *x < a);
            self.0.insert(at, [a, b]);
        }
    }

    fn is_whole(&self) -> bool {
        matches!(self.0.as_slice(), [[a, b]] if *a <= 0.0 && *b >= TAU)
    }

    /// What is not in the union: intervals that begin in -pi .. pi.
    fn rest(&self) -> Vec<[f64; 2]> {
        let (Some(first), Some(last)) = (self.0.first(), self.0.last()) else { return vec![[-PI, PI]] };
        let mut out: Vec<[f64; 2]> = self.0.windows(2).map(|w| [w[0][1], w[1][0]]).collect();
        out.push([last[1], first[0] + TAU]);
        let mut out: Vec<[f64; 2]> = out
            .into_iter()
            .filter(|[a, b]| b - a > ROUNDING)
            .map(|[a, b]| {
                let off = TAU * ((a + PI) / TAU).floor();
                [a - off, b - off]
            })
            .collect();
        out.sort_by(|a, b| a[0].total_cmp(&b[0]));
        out
    }
}

/// The search at one center.
struct TurnSearch<'a> {
    turn: &'a AxisTurn,
    /// Cosine of the inclination.
    across: f64,
    extent: &'a Extent,
    union: Union,
}

impl TurnSearch<'_> {
    /// Middle and half width of the angles whose axes are nearer to a direction than an angle; none where
    /// there are none.
    fn near(&self, direction: &Vector, angle: f64) -> Option<(f64, f64)> {
        let [x, y, z] = self.turn.basis.map(|b| b.dot(direction));
        let size = self.across * x.hypot(y);
        if angle >= PI {
            return Some((0.0, PI));
        }
        let room = angle.cos() - self.turn.axial * z;
        if room > size {
            return None;
        }
        let half = if room <= -size { PI } else { (room / size).acos() };
        Some((y.atan2(x), (half + ROUNDING).min(PI)))
    }

    /// What a ball round a place forbids: middle and half width, and half the angle under which the ball is
    /// seen, without drift.
    fn forbidden(&self, center: &Point, radius: f64) -> Option<((f64, f64), f64)> {
        let from = center - self.turn.center;
        let r = from.norm();
        let wide = radius + self.turn.drift;
        let [_, high] = self.extent.outer((r - wide).max(0.0), r + wide)?;
        let seen = |radius: f64| if radius < r { (radius / r).asin() } else { PI };
        let angle = high.clamp(-1.0, 1.0).acos() + seen(wide) + self.turn.spread + ROUNDING;
        // A place at the center itself has no direction; everything is forbidden.
        let interval = if r > CENTER_MM { self.near(&(from / r), angle)? } else { (0.0, PI) };
        Some((interval, seen(radius)))
    }

    /// Takes a place that is surely too near.
    fn take_inner(&mut self, place: &Point) {
        let from = place - self.turn.center;
        let r = from.norm();
        if r <= CENTER_MM {
            return;
        }
        // Angles from the axis on: a ring would leave out its middle.
        if let Some([low, high]) = self.extent.inner(r).filter(|[low, _]| *low >= 1.0 - ON_AXIS)
            && let Some((middle, half)) = self.near(&(from / r), high.clamp(-low, low).acos())
        {
            self.union.add(middle, half);
        }
    }

    /// Whether a ball is dealt with: it forbids nothing new, or it is small and what it forbids was added.
    fn settled(&mut self, center: &Point, radius: f64) -> bool {
        let Some(((middle, half), seen)) = self.forbidden(center, radius) else { return true };
        let missing = self.union.missing(middle, half);
        if missing <= ROUNDING {
            return true;
        }
        let fine = seen <= FINE.max(OF_SPREAD * self.turn.spread) || radius <= OF_DRIFT * self.turn.drift;
        if fine || seen <= SMALL && missing <= HARDLY {
            self.union.add(middle, half);
            return true;
        }
        false
    }

    fn take(&mut self, solid: &ObstacleSolid) {
        let mut stack = vec![0_u32];
        let mut pieces: Vec<[Point; 3]> = Vec::new();
        while let Some(node) = stack.pop().and_then(|i| solid.nodes.get(i as usize)) {
            if self.union.is_whole() {
                return;
            }
            if self.settled(&node.center, node.radius) {
                continue;
            }
            self.take_inner(&node.anchor);
            if !node.leaf {
                // The nearer one first: it forbids most.
                let far = |i: u32| {
                    solid.nodes.get(i as usize).map_or(0.0, |n| (n.center - self.turn.center).norm() - n.radius)
                };
                let (a, b) = (node.first, node.first + 1);
                stack.extend(if far(a) < far(b) { [b, a] } else { [a, b] });
                continue;
            }
            pieces.push(solid.triangles[node.first as usize]);
            while let Some(piece) = pieces.pop() {
                let [a, b, c] = piece;
                let center = Point::from((a.coords + b.coords + c.coords) / 3.0);
                let radius = piece.iter().map(|p| (p - center).norm()).fold(0.0, f64::max) * (1.0 + BALL_ROUNDING)
                    + BALL_ROUNDING;
                if self.settled(&center, radius) {
                    continue;
                }
                self.take_inner(&closest(&piece, &self.turn.center));
                let [d, e, f] = [nalgebra::center(&a, &b), nalgebra::center(&b, &c), nalgebra::center(&c, &a)];
                pieces.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
            }
        }
    }
}

impl OrientationSpace {
    /// Angles of a turn at which neck, shank, holder and the cutter above its ball are free, proved:
    /// intervals `[from, to]` in radian, in order and apart, `from` in -pi .. pi, `to` at most a turn above;
    /// `[-pi, pi]` where all are. Whether the ball itself goes too deep is not asked: no angle changes that.
    /// None for a cutter without a ball end, and for numbers that make no turn.
    pub fn free_turns(&self, turn: &AxisTurn) -> Option<Vec<[f64; 2]>> {
        let extents = self.extents.as_ref()?;
        let finite = turn.center.coords.iter().chain(turn.basis.iter().flat_map(|b| b.iter())).all(|v| v.is_finite());
        let unit = turn.basis.iter().all(|b| (b.norm() - 1.0).abs() < UNIT);
        let known = turn.drift >= 0.0 && turn.drift.is_finite() && turn.spread >= 0.0 && turn.axial.abs() < 1.0;
        if !(finite && unit && known) {
            return None;
        }
        let across = (1.0 - turn.axial * turn.axial).sqrt();
        let mut union = Union::default();
        for solid in &self.solids {
            let mut turning = TurnSearch { turn, across, extent: &extents[usize::from(!solid.cut)], union };
            turning.take(solid);
            union = turning.union;
        }
        Some(union.rest())
    }
}
