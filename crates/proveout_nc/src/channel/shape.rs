//! Shapes of pockets, slots and studs, and the paths of the tool center along them, in the plane of a cycle.
//!
//! ```text
//!     .-----------------.           A shape is given by its finished wall, about the origin. A ring at the
//!    /  .-----------.    \          inset d runs d inside of it (d below zero: outside), counter-clockwise
//!   |  |    ring     o start        from its start. The spine is what is left of the ring where the inset
//!    \  '-----------'    /          is half of the width.
//!     '-----------------'
//! ```

use std::f64::consts::TAU;

use crate::frame::sin_cos_degrees;

pub(crate) type Point = [f64; 2];

/// Widths below this are none, mm.
pub(crate) const NO_WIDTH_MM: f64 = 1e-6;
/// An arc of more than this is a full turn, radian: rounding.
const FULL_TURN: f64 = TAU - 1e-9;

/// A piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Leg {
    Line(Point),
    Arc { to: Point, center: Point, clockwise: bool },
}

/// A path from its start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pass {
    pub(crate) start: Point,
    pub(crate) legs: Vec<Leg>,
}

/// The finished wall of a pocket, slot or stud, mm and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Rectangle with half sides a and b and rounded corners; a circle where all three are equal.
    Rounded { a: f64, b: f64, corner: f64 },
    /// Slot of this half width along a circle about the origin, from an angle through an angle above zero.
    Curved { pitch: f64, from: f64, through: f64, half: f64 },
}

fn polar(radius: f64, degrees: f64) -> Point {
    let (s, c) = sin_cos_degrees(degrees);
    [radius * c, radius * s]
}

fn plus(p: Point, d: Point, by: f64) -> Point {
    [p[0] + by * d[0], p[1] + by * d[1]]
}

fn left(d: Point) -> Point {
    [-d[1], d[0]]
}

impl Leg {
    pub(crate) fn end(&self) -> Point {
        match *self {
            Self::Line(to) | Self::Arc { to, .. } => to,
        }
    }
}

impl Pass {
    pub(crate) fn end(&self) -> Point {
        self.legs.last().map_or(self.start, Leg::end)
    }

    /// The same path from its end to its start.
    pub(crate) fn reversed(&self) -> Self {
        let mut starts = vec![self.start];
        starts.extend(self.legs.iter().map(Leg::end));
        let legs = self.legs.iter().zip(&starts).rev().map(|(leg, &to)| match *leg {
            Leg::Line(_) => Leg::Line(to),
            Leg::Arc { center, clockwise, .. } => Leg::Arc { to, center, clockwise: !clockwise },
        });
        Self { start: self.end(), legs: legs.collect() }
    }

    /// Direction at the start; none for a path without length.
    pub(crate) fn heading(&self) -> Option<Point> {
        let d = match *self.legs.first()? {
            Leg::Line(to) => [to[0] - self.start[0], to[1] - self.start[1]],
            Leg::Arc { center, clockwise, .. } => {
                let out = left([self.start[0] - center[0], self.start[1] - center[1]]);
                if clockwise { [-out[0], -out[1]] } else { out }
            }
        };
        let length = d[0].hypot(d[1]);
        (length > 0.0).then(|| [d[0] / length, d[1] / length])
    }

    /// A closed path with tangential arcs of this radius onto it and off it, through an angle of 90 or 180
    /// degrees each. `from_left`: on which side of the path they lie.
    pub(crate) fn with_leads(mut self, radius: f64, half_turns: bool, from_left: bool, on: bool) -> Self {
        let Some(t) = self.heading().filter(|_| radius > NO_WIDTH_MM) else { return self };
        let side = if from_left { left(t) } else { [t[1], -t[0]] };
        let p = self.start;
        let center = plus(p, side, radius);
        let beside = |sign: f64| if half_turns { plus(center, side, radius) } else { plus(center, t, sign * radius) };
        let clockwise = !from_left;
        self.legs.push(Leg::Arc { to: beside(1.0), center, clockwise });
        if on {
            self.legs.insert(0, Leg::Arc { to: p, center, clockwise });
            self.start = beside(-1.0);
        }
        self
    }
}

impl Shape {
    /// Half of the smaller width.
    pub(crate) fn half_width(&self) -> f64 {
        match *self {
            Self::Rounded { a, b, .. } => a.min(b),
            Self::Curved { half, .. } => half,
        }
    }

    /// The ring at an inset, counter-clockwise; where no width is left the spine there and back.
    pub(crate) fn ring(&self, inset: f64) -> Pass {
        if self.half_width() - inset <= NO_WIDTH_MM {
            return self.spine();
        }
        match *self {
            Self::Rounded { a, b, corner } => rounded(a - inset, b - inset, (corner - inset).max(0.0)),
            Self::Curved { pitch, from, through, half } => curved(pitch, from, through, half - inset),
        }
    }

    /// The middle line there and back.
    fn spine(&self) -> Pass {
        match *self {
            Self::Rounded { a, b, .. } => {
                let end = if a >= b { [a - b, 0.0] } else { [0.0, b - a] };
                let other = [-end[0], -end[1]];
                let legs = if end == other { Vec::new() } else { vec![Leg::Line(other), Leg::Line(end)] };
                Pass { start: end, legs }
            }
            Self::Curved { pitch, from, through, .. } => {
                let (start, end) = (polar(pitch, from), polar(pitch, from + through));
                let center = [0.0; 2];
                let there = Leg::Arc { to: end, center, clockwise: false };
                Pass { start, legs: vec![there, Leg::Arc { to: start, center, clockwise: true }] }
            }
        }
    }
}

/// From the middle of the right side.
fn rounded(a: f64, b: f64, corner: f64) -> Pass {
    let r = corner.min(a).min(b);
    let mut legs = Vec::new();
    let mut at = [a, 0.0];
    for quarter in 0..4 {
        // Corner at the end of this side, and the direction of the side.
        let (x, y) = [(a, b), (-a, b), (-a, -b), (a, -b)][quarter];
        let d = [[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]][quarter];
        let before = plus([x, y], d, -r);
        if (before[0] - at[0]).hypot(before[1] - at[1]) > NO_WIDTH_MM {
            legs.push(Leg::Line(before));
        }
        at = before;
        if r > NO_WIDTH_MM {
            at = plus([x, y], left(d), r);
            legs.push(Leg::Arc { to: at, center: plus(before, left(d), r), clockwise: false });
        }
    }
    if at[1].abs() > NO_WIDTH_MM {
        legs.push(Leg::Line([a, 0.0]));
    } else if let Some(Leg::Line(to) | Leg::Arc { to, .. }) = legs.last_mut() {
        *to = [a, 0.0];
    }
    Pass { start: [a, 0.0], legs }
}

/// From the outer end of the cap at the start of the slot.
fn curved(pitch: f64, from: f64, through: f64, w: f64) -> Pass {
    let to = from + through;
    let (outer, inner) = (pitch + w, pitch - w);
    let mut legs = vec![
        Leg::Arc { to: polar(outer, to), center: [0.0; 2], clockwise: false },
        Leg::Arc { to: polar(inner, to), center: polar(pitch, to), clockwise: false },
    ];
    if inner > NO_WIDTH_MM {
        legs.push(Leg::Arc { to: polar(inner, from), center: [0.0; 2], clockwise: true });
    } else {
        legs.push(Leg::Line(polar(inner, from)));
    }
    let start = polar(outer, from);
    legs.push(Leg::Arc { to: start, center: polar(pitch, from), clockwise: false });
    Pass { start, legs }
}

/// Where the cycle lies in the working plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    origin: Point,
    degrees: f64,
    /// Sine and cosine of the rotation.
    turn: (f64, f64),
}

impl Place {
    pub(crate) fn new(origin: Point, degrees: f64) -> Self {
        Self { origin, degrees, turn: sin_cos_degrees(degrees) }
    }

    /// Turned on about its origin.
    pub(crate) fn turned(&self, degrees: f64) -> Self {
        Self::new(self.origin, self.degrees + degrees)
    }

    /// A point of the cycle in the working plane.
    pub(crate) fn at(&self, p: Point) -> Point {
        let (s, c) = self.turn;
        [self.origin[0] + c * p[0] - s * p[1], self.origin[1] + s * p[0] + c * p[1]]
    }
}

/// Angle of an arc from its ends, radian; ends at one point are a full turn.
pub(crate) fn sweep(start: Point, end: Point, center: Point, clockwise: bool) -> f64 {
    let sweep = crate::arc::sweep(start, end, center, clockwise);
    if sweep > FULL_TURN { TAU } else { sweep }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 6] = [
        Shape::Rounded { a: 30.0, b: 20.0, corner: 5.0 },
        Shape::Rounded { a: 10.0, b: 25.0, corner: 10.0 },
        Shape::Rounded { a: 15.0, b: 15.0, corner: 15.0 },
        Shape::Rounded { a: 30.0, b: 20.0, corner: 0.0 },
        Shape::Curved { pitch: 40.0, from: 30.0, through: 70.0, half: 8.0 },
        Shape::Curved { pitch: 6.0, from: -20.0, through: 200.0, half: 5.0 },
    ];

    fn samples(pass: &Pass) -> Vec<Point> {
        let mut all = vec![pass.start];
        let mut at = pass.start;
        for leg in &pass.legs {
            match *leg {
                Leg::Line(to) => {
                    all.extend((1..=20).map(|i| plus(at, [to[0] - at[0], to[1] - at[1]], f64::from(i) / 20.0)))
                }
                Leg::Arc { to, center, clockwise } => {
                    let angle = sweep(at, to, center, clockwise);
                    let d = [at[0] - center[0], at[1] - center[1]];
                    assert!((d[0].hypot(d[1]) - (to[0] - center[0]).hypot(to[1] - center[1])).abs() < 1e-9, "{leg:?}");
                    for i in 1..=40 {
                        let (s, c) = (if clockwise { -angle } else { angle } * f64::from(i) / 40.0).sin_cos();
                        all.push([center[0] + c * d[0] - s * d[1], center[1] + s * d[0] + c * d[1]]);
                    }
                }
            }
            at = leg.end();
        }
        all
    }

    /// Signed distance to the wall, negative inside; computed independently of the rings.
    fn distance(shape: Shape, p: Point) -> f64 {
        match shape {
            Shape::Rounded { a, b, corner } => {
                let q = [p[0].abs() - a + corner, p[1].abs() - b + corner];
                q[0].max(0.0).hypot(q[1].max(0.0)) + q[0].max(q[1]).min(0.0) - corner
            }
            Shape::Curved { pitch, from, through, half } => {
                let angle = (p[1].atan2(p[0]).to_degrees() - from).rem_euclid(360.0);
                let caps = [from, from + through].map(|d| {
                    let c = polar(pitch, d);
                    (p[0] - c[0]).hypot(p[1] - c[1])
                });
                let ends = caps[0].min(caps[1]);
                (if angle <= through { (p[0].hypot(p[1]) - pitch).abs().min(ends) } else { ends }) - half
            }
        }
    }

    #[test]
    fn rings_keep_their_distance_from_the_wall_and_close() {
        for shape in SHAPES {
            for inset in [0.0, 1.0, 3.0, 4.9] {
                let ring = shape.ring(inset);
                assert_eq!(ring.start, ring.end(), "{shape:?} {inset}");
                let points = samples(&ring);
                for p in &points {
                    let d = distance(shape, *p);
                    assert!((d + inset).abs() < 1e-9, "{shape:?} inset {inset}: {p:?} is {d} from the wall");
                }
                // Counter-clockwise, by the area within.
                let area: f64 = points.windows(2).map(|w| w[0][0] * w[1][1] - w[0][1] * w[1][0]).sum();
                assert!(area > 0.0, "{shape:?} {inset}");
                let mut back = samples(&ring.reversed());
                back.reverse();
                assert!(points.iter().zip(&back).all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9), "{shape:?}");
            }
        }
    }

    #[test]
    fn outside_of_a_wall_corners_are_round() {
        let shape = Shape::Rounded { a: 30.0, b: 20.0, corner: 0.0 };
        for p in samples(&shape.ring(-6.0)) {
            assert!((distance(shape, p) - 6.0).abs() < 1e-9, "{p:?}");
        }
    }

    #[test]
    fn leads_are_tangential_and_stay_inside() {
        for shape in SHAPES {
            for reverse in [false, true] {
                let ring = shape.ring(2.0);
                let ring = if reverse { ring.reversed() } else { ring };
                let radius = 1.5;
                let whole = ring.clone().with_leads(radius, false, !reverse, true);
                for p in samples(&whole) {
                    assert!(distance(shape, p) < -2.0 + 1e-9, "{shape:?} {reverse} {p:?}");
                }
                // The arcs end and begin in the direction of the ring.
                let first = Pass { start: ring.start, legs: whole.legs[1..].to_vec() };
                let arc = Pass { start: whole.start, legs: whole.legs[..1].to_vec() }.reversed();
                let (a, b) = (first.heading().unwrap(), arc.heading().unwrap());
                assert!((a[0] + b[0]).hypot(a[1] + b[1]) < 1e-9, "{shape:?} {a:?} {b:?}");
            }
        }
    }
}
