//! A first machine file from a URDF description: what the URDF states, the rest assumed and marked.
//!
//! A URDF (ROS, `robot` of XML) is a tree of links connected by joints: where each joint is (`origin`,
//! meter and radian, roll, pitch and yaw about fixed axes), how it moves (`axis`, `limit`), what the links
//! look like. It does not say which link carries the tool and which the workpiece, what a control calls the
//! axes, or how fast they accelerate:
//!
//! ```text
//!   root ── ... ── base ──┬─ joints of the table ── table link
//!                         └─ joints of the tool ─── tool link
//!
//!   M     frame of the root, all joints at zero, in mm
//!   base  the last link that both ways have in common
//! ```
//!
//! The caller names the two links. The axes lie between them. Each is given by its line in M with all
//! joints at zero, which includes the fixed joints. A joint of the file moves what it carries by +value
//! along its axis. On the side of the table the machine file follows ISO 841: the direction is the one in
//! which the *tool* moves relative to the workpiece, and the sense is -1.
//!
//! Links become bodies of the joint that carries them: boxes along the axes and cylinders as such, all else
//! as a mesh of `model.glb`.

mod axes;
mod bodies;
mod glb;
mod link_tree;
mod meshes;
mod named_links;
mod read;
mod source;
mod write;
mod xml;

use std::path::Path;

use proveout_input::{InputError, read_input};

use self::{link_tree::LinkTree, source::UrdfSource};
use crate::{ImportedMachine, Machine};

/// What a URDF file does not say about a machine, in the words of the caller; `None` where the caller says
/// nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UrdfOptions {
    /// Link that carries the tool: its origin is the middle of the gauge line.
    pub tool_link: Option<String>,
    /// Link that carries the workpiece: its origin is the middle of the clamping surface.
    pub table_link: Option<String>,
    /// Letters of joints: `joint_1=X,joint_2=C`.
    pub axis_names: Option<String>,
    /// Letters of the axes that a control counts against the joint of the file: `X,C`.
    pub reverse: Option<String>,
    /// Axis of the tool link that points from the tool into the spindle: `z`, `-z`, `x`, ... (`z`).
    pub tool_direction: Option<String>,
    /// Axis of the table link that points out of the clamping surface (`z`).
    pub table_normal: Option<String>,
}

/// Reads a URDF file.
///
/// # Errors
/// [`InputError`] with the line: no XML, no robot, a tree that is none, a joint that no machine of the twin
/// can have, a link or a letter that is missing, a mesh that is not there.
pub fn import_urdf(file: &Path, options: &UrdfOptions) -> Result<ImportedMachine, InputError> {
    let text = read_input(file)?;
    let source = UrdfSource { file, text: &text };
    let robot = read::robot(&source)?;
    let tree = LinkTree::new(&source, &robot)?;
    let ends = named_links::ends(&source, &robot, &tree, options)?;
    let axes = axes::axes(&source, &robot, &tree, &ends, options)?;
    let mut notes = axes.notes.clone();
    let kinematics = write::kinematics(&source, &robot, &tree, &ends, &axes, &mut notes)?;
    let whole = |bodies: &write::Sections<'_>| write::machine(&source, &robot, &kinematics, bodies);
    // The axes alone first, so that errors about them name the URDF file.
    let machine = Machine::from_text(Path::new("machine.toml"), &whole(&write::Sections::default()))
        .map_err(|e| axes.no_machine(&source, &robot, &e))?;
    axes.warn_reversed_axes(&machine, &mut notes);
    let bodies = bodies::bodies(&source, &robot, &tree, &axes, &mut notes)?;
    if bodies.text.is_empty() {
        notes.push(
            "no link has a supported shape: nothing is checked against the machine until bodies are drawn \
                    (machines/README.md)"
                .into(),
        );
    }
    let text = whole(&write::Sections { bodies: &bodies.text, has_model: bodies.model.is_some() });
    robot.note_left_out(&mut notes);
    Ok(ImportedMachine { text, notes, model: bodies.model })
}
