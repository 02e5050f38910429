//! What a tool sweeps through the stock: its bodies along each piece of motion, and the state of the spindle
//! then.

use proveout_controller::{Chunk, Event, MoveKind, Piece};
use proveout_nc::SpindleDirection;
use proveout_stock::{Action, Measure, SweepItem, SweepMotion, SweepReport};
use proveout_tool::{Profile, Role, Tool};

use crate::{
    checks::descent,
    verdict::{
        finding::{Code, RAPID_IN_MATERIAL, SPINDLE_OFF, SPINDLE_WRONG_WAY},
        log::Joined,
    },
};

/// Spindle and tool while a piece is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CuttingState {
    /// Index of the tool in the library.
    pub(crate) tool: Option<usize>,
    /// Rotation.
    pub(crate) spindle: SpindleDirection,
    /// Speed, 1/min; zero when off.
    pub(crate) speed_rpm: f64,
}

/// What is swept: a body of a tool, or another shape derived from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Swept {
    /// A body of the tool.
    Body(Role),
    /// A part of the holder, widened by the wanted clearance.
    Zone,
    /// The core round the axis of a tool that does not cut there, before its cutter comes.
    Core,
    /// The cutter in its pose when its tool has come into the spindle.
    Entry,
}

/// What one sweep represents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SweepPart {
    /// Index of the piece within the batch.
    pub(crate) piece: usize,
    /// What is swept.
    pub(crate) what: Swept,
}

/// The sweeps of a batch, and what each represents.
#[derive(Debug, Default)]
pub(crate) struct Sweeps<'a> {
    pub(crate) items: Vec<SweepItem<'a>>,
    pub(crate) measures: Vec<Measure>,
    pub(crate) parts: Vec<SweepPart>,
}

/// What a piece of motion asks of the stock, before the bodies of its tool are put in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PieceCut {
    /// Number of the piece in the run.
    pub(crate) id: u32,
    /// Its tool in the library.
    pub(crate) tool: usize,
    /// First piece of the run of motion in which the cutter must not meet material, where this is one of it.
    pub(crate) since: Option<u32>,
    /// First piece of the run whose findings on one part of the tool are one.
    pub(crate) joined: u32,
    /// In feed, and down along the axis.
    pub(crate) goes_down: bool,
    /// The first with this tool since it came into the spindle.
    pub(crate) entered: bool,
    /// In the frame of the stock.
    pub(crate) motion: SweepMotion,
}

/// Follows in which run of pieces the cutter must not meet material.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Barring {
    /// The first of it, the tool, and why.
    run: Option<(u32, usize, &'static str)>,
    /// Tool of the piece before.
    tool: Option<usize>,
    /// First piece of the run of findings that are joined, and the piece before.
    joined: Option<(u32, Joined)>,
}

impl Barring {
    /// What the next piece asks of the stock; nothing without a tool.
    pub(crate) fn cut(
        &mut self,
        id: u32,
        piece: &Piece,
        state: &CuttingState,
        tools: &[Tool],
        motion: SweepMotion,
    ) -> Option<PieceCut> {
        let Some((index, tool)) = state.tool.and_then(|t| Some((t, tools.get(t)?))) else {
            *self = Self::default();
            return None;
        };
        let entered = self.tool.replace(index) != Some(index);
        self.run = fault(piece.kind, state, tool).map(|code| match self.run {
            Some((since, of, why)) if (of, why) == (index, code.code) => (since, of, why),
            _ => (id, index, code.code),
        });
        let now = Joined { block: piece.block, time: piece.time[0] };
        let joined = self.joined.filter(|(_, last)| !entered && now.goes_on(*last)).map_or(id, |(first, _)| first);
        self.joined = Some((joined, now));
        let goes_down = piece.kind == MoveKind::Feed && descent::way_down(&piece.pose).0 > 0.0;
        Some(PieceCut { id, tool: index, since: self.run.map(|(since, ..)| since), joined, goes_down, entered, motion })
    }
}

/// The bodies of a tool that are swept.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ToolBodies {
    /// Round the axis of a tool that is watched for going down, before its cutter comes.
    pub(crate) core: Vec<Profile>,
    /// Those that cut.
    pub(crate) cutting: Vec<(Role, Profile)>,
    /// Those that must not touch anything.
    pub(crate) others: Vec<(Role, Profile)>,
    /// Parts of the holder, widened by the wanted clearance.
    pub(crate) zones: Vec<Profile>,
}

/// The bodies of all tools that are swept.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Cutters(pub(crate) Vec<ToolBodies>);

impl Cutters {
    pub(crate) fn new(tools: &[Tool], zones: &[Vec<Profile>], cell_mm: f64) -> Self {
        let of = |(k, tool): (usize, &Tool)| ToolBodies {
            core: descent::core(tool, cell_mm).into_iter().collect(),
            cutting: tool.cutting().map(|b| (b.role, b.profile.clone())).collect(),
            others: tool.not_cutting().map(|b| (b.role, b.profile.clone())).collect(),
            zones: zones.get(k).cloned().unwrap_or_default(),
        };
        Self(tools.iter().enumerate().map(of).collect())
    }

    /// The core of a tool that is watched for going down.
    pub(crate) fn core(&self, tool: usize) -> Option<&Profile> {
        self.0.get(tool).and_then(|t| t.core.first())
    }

    /// Adds the sweeps of a piece, whose place in the batch is `index`: the cutter removes, the rest is
    /// probed against what the cutter has left.
    ///
    /// A cutter removes material at rapid rate too, so that one crash is one finding and does not
    /// spoil what follows; the finding says that it was a rapid.
    pub(crate) fn add<'s>(&'s self, sweeps: &mut Sweeps<'s>, index: usize, cut: &PieceCut) {
        let Some(tool) = self.0.get(cut.tool) else { return };
        let mut put = |body: &'s Profile, action: Action, measure: Measure, what: Swept| {
            let from = cut.motion.from;
            let motion = if what == Swept::Entry { SweepMotion { from, to: from } } else { cut.motion };
            sweeps.items.push(SweepItem { id: cut.id, body, action, motion });
            sweeps.measures.push(measure);
            sweeps.parts.push(SweepPart { piece: index, what });
        };
        for (_, body) in tool.cutting.iter().filter(|_| cut.entered) {
            put(body, Action::Probe, Measure::Alone, Swept::Entry);
        }
        for body in tool.core.iter().filter(|_| cut.goes_down) {
            put(body, Action::Probe, Measure::No, Swept::Core);
        }
        let depth = cut.since.map_or(Measure::No, Measure::Since);
        for (role, body) in &tool.cutting {
            put(body, Action::Remove, depth, Swept::Body(*role));
        }
        for (role, body) in &tool.others {
            put(body, Action::Probe, Measure::Deepest(cut.joined), Swept::Body(*role));
        }
        for zone in &tool.zones {
            put(zone, Action::Probe, Measure::Touch, Swept::Zone);
        }
    }
}

impl CuttingState {
    /// Without a tool, the spindle at rest.
    pub(crate) const IDLE: Self = Self { tool: None, spindle: SpindleDirection::Off, speed_rpm: 0.0 };

    /// What an event makes of it.
    pub(crate) fn apply(&mut self, event: &Event) {
        match *event {
            // The spindle stops for the change and needs a new M3 or M4 after it.
            Event::ToolChange { tool, .. } => *self = Self { tool, ..Self::IDLE },
            Event::Spindle { direction, speed_rpm, .. } => {
                (self.spindle, self.speed_rpm) = (direction, speed_rpm);
            }
            _ => {}
        }
    }
}

/// Whether an event comes before a piece of motion: those of earlier blocks, and of its own what
/// the control does before it moves. A tool change has a block of its own, in which drives may
/// still settle with the tool before: there its time decides.
fn comes_before(event: &Event, piece: &Piece) -> bool {
    match event {
        Event::ToolChange { time, block, .. } if *block == piece.block => *time <= piece.time[0],
        _ => event.block() <= piece.block,
    }
}

/// Tool and spindle at each piece; events of earlier blocks come first. `apply` is called for every
/// event.
pub(crate) fn states_of_pieces(
    chunk: &Chunk,
    state: &mut CuttingState,
    mut apply: impl FnMut(&Event),
) -> Vec<CuttingState> {
    let mut states = Vec::with_capacity(chunk.pieces.len());
    let mut events = chunk.events.iter().peekable();
    let mut take = |event: &Event, state: &mut CuttingState| {
        apply(event);
        state.apply(event);
    };
    for piece in &chunk.pieces {
        while let Some(event) = events.next_if(|e| comes_before(e, piece)) {
            take(event, state);
        }
        states.push(*state);
    }
    events.for_each(|e| take(e, state));
    states
}

/// Why the cutter must not meet material in this motion; none in feed with the spindle turning its way.
pub(crate) fn fault(kind: MoveKind, state: &CuttingState, tool: &Tool) -> Option<Code> {
    match state.spindle {
        _ if kind != MoveKind::Feed => Some(RAPID_IN_MATERIAL),
        SpindleDirection::Off => Some(SPINDLE_OFF),
        // M3 without S, or S0: it is commanded to turn and does not.
        _ if state.speed_rpm <= 0.0 => Some(SPINDLE_OFF),
        SpindleDirection::Clockwise if tool.left_handed => Some(SPINDLE_WRONG_WAY),
        SpindleDirection::CounterClockwise if !tool.left_handed => Some(SPINDLE_WRONG_WAY),
        _ => None,
    }
}

/// The part of the tool that a sweep belongs to.
pub(crate) fn part_of_tool(what: Swept) -> &'static str {
    match what {
        Swept::Body(Role::Cutting) | Swept::Entry => "cutter",
        Swept::Core => "core",
        Swept::Body(Role::Neck) => "neck",
        Swept::Body(Role::Shank) => "shank",
        Swept::Body(Role::Holder) | Swept::Zone => "holder",
    }
}

/// The role of that part; none for the core, which is no body of the tool.
pub(crate) fn role_of(what: Swept) -> Option<Role> {
    match what {
        Swept::Body(role) => Some(role),
        Swept::Entry => Some(Role::Cutting),
        Swept::Zone => Some(Role::Holder),
        Swept::Core => None,
    }
}

/// How deep a sweep was in material, mm: measured where it is, else the longest overlap.
pub(crate) fn depth(report: &SweepReport) -> f64 {
    report.depth_mm.unwrap_or(report.overlap_mm)
}
