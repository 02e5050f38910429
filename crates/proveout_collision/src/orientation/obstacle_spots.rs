//! What the places of solids forbid the axis of a tool with a ball end, as seen from the center of the ball
//! at one contact.
//!
//! A *spot* is a ball of a solid's tree or a piece of a triangle. Spots are made where they are asked for,
//! and their parts where they are opened; they live for one contact. What every look needs is kept apart from
//! the rest, in half a line of the cache.

use proveout_geom::{Point, Vector};

use super::BALL_ROUNDING;
use super::extent::Extent;
use super::obstacle_solids::ObstacleSolid;
use super::space::PivotedContact;

/// So many balls and pieces of triangles are looked at for one contact; what is not decided then stays
/// unknown.
const MOST_SPOTS: usize = 1_000_000;
/// Room for so many is made at once.
const USUAL_SPOTS: usize = 1 << 14;
/// Where the sum of two angles comes this near to half a turn (its sine), its cosine is too
/// imprecise: it counts as half a turn.
const NEAR_HALF_TURN: f64 = 1e-3;

/// An angle by its cosine and sine.
pub(super) type Turn = [f64; 2];

pub(super) fn turn(angle: f64) -> Turn {
    [angle.cos(), angle.sin()]
}

#[inline(always)]
fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

/// Whether a sum of two angles, each up to half a turn, is known to be below half a turn.
#[inline(always)]
fn is_below_half_turn([cosine, sine]: Turn) -> bool {
    sine > if cosine < 0.0 { NEAR_HALF_TURN } else { 0.0 }
}

/// The angle of a cosine, 0 to half a turn.
fn of_cosine(c: f64) -> Turn {
    [c, (1.0 - c * c).max(0.0).sqrt()]
}

/// What a spot represents.
#[derive(Clone, Copy, Debug)]
enum SpotSource {
    Ball(u32),
    /// Number of its corners.
    Piece(u32),
}

/// A ball of a solid's tree or a piece of a triangle as seen from the center of the cutter's ball: what every
/// look needs, in half a line of the cache.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObstacleSpot {
    /// Unit vector to its center.
    pub(super) way: [f32; 3],
    /// No axis farther from there is forbidden; half a turn where all may be.
    pub(super) high: [f32; 2],
    /// Sine of half the angle under which it is seen; more than one from inside of it.
    pub(super) size: f32,
    /// Its parts, once it was opened, and how many.
    parts: u32,
    count: u32,
}

/// A piece of a triangle in a ball.
#[derive(Clone, Copy, Debug)]
struct TrianglePiece {
    corners: [Point; 3],
    center: Point,
    radius: f64,
}

/// What is not yet opened or asked for.
const CLOSED: u32 = u32::MAX;

/// Where a spot comes from.
#[derive(Clone, Copy, Debug)]
struct Origin {
    solid: u32,
    what: SpotSource,
    /// Number of what is known of its anchor, once it was asked for.
    anchor: u32,
}

/// What is asked where a spot is not apart from a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    /// Unit vector to a point of the skin, and the angles from it at which an axis may be forbidden, and is.
    pub(super) way: [f32; 3],
    pub(super) reach: Option<[[f32; 2]; 2]>,
    pub(super) inner: Option<[[f32; 2]; 2]>,
    /// No axis nearer to the center of the spot is forbidden.
    pub(super) low: Option<[f32; 2]>,
}

/// The spots of one contact.
pub(super) struct Spots<'a> {
    extents: &'a [Extent; 2],
    solids: &'a [ObstacleSolid],
    center: Point,
    normal: Vector,
    /// Largest tilt that is looked at.
    limit: Turn,
    spots: Vec<ObstacleSpot>,
    origins: Vec<Origin>,
    anchors: Vec<Anchor>,
    pieces: Vec<TrianglePiece>,
    /// Number of those that hold a whole solid: the first ones.
    pub(super) roots: u32,
}

impl<'a> Spots<'a> {
    /// Those of the solids; `extents` are for solids that are cut and for others, `limit` is the largest tilt
    /// that is looked at, radian.
    pub(super) fn new(
        extents: &'a [Extent; 2],
        solids: &'a [ObstacleSolid],
        place: &PivotedContact,
        limit: f64,
    ) -> Self {
        let mut spots = Self {
            extents,
            solids,
            center: place.pivot,
            normal: place.frame.normal,
            limit: turn(limit),
            spots: Vec::with_capacity(USUAL_SPOTS),
            origins: Vec::with_capacity(USUAL_SPOTS),
            anchors: Vec::with_capacity(USUAL_SPOTS / 2),
            pieces: Vec::with_capacity(USUAL_SPOTS),
            roots: 0,
        };
        for (solid, of) in solids.iter().enumerate() {
            let [spot] = spots.spots_of_balls(solid as u32, &[of.nodes[0].center], &[of.nodes[0].radius]);
            spots.store_spot(solid as u32, spot, SpotSource::Ball(0));
        }
        spots.roots = spots.spots.len() as u32;
        spots
    }

    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> ObstacleSpot {
        self.spots[index as usize]
    }

    /// The parts of a spot; none where there are too many already.
    #[inline(always)]
    pub(super) fn open_parts(&mut self, index: u32) -> Option<(u32, u32)> {
        let ObstacleSpot { parts, count, .. } = self.spots[index as usize];
        if parts != CLOSED {
            return Some((parts, parts + count));
        }
        if self.spots.len() > MOST_SPOTS {
            return None;
        }
        let Origin { what, solid, .. } = self.origins[index as usize];
        let from = self.spots.len() as u32;
        match what {
            SpotSource::Ball(node) => {
                let of = &self.solids[solid as usize];
                let node = of.nodes[node as usize];
                if node.leaf {
                    let corners = of.triangles[node.first as usize];
                    let (center, radius) = circle(&corners);
                    self.quarter(solid, &TrianglePiece { corners, center, radius });
                } else {
                    let two = [node.first, node.first + 1];
                    let ball = |i: usize| &of.nodes[two[i] as usize];
                    let centers = [ball(0).center, ball(1).center];
                    let seen = self.spots_of_balls(solid, &centers, &[ball(0).radius, ball(1).radius]);
                    for (i, spot) in seen.into_iter().enumerate() {
                        self.store_spot(solid, spot, SpotSource::Ball(two[i]));
                    }
                }
            }
            SpotSource::Piece(number) => {
                let piece = self.pieces[number as usize];
                self.quarter(solid, &piece);
            }
        }
        let to = self.spots.len() as u32;
        let spot = &mut self.spots[index as usize];
        (spot.parts, spot.count) = (from, to - from);
        Some((from, to))
    }

    /// The quarters of a triangle: three shrunk to a half towards its corners, and the one amid them, shrunk
    /// and turned by half a turn about the middle of the corners. The balls that hold them come from its ball
    /// in the same way.
    #[inline(always)]
    fn quarter(&mut self, solid: u32, piece: &TrianglePiece) {
        let TrianglePiece { corners: [a, b, c], center, radius } = piece;
        let radius = 0.5 * radius * (1.0 + BALL_ROUNDING) + BALL_ROUNDING;
        let amid = Point::from(0.5 * (a.coords + b.coords + c.coords - center.coords));
        let [by_a, by_b, by_c] = [a, b, c].map(|p| nalgebra::center(p, center));
        let centers = [by_a, by_b, by_c, amid];
        let seen = self.spots_of_balls(solid, &centers, &[radius; 4]);
        let [d, e, f] = [nalgebra::center(a, b), nalgebra::center(b, c), nalgebra::center(c, a)];
        let parts = [[*a, d, f], [d, *b, e], [f, e, *c], [d, e, f]];
        for (i, spot) in seen.into_iter().enumerate() {
            if spot.is_some() {
                self.store_spot(solid, spot, SpotSource::Piece(self.pieces.len() as u32));
                self.pieces.push(TrianglePiece { corners: parts[i], center: centers[i], radius });
            }
        }
    }

    /// What balls forbid, of those that forbid an axis that is looked at: the same operation for each, so
    /// that the compiler makes vector instructions of it.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the same step of several arrays at once")]
    fn spots_of_balls<const N: usize>(
        &self,
        solid: u32,
        centers: &[Point; N],
        radius: &[f64; N],
    ) -> [Option<ObstacleSpot>; N] {
        let extent = self.extent(solid);
        // Loops and no closures: these would be called one by one, without the instructions of this
        // processor.
        let (mut to, mut way) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        let (mut r, mut low, mut far) = ([0.0; N], [0.0; N], [0.0; N]);
        for k in 0..N {
            for i in 0..3 {
                to[i][k] = centers[k][i] - self.center[i];
            }
            r[k] = (to[0][k] * to[0][k] + to[1][k] * to[1][k] + to[2][k] * to[2][k]).sqrt();
            low[k] = positive(r[k] - radius[k]);
            far[k] = r[k] + radius[k];
        }
        let (mut cosine, mut is_met) = ([1.0; N], [false; N]);
        for k in 0..N {
            if let Some([_, high]) = extent.outer(low[k], far[k]) {
                (cosine[k], is_met[k]) = (high, true);
            }
        }
        let (mut size, mut wide, mut tilt, mut bound) = ([0.0; N], [[0.0; N]; 2], [0.0; N], [0.0; N]);
        for k in 0..N {
            size[k] = if r[k] > radius[k] { radius[k] / r[k] } else { 2.0 };
            for i in 0..3 {
                way[i][k] = if r[k] > 0.0 { to[i][k] / r[k] } else { self.normal[i] };
            }
            tilt[k] = way[0][k] * self.normal[0] + way[1][k] * self.normal[1] + way[2][k] * self.normal[2];
            let sine = positive(1.0 - cosine[k] * cosine[k]).sqrt();
            let half = positive(1.0 - size[k] * size[k]).sqrt();
            // The widest angle, and that of it and of the largest tilt.
            wide[0][k] = cosine[k] * half - sine * size[k];
            wide[1][k] = sine * half + cosine[k] * size[k];
            let [co, so] = self.limit;
            let all = [wide[0][k] * co - wide[1][k] * so, wide[1][k] * co + wide[0][k] * so];
            bound[k] = if is_below_half_turn(all) { all[0] } else { -2.0 };
        }
        let mut spots = [None; N];
        for k in 0..N {
            let wide = [wide[0][k], wide[1][k]];
            let is_known = size[k] < 1.0 && is_below_half_turn(wide);
            if is_met[k] && !(is_known && tilt[k] < bound[k]) {
                spots[k] = Some(ObstacleSpot {
                    way: [way[0][k] as f32, way[1][k] as f32, way[2][k] as f32],
                    high: if is_known { [wide[0] as f32, wide[1] as f32] } else { [-1.0, 0.0] },
                    size: size[k] as f32,
                    parts: CLOSED,
                    count: 0,
                });
            }
        }
        spots
    }

    #[inline(always)]
    fn store_spot(&mut self, solid: u32, spot: Option<ObstacleSpot>, what: SpotSource) {
        if let Some(spot) = spot {
            self.spots.push(spot);
            self.origins.push(Origin { solid, what, anchor: CLOSED });
        }
    }

    #[inline(always)]
    fn extent(&self, solid: u32) -> &'a Extent {
        &self.extents[usize::from(!self.solids[solid as usize].cut)]
    }

    fn ball(&self, solid: u32, what: SpotSource) -> (Point, f64) {
        match what {
            SpotSource::Ball(node) => {
                let node = &self.solids[solid as usize].nodes[node as usize];
                (node.center, node.radius)
            }
            SpotSource::Piece(number) => {
                let piece = &self.pieces[number as usize];
                (piece.center, piece.radius)
            }
        }
    }

    /// What is known of the anchor of a spot.
    pub(super) fn anchor(&mut self, index: u32) -> &Anchor {
        let Origin { solid, what, anchor } = self.origins[index as usize];
        if anchor != CLOSED {
            return &self.anchors[anchor as usize];
        }
        let extent = self.extent(solid);
        let (center, radius) = self.ball(solid, what);
        let place = match what {
            SpotSource::Ball(node) => self.solids[solid as usize].nodes[node as usize].anchor,
            SpotSource::Piece(number) => {
                let [a, b, c] = self.pieces[number as usize].corners;
                Point::from((a.coords + b.coords + c.coords) / 3.0)
            }
        };
        let r = (center - self.center).norm();
        let mut low = None;
        if r > radius
            && let Some([nearest, _]) = extent.outer(r - radius, r + radius)
        {
            let (seen, nearest) = (turn_of_sine(radius / r), of_cosine(nearest));
            low = (nearest[0] < seen[0])
                .then(|| [nearest[0] * seen[0] + nearest[1] * seen[1], nearest[1] * seen[0] - nearest[0] * seen[1]]);
        }
        let to = place - self.center;
        let r = to.norm();
        let turns = |a: [f64; 2]| a.map(|c| narrow(of_cosine(c)));
        self.origins[index as usize].anchor = self.anchors.len() as u32;
        self.anchors.push(Anchor {
            way: (if r > 0.0 { to / r } else { self.normal }).map(|x| x as f32).into(),
            reach: extent.outer(r, r).map(turns),
            inner: if r > 0.0 { extent.inner(r).map(turns) } else { None },
            low: low.map(narrow),
        });
        &self.anchors[self.anchors.len() - 1]
    }
}

/// The angle of a sine, up to a right angle.
fn turn_of_sine(sine: f64) -> Turn {
    [(1.0 - sine * sine).max(0.0).sqrt(), sine]
}

fn narrow(t: Turn) -> [f32; 2] {
    t.map(|x| x as f32)
}

/// A ball that holds a triangle: round its longest edge, or through its corners where it has no wide angle.
fn circle(corners: &[Point; 3]) -> (Point, f64) {
    let [a, b, c] = corners;
    let (u, v) = (b - a, c - a);
    let normal = u.cross(&v);
    let square = normal.norm_squared();
    let longest = [(a, b, c), (b, c, a), (c, a, b)]
        .into_iter()
        .max_by(|x, y| (x.1 - x.0).norm_squared().total_cmp(&(y.1 - y.0).norm_squared()));
    if let Some((p, q, other)) = longest {
        let middle = nalgebra::center(p, q);
        let radius = 0.5 * (q - p).norm();
        if (other - middle).norm() <= radius || square <= 0.0 {
            let radius = radius.max((other - middle).norm());
            return (middle, radius * (1.0 + BALL_ROUNDING) + BALL_ROUNDING);
        }
    }
    let center = a + (normal.cross(&u) * v.norm_squared() + v.cross(&normal) * u.norm_squared()) / (2.0 * square);
    let radius = corners.iter().map(|p| (p - center).norm()).fold(0.0, f64::max);
    (center, radius * (1.0 + BALL_ROUNDING) + BALL_ROUNDING)
}
