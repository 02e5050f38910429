//! Free tool axes along a program: `free_axes.json`, and what page and recording show of it.

use std::{fmt::Write as _, fs, path::Path};

use proveout_sim::{
    AxisState, Observer, OrientationCell,
    free_axes::{FreeAxes, FreePlace},
    observer::{Batch, ObserverError, Outcome, Setup},
};
use serde::Serialize;

use crate::{envelope::Envelope, error::RecordError};

/// Maps with a picture on the page, evenly along the program.
const PAGE_MAPS: usize = 12;
/// Radius of the picture on the page, in its own units.
const DISK: f64 = 90.0;
/// Borders of cells are written to this step, degrees.
const CELL_DIGIT_DEG: f64 = 1.0 / 8192.0;
/// Keeps the scale of a map without a tilt a number, radian.
const LEAST_TILT: f64 = 1e-9;

/// The whole file.
#[derive(Serialize)]
struct FreeAxesFile {
    schema_version: u32,
    finest_cell_deg: f64,
    tilt_limit_deg: f64,
    clearance_mm: f64,
    gouge_mm: f64,
    touch_mm: f64,
    unchecked: Vec<String>,
    places: Vec<OrientationRow>,
}

#[derive(Serialize)]
struct OrientationRow {
    time_s: f64,
    file: Option<String>,
    line: Option<u32>,
    tool: String,
    point_mm: [f64; 3],
    normal: [f64; 3],
    feed: [f64; 3],
    axis: [f64; 3],
    tilt_deg: f64,
    yaw_deg: f64,
    state: &'static str,
    room_deg: f64,
    refusal: Option<&'static str>,
    free_share: f64,
    blocked_share: f64,
    unknown_share: f64,
    cells: Vec<(f64, f64, f64, f64, &'static str)>,
}

impl OrientationRow {
    fn of(place: &FreePlace) -> Self {
        let map = &place.map;
        let [feed, _, normal] = map.frame();
        let [tilt, yaw] = map.angles(&place.axis);
        let [free, blocked, unknown] = map.shares();
        let cell = |c: OrientationCell| {
            let [t, y] = [c.tilt, c.yaw].map(|r| r.map(|a| (a.to_degrees() / CELL_DIGIT_DEG).round() * CELL_DIGIT_DEG));
            (t[0], t[1], y[0], y[1], c.state.name())
        };
        Self {
            time_s: place.time_s,
            file: place.line.as_ref().map(|(f, _)| f.to_string()),
            line: place.line.as_ref().map(|(_, l)| *l),
            tool: place.tool.clone(),
            point_mm: place.point.coords.into(),
            normal: normal.into(),
            feed: feed.into(),
            axis: place.axis.into(),
            tilt_deg: tilt.to_degrees(),
            yaw_deg: yaw.to_degrees(),
            state: state_name(place),
            room_deg: place.room.to_degrees(),
            refusal: map.refusal().map(|r| r.reason()),
            free_share: free,
            blocked_share: blocked,
            unknown_share: unknown,
            cells: map.cells().map(cell).collect(),
        }
    }
}

/// What is known of the axis of the program.
fn state_name(place: &FreePlace) -> &'static str {
    place.map.state(&place.axis).map_or("beyond the largest tilt", AxisState::name)
}

/// Writes `free_axes.json`, where the call asks for it.
#[derive(Debug, Default)]
pub struct FreeAxesObserver {
    folder: Option<std::path::PathBuf>,
}

impl Observer for FreeAxesObserver {
    fn name(&self) -> &'static str {
        "free axes"
    }

    fn begin(&mut self, _setup: &Setup<'_>, folder: &Path) -> Result<(), ObserverError> {
        self.folder = Some(folder.to_owned());
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn free_axes(&mut self, _setup: &Setup<'_>, axes: &FreeAxes) -> Result<(), ObserverError> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let settings = &axes.settings;
        let file = FreeAxesFile {
            schema_version: 1,
            finest_cell_deg: settings.finest_cell.to_degrees(),
            tilt_limit_deg: settings.tilt_limit.to_degrees(),
            clearance_mm: settings.clearance,
            gouge_mm: settings.gouge,
            touch_mm: axes.touch_mm,
            unchecked: axes.unchecked.clone(),
            places: axes.places.iter().map(OrientationRow::of).collect(),
        };
        let path = folder.join("free_axes.json");
        // In one line: a map has hundreds of cells.
        let mut text = serde_json::to_string(&file).map_err(|e| RecordError::io(&path)(e.into()))?;
        text.push('\n');
        fs::write(&path, text).map_err(RecordError::io(&path))?;
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, _outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// What page and recording keep of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShownAxes {
    pub(crate) words: String,
    /// Room (degrees) over time, one value a place.
    pub(crate) room: Envelope,
    /// Titles and pictures.
    pub(crate) figures: Vec<[String; 2]>,
    pub(crate) unchecked: Vec<String>,
}

impl ShownAxes {
    pub(crate) fn of(axes: &FreeAxes) -> Self {
        let mut room = Envelope::default();
        axes.places.iter().for_each(|p| room.push(p.time_s, p.room.to_degrees()));
        Self {
            words: axes.words(),
            room,
            figures: evenly(axes.places.len(), PAGE_MAPS).map(|i| figure(&axes.places[i])).collect(),
            unchecked: axes.unchecked.clone(),
        }
    }
}

/// At most `most` of the places, evenly, with the first and the last.
pub(crate) fn evenly(of: usize, most: usize) -> impl Iterator<Item = usize> {
    let count = of.min(most);
    (0..count).map(move |k| if count > 1 { k * (of - 1) / (count - 1) } else { 0 })
}

fn figure(place: &FreePlace) -> [String; 2] {
    let line = place.line.as_ref().map_or_else(String::new, |(_, l)| format!("line {l}, "));
    let title = format!("{line}{:.1} s: room {:.1}°", place.time_s, place.room.to_degrees());
    let size = DISK + 8.0;
    let mut out = format!(
        r#"<svg class="axes-map" viewBox="{0} {0} {1} {1}" role="img" aria-label="Free tool axes"><circle class="blocked" r="{DISK}"/>"#,
        -size,
        2.0 * size
    );
    let limit = place.map.cells().map(|c| c.tilt[1]).fold(LEAST_TILT, f64::max);
    for cell in place.map.cells() {
        let class = match cell.state {
            AxisState::Free => "free",
            AxisState::Unknown => "unknown",
            AxisState::Blocked => continue,
        };
        let [low, high] = cell.tilt.map(|t| DISK * t / limit);
        let at = |r: f64, yaw: f64| [r * yaw.cos(), -r * yaw.sin()];
        let [a, b, c, d] = [at(low, cell.yaw[0]), at(high, cell.yaw[0]), at(high, cell.yaw[1]), at(low, cell.yaw[1])];
        write!(
            out,
            r#"<path class="{class}" d="M{:.1} {:.1}L{:.1} {:.1}A{high:.1} {high:.1} 0 0 0 {:.1} {:.1}L{:.1} {:.1}A{low:.1} {low:.1} 0 0 1 {:.1} {:.1}Z"/>"#,
            a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1], a[0], a[1]
        )
        .unwrap_or_default(); // a string takes everything
    }
    let [tilt, yaw] = place.map.angles(&place.axis);
    let r = DISK * (tilt / limit).min(1.0);
    write!(
        out,
        r#"<circle class="rim" r="{DISK}"/><path class="feed" d="M{DISK} 0l6 0"/><circle class="axis" cx="{:.1}" cy="{:.1}" r="4"/></svg>"#,
        r * yaw.cos(),
        -r * yaw.sin()
    )
    .unwrap_or_default();
    [title, out]
}
