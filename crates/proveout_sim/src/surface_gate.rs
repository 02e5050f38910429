//! The gate `surface`: what the tolerances of the surface say, folded into one judgement.
//!
//! Each tolerance that a scene sets is judged on its own ([`Judgement`]); the gate fails when one of them fails, is unchecked when one
//! of them is, and passes when all pass. A scene that sets none leaves the gate unchecked.

use crate::verdict::{Gate, State};

/// What one tolerance says of the surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Judgement {
    /// Its key in the scene, under `[tolerances]`.
    pub(crate) key: &'static str,
    /// What came out.
    pub(crate) state: State,
    /// Value, limit and place, or what was not looked at.
    pub(crate) reason: String,
}

/// The gate of all judgements; `left_out` is what none of them has seen (text that was not run).
pub(crate) fn fold(name: &str, judgements: &[Judgement], left_out: &[String]) -> Gate {
    let gate = |state, reason| Gate { name: name.into(), state, reason };
    if judgements.is_empty() {
        return gate(State::Unchecked, "not checked: roughness and scallop are not evaluated".into());
    }
    let of = |state: State| -> Vec<String> {
        judgements.iter().filter(|j| j.state == state).map(|j| format!("{}: {}", j.key, j.reason)).collect()
    };
    let (failed, passed) = (of(State::Fail), of(State::Pass));
    let open: Vec<String> = of(State::Unchecked).into_iter().chain(left_out.iter().cloned()).collect();
    let state = match (failed.is_empty(), open.is_empty()) {
        (false, _) => State::Fail,
        (true, false) => State::Unchecked,
        (true, true) => State::Pass,
    };
    let part = |word: &str, what: &[String]| (!what.is_empty()).then(|| format!("{word}{}", what.join("; ")));
    let word = if state == State::Pass { "" } else { "within the tolerance: " };
    let parts = [part("", &failed), part("not checked: ", &open), part(word, &passed)];
    gate(state, parts.into_iter().flatten().collect::<Vec<_>>().join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(key: &'static str, state: State) -> Judgement {
        Judgement { key, state, reason: format!("{key} was looked at") }
    }

    #[test]
    fn fail_beats_unchecked_beats_pass_and_nothing_is_never_a_pass() {
        use State::{Fail, Pass, Unchecked};
        let states = |all: &[State], left_out: &[String]| {
            let judgements: Vec<Judgement> = all.iter().map(|s| judged("scallop_um", *s)).collect();
            fold("surface", &judgements, left_out).state
        };
        let lost = ["lines 3 to 9 were not run".to_owned()];
        assert_eq!(states(&[], &[]), Unchecked);
        assert_eq!(states(&[Pass, Pass], &[]), Pass);
        assert_eq!(states(&[Pass, Unchecked], &[]), Unchecked);
        assert_eq!(states(&[Pass, Unchecked, Fail], &[]), Fail);
        assert_eq!(states(&[Pass], &lost), Unchecked);
        assert_eq!(states(&[Fail], &lost), Fail);
    }

    #[test]
    fn the_reason_begins_with_what_decides() {
        let all = [judged("ra_um", State::Pass), judged("rz_um", State::Unchecked), judged("scallop_um", State::Fail)];
        let gate = fold("surface", &all, &[]);
        assert_eq!(
            gate.reason,
            "scallop_um: scallop_um was looked at; not checked: rz_um: rz_um was looked at; within the tolerance: ra_um: ra_um was looked at"
        );
        assert_eq!(fold("surface", &all[..1], &[]).reason, "ra_um: ra_um was looked at");
    }
}
