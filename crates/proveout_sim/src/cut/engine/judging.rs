//! Turns what sweeps, bodies and control report of a stretch into findings with their place and
//! time.

use std::collections::BTreeMap;

use proveout_controller::{Chunk, Event, MoveKind, Piece};
use proveout_machine::{JointValues, MachineBody};
use proveout_stock::SweepReport;
use proveout_tool::Role;

use super::{Engine, UnknownPlunge, wording};
use crate::{
    checks::{block_slope::BlockEnds, descent::Judgement},
    cut::{
        bodies::Hit,
        detached_parts::{LooseParts, Shop, Told},
        tool_sweeps::{self, CuttingState, SweepPart, Swept, judge_sweep},
    },
    scene::{FixtureFile, FixtureFrame},
    verdict::{
        finding::{self, Finding},
        log::FindingLog,
    },
};

impl Engine<'_> {
    /// Judges the sweeps.
    pub(super) fn judge_reports(
        &mut self,
        chunk: &Chunk,
        states: &[CuttingState],
        parts: &[SweepPart],
        (reports, between): (&[SweepReport], &[usize]),
    ) {
        let contact = self.prepared.scene.file.tolerances.contact_mm;
        let mut touched = None;
        let mut cores = parts.iter().zip(reports).filter(|(part, _)| part.what == Swept::Core).peekable();
        for (i, (piece, state)) in chunk.pieces.iter().zip(states).enumerate() {
            let met = cores.next_if(|(part, _)| part.piece == i).map(|(_, report)| report);
            self.judge_descent(chunk, piece, state, met);
        }
        for (k, (part, report)) in parts.iter().zip(reports).enumerate() {
            let (piece, state) = (&chunk.pieces[part.piece], &states[part.piece]);
            let Some(tool) = self.tool(state.tool) else { continue };
            if part.what == Swept::Body(Role::Holder) && tool_sweeps::depth(report) > contact {
                touched = Some(part.piece);
            }
            if part.what == Swept::Zone && touched == Some(part.piece) {
                continue; // a holder in material is told as such
            }
            if let Some(code) = judge_sweep(part, piece.kind, state, tool, report, contact) {
                let wanted = self.prepared.scene.file.tolerances.near_miss_mm;
                let mut finding = wording::material(&code, part.what, state, tool, report, wanted);
                if between.binary_search(&k).is_ok() {
                    finding.message += wording::BETWEEN;
                }
                if let Some(index) = state.tool {
                    let role = tool_sweeps::role_of(part.what);
                    finding.message += &wording::chosen_of_tool(&self.prepared.tools, index, role);
                }
                let finding = self.at_piece(finding, piece, piece.time[0]);
                self.log.push(finding);
            }
        }
        for (piece, state) in chunk.pieces.iter().zip(states) {
            let moved = (piece.pose[1].tip - piece.pose[0].tip).norm() > 0.0;
            if state.tool.is_none() && piece.kind == MoveKind::Feed && moved {
                let message = "feed motion with an empty spindle".into();
                let finding = self.at_piece(FindingLog::of(&finding::NO_TOOL, message), piece, piece.time[0]);
                self.log.push(finding);
            }
        }
    }

    /// Follows a tool without edges at its center; `met` is what its core met, where it goes down.
    fn judge_descent(&mut self, chunk: &Chunk, piece: &Piece, state: &CuttingState, met: Option<&SweepReport>) {
        let Some((index, tool)) = state.tool.and_then(|t| Some((t, self.prepared.tools.tools.get(t)?))) else { return };
        let Some(core) = self.cutters.core(index) else { return };
        let contact = self.prepared.scene.file.tolerances.contact_mm;
        let Some(descent) = self.plunge.follow((index, tool), piece, met, core, contact) else { return };
        let measured = descent.angle;
        let (descent, shown) = if BlockEnds::has_ended(chunk, piece.block) {
            let descent = descent.with_slope(self.block_ends.slope(chunk, piece.block));
            (descent, descent.angle)
        } else {
            (descent.without_rounding(), measured)
        };
        match descent.judged(tool, contact) {
            Judgement::Allowed => {}
            Judgement::Unknown => {
                let steepest = self.unknown_plunges.entry(index);
                let steepest = steepest.or_insert(UnknownPlunge { angle: 0.0, block: piece.block });
                if shown > steepest.angle {
                    *steepest = UnknownPlunge { angle: shown, block: piece.block };
                }
            }
            Judgement::Fault { angle, stub } => {
                let left = if tool.dead_center.is_some() { descent.pillar } else { descent.stub };
                let finding = wording::plunge(tool, shown, angle, [left, stub]);
                let mut f = self.at_piece(finding, piece, piece.time[0]);
                f.point_mm = met.and_then(|r| r.first_point).map(|p| [p.x, p.y, p.z]);
                self.log.push(f);
            }
        }
    }

    pub(super) fn judge_hit(&mut self, piece: &Piece, hit: &Hit) {
        let mut told = wording::hit(hit);
        let point = self.work_from_table.point(&hit.point_in_table);
        if self.is_of_program(hit) {
            told.message += &wording::place_of_hit(&point, self.prepared.stock.bounds().min.z);
        }
        told.message += &self.chosen_of_hit(hit);
        let mut f = self.at_piece(told, piece, hit.time);
        f.point_mm = Some(point.coords.into());
        let finding = self.log.push(f);
        self.breaches.push((hit.breach, finding));
    }

    /// Which assumed numbers a hit depends on, in words.
    fn chosen_of_hit(&self, hit: &Hit) -> String {
        let of_tool =
            hit.roles.iter().filter_map(|role| Some(wording::chosen_of_tool(&self.prepared.tools, hit.tool?, *role)));
        let mut all: String = of_tool.collect();
        if self.prepared.mount_assumed && !self.is_of_program(hit) {
            all += wording::ASSUMED_MOUNT;
        }
        all
    }

    /// Whether a body is a fixture whose place is given in coordinates of the workpiece.
    fn is_fixed_to_work(&self, body: &str) -> bool {
        let own = |f: &FixtureFile| f.name == body && f.frame == FixtureFrame::Workpiece;
        self.prepared.scene.file.fixture.iter().any(own)
    }

    /// Whether two bodies meet by the program alone: one of them is fixed to the workpiece, the other goes
    /// with the tool. No mounting changes that.
    fn is_of_program(&self, hit: &Hit) -> bool {
        let machine = &self.prepared.machine;
        let with_tool = |k: usize| {
            let spindle = |b: &MachineBody| b.name == hit.bodies[k] && b.attached_to == machine.spindle.attached_to;
            hit.roles[k].is_some() || machine.bodies.iter().any(spindle)
        };
        let [a, b] = &hit.bodies;
        self.is_fixed_to_work(a) && with_tool(1) || self.is_fixed_to_work(b) && with_tool(0)
    }

    /// A body that came too near to the stock.
    pub(super) fn judge_stock_breach(&mut self, piece: &Piece, index: usize) {
        let Some(breach) = self.stock_bodies.breach(index) else { return };
        let tolerances = &self.prepared.scene.file.tolerances;
        let mut told = wording::stock_breach(breach, tolerances.near_miss_mm, self.stock_bodies.unseen_mm());
        // The whole run sees more of what lies between the rays, and may clear it.
        if self.prepared.wanted.preview.is_some() && wording::may_be_of_the_cells(breach, tolerances.near_miss_mm) {
            told.severity = finding::Severity::Warning;
            told.message += "; preview: its coarse cells may be the only reason";
        }
        let finding = self.at_piece(told, piece, breach.time);
        let finding = self.log.push(finding);
        self.stock_breaches.push((index, finding));
    }

    /// Reports the bodies that are in the stock from the start.
    pub(super) fn tell_at_rest(&mut self) {
        for finding in std::mem::take(&mut self.of_meshes) {
            self.log.push(finding);
        }
        for standing in self.stock_bodies.take_at_rest() {
            let mut told = wording::at_rest(&standing);
            if self.prepared.mount_assumed && !self.is_fixed_to_work(&standing.body) {
                told.message += wording::ASSUMED_MOUNT;
            }
            self.log.push(told);
        }
    }

    pub(super) fn judge_events(&mut self, chunk: &Chunk) {
        for event in &chunk.events {
            if let Event::Overcut { time, location, overcut, .. } = event {
                self.log.push(wording::overcut(*time, location, overcut));
                continue;
            }
            let Some(mut f) = wording::event(event, &self.prepared.machine) else { continue };
            (f.block, f.time_s) = (Some(event.block()), Some(event.time()));
            if let Some(sample) = chunk.samples.iter().find(|s| s.time >= event.time()) {
                f.axes = self.axes(&sample.commanded);
            }
            self.log.push(f);
        }
    }

    /// Joint positions by name, mm or degrees.
    pub(super) fn axes(&self, q: &JointValues) -> BTreeMap<String, f64> {
        let joints = self.prepared.machine.joints.iter().enumerate();
        joints.map(|(i, j)| (j.name.clone(), j.kind.in_unit(q[i]))).collect()
    }

    /// Lets the loose parts do something, and reports the result.
    pub(super) fn follow_loose_parts(&mut self, what: impl FnOnce(&mut LooseParts, &mut Shop<'_>) -> Vec<Told>) {
        let Some(last_piece) = (self.block_of_piece.len() as u32).checked_sub(1) else { return };
        let (prepared, stock, patches) = (self.prepared, &mut self.stock, &mut self.patches[..]);
        let told = what(&mut self.loose, &mut Shop { prepared, stock, patches, last_piece });
        self.ledger.book_fallen(&self.stock);
        for Told { mut finding, at } in told {
            finding.block = at.piece.and_then(|id| self.block_of_piece.get(id as usize).copied());
            (finding.time_s, finding.axes) = (Some(at.time), self.axes(&at.joints));
            self.log.push(finding);
        }
    }

    fn at_piece(&self, mut f: Finding, piece: &Piece, time: f64) -> Finding {
        (f.block, f.time_s) = (Some(piece.block), Some(time));
        let t =
            if piece.time[1] > piece.time[0] { (time - piece.time[0]) / (piece.time[1] - piece.time[0]) } else { 0.0 };
        f.axes = self.axes(&piece.joints[0].interpolated(piece.joints[1], t));
        f
    }
}
