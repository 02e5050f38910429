//! `setup.html`: what is on the machine for this program, for the person who sets it up.

mod picture;

use std::{fs, path::Path};

use minijinja::value::Serde;
use proveout_controller::Event;
use proveout_geom::{Aabb, Point, Pose, TriMesh};
use proveout_sim::{
    Observer,
    observer::{Batch, ObserverError, Outcome, Setup},
    scene::OffsetFile,
    verdict::{State, Verdict},
};
use proveout_tool::{Role, Tool};
use serde::Serialize;
use serde_json::{Value, json};

use crate::{
    error::RecordError,
    page_template::{fill, policy},
    report::format::{duration, fixed, tool_name},
};

const TEMPLATE: &str = include_str!("../../templates/setup.html");
const CSS: &str = include_str!("../../templates/report.css");
/// Most pictures at tool changes, and most stops that are listed.
const PICTURES: usize = 8;
const STOPS: usize = 200;

/// Something at which the operator is asked for, or which a program says to him.
#[derive(Clone, Debug, Serialize)]
struct Moment {
    time: String,
    #[serde(skip)]
    block: u32,
    place: String,
    what: String,
    /// PNG in Base64; empty without a picture.
    picture: String,
}

#[derive(Debug, Serialize)]
struct BodyRow {
    name: String,
    size: String,
    /// Lower and upper corner in the table frame.
    from: String,
    to: String,
}

/// Writes `setup.html`.
#[derive(Debug, Default)]
pub struct SetupSheetObserver {
    bodies: Vec<BodyRow>,
    picture: String,
    moments: Vec<Moment>,
    pictures: usize,
    left_out: usize,
    /// Place of the last block.
    last: String,
}

impl SetupSheetObserver {
    fn moment(&mut self, time: f64, block: u32, what: String, picture: String) {
        if self.moments.len() < STOPS {
            let place = self.last.clone();
            self.moments.push(Moment { time: duration(time), block, place, what, picture });
        } else {
            self.left_out += 1;
        }
    }
}

impl Observer for SetupSheetObserver {
    fn name(&self) -> &'static str {
        "setup sheet"
    }

    fn begin(&mut self, setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        *self = Self::default();
        let table = |mesh: &TriMesh, pose: &Pose| Aabb::of_points(&mesh.transformed(pose).positions);
        let stock = setup.stock.bounds();
        let corners = (0..8).map(|k| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { stock.min[axis] } else { stock.max[axis] };
            setup.table_from_work.point(&Point::new(pick(0), pick(1), pick(2)))
        });
        let on_table = Aabb::of_points(&corners.collect::<Vec<_>>());
        self.bodies.push(body_row("Stock (the box round it)", &on_table));
        for (name, mesh) in setup.fixtures {
            self.bodies.push(body_row(name, &table(mesh, &Pose::identity())));
        }
        self.picture = picture::clamped(setup, setup.stock, None)?;
        Ok(())
    }

    fn batch(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        for event in batch.events {
            match event {
                Event::ToolChange { time, block, tool } => {
                    let tool = tool.and_then(|t| setup.tools.tools.get(t));
                    let what = tool.map_or_else(
                        || "The spindle is empty".into(),
                        |t| format!("Tool {}", tool_name(t.number, &t.name)),
                    );
                    let mut picture = String::new();
                    if let Some(tool) = tool.filter(|_| self.pictures < PICTURES) {
                        picture = picture::clamped(setup, batch.stock, Some(tool))?;
                        self.pictures += 1;
                    }
                    self.moment(*time, *block, what, picture);
                }
                Event::Stop { time, block, optional } => {
                    let what = if *optional { "Optional stop (M1)" } else { "Stop (M0)" };
                    self.moment(*time, *block, what.into(), String::new());
                }
                Event::Message { time, block, text } if !text.trim().is_empty() => {
                    self.moment(*time, *block, format!("Message: {}", text.trim()), String::new());
                }
                _ => {}
            }
        }
        for row in batch.blocks {
            let file = crate::report::format::file_name(&row.file);
            // Before the first block with motion there is none to come after.
            for moment in self.moments.iter_mut().filter(|m| m.place.is_empty() && m.block < row.block) {
                moment.place = format!("{file}, before line {}", row.line);
            }
            for moment in self.moments.iter_mut().rev().take_while(|m| m.block >= row.block) {
                // Blocks without motion are no rows: the last one before them is named.
                let word = if moment.block == row.block { "line" } else { "after line" };
                moment.place = format!("{file}, {word} {}", row.line);
            }
            self.last = format!("{file}, after line {}", row.line);
        }
        Ok(())
    }

    fn end(&mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        let text = self.render(setup, outcome)?;
        let path = outcome.folder.join("setup.html");
        fs::write(&path, text).map_err(RecordError::io(&path))?;
        Ok(())
    }
}

impl SetupSheetObserver {
    fn render(&self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<String, RecordError> {
        let file = &setup.scene.file;
        let entry = file.program.iter().find(|p| p.name == setup.program);
        let offsets = entry.and_then(|p| p.work_offsets.as_ref()).unwrap_or(&file.work_offsets);
        let v = outcome.verdict;
        let tools: Vec<Value> = v
            .tools
            .iter()
            .filter_map(|used| {
                let same = |t: &Tool| t.number == used.number && t.name == used.name;
                let index = setup.tools.tools.iter().position(same)?;
                let notes = setup.tools.notes.get(index);
                let chosen = notes.into_iter().flat_map(|n| &n.chosen).flat_map(|(keys, _)| keys);
                let chosen: Vec<&str> = chosen.map(String::as_str).collect();
                Some(tool_row(setup.tools.tools.get(index)?, used.min_overhang_mm, &chosen))
            })
            .collect();
        let start = file.start.tool;
        let at = setup.table_from_work.point(&Point::origin());
        let turned = setup.table_from_work.vector(&proveout_geom::Vector::x());
        let upright = setup.table_from_work.vector(&proveout_geom::Vector::z());
        let tilt = upright.z.clamp(-1.0, 1.0).acos().to_degrees();
        let turn = turned.y.atan2(turned.x).to_degrees();
        let (state, open) = verdict_of(v);
        let data = json!({
            "css": CSS,
            "policy": policy(&[]),
            "generator": format!("Written by proveout {}", env!("CARGO_PKG_VERSION")),
            "program": setup.program,
            "scene": v.scene,
            "machine": setup.machine.name,
            "description": file.description.trim(),
            "time": duration(v.time.total_s),
            "state": state.to_lowercase(),
            "open": open,
            "picture": self.picture,
            "mount": [place(&at), fixed(turn, 3), fixed(tilt, 3)],
            "mount_chosen": file.mount.chosen,
            "workholding": file.workholding_in_words(),
            "verdict": v.verdict.word(),
            "not_asked": v.not_asked().join(", "),
            "offset_axes": OFFSET_AXES,
            "offsets": offsets.iter().map(|(name, o)| offset_row(setup, name, o)).collect::<Vec<_>>(),
            "bodies": self.bodies,
            "tools": tools,
            "start": start,
            "moments": self.moments,
            "left_out": self.left_out,
        });
        fill("setup.html", TEMPLATE, Serde(&data))
    }
}

/// The verdict in a word, and the gates that keep it from being a pass: a sheet of a run that failed must not
/// look like one for the machine.
fn verdict_of(v: &Verdict) -> (&'static str, String) {
    let named = |state: State| {
        let gates = v.gates.iter().filter(|g| g.state == state).map(|g| g.gate.name());
        gates.collect::<Vec<_>>().join(", ")
    };
    match v.verdict {
        State::Pass => ("PASS", String::new()),
        State::Fail => ("FAIL", named(State::Fail)),
        State::Unchecked => ("UNCHECKED", named(State::Unchecked)),
        State::NotAsked => ("NOT ASKED", named(State::NotAsked)),
    }
}

const OFFSET_AXES: [&str; 6] = ["X, mm", "Y, mm", "Z, mm", "A, °", "B, °", "C, °"];

fn place(p: &Point) -> String {
    format!("X {} Y {} Z {}", fixed(p.x, 3), fixed(p.y, 3), fixed(p.z, 3))
}

fn offset_row(setup: &Setup<'_>, name: &str, o: &OffsetFile) -> Value {
    let turned = [o.A_deg, o.B_deg, o.C_deg].iter().any(|a| *a != 0.0);
    let zero = setup.machine.program_zero().filter(|_| !turned).map(|z| {
        let in_table = z + proveout_geom::Vector::new(o.X_mm, o.Y_mm, o.Z_mm);
        place(&setup.table_from_work.inverse().point(&in_table))
    });
    let values = [o.X_mm, o.Y_mm, o.Z_mm, o.A_deg, o.B_deg, o.C_deg].map(|v| fixed(v, 3));
    json!({ "name": name, "values": values, "zero": zero.unwrap_or_else(|| "–".into()) })
}

fn body_row(name: &str, bounds: &Aabb) -> BodyRow {
    let size = bounds.size();
    BodyRow {
        name: name.to_owned(),
        size: format!("{} × {} × {} mm", fixed(size.x, 2), fixed(size.y, 2), fixed(size.z, 2)),
        from: place(&bounds.min),
        to: place(&bounds.max),
    }
}

fn tool_row(tool: &Tool, overhang: Option<f64>, chosen: &[&str]) -> Value {
    let radius = tool.cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max);
    // Projection from the holder: from the tip to the lowest point of the holder.
    let lowest = tool.bodies.iter().filter(|b| b.role == Role::Holder).map(|b| b.profile.z_min());
    let clamped = lowest.fold(f64::INFINITY, f64::min);
    let now = if clamped.is_finite() { format!("clamped {}", fixed(clamped, 1)) } else { "not stated".into() };
    json!({
        "number": tool.number,
        "name": tool.name,
        "description": tool.description,
        "diameter": fixed(2.0 * radius, 3),
        "length": fixed(tool.gauge_length, 3),
        "flutes": fixed(tool.flute_length, 1),
        "overhang": overhang.map_or(now.clone(), |least| format!("{} at least; {now}", fixed(least, 1))),
        "holder": if tool.has_holder { "modeled" } else { "not modeled, not checked" },
        "chosen": chosen.join(", "),
    })
}
