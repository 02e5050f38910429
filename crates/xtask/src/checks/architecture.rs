//! ARCHITECTURE.md against the manifests, so that the map cannot go stale.

use super::layers::{FREE, PREFIX, short};
use crate::{
    TaskError,
    workspace::{DependencyKind, Workspace},
};

/// A row of the crate table: crate name and the names in its last column, without prefix.
#[derive(Clone, Debug, PartialEq, Eq)]
struct CrateRow {
    line: usize,
    name: String,
    uses: Vec<String>,
}

/// Rows ``| `crate` | does | may use |`` of the table under the heading that starts with `crate`.
fn rows(text: &str) -> Vec<CrateRow> {
    let mut rows = Vec::new();
    let mut inside = false;
    for (index, line) in text.lines().enumerate() {
        let Some(cells) = line.trim().strip_prefix('|').and_then(|l| l.strip_suffix('|')) else {
            inside = false;
            continue;
        };
        let cells: Vec<&str> = cells.split('|').map(str::trim).collect();
        if cells.first() == Some(&"crate") {
            inside = true;
            continue;
        }
        let ([name, _, uses], true) = (cells.as_slice(), inside) else { continue };
        if let Some(name) = name.strip_prefix('`').and_then(|n| n.strip_suffix('`')) {
            let uses = uses.split_whitespace().filter(|w| *w != "–").map(str::to_owned).collect();
            rows.push(CrateRow { line: index + 1, name: name.to_owned(), uses });
        }
    }
    rows
}

/// Fails with every difference between table and manifests.
pub(crate) fn check(text: &str, workspace: &Workspace) -> Result<String, TaskError> {
    let rows = rows(text);
    let mut faults = Vec::new();
    for row in &rows {
        let place = format!("ARCHITECTURE.md:{}", row.line);
        if rows.iter().filter(|r| r.name == row.name).count() > 1 {
            faults.push(format!("{place}: {} has two rows", row.name));
        }
        let Some(member) = workspace.members.iter().find(|m| m.name == row.name) else {
            faults.push(format!("{place}: {} is not a crate of the workspace", row.name));
            continue;
        };
        if FREE.contains(&row.name.as_str()) {
            if row.uses != ["any"] {
                faults.push(format!("{place}: {} may use any crate; write `any`", row.name));
            }
            continue;
        }
        let in_manifest = member.uses(workspace, &[DependencyKind::Normal]).into_iter().map(short).collect::<Vec<_>>();
        for name in row.uses.iter().filter(|u| !in_manifest.contains(&u.as_str())) {
            faults.push(format!("{place}: {} does not use {name}: take it out of the row", row.name));
        }
        for name in in_manifest.iter().filter(|name| !row.uses.iter().any(|u| u == *name)) {
            faults.push(format!("{place}: {} uses {PREFIX}{name}: add it to the row", row.name));
        }
    }
    for member in &workspace.members {
        let in_crates = member.folder.parent().is_some_and(|p| p.ends_with("crates"));
        if in_crates && !rows.iter().any(|r| r.name == member.name) {
            faults.push(format!("ARCHITECTURE.md: the crate table has no row for `{}`", member.name));
        }
    }
    if faults.is_empty() { Ok(format!("{} rows", rows.len())) } else { Err(TaskError(faults.join("\n"))) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::{Dependency, Member};

    fn workspace() -> Workspace {
        let dependency = |name: &str| Dependency { name: name.into(), kind: DependencyKind::Normal };
        let member = |name: &str, uses: &[&str]| Member {
            name: name.into(),
            folder: format!("/w/crates/{name}").into(),
            dependencies: uses.iter().map(|u| dependency(u)).collect(),
        };
        let members = vec![
            member("proveout_geom", &["nalgebra"]),
            member("proveout_tool", &["proveout_geom"]),
            member("xtask", &["proveout_tool"]),
        ];
        Workspace { members, target: "/w/target".into() }
    }

    const RIGHT: &str = "# Map\n\n| crate | does | may use |\n|---|---|---|\n| `proveout_geom` | poses | – |\n\
        | `proveout_tool` | cutters | geom |\n| `xtask` | steps | any |\n\n| looking for | open |\n|---|---|\n| a | `b` |\n";

    #[test]
    fn a_true_table_passes() {
        assert_eq!(check(RIGHT, &workspace()).expect("true"), "3 rows");
    }

    #[test]
    fn every_lie_is_named_with_its_line() {
        let message = |text: &str| check(text, &workspace()).expect_err("a fault").0;
        assert!(message(&RIGHT.replace("| geom |", "| – |")).contains(":6: proveout_tool uses proveout_geom"));
        assert!(message(&RIGHT.replace("| – |", "| tool |")).contains(":5: proveout_geom does not use tool"));
        assert!(message(&RIGHT.replace("proveout_tool", "proveout_new")).contains("not a crate of the workspace"));
        let without = RIGHT.replace("| `proveout_geom` | poses | – |\n", "");
        assert_eq!(message(&without), "ARCHITECTURE.md: the crate table has no row for `proveout_geom`");
        assert!(message(&RIGHT.replace("| any |", "| tool |")).contains("write `any`"));
    }
}
