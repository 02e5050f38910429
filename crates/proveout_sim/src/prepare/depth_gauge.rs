//! The depth of a cut under a ball, by the nearest point of the closed form of the blade.

use std::sync::Arc;

use proveout_blade::ParametricSurface;
use proveout_geom::{Point, Pose, Vector};

use crate::{
    prepare::part_shape::Shape,
    scene::{CompareFile, Scene},
};

/// What depths are measured from.
#[derive(Clone, Debug)]
pub(crate) struct DepthGauge {
    surface: Arc<dyn ParametricSurface>,
    work_from_table: Pose,
    /// What the raw blade has more than the design, mm.
    allowance: f64,
}

/// A place of the cutter: way of the tip up to it since the place before, and the depth there, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deep {
    pub(crate) way: f64,
    pub(crate) depth: f64,
}

impl DepthGauge {
    /// Of a scene that asks for a depth; none where it does not, or has no closed form.
    pub(crate) fn of_scene(scene: &Scene) -> Option<Self> {
        let asks = |c: &CompareFile| {
            let published = c.published.iter().map(|p| p.quantity);
            published.chain(c.expect.iter().filter_map(|e| e.quantity)).any(|q| q.of_depth())
        };
        scene.file.compare.as_ref().filter(|c| asks(c))?;
        let blade = scene.file.part.as_ref()?.blade?;
        let shape = Shape::of_scene(scene, &blade, 0.0).ok()?;
        Some(Self {
            surface: shape.surface(),
            work_from_table: scene.file.mount.table_from_work().inverse(),
            allowance: scene.file.stock.get_ref().blade_allowance_mm.unwrap_or(0.0),
        })
    }

    /// Depth of a ball, mm; its center in the table frame.
    pub(crate) fn depth(&self, center: &Point, radius: f64) -> f64 {
        let p = self.work_from_table.point(center);
        let [u, v] = self.surface.nearest(&p);
        let local = self.surface.local(u, v);
        let from: Vector = p - local.point;
        let distance = from.norm().copysign(from.dot(&local.normal));
        self.allowance - (distance - radius)
    }
}

#[cfg(test)]
mod tests {
    use proveout_blade::{ClosedSurface, Lu};

    use super::*;

    #[test]
    fn the_depth_is_that_of_the_ball_along_the_normal() {
        let surface: Arc<dyn ParametricSurface> = Arc::new(ClosedSurface::new(Lu::stand_in()));
        let mount = Pose::from_axis_angle(&Vector::z(), 0.7);
        let gauge = DepthGauge { surface: surface.clone(), work_from_table: mount.inverse(), allowance: 0.2 };
        for (u, v) in [(0.4, 0.2), (1.5, 0.5), (3.0, 0.7), (3.2, 0.4), (4.6, 0.6)] {
            let at = surface.local(u, v);
            for off in [-0.05, 0.0, 0.03] {
                let center = mount.point(&(at.point + at.normal * (3.0 + off)));
                let depth = gauge.depth(&center, 3.0);
                // Inward by 0.05 the ball still touches where it did: its radius is far above that of the
                // edge.
                assert!((depth - (0.2 - off)).abs() < 1e-6, "{u} {v} {off}: {depth}");
            }
        }
    }
}
