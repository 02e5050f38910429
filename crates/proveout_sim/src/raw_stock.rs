//! The stock before the first cut, as the scene says.

use std::{
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
};

use proveout_geom::{Point, TriMesh, Vector, read_mesh};
use proveout_stock::{Patch, PatchError, PatchPlan, RawBody, StockError, TriDexel};
use serde_spanned::Spanned;

use crate::{
    config::ConfigError,
    error::SimError,
    prepare::{blade_mesh, read_solid},
    scene::{PatchFile, Scene, StockFile},
};

/// File of a run folder that holds the stock that is left.
pub const STOCK_FILE: &str = "stock.dexel";

/// File of a run folder that holds what is left in a patch and round it.
pub fn patch_file(name: &str) -> String {
    format!("stock-patch-{name}.dexel")
}

/// What rays will take, told before they are made.
#[derive(Clone, Debug, PartialEq)]
pub struct StockMemory {
    /// The stock first, then each patch by its name, bytes.
    pub parts: Vec<(String, u64)>,
    /// Allowed for all together, bytes.
    pub limit: u64,
}

/// Makes the stock and its patches; files that are read are added to `inputs`. Nothing is allocated before all of them together
/// are known to fit into `limit_bytes` and `announce` was told.
pub(crate) fn make(
    scene: &Scene,
    cells: [f64; 3],
    limit_bytes: u64,
    inputs: &mut Vec<(String, PathBuf)>,
    announce: &mut dyn FnMut(&StockMemory),
) -> Result<(TriDexel, Vec<Patch>), SimError> {
    let file = scene.file.stock.get_ref();
    let mut body = formed(scene, file, limit_bytes, inputs)?;
    let bounds = body.prepare(cells, !file.patch.is_empty())?;
    let refused = |patch: &Spanned<PatchFile>, e: &PatchError| {
        let message = format!("patch {:?}: {e}", patch.get_ref().name);
        SimError::from(scene.fault(patch.span().start, message, e.remedy()))
    };
    let mut plans = Vec::new();
    for patch in &file.patch {
        let p = patch.get_ref();
        let plan = PatchPlan::new(&bounds, cells, &p.aabb(), p.cell_mm.edges()).map_err(|e| refused(patch, &e))?;
        plans.push((p.name.as_str(), plan));
    }
    let of_stock = TriDexel::memory_estimate(&bounds, cells);
    let room = limit_bytes.saturating_sub(of_stock);
    let of_patches: u64 = plans.iter().map(|(_, plan)| plan.memory_estimate()).sum();
    if of_stock <= limit_bytes && of_patches > room {
        return Err(too_large(scene, file, [of_stock, of_patches, limit_bytes], |factor| {
            let wider = |p: &Spanned<PatchFile>| {
                let p = p.get_ref();
                PatchPlan::new(&bounds, cells, &p.aabb(), p.cell_mm.edges().map(|c| c * factor))
            };
            let plans: Result<Vec<PatchPlan>, PatchError> = file.patch.iter().map(wider).collect();
            plans.is_ok_and(|plans| plans.iter().map(PatchPlan::memory_estimate).sum::<u64>() <= room)
        }));
    }
    let patches = plans.iter().map(|(name, plan)| ((*name).to_owned(), plan.memory_estimate()));
    let parts = std::iter::once(("stock".to_owned(), of_stock)).chain(patches).collect();
    announce(&StockMemory { parts, limit: limit_bytes });
    let mut stock = body.stock(cells, limit_bytes)?;
    stock.watch_engagement(scene.file.engagement);
    let mut patches = Vec::new();
    for (name, plan) in plans {
        patches.push(Patch::new(name, plan, &body, limit_bytes)?);
    }
    if file.history {
        stock.keep_history();
        patches.iter_mut().for_each(|p| p.stock_mut().keep_history());
    }
    Ok((stock, patches))
}

/// The refusal of patches that do not fit beside the stock; `[stock, patches, limit]` in bytes, `fits` tells whether all cells of
/// patches made longer by a factor fit.
fn too_large(scene: &Scene, file: &StockFile, bytes: [u64; 3], fits: impl Fn(f64) -> bool) -> SimError {
    let [of_stock, of_patches, limit] = bytes.map(|b| b as f64 / f64::from(1 << 20));
    let message = format!(
        "the stock needs {of_stock:.0} MiB and its patches {of_patches:.0} MiB, together more than the {limit:.0} MiB allowed"
    );
    // Doubled until it fits, then halved between; a patch coarser than the stock does not fit either.
    let highest = (1..40).map(|k| 1.05_f64.powi(k * k.min(8))).find(|f| fits(*f));
    let help = highest.map_or_else(
        || "give the stock a coarser resolution_mm, or the patches less room".to_owned(),
        |highest| {
            let (mut low, mut high) = (1.0, highest);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if fits(middle) { high = middle } else { low = middle }
            }
            let cells: Vec<String> = file
                .patch
                .iter()
                .map(Spanned::get_ref)
                .map(|p| {
                    let longest = p.cell_mm.edges().into_iter().fold(0.0, f64::max);
                    format!("{:.4} mm for {:?}", (longest * high * 1e4).ceil() / 1e4, p.name)
                })
                .collect();
            format!("cells of {} fit, or boxes that hold less", cells.join(", "))
        },
    );
    scene.fault(file.patch.first().map_or(0, |p| p.span().start), message, help).into()
}

fn formed(
    scene: &Scene,
    file: &StockFile,
    limit_bytes: u64,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<RawBody, SimError> {
    if let Some(b) = &file.block {
        return Ok(RawBody::block(&b.aabb()));
    }
    if let Some(c) = &file.cylinder {
        return Ok(RawBody::cylinder(&Point::from(c.base_mm), &Vector::z(), c.radius_mm, c.height_mm)?);
    }
    if let Some(run) = &file.from_run {
        return of_a_run(file, &scene.resolve(run), limit_bytes, inputs);
    }
    let blade = scene.file.part.as_ref().and_then(|p| p.blade.as_ref());
    if let (Some(allowance), Some(blade)) = (file.blade_allowance_mm, blade) {
        return Ok(RawBody::mesh(blade_mesh(scene, blade, allowance)?)?);
    }
    let path = scene.resolve(file.mesh.as_deref().unwrap_or(Path::new("")));
    inputs.push(("stock".into(), path.clone()));
    if file.repair {
        let mesh: TriMesh = read_mesh(&path)?;
        return RawBody::repaired_mesh(&mesh).map_err(|e| match e {
            StockError::Mesh(source) => SimError::Mesh { path, source },
            other => other.into(),
        });
    }
    Ok(RawBody::mesh(read_solid(&path)?)?)
}

/// What an earlier run has left, with those of its patches that this scene has too, by name.
fn of_a_run(
    file: &StockFile,
    run: &Path,
    limit_bytes: u64,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<RawBody, SimError> {
    let path = if run.is_dir() { run.join(STOCK_FILE) } else { run.to_owned() };
    let mut load = |role: String, path: &Path| -> Result<TriDexel, SimError> {
        let opened = File::open(path).map_err(|e| {
            let help = "run the earlier setup first, or correct the path of `from_run`";
            ConfigError::file(path, format!("cannot be read: {e}"), help)
        })?;
        inputs.push((role, path.to_owned()));
        let refuse = |message: String, help: &str| SimError::from(ConfigError::file(path, message, help));
        let mut left = TriDexel::load(&mut BufReader::new(opened), limit_bytes)
            .map_err(|e| refuse(e.to_string(), "run the earlier setup again to write it anew"))?;
        if let Some(time_s) = file.at_time_s {
            let help = "run the earlier setup with `history = true` under [stock], or leave `at_time_s` out";
            (left, _) = left.at_time(time_s).map_err(|e| refuse(e.to_string(), help))?;
        }
        Ok(left)
    };
    let left = load("stock".into(), &path)?;
    let mut fine = Vec::new();
    for patch in file.patch.iter().map(Spanned::get_ref) {
        let beside = path.with_file_name(patch_file(&patch.name));
        if beside.is_file() {
            fine.push(load(format!("stock patch {}", patch.name), &beside)?);
        }
    }
    Ok(RawBody::earlier(left, fine, &file.place.unwrap_or_default().table_from_work())?)
}
