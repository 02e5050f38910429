//! Pairs of bodies with a rule of their own: another near-miss distance than that of the scene, or no check
//! of one against the other.

/// Names for the parts of whichever tool is in the spindle.
pub const TOOL_PARTS: [&str; 4] = ["cutter", "neck", "shank", "holder"];

/// What is wanted of a pair of bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairCare {
    /// They are to keep this distance, mm, instead of that of the scene.
    NearMiss(f64),
    /// They are not checked against each other.
    Unchecked,
}

/// A rule for one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRule {
    /// Names of machine bodies; one may be of [`TOOL_PARTS`].
    pub bodies: [String; 2],
    /// What is wanted of them.
    pub care: PairCare,
    /// Why, in the words of the machine file; empty where the pair has a distance of its own and no reason
    /// is given.
    pub reason: String,
}

impl PairRule {
    /// Whether the rule is of these two, in any order.
    pub fn is_of(&self, one: &str, other: &str) -> bool {
        let [a, b] = &self.bodies;
        (a == one && b == other) || (a == other && b == one)
    }
}
