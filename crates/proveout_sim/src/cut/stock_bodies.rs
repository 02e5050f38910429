//! Bodies of machine and setup against the stock while it is cut.
//!
//! A stretch is cut in one go, so that the sweeps run in parallel. The bodies are asked first, against the
//! stock at its begin: material only goes away, so that what is clear then is clear. Where a body would come
//! too near in piece k, the pieces before k are cut and the rest is asked again: what the cutter has taken by
//! then is no obstacle.
//!
//! ```text
//!   pieces   0 . . . . k . . . . . n
//!   ask      |---------x               against the stock before 0: too near in k
//!   cut      |########|
//!   ask                |-----------|   against the stock before k
//!   cut                |###########|
//! ```
//!
//! Sweeps do the same in any division.

use proveout_collision::{CollisionError, Interference, JointMotion, Severity, StockBreach, StockCheck};
use proveout_controller::Piece;
use proveout_geom::TriMesh;
use proveout_stock::{SolidOverlap, SweepReport, TriDexel};

use crate::{
    cut::{body_facts::StockNear, cut_source::Cuts, cutting::Cutting, stages::timed, tool_sweeps::Sweeps},
    prepare::prepared::Prepared,
    verdict::verdict_file::PairClearance,
};

/// A body inside the stock that does not move against it.
#[derive(Clone, Debug)]
pub(crate) struct AtRest {
    pub(crate) body: String,
    pub(crate) overlap: SolidOverlap,
}

/// What a stretch gave.
#[derive(Debug, Default)]
pub(crate) struct Cut {
    /// Of each sweep.
    pub(crate) reports: Vec<SweepReport>,
    /// Index of a piece, and of the breach that began in it.
    pub(crate) breaches: Vec<(usize, usize)>,
    /// Wall time of the two parts of the work, s.
    pub(crate) removal: f64,
    pub(crate) collision: f64,
}

/// The check of all bodies against the stock, in order of time.
#[derive(Debug)]
pub(crate) struct StockBodies {
    check: StockCheck,
    errors: f64,
    /// Bodies inside the stock at the start, until they are reported.
    at_rest: Vec<AtRest>,
}

impl StockBodies {
    /// `errors` is the most by which the geometric errors of the machine displace two bodies against each
    /// other, mm.
    pub(crate) fn new(
        prepared: &Prepared,
        world: &Interference,
        stock: &TriDexel,
        errors: f64,
    ) -> Result<Self, CollisionError> {
        let check = StockCheck::new(world, stock, &prepared.table_from_work, errors)?;
        let touching = prepared.scene.file.tolerances.contact_mm;
        let work_from_table = prepared.table_from_work.inverse();
        // What is inside an open mesh is unknown; the gate says so.
        let open: Vec<&str> = world.mesh_faults().filter(|(_, f)| f.open.is_some()).map(|(n, _)| &**n).collect();
        let fixed = |name: &str| check.fixed_to_stock().iter().any(|n| **n == *name) && !open.contains(&name);
        let bodies = prepared.machine.bodies.iter().filter(|b| b.check).map(|b| (&b.name, &b.mesh));
        let standing =
            bodies.chain(prepared.fixtures.iter().map(|(name, mesh)| (name, mesh))).filter(|(n, _)| fixed(n));
        let overlap = |(name, mesh): (&String, &TriMesh)| {
            let overlap = stock.overlap_with(&mesh.transformed(&work_from_table))?;
            (overlap.depth_mm > touching).then(|| AtRest { body: name.clone(), overlap })
        };
        let at_rest = standing.filter_map(overlap).collect();
        Ok(Self { check, errors, at_rest })
    }

    /// Bodies inside the stock as it was at the start; each is reported once.
    pub(crate) fn take_at_rest(&mut self) -> Vec<AtRest> {
        std::mem::take(&mut self.at_rest)
    }

    /// Cuts a stretch, and follows the bodies through it; `cuts` is where they are written down, or taken
    /// from.
    pub(crate) fn cut(
        &mut self,
        mut cutting: Cutting<'_>,
        mut cuts: Option<&mut Cuts>,
        sweeps: &Sweeps<'_>,
        pieces: &[Piece],
    ) -> Cut {
        let motion = |p: &Piece| JointMotion {
            joints: p.joints,
            time: p.time,
            off: p.joint_deviation,
            slack: p.deviation + self.errors,
        };
        let motions: Vec<JointMotion> = pieces.iter().map(motion).collect();
        let mut out = Cut::default();
        let (mut piece, mut sweep) = (0, 0);
        loop {
            let known = self.check.breaches().len();
            let (done, collision) = timed(|| self.check.follow(cutting.stock, &motions[piece..]));
            out.collision += collision;
            for (index, breach) in self.check.breaches().iter().enumerate().skip(known) {
                // Breaches begin within a piece, at its end at the latest.
                let within = pieces[piece..piece + done].iter().position(|p| breach.time <= p.time[1]);
                out.breaches.push((piece + within.unwrap_or(done.saturating_sub(1)), index));
            }
            piece += done;
            let next = sweeps.parts.partition_point(|part| part.piece < piece);
            let ((), removal) = timed(|| {
                let (items, measures) = (&sweeps.items[sweep..next], &sweeps.measures[sweep..next]);
                out.reports.extend(match &mut cuts {
                    Some(cuts) if !items.is_empty() => cuts.sweep(&mut cutting, items, measures),
                    _ => cutting.sweep(items, measures),
                });
            });
            out.removal += removal;
            sweep = next;
            if piece >= pieces.len() {
                return out;
            }
        }
    }

    /// Least distance of each body that is followed.
    pub(crate) fn least(&self) -> Vec<PairClearance> {
        let of = |(body, proved, seen): (&std::sync::Arc<str>, f64, Option<f64>)| PairClearance {
            bodies: [body.to_string(), "stock".into()],
            min_mm: seen,
            error_mm: seen.map(|s| (s - proved).max(0.0)),
            proved_mm: proved.min(f64::MAX),
            time_s: None,
            near_miss_mm: None,
        };
        self.check.least().map(of).collect()
    }

    pub(crate) fn breach(&self, index: usize) -> Option<&StockBreach> {
        self.check.breaches().get(index)
    }

    /// Distance queries and motions so far.
    pub(crate) fn effort(&self) -> (u64, u64) {
        (self.check.queries(), self.check.motions())
    }

    /// What the rays cannot resolve, mm.
    pub(crate) fn unseen_mm(&self) -> f64 {
        self.check.unseen_mm()
    }

    /// What was followed and what not, in all.
    pub(crate) fn near(&self, behind_table: Vec<(String, f64)>) -> StockNear {
        let (flush, layer_mm) = self.check.flush();
        let near = |name: &str| self.check.breaches().iter().any(|b| *b.body == *name);
        StockNear {
            clear: self.check.followed().filter(|name| !near(name)).count(),
            followed: self.check.followed().count(),
            unseen_mm: self.check.unseen_mm(),
            flush: flush.iter().map(|n| n.to_string()).collect(),
            layer_mm,
            fixed: self.check.fixed_to_stock().iter().map(|n| n.to_string()).collect(),
            behind_table,
        }
    }
}

/// True where the breach is only a distance below the wanted one.
pub(crate) fn is_near_miss(breach: &StockBreach) -> bool {
    breach.severity == Severity::NearMiss
}
