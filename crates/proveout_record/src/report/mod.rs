//! The page `report.html`: signals are gathered while the run goes on, the page is written at its end.

mod blocks;
mod data;
mod explain;
mod findings;
pub(crate) mod format;
mod gouge_excess_scale;
mod operations;
mod page;
mod path;
mod player;
mod roughness;
pub(crate) mod rows;
mod scallop;
#[cfg(test)]
pub(crate) mod tests;

use std::{fs, path::Path};

use proveout_controller::{Dynamics, Event, LimitKind, MoveKind, servo::Plant};
use proveout_sim::{
    Observer, SurfaceShape, SurfaceTexture,
    free_axes::FreeAxes,
    observer::{Batch, MeshPart, ObserverError, Outcome, PointBand, Setup},
};

use self::{
    blocks::{Blocks, LineNumbers},
    data::{JointSignals, Page, PartView, ProcessSignals, ProgramView},
    explain::{explained, listings, unchecked},
    gouge_excess_scale::Scales,
    operations::Operations,
    path::ToolPath,
    player::{PlayedRun, Player},
};
use crate::{
    contact::ContactPictures,
    deviation_classes::Classes,
    error::RecordError,
    free_axes::ShownAxes,
    inspection::write_inspection,
    part::range_floor,
    roughness_map::ShownTexture,
    surface_picture::{ShownSurface, SurfacePicture},
    units::{JointUnit, PER_MINUTE},
};

/// Most triangles of the page's 3D view: about 2 MB of page.
const VIEW_TRIANGLES: usize = 200_000;
/// Part of the drive's highest force from which on a sample counts as saturated: rounding of the force.
const AT_LIMIT: f64 = 1.0 - 1e-9;
/// Classes of the histogram.
const CLASSES: usize = 41;

/// Writes `report.html`. Of the length of the run it keeps 24 bytes a block; what the player shows is of
/// bounded size.
#[derive(Default)]
pub struct ReportObserver {
    units: Vec<JointUnit>,
    joints: Vec<JointSignals>,
    process: ProcessSignals,
    surface: Option<SurfacePicture>,
    textures: Vec<ShownTexture>,
    contacts: ContactPictures,
    blocks: Blocks,
    path: ToolPath,
    operations: Operations,
    player: Option<Player>,
    axes: Option<ShownAxes>,
}

impl ReportObserver {
    fn surface(&mut self) -> &mut SurfacePicture {
        self.surface.get_or_insert_with(|| SurfacePicture::owned(VIEW_TRIANGLES))
    }
}

impl Observer for ReportObserver {
    fn name(&self) -> &'static str {
        "report"
    }

    fn begin(&mut self, setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        self.units = JointUnit::all(setup.machine);
        let signals = |(unit, joint): (&JointUnit, &proveout_machine::Joint)| JointSignals {
            name: unit.name.clone(),
            effort: unit.effort(),
            unit: unit.unit,
            travel: joint.travel.map(|t| t.map(|l| l * unit.factor)),
            limits: [joint.max_velocity, joint.max_acceleration, joint.max_jerk].map(|l| l.map(|l| l * unit.factor)),
            force_unit: unit.force_unit,
            force_limit: joint.drive.as_ref().and_then(|d| d.max_force).map(|f| f * unit.force_factor),
            ..JointSignals::default()
        };
        self.joints = self.units.iter().zip(&setup.machine.joints).map(signals).collect();
        self.process = ProcessSignals::default();
        self.surface = None;
        self.textures.clear();
        self.contacts = ContactPictures::default();
        self.blocks = Blocks::default();
        self.path = ToolPath::default();
        self.operations = Operations::default();
        self.player = Some(Player::new(setup));
        self.axes = None;
        Ok(())
    }

    fn batch(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        self.contacts.take(setup, batch)?;
        self.blocks.take(batch);
        self.path.take(setup, batch);
        self.operations.take(setup, batch);
        if let Some(player) = &mut self.player {
            player.take(setup, batch, &self.blocks);
        }
        for (i, s) in batch.samples.iter().enumerate() {
            for (k, (joint, unit)) in self.joints.iter_mut().zip(&self.units).enumerate() {
                let values = [s.commanded[k], s.velocity[k], s.acceleration[k], s.jerk[k]];
                for (signal, value) in joint.signals.iter_mut().zip(values) {
                    signal.push(s.time, value * unit.factor);
                }
                if let Some(drive) = &s.drive {
                    joint.following.push(s.time, (s.actual[k] - s.commanded[k]) * unit.factor);
                    let force = drive.force[k] * unit.force_factor;
                    joint.force.push(s.time, force);
                    joint.power.push(s.time, drive.power[k]);
                    if joint.force_limit.is_some_and(|l| force.abs() >= l * AT_LIMIT) {
                        joint.saturated.push(s.time, 1.0);
                    }
                }
            }
            let beside = batch.signals.get(i).copied().unwrap_or_default();
            self.process.feed.push(s.time, s.feed * PER_MINUTE);
            if s.kind == MoveKind::Feed {
                self.process.feed_programmed.push(s.time, s.feed_programmed * PER_MINUTE);
            }
            self.process.removal.push(s.time, beside.removal_rate);
            if let Some(clearance) = beside.clearance {
                self.process.clearance.push(s.time, clearance);
            }
        }
        for event in batch.events {
            match event {
                Event::ToolChange { time, tool, .. } => {
                    let name = tool.and_then(|t| setup.tools.tools.get(t)).map_or("empty spindle", |t| t.name.as_str());
                    self.process.tool_changes.push((*time, name.to_owned()));
                }
                // A drive may be at its limit between two samples alone.
                Event::Limit { time, joint: Some(k), kind: LimitKind::DriveForce, .. } => {
                    if let Some(joint) = self.joints.get_mut(*k) {
                        joint.saturated.push(*time, 1.0);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn surface_points(&mut self, setup: &Setup<'_>, band: &PointBand<'_>) -> Result<(), ObserverError> {
        self.surface().points(setup, band);
        Ok(())
    }

    fn surface_mesh(
        &mut self,
        _setup: &Setup<'_>,
        shape: &SurfaceShape,
        part: &MeshPart<'_>,
    ) -> Result<(), ObserverError> {
        self.surface().mesh(shape, part);
        Ok(())
    }

    fn surface_texture(&mut self, _setup: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        if self.textures.len() < roughness::PAGE_MAPS {
            self.textures.push(ShownTexture::of(texture, roughness::PAGE_SIDE));
        }
        Ok(())
    }

    fn free_axes(&mut self, _setup: &Setup<'_>, axes: &FreeAxes) -> Result<(), ObserverError> {
        self.axes = Some(ShownAxes::of(axes));
        Ok(())
    }

    fn end(&mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        let shown = self.surface.take().map(SurfacePicture::finish).unwrap_or_default();
        let part = part_view(setup, shown, outcome.surface);
        let findings = &outcome.verdict.findings;
        let blocks = std::mem::take(&mut self.blocks);
        let (listings, left_out) = listings(setup, &blocks, findings);
        let numbers = LineNumbers::of(&blocks, &listings);
        let operations = std::mem::take(&mut self.operations).finish();
        let run = PlayedRun {
            blocks: &blocks,
            numbers: &numbers,
            operations: &operations,
            findings,
            end: outcome.verdict.time.total_s,
        };
        let player = self.player.take().and_then(|player| player.finish(setup, &run));
        let program = ProgramView {
            explained: explained(setup, &blocks, &numbers, findings),
            unchecked: unchecked(setup, outcome.verdict),
            listings,
            left_out,
            blocks,
            numbers,
            path: std::mem::take(&mut self.path),
            operations,
            tools: setup.tools.tools.iter().map(|t| (t.number, t.name.clone())).collect(),
        };
        let text = page::render(&Page {
            verdict: outcome.verdict,
            machine: &setup.machine.name,
            description: &setup.scene.file.description,
            method: method(setup, outcome),
            joints: &self.joints,
            process: &self.process,
            part: &part,
            textures: &self.textures,
            contacts: self.contacts.all(),
            program: &program,
            player: player.as_ref(),
            axes: self.axes.as_ref(),
        })?;
        write_inspection(outcome.folder, outcome.verdict, &setup.scene.file.inspect)?;
        let path = outcome.folder.join("report.html");
        fs::write(&path, text).map_err(RecordError::io(&path))?;
        Ok(())
    }
}

fn part_view(setup: &Setup<'_>, shown: ShownSurface, shape: &SurfaceShape) -> PartView {
    let ShownSurface { picture, cell, classes } = shown;
    let t = &setup.scene.file.tolerances;
    let scales = Scales::of(&classes, [t.gouge_mm, t.excess_mm], range_floor(setup));
    let triangles = shape.all_triangles() as usize;
    let mut view = PartView { triangles, picture, scales, cell, ..PartView::default() };
    if let Some(scales) = scales {
        (view.shares, view.outside) = shares(scales, &classes);
    }
    view
}

/// Share of the points in each class between the ends of the scales, and below and above them.
fn shares(scales: Scales, classes: &Classes) -> (Vec<f64>, [f64; 2]) {
    let mut sums = vec![0.0; CLASSES];
    let mut outside = [0.0; 2];
    for (v, weight) in classes.weights().filter(|(v, _)| v.is_finite()) {
        let t = scales.position(v);
        if t < 0.0 {
            outside[0] += weight;
        } else if t > 1.0 {
            outside[1] += weight;
        } else {
            sums[((t * CLASSES as f64) as usize).min(CLASSES - 1)] += weight;
        }
    }
    let all: f64 = sums.iter().sum::<f64>() + outside[0] + outside[1];
    let share = |c: f64| if all > 0.0 { c / all } else { 0.0 };
    (sums.into_iter().map(share).collect(), outside.map(share))
}

/// Edges of cells: one number where they are alike.
fn edges(cells: [f64; 3]) -> String {
    if cells[0] == cells[1] && cells[1] == cells[2] {
        return format::length(cells[0]);
    }
    cells.map(format::length).join(" × ")
}

/// What the run was made with, in rows.
fn method(setup: &Setup<'_>, outcome: &Outcome<'_>) -> Vec<(String, String)> {
    let (file, v) = (&setup.scene.file, outcome.verdict);
    let mut rows: Vec<(String, String)> = Vec::new();
    let mut put = |name: &str, value: String| rows.push((name.into(), value));
    put(
        "Program",
        format!(
            "{}, {} lines, {} blocks with motion, path {}",
            setup.program,
            format::count(u64::from(setup.program_lines)),
            format::count(v.path.blocks),
            format::path(v.path.length_mm)
        ),
    );
    put(
        "Machine",
        if setup.machine.description.is_empty() {
            setup.machine.name.clone()
        } else {
            format!("{}. {}", setup.machine.name, setup.machine.description)
        },
    );
    let chosen: Vec<&str> = setup.machine.trust.iter().filter(|t| t.chosen).map(|t| t.key.as_str()).collect();
    if !chosen.is_empty() {
        put("Machine data that were chosen, not published", chosen.join(", "));
    }
    let stock = &file.stock.get_ref().source;
    if !stock.is_empty() {
        put("Source of the stock", stock.clone());
    }
    put(
        "Stock resolution",
        format!(
            "rays {} apart, ends exact; swept surface within {}{}",
            format::length(v.removal.cell_mm),
            format::length(v.removal.sweep_bound_mm),
            v.removal.regrid_bound_mm.map_or_else(String::new, |bound| format!(
                "; taken over from an earlier run within {}, at its edges {}",
                format::length(bound),
                format::length(v.removal.regrid_edge_bound_mm.unwrap_or(bound))
            ))
        ),
    );
    if !v.removal.patches.is_empty() {
        let patch = |p: &proveout_sim::verdict::PatchUsed| {
            let [x, y, z] = [0, 1, 2].map(|k| format!("{} to {}", p.min_mm[k], p.max_mm[k]));
            format!(
                "{}: X {x}, Y {y}, Z {z} mm, rays {} apart, {} points, swept surface within {}{}",
                p.name,
                edges(p.cells_mm),
                format::count(p.points),
                format::length(p.sweep_bound_mm),
                p.regrid_bound_mm.map_or_else(String::new, |bound| format!(
                    ", taken over from the earlier run within {}, at its edges {}",
                    format::length(bound),
                    format::length(p.regrid_edge_bound_mm.unwrap_or(bound))
                ))
            )
        };
        let all: Vec<String> = v.removal.patches.iter().map(patch).collect();
        put("Patches: finer surface; all else is judged on the stock", all.join("; "));
    }
    put(
        "Motion that cuts",
        match (setup.dynamics, setup.plant) {
            (Dynamics::Ideal, _) => "the programmed path without corner rounding".into(),
            (Dynamics::Planned, _) => "the set points of the control, corners rounded within its tolerance".into(),
            (Dynamics::Servo, Plant::NewtonEuler) => {
                "the joints as the drives bring them: lag, friction, backlash, elasticity, loads by Newton-Euler".into()
            }
            (Dynamics::Servo, Plant::Rapier) => {
                "the joints as the drives bring them: lag, friction, backlash, elasticity, rigid bodies in Rapier"
                    .into()
            }
        },
    );
    if let Some(chord) = v.path.max_chord_error_mm {
        put("Straight pieces stay within", format!("{} of their path", format::length(chord)));
    }
    if let Some(contour) = v.path.max_contour_error_mm {
        put("Largest contour error", format::length(contour));
    }
    if let Some(axis) = v.path.max_axis_error_deg {
        put("Largest error of the tool axis", format!("{axis:.5} degrees"));
    }
    let t = &file.tolerances;
    put(
        "Tolerances",
        format!(
            "gouge {}, material left {}, required clearance {}, touching up to {}",
            format::length(t.gouge_mm),
            format::length(t.excess_mm),
            format::length(t.near_miss_mm),
            format::length(t.contact_mm)
        ),
    );
    put("Interference", format!("{} checks of a motion piece against the world", format::count(v.clearance.checks)));
    rows
}
