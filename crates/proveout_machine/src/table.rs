use std::io::{Read, Write};

use csv::StringRecord;
use proveout_geom::{Point, ToolPose, Vector, rad};
use thiserror::Error;

use crate::{Joint, JointValues, KinematicsError, Limited, Machine, MotionState};

/// Way of [`kinematics_csv`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Joints to tip and tool axis.
    Forward,
    /// Tip and tool axis to joints.
    Inverse {
        /// One row a pose, continuous with the row before (the first one with home); else one row a branch.
        nearest: bool,
    },
}

/// Why a table could not be converted.
#[derive(Debug, Error)]
pub enum TableError {
    /// The table cannot be read or written.
    #[error("table: {0}")]
    Csv(#[from] csv::Error),
    /// A row cannot be written.
    #[error("table: {0}")]
    Io(#[from] std::io::Error),
    /// The header lacks a column, or has one twice.
    #[error("line 1: {message}; the columns needed are {needed}")]
    Header {
        /// What is wrong.
        message: String,
        /// All columns that are needed.
        needed: String,
    },
    /// A value cannot be used.
    #[error("line {line}: column {column}: {value:?} {message}")]
    Value {
        /// Line of the table, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// The text of the cell.
        value: String,
        /// What is wrong and what to write.
        message: String,
    },
}

/// Names of the pose columns: tip in mm and unit axis, in the table frame K.
const POSE: [&str; 6] = ["x_mm", "y_mm", "z_mm", "i", "j", "k"];

/// A tool axis in a table may miss the length one by this much: five digits. It is then normalized.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-5;

/// Name of the column of a joint, `X_mm` or `A_deg`.
fn column_name(joint: &Joint) -> String {
    format!("{}_{}", joint.name, joint.kind.unit())
}

/// Converts a table of joint values to tool poses, or of tool poses to joint values.
///
/// CSV with one header line; columns in any order, further columns are passed through. Forward reads
/// one column per joint (`X_mm`, `A_deg`) and appends tip and tool axis in the table frame K,
/// `x_mm, y_mm, z_mm, i, j, k`. A held joint may be left out and is then at home. Heave and tilt of a
/// platform may be left out where all three of its legs are given (`L1_mm`). Inverse reads those six
/// columns and appends the joints, the legs of platforms, `branch`, `residual_mm` (the distance of the
/// tip that these joints give from the wanted one) and a `note`, one row per branch in the order of
/// [`Machine::inverse`]. The note reports an exceeded travel (of a leg, too), an axis that cannot be
/// reached (the nearest one is then given) or a singular pose. Numbers are written in full precision.
/// Returns the number of rows read.
///
/// # Errors
/// [`TableError`] with line and column.
pub fn kinematics_csv(
    machine: &Machine,
    reader: impl Read,
    writer: impl Write,
    direction: Direction,
    tool_length: f64,
) -> Result<u64, TableError> {
    let mut input = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(reader);
    let mut output = csv::Writer::from_writer(writer);
    let header = without_mark(input.headers()?);
    let joint_columns: Vec<String> = machine.joints.iter().map(column_name).collect();
    let leg_columns: Vec<String> =
        machine.platforms.iter().flat_map(|p| &p.legs).map(|leg| format!("{}_mm", leg.name)).collect();
    let needed: Vec<String> = match direction {
        Direction::Forward => joint_columns.clone(),
        Direction::Inverse { .. } => POSE.map(str::to_owned).into(),
    };
    let forward = direction == Direction::Forward;
    let leg_places = find_columns(&header, &leg_columns, |_| true)?;
    let legs_given: Vec<bool> = leg_places.chunks(3).map(|legs| forward && legs.iter().all(Option::is_some)).collect();
    let from_legs = |k: usize| {
        let of_joint = machine.platforms.iter().zip(&legs_given);
        of_joint.filter(|(_, given)| **given).any(|(p, _)| p.heave == k || p.tilt == k)
    };
    let places = find_columns(&header, &needed, |k| forward && (machine.joints[k].held || from_legs(k)))?;
    let mut head: Vec<String> = header.iter().map(str::to_owned).collect();
    match direction {
        Direction::Forward => head.extend(POSE.map(str::to_owned)),
        Direction::Inverse { .. } => {
            head.extend(joint_columns);
            head.extend(leg_columns.iter().cloned());
            head.extend(["branch", "residual_mm", "note"].map(str::to_owned));
        }
    }
    output.write_record(&head)?;

    let mut previous = machine.home();
    let mut rows = 0;
    let mut record = StringRecord::new();
    while input.read_record(&mut record)? {
        rows += 1;
        let row = TableRow { record: &record, names: &needed, places: &places };
        match direction {
            Direction::Forward => {
                let mut q = machine.home();
                for (j, joint) in machine.joints.iter().enumerate() {
                    if let Some(value) = row.number(j)? {
                        q[j] = if joint.is_rotary() { rad(value) } else { value };
                    }
                }
                let legs = TableRow { record: &record, names: &leg_columns, places: &leg_places };
                for (p, platform) in machine.platforms.iter().enumerate().filter(|(p, _)| legs_given[*p]) {
                    if row.number(platform.heave)?.is_some() && row.number(platform.tilt)?.is_some() {
                        continue;
                    }
                    let mut lengths = [0.0; 3];
                    for (k, length) in lengths.iter_mut().enumerate() {
                        *length = legs.number(3 * p + k)?.unwrap_or_default();
                    }
                    let values =
                        platform.from_legs(lengths, &previous).map_err(|e| legs.fail(3 * p, &e.to_string()))?;
                    (q[platform.heave], q[platform.tilt]) = (values[0], values[1]);
                }
                previous = q;
                let pose = machine.forward(&q, tool_length);
                let appended = pose.tip.iter().chain(pose.axis.iter()).map(|v| number(*v));
                output.write_record(record.iter().map(str::to_owned).chain(appended))?;
            }
            Direction::Inverse { nearest: true } => {
                let pose = row.pose()?;
                let (solution, note) = match machine.inverse_nearest(&pose, tool_length, &previous) {
                    Ok(s) => (Some((s.q, s.branch)), if s.singular { "singular".to_owned() } else { String::new() }),
                    Err(ref e @ KinematicsError::OverTravel { ref solution, .. }) => {
                        (Some((solution.q, solution.branch)), e.to_string())
                    }
                    Err(e) => {
                        let closest = machine.inverse_closest(&pose, tool_length);
                        (closest.first().map(|b| (b.q, b.index)), e.to_string())
                    }
                };
                if let Some((q, branch)) = solution {
                    write_solution(machine, &mut output, &record, &pose, tool_length, &q, branch, &note)?;
                    previous = q;
                }
            }
            Direction::Inverse { nearest: false } => {
                let pose = row.pose()?;
                let closest = machine.inverse_closest(&pose, tool_length);
                let reached = !machine.inverse(&pose, tool_length).is_empty();
                for branch in closest.iter() {
                    let note = if !reached {
                        KinematicsError::AxisUnreachable { angle: closest.axis_error }.to_string()
                    } else if branch.singular {
                        "singular".to_owned()
                    } else {
                        String::new()
                    };
                    let (q, index) = (&branch.q, branch.index);
                    write_solution(machine, &mut output, &record, &pose, tool_length, q, index, &note)?;
                }
            }
        }
    }
    output.flush()?;
    Ok(rows)
}

/// The header without the byte order mark that some spreadsheets write.
fn without_mark(header: &StringRecord) -> StringRecord {
    header.iter().map(|name| name.trim_start_matches('\u{feff}').trim()).collect()
}

/// Shortest text that reads back as the same number, without a negative zero.
fn number(value: f64) -> String {
    format!("{}", value + 0.0)
}

#[expect(clippy::too_many_arguments, reason = "one row of the table, written from two places")]
fn write_solution(
    machine: &Machine,
    output: &mut csv::Writer<impl Write>,
    record: &StringRecord,
    pose: &ToolPose,
    tool_length: f64,
    q: &JointValues,
    branch: usize,
    note: &str,
) -> Result<(), TableError> {
    let residual = (machine.forward(q, tool_length).tip - pose.tip).norm();
    let mut fields: Vec<String> = record.iter().map(str::to_owned).collect();
    for (j, joint) in machine.joints.iter().enumerate() {
        fields.push(number(joint.kind.in_unit(q[j])));
    }
    let mut note = note.to_owned();
    let state = MotionState { q: *q, ..MotionState::default() };
    for violation in machine.limit_violations(&state, 0.0).iter().filter(|v| matches!(v.limited, Limited::Leg { .. })) {
        let separator = if note.is_empty() { "" } else { "; " };
        note += &format!("{separator}{violation}");
    }
    for platform in &machine.platforms {
        fields.extend(platform.leg_lengths(q).map(number));
    }
    fields.extend([branch.to_string(), number(residual), note]);
    Ok(output.write_record(&fields)?)
}

fn find_columns(
    header: &StringRecord,
    needed: &[String],
    optional: impl Fn(usize) -> bool,
) -> Result<Vec<Option<usize>>, TableError> {
    let fail = |message: String| TableError::Header { message, needed: needed.join(", ") };
    let mut places = Vec::with_capacity(needed.len());
    for (k, name) in needed.iter().enumerate() {
        let mut found = header.iter().enumerate().filter(|(_, n)| n == name).map(|(i, _)| i);
        let place = found.next();
        if found.next().is_some() {
            return Err(fail(format!("column {name} appears twice")));
        }
        if place.is_none() && !optional(k) {
            let stem = name.split('_').next().unwrap_or(name);
            let similar = header.iter().find(|n| n.split('_').next().unwrap_or(n).eq_ignore_ascii_case(stem));
            let hint = similar.map_or_else(String::new, |n| format!(" (there is {n:?})"));
            return Err(fail(format!("column {name} is missing{hint}")));
        }
        places.push(place);
    }
    Ok(places)
}

/// One row with the places of the columns that are needed.
struct TableRow<'a> {
    record: &'a StringRecord,
    names: &'a [String],
    places: &'a [Option<usize>],
}

impl TableRow<'_> {
    fn fail(&self, column: usize, message: &str) -> TableError {
        let value = self.places[column].and_then(|i| self.record.get(i)).unwrap_or_default();
        TableError::Value {
            line: self.record.position().map_or(0, csv::Position::line),
            column: self.names[column].clone(),
            value: value.to_owned(),
            message: message.to_owned(),
        }
    }

    fn number(&self, column: usize) -> Result<Option<f64>, TableError> {
        let Some(place) = self.places[column] else { return Ok(None) };
        let parsed = self.record.get(place).and_then(|t| t.parse::<f64>().ok()).filter(|v| v.is_finite());
        parsed.map(Some).ok_or_else(|| self.fail(column, "is not a finite number; write decimals with a point"))
    }

    fn pose(&self) -> Result<ToolPose, TableError> {
        let mut n = [0.0; 6];
        for (k, value) in n.iter_mut().enumerate() {
            *value = self.number(k)?.unwrap_or_default();
        }
        let axis = Vector::new(n[3], n[4], n[5]);
        let length = axis.norm();
        if (length - 1.0).abs() > AXIS_LENGTH_TOLERANCE {
            return Err(self.fail(3, &format!("begins an axis (i, j, k) of length {length}; write a unit vector")));
        }
        Ok(ToolPose { tip: Point::new(n[0], n[1], n[2]), axis: axis / length })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::u5;

    fn convert(text: &str, direction: Direction) -> Result<String, TableError> {
        let mut out = Vec::new();
        kinematics_csv(&u5(), text.as_bytes(), &mut out, direction, 100.0)?;
        Ok(String::from_utf8(out).expect("text"))
    }

    #[test]
    fn forward_appends_the_pose_and_inverse_gives_it_back() {
        let text = "label,C_deg,B_deg,Z_mm,Y_mm,X_mm\n\"a, b\",-90,90,300,10,20\nc,-100,-5,400,0,0\n";
        let forward = convert(text, Direction::Forward).expect("forward");
        let lines: Vec<&str> = forward.lines().collect();
        assert_eq!(lines[0], "label,C_deg,B_deg,Z_mm,Y_mm,X_mm,x_mm,y_mm,z_mm,i,j,k");
        assert!(lines[1].ends_with(",0,-1,0"), "B90 C-90 points along -y exactly: {}", lines[1]);
        let poses: String = forward
            .lines()
            .map(|l| {
                l.split(',').rev().take(6).collect::<Vec<_>>().into_iter().rev().collect::<Vec<_>>().join(",") + "\n"
            })
            .collect();
        let inverse = convert(&poses, Direction::Inverse { nearest: false }).expect("inverse");
        let rows: Vec<&str> = inverse.lines().collect();
        assert_eq!(rows[0], "x_mm,y_mm,z_mm,i,j,k,X_mm,Y_mm,Z_mm,B_deg,C_deg,branch,residual_mm,note");
        assert_eq!(rows.len(), 5, "two branches a pose");
        let field = |row: &str, k: usize| row.split(',').nth(k).expect("field").parse::<f64>().expect("number");
        assert_eq!((field(rows[1], 9), field(rows[1], 10)), (90.0, -90.0));
        assert!((field(rows[1], 8) - 300.0).abs() < 1e-9);
        assert!((field(rows[4], 9) - -5.0).abs() < 1e-9);
        assert!(rows[1..].iter().all(|r| field(r, 12) < 1e-9));
        let nearest = convert(&poses, Direction::Inverse { nearest: true }).expect("nearest");
        let rows: Vec<&str> = nearest.lines().collect();
        assert_eq!(rows.len(), 3, "one row a pose");
        assert!((field(rows[2], 9) - -5.0).abs() < 1e-9, "C stays near with the negative tilt: {}", rows[2]);
    }

    #[test]
    fn places_of_mistakes_are_named() {
        let missing = convert("X_mm,Y_mm,Z_mm,B_rad,C_deg\n", Direction::Forward).expect_err("no B_deg");
        assert!(missing.to_string().contains("B_deg is missing (there is \"B_rad\")"), "{missing}");
        let comma = convert("X_mm,Y_mm,Z_mm,B_deg,C_deg\n1,2,3,4,5\n1,2,x,4,5\n", Direction::Forward).expect_err("x");
        assert!(comma.to_string().starts_with("line 3: column Z_mm: \"x\""), "{comma}");
        let short = convert("X_mm,Y_mm,Z_mm,B_deg,C_deg\n1,2\n", Direction::Forward).expect_err("short row");
        assert!(matches!(short, TableError::Csv(_)), "{short}");
        let axis = convert("x_mm,y_mm,z_mm,i,j,k\n0,0,0,0,0,2\n", Direction::Inverse { nearest: true });
        assert!(axis.expect_err("length").to_string().contains("of length 2"));
        let twice = convert("X_mm,X_mm,Y_mm,Z_mm,B_deg,C_deg\n", Direction::Forward).expect_err("twice");
        assert!(twice.to_string().contains("twice"), "{twice}");
    }
}
