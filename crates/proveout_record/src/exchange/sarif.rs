//! SARIF 2.1.0 (OASIS standard, 2020): one run of the tool, a result for each finding, a notification and an
//! open result for each gate that is not checked.

use proveout_sim::{digest::of_bytes, finding::Severity};
use serde::Serialize;
use serde_json::{Map, Value};

use super::{CaseAnswer, ReportedItem, ReportedSuite};
use crate::error::RecordError;

const SCHEMA: &str = "https://json.schemastore.org/sarif-2.1.0.json";
/// Digits of a fingerprint.
const FINGERPRINT: usize = 32;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Log<'a> {
    #[serde(rename = "$schema")]
    schema: &'static str,
    version: &'static str,
    runs: [Run<'a>; 1],
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Run<'a> {
    tool: Tool<'a>,
    column_kind: &'static str,
    invocations: [Invocation; 1],
    results: Vec<Outcome<'a>>,
}

#[derive(Serialize)]
struct Tool<'a> {
    driver: Driver<'a>,
}

#[derive(Serialize)]
struct Driver<'a> {
    name: &'static str,
    version: &'static str,
    rules: Vec<Rule<'a>>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Rule<'a> {
    id: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    short_description: Option<Message<'a>>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Invocation {
    execution_successful: bool,
    tool_execution_notifications: Vec<Notification>,
}

#[derive(Serialize)]
struct Notification {
    level: &'static str,
    message: OwnMessage,
}

#[derive(Serialize)]
struct OwnMessage {
    text: String,
}

#[derive(Serialize)]
struct Message<'a> {
    text: &'a str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Outcome<'a> {
    rule_id: &'a str,
    rule_index: usize,
    kind: &'static str,
    level: &'static str,
    message: OwnMessage,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    locations: Vec<Location>,
    #[serde(skip_serializing_if = "Map::is_empty")]
    partial_fingerprints: Map<String, Value>,
    properties: Map<String, Value>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Location {
    physical_location: PhysicalLocation,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct PhysicalLocation {
    artifact_location: ArtifactLocation,
    #[serde(skip_serializing_if = "Option::is_none")]
    region: Option<Region>,
}

#[derive(Serialize)]
struct ArtifactLocation {
    uri: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Region {
    start_line: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    start_column: Option<u32>,
}

/// The suites as one SARIF log. A result's fingerprint is of its code, its file and the text of its line, so
/// that lines above it may come and go. Two findings of one line differ by a running number.
///
/// # Errors
/// [`RecordError::Page`] when a value cannot be written as JSON, which is a fault of this crate.
pub fn sarif(suites: &[ReportedSuite]) -> Result<String, RecordError> {
    let mut rules: Vec<Rule<'_>> = Vec::new();
    let mut results = Vec::new();
    let mut notifications = Vec::new();
    let mut seen = std::collections::BTreeMap::<String, u32>::new();
    for suite in suites {
        for item in &suite.items {
            let rule_index = place(&mut rules, &item.code, &item.summary);
            results.push(result(suite, item, rule_index, &mut seen));
        }
        for case in suite.cases.iter().filter(|c| c.answer == CaseAnswer::Unchecked) {
            let text = format!("{}: gate {} is unchecked: {}", suite.name, case.name, case.reason);
            notifications.push(Notification { level: "warning", message: OwnMessage { text: text.clone() } });
            results.push(Outcome {
                rule_id: UNCHECKED.0,
                rule_index: place(&mut rules, UNCHECKED.0, UNCHECKED.1),
                kind: "open",
                level: "none",
                message: OwnMessage { text },
                locations: Vec::new(),
                partial_fingerprints: Map::new(),
                properties: [("gate", &case.name), ("program", &suite.name)]
                    .map(|(key, value)| (key.to_owned(), Value::from(value.as_str())))
                    .into_iter()
                    .collect(),
            });
        }
    }
    let log = Log {
        schema: SCHEMA,
        version: "2.1.0",
        runs: [Run {
            tool: Tool { driver: Driver { name: "proveout", version: env!("CARGO_PKG_VERSION"), rules } },
            column_kind: "unicodeCodePoints",
            invocations: [Invocation {
                execution_successful: suites.iter().all(|s| s.executed),
                tool_execution_notifications: notifications,
            }],
            results,
        }],
    };
    let text = serde_json::to_string_pretty(&log).map_err(|e| RecordError::Page { message: e.to_string() })?;
    Ok(text + "\n")
}

/// Rule of a gate that is not checked.
const UNCHECKED: (&str, &str) = ("gate-unchecked", "A gate is not checked: this never counts as passed.");

/// Index of the rule with this id.
fn place<'a>(rules: &mut Vec<Rule<'a>>, id: &'a str, summary: &'a str) -> usize {
    if let Some(at) = rules.iter().position(|r| r.id == id) {
        return at;
    }
    let short_description = (!summary.is_empty()).then_some(Message { text: summary });
    rules.push(Rule { id, short_description });
    rules.len() - 1
}

fn result<'a>(
    suite: &ReportedSuite,
    item: &'a ReportedItem,
    rule_index: usize,
    seen: &mut std::collections::BTreeMap<String, u32>,
) -> Outcome<'a> {
    let mut fingerprints = Map::new();
    if !item.line_text.is_empty() {
        let file = item.file.as_deref().unwrap_or_default();
        let mut digest = of_bytes([&item.code, file, item.line_text.trim()].join("\0").as_bytes());
        digest.truncate(FINGERPRINT);
        let number = seen.entry(digest.clone()).and_modify(|n| *n += 1).or_insert(1);
        fingerprints.insert("codeFileLineText/v1".to_owned(), format!("{digest}:{number}").into());
    }
    let region = item
        .line
        .filter(|line| *line > 0)
        .map(|start_line| Region { start_line, start_column: item.column.filter(|column| *column > 0) });
    let location = |file: &String| Location {
        physical_location: PhysicalLocation { artifact_location: ArtifactLocation { uri: uri(file) }, region },
    };
    let mut properties = item.more.clone();
    properties.insert("program".to_owned(), suite.name.as_str().into());
    if let Some(case) = &item.case {
        properties.insert("gate".to_owned(), case.as_str().into());
    }
    Outcome {
        rule_id: &item.code,
        rule_index,
        kind: if item.severity == Severity::Info { "informational" } else { "fail" },
        level: match item.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            // Required where the kind is not `fail` (section 3.27.10).
            Severity::Info => "none",
        },
        message: OwnMessage { text: item.message.clone() },
        locations: item.file.as_ref().map(location).into_iter().collect(),
        partial_fingerprints: fingerprints,
        properties,
    }
}

/// A path as a URI reference (RFC 3986): a relative one stays relative, an absolute one becomes a `file` URI.
fn uri(path: &str) -> String {
    let path = path.replace('\\', "/");
    let mut out = String::new();
    let drive = path.as_bytes().get(1) == Some(&b':') && path.starts_with(|c: char| c.is_ascii_alphabetic());
    if path.starts_with('/') {
        out.push_str("file://");
    } else if drive {
        out.push_str("file:///");
    }
    for byte in path.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => out.push(char::from(byte)),
            b':' if drive => out.push(':'),
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::{ReportedCase, reported};
    use super::*;
    use crate::report::tests::{EVIL, verdict};

    #[test]
    fn paths_are_uri_references() {
        for (path, wanted) in [
            ("part.nc", "part.nc"),
            ("a b/ö#1.mpf", "a%20b/%C3%B6%231.mpf"),
            ("/work/x.nc", "file:///work/x.nc"),
            ("C:\\nc\\x.nc", "file:///C:/nc/x.nc"),
            ("%MAIN_MPF", "%25MAIN_MPF"),
            ("x:y/z", "file:///x:y/z"),
        ] {
            assert_eq!(uri(path), wanted);
        }
    }

    /// The parts of the schema (OASIS 2020) that this writer touches: names, enumerations, required members.
    #[test]
    fn the_log_has_what_the_standard_requires() {
        let mut v = verdict(EVIL);
        v.gates[0].state = proveout_sim::verdict::State::Unchecked;
        let suite = reported(&v, &mut |file, line| (file.to_owned(), format!("  N{} G0  ", line.unwrap_or(0))));
        let log: Value = serde_json::from_str(&sarif(&[suite.clone(), suite]).expect("JSON")).expect("JSON");
        assert_eq!((log["version"].as_str(), log["$schema"].as_str()), (Some("2.1.0"), Some(SCHEMA)));
        let run = &log["runs"][0];
        let rules = run["tool"]["driver"]["rules"].as_array().expect("rules");
        assert_eq!(run["columnKind"], "unicodeCodePoints");
        assert_eq!(run["invocations"][0]["executionSuccessful"], true);
        let notes = run["invocations"][0]["toolExecutionNotifications"].as_array().expect("notes");
        assert!(notes.len() == 2 && notes.iter().all(|n| n["level"] == "warning" && n["message"]["text"].is_string()));
        let results = run["results"].as_array().expect("results");
        assert_eq!(results.len(), 8, "three findings and an unchecked gate, twice");
        let mut prints = Vec::new();
        for r in results {
            let index = r["ruleIndex"].as_u64().expect("an index") as usize;
            assert_eq!(rules[index]["id"], r["ruleId"]);
            assert!(r["message"]["text"].is_string());
            let (kind, level) = (r["kind"].as_str().expect("a kind"), r["level"].as_str().expect("a level"));
            // Section 3.27.10: a level other than `none` only where the kind is `fail`.
            assert_eq!(kind == "fail", level != "none", "{kind} {level}");
            if kind == "open" {
                assert!(r["message"]["text"].as_str().is_some_and(|t| t.contains("is unchecked")));
                continue;
            }
            let place = &r["locations"][0]["physicalLocation"];
            assert_eq!(
                (place["artifactLocation"]["uri"].as_str(), place["region"]["startLine"].as_u64()),
                (Some("axis/part.mpf"), Some(1204))
            );
            assert_eq!(r["properties"]["time_s"], 83.4);
            prints.push(r["partialFingerprints"]["codeFileLineText/v1"].as_str().expect("a fingerprint").to_owned());
        }
        let unique: std::collections::BTreeSet<_> = prints.iter().collect();
        assert_eq!(unique.len(), prints.len());
        let ids: std::collections::BTreeSet<_> = rules.iter().map(|r| r["id"].to_string()).collect();
        assert_eq!(ids.len(), rules.len(), "each rule once");
    }

    #[test]
    fn a_line_above_changes_no_fingerprint() {
        let print = |above: u32| {
            let mut v = verdict("plain");
            v.findings.iter_mut().for_each(|f| f.line = f.line.map(|l| l + above));
            let suite = reported(&v, &mut |file, _| (file.to_owned(), "N10 G1 X5".into()));
            let log: Value = serde_json::from_str(&sarif(&[suite]).expect("JSON")).expect("JSON");
            log["runs"][0]["results"][1]["partialFingerprints"].to_string()
        };
        assert_eq!(print(0), print(3));
    }

    #[test]
    fn an_input_that_is_not_in_order_is_no_success() {
        let suite = ReportedSuite {
            name: "part.nc".into(),
            cases: vec![ReportedCase { name: "check".into(), answer: CaseAnswer::Fail, reason: "x".into() }],
            ..ReportedSuite::default()
        };
        let log: Value = serde_json::from_str(&sarif(&[suite]).expect("JSON")).expect("JSON");
        assert_eq!(log["runs"][0]["invocations"][0]["executionSuccessful"], false);
        assert_eq!(log["runs"][0]["results"], serde_json::json!([]));
    }
}
