//! Cells, units and places that do not belong together: a stock between the rays, meshes in another unit, a
//! volume that does not add up.

use std::time::Duration;

use serde_json::Value;

use crate::hostile::workshop::Workshop;

/// A box as STL text, its numbers divided by `unit`.
fn stl(min: [f64; 3], max: [f64; 3], unit: f64) -> String {
    let corner =
        |k: usize| -> [f64; 3] { std::array::from_fn(|i| if k >> i & 1 == 0 { min[i] } else { max[i] } / unit) };
    let faces = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    let mut text = String::from("solid box\n");
    for face in faces {
        text += "facet normal 0 0 0\nouter loop\n";
        for k in face {
            let [x, y, z] = corner(k);
            text += &format!("vertex {x:e} {y:e} {z:e}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid box\n"
}

fn verdict(shop: &Workshop) -> Value {
    serde_json::from_str(&shop.read("result/verdict.json")).expect("JSON")
}

const BOX: &str = "box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }";

/// Bars, plates and rods that no ray of a direction meets: refused with a cell size, and with that they run.
#[test]
fn a_stock_that_the_rays_miss_is_refused_with_the_cells_that_hold_it() {
    for (stock, cell) in [
        ("cylinder = { base_mm = [0, 0, -40], radius_mm = 0.5, height_mm = 40 }", "2.0"),
        ("cylinder = { base_mm = [0, 0, -40], radius_mm = 0.3, height_mm = 40, along = \"x\" }", "1.0"),
        ("box = { min_mm = [-2, -2, -40], max_mm = [2, 2, 0] }", "10.0"),
        ("box = { min_mm = [-30, -1, -1], max_mm = [30, 1, 0] }", "5.0"),
        (BOX, "1000"),
    ] {
        let shop = Workshop::new();
        shop.replace("scene.toml", BOX, stock);
        shop.replace("scene.toml", "resolution_mm = 1.0", &format!("resolution_mm = {cell}"));
        let output = shop.refused(&["between the rays", "resolution_mm of "]);
        let named = output.text.split("resolution_mm of ").nth(1).and_then(|t| t.split(' ').next()).expect("a size");
        shop.replace("scene.toml", &format!("resolution_mm = {cell}"), &format!("resolution_mm = {named}"));
        let output = shop.run();
        assert!(matches!(output.code(), Some(0 | 1 | 3)), "{stock} at {named}: {}", output.text);
    }
}

/// One range of the cell size, in the scene, by `--set` and by the option.
#[test]
fn the_cell_size_has_one_range() {
    for value in ["5000", "1e300", "0.000001", "0", "-1", "nan"] {
        let shop = Workshop::new();
        let of_call = shop.call(&["run", ".", &format!("--resolution-mm={value}"), "--output", "result"]);
        let of_set = shop.call(&["run", ".", "--set", &format!("resolution_mm={value}"), "--output", "result"]);
        shop.replace("scene.toml", "resolution_mm = 1.0", &format!("resolution_mm = {value}"));
        let of_scene = shop.call(&["run", ".", "--output", "result"]);
        for output in [of_call, of_set, of_scene] {
            assert_eq!(output.code(), Some(2), "{value}: {}", output.text);
            let is_named = output.text.contains("out of range: 0.00001 to 1000");
            let is_no_number = value == "nan" && output.text.contains("is not a usable number");
            assert!(is_named || is_no_number, "{value}: {}", output.text);
        }
    }
}

/// Fixtures, designs and stocks in inches, meters and centimeters, and designs far off: refused by `check`
/// and `run` in seconds, until the unit is stated.
#[test]
fn meshes_in_another_unit_are_refused_until_it_is_stated() {
    let clamp = ([-7.0, 20.0, -15.0], [7.0, 45.0, 10.0]);
    let part = ([-18.0, -18.0, -20.0], [18.0, 18.0, -2.0]);
    let raw = ([-20.0, -20.0, -20.0], [20.0, 20.0, 0.0]);
    for (unit, factor) in [("inch", 25.4), ("m", 1000.0)] {
        for (role, (min, max)) in [("fixture", clamp), ("part", part), ("stock", raw)] {
            let shop = Workshop::new();
            shop.write("body.stl", stl(min, max, factor));
            let stated = format!("mesh = \"body.stl\"\nmesh_unit = \"{unit}\"");
            let place = |form: &str| match role {
                "fixture" => shop.scene(&format!("[[fixture]]\nname = \"clamp\"\n{form}")),
                "part" => shop.scene(&format!("[part]\n{form}")),
                _ => {
                    shop.scene("");
                    shop.replace("scene.toml", BOX, form);
                }
            };
            place("mesh = \"body.stl\"");
            for call in [&["check", "."][..], &["run", ".", "--output", "result"]] {
                let output = shop.call(call);
                assert_eq!(output.code(), Some(2), "{role} {unit}: {}", output.text);
                assert!(
                    output.text.contains(role) && output.text.contains("mesh_unit"),
                    "{role} {unit}: {}",
                    output.text
                );
                assert!(output.text.contains(&format!("mesh_unit = \"{unit}\"")), "{role} {unit}: {}", output.text);
                assert!(output.wall < Duration::from_secs(20), "{:?}", output.wall);
            }
            place(&stated);
            let output = shop.run();
            assert!(matches!(output.code(), Some(0 | 1 | 3)), "{role} {unit}: {}", output.text);
        }
    }
    // A pin that is meant.
    let shop = Workshop::new();
    shop.write("body.stl", stl([-1.0, -1.0, -9.0], [1.0, 1.0, -5.0], 1.0));
    shop.scene("[[fixture]]\nname = \"pin\"\nmesh = \"body.stl\"");
    shop.refused(&["pin", "wholly inside of the stock"]);
    shop.scene("[[fixture]]\nname = \"pin\"\nmesh = \"body.stl\"\nmesh_unit = \"mm\"");
    assert!(matches!(shop.run().code(), Some(0 | 1 | 3)));
    // Stated of no mesh.
    shop.scene("[[fixture]]\nname = \"pin\"\nbox = { min_mm = [30, 0, 0], max_mm = [31, 1, 1] }\nmesh_unit = \"mm\"");
    shop.refused(&["mesh_unit"]);
}

/// Designs many times as large as the stock or far away from it end in seconds, stated or not.
#[test]
fn a_design_of_another_size_ends_in_seconds() {
    let (min, max) = ([-18.0, -18.0, -20.0], [18.0, 18.0, -2.0]);
    for factor in [9.0, 50.0, 1000.0] {
        let shop = Workshop::new();
        shop.write("part.stl", stl(min, max, 1.0 / factor));
        shop.scene("[part]\nmesh = \"part.stl\"");
        let output = shop.refused(&["part", "times as large"]);
        assert!(output.wall < Duration::from_secs(20), "{factor}: {:?}", output.wall);
        shop.scene("[part]\nmesh = \"part.stl\"\nmesh_unit = \"mm\"");
        let output = shop.run();
        assert!(matches!(output.code(), Some(0 | 1 | 3)), "{factor}: {}", output.text);
        assert!(output.wall < Duration::from_secs(60), "{factor}: {:?}", output.wall);
    }
    let shop = Workshop::new();
    shop.write("part.stl", stl(min.map(|x| x + 500.0), max.map(|x| x + 500.0), 1.0));
    shop.scene("[part]\nmesh = \"part.stl\"");
    shop.refused(&["part", "away from the stock"]);
}

/// A face of 40 x 40 x 2 mm: the same volume at any cells, in verdict, blocks and tools; with what is left it
/// is the stock.
#[test]
fn removed_and_left_are_the_stock() {
    const PROGRAM: &str = "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X-35 Y-12 Z50 S1000 M3 D1\nG0 Z-2\nG1 X35 F2000\nG1 Y4\nG1 X-35\nG1 Y20\nG1 X35\nG0 Z50\nM30\n";
    for cell in ["0.3", "0.4", "0.7", "1.0", "1.9"] {
        let shop = Workshop::new();
        shop.write("program.mpf", PROGRAM);
        shop.replace("scene.toml", "resolution_mm = 1.0", &format!("resolution_mm = {cell}"));
        shop.run();
        let v = verdict(&shop);
        let number = |path: &str| v.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"));
        let (removed, left) = (number("/removal/volume_mm3"), number("/removal/stock_left_mm3"));
        assert!((removed - 3200.0).abs() < 1e-2, "{cell}: {removed}");
        assert!((removed + left - 32_000.0).abs() < 1e-6, "{cell}: {removed} {left}");
        let tools: f64 = v["tools"].as_array().expect("tools").iter().filter_map(|t| t["volume_mm3"].as_f64()).sum();
        assert!((tools - removed).abs() < 1e-6, "{cell}: {tools} {removed}");
    }
}
