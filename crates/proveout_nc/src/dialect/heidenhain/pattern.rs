//! Hole patterns: cycles 220 (circle) and 221 (rows), PATTERN DEF with CYCL CALL PAT.

use super::cycle::Cycle;
use super::interpreter::Interpreter;
use super::words::{Pattern, PatternKind, Words};
use crate::codes;
use crate::cycle::{Given, Key, Values};
use crate::diagnostic::{Fault, Span};

/// Most holes of a pattern.
const MAX_HOLES: f64 = 100_000.0;

impl Interpreter {
    /// 220 and 221 run the drilling cycle before them at once; Q200, Q203, Q204 of the pattern replace those
    /// of the cycle.
    pub(crate) fn pattern_cycle(&mut self, p: &Values) -> Result<(), Fault> {
        self.settle_contour(p.span)?;
        let Some(Cycle::Fixed(defined)) = self.modal.cycle.clone() else {
            let message = format!("CYCL DEF {} has no drilling cycle before it", p.name());
            return Err(p.fault(codes::STRUCTURE, message, "define the drilling cycle first"));
        };
        let mut values = Values { span: p.span, ..defined };
        for key in [200, 203, 204].map(Key::Q) {
            if let Some(value) = p.given.get(&key) {
                values.given.insert(key, value.clone());
            }
        }
        let count = |key: u32| {
            let value = p.value(key)?;
            if (1.0..=MAX_HOLES).contains(&value) && value.fract() == 0.0 {
                return Ok(value as u32);
            }
            let message = format!("the pattern has {value} holes in a row");
            Err(p.fault(codes::ARGUMENTS, message, "write a whole number from 1"))
        };
        let mut points = Vec::new();
        if p.name() == "220" {
            let center = [p.value(216)?, p.value(217)?];
            let radius = 0.5 * p.value(244)?;
            let (start, stop) = (p.value(245)?, p.value(246)?);
            let holes = count(241)?;
            let step = match p.value(247)? {
                0.0 => {
                    let full = ((stop - start).abs() % 360.0) == 0.0;
                    (stop - start) / f64::from(if full { holes } else { (holes - 1).max(1) })
                }
                step => step,
            };
            if p.value(365)? != 0.0 {
                let word = "Q365=1 (way between the holes on the circle)";
                return Err(super::lexer::refused(word, p.span, "write Q365=0"));
            }
            for i in 0..holes {
                let (s, c) = crate::frame::sin_cos_degrees(start + step * f64::from(i));
                points.push([center[0] + radius * c, center[1] + radius * s]);
            }
        } else {
            let start = [p.value(225)?, p.value(226)?];
            let (du, dv) = (p.value(237)?, p.value(238)?);
            let (columns, rows) = (count(242)?, count(243)?);
            if f64::from(columns) * f64::from(rows) > MAX_HOLES {
                let message = "the pattern has more than 100 000 holes";
                return Err(p.fault(codes::ARGUMENTS, message, "check Q242 and Q243"));
            }
            let (s, c) = crate::frame::sin_cos_degrees(p.value(224)?);
            for row in 0..rows {
                for i in 0..columns {
                    // Every second row runs back.
                    let column = if row % 2 == 0 { i } else { columns - 1 - i };
                    let (a, b) = (f64::from(column) * du, f64::from(row) * dv);
                    points.push([start[0] + c * a - s * b, start[1] + s * a + c * b]);
                }
            }
        }
        // Between the holes the tool stays at the set-up clearance.
        let between_clear = p.value(301)? == 0.0;
        let last = points.len().saturating_sub(1);
        let second = values.given(204).cloned();
        for (i, point) in points.into_iter().enumerate() {
            if between_clear && i < last {
                values.put(204, 0.0);
            } else if let Some(second) = &second {
                values.given.insert(Key::Q(204), second.clone());
            }
            // The way to the first hole begins above the second clearance.
            if i == 0 {
                let surface = values.value(203)?;
                let high = match second {
                    Some(Given::Number(above)) => surface + above * values.length,
                    _ => surface,
                };
                self.lift_to(high.max(surface + values.value(200)?), p.span)?;
            }
            self.hole(&values, point, true)?;
        }
        Ok(())
    }

    /// Retracts along the tool axis where the tool is lower.
    fn lift_to(&mut self, height: f64, span: Span) -> Result<(), Fault> {
        let axis = self.modal.normal;
        if self.position.work.get(axis).is_some_and(|z| z >= height) {
            return Ok(());
        }
        let mut goal = super::motion::Goal { end: self.position.work, programmed: 1 << axis, tool_axis: None };
        goal.end.put(axis, height);
        self.straight(goal, true, span)
    }

    /// CYCL CALL PAT: the cycle at every point of PATTERN DEF; Z of a point lifts the surface.
    pub(crate) fn cycle_call_pattern(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        self.settle_contour(span)?;
        let Some(Cycle::Fixed(values)) = self.modal.cycle.clone() else {
            return Err(Fault::new(codes::STRUCTURE, span, "CYCL CALL PAT has no drilling cycle")
                .help("write CYCL DEF before it"));
        };
        if self.modal.pattern.is_empty() {
            return Err(
                Fault::new(codes::STRUCTURE, span, "CYCL CALL PAT has no pattern").help("write PATTERN DEF before it")
            );
        }
        super::takes::feed_and_functions(w, "CYCL CALL PAT", span)?;
        self.functions_before(w, span)?;
        // Without F the tool moves between the points with the feed in force; FMAX is rapid.
        let rapid = self.feed_word(w, span)? || self.technology.feed.is_none();
        for pattern in self.modal.pattern.clone() {
            for p in self.points_of(&pattern, span)? {
                self.hole(&Values { span, lift: p[2], ..values.clone() }, [p[0], p[1]], rapid)?;
            }
        }
        self.functions_after(w, span)?;
        self.functions_last(w);
        Ok(())
    }

    /// Points of PATTERN DEF, mm: X and Y in the plane, Z that lifts the surface.
    ///
    /// HEIDENHAIN, *TNC 640 Programming of machining cycles*, "Pattern definition PATTERN DEF": rows and
    /// grids turn about their first point, D of a circle is its diameter.
    fn points_of(&mut self, pattern: &Pattern, span: Span) -> Result<Vec<[f64; 3]>, Fault> {
        let unit = self.modal.unit();
        let value = |word: &str| {
            let found = pattern.values.iter().find(|(other, _)| *other == word);
            found.map_or(Ok(0.0), |(_, value)| self.variables.value(*value, span))
        };
        let count = |word: &str| {
            let count = value(word)?;
            if count.fract() == 0.0 && (1.0..=MAX_HOLES).contains(&count) {
                return Ok(count as u32);
            }
            let message = format!("{word} of PATTERN DEF takes a whole number from 1 and has {count}");
            Err(Fault::new(codes::BAD_VALUE, span, message).help("write the number of points"))
        };
        let start = [value("X")? * unit, value("Y")? * unit, value("Z")? * unit];
        let at = |degrees: f64, a: f64, b: f64| {
            let (s, c) = crate::frame::sin_cos_degrees(degrees);
            [start[0] + c * a - s * b, start[1] + s * a + c * b, start[2]]
        };
        let points = match pattern.kind {
            PatternKind::Point => vec![start],
            PatternKind::Row => {
                let (turn, step) = (value("ROT")?, value("D")? * unit);
                (0..count("NUM")?).map(|i| at(turn, f64::from(i) * step, 0.0)).collect()
            }
            PatternKind::Circle | PatternKind::Sector => {
                let (holes, radius, from) = (count("NUM")?, 0.5 * value("D")? * unit, value("START")?);
                let step = if pattern.kind == PatternKind::Circle { 360.0 / f64::from(holes) } else { value("STEP")? };
                (0..holes).map(|i| at(from + f64::from(i) * step, radius, 0.0)).collect()
            }
            PatternKind::Grid | PatternKind::Frame => {
                if value("ROTX")? != 0.0 || value("ROTY")? != 0.0 {
                    return Err(super::lexer::refused(
                        "PATTERN DEF with ROTX or ROTY (a sheared grid)",
                        pattern.span,
                        "write the points as POS1 ( X.. Y.. Z.. )",
                    ));
                }
                let (columns, rows, turn) = (count("NUMX")?, count("NUMY")?, value("ROT")?);
                let (du, dv) = (value("DX")? * unit, value("DY")? * unit);
                if f64::from(columns) * f64::from(rows) > MAX_HOLES {
                    return Err(Fault::new(codes::ARGUMENTS, span, "the pattern has more than 100 000 points")
                        .help("check NUMX and NUMY"));
                }
                let edge = |row: u32, column: u32| row == 0 || row + 1 == rows || column == 0 || column + 1 == columns;
                let all = (0..rows)
                    .flat_map(|row| (0..columns).map(move |i| (row, if row % 2 == 0 { i } else { columns - 1 - i })));
                all.filter(|&(row, column)| pattern.kind == PatternKind::Grid || edge(row, column))
                    .map(|(row, column)| at(turn, f64::from(column) * du, f64::from(row) * dv))
                    .collect()
            }
        };
        if matches!(pattern.kind, PatternKind::Grid | PatternKind::Frame) {
            self.assume(
                "PATTERN DEF PAT and FRAME: the points are machined row by row along the first direction, in \
                 alternating directions",
            );
        }
        Ok(points)
    }
}
