//! Tools that are changed into the spindle and not moved before the next change or the end of the
//! program.
//!
//! They are in the machine all the same, and may be longer or wider than the tool before them. Each
//! gets a piece of motion of zero length, so that removal and the checks of bodies treat it like
//! any other.
//!
//! ```text
//!   T1 M6      G0 ...      T3 M6      M30
//!   ──┼────────pieces────────┼─────────┼──
//!   T1 is moved              T3 is not: a piece from here to here, of the block of T3 M6, at the time of M30
//! ```

use proveout_machine::{JointValues, Machine};
use proveout_tool::Tool;

use crate::output::{Chunk, Event, MoveKind, Piece};

/// A tool that nothing has moved since it came.
#[derive(Clone, Copy, Debug)]
struct IdleTool {
    tool: usize,
    block: u32,
    time: f64,
}

/// Follows the stream of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IdleTools {
    still: Option<IdleTool>,
    /// Where the last piece of motion ended.
    joints: JointValues,
}

impl IdleTools {
    /// Before the first motion.
    pub(crate) fn at(joints: JointValues) -> Self {
        Self { still: None, joints }
    }

    /// Adds the pieces of tools that do not move to a chunk; `last` says that no chunk follows.
    pub(crate) fn complete(&mut self, machine: &Machine, tools: &[Tool], chunk: &mut Chunk, last: bool) {
        let mut put: Vec<(usize, Piece)> = Vec::new();
        let mut at = 0;
        for event in &chunk.events {
            let next = match *event {
                Event::ToolChange { time, block, tool } => tool.map(|tool| IdleTool { tool, block, time }),
                Event::End { .. } | Event::Ended { .. } => None,
                _ => continue,
            };
            // Drives that settle during a change move the tool before.
            let before = |p: &&Piece| p.block < event.block() || (p.block == event.block() && p.time[0] < event.time());
            let moved = chunk.pieces[at..].iter().take_while(before).count();
            self.moved(&chunk.pieces[at..at + moved]);
            at += moved;
            put.extend(self.stands(machine, tools, event.time()).map(|piece| (at, piece)));
            self.still = next;
        }
        self.moved(&chunk.pieces[at..]);
        if let Some(still) = self.still.filter(|_| last) {
            put.extend(self.stands(machine, tools, still.time).map(|piece| (chunk.pieces.len(), piece)));
        }
        for (at, piece) in put.into_iter().rev() {
            chunk.pieces.insert(at, piece);
        }
    }

    fn moved(&mut self, pieces: &[Piece]) {
        if let Some(piece) = pieces.last() {
            self.joints = piece.joints[1];
            self.still = None;
        }
    }

    /// The piece of a tool that nothing has moved.
    fn stands(&mut self, machine: &Machine, tools: &[Tool], now: f64) -> Option<Piece> {
        let still = self.still.take()?;
        let pose = machine.actual_forward(&self.joints, tools.get(still.tool)?.gauge_length);
        Some(Piece {
            time: [now.max(still.time); 2],
            block: still.block,
            kind: MoveKind::Handling,
            joints: [self.joints; 2],
            pose: [pose; 2],
            deviation: 0.0,
            edge_deviation: 0.0,
            joint_deviation: JointValues::ZERO,
            finer: None,
        })
    }
}
