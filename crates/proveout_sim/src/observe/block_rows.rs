//! What a stretch of the run gives to observers: signals, blocks, parts that came off, proofs of clearance.

use std::sync::Arc;

use proveout_collision::ProvedSpan;
use proveout_controller::MoveKind;
use proveout_geom::{Pose, TriMesh};

use crate::checks::engagement::Engagement;

/// Signals for the motion of one sample; same order as [`Batch::samples`](crate::observer::Batch::samples).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleSignals {
    /// Material removal rate, mm³/s, of the piece that holds the sample.
    pub removal_rate: f64,
    /// Proved clearance of the piece that holds the sample, mm; none when nothing was checked.
    pub clearance: Option<f64>,
    /// Index of the tool in the library.
    pub tool: Option<u32>,
}

/// What proves the least clearance of every pair of bodies: spans of time with a distance that is proved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClearanceProof {
    /// Names of the two bodies of each pair.
    pub bodies: Vec<[Arc<str>; 2]>,
    /// By pair (an index of `bodies`), in order of time.
    pub spans: Vec<ProvedSpan>,
}

/// One executed block, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockRow {
    /// Index of the block, from 0.
    pub block: u32,
    /// File as given.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Kind of motion.
    pub kind: MoveKind,
    /// Index of the tool in the library.
    pub tool: Option<u32>,
    /// Start, s.
    pub start_time: f64,
    /// End, s.
    pub end_time: f64,
    /// Path of the tip in the workpiece, mm.
    pub length: f64,
    /// Programmed feed, mm/s; none for rapids.
    pub feed: Option<f64>,
    /// Removed volume, mm³.
    pub volume_mm3: f64,
    /// Largest length of cutter in material on a ray, mm: a measure of engagement.
    pub engagement_mm: f64,
    /// Engagement of the cutter, where the scene asks for it and the block has cut.
    pub engagement: Option<Engagement>,
}

/// The way of a part that came off the stock.
#[derive(Clone, Debug, PartialEq)]
pub struct LooseMotion {
    /// Name in findings.
    pub name: String,
    /// Its surface where it came off, table frame, mm.
    pub mesh: TriMesh,
    /// Time, s, and motion since then in the table frame: applied to the mesh it gives the part at that time.
    /// Rising times.
    pub track: Vec<(f64, Pose)>,
    /// It is no longer stock; otherwise it rests, or it is not known where it goes and this is one of its
    /// ways.
    pub gone: bool,
}
