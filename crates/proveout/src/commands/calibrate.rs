use std::{
    fs,
    path::{Path, PathBuf},
};

use proveout_calibrate::{
    AirProgram, Calibration, ColumnsFile, JointReport, Parameter, PlanError, Trace, WordTimes, calibrate,
    calibrated_machine, needs_folder, trace_from_text, with_error,
};
use proveout_machine::Machine;
use proveout_nc::{Dialect, Program, ProgramText, detect};
use proveout_sim::{
    Choice, InputError, Prepared, RunFolder, SimError, control_of,
    finding::{Family, NO_TOOL, Severity},
    read_input, read_regular_text,
    run::{RunResult, run},
    scene::Scene,
    verdict::{Gate, State},
    with_machine,
};

use crate::{
    args::{CalibrateCommand, CalibrateFitArgs, CalibratePlanArgs},
    commands::{
        output_file::{check, put_bytes},
        reader::dialect_of,
    },
    failure::Failure,
};

/// Longest air program, s.
const LONGEST_S: f64 = 600.0;
/// Largest trace, bytes: an hour of ten columns at 1 kHz.
const MAX_TRACE: u64 = 1 << 30;
/// Findings that are shown.
const SHOWN: usize = 5;

pub(crate) fn calibration(command: &CalibrateCommand) -> Result<(), Failure> {
    match command {
        CalibrateCommand::Plan(args) => plan(args),
        CalibrateCommand::Fit(args) => fit(args),
    }
}

fn input(error: InputError) -> Failure {
    Failure::from(&SimError::from(error))
}

fn scene_and_machine(scene: &Path) -> Result<(Scene, Machine), Failure> {
    let scene = Scene::read(scene).map_err(input)?;
    let machine = Machine::read(&scene.resolve(&scene.file.machine)).map_err(input)?;
    Ok((scene, machine))
}

/// `Z=300..610`.
fn range(text: &str) -> Result<(String, [f64; 2]), Failure> {
    let read = || {
        let (name, ends) = text.split_once('=')?;
        let (low, high) = ends.split_once("..")?;
        let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        Some((name.trim().to_owned(), [number(low)?, number(high)?]))
    };
    read().ok_or_else(|| {
        Failure::new(format!("--range {text:?} cannot be read"))
            .with_help("write --range AXIS=LOW..HIGH, such as Z=300..610, in mm or degrees")
    })
}

fn plan(args: &CalibratePlanArgs) -> Result<(), Failure> {
    check(&args.output, args.force)?;
    let (scene, machine) = scene_and_machine(&args.scene)?;
    let ranges = args.range.iter().map(|r| range(r)).collect::<Result<Vec<_>, _>>()?;
    let dialect = match &args.dialect {
        Some(name) => dialect_of(name)?,
        None => match control_of(Some(&scene), &machine).map_err(|e| Failure::from(&e))? {
            Some(control) => control.dialect(),
            None => detect(&args.output.display().to_string(), ""),
        },
    };
    if dialect == Dialect::Auto {
        return Err(Failure::new(
            "neither machine nor scene name a control, and the ending of the file names no language",
        )
        .with_help("name it with --dialect: siemens-840d, heidenhain, fanuc, haas or linuxcnc"));
    }
    let failed = |e: PlanError| Failure::new(e.message).with_help(e.help);
    let program = AirProgram::new(&machine, &ranges).map_err(failed)?;
    let (text, notes) = program.text(&machine, dialect).map_err(failed)?;
    let result = proved(&args.scene, &args.output, &text)?;
    judged(&result)?;
    put_bytes(&args.output, args.force, &text)?;
    say!(
        "{}: {} moves of {} axes in {}, {:.0} s on the twin, nothing found",
        args.output.display(),
        program.steps.len(),
        program.order.len(),
        dialect.name(),
        result.verdict.time.total_s
    );
    for note in notes {
        say!("note: {note}");
    }
    for gate in result.verdict.gates.iter().filter(|g| matches!(g.gate, Gate::Collision | Gate::Limits)) {
        if gate.state == State::Unchecked {
            say!("note: {} is unchecked: {}", gate.gate.name(), gate.reason);
        }
    }
    say!("record it at 100 percent of feed and rapid override, then: proveout calibrate fit");
    Ok(())
}

/// Runs the text on the twin, with stock, fixtures and bodies of the scene.
fn proved(scene: &Path, output: &Path, text: &str) -> Result<RunResult, Failure> {
    let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let beside = output.with_file_name(format!(".proof-{}-{name}", std::process::id()));
    let unwritten = |e: std::io::Error| {
        Failure::new(format!("{} cannot be written: {e}", beside.display())).with_help("name another file")
    };
    fs::write(&beside, text).map_err(unwritten)?;
    let prove = || -> Result<RunResult, SimError> {
        let choice = Choice { nc: Some(beside.clone()), ..Choice::default() };
        let prepared = Prepared::read(scene, &choice)?;
        let place = output.with_file_name(format!(".proof-{}-{name}.run", std::process::id()));
        let folder = RunFolder::create(&place).map_err(SimError::Folder)?;
        run(prepared, &mut [], folder.path())
    };
    let result = prove();
    fs::remove_file(&beside).ok();
    result.map_err(|e| {
        Failure::from(&e).with_more_help("the air program did not run on the twin of this scene; nothing is written")
    })
}

/// Refuses a program with findings, cuts, or of more than ten minutes.
fn judged(result: &RunResult) -> Result<(), Failure> {
    let verdict = &result.verdict;
    let of_motion = |f: Family| matches!(f, Family::Program | Family::Limits | Family::Process | Family::Collision);
    let faults: Vec<String> = verdict
        .findings
        .iter()
        // It runs without a tool: nothing may be cut.
        .filter(|f| f.severity == Severity::Error && of_motion(f.family) && f.code != NO_TOOL.code)
        .map(|f| format!("line {}: {} [{}]", f.line.unwrap_or(0), f.message, f.code))
        .collect();
    if !faults.is_empty() {
        let shown = faults.iter().take(SHOWN).cloned().collect::<Vec<_>>().join("; ");
        return Err(Failure::new(format!("the twin finds {} faults in the air program: {shown}", faults.len()))
            .with_help("narrow the ranges with --range; nothing is written"));
    }
    if verdict.removal.volume_mm3 > 0.0 {
        return Err(Failure::new(format!(
            "the air program would cut {:.1} mm3 of the stock",
            verdict.removal.volume_mm3
        ))
        .with_help("keep the axis along the spindle higher with --range; nothing is written"));
    }
    if verdict.time.total_s > LONGEST_S {
        return Err(Failure::new(format!(
            "the air program takes {:.0} s on the twin, more than {LONGEST_S} s",
            verdict.time.total_s
        ))
        .with_help("narrow the ranges of the slow axes with --range; nothing is written"));
    }
    Ok(())
}

fn fit(args: &CalibrateFitArgs) -> Result<(), Failure> {
    for file in std::iter::once(&args.output).chain(&args.report) {
        check(file, args.force)?;
    }
    let (scene, machine) = scene_and_machine(&args.scene)?;
    let file = machine.file().to_owned();
    let text = read_input(&file).map_err(input)?;
    same_folder(&file, &args.output, &text)?;
    let columns = match &args.columns {
        Some(path) => Some(ColumnsFile::read(path, &read_input(path).map_err(input)?).map_err(input)?),
        None => None,
    };
    let mut traces: Vec<Trace> = Vec::new();
    for path in &args.trace {
        let text = read_regular_text(path, MAX_TRACE).map_err(|e| {
            Failure::new(format!("{}: the trace cannot be read: {e}", path.display()))
                .with_help("name a CSV file, as text in UTF-8")
        })?;
        traces.push(trace_from_text(path, &text, columns.as_ref(), &machine).map_err(input)?);
    }
    let words = args.program.as_deref().map(|p| words(p, &scene, &machine, &traces)).transpose()?;
    if words.is_none() && traces.iter().any(|t| t.block.is_some()) {
        say!("note: the column of program lines is not used without --program");
    }
    let found = calibrate(&machine, &traces, words.as_ref()).map_err(input)?;
    for joint in &found.joints {
        print_joint(joint, &found);
    }
    for time in &found.word_times {
        say!(
            "{}: {} times, {}{} s, spread {:.4} s",
            time.word,
            time.count,
            if time.word == "dwell" { "beyond the programmed time " } else { "" },
            with_error(time.mean_s, time.standard_error_s),
            time.spread_s
        );
    }
    if let Some(report) = &args.report {
        let json = serde_json::to_string_pretty(&found);
        let json = json.map_err(|e| Failure::new(format!("the report cannot be written: {e}")))?;
        put_bytes(report, args.force, json)?;
    }
    let written = found.parameters.iter().filter(|p| p.written).count();
    if written == 0 {
        return Err(Failure::new("the traces determine no value of the machine file: nothing is written").with_help(
            "record the program of `proveout calibrate plan`, with command and actual positions, at 1 kHz",
        ));
    }
    let new = calibrated_machine(&args.output, &text, &found).map_err(input)?;
    put_bytes(&args.output, args.force, new)?;
    say!("{}: {written} of {} values from the traces", args.output.display(), found.parameters.len());
    Ok(())
}

/// A machine file that names files of its folder must stay in it.
fn same_folder(machine: &Path, output: &Path, text: &str) -> Result<(), Failure> {
    let folder = |path: &Path| -> Option<PathBuf> {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        parent.canonicalize().ok()
    };
    match needs_folder(text) {
        Some(named) if folder(machine) != folder(output) => {
            let place = machine.with_file_name("machine.calibrated.toml");
            Err(Failure::new(format!("the machine file names {named}, which is in its folder"))
                .with_help(format!("write the calibrated file there: --output {}", place.display())))
        }
        _ => Ok(()),
    }
}

/// Standstills of the recorded program.
fn words(program: &Path, scene: &Scene, machine: &Machine, traces: &[Trace]) -> Result<WordTimes, Failure> {
    if !traces.iter().any(|t| t.block.is_some()) {
        return Err(Failure::new("--program, but no trace has a column of program lines")
            .with_help("name the column as `block`, or omit --program"));
    }
    let failure = |e: SimError| Failure::from(&e);
    let lines = ProgramText::open(program).map_err(|e| failure(e.into()))?.all().count();
    let control = control_of(Some(scene), machine).map_err(failure)?;
    let (settings, note) = proveout_sim::settings_on(control.as_ref(), Dialect::Auto, program).map_err(failure)?;
    if let Some(note) = note {
        say!("note: {note}");
    }
    let mut out = WordTimes::new(u32::try_from(lines).unwrap_or(u32::MAX));
    for command in Program::open(program, &with_machine(settings, machine)).map_err(|e| failure(e.into()))? {
        out.add(&command.map_err(|e| failure(e.into()))?);
    }
    Ok(out)
}

fn print_joint(joint: &JointReport, found: &Calibration) {
    let mut left = Vec::new();
    for (count, why) in [
        (joint.moves_together, "with other axes"),
        (joint.moves_overridden, "at another override"),
        (joint.moves_unfit, "that no law fits"),
    ] {
        if count > 0 {
            left.push(format!("{count} {why}"));
        }
    }
    let left = if left.is_empty() { String::new() } else { format!("; left out: {}", left.join(", ")) };
    say!("{}: {} moves, {} at full velocity{left}", joint.name, joint.moves, joint.moves_at_velocity);
    if let Some(words) = joint.interpolator {
        let averages: Vec<String> =
            joint.averages_ms.iter().map(|[v, e]| format!("{} ms", with_error(*v, *e))).collect();
        let averages = if averages.is_empty() { String::new() } else { format!(": {}", averages.join(", ")) };
        let alike = if joint.interpolators_alike.is_empty() {
            String::new()
        } else {
            format!(" (as well: {})", joint.interpolators_alike.join("; "))
        };
        say!("  set points: {words}{averages}{alike}, misfit {:.2}", joint.misfit.unwrap_or(0.0));
    }
    let own = |p: &&Parameter| p.joint.as_deref() == Some(joint.name.as_str());
    for p in found.parameters.iter().filter(own) {
        let before = p.before.map_or_else(
            || "none".to_owned(),
            |v| format!("{:.6}", v).trim_end_matches('0').trim_end_matches('.').to_owned(),
        );
        match (p.written, p.estimate, p.standard_error) {
            (true, Some(v), Some(e)) => say!("  {}: {}, before {before}", p.key, with_error(v, e)),
            _ => say!("  {}: stays {before}: {}", p.key, p.reason),
        }
    }
    for c in &joint.correlations {
        say!("  correlation of {} and {}: {:.2}", c.keys[0], c.keys[1], c.correlation);
    }
    if let Some([mass, error]) = joint.moved_mass {
        say!("  moved mass from the force (not written): {}", with_error(mass, error));
    }
    if let Some(([value, error], unit)) = joint.friction_in_unit {
        say!("  dry friction: {} {unit}", with_error(value, error));
    }
}
