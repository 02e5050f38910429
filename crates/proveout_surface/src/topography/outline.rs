//! Signed distance to a convex body of revolution, in its meridian half plane (r, z).

use proveout_tool::{Profile, Segment};

use super::{AT_CENTER, edge::Edge};

/// Length by which a line is divided at least, mm.
const SHORTEST: f64 = 1e-12;
/// Nearer to a corner than this the way from it leads down, mm.
const AT_CORNER: f64 = 1e-12;

/// What bounds a cutter from outside.
#[derive(Clone, Debug)]
pub(crate) enum CutterBody {
    /// The nominal cutter.
    Outline(CutterOutline),
    /// A convex body that holds the circles of all edges: everything within `radius` of the disc and cylinder
    /// above (r <= center radius, z >= center height).
    Corner { center_radius: f64, center_height: f64, radius: f64 },
    /// The same for arcs with centers beyond the axis (barrels): the arc alone, turned.
    Barrel { center_radius: f64, center_height: f64, radius: f64 },
}

impl CutterBody {
    /// The body that holds all edges; none without edges.
    pub(crate) fn of_edges(edges: &[Edge]) -> Option<Self> {
        let first = edges.first()?;
        let radius = edges.iter().fold(first.radius, |a, e| a.max(e.radius + e.margin()));
        let center_radius = edges.iter().fold(first.center_radius, |a, e| a.max(e.center_radius));
        let low = edges.iter().fold(first.center_height, |a, e| a.min(e.center_height));
        let high = edges.iter().fold(first.center_height, |a, e| a.max(e.center_height));
        Some(if center_radius >= -0.5 * radius {
            Self::Corner { center_radius: center_radius.max(0.0), center_height: low, radius }
        } else {
            Self::Barrel { center_radius, center_height: 0.5 * (low + high), radius: radius + 0.5 * (high - low) }
        })
    }

    pub(crate) fn smallest_radius(&self) -> f64 {
        match self {
            Self::Outline(outline) => outline.smallest_radius,
            Self::Corner { radius, .. } | Self::Barrel { radius, .. } => *radius,
        }
    }

    /// Signed distance (mm, positive outside) and its gradient; inside it may be larger than the true one,
    /// but never positive.
    #[inline]
    pub(crate) fn distance(&self, r: f64, z: f64) -> (f64, [f64; 2]) {
        let from = |dr: f64, dz: f64, radius: f64| {
            let length = (dr * dr + dz * dz).sqrt();
            (length - radius, if length > AT_CENTER { [dr / length, dz / length] } else { [0.0, 0.0] })
        };
        match *self {
            Self::Outline(ref outline) => outline.distance(r, z),
            Self::Corner { center_radius, center_height, radius } => {
                from((r - center_radius).max(0.0), (z - center_height).min(0.0), radius)
            }
            Self::Barrel { center_radius, center_height, radius } => from(r - center_radius, z - center_height, radius),
        }
    }
}

/// A generating curve made ready: each part with the wedge or strip of the half plane that is nearest to it.
#[derive(Clone, Debug)]
pub(crate) struct CutterOutline {
    parts: Vec<OutlinePart>,
    /// Smallest radius of curvature of a rounded part below the widest place, mm; infinity without one.
    pub smallest_radius: f64,
}

#[derive(Clone, Copy, Debug)]
enum OutlinePart {
    Line { from: [f64; 2], along: [f64; 2], length: f64, normal: [f64; 2] },
    Arc { center: [f64; 2], radius: f64, first: [f64; 2], last: [f64; 2], from: [f64; 2], to: [f64; 2] },
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

impl CutterOutline {
    pub(crate) fn new(profile: &Profile) -> Self {
        let mut smallest_radius = f64::INFINITY;
        let parts = profile
            .segments()
            .iter()
            .map(|segment| match *segment {
                Segment::Line { from, to } => {
                    let (dx, dz) = (to[0] - from[0], to[1] - from[1]);
                    let length = dx.hypot(dz).max(SHORTEST);
                    let along = [dx / length, dz / length];
                    // The curve runs counter-clockwise: the body lies to the left.
                    OutlinePart::Line { from, along, length, normal: [along[1], -along[0]] }
                }
                Segment::Arc { center, radius, from, to } => {
                    smallest_radius = smallest_radius.min(radius);
                    let ray = |p: [f64; 2]| [(p[0] - center[0]) / radius, (p[1] - center[1]) / radius];
                    OutlinePart::Arc { center, radius, first: ray(from), last: ray(to), from, to }
                }
            })
            .collect();
        Self { parts, smallest_radius }
    }

    /// Signed distance (mm, positive outside) of a point of the half plane and its gradient.
    ///
    /// Outside of a convex curve one part, or a corner of two, is nearest, and the point lies on the outer
    /// side of a line, of an arc in its wedge, or of the tangent at an end; inside, the largest of the
    /// distances to the parts whose wedge holds the point.
    #[inline]
    pub(crate) fn distance(&self, r: f64, z: f64) -> (f64, [f64; 2]) {
        let mut best = (f64::NEG_INFINITY, [0.0, -1.0]);
        let mut corner = (f64::INFINITY, [0.0, -1.0]);
        let mut outside = false;
        for part in &self.parts {
            let (own, side, end) = part.at(r, z);
            match own {
                Some((value, gradient)) => {
                    outside |= value > 0.0;
                    if value > best.0 {
                        best = (value, gradient);
                    }
                }
                None => {
                    outside |= side > 0.0;
                    if side > 0.0 {
                        let d = [r - end[0], z - end[1]];
                        let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
                        if length < corner.0 {
                            corner =
                                (length, if length > AT_CORNER { [d[0] / length, d[1] / length] } else { [0.0, -1.0] });
                        }
                    }
                }
            }
        }
        if outside { if best.0 > 0.0 && best.0 <= corner.0 { best } else { corner } } else { best }
    }

    /// Largest `r across + z along` over the body: how far it reaches along a unit direction with these
    /// parts.
    #[inline]
    pub(crate) fn support(&self, across: f64, along: f64) -> f64 {
        let toward = |p: [f64; 2]| p[0] * across + p[1] * along;
        self.parts.iter().fold(f64::NEG_INFINITY, |most, part| match *part {
            OutlinePart::Line { from, along: way, length, .. } => {
                let to = [from[0] + length * way[0], from[1] + length * way[1]];
                most.max(toward(from)).max(toward(to))
            }
            OutlinePart::Arc { center, radius, first, last, from, to } => {
                let n = [across, along];
                let within = cross(first, n) >= 0.0 && cross(n, last) >= 0.0;
                let own = if within { toward(center) + radius } else { f64::NEG_INFINITY };
                most.max(own).max(toward(from)).max(toward(to))
            }
        })
    }
}

/// A signed distance and its gradient.
type NearestOnPart = (f64, [f64; 2]);

impl OutlinePart {
    /// Signed distance and gradient where the part's wedge or strip holds the point; else on which side of
    /// the tangent at its nearer end the point lies, and this end.
    #[inline]
    fn at(&self, r: f64, z: f64) -> (Option<NearestOnPart>, f64, [f64; 2]) {
        match *self {
            Self::Line { from, along, length, normal } => {
                let d = [r - from[0], z - from[1]];
                let s = d[0] * along[0] + d[1] * along[1];
                let signed = d[0] * normal[0] + d[1] * normal[1];
                if s < 0.0 {
                    (None, signed, from)
                } else if s > length {
                    (None, signed, [from[0] + length * along[0], from[1] + length * along[1]])
                } else {
                    (Some((signed, normal)), 0.0, from)
                }
            }
            Self::Arc { center, radius, first, last, from, to } => {
                let d = [r - center[0], z - center[1]];
                if cross(first, d) >= 0.0 && cross(d, last) >= 0.0 {
                    let length = (d[0] * d[0] + d[1] * d[1]).sqrt().max(AT_CENTER);
                    (Some((length - radius, [d[0] / length, d[1] / length])), 0.0, from)
                } else {
                    let (end, normal) = if cross(first, d) < 0.0 { (from, first) } else { (to, last) };
                    (None, (r - end[0]) * normal[0] + (z - end[1]) * normal[1], end)
                }
            }
        }
    }
}
