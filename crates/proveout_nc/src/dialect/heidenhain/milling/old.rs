//! Cycles 210 to 215 of older controls, whose center is Q216 and Q217: slots, and the finishing of pockets
//! and studs.
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

use crate::codes;
use crate::cycle::{Key, Values, heidenhain as table};
use crate::diagnostic::Fault;
use crate::dialect::heidenhain::interpreter::Interpreter;

/// Allowance of a wall where the cycle states none, mm: it only marks that there is something to
/// finish.
const SOME_MM: f64 = 1.0;

impl Interpreter {
    /// Runs the cycle at its own center.
    pub(super) fn mill_old(&mut self, v: &Values) -> Result<(), Fault> {
        let get = |key: u32| v.raw(key).map(Option::unwrap_or_default);
        let center = [get(216)? * v.length, get(217)? * v.length];
        let mut mapped = v.clone();
        let mut put = |list: &[(u32, f64)]| list.iter().for_each(|&(key, value)| mapped.put(key, value));
        put(&[(351, 1.0), (370, 1.0), (367, 0.0), (369, 0.0), (368, 0.0)]);
        let wall = SOME_MM / v.length;
        let allowance = get(221)?.abs().max(wall);
        let target = match v.name() {
            "210" => {
                put(&[(366, 2.0), (338, get(338)?), (374, get(224)?)]);
                &table::C253
            }
            "211" => {
                put(&[(366, 2.0), (338, get(338)?), (375, get(244)?), (376, get(245)?), (377, 1.0), (378, 0.0)]);
                &table::C254
            }
            "212" | "213" => {
                put(&[(215, 2.0), (224, 0.0), (366, 0.0), (338, get(202)?), (368, allowance), (220, get(220)?)]);
                put(&[(424, get(218)? + 2.0 * allowance), (425, get(219)? + 2.0 * allowance)]);
                if v.name() == "212" { &table::C251 } else { &table::C256 }
            }
            number => {
                let (blank, finished) = (get(222)?, get(223)?);
                let fits = if number == "214" { blank < finished } else { blank > finished };
                if !fits {
                    let message = format!(
                        "cycle {number}: the diameter before is Q222={blank} and the finished one Q223={finished}"
                    );
                    return Err(v.fault(codes::BAD_VALUE, message, "Q222 is that of the blank"));
                }
                put(&[(215, 2.0), (366, 0.0), (338, get(202)?), (368, 0.5 * (blank - finished).abs())]);
                if number == "214" { &table::C252 } else { &table::C257 }
            }
        };
        // 210 and 211 plunge at the milling feed if Q206 is not given.
        if let Some(feed) = v.given(207) {
            mapped.given.entry(Key::Q(206)).or_insert_with(|| feed.clone());
        }
        let heights = self.heights(v)?;
        let normal = self.modal.normal;
        if self.position.work.get(normal).is_none_or(|z| z < heights.second) {
            self.mill_to(None, Some(heights.second), None, v.span)?;
        }
        self.mill_to(Some(center), None, None, v.span)?;
        self.mill(&Values { spec: target, ..mapped })?;
        self.mill_to(Some(center), None, None, v.span)
    }
}
