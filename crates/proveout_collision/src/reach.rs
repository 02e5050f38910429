//! Which bodies come within reach of the stock.
//!
//! The stock is judged by the parts of the tool that are swept through it. Machine bodies and fixtures are meshes of any form, and
//! nothing sweeps them through the stock. So that no gate passes what nobody has looked at, the box of the raw stock is followed
//! along the motion like a body, by distance with a motion bound: a body that keeps the wanted clearance from the box keeps it
//! from every stock that is left in it; of one that does not, nothing is known.
//!
//! ```text
//!      spindle  |___|        .--------------.  box of the raw stock, grown by the clearance
//!                            :  ____        :
//!               never inside : |    |__     : the stock that is left
//!               of it: clear : |_______|____:
//! ```
//!
//! Bodies that move as one with the stock, the table and what stands on it, do not move against it: where they touch, it is the
//! mounting, and no motion changes it. They are named apart.

use std::sync::Arc;

use proveout_geom::{Aabb, Pose, box_mesh};
use proveout_machine::JointValues;

use crate::Interference;
use crate::advance::State;
use crate::parts::{Part, mesh_shape, relation, table_of};
use crate::report::{CollisionError, PartKind, Unchecked};
use crate::shape::Shape;

/// A body that came within reach of the box of the stock.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// Name of the body.
    pub body: Arc<str>,
    /// When it may first have been that near, s.
    pub time: f64,
}

/// The box of the raw stock among the bodies of a machine and the fixtures; see the text of the file.
#[derive(Clone, Debug)]
pub struct StockReach {
    world: Interference,
    reached: Vec<Reached>,
    fixed_to_stock: Vec<Arc<str>>,
    looked_at: usize,
}

impl StockReach {
    /// A box in the workpiece frame W, mounted on the table, among the bodies and fixtures of a world in which nothing has moved,
    /// with its clearance.
    ///
    /// # Errors
    /// A box that bounds no solid.
    pub fn new(world: &Interference, stock: &Aabb, table_from_work: &Pose) -> Result<Self, CollisionError> {
        let mut world = world.clone();
        world.parts.truncate(world.fixed_parts);
        let mesh = box_mesh(stock).transformed(table_from_work);
        world.parts.push(Part {
            name: "stock".into(),
            kind: PartKind::Stock,
            attached: table_of(&world.machine),
            zero_from_local: Pose::identity(),
            shape: Arc::new(Shape::Mesh(Box::new(mesh_shape("stock", "box", &mesh, true)?))),
            excluded: false,
        });
        let last = world.parts.len() - 1;
        let rigid =
            |part: &Part| relation(&world.machine, part, &world.parts[last], &[]) == Some(Some(Unchecked::Rigid));
        let fixed_to_stock = world.parts[..last].iter().filter(|p| rigid(p)).map(|p| p.name.clone()).collect();
        world.pair_with_last();
        Ok(Self { world, reached: Vec::new(), fixed_to_stock, looked_at: 0 })
    }

    /// Follows one straight motion of the joints, as [`Interference::check_piece`].
    pub fn check_piece(&mut self, from: &JointValues, to: &JointValues, time: [f64; 2], slack: f64) {
        self.check_bent_piece([from, to], time, slack, &JointValues::ZERO);
    }

    /// Follows a motion that is not quite straight, as [`Interference::check_bent_piece`].
    pub fn check_bent_piece(&mut self, ends: [&JointValues; 2], time: [f64; 2], slack: f64, off: &JointValues) {
        let begun = self.world.check_bent_piece(ends, time, slack, off);
        for i in begun {
            let breach = &self.world.breaches()[i];
            if self.reached.iter().all(|r| r.body != breach.bodies[0]) {
                self.reached.push(Reached { body: breach.bodies[0].clone(), time: breach.time });
            }
        }
        if self.reached.len() > self.looked_at {
            // What is known of a body does not change any more.
            self.looked_at = self.reached.len();
            // A body may come near and go away again within one piece.
            let (parts, reached) = (&self.world.parts, &self.reached);
            self.world.pairs.retain(|p| {
                let named = |i: usize| reached.iter().any(|r| r.body == parts[i].name);
                p.state == State::Clear && !named(p.a) && !named(p.b)
            });
            self.world.budget = f64::NEG_INFINITY;
        }
    }

    /// Bodies that came within reach, in order of time.
    pub fn reached(&self) -> &[Reached] {
        &self.reached
    }

    /// Bodies that move as one with the stock.
    pub fn fixed_to_stock(&self) -> &[Arc<str>] {
        &self.fixed_to_stock
    }

    /// Number of bodies that kept away so far.
    pub fn clear(&self) -> usize {
        self.world.pairs.len()
    }
}
