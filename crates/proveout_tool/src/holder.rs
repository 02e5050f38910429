//! The same tool clamped further out of its holder, or less far.
//!
//! ```text
//!      |  holder  |              |  holder  |   ^ by
//!       \________/                \________/    |
//!          |  |  . . . . . . . . .   |  |  . . .
//!          |  |  cylinder that       |  |
//!          |  |  the holder grips    |  |
//!           \/   flutes               \/
//! ```
//!
//! The holder and the gauge line move along the axis; the cylinder that ends at the holder's nose becomes
//! longer or shorter. Everything below it stays.

use crate::{Body, Profile, Role, Segment, Tool};

/// Heights closer than this are one, mm.
const JOIN_MM: f64 = 1e-6;

/// One section of a holder: a cylinder or a cone, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolderSection {
    /// Diameter at its end nearer to the tip.
    pub diameter: f64,
    /// Diameter at its end nearer to the spindle.
    pub top_diameter: f64,
    /// Length along the axis.
    pub length: f64,
}

impl Tool {
    /// Current projection from the holder: tip to holder nose, mm; none without a holder.
    pub fn overhang(&self) -> Option<f64> {
        let holder = self.bodies.iter().filter(|b| b.role == Role::Holder);
        holder.map(|b| b.profile.z_min()).reduce(f64::min)
    }

    /// Least and largest overhang that can be clamped, mm: the holder grips the cylinder that ends at its
    /// nose, and does not leave the end of the tool, where the library knows its length (else infinity). None
    /// without a holder, or where what ends at its nose is no cylinder.
    pub fn clamping_range(&self) -> Option<[f64; 2]> {
        let nose = self.overhang()?;
        let gripped = self.gripped(nose)?;
        let below = |b: &&Body| b.role != Role::Holder && b.profile.z_max() < nose - JOIN_MM;
        let foot = self.bodies.iter().filter(below).map(|b| b.profile.z_max()).fold(gripped, f64::max);
        Some([foot, self.overall_length.unwrap_or(f64::INFINITY)])
    }

    /// The same tool with an overhang that is larger by `by` mm (smaller where negative). None where
    /// [`Self::clamping_range`] does not allow it.
    pub fn clamped_out_by(&self, by: f64) -> Option<Self> {
        let nose = self.overhang()?;
        let [least, most] = self.clamping_range()?;
        let to = nose + by;
        if !(to > least + JOIN_MM && to <= most + JOIN_MM) {
            return None;
        }
        let moved = |body: &Body| {
            let from_z = match body.role {
                Role::Holder => f64::NEG_INFINITY,
                _ => nose - JOIN_MM,
            };
            let point = |p: [f64; 2]| if p[1] >= from_z { [p[0], p[1] + by] } else { p };
            let segments = body.profile.segments().iter().map(|s| match *s {
                Segment::Line { from, to } => Segment::Line { from: point(from), to: point(to) },
                Segment::Arc { center, radius, from, to } => {
                    Segment::Arc { center: point(center), radius, from: point(from), to: point(to) }
                }
            });
            Some(Body { role: body.role, profile: Profile::new(segments.collect()).ok()? })
        };
        let bodies = self.bodies.iter().map(moved).collect::<Option<Vec<Body>>>()?;
        Some(Self { bodies, gauge_length: self.gauge_length + by, ..self.clone() })
    }

    /// Height of the foot of the cylinder that ends at the holder's nose.
    fn gripped(&self, nose: f64) -> Option<f64> {
        let ends_there = |b: &&Body| b.role != Role::Holder && (b.profile.z_max() - nose).abs() <= JOIN_MM;
        let body = self.bodies.iter().find(ends_there)?;
        let side =
            body.profile.segments().iter().find(|s| s.from()[1] < nose - JOIN_MM && s.to()[1] >= nose - JOIN_MM)?;
        match *side {
            Segment::Line { from, to } if (from[0] - to[0]).abs() <= JOIN_MM => Some(from[1]),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Cutter, HolderSection, ToolBuilder};

    fn builder(gauge: f64) -> ToolBuilder {
        let cutter = Cutter::ball(8.0).expect("ball");
        let section = HolderSection { diameter: 20.0, top_diameter: 30.0, length: 40.0 };
        ToolBuilder::new(1, "B8", cutter, 12.0, gauge).transition(5.0).shank(10.0).holder([section])
    }

    #[test]
    fn a_tool_clamped_further_out_is_the_one_built_so() {
        let tool = builder(90.0).build().expect("tool");
        assert_eq!(tool.overhang(), Some(50.0));
        // Flutes 12, cone 5: the shank begins at 17.
        assert_eq!(tool.clamping_range(), Some([17.0, f64::INFINITY]));
        for by in [-32.0, -7.5, 0.0, 0.3, 40.0] {
            let built = builder(90.0 + by).build().expect("tool");
            let moved = tool.clamped_out_by(by).expect("in range");
            assert_eq!(moved.bodies.len(), built.bodies.len());
            for (a, b) in moved.bodies.iter().zip(&built.bodies) {
                assert_eq!(a.role, b.role);
                for (s, t) in a.profile.segments().iter().zip(b.profile.segments()) {
                    let near = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).abs() < 1e-9 && (p[1] - q[1]).abs() < 1e-9;
                    assert!(near(s.from(), t.from()) && near(s.to(), t.to()), "{by}: {s:?} {t:?}");
                }
            }
            assert!((moved.gauge_length - built.gauge_length).abs() < 1e-9);
        }
    }

    #[test]
    fn ends_of_the_range_are_kept() {
        let tool = builder(90.0).overall_length(70.0).build().expect("tool");
        assert_eq!(tool.clamping_range(), Some([17.0, 70.0]));
        assert!(tool.clamped_out_by(20.0).is_some());
        assert!(tool.clamped_out_by(20.1).is_none());
        assert!(tool.clamped_out_by(-33.0).is_none());
        assert!(tool.clamped_out_by(f64::NAN).is_none());
        let bare = ToolBuilder::new(1, "B8", Cutter::ball(8.0).expect("ball"), 12.0, 90.0).build().expect("tool");
        assert!(bare.overhang().is_none() && bare.clamped_out_by(1.0).is_none());
    }
}
