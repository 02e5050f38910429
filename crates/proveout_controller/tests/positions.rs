//! Where positions come from: work offsets on machines with their zero on the table and at home, in every
//! structure and language; reference points; what stays where after motions of machine axes under tool
//! center point control.

use std::path::Path;

use crate::common::{Random, for_all, tool};
use proveout_controller::{Chunk, Controller, Dynamics, MoveKind, RunError, Settings};
use proveout_geom::{ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{
    AXIS_LETTERS, AxisValues, Diagnostic, Dialect, Program, ReferencePoints, Settings as NcSettings, WorkOffset,
};

const LENGTH: f64 = 120.0;

fn machine(name: &str) -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name);
    Machine::read(&folder).unwrap_or_else(|e| panic!("{e}"))
}

/// The same machine with its zero on the table and at home, for each structure, with the letter of the
/// tilting joint and the angles that the programs below put there, degrees.
const PAIRS: [(&str, &str, char); 3] = [
    ("bc-trunnion", "bc-trunnion-home-zero", 'B'),
    ("bc-head-table-grinder", "bc-head-table-home-zero", 'B'),
    ("fork-head-gantry", "fork-head-home-zero", 'A'),
];

/// Settings of a reader for a part whose zero is at `zero_in_table`, on this machine.
fn reader(machine: &Machine, dialect: Dialect, zero_in_table: Vector) -> NcSettings {
    let translation = (zero_in_table - machine.program_zero().expect("a common zero").coords).into();
    let offset = WorkOffset { translation, rotary: [0.0; 3] };
    let mut settings = NcSettings { dialect, ..NcSettings::default() };
    for word in ["G54", "PRESET0", "PRESET1"] {
        settings.work_offsets.insert(word.to_owned(), offset);
    }
    let mut points = ReferencePoints { machine: machine.name.clone(), ..ReferencePoints::default() };
    for (index, letter) in AXIS_LETTERS.into_iter().enumerate() {
        if let Some(joint) = machine.joint_for_letter(letter).map(|j| &machine.joints[j]) {
            points.axes |= 1 << index;
            let put = |values: &mut AxisValues, value: Option<f64>| {
                if let Some(value) = value {
                    values.put(index, value);
                }
            };
            put(&mut points.first, joint.first_reference());
            put(&mut points.second, joint.second_reference());
        }
    }
    // Machine coordinates of a retraction to the height of the home position.
    settings.variables.insert("R1".to_owned(), points.first.get(2).expect("Z"));
    settings.variables.insert("M92_Z".to_owned(), points.first.get(2).expect("Z"));
    settings.reference_points = Some(points);
    settings
}

struct Run {
    all: Chunk,
    end: JointValues,
}

fn run(text: &str, machine: &Machine, reader: &NcSettings) -> Result<Run, RunError<Diagnostic>> {
    let program = Program::from_text("p.txt", text, reader).unwrap_or_else(|e| panic!("{e}"));
    let with_length = matches!(program.dialect(), Dialect::Siemens840d | Dialect::Heidenhain);
    let settings = Settings {
        dynamics: Dynamics::Ideal,
        length_active_after_change: with_length,
        length_in_machine_coordinates: program.dialect() != Dialect::Heidenhain,
        spindle_waits: false,
        ..Settings::default()
    };
    let tools = [tool(1, LENGTH)];
    let mut controller = Controller::new(program, machine, &tools, settings).unwrap_or_else(|e| panic!("{e}"));
    let mut all = Chunk::default();
    while let Some(chunk) = controller.next_chunk()? {
        all.pieces.extend(chunk.pieces);
        all.samples.extend(chunk.samples);
        all.events.extend(chunk.events);
        all.blocks.extend(chunk.blocks);
    }
    let end = controller.summary().end_position;
    Ok(Run { all, end })
}

fn runs(text: &str, machine: &Machine, reader: &NcSettings) -> Run {
    run(text, machine, reader).unwrap_or_else(|e| panic!("{}: {e}\n{text}", machine.name))
}

/// Tool pose in the table frame at the end of each line that moves.
fn ends(run: &Run) -> Vec<(u32, ToolPose)> {
    let mut ends: Vec<(u32, ToolPose)> = Vec::new();
    for piece in &run.all.pieces {
        let line = run.all.blocks.iter().find(|b| b.index == piece.block).expect("a record").line;
        match ends.last_mut() {
            Some((last, pose)) if *last == line => *pose = piece.pose[1],
            _ => ends.push((line, piece.pose[1])),
        }
    }
    ends
}

/// Programs in each language: straight and curved motion without tool center point control, with it, in a
/// tilted plane, and ways to the reference point between them. `t` is the letter of the tilting axis.
fn programs(t: char) -> Vec<(Dialect, String)> {
    let iso_head = "G21 G90 G94 G17 G54\nT1 M6\nS1000 M3\n";
    let iso_flat = format!(
        "G0 {t}0 C0\nG43 H1\nG0 X30. Y20. Z80.\nG1 Z50. F2000.\nX40.\nG2 X50. Y30. I0. J10.\nG1 X45. Y35. Z52. C20.\n\
         G0 Z90. C0\nG91 G28 Z0\nG90 G49\n"
    );
    let tcp = |on: &str| {
        format!(
            "G0 {t}20. C15.\n{on}\nG0 X30. Y20. Z80.\nG1 Z50. F2000.\nX45. Y30. {t}35. C40.\nG3 X30. Y45. I-15. J0.\n\
             G91 G1 X5. Z2.\nG90 G0 Z95.\nG91 G28 Z0\nG28 X0 Y0\nG90 G49\nG0 {t}0 C0\n"
        )
    };
    // Repeating a point after the switch moves nothing.
    let repeat = |on: &str| {
        format!(
            "G0 {t}0 C0\nG43 H1\nG0 X50. Y50. Z100.\nG1 Z90. F2000.\nG49\n{on}\nG1 X50. Y50. Z90.\nX51.\nG49\nG91 G28 Z0\nG90\n"
        )
    };
    let plane = format!(
        "G68.2 X10. Y5. Z12. I0. J{} K0.\nG53.1\nG43 H1\nG0 X5. Y6. Z60.\nG1 Z20. F2000.\nG2 X15. Y16. I10. J0.\nG0 Z60.\nG69\nG49\nG91 G28 Z0\nG90\n",
        if t == 'A' { "25." } else { "20." }
    );
    let dynamic =
        format!("G0 {t}30. C10.\nG43 H1\nG254\nG0 X5. Y6. Z60.\nG1 Z30. F2000.\nG0 Z80.\nG255\nG49\nG91 G28 Z0\nG90\n");
    let haas = format!("{iso_head}{iso_flat}{}{}{dynamic}M30\n", tcp("G234 H1"), repeat("G234 H1"));
    let fanuc = format!(
        "{iso_head}{iso_flat}{}{}{plane}G43.5 H1\nG0 X10. Y10. Z70. I0. J0. K1.\nG1 X20. Z50. I0.2 J0.1 K0.9 F2000.\nG49\nG91 G28 Z0\nM30\n",
        tcp("G43.4 H1"),
        repeat("G43.4 H1")
    );
    let linuxcnc =
        format!("{iso_head}{iso_flat}G43 H1\nG0 X0 Y0 Z60\nG5 X20 Y10 I5 J0 P-5 Q0 F2000\nG0 Z90\nG28 Z95\nM2\n");
    let siemens = format!(
        "G17 G54 G90 G94 G710 G64\nT1\nM6\nS1000 M3 D1\nG0 {t}0 C0\nG0 X30 Y20 Z80\nG1 Z50 F2000\nX40\nG2 X50 Y30 I0 J10\n\
         G0 Z90\nSUPA G0 Z=R1 D0\nD1\nG0 X50 Y50 Z100\nTRAORI\nG0 X50 Y50 Z100\nG1 X51 F2000\nG0 {t}20 C15\nORIAXES\n\
         G1 X45 Y30 Z50 {t}35 C40 F2000\nORIVECT\nG1 X30 Y35 Z52 A3=0.2 B3=0.3 C3=0.9\nG3 X20 Y45 I-10 J0\nTRANS X5 Y6 Z7\n\
         AROT Z30\nG1 X30 Y10 Z60\nTRANS\nG0 Z95\nTRAFOOF\nSUPA G0 Z=R1 D0\nD1\nG0 {t}0 C0\n\
         CYCLE800(0,\"TC1\",0,57,10,5,12,{},{},0,0,0,0,1)\nG0 X5 Y6 Z60\nG1 Z20 F2000\nG2 X15 Y16 I10 J0\nG0 Z60\nCYCLE800()\n\
         SUPA G0 Z=R1 D0\nM30\n",
        if t == 'A' { "25" } else { "0" },
        if t == 'A' { "0" } else { "20" }
    );
    let heidenhain = format!(
        "BEGIN PGM P MM\nTOOL CALL 1 Z S1000\nL {t}+0 C+0 R0 FMAX M3\nL X+30 Y+20 Z+80 R0 FMAX\nL Z+50 F2000\nL X+40\n\
         CC X+40 Y+30\nC X+50 Y+30 DR+\nL Z+90 R0 FMAX\nL Z+0 R0 FMAX M92\nL X+50 Y+50 Z+100 R0 FMAX\nM128\n\
         L X+50 Y+50 Z+100 R0 FMAX\nL X+51 F2000\nL X+45 Y+30 Z+50 {t}+35 C+40 F2000\nL Z+95 R0 FMAX\nM140 MB 20\nM129\n\
         L Z+0 R0 FMAX M92\nL {t}+0 C+0 R0 FMAX\nPLANE SPATIAL SPA{} SPB{} SPC+0 TURN FMAX\nL X+5 Y+6 Z+60 R0 FMAX\nL Z+20 F2000\n\
         CC X+15 Y+6\nC X+15 Y+16 DR-\nL Z+60 R0 FMAX\nPLANE RESET STAY\nL Z+0 R0 FMAX M92\nM30\nEND PGM P MM\n",
        if t == 'A' { "+25" } else { "+0" },
        if t == 'A' { "+0" } else { "+20" }
    );
    vec![
        (Dialect::Haas, haas),
        (Dialect::Fanuc, fanuc),
        (Dialect::LinuxCnc, linuxcnc),
        (Dialect::Siemens840d, siemens),
        (Dialect::Heidenhain, heidenhain),
    ]
}

/// One program, one part, two ways to count the axes: the tool goes the same way over the table.
#[test]
fn the_same_program_gives_the_same_tool_poses_whatever_the_zero_of_the_axes() {
    for (at_table, at_home, tilt) in PAIRS {
        let (a, b) = (machine(at_table), machine(at_home));
        let shift = b.program_zero().expect("common") - a.program_zero().expect("common");
        assert!(shift.norm() > 500.0, "{at_home} has its zero at home");
        for (dialect, text) in programs(tilt) {
            // G254 is a matter of tables on tables.
            let text = if at_table == "bc-trunnion" { text } else { without_dynamic_offset(&text) };
            let part = Vector::new(20.0, -15.0, 130.0);
            let (x, y) = (runs(&text, &a, &reader(&a, dialect, part)), runs(&text, &b, &reader(&b, dialect, part)));
            let (x_ends, y_ends) = (ends(&x), ends(&y));
            assert_eq!(x_ends.len(), y_ends.len(), "{at_table} {dialect:?}");
            assert!(x_ends.len() > 8, "{at_table} {dialect:?}: {}", x_ends.len());
            for ((line, p), (other, q)) in x_ends.iter().zip(&y_ends) {
                assert_eq!(line, other);
                // Places of 2 m with 1e-16 of each: 1e-9 mm with room for the arcs.
                assert!((p.tip - q.tip).norm() < 1e-8, "{at_table} {dialect:?} line {line}: {} {}", p.tip, q.tip);
                assert!((p.axis - q.axis).norm() < 1e-12, "{at_table} {dialect:?} line {line}");
            }
            // The slides are at the same place, counted from elsewhere.
            for (name, k) in [("X", 0), ("Y", 1), ("Z", 2)] {
                let (i, j) = (a.joint(name).expect("slide"), b.joint(name).expect("slide"));
                assert!((x.end[i] - y.end[j] - shift[k]).abs() < 1e-8, "{at_table} {dialect:?} {name}");
            }
            // Times follow the joints, whose ways are the same; the plan ends its search within a millionth
            // of the time.
            let total = |r: &Run| r.all.blocks.last().expect("blocks").end_time;
            assert!((total(&x) / total(&y) - 1.0).abs() < 1e-4, "{at_table} {dialect:?}: {} {}", total(&x), total(&y));
        }
    }
}

fn without_dynamic_offset(text: &str) -> String {
    let mut on = false;
    let keep = |line: &&str| {
        on |= *line == "G254";
        let keep = !on;
        on &= *line != "G255";
        keep
    };
    text.lines().filter(keep).fold(String::new(), |all, line| all + line + "\n")
}

/// A part zero at (x, y, z) of the table is where the program's zero goes, with all rotary axes at zero and
/// the tool straight.
#[test]
fn a_work_offset_is_a_point_of_the_table() {
    for (at_table, at_home, tilt) in PAIRS {
        for name in [at_table, at_home] {
            let machine = machine(name);
            let part = Vector::new(33.0, -21.0, 140.0);
            for (dialect, head, on) in [
                (Dialect::Haas, "G21 G90 G54\nT1 M6\nG43 H1\n", "G49\nG234 H1\n"),
                (Dialect::Fanuc, "G21 G90 G54\nT1 M6\nG43 H1\n", "G49\nG43.4 H1\n"),
                (Dialect::Siemens840d, "G54 G90 G64\nT1\nM6\nD1\n", "TRAORI\n"),
                (Dialect::Heidenhain, "BEGIN PGM P MM\nTOOL CALL 1 Z S1000\n", "M128\n"),
            ] {
                let word = |w: &str| {
                    if dialect == Dialect::Heidenhain { format!("L {w} R0 FMAX\n") } else { format!("G0 {w}\n") }
                };
                let zero = word(if dialect == Dialect::Heidenhain { "X+0 Y+0 Z+0" } else { "X0. Y0. Z0." });
                let turn =
                    word(&format!("{tilt}{s}0 C{s}0", s = if dialect == Dialect::Heidenhain { "+" } else { "" }));
                let before = format!("{head}{turn}{zero}");
                let reader = reader(&machine, dialect, part);
                let flat = runs(&before, &machine, &reader);
                let with = runs(&format!("{before}{on}{zero}"), &machine, &reader);
                for run in [&flat, &with] {
                    let tip = machine.forward(&run.end, LENGTH).tip;
                    assert!((tip.coords - part).norm() < 1e-9, "{name} {dialect:?}: {tip}");
                }
                assert!(
                    (flat.end - with.end).max_abs() < 1e-9,
                    "{name} {dialect:?}: X from {} to {}",
                    flat.end[0],
                    with.end[0]
                );
            }
        }
    }
}

/// What a program says of the axes X and Z after a retraction under tool center point control and a turn of
/// the tilting axis: the tip stays on the table where the retraction has brought it.
#[test]
fn behind_a_retraction_under_tcp_the_tool_stays_up() {
    // Language; tool center point control on; a point; retraction of Z to a machine coordinate (@); turns.
    let ways: [(Dialect, &str, &str, &str, &str); 5] = [
        (
            Dialect::Haas,
            "G21 G90 G54\nT1 M6\nG0 @90. C0\nG234 H1\n",
            "G0 X150. Y50. Z10.\n",
            "G53 G0 Z#.\n",
            "G0 @80.\nG0 C30.\n",
        ),
        (
            Dialect::Fanuc,
            "G21 G90 G54\nT1 M6\nG0 @90. C0\nG43.4 H1\n",
            "G0 X150. Y50. Z10.\n",
            "G53 Z#.\n",
            "G0 @80.\nG0 C30.\n",
        ),
        (
            Dialect::Fanuc,
            "G21 G90 G54\nT1 M6\nG0 @90. C0\nG43.4 H1\n",
            "G0 X150. Y50. Z10.\n",
            "G91 G28 Z0\nG90\n",
            "G0 @80.\nG0 C30.\n",
        ),
        (
            Dialect::Siemens840d,
            "G54 G90 G64\nT1\nM6\nD1\nG0 @90 C0\nTRAORI\n",
            "G0 X150 Y50 Z10\n",
            "SUPA G0 Z#\n",
            "G0 @80\nG0 C30\n",
        ),
        (
            Dialect::Heidenhain,
            "TOOL CALL 1 Z S1000\nL @+90 C+0 R0 FMAX\nM128\n",
            "L X+150 Y+50 Z+10 R0 FMAX\n",
            "L Z+# R0 FMAX M91\n",
            "L @+80 R0 FMAX\nL C+30 R0 FMAX\n",
        ),
    ];
    for (at_table, at_home, tilt) in PAIRS {
        for name in [at_table, at_home] {
            let machine = machine(name);
            let z = machine.joint("Z").expect("Z");
            let up = machine.joints[z].home - 10.0;
            for (dialect, head, point, retract, turns) in ways {
                let letter = tilt.to_string();
                let reader = reader(&machine, dialect, Vector::new(-50.0, -50.0, 140.0));
                // `Z+-10` is no Klartext; `Z-10.` and `Z-10` are.
                let retract = retract.replace("+#", &format!("{up:+}")).replace('#', &up.to_string());
                let start = format!("{head}{point}").replace('@', &letter);
                let away = format!("{start}{retract}");
                let turned = format!("{away}{}", turns.replace('@', &letter));
                let (a, b) = (runs(&away, &machine, &reader), runs(&turned, &machine, &reader));
                let (p, q) = (machine.forward(&a.end, LENGTH).tip, machine.forward(&b.end, LENGTH).tip);
                assert!((p - q).norm() < 1e-8, "{name} {dialect:?}: the tip went from {p} to {q}\n{turned}");
                // And on all of the way, not only at its end.
                let last = a.all.blocks.last().expect("blocks").index;
                for piece in b.all.pieces.iter().filter(|piece| piece.block > last) {
                    for pose in &piece.pose {
                        assert!((pose.tip - p).norm() < 1e-3, "{name} {dialect:?}: {} {p}", pose.tip);
                    }
                }
                // The retraction moved the tip along the table, so that the last programmed point is another
                // one.
                let at_point = runs(&start, &machine, &reader).end;
                let before = machine.forward(&at_point, LENGTH).tip;
                assert!((before - p).norm() > 50.0, "{name} {dialect:?}");
                // Only the named axis moved.
                for joint in (0..machine.joints.len()).filter(|&joint| joint != z) {
                    assert_eq!(a.end[joint], at_point[joint], "{name} {dialect:?} {}", machine.joints[joint].name);
                }
            }
        }
    }
}

/// Random positions, random machine axes, random turns; corners: no retraction at all, the pole, quarter
/// turns, over-travel.
#[test]
fn behind_any_machine_motion_under_tcp_the_tip_stays_where_it_is() {
    let machines: Vec<Machine> = PAIRS.iter().flat_map(|(a, b, _)| [machine(a), machine(b)]).collect();
    let cases = std::env::var("PROVEOUT_POSITION_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(48);
    for_all(0..cases, |seed| {
        let mut r = Random::new(seed);
        let machine = &machines[seed as usize % machines.len()];
        let tilt = if machine.joint("A").is_some() { 'A' } else { 'B' };
        let mut angle = |most: f64| {
            let corner = [0.0, 90.0, -90.0, 0.001];
            let pick = r.range(0.0, 8.0) as usize;
            corner.get(pick).copied().unwrap_or_else(|| (r.range(-most, most) * 1e3).round() / 1e3)
        };
        let (b0, c0, b1, c1) = (angle(90.0), angle(180.0), angle(90.0), angle(180.0));
        let (x, y, z) = (r.range(-100.0, 100.0).round(), r.range(-100.0, 100.0).round(), r.range(20.0, 200.0).round());
        let names = ["X", "Y", "Z"];
        let axis = names[seed as usize / 7 % 3];
        let joint = &machine.joints[machine.joint(axis).expect("slide")];
        let [low, high] = joint.travel.expect("travel");
        let to = r.range(low, high).round();
        let part = Vector::new(10.0, 20.0, 130.0);
        for (dialect, text, turn) in [
            (
                Dialect::Haas,
                format!(
                    "G21 G90 G54\nT1 M6\nG0 {tilt}{b0:.3} C{c0:.3}\nG234 H1\nG0 X{x}. Y{y}. Z{z}.\nG53 G0 {axis}{to}.\n"
                ),
                format!("G0 {tilt}{b1:.3} C{c1:.3}\n"),
            ),
            (
                Dialect::Siemens840d,
                format!(
                    "G54 G90 G64\nT1\nM6\nD1\nG0 {tilt}{b0:.3} C{c0:.3}\nTRAORI\nG0 X{x} Y{y} Z{z}\nSUPA G0 {axis}{to} D0\nD1\n"
                ),
                format!("G0 {tilt}{b1:.3} C{c1:.3}\n"),
            ),
            (
                Dialect::Heidenhain,
                format!(
                    "TOOL CALL 1 Z S1000\nL {tilt}{b0:+.3} C{c0:+.3} R0 FMAX\nM128\nL X{x:+} Y{y:+} Z{z:+} R0 FMAX\nL {axis}{to:+} R0 FMAX M91\n"
                ),
                format!("L {tilt}{b1:+.3} C{c1:+.3} R0 FMAX\n"),
            ),
        ] {
            let reader = reader(machine, dialect, part);
            let before = runs(&text, machine, &reader).end;
            let after = runs(&format!("{text}{turn}"), machine, &reader).end;
            let (p, q) = (machine.forward(&before, LENGTH).tip, machine.forward(&after, LENGTH).tip);
            assert!((p - q).norm() < 1e-7, "seed {seed} {} {dialect:?}: {p} {q}\n{text}{turn}", machine.name);
        }
    });
}

/// G28 of every library machine: inside of the travel, the named axis alone, by the programmed point.
#[test]
fn g28_goes_to_the_home_position_of_every_machine() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).expect("machines/") {
        let path = entry.expect("entry").path();
        if !path.is_dir() {
            continue;
        }
        let machine = Machine::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let Some(z) = machine.joint("Z") else { panic!("{} has no Z", machine.name) };
        let [low, high] = machine.joints[z].travel.expect("travel");
        let mut reader = NcSettings { dialect: Dialect::Fanuc, ..NcSettings::default() };
        let mut points = ReferencePoints { machine: machine.name.clone(), ..ReferencePoints::default() };
        for (index, letter) in AXIS_LETTERS.into_iter().enumerate() {
            if let Some(joint) = machine.joint_for_letter(letter).map(|j| &machine.joints[j]) {
                points.axes |= 1 << index;
                points.first.put(index, joint.first_reference().expect("stated"));
            }
        }
        reader.reference_points = Some(points);
        // From the middle of the travel; the intermediate point is a tenth of it further.
        let middle = 0.5 * (low + high);
        let way = 0.1 * (high - low);
        let text = |block: &str| format!("G21 G90\nT1 M6\nG0 Z{middle:.3}\n{block}\n");
        let start = runs(&text(""), &machine, &reader).end;
        let end = runs(&text("G91 G28 Z0"), &machine, &reader);
        assert_eq!(end.end[z], machine.joints[z].home, "{}", machine.name);
        assert!(machine.joints[z].travel_violation(end.end[z]).is_none(), "{}", machine.name);
        for joint in (0..machine.joints.len()).filter(|&joint| joint != z) {
            assert_eq!(end.end[joint], start[joint], "{} {}", machine.name, machine.joints[joint].name);
        }
        // With an increment the way turns at the intermediate point, which the path meets within its
        // tolerance.
        let by = runs(&text(&format!("G91 G28 Z{way:.3}")), &machine, &reader);
        let reached =
            by.all.samples.iter().map(|s| (s.commanded[z] - (middle + way)).abs()).fold(f64::INFINITY, f64::min);
        let on_the_way = (middle + way - start[z]).signum() == (machine.joints[z].home - start[z]).signum();
        // There is a sample every 2 ms; where the axis turns back it comes within the tolerance, where it
        // passes on it is met.
        assert!(reached < if on_the_way { 2.0 } else { 0.02 }, "{}: {reached}", machine.name);
        assert_eq!(by.end[z], machine.joints[z].home, "{}", machine.name);
        // In its text G90 names the point itself.
        let by = runs(&text(&format!("G28 Z{:.3}", middle - way)), &machine, &reader);
        let least = by.all.pieces.iter().filter(|p| p.kind == MoveKind::Rapid).flat_map(|p| p.joints);
        let reached = least.map(|q| (q[z] - (middle - way)).abs()).fold(f64::INFINITY, f64::min);
        assert!(reached < 0.02, "{}: {reached}", machine.name);
        seen += 1;
    }
    assert!(seen >= 18, "{seen} machines");
}

/// Slides that count the motion of the table: an offset would be two points.
#[test]
fn machines_without_a_common_zero_refuse_both_ways_in_one_program() {
    let machine = machine("lu-serial-i");
    let reader = NcSettings { dialect: Dialect::Siemens840d, ..NcSettings::default() };
    let head = "G54 G90\nT1\nM6\nD1\n";
    for (text, refused) in [
        ("G0 X10 Y10 Z-300\nTRAORI\nG0 X20", true),
        ("TRAORI\nG0 X10 Y10 Z30\nTRAFOOF\nG0 X20", true),
        ("TRAORI\nG0 X10 Y10 Z30\nTRAFOOF\nSUPA G0 Z-600\nG0 B10\nTRAORI\nG0 X10 Y10 Z30", false),
        ("G0 X10 Y10 Z-300\nG0 X20", false),
    ] {
        let result = run(&format!("{head}{text}\nM30\n"), &machine, &reader);
        let message = result.err().map(|e| e.to_string()).unwrap_or_default();
        assert_eq!(
            message.contains("lu-serial-i") || message.contains("do not move the tool along"),
            refused,
            "{text}: {message}"
        );
    }
}
