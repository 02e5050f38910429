//! The depth that a program names is reached: all drilling cycles of the four languages, and reversals of
//! every other kind.

use std::path::Path;

use crate::common::{Program, Random, bc_machine, for_all, motion, run_with, tool};
use proveout_controller::{Chunk, Controller, MoveKind, Settings};
use proveout_machine::Machine;
use proveout_nc::{AxisValues, Dialect, Op, Program as NcProgram, Settings as NcSettings};

/// A place that is reached is reached to rounding of positions of some hundred millimeters.
const REACHED: f64 = 1e-9;

/// A program with one cycle, and the lowest Z of its holes.
struct Hole {
    dialect: Dialect,
    text: String,
    lowest: f64,
}

fn iso(dialect: Dialect, cycle: &str, lowest: f64) -> Hole {
    let head = match dialect {
        Dialect::LinuxCnc => "G21 G90 G17 G94 G64 P0.02\nT1 M6\nS600 M3\nG0 X0 Y0 Z20\n",
        _ => "%\nO1\nG21 G90 G17 G94\nT1 M6\nS600 M3\nG0 X0. Y0. Z20.\n",
    };
    let tail = if dialect == Dialect::LinuxCnc { "G80\nM2\n" } else { "G80\nM30\n%\n" };
    Hole { dialect, text: format!("{head}{cycle}\n{tail}"), lowest }
}

fn siemens(cycle: &str, lowest: f64) -> Hole {
    let text = format!("G17 G90 G94 G710 G64\nT1\nM6\nS600 M3\nF200\nG0 X0 Y0 Z20\n{cycle}\nM30\n");
    Hole { dialect: Dialect::Siemens840d, text, lowest }
}

fn heidenhain(cycle: &str, lowest: f64) -> Hole {
    let text = format!(
        "0 BEGIN PGM HOLE MM\n1 TOOL CALL 1 Z S600 F200\n2 L X+0 Y+0 Z+20 R0 FMAX M3\n3 {cycle}\n4 L X+10 Y+10 FMAX M99\n\
         5 L X+20 FMAX M99\n6 M30\n7 END PGM HOLE MM\n"
    );
    Hole { dialect: Dialect::Heidenhain, text, lowest }
}

fn apt(cycle: &str, lowest: f64) -> Hole {
    let text = format!(
        "UNITS/MM\nLOADTL/1\nSPINDL/600,CLW\nFEDRAT/200,MMPM\nRAPID\nGOTO/0,0,20\n{cycle}\nGOTO/10,0,0\nGOTO/20,5,0\n\
         CYCLE/OFF\nRAPID\nGOTO/0,0,20\nFINI\n"
    );
    Hole { dialect: Dialect::Apt, text, lowest }
}

/// Every drilling cycle that a language has, in each of its courses.
fn holes() -> Vec<Hole> {
    let mut all = Vec::new();
    for dialect in [Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc] {
        for back in ["G98", "G99"] {
            let mut with = |cycle: &str, lowest: f64| {
                // Dwells: seconds on a LinuxCNC, milliseconds on the others.
                let mut cycle = if dialect == Dialect::LinuxCnc { cycle.replace("P200", "P0.2") } else { cycle.into() };
                // A LinuxCNC asks for the dwell of G86, and for a spindle that turns to the left before G74.
                if dialect == Dialect::LinuxCnc {
                    cycle = cycle.replace("G86 X10. Z-5.3 R2.", "G86 X10. Z-5.3 R2. P0.2");
                }
                let before = if dialect == Dialect::LinuxCnc && cycle.starts_with("G74") { "M4\n" } else { "" };
                all.push(iso(dialect, &format!("{before}{back} {cycle}"), lowest));
            };
            with("G81 X10. Y0. Z-5.3 R2. F100.\nX20.", -5.3);
            with("G82 X10. Z-5.3 R2. P200 F100.\nX20. Y3.", -5.3);
            with("G83 X10. Z-5.3 R2. Q1.7 F100.\nX20.", -5.3);
            with("G73 X10. Z-5.3 R2. Q1.7 F100.\nX20.", -5.3);
            with("G84 X10. Z-5.3 R2. F600.\nX20.", -5.3);
            with("G74 X10. Z-5.3 R2. F600.\nX20.", -5.3);
            with("G85 X10. Z-5.3 R2. F100.\nX20.", -5.3);
            with("G86 X10. Z-5.3 R2. F100.\nX20.", -5.3);
            with("G89 X10. Z-5.3 R2. P200 F100.\nX20.", -5.3);
            with("G85 X10. Z-0.004 R0.003 F4000.\nX20.", -0.004);
            if dialect != Dialect::LinuxCnc {
                with("G76 X10. Z-5.3 R2. Q0.5 F100.\nX20.", -5.3);
            }
        }
    }
    all.push(iso(Dialect::Fanuc, "G98 G87 X10. Z5. R-10. Q1. F100.", -10.0));
    all.push(iso(Dialect::Haas, "G98 G77 X10. Z5. R-10. Q1. F100.", -10.0));
    all.push(iso(Dialect::Haas, "G98 G83 X10. Z-5.3 R2. I2. J0.5 K0.7 F100.", -5.3));
    all.push(iso(Dialect::Fanuc, "G91 G99 G81 X5. Z-3. R-19. K3 F100.", -2.0));
    for cycle in [
        "CYCLE81(15,0,2,-6.1)",
        "CYCLE82(15,0,2,-6.1,,0.3)",
        "CYCLE82(15,0,2,-6.1)",
        "CYCLE83(15,0,2,-6.1,,-2,,0.5,0,0,1,0)",
        "CYCLE83(15,0,2,-6.1,,-2,,0.5,0.1,0.1,0.5,1)",
        "CYCLE84(15,0,2,-6.1,,0,3,,1)",
        "CYCLE84(15,0,2,-6.1,,,3,,1,0,300,300,0,1,,1,2,0.5)",
        "CYCLE84(15,0,2,-6.1,,,3,,1,0,300,300,0,1,,2,2,0.5)",
        "CYCLE840(15,0,2,-6.1,,0,4,3,1,,1)",
        "CYCLE85(15,0,2,-6.1,,0,100,300)",
        "CYCLE85(15,0,2,-6.1,,0.5,100,100)",
        "CYCLE86(15,0,2,-6.1,,0,3,0.4,0.3,0.2,0)",
        "CYCLE86(15,0,2,-6.1,,0.2,3,0.4,0,0,0)",
        "CYCLE87(15,0,2,-6.1,,3)",
        "CYCLE88(15,0,2,-6.1,,0,3)",
        "CYCLE89(15,0,2,-6.1,,0)",
        "MCALL CYCLE81(15,0,2,-6.1)\nHOLES1(0,0,90,10,5,3)\nHOLES2(0,0,10,0,0,4)\nMCALL",
        "MCALL CYCLE83(15,0,2,-6.1,,-2,,0.5,0,0,1,1)\nX5 Y5\nX9\nMCALL",
        "G1 Z-6.1\nZ3",
        "G1 Z-6.1\nG0 Z3",
        "G641 ADIS=0.5\nG1 Z-6.1\nZ3",
        "CYCLE832(0.1,3,1)\nG1 Z-6.1 F3000\nZ3\nZ-6.1\nZ3",
        "G332 Z2 K1\nG331 Z-6.1 K1\nG332 Z2 K1",
        "G0 Z0\nG91\nREPEATB DOWN P=20\nDOWN: G1 Z-0.305\nG90 Z5",
    ] {
        // The last one goes down in short blocks: 21 of 0.305.
        let lowest = if cycle.contains("REPEATB") { f64::NAN } else { -6.1 };
        all.push(siemens(cycle, lowest));
    }
    let words = |list: &str| list.to_owned();
    for (cycle, lowest) in [
        (words("CYCL DEF 200 DRILLING Q200=2 Q201=-7.2 Q206=250 Q202=3 Q210=0 Q203=+0 Q204=20 Q211=0"), -7.2),
        (words("CYCL DEF 200 DRILLING Q200=2 Q201=-7.2 Q206=250 Q202=3 Q210=0.2 Q203=+1 Q204=20 Q211=0.2"), -6.2),
        (words("CYCL DEF 201 REAMING Q200=2 Q201=-7.2 Q206=100 Q211=0 Q208=400 Q203=+0 Q204=20"), -7.2),
        (words("CYCL DEF 202 BORING Q200=2 Q201=-7.2 Q206=100 Q211=0 Q208=300 Q203=+0 Q204=20 Q214=1 Q336=0"), -7.2),
        (words("CYCL DEF 202 BORING Q200=2 Q201=-7.2 Q206=100 Q211=0 Q208=0 Q203=+0 Q204=20 Q214=0 Q336=0"), -7.2),
        (
            words(
                "CYCL DEF 203 UNIVERSAL DRILLING Q200=2 Q201=-7.2 Q206=150 Q202=3 Q210=0 Q203=+0 Q204=0 Q212=1 Q213=1 \
                 Q205=1 Q211=0 Q208=MAX Q256=0.2",
            ),
            -7.2,
        ),
        (
            words(
                "CYCL DEF 205 UNIVERSAL PECKING Q200=2 Q201=-7.2 Q206=150 Q202=3 Q203=+0 Q204=10 Q212=0 Q205=0 Q258=0.5 \
                 Q259=1 Q257=2 Q256=0.2 Q211=0 Q379=1 Q253=750",
            ),
            -7.2,
        ),
        (
            words(
                "CYCL DEF 204 BACK BORING Q200=1 Q249=3 Q250=4.5 Q251=1.5 Q252=1.7 Q253=750 Q254=200 Q255=0 Q203=+0 Q204=20 \
                 Q214=1 Q336=0",
            ),
            -7.2,
        ),
        (words("CYCL DEF 206 TAPPING Q200=2 Q201=-7.2 Q206=600 Q211=0 Q203=+0 Q204=20"), -7.2),
        (words("CYCL DEF 207 RIGID TAPPING Q200=2 Q201=-7.2 Q239=+1 Q203=+0 Q204=20"), -7.2),
        (
            words("CYCL DEF 209 TAPPING W/ CHIP BRKG Q200=2 Q201=-7.2 Q239=+1 Q203=+0 Q204=20 Q257=3 Q256=1 Q336=0"),
            -7.2,
        ),
        (words("CYCL DEF 240 CENTERING Q200=2 Q343=0 Q201=-7.2 Q344=0 Q206=200 Q211=0 Q203=+0 Q204=10"), -7.2),
        (
            words(
                "CYCL DEF 241 SINGLE-LIP D.H.DRLNG Q200=2 Q201=-7.2 Q206=150 Q211=0 Q203=+0 Q204=10 Q379=1.5 Q253=750 \
                 Q208=1000 Q426=3 Q427=25 Q428=500 Q429=8 Q430=9 Q435=0",
            ),
            -7.2,
        ),
        (
            words(
                "CYCL DEF 1.0 PECKING\n4 CYCL DEF 1.1 SET UP 2\n5 CYCL DEF 1.2 DEPTH -7.2\n6 CYCL DEF 1.3 PECKG 3\n\
                 7 CYCL DEF 1.4 DWELL 0\n8 CYCL DEF 1.5 F80\n9 L Z+2 FMAX",
            ),
            -7.2,
        ),
        (
            words(
                "CYCL DEF 2.0 TAPPING\n4 CYCL DEF 2.1 SET UP 2\n5 CYCL DEF 2.2 DEPTH -7.2\n6 CYCL DEF 2.3 DWELL 0\n\
                 7 CYCL DEF 2.4 F600\n8 L Z+2 FMAX",
            ),
            -7.2,
        ),
        (
            words(
                "CYCL DEF 17.0 RIGID TAPPING\n4 CYCL DEF 17.1 SET UP 2\n5 CYCL DEF 17.2 DEPTH -7.2\n6 CYCL DEF 17.3 PITCH +1\n\
                 7 L Z+2 FMAX",
            ),
            -7.2,
        ),
    ] {
        all.push(heidenhain(&cycle, lowest));
    }
    for (cycle, lowest) in [
        ("CYCLE/DRILL,RAPTO,3,FEDTO,-8.4,RTRCTO,AUTO,MMPM,100", -8.4),
        ("CYCLE/DRILL,8.4,MMPM,60,2", -8.4),
        ("CYCLE/FACE,FEDTO,-8.4,CLEAR,2,DWELL,0.2", -8.4),
        ("CYCLE/DEEP,8.4,INCR,3,MMPM,50,2", -8.4),
        ("CYCLE/DRILL,BRKCHP,FEDTO,-8.4,STEP,3,CLEAR,2,RTRCTO,8", -8.4),
        ("CYCLE/BORE,8.4,MMPR,0.1,1", -8.4),
        ("CYCLE/REAM,8.4,MMPM,100,1", -8.4),
        ("CYCLE/TAP,8.4,MMPM,600,2", -8.4),
    ] {
        all.push(apt(cycle, lowest));
    }
    all
}

fn three_axis() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/three-axis-mill");
    Machine::read(&folder).expect("library machine")
}

/// Places at which a row of values turns back, with both ends.
fn turns(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::new();
    for z in values {
        if out.last().is_some_and(|last| (z - last).abs() < 1e-12) {
            continue;
        }
        if let [.., a, b] = out[..]
            && (b - a) * (z - b) > 0.0
        {
            out.pop();
        }
        out.push(z);
    }
    out
}

/// Z of the programmed motions, from the first one that names it on.
fn programmed_z(text: &str, dialect: Dialect) -> Vec<f64> {
    let settings = NcSettings { dialect, ..NcSettings::default() };
    let program = NcProgram::from_text("hole.nc", text, &settings).expect("readable");
    let z = AxisValues::index('Z').expect("an axis");
    let ends = program.filter_map(|command| match command.expect("no fault").op {
        Op::Rapid(m) | Op::Linear(m) => m.end_base.get(z),
        Op::Thread(t) => t.motion.end_base.get(z),
        _ => None,
    });
    ends.collect()
}

fn executed(text: &str, dialect: Dialect, machine: &Machine, settings: &Settings) -> Chunk {
    let nc = NcSettings { dialect, ..NcSettings::default() };
    let program = NcProgram::from_text("hole.nc", text, &nc).expect("readable");
    // Without a length the slide is where the program says.
    let tools = [tool(1, 0.0)];
    let mut controller = Controller::new(program, machine, &tools, settings.clone()).expect("good settings");
    let mut all = Chunk::default();
    loop {
        match controller.next_chunk() {
            Ok(Some(chunk)) => {
                all.pieces.extend(chunk.pieces);
                all.blocks.extend(chunk.blocks);
            }
            Ok(None) => return all,
            Err(e) => panic!("{text}\n{e}"),
        }
    }
}

#[test]
fn every_drilling_cycle_of_every_language_reaches_every_depth_that_it_names() {
    let mut machine = three_axis();
    let z = machine.joint("Z").expect("Z");
    machine.control.tool_change_position[z] = None;
    machine.joints[z].travel = None;
    let mut quick = machine.clone();
    quick.control.spindle_start_time = 0.0;
    let list = holes();
    assert!(list.len() > 100, "{}", list.len());
    for_all(0..list.len() as u64, |k| {
        let Hole { dialect, text, lowest } = &list[k as usize];
        let wanted = programmed_z(text, *dialect);
        let low = wanted.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(lowest.is_nan() || (low - lowest).abs() < 1e-9, "the reader goes to {low}, not to {lowest}:\n{text}");
        // A spindle that takes its time, one that takes none, a rough tolerance where the program states
        // none.
        for (machine, default_tolerance) in [(&machine, None), (&quick, None), (&quick, Some(0.5))] {
            let settings = Settings { default_tolerance, ..Settings::default() };
            let run = executed(text, *dialect, machine, &settings);
            let home = machine.home()[z];
            let reached = turns(run.pieces.iter().flat_map(|p| [p.joints[0][z], p.joints[1][z]]));
            let wanted = turns(std::iter::once(home).chain(wanted.iter().copied()));
            let close =
                wanted.len() == reached.len() && wanted.iter().zip(&reached).all(|(a, b)| (a - b).abs() <= REACHED);
            assert!(close, "{text}\nwanted {wanted:?}\nreached {reached:?}");
        }
    });
}

/// A corner of each kind that turns back, at the end of `from` and the begin of `to`; the point must be on
/// the path that is run.
#[test]
fn corners_that_turn_back_by_170_degrees_and_more_are_reached() {
    let machine = bc_machine();
    let settings = Settings::default();
    let mut stopped = 0;
    for degrees in [180.0_f64, 179.9, 176.0, 172.0, 170.5, 169.0, 150.0, 120.0] {
        let heading = std::f64::consts::PI - degrees.to_radians();
        for (first, second) in [(10.0, 10.0), (10.0, 0.01), (0.01, 10.0), (0.02, 0.02), (0.5, 300.0)] {
            for kinds in 0..4 {
                let tip = [30.0, 20.0];
                let begin = [tip[0], tip[1] + first];
                let end = [tip[0] + second * heading.sin(), tip[1] + second * heading.cos()];
                let mut program = Program::default().g0(&[('X', begin[0]), ('Y', begin[1])]).exact_stop().feed(50.0);
                program = program.g1(&[('Z', -1.0)]).continuous(0.05);
                let at = |p: [f64; 2]| [('X', p[0]), ('Y', p[1])];
                program = if kinds & 1 == 0 { program.g1(&at(tip)) } else { program.g0(&at(tip)) };
                program = if kinds & 2 == 0 { program.g1(&at(end)) } else { program.g0(&at(end)) };
                let run = run_with(&program, &machine, &[], &settings);
                let off = |q: &proveout_machine::JointValues| (q[0] - tip[0]).hypot(q[1] - tip[1]);
                let nearest =
                    run.all.pieces.iter().flat_map(|p| p.joints).map(|q| off(&q)).fold(f64::INFINITY, f64::min);
                if degrees >= 170.0 {
                    assert!(
                        nearest <= REACHED,
                        "{degrees} degrees, blocks of {first} and {second} mm: {nearest} mm off"
                    );
                    stopped += 1;
                } else {
                    assert!(nearest <= 0.05 + REACHED, "{degrees}: {nearest}");
                }
            }
        }
    }
    assert_eq!(stopped, 5 * 5 * 4);
    // What lies below the angle is rounded as before.
    let program = Program::default().continuous(0.05).feed(50.0).g1(&[('X', 20.0)]).g1(&[('X', 5.0), ('Y', 9.0)]);
    let run = run_with(&program, &machine, &[], &settings);
    assert!(run.summary.max_contour_error_mm > 1e-3, "{}", run.summary.max_contour_error_mm);
}

/// Short blocks down and up again, straight and along a curve, with rough tolerances: the fit ends in the
/// turning point.
#[test]
fn fitted_runs_of_short_blocks_reach_their_turning_points() {
    let machine = bc_machine();
    for tolerance in [0.005, 0.05, 0.75] {
        for step in [0.02, 0.1, 0.6] {
            let mut program = Program::default().g0(&[('Z', 8.0)]).continuous(tolerance).feed(40.0);
            let mut points = vec![[0.0, 8.0]];
            // Down on a slight curve, and back on it.
            let down: Vec<[f64; 2]> = (1..=60).map(|k| step * f64::from(k)).map(|s| [0.002 * s * s, 8.0 - s]).collect();
            points.extend(&down);
            points.extend(down.iter().rev().skip(1));
            points.push([0.0, 8.0]);
            for p in &points[1..] {
                program = program.g1(&[('X', p[0]), ('Z', p[1])]);
            }
            let run = run_with(&program, &machine, &[], &Settings::default());
            let cut = run.all.pieces.iter().filter(|p| p.kind == MoveKind::Feed);
            let lowest = cut.flat_map(|p| p.joints).map(|q| q[2]).fold(f64::INFINITY, f64::min);
            assert!((lowest - (8.0 - 60.0 * step)).abs() <= REACHED, "tolerance {tolerance}, step {step}: {lowest}");
            assert!((run.summary.end_position[2] - 8.0).abs() <= REACHED);
        }
    }
}

/// Rotary joints alone, with and without tool center point control; a table that turns back under a slide
/// that goes on; and a slide that goes to and fro over a table that turns, which is a curve on the part and
/// no reversal.
#[test]
fn rotary_joints_that_turn_back_reach_their_angle() {
    let machine = bc_machine();
    let tools = [tool(1, 120.0)];
    let furthest = |program: &Program, joint: usize| {
        let run = run_with(program, &machine, &tools, &Settings::default());
        let most = run.all.pieces.iter().flat_map(|p| p.joints).map(|q| q[joint]).fold(f64::NEG_INFINITY, f64::max);
        (most, run)
    };
    for tcp in [false, true] {
        for rapid in [false, true] {
            let mut program = Program::default().change(1).g0(&[('Z', 300.0)]).tcp(tcp).continuous(0.5).feed(30.0);
            for c in [1.2, 0.3, 1.2, -0.4] {
                program = if rapid { program.g0(&[('C', c)]) } else { program.g1(&[('C', c)]) };
            }
            let (most, run) = furthest(&program, 4);
            assert!((most - 1.2).abs() <= REACHED, "tcp {tcp}, rapid {rapid}: {most}");
            let c: Vec<f64> = turns(run.all.pieces.iter().flat_map(|p| [p.joints[0][4], p.joints[1][4]]));
            let wanted = [0.0, 1.2, 0.3, 1.2, -0.4];
            assert!(c.len() == 5 && c.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= REACHED), "{c:?}");
        }
    }
    // X goes on by little, C turns back under the tool, 60 mm from its axis: the cut turns back.
    let program = Program::default()
        .change(1)
        .g0(&[('X', 65.0), ('Y', -3.0), ('Z', 300.0)])
        .continuous(0.05)
        .feed(5.0)
        .g1(&[('X', 65.5), ('C', 0.8)])
        .g1(&[('X', 66.0), ('C', 0.0)]);
    let (most, _) = furthest(&program, 4);
    assert!((most - 0.8).abs() <= REACHED, "{most}");
    // A cam: C goes on, X comes and goes. The tip against the table turns by little, and nothing stops there.
    let cam = |k: i32| [('X', 65.0 + (0.2 * f64::from(k)).sin()), ('C', 0.05 * f64::from(k))];
    let mut program =
        Program::default().change(1).g0(&[('X', 65.0), ('Y', -3.0), ('Z', 300.0)]).continuous(0.05).feed(2.0);
    for k in 1..=60 {
        program = program.g1(&cam(k));
    }
    let (_, run) = furthest(&program, 4);
    let feeds = run.all.samples.iter().filter(|s| s.kind == MoveKind::Feed && s.block > 5 && s.block < 55);
    let slowest = feeds.map(|s| s.velocity[4].abs()).fold(f64::INFINITY, f64::min);
    assert!(slowest > 0.002, "C stands while X turns back: {slowest}");
}

/// Random plunges: directions of five axes with tool center point control, kinds of motion, tolerances,
/// blocks before and after.
#[test]
fn random_plunges_reach_their_points() {
    let machine = bc_machine();
    let count = std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(120);
    for_all(0..count, |seed| {
        let mut r = Random::new(seed + 4_000);
        let tcp = r.unit() < 0.5;
        let start = [('X', 10.0), ('Y', 5.0), ('Z', 150.0), ('B', r.range(0.1, 0.9)), ('C', r.range(-1.0, 1.0))];
        let mut program = Program::default().change(1).g0(&[('Z', 300.0)]).g0(&start[3..]).tcp(tcp).g0(&start);
        program = program.continuous(10_f64.powf(r.range(-3.0, -0.1))).feed(10_f64.powf(r.range(0.0, 2.3)));
        let (mut points, mut at) = (Vec::new(), [10.0, 5.0, 150.0]);
        for _ in 0..12 {
            let depth = 10_f64.powf(r.range(-2.5, 1.3));
            let axis: [f64; 3] = std::array::from_fn(|_| r.range(-1.0, 1.0));
            let size = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
            let bottom: [f64; 3] = std::array::from_fn(|k| at[k] + depth * axis[k] / size);
            // Back up to a part of the way, to beyond it, or off it by up to 10 degrees.
            let lean = r.range(-0.17, 0.17);
            let back = depth * r.range(0.2, 1.5);
            let side = {
                let s: [f64; 3] = [axis[1], -axis[0], 0.0];
                let n = s[0].hypot(s[1]).max(1e-9);
                s.map(|x| x / n)
            };
            let to: [f64; 3] =
                std::array::from_fn(|k| bottom[k] - back * (lean.cos() * axis[k] / size - lean.sin() * side[k]));
            for (p, rapid) in [(bottom, r.unit() < 0.2), (to, r.unit() < 0.5)] {
                let m = motion(&[('X', p[0]), ('Y', p[1]), ('Z', p[2])]);
                program = program.op(if rapid { Op::Rapid(m) } else { Op::Linear(m) });
            }
            points.push(bottom);
            at = to;
        }
        let run = run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default());
        for p in points {
            let off = |piece: &proveout_controller::Piece| {
                let place = |k: usize| {
                    let q = if tcp { piece.pose[k].tip.coords } else { slides(&piece.joints[k]) };
                    ((q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2) + (q[2] - p[2]).powi(2)).sqrt()
                };
                place(0).min(place(1))
            };
            let nearest = run.all.pieces.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-8, "seed {seed}, tcp {tcp}: {nearest} mm from {p:?}");
        }
    });
}

/// The linear joints, less the tool length that the control adds along Z.
fn slides(q: &proveout_machine::JointValues) -> proveout_geom::Vector {
    proveout_geom::Vector::new(q[0], q[1], q[2] - 120.0)
}
