//! Definition and call of cycles.

use std::collections::BTreeMap;

use super::drilling::check_hole;
use super::interpreter::Interpreter;
use super::plane::{Tilt, Way};
use super::words::{Coordinate, CycleValue, Kind, OldWord, Param, Positioning, Reference, Words};
use crate::codes;
use crate::control::Meaning;
use crate::control::words::ListedWord;
use crate::cycle::{CycleSpec, Given, Key, Values, heidenhain as table};
use crate::diagnostic::{Fault, Span};
use crate::dialect::listed::refused_by;
use crate::frame::Frame;
use crate::{AxisValues, Dwell, Feed, Location, Op, PathMode};

/// The cycle that a call runs.
#[derive(Clone, Debug)]
pub(crate) enum Cycle {
    /// Drilling or milling cycle with its parameters.
    Fixed(Values),
    /// Cycle 12: a program.
    Program(String),
}

/// A cycle in the old form, collected until its last block.
#[derive(Debug)]
pub(crate) struct OldCycle {
    number: u32,
    words: Vec<(u32, OldWord)>,
    location: Location,
    span: Span,
}

impl Interpreter {
    /// Finishes everything that waits for a next block: at the end of a program, at calls.
    pub(crate) fn settle(&mut self) -> Result<(), Fault> {
        self.finish_old_cycle()?;
        self.settle_contour(Span::default())
    }

    /// Refuses a corner, an approach or a free contour that still waits for its next element.
    pub(crate) fn settle_contour(&mut self, span: Span) -> Result<(), Fault> {
        if let Some(fault) = self.free_is_open(span) {
            return Err(fault);
        }
        if self.modal.corner.is_some() {
            return Err(super::corner::no_element(span));
        }
        if self.modal.approach.is_some() {
            return Err(super::approach::no_contour(span));
        }
        self.modal.held = false;
        Ok(())
    }

    pub(crate) fn old_cycle(&mut self, number: u32, part: u32, words: Vec<OldWord>, span: Span) -> Result<(), Fault> {
        if part == 0 {
            self.finish_old_cycle()?;
            self.modal.pending_cycle =
                Some(OldCycle { number, words: Vec::new(), location: self.location.clone(), span });
            return Ok(());
        }
        let location = self.location.clone();
        match &mut self.modal.pending_cycle {
            Some(cycle) if cycle.number == number => {
                cycle.words.extend(words.into_iter().map(|word| (part, word)));
                cycle.location = location;
                cycle.span = span;
                Ok(())
            }
            // DIN/ISO writes a cycle in one block.
            _ if self.own.din_now => self.din_cycle(number, words, span),
            _ => {
                Err(Fault::new(codes::STRUCTURE, span, format!("CYCL DEF {number}.{part} without CYCL DEF {number}.0"))
                    .help(format!("write CYCL DEF {number}.0 before it")))
            }
        }
    }

    fn din_cycle(&mut self, number: u32, words: Vec<OldWord>, span: Span) -> Result<(), Fault> {
        let words = words.into_iter().map(|word| (1, word)).collect();
        self.run_old_cycle(&OldCycle { number, words, location: self.location.clone(), span })
    }

    /// Executes a cycle in the old form when its last block has been read, with the place of that block.
    pub(crate) fn finish_old_cycle(&mut self) -> Result<(), Fault> {
        let Some(cycle) = self.modal.pending_cycle.take() else { return Ok(()) };
        self.settle_contour(cycle.span)?;
        let here = std::mem::replace(&mut self.location, cycle.location.clone());
        let result = self.run_old_cycle(&cycle);
        self.location = here;
        result.map_err(|fault| Fault {
            message: format!("CYCL DEF {} (line {}): {}", cycle.number, cycle.location.line, fault.message),
            ..fault
        })
    }

    /// Words of a cycle as coordinates by axis letter, `IX` as increment.
    fn axis_words(cycle: &OldCycle, span: Span) -> Result<Words, Fault> {
        let mut w = Words::default();
        for (_, word) in &cycle.words {
            let (name, reference) = match word.name.strip_prefix('I') {
                Some(rest) if !rest.is_empty() => (rest, Reference::Incremental),
                _ => (word.name.as_str(), Reference::Absolute),
            };
            let mut letters = name.chars();
            let axis = letters.next().and_then(AxisValues::index).filter(|_| letters.next().is_none());
            let (Some(axis), Some(value)) = (axis, word.value) else {
                return Err(super::lexer::unknown(&word.name, span));
            };
            w.axes[axis] = Some(Coordinate { value, reference });
            w.programmed |= 1 << axis;
        }
        Ok(w)
    }

    fn run_old_cycle(&mut self, cycle: &OldCycle) -> Result<(), Fault> {
        let span = cycle.span;
        super::takes::old_cycle(cycle.number, &cycle.words)?;
        let find = |names: &[&str]| cycle.words.iter().find(|(_, w)| names.contains(&w.name.as_str())).map(|(_, w)| w);
        let last =
            |part: u32| cycle.words.iter().rfind(|(p, w)| *p == part && w.value.is_some()).and_then(|(_, w)| w.value);
        let number = |this: &Self, part: u32, what: &str| -> Result<f64, Fault> {
            let value = last(part).ok_or_else(|| {
                Fault::new(codes::MISSING_VALUE, span, format!("{what} is missing"))
                    .help(format!("write CYCL DEF {}.{part}", cycle.number))
            })?;
            this.variables.value(value, span)
        };
        match cycle.number {
            7 => {
                if let Some(row) = find(&["#"]).and_then(|w| w.value) {
                    let row = self.variables.value(row, span)?;
                    return self.datum_row(row, span);
                }
                let w = Self::axis_words(cycle, span)?;
                self.shift(&w, "CYCL DEF 7", span)
            }
            8 => {
                let mut axes = 0u16;
                for (_, word) in &cycle.words {
                    for letter in word.name.chars() {
                        let Some(axis) = AxisValues::index(letter) else {
                            return Err(super::lexer::unknown(&word.name, span));
                        };
                        axes |= 1 << axis;
                    }
                }
                self.mirror(axes, "CYCL DEF 8", span)
            }
            9 => {
                let seconds = number(self, 1, "the dwell")?;
                if seconds.is_nan() || seconds < 0.0 {
                    return Err(
                        Fault::new(codes::BAD_VALUE, span, "the dwell must not be negative").help("write seconds")
                    );
                }
                self.emit(Op::Dwell(Dwell::Seconds(seconds)));
                Ok(())
            }
            10 => {
                let word = find(&["ROT", "IROT"]).ok_or_else(|| {
                    Fault::new(codes::MISSING_VALUE, span, "the rotation has no angle")
                        .help("write CYCL DEF 10.1 ROT+35")
                })?;
                let reference = if word.name == "IROT" { Reference::Incremental } else { Reference::Absolute };
                let Some(value) = word.value else {
                    return Err(
                        Fault::new(codes::MISSING_VALUE, span, "the rotation has no angle").help("write ROT+35")
                    );
                };
                self.rotation(Coordinate { value, reference }, "CYCL DEF 10", span)
            }
            11 => {
                let factor = number(self, 1, "the scale factor")?;
                self.scale([factor; 3], [0.0; 3], false, "CYCL DEF 11", span)
            }
            13 => {
                self.note("CYCL DEF 13");
                Ok(())
            }
            19 => self.working_plane(cycle),
            26 => self.axis_scale(cycle),
            32 => self.tolerance(cycle),
            247 => {
                let row = number(self, 1, "the row of the preset table")?;
                self.preset(row, span)
            }
            1 | 2 | 17 => self.old_drilling(cycle, number),
            4 | 5 => self.old_pocket(cycle),
            other => Err(super::lexer::refused(&format!("CYCL DEF {other}"), span, "write its motions with L blocks")),
        }
    }

    /// Cycle 19: spatial angles; without angles, or with all zero, the plane ends. With F the rotary axes
    /// turn, and the linear ones follow so that the tip of the tool, made longer by the set-up clearance,
    /// stays on the workpiece.
    fn working_plane(&mut self, cycle: &OldCycle) -> Result<(), Fault> {
        let span = cycle.span;
        let mut angles = [0.0; 3];
        let (mut feed, mut ahead) = (None, 0.0);
        for (_, word) in &cycle.words {
            match (word.name.as_str(), word.value) {
                ("A" | "B" | "C", Some(value)) => {
                    let axis = AxisValues::index(word.name.chars().next().unwrap_or('A')).unwrap_or(3) - 3;
                    angles[axis] = self.variables.value(value, span)?;
                }
                ("F", Some(value)) => feed = Some(super::words::FeedWord::Value(value)),
                ("FMAX", None) => feed = Some(super::words::FeedWord::Max),
                ("DIST" | "ABST" | "SET" | "UP" | "SETUP" | "SET-UP" | "S-ABST", value) => {
                    if let Some(value) = value {
                        ahead = self.variables.value(value, span)? * self.modal.unit();
                    }
                }
                (name, _) => return Err(super::lexer::unknown(name, span)),
            }
        }
        let solution = self.usual_solution();
        // Without a feed the control turns no axis, and the clearance has no effect.
        if feed.is_none() && ahead != 0.0 {
            self.note("the set-up clearance of CYCL DEF 19 has no effect: without F the control turns no axis");
        }
        let way = match feed {
            Some(_) => Way { positioning: Positioning::Move, ahead, feed, solution },
            None => Way { positioning: Positioning::Stay, ahead: 0.0, feed, solution },
        };
        if angles == [0.0; 3] {
            return self.plane_reset(way, "CYCL DEF 19", span);
        }
        let tilt = Tilt { frame: Frame::rpy(angles), relative: false, axes: [None; 3] };
        self.tilt(tilt, way, "CYCL DEF 19", span)
    }

    /// Cycle 26: factors of the axes about a center.
    fn axis_scale(&mut self, cycle: &OldCycle) -> Result<(), Fault> {
        let (mut factors, mut center) = ([1.0; 3], [0.0; 3]);
        for (_, word) in &cycle.words {
            let Some(value) = word.value else { return Err(super::lexer::unknown(&word.name, cycle.span)) };
            let value = self.variables.value(value, cycle.span)?;
            let (list, letter, factor) = match word.name.strip_prefix("CC") {
                Some(letter) => (&mut center, letter, self.modal.unit()),
                None => (&mut factors, word.name.as_str(), 1.0),
            };
            let axis = match letter {
                "X" => 0,
                "Y" => 1,
                "Z" => 2,
                _ => return Err(super::lexer::unknown(&word.name, cycle.span)),
            };
            list[axis] = value * factor;
        }
        self.scale(factors, center, true, "CYCL DEF 26", cycle.span)
    }

    /// Cycle 32: T tolerance of the contour, TA of the rotary axes in degrees.
    fn tolerance(&mut self, cycle: &OldCycle) -> Result<(), Fault> {
        let mut mode = (None, None);
        for (_, word) in &cycle.words {
            let Some(value) = word.value else { continue };
            let value = self.variables.value(value, cycle.span)?;
            match word.name.as_str() {
                "T" => mode.0 = Some(value * self.modal.unit()),
                "TA" => mode.1 = Some(value.to_radians()),
                "HSC-MODE" => self.note(format!("CYCL DEF 32 HSC-MODE:{value}")),
                name => return Err(super::lexer::unknown(name, cycle.span)),
            }
        }
        self.path_tolerance(mode.0, mode.1, cycle.span)
    }

    pub(crate) fn path_tolerance(
        &mut self,
        tolerance: Option<f64>,
        angle: Option<f64>,
        span: Span,
    ) -> Result<(), Fault> {
        if [tolerance, angle].into_iter().flatten().any(|v| !(v >= 0.0 && v.is_finite())) {
            return Err(Fault::new(codes::BAD_VALUE, span, "a tolerance must not be negative").help("write T0.02"));
        }
        // T0 selects the default tolerance of the control, as a block without a value does.
        let tolerance = tolerance.filter(|t| *t > 0.0);
        self.emit(Op::PathMode(PathMode::Continuous { tolerance, orientation_tolerance: angle.filter(|a| *a > 0.0) }));
        Ok(())
    }

    /// Cycles 1 (pecking), 2 (tapping with compensating chuck), 17 (rigid tapping): planes count from the
    /// position.
    fn old_drilling(
        &mut self,
        cycle: &OldCycle,
        number: impl Fn(&Self, u32, &str) -> Result<f64, Fault>,
    ) -> Result<(), Fault> {
        let (spec, parts): (_, &[(u32, &str)]) = match cycle.number {
            1 => (&table::C1, &[(202, "the infeed"), (211, "the dwell"), (206, "the feed")]),
            2 => (&table::C2, &[(211, "the dwell"), (206, "the feed")]),
            _ => (&table::C17, &[(239, "the pitch")]),
        };
        let mut values = self.values_of(spec, BTreeMap::new(), cycle.span);
        values.put(200, number(self, 1, "the set-up clearance")?.abs());
        values.put(201, number(self, 2, "the depth")?);
        for (part, (key, what)) in (3..).zip(parts) {
            values.put(*key, number(self, part, what)?);
        }
        self.define_cycle(Cycle::Fixed(values));
        Ok(())
    }

    /// Cycles 4 (rectangular pocket about the tool) and 5 (circular pocket): planes count from the position,
    /// too.
    ///
    /// ```text
    ///   4.1 SET UP 2   4.2 DEPTH -10   4.3 PECKG 4 F80   4.4 X80   4.5 Y40   4.6 F200 DR+ RADIUS 10
    ///   5.1 SET UP 2   5.2 DEPTH -10   5.3 PECKG 4 F80   5.4 RADIUS 35       5.5 F200 DR+
    /// ```
    fn old_pocket(&mut self, cycle: &OldCycle) -> Result<(), Fault> {
        let number = cycle.number;
        let words = || cycle.words.iter();
        // The value of a part: the one with this letter, or, without a letter, the first that is
        // not a feed.
        let value = |part: u32, letter: Option<&str>| -> Result<Option<f64>, Fault> {
            let wanted = |word: &&(u32, OldWord)| {
                word.0 == part
                    && word.1.value.is_some()
                    && letter.map_or(word.1.name != "F", |letter| word.1.name == letter)
            };
            words()
                .find(wanted)
                .and_then(|(_, word)| word.value)
                .map(|v| self.variables.value(v, cycle.span))
                .transpose()
        };
        let need = |part: u32, letter: Option<&str>, what: &str| -> Result<f64, Fault> {
            value(part, letter)?.ok_or_else(|| {
                Fault::new(codes::MISSING_VALUE, cycle.span, format!("{what} is missing"))
                    .help(format!("write CYCL DEF {number}.{part}"))
            })
        };
        let last = if number == 4 { 6 } else { 5 };
        let turn = words().find_map(|(_, word)| match word.name.as_str() {
            "DR+" => Some(1.0),
            "DR-" => Some(-1.0),
            _ => None,
        });
        let Some(turn) = turn else {
            return Err(Fault::new(codes::MISSING_VALUE, cycle.span, "the pocket has no direction of rotation")
                .help(format!("write DR+ or DR- in CYCL DEF {number}.{last}")));
        };
        let depth = need(2, None, "the depth")?;
        if depth == 0.0 {
            return Err(
                Fault::new(codes::BAD_VALUE, cycle.span, "the depth of the pocket is zero").help("write the depth")
            );
        }
        let spec = if number == 4 { &table::C4 } else { &table::C5 };
        let mut values = self.values_of(spec, BTreeMap::new(), cycle.span);
        values.put(200, need(1, None, "the set-up clearance")?.abs());
        values.put(201, depth);
        values.put(202, need(3, None, "the infeed")?.abs());
        values.put(206, need(3, Some("F"), "the feed of the infeed")?);
        values.put(207, need(last, Some("F"), "the feed")?);
        values.put(351, turn);
        if number == 4 {
            values.put(218, need(4, Some("X"), "the length")?);
            values.put(219, need(5, Some("Y"), "the width")?);
            values.put(220, value(6, Some("RADIUS"))?.or(value(6, Some("R"))?).unwrap_or(0.0));
        } else {
            values.put(223, 2.0 * need(4, None, "the radius")?);
        }
        self.assume(format!(
            "cycle {number}: rings from the inside out, one radius apart, joined by straight lines (the overlap factor is a machine parameter)"
        ));
        self.define_cycle(Cycle::Fixed(values));
        Ok(())
    }

    fn define_cycle(&mut self, cycle: Cycle) {
        self.modal.cycle = Some(cycle);
        self.modal.modal_cycle = false;
    }

    pub(crate) fn cycle_program(&mut self, name: String) {
        self.modal.pending_cycle = None;
        self.define_cycle(Cycle::Program(name));
    }

    /// CYCL DEF with Q parameters: values are evaluated now and assigned to the parameters.
    pub(crate) fn cycle(&mut self, number: u32, list: &[(Param, CycleValue, Span)], span: Span) -> Result<(), Fault> {
        let mut given = BTreeMap::new();
        for (param, value, at) in list {
            if param.kind != Kind::Global {
                return Err(
                    Fault::new(codes::SYNTAX, *at, "the parameters of a cycle are Q parameters").help("write Q200=2")
                );
            }
            let setting = match *value {
                CycleValue::Value(value) => {
                    let number = self.variables.value(value, *at)?;
                    self.variables.set(*param, number, *at)?;
                    Given::Number(number)
                }
                CycleValue::Max => Given::Max,
                CycleValue::Auto => Given::Auto,
                CycleValue::PerRevolution(value) => Given::PerRevolution(self.variables.value(value, *at)?),
            };
            given.insert(Key::Q(param.index), setting);
        }
        let Some(spec) = table::spec(number) else { return self.builder_cycle(number, span) };
        let values = self.values_of(spec, given, span);
        match number {
            247 => {
                let row = values.value(339)?;
                return self.preset(row, span);
            }
            220 | 221 => return self.pattern_cycle(&values),
            _ if super::milling::is_milling(spec.name) => self.check_milling(&values)?,
            _ => {
                check_hole(&values)?;
                if number == 204 {
                    self.assume("cycle 204: the bar comes down out of the counterbore in the feed Q253");
                }
            }
        }
        self.define_cycle(Cycle::Fixed(values));
        Ok(())
    }

    fn values_of(&self, spec: &'static CycleSpec, given: BTreeMap<Key, Given>, span: Span) -> Values {
        Values { spec, given, length: self.modal.unit(), lift: 0.0, span }
    }

    /// A cycle of the machine builder, as defined by the control file.
    fn builder_cycle(&mut self, number: u32, span: Span) -> Result<(), Fault> {
        let word = format!("CYCL{number}");
        let control = std::sync::Arc::clone(&self.settings.control);
        match control.words.name(&word) {
            None => {
                let message = format!("CYCL DEF {number} is a cycle of the machine builder: it is not supported");
                Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help(format!(
                    "say what it means in the control file: [words.{word}] with note, ignore, message or refuse"
                )))
            }
            Some((_, ListedWord { meaning: Meaning::Refuse(remedy), word, .. })) => {
                Err(refused_by(&control, word, span, remedy))
            }
            Some((at, _)) => {
                self.tell_listed(at, "");
                Ok(())
            }
        }
    }

    /// Feed of a cycle parameter; none means rapid.
    pub(crate) fn cycle_feed(&self, v: &Values, key: u32) -> Result<Option<Feed>, Fault> {
        let (number, per_revolution) = match v.given(key) {
            Some(Given::Number(number)) => (*number, false),
            Some(Given::PerRevolution(number)) => (*number, true),
            Some(Given::Max | Given::Text(_)) => return Ok(None),
            Some(Given::Auto) => return self.feed_of(super::words::FeedWord::Auto, v.span),
            None => return Err(v.missing(&table::parameter(key))),
        };
        if number.is_nan() || number <= 0.0 {
            let message = format!("the feed Q{key} must be above zero and is {number}");
            return Err(v.fault(codes::BAD_VALUE, message, "write a feed"));
        }
        Ok(Some(if per_revolution {
            Feed::PerRevolution(number * self.modal.unit())
        } else {
            Feed::PerTime(number * if self.modal.inch { 2.54 } else { 1.0 } / 60.0)
        }))
    }

    /// The same where the parameter is written.
    pub(crate) fn feed_if_written(&self, v: &Values, key: u32) -> Result<Option<Feed>, Fault> {
        if v.given(key).is_some() { self.cycle_feed(v, key) } else { Ok(None) }
    }

    /// Runs the defined cycle at the tool position.
    pub(crate) fn run_cycle(&mut self, span: Span) -> Result<(), Fault> {
        self.settle_contour(span)?;
        match self.modal.cycle.clone() {
            None => Err(Fault::new(codes::STRUCTURE, span, "a cycle is called, but none is defined")
                .help("write CYCL DEF before it")),
            Some(Cycle::Program(name)) => self.call_program(&name, span),
            Some(Cycle::Fixed(values)) => self.drill(&Values { span, ..values }),
        }
    }

    /// CYCL CALL POS X Y Z: to the point, the tool axis as an additional shift of the surface.
    pub(crate) fn cycle_call_pos(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        self.settle_contour(span)?;
        let Some(Cycle::Fixed(values)) = self.modal.cycle.clone() else {
            return Err(Fault::new(codes::STRUCTURE, span, "CYCL CALL POS has no drilling cycle")
                .help("write CYCL DEF before it"));
        };
        let axes = self.modal.plane_axes();
        if !axes.iter().all(|a| w.programmed >> a & 1 == 1) {
            return Err(
                Fault::new(codes::MISSING_VALUE, span, "CYCL CALL POS needs X, Y and Z").help("write all three")
            );
        }
        super::takes::point_and_feed(w, "CYCL CALL POS", span)?;
        self.modal.modal_cycle = false;
        self.functions_before(w, span)?;
        let rapid = self.feed_word(w, span)?;
        let goal = self.goal(w, span)?;
        let [u, v, n] = axes;
        let lift = goal.end.get(n).unwrap_or(0.0);
        let point = [goal.end.get(u).unwrap_or(0.0), goal.end.get(v).unwrap_or(0.0)];
        self.hole(&Values { span, lift, ..values }, point, rapid)?;
        self.functions_after(w, span)?;
        self.functions_last(w);
        Ok(())
    }
}
