//! Applies a file to the data of its parents, and refuses keys that contradict each other or have
//! no effect.

use std::path::Path;

use super::error::Checked;
use super::family::ReaderFamily;
use super::file::{
    ControlFile, CycleDepthFile, CycleReturnFile, MissingSubprogramFile, ModalVariablesFile, ProgramEndFile,
    ProgramWordsFile, UnlistedMFile, WithoutHFile,
};
use super::meanings;
use super::model::Control;
use super::parameters::parameters;
use super::place::{ControlText, nearest};
use super::start::{positions, start};
use super::values::{arcs, dwell, feed, numbers};
use crate::settings::Dialect;

/// Deepest calls that a control file may allow: far more than any control has levels.
const MOST_CALLS: u64 = 1000;
/// Most jumps back that a control file may allow: days of a run.
const MOST_PASSES: u64 = 1_000_000_000_000;

/// Applies the file to the control of its parents.
pub(super) fn apply(
    control: &mut Control,
    file: &ControlFile,
    text: &ControlText<'_>,
    folder: Option<&Path>,
) -> Checked<()> {
    dialect(control, file, text)?;
    sources(file, text)?;
    assumed(control, file, text);
    control.name = match &file.name {
        Some(name) if name.trim().is_empty() => {
            return Err(text.error(
                "control-empty-text",
                &["name"],
                "the name is empty",
                "write a name, or leave it out",
            ));
        }
        Some(name) => name.clone(),
        None => stem(text.file),
    };
    start(control, &file.start, text)?;
    parameters(&mut control.parameters, &file.parameters, text)?;
    if let Some(numbers) = numbers(&file.numbers, control.whole_numbers, text)? {
        control.whole_numbers = numbers;
    }
    arcs(control, &file.arcs, text)?;
    if let Some(g76) = file.cycles.g76 {
        control.fine_boring = g76;
    }
    if let Some(returns) = file.cycles.returns {
        control.stated_returns = matches!(returns, CycleReturnFile::M53);
    }
    if let Some(depth) = file.cycles.depth {
        control.depth_in_i = matches!(depth, CycleDepthFile::I);
    }
    if let Some(words) = file.program.words {
        control.osp_words = matches!(words, ProgramWordsFile::Osp);
        control.grbl_words = matches!(words, ProgramWordsFile::Grbl);
        control.mach3_words = matches!(words, ProgramWordsFile::Mach3);
    }
    if let Some(variables) = file.program.modal_variables {
        control.mitsubishi_variables = matches!(variables, ModalVariablesFile::Mitsubishi);
    }
    if let Some(end) = file.program.end {
        control.ends_with_text = end == ProgramEndFile::Text;
    }
    if let Some(without) = file.tool_length.without_h {
        control.length_of_tool = matches!(without, WithoutHFile::Tool);
    }
    positions(&mut control.tool_change, &file.tool_change.position_mm, false, &["tool_change", "position_mm"], text)?;
    dwell(control, file, text)?;
    feed(control, file, text)?;
    if let Some(interpolation) = file.orientation.interpolation {
        control.orientation = interpolation;
    }
    if let Some(levels) = &file.blocks.skipped_levels {
        control.skipped_levels = skipped(levels, control.dialect, text)?;
        control.skip_stated = true;
    }
    for (name, value) in &file.variables {
        if !value.is_finite() {
            let path = ["variables", name.as_str()];
            return Err(text.error(
                "control-value",
                &path,
                format!("{value} is not a valid value"),
                "write a finite number",
            ));
        }
        control.variables.insert(name.trim().to_ascii_uppercase(), *value);
    }
    subprograms(control, file, text, folder)?;
    for (key, list, into) in [
        ("header", &file.program.header, &mut control.header),
        ("trailer", &file.program.trailer, &mut control.trailer),
    ] {
        let Some(list) = list else { continue };
        if list.iter().any(|pattern| pattern.trim().trim_matches('*').is_empty()) {
            let message = "a pattern of `*` alone would match every line";
            return Err(text.error("control-pattern", &["program", key], message, "write what the lines begin with"));
        }
        into.clone_from(list);
    }
    limits(control, file, text)?;
    if let Some(unlisted) = file.unlisted.m {
        control.refuses_unlisted = unlisted == UnlistedMFile::Refuse;
    }
    meanings::apply(control, &file.words, text)
}

fn limits(control: &mut Control, file: &ControlFile, text: &ControlText<'_>) -> Checked<()> {
    let limits = &mut control.limits;
    let file = &file.limits;
    if let Some(depth) = file.call_depth {
        limits.max_call_depth = depth;
    }
    for (value, into) in [(file.passes, &mut limits.max_loop_passes), (file.idle_passes, &mut limits.max_idle_passes)] {
        if let Some(value) = value {
            *into = value;
        }
    }
    let given = [
        ("call_depth", file.call_depth.map(u64::from), MOST_CALLS),
        ("passes", file.passes, MOST_PASSES),
        ("idle_passes", file.idle_passes, MOST_PASSES),
    ];
    for (key, value, most) in given {
        if let Some(value) = value.filter(|value| !(1..=most).contains(value)) {
            let message = format!("{value} is not a valid limit");
            return Err(text.error("control-value", &["limits", key], message, format!("write 1 to {most}")));
        }
    }
    Ok(())
}

/// `fanuc-30i` of `built-in fanuc-30i` and of `shop/fanuc-30i.toml`.
fn stem(file: &str) -> String {
    let name = file.strip_prefix("built-in ").unwrap_or(file);
    Path::new(name).file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// The language, and keys that have no effect in it.
fn dialect(control: &mut Control, file: &ControlFile, text: &ControlText<'_>) -> Checked<()> {
    if let Some(named) = file.dialect {
        if control.dialect != Dialect::Auto && control.dialect != named {
            let message = format!(
                "the dialect is {}, and that of the parent {:?} is {}",
                named.name(),
                control.name,
                control.dialect.name()
            );
            return Err(text.error(
                "control-contradiction",
                &["dialect"],
                message,
                "remove it, or inherit from another control",
            ));
        }
        control.dialect = named;
    }
    let Some(family) = ReaderFamily::of(control.dialect) else {
        let remedy = "add dialect = \"fanuc\" (or another language), or inherits = \"fanuc-30i\" (or another control)";
        return Err(text.error(
            "control-no-dialect",
            &["dialect"],
            "the file does not state the dialect of the programs",
            remedy,
        ));
    };
    let foreign = match file.program.words {
        Some(ProgramWordsFile::Osp) => (family == ReaderFamily::LinuxCnc).then_some("osp"),
        Some(ProgramWordsFile::Grbl) => (family == ReaderFamily::MacroB).then_some("grbl"),
        Some(ProgramWordsFile::Mach3) => (family == ReaderFamily::MacroB).then_some("mach3"),
        None => None,
    };
    if let Some(words) = foreign {
        let message =
            format!("words = \"{words}\" have no place in programs in the dialect {}", control.dialect.name());
        return Err(text.error(
            "control-contradiction",
            &["program", "words"],
            message,
            "remove it, or name another dialect",
        ));
    }
    for path in text.paths() {
        let keys: Vec<&str> = path.splitn(2, '.').collect();
        if !family.uses(&keys) {
            let message = format!("the key has no effect on programs in the dialect {}", control.dialect.name());
            return Err(text.error("control-no-effect", &keys, message, "remove it"));
        }
    }
    Ok(())
}

/// Sources and assumptions must name keys of the file.
fn sources(file: &ControlFile, text: &ControlText<'_>) -> Checked<()> {
    let paths: Vec<String> =
        text.paths().into_iter().filter(|p| !p.starts_with("source.") && !p.starts_with("assumed.")).collect();
    for (table, what, entries) in [("source", "source", &file.source), ("assumed", "reason", &file.assumed)] {
        for (key, words) in entries {
            let at = [table, key.as_str()];
            if words.trim().is_empty() {
                let remedy = match table {
                    "source" => "write where the value comes from",
                    _ => "write why the value is likely",
                };
                return Err(text.error("control-empty-text", &at, format!("the {what} is empty"), remedy));
            }
            let known = key == "*" || paths.iter().any(|p| p == key || p.split('.').next() == Some(key));
            if !known {
                let names: Vec<&str> = paths.iter().map(String::as_str).collect();
                let message = format!("the file has no key {key}");
                return Err(text.error("control-unknown-key", &at, message, nearest(key, &names)));
            }
        }
    }
    Ok(())
}

/// What a file states ends the assumption of its parents about the same key; what it assumes comes on top.
fn assumed(control: &mut Control, file: &ControlFile, text: &ControlText<'_>) {
    let stated = text.paths();
    control.assumed.retain(|key, _| !stated.contains(key));
    control.assumed.extend(file.assumed.iter().map(|(key, why)| (key.clone(), why.clone())));
}

fn skipped(levels: &[u8], dialect: Dialect, text: &ControlText<'_>) -> Checked<u16> {
    let heidenhain = matches!(dialect, Dialect::Heidenhain | Dialect::HeidenhainIso);
    let most = if heidenhain { 0 } else { 9 };
    if let Some(wrong) = levels.iter().find(|level| **level > most) {
        let message = format!("{wrong} is not a block skip level");
        let remedy = if heidenhain { "write 0: the control has one level" } else { "write 0 to 9" };
        return Err(text.error("control-value", &["blocks", "skipped_levels"], message, remedy));
    }
    Ok(levels.iter().fold(0, |bits, level| bits | 1 << level))
}

fn subprograms(
    control: &mut Control,
    file: &ControlFile,
    text: &ControlText<'_>,
    folder: Option<&Path>,
) -> Checked<()> {
    let file = &file.subprograms;
    if let Some(folders) = &file.folders {
        control.folders.clear();
        for name in folders {
            let path = folder.map_or_else(|| name.into(), |folder| folder.join(name));
            if !path.is_dir() {
                let message = format!("{} is not a folder", path.display());
                return Err(text.error(
                    "control-value",
                    &["subprograms", "folders"],
                    message,
                    "check the path; relative ones begin at the control file",
                ));
            }
            control.folders.push(path);
        }
    }
    match (file.missing, &file.missing_reason) {
        (None, None) => {}
        (Some(MissingSubprogramFile::Refuse), None) => control.missing_subprogram = None,
        (Some(MissingSubprogramFile::Note), Some(reason)) if !reason.trim().is_empty() => {
            control.missing_subprogram = Some(reason.clone());
        }
        (Some(MissingSubprogramFile::Note), _) => {
            let message = "no reason is given for leaving out missing subprograms";
            return Err(text.error(
                "control-contradiction",
                &["subprograms", "missing"],
                message,
                "add missing_reason",
            ));
        }
        (_, Some(_)) => {
            let message = "a reason is given, but missing subprograms are not left out";
            let path = ["subprograms", "missing_reason"];
            return Err(text.error(
                "control-contradiction",
                &path,
                message,
                "write missing = \"note\", or remove the reason",
            ));
        }
    }
    Ok(())
}
