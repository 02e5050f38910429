//! Probing motions with their answers: where they end, what the program then reads, and what it may not.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{Command, Contact, Dialect, Met, Op, Program, Settings, Touch, TouchList};

fn settings(dialect: Dialect, touches: &[Touch]) -> Settings {
    Settings { dialect, touches: Some(touches.iter().copied().collect()), ..Settings::default() }
}

fn after(share: f64) -> Touch {
    Touch { met: Met::After(share), at_start: false, ball_radius: 3.0 }
}

const MISSED: Touch = Touch { met: Met::Nothing, at_start: false, ball_radius: 3.0 };

/// Probing motions with their ends, and ends of the others.
type Ends = (Vec<(Contact, [f64; 3])>, Vec<[f64; 3]>);

/// Ends of the probing and of the other motions, in work coordinates.
fn ends(commands: &[Command]) -> Ends {
    let (mut probed, mut others) = (Vec::new(), Vec::new());
    for command in commands {
        match &command.op {
            Op::Probe(p) => probed.push((p.contact, p.motion.end.xyz().unwrap())),
            Op::Rapid(m) | Op::Linear(m) => others.push(m.end.xyz().unwrap_or([f64::NAN; 3])),
            _ => {}
        }
    }
    (probed, others)
}

fn read(text: &str, settings: &Settings) -> Ends {
    let program = Program::from_text("probe", text, settings).unwrap();
    ends(&program.collect::<Result<Vec<_>, _>>().unwrap_or_else(|e| panic!("{e}")))
}

/// Code, line and text of the fault that ends a program.
fn fault(text: &str, settings: &Settings) -> (&'static str, u32, String) {
    let program = Program::from_text("probe", text, settings).unwrap();
    let fault = program.filter_map(Result::err).next().expect("it is refused");
    (fault.code, fault.line, fault.message.clone())
}

#[test]
fn a_skip_ends_where_the_probe_switches_and_the_program_goes_on_from_there() {
    // From X0 to X30 against a face at X20 with a ball of 6 mm: 17 of 30 mm.
    let text =
        "G21 G90 G54\nG0 X0. Y5. Z-2.\nG31 X30. F100\n#100=#5061+3.\nG91 G1 X-1. F200\nG90 X[#100] Y[#5062+1.]\nM30\n";
    let (probed, others) = read(text, &settings(Dialect::Fanuc, &[after(17.0 / 30.0)]));
    assert_eq!(probed.len(), 1);
    assert_eq!(probed[0].0, Contact::Touched);
    assert!((probed[0].1[0] - 17.0).abs() < 1e-12 && probed[0].1[1..] == [5.0, -2.0]);
    assert!((others[1][0] - 16.0).abs() < 1e-12, "the increment counts from the touch: {others:?}");
    assert!((others[2][0] - 20.0).abs() < 1e-12 && (others[2][1] - 6.0).abs() < 1e-12, "{others:?}");
    // In inch the variables are inch.
    let inch = "G20 G90 G54\nG0 X0. Y0. Z0.\nG31 X3. F10.\nG1 X[#5061-1.]\nM30\n";
    let (_, others) = read(inch, &settings(Dialect::Fanuc, &[after(0.5)]));
    assert!((others[1][0] - 0.5 * 25.4).abs() < 1e-9, "{others:?}");
}

#[test]
fn a_branch_follows_what_is_measured_under_a_turned_frame_too() {
    let text = "G21 G90 G54\nG68 X0. Y0. R90.\nG0 X0. Y0. Z0.\nG31 X10. F100\nIF [#5061 GT 4.] GOTO 10\nG1 Y1.\nGOTO 20\n\
                N10 G1 Y2.\nN20 M30\n";
    let far = read(text, &settings(Dialect::Fanuc, &[after(0.5)])).1;
    assert_eq!(far.last().unwrap()[1], 2.0);
    let near = read(text, &settings(Dialect::Fanuc, &[after(0.3)])).1;
    assert_eq!(near.last().unwrap()[1], 1.0);
}

#[test]
fn without_an_answer_the_run_waits_and_goes_on_when_it_comes() {
    let touches = TouchList::default();
    let settings = Settings { dialect: Dialect::LinuxCnc, touches: Some(touches.clone()), ..Settings::default() };
    let text = "G21 G90\nG0 X0 Y0 Z10\nG38.2 Z-10 F50\n#1=#5063\nG38.3 X5\nG1 Z[#1+#5070]\nM2\n";
    let mut program = Program::from_text("probe.ngc", text, &settings).unwrap();
    let asked = program.by_ref().map(Result::unwrap).last().unwrap();
    assert!(matches!(asked.op, Op::Probe(ref p) if p.contact == Contact::Asked), "{asked:?}");
    assert!(program.waits_for_probe());
    assert!(program.next().is_none(), "it does not go on by itself");
    touches.push(after(0.25));
    let rest: Vec<Command> = program.by_ref().map(Result::unwrap).collect();
    let (probed, _) = ends(&rest);
    assert_eq!(probed, [(Contact::Touched, [0.0, 0.0, 5.0]), (Contact::Asked, [5.0, 0.0, 5.0])]);
    touches.push(MISSED);
    let rest: Vec<Command> = program.by_ref().map(Result::unwrap).collect();
    let (probed, others) = ends(&rest);
    assert_eq!(probed, [(Contact::Missed, [5.0, 0.0, 5.0])]);
    assert_eq!(others, [[5.0, 0.0, 5.0]], "#5070 is 0 after a miss");
    assert!(!program.waits_for_probe());
    // The complete list gives the same commands at once.
    let again = Program::from_text("probe.ngc", text, &settings).unwrap();
    assert_eq!(again.map(Result::unwrap).filter(|c| matches!(c.op, Op::Probe(_))).count(), 2);
}

#[test]
fn misses_are_what_the_control_makes_of_them() {
    let at = |word: &str, touch: Touch| {
        let text = format!("G21 G90\nG0 X0 Y0 Z10\n{word} Z-10 F50\nM2\n");
        let program = Program::from_text("probe.ngc", text, &settings(Dialect::LinuxCnc, &[touch])).unwrap();
        program.filter_map(Result::err).next().map(|f| (f.code, f.line))
    };
    let touching = Touch { at_start: true, ..after(0.0) };
    assert_eq!(at("G38.2", after(0.5)), None);
    assert_eq!(at("G38.2", MISSED), Some(("nc-probe", 3)));
    assert_eq!(at("G38.3", MISSED), None);
    assert_eq!(at("G38.4", MISSED), Some(("nc-probe", 3)));
    assert_eq!(at("G38.5", MISSED), None);
    assert_eq!(at("G38.2", touching), Some(("nc-probe", 3)), "the probe is already tripped");
    assert_eq!(at("G38.4", touching), Some(("nc-probe", 3)), "the probe does not touch");
    // G31 of a Fanuc ends where it was sent, and the program reads that position.
    let text = "G21 G90\nG0 X0. Y0. Z10.\nG31 Z-10. F50\nG1 X[#5063]\nM30\n";
    let (probed, others) = read(text, &settings(Dialect::Fanuc, &[MISSED]));
    assert_eq!(probed[0], (Contact::Missed, [0.0, 0.0, -10.0]));
    assert_eq!(others.last().unwrap()[0], -10.0);
}

#[test]
fn a_result_is_not_read_before_it_is_measured() {
    let (code, line, text) = fault("G21 G90\nG0 X0. Y0. Z0.\nG1 X[#5061] F100\nM30\n", &settings(Dialect::Fanuc, &[]));
    assert_eq!((code, line), ("nc-probe", 3));
    assert!(text.contains("#5061 is read before"), "{text}");
    // Without a stylus in the spindle nothing is known afterwards either.
    let text = "G21 G90\nG0 X0. Y0. Z0.\nG31 X9. F100\nG1 X[#5061]\nM30\n";
    let (code, line, _) = fault(text, &settings(Dialect::Fanuc, &[Touch::default()]));
    assert_eq!((code, line), ("nc-probe", 4));
    let unmeasured = Settings { dialect: Dialect::Fanuc, ..Settings::default() };
    assert_eq!(fault(text, &unmeasured).0, "nc-probe");
    // A way that begins at an unknown place.
    let (code, line, _) = fault("G21 G90\nG0 X0. Y0.\nG31 Z-9. F100\nM30\n", &settings(Dialect::Fanuc, &[MISSED]));
    assert_eq!((code, line), ("nc-position-unknown", 3));
    // Under cutter compensation the control refuses to probe.
    let text = "G21 G90 G17\nG0 X0. Y0. Z0.\nG41 D1 G1 X5. F100\nG31 X9.\nM30\n";
    assert_eq!(fault(text, &settings(Dialect::Fanuc, &[MISSED])).0, "nc-probe");
}

#[test]
fn meas_deletes_the_rest_of_the_way_and_meaw_runs_on() {
    let text = |word: &str| {
        format!(
            "G17 G710 G90 G94\nTRANS X100\nG0 X0 Y0 Z10\n{word} G1 Z-10 F50\nSTOPRE\nIF $AC_MEA[1]==0 GOTOF MISS\n\
                 R1=$AA_MW[Z]\nG1 Z=R1+1\nMISS:\nG0 X7\nM30\n"
        )
    };
    let of = |word: &str, touch: Touch| read(&text(word), &settings(Dialect::Siemens840d, &[touch]));
    let (probed, others) = of("MEAS=1", after(0.25));
    assert_eq!(probed, [(Contact::Touched, [0.0, 0.0, 5.0])]);
    assert_eq!(others[1..], [[0.0, 0.0, 6.0], [7.0, 0.0, 6.0]]);
    let (probed, others) = of("MEAW=1", after(0.25));
    assert_eq!(probed, [(Contact::Touched, [0.0, 0.0, 5.0])]);
    assert_eq!(others[1..], [[0.0, 0.0, -10.0], [0.0, 0.0, 6.0], [7.0, 0.0, 6.0]]);
    let (probed, others) = of("MEAS=1", MISSED);
    assert_eq!(probed, [(Contact::Missed, [0.0, 0.0, -10.0])]);
    assert_eq!(others[1..], [[7.0, 0.0, -10.0]]);
    // Bad words.
    let bad = |block: &str, touch: Touch| {
        let text = format!("G17 G710 G90 G94\nG0 X0 Y0 Z10\n{block}\nM30\n");
        fault(&text, &settings(Dialect::Siemens840d, &[touch]))
    };
    assert_eq!(bad("MEAS=3 G1 Z-10 F50", MISSED).0, "nc-bad-value");
    assert_eq!(bad("MEAS=1 G0 Z-10", MISSED).0, "nc-conflicting-words");
    assert_eq!(bad("MEAS=1 MEAW=1 G1 Z-10 F50", MISSED).0, "nc-conflicting-words");
    assert_eq!(bad("MEAS=1", MISSED).0, "nc-conflicting-words");
    assert_eq!(bad("R1=$AA_MW[Z]", MISSED).0, "nc-probe");
    assert_eq!(
        bad("MEAS=1 G1 Z-10 F50\nR1=$AA_MW[Z]", MISSED),
        ("nc-probe", 4, "$AA_MW is read, and the probe has not switched".to_owned())
    );
}
