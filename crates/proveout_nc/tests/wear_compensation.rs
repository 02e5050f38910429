//! Programs that give the path of the tool center, with the wear alone in D: closed forms of a wall.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{Compensation, Control, Op, Program, Settings, ToolName, ToolRadii};

/// Height of the tool center along a wall, mm, and the notes of the run.
fn along_the_wall(control: &str, program_y_mm: f64) -> Result<(f64, Vec<String>), String> {
    let control = Control::from_text("mill.toml", control, None).map_err(|e| e.to_string())?;
    let mut radii = ToolRadii::default();
    radii.by_tool.insert(ToolName::Number(1), 5.0);
    let settings = Settings { compensation: Compensation::ToolCenter(radii), ..Settings::of_control(control) };
    let text = format!(
        "G21 G17 G90 G54\nT1 M6\nG0 X-20. Y40. Z-1.\nG41 D1 G1 X-10. Y{program_y_mm:.3} F300.\nX50.\nG40 Y40.\nM30\n"
    );
    let (mut y, mut notes) = (f64::NAN, Vec::new());
    for command in Program::from_text("wall.nc", text, &settings).map_err(|e| e.to_string())? {
        match command.map_err(|e| e.to_string())?.op {
            Op::Linear(motion) if motion.end_base.get(0) == Some(50.0) && y.is_nan() => {
                y = motion.end_base.get(1).unwrap()
            }
            Op::Note(note) => notes.push(note.to_string()),
            _ => {}
        }
    }
    Ok((y, notes))
}

#[test]
fn a_wall_is_the_same_by_contour_and_by_wear() {
    // A wall at Y0 and a tool of 10 mm: the center runs at Y5; ground to 9.9 mm it runs at Y4.95.
    for (control, program_y_mm, center_y_mm) in [
        ("dialect = \"fanuc\"\n", 0.0, 5.0),
        ("dialect = \"fanuc\"\nparameters.radius_offset_mm = { 1 = 4.95 }\n", 0.0, 4.95),
        ("dialect = \"fanuc\"\nparameters.compensation = \"contour\"\n", 0.0, 5.0),
        ("dialect = \"fanuc\"\nparameters.compensation = \"wear\"\n", 5.0, 5.0),
        (
            "dialect = \"fanuc\"\nparameters = { compensation = \"wear\", radius_offset_mm = { 1 = -0.05 } }\n",
            5.0,
            4.95,
        ),
        ("dialect = \"fanuc\"\nparameters = { compensation = \"wear\", radius_offset_mm = { 1 = 0.2 } }\n", 5.0, 5.2),
    ] {
        let (y, notes) = along_the_wall(control, program_y_mm).unwrap_or_else(|e| panic!("{control}: {e}"));
        assert!((y - center_y_mm).abs() < 1e-9, "{control}: {y}");
        let wear = notes.iter().any(|note| note.contains("the program gives the path of the tool center"));
        assert_eq!(wear, control.contains("wear"), "{notes:?}");
    }
}

#[test]
fn a_wear_that_is_a_radius_is_refused() {
    for wear in [5.0, -5.0, 6.35] {
        let control = format!(
            "dialect = \"fanuc\"\nparameters = {{ compensation = \"wear\", radius_offset_mm = {{ 1 = {wear:.2} }} }}\n"
        );
        let fault = along_the_wall(&control, 5.0).expect_err("refused");
        assert!(fault.contains("the wear of D1") && fault.contains("wall.nc:4"), "{fault}");
    }
    let apt = along_the_wall("dialect = \"apt\"\nparameters.compensation = \"wear\"\n", 0.0).expect_err("no effect");
    assert!(apt.contains("no effect"), "{apt}");
}
