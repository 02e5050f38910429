//! Patches and profiles as lattices of points on the design.
//!
//! ```text
//!        t |   . . . . . . .      nodes at equal steps along s (columns) and t (rows), both ends included,
//!          |   . . . o . . .      round the middle o
//!          |   . . . . . . .
//!          +------------------ s
//! ```
//!
//! On a blade a step in the tangent plane of the middle is turned into one of arc length and height by the
//! derivatives there, and the nodes are points of the closed form: along the section they lie at equal
//! distances exactly, across it as far as the twist is the same over the patch. On a mesh or a flank every
//! node is found from its neighbor: one step along the tangent plane, the nearest point of the design, the
//! direction laid into the surface there. A plane needs neither.

use std::sync::Arc;

use proveout_blade::Blade;
use proveout_geom::{Point, Vector};
use proveout_surface::{DesignSurface, topography::Lattice};

use crate::scene::surface::Middle;

/// A middle may be given as far as this off the design, mm.
const BESIDE_MM: f64 = 1.0;
/// Largest turn of the normal from node to node, radian: above it the patch runs over an edge.
const EDGE_RAD: f64 = 0.5;
/// Steps from the nearest point to a nearer one; a mesh needs two where the first is on an edge.
const FOOT_STEPS: usize = 3;
/// Sine of the angle to the normal below which a direction shows no way along the surface.
const ALONG_NORMAL: f64 = 1e-6;
/// A point that is closer to the design lies on it, mm.
const ON_SURFACE_MM: f64 = 1e-12;

/// Why there is no such place, and what to do.
pub(crate) type Refused = (String, String);

/// What patches lie on.
pub(crate) enum Ground {
    Design(Arc<dyn DesignSurface + Send>),
    Blade(Box<Blade>),
    /// Nothing but planes of their own.
    None,
}

/// Middle and directions of a patch or profile.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) middle: Point,
    pub(crate) normal: Vector,
    /// Direction of the columns, and of the rows: a right-handed frame with the normal.
    pub(crate) along: Vector,
    pub(crate) across: Vector,
    /// Arc length and height on a blade.
    on_blade: Option<[f64; 2]>,
    plane: bool,
}

/// Part of a direction in the plane across a normal.
fn laid(direction: &Vector, normal: &Vector) -> Option<Vector> {
    (direction - normal * direction.dot(normal)).try_normalize(ALONG_NORMAL)
}

fn coordinates(p: &Point) -> String {
    format!("X{:.3} Y{:.3} Z{:.3}", p.x, p.y, p.z)
}

impl Ground {
    /// The place of a middle; or why there is none, and what to do.
    pub(crate) fn place(&self, middle: &Middle<'_>, along: Option<[f64; 3]>) -> Result<Place, Refused> {
        let usual = |n: &Vector| if n.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        let finish = |point: Point, normal: Vector, usual: Vector, on_blade, plane| {
            let wanted = along.map_or(usual, Vector::from);
            let along = laid(&wanted, &normal).ok_or_else(|| {
                (
                    "`along` is perpendicular to the surface".to_owned(),
                    "give a direction that lies in the surface".to_owned(),
                )
            })?;
            Ok(Place { middle: point, normal, along, across: normal.cross(&along), on_blade, plane })
        };
        if let (Some(normal), Some(at)) = (middle.normal, middle.at) {
            let n = Vector::from(*normal).normalize();
            return finish(Point::from(*at), n, usual(&n), None, true);
        }
        match self {
            Self::None => Err((
                "the scene has no design part for it to lie on".into(),
                "give [part], or `normal`, which makes the patch a plane of its own".into(),
            )),
            Self::Blade(blade) => {
                let [arc, x] = match (middle.arc, middle.x, middle.at) {
                    (Some(arc), Some(x), _) => [arc, x],
                    (_, _, Some(at)) => nearest_on_blade(blade, &Point::from(*at))?,
                    _ => return Err(("it has no place".into(), "give `arc_mm` and `x_mm`".into())),
                };
                on_airfoil(blade, arc, x)?;
                let p = blade.at(arc, x);
                let [along_arc, _] = derivatives(blade, arc, x);
                finish(p.point, p.normal, along_arc, Some([arc, x]), false)
            }
            Self::Design(design) => {
                let Some(at) = middle.at else {
                    return Err(("`arc_mm` and `x_mm` belong to a blade".into(), "give `at_mm`".into()));
                };
                let asked = Point::from(*at);
                let off = design.nearest(&asked, f64::MAX);
                let distance = off.map_or(f64::INFINITY, |n| n.distance.abs());
                let foot = (distance <= BESIDE_MM).then(|| foot(design.as_ref(), &asked)).flatten();
                let Some((point, normal)) = foot else {
                    let how_far = if distance.is_finite() {
                        format!("{distance:.3} mm away from the design")
                    } else {
                        "off the design".into()
                    };
                    return Err((
                        format!("{} lies {how_far}", coordinates(&asked)),
                        format!("give a point within {BESIDE_MM} mm of the design surface"),
                    ));
                };
                finish(point, normal, usual(&normal), None, false)
            }
        }
    }
}

impl Place {
    /// The same with its columns turned by an angle (radian) about the normal.
    pub(crate) fn turned(&self, angle: f64) -> Self {
        let (s, c) = angle.sin_cos();
        let along = self.along * c + self.across * s;
        Self { along, across: self.normal.cross(&along), ..self.clone() }
    }

    /// Looks whether the patch lies on the surface, at its middle lines and rim.
    pub(crate) fn check(&self, ground: &Ground, steps: [usize; 2], step: [f64; 2]) -> Result<(), Refused> {
        match ground {
            Ground::Design(design) if !self.plane => {
                let start = Node { point: self.middle, normal: self.normal, along: self.across };
                let spine = line(design.as_ref(), start, steps[1], step[1])?;
                for j in [0, steps[1] / 2, steps[1]] {
                    row(design.as_ref(), &spine[j], steps[0], step[0])?;
                }
                Ok(())
            }
            // Corners of an airfoil patch are checked against its ends.
            _ => self.lattice(ground, [1, 1], [steps[0] as f64 * step[0], steps[1] as f64 * step[1]]).map(|_| ()),
        }
    }

    /// Nodes `step` (mm) apart round the middle, `steps` of them along the columns and the rows.
    pub(crate) fn lattice(&self, ground: &Ground, steps: [usize; 2], step: [f64; 2]) -> Result<Lattice, Refused> {
        let offset = |i: usize, k: usize| (i as f64 - 0.5 * steps[k] as f64) * step[k];
        let (columns, rows) = (steps[0] + 1, steps[1] + 1);
        let made = match (self.plane, self.on_blade, ground) {
            (true, ..) => {
                let at = |i, j| self.middle + self.along * offset(i, 0) + self.across * offset(j, 1);
                let points = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
                Lattice::new(columns, points, vec![self.normal; columns * rows])
            }
            (_, Some(middle), Ground::Blade(blade)) => self.on_airfoil(blade, middle, steps, step)?,
            (_, _, Ground::Design(design)) => self.on_design(design.as_ref(), steps, step)?,
            _ => None,
        };
        made.ok_or_else(|| ("it has no nodes".into(), "give it a size and a step".into()))
    }

    fn on_airfoil(
        &self,
        blade: &Blade,
        [arc, x]: [f64; 2],
        steps: [usize; 2],
        step: [f64; 2],
    ) -> Result<Option<Lattice>, Refused> {
        // Metric of the surface at the middle: direction = P_arc a + P_x b.
        let [u, v] = derivatives(blade, arc, x);
        let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
        let det = uu * vv - uv * uv;
        let solve = |d: &Vector| {
            let (p, q) = (d.dot(&u), d.dot(&v));
            [(p * vv - q * uv) / det, (q * uu - p * uv) / det]
        };
        let (s, t) = (solve(&self.along), solve(&self.across));
        let offset = |i: usize, k: usize| (i as f64 - 0.5 * steps[k] as f64) * step[k];
        let parameters = |i: usize, j: usize| {
            let (a, b) = (offset(i, 0), offset(j, 1));
            [arc + s[0] * a + t[0] * b, x + s[1] * a + t[1] * b]
        };
        for (i, j) in [(0, 0), (steps[0], 0), (0, steps[1]), (steps[0], steps[1])] {
            let [arc, x] = parameters(i, j);
            on_airfoil(blade, arc, x)?;
        }
        let (columns, rows) = (steps[0] + 1, steps[1] + 1);
        let nodes: Vec<Vec<(Point, Vector)>> = rows_of(rows, |j| {
            (0..columns)
                .map(|i| {
                    let [arc, x] = parameters(i, j);
                    let p = blade.at(arc, x);
                    (p.point, p.normal)
                })
                .collect()
        });
        let (points, normals) = nodes.into_iter().flatten().unzip();
        Ok(Lattice::new(columns, points, normals))
    }

    fn on_design(
        &self,
        design: &dyn DesignSurface,
        steps: [usize; 2],
        step: [f64; 2],
    ) -> Result<Option<Lattice>, Refused> {
        let start = Node { point: self.middle, normal: self.normal, along: self.across };
        // The middle lies between two nodes where the number of steps is odd.
        let spine = line(design, start, steps[1], step[1])?;
        let rows = rows_of(spine.len(), |j| row(design, &spine[j], steps[0], step[0]));
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for row in rows {
            for node in row? {
                points.push(node.point);
                normals.push(node.normal);
            }
        }
        Ok(Lattice::new(steps[0] + 1, points, normals))
    }
}

/// Rows in parallel, in their order.
fn rows_of<T: Send>(rows: usize, row: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    use rayon::prelude::*;
    (0..rows).into_par_iter().map(row).collect()
}

#[derive(Clone, Copy)]
struct Node {
    point: Point,
    normal: Vector,
    along: Vector,
}

/// A row of a patch through a node of its spine.
fn row(design: &dyn DesignSurface, node: &Node, steps: usize, step: f64) -> Result<Vec<Node>, Refused> {
    let along = laid(&node.along.cross(&node.normal), &node.normal).ok_or_else(|| leaves(&node.point))?;
    line(design, Node { along, ..*node }, steps, step)
}

/// `steps` + 1 nodes in a row whose middle is `start`.
fn line(design: &dyn DesignSurface, start: Node, steps: usize, step: f64) -> Result<Vec<Node>, Refused> {
    let half = steps / 2;
    // An odd number of steps begins half a step from the middle.
    let first = if steps.is_multiple_of(2) { start } else { next(design, &start, 0.5 * step)? };
    let go = |count: usize, step: f64| -> Result<Vec<Node>, Refused> {
        let mut nodes = Vec::with_capacity(count);
        let mut at = first;
        for _ in 0..count {
            at = next(design, &at, step)?;
            nodes.push(at);
        }
        Ok(nodes)
    };
    let (forward, backward) = (half, steps - half);
    let mut nodes: Vec<Node> = go(backward, -step)?;
    nodes.reverse();
    nodes.push(first);
    nodes.extend(go(forward, step)?);
    Ok(nodes)
}

fn next(design: &dyn DesignSurface, from: &Node, step: f64) -> Result<Node, Refused> {
    let wanted = from.point + from.along * step;
    let (point, normal) = foot(design, &wanted).ok_or_else(|| leaves(&from.point))?;
    let turned = from.normal.cross(&normal).norm().atan2(from.normal.dot(&normal));
    let made = (point - from.point).norm();
    if turned > EDGE_RAD || (made - step.abs()).abs() > 0.2 * step.abs() {
        return Err(leaves(&from.point));
    }
    let along = laid(&from.along, &normal).ok_or_else(|| leaves(&from.point))?;
    Ok(Node { point, normal, along })
}

fn leaves(p: &Point) -> Refused {
    (
        format!("it leaves the surface of the design, or runs over an edge, at {}", coordinates(p)),
        "move it, or make it smaller".into(),
    )
}

/// The nearest point of the design and its normal.
fn foot(design: &dyn DesignSurface, p: &Point) -> Option<(Point, Vector)> {
    let mut at = *p;
    let mut found = design.nearest(&at, f64::MAX)?;
    for _ in 0..FOOT_STEPS {
        if found.distance.abs() <= ON_SURFACE_MM {
            break;
        }
        at -= found.normal * found.distance;
        found = design.nearest(&at, f64::MAX)?;
    }
    Some((at, found.normal))
}

/// Derivatives of the airfoil by arc length and by height: the tangent of the turned section, and `e_x +
/// twist (e_x x P)`.
fn derivatives(blade: &Blade, arc: f64, x: f64) -> [Vector; 2] {
    let twist = blade.spec().twist;
    let section = blade.outline().at(arc);
    let (s, c) = (section.normal_angle + twist * x).sin_cos();
    let p = blade.at(arc, x).point;
    [Vector::new(0.0, -s, c), Vector::x() + Vector::x().cross(&p.coords) * twist]
}

fn on_airfoil(blade: &Blade, arc: f64, x: f64) -> Result<(), Refused> {
    let (low, high, perimeter) = (blade.airfoil_start(), blade.spec().length, blade.outline().perimeter());
    if !(low..=high).contains(&x) {
        return Err((
            format!("it reaches to height x = {x:.3} mm; the airfoil goes from {low:.3} to {high:.3} mm"),
            "move it, or make it smaller".into(),
        ));
    }
    if !(-perimeter..=2.0 * perimeter).contains(&arc) {
        return Err((
            format!("arc length {arc:.3} mm is more than a turn of the section, which has {perimeter:.3} mm"),
            format!("give 0 to {perimeter:.3} mm"),
        ));
    }
    Ok(())
}

/// Arc length and height of the point of the airfoil that is nearest: a search over the section, then Newton
/// on the tangent plane.
fn nearest_on_blade(blade: &Blade, p: &Point) -> Result<[f64; 2], Refused> {
    const STARTS: usize = 400;
    let perimeter = blade.outline().perimeter();
    let distance = |arc: f64| (blade.at(arc, p.x).point - p).norm();
    let starts = (0..STARTS).map(|k| perimeter * k as f64 / STARTS as f64);
    let mut arc = starts.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(0.0);
    let mut x = p.x;
    for _ in 0..30 {
        let [u, v] = derivatives(blade, arc, x);
        let off = p - blade.at(arc, x).point;
        let (uv, vv, pu, pv) = (u.dot(&v), v.dot(&v), off.dot(&u), off.dot(&v));
        let det = vv - uv * uv;
        arc += (pu * vv - pv * uv) / det;
        x += (pv - pu * uv) / det;
    }
    let off = (blade.at(arc, x).point - p).norm();
    if off <= BESIDE_MM {
        return Ok([arc.rem_euclid(perimeter), x]);
    }
    Err((
        format!("{} lies {off:.3} mm away from the airfoil", coordinates(p)),
        format!("give a point within {BESIDE_MM} mm of its surface, or `arc_mm` and `x_mm`"),
    ))
}

#[cfg(test)]
mod tests {
    use proveout_blade::{BladeSpec, CamberSection};
    use proveout_surface::{ConeFlank, ConeFrustum};

    use super::*;

    fn middle<'a>(at: &'a Option<[f64; 3]>, arc: Option<f64>, x: Option<f64>) -> Middle<'a> {
        Middle { at, arc, x, normal: &None }
    }

    /// Distances of neighbors along rows and columns, and the angle between them in the middle, radian.
    fn steps(lattice: &Lattice) -> (Vec<f64>, Vec<f64>, f64) {
        let (n, m, p) = (lattice.columns(), lattice.rows(), lattice.points());
        let along = |i: usize, j: usize| p[j * n + i + 1] - p[j * n + i];
        let across = |i: usize, j: usize| p[(j + 1) * n + i] - p[j * n + i];
        let rows = (0..m).flat_map(|j| (0..n - 1).map(move |i| (i, j))).map(|(i, j)| along(i, j).norm()).collect();
        let columns = (0..m - 1).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| across(i, j).norm()).collect();
        (rows, columns, along(n / 2, m / 2).angle(&across(n / 2, m / 2)))
    }

    fn within(values: &[f64], step: f64, part: f64) {
        for v in values {
            assert!((v - step).abs() < part * step, "{v} for {step}");
        }
    }

    #[test]
    fn nodes_on_a_cone_lie_on_it_at_equal_steps() {
        let frustum =
            ConeFrustum { base: Point::origin(), axis: Vector::z(), base_radius: 20.0, top_radius: 12.0, height: 30.0 };
        let design = ConeFlank { frustum, end_margin: 0.0 };
        let ground = Ground::Design(Arc::new(design));
        let place = ground.place(&middle(&Some([16.2, 0.1, 15.0]), None, None), None).expect("a place");
        for steps_of in [[40, 40], [41, 39]] {
            place.check(&ground, steps_of, [0.1, 0.1]).expect("on the flank");
            let lattice = place.lattice(&ground, steps_of, [0.1, 0.1]).expect("a lattice");
            assert_eq!((lattice.columns(), lattice.rows()), (steps_of[0] + 1, steps_of[1] + 1));
            for (p, n) in lattice.points().iter().zip(lattice.normals()) {
                let near = design.nearest(p, 1.0).expect("on the flank");
                assert!(near.distance.abs() < 1e-12 && (near.normal - n).norm() < 1e-12);
            }
            let (rows, columns, angle) = steps(&lattice);
            within(&rows, 0.1, 1e-4);
            // Rows on both sides of the spine come nearer to each other or go apart, as meridians
            // do.
            within(&columns, 0.1, 1e-2);
            assert!((angle - std::f64::consts::FRAC_PI_2).abs() < 0.01, "{angle}");
        }
        // Beyond the end of the flank.
        let low = ground.place(&middle(&Some([19.7, 0.0, 1.0]), None, None), None).expect("a place");
        assert!(low.check(&ground, [40, 40], [0.1, 0.1]).is_err());
    }

    #[test]
    fn nodes_on_a_blade_are_points_of_its_closed_form_at_equal_steps() {
        let spec = BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist: 0.002, platform: None };
        let blade = Blade::new(spec).expect("a blade");
        let ground = Ground::Blade(Box::new(blade.clone()));
        for along in [None, Some([1.0, 0.0, 0.0]), Some([1.0, 1.0, 1.0])] {
            let place = ground.place(&middle(&None, Some(30.0), Some(20.0)), along).expect("a place");
            let lattice = place.lattice(&ground, [40, 40], [0.1, 0.1]).expect("a lattice");
            let center = blade.at(30.0, 20.0);
            assert!((lattice.points()[20 * 41 + 20] - center.point).norm() < 1e-12);
            let (rows, columns, angle) = steps(&lattice);
            within(&rows, 0.1, 0.01);
            within(&columns, 0.1, 0.01);
            assert!((angle - std::f64::consts::FRAC_PI_2).abs() < 1e-3, "{angle}");
        }
        // The point of a place that is written in space is the nearest one.
        let on = blade.at(42.0, 33.0);
        let beside: [f64; 3] = (on.point + on.normal * 0.4).into();
        let place = ground.place(&middle(&Some(beside), None, None), None).expect("a place");
        assert!((place.middle - on.point).norm() < 1e-9, "{:?}", place.middle);
        assert!(ground.place(&middle(&Some([30.0, 200.0, 0.0]), None, None), None).is_err());
        let top = ground.place(&middle(&None, Some(30.0), Some(59.0)), None).expect("a place");
        assert!(top.check(&ground, [40, 40], [0.1, 0.1]).is_err_and(|(m, _)| m.contains("x = 61")), "beyond its end");
    }
}
