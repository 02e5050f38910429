/// How far a stock that was taken over from another grid may lie from the one it was made from, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Regrid {
    /// On faces: largest distance, in addition to the sweep bound of the earlier stock.
    pub surface_mm: f64,
    /// Within a cell of edges, of roundings as small as the cells, and of details thinner than a cell.
    pub edge_mm: f64,
}
