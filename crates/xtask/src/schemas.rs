//! JSON Schemas of the files that people and scripts read and write, made from the types that read and write them.

use std::path::Path;

use crate::{Failure, files};

/// Writes `docs/schemas/*.schema.json`; with `check`, only compares.
pub(crate) fn run(root: &Path, check: bool) -> Result<(), Failure> {
    let schemas = [
        ("machine", text(&proveout_machine::machine_schema())?),
        ("tools", proveout_tool::library_schema()),
        ("control", text(&proveout_nc::control_schema())?),
        ("scene", text(&schemars::schema_for!(proveout_sim::scene::SceneFile))?),
        ("verdict", text(&schemars::schema_for!(proveout_sim::verdict::Verdict))?),
        ("compare", text(&schemars::schema_for!(proveout_sim::compare::Comparison))?),
    ];
    for (name, text) in schemas {
        let path = root.join(format!("docs/schemas/{name}.schema.json"));
        files::put(&path, &text, check, "cargo xtask schemas")?;
        println!("{}", path.display());
    }
    Ok(())
}

fn text(schema: &schemars::Schema) -> Result<String, Failure> {
    let json = serde_json::to_string_pretty(schema).map_err(|e| Failure(format!("a schema is no JSON: {e}")))?;
    Ok(json + "\n")
}
