//! The stock as it stood after any move, without another run.
//!
//! A cut only takes away, and on a ray it changes a run of neighboring ends: the top goes from one height to
//! another, a hole puts two new ends in, an island takes two away. The log of a tile keeps, in the order of
//! the items, what stood there before:
//!
//! ```text
//!   ends of a ray     0.0   8.0              0.0   3.0   5.0   8.0            0.0   3.0
//!                          item 7: a hole  ------>         item 9: the rest ------>
//!   log                at 1, take 2, put nothing            at 2, take 2, put 5.0 and 8.0 back
//! ```
//!
//! Undoing the log from its end until the first change of an item that is not later than the one asked for
//! gives the ends of that moment bit for bit, with what made them. A change takes 12 bytes and 16 for each
//! end to put back: 28 bytes where a surface is lowered, 12 where a hole is made.

use rayon::prelude::*;
use thiserror::Error;

use crate::{
    field::dexel::TriDexel,
    field::grid::TILE_RAYS,
    field::last_emptied::LastEmptied,
    field::span::{MaterialSpan, SpanEnd},
    field::tile::Tile,
    field::undo::{History, Undo, is_later},
};

/// Why the stock of an earlier moment is not known.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum HistoryError {
    /// The history was not requested before the first cut.
    #[error("the stock keeps no history: ask for it before the first cut")]
    Missing,
    /// An item had a lower id than one before it.
    #[error("the moves did not come in the order of their ids: move {id} came after move {before}")]
    Order {
        /// The later one.
        id: u32,
        /// The one before it.
        before: u32,
    },
    /// A ray had more than 65,535 ends.
    #[error("a ray had more than 65535 ends")]
    Ends,
    /// No time was noted.
    #[error("the history has no move that ended by {time_s} s")]
    Time {
        /// Asked for, s.
        time_s: f64,
    },
}

impl TriDexel {
    /// Remembers from now on what each removal changes, so that [`Self::after`] can go back. The items must
    /// come with rising ids. Costs 28 bytes where a ray gets a new end (12 where it gets two), see
    /// [`Self::history_bytes`].
    pub fn keep_history(&mut self) {
        if self.history.is_none() {
            self.history = Some(History { tiles: vec![Undo::default(); self.tiles.len()], ended: Vec::new() });
        }
    }

    /// Forgets the history.
    pub fn drop_history(&mut self) {
        self.history = None;
    }

    /// True while the history is kept.
    pub fn has_history(&self) -> bool {
        self.history.is_some()
    }

    /// Memory that the history takes, bytes.
    pub fn history_bytes(&self) -> u64 {
        self.history.as_ref().map_or(0, |h| h.tiles.iter().map(|t| t.heap_bytes() + size_of::<Undo>() as u64).sum())
    }

    /// Changes of a ray that the history has: each is a removed interval, or several neighbors at once.
    pub fn history_changes(&self) -> u64 {
        self.history.as_ref().map_or(0, |h| h.tiles.iter().map(|t| t.changes.len() as u64).sum())
    }

    /// Notes in the history when the item `id` ended, s, for [`Self::at_time`]; ids and times must rise.
    pub fn note_end(&mut self, id: u32, time_s: f64) {
        if let Some(h) = &mut self.history
            && h.ended.last().is_none_or(|&(i, t)| i < id && t <= time_s)
        {
            h.ended.push((id, time_s));
        }
    }

    /// The stock as it stood after the item `id` and before all later ones, bit for bit, without a history of
    /// its own. [`Self::sweep_bound_mm`] stays that of the whole run.
    ///
    /// ```
    /// use proveout_geom::{Aabb, Point, ToolPose, Vector};
    /// use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
    /// use proveout_tool::Cutter;
    ///
    /// let block = Aabb { min: Point::new(0.0, 0.0, -10.0), max: Point::new(40.0, 20.0, 0.0) };
    /// let mut stock = TriDexel::from_box(&block, 0.5, 1 << 30)?;
    /// stock.keep_history();
    /// let tool = Cutter::flat(8.0)?.bodies(20.0)?.remove(0);
    /// let at = |x: f64, z: f64| ToolPose { tip: Point::new(x, 10.0, z), axis: Vector::z() };
    /// let slot = |z: f64| SweepMotion { from: at(-10.0, z), to: at(50.0, z) };
    /// let cut = |id, z| SweepItem { id, body: &tool, action: Action::Remove, motion: slot(z) };
    /// stock.sweep(&[cut(1, -2.0)]);
    /// let volume = stock.volume(); // mm3
    /// stock.sweep(&[cut(2, -4.0)]);
    /// assert_eq!(stock.after(1)?.volume(), volume);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`HistoryError`] when nothing was remembered or the items did not come with rising ids.
    pub fn after(&self, id: u32) -> Result<Self, HistoryError> {
        self.back_to(Some(id))
    }

    fn back_to(&self, id: Option<u32>) -> Result<Self, HistoryError> {
        let history = self.history.as_ref().ok_or(HistoryError::Missing)?;
        for tile in &history.tiles {
            if tile.broken {
                return Err(HistoryError::Ends);
            }
            if let Some(w) = tile.changes.windows(2).find(|w| w[1].id < w[0].id) {
                return Err(HistoryError::Order { id: w[1].id, before: w[0].id });
            }
        }
        let tiles = self.tiles.par_iter().zip(&history.tiles).map(|(tile, undo)| {
            if undo.changes.last().is_none_or(|c| !is_later(c, id)) {
                return tile.clone();
            }
            let mut rays: Vec<Vec<SpanEnd>> =
                (0..TILE_RAYS).map(|r| tile.ray(r).iter().flat_map(MaterialSpan::ends).collect()).collect();
            undo.back_to(id, &mut rays);
            Tile::from_rays(|r, spans| {
                spans.extend(rays[r].chunks_exact(2).map(|e| MaterialSpan::from_ends(e[0], e[1])));
            })
        });
        Ok(self.with_tiles(tiles.collect()))
    }

    /// The stock as it was when the history began.
    ///
    /// # Errors
    /// As [`Self::after`].
    pub fn before_all(&self) -> Result<Self, HistoryError> {
        self.back_to(None)
    }

    /// The stock after the last item that had ended at `time_s`, and that item; an item that was then under
    /// way counts as not begun. Times are those of [`Self::note_end`].
    ///
    /// # Errors
    /// [`HistoryError`], also when no item had ended.
    pub fn at_time(&self, time_s: f64) -> Result<(Self, u32), HistoryError> {
        let history = self.history.as_ref().ok_or(HistoryError::Missing)?;
        let past = history.ended.partition_point(|&(_, t)| t <= time_s);
        let Some(&(id, _)) = past.checked_sub(1).and_then(|k| history.ended.get(k)) else {
            return Err(HistoryError::Time { time_s });
        };
        Ok((self.after(id)?, id))
    }

    /// Other material on the same rays.
    pub(crate) fn with_tiles(&self, tiles: Vec<Tile>) -> Self {
        Self {
            grid: self.grid.clone(),
            tiles,
            initial_volume: self.initial_volume,
            sweep_bound: self.sweep_bound,
            regrid: self.regrid,
            changed: vec![true; self.changed.len()],
            passes: 0,
            cut_in: vec![0; self.cut_in.len()],
            history: None,
            lost: vec![LastEmptied::default(); self.tiles.len()],
            watch_engagement: self.watch_engagement,
            slice_plan: None,
            slices: Vec::new(),
            empty_rows: Vec::new(),
        }
    }
}
