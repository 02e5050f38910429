//! Cycles 210 to 215 of older controls, whose center is Q216 and Q217: slots, and the finishing of pockets and studs.
//!
//! | cycle | is milled as | with |
//! |---|---|---|
//! | 210 slot to and fro | 253 | Q218 Q219 Q224 |
//! | 211 circular slot | 254 | Q244 pitch circle, Q219 Q245 Q248 |
//! | 212 pocket finishing | 251, the wall | Q218 Q219 Q220, Q221 allowance |
//! | 213 stud finishing | 256, the wall | the same |
//! | 214 circular pocket finishing | 252, the wall | Q222 before, Q223 finished |
//! | 215 circular stud finishing | 257, the wall | the same |
//!
//! Parameters after HEIDENHAIN, *iTNC 530 cycles* (60 642x), chapter "Pocket, stud and slot
//! milling", from memory. The tool moves to the center at the second set-up clearance, mills, and
//! stops above the center.

use super::Values;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::dialect::heidenhain::cycle::Setting;
use crate::dialect::heidenhain::interpreter::Interpreter;

/// Cycles of this form.
pub(super) const OLD: std::ops::RangeInclusive<u32> = 210..=215;

/// Allowance of a wall where the cycle states none, mm: it only marks that there is something to
/// finish.
const SOME_MM: f64 = 1.0;

/// Parameters that the control writes, and what is taken for granted.
pub(super) fn words(number: u32) -> (&'static [u32], &'static str) {
    const WALL: &str = "the wall is finished from the center, or from outside the stud, on arcs of the tool radius, \
                        with equal infeeds Q202";
    const SLOT: &str = "the slot is cleared by rings of one tool radius and a plunge to and fro at 3 degrees";
    match number {
        210 => (&[200, 201, 207, 202, 215, 203, 204, 216, 217, 218, 219, 224], SLOT),
        211 => (&[200, 201, 207, 202, 215, 203, 204, 216, 217, 244, 219, 245, 248], SLOT),
        214 | 215 => (&[200, 201, 206, 202, 207, 203, 204, 216, 217, 222, 223], WALL),
        _ => (&[200, 201, 206, 202, 207, 203, 204, 216, 217, 218, 219], WALL),
    }
}

impl Interpreter {
    /// Runs the cycle at its own center.
    pub(super) fn mill_old(&mut self, number: u32, values: &Values, lift: f64, span: Span) -> Result<(), Fault> {
        let unit = self.modal.unit();
        let get = |key: u32, default: f64| self.cycle_number(values, key, Some(default), span);
        let center = [get(216, 0.0)? * unit, get(217, 0.0)? * unit];
        let mut mapped = values.clone();
        let mut put = |key: u32, value: f64| {
            mapped.insert(key, Setting::Number(value));
        };
        for (key, value) in [(351, 1.0), (370, 1.0), (367, 0.0), (369, 0.0), (368, 0.0)] {
            put(key, value);
        }
        let wall = SOME_MM / unit;
        let allowance = get(221, 0.0)?.abs().max(wall);
        let target = match number {
            210 | 211 => {
                put(366, 2.0);
                put(338, get(338, 0.0)?);
                if number == 210 {
                    put(374, get(224, 0.0)?);
                    253
                } else {
                    for (key, value) in [(375, get(244, 0.0)?), (376, get(245, 0.0)?), (377, 1.0), (378, 0.0)] {
                        put(key, value);
                    }
                    254
                }
            }
            212 | 213 => {
                for (key, value) in [(215, 2.0), (224, 0.0), (366, 0.0), (338, get(202, 0.0)?), (368, allowance)] {
                    put(key, value);
                }
                put(220, get(220, 0.0)?);
                put(424, get(218, 0.0)? + 2.0 * allowance);
                put(425, get(219, 0.0)? + 2.0 * allowance);
                if number == 212 { 251 } else { 256 }
            }
            _ => {
                let (blank, finished) = (get(222, 0.0)?, get(223, 0.0)?);
                let fits = if number == 214 { blank < finished } else { blank > finished };
                if !fits {
                    let message = format!(
                        "cycle {number}: the diameter before is Q222={blank} and the finished one Q223={finished}"
                    );
                    return Err(Fault::new(codes::BAD_VALUE, span, message).help("Q222 is that of the blank"));
                }
                for (key, value) in
                    [(215, 2.0), (366, 0.0), (338, get(202, 0.0)?), (368, 0.5 * (blank - finished).abs())]
                {
                    put(key, value);
                }
                if number == 214 { 252 } else { 257 }
            }
        };
        // 210 and 211 plunge at the milling feed if Q206 is not given.
        if let Some(feed) = values.get(&207) {
            mapped.entry(206).or_insert(*feed);
        }
        let heights = self.heights(number, values, lift, span)?;
        let normal = self.modal.normal;
        if self.position.work.get(normal).is_none_or(|z| z < heights.second) {
            self.mill_to(None, Some(heights.second), None, span)?;
        }
        self.mill_to(Some(center), None, None, span)?;
        self.mill(target, &mapped, lift, span)?;
        self.mill_to(Some(center), None, None, span)
    }
}
