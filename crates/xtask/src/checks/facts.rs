//! No code looks into a sentence to find a fact: what a sentence says is a field, an enum or a typed cause as
//! well.

use std::path::Path;

use super::style;
use crate::{TaskError, files};

/// Names of values that hold sentences for people.
const SENTENCES: [&str; 14] = [
    "basis", "help", "message", "note", "notes", "reason", "reasons", "remark", "remarks", "remedy", "summary",
    "title", "why", "warning",
];
/// Calls that look into a text.
const LOOKS: [&str; 9] = [
    "contains",
    "ends_with",
    "find",
    "matches",
    "rsplit_once",
    "split_once",
    "starts_with",
    "strip_prefix",
    "strip_suffix",
];
/// Files that may, with the number of their places and the cause.
const KNOWN: [(&str, usize, &str); 2] = [
    ("crates/proveout_input/src/document/toml_fault.rs", 6, "errors of the TOML reader are texts alone"),
    ("crates/proveout_machine/src/summary.rs", 1, "notes of machine files name value and source in one text"),
];

/// Fails with every place that looks into a sentence.
pub(crate) fn check(root: &Path) -> Result<String, TaskError> {
    let mut faults = Vec::new();
    for path in style::text_files(root)?.into_iter().filter(|path| style::is_production(path)) {
        let name = path.to_string_lossy().replace('\\', "/");
        if !name.ends_with(".rs") || name.contains("xtask") {
            continue;
        }
        let text = files::get(&root.join(&path))?;
        let found = places(style::without_tests(&text));
        let allowed = KNOWN.iter().find(|(file, ..)| *file == name).map_or(0, |(_, count, _)| *count);
        if found.len() > allowed {
            faults.extend(found.iter().map(|(line, call)| format!("{name}:{line}: {call}")));
        }
    }
    if faults.is_empty() {
        return Ok(format!(
            "{} known places look into a sentence",
            KNOWN.iter().map(|(_, count, _)| count).sum::<usize>()
        ));
    }
    let help =
        "these places look into a sentence for a fact: make the fact a field or an enum where the sentence is made";
    Err(TaskError(format!("{help}\n{}", faults.join("\n"))))
}

/// Lines and calls that look into a sentence.
fn places(text: &str) -> Vec<(usize, String)> {
    let mut out = Vec::new();
    for (k, line) in text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//")) {
        for look in LOOKS {
            let call = format!(".{look}(");
            for (at, _) in line.match_indices(&call) {
                let before = line[..at].trim_end_matches("()").trim_end_matches(".as_str").trim_end_matches(".get_ref");
                let word = before.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
                // Whether a list has an element is no look into a text.
                let of_list = line[at + call.len()..].starts_with('&') && look == "contains";
                if SENTENCES.contains(&word) && !of_list {
                    out.push((k + 1, format!("{word}{call}")));
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_into_a_sentence_is_found_and_others_are_not() {
        let found = |line: &str| places(line).len();
        assert_eq!(found("if plan.mount.reason.starts_with(\"chosen\") {"), 1);
        assert_eq!(found("let name = fault.message.strip_prefix(\"unknown\")?;"), 1);
        assert_eq!(found("if error.message().contains(\"untagged\") {"), 1);
        assert_eq!(found("if reasons.contains(&why) && name.starts_with('$') {"), 0);
        assert_eq!(found("// message.contains(x)"), 0);
    }
}
