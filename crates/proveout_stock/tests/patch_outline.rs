//! Rays beside the edge of what is left in a patch of rays stayed uncut, because the first and the last ray with
//! material were taken for the corners of the patch.

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_tool::{Profile, Segment};

fn cylinder(radius: f64, length: f64) -> Profile {
    let line = |from, to| Segment::Line { from, to };
    let skin = vec![
        line([0.0, 0.0], [radius, 0.0]),
        line([radius, 0.0], [radius, length]),
        line([radius, length], [0.0, length]),
    ];
    Profile::new(skin).expect("a cylinder is convex")
}

fn motion(from: [f64; 3], to: [f64; 3], axis: Vector) -> SweepMotion {
    let pose = |tip: [f64; 3]| ToolPose { tip: Point::from(tip), axis };
    SweepMotion { from: pose(from), to: pose(to) }
}

/// Whatever outline is left, a last cut over everything leaves nothing.
#[test]
fn nothing_stays_beside_the_edge_of_what_is_left() {
    let block = Aabb { min: Point::origin(), max: Point::new(12.0, 12.0, 6.0) };
    let (drill, mill) = (cylinder(1.3, 30.0), cylinder(2.0, 30.0));
    let mut state = 12_345_u64;
    let mut next = move || {
        // Knuth's linear congruential generator.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    for axis in [Vector::z(), Vector::x(), Vector::y()] {
        let along = |p: [f64; 2], h: f64| {
            // p lies across the axis; cyclic, so that every ray set sees the same cuts.
            let mut q = [0.0; 3];
            let a = axis.iter().position(|v| *v == 1.0).expect("an axis");
            (q[a], q[(a + 1) % 3], q[(a + 2) % 3]) = (h, p[0], p[1]);
            q
        };
        for _ in 0..40 {
            let mut stock = TriDexel::from_box(&block, 0.5, 1 << 26).expect("small");
            let holes: Vec<SweepMotion> = (0..6)
                .map(|_| {
                    let p = [12.0 * next(), 12.0 * next()];
                    motion(along(p, -1.0), along(p, -1.0), axis)
                })
                .collect();
            let rows: Vec<SweepMotion> = (0..7)
                .map(|k| motion(along([-3.0, 2.0 * f64::from(k)], -1.0), along([15.0, 2.0 * f64::from(k)], -1.0), axis))
                .collect();
            let drilled = holes.iter().map(|m| (&drill, *m));
            let milled = rows.iter().map(|m| (&mill, *m));
            let items: Vec<SweepItem<'_>> = drilled
                .chain(milled)
                .enumerate()
                .map(|(id, (body, motion))| SweepItem { id: id as u32, body, action: Action::Remove, motion })
                .collect();
            let removed: f64 = stock.sweep(&items).iter().map(|r| r.volume_mm3).sum();
            assert!(stock.volume() < 1e-9, "{} mm3 are left along {axis:?}", stock.volume());
            assert!((removed - 864.0).abs() < 1e-6, "{removed} mm3 were removed");
        }
    }
}
