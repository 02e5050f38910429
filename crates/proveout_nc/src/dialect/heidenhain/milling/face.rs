//! Cycle 232: face milling in meanders (Q389=0, 1) or line by line (2). Cycle 233: the same along
//! either axis (Q350), from the tool position; in meanders that end outside the surface (0) or at
//! its edge (1), or line by line to the same ends (2, 3).
//!
//! ```text
//!   Q226 + Q219   ------------>      Passes lie side by side, no farther apart than the overlap says, all
//!                 <------------      alike. Their middles lie symmetrically over the width, their ends
//!   Q226          ------------>      outside of the surface by the radius and Q357 (strategy 1: inside of
//!                                    it between two passes).
//! ```

use crate::Feed;
use crate::channel::milling::WHOLE;
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::Fault;
use crate::dialect::heidenhain::interpreter::Interpreter;

/// Most passes and depths of one cycle.
const MAX_LINES: f64 = 10_000.0;

/// Equal passes over the width and equal infeeds down to the bottom, none above the allowed size.
struct Division {
    passes: f64,
    /// Heights, and whether the base is finished there.
    depths: Vec<(f64, bool)>,
}

impl Division {
    /// `sides`: the parameters of the width.
    fn of(v: &Values, width: f64, overlap: f64, sides: &'static str) -> Result<Self, Fault> {
        let (top, bottom, allowance) = (v.value(227)?, v.value(386)?, v.value(369)?.abs());
        let passes = (width.abs() / overlap - WHOLE).ceil().max(1.0);
        let total = top - bottom;
        let rough = total.signum() * (total.abs() - allowance).max(0.0);
        let infeeds = (rough.abs() / v.value(202)?.abs() - WHOLE).ceil().max(0.0);
        if passes > MAX_LINES || infeeds > MAX_LINES {
            let message = format!("cycle {} would need more than 10 000 passes or infeeds", v.name());
            return Err(v.fault(codes::ARGUMENTS, message, sides));
        }
        let depths = (1..=infeeds as u32).map(|i| (top - rough * f64::from(i) / infeeds, false)).collect();
        Ok(Self { passes, depths })
    }

    /// The middle of each pass as a distance from the start of the width.
    fn lines(&self, width: f64) -> impl Iterator<Item = f64> {
        let passes = self.passes;
        (0..passes as u32).map(move |i| width * (f64::from(i) + 0.5) / passes)
    }
}

impl Interpreter {
    /// Feeds of milling, finishing and positioning.
    fn face_feeds(&self, v: &Values) -> Result<[Option<Feed>; 3], Fault> {
        Ok([self.cycle_feed(v, 207)?, self.cycle_feed(v, 385)?, self.cycle_feed(v, 253)?])
    }

    pub(super) fn face_mill(&mut self, v: &Values, radius: f64) -> Result<(), Fault> {
        let span = v.span;
        let strategy = v.value(389)?;
        if !matches!(strategy, 0.0 | 1.0 | 2.0) {
            let message = format!("Q389 takes 0, 1 or 2 and has {strategy}");
            return Err(v.fault(codes::BAD_VALUE, message, "0 and 1 mill in meanders, 2 line by line"));
        }
        let (u0, v0, top, bottom) = (v.value(225)?, v.value(226)?, v.value(227)?, v.value(386)?);
        let (length, width) = (v.value(218)?, v.value(219)?);
        let (clearance, lateral) = (v.value(200)?.abs(), v.value(357)?.abs());
        let second = top.max(bottom) + v.value(204)?.abs();
        if length == 0.0 || width == 0.0 || v.value(202)? == 0.0 || !(length + width).is_finite() {
            let message = "Q218, Q219 and Q202 of cycle 232 must not be zero";
            return Err(v.fault(codes::ARGUMENTS, message, "write the sides of the surface and the infeed"));
        }
        let [mill, finish, position] = self.face_feeds(v)?;
        let division = Division::of(v, width, self.overlap(v, radius)?, "check Q219, Q370, Q202")?;
        let lines: Vec<f64> = division.lines(width).map(|line| v0 + line).collect();
        let mut depths = division.depths;
        let outside = length.signum() * (radius + lateral);
        let inside = length.signum() * radius.min(0.5 * length.abs());
        let far = [u0 - outside, u0 + length + outside];
        let near = [u0 + inside, u0 + length - inside];
        if v.value(369)? != 0.0 {
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

    pub(super) fn face_233(&mut self, v: &Values, radius: f64) -> Result<(), Fault> {
        let span = v.span;
        let choice = |key: u32, usual: f64, allowed: &[f64]| -> Result<f64, Fault> {
            let value = v.raw(key)?.unwrap_or(usual);
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
        let sides = [v.value(218)?, v.value(219)?];
        let (top, bottom) = (v.value(227)?, v.value(386)?);
        let (clearance, lateral) = (v.value(200)?.abs(), v.value(357)?.abs());
        let second = top.max(bottom) + v.value(204)?.abs();
        if sides.contains(&0.0) || v.value(202)? == 0.0 || top == bottom || !(sides[0] + sides[1]).is_finite() {
            let message = "the sides, the infeed and the depth of cycle 233 must not be zero";
            let help = "write Q218, Q219, Q202 and another height in Q386 than in Q227";
            return Err(v.fault(codes::ARGUMENTS, message, help));
        }
        let [mill, finish, across] = self.face_feeds(v)?;
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
        let width = sides[over].abs();
        let division = Division::of(v, width, self.overlap(v, radius)?, "check Q218, Q219, Q370, Q202")?;
        let at = |end: f64, line: f64| {
            let mut p = corner;
            p[along] += signs[along] * end;
            p[over] += signs[over] * line;
            p
        };
        let lines: Vec<f64> = division.lines(width).collect();
        let length = sides[along].abs();
        let begin = -(radius + lateral);
        let reach = lateral + if strategy == 0.0 || strategy == 2.0 { radius } else { 0.0 };
        let mut depths = if operation == 2.0 { Vec::new() } else { division.depths };
        if operation != 1.0 && (v.value(369)? != 0.0 || operation == 2.0) {
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
