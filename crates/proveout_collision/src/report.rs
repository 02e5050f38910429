//! What a check says.

use std::sync::Arc;

use proveout_geom::{MeshError, Point};
use proveout_machine::JointValues;
use proveout_tool::Role;
use thiserror::Error;

/// What a part is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PartKind {
    /// Flutes.
    Cutter,
    /// Neck of the tool.
    Neck,
    /// Shank of the tool.
    Shank,
    /// Tool holder.
    Holder,
    /// A body of the machine.
    Machine,
    /// A fixture, clamp or platform of the setup.
    Fixture,
    /// The stock.
    Stock,
}

impl PartKind {
    /// Which part of the tool it is; none for what is no part of the tool.
    pub fn role(self) -> Option<Role> {
        match self {
            Self::Cutter => Some(Role::Cutting),
            Self::Neck => Some(Role::Neck),
            Self::Shank => Some(Role::Shank),
            Self::Holder => Some(Role::Holder),
            Self::Machine | Self::Fixture | Self::Stock => None,
        }
    }
}

/// How bad a breach is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// Nearer than the clearance asked for, not touching.
    NearMiss,
    /// Touching, overlapping, or one inside of the other; or so near that this is not excluded (0.2
    /// micrometers).
    Collision,
    /// The distance could not be computed; counts as a collision.
    QueryFailed,
}

/// One pair of parts that came too near, from its begin to its end.
///
/// A near miss that becomes a collision gives two entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Breach {
    /// Index in the list of pairs.
    pub pair: usize,
    /// Names of the two parts.
    pub bodies: [Arc<str>; 2],
    /// What they are.
    pub kinds: [PartKind; 2],
    /// How bad it is.
    pub severity: Severity,
    /// Begin, s: the first time at which the parts may be this near; never later than the true one.
    pub time: f64,
    /// Joints then.
    pub joints: JointValues,
    /// Distance measured then, mm; zero when the parts meet. Never a penetration.
    pub distance: f64,
    /// Smallest distance measured while the breach lasts, mm.
    pub least_distance: f64,
    /// Deepest penetration seen while the breach lasts, mm: a lower estimate, taken at ends of pieces. None
    /// while the parts only touch or are near.
    pub penetration_estimate: Option<f64>,
    /// One part lies wholly inside of the other.
    pub inside: bool,
    /// Where, in the table frame K, mm: middle of the nearest points, or a point near the contact.
    pub point_in_table: Point,
    /// End, s: when the pair was seen apart again; none while the breach lasts.
    pub end_time: Option<f64>,
}

/// Smallest distance that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastMeasured {
    /// Distance, mm; zero for a collision.
    pub distance: f64,
    /// Index of the pair.
    pub pair: usize,
    /// Names of the two parts.
    pub bodies: [Arc<str>; 2],
    /// When, s.
    pub time: f64,
    /// Where, in the table frame K, mm.
    pub point_in_table: Point,
}

/// Clearance of all pairs over everything checked so far. The true smallest distance is between the two.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// Smallest distance measured; none when no pair was within the range of a query.
    pub measured: Option<LeastMeasured>,
    /// Proved lower bound, mm; infinite when there is no pair to check.
    pub lower_bound: f64,
}

/// How checks were settled, from the cheapest to the dearest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Pieces of motion.
    pub pieces: u64,
    /// Pieces that the smallest allowance of all pairs settled: one scalar product for all of them.
    pub pieces_by_allowance: u64,
    /// Pairs that were looked at one by one, in pieces that were not settled so (a piece of much turning
    /// counts in steps).
    pub pair_checks: u64,
    /// Pairs that their own allowance settled: one scalar product.
    pub pairs_by_allowance: u64,
    /// Queries that ended with "farther than is needed", and a proved distance.
    pub misses: u64,
    /// Queries that ended with a distance.
    pub distances: u64,
}

impl Effort {
    /// Share of the pieces in which no distance was asked for, or could not be, 0 to 1: those settled by one
    /// scalar product.
    pub fn share_by_allowance(&self) -> f64 {
        if self.pieces == 0 { 1.0 } else { self.pieces_by_allowance as f64 / self.pieces as f64 }
    }

    /// Share of the pairs that were looked at one by one, and were settled so as well.
    pub fn share_of_pairs_by_allowance(&self) -> f64 {
        if self.pair_checks == 0 { 1.0 } else { self.pairs_by_allowance as f64 / self.pair_checks as f64 }
    }
}

/// A pair of parts and whether it is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct PairInfo {
    /// Names of the two parts.
    pub bodies: [Arc<str>; 2],
    /// What they are.
    pub kinds: [PartKind; 2],
    /// Why the pair is not checked; none when it is.
    pub unchecked: Option<Unchecked>,
    /// Below this distance they give a near miss, mm.
    pub near_miss: f64,
    /// The machine file has a rule of its own for the pair: why, in its words, which may be none.
    pub ruled: Option<Arc<str>>,
    /// Of machine bodies of neighboring joints: the larger part of a skin that is left out, since the two
    /// bear on each other there, 0 to 1.
    pub bearing: f64,
}

/// Why a pair is not checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unchecked {
    /// Both move as one.
    Rigid,
    /// Machine bodies of neighboring joints with nothing left outside the volume in which they bear
    /// on each other, though no role says that they bear.
    Neighbors,
    /// The same of a body that bears by its role in the machine file ([`crate::BEARING_ROLES`]), or is round
    /// about the axis of the joint between them, so that it is at every turn where it is at rest.
    Guide,
    /// Machine bodies of neighboring joints with a tilting platform between them, whose motion leaves no
    /// volume in place.
    Platform,
    /// The caller allows it.
    Allowed,
    /// The machine description excludes the body.
    Excluded,
    /// The machine description excludes the pair.
    PairExcluded,
}

impl Unchecked {
    /// Words for a report.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Rigid => "both parts move as one",
            Self::Neighbors => "machine bodies of neighboring joints bear on each other all over",
            Self::Guide => {
                "one of them bears on the other everywhere: by its role in the machine file, or all around the axis \
                 of the joint between them"
            }
            Self::Platform => "the platform between them tilts about no fixed line, so that no volume can be left out",
            Self::Allowed => "allowed by the setup",
            Self::Excluded => "the machine description excludes the body from checks",
            Self::PairExcluded => "the machine description excludes the pair from checks",
        }
    }
}

/// What a mesh lacks that is checked all the same.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFaults {
    /// Why it bounds no solid: its inside is not defined, so that only its surface is checked.
    pub open: Option<MeshError>,
    /// Triangles without area; they are checked as the lines and points that they are.
    pub flat: usize,
}

/// Why interference cannot be checked.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CollisionError {
    /// A mesh does not bound a solid: of a machine body or fixture one that has no volume, is inside out, or
    /// no numbers.
    #[error("the mesh of {kind} \"{name}\" does not bound a solid: {fault}; repair the mesh or exclude the body")]
    NotSolid {
        /// `machine body`, `fixture` or `solid`.
        kind: &'static str,
        /// Name.
        name: String,
        /// First fault.
        fault: MeshError,
    },
    /// The search tree refused a mesh.
    #[error("the mesh of {kind} \"{name}\" cannot be searched: {fault}; repair the mesh or exclude the body")]
    Tree {
        /// `machine body`, `fixture` or `solid`.
        kind: &'static str,
        /// Name.
        name: String,
        /// What the tree says.
        fault: String,
    },
    /// A clearance below zero or not a number.
    #[error("the clearance of {value} mm is not a length of zero or more")]
    Clearance {
        /// Value given, mm.
        value: f64,
    },
}
