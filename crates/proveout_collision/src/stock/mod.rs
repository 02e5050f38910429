//! Bodies of machine and setup against the in-process stock.
//!
//! The parts of the tool are swept through the stock, exactly. Machine bodies and fixtures are meshes of any
//! form: they are followed by distance with a motion bound, as two bodies are (see the crate's text), with
//! the material on the rays of the stock as the other body.
//!
//! # What follows from the rays
//!
//! Let M be the material, S the intervals on the rays of all three sets, c the edges of a cell and `D = |c|`
//! its diagonal.
//!
//! 1. *From above.* S is material, so `dist(body, M) <= dist(body, S)`. A body whose skin meets an interval
//!    meets material.
//! 2. *From below, on faces.* Rays pass through the centers of the cells, along all three axes: they are the
//!    edges of boxes of the size of a cell. A plane, or a fin of any thickness, cuts such a box in a polygon
//!    whose corners lie on those edges, that is on rays. The widest polygon is the rectangle through two
//!    opposite edges; its middle is `D / 2` from its corners. So a point of a face, or of a fin, has an
//!    interval within `D / 2`.
//! 3. *From below, on edges.* At an edge a point may have material on one side only. A flat disk of radius `D
//!    / 2` that lies in the material, of any direction and however thin, is met by a ray (2., for its
//!    center). A point on the rim of one has an interval within `D / 2 + D / 2 = D`. At the corner of a block
//!    along the axes the nearest ray is at most a cell away in two directions, which is less than D.
//!
//! ```text
//!     . . . . . .            |<- D ->|  body farther than D from every interval:
//!     . ___________ . .                 no material of this kind reaches it
//!     . |-+-+-+-+-|  <- rays
//!     . |-+-+-+-+-| .                   true distance:  dist(S) - D <= dist(M) <= dist(S),
//!       '---------'  . .                known to half a diagonal either way
//! ```
//!
//! So `dist(body, M) >= dist(body, S) - D` for material that holds such a disk through each of its
//! points. Excepted are details that no ray sees (a pin or a sliver between the rays, thinner than
//! a cell in two directions) and the last tip of a sharp corner that is turned against the axes.
//! Half a diagonal is not enough: a corner of the raw block may be a whole cell away from the last
//! ray.
//!
//! 4. Material is never outside of the box of the raw stock, whose distance is exact: the larger bound of the
//!    two counts.
//!
//! # Over time
//!
//! Material only goes away. A distance that was proved against an earlier stock is valid for every later
//! one, so that what is kept of a pair stays valid through cuts. [`StockCheck::follow`] takes
//! motions with the stock at the begin of the first one. Where a body would come too near in a
//! later one it stops there, and must be called again with the stock at that moment. So no finding
//! comes from material that was cut before. Within one motion all material counts that is there at
//! its begin.
//!
//! # What is not followed
//!
//! Bodies that move as one with the stock do not move against it. A body that carries the table and
//! lies against its face (a rotary table flush in its cradle) touches the lowest material all the
//! time without a collision. For such a body, which is found with all joints at zero, the layer of
//! material on the face is ignored ([`StockCheck::flush`]) against the part of it that is no higher
//! than the face, and all material above the layer counts. The part of the body above the face,
//! such as the cheeks of the cradle, is checked against all material: however thin a plate is, it
//! must not swing into them.

mod distance;
mod motion;
mod segment;

use std::sync::Arc;

use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use proveout_geom::{Aabb, Point, Pose, Vector, box_mesh};
use proveout_machine::{JointValues, MAX_JOINTS, Machine};
use proveout_stock::{TileTree, TriDexel};

use crate::Interference;
use crate::parts::{CollisionPart, Envelope, MeshDemand, mesh_shape, relation, table_of};
use crate::proved_distance::Turns;
use crate::report::{CollisionError, PartKind, Severity, Unchecked};
use crate::ring::{ring_of, turning_joint};
use crate::shape::{MeshShape, PartShape, to_parry};
use crate::triangle_tree::TriangleTree;
use distance::HalfSpace;
use motion::FollowedBody;

/// How far a flush body may project above the table's face, mm.
const PROUD_MM: f64 = 0.1;

/// A body that met the stock, or came nearer to it than wanted, from begin to end.
#[derive(Clone, Debug, PartialEq)]
pub struct StockBreach {
    /// Name of the body.
    pub body: Arc<str>,
    /// What it is.
    pub kind: PartKind,
    /// How bad it is; a collision also where the rays do not exclude one.
    pub severity: Severity,
    /// Begin, s: never later than the true one.
    pub time: f64,
    /// Joints then.
    pub joints: JointValues,
    /// Distance that is proved, mm.
    pub distance: f64,
    /// Distance of the nearest material on a ray, mm: the true distance is between the two. Zero where the
    /// skin meets it.
    pub ray_distance: f64,
    /// Smallest distance that was proved while it lasts, mm.
    pub least_distance: f64,
    /// Deepest penetration seen while it lasts, mm: a lower estimate.
    pub penetration_estimate: Option<f64>,
    /// The material, or a part of it, lies wholly inside of the body.
    pub inside: bool,
    /// Where, in W, mm.
    pub point_in_work: Point,
    /// End, s: when the body was seen apart again; none while it lasts.
    pub end_time: Option<f64>,
}

/// A motion of the joints, straight but for a little.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMotion {
    /// Joints at both ends.
    pub joints: [JointValues; 2],
    /// Begin and end, s.
    pub time: [f64; 2],
    /// By how much each joint may leave the straight motion, mm and radian: at every moment all of them are
    /// so near to one place of it.
    pub off: JointValues,
    /// By how much a point may be elsewhere than its joints say, mm.
    pub slack: f64,
}

/// The stock among the bodies of a machine and the fixtures; see the text of the module.
#[derive(Clone, Debug)]
pub struct StockCheck {
    machine: Machine,
    table_from_work: Pose,
    bodies: Vec<FollowedBody>,
    fixed_to_stock: Vec<Arc<str>>,
    /// The box of the raw stock, on the table.
    raw: CollisionPart,
    raw_box: Aabb,
    tree: TileTree,
    /// The layer on the table that counts for nothing against a flush body ends here.
    above_layer: HalfSpace,
    layer: f64,
    clearance: f64,
    /// The diagonal of a cell, mm.
    unseen: f64,
    envelope: Envelope,
    turns: Turns,
    /// The box of the raw stock at all turns of the joint that carries it.
    ring: Option<(usize, Arc<CollisionPart>)>,
    last: Option<JointValues>,
    last_time: f64,
    largest_weights: [f64; MAX_JOINTS],
    /// Where all bodies were last looked at, by how much at least each was farther there than needs to be
    /// known, and most of that which any motion has needed since, mm.
    reference: JointValues,
    budget: f64,
    roamed: f64,
    breaches: Vec<StockBreach>,
    queries: u64,
    motions: u64,
}

impl StockCheck {
    /// The stock in the workpiece frame W, mounted on the table, among the bodies and fixtures of a world in
    /// which nothing has moved, with its clearance. `slack` is the most by which the geometric errors of the
    /// machine displace two bodies against each other, mm.
    ///
    /// # Errors
    /// A box of the raw stock that bounds no solid.
    pub fn new(
        world: &Interference,
        stock: &TriDexel,
        table_from_work: &Pose,
        slack: f64,
    ) -> Result<Self, CollisionError> {
        let machine = world.machine.clone();
        let raw_box = stock.bounds();
        let raw = CollisionPart {
            name: "stock".into(),
            kind: PartKind::Stock,
            attached: table_of(&machine),
            zero_from_local: *table_from_work,
            shape: Arc::new(PartShape::Mesh(Box::new(mesh_shape(
                "stock",
                "box",
                &box_mesh(&raw_box),
                MeshDemand::Solid,
            )?))),
            excluded: false,
            bears: false,
        };
        let [x, y, z] = stock.cells_mm();
        let unseen = Vector::new(x, y, z).norm();
        let work_from_table = table_from_work.inverse();
        let layer = world.clearance + unseen + slack + 2.0 * PROUD_MM;
        let (normal, face) =
            (work_from_table.vector(&machine.table.normal), work_from_table.point(&machine.table.point));
        let above_layer = HalfSpace { normal, offset: normal.dot(&face.coords) + layer };
        let mut check = Self {
            envelope: Envelope::new(&machine),
            table_from_work: *table_from_work,
            bodies: Vec::new(),
            fixed_to_stock: Vec::new(),
            tree: TileTree::new(stock),
            raw_box,
            above_layer,
            layer,
            clearance: world.clearance,
            unseen,
            turns: Turns::of(&machine),
            ring: turning_joint(&machine, &raw)
                .and_then(|joint| Some((joint, Arc::new(ring_of(&machine, &raw, joint)?)))),
            last: None,
            last_time: 0.0,
            largest_weights: [0.0; MAX_JOINTS],
            reference: JointValues::ZERO,
            budget: f64::NEG_INFINITY,
            roamed: 0.0,
            breaches: Vec::new(),
            queries: 0,
            motions: 0,
            raw,
            machine,
        };
        for part in &world.parts[..world.fixed_parts] {
            match relation(&check.machine, part, &check.raw, &[]) {
                Some(Some(Unchecked::Rigid)) => check.fixed_to_stock.push(part.name.clone()),
                // The machine file keeps it out, and the gate says so.
                Some(Some(Unchecked::Excluded | Unchecked::PairExcluded)) | None => {}
                Some(_) => check.bodies.extend(FollowedBody::new(part.clone())),
            }
        }
        check.find_flush(stock);
        check.recompute_weights();
        Ok(check)
    }

    /// Names of the bodies that are followed.
    pub fn followed(&self) -> impl Iterator<Item = &Arc<str>> {
        self.bodies.iter().map(|b| &b.part.name)
    }

    /// Least distance of every body that is followed, over all motion so far: proved, and of material on a
    /// ray where any was seen, mm. The true one is at least the first; and at most the second, of what stood
    /// there at the begin of the motion.
    pub fn least(&self) -> impl Iterator<Item = (&Arc<str>, f64, Option<f64>)> {
        self.bodies.iter().map(|b| {
            let [proved, seen] = b.least(&self.turns, &self.reference, self.roamed);
            (&b.part.name, proved, seen.is_finite().then_some(seen))
        })
    }

    /// Bodies that move as one with the stock.
    pub fn fixed_to_stock(&self) -> &[Arc<str>] {
        &self.fixed_to_stock
    }

    /// Bodies that carry the table and lie against its face where the stock lies, and the height of the layer
    /// of material on the face that counts for nothing against them, mm.
    pub fn flush(&self) -> (Vec<Arc<str>>, f64) {
        (self.bodies.iter().filter(|b| b.flush).map(|b| b.part.name.clone()).collect(), self.layer)
    }

    /// The diagonal of a cell, mm: so much nearer than the nearest ray may material be.
    pub fn unseen_mm(&self) -> f64 {
        self.unseen
    }

    /// Every breach so far, in the order in which they began.
    pub fn breaches(&self) -> &[StockBreach] {
        &self.breaches
    }

    /// Number of distance queries so far.
    pub fn queries(&self) -> u64 {
        self.queries
    }

    /// Number of motions so far.
    pub fn motions(&self) -> u64 {
        self.motions
    }

    /// Memory of the boxes over the stock, bytes.
    pub fn memory_bytes(&self) -> u64 {
        self.tree.memory_bytes()
    }

    /// Bodies that carry the table and touch, with all joints at zero, nothing but the layer on its face.
    fn find_flush(&mut self, stock: &TriDexel) {
        let (table, zero) = (table_of(&self.machine), JointValues::ZERO);
        let carriers = crate::parts::chain_to(&self.machine, table).to_vec();
        for i in 0..self.bodies.len() {
            let part = &self.bodies[i].part;
            let chain = crate::parts::chain_to(&self.machine, part.attached);
            if part.kind != PartKind::Machine || !carriers.starts_with(chain) {
                continue;
            }
            let wanted = self.layer - self.unseen - PROUD_MM;
            if self.gap(i, stock, &zero, wanted).is_some() {
                self.bodies[i].flush = true;
                self.bodies[i].flush = self.gap(i, stock, &zero, wanted).is_none();
                self.bodies[i].raised = self.raised(i);
            }
        }
    }

    /// The part of a flush body above the face of the table, with all joints at zero.
    fn raised(&self, i: usize) -> Option<TriangleTree> {
        let body = &self.bodies[i];
        let table = &self.machine.table;
        let local_from_machine = body.part.pose(&self.machine, &JointValues::ZERO).inverse();
        let (normal, face) = (local_from_machine.vector(&table.normal), local_from_machine.point(&table.point));
        let above = HalfSpace { normal, offset: normal.dot(&face.coords) + PROUD_MM };
        let skin = body.mesh().filter(|_| body.flush)?.boxes.triangles();
        let skin: Vec<[Point; 3]> = skin.iter().flat_map(|t| above.part_of(t)).collect();
        (!skin.is_empty()).then(|| TriangleTree::of_triangles(skin))
    }
}

impl MeshShape {
    /// Distance of a point from the nearest triangle, mm.
    fn distance_to_skin(&self, p: &Point) -> f64 {
        self.tree.distance_to_local_point(to_parry(p), false)
    }

    /// How deep a point is inside, mm; zero outside.
    fn depth(&self, p: parry3d_f64::math::Vector) -> f64 {
        let (projection, _) = self.tree.project_local_point_and_get_location(p, false);
        if projection.is_inside { (projection.point - p).length() } else { 0.0 }
    }
}
