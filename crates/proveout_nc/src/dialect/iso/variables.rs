//! Numbered and named parameters.

use std::collections::BTreeMap;

use super::flavor::Flavor;
use super::osp;

/// Highest number of a local parameter of macro B.
pub(crate) const MACRO_LOCALS: usize = 33;
/// Highest number of a local parameter of an O word subprogram.
const O_LOCALS: usize = 30;

#[derive(Clone, Debug)]
struct Locals {
    numbered: [Option<f64>; MACRO_LOCALS + 1],
    named: BTreeMap<String, f64>,
}

impl Locals {
    fn new() -> Self {
        Self { numbered: [None; MACRO_LOCALS + 1], named: BTreeMap::new() }
    }
}

/// Values of parameters; a numbered one without a value is vacant.
#[derive(Debug)]
pub(crate) struct MacroVariables {
    flavor: Flavor,
    levels: Vec<Locals>,
    common: BTreeMap<u32, f64>,
    globals: BTreeMap<String, f64>,
    /// From the settings, by upper-case name: `#500`, `#<_DEPTH>`.
    given: BTreeMap<String, f64>,
}

impl MacroVariables {
    pub(crate) fn new(flavor: Flavor, given: &BTreeMap<String, f64>) -> Self {
        Self {
            flavor,
            levels: vec![Locals::new()],
            common: BTreeMap::new(),
            globals: BTreeMap::new(),
            given: given.iter().map(|(name, &value)| (name.trim().to_ascii_uppercase(), value)).collect(),
        }
    }

    fn locals(&self) -> usize {
        if self.flavor.is_linuxcnc() { O_LOCALS } else { MACRO_LOCALS }
    }

    /// Value of a numbered parameter that the program set, or that the settings give.
    pub(crate) fn numbered(&self, number: u32) -> Option<f64> {
        let found = if (1..=self.locals()).contains(&(number as usize)) {
            self.levels.last().and_then(|level| level.numbered.get(number as usize).copied().flatten())
        } else {
            self.common.get(&number).copied()
        };
        let given = || match osp::common(number) {
            Some(common) => self.given.get(&format!("VC{common}")).copied(),
            None => self.given.get(&format!("#{number}")).copied(),
        };
        found.or_else(|| if self.given.is_empty() { None } else { given() })
    }

    pub(crate) fn is_local(&self, number: u32) -> bool {
        number as usize <= self.locals()
    }

    /// None takes the value away.
    pub(crate) fn set(&mut self, number: u32, value: Option<f64>) {
        if (1..=self.locals()).contains(&(number as usize)) {
            if let Some(slot) = self.levels.last_mut().and_then(|level| level.numbered.get_mut(number as usize)) {
                *slot = value;
            }
        } else if let Some(value) = value {
            self.common.insert(number, value);
        } else {
            self.common.remove(&number);
        }
    }

    /// Value of a named parameter; names that begin with `_` are global.
    pub(crate) fn named(&self, name: &str) -> Option<f64> {
        let found = if name.starts_with('_') {
            self.globals.get(name)
        } else {
            self.levels.last().and_then(|level| level.named.get(name))
        };
        found.or_else(|| self.given.get(&format!("#<{}>", name.to_ascii_uppercase()))).copied()
    }

    pub(crate) fn set_named(&mut self, name: &str, value: f64) {
        let map = if name.starts_with('_') {
            &mut self.globals
        } else {
            match self.levels.last_mut() {
                Some(level) => &mut level.named,
                None => return,
            }
        };
        map.insert(name.to_owned(), value);
    }

    /// A new level of local parameters.
    pub(crate) fn enter(&mut self) {
        self.levels.push(Locals::new());
    }

    pub(crate) fn leave(&mut self) {
        if self.levels.len() > 1 {
            self.levels.pop();
        }
    }
}
