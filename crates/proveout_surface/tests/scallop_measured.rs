//! Ridges that are found on a cut stock against closed forms: ball and bull-nose on plane, convex and concave
//! cylinder.
//!
//! The design lies askew in the stock, so that no ray runs along anything; passes run along the cylinder, to
//! and fro, with the axis leaning along the feed. Cells are 0.15 mm, a fifth of the step and some hundred
//! times the bound that is asked for.
#![allow(clippy::print_stdout, reason = "figures for people, shown with --nocapture")]

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_surface::{
    DesignSurface, NearestOnDesign,
    scallop::{RidgeSettings, Ridges, ball_scallop, by_pass, by_patch, heights, histogram, ridges},
    topography::{PathPiece, SweptPath},
};
use proveout_tool::{Cutter, Profile};

/// What is asked for, mm.
const BOUND: f64 = 1e-4;
const CELL: f64 = 0.15;

/// A cylinder along `along` (or a plane), with material on the inner side where the curvature is positive.
struct Design {
    origin: Point,
    along: Vector,
    up: Vector,
    curvature: f64,
}

impl Design {
    fn askew(curvature: f64) -> Self {
        let along = Vector::new(0.9, 0.4, 0.1).normalize();
        let up = (Vector::new(-0.1, 0.2, 1.0) - along * along.dot(&Vector::new(-0.1, 0.2, 1.0))).normalize();
        Self { origin: Point::new(0.0, 0.0, 0.0), along, up, curvature }
    }

    /// Point and normal at arc length `s` to the left and `t` along.
    fn at(&self, s: f64, t: f64) -> (Point, Vector) {
        let left = self.up.cross(&self.along);
        let angle = s * self.curvature;
        let normal = self.up * angle.cos() + left * angle.sin();
        let aside = if angle.abs() < 1e-12 { s } else { angle.sin() / self.curvature };
        let down = if angle.abs() < 1e-12 { 0.0 } else { (angle.cos() - 1.0) / self.curvature };
        (self.origin + self.along * t + left * aside + self.up * down, normal)
    }
}

impl DesignSurface for Design {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let d = p - self.origin;
        let (distance, normal) = if self.curvature == 0.0 {
            (d.dot(&self.up), self.up)
        } else {
            let center = self.up * (-1.0 / self.curvature);
            let out = d - center;
            let out = out - self.along * out.dot(&self.along);
            let sign = self.curvature.signum();
            (sign * out.norm() - 1.0 / self.curvature, out.normalize() * sign)
        };
        (distance.abs() <= range).then_some(NearestOnDesign { distance, normal })
    }
}

struct Job {
    design: Design,
    profile: Profile,
    corner: f64,
    radius: f64,
    lean: f64,
    step: f64,
}

impl Job {
    /// Tool pose that touches the design at (s, t), leaning along the feed.
    fn pose(&self, s: f64, t: f64, sense: f64) -> ToolPose {
        let (point, normal) = self.design.at(s, t);
        let axis = normal * self.lean.cos() + self.design.along * (sense * self.lean.sin());
        let aside = (normal - axis * normal.dot(&axis)).try_normalize(1e-9).unwrap_or_else(Vector::zeros);
        ToolPose { tip: point + normal * self.corner + aside * (self.radius - self.corner) - axis * self.corner, axis }
    }

    fn cut(&self) -> (TriDexel, SweptPath) {
        let size = Vector::new(5.0, 5.0, 2.5);
        let bounds = Aabb { min: Point::from(-size), max: Point::from(size) };
        let mut stock = TriDexel::from_box(&bounds, CELL, 1 << 30).expect("a stock");
        let mut pieces = Vec::new();
        let rows = (7.0 / self.step).ceil() as i32;
        for row in -rows..=rows {
            let sense = if row % 2 == 0 { 1.0 } else { -1.0 };
            let s = f64::from(row) * self.step;
            // Each pass in five pieces, and a lift between the passes that cuts nothing.
            for k in 0..5 {
                let t = |k: i32| sense * (f64::from(k) * 4.0 - 10.0);
                let (from, to) = (self.pose(s, t(k), sense), self.pose(s, t(k + 1), sense));
                pieces.push(PathPiece { from, to, cutter: Some(0) });
            }
        }
        let items: Vec<SweepItem<'_>> = pieces
            .iter()
            .enumerate()
            .map(|(k, p)| SweepItem {
                id: k as u32,
                body: &self.profile,
                action: Action::Remove,
                motion: SweepMotion { from: p.from, to: p.to },
            })
            .collect();
        stock.sweep(&items);
        (stock, SweptPath::new(pieces, &[vec![self.profile.clone()]]))
    }

    fn measure(&self) -> (Ridges, f64) {
        let (stock, path) = self.cut();
        let size = Vector::new(3.0, 3.0, 3.0);
        let region = Aabb { min: Point::from(-size), max: Point::from(size) };
        let settings = RidgeSettings { reach: 0.5, region: Some(region), window: None, finer: &[], most: 4000 };
        let cutters = [vec![self.profile.clone()]];
        (ridges(&stock, &path, &cutters, &self.design, &settings), stock.sweep_bound_mm())
    }

    /// The ridge of two equal passes on the half plane between them: the place of the profile across the feed
    /// (an ellipse of the corner's center, grown by the corner) that lies on the line from the cylinder's
    /// axis half way between the contacts.
    fn closed_form(&self) -> f64 {
        let (a, b, r) = (self.radius - self.corner, (self.radius - self.corner) * self.lean.sin(), self.corner);
        let half = 0.5 * self.step * self.design.curvature;
        let (sine, cosine) = half.sin_cos();
        // In the frame of the right contact the half plane begins at `foot` of the design and runs along `n`.
        let foot = if half.abs() < 1e-12 {
            [0.5 * self.step, 0.0]
        } else {
            [sine / self.design.curvature, (cosine - 1.0) / self.design.curvature]
        };
        let at = |t: f64| {
            let (s, c) = t.sin_cos();
            let n = (b * s).hypot(a * c);
            let grown = if n > 0.0 { [r * b * s / n, r * a * c / n] } else { [r * s, r * c] };
            let p = [a * s + grown[0] - foot[0], b + r - b * c - grown[1] - foot[1]];
            // Aside of the half plane, and along it.
            (p[0] * cosine - p[1] * sine, p[0] * sine + p[1] * cosine)
        };
        let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if at(middle).0 < 0.0 { low = middle } else { high = middle }
        }
        at(low).1
    }
}

fn jobs() -> Vec<(&'static str, Job)> {
    let mut jobs = Vec::new();
    for (name, curvature) in [("plane", 0.0), ("convex", 0.05), ("concave", -0.05)] {
        let ball = Cutter::ball(6.0).and_then(|c| c.bodies(15.0)).expect("a ball").remove(0);
        let bull = Cutter::bull_nose(8.0, 2.0).and_then(|c| c.bodies(15.0)).expect("a bull-nose").remove(0);
        for lean in [0.0, 0.25] {
            let design = Design::askew(curvature);
            jobs.push((name, Job { design, profile: ball.clone(), corner: 3.0, radius: 3.0, lean, step: 0.7 }));
        }
        for lean in [0.15, 0.4] {
            let design = Design::askew(curvature);
            jobs.push((name, Job { design, profile: bull.clone(), corner: 2.0, radius: 4.0, lean, step: 0.8 }));
        }
    }
    jobs
}

#[test]
fn ridges_on_the_cut_surface_have_the_height_of_the_closed_form() {
    for (name, job) in jobs() {
        let exact = job.closed_form();
        if job.radius == job.corner {
            let half = 0.5 * job.step * job.design.curvature;
            let chord = if half.abs() < 1e-12 { job.step } else { 2.0 * half.sin() / job.design.curvature };
            let other = ball_scallop(3.0, chord.abs(), job.design.curvature).expect("a ridge");
            assert!((exact - other).abs() < 1e-13, "the two closed forms: {exact} {other}");
        }
        let (found, bound) = job.measure();
        let all = heights(&found.ridges).expect("ridges");
        let worst = found.ridges.iter().map(|r| (r.height - exact).abs()).fold(0.0, f64::max);
        let geometric: Vec<f64> = found.ridges.iter().map(|r| r.geometric.expect("both valleys")).collect();
        let off = geometric.iter().map(|g| (g - exact).abs()).fold(0.0, f64::max);
        let apart = found.ridges.iter().map(|r| (r.spacing.expect("valleys") - job.step).abs()).fold(0.0, f64::max);
        let bent = found.ridges.iter().map(|r| (r.curvature.expect("valleys") - job.design.curvature).abs());
        let bent = bent.fold(0.0, f64::max);
        println!(
            "{name:8} r {} lean {:4}: exact {:.6} um, {} places on {:.1} mm, mean {:.6}, p95 {:.6}, off at most {:.2e} um; geometric off \
             {:.2e} um; step off {apart:.1e} mm, curvature {bent:.1e}; sweeps {bound:.1e}, check {:.1e}, not followed {}",
            job.corner,
            job.lean,
            1e3 * exact,
            all.places,
            all.length,
            1e3 * all.mean,
            1e3 * all.p95,
            1e3 * worst,
            1e3 * off,
            found.largest_check,
            found.not_followed
        );
        assert!(worst < BOUND && off < BOUND, "{name}: {worst} {off}");
        // Well below what is asked for: rounding, not a bound of the grid.
        assert!(worst < 1e-8, "{name}: {worst}");
        assert!(apart < 1e-5 && bent < 1e-5, "{name}: {apart} {bent}");
        assert_eq!(found.not_followed, 0, "{name}");
        // A ridge every step over the cut of the box with the design, 36 mm2 over the slope of a plane; four
        // figures of ridges that end at its border.
        let area = 36.0 / job.design.up.z;
        let length = all.length * job.step;
        assert!((length / area - 1.0).abs() < 0.06, "{name}: {length} mm2 of {area}");
        // Passes are distinct, and none cuts two rows.
        let passes = by_pass(&found.ridges);
        assert!(
            passes.iter().all(|p| p.first_piece % 5 < 5) && (6..=14).contains(&passes.len()),
            "{name}: {}",
            passes.len()
        );
        let patches = by_patch(&found.ridges, 4.0);
        assert!(patches.iter().map(|p| p.heights.places).sum::<u64>() == all.places);
        let bars = histogram(&found.ridges);
        assert!((bars.lengths.iter().sum::<f64>() - all.length).abs() < 1e-9);
    }
}
