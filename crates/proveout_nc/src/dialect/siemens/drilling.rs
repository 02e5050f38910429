//! Drilling cycles and hole patterns, expanded to motions.
//!
//! Courses after the programming manual (Siemens, *NC programming, cycles*: CYCLE81, CYCLE82,
//! CYCLE83, HOLES1, HOLES2; the others in [`super::tapping`] and [`super::boring`]). All lengths
//! run along the normal of the working plane; the drilling direction is from the retraction plane
//! to the final depth.

use std::sync::Arc;

use super::eval::Val;
use super::frames::number;
use super::interpreter::{Interpreter, Siemens};
use super::parser::Call;
use super::slots::surplus;
use crate::channel::milling::SAME_HEIGHT_MM;
use crate::channel::{Holes, Stroke};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{AxisValues, Dwell, Feed, Motion};

/// Clearance before the last depth when CYCLE83 returns into the hole, chosen by the cycle: 0.6 mm
/// up to 30 mm depth, then depth/50, at most 7 mm.
fn anticipation(depth: f64) -> f64 {
    if depth <= 30.0 { 0.6 } else { (depth / 50.0).min(7.0) }
}

/// Retraction of chip breaking where none is given, mm.
const CHIP_BREAK_RETRACTION: f64 = 1.0;
/// Cycles that make one hole.
const DRILLING: [&str; 10] =
    ["CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE840", "CYCLE85", "CYCLE86", "CYCLE87", "CYCLE88", "CYCLE89"];
/// Most infeeds of one hole.
pub(super) const MAX_INFEEDS: usize = 10_000;

/// The planes that all drilling cycles share, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planes {
    pub(crate) retraction: f64,
    /// Reference plane moved by the safety distance.
    pub(crate) start: f64,
    pub(crate) reference: f64,
    pub(crate) depth: f64,
}

impl Planes {
    /// Down to where the feed begins.
    pub(crate) fn approach(self) -> Stroke {
        Stroke::Rapid(self.start)
    }

    /// To the bottom.
    pub(crate) fn down(self) -> Stroke {
        Stroke::Feed(self.depth)
    }

    /// To the retraction plane.
    pub(crate) fn out(self) -> Stroke {
        Stroke::Rapid(self.retraction)
    }
}

/// Dwell of a cycle: seconds above zero, revolutions below.
pub(crate) fn wait(dwell: Option<f64>) -> Stroke {
    Stroke::Wait(match dwell {
        Some(seconds) if seconds > 0.0 => Some(Dwell::Seconds(seconds)),
        Some(revolutions) if revolutions < 0.0 => Some(Dwell::Revolutions(-revolutions)),
        _ => None,
    })
}

impl Holes for Siemens {
    fn stands_at(channel: &Interpreter, to: f64) -> bool {
        channel.position.work.get(channel.modal.normal) == Some(to)
    }

    fn stroke(channel: &mut Interpreter, to: f64, rapid: bool, span: Span) -> Result<(), Fault> {
        channel.straight(channel.on_axis(to), 1 << channel.modal.normal, rapid, span)
    }

    fn thread_stroke(channel: &mut Interpreter, to: f64, span: Span) -> Result<Motion, Fault> {
        let motion = channel.cycle_motion(channel.on_axis(to), 1 << channel.modal.normal, span)?;
        channel.own.tangent = None;
        Ok(motion)
    }
}

impl Interpreter {
    /// Runs a cycle of the control; false when there is none of this name.
    pub(crate) fn run_cycle(&mut self, call: &Call, span: Span) -> Result<bool, Fault> {
        match call.name.as_str() {
            "CYCLE832" => self.cycle832(call, span)?,
            "CYCLE800" => self.cycle800(call, span)?,
            name if DRILLING.contains(&name) => {
                let mut values = self.arguments(call, span)?;
                self.take_modes(name, &mut values, span)?;
                let planes = self.planes(name, &values, span)?;
                if !matches!(name, "CYCLE84" | "CYCLE840") {
                    self.need_feed(span)?;
                }
                match name {
                    "CYCLE83" => self.deep_hole(planes, &values, span)?,
                    "CYCLE84" => self.rigid_tapping(planes, &values, span)?,
                    "CYCLE840" => self.floating_tapping(planes, &values, span)?,
                    "CYCLE85" => self.reaming(planes, &values, span)?,
                    "CYCLE86" => self.boring_with_lift(planes, &values, span)?,
                    "CYCLE87" | "CYCLE88" => self.boring_with_stop(name, planes, &values, span)?,
                    "CYCLE89" => self.boring_in_and_out(planes, &values, span)?,
                    name => {
                        let dwell =
                            if name == "CYCLE82" || values.len() > 8 { number(&values, 5, name, span)? } else { None };
                        let dwell = in_revolutions(dwell, number(&values, 8, name, span)?);
                        self.course(&[planes.approach(), planes.down(), wait(dwell), planes.out()], span)?;
                    }
                }
            }
            "CYCLE62" => self.contour_call(call, span)?,
            "CYCLE72" => self.path_milling(call, span)?,
            name if super::milling::MILLING.contains(&name) => self.mill_cycle(call, span)?,
            "HOLES1" => self.row_of_holes(call, span)?,
            "HOLES2" => self.circle_of_holes(call, span)?,
            "CYCLE801" => self.grid_of_holes(call, span)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// GMODE, DMODE and AMODE at the end of the argument list (Operate): another reference of the depth or another plane is
    /// refused; AMODE says which depth counts (1 relative, 2 absolute) and that the dwell is in revolutions (tens 2).
    fn take_modes(&self, name: &str, values: &mut [Option<Val>], span: Span) -> Result<(), Fault> {
        let at = match name {
            "CYCLE81" => 5,
            "CYCLE82" => 6,
            "CYCLE83" => 17,
            "CYCLE84" => 21,
            "CYCLE85" => 8,
            "CYCLE86" => 11,
            _ => return Ok(()),
        };
        let value = |at: usize| number(values, at, name, span).map(|v| v.unwrap_or(0.0));
        // Operate also writes a call of CYCLE81 with a dwell before the modes.
        let at = if name == "CYCLE81" && values.len() > 8 { 6 } else { at };
        let (geometry, plane, alternative) = (value(at)?, value(at + 1)?, value(at + 2)?);
        if geometry != 0.0 {
            let message = format!("`{name}` with GMODE {geometry} (another reference of the depth) is not supported");
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help("give the depth of the tip, GMODE 0"));
        }
        let digit = |number: f64, unit: f64| (number / unit).floor().rem_euclid(10.0);
        if !matches!(digit(plane, 1.0), 0.0) && digit(plane, 1.0) != (3 - self.modal.normal) as f64 {
            let message = format!("`{name}` in another plane than the active one (DMODE {plane}) is not supported");
            return Err(
                Fault::new(codes::UNSUPPORTED_WORD, span, message).help("choose the plane with G17, G18 or G19")
            );
        }
        let depth = digit(alternative, 1.0);
        let (absolute, relative) = (values.get(3).cloned().flatten(), values.get(4).cloned().flatten());
        match (depth, values) {
            (1.0, [_, _, _, slot, ..]) if relative.is_some() => *slot = None,
            (2.0, [_, _, _, _, slot, ..]) if absolute.is_some() => *slot = None,
            _ => {}
        }
        Ok(())
    }

    fn planes(&self, name: &str, values: &[Option<Val>], span: Span) -> Result<Planes, Fault> {
        let length = self.modal.units.length();
        let need = |at: usize, what: &str| {
            number(values, at, name, span)?.map(|v| v * length).ok_or_else(|| {
                Fault::new(codes::ARGUMENTS, span, format!("`{name}` has no {what} (argument {})", at + 1))
                    .help("write the argument")
            })
        };
        let retraction = need(0, "retraction plane")?;
        let reference = need(1, "reference plane")?;
        let safety = number(values, 2, name, span)?.unwrap_or(0.0).abs() * length;
        let absolute = number(values, 3, name, span)?.map(|v| v * length);
        let relative = number(values, 4, name, span)?.map(|v| v.abs() * length);
        let depth = match (absolute, relative) {
            // The sign of the relative depth has no meaning; it leads away from the retraction
            // plane.
            (_, Some(relative)) if relative > 0.0 => {
                reference - relative * if retraction >= reference { 1.0 } else { -1.0 }
            }
            (Some(absolute), _) => absolute,
            _ => need(3, "final depth")?,
        };
        let down = if depth < reference { -1.0 } else { 1.0 };
        if depth == reference || (retraction - reference) * down > 0.0 {
            let message = format!(
                "the planes of `{name}` do not follow each other: retraction {retraction}, reference {reference}, depth {depth}"
            );
            return Err(Fault::new(codes::ARGUMENTS, span, message)
                .help("the reference plane lies between the retraction plane and the final depth"));
        }
        Ok(Planes { retraction, start: reference - safety * down, reference, depth })
    }

    /// Work coordinates of a point on the axis of the hole.
    fn on_axis(&self, to: f64) -> AxisValues {
        let mut end = self.position.work;
        end.put(self.modal.normal, to);
        end
    }

    pub(crate) fn straight(
        &mut self,
        mut end: AxisValues,
        mut programmed: u16,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault> {
        let words = programmed;
        self.with_kept(&mut end, &mut programmed);
        if rapid && self.rapid_left_open(end, programmed, words, false) {
            return Ok(());
        }
        let motion = self.cycle_motion(end, programmed, span)?;
        self.own.tangent = None;
        self.go(motion, rapid);
        Ok(())
    }

    pub(super) fn cycle_motion(&self, end: AxisValues, programmed: u16, span: Span) -> Result<Motion, Fault> {
        self.motion_to(end, programmed).map_err(|missing| {
            let message = format!("the cycle needs the position of {}, which the program has not set", missing.0);
            Fault::new(codes::POSITION_UNKNOWN, span, message).help("program X, Y and Z before the cycle")
        })
    }

    /// CYCLE83(RTP, RFP, SDIS, DP, DPR, FDEP, FDPR, DAM, DTB, DTS, FRF, VARI, AXN, MDEP, VRT, DTD, DIS1).
    ///
    /// First depth FDEP or FDPR, then each infeed is DAM shorter than the one before (or DAM times as long for a negative
    /// DAM) down to the smallest infeed; the last two are halved when the rest is between one and two of them.
    fn deep_hole(&mut self, planes: Planes, values: &[Option<Val>], span: Span) -> Result<(), Fault> {
        const NAME: &str = "CYCLE83";
        let length = self.modal.units.length();
        let value = |at: usize| number(values, at, NAME, span);
        // 1 to 3 are the axes of the geometry, anything else the third one.
        let axis =
            value(12)?.filter(|axis| *axis != 0.0).map(|axis| if matches!(axis, 1.0 | 2.0) { axis } else { 3.0 });
        if axis.is_some_and(|axis| axis != (self.modal.normal + 1) as f64) {
            return Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                "CYCLE83 with another drilling axis (AXN) is not supported",
            )
            .help("choose the plane with G17, G18 or G19"));
        }
        let total = (planes.reference - planes.depth).abs();
        let down = if planes.depth < planes.reference { -1.0 } else { 1.0 };
        let first = match (value(5)?, value(6)?) {
            (_, Some(relative)) if relative != 0.0 => relative.abs() * length,
            (Some(absolute), _) => (planes.reference - absolute * length).abs(),
            _ => total,
        };
        let infeeds = infeeds(total, first, value(7)?.unwrap_or(0.0), value(13)?.map(|v| v.abs() * length), length)
            .ok_or_else(|| {
                Fault::new(codes::ARGUMENTS, span, format!("CYCLE83 would need more than {MAX_INFEEDS} infeeds"))
                    .help("check first depth and degression")
            })?;
        let chip_break = value(11)?.unwrap_or(0.0) == 0.0;
        let retract = value(14)?.filter(|v| *v > 0.0).map_or(CHIP_BREAK_RETRACTION, |v| v * length);
        let ahead = value(16)?.filter(|v| *v > 0.0).map_or_else(|| anticipation(total), |v| v * length);
        let (at_depth, at_start) = (value(8)?, value(9)?);
        let first_factor = value(10)?.filter(|f| *f > 0.0 && *f <= 1.0).unwrap_or(1.0);
        let feed = self.technology.feed;
        self.course(&[planes.approach()], span)?;
        let mut reached = 0.0;
        for (i, infeed) in infeeds.iter().enumerate() {
            if i == 0 && first_factor < 1.0 {
                self.technology.feed = feed.map(|f| match f {
                    Feed::PerTime(v) => Feed::PerTime(v * first_factor),
                    Feed::PerRevolution(v) => Feed::PerRevolution(v * first_factor),
                    other => other,
                });
                self.tell_feed();
            }
            reached += infeed;
            let last = i + 1 == infeeds.len();
            let depth = if last { planes.depth } else { planes.reference + down * reached };
            self.course(&[Stroke::Feed(depth)], span)?;
            if self.technology.feed != feed {
                self.set_feed(feed);
            }
            // A dwell of zero at the final depth means the dwell of the other depths.
            let dwell = if last { value(15)?.filter(|v| *v != 0.0).or(at_depth) } else { at_depth };
            self.course(&[wait(dwell)], span)?;
            if last {
                break;
            }
            if chip_break {
                self.course(&[Stroke::Feed(depth - down * retract)], span)?;
            } else {
                let back = Stroke::Rapid(depth - down * ahead.min(reached));
                self.course(&[planes.approach(), wait(at_start), back], span)?;
            }
        }
        self.course(&[planes.out()], span)
    }

    /// HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM): holes on a line, each followed by the modal cycle.
    fn row_of_holes(&mut self, call: &Call, span: Span) -> Result<(), Fault> {
        let [x, y, angle, first, distance, count] = self.pattern(call, span)?;
        let (s, c) = crate::frame::sin_cos_degrees(angle);
        let length = self.modal.units.length();
        for i in 0..hole_count(count, "HOLES1", span)? {
            let along = (first + distance * f64::from(i)) * length;
            self.hole(x * length + along * c, y * length + along * s, span)?;
        }
        Ok(())
    }

    /// HOLES2(CPA, CPO, RAD, STA1, INDA, NUM): holes on a circle; INDA 0 spreads them evenly.
    fn circle_of_holes(&mut self, call: &Call, span: Span) -> Result<(), Fault> {
        let [x, y, radius, start, step, count] = self.pattern(call, span)?;
        let count = hole_count(count, "HOLES2", span)?;
        let step = if step == 0.0 { 360.0 / f64::from(count) } else { step };
        let length = self.modal.units.length();
        for i in 0..count {
            let (s, c) = crate::frame::sin_cos_degrees(start + step * f64::from(i));
            self.hole((x + radius * c) * length, (y + radius * s) * length, span)?;
        }
        Ok(())
    }

    /// CYCLE801(SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2, VARI): holes on a grid, row by row to and fro; VARI 1 leaves its inside out.
    fn grid_of_holes(&mut self, call: &Call, span: Span) -> Result<(), Fault> {
        const NAME: &str = "CYCLE801";
        let values = self.arguments(call, span)?;
        let mut numbers = [0.0; 8];
        for (at, slot) in numbers.iter_mut().enumerate() {
            *slot = number(&values, at, NAME, span)?.unwrap_or(0.0);
        }
        let [x, y, angle, across, up, columns, rows, variant] = numbers;
        if !matches!(variant, 0.0 | 1.0) || surplus(&values, 8).is_some() {
            let message = "`CYCLE801` with sheared rows, hidden holes, or a VARI other than 0 and 1 is not supported";
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help("write the holes with X and Y"));
        }
        let (columns, rows) = (hole_count(columns, NAME, span)?, hole_count(rows, NAME, span)?);
        self.assume("CYCLE801: the holes are made row by row along the first direction, in alternating directions");
        let ((s, c), length) = (crate::frame::sin_cos_degrees(angle), self.modal.units.length());
        for row in 0..rows {
            for place in 0..columns {
                let column = if row % 2 == 0 { place } else { columns - 1 - place };
                let edge = row == 0 || row + 1 == rows || column == 0 || column + 1 == columns;
                if variant == 1.0 && !edge {
                    continue;
                }
                let (u, v) = (across * f64::from(column), up * f64::from(row));
                self.hole((x + u * c - v * s) * length, (y + u * s + v * c) * length, span)?;
            }
        }
        Ok(())
    }

    fn pattern(&mut self, call: &Call, span: Span) -> Result<[f64; 6], Fault> {
        let values = self.arguments(call, span)?;
        if let Some(at) = surplus(&values, 6) {
            // HIDE
            if let Some(Some(Val::Text(hidden))) = values.get(8)
                && !hidden.trim().is_empty()
            {
                let message = format!("`{}` with hidden holes (argument 9) is not supported", call.name);
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help("write the holes with X and Y"));
            }
            if at != 8 || surplus(&values, 9).is_some() {
                self.assume(format!(
                    "{}: arguments from 7 on set how the editor of the control shows the pattern and how the tool \
                     moves from hole to hole: straight moves are used",
                    call.name
                ));
            }
        }
        let mut numbers = [0.0; 6];
        for (at, slot) in numbers.iter_mut().enumerate() {
            *slot = number(&values, at, &call.name, span)?.unwrap_or(0.0);
        }
        Ok(numbers)
    }

    fn hole(&mut self, u: f64, v: f64, span: Span) -> Result<(), Fault> {
        let [first, second, _] = self.modal.plane_axes();
        let mut end = self.position.work;
        end.put(first, u);
        end.put(second, v);
        self.straight(end, 1 << first | 1 << second, true, span)?;
        let Some(modal) = self.own.modal_call.clone() else { return Ok(()) };
        if DRILLING.contains(&modal.call.name.as_str()) {
            let file = Arc::clone(&self.location.file);
            self.run_cycle(&modal.call, span).map_err(|fault| modal.at_call(fault, &file))?;
            return Ok(());
        }
        Err(Fault::new(
            codes::UNSUPPORTED_WORD,
            span,
            format!("a hole pattern with `{}` is not supported", modal.call.name),
        )
        .help("use MCALL with a drilling cycle (CYCLE81 to CYCLE89)"))
    }
}

/// Dwell of a cycle with its AMODE: revolutions are below zero in the cycles.
pub(crate) fn in_revolutions(dwell: Option<f64>, mode: Option<f64>) -> Option<f64> {
    let revolutions = mode.is_some_and(|mode| (mode / 10.0).floor().rem_euclid(10.0) == 2.0);
    if revolutions { dwell.map(|v| -v.abs()) } else { dwell }
}

fn hole_count(count: f64, name: &str, span: Span) -> Result<u32, Fault> {
    if (1.0..=1000.0).contains(&count) && count.fract() == 0.0 {
        return Ok(count as u32);
    }
    Err(Fault::new(codes::ARGUMENTS, span, format!("`{name}` takes 1 to 1000 holes and has {count}"))
        .help("check argument 6"))
}

/// Lengths of the infeeds of a deep hole, mm; none when there would be too many.
fn infeeds(total: f64, first: f64, degression: f64, smallest: Option<f64>, length: f64) -> Option<Vec<f64>> {
    let mut list = Vec::new();
    let mut rest = total;
    let mut infeed = first.min(total);
    // If no smallest infeed is given, the degression itself is the smallest, so infeeds never
    // vanish.
    let amount = degression.max(0.0) * length;
    let floor = smallest.filter(|s| *s > 0.0).unwrap_or(if degression > 0.0 { amount } else { 0.0 });
    while rest > SAME_HEIGHT_MM {
        if list.len() >= MAX_INFEEDS || infeed <= SAME_HEIGHT_MM {
            return None;
        }
        if list.is_empty() || rest > 2.0 * infeed || rest <= infeed {
            let step = infeed.min(rest);
            list.push(step);
            rest -= step;
        } else {
            list.push(rest / 2.0);
            list.push(rest / 2.0);
            rest = 0.0;
        }
        let next = if degression < 0.0 { infeed * -degression } else { infeed - amount };
        infeed = if next < floor { floor.min(infeed) } else { next };
    }
    Some(list)
}

#[cfg(test)]
mod tests {
    use super::infeeds;

    #[test]
    fn infeeds_sum_to_the_depth() {
        for (total, first, degression, smallest) in
            [(30.0, 10.0, 3.0, None), (30.0, 10.0, 0.0, None), (50.0, 12.0, -0.7, Some(2.0)), (5.0, 20.0, 1.0, None)]
        {
            let list = infeeds(total, first, degression, smallest, 1.0).unwrap();
            assert!((list.iter().sum::<f64>() - total).abs() < 1e-9, "{list:?}");
        }
        assert_eq!(infeeds(30.0, 10.0, 3.0, None, 1.0).unwrap(), [10.0, 7.0, 4.0, 3.0, 3.0, 3.0]);
        assert_eq!(infeeds(30.0, 0.0, 0.0, None, 1.0), None);
    }
}
