//! JSON Schemas of the files that people and scripts read and write, made from the types that read and write them.

use std::path::Path;

use crate::{Failure, files};

/// Writes `docs/schemas/*.schema.json`; with `check`, only compares.
pub(crate) fn run(root: &Path, check: bool) -> Result<(), Failure> {
    let schemas = [
        ("scene", schemars::schema_for!(proveout_sim::scene::SceneFile)),
        ("verdict", schemars::schema_for!(proveout_sim::verdict::Verdict)),
    ];
    for (name, schema) in schemas {
        let mut text = serde_json::to_string_pretty(&schema).map_err(|e| Failure(format!("schema {name}: {e}")))?;
        text.push('\n');
        let path = root.join(format!("docs/schemas/{name}.schema.json"));
        files::put(&path, &text, check, "cargo run --package xtask --features schemas -- schemas")?;
        println!("{}", path.display());
    }
    Ok(())
}
