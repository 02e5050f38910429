//! In-process stock: three orthogonal sets of rays with exact interval ends (tri-dexels), cut by the exact
//! swept volumes of convex bodies of revolution.
//!
//! Data in: a box, cylinder, closed mesh or the file of an earlier stock; [`SweepItem`]s, each a
//! [`proveout_tool::Profile`] on a motion whose tip runs straight while the axis turns on the great circle.
//! Data out: a [`SweepReport`] an item (volume, longest overlap, depth, where, engagement), exact
//! [`SurfacePoint`]s, a [`SurfaceMesh`], [`Interval`]s on any ray, sections, distances and walls. All in mm
//! in one frame, that of the stock; the caller brings tool poses into it.
//!
//! * [`TriDexel`] – the stock. [`TriDexel::sweep`] removes or probes, in program order and in parallel.
//! * [`Action::Remove`] cuts; [`Action::Probe`] only reports, for rapid motions, shank and holder.
//! * [`Cells`] – edges of the cells, along each axis its own where wanted.
//! * [`TriDexel::surface`], [`TriDexel::tile_surface`] – triangles with sharp edges;
//!   [`TriDexel::take_changed_tiles`] returns the blocks to show again.
//! * [`Patch`] – finer cells over a box, from one [`RawBody`] with the stock; [`SurfaceMesh::inside`],
//!   [`SurfaceMesh::outside`] cut the meshes at its window, [`patched_intervals`] reads rays through both.
//! * [`TriDexel::save`], [`TriDexel::load`] – a file, bit for bit; [`TriDexel::regridded`] – another pose or
//!   other cells, with [`Regrid`] as bound.
//! * [`TriDexel::keep_history`], [`TriDexel::after`] – the stock of any earlier moment without another run.
//! * [`TriDexel::sweep_share`], [`TriDexel::apply_shares`], [`TriDexel::share_rows`] – one stock cut by
//!   several processes, bit for bit as by one.
//! * [`TriDexel::parts`], [`TriDexel::take_part`], [`TriDexel::put_back`], [`TriDexel::moments`] –
//!   separate parts, their removal, their moments of inertia.
//! * [`TriDexel::sweep_measured`], [`Depths`] – how deep a motion, or a run of them, was in the material.
//! * [`TriDexel::watch_engagement`], [`Contact`] – depth, width, angles and chip of every motion.
//! * [`TriDexel::watch_slices`], [`SliceContact`] – the same by slices of the cutter and steps of the path.
//! * [`TileTree`] – boxes round the material, so that what is near is found without looking at every ray.
//! * [`BetweenRays`] – whether a body meets material that no ray sees.
//! * [`Volume`] – how much material there is and how much has gone, so that both add up.
//! * [`TriDexel::stylus_touch`] – where the ball of a stylus touches.
//! * [`Probe`] – sections, nearest points, walls; [`TriDexel::thickness_along`] on the rays themselves.
//!
//! ```
//! use proveout_geom::{Aabb, Point, ToolPose, Vector};
//! use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
//! use proveout_tool::Cutter;
//!
//! let block = Aabb { min: Point::new(0.0, 0.0, -10.0), max: Point::new(40.0, 20.0, 0.0) };
//! let mut stock = TriDexel::from_box(&block, 0.5, 1 << 30)?; // cells of 0.5 mm, at most 1 GiB
//! let tool = Cutter::flat(8.0)?.bodies(20.0)?.remove(0);
//! let at = |x: f64| ToolPose { tip: Point::new(x, 10.0, -2.0), axis: Vector::z() };
//! let motion = SweepMotion { from: at(-10.0), to: at(50.0) };
//! stock.sweep(&[SweepItem { id: 1, body: &tool, action: Action::Remove, motion }]);
//! // A slot of 8 x 2 x 40 mm out of a block of 8000 mm3.
//! assert!((stock.exact_volume() - (8000.0 - 640.0)).abs() < 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Files
//!
//! | folder or file | holds |
//! |---|---|
//! | `field` | rays in tiles, cells, raw bodies, sweeps and what they take away, depths and engagement |
//! | `kernels` | how a moving body meets one ray, or several at once |
//! | `between` | what lies between the rays: raw body and cuts themselves |
//! | `query` | surface, rows, sections, distances, parts |
//! | `persist` | files, earlier moments, other poses and cells, patches |
//! | `sweep_item`, `error` | one body on one motion; why a stock cannot be made |
//!
//! # How a motion meets a ray
//!
//! Every body is one convex function F whose zero set is its skin (`meridian`). The interval that it takes up
//! on a ray over the whole motion is the union over time of an interval each, and its ends lie where normal
//! times velocity is zero or at the ends of the motion. These kernels find them:
//!
//! - `ray_ball`, `lane_ball`: the ball of a ball end, any motion; closed form, one ray, or several at once
//! - `lane_body`, `lane_search`: every body, several rays at once; Newton's method on the envelope, then a
//!   proof for each ray
//! - `ray_translate`: every body on a straight line; cutting planes in (t, s): the set is convex
//! - `ray_turn`: every body while its axis turns; supporting half spaces with a bound of second order,
//!   halving of time
//!
//! The kernels for several rays come first; a ray whose proof fails has a second chance with more samples and
//! in parts of the motion, and then goes to the searches for one ray, which always end. Which instructions
//! the processor has is found at run time (`lanes`), and makes no difference to any bit of the result.
//!
//! The volume that a ball end takes is that of its ball and that of the cylinder or cone above, swept one by
//! one.
//!
//! # Error
//!
//! In the direction of the normal: what is missed lies less than 0.15 um deep in the swept volume
//! of a translation and 0.4 um in that of a turning motion. Outside the swept volume nothing is
//! removed except what the body misses by less than 0.25 um between two times at which it meets the
//! ray. The axis of a turning piece lags the uniform turn by up to angle^3 / 60, which is 0.005 um
//! at 40 mm from the tip and is added. [`TriDexel::sweep_bound_mm`] is the largest bound used so
//! far; the oracle test checks every motion against its own bound. Bodies are taken 1e-7 mm
//! smaller, so that touching counts for nothing; a surface that was just cut may overlap with the
//! same body by the bound. Along a ray that grazes the surface at an angle a, these depths are
//! longer by 1 / sin a.
//!
//! # Order and parallel work
//!
//! Rays are grouped in tiles of 8 x 8. A batch is sorted into the tiles that the box of each motion meets and
//! that still hold material there; every tile then works through its items in their order, on any thread. For
//! that it is spread out over lanes (`tile_field`), one interval of each ray side by side; bounds clear the
//! tile, then blocks of two by two rays by the range of their material (`lane_blocks`), so that cost follows
//! the material that is met. What is taken is subtracted and added up on the lanes as well (`tile_cut`); an
//! end remembers the step and the time that made it, and its normal is made when the batch ends. Sums run
//! over the columns of lanes and then over the tiles in a fixed order: the same bytes at any number of
//! threads, on any processor and for any division into batches.
//!
//! # Limits
//!
//! Details of the mesh of the surface thinner than a cell that no cell center sees are left out of the mesh
//! (not of the rays). Meshes as stock may have several shells, but not crossing or nested ones with the same
//! orientation, unless a repair is asked for. Re-gridding and [`Probe`] see the mesh. Axes at both ends of a
//! motion may not be opposite: the great circle is then not defined, and the axis stays.

mod between;
mod error;
mod field;
mod kernels;
mod persist;
mod query;
mod sweep_item;

pub use between::{BetweenFound, BetweenRays};
pub use error::StockError;
pub use field::depth::{Depths, Measure};
pub use field::dexel::{Interval, SurfacePoint, TriDexel};
pub use field::engagement::Contact;
pub use field::grid::{Cells, TileId};
pub use field::raw_body::RawBody;
pub use field::regrid_bound::Regrid;
pub use field::slices::{SliceContact, SlicePlan};
pub use field::sweep::SweepReport;
pub use persist::file::StockFileError;
pub use persist::history::HistoryError;
pub use persist::patch::{Patch, PatchError, PatchPlan, patched_intervals};
pub use persist::share::{ShareLog, ShareReplay};
pub use persist::sweep_log::{BeforeSweep, SweepLog, SweepReplay};
pub use persist::take_part::TakenPart;
pub use query::ball_touch::StylusTouch;
pub use query::bands::MeshBand;
pub use query::coherence::Coherence;
pub use query::moments::Moments;
pub use query::overlap::SolidOverlap;
pub use query::parts::StockPart;
pub use query::probe::{NearestOnStock, Probe, StockWall};
pub use query::rows::{MeshRows, RayEnd, RayPlace, RaySpan, RowMaterial};
pub use query::section::Outline;
pub use query::surface::SurfaceMesh;
pub use query::tile_tree::{RaySegment, TileNode, TileTree};
pub use query::volume::Volume;
pub use sweep_item::{Action, SweepItem, SweepMotion};
