//! The motion that was checked, kept in pieces, with the ranges of the joints over any stretch of it.

use proveout_machine::{JointValues, MAX_JOINTS};

use crate::JointMotion;

/// Pieces that one straight motion may represent.
const MOST_IN_CHORD: usize = 64;

/// Where the joints may be over a stretch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub(crate) low: JointValues,
    pub(crate) high: JointValues,
    /// Largest of the pieces.
    pub(crate) off: JointValues,
    pub(crate) slack: f64,
}

impl Range {
    const NONE: Self = Self {
        low: JointValues([f64::INFINITY; MAX_JOINTS]),
        high: JointValues([f64::NEG_INFINITY; MAX_JOINTS]),
        off: JointValues::ZERO,
        slack: 0.0,
    };

    fn of(piece: &JointMotion) -> Self {
        let [from, to] = piece.joints;
        Self { low: from.zip_map(to, f64::min), high: from.zip_map(to, f64::max), off: piece.off, slack: piece.slack }
            .widened(&piece.off)
    }

    fn widened(mut self, off: &JointValues) -> Self {
        self.low = self.low - *off;
        self.high = self.high + *off;
        self
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            low: self.low.zip_map(other.low, f64::min),
            high: self.high.zip_map(other.high, f64::max),
            off: self.off.zip_map(other.off, f64::max),
            slack: self.slack.max(other.slack),
        }
    }
}

/// A stretch of the motion: a node of the tree over the pieces, or a part of one piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotionStretch {
    /// Node of the tree.
    Node(usize),
    /// Piece, and from where to where in it, 0 to 1.
    Part(usize, [f64; 2]),
}

/// Pieces in order of time, and a binary tree of ranges over them: node 1 is all of them, node n has the
/// halves 2 n and 2 n + 1.
#[derive(Clone, Debug)]
pub(crate) struct PieceTree {
    pieces: Vec<JointMotion>,
    ranges: Vec<Range>,
    leaves: usize,
}

impl PieceTree {
    /// None without a piece.
    pub(crate) fn new(pieces: Vec<JointMotion>) -> Option<Self> {
        let leaves = pieces.len().next_power_of_two();
        let mut ranges = vec![Range::NONE; 2 * leaves];
        for (range, piece) in ranges[leaves..].iter_mut().zip(&pieces) {
            *range = Range::of(piece);
        }
        for n in (1..leaves).rev() {
            ranges[n] = ranges[2 * n].and(&ranges[2 * n + 1]);
        }
        (!pieces.is_empty()).then_some(Self { pieces, ranges, leaves })
    }

    /// Begin and end, s. What lies between two pieces, where nothing moves, belongs to the first.
    /// The motion within a piece is not uniform: a part of a piece has the time of the whole piece,
    /// since it is not known when the joints are in it.
    pub(crate) fn time(&self, stretch: MotionStretch) -> [f64; 2] {
        let begin = |k: usize| self.pieces.get(k).map_or_else(|| self.end(), |p| p.time[0]);
        match stretch {
            MotionStretch::Node(n) => {
                let [first, last] = self.held(n);
                [begin(first), begin(last)]
            }
            MotionStretch::Part(k, _) => [begin(k), begin(k + 1)],
        }
    }

    /// Where a stretch begins along the way: its first piece, and the part of that which is before it.
    pub(crate) fn begin(&self, stretch: MotionStretch) -> (usize, f64) {
        match stretch {
            MotionStretch::Node(n) => (self.held(n)[0], 0.0),
            MotionStretch::Part(k, [a, _]) => (k, a),
        }
    }

    /// Joints at both ends of all of it.
    pub(crate) fn ends(&self) -> Option<[JointValues; 2]> {
        Some([self.pieces.first()?.joints[0], self.pieces.last()?.joints[1]])
    }

    fn end(&self) -> f64 {
        self.pieces.last().map_or(0.0, |p| p.time[1])
    }

    /// Pieces of a node: first, and one past the last.
    fn held(&self, mut n: usize) -> [usize; 2] {
        let mut width = 1;
        while n < self.leaves {
            (n, width) = (2 * n, 2 * width);
        }
        [n - self.leaves, n - self.leaves + width].map(|k| k.min(self.pieces.len()))
    }

    /// The two halves of a stretch, the earlier first; one where the other holds no piece.
    pub(crate) fn halves(&self, stretch: MotionStretch) -> [Option<MotionStretch>; 2] {
        match stretch {
            MotionStretch::Node(n) if n < self.leaves => [2 * n, 2 * n + 1].map(|n| {
                let [first, last] = self.held(n);
                (first < last).then_some(MotionStretch::Node(n))
            }),
            MotionStretch::Node(n) => self.halves(MotionStretch::Part(n - self.leaves, [0.0, 1.0])),
            MotionStretch::Part(k, [a, b]) => {
                let middle = 0.5 * (a + b);
                [[a, middle], [middle, b]].map(|part| Some(MotionStretch::Part(k, part)))
            }
        }
    }

    /// The piece that a stretch lies in, and from where to where; none for more than one piece.
    fn within(&self, stretch: MotionStretch) -> Option<(&JointMotion, [f64; 2])> {
        match stretch {
            MotionStretch::Node(n) => n.checked_sub(self.leaves).map(|k| (&self.pieces[k], [0.0, 1.0])),
            MotionStretch::Part(k, part) => Some((&self.pieces[k], part)),
        }
    }

    /// The node of a piece.
    pub(crate) fn leaf(&self, piece: usize) -> usize {
        self.leaves + piece
    }

    /// Nodes of the single pieces of a node, in their order.
    pub(crate) fn leaves_of(&self, node: usize) -> std::ops::Range<usize> {
        let [first, last] = self.held(node);
        self.leaf(first)..self.leaf(last)
    }

    /// Nodes of the tree, less than this.
    pub(crate) fn nodes(&self) -> usize {
        2 * self.leaves
    }

    /// Ends of a piece, and where its joints may be.
    pub(crate) fn piece(&self, piece: usize) -> ([JointValues; 2], Range) {
        (self.pieces[piece].joints, self.ranges[self.leaves + piece])
    }

    /// Ends of the straight motion of the joints in a stretch of one piece.
    pub(crate) fn line(&self, stretch: MotionStretch) -> Option<[JointValues; 2]> {
        let (piece, part) = self.within(stretch)?;
        Some(part.map(|t| piece.joints[0].interpolated(piece.joints[1], t)))
    }

    pub(crate) fn range(&self, stretch: MotionStretch) -> Range {
        match (stretch, self.line(stretch), self.within(stretch)) {
            (MotionStretch::Node(n), ..) => self.ranges[n],
            (_, Some(joints), Some((piece, _))) => Range::of(&JointMotion { joints, ..*piece }),
            _ => Range::NONE,
        }
    }

    /// Straight motion of the joints from the begin of a stretch to its end, and by how much each joint
    /// leaves it, mm and radian: at every moment all of them are so near to one place of it. `weights` say
    /// what a unit of each joint is worth. None for a stretch of many pieces.
    pub(crate) fn chord(
        &self,
        stretch: MotionStretch,
        weights: &[f64; MAX_JOINTS],
    ) -> Option<([JointValues; 2], JointValues)> {
        if let (Some(line), Some((piece, _))) = (self.line(stretch), self.within(stretch)) {
            return Some((line, piece.off));
        }
        let MotionStretch::Node(n) = stretch else { return None };
        let [first, last] = self.held(n);
        let pieces = &self.pieces[first..last];
        if pieces.len() > MOST_IN_CHORD {
            return None;
        }
        let (from, to) = (pieces.first()?.joints[0], pieces.last()?.joints[1]);
        let way = to - from;
        let dot = |a: &JointValues, b: &JointValues| -> f64 {
            (0..MAX_JOINTS).map(|j| weights[j] * weights[j] * a[j] * b[j]).sum()
        };
        let length = dot(&way, &way);
        let mut off = JointValues::ZERO;
        for q in pieces.iter().flat_map(|p| p.joints) {
            let t = if length > 0.0 { (dot(&(q - from), &way) / length).clamp(0.0, 1.0) } else { 0.0 };
            off = off.zip_map(q - (from + way * t), |most, d| most.max(d.abs()));
        }
        // Between two ends of a piece the joints are between two places that are so near to the chord.
        Some(([from, to], off + self.ranges[n].off))
    }

    /// A place of the motion near the middle of a stretch: joints, and when, s, as if the joints went
    /// uniformly through the piece.
    pub(crate) fn middle(&self, stretch: MotionStretch) -> (JointValues, f64) {
        if let (Some([a, b]), Some((piece, [s, t]))) = (self.line(stretch), self.within(stretch)) {
            let time = piece.time[0] + (piece.time[1] - piece.time[0]) * 0.5 * (s + t);
            return (a.interpolated(b, 0.5), time);
        }
        let MotionStretch::Node(n) = stretch else { return (self.pieces[0].joints[0], self.pieces[0].time[0]) };
        let [first, last] = self.held(n);
        let piece = &self.pieces[(first + last) / 2];
        (piece.joints[0], piece.time[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(k: usize) -> JointMotion {
        let at = |x: f64| JointValues([x; MAX_JOINTS]);
        let t = k as f64;
        JointMotion {
            joints: [at(t * t), at((t + 1.0) * (t + 1.0))],
            time: [2.0 * t, 2.0 * t + 1.5],
            off: at(0.25),
            slack: 0.1 * t,
        }
    }

    /// For any number of pieces the halves of a stretch follow each other without a gap in time and along the
    /// way, down to parts of one piece, and their joints lie within its range. At any moment the joints are
    /// in a stretch of that time, however they went through the piece.
    #[test]
    fn halves_are_the_whole() {
        for n in 1..20 {
            let way = PieceTree::new((0..n).map(piece).collect()).expect("pieces");
            assert_eq!(way.time(MotionStretch::Node(1)), [0.0, 2.0 * n as f64 - 0.5]);
            let mut open = vec![MotionStretch::Node(1)];
            let mut parts = 0;
            while let Some(stretch) = open.pop() {
                let (time, range) = (way.time(stretch), way.range(stretch));
                let (q, at) = way.middle(stretch);
                assert!(time[0] <= at && at <= time[1], "{stretch:?}");
                assert!(range.low[0] <= q[0] && q[0] <= range.high[0], "{stretch:?}");
                if matches!(stretch, MotionStretch::Part(_, [a, b]) if b - a < 0.3) {
                    parts += 1;
                    continue;
                }
                let halves: Vec<MotionStretch> = way.halves(stretch).into_iter().flatten().collect();
                assert_eq!(way.time(halves[0])[0], time[0]);
                assert_eq!(way.time(halves[halves.len() - 1])[1], time[1]);
                assert_eq!(way.begin(halves[0]), way.begin(stretch));
                if let [a, b] = halves[..] {
                    assert!(way.begin(a) < way.begin(b));
                    if matches!(a, MotionStretch::Part(..)) {
                        assert_eq!([way.time(a), way.time(b)], [time; 2]);
                        // Braking hard, the joints are far beyond the middle at half the time.
                        let [from, to] = way.line(stretch).expect("one piece");
                        let q = from.interpolated(to, 0.9);
                        assert!([a, b].iter().any(|x| way.range(*x).low[0] <= q[0] && q[0] <= way.range(*x).high[0]));
                    } else {
                        assert_eq!(way.time(a)[1], way.time(b)[0]);
                    }
                }
                for half in &halves {
                    let part = way.range(*half);
                    assert!(range.low[0] <= part.low[0] && part.high[0] <= range.high[0] && part.slack <= range.slack);
                }
                open.extend(halves);
            }
            assert_eq!(parts, 4 * n);
        }
        assert!(PieceTree::new(Vec::new()).is_none());
    }
}
