//! Keys of the published schemas.

use std::collections::BTreeSet;

use proveout_tests::root;
use serde_json::Value;

/// `machine/JointFile.travel_mm`: schema, table, key; the table of the file itself is a dot.
pub(crate) fn keys() -> BTreeSet<String> {
    let mut keys = BTreeSet::new();
    for name in ["scene", "machine", "tools"] {
        let path = root().join("docs/schemas").join(format!("{name}.schema.json"));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let schema: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut take = |table: &str, of: &Value| {
            let properties = of["properties"].as_object();
            keys.extend(properties.into_iter().flatten().map(|(key, _)| format!("{name}/{table}.{key}")));
        };
        take("", &schema);
        let tables = schema["$defs"].as_object();
        tables.into_iter().flatten().for_each(|(table, of)| take(table, of));
    }
    keys
}
