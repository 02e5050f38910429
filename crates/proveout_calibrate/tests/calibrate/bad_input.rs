//! Faults of a trace, each named with its line.

use std::path::Path;

use proveout_calibrate::{ColumnsFile, calibrate, trace_from_text};
use proveout_input::InputError;

use crate::plant::{Axis, Random, Recorder, air_text, machine, machine_text, record, table, trace};

fn axes() -> [Axis; 3] {
    let mut r = Random::new(40);
    [(); 3].map(|()| Axis::random(&mut r))
}

/// A table of 100 rows that is right, as rows of cells.
fn rows() -> Vec<Vec<String>> {
    let mut out = vec![["time_s", "X_command_mm", "X_actual_mm"].map(str::to_owned).to_vec()];
    for k in 0..100 {
        out.push(vec![format!("{:.3}", 0.01 * f64::from(k)), "10.0".into(), "10.001".into()]);
    }
    out
}

fn text(rows: &[Vec<String>]) -> String {
    rows.iter().map(|r| r.join(",") + "\n").collect()
}

fn read(text: &str, columns: Option<&str>) -> Result<(), InputError> {
    let machine = machine(&machine_text(&axes()));
    let columns = columns.map(|c| ColumnsFile::read(Path::new("columns.toml"), c)).transpose()?;
    trace_from_text(Path::new("air.csv"), text, columns.as_ref(), &machine).map(|_| ())
}

#[test]
fn a_table_that_is_right_is_read() {
    read(&text(&rows()), None).expect("a trace");
    let semicolons = text(&rows()).replace(',', ";");
    read(&semicolons, None).expect("semicolons are taken");
}

#[test]
fn faults_of_rows_are_named_with_their_line() {
    type Change = fn(&mut Vec<Vec<String>>);
    let cases: [(Change, usize, &str); 7] = [
        (|r| r[50][0] = "0.1".into(), 51, "time runs backwards: 0.1 s comes after 0.48 s"),
        (|r| r[50][0] = r[49][0].clone(), 51, "two rows have the time 0.48 s"),
        (|r| r[50][1] = "NaN".into(), 51, "column X_command_mm: \"NaN\" is not a number"),
        (|r| r[50][2] = String::new(), 51, "column X_actual_mm: \"\" is not a number"),
        (|r| drop(r.drain(40..60)), 41, "a gap of 0.2100 s, from 0.3800 s to 0.5900 s"),
        (|r| r[50][1] = "10000.0".into(), 51, "10000.000 mm is outside of the travel of X, 0.000 to 400.000 mm"),
        (|r| drop(r[50].pop()), 51, "the table cannot be read"),
    ];
    for (change, line, message) in cases {
        let mut all = rows();
        change(&mut all);
        let error = read(&text(&all), None).expect_err(message);
        assert!(error.message.contains(message), "{error}");
        assert!(error.line == line && !error.remedy.is_empty(), "{error}");
    }
}

#[test]
fn a_header_that_fits_no_joint_is_refused_with_names() {
    let mut all = rows();
    all[0] = ["time_s", "U_command_mm", "V_actual_mm"].map(str::to_owned).to_vec();
    let error = read(&text(&all), None).expect_err("no joint");
    assert!(error.message.contains("no column is a position of a joint of plant (X, Y, Z)"), "{error}");
    all[0][0] = "clock".into();
    let error = read(&text(&all), None).expect_err("no time");
    assert!(error.message.contains("there is no column of the time") && error.remedy.contains("--columns"), "{error}");
    let error = read("", None).expect_err("empty");
    assert!(!error.message.is_empty());
}

#[test]
fn columns_are_refused_by_name() {
    let good = "time = \"time_s\"\n[[joint]]\nname = \"X\"\nunit = \"mm\"\ncommand = \"X_command_mm\"\n";
    let all = text(&rows());
    read(&all, Some(good)).expect("right");
    for (change, to, message) in [
        ("X_command_mm", "X_comand_mm", "did you mean \"X_command_mm\"?"),
        ("name = \"X\"", "name = \"x\"", "did you mean X?"),
        ("unit = \"mm\"", "unit = \"deg\"", "joint X is linear, and its positions are stated in deg"),
        ("command =", "comand =", "command"),
        ("command = \"X_command_mm\"", "", "joint X has no column"),
        ("unit = \"mm\"", "unit = \"mm\"\nforce = \"X_actual_mm\"", "column and unit of the force come together"),
        (
            "unit = \"mm\"",
            "unit = \"mm\"\nforce = \"X_actual_mm\"\nforce_unit = \"Nm\"",
            "joint X is linear: its motor is measured in N",
        ),
        (
            "unit = \"mm\"",
            "unit = \"mm\"\nforce = \"X_actual_mm\"\nforce_unit = \"A\"\nforce_per_unit_N = -1.0",
            "-1 cannot be",
        ),
    ] {
        let error = read(&all, Some(&good.replace(change, to))).expect_err(message);
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn a_trace_in_inch_and_one_of_no_motion_are_refused() {
    let axes = axes();
    let truth = machine(&machine_text(&axes));
    let recording = record(&truth, &air_text(&truth));
    let mut inch = record(&truth, &air_text(&truth));
    for joint in &mut inch.joints {
        for column in joint.iter_mut().take(2) {
            column.iter_mut().for_each(|v| *v /= 25.4);
        }
    }
    let recorder = Recorder { every: 4, noise: 1e-3, rounding: 0.0, force_noise: 0.01 };
    let error = calibrate(&truth, &[trace(&table(&inch, recorder, 1), &truth)], None).expect_err("inch");
    assert!(error.message.contains("the positions are in inch"), "{error}");
    let error = calibrate(&truth, &[trace(&text(&rows()), &truth)], None).expect_err("no motion");
    assert!(error.message.contains("no joint moves alone from rest to rest"), "{error}");

    // At half of the override nothing is left that shows the machine.
    let full = table(&recording, recorder, 1);
    let half: String = full
        .lines()
        .enumerate()
        .map(|(k, l)| format!("{l},{}\n", if k == 0 { "override_percent" } else { "50" }))
        .collect();
    let error = calibrate(&truth, &[trace(&half, &truth)], None).expect_err("half of the override");
    assert!(error.message.contains("at another override than 100 percent"), "{error}");
}
