//! The stock before the first cut, as the scene says.

use std::{io::BufReader, path::Path};

use proveout_geom::{Aabb, Point, TriMesh};
use proveout_input::{InputError, open_regular_file};
use proveout_stock::{BetweenRays, Patch, PatchError, PatchPlan, RawBody, StockError, TriDexel};
use serde_spanned::Spanned;

use crate::{
    evidence::{
        digest,
        inputs::{Inputs, MeshRole},
        manifest::{MANIFEST, Manifest},
    },
    prepare::{
        error::SimError,
        memory::{self, Demand, GROWTH, HISTORY_MEMORY, Memory},
        part_mesh::solid,
        part_shape::Shape,
        stock_on_rays,
    },
    scene::{PatchFile, Scene, StockFile},
    verdict::partial_run,
};

/// File of a run folder that holds the stock that is left.
pub const STOCK_FILE: &str = "stock.dexel";
/// Scale of the four decimals of a cell's edge that is told.
const FOUR_DECIMALS: f64 = 1e4;

/// File of a run folder that holds what is left in a patch and round it.
pub fn patch_file(name: &str) -> String {
    format!("stock-patch-{name}.dexel")
}

/// The raw stock of a run: where it lies, and its rays until the run takes them.
#[derive(Debug)]
pub struct RawStock {
    bounds: Aabb,
    cells: [f64; 3],
    /// Volume of its shape, mm³.
    own_volume: Option<f64>,
    rays: Option<(TriDexel, Vec<Patch>)>,
    between: BetweenRays,
    mesh: Option<TriMesh>,
}

impl RawStock {
    /// Its box, workpiece frame.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// What lies between its rays.
    pub(crate) fn between(&self) -> &BetweenRays {
        &self.between
    }

    /// Its triangles, where it is a mesh that was not mended.
    pub(crate) fn mesh(&self) -> Option<&TriMesh> {
        self.mesh.as_ref()
    }

    /// Edges of its cells along x, y and z, mm.
    pub fn cells_mm(&self) -> [f64; 3] {
        self.cells
    }

    /// Volume of its shape, mm³; none of a mesh that was mended.
    pub fn own_volume(&self) -> Option<f64> {
        self.own_volume
    }

    /// Longest edge of a cell, mm.
    pub fn cell_mm(&self) -> f64 {
        self.cells.into_iter().fold(0.0, f64::max)
    }

    /// The stock and its patches, once.
    ///
    /// # Errors
    /// When they were taken before.
    pub fn take(&mut self) -> Result<(TriDexel, Vec<Patch>), StockError> {
        self.rays.take().ok_or_else(|| StockError::Degenerate { what: "it was taken by another run".into() })
    }
}

/// Cells along each side of the grid on which the intervals of the design are counted.
const SAMPLED: f64 = 47.0;
/// Intervals of the stock for one of the design: while it is cut it has more.
const FOR_ONE: f64 = 1.25;

/// Intervals of material that a ray will hold, as a mean.
fn intervals(file: &StockFile, body: &RawBody, part: Option<&TriMesh>) -> f64 {
    if let Some(told) = &file.intervals_per_ray {
        return *told.get_ref();
    }
    let of_part = part.and_then(|mesh| {
        let cells: [f64; 3] = (mesh.aabb().size() / SAMPLED).into();
        TriDexel::from_mesh_repaired(mesh, cells, u64::MAX).ok().map(|few| few.intervals_per_ray())
    });
    (body.intervals_per_ray() + GROWTH).max(FOR_ONE * of_part.unwrap_or(0.0))
}

/// Makes the stock and its patches; files that are read are added to `inputs`. Nothing is allocated
/// before the whole run is known to fit into `limit_bytes` and `announce` was called; the announced
/// memory is returned, too, in bytes.
pub(crate) fn make(
    scene: &Scene,
    cells: [f64; 3],
    limit_bytes: u64,
    demand: &Demand<'_>,
    inputs: &mut Inputs,
    announce: &mut dyn FnMut(&Memory),
) -> Result<(RawStock, Memory), SimError> {
    let file = scene.file.stock.get_ref();
    let mut body = formed(scene, file, limit_bytes, inputs)?;
    let bounds = body.prepare(cells, !file.patch.is_empty())?;
    let refused = |patch: &Spanned<PatchFile>, e: &PatchError| {
        let message = format!("patch {:?}: {e}", patch.get_ref().name);
        SimError::from(scene.fault(patch.span().start, message, e.remedy()))
    };
    let plans_with = |factor: f64| -> Result<Vec<PatchPlan>, (&Spanned<PatchFile>, PatchError)> {
        let plan = |patch| {
            let p: &PatchFile = Spanned::get_ref(patch);
            PatchPlan::new(&bounds, cells, &p.aabb(), p.cell_mm.edges().map(|c| c * factor)).map_err(|e| (patch, e))
        };
        file.patch.iter().map(plan).collect()
    };
    let plans = plans_with(1.0).map_err(|(patch, e)| refused(patch, &e))?;
    let intervals = intervals(file, &body, demand.part);
    let held = memory::resident();
    let names = || file.patch.iter().map(|p| p.get_ref().name.clone());
    let memory = |cells: [f64; 3], plans: &[PatchPlan]| {
        let of_patches = plans.iter().map(|p| TriDexel::rays_in(p.grid_bounds(), p.cells_mm()));
        let rays: Vec<f64> = std::iter::once(TriDexel::rays_in(&bounds, cells)).chain(of_patches).collect();
        let size = bounds.size();
        let along_x = (size.y / cells[1]).ceil() * (size.z / cells[2]).ceil();
        let names = std::iter::once("stock".to_owned()).chain(names());
        Memory {
            stocks: names.zip(&rays).map(|(n, r)| (n, memory::of_stock(*r, intervals) as u64)).collect(),
            rest: held.saturating_add(memory::of_stages(&rays, along_x, intervals, demand) as u64),
            history: if file.history { HISTORY_MEMORY } else { 0 },
            limit: limit_bytes,
        }
    };
    let announced = memory(cells, &plans);
    if announced.working() > limit_bytes {
        let fits = |factor: f64| match file.patch.is_empty() {
            true => memory(cells.map(|c| c * factor), &[]).working() <= limit_bytes,
            false => plans_with(factor).is_ok_and(|plans| memory(cells, &plans).working() <= limit_bytes),
        };
        return Err(too_large(scene, file, cells, &announced, fits));
    }
    announce(&announced);
    let mut stock = body.stock(cells, u64::MAX)?;
    stock_on_rays::check(scene, &body, &stock)?;
    stock.watch_engagement(scene.file.engagement);
    let mut patches = Vec::new();
    for (patch, plan) in file.patch.iter().zip(plans) {
        patches.push(Patch::new(&patch.get_ref().name, plan, &body, u64::MAX)?);
    }
    if file.history {
        stock.keep_history();
        patches.iter_mut().for_each(|p| p.stock_mut().keep_history());
    }
    let between = BetweenRays::new(&body, &stock);
    let own_volume = body.own_volume();
    let (bounds, cells) = (stock.bounds(), stock.cells_mm());
    let raw =
        RawStock { bounds, cells, own_volume, rays: Some((stock, patches)), between, mesh: body.triangles().cloned() };
    Ok((raw, announced))
}

/// The refusal of a run that does not fit; `fits` says whether it would with all cells of the
/// patches, or of the stock where it has none, made longer by a factor.
fn too_large(
    scene: &Scene,
    file: &StockFile,
    cells: [f64; 3],
    memory: &Memory,
    fits: impl Fn(f64) -> bool,
) -> SimError {
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let stocks: Vec<String> = memory.stocks.iter().map(|(name, b)| format!("{name} {:.0} MiB", mib(*b))).collect();
    let limit = mib(memory.limit);
    let longest = cells.into_iter().fold(0.0, f64::max);
    // Doubled until it fits, then halved between; a patch coarser than the stock does not fit either.
    let fitting = (1..40).map(|k| 1.05_f64.powi(k * k.min(8))).find(|f| fits(*f)).map(|highest| {
        let (mut low, mut high) = (1.0, highest);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if fits(middle) { high = middle } else { low = middle }
        }
        high
    });
    let edge = |cell: f64, factor: f64| (cell * factor * FOUR_DECIMALS).ceil() / FOUR_DECIMALS;
    let Some(first) = file.patch.first() else {
        let message = format!(
            "a run with {longest} mm cells needs {:.0} MiB ({}; the rest {:.0} MiB), more than the {limit:.0} MiB allowed",
            mib(memory.working()),
            stocks.join(", "),
            mib(memory.rest)
        );
        let help = fitting.map_or_else(
            || "use a machine, a part or fixtures with fewer triangles".to_owned(),
            |f| format!("use cells of {:.4} mm or more", edge(longest, f)),
        );
        return scene.fault(scene.file.resolution_mm.span().start, message, help).into();
    };
    let message = format!(
        "{} and the rest of the run {:.0} MiB need {:.0} MiB, together more than the {limit:.0} MiB allowed",
        stocks.join(", "),
        mib(memory.rest),
        mib(memory.working())
    );
    let help = fitting.map_or_else(
        || "give the stock a coarser resolution_mm, or make the patches smaller".to_owned(),
        |factor| {
            let cells = file.patch.iter().map(Spanned::get_ref).map(|p| {
                let longest = p.cell_mm.edges().into_iter().fold(0.0, f64::max);
                format!("{:.4} mm for {:?}", edge(longest, factor), p.name)
            });
            format!("use cells of {}, or smaller boxes", cells.collect::<Vec<_>>().join(", "))
        },
    );
    scene.fault(first.span().start, message, help).into()
}

fn formed(scene: &Scene, file: &StockFile, limit_bytes: u64, inputs: &mut Inputs) -> Result<RawBody, SimError> {
    if let Some(b) = &file.block {
        return Ok(RawBody::block(&b.aabb()));
    }
    if let Some(c) = &file.cylinder {
        return Ok(RawBody::cylinder(&Point::from(c.base_mm), &c.along.direction(), c.radius_mm, c.height_mm)?);
    }
    if let Some(run) = &file.from_run {
        return of_a_run(file, &scene.resolve(run), limit_bytes, inputs);
    }
    let blade = scene.file.part.as_ref().and_then(|p| p.blade.as_ref());
    if let (Some(allowance), Some(blade)) = (file.blade_allowance_mm, blade) {
        return Ok(RawBody::mesh(Shape::of_scene(scene, blade, allowance)?.mesh(scene, blade.chord_error_mm)?.0)?);
    }
    let Some(named) = file.named_mesh() else {
        return Err(StockError::Degenerate { what: "its shape is missing".into() }.into());
    };
    let (mesh, path) = inputs.mesh(scene, MeshRole::Stock, named)?;
    if file.repair {
        return RawBody::repaired_mesh(&mesh).map_err(|e| match e {
            StockError::Mesh(source) => SimError::Mesh { path, source },
            other => other.into(),
        });
    }
    Ok(RawBody::mesh(solid(mesh, path)?)?)
}

/// Refuses a stock that is not the one in the manifest next to it: the setup would start from a
/// part that was never cut. A file without a manifest was taken out of its run folder by hand, and
/// is accepted as it is.
fn as_the_run_left_it(path: &Path) -> Result<(), InputError> {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { return Ok(()) };
    let name = name.to_string_lossy();
    if !folder.join(MANIFEST).is_file() {
        return Ok(());
    }
    let help = "run the earlier setup again, or move the file out of the run folder to use it as it is";
    let refuse = |message: String| InputError::file(path, message, help);
    let manifest = Manifest::read(folder).map_err(|e| refuse(e.to_string()))?;
    let known =
        manifest.digest_of(&name).ok_or_else(|| refuse(format!("{MANIFEST} in the same folder does not list it")))?;
    let (_, found) = digest::measure(path).map_err(|e| refuse(format!("cannot be read: {e}")))?;
    if found == known {
        return Ok(());
    }
    Err(refuse(format!(
        "is not as the run left it: its SHA-256 is {found}, and {MANIFEST} in the same folder says {known}"
    )))
}

/// What an earlier run has left, with those of its patches that this scene has too, by name.
fn of_a_run(file: &StockFile, run: &Path, limit_bytes: u64, inputs: &mut Inputs) -> Result<RawBody, SimError> {
    let path = if run.is_dir() { run.join(STOCK_FILE) } else { run.to_owned() };
    let mut load = |role: String, path: &Path| -> Result<TriDexel, SimError> {
        let opened = open_regular_file(path).map_err(|e| {
            let help = "run the earlier setup first, or correct the path of `from_run`";
            InputError::file(path, format!("cannot be read: {e}"), help)
        })?;
        as_the_run_left_it(path)?;
        if let Some(what) = path.parent().and_then(partial_run::refused_as_stock) {
            let help = "run the earlier setup to its end, without --preview and --stop-at";
            return Err(InputError::file(path, what, help).into());
        }
        inputs.push(role, path.to_owned());
        let refuse = |message: String, help: &str| SimError::from(InputError::file(path, message, help));
        let mut left = TriDexel::load(&mut BufReader::new(opened), limit_bytes)
            .map_err(|e| refuse(e.to_string(), "run the earlier setup again"))?;
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
