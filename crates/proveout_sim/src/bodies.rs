//! Bodies against bodies along the pieces of motion.

use proveout_collision::{Breach, CollisionError, Fixture, Interference, Severity};
use proveout_controller::Piece;
use proveout_geom::Point;

use crate::{prepare::Prepared, process::CuttingState, verdict::Clearance};

/// How a hit is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HitKind {
    /// Touching or overlapping, or not excluded.
    Collision,
    /// Nearer than wanted; the distance, mm.
    NearMiss(f64),
}

/// Two bodies that came too near within a piece.
#[derive(Clone, Debug)]
pub(crate) struct Hit {
    pub(crate) kind: HitKind,
    pub(crate) bodies: [String; 2],
    /// When, s.
    pub(crate) time: f64,
    pub(crate) penetration: Option<f64>,
    pub(crate) inside: bool,
    pub(crate) point_in_table: Point,
    /// Index of the breach, whose figures grow while it lasts.
    pub(crate) breach: usize,
}

/// What the check of one piece gave.
#[derive(Clone, Debug, Default)]
pub(crate) struct Checked {
    pub(crate) hits: Vec<Hit>,
    /// Proved clearance of all pairs at the end of the piece, mm.
    pub(crate) clearance: Option<f64>,
}

/// The check of all pairs, in order of time.
pub(crate) struct BodyCheck<'a> {
    prepared: &'a Prepared,
    world: Interference,
    tool: Option<usize>,
}

impl<'a> BodyCheck<'a> {
    pub(crate) fn new(prepared: &'a Prepared) -> Result<Self, CollisionError> {
        let fixtures: Vec<Fixture> = prepared
            .fixtures
            .iter()
            .map(|(name, mesh)| Fixture { name: name.clone(), mesh: mesh.clone(), on_table: true })
            .collect();
        let world = Interference::new(&prepared.machine, &fixtures, prepared.scene.file.tolerances.near_miss_mm)?;
        Ok(Self { prepared, world, tool: None })
    }

    /// Checks pieces in order; `states` tells the tool of each.
    pub(crate) fn check(&mut self, pieces: &[Piece], states: &[CuttingState]) -> Vec<Checked> {
        pieces.iter().zip(states).map(|(piece, state)| self.check_one(piece, state)).collect()
    }

    fn check_one(&mut self, piece: &Piece, state: &CuttingState) -> Checked {
        if state.tool != self.tool {
            self.tool = state.tool;
            self.world.set_tool(state.tool.and_then(|t| self.prepared.tools.tools.get(t)));
        }
        let [from, to] = &piece.joints;
        let begun = self.world.check_piece(from, to, piece.time, piece.deviation);
        let hits = begun.map(|i| hit(i, &self.world.breaches()[i])).collect();
        let proved = self.world.proved_now();
        Checked { hits, clearance: proved.is_finite().then_some(proved) }
    }

    /// The figures of a breach as they are by now: deepest penetration and least distance, mm.
    pub(crate) fn worst(&self, breach: usize) -> Option<(Option<f64>, f64)> {
        self.world.breaches().get(breach).map(|b| (b.penetration_estimate, b.least_distance))
    }

    /// Smallest proved clearance with the pair that came nearest.
    pub(crate) fn clearance(&self) -> Clearance {
        let all = self.world.clearance();
        let nearest = all.measured.as_ref();
        Clearance {
            min_mm: all.lower_bound.is_finite().then_some(all.lower_bound),
            pair: nearest.map(|n| n.bodies.clone().map(|b| b.to_string())),
            time_s: nearest.map(|n| n.time),
            checks: self.world.pieces(),
        }
    }

    /// Number of pairs that were checked.
    pub(crate) fn checked_pairs(&self) -> usize {
        self.world.pairs().iter().filter(|p| p.unchecked.is_none()).count()
    }

    /// Bodies that the machine description keeps out of the checks.
    pub(crate) fn excluded(&self) -> Vec<String> {
        let machine = &self.prepared.machine;
        machine.bodies.iter().filter(|b| !b.check).map(|b| b.name.clone()).collect()
    }
}

fn hit(index: usize, breach: &Breach) -> Hit {
    Hit {
        kind: match breach.severity {
            Severity::NearMiss => HitKind::NearMiss(breach.distance),
            Severity::Collision | Severity::QueryFailed => HitKind::Collision,
        },
        bodies: breach.bodies.clone().map(|b| b.to_string()),
        time: breach.time,
        penetration: breach.penetration_estimate,
        inside: breach.inside,
        point_in_table: breach.point_in_table,
        breach: index,
    }
}
