//! Bodies against bodies along the pieces of motion.

use proveout_collision::{
    CollisionError, Effort, FinerPiece, Fixture, Interference, PairInfo, PartKind, Severity, Unchecked, ZONE_MM,
};
use proveout_controller::Piece;
use proveout_geom::{Point, TriMesh, box_mesh};
use proveout_machine::Machine;
use proveout_stock::TriDexel;
use proveout_tool::Role;

use crate::{
    cut::{body_facts::Told, stock_bodies::StockBodies, tool_sweeps::CuttingState},
    observe::block_rows::ClearanceProof,
    prepare::prepared::Prepared,
    verdict::{
        finding::ToolPart,
        verdict_file::{Clearance, PairClearance, UncheckedPair},
    },
};

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
    /// The tool in the spindle, by its index in the library.
    pub(crate) tool: Option<usize>,
    /// Of both bodies: which part of the tool it is; none for other bodies.
    pub(crate) roles: [Option<Role>; 2],
    /// When, s.
    pub(crate) time: f64,
    pub(crate) penetration: Option<f64>,
    pub(crate) inside: bool,
    /// Distance that they are to keep, mm.
    pub(crate) wanted: f64,
    pub(crate) point_in_table: Point,
    /// Index of the breach, whose figures grow while it lasts.
    pub(crate) breach: usize,
}

impl Hit {
    /// The part of the tool among the two bodies.
    pub(crate) fn tool_part(&self) -> Option<ToolPart> {
        let body = self.roles.iter().position(Option::is_some)?;
        Some(ToolPart { tool: self.tool?, role: self.roles[body], body, swept: false })
    }
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

    /// Keeps the motion from now on, so that the least clearance of every pair can be reported at
    /// the end.
    pub(crate) fn keep_proof(&mut self) {
        self.world.keep_proof();
    }

    /// Checks pieces in order; `states` gives the tool of each.
    pub(crate) fn check(&mut self, pieces: &[Piece], states: &[CuttingState]) -> Vec<Checked> {
        pieces.iter().zip(states).map(|(piece, state)| self.check_one(piece, state)).collect()
    }

    fn check_one(&mut self, piece: &Piece, state: &CuttingState) -> Checked {
        if state.tool != self.tool {
            self.tool = state.tool;
            self.world.set_tool(state.tool.and_then(|t| self.prepared.tools.tools.get(t)));
        }
        let [from, to] = &piece.joints;
        // The bodies follow the joints straight, and leave that by the deviation of the joints; that of the
        // tool is held as well.
        let (slack, off) = (piece.deviation + self.errors, &piece.joint_deviation);
        // Between its quarters the joints bound all bodies, the tool among them.
        let finer = piece.finer.map(|finer| {
            let (joints, off) = finer.places(&piece.joints);
            FinerPiece { joints, off, slack: self.errors }
        });
        let begun = self.world.check_curved_piece([from, to], piece.time, slack, off, finer.as_ref());
        let hits = begun.map(|i| self.hit(i)).collect();
        let proved = self.world.proved_now();
        Checked { hits, clearance: proved.is_finite().then_some(proved) }
    }

    /// The figures of a breach as they are by now: deepest penetration and least distance, mm.
    pub(crate) fn worst(&self, breach: usize) -> Option<(Option<f64>, f64)> {
        self.world.breaches().get(breach).map(|b| (b.penetration_estimate, b.least_distance))
    }

    /// Least clearance of every pair over the run, with that of the bodies against the stock, and the proof.
    pub(crate) fn clearance(&mut self, stock: &StockBodies) -> (Clearance, ClearanceProof) {
        let bound = self.world.clearance();
        let all = self.world.least_clearances().to_vec();
        let infos = self.world.pairs();
        let names = |pair: usize| infos[pair].bodies.clone().map(|b| b.to_string());
        let pair = |l: &proveout_collision::PairClearance| PairClearance {
            bodies: names(l.pair),
            min_mm: l.measured,
            error_mm: l.measured.map(|m| (m - l.proved).max(0.0)),
            proved_mm: l.proved,
            time_s: l.time,
            near_miss_mm: own_near_miss(&infos[l.pair]),
        };
        let against = stock.least();
        // Neighbors are near each other all the time: they count where they come nearer than wanted.
        let counted =
            all.iter().filter(|l| !l.neighbors || l.measured.is_some_and(|m| m < infos[l.pair].near_miss)).map(pair);
        let counted = counted.chain(against.iter().filter(|p| p.min_mm.is_some()).cloned());
        let least = counted.min_by(|a, b| a.min_mm.unwrap_or(f64::MAX).total_cmp(&b.min_mm.unwrap_or(f64::MAX)));
        // No pair of bodies is nearer than what is proved of it. Against the stock more is not asked than
        // whether the clearance is kept.
        let proved = all.iter().filter(|l| !l.neighbors).map(|l| l.proved).fold(f64::INFINITY, f64::min);
        let proved = least.as_ref().map_or(proved, |l| proved.min(l.proved_mm));
        let pairs: Vec<PairClearance> = all.iter().map(pair).chain(against).collect();
        let min_mm =
            least.as_ref().and_then(|l| l.min_mm).or(bound.lower_bound.is_finite().then_some(bound.lower_bound));
        let time_s = match (&least, &bound.measured) {
            (Some(l), Some(n)) if l.time_s.is_none() && n.bodies.clone().map(|b| b.to_string()) == l.bodies => {
                Some(n.time)
            }
            (Some(l), _) => l.time_s,
            (None, n) => n.as_ref().map(|n| n.time),
        };
        let clearance = Clearance {
            min_mm,
            error_mm: min_mm.map(|m| (m - proved).max(0.0)).filter(|e| e.is_finite()),
            pair: least.map(|l| l.bodies).or(bound.measured.map(|n| n.bodies.map(|b| b.to_string()))),
            time_s,
            checks: self.world.pieces(),
            pairs,
            unchecked: self.unchecked(),
        };
        let bodies = infos.iter().map(|i| i.bodies.clone()).collect();
        (clearance, ClearanceProof { bodies, spans: self.world.proved_spans().to_vec() })
    }

    /// Pairs that are not checked, with the reason; parts that move as one are no pair.
    fn unchecked(&self) -> Vec<UncheckedPair> {
        let pairs =
            self.world.pairs().iter().filter_map(|p| Some((p, p.unchecked.filter(|u| *u != Unchecked::Rigid)?)));
        let words = |(p, why): (&PairInfo, Unchecked)| UncheckedPair {
            bodies: p.bodies.clone().map(|b| b.to_string()),
            reason: match p.ruled.as_deref().filter(|_| why == Unchecked::PairExcluded) {
                Some(reason) => format!("{}: {reason}", why.reason()),
                None => why.reason().into(),
            },
            cause: Some(why),
        };
        pairs.map(words).collect()
    }

    /// What is mounted on the table and reaches below its face. No motion shows it, since it moves
    /// as one with the table.
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

    /// How the checks were settled, and stretches of motion that were looked at for the least clearances.
    pub(crate) fn effort(&self) -> (Effort, u64) {
        (self.world.effort(), self.world.looks())
    }

    /// Number of pairs that were checked.
    pub(crate) fn checked_pairs(&self) -> usize {
        self.world.pairs().iter().filter(|p| p.unchecked.is_none()).count()
    }

    /// Remarks for the gates on pairs with a rule of their own, and on incomplete meshes.
    pub(crate) fn told(&self) -> Told {
        let mut told = Told::default();
        let named = |p: &PairInfo| p.bodies.join(" against ");
        let because = |p: &PairInfo| match p.ruled.as_deref() {
            None | Some("") => String::new(),
            Some(reason) => format!(" ({reason})"),
        };
        let mut excluded = Vec::new();
        for p in self.world.pairs() {
            if p.unchecked == Some(Unchecked::PairExcluded) {
                excluded.push(named(p) + &because(p));
            } else if let (Some(wanted), None) = (own_near_miss(p), p.unchecked) {
                told.own_near_miss.push(format!("{} {wanted} mm{}", named(p), because(p)));
            }
        }
        if !excluded.is_empty() {
            told.left_out.push(format!("pairs that the machine file excludes: {}", excluded.join(", ")));
        }
        let bearing = self.world.pairs().iter().filter(|p| p.bearing > 0.0 && p.unchecked.is_none());
        let bearing: Vec<String> = bearing.map(named).collect();
        if !bearing.is_empty() {
            told.remarks.push(format!(
                "neighbors checked outside of the zone where they bear on each other, up to {ZONE_MM} mm around their contact at rest: {}",
                bearing.join(", ")
            ));
        }
        for (name, faults) in self.world.mesh_faults() {
            if let Some(fault) = &faults.open {
                told.left_out.push(format!("the inside of {name}: {fault}; its surface is checked"));
            }
            match faults.flat {
                0 => {}
                1 => told.remarks.push(format!("1 triangle of {name} has no area and counts as a line")),
                n => told.remarks.push(format!("{n} triangles of {name} have no area and count as lines")),
            }
        }
        told
    }

    fn hit(&self, index: usize) -> Hit {
        let breach = &self.world.breaches()[index];
        Hit {
            kind: match breach.severity {
                Severity::NearMiss => HitKind::NearMiss(breach.distance),
                Severity::Collision | Severity::QueryFailed => HitKind::Collision,
            },
            bodies: breach.bodies.clone().map(|b| b.to_string()),
            tool: self.tool,
            roles: breach.kinds.map(PartKind::role),
            time: breach.time,
            penetration: breach.penetration_estimate,
            inside: breach.inside,
            wanted: self.world.pairs()[breach.pair].near_miss,
            point_in_table: breach.point_in_table,
            breach: index,
        }
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

/// A length that no point of machine, setup or tool is farther than from any line of a joint, and no slide is
/// farther out, mm.
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

/// Near-miss distance that the machine file states for the pair, mm.
fn own_near_miss(pair: &PairInfo) -> Option<f64> {
    pair.ruled.is_some().then_some(pair.near_miss)
}
