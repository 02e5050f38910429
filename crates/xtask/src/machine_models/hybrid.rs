//! The hybrid grinder: a platform on three legs on a slide, a fixture on the platform, the tool on a portal.
//!
//! ```text
//!          ( B )            axis of the fixture, 60 mm above the moving joints
//!       ==plate==           moving joints on a circle of 150 mm about the A axis, z = 400
//!       /   |   \           legs: the sleeve belongs to the slide, the rod to the plate
//!     ===fixed plate===     fixed joints on a circle of 220 mm, z = 0
//!       Y slide
//! ```

use crate::{
    TaskError,
    machine_models::{
        gantry::Gantry,
        numbers::KinematicNumbers,
        part::{MachinePart, Paint},
        singles::y_slide,
        solid::{SolidMesh, UnitAxis, V3, add, block, cylinder, prism, revolved, scaled, tongue},
        spindle_heads::{Spindle, spindle},
    },
};

/// Radii of the circles of the fixed and the moving joints, as in `[[platform]]` of the machine.
const FIXED: f64 = 220.0;
const MOVING: f64 = 150.0;

/// From one point to another: direction and distance.
fn way(from: V3, to: V3) -> (V3, f64) {
    let d = add(to, scaled(from, -1.0));
    let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
    (scaled(d, 1.0 / length), length)
}

pub(crate) fn lu_hybrid(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [46, 84, 120];
    let [x, z] = ["X", "Z"].map(|n| numbers.travel(n));
    let (x, z) = (x?, z?);
    let height = numbers.point("A")?[2];
    let axis = numbers.point("B")?;
    let gauge = numbers.gauge[2];
    let deck = -64.0;
    let portal = Gantry {
        on: ["base", "X", "X"],
        travel: [x, [0.0, 0.0], [0.0, 0.0]],
        ram: 80.0,
        foot: gauge + 210.0,
        floor: deck - 74.0,
        clear: [330.0, 620.0],
        accent,
    };
    let mut parts: Vec<MachinePart> = portal.parts().into_iter().filter(|p| p.name != "z_rails").collect();
    parts.extend(spindle(numbers, Spindle { nose: 34.0, housing: 58.0, top: 212.0 }));
    parts.extend(y_slide(numbers, deck, [290.0, 290.0])?);
    let plate = cylinder([0.0, 0.0, deck - 2.0], UnitAxis::Z.unit(), 275.0, 34.0, 6.0);
    parts.push(MachinePart::new("fixed_plate", "slide", "Y", Paint::Accent(accent), plate));

    // Legs in the middle of the heave. The plate's parts are drawn where they are at heave zero.
    let middle = 0.5 * (z[0] + z[1]);
    let (mut sleeves, mut rods) = (Vec::new(), Vec::new());
    for turn in [90.0_f64, 210.0, 330.0] {
        let (s, c) = turn.to_radians().sin_cos();
        let fixed = [FIXED * c, FIXED * s, 0.0];
        let moving = [MOVING * c, MOVING * s, height];
        let (up, _) = way(fixed, add(moving, [0.0, 0.0, middle]));
        let along_ring = [-s, c, 0.0];
        sleeves.push(cylinder(add(fixed, scaled(along_ring, -46.0)), along_ring, 30.0, 92.0, 4.0));
        sleeves.push(block(
            [fixed[0] - 38.0, fixed[1] - 38.0, deck + 28.0],
            [fixed[0] + 38.0, fixed[1] + 38.0, -8.0],
            6.0,
        ));
        sleeves.push(cylinder(add(fixed, scaled(up, 8.0)), up, 36.0, 248.0, 4.0));
        let (down, _) = way(moving, add(fixed, [0.0, 0.0, -middle]));
        rods.push(cylinder(add(moving, scaled(down, 6.0)), down, 20.0, 168.0, 2.0));
        let ball = [[0.0, -26.0], [15.0, -22.0], [26.0, -9.0], [26.0, 9.0], [15.0, 22.0], [0.0, 26.0]];
        rods.push(revolved(moving, UnitAxis::Z.unit(), &ball));
    }
    parts.push(MachinePart::drawn("leg_sleeves", "leg", "Y", Paint::Casting, SolidMesh::all(sleeves)));
    parts.push(MachinePart::drawn("leg_rods", "leg", "A", Paint::Rail, SolidMesh::all(rods)));

    // Moving plate with the headstock of the fixture; its disc looks along y.
    let face = numbers.table[1];
    let top = height + 8.0;
    let headstock = prism(UnitAxis::Y, [face - 150.0, face - 36.0], &{
        // The outline along y is (z, x): the tongue is in (x, z), turned over so that it stays
        // counter-clockwise.
        let upright = tongue(70.0, top - 2.0, axis[2], 52.0);
        upright.iter().rev().map(|&[across, up]| [up, across]).collect::<Vec<_>>()
    });
    let moving_plate = cylinder([0.0, 0.0, height - 8.0], UnitAxis::Z.unit(), 188.0, 16.0, 3.0);
    let motor = cylinder([axis[0], face - 148.0, axis[2]], [0.0, -1.0, 0.0], 40.0, 60.0, 6.0);
    parts.push(MachinePart::new("moving_plate", "platform", "A", Paint::Accent(accent), moving_plate));
    parts.push(MachinePart::new("fixture_headstock", "bearing", "A", Paint::Casting, headstock));
    parts.push(MachinePart::new("fixture_motor", "motor", "A", Paint::Dark, motor));
    let disc = [[0.0, -36.0], [30.0, -36.0], [30.0, -20.0], [46.0, -20.0], [46.0, -2.0], [44.0, 0.0], [0.0, 0.0]];
    let disc = revolved([axis[0], face, axis[2]], UnitAxis::Y.unit(), &disc);
    parts.push(MachinePart::new("fixture", "table", "B", Paint::Steel, disc));
    Ok(parts)
}
