use crate::{CuttingEdges, Profile, Residual, Segment, Thread};

/// An end that rises by less of its radius is flat: rounding.
const FLAT: f64 = 1e-9;

/// What a part of the assembly may do to the stock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Role {
    /// Flutes: removes material.
    Cutting,
    /// Between flutes and shank, or above the flute length on the cutter's diameter: must not touch.
    Neck,
    /// Must not touch.
    Shank,
    /// Must not touch.
    Holder,
}

/// One convex body of revolution of an assembly, in frame T.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What it may do.
    pub role: Role,
    /// Its generating curve, z from the programmed tip.
    pub profile: Profile,
}

/// How a program names a tool.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ToolId {
    /// `T5`.
    Number(u32),
    /// `T="END_D12"`.
    Name(String),
}

/// A tool assembly as it hangs in the spindle.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Place in the magazine or tool table.
    pub number: u32,
    /// Name in the program.
    pub name: String,
    /// Words for people.
    pub description: String,
    /// The parts, from the tip upward.
    pub bodies: Vec<Body>,
    /// From the programmed tip to the gauge line of the spindle, mm.
    pub gauge_length: f64,
    /// Length of the flutes from the tip, mm.
    pub flute_length: f64,
    /// Length of the cutting tool without holder, mm, where known.
    pub overall_length: Option<f64>,
    /// Number of flutes, where known.
    pub flutes: Option<u32>,
    /// Whether the cutting edges reach the center, so that it may plunge, where known.
    pub center_cutting: Option<bool>,
    /// Radius of the region round the axis that no edge sweeps, of a tool without edges at its center, mm,
    /// where known.
    pub dead_center: Option<f64>,
    /// Steepest way into material of a tool without edges at its center, radian against the plane across its
    /// axis, where known.
    pub max_ramp_angle: Option<f64>,
    /// Highest spindle speed, 1/min, where known.
    pub max_speed_rpm: Option<f64>,
    /// True for a tool that cuts when the spindle turns counter-clockwise (M4).
    pub left_handed: bool,
    /// False when the library gives no holder: holder checks are then unchecked.
    pub has_holder: bool,
    /// Edges of the teeth, where they are described.
    pub edges: Option<CuttingEdges>,
    /// A tap: its cutting body is the cylinder round its teeth.
    pub is_tap: bool,
    /// A thread mill: its cutting body is the cylinder around its teeth.
    pub is_thread_mill: bool,
    /// The thread that a tap cuts, where its pitch is known.
    pub thread: Option<Thread>,
    /// A touch probe: radius of the ball of its stylus, mm. None of its bodies cuts.
    pub stylus: Option<f64>,
    /// What it adds to the roughness of its motion, where that is known.
    pub residual: Option<Residual>,
}

impl Tool {
    /// The parts that remove material.
    pub fn cutting(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter().filter(|b| b.role == Role::Cutting)
    }

    /// The parts that must not touch anything.
    pub fn not_cutting(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter().filter(|b| b.role != Role::Cutting)
    }

    /// Whether the edges reach the center of its end, so that it may go straight down: as the library states
    /// it. Where it states nothing, the edges of an end that rises from the axis (ball, cone, flat arc) meet
    /// there; of a flat end it is not known.
    pub fn cuts_at_center(&self) -> Option<bool> {
        self.center_cutting.or_else(|| {
            let end = self.cutting().next()?.profile.segments().first()?;
            let flat = matches!(end, Segment::Line { from, to } if to[1] - from[1] <= FLAT * to[0]);
            (!flat).then_some(true)
        })
    }

    /// Largest distance of any part from the axis, mm.
    pub fn max_radius(&self) -> f64 {
        self.bodies.iter().map(|b| b.profile.max_radius()).fold(0.0, f64::max)
    }
}
