//! Reversals in stock: the floor of a hole lies where the program says, in every language; and a path that is
//! cut short is timed as it is.

use std::{fs, path::Path};

use proveout_sim::{Choice, run::RunResult};
use proveout_tests::{prove, root};

/// One hole in the middle of the block, 3 mm deep.
const PROGRAMS: [(&str, &str); 6] = [
    (
        "cycle.mpf",
        "G17 G54 G90 G94 G710 G64\nT=\"SCHAFT_D6_N_AP15\"\nM6\nS3000 M3\nF400\nG0 X0 Y0\nG0 Z5 D1\nCYCLE85(5,0,2,-3,,0,400,400)\n\
         M5\nM30\n",
    ),
    (
        "cycle.nc",
        "%\nO1 (HOLE)\nG17 G21 G40 G49 G80 G90 G94\nT3 M6\nG54\nS3000 M3\nG0 X0. Y0.\nG43 Z5. H3\nG81 Z-3. R2. F400.\nG80\nM5\nM30\n%\n",
    ),
    (
        "plunge.nc",
        "%\nO1 (PLUNGE)\nG17 G21 G40 G49 G80 G90 G94\nT3 M6\nG54\nS3000 M3\nG0 X0. Y0.\nG43 Z5. H3\nG1 Z-3. F400.\nZ5.\nM5\nM30\n%\n",
    ),
    (
        "cycle.ngc",
        "G17 G21 G40 G49 G80 G90 G94\nG64 P0.5\nT3 M6\nG54\nS3000 M3\nG0 X0 Y0\nG43 H3 Z5\nG85 Z-3 R2 F400\nG80\nM5\nM2\n",
    ),
    (
        "cycle.h",
        "0 BEGIN PGM HOLE MM\n1 CYCL DEF 247 DATUM SETTING ~\n  Q339=+1 ;DATUM NUMBER\n2 TOOL CALL 3 Z S3000\n\
         3 L X+0 Y+0 R0 FMAX M3\n4 L Z+5 FMAX\n\
         5 CYCL DEF 201 REAMING Q200=2 Q201=-3 Q206=400 Q211=0 Q208=400 Q203=+0 Q204=5\n6 CYCL CALL\n7 L Z+20 FMAX M5\n8 M30\n\
         9 END PGM HOLE MM\n",
    ),
    (
        "cycle.apt",
        "UNITS/MM\nLOADTL/3\nSPINDL/3000,RPM,CLW\nRAPID\nGOTO/0,0,300\nRAPID\nGOTO/0,0,5\nFEDRAT/400,MMPM\nCYCLE/BORE,3,MMPM,400,2\n\
         GOTO/0,0,0\nCYCLE/OFF\nRAPID\nGOTO/0,0,50\nSPINDL/OFF\nFINI\n",
    ),
];

fn run(file: &str, text: &str, extra: &str) -> RunResult {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = format!(
        "name = \"hole\"\nmachine = {:?}\ntools = {:?}\nresolution_mm = 0.5\n\
         [stock.box]\nmin_mm = [-20, -20, -8]\nmax_mm = [20, 20, 0]\n[mount]\ntranslation_mm = [0, 0, 100]\n\
         [work_offsets.G54]\nZ_mm = 100\n[work_offsets.PRESET1]\nZ_mm = 100\n\
         [[program]]\nname = \"hole\"\nfile = {file:?}\n{extra}",
        root().join("machines/three-axis-mill"),
        root().join("tools/axis-cross.toml"),
    );
    let write = |name: &str, text: &str| fs::write(Path::new(folder.path()).join(name), text).expect("written");
    write(file, text);
    write("scene.toml", &scene);
    prove(folder.path(), &Choice::default(), 2).unwrap_or_else(|e| panic!("{file}: {e}"))
}

#[test]
fn the_floor_of_a_hole_lies_where_the_program_says() {
    let floor = "[[inspect]]\nname = \"floor\"\nfrom_mm = [0, 0, 5]\ndirection = \"-z\"\nnominal_mm = -3\ntolerance_mm = 0.002\n";
    for (file, text) in PROGRAMS {
        let verdict = run(file, text, floor).verdict;
        let measured = verdict.inspection.first().and_then(|i| i.measured_mm).unwrap_or(f64::NAN);
        // A plane face of an end mill, down and up: the sweep's bound alone.
        assert!((measured + 3.0).abs() <= verdict.removal.sweep_bound_mm + 1e-6, "{file}: {measured} mm");
    }
}

/// 60 steps of 2 mm at G64 P0.75, over the block.
#[test]
fn stairs_are_timed_on_the_path_that_is_run() {
    let mut text =
        "%\nG21 G90 G17 G40 G49 G80\nG64 P0.75\nT3 M6\nG54\nS3000 M3\nF600\nG0 X0 Y0\nG43 H3 Z30\n".to_owned();
    for k in 1..=30 {
        text += &format!("G1 X{}\nG1 Y{}\n", 2 * k, 2 * k);
    }
    text += "M5\nM2\n%\n";
    let verdict = run("stairs.ngc", &text, "").verdict;
    let (time, path) = (&verdict.time, &verdict.path);
    // The programmed length takes 12 s at the feed; the corners are rounded by what 10 mm/s need, not by all
    // of the tolerance.
    assert!(time.cutting_s < 11.8 && time.cutting_s > 11.0, "{time:?}");
    assert!(path.min_feed_ratio.is_some_and(|ratio| ratio > 0.99), "{path:?}");
    // A control that rounds with arcs of the whole step needs 9.47 s for the steps, one on the diagonal 8.4
    // s.
    let [lower, own] = [time.lower_bound_s, time.path_bound_s].map(|b| b.expect("bounded"));
    assert!(lower <= time.total_s - time.cutting_s + 8.49, "{time:?}");
    assert!(own > lower + 2.0 && own <= time.total_s, "{time:?}");
}
