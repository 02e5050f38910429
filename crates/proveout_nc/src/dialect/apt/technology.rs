//! Feed, spindle, tool, coolant, texts, stops.

use super::reader::{AptReader, INCH, arity};
use super::statement::{AptStatement, Bad, Item, Token};
use crate::channel::direction_of;
use crate::codes;
use crate::source::Source;
use crate::{CompSide, CutterComp, Dwell, Feed, Op, SpindleDirection, ToolName};

/// Unit of a feed value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FeedUnit {
    /// Per minute; the value is the unit length in mm.
    Minute(f64),
    /// Per revolution; the value is the unit length in mm.
    Revolution(f64),
}

impl AptReader {
    /// The feed unit of a word; PERMIN and PERREV are in the length unit of the text.
    pub(crate) fn feed_unit(&self, word: &str) -> Option<FeedUnit> {
        Some(match word {
            "MMPM" => FeedUnit::Minute(1.0),
            "IPM" => FeedUnit::Minute(INCH),
            "FPM" => FeedUnit::Minute(12.0 * INCH),
            "PERMIN" => FeedUnit::Minute(self.own.unit),
            "MMPR" => FeedUnit::Revolution(1.0),
            "IPR" => FeedUnit::Revolution(INCH),
            "PERREV" => FeedUnit::Revolution(self.own.unit),
            _ => return None,
        })
    }

    pub(crate) fn feed_of(&self, value: f64, unit: Option<FeedUnit>, item: &Item) -> Result<Feed, Box<Bad>> {
        if value <= 0.0 {
            let message = format!("a feed must be above zero and is {value}");
            return Err(item.place.bad(
                codes::BAD_VALUE,
                message,
                "write FEDRAT/100,MMPM, or RAPID for a rapid motion",
            ));
        }
        Ok(match unit.unwrap_or(FeedUnit::Minute(self.own.unit)) {
            FeedUnit::Minute(mm) => Feed::PerTime(value * mm / 60.0),
            FeedUnit::Revolution(mm) => Feed::PerRevolution(value * mm),
        })
    }

    pub(crate) fn feed_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let (mut value, mut unit) = (None, None);
        for item in &st.items {
            if item.token == Token::Word
                && let Some(found) = self.feed_unit(&Self::word(source, item))
            {
                unit = Some(found);
            } else if value.is_none() && !is_known_word(&Self::word(source, item)) {
                value = Some((self.number(source, item)?, item));
            } else {
                let message = format!("`{}` in FEDRAT is not supported", item.place.text(source));
                let help = "write FEDRAT/value with MMPM, IPM, PERMIN, MMPR, IPR or PERREV";
                return Err(item.place.bad(codes::UNSUPPORTED_WORD, message, help));
            }
        }
        let Some((value, item)) = value else {
            return Err(st.head.bad(codes::MISSING_VALUE, "FEDRAT has no value", "write FEDRAT/100,MMPM"));
        };
        let feed = self.feed_of(value, unit, item)?;
        self.set_feed(Some(feed));
        Ok(())
    }

    /// Words that are neither points nor coordinate systems.
    pub(crate) fn technology(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        match st.major.as_str() {
            "SPINDL" => self.spindle_statement(source, st),
            "COOLNT" => self.coolant_statement(source, st),
            "LOADTL" | "LOAD" => self.load_tool(source, st),
            "SELCTL" | "SELECTL" | "SELECT" => {
                let (number, _) = self.tool_number(source, st)?;
                self.emit(Op::Tool(crate::ToolAction::Select(number)));
                self.note_dimensions(source, st);
                Ok(())
            }
            "TOOL PATH" => {
                self.tool_path(source, st);
                Ok(())
            }
            "CUTCOM" => self.cutcom(source, st),
            "DELAY" => self.delay(source, st),
            "STOP" | "OPSTOP" => {
                self.emit(Op::Stop { optional: st.major == "OPSTOP" });
                Ok(())
            }
            "END" | "FINI" => {
                self.end_of_program();
                Ok(())
            }
            "PPRINT" => {
                self.emit(Op::Message(unquoted(st.literal.text(source)).to_owned()));
                Ok(())
            }
            "PARTNO" => {
                let text = unquoted(st.literal.text(source)).to_owned();
                self.note(format!("PARTNO {text}"));
                Ok(())
            }
            "INSERT" | "PPWORD" | "PPFUN" => self.post_text(source, st),
            "AUXFUN" => self.auxiliary(source, st),
            "PREFUN" => self.preparatory(source, st),
            other => {
                let message = format!("unknown word `{other}`");
                Err(st.head.bad(codes::UNKNOWN_WORD, message, "correct the word"))
            }
        }
    }

    /// SPINDL/[RPM,]speed[,RPM][,CLW], SPINDL/CLW, SPINDL/ON, SPINDL/OFF.
    fn spindle_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut direction = None;
        let mut speed = None;
        for item in &st.items {
            let word = Self::word(source, item);
            match word.as_str() {
                "OFF" | "STOP" => direction = Some(SpindleDirection::Off),
                "ON" => direction = Some(self.own.last_direction),
                "CLW" => direction = Some(SpindleDirection::Clockwise),
                "CCLW" => direction = Some(SpindleDirection::CounterClockwise),
                "RPM" | "NOTE" => {}
                "RANGE" | "LOW" | "MEDIUM" | "HIGH" | "AUTO" => self.note(format!("SPINDL {word}")),
                "SFM" | "SMM" | "MAXRPM" | "ORIENT" | "LOCK" | "LINTOL" => {
                    let message = format!("`{word}` in SPINDL is not supported");
                    return Err(item.place.bad(
                        codes::UNSUPPORTED_WORD,
                        message,
                        "give the speed in revolutions a minute, SPINDL/1000,RPM,CLW",
                    ));
                }
                _ if speed.is_none() => speed = Some((self.number(source, item)?, item)),
                _ => {
                    let message = format!("`{}` in SPINDL is not supported", item.place.text(source));
                    return Err(item.place.bad(codes::UNSUPPORTED_WORD, message, "write SPINDL/1000,RPM,CLW"));
                }
            }
        }
        if let Some((value, item)) = speed {
            if value < 0.0 {
                let message = format!("the spindle speed must not be negative and is {value}");
                return Err(item.place.bad(codes::BAD_VALUE, message, "give the direction with CLW or CCLW"));
            }
            self.technology.speed = Some(value);
        }
        // A speed alone starts the spindle, as SPINDL/ON does.
        self.technology.direction = match direction {
            Some(direction) => direction,
            None if speed.is_some() || st.items.is_empty() => self.own.last_direction,
            None => self.technology.direction,
        };
        if self.technology.direction != SpindleDirection::Off {
            self.own.last_direction = self.technology.direction;
        }
        self.tell_spindle();
        Ok(())
    }

    fn coolant_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut words: Vec<String> = st.items.iter().map(|i| Self::word(source, i)).collect();
        if words.is_empty() {
            words.push("ON".to_owned());
        }
        for word in words {
            match word.as_str() {
                "OFF" => self.technology.set_coolant(9),
                "ON" if self.technology.flood || self.technology.mist => {}
                "ON" | "FLOOD" => self.technology.set_coolant(8),
                "MIST" => self.technology.set_coolant(7),
                "THRU" | "TAPKUL" | "HIGH" | "MEDIUM" | "LOW" | "BOTH" => {
                    self.technology.set_coolant(8);
                    self.note(format!("COOLNT/{word} is taken as flood"));
                }
                "AIR" => self.note("COOLNT/AIR"),
                _ => {
                    let message = format!("the coolant `{word}` is not supported");
                    return Err(st.head.bad(codes::UNSUPPORTED_WORD, message, "write ON, OFF, FLOOD, MIST or THRU"));
                }
            }
        }
        self.tell_coolant();
        Ok(())
    }

    /// Number of a tool, and of its offset if the statement gives one.
    fn tool_number(&self, source: &Source, st: &AptStatement) -> Result<(ToolName, Option<u32>), Box<Bad>> {
        let skip = usize::from(st.items.first().is_some_and(|i| Self::word(source, i) == "TOOL"));
        let Some(item) = st.items.get(skip) else {
            let message = format!("{} has no tool number", st.major);
            return Err(st.head.bad(codes::MISSING_VALUE, message, "write LOADTL/5"));
        };
        if item.token == Token::Word && item.place.text(source).starts_with(['\'', '"']) {
            return Ok((ToolName::Name(unquoted(item.place.text(source)).to_owned()), None));
        }
        let whole = |item: &Item| -> Result<u32, Box<Bad>> {
            let value = self.number(source, item)?;
            if !(0.0..=f64::from(u32::MAX)).contains(&value) || value.fract() != 0.0 {
                let message = format!("a tool number must be a whole number and is {value}");
                return Err(item.place.bad(codes::BAD_VALUE, message, "write LOADTL/5"));
            }
            Ok(value as u32)
        };
        let number = whole(item)?;
        let mut edge = None;
        let mut rest = st.items[skip + 1..].iter();
        while let Some(item) = rest.next() {
            if matches!(Self::word(source, item).as_str(), "ADJUST" | "OSETNO" | "OFSTNO")
                && let Some(value) = rest.next()
            {
                edge = Some(whole(value)?);
            }
        }
        let name = if number == 0 { ToolName::Empty } else { ToolName::Number(number) };
        Ok((name, edge))
    }

    fn load_tool(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let (tool, edge) = self.tool_number(source, st)?;
        self.own.tool_loaded = true;
        self.own.pending_tool = None;
        self.load_into_spindle(tool, edge.unwrap_or(1));
        self.note_dimensions(source, st);
        Ok(())
    }

    /// Notes the items of a tool statement other than the tool and its offset: the tool library
    /// gives dimensions.
    fn note_dimensions(&mut self, source: &Source, st: &AptStatement) {
        let dimensions = super::items::dimensions_of_tool(source, st);
        if !dimensions.is_empty() {
            self.note(format!(
                "{}: {} without effect, the tool library gives dimensions",
                st.major,
                dimensions.join(",")
            ));
        }
    }

    /// TOOL PATH/operation,TOOL,name: the tool of an NX operation, where the program loads none by number.
    fn tool_path(&mut self, source: &Source, st: &AptStatement) {
        let name =
            st.items.iter().skip(1).position(|i| Self::word(source, i) == "TOOL").and_then(|at| st.items.get(at + 2));
        let name = name.map(|i| unquoted(i.place.text(source)).to_owned());
        if let Some(name) = name.filter(|name| self.own.path_tool.as_ref() != Some(name)) {
            if !self.own.tool_loaded {
                self.own.pending_tool = Some(name.clone());
            }
            self.own.path_tool = Some(name);
        }
        let operation = st.items.first().map_or("", |i| i.place.text(source));
        self.note(format!("TOOL PATH/{operation}"));
    }

    /// CUTCOM/LEFT|RIGHT|ON|OFF[,offset][,XYPLAN].
    fn cutcom(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut side = None;
        let mut offset = None;
        for item in &st.items {
            match Self::word(source, item).as_str() {
                "LEFT" => side = Some(CompSide::Left),
                "RIGHT" => side = Some(CompSide::Right),
                "OFF" => side = Some(CompSide::Off),
                // Autodesk's posts announce LEFT or RIGHT of the next statement.
                "ON" => {
                    self.note("CUTCOM/ON");
                    return Ok(());
                }
                "XYPLAN" | "OSETNO" | "OFSTNO" | "ADJUST" => {}
                _ if item.token != Token::Word => {
                    let value = self.number(source, item)?;
                    if value < 0.0 || value.fract() != 0.0 {
                        let message = format!("the offset of CUTCOM is a whole number and not {value}");
                        return Err(item.place.bad(codes::BAD_VALUE, message, "write CUTCOM/LEFT,1"));
                    }
                    offset = Some(value as u32);
                }
                word => {
                    let message = format!("`CUTCOM/{word}` is not supported");
                    return Err(item.place.bad(codes::UNSUPPORTED_WORD, message, "write CUTCOM/LEFT, RIGHT or OFF"));
                }
            }
        }
        let Some(side) = side else {
            return Err(st.head.bad(codes::MISSING_VALUE, "CUTCOM names no side", "write CUTCOM/LEFT, RIGHT or OFF"));
        };
        let named = st.items.last().map(|item| Self::word(source, item)).unwrap_or_default();
        if matches!(named.as_str(), "OSETNO" | "OFSTNO" | "ADJUST") {
            return Err(st.head.bad(
                codes::MISSING_VALUE,
                format!("`{named}` has no value"),
                "write the offset after it",
            ));
        }
        self.own.side = side;
        self.emit(Op::CutterComp(CutterComp { side, offset, radius: None }));
        Ok(())
    }

    /// DELAY/seconds, DELAY/revolutions,REV.
    fn delay(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let (mut value, mut revolutions) = (None, false);
        for item in &st.items {
            match Self::word(source, item).as_str() {
                "REV" => revolutions = true,
                "SEC" => {}
                _ => value = Some((self.number(source, item)?, item)),
            }
        }
        let Some((value, item)) = value else {
            return Err(st.head.bad(codes::MISSING_VALUE, "DELAY has no value", "write DELAY/2 for two seconds"));
        };
        if value < 0.0 {
            let message = format!("a dwell must not be negative and is {value}");
            return Err(item.place.bad(codes::BAD_VALUE, message, "write DELAY/2 for two seconds"));
        }
        self.emit(Op::Dwell(if revolutions { Dwell::Revolutions(value) } else { Dwell::Seconds(value) }));
        Ok(())
    }

    /// AUXFUN/n: M word.
    fn auxiliary(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut n = [0.0; 1];
        let count = self.numbers(source, st, &mut n)?;
        if count != 1 {
            return Err(arity(st.head, "AUXFUN", count, "one number"));
        }
        match n[0] {
            0.0 => self.emit(Op::Stop { optional: false }),
            1.0 => self.emit(Op::Stop { optional: true }),
            2.0 | 30.0 => self.end_of_program(),
            3.0..=5.0 => self.spindle(direction_of(n[0])),
            6.0 => {
                return Err(st.head.bad(
                    codes::UNSUPPORTED_WORD,
                    "`AUXFUN/6` is not supported",
                    "change the tool with LOADTL",
                ));
            }
            7.0 => self.coolant(7),
            8.0 => self.coolant(8),
            7.0..=9.0 => self.coolant(9),
            code => self.note(format!("M{code}")),
        }
        Ok(())
    }

    /// PREFUN/n: G word; work offsets are read.
    fn preparatory(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut n = [0.0; 1];
        let count = self.numbers(source, st, &mut n)?;
        let whole = n[0].fract() == 0.0;
        if count == 1 && whole && matches!(n[0] as i64, 54..=59 | 500 | 505..=599) {
            self.work_offset(&format!("G{}", n[0]));
            return Ok(());
        }
        Err(st.head.bad(
            codes::UNSUPPORTED_WORD,
            format!("`PREFUN/{}` is not supported", n[0]),
            "only work offsets (54 to 59, 500, 505 to 599) can be called as G words",
        ))
    }
}

/// Words that some posts write in FEDRAT and that are not numbers.
fn is_known_word(word: &str) -> bool {
    matches!(word, "INVERS" | "LENGTH" | "MAXIPM" | "SCALE" | "LOCK" | "OFF" | "ON" | "RAPID" | "AUTO" | "LAST")
}

/// Text without the quotation marks around it.
pub(crate) fn unquoted(text: &str) -> &str {
    let text = text.trim();
    for quote in ['\'', '"'] {
        if let Some(inner) = text.strip_prefix(quote).and_then(|rest| rest.strip_suffix(quote)) {
            return inner;
        }
    }
    text
}
