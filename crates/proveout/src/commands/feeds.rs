use std::collections::BTreeMap;

use proveout_record::write_engagement_table;
use proveout_sim::{
    Choice, SimError,
    feeds::{FeedMode, FeedRow, FeedsCall, FeedsResult, LimitsFile, Loads, MOST_RUNS, schedule},
};
use serde::Serialize;

use crate::{
    args::{FeedModeArg, FeedsArgs},
    commands::output_file::{check, put, put_bytes},
    failure::Failure,
};

/// A load this much over its limit is reported as one.
const OVER: f64 = 1.02;
/// Changed lines that are printed.
const SHOWN: usize = 20;
/// Hundredths of a whole.
const PERCENT: f64 = 100.0;

/// Finds the feeds of a program and writes them.
pub(crate) fn feeds(args: &FeedsArgs) -> Result<(), Failure> {
    for file in args.output.iter().chain(&args.report).chain(&args.engagement) {
        check(file, args.force)?;
    }
    let mode = mode(args.mode);
    if let Some(output) = args.output.as_ref().filter(|_| mode == FeedMode::Analyse) {
        return Err(Failure::new(format!("--output {}: --mode analyse writes no program", output.display()))
            .with_help("omit --output, or choose another --mode"));
    }
    if args.output.is_none() && mode != FeedMode::Analyse {
        return Err(Failure::new("--output is missing: this --mode writes a program")
            .with_help("add --output FILE, or use --mode analyse"));
    }
    if !(0.0..PERCENT).contains(&args.dead_band) {
        return Err(Failure::new(format!("--dead-band {}: must be from 0 to below 100 percent", args.dead_band))
            .with_help("use 5, or 0 to make every change"));
    }
    let (_, pool) = super::run::pool(args.resolution_mm, args.threads)?;
    let limits =
        args.limits.as_deref().map(LimitsFile::read).transpose().map_err(|e| Failure::from(&SimError::from(e)))?;
    let choice = Choice {
        program: args.program.clone(),
        nc: args.nc.clone(),
        resolution_mm: args.resolution_mm,
        ..Choice::default()
    };
    let call = FeedsCall {
        scene: &args.scene,
        choice: &choice,
        limits: limits.as_ref(),
        mode,
        dead_band: args.dead_band / PERCENT,
    };
    let found = pool.install(|| schedule(&call, &mut |line| tell!("{line}"))).map_err(|e| Failure::from(&e))?;
    print(&found, limits.as_ref());
    if !found.new_faults.is_empty() {
        let lines: Vec<String> = found.new_faults.iter().map(|(code, line)| format!("{code} in line {line}")).collect();
        return Err(Failure::new(format!(
            "the new feeds have findings that the program did not have: {}",
            lines.join(", ")
        ))
        .with_help("nothing is written; lower max_feed_mm_min of the tool, or use a wider --dead-band"));
    }
    let over = found.worst.filter(|(ratio, ..)| *ratio > OVER && mode != FeedMode::Analyse);
    if let Some((ratio, binds, line)) = over {
        let message =
            format!("line {line}: {} is {:.1} percent of its limit with the new feeds", binds.word(), PERCENT * ratio);
        return Err(
            Failure::new(message).with_help("nothing is written; lower the feed of this line and the one before it")
        );
    }
    if let Some(report) = &args.report {
        let json = serde_json::to_string_pretty(&Report::of(&found, args.mode));
        put_bytes(report, args.force, json.map_err(|e| Failure::new(format!("the report cannot be written: {e}")))?)?;
        say!("report: {}", report.display());
    }
    if let Some(path) = &args.engagement {
        put(path, args.force, |beside| {
            write_engagement_table(beside, &found.engagement, found.cell_mm).map_err(Failure::new)
        })?;
        say!("engagement: {}", path.display());
    }
    if let Some(output) = &args.output {
        match &found.text {
            Some(text) => {
                put_bytes(output, args.force, text)?;
                say!("written: {}", output.display());
            }
            None => say!("not written: {}: no feed changes", output.display()),
        }
    }
    Ok(())
}

fn mode(arg: FeedModeArg) -> FeedMode {
    match arg {
        FeedModeArg::Analyse => FeedMode::Analyse,
        FeedModeArg::Air => FeedMode::Air,
        FeedModeArg::Chip => FeedMode::Chip,
        FeedModeArg::Force => FeedMode::Force,
        FeedModeArg::Learned => FeedMode::Learned,
    }
}

fn print(found: &FeedsResult, limits: Option<&LimitsFile>) {
    let [before, after] = found.time_s;
    let saved = PERCENT * (before - after) / before.max(f64::MIN_POSITIVE);
    say!("machine time {before:.2} s before, {after:.2} s after: {saved:.1} percent saved");
    say!("{} lines with another feed; {} runs of the twin, cells of {} mm", found.changed, found.runs, found.cell_mm);
    if !found.settled {
        say!("not settled: after {MOST_RUNS} runs a feed would still change; the text is that of the last run");
    }
    for (tool, chip) in &found.learned {
        say!("{tool}: largest chip learned from the program, {chip:.4} mm");
    }
    for (name, material) in limits.iter().flat_map(|l| l.materials()) {
        say!(
            "{name}: {}, forces within {} percent; source: {}",
            material.name,
            material.uncertainty_percent,
            material.source
        );
    }
    for what in &found.assumed {
        say!("assumed: {what}");
    }
    by_tool(&found.rows);
    let changed: Vec<&FeedRow> = found.rows.iter().filter(|r| r.feed_mm_min[0] != r.feed_mm_min[1]).collect();
    for row in changed.iter().take(SHOWN) {
        let [was, is] = row.feed_mm_min;
        say!("  line {}: F {was:.1} to {is:.1} mm/min, {}", row.line, row.set_by.words());
    }
    if changed.len() > SHOWN {
        say!("  and {} more blocks; --report has all", changed.len() - SHOWN);
    }
    if let Some((ratio, binds, line)) = found.worst {
        let words = if ratio > OVER { "over its limit" } else { "within its limit" };
        say!("largest load: {} at {:.1} percent, {words}, in line {line}", binds.word(), PERCENT * ratio);
    }
    if found.over_in_kept > 0 {
        say!("{} blocks that keep their feed are over a limit; --report names them", found.over_in_kept);
    }
    say!("not checked here: surface, roughness, chatter; prove the new program with `proveout run --nc`");
}

/// Time by tool and by what sets the feed.
fn by_tool(rows: &[FeedRow]) {
    let mut tools: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    let mut causes: BTreeMap<(&str, String), f64> = BTreeMap::new();
    for row in rows {
        let tool = row.tool.as_deref().unwrap_or("no tool");
        let times = tools.entry(tool).or_default();
        times[0] += row.time_s[0];
        times[1] += row.time_s[1];
        *causes.entry((tool, row.set_by.words())).or_default() += row.time_s[1];
    }
    for (tool, [before, after]) in &tools {
        say!("{tool}: {before:.2} s in feed before, {after:.2} s after");
        let mut own: Vec<(&String, f64)> =
            causes.iter().filter(|((t, _), _)| t == tool).map(|((_, words), time)| (words, *time)).collect();
        own.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(b.0)));
        for (words, time) in own {
            say!("  {:>5.1} percent of the time: {words}", PERCENT * time / after.max(f64::MIN_POSITIVE));
        }
    }
}

/// The report.
#[derive(Serialize)]
struct Report {
    mode: String,
    time_before_s: f64,
    time_after_s: f64,
    lines_changed: usize,
    runs: usize,
    settled: bool,
    resolution_mm: f64,
    assumed: Vec<String>,
    blocks: Vec<ReportBlock>,
}

#[derive(Serialize)]
struct ReportBlock {
    block: u32,
    file: String,
    line: u32,
    tool: Option<String>,
    feed_before_mm_min: f64,
    feed_after_mm_min: f64,
    reached_before_mm_min: f64,
    reached_after_mm_min: f64,
    time_before_s: f64,
    time_after_s: f64,
    set_by: String,
    engaged: bool,
    removal_mm3_s: f64,
    load_over_limit: Option<f64>,
    chip_max_mm: Option<f64>,
    force_peak_n: Option<f64>,
    torque_peak_nm: Option<f64>,
    power_kw: Option<f64>,
    deflection_um: Option<f64>,
}

impl Report {
    fn of(found: &FeedsResult, mode: FeedModeArg) -> Self {
        let block = |r: &FeedRow| {
            let known = |of: &dyn Fn(&Loads) -> f64| r.loads.as_ref().map(of);
            ReportBlock {
                block: r.block,
                file: r.file.clone(),
                line: r.line,
                tool: r.tool.clone(),
                feed_before_mm_min: r.feed_mm_min[0],
                feed_after_mm_min: r.feed_mm_min[1],
                reached_before_mm_min: r.reached_mm_min[0],
                reached_after_mm_min: r.reached_mm_min[1],
                time_before_s: r.time_s[0],
                time_after_s: r.time_s[1],
                set_by: r.set_by.words(),
                engaged: r.engaged,
                removal_mm3_s: r.removal_mm3_s,
                load_over_limit: r.over,
                chip_max_mm: known(&|l| l.chip_mm),
                force_peak_n: known(&|l| l.force_peak_n),
                torque_peak_nm: known(&|l| l.torque_peak_nm),
                power_kw: known(&|l| l.power_kw),
                deflection_um: r.loads.and_then(|l| l.deflection_um),
            }
        };
        Self {
            mode: format!("{mode:?}").to_lowercase(),
            time_before_s: found.time_s[0],
            time_after_s: found.time_s[1],
            lines_changed: found.changed,
            runs: found.runs,
            settled: found.settled,
            resolution_mm: found.cell_mm,
            assumed: found.assumed.clone(),
            blocks: found.rows.iter().map(block).collect(),
        }
    }
}
