//! The path of a run between two stops: exact blocks, corner blends, and cells with limits.
//!
//! All lives on one parameter s. Block i runs over `s0..s0 + length`; a blend of half width d around a border
//! replaces `s - d ..= s + d` of both blocks, so that rounded and exact path have the same parameter:
//!
//! ```text
//!      block a            |            block b
//!   ---------------x......|......x--------------      x: C2 joints of exact parts and blend
//!                 s - d   s    s + d                  the border s lies in the middle of the blend
//! ```
//!
//! *Lines in feed.* All corners of a run of lines are rounded together (`fit.rs`, `curve.rs`): the rounded
//! path is the exact one plus a sum over its kinks, with half widths that may reach over many short blocks;
//! it passes through the points of a curve (`points.rs`).
//!
//! *Reversals* are exact stops (`reversal.rs`). The feed, lengths and ratios are about the rounded path
//! (`way.rs`).
//!
//! *Other corners* get a polynomial of fifth degree in task coordinates that takes value, first and
//! second derivative from both exact paths at its ends. Between two lines with slopes u and w it
//! has x' with Bezier points u, u, (u + w)/2, w, w: |x'| <= max(|u|, |w|), so the tip is never
//! faster than the parameter. It leaves the corner by 3/16 d |w - u|. Its largest second derivative
//! is 3/4 |w - u| / d (middle) and its largest third derivative 3/2 |w - u| / d^2 (ends). It is no
//! wider than the joints need at the programmed feed, than the tolerances of tip and orientation
//! allow, or than half of either block. Where a neighbor is not a line the
//! deviation is measured at points, and d shrinks until it fits.
//!
//! *A corner between feed and rapid* is not rounded: the control stops in it, so that the feed
//! reaches the end of its path and the rapid begins on its own. `LinuxCNC` does not blend traverse
//! and feed moves, and a control with in-position check between cutting and positioning, such as
//! Fanuc's, also stops there; a control that rounds the corner leaves material that the rapid would
//! take. A rapid that continues straight into the feed, or the other way round, passes its border
//! at feed.

mod cells;
mod corner_rounding;
mod curve;
mod fit;
mod points;
mod reversal;
mod septic;
mod way;

use proveout_machine::{JointValues, Machine};

pub(crate) use self::way::WayMeasure;
use self::{
    cells::{blend_cells, exact_cells},
    corner_rounding::{CornerRounding, corner, size},
    curve::LineFit,
    septic::Septic,
};
use crate::{
    jet::JointJet,
    limits::{CellLimits, JointLimits},
    mapping::ActiveKinematics,
    motion::ProgrammedMotion,
    output::MoveKind,
    shape::{BlockShape, Quintic},
};

/// Blocks that pass in less than this time (s) are the approximation of a curve where the tolerance allows to
/// see them so: controls look at them together. Chosen: kinks that come more often than ten times a second
/// shake the machine; longer blocks keep their corners as narrow as the joints allow.
const SHORT: f64 = 0.1;
/// Part of the tolerance by which a short curved block may leave its chord to be taken for a line.
const OFF_CHORD: f64 = 0.5;
/// Rounding of sums of the way, part of it and of one at least.
const ROUNDING: f64 = 1e-12;

/// How far corners may be rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tolerance {
    /// Tip (with tool center point control) or linear joints (without), mm.
    pub(crate) tip: f64,
    /// Rotary joints, radian.
    pub(crate) angle: f64,
}

impl Tolerance {
    fn min(self, other: Self) -> Self {
        Self { tip: self.tip.min(other.tip), angle: self.angle.min(other.angle) }
    }
}

/// One block of a run.
#[derive(Clone, Debug)]
pub(crate) struct PathBlock {
    /// Index of the block record.
    pub(crate) index: u32,
    pub(crate) shape: BlockShape,
    pub(crate) length: f64,
    /// Begin on the parameter of the run.
    pub(crate) s0: f64,
    pub(crate) kind: MoveKind,
    /// Speed along the path that the program asks for; infinite for rapid motion.
    pub(crate) feed: f64,
    /// Feed for the record, mm/s; zero for rapid motion.
    pub(crate) feed_programmed: f64,
    /// The path follows the angle of the spindle.
    pub(crate) coupled: bool,
    /// Rounding at its end; none: exact stop.
    pub(crate) corner: Option<Tolerance>,
    /// Rounding at its end that the program allows, whatever this control does there; none: it must be
    /// reached.
    pub(crate) loose: Option<Tolerance>,
    /// The program makes the machine stop at its end.
    pub(crate) stands: bool,
    /// The line that replaces a short curved block, see [`RunPath::push`].
    pub(crate) chord: Option<BlockShape>,
    /// False when the parameter is in degrees since the tip does not move.
    pub(crate) tip_moves: bool,
    /// What the program says of the way, and the share of it that this block runs; none where it says the end
    /// alone.
    pub(crate) told: Option<(std::sync::Arc<ProgrammedMotion>, [f64; 2])>,
    pub(crate) file: std::sync::Arc<str>,
    pub(crate) line: u32,
}

/// Whether a path that has come to s has come to the end of a block, but for rounding of their sums.
pub(crate) fn reaches(s: f64, end: f64) -> bool {
    end - s <= ROUNDING * end.abs().max(1.0)
}

impl PathBlock {
    pub(crate) fn end(&self) -> f64 {
        self.s0 + self.length
    }

    /// How far joints are from the programmed way at s: tip or linear joints, mm, and the tool axis, radian.
    pub(crate) fn off(&self, machine: &Machine, s: f64, q: &JointValues) -> Option<(f64, f64)> {
        let (way, [t0, t1]) = self.told.as_ref()?;
        let part = if self.length > 0.0 { ((s - self.s0) / self.length).clamp(0.0, 1.0) } else { 0.0 };
        Some(way.off(machine, t0 + (t1 - t0) * part, q))
    }

    /// What the rounded path follows: the exact path, or the line that replaces it.
    fn course(&self) -> &BlockShape {
        self.chord.as_ref().unwrap_or(&self.shape)
    }

    /// Replaces a short block that hardly leaves its chord (a great circle of the tool axis, mostly) by it,
    /// so that it is fitted with its neighbors; the tolerance gives what this takes.
    ///
    /// Returns how far it leaves the tip's exact path, mm.
    fn straighten(&mut self, machine: &Machine) -> f64 {
        let Some(tolerance) = self.corner.filter(|_| self.kind == MoveKind::Feed && self.length <= SHORT * self.feed)
        else {
            return 0.0;
        };
        let Some((line, off)) = self.shape.chord(self.length) else { return 0.0 };
        let (tip, angle) = size(machine, &off);
        if tip > OFF_CHORD * tolerance.tip || angle > OFF_CHORD * tolerance.angle {
            return 0.0;
        }
        self.chord = Some(line);
        self.corner = Some(Tolerance { tip: tolerance.tip - tip, angle: tolerance.angle - angle });
        tip
    }

    fn is_rapid(&self) -> bool {
        self.kind != MoveKind::Feed
    }
}

#[derive(Clone, Debug)]
pub(crate) enum SpanShape {
    /// The exact path of the block.
    Exact,
    /// A blend, or a stretch of a fitted run of lines.
    Blend(Box<Quintic>),
}

/// A stretch of the rounded path.
#[derive(Clone, Debug)]
pub(crate) struct PathSpan {
    pub(crate) s0: f64,
    pub(crate) s1: f64,
    /// Running number of the block in which it begins.
    pub(crate) block: u64,
    pub(crate) shape: SpanShape,
    /// What counts as way on it.
    pub(crate) way: WayMeasure,
}

/// A cell with its limits.
#[derive(Clone, Debug)]
pub(crate) struct PathCell {
    pub(crate) s1: f64,
    pub(crate) limits: CellLimits,
    /// Running number of the block in which it begins.
    pub(crate) block: u64,
    /// False in blends of a single corner.
    pub(crate) exact: bool,
    /// The joints, where polynomials approximate the kinematics.
    pub(crate) joints: Option<Box<Septic>>,
}

/// Position of a forward walk along a path; makes the walk linear in cost.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PathCursor {
    pub(crate) span: usize,
    pub(crate) cell: usize,
}

/// The known part of a run.
#[derive(Default)]
pub(crate) struct RunPath {
    pub(crate) blocks: Vec<PathBlock>,
    /// Running number of the first block in `blocks`.
    pub(crate) first_block: u64,
    pub(crate) spans: Vec<PathSpan>,
    pub(crate) cells: Vec<PathCell>,
    /// Begin of the first cell.
    pub(crate) s_begin: f64,
    /// End of the finished spans.
    s_done: f64,
    /// The fit of the run of lines under way.
    curve: LineFit,
    /// Largest rounding of the tip or linear joints, mm.
    pub(crate) max_rounding: f64,
    /// Largest way between a short curved block and its chord, mm.
    off_chord: f64,
}

/// What the geometry of a path needs to know about machine and control.
#[derive(Clone, Copy)]
pub(crate) struct PathContext<'a> {
    pub(crate) kinematics: ActiveKinematics<'a>,
    pub(crate) limits: &'a JointLimits,
}

impl RunPath {
    /// An empty path whose first block gets this running number.
    pub(crate) fn starting_with(first_block: u64) -> Self {
        Self { first_block, ..Self::default() }
    }

    /// A path of one block that has its own law over the path parameter.
    pub(crate) fn single(first_block: u64, block: PathBlock) -> Self {
        let s1 = block.length;
        let span = PathSpan { s0: 0.0, s1, block: first_block, shape: SpanShape::Exact, way: WayMeasure::Parameter };
        Self { first_block, s_done: s1, spans: vec![span], blocks: vec![block], ..Self::default() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Begin of the next block.
    pub(crate) fn end(&self) -> f64 {
        self.blocks.last().map_or(self.s_done, PathBlock::end)
    }

    pub(crate) fn block(&self, number: u64) -> &PathBlock {
        let i = (number - self.first_block) as usize;
        &self.blocks[i.min(self.blocks.len() - 1)]
    }

    /// Appends a block with a rounded corner before it. False, and nothing is changed, where the corner has
    /// no room for a blend: the control must stop there first.
    pub(crate) fn push(&mut self, frame: &PathContext<'_>, mut block: PathBlock) -> bool {
        block.s0 = self.end();
        let off = block.straighten(frame.kinematics.machine);
        self.off_chord = self.off_chord.max(off);
        if let Some(before) = self.blocks.last() {
            let Some(tolerance) = before.corner else { return false };
            let number = self.first_block + self.blocks.len() as u64 - 1;
            let corner = corner(frame, (number, before), &block, tolerance);
            match corner {
                CornerRounding::Stop => return false,
                CornerRounding::Kink(kink) => {
                    self.blocks.push(block);
                    self.round(frame, *kink);
                    return true;
                }
                CornerRounding::Smooth => {
                    self.end_lines(frame, block.s0);
                    self.curve = LineFit::from(block.s0);
                }
                CornerRounding::Blend { half_width, rounding, quintic } => {
                    self.end_lines(frame, block.s0 - half_width);
                    self.curve = LineFit::from(block.s0 + half_width);
                    self.max_rounding = self.max_rounding.max(rounding + self.off_chord);
                    self.push_blend(frame, number, &block, quintic);
                }
            }
        }
        self.blocks.push(block);
        true
    }

    /// Finishes the last block: the path ends with a stop.
    pub(crate) fn finish(&mut self, frame: &PathContext<'_>) {
        if !self.blocks.is_empty() {
            self.end_lines(frame, self.end());
        }
    }

    fn finish_exact(&mut self, frame: &PathContext<'_>, number: u64, s1: f64) {
        let s0 = self.s_done;
        if reaches(s0, s1) {
            // What is left is rounding of sums: the path ends where its last block does.
            if let (Some(cell), Some(span)) = (self.cells.last_mut(), self.spans.last_mut()) {
                (cell.s1, span.s1) = (cell.s1.max(s1), span.s1.max(s1));
                self.s_done = s0.max(s1);
            }
            return;
        }
        let block = self.block(number);
        let cells = exact_cells(frame, block, s0, s1);
        for (end, limits, joints) in cells {
            self.cells.push(PathCell { s1: end, limits, block: number, exact: true, joints });
        }
        self.spans.push(PathSpan { s0, s1, block: number, shape: SpanShape::Exact, way: WayMeasure::Parameter });
        self.s_done = s1;
    }

    fn push_blend(&mut self, frame: &PathContext<'_>, number: u64, next: &PathBlock, quintic: Box<Quintic>) {
        let before = self.block(number);
        let rapid = before.is_rapid() && next.is_rapid();
        let feed = before.feed.min(next.feed);
        let way = WayMeasure::of([before.tip_moves, next.tip_moves]);
        let s0 = self.s_done;
        let s1 = quintic.u1;
        for (end, limits, joints) in blend_cells(frame, (rapid, feed, way), s0, &quintic) {
            self.cells.push(PathCell { s1: end, limits, block: number, exact: false, joints });
        }
        self.spans.push(PathSpan { s0, s1, block: number, shape: SpanShape::Blend(quintic), way });
        self.s_done = s1;
    }

    fn span_at(&self, s: f64, hint: &mut usize) -> usize {
        let mut i = (*hint).min(self.spans.len().saturating_sub(1));
        while i > 0 && self.spans[i].s0 > s {
            i -= 1;
        }
        while i + 1 < self.spans.len() && self.spans[i].s1 < s {
            i += 1;
        }
        *hint = i;
        i
    }

    /// Way along the path that is run between two places; the cursor `hint` is that of [`Self::rounded`].
    pub(crate) fn way(&self, machine: &Machine, [from, to]: [f64; 2], hint: &mut usize) -> f64 {
        let mut i = self.span_at(from, hint);
        let (mut at, mut sum) = (from, 0.0);
        while at < to {
            let Some(span) = self.spans.get(i) else { return sum + to - at };
            let end = if i + 1 == self.spans.len() { to } else { span.s1.min(to) };
            if end > at {
                sum += match &span.shape {
                    SpanShape::Exact => self.block(span.block).shape.way([at, end]),
                    SpanShape::Blend(q) => span.way.length(machine, q, [at, end]),
                };
                at = end;
            }
            *hint = i;
            i += 1;
        }
        sum
    }

    /// Whether s lies in the corner between a motion in feed and another kind; the cursor `hint` is that of
    /// [`Self::rounded`].
    pub(crate) fn changes_kind(&self, s: f64, hint: &mut usize) -> bool {
        let span = &self.spans[self.span_at(s, hint)];
        // The block before the corner may be done and gone while the corner is still run.
        let kind = |number: u64| {
            let i = usize::try_from(number.checked_sub(self.first_block)?).ok()?;
            self.blocks.get(i).map(|block| block.kind)
        };
        matches!(span.shape, SpanShape::Blend(_))
            && kind(span.block).zip(kind(span.block + 1)).is_some_and(|(before, after)| before != after)
    }

    /// Task coordinates of the rounded path at s; the cursor `hint` (a span) makes a forward walk linear.
    pub(crate) fn rounded(&self, s: f64, hint: &mut usize) -> JointJet {
        let i = self.span_at(s, hint);
        let span = &self.spans[i];
        match &span.shape {
            SpanShape::Exact => {
                let block = self.block(span.block);
                block.course().jet((s - block.s0).clamp(0.0, block.length))
            }
            SpanShape::Blend(q) => q.jet(s.clamp(q.u0, q.u1)),
        }
    }

    /// The polynomials that approximate the joints at s; at a border, those before it.
    fn joints_of_cell(&self, s: f64, hint: &mut usize) -> Option<&Septic> {
        let last = self.cells.len().checked_sub(1)?;
        let mut i = (*hint).min(last);
        while i > 0 && self.cells[i - 1].s1 >= s {
            i -= 1;
        }
        while i < last && self.cells[i].s1 < s {
            i += 1;
        }
        *hint = i;
        self.cells[i].joints.as_deref().filter(|_| s >= self.s_begin)
    }

    /// Joints of the rounded path at s.
    pub(crate) fn position(&self, kinematics: &ActiveKinematics<'_>, s: f64, walk: &mut PathCursor) -> JointValues {
        match self.joints_of_cell(s, &mut walk.cell) {
            Some(joints) => joints.at(s),
            None => kinematics.position(&self.rounded(s, &mut walk.span).0[0]),
        }
    }

    /// Position in `blocks` of the block at s, on the exact path; at a border, the earlier one.
    pub(crate) fn block_at(&self, s: f64, hint: &mut usize) -> usize {
        let mut i = (*hint).min(self.blocks.len().saturating_sub(1));
        while i > 0 && self.blocks[i].s0 >= s {
            i -= 1;
        }
        while i + 1 < self.blocks.len() && self.blocks[i].end() < s {
            i += 1;
        }
        *hint = i;
        i
    }

    /// Drops all that lies before s (a border of cells), keeping the blocks and spans that reach beyond it.
    pub(crate) fn drop_before(&mut self, s: f64, cells: usize) {
        self.cells.drain(..cells);
        let spans = self.spans.partition_point(|p| p.s1 <= s);
        self.spans.drain(..spans);
        let blocks = self.blocks.partition_point(|b| reaches(s, b.end())).min(self.blocks.len().saturating_sub(1));
        self.blocks.drain(..blocks);
        self.first_block += blocks as u64;
        self.s_begin = s;
    }
}
