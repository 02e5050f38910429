//! Parts of a model and their paint.

use std::fmt::Write;

use crate::machine_models::solid::SolidMesh;

/// Surface of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Paint {
    /// Bed, columns, walls.
    Frame,
    /// Moving castings.
    Casting,
    /// Castings in the color of the machine.
    Accent([u8; 3]),
    /// Ground steel: tables, spindle noses.
    Steel,
    /// Guide rails and screws.
    Rail,
    /// Spindle housings, motors.
    Dark,
    /// Bellows and covers.
    Bellows,
}

impl Paint {
    fn color(self) -> [u8; 3] {
        match self {
            Self::Frame => [104, 112, 122],
            Self::Casting => [188, 193, 198],
            Self::Accent(color) => color,
            Self::Steel => [168, 174, 180],
            Self::Rail => [216, 220, 224],
            Self::Dark => [70, 76, 84],
            Self::Bellows => [46, 50, 56],
        }
    }
}

/// A body of the machine.
#[derive(Clone, Debug)]
pub(crate) struct MachinePart {
    /// Name of the body and of its node.
    pub(crate) name: String,
    /// What it is.
    pub(crate) role: &'static str,
    /// Joint that carries it, or base.
    pub(crate) on: String,
    /// Red, green, blue.
    pub(crate) color: [u8; 3],
    /// Metal that shines.
    pub(crate) bright: bool,
    /// False for what is only drawn, since no joint moves it as one rigid body.
    pub(crate) check: bool,
    /// Shape in machine coordinates with all joints at zero.
    pub(crate) solid: SolidMesh,
}

impl MachinePart {
    /// A part that is checked for collisions.
    pub(crate) fn new(name: &str, role: &'static str, on: &str, paint: Paint, solid: SolidMesh) -> Self {
        let bright = matches!(paint, Paint::Steel | Paint::Rail);
        Self { name: name.into(), role, on: on.into(), color: paint.color(), bright, check: true, solid }
    }

    /// A part that is only drawn: the legs of a platform, which turn with three joints, drawn in their
    /// middle position. Everything else is checked, guides, covers and motors too: a gate that leaves
    /// bodies out does not pass.
    pub(crate) fn drawn(name: &str, role: &'static str, on: &str, paint: Paint, solid: SolidMesh) -> Self {
        Self { check: false, ..Self::new(name, role, on, paint, solid) }
    }
}

/// The `[[body]]` tables of all parts.
pub(crate) fn body_tables(parts: &[MachinePart]) -> String {
    let mut text = String::new();
    for MachinePart { name, role, on, color: [r, g, b], check, .. } in parts {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[[body]]\nname = \"{name}\"\nrole = \"{role}\"\nattached_to = \"{on}\"\ncolor = [{r}, {g}, {b}]\n\
             check = {check}\nnode = \"{name}\"\n"
        );
    }
    text
}
