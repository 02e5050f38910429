//! What a scene holds, and copies of it with other values.

use std::path::{Path, PathBuf};

use proveout::front::CommandError;
use proveout_sim::{SimError, scene::Scene};
use pyo3::{prelude::*, types::PyDict};
use toml::{Table, Value};

use crate::errors::raised;

/// Keys whose text is a path relative to the scene.
const PATHS: [&str; 7] = ["machine", "tools", "mesh", "sections", "file", "from_run", "control"];

/// Name, description, programs with their files, machine, file and folder of a scene.
#[pyfunction]
pub(crate) fn scene_facts(py: Python<'_>, scene: PathBuf) -> PyResult<Py<PyDict>> {
    let scene = py.detach(|| Scene::read(&scene)).map_err(|e| raised(py, &SimError::from(e).into()))?;
    let facts = PyDict::new(py);
    facts.set_item("name", &scene.file.name)?;
    facts.set_item("description", &scene.file.description)?;
    facts.set_item("programs", scene.file.program.iter().map(|p| p.name.as_str()).collect::<Vec<_>>())?;
    facts.set_item("machine", scene.resolve(&scene.file.machine))?;
    facts.set_item("path", &scene.path)?;
    facts.set_item("folder", &scene.folder)?;
    Ok(facts.unbind())
}

/// Writes the text of a scene with other values to `to`, so that it means the same from there; with
/// `programs` these alone are in it.
///
/// `values` are TOML documents `value = ...` by the path of their key; an empty document takes the key out.
#[pyfunction]
pub(crate) fn scene_copy(
    py: Python<'_>,
    scene: PathBuf,
    to: PathBuf,
    values: Vec<(String, String)>,
    programs: Option<Vec<String>>,
) -> PyResult<()> {
    let made = || -> Result<(), CommandError> {
        let scene = Scene::read(&scene).map_err(SimError::from)?;
        let text = std::fs::read_to_string(&scene.path)
            .map_err(|e| CommandError::new(format!("{}: {e}", scene.path.display()), ""))?;
        let mut file: Table =
            text.parse().map_err(|e| CommandError::new(format!("{}: {e}", scene.path.display()), ""))?;
        let folder = std::path::absolute(&scene.folder).unwrap_or_else(|_| scene.folder.clone());
        for (key, value) in &values {
            let value: Table =
                value.parse().map_err(|e| CommandError::new(format!("{key}: {e}"), "give a TOML value"))?;
            put(&mut file, key, value.get("value").cloned())?;
        }
        make_absolute(&mut file, &folder);
        if let Some(programs) = &programs {
            keep_programs(&mut file, programs)?;
        }
        let text = toml::to_string(&file).map_err(|e| CommandError::new(e, ""))?;
        std::fs::write(&to, text).map_err(|e| CommandError::new(format!("{} cannot be written: {e}", to.display()), ""))
    };
    py.detach(made).map_err(|fault| raised(py, &fault))
}

/// Paths that lead from the folder of the scene lead from anywhere.
fn make_absolute(table: &mut Table, folder: &Path) {
    let whole = |text: &mut String| {
        let path = folder.join(text.as_str());
        // A built-in control is named by a word that is no file.
        if path.exists() {
            *text = path.display().to_string();
        }
    };
    for (key, value) in table.iter_mut() {
        match value {
            Value::String(text) if PATHS.contains(&key.as_str()) => whole(text),
            Value::Array(all) if key == "subprograms" => {
                all.iter_mut().for_each(|v| {
                    if let Value::String(text) = v {
                        whole(text)
                    }
                });
            }
            Value::Table(inner) => make_absolute(inner, folder),
            Value::Array(all) => {
                all.iter_mut().for_each(|v| {
                    if let Value::Table(inner) = v {
                        make_absolute(inner, folder)
                    }
                });
            }
            _ => {}
        }
    }
}

/// Puts a value under a key such as `control.joint_limits.A.max_velocity_deg_s` or `program.original.file`: a
/// table of a list is meant by its `name`, or by its number from 0.
fn put(table: &mut Table, key: &str, value: Option<Value>) -> Result<(), CommandError> {
    let wrong = |message: String| {
        CommandError::new(format!("{key}: {message}"), "write a dotted key, such as control.dynamics")
    };
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    if first.is_empty() {
        return Err(wrong("a part of the key is empty".to_owned()));
    }
    let Some(rest) = rest else {
        match value {
            Some(value) => table.insert(first.to_owned(), value),
            None => table.remove(first),
        };
        return Ok(());
    };
    match table.entry(first.to_owned()).or_insert_with(|| Value::Table(Table::new())) {
        Value::Table(inner) => put(inner, rest, value),
        Value::Array(all) => {
            let (which, rest) = rest.split_once('.').ok_or_else(|| wrong(format!("{first} is a list")))?;
            let names = |v: &Value| v.get("name").and_then(Value::as_str).map(str::to_owned);
            let known: Vec<String> = all.iter().filter_map(names).collect();
            let place = all.iter().position(|v| names(v).as_deref() == Some(which));
            let place = place.or_else(|| which.parse().ok()).filter(|k| *k < all.len());
            match place.and_then(|k| all.get_mut(k)) {
                Some(Value::Table(inner)) => put(inner, rest, value),
                _ => Err(wrong(format!("{first} has no entry {which:?}; entries: {}", known.join(", ")))),
            }
        }
        _ => Err(wrong(format!("{first} is a value, not a table"))),
    }
}

/// Leaves these programs alone in a scene, in their order, with what is said of them.
fn keep_programs(file: &mut Table, programs: &[String]) -> Result<(), CommandError> {
    let Some(Value::Array(all)) = file.get_mut("program") else { return Ok(()) };
    let name = |v: &Value| v.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
    let known: Vec<String> = all.iter().map(&name).collect();
    if let Some(missing) = programs.iter().find(|p| !known.contains(p)) {
        let remedy = format!("programs of the scene: {}", known.join(", "));
        return Err(CommandError::new(format!("no program {missing:?} in the scene"), &remedy));
    }
    let texts: Vec<(String, Value)> = all.iter().map(|v| (name(v), v.clone())).collect();
    all.retain(|v| programs.contains(&name(v)));
    all.sort_by_key(|v| programs.iter().position(|p| *p == name(v)));
    // A program that is made from one that is left out still needs its text.
    let sources: Vec<String> = all
        .iter()
        .filter_map(|v| v.get("reschedule")?.get("from")?.as_str().map(str::to_owned))
        .filter(|from| !programs.contains(from))
        .collect();
    all.extend(texts.into_iter().filter(|(n, _)| sources.contains(n)).map(|(_, v)| v));
    let kept: Vec<String> = all.iter().map(&name).collect();
    let Some(Value::Table(compare)) = file.get_mut("compare") else { return Ok(()) };
    let gone = |v: Option<&Value>| v.and_then(Value::as_str).is_some_and(|n| !kept.iter().any(|k| k == n));
    for key in ["baseline", "null_program"] {
        if gone(compare.get(key)) {
            compare.remove(key);
        }
    }
    // What may be chosen of a program that is left out, as `program.NAME.KEY`.
    let of_gone = |v: Option<&Value>| {
        let rest = v.and_then(Value::as_str).and_then(|key| key.strip_prefix("program."));
        rest.is_some_and(|rest| !kept.iter().any(|k| rest.strip_prefix(k.as_str()).is_some_and(|r| r.starts_with('.'))))
    };
    if let Some(Value::Array(choices)) = compare.get_mut("choice") {
        choices.retain(|c| !of_gone(c.get("key")));
    }
    for list in ["published", "expect"] {
        if let Some(Value::Array(entries)) = compare.get_mut(list) {
            entries.retain(|e| !gone(e.get("program")) && !gone(e.get("against")));
        }
    }
    if let Some(Value::Array(names)) = compare.get_mut("must_pass") {
        names.retain(|n| !gone(Some(n)));
        if names.is_empty() {
            compare.remove("must_pass");
        }
    }
    Ok(())
}
