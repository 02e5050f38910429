//! Rays of an irregular rest, one by one against a closed form: a patch of rays shares bounds, and no ray may
//! be cleared by the bounds of its neighbors.

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_tool::{Profile, Segment};

/// A ray nearer to the wall than this (mm) may count to either side: the bound of the sweep, ten times.
const EDGE_MM: f64 = 0.01;

fn cylinder(radius: f64) -> Profile {
    let line = |from, to| Segment::Line { from, to };
    let skin =
        vec![line([0.0, 0.0], [radius, 0.0]), line([radius, 0.0], [radius, 30.0]), line([radius, 30.0], [0.0, 30.0])];
    Profile::new(skin).expect("a cylinder is convex")
}

fn distance_to_path(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let t = (((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
    (p[0] - a[0] - t * d[0]).hypot(p[1] - a[1] - t * d[1])
}

/// Vertical cutters through a plate: a ray is empty when a path came nearer than the radius, and whole
/// otherwise.
#[test]
fn every_ray_of_an_irregular_rest_is_cut() {
    let plate = Aabb { min: Point::origin(), max: Point::new(12.0, 12.0, 3.0) };
    let mut state = 12_345_u64;
    let mut next = move || {
        // Knuth's linear congruential generator.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    for _ in 0..60 {
        let mut stock = TriDexel::from_box(&plate, 0.5, 1 << 26).expect("small");
        let mut paths: Vec<(f64, [f64; 2], [f64; 2])> = Vec::new();
        for id in 0..25 {
            let radius = 0.5 + 2.5 * next();
            let from = [14.0 * next() - 1.0, 14.0 * next() - 1.0];
            let to = [from[0] + 2.0 * next() - 1.0, from[1] + 2.0 * next() - 1.0];
            let pose = |p: [f64; 2]| ToolPose { tip: Point::new(p[0], p[1], -1.0), axis: Vector::z() };
            let motion = SweepMotion { from: pose(from), to: pose(to) };
            let body = cylinder(radius);
            stock.sweep(&[SweepItem { id, body: &body, action: Action::Remove, motion }]);
            paths.push((radius, from, to));
            for i in 0..stock.counts()[0] {
                for j in 0..stock.counts()[1] {
                    let at = stock.ray_place(2, i, j);
                    let depth = paths.iter().map(|(r, a, b)| r - distance_to_path(at, *a, *b)).fold(f64::MIN, f64::max);
                    let material: f64 = stock.ray_intervals(2, i, j).iter().map(|x| x.hi - x.lo).sum();
                    if depth > EDGE_MM {
                        assert!(material == 0.0, "{material} mm left at {at:?}, {depth} mm inside of the cut");
                    } else if depth < -EDGE_MM {
                        assert!(
                            (material - 3.0).abs() < 1e-12,
                            "{material} mm at {at:?}, {depth} mm outside of the cut"
                        );
                    }
                }
            }
        }
    }
}
