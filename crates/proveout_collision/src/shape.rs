//! Shapes as the distance queries see them. Types of the query library stay inside this file and
//! `distance.rs`.

use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::shape::{SupportMap, TriMesh as ParryMesh, TriMeshFlags};
use proveout_geom::{MeshError, Point, Pose, TriMesh, Vector};
use proveout_tool::{Profile, Segment};

use crate::report::MeshFaults;
use crate::triangle_tree::TriangleTree;

/// Exact convex body of revolution about z, given by its support function: for a direction with the
/// components u across and w along the axis it is the largest r u + z w over the generating curve. Corners
/// are candidates, and on an arc the point whose normal has that direction, if the arc has it. So nothing is
/// faceted and no margin is needed.
#[derive(Clone, Debug)]
pub(crate) struct Revolved {
    profile: Profile,
    corners: Vec<[f64; 2]>,
    arcs: Vec<Arc>,
    /// Center on the axis and radius of a ball end.
    ball: Option<(f64, f64)>,
}

#[derive(Clone, Copy, Debug)]
struct Arc {
    center: [f64; 2],
    radius: f64,
    from: [f64; 2],
    to: [f64; 2],
}

impl Revolved {
    pub(crate) fn new(profile: &Profile) -> Self {
        let segments = profile.segments();
        let first = segments.first().map(Segment::from);
        let corners = first.into_iter().chain(segments.iter().map(Segment::to)).collect();
        let arcs = segments.iter().filter_map(|s| match *s {
            Segment::Arc { center, radius, from, to } => Some(Arc { center, radius, from, to }),
            Segment::Line { .. } => None,
        });
        let ball = match segments.first() {
            Some(Segment::Arc { center, .. }) => profile.ball_radius().map(|radius| (center[1], radius)),
            _ => None,
        };
        Self { arcs: arcs.collect(), corners, ball, profile: profile.clone() }
    }

    /// Center and radius of a ball end, in its own frame.
    pub(crate) fn ball(&self) -> Option<(Point, f64)> {
        self.ball.map(|(z, radius)| (Point::new(0.0, 0.0, z), radius))
    }

    pub(crate) fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Axis from bottom to top and radius of a cylinder that holds the body, in its own frame.
    pub(crate) fn capsule(&self) -> (Point, Point, f64) {
        let at = |z| Point::new(0.0, 0.0, z);
        (at(self.profile.z_min()), at(self.profile.z_max()), self.profile.max_radius())
    }

    /// Part of the axis and a radius, so that all of the body is no farther from that part: of a ball end
    /// from the center of the ball on.
    pub(crate) fn spine(&self) -> (Point, Point, f64) {
        let (low, high, radius) = self.capsule();
        (self.ball().map_or(low, |(center, _)| center), high, radius)
    }

    /// Largest component of its points along a direction of any length: that of the support point, without
    /// the point.
    pub(crate) fn height(&self, along: &Vector) -> f64 {
        let (across, up) = ((along.x * along.x + along.y * along.y).sqrt(), along.z);
        let corners = self.corners.iter().map(|p| p[0] * across + p[1] * up).fold(f64::NEG_INFINITY, f64::max);
        let of_arc = |a: &Arc| {
            // The normal lies between both ends; its length does not count for that.
            let beside = |p: [f64; 2]| (p[0] - a.center[0]) * up - (p[1] - a.center[1]) * across;
            if beside(a.from) < 0.0 || beside(a.to) > 0.0 {
                return f64::NEG_INFINITY;
            }
            let length = (across * across + up * up).sqrt();
            let off_axis = a.center[0] * length + a.radius * across;
            if off_axis < 0.0 || length <= 0.0 {
                return f64::NEG_INFINITY;
            }
            a.center[0] * across + a.center[1] * up + a.radius * length
        };
        self.arcs.iter().map(of_arc).fold(corners, f64::max)
    }

    /// A point inside, on the axis.
    pub(crate) fn middle(&self) -> Point {
        Point::new(0.0, 0.0, 0.5 * (self.profile.z_min() + self.profile.z_max()))
    }

    /// The point of the skin nearest to a point outside; none for a point inside.
    pub(crate) fn nearest(&self, p: &Point) -> Option<Point> {
        let across = p.x.hypot(p.y);
        if self.profile.signed_distance([across, p.z]) < 0.0 {
            return None;
        }
        let [r, z] = self.profile.nearest([across, p.z]).point;
        let (x, y) = if across > 0.0 { (p.x / across, p.y / across) } else { (1.0, 0.0) };
        Some(Point::new(r * x, r * y, z))
    }

    /// Signed distance of a point, mm.
    pub(crate) fn signed_distance(&self, p: &Point) -> f64 {
        self.profile.signed_distance([p.x.hypot(p.y), p.z])
    }
}

impl SupportMap for Revolved {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        // A direction is far from what would underflow, and `hypot` is a fifth of a query.
        let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let value = |p: [f64; 2]| p[0] * across + p[1] * direction.z;
        let mut best = [0.0, 0.0];
        let mut height = f64::NEG_INFINITY;
        for &p in &self.corners {
            let v = value(p);
            if v > height {
                (best, height) = (p, v);
            }
        }
        let length = (across * across + direction.z * direction.z).sqrt();
        if length > 0.0 && !self.arcs.is_empty() {
            let n = [across / length, direction.z / length];
            for a in &self.arcs {
                let cross = |p: [f64; 2]| (p[0] - a.center[0]) * n[1] - (p[1] - a.center[1]) * n[0];
                // The normal lies between the two ends of the (convex, counter-clockwise) arc.
                if cross(a.from) >= 0.0 && cross(a.to) <= 0.0 {
                    let p = [a.center[0] + a.radius * n[0], a.center[1] + a.radius * n[1]];
                    if p[0] >= 0.0 && value(p) > height {
                        (best, height) = (p, value(p));
                    }
                }
            }
        }
        let (x, y) = if across > 0.0 { (direction.x / across, direction.y / across) } else { (1.0, 0.0) };
        ParryVector::new(best[0] * x, best[0] * y, best[1])
    }
}

/// Mesh with its search tree; one that is not closed has no inside.
#[derive(Clone, Debug)]
pub(crate) struct MeshShape {
    pub(crate) tree: ParryMesh,
    /// The triangles once more, in the tree of the distance queries.
    pub(crate) boxes: std::sync::Arc<TriangleTree>,
    /// One vertex of each shell, to find a shell that lies wholly inside of another body.
    pub(crate) shells: Vec<Point>,
    /// What it lacks.
    pub(crate) faults: MeshFaults,
}

/// Why a mesh cannot be checked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ShapeFault {
    Solid(MeshError),
    Tree(String),
}

impl MeshShape {
    /// A mesh that bounds a solid.
    pub(crate) fn new(mesh: &TriMesh) -> Result<Self, ShapeFault> {
        let shape = Self::surface(mesh)?;
        shape.faults.open.clone().map_or(Ok(shape), |fault| Err(ShapeFault::Solid(fault)))
    }

    /// A mesh that bounds a solid, or one with holes or turned faces, of which only the surface is known.
    pub(crate) fn surface(mesh: &TriMesh) -> Result<Self, ShapeFault> {
        // Bodies are often several closed shells that touch: joining their vertices would hide that each is
        // closed.
        let (solid, open) = match mesh.check_solid() {
            Ok(()) => (mesh.clone(), None),
            Err(MeshError::Index { triangle, vertex, vertices }) => {
                return Err(ShapeFault::Solid(MeshError::Index { triangle, vertex, vertices }));
            }
            Err(_) => {
                let merged = mesh.merge_equal_vertices();
                match merged.check_solid() {
                    Ok(()) => (merged, None),
                    Err(fault @ (MeshError::Open { .. } | MeshError::NotManifold { .. })) => (merged, Some(fault)),
                    Err(fault) => return Err(ShapeFault::Solid(fault)),
                }
            }
        };
        let flat = (0..mesh.triangles.len()).filter(|&t| mesh.area_normal(t).norm_squared() == 0.0).count();
        let vertices = solid.positions.iter().map(to_parry).collect();
        // Which side of a surface is inside is only asked of one that has an inside.
        let flags = if open.is_some() { TriMeshFlags::empty() } else { TriMeshFlags::ORIENTED };
        let tree = ParryMesh::with_flags(vertices, solid.triangles.clone(), flags)
            .map_err(|e| ShapeFault::Tree(format!("{e:?}")))?;
        // Joining vertices drops triangles that are lines or points: they count as what they are.
        let boxes = std::sync::Arc::new(TriangleTree::new(if flat > 0 { mesh } else { &solid }));
        Ok(Self { tree, boxes, shells: shells(&solid), faults: MeshFaults { open, flat } })
    }

    pub(crate) fn vertices(&self) -> impl Iterator<Item = Point> + '_ {
        self.tree.vertices().iter().map(|v| from_parry(*v))
    }

    /// True when the point is inside: its winding number, the sum of the signed solid angles of all triangles
    /// over the full sphere (van Oosterom and Strackee 1983), is above one half. Unlike the sign of the
    /// nearest face, this is right where shells of one body overlap. Nothing is known to be inside of an open
    /// mesh.
    pub(crate) fn contains(&self, p: &Point) -> bool {
        let q = to_parry(p);
        if self.faults.open.is_some() || !self.tree.local_aabb().contains_local_point(q) {
            return false;
        }
        let sum: f64 = self
            .tree
            .triangles()
            .map(|t| {
                let (a, b, c) = (from_parry(t.a - q), from_parry(t.b - q), from_parry(t.c - q));
                let (a, b, c) = (a.coords, b.coords, c.coords);
                let (x, y, z) = (a.norm(), b.norm(), c.norm());
                let numerator = a.dot(&b.cross(&c));
                let denominator = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
                numerator.atan2(denominator)
            })
            .sum();
        sum / std::f64::consts::TAU > 0.5
    }
}

/// One vertex of each connected part.
fn shells(mesh: &TriMesh) -> Vec<Point> {
    let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for t in &mesh.triangles {
        for pair in t.windows(2) {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut used: Vec<u32> = mesh.triangles.iter().map(|t| root(&mut parent, t[0])).collect();
    used.sort_unstable();
    used.dedup();
    used.into_iter().map(|i| mesh.positions[i as usize]).collect()
}

pub(crate) fn to_parry(p: &Point) -> ParryVector {
    ParryVector::new(p.x, p.y, p.z)
}

pub(crate) fn from_parry(v: ParryVector) -> Point {
    Point::new(v.x, v.y, v.z)
}

pub(crate) fn pose_to_parry(a_from_b: &Pose) -> ParryPose {
    a_from_b.to_isometry().into()
}

/// Shape of one part of the machine or the tool.
#[derive(Clone, Debug)]
pub(crate) enum PartShape {
    /// Bodies of revolution about the z axis of one frame.
    Convex(Vec<Revolved>),
    /// Mesh.
    Mesh(Box<MeshShape>),
}

impl PartShape {
    /// Ball round the shape: center and radius.
    pub(crate) fn ball(&self) -> (Point, f64) {
        match self {
            Self::Convex(bodies) => {
                let low = bodies.iter().map(|b| b.profile.z_min()).fold(f64::INFINITY, f64::min);
                let high = bodies.iter().map(|b| b.profile.z_max()).fold(f64::NEG_INFINITY, f64::max);
                let radius = bodies.iter().map(|b| b.profile.max_radius()).fold(0.0, f64::max);
                let center = Point::new(0.0, 0.0, 0.5 * (low + high));
                (center, radius.hypot(0.5 * (high - low)))
            }
            Self::Mesh(m) => {
                let b = m.tree.local_aabb();
                let center = nalgebra::center(&from_parry(b.mins), &from_parry(b.maxs));
                (center, m.vertices().map(|v| (v - center).norm()).fold(0.0, f64::max))
            }
        }
    }

    /// Farthest distance of any point from a line, in the frame of the shape.
    pub(crate) fn farthest_from_line(&self, point: &Point, direction: &Vector) -> f64 {
        let off = |p: &Point| (p - point).cross(direction).norm();
        match self {
            Self::Convex(bodies) => bodies
                .iter()
                .flat_map(|b| b.profile.segments().iter().flat_map(|s| [s.from(), s.to()]).map(move |q| (b, q)))
                .map(|(b, q)| off(&Point::new(0.0, 0.0, q[1])) + b.profile.max_radius())
                .fold(0.0, f64::max),
            Self::Mesh(m) => m.vertices().map(|v| off(&v)).fold(0.0, f64::max),
        }
    }
}
