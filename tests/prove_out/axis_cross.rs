//! The axis cross with the production program, where the data set lies next to the checkout.

use proveout_sim::{Choice, verdict::State};
use proveout_tests::{left_out, prove, published, scene};

const PROGRAM: &str = "spinner-u5-840d/NC_code/Coordinate_system_representation_Achskreuz/\
                       Coordinate_system_representation_Achskreuz.mpf";

#[test]
fn the_production_program_makes_the_part_that_its_text_describes() {
    let Some(nc) = published(PROGRAM) else {
        left_out(
            "the axis cross as it was cut: the data set doi:10.1038/s41597-025-05294-0 is not beside the checkout",
        );
        return;
    };
    // Faces across a ray are exact whatever the distance of the rays; sides of round arms need rays near
    // their crown.
    let choice = Choice { nc: Some(nc), resolution_mm: Some(0.5), ..Choice::default() };
    let run = prove(&scene("axis-cross"), &choice, 2).expect("runs to its end");
    let v = &run.verdict;
    let gate = |name: &str| v.gates.iter().find(|g| g.gate.name() == name).expect("every gate is there").clone();
    assert_eq!(gate("program").state, State::Pass, "{:?}", gate("program"));
    for name in ["limits", "process", "collision"] {
        assert_eq!(gate(name).state, State::Pass, "{:?}", gate(name));
    }
    assert_eq!(v.tools.len(), 4, "face mill, two end mills, chamfer cutter");
    assert!(v.inspection.len() >= 10);
    for feature in &v.inspection {
        let measured = feature.measured_mm.expect("the touch meets material");
        assert!((measured - feature.nominal_mm).abs() <= 0.01, "{feature:?}");
    }
    // Removed plus left is the stock: the same rays carry both, so only rounding may differ.
    let stock = 50.0 * 50.0 * 80.0;
    assert!((v.removal.volume_mm3 + v.removal.stock_left_mm3 - stock).abs() < 1e-3, "{:?}", v.removal);
}
