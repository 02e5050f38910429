//! Forces of slot, half and quarter immersion against closed integrals.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proveout_feeds::{Compliance, ForceModel, SliceCut};
use proveout_tool::ToolLibrary;

use crate::{cut, flat, material};

/// Spindle speed, 1/min, and teeth: 100 teeth a second.
const RPM: f64 = 3000.0;

/// Gamma function by Lanczos (1964), g = 7: good to 1e-13.
fn gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let t = x + 7.5;
    let sum = C[0] + (1..9).map(|k| C[k] / (x + k as f64)).sum::<f64>();
    TAU.sqrt() * t.powf(x + 0.5) * (-t).exp() * sum
}

fn beta(a: f64, b: f64) -> f64 {
    gamma(a) * gamma(b) / gamma(a + b)
}

#[test]
fn the_mean_torque_of_slot_and_half_immersion_is_the_closed_integral() {
    // Mean over a revolution of N teeth: N / 2 pi * integral of kc1.1 (f sin p)^(1 - m) b r dp. Over 0 to pi
    // the integral of sin^(1 - m) is the Beta function of (2 - m) / 2 and 1 / 2; half of it over a quarter
    // turn.
    for exponent in [0.0, 0.186, 0.25, 0.34] {
        let tool = flat("flutes = 2\n");
        let model =
            ForceModel::new(&tool, material("chip-thickness", 1500.0, exponent, "radial_ratio = 0.3\n"), 1.0, None)
                .unwrap();
        let (feed, depth, radius) = (10.0_f64, 3.0, 5.0);
        let chip: f64 = feed / 100.0;
        let whole = beta((2.0 - exponent) / 2.0, 0.5);
        let force = 1500.0 * chip.powf(1.0 - exponent) * depth;
        for (range, part) in [([0.0, 180.0], 1.0), ([0.0, 90.0], 0.5), ([90.0, 180.0], 0.5)] {
            let loads = model.loads(&[cut(depth, range, feed)], RPM).unwrap().at(1.0);
            let want = 2.0 / TAU * force * radius * part * whole * 1e-3;
            // The integrand is no polynomial where it leaves zero: 32 nodes reach some 1e-4 there.
            assert!(
                (loads.torque_mean_nm / want - 1.0).abs() < 3e-4,
                "{exponent} {range:?}: {} {want}",
                loads.torque_mean_nm
            );
            assert!((loads.chip_mm - chip).abs() < 1e-12);
            let power = want * RPM * TAU / 60.0 * 1e-3;
            assert!((loads.power_kw / power - 1.0).abs() < 3e-4);
        }
    }
}

#[test]
fn mean_forces_against_the_feed_and_to_the_side_are_the_closed_integrals() {
    // With m = 0: F_x = -(N b kc f / 2 pi) integral (sin cos + r sin^2) dp, F_y = (...) integral (sin^2 - r
    // sin cos) dp.
    let ratio = 0.4;
    let tool = flat("flutes = 3\n");
    let more = format!("radial_ratio = {ratio}\n");
    let model = ForceModel::new(&tool, material("chip-thickness", 2000.0, 0.0, &more), 1.0, None).unwrap();
    let (feed, depth) = (15.0, 2.0);
    let chip = feed / 150.0;
    let scale = 3.0 / TAU * 2000.0 * depth * chip;
    // A quarter of the diameter: 0 to acos(1 - 2 / 4).
    for [a, b] in [[0.0, PI], [0.0, FRAC_PI_2], [FRAC_PI_2, PI], [0.0, (0.5_f64).acos()], [1.0, 2.5]] {
        let squares = 0.5 * (b - a) - 0.25 * ((2.0 * b).sin() - (2.0 * a).sin());
        let products = 0.5 * (b.sin().powi(2) - a.sin().powi(2));
        let want = [-scale * (products + ratio * squares), scale * (squares - ratio * products)];
        let range = [a, b].map(f64::to_degrees);
        let have = model.loads(&[cut(depth, range, feed)], RPM).unwrap().mean_force(1.0);
        for k in 0..2 {
            assert!((have[k] - want[k]).abs() < 1e-6 * scale, "{range:?} {have:?} {want:?}");
        }
    }
}

#[test]
fn the_chip_is_thickest_where_the_sine_is_largest() {
    let tool = flat("flutes = 2\n");
    let model = ForceModel::of_chips(&tool).unwrap();
    let chip = |range: [f64; 2]| model.loads(&[cut(1.0, range, 10.0)], RPM).unwrap().at(1.0).chip_mm;
    assert!((chip([0.0, 180.0]) - 0.1).abs() < 1e-12);
    assert!((chip([0.0, 60.0]) - 0.1 * (60.0_f64).to_radians().sin()).abs() < 1e-12);
    assert!((chip([150.0, 180.0]) - 0.05).abs() < 1e-12);
    assert_eq!(model.loads(&[cut(1.0, [0.0, 180.0], 10.0)], 0.0).map(|c| c.at(1.0)), None);
}

#[test]
fn run_out_of_a_tooth_thickens_its_chip() {
    let tool = flat("flutes = 2\nedges = { radial_run_out_mm = [0.02, 0.0] }\n");
    let model = ForceModel::of_chips(&tool).unwrap();
    let cut = model.loads(&[cut(1.0, [0.0, 180.0], 10.0)], RPM).unwrap();
    assert!((cut.at(1.0).chip_mm - 0.12).abs() < 1e-12);
    assert!((cut.at(2.0).chip_mm - 0.22).abs() < 1e-12);
}

#[test]
fn a_published_milling_power_is_found() {
    // Mitsubishi Materials, milling power: ap 2 mm, ae 80 mm, vf 280 mm/min, Kc 1800 N/mm2, efficiency 0.8:
    // 1.68 kW.
    let text = "[[tool]]\nnumber = 1\nname = \"M\"\nkind = \"flat\"\ndiameter_mm = 80\nflute_length_mm = 10\ngauge_length_mm = 60\nflutes = 5\n";
    let tool = ToolLibrary::from_text("t.toml".as_ref(), text).unwrap().tools.remove(0);
    for convention in ["feed-per-tooth", "chip-thickness"] {
        let model =
            ForceModel::new(&tool, material(convention, 1800.0, 0.0, "radial_ratio = 0.3\n"), 0.8, None).unwrap();
        let slot = cut(2.0, [0.0, 180.0], 280.0 / 60.0);
        for rpm in [200.0, 500.0] {
            let power = model.loads(&[slot], rpm).unwrap().at(1.0).power_kw;
            assert!((power - 1.68).abs() < 1e-6, "{power}");
        }
    }
}

#[test]
fn a_table_by_feed_per_tooth_gives_its_own_specific_force() {
    // Power = kc(fz) ap ae vf: the thickness of the table is the feed per tooth at every angle.
    let tool = flat("flutes = 2\n");
    let m = material("feed-per-tooth", 1442.0, 0.186, "radial_ratio = 0.4\n");
    let model = ForceModel::new(&tool, m.clone(), 1.0, None).unwrap();
    for (range, width) in [([0.0, 180.0], 10.0), ([0.0, 90.0], 5.0), ([0.0, 60.0], 2.5)] {
        let power = model.loads(&[cut(4.0, range, 20.0)], RPM).unwrap().at(1.0).power_kw;
        let want = m.specific_force(0.2) * 4.0 * width * 20.0 * 1e-6;
        assert!((power / want - 1.0).abs() < 1e-6, "{power} {want}");
    }
}

#[test]
fn a_straight_tooth_peaks_at_the_end_of_its_range_and_teeth_add_up() {
    // One tooth at a time, no force across the edge: F(p) = kc f sin(p) b, largest where the sine is.
    let model = |teeth: u32| {
        let tool = flat(&format!("flutes = {teeth}\n"));
        ForceModel::new(&tool, material("chip-thickness", 1000.0, 0.0, "radial_ratio = 0\n"), 1.0, None).unwrap()
    };
    let peak = |teeth: u32, range: [f64; 2]| {
        let feed = 0.1 * RPM / 60.0 * f64::from(teeth);
        model(teeth).loads(&[cut(1.0, range, feed)], RPM).unwrap().at(1.0)
    };
    for (range, want) in [
        ([0.0, 37.3], (37.3_f64).to_radians().sin()),
        ([0.0, 90.0], 1.0),
        ([128.4, 180.0], (128.4_f64).to_radians().sin()),
    ] {
        let loads = peak(2, range);
        assert!((loads.force_peak_n / (100.0 * want) - 1.0).abs() < 1e-6, "{range:?} {}", loads.force_peak_n);
        assert!((loads.torque_peak_nm / (0.5 * want) - 1.0).abs() < 1e-6);
    }
    // Four teeth in a slot: two at once, 90 degrees apart; torque kc f b r (sin p + cos p), at most sqrt 2.
    let loads = peak(4, [0.0, 180.0]);
    assert!((loads.torque_peak_nm / (0.5 * 2.0_f64.sqrt()) - 1.0).abs() < 1e-3, "{}", loads.torque_peak_nm);
}

#[test]
fn a_helix_smooths_the_peak_and_leaves_the_mean() {
    let of = |more: &str| {
        let tool = flat(&format!("flutes = 4\n{more}"));
        let m = material("chip-thickness", 1500.0, 0.2, "radial_ratio = 0.3\nedge_force_n_mm = 10\n");
        let slices: Vec<SliceCut> = (0..20)
            .map(|k| SliceCut { height: [f64::from(k), f64::from(k + 1)], ..cut(1.0, [120.0, 180.0], 20.0) })
            .collect();
        ForceModel::new(&tool, m, 1.0, None).unwrap().loads(&slices, RPM).unwrap().at(1.0)
    };
    let (straight, helix) = (of(""), of("edges = { helix_deg = 30 }\n"));
    assert!((straight.torque_mean_nm / helix.torque_mean_nm - 1.0).abs() < 1e-9);
    assert!(helix.force_peak_n < 0.9 * straight.force_peak_n, "{helix:?} {straight:?}");
}

#[test]
fn a_ball_end_takes_its_slope_into_account_and_a_plunge_cuts_with_the_end() {
    let text = "[[tool]]\nnumber = 1\nname = \"B\"\nkind = \"ball\"\ndiameter_mm = 10\nflute_length_mm = 20\ngauge_length_mm = 60\nflutes = 2\n";
    let ball = ToolLibrary::from_text("t.toml".as_ref(), text).unwrap().tools.remove(0);
    let model = ForceModel::of_chips(&ball).unwrap();
    // At the height z of a ball of radius 5 the slope has the sine sqrt(1 - (1 - z / 5)^2).
    let slices: Vec<SliceCut> = (0..10)
        .map(|k| SliceCut { height: [0.1 * f64::from(k), 0.1 * f64::from(k + 1)], ..cut(1.0, [0.0, 180.0], 10.0) })
        .collect();
    let chip = model.loads(&slices, RPM).unwrap().at(1.0).chip_mm;
    let want = 0.1 * (1.0 - 0.8_f64.powi(2)).sqrt();
    assert!(chip < want && chip > 0.98 * want, "{chip} {want}");
    // Straight down: the end of a flat cutter takes the whole feed, the wall nothing; torque over the end is
    // N / 2 pi * 2 pi * kc f * integral of r dr = kc f N r^2 / 2.
    let m = material("chip-thickness", 1000.0, 0.0, "radial_ratio = 0\n");
    let model = ForceModel::new(&flat("flutes = 2\n"), m, 1.0, None).unwrap();
    let down = SliceCut { height: [0.0, 2.0], range: None, around: true, feed_across: 0.0, feed_down: 5.0 };
    let loads = model.loads(&[down], RPM).unwrap().at(1.0);
    assert!((loads.chip_mm - 0.05).abs() < 1e-12, "{loads:?}");
    assert!((loads.torque_mean_nm / (1000.0 * 0.05 * 2.0 * 12.5 * 1e-3) - 1.0).abs() < 1e-9, "{loads:?}");
}

#[test]
fn a_plain_shank_bends_as_a_cantilever_and_a_stepped_one_as_its_parts() {
    // A plain rod: F L^3 / (3 E I) at the tip; with the force at a: F (L - a)^2 (2 L + a) / (6 E I).
    let tool = flat("flutes = 2\nshank_diameter_mm = 10\noverall_length_mm = 60\n");
    let young = 600e3;
    let (length, inertia) = (60.0_f64, PI * 5.0_f64.powi(4) / 4.0);
    let bend = Compliance::of_tool(&tool, young, 1.0).unwrap();
    let want = length.powi(3) / (3.0 * young * inertia);
    assert!((bend.at_tip(0.0) / want - 1.0).abs() < 1e-9, "{} {want}", bend.at_tip(0.0));
    for a in [5.0, 17.3, 40.0] {
        let want = (length - a).powi(2) * (2.0 * length + a) / (6.0 * young * inertia);
        assert!((bend.at_tip(a) / want - 1.0).abs() < 1e-3, "{a}");
    }
    // Flutes of 30 mm with 0.8 of the diameter: the integral of z^2 / I over both parts.
    let stepped = Compliance::of_tool(&tool, young, 0.8).unwrap();
    let want = (30.0_f64.powi(3) / 0.8_f64.powi(4) + length.powi(3) - 30.0_f64.powi(3)) / (3.0 * young * inertia);
    assert!((stepped.at_tip(0.0) / want - 1.0).abs() < 1e-2, "{} {want}", stepped.at_tip(0.0));
    assert_eq!(Compliance::of_tool(&tool, 0.0, 1.0), None);
}
