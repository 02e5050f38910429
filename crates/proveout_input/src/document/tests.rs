use std::{collections::BTreeMap, path::PathBuf};

use serde::Deserialize;

use super::*;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "only the reading is tested")]
struct Shop {
    name: String,
    resolution_mm: f64,
    count: Option<u32>,
    model: Option<PathBuf>,
    on: Option<bool>,
    kind: Option<Kind>,
    size_mm: Option<[f64; 3]>,
    #[serde(default)]
    tool: Vec<Tool>,
    #[serde(default)]
    offset: BTreeMap<String, Tool>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Ball,
    BullNose,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "only the reading is tested")]
struct Tool {
    #[serde(default)]
    name: String,
    travel_mm: f64,
    travel_deg: Option<f64>,
}

fn error_of(text: &str) -> String {
    let file = Path::new("shop.toml");
    match Document::new(file, text).read::<Shop>() {
        Ok(shop) => panic!("accepted: {shop:?}"),
        Err(e) => e.to_string(),
    }
}

const GOOD: &str = "name = \"a\"\nresolution_mm = 1.0\n";

#[test]
fn every_fault_has_place_value_limit_and_remedy() {
    let after = |more: &str| error_of(&format!("{GOOD}{more}"));
    for (found, wanted) in [
        (
            error_of(""),
            "shop.toml:1:1: the file holds no key [input-empty]; write a file that matches docs/schemas, or name \
             another file",
        ),
        (
            error_of("# a remark\n"),
            "shop.toml:1:1: the file holds no key [input-empty]; write a file that matches docs/schemas, or name \
             another file",
        ),
        (
            error_of("name = \"a\"\n"),
            "shop.toml:1:1: `resolution_mm` is missing [input-missing-key]; add `resolution_mm = ...`",
        ),
        (after("x = = 1\n"), "shop.toml:3:5: the text is not TOML: "),
        (
            after("resolutoin_mm = 2.0\n"),
            "shop.toml:3:1: `resolutoin_mm` is not a known key [input-unknown-key]; did you mean `resolution_mm`?",
        ),
        (after("zzz = 1\n"), "known keys here: name, resolution_mm, count"),
        (
            after("resolution = 2.0\n"),
            "`resolution` is not a known key [input-unit-missing]; a key carries its unit: write `resolution_mm`",
        ),
        (
            after("count = \"7\"\n"),
            "shop.toml:3:9: `count` = \"7\": must be a whole number, 0 or more [input-wrong-type]; write it without quotes",
        ),
        (
            after("count = -1\n"),
            "shop.toml:3:9: `count` = -1: must be a whole number, 0 or more [input-wrong-type]; write a whole number, 0 or more",
        ),
        (after("count = 1.5\n"), "shop.toml:3:9: `count` = 1.5: must be a whole number, 0 "),
        (
            after("count = 5000000000\n"),
            "`count` = 5000000000: must be a whole number, 0 to 4294967295 [input-wrong-type]",
        ),
        (after("model = 3\n"), "`model` = 3: must be text in quotes [input-wrong-type]; write it in quotes"),
        (after("on = 1\n"), "`on` = 1: must be true or false [input-wrong-type]; write true or false"),
        (
            after("kind = \"bal\"\n"),
            "`kind` = \"bal\": must be one of ball, bull_nose [input-unknown-word]; did you mean \"ball\"?",
        ),
        (after("kind = \"zzzzzz\"\n"), "must be one of ball, bull_nose [input-unknown-word]; write one of them"),
        (after("size_mm = [1, 2]\n"), "`size_mm` = [1, 2]: must be a list of 3 values"),
        (after("size_mm = [1, 2, 3, 4]\n"), "`size_mm` = [1, 2, 3, 4]: must be a list of 3 values"),
        (
            after("size_mm = [1, \"2\", 3]\n"),
            "shop.toml:3:15: `size_mm[1]` = \"2\": must be a number [input-wrong-type]; write it without quotes",
        ),
        (
            after("size_mm = [1, 1e9, 3]\n"),
            "shop.toml:3:15: `size_mm[1]` = 1e9: is out of range: -100000 to 100000 [input-out-of-range]; check the value",
        ),
        (after("tool = 3\n"), "`tool` = 3: must be a list [...] [input-wrong-type]; write a list [...]"),
        (after("[tool]\ntravel_mm = 1\n"), "must be a list"),
        (
            after("[[tool]]\nname = \"T\"\n"),
            "shop.toml:3:1: `tool.T.travel_mm` is missing [input-missing-key]; add `travel_mm = ...`",
        ),
        (
            after("[[tool]]\nname = \"T\"\ntravel = 1\n"),
            "shop.toml:5:1: `tool.T.travel` is not a known key [input-unit-missing]; a key carries its unit: write `travel_mm` or `travel_deg`",
        ),
        (after("[[tool]]\ntravel_mm = \"1\"\n"), "shop.toml:4:13: `tool[0].travel_mm` = \"1\": must be a number"),
        (after("[offset.G54]\ntravel_mm = nan\n"), "shop.toml:4:13: `offset.G54.travel_mm` = nan: is out of range"),
        (after("[offset.G54]\nname = \"\"\n"), "`offset.G54.travel_mm` is missing"),
        (
            after("offset = { G54 = { travel_mm = 1, trvel_deg = 2 } }\n"),
            "`offset.G54.trvel_deg` is not a known key [input-unknown-key]; did you mean `travel_deg`?",
        ),
    ] {
        assert!(found.contains(wanted), "{wanted}\nis not\n{found}");
    }
}

#[test]
fn what_a_reader_finds_later_has_its_place() {
    let text = format!("{GOOD}[[tool]]\nname = \"T\"\ntravel_mm = -3\n[[tool]]\ntravel_mm = 4\n");
    let document = Document::new(Path::new("shop.toml"), &text);
    let at = |item, key| [Step::Key("tool"), Step::Item(item), Step::Key(key)];
    let error = document.error_with_value("tool-short", &at(0, "travel_mm"), "must be above 0", "mend it");
    assert_eq!(error.to_string(), "shop.toml:5:13: `tool.T.travel_mm` = -3: must be above 0 [tool-short]; mend it");
    assert_eq!((error.length, error.source_line.as_str()), (2, "travel_mm = -3"));
    let error = document.error_with_value("", &at(1, "name"), "is missing", "add it");
    assert_eq!(error.to_string(), "shop.toml:6:1: `tool[1].name` is missing; add it");
    assert!(document.has(&at(0, "name")) && !document.has(&at(1, "name")) && !document.has(&at(2, "name")));
    assert_eq!(document.keys(&[Step::Key("tool"), Step::Item(0)]), ["name", "travel_mm"]);
}

#[test]
fn slips_find_their_word() {
    assert_eq!(nearest("diamter_mm", ["number", "diameter_mm", "flutes"]), Some("diameter_mm"));
    assert_eq!(nearest("zzzzzz", ["number", "diameter_mm", "flutes"]), None);
    assert_eq!(nearest("lift", ["right", "left"]), Some("left"));
}
