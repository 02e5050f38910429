//! Replaces Rapier in a build without the feature `rapier`: no part is followed.
//!
//! [`IS_BUILT`] is asked before any of it is called.

use std::convert::Infallible;

use proveout_geom::{Point, Pose, Vector};

use super::world::{Body, Contact, Hull, Standing, Touch};

/// Whether falls can be followed.
pub(super) const IS_BUILT: bool = false;

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
