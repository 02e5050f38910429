//! Facts about a run for its recording: boxes for the cameras, and a page of text.

use proveout_geom::Aabb;
use proveout_sim::observer::Setup;

use crate::in_process::tiles::StockTiles;

/// Boxes of the machine at home (machine frame) and of the workpiece (workpiece frame), mm.
pub(crate) fn boxes(setup: &Setup<'_>) -> (Aabb, Aabb) {
    let home = setup.machine.home();
    let mut all = Aabb::empty();
    for (i, body) in setup.machine.bodies.iter().enumerate() {
        let pose = setup.machine.body_pose(i, &home);
        for p in &body.mesh.positions {
            all.grow(&pose.point(p));
        }
    }
    let work = setup.stock.bounds();
    let machine_from_work = setup.machine.machine_from_table(&home) * setup.table_from_work;
    for p in &proveout_geom::box_mesh(&work).positions {
        all.grow(&machine_from_work.point(p));
    }
    (all, work)
}

/// What the recording shows and leaves out, in Markdown.
pub(crate) fn about(setup: &Setup<'_>, tiles: &[StockTiles]) -> String {
    let mut patches = String::new();
    for (patch, tiles) in setup.patches.iter().zip(tiles.iter().skip(1)) {
        let cell = patch.stock().cell_mm();
        patches +=
            &format!(" In the patch {} it is drawn from every {} node of {cell} mm.", patch.name(), nth(tiles.step()));
    }
    let step = tiles.first().map_or(1, StockTiles::step);
    let cell = setup.stock.cell_mm();
    format!(
        "# {}\n\nScene {}, machine {}.\n\nLengths in mm, angles in degrees; the timelines are simulated time (`sim_time`) and the executed block (`nc_block`): the arrow keys of the time panel go block by block there.\n\n\
         - The stock is drawn from every {} node of {cell} mm; what is thinner than {} mm may be missing here.{patches}\n\
         - Poses: at most 50 a second. Plots: smallest and largest sample of stretches of 40 ms. Both spacings double \
         after every 15 000 rows.\n\
         - Path in feed: blue where 95 percent and more of the programmed feed are reached, then teal (80), green (60), yellow (40), \
         orange (20), red; rapids are gray. The eye next to `path` in the tree of the viewer switches it off.\n\
         - Findings and messages: a click on the time of a line sets the time.\n\
         - At the end the measured surface takes the place of the stock; red is gouge, blue is material left.\n\
         - Exact values: signals.parquet, blocks.parquet, surface.parquet, verdict.json of the same folder.\n",
        setup.program,
        setup.scene.file.name,
        setup.machine.name,
        nth(step),
        cell * step as f64,
    )
}

/// First, second, fourth and so on: steps are powers of two.
fn nth(step: usize) -> String {
    match step {
        1 => "single".into(),
        2 => "2nd".into(),
        32 => "32nd".into(),
        n => format!("{n}th"),
    }
}
