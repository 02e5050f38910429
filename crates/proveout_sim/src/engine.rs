//! One stretch of motion through stock and bodies.

use std::{collections::BTreeMap, sync::Arc, time::Instant};

use proveout_controller::{BlockKind, BlockRecord, Chunk, Event, LimitKind, MoveKind, Piece};
use proveout_geom::Pose;
use proveout_machine::{JointKind, JointValues};
use proveout_nc::{ASSUMED, Location, Overcut, OvercutWeight, SpindleDirection};
use proveout_stock::{Depths, Patch, SweepMotion, SweepReport, TileId, TriDexel};
use proveout_tool::{Profile, Role, Tool};

use crate::{
    bodies::{BodyCheck, Hit, HitKind, StockNear},
    engagement::Engagement,
    error::SimError,
    finding::{self, Code, Finding},
    kept_motion::{KeptMotion, KeptPiece},
    legs,
    log::FindingLog,
    loose::LooseParts,
    memory::{ALLOWANCE, HISTORY_MEMORY},
    observer::{BlockRow, SampleSignals},
    plunge::{self, Judgement, PlungeWatch},
    prepare::Prepared,
    process::{self, CuttingState, SweepPart, Sweeps, Swept, judge_sweep},
    run::Stages,
    texture::{Recorder, Tracks},
    verdict::{Clearance, ToolUse},
};

/// What a stretch gave beside its motion.
#[derive(Debug, Default)]
pub(crate) struct Stretch {
    pub(crate) signals: Vec<SampleSignals>,
    pub(crate) blocks: Vec<BlockRow>,
    pub(crate) findings: Vec<Finding>,
    pub(crate) changed_tiles: Vec<TileId>,
    /// The same for each patch.
    pub(crate) changed_in_patches: Vec<Vec<TileId>>,
    pub(crate) time: f64,
}

/// What the loop knows at the end of the program.
#[derive(Debug)]
pub(crate) struct Facts {
    pub(crate) log: FindingLog,
    pub(crate) tools: Vec<ToolUse>,
    pub(crate) tools_without_holder: Vec<String>,
    pub(crate) clearance: Clearance,
    pub(crate) removed: f64,
    /// What is not known since parts came off the stock.
    pub(crate) loose: Option<String>,
    pub(crate) pieces: u64,
    /// The program told its end (M2, M30).
    pub(crate) ended: bool,
    /// Block of every piece, by its id in the stock.
    pub(crate) block_of_piece: Vec<u32>,
    /// File and line of every block.
    pub(crate) places: Vec<Option<(Arc<str>, u32)>>,
    /// Bodies that the machine keeps out of the checks.
    pub(crate) excluded_bodies: Vec<String>,
    /// Pairs of bodies that were checked.
    pub(crate) checked_pairs: usize,
    /// Bodies that nothing checks against the stock, and how near its box came to them.
    pub(crate) stock_near: StockNear,
    /// Ways down into material of which nobody says whether the tool may make them, by tool.
    pub(crate) unknown_plunges: Vec<String>,
    /// All motion, where somebody asks for the surface that it swept.
    pub(crate) motion: Option<KeptMotion>,
    /// Motion near the places of `[surface]`, where the scene has them.
    pub(crate) tracks: Option<Tracks>,
}

/// The steepest way down into material of a tool that may not be allowed, and where.
#[derive(Clone, Copy, Debug)]
struct UnknownPlunge {
    angle: f64,
    block: u32,
}

/// Sums over the pieces of a block.
#[derive(Clone, Copy, Debug, Default)]
struct BlockSum {
    volume: f64,
    overlap: f64,
    engagement: Option<Engagement>,
    tool: Option<usize>,
}

pub(crate) struct Engine<'a> {
    prepared: &'a Prepared,
    work_from_table: Pose,
    stock: TriDexel,
    /// Cut like the stock; everything is judged on the stock alone.
    patches: Vec<Patch>,
    bodies: BodyCheck<'a>,
    depths: Depths,
    /// First piece of the run in which the cutter must not meet material, the tool, and why.
    barred: Option<(u32, Option<usize>, &'static str)>,
    /// Cores of the tools that are watched for going down, by tool.
    cores: Vec<Vec<Profile>>,
    plunge: PlungeWatch,
    unknown_plunges: BTreeMap<usize, UnknownPlunge>,
    log: FindingLog,
    /// Breach of the bodies, and the finding that tells of it.
    breaches: Vec<(usize, usize)>,
    state: CuttingState,
    uses: BTreeMap<usize, (usize, ToolUse)>,
    in_spindle_since: f64,
    sums: BTreeMap<u32, BlockSum>,
    block_of_piece: Vec<u32>,
    motion: Option<KeptMotion>,
    recorder: Option<Recorder<'a>>,
    places: Vec<Option<(Arc<str>, u32)>>,
    removed: f64,
    loose: LooseParts,
    /// Volume that was removed when the parts were looked at last, mm³.
    looked_at: f64,
    time: f64,
    ended: bool,
    /// End of the last piece, and its signals.
    last_signals: (f64, SampleSignals),
}

impl<'a> Engine<'a> {
    pub(crate) fn new(prepared: &'a Prepared, stock: TriDexel, patches: Vec<Patch>) -> Result<Self, SimError> {
        Ok(Self {
            prepared,
            work_from_table: prepared.table_from_work.inverse(),
            loose: LooseParts::new(&stock),
            looked_at: 0.0,
            depths: Depths::new(prepared.scene.file.tolerances.contact_mm),
            barred: None,
            cores: prepared
                .tools
                .tools
                .iter()
                .map(|t| plunge::core(t, stock.cell_mm()).into_iter().collect())
                .collect(),
            plunge: PlungeWatch::default(),
            unknown_plunges: BTreeMap::new(),
            bodies: BodyCheck::new(prepared, &stock)?,
            stock,
            patches,
            log: FindingLog::default(),
            breaches: Vec::new(),
            state: CuttingState { tool: None, spindle: SpindleDirection::Off, speed_rpm: 0.0 },
            uses: BTreeMap::new(),
            in_spindle_since: 0.0,
            sums: BTreeMap::new(),
            block_of_piece: Vec::new(),
            motion: prepared.keeps_motion().then(KeptMotion::default),
            recorder: prepared.texture.as_ref().map(|plan| Recorder::new(prepared, plan.areas())),
            places: Vec::new(),
            removed: 0.0,
            time: 0.0,
            ended: false,
            last_signals: (f64::NEG_INFINITY, SampleSignals::default()),
        })
    }

    pub(crate) fn stock(&self) -> &TriDexel {
        &self.stock
    }

    pub(crate) fn patches(&self) -> &[Patch] {
        &self.patches
    }

    pub(crate) fn pieces(&self) -> u64 {
        self.block_of_piece.len() as u64
    }

    fn tool(&self, index: Option<usize>) -> Option<&'a Tool> {
        index.and_then(|i| self.prepared.tools.tools.get(i))
    }

    /// Cuts and checks a stretch; its parts are in order of time.
    pub(crate) fn step(&mut self, chunk: &Chunk, stages: &mut Stages) -> Stretch {
        let known = self.log.len();
        for block in &chunk.blocks {
            self.place(block);
        }
        let states = self.states_of_pieces(chunk);
        if let Some(recorder) = &mut self.recorder {
            recorder.take(chunk, &states);
        }
        let first_id = self.block_of_piece.len() as u32;
        let mut sweeps = Sweeps::default();
        for (i, (piece, state)) in chunk.pieces.iter().zip(&states).enumerate() {
            let id = first_id + i as u32;
            self.block_of_piece.push(piece.block);
            let [from, to] = piece.pose.map(|p| p.transformed(&self.work_from_table));
            if let Some(motion) = &mut self.motion {
                motion.push(KeptPiece {
                    time: piece.time,
                    motion: SweepMotion { from, to },
                    tool: state.tool.map_or(u32::MAX, |t| t as u32),
                    feed: piece.kind == MoveKind::Feed,
                    deviation: piece.deviation as f32,
                });
            }
            let Some((index, tool)) = state.tool.and_then(|t| Some((t, self.prepared.tools.tools.get(t)?))) else {
                self.barred = None;
                continue;
            };
            self.barred = process::fault(piece.kind, state, tool).map(|code| match self.barred {
                Some((since, of, why)) if (of, why) == (state.tool, code.code) => (since, of, why),
                _ => (id, state.tool, code.code),
            });
            let zones = self.prepared.holder_zones.get(index).map_or(&[][..], Vec::as_slice);
            let goes_down = piece.kind == MoveKind::Feed && plunge::way_down(&piece.pose).0 > 0.0;
            let core = self.cores.get(index).filter(|_| goes_down).map_or(&[][..], Vec::as_slice);
            let since = self.barred.map(|(since, ..)| since);
            sweeps.add((i, id), SweepMotion { from, to }, tool, [zones, core], since);
        }
        let Sweeps { items, measures, parts } = sweeps;
        let (stock, patches, bodies, depths) = (&mut self.stock, &mut self.patches, &mut self.bodies, &mut self.depths);
        let cut = || {
            patches.iter_mut().for_each(|p| p.sweep(&items));
            stock.sweep_measured(&items, &measures, depths)
        };
        let ((reports, removal), (hits, collision)) =
            rayon::join(|| timed(cut), || timed(|| bodies.check(&chunk.pieces, &states)));
        stages.removal += removal;
        stages.collision += collision;

        self.keep_history(chunk, first_id);
        let volumes = self.judge_reports(chunk, &states, &parts, &reports);
        let clearances: Vec<Option<f64>> = hits.iter().map(|h| h.clearance).collect();
        for (piece, checked) in chunk.pieces.iter().zip(hits) {
            for hit in checked.hits {
                self.judge_hit(piece, &hit);
            }
        }
        self.judge_events(chunk);
        for (mut f, at) in legs::breaches(&self.prepared.machine, &chunk.samples) {
            (f.block, f.time_s, f.axes) = (Some(at.block), Some(at.time), self.axes(&at.commanded));
            self.log.push(f);
        }
        if chunk.events.iter().any(|e| matches!(e, Event::ToolChange { .. } | Event::Stop { .. } | Event::End { .. })) {
            self.look_for_loose_parts(Some((chunk, first_id)));
        }
        let blocks = chunk.blocks.iter().filter_map(|b| self.finish_block(b)).collect();
        self.time = chunk.samples.last().map_or(self.time, |s| s.time.max(self.time));
        self.time = chunk.pieces.last().map_or(self.time, |p| p.time[1].max(self.time));
        self.time = chunk.blocks.last().map_or(self.time, |b| b.end_time.max(self.time));
        Stretch {
            signals: signals(chunk, &states, &volumes, &clearances, &mut self.last_signals),
            blocks,
            findings: self.log.all()[known..].to_vec(),
            changed_tiles: self.stock.take_changed_tiles(),
            changed_in_patches: self.patches.iter_mut().map(|p| p.stock_mut().take_changed_tiles()).collect(),
            time: self.time,
        }
    }

    /// Refuses to go on when the stock takes more than was announced.
    pub(crate) fn check_memory(&self) -> Result<(), SimError> {
        let stocks = || std::iter::once(&self.stock).chain(self.patches.iter().map(Patch::stock));
        let used: u64 = stocks().map(|s| s.memory_bytes() - s.history_bytes()).sum();
        let announced = self.prepared.memory.of_stocks();
        if used <= announced.saturating_add(ALLOWANCE) {
            return Ok(());
        }
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let rays: f64 = stocks().map(|s| s.rays() as f64).sum();
        let intervals = stocks().map(|s| s.intervals_per_ray() * s.rays() as f64).sum::<f64>() / rays.max(1.0);
        // It may go on as it did over the lines that are left. Half is added: lines are no measure of what they remove, and the last
        // one that is known may lie ahead of what was cut.
        let line = self.places.iter().rev().flatten().next().map_or(1, |p| p.1);
        let done = f64::from(line) / f64::from(self.prepared.program_lines.max(1));
        let at_end = 1.0 + (intervals - 1.0).max(0.0) / done.clamp(0.02, 1.0);
        let enough = 1.5 * intervals.max(at_end);
        Err(SimError::Memory {
            used_mib: mib(used),
            announced_mib: mib(announced),
            intervals,
            time_s: self.time,
            remedy: format!("write `intervals_per_ray = {enough:.1}` under [stock], or take coarser cells"),
        })
    }

    /// Closes the run.
    pub(crate) fn finish(mut self) -> (TriDexel, Vec<Patch>, Facts) {
        self.tool_out(self.time);
        self.look_for_loose_parts(None);
        for (breach, finding) in std::mem::take(&mut self.breaches) {
            if let Some((penetration, distance)) = self.bodies.worst(breach) {
                self.log.deepen(finding, penetration, distance);
            }
        }
        let mut uses: Vec<(usize, ToolUse)> = self.uses.into_values().collect();
        uses.sort_by_key(|(order, _)| *order);
        let tools: Vec<ToolUse> = uses.into_iter().map(|(_, u)| u).collect();
        let library = &self.prepared.tools.tools;
        let tools_without_holder = tools
            .iter()
            .filter(|u| library.iter().any(|t| t.name == u.name && !t.has_holder))
            .map(|u| u.name.clone())
            .collect();
        let unknown_plunges =
            self.unknown_plunges.iter().map(|(t, p)| unknown_plunge(&library[*t], p, &self.places)).collect();
        let facts = Facts {
            log: self.log.placed(&self.places),
            tools,
            tools_without_holder,
            clearance: self.bodies.clearance(),
            removed: self.removed,
            loose: self.loose.left_out(),
            pieces: self.block_of_piece.len() as u64,
            ended: self.ended,
            block_of_piece: self.block_of_piece,
            motion: self.motion,
            tracks: self.recorder.map(Recorder::finish),
            places: self.places,
            excluded_bodies: self.bodies.excluded(),
            checked_pairs: self.bodies.checked_pairs(),
            stock_near: self.bodies.stock_near(),
            unknown_plunges,
        };
        (self.stock, self.patches, facts)
    }

    fn place(&mut self, block: &BlockRecord) {
        let index = block.index as usize;
        if self.places.len() <= index {
            self.places.resize(index + 1, None);
        }
        self.places[index] = Some((block.file.clone(), block.line));
    }

    /// Tool and spindle at each piece; events of earlier blocks come first.
    fn states_of_pieces(&mut self, chunk: &Chunk) -> Vec<CuttingState> {
        let mut states = Vec::with_capacity(chunk.pieces.len());
        let mut events = chunk.events.iter().peekable();
        for piece in &chunk.pieces {
            while let Some(event) = events.next_if(|e| e.block() < piece.block) {
                self.apply(event);
            }
            states.push(self.state);
        }
        events.for_each(|e| self.apply(e));
        states
    }

    fn apply(&mut self, event: &Event) {
        match *event {
            Event::ToolChange { time, tool, .. } => {
                self.tool_out(time);
                // The spindle stands for the change and needs a new M3 or M4 after it.
                self.state = CuttingState { tool, spindle: SpindleDirection::Off, speed_rpm: 0.0 };
                if let Some(t) = self.tool(tool) {
                    let order = self.uses.len();
                    let fresh = || (order, ToolUse { number: t.number, name: t.name.clone(), ..ToolUse::default() });
                    self.uses.entry(tool.unwrap_or_default()).or_insert_with(fresh);
                }
            }
            Event::Spindle { direction, speed_rpm, .. } => {
                (self.state.spindle, self.state.speed_rpm) = (direction, speed_rpm);
            }
            Event::End { .. } => self.ended = true,
            _ => {}
        }
    }

    /// Books the time of the tool in the spindle until now.
    fn tool_out(&mut self, now: f64) {
        if let Some((_, used)) = self.state.tool.and_then(|t| self.uses.get_mut(&t)) {
            used.time_s += now - self.in_spindle_since;
        }
        self.in_spindle_since = now;
    }

    /// Notes when the pieces ended; gives the history up when it has grown too large.
    fn keep_history(&mut self, chunk: &Chunk, first_id: u32) {
        let patches = self.patches.iter_mut().map(Patch::stock_mut);
        let mut all: Vec<&mut TriDexel> = std::iter::once(&mut self.stock).chain(patches).collect();
        for (i, piece) in chunk.pieces.iter().enumerate() {
            all.iter_mut().for_each(|s| s.note_end(first_id + i as u32, piece.time[1]));
        }
        if all.iter().map(|s| s.history_bytes()).sum::<u64>() > HISTORY_MEMORY {
            all.iter_mut().for_each(|s| s.drop_history());
            let message = format!(
                "the history of the stock is given up: it has grown past {} MiB (leave `history` out, or take a coarser resolution_mm)",
                HISTORY_MEMORY >> 20
            );
            let mut f = FindingLog::of(&finding::NOTE, message);
            (f.block, f.time_s) = chunk.pieces.last().map_or((None, None), |p| (Some(p.block), Some(p.time[1])));
            self.log.push(f);
        }
    }

    /// Judges the sweeps; gives the removed volume of every piece, mm³.
    fn judge_reports(
        &mut self,
        chunk: &Chunk,
        states: &[CuttingState],
        parts: &[SweepPart],
        reports: &[SweepReport],
    ) -> Vec<f64> {
        let mut volumes = vec![0.0; chunk.pieces.len()];
        let contact = self.prepared.scene.file.tolerances.contact_mm;
        let mut touched = None;
        let mut cores = parts.iter().zip(reports).filter(|(part, _)| part.what == Swept::Core).peekable();
        for (i, (piece, state)) in chunk.pieces.iter().zip(states).enumerate() {
            let met = cores.next_if(|(part, _)| part.piece == i).map(|(_, report)| report);
            self.judge_descent(piece, state, met);
        }
        for (part, report) in parts.iter().zip(reports) {
            let (piece, state) = (&chunk.pieces[part.piece], &states[part.piece]);
            let Some(tool) = self.tool(state.tool) else { continue };
            if part.what == Swept::Body(Role::Cutting) {
                volumes[part.piece] += report.volume_mm3;
                let sum = self.sums.entry(piece.block).or_default();
                sum.volume += report.volume_mm3;
                sum.overlap = sum.overlap.max(report.overlap_mm);
                if let Some(contact) = report.contact.filter(|_| report.overlap_mm > contact) {
                    let engaged = Engagement::of_piece(&contact, piece, state, tool);
                    sum.engagement = Some(sum.engagement.map_or(engaged, |e| e.union(&engaged)));
                }
                self.removed += report.volume_mm3;
            }
            if part.what == Swept::Body(Role::Holder) && process::depth(report) > contact {
                touched = Some(part.piece);
            }
            if part.what == Swept::Zone && touched == Some(part.piece) {
                continue; // a holder in material is told as such
            }
            if let Some(code) = judge_sweep(part, piece.kind, state, tool, report, contact) {
                let finding = self.material_finding(&code, part.what, piece, tool, report);
                self.log.push(finding);
            }
        }
        for (piece, state) in chunk.pieces.iter().zip(states) {
            self.sums.entry(piece.block).or_default().tool = state.tool;
            let moved = (piece.pose[1].tip - piece.pose[0].tip).norm() > 0.0;
            if state.tool.is_none() && piece.kind == MoveKind::Feed && moved {
                let message = "feed motion with an empty spindle".into();
                let finding = self.at_piece(FindingLog::of(&finding::NO_TOOL, message), piece, piece.time[0]);
                self.log.push(finding);
            }
        }
        volumes
    }

    /// Follows a tool without edges at its center; `met` is what its core met, where it goes down.
    fn judge_descent(&mut self, piece: &Piece, state: &CuttingState, met: Option<&SweepReport>) {
        let Some((index, tool)) = state.tool.and_then(|t| Some((t, self.prepared.tools.tools.get(t)?))) else { return };
        let Some(core) = self.cores.get(index).and_then(|c| c.first()) else { return };
        let contact = self.prepared.scene.file.tolerances.contact_mm;
        let Some(descent) = self.plunge.follow((index, tool), piece, met, core, contact) else { return };
        match descent.judged(tool, contact) {
            Judgement::Allowed => {}
            Judgement::Unknown => {
                let steepest = self.unknown_plunges.entry(index);
                let steepest = steepest.or_insert(UnknownPlunge { angle: 0.0, block: piece.block });
                if descent.angle > steepest.angle {
                    *steepest = UnknownPlunge { angle: descent.angle, block: piece.block };
                }
            }
            Judgement::Fault { angle, stub } => {
                let finding = plunge_finding(tool, descent.angle, angle, [descent.stub, stub]);
                let mut f = self.at_piece(finding, piece, piece.time[0]);
                f.point_mm = met.and_then(|r| r.first_point).map(|p| [p.x, p.y, p.z]);
                self.log.push(f);
            }
        }
    }

    fn material_finding(&self, code: &Code, what: Swept, piece: &Piece, tool: &Tool, report: &SweepReport) -> Finding {
        let part = match what {
            Swept::Body(Role::Cutting) => "cutter",
            Swept::Core => "core",
            Swept::Body(Role::Neck) => "neck",
            Swept::Body(Role::Shank) => "shank",
            Swept::Body(Role::Holder) | Swept::Zone => "holder",
        };
        let how = match code.code {
            c if c == finding::RAPID_IN_MATERIAL.code => " at rapid rate",
            c if c == finding::SPINDLE_OFF.code => " while the spindle stands still",
            c if c == finding::SPINDLE_WRONG_WAY.code => " while the spindle turns against its hand",
            _ => "",
        };
        let near = code.code == finding::NEAR_MISS.code;
        let wanted = self.prepared.scene.file.tolerances.near_miss_mm;
        let message = if near {
            format!("{part} of {} comes nearer to the stock than the wanted {wanted:.3} mm", tool.name)
        } else {
            format!(
                "{part} of {} meets material{how}: {:.3} mm deep, {:.3} mm3 in this piece",
                tool.name,
                process::depth(report),
                report.volume_mm3
            )
        };
        let mut f = self.at_piece(FindingLog::of(code, message), piece, piece.time[0]);
        f.bodies = vec![format!("{}/{part}", tool.name), "stock".into()];
        if near {
            (f.limit, f.unit) = (Some(wanted), Some("mm".into()));
        } else {
            f.penetration_mm = Some(process::depth(report));
        }
        f.point_mm = report.first_point.map(|p| [p.x, p.y, p.z]);
        f
    }

    fn judge_hit(&mut self, piece: &Piece, hit: &Hit) {
        let [a, b] = &hit.bodies;
        let inside = if hit.inside { ", one inside of the other" } else { "" };
        let near = self.prepared.scene.file.tolerances.near_miss_mm;
        let (code, message) = match hit.kind {
            HitKind::Collision => (&finding::COLLISION, format!("{a} hits {b}{inside}")),
            HitKind::NearMiss(_) => {
                (&finding::NEAR_MISS, format!("{a} comes nearer to {b} than the wanted {near:.3} mm"))
            }
        };
        let mut f = self.at_piece(FindingLog::of(code, message), piece, hit.time);
        f.bodies = hit.bodies.to_vec();
        f.penetration_mm = hit.penetration;
        if let HitKind::NearMiss(left) = hit.kind {
            (f.clearance_mm, f.limit, f.unit) = (Some(left), Some(near), Some("mm".into()));
        }
        f.point_mm = Some(self.work_from_table.point(&hit.point_in_table).coords.into());
        let finding = self.log.push(f);
        self.breaches.push((hit.breach, finding));
    }

    fn judge_events(&mut self, chunk: &Chunk) {
        for event in &chunk.events {
            let found = match event {
                Event::Limit { joint, value, limit, kind: LimitKind::Travel, .. } => {
                    let joint = joint.and_then(|j| self.prepared.machine.joints.get(j));
                    let kind_of_joint = joint.map_or(JointKind::Linear, |j| j.kind);
                    let (unit, scale) = (kind_of_joint.unit(), kind_of_joint.unit_factor());
                    let name = joint.map_or("a joint", |j| j.name.as_str());
                    let (value, limit) = (value * scale, limit * scale);
                    let message = format!(
                        "{name} is sent to {value:.3} {unit}, {:.3} {unit} past its travel of {limit:.3} {unit}",
                        (value - limit).abs()
                    );
                    let mut f = FindingLog::of(&finding::OVERTRAVEL, message);
                    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some(unit.into()));
                    f.bodies = vec![name.into()];
                    f
                }
                Event::Limit { joint, value, limit, kind: LimitKind::DriveForce, .. } => {
                    let joint = joint.and_then(|j| self.prepared.machine.joints.get(j));
                    let linear = joint.is_none_or(|j| j.kind == JointKind::Linear);
                    let (word, unit, scale) = if linear { ("force", "N", 1.0) } else { ("torque", "Nm", 1e-3) };
                    let name = joint.map_or("a joint", |j| j.name.as_str());
                    let (value, limit) = (value * scale, limit * scale);
                    let message = format!(
                        "the control asks the drive of {name} for a {word} of {value:.1} {unit}; it has {limit:.1} {unit}, \
                         and the joint leaves its set points"
                    );
                    let mut f = FindingLog::of(&finding::DRIVE_SATURATED, message);
                    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some(unit.into()));
                    f.bodies = vec![name.into()];
                    f
                }
                Event::Limit {
                    joint,
                    value,
                    limit,
                    kind: kind @ (LimitKind::Velocity | LimitKind::Acceleration | LimitKind::Jerk),
                    ..
                } => {
                    let joint = joint.and_then(|j| self.prepared.machine.joints.get(j));
                    let kind_of_joint = joint.map_or(JointKind::Linear, |j| j.kind);
                    let (unit, scale) = (kind_of_joint.unit(), kind_of_joint.unit_factor());
                    let (word, per) = match kind {
                        LimitKind::Velocity => ("velocity", "s"),
                        LimitKind::Acceleration => ("acceleration", "s²"),
                        _ => ("jerk", "s³"),
                    };
                    let name = joint.map_or("a joint", |j| j.name.as_str());
                    let (value, limit) = (value * scale, limit * scale);
                    let unit = format!("{unit}/{per}");
                    let message = format!(
                        "the set points ask {name} for a {word} of {value:.3} {unit}; its limit is {limit:.3} {unit}"
                    );
                    let mut f = FindingLog::of(&finding::PLANNED_MOTION, message);
                    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some(unit));
                    f.bodies = vec![name.into()];
                    f
                }
                Event::Limit { value, limit, kind: LimitKind::SpindleSpeed, .. } => {
                    let message = format!("spindle speed {value:.0} 1/min is above the limit of {limit:.0} 1/min");
                    let mut f = FindingLog::of(&finding::SPINDLE_SPEED, message);
                    (f.value, f.limit, f.unit) = (Some(*value), Some(*limit), Some("1/min".into()));
                    f
                }
                Event::UnreachablePose { reason, .. } => FindingLog::of(
                    &finding::UNREACHABLE,
                    format!("the programmed tool pose cannot be reached: {reason}"),
                ),
                Event::LeavesCircle { angle, at_flank, in_cone, reason, .. } => {
                    let code = if *in_cone { &finding::POLE_CROSSED } else { &finding::OFF_CIRCLE };
                    let angle = angle.to_degrees();
                    let message = format!(
                        "{reason}: the tool axis leaves the programmed great circle by {angle:.6} degrees, {at_flank:.6} mm at the flank"
                    );
                    let mut f = FindingLog::of(code, message);
                    (f.value, f.unit) = (Some(angle), Some("deg".into()));
                    f
                }
                Event::Probe { .. } => FindingLog::of(
                    &finding::PROBED,
                    "the probing motion runs to its end: what the probe finds is not known".into(),
                ),
                Event::Note { text, .. } => match text.strip_prefix(ASSUMED) {
                    Some(assumed) => FindingLog::of(&finding::ASSUMED, assumed.to_owned()),
                    None => FindingLog::of(&finding::NOTE, text.clone()),
                },
                Event::Overcut { time, location, overcut, .. } => {
                    self.log.push(overcut_finding(*time, location, overcut));
                    continue;
                }
                _ => continue,
            };
            let mut f = found;
            (f.block, f.time_s) = (Some(event.block()), Some(event.time()));
            if let Some(sample) = chunk.samples.iter().find(|s| s.time >= event.time()) {
                f.axes = self.axes(&sample.commanded);
            }
            self.log.push(f);
        }
    }

    /// Joint positions by name, mm or degrees.
    fn axes(&self, q: &JointValues) -> BTreeMap<String, f64> {
        let joints = self.prepared.machine.joints.iter().enumerate();
        joints.map(|(i, j)| (j.name.clone(), j.kind.in_unit(q[i]))).collect()
    }

    /// Tells parts that have come off; the chunk under way, with the id of its first piece, gives them their time.
    fn look_for_loose_parts(&mut self, now: Option<(&Chunk, u32)>) {
        if self.removed == self.looked_at {
            return;
        }
        self.looked_at = self.removed;
        for part in self.loose.look(&self.stock) {
            let size = part.bounds.size();
            let message = format!(
                "{:.1} mm3 no longer hang together with the rest of the stock: {:.1} x {:.1} x {:.1} mm; the twin leaves them in their place",
                part.volume_mm3, size.x, size.y, size.z
            );
            let mut f = FindingLog::of(&finding::LOOSE_PART, message);
            f.bodies = vec!["stock".into()];
            f.point_mm = Some(part.center.coords.into());
            (f.value, f.unit) = (Some(part.volume_mm3), Some("mm3".into()));
            let piece = now
                .zip(part.last_made_by)
                .and_then(|((chunk, first), id)| chunk.pieces.get(id.checked_sub(first)? as usize));
            let block = part.last_made_by.and_then(|id| self.block_of_piece.get(id as usize).copied());
            f = match piece {
                Some(piece) => self.at_piece(f, piece, piece.time[1]),
                None => Finding { block, time_s: Some(self.time), ..f },
            };
            self.log.push(f);
        }
    }

    fn at_piece(&self, mut f: Finding, piece: &Piece, time: f64) -> Finding {
        (f.block, f.time_s) = (Some(piece.block), Some(time));
        let t =
            if piece.time[1] > piece.time[0] { (time - piece.time[0]) / (piece.time[1] - piece.time[0]) } else { 0.0 };
        f.axes = self.axes(&piece.joints[0].interpolated(piece.joints[1], t));
        f
    }

    fn finish_block(&mut self, block: &BlockRecord) -> Option<BlockRow> {
        let sum = self.sums.remove(&block.index).unwrap_or_default();
        let BlockKind::Move(kind) = block.kind else { return None };
        if let Some((_, used)) = sum.tool.and_then(|t| self.uses.get_mut(&t)) {
            used.volume_mm3 += sum.volume;
            if kind == MoveKind::Feed {
                used.cut_time_s += block.end_time - block.start_time;
                used.length_mm += block.length;
            }
        }
        Some(BlockRow {
            block: block.index,
            file: block.file.clone(),
            line: block.line,
            kind,
            tool: sum.tool.map(|t| t as u32),
            start_time: block.start_time,
            end_time: block.end_time,
            length: block.length,
            feed: (kind == MoveKind::Feed).then_some(block.feed),
            volume_mm3: sum.volume,
            engagement_mm: sum.overlap,
            engagement: sum.engagement,
        })
    }
}

/// A place where the compensated path enters its own contour. It was told behind the stretch, so its line is that of the
/// reader and not that of the block under way.
fn overcut_finding(time: f64, location: &Location, overcut: &Overcut) -> Finding {
    let code = match overcut.kind.weight() {
        OvercutWeight::Error => &finding::OVERCUT,
        OvercutWeight::Warning => &finding::CONTOUR_TOUCHED,
        OvercutWeight::Info => &finding::NOTE,
    };
    let mut f = FindingLog::of(code, overcut.to_string());
    (f.file, f.line) = (Some(location.file.to_string()), Some(location.line));
    f.time_s = Some(time);
    f.penetration_mm = Some(overcut.depth);
    f
}

/// What is known of a way down that is not allowed: its angle or its stub, each with its limit.
fn plunge_finding(tool: &Tool, angle: f64, limit: f64, [stub, most]: [f64; 2]) -> Finding {
    let name = &tool.name;
    let (angle_deg, limit_deg) = (angle.to_degrees(), limit.to_degrees());
    let ramp = match tool.max_ramp_angle {
        Some(_) => format!("its steepest ramp is {limit_deg:.3} degrees"),
        None => "its steepest ramp is not stated".to_owned(),
    };
    let steep = angle > limit;
    let message = if steep {
        format!("{name} has no edges at its center and goes down into material at {angle_deg:.3} degrees; {ramp}")
    } else {
        format!(
            "{name} has no edges at its center and leaves a stub of {stub:.3} mm under it: it goes down without moving aside by \
             its radius; {ramp}, which leaves {most:.3} mm"
        )
    };
    let mut f = FindingLog::of(&finding::PLUNGE, message);
    f.bodies = vec![name.clone()];
    if steep {
        f.value = Some(angle_deg);
        (f.limit, f.unit) = (tool.max_ramp_angle.map(|_| limit_deg), Some("deg".into()));
    } else {
        (f.value, f.limit, f.unit) = (Some(stub), Some(most), Some("mm".into()));
    }
    f
}

fn unknown_plunge(tool: &Tool, plunge: &UnknownPlunge, places: &[Option<(Arc<str>, u32)>]) -> String {
    let at = places.get(plunge.block as usize).and_then(Option::as_ref);
    let at = at.map_or_else(String::new, |(file, line)| format!(" ({file}:{line})"));
    let missing = if tool.center_cutting.is_none() { "center_cutting" } else { "max_ramp_angle_deg" };
    let (name, angle) = (&tool.name, plunge.angle.to_degrees());
    format!(
        "whether {name} may go down into material at {angle:.1} degrees{at}: the tool library gives it no `{missing}`"
    )
}

/// Signals beside the samples: those of the piece that holds the sample. `last` carries the piece that reaches over the
/// end of a stretch, with its end.
fn signals(
    chunk: &Chunk,
    states: &[CuttingState],
    volumes: &[f64],
    clearances: &[Option<f64>],
    last: &mut (f64, SampleSignals),
) -> Vec<SampleSignals> {
    let of_piece = |at: usize| {
        let piece = &chunk.pieces[at];
        let duration = piece.time[1] - piece.time[0];
        SampleSignals {
            removal_rate: if duration > 0.0 { volumes[at] / duration } else { 0.0 },
            clearance: clearances[at],
            tool: states[at].tool.map(|t| t as u32),
        }
    };
    let mut at = 0;
    let all = chunk.samples.iter().map(|sample| {
        while at + 1 < chunk.pieces.len() && chunk.pieces[at].time[1] < sample.time {
            at += 1;
        }
        match chunk.pieces.get(at) {
            Some(p) if p.time[0] <= sample.time && sample.time <= p.time[1] => of_piece(at),
            _ if sample.time <= last.0 => last.1,
            _ => SampleSignals::default(),
        }
    });
    let all = all.collect();
    if let Some(end) = chunk.pieces.last() {
        *last = (end.time[1], of_piece(chunk.pieces.len() - 1));
    }
    all
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}
