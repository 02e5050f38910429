//! Single numbers of a scene whose range does not follow from their unit.

use std::ops::RangeInclusive;

use proveout_input::Step::Key;

use crate::scene::{SceneFile, place::offset_of};

/// What is wrong with such a number: its offset in the text of the scene, message and help.
pub(crate) fn fault(text: &str, file: &SceneFile) -> Option<(usize, String, &'static str)> {
    let control = &file.control;
    let piece = control.piece_tolerance_mm.as_ref().map(|t| *t.get_ref());
    type Row<'a> = (&'a str, &'a str, Option<f64>, RangeInclusive<f64>, &'static str);
    let rows: [Row<'_>; 4] = [
        (
            "control",
            "path_tolerance_mm",
            control.path_tolerance_mm,
            0.0..=10.0,
            "write 0 to 10, or leave it out for the machine's",
        ),
        ("control", "piece_tolerance_mm", piece, 1e-6..=0.1, "write 0.000001 to 0.1, or leave it out for 0.0005"),
        (
            "control",
            "pole_cone_deg",
            control.pole_cone_deg,
            0.0..=5.0,
            "write 0 to 5, or leave it out for the machine's",
        ),
        (
            "run_limits",
            "simulated_time_s",
            file.run_limits.simulated_time_s,
            1.0..=1e7,
            "write 1 to 10000000, or leave it out for 360000",
        ),
    ];
    rows.into_iter().find_map(|(table, key, value, range, help)| {
        let value = value.filter(|v| !range.contains(v))?;
        let at = offset_of(text, &[Key(table), Key(key)]);
        Some((at, format!("{key} = {value} is out of range"), help))
    })
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    #[test]
    fn a_number_out_of_its_range_is_refused_by_its_key_where_it_stands() {
        let scene = |control: &str, limits: &str| {
            format!(
                "name = \"part\"\nmachine = \"m\"\ntools = \"t\"\nresolution_mm = 1\n[stock]\nbox = {{ min_mm = [0, 0, 0], max_mm = [9, 9, 9] }}\n\
                 [mount]\ntranslation_mm = [0, 0, 0]\n[control]\n{control}\n[run_limits]\n{limits}\n[[program]]\nname = \"a\"\nfile = \"a.nc\"\n"
            )
        };
        let read = |control: &str, limits: &str| Scene::of_text("scene.toml".into(), &scene(control, limits));
        for (control, limits) in
            [("path_tolerance_mm = 0", ""), ("pole_cone_deg = 5", ""), ("", "simulated_time_s = 1")]
        {
            if let Err(error) = read(control, limits) {
                panic!("{control} {limits}: {error}");
            }
        }
        for (control, limits, key, line) in [
            ("path_tolerance_mm = -1", "", "path_tolerance_mm = -1 ", 10),
            ("path_tolerance_mm = 11", "", "path_tolerance_mm = 11 ", 10),
            ("piece_tolerance_mm = 0", "", "piece_tolerance_mm = 0 ", 10),
            ("pole_cone_deg = -1", "", "pole_cone_deg = -1 ", 10),
            ("pole_cone_deg = 5.1", "", "pole_cone_deg = 5.1 ", 10),
            ("", "simulated_time_s = -1", "simulated_time_s = -1 ", 12),
            ("", "simulated_time_s = 0", "simulated_time_s = 0 ", 12),
        ] {
            let error = read(control, limits).expect_err(key).to_string();
            assert!(error.contains(key) && error.contains(&format!("scene.toml:{line}:")), "{error}");
        }
    }
}
