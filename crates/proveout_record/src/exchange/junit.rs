//! `JUnit` XML as build servers read it: a suite a program, a case a gate. A gate that is not checked is an
//! error, since a skipped case counts as green.

use std::fmt::Write;

use proveout_sim::finding::Severity;

use super::{CaseAnswer, ReportedItem, ReportedSuite};

/// Most findings of a case that are written out.
const MOST_ITEMS: usize = 50;

/// The suites as one `JUnit` document.
pub fn junit(suites: &[ReportedSuite]) -> String {
    let count = |answer| -> usize { suites.iter().flat_map(|s| &s.cases).filter(|c| c.answer == answer).count() };
    let tests: usize = suites.iter().map(|s| s.cases.len()).sum();
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    line(format!(
        "<testsuites name=\"proveout\" tests=\"{tests}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">",
        count(CaseAnswer::Fail),
        count(CaseAnswer::Unchecked),
        count(CaseAnswer::NotAsked)
    ));
    for suite in suites {
        let of = |answer| suite.cases.iter().filter(|c| c.answer == answer).count();
        let time = suite.time_s.map_or_else(String::new, |t| format!(" time=\"{t:.3}\""));
        line(format!(
            "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\"{time}>",
            escaped(&suite.name),
            suite.cases.len(),
            of(CaseAnswer::Fail),
            of(CaseAnswer::Unchecked),
            of(CaseAnswer::NotAsked)
        ));
        for case in &suite.cases {
            let head = format!(
                "    <testcase classname=\"{}\" name=\"{}\"",
                escaped(&[suite.group.as_str(), suite.name.as_str()].join(".")),
                escaped(&case.name)
            );
            let reason = escaped(&case.reason);
            match case.answer {
                CaseAnswer::Pass => line(format!("{head}/>")),
                CaseAnswer::NotAsked => {
                    line(format!("{head}>\n      <skipped message=\"{reason}\"/>\n    </testcase>"));
                }
                CaseAnswer::Unchecked => {
                    line(format!("{head}>\n      <error type=\"unchecked\" message=\"{reason}\"/>\n    </testcase>"))
                }
                CaseAnswer::Fail => line(format!(
                    "{head}>\n      <failure type=\"fail\" message=\"{reason}\">{}</failure>\n    </testcase>",
                    escaped(&details(suite, &case.name))
                )),
            }
        }
        line("  </testsuite>".to_owned());
    }
    out.push_str("</testsuites>\n");
    out
}

/// The findings that fail a case, one a line.
fn details(suite: &ReportedSuite, case: &str) -> String {
    let own: Vec<&ReportedItem> =
        suite.items.iter().filter(|i| i.severity == Severity::Error && i.case.as_deref() == Some(case)).collect();
    let mut text = String::new();
    for item in own.iter().take(MOST_ITEMS) {
        let place = match (&item.file, item.line) {
            (Some(file), Some(line)) => format!("{file}:{line}: "),
            (Some(file), None) => format!("{file}: "),
            _ => String::new(),
        };
        writeln!(text, "{place}{} [{}]", item.message.replace('\n', " "), item.code).ok();
    }
    if own.len() > MOST_ITEMS {
        writeln!(text, "and {} more", own.len() - MOST_ITEMS).ok();
    }
    text
}

/// Text and attribute values of XML 1.0; characters that it does not allow become U+FFFD.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' => out.push_str("&#10;"),
            '\t' => out.push_str("&#9;"),
            c if c < ' ' || matches!(c, '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
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
    fn an_unchecked_gate_is_an_error_and_texts_are_escaped() {
        let mut v = verdict(&format!("{EVIL}\u{1b}\u{0}"));
        v.gates = proveout_sim::verdict::Gate::ALL
            .into_iter()
            .zip([
                proveout_sim::verdict::State::Pass,
                proveout_sim::verdict::State::Unchecked,
                proveout_sim::verdict::State::Pass,
                proveout_sim::verdict::State::Fail,
                proveout_sim::verdict::State::NotAsked,
            ])
            .map(|(gate, state)| proveout_sim::verdict::GateVerdict { gate, state, reason: EVIL.into() })
            .collect();
        let text = junit(&[reported(&v, &mut |file, _| (file.to_owned(), String::new()))]);
        let document = roxmltree::Document::parse(&text).expect("well-formed XML");
        let root = document.root_element();
        let number = |n: roxmltree::Node<'_, '_>, name: &str| n.attribute(name).and_then(|t| t.parse::<u32>().ok());
        for node in [root, root.first_element_child().expect("a suite")] {
            let counts = ["tests", "failures", "errors", "skipped"].map(|name| number(node, name));
            assert_eq!(counts, [Some(5), Some(1), Some(1), Some(1)]);
        }
        let cases: Vec<_> = root.descendants().filter(|n| n.has_tag_name("testcase")).collect();
        let inside: Vec<_> =
            cases.iter().map(|c| c.first_element_child().map(|e| e.tag_name().name().to_owned())).collect();
        let named = |name: &str| Some(name.to_owned());
        assert_eq!(inside, [None, named("error"), None, named("failure"), named("skipped")]);
        // The holder in the stock fails the gate of collisions, by file and line.
        let failure = root.descendants().find(|n| n.has_tag_name("failure")).expect("a failure");
        assert!(
            failure.text().is_some_and(|t| t.contains("axis/part.mpf:1204") && t.contains("[collision-holder-stock]"))
        );
        assert_eq!(failure.attribute("message"), Some(EVIL));
    }

    #[test]
    fn a_case_with_many_findings_counts_the_rest() {
        let mut v = verdict("plain");
        let one = v.findings[1].clone();
        v.findings = vec![one; MOST_ITEMS + 7];
        let text = junit(&[reported(&v, &mut |file, _| (file.to_owned(), String::new()))]);
        assert!(text.contains("and 7 more") && text.matches("part.mpf:1204").count() == MOST_ITEMS);
    }

    #[test]
    fn suites_of_a_check_have_a_case_each() {
        let suite = ReportedSuite {
            name: "a.nc".into(),
            group: "program".into(),
            cases: vec![ReportedCase { name: "check".into(), answer: CaseAnswer::Pass, reason: String::new() }],
            executed: true,
            ..ReportedSuite::default()
        };
        let text = junit(&[suite]);
        assert!(text.contains("<testcase classname=\"program.a.nc\" name=\"check\"/>"), "{text}");
    }
}
