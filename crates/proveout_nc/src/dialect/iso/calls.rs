//! Subprograms and macros: M98 M97 M99, G65 G66 G67, O CALL.
//!
//! Sources: Fanuc, *Custom macro B* (argument specification I and II); `LinuxCNC`, *O codes*; Haas, *M97,
//! M98*.

use std::path::Path;
use std::sync::Arc;

use super::flavor::Flavor;
use super::parser::{CHAMFER, IsoBlock, ROUNDING};
use super::run_state::{CallKind, CallTarget, Interpreter, IsoCall, Loaded, MacroCall};
use super::statement::OLabel;
use crate::Op;
use crate::channel::ProgramSection;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::source::Mark;

/// Program, passes and arguments.
type MacroWords = (Option<f64>, Option<f64>, Vec<(u32, f64)>);

/// Endings of program files, in the order in which they are tried.
const ENDINGS: [&str; 13] = ["", "NC", "NGC", "CNC", "TAP", "PRG", "TXT", "EIA", "ISO", "SUB", "MIN", "SSB", "LIB"];

impl Interpreter {
    /// M98 (or M198) with the words P and L.
    pub(crate) fn call_sub(&mut self, program: Option<f64>, times: Option<f64>, span: Span) -> Result<(), Fault> {
        let Some(program) = program else {
            return Err(
                Fault::new(codes::MISSING_VALUE, span, "M98 has no P").help("write the program number: M98 P1000")
            );
        };
        let number = whole(program, "P", 99_999_999.0, span)?;
        let mut passes = count(times, span)?;
        let mut found = self.find_program(&number.to_string(), span)?;
        if self.own.flavor == Flavor::Fanuc && number > 9999 && times.is_none() {
            // The last four digits are the program, those before the number of passes.
            let split = self.find_program(&(number % 10_000).to_string(), span)?;
            if found.is_some() && split.is_some() {
                let message = format!(
                    "P{number} is program {number}, or {} times program {}: both are there",
                    number / 10_000,
                    number % 10_000
                );
                return Err(Fault::new(codes::CONFLICT, span, message).help("write the number of passes with L"));
            }
            if split.is_some() {
                found = split;
                passes = number / 10_000;
            }
        }
        let Some((loaded, section)) = found else { return self.missing(&format!("O{number}"), span) };
        if passes > 0 {
            self.enter_sub((loaded, section), section.start, passes, CallKind::Sub, span)?;
        }
        Ok(())
    }

    /// M97 P: from a block number of the same program to M99.
    pub(crate) fn call_local(&mut self, target: Option<f64>, times: Option<f64>, span: Span) -> Result<(), Fault> {
        let Some(target) = target else {
            return Err(Fault::new(codes::MISSING_VALUE, span, "M97 has no P").help("write the block number: M97 P100"));
        };
        let passes = count(times, span)?;
        let Some(level) = self.stack.last() else { return Ok(()) };
        let (loaded, section, cursor) = (Arc::clone(&level.loaded), level.section, level.cursor);
        let first = self.find_number(&loaded, cursor, target, span)?;
        if passes > 0 {
            self.enter_sub((loaded, section), first, passes, CallKind::Sub, span)?;
        }
        Ok(())
    }

    /// M99, with the block number of P.
    pub(crate) fn return_from_sub(&mut self, target: Option<f64>, span: Span) -> Result<(), Fault> {
        let Some(target) = target else {
            if self.stack.len() > 1 {
                return self.leave(span);
            }
            self.note("M99 in the main program: the control repeats the program; it is run once");
            self.end_of_program();
            return Ok(());
        };
        if self.stack.len() > 1 {
            if let Some(level) = self.stack.last_mut() {
                level.passes_left = 0;
            }
            self.leave(span)?;
        }
        let Some(level) = self.stack.last() else { return Ok(()) };
        let (loaded, cursor) = (Arc::clone(&level.loaded), level.cursor);
        // The cursor is after the call: a target before it is a jump back.
        self.goto_number(&loaded, cursor, target, span)
    }

    /// G65 and G66.
    pub(crate) fn macro_call(&mut self, block: &IsoBlock, modal: bool) -> Result<(), Fault> {
        let span = block.span;
        let (program, times, arguments) = self.macro_words(block, None)?;
        let Some(program) = program else {
            return Err(Fault::new(codes::MISSING_VALUE, span, "the macro call has no P").help("write G65 P9010"));
        };
        let program = CallTarget::Number(program);
        let (passes, names) = (count(times, span)?, Vec::new());
        let call = MacroCall { program, passes, arguments, names, depth: self.depth() };
        if modal {
            self.own.modal_macro = Some(call);
            return Ok(());
        }
        self.run_macro(&call, span)
    }

    /// A macro that a word of the control file calls: as G65, with the words of the block but this one and G
    /// words.
    pub(crate) fn call_macro(&mut self, program: f64, caller: &str, block: &IsoBlock) -> Result<(), Fault> {
        let (_, times, arguments) = self.macro_words(block, Some(caller))?;
        let (passes, names) = (count(times, block.span)?, Vec::new());
        let call = MacroCall { program: CallTarget::Number(program), passes, arguments, names, depth: self.depth() };
        self.run_macro(&call, block.span)
    }

    /// Program (P), passes (L) and arguments of a block that calls a macro; `caller` is the M word that does.
    fn macro_words(&self, block: &IsoBlock, caller: Option<&str>) -> Result<MacroWords, Fault> {
        let (mut program, mut times, mut arguments) = (None, None, Vec::new());
        let mut sets = [0u32; 3];
        for word in &block.words {
            let Some(value) = self.word_value(&word.value, word.span)? else { continue };
            let number = match word.letter {
                b'G' | b'N' | b'O' => continue,
                b'M' if caller.is_some_and(|caller| caller == format!("M{value}")) => continue,
                b'P' if caller.is_some() => {
                    return Err(Fault::new(codes::ARGUMENTS, word.span, "P is not an argument of a macro")
                        .help("pass the value with another letter"));
                }
                b'P' => {
                    program = Some(value);
                    continue;
                }
                b'L' => {
                    times = Some(value);
                    continue;
                }
                letter @ b'I'..=b'K' => {
                    // Argument specification II: further sets of I J K fill #7 and up.
                    let at = usize::from(letter - b'I');
                    let set = sets[at];
                    sets[at] += 1;
                    4 + at as u32 + 3 * set
                }
                CHAMFER | ROUNDING => return Err(super::corners::misplaced(block)),
                letter => argument_number(letter),
            };
            if number > 33 {
                return Err(Fault::new(codes::ARGUMENTS, word.span, "the macro call has more than ten sets of I J K")
                    .help("use the other letters"));
            }
            arguments.push((number, value));
        }
        Ok((program, times, arguments))
    }

    pub(crate) fn run_macro(&mut self, call: &MacroCall, span: Span) -> Result<(), Fault> {
        let name = match &call.program {
            CallTarget::Number(number) => whole(*number, "P", 99_999_999.0, span)?.to_string(),
            CallTarget::Name(name) => name.clone(),
        };
        let Some((loaded, section)) = self.find_program(&name, span)? else {
            return self.missing(&format!("O{}", name.trim_matches(['<', '>']).to_ascii_uppercase()), span);
        };
        if call.passes == 0 {
            return Ok(());
        }
        self.enter_sub((loaded, section), section.start, call.passes, CallKind::Macro, span)?;
        for &(number, value) in &call.arguments {
            self.variables.set(number, Some(value));
        }
        for (name, value) in &call.names {
            self.variables.set_named(name, *value);
        }
        Ok(())
    }

    /// CALL and MODIN of an Okuma: a program by the name of its head, with values of local variables.
    pub(super) fn call_with_names(
        &mut self,
        program: String,
        times: Option<f64>,
        names: Vec<(String, f64)>,
        modal: bool,
        span: Span,
    ) -> Result<(), Fault> {
        let (passes, program) = (count(times, span)?, CallTarget::Name(program));
        let call = MacroCall { program, passes, arguments: Vec::new(), names, depth: self.depth() };
        if modal {
            self.own.modal_macro = Some(call);
            return Ok(());
        }
        self.run_macro(&call, span)
    }

    /// Runs the modal macro after a block with a motion.
    pub(crate) fn after_motion(&mut self, span: Span) -> Result<(), Fault> {
        match self.own.modal_macro.take() {
            Some(call) if call.depth == self.depth() => {
                self.run_macro(&call, span)?;
                self.own.modal_macro = Some(call);
                Ok(())
            }
            other => {
                self.own.modal_macro = other;
                Ok(())
            }
        }
    }

    /// `o100 call [1] [2]`
    pub(crate) fn call_o_sub(
        &mut self,
        label: &OLabel,
        arguments: &[super::expr::Expr],
        span: Span,
    ) -> Result<(), Fault> {
        let name = match label {
            OLabel::Fixed(name) => name.clone(),
            OLabel::Computed(expr) => whole(self.number(expr, span)?, "the label", 999_999_999.0, span)?.to_string(),
        };
        if arguments.len() > 30 {
            let message = format!("the call of {name} has {} arguments; a subprogram takes 30", arguments.len());
            return Err(Fault::new(codes::ARGUMENTS, span, message).help("pass the others as global parameters"));
        }
        let mut values = Vec::with_capacity(arguments.len());
        for argument in arguments {
            values.push(self.number(argument, span)?);
        }
        let mut found = self.stack.iter().rev().find_map(|level| {
            level.loaded.index.subs.get(&name).map(|&(mark, section)| (Arc::clone(&level.loaded), mark, section))
        });
        if found.is_none()
            && let Some(loaded) = self.load_beside(name.trim_start_matches('<').trim_end_matches('>'), span)?
        {
            found = loaded.index.subs.get(&name).map(|&(mark, section)| (Arc::clone(&loaded), mark, section));
        }
        let Some((loaded, mark, section)) = found else { return self.missing(&format!("o{name}"), span) };
        let first = loaded.source.line(mark).map_or(mark, |(_, next)| next);
        self.enter_sub((loaded, section), first, 1, CallKind::OSub, span)?;
        // Arguments left out are zero, whatever a caller has in its parameters.
        for number in 1..=30 {
            let value = values.get(number as usize - 1).copied().unwrap_or(0.0);
            self.variables.set(number, Some(value));
        }
        Ok(())
    }

    /// `o100 return [5]`, `o100 endsub [5]`
    pub(crate) fn return_from_o_sub(&mut self, value: Option<f64>, span: Span) -> Result<(), Fault> {
        if self.stack.last().is_none_or(|level| level.own.kind != CallKind::OSub) {
            return Err(
                Fault::new(codes::STRUCTURE, span, "no subprogram of O words is running here").help("remove it")
            );
        }
        self.leave(span)?;
        self.variables.set_named("_value", value.unwrap_or(0.0));
        self.variables.set_named("_value_returned", f64::from(u8::from(value.is_some())));
        Ok(())
    }

    fn enter_sub(
        &mut self,
        program: (Arc<Loaded>, ProgramSection),
        first: Mark,
        passes: u32,
        kind: CallKind,
        span: Span,
    ) -> Result<(), Fault> {
        self.room_for_call("the subprogram is called", span)?;
        // Passes are jumps back: an empty subprogram called without end is stopped by their limit.
        self.count_pass(span)?;
        if matches!(kind, CallKind::Macro | CallKind::OSub) {
            self.variables.enter();
        }
        self.enter(program, first, passes, IsoCall::new(kind));
        Ok(())
    }

    /// The blocks from one number to another, so many times.
    pub(super) fn repeat_blocks(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        [first, last, passes]: [u32; 3],
        span: Span,
    ) -> Result<(), Fault> {
        if !self.settings.control.depth_in_i {
            return Err(Fault::new(codes::UNKNOWN_WORD, span, "`RPT` is a word of a Fagor")
                .help("name that control (fagor-8055), or call a subprogram"));
        }
        let start = self.find_number(loaded, at, f64::from(first), span)?;
        let end = self.find_number(loaded, start, f64::from(last), span)?;
        if end.offset < start.offset {
            let message = format!("block N{last} comes before N{first}");
            return Err(Fault::new(codes::JUMP_TARGET, span, message).help("write the first block first"));
        }
        if start.offset <= at.offset && at.offset <= end.offset {
            let message = format!("the blocks N{first} to N{last} hold their own repetition");
            return Err(Fault::new(codes::LOOP_LIMIT, span, message).help("write the repetition after them"));
        }
        let end = loaded.source.line(end).map_or(end, |(_, next)| next).offset;
        if passes > 0 {
            self.enter_sub((Arc::clone(loaded), ProgramSection { start, end }), start, passes, CallKind::Sub, span)?;
        }
        Ok(())
    }

    /// Leaves a subprogram, or begins its next pass.
    pub(crate) fn leave(&mut self, span: Span) -> Result<(), Fault> {
        if self.next_pass() {
            return self.count_pass(span);
        }
        let Some(level) = self.stack.pop() else { return Ok(()) };
        if matches!(level.own.kind, CallKind::Macro | CallKind::OSub) {
            self.variables.leave();
        }
        let depth = self.depth();
        if self.own.modal_macro.as_ref().is_some_and(|call| call.depth > depth) {
            self.own.modal_macro = None;
        }
        Ok(())
    }

    /// A program by its number or `<name>`: in the files of the call stack, then in the folders.
    fn find_program(&mut self, name: &str, span: Span) -> Result<Option<(Arc<Loaded>, ProgramSection)>, Fault> {
        for level in self.stack.iter().rev() {
            if let Some(section) = level.loaded.index.programs.get(name) {
                return Ok(Some((Arc::clone(&level.loaded), *section)));
            }
        }
        let file = if self.settings.control.osp_words { name.trim_matches(['<', '>']) } else { name };
        // The name of an Okuma program has its O in the name of the file as well.
        let named = file != name;
        let loaded = match self.load_beside(file, span)? {
            None if named => self.load_beside(&format!("o{file}"), span)?,
            found => found,
        };
        let Some(loaded) = loaded else { return Ok(None) };
        let section = loaded.index.programs.get(name).copied().or(loaded.index.main);
        Ok(section.map(|section| (loaded, section)))
    }

    /// A program file with this name or number in the folders of the program and of the settings.
    fn load_beside(&mut self, name: &str, span: Span) -> Result<Option<Arc<Loaded>>, Fault> {
        match self.file_beside(|path| rank(path, name)) {
            Some(path) => self.load(path, "subprogram", name, span).map(Some),
            None => Ok(None),
        }
    }

    /// Text for a stop by `#3006`.
    pub(crate) fn stop_with_message(&mut self, text: &str) {
        if !text.is_empty() {
            self.emit(Op::Message(text.to_owned()));
        }
        self.emit(Op::Stop { optional: false });
    }
}

/// Rank of a file among those of a program: `O1000`, `1000` or the name itself, with one of the usual
/// endings.
fn rank(path: &Path, name: &str) -> Option<usize> {
    let ending = path.extension().map_or(String::new(), |e| e.to_string_lossy().to_ascii_uppercase());
    let rank = ENDINGS.iter().position(|known| *known == ending)?;
    let stem = path.file_stem()?.to_string_lossy();
    let fits = if name.bytes().all(|b| b.is_ascii_digit()) {
        let digits = stem.strip_prefix(['O', 'o']).unwrap_or(&stem);
        !digits.is_empty()
            && digits.bytes().all(|b| b.is_ascii_digit())
            && digits.trim_start_matches('0') == name.trim_start_matches('0')
    } else {
        stem.eq_ignore_ascii_case(name)
    };
    (fits && path.is_file()).then_some(rank)
}

/// Local parameter of an argument letter (specification I).
fn argument_number(letter: u8) -> u32 {
    match letter {
        b'A' => 1,
        b'B' => 2,
        b'C' => 3,
        b'D' => 7,
        b'E' => 8,
        b'F' => 9,
        b'H' => 11,
        b'M' => 13,
        letter => u32::from(letter.saturating_sub(b'Q')) + 17,
    }
}

/// A whole number from 0 to a limit.
pub(crate) fn whole(value: f64, what: &str, limit: f64, span: Span) -> Result<u32, Fault> {
    if value.fract() == 0.0 && (0.0..=limit).contains(&value) {
        return Ok(value as u32);
    }
    Err(Fault::new(codes::BAD_VALUE, span, format!("{what} must be a whole number from 0 to {limit} and is {value}"))
        .help("write a whole number"))
}

/// Passes of L or K; one where none is given.
fn count(times: Option<f64>, span: Span) -> Result<u32, Fault> {
    times.map_or(Ok(1), |times| whole(times, "L", 9999.0, span))
}

pub(super) fn missing(name: &str, flavor: Flavor, span: Span) -> Fault {
    let control = match flavor {
        Flavor::LinuxCnc => "linuxcnc-2.9",
        Flavor::Fanuc | Flavor::Haas => "haas-ngc",
    };
    Fault::new(codes::SUBPROGRAM, span, format!("subprogram `{name}` not found"))
        .help(format!(
            "put {name} into the file of the program, or as a file into its folder; where it stays on the control, as probing does, a file for \
             --control leaves it out: inherits = \"{control}\" (the control's name), subprograms = {{ missing = \"note\", missing_reason = \"probing\" }}"
        ))
}
