//! Sections from files: a published rotor where it lies beside the checkout, and files that hold none.

use std::{io::Write, path::Path};

use proveout_geom::Point;
use proveout_geom::blade::{
    FOOT_ERROR_MM, ParametricSurface, PointedSection, SectionsError, SkinnedBlade, read_sections,
};

/// The published profiles of NASA Rotor 37 as a section file: points 1 to 25 and 277 to 300 are the leading edge, 127 to 175 the trailing edge,
/// as their spacing tells. Centimeter become millimeter, the radial Z becomes X.
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
        // Past the capture of the test program, so that nobody takes it for tried.
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
            worst = worst.max(blade.foot(p).1);
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
            between = between.max(half.foot(p).1);
        }
    }
    // The published points themselves scatter: every second one lies some tenths to five micrometers beside the curve through the others, all along
    // the sides.
    assert!(between < 6e-3, "{between}");
    // Its edges are round: the leading edge of the root has a radius of some tenths of a millimeter and no concave place.
    let breaks = blade.breaks();
    for k in 0..=200 {
        let u = breaks[0] + (breaks[1] - breaks[0]) * f64::from(k) / 200.0;
        let at = blade.local(u, 0.0);
        assert!(at.principal()[0].0 > 1.0, "{u} {:?}", at.principal());
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
        "section s3 begins at another place than s2: its point 1 lies where s2 has point 21",
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
    fails("section,x_mm,y_mm,z_mm\na,1,2,nan\n", 2, "\"nan\" is no coordinate");
    fails("section,x_mm,y_mm,z_mm\na,1,2,3\nb,1,2,3\na,1,2,3\n", 4, "goes on after another");
    fails("section,part,x_mm,y_mm,z_mm\na,nose,1,2,3\n", 2, "leading, trailing, suction, pressure");
}
