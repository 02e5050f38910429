//! The stock before the first cut, as the scene says.

use std::{
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
};

use proveout_geom::{Point, TriMesh, Vector, read_mesh};
use proveout_stock::TriDexel;

use crate::{
    config::ConfigError,
    error::SimError,
    prepare::{blade_mesh, read_solid},
    scene::{Scene, StockFile},
};

/// File of a run folder that holds the stock that is left.
pub const STOCK_FILE: &str = "stock.dexel";

/// Makes the stock; files that are read are added to `inputs`.
pub(crate) fn make(
    scene: &Scene,
    cells: [f64; 3],
    limit_bytes: u64,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<TriDexel, SimError> {
    let file = scene.file.stock.get_ref();
    let mut stock = formed(scene, file, cells, limit_bytes, inputs)?;
    if file.history {
        stock.keep_history();
    }
    stock.watch_engagement(scene.file.engagement);
    Ok(stock)
}

fn formed(
    scene: &Scene,
    file: &StockFile,
    cells: [f64; 3],
    limit_bytes: u64,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<TriDexel, SimError> {
    if let Some(b) = &file.block {
        return Ok(TriDexel::from_box(&b.aabb(), cells, limit_bytes)?);
    }
    if let Some(c) = &file.cylinder {
        let base = Point::from(c.base_mm);
        return Ok(TriDexel::from_cylinder(&base, &Vector::z(), c.radius_mm, c.height_mm, cells, limit_bytes)?);
    }
    if let Some(run) = &file.from_run {
        return of_a_run(file, &scene.resolve(run), cells, limit_bytes, inputs);
    }
    let blade = scene.file.part.as_ref().and_then(|p| p.blade.as_ref());
    if let (Some(allowance), Some(blade)) = (file.blade_allowance_mm, blade) {
        return Ok(TriDexel::from_mesh(&blade_mesh(scene, blade, allowance)?, cells, limit_bytes)?);
    }
    let path = scene.resolve(file.mesh.as_deref().unwrap_or(Path::new("")));
    inputs.push(("stock".into(), path.clone()));
    if file.repair {
        let mesh: TriMesh = read_mesh(&path)?;
        return TriDexel::from_mesh_repaired(&mesh, cells, limit_bytes).map_err(|e| match e {
            proveout_stock::StockError::Mesh(source) => SimError::Mesh { path, source },
            other => other.into(),
        });
    }
    Ok(TriDexel::from_mesh(&read_solid(&path)?, cells, limit_bytes)?)
}

/// What an earlier run has left, in the frame and the cells of this one.
fn of_a_run(
    file: &StockFile,
    run: &Path,
    cells: [f64; 3],
    limit_bytes: u64,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<TriDexel, SimError> {
    let path = if run.is_dir() { run.join(STOCK_FILE) } else { run.to_owned() };
    let opened = File::open(&path).map_err(|e| {
        let help = "run the earlier setup first, or correct the path of `from_run`";
        ConfigError::file(&path, format!("cannot be read: {e}"), help)
    })?;
    inputs.push(("stock".into(), path.clone()));
    let refuse = |message: String, help: &str| SimError::from(ConfigError::file(&path, message, help));
    let mut left = TriDexel::load(&mut BufReader::new(opened), limit_bytes)
        .map_err(|e| refuse(e.to_string(), "run the earlier setup again to write it anew"))?;
    if let Some(time_s) = file.at_time_s {
        let help = "run the earlier setup with `history = true` under [stock], or leave `at_time_s` out";
        (left, _) = left.at_time(time_s).map_err(|e| refuse(e.to_string(), help))?;
    }
    let pose = file.place.unwrap_or_default().table_from_work();
    Ok(left.regridded(&pose, cells, limit_bytes)?)
}
