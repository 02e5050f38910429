//! A convex part of the tool as the search sees it: distances in its half plane, z from the center O of the
//! cutter's end.

use proveout_tool::{Profile, Segment};

/// Nearer to the skin than this, the way from it gives no normal, mm.
const ON_SKIN_MM: f64 = 1e-12;

/// What the part is made of.
#[derive(Clone, Debug)]
enum ToolPartShape {
    /// Pieces of a generating curve.
    Body(Vec<OutlinePiece>),
    /// A disk across the axis through O with this radius, widened by the rounding: the end of a bull-nose.
    Disk { circle: f64, round: f64 },
}

#[derive(Clone, Copy, Debug)]
enum OutlinePiece {
    Line {
        from: [f64; 2],
        along: [f64; 2],
        length: f64,
    },
    /// Of less than half a turn, counter-clockwise from the unit direction `from` to `to`.
    Arc {
        center: [f64; 2],
        radius: f64,
        from: [f64; 2],
        to: [f64; 2],
    },
}

/// Signed distance of a place from the skin and the direction in which it grows, `[r, z]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Height {
    pub(crate) distance: f64,
    pub(crate) normal: [f64; 2],
}

/// A part with the distances asked for.
#[derive(Clone, Debug)]
pub(crate) struct ToolPart {
    shape: ToolPartShape,
    /// From solids that are cut and from all others, mm.
    pub(crate) needs: [f64; 2],
    /// No point of it is farther from O, mm.
    pub(crate) reach: f64,
    radius: f64,
    low: f64,
    high: f64,
}

impl ToolPart {
    /// A body whose heights count from the tip; O is at `height`.
    pub(crate) fn body(profile: &Profile, height: f64, needs: [f64; 2]) -> Self {
        let mut pieces = Vec::new();
        let mut reach = 0.0_f64;
        for segment in profile.segments() {
            let down = |p: [f64; 2]| [p[0], p[1] - height];
            let (from, to) = (down(segment.from()), down(segment.to()));
            match *segment {
                Segment::Line { .. } => {
                    let d = [to[0] - from[0], to[1] - from[1]];
                    let length = d[0].hypot(d[1]);
                    pieces.push(OutlinePiece::Line { from, along: [d[0] / length, d[1] / length], length });
                    reach = reach.max(from[0].hypot(from[1])).max(to[0].hypot(to[1]));
                }
                Segment::Arc { center, radius, .. } => {
                    let center = down(center);
                    let start = (from[1] - center[1]).atan2(from[0] - center[0]);
                    let end = (to[1] - center[1]).atan2(to[0] - center[0]);
                    let sweep = (end - start).rem_euclid(std::f64::consts::TAU);
                    let count = (sweep / 1.5).ceil().max(1.0);
                    let at = |k: f64| [(start + sweep * k / count).cos(), (start + sweep * k / count).sin()];
                    for k in 0..count as usize {
                        pieces.push(OutlinePiece::Arc { center, radius, from: at(k as f64), to: at((k + 1) as f64) });
                    }
                    reach = reach.max(center[0].hypot(center[1]) + radius);
                }
            }
        }
        let (low, high) = (profile.z_min() - height, profile.z_max() - height);
        Self { shape: ToolPartShape::Body(pieces), needs, reach, radius: profile.max_radius(), low, high }
    }

    /// The end of a bull-nose or flat end mill.
    pub(crate) fn disk(circle: f64, round: f64, needs: [f64; 2]) -> Self {
        let shape = ToolPartShape::Disk { circle, round };
        Self { shape, needs, reach: circle + round, radius: circle + round, low: -round, high: round }
    }

    pub(crate) fn is_disk(&self) -> bool {
        matches!(self.shape, ToolPartShape::Disk { .. })
    }

    /// Distance from the cylinder round the part: never above the distance from the part; 0 inside.
    pub(crate) fn hull_distance(&self, [r, z]: [f64; 2]) -> f64 {
        length([(r - self.radius).max(0.0), (self.low - z).max(z - self.high).max(0.0)])
    }

    /// Support function: the largest `r u + z w` over the part, for a direction with `u >= 0` across the axis
    /// and `w` along it, and where that is.
    pub(crate) fn support(&self, [u, w]: [f64; 2]) -> (f64, [f64; 2]) {
        let value = |p: [f64; 2]| p[0] * u + p[1] * w;
        match &self.shape {
            ToolPartShape::Disk { circle, round } => {
                let p = [circle + round * u, round * w];
                (value(p), p)
            }
            ToolPartShape::Body(pieces) => {
                let mut best = (f64::NEG_INFINITY, [0.0; 2]);
                let mut take = |p: [f64; 2]| {
                    if value(p) > best.0 {
                        best = (value(p), p);
                    }
                };
                for piece in pieces {
                    match *piece {
                        OutlinePiece::Line { from, along, length } => {
                            take(from);
                            take([from[0] + length * along[0], from[1] + length * along[1]]);
                        }
                        OutlinePiece::Arc { center, radius, from, to } => {
                            let on = |n: [f64; 2]| [center[0] + radius * n[0], center[1] + radius * n[1]];
                            take(on(from));
                            take(on(to));
                            let inside = from[0] * w - from[1] * u >= 0.0 && u * to[1] - w * to[0] >= 0.0;
                            if inside {
                                take(on([u, w]));
                            }
                        }
                    }
                }
                best
            }
        }
    }

    /// The height on the axis that is nearest, for a start.
    pub(crate) fn clamp(&self, z: f64) -> f64 {
        z.clamp(self.low, self.high)
    }

    /// Signed distance of `[r, z]`, negative inside.
    pub(crate) fn height(&self, p: [f64; 2]) -> Height {
        match &self.shape {
            ToolPartShape::Disk { circle, round } => {
                let off = [(p[0] - circle).max(0.0), p[1]];
                let d = length(off);
                let normal = if d > 0.0 { [off[0] / d, off[1] / d] } else { [0.0, 1.0] };
                Height { distance: d - round, normal }
            }
            ToolPartShape::Body(pieces) => body_height(pieces, p),
        }
    }
}

fn body_height(pieces: &[OutlinePiece], p: [f64; 2]) -> Height {
    let (mut least, mut outside) = (f64::INFINITY, false);
    let (mut foot, mut skin_normal) = (p, [0.0, 1.0]);
    for piece in pieces {
        let (q, n) = match *piece {
            OutlinePiece::Line { from, along, length } => {
                let t = ((p[0] - from[0]) * along[0] + (p[1] - from[1]) * along[1]).clamp(0.0, length);
                ([from[0] + t * along[0], from[1] + t * along[1]], [along[1], -along[0]])
            }
            OutlinePiece::Arc { center, radius, from, to } => {
                let d = [p[0] - center[0], p[1] - center[1]];
                let after = from[0] * d[1] - from[1] * d[0] >= 0.0;
                let before = d[0] * to[1] - d[1] * to[0] >= 0.0;
                let size = length(d);
                let n = if after && before && size > 0.0 {
                    [d[0] / size, d[1] / size]
                } else if d[0] * (from[0] - to[0]) + d[1] * (from[1] - to[1]) >= 0.0 {
                    from
                } else {
                    to
                };
                ([center[0] + radius * n[0], center[1] + radius * n[1]], n)
            }
        };
        let off = [p[0] - q[0], p[1] - q[1]];
        // Every piece supports the convex body: a point above one of the lines that touch it is outside.
        outside |= off[0] * n[0] + off[1] * n[1] > 0.0;
        let d = length(off);
        if d < least {
            (least, foot, skin_normal) = (d, q, n);
        }
    }
    if outside && least > ON_SKIN_MM {
        Height { distance: least, normal: [(p[0] - foot[0]) / least, (p[1] - foot[1]) / least] }
    } else {
        Height { distance: if outside { least } else { -least }, normal: skin_normal }
    }
}

/// Without the care of `hypot` for the ends of the range of numbers, which lengths of a machine do not come
/// near.
fn length(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

#[cfg(test)]
mod tests {
    use proveout_tool::Cutter;

    use super::*;

    #[test]
    fn distances_are_those_of_the_profiles_and_planes_support_the_body() {
        let bodies = [
            Cutter::ball(12.0).expect("ball").bodies(20.0).expect("bodies"),
            Cutter::bull_nose(20.0, 3.0).expect("bull").bodies(30.0).expect("bodies"),
            Cutter::barrel(12.0, 3.0, 80.0, 25.0).expect("barrel").bodies(25.0).expect("bodies"),
            Cutter::chamfer(8.0, 90.0, 0.0).expect("cone").bodies(10.0).expect("bodies"),
        ];
        for profile in bodies.iter().flatten() {
            let limb = ToolPart::body(profile, 2.0, [0.0; 2]);
            let curve = profile.polyline(1e-4);
            for k in 0..4000 {
                let p = [0.31 * f64::from(k % 77), 0.53 * f64::from(k / 77) - 8.0];
                let found = limb.height([p[0], p[1] - 2.0]);
                let exact = profile.signed_distance(p);
                assert!((found.distance - exact).abs() < 1e-9, "{p:?} {found:?} {exact}");
                assert!(limb.hull_distance([p[0], p[1] - 2.0]) <= exact.max(0.0) + 1e-12);
                assert!((found.normal[0].hypot(found.normal[1]) - 1.0).abs() < 1e-12);
                // No point of the body is above the plane at the foot.
                for q in &curve {
                    for r in [q[0], -q[0]] {
                        let above = (r - p[0]) * found.normal[0] + (q[1] - p[1]) * found.normal[1] + found.distance;
                        assert!(above < 1e-9, "{p:?} {q:?} {above}");
                    }
                    assert!(q[0].hypot(q[1] - 2.0) <= limb.reach + 1e-9);
                }
                let (sine, w) = (0.001 * f64::from(k)).sin_cos();
                let highest = curve.iter().map(|q| q[0] * sine.abs() + (q[1] - 2.0) * w).fold(f64::MIN, f64::max);
                let (support, at) = limb.support([sine.abs(), w]);
                assert!(support >= highest - 1e-9 && support < highest + 0.01, "{support} {highest}");
                assert!(profile.signed_distance([at[0], at[1] + 2.0]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_widened_disk_is_the_end_of_a_bull_nose() {
        let profile = &Cutter::bull_nose(20.0, 3.0).expect("bull").bodies(30.0).expect("bodies")[0];
        let disk = ToolPart::disk(7.0, 3.0, [0.0; 2]);
        for k in 0..400 {
            let p = [0.1 * f64::from(k % 120), -0.25 * f64::from(k / 20)];
            let exact = profile.signed_distance([p[0], p[1] + 3.0]);
            // Below the corner centers the two are one.
            assert!((disk.height(p).distance - exact).abs() < 1e-9 || exact < 0.0, "{p:?} {exact}");
        }
    }
}
