//! Places where parts lie that have come off, against everything that moves later.
//!
//! A part that lies on the table is a body of its own. Where it lies is known to a millimeter: the
//! box round it is followed as a fixture. What comes into the box is reported; what does not is
//! proved clear.

use proveout_collision::{CollisionError, Fixture, Interference};
use proveout_controller::Chunk;
use proveout_geom::{Aabb, box_mesh};
use proveout_machine::Machine;

use super::wording;
use crate::{cut::tool_sweeps::CuttingState, prepare::prepared::Prepared};

/// Boxes in which parts lie, among the bodies of the machine.
pub(super) struct Lying {
    boxes: Vec<Fixture>,
    /// When the last of their parts began to fall, s.
    since: f64,
    world: Interference,
    tool: Option<Option<usize>>,
    /// Boxes that something came into.
    entered: Vec<String>,
}

impl Lying {
    /// The boxes so far and a new one, in K.
    pub(super) fn with(
        before: Option<Self>,
        machine: &Machine,
        (name, since): (&str, f64),
        within: &Aabb,
    ) -> Result<Self, CollisionError> {
        let (mut boxes, entered) = before.map_or_else(Default::default, |b| (b.boxes, b.entered));
        boxes.push(Fixture { name: name.into(), mesh: box_mesh(within), on_table: true });
        let mut world = Interference::new(machine, &boxes, 0.0)?;
        // The bodies of the machine among themselves are checked elsewhere.
        let is_box = |name: &str| boxes.iter().any(|b| b.name == name);
        let others: Vec<String> = world.part_names().map(|n| n.to_string()).filter(|n| !is_box(n)).collect();
        for (k, one) in others.iter().enumerate() {
            for other in &others[k + 1..] {
                world = world.allow(one, other);
            }
        }
        Ok(Self { boxes, since, world, tool: None, entered })
    }

    /// Number of boxes.
    pub(super) fn len(&self) -> usize {
        self.boxes.len()
    }

    /// Follows a stretch; gives what came into a box for the first time, in words.
    pub(super) fn watch(&mut self, prepared: &Prepared, chunk: &Chunk, states: &[CuttingState]) -> Vec<String> {
        let mut told = Vec::new();
        for (piece, state) in chunk.pieces.iter().zip(states).filter(|(p, _)| p.time[0] >= self.since) {
            if self.tool != Some(state.tool) {
                self.tool = Some(state.tool);
                self.world.set_tool(state.tool.and_then(|t| prepared.tools.tools.get(t)));
            }
            let [from, to] = &piece.joints;
            let begun = self.world.check_piece(from, to, piece.time, piece.deviation);
            for k in begun {
                let bodies = self.world.breaches()[k].bodies.clone();
                for (lies, comes) in [(&bodies[0], &bodies[1]), (&bodies[1], &bodies[0])] {
                    let entered = lies.to_string();
                    if self.boxes.iter().any(|b| b.name == entered) && !self.entered.contains(&entered) {
                        told.push(wording::came_near(&entered, comes, self.world.breaches()[k].time));
                        self.entered.push(entered);
                    }
                }
            }
        }
        told
    }
}
