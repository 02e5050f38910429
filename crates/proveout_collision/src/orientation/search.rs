//! Whether all poses of a cell are free: the tree of the solids against the parts of the tool.

use std::ops::Range;

use proveout_geom::{Point, Vector};

use super::obstacle_solids::{ObstacleSolid, closest};
use super::tool_part::ToolPart;

/// Added to every bound of a motion, mm: far above the rounding of coordinates of a meter, far below every
/// tolerance.
const ROUNDING_MM: f64 = 1e-9;
/// A ball of the tree is opened when it is larger than this share of the motion inside of the cell: what is
/// smaller is left to smaller cells, for which it is most often apart as a whole.
const OPEN_SHARE: f64 = 1.0;
/// Steps of the search for a plane between a triangle and a part: each is a projection on both.
const PLANE_STEPS: usize = 10;
/// After the first piece that a finest cell is not free of, so many more are looked at for one that blocks
/// it.
const MORE_LOOKS: u32 = 24;
/// So many pieces of a triangle are looked at.
const MOST_PIECES: usize = 40;
/// Pieces are no smaller than this, mm.
const LEAST_PIECE_MM: f64 = 0.1;
/// Shorter vectors across an axis, and products of edges and axes, have no direction.
const SHORTEST: f64 = 1e-12;
/// Square of a step below which the search for a plane stands, mm^2.
const STANDS: f64 = 1e-18;

/// What is proved of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Free,
    Blocked,
    Open,
}

/// A ball of a solid's tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) solid: u32,
    pub(crate) node: u32,
}

/// The pose at the center of a cell, and the range of motion that it covers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellPose {
    /// O.
    pub(crate) center: Point,
    /// Q.
    pub(crate) pivot: Point,
    /// N.
    pub(crate) normal: Vector,
    /// V.
    pub(crate) axis: Vector,
    /// Largest |V' - V|.
    pub(crate) chord: f64,
    /// Largest |O' - O|, mm.
    pub(crate) shift: f64,
    /// Largest angle about Q, radian.
    pub(crate) turn: f64,
    /// |O - Q|, the same in every pose, mm.
    pub(crate) offset: f64,
    /// Shift of the contact that is allowed for, mm, and |R' - R| of its frame.
    pub(crate) drift: [f64; 2],
}

/// How far places are from the centers of the motions: from O, from Q and from the ray below Q.
#[derive(Clone, Copy)]
struct MomentArms {
    center: f64,
    pivot: f64,
    ray: f64,
}

impl CellPose {
    fn levers(&self, p: &Point) -> MomentArms {
        let from = p - self.pivot;
        let up = from.dot(&self.normal);
        let pivot = from.norm();
        let ray = if up > 0.0 { pivot } else { (pivot * pivot - up * up).max(0.0).sqrt() };
        MomentArms { center: (p - self.center).norm(), pivot, ray }
    }

    /// How much the distance of a place from a part may change: formulas (1), (2) and (3).
    fn motion(&self, limb: &ToolPart, at: MomentArms) -> f64 {
        // Seen from the part no more moves than the place, seen from the place no more than the farthest
        // point of the part.
        let far = at.pivot.min(limb.reach + self.offset);
        let inside = if limb.is_disk() {
            // No two points of the disk are farther apart than its diameter.
            at.ray.min(2.0 * self.offset) * self.turn
        } else {
            (at.center.min(limb.reach) * self.chord + self.shift).min(far * self.turn)
        };
        inside + self.drift[0] + self.drift[1] * far + ROUNDING_MM
    }

    /// Distance of a place from the axis and height above O.
    fn half_plane(&self, p: &Point) -> ([f64; 2], Vector) {
        let from = p - self.center;
        let z = from.dot(&self.axis);
        let radial = from - self.axis * z;
        ([radial.norm(), z], radial)
    }
}

#[derive(Clone, Copy, Debug)]
enum BallNearness {
    Apart,
    Blocked,
    /// Not decided: the largest of the motions, and the least distance above what is asked for, mm.
    Open {
        motion: f64,
        depth: f64,
    },
}

impl BallNearness {
    fn depth(self) -> f64 {
        match self {
            Self::Apart => f64::INFINITY,
            Self::Blocked => f64::NEG_INFINITY,
            Self::Open { depth, .. } => depth,
        }
    }
}

/// The parts and solids, and lists of candidates that one search after another uses.
pub(crate) struct CellSearch<'a> {
    pub(crate) limbs: &'a [ToolPart],
    pub(crate) solids: &'a [ObstacleSolid],
    /// Candidates of the cells that are being checked, in consecutive lists.
    pub(crate) lists: Vec<Candidate>,
    stack: Vec<(Candidate, BallNearness)>,
    pieces: Vec<[Point; 3]>,
    /// Balls and triangles looked at.
    pub(crate) looked: u64,
}

impl<'a> CellSearch<'a> {
    pub(crate) fn new(limbs: &'a [ToolPart], solids: &'a [ObstacleSolid]) -> Self {
        let lists = (0..solids.len() as u32).map(|solid| Candidate { solid, node: 0 }).collect();
        Self { limbs, solids, lists, stack: Vec::new(), pieces: Vec::new(), looked: 0 }
    }

    /// Compares the candidates of a list with all poses of a cell. Those that are not apart are
    /// appended to the lists; at the last level all balls are opened.
    pub(crate) fn settle(&mut self, pose: &CellPose, from: Range<usize>, last: bool) -> Verdict {
        let end = self.lists.len();
        let mut stack = std::mem::take(&mut self.stack);
        stack.clear();
        let mut blocked = false;
        let mut deepest = (f64::INFINITY, end);
        let mut left = MORE_LOOKS;
        // From the end of the list, which has the deepest one.
        'list: for index in from.rev() {
            let candidate = self.lists[index];
            let near = self.ball(pose, candidate);
            stack.push((candidate, near));
            while let Some((candidate, mut near)) = stack.pop() {
                if let BallNearness::Open { motion, depth } = near {
                    let solid = &self.solids[candidate.solid as usize];
                    let node = &solid.nodes[candidate.node as usize];
                    let small = !last && node.radius < OPEN_SHARE * motion;
                    if !node.leaf && !small {
                        let [a, b] = [node.first, node.first + 1].map(|node| {
                            let candidate = Candidate { node, ..candidate };
                            (candidate, self.ball(pose, candidate))
                        });
                        stack.extend(if a.1.depth() < b.1.depth() { [b, a] } else { [a, b] });
                        continue;
                    }
                    if node.leaf && !small {
                        near = self.triangle(pose, solid, node.first, last);
                    }
                    if matches!(near, BallNearness::Open { .. }) {
                        if depth < deepest.0 {
                            deepest = (depth, self.lists.len());
                        }
                        self.lists.push(candidate);
                    }
                }
                if matches!(near, BallNearness::Blocked) {
                    blocked = true;
                    break 'list;
                }
                // Where nothing is divided any more the cell is not free; a few more looks may show that it
                // is blocked.
                if last && self.lists.len() > end {
                    left -= 1;
                    if left == 0 {
                        break 'list;
                    }
                }
            }
        }
        self.stack = stack;
        if blocked {
            self.lists.truncate(end);
            return Verdict::Blocked;
        }
        if self.lists.len() == end {
            return Verdict::Free;
        }
        // Lists are worked off from their end: what is deepest first blocks smaller cells soon.
        let behind = self.lists.len() - 1;
        self.lists.swap(deepest.1, behind);
        Verdict::Open
    }

    fn ball(&mut self, pose: &CellPose, candidate: Candidate) -> BallNearness {
        self.looked += 1;
        let solid = &self.solids[candidate.solid as usize];
        let node = &solid.nodes[candidate.node as usize];
        let kind = usize::from(!solid.cut);
        let (place, _) = pose.half_plane(&node.center);
        let at = pose.levers(&node.center);
        let wide =
            MomentArms { center: at.center + node.radius, pivot: at.pivot + node.radius, ray: at.ray + node.radius };
        let (mut largest, mut depth) = (0.0_f64, f64::INFINITY);
        for limb in self.limbs {
            let need = limb.needs[kind];
            let away = at.center - node.radius - limb.reach - pose.shift - pose.drift[0];
            if away - pose.drift[1] * wide.pivot > need + ROUNDING_MM {
                continue;
            }
            let motion = pose.motion(limb, wide);
            let wanted = need + node.radius + motion;
            if limb.hull_distance(place) > wanted {
                continue;
            }
            let distance = limb.height(place).distance;
            if distance > wanted {
                continue;
            }
            (largest, depth) = (largest.max(motion), depth.min(distance - need));
            if distance < need && self.is_deep(pose, limb, need, &node.anchor) {
                return BallNearness::Blocked;
            }
        }
        if depth < f64::INFINITY { BallNearness::Open { motion: largest, depth } } else { BallNearness::Apart }
    }

    /// A point of a skin that is nearer than is asked for in all poses.
    fn is_deep(&self, pose: &CellPose, limb: &ToolPart, need: f64, p: &Point) -> bool {
        let (place, _) = pose.half_plane(p);
        limb.height(place).distance + pose.motion(limb, pose.levers(p)) < need
    }

    fn triangle(&mut self, pose: &CellPose, solid: &ObstacleSolid, triangle: u32, last: bool) -> BallNearness {
        let corners = solid.triangles[triangle as usize];
        let kind = usize::from(!solid.cut);
        let mut open = BallNearness::Apart;
        for limb in self.limbs {
            let need = limb.needs[kind];
            match plane(pose, limb, need, &corners) {
                BallNearness::Apart => {}
                BallNearness::Blocked => return BallNearness::Blocked,
                BallNearness::Open { motion, depth } => {
                    if last && limb.is_disk() {
                        match in_pieces(&mut self.pieces, pose, limb, need, corners) {
                            BallNearness::Apart => continue,
                            BallNearness::Blocked => return BallNearness::Blocked,
                            BallNearness::Open { .. } => {}
                        }
                    }
                    open = BallNearness::Open { motion, depth };
                }
            }
        }
        open
    }
}

/// Looks for a plane that supports the part and has the triangle far enough above it.
fn plane(pose: &CellPose, limb: &ToolPart, need: f64, corners: &[Point; 3]) -> BallNearness {
    // Distances are convex: the largest over a triangle is that of a corner.
    let mut wide = MomentArms { center: 0.0, pivot: 0.0, ray: 0.0 };
    for p in corners {
        let at = pose.levers(p);
        wide = MomentArms {
            center: wide.center.max(at.center),
            pivot: wide.pivot.max(at.pivot),
            ray: wide.ray.max(at.ray),
        };
    }
    let motion = pose.motion(limb, wide);
    let wanted = need + motion;
    let middle = Point::from((corners[0].coords + corners[1].coords + corners[2].coords) / 3.0);
    let ([_, z], _) = pose.half_plane(&middle);
    let mut x = closest(corners, &(pose.center + pose.axis * limb.clamp(z)));
    for step in 0..PLANE_STEPS {
        let (place, radial) = pose.half_plane(&x);
        let height = limb.height(place);
        if height.distance < need && height.distance + pose.motion(limb, pose.levers(&x)) < need {
            return BallNearness::Blocked;
        }
        let outward = radial.try_normalize(SHORTEST).unwrap_or_else(|| across(&pose.axis));
        let normal = outward * height.normal[0] + pose.axis * height.normal[1];
        let lowest = corners.iter().map(|p| normal.dot(&(p - x))).fold(f64::INFINITY, f64::min);
        if height.distance + lowest > wanted {
            return BallNearness::Apart;
        }
        // Projections go along nearly parallel faces with short steps: planes of the face and of edges along
        // the side end that.
        let next = if step == 1 {
            let (least, nearest) = face_and_edges(pose, limb, corners);
            if least > wanted {
                return BallNearness::Apart;
            }
            closest(corners, &nearest)
        } else {
            closest(corners, &(x - normal * height.distance))
        };
        if step != 1 && (next - x).norm_squared() < STANDS {
            if step > 1 {
                break;
            }
            continue;
        }
        x = next;
    }
    BallNearness::Open { motion, depth: 0.0 }
}

/// The best of the planes along the face of a triangle and along an edge and the axis: least height of a
/// corner over the part, and the point of the part that the plane touches.
fn face_and_edges(pose: &CellPose, limb: &ToolPart, corners: &[Point; 3]) -> (f64, Point) {
    let [a, b, c] = corners;
    let edges = [b - a, c - b, a - c];
    let directions =
        [edges[0].cross(&edges[1]), edges[0].cross(&pose.axis), edges[1].cross(&pose.axis), edges[2].cross(&pose.axis)];
    let mut best = (f64::NEG_INFINITY, pose.center);
    for direction in directions {
        let Some(normal) = direction.try_normalize(SHORTEST) else { continue };
        for normal in [normal, -normal] {
            let lowest = corners.iter().map(|p| normal.dot(&(p - pose.center))).fold(f64::INFINITY, f64::min);
            let w = normal.dot(&pose.axis);
            let radial = normal - pose.axis * w;
            let (support, at) = limb.support([radial.norm(), w]);
            if lowest - support > best.0 {
                let outward = radial.try_normalize(SHORTEST).unwrap_or_else(|| across(&pose.axis));
                best = (lowest - support, pose.center + outward * at[0] + pose.axis * at[1]);
            }
        }
    }
    best
}

/// The quarters of a triangle, and theirs, as far as needed: the bound (2) is small only near the contact.
fn in_pieces(
    pieces: &mut Vec<[Point; 3]>,
    pose: &CellPose,
    limb: &ToolPart,
    need: f64,
    corners: [Point; 3],
) -> BallNearness {
    pieces.clear();
    pieces.push(corners);
    let mut looked = 0;
    while let Some(piece) = pieces.pop() {
        looked += 1;
        match plane(pose, limb, need, &piece) {
            BallNearness::Apart => {}
            BallNearness::Blocked => return BallNearness::Blocked,
            open @ BallNearness::Open { .. } => {
                let [a, b, c] = piece;
                let edge = (b - a).norm().max((c - b).norm()).max((a - c).norm());
                if edge < LEAST_PIECE_MM || looked > MOST_PIECES {
                    return open;
                }
                let [d, e, f] = [nalgebra::center(&a, &b), nalgebra::center(&b, &c), nalgebra::center(&c, &a)];
                pieces.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
            }
        }
    }
    BallNearness::Apart
}

/// Any direction across an axis.
fn across(axis: &Vector) -> Vector {
    let off = if axis.x.abs() < 0.7 { Vector::x() } else { Vector::y() };
    axis.cross(&off).normalize()
}
