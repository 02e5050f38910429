//! A bound for schedules with both angles of the tool axis free: dynamic programming over cells of the two
//! rotary joints.
//!
//! *What is bound.* The tool axis at gate i lies within an angle `radius_i` of a direction `a_i` (a cap). The
//! two rotary joints bring it there; the inner one carries the tool axis `zero`, the outer one turns both:
//!
//! ```text
//!   axis(p, q) = turn(outer, q) turn(inner, p) zero
//! ```
//!
//! *Cells.* The plane of both joints is cut into cells of equal size, the outer joint taken as a circle:
//! whole turns of it, and its travel, do not count, which only lowers the bound. A cell belongs to a gate if
//! its middle is nearer to `a_i` than `radius_i` and what the axis can be off in the cell: the half of its
//! height, and the half of its width times the sine of the angle to the outer axis. So no axis of the cap is
//! left out.
//!
//! *Potentials.* Stations are some of the gates, the first and the last among them. From a cell to another of
//! the next station
//!
//! ```text
//!   cost = max(what the feed proves between both stations,
//!              smallest way of each joint between the cells / its velocity)
//! ```
//!
//! is less than any schedule takes that is in both. With v = 0 at the first station and `v' <= v + cost` on
//! every edge, v is a lower bound of the time to be in a cell, and the least v of the last station is one of
//! the time of all schedules: the dual of the shortest path, which a reader can check edge by edge.
//!
//! *What the cells lose.* Between two stations each joint has the way of one cell for nothing: few
//! stations and small cells lose little, while many stations see more of the caps. Both are tried.
//! A path through middles of cells that are in their caps is a schedule: its time is reported as
//! the most that this relaxation (feed and velocity at these stations) can be above the bound.

use std::f64::consts::TAU;

use proveout_geom::Vector;

/// Two rotary joints and the axis that they turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPair {
    /// Direction of the inner joint with both at zero; the axis turns right-handed about it by the joint's
    /// value.
    pub inner: Vector,
    /// Direction of the outer joint.
    pub outer: Vector,
    /// The tool axis with both at zero.
    pub zero: Vector,
    /// Lowest and highest position of the inner joint, radian.
    pub travel: [f64; 2],
    /// Velocity limits of the inner and the outer joint, rad/s.
    pub velocity: [f64; 2],
}

impl AxisPair {
    /// The tool axis.
    pub fn axis(&self, [inner, outer]: [f64; 2]) -> Vector {
        turned(&self.outer, outer, &turned(&self.inner, inner, &self.zero))
    }
}

fn turned(about: &Vector, by: f64, v: &Vector) -> Vector {
    v * by.cos() + about.cross(v) * by.sin() + about * (about.dot(v) * (1.0 - by.cos()))
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Axes that schedules may take: within an angle of a direction at each gate.
#[derive(Clone, Debug, PartialEq)]
pub struct Caps {
    /// Middle of each gate's cap, unit length.
    pub middles: Vec<Vector>,
    /// Angle of all caps, radian.
    pub radius: f64,
}

/// Cells of a station, inner and outer, with the least time to be in each, s.
type Bounds = Vec<([usize; 2], f64)>;

/// Cells of the two joints with a lower bound of the time to be in each.
#[derive(Clone, Debug, PartialEq)]
pub struct CellBound {
    /// The gates that were looked at; the first and the last are among them.
    pub stations: Vec<usize>,
    /// Lowest position of the inner joint, radian; the outer one begins at zero.
    pub from: f64,
    /// Number of cells of the inner and the outer joint.
    pub counts: [usize; 2],
    /// Height and width of a cell, radian.
    pub size: [f64; 2],
    /// Of each station its cells, inner and outer, and their bounds, s.
    pub cells: Vec<Vec<([usize; 2], f64)>>,
    /// The bound, s.
    pub time: f64,
    /// A schedule of the relaxation through middles of cells takes this, s; none where a station has no
    /// middle in its cap.
    pub reached: Option<f64>,
}

/// Cells of a station above which finer ones are not tried.
const MOST_CELLS: usize = 1200;
/// Sizes of cells that are tried, the coarsest first: height as part of the caps' angle, and number of cells
/// of a turn of the outer joint.
const SIZES: [(f64, usize); 6] = [(1.0, 45), (0.5, 90), (0.25, 180), (0.125, 360), (0.25, 360), (0.125, 720)];
/// Strides of stations that are tried.
const STRIDES: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Part of the bound that finer cells must add to be worth their room in a file.
const WORTH: f64 = 1e-4;
/// Rows of cells above which finer ones are not tried.
const MOST_ROWS: f64 = 1e4;

struct JointGrid<'a> {
    pair: &'a AxisPair,
    caps: &'a Caps,
    counts: [usize; 2],
    size: [f64; 2],
}

impl JointGrid<'_> {
    fn middle(&self, [j, k]: [usize; 2]) -> [f64; 2] {
        [self.pair.travel[0] + (j as f64 + 0.5) * self.size[0], (k as f64 + 0.5) * self.size[1]]
    }

    /// Cells that reach into the cap of a gate; with `middles` those whose middle lies in it. None where
    /// there are too many.
    fn cells(&self, gate: usize, middles: bool) -> Option<Vec<[usize; 2]>> {
        let middle = &self.caps.middles[gate];
        let mut cells = Vec::new();
        for j in 0..self.counts[0] {
            let inner = turned(&self.pair.inner, self.middle([j, 0])[0], &self.pair.zero);
            let lean = angle(&inner, &self.pair.outer);
            let off = if middles { 0.0 } else { 0.5 * (self.size[0] + self.size[1] * lean.sin()) };
            // A whole row whose lean is too different has no cell.
            if (lean - angle(middle, &self.pair.outer)).abs() > self.caps.radius + off {
                continue;
            }
            for k in 0..self.counts[1] {
                let axis = turned(&self.pair.outer, self.middle([j, k])[1], &inner);
                if angle(&axis, middle) <= self.caps.radius + off {
                    cells.push([j, k]);
                }
            }
            if cells.len() > MOST_CELLS {
                return None;
            }
        }
        Some(cells)
    }

    /// Smallest time of both joints from one cell to another; from middle to middle with `middles`.
    fn way(&self, a: [usize; 2], b: [usize; 2], middles: bool) -> f64 {
        let free = usize::from(!middles);
        let inner = a[0].abs_diff(b[0]).saturating_sub(free) as f64 * self.size[0];
        let round = a[1].abs_diff(b[1]);
        let outer = round.min(self.counts[1] - round).saturating_sub(free) as f64 * self.size[1];
        (inner / self.pair.velocity[0]).max(outer / self.pair.velocity[1])
    }

    /// Bounds of all cells of all stations; none where a station has no cell, or too many.
    fn potentials(&self, stations: &[usize], feed: &[f64], middles: bool) -> Option<Vec<Bounds>> {
        let mut all: Vec<Bounds> = Vec::with_capacity(stations.len());
        for (k, &gate) in stations.iter().enumerate() {
            let cells = self.cells(gate, middles).filter(|c| !c.is_empty())?;
            let Some(last) = all.last() else {
                all.push(cells.into_iter().map(|c| (c, 0.0)).collect());
                continue;
            };
            let mut rising: Vec<&([usize; 2], f64)> = last.iter().collect();
            rising.sort_by(|a, b| a.1.total_cmp(&b.1));
            let feed = feed[k - 1];
            let least = |cell: [usize; 2]| {
                let mut least = f64::INFINITY;
                for (from, time) in &rising {
                    if time + feed >= least {
                        break;
                    }
                    least = least.min(time + self.way(*from, cell, middles).max(feed));
                }
                least
            };
            all.push(cells.into_iter().map(|c| (c, least(c))).collect());
        }
        Some(all)
    }
}

fn least_of(cells: &[Bounds]) -> f64 {
    cells.last().map_or(0.0, |last| last.iter().map(|(_, t)| *t).fold(f64::INFINITY, f64::min))
}

impl CellBound {
    /// The best bound of all cell sizes and rows of stations that are tried. `feed` returns what
    /// the feed proves from one gate to another, s. None if there are fewer than two gates, or more
    /// cells than can be searched.
    pub fn new(pair: &AxisPair, caps: &Caps, feed: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let last = caps.middles.len().checked_sub(1).filter(|n| *n > 0)?;
        let travel = pair.travel[1] - pair.travel[0];
        if !(caps.radius > 0.0 && travel > 0.0 && travel.is_finite() && pair.velocity.iter().all(|v| *v > 0.0)) {
            return None;
        }
        let mut best: Option<Self> = None;
        for stride in STRIDES {
            if stride > last.max(1) && stride > 1 {
                break;
            }
            let mut stations: Vec<usize> = (0..=last).step_by(stride).collect();
            if stations.last() != Some(&last) {
                stations.push(last);
            }
            let feeds: Vec<f64> = stations.windows(2).map(|p| feed(p[0], p[1])).collect();
            for (height, width) in SIZES {
                let rows = (travel / (height * caps.radius)).ceil().max(1.0);
                if rows > MOST_ROWS {
                    break;
                }
                let counts = [rows as usize, width];
                let size = [travel / rows, TAU / width as f64];
                let grid = JointGrid { pair, caps, counts, size };
                let Some(cells) = grid.potentials(&stations, &feeds, false) else { continue };
                let time = least_of(&cells);
                if best.as_ref().is_some_and(|b| time <= b.time * (1.0 + WORTH)) {
                    continue;
                }
                let reached = grid.potentials(&stations, &feeds, true).map(|cells| least_of(&cells));
                let stations = stations.clone();
                best = Some(Self { stations, from: pair.travel[0], counts, size, cells, time, reached });
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Random;
    use super::*;

    /// A head with a B axis over a table with a C axis.
    fn pair(velocity: [f64; 2]) -> AxisPair {
        AxisPair { inner: Vector::y(), outer: Vector::z(), zero: Vector::z(), travel: [-0.6, 0.6], velocity }
    }

    #[test]
    fn a_row_past_the_pole_is_bound_by_its_turn_and_one_whose_caps_hold_it_by_the_feed() {
        // The axis goes past the pole at a degree: C turns by nearly half a turn.
        let n = 40;
        let middles: Vec<Vector> = (0..=n)
            .map(|i| {
                let x = 0.2 * (2.0 * f64::from(i) / f64::from(n) - 1.0);
                Vector::new(x, 0.0175, 1.0).normalize()
            })
            .collect();
        let pair = pair([10.0, 1.0]);
        let feed = |a: usize, b: usize| 0.01 * (b - a) as f64;
        let narrow = Caps { middles: middles.clone(), radius: 0.005 };
        let found = CellBound::new(&pair, &narrow, feed).expect("cells");
        // Any schedule turns C from 175 to 5 degrees, less what the caps leave at the ends: 1.4 degrees each.
        let turn = std::f64::consts::PI - 2.0 * (0.0175_f64 / 0.2).atan() - 2.0 * (0.005_f64 / 0.2).asin();
        assert!(found.time <= turn && found.time > 0.8 * turn, "{} {turn}", found.time);
        assert!(found.reached.is_some_and(|t| t >= found.time), "{:?}", found.reached);
        // With the pole in the caps B changes its sign and C stays.
        let wide = Caps { middles, radius: 0.03 };
        let found = CellBound::new(&pair, &wide, feed).expect("cells");
        assert!((found.time - 0.4).abs() < 1e-9, "{}", found.time);
    }

    /// Random rows of axes, each inside of random caps: the time by feed and velocity of the row itself is
    /// never below the bound.
    #[test]
    fn no_row_of_axes_is_below_the_bound_and_wider_caps_and_faster_joints_do_not_raise_it() {
        let mut random = Random(11);
        let (mut forced, mut near) = (0, f64::INFINITY);
        for _ in 0..40 {
            let n = 4 + (20.0 * random.next()) as usize;
            let pair = pair([10_f64.powf(random.between(-1.0, 1.0)), 10_f64.powf(random.between(-1.0, 1.0))]);
            let step = random.between(0.01, 0.1);
            let mut q = [random.between(-0.4, 0.4), random.between(-3.0, 3.0)];
            let radius = random.between(0.01, 0.1);
            let (mut rows, mut middles) = (vec![q], Vec::new());
            for _ in 0..n {
                q = [(q[0] + random.between(-0.1, 0.1)).clamp(-0.55, 0.55), q[1] + random.between(-0.8, 0.8)];
                rows.push(q);
            }
            for q in &rows {
                let off = Vector::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
                middles.push((pair.axis(*q) + off * (0.5 * radius)).normalize());
            }
            let feed = |a: usize, b: usize| step * (b - a) as f64;
            let own: f64 = rows
                .windows(2)
                .map(|p| (0..2).map(|j| (p[1][j] - p[0][j]).abs() / pair.velocity[j]).fold(step, f64::max))
                .sum();
            let caps = Caps { middles, radius };
            let Some(found) = CellBound::new(&pair, &caps, feed) else { continue };
            assert!(found.time <= own + 1e-12, "{} above {own}", found.time);
            forced += usize::from(found.time > 1.02 * feed(0, n));
            near = near.min(own / found.time);
            // At the same cells every edge costs no more.
            let same = |caps: &Caps, pair: &AxisPair| {
                let grid = JointGrid { pair, caps, counts: found.counts, size: found.size };
                let feeds: Vec<f64> = found.stations.windows(2).map(|p| feed(p[0], p[1])).collect();
                grid.potentials(&found.stations, &feeds, false).map(|cells| least_of(&cells))
            };
            let wider = Caps { radius: 1.2 * caps.radius, ..caps.clone() };
            let faster = AxisPair { velocity: [1.5 * pair.velocity[0], pair.velocity[1]], ..pair };
            for bound in [same(&wider, &pair), same(&caps, &faster)].into_iter().flatten() {
                assert!(bound <= found.time + 1e-12, "{bound} above {}", found.time);
            }
        }
        assert!(forced > 10 && near < 1.5, "{forced} {near}");
    }
}
