//! Tri-dexel stock, swept volume, material removal, surface extraction.

mod dexel;
mod error;
mod grid;
mod meridian;
mod mesh_rays;
mod motion;
mod qef;
mod ray;
mod ray_ball;
mod ray_translate;
mod ray_turn;
mod sheets;
mod span;
mod surface;
mod sweep;
mod tile;
mod vec3;

pub use dexel::{Interval, SurfacePoint, TriDexel};
pub use error::StockError;
pub use surface::{SurfaceMesh, TileId};
pub use sweep::{Action, SweepItem, SweepMotion, SweepReport};
