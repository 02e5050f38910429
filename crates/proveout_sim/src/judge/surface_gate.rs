//! The gate `surface`: what the tolerances of the surface say, folded into one judgement.
//!
//! Each tolerance that a scene sets is judged on its own ([`Judgement`]); the gate fails when one
//! of them fails, is unchecked when one of them is, and passes when all pass. A scene that sets
//! none does not ask the gate. What was evaluated is reported in any case.

use crate::verdict::{
    gate::Gate,
    surface_words::evaluated,
    verdict_file::{GateVerdict, State, Surface},
};

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
pub(crate) fn fold(judgements: &[Judgement], left_out: &[String], surface: &Surface) -> GateVerdict {
    let gate = |state, reason| GateVerdict { gate: Gate::Surface, state, reason };
    let values = evaluated(surface);
    if judgements.is_empty() {
        let reason = match values {
            Some(values) => format!("evaluated, not judged: no tolerance; {values}"),
            None => "not checked: the scene has no tolerance of the surface".into(),
        };
        return gate(State::Unchecked, reason);
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
    let values = values.map(|v| format!("evaluated: {v}"));
    let parts = [part("", &failed), part("not checked: ", &open), part(word, &passed), values];
    gate(state, parts.into_iter().flatten().collect::<Vec<_>>().join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::verdict_file::{ProfileUsed, TextureUsed};

    fn judged(key: &'static str, state: State) -> Judgement {
        Judgement { key, state, reason: format!("{key} was looked at") }
    }

    #[test]
    fn fail_beats_unchecked_beats_pass_and_nothing_is_never_a_pass() {
        use State::{Fail, Pass, Unchecked};
        let states = |all: &[State], left_out: &[String]| {
            let judgements: Vec<Judgement> = all.iter().map(|s| judged("scallop_um", *s)).collect();
            fold(&judgements, left_out, &Surface::default()).state
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
        let gate = fold(&all, &[], &Surface::default());
        assert_eq!(
            gate.reason,
            "scallop_um: scallop_um was looked at; not checked: rz_um: rz_um was looked at; within the tolerance: ra_um: ra_um was looked at"
        );
        let one = |surface: &Surface| fold(&all[..1], &[], surface).reason;
        assert_eq!(one(&Surface::default()), "ra_um: ra_um was looked at");
    }

    #[test]
    fn values_are_reported_with_a_tolerance_and_without_one() {
        let place = |sa: f64, ra: [f64; 2]| TextureUsed {
            sa_um: Some(sa),
            profiles: vec![ProfileUsed { ra_um: Some(ra), rz_um: None, ..ProfileUsed::default() }],
            ..TextureUsed::default()
        };
        let surface = Surface { textures: vec![place(0.2, [0.3, 0.4]), place(0.1, [0.35, 0.5])], ..Surface::default() };
        let values = "Sa 0.1000 to 0.2000 um, Ra 0.3000 to 0.5000 um at 2 places";
        assert_eq!(evaluated(&surface).as_deref(), Some(values));
        let none = fold(&[], &[], &surface);
        assert_eq!(
            (none.state, none.reason),
            (State::Unchecked, format!("evaluated, not judged: no tolerance; {values}"))
        );
        for state in [State::Pass, State::Fail, State::Unchecked] {
            let message = fold(&[judged("ra_um", state)], &[], &surface).reason;
            assert!(message.ends_with(&format!("; evaluated: {values}")), "{message}");
        }
        assert_eq!(evaluated(&Surface::default()), None);
        let flat = TextureUsed { sa_um: Some(0.0), is_flat: true, ..TextureUsed::default() };
        let message = evaluated(&Surface { textures: vec![flat], ..Surface::default() }).expect("a value");
        assert_eq!(message, "Sa 0.0000 um at 1 place; no kinematic height along the path; teeth not modeled");
    }
}
