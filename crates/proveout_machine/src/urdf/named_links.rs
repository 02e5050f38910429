//! The two ends of a machine in a tree of links: where the tool is, and where the workpiece.

use proveout_geom::Vector;
use proveout_input::InputError;

use super::{
    UrdfOptions,
    link_tree::LinkTree,
    read::Robot,
    source::{UrdfSource, listed, shown},
};

/// The links that the caller has named, and which way their frames look.
pub(super) struct NamedLinks {
    pub(super) tool: usize,
    pub(super) table: usize,
    /// From the tool into the spindle, unit vector in the frame of the tool link.
    pub(super) into_spindle: Vector,
    /// Out of the clamping surface, unit vector in the frame of the table link.
    pub(super) normal: Vector,
    /// Whether the caller has said so.
    pub(super) stated: [bool; 2],
}

/// Finds them.
pub(super) fn ends(
    source: &UrdfSource<'_>,
    robot: &Robot,
    tree: &LinkTree,
    options: &UrdfOptions,
) -> Result<NamedLinks, InputError> {
    let given = [("tool", &options.tool_link), ("table", &options.table_link)];
    let missing: Vec<&str> = given.iter().filter(|(_, name)| name.is_none()).map(|(word, _)| *word).collect();
    if let [first, ..] = missing[..] {
        let what = match (missing.len(), first) {
            (2, _) => "which link carries the tool and which the workpiece",
            (_, "tool") => "which link carries the tool",
            _ => "which link carries the workpiece",
        };
        let words: Vec<String> = missing.iter().map(|word| format!("--{word}-link NAME")).collect();
        let message = format!("the file does not say {what}; links at the ends: {}", listed(tree.leaves(robot)));
        return Err(source.whole(message, format!("say it by {}", words.join(" and "))));
    }
    let find = |option: &str, name: &Option<String>| {
        let name = name.as_deref().unwrap_or_default();
        robot.links.iter().position(|l| l.name == name).ok_or_else(|| {
            let message = format!("{option} {}: the file has no such link", shown(name));
            source.whole(message, format!("links at the ends: {}", listed(tree.leaves(robot))))
        })
    };
    let (tool, table) = (find("--tool-link", &options.tool_link)?, find("--table-link", &options.table_link)?);
    if tool == table {
        let message = format!("link {} cannot carry tool and workpiece", shown(&robot.links[tool].name));
        return Err(source.whole(message, "name two links with --tool-link and --table-link"));
    }
    let axis = |option: &str, given: &Option<String>| match given {
        None => Ok(Vector::z()),
        Some(word) => direction(word).ok_or_else(|| {
            source.whole(format!("{option} {} is not a frame axis", shown(word)), "write x, -x, y, -y, z or -z")
        }),
    };
    Ok(NamedLinks {
        tool,
        table,
        into_spindle: axis("--tool-direction", &options.tool_direction)?,
        normal: axis("--table-normal", &options.table_normal)?,
        stated: [options.tool_direction.is_some(), options.table_normal.is_some()],
    })
}

fn direction(word: &str) -> Option<Vector> {
    let word = word.trim().to_ascii_lowercase();
    let (sign, letter) = match word.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, word.strip_prefix('+').unwrap_or(&word)),
    };
    let axis = match letter {
        "x" => Vector::x(),
        "y" => Vector::y(),
        "z" => Vector::z(),
        _ => return None,
    };
    Some(axis * sign)
}
