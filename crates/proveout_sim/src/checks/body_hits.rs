//! Two bodies hit each other ([`COLLISION`], gate `collision`), or come closer than required ([`NEAR_MISS`],
//! gate `near_miss`).
//!
//! Bodies are the parts of the machine, the fixtures, and the parts of the tool in the spindle. Between the
//! ends of a piece of motion the distance is bounded, not sampled
//! ([`BodyCheck`](crate::cut::bodies::BodyCheck)). The clearance is `tolerances.near_miss_mm`, or that of the
//! pair in the machine file. At the end of the run each finding takes the deepest penetration and the least
//! clearance of its breach. Pairs that are not checked are named by the gate.

use proveout_controller::Piece;
use proveout_geom::Point;
use proveout_machine::MachineBody;

use crate::{
    checks::{
        assumed_values::{ASSUMED_MOUNT, chosen_of_tool, is_fixed_to_work},
        check::{Check, RunEnd, StretchView},
    },
    cut::bodies::{Hit, HitKind},
    prepare::prepared::Prepared,
    verdict::{
        finding::{COLLISION, Finding, NEAR_MISS},
        log::FindingLog,
    },
};

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct BodyHits {
    /// Breach of the bodies, and the finding that reports it.
    breaches: Vec<(usize, usize)>,
}

impl Check for BodyHits {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        for (piece, checked) in view.chunk.pieces.iter().zip(view.hits) {
            for hit in &checked.hits {
                let finding = log.push(of_hit(view, piece, hit));
                self.breaches.push((hit.breach, finding));
            }
        }
    }

    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        for (breach, finding) in std::mem::take(&mut self.breaches) {
            if let Some((penetration, distance)) = end.bodies.worst(breach) {
                log.deepen(finding, penetration, distance);
            }
        }
    }
}

fn of_hit(view: &StretchView<'_>, piece: &Piece, hit: &Hit) -> Finding {
    let prepared = view.prepared;
    let mut f = finding(hit);
    let point = view.work_from_table.point(&hit.point_in_table);
    if is_of_program(prepared, hit) {
        f.message += &place_of_hit(&point, prepared.stock.bounds().min.z);
    }
    f.message += &assumed_of_hit(prepared, hit);
    let mut f = view.at_piece(f, piece, hit.time);
    f.point_mm = Some(point.coords.into());
    f
}

/// Which assumed values a hit depends on, in words.
fn assumed_of_hit(prepared: &Prepared, hit: &Hit) -> String {
    let of_tool = hit.roles.iter().filter_map(|role| Some(chosen_of_tool(&prepared.tools, hit.tool?, *role)));
    let mut all: String = of_tool.collect();
    if prepared.mount_assumed && !is_of_program(prepared, hit) {
        all += ASSUMED_MOUNT;
    }
    all
}

/// Whether two bodies meet by the program alone: one of them is fixed to the workpiece, the other goes
/// with the tool. No mounting changes that.
fn is_of_program(prepared: &Prepared, hit: &Hit) -> bool {
    let machine = &prepared.machine;
    let with_tool = |k: usize| {
        let spindle = |b: &MachineBody| b.name == hit.bodies[k] && b.attached_to == machine.spindle.attached_to;
        hit.roles[k].is_some() || machine.bodies.iter().any(spindle)
    };
    let [a, b] = &hit.bodies;
    is_fixed_to_work(prepared, a) && with_tool(1) || is_fixed_to_work(prepared, b) && with_tool(0)
}

/// Where a tool meets what is fixed to the workpiece, in words: a place of the program, which no mounting
/// changes. `lowest`: lower face of the raw stock, workpiece frame, mm.
fn place_of_hit(point_in_work: &Point, lowest: f64) -> String {
    let [x, y, z] = [point_in_work.x, point_in_work.y, point_in_work.z].map(|v| v + 0.0);
    let below = lowest - z;
    let below = if below > 0.0 { format!(", {below:.3} mm below the raw stock") } else { String::new() };
    format!(" at X{x:.3} Y{y:.3} Z{z:.3} of the workpiece{below}")
}

/// Two bodies too near.
fn finding(hit: &Hit) -> Finding {
    let ([a, b], near) = (&hit.bodies, hit.wanted);
    let inside = if hit.inside { ", one inside of the other" } else { "" };
    let (code, message) = match hit.kind {
        HitKind::Collision => (&COLLISION, format!("{a} hits {b}{inside}")),
        HitKind::NearMiss(_) => (&NEAR_MISS, format!("{a} comes closer to {b} than the required {near:.3} mm")),
    };
    let mut f = FindingLog::of(code, message);
    f.bodies = hit.bodies.to_vec();
    f.penetration_mm = hit.penetration;
    f.tool = hit.tool_part();
    if let HitKind::NearMiss(left) = hit.kind {
        (f.clearance_mm, f.limit, f.unit) = (Some(left), Some(near), Some("mm".into()));
    }
    f
}
