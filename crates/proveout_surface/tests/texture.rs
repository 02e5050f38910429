//! Parameters and filters of texture against closed forms (values computed with forty digits) and laws.

use std::f64::consts::{PI, TAU};

use proveout_surface::texture::{
    Autocorrelation, HeightMap, Profile, ProfileParameters, SettingClass, Standard, TextureError, cusp, gaussian_mean,
    gaussian_mean_of_map, lay,
};

fn close(got: f64, want: f64, relative: f64, what: &str) {
    assert!((got - want).abs() <= relative * want.abs(), "{what}: {got} instead of {want}");
}

/// Height of a row of parabolas of height 1 at `x` for pitch `p`.
fn parabola(x: f64, p: f64) -> f64 {
    let u = x / p - (x / p).round();
    4.0 * u * u
}

#[test]
fn rows_of_arcs_have_their_closed_forms() {
    // R, pitch, height, Ra, Rq; mm and um.
    let rows = [
        (8.0, 0.5, 3.907_204_140_262_105, 1.002_540_063_298_067, 1.164_862_551_836_993),
        (8.0, 0.8, 10.006_257_824_728_434, 2.567_285_466_340_19, 2.983_022_865_500_227),
        (3.0, 0.3, 3.752_346_684_273_163, 0.962_732_049_877_571, 1.118_633_574_562_585),
        (6.0, 0.5, 5.210_595_859_100_573, 1.336_923_323_407_486, 1.553_403_100_084_647),
        (4.0, 0.6, 11.265_864_964_173_875, 2.890_006_182_07, 3.358_154_578_890_512_5),
    ];
    for (radius, pitch, height, ra, rq) in rows {
        close(cusp::arc_height(radius, pitch).expect("arcs meet") * 1e3, height, 1e-12, "height");
        let (got_ra, got_rq) = cusp::arc_ra_rq(radius, pitch).expect("arcs meet");
        close(got_ra * 1e3, ra, 1e-11, "Ra");
        close(got_rq * 1e3, rq, 1e-11, "Rq");
    }
    assert_eq!(cusp::arc_height(1.0, 2.5), None, "arcs that do not meet");
    close(cusp::parabola_ra(1.0), 0.256_600_119_639_833_67, 1e-12, "Ra");
    close(cusp::parabola_rq(1.0), 0.298_142_396_999_971_96, 1e-12, "Rq");
    close(cusp::parabola_developed_ratio(0.0039, 0.5) * 100.0, 0.016_221_631_859_613_6, 1e-12, "Sdr");
    close(cusp::parabola_developed_ratio(0.02, 0.1) * 100.0, 9.823_008_377_166_67, 1e-12, "Sdr");
}

#[test]
fn a_profile_of_parabolas_has_its_parameters() {
    // Five sections of 40 periods; the polygon of 800 points a period leaves out some 10 / 800^2 of each
    // moment.
    let (pitch, points) = (0.02, 800);
    let step = pitch / f64::from(points);
    let n = 200 * points;
    let z: Vec<f64> = (0..=n).map(|i| parabola(f64::from(i) * step, pitch) - 1.0 / 3.0).collect();
    for standard in [Standard::Iso21920, Standard::Iso4287] {
        let p = ProfileParameters::of(&z, step, standard);
        close(p.ra, 0.256_600_119_639_833_67, 3e-6, "Ra");
        close(p.rq, 0.298_142_396_999_971_96, 3e-6, "Rq");
        close(p.rsk, 0.638_876_564_999_939_9, 3e-5, "Rsk");
        close(p.rku, 15.0 / 7.0, 1e-5, "Rku");
        close(p.rz, 1.0, 1e-12, "Rz");
        close(p.rt, 1.0, 1e-12, "Rt");
        close(p.rp, 2.0 / 3.0, 1e-12, "Rp");
        close(p.rsm.expect("elements"), pitch, 1e-9, "RSm");
    }
}

#[test]
fn the_gaussian_filter_passes_what_its_equation_says() {
    // 1 - exp(-pi (alpha lambda_c / lambda)^2) of a wave is taken off; at the cut-off one half.
    for (lambda, want) in [(0.4, 0.9375), (0.8, 0.5), (1.6, 0.159_103_584_746_285)] {
        let step = 0.001;
        let z: Vec<f64> = (0..=20_000).map(|i| (TAU * f64::from(i) * step / lambda).sin()).collect();
        let mean = gaussian_mean(&z, step, 0.8);
        // Amplitude from the middle, where no end is near, over whole waves.
        let middle = 4_000..16_000;
        let count = middle.len() as f64;
        let part: f64 = middle.map(|i| 2.0 * (z[i] - mean[i]) * z[i]).sum::<f64>() / count;
        assert!((part - want).abs() < 1e-6, "wave of {lambda} mm: {part} instead of {want}");
    }
}

#[test]
fn parabolas_through_the_filter_keep_the_share_of_the_closed_form() {
    let want = [
        (0.3, 0.296_150_399_772_567),
        (0.5, 0.251_770_349_414_561),
        (0.6, 0.218_855_034_015_719),
        (0.8, 0.163_301_731_909_998),
        (1.0, 0.125_191_401_986_336),
        (2.5, 0.036_240_571_339_533_8),
    ];
    for (pitch, share) in want {
        // Ten periods and two cut-offs on either side, points so that periods are whole.
        let points = 3000;
        let step = pitch / f64::from(points);
        let ends = (1.7 / step).ceil() as i32;
        let n = 10 * points;
        let z: Vec<f64> = (-ends..=n + ends).map(|i| parabola(f64::from(i) * step, pitch)).collect();
        let mean = gaussian_mean(&z, step, 0.8);
        let square: f64 =
            (ends..ends + n).map(|i| (z[i as usize] - mean[i as usize]).powi(2)).sum::<f64>() / f64::from(n);
        assert!((square.sqrt() - share).abs() < 2e-6, "pitch {pitch}: {} instead of {share}", square.sqrt());
    }
}

#[test]
fn a_plane_passes_the_filter_unchanged_and_constants_to_the_ends() {
    let map = HeightMap::new(
        120,
        90,
        0.02,
        0.03,
        (0..120 * 90).map(|k| f64::from(k % 120) * 0.1 + f64::from(k / 120) * 0.2).collect(),
    )
    .expect("a map");
    let mean = gaussian_mean_of_map(&map, 0.4);
    for j in 14..76 {
        for i in 21..99 {
            assert!((mean.at(i, j) - map.at(i, j)).abs() < 1e-12, "({i}, {j})");
        }
    }
    let flat = gaussian_mean(&[2.5; 50], 0.1, 0.8);
    assert!(flat.iter().all(|z| (z - 2.5).abs() < 1e-12));
}

#[test]
fn two_crossed_rows_have_the_moments_of_their_sum() {
    let (h1, h2) = (3.906_25e-3, 0.156_25e-3);
    let n = 1200;
    let heights = (0..n * n)
        .map(|k| {
            let (x, y) = (f64::from(k % n), f64::from(k / n));
            h1 * parabola(x + 0.5, 400.0) + h2 * parabola(y + 0.5, 200.0)
        })
        .collect();
    let p = HeightMap::new(n as usize, n as usize, 0.001, 0.001, heights).expect("a map").parameters();
    // Means over midpoints miss the integrals by 1 / (24 N^2) of the curvature.
    close(p.sq * 1e3, 1.165_550_060_891_61, 2e-5, "Sq");
    close(p.ssk, 0.637_387_112_302_021, 1e-4, "Ssk");
    close(p.sku, 2.145_591_243_877_44, 1e-4, "Sku");
}

#[test]
fn the_developed_ratio_of_a_row_is_that_of_its_closed_form() {
    for (h, pitch) in [(0.0039, 0.5), (0.02, 0.1)] {
        let n = 4001;
        let step = pitch / 1000.0;
        let heights = (0..n * 3).map(|k| h * parabola(f64::from(k % n) * step, pitch)).collect();
        let p = HeightMap::new(n as usize, 3, step, step, heights).expect("a map").parameters();
        close(p.sdr, cusp::parabola_developed_ratio(h, pitch), 1e-5, "Sdr");
    }
}

#[test]
fn spacing_is_the_same_backwards() {
    // Waves of changing length with small ones on them, and noise by a fixed rule.
    let mut seed = 7_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    for case in 0..20 {
        let z: Vec<f64> = (0..4001)
            .map(|i| {
                let x = f64::from(i) * 0.001;
                (TAU * x / (0.2 + 0.02 * x)).sin() + 0.2 * (TAU * x / 0.031).sin() + 0.1 * f64::from(case) * noise()
            })
            .collect();
        let back: Vec<f64> = z.iter().rev().copied().collect();
        let a = ProfileParameters::of(&z, 0.001, Standard::Iso21920).rsm.expect("elements");
        let b = ProfileParameters::of(&back, 0.001, Standard::Iso21920).rsm.expect("elements");
        assert!((a - b).abs() < 1e-12, "case {case}: {a} and {b}");
    }
}

#[test]
fn an_evaluation_takes_the_middle_and_says_what_it_needs() {
    let class = SettingClass::Sc3;
    let step = class.max_spacing();
    let n = (Profile::length_for(class) / step).round() as usize;
    let z: Vec<f64> = (0..=n).map(|i| 0.001 * parabola(i as f64 * step, 0.25)).collect();
    let profile = Profile::new(step, z.clone()).expect("a profile");
    let found = profile.evaluate(class, Standard::Iso21920).expect("long enough");
    assert_eq!(found.profile.len(), 8001);
    assert_eq!(found.setting.standard, "ISO 21920-2:2021");
    close(found.unfiltered.ra, 0.001 * cusp::parabola_ra(1.0), 1e-4, "unfiltered Ra");
    assert!(found.filtered.ra < found.unfiltered.ra && found.filtered.ra > 0.9 * found.unfiltered.ra);
    close(found.filtered.rsm.expect("elements"), 0.25, 2e-3, "RSm");

    let short = Profile::new(step, z[..8100].to_vec()).expect("a profile");
    assert!(matches!(short.evaluate(class, Standard::Iso21920), Err(TextureError::TooShort { .. })));
    let coarse = Profile::new(0.005, z).expect("a profile");
    let error = coarse.evaluate(class, Standard::Iso21920).expect_err("too coarse");
    assert_eq!(error.to_string(), "points every 5.0000 um cannot carry class Sc3, which needs 0.5000 um or less");
    assert_eq!(SettingClass::for_pitch(1.0), Some(SettingClass::Sc4));
    assert_eq!(SettingClass::for_pitch(9.0), None);
}

#[test]
fn holes_and_flats_are_answered() {
    assert!(matches!(
        HeightMap::new(2, 2, 1.0, 1.0, vec![0.0, f64::NAN, 0.0, 0.0]),
        Err(TextureError::Hole { index: 1, .. })
    ));
    assert!(matches!(HeightMap::new(1, 4, 1.0, 1.0, vec![0.0; 4]), Err(TextureError::Lattice { .. })));
    assert!(matches!(HeightMap::new(2, 2, 0.0, 1.0, vec![0.0; 4]), Err(TextureError::Step(_))));
    let flat = HeightMap::new(30, 30, 0.1, 0.1, vec![0.25; 900]).expect("a map");
    let p = flat.parameters();
    assert_eq!((p.sa, p.sq, p.sz, p.ssk, p.sku, p.sdr), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
    assert_eq!(Autocorrelation::of(&flat), Autocorrelation { sal: None, str: None });
    assert_eq!(lay(&flat), None);
    assert_eq!(ProfileParameters::of(&[0.0; 100], 0.1, Standard::Iso21920).rsm, None);
}

#[test]
fn marks_have_their_direction_and_their_length() {
    let n = 256;
    let map = |angle: f64, pitch: f64| {
        let (sin, cos) = angle.sin_cos();
        let heights = (0..n * n)
            .map(|k| {
                let (x, y) = (f64::from(k % n) * 0.01, f64::from(k / n) * 0.01);
                // Marks run along the angle: heights change across it.
                (TAU * (y * cos - x * sin) / pitch).cos()
            })
            .collect();
        HeightMap::new(n as usize, n as usize, 0.01, 0.01, heights).expect("a map")
    };
    for degrees in [0.0, 17.0, 45.0, 90.0, 133.5] {
        let got = lay(&map(f64::to_radians(degrees), 0.2)).expect("a direction");
        let off = (got - f64::to_radians(degrees) + PI / 2.0).rem_euclid(PI) - PI / 2.0;
        assert!(off.abs() < f64::to_radians(1.01), "{degrees}: {}", got.to_degrees());
    }
    let found = Autocorrelation::of(&map(0.0, 0.2));
    // A cosine falls to 0.2 after acos(0.2) / (2 pi) of its length.
    close(found.sal.expect("decays across"), 0.2 * 0.2_f64.acos() / TAU, 0.02, "Sal");
    assert_eq!(found.str, None, "marks do not end in the map");
}
