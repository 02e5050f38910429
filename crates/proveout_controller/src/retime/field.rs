//! All intervals of a region with their nodes, in sections: a problem of some intervals is taken out, solved,
//! and put back with the nodes that it has grown, at a cost that does not depend on the length of the region.

use super::problem::{JointRow, Problem, TempoNode};

/// Intervals of a section.
const SECTION: usize = 64;
/// Nodes an interval for which there is room at once: more than usual, since the search adds some.
const NODES: usize = 5;

#[derive(Debug, Default)]
struct FieldSection {
    /// With interval numbers of the whole.
    nodes: Vec<TempoNode>,
    joints: Vec<JointRow>,
}

/// Grid and rows of a region.
#[derive(Debug, Default)]
pub(super) struct Field {
    /// All but the nodes and their rows.
    whole: Problem,
    sections: Vec<FieldSection>,
}

impl Field {
    /// The intervals of a problem, without nodes.
    pub(super) fn new(whole: Problem) -> Self {
        let count = whole.lengths.len().div_ceil(SECTION);
        let mut field = Self { whole, sections: Vec::new() };
        field.sections.resize_with(count, FieldSection::default);
        field
    }

    /// Appends nodes of an interval with their rows. If its first node is the same place as the
    /// last one before, this is noted there.
    pub(super) fn push(&mut self, nodes: &[TempoNode], joints: &[JointRow], alike: f64) {
        let (Some(first), count) = (nodes.first(), self.whole.count) else { return };
        let number = first.k / SECTION;
        let before = if first.k.is_multiple_of(SECTION) { number.checked_sub(1) } else { Some(number) };
        if let Some(section) = before.and_then(|before| self.sections.get_mut(before))
            && let Some(last) = section.nodes.last_mut().filter(|last| last.k + 1 == first.k)
        {
            // b' is no larger than what changes b by its own size over the interval.
            let scales = [self.whole.lengths[first.k], 1.0];
            let same =
                |(a, b): (&JointRow, &JointRow)| (0..2).all(|i| f64::from((a[i] - b[i]).abs()) <= alike * scales[i]);
            last.twin = section.joints[section.joints.len() - count..].iter().zip(&joints[..count]).all(same);
        }
        if let Some(section) = self.sections.get_mut(number) {
            if section.nodes.is_empty() {
                let room = NODES * SECTION.min(self.whole.lengths.len() - number * SECTION);
                section.nodes.reserve(room);
                section.joints.reserve(room * count);
            }
            section.nodes.extend_from_slice(nodes);
            section.joints.extend_from_slice(joints);
        }
    }

    /// Lengths, begins and ends, without nodes.
    pub(super) fn whole(&self) -> &Problem {
        &self.whole
    }

    /// Number of intervals.
    pub(super) fn len(&self) -> usize {
        self.whole.lengths.len()
    }

    /// The intervals from `from` up to `to` as a problem of their own; the unknowns at inner ends are given.
    pub(super) fn between(&self, [from, to]: [usize; 2]) -> Problem {
        let whole = &self.whole;
        let mut problem = Problem {
            scale: whole.scale,
            lengths: whole.lengths[from..to].to_vec(),
            begins: whole.begins[from..to].to_vec(),
            nodes: Vec::new(),
            joints: Vec::new(),
            count: whole.count,
            used: whole.used.clone(),
            fixed: [from > 0 || whole.fixed[0], to < self.len() || whole.fixed[1]],
        };
        for section in &self.sections[from / SECTION..to.div_ceil(SECTION).min(self.sections.len())] {
            let own = range(&section.nodes, [from, to]);
            problem.nodes.extend(section.nodes[own.clone()].iter().map(|n| TempoNode { k: n.k - from, ..*n }));
            problem.joints.extend_from_slice(&section.joints[own.start * whole.count..own.end * whole.count]);
        }
        problem
    }

    /// Puts the nodes of some intervals back.
    pub(super) fn put_back(&mut self, from: usize, problem: Problem) {
        let to = from + problem.lengths.len();
        let count = self.whole.count;
        for section in &mut self.sections[from / SECTION..to.div_ceil(SECTION)] {
            let own = range(&section.nodes, [from, to]);
            section.joints.drain(own.start * count..own.end * count);
            section.nodes.drain(own);
        }
        self.put(problem.nodes, &problem.joints, from);
    }

    /// Adds nodes, numbered from interval `from` on, of intervals that have none.
    fn put(&mut self, nodes: Vec<TempoNode>, joints: &[JointRow], from: usize) {
        let count = self.whole.count;
        let mut begin = 0;
        while begin < nodes.len() {
            let number = (nodes[begin].k + from) / SECTION;
            let end = begin + nodes[begin..].partition_point(|n| (n.k + from) / SECTION == number);
            let section = &mut self.sections[number];
            let at = section.nodes.partition_point(|n| n.k < nodes[begin].k + from);
            section.nodes.splice(at..at, nodes[begin..end].iter().map(|n| TempoNode { k: n.k + from, ..*n }));
            section.joints.splice(at * count..at * count, joints[begin * count..end * count].iter().copied());
            begin = end;
        }
    }
}

/// Nodes of some intervals.
fn range(nodes: &[TempoNode], [from, to]: [usize; 2]) -> std::ops::Range<usize> {
    nodes.partition_point(|n| n.k < from)..nodes.partition_point(|n| n.k < to)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(k: usize, tau: f64) -> TempoNode {
        TempoNode { k, tau, cell: k, smooth: 0, twin: false, weight: 0.0, speed: 0.0, lead: 0.0 }
    }

    /// Intervals with one to three nodes; each row names the node it belongs to.
    fn field(n: usize) -> Field {
        let lengths = vec![1.0; n];
        let begins = (0..n).map(|k| k as f64).collect();
        let mut field = Field::new(Problem { lengths, begins, count: 2, ..Problem::default() });
        for k in 0..n {
            let nodes: Vec<TempoNode> = (0..1 + k % 3).map(|i| node(k, 0.3 * i as f64)).collect();
            let joints: Vec<JointRow> = nodes.iter().flat_map(|n| [[n.k as f32; 5], [n.tau as f32; 5]]).collect();
            field.push(&nodes, &joints, 1e-9);
        }
        field
    }

    #[test]
    fn what_is_taken_out_and_grows_stands_in_its_place() {
        for [from, to] in [[0, 200], [0, 64], [63, 65], [64, 128], [10, 20], [150, 200]] {
            let mut field = field(200);
            let before = field.between([0, 200]);
            let mut part = field.between([from, to]);
            assert_eq!(part.fixed, [from > 0, to < 200]);
            assert!(part.nodes.iter().zip(part.joints.chunks(2)).all(|(n, r)| (n.k + from) as f32 == r[0][0]));
            let behind = part.nodes.iter().position(|n| n.k == 3.min(to - from - 1)).unwrap_or(0);
            let own = part.nodes[behind].k;
            part.insert(&[(behind, 0.1)], |_, _| vec![[(own + from) as f32; 5], [0.1; 5]]);
            field.put_back(from, part);
            let after = field.between([0, 200]);
            assert_eq!(after.nodes.len(), before.nodes.len() + 1);
            assert!(after.nodes.windows(2).all(|w| (w[0].k, w[0].tau) < (w[1].k, w[1].tau)));
            assert!(
                after
                    .nodes
                    .iter()
                    .zip(after.joints.chunks(2))
                    .all(|(n, r)| n.k as f32 == r[0][0] && n.tau as f32 == r[1][0])
            );
            assert_eq!(after.nodes.iter().filter(|n| n.tau == 0.1).map(|n| n.k).collect::<Vec<_>>(), [own + from]);
        }
    }
}
