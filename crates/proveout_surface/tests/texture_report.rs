//! Reports of texture: what is named, which rules leave a value unchecked, and which class is taken in the
//! end.

use std::f64::consts::TAU;

use proptest::prelude::*;
use proveout_surface::texture::{
    ArealReport, Asked, Form, HeightMap, Profile, ProfileReport, SettingClass, Standard, TextureReport, Unchecked, cusp,
};

/// Height of a row of parabolas of height 1 at `x` for pitch `p`.
fn parabola(x: f64, p: f64) -> f64 {
    let u = x / p - (x / p).round();
    4.0 * u * u
}

fn profile(step: f64, length: f64, height: impl Fn(f64) -> f64) -> Profile {
    let n = (length / step).round() as usize;
    Profile::new(step, (0..=n).map(|i| height(i as f64 * step)).collect()).expect("a profile")
}

fn rules(unchecked: &[Unchecked]) -> Vec<&'static str> {
    unchecked.iter().map(Unchecked::rule).collect()
}

#[test]
fn a_report_names_everything_that_its_values_depend_on() {
    let marks = profile(0.0005, 5.6, |x| 0.001 * parabola(x, 0.25));
    let report = ProfileReport::of(&marks, &Asked { to_lay: Some(90.0), ..Asked::default() });
    let json = serde_json::to_value(TextureReport { area: None, profiles: vec![report.clone()] }).expect("JSON");
    let p = &json["profiles"][0];
    for (key, want) in [
        ("standard", "ISO 21920-2:2021"),
        ("class_standard", "ISO 21920-3:2021, table 1"),
        ("filter_standard", "ISO 16610-21:2011, Gaussian, cut at one cut-off"),
        ("class", "Sc3"),
        ("form_removal", "distance to the design along its normal"),
        ("end_rule", "one cut-off of data beyond each end"),
        ("direction_to_lay", "across the lay"),
    ] {
        assert_eq!(p[key], want, "{key}");
    }
    for (key, want) in [
        ("lambda_s_um", 2.5),
        ("lambda_c_mm", 0.8),
        ("evaluation_length_mm", 4.0),
        ("spacing_um", 0.5),
        ("direction_to_lay_deg", 90.0),
        ("length_mm", 5.6),
    ] {
        assert!((p[key].as_f64().expect(key) - want).abs() < 1e-9, "{key}: {}", p[key]);
    }
    assert!(report.unchecked.is_empty() && report.remarks.is_empty(), "{report}");
    let (filtered, unfiltered) = (report.filtered.expect("evaluated"), report.unfiltered);
    assert!((unfiltered.ra_um - cusp::parabola_ra(1.0)).abs() < 1e-4, "{unfiltered:?}");
    assert!(filtered.ra_um < unfiltered.ra_um && filtered.ra_um > 0.9 * unfiltered.ra_um);
    assert!((report.pitch_mm.expect("a pitch") - 0.25).abs() < 1e-3);
    assert_eq!(report.roughness.len(), 8001);
    let text = report.to_string();
    for word in
        ["ISO 21920-2:2021", "Sc3", "0.8 mm", "4 mm", "across the lay", "0.5000 µm", "one cut-off of data", "Ra"]
    {
        assert!(text.contains(word), "{word}:\n{text}");
    }
}

#[test]
fn the_older_standard_is_named_and_averages_over_sampling_lengths() {
    // Marks whose height grows from section to section: whole-length and mean skewness differ.
    let marks = profile(0.0005, 5.6, |x| 0.0005 * (1.0 + x) * parabola(x, 0.2));
    let new = ProfileReport::of(&marks, &Asked::default());
    let old = ProfileReport::of(&marks, &Asked { standard: Standard::Iso4287, ..Asked::default() });
    assert_eq!((new.standard, old.standard), ("ISO 21920-2:2021", "ISO 4287:1997+A1:2009"));
    assert!(old.class_standard.starts_with("ISO 4288:1996") && old.tolerance_rule.starts_with("16 %"));
    let (new, old) = (new.filtered.expect("evaluated"), old.filtered.expect("evaluated"));
    assert!(old.rq_um < 0.99 * new.rq_um, "{} {}", old.rq_um, new.rq_um);
    assert!(old.rku < 0.9 * new.rku, "{} {}", old.rku, new.rku);
    assert!((old.rz_um - new.rz_um).abs() < 1e-12 && (old.ra_um - new.ra_um).abs() < 1e-3 * new.ra_um);
}

#[test]
fn a_pitch_beyond_the_cutoff_goes_to_the_next_class_or_stays_unchecked() {
    let asked = Asked::default();
    // Room for Sc4: 12.5 mm and two cut-offs of 2.5 mm.
    let long = ProfileReport::of(&profile(0.0005, 17.5, |x| 0.001 * parabola(x, 1.0)), &asked);
    assert_eq!((long.class, long.class_asked, long.lambda_c_mm), ("Sc4", "Sc3", 2.5));
    assert!(long.unchecked.is_empty() && long.remarks[0].contains("beyond lambda_c = 0.8 mm of class Sc3"), "{long}");
    assert!((long.pitch_mm.expect("a pitch") - 1.0).abs() < 0.01, "{:?}", long.pitch_mm);
    let short = ProfileReport::of(&profile(0.0005, 5.6, |x| 0.001 * parabola(x, 1.0)), &asked);
    assert_eq!(short.filtered, None);
    assert_eq!(rules(&short.unchecked), ["pitch-beyond-cutoff", "too-short"]);
    assert_eq!(short.class, "Sc3");
    assert!(
        short.unchecked[1].to_string().ends_with("give a longer profile"),
        "a smaller class is no way out: {short}"
    );
    assert!(short.unfiltered.ra_um > 0.2, "unfiltered values are there all the same");
    assert!(short.roughness.is_empty());
    // The program's step is known where the profile is too short to show it.
    let known = Asked { pitch: Some(1.0), ..asked };
    let flat = ProfileReport::of(&profile(0.0005, 5.6, |_| 0.0), &known);
    assert_eq!(rules(&flat.unchecked), ["pitch-beyond-cutoff", "too-short"]);
    // Beyond all classes.
    let far = ProfileReport::of(
        &profile(0.005, 60.0, |x| 0.001 * parabola(x, 20.0)),
        &Asked { class: SettingClass::Sc5, ..asked },
    );
    assert_eq!(rules(&far.unchecked), ["pitch-beyond-cutoff"], "{far}");
    assert!(far.to_string().contains("no class goes farther"), "{far}");
    // At the cut-off itself the class stays.
    let at =
        ProfileReport::of(&profile(0.0005, 5.6, |x| 0.001 * parabola(x, 0.8)), &Asked { pitch: Some(0.8), ..asked });
    assert_eq!((at.class, at.unchecked.len()), ("Sc3", 0), "{at}");
}

#[test]
fn a_long_wave_under_fine_marks_is_waviness() {
    let wavy = profile(0.0005, 5.6, |x| 0.001 * parabola(x, 0.1) + 0.002 * (TAU * x / 3.0).sin());
    let report = ProfileReport::of(&wavy, &Asked::default());
    assert_eq!((report.class, report.unchecked.len()), ("Sc3", 0), "{report}");
    assert!((report.filtered.expect("evaluated").rsm_mm.expect("elements") - 0.1).abs() < 2e-3, "{report}");
    assert!(report.remarks.iter().any(|r| r.contains("waviness")), "{report}");
}

#[test]
fn spacing_and_length_are_held_to_the_class() {
    let asked = Asked::default();
    let coarse = ProfileReport::of(&profile(0.005, 5.6, |x| parabola(x, 0.25)), &asked);
    assert_eq!(rules(&coarse.unchecked), ["spacing-too-coarse"]);
    assert!(coarse.to_string().contains("points every 5.0000 µm cannot carry class Sc3, which needs 0.5 µm or less"));
    let fine = ProfileReport::of(&profile(0.000_01, 0.1, |x| x), &asked);
    assert_eq!(rules(&fine.unchecked), ["spacing-too-fine"]);
    let short = ProfileReport::of(&profile(0.0005, 3.0, |x| 0.001 * parabola(x, 0.25)), &asked);
    assert_eq!(rules(&short.unchecked), ["too-short"]);
    assert!(short.unchecked[0].to_string().ends_with("or ask for class Sc2"), "{}", short.unchecked[0]);
    // The evaluation length alone: the ends are regressed, and said to be.
    let bare = ProfileReport::of(&profile(0.0005, 4.0, |x| 0.001 * parabola(x, 0.25)), &asked);
    assert_eq!(bare.end_rule, "ISO 16610-28:2016, regression of order zero");
    let whole = ProfileReport::of(&profile(0.0005, 5.6, |x| 0.001 * parabola(x, 0.25)), &asked);
    let (a, b) = (bare.filtered.expect("evaluated"), whole.filtered.expect("evaluated"));
    assert!((a.ra_um - b.ra_um).abs() < 0.02 * b.ra_um, "{} {}", a.ra_um, b.ra_um);
    // Two points are answered, too.
    let two = ProfileReport::of(
        &Profile::new(0.0005, vec![0.0, 1.0]).expect("a profile"),
        &Asked { form: Form::Level, ..asked },
    );
    assert_eq!(rules(&two.unchecked), ["too-short"]);
    assert!(two.unfiltered.rt_um < 1e-9);
}

#[test]
fn a_tilt_is_taken_off_where_it_is_asked_for() {
    let tilted = profile(0.0005, 5.6, |x| 0.001 * parabola(x, 0.25) + 0.3 * x + 7.0);
    let level = ProfileReport::of(&tilted, &Asked { form: Form::Level, ..Asked::default() });
    let plain = ProfileReport::of(&profile(0.0005, 5.6, |x| 0.001 * parabola(x, 0.25)), &Asked::default());
    assert_eq!(level.form_removal, "least-squares line removed");
    let (a, b) = (level.filtered.expect("evaluated"), plain.filtered.expect("evaluated"));
    assert!((a.ra_um - b.ra_um).abs() < 1e-6 * b.ra_um, "{} {}", a.ra_um, b.ra_um);
    let raw = ProfileReport::of(&tilted, &Asked { form: Form::None, ..Asked::default() });
    assert_eq!(raw.form_removal, "not removed");
    assert!(raw.unfiltered.rt_um > 1000.0);
}

fn map(n: usize, step: f64, height: impl Fn(f64, f64) -> f64) -> HeightMap {
    HeightMap::new(n, n, step, step, (0..n * n).map(|k| height((k % n) as f64 * step, (k / n) as f64 * step)).collect())
        .expect("a map")
}

#[test]
fn a_map_has_its_lay_its_filter_and_its_rules() {
    let asked = Asked { form: Form::Level, ..Asked::default() };
    // Marks along y, every 0.4 mm, on a tilt.
    let marks = map(401, 0.01, |x, y| 0.001 * parabola(x, 0.4) + 0.02 * x - 0.01 * y);
    let report = ArealReport::of(&marks, &asked);
    assert!(report.unchecked.is_empty(), "{report}");
    assert_eq!((report.standard, report.l_filter_mm, report.s_filter_um), ("ISO 25178-2:2021", 0.8, None));
    assert_eq!(report.end_rule, "ISO 16610-28:2016, regression of order zero");
    assert!(report.s_filter.starts_with("left out"));
    assert!((report.lay_deg.expect("a lay") - 90.0).abs() < 1.01, "{report}");
    assert!((report.pitch_mm.expect("a pitch") - 0.4).abs() < 0.01, "{report}");
    assert!((report.unfiltered.sa_um - cusp::parabola_ra(1.0)).abs() < 0.003, "{report}");
    assert!(report.filtered.expect("evaluated").sa_um < report.unfiltered.sa_um);
    assert!(report.remarks[0].contains("carry no profile parameters of class Sc3"), "{report}");
    // Marks beyond the cut-off: Sc4 fits into 4 mm, Sc5 does not.
    let wide = ArealReport::of(&map(401, 0.01, |x, _| 0.001 * parabola(x, 1.0)), &asked);
    assert_eq!((wide.class, wide.l_filter_mm), ("Sc4", 2.5), "{wide}");
    let wider = ArealReport::of(&map(401, 0.01, |x, _| 0.001 * parabola(x, 0.4)), &Asked { pitch: Some(3.0), ..asked });
    assert_eq!(rules(&wider.unchecked), ["pitch-beyond-cutoff", "cutoff-beyond-patch"], "{wider}");
    assert_eq!(wider.filtered, None);
    // One ridge and a half: no whole element, and no silent number.
    let one = ArealReport::of(&map(401, 0.01, |x, _| 0.001 * parabola(x + 1.2, 3.2)), &asked);
    assert_eq!(rules(&one.unchecked)[0], "pitch-beyond-cutoff", "{one}");
    let small = ArealReport::of(&map(41, 0.01, |x, _| 0.001 * parabola(x, 0.1)), &asked);
    assert_eq!(rules(&small.unchecked), ["cutoff-beyond-patch"]);
    let coarse = ArealReport::of(&map(41, 0.2, |x, _| 0.001 * parabola(x, 0.7)), &asked);
    assert_eq!(rules(&coarse.unchecked), ["spacing-too-coarse"]);
    // Fine enough for the S-filter.
    let fine = ArealReport::of(
        &map(201, 0.0005, |x, _| 0.0001 * parabola(x, 0.02)),
        &Asked { class: SettingClass::Sc1, ..asked },
    );
    assert_eq!(fine.s_filter_um, Some(2.5), "{fine}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Corners: two points, flats, single spikes, steps from the finest to far beyond the class, pitches that
    /// are no numbers, heights of a kilometer.
    #[test]
    fn any_profile_and_any_map_have_a_report(
        heights in prop::collection::vec(prop::sample::select(vec![0.0, 1e-9, -1e-3, 0.002, 0.5, 1e6, -1e6]), 4..400),
        step in prop::sample::select(vec![1e-7, 2.5e-5, 0.0005, 0.0015, 0.01, 0.1, 1e6]),
        class in prop::sample::select(SettingClass::ALL.to_vec()),
        old in any::<bool>(),
        pitch in prop::sample::select(vec![None, Some(f64::NAN), Some(-1.0), Some(0.0), Some(0.3), Some(5.0), Some(1e9)]),
    ) {
        let asked = Asked {
            standard: if old { Standard::Iso4287 } else { Standard::Iso21920 },
            class,
            form: if old { Form::Level } else { Form::None },
            to_lay: pitch,
            pitch,
        };
        let report = ProfileReport::of(&Profile::new(step, heights.clone()).expect("a profile"), &asked);
        prop_assert_eq!(report.filtered.is_none(), !report.unchecked.is_empty(), "{}", report);
        prop_assert!(report.unfiltered.ra_um.is_finite() && report.unfiltered.rz_um.is_finite());
        let rows = 2 + heights.len() % 5;
        let columns = heights.len() / rows;
        if columns >= 2 {
            let map = HeightMap::new(columns, rows, step, step, heights[..columns * rows].to_vec()).expect("a map");
            let report = ArealReport::of(&map, &asked);
            prop_assert_eq!(report.filtered.is_none(), !report.unchecked.is_empty(), "{}", report);
            prop_assert!(report.unfiltered.sa_um.is_finite());
        }
    }
}
