//! Parts that a program cuts off the stock.
//!
//! The twin looks at tool changes, program stops and the end whether the stock still hangs together. What came off stays in its
//! place in the twin; on the machine it falls, is caught or jams. Where it lies is not known, so that the collision gate is unchecked
//! from then on.

use proveout_stock::{StockPart, TriDexel};

/// Least volume of a part that is told, mm³: below it lie crumbs of a few chips.
const LEAST_VOLUME: f64 = 1.0;
/// The same in edges of a cell: what is thinner may hang together between the rays.
const LEAST_CELLS: f64 = 4.0;

/// Parts seen so far, the largest apart.
#[derive(Debug)]
pub(crate) struct LooseParts {
    least_volume: f64,
    known: Vec<StockPart>,
    /// Parts that came off, and their volume when they were seen first, mm³.
    pub(crate) count: usize,
    pub(crate) volume: f64,
}

impl LooseParts {
    /// The raw stock may consist of several parts: those are held.
    pub(crate) fn new(raw: &TriDexel) -> Self {
        let cell = LEAST_CELLS * raw.cell_mm();
        let mut loose =
            Self { least_volume: (cell * cell * cell).max(LEAST_VOLUME), known: Vec::new(), count: 0, volume: 0.0 };
        loose.known = loose.apart(raw);
        loose
    }

    fn apart(&self, stock: &TriDexel) -> Vec<StockPart> {
        stock.parts().into_iter().skip(1).filter(|p| p.volume_mm3 >= self.least_volume).collect()
    }

    /// Parts that have come off since the last look.
    pub(crate) fn look(&mut self, stock: &TriDexel) -> Vec<StockPart> {
        let before = std::mem::take(&mut self.known);
        self.known = self.apart(stock);
        // A part only shrinks: it lies within the box in which it was seen.
        let within = |new: &StockPart, old: &StockPart| {
            (0..3)
                .all(|c| new.bounds.min[c] >= old.bounds.min[c] - 1e-9 && new.bounds.max[c] <= old.bounds.max[c] + 1e-9)
        };
        let fresh: Vec<StockPart> =
            self.known.iter().filter(|new| !before.iter().any(|old| within(new, old))).cloned().collect();
        self.count += fresh.len();
        self.volume += fresh.iter().map(|p| p.volume_mm3).sum::<f64>();
        fresh
    }

    /// For the gates: what is not known; none while the stock hangs together.
    pub(crate) fn left_out(&self) -> Option<String> {
        let (parts, lie) = if self.count == 1 { ("part", "lies") } else { ("parts", "lie") };
        (self.count > 0).then(|| {
            format!(
                "where {} {parts} of {:.1} mm3 {lie} that came off the stock (process-loose-part)",
                self.count, self.volume
            )
        })
    }
}
