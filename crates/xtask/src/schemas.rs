//! JSON Schemas of the files that people and scripts read and write, made from the types that read and write
//! them.

use std::path::Path;

use crate::{TaskError, files};

/// Writes `docs/schemas/*.schema.json`; with `check`, only compares.
pub(crate) fn run(root: &Path, check: bool) -> Result<(), TaskError> {
    let schemas = [
        ("machine", bounded(&text(&proveout_machine::machine_schema())?, false)?),
        ("tools", bounded(&proveout_tool::library_schema(), true)?),
        ("control", text(&proveout_nc::control_schema())?),
        ("scene", bounded(&text(&schemars::schema_for!(proveout_sim::scene::SceneFile))?, true)?),
        ("job", text(&schemars::schema_for!(proveout_sim::job::JobFile))?),
        ("job-verdict", text(&schemars::schema_for!(proveout_sim::job::JobVerdict))?),
        ("sweep", text(&schemars::schema_for!(proveout_sim::sweep::SweepFile))?),
        ("verdict", text(&schemars::schema_for!(proveout_sim::verdict::Verdict))?),
        ("compare", text(&schemars::schema_for!(proveout_sim::compare::Comparison))?),
    ];
    for (name, text) in schemas {
        let text = joined_paragraphs(&text)?;
        let path = root.join(format!("docs/schemas/{name}.schema.json"));
        files::put(&path, &text, check, "cargo xtask schemas")?;
        println!("{}", path.display());
    }
    Ok(())
}

/// A schema whose descriptions have one line a paragraph: lines of comments are broken for readers of the
/// code.
fn joined_paragraphs(schema: &str) -> Result<String, TaskError> {
    fn join(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(fields) => {
                for (key, field) in fields {
                    match field {
                        serde_json::Value::String(text) if key == "description" => {
                            let paragraphs: Vec<String> = text
                                .split("\n\n")
                                .map(|p| p.split('\n').map(str::trim).collect::<Vec<_>>().join(" "))
                                .collect();
                            *text = paragraphs.join("\n\n");
                        }
                        other => join(other),
                    }
                }
            }
            serde_json::Value::Array(items) => items.iter_mut().for_each(join),
            _ => {}
        }
    }
    let fail = |e: serde_json::Error| TaskError(format!("a schema is not valid JSON: {e}"));
    let mut value: serde_json::Value = serde_json::from_str(schema).map_err(fail)?;
    join(&mut value);
    Ok(serde_json::to_string_pretty(&value).map_err(fail)? + "\n")
}

/// A schema with the ranges of its quantities; with inches where a file may count in them.
fn bounded(schema: &str, inches: bool) -> Result<String, TaskError> {
    let fail = |e: serde_json::Error| TaskError(format!("a schema is not valid JSON: {e}"));
    let mut value: serde_json::Value = serde_json::from_str(schema).map_err(fail)?;
    proveout_input::add_ranges_to_schema(&mut value);
    if inches {
        proveout_input::add_inches_to_schema(&mut value);
    }
    Ok(serde_json::to_string_pretty(&value).map_err(fail)? + "\n")
}

fn text(schema: &schemars::Schema) -> Result<String, TaskError> {
    let json =
        serde_json::to_string_pretty(schema).map_err(|e| TaskError(format!("a schema is not valid JSON: {e}")))?;
    Ok(json + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the tests and not in a step of `ci`: a build of its own for the types of the product takes minutes.
    /// With `PROVEOUT_SCHEMAS=write` it writes the files instead of comparing them, after a build of all
    /// tests.
    #[test]
    fn schemas_are_those_of_the_types() {
        let check = std::env::var_os("PROVEOUT_SCHEMAS").is_none_or(|word| word != "write");
        run(&crate::workspace_root(), check).expect("the schemas of docs/schemas");
    }

    #[test]
    fn a_paragraph_of_a_description_is_one_line() {
        let text = r#"{ "description": "one\ntwo\n\nthree", "properties": { "description": { "type": "string" } } }"#;
        let joined = joined_paragraphs(text).expect("JSON");
        assert!(joined.contains(r#""one two\n\nthree""#) && joined.contains(r#""type": "string""#), "{joined}");
    }

    #[test]
    fn another_schema_is_refused() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("docs/schemas");
        std::fs::create_dir_all(&folder).expect("a folder");
        run(root.path(), false).expect("written");
        run(root.path(), true).expect("the same");
        std::fs::write(folder.join("scene.schema.json"), "{}\n").expect("written");
        let message = run(root.path(), true).expect_err("another schema").0;
        assert!(message.contains("scene.schema.json") && message.contains("cargo xtask schemas"), "{message}");
    }
}
