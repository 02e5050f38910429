//! From findings and from what was left unchecked to the gates and the verdict.

use crate::verdict::{
    finding::{self, Code, Severity},
    log::FindingLog,
    surface_words,
    verdict_file::{Gate, State, Surface},
};

/// Names of the gates, in the order of the verdict.
pub const GATES: [&str; 8] = ["program", "limits", "process", "collision", "near_miss", "gouge", "excess", "surface"];

/// Codes that fail a gate.
fn codes(gate: &str) -> &'static [Code] {
    use finding::*;
    match gate {
        "program" => &[STOPPED, TEXT_LOST],
        "limits" => &[OVERTRAVEL, UNREACHABLE, OFF_CIRCLE, SPINDLE_SPEED, DRIVE_SATURATED, PLANNED_MOTION],
        "process" => &[
            RAPID_IN_MATERIAL,
            SPINDLE_OFF,
            SPINDLE_WRONG_WAY,
            PLUNGE,
            TAP_PITCH,
            NO_TOOL,
            NECK_RUBS,
            SHANK_RUBS,
            LOOSE_PART_CUT,
        ],
        "collision" => &[HOLDER_IN_STOCK, STOCK_HIT, STOCK_AT_REST, COLLISION],
        "near_miss" => &[NEAR_MISS],
        "gouge" => &[GOUGE, OVERCUT],
        "excess" => &[EXCESS, INSPECTION],
        "surface" => &[SCALLOP, ROUGHNESS],
        _ => &[],
    }
}

/// What a gate covers and what it leaves out, as the run reports it.
#[derive(Clone, Debug, Default)]
pub struct Coverage {
    /// What was checked, in words; none when nothing was.
    pub checked: Option<String>,
    /// What was not checked; the gate is then unchecked unless it has failed.
    pub left_out: Vec<String>,
}

/// Judges one gate: fail beats unchecked, unchecked beats pass.
pub fn judge(name: &str, coverage: &Coverage, log: &FindingLog) -> Gate {
    let count = |c: &Code| {
        log.all()
            .iter()
            .filter(|f| f.code == c.code && f.severity == Severity::Error)
            .map(|f| f.areas.unwrap_or(1))
            .sum::<u64>()
    };
    let hits: Vec<(&Code, u64)> = codes(name).iter().map(|c| (c, count(c))).filter(|(_, n)| *n > 0).collect();
    let left_out = coverage.left_out.join("; ");
    let mut counts: Vec<String> = hits.iter().map(|(c, n)| format!("{n} x {}{}", c.code, worst(c, log))).collect();
    if name == "near_miss" && log.near_misses_of_hits() > 0 {
        // What touches came too near before.
        counts.push(format!("{} x two bodies hit each other", log.near_misses_of_hits()));
    }
    if name == "near_miss" && counts.is_empty() {
        let hits: u64 = codes("collision").iter().map(count).sum();
        if hits > 0 {
            counts.push(format!("{hits} x two bodies hit each other"));
        }
    }
    let (state, reason) = if !counts.is_empty() {
        let more = if left_out.is_empty() { String::new() } else { format!("; not checked: {left_out}") };
        (State::Fail, counts.join(", ") + &more)
    } else if !left_out.is_empty() {
        let checked =
            coverage.checked.as_ref().map_or_else(String::new, |c| format!("checked without a finding: {c}; "));
        (State::Unchecked, format!("{checked}not checked: {left_out}"))
    } else if let Some(checked) = &coverage.checked {
        (State::Pass, checked.clone())
    } else {
        (State::Unchecked, "nothing was checked".into())
    };
    Gate { name: name.into(), state, reason }
}

/// A gate that the scene does not ask; a finding that fails it stays one. `surface` says what was evaluated
/// all the same.
pub(crate) fn not_asked(gate: Gate, why: String, surface: &Surface) -> Gate {
    if gate.state == State::Fail {
        return gate;
    }
    let evaluated = surface_words::evaluated(surface).filter(|_| gate.name == "surface");
    let reason = match evaluated {
        Some(values) => format!("evaluated, not judged: no tolerance; {values}"),
        None => why,
    };
    Gate { state: State::NotAsked, reason, ..gate }
}

/// The deepest gouge or the highest excess, and the line that made it; of other faults the values are of several kinds.
fn worst(code: &Code, log: &FindingLog) -> String {
    if ![finding::GOUGE.code, finding::EXCESS.code].contains(&code.code) {
        return String::new();
    }
    let depths = log.all().iter().filter(|f| f.code == code.code).filter_map(|f| Some((f.value?, f.line)));
    match depths.reduce(|a, b| if b.0 > a.0 { b } else { a }) {
        Some((depth, Some(line))) => format!(", up to {depth:.4} mm in line {line}"),
        Some((depth, None)) => format!(", up to {depth:.4} mm"),
        None => String::new(),
    }
}

/// The verdict of a list of gates; those that are not asked have no part in it, and nothing asked is no pass.
pub fn overall(gates: &[Gate]) -> State {
    let any = |state| gates.iter().any(|g| g.state == state);
    if any(State::Fail) {
        State::Fail
    } else if any(State::Unchecked) || !any(State::Pass) {
        State::Unchecked
    } else {
        State::Pass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered() -> Coverage {
        Coverage { checked: Some("all".into()), left_out: vec![] }
    }

    #[test]
    fn nothing_checked_is_never_a_pass() {
        let log = FindingLog::default();
        assert_eq!(judge("gouge", &Coverage::default(), &log).state, State::Unchecked);
        assert_eq!(judge("gouge", &covered(), &log).state, State::Pass);
        let partly = Coverage { left_out: vec!["tool 3 has no holder".into()], ..covered() };
        assert_eq!(judge("collision", &partly, &log).state, State::Unchecked);
        assert_eq!(overall(&[]), State::Unchecked);
    }

    #[test]
    fn each_error_code_fails_its_gate_and_a_hit_fails_near_miss_as_well() {
        for code in finding::CODES {
            let mut log = FindingLog::default();
            log.push(FindingLog::of(code, String::new()));
            let failed: Vec<&str> =
                GATES.into_iter().filter(|g| judge(g, &covered(), &log).state == State::Fail).collect();
            let own = GATES.into_iter().filter(|g| codes(g).iter().any(|c| c.code == code.code));
            let expected: Vec<&str> = match code.severity {
                Severity::Error => {
                    own.flat_map(|g| if g == "collision" { vec![g, "near_miss"] } else { vec![g] }).collect()
                }
                _ => vec![],
            };
            assert_eq!(failed, expected, "{}", code.code);
            assert_eq!(failed.is_empty(), code.severity != Severity::Error, "{} fails no gate", code.code);
        }
    }

    #[test]
    fn a_gate_that_fails_by_depth_says_how_deep_and_where() {
        let mut log = FindingLog::default();
        for (depth, line) in [(0.2, Some(9)), (1.2, Some(14)), (0.3, None)] {
            let mut f = FindingLog::of(&finding::GOUGE, "too deep".into());
            (f.value, f.line, f.areas) = (Some(depth), line, Some(2));
            f.point_mm = Some([depth, 0.0, 0.0]);
            log.push(f);
        }
        assert_eq!(judge("gouge", &covered(), &log).reason, "6 x geometry-gouge, up to 1.2000 mm in line 14");
    }

    #[test]
    fn fail_beats_unchecked_beats_pass() {
        let gate = |state| Gate { name: String::new(), state, reason: String::new() };
        assert_eq!(overall(&[gate(State::Pass), gate(State::Unchecked), gate(State::Fail)]), State::Fail);
        assert_eq!(overall(&[gate(State::Pass), gate(State::Unchecked)]), State::Unchecked);
        assert_eq!(overall(&[gate(State::Pass), gate(State::Pass)]), State::Pass);
        assert_eq!(overall(&[gate(State::Pass), gate(State::NotAsked)]), State::Pass);
        assert_eq!(overall(&[gate(State::Unchecked), gate(State::NotAsked)]), State::Unchecked);
        assert_eq!(overall(&[gate(State::NotAsked)]), State::Unchecked, "nothing was asked, so that nothing passes");
    }
}
