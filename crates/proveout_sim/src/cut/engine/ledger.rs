//! The material of a run: what was there, what was cut and what fell off add up to what is left.
//!
//! Sweeps report a volume of their own, which is counted by whole cells across the rays
//! ([`proveout_stock::SweepReport`]). It says which cut took more than another, not how much. How much a
//! stretch of the run took is what the stock has less after it ([`proveout_stock::Volume`]); its cuts share
//! that in proportion to what they report. So verdict, blocks and tools have one sum.

use proveout_stock::{TriDexel, Volume};

/// What became of the raw stock, mm³.
#[derive(Debug)]
pub(crate) struct Ledger {
    volume: Volume,
    /// Volume of the shape over that of its rays.
    scale: f64,
    raw: f64,
    removed: f64,
    fallen: f64,
    /// Taken by a stretch that reported nothing, or given back by one: the next stretch has it.
    open: f64,
    /// What cuts have reported so far: it grows with each of them.
    reported: f64,
    /// The same when the stock was looked through for loose parts last.
    searched_at: f64,
}

impl Ledger {
    /// Of a raw stock; `own` is the volume of its shape, where that is known.
    pub(crate) fn new(stock: &TriDexel, own: Option<f64>) -> Self {
        let volume = Volume::of(stock);
        let on_rays = volume.total();
        let scale = own.map_or(1.0, |own| own / on_rays);
        let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        Self {
            raw: scale * on_rays,
            volume,
            scale,
            removed: 0.0,
            fallen: 0.0,
            open: 0.0,
            reported: 0.0,
            searched_at: 0.0,
        }
    }

    /// Books what the cuts of a stretch took; gives the factor from what they reported to what they took.
    pub(crate) fn book_cuts(&mut self, stock: &TriDexel, reported: f64) -> f64 {
        self.reported += reported;
        self.open += self.scale * self.volume.follow(stock);
        if reported <= 0.0 || self.open <= 0.0 {
            return 0.0;
        }
        let share = self.open / reported;
        self.removed += std::mem::take(&mut self.open);
        share
    }

    /// Books what fell off since the last look.
    pub(crate) fn book_fallen(&mut self, stock: &TriDexel) {
        self.fallen += self.scale * self.volume.follow(stock);
    }

    /// Whether anything was cut since the last search for loose parts.
    pub(crate) fn is_cut_since_search(&self) -> bool {
        self.reported != self.searched_at
    }

    /// Takes note of a search for loose parts.
    pub(crate) fn note_search(&mut self) {
        self.searched_at = self.reported;
    }

    pub(crate) fn removed(&self) -> f64 {
        self.removed
    }

    pub(crate) fn fallen(&self) -> f64 {
        self.fallen
    }

    /// What is left: the rest of the raw stock, and nothing where no ray has any.
    pub(crate) fn left(&self, stock: &TriDexel) -> f64 {
        if stock.is_empty() { 0.0 } else { (self.raw - self.removed - self.fallen).max(0.0) }
    }
}
