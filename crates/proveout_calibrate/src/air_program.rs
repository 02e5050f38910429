//! The moves of an air program: each joint alone, from rest to rest, so that a trace of them determines its
//! limits, its drive and its friction.
//!
//! A joint goes from one end of its range by six lengths there and back at rapid rate, which shows velocity,
//! acceleration and jerk apart, and by eight feeds there and back, which show friction over speed. All others
//! wait at home. Positions are machine coordinates.

use proveout_machine::{Joint, Machine};

/// Lengths of the rapids as parts of the range.
const LENGTHS: [f64; 6] = [1.0, 0.4, 0.15, 0.05, 0.015, 0.004];
/// Shortest move, mm and degrees.
const SHORTEST: f64 = 0.5;
/// Feeds as parts of the velocity of rapids.
const FEEDS: [f64; 8] = [0.02, 0.04, 0.08, 0.15, 0.25, 0.4, 0.6, 0.8];
/// Time that a move in feed aims at, s.
const FEED_TIME_S: f64 = 0.8;
/// Time at rest between two moves, s: longer than a position loop takes to settle.
pub(crate) const REST_S: f64 = 0.4;
/// Distance kept from the ends of the travel: part of it, and at least so much in mm or degrees.
const END_PART: f64 = 0.02;
const END_LEAST: f64 = 2.0;
/// Longest turn of a joint without ends, degrees: below half a turn every control goes the same way.
const LONGEST_TURN_DEG: f64 = 170.0;
/// Digits of a position, mm and degrees.
const DIGITS: f64 = 1e3;

/// One block of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirStep {
    /// Joint that moves.
    pub joint: usize,
    /// Where to, mm or degrees.
    pub to: f64,
    /// Feed, mm/min or degrees/min; none at rapid rate.
    pub feed: Option<f64>,
}

/// Why there is no air program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanError {
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl PlanError {
    pub(crate) fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into() }
    }
}

/// The moves, and what is left out of them.
#[derive(Clone, Debug, PartialEq)]
pub struct AirProgram {
    /// Order in which joints go home before the first move: that of the tool first.
    pub order: Vec<usize>,
    /// Moves.
    pub steps: Vec<AirStep>,
    /// What is left out, with the reason.
    pub notes: Vec<String>,
}

/// A position with three decimals.
fn digits(v: f64) -> f64 {
    (v * DIGITS).round() / DIGITS
}

impl AirProgram {
    /// Plans the moves. `ranges` are positions (mm, degrees, machine coordinates) that a joint may use; the
    /// joint along the spindle must have one, since nothing else says how far down is safe.
    ///
    /// # Errors
    /// [`PlanError`]: a range outside of the travel, without home in it, or not given for the joint along the
    /// spindle; a joint without velocity.
    pub fn new(machine: &Machine, ranges: &[(String, [f64; 2])]) -> Result<Self, PlanError> {
        for (k, (name, _)) in ranges.iter().enumerate() {
            if machine.joint(name).is_none() {
                let names: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
                let message = format!("{} has no joint {name:?}", machine.name);
                return Err(PlanError::new(message, format!("joints: {}", names.join(", "))));
            }
            if ranges.iter().take(k).any(|(n, _)| n == name) {
                return Err(PlanError::new(format!("joint {name} has two ranges"), "give one"));
            }
        }
        let spindle = machine.spindle.gauge_pose.vector(&nalgebra::Vector3::z());
        let platform = |j: usize| machine.platforms.iter().any(|p| p.heave == j || p.tilt == j);
        let mut notes = Vec::new();
        let mut moved = Vec::new();
        for (index, joint) in machine.joints.iter().enumerate() {
            if joint.held {
                notes.push(format!("{} is held by the setup and does not move", joint.name));
            } else if platform(index) {
                notes.push(format!("{} is moved by the legs of a platform and is left out", joint.name));
            } else if joint.name.chars().count() != 1 {
                notes.push(format!("{} has no letter that a program addresses", joint.name));
            } else {
                moved.push((index, joint));
            }
        }
        let along = |joint: &Joint| !joint.is_rotary() && joint.direction.dot(&spindle).abs() > 0.99;
        let mut order: Vec<usize> = moved.iter().filter(|(_, j)| along(j)).map(|(i, _)| *i).collect();
        order.extend(moved.iter().filter(|(_, j)| !along(j)).map(|(i, _)| *i));
        let mut steps = Vec::new();
        for &index in &order {
            let Some(joint) = machine.joints.get(index) else { continue };
            let given = ranges.iter().find(|(name, _)| *name == joint.name).map(|(_, r)| *r);
            if given.is_none() && along(joint) {
                let message = format!("nothing says how far {} may go: it moves along the spindle", joint.name);
                let help = format!("give the range that is clear of table and part: --range {}=LOW..HIGH", joint.name);
                return Err(PlanError::new(message, help));
            }
            let [low, high] = range(joint, given)?;
            let home = digits(joint.kind.in_unit(joint.home));
            let Some(rapid) = joint.rapid_velocity.or(joint.max_velocity) else {
                let message = format!("the machine file states no velocity of {}", joint.name);
                return Err(PlanError::new(message, "state rapid_velocity of the joint, a rough value is enough"));
            };
            let rapid = rapid * joint.kind.unit_factor();
            let span = high - low;
            if span < 2.0 * SHORTEST {
                let message = format!("the range of {}, {low} to {high}, is too short for six lengths", joint.name);
                return Err(PlanError::new(message, format!("give at least {} {}", 2.0 * SHORTEST, joint.kind.unit())));
            }
            // From the end that is nearer to home.
            let (from, sign) = if (home - low).abs() <= (high - home).abs() { (low, 1.0) } else { (high, -1.0) };
            let mut go = |to: f64, feed: Option<f64>| steps.push(AirStep { joint: index, to: digits(to), feed });
            if (home - from).abs() > 1.0 / DIGITS {
                go(from, None);
            }
            for part in LENGTHS {
                let length = (part * span).max(SHORTEST);
                go(from + sign * length, None);
                go(from, None);
            }
            for part in FEEDS {
                let speed = part * rapid;
                let length = (FEED_TIME_S * speed).clamp(SHORTEST, span);
                let feed = (60.0 * speed * 10.0).round() / 10.0;
                go(from + sign * length, Some(feed));
                go(from, Some(feed));
            }
            if (home - from).abs() > 1.0 / DIGITS {
                go(home, None);
            }
        }
        if steps.is_empty() {
            return Err(PlanError::new("no joint can be moved by a program", "name another machine"));
        }
        Ok(Self { order, steps, notes })
    }
}

/// The range that a joint uses, mm or degrees.
fn range(joint: &Joint, given: Option<[f64; 2]>) -> Result<[f64; 2], PlanError> {
    let unit = joint.kind.unit();
    let home = joint.kind.in_unit(joint.home);
    let travel = joint.travel.map(|t| t.map(|q| joint.kind.in_unit(q)));
    let [low, high] = match (given, travel) {
        (Some([low, high]), _) if !(low < high && low.is_finite() && high.is_finite()) => {
            let message = format!("the range of {}, {low} to {high}, is upside down", joint.name);
            return Err(PlanError::new(message, "write the lower end first: LOW..HIGH"));
        }
        (Some([low, high]), Some([least, most])) if low < least || high > most => {
            let message = format!(
                "the range of {}, {low} to {high} {unit}, leaves its travel, {least} to {most} {unit}",
                joint.name
            );
            return Err(PlanError::new(message, "give positions within the travel, in machine coordinates"));
        }
        (Some(range), _) => range,
        (None, Some([least, most])) => {
            let end = (END_PART * (most - least)).max(END_LEAST).min(0.25 * (most - least));
            // Home may be at the very end: the joint begins there all the same.
            [(least + end).min(home), (most - end).max(home)]
        }
        (None, None) if joint.is_rotary() => [home, home + LONGEST_TURN_DEG],
        (None, None) => {
            let message = format!("the machine file states no travel of {}", joint.name);
            return Err(PlanError::new(message, format!("give its range: --range {}=LOW..HIGH", joint.name)));
        }
    };
    let [low, high] = [digits(low), digits(high)];
    if home < low - 1.0 / DIGITS || home > high + 1.0 / DIGITS {
        let message = format!("home of {}, {home} {unit}, is outside of its range, {low} to {high} {unit}", joint.name);
        return Err(PlanError::new(message, "the other joints move while it is at home: give a range that holds it"));
    }
    if joint.endless && high - low > LONGEST_TURN_DEG {
        let message =
            format!("{} turns without end: over {LONGEST_TURN_DEG} degrees controls go different ways", joint.name);
        return Err(PlanError::new(message, format!("give a range of at most {LONGEST_TURN_DEG} degrees")));
    }
    Ok([low, high])
}
