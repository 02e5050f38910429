//! Cycle 232: face milling in meanders (Q389=0, 1) or line by line (2). Cycle 233: the same along
//! either axis (Q350), from the tool position; in meanders that end outside the surface (0) or at
//! its edge (1), or line by line to the same ends (2, 3).
//!
//! ```text
//!   Q226 + Q219   ------------>      passes side by side, no farther apart than the overlap says, all alike; their middles lie
//!                 <------------      symmetrically over the width; outside of the surface by the radius and Q357 at their ends
//!   Q226          ------------>      (strategy 1: inside of it between two passes)
//! ```

use super::Values;
use crate::channel::milling::WHOLE;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::dialect::heidenhain::interpreter::Interpreter;

/// Most passes and depths of one cycle.
const MAX_LINES: f64 = 10_000.0;

/// Parameters that the control writes, and what is taken for granted.
pub(super) fn words() -> (&'static [u32], &'static str) {
    (
        &[389, 225, 226, 227, 386, 218, 219, 202, 369, 370, 207, 385, 253, 200, 357, 204],
        "passes lie symmetrically over the width Q219; rounded inserts (R2) do not lower the overlap; in the working plane the tool \
         moves to the first pass at rapid rate",
    )
}

/// Parameters that the control writes for 233, and what is taken for granted.
pub(super) fn words_of_233() -> (&'static [u32], &'static str) {
    (
        &[215, 389, 350, 218, 219, 227, 386, 369, 202, 370, 207, 385, 253, 357, 200, 204],
        "without Q367 the surface begins at the tool, to the sides of the signs of Q218 and Q219; passes lie symmetrically over its \
         width; the tool goes back to the first pass Q200 above the depth",
    )
}

/// Parameters of 233 that must be zero, with what to do instead.
pub(super) const ZEROS: &[(u32, &str)] = &[
    (347, "a side wall limits the surface: mill a pocket or a stud"),
    (348, "a side wall limits the surface: mill a pocket or a stud"),
    (349, "a side wall limits the surface: mill a pocket or a stud"),
];

impl Interpreter {
    pub(super) fn face_mill(&mut self, values: &Values, radius: f64, span: Span) -> Result<(), Fault> {
        let number = |key: u32| self.cycle_number(values, key, None, span);
        let mm = |key: u32| self.mm(values, key, None, span);
        let strategy = number(389)?;
        if !matches!(strategy, 0.0 | 1.0 | 2.0) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("Q389 takes 0, 1 or 2 and has {strategy}"))
                .help("0 and 1 mill in meanders, 2 line by line"));
        }
        let (u0, v0, top, bottom) = (mm(225)?, mm(226)?, mm(227)?, mm(386)?);
        let (length, width) = (mm(218)?, mm(219)?);
        let (infeed, allowance) = (mm(202)?.abs(), mm(369)?.abs());
        let (clearance, lateral) = (mm(200)?.abs(), mm(357)?.abs());
        let second = top.max(bottom) + mm(204)?.abs();
        if length == 0.0 || width == 0.0 || infeed == 0.0 || !(length + width).is_finite() {
            return Err(Fault::new(codes::ARGUMENTS, span, "Q218, Q219 and Q202 of cycle 232 must not be zero")
                .help("write the sides of the surface and the infeed"));
        }
        let (mill, finish, position) = (
            self.cycle_feed(values, 207, span)?,
            self.cycle_feed(values, 385, span)?,
            self.cycle_feed(values, 253, span)?,
        );
        // Equal passes and equal infeeds, none above the allowed size.
        let passes = (width.abs() / self.overlap(values, radius, span)? - WHOLE).ceil().max(1.0);
        let total = top - bottom;
        let rough = total.signum() * (total.abs() - allowance).max(0.0);
        let infeeds = (rough.abs() / infeed - WHOLE).ceil().max(0.0);
        if passes > MAX_LINES || infeeds > MAX_LINES {
            return Err(Fault::new(codes::ARGUMENTS, span, "cycle 232 would need more than 10 000 passes or infeeds")
                .help("check Q219, Q370, Q202"));
        }
        let lines: Vec<f64> = (0..passes as u32).map(|i| v0 + width * (f64::from(i) + 0.5) / passes).collect();
        let outside = length.signum() * (radius + lateral);
        let inside = length.signum() * radius.min(0.5 * length.abs());
        let far = [u0 - outside, u0 + length + outside];
        let near = [u0 + inside, u0 + length - inside];
        let mut depths: Vec<(f64, bool)> =
            (1..=infeeds as u32).map(|i| (top - rough * f64::from(i) / infeeds, false)).collect();
        if allowance > 0.0 {
            depths.push((bottom, true));
        }
        let normal = self.modal.normal;
        if self.position.work.get(normal).is_none_or(|z| z < second) {
            self.mill_to(None, Some(second), None, span)?;
        }
        self.mill_to(Some([far[0], lines[0]]), None, None, span)?;
        self.mill_to(None, Some(top + clearance), None, span)?;
        let mut backwards = false;
        let mut side = 0;
        for (depth, last) in depths {
            let feed = if last { finish } else { mill };
            self.mill_to(None, Some(depth), position, span)?;
            let count = lines.len();
            for i in 0..count {
                let v = lines[if backwards { count - 1 - i } else { i }];
                // Where the pass begins and ends: strategy 1 turns on the surface.
                let ends = if strategy == 1.0 { near } else { far };
                let to = if i + 1 == count { far[1 - side] } else { ends[1 - side] };
                let now = self.flat(span)?[0];
                let across = if strategy == 1.0 { feed } else { position };
                if strategy == 2.0 && i > 0 {
                    // Back to the side where every line begins, above the surface.
                    self.mill_to(None, Some(depth + clearance), None, span)?;
                    self.mill_to(Some([far[0], v]), None, position, span)?;
                    self.mill_to(None, Some(depth), position, span)?;
                } else {
                    self.mill_to(Some([now, v]), None, across, span)?;
                }
                self.mill_to(Some([to, v]), None, feed, span)?;
                side = if strategy == 2.0 { 0 } else { 1 - side };
            }
            if strategy == 2.0 {
                self.mill_to(None, Some(depth + clearance), None, span)?;
                self.mill_to(Some([far[0], lines[if backwards { count - 1 } else { 0 }]]), None, position, span)?;
            } else {
                // The surface is milled back again at the next depth.
                backwards = !backwards;
            }
        }
        self.mill_to(None, Some(second), None, span)
    }

    pub(super) fn face_233(&mut self, values: &Values, radius: f64, span: Span) -> Result<(), Fault> {
        let mm = |key: u32| self.mm(values, key, None, span);
        let choice = |key: u32, default: f64, allowed: &[f64]| -> Result<f64, Fault> {
            let value = self.cycle_number(values, key, Some(default), span)?;
            if allowed.contains(&value) {
                return Ok(value);
            }
            let list: Vec<String> = allowed.iter().map(f64::to_string).collect();
            Err(Fault::new(codes::BAD_VALUE, span, format!("Q{key} of cycle 233 is {value}"))
                .help(format!("of its values {} are read", list.join(", "))))
        };
        let strategy = choice(389, 0.0, &[0.0, 1.0, 2.0, 3.0])?;
        let operation = choice(215, 0.0, &[0.0, 1.0, 2.0])?;
        let main = choice(350, 1.0, &[1.0, 2.0])? == 1.0;
        let position = choice(367, -1.0, &[-1.0, 0.0, 1.0, 2.0, 3.0, 4.0])?;
        let sides = [mm(218)?, mm(219)?];
        let (top, bottom) = (mm(227)?, mm(386)?);
        let (infeed, allowance) = (mm(202)?.abs(), mm(369)?.abs());
        let (clearance, lateral) = (mm(200)?.abs(), mm(357)?.abs());
        let second = top.max(bottom) + mm(204)?.abs();
        if sides.contains(&0.0) || infeed == 0.0 || top == bottom || !(sides[0] + sides[1]).is_finite() {
            return Err(Fault::new(
                codes::ARGUMENTS,
                span,
                "the sides, the infeed and the depth of cycle 233 must not be zero",
            )
            .help("write Q218, Q219, Q202 and another height in Q386 than in Q227"));
        }
        let (mill, finish, across) = (
            self.cycle_feed(values, 207, span)?,
            self.cycle_feed(values, 385, span)?,
            self.cycle_feed(values, 253, span)?,
        );
        let (along, over) = if main { (0, 1) } else { (1, 0) };
        // Tool position by Q367: -1 the corner that the signs of the side lengths refer to, 0 the
        // middle, 1 to 4 a corner, counter-clockwise from the lower left.
        let here = self.flat(span)?;
        let [a, b] = sides.map(f64::abs);
        let (corner, signs) = match position {
            -1.0 => (here, sides.map(f64::signum)),
            at => {
                let from = [[0.5 * a, 0.5 * b], [0.0, 0.0], [a, 0.0], [a, b], [0.0, b]][at as usize];
                ([here[0] - from[0], here[1] - from[1]], [1.0, 1.0])
            }
        };
        let passes = (sides[over].abs() / self.overlap(values, radius, span)? - WHOLE).ceil().max(1.0);
        let total = top - bottom;
        let rough = total.signum() * (total.abs() - allowance).max(0.0);
        let infeeds = (rough.abs() / infeed - WHOLE).ceil().max(0.0);
        if passes > MAX_LINES || infeeds > MAX_LINES {
            return Err(Fault::new(codes::ARGUMENTS, span, "cycle 233 would need more than 10 000 passes or infeeds")
                .help("check Q218, Q219, Q370, Q202"));
        }
        let at = |end: f64, line: f64| {
            let mut p = corner;
            p[along] += signs[along] * end;
            p[over] += signs[over] * line;
            p
        };
        let lines: Vec<f64> = (0..passes as u32).map(|i| sides[over].abs() * (f64::from(i) + 0.5) / passes).collect();
        let length = sides[along].abs();
        let begin = -(radius + lateral);
        let reach = lateral + if strategy == 0.0 || strategy == 2.0 { radius } else { 0.0 };
        let mut depths: Vec<(f64, bool)> = match operation {
            2.0 => Vec::new(),
            _ => (1..=infeeds as u32).map(|i| (top - rough * f64::from(i) / infeeds, false)).collect(),
        };
        if operation != 1.0 && (allowance > 0.0 || operation == 2.0) {
            depths.push((bottom, true));
        }
        let by_lines = strategy >= 2.0;
        let normal = self.modal.normal;
        if self.position.work.get(normal).is_none_or(|z| z < second) {
            self.mill_to(None, Some(second), None, span)?;
        }
        for (i, &(depth, last)) in depths.iter().enumerate() {
            let feed = if last { finish } else { mill };
            self.mill_to(Some(at(begin, lines[0])), None, None, span)?;
            if i == 0 {
                self.mill_to(None, Some(top + clearance), None, span)?;
            }
            self.mill_to(None, Some(depth), if i == 0 { mill } else { across }, span)?;
            let mut ends = [-reach, length + reach];
            for (j, &line) in lines.iter().enumerate() {
                if j > 0 && by_lines {
                    self.mill_to(None, Some(depth + clearance), None, span)?;
                    self.mill_to(Some(at(begin, line)), None, across, span)?;
                    self.mill_to(None, Some(depth), across, span)?;
                } else if j > 0 {
                    self.mill_to(Some(at(ends[0], line)), None, across, span)?;
                }
                self.mill_to(Some(at(ends[1], line)), None, feed, span)?;
                if !by_lines {
                    ends.swap(0, 1);
                }
            }
            self.mill_to(None, Some(depth + clearance), None, span)?;
        }
        self.mill_to(None, Some(second), None, span)
    }
}
