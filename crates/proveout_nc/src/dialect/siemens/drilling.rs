//! Drilling cycles and hole patterns, expanded to motions.
//!
//! Courses after the programming manual (Siemens, *NC programming, cycles*: CYCLE81, CYCLE82,
//! CYCLE83, HOLES1, HOLES2; the others in [`super::tapping`] and [`super::boring`]). All lengths
//! run along the normal of the working plane; the drilling direction is from the retraction plane
//! to the final depth.

use std::sync::Arc;

use super::eval::Val;
use super::interpreter::{Interpreter, Siemens};
use super::parser::Call;
use crate::channel::milling::{Heights, SAME_HEIGHT_MM};
use crate::channel::{Holes, Stroke};
use crate::codes;
use crate::cycle::{Given, Key, Values, siemens as table};
use crate::diagnostic::{Fault, Span};
use crate::{AxisValues, Dwell, Feed, Motion};

/// Clearance before the last depth when CYCLE83 returns into the hole, chosen by the cycle: 0.6 mm
/// up to 30 mm depth, then depth/50, at most 7 mm.
fn anticipation(depth: f64) -> f64 {
    if depth <= 30.0 { 0.6 } else { (depth / 50.0).min(7.0) }
}

/// Retraction of chip breaking where none is given, mm.
const CHIP_BREAK_RETRACTION: f64 = 1.0;
/// Most infeeds of one hole.
pub(super) const MAX_INFEEDS: usize = 10_000;

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
    /// What a call gives to a cycle.
    pub(super) fn cycle_values(&self, call: &Call, span: Span) -> Result<Option<Values>, Fault> {
        let Some(spec) = table::ALL.iter().find(|spec| spec.name == call.name) else { return Ok(None) };
        let arguments = self.arguments(call, span)?;
        // Operate also writes a call of CYCLE81 with a dwell before the modes.
        let with_dwell = spec.name == table::CYCLE81.name && arguments.len() > table::CYCLE81.parameters.len();
        let spec = if with_dwell { &table::CYCLE81_WITH_DWELL } else { *spec };
        let given = arguments.into_iter().map(|argument| {
            argument.map(|value| match value {
                Val::Number(number) => Given::Number(number),
                Val::Text(text) => Given::Text(text),
            })
        });
        Ok(Some(Values::of_call(spec, given, self.modal.units.length(), span)))
    }

    /// Runs a cycle of the control; false when there is none of this name.
    pub(crate) fn run_cycle(&mut self, call: &Call, span: Span) -> Result<bool, Fault> {
        let Some(values) = self.cycle_values(call, span)? else { return Ok(false) };
        match values.name() {
            "CYCLE800" => self.cycle800(&values)?,
            "CYCLE832" => self.cycle832(&values)?,
            "CYCLE62" => self.contour_call(&values)?,
            "HOLES1" => self.row_of_holes(&values)?,
            "HOLES2" => self.circle_of_holes(&values)?,
            "CYCLE801" => self.grid_of_holes(&values)?,
            name if table::makes_a_hole(name) => self.make_hole(&values)?,
            _ => self.mill_cycle(&values)?,
        }
        Ok(true)
    }

    fn make_hole(&mut self, v: &Values) -> Result<(), Fault> {
        v.check_modes(self.modal.normal)?;
        let h = v.heights_of_hole()?;
        match v.name() {
            "CYCLE84" => return self.rigid_tapping(h, v),
            "CYCLE840" => return self.floating_tapping(h, v),
            _ => self.need_feed(v.span)?,
        }
        match v.name() {
            "CYCLE83" => self.deep_hole(h, v),
            "CYCLE85" => self.reaming(h, v),
            "CYCLE86" => self.boring_with_lift(h, v),
            "CYCLE87" | "CYCLE88" => self.boring_with_stop(h, v),
            // Down, dwell and up in the same feed.
            "CYCLE89" => {
                let strokes = [h.approach(), h.to_depth(), wait(v.get("DTB")?), Stroke::Feed(h.clear), h.out()];
                self.course(&strokes, v.span)
            }
            _ => self.course(&[h.approach(), h.to_depth(), wait(v.dwell()?), h.out()], v.span),
        }
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

    /// CYCLE83: first depth FDEP or FDPR, then each infeed is DAM shorter than the one before (or DAM times
    /// as long for a negative DAM) down to the smallest infeed; the last two are halved when the rest is
    /// between one and two of them.
    fn deep_hole(&mut self, h: Heights, v: &Values) -> Result<(), Fault> {
        let span = v.span;
        // 1 to 3 are the axes of the geometry, anything else the third one.
        let axis =
            v.get("AXN")?.filter(|axis| *axis != 0.0).map(|axis| if matches!(axis, 1.0 | 2.0) { axis } else { 3.0 });
        if axis.is_some_and(|axis| axis != (self.modal.normal + 1) as f64) {
            return Err(v.fault(
                codes::UNSUPPORTED_WORD,
                "CYCLE83 with another drilling axis (AXN) is not supported",
                "choose the plane with G17, G18 or G19",
            ));
        }
        let total = (h.surface - h.depth).abs();
        let first = match (v.get("FDEP")?, v.get("FDPR")?) {
            (_, Some(relative)) if relative != 0.0 => relative,
            (Some(absolute), _) => (h.surface - absolute).abs(),
            _ => total,
        };
        let infeeds = infeeds(total, first, v.value("DAM")?, v.get("MDEP")?, v.length).ok_or_else(|| {
            let message = format!("CYCLE83 would need more than {MAX_INFEEDS} infeeds");
            v.fault(codes::ARGUMENTS, message, "check first depth and degression")
        })?;
        let chip_break = v.value("VARI")? == 0.0;
        let retract = v.get("VRT")?.filter(|v| *v > 0.0).unwrap_or(CHIP_BREAK_RETRACTION);
        let ahead = v.get("DIS1")?.filter(|v| *v > 0.0).unwrap_or_else(|| anticipation(total));
        let (at_depth, at_start) = (v.get("DTB")?, v.get("DTS")?);
        let first_factor = v.get("FRF")?.filter(|f| *f > 0.0 && *f <= 1.0).unwrap_or(1.0);
        let feed = self.technology.feed;
        self.course(&[h.approach()], span)?;
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
            let depth = if last { h.depth } else { h.surface + h.down * reached };
            self.course(&[Stroke::Feed(depth)], span)?;
            if self.technology.feed != feed {
                self.set_feed(feed);
            }
            // A dwell of zero at the final depth means the dwell of the other depths.
            let dwell = if last { v.get("DTD")?.filter(|v| *v != 0.0).or(at_depth) } else { at_depth };
            self.course(&[wait(dwell)], span)?;
            if last {
                break;
            }
            if chip_break {
                self.course(&[Stroke::Feed(depth - h.down * retract)], span)?;
            } else {
                let back = Stroke::Rapid(depth - h.down * ahead.min(reached));
                self.course(&[h.approach(), wait(at_start), back], span)?;
            }
        }
        self.course(&[h.out()], span)
    }

    /// HOLES1: holes on a line, each followed by the modal cycle.
    fn row_of_holes(&mut self, v: &Values) -> Result<(), Fault> {
        let [x, y, angle, first, distance, count] = self.pattern(v)?;
        let (s, c) = crate::frame::sin_cos_degrees(angle);
        for i in 0..hole_count(count, v)? {
            let along = (first + distance * f64::from(i)) * v.length;
            self.hole(x * v.length + along * c, y * v.length + along * s, v.span)?;
        }
        Ok(())
    }

    /// HOLES2: holes on a circle; INDA 0 spreads them evenly.
    fn circle_of_holes(&mut self, v: &Values) -> Result<(), Fault> {
        let [x, y, radius, start, step, count] = self.pattern(v)?;
        let count = hole_count(count, v)?;
        let step = if step == 0.0 { 360.0 / f64::from(count) } else { step };
        for i in 0..count {
            let (s, c) = crate::frame::sin_cos_degrees(start + step * f64::from(i));
            self.hole((x + radius * c) * v.length, (y + radius * s) * v.length, v.span)?;
        }
        Ok(())
    }

    /// CYCLE801: holes on a grid, row by row to and fro; VARI 1 leaves its inside out.
    fn grid_of_holes(&mut self, v: &Values) -> Result<(), Fault> {
        let [x, y, angle, across, up, columns, rows, variant] = v.all()?;
        if !matches!(variant, 0.0 | 1.0) || v.surplus().is_some() {
            let message = "`CYCLE801` with sheared rows, hidden holes, or a VARI other than 0 and 1 is not supported";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, "write the holes with X and Y"));
        }
        let (columns, rows) = (hole_count(columns, v)?, hole_count(rows, v)?);
        self.assume("CYCLE801: the holes are made row by row along the first direction, in alternating directions");
        let (s, c) = crate::frame::sin_cos_degrees(angle);
        for row in 0..rows {
            for place in 0..columns {
                let column = if row % 2 == 0 { place } else { columns - 1 - place };
                let edge = row == 0 || row + 1 == rows || column == 0 || column + 1 == columns;
                if variant == 1.0 && !edge {
                    continue;
                }
                let (along, over) = (across * f64::from(column), up * f64::from(row));
                self.hole((x + along * c - over * s) * v.length, (y + along * s + over * c) * v.length, v.span)?;
            }
        }
        Ok(())
    }

    fn pattern(&mut self, v: &Values) -> Result<[f64; 6], Fault> {
        if let Some(at) = v.surplus() {
            // HIDE
            if matches!(v.given.get(&Key::Position(9)), Some(Given::Text(hidden)) if !hidden.trim().is_empty()) {
                let message = format!("`{}` with hidden holes (argument 9) is not supported", v.name());
                return Err(v.fault(codes::UNSUPPORTED_WORD, message, "write the holes with X and Y"));
            }
            if at != 9 || v.surplus_after(9).is_some() {
                self.assume(format!(
                    "{}: arguments from 7 on set how the editor of the control shows the pattern and how the tool \
                     moves from hole to hole: straight moves are used",
                    v.name()
                ));
            }
        }
        v.all()
    }

    fn hole(&mut self, u: f64, v: f64, span: Span) -> Result<(), Fault> {
        let [first, second, _] = self.modal.plane_axes();
        let mut end = self.position.work;
        end.put(first, u);
        end.put(second, v);
        self.straight(end, 1 << first | 1 << second, true, span)?;
        let Some(modal) = self.own.modal_call.clone() else { return Ok(()) };
        if table::makes_a_hole(&modal.call.name) {
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

fn hole_count(count: f64, v: &Values) -> Result<u32, Fault> {
    if (1.0..=1000.0).contains(&count) && count.fract() == 0.0 {
        return Ok(count as u32);
    }
    let message = format!("`{}` takes 1 to 1000 holes and has {count}", v.name());
    Err(v.fault(codes::ARGUMENTS, message, "check argument 6"))
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
