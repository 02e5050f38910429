//! Checks on the tree of joints as a whole: chains, loops, and whether the joints span the motion that they
//! must.

use proveout_input::{Document, Step::Item, Step::Key};

use crate::{
    Attachment, Carries, Joint, axis_pair::PARALLEL_SINE, kinematic_chain::Chain, reading::Checked, solver::Solver,
};

/// The joints from the base to the one that carries the spindle or the table.
pub(crate) fn chain_to(
    source: &Document<'_>,
    joints: &[Joint],
    end: Attachment,
    carries: Carries,
) -> Checked<Vec<usize>> {
    let mut chain = Vec::new();
    let mut next = match end {
        Attachment::Base => None,
        Attachment::Joint(j) => Some(j),
    };
    let (word, other) = match carries {
        Carries::Tool => ("tool", "workpiece"),
        Carries::Workpiece => ("workpiece", "tool"),
    };
    while let Some(j) = next {
        if chain.contains(&j) {
            let message = format!("joint {} is its own ancestor: the parents form a loop", joints[j].name);
            let path = [Key("joint"), Item(j), Key("parent")];
            return Err(source.error("machine-loop", &path, message, "give one joint of the loop the parent base"));
        }
        if joints[j].carries != carries {
            let message = format!("joint {} carries the {word} by its parents, but states {other}", joints[j].name);
            let remedy = format!("write carries = \"{word}\", or correct the parent of the joints that it carries");
            return Err(source.error("machine-wrong-side", &[Key("joint"), Item(j), Key("carries")], message, remedy));
        }
        chain.push(j);
        next = joints[j].parent;
    }
    chain.reverse();
    Ok(chain)
}

/// Every joint is in a chain, and those that are not held can be solved.
pub(crate) fn check_kinematics(source: &Document<'_>, joints: &[Joint], chain: &Chain, solver: &Solver) -> Checked<()> {
    for j in 0..joints.len() {
        if !chain.links.iter().any(|l| l.joint == j) {
            let mut seen = vec![j];
            while let Some(parent) = joints[seen[seen.len() - 1]].parent {
                if seen.contains(&parent) {
                    let message = format!("joint {} is its own ancestor: the parents form a loop", joints[j].name);
                    let path = [Key("joint"), Item(j), Key("parent")];
                    return Err(source.error(
                        "machine-loop",
                        &path,
                        message,
                        "give one joint of the loop the parent base",
                    ));
                }
                seen.push(parent);
            }
            let message = format!("joint {} is in no chain: it carries neither spindle nor table", joints[j].name);
            let remedy = "set `on` of [spindle] or [table], or the parent of the next joint, to this joint";
            return Err(source.error("machine-loose-joint", &[Key("joint"), Item(j), Key("parent")], message, remedy));
        }
    }
    if let &[first, .., last] = solver.rotary()
        && !solver.has_closed_form()
        && solver.freedom(chain) < PARALLEL_SINE
    {
        let message =
            format!("the rotary axes from {} to {} swing the tool in one plane", joints[first].name, joints[last].name);
        let path = [Key("joint"), Item(last), Key("direction")];
        let remedy = "correct the directions, or set held = true on all but one";
        return Err(source.error("machine-parallel-rotary-axes", &path, message, remedy));
    }
    if let &[first, second] = solver.rotary()
        && !solver.has_pair(chain)
    {
        let axis = |joint| chain.links.iter().find(|l| l.joint == joint).map_or_else(Default::default, |l| l.direction);
        let parallel = axis(first).cross(&axis(second)).norm() < PARALLEL_SINE;
        let (a, b) = (&joints[first].name, &joints[second].name);
        let (code, message) = if parallel {
            ("machine-parallel-rotary-axes", format!("the rotary axes {a} and {b} are parallel"))
        } else {
            ("machine-tool-on-axis", format!("joint {b} turns the tool about itself and cannot tilt it against {a}"))
        };
        let remedy = "correct the direction, or set held = true on one of the two";
        return Err(source.error(code, &[Key("joint"), Item(second), Key("direction")], message, remedy));
    }
    Ok(())
}
