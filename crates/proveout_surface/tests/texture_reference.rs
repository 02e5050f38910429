//! Parameters of areas and profiles against surfalize, an independent package; `reference/texture.py` made
//! the values and says how.

use std::f64::consts::{PI, TAU};

use proveout_surface::texture::{
    ArealReport, Asked, HeightMap, Profile, ProfileParameters, ProfileReport, ProfileValues, Standard,
    gaussian_mean_of_map,
};
use serde_json::Value;

/// Numbers in [0, 1) by the rule of `reference/texture.py`.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Heights in mm; steps in um.
fn patch(case: u64, columns: usize, rows: usize, step_x: f64, step_y: f64) -> HeightMap {
    let mut numbers = Numbers(case + 1);
    let (angle, pitch) = (0.4 + 0.5 * case as f64, 60.0 + 20.0 * case as f64);
    let mut heights = Vec::with_capacity(columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let (x, y) = (i as f64 * step_x, j as f64 * step_y);
            let u = angle.cos() * x + angle.sin() * y;
            let v = -angle.sin() * x + angle.cos() * y;
            let ridge = (PI * u / pitch).sin().abs();
            heights.push(1e-3 * (2.0 * ridge + 0.5 * (TAU * v / 410.0).sin() + 0.3 * (numbers.next() - 0.5)));
        }
    }
    HeightMap::new(columns, rows, 1e-3 * step_x, 1e-3 * step_y, heights).expect("a map")
}

/// Heights in mm; step in um.
fn line(case: u64, count: usize, step: f64) -> Vec<f64> {
    let mut numbers = Numbers(100 + case);
    let pitch = 130.0 + 45.0 * case as f64;
    (0..count)
        .map(|i| {
            let x = i as f64 * step;
            let u = x / pitch;
            let c = u - u.floor() - 0.5;
            1e-3 * (6.0 * c * c + 0.8 * (TAU * x / 2900.0).sin() + 0.2 * (numbers.next() - 0.5))
        })
        .collect()
}

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/surfalize.json")).expect("JSON")
}

fn close(got: f64, want: &Value, relative: f64, what: &str) {
    let want = want.as_f64().unwrap_or_else(|| panic!("{what}: no reference"));
    assert!((got - want).abs() <= relative * want.abs(), "{what}: {got} instead of {want}");
}

fn case(entry: &Value, key: &str) -> usize {
    entry[key].as_u64().expect(key) as usize
}

#[test]
fn areas_have_the_values_of_the_package() {
    let reference = reference();
    let areas = reference["areas"].as_array().expect("areas");
    assert_eq!(areas.len(), 3);
    for entry in areas {
        let (k, columns, rows) = (case(entry, "case"), case(entry, "columns"), case(entry, "rows"));
        let map = patch(k as u64, columns, rows, number(entry, "step_x_um"), number(entry, "step_y_um"));
        let unfiltered = ArealReport::of(&map, &Asked::default()).unfiltered;
        let want = &entry["unfiltered"];
        // The same sums over the same nodes.
        for (got, name) in [
            (unfiltered.sa_um, "Sa"),
            (unfiltered.sq_um, "Sq"),
            (unfiltered.sp_um, "Sp"),
            (unfiltered.sv_um, "Sv"),
            (unfiltered.sz_um, "Sz"),
            (unfiltered.ssk, "Ssk"),
            (unfiltered.sku, "Sku"),
            (unfiltered.sdq, "Sdq"),
        ] {
            close(got, &want[name], 1e-9, &format!("area {k}, {name}"));
        }
        // The package takes its triangles along both diagonals, too.
        close(unfiltered.sdr_percent, &want["Sdr"], 1e-6, &format!("area {k}, Sdr"));
        // Both interpolate the autocorrelation between lags of 4 um, each in its own way.
        close(1e3 * unfiltered.sal_mm.expect("decays"), &want["Sal"], 0.05, &format!("area {k}, Sal"));
        assert_eq!(unfiltered.str.is_none(), want["Str"].is_null(), "area {k}, Str");
        // The marks run across the direction that the patch was made with. The package names that direction,
        // with rows upward where rows run with y here; where its steps differ, it warns that it may be wrong.
        let lay = unfiltered.std_deg.expect("a lay");
        let off = |want: f64| ((lay - want + 90.0).rem_euclid(180.0) - 90.0).abs();
        assert!(off((0.4 + 0.5 * k as f64).to_degrees() + 90.0) < 1.5, "area {k}: lay {lay}");
        let bound = if map.step_x() == map.step_y() { 1.5 } else { 4.0 };
        assert!(off(90.0 - want["Std"].as_f64().expect("Std")) < bound, "area {k}: lay {lay}, Std {}", want["Std"]);

        // High-pass, one cut-off inside of the ends; the package stops its weights at four sigma, which
        // leaves 6e-5 of them out.
        let cutoff = 1e-3 * number(entry, "cutoff_um");
        let mean = gaussian_mean_of_map(&map, cutoff);
        let (ex, ey) = ((cutoff / map.step_x()).ceil() as usize, (cutoff / map.step_y()).ceil() as usize);
        let inside: Vec<f64> = (ey..rows - ey)
            .flat_map(|j| (ex..columns - ex).map(move |i| (i, j)))
            .map(|(i, j)| map.at(i, j) - mean.at(i, j))
            .collect();
        let inside =
            HeightMap::new(columns - 2 * ex, rows - 2 * ey, map.step_x(), map.step_y(), inside).expect("a map");
        let p = inside.parameters();
        let want = &entry["highpass_inside"];
        for (got, name) in [
            (1e3 * p.sa, "Sa"),
            (1e3 * p.sq, "Sq"),
            (1e3 * p.sp, "Sp"),
            (1e3 * p.sv, "Sv"),
            (1e3 * p.sz, "Sz"),
            (p.ssk, "Ssk"),
            (p.sku, "Sku"),
            (p.sdq, "Sdq"),
            (100.0 * p.sdr, "Sdr"),
        ] {
            close(got, &want[name], 5e-4, &format!("area {k} filtered, {name}"));
        }
    }
}

fn number(entry: &Value, key: &str) -> f64 {
    entry[key].as_f64().expect(key)
}

#[test]
fn profiles_have_the_values_of_the_package() {
    let reference = reference();
    let profiles = reference["profiles"].as_array().expect("profiles");
    assert_eq!(profiles.len(), 3);
    for entry in profiles {
        let (k, step) = (case(entry, "case"), number(entry, "step_um"));
        let heights = line(k as u64, case(entry, "count"), step);
        let report = ProfileReport::of(&Profile::new(1e-3 * step, heights).expect("a profile"), &Asked::default());
        // The package centers the roughness profile again, which the standard does not.
        let mean = report.roughness.iter().sum::<f64>() / report.roughness.len() as f64;
        let centered: Vec<f64> = report.roughness.iter().map(|z| z - mean).collect();
        let roughness = ProfileValues::from(&ProfileParameters::of(&centered, 1e-3 * step, Standard::Iso21920));
        let reported = report.filtered.expect("evaluated");
        assert!(
            (reported.rp_um - roughness.rp_um - 1e3 * mean).abs() < 1e-9
                && (reported.rz_um - roughness.rz_um).abs() < 1e-9
        );
        // The package takes sums of nodes in place of integrals of the polygon: with noise of 0.2 um from
        // node to node, the mean squares of the two differ by a twelfth of that of the differences; parts of
        // sections lie a node apart.
        for (got, values) in [(report.unfiltered, &entry["unfiltered"]), (roughness, &entry["roughness"])] {
            for (got, name, bound) in [
                (got.ra_um, "Ra", 2e-3),
                (got.rq_um, "Rq", 2e-3),
                (got.rp_um, "Rp", 2e-3),
                (got.rv_um, "Rv", 2e-3),
                (got.rz_um, "Rz", 2e-3),
                (got.rt_um, "Rt", 2e-3),
                (got.rsk, "Rsk", 5e-3),
                (got.rku, "Rku", 5e-3),
            ] {
                close(got, &values[name], bound, &format!("profile {k}, {name}"));
            }
        }
    }
}

#[test]
fn a_reversed_profile_has_the_same_spacing() {
    for k in 0..30 {
        let heights = line(k % 6, 8001 - 97 * k as usize, 0.5);
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        let z: Vec<f64> = heights.iter().map(|z| z - mean).collect();
        let back: Vec<f64> = z.iter().rev().copied().collect();
        for standard in [Standard::Iso21920, Standard::Iso4287] {
            let a = ProfileParameters::of(&z, 0.0005, standard);
            let b = ProfileParameters::of(&back, 0.0005, standard);
            let (a, b) = (a.rsm.expect("elements"), b.rsm.expect("elements"));
            assert!((a - b).abs() < 1e-12, "profile {k}: {a} and {b}");
        }
    }
}
