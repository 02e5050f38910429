//! What the checks of bodies report to the gates.

/// Remarks for the gates: pairs of bodies with a rule of their own in the machine file, and bodies
/// that cannot be checked in full.
#[derive(Clone, Debug, Default)]
pub(crate) struct Told {
    /// Pairs with a near-miss distance of their own, in words.
    pub(crate) own_near_miss: Vec<String>,
    /// What is not checked of meshes and pairs, in words.
    pub(crate) left_out: Vec<String>,
    /// Meshes that are checked as they are, in words.
    pub(crate) remarks: Vec<String>,
}

/// What is known of the stock and the bodies that nothing sweeps through it.
#[derive(Clone, Debug, Default)]
pub(crate) struct StockNear {
    /// Number of bodies that are followed against the stock.
    pub(crate) followed: usize,
    /// Number of those that kept away.
    pub(crate) clear: usize,
    /// So much nearer than the nearest ray may material be, mm.
    pub(crate) unseen_mm: f64,
    /// Bodies that lie against the table's face, and the height of the layer of material on it that counts
    /// for nothing against them, mm.
    pub(crate) flush: Vec<String>,
    pub(crate) layer_mm: f64,
    /// Bodies that move as one with the stock.
    pub(crate) fixed: Vec<String>,
    /// Stock and fixtures that reach below the face of the table, and how far, mm.
    pub(crate) behind_table: Vec<(String, f64)>,
}
