//! What stands for Rapier in a build without the feature `rapier`: no part is followed.
//!
//! The types are those of `rapier_world`; [`IS_BUILT`] is asked before any of them is made.

#![allow(dead_code, reason = "the types are those of `rapier_world`, and nothing reads them here")]

use std::convert::Infallible;

use nalgebra::Matrix3;
use proveout_geom::{Point, Pose, TriMesh, Vector};

/// Whether falls can be followed.
pub(super) const IS_BUILT: bool = false;
/// One step, s.
pub(super) const STEP: f64 = 5e-4;

/// What is taken for granted of two bodies that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    pub(super) friction: f64,
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

/// A body that stands, in K.
#[derive(Clone, Debug)]
pub(super) struct Standing {
    pub(super) name: String,
    pub(super) mesh: TriMesh,
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
    pub(super) with: Option<usize>,
    pub(super) point: Point,
    pub(super) approach: f64,
    pub(super) depth: f64,
    pub(super) bears: bool,
}

/// No hull is found.
pub(super) fn hull(_points: &[Point]) -> Option<Hull> {
    None
}

/// The part on its way; there is none in this build.
pub(super) struct World(Infallible);

impl World {
    pub(super) fn new(
        _body: &Body,
        _standing: &[Standing],
        _tool: Option<(&[Vec<Point>], &Pose)>,
        _touch: Touch,
    ) -> Option<Self> {
        None
    }

    pub(super) fn step(&mut self, _acceleration: &Vector, _tool: Option<&Pose>) -> Vec<Contact> {
        match self.0 {}
    }

    pub(super) fn moved(&self) -> Pose {
        match self.0 {}
    }
}
