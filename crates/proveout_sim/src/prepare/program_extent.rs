//! What a program does, from one pass of its reader: tools with the room that they move in, work
//! offsets, rotary axes, positions of the machine.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use proveout_geom::{Aabb, Point, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{
    AXIS_LETTERS, Command, Dialect, Location, Motion, Offset, Op, Settings, Survey, ToolAction, ToolName,
};

use crate::prepare::{
    prepared::Prepared,
    program_trace::{SAME_DIRECTION, SAME_MM, TraceSetup, Tracer, Way, WayKind, setup},
};

/// Most descents that are kept a tool: places where it goes down in rapid.
const MAX_DESCENTS: usize = 10_000;
/// Most places with a tilted tool that are kept.
const MAX_TILTED: usize = 20_000;
/// Most motions of rotary axes alone under tool center point control that are kept.
const MAX_TURNS: usize = 10_000;
/// A motion that goes down by more than five times its way across goes into material or to it, and not along
/// it.
const STEEP: f64 = 0.2;
/// Cosine of the tilt below which a tool counts as upright: 3 degrees.
const UPRIGHT: f64 = 0.9986;
/// Turns below this are none, radian.
pub(crate) const NO_TURN: f64 = 1e-9;
/// A zero that is moved by less is not moved, mm.
const AT_ZERO_MM: f64 = 1e-9;

/// Use of one tool.
#[derive(Clone, Debug)]
pub(crate) struct ToolUse {
    pub(crate) name: ToolName,
    /// Where it is called first.
    pub(crate) at: Location,
    /// Tip in feed, workpiece frame.
    pub(crate) feed: Aabb,
    /// Tip in feed while it moves sideways to its axis. Of an upright tool the lower end of each motion
    /// counts: what it came down from may be air.
    pub(crate) sideways: Aabb,
    /// Highest sideways motion in feed that does not go down: a ramp or a helix begins in air.
    pub(crate) level: Option<f64>,
    /// Ends of rapid motions that go down along the tool axis.
    pub(crate) descents: Vec<Point>,
    /// Motions in feed.
    pub(crate) feeds: u64,
    /// A motion in feed without an active length, and where.
    pub(crate) bare: Option<Location>,
    /// A motion in feed with an active length.
    pub(crate) lengthened: bool,
    /// A motion in feed with the tool off the z axis of the workpiece.
    pub(crate) tilted: bool,
    /// Longest way in feed along an axis of the tool that stays, mm.
    pub(crate) along: f64,
    /// That axis, and lowest and highest place along it.
    span: Option<(Vector, [f64; 2])>,
    /// The first motion in feed.
    pub(crate) first_feed: Option<Location>,
    /// The first end of a rapid motion that goes down, before any motion in feed.
    pub(crate) first_descent: Option<(Location, Point)>,
}

/// A position of the machine that the program names.
#[derive(Clone, Debug)]
pub(crate) struct MachineMove {
    pub(crate) letter: char,
    /// mm or radian.
    pub(crate) value: f64,
    pub(crate) at: Location,
}

/// A place of a tool off the z axis of the workpiece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TiltedPlace {
    /// Tip, workpiece frame.
    pub(crate) tip: Point,
    pub(crate) axis: Vector,
    /// Gauge length of the tool, mm.
    pub(crate) gauge: f64,
}

/// A zero that the program sets (G10 L2, G92), base coordinates, mm.
#[derive(Clone, Debug)]
pub(crate) struct OwnZero {
    pub(crate) base: [f64; 3],
    /// The word that counts from there: `G54`, `G92`.
    pub(crate) word: String,
    pub(crate) at: Location,
}

/// A motion of rotary axes alone under tool center point control: the tip keeps its place on the part, and
/// the linear axes follow it.
#[derive(Clone, Debug)]
pub(crate) struct TurnUnderTcp {
    pub(crate) at: Location,
    /// Where the control was switched on that is still in force.
    pub(crate) on: Location,
}

/// What a program does.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reading {
    pub(crate) survey: Survey,
    pub(crate) tools: Vec<ToolUse>,
    /// Work offsets in the order in which they are called, with the place.
    pub(crate) offsets: Vec<(String, Location)>,
    /// Those of them in which a linear axis moves: a retract in machine coordinates counts from none.
    pub(crate) moved_in: BTreeSet<String>,
    /// The first motion of a linear axis in coordinates of the program before any work offset is called.
    pub(crate) before_offsets: Option<Location>,
    /// Tools that are made ready, with the first place of each.
    pub(crate) selected: Vec<(ToolName, Location)>,
    /// A tool is changed in.
    pub(crate) changes: bool,
    /// Lowest and highest positions of rotary axes, radian.
    pub(crate) rotary: BTreeMap<char, [f64; 2]>,
    /// Tool center point control or a tilted plane is used.
    pub(crate) tcp: bool,
    /// Feed with a rotary axis of the table turned, without tool center point control: where the
    /// part is then depends on its place on the table.
    pub(crate) indexed: Option<Location>,
    pub(crate) machine_moves: Vec<MachineMove>,
    /// Where the program itself puts its zero before it cuts.
    pub(crate) own_zero: Option<OwnZero>,
    /// Ends of motions with the tool off the z axis of the workpiece.
    pub(crate) tilted: Vec<TiltedPlace>,
    /// Lowest and highest position of each joint, where the program is; under tool center point control at
    /// the ends of motions.
    pub(crate) joints: BTreeMap<usize, [(f64, Location); 2]>,
    /// The same without motions of rotary axes alone under tool center point control.
    pub(crate) joints_besides: BTreeMap<usize, [f64; 2]>,
    /// Those motions.
    pub(crate) turns: Vec<TurnUnderTcp>,
}

impl Reading {
    /// Box of the tip in feed of all tools.
    pub(crate) fn feed(&self) -> Aabb {
        self.tools.iter().fold(Aabb::empty(), |all, t| all.union(&t.feed))
    }

    /// Reads a program to its end.
    pub(crate) fn of(path: &Path, settings: &Settings, machine: &Machine, setup: TraceSetup) -> Self {
        let mut tracer = Tracer::new(machine, setup);
        let mut state = Collecting {
            machine,
            found: Self::default(),
            current: None,
            offset: None,
            zero: None,
            own_zero: None,
            iso: false,
            tcp_on: None,
        };
        let survey = Survey::of_file(path, settings, &mut |command, dialect: Dialect| {
            state.iso = dialect.family() == Dialect::Iso;
            let way = tracer.step(command);
            let joints = match &way {
                Some(way) if way.joints.is_none() && !way.machine => tracer.joints_under_tip(),
                Some(way) => way.joints.filter(|_| !way.machine),
                None => None,
            };
            state.look(command, way.as_ref(), joints.as_ref(), &tracer);
            None
        });
        let mut found = state.found;
        found.tools.retain(|t| t.name != ToolName::Empty || t.feeds > 0);
        Self { survey, own_zero: state.own_zero.flatten(), ..found }
    }
}

struct Collecting<'a> {
    machine: &'a Machine,
    found: Reading,
    current: Option<usize>,
    /// The work offset in force.
    offset: Option<String>,
    /// The zero in force, where the program has set it.
    zero: Option<OwnZero>,
    /// That of the first motion in feed; empty before one.
    own_zero: Option<Option<OwnZero>>,
    /// Words are those of an ISO control.
    iso: bool,
    /// Where tool center point control was switched on that is in force.
    tcp_on: Option<Location>,
}

/// A motion that programs rotary axes, or a tool axis, and none of X, Y and Z.
fn turns_alone(motion: &Motion) -> bool {
    let told = motion.programmed >> 3 & 0b111 != 0 || motion.tool_axis_base.is_some();
    told && motion.programmed & 0b111 == 0 && !motion.machine_coordinates
}

impl Collecting<'_> {
    fn look(&mut self, command: &Command, way: Option<&Way>, joints: Option<&JointValues>, tracer: &Tracer<'_>) {
        let at = &command.location;
        match &command.op {
            Op::Tool(ToolAction::Change(name)) => {
                self.found.changes = true;
                self.change(name, at);
            }
            Op::Tool(ToolAction::Select(name)) if !self.found.selected.iter().any(|(known, _)| known == name) => {
                self.found.selected.push((name.clone(), at.clone()));
            }
            Op::Offset(Offset::Work { word }) => {
                self.offset = Some(word.clone());
                if !self.found.offsets.iter().any(|(known, _)| known == word) {
                    self.found.offsets.push((word.clone(), at.clone()));
                }
            }
            Op::Tcp(tcp) => {
                self.found.tcp |= tcp.on;
                self.tcp_on = tcp.on.then(|| self.tcp_on.take().unwrap_or_else(|| at.clone()));
            }
            Op::Frame(frame) if self.iso && (frame.word == "G92" || self.offset.as_ref() == Some(&frame.word)) => {
                // No offset is known to the reader: one away from zero has been written by the program.
                let set = frame.translation.iter().any(|v| v.abs() > AT_ZERO_MM);
                let zero = || OwnZero { base: frame.translation, word: frame.word.clone(), at: at.clone() };
                let same = |own: &OwnZero| own.word == frame.word && own.base == frame.translation;
                if !set {
                    self.zero = None;
                } else if !self.zero.as_ref().is_some_and(same) {
                    self.zero = Some(zero());
                }
            }
            Op::Rapid(motion) | Op::Linear(motion) => self.axes(motion, at),
            Op::Arc(arc) => self.axes(&arc.motion, at),
            Op::Spline(spline) => self.axes(&spline.motion, at),
            _ => {}
        }
        let Some(way) = way else { return };
        if self.current.is_none() {
            let name = tracer.tool.clone();
            self.change(&name, at);
        }
        let table_turned = way.joints.is_some_and(|q| {
            let turned =
                |&j: &usize| self.machine.joints[j].is_rotary() && (q[j] - self.machine.joints[j].home).abs() > NO_TURN;
            self.machine.work_chain.iter().any(turned)
        });
        let alone = match &command.op {
            Op::Rapid(motion) | Op::Linear(motion) => self.tcp_on.clone().filter(|_| turns_alone(motion)),
            _ => None,
        };
        if let (Some(q), None) = (joints, &alone) {
            for j in 0..self.machine.joints.len() {
                let [low, high] = self.found.joints_besides.entry(j).or_insert([q[j]; 2]);
                (*low, *high) = (low.min(q[j]), high.max(q[j]));
            }
        }
        if let Some(on) = alone.filter(|_| self.found.turns.len() < MAX_TURNS) {
            self.found.turns.push(TurnUnderTcp { at: at.clone(), on });
        }
        if let Some(q) = joints {
            for j in 0..self.machine.joints.len() {
                let [low, high] =
                    self.found.joints.entry(j).or_insert_with(|| [(q[j], at.clone()), (q[j], at.clone())]);
                if q[j] < low.0 {
                    *low = (q[j], at.clone());
                }
                if q[j] > high.0 {
                    *high = (q[j], at.clone());
                }
            }
        }
        if way.axis.z < UPRIGHT
            && !way.machine
            && self.found.tilted.len() < MAX_TILTED
            && let Some(tip) = way.points.last()
        {
            self.found.tilted.push(TiltedPlace { tip: *tip, axis: way.axis, gauge: tracer.gauge() });
        }
        let Some(tool) = self.current.and_then(|i| self.found.tools.get_mut(i)) else { return };
        match way.kind {
            WayKind::Rapid => {
                if let (true, [from, .., to]) = (!way.machine && way.from_known, &way.points[..])
                    && (from - to).dot(&way.axis) > SAME_MM
                    && tool.descents.len() < MAX_DESCENTS
                {
                    tool.descents.push(*to);
                    if tool.feeds == 0 {
                        tool.first_descent = Some((at.clone(), *to));
                    }
                }
            }
            WayKind::Feed if !way.machine => {
                tool.feeds += 1;
                self.own_zero.get_or_insert_with(|| self.zero.clone());
                if !tracer.length_on && !tracer.tcp {
                    tool.bare.get_or_insert_with(|| at.clone());
                } else {
                    tool.lengthened = true;
                }
                tool.tilted |= way.axis.z < 1.0 - SAME_DIRECTION;
                if table_turned && !tracer.tcp {
                    self.found.indexed.get_or_insert_with(|| at.clone());
                }
                way.points.iter().skip(usize::from(!way.from_known)).for_each(|p| {
                    tool.feed.grow(p);
                    let height = p.coords.dot(&way.axis);
                    let [low, high] = match tool.span {
                        Some((axis, span)) if axis.dot(&way.axis) > 1.0 - SAME_DIRECTION => span,
                        _ => [height; 2],
                    };
                    let span = [low.min(height), high.max(height)];
                    tool.span = Some((way.axis, span));
                    tool.along = tool.along.max(span[1] - span[0]);
                });
                if let [from, .., to] = &way.points[..] {
                    let along = (to - from).dot(&way.axis);
                    let across = (to - from - way.axis * along).norm();
                    if way.points.len() > 2 || across > SAME_MM.max(STEEP * -along) {
                        let upright = way.axis.z > UPRIGHT;
                        for pair in way.points.windows(2) {
                            let low = pair[0].z.min(pair[1].z);
                            let lowered = |p: &Point| if upright { Point::new(p.x, p.y, low) } else { *p };
                            pair.iter().for_each(|p| tool.sideways.grow(&lowered(p)));
                        }
                        if upright && to.z >= from.z - SAME_MM {
                            tool.level = Some(tool.level.map_or(to.z, |z| z.max(to.z)));
                        }
                    }
                }
                tool.first_feed.get_or_insert_with(|| at.clone());
            }
            WayKind::Feed => {}
        }
    }

    fn change(&mut self, name: &ToolName, at: &Location) {
        let known = self.found.tools.iter().position(|t| t.name == *name);
        self.current = Some(known.unwrap_or_else(|| {
            self.found.tools.push(ToolUse {
                name: name.clone(),
                at: at.clone(),
                feed: Aabb::empty(),
                sideways: Aabb::empty(),
                level: None,
                descents: Vec::new(),
                feeds: 0,
                bare: None,
                lengthened: false,
                tilted: false,
                along: 0.0,
                span: None,
                first_feed: None,
                first_descent: None,
            });
            self.found.tools.len() - 1
        }));
    }

    fn axes(&mut self, motion: &Motion, at: &Location) {
        for (index, letter) in AXIS_LETTERS.into_iter().enumerate() {
            if motion.programmed >> index & 1 == 0 && !motion.machine_coordinates {
                continue;
            }
            let Some(value) = motion.end_base.get(index) else { continue };
            if index < 3 && !motion.machine_coordinates {
                match &self.offset {
                    None => {
                        self.found.before_offsets.get_or_insert_with(|| at.clone());
                    }
                    Some(word) if !self.found.moved_in.contains(word) => {
                        self.found.moved_in.insert(word.clone());
                    }
                    Some(_) => {}
                }
            }
            if motion.machine_coordinates {
                self.found.machine_moves.push(MachineMove { letter, value, at: at.clone() });
            } else if (3..6).contains(&index) {
                let range = self.found.rotary.entry(letter).or_insert([value; 2]);
                *range = [range[0].min(value), range[1].max(value)];
            }
        }
    }
}

/// The tool in the spindle before the first block.
pub(crate) fn at_start(prepared: &Prepared) -> ToolName {
    prepared.scene.file.start.tool.map_or(ToolName::Empty, ToolName::Number)
}

/// The way of the tool, from one pass over the text.
pub(crate) fn reading(prepared: &Prepared) -> Reading {
    let lengths = prepared
        .tools
        .tools
        .iter()
        .flat_map(|t| [(ToolName::Number(t.number), t.gauge_length), (ToolName::Name(t.name.clone()), t.gauge_length)])
        .collect();
    let tracing = setup(&prepared.table_from_work, lengths, prepared.survey.dialect, at_start(prepared));
    Reading::of(&prepared.program_path, &prepared.nc_settings, &prepared.machine, tracing)
}

/// Box of the motion in feed, workpiece frame; empty where the program is made, or has none.
pub(crate) fn cuts_in_feed(prepared: &Prepared) -> Aabb {
    if prepared.made.is_some() { Aabb::empty() } else { reading(prepared).feed() }
}
