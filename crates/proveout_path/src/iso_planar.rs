//! Lines in parallel planes: curves `N . S(u, v) = d`, followed by predictor and corrector (Allgower and
//! Georg 1990, chapter 3).

use std::cell::RefCell;

use proveout_blade::{Domain, ParametricSurface};
use proveout_geom::{Point, Vector};

use super::{
    Line, PathError, Spacing, Strategy, Task,
    curve::fitted,
    error::{LEAST_SCALLOP_MM, UNIT},
    families::{check_along, within},
    strategy::to_and_fro,
};

/// Lines in parallel planes.
#[derive(Clone, Debug, PartialEq)]
pub struct IsoPlanar {
    /// Unit normal of the planes, frame of the surface.
    pub normal: Vector,
    /// First and last distance from the origin along the normal, mm.
    pub range: [f64; 2],
    /// Round the section, parts of the domain.
    pub round: [f64; 2],
    /// Along the blade, parts of the domain.
    pub along: [f64; 2],
    /// Where the planes lie; values in mm.
    pub spacing: Spacing,
}

/// Places on a rim, and lines inside of it, at which curves are looked for.
const SCAN: usize = 720;
const INNER: usize = 12;
/// Turn of the direction within a step, radian: above it the step is halved, below a third of it made longer.
const TURN: f64 = 0.1;
/// Longest and shortest step, mm.
const STEPS: [f64; 2] = [1e-5, 1.0];
/// Steps of a curve beyond which it is no curve.
const MOST_STEPS: usize = 400_000;
/// Sine of the angle between plane and surface below which lines in planes have no distance of their own.
const ALONG: f64 = 0.02;
/// Sine of the angle between plane and surface below which they touch: no curve leaves from there.
const TOUCHES: f64 = 1e-6;
/// Distance from the plane at which a correction ends, mm.
const ON_PLANE_MM: f64 = 1e-12;
/// Least square of the length of a chord, mm2: the place on it stays finite.
const NO_CHORD_MM2: f64 = 1e-30;
/// A seed this near to a curve, with a tenth of the chord there, is on it, mm.
const KNOWN_MM: f64 = 1e-3;
/// Two points of a curve nearer than this are one, mm.
const SAME_POINT_MM: f64 = 1e-7;
/// Shortest step from plane to plane, mm: with shorter ones the lines come to no end.
const LEAST_STEP_MM: f64 = 1e-9;

struct PlaneCut<'a> {
    surface: &'a dyn ParametricSurface,
    normal: Vector,
    distance: f64,
    domain: Domain,
}

impl PlaneCut<'_> {
    fn height(&self, [u, v]: [f64; 2]) -> f64 {
        self.surface.local(u, v).point.coords.dot(&self.normal) - self.distance
    }

    /// Direction of the curve in the parameter plane for each mm, the same in space; none where the surface
    /// touches the plane.
    fn direction(&self, [u, v]: [f64; 2]) -> Option<([f64; 2], Vector)> {
        let [su, sv] = self.surface.local(u, v).first;
        let (gu, gv) = (su.dot(&self.normal), sv.dot(&self.normal));
        let way = su * gv - sv * gu;
        let length = way.norm();
        // |way| is |S_u x S_v| times the sine of the angle between plane and surface.
        (length > TOUCHES * su.cross(&sv).norm()).then(|| ([gv / length, -gu / length], way / length))
    }

    /// Back onto the plane, across the curve.
    fn corrected(&self, mut at: [f64; 2]) -> [f64; 2] {
        for _ in 0..8 {
            let local = self.surface.local(at[0], at[1]);
            let off = local.point.coords.dot(&self.normal) - self.distance;
            let [su, sv] = local.first;
            let (e, f, g) = (su.norm_squared(), su.dot(&sv), sv.norm_squared());
            let (gu, gv) = (su.dot(&self.normal), sv.dot(&self.normal));
            let det = e * g - f * f;
            let (a, b) = ((g * gu - f * gv) / det, (e * gv - f * gu) / det);
            let slope = gu * a + gv * b;
            if off.abs() < ON_PLANE_MM || slope <= 0.0 {
                break;
            }
            at = [at[0] - off * a / slope, at[1] - off * b / slope];
        }
        at
    }

    fn inside(&self, at: [f64; 2]) -> bool {
        let d = &self.domain;
        (d.u_closed || at[0] >= d.u[0] && at[0] <= d.u[1]) && at[1] >= d.v[0] && at[1] <= d.v[1]
    }

    /// The way from a start in one sense until it leaves the domain or comes back.
    fn follow(&self, start: [f64; 2], sense: f64) -> Result<(Vec<[f64; 2]>, bool), PathError> {
        let Some((mut way, mut ahead)) = self.direction(start) else { return Ok((vec![start], false)) };
        let mut points = vec![start];
        let origin = self.surface.local(start[0], start[1]).point;
        let mut at = start;
        let mut step = 0.1;
        let mut length = 0.0;
        while points.len() < MOST_STEPS {
            let [next, gone] = loop {
                let moved = |h: f64| self.corrected([at[0] + sense * h * way[0], at[1] + sense * h * way[1]]);
                let next = moved(step);
                let turned = self
                    .direction(next)
                    .map_or(f64::INFINITY, |(_, there)| ahead.cross(&there).norm().atan2(ahead.dot(&there)));
                if turned > TURN && step > STEPS[0] {
                    step = (0.5 * step).max(STEPS[0]);
                    continue;
                }
                if !turned.is_finite() {
                    let what = "a plane touches the surface: its line has a branch there".to_owned();
                    return Err(PathError::NoLine { what, section: super::sections::part(at[1], self.domain.v) });
                }
                if !self.inside(next) {
                    // Up to the rim.
                    let (mut low, mut high) = (0.0, step);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if self.inside(moved(middle)) { low = middle } else { high = middle }
                    }
                    points.push(moved(low));
                    return Ok((points, false));
                }
                let gone = step;
                if turned < TURN / 3.0 {
                    step = (1.5 * step).min(STEPS[1]);
                }
                break [next, [gone, 0.0]];
            };
            let there = self.surface.local(next[0], next[1]).point;
            length += gone[0];
            if length > 4.0 * gone[0] && (there - origin).norm() < 0.75 * gone[0] {
                // Round: the start once more, on the turn that has been reached.
                let period = self.domain.u[1] - self.domain.u[0];
                let turns = if self.domain.u_closed { ((next[0] - start[0]) / period).round() } else { 0.0 };
                points.push([start[0] + turns * period, start[1]]);
                return Ok((points, true));
            }
            points.push(next);
            at = next;
            match self.direction(at) {
                Some((w, a)) => (way, ahead) = (w, a),
                None => break,
            }
        }
        Err(PathError::TooLong)
    }

    /// Zeros of the height on a straight way in the parameter plane.
    fn zeros(&self, from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
        let at = |s: f64| [from[0] + (to[0] - from[0]) * s, from[1] + (to[1] - from[1]) * s];
        let values: Vec<f64> = (0..=SCAN).map(|k| self.height(at(k as f64 / SCAN as f64))).collect();
        let mut found = Vec::new();
        for k in 0..SCAN {
            if (values[k] < 0.0) != (values[k + 1] < 0.0) {
                let (mut low, mut high) = (k as f64 / SCAN as f64, (k + 1) as f64 / SCAN as f64);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if (self.height(at(middle)) < 0.0) == (values[k] < 0.0) { low = middle } else { high = middle }
                }
                found.push(at(0.5 * (low + high)));
            }
        }
        found
    }

    /// All curves, each as points in the parameter plane.
    fn curves(&self) -> Result<Vec<Vec<[f64; 2]>>, PathError> {
        let ([u0, u1], [v0, v1]) = (self.domain.u, self.domain.v);
        let mut seeds = [self.zeros([u0, v0], [u1, v0]), self.zeros([u0, v1], [u1, v1])].concat();
        if !self.domain.u_closed {
            seeds.extend([self.zeros([u0, v0], [u0, v1]), self.zeros([u1, v0], [u1, v1])].concat());
        }
        for k in 0..INNER {
            let u = u0 + (u1 - u0) * (k as f64 + 0.37) / INNER as f64;
            let v = v0 + (v1 - v0) * (k as f64 + 0.37) / INNER as f64;
            seeds.extend(self.zeros([u, v0], [u, v1]));
            seeds.extend(self.zeros([u0, v], [u1, v]));
        }
        let place = |p: &[f64; 2]| self.surface.local(p[0], p[1]).point;
        let mut curves: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut followed: Vec<Vec<Point>> = Vec::new();
        for seed in seeds {
            let here = place(&seed);
            let known = followed.iter().any(|curve| {
                curve.windows(2).any(|w| {
                    let d = w[1] - w[0];
                    let s = ((here - w[0]).dot(&d) / d.norm_squared().max(NO_CHORD_MM2)).clamp(0.0, 1.0);
                    (here - w[0] - d * s).norm() < KNOWN_MM + 0.1 * d.norm()
                })
            });
            if known {
                continue;
            }
            let (mut points, closed) = self.follow(seed, 1.0)?;
            if !closed {
                let (mut back, _) = self.follow(seed, -1.0)?;
                back.reverse();
                back.pop();
                back.extend(points);
                points = back;
            }
            // A seed on a corner of the domain leaves nothing.
            points.dedup_by(|a, b| (place(a) - place(b)).norm() < SAME_POINT_MM);
            if points.len() > 2 {
                followed.push(points.iter().map(place).collect());
                curves.push(points);
            }
        }
        Ok(curves)
    }
}

impl IsoPlanar {
    /// The lines in one plane, in a fixed order.
    fn in_plane(&self, task: &Task<'_>, distance: f64) -> Result<Vec<Line>, PathError> {
        let domain = task.surface.domain();
        let part = |range: [f64; 2], parts: [f64; 2]| [within(range, parts[0]), within(range, parts[1])];
        let whole = domain.u_closed && self.round == [0.0, 1.0];
        let domain = Domain { u: part(domain.u, self.round), v: part(domain.v, self.along), u_closed: whole };
        let cut = PlaneCut { surface: task.surface, normal: self.normal, distance, domain };
        let mut lines = Vec::new();
        for points in cut.curves()? {
            let mut t = vec![0.0];
            for w in points.windows(2) {
                let [a, b] = [w[0], w[1]].map(|p| task.surface.local(p[0], p[1]).point);
                t.push(t[t.len() - 1] + (b - a).norm());
            }
            let curve = fitted(&t, &points, "the curve in a plane", 0.0)?;
            // All in the same direction: along growing v, or growing u where they run round.
            let [from, to] = [points[0], points[points.len() - 1]];
            let back = if (to[1] - from[1]).abs() > 0.2 * (domain.v[1] - domain.v[0]) {
                to[1] < from[1]
            } else {
                to[0] < from[0]
            };
            let curve = if back { curve.reversed() } else { curve };
            lines.push(Line::new(format!("plane {distance:.4} mm"), curve));
        }
        Ok(lines)
    }
}

impl Strategy for IsoPlanar {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        PathError::within("the length of the planes' normal", self.normal.norm(), 1.0 - UNIT, 1.0 + UNIT)?;
        check_along(self.along)?;
        check_along(self.round)?;
        let mut lines = Vec::new();
        match &self.spacing {
            Spacing::At(distances) => {
                for &distance in distances {
                    let found = self.in_plane(task, distance)?;
                    if found.is_empty() {
                        let what = format!("the plane at {distance} mm does not meet the surface");
                        return Err(PathError::NoLine { what, section: self.along[0] });
                    }
                    lines.extend(found);
                }
            }
            Spacing::Scallop(height) => {
                PathError::within("the scallop in mm", *height, LEAST_SCALLOP_MM, 10.0)?;
                let [from, to] = self.range;
                let mut distance = from;
                loop {
                    let found = self.in_plane(task, distance)?;
                    let least = RefCell::new(f64::INFINITY);
                    for line in &found {
                        for (place, allowed) in task.looks(line, *height)? {
                            // A step d of the planes is d / sin on the surface.
                            let sine = self.normal.dot(&place.across).abs();
                            if sine < ALONG {
                                return Err(PathError::NoSideStep {
                                    at: place.named(&task.surface.domain()),
                                    scallop_mm: *height,
                                    reason: "the surface lies along the planes: their lines have no distance there",
                                });
                            }
                            let mut least = least.borrow_mut();
                            *least = least.min(allowed * sine);
                        }
                    }
                    lines.extend(found);
                    if distance == to {
                        break;
                    }
                    // Where a plane does not meet the surface the next ones come by small steps.
                    let least = least.into_inner();
                    let step = if least.is_finite() { 0.99 * least } else { 0.02 * (to - from).abs() };
                    distance = if (to - distance).abs() <= step { to } else { distance + step.copysign(to - from) };
                    if lines.len() > 100_000 || step < LEAST_STEP_MM {
                        return Err(PathError::TooLong);
                    }
                }
                if lines.is_empty() {
                    let what = format!("no plane from {from} to {to} mm meets the surface");
                    return Err(PathError::NoLine { what, section: self.along[0] });
                }
            }
        }
        to_and_fro(&mut lines);
        Ok(lines)
    }
}
