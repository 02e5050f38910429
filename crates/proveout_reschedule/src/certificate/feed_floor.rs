//! What a programmed feed proves of the time of blocks, whatever a control makes of their corners.
//!
//! *What is known.* Block i leads the tip (without tool center point control the linear joints) from `p_i` to
//! `p_i+1`, as far as `L_i`, and is given the time `t_i`: on the way that is run the tip makes no more than
//! `L_i / t_i` mm a second. At the border of two blocks the tip is within e of `p_i`; in between it may go as
//! it likes. With `d_i` the direction of the block and `u_i = d_i t_i / L_i`, every way y takes in block i
//!
//! ```text
//!   T_i  >=  |y_i+1 - y_i| t_i / L_i  >=  u_i . (y_i+1 - y_i)            since |u_i| = t_i / L_i
//! ```
//!
//! Put `y_i = p_i + o_i` with `|o_i| <= e` and sum from gate a to gate b; of the borders inside only the bend
//! of u is left:
//!
//! ```text
//!   sum T_i  >=  sum t_i - e sum |u_i - u_i-1| - e |u_a| - e |u_b-1|
//!                          inside a .. b       at both ends
//! ```
//!
//! So a corner of angle g at the feed F costs at most `2 e sin(g/2) / F`, and a curve `e / F` for a radian,
//! however many blocks it has: what a single block may lose, `2 e / L_i` of its time, its neighbors have.
//! This is the dual of the shortest way through balls of radius e about the points, with the directions of
//! the blocks for the dual variables.
//!
//! *Per block.* Half of a bend is taken from each side of it: `least_i = t_i - (k_i + k_i+1) / 2` with `k_i =
//! e |u_i - u_i-1|`, zero at the ends. A window from gate to gate then takes at least the sum of `least` less
//! `seam = e |u| - k / 2` at either end, with the larger `|u|` of both sides. A single block is a window as
//! well.
//!
//! *Several ways.* Schedules of one channel have different ways of the tip. Of several the largest bend and
//! the largest `|u|` are taken at each border: the floor is about every schedule that bends no more there,
//! and whose blocks are no shorter for their time. That is a condition, not a theorem: a schedule whose axes
//! go to and fro from block to block zigzags with its tip, its feed is that of the zigzag, and rounding cuts
//! it short.

use proveout_geom::Point;

/// What the feed proves of a stretch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FeedFloor {
    /// Of each block, s.
    pub least: Vec<f64>,
    /// What a window of blocks loses where it begins or ends, of each border, s.
    pub seams: Vec<f64>,
}

impl FeedFloor {
    /// The floor of blocks with times (s) from the ways of the tip in some schedules, each with a point (mm)
    /// more than there are blocks; the control leaves points by at most `off` (mm) and passes the feed by a
    /// part.
    ///
    /// # Errors
    /// The first block that is too short compared with the rounding: nothing is left of its time.
    pub fn new(times: &[f64], ways: &[&[Point]], off: f64, passed: f64) -> Result<Self, usize> {
        let n = times.len();
        let mut bends = vec![0.0_f64; n + 1];
        let mut slow = vec![0.0_f64; n];
        for way in ways {
            let mut last = None;
            for (i, (pair, time)) in way.windows(2).zip(times).enumerate() {
                let step = pair[1] - pair[0];
                let length = step.norm();
                if length.is_nan() || length <= off {
                    return Err(i);
                }
                let u = step * (time / (length * length));
                slow[i] = slow[i].max(time / length);
                if let Some(before) = last.replace(u) {
                    bends[i] = bends[i].max(off * (u - before).norm());
                }
            }
        }
        let least: Vec<f64> = (0..n).map(|i| (times[i] - 0.5 * (bends[i] + bends[i + 1])) / (1.0 + passed)).collect();
        if let Some(block) = least.iter().position(|t| t.is_nan() || *t <= 0.0) {
            return Err(block);
        }
        let seam = |i: usize| {
            let beside = slow.get(i).copied().unwrap_or(0.0).max(if i > 0 { slow[i - 1] } else { 0.0 });
            (off * beside - 0.5 * bends[i]) / (1.0 + passed)
        };
        Ok(Self { seams: (0..=n).map(seam).collect(), least })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Random;
    use super::*;
    use proveout_geom::Vector;

    /// A wavy way, its times, and how far a control leaves its points.
    fn way(random: &mut Random) -> (Vec<Point>, Vec<f64>, f64) {
        let n = 2 + (40.0 * random.next()) as usize;
        let bend = random.between(0.0, 0.6);
        let (mut angle, mut p) = (0.0, Point::origin());
        let mut points = vec![p];
        let times: Vec<f64> = (0..n).map(|_| random.between(0.02, 0.05)).collect();
        for _ in 0..n {
            angle += random.between(-bend, bend);
            let tilt = random.between(-0.2, 0.2);
            p += Vector::new(f64::cos(angle), f64::sin(angle), tilt) * random.between(0.3, 1.0);
            points.push(p);
        }
        (points, times, random.between(0.0, 0.05))
    }

    /// A way through the balls about the points that is made short, point by point: the most that a control
    /// could save.
    fn shortened(points: &[Point], rate: &[f64], off: f64) -> Vec<Point> {
        let mut y = points.to_vec();
        for _ in 0..400 {
            for i in 0..y.len() {
                // Against the slope of the weighted length, back into the ball.
                let mut slope = Vector::zeros();
                if i > 0 {
                    let d = y[i] - y[i - 1];
                    slope += d * (rate[i - 1] / d.norm().max(1e-9));
                }
                if i + 1 < y.len() {
                    let d = y[i] - y[i + 1];
                    slope += d * (rate[i] / d.norm().max(1e-9));
                }
                let size = rate.iter().fold(0.0_f64, |m, r| m.max(*r));
                let moved = y[i] - slope * (0.2 * off / size) - points[i];
                y[i] = points[i] + moved * (off / moved.norm()).min(1.0);
            }
        }
        y
    }

    #[test]
    fn no_way_through_the_balls_is_shorter_in_any_window() {
        let mut random = Random(5);
        let mut nearest = f64::INFINITY;
        for _ in 0..300 {
            let (points, times, off) = way(&mut random);
            let floor = FeedFloor::new(&times, &[&points], off, 0.0).expect("long blocks");
            let rate: Vec<f64> = points.windows(2).zip(&times).map(|(p, t)| t / (p[1] - p[0]).norm()).collect();
            let jittered: Vec<Point> = points
                .iter()
                .map(|p| {
                    let v =
                        Vector::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
                    p + v * (off / v.norm().max(1.0))
                })
                .collect();
            for y in [shortened(&points, &rate, off), jittered, points.clone()] {
                let taken: Vec<f64> = y.windows(2).zip(&rate).map(|(p, r)| (p[1] - p[0]).norm() * r).collect();
                for a in 0..times.len() {
                    let (mut time, mut least) = (0.0, 0.0);
                    for (b, (own, proved)) in taken.iter().zip(&floor.least).enumerate().skip(a) {
                        time += own;
                        least += proved;
                        let proved = least - floor.seams[a] - floor.seams[b + 1];
                        assert!(time >= proved - 1e-12, "{a}..{b}: {time} below {proved}");
                        if off > 1e-3 && b > a + 10 {
                            nearest = nearest.min(time / proved);
                        }
                    }
                }
            }
        }
        assert!(nearest < 1.02, "no way comes near: {nearest}");
    }

    #[test]
    fn a_straight_way_loses_its_ends_and_a_circle_its_angle() {
        let straight: Vec<Point> = (0..=10).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
        let floor = FeedFloor::new(&[0.1; 10], &[&straight], 0.01, 0.0).expect("long");
        assert!(floor.least.iter().all(|t| (t - 0.1).abs() < 1e-15));
        assert!(floor.seams.iter().all(|t| (t - 0.001).abs() < 1e-15), "0.01 mm at 10 mm/s");
        let n = 360;
        let circle: Vec<Point> = (0..=n)
            .map(|i| {
                let a = f64::from(i).to_radians();
                Point::new(50.0 * a.cos(), 50.0 * a.sin(), 0.0)
            })
            .collect();
        let step = 2.0 * 50.0 * 0.5_f64.to_radians().sin();
        let times = vec![step / 20.0; n as usize];
        let floor = FeedFloor::new(&times, &[&circle], 0.01, 0.0).expect("long");
        let lost: f64 = times.iter().zip(&floor.least).map(|(t, l)| t - l).sum();
        let angle = 359.0 * 2.0 * 0.5_f64.to_radians().sin();
        assert!((lost - 0.01 / 20.0 * angle).abs() < 1e-12, "{lost}");
    }

    #[test]
    fn of_several_ways_the_sharper_one_counts_and_a_block_that_stands_is_named() {
        let straight: Vec<Point> = (0..=4).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
        let mut bent = straight.clone();
        bent[2].y = 0.5;
        let [one, both] =
            [&[&bent[..]][..], &[&straight, &bent]].map(|ways| FeedFloor::new(&[0.1; 4], ways, 0.01, 0.0));
        assert!(both.as_ref().expect("long").least.iter().zip(&one.expect("long").least).all(|(b, o)| b <= o));
        let mut stands = straight;
        stands[3] = stands[2];
        assert_eq!(FeedFloor::new(&[0.1; 4], &[&stands], 0.01, 0.0), Err(2));
        // A corner sharper than there is way for.
        let zigzag: Vec<Point> = (0..=4).map(|i| Point::new(f64::from(i % 2) * 0.015, 0.0, 0.0)).collect();
        assert!(FeedFloor::new(&[0.1; 4], &[&zigzag], 0.01, 0.0).is_err());
    }
}
