//! The tool that is in the spindle, from the first motion on and as long as it is there.

use super::*;

/// The second tool is 40 mm longer: it comes into the spindle with 20 mm of its flutes in the block, and goes
/// up out of it in feed.
#[test]
fn a_tool_that_comes_into_the_spindle_in_material_is_found() {
    let program = |height: f64| {
        format!(
            "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 M3\nG0 X-45. Y-45. Z{height}.\nM5\nT2 M6\nG43 H2\nS3000 M3\n\
             G1 Z{}. F1000.\nG0 Z200.\nM30\n%\n",
            height + 10.0
        )
    };
    for (height, depth) in [(45.0, Some(5.0)), (51.0, None)] {
        let shop = Shop::new(&machine(""), "", &program(height));
        let second = TOOLS.replace("number = 1", "number = 2").replace("T1", "T2").replace("_mm = 80", "_mm = 120");
        shop.write("tools.toml", &format!("{TOOLS}\n{second}"));
        let verdict = shop.verdict();
        let found = found(&verdict, "process-rapid-in-material");
        assert_eq!(found.len(), usize::from(depth.is_some()), "{:?}", verdict["findings"]);
        if let Some(depth) = depth {
            assert!((found[0]["penetration_mm"].as_f64().expect("given") - depth).abs() < 0.1, "{found:?}");
            let message = found[0]["message"].as_str().expect("given");
            assert!(
                message.starts_with("cutter of T2 meets material right after the tool change, before it moves"),
                "{message}"
            );
            assert_eq!(found[0]["line"], 12, "{found:?}");
        }
    }
}

#[test]
fn a_start_in_collision_is_found_at_the_start() {
    // Wholly inside of the head at home, which is at Z 300.
    let lamp = "\n[[body]]\nname = \"lamp\"\nrole = \"lamp\"\nattached_to = \"base\"\ncheck = true\n\
                box = [{ min_mm = [-5, -5, 350], max_mm = [5, 5, 360] }]\n";
    let verdict = Shop::new(&machine(lamp), "", TO_THE_COVER).verdict();
    assert_eq!(gate(&verdict, "collision").0, "fail");
    let hits = found(&verdict, "collision-bodies");
    assert_eq!(hits.len(), 1, "{hits:?}");
    assert!(hits[0]["message"].as_str().expect("words").contains("one inside of the other"), "{hits:?}");
    let motion = verdict["clearance"]["pairs"].to_string();
    assert!(hits[0]["time_s"].as_f64().expect("a time") <= 6.0, "before the first block has moved: {hits:?} {motion}");
}

/// Tools 1 and 2, the second one longer by a height.
fn two_tools(longer: f64) -> String {
    let second = TOOLS.replace("number = 1", "number = 2").replace("\"T1\"", "\"T2\"");
    format!("{TOOLS}\n{}", second.replace("gauge_length_mm = 80", &format!("gauge_length_mm = {}", 80.0 + longer)))
}

/// The tool that the scene puts into the spindle at the start is there in the first motion, too: it goes into
/// the post, 60 mm high, or ends over it.
#[test]
fn a_tool_that_is_in_the_spindle_at_the_start_is_checked_from_the_first_motion_on() {
    for (z, state) in [(40.0, "fail"), (66.0, "pass")] {
        let program = format!("%\nO1\nG17 G21 G40 G49 G80 G90 G94 G54\nG0 G43 H1 Z{z}.\nZ200.\nM30\n%\n");
        let shop = Shop::new(&machine(""), &format!("{POST}\n[start]\ntool = 1\n"), &program);
        shop.write("post.stl", &post(0..0, &[]));
        let verdict = shop.verdict();
        assert_eq!(gate(&verdict, "collision").0, state, "{verdict}");
        if state == "fail" {
            assert_eq!(found(&verdict, "collision-bodies")[0]["line"], 4, "{verdict}");
        }
    }
    // The same into the stock, which no body of the machine meets: 3 mm deep.
    let program = "%\nO1\nG17 G21 G40 G49 G80 G90 G94 G54\nG0 G43 H1 Z7.\nZ200.\nM30\n%\n";
    let shop = Shop::new(&machine("").replace("home_mm = 0", "home_mm = -45"), "[start]\ntool = 1\n", program);
    let verdict = shop.verdict();
    let hits = found(&verdict, "process-rapid-in-material");
    assert_eq!((hits.len(), hits.first().map(|f| &f["line"])), (1, Some(&4.into())), "{:?}", verdict["findings"]);
}

/// The last tool of a program comes into the spindle where the one before has cut, and nothing moves it: it
/// is longer, and is in the post, or in the stock next to it, or over both.
#[test]
fn a_tool_that_nothing_moves_is_checked_where_it_stands() {
    let ends = ["M30\n", "", "T1 M6\nM30\n"];
    let places = [("X0. Y0. Z66.", "collision-bodies"), ("X-45. Y-45. Z12.", "process-rapid-in-material")];
    for (place, code) in places {
        for end in ends {
            for (longer, hits) in [(5.0, place.starts_with("X-45")), (20.0, true)] {
                let program =
                    format!("%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nG0 Z80.\n{place}\nT2 M6\n{end}%\n");
                let shop = Shop::new(&machine(""), POST, &program);
                shop.write("post.stl", &post(0..0, &[]));
                shop.write("tools.toml", &two_tools(longer));
                let verdict = shop.verdict();
                let matches = found(&verdict, code);
                assert_eq!(!matches.is_empty(), hits, "{place} {end:?} {longer}: {:?}", verdict["findings"]);
                if hits {
                    assert_eq!((matches.len(), &matches[0]["line"]), (1, &8.into()), "{place} {end:?}: {matches:?}");
                }
            }
        }
    }
}

/// A spindle that is at its speed at once, switched right before a motion into the stock: the word counts in
/// that motion already.
#[test]
fn the_spindle_turns_or_stands_in_the_very_next_block() {
    for (words, stands) in [("M3", false), ("M5", true), ("S0 M3", true)] {
        let program = format!(
            "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 {}\nG0 Z80.\nX-45. Y-45. Z11.\n{words}\nG1 Z8. F300.\nM3\n             G0 Z80.\nM30\n%\n",
            if words == "M5" { "M3" } else { "" }
        );
        let at_once = machine("").replace("start_time_s = 1", "start_time_s = 0");
        let verdict = Shop::new(&at_once, "", &program).verdict();
        let matches = found(&verdict, "process-spindle-off");
        assert_eq!(!matches.is_empty(), stands, "{words}: {:?}", verdict["findings"]);
        assert!(matches.iter().all(|f| f["line"] == 10), "{words}: {matches:?}");
    }
}
