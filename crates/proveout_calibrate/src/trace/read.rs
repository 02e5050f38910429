//! A CSV table becomes a trace, or an error names what is wrong with it.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use proveout_input::{InputError, InputFault};
use proveout_machine::{Joint, Machine};
use sha2::{Digest, Sha256};

use super::{
    JointTrace, Signal, Trace,
    columns::ColumnsFile,
    quality::{noise, quantum, steps_of_time},
};

/// A step of time this many times longer than the median is a gap.
const GAP: f64 = 5.0;
/// Fewest rows that can hold a move with its rests.
const FEWEST_ROWS: usize = 20;
/// A position may pass the end of the travel by this part of the travel: referencing and rounding.
const BEYOND_TRAVEL: f64 = 0.01;
/// The same in mm or radian.
const BEYOND_TRAVEL_LEAST: f64 = 1.0;
/// Digits of a digest in a source note.
const SHOWN_DIGITS: usize = 12;

/// A column of the table that is read, with its number.
struct Column {
    name: String,
    index: usize,
}

/// Reads a table with a header. Fields are separated by commas, or by semicolons or tabs where the header has
/// no comma; the decimal sign is a point.
///
/// # Errors
/// [`InputError`] with file and line: a column that is not there, a cell that is no number, time that runs
/// backwards or repeats, a gap, positions outside of the travel.
pub fn trace_from_text(
    file: &Path,
    text: &str,
    columns: Option<&ColumnsFile>,
    machine: &Machine,
) -> Result<Trace, InputError> {
    let fault = |line: usize, message: String, remedy: String| -> InputError {
        InputFault { code: "trace", file: file.into(), line, message, remedy, ..InputFault::default() }.into()
    };
    let first = text.lines().next().unwrap_or_default();
    let delimiter = [b',', b';', b'\t'].into_iter().find(|d| first.contains(char::from(*d))).unwrap_or(b',');
    let mut reader = ReaderBuilder::new().delimiter(delimiter).trim(Trim::All).from_reader(text.as_bytes());
    let unreadable = |e: &csv::Error| {
        let line = e.position().map_or(0, |p| p.line() as usize);
        fault(line, format!("the table cannot be read: {e}"), "write as many cells in each row as in the header".into())
    };
    let header: Vec<String> = reader.headers().map_err(|e| unreadable(&e))?.iter().map(str::to_owned).collect();
    let own;
    let columns = match columns {
        Some(given) => given,
        None => {
            own = ColumnsFile::of_header(&header, machine).map_err(|m| fault(1, m, ColumnsFile::remedy()))?;
            &own
        }
    };
    let find = |name: &str| -> Result<Column, InputError> {
        let mut all = header.iter().enumerate().filter(|(_, h)| *h == name);
        let index = match (all.next(), all.next()) {
            (Some((index, _)), None) => index,
            (Some(_), Some(_)) => {
                return Err(fault(1, format!("column {name:?} is there twice"), "rename one of the two".into()));
            }
            (None, _) => {
                let near = proveout_input::nearest(name, header.iter().map(String::as_str));
                let near = near.map_or_else(String::new, |n| format!("; did you mean {n:?}?"));
                let message = format!("there is no column {name:?}{near} (columns: {})", header.join(", "));
                return Err(fault(1, message, "correct the name in the file of --columns".into()));
            }
        };
        Ok(Column { name: name.to_owned(), index })
    };
    let time_column = find(&columns.time)?;
    let block_column = columns.block.as_deref().map(find).transpose()?;
    let override_column = columns.override_percent.as_deref().map(find).transpose()?;
    let mut joint_columns = Vec::new();
    for of_joint in &columns.joint {
        let (index, joint) = of_joint
            .joint_of(machine)
            .map_err(|m| fault(1, m, "name joints of this machine, each with its unit".into()))?;
        let column = |name: &Option<String>| name.as_deref().map(find).transpose();
        let (command, actual) = (column(&of_joint.command)?, column(&of_joint.actual)?);
        joint_columns.push((index, joint, of_joint, command, actual, column(&of_joint.force)?));
    }

    let mut time: Vec<f64> = Vec::new();
    let mut block = block_column.as_ref().map(|_| Vec::new());
    let mut overrides = override_column.as_ref().map(|_| Vec::new());
    let mut values: Vec<[Vec<f64>; 3]> = joint_columns.iter().map(|_| Default::default()).collect();
    let mut row = StringRecord::new();
    let seconds = columns.time_unit.seconds();
    while reader.read_record(&mut row).map_err(|e| unreadable(&e))? {
        let line = row.position().map_or(0, |p| p.line() as usize);
        let number = |column: &Column| -> Result<f64, InputError> {
            let cell = row.get(column.index).unwrap_or_default();
            match cell.parse::<f64>() {
                Ok(v) if v.is_finite() => Ok(v),
                _ => {
                    let message = format!("column {}: {cell:?} is not a number", column.name);
                    Err(fault(line, message, "write a decimal number with a point".into()))
                }
            }
        };
        let t = number(&time_column)? * seconds;
        if let Some(before) = time.last()
            && t <= *before
        {
            let message = if t < *before {
                format!("time runs backwards: {t} s comes after {before} s")
            } else {
                format!("two rows have the time {t} s")
            };
            let remedy = "a trace is one recording: split the file where the clock starts anew, and drop doubled rows";
            return Err(fault(line, message, remedy.into()));
        }
        time.push(t);
        if let (Some(column), Some(all)) = (&block_column, &mut block) {
            let n = number(column)?;
            if !(n >= 0.0 && n.fract() == 0.0 && n <= f64::from(u32::MAX)) {
                let message = format!("column {}: {n} is not the number of a line", column.name);
                return Err(fault(line, message, "write lines of the program, from 1".into()));
            }
            all.push(n as u32);
        }
        if let (Some(column), Some(all)) = (&override_column, &mut overrides) {
            all.push(number(column)?);
        }
        for ((_, joint, of, command, actual, force), into) in joint_columns.iter().zip(&mut values) {
            let factor = of.unit.scale().1;
            let [commands, actuals, forces] = into;
            for (column, into) in [(command, commands), (actual, actuals)] {
                let Some(column) = column else { continue };
                let v = number(column)?;
                within_travel(joint, v * factor)
                    .map_err(|(message, remedy)| fault(line, format!("column {}: {message}", column.name), remedy))?;
                into.push(v);
            }
            if let Some(column) = force {
                forces.push(number(column)? * of.force_factor().unwrap_or(1.0));
            }
        }
    }
    if time.len() < FEWEST_ROWS {
        let message = format!("{} rows; a move with its rests takes at least {FEWEST_ROWS}", time.len());
        return Err(fault(0, message, "record a longer piece, or faster".into()));
    }
    let (step, even) = steps_of_time(&time);
    if let Some(k) = time.windows(2).position(|w| w[1] - w[0] > GAP * step) {
        let [from, to] = [time[k], time[k + 1]];
        let message = format!(
            "a gap of {:.4} s, from {from:.4} s to {to:.4} s, among rows {step:.6} s apart: what the joints did there is not known",
            to - from
        );
        return Err(fault(k + 3, message, "split the file there, and name both parts with --trace".into()));
    }
    let mut joints: Vec<Option<JointTrace>> = machine.joints.iter().map(|_| None).collect();
    for ((index, _, of, command, actual, force), [commands, actuals, forces]) in joint_columns.into_iter().zip(values) {
        let factor = of.unit.scale().1;
        let signal = |column: Option<Column>, raw: Vec<f64>| {
            column.map(|_| Signal {
                quantum: quantum(&raw) * factor,
                noise: noise(&raw) * factor,
                values: raw.into_iter().map(|v| v * factor).collect(),
            })
        };
        let entry = JointTrace {
            command: signal(command, commands),
            actual: signal(actual, actuals),
            force: force.map(|_| forces),
            force_unit: of.force_unit,
            force_known: of.force_factor().is_some(),
        };
        if let Some(place) = joints.get_mut(index) {
            if place.is_some() {
                let message = format!("joint {} has two entries", of.name);
                return Err(fault(0, message, "write one [[joint]] for each joint".into()));
            }
            *place = Some(entry);
        }
    }
    let digest = Sha256::digest(text.as_bytes());
    let sha256 = digest.iter().map(|b| format!("{b:02x}")).collect::<String>();
    let name = file.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    Ok(Trace { name, sha256, time, step, even, joints, block, override_percent: overrides })
}

impl Trace {
    /// Name and begin of the digest, for notes.
    pub(crate) fn label(&self) -> String {
        format!("{} (sha256 {})", self.name, self.sha256.get(..SHOWN_DIGITS).unwrap_or_default())
    }
}

fn within_travel(joint: &Joint, q: f64) -> Result<(), (String, String)> {
    let Some([low, high]) = joint.travel else { return Ok(()) };
    let slack = (BEYOND_TRAVEL * (high - low)).max(BEYOND_TRAVEL_LEAST);
    if q >= low - slack && q <= high + slack {
        return Ok(());
    }
    let (unit, factor) = (joint.kind.unit(), joint.kind.unit_factor());
    let message = format!(
        "{:.3} {unit} is outside of the travel of {}, {:.3} to {:.3} {unit}",
        q * factor,
        joint.name,
        low * factor,
        high * factor
    );
    Err((message, "name the machine that was recorded, machine coordinates, and the unit of the column".into()))
}
