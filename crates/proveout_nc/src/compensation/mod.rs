//! Cutter radius compensation: from the programmed contour to the path of the tool center.
//!
//! A stage after the readers of all dialects. It works where [`Compensation::ToolCenter`] gives the radii of
//! the tools; otherwise commands pass through one by one and [`Op::CutterComp`] says what the control would
//! do.
//!
//! # Geometry
//!
//! All is computed in the working plane in base coordinates, with `u` and `v` along the axes of the
//! plane as the frame turns and mirrors them. `o` is the offset to the left of the motion: the
//! radius with G41, minus the radius with G42. For a point of the contour with the unit tangent
//! `t`, the tool center is at `point + o * left(t)`.
//!
//! ```text
//!   outside corner, tool on the left       inside corner, tool on the left
//!
//!     equidistant                                  :     |
//!   - - - - - - - p - .                            :     | contour
//!                 :     ' .  circle                :     |
//!                 : o      ' about P    - - - - - -X     |
//!                 :         '             equidistant    |
//!   --------------P         q                            |
//!       contour   |         :           -----------------P
//!                 |         :                 contour
//! ```
//!
//! * The equidistant of a line is the parallel line; of an arc, the circle about the same center with the
//!   radius `R - o` where the arc runs counter-clockwise and `R + o` where it runs clockwise. It must stay
//!   above zero.
//! * With tangents `s` before and `t` after a corner, the corner is inside where `o * (s x t) > 0`.
//!   There the equidistants, lines or circles, are intersected; of the points that lie on both, the
//!   one that shortens the first block least is taken. If there is none, the tool does not fit:
//!   `nc-compensation` names block, radius and the radius that fits.
//! * At a *cusp*, where the path turns back, the bends of both blocks decide between inside and
//!   outside ([`corner`]).
//! * At an outside corner the tool goes around as the dialect says: on a circle about `P` (G450 of Siemens,
//!   `LinuxCNC`, Heidenhain), or over the intersection of the tangents (G451 up to 100 degrees, MD20210, a
//!   circle beyond; Fanuc up to 90 degrees, beyond both tangents go on for one radius and a line joins them).
//!   At rapid rate there are no circles: the lines of Fanuc are taken, which lie outside of them.
//! * Every point of these paths is at least `|o|` away from both blocks of the corner: on the circle and at
//!   `X` exactly, on the tangents and the chamfer at least.
//! * *Near-tangent* outside corners take no piece of their own: the equidistants run on until they meet.
//!   Blocks of micrometers into which the tool does not fit are passed ([`crumb`]).
//!
//! # Check
//!
//! The whole path from G41 to G40 is checked against the whole contour ([`stretch`]): a corner
//! looks at its two blocks only, and anything else may lie in the way. A tool that does not fit
//! between blocks within the look-ahead of the control ([`CompStyle::look_ahead`]) is refused.
//! [`Op::Overcut`] reports what the control would cut without an alarm ([`overcut`]).
//!
//! # Entry, exit, and blocks between
//!
//! * *Entry*, a straight block with a motion in the plane. Perpendicular: it ends at `P + o * left(t)` of the
//!   first block of the contour (NORM of Siemens; start-up type A of Fanuc and Haas; RL/RR of Heidenhain).
//!   `LinuxCNC`: the entry block is a block of the contour that begins at the uncompensated point, and must
//!   be longer than the radius.
//! * *Exit*: the last block ends at the end of its equidistant; the next straight block with a
//!   motion in the plane leads from there to its programmed end. All four families do this with
//!   their standard settings. With KONT the same, where the exit lies on the side of the tool; an
//!   exit on the far side of the contour is refused.
//! * *Blocks without motion in the plane* are executed where the block before ends, ahead of the circle of
//!   the corner, as the manual of Siemens says of G450.
//! * *Another radius* while it is on: a straight block begins with the old one and ends with the new one.
//! * Axes outside of the plane move along with their block; pieces of corners keep them still.
//! * Feed on arcs holds at the contour with CFC (standard of Siemens), inside of it with CFIN, else at the
//!   tool center.
//!
//! # Limits
//!
//! A block's end is known when the next one with a motion in the plane is; at most [`LOOK_AHEAD`]
//! commands are allowed between. The check follows the stretch, whose motions are emitted by then.
//! It knows the plane alone, and heights only where a path lies above the block that it cuts.
//! Refused by name (`nc-compensation`): splines, probing and threads in the plane, circles outside
//! of the plane, tool axes not square to it, machine coordinates, a tool change, another plane, a
//! turned frame or tool center point control in between, inverse time feed, G41 after G42 without
//! G40.
//!
//! Sources: Siemens, *SINUMERIK 840D sl Function Manual Basic Functions* (W1, tool radius compensation 2D;
//! collision detection and bottleneck detection) and *Programming Manual Fundamentals* (G40 to G42, G450,
//! G451, CDON); Fanuc, *Series 30i User's Manual* (blocks read in offset mode, parameter 19625); HEIDENHAIN,
//! *TNC 640 User's Manual* (M120); Kramer, Proctor, Messina, *The NIST RS274NGC Interpreter*, NISTIR 6556,
//! 2000, appendix on cutter radius compensation. The rest of Fanuc and Heidenhain from general knowledge of
//! their manuals.

mod blocks;
pub(crate) mod contour;
mod corner;
mod crumb;
mod distance;
mod emit;
mod faults;
mod overcut;
mod plane;
mod recover;
mod shadow;
mod stretch;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use contour::{Element, Point};
pub(crate) use faults::line_of;
use plane::CompPlane;
pub(crate) use shadow::may_compensate;
use stretch::ContourStretch;

use shadow::Shadow;

pub(crate) use corner::{Beyond, CompStyle, ContourEntry, FeedAt, OutsideCorner};

use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::dialect::Reader;
use crate::frame::Frame;
use crate::settings::{Compensation, Dialect, Settings, ToolRadii};
use crate::{AxisValues, Command, CompSide, CutterComp, Feed, Motion, Note, Offset, Op, ToolAction, ToolName};

/// Most commands between two blocks with a motion in the plane.
pub(crate) const LOOK_AHEAD: usize = 1000;

type Fault = Box<Diagnostic>;

/// A block of the contour of which the end of the tool center is not known yet.
#[derive(Debug)]
struct PendingBlock {
    command: Command,
    element: Element,
    /// Offset to the left at its end, mm.
    offset: f64,
    /// The smaller of those at its start and its end, mm.
    least_offset: f64,
    /// Where the tool center begins it.
    from: Point,
    /// What the corner at its start has left of it, in the unit of [`Element::extent`].
    rest: f64,
    /// It leads onto the contour.
    entry: bool,
    feed: Option<Feed>,
    style: CompStyle,
    /// Least and greatest height of the tip over the plane, mm, where they are known.
    heights: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CompState {
    Off,
    /// On, and no block with a motion in the plane came yet.
    Entering,
    On,
}

/// A reader with its compensation.
#[derive(Debug)]
pub(crate) struct CompensatedReader {
    reader: Box<dyn Reader>,
    radii: Option<ToolRadii>,
    /// Without radii: looks at contours whose radius the program gives.
    shadow: Option<Box<Shadow>>,
    default_style: CompStyle,
    out: VecDeque<Result<Command, Fault>>,
    finished: bool,
    state: CompState,
    /// Offset to the left, mm, in force for the end of the next block.
    offset: f64,
    side: CompSide,
    plane: Option<CompPlane>,
    /// Tool center minus programmed point, in the plane.
    residual: Point,
    pending: Option<PendingBlock>,
    /// Contour and path since compensation was switched on.
    stretch: ContourStretch,
    /// After G40: the same, for the exit, and the position of the tool center.
    leaving: Option<(ContourStretch, Point)>,
    /// Heights of the tip over the plane in the motion under way, mm.
    heights: Option<[f64; 2]>,
    /// With KONT, after G40: end of the contour, tangent and offset there.
    exit: Option<(Point, Point, f64)>,
    /// Commands after the pending block that do not move in the plane.
    held: Vec<Command>,
    // What the commands so far say.
    frame: Frame,
    normal: usize,
    tool: ToolName,
    tcp: bool,
    feed: Option<Feed>,
    /// Programmed point in base coordinates.
    position: AxisValues,
    /// Motion emitted last, for the pieces of corners.
    last: Option<Motion>,
    /// A fault was reported, and the run goes on after it.
    broken: bool,
}

impl CompensatedReader {
    /// `compensates`: the text may switch compensation on ([`may_compensate`]).
    pub(crate) fn new(reader: Box<dyn Reader>, dialect: Dialect, compensates: bool, settings: &Settings) -> Self {
        let linuxcnc = dialect == Dialect::LinuxCnc;
        let radii = match &settings.compensation {
            Compensation::Programmed => None,
            Compensation::ToolCenter(radii) => Some(radii.clone()),
        };
        let default_style = match dialect {
            Dialect::Iso | Dialect::Fanuc | Dialect::Haas => CompStyle::FANUC,
            Dialect::LinuxCnc => CompStyle::LINUX_CNC,
            _ => CompStyle::PLAIN,
        };
        let shadow = (compensates && linuxcnc && radii.is_none()).then(|| Box::new(Shadow::new(dialect, settings)));
        Self {
            reader,
            radii,
            shadow,
            default_style,
            out: VecDeque::new(),
            finished: false,
            state: CompState::Off,
            offset: 0.0,
            side: CompSide::Off,
            plane: None,
            residual: [0.0; 2],
            pending: None,
            stretch: ContourStretch::default(),
            leaving: None,
            heights: None,
            exit: None,
            held: Vec::new(),
            frame: Frame::IDENTITY,
            normal: 2,
            tool: ToolName::Empty,
            tcp: false,
            feed: None,
            position: AxisValues::NONE,
            last: None,
            broken: false,
        }
    }

    pub(crate) fn next(&mut self) -> Option<Result<Command, Fault>> {
        if self.radii.is_none() {
            let item = self.reader.next_command();
            return match self.shadow_fault(&item) {
                Some(fault) => Some(Err(fault)),
                None => item,
            };
        }
        loop {
            if let Some(item) = self.out.pop_front() {
                return Some(item);
            }
            if self.finished {
                return None;
            }
            let result = match self.reader.next_command() {
                None if self.reader.waits_for_probe() => return None,
                None => {
                    self.finished = true;
                    self.settle(None).map(|_| ())
                }
                Some(Err(fault)) => Err(fault),
                Some(Ok(command)) => self.take(command),
            };
            if let Err(fault) = result {
                self.finished = true;
                self.out.push_back(Err(fault));
            }
        }
    }

    /// The fault of a contour whose radius the program gives. The shadow ends at the first fault,
    /// also of the reader.
    fn shadow_fault(&mut self, item: &Option<Result<Command, Fault>>) -> Option<Fault> {
        let shadow = self.shadow.as_mut()?;
        let mut fault = match item {
            Some(Ok(command)) => shadow.follow(command).err()?,
            Some(Err(_)) => {
                self.shadow = None;
                return None;
            }
            None => shadow.end().err()?,
        };
        self.shadow = None;
        if fault.source_line.is_empty()
            && let Some(line) = self.reader.source_line(&fault.file, fault.line)
        {
            fault.source_line = line.into();
        }
        Some(fault)
    }

    fn is_active(&self) -> bool {
        self.state != CompState::Off
    }

    fn take(&mut self, command: Command) -> Result<(), Fault> {
        match &command.op {
            Op::CutterComp(comp) => {
                let comp = *comp;
                return self.switch(comp, command);
            }
            Op::Rapid(_) | Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_) | Op::Thread(_) => {
                return self.motion(command);
            }
            Op::Tool(ToolAction::Change(tool)) => {
                if self.is_active() {
                    return Err(self.unfit(&command.location, "the tool is changed while cutter compensation is on"));
                }
                self.tool = tool.clone();
                self.position = AxisValues::NONE;
            }
            Op::Plane(letter) => {
                let normal = AxisValues::index(*letter).unwrap_or(2).min(2);
                if self.is_active() && normal != self.normal {
                    let message = "the working plane changes while cutter compensation is on";
                    return Err(self.unfit(&command.location, message));
                }
                self.normal = normal;
            }
            Op::Frame(change) => {
                let frame = Frame { linear: change.rotation, translation: change.translation, rotary: change.rotary };
                if self.is_active() && frame.linear != self.frame.linear {
                    let message = "the frame turns, mirrors or scales while cutter compensation is on";
                    return Err(self.unfit(&command.location, message));
                }
                self.frame = frame;
            }
            Op::Tcp(tcp) if tcp.on != self.tcp => {
                if self.is_active() {
                    let message = "tool center point control is switched while cutter compensation is on";
                    return Err(self.unfit(&command.location, message));
                }
                self.tcp = tcp.on;
                self.position = AxisValues::NONE;
            }
            Op::Offset(Offset::ToolEdge { .. }) if !self.is_active() => {
                // The tip is another point; the coordinates that this leaves known come with the next motion.
                self.position = AxisValues::NONE;
            }
            Op::Feed(feed) => self.feed = Some(*feed),
            Op::End => {
                self.settle(None)?;
                self.state = CompState::Off;
            }
            _ => {}
        }
        self.pass(command)
    }

    /// Passes a command on; while a block waits for its end, the command is held after it.
    fn pass(&mut self, command: Command) -> Result<(), Fault> {
        if self.pending.is_none() {
            self.out.push_back(Ok(command));
            return Ok(());
        }
        if self.held.len() >= LOOK_AHEAD {
            let message = format!(
                "cutter compensation finds no motion in the plane within {LOOK_AHEAD} commands after line {}",
                self.pending.as_ref().map_or(0, |p| p.command.location.line)
            );
            return Err(self.fault(codes::COMPENSATION, &command.location, message, "write G40 before this part"));
        }
        self.held.push(command);
        Ok(())
    }

    fn switch(&mut self, comp: CutterComp, command: Command) -> Result<(), Fault> {
        let location = command.location.clone();
        let note = |text: String| Command { location: location.clone(), op: Op::Note(Note::new(text)) };
        if comp.side == CompSide::Off {
            self.settle(None)?;
            self.state = CompState::Off;
            self.side = CompSide::Off;
            return self.pass(note("cutter compensation off".to_owned()));
        }
        let radius = self.radius(comp, &location)?;
        let (sign, word) = if comp.side == CompSide::Left { (1.0, "left") } else { (-1.0, "right") };
        if self.is_active() && comp.side != self.side {
            return Err(self.unfit(&location, "cutter compensation changes its side"));
        }
        self.offset = sign * radius;
        self.side = comp.side;
        if !self.is_active() {
            self.plane = Some(CompPlane::new(self.normal, &self.frame).ok_or_else(|| {
                let message = "cutter compensation under a frame that scales the axes differently";
                self.unfit(&location, message)
            })?);
            self.state = CompState::Entering;
        }
        if self.radii.as_ref().is_some_and(|radii| radii.wear) {
            return self.pass(note(format!(
                "cutter compensation {word} with the wear {radius} mm: the program gives the path of the tool center"
            )));
        }
        self.pass(note(format!(
            "cutter compensation {word} of the contour with the radius {radius} mm: base coordinates are those of the tool center"
        )))
    }
}

fn motion_of(op: &Op) -> Option<&Motion> {
    match op {
        Op::Rapid(motion) | Op::Linear(motion) => Some(motion),
        Op::Arc(arc) => Some(&arc.motion),
        Op::Spline(spline) => Some(&spline.motion),
        Op::Probe(probe) => Some(&probe.motion),
        Op::Thread(thread) => Some(&thread.motion),
        _ => None,
    }
}

fn motion_mut(op: &mut Op) -> Option<&mut Motion> {
    match op {
        Op::Rapid(motion) | Op::Linear(motion) => Some(motion),
        Op::Arc(arc) => Some(&mut arc.motion),
        Op::Spline(spline) => Some(&mut spline.motion),
        Op::Probe(probe) => Some(&mut probe.motion),
        Op::Thread(thread) => Some(&mut thread.motion),
        _ => None,
    }
}
