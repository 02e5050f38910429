//! What the host says of a finished run; nothing of it goes into the verdict.

use std::{collections::BTreeMap, fs, path::Path};

use proveout_record::{CheckCounts, RunInfo, StageTimes};
use proveout_sim::run::{Checks, RunResult};

/// Clock ticks a second of `/proc/self/stat`: 100 on every Linux that Rust supports.
const TICKS_PER_S: f64 = 100.0;
/// Keeps the speed of a run that took no time a number, s.
pub(crate) const LEAST_WALL_S: f64 = 1e-9;

/// Peak memory of the process, MiB, where the system reports it.
pub(crate) fn peak_mib() -> Option<f64> {
    first_value("/proc/self/status", "VmHWM")
        .and_then(|v| v.trim_end_matches("kB").trim().parse::<f64>().ok())
        .map(|kib| kib / 1024.0)
}

/// Wall time, processor time, memory and versions of a run.
///
/// `alone`: the process has made no other run, so that its peak is that of this one.
pub(crate) fn run_info(result: &RunResult, scene: &Path, threads: usize, alone: bool) -> RunInfo {
    let s = &result.stages;
    let simulated = result.verdict.time.total_s;
    let wall = result.wall.max(LEAST_WALL_S);
    let versions = [
        ("proveout", env!("CARGO_PKG_VERSION")),
        ("verdict_schema", &proveout_sim::verdict::SCHEMA_VERSION.to_string()),
    ];
    let mut host = BTreeMap::from([
        ("os".to_owned(), std::env::consts::OS.to_owned()),
        ("arch".to_owned(), std::env::consts::ARCH.to_owned()),
    ]);
    if let Ok(cores) = std::thread::available_parallelism() {
        host.insert("cores".into(), cores.to_string());
    }
    if let Some(cpu) = first_value("/proc/cpuinfo", "model name") {
        host.insert("cpu".into(), cpu);
    }
    RunInfo {
        scene: scene.canonicalize().unwrap_or_else(|_| scene.to_owned()).display().to_string(),
        command: crate::words().iter().map(|a| a.to_string_lossy().into_owned()).collect(),
        wall_s: result.wall,
        cpu_s: cpu_time(),
        threads,
        peak_rss_mib: peak_mib(),
        announced_mib: alone.then(|| result.announced_memory as f64 / f64::from(1 << 20)),
        stock_mib: result.stock_memory.iter().map(|(n, b)| (n.clone(), *b as f64 / f64::from(1 << 20))).collect(),
        simulated_s: simulated,
        realtime_factor: simulated / wall,
        moves_per_s: result.pieces as f64 / wall,
        stages: StageTimes {
            read_s: s.read,
            plan_s: s.plan,
            servo_s: s.servo,
            removal_s: s.removal,
            collision_s: s.collision,
            surface_s: s.surface,
            record_s: s.record,
        },
        checks: checks(&result.checks),
        versions: versions.map(|(k, v)| (k.to_owned(), v.to_owned())).into(),
        host,
    }
}

fn checks(of: &Checks) -> CheckCounts {
    let bodies = &of.bodies;
    CheckCounts {
        pieces: bodies.pieces,
        share_by_one_comparison: bodies.share_by_allowance(),
        pairs: bodies.pair_checks,
        pairs_by_one_comparison: bodies.pairs_by_allowance,
        queries_farther: bodies.misses,
        queries_distance: bodies.distances,
        stock_motions: of.stock_motions,
        stock_queries: of.stock_queries,
        clearance_looks: of.looks,
    }
}

/// Value of the first `key: value` line of a file.
fn first_value(file: &str, key: &str) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let line = text.lines().find(|l| l.starts_with(key))?;
    line.split_once(':').map(|(_, v)| v.trim().to_owned())
}

/// Time of all processor cores, s; `None` where the host does not report it.
pub(crate) fn cpu_time() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    let after_name = stat.rsplit_once(')')?.1;
    let mut fields = after_name.split_whitespace().skip(11);
    let ticks: f64 = fields.next()?.parse::<f64>().ok()? + fields.next()?.parse::<f64>().ok()?;
    Some(ticks / TICKS_PER_S)
}
