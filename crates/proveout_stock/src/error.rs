use proveout_geom::{MeshError, Point};
use thiserror::Error;

/// Why a stock cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StockError {
    /// The cell size is not a length.
    #[error("the cell size must be a positive number, but is {cell_mm} mm")]
    Cell {
        /// The value, mm.
        cell_mm: f64,
    },
    /// The body has no extent.
    #[error("the stock is empty or not finite: {what}")]
    Degenerate {
        /// Which measure is wrong, with its value.
        what: String,
    },
    /// The rays would take more memory than allowed; nothing was allocated.
    #[error(
        "a stock with {cell_mm} mm cells needs {needed_mib:.0} MiB, more than the {limit_mib:.0} MiB allowed: \
         use cells of {fitting_cell_mm:.4} mm or more, or allow more memory"
    )]
    Memory {
        /// The cell size asked for, mm.
        cell_mm: f64,
        /// Estimate for it, MiB.
        needed_mib: f64,
        /// Allowed, MiB.
        limit_mib: f64,
        /// The finest cell size that fits, mm.
        fitting_cell_mm: f64,
    },
    /// The triangles do not bound a solid.
    #[error("the stock mesh is not a solid: {0}")]
    Mesh(#[from] MeshError),
    /// A ray enters the body twice without leaving it, or leaves it before it enters.
    #[error(
        "the stock mesh crosses itself near ({:.4}, {:.4}, {:.4}) on a ray along {axis}",
        point.x, point.y, point.z
    )]
    SelfCrossing {
        /// Where the order of entry and exit breaks, mm.
        point: Point,
        /// Direction of the ray: x, y or z.
        axis: char,
    },
}
