//! A loose part among bodies at rest and a moving tool, in Rapier. No other file knows Rapier.
//!
//! All is in the table frame K. Lengths are in m inside, with `length_unit` set to the size of such parts:
//! the tolerances of the library are made for bodies of a meter.
//!
//! Things to know about the library (0.36.1), each checked by a test: integration is of first
//! order, so that a step is 0.5 ms in four substeps (a fall of 0.3 s is then 0.2 mm off in its
//! place and exact in its speed). Contacts are kept for a while instead of being found again, so
//! that `contact_recycling` is off. Contacts of one plane are merged before they are solved, so
//! that impulses are read only with `contact_clustering` off. Speeds are cut off at 400
//! `length_unit` a second, so that the limit is taken away. The axes that it finds of an inertia
//! tensor may be off where two of its values are nearly equal, so that they are found here. What
//! slides feels a friction that is up to 10 percent off. It runs on one thread: the feature
//! `parallel` stays off, and the same calls give the same bits.

use nalgebra::Matrix3;
use proveout_geom::{Point, Pose, Vector};
use rapier3d_f64::{
    dynamics::{FrictionModel, MassProperties, RigidBodyBuilder},
    geometry::{ColliderBuilder, ColliderHandle, TriMeshFlags},
    math::{Matrix, Pose as RapierPose, Rotation, Vector as RapierVector},
    parry::transformation::try_convex_hull,
    prelude::{PhysicsWorld, RigidBodyHandle, SharedShape},
};

use super::world::{Body, Contact, Hull, STEP, Standing, Touch};

const METER: f64 = 1e-3;
/// Parts of a step.
const SUBSTEPS: usize = 4;
/// Size of the parts, m: scales the tolerances of the library.
const LENGTH_UNIT: f64 = 0.01;

/// Whether falls can be followed.
pub(super) const IS_BUILT: bool = true;

/// The hull of points, mm; none of fewer than four points, or of points in one plane.
pub(super) fn hull(points: &[Point]) -> Option<Hull> {
    if points.len() < 4 || !points.iter().all(|p| p.coords.iter().all(|x| x.is_finite())) {
        return None;
    }
    let all: Vec<RapierVector> = points.iter().map(|p| RapierVector::new(p.x, p.y, p.z)).collect();
    let (vertices, triangles) = try_convex_hull(&all).ok()?;
    Some(Hull { points: vertices.iter().map(|v| Point::new(v.x, v.y, v.z)).collect(), triangles })
}

fn to_meter(v: &Vector) -> RapierVector {
    RapierVector::new(v.x * METER, v.y * METER, v.z * METER)
}

fn rotation(m: &Matrix3<f64>) -> Rotation {
    let columns: [f64; 9] = std::array::from_fn(|k| m[(k % 3, k / 3)]);
    Rotation::from_mat3(&Matrix::from_cols_array(&columns)).normalize()
}

fn placed(pose: &Pose) -> RapierPose {
    RapierPose::from_parts(to_meter(&pose.translation), rotation(&pose.rotation))
}

fn of_meter(v: RapierVector) -> Vector {
    Vector::new(v.x, v.y, v.z) / METER
}

/// Mass properties about the center, which is the origin of the body.
fn mass_properties(body: &Body) -> MassProperties {
    let eigen = (body.inertia * (METER * METER)).symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let value = |k: usize| eigen.eigenvalues[k].max(f64::MIN_POSITIVE);
    let principal = RapierVector::new(value(0), value(1), value(2));
    MassProperties::with_principal_inertia_frame(RapierVector::ZERO, body.mass, principal, rotation(&axes))
}

/// The part on its way.
pub(super) struct World {
    world: PhysicsWorld,
    part: RigidBodyHandle,
    center: Point,
    standing: Vec<ColliderHandle>,
    tool: Option<RigidBodyHandle>,
}

impl World {
    /// The part at rest where it was found. `tool` are the convex bodies of the tool in its tip frame T; none
    /// where nothing is in the spindle. None where a piece has no volume or a mesh no triangles.
    pub(super) fn new(
        body: &Body,
        standing: &[Standing],
        tool: Option<(&[Vec<Point>], &Pose)>,
        touch: Touch,
    ) -> Option<Self> {
        let mut world = PhysicsWorld::new();
        let p = &mut world.integration_parameters;
        (p.dt, p.num_solver_iterations, p.length_unit) = (STEP, SUBSTEPS, LENGTH_UNIT);
        (p.contact_recycling, p.contact_clustering) = (false, false);
        p.normalized_max_linear_velocity = f64::MAX;
        p.friction_model = FrictionModel::Coulomb;
        let surface = |shape: SharedShape| {
            ColliderBuilder::new(shape).density(0.0).friction(touch.friction).restitution(touch.restitution)
        };
        let builder = RigidBodyBuilder::dynamic()
            .translation(to_meter(&body.center.coords))
            .additional_mass_properties(mass_properties(body))
            .can_sleep(false)
            .ccd_enabled(true)
            .linear_damping(0.0)
            .angular_damping(0.0);
        let part = world.insert_body(builder);
        for piece in &body.pieces {
            let points: Vec<RapierVector> = piece.iter().map(|p| to_meter(&(p - body.center))).collect();
            world.insert_collider(surface(SharedShape::convex_hull(&points)?), Some(part));
        }
        let mut handles = Vec::with_capacity(standing.len());
        for s in standing {
            let points: Vec<RapierVector> = s.mesh.positions.iter().map(|p| to_meter(&p.coords)).collect();
            // Edges within a face do not catch what slides over them; a mesh that is not closed is taken as
            // it is.
            let smooth = SharedShape::trimesh_with_flags(
                points.clone(),
                s.mesh.triangles.clone(),
                TriMeshFlags::FIX_INTERNAL_EDGES,
            );
            let shape = smooth.or_else(|_| SharedShape::trimesh(points, s.mesh.triangles.clone())).ok()?;
            handles.push(world.insert_collider(surface(shape), None));
        }
        let tool = match tool {
            None => None,
            Some((pieces, pose)) => {
                let body = world.insert_body(RigidBodyBuilder::kinematic_position_based().pose(placed(pose)));
                for piece in pieces {
                    let points: Vec<RapierVector> = piece.iter().map(|p| to_meter(&p.coords)).collect();
                    world.insert_collider(surface(SharedShape::convex_hull(&points)?), Some(body));
                }
                Some(body)
            }
        };
        Some(Self { world, part, center: body.center, standing: handles, tool })
    }

    /// One step of [`STEP`] under an acceleration (mm/s²), the tool on its way to a pose. Gives the contacts.
    pub(super) fn step(&mut self, acceleration: &Vector, tool: Option<&Pose>) -> Vec<Contact> {
        self.world.gravity = to_meter(acceleration);
        if let (Some(handle), Some(pose)) = (self.tool, tool)
            && let Some(body) = self.world.bodies.get_mut(handle)
        {
            body.set_next_kinematic_position(placed(pose));
        }
        let before = self.world.bodies.get(self.part).map(|b| (b.linvel(), b.angvel(), b.translation()));
        let tool_at = self.tool.and_then(|t| self.world.bodies.get(t)).map(|b| *b.position());
        self.world.step();
        let Some((linear, angular, center)) = before else { return Vec::new() };
        let tool_now = self.tool.and_then(|t| self.world.bodies.get(t)).map(|b| *b.position());
        // Speed of a point of the tool within the step.
        let tool_speed = |p: RapierVector| match (&tool_at, &tool_now) {
            (Some(from), Some(to)) => (to.transform_point(from.inverse_transform_point(p)) - p) / STEP,
            _ => RapierVector::ZERO,
        };
        let mut out = Vec::new();
        for pair in self.world.contact_pairs() {
            let owner = |c: ColliderHandle| self.world.colliders.get(c).and_then(|c| c.parent());
            let first = owner(pair.collider1) == Some(self.part);
            let other = if first { pair.collider2 } else { pair.collider1 };
            let with = self.standing.iter().position(|h| *h == other);
            let Some(placed) = self.world.colliders.get(pair.collider1).map(|c| *c.position()) else { continue };
            for manifold in pair.manifolds() {
                // The normal of the library runs from the first body to the second; here out of the obstacle.
                let normal = if first { -manifold.data.normal } else { manifold.data.normal };
                let placed = manifold.subshape_pos1().map_or(placed, |local| placed * *local);
                for contact in &manifold.points {
                    let p = placed.transform_point(contact.local_p1);
                    let speed = linear + angular.cross(p - center);
                    let speed = if with.is_none() { speed - tool_speed(p) } else { speed };
                    let bears = contact.data.impulse > 0.0;
                    out.push(Contact {
                        with,
                        point: Point::from(of_meter(p)),
                        approach: if bears { (-speed.dot(normal) / METER).max(0.0) } else { 0.0 },
                        depth: -contact.dist / METER,
                        bears,
                    });
                }
            }
        }
        out
    }

    /// The motion of the part since it was found: applied to its places in K then, it gives those now.
    pub(super) fn moved(&self) -> Pose {
        let Some(body) = self.world.bodies.get(self.part) else { return Pose::identity() };
        let pose = body.position();
        let columns = [RapierVector::X, RapierVector::Y, RapierVector::Z].map(|e| pose.rotation * e);
        let rotation = Matrix3::from_fn(|r, c| [columns[c].x, columns[c].y, columns[c].z][r]);
        Pose { rotation, translation: of_meter(pose.translation) - rotation * self.center.coords }
    }

    /// Velocity of the center, mm/s.
    #[cfg(test)]
    fn velocity(&self) -> Vector {
        self.world.bodies.get(self.part).map_or_else(Vector::zeros, |b| of_meter(b.linvel()))
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, box_mesh};

    use super::*;

    const G: f64 = 9806.65;

    /// A block of steel of 20 x 20 x 10 mm, its lower face at `z`.
    fn block(z: f64) -> Body {
        let size = Vector::new(20.0, 20.0, 10.0);
        let mass = size.product() * 7850e-9;
        let turn = |a: f64, b: f64| mass * (a * a + b * b) / 12.0;
        let inertia = [turn(size.y, size.z), turn(size.x, size.z), turn(size.x, size.y)];
        let bounds = Aabb { min: Point::new(-10.0, -10.0, z), max: Point::new(10.0, 10.0, z + 10.0) };
        Body {
            pieces: vec![box_mesh(&bounds).positions],
            mass,
            center: bounds.center(),
            inertia: Matrix3::from_diagonal(&Vector::from(inertia)),
        }
    }

    fn plate() -> Vec<Standing> {
        let bounds = Aabb { min: Point::new(-300.0, -300.0, -20.0), max: Point::new(300.0, 300.0, 0.0) };
        vec![Standing { name: "plate".into(), mesh: box_mesh(&bounds), on_table: true }]
    }

    #[test]
    fn a_block_falls_and_hits_as_galilei_has_it() {
        let touch = Touch { friction: 0.3, restitution: 0.0 };
        for height in [20.0, 94.0, 300.0] {
            let mut world = World::new(&block(height), &plate(), None, touch).unwrap();
            let (time, speed) = ((2.0 * height / G).sqrt(), (2.0 * G * height).sqrt());
            let mut hit = None;
            for k in 0..2000 {
                let contacts = world.step(&Vector::new(0.0, 0.0, -G), None);
                if let Some(c) = contacts.iter().find(|c| c.bears) {
                    hit = hit.or(Some((f64::from(k + 1) * STEP, c.approach, c.with)));
                }
            }
            let (at, approach, with) = hit.unwrap();
            assert_eq!(with, Some(0));
            // Two steps of time; the speed is that before the step of the hit.
            assert!((at - time).abs() < 2.0 * STEP, "{height}: {at} {time}");
            assert!((approach - speed).abs() < 2.0 * STEP * G, "{height}: {approach} {speed}");
            // It lies on the plate then, to a tenth of a millimeter.
            let off = world.moved().point(&block(height).center) - block(0.0).center;
            assert!(off.norm() < 0.1 && world.velocity().norm() < 0.5, "{height}: {off:?}");
        }
    }

    #[test]
    fn free_flight_is_off_by_less_than_is_said() {
        let mut world = World::new(&block(0.0), &[], None, Touch { friction: 0.1, restitution: 0.3 }).unwrap();
        let steps = 600;
        for _ in 0..steps {
            world.step(&Vector::new(100.0, 0.0, -G), None);
        }
        let t = f64::from(steps) * STEP;
        let moved = world.moved().translation;
        assert!((moved.z + 0.5 * G * t * t).abs() < 0.2 && (moved.x - 50.0 * t * t).abs() < 0.01, "{moved:?}");
        assert!((world.velocity().z + G * t).abs() < 1e-6 * G);
    }

    #[test]
    fn a_block_slides_on_an_incline_beyond_the_angle_of_friction() {
        for friction in [0.1, 0.3, 0.5] {
            let limit = f64::atan(friction);
            for (angle, slides) in [(0.9 * limit, false), (1.1 * limit, true)] {
                let mut world = World::new(&block(0.0), &plate(), None, Touch { friction, restitution: 0.0 }).unwrap();
                let pull = Vector::new(angle.sin(), 0.0, -angle.cos()) * G;
                let steps = 1000;
                for _ in 0..steps {
                    world.step(&pull, None);
                }
                let t = f64::from(steps) * STEP;
                let way = world.moved().translation.x;
                // The friction that follows from the distance slid.
                let felt = angle.tan() - 2.0 * way / (t * t * G * angle.cos());
                if slides {
                    assert!((felt / friction - 1.0).abs() < 0.1, "{friction} {angle}: {way} {felt}");
                } else {
                    assert!(way.abs() < 0.1, "{friction} {angle}: {way}");
                }
            }
        }
    }

    #[test]
    fn a_tool_that_moves_hits_a_part_that_lies() {
        let pin = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| [0.0, 40.0].map(|z| Point::new(x, y, z))));
        let pin: Vec<Point> = pin.as_flattened().as_flattened().to_vec();
        let at = |x: f64| Pose::from_translation(Vector::new(x, 0.0, 2.0));
        let tool = [pin];
        let touch = Touch { friction: 0.1, restitution: 0.0 };
        let mut world = World::new(&block(0.0), &plate(), Some((&tool, &at(-30.0))), touch).unwrap();
        // 100 mm/s towards the face at -10 mm, from 19 mm away.
        let mut hit = None;
        for k in 1..1000 {
            let x = -30.0 + 100.0 * STEP * f64::from(k);
            let contacts = world.step(&Vector::new(0.0, 0.0, -G), Some(&at(x)));
            if let Some(c) = contacts.iter().find(|c| c.with.is_none() && c.bears) {
                hit = hit.or(Some((f64::from(k) * STEP, c.approach)));
            }
        }
        let (time, speed) = hit.unwrap();
        assert!((time - 0.19).abs() < 0.003 && (speed - 100.0).abs() < 5.0, "{time} {speed}");
        assert!(world.moved().translation.x > 5.0, "it is pushed");
    }

    #[test]
    fn a_long_body_keeps_the_inertia_that_it_is_given() {
        // A rod along (1, 1, 0): two principal values are equal.
        let axis = Vector::new(1.0, 1.0, 0.0).normalize();
        let (thin, long) = (2.0, 50.0);
        let inertia = Matrix3::identity() * long + axis * axis.transpose() * (thin - long);
        let body = Body { inertia, ..block(0.0) };
        let properties = mass_properties(&body);
        let back = properties.reconstruct_inertia_matrix();
        for r in 0..3 {
            for c in 0..3 {
                let got = back.col(c)[r] / (METER * METER);
                assert!((got - inertia[(r, c)]).abs() < 1e-6, "{r} {c}: {got}");
            }
        }
    }
}
