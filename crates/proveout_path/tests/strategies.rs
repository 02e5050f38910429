//! Strategies on surfaces with closed forms: where their lines lie, how far apart, how they are linked, and
//! what is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::f64::consts::PI;
use std::path::Path;

use proveout_blade::{Blade, BladeSpec, CamberSection, CamberSide, ClosedSurface, Lu, ParametricSurface, Sine};
use proveout_geom::{Pose, Vector, rad};
use proveout_machine::Machine;
use proveout_path::{
    AxisRule, ConstantScallop, IsoParametric, IsoPlanar, Label, LineContacts, LinkRule, Move, PathCutter, PathError,
    Pocket, PointRoughing, QuasiCircle, Setting, Spacing, StepRule, Strategy, Task, Transverse, linked,
};
use proveout_tool::Cutter;

fn ball(diameter: f64) -> PathCutter {
    PathCutter::new(Cutter::ball(diameter).unwrap().bodies(20.0).unwrap().remove(0))
}

const RULE: AxisRule = AxisRule::LeadTilt { lead: 0.2, tilt: 0.1 };

fn task<'a>(surface: &'a dyn ParametricSurface, cutter: &'a PathCutter) -> Task<'a> {
    Task { surface, cutter, rule: &RULE, step: StepRule::Chord { error: 0.005, longest: 2.0 }, allowance: 0.0 }
}

/// A blade of 100 mm whose edges have radii of 1.6 and 1.2 mm: those of the substitute of Lu et al. go below
/// 1 um, where every chord is refused.
fn camber_side() -> CamberSide {
    let section = CamberSection::stand_in();
    CamberSide::new(Blade::new(BladeSpec { section, length: 100.0, twist: 0.004, platform: None }).unwrap())
}

const RIDGE: f64 = 0.005;

/// Ridges as computed lie below the height asked for, and reach it somewhere between each two lines but the
/// last two.
fn spaced(name: &str, lines: &[LineContacts], everywhere: bool) {
    assert!(lines.len() > 3, "{name}: {}", lines.len());
    for (k, line) in lines.iter().enumerate().take(lines.len() - 1) {
        let ridges: Vec<f64> = line.contacts.iter().filter_map(|c| c.scallop).collect();
        let most = ridges.iter().copied().fold(0.0, f64::max);
        let least = ridges.iter().copied().fold(f64::MAX, f64::min);
        assert!(most < 1.01 * RIDGE, "{name} {}: {most}", line.name);
        // The last lines of constant scallop are pieces in front of the line where they end.
        let length = |l: &LineContacts| l.contacts.last().map_or(0.0, |c| c.length);
        if k + 2 < lines.len() && length(&lines[k + 1]) > 0.9 * length(line) {
            assert!(ridges.len() > line.contacts.len() / 2, "{name} {}: {}", line.name, ridges.len());
            assert!(most > 0.93 * RIDGE, "{name} {}: {most}", line.name);
            assert!(!everywhere || least > 0.98 * RIDGE, "{name} {}: {least} to {most}", line.name);
        }
    }
}

#[test]
fn lines_lie_as_far_apart_as_the_scallop_allows() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let cutter = ball(6.0);
    let task = task(&lu, &cutter);
    let scallop = || Spacing::Scallop(RIDGE);
    let along = [0.1, 0.9];
    let iso = IsoParametric { label: Label::Length, range: [0.1, 0.16], along, spacing: scallop() };
    spaced("iso-parametric", &task.plan(&iso).unwrap(), false);
    // Over the leading edge, where a step of the angle is a small step of the surface.
    let quasi =
        QuasiCircle { focus_inside: 0.0, trailing: 0.0, range: [rad(172.0), rad(186.0)], along, spacing: scallop() };
    spaced("quasi-circle", &task.plan(&quasi).unwrap(), false);
    let round = Transverse { round: [0.05, 0.4], range: [0.2, 0.3], spacing: scallop(), one_way: false };
    spaced("transverse", &task.plan(&round).unwrap(), false);
    let constant = ConstantScallop { range: [0.2, 0.25], along, scallop: RIDGE };
    spaced("constant-scallop", &task.plan(&constant).unwrap(), true);
    // The concave side and a hollow.
    let constant = ConstantScallop { range: [0.7, 0.75], along, scallop: RIDGE };
    spaced("constant-scallop, concave", &task.plan(&constant).unwrap(), true);
}

/// Lines all round a blade, to and fro: every contact has its neighbor next to it but where the next line
/// begins aside, for the blade is twisted; the first and the last line lie at the ends of the range.
#[test]
fn lines_all_round_keep_within_their_range_and_find_their_neighbors() {
    let side = camber_side();
    let cutter = ball(6.0);
    let task = task(&side, &cutter);
    let rounds = Transverse { round: [0.0, 1.0], range: [0.3, 0.37], spacing: Spacing::Scallop(RIDGE), one_way: false };
    let lines = task.plan(&rounds).unwrap();
    let at = |line: &LineContacts| line.contacts[0].place.point.x;
    let (first, last) = (at(&lines[0]), at(&lines[lines.len() - 1]));
    assert!((first - 30.0).abs() < 1e-9 && (last - 37.0).abs() < 1e-9, "{first} {last}");
    let mut asked = 0;
    for line in &lines[..lines.len() - 1] {
        for contact in &line.contacts {
            let Some(step) = contact.side_step else {
                let length = line.contacts.last().unwrap().length;
                assert!(contact.length.min(length - contact.length) < 0.5, "{} {:?}", line.name, contact.place.point);
                continue;
            };
            assert!(
                step < 1.0 && contact.scallop.is_some_and(|s| s < 1.01 * RIDGE),
                "{} {step} {:?}",
                line.name,
                contact
            );
            asked += 1;
        }
    }
    assert!(asked > 500, "{asked}");
}

#[test]
fn lines_go_to_and_fro_and_backwards_where_asked() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let cutter = ball(6.0);
    let task = task(&lu, &cutter);
    let lines = |along: [f64; 2]| {
        let spacing = Spacing::At(vec![0.2, 0.25, 0.3]);
        task.plan(&IsoParametric { label: Label::Surface, range: [0.0, 1.0], along, spacing }).unwrap()
    };
    for (along, first) in [([0.1, 0.8], 1.0), ([0.8, 0.1], -1.0)] {
        for (k, line) in lines(along).iter().enumerate() {
            let way = line.contacts.last().unwrap().place.point.x - line.contacts[0].place.point.x;
            let sign = if k % 2 == 0 { first } else { -first };
            assert!((way * sign - 70.0).abs() < 1e-6, "{along:?} {k} {way}");
            // The direction of travel is the one of the points.
            let [a, b] = [0, 1].map(|i| line.contacts[i].place);
            assert!(a.feed.dot(&(b.point - a.point)) > 0.0);
            assert!(line.contacts.windows(2).all(|w| w[1].length > w[0].length));
        }
    }
}

#[test]
fn planes_across_a_blade_give_closed_lines_and_planes_along_it_open_ones() {
    let side = camber_side();
    let cutter = ball(6.0);
    let task = task(&side, &cutter);
    let planes = |normal: Vector, at: f64| IsoPlanar {
        normal,
        range: [at, at],
        round: [0.0, 1.0],
        along: [0.0, 1.0],
        spacing: Spacing::At(vec![at]),
    };
    // Across the span: one closed line, that of the section.
    let across = task.plan(&planes(Vector::x(), 40.0)).unwrap();
    assert_eq!(across.len(), 1);
    let contacts = &across[0].contacts;
    let [first, last] = [contacts[0].place, contacts[contacts.len() - 1].place];
    assert!((first.point - last.point).norm() < 1e-9, "{:?}", last.point - first.point);
    let section = Transverse { round: [0.0, 1.0], range: [0.4, 0.5], spacing: Spacing::At(vec![0.4]), one_way: false };
    let whole = task.plan(&section).unwrap();
    let length = |l: &[LineContacts]| l[0].contacts.last().unwrap().length;
    assert!((length(&across) - length(&whole)).abs() < 1e-3, "{} {}", length(&across), length(&whole));
    assert!(contacts.iter().all(|c| (c.place.point.x - 40.0).abs() < 1e-5));
    // Past the blade: nothing, and reported.
    assert!(matches!(task.plan(&planes(Vector::x(), 140.0)), Err(PathError::NoLine { .. })));
    // A wavy face: planes across its waves.
    let sine = ClosedSurface::new(Sine::gentle());
    let wavy = Task { surface: &sine, ..task };
    let lines = wavy.plan(&planes(Vector::x(), 15.0)).unwrap();
    assert_eq!(lines.len(), 1);
    assert!((lines[0].contacts.last().unwrap().place.point.y - lines[0].contacts[0].place.point.y - 80.0).abs() < 1e-6);
}

#[test]
fn rings_are_closed_and_lie_inside_each_other() {
    let sine = ClosedSurface::new(Sine::gentle());
    let cutter = ball(6.0);
    let task = task(&sine, &cutter);
    let pocket = Pocket { round: [0.1, 0.9], along: [0.1, 0.4], spacing: Spacing::Scallop(0.02), outwards: false };
    let lines = task.plan(&pocket).unwrap();
    assert!(lines.len() > 20 && !lines[0].joined && lines[1..].iter().all(|l| l.joined));
    // Every line begins where the one before ends: one way on the surface, without a retract.
    for pair in lines.windows(2) {
        let [end, start] = [pair[0].contacts.last().unwrap(), &pair[1].contacts[0]];
        assert!((end.place.point - start.place.point).norm() < 1e-9, "{} {}", pair[0].name, pair[1].name);
    }
    let rings: Vec<&LineContacts> = lines.iter().filter(|l| l.name.ends_with("side 1")).collect();
    assert!(rings.windows(2).all(|w| w[1].contacts[0].place.uv[1] > w[0].contacts[0].place.uv[1]));
    let outwards = task.plan(&Pocket { outwards: true, ..pocket }).unwrap();
    assert!((outwards.last().unwrap().contacts[0].place.uv[0] - 3.0).abs() < 1e-9, "the last ring is the rim");
}

#[test]
fn layers_have_falling_allowances_and_the_cutter_stands_on_them() {
    let side = camber_side();
    let cutter = ball(6.0);
    let task = task(&side, &cutter);
    let roughing = PointRoughing {
        from_allowance: 5.0,
        to_allowance: 0.3,
        depth: 1.5,
        range: [0.9, 0.5],
        start: 0.25,
        spacing: Spacing::At(vec![0.9, 0.5]),
    };
    assert_eq!(roughing.layers().len(), 5);
    let lines = task.plan(&roughing).unwrap();
    assert_eq!(lines.len(), 10);
    for line in &lines {
        for contact in &line.contacts {
            let center = contact.touch.pose.tip + contact.touch.pose.axis * 3.0;
            let off = (center - contact.place.point).dot(&contact.place.normal);
            assert!((off - 3.0 - line.allowance).abs() < 1e-9, "{}", line.name);
        }
    }
    assert!((lines[0].allowance - 5.0).abs() < 1e-12 && (lines[9].allowance - 0.3).abs() < 1e-12);
}

/// Between lines the ball keeps away from the whole blade by the lift at least, on straight ways from pose to
/// pose.
#[test]
fn links_round_the_blade_do_not_touch_it() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let cutter = ball(6.0);
    let task = task(&lu, &cutter);
    // One line on each side, and one next to the first: a hop, a way round, and all ends.
    let spacing = Spacing::At(vec![0.2, 0.21, 0.8, 0.25]);
    let lines =
        task.plan(&IsoParametric { label: Label::Surface, range: [0.0, 1.0], along: [0.1, 0.9], spacing }).unwrap();
    let rule = LinkRule { lift: 2.0, clearance: 5.0, feed: 10.0, step: [10.0, 0.1], chords: false };
    let moves: Vec<Move> = linked(&lu, &cutter, &lines, &rule).unwrap();
    let contacts: usize = lines.iter().map(|l| l.contacts.len()).sum();
    assert!(moves.len() > contacts + 10);
    let cloud: Vec<_> = (0..400)
        .flat_map(|i| (0..200).map(move |j| (2.0 * PI * f64::from(i) / 400.0, f64::from(j) / 199.0)))
        .map(|(u, v)| lu.local(u, v).point)
        .collect();
    let mut rapids = 0;
    for pair in moves.windows(2) {
        if pair[1].seconds.is_some() {
            continue;
        }
        rapids += 1;
        for k in 0..=8 {
            let pose = pair[0].pose.interpolated(&pair[1].pose, f64::from(k) / 8.0);
            // The whole flute, as balls along the axis.
            for up in 0..6 {
                let center = pose.tip + pose.axis * (3.0 + 3.0 * f64::from(up));
                let gap = cloud.iter().map(|p| (p - center).norm()).fold(f64::MAX, f64::min) - 3.0;
                assert!(gap > 1.5, "{gap} {pose:?}");
            }
        }
    }
    assert!(rapids > 10, "{rapids}");
    // Feeds take the time of their way on the contact's path.
    let time: f64 = moves.iter().filter_map(|m| m.seconds).sum();
    let length: f64 = lines.iter().map(|l| l.contacts.last().unwrap().length).sum();
    assert!((time - (length + 2.0 * 8.0) / 10.0).abs() < 1e-6, "{time} {length}");
}

#[test]
fn what_a_machine_cannot_take_is_reported_with_its_place() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let cutter = ball(6.0);
    let task = task(&lu, &cutter);
    let spacing = Spacing::At(vec![0.2, 0.8]);
    let lines =
        task.plan(&IsoParametric { label: Label::Surface, range: [0.0, 1.0], along: [0.1, 0.9], spacing }).unwrap();
    // Span along x: one of the sides looks down, which no head of 95 degrees takes.
    let grinder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/bc-head-table-grinder");
    let grinder = Machine::read(&grinder).unwrap();
    let setting = Setting {
        machine: &grinder,
        table_from_surface: Pose::from_translation(Vector::new(0.0, 0.0, 150.0)),
        tool_length: 150.0,
        domain: lu.domain(),
        feed: 10.0,
    };
    let error = setting.judge(&lines, &grinder.home()).unwrap_err();
    assert!(matches!(error, PathError::Unreachable { .. }), "{error}");
    assert!(error.to_string().contains("section") && error.to_string().contains("X"), "{error}");
}

#[test]
fn numbers_out_of_range_and_cutters_that_leave_no_ridge_are_named() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let cutter = ball(6.0);
    let task = task(&lu, &cutter);
    let iso = |along: [f64; 2], scallop: f64| {
        let spacing = Spacing::Scallop(scallop);
        task.plan(&IsoParametric { label: Label::Surface, range: [0.2, 0.21], along, spacing }).map(|l| l.len())
    };
    for along in [[0.1, 0.1], [-0.1, 0.5], [0.0, f64::NAN]] {
        assert!(matches!(iso(along, 0.01), Err(PathError::Value { .. })), "{along:?}");
    }
    assert!(matches!(iso([0.1, 0.9], 0.0), Err(PathError::Value { name: "the scallop in mm", .. })));
    assert!(matches!(iso([0.1, 0.9], 4.0), Err(PathError::NoSideStep { .. })), "higher than the ball's radius");
    // A flat mill along the normal of a flat side leaves no ridge that a circle describes.
    let flat = PathCutter::new(Cutter::flat(6.0).unwrap().bodies(20.0).unwrap().remove(0));
    let sine = ClosedSurface::new(Sine { steepness: 1e-9, ..Sine::gentle() });
    let standing = Task { surface: &sine, cutter: &flat, rule: &AxisRule::Normal, ..task };
    let spacing = Spacing::Scallop(0.01);
    let result = standing.plan(&IsoParametric { label: Label::Surface, range: [0.2, 0.3], along: [0.1, 0.2], spacing });
    assert!(result.is_err(), "{result:?}");
    let open = Task { surface: &sine, ..task };
    let spacing = Spacing::At(vec![1.0]);
    let quasi = QuasiCircle { focus_inside: 0.0, trailing: 0.0, range: [0.0, 1.0], along: [0.0, 1.0], spacing };
    assert!(matches!(quasi.lines(&open), Err(PathError::NoLine { .. })), "an open face has no edges");
}
