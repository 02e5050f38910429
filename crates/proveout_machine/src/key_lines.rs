//! Lines of the keys of a machine file, kept with the machine so that remarks can name their place.

use std::{collections::BTreeMap, path::PathBuf};

use proveout_input::Document;
use toml::de::DeValue;

/// File and the line of each key, by its path as errors show it (`joint.X.travel_mm`).
#[derive(Clone, Debug, Default)]
pub(crate) struct KeyLines {
    pub(crate) file: PathBuf,
    lines: BTreeMap<String, usize>,
}

impl KeyLines {
    pub(crate) fn new(source: &Document<'_>) -> Self {
        let mut places = Self { file: source.file().into(), lines: BTreeMap::new() };
        if let Some(tree) = source.tree() {
            for (key, value) in tree {
                let name = key.get_ref().to_string();
                places.lines.insert(name.clone(), source.line(key.span().start));
                places.add(source, &name, value.get_ref());
            }
        }
        places
    }

    /// Adds all keys below a value; members of lists go by their `name`, error tables by their `joint`.
    fn add(&mut self, source: &Document<'_>, path: &str, value: &DeValue<'_>) {
        if let Some(table) = value.as_table() {
            for (key, inner) in table {
                let below = format!("{path}.{}", key.get_ref());
                self.lines.entry(below.clone()).or_insert_with(|| source.line(key.span().start));
                self.add(source, &below, inner.get_ref());
            }
        }
        for (i, item) in value.as_array().into_iter().flatten().enumerate() {
            let Some(table) = item.get_ref().as_table() else { continue };
            let name = ["name", "joint"].iter().find_map(|k| table.get(*k)?.get_ref().as_str());
            let below = name.map_or_else(|| format!("{path}[{i}]"), |n| format!("{path}.{n}"));
            self.lines.entry(below.clone()).or_insert_with(|| source.line(item.span().start));
            self.add(source, &below, item.get_ref());
        }
    }

    /// Line of a key, or of its table if the key is missing; 0 if neither is in the file.
    pub(crate) fn line(&self, key: &str) -> usize {
        let mut key = key;
        loop {
            if let Some(line) = self.lines.get(key) {
                return *line;
            }
            match key.rsplit_once('.') {
                Some((table, _)) => key = table,
                None => return 0,
            }
        }
    }

    /// The key of a table that states the quantity of `key`, perhaps in another unit.
    pub(crate) fn given<'k>(&self, table: &str, key: &'k str) -> &'k str {
        match key {
            "max_velocity_deg_s" if self.lines.contains_key(&format!("{table}.max_velocity_rev_min")) => {
                "max_velocity_rev_min"
            }
            "rapid_velocity_deg_s" if self.lines.contains_key(&format!("{table}.rapid_velocity_rev_min")) => {
                "rapid_velocity_rev_min"
            }
            _ => key,
        }
    }
}
