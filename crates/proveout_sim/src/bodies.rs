//! Bodies against bodies along the pieces of motion.

use proveout_collision::{Breach, CollisionError, Fixture, Interference, Severity, Unchecked};
use proveout_controller::Piece;
use proveout_geom::{Point, TriMesh, box_mesh};
use proveout_machine::Machine;
use proveout_stock::TriDexel;

use crate::{prepare::Prepared, process::CuttingState, stock_bodies::StockBodies, verdict::Clearance};

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

/// What is known of the stock and the bodies that nothing sweeps through it.
#[derive(Clone, Debug, Default)]
pub(crate) struct StockNear {
    /// Number of bodies that are followed against the stock.
    pub(crate) followed: usize,
    /// Number of those that kept away.
    pub(crate) clear: usize,
    /// So much nearer than the nearest ray may material be, mm.
    pub(crate) unseen_mm: f64,
    /// Bodies that lie against the table's face, and the height of the layer of material on it that counts for nothing against them, mm.
    pub(crate) flush: Vec<String>,
    pub(crate) layer_mm: f64,
    /// Bodies that move as one with the stock.
    pub(crate) fixed: Vec<String>,
    /// The stock or a fixture that reaches behind the face of the table, and how far, mm.
    pub(crate) behind_table: Vec<(String, f64)>,
}

/// The check of all pairs, in order of time.
pub(crate) struct BodyCheck<'a> {
    prepared: &'a Prepared,
    world: Interference,
    /// Most by which the geometric errors of the machine displace two bodies against each other, mm.
    errors: f64,
    tool: Option<usize>,
}

impl<'a> BodyCheck<'a> {
    /// The bodies among each other, and against the stock.
    pub(crate) fn new(prepared: &'a Prepared, stock: &TriDexel) -> Result<(Self, StockBodies), CollisionError> {
        let fixtures: Vec<Fixture> = prepared
            .fixtures
            .iter()
            .map(|(name, mesh)| Fixture { name: name.clone(), mesh: mesh.clone(), on_table: true })
            .collect();
        let world = Interference::new(&prepared.machine, &fixtures, prepared.scene.file.tolerances.near_miss_mm)?;
        let errors = prepared.machine.errors.bound(reach_of(&prepared.machine, prepared));
        let against_stock = StockBodies::new(prepared, &world, stock, errors)?;
        Ok((Self { prepared, world, errors, tool: None }, against_stock))
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
        // The bodies follow the joints straight, and leave that by the deviation of the joints; that of the tool is held as well.
        let (slack, off) = (piece.deviation + self.errors, &piece.joint_deviation);
        let begun = self.world.check_bent_piece([from, to], piece.time, slack, off);
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

    /// What stands on the table and reaches behind its face: no motion tells of it, since it moves as one with the table.
    pub(crate) fn behind_table(&self) -> Vec<(String, f64)> {
        let table = &self.prepared.machine.table;
        let depth = |p: &Point| -(p - table.point).dot(&table.normal);
        let stock = box_mesh(&self.prepared.stock.bounds()).transformed(&self.prepared.table_from_work);
        let fixtures = self.prepared.fixtures.iter().map(|(name, mesh)| (name.clone(), mesh));
        let all = std::iter::once(("stock".to_owned(), &stock)).chain(fixtures);
        let deepest = |mesh: &TriMesh| mesh.positions.iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
        let touching = self.prepared.scene.file.tolerances.contact_mm;
        all.map(|(name, mesh)| (name, deepest(mesh))).filter(|(_, d)| *d > touching).collect()
    }

    /// Number of pairs that were checked.
    pub(crate) fn checked_pairs(&self) -> usize {
        self.world.pairs().iter().filter(|p| p.unchecked.is_none()).count()
    }

    /// Machine bodies on both sides of a tilting platform, which are not checked against each other.
    pub(crate) fn across_platforms(&self) -> Vec<String> {
        let pairs = self.world.pairs().iter().filter(|p| p.unchecked == Some(Unchecked::Platform));
        pairs.map(|p| format!("{} against {}", p.bodies[0], p.bodies[1])).collect()
    }

    /// Bodies that the machine description keeps out of the checks.
    pub(crate) fn excluded(&self) -> Vec<String> {
        let machine = &self.prepared.machine;
        machine.bodies.iter().filter(|b| !b.check).map(|b| b.name.clone()).collect()
    }
}

/// A length that no point of machine, setup or tool is farther than from any line of a joint, and no slide is farther out, mm.
fn reach_of(machine: &Machine, prepared: &Prepared) -> f64 {
    let fixtures = prepared.fixtures.iter().map(|(_, mesh)| mesh);
    let points = machine.bodies.iter().map(|b| &b.mesh).chain(fixtures).flat_map(|mesh| &mesh.positions);
    let farthest = points.map(|p| p.coords.norm()).fold(0.0, f64::max);
    let lines = machine.joints.iter().map(|j| j.point.coords.norm()).fold(0.0, f64::max);
    let tools = prepared.tools.tools.iter().map(|t| t.gauge_length).fold(0.0, f64::max);
    let ways: f64 = machine
        .joints
        .iter()
        .filter(|j| !j.is_rotary())
        .filter_map(|j| j.travel)
        .map(|t| t[0].abs().max(t[1].abs()))
        .sum();
    2.0 * (farthest.max(lines) + tools) + ways
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
