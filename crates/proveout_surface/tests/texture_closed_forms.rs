//! Every value of `reference/roughness_closed_forms.csv` (computed with forty digits): closed forms to 1e-9,
//! what the filter and the sums of the library make of sampled profiles and maps to 1e-6.

use std::f64::consts::TAU;

use proveout_surface::texture::{HeightMap, ProfileParameters, Standard, cusp, gaussian_mean};

struct Row {
    case: &'static str,
    radius: f64,
    pitch: f64,
    cutoff: f64,
    quantity: &'static str,
    value: f64,
}

fn rows() -> Vec<Row> {
    let number = |text: &str| text.parse().unwrap_or(f64::NAN);
    include_str!("reference/roughness_closed_forms.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<&'static str> = line.split(',').collect();
            let [case, radius, pitch, cutoff, quantity, value] = fields[..] else { panic!("{line}") };
            let row = Row {
                case,
                radius: number(radius),
                pitch: number(pitch),
                cutoff: number(cutoff),
                quantity,
                value: number(value),
            };
            assert!(row.value.is_finite(), "{line}");
            row
        })
        .collect()
}

/// Height of a row of parabolas of height 1 at `x` for pitch `p`.
fn parabola(x: f64, p: f64) -> f64 {
    let u = x / p - (x / p).round();
    4.0 * u * u
}

/// The closed form of a row.
fn closed(row: &Row) -> f64 {
    let arcs = || cusp::arc_ra_rq(row.radius, row.pitch).expect("arcs meet");
    let height = || cusp::arc_height(row.radius, row.pitch).expect("arcs meet");
    match (row.case, row.quantity) {
        ("arc_cusp", "height_um") => 1e3 * height(),
        ("arc_cusp", "Ra_um") => 1e3 * arcs().0,
        ("arc_cusp", "Rq_um") => 1e3 * arcs().1,
        ("arc_cusp", "Ra_over_height") => arcs().0 / height(),
        ("arc_cusp", "Rq_over_height") => arcs().1 / height(),
        ("parabola", "Ra_over_h") => cusp::parabola_ra(1.0),
        ("parabola", "Rq_over_h") => cusp::parabola_rq(1.0),
        ("parabola", "Rsk") => cusp::PARABOLA_RSK,
        ("parabola", "Rku") => cusp::PARABOLA_RKU,
        ("parabola_gauss_highpass", _) => cusp::parabola_rq_high_pass(1.0, row.pitch, row.cutoff),
        ("sine_gauss_highpass", _) => cusp::high_pass_share(row.pitch, row.cutoff),
        ("parabola_train_Sdr", q) => {
            let h = q.split('=').nth(1).and_then(|h| h.parse().ok()).expect("a height");
            100.0 * cusp::parabola_developed_ratio(h, row.pitch)
        }
        (_, quantity) => {
            let (sq, ssk, sku) = cusp::crossed(3.906_25, 0.156_25).expect("ridges");
            match quantity {
                "Sq_um" => sq,
                "Ssk" => ssk,
                "Sku" => sku,
                other => panic!("no closed form of {other}"),
            }
        }
    }
}

#[test]
fn closed_forms_have_nine_digits() {
    let rows = rows();
    assert_eq!(rows.len(), 43);
    for row in &rows {
        let got = closed(row);
        assert!(
            (got - row.value).abs() <= 1e-9 * row.value.abs(),
            "{} {}: {got} instead of {}",
            row.case,
            row.quantity,
            row.value
        );
    }
    assert_eq!(cusp::crossed(0.0, 0.0), None);
}

#[test]
fn sampled_profiles_have_six() {
    for row in rows() {
        let got = match (row.case, row.quantity) {
            // A mean of squares over whole periods of nodes misses the integral of a kinked profile by the
            // square of the step: a finer and a coarser step show how much (Richardson).
            ("parabola_gauss_highpass", _) => {
                let at = |points: i32| {
                    let step = row.pitch / f64::from(points);
                    let ends = (1.01 * row.cutoff / step).ceil() as i32;
                    let z: Vec<f64> =
                        (-ends..=points + ends).map(|i| parabola(f64::from(i) * step, row.pitch)).collect();
                    let mean = gaussian_mean(&z, step, row.cutoff);
                    let square = |i: i32| (z[(i + ends) as usize] - mean[(i + ends) as usize]).powi(2);
                    ((0..points).map(square).sum::<f64>() / f64::from(points)).sqrt()
                };
                let (fine, coarse) = (at(3000), at(1500));
                assert!((fine - row.value).abs() < 2e-6, "{}: {fine}", row.pitch);
                fine + (fine - coarse) / 3.0
            }
            ("sine_gauss_highpass", _) => {
                let step = row.cutoff / 800.0;
                let count = (row.pitch / step).round() as i32;
                let ends = 801;
                let wave = |i: i32| (TAU * f64::from(i) / f64::from(count)).sin();
                let z: Vec<f64> = (-ends..=count + ends).map(wave).collect();
                let mean = gaussian_mean(&z, step, row.cutoff);
                let part = |i: i32| 2.0 * (z[(i + ends) as usize] - mean[(i + ends) as usize]) * wave(i);
                (0..count).map(part).sum::<f64>() / f64::from(count)
            }
            ("arc_cusp", "Ra_over_height" | "Rq_over_height") => {
                // Five sections of two periods each, as polygon.
                let points = 4000;
                let z: Vec<f64> = (0..=10 * points)
                    .map(|i| {
                        let x = (f64::from(i % points) / f64::from(points) - 0.5) * row.pitch;
                        x * x / (row.radius + (row.radius * row.radius - x * x).sqrt())
                    })
                    .collect();
                let height = cusp::arc_height(row.radius, row.pitch).expect("arcs meet");
                let mean = z.windows(2).map(|w| 0.5 * (w[0] + w[1])).sum::<f64>() / f64::from(10 * points);
                let centered: Vec<f64> = z.iter().map(|z| z - mean).collect();
                let p = ProfileParameters::of(&centered, row.pitch / f64::from(points), Standard::Iso21920);
                if row.quantity.starts_with("Ra") { p.ra / height } else { p.rq / height }
            }
            _ => continue,
        };
        assert!((got - row.value).abs() < 1e-6, "{} {}: {got} instead of {}", row.case, row.pitch, row.value);
    }
}

#[test]
fn a_sampled_map_of_two_rows_has_their_moments() {
    // Nodes at the middles of cells; the means miss the integrals by the square of the step, which two steps
    // show.
    let at = |n: usize| {
        let heights = (0..n * n)
            .map(|k| {
                let (x, y) = ((k % n) as f64 + 0.5, (k / n) as f64 + 0.5);
                3.906_25e-3 * parabola(x, n as f64 / 3.0) + 0.156_25e-3 * parabola(y, n as f64 / 6.0)
            })
            .collect();
        let p = HeightMap::new(n, n, 0.001, 0.001, heights).expect("a map").parameters();
        [1e3 * p.sq, p.ssk, p.sku]
    };
    let (fine, coarse) = (at(1200), at(600));
    let (sq, ssk, sku) = cusp::crossed(3.906_25, 0.156_25).expect("ridges");
    for (k, want) in [sq, ssk, sku].into_iter().enumerate() {
        let got = fine[k] + (fine[k] - coarse[k]) / 3.0;
        assert!((got - want).abs() < 1e-6 * want, "{k}: {got} instead of {want}");
    }
}
