//! Engagement and loads along the path, as a table: a row a sample and slice of the cutter.
//!
//! Rows of one sample follow each other from the tip up; what belongs to the whole sample is the same in all
//! of them.

use std::path::Path;

use proveout_sim::{EngagedSlice, feeds::EngagementRow};

use crate::{
    error::RecordError,
    parquet_table::{Column, Table},
};

fn columns() -> Vec<Column> {
    vec![
        Column::index("sample"),
        Column::index("block"),
        Column::text("file"),
        Column::index("line"),
        Column::text("tool_name"),
        Column::real("begin_s", "s"),
        Column::real("end_s", "s"),
        Column::real("path_begin_mm", "mm"),
        Column::real("path_end_mm", "mm"),
        Column::real("spindle_rpm", "1/min"),
        Column::real("feed_mm_min", "mm/min"),
        Column::real("axial_depth_mm", "mm"),
        Column::real("radial_depth_mm", "mm"),
        Column::real("removal_mm3_s", "mm3/s"),
        Column::real("chip_thickness_max_mm", "mm"),
        Column::real("force_peak_N", "N"),
        Column::real("force_mean_N", "N"),
        Column::real("torque_peak_Nm", "N m"),
        Column::real("torque_mean_Nm", "N m"),
        Column::real("power_kW", "kW"),
        Column::real("deflection_um", "um"),
        Column::index("slice"),
        Column::real("slice_low_mm", "mm"),
        Column::real("slice_high_mm", "mm"),
        Column::real("slice_entry_deg", "deg"),
        Column::real("slice_exit_deg", "deg"),
        Column::index("slice_all_around"),
        Column::real("slice_feed_across_mm_min", "mm/min"),
        Column::real("slice_feed_down_mm_min", "mm/min"),
        Column::real("slice_feed_per_tooth_mm", "mm"),
        Column::real("slice_volume_mm3", "mm3"),
    ]
}

/// Width across the feed, over all slices.
fn radial_depth(slices: &[EngagedSlice]) -> Option<f64> {
    let all = slices.iter().filter(|s| s.across[0] <= s.across[1]);
    let both = all.fold([f64::INFINITY, f64::NEG_INFINITY], |a, s| [a[0].min(s.across[0]), a[1].max(s.across[1])]);
    (both[0] <= both[1]).then_some(both[1] - both[0])
}

/// Writes the samples of a run. Angles are those of a tooth seen from the spindle, in the sense in which it
/// turns: 0 on one side of the feed, 90 degrees in front.
///
/// # Errors
/// [`RecordError`] with the path.
pub fn write_engagement_table(path: &Path, rows: &[EngagementRow], cell_mm: f64) -> Result<(), RecordError> {
    let bound =
        format!("ranges of angles are short of the true ones by less than asin({cell_mm} / radius) at each end");
    let mut table = Table::create(path, &columns(), &[("bound", bound), ("resolution_mm", cell_mm.to_string())])?;
    for (number, row) in rows.iter().enumerate() {
        let (s, loads) = (&row.sample, row.loads);
        let duration = s.time[1] - s.time[0];
        let heights = row
            .slices
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |a, s| [a[0].min(s.height[0]), a[1].max(s.height[1])]);
        let depth = (heights[0] <= heights[1]).then_some(heights[1] - heights[0]);
        let forces = loads.filter(|_| row.has_forces);
        for slice in &row.slices {
            let feed = s.feed_at(0.5 * (slice.height[0] + slice.height[1]));
            let teeth_per_s = row.tool.1.map(|n| f64::from(n) * s.speed_rpm / 60.0).filter(|rate| *rate > 0.0);
            table
                .row()?
                .index(u32::try_from(number).unwrap_or(u32::MAX))
                .index(s.block)
                .text(row.place.as_ref().map(|(file, _)| file.as_str()))
                .index(row.place.as_ref().map(|(_, line)| *line))
                .text(Some(&row.tool.0))
                .reals([s.time[0], s.time[1], s.path[0], s.path[1], s.speed_rpm, 60.0 * s.tip_speed()])
                .real(depth)
                .real(radial_depth(&row.slices))
                .real((duration > 0.0).then(|| s.volume_mm3() / duration))
                .real(loads.map(|l| l.chip_mm))
                .real(forces.map(|l| l.force_peak_n))
                .real(forces.map(|l| l.force_mean_n))
                .real(forces.map(|l| l.torque_peak_nm))
                .real(forces.map(|l| l.torque_mean_nm))
                .real(forces.map(|l| l.power_kw))
                .real(forces.and_then(|l| l.deflection_um))
                .index(slice.slice)
                .reals(slice.height)
                .real(slice.range.map(|r| r[0].to_degrees()))
                .real(slice.range.map(|r| r[1].to_degrees()))
                .index(u32::from(slice.around))
                .reals(feed.map(|f| 60.0 * f))
                .real(teeth_per_s.map(|rate| feed[0].hypot(feed[1]) / rate))
                .real(slice.volume_mm3);
        }
    }
    table.finish()
}
