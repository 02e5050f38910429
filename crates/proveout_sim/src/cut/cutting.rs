//! Stock and patches, as they are cut.

use proveout_stock::{Depths, Measure, Patch, SweepItem, SweepReport, TriDexel};

/// Stock and patches, as they are cut.
pub(crate) struct Cutting<'e> {
    pub(crate) stock: &'e mut TriDexel,
    pub(crate) patches: &'e mut [Patch],
    pub(crate) depths: &'e mut Depths,
}

impl Cutting<'_> {
    /// Cuts patches and stock; reports on each item.
    pub(crate) fn sweep(&mut self, items: &[SweepItem<'_>], measures: &[Measure]) -> Vec<SweepReport> {
        self.patches.iter_mut().for_each(|p| p.sweep(items));
        self.stock.sweep_measured(items, measures, self.depths)
    }
}
