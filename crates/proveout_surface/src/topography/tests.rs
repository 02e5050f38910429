//! The published case of plane face milling, from a tool of a library to Sa.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

use proveout_geom::{Point, Vector};
use proveout_tool::ToolLibrary;

use super::{
    CutterPiece, Edge, Lattice, Settings, TeethError, check_chip, check_motion, edges_of, heights_by_edges, phase_zero,
};

/// Two round inserts, D = 10 mm; Duong, Nguyen 2026, case A1: 170 m/min, 0.6 mm a tooth. `hand` is that of
/// the tool.
fn edges(hand: &str) -> Vec<Edge> {
    let text = format!(
        "[[tool]]\nnumber = 1\nname = \"A1\"\nkind = \"bull_nose\"\ndiameter_mm = 20\ncorner_radius_mm = 5\n\
         flute_length_mm = 8\ngauge_length_mm = 60\nflutes = 2\nhand = \"{hand}\"\n[tool.edges]\n\
         radial_run_out_mm = [0, 0.011]\naxial_run_out_mm = [0, 0.003]\nradial_rake_deg = 0.6\n\
         round_insert = {{ nose_circle_diameter_mm = 10, insert_radius_mm = 5 }}\n"
    );
    let library = ToolLibrary::from_text(Path::new("a1.toml"), &text).unwrap_or_else(|e| panic!("{e}"));
    edges_of(&library.tools[0]).unwrap_or_else(|e| panic!("{e}"))
}

/// Heights of the 10 x 5 mm field in steps of 5 mm / n, fed along +y. Counter-clockwise as published with
/// `wind` 1; -1 is its mirror image in x = 5 mm. `speed` and `depth` scale cutting speed and depth of cut,
/// `phase` turns the first insert.
fn face_mill(n: usize, wind: f64, speed: f64, depth: f64, phase: f64) -> Vec<f64> {
    let (d, fz) = (10.0, 0.6);
    let turns = speed * 170_000.0 / 60.0 / (PI * d);
    let feed = fz * 2.0 * turns;
    let duration = (1.5 * d + 5.0) / feed;
    let piece = CutterPiece {
        time: [0.0, duration],
        tip: [Point::new(5.0, -5.0, 0.0), Point::new(5.0, -5.0 + feed * duration, 0.0)],
        housing: [Vector::x(), Vector::y(), Vector::z()],
        turn: Vector::zeros(),
        // At the begin the first insert is on the trailing side of the axis.
        azimuth: -FRAC_PI_2 + wind * phase,
        azimuth_rate: wind * TAU * turns,
        motion: 0,
    };
    let lattice =
        Lattice::plane(Point::origin(), Vector::x(), Vector::y(), [5.0 / n as f64, 5.0 / n as f64], 2 * n + 1, n + 1)
            .expect("a lattice");
    let edges = edges(if wind > 0.0 { "left" } else { "right" });
    let found = heights_by_edges(&lattice, &edges, &[piece], &Settings { max_height: depth });
    assert_eq!(found.uncut(), 0);
    found.heights()
}

fn mean(values: impl Iterator<Item = f64>, count: usize) -> f64 {
    values.sum::<f64>() / count as f64
}

fn sa_um(z: &[f64]) -> f64 {
    let middle = mean(z.iter().copied(), z.len());
    1e3 * mean(z.iter().map(|z| (z - middle).abs()), z.len())
}

#[test]
fn face_mill_with_two_round_inserts_leaves_the_published_surface() {
    let published = [
        (25, 1.48499349337313, 9.05204573513441),
        (50, 1.5998235023622, 9.93395141174691),
        (100, 1.58088191701734, 9.93395141174691),
        (200, 1.57102844765609, 9.94283734974377),
        (400, 1.56919774688229, 9.94283734974377),
        (800, 1.56880679399002, 9.97909928507568),
        (1600, 1.56870793750871, 10.0296070618907),
    ];
    // The finest two have 1.3 and 5.1 million points.
    let all = std::env::var("PROVEOUT_TOPOGRAPHY_CASES").is_ok();
    for (n, sa, sz) in published.into_iter().take(if all { 7 } else { 5 }) {
        let z = face_mill(n, 1.0, 1.0, 0.5, 0.0);
        let found = sa_um(&z);
        assert!((found - sa).abs() < 1e-9, "n {n}: Sa {found} against {sa}");
        let (low, high) = z.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |a, z| (a.0.min(*z), a.1.max(*z)));
        let found = 1e3 * (high - low);
        assert!((found - sz).abs() < 1e-9, "n {n}: Sz {found} against {sz}");
        if n == 100 {
            let middle = mean(z.iter().copied(), z.len());
            let sq = 1e3 * mean(z.iter().map(|z| (z - middle).powi(2)), z.len()).sqrt();
            assert!((sq - 1.843_714_875_967).abs() < 1e-9, "Sq {sq}");
        }
    }
}

#[test]
fn a_mirrored_cutter_leaves_the_mirrored_surface() {
    let n = 40;
    let (left, right) = (face_mill(n, 1.0, 1.0, 0.5, 0.3), face_mill(n, -1.0, 1.0, 0.5, 0.3));
    let columns = 2 * n + 1;
    for (i, z) in left.iter().enumerate() {
        let mirrored = right[i / columns * columns + columns - 1 - i % columns];
        assert!((z - mirrored).abs() < 1e-11, "point {i}: {z} and {mirrored}");
    }
    // The other sense without its mirror changes heights, and Sa hardly.
    let other: Vec<f64> = right;
    let most = left.iter().zip(&other).fold(0.0_f64, |a, (x, y)| a.max((x - y).abs()));
    assert!(most > 1e-5 && (sa_um(&left) - sa_um(&other)).abs() < 5e-3);
}

#[test]
#[expect(clippy::print_stdout, reason = "the spread over phases is what one wants to read")]
fn sa_does_not_hang_on_speed_and_depth_and_hardly_on_phase() {
    let n = 60;
    let sa = sa_um(&face_mill(n, 1.0, 1.0, 0.5, 0.0));
    for (speed, depth) in [(0.1, 0.5), (0.7, 0.3), (1.9, 0.1), (13.0, 2.5), (100.0, 0.05)] {
        let found = sa_um(&face_mill(n, 1.0, speed, depth, 0.0));
        assert!((found - sa).abs() < 1e-9, "speed {speed}, depth {depth} mm: {found} against {sa}");
    }
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    let mut seed = 1_u64;
    for _ in 0..12 {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let found = sa_um(&face_mill(n, 1.0, 1.0, 0.5, TAU * (seed >> 11) as f64 / (1_u64 << 53) as f64));
        (low, high) = (low.min(found), high.max(found));
    }
    println!("Sa over twelve random phases: {low:.4} to {high:.4} um");
    assert!(high - low > 1e-6 && (high - low) < 0.1 * sa, "{low} to {high}");
}

fn tool(kind: &str, more: &str) -> Result<proveout_tool::Tool, String> {
    let text = format!(
        "[[tool]]\nnumber = 1\nname = \"T\"\n{kind}\nflute_length_mm = 30\ngauge_length_mm = 60\nflutes = 3\n{more}\n"
    );
    let library = ToolLibrary::from_text(Path::new("t.toml"), &text).map_err(|e| e.to_string())?;
    Ok(library.tools[0].clone())
}

#[test]
fn edges_are_those_of_the_definition() {
    let (dr, da) = ([0.01, -0.004, 0.0], [0.002, 0.0, -0.003]);
    let more =
        "[tool.edges]\nhelix_deg = 35\nradial_run_out_mm = [0.01, -0.004, 0]\naxial_run_out_mm = [0.002, 0, -0.003]";
    let kinds = [
        ("kind = \"ball\"\ndiameter_mm = 6", 3.0, 3.0),
        ("kind = \"bull_nose\"\ndiameter_mm = 8\ncorner_radius_mm = 1.5", 4.0, 1.5),
    ];
    for (kind, outer, r) in kinds {
        let edges = edges_of(&tool(kind, more).expect("a tool")).expect("edges");
        assert_eq!(edges.len(), 3);
        for (k, e) in edges.iter().enumerate() {
            for kappa in [0.0, 0.4, 1.1, FRAC_PI_2] {
                // Radius, height and azimuth as they are defined.
                let radius = (outer - r) + r * kappa.sin() + dr[k];
                let height = r * (1.0 - kappa.cos()) + da[k];
                let azimuth = TAU * k as f64 / 3.0 + r * (1.0 - kappa.cos()) * 35_f64.to_radians().tan() / outer;
                assert!((e.center_radius + e.radius * kappa.sin() - radius).abs() < 1e-12);
                let z = e.center_height - e.radius * kappa.cos();
                assert!((z - height).abs() < 1e-12);
                assert!((e.azimuth + (z - e.center_height + e.radius) * e.lead - azimuth).abs() < 1e-12);
                // The point at this azimuth is on the edge: both residuals are zero.
                let q = Vector::new(radius * azimuth.cos(), radius * azimuth.sin(), height);
                let found = e.residual(&q, 0.0);
                assert!(found.plane.abs() < 1e-12 && found.arc.abs() < 1e-12 && e.holds(&found));
            }
            assert!((e.corner[0].abs() + (e.corner[1] - FRAC_PI_2).abs()) < 1e-12);
        }
    }
    // A barrel has the arc of its tip and that of its side; the lead goes on from one to the other.
    let barrel = "kind = \"barrel\"\ndiameter_mm = 12\ntip_radius_mm = 2\nside_radius_mm = 85";
    let edges = edges_of(&tool(barrel, "[tool.edges]\nhelix_deg = 20").expect("a tool")).expect("edges");
    assert_eq!(edges.len(), 6);
    let at = |e: &Edge, kappa: f64| {
        let z = e.center_height - e.radius * kappa.cos();
        (e.center_radius + e.radius * kappa.sin(), z, e.azimuth + (z - e.center_height + e.radius) * e.lead)
    };
    let (tip, side) = (at(&edges[0], edges[0].corner[1]), at(&edges[1], edges[1].corner[0]));
    let apart = (tip.0 - side.0).abs() + (tip.1 - side.1).abs() + (tip.2 - side.2).abs();
    assert!(apart < 1e-9, "{tip:?} and {side:?}");
}

#[test]
fn rake_turns_ahead_of_the_cut() {
    let insert = "kind = \"bull_nose\"\ndiameter_mm = 20\ncorner_radius_mm = 5";
    let more = |hand: &str, about: &str| {
        format!(
            "hand = \"{hand}\"\n[tool.edges]\nradial_rake_deg = 6\nrake_about = \"{about}\"\n\
             round_insert = {{ nose_circle_diameter_mm = 10, insert_radius_mm = 5 }}"
        )
    };
    for (hand, sense) in [("right", -1.0), ("left", 1.0)] {
        let axis = edges_of(&tool(insert, &more(hand, "axis")).expect("a tool")).expect("edges");
        assert!((axis[0].azimuth - sense * 6_f64.to_radians()).abs() < 1e-12 && axis[0].nose_turn == 0.0);
        let nose = edges_of(&tool(insert, &more(hand, "nose")).expect("a tool")).expect("edges");
        assert!(nose[0].azimuth == 0.0 && (nose[0].nose_turn - sense * 6_f64.to_radians()).abs() < 1e-12);
        // The lowest point stays, the outermost goes ahead of it in the sense of the cut.
        let g = nose[0].nose_turn;
        let outer = Vector::new(5.0 + 5.0 * g.cos(), 5.0 * g.sin(), 5.0);
        for q in [Vector::new(5.0, 0.0, 0.0), outer] {
            let found = nose[0].residual(&q, 0.0);
            assert!(found.plane.abs() < 1e-12 && found.arc.abs() < 1e-12, "{found:?}");
        }
        assert!(outer.y * sense > 0.0);
    }
}

#[test]
fn what_leaves_no_marks_is_refused_by_name() {
    let ball = "kind = \"ball\"\ndiameter_mm = 6";
    let refusal = |t: &proveout_tool::Tool| edges_of(t).expect_err("refused").to_string();
    assert!(refusal(&tool(ball, "").expect("a tool")).contains("has no [tool.edges]"));
    let flat = tool("kind = \"flat\"\ndiameter_mm = 6", "[tool.edges]").expect("a tool");
    assert!(refusal(&flat).contains("no rounded edge"));
    let mut odd = tool(ball, "[tool.edges]").expect("a tool");
    odd.flutes = Some(2);
    assert_eq!(edges_of(&odd), Err(TeethError::RunOuts { tool: "T".into(), given: 3, teeth: 2 }));
    odd.flutes = None;
    assert!(refusal(&odd).contains("add `flutes`"));
    let off = tool(ball, "[tool.edges]\nradial_run_out_mm = [0.03, -0.02, 0]").expect("a tool");
    assert_eq!(check_chip(&off, 0.05), Ok(()));
    assert!(check_chip(&off, 0.04).expect_err("refused").to_string().contains("0.05 mm between two teeth"));
    let piece = CutterPiece {
        time: [2.0, 3.0],
        tip: [Point::origin(), Point::new(1.0, 0.0, 0.0)],
        housing: [Vector::x(), Vector::y(), Vector::z()],
        turn: Vector::zeros(),
        azimuth: 0.0,
        azimuth_rate: 100.0,
        motion: 0,
    };
    assert_eq!(check_motion(&[piece]), Ok(()));
    let still = CutterPiece { azimuth_rate: 0.0, ..piece };
    assert_eq!(check_motion(&[piece, still]), Err(TeethError::Standing { time_s: 2.0, piece: 1 }));
    for bad in [CutterPiece { time: [3.0, 2.0], ..piece }, CutterPiece { azimuth: f64::NAN, ..piece }] {
        assert_eq!(check_motion(&[bad]), Err(TeethError::NotFinite { piece: 0 }));
    }
}

#[test]
fn the_phase_is_counted_from_the_feed_across_the_axis() {
    let upright = [Vector::x(), Vector::y(), Vector::z()];
    assert!((phase_zero(&upright, &Vector::new(0.0, 3.0, 1.0)) - FRAC_PI_2).abs() < 1e-15);
    // Along the axis: from +X, whatever the housing.
    let turned = [Vector::y(), -Vector::x(), Vector::z()];
    assert!((phase_zero(&turned, &-Vector::z()) + FRAC_PI_2).abs() < 1e-15);
    let lying = [Vector::y(), Vector::z(), Vector::x()];
    assert!(phase_zero(&lying, &Vector::x()).abs() < 1e-15);
    assert!(phase_zero(&upright, &Vector::new(f64::NAN, 0.0, 0.0)).is_finite());
}
