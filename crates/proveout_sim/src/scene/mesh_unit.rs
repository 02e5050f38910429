//! Unit and place of the meshes of a scene.
//!
//! STL and OBJ state no unit. A clamp that was exported in inches is 25.4 times too small, one in meters a
//! thousand times: it floats inside the stock, hits nothing, and every gate passes. So each mesh is compared
//! with the stock, and refused where it cannot be what its role says, until the scene states its unit:
//!
//! ```text
//!    role       refused without mesh_unit
//!    fixture    inside the box of the stock; smaller than any clamp for it; small and away from the
//!               stock, and next to it in another unit; far larger; far away
//!    design     far larger or far smaller than the stock; far away from it (refused with a unit as well:
//!               it cannot be cut from it)
//!    machine    its model far smaller than its travel, or larger than 100 m
//!    stock      below 1 mm; far smaller than the cuts in feed, and as large as they are in another unit
//! ```
//!
//! A stated unit also converts the mesh. A STEP file states its own.

use proveout_geom::{Aabb, Point, Pose, TriMesh};
use proveout_input::InputError;
use proveout_machine::Machine;
use proveout_step::is_step;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;
use std::path::{Path, PathBuf};

use crate::scene::Scene;

/// Keeps ratios to a body without an extent numbers, mm.
const LEAST_DIVISOR_MM: f64 = 1e-9;

/// Unit of the numbers of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MeshUnitFile {
    /// Millimeters; states that the size is meant.
    Mm,
    /// Centimeters.
    Cm,
    /// Meters.
    M,
    /// Inches.
    Inch,
}

impl MeshUnitFile {
    /// Millimeters of one unit.
    pub fn millimeters(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::Cm => 10.0,
            Self::M => 1000.0,
            Self::Inch => 25.4,
        }
    }

    /// The mesh in millimeters.
    pub(crate) fn convert(self, mesh: &mut TriMesh) {
        let factor = self.millimeters();
        if factor != 1.0 {
            mesh.positions.iter_mut().for_each(|p| *p = Point::from(p.coords * factor));
        }
    }
}

/// No fixture and no workpiece is smaller than this in all directions, mm.
const LEAST_MM: f64 = 1.0;
/// A fixture is no smaller than this, mm, and this part of the stock: a clamp of 150 mm in inches is. Pins
/// that are can be stated.
const LEAST_FIXTURE_MM: f64 = 6.0;
const LEAST_FIXTURE: f64 = 1.0 / 4.0;
/// A fixture smaller than this part of the stock, and away from it, may be in another unit.
const SMALL: f64 = 1.0 / 8.0;
/// A mesh larger than the stock by this factor, or by its inverse, is compared with what other units would
/// make of it.
const PLAUSIBLE: f64 = 20.0;
/// Gap beyond which a fixture does not touch the stock, mm.
const APART_MM: f64 = 1.0;
/// A fixture is far larger than the stock above this factor and this length, mm.
const LARGE: f64 = 20.0;
const LARGE_MM: f64 = 2000.0;
/// A fixture is far from the stock beyond this many times its size and this length, mm.
const FAR: f64 = 10.0;
const FAR_MM: f64 = 1000.0;
/// A design is far larger than its stock above this factor, and far smaller below the inverse of the second.
const DESIGN_LARGE: f64 = 8.0;
const DESIGN_SMALL: f64 = 20.0;
/// A design lies far away from its stock where the gap is this many times the larger of the two.
const DESIGN_BESIDE: f64 = 1.0;
/// A stock is far smaller than its cuts below this part of them.
const STOCK_SMALL: f64 = 1.0 / 8.0;

/// A machine is no smaller than this part of its longest travel, and no larger than this, mm.
const MACHINE_SMALL: f64 = 1.0 / 8.0;
const MACHINE_LARGE_MM: f64 = 1e5;

/// Units that a mesh may be in by mistake, with what its numbers are then.
static UNITS: [(f64, &str, &str); 3] = [(25.4, "inch", "inches"), (1000.0, "m", "meters"), (10.0, "cm", "centimeters")];

fn largest(b: &Aabb) -> f64 {
    b.size().max()
}

/// Distance of two boxes, mm.
fn gap(a: &Aabb, b: &Aabb) -> f64 {
    (a.min - b.max).sup(&(b.min - a.max)).map(|x| x.max(0.0)).norm()
}

fn scaled(b: &Aabb, factor: f64) -> Aabb {
    Aabb { min: b.min * factor, max: b.max * factor }
}

fn is_within(a: &Aabb, b: &Aabb) -> bool {
    (0..3).all(|i| b.min[i] <= a.min[i] && a.max[i] <= b.max[i])
}

fn measures(b: &Aabb) -> String {
    let size = b.size();
    let figure = |x: f64| if x < 0.1 { format!("{x:.6}") } else { format!("{x:.3}") };
    format!("{} x {} x {} mm", figure(size.x), figure(size.y), figure(size.z))
}

/// The unit in which a mesh would have about the size of another body, and meet it without lying inside of
/// it.
fn other_unit(
    own: &Aabb,
    place: &Aabb,
    fits: impl Fn(&Aabb) -> bool,
) -> Option<&'static (f64, &'static str, &'static str)> {
    let ratio = |factor: f64| largest(&scaled(own, factor)) / largest(place).max(LEAST_DIVISOR_MM);
    let plausible = |factor: f64| (1.0 / PLAUSIBLE..=PLAUSIBLE).contains(&ratio(factor));
    let all = UNITS.iter().filter(|(factor, ..)| plausible(*factor) && fits(&scaled(own, *factor)));
    all.min_by(|a, b| ratio(a.0).ln().abs().total_cmp(&ratio(b.0).ln().abs()))
}

/// Why a fixture cannot be what its numbers say in millimeters, and the unit that would explain it; boxes in
/// one frame.
fn doubt_of_fixture(own: &Aabb, stock: &Aabb) -> Option<(String, Option<&'static str>)> {
    let (size, other, apart) = (largest(own), largest(stock), gap(own, stock));
    let beside = |b: &Aabb| gap(b, stock) <= APART_MM.max(0.05 * other) && !is_within(b, stock);
    let unit = other_unit(own, stock, beside);
    let what = if is_within(own, stock) {
        format!("lies wholly inside of the stock ({}), where it cannot hold anything", measures(stock))
    } else if size < LEAST_MM || size < LEAST_FIXTURE_MM && size < LEAST_FIXTURE * other {
        format!("is too small for a clamp or jaw of the stock ({})", measures(stock))
    } else if size < SMALL * other && apart > APART_MM && unit.is_some() {
        format!("is small compared with the stock ({}) and {apart:.3} mm away from it", measures(stock))
    } else if size > LARGE * other && size > LARGE_MM {
        format!("is {:.0} times as large as the stock ({})", size / other, measures(stock))
    } else if apart > FAR * other && apart > FAR_MM {
        format!("is {apart:.0} mm away from the stock")
    } else {
        return None;
    };
    Some((what, unit.map(|u| u.2)))
}

/// Why a design cannot be cut from its stock; whether a stated unit answers it.
fn doubt_of_design(own: &Aabb, stock: &Aabb) -> Option<(String, bool, Option<&'static str>)> {
    let (size, other, apart) = (largest(own), largest(stock), gap(own, stock));
    let unit = other_unit(own, stock, |b| gap(b, stock) <= APART_MM).map(|u| u.2);
    let against = measures(stock);
    if apart > DESIGN_BESIDE * size.max(other) {
        let way = own.center() - stock.center();
        let what = format!(
            "lies {apart:.1} mm away from the stock ({against}): its center is {:.1}, {:.1}, {:.1} mm from that of the stock",
            way.x, way.y, way.z
        );
        return Some((what, unit.is_some(), unit));
    }
    if size > DESIGN_LARGE * other {
        let what = format!("is {:.1} times as large as the stock ({against}) that it is cut from", size / other);
        return Some((what, true, None));
    }
    (size * DESIGN_SMALL < other || size < LEAST_MM).then(|| {
        (
            format!(
                "is {:.1} times smaller than the stock ({against}) that it is cut from",
                other / size.max(LEAST_DIVISOR_MM)
            ),
            true,
            unit,
        )
    })
}

/// Why a stock cannot be what the cuts in feed are made in, and the unit that would explain it.
fn doubt_of_stock(own: &Aabb, cuts: &Aabb) -> Option<(String, Option<&'static str>)> {
    let size = largest(own);
    if size < LEAST_MM {
        let unit = other_unit(own, cuts, |b| gap(b, cuts) <= APART_MM).or(UNITS.get(1));
        return Some((format!("is smaller than {LEAST_MM} mm, too small for a workpiece"), unit.map(|u| u.2)));
    }
    if cuts.is_empty() || size >= STOCK_SMALL * largest(cuts) {
        return None;
    }
    let unit = other_unit(own, cuts, |b| gap(b, cuts) <= APART_MM)?;
    Some((
        format!("is {:.1} times smaller than the box of the cuts in feed ({})", largest(cuts) / size, measures(cuts)),
        Some(unit.2),
    ))
}

/// The refusal: `who` is the mesh with its role.
fn refused(
    scene: &Scene,
    named: &Spanned<PathBuf>,
    who: &str,
    own: &Aabb,
    what: &str,
    unit: Option<&str>,
) -> InputError {
    let looks = unit.map_or_else(String::new, |unit| format!("; its numbers look like {unit}"));
    let message = format!("{who}: the mesh of {} {what}{looks}", measures(own));
    // Half a millimeter is no workpiece and no clamp in inches either.
    let otherwise = if own.size().max() < 0.5 { "m" } else { "inch" };
    let word = unit.and_then(|unit| UNITS.iter().find(|u| u.2 == unit)).map_or(otherwise, |u| u.1);
    let help = format!(
        "a mesh file states no unit: write mesh_unit = \"{word}\" next to `mesh` (mm, cm, m or inch), or mesh_unit = \
         \"mm\" if size and place are intended"
    );
    scene.fault(named.span().start, message, help)
}

/// Refuses fixtures that cannot be fixtures of this stock.
///
/// # Errors
/// The first one, with the line of its mesh.
pub(crate) fn check_fixtures(
    scene: &Scene,
    fixtures: &[(String, TriMesh)],
    stock: &Aabb,
    table_from_work: &Pose,
) -> Result<(), InputError> {
    let stock = of_pose(stock, table_from_work);
    for (file, (name, mesh)) in scene.file.fixture.iter().zip(fixtures) {
        let (Some(named), None) = (&file.mesh, file.mesh_unit) else { continue };
        if is_step(named.get_ref()) {
            continue;
        }
        let own = mesh.aabb();
        if let Some((what, unit)) = doubt_of_fixture(&own, &stock) {
            return Err(refused(scene, named, &format!("fixture {name:?}"), &own, &what, unit));
        }
    }
    Ok(())
}

/// Refuses a design that cannot be cut from the stock.
///
/// # Errors
/// What is wrong with it, with the line of its mesh.
pub(crate) fn check_design(scene: &Scene, mesh: Option<&TriMesh>, stock: &Aabb) -> Result<(), InputError> {
    let (Some(mesh), Some(part)) = (mesh, &scene.file.part) else { return Ok(()) };
    let Some(named) = &part.mesh else { return Ok(()) };
    let own = mesh.aabb();
    let Some((what, by_unit, unit)) = doubt_of_design(&own, stock) else { return Ok(()) };
    if by_unit {
        if part.mesh_unit.is_some() || part.judged_box.is_some() || is_step(named.get_ref()) {
            return Ok(());
        }
        return Err(refused(scene, named, "part", &own, &what, unit));
    }
    let message = format!("part: the mesh of {} {what}", measures(&own));
    Err(scene.fault(named.span().start, message, "export it in the coordinates of the workpiece"))
}

/// Refuses a stock mesh that is far smaller than what is cut in it.
///
/// # Errors
/// What is wrong with it, with the line of its mesh.
pub(crate) fn check_stock(scene: &Scene, stock: &Aabb, cuts: &Aabb) -> Result<(), InputError> {
    let file = scene.file.stock.get_ref();
    let (Some(named), None) = (&file.mesh, file.mesh_unit) else { return Ok(()) };
    match doubt_of_stock(stock, cuts) {
        None => Ok(()),
        Some((what, unit)) => Err(refused(scene, named, "stock", stock, &what, unit)),
    }
}

/// Refuses a machine whose model is far smaller or larger than its travel: glTF counts in meters, and a model
/// in other units is none.
///
/// # Errors
/// Both sizes, with the file of the machine.
pub(crate) fn check_machine(machine: &Machine, file: &Path) -> Result<(), InputError> {
    let travels = machine.joints.iter().filter(|j| !j.is_rotary()).filter_map(|j| j.travel);
    let travel = travels.map(|[low, high]| high - low).filter(|t| t.is_finite()).fold(0.0, f64::max);
    let points = || machine.bodies.iter().flat_map(|b| &b.mesh.positions);
    let own = Aabb::of_points(points());
    if own.is_empty() || travel <= 0.0 {
        return Ok(());
    }
    let size = largest(&own);
    let what = if size < MACHINE_SMALL * travel {
        "far smaller than its travel"
    } else if size > MACHINE_LARGE_MM {
        "larger than any machine, with a travel"
    } else {
        return Ok(());
    };
    let message = format!("the bodies of the machine measure {}, {what} of {travel:.0} mm", measures(&own));
    Err(InputError::file(
        file,
        message,
        "glTF files count in meters: export the model so, or correct the bodies in the machine file",
    ))
}

/// Whether the stock of a scene is a mesh without a stated unit.
pub(crate) fn is_stock_in_doubt(scene: &Scene) -> bool {
    let file = scene.file.stock.get_ref();
    file.mesh.as_ref().is_some_and(|named| !is_step(named.get_ref())) && file.mesh_unit.is_none()
}

/// Box round a box in another frame.
fn of_pose(b: &Aabb, pose: &Pose) -> Aabb {
    let corner = |k: usize| {
        let of = |i: usize| if k >> i & 1 == 0 { b.min[i] } else { b.max[i] };
        pose.point(&Point::new(of(0), of(1), of(2)))
    };
    let corners: Vec<Point> = (0..8).map(corner).collect();
    Aabb::of_points(&corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
        Aabb { min: min.into(), max: max.into() }
    }

    struct Random(u64);

    impl Random {
        fn next(&mut self, low: f64, high: f64) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// A stock with its zero on top, and a clamp or jaw that touches it from a side or from above.
    fn job(random: &mut Random) -> (Aabb, Aabb) {
        let half = [random.next(15.0, 200.0), random.next(15.0, 150.0)];
        let height = random.next(10.0, 80.0);
        let stock = aabb([-half[0], -half[1], -height], [half[0], half[1], 0.0]);
        let edge = [random.next(12.0, 150.0), random.next(12.0, 150.0), random.next(10.0, 60.0)];
        let mut min = [random.next(-half[0], half[0] - 5.0), random.next(-half[1], half[1] - 5.0), -height];
        match random.next(0.0, 3.0) as usize {
            0 => min[0] = half[0],
            1 => min[1] = -half[1] - edge[1],
            _ => min[2] = 0.0,
        }
        (stock, aabb(min, [min[0] + edge[0], min[1] + edge[1], min[2] + edge[2]]))
    }

    /// Clamps and jaws that touch the stock are taken; those written in inches, centimeters or meters are
    /// refused.
    #[test]
    fn fixtures_in_another_unit_are_refused_and_true_ones_are_not() {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let mut missed = Vec::new();
        for k in 0..2000 {
            let (stock, clamp) = job(&mut random);
            assert_eq!(doubt_of_fixture(&clamp, &stock), None, "{k}: {clamp:?} on {stock:?}");
            for (factor, unit) in [(1.0 / 25.4, "inch"), (1e-3, "m")] {
                let wrong = scaled(&clamp, factor);
                // One that reaches into the stock and out of it is reported by the setup as given.
                let deep = (0..3).all(|i| wrong.max[i].min(stock.max[i]) - wrong.min[i].max(stock.min[i]) > 1e-3);
                let expected = deep && !is_within(&wrong, &stock);
                if doubt_of_fixture(&wrong, &stock).is_none() && !expected {
                    missed.push((k, unit, wrong, stock));
                }
            }
            let wrong = scaled(&clamp, 1000.0);
            assert!(doubt_of_fixture(&wrong, &stock).is_some(), "{k}: {wrong:?} on {stock:?}");
        }
        assert!(missed.is_empty(), "{} of 4000, the first {:?}", missed.len(), missed[0]);
    }

    #[test]
    fn the_unit_is_named() {
        let stock = aabb([-30.0, -30.0, -80.0], [30.0, 30.0, 0.0]);
        let clamp = aabb([-7.0, 5.0, -20.0], [7.0, 25.0, 10.0]);
        let unit = |factor: f64| doubt_of_fixture(&scaled(&clamp, factor), &stock).and_then(|d| d.1);
        assert_eq!((unit(1.0 / 25.4), unit(1e-3)), (Some("inches"), Some("meters")));
    }

    /// Designs a little off, larger or smaller than the stock are judged; far ones are refused.
    #[test]
    fn designs_far_from_their_stock_are_refused() {
        let mut random = Random(77);
        for k in 0..2000 {
            let (stock, _) = job(&mut random);
            let part = |random: &mut Random| {
                let of = |random: &mut Random, i: usize| {
                    let (low, high) = (stock.min[i], stock.max[i]);
                    [low + random.next(0.0, 0.3) * (high - low), high - random.next(0.0, 0.3) * (high - low)]
                };
                let [x, y, z] = [0, 1, 2].map(|i| of(random, i));
                aabb([x[0], y[0], z[0]], [x[1], y[1], z[1]])
            };
            let design = part(&mut random);
            assert_eq!(doubt_of_design(&design, &stock), None, "{k}");
            for factor in [1e-3, 1.0 / 25.4, 50.0, 1000.0] {
                assert!(doubt_of_design(&scaled(&design, factor), &stock).is_some(), "{k}: {factor}");
            }
            let far = random.next(3.0, 1e4) * largest(&stock);
            let beside = Aabb {
                min: design.min + proveout_geom::Vector::x() * far,
                max: design.max + proveout_geom::Vector::x() * far,
            };
            assert!(doubt_of_design(&beside, &stock).is_some_and(|d| !d.1 || d.2.is_some()), "{k}: {far}");
        }
    }

    #[test]
    fn a_stock_in_inches_or_meters_is_refused_by_its_cuts() {
        let mut random = Random(5);
        for k in 0..1000 {
            let (stock, _) = job(&mut random);
            let reach = random.next(2.0, 12.0);
            let mut cuts = Aabb { min: stock.min.map(|x| x - reach), max: stock.max.map(|x| x + reach) };
            cuts.min.z = stock.min.z * random.next(0.1, 1.0);
            assert_eq!(doubt_of_stock(&stock, &cuts), None, "{k}");
            for factor in [1.0 / 25.4, 1e-3] {
                assert!(doubt_of_stock(&scaled(&stock, factor), &cuts).is_some(), "{k}: {factor}");
            }
        }
    }
}
