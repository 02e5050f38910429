//! Findings as they come in, joined where one fault goes on over many blocks.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use crate::verdict::{
    finding::{ASSUMED, Code, Family, Finding, NEAR_MISS, NOTE, Severity},
    gate::{Gate, PerGate},
};

/// A fault that goes on within this time (s) or in the next block is one finding with a count.
const JOIN_S: f64 = 1.0;

/// Where a fault was seen last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joined {
    pub(crate) block: u32,
    /// Simulated time, s.
    pub(crate) time: f64,
}

impl Joined {
    /// Whether the same fault here goes on from where it was last.
    pub(crate) fn goes_on(self, last: Self) -> bool {
        self.block <= last.block + 1 || self.time - last.time <= JOIN_S
    }
}

/// The findings of a run in order of time.
#[derive(Clone, Debug, Default)]
pub struct FindingLog {
    findings: Vec<Finding>,
    /// Last finding of a code and its bodies: its index, and its latest repetition.
    open: BTreeMap<(String, Vec<String>), (usize, Joined)>,
    /// Near misses that are left out, since the bodies hit each other in the same line.
    near_misses_of_hits: u64,
    /// What the checks did not decide, for the reasons of the gates.
    left_out: PerGate<Vec<String>>,
}

impl FindingLog {
    /// A finding of a code, with the limit's source where the code knows it and no other detail, to be filled
    /// in.
    pub fn of(code: &Code, message: String) -> Finding {
        Finding {
            code: code.code.into(),
            family: code.family,
            severity: code.severity,
            file: None,
            line: None,
            block: None,
            time_s: None,
            axes: BTreeMap::new(),
            bodies: Vec::new(),
            point_mm: None,
            penetration_mm: None,
            clearance_mm: None,
            value: None,
            limit: None,
            unit: None,
            area_mm2: None,
            volume_mm3: None,
            areas: None,
            repeats: 0,
            message,
            tool: None,
            limit_source: code.limit_source,
        }
    }

    /// Takes a finding; joins it with the one before of the same code and bodies when it goes on without a
    /// break, and keeps the worst depth, clearance and value of the two. Gives its place in [`Self::all`].
    pub fn push(&mut self, finding: Finding) -> usize {
        // A note is the same note wherever the program repeats its word.
        let note = finding.code == NOTE.code || finding.code == ASSUMED.code;
        let bodies = if note { vec![finding.message.clone()] } else { finding.bodies.clone() };
        let key = (finding.code.clone(), bodies);
        if let (Some(block), Some(time)) = (finding.block, finding.time_s) {
            let now = Joined { block, time };
            if let Some((index, last)) = self.open.get_mut(&key)
                && (note || now.goes_on(*last))
            {
                let first = &mut self.findings[*index];
                if block > last.block {
                    first.repeats += 1;
                }
                if finding.severity == Severity::Error {
                    first.severity = Severity::Error;
                }
                *last = Joined { block: block.max(last.block), time: time.max(last.time) };
                first.penetration_mm = larger(first.penetration_mm, finding.penetration_mm);
                first.value = larger(first.value, finding.value);
                first.clearance_mm =
                    larger(first.clearance_mm.map(|v| -v), finding.clearance_mm.map(|v| -v)).map(|v| -v);
                return *index;
            }
            self.open.insert(key, (self.findings.len(), now));
        }
        self.findings.push(finding);
        self.findings.len() - 1
    }

    /// Says in words what a check did not decide: the gate is then unchecked, unless it fails.
    pub fn leave_out(&mut self, gate: Gate, words: String) {
        self.left_out[gate].push(words);
    }

    /// What the checks did not decide of a gate, in their order.
    pub fn left_out(&self, gate: Gate) -> &[String] {
        &self.left_out[gate]
    }

    /// Writes later figures into a finding: the deepest penetration, and the least clearance where it has
    /// one, mm.
    pub fn deepen(&mut self, finding: usize, penetration: Option<f64>, clearance: f64) {
        if let Some(f) = self.findings.get_mut(finding) {
            f.penetration_mm = larger(f.penetration_mm, penetration);
            f.clearance_mm = f.clearance_mm.map(|c| c.min(clearance));
        }
    }

    /// File and line of every finding filled in from the table of blocks.
    pub fn placed(self, places: &[Option<(Arc<str>, u32)>]) -> Self {
        Self { findings: placed(self.findings, places), ..self }
    }

    /// Without near misses of bodies that hit each other in the same line: who hits came near before.
    pub fn without_near_misses_of_hits(self) -> Self {
        let hits: BTreeSet<(Vec<String>, Option<String>, Option<u32>)> = self
            .findings
            .iter()
            .filter(|f| f.family == Family::Collision && f.code != NEAR_MISS.code && f.line.is_some())
            .map(|f| (f.bodies.clone(), f.file.clone(), f.line))
            .collect();
        let told = |f: &Finding| f.code == NEAR_MISS.code && hits.contains(&(f.bodies.clone(), f.file.clone(), f.line));
        let (of_hits, findings): (Vec<Finding>, Vec<Finding>) = self.findings.into_iter().partition(told);
        Self { findings, near_misses_of_hits: self.near_misses_of_hits + of_hits.len() as u64, ..self }
    }

    /// Near misses without a finding of their own: the bodies hit each other in the same line. They fail the
    /// gate all the same.
    pub fn near_misses_of_hits(&self) -> u64 {
        self.near_misses_of_hits
    }

    /// All findings so far.
    pub fn all(&self) -> &[Finding] {
        &self.findings
    }

    /// Number of findings so far.
    pub fn len(&self) -> usize {
        self.findings.len()
    }

    /// True when nothing was found.
    pub fn is_empty(&self) -> bool {
        self.findings.is_empty()
    }

    /// True when a finding of this code is there.
    pub fn has(&self, code: &Code) -> bool {
        self.findings.iter().any(|f| f.code == code.code)
    }
}

/// File and line of findings filled in from the table of blocks, as far as their blocks are known.
pub(crate) fn placed(mut findings: Vec<Finding>, places: &[Option<(Arc<str>, u32)>]) -> Vec<Finding> {
    for f in &mut findings {
        if let Some((file, line)) = f.block.and_then(|b| places.get(b as usize)).and_then(Option::as_ref) {
            (f.file, f.line) = (Some(file.to_string()), Some(*line));
        }
    }
    findings
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::finding::HOLDER_IN_STOCK;

    fn hit(block: u32, time: f64, depth: f64) -> Finding {
        let mut f = FindingLog::of(&HOLDER_IN_STOCK, "holder".into());
        (f.block, f.time_s, f.penetration_mm, f.bodies) = (Some(block), Some(time), Some(depth), vec!["holder".into()]);
        f
    }

    #[test]
    fn words_that_are_left_out_keep_their_order_and_gate() {
        let mut log = FindingLog::default();
        log.leave_out(Gate::Process, "first".into());
        log.leave_out(Gate::Limits, "legs".into());
        log.leave_out(Gate::Process, "second".into());
        let log = log.placed(&[]).without_near_misses_of_hits();
        assert_eq!(log.left_out(Gate::Process), ["first", "second"]);
        assert_eq!(log.left_out(Gate::Limits), ["legs"]);
        assert!(log.left_out(Gate::Gouge).is_empty());
    }

    #[test]
    fn a_fault_that_goes_on_is_one_finding_with_its_worst_depth() {
        let mut log = FindingLog::default();
        for (block, time, depth) in [(7, 1.0, 0.1), (7, 1.1, 0.2), (8, 1.2, 0.9), (9, 5.0, 0.3), (40, 60.0, 0.1)] {
            log.push(hit(block, time, depth));
        }
        assert_eq!(log.len(), 2);
        assert_eq!((log.all()[0].repeats, log.all()[0].penetration_mm), (2, Some(0.9)));
        assert_eq!(log.all()[1].block, Some(40));
    }
}
