use std::fmt::Write as _;
use std::path::Path;

use proveout_machine::Machine;
use proveout_nc::{Dialect, detect};
use proveout_sim::{
    SimError,
    certificate::{
        CellCertificate, ConstantFeed, JointCertificate, LinearCertificate, RunCertificate, ScheduleCertificate,
        VelocityLimit, VelocityRow,
    },
    planning,
    scene::{HELIX, Scene, StrategyFile},
};
use proveout_tool::ToolLibrary;

use crate::{
    args::{PlanArgs, RescheduleArgs},
    commands::output_file::{check, put_bytes},
    failure::Failure,
    front::{self, RescheduledProgram},
};

/// Writes a program for the blade of a scene, or compares its plans.
pub(crate) fn plan(args: &PlanArgs) -> Result<(), Failure> {
    for file in args.output.iter().chain(&args.report) {
        check(file, args.force)?;
    }
    let (Some(strategy), Some(output)) = (&args.strategy, &args.output) else {
        return study(&args.scene);
    };
    if strategy == HELIX.0 && args.report.is_some() {
        return Err(Failure::new("--report is not available with --strategy helix")
            .with_help("run the program with `proveout run`: its report shows the demands on the joints"));
    }
    let (text, report) = front::plan(&args.scene, strategy, args.program.as_deref(), language(output))?;
    if let Some(report) = report {
        tell!("{}", report.text().trim_end());
        if let Some(path) = &args.report {
            let json = serde_json::to_string_pretty(&report);
            let json = json.map_err(|e| Failure::new(format!("the report cannot be written: {e}")))?;
            put_bytes(path, args.force, json)?;
        }
    }
    put_bytes(output, args.force, &text)
}

/// All plans of a scene side by side.
fn study(scene: &Path) -> Result<(), Failure> {
    let failure = |e: SimError| Failure::from(&e);
    let scene = Scene::read(scene).map_err(|e| failure(e.into()))?;
    let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools)).map_err(|e| failure(e.into()))?;
    let machine = Machine::read(&scene.resolve(&scene.file.machine)).map_err(|e| failure(e.into()))?;
    let plans = scene.file.plan.as_ref();
    let given = StrategyFile::ALL.into_iter().filter(|(s, ..)| plans.is_some_and(|p| s.of(p).is_some()));
    let mut reports = Vec::new();
    for (strategy, ..) in given {
        let planned = planning::plan(&scene, &machine, &tools, strategy).map_err(failure)?;
        reports.push(planned.report);
    }
    if reports.is_empty() {
        return Err(Failure::new(format!("{}: the scene has no contact-based plan to compare", scene.path.display()))
            .with_help("add tables such as [plan.quasi-circle] and [plan.iso-parametric]"));
    }
    tell!("{}", planning::PlanReport::table(&reports).trim_end());
    Ok(())
}

/// Writes a program of a scene with new tool axes.
pub(crate) fn reschedule(args: &RescheduleArgs) -> Result<(), Failure> {
    for file in std::iter::once(&args.output).chain(&args.certificate) {
        check(file, args.force)?;
    }
    let mut options = Vec::new();
    for option in &args.set {
        let Some((key, value)) = option.split_once('=') else {
            return Err(Failure::new(format!("--set {option} is not KEY=VALUE")).with_help("for example --set keys=15"));
        };
        options.push((key.trim(), value.trim()));
    }
    let work = front::reschedule(&args.scene, &args.program, &args.method, &options, "--set", language(&args.output))?;
    let made = &work.made;
    if let Some(path) = &args.certificate {
        let json = serde_json::to_string(&made.certificate);
        put_bytes(
            path,
            args.force,
            json.map_err(|e| Failure::new(format!("the certificate cannot be written: {e}")))?,
        )?;
    }
    put_bytes(&args.output, args.force, &made.text)?;
    tell!("{}: {} from {}, {}", args.output.display(), args.method, work.source, options_in_words(&work));
    for run in &made.certificate.runs {
        tell!("{}", stretch(run, &made.certificate).trim_end());
    }
    for channel in &made.channels {
        let fastest = channel.least_velocity_deg_s;
        let fastest = fastest.map(|v| format!(", least peak velocity {v:.1} deg/s at the programmed feed"));
        let fastest = fastest.unwrap_or_default();
        tell!("channel {}: narrowest {:.1} deg{fastest}", channel.name, channel.narrowest_deg);
    }
    let [before, now] = made.feed_s;
    tell!("in feed: {} {before:.3} s, {} {now:.3} s", work.source, args.method);
    if let Some(kept) = made.kept {
        tell!(
            "{} kept {}: it found nothing faster or smoother in this channel; try another channel= or clearance_deg=",
            args.method,
            kept.words()
        );
    }
    for why in &made.uncertified {
        tell!("no time bound: {why}");
    }
    Ok(())
}

/// Times of a stretch, the bound of all schedules, and the limits that both rest on.
fn stretch(run: &RunCertificate, all: &ScheduleCertificate) -> String {
    let [first, last] = run.lines;
    let mut out = format!(
        "lines {first} to {last}: {:.3} s, {} {:.3} s ({:+.2} percent)\n",
        run.time_s,
        all.from,
        run.original_time_s,
        -run.gain_percent()
    );
    let proofs: Vec<String> = ["feed", "travel", "swings", "cells"]
        .into_iter()
        .map(|proof| (proof, run.proved_by(proof)))
        .filter(|(_, time)| *time > 0.0)
        .map(|(proof, time)| format!("{proof} {time:.3} s"))
        .collect();
    let about = match &run.cells {
        Some(cells) => format!("with axes within {:.2} degrees of those of {}", cells.stray_deg, all.from),
        None if run.joints.is_empty() => "at these feeds (channel unknown)".to_owned(),
        None => "in the channel".to_owned(),
    };
    let _ = writeln!(out, "  no schedule {about} is below {:.3} s: {}", run.bound_s, proofs.join(", "));
    match run.gap_percent {
        Some(gap) => {
            let _ = writeln!(out, "  at most {gap:.2} percent remain to be gained");
        }
        None => out.push_str("  the new axes leave the channel, so the bound does not apply to them\n"),
    }
    if let Some(middle) = &run.ramps_apart {
        let _ = writeln!(
            out,
            "  without the first and last {} s: {:.3} s, no schedule is below {:.3} s there, at most {:.2} percent remain",
            middle.ramp_s, middle.time_s, middle.bound_s, middle.gap_percent
        );
    }
    let _ = writeln!(
        out,
        "  {:.3} s at programmed feed, {:.3} s of it proved: block ends may be off by {:.4} mm",
        run.programmed_s, run.feed_bound_s, run.off_mm
    );
    for what in &run.rests_on {
        let _ = writeln!(out, "  not proved for all schedules: {what}");
    }
    if let Some(cells) = &run.cells {
        let _ = writeln!(out, "  {}", by_cells(cells));
    }
    if let Some(line) = slides(&run.linear, run.feed_bound_s) {
        let _ = writeln!(out, "  {line}");
    }
    for peak in &run.constant_feed {
        let _ = writeln!(out, "  {}", least_peak(peak));
    }
    if !run.joints.is_empty() && run.constant_feed.is_empty() {
        out.push_str(
            "  at the programmed times no table motion in the channel was found: the table is too slow for them\n",
        );
    }
    if !run.original_inside {
        let _ = writeln!(out, "  the axes of {} leave the channel", all.from);
    }
    for joint in &run.joints {
        let limit =
            |v: Option<f64>, unit: &str| v.map_or_else(|| format!("no limit in {unit}"), |v| format!("{v:.1} {unit}"));
        let lowered = all.changed_limits.iter().filter(|l| l.joint == joint.name).map(|l| {
            let own = l.of_machine.map_or_else(|| "none".to_owned(), |v| format!("{v:.1}"));
            format!("{} {own}", l.quantity)
        });
        let lowered: Vec<String> = lowered.collect();
        let _ = write!(
            out,
            "  based on {} with at most {:.1} deg/s, {}, {}",
            joint.name,
            joint.velocity_deg_s,
            limit(joint.acceleration_deg_s2, "deg/s2"),
            limit(joint.jerk_deg_s3, "deg/s3")
        );
        if lowered.is_empty() {
            out.push('\n');
        } else {
            let _ = writeln!(out, " (lowered by the scene; the machine has {})", lowered.join(", "));
        }
        if let Some(line) = over_velocity(joint) {
            let _ = writeln!(out, "  {line}");
        }
    }
    out
}

/// The bound with both angles free.
fn by_cells(cells: &CellCertificate) -> String {
    let lost = match cells.reached_s {
        Some(reached) => format!(
            "; a schedule of the relaxation takes {reached:.3} s, so the cells lose at most {:.2} percent",
            100.0 * (reached / cells.bound_s - 1.0)
        ),
        None => String::new(),
    };
    format!(
        "by cells of {} and {} at {} places: {:.3} s{lost}",
        cells.inner.name,
        cells.outer.name,
        cells.stations.len(),
        cells.bound_s
    )
}

/// What linear joints that follow the axes bound.
fn slides(linear: &[LinearCertificate], feed: f64) -> Option<String> {
    let one = |l: &LinearCertificate| {
        let at = l.longest_way_mm / l.velocity_mm_s;
        format!("{} by {:.1} mm at once, {at:.3} s at {:.0} mm/s", l.name, l.longest_way_mm, l.velocity_mm_s)
    };
    let binds = linear.iter().any(|l| l.velocity_bound_s > feed);
    let verb = if binds { "bind" } else { "do not bind" };
    let all: Vec<String> = linear.iter().map(one).collect();
    (!all.is_empty()).then(|| format!("linear joints {verb}; every schedule moves {}", all.join("; ")))
}

/// What the table needs at the programmed times.
fn least_peak(peak: &ConstantFeed) -> String {
    let unit = if peak.order == 2 { "deg/s2" } else { "deg/s3" };
    let which = if peak.one_way() { " without turning back" } else { "" };
    format!(
        "at the programmed times {}{which} needs at least {:.1} {unit} ({:.1} suffice at block ends); these axes have {:.1}",
        peak.joint, peak.proved_deg, peak.reached_deg, peak.program_deg
    )
}

/// What the new axes save over the velocity limit of a joint, the largest limit first.
fn over_velocity(joint: &JointCertificate) -> Option<String> {
    let told = |r: &VelocityRow| {
        let which = match r.is {
            VelocityLimit::Tried => return None,
            VelocityLimit::OfOriginal => "needed by the original program",
            VelocityLimit::InForce => "in force",
            VelocityLimit::OfMachine => "the machine's own",
        };
        Some(format!("{:.1} percent at {:.1} deg/s ({which})", r.saved_percent, r.velocity_deg_s))
    };
    let rows: Vec<String> = joint.over_velocity.iter().filter_map(told).collect();
    let lowest = joint.over_velocity.last().filter(|r| r.is == VelocityLimit::Tried);
    let lowest = lowest.map(|r| format!(", {:.1} percent at {:.1} deg/s", r.saved_percent, r.velocity_deg_s));
    (!rows.is_empty()).then(|| {
        format!("by feed and velocity of {} alone: {}{}", joint.name, rows.join(", "), lowest.unwrap_or_default())
    })
}

/// The options that were taken, and where they come from.
fn options_in_words(work: &RescheduledProgram) -> String {
    let given: Vec<String> = work.options.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let given = if given.is_empty() { "published and default options".to_owned() } else { given.join(", ") };
    match &work.entry {
        Some(entry) => format!("{given} (program {entry} of the scene)"),
        None => given,
    }
}

/// The language of an output file; 840D where the file extension does not decide it.
fn language(path: &Path) -> Dialect {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match (detect(&path.display().to_string(), ""), ending.as_deref()) {
        (Dialect::Auto, Some("nc" | "iso" | "tap" | "gcode")) => Dialect::Iso,
        (Dialect::Auto, _) => Dialect::Siemens840d,
        (dialect, _) => dialect,
    }
}
