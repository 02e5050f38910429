//! Hole patterns: cycles 220 (circle) and 221 (rows), PATTERN DEF with CYCL CALL PAT.

use std::collections::BTreeMap;

use super::cycle::{Cycle, Setting};
use super::interpreter::Interpreter;
use super::words::{Pattern, PatternKind, Words};
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// Most holes of a pattern.
const MAX_HOLES: f64 = 100_000.0;

impl Interpreter {
    /// 220 and 221 run the drilling cycle before them at once; Q200, Q203, Q204 of the pattern replace those of the cycle.
    pub(crate) fn pattern_cycle(&mut self, pattern: u32, p: &BTreeMap<u32, Setting>, span: Span) -> Result<(), Fault> {
        self.settle_contour(span)?;
        let Some(Cycle::Drilling { number, mut values }) = self.modal.cycle.clone() else {
            return Err(Fault::new(
                codes::STRUCTURE,
                span,
                format!("CYCL DEF {pattern} has no drilling cycle before it"),
            )
            .help("define the drilling cycle first"));
        };
        for key in [200, 203, 204] {
            if let Some(value) = p.get(&key) {
                values.insert(key, *value);
            }
        }
        let unit = self.modal.unit();
        let need = |key: u32| self.cycle_number(p, key, None, span);
        let count = |value: f64| {
            if (1.0..=MAX_HOLES).contains(&value) && value.fract() == 0.0 {
                return Ok(value as u32);
            }
            Err(Fault::new(codes::ARGUMENTS, span, format!("the pattern has {value} holes in a row"))
                .help("write a whole number from 1"))
        };
        let mut points = Vec::new();
        let mut between_clear = false;
        if pattern == 220 {
            let center = [need(216)? * unit, need(217)? * unit];
            let radius = 0.5 * need(244)? * unit;
            let (start, stop) = (need(245)?, self.cycle_number(p, 246, Some(360.0), span)?);
            let holes = count(need(241)?)?;
            let step = match self.cycle_number(p, 247, Some(0.0), span)? {
                0.0 => {
                    let full = ((stop - start).abs() % 360.0) == 0.0;
                    (stop - start) / f64::from(if full { holes } else { (holes - 1).max(1) })
                }
                step => step,
            };
            if self.cycle_number(p, 365, Some(0.0), span)? != 0.0 {
                return Err(super::lexer::refused(
                    "Q365=1 (way between the holes on the circle)",
                    span,
                    "write Q365=0",
                ));
            }
            for i in 0..holes {
                let (s, c) = crate::frame::sin_cos_degrees(start + step * f64::from(i));
                points.push([center[0] + radius * c, center[1] + radius * s]);
            }
        } else {
            let start = [need(225)? * unit, need(226)? * unit];
            let (du, dv) = (need(237)? * unit, need(238)? * unit);
            let (columns, rows) = (count(need(242)?)?, count(need(243)?)?);
            if f64::from(columns) * f64::from(rows) > MAX_HOLES {
                return Err(Fault::new(codes::ARGUMENTS, span, "the pattern has more than 100 000 holes")
                    .help("check Q242 and Q243"));
            }
            let (s, c) = crate::frame::sin_cos_degrees(self.cycle_number(p, 224, Some(0.0), span)?);
            for row in 0..rows {
                for i in 0..columns {
                    // Every second row runs back.
                    let column = if row % 2 == 0 { i } else { columns - 1 - i };
                    let (a, b) = (f64::from(column) * du, f64::from(row) * dv);
                    points.push([start[0] + c * a - s * b, start[1] + s * a + c * b]);
                }
            }
        }
        if self.cycle_number(p, 301, Some(1.0), span)? == 0.0 {
            // Between the holes the tool stays at the set-up clearance.
            between_clear = true;
        }
        let last = points.len().saturating_sub(1);
        let second = values.get(&204).copied();
        for (i, point) in points.into_iter().enumerate() {
            if between_clear && i < last {
                values.insert(204, Setting::Number(0.0));
            } else if let Some(second) = second {
                values.insert(204, second);
            }
            // The way to the first hole begins above the second clearance.
            if i == 0 {
                let surface = self.cycle_number(&values, 203, Some(0.0), span)? * unit;
                let high = match second {
                    Some(Setting::Number(v)) => surface + v * unit,
                    _ => surface,
                };
                self.lift_to(high.max(surface + self.cycle_number(&values, 200, None, span)? * unit), span)?;
            }
            self.hole(number, &values, point, 0.0, true, span)?;
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
        let Some(Cycle::Drilling { number, values }) = self.modal.cycle.clone() else {
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
                self.hole(number, &values, [p[0], p[1]], p[2], rapid, span)?;
            }
        }
        self.functions_after(w, span)?;
        self.functions_last(w);
        Ok(())
    }

    /// Points of PATTERN DEF, mm: X and Y in the plane, Z that lifts the surface.
    ///
    /// HEIDENHAIN, *TNC 640 Programming of machining cycles*, "Pattern definition PATTERN DEF": rows and grids turn about their first
    /// point, D of a circle is its diameter.
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
