//! Cycles as tables: the parameters of a cycle are data, and one function reads and checks them.
//!
//! ```text
//!   CYCLE83(RTP, RFP, SDIS, ..)    Position 1, 2, 3 ..  ─┐
//!   CYCL DEF 205 Q200=2 ..         Q 200 ..              ├─► CycleSpec + what the program gives
//!   G83 Z-5. R2. Q1.               Letter                ─┘   = Values ─► the builder of its language
//! ```
//!
//! A [`CycleSpec`] holds the name of a cycle and its [`Parameter`]s: where each is written, what it
//! is called, what it measures and which value it has where the program leaves it out. [`Values`]
//! reads one parameter at a time, so that the first fault is the first parameter that the cycle
//! uses. A builder never counts arguments. The tables are [`siemens`], [`heidenhain`] and [`iso`]; the
//! README lists them, and a test holds its list to the tables. The words of an ISO cycle hold from block to
//! block, so that its reader keeps them itself and asks the table which a cycle takes and which it needs.

pub(crate) mod heidenhain;
pub(crate) mod iso;
pub(crate) mod siemens;
mod values;

pub(crate) use values::{Given, Values};

/// Where a parameter is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Key {
    /// Argument of a call, counted from 1.
    Position(u8),
    /// Number of a Q parameter.
    Q(u32),
    /// Letter of a word.
    Letter(u8),
}

/// What a parameter measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    /// A count, a choice, an angle in degrees, a time: taken as it is.
    Number,
    /// A coordinate or a distance with its sign, in the unit of the program.
    Length,
    /// A distance without its sign, in the unit of the program.
    Size,
    /// A feed.
    Feed,
    /// A name.
    Text,
    /// Shown by the editor of the control, and not read.
    Unread,
}

/// A parameter of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) key: Key,
    /// Name in the manual.
    pub(crate) name: &'static str,
    pub(crate) unit: Unit,
    /// What it is, for messages.
    pub(crate) what: &'static str,
    pub(crate) usual: Usual,
    /// The control always writes it into the definition of the cycle; an ISO cycle needs the word.
    pub(crate) written: bool,
}

/// What holds where a program does not write a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Usual {
    /// The cycle is refused where it needs the parameter.
    None,
    Value(f64),
}

/// A cycle and its parameters.
#[derive(Debug)]
pub(crate) struct CycleSpec {
    pub(crate) name: &'static str,
    pub(crate) parameters: &'static [Parameter],
    /// What is taken for granted of its course, where the manual leaves it open.
    pub(crate) assumed: Option<&'static str>,
}

#[cfg(test)]
mod tests {
    use super::{CycleSpec, Key, Unit, Usual, heidenhain, iso, siemens};

    fn row(spec: &CycleSpec) -> String {
        let names = spec.parameters.iter().map(|parameter| match (parameter.key, parameter.usual) {
            (Key::Position(_), _) if parameter.unit == Unit::Unread => format!("({})", parameter.name),
            (Key::Position(_), _) => parameter.name.to_owned(),
            (Key::Q(number), _) if parameter.written => format!("Q{number}"),
            (Key::Q(number), Usual::Value(value)) => format!("Q{number}={value}"),
            (Key::Q(number), Usual::None) => format!("Q{number}="),
            (Key::Letter(letter), _) => char::from(letter).to_string(),
        });
        format!("| `{}` | {} |", spec.name, names.collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn the_readme_lists_every_cycle() {
        let readme = include_str!("../../README.md");
        let section = readme.split("## Parameters of cycles\n").nth(1).unwrap().split("\n## ").next().unwrap();
        let listed: Vec<&str> = section.lines().filter(|line| line.starts_with("| `")).collect();
        let rows = siemens::ALL.iter().chain(heidenhain::ALL).map(|spec| row(spec));
        let rows: Vec<String> = rows.chain(iso::tests::rows()).collect();
        assert_eq!(listed, rows, "write into the README:\n{}", rows.join("\n"));
    }

    #[test]
    fn a_parameter_is_in_its_cycle_once() {
        for spec in siemens::ALL.iter().chain(heidenhain::ALL) {
            for (at, parameter) in spec.parameters.iter().enumerate() {
                assert!(!parameter.name.is_empty() || matches!(parameter.key, Key::Q(429 | 430)), "{}", spec.name);
                let again = spec.parameters[..at].iter().any(|other| other.key == parameter.key);
                assert!(!again, "{} {:?}", spec.name, parameter.key);
            }
        }
    }
}
