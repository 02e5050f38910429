//! Cycles as tables: the parameters of a cycle are data, and one function reads and checks them.
//!
//! ```text
//!   CYCLE83(RTP, RFP, SDIS, ..)    Position 1, 2, 3 ..  ─┐
//!   CYCL DEF 205 Q200=2 ..         Q 200 ..              ├─► CycleSpec + what the program gives = Values ─► the builder of its language
//!   G83 Z-5. R2. Q1.               Letter                ─┘
//! ```
//!
//! A [`CycleSpec`] holds the name of a cycle and its [`Parameter`]s: where each is written, what it
//! is called, what it measures and which value it has where the program leaves it out. [`Values`]
//! reads one parameter at a time, so that the first fault is the first parameter that the cycle
//! uses. A builder never counts arguments. The tables are [`siemens`] and [`heidenhain`]; the
//! README lists them as [`rows`] prints them.

pub(crate) mod heidenhain;
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
    /// The control always writes it into the definition of the cycle.
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
