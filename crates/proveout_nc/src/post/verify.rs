//! A written program against the commands that it was written from: read again, it moves the same within the
//! decimals of its format.
//!
//! Both run side by side, motion by motion, so that nothing is kept. Compared are ends in base coordinates,
//! arcs, feeds, dwells, threads, the tool, the spindle and cutter compensation, as they hold at each motion.

use std::f64::consts::TAU;

use super::PostSettings;
use crate::diagnostic::Diagnostic;
use crate::{
    ArcMotion, AxisValues, Command, CompSide, Dwell, Feed, Location, Motion, Op, SpindleDirection, ToolAction, ToolName,
};

/// Sagitta below which an arc may be written as a straight line, mm.
pub(super) const FLAT_MM: f64 = 1e-5;
/// Largest difference of the components of a tool vector of six decimals.
const VECTOR: f64 = 3e-6;
/// Largest difference of a pitch, part of it.
const PITCH: f64 = 1e-3;
/// Largest difference of a dwell, s: three decimals.
const DWELL_S: f64 = 6e-4;
/// Largest difference of the components of the normal of an arc.
const NORMAL: f64 = 1e-6;
/// Least sine of half of a sweep that rounding of both ends is related to.
const LEAST_SINE: f64 = 1e-3;
/// Largest difference of a feed, part of it.
const FEED: f64 = 1e-3;
/// Largest difference of a feed for each revolution, mm, at least.
const PER_REVOLUTION: f64 = 1e-3;
/// Largest difference of the speed of a spindle, part of it.
const SPEED: f64 = 1e-3;

/// Where a written program differs from its original.
#[derive(Clone, Debug)]
pub struct Difference {
    /// What differs, with both values.
    pub what: String,
    /// Place in the original; none where it has ended.
    pub original: Option<Location>,
    /// Line of the written text.
    pub written_line: u32,
}

/// The state in force at a motion.
#[derive(Clone, Debug, Default, PartialEq)]
struct StateAtMotion {
    feed: Option<Feed>,
    tool: Option<ToolName>,
    spindle: Option<(SpindleDirection, Option<f64>)>,
    side: Option<CompSide>,
}

/// A motion, a dwell or a stop, with the state in force there.
#[derive(Clone, Debug)]
struct VerifyStep {
    op: Op,
    state: StateAtMotion,
    location: Location,
}

/// The steps of commands.
struct Steps<I> {
    commands: I,
    state: StateAtMotion,
    waiting: Option<VerifyStep>,
}

impl<I: Iterator<Item = Result<Command, Diagnostic>>> Steps<I> {
    fn new(commands: I) -> Self {
        Self { commands, state: StateAtMotion::default(), waiting: None }
    }

    fn next(&mut self) -> Result<Option<VerifyStep>, Diagnostic> {
        if let Some(step) = self.waiting.take() {
            return Ok(Some(step));
        }
        for command in self.commands.by_ref() {
            let Command { op, location } = command?;
            match op {
                Op::Feed(feed) => self.state.feed = Some(feed),
                Op::Tool(ToolAction::Change(tool)) => self.state.tool = Some(tool),
                Op::Spindle(spindle) => self.state.spindle = Some((spindle.direction, spindle.speed_rpm)),
                Op::CutterComp(comp) => self.state.side = Some(comp.side),
                // A return of all axes on a machine of which no reference point is known moves none.
                Op::Rapid(motion) if motion.machine_coordinates && motion.programmed == 0 => {}
                Op::Rapid(_)
                | Op::Linear(_)
                | Op::Arc(_)
                | Op::Spline(_)
                | Op::Probe(_)
                | Op::Thread(_)
                | Op::Retract(_)
                | Op::Dwell(_)
                | Op::Stop { .. } => return Ok(Some(VerifyStep { op, state: self.state.clone(), location })),
                _ => {}
            }
        }
        Ok(None)
    }
}

/// How near the two must be.
#[derive(Clone, Copy, Debug)]
struct VerifyLimits {
    length_mm: f64,
    angle: f64,
    feed: f64,
}

/// Compares a program with the text that was written from it. `settings`: the format of the text.
///
/// # Errors
/// The first difference; a fault of the original or of the written text is one.
pub fn verify(
    original: impl Iterator<Item = Result<Command, Diagnostic>>,
    written: impl Iterator<Item = Result<Command, Diagnostic>>,
    settings: &PostSettings,
) -> Result<(), Difference> {
    let unit = if settings.inches { 25.4 } else { 1.0 };
    let decimal = |decimals: usize| 10f64.powi(-i32::try_from(decimals).unwrap_or(9));
    // Half of the last decimal; rounding adds up in sums of two.
    let limits = VerifyLimits {
        length_mm: 1.2 * unit * decimal(settings.length_decimals),
        angle: (0.7 * decimal(settings.angle_decimals)).to_radians(),
        feed: unit * decimal(settings.feed_decimals) / 60.0,
    };
    let (mut a, mut b) = (Steps::new(original), Steps::new(written));
    let mut last_line = 1;
    loop {
        let fault = |fault: Diagnostic, original: Option<Location>| Difference {
            what: format!("the written text is refused: {} [{}]", fault.message, fault.code),
            original,
            written_line: fault.line,
        };
        let step = a.next().map_err(|e| Difference {
            what: format!("the program cannot be read: {}", e.message),
            original: None,
            written_line: last_line,
        })?;
        let other = b.next().map_err(|e| fault(e, step.as_ref().map(|step| step.location.clone())))?;
        let (step, other) = match (step, other) {
            (None, None) => return Ok(()),
            (Some(step), None) => {
                return Err(Difference {
                    what: format!("the written text ends before {}", named(&step.op)),
                    original: Some(step.location),
                    written_line: last_line,
                });
            }
            (None, Some(other)) => {
                return Err(Difference {
                    what: format!("the written text goes on with {}", named(&other.op)),
                    original: None,
                    written_line: other.location.line,
                });
            }
            (Some(step), Some(other)) => (step, other),
        };
        last_line = other.location.line;
        let mut other = other;
        if let (Op::Arc(want), Op::Arc(arc)) = (&step.op, &mut other.op) {
            // A helix of several turns comes as one block a turn where the control has no word for turns.
            while want.sweep > TAU && arc.sweep < want.sweep - 0.1 {
                match b.next().map_err(|e| fault(e, Some(step.location.clone())))? {
                    Some(VerifyStep { op: Op::Arc(next), .. }) => {
                        arc.sweep += next.sweep;
                        arc.motion = next.motion;
                    }
                    more => {
                        b.waiting = more;
                        break;
                    }
                }
            }
        }
        if let Some(what) = differs(&step, &other, limits) {
            return Err(Difference { what, original: Some(step.location), written_line: last_line });
        }
    }
}

fn named(op: &Op) -> &'static str {
    match op {
        Op::Rapid(_) => "a rapid motion",
        Op::Linear(_) => "a straight motion",
        Op::Arc(_) => "an arc",
        Op::Spline(_) => "a spline",
        Op::Probe(_) => "a probing motion",
        Op::Thread(_) => "a motion coupled to the spindle",
        Op::Retract(_) => "a retraction",
        Op::Dwell(_) => "a dwell",
        Op::Stop { .. } => "a stop",
        _ => "a word",
    }
}

fn differs(a: &VerifyStep, b: &VerifyStep, limits: VerifyLimits) -> Option<String> {
    let path = match (&a.op, &b.op) {
        (Op::Rapid(x), Op::Rapid(y)) | (Op::Linear(x), Op::Linear(y)) => motion(x, y, limits),
        (Op::Arc(x), Op::Arc(y)) => motion(&x.motion, &y.motion, limits).or_else(|| arc(x, y, limits)),
        // An arc that is shorter than the last decimal, or as flat as a line.
        (Op::Arc(x), Op::Linear(y)) if x.sweep < TAU / 2.0 && is_flat(x, limits) => motion(&x.motion, y, limits),
        (Op::Probe(x), Op::Probe(y)) => motion(&x.motion, &y.motion, limits),
        (Op::Spline(x), Op::Spline(y)) => motion(&x.motion, &y.motion, limits),
        (Op::Thread(x), Op::Thread(y)) => motion(&x.motion, &y.motion, limits).or_else(|| {
            (near(x.pitch, y.pitch, PITCH * x.pitch) && x.direction == y.direction).then_some(()).map_or_else(
                || Some(format!("the pitch is {} mm and comes back as {} mm", x.pitch, y.pitch)),
                |()| None,
            )
        }),
        (Op::Dwell(Dwell::Seconds(x)), Op::Dwell(Dwell::Seconds(y))) => {
            (!near(*x, *y, DWELL_S)).then(|| format!("the dwell is {x} s and comes back as {y} s"))
        }
        (Op::Dwell(x), Op::Dwell(y)) => (x != y).then(|| "the dwell comes back in another unit".to_owned()),
        (Op::Stop { optional: x }, Op::Stop { optional: y }) => {
            (x != y).then(|| "M0 and M1 come back as each other".to_owned())
        }
        (Op::Retract(x), Op::Retract(y)) => (x != y).then(|| "the retraction comes back as another".to_owned()),
        (x, y) => Some(format!("{} comes back as {}", named(x), named(y))),
    };
    path.or_else(|| state(a, b, limits))
}

fn is_flat(arc: &ArcMotion, limits: VerifyLimits) -> bool {
    let half = 0.5 * arc.sweep;
    arc.radius * (1.0 - half.cos()) < FLAT_MM || arc.radius * arc.sweep < 2.0 * limits.length_mm
}

fn near(a: f64, b: f64, limit: f64) -> bool {
    (a - b).abs() <= limit
}

fn point(values: &AxisValues) -> String {
    let word = |(letter, value): (char, f64)| {
        let rotary = matches!(letter, 'A' | 'B' | 'C');
        format!("{letter}{:.4}", if rotary { value.to_degrees() } else { value } + 0.0)
    };
    values.iter().map(word).collect::<Vec<_>>().join(" ")
}

fn motion(a: &Motion, b: &Motion, limits: VerifyLimits) -> Option<String> {
    if a.machine_coordinates != b.machine_coordinates {
        return Some("machine coordinates come back as those of the workpiece, or the other way round".to_owned());
    }
    // Axes that one of the two knows and the other does not are compared where they are programmed.
    let apart = (0..9).any(|axis| {
        let limit = if (3..6).contains(&axis) { limits.angle } else { limits.length_mm };
        a.end_base.get(axis).zip(b.end_base.get(axis)).is_some_and(|(a, b)| !near(a, b, limit))
    });
    let lost = (0..3)
        .any(|axis| a.programmed >> axis & 1 == 1 && a.end_base.get(axis).is_some() != b.end_base.get(axis).is_some());
    // Where neither knows the base, as in a turned frame before all axes are known, the words themselves are
    // compared.
    let words_apart = (0..3).any(|axis| {
        let unknown = a.end_base.get(axis).is_none() && b.end_base.get(axis).is_none();
        let words = a.end.get(axis).zip(b.end.get(axis));
        a.programmed >> axis & 1 == 1 && unknown && words.is_some_and(|(a, b)| !near(a, b, limits.length_mm))
    });
    if words_apart {
        return Some(format!("the motion ends at {} and comes back to {}", point(&a.end), point(&b.end)));
    }
    let turned = a
        .tool_axis_base
        .zip(b.tool_axis_base)
        .is_some_and(|(a, b)| (0..3).any(|i| !near(a[i], b[i], VECTOR.max(limits.angle))));
    if apart || lost {
        return Some(format!("the motion ends at {} and comes back to {}", point(&a.end_base), point(&b.end_base)));
    }
    turned.then(|| "the tool axis comes back in another direction".to_owned())
}

fn arc(a: &ArcMotion, b: &ArcMotion, limits: VerifyLimits) -> Option<String> {
    let about = (0..3).all(|i| near(a.normal_base[i], b.normal_base[i], NORMAL));
    // Rounding of both ends moves the center of a short arc by the inverse of its half chord; said by its
    // radius, the center of an arc near a half turn by the inverse of its height over the chord.
    let (s, c) = (0.5 * a.sweep.min(TAU)).sin_cos();
    let lever = (1.0 / s.abs().max(LEAST_SINE)).max(1.0 / c.abs().max(0.17));
    let radius = near(a.radius, b.radius, 4.0 * limits.length_mm * lever) || is_flat(a, limits);
    let sweep = near(a.sweep, b.sweep, 8.0 * limits.length_mm * lever / a.radius);
    if about && radius && sweep {
        return None;
    }
    Some(format!(
        "the arc of radius {:.4} mm through {:.3} degrees comes back with {:.4} mm and {:.3} degrees",
        a.radius,
        a.sweep.to_degrees(),
        b.radius,
        b.sweep.to_degrees()
    ))
}

fn state(a: &VerifyStep, b: &VerifyStep, limits: VerifyLimits) -> Option<String> {
    let cuts = matches!(a.op, Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Thread(_));
    let (x, y) = (&a.state, &b.state);
    if matches!(a.op, Op::Linear(_) | Op::Arc(_) | Op::Spline(_)) {
        let same = match (x.feed, y.feed) {
            (Some(Feed::PerTime(a)), Some(Feed::PerTime(b))) => near(a, b, FEED * a + limits.feed.max(0.002)),
            (Some(Feed::PerRevolution(a)), Some(Feed::PerRevolution(b))) => near(a, b, PER_REVOLUTION.max(limits.feed)),
            (Some(Feed::InverseTime(a)), Some(Feed::InverseTime(b))) => near(a, b, FEED * a),
            (a, b) => a.is_some() == b.is_some() && a.is_none(),
        };
        if !same {
            return Some(format!("the feed {} comes back as {}", feed(x.feed), feed(y.feed)));
        }
    }
    if let (Some(want), Some(found)) = (&x.tool, &y.tool)
        && want != found
    {
        return Some(format!("the tool {} comes back as {}", tool(want), tool(found)));
    }
    let turning = |state: &StateAtMotion| state.spindle.filter(|(direction, _)| *direction != SpindleDirection::Off);
    match (turning(x), turning(y)) {
        (Some((direction, speed)), Some((other, found))) if cuts => {
            let same = speed.zip(found).is_none_or(|(a, b)| near(a, b, SPEED * a + 0.5));
            if direction != other || !same {
                return Some("the spindle comes back with another direction or speed".to_owned());
            }
        }
        (Some(_), None) if cuts => return Some("the spindle that turns comes back at rest".to_owned()),
        (None, Some(_)) if cuts => return Some("the spindle at rest comes back turning".to_owned()),
        _ => {}
    }
    let side = |state: &StateAtMotion| state.side.unwrap_or(CompSide::Off);
    (side(x) != side(y)).then(|| "cutter compensation comes back on another side".to_owned())
}

fn feed(feed: Option<Feed>) -> String {
    match feed {
        None => "of nothing".to_owned(),
        Some(Feed::PerTime(value)) => format!("{} mm/min", value * 60.0),
        Some(Feed::PerRevolution(value)) => format!("{value} mm a revolution"),
        Some(Feed::InverseTime(value)) => format!("of {value} s a block"),
    }
}

fn tool(name: &ToolName) -> String {
    match name {
        ToolName::Empty => "T0".to_owned(),
        ToolName::Number(number) => format!("T{number}"),
        ToolName::Name(name) => format!("{name:?}"),
    }
}
