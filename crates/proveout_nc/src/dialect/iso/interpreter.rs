//! Runs a program line by line.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::flavor::FlavorChoice;
use super::index::Index;
use super::modal::{CycleValues, Modal};
use super::parser::{self, IsoBlock, Remark};
use super::run_state::{CallKind, FagorCycle, IsoCall, Loaded, alarm, offset_key};
use super::variables::MacroVariables;
use super::{grbl, leftover, osp, recover};
use crate::channel::corners::{CornerLanguage, CornerMark, Corners};
use crate::channel::doubt::{Doubt, Stage};
use crate::channel::{Channel, FailedBlock, Language, LineLanguage, ProgramSection, UsualFeed};
use crate::codes;
use crate::control::MixedFeed;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::not_run::NotRun;
use crate::source::{Mark, Source};
use crate::{AxisValues, Command, Offset, Op, Settings};

pub(super) use super::run_state::{Interpreter, Iso};

/// The program, before its first block. `folder`: where it lies, if it is a file.
pub(super) fn begin(source: Source, folder: Option<PathBuf>, settings: &Settings, told: FlavorChoice) -> Interpreter {
    let flavor = told.flavor;
    let own = Iso {
        flavor,
        assumed: !told.certain,
        no_cycle: false,
        block_numbers: BTreeMap::new(),
        offsets: settings.work_offsets.iter().map(|(word, &offset)| (offset_key(word), offset)).collect(),
        turns: BTreeMap::new(),
        lengths: BTreeMap::new(),
        radii: BTreeMap::new(),
        kept_modal: None,
        feed: None,
        feed_unit: 1.0,
        h: None,
        d: None,
        overrides: true,
        length_canceled_by: None,
        cycle: CycleValues::default(),
        pole: [0.0; 2],
        fagor: FagorCycle::default(),
        held: AxisValues::NONE,
        corners: Corners::default(),
        spline_end: None,
        nurbs: None,
        plane_parts: None,
        modal_macro: None,
        moved_in_block: false,
        last_m: 0,
        noted_vacant: std::collections::BTreeSet::new(),
        sequence: 0,
        started: false,
        noted_integers: false,
        noted_length: false,
        noted_surface_speed: false,
        noted_references: Vec::new(),
    };
    let main = |index: &Index| {
        let nothing = ProgramSection { start: Mark::START, end: 0 };
        (index.main.unwrap_or(nothing), IsoCall::new(CallKind::Main))
    };
    let variables = MacroVariables::new(flavor, &settings.variables);
    let mut channel = Channel::new(source, folder, settings, own, main, variables, Modal::new(&settings.control));
    channel.load_offset("G54");
    let total = channel.modal.frames.total(flavor);
    channel.position.set_frame(total);
    channel.position.begin_at(&settings.start_position);
    channel
}

impl Language for Iso {
    type Index = Index;
    type Level = IsoCall;
    type Block = IsoBlock;
    /// What the end of a motion needs for its corner.
    type Mark = Option<Box<CornerMark>>;
    type Variables = MacroVariables;
    type Modal = Modal;

    fn index(&self, source: &Source, _main: bool, faults: &mut Vec<Diagnostic>) -> Index {
        Index::new(source, self.flavor, faults)
    }

    fn step(channel: &mut Interpreter) -> Result<(), Box<Diagnostic>> {
        channel.step_line()
    }

    #[inline]
    fn hand_out(channel: &mut Interpreter) -> Option<Command> {
        channel.past_corners()
    }

    fn resume(channel: &mut Interpreter) -> Option<bool> {
        if !channel.own.corners.resume() {
            return None;
        }
        channel.done = channel.stack.is_empty();
        Some(true)
    }

    fn moving(channel: &mut Interpreter) {
        channel.begin_motion();
    }

    /// A `LinuxCNC` counts X, Y and Z, whatever its set-up (*Machining center*, "Feed"). On a Fanuc F is the
    /// speed along the vector of the axes, degrees as millimeters.
    fn mixed_feed(channel: &Interpreter) -> UsualFeed {
        if channel.own.flavor.is_linuxcnc() {
            UsualFeed::Rule(MixedFeed::Linear)
        } else {
            UsualFeed::Usual(MixedFeed::Vector)
        }
    }

    fn may_follow(channel: &Interpreter, fault: &Diagnostic) -> bool {
        recover::may_follow(channel, fault)
    }

    fn settle_doubt(channel: &mut Interpreter) {
        recover::settle_doubt(channel);
    }

    fn go_on(channel: &mut Interpreter, failed: &FailedBlock<Index>) -> Option<Doubt> {
        recover::go_on(channel, failed)
    }

    fn doubted(channel: &mut Interpreter, doubt: Doubt) {
        if doubt.axes != 0 {
            channel.own.held = AxisValues::NONE;
            // The next spline would take up the direction of this one.
            channel.recovery.faults.doubt.modal |= channel.own.spline_end.take().is_some();
        }
    }

    fn not_run(channel: &Interpreter) -> Vec<NotRun> {
        leftover::not_run(channel)
    }

    fn is_subprogram(channel: &Interpreter) -> bool {
        leftover::is_subprogram(&channel.main, channel.own.flavor)
    }
}

impl CornerLanguage for Iso {
    #[inline]
    fn corners(&mut self) -> &mut Corners {
        &mut self.corners
    }
}

impl LineLanguage for Iso {
    fn run_line(
        channel: &mut Interpreter,
        loaded: &Arc<Loaded>,
        line: &str,
        at: Mark,
        block: &mut IsoBlock,
    ) -> Result<(), Fault> {
        channel.run_line(loaded, line, at, block)
    }

    /// The end of the text ends the program as M30 and the subprogram as M99 do. On a Fanuc and a Haas no
    /// program runs into the next one of its file.
    fn end_of_text(channel: &mut Interpreter, loaded: &Arc<Loaded>, at: Mark) -> Result<(), Box<Diagnostic>> {
        if let Some((line, _)) = loaded.source.line(at)
            && let Some(part) = loaded.index.parts.iter().find(|p| p.lines[0] == at.line && !p.outside)
            && let Some(name) = &part.name
        {
            let (first, last) = (part.lines[0], part.lines[1].saturating_sub(1).max(part.lines[0]));
            let fault = Fault::new(
                codes::NO_END,
                Span::new(0, line.trim_end().len()),
                format!("the program before runs into the head of program {name} without an end: lines {first} to {last} would not be run"),
            )
            .help("write M30 (M99 in a subprogram) before it; where it is the number of this program, write it first");
            return Err(channel.failed(loaded, at, line, fault));
        }
        if channel.stack.len() > 1 {
            return channel.leave(Span::default()).map_err(|fault| channel.failed(loaded, at, "", fault));
        }
        channel.done = true;
        Ok(())
    }
}

impl Interpreter {
    /// A motion is made: loops that move are not idle.
    pub(crate) fn begin_motion(&mut self) {
        self.passes.moved();
        self.own.moved_in_block = true;
        self.begin();
    }

    /// Before the first motion or plane: what is in force without a word of the program.
    pub(crate) fn begin(&mut self) {
        if std::mem::replace(&mut self.own.started, true) {
            return;
        }
        if self.own.assumed {
            self.note("no word identifies the control: read as Fanuc");
        }
        if self.modal.inch.is_none() {
            self.note("the program has neither G20 nor G21: lengths are read as millimeters");
        }
        let word = self.modal.offset.clone();
        self.emit(Op::Offset(Offset::Work { word: word.clone() }));
        self.tell_frame(&word);
    }

    /// Work offset and frame have been emitted.
    pub(crate) fn has_begun(&self) -> bool {
        self.own.started
    }

    fn run_line(&mut self, loaded: &Arc<Loaded>, line: &str, at: Mark, block: &mut IsoBlock) -> Result<(), Fault> {
        self.recovery.faults.stage = Stage::Unread;
        parser::parse_line(line, self.own.flavor, block)?;
        self.recovery.faults.stage = Stage::Read;
        if block.is_empty() || block.skip.is_some_and(|level| self.is_skipped(level)) {
            return Ok(());
        }
        self.stands_at(&loaded.source.name, at, line, block.span);
        if block.skip.is_some() {
            self.run_with_slash();
        }
        if block.osp.is_some()
            && let Some(fault) = osp::refused(block, self.settings.control.osp_words)
        {
            return Err(fault);
        }
        if let Some(fault) = grbl::refused(block, &self.settings.control) {
            return Err(fault);
        }
        if let Some(number) = block.number {
            self.own.sequence = number;
        }
        for remark in block.remarks.drain(..) {
            match remark {
                Remark::Message(text) => self.emit(Op::Message(text)),
                Remark::Note(text) => {
                    let text = self.expanded(&text, block.span);
                    self.note(format!("({text})"));
                }
                Remark::Abort(text) => return Err(alarm(&text, block.span)),
                Remark::Idle(text) => self.note(text),
                Remark::Assumed(text) => self.assume(text),
            }
        }
        if let Some(statement) = block.statement.take() {
            let behind = block.behind.take();
            if !self.statement(loaded, at, statement, block, line)? {
                return Ok(());
            }
            if let Some(behind) = behind {
                self.assume("the words after WHILE .. DO in its block are run in their order, at every pass");
                if !block.words.is_empty() || !block.assignments.is_empty() {
                    self.execute(block, line)?;
                }
                self.statement(loaded, at, behind, block, line)?;
                return Ok(());
            }
            if block.words.is_empty() && block.assignments.is_empty() {
                return Ok(());
            }
        }
        self.execute(block, line)
    }

    /// `/` is the first level of a Fanuc.
    fn is_skipped(&self, level: u8) -> bool {
        let bits = self.settings.skipped_levels;
        bits >> level & 1 == 1 || level <= 1 && bits & 0b11 != 0
    }
}
