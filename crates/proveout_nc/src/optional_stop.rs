//! M1 with a spindle that turns: on many controls the stop ends the turning too, and a program that cuts on
//! without a new M3 or M4 depends on a switch of the operator.
//!
//! ```text
//!   M3 ... M1 ... G1      switch off: the spindle turns in G1     switch on: many controls have stopped it
//!   M3 ... M1 ... M3 G1   the same on both
//! ```
//!
//! The check looks at the commands that the reader emits, so that one rule holds for every
//! language.

use crate::{Command, Location, Note, Op, Spindle, SpindleDirection, ToolAction};

/// How the switch of the optional stop (M1) is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OptionalStop {
    /// Not known: a cut that depends on it is `assumed`.
    #[default]
    Unknown,
    /// M1 is passed as if it were not there.
    Off,
    /// M1 stops the program, and the spindle with it; it turns again with the next M3 or M4.
    On,
}

/// Follows the spindle from command to command.
#[derive(Clone, Debug, Default)]
pub(crate) struct StopWatch {
    switch: OptionalStop,
    turns: Option<Spindle>,
    /// The last M1 that met a turning spindle, with no spindle word after it.
    open: Option<Location>,
}

impl StopWatch {
    pub(crate) fn new(switch: OptionalStop) -> Self {
        Self { switch, ..Self::default() }
    }

    /// Returns what to insert before a command (an assumption) and after it (the spindle's stop).
    pub(crate) fn look(&mut self, command: &Command) -> [Option<Op>; 2] {
        match &command.op {
            Op::Spindle(spindle) => {
                self.turns = Some(*spindle).filter(|s| s.direction != SpindleDirection::Off);
                self.open = None;
            }
            Op::Tool(ToolAction::Change(_)) => self.open = None,
            Op::Stop { optional: true } => {
                let Some(spindle) = self.turns else { return [None, None] };
                match self.switch {
                    OptionalStop::Off => {}
                    OptionalStop::Unknown => self.open = Some(command.location.clone()),
                    OptionalStop::On => {
                        self.turns = None;
                        let stopped = Spindle { direction: SpindleDirection::Off, ..spindle };
                        return [None, Some(Op::Spindle(stopped))];
                    }
                }
            }
            Op::Linear(_) | Op::Arc(_) | Op::Spline(_) => return [self.assumption(), None],
            Op::Thread(thread) if thread.direction.is_none() => return [self.assumption(), None],
            _ => {}
        }
        [None, None]
    }

    fn assumption(&mut self) -> Option<Op> {
        let at = self.open.take()?;
        Some(Op::Note(Note::assuming(format!(
            "the spindle is taken as still turning after M1 of line {}: with the optional stop on, many \
             controls stop it there, and neither M3 nor M4 follows before this motion at feed rate; write M3 after \
             M1, or `optional_stop` of the program in the scene",
            at.line
        ))))
    }
}

#[cfg(test)]
mod tests {
    use crate::{ASSUMED, Dialect, Op, OptionalStop, Program, Settings, SpindleDirection};

    fn run(dialect: Dialect, text: &str, switch: OptionalStop) -> (usize, usize) {
        let settings = Settings { dialect, optional_stop: switch, ..Settings::default() };
        let all: Vec<Op> =
            Program::from_text("p", text, &settings).expect("opens").map(|c| c.expect("reads").op).collect();
        let assumed = all.iter().filter(|op| matches!(op, Op::Note(t) if t.starts_with(ASSUMED) && t.contains("M1")));
        let off = all.iter().filter(|op| matches!(op, Op::Spindle(s) if s.direction == SpindleDirection::Off));
        (assumed.count(), off.count())
    }

    #[test]
    fn a_cut_behind_m1_without_a_spindle_word_depends_on_the_switch_in_every_language() {
        for (dialect, head, cut, tail) in [
            (Dialect::Fanuc, "G21 G90 G94 S900 M3\nG0 X0. Y0. Z5.\n", "G1 X5. F100.\n", "M5\nM30\n"),
            (Dialect::Haas, "G21 G90 G94 S900 M3\nG0 X0. Y0. Z5.\n", "G1 X5. F100.\n", "M5\nM30\n"),
            (Dialect::LinuxCnc, "G21 G90 G94 S900 M3\nG0 X0 Y0 Z5\n", "G1 X5 F100\n", "M5\nM2\n"),
            (Dialect::Siemens840d, "G710 G90 G94 S900 M3\nG0 X0 Y0 Z5\n", "G1 X5 F100\n", "M5\nM30\n"),
        ] {
            for (between, assumed) in [
                ("M1\n", 1),
                ("M1\nM3\n", 0),
                ("M5\nM1\n", 0),
                ("M0\n", 0),
                ("M1\nG0 X1.\n", 1),
                ("M5\nM1\nM4\nM1\n", 1),
                ("", 0),
            ] {
                let text = format!("{head}{between}{cut}{cut}{tail}");
                let dialects = format!("{dialect:?} {between:?}");
                let (none, stops) = run(dialect, &text, OptionalStop::Off);
                assert_eq!(none, 0, "{dialects}");
                assert_eq!(run(dialect, &text, OptionalStop::Unknown), (assumed, stops), "{dialects}");
                let on = run(dialect, &text, OptionalStop::On);
                assert_eq!(on.0, 0, "{dialects}");
                assert_eq!(on.1 > stops, assumed > 0 || between == "M1\nM3\n", "{dialects}: {on:?}");
            }
        }
    }
}
