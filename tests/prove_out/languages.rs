//! One part from programs in four languages: a boss whose contour is compensated by the control where the
//! language can.

use std::fs;

use proveout_sim::Choice;
use proveout_sim::verdict::State;
use proveout_tests::{prove, root};

/// A square boss of 30 mm, 3 mm high, with an end mill of 6 mm, clockwise on the left of the contour.
const PROGRAMS: [(&str, &str); 4] = [
    (
        "boss.mpf",
        "G17 G54 G90 G94 G710 G60\nT=\"SCHAFT_D6_N_AP15\"\nM6\nS3000 M3\nG0 X-30 Y-25\nG0 Z5 D1\nG1 Z-3 F400\n\
         G41 G1 X-15 Y-25\nY15\nX15\nY-15\nX-25\nG40 X-30 Y-30\nG0 Z5\nM5\nM30\n",
    ),
    (
        "boss.nc",
        "%\nO1 (BOSS)\nG17 G21 G40 G49 G80 G90 G94\nT3 M6\nG54\nS3000 M3\nG0 X-30. Y-25.\nG43 Z5. H3\nG1 Z-3. F400.\n\
         G41 X-15. Y-25. D3\nY15.\nX15.\nY-15.\nX-25.\nG40 X-30. Y-30.\nG0 Z5.\nM5\nM30\n%\n",
    ),
    (
        "boss.h",
        "0 BEGIN PGM BOSS MM\n1 CYCL DEF 247 DATUM SETTING ~\n  Q339=+1 ;DATUM NUMBER\n2 TOOL CALL 3 Z S3000\n\
         3 L X-30 Y-25 R0 FMAX M3\n4 L Z+5 FMAX\n5 L Z-3 F400\n6 L X-15 Y-25 RL\n7 L Y+15\n8 L X+15\n9 L Y-15\n\
         10 L X-25\n11 L X-30 Y-30 R0\n12 L Z+5 FMAX M5\n13 M30\n14 END PGM BOSS MM\n",
    ),
    (
        "boss.apt",
        "UNITS/MM\nLOADTL/3\nSPINDL/3000,RPM,CLW\nRAPID\nGOTO/-30,-25,300\nRAPID\nGOTO/-30,-25,5\nFEDRAT/400,MMPM\n\
         GOTO/-30,-25,-3\nGOTO/-18,-25,-3\nGOTO/-18,18,-3\nGOTO/18,18,-3\nGOTO/18,-18,-3\nGOTO/-25,-18,-3\n\
         RAPID\nGOTO/-25,-18,5\nSPINDL/OFF\nFINI\n",
    ),
];

#[test]
fn the_same_part_comes_from_every_language() {
    for (file, text) in PROGRAMS {
        let folder = tempfile::tempdir().expect("temporary folder");
        let touch = |name: &str, from: [f64; 3], direction: &str, nominal: f64| {
            format!(
                "[[inspect]]\nname = {name:?}\nfrom_mm = {from:?}\ndirection = {direction:?}\nnominal_mm = {nominal}\n\
                 tolerance_mm = 0.002\n"
            )
        };
        let inspect = [
            touch("left", [-30.0, 0.0, -1.0], "+x", -15.0),
            touch("right", [30.0, 0.0, -1.0], "-x", 15.0),
            touch("front", [0.0, -30.0, -1.0], "+y", -15.0),
            touch("back", [0.0, 30.0, -1.0], "-y", 15.0),
            touch("floor", [17.0, 0.0, 5.0], "-z", -3.0),
        ]
        .concat();
        let scene = format!(
            "name = \"boss\"\nmachine = {:?}\ntools = {:?}\nresolution_mm = 0.25\n\
             [stock.box]\nmin_mm = [-20, -20, -8]\nmax_mm = [20, 20, 0]\n[mount]\ntranslation_mm = [0, 0, 100]\n\
             [work_offsets.G54]\nZ_mm = 100\n[work_offsets.PRESET1]\nZ_mm = 100\n\
             [[program]]\nname = \"boss\"\nfile = {file:?}\n{inspect}",
            root().join("machines/three-axis-mill"),
            root().join("tools/axis-cross.toml"),
        );
        fs::write(folder.path().join(file), text).expect("written");
        fs::write(folder.path().join("scene.toml"), scene).expect("written");
        let run = prove(folder.path(), &Choice::default(), 2).unwrap_or_else(|e| panic!("{file}: {e}"));
        let verdict = &run.verdict;
        for name in ["program", "limits", "process"] {
            let gate = verdict.gates.iter().find(|g| g.gate.name() == name).expect("gate");
            assert_eq!(gate.state, State::Pass, "{file}: {name}: {} {:?}", gate.reason, verdict.findings);
        }
        assert_eq!(verdict.inspection.len(), 5, "{file}");
        for feature in &verdict.inspection {
            // Straight sides of an end mill: the sweep's bound of 1 micrometer.
            let deviation = feature.measured_mm.map_or(f64::NAN, |measured| measured - feature.nominal_mm);
            assert!(deviation.abs() < 0.001, "{file}: {} is off by {deviation}", feature.name);
        }
    }
}
