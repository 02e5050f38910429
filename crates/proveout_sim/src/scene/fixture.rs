//! Fixtures by their dimensions: `kind` of a `[[fixture]]`, so that no vise has to be modeled.
//!
//! `at_mm` is the point of the fixture that the table below names, `rotation_deg` turns it there about the
//! fixed x, y and z axes.
//!
//! | kind | `at_mm` | body |
//! |---|---|---|
//! | `vise` | middle between the jaws, at their upper edge | two jaws that close along y, a bed below them |
//! | `plate` | middle of the upper face | a block |
//! | `chuck` | middle of the front face, jaws towards +z | a disk, jaws from the grip diameter outward |
//! | `tombstone` | middle of the foot | a square column on a square foot |
//! | `toe-clamp` | part edge, under the toe | bar from `reach_mm` over the part along +x, z > 0 |
//! | | | stud and post outside |

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::FixtureFile;

/// What a fixture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FixtureKindFile {
    /// Machine vise.
    Vise,
    /// Plate, riser, vacuum plate.
    Plate,
    /// Chuck with jaws.
    Chuck,
    /// Tombstone.
    Tombstone,
    /// Toe clamp with its stud and post.
    ToeClamp,
}

impl FixtureKindFile {
    /// The word in the scene.
    pub fn word(self) -> &'static str {
        match self {
            Self::Vise => "vise",
            Self::Plate => "plate",
            Self::Chuck => "chuck",
            Self::Tombstone => "tombstone",
            Self::ToeClamp => "toe-clamp",
        }
    }

    /// Lengths that the kind has, all of them needed.
    fn lengths(self) -> &'static [&'static str] {
        match self {
            Self::Vise => &["opening_mm", "jaw_width_mm", "jaw_height_mm", "jaw_thickness_mm", "bed_height_mm"],
            Self::Plate => &["length_mm", "width_mm", "thickness_mm"],
            Self::Chuck => &["diameter_mm", "length_mm", "grip_diameter_mm", "jaw_width_mm", "jaw_height_mm"],
            Self::Tombstone => &["side_mm", "height_mm", "base_side_mm", "base_thickness_mm"],
            Self::ToeClamp => &[
                "length_mm",
                "width_mm",
                "thickness_mm",
                "reach_mm",
                "height_mm",
                "stud_diameter_mm",
                "stud_height_mm",
            ],
        }
    }
}

/// Longest dimension of a fixture, mm.
const LONGEST_MM: f64 = 5000.0;
/// Jaws of a chuck.
const JAWS: std::ops::RangeInclusive<u32> = 2..=8;

impl FixtureFile {
    /// All lengths by their keys.
    fn lengths(&self) -> [(&'static str, Option<f64>); 18] {
        [
            ("opening_mm", self.opening_mm),
            ("jaw_width_mm", self.jaw_width_mm),
            ("jaw_height_mm", self.jaw_height_mm),
            ("jaw_thickness_mm", self.jaw_thickness_mm),
            ("bed_height_mm", self.bed_height_mm),
            ("length_mm", self.length_mm),
            ("width_mm", self.width_mm),
            ("thickness_mm", self.thickness_mm),
            ("diameter_mm", self.diameter_mm),
            ("grip_diameter_mm", self.grip_diameter_mm),
            ("side_mm", self.side_mm),
            ("height_mm", self.height_mm),
            ("base_side_mm", self.base_side_mm),
            ("base_thickness_mm", self.base_thickness_mm),
            ("reach_mm", self.reach_mm),
            ("stud_diameter_mm", self.stud_diameter_mm),
            ("stud_height_mm", self.stud_height_mm),
            ("jaws", self.jaws.map(f64::from)),
        ]
    }

    /// A length of the kind; zero where it is not given, which is refused before.
    pub(crate) fn length_of(&self, key: &str) -> f64 {
        self.lengths().into_iter().find(|(k, _)| *k == key).and_then(|(_, v)| v).unwrap_or(0.0)
    }
}

/// What is wrong with the dimensions of a fixture: the key, message and help.
pub(crate) fn fault(fixture: &FixtureFile) -> Option<(&'static str, String, String)> {
    let name = &fixture.name;
    let given = fixture.lengths();
    let Some(kind) = fixture.kind else {
        let of_kind = given.into_iter().find(|(_, value)| value.is_some()).map(|(key, _)| key);
        let placed = [("at_mm", fixture.at_mm.is_some()), ("rotation_deg", fixture.rotation_deg.is_some())];
        let key = of_kind.or_else(|| placed.into_iter().find(|(_, is)| *is).map(|(key, _)| key))?;
        let message = format!("`{key}` of fixture {name:?} has no effect without a `kind`");
        return Some((
            key,
            message,
            "add kind = \"vise\", \"plate\", \"chuck\", \"tombstone\" or \"toe-clamp\"".into(),
        ));
    };
    let word = kind.word();
    let wanted = kind.lengths();
    let jaws = kind == FixtureKindFile::Chuck;
    for (key, value) in given {
        let known = wanted.contains(&key) || jaws && key == "jaws";
        match value {
            Some(_) if !known => {
                let message = format!("`{key}` has no effect on the {word} {name:?}");
                return Some((key, message, format!("remove it; a {word} has {}", wanted.join(", "))));
            }
            None if known => {
                let all = if jaws { format!("{}, jaws", wanted.join(", ")) } else { wanted.join(", ") };
                return Some(("kind", format!("the {word} {name:?} has no `{key}`"), format!("a {word} needs {all}")));
            }
            Some(value) if key != "jaws" && !(value > 0.0 && value <= LONGEST_MM) => {
                let message = format!("{key} = {value} mm of the {word} {name:?} is out of range");
                return Some((key, message, format!("write a length above 0 and up to {LONGEST_MM} mm")));
            }
            _ => {}
        }
    }
    if let Some(count) = fixture.jaws.filter(|count| !JAWS.contains(count)) {
        let message = format!("jaws = {count} of the chuck {name:?} is out of range");
        return Some(("jaws", message, format!("write {} to {}", JAWS.start(), JAWS.end())));
    }
    // The first must be below the second.
    let pairs: &[(&'static str, &'static str)] = match kind {
        FixtureKindFile::Vise | FixtureKindFile::Plate => &[],
        FixtureKindFile::Chuck => &[("grip_diameter_mm", "diameter_mm")],
        FixtureKindFile::Tombstone => &[("side_mm", "base_side_mm"), ("base_thickness_mm", "height_mm")],
        FixtureKindFile::ToeClamp => &[("reach_mm", "length_mm"), ("stud_diameter_mm", "width_mm")],
    };
    pairs.iter().find_map(|(small, large)| {
        let (a, b) = (fixture.length_of(small), fixture.length_of(large));
        (a >= b).then(|| {
            let message = format!("{small} = {a} mm of the {word} {name:?} must be below {large} = {b} mm");
            (*small, message, "correct one of the two".to_owned())
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::setup::fixture_fault;

    const WHOLE: [(&str, &str); 5] = [
        (
            "vise",
            "opening_mm = 40\njaw_width_mm = 125\njaw_height_mm = 40\njaw_thickness_mm = 20\nbed_height_mm = 30\n",
        ),
        ("plate", "length_mm = 200\nwidth_mm = 100\nthickness_mm = 20\n"),
        (
            "chuck",
            "diameter_mm = 160\nlength_mm = 80\ngrip_diameter_mm = 40\njaws = 3\njaw_width_mm = 20\njaw_height_mm = 30\n",
        ),
        ("tombstone", "side_mm = 100\nheight_mm = 300\nbase_side_mm = 200\nbase_thickness_mm = 30\n"),
        (
            "toe-clamp",
            "length_mm = 100\nwidth_mm = 30\nthickness_mm = 20\nreach_mm = 10\nheight_mm = 40\nstud_diameter_mm = 12\nstud_height_mm = 15\n",
        ),
    ];

    fn refused(text: &str) -> Option<String> {
        let text = format!("[[fixture]]\nname = \"f\"\n{text}");
        #[derive(serde::Deserialize)]
        struct File {
            fixture: Vec<FixtureFile>,
        }
        match toml::from_str::<File>(&text) {
            Ok(file) => fixture_fault(&text, &file.fixture).map(|(_, message, help)| format!("{message}; {help}")),
            Err(e) => Some(e.to_string()),
        }
    }

    /// Every key of every kind: left out, zero, below zero, too long, and given to a kind that has none.
    #[test]
    fn every_dimension_is_needed_in_range_and_refused_where_it_has_no_effect() {
        let all: Vec<&str> =
            WHOLE.iter().flat_map(|(_, keys)| keys.lines()).map(|l| l.split_once(" = ").expect("a key").0).collect();
        for (kind, keys) in WHOLE {
            let head = format!("kind = \"{kind}\"\nat_mm = [0, 0, 0]\n");
            assert_eq!(refused(&format!("{head}{keys}")), None, "{kind}");
            for line in keys.lines() {
                let key = line.split_once(" = ").expect("a key").0;
                let others: String = keys.lines().filter(|l| *l != line).map(|l| format!("{l}\n")).collect();
                let refusal = |value: &str| refused(&format!("{head}{others}{key} = {value}\n")).unwrap_or_default();
                assert!(
                    refused(&format!("{head}{others}")).is_some_and(|t| t.contains(&format!("no `{key}`"))),
                    "{kind} {key}"
                );
                for value in ["0", "9999"] {
                    assert!(refusal(value).contains(&format!("{key} = {value}")), "{kind} {key}: {}", refusal(value));
                }
                assert!(!refusal("-1").is_empty() && !refusal("nan").is_empty(), "{kind} {key}");
            }
            for stray in all.iter().filter(|key| !keys.lines().any(|l| l.starts_with(&format!("{key} = ")))) {
                let message = refused(&format!("{head}{keys}{stray} = 5\n")).unwrap_or_default();
                assert!(message.contains(&format!("`{stray}` has no effect")), "{kind} {stray}: {message}");
            }
            assert!(refused(&format!("{head}{keys}box = {{ min_mm = [0,0,0], max_mm = [1,1,1] }}\n")).is_some());
        }
        assert!(
            refused("box = { min_mm = [0,0,0], max_mm = [1,1,1] }\nat_mm = [0,0,1]\n")
                .is_some_and(|t| t.contains("no effect"))
        );
        assert!(refused("kind = \"magnet\"\n").is_some());
        assert!(
            refused("kind = \"plate\"\nlength_mm = 200\nwidth_mm = 100\nthickness_mm = 20\n")
                .is_some_and(|t| t.contains("at_mm"))
        );
    }
}
