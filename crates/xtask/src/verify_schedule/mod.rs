//! Checks a schedule certificate (`proveout reschedule --certificate`) with code of its own: nothing of the
//! product is used.
//!
//! 1. The least times of blocks follow from the ways of the tip and from what ends of blocks may be off
//!    (`feed.rs`), and in no window of blocks is either program faster, where it keeps to the channel.
//! 2. The windows follow each other from the first gate to the last, and each proves its time: the feed is
//!    summed again, a travel goes from one side of its first gate to the other side of its last, and the time
//!    of a swing is found by bisection over the farthest way in a time, which is another way to it than the
//!    product's. Potentials of cells are looked at edge by edge, and no cell is left out (`cells.rs`).
//! 3. The bound is the sum of the windows; times and gap are those of the blocks; the claim about who keeps
//!    to the channel is true.
//! 4. Weights prove the least peak that they claim at the programmed times (`peak.rs`).
//!
//! A certificate that claims less than is true is none the worse. Whether gates and limits are those of
//! channel and machine is not seen: they are what the bound is about.

mod cells;
mod feed;
mod peak;
mod swing;
#[cfg(test)]
mod tests;

use std::path::Path;

use serde_json::Value;

use crate::TaskError;
use swing::PeakLimits;

/// By how much sums may differ, as part: rounding of decimal text.
const ROUNDED: f64 = 1e-9;
/// By how much a position may be outside of its gate, degrees: eight decimals of a tool vector.
const PLACE_DEG: f64 = 1e-4;

struct CheckedJoint {
    name: String,
    limits: PeakLimits,
    gates: Vec<[f64; 2]>,
}

struct ScheduleRun<'a> {
    value: &'a Value,
    least: Vec<f64>,
    seams: Vec<f64>,
    joints: Vec<CheckedJoint>,
}

fn wrong(what: impl Into<String>) -> TaskError {
    TaskError(what.into())
}

fn number(value: &Value, key: &str) -> Result<f64, TaskError> {
    value[key].as_f64().ok_or_else(|| wrong(format!("{key} is not a number")))
}

fn numbers(value: &Value, key: &str) -> Result<Vec<f64>, TaskError> {
    let list = value[key].as_array().ok_or_else(|| wrong(format!("{key} is not a list")))?;
    list.iter()
        .map(|v| v.as_f64().ok_or_else(|| wrong(format!("{key} contains a value that is not a number"))))
        .collect()
}

fn list<'a>(value: &'a Value, key: &str) -> Result<&'a [Value], TaskError> {
    value[key].as_array().map(Vec::as_slice).ok_or_else(|| wrong(format!("{key} is not a list")))
}

/// Two numbers that should be one.
fn same(what: &str, claimed: f64, found: f64) -> Result<(), TaskError> {
    if (claimed - found).abs() <= ROUNDED * claimed.abs().max(found.abs()).max(1.0) {
        return Ok(());
    }
    Err(wrong(format!("{what}: stated {claimed}, computed {found}")))
}

/// Checks a certificate; gives what was seen.
///
/// # Errors
/// The first claim that does not hold, or a file that cannot be read.
pub(crate) fn run(file: &Path) -> Result<String, TaskError> {
    let value: Value =
        serde_json::from_str(&crate::files::get(file)?).map_err(|e| wrong(format!("{}: {e}", file.display())))?;
    let seen = check(&value).map_err(|TaskError(e)| wrong(format!("{}: {e}", file.display())))?;
    Ok(format!("{}: {seen}", file.display()))
}

fn check(value: &Value) -> Result<String, TaskError> {
    if value["format"] != "proveout schedule certificate, version 2" {
        return Err(wrong("not a schedule certificate of version 2"));
    }
    let runs = list(value, "runs")?;
    if runs.is_empty() {
        return Err(wrong("the certificate contains no run"));
    }
    let mut seen = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        let windows = check_run(run).map_err(|TaskError(e)| wrong(format!("run {k}: {e}")))?;
        seen.push(format!("{:.3} s proved by {windows} windows", number(run, "bound_s")?));
    }
    Ok(format!("{} hold: {}", if runs.len() == 1 { "1 run" } else { "the runs" }, seen.join(", ")))
}

fn check_run(value: &Value) -> Result<usize, TaskError> {
    let least = numbers(value, "least_s")?;
    if least.is_empty() || least.iter().any(|t| *t <= 0.0) {
        return Err(wrong("a block has no least time"));
    }
    let seams = numbers(value, "seams_s")?;
    if seams.len() != least.len() + 1 || seams.iter().any(|t| *t < 0.0) {
        return Err(wrong("seams_s needs one time per gate, zero or more"));
    }
    feed::check(value, &least, &seams)?;
    let mut all = joints(value, "joints", "deg", least.len())?;
    all.extend(joints(value, "linear", "mm", least.len())?);
    let run = ScheduleRun { joints: all, least, seams, value };
    let cells = match &value["cells"] {
        Value::Null => None,
        cells => {
            Some(cells::check(cells, number(value, "limit_passed")?, |from, to| run.feed(from, to), run.least.len())?)
        }
    };
    for peak in list(value, "constant_feed")? {
        peak::check(value, peak)?;
    }
    let inside = |key: &str| value[key].as_bool().ok_or_else(|| wrong(format!("{key} is neither true nor false")));
    for (program, times, flag, total) in
        [("new", "new_s", "new_inside", "time_s"), ("original", "original_s", "original_inside", "original_time_s")]
    {
        let positions = format!("{program}_deg");
        let claimed = inside(flag)?;
        if claimed != run.keeps(&positions)? {
            return Err(wrong(format!("{flag} is stated as {claimed}, which contradicts the gates")));
        }
        let own = numbers(value, times)?;
        if own.len() != run.least.len() {
            return Err(wrong(format!("{times} needs one time per block")));
        }
        if claimed && let Some([from, to]) = feed::faster(&own, &run.least, &run.seams) {
            return Err(wrong(format!(
                "blocks {from} to {to} take less time in the {program} program than the proved feed time"
            )));
        }
        let sum: f64 = own.iter().sum();
        same(total, number(value, total)?, sum)?;
        if claimed && sum < number(value, "bound_s")? * (1.0 - ROUNDED) {
            return Err(wrong(format!("the {program} program is faster than the bound")));
        }
    }
    same("feed_bound_s", number(value, "feed_bound_s")?, run.feed(0, run.least.len()))?;
    let windows = list(value, "windows")?;
    let bound = number(value, "bound_s")?;
    same("bound_s", bound, run.proved(windows, [0, run.least.len()], cells)?)?;
    match &value["gap_percent"] {
        Value::Null if !inside("new_inside")? => {}
        Value::Number(_) if inside("new_inside")? => {
            same("gap_percent", number(value, "gap_percent")?, 100.0 * (number(value, "time_s")? / bound - 1.0))?;
        }
        _ => {
            return Err(wrong(
                "gap_percent is given although the program leaves the channel, or missing although it does not",
            ));
        }
    }
    match &value["ramps_apart"] {
        Value::Null => {}
        middle => run.check_middle(middle).map_err(|TaskError(e)| wrong(format!("ramps_apart: {e}")))?,
    }
    Ok(windows.len())
}

fn joints(value: &Value, list_of: &str, unit: &str, blocks: usize) -> Result<Vec<CheckedJoint>, TaskError> {
    let passed = 1.0 + number(value, "limit_passed")?;
    let mut joints = Vec::new();
    for joint in list(value, list_of)? {
        let name = joint["name"].as_str().ok_or_else(|| wrong("a joint without a name"))?.to_owned();
        let limit = |quantity: &str| match &joint
            [format!("{quantity}_{unit}_s{}", if quantity == "jerk" { 3 } else { 2 })]
        {
            Value::Null => Ok(f64::INFINITY),
            value => {
                value.as_f64().map(|v| v * passed).ok_or_else(|| wrong(format!("{quantity} of {name} is not a number")))
            }
        };
        let limits = PeakLimits {
            velocity: number(joint, &format!("velocity_{unit}_s"))? * passed,
            acceleration: limit("acceleration")?,
            jerk: limit("jerk")?,
        };
        if !(limits.velocity > 0.0 && limits.acceleration > 0.0 && limits.jerk > 0.0) {
            return Err(wrong(format!("a limit of {name} is not above zero")));
        }
        let mut gates = Vec::new();
        for gate in list(joint, &format!("gates_{unit}"))? {
            let both = (gate[0].as_f64(), gate[1].as_f64());
            let (Some(low), Some(high)) = both else { return Err(wrong(format!("a gate of {name} is not a pair"))) };
            if low > high {
                return Err(wrong(format!("gate {} of {name} is empty", gates.len())));
            }
            gates.push([low, high]);
        }
        if gates.len() != blocks + 1 {
            return Err(wrong(format!("{name} has {} gates for {blocks} blocks", gates.len())));
        }
        joints.push(CheckedJoint { name, limits, gates });
    }
    Ok(joints)
}

impl ScheduleRun<'_> {
    /// What the feed proves from one gate to another.
    fn feed(&self, from: usize, to: usize) -> f64 {
        (self.least[from..to].iter().sum::<f64>() - self.seams[from] - self.seams[to]).max(0.0)
    }

    /// All positions of a program are inside of the gates, less what these are wider by.
    fn keeps(&self, positions: &str) -> Result<bool, TaskError> {
        let rounding = number(self.value, "rounding_deg")?;
        let mut keeps = true;
        for (joint, value) in self.joints.iter().zip(list(self.value, "joints")?) {
            let own = numbers(value, positions)?;
            if own.len() != joint.gates.len() {
                return Err(wrong(format!("{positions} of {} needs one position per gate", joint.name)));
            }
            keeps &= own
                .iter()
                .zip(&joint.gates)
                .all(|(q, [low, high])| q - low > rounding - PLACE_DEG && high - q > rounding - PLACE_DEG);
        }
        Ok(keeps)
    }

    /// What windows claim from one gate to another, s; each of them has to prove its own.
    fn proved(&self, windows: &[Value], [from, to]: [usize; 2], cells: Option<f64>) -> Result<f64, TaskError> {
        let (mut at, mut sum) = (from, 0.0);
        for (k, window) in windows.iter().enumerate() {
            let (end, time) =
                self.window(window, at, cells).map_err(|TaskError(e)| wrong(format!("window {k}: {e}")))?;
            let claimed = number(window, "time_s")?;
            if claimed > time + ROUNDED * time.abs().max(1.0) {
                return Err(wrong(format!("window {k} claims {claimed} s, but proves {time} s")));
            }
            sum += claimed;
            at = end;
        }
        if at != to {
            return Err(wrong(format!("the windows end at gate {at} of {to}")));
        }
        Ok(sum)
    }

    /// Time and bound of the blocks between the ramps.
    fn check_middle(&self, middle: &Value) -> Result<(), TaskError> {
        let gates: Vec<f64> = numbers(middle, "gates")?;
        let (from, to) = match gates.as_slice() {
            [from, to] if *from >= 0.0 && from < to && *to <= self.least.len() as f64 => (*from as usize, *to as usize),
            _ => return Err(wrong(format!("its gates {gates:?} are not two gates of the stretch"))),
        };
        let own = numbers(self.value, "new_s")?;
        let (time, bound) = (number(middle, "time_s")?, number(middle, "bound_s")?);
        same("time_s", time, own[from..to].iter().sum())?;
        let ramp = number(middle, "ramp_s")?;
        for (end, left) in [("first", &own[..from]), ("last", &own[to..])] {
            if left.iter().sum::<f64>() < ramp * (1.0 - ROUNDED) {
                return Err(wrong(format!("the {end} ramp is shorter than {ramp} s")));
            }
        }
        same("bound_s", bound, self.proved(list(middle, "windows")?, [from, to], None)?)?;
        same("gap_percent", number(middle, "gap_percent")?, 100.0 * (time / bound - 1.0))
    }

    /// Last gate and time of a window that must begin at a gate.
    fn window(&self, window: &Value, begin: usize, cells: Option<f64>) -> Result<(usize, f64), TaskError> {
        let gates: Option<Vec<usize>> =
            list(window, "gates")?.iter().map(|v| v.as_u64().and_then(|v| usize::try_from(v).ok())).collect();
        let gates = gates.filter(|g| g.len() >= 2).ok_or_else(|| wrong("it has no gates"))?;
        let last = gates[gates.len() - 1];
        if gates[0] != begin || gates.windows(2).any(|p| p[0] >= p[1]) || last > self.least.len() {
            return Err(wrong(format!("its gates {gates:?} do not increase from gate {begin}")));
        }
        let kind = window["proof"].as_str().unwrap_or_default();
        if kind == "feed" {
            return if gates.len() == 2 {
                Ok((last, self.feed(begin, last)))
            } else {
                Err(wrong("a feed proof needs two gates"))
            };
        }
        if kind == "cells" {
            let whole = begin == 0 && gates.len() == 2 && last == self.least.len();
            let proved = cells.filter(|_| whole);
            return proved
                .map(|time| (last, time))
                .ok_or_else(|| wrong("a cells proof must cover all blocks, and the cells must be given"));
        }
        let joint = self.joints.iter().find(|j| window["joint"] == j.name.as_str());
        let joint = joint.ok_or_else(|| wrong("its joint is not in the certificate"))?;
        let up = window["up"].as_bool().ok_or_else(|| wrong("`up` is missing"))?;
        // From the side where the joint must be at one gate to the other side of the next.
        let ways: Vec<f64> = gates
            .windows(2)
            .enumerate()
            .map(|(k, p)| {
                let [from, to] = [joint.gates[p[0]], joint.gates[p[1]]];
                if up == (k % 2 == 0) { to[0] - from[1] } else { from[0] - to[1] }
            })
            .collect();
        if ways.iter().any(|w| *w <= 0.0) {
            return Err(wrong("two of its gates can be passed without moving"));
        }
        let time = match (kind, ways.as_slice()) {
            ("travel", [way]) => way / joint.limits.velocity,
            ("swings", [first, inner @ .., last]) => {
                joint.limits.after_turn(*first)
                    + inner.iter().map(|w| joint.limits.turn_to_turn(*w)).sum::<f64>()
                    + joint.limits.after_turn(*last)
            }
            _ => return Err(wrong(format!("{kind:?} with {} gates is not a proof", gates.len()))),
        };
        Ok((last, time))
    }
}
