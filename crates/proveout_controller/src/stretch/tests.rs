use proveout_machine::Machine;

use super::*;
use crate::{
    limits::JointLimits,
    mapping::{ActiveKinematics, Mapping},
    output::MoveKind,
    path::{PathBlock, Tolerance},
    shape::BlockShape,
};

fn machine() -> Machine {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/spinner-u5-620");
    Machine::read(&folder).expect("library machine")
}

fn frame<'a>(machine: &'a Machine, limits: &'a JointLimits) -> PathContext<'a> {
    let mapping = Mapping { tcp_length: None, tool_length: 0.0, edge_length: 0.0 };
    PathContext { kinematics: ActiveKinematics { machine, rig: None, mapping }, limits }
}

/// A zigzag in X and Y with rounded corners.
fn zigzag(frame: &PathContext<'_>, blocks: u32) -> RunPath {
    let mut path = RunPath::starting_with(0);
    let mut from = JointValues::ZERO;
    for k in 0..blocks {
        let mut slope = JointValues::ZERO;
        (slope[0], slope[1]) = if k % 2 == 0 { (0.8, 0.6) } else { (0.8, -0.6) };
        let block = PathBlock {
            index: k,
            shape: BlockShape::Line { from, slope },
            length: 9.0,
            s0: 0.0,
            kind: MoveKind::Feed,
            feed: 150.0,
            feed_programmed: 150.0,
            coupled: false,
            chord: None,
            loose: Some(Tolerance { tip: 0.05, angle: 0.01 }),
            stands: false,
            corner: Some(Tolerance { tip: 0.05, angle: 0.01 }),
            tip_moves: true,
            told: None,
            file: std::sync::Arc::from("test"),
            line: k,
        };
        from = from + slope * 9.0;
        assert!(path.push(frame, block));
    }
    path
}

/// Plans the first window, and returns it with the rest of the path and the clock there.
fn first_window(frame: &PathContext<'_>) -> (RunPath, PlanStretch, Clock) {
    let mut path = zigzag(frame, 60);
    let start = Clock { cycle: 0.002, start: 0.0, before: [JointValues::ZERO; REACH] };
    let Outcome::Planned(stretch) =
        plan(&mut path, frame, start, 0.0, (&LawEntry::default(), &mut Stages::default()), false)
    else {
        panic!("the first window is planned")
    };
    path.drop_before(stretch.s_end, stretch.cells);
    let n = stretch.samples.len();
    let before = [n - 3, n - 2, n - 1].map(|k| stretch.samples[k].q);
    let clock = Clock { cycle: 0.002, start: stretch.law.duration, before };
    (path, *stretch, clock)
}

#[test]
#[ignore = "nightly, 26 s"]
fn where_a_window_fails_the_reserve_leads_to_rest_within_the_limits() {
    let machine = machine();
    let limits = JointLimits::new(&machine);
    let frame_as_it_was = frame(&machine, &limits);
    let (mut path, stretch, clock) = first_window(&frame_as_it_was);
    assert!(stretch.v_end > 0.0);
    // Limits fall to a tenth under way: the speed at the begin passes them, and no law can mend that.
    let mut low = limits;
    for i in 0..low.count {
        (low.velocity[i], low.rapid[i]) = (0.02 * low.velocity[i], 0.02 * low.rapid[i]);
    }
    let weak = frame(&machine, &low);
    assert!(matches!(
        plan(&mut path, &weak, clock, stretch.v_end, (&stretch.entry, &mut Stages::default()), false),
        Outcome::Failed
    ));
    path.finish(&frame_as_it_was);
    assert!(matches!(
        plan(&mut path, &weak, clock, stretch.v_end, (&stretch.entry, &mut Stages::default()), true),
        Outcome::Failed
    ));
    let reserve = stretch.reserve.expect("a reserve").stretch(&path, &frame_as_it_was, clock);
    let stands = reserve.samples.last().map(|m| m.q);
    assert!(
        over_limits(
            &limits,
            [0.002, reserve.samples[0].time],
            &clock.before,
            &reserve.samples,
            stands.as_ref(),
            PROMISED
        )
        .is_empty()
    );
    let end = reserve.law.end();
    assert!((end.s - reserve.s_end).abs() < 1e-9 && reserve.v_end == 0.0);
    let last = reserve.samples.last().expect("samples").state;
    assert!(last.v < 10.0, "the machine comes to rest: {}", last.v);
    // From there the rest is planned again.
    let n = reserve.samples.len();
    let before = [n - 2, n - 1, n - 1].map(|k| reserve.samples[k].q);
    path.drop_before(reserve.s_end, reserve.cells);
    let clock = Clock { start: clock.start + reserve.law.duration, before, ..clock };
    assert!(matches!(
        plan(&mut path, &frame_as_it_was, clock, 0.0, (&LawEntry::default(), &mut Stages::default()), true),
        Outcome::Planned(_)
    ));
}

#[test]
fn the_reserve_goes_on_where_the_stretch_ends() {
    let machine = machine();
    let limits = JointLimits::new(&machine);
    let (path, stretch, clock) = first_window(&frame(&machine, &limits));
    let end = stretch.law.at(stretch.law.duration, &mut Cursor::default());
    let reserve = stretch.reserve.expect("a reserve");
    let begin = reserve.law.at(0.0, &mut Cursor::default());
    for (a, b, size) in [(end.s, begin.s, 1.0), (end.v, begin.v, 100.0), (end.a, begin.a, 1000.0)] {
        assert!((a - b).abs() < 1e-9 * size, "{end:?} {begin:?}");
    }
    let reserve = reserve.stretch(&path, &frame(&machine, &limits), clock);
    assert!((reserve.samples[0].time - clock.start) < 0.002 && reserve.samples[0].time >= clock.start);
}

#[test]
fn from_rest_to_rest_a_law_is_always_found() {
    let machine = machine();
    let limits = JointLimits::new(&machine);
    let as_it_was = frame(&machine, &limits);
    let mut path = zigzag(&as_it_was, 6);
    path.finish(&as_it_was);
    let start = Clock { cycle: 0.002, start: 0.0, before: [JointValues::ZERO; REACH] };
    // The cells still have the limits of the machine; the joints have less of one kind, or of all.
    for [v, a, j] in [[0.2, 1.0, 1.0], [1.0, 0.1, 1.0], [1.0, 1.0, 0.05], [0.3, 0.2, 0.1]] {
        let mut low = limits;
        for i in 0..low.count {
            (low.velocity[i], low.rapid[i]) = (v * low.velocity[i], v * low.rapid[i]);
            (low.acceleration[i], low.jerk[i]) = (a * low.acceleration[i], j * low.jerk[i]);
        }
        let weak = frame(&machine, &low);
        let Outcome::Planned(stretch) =
            plan(&mut path, &weak, start, 0.0, (&LawEntry::default(), &mut Stages::default()), true)
        else {
            panic!("{v} {a} {j}")
        };
        let over = start.over_limits(&path, &weak, &stretch.samples, true, PROMISED);
        assert!(over.is_empty(), "{v} {a} {j}: {:?}", over.iter().map(|o| o.ratios).next());
    }
}
