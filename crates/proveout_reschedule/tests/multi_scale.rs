//! The method of Dong et al. 2023 against its specification: golden files, closed forms of roughness, the
//! printed forms that are wrong, and the rows of the substitute surface as an independent implementation
//! counts them.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests fail by panic; figures are told")]

use std::path::Path;

use proveout_blade::{ClosedSurface, Dong};
use proveout_geom::{Point, Pose, ToolPose, Vector};
use proveout_machine::Machine;
use proveout_path::{PathCutter, PathPoint};
use proveout_reschedule::{
    BladeSurface, BullNose, ContactFrame, ContactPoint, ContactSurface, CrossSection, CuttingBlock, CuttingRun,
    Measurement, Method, MultiScale, RescheduleError, Rescheduled, Surroundings, critical, curve_value, fitted_curves,
    leaned, mean_deviation, mean_line,
};
use proveout_tool::{Cutter, Profile};

fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines().skip(1).map(|l| l.split(',').map(|v| v.trim().parse().unwrap_or(f64::NAN)).collect()).collect()
}

const TOOL: BullNose = BullNose { circle: 2.0, corner: 3.0 };

#[test]
fn golden_least_inclinations() {
    let golden = rows(include_str!("reference/multi-scale_golden_lambda_min.csv"));
    assert_eq!(golden.len(), 30);
    for v in &golden {
        let tool = BullNose { corner: v[0], circle: v[1] };
        let lean = tool.least_lean([v[2], v[3]], v[4].to_radians()).unwrap();
        assert!((lean.to_degrees() - v[6]).abs() < 1e-6, "{v:?} {}", lean.to_degrees());
    }
    // No inclination fits where the surface is as hollow as the corner.
    assert_eq!(TOOL.least_lean([0.4, 0.0], 1.0), None);
}

/// At the least inclination the smallest relative curvature is zero, below it the tool gouges, above it does
/// not.
#[test]
fn the_least_inclination_is_where_the_relative_curvature_is_zero() {
    let mut seed = 7_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut bound, mut free) = (0, 0);
    for _ in 0..9000 {
        let tool = BullNose { corner: 0.5 + 4.0 * random(), circle: 0.5 + 5.0 * random() };
        let (a, b) = (0.3 * random() - 0.1, 0.3 * random() - 0.1);
        let hollow = [a.max(b), a.min(b)];
        let gamma = 7.0 * random() - 3.5;
        let Some(lean) = tool.least_lean(hollow, gamma) else { continue };
        let at = |lean: f64| critical(tool.form(&leaned(lean, gamma)), [-hollow[0], 0.0, -hollow[1]]);
        if lean > 0.0 {
            bound += 1;
            assert!(at(lean).abs() < 1e-9, "{tool:?} {hollow:?} {gamma} {}", at(lean));
            assert!(at(lean * 0.98) < 0.0 && at((lean * 1.02).min(1.57)) > -1e-12);
        } else {
            free += 1;
            assert!(at(1e-6) >= -1e-9);
        }
    }
    assert!(bound > 3000 && free > 1000, "{bound} {free}");
    // Erratum MS-3: with the printed phase the relative curvature in a direction is another one.
    let form = TOOL.form(&leaned(0.4, 0.7));
    let (e, f, g) = (form[0], form[2], 2.0 * form[1]);
    let m = (e - f).hypot(g);
    let of = |phase: f64, a: f64| 0.5 * (e + f) + 0.5 * m * (2.0 * a - phase).cos();
    let direct = |a: f64| form[0] * a.cos().powi(2) + 2.0 * form[1] * a.sin() * a.cos() + form[2] * a.sin().powi(2);
    for a in [0.0, 0.6, 1.9] {
        assert!((of(g.atan2(e - f), a) - direct(a)).abs() < 1e-12);
        assert!((of(((e - f) / g).atan(), a) - direct(a)).abs() > 1e-3);
    }
}

#[test]
fn golden_strips_on_a_plane() {
    let golden = rows(include_str!("reference/multi-scale_golden_strip_width.csv"));
    assert_eq!(golden.len(), 15);
    for v in &golden {
        let t = leaned(v[3].to_radians(), v[4].to_radians());
        let flat = |_: f64| 0.0;
        let [left, right] = TOOL.strip(&t, &flat, v[2]).unwrap();
        assert!((left - v[8]).abs() < 2e-4 && (right - v[9]).abs() < 2e-4, "{v:?} {left} {right}");
        let [left, right] = TOOL.swept_strip(&t, &flat, v[2]).unwrap();
        assert!((left + right - v[12]).abs() < 2e-4, "{v:?} {}", left + right);
    }
}

#[test]
fn golden_curves_and_the_printed_system() {
    let golden = rows(include_str!("reference/multi-scale_golden_bspline.csv"));
    let coefficients = rows(include_str!("reference/multi-scale_golden_bspline_coeffs.csv"));
    let u: Vec<f64> = golden.iter().map(|v| v[1]).collect();
    let times: Vec<f64> = golden.iter().map(|v| v[4]).take_while(|t| t.is_finite()).collect();
    let ends = [(0, [18.0]), (20, [26.0])];
    let [free] = fitted_curves(&u, &times, 9, &ends).unwrap();
    let fixed = [(0, [18.0]), (5, [22.0]), (12, [20.0]), (20, [26.0])];
    let [bound] = fitted_curves(&u, &times, 9, &fixed).unwrap();
    for (v, (a, b)) in coefficients.iter().zip(free.iter().zip(&bound)) {
        assert!((a - v[1]).abs() < 1e-8 && (b - v[2]).abs() < 1e-8, "{v:?} {a} {b}");
    }
    for v in &golden {
        assert!((curve_value(&free, v[1]) - v[5]).abs() < 1e-8);
        assert!((curve_value(&bound, v[1]) - v[6]).abs() < 1e-8);
    }
    // (26) as printed misses the fixed values by degrees: 22 and 20 at these contacts.
    assert!((golden[5][7] - 22.0).abs() > 1.5 && (golden[12][7] - 20.0).abs() > 2.0);
    // What does not fit is reported, not bent: two values at one place, more places than coefficients.
    assert!(fitted_curves(&u, &times, 9, &[(0, [1.0]), (5, [2.0]), (5, [3.0]), (20, [1.0])]).is_none());
    let all: Vec<(usize, [f64; 1])> = (0..21).map(|i| (i, [0.0])).collect();
    assert!(fitted_curves(&u, &times, 9, &all).is_none());
    assert!(fitted_curves(&u, &times, 3, &ends).is_none());
}

/// A plane z = 0 as far as x and y reach.
struct Plane;

impl ContactSurface for Plane {
    fn contact(&self, near: &Point) -> Option<ContactPoint> {
        let curvatures = [(0.0, Vector::x()), (0.0, Vector::y())];
        Some(ContactPoint { point: Point::new(near.x, near.y, 0.0), normal: Vector::z(), curvatures })
    }
}

/// A parabola of height H has Ra = 4 H / (9 sqrt 3) about its mean line; the torus at a distance that is
/// small against its radius is one.
#[test]
fn roughness_of_a_plane_is_that_of_its_parabolas() {
    let parabola: Vec<[f64; 2]> =
        (0..2000).map(|i| (f64::from(i) + 0.5) / 2000.0 - 0.5).map(|y| [y, 4.0 * y * y]).collect();
    assert!((mean_deviation(&parabola) - 4.0 / (9.0 * 3.0_f64.sqrt())).abs() < 1e-6);
    let frame = ContactFrame::new(Point::origin(), Vector::z(), Vector::x()).unwrap();
    // Table of the specification: inclination, um at 0.63 mm, at 0.8 mm (by the quadratic formula, printed to
    // 0.01).
    for [lean, small, large] in [[10.0, 0.88, 1.41], [20.0, 1.44, 2.32], [45.0, 2.18, 3.52]] {
        for (distance, ra) in [(0.63, small), (0.8, large)] {
            let section = CrossSection::new(&Plane, &frame, distance, 5.0 * distance);
            let found = 1e3 * section.roughness(&TOOL, &leaned(f64::to_radians(lean), 0.0));
            assert!((found - ra).abs() < 0.012 + 0.01 * ra, "{lean} {distance}: {found} {ra}");
        }
    }
}

/// The Gaussian filter of ISO 16610-21 lets `exp(-pi (alpha cutoff / wave)^2)` of a wave through to the mean
/// line: half of one of the cutoff. Rows of a torus 0.8 mm apart are nearly parabolas, whose waves of 0.8,
/// 0.4 ... mm are left by that.
#[test]
fn filtered_roughness_is_what_the_filter_leaves_of_the_waves() {
    let alpha = (std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
    for wave in [0.25, 0.8, 2.5] {
        let at = |y: f64| (std::f64::consts::TAU * y / wave).cos();
        let profile: Vec<[f64; 2]> = (-300..=300).map(|i| 0.01 * f64::from(i)).map(|y| [y, at(y)]).collect();
        let through = (-std::f64::consts::PI * (alpha * 0.8 / wave).powi(2)).exp();
        assert!((mean_line(&profile, 0.0, 0.8) - through).abs() < 1e-4, "{wave}");
    }
    let frame = ContactFrame::new(Point::origin(), Vector::z(), Vector::x()).unwrap();
    let lean = leaned(0.35, 0.0);
    let section = CrossSection::new(&Plane, &frame, 0.8, 4.0);
    let filtered = section.filtered_roughness(&TOOL, &lean, 0.8);
    // A parabola z = 4 H (y / d)^2 from -d/2 to d/2 is H/3 + sum (-1)^n 4 H / (pi n)^2 cos(2 pi n y / d).
    let height = section.roughness(&TOOL, &lean) * 9.0 * 3.0_f64.sqrt() / 4.0;
    let rest = |y: f64| -> f64 {
        let wave = |n: i32| {
            let k = f64::from(n);
            let left = 1.0 - (-std::f64::consts::PI * (alpha * k).powi(2)).exp();
            let size = (-1.0_f64).powi(n) * 4.0 * height / (std::f64::consts::PI * k).powi(2);
            left * size * (std::f64::consts::TAU * k * y / 0.8).cos()
        };
        (1..60).map(wave).sum()
    };
    let expected = (0..4000).map(|i| rest(0.8 * f64::from(i) / 4000.0).abs()).sum::<f64>() / 4000.0;
    println!(
        "Ra {} um, filtered {} um, of parabolas {} um",
        section.roughness(&TOOL, &lean) * 1e3,
        filtered * 1e3,
        expected * 1e3
    );
    assert!((filtered / expected - 1.0).abs() < 0.01, "{filtered} {expected}");
}

fn dong() -> BladeSurface {
    BladeSurface::of(std::sync::Arc::new(ClosedSurface::new(Dong::stand_in())), Pose::identity())
}

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/jdgr200t")).unwrap()
}

fn bull_nose() -> Profile {
    Cutter::bull_nose(10.0, 3.0).unwrap().bodies(20.0).unwrap().remove(0)
}

/// The substitute at a place, with the feed along x.
fn place(surface: &BladeSurface, x: f64, y: f64) -> PathPoint {
    let (sin, cos) = (std::f64::consts::TAU * x / 60.0).sin_cos();
    let off = (y - 20.0) * (y - 20.0) / 2.0;
    let z = (0.004 + 0.016 * x / 60.0) * off + 0.8 * sin;
    let contact = surface.contact(&Point::new(x, y, z)).unwrap();
    let feed = Vector::new(1.0, 0.0, 0.8 * std::f64::consts::TAU / 60.0 * cos + 0.016 / 60.0 * off);
    let frame = ContactFrame::new(contact.point, contact.normal, feed).unwrap();
    PathPoint {
        t: 0.0,
        uv: [0.0; 2],
        point: frame.point,
        normal: frame.axes[2],
        feed: frame.axes[0],
        across: frame.axes[1],
        speed: 1.0,
        path_curvature: 0.0,
        form: [0.0; 3],
    }
}

/// Rows of the substitute at these y, with 101 contacts each, leaned by 20 degrees along the feed (Sturz).
fn sturz(surface: &BladeSurface, ys: &[f64]) -> Vec<CuttingRun> {
    let cutter = PathCutter::new(bull_nose());
    let at = |x: f64, y: f64| {
        let place = place(surface, x, y);
        let t = leaned(20.0_f64.to_radians(), 0.0);
        let axis = place.feed * t.x + place.across * t.y + place.normal * t.z;
        cutter.touch(&place, &axis, 0.0, None).pose
    };
    let block = |y: f64, i: u32| CuttingBlock { pose: at(0.6 * f64::from(i), y), line: i + 1, time: None };
    ys.iter().map(|y| CuttingRun { blocks: (0..=100).map(|i| block(*y, i)).collect() }).collect()
}

fn solved(
    method: &MultiScale,
    surface: &BladeSurface,
    runs: &[CuttingRun],
    row: usize,
) -> Result<Rescheduled, RescheduleError> {
    let (profile, machine) = (bull_nose(), machine());
    let around = Surroundings {
        machine: Some(&machine),
        surface: Some(surface),
        rows: runs,
        row,
        ..Surroundings::new(&profile, Vector::z())
    };
    method.reschedule(&runs[row], &around)
}

/// Rows of the substitute, 0.8 mm apart in y: nothing gouges, the strip stays in its window, no contact is
/// rougher than 1.6 um, the joints turn at most 1.5 times as fast as with the constant lead. Rows: both rims,
/// the middle where C is at rest, and the roughest. `PROVEOUT_MULTI_SCALE=full` takes all 51.
#[test]
fn rows_of_the_stand_in_keep_all_rules() {
    let surface = dong();
    let ys: Vec<f64> = (0..=50).map(|k| 0.8 * f64::from(k)).collect();
    let runs = sturz(&surface, &ys);
    let full = std::env::var("PROVEOUT_MULTI_SCALE").is_ok_and(|v| v == "full");
    let chosen: Vec<usize> = if full { (0..=50).collect() } else { vec![0, 13, 25, 47] };
    let machine = machine();
    let rates = |poses: &[ToolPose]| {
        let mut q = machine.home();
        let mut last: Option<[f64; 2]> = None;
        let mut most = [0.0_f64; 2];
        for pose in poses {
            let upright = ToolPose { tip: Point::origin(), ..*pose };
            q = machine.inverse_nearest(&upright, 0.0, &q).map(|s| s.q).unwrap_or_else(|e| match e {
                proveout_machine::KinematicsError::OverTravel { solution, .. } => solution.q,
                e => panic!("{e}"),
            });
            let here = [machine.rotary_joints()[0], machine.rotary_joints()[1]].map(|j| q[j]);
            if let Some(last) = last {
                most = [0, 1].map(|k| most[k].max((here[k] - last[k]).abs()));
            }
            last = Some(here);
        }
        most
    };
    let (mut roughest, mut sums, mut old, mut new) = (0.0_f64, [0.0; 3], [0.0_f64; 2], [0.0_f64; 2]);
    for &row in &chosen {
        let result = solved(&MultiScale::default(), &surface, &runs, row).unwrap();
        let figure = |name| result.study.figure(name).unwrap();
        let ra = figure("largest Ra across the feed");
        assert!(ra <= 1.6, "row {row}: {ra}");
        roughest = roughest.max(ra);
        assert!(figure("narrowest strip") >= 2.15 && figure("widest strip") <= 3.15, "row {row}");
        sums[0] += figure("mean Ra across the feed before");
        sums[1] += figure("mean Ra across the feed");
        sums[2] += figure("fixed contacts");
        let before: Vec<ToolPose> = runs[row].blocks.iter().map(|b| b.pose).collect();
        let (a, b) = (rates(&before), rates(&result.poses));
        old = [0, 1].map(|k| old[k].max(a[k]));
        new = [0, 1].map(|k| new[k].max(b[k]));
        // Contacts stay: tips go where the tool touches the same point.
        let cutter = PathCutter::new(bull_nose());
        for (i, pose) in result.poses.iter().enumerate() {
            let place = place(&surface, 0.6 * i as f64, ys[row]);
            assert!((cutter.touch(&place, &pose.axis, 0.0, None).pose.tip - pose.tip).norm() < 1e-5, "{row} {i}");
        }
    }
    let mean = 100.0 * (sums[1] / sums[0] - 1.0);
    println!(
        "largest Ra {roughest:.3} um, mean Ra {mean:.1} percent, fixed {}, rates x {:.2} {:.2}",
        sums[2],
        new[0] / old[0],
        new[1] / old[1]
    );
    assert!((-35.0..=-15.0).contains(&mean), "{mean}");
    assert!(new[0] <= 1.5 * old[0] && new[1] <= 1.5 * old[1], "{old:?} {new:?}");
}

/// The published ends (20 degrees) are rougher than the limit: with a run-in they stay and are reported,
/// judged they move.
#[test]
fn published_ends_need_a_run_in() {
    let surface = dong();
    let runs = sturz(&surface, &[19.2, 20.0, 20.8]);
    let method = MultiScale { run_in: 14.0, ..MultiScale::default() };
    let kept = solved(&method, &surface, &runs, 1).unwrap();
    let moved = solved(&MultiScale::default(), &surface, &runs, 1).unwrap();
    for (k, at) in [(0, 0), (100, 100)] {
        let was = runs[1].blocks[at].pose.axis;
        assert!((kept.poses[k].axis - was).norm() < 1e-6, "{k}");
        assert!((moved.poses[k].axis - was).norm() > 0.05, "{k}");
    }
    let ra = |r: &Rescheduled| r.study.figure("largest Ra across the feed").unwrap();
    assert!(ra(&kept) <= 1.6 && ra(&moved) <= 1.6);
    let out = kept.study.figure("contacts of the run-in, not judged").unwrap();
    assert!((40.0..=56.0).contains(&out), "{out}");
    assert_eq!(moved.study.figure("contacts of the run-in, not judged"), Some(0.0));
}

/// Blocks that lift the tool along the normal at both ends keep their distance and take the axis of the end.
#[test]
fn lead_in_and_lead_out_follow_their_ends() {
    let surface = dong();
    let mut runs = sturz(&surface, &[19.2, 20.0, 20.8]);
    let plain = solved(&MultiScale::default(), &surface, &runs, 1).unwrap();
    let lifted = |runs: &[CuttingRun], x: f64, k: usize| {
        let mut block = runs[1].blocks[k];
        block.pose.tip += place(&surface, x, 20.0).normal * 2.0;
        block
    };
    let (first, last) = (lifted(&runs, 0.0, 0), lifted(&runs, 60.0, 100));
    runs[1].blocks.insert(0, first);
    runs[1].blocks.push(last);
    let led = solved(&MultiScale::default(), &surface, &runs, 1).unwrap();
    assert_eq!(led.stretch, 1..102);
    for (k, pose) in plain.poses.iter().enumerate() {
        assert!((pose.tip - led.poses[k + 1].tip).norm() < 1e-6, "{k}");
    }
    for (lead, end, x) in [(0, 1, 0.0), (102, 101, 60.0)] {
        let by = led.poses[lead].tip - led.poses[end].tip;
        assert!((by - place(&surface, x, 20.0).normal * 2.0).norm() < 1e-5);
        assert!((led.poses[lead].axis - led.poses[end].axis).norm() < 1e-12);
    }
}

#[test]
fn what_it_is_not_defined_for_is_refused() {
    let surface = dong();
    let runs = sturz(&surface, &[19.2, 20.0, 20.8]);
    let base = MultiScale::default();
    let error =
        |method: &MultiScale, runs: &[CuttingRun]| solved(method, &surface, runs, 1.min(runs.len() - 1)).unwrap_err();
    assert_eq!(error(&MultiScale { strip: [3.0, 2.0], ..base }, &runs).code, "reschedule-option");
    assert_eq!(error(&MultiScale { strip: [f64::NAN, 2.0], ..base }, &runs).code, "reschedule-option");
    assert_eq!(error(&MultiScale { strip_height: 0.0, ..base }, &runs).code, "reschedule-option");
    assert_eq!(error(&MultiScale { roughness: f64::INFINITY, ..base }, &runs).code, "reschedule-option");
    // A window that no inclination reaches, with its first line.
    let narrow = error(&MultiScale { strip: [4.5, 5.0], ..base }, &runs);
    assert!(narrow.code == "reschedule-channel" && narrow.line == 1, "{narrow:?}");
    let smooth = error(&MultiScale { roughness: 0.2e-3, ..base }, &runs);
    assert!(smooth.code == "reschedule-channel" && smooth.message.contains("at most"), "{smooth:?}");
    // A row alone has no roughness across it; without that limit it is planned.
    let alone = &runs[1..2];
    assert!(error(&base, alone).message.contains("has no neighboring row"));
    assert!(solved(&MultiScale { roughness: 0.0, ..base }, &surface, alone, 0).is_ok());
    // Rows in one run, a row of four blocks, blocks at one place.
    let mut zigzag = runs.clone();
    let back: Vec<CuttingBlock> = runs[2].blocks.iter().rev().copied().collect();
    zigzag[1].blocks.extend(back);
    assert!(error(&base, &zigzag).message.contains("turns by"));
    let mut short = runs.clone();
    short[1].blocks.truncate(4);
    assert_eq!(error(&base, &short).code, "reschedule-layers");
    let mut twice = runs.clone();
    twice[1].blocks[7].pose = twice[1].blocks[6].pose;
    assert_eq!(error(&base, &twice).line, 7);
    let profile = Cutter::ball(10.0).unwrap().bodies(20.0).unwrap().remove(0);
    let around =
        Surroundings { rows: &runs, row: 1, surface: Some(&surface), ..Surroundings::new(&profile, Vector::z()) };
    assert_eq!(base.reschedule(&runs[1], &around).unwrap_err().code, "reschedule-tool");
}

/// Probability that a normal distribution lies above a place, in its standard deviations: tables of the
/// normal distribution (for instance Abramowitz and Stegun 1964, table 26.1) have 0.5, 0.158655, 0.022750 and
/// 0.001350 above 0, 1, 2 and 3.
#[test]
fn a_probe_reads_a_part_with_a_normal_scatter() {
    let model = Measurement { part: 0.5, spread: 0.1 };
    // Reads 1 um in the mean, with 0.1 um.
    for (limit, above) in [(1.0, 0.5), (1.1, 0.158_655), (1.2, 0.022_750), (1.3, 0.001_350), (0.9, 0.841_345)] {
        let found = model.above(2.0, limit);
        assert!((found - above).abs() < 1e-6, "{limit}: {found}");
    }
    let sharp = Measurement { part: 0.5, spread: 0.0 };
    assert_eq!([sharp.above(2.0, 0.99), sharp.above(2.0, 1.01)], [1.0, 0.0]);
}

/// With a measurement the study names places, with a margin contacts lie farther inside, and what is no model
/// is refused.
#[test]
fn options_of_the_published_numbers_act() {
    let surface = dong();
    let runs = sturz(&surface, &[19.2, 20.0, 20.8]);
    let base = MultiScale { measurement: Some(Measurement { part: 0.66, spread: 0.12 }), ..MultiScale::default() };
    let figures = |method: &MultiScale| solved(method, &surface, &runs, 1).expect("a plan").study;
    let own = figures(&base);
    let ra = own.figure("mean Ra across the feed before").expect("a mean");
    let places = own.figure("places of 90 measured above the limit before").expect("a count");
    // Ra is nearly the same all along this row, so that the count is that of its mean, to a place or two.
    let of_mean = 90.0 * Measurement { part: 0.66, spread: 0.12 }.above(ra, 1.6);
    assert!((places - of_mean).abs() <= 2.0 && places > 0.0, "{places} and {of_mean}");
    assert_eq!(own.figure("places of 90 measured above the limit"), Some(0.0));
    assert_eq!(figures(&MultiScale::default()).figure("places of 90 measured above the limit"), None);
    let less = own.figure("mean Ra across the feed less than before").expect("a part");
    let after = own.figure("mean Ra across the feed").expect("a mean");
    assert!((less - 100.0 * (1.0 - after / ra)).abs() < 1e-9);
    let rough = |margin: f64| {
        let method = MultiScale { margin: margin.to_radians(), ..base };
        figures(&method).figure("largest Ra across the feed").expect("a roughness")
    };
    assert!(rough(0.5) < rough(0.05), "a wider margin keeps farther from the limit");
    // Without a margin contacts lie on their limits, ends that are judged too.
    for run_in in [0.0, 2.0] {
        let made = solved(&MultiScale { margin: 0.0, run_in, ..base }, &surface, &runs, 1).expect("a plan");
        let largest = made.study.figure("largest Ra across the feed").expect("a roughness");
        assert!(largest > 1.599 && (run_in > 0.0 || largest < 1.6 * (1.0 + 1e-8)), "{run_in}: {largest}");
    }
    let coarse = figures(&MultiScale { coefficients: 8, ..base }).figure("coefficients of a curve").expect("a count");
    assert!(coarse < own.figure("coefficients of a curve").expect("a count"), "{coarse}");
    for wrong in [
        MultiScale { margin: -0.001, ..base },
        MultiScale { margin: f64::NAN, ..base },
        MultiScale { coefficients: 3, ..base },
        MultiScale { measurement: Some(Measurement { part: 0.0, spread: 0.1 }), ..base },
        MultiScale { measurement: Some(Measurement { part: 0.66, spread: 1.0 }), ..base },
    ] {
        let refused = solved(&wrong, &surface, &runs, 1).unwrap_err();
        assert_eq!(refused.code, "reschedule-option", "{wrong:?}");
    }
}
