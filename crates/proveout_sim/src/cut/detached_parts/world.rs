//! The data of a fall: the part, the bodies about it, their contacts. `rapier_world` and
//! `no_rapier` take and return these.

#![cfg_attr(not(feature = "rapier"), allow(dead_code, reason = "a build without Rapier follows no fall"))]

use nalgebra::Matrix3;
use proveout_geom::{Point, TriMesh};

/// One step of a fall, s.
pub(super) const STEP: f64 = 5e-4;

/// What is assumed of two bodies that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Coefficient of Coulomb friction, at rest and sliding.
    pub(super) friction: f64,
    /// Speed after a hit over that before it.
    pub(super) restitution: f64,
}

/// The part: convex pieces and mass properties in K, mm, kg, kg mm².
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) pieces: Vec<Vec<Point>>,
    pub(super) mass: f64,
    pub(super) center: Point,
    pub(super) inertia: Matrix3<f64>,
}

/// A body at rest in K.
#[derive(Clone, Debug)]
pub(super) struct Standing {
    pub(super) name: String,
    pub(super) mesh: TriMesh,
    /// It is carried by the table.
    pub(super) on_table: bool,
}

/// Convex hull: vertices, and triangles counter-clockwise from outside.
pub(super) struct Hull {
    pub(super) points: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A contact of the part after a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Index of the standing body; none for the tool.
    pub(super) with: Option<usize>,
    /// Place in K.
    pub(super) point: Point,
    /// Speed of approach along the normal before the step, mm/s; zero where no force was passed on.
    pub(super) approach: f64,
    /// Depth of penetration, mm; negative for a gap.
    pub(super) depth: f64,
    /// A force was passed on.
    pub(super) bears: bool,
}
