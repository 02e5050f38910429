//! Findings for gouged areas and areas with material left.

use proveout_surface::Area;

use crate::{
    cut::engine::Facts,
    judge::surface_survey::Measured,
    prepare::prepared::Prepared,
    verdict::{
        finding::{self, Code, Finding},
        log::FindingLog,
    },
};

/// Areas of a kind that get a finding of their own, the worst first; all others share one more. A
/// page of findings is read, a longer list is not, and all of them are counted.
const TOLD: usize = 20;
/// Smaller volumes are written with an exponent, mm3.
const LEAST_PLAIN_MM3: f64 = 1e-3;
/// The last of the six decimals that are written at most: what is smaller has no more.
const SIX_DECIMALS: f64 = 1e-6;

/// Findings for the areas beyond the tolerances, the worst first; the place in the program is the block that
/// made the worst point.
pub(crate) fn judge_areas(
    prepared: &Prepared,
    facts: &Facts,
    measured: &Measured,
    finished: bool,
    log: &mut FindingLog,
) {
    let tolerances = &prepared.scene.file.tolerances;
    let floor = measured.deviation.tolerance_floor_mm.unwrap_or(0.0);
    let kinds = [
        (&finding::GOUGE, ["gouge", "gouges"], &measured.gouges, tolerances.gouge_mm),
        (&finding::EXCESS, ["excess", "areas with excess"], &measured.excesses, tolerances.excess_mm),
    ];
    // On a part that is not finished there is material everywhere.
    for (code, words, areas, limit) in kinds.into_iter().take(if finished { 2 } else { 1 }) {
        let (told, rest) = areas.split_at(areas.len().min(TOLD));
        for area in told {
            let mut f = of_area(code, words[0], area, [limit, floor]);
            f.block = area.made_by.and_then(|p| facts.block_of_piece.get(p as usize)).copied();
            let round = f.block.and_then(|b| facts.envelopes.get(&b)).and_then(|t| prepared.tools.tools.get(*t));
            if let Some(tool) = round {
                f.message += &format!(
                    "; {} is modeled here as a cylinder (a cylinder of its diameter is its envelope): if the design has the hole before the thread, the depth of the thread is no fault",
                    tool.name
                );
            }
            if let Some((file, line)) = f.block.and_then(|b| facts.places.get(b as usize)).and_then(Option::as_ref) {
                (f.file, f.line) = (Some(file.to_string()), Some(*line));
            }
            log.push(f);
        }
        if let Some(worst) = rest.first() {
            let sum = |of: fn(&Area) -> f64| rest.iter().map(of).sum::<f64>();
            let (area, volume) = (sum(|a| a.area), sum(|a| a.volume));
            let message = format!(
                "{} more {}, up to {:.4} mm: {} mm2 and {} mm3 together",
                rest.len(),
                words[1],
                worst.depth,
                figure(area),
                figure(volume)
            );
            let mut f = FindingLog::of(code, message);
            (f.value, f.limit, f.unit) = (Some(worst.depth), Some(limit), Some("mm".into()));
            (f.area_mm2, f.volume_mm3, f.areas) = (Some(area), Some(volume), Some(rest.len() as u64));
            log.push(f);
        }
    }
}

/// Reports the sheets that no gate counts: one finding for all of them, at the highest one.
pub(crate) fn tell_films(facts: &Facts, measured: &Measured, log: &mut FindingLog) {
    let Some(highest) = measured.films.first() else { return };
    let mut f = FindingLog::of(&finding::FILM, format!("{}: not counted as a fault", films_in_words(measured)));
    put_place(&mut f, facts, highest);
    (f.value, f.unit) = (Some(highest.depth), Some("mm".into()));
    f.volume_mm3 = measured.deviation.film_volume_mm3;
    f.areas = measured.deviation.films;
    log.push(f);
}

/// Reports what taps have cut outside the core holes: one finding for all threads, at the largest.
pub(crate) fn tell_threads(prepared: &Prepared, facts: &Facts, measured: &Measured, log: &mut FindingLog) {
    let Some(first) = measured.threads.first() else { return };
    let mut f = FindingLog::of(&finding::THREAD, threads_in_words(prepared, facts, measured));
    put_place(&mut f, facts, first);
    f.volume_mm3 = measured.deviation.thread_volume_mm3;
    f.areas = measured.deviation.threads;
    log.push(f);
}

/// How many threads, their volume, their tools, and where the first of them is.
pub(crate) fn threads_in_words(prepared: &Prepared, facts: &Facts, measured: &Measured) -> String {
    let Some(first) = measured.threads.first() else { return String::new() };
    let mut tools: Vec<String> = Vec::new();
    let of_area = |a: &Area| a.made_by.and_then(|p| facts.strokes.get(&p)).map(|s| s.tool());
    for tool in measured.threads.iter().filter_map(of_area).filter_map(|t| prepared.tools.tools.get(t)) {
        let words = tool.description.trim();
        let name =
            if words.is_empty() || words == tool.name { tool.name.clone() } else { format!("{} ({words})", tool.name) };
        if !tools.contains(&name) {
            tools.push(name);
        }
    }
    let [x, y, z]: [f64; 3] = first.point.coords.into();
    let (count, hole) = match measured.threads.len() {
        1 => ("a thread".to_owned(), "a core hole"),
        n => (format!("{n} threads"), "core holes"),
    };
    format!(
        "{count} in {hole} of the design: {} mm3 between core and outer diameter, cut by {}, for example at X{x:.3} Y{y:.3} Z{z:.3} of the workpiece",
        figure(measured.threads.iter().map(|a| a.volume).sum()),
        tools.join(", ")
    )
}

/// Place on the part and in the program.
fn put_place(f: &mut Finding, facts: &Facts, area: &Area) {
    f.block = area.made_by.and_then(|p| facts.block_of_piece.get(p as usize)).copied();
    if let Some((file, line)) = f.block.and_then(|b| facts.places.get(b as usize)).and_then(Option::as_ref) {
        (f.file, f.line) = (Some(file.to_string()), Some(*line));
    }
    f.point_mm = Some(area.point.coords.into());
}

/// How many sheets are left above the design, their largest thickness, their height, their volume,
/// and where.
pub(crate) fn films_in_words(measured: &Measured) -> String {
    let Some(highest) = measured.films.first() else { return String::new() };
    let [x, y, z]: [f64; 3] = highest.point.coords.into();
    let volume: f64 = measured.films.iter().map(|a| a.volume).sum();
    let count = match measured.films.len() {
        1 => "a sheet".to_owned(),
        n => format!("{n} sheets"),
    };
    format!(
        "{count} of material at most {:.4} mm thick, the resolution of the twin, up to {:.4} mm above \
         the design, for example at X{x:.3} Y{y:.3} Z{z:.3} of the workpiece, {} mm3 in all",
        measured.film_thickness,
        highest.depth,
        scientific(volume)
    )
}

/// Three figures of a volume that may be next to nothing.
fn scientific(value: f64) -> String {
    if value > 0.0 && value < LEAST_PLAIN_MM3 { format!("{value:.2e}") } else { figure(value) }
}

fn of_area(code: &Code, word: &str, area: &Area, [limit, floor]: [f64; 2]) -> Finding {
    let [x, y, z]: [f64; 3] = area.point.coords.into();
    let what = match area.wall {
        Some(wall) if area.foil => format!("a wall of {wall:.4} mm, within the tolerance, is cut away"),
        Some(wall) => format!("{word} of {:.4} mm: a wall of {wall:.4} mm is cut away", area.depth),
        None => format!("{word} of {:.4} mm", area.depth),
    };
    let raw = if area.made_by.is_none() { "; not cut by any motion: the raw stock has this shape" } else { "" };
    let message = format!(
        "{what} at X{x:.3} Y{y:.3} Z{z:.3} of the workpiece, {} mm2 and {} mm3{raw}; allowed: {limit:.4} mm plus {floor:.4} mm resolution of the measurement",
        figure(area.area),
        figure(area.volume)
    );
    let mut f = FindingLog::of(code, message);
    (f.value, f.limit, f.unit) = (Some(area.depth), Some(limit), Some("mm".into()));
    (f.area_mm2, f.volume_mm3, f.areas) = (Some(area.area), Some(area.volume), Some(1));
    f.point_mm = Some(area.point.coords.into());
    f
}

/// Three figures, as far as they are known.
fn figure(value: f64) -> String {
    let digits = (2.0 - value.abs().max(SIX_DECIMALS).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}
