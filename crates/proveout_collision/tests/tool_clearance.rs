//! Clearance of one tool pose against distances of densely sampled points of the tool from a box in closed
//! form.

use std::f64::consts::TAU;

use proveout_collision::ToolClearance;
use proveout_geom::{Aabb, Point, ToolPose, Vector, box_mesh};
use proveout_tool::{Cutter, HolderSection, Role, Tool, ToolBuilder};

use crate::common::Random;

fn tool() -> Tool {
    let section = |diameter, top_diameter, length| HolderSection { diameter, top_diameter, length };
    ToolBuilder::new(1, "BALL", Cutter::ball(12.0).expect("ball"), 20.0, 120.0)
        .shank(10.0)
        .holder([section(30.0, 40.0, 50.0), section(60.0, 60.0, 20.0)])
        .build()
        .expect("tool")
}

/// Least distance from a box of points on neck, shank and holder, 0.5 mm along the axis and 7.5 degrees round
/// it.
fn sampled(tool: &Tool, pose: &ToolPose, solid: &Aabb) -> f64 {
    let u = pose.axis.cross(&if pose.axis.x.abs() < 0.9 { Vector::x() } else { Vector::y() }).normalize();
    let v = pose.axis.cross(&u);
    let mut least = f64::MAX;
    for body in tool.bodies.iter().filter(|b| b.role != Role::Cutting) {
        let (low, high) = (body.profile.z_min(), body.profile.z_max());
        let steps = ((high - low) / 0.5).ceil() as usize;
        for i in 0..=steps {
            let z = low + (high - low) * i as f64 / steps as f64;
            let radius = body.profile.radius_at(z).unwrap_or(0.0);
            for k in 0..48 {
                let (s, c) = (TAU * f64::from(k) / 48.0).sin_cos();
                let p = pose.tip + pose.axis * z + u * (radius * c) + v * (radius * s);
                let off = |i: usize| (solid.min[i] - p[i]).max(p[i] - solid.max[i]).max(0.0);
                least = least.min(off(0).hypot(off(1)).hypot(off(2)));
            }
        }
    }
    least
}

#[test]
fn the_distance_is_that_of_densely_sampled_points() {
    let tool = tool();
    let solid = Aabb { min: Point::new(-30.0, -20.0, -10.0), max: Point::new(30.0, 20.0, 0.0) };
    let clearance = ToolClearance::new(&tool, &[("block".into(), box_mesh(&solid))]).expect("a solid");
    let mut numbers = Random::new(0x9e37_79b9_7f4a_7c15);
    let mut random = || numbers.part();
    let (mut near, mut touching) = (0, 0);
    for _ in 0..400 {
        let axis = Vector::new(random() - 0.5, random() - 0.5, random() - 0.2).normalize();
        let tip = Point::new(80.0 * (random() - 0.5), 60.0 * (random() - 0.5), 20.0 * random());
        let pose = ToolPose { tip, axis };
        let (found, points) = (clearance.distance(&pose, 60.0), sampled(&tool, &pose, &solid).min(60.0));
        // Points lie up to 0.25 mm along and 30 mm * 3.75 degrees = 2 mm round off the nearest place of a
        // flange, which lies below the circle's chord by 30 mm * (1 - cos 3.75 degrees) = 0.07 mm, or next to
        // an edge of the box by all of it.
        assert!(found <= points + 1e-9 && points - found < 2.1, "{found} {points} {pose:?}");
        near += u32::from(found > 0.0 && found < 60.0);
        touching += u32::from(found == 0.0);
        assert!(clearance.distance(&pose, 1.0) <= 1.0);
    }
    assert!(near > 100 && touching > 20, "{near} {touching}");
}

#[test]
fn the_cutting_end_does_not_count() {
    let solid = Aabb { min: Point::new(-30.0, -20.0, -10.0), max: Point::new(30.0, 20.0, 0.0) };
    let clearance = ToolClearance::new(&tool(), &[("block".into(), box_mesh(&solid))]).expect("a solid");
    // The ball cuts 5 mm deep; the shank begins 20 mm over the tip.
    let pose = ToolPose { tip: Point::new(0.0, 0.0, -5.0), axis: Vector::z() };
    assert!((clearance.distance(&pose, 100.0) - 15.0).abs() < 1e-3);
    assert!((clearance.distance(&pose, 10.0) - 10.0).abs() < 1e-12, "no more than was asked for");
}
