//! Meshes that bound no solid, bodies without a size, and machines that are described in part.

use super::*;

#[test]
fn the_surface_of_an_open_mesh_is_checked_and_its_inside_is_named() {
    for (holes, height, state) in [(0, 1.2, "pass"), (2, 1.2, "unchecked"), (2, 0.8, "unchecked"), (2, -0.02, "fail")] {
        let shop = Shop::new(&machine(""), POST, &over_the_post(height));
        // Its lower face is missing.
        shop.write("post.stl", &post(0..holes, &[]));
        let verdict = shop.verdict();
        let (is, reason) = gate(&verdict, "collision");
        assert_eq!(is, state, "{holes} {height}: {reason}");
        let named = "the inside of post: the mesh has a hole";
        assert_eq!(reason.contains(named), holes > 0, "{reason}");
        assert_eq!(gate(&verdict, "near_miss").1.contains(named), holes > 0);
        let hits = found(&verdict, if height < 0.0 { "collision-bodies" } else { "collision-near-miss" });
        if height < 1.0 {
            assert_eq!(hits[0]["line"], 8, "{hits:?}");
            assert_eq!(gate(&verdict, "near_miss").0, "fail");
        } else {
            assert!(hits.is_empty(), "{hits:?}");
        }
    }
}

#[test]
fn a_triangle_without_area_counts_as_the_line_that_it_is() {
    // A line that rises from the top by 5 mm: the holder, 3 mm over it, meets the line and nothing else.
    let line = [[-12.0, 0.0, 60.0], [-12.0, 0.0, 62.0], [-12.0, 0.0, 65.0]];
    for (more, state) in [(vec![], "pass"), (vec![line], "fail")] {
        let shop = Shop::new(&machine(""), POST, &over_the_post(3.0));
        shop.write("post.stl", &post(0..0, &more));
        let verdict = shop.verdict();
        let (is, reason) = gate(&verdict, "collision");
        assert_eq!(is, state, "{reason}");
        if state == "fail" {
            assert_eq!(found(&verdict, "collision-bodies")[0]["line"], 8, "{verdict}");
            assert!(reason.contains("the inside of post"), "a line closes nothing: {reason}");
        } else {
            assert!(!reason.contains("no area"), "{reason}");
        }
    }
    // A vertex on an edge, joined by a triangle that is a line, as repaired meshes have them: still a solid.
    let [a, b, foot] = [[-15.0, -15.0, 60.0], [15.0, -15.0, 60.0], [-15.0, -15.0, 0.0]];
    let m = [0.0, -15.0, 60.0];
    let shop = Shop::new(&machine(""), POST, &over_the_post(3.0));
    shop.write("post.stl", &post(5..6, &[[foot, b, m], [foot, m, a], [a, m, b]]));
    let verdict = shop.verdict();
    let (is, reason) = gate(&verdict, "collision");
    assert!(is == "pass" && reason.contains("1 triangle of post has no area and counts as a line"), "{reason}");
}

#[test]
fn bodies_without_a_size_are_refused_by_name() {
    let point = [[1.0, 2.0, 3.0]; 3];
    let flat =
        [[[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 9.0, 0.0], [9.0, 0.0, 0.0]]];
    for (mesh, words) in [
        (post(0..12, &[point]), "the only triangle of ./post.stl has no area"),
        (post(0..12, &[point, point]), "each of the 2 triangles of ./post.stl has no area"),
        (post(0..12, &flat), "volume is 0.000 mm3"),
    ] {
        let shop = Shop::new(&machine(""), POST, TO_THE_COVER);
        shop.write("post.stl", &mesh);
        let (code, said) = shop.run();
        assert_eq!(code, 2, "{said}");
        assert!(said.contains("post") && said.contains(words), "{said}");
        assert!(!shop.path().join("result").exists());
    }
    let empty = "[[fixture]]\nname = \"post\"\nbox = { min_mm = [0, 0, 0], max_mm = [0, 5, 5] }\n";
    let (code, said) = Shop::new(&machine(""), empty, TO_THE_COVER).run();
    assert!(code == 2 && said.contains("scene.toml") && said.contains("fixture \"post\" is empty"), "{said}");
    let none = machine("").replace("max_mm = [160, 100, 600]", "max_mm = [150, 100, 600]");
    let (code, said) = Shop::new(&none, "", TO_THE_COVER).run();
    assert!(code == 2 && said.contains("machine.toml:") && said.contains("is empty"), "{said}");
}

/// No finding could say which of two fixtures it means, and of a cylinder without an inside nothing can be
/// said.
#[test]
fn fixtures_that_a_finding_could_not_tell_apart_are_refused_with_their_place() {
    let one = |name: &str, form: &str| format!("[[fixture]]\nname = \"{name}\"\n{form}\n");
    let block = "box = { min_mm = [0, 0, 0], max_mm = [9, 9, 9] }";
    let round = |radius: f64, height: f64| {
        format!("cylinder = {{ base_mm = [0, 0, 0], radius_mm = {radius}, height_mm = {height} }}")
    };
    for (fixtures, words) in [
        (one("jaw", block) + &one("jaw", block), "two fixtures have the name \"jaw\""),
        (one("stock", block), "a fixture is named \"stock\""),
        (one(" ", block), "a fixture has no name"),
        (one("head", block), "fixture \"head\" has the name of a body of the machine"),
        (one("pin", &round(0.0, 9.0)), "the cylinder of fixture \"pin\" is empty"),
        (one("pin", &round(-3.0, 9.0)), "the cylinder of fixture \"pin\" is empty"),
        (one("pin", &round(3.0, 0.0)), "the cylinder of fixture \"pin\" is empty"),
    ] {
        let (code, said) = Shop::new(&machine(""), &fixtures, TO_THE_COVER).run();
        assert!(code == 2 && said.contains(words) && said.contains("scene.toml"), "{words}: {said}");
        let line = if words.contains("two fixtures") { 12 } else { 9 };
        assert!(words.contains("of a body") || said.contains(&format!("scene.toml:{line}:1")), "{line}: {said}");
    }
}

/// A machine that is described without a body is not checked, whatever is next to it.
#[test]
fn a_machine_without_bodies_is_not_passed_for_its_fixtures() {
    let bare = machine("").split("\n[[body]]").next().expect("the joints").to_owned();
    let jaw = "[[fixture]]\nname = \"jaw\"\nbox = { min_mm = [20, 20, 0], max_mm = [30, 30, 20] }\n";
    let verdict = Shop::new(&bare, jaw, TO_THE_COVER).verdict();
    for name in ["collision", "near_miss"] {
        let (state, reason) = gate(&verdict, name);
        assert_eq!(state, "unchecked", "{name}: {reason}");
        assert!(reason.contains("its file has no bodies"), "{name}: {reason}");
    }
}

/// A tool below the table's face is a finding only where the table is described: a machine file with bodies,
/// but none that moves with the table or with the spindle, is not passed, and the gate names which.
#[test]
fn a_machine_without_its_table_or_its_spindle_is_not_passed() {
    let jaw = "[[fixture]]\nname = \"jaw\"\nbox = { min_mm = [20, 20, 0], max_mm = [30, 30, 20] }\n";
    let away = TO_THE_COVER.replace("X95.", "X60.");
    for (moved, end) in [("\"B\"", "table"), ("\"Z\"", "spindle")] {
        let away_from = machine("").replace(&format!("attached_to = {moved}"), "attached_to = \"X\"");
        let verdict = Shop::new(&away_from, jaw, &away).verdict();
        for name in ["collision", "near_miss"] {
            let (state, reason) = gate(&verdict, name);
            assert_ne!(state, "pass", "{name}: {reason}");
            let text = format!("the {end}: no body of the machine file moves with it (`attached_to = {moved}`)");
            assert!(reason.contains(&text), "{name}: {reason}");
        }
    }
}
