//! What holds the part, as whoever makes the scene says it: a fixture by its size, or none with a reason.
//! Nothing is proposed: without an answer the scene says nothing of it, and its runs leave `collision` and
//! `near_miss` unchecked.

use proveout_geom::Aabb;
use proveout_tool::{plain_number as n, quoted};

use super::{
    FirstPartError,
    interview::{Interview, unit},
    refused,
};
use crate::prepare::program_trace::SAME_MM;

/// Begin of the line that says how far a fixture reaches below the stock.
const BELOW: &str = "# Below the stock, mm: ";
/// Key of the answer.
const KEY: &str = "workholding";
/// Sizes that no answer gives, mm: thickness of the jaws of a vise and height of its bed, width of
/// the jaws of a chuck, stud of a clamp.
const JAW_MM: f64 = 20.0;
const BED_MM: f64 = 30.0;
const CHUCK_JAW_MM: f64 = 25.0;
const STUD_MM: f64 = 12.0;
const STUD_HEIGHT_MM: f64 = 15.0;
const FORMS: &str = "write `vise 125x40 grip 8` (width x height of the jaws, depth of the grip), `clamps 100x30x20 reach 10` (two toe clamps, length x \
                     width x thickness), `plate 200x150x20`, `chuck 160x80 grip 30` (diameter x length, height of the jaws) or `none: REASON`, with \
                     `inch` at the end for inches";

/// What the scene says of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Workholding {
    /// Nothing.
    Unknown,
    /// There is none, for this reason.
    None(String),
    /// Fixtures, and in words.
    Fixtures(Vec<FixtureText>, String),
}

/// A table `[[fixture]]` of the scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FixtureText {
    pub(crate) text: String,
    /// How far it reaches below the stock, mm.
    below: f64,
}

impl Workholding {
    /// In one line, for people.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Unknown => "not stated: add [[fixture]], or workholding = \"none\"; until then collision and near_miss are unchecked".into(),
            Self::None(reason) => format!("none: {reason}"),
            Self::Fixtures(_, words) => words.clone(),
        }
    }
}

impl Workholding {
    /// The same with the bed of a vise down to the table, and what does not fit under the part.
    pub(crate) fn on_table(self, stock: &Aabb, gap: f64) -> (Self, Option<String>) {
        let Self::Fixtures(_, answer) = &self else { return (self, None) };
        let Ok(Self::Fixtures(texts, words)) = read(answer, stock, Some(gap)) else { return (self, None) };
        let lowest = texts.iter().map(|t| t.below).fold(0.0, f64::max);
        let note = (lowest > gap + SAME_MM).then(|| {
            format!(
                "{words} reaches {} mm below the part, which is mounted {} mm above the table: state the place of the part (`mount`, or \
                 [mount] of the scene)",
                n(lowest),
                n(gap)
            )
        });
        (Self::Fixtures(texts, words), note)
    }
}

/// Asks for it; an open answer is no fault.
pub(super) fn workholding(stock: &Aabb, interview: &mut Interview<'_, '_>) -> Result<Workholding, FirstPartError> {
    let text = format!("What holds the part? An empty line leaves it open. {FORMS}");
    let Some(answer) = interview.may_be_open(KEY, text) else { return Ok(Workholding::Unknown) };
    read(&answer, stock, None).map_err(|message| refused(format!("`{KEY}` = {answer:?}: {message}"), FORMS))
}

/// `gap`: from the table to the lower face of the stock, mm, once the mounting is known.
fn read(answer: &str, stock: &Aabb, gap: Option<f64>) -> Result<Workholding, String> {
    let answer = answer.trim();
    let (word, rest) = answer.split_once([' ', ':']).unwrap_or((answer, ""));
    if word.eq_ignore_ascii_case("none") {
        let reason = rest.trim().trim_start_matches(':').trim();
        if reason.is_empty() {
            return Err("none needs a reason".into());
        }
        return Ok(Workholding::None(reason.to_owned()));
    }
    let (rest, mm) = unit(rest);
    let mut words = rest.split_whitespace();
    let sizes = words.next().unwrap_or_default();
    let sizes: Option<Vec<f64>> = sizes.split(['x', 'X']).map(|t| positive(t).map(|v| v * mm)).collect();
    let sizes = sizes.ok_or("its size must be numbers separated by x")?;
    let (mut depth, mut along_y) = (None, stock.size().y > stock.size().x);
    while let Some(key) = words.next() {
        let value = words.next().unwrap_or_default();
        match key.to_ascii_lowercase().as_str() {
            "grip" | "reach" => depth = Some(positive(value).ok_or(format!("{key} {value:?} is not a length"))? * mm),
            "along" if value.eq_ignore_ascii_case("x") => along_y = false,
            "along" if value.eq_ignore_ascii_case("y") => along_y = true,
            _ => return Err(format!("{key:?} is not known")),
        }
    }
    let depth = |what: &str| depth.ok_or(format!("it has no {what}"));
    let (mid, size) = (stock.center(), stock.size());
    let form = |kind: &str, name: &str, at: [f64; 3], turn: f64, keys: &[(&str, f64)], chosen: &str, below: f64| {
        let mut text = format!(
            "{BELOW}{}\n[[fixture]]\nname = {}\nkind = \"{kind}\"\nat_mm = [{}, {}, {}]\n",
            n(below),
            quoted(name),
            n(at[0]),
            n(at[1]),
            n(at[2])
        );
        if turn != 0.0 {
            text += &format!("rotation_deg = [0, 0, {}]\n", n(turn));
        }
        for (key, value) in keys {
            text += &format!("{key} = {}\n", n(*value));
        }
        let chosen = if chosen.is_empty() { String::new() } else { format!("; assumed: {chosen}") };
        text += &format!("source = {}\n", quoted(&format!("the answer of the call: {answer}{chosen}")));
        FixtureText { text, below }
    };
    let words = answer.to_owned();
    match (word.to_ascii_lowercase().as_str(), &sizes[..]) {
        ("vise", [width, height]) => {
            let grip = depth("grip")?;
            if grip >= *height {
                return Err("the grip is as deep as the jaws are high".into());
            }
            // Down to the table, where it leaves room for a bed.
            let bed = gap.map(|gap| gap - (height - grip)).filter(|room| *room >= 1.0).unwrap_or(BED_MM);
            let keys = [
                ("opening_mm", if along_y { size.x } else { size.y }),
                ("jaw_width_mm", *width),
                ("jaw_height_mm", *height),
                ("jaw_thickness_mm", JAW_MM),
                ("bed_height_mm", bed),
            ];
            let chosen = format!("jaws {JAW_MM} mm thick, bed {} mm high", n(bed));
            let turn = if along_y { 90.0 } else { 0.0 };
            let vise =
                form("vise", "vise", [mid.x, mid.y, stock.min.z + grip], turn, &keys, &chosen, height - grip + bed);
            Ok(Workholding::Fixtures(vec![vise], words))
        }
        ("clamps", [length, width, thickness]) => {
            let reach = depth("reach")?;
            if reach >= *length {
                return Err("the reach is as long as the clamp".into());
            }
            let keys = [
                ("length_mm", *length),
                ("width_mm", *width),
                ("thickness_mm", *thickness),
                ("reach_mm", reach),
                ("height_mm", size.z),
                ("stud_diameter_mm", STUD_MM.min(0.5 * width)),
                ("stud_height_mm", STUD_HEIGHT_MM),
            ];
            let chosen = "stud, and posts that end at the lower face of the stock";
            let ends = if along_y {
                [([mid.x, stock.min.y], -90.0), ([mid.x, stock.max.y], 90.0)]
            } else {
                [([stock.min.x, mid.y], 180.0), ([stock.max.x, mid.y], 0.0)]
            };
            let clamps = ends.iter().enumerate().map(|(k, ([x, y], turn))| {
                form("toe-clamp", &format!("clamp {}", k + 1), [*x, *y, stock.max.z], *turn, &keys, chosen, 0.0)
            });
            Ok(Workholding::Fixtures(clamps.collect(), words))
        }
        ("plate", [length, width, thickness]) => {
            let keys = [("length_mm", *length), ("width_mm", *width), ("thickness_mm", *thickness)];
            let plate = form("plate", "plate", [mid.x, mid.y, stock.min.z], 0.0, &keys, "", *thickness);
            Ok(Workholding::Fixtures(vec![plate], words))
        }
        ("chuck", [diameter, length]) => {
            let grip = depth("grip")?;
            let held = size.x.max(size.y);
            if held >= *diameter {
                return Err(format!(
                    "the stock is {} mm wide, the chuck has a diameter of {} mm",
                    n(held),
                    n(*diameter)
                ));
            }
            let keys = [
                ("diameter_mm", *diameter),
                ("length_mm", *length),
                ("grip_diameter_mm", held),
                ("jaws", 3.0),
                ("jaw_width_mm", CHUCK_JAW_MM),
                ("jaw_height_mm", grip),
            ];
            let chosen = format!("three jaws, {CHUCK_JAW_MM} mm wide");
            let chuck = form("chuck", "chuck", [mid.x, mid.y, stock.min.z], 0.0, &keys, &chosen, *length);
            Ok(Workholding::Fixtures(vec![chuck], words))
        }
        (kind @ ("vise" | "clamps" | "plate" | "chuck"), sizes) => {
            Err(format!("{} numbers are not the size of a {kind}", sizes.len()))
        }
        (other, _) => Err(format!("{other:?} is not a known workholding")),
    }
}

fn positive(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|v| *v > 0.0 && *v <= 5000.0)
}

#[cfg(test)]
mod tests {
    use proveout_geom::Point;

    use super::*;
    use crate::scene::{FixtureFile, setup::fixture_fault};

    #[test]
    fn every_form_gives_fixtures_that_the_scene_takes_and_wrong_ones_are_refused() {
        #[derive(serde::Deserialize)]
        struct File {
            fixture: Vec<FixtureFile>,
        }
        let long = Aabb { min: Point::new(-30.0, -20.0, -20.0), max: Point::new(30.0, 20.0, 0.0) };
        let deep = Aabb { min: Point::new(0.0, 0.0, -50.8), max: Point::new(25.4, 101.6, 0.0) };
        for stock in [long, deep] {
            for (answer, count) in [
                ("vise 125x40 grip 8", 1),
                ("vise 5x2 grip 0.3 inch", 1),
                ("VISE 125X40 grip 8 along Y", 1),
                ("clamps 100x30x20 reach 10", 2),
                ("plate 200x150x20", 1),
                ("chuck 260x80 grip 30", 1),
            ] {
                let Ok(Workholding::Fixtures(texts, words)) = read(answer, &stock, None) else { panic!("{answer}") };
                assert_eq!((texts.len(), words.as_str()), (count, answer));
                let text: String = texts.iter().map(|t| t.text.as_str()).collect();
                let file: File = toml::from_str(&text).unwrap_or_else(|e| panic!("{text}: {e}"));
                assert!(fixture_fault(&text, &file.fixture).is_none(), "{text}");
            }
        }
        let vise = read("vise 125x40 grip 8", &long, None).expect("read");
        for (gap, lowest, fits) in [(50.0, 50.0, true), (32.5, 62.0, false), (10.0, 62.0, false)] {
            let (Workholding::Fixtures(texts, _), note) = vise.clone().on_table(&long, gap) else { panic!("{gap}") };
            assert_eq!((texts[0].below, note.is_none()), (lowest, fits), "{gap}: {note:?}");
        }
        assert_eq!(read("none: glued on wax", &long, None), Ok(Workholding::None("glued on wax".into())));
        for (answer, words) in [
            ("none", "reason"),
            ("none:", "reason"),
            ("vise", "size"),
            ("vise 125x40", "no grip"),
            ("vise 125x40 grip 40", "as deep"),
            ("vise 125x40x3 grip 8", "3 numbers"),
            ("vise 125x-4 grip 8", "size"),
            ("vise 125x40 grip deep", "not a length"),
            ("clamps 100x30x20", "no reach"),
            ("chuck 50x80 grip 30", "60 mm wide"),
            ("magnet 3x4", "not a known workholding"),
            ("plate 200x150x20 tall 3", "not known"),
        ] {
            let error = read(answer, &long, None).expect_err(answer);
            assert!(error.contains(words), "{answer}: {error}");
        }
    }
}
