//! A contact of the cutter with a surface, its local frame, and what is refused.

use proveout_geom::{Point, Vector};
use proveout_tool::ProfileError;
use thiserror::Error;

use super::NOT_ZERO;
use crate::report::CollisionError;

/// A unit vector may be this far from length one.
const UNIT: f64 = 1e-6;
/// Principal directions may be this far from length one and from right angles.
const PRINCIPAL: f64 = 1e-4;
/// Sine of the angle to the normal below which a feed has no direction on the surface.
const ALONG_NORMAL: f64 = 1e-9;

/// Where a cutter touches a surface, in the frame of the solids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceContact {
    /// The contact, mm.
    pub point: Point,
    /// Outward unit normal of the surface.
    pub normal: Vector,
    /// Direction of the feed; its part along the surface is what counts.
    pub feed: Vector,
    /// Principal curvatures of the surface, 1/mm, positive where it is convex, with their unit directions;
    /// none where they are not known: then a cutter that is too round is only found as deep as the gouge
    /// allowance.
    pub curvatures: Option<[(f64, Vector); 2]>,
}

/// Why there is no region.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OrientationError {
    /// A mesh that does not bound a solid.
    #[error(transparent)]
    Solid(#[from] CollisionError),
    /// A cutter whose contact is not known in closed form.
    #[error(
        "the cutting end of tool \"{tool}\" is neither a ball nor a flat bottom with a corner: {reason}; free orientations are known \
         for ball, tapered ball, bull-nose and flat end mills"
    )]
    Cutter {
        /// Name of the tool.
        tool: String,
        /// What does not fit.
        reason: &'static str,
    },
    /// A part of the tool that makes no body.
    #[error("a part of tool \"{tool}\" makes no body: {fault}; correct the tool library")]
    Body {
        /// Name of the tool.
        tool: String,
        /// What is wrong.
        fault: ProfileError,
    },
    /// A setting outside of its range.
    #[error("{key} = {value} must be {limit}")]
    Setting {
        /// Name of the setting, with its unit.
        key: &'static str,
        /// Value given.
        value: f64,
        /// What it must be.
        limit: &'static str,
    },
    /// A number of a contact that is not finite.
    #[error(
        "the {what} of the contact is not finite: {value:?}; a contact needs a point, a normal and a feed direction"
    )]
    NotFinite {
        /// `point`, `normal` or `feed`.
        what: &'static str,
        /// Value given.
        value: [f64; 3],
    },
    /// A contact without a normal.
    #[error("the contact at {point:?} has no unit normal: its length is {length}")]
    NoNormal {
        /// The contact, mm.
        point: [f64; 3],
        /// Length given.
        length: f64,
    },
    /// A feed without a direction along the surface: yaw would count from nowhere.
    #[error("the feed {feed:?} of the contact at {point:?} is normal to the surface, so yaw has no reference")]
    NoFeed {
        /// The contact, mm.
        point: [f64; 3],
        /// Direction given.
        feed: [f64; 3],
    },
    /// A curvature that is not finite: an edge or a corner, where the normal is not one.
    #[error(
        "the curvature of the surface at {point:?} is {value}: an edge or a corner has no normal of its own; use a \
         contact next to it"
    )]
    Curvature {
        /// The contact, mm.
        point: [f64; 3],
        /// Curvature given, 1/mm.
        value: f64,
    },
    /// Directions of the principal curvatures that are not unit vectors across each other and along the
    /// surface.
    #[error("the directions of the curvatures at {point:?} are not unit vectors along the surface, across each other")]
    Directions {
        /// The contact, mm.
        point: [f64; 3],
    },
}

/// The contact in its local frame: T along the feed, K = N x T, N outward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LocalFrame {
    pub(crate) point: Point,
    pub(crate) along: Vector,
    pub(crate) across: Vector,
    pub(crate) normal: Vector,
    /// Second fundamental form of the surface in (T, K), 1/mm, positive where convex: `[TT, TK, KK]`.
    pub(crate) curvature: Option<[f64; 3]>,
}

impl LocalFrame {
    pub(crate) fn new(contact: &SurfaceContact) -> Result<Self, OrientationError> {
        let at: [f64; 3] = contact.point.coords.into();
        let vectors = [("point", contact.point.coords), ("normal", contact.normal), ("feed", contact.feed)];
        for (what, v) in vectors {
            if !v.iter().all(|x| x.is_finite()) {
                return Err(OrientationError::NotFinite { what, value: v.into() });
            }
        }
        let length = contact.normal.norm();
        if (length - 1.0).abs() > UNIT {
            return Err(OrientationError::NoNormal { point: at, length });
        }
        let normal = contact.normal / length;
        let flat = contact.feed - normal * contact.feed.dot(&normal);
        let along = flat.try_normalize(ALONG_NORMAL * contact.feed.norm().max(NOT_ZERO));
        let along = along.ok_or(OrientationError::NoFeed { point: at, feed: contact.feed.into() })?;
        let across = normal.cross(&along);
        let mut form = None;
        if let Some(principal) = &contact.curvatures {
            let mut sum = [0.0; 3];
            for (k, direction) in principal {
                if !k.is_finite() {
                    return Err(OrientationError::Curvature { point: at, value: *k });
                }
                let (x, y) = (direction.dot(&along), direction.dot(&across));
                sum = [sum[0] + k * x * x, sum[1] + k * x * y, sum[2] + k * y * y];
            }
            let [(_, u), (_, v)] = principal;
            let unit = |d: &Vector| (d.norm() - 1.0).abs() < PRINCIPAL && d.dot(&normal).abs() < PRINCIPAL;
            if !(unit(u) && unit(v) && u.dot(v).abs() < PRINCIPAL) {
                return Err(OrientationError::Directions { point: at });
            }
            form = Some(sum);
        }
        Ok(Self { point: contact.point, along, across, normal, curvature: form })
    }

    /// Unit vector at a polar angle from N and a yaw from T.
    pub(crate) fn direction(&self, polar: [f64; 2], yaw: [f64; 2]) -> Vector {
        let ([s, c], [sy, cy]) = (polar, yaw);
        self.along * (s * cy) + self.across * (s * sy) + self.normal * c
    }

    /// Tilt and yaw of an axis, radian; yaw 0 at the pole.
    pub(crate) fn angles(&self, axis: &Vector) -> [f64; 2] {
        let (x, y, z) = (axis.dot(&self.along), axis.dot(&self.across), axis.dot(&self.normal));
        let off = x.hypot(y);
        [off.atan2(z), if off > 0.0 { y.atan2(x) } else { 0.0 }]
    }

    /// `|R' - R|`: twice the sine of half the angle of the rotation to another frame.
    pub(crate) fn turn_to(&self, other: &Self) -> f64 {
        let a = [self.along, self.across, self.normal];
        let b = [other.along, other.across, other.normal];
        // The squared Frobenius norm of R' - R is 8 sin^2 of half the angle.
        let square: f64 = a.iter().zip(&b).map(|(x, y)| (y - x).norm_squared()).sum();
        (0.5 * square).sqrt()
    }
}
