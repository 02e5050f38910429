//! Where a part goes that has come off, as far as two assumptions about its contacts agree.
//!
//! The part starts at rest in its place when the piece of motion ends that cut it off, and is followed twice:
//! slippery and bouncing, and rough and dead. Only where both come to the same end is it decided.
//!
//! - **rests**: no corner has moved by [`STAYS_MM`] or half a cell, and small pushes along all axes of the
//!   table do not move it either
//! - **lies**: it comes to rest elsewhere, both times within [`AGREES_MM`]; what comes near to that place is
//!   reported
//! - **left**: it is lower than everything that the table carries
//! - **not decided**: anything else, with the reason
//!
//! *Rest under pushes.* Loads that contacts with friction can answer form a convex cone. Where the
//! part stays under gravity and a push of p along each of +-x, +-y and +-z, contacts therefore
//! answer every load in the octahedron |f - g|_1 <= p between them. Accelerations of the table and
//! its tilt later in the program are compared with that limit.

use proveout_geom::{Aabb, Point, Pose, Vector};

use super::{
    course::{Course, placed},
    rapier_world::World,
    world::{Body, Contact, STEP, Standing, Touch},
};

/// Standard gravity, mm/s² (third General Conference on Weights and Measures, 1901).
pub(crate) const STANDARD_GRAVITY: f64 = 9806.65;

/// Oiled and bouncing; dry and dead. Steel on steel is between 0.1 and 0.5 in handbooks, and a hit at these
/// speeds gives back less than a third of its speed.
const ASSUMED: [Touch; 2] = [Touch { friction: 0.1, restitution: 0.3 }, Touch { friction: 0.5, restitution: 0.0 }];
/// A part that moves by less stays, mm; half a cell where that is more.
const STAYS_MM: f64 = 0.1;
/// Two places nearer to each other are one, mm: the room that is kept round it.
pub(super) const AGREES_MM: f64 = 1.0;
/// A part rests when no corner has moved by `RESTS_MM` within `RESTS_S`.
const RESTS_MM: f64 = 0.02;
const RESTS_S: f64 = 0.2;
/// Longest fall that is followed, s.
const LONGEST_S: f64 = 3.0;
/// Deepest penetration of the solver beyond the error of the shape, mm: more means that it does not know
/// where the part is.
const DEEPEST_MM: f64 = 0.3;
/// The same on the way: a hit is seen a step late, and what is then too deep comes out within some steps.
const DEEPEST_ON_WAY_MM: f64 = 1.0;
/// Slower contacts are no hits, mm/s: a part that settles by a tenth of a millimeter has this speed.
const HIT_MM_S: f64 = 50.0;
/// Pushes that a part that rests is tried with, mm/s²: 2 percent of gravity up to twice of it.
const PUSHES: [f64; 3] = [200.0, 2000.0, 20_000.0];
/// Time of a push, s: one that is not answered moves the part by millimeters.
const PUSH_S: f64 = 0.15;
/// Steps between two looks at all corners.
const LOOK: u64 = 10;
/// Poses that are kept for pictures, s.
const SHOWN_S: f64 = 0.01;

/// A part and all that it may meet, in K.
pub(super) struct Fall {
    pub(super) body: Body,
    /// Error of its shape and of the surfaces round it, mm.
    pub(super) error: f64,
    pub(super) standing: Vec<Standing>,
    /// Convex bodies of the tool in T, smaller by the error.
    pub(super) tool: Vec<Vec<Point>>,
    /// A point of the table's face and its normal.
    pub(super) table: (Point, Vector),
    /// When it begins, s.
    pub(super) start: f64,
    /// What the part feels while the machine is at rest, mm/s².
    pub(super) gravity: Vector,
}

/// What the part hit on its way.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Struck {
    /// Name of the body.
    pub(crate) body: String,
    /// Place in K.
    pub(crate) point: Point,
    /// Speed along the normal, mm/s.
    pub(crate) speed: f64,
    /// When, s.
    pub(crate) time: f64,
}

/// Where a part went.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum End {
    /// It stays, and answers pushes up to this acceleration, mm/s².
    Rests { push: f64 },
    /// It lies within this box in K.
    Lies { within: Aabb },
    /// It has left.
    Left,
    /// It is not known, and why.
    Unknown(String),
    /// The motion of the machine is not known for long enough.
    Unfinished,
}

/// A decision with what was seen on the way.
#[derive(Clone, Debug)]
pub(crate) struct Decision {
    pub(crate) end: End,
    /// The fastest hit of each body, over both assumptions.
    pub(crate) struck: Vec<Struck>,
    /// Motion of the part since it was found, in K, of the first assumption: time, s, and pose.
    pub(crate) track: Vec<(f64, Pose)>,
}

/// How one simulation ended.
enum Ran {
    Stayed,
    Lies(Pose),
    Left,
    Unknown(String),
    Unfinished,
}

struct Way {
    ran: Ran,
    struck: Vec<Struck>,
    track: Vec<(f64, Pose)>,
}

impl Fall {
    /// Follows the part. `last`: the machine stops where the course ends; otherwise a fall that
    /// lasts longer is unfinished.
    pub(super) fn decide(&self, course: &Course, last: bool) -> Decision {
        let [mut first, second] = ASSUMED.map(|touch| self.follow(touch, course, last));
        for s in second.struck {
            note(&mut first.struck, s);
        }
        first.struck.sort_by(|a, b| a.time.total_cmp(&b.time).then_with(|| a.body.cmp(&b.body)));
        let [low, high] = ASSUMED.map(|t| t.friction);
        let end = match (first.ran, second.ran) {
            (Ran::Unfinished, _) | (_, Ran::Unfinished) => End::Unfinished,
            (Ran::Unknown(why), _) | (_, Ran::Unknown(why)) => End::Unknown(why),
            (Ran::Stayed, Ran::Stayed) => self.pushed(),
            (Ran::Left, Ran::Left) => End::Left,
            (Ran::Lies(one), Ran::Lies(other)) => self.lies(&one, &other),
            (one, other) => {
                End::Unknown(format!("with a friction of {low} it {}, with {high} it {}", one.words(), other.words()))
            }
        };
        Decision { end, struck: first.struck, track: first.track }
    }

    fn corners(&self) -> impl Iterator<Item = &Point> {
        self.body.pieces.iter().flatten()
    }

    /// Farthest way of a corner between two motions of the part.
    fn way(&self, one: &Pose, other: &Pose) -> f64 {
        self.corners().map(|p| (one.point(p) - other.point(p)).norm()).fold(0.0, f64::max)
    }

    fn stays(&self) -> f64 {
        STAYS_MM.max(self.error)
    }

    fn lies(&self, one: &Pose, other: &Pose) -> End {
        let apart = self.way(one, other);
        if apart > AGREES_MM {
            let [low, high] = ASSUMED.map(|t| t.friction);
            return End::Unknown(format!(
                "with frictions of {low} and {high} it comes to rest at places that are more than {AGREES_MM} mm apart"
            ));
        }
        let points: Vec<Point> = [one, other].iter().flat_map(|pose| self.corners().map(|p| pose.point(p))).collect();
        End::Lies { within: Aabb::of_points(&points).expanded(AGREES_MM + self.error) }
    }

    /// How far down everything reaches that the table carries.
    fn lowest(&self, down: &Vector) -> f64 {
        let carried = self.standing.iter().filter(|s| s.on_table).flat_map(|s| &s.mesh.positions);
        carried.map(|p| down.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The part is lower than everything that the table carries, or than the face of the table.
    fn has_left(&self, moved: &Pose, down: &Vector, lowest: f64) -> bool {
        let (face, normal) = &self.table;
        let below = self.corners().all(|p| (moved.point(p) - face).dot(normal) < -self.stays());
        let highest = self.corners().map(|p| down.dot(&moved.point(p).coords)).fold(f64::INFINITY, f64::min);
        below || highest > lowest
    }

    fn world(&self, touch: Touch, tool: Option<&Pose>) -> Option<World> {
        let tool = tool.filter(|_| !self.tool.is_empty()).map(|pose| (&self.tool[..], pose));
        World::new(&self.body, &self.standing, tool, touch)
    }

    fn follow(&self, touch: Touch, course: &Course, last: bool) -> Way {
        let mut way = Way { ran: Ran::Unfinished, struck: Vec::new(), track: vec![(self.start, Pose::identity())] };
        way.ran = self.run(touch, course, last, &mut way.struck, &mut way.track);
        way
    }

    fn run(
        &self,
        touch: Touch,
        course: &Course,
        last: bool,
        struck: &mut Vec<Struck>,
        track: &mut Vec<(f64, Pose)>,
    ) -> Ran {
        let tool = |time: f64| course.tool(time).map(|t| placed(&t));
        let Some(mut world) = self.world(touch, tool(self.start).as_ref()) else {
            return Ran::Unknown("its shape or that of a neighboring body is not a closed solid".into());
        };
        let down = self.gravity / STANDARD_GRAVITY;
        let lowest = self.lowest(&down);
        let every = (RESTS_S / STEP) as u64;
        let mut before = Pose::identity();
        for k in 1..=(LONGEST_S / STEP) as u64 {
            let time = self.start + k as f64 * STEP;
            if time > course.end() && !last {
                return Ran::Unfinished;
            }
            let now = course.at(time, self.gravity);
            let contacts = world.step(&now.acceleration, tool(time).as_ref());
            let moved = world.moved();
            if !moved.is_finite() {
                return Ran::Unknown("the simulation of its fall breaks down".into());
            }
            let traveled = || self.way(&Pose::identity(), &moved);
            if now.turns && traveled() > self.stays() {
                return Ran::Unknown("the table turns while it falls".into());
            }
            if let Some(lost) = self.too_deep(&contacts, DEEPEST_ON_WAY_MM) {
                return lost;
            }
            for c in contacts.iter().filter(|c| c.approach > HIT_MM_S) {
                note(struck, Struck { body: self.name(c).to_owned(), point: c.point, speed: c.approach, time });
                if c.with.is_none() {
                    return Ran::Unknown("the tool hits it".into());
                }
            }
            if time - track[track.len() - 1].0 > SHOWN_S - 0.5 * STEP {
                track.push((time, moved));
            }
            if k % LOOK == 0 && self.has_left(&moved, &down, lowest) {
                return Ran::Left;
            }
            if k % every == 0 {
                if self.way(&before, &moved) < RESTS_MM {
                    track.push((time, moved));
                    return self.rest(&moved, traveled(), &contacts);
                }
                before = moved;
            }
        }
        Ran::Unknown(format!("it still moves after {LONGEST_S} s"))
    }

    /// The part has come to rest.
    fn rest(&self, moved: &Pose, traveled: f64, contacts: &[Contact]) -> Ran {
        let bearing = || contacts.iter().filter(|c| c.bears);
        if let Some(lost) = self.too_deep(contacts, DEEPEST_MM) {
            return lost;
        }
        if traveled < self.stays() {
            return Ran::Stayed;
        }
        if bearing().any(|c| c.with.is_none()) {
            return Ran::Unknown("it leans on the tool".into());
        }
        let off_table = |c: &Contact| c.with.is_some_and(|k| !self.standing[k].on_table);
        if let Some(c) = bearing().find(|c| off_table(c)) {
            let name = self.name(c);
            return Ran::Unknown(format!("it comes to rest on {name}, which does not move with the table"));
        }
        Ran::Lies(*moved)
    }

    /// The solver has lost the place of the part at a body.
    fn too_deep(&self, contacts: &[Contact], limit: f64) -> Option<Ran> {
        let deep = contacts.iter().find(|c| c.depth > limit + self.error)?;
        let name = self.name(deep);
        Some(Ran::Unknown(format!("its place is not known to better than {limit} mm next to {name}")))
    }

    fn name(&self, contact: &Contact) -> &str {
        contact.with.and_then(|k| self.standing.get(k)).map_or("the tool", |s| &s.name)
    }

    /// The part stays by itself: up to which push it does so in all directions.
    fn pushed(&self) -> End {
        let mut held = None;
        for push in PUSHES {
            let stays = (0..6).all(|k| {
                let mut along = Vector::zeros();
                along[k / 2] = if k % 2 == 0 { push } else { -push };
                ASSUMED.iter().all(|touch| self.stays_under(*touch, &(self.gravity + along)))
            });
            if !stays {
                break;
            }
            held = Some(push);
        }
        held.map_or_else(|| End::Unknown(format!("a push of {} mm/s2 moves it", PUSHES[0])), |push| End::Rests { push })
    }

    fn stays_under(&self, touch: Touch, load: &Vector) -> bool {
        let Some(mut world) = self.world(touch, None) else { return false };
        for k in 1..=(PUSH_S / STEP) as u64 {
            world.step(load, None);
            let moved = world.moved();
            // The last step is one of those that are looked at.
            if k % LOOK == 0 && !(moved.is_finite() && self.way(&Pose::identity(), &moved) < self.stays()) {
                return false;
            }
        }
        true
    }
}

impl Ran {
    fn words(&self) -> &'static str {
        match self {
            Self::Stayed => "stays where it is",
            Self::Lies(_) => "comes to rest elsewhere",
            Self::Left => "falls away",
            Self::Unknown(_) | Self::Unfinished => "goes to an unknown place",
        }
    }
}

/// Keeps the fastest hit of each body.
fn note(struck: &mut Vec<Struck>, new: Struck) {
    match struck.iter_mut().find(|s| s.body == new.body) {
        Some(old) if old.speed >= new.speed => {}
        Some(old) => *old = new,
        None => struck.push(new),
    }
}
