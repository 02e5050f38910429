//! Conservative advancement: when a distance may first be at a threshold (Mirtich 1996).
//!
//! Of a distance d(t) on 0..1 two things are known: a lower bound of it wherever it is asked for, and that it
//! changes by no more than `mu` for a unit of t. From t on it is above the threshold up to `t + (d(t) -
//! threshold) / mu`: there it is asked for again. The steps shrink with the distance, and end at a tolerance
//! above the threshold, so that nothing is passed over, and what is called near is no further away than the
//! tolerance.
//!
//! The pairs of a machine (`pair_advance.rs`) and single edges and faces go by the same rule.

/// What one distance says of the rest of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum AdvanceStep {
    /// At the threshold, within the tolerance; or no number.
    Reached,
    /// Above the threshold to the end.
    Clear,
    /// Above the threshold up to this time.
    Until(f64),
}

/// How the distance (mm, a lower bound) at time t is judged; `mu` is the most by which it changes for a unit
/// of time. Where it goes on, it does so down to `aim` only, which is the threshold or above it.
pub(crate) fn next_advance(t: f64, distance: f64, mu: f64, [threshold, aim]: [f64; 2], tolerance: f64) -> AdvanceStep {
    if distance.is_nan() || mu.is_nan() || distance <= threshold + tolerance {
        return AdvanceStep::Reached;
    }
    let until = t + (distance - aim) / mu;
    if mu <= 0.0 || until >= 1.0 { AdvanceStep::Clear } else { AdvanceStep::Until(until) }
}

/// The first time in 0..1 at which a distance may be within `tolerance` of the threshold; none where it is
/// above it all the way.
#[cfg(test)]
fn first_approach(mut distance_at: impl FnMut(f64) -> f64, mu: f64, threshold: f64, tolerance: f64) -> Option<f64> {
    let mut t = 0.0;
    loop {
        match next_advance(t, distance_at(t), mu, [threshold; 2], tolerance) {
            AdvanceStep::Reached => return Some(t),
            AdvanceStep::Clear => return None,
            AdvanceStep::Until(next) => t = next,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use proveout_geom::Point;

    use super::*;
    use crate::triangle;

    /// Two edges, or a vertex and a face, whose vertices move uniformly along straight ways.
    struct Query {
        edges: bool,
        from: [Point; 4],
        to: [Point; 4],
        meet: bool,
    }

    impl Query {
        fn distance(&self, t: f64) -> f64 {
            let [a, b, c, d] = std::array::from_fn(|k| self.from[k] + (self.to[k] - self.from[k]) * t);
            let nearest =
                if self.edges { triangle::segments(a, b, c, d) } else { triangle::point_triangle(a, &[b, c, d]) };
            nearest.square.sqrt()
        }

        /// The fastest vertex of each of the two, together.
        fn mu(&self) -> f64 {
            let way = |k: usize| (self.to[k] - self.from[k]).norm();
            let most = |all: std::ops::Range<usize>| all.map(way).fold(0.0, f64::max);
            let split = if self.edges { 2 } else { 1 };
            most(0..split) + most(split..4)
        }

        fn approach(&self, tolerance: f64) -> Option<f64> {
            // Rounding of the vertices on their way.
            first_approach(|t| self.distance(t), self.mu() * (1.0 + 1e-12), 0.0, tolerance)
        }
    }

    /// The zero set of a signed volume is crossed where it changes its sign; scenes of the same kinds as
    /// published ones, made here: no motion, touching at the begin and at the end, parallel edges, flat
    /// faces, thin ones, fast ones.
    fn own_queries() -> Vec<Query> {
        let p = Point::new;
        let face = [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0)];
        let vertex = |from: Point, to: Point, meet: bool| Query {
            edges: false,
            from: [from, face[0], face[1], face[2]],
            to: [to, face[0], face[1], face[2]],
            meet,
        };
        let still = [p(-1.0, 0.0, 0.0), p(1.0, 0.0, 0.0)];
        let edge = |from: [Point; 2], to: [Point; 2], meet: bool| Query {
            edges: true,
            from: [from[0], from[1], still[0], still[1]],
            to: [to[0], to[1], still[0], still[1]],
            meet,
        };
        let mut all = vec![
            // Through the face; touching at the end, at the begin, all the way; to a micrometer of it.
            vertex(p(0.2, 0.2, 1.0), p(0.3, 0.2, -1.0), true),
            vertex(p(0.2, 0.2, 1.0), p(0.2, 0.2, 0.0), true),
            vertex(p(0.2, 0.2, 0.0), p(0.2, 0.2, 1.0), true),
            vertex(p(0.2, 0.2, 0.0), p(0.2, 0.2, 0.0), true),
            vertex(p(-0.5, 0.3, 0.0), p(0.5, 0.3, 0.0), true),
            vertex(p(0.2, 0.2, 1.0), p(0.2, 0.2, 1e-2), false),
            vertex(p(0.2, 0.2, 0.5), p(0.2, 0.2, 0.5), false),
            // Past the border of the face.
            vertex(p(-0.01, 0.2, 1.0), p(-0.01, 0.2, -1.0), false),
            vertex(p(0.0, 0.2, 1.0), p(0.0, 0.2, -1.0), true),
            // Edges: crossing, parallel, on one line, only near.
            edge([p(0.0, -1.0, 1.0), p(0.0, 1.0, 1.0)], [p(0.0, -1.0, -1.0), p(0.0, 1.0, -1.0)], true),
            edge([p(-1.0, 0.0, 1.0), p(1.0, 0.0, 1.0)], [p(-1.0, 0.0, -1.0), p(1.0, 0.0, -1.0)], true),
            edge([p(-4.0, 0.0, 0.0), p(-3.0, 0.0, 0.0)], [p(-3.0, 0.0, 0.0), p(-2.0, 0.0, 0.0)], false),
            edge([p(-4.0, 0.0, 0.0), p(-3.0, 0.0, 0.0)], [p(-2.0, 0.0, 0.0), p(-1.0, 0.0, 0.0)], true),
            edge([p(-1.0, 0.1, 0.0), p(1.0, 0.1, 0.0)], [p(-1.0, 0.01, 0.0), p(1.0, 0.01, 0.0)], false),
            edge([p(1.1, -1.0, 1.0), p(1.1, 1.0, 1.0)], [p(1.1, -1.0, -1.0), p(1.1, 1.0, -1.0)], false),
            // A fast one through, an edge that is a point.
            edge([p(0.0, -1.0, 1e6), p(0.0, 1.0, 1e6)], [p(0.0, -1.0, -1e6), p(0.0, 1.0, -1e6)], true),
            edge([p(0.5, 0.0, 1.0); 2], [p(0.5, 0.0, -1.0); 2], true),
        ];
        // Faces that are lines and points.
        for flat in [[p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.5, 0.0, 0.0)], [p(0.5, 0.0, 0.0); 3]] {
            for (y, meet) in [(0.0, true), (0.01, false)] {
                let ends = [1.0, -1.0].map(|z| [p(0.5, y, z), flat[0], flat[1], flat[2]]);
                all.push(Query { edges: false, from: ends[0], to: ends[1], meet });
            }
        }
        all
    }

    /// How many that meet are missed, and how many that do not are called near.
    fn judge(all: &[Query], tolerance: f64) -> (usize, usize) {
        let missed = all.iter().filter(|q| q.meet && q.approach(tolerance).is_none()).count();
        (missed, all.iter().filter(|q| !q.meet && q.approach(tolerance).is_some()).count())
    }

    #[test]
    fn motions_of_edges_and_faces_have_the_right_distance() {
        let all = own_queries();
        assert_eq!(judge(&all, 1e-6), (0, 0));
        assert_eq!(judge(&all, 1e-3), (0, 0));
        assert!(judge(&all, 0.02).1 > 0, "a wide tolerance calls the near ones near");
    }

    /// The labeled queries of Wang et al. 2021 (A large-scale benchmark for continuous collision detection),
    /// in the folder named by `PROVEOUT_CCD_QUERIES`: eight rows of three fractions and the answer for each
    /// query.
    #[test]
    #[expect(clippy::print_stdout, reason = "the figures of a run by hand")]
    fn no_labeled_collision_is_missed() {
        let Ok(folder) = std::env::var("PROVEOUT_CCD_QUERIES") else { return };
        let mut open = vec![PathBuf::from(folder)];
        let mut all = Vec::new();
        while let Some(path) = open.pop() {
            if path.is_dir() {
                let mut inner: Vec<PathBuf> =
                    std::fs::read_dir(&path).expect("folder").map(|e| e.expect("entry").path()).collect();
                inner.sort();
                open.extend(inner);
            } else if path.extension().is_some_and(|e| e == "csv") {
                all.extend(read(&path));
            }
        }
        let meet = all.iter().filter(|q| q.meet).count();
        assert!(meet > 0, "no query in the folder");
        for tolerance in [1e-6, 1e-3] {
            let (missed, alarms) = judge(&all, tolerance);
            println!(
                "{} queries, {meet} meet: tolerance {tolerance:e}, {missed} missed, {alarms} false alarms",
                all.len()
            );
            assert_eq!(missed, 0);
        }
    }

    fn read(path: &Path) -> Vec<Query> {
        let text = std::fs::read_to_string(path).expect("queries");
        let edges = path.components().any(|c| c.as_os_str() == "edge-edge");
        let rows: Vec<(Point, bool)> = text
            .lines()
            .map(|line| {
                let n: Vec<f64> = line.split(',').map(|x| x.trim().parse().expect("number")).collect();
                (Point::new(n[0] / n[1], n[2] / n[3], n[4] / n[5]), n[6] != 0.0)
            })
            .collect();
        rows.chunks_exact(8)
            .map(|q| Query {
                edges,
                from: std::array::from_fn(|k| q[k].0),
                to: std::array::from_fn(|k| q[4 + k].0),
                meet: q[0].1,
            })
            .collect()
    }
}
