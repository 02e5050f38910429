//! First blocks of a tilted plane: the program gives some work coordinates, the machine has the others.

use crate::common::{Program, bc_machine, motion, run_with, tool};
use proveout_controller::{Dynamics, Settings};
use proveout_geom::{Point, Vector};
use proveout_nc::{AxisValues, FrameChange, Motion, Op};

const LENGTH: f64 = 120.0;

#[test]
fn what_a_block_leaves_out_comes_from_the_machine() {
    let machine = bc_machine();
    let (s, c) = 0.4f64.sin_cos();
    let rotation = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]];
    let translation = [7.0, -3.0, 11.0];
    let frame = FrameChange { word: "PLANE".to_owned(), rotation, translation, rotary: [0.0; 3] };
    let settings = Settings { dynamics: Dynamics::Ideal, ..Settings::default() };
    for tcp in [true, false] {
        let start = Program::default()
            .change(1)
            .g0(&[('X', 20.0), ('Y', -10.0), ('Z', 180.0)])
            .g0(&[('B', 0.3), ('C', 0.2)])
            .op(Op::Frame(frame.clone()))
            .tcp(tcp);
        let before = run_with(&start, &machine, &[tool(1, LENGTH)], &settings).summary.end_position;
        // X and Y of the work frame alone; no base coordinates.
        let partial = Motion { end_base: AxisValues::NONE, ..motion(&[('X', 31.0), ('Y', 2.0)]) };
        let moved = start.op(Op::Rapid(partial));
        let after = run_with(&moved, &machine, &[tool(1, LENGTH)], &settings).summary.end_position;
        let base = |q: &proveout_machine::JointValues| {
            if tcp { machine.forward(q, LENGTH).tip } else { Point::new(q[0], q[1], q[2] - LENGTH) }
        };
        // The work frame by its axes: the columns of the rotation.
        let in_work = |p: Point| {
            let d = p - Point::from(translation);
            [0, 1, 2].map(|i| d.dot(&Vector::new(rotation[0][i], rotation[1][i], rotation[2][i])))
        };
        let (was, is) = (in_work(base(&before)), in_work(base(&after)));
        for (got, want) in is.into_iter().zip([31.0, 2.0, was[2]]) {
            assert!((got - want).abs() < 1e-9, "{is:?} {was:?}");
        }
        assert_eq!((before[3], before[4]), (after[3], after[4]));
    }
}
