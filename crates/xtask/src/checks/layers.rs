//! Direction of dependencies: program, motion, geometry, judgement, record.

use crate::{
    TaskError,
    workspace::{DependencyKind, Workspace},
};

/// Prefix of the product's crates, left out in tables.
pub(crate) const PREFIX: &str = "proveout_";

/// Which crates of the workspace a crate may use, in tests as well. `xtask` and the crate of whole
/// prove-outs are at the top and may use any.
///
/// `proveout` names the types of the stages that its commands `nc`, `kinematics` and `check` print; it has
/// no algorithm of its own. `proveout_py` is above it: its commands are those of the Python package too.
pub(crate) const MAY_USE: &[(&str, &[&str])] = &[
    ("proveout_input", &[]),
    ("proveout_geom", &["input"]),
    ("proveout_step", &["input", "geom"]),
    ("proveout_blade", &["input", "geom"]),
    ("proveout_nc", &["input", "tool"]),
    ("proveout_tool", &["input", "geom"]),
    ("proveout_machine", &["input", "geom"]),
    ("proveout_path", &["geom", "blade", "tool", "machine"]),
    ("proveout_reschedule", &["geom", "blade", "tool", "machine", "path"]),
    ("proveout_controller", &["geom", "blade", "nc", "tool", "machine", "path", "reschedule"]),
    ("proveout_calibrate", &["input", "nc", "machine", "controller"]),
    ("proveout_stock", &["geom", "tool"]),
    ("proveout_surface", &["input", "geom", "blade", "tool", "stock"]),
    ("proveout_collision", &["geom", "blade", "tool", "machine", "stock"]),
    ("proveout_feeds", &["input", "tool"]),
    (
        "proveout_sim",
        &[
            "input",
            "geom",
            "step",
            "blade",
            "nc",
            "tool",
            "machine",
            "path",
            "reschedule",
            "controller",
            "stock",
            "surface",
            "collision",
            "feeds",
        ],
    ),
    ("proveout_record", &["geom", "nc", "tool", "machine", "controller", "stock", "surface", "collision", "sim"]),
    ("proveout", &["geom", "nc", "tool", "machine", "controller", "calibrate", "surface", "sim", "record"]),
    ("proveout_py", &["geom", "nc", "machine", "controller", "surface", "sim", "record", "proveout"]),
];

/// Crates above the table.
pub(crate) const FREE: &[&str] = &["xtask", "proveout_tests"];

/// An outside crate that only some crates may name.
struct ReservedCrate {
    name: &'static str,
    users: &'static [&'static str],
    /// Whether tests of other crates may name it: a library is a fine oracle, a viewer is not.
    in_tests: bool,
    why: &'static str,
}

const RESERVED: &[ReservedCrate] = &[
    ReservedCrate {
        name: "rerun",
        users: &["proveout_record"],
        in_tests: false,
        why: "it takes minutes to build; only the recording may wait for it",
    },
    ReservedCrate {
        name: "parry3d-f64",
        users: &["proveout_collision", "proveout_surface", "xtask"],
        in_tests: true,
        why: "one place for each use of distance queries, and the checker of certificates, which shares no other code with them; stock and \
              kinematics carry their own geometry",
    },
    ReservedCrate {
        name: "rapier3d-f64",
        users: &["proveout_controller", "proveout_sim"],
        in_tests: true,
        why: "its releases change motors and impulses; one file of each of two crates carries the change",
    },
];

/// Fails with every forbidden dependency.
pub(crate) fn check(workspace: &Workspace) -> Result<String, TaskError> {
    let faults = faults(workspace);
    if faults.is_empty() {
        let edges: usize = workspace.members.iter().map(|m| m.uses(workspace, &[DependencyKind::Normal]).len()).sum();
        return Ok(format!("{} crates, {edges} dependencies between them", workspace.members.len()));
    }
    Err(TaskError(faults.join("\n")))
}

fn faults(workspace: &Workspace) -> Vec<String> {
    let mut faults = Vec::new();
    for member in &workspace.members {
        for reserved in RESERVED {
            let names_it = member
                .dependencies
                .iter()
                .any(|d| d.name == reserved.name && (d.kind == DependencyKind::Normal || !reserved.in_tests));
            if names_it && !reserved.users.contains(&member.name.as_str()) {
                let users = reserved.users.join(", ");
                faults.push(format!(
                    "{} uses {}, which is reserved for {users}: {}",
                    member.name, reserved.name, reserved.why
                ));
            }
        }
        if FREE.contains(&member.name.as_str()) {
            continue;
        }
        let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == member.name) else {
            faults.push(format!(
                "{} is not in the table of layers: add it to MAY_USE in crates/xtask/src/checks/layers.rs and to ARCHITECTURE.md",
                member.name
            ));
            continue;
        };
        for used in member.uses(workspace, &[DependencyKind::Normal, DependencyKind::Dev]) {
            if !allowed.contains(&short(used)) {
                let allowed = if allowed.is_empty() { "none".to_owned() } else { allowed.join(", ") };
                faults.push(format!("{} uses {used}; it may use: {allowed}", member.name));
            }
        }
    }
    for (name, _) in MAY_USE {
        if !workspace.has(name) {
            faults.push(format!("{name} is in the table of layers but not in the workspace"));
        }
    }
    faults
}

/// Name as tables write it.
pub(crate) fn short(name: &str) -> &str {
    name.strip_prefix(PREFIX).unwrap_or(name)
}

/// What every crate uses, one line each.
pub(crate) fn table(workspace: &Workspace) -> String {
    let mut lines = String::new();
    for member in &workspace.members {
        let uses: Vec<&str> = member.uses(workspace, &[DependencyKind::Normal]).into_iter().map(short).collect();
        let uses = if uses.is_empty() { "–".to_owned() } else { uses.join(" ") };
        lines.push_str(&format!("{:<22} {uses}\n", member.name));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::{Dependency, Member};

    fn whole() -> Workspace {
        let member = |name: &str| Member { name: name.into(), folder: name.into(), dependencies: Vec::new() };
        let mut members: Vec<Member> = MAY_USE.iter().map(|(name, _)| member(name)).collect();
        members.push(member("xtask"));
        Workspace { members, target: "target".into() }
    }

    fn with(name: &str, dependency: &str, kind: DependencyKind) -> Vec<String> {
        let mut workspace = whole();
        let member = workspace.members.iter_mut().find(|m| m.name == name).expect("a member");
        member.dependencies.push(Dependency { name: dependency.into(), kind });
        faults(&workspace)
    }

    #[test]
    fn the_table_has_no_cycle() {
        // Every crate uses only crates whose own rows use fewer: peeling off rows without open uses empties
        // the table.
        let mut open: Vec<&(&str, &[&str])> = MAY_USE.iter().collect();
        let mut done: Vec<&str> = Vec::new();
        while !open.is_empty() {
            let ready: Vec<&str> =
                open.iter().filter(|(_, uses)| uses.iter().all(|u| done.contains(u))).map(|(n, _)| short(n)).collect();
            assert!(!ready.is_empty(), "a cycle among {open:?}");
            open.retain(|(name, _)| !ready.contains(&short(name)));
            done.extend(ready);
        }
    }

    #[test]
    fn dependencies_against_the_direction_are_named() {
        assert!(faults(&whole()).is_empty());
        assert!(with("proveout_stock", "proveout_geom", DependencyKind::Normal).is_empty());
        let upward = with("proveout_stock", "proveout_machine", DependencyKind::Normal);
        assert_eq!(upward, ["proveout_stock uses proveout_machine; it may use: geom, tool"]);
        assert_eq!(
            with("proveout_geom", "proveout_tool", DependencyKind::Dev).len(),
            1,
            "tests follow the direction too"
        );
        assert_eq!(with("proveout_sim", "proveout_record", DependencyKind::Normal).len(), 1);
    }

    #[test]
    fn heavy_crates_stay_where_they_are() {
        assert!(with("proveout_record", "rerun", DependencyKind::Normal).is_empty());
        assert_eq!(with("proveout_sim", "rerun", DependencyKind::Normal).len(), 1);
        assert_eq!(with("xtask", "rerun", DependencyKind::Dev).len(), 1);
        assert_eq!(with("proveout_stock", "parry3d-f64", DependencyKind::Normal).len(), 1);
        assert!(with("proveout_stock", "parry3d-f64", DependencyKind::Dev).is_empty(), "as an oracle in tests");
    }

    #[test]
    fn a_crate_without_a_row_is_a_fault() {
        let mut workspace = whole();
        let old = std::mem::replace(&mut workspace.members[0].name, "proveout_new".into());
        let faults = faults(&workspace);
        assert!(faults.iter().any(|f| f.starts_with("proveout_new is not in the table")));
        assert!(faults.iter().any(|f| f.starts_with(&format!("{old} is in the table of layers but not"))));
    }
}
