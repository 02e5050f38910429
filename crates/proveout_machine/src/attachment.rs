//! What carries a body or an end of the chain: the bed or a joint.

use proveout_input::{Document, Step};

use crate::{description::JointFile, reading::Checked};

/// What carries a body or a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Attachment {
    /// The machine bed.
    Base,
    /// Index of a joint.
    Joint(usize),
}

pub(crate) fn attachment(
    source: &Document<'_>,
    joints: &[JointFile],
    path: &[Step<'_>],
    name: &str,
) -> Checked<Attachment> {
    if name == "base" {
        return Ok(Attachment::Base);
    }
    joints.iter().position(|j| j.name == name).map(Attachment::Joint).ok_or_else(|| {
        let names: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
        let remedy = format!("write base or a joint of this file: {}", names.join(", "));
        source.error("machine-unknown-joint", path, format!("there is no joint {name:?}"), remedy)
    })
}
