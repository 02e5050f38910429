//! How a published value compares with ours.
//!
//! ```text
//!   published value                                      verdict
//!   within 10 percent of ours                            agrees
//!   in the range of ours over what the paper leaves open compatible
//!   outside of everything that was tried                 not reproduced
//!   not defined in the paper, or not measured here       not comparable
//! ```
//!
//! A wider range is compatible with more: the verdict is read together with the range, with the null program,
//! and with the choice that moves the value most. A sign that turns within the range, or a range that only
//! draws of all choices at once reach, is compatible as well, but decides no criterion of the scene
//! (`State::Unchecked`).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::result::{Choices, Published};
use crate::verdict::verdict_file::State;

/// Part of the published value within which ours agrees with it: three papers of five print two digits.
const AGREES: f64 = 0.1;

/// Verdict on a published value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// Ours lies within 10 percent of it, under the choices of the scene.
    Agrees,
    /// It lies in the range of ours over the choices that the publication leaves open.
    Compatible,
    /// It lies outside of everything that was tried.
    NotReproduced,
    /// The publication does not define it, or it was not measured here.
    NotComparable,
}

impl Agreement {
    /// The words used in tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Compatible => "compatible",
            Self::NotReproduced => "not reproduced",
            Self::NotComparable => "not comparable",
        }
    }
}

/// Ranges of a row, with its value in each.
struct Ranges {
    /// Over choices one at a time, and the twin.
    alone: [f64; 2],
    /// With the draws of all choices at once.
    all: [f64; 2],
}

impl Ranges {
    fn of(row: &Published, value: f64) -> Self {
        let hull = |ranges: &[Option<[f64; 2]>]| {
            let ends = ranges.iter().flatten().flatten();
            ends.fold([value; 2], |[low, high], v| [low.min(*v), high.max(*v)])
        };
        Self {
            alone: hull(&[row.over_choices, row.over_twin]),
            all: hull(&[row.over_choices, row.over_draws, row.over_twin]),
        }
    }
}

fn holds([low, high]: [f64; 2], value: f64) -> bool {
    (low..=high).contains(&value)
}

/// The verdict on a row whose ranges are known.
pub(crate) fn agreement(row: &Published) -> Agreement {
    let Some(value) = row.value.filter(|v| v.is_finite() && row.not_comparable.is_none()) else {
        return Agreement::NotComparable;
    };
    if (value - row.published).abs() <= AGREES * row.published.abs() {
        Agreement::Agrees
    } else if holds(Ranges::of(row, value).all, row.published) {
        Agreement::Compatible
    } else {
        Agreement::NotReproduced
    }
}

/// What the verdict means for a row with a band, where choices were tried on it; none where nothing was
/// tried.
pub(crate) fn state(row: &Published) -> Option<State> {
    let value = row.value?;
    if row.over_choices.is_none() && row.over_twin.is_none() {
        return None;
    }
    let Ranges { alone, all } = Ranges::of(row, value);
    let sign = all[0] * row.published > 0.0 && all[1] * row.published > 0.0;
    Some(match agreement(row) {
        Agreement::Agrees if sign => State::Pass,
        Agreement::Compatible if sign && holds(alone, row.published) => State::Pass,
        Agreement::Agrees | Agreement::Compatible | Agreement::NotComparable => State::Unchecked,
        Agreement::NotReproduced => State::Fail,
    })
}

/// The choice that moves a value most, with its range; none where no choice acts on it.
pub(crate) fn decided_by<'a>(row: &Published, choices: &'a Choices) -> Option<(&'a str, [f64; 2])> {
    let acts = choices.choices.iter().filter_map(|c| Some((c.name.as_str(), *c.acts_on.get(&row.name)?)));
    let width = |range: &[f64; 2]| range[1] - range[0];
    // Of equal ones the first.
    acts.fold(None, |most: Option<(&str, [f64; 2])>, now| match most {
        Some(most) if width(&most.1) >= width(&now.1) => Some(most),
        _ => Some(now),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::{
        Agreement::{Agrees, Compatible, NotComparable, NotReproduced},
        *,
    };
    use crate::compare::result::TriedChoice;

    fn row(value: Option<f64>, published: f64, ranges: [Option<[f64; 2]>; 3]) -> Published {
        let [over_choices, over_draws, over_twin] = ranges;
        Published { value, published, over_choices, over_draws, over_twin, ..Published::named("n") }
    }

    #[test]
    fn a_value_agrees_is_compatible_or_is_not_reproduced() {
        let judged = |value, published, ranges| {
            let row = row(Some(value), published, ranges);
            (agreement(&row), state(&row))
        };
        let none = [None, None, None];
        assert_eq!(judged(22.1, 24.5, none), (Agrees, None), "9.8 percent; nothing was tried");
        assert_eq!(judged(-22.1, -24.5, none).0, Agrees);
        assert_eq!(judged(0.0, 0.0, none).0, Agrees);
        assert_eq!(judged(22.0, 24.5, none), (NotReproduced, None), "10.2 percent");
        let ranges = |choices, draws, twin| [choices, draws, twin];
        let wide = ranges(Some([12.0, 26.0]), Some([10.0, 30.0]), None);
        assert_eq!(judged(17.8, 24.5, wide), (Compatible, Some(State::Pass)));
        let twin = ranges(Some([17.0, 20.0]), None, Some([14.0, 25.0]));
        assert_eq!(judged(17.8, 24.5, twin), (Compatible, Some(State::Pass)), "by the twin");
        let draws = ranges(Some([12.0, 20.0]), Some([10.0, 30.0]), None);
        assert_eq!(judged(17.8, 24.5, draws), (Compatible, Some(State::Unchecked)), "draws alone");
        let turns = ranges(Some([-1.0, 26.0]), None, None);
        assert_eq!(judged(17.8, 24.5, turns), (Compatible, Some(State::Unchecked)), "the sign turns");
        assert_eq!(judged(24.0, 24.5, turns), (Agrees, Some(State::Unchecked)), "the sign turns");
        let narrow = ranges(Some([12.0, 20.0]), Some([10.0, 24.4]), None);
        assert_eq!(judged(17.8, 24.5, narrow), (NotReproduced, Some(State::Fail)));
    }

    #[test]
    fn what_is_not_defined_or_not_measured_is_not_comparable() {
        assert_eq!(agreement(&row(None, 24.5, [None; 3])), NotComparable);
        assert_eq!(agreement(&row(Some(f64::NAN), 24.5, [None; 3])), NotComparable);
        let undefined = Published { not_comparable: Some("no definition".into()), ..row(Some(24.5), 24.5, [None; 3]) };
        assert_eq!(agreement(&undefined), NotComparable);
    }

    #[test]
    fn the_widest_choice_decides() {
        let choice = |name: &str, range: Option<[f64; 2]>| TriedChoice {
            name: name.into(),
            key: String::new(),
            tried: Vec::new(),
            source: String::new(),
            reason: String::new(),
            acts_on: range.map(|r| ("n".to_owned(), r)).into_iter().collect::<BTreeMap<_, _>>(),
            refused: String::new(),
        };
        let all = |choices| Choices { choices, draws: 0, refused: 0, reasons: Vec::new() };
        let row = row(Some(1.0), 1.0, [None; 3]);
        let choices = all(vec![
            choice("narrow", Some([0.9, 1.0])),
            choice("idle", None),
            choice("wide", Some([-1.0, 1.0])),
            choice("as wide", Some([1.0, 3.0])),
        ]);
        assert_eq!(decided_by(&row, &choices), Some(("wide", [-1.0, 1.0])));
        assert_eq!(decided_by(&row, &all(vec![choice("idle", None)])), None);
    }
}
