//! Settings of a reader as the call states them: control file, variables, offsets, start.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use proveout_machine::Machine;
use proveout_nc::{ArcTolerance, AxisValues, Control, Dialect, Settings, WorkOffset, builtin_controls};
use proveout_sim::{SimError, control_of, settings_on, with_machine};

use crate::{args::ReaderArgs, failure::Failure};

pub(crate) fn dialect_of(name: &str) -> Result<Dialect, Failure> {
    Dialect::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = Dialect::NAMES.iter().map(|(name, _)| *name).collect();
        Failure::new(format!("unknown dialect {name:?}"))
            .with_help(format!("use one of {}, or omit it", names.join(", ")))
    })
}

/// Settings for a program: of the control that the call names, else of that of the machine, then what the
/// call itself states.
pub(crate) fn settings(args: &ReaderArgs, machine: Option<&Machine>, program: &Path) -> Result<Settings, Failure> {
    let told = |e: SimError| Failure::from(&e);
    let dialect = args.dialect.as_deref().map_or(Ok(Dialect::Auto), dialect_of)?;
    let settings = match &args.control {
        Some(name) => {
            let control = Control::find(name, None).map_err(|e| told(e.into()))?;
            let spoken = control.dialect();
            let settings = Settings::of_control(control);
            // A dialect that contradicts the control is refused where the program is opened.
            Settings { dialect: if dialect == Dialect::Auto { spoken } else { dialect }, ..settings }
        }
        None => {
            let control: Option<Arc<Control>> =
                machine.map_or(Ok(None), |machine| control_of(None, machine)).map_err(told)?;
            let (settings, note) = settings_on(control.as_ref(), dialect, program).map_err(told)?;
            if let Some(note) = note {
                tell!("note: {note}");
            }
            settings
        }
    };
    stated(args, machine, settings)
}

/// The control from which a file written for the program inherits: that of the call, else of the machine; a
/// file by its full path.
pub(crate) fn parent(args: &ReaderArgs, machine: Option<&Machine>) -> Option<String> {
    let of_machine = || machine.and_then(|m| Some((m.control.file.as_deref()?, m.file().parent())));
    let (name, folder) = args.control.as_deref().map(|name| (name, None)).or_else(of_machine)?;
    if builtin_controls().any(|known| known == name) {
        return Some(name.to_owned());
    }
    let path = folder.map_or_else(|| Path::new(name).to_path_buf(), |folder| folder.join(name));
    Some(path.canonicalize().unwrap_or(path).display().to_string())
}

/// Adds what the call and the machine state.
pub(crate) fn stated(args: &ReaderArgs, machine: Option<&Machine>, settings: Settings) -> Result<Settings, Failure> {
    let mut settings = settings;
    for text in &args.variable {
        let (name, value) =
            text.split_once('=').ok_or_else(|| wrong("--variable", text, "NAME=VALUE, such as #500=1.5"))?;
        let name = name.trim();
        if name.is_empty() {
            return Err(wrong("--variable", text, "NAME=VALUE, such as #500=1.5"));
        }
        settings.variables.insert(name.to_ascii_uppercase(), number("--variable", text, value)?);
    }
    for text in &args.offset {
        let (word, offset) = offset(text)?;
        settings.work_offsets.insert(word, offset);
    }
    if let Some(text) = &args.start {
        start(text, &mut settings.start_position)?;
    }
    if let Some(feed) = args.feed {
        settings.default_feed_mm_per_min = Some(positive("--feed", feed)?);
    }
    if let Some(tolerance) = args.arc_tolerance {
        settings.arc_tolerance = Some(ArcTolerance::absolute(positive("--arc-tolerance", tolerance)?));
    }
    for folder in &args.subprograms {
        if !folder.is_dir() {
            return Err(
                Failure::new(format!("--subprograms {} is not a folder", folder.display())).with_help("check the path")
            );
        }
        settings.subprogram_folders.push(folder.clone());
    }
    if let Some(reason) = &args.without_subprograms {
        if reason.trim().is_empty() {
            return Err(Failure::new("--without-subprograms has no reason")
                .with_help("give the reason why the proof may skip these calls"));
        }
        settings.missing_subprogram = Some(reason.clone());
    }
    Ok(match machine {
        Some(machine) => with_machine(settings, machine),
        None => settings,
    })
}

fn wrong(option: &str, text: &str, want: &str) -> Failure {
    Failure::new(format!("{option} {text:?} cannot be read")).with_help(format!("write {option} {want}"))
}

fn number(option: &str, text: &str, value: &str) -> Result<f64, Failure> {
    let value = value.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    value.ok_or_else(|| {
        Failure::new(format!("{option} {text:?}: a number is missing")).with_help("write a decimal number")
    })
}

fn positive(option: &str, value: f64) -> Result<f64, Failure> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Failure::new(format!("{option} is {value}, but must be above zero")).with_help("give a number above zero"))
}

/// `G54=X,Y,Z[,A,B,C]`: mm and degrees.
fn offset(text: &str) -> Result<(String, WorkOffset), Failure> {
    let want = "G54=X,Y,Z or G54=X,Y,Z,A,B,C in mm and degrees";
    let (word, values) = text.split_once('=').ok_or_else(|| wrong("--offset", text, want))?;
    let values = values.split(',').map(|v| number("--offset", text, v)).collect::<Result<Vec<f64>, _>>()?;
    let word = word.trim().to_ascii_uppercase();
    let (translation, rotary) = match values[..] {
        _ if word.is_empty() => return Err(wrong("--offset", text, want)),
        [x, y, z] => ([x, y, z], [0.0; 3]),
        [x, y, z, a, b, c] => ([x, y, z], [a, b, c].map(f64::to_radians)),
        _ => return Err(wrong("--offset", text, want)),
    };
    Ok((word, WorkOffset { translation, rotary }))
}

/// `X0,Y0,Z100,B30`: mm and degrees.
fn start(text: &str, into: &mut AxisValues) -> Result<(), Failure> {
    let want = "X0,Y0,Z100: axis letters with mm or degrees";
    let mut seen: BTreeMap<usize, ()> = BTreeMap::new();
    for word in text.split(',') {
        let word = word.trim();
        let mut letters = word.chars();
        let axis = letters.next().and_then(|c| AxisValues::index(c.to_ascii_uppercase()));
        let axis = axis.filter(|axis| seen.insert(*axis, ()).is_none()).ok_or_else(|| wrong("--start", text, want))?;
        let value = number("--start", text, letters.as_str())?;
        into.put(axis, if (3..6).contains(&axis) { value.to_radians() } else { value });
    }
    Ok(())
}
