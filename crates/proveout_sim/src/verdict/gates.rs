//! From findings and from what was left unchecked to the gates and the verdict.

use crate::verdict::{
    finding::{self, CODES, Code, Severity},
    gate::Gate,
    log::FindingLog,
    surface_words,
    verdict_file::{GateVerdict, State, Surface},
};

/// Codes that fail a gate.
fn codes(gate: Gate) -> impl Iterator<Item = &'static Code> {
    CODES.iter().filter(move |c| c.fails == Some(gate))
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
pub fn judge(gate: Gate, coverage: &Coverage, log: &FindingLog) -> GateVerdict {
    let count = |c: &Code| {
        log.all()
            .iter()
            .filter(|f| f.code == c.code && f.severity == Severity::Error)
            .map(|f| f.areas.unwrap_or(1))
            .sum::<u64>()
    };
    let hits: Vec<(&Code, u64)> = codes(gate).map(|c| (c, count(c))).filter(|(_, n)| *n > 0).collect();
    let left_out = coverage.left_out.join("; ");
    let mut counts: Vec<String> = hits.iter().map(|(c, n)| format!("{n} x {}{}", c.code, worst(c, log))).collect();
    if gate == Gate::NearMiss && log.near_misses_of_hits() > 0 {
        // What touches came too near before.
        counts.push(format!("{} x two bodies hit each other", log.near_misses_of_hits()));
    }
    if gate == Gate::NearMiss && counts.is_empty() {
        let hits: u64 = codes(Gate::Collision).map(count).sum();
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
    GateVerdict { gate, state, reason }
}

/// A gate that the scene does not ask; a finding that fails it stays one. `surface` says what was evaluated
/// all the same.
pub(crate) fn not_asked(verdict: GateVerdict, why: String, surface: &Surface) -> GateVerdict {
    if verdict.state == State::Fail {
        return verdict;
    }
    let evaluated = surface_words::evaluated(surface).filter(|_| verdict.gate == Gate::Surface);
    let reason = match evaluated {
        Some(values) => format!("evaluated, not judged: no tolerance; {values}"),
        None => why,
    };
    GateVerdict { state: State::NotAsked, reason, ..verdict }
}

/// The deepest gouge or the highest excess, and the line that made it; of other faults the values are of
/// several kinds.
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

/// The verdict of the states of some gates; those that are not asked have no part in it, and nothing asked is
/// no pass.
pub fn overall(gates: impl IntoIterator<Item = State>) -> State {
    let states: Vec<State> = gates.into_iter().collect();
    let any = |state| states.contains(&state);
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
        assert_eq!(judge(Gate::Gouge, &Coverage::default(), &log).state, State::Unchecked);
        assert_eq!(judge(Gate::Gouge, &covered(), &log).state, State::Pass);
        let partly = Coverage { left_out: vec!["tool 3 has no holder".into()], ..covered() };
        assert_eq!(judge(Gate::Collision, &partly, &log).state, State::Unchecked);
        assert_eq!(overall([]), State::Unchecked);
    }

    #[test]
    fn each_error_code_fails_its_gate_and_a_hit_fails_near_miss_as_well() {
        for code in CODES {
            let mut log = FindingLog::default();
            log.push(FindingLog::of(code, String::new()));
            let failed: Vec<Gate> =
                Gate::ALL.into_iter().filter(|g| judge(*g, &covered(), &log).state == State::Fail).collect();
            let expected = match code.fails {
                Some(Gate::Collision) => vec![Gate::Collision, Gate::NearMiss],
                own => Vec::from_iter(own),
            };
            assert_eq!(log.all()[0].fails(), code.fails);
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
        assert_eq!(judge(Gate::Gouge, &covered(), &log).reason, "6 x geometry-gouge, up to 1.2000 mm in line 14");
    }

    #[test]
    fn fail_beats_unchecked_beats_pass() {
        assert_eq!(overall([State::Pass, State::Unchecked, State::Fail]), State::Fail);
        assert_eq!(overall([State::Pass, State::Unchecked]), State::Unchecked);
        assert_eq!(overall([State::Pass, State::Pass]), State::Pass);
        assert_eq!(overall([State::Pass, State::NotAsked]), State::Pass);
        assert_eq!(overall([State::Unchecked, State::NotAsked]), State::Unchecked);
        assert_eq!(overall([State::NotAsked]), State::Unchecked, "nothing was asked, so that nothing passes");
    }
}
