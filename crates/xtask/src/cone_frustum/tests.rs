//! The programs are read back as text and every block is measured against the cone with formulas that share
//! nothing with the generator: rotation matrices instead of its angles, the half-angle test of a cone instead
//! of its distance.

use super::{
    geometry::Rotaries,
    plan,
    program::{ProgramTarget, TARGETS, word, write},
};

/// Closed form of the cone, worked out by hand from its drawing and not taken from the generator.
const APEX: [f64; 3] = [25.922_553_2, 0.0, 117.014_102_9];
const AXIS: [f64; 3] = [0.173_648_177_667, 0.0, 0.984_807_753_012];
const SIN_15: f64 = 0.258_819_045_103;
const COS_15: f64 = 0.965_925_826_289;
/// Half a unit of the last printed decimal: 4 for mm, 5 for degrees.
const LENGTH_ROUNDING: f64 = 0.5e-4;
const ANGLE_ROUNDING_DEG: f64 = 0.5e-5;

/// Of the end mill that cuts the flank.
const FINISH_RADIUS: f64 = 10.0;

#[derive(Clone, Copy, Debug)]
struct Row {
    rapid: bool,
    feed: bool,
    tip: [f64; 3],
    tilt_deg: f64,
    c_deg: f64,
}

/// Blocks with X, Y, Z and both rotary words, split at the comment that opens a pass.
fn read(text: &str) -> Vec<Vec<Row>> {
    let mut passes: Vec<Vec<Row>> = Vec::new();
    let mut rapid = false;
    let mut feed_mm_min = 0.0;
    for line in text.lines() {
        let (number, words) = line.split_once(' ').expect("a block number and words");
        assert!(number.starts_with('N'), "{line}");
        if words.starts_with(";Pass") {
            passes.push(Vec::new());
        }
        if words.starts_with(';') || words.starts_with("MSG") {
            continue;
        }
        let value =
            |letter: char| words.split(' ').find_map(|w| w.strip_prefix(letter)).and_then(|v| v.parse::<f64>().ok());
        match value('G') {
            Some(0.0) => rapid = true,
            Some(1.0) => rapid = false,
            _ => {}
        }
        feed_mm_min = value('F').unwrap_or(feed_mm_min);
        if let (Some(x), Some(y), Some(z), Some(c)) = (value('X'), value('Y'), value('Z'), value('C')) {
            let tilt_deg = value('B').or_else(|| value('A')).expect("a tilt word");
            let row = Row { rapid, feed: feed_mm_min == 2000.0, tip: [x, y, z], tilt_deg, c_deg: c };
            passes.last_mut().expect("a pass").push(row);
        }
    }
    passes
}

type Matrix = [[f64; 3]; 3];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Third column of `Rz(C) Ry(B)` or `Rz(C) Rx(A)`.
fn tool_axis(rotaries: Rotaries, row: &Row) -> [f64; 3] {
    let (s, c) = row.c_deg.to_radians().sin_cos();
    let turn = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
    let (s, c) = row.tilt_deg.to_radians().sin_cos();
    let tilt = match rotaries {
        Rotaries::Bc => [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
        Rotaries::Ac => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
    };
    let both = times(&turn, &tilt);
    [both[0][2], both[1][2], both[2][2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Signed distance of a point from the cone: length of the vector from the apex times the sine of the angle
/// by which it lies outside of the half angle.
fn distance(p: [f64; 3]) -> f64 {
    let v = minus(p, APEX);
    let length = dot(v, v).sqrt();
    let cos = -dot(v, AXIS) / length;
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    length * (sin * COS_15 - cos * SIN_15)
}

fn programs() -> Vec<(ProgramTarget, Vec<Vec<Row>>)> {
    TARGETS.iter().map(|t| (*t, read(&write(t).text))).collect()
}

/// Blocks of the full turn: those in feed whose distance is the allowance; the leads are further off.
fn turn(pass: &[Row], radius: f64, allowance: f64) -> Vec<&Row> {
    let near = |row: &&Row| row.feed && !row.rapid && distance(row.tip) - radius - allowance < 1e-3;
    pass.iter().filter(near).collect()
}

#[test]
fn every_block_of_a_turn_lies_on_the_cone_with_its_allowance() {
    // Rounding of the tip moves the cylinder by at most sqrt(3) halves of the last decimal; rounding of both
    // angles by their sum over the length of the flank.
    let reach = 40.0;
    let bound = 1e-6 + 3_f64.sqrt() * LENGTH_ROUNDING + 2.0 * ANGLE_ROUNDING_DEG.to_radians() * reach;
    for (target, passes) in programs() {
        let wanted = plan::passes();
        assert_eq!(passes.len(), wanted.len());
        for (pass, wanted) in passes.iter().zip(wanted) {
            let (radius, allowance) = (wanted.cutter.radius, wanted.allowance);
            let rows = turn(pass, radius, allowance);
            assert!(rows.len() > 180, "{} blocks", rows.len());
            for row in rows {
                let axis = tool_axis(target.rotaries, row);
                for height in [0.0, 13.0, reach] {
                    let center: [f64; 3] = std::array::from_fn(|i| row.tip[i] + height * axis[i]);
                    let off = distance(center) - radius - allowance;
                    assert!(off.abs() < bound, "{row:?} height {height}: {off}");
                }
            }
        }
    }
}

#[test]
fn between_blocks_the_finish_pass_stays_within_its_bound() {
    // Half a micrometer as stated in the program, and the rounding of its words at both ends.
    let bound = 0.0005 + 3_f64.sqrt() * LENGTH_ROUNDING + 2.0 * ANGLE_ROUNDING_DEG.to_radians() * 40.0;
    for (target, passes) in programs() {
        let rows = turn(passes.last().expect("passes"), FINISH_RADIUS, 0.0);
        let mut worst: f64 = 0.0;
        for pair in rows.windows(2) {
            for step in 1..16 {
                let u = f64::from(step) / 16.0;
                let mix = |a: f64, b: f64| a + u * (b - a);
                let row = Row {
                    tip: std::array::from_fn(|i| mix(pair[0].tip[i], pair[1].tip[i])),
                    tilt_deg: mix(pair[0].tilt_deg, pair[1].tilt_deg),
                    c_deg: mix(pair[0].c_deg, pair[1].c_deg),
                    ..*pair[0]
                };
                let axis = tool_axis(target.rotaries, &row);
                for height in 0..=8 {
                    let center: [f64; 3] = std::array::from_fn(|i| row.tip[i] + 5.0 * f64::from(height) * axis[i]);
                    worst = worst.max(FINISH_RADIUS - distance(center));
                }
            }
        }
        assert!(worst < bound && worst > 0.0002, "{}: {worst}", target.name);
    }
}

#[test]
fn a_turn_closes_without_a_jump_of_c_and_in_climb_direction() {
    for (target, passes) in programs() {
        for pass in &passes {
            let feed: Vec<&Row> = pass.iter().filter(|r| !r.rapid).collect();
            for pair in feed.windows(2) {
                let step = pair[1].c_deg - pair[0].c_deg;
                assert!(step <= 0.0 && step > -8.0, "{}: C from {} to {}", target.name, pair[0].c_deg, pair[1].c_deg);
            }
            let total = feed[0].c_deg - feed[feed.len() - 1].c_deg;
            assert!(total > 360.0 + plan::OVERLAP_DEG && total < 720.0, "{total}");
            assert!(feed.iter().all(|r| r.c_deg.abs() < 360.0));
            assert!(feed.iter().all(|r| (4.999..25.001).contains(&r.tilt_deg.abs())));
        }
    }
}

#[test]
fn rapids_and_plunges_stay_outside_of_the_blank() {
    for (target, passes) in programs() {
        for (pass, wanted) in passes.iter().zip(plan::passes()) {
            // The first three rows and the last are rapid or plunge; the motion between them is along the
            // tool axis.
            for row in pass[..3].iter().chain(pass.last()) {
                let axis = tool_axis(target.rotaries, row);
                for height in 0..300 {
                    let p: [f64; 3] = std::array::from_fn(|i| row.tip[i] + f64::from(height) * axis[i]);
                    let beside = (p[0].hypot(p[1]) - plan::BLANK_RADIUS).max(0.0);
                    let gap = beside.hypot(p[2].max(0.0)) - wanted.cutter.radius;
                    assert!(gap > plan::CLEARANCE - 0.01, "{row:?} height {height}: {gap}");
                }
            }
            let (first, last) = (&pass[0], &pass[pass.len() - 1]);
            assert!(first.rapid && last.rapid && first.tip[2] == 100.0 && last.tip[2] == 100.0);
        }
    }
}

#[test]
fn the_tool_passes_the_base_circle_and_no_pass_cuts_deeper_than_the_flutes() {
    for (_, passes) in programs() {
        let finish = turn(passes.last().expect("passes"), FINISH_RADIUS, 0.0);
        for row in finish {
            // The contact point at the lower end: from the tip back to the cone by one radius.
            let from_apex = minus(row.tip, APEX);
            let lower_end = (dot(from_apex, from_apex) - FINISH_RADIUS * FINISH_RADIUS).sqrt();
            let base = plan::BASE_RADIUS / SIN_15;
            assert!((lower_end - base - plan::RUN_PAST).abs() < 1e-3, "{lower_end}");
        }
        let deepest = passes.iter().flatten().filter(|r| !r.rapid).map(|r| r.tip[2]).fold(f64::INFINITY, f64::min);
        assert!(-deepest < plan::greatest_depth());
    }
    assert!(plan::greatest_depth() < 40.0, "{}", plan::greatest_depth());
}

#[test]
fn both_machines_see_the_same_tool() {
    let programs = programs();
    let (bc, ac) = (&programs[0].1, &programs[1].1);
    for (one, other) in bc.iter().flatten().zip(ac.iter().flatten()) {
        assert_eq!(one.tip, other.tip);
        let gap = minus(tool_axis(Rotaries::Bc, one), tool_axis(Rotaries::Ac, other));
        assert!(dot(gap, gap).sqrt() < 4.0 * ANGLE_ROUNDING_DEG.to_radians());
    }
}

#[test]
fn words_have_no_negative_zero_and_always_a_point() {
    assert_eq!(word(-0.000_01, 4), "0.0");
    assert_eq!(word(12.0, 4), "12.0");
    assert_eq!(word(-3.250_04, 4), "-3.25");
    assert_eq!(word(0.005, 4), "0.005");
}

#[test]
fn the_tool_library_has_the_cutters_with_these_radii_and_long_flutes() {
    let path = crate::workspace_root().join("tools/cone-frustum.toml");
    let library = std::fs::read_to_string(path).expect("the tool library");
    for cutter in [plan::ROUGHER, plan::FINISHER] {
        let tables: Vec<&str> = library.split("[[tool]]").collect();
        let name = format!("name = \"{}\"", cutter.name);
        let table = tables.iter().find(|t| t.lines().any(|l| l == name)).expect(cutter.name);
        let value = |key: &str| {
            table.lines().find_map(|l| l.strip_prefix(key)?.trim().strip_prefix('=')?.trim().parse::<f64>().ok())
        };
        assert_eq!(value("diameter_mm"), Some(2.0 * cutter.radius));
        assert!(value("flute_length_mm").is_some_and(|length| length > plan::greatest_depth()));
    }
}
