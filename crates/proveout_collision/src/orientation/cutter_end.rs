//! The end of a cutter as far as it touches: a ball, or a disk widened by the corner radius.

use proveout_tool::{Profile, Segment, Tool};

use super::contact::OrientationError;

/// Lengths nearer than this are one, mm.
const JOIN_MM: f64 = 1e-6;

/// Where the end touches, and what is above it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CutterEnd {
    /// Radius of the circle of the corner's centers, mm: 0 for a ball.
    pub(crate) circle: f64,
    /// Corner radius or radius of the ball, mm: 0 for a sharp corner.
    pub(crate) round: f64,
    /// Height of those centers over the tip, mm.
    pub(crate) height: f64,
    /// Largest tilt for which the rounding touches, radian.
    pub(crate) largest_tilt: f64,
    /// What the cutter is above its end.
    pub(crate) rest: Profile,
}

impl CutterEnd {
    pub(crate) fn of(tool: &Tool) -> Result<Self, OrientationError> {
        let wrong = |reason| OrientationError::Cutter { tool: tool.name.clone(), reason };
        let body = tool.cutting().next().ok_or_else(|| wrong("it has no cutting end"))?;
        let segments = body.profile.segments();
        let first = *segments.first().ok_or_else(|| wrong("it has no cutting end"))?;
        let base = first.from()[1];
        let (circle, round, height, end, used) = match first {
            Segment::Arc { center, radius, to, .. } => {
                if center[0].abs() > JOIN_MM {
                    return Err(wrong("the center of its first arc is not on the axis"));
                }
                (0.0, radius, center[1], to, 1)
            }
            Segment::Line { to, .. } => {
                if (to[1] - base).abs() > JOIN_MM {
                    return Err(wrong("its bottom rises from the axis as a cone"));
                }
                match segments.get(1) {
                    Some(Segment::Arc { center, radius, to: end, .. }) => {
                        if (center[0] - to[0]).abs() > JOIN_MM || (center[1] - base - radius).abs() > JOIN_MM {
                            return Err(wrong("its corner does not go over smoothly into a flat bottom"));
                        }
                        (to[0], *radius, center[1], *end, 2)
                    }
                    _ => (to[0], 0.0, base, to, 1),
                }
            }
        };
        let largest_tilt =
            if round > 0.0 { (end[0] - circle).atan2(height - end[1]) } else { std::f64::consts::FRAC_PI_2 };
        // The disk below the rest closes it; it lies inside of the end.
        let mut rest = vec![Segment::Line { from: [0.0, end[1]], to: end }];
        rest.extend_from_slice(&segments[used..]);
        let rest = Profile::new(rest).map_err(|fault| OrientationError::Body { tool: tool.name.clone(), fault })?;
        Ok(Self { circle, round, height, largest_tilt: largest_tilt.min(std::f64::consts::FRAC_PI_2), rest })
    }
}
