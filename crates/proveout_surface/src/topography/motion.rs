//! Motion of a turning cutter: short pieces with times.

use proveout_geom::{Point, Vector};

use super::LARGEST;

/// Duration of a piece at least, s: one that stands has none.
const SHORTEST_S: f64 = 1e-12;
/// A smaller angle is no turn, radian.
const NO_TURN: f64 = 1e-12;

/// A piece of the motion of a cutter in the frame of the design (W): the tip runs straight and evenly, the
/// housing of the spindle turns evenly about one direction, the cutter turns evenly in the housing.
///
/// The housing frame has its z axis along the tool, from tip to holder; x is fixed to the housing of the
/// spindle. Azimuths are right-handed about z, from x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutterPiece {
    /// Begin and end, s.
    pub time: [f64; 2],
    /// Tip at both ends, mm.
    pub tip: [Point; 2],
    /// x, y, z of the housing at the begin, unit vectors.
    pub housing: [Vector; 3],
    /// Rotation of the housing over the piece: unit direction times angle, radian.
    pub turn: Vector,
    /// Azimuth of the cutter in the housing at the begin, radian; continuous from piece to piece.
    pub azimuth: f64,
    /// Its rate, rad/s: negative for M3, zero for a stopped spindle.
    pub azimuth_rate: f64,
    /// The motion this piece belongs to, as the caller counts them.
    pub motion: u32,
}

impl CutterPiece {
    /// Whether all numbers are finite and of a size that a machine has, and time passes where there is a way.
    /// Other pieces leave nothing.
    pub fn is_finite(&self) -> bool {
        // Revolutions of a piece of ten hours at 16 000 1/min.
        const TURNS: f64 = 1e7;
        let tips = self.tip.iter().flat_map(|p| p.iter());
        let vectors = self.housing.iter().flat_map(|v| v.iter()).chain(self.turn.iter());
        let duration = self.time[1] - self.time[0];
        let still = self.tip[0] == self.tip[1] && self.turn == Vector::zeros();
        tips.chain(vectors).chain(&[self.time[0], self.time[1], self.azimuth_rate]).all(|v| v.abs() < LARGEST)
            && self.azimuth.is_finite()
            && (self.azimuth_rate * duration).abs() < TURNS * std::f64::consts::TAU
            && (duration > 0.0 || (duration == 0.0 && still))
    }
}

/// Position and rates of a piece at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutterState {
    /// Tip.
    pub tip: Vector,
    /// Housing.
    pub frame: [Vector; 3],
    /// Azimuth of the cutter.
    pub azimuth: f64,
}

/// A piece made ready for evaluation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptPiece {
    pub time: [f64; 2],
    tip: Vector,
    /// mm/s.
    velocity: Vector,
    frame: [Vector; 3],
    /// Velocity and turn in the coordinates of the housing; the second is the same at all times, since the
    /// turn has one axis.
    velocity_in_housing: Option<Vector>,
    pub spin: Vector,
    turn: Option<Turn>,
    azimuth: f64,
    pub azimuth_rate: f64,
    pub motion: u32,
}

/// A turn about one axis: a vector is its part along the axis, which stays, and one across it, which turns
/// (Rodrigues 1840).
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// Unit direction, and rate in rad/s.
    axis: Vector,
    rate: f64,
    /// Of each axis of the frame at the begin.
    along: [Vector; 3],
    across: [Vector; 3],
    ahead: [Vector; 3],
}

impl Turn {
    fn new(axis: Vector, rate: f64, frame: &[Vector; 3]) -> Self {
        let along = frame.map(|v| axis * axis.dot(&v));
        let across = [0, 1, 2].map(|k| frame[k] - along[k]);
        Self { axis, rate, along, across, ahead: frame.map(|v| axis.cross(&v)) }
    }

    #[inline]
    fn frame(&self, time: f64) -> [Vector; 3] {
        let (sin, cos) = sin_cos_of_small(self.rate * time);
        [0, 1, 2].map(|k| self.along[k] + self.across[k] * cos + self.ahead[k] * sin)
    }
}

/// Sine and cosine; by their series where the first terms left out are below rounding (0.1^13 / 13! = 2e-23).
#[inline]
fn sin_cos_of_small(x: f64) -> (f64, f64) {
    if x.abs() > 0.1 {
        return x.sin_cos();
    }
    let y = x * x;
    let sin = x * (1.0 - y / 6.0 * (1.0 - y / 20.0 * (1.0 - y / 42.0 * (1.0 - y / 72.0 * (1.0 - y / 110.0)))));
    let cos = 1.0 - y / 2.0 * (1.0 - y / 12.0 * (1.0 - y / 30.0 * (1.0 - y / 56.0 * (1.0 - y / 90.0))));
    (sin, cos)
}

impl SweptPiece {
    pub(crate) fn new(p: &CutterPiece) -> Self {
        let duration = (p.time[1] - p.time[0]).max(SHORTEST_S);
        let velocity = (p.tip[1] - p.tip[0]) / duration;
        let angle = p.turn.norm();
        let turn = (angle > NO_TURN).then(|| Turn::new(p.turn / angle, angle / duration, &p.housing));
        let in_housing = |v: &Vector| Vector::new(p.housing[0].dot(v), p.housing[1].dot(v), p.housing[2].dot(v));
        Self {
            time: p.time,
            tip: p.tip[0].coords,
            velocity,
            frame: p.housing,
            velocity_in_housing: turn.is_none().then(|| in_housing(&velocity)),
            spin: turn.map_or_else(Vector::zeros, |t| in_housing(&t.axis) * t.rate),
            turn,
            azimuth: p.azimuth,
            azimuth_rate: p.azimuth_rate,
            motion: p.motion,
        }
    }

    pub(crate) fn duration(&self) -> f64 {
        self.time[1] - self.time[0]
    }

    /// The same motion in parts, so that none turns far along its way: what follows for a whole piece from
    /// one of its times (a tangent plane, one lowest place) is then sharp.
    pub(crate) fn parts(self) -> impl Iterator<Item = Self> {
        // Radian; and radian times millimeter, twice the height by which a plane that turns with the piece
        // tilts at its ends.
        const ANGLE: f64 = 0.02;
        const TILT: f64 = 0.01;
        let angle = self.angle();
        let count = (angle / ANGLE).max((angle * self.travel() / TILT).sqrt()).ceil().clamp(1.0, 10_000.0) as usize;
        let step = self.duration() / count as f64;
        (0..count).map(move |k| {
            if count == 1 {
                return self;
            }
            let at = |k: usize| if k == count { self.time[1] } else { self.time[0] + step * k as f64 };
            let state = self.state(at(k));
            let in_housing = |v: &Vector| state.direction(v);
            Self {
                time: [at(k), at(k + 1)],
                tip: state.tip,
                frame: state.frame,
                velocity_in_housing: self.velocity_in_housing,
                spin: self.turn.map_or_else(Vector::zeros, |t| in_housing(&t.axis) * t.rate),
                turn: self.turn.map(|t| Turn::new(t.axis, t.rate, &state.frame)),
                azimuth: state.azimuth,
                ..self
            }
        })
    }

    /// Largest angle that the housing turns, radian.
    pub(crate) fn angle(&self) -> f64 {
        self.turn.map_or(0.0, |t| t.rate * self.duration())
    }

    /// Whether the housing turns.
    pub(crate) fn turns(&self) -> bool {
        self.turn.is_some()
    }

    /// Of the tip, mm/s.
    pub(crate) fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    /// Way of the tip, mm.
    pub(crate) fn travel(&self) -> f64 {
        self.velocity.norm() * self.duration()
    }

    #[inline]
    pub(crate) fn state(&self, time: f64) -> CutterState {
        let t = time - self.time[0];
        let frame = self.turn.as_ref().map_or(self.frame, |turn| turn.frame(t));
        CutterState { tip: self.tip + self.velocity * t, frame, azimuth: self.azimuth + self.azimuth_rate * t }
    }

    /// Rate of a point fixed in W, in the coordinates of the housing: - v - spin x q.
    #[inline]
    pub(crate) fn rate(&self, state: &CutterState, q: &Vector) -> Vector {
        match self.velocity_in_housing {
            Some(v) => -v,
            None => {
                let v = Vector::new(
                    state.frame[0].dot(&self.velocity),
                    state.frame[1].dot(&self.velocity),
                    state.frame[2].dot(&self.velocity),
                );
                -v - self.spin.cross(q)
            }
        }
    }
}

impl CutterState {
    /// A point of W in the coordinates of the housing.
    #[inline]
    pub(crate) fn point(&self, p: &Vector) -> Vector {
        self.direction(&(p - self.tip))
    }

    /// A direction of W in the coordinates of the housing.
    #[inline]
    pub(crate) fn direction(&self, v: &Vector) -> Vector {
        Vector::new(self.frame[0].dot(v), self.frame[1].dot(v), self.frame[2].dot(v))
    }
}
