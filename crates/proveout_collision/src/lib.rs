//! Interference of tool, holder, machine bodies and fixtures while the joints of a machine move. The stock
//! judges itself what is swept through it, the parts of the tool (crate `proveout_stock`); the other bodies
//! are followed against the material on its rays ([`StockCheck`]). The design part is judged by the deviation
//! of what was cut.
//!
//! Data in: a [`proveout_machine::Machine`] with its bodies (M with all joints at zero), [`Fixture`]s (table
//! frame K), tools, and straight motions of the joints, mm and radian. Data out: [`Breach`]es with time,
//! joints, pair and place (table frame K), the smallest distance with its pair, and the list of pairs that
//! were not checked, each with the reason.
//!
//! * [`Interference`] – takes pieces of motion in order.
//! * [`StockCheck`] – takes them with the stock as it is cut; [`StockBreach`] – a body that met it, or came
//!   near.
//! * [`Breach`] – near miss or collision of one pair, from begin to end; distance and penetration are
//!   different fields.
//! * [`ToolClearance`] – one tool pose among fixed solids: which tool axes are free.
//! * [`OrientationSpace`] – all axes of a tool at a contact: which are free, with proof (module text of
//!   `orientation`).
//! * [`SolidPair`] – distance of two meshes in pose after pose.
//! * [`Clearance`] – smallest distance measured, and the lower bound that is proved as the check needs it.
//! * [`PairClearance`], [`ProvedSpan`] – least distance of each pair over the motion, and what proves it.
//!
//! ```
//! use proveout_collision::{Fixture, Interference, Severity};
//! use proveout_geom::{Aabb, Point, box_mesh};
//! use proveout_machine::{JointValues, Machine};
//! use proveout_tool::{Cutter, ToolBuilder};
//!
//! let mut machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
//! machine.bodies.clear(); // a fixture and the tool alone
//! let block = Aabb { min: Point::new(50.0, -20.0, 0.0), max: Point::new(60.0, 20.0, 400.0) };
//! let wall = Fixture { name: "wall".to_owned(), mesh: box_mesh(&block), on_table: true };
//! let mut check = Interference::new(&machine, &[wall], 0.0)?;
//! let tool = ToolBuilder::new(1, "END_D12", Cutter::flat(12.0)?, 26.0, 120.0).build()?;
//! check.set_tool(Some(&tool));
//! let at = |x: f64| JointValues([x, 0.0, 300.0, 0.0, 0.0, 0.0, 0.0, 0.0]); // X Y Z B C
//! check.check_piece(&at(0.0), &at(60.0), [0.0, 1.0], 0.0);
//! // The tool of 6 mm radius meets the wall after 44 of 60 mm.
//! let hit = &check.breaches()[0];
//! assert!(hit.severity == Severity::Collision && (hit.time - 44.0 / 60.0).abs() < 1e-3); // s
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Method
//!
//! Conservative advancement: between two positions of the joints the distance of two parts changes by at most
//! `mu = sum |dq_linear| + sum R |dq_rotary|`, R being the farthest distance of the moving part from that
//! axis. Where the distance d at time t is above `threshold + mu (1 - t)`, the rest of the step is clear;
//! otherwise the motion is safe up to `t + (d - threshold) / mu`, where the distance is asked for again
//! (Mirtich 1996; Zhang, Redon, Lee and Kim 2007).
//!
//! ```text
//!  distance
//!    |\        d(t) is above each of the dashed lines of slope -mu
//!    | \ \ .   so no contact is stepped over, however thin the part
//!    |  \  \   . . .
//!    |---\--\----------  threshold
//!    +----t1-t2-------> t
//! ```
//!
//! 1. Every pair keeps the distance that was last proved, less the motion since then. A query is made only
//!    when that is used up. All pairs together keep the smallest of these allowances, so that most pieces
//!    cost one scalar product.
//! 2. Distances are bounded: a query stops when it has proved that the parts are further apart than is
//!    needed.
//! 3. Tools are exact convex bodies of revolution (support functions of their generating curves). GJK finds a
//!    direction, the gap between two planes across it is the proved distance, within 1e-7 mm of the true one.
//!    Meshes are compared triangle by triangle in closed form, down two trees of boxes at once
//!    ([`nearest_leaves`]), starting with those that were nearest last time. A bounded query that finds
//!    nothing proves a distance all the same: the smallest bound of what it left out.
//! 4. Skins alone do not show a part wholly inside another: at the start, after a tool change and after a
//!    contact, the winding number of a point of each part about the other is tested. Skins that never met
//!    cannot change it. A mesh that is not closed has no defined inside: its surface is checked, and
//!    [`Interference::mesh_faults`] names it.
//! 5. A failed query and joints that are not numbers count as collisions.
//!
//! # Known limits
//!
//! Machine bodies of neighboring joints are checked without the volume in which they bear on each other (text
//! of `neighbors.rs`); one of which nothing is left is listed, with whether its role is to bear; those that a
//! tilting platform carries are not, and are listed so. Penetration is a lower estimate from vertices and
//! points on the generating curves, and is not estimated for neighbors. A pair that collides is looked at
//! again each half millimeter of motion; a separation and new contact in between counts as one breach.
//!
//! # Files
//!
//! | file or folder | holds |
//! |---|---|
//! | `interference`, `parts` | pairs of a machine: which are checked |
//! | `neighbors`, `neighbor_shells` | bodies that bear on each other |
//! | `pair_advance`, `conservative_advancement` | one pair through a motion |
//! | `proved_distance` | when the distance of a pair is needed again |
//! | `distance`, `gjk`, `triangle`, `triangle_tree`, `box_tree`, `shape` | distance of two bodies |
//! | `swept`, `ring` | bodies in motion: between two poses, at all turns at once |
//! | `least_clearance` | least distance of each pair over a motion, with its proof |
//! | `stock` | bodies against the material on the rays of the stock |
//! | `orientation` | free tool axes at a contact, with proof |
//! | `solid_pair`, `tool_clearance` | two solids; one tool pose among solids |
//! | `report` | breaches, smallest distance, pairs that were not checked |

mod box_tree;
mod conservative_advancement;
mod distance;
#[cfg(test)]
mod effort_tests;
mod gjk;
mod interference;
mod least_clearance;
mod neighbor_shells;
mod neighbors;
mod orientation;
mod pair_advance;
mod parts;
mod proved_distance;
mod report;
mod ring;
mod shape;
mod solid_pair;
mod stock;
mod swept;
mod tool_clearance;
mod triangle;
mod triangle_tree;

pub use box_tree::{BoxTree, Branch, NearestLeaves, nearest_leaves};
pub use interference::{FinerPiece, Interference};
pub use least_clearance::{PairClearance, ProvedSpan};
pub use neighbors::ZONE_MM;
pub use orientation::{
    AxisState, Obstacle, OrientationCell, OrientationError, OrientationMap, OrientationSettings, OrientationSpace,
    OrientationWalk, Refusal, SurfaceContact,
};
pub use parts::{BEARING_ROLES, Fixture};
pub use report::{
    Breach, Clearance, CollisionError, Effort, LeastMeasured, MeshFaults, PairInfo, PartKind, Severity, Unchecked,
};
pub use solid_pair::SolidPair;
pub use stock::{JointMotion, StockBreach, StockCheck};
pub use tool_clearance::{StandingSolids, ToolClearance};
