//! Files of materials and limits: what is read, and what is refused by name.

use std::path::{Path, PathBuf};

use proveout_feeds::{LimitsFile, Material};

use crate::flat;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_owned()
}

#[test]
fn every_material_of_the_project_is_read_and_has_a_source() {
    let mut count = 0;
    for entry in std::fs::read_dir(root().join("materials")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let m = Material::read(&path).unwrap();
            assert!(
                m.specific_force(0.1) > m.specific_force(0.3) && m.uncertainty_percent > 0.0 && !m.source.is_empty()
            );
            count += 1;
        }
    }
    assert!(count >= 10, "{count}");
}

fn refused(text: &str) -> String {
    let path = root().join("materials/limits.toml");
    LimitsFile::from_text(&path, text.to_owned()).map_or_else(|e| e.to_string(), |_| panic!("taken: {text}"))
}

#[test]
fn limits_that_cannot_be_are_refused_with_the_place() {
    for (text, what) in [
        ("[tool.F10]\nmax_chips_mm = 0.1\n", "max_chip_mm"),
        ("[tool.F10]\nmax_chip_mm = 0\n", "above 0"),
        ("[tool.F10]\nmax_force_n = -5\n", "above 0"),
        ("[tool.F10]\nmax_power_kw = nan\n", "max_power_kw"),
        ("[tool.F10]\nmax_chip_mm = 0.1\nmin_chip_mm = 0.2\n", "no feed meets both"),
        ("[tool.F10]\nmax_deflection_um = 20\n", "youngs_modulus_gpa"),
        ("material = \"nowhere.toml\"\n", "nowhere.toml"),
        ("spindle_efficiency = 1.2\n", "spindle_efficiency"),
        ("[tool.F10]\nmax_chip_mm = \"thin\"\n", "number"),
    ] {
        let said = refused(text);
        assert!(said.contains(what), "{text}: {said}");
        assert!(said.contains("limits.toml:"), "{said}");
    }
}

#[test]
fn a_tool_without_teeth_or_material_is_named() {
    let limits = |text: &str| LimitsFile::from_text(&root().join("materials/limits.toml"), text.to_owned()).unwrap();
    let error = |text: &str, tool: &str| {
        limits(text).model_of(&flat(tool)).map_or_else(|e| e.to_string(), |_| panic!("{text}"))
    };
    let said = error("[tool.F10]\nmax_chip_mm = 0.1\n", "");
    assert!(said.contains("no teeth") && said.contains("flutes"), "{said}");
    let said = error("[tool.F10]\nmax_force_n = 100\n", "flutes = 2\n");
    assert!(said.contains("no material"), "{said}");
    let said = error("material = \"mild-steel.toml\"\n[tool.F10]\nmax_power_kw = 1\n", "flutes = 2\n");
    assert!(said.contains("spindle_efficiency"), "{said}");
    // A chip alone needs no material; a tool that no limit names needs nothing.
    assert!(limits("[tool.F10]\nmax_chip_mm = 0.1\n").model_of(&flat("flutes = 2\n")).unwrap().is_none());
    assert!(limits("[tool.OTHER]\nmax_chip_mm = 0.1\n").model_of(&flat("")).unwrap().is_none());
    let all = limits("material = \"mild-steel.toml\"\nspindle_efficiency = 0.8\n[tool.F10]\nmax_power_kw = 1\n");
    assert!(all.model_of(&flat("flutes = 2\n")).unwrap().is_some());
    assert!(all.assumed().is_empty());
}

#[test]
fn a_name_that_the_library_lacks_is_refused_with_the_nearest() {
    let limits =
        LimitsFile::from_text(&root().join("materials/l.toml"), "[tool.F1O]\nmax_chip_mm = 0.1\n".into()).unwrap();
    let text = "[[tool]]\nnumber = 1\nname = \"F10\"\nkind = \"flat\"\ndiameter_mm = 10\nflute_length_mm = 30\ngauge_length_mm = 60\n";
    let library = proveout_tool::ToolLibrary::from_text(Path::new("t.toml"), text).unwrap();
    let said = limits.check_names(&library).unwrap_err().to_string();
    assert!(said.contains("F1O") && said.contains("F10"), "{said}");
}
