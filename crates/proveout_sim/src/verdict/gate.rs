//! The eight gates, and tables with one entry per gate.

use std::{
    fmt,
    ops::{Index, IndexMut},
};

/// A question that a program must pass before it goes to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gate {
    /// The program runs to its end, and all of its text is run.
    Program,
    /// Joints and drives keep their limits.
    Limits,
    /// The tool cuts as it may: no rapid in material, the spindle turns, no shank rubs.
    Process,
    /// No two bodies touch.
    Collision,
    /// Bodies keep the clearance that the scene asks for.
    NearMiss,
    /// No material of the design is cut away.
    Gouge,
    /// No material above the design is left.
    Excess,
    /// Roughness and scallops keep their tolerances.
    Surface,
}

impl Gate {
    /// All gates, in the order of the verdict.
    pub const ALL: [Self; 8] = [
        Self::Program,
        Self::Limits,
        Self::Process,
        Self::Collision,
        Self::NearMiss,
        Self::Gouge,
        Self::Excess,
        Self::Surface,
    ];

    /// Names of all gates, in the order of the verdict.
    pub const NAMES: [&str; 8] =
        ["program", "limits", "process", "collision", "near_miss", "gouge", "excess", "surface"];

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The gate with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|gate| gate.name() == name)
    }
}

impl fmt::Display for Gate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One value per gate.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PerGate<T>([T; Gate::ALL.len()]);

impl<T> PerGate<T> {
    /// The value of each gate as `of` gives it.
    pub fn from_fn(of: impl FnMut(Gate) -> T) -> Self {
        Self(Gate::ALL.map(of))
    }

    /// Gates and their values, in the order of the verdict.
    pub fn iter(&self) -> impl Iterator<Item = (Gate, &T)> {
        Gate::ALL.into_iter().zip(&self.0)
    }

    /// As [`Self::iter`], to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (Gate, &mut T)> {
        Gate::ALL.into_iter().zip(&mut self.0)
    }
}

impl<T> Index<Gate> for PerGate<T> {
    type Output = T;

    fn index(&self, gate: Gate) -> &T {
        &self.0[gate as usize]
    }
}

impl<T> IndexMut<Gate> for PerGate<T> {
    fn index_mut(&mut self, gate: Gate) -> &mut T {
        &mut self.0[gate as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_files_and_tables_are_in_their_order() {
        let table = PerGate::from_fn(Gate::name);
        for ((gate, name), wanted) in table.iter().zip(Gate::NAMES) {
            assert_eq!((*name, table[gate], Gate::named(name)), (wanted, wanted, Some(gate)));
            assert_eq!(serde_json::to_value(gate).expect("a word"), wanted);
            assert_eq!(format!("{gate:<11}|"), format!("{wanted:<11}|"));
        }
        assert_eq!(Gate::named("surfaces"), None);
    }
}
