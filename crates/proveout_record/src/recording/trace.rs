//! The path of the tip on the workpiece as lines.

use proveout_controller::MoveKind;
use proveout_geom::Point;

/// Distance of left-out points from the line, mm: less than a pixel at any useful zoom.
const TOLERANCE: f64 = 0.01;
/// Points after which the tolerance doubles.
const POINTS: usize = 200_000;
/// Left-out points that are checked against the line.
const HELD: usize = 64;
/// Keeps parts of a run without a length numbers, s.
const LEAST_END_S: f64 = 1e-9;

/// Shares of the programmed feed below which the classes after the first begin.
pub(crate) const REACHED: [f64; 5] = [0.95, 0.8, 0.6, 0.4, 0.2];
/// Shortest time in one class before the next may begin, s: what is shorter is less than a pixel at any
/// useful zoom.
const IN_CLASS: f64 = 0.02;

/// Class of a motion by the feed that it reached over that which is programmed: 0 for 95 percent and more, 5
/// below 20. Without a programmed feed nothing is missed.
pub(crate) fn class_of(reached: f64, programmed: f64) -> usize {
    if programmed > 0.0 { REACHED.iter().filter(|r| reached < *r * programmed).count() } else { 0 }
}

/// A line of one kind of motion, its feed in one class.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MotionStrip {
    pub(crate) kind: MoveKind,
    /// See [`class_of`]; 0 of rapids.
    pub(crate) class: usize,
    /// Time (s) and position (mm) of each point.
    pub(crate) points: Vec<(f64, [f32; 3])>,
}

/// Gathers the tip's path and leaves out points that lie on the line of their neighbors.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    strips: Vec<MotionStrip>,
    /// Last point of the line that is kept.
    anchor: Point,
    /// Points after it that are left out so far.
    held: Vec<(f64, Point)>,
    /// Bound of the distance of each of them from the line to the last one, mm, and of that from the anchor.
    off: f64,
    far: f64,
    tolerance: f64,
    in_class: f64,
    count: usize,
}

impl Default for Trace {
    fn default() -> Self {
        Self {
            strips: Vec::new(),
            anchor: Point::origin(),
            held: Vec::new(),
            off: 0.0,
            far: 0.0,
            tolerance: TOLERANCE,
            in_class: IN_CLASS,
            count: 0,
        }
    }
}

impl Trace {
    /// Adds a straight piece from one time and point to another; a gap, another kind of motion or another
    /// class begins a new line.
    pub(crate) fn push(&mut self, kind: MoveKind, class: usize, times: [f64; 2], from: Point, to: Point) {
        if !from.iter().chain(to.iter()).all(|v| v.is_finite()) {
            return;
        }
        let end = self.held.last().map_or(self.anchor, |h| h.1);
        let same = |s: &MotionStrip| {
            let young = s.points.first().is_some_and(|(begin, _)| times[1] - begin < self.in_class);
            s.kind == kind && (s.class == class || young)
        };
        let goes_on = self.strips.last().is_some_and(same) && (end - from).norm() <= TOLERANCE;
        if !goes_on {
            self.close();
            self.strips.push(MotionStrip { kind, class, points: Vec::new() });
            self.keep(times[0], from);
        }
        if self.held.len() >= HELD || !self.holds(&to) {
            self.close();
        }
        self.far = self.far.max((to - self.anchor).norm());
        self.held.push((times[1], to));
    }

    /// True where the line to a point stays near all points that are held. What turns the line by an angle
    /// takes each of them no farther off it than their distance from the anchor has it, so that points on a
    /// straight way are not looked at again.
    fn holds(&mut self, to: &Point) -> bool {
        let Some((_, last)) = self.held.last() else { return true };
        let (old, new) = (last - self.anchor, to - self.anchor);
        let (a, b) = (old.norm(), new.norm());
        let turn =
            if a > 0.0 && b > 0.0 && old.dot(&new) > 0.0 { old.cross(&new).norm() / (a * b) } else { f64::INFINITY };
        let off = self.off + self.far * turn;
        self.off = if b >= self.far && off <= self.tolerance {
            off
        } else {
            self.held.iter().map(|(_, p)| off_line(&self.anchor, to, p)).fold(0.0, f64::max)
        };
        self.off <= self.tolerance
    }

    /// Keeps the last held point.
    fn close(&mut self) {
        if let Some((time, point)) = self.held.pop() {
            self.held.clear();
            self.keep(time, point);
        }
    }

    fn keep(&mut self, time: f64, point: Point) {
        (self.anchor, self.off, self.far) = (point, 0.0, 0.0);
        if let Some(strip) = self.strips.last_mut() {
            strip.points.push((time, [point.x as f32, point.y as f32, point.z as f32]));
            self.count += 1;
            if self.count.is_multiple_of(POINTS) {
                self.tolerance *= 2.0;
                self.in_class *= 2.0;
            }
        }
    }

    /// The lines, cut so that each ends in one of `bins` equal stretches of time from 0 to `end` (s): bin and
    /// line.
    pub(crate) fn finish(mut self, end: f64, bins: usize) -> Vec<(usize, MotionStrip)> {
        self.close();
        let bin = |t: f64| ((t / end.max(LEAST_END_S) * bins as f64) as usize).min(bins.saturating_sub(1));
        let mut out: Vec<(usize, MotionStrip)> = Vec::new();
        for strip in self.strips {
            let mut current: Option<(usize, MotionStrip)> = None;
            for pair in strip.points.windows(2) {
                let b = bin(pair[1].0);
                match &mut current {
                    Some((open, line)) if *open == b => line.points.push(pair[1]),
                    other => {
                        out.extend(other.take());
                        *other = Some((b, MotionStrip { kind: strip.kind, class: strip.class, points: pair.to_vec() }));
                    }
                }
            }
            out.extend(current);
        }
        out
    }
}

/// Distance of `p` from the straight line between `a` and `b`, mm.
fn off_line(a: &Point, b: &Point, p: &Point) -> f64 {
    let d = b - a;
    let length2 = d.norm_squared();
    let t = if length2 > 0.0 { ((p - a).dot(&d) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + d * t)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_lose_their_inner_points_and_stay_within_the_tolerance() {
        let mut trace = Trace::default();
        let at = |i: i32| {
            let t = f64::from(i) * 0.001;
            if t < 5.0 {
                Point::new(t * 10.0, 0.0, 0.0)
            } else {
                Point::new(50.0 + 20.0 * (t - 5.0).sin(), 20.0 - 20.0 * (t - 5.0).cos(), 0.0)
            }
        };
        for i in 0..8000 {
            trace.push(MoveKind::Feed, 0, [f64::from(i) * 0.001, f64::from(i + 1) * 0.001], at(i), at(i + 1));
        }
        trace.push(MoveKind::Rapid, 0, [8.0, 9.0], at(8000), Point::new(0.0, 0.0, 50.0));
        let strips = trace.finish(9.0, 3);
        assert_eq!(strips.iter().map(|s| s.0).collect::<Vec<_>>(), [0, 1, 2, 2]);
        assert_eq!(strips.last().map(|s| s.1.kind), Some(MoveKind::Rapid));
        let points: usize = strips.iter().map(|s| s.1.points.len()).sum();
        assert!((80..260).contains(&points), "{points} of 8001");
        for i in 0..8000 {
            let p = at(i);
            let near = strips.iter().flat_map(|s| s.1.points.windows(2)).map(|w| {
                let [a, b] = [w[0].1, w[1].1].map(|p| Point::from(p.map(f64::from)));
                off_line(&a, &b, &p)
            });
            assert!(near.fold(f64::MAX, f64::min) <= TOLERANCE + 1e-4, "sample {i}");
        }
    }

    #[test]
    fn gaps_begin_a_new_line() {
        let mut trace = Trace::default();
        let p = |x: f64| Point::new(x, 0.0, 0.0);
        trace.push(MoveKind::Feed, 0, [0.0, 1.0], p(0.0), p(1.0));
        trace.push(MoveKind::Feed, 0, [1.0, 2.0], p(5.0), p(6.0));
        trace.push(MoveKind::Feed, 0, [2.0, 3.0], p(f64::NAN), p(6.0));
        assert_eq!(trace.finish(3.0, 1).len(), 2);
    }

    #[test]
    fn the_feed_that_is_reached_parts_the_line_into_classes() {
        let classes = [1.0, 0.95, 0.94, 0.7, 0.5, 0.3, 0.1].map(|share| class_of(share * 8.0, 8.0));
        assert_eq!(classes, [0, 0, 1, 2, 3, 4, 5]);
        assert_eq!((class_of(3.0, 0.0), class_of(0.0, 5.0)), (0, 5));
        // 5 ms a piece: a corner of 25 ms in class 3 is a line of its own; one of 5 ms in class 5 is shown as
        // long as a line may be short.
        let class = |i: i32| match i {
            10..15 => 3,
            30 => 5,
            _ => 0,
        };
        let mut trace = Trace::default();
        let at = |i: i32| Point::new(f64::from(i), 0.0, 0.0);
        for i in 0..50 {
            let times = [f64::from(i) * 0.005, f64::from(i + 1) * 0.005];
            trace.push(MoveKind::Feed, class(i), times, at(i), at(i + 1));
        }
        // A long piece after a short one has its own class.
        trace.push(MoveKind::Feed, 5, [0.25, 0.26], at(50), at(51));
        trace.push(MoveKind::Feed, 0, [0.26, 1.26], at(51), at(90));
        let strips = trace.finish(1.26, 1);
        let shown: Vec<_> =
            strips.iter().map(|(_, s)| (s.class, s.points[0].1[0], s.points[s.points.len() - 1].1[0])).collect();
        let expected = [
            (0, 0.0, 10.0),
            (3, 10.0, 15.0),
            (0, 15.0, 30.0),
            (5, 30.0, 33.0),
            (0, 33.0, 50.0),
            (5, 50.0, 51.0),
            (0, 51.0, 90.0),
        ];
        assert_eq!(shown, expected);
        assert!(strips.windows(2).all(|w| w[0].1.points.last() == w[1].1.points.first()), "no gap between lines");
    }
}
