//! The results of a sweep in one table and one page: `sweep.parquet`, `sweep.csv`, `sweep.json`,
//! `sweep.html`.
//!
//! Results are read twice in the order of the jobs: once to hold every one of them against the plan, then to
//! write. A row leaves the memory with its row group, so that a million jobs take as much as a thousand; the
//! page keeps [`SHOWN`] rows.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, File},
    io::{BufWriter, Write as _},
    path::{Path, PathBuf},
};

use minijinja::{context, value::Serde};
use proveout_sim::{
    sweep::{JobResult, JobState, Plan, Recheck, check_verdict, read_result},
    verdict::State,
};
use serde::Serialize;
use serde_json::Value;
use thiserror::Error;

use crate::{
    chart::{Chart, Series, Style},
    error::RecordError,
    page_template::{fill, policy},
    parquet_table::{Column, ColumnKind, Table},
};

const TEMPLATE: &str = include_str!("../templates/sweep.html");
const TABLES: &str = include_str!("../templates/tables.js");
/// Rows of the page: the fastest jobs of the best state.
const SHOWN: usize = 200;
/// Largest number of faults that are shown.
const FAULTS: usize = 10;
/// Points of a chart.
const POINTS: usize = 2000;
/// Files of a merge.
const FILES: [&str; 4] = ["sweep.parquet", "sweep.csv", "sweep.json", "sweep.html"];
/// Figures that the page shows, where the sweep has them.
const FIGURES: [&str; 7] = ["time_s", "removed_mm3", "gouge_mm", "excess_mm", "scallop_um", "ra_um", "errors"];

/// Why a sweep was not merged; nothing was written.
#[derive(Debug, Error)]
pub enum MergeError {
    /// Results that are missing, of another plan or damaged.
    #[error("{} of {jobs} results cannot be merged: {}{}", .count, .first.join("; "), more(*.count, .first.len()))]
    Results {
        /// How many.
        count: usize,
        /// Jobs of the plan.
        jobs: usize,
        /// The first of them, in words.
        first: Vec<String>,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

fn more(count: usize, told: usize) -> String {
    if count > told { format!("; and {} more", count - told) } else { String::new() }
}

/// What was merged: `sweep.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SweepSummary {
    /// Name of the sweep.
    pub name: String,
    /// Program and version.
    pub made_by: String,
    /// Jobs.
    pub jobs: usize,
    /// Jobs by what became of them.
    pub states: BTreeMap<&'static str, usize>,
    /// The fastest job that passes, with its values; null where none does.
    pub fastest_pass: Option<Fastest>,
}

/// The fastest job of a state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fastest {
    /// Its number.
    pub job: usize,
    /// Machine time, s.
    pub time_s: f64,
    /// Its values.
    pub values: serde_json::Map<String, Value>,
}

/// Merges the results of all jobs.
///
/// # Errors
/// [`MergeError`]: a result that is missing, of another plan or version, or damaged; nothing is merged by
/// halves.
pub fn merge_sweep(folder: &Path, plan: &Plan) -> Result<SweepSummary, MergeError> {
    let seen = survey(folder, plan)?;
    let beside = |name: &str| folder.join(format!(".{name}.{}", std::process::id()));
    let written = write_all(folder, plan, &seen, &beside);
    if written.is_err() {
        for name in FILES {
            fs::remove_file(beside(name)).ok();
        }
    }
    written?;
    for name in FILES {
        let path = folder.join(name);
        fs::rename(beside(name), &path).map_err(RecordError::io(&path))?;
    }
    Ok(seen.merged)
}

/// What the first reading finds.
struct JobSurvey {
    merged: SweepSummary,
    figures: BTreeSet<String>,
    /// Keys all of whose values are numbers.
    numbers: Vec<bool>,
    best: Vec<JobResult>,
    points: Vec<JobResult>,
    gates: BTreeMap<String, usize>,
    refusals: BTreeMap<String, usize>,
}

fn time(result: &JobResult) -> f64 {
    result.figures.get("time_s").copied().flatten().unwrap_or(f64::INFINITY)
}

fn survey(folder: &Path, plan: &Plan) -> Result<JobSurvey, MergeError> {
    let (mut faults, mut first) = (0, Vec::new());
    let mut seen = JobSurvey {
        merged: SweepSummary {
            name: plan.name.clone(),
            made_by: plan.made_by.clone(),
            jobs: plan.jobs.len(),
            ..SweepSummary::default()
        },
        figures: BTreeSet::new(),
        numbers: vec![true; plan.keys.len()],
        best: Vec::new(),
        points: Vec::new(),
        gates: BTreeMap::new(),
        refusals: BTreeMap::new(),
    };
    let every = plan.jobs.len().div_ceil(POINTS).max(1);
    let mut recheck = Recheck::new(folder, plan);
    let mut sound = |job| {
        let result = read_result(folder, plan, job).map_err(|fault| fault.to_string())?;
        check_verdict(folder, plan, &result).map_err(|fault| fault.to_string())?;
        recheck.job(job).map_err(|changed| changed.to_string())?;
        Ok(result)
    };
    for job in 0..plan.jobs.len() {
        let result: JobResult = match sound(job) {
            Ok(result) => result,
            Err(fault) => {
                faults += 1;
                if first.len() < FAULTS {
                    first.push(fault);
                }
                continue;
            }
        };
        *seen.merged.states.entry(result.state.word()).or_default() += 1;
        for name in result.figures.keys() {
            if !seen.figures.contains(name) {
                seen.figures.insert(name.clone());
            }
        }
        for (number, key) in seen.numbers.iter_mut().zip(&plan.keys) {
            *number &= result.values.get(key).is_some_and(Value::is_number);
        }
        for (gate, _) in result.gates.iter().filter(|(_, state)| **state != State::NotAsked) {
            *seen.gates.entry(gate.clone()).or_default() += 1;
        }
        if !result.refused.is_empty() && (seen.refusals.len() < FAULTS || seen.refusals.contains_key(&result.refused)) {
            *seen.refusals.entry(result.refused.clone()).or_default() += 1;
        }
        if result.state == JobState::Pass && seen.merged.fastest_pass.as_ref().is_none_or(|f| time(&result) < f.time_s)
        {
            let values = result.values.clone();
            seen.merged.fastest_pass = Some(Fastest { job, time_s: time(&result), values });
        }
        if job % every == 0 {
            seen.points.push(result.clone());
        }
        seen.best.push(result);
        if seen.best.len() >= 2 * SHOWN {
            shorten(&mut seen.best);
        }
    }
    if faults > 0 {
        return Err(MergeError::Results { count: faults, jobs: plan.jobs.len(), first });
    }
    shorten(&mut seen.best);
    Ok(seen)
}

/// The best jobs: passes before failures, the fastest first.
fn shorten(best: &mut Vec<JobResult>) {
    let order = |a: &JobResult, b: &JobResult| {
        let state = |r: &JobResult| match r.state {
            JobState::Pass => 0,
            JobState::Unchecked => 1,
            JobState::Fail => 2,
            JobState::Refused | JobState::Cut => 3,
        };
        state(a).cmp(&state(b)).then(time(a).total_cmp(&time(b))).then(a.job.cmp(&b.job))
    };
    best.sort_by(order);
    best.truncate(SHOWN);
}

fn write_all(folder: &Path, plan: &Plan, seen: &JobSurvey, beside: &dyn Fn(&str) -> PathBuf) -> Result<(), MergeError> {
    let [table, csv, json, html] = FILES.map(beside);
    write_tables(folder, plan, seen, (&table, &csv))?;
    let text = serde_json::to_string_pretty(&seen.merged).map_err(|e| RecordError::Page { message: e.to_string() })?;
    fs::write(&json, text + "\n").map_err(RecordError::io(&json))?;
    fs::write(&html, render(plan, seen)?).map_err(RecordError::io(&html))?;
    Ok(())
}

/// Columns: job, values, state, why it was refused, digest, figures.
fn columns(plan: &Plan, seen: &JobSurvey) -> Vec<Column> {
    let keys = plan.keys.iter().zip(&seen.numbers);
    let mut all = vec![Column::index("job")];
    all.extend(keys.map(|(key, number)| if *number { Column::real(key, "") } else { Column::text(key) }));
    all.extend(["state", "refused", "digest"].map(Column::text));
    all.extend(seen.figures.iter().map(|name| Column::real(name, "")));
    all
}

fn write_tables(
    folder: &Path,
    plan: &Plan,
    seen: &JobSurvey,
    (parquet, csv): (&Path, &Path),
) -> Result<(), MergeError> {
    let columns = columns(plan, seen);
    let notes = [("sweep", plan.name.clone()), ("made_by", plan.made_by.clone())];
    let mut table = Table::create(parquet, &columns, &notes)?;
    let mut lines = BufWriter::new(File::create(csv).map_err(RecordError::io(csv))?);
    let mut line = |cells: Vec<String>| {
        let cells: Vec<String> = cells.iter().map(|c| quoted(c)).collect();
        writeln!(lines, "{}", cells.join(",")).map_err(RecordError::io(csv))
    };
    line(columns.iter().map(|c| c.name.clone()).collect())?;
    for job in 0..plan.jobs.len() {
        let result = read_result(folder, plan, job).map_err(|fault| MergeError::Results {
            count: 1,
            jobs: plan.jobs.len(),
            first: vec![fault.to_string()],
        })?;
        let mut cells = vec![job.to_string()];
        let mut row = table.row()?;
        row.index(u32::try_from(job).ok());
        for (key, number) in plan.keys.iter().zip(&seen.numbers) {
            let value = result.values.get(key).unwrap_or(&Value::Null);
            if *number {
                row.real(value.as_f64());
            } else {
                row.text(Some(&words(value)));
            }
            cells.push(words(value));
        }
        for text in [result.state.word(), &result.refused, &result.digest] {
            row.text(Some(text));
            cells.push(text.to_owned());
        }
        for name in &seen.figures {
            let value = result.figures.get(name).copied().flatten();
            row.real(value);
            cells.push(value.map_or_else(String::new, |v| v.to_string()));
        }
        drop(row);
        line(cells)?;
    }
    lines.flush().map_err(RecordError::io(csv))?;
    table.finish()?;
    debug_assert!(columns.iter().filter(|c| c.kind == ColumnKind::Index).count() == 1);
    Ok(())
}

/// A cell of a CSV file (RFC 4180).
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

/// A value as people write it.
fn words(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

#[derive(Serialize)]
struct PageRow {
    job: usize,
    class: &'static str,
    word: &'static str,
    cells: Vec<String>,
    gates: String,
}

#[derive(Serialize)]
struct Figure {
    name: String,
    svg: String,
}

fn render(plan: &Plan, seen: &JobSurvey) -> Result<String, RecordError> {
    let figures: Vec<&str> = FIGURES
        .into_iter()
        .filter(|name| seen.best.iter().any(|r| r.figures.get(*name).is_some_and(Option::is_some)))
        .collect();
    let row = |r: &JobResult| {
        let values = plan.keys.iter().map(|key| r.values.get(key).map_or_else(String::new, words));
        let shown = figures.iter().map(|name| r.figures.get(*name).copied().flatten().map_or_else(String::new, short));
        let gates: Vec<String> = r
            .gates
            .iter()
            .map(|(name, state)| match state {
                State::NotAsked => format!("{name} (not asked)"),
                _ => name.clone(),
            })
            .collect();
        let class = if r.state == JobState::Refused { "unchecked" } else { r.state.word() };
        let gates = if r.refused.is_empty() { gates.join(", ") } else { r.refused.clone() };
        PageRow { job: r.job, class, word: r.state.word(), cells: values.chain(shown).collect(), gates }
    };
    let rows: Vec<PageRow> = seen.best.iter().map(row).collect();
    let charts: Vec<Figure> = plan
        .keys
        .iter()
        .zip(&seen.numbers)
        .filter(|(_, number)| **number)
        .map(|(key, _)| Figure { name: key.clone(), svg: chart(key, &seen.points) })
        .collect();
    let data = context! {
            policy => policy(&[TABLES]), tables_script => TABLES, name => plan.name.clone(), made_by => plan.made_by.clone(),
            merged => Serde(&seen.merged), keys => plan.keys.clone(), figures, rows => Serde(&rows), charts => Serde(&charts),
            gates => seen.gates.iter().map(|(g, n)| (g.clone(), *n)).collect::<Vec<_>>(),
            refusals => seen.refusals.iter().map(|(r, n)| (r.clone(), *n)).collect::<Vec<_>>(),
            part => seen.points.len() < plan.jobs.len(),
    };
    fill("sweep.html", TEMPLATE, data)
}

/// Machine time over the values of a key.
fn chart(key: &str, points: &[JobResult]) -> String {
    let of = |pass: bool| {
        let of_state =
            points.iter().filter(move |r| (r.state == JobState::Pass) == pass && r.state != JobState::Refused);
        of_state.filter_map(|r| Some([r.values.get(key)?.as_f64()?, time(r)])).filter(|p| p[1].is_finite()).collect()
    };
    let series = [(Style::Circles, of(true)), (Style::Triangles, of(false))];
    Chart {
        label: format!("machine time over {key}"),
        axes: [key.to_owned(), "machine time, s".to_owned()],
        range: None,
        size: [520.0, 260.0],
        series: series.map(|(style, points)| Series { style, points }).into(),
        limits: Vec::new(),
        abscissa: true,
    }
    .svg()
}

/// Six digits at most.
fn short(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (5 - value.abs().log10().floor() as i32).clamp(0, 9) };
    let text = format!("{value:.*}", usize::try_from(digits).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be_and_numbers_are_short() {
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("a\"b"), "\"a\"\"b\"");
        assert_eq!(quoted("plain"), "plain");
        assert_eq!(
            [short(0.0), short(123.456_789), short(0.000_123_456_7), short(1e9)],
            ["0", "123.457", "0.000123457", "1000000000"]
        );
    }
}
