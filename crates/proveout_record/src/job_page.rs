//! The result of a job: `job.json`, and `job.html` with the setups on one page, each with a link to its own
//! report.

use std::{fs, path::Path};

use minijinja::{context, value::Serde};
use proveout_sim::{
    job::JobVerdict,
    verdict::{GateVerdict, State},
};
use serde_json::{Value, json};

use crate::{
    error::RecordError,
    page_template::{fill, policy},
    report::format::{duration, volume},
};

const TEMPLATE: &str = include_str!("../templates/job.html");
const CSS: &str = include_str!("../templates/report.css");

/// Writes `job.json` and `job.html` into the folder of a job.
///
/// # Errors
/// [`RecordError`] when a file cannot be written.
pub fn write_job(folder: &Path, verdict: &JobVerdict) -> Result<(), RecordError> {
    let put = |name: &str, text: String| {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|source| RecordError::Io { path, source })
    };
    let json = serde_json::to_string_pretty(verdict).map_err(|e| RecordError::Page { message: e.to_string() })?;
    put("job.json", json + "\n")?;
    put("job.html", render(verdict)?)
}

fn render(verdict: &JobVerdict) -> Result<String, RecordError> {
    let rows: Vec<Value> = verdict
        .setups
        .iter()
        .map(|s| {
            let (class, word) = s.verdict.map_or(("unchecked", "not run"), words);
            json!({
                "name": s.name,
                "report": s.verdict.map(|_| format!("{}/report.html", address(&s.name))),
                "class": class,
                "word": word,
                "stock": s.after.as_ref().map_or_else(|| "of its scene".into(), |a| format!("as {a} left it")),
                "why": s.not_run.clone().unwrap_or_default(),
                "figures": match (s.time_s, s.removed_mm3, s.stock_left_mm3) {
                    (Some(time), Some(removed), Some(left)) => {
                        format!("{} of machine time, {} removed, {} left", duration(time), volume(removed), volume(left))
                    }
                    _ => String::new(),
                },
                "gates": s.gates.iter().map(gate).collect::<Vec<_>>(),
                "errors": s.first_errors,
                "more": s.errors.saturating_sub(s.first_errors.len() as u64),
            })
        })
        .collect();
    let (class, word) = words(verdict.verdict);
    let data =
        context! { policy => policy(&[]), css => CSS, job => verdict.job.clone(), class, word, rows => Serde(rows) };
    fill("job.html", TEMPLATE, data)
}

fn words(state: State) -> (&'static str, &'static str) {
    (state.class(), state.word())
}

/// Class, word, name and reason.
fn gate(gate: &GateVerdict) -> [String; 4] {
    let (class, word) = words(gate.state);
    [class.to_owned(), word.to_owned(), gate.gate.name().to_owned(), gate.reason.clone()]
}

/// A name of a folder in an address: everything but letters, digits and a few marks as the hexadecimal digits
/// of its bytes.
fn address(name: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_' | b'.');
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

#[cfg(test)]
mod tests {
    use proveout_sim::{job::SetupVerdict, verdict::Gate};

    use super::*;

    #[test]
    fn names_are_escaped_and_setups_that_were_not_run_have_no_link() {
        let ran = SetupVerdict {
            name: "op 10 <b>".into(),
            verdict: Some(State::Fail),
            gates: vec![GateVerdict { gate: Gate::Process, state: State::Fail, reason: "1 x <rapid>".into() }],
            errors: 7,
            first_errors: vec!["line 3: <script>alert(1)</script>".into()],
            ..SetupVerdict::default()
        };
        let left = SetupVerdict {
            name: "op20".into(),
            after: Some("op 10 <b>".into()),
            not_run: Some("not run: setup op 10 <b> before it failed".into()),
            ..SetupVerdict::default()
        };
        let job =
            JobVerdict { schema_version: 1, job: "bracket".into(), verdict: State::Fail, setups: vec![ran, left] };
        let page = render(&job).expect("a page");
        assert!(!page.contains("<script>") && !page.contains("<rapid>"), "{page}");
        assert!(page.contains("href=\"op%2010%20%3Cb%3E/report.html\""), "{page}");
        assert_eq!(page.matches("report.html").count(), 1);
        assert!(
            page.contains("not run") && page.contains("6 more") && page.contains("default-src &#x27;none&#x27;"),
            "{page}"
        );
    }
}
