//! The control file that is being written.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::Advised;
use super::proposals::Candidate;
use crate::diagnostic::Diagnostic;
use crate::settings::Dialect;

/// Characters of a line of the program that a comment shows.
const SHOWN: usize = 90;
/// Faults that the file names.
const SHOWN_FAULTS: usize = 5;

/// A control file as statements.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    inherits: Option<String>,
    dialect: Dialect,
    pub(super) statements: Vec<Advised>,
}

impl Draft {
    pub(super) fn new(inherits: Option<String>, dialect: Dialect) -> Self {
        Self { inherits, dialect, statements: Vec::new() }
    }

    pub(super) fn with(&self, candidate: &Candidate) -> Self {
        let mut next = self.clone();
        next.statements.push(candidate.advised.clone());
        next
    }

    /// The file, with the faults that it does not mend in comments.
    pub(super) fn file(&self, left: &[Diagnostic]) -> String {
        let mut out = String::new();
        // Writing to a text does not fail.
        self.write(&mut out, left).ok();
        out
    }

    fn write(&self, out: &mut String, left: &[Diagnostic]) -> std::fmt::Result {
        writeln!(
            out,
            "# Written from the program by `proveout nc --write-control`. Each statement is the most likely one;"
        )?;
        writeln!(
            out,
            "# what [assumed] lists leaves the gate `program` unchecked: confirm it and take it out of that table."
        )?;
        writeln!(out)?;
        match &self.inherits {
            Some(name) => writeln!(out, "inherits = {}", quoted(name))?,
            None => writeln!(out, "dialect = {}", quoted(self.dialect.name()))?,
        }
        let mut tables: BTreeMap<&str, Vec<&Advised>> = BTreeMap::new();
        for statement in &self.statements {
            let table = statement.key.split_once('.').map_or("", |(table, _)| table);
            tables.entry(table).or_default().push(statement);
        }
        for (table, statements) in &tables {
            writeln!(out, "\n[{table}]")?;
            for statement in statements {
                let key = statement.key.split_once('.').map_or(statement.key.as_str(), |(_, key)| key);
                let shown: String = one_line(statement.line.trim()).chars().take(SHOWN).collect();
                writeln!(out, "# {}: {shown}", statement.place())?;
                writeln!(out, "# {}", one_line(&statement.meaning))?;
                writeln!(out, "{} = {}", bare(key), statement.value)?;
            }
        }
        if !self.statements.is_empty() {
            writeln!(out, "\n[assumed]")?;
        }
        for statement in &self.statements {
            writeln!(out, "{} = {}", quoted(&statement.key), quoted(&statement.why))?;
        }
        if !left.is_empty() {
            writeln!(out, "\n# No statement of a control file mends {} faults of the program:", left.len())?;
        }
        for fault in left.iter().take(SHOWN_FAULTS) {
            writeln!(out, "# {}", one_line(&fault.to_string()))?;
        }
        Ok(())
    }
}

/// A key as TOML writes it.
fn bare(key: &str) -> String {
    let plain = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if plain { key.to_owned() } else { quoted(key) }
}

/// A text as TOML writes it on one line.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => {
                out.push('\\');
                out.push(c);
            }
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A text that stays within its comment.
pub(super) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
