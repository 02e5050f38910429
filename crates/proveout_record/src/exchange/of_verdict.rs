//! The data of a verdict for other programs.

use proveout_sim::{
    finding::Finding,
    verdict::{State, Verdict},
};
use serde_json::{Map, Value, json};

use super::{CaseAnswer, ReportedCase, ReportedItem, ReportedSuite};

/// A line of a file that findings name: path for other programs, and text of the line.
pub type LineOf<'a> = dyn FnMut(&str, Option<u32>) -> (String, String) + 'a;

/// What a verdict says. `line_of` gives the path of a file that findings name, and the text of a line of it.
pub fn reported(verdict: &Verdict, line_of: &mut LineOf<'_>) -> ReportedSuite {
    let case = |g: &proveout_sim::verdict::GateVerdict| ReportedCase {
        name: g.gate.name().to_owned(),
        answer: match g.state {
            State::Pass => CaseAnswer::Pass,
            State::Fail => CaseAnswer::Fail,
            State::Unchecked => CaseAnswer::Unchecked,
            State::NotAsked => CaseAnswer::NotAsked,
        },
        reason: g.reason.clone(),
    };
    ReportedSuite {
        name: verdict.program.clone(),
        group: verdict.scene.clone(),
        time_s: Some(verdict.time.total_s).filter(|t| t.is_finite()),
        cases: verdict.gates.iter().map(case).collect(),
        items: verdict.findings.iter().map(|f| item(f, line_of)).collect(),
        executed: true,
    }
}

fn item(f: &Finding, line_of: &mut LineOf<'_>) -> ReportedItem {
    let (file, line_text) = match &f.file {
        Some(file) => {
            let (path, text) = line_of(file, f.line);
            (Some(path), text)
        }
        None => (None, String::new()),
    };
    ReportedItem {
        code: f.code.clone(),
        summary: f.registered().map_or_else(String::new, |c| c.summary.to_owned()),
        severity: f.severity,
        message: f.message.clone(),
        case: f.fails().map(|gate| gate.name().to_owned()),
        file,
        line: f.line,
        column: None,
        line_text,
        more: more(f),
    }
}

fn more(f: &Finding) -> Map<String, Value> {
    let mut map = Map::new();
    let mut put = |key: &str, value: Option<Value>| {
        if let Some(value) = value {
            map.insert(key.to_owned(), value);
        }
    };
    put("block", f.block.map(Value::from));
    put("time_s", f.time_s.map(Value::from));
    put("axes", (!f.axes.is_empty()).then(|| json!(f.axes)));
    put("bodies", (!f.bodies.is_empty()).then(|| json!(f.bodies)));
    put("point_mm", f.point_mm.map(|p| json!(p)));
    put("penetration_mm", f.penetration_mm.map(Value::from));
    put("clearance_mm", f.clearance_mm.map(Value::from));
    put("value", f.value.map(Value::from));
    put("limit", f.limit.map(Value::from));
    put("unit", f.unit.clone().map(Value::from));
    put("repeats", (f.repeats > 0).then(|| f.repeats.into()));
    map
}
