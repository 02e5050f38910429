//! A side of a part as a surface that answers where a tool touches it, with normal and principal curvatures,
//! in the frame of a program.

use std::sync::Arc;

use proveout_blade::{Blade, CamberSide, Local, ParametricSurface};
use proveout_geom::{Point, Pose};

use crate::{ContactPoint, ContactSurface};

/// A point beyond a rim of the surface is one whose way to the nearest point of the rim leans out from it by
/// more than this, mm.
const BEYOND_MM: f64 = 1e-6;

/// A side of a part in the frame of a program.
#[derive(Clone, Debug)]
pub struct BladeSurface {
    surface: Arc<dyn ParametricSurface>,
    run_from_blade: Pose,
    blade_from_run: Pose,
}

impl BladeSurface {
    /// The airfoil of a blade whose frame has the pose `run_from_blade` in the frame of the
    /// program.
    pub fn new(blade: Blade, run_from_blade: Pose) -> Self {
        Self::of(Arc::new(CamberSide::new(blade)), run_from_blade)
    }

    /// Any surface, likewise.
    pub fn of(surface: Arc<dyn ParametricSurface>, run_from_blade: Pose) -> Self {
        Self { surface, run_from_blade, blade_from_run: run_from_blade.inverse() }
    }
}

impl BladeSurface {
    /// The contact at parameters of the surface.
    fn at(&self, at: &Local) -> ContactPoint {
        let curvatures = at.principal().map(|(k, direction)| (k, self.run_from_blade.vector(&direction)));
        ContactPoint {
            point: self.run_from_blade.point(&at.point),
            normal: self.run_from_blade.vector(&at.normal),
            curvatures,
        }
    }

    /// Parameters of the nearest point to a point of the frame of the program, and that point in the frame of
    /// the surface.
    fn foot(&self, near: &Point) -> Option<(Point, [f64; 2])> {
        let p = self.blade_from_run.point(near);
        p.coords.iter().all(|v| v.is_finite()).then(|| (p, self.surface.nearest(&p)))
    }
}

impl ContactSurface for BladeSurface {
    fn contact(&self, near: &Point) -> Option<ContactPoint> {
        let (p, [u, v]) = self.foot(near)?;
        let at = self.surface.local(u, v);
        let domain = self.surface.domain();
        let out = p - at.point;
        let beyond = |x: f64, range: [f64; 2], k: usize| {
            let outward = out.dot(&at.first[k]) / at.first[k].norm();
            (x <= range[0] && outward < -BEYOND_MM) || (x >= range[1] && outward > BEYOND_MM)
        };
        if beyond(v, domain.v, 1) || (!domain.u_closed && beyond(u, domain.u, 0)) {
            return None;
        }
        Some(self.at(&at))
    }

    fn nearest(&self, near: &Point) -> Option<ContactPoint> {
        let (_, [u, v]) = self.foot(near)?;
        Some(self.at(&self.surface.local(u, v)))
    }
}
