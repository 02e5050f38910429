//! `signals.parquet`, `blocks.parquet`, `surface.parquet`.
//!
//! Positions of tip and surface are in the workpiece frame W, mm. Joints are in mm or degrees as their
//! columns say.

use std::path::Path;

use proveout_controller::{MoveKind, Sample};
use proveout_geom::Pose;
use proveout_sim::{
    Observer, SurfaceMap, SurfaceTexture,
    observer::{Batch, BlockRow, ObserverError, Outcome, PointBand, SampleSignals, Setup},
};
use proveout_tool::Tool;

use crate::{
    error::RecordError,
    parquet_table::{Column, Table},
    units::{JointUnit, PER_MINUTE, UM_PER_MM},
};

fn kind_name(kind: MoveKind) -> &'static str {
    match kind {
        MoveKind::Rapid => "rapid",
        MoveKind::Feed => "feed",
        MoveKind::Handling => "handling",
    }
}

/// Columns of `signals.parquet` for the joints of a machine, in their order.
pub(crate) fn signal_columns(joints: &[JointUnit]) -> Vec<Column> {
    let mut columns =
        vec![Column::real("time_s", "s"), Column::index("block"), Column::text("kind"), Column::real("path_mm", "mm")];
    for j in joints {
        let (name, unit) = (j.name.as_str(), j.unit);
        let derived = if j.rotary { ["deg/s", "deg/s2", "deg/s3"] } else { ["mm/s", "mm/s2", "mm/s3"] };
        columns.extend([
            Column::real(format!("{name}_{unit}"), unit),
            Column::real(format!("{name}_actual_{unit}"), unit),
            Column::real(format!("velocity_{name}_{unit}_s"), derived[0]),
            Column::real(format!("acceleration_{name}_{unit}_s2"), derived[1]),
            Column::real(format!("jerk_{name}_{unit}_s3"), derived[2]),
            Column::real(format!("following_error_{name}_{unit}"), unit),
            Column::real(format!("{}_{name}_{}", j.effort(), j.force_unit), j.force_unit),
            Column::real(format!("power_{name}_W"), "W"),
            Column::real(format!("energy_{name}_J"), "J"),
        ]);
    }
    columns.extend(["x", "y", "z"].map(|a| Column::real(format!("tip_{a}_mm"), "mm")));
    columns.extend(["i", "j", "k"].map(|a| Column::real(format!("axis_{a}"), "1")));
    columns.extend([
        Column::real("feed_programmed_mm_min", "mm/min"),
        Column::real("feed_mm_min", "mm/min"),
        Column::real("removal_mm3_s", "mm3/s"),
        Column::real("clearance_mm", "mm"),
        Column::index("tool"),
    ]);
    columns
}

fn signal_row(
    table: &mut Table,
    joints: &[JointUnit],
    work_from_table: &Pose,
    sample: &Sample,
    signals: &SampleSignals,
    tool: Option<u32>,
) -> Result<(), RecordError> {
    let mut row = table.row()?;
    row.real(sample.time).index(sample.block).text(Some(kind_name(sample.kind))).real(sample.path_length);
    for (i, j) in joints.iter().enumerate() {
        let (commanded, actual) = (sample.commanded[i], sample.actual[i]);
        row.reals(
            [commanded, actual, sample.velocity[i], sample.acceleration[i], sample.jerk[i], actual - commanded]
                .map(|v| v * j.factor),
        );
        let drive = sample.drive.as_ref();
        row.real(drive.map(|d| d.force[i] * j.force_factor))
            .real(drive.map(|d| d.power[i]))
            .real(drive.map(|d| d.energy[i]));
    }
    let pose = sample.pose.transformed(work_from_table);
    row.reals([pose.tip.x, pose.tip.y, pose.tip.z, pose.axis.x, pose.axis.y, pose.axis.z]);
    row.real((sample.kind == MoveKind::Feed).then_some(sample.feed_programmed * PER_MINUTE))
        .real(sample.feed * PER_MINUTE)
        .real(signals.removal_rate)
        .real(signals.clearance)
        .index(tool);
    Ok(())
}

/// Columns of `blocks.parquet`.
pub(crate) fn block_columns() -> Vec<Column> {
    vec![
        Column::index("block"),
        Column::text("file"),
        Column::index("line"),
        Column::text("kind"),
        Column::index("tool"),
        Column::text("tool_name"),
        Column::real("start_s", "s"),
        Column::real("end_s", "s"),
        Column::real("time_s", "s"),
        Column::real("length_mm", "mm"),
        Column::real("feed_programmed_mm_min", "mm/min"),
        Column::real("feed_mean_mm_min", "mm/min"),
        Column::real("volume_mm3", "mm3"),
        Column::real("engagement_mm", "mm"),
        Column::real("axial_depth_mm", "mm"),
        Column::real("radial_width_mm", "mm"),
        Column::real("entry_deg", "deg"),
        Column::real("exit_deg", "deg"),
        Column::real("chip_thickness_max_mm", "mm"),
    ]
}

fn block_row(table: &mut Table, b: &BlockRow, tool: Option<&Tool>) -> Result<(), RecordError> {
    let time = b.end_time - b.start_time;
    let mean = (time > 0.0).then_some(b.length / time * PER_MINUTE);
    table
        .row()?
        .index(b.block)
        .text(Some(&b.file))
        .index(b.line)
        .text(Some(kind_name(b.kind)))
        .index(tool.map(|t| t.number))
        .text(tool.map(|t| t.name.as_str()))
        .reals([b.start_time, b.end_time, time, b.length])
        .real(b.feed.map(|f| f * PER_MINUTE))
        .real(mean)
        .reals([b.volume_mm3, b.engagement_mm])
        .real(b.engagement.map(|e| e.axial_depth_mm))
        .real(b.engagement.and_then(|e| e.radial_width_mm))
        .real(b.engagement.and_then(|e| e.entry).map(f64::to_degrees))
        .real(b.engagement.and_then(|e| e.exit).map(f64::to_degrees))
        .real(b.engagement.and_then(|e| e.chip_thickness_mm));
    Ok(())
}

/// Columns of `surface.parquet`.
pub(crate) fn surface_columns() -> Vec<Column> {
    let mut columns: Vec<Column> = ["x", "y", "z"].map(|a| Column::real(format!("{a}_mm"), "mm")).into();
    columns.extend(["i", "j", "k"].map(|a| Column::real(format!("normal_{a}"), "1")));
    columns.extend([
        Column::real("deviation_mm", "mm"),
        Column::real("scallop_mm", "mm"),
        Column::real("scallop_geometric_mm", "mm"),
        Column::real("scallop_difference_mm", "mm"),
        Column::index("made_by_piece"),
        Column::text("patch"),
        Column::text("map"),
        Column::index("map_row"),
        Column::index("map_column"),
        Column::real("height_um", "um"),
        Column::index("made_by_block"),
        Column::index("tooth"),
    ]);
    columns
}

/// The table of surface points, band by band.
struct SurfaceTable {
    table: Table,
    names: Vec<String>,
}

impl SurfaceTable {
    /// `names` are those of the patches.
    fn create(path: &Path, names: Vec<String>) -> Result<Self, RecordError> {
        let notes = [
            ("frame", "workpiece W, mm".to_owned()),
            ("deviation", "positive: material left; negative: gouge".into()),
            ("scallop", "height of the ridges next to the point; geometric: from cutter, lean, step and design; difference: measured less geometric".into()),
            ("map", "rows with a map: nodes of a roughness map on the design, height along the normal".into()),
        ];
        Ok(Self { table: Table::create(path, &surface_columns(), &notes)?, names })
    }

    fn add(&mut self, band: &PointBand<'_>) -> Result<(), RecordError> {
        let name = band.patch.and_then(|k| self.names.get(k)).map(String::as_str);
        for p in band.points {
            let mut row = self.table.row()?;
            let difference = p.scallop.zip(p.scallop_geometric).map(|(measured, geometric)| measured - geometric);
            row.reals(p.position).reals(p.normal).real(p.deviation);
            row.real(p.scallop).real(p.scallop_geometric).real(difference).index(p.made_by);
            row.text(name);
            row.text(None).index(None).index(None).real(None).index(None).index(None);
        }
        Ok(())
    }

    /// Rows of a roughness map: the node on the design with its normal, and its height.
    fn add_map(&mut self, texture: &SurfaceTexture) -> Result<(), RecordError> {
        let Some(map) = &texture.map else { return Ok(()) };
        for (i, (point, normal)) in map.points.iter().zip(&map.normals).enumerate() {
            let (height, maker) = (map.heights.get(i).filter(|h| h.is_finite()), map.makers.get(i).copied().flatten());
            let mut row = self.table.row()?;
            row.reals([point.x, point.y, point.z, normal.x, normal.y, normal.z]);
            row.real(None).real(None).real(None).real(None).index(None).text(None).text(Some(&texture.name));
            row.index((i / map.columns) as u32).index((i % map.columns) as u32).real(height.map(|h| UM_PER_MM * h));
            row.index(maker.map(|m| m.block)).index(maker.and_then(|m| m.tooth));
        }
        Ok(())
    }
}

/// Writes the points of a surface map, in their order; `patch` names the patch whose cells gave the point.
///
/// # Errors
/// [`RecordError`] with the path.
pub fn write_surface_table(path: &Path, surface: &SurfaceMap) -> Result<(), RecordError> {
    let mut open = SurfaceTable::create(path, surface.patches.iter().map(|p| p.name.clone()).collect())?;
    for band in surface.point_bands() {
        open.add(&band)?;
    }
    open.table.finish()
}

/// Writes the three tables while the run goes on; memory does not grow with the length of the run.
#[derive(Default)]
pub struct TableObserver {
    open: Option<OpenTables>,
}

struct OpenTables {
    signals: Table,
    blocks: Table,
    surface: SurfaceTable,
    joints: Vec<JointUnit>,
    work_from_table: Pose,
}

impl Observer for TableObserver {
    fn name(&self) -> &'static str {
        "parquet"
    }

    fn begin(&mut self, setup: &Setup<'_>, folder: &Path) -> Result<(), ObserverError> {
        let joints = JointUnit::all(setup.machine);
        let notes = [("machine", setup.machine.name.clone()), ("frame", "tip and axis in workpiece W".to_owned())];
        let signals = Table::create(&folder.join("signals.parquet"), &signal_columns(&joints), &notes)?;
        let blocks = Table::create(&folder.join("blocks.parquet"), &block_columns(), &notes[..1])?;
        let names = setup.patches.iter().map(|p| p.name().into()).collect();
        let surface = SurfaceTable::create(&folder.join("surface.parquet"), names)?;
        self.open =
            Some(OpenTables { signals, blocks, surface, joints, work_from_table: setup.table_from_work.inverse() });
        Ok(())
    }

    fn batch(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let tool_at = |index: Option<u32>| index.and_then(|i| setup.tools.tools.get(i as usize));
        for (i, sample) in batch.samples.iter().enumerate() {
            let beside = batch.signals.get(i).copied().unwrap_or_default();
            let tool = tool_at(beside.tool).map(|t| t.number);
            signal_row(&mut open.signals, &open.joints, &open.work_from_table, sample, &beside, tool)?;
        }
        for block in batch.blocks {
            block_row(&mut open.blocks, block, tool_at(block.tool))?;
        }
        Ok(())
    }

    fn surface_points(&mut self, _setup: &Setup<'_>, band: &PointBand<'_>) -> Result<(), ObserverError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        // No sample follows: what is held of them goes before the points come.
        open.signals.flush()?;
        open.blocks.flush()?;
        Ok(open.surface.add(band)?)
    }

    fn surface_texture(&mut self, setup: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        if setup.scene.file.surface.as_ref().is_some_and(|s| s.save_nodes) {
            open.surface.add_map(texture)?;
        }
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, _outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        if let Some(open) = self.open.take() {
            open.signals.finish()?;
            open.blocks.finish()?;
            open.surface.table.finish()?;
        }
        Ok(())
    }
}
