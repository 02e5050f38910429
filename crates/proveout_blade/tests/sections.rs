//! Sections from files: a published rotor where it lies next to the checkout, and files that hold none.

use std::{io::Write, path::Path};

use proveout_blade::{FOOT_ERROR_MM, ParametricSurface, PointedSection, SectionsError, SkinnedBlade, read_sections};
use proveout_geom::Point;

/// The published profiles of NASA Rotor 37 as a section file: points 1 to 25 and 277 to 300 are the leading
/// edge, 127 to 175 the trailing edge, as their spacing shows. Centimeter become millimeter, the radial Z
/// becomes X.
fn rotor37(folder: &Path) -> String {
    let mut text = "section,part,x_mm,y_mm,z_mm\n".to_owned();
    for profile in 1..=6 {
        let file = folder.join(format!("R37_profile0{profile}.csv"));
        let lines = std::fs::read_to_string(file).expect("a profile");
        for (k, line) in lines.lines().skip(1).enumerate() {
            let [x, y, z]: [f64; 3] = line
                .split(',')
                .map(|v| v.trim().parse().expect("a number"))
                .collect::<Vec<_>>()
                .try_into()
                .expect("three");
            let part = match k {
                0..=24 | 276.. => "leading",
                25..=125 => "pressure",
                126..=174 => "trailing",
                _ => "suction",
            };
            text += &format!("{profile},{part},{},{},{}\n", 10.0 * z, 10.0 * x, 10.0 * y);
        }
    }
    text
}

#[test]
fn sections_of_nasa_rotor_37_are_reproduced() {
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let checkout = checkout.canonicalize().expect("the checkout");
    let folders =
        checkout.ancestors().skip(1).take(2).map(|dir| dir.join("shared/cases/nasa-rotor37/tutorials/rotor37"));
    let Some(folder) = folders.into_iter().find(|folder| folder.is_dir()) else {
        // Past the capture of the test program, so that no one takes it for tried.
        let _ = std::io::stderr().write_all(
            b"\nLEFT OUT: sections of NASA Rotor 37: shared/cases/nasa-rotor37 is not beside the checkout\n",
        );
        return;
    };
    let sections = read_sections(&rotor37(&folder)).expect("sections");
    assert_eq!((sections.len(), sections[0].points.len()), (6, 300));
    let blade = SkinnedBlade::new(&sections).expect("a blade");
    let mut worst = 0.0_f64;
    for section in &sections {
        for p in &section.points {
            worst = worst.max(blade.foot(p).distance);
        }
    }
    assert!(worst < FOOT_ERROR_MM, "{worst}");
    // Every second point left out comes back: the section between its points, not only at them.
    let thin = |s: &PointedSection| {
        let keep = |k: &usize| k.is_multiple_of(2);
        PointedSection {
            name: s.name.clone(),
            points: (0..300).filter(keep).map(|k| s.points[k]).collect(),
            parts: (0..300).filter(keep).map(|k| s.parts[k]).collect(),
        }
    };
    let thinned: Vec<PointedSection> = sections.iter().map(thin).collect();
    let half = SkinnedBlade::new(&thinned).expect("a blade");
    let mut between = 0.0_f64;
    for section in &sections {
        for p in &section.points {
            between = between.max(half.foot(p).distance);
        }
    }
    // The published points themselves scatter: every second one lies some tenths to five micrometers off
    // the curve through the others, all along the sides, whatever the curve.
    assert!(between < 6e-3, "{between}");
    scatter(&sections);
    // Its edges are round: the leading edge of the root has a radius of some tenths of a millimeter and no
    // concave place.
    let breaks = blade.breaks();
    for k in 0..=200 {
        let u = breaks[0] + (breaks[1] - breaks[0]) * f64::from(k) / 200.0;
        let at = blade.local(u, 0.0);
        assert!(at.principal()[0].0 > 1.0, "{u} {:?}", at.principal());
    }
}

/// Where a polynomial through `degree + 1` points next to each point of a side, the nearest at `stride`
/// places, misses it square to the side: root mean square, mm (Lagrange's form over the chord length).
fn left_out(side: &[Point], degree: usize, stride: usize) -> f64 {
    let mut length = vec![0.0];
    for pair in side.windows(2) {
        length.push(length[length.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let half = degree.div_ceil(2);
    let reach = stride * (2 * half - 1);
    let (mut sum, mut count) = (0.0, 0);
    for k in reach..side.len() - reach {
        let knots: Vec<usize> = (0..2 * half).map(|m| k - reach + 2 * m * stride).collect();
        let miss = knots.iter().fold(-side[k].coords, |sum, &i| {
            let others = knots.iter().filter(|&&j| j != i);
            let weight: f64 = others.map(|&j| (length[k] - length[j]) / (length[i] - length[j])).product();
            sum + side[i].coords * weight
        });
        let along = (side[k + 1] - side[k - 1]).normalize();
        sum += (miss - along * miss.dot(&along)).norm_squared();
        count += 1;
    }
    (sum / f64::from(count)).sqrt()
}

/// What the published points allow between them. Of a curve with smooth curvature a cubic through neighbors
/// misses 2^4 times as much at twice the spacing, and a polynomial of degree seven 2^8 times, and far less
/// altogether: the ellipse shows it. The points of the rotor do not.
fn scatter(sections: &[PointedSection]) {
    let ellipse: Vec<Point> = (0..100)
        .map(|k| {
            let (s, c) = (0.4 + 0.022 * f64::from(k)).sin_cos();
            Point::new(0.0, 30.0 * c, 8.0 * s)
        })
        .collect();
    let growth = left_out(&ellipse, 3, 2) / left_out(&ellipse, 3, 1);
    let gain = left_out(&ellipse, 3, 1) / left_out(&ellipse, 7, 1);
    assert!(growth > 12.0 && gain > 100.0, "{growth} {gain}");
    for section in sections {
        for side in [&section.points[26..126], &section.points[176..276]] {
            let [once, twice, seventh] = [(3, 1), (3, 2), (7, 1)].map(|(d, s)| left_out(side, d, s));
            assert!((0.6e-3..1.5e-3).contains(&once), "{} {once}", section.name);
            assert!(twice < 4.0 * once && seventh > 0.95 * once, "{} {once} {twice} {seventh}", section.name);
        }
    }
}

/// Ellipses of 40 by 10 mm in planes 10 mm apart.
fn ellipses() -> Vec<PointedSection> {
    let point = |j: u32, k: u32| {
        let (s, c) = (f64::from(k) * std::f64::consts::TAU / 60.0).sin_cos();
        Point::new(10.0 * f64::from(j), 20.0 * c, 5.0 * s)
    };
    let section =
        |j| PointedSection { name: format!("s{j}"), points: (0..60).map(|k| point(j, k)).collect(), parts: Vec::new() };
    (0..4).map(section).collect()
}

#[test]
fn sections_that_make_no_blade_are_named_with_section_and_point() {
    SkinnedBlade::new(&ellipses()).expect("a blade");
    let refused = |change: &dyn Fn(&mut Vec<PointedSection>), words: &str| {
        let mut sections = ellipses();
        change(&mut sections);
        let error = SkinnedBlade::new(&sections).map(|_| words).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(&|s| s.truncate(1), "at least two");
    refused(&|s| s[2].points.truncate(59), "section s2 has 59 points, s0 has 60");
    refused(&|s| s[1].points.reverse(), "section s1 runs the other way round than s0");
    refused(
        &|s| s[3].points.rotate_left(20),
        "section s3 begins at a different place than s2: its point 1 lies where s2 has point 21",
    );
    refused(&|s| s[2].points[7] = s[2].points[6], "section s2, point 8: it lies on the point before it");
    refused(&|s| s[2].points.swap(10, 20), "section s2 crosses itself between points");
    refused(&|s| s[2].points.iter_mut().for_each(|p| p.x += p.y), "section s2 crosses s1 near point");
    let parts = SectionsError::Few { count: 0 };
    assert_eq!(SkinnedBlade::new(&[]).map(|_| ()).expect_err("none"), parts);
}

#[test]
fn files_that_hold_no_sections_are_named_with_their_line() {
    let fails = |text: &str, line: usize, words: &str| {
        let error = read_sections(text).expect_err(words);
        assert!(error.line == line && error.message.contains(words), "{error}");
    };
    fails("", 1, "no header");
    fails("# sections\nx,y,z\n", 2, "write `section,part,x_mm,y_mm,z_mm`");
    fails("section,x_mm,y_mm,z_mm\na,1,2\n", 2, "3 values under 4 columns");
    fails("section,x_mm,y_mm,z_mm\na,1,2,nan\n", 2, "\"nan\" is not a coordinate");
    fails("section,x_mm,y_mm,z_mm\na,1,2,3\nb,1,2,3\na,1,2,3\n", 4, "goes on after another");
    fails("section,part,x_mm,y_mm,z_mm\na,nose,1,2,3\n", 2, "leading, trailing, suction, pressure");
}
