//! One stretch of motion through stock and bodies.

mod ledger;

use ledger::Ledger;

use std::{collections::BTreeMap, sync::Arc};

use proveout_controller::{BlockKind, BlockRecord, Chunk, Event, MoveKind};
use proveout_geom::Pose;
use proveout_stock::{Depths, Patch, SlicePlan, SweepMotion, SweepReport, TileId, TriDexel};
use proveout_tool::Role;

use crate::{
    checks::{
        CheckList,
        check::{self, BlockEnd, RunEnd, StretchView},
        thread_strokes::{Strokes, ThreadCuts},
    },
    cut::{
        block_sums::BlockSums,
        bodies::{BodyCheck, Checked},
        body_facts::{StockNear, Told},
        cut_source::Cuts,
        cutting::Cutting,
        detached_parts::{self, LooseParts, Shop},
        engaged_samples::{EngagedSample, SampleMaker},
        kept_motion::{KeptMotion, KeptPiece},
        stages::{Checks, Stages, timed},
        stock_bodies::StockBodies,
        texture_motion::{Recorder, Tracks},
        tool_between_rays::BetweenWatch,
        tool_sweeps::{Barring, Cutters, CuttingState, SweepPart, Sweeps, Swept},
        tool_uses::ToolUses,
    },
    observe::block_rows::{BlockRow, ClearanceProof, LooseMotion, SampleSignals},
    prepare::{
        error::SimError,
        memory::{ALLOWANCE, HISTORY_MEMORY},
        prepared::Prepared,
    },
    verdict::{
        finding::{self, Finding},
        log::{self, FindingLog},
        verdict_file::{Clearance, ToolUse},
    },
};

/// What a stretch gave in addition to its motion.
#[derive(Debug, Default)]
pub(crate) struct Stretch {
    pub(crate) signals: Vec<SampleSignals>,
    pub(crate) blocks: Vec<BlockRow>,
    pub(crate) findings: Vec<Finding>,
    pub(crate) changed_tiles: Vec<TileId>,
    /// The same for each patch.
    pub(crate) changed_in_patches: Vec<Vec<TileId>>,
    /// Parts that came off the stock and moved.
    pub(crate) loose: Vec<LooseMotion>,
    pub(crate) time: f64,
}

/// What the loop knows at the end of the program.
#[derive(Debug)]
pub(crate) struct Facts {
    pub(crate) log: FindingLog,
    pub(crate) tools: Vec<ToolUse>,
    pub(crate) tools_without_holder: Vec<String>,
    pub(crate) clearance: Clearance,
    pub(crate) proof: ClearanceProof,
    pub(crate) removed: f64,
    /// Volume of the stock at the end, mm³: the raw stock less what was removed and what fell off.
    pub(crate) left: f64,
    /// What is not known since parts came off the stock.
    pub(crate) loose: Vec<String>,
    /// What is known of those parts.
    pub(crate) loose_known: Option<String>,
    /// Volume of those that are no longer stock, mm³.
    pub(crate) fallen: f64,
    pub(crate) pieces: u64,
    /// The program reached its end (M2, M30).
    pub(crate) ended: bool,
    /// Block of every piece, by its id in the stock.
    pub(crate) block_of_piece: Vec<u32>,
    /// Tools that cut as the cylinder round them (a tap), by the block that they cut in.
    pub(crate) envelopes: BTreeMap<u32, usize>,
    /// Motions of taps along their axis.
    pub(crate) strokes: Strokes,
    /// File and line of every block.
    pub(crate) places: Vec<Option<(Arc<str>, u32)>>,
    /// Bodies that the machine keeps out of the checks.
    pub(crate) excluded_bodies: Vec<String>,
    /// Remarks for the gates on pairs and meshes.
    pub(crate) told: Told,
    /// How the checks were settled.
    pub(crate) effort: Checks,
    /// Machine bodies on both sides of a tilting platform.
    pub(crate) across_platforms: Vec<String>,
    /// Pairs of bodies that were checked.
    pub(crate) checked_pairs: usize,
    /// Bodies that are followed against the stock, and those that are not.
    pub(crate) stock_near: StockNear,
    /// All motion, where the surface that it swept is asked for.
    pub(crate) motion: Option<KeptMotion>,
    /// Motion near the places of `[surface]`, where the scene has them.
    pub(crate) tracks: Option<Tracks>,
}

pub(crate) struct Engine<'a> {
    prepared: &'a Prepared,
    work_from_table: Pose,
    stock: TriDexel,
    /// Cut like the stock; everything is judged on the stock alone.
    patches: Vec<Patch>,
    bodies: BodyCheck<'a>,
    stock_bodies: StockBodies,
    depths: Depths,
    /// Where the cuts are written down, or taken from.
    cuts: Option<Cuts>,
    barring: Barring,
    cutters: Cutters,
    between: BetweenWatch,
    checks: CheckList,
    log: FindingLog,
    tool_uses: ToolUses,
    block_sums: BlockSums,
    block_of_piece: Vec<u32>,
    threads: ThreadCuts,
    motion: Option<KeptMotion>,
    recorder: Option<Recorder<'a>>,
    samples: Option<SampleMaker>,
    places: Vec<Option<(Arc<str>, u32)>>,
    ledger: Ledger,
    loose: LooseParts,
    time: f64,
    /// End of the last piece, and its signals.
    last_signals: (f64, SampleSignals),
}

impl<'a> Engine<'a> {
    pub(crate) fn new(
        prepared: &'a Prepared,
        stock: TriDexel,
        patches: Vec<Patch>,
        cuts: Option<Cuts>,
    ) -> Result<Self, SimError> {
        let (bodies, mut stock_bodies) = BodyCheck::new(prepared, &stock)?;
        Ok(Self {
            prepared,
            work_from_table: prepared.table_from_work.inverse(),
            ledger: Ledger::new(&stock, prepared.stock.own_volume()),
            loose: LooseParts::new(&stock),
            depths: Depths::new(prepared.scene.file.tolerances.contact_mm),
            cuts,
            barring: Barring::default(),
            cutters: Cutters::new(&prepared.tools.tools, &prepared.holder_zones, stock.cell_mm()),
            between: BetweenWatch::new(prepared.stock.between().clone()),
            checks: CheckList::new(stock_bodies.take_at_rest()),
            bodies,
            stock_bodies,
            stock,
            patches,
            log: FindingLog::default(),
            tool_uses: ToolUses::new(),
            block_sums: BlockSums::default(),
            block_of_piece: Vec::new(),
            threads: ThreadCuts::new(&prepared.tools),
            motion: prepared.keeps_motion().then(KeptMotion::default),
            recorder: prepared.texture.as_ref().map(|plan| Recorder::new(prepared, plan.areas())),
            samples: None,
            places: Vec::new(),
            time: 0.0,
            last_signals: (f64::NEG_INFINITY, SampleSignals::default()),
        })
    }

    /// Proves the least clearance of every pair of bodies as well.
    pub(crate) fn prove_clearance(&mut self) {
        self.bodies.keep_proof();
    }

    /// Sorts the engagement into samples of at most `step` mm of path and slices of `slice` mm, see
    /// [`Self::take_samples`].
    pub(crate) fn sample_engagement(&mut self, step: f64, slice: f64) {
        let plan = SlicePlan::new(step, slice);
        self.stock.watch_slices(plan);
        self.samples = plan.map(|plan| SampleMaker::new(plan, step));
    }

    /// The samples that are complete since the last call; with `end`, all that are left.
    pub(crate) fn take_samples(&mut self, end: bool) -> Vec<EngagedSample> {
        self.samples.as_mut().map_or_else(Vec::new, |s| s.take(end))
    }

    pub(crate) fn stock(&self) -> &TriDexel {
        &self.stock
    }

    pub(crate) fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// Simulated time to which motion was cut and judged, s.
    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    pub(crate) fn pieces(&self) -> u64 {
        self.block_of_piece.len() as u64
    }

    /// Cuts and checks a stretch; its parts are in order of time.
    pub(crate) fn step(&mut self, chunk: &Chunk, stages: &mut Stages) -> Stretch {
        let known = self.log.len();
        for block in &chunk.blocks {
            self.place(block);
        }
        let states = self.tool_uses.states_of_pieces(self.prepared, chunk);
        if let Some(recorder) = &mut self.recorder {
            recorder.take(chunk, &states);
        }
        let first_id = self.block_of_piece.len() as u32;
        self.follow_loose_parts(|loose, shop| loose.go_on(shop, chunk));
        let mut sweeps = Sweeps::default();
        for (i, (piece, state)) in chunk.pieces.iter().zip(&states).enumerate() {
            let id = first_id + i as u32;
            self.block_of_piece.push(piece.block);
            let [from, to] = piece.pose.map(|p| p.transformed(&self.work_from_table));
            let motion = SweepMotion { from, to };
            self.threads.add([id, piece.block], &self.prepared.tools, state.tool, &motion);
            if let Some(kept) = &mut self.motion {
                kept.push(KeptPiece {
                    time: piece.time,
                    motion,
                    tool: state.tool.map_or(u32::MAX, |t| t as u32),
                    feed: piece.kind == MoveKind::Feed,
                    deviation: piece.edge_deviation as f32,
                });
            }
            if let Some(cut) = self.barring.cut(id, piece, state, &self.prepared.tools.tools, motion) {
                self.cutters.add(&mut sweeps, i, &cut);
            }
        }
        let (bodies, stock_bodies) = (&mut self.bodies, &mut self.stock_bodies);
        let cutting = Cutting { stock: &mut self.stock, patches: &mut self.patches, depths: &mut self.depths };
        let cuts = self.cuts.as_mut();
        let (mut cut, (hits, collision)) = rayon::join(
            || stock_bodies.cut(cutting, cuts, &sweeps, &chunk.pieces),
            || timed(|| bodies.check(&chunk.pieces, &states)),
        );
        stages.removal += cut.removal;
        stages.collision += collision + cut.collision;
        let sizes = [self.prepared.scene.file.tolerances.contact_mm, self.stock.cell_mm()];
        let (between, took) = timed(|| self.between.look(&sweeps, &mut cut.reports, &chunk.pieces, &states, sizes));
        stages.removal += took;
        let parts = sweeps.parts;

        self.keep_history(chunk, first_id);
        let volumes = self.book_cuts(chunk, &states, &parts, &cut.reports);
        if let Some(samples) = &mut self.samples {
            let contacts = self.stock.take_slices();
            samples.stretch(chunk, (&states, &self.prepared.tools.tools), first_id, &contacts, &volumes);
        }
        let view = StretchView {
            prepared: self.prepared,
            work_from_table: &self.work_from_table,
            chunk,
            states: &states,
            first_id,
            cutters: &self.cutters,
            parts: &parts,
            reports: &cut.reports,
            between_rays: &between,
            hits: &hits,
            stock_breaches: &cut.breaches,
            stock_bodies: &self.stock_bodies,
        };
        self.checks.stretch(&view, &mut self.log);
        self.search_loose_parts((chunk, first_id), &states, &cut.reports);
        let blocks = chunk.blocks.iter().filter_map(|b| self.finish_block(b)).collect();
        self.time = chunk.samples.last().map_or(self.time, |s| s.time.max(self.time));
        self.time = chunk.pieces.last().map_or(self.time, |p| p.time[1].max(self.time));
        self.time = chunk.blocks.last().map_or(self.time, |b| b.end_time.max(self.time));
        Stretch {
            signals: signals(chunk, &states, &volumes, &hits, &mut self.last_signals),
            blocks,
            findings: log::placed(self.log.all()[known..].to_vec(), &self.places),
            changed_tiles: self.stock.take_changed_tiles(),
            changed_in_patches: self.patches.iter_mut().map(|p| p.stock_mut().take_changed_tiles()).collect(),
            loose: self.loose.take_motions(),
            time: self.time,
        }
    }

    /// Refuses to go on with cuts of other motion.
    pub(crate) fn check_cuts(&mut self) -> Result<(), SimError> {
        self.cuts.as_mut().and_then(Cuts::take_fault).map_or(Ok(()), Err)
    }

    /// Where the cuts are written down, or taken from.
    pub(crate) fn cuts(&self) -> Option<&Cuts> {
        self.cuts.as_ref()
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
        // It may go on as it did over the lines that are left. Half is added: lines are no measure of what
        // they remove, and the last one that is known may lie ahead of what was cut.
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
        let tools = self.tool_uses.finish(self.time);
        self.follow_loose_parts(LooseParts::finish);
        let library = &self.prepared.tools.tools;
        let tools_without_holder = tools
            .iter()
            .filter(|u| library.iter().any(|t| t.name == u.name && !t.has_holder))
            .map(|u| u.name.clone())
            .collect();
        let end = RunEnd {
            prepared: self.prepared,
            tools: &tools,
            places: &self.places,
            bodies: &self.bodies,
            stock_bodies: &self.stock_bodies,
            between: &self.between.facts(library, &self.places),
        };
        self.checks.finish(&end, &mut self.log);
        let (clearance, proof) = self.bodies.clearance(&self.stock_bodies);
        let (bodies, looks) = self.bodies.effort();
        let (stock_queries, stock_motions) = self.stock_bodies.effort();
        let effort = Checks { bodies, looks, stock_motions, stock_queries };
        let facts = Facts {
            log: self.log.placed(&self.places).without_near_misses_of_hits(),
            tools,
            tools_without_holder,
            clearance,
            proof,
            removed: self.ledger.removed(),
            left: self.ledger.left(&self.stock),
            loose: self.loose.left_out(),
            loose_known: self.loose.checked(),
            fallen: self.ledger.fallen(),
            pieces: self.block_of_piece.len() as u64,
            ended: self.tool_uses.has_ended(),
            block_of_piece: self.block_of_piece,
            envelopes: self.threads.envelopes,
            strokes: self.threads.strokes,
            motion: self.motion,
            tracks: self.recorder.map(Recorder::finish),
            places: self.places,
            excluded_bodies: self.bodies.excluded(),
            told: self.bodies.told(),
            effort,
            across_platforms: self.bodies.across_platforms(),
            checked_pairs: self.bodies.checked_pairs(),
            stock_near: self.stock_bodies.near(self.bodies.behind_table()),
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

    /// Follows the parts that have come off, and searches the stock for more of them.
    fn search_loose_parts(
        &mut self,
        (chunk, first_id): (&Chunk, u32),
        states: &[CuttingState],
        reports: &[SweepReport],
    ) {
        self.loose.watch(self.prepared, chunk, states, reports);
        let settled =
            chunk.events.iter().any(|e| matches!(e, Event::ToolChange { .. } | Event::Stop { .. } | Event::End { .. }));
        if !self.ledger.is_cut_since_search() || !(settled || self.loose.is_due(&self.stock)) {
            self.loose.moved(self.prepared, chunk);
        } else {
            self.ledger.note_search();
            let last = chunk.events.iter().any(|e| matches!(e, Event::End { .. } | Event::Ended { .. }));
            self.follow_loose_parts(|loose, shop| loose.look(shop, (chunk, first_id), states, last));
            self.between.parts_are_gone(&self.loose.gone_bounds());
            if self.loose.has_taken()
                && let Some(cuts) = &mut self.cuts
            {
                cuts.stock_was_changed();
            }
        }
    }

    /// Lets the loose parts do something, and reports the result.
    fn follow_loose_parts(&mut self, what: impl FnOnce(&mut LooseParts, &mut Shop<'_>) -> Vec<detached_parts::Told>) {
        let Some(last_piece) = (self.block_of_piece.len() as u32).checked_sub(1) else { return };
        let (prepared, stock, patches) = (self.prepared, &mut self.stock, &mut self.patches[..]);
        let told = what(&mut self.loose, &mut Shop { prepared, stock, patches, last_piece });
        self.ledger.book_fallen(&self.stock);
        for detached_parts::Told { mut finding, at } in told {
            finding.block = at.piece.and_then(|id| self.block_of_piece.get(id as usize).copied());
            (finding.time_s, finding.axes) = (Some(at.time), check::axes(&prepared.machine, &at.joints));
            self.log.push(finding);
        }
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
                "the history of the stock was dropped: it exceeds {} MiB (leave `history` out, or use a coarser resolution_mm)",
                HISTORY_MEMORY >> 20
            );
            let mut f = FindingLog::of(&finding::NOTE, message);
            (f.block, f.time_s) = chunk.pieces.last().map_or((None, None), |p| (Some(p.block), Some(p.time[1])));
            self.log.push(f);
        }
    }

    /// Books what the cuts of a stretch took; gives the removed volume of every piece, mm³.
    fn book_cuts(
        &mut self,
        chunk: &Chunk,
        states: &[CuttingState],
        parts: &[SweepPart],
        reports: &[SweepReport],
    ) -> Vec<f64> {
        let cuts = |part: &SweepPart| part.what == Swept::Body(Role::Cutting);
        let reported: f64 = parts.iter().zip(reports).filter(|(part, _)| cuts(part)).map(|(_, r)| r.volume_mm3).sum();
        let share = self.ledger.book_cuts(&self.stock, reported);
        let contact = self.prepared.scene.file.tolerances.contact_mm;
        let tools = &self.prepared.tools.tools;
        self.block_sums.add((chunk, states), tools, (parts, reports), [share, contact])
    }

    fn finish_block(&mut self, block: &BlockRecord) -> Option<BlockRow> {
        let sum = self.block_sums.take(block.index);
        let BlockKind::Move(kind) = block.kind else { return None };
        self.checks.block(&BlockEnd { prepared: self.prepared, block, sum: &sum }, &mut self.log);
        self.tool_uses.book_block(sum.tool, block, kind, sum.volume);
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

/// Signals for the samples: those of the piece that holds the sample. `last` carries the piece that
/// reaches over the end of a stretch, with its end.
fn signals(
    chunk: &Chunk,
    states: &[CuttingState],
    volumes: &[f64],
    hits: &[Checked],
    last: &mut (f64, SampleSignals),
) -> Vec<SampleSignals> {
    let of_piece = |at: usize| {
        let piece = &chunk.pieces[at];
        let duration = piece.time[1] - piece.time[0];
        SampleSignals {
            removal_rate: if duration > 0.0 { volumes[at] / duration } else { 0.0 },
            clearance: hits[at].clearance,
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
