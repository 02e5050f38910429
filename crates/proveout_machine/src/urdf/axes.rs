//! The axes between table and tool: which joint has which letter, and its line in M with all joints at zero.

use std::collections::{BTreeMap, BTreeSet};

use proveout_geom::{Point, Vector};
use proveout_input::{InputError, MAX_LENGTH_MM};

use super::{
    UrdfOptions,
    link_tree::LinkTree,
    named_links::NamedLinks,
    read::{Robot, UrdfJoint, UrdfJointKind},
    source::{UrdfSource, listed, reach, shown},
};
use crate::{Carries, MAX_JOINTS, Machine};

/// Letters of axes, in the order of the machine file. Programs move the first six.
const LETTERS: &str = "XYZABCUVW";
/// Directions whose cosine is closer to 1 are the same: rounding.
const SAME_DIRECTION: f64 = 1e-9;

/// An axis of the machine.
pub(super) struct UrdfAxis {
    pub(super) letter: char,
    /// Index of the joint in the file.
    pub(super) joint: usize,
    pub(super) carries: Carries,
    /// Letter of the axis that carries this one.
    pub(super) parent: Option<char>,
    /// The way of the tool past the workpiece for a growing value, or the axis of that turn; unit vector in
    /// M.
    pub(super) direction: Vector,
    /// A point of the axis in M, mm.
    pub(super) point: Point,
    /// Lowest and highest value of the control, mm or radian.
    pub(super) travel: Option<[f64; 2]>,
    /// The control counts against the joint of the file.
    pub(super) reversed: bool,
}

impl UrdfAxis {
    pub(super) fn rotary(&self) -> bool {
        "ABC".contains(self.letter)
    }

    /// Axes that programs do not move.
    pub(super) fn held(&self) -> bool {
        "UVW".contains(self.letter)
    }
}

/// All axes, by letter.
pub(super) struct Axes {
    pub(super) all: Vec<UrdfAxis>,
    /// Axis that carries each link; none for the base.
    pub(super) carrier: Vec<Option<char>>,
    /// Letter of the last axis before the tool link, and before the table link.
    pub(super) last: [Option<char>; 2],
    pub(super) notes: Vec<String>,
}

/// The axis letter of a name: the name itself, or one of its words (`x_axis`, `joint-B`, `axisC`).
fn letter_of(name: &str) -> Option<char> {
    let mut found = None;
    let mut word = String::new();
    let mut before = ' ';
    for c in name.chars().chain([' ']) {
        let begins = before.is_ascii_lowercase() && c.is_ascii_uppercase();
        if !c.is_alphanumeric() || begins {
            let mut letters = word.chars();
            if let (Some(only), None) = (letters.next().map(|c| c.to_ascii_uppercase()), letters.next())
                && LETTERS.contains(only)
                && found.replace(only).is_some()
            {
                return None;
            }
            word.clear();
        }
        if c.is_alphanumeric() {
            word.push(c);
        }
        before = c;
    }
    found
}

/// Letters that the caller gives to joints.
fn named<'o>(source: &UrdfSource<'_>, robot: &Robot, text: &'o str) -> Result<BTreeMap<&'o str, char>, InputError> {
    let mut all = BTreeMap::new();
    for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
        let letter = part.rsplit_once('=').and_then(|(name, letter)| {
            let mut letters = letter.trim().chars().map(|c| c.to_ascii_uppercase());
            let first = letters.next().filter(|c| LETTERS.contains(*c))?;
            letters.next().is_none().then_some((name.trim(), first))
        });
        let Some((name, letter)) = letter else {
            let message = format!("--axis-names {}: this names no axis", shown(part));
            return Err(
                source.whole(message, "write JOINT=LETTER, as in joint_1=X,joint_2=C; letters: X Y Z A B C U V W")
            );
        };
        if robot.joints.iter().all(|j| j.name != name) {
            let message = format!("--axis-names {}: the file has no such joint", shown(name));
            let moving = robot.joints.iter().filter(|j| j.kind != UrdfJointKind::Fixed).map(|j| j.name.as_str());
            return Err(source.whole(message, format!("joints that move: {}", listed(moving))));
        }
        if all.insert(name, letter).is_some() {
            return Err(source.whole(format!("--axis-names names joint {} twice", shown(name)), "keep one of the two"));
        }
    }
    Ok(all)
}

/// Finds the axes and describes them.
pub(super) fn axes(
    source: &UrdfSource<'_>,
    robot: &Robot,
    tree: &LinkTree,
    ends: &NamedLinks,
    options: &UrdfOptions,
) -> Result<Axes, InputError> {
    let (to_tool, to_table) = (tree.way_to(ends.tool), tree.way_to(ends.table));
    let common = to_tool.iter().zip(&to_table).take_while(|(a, b)| a == b).count();
    let side = |way: &[usize]| LinkTree::moving(robot, way.get(common..).unwrap_or_default());
    let sides = [(side(&to_tool), Carries::Tool), (side(&to_table), Carries::Workpiece)];
    let mut notes = Vec::new();
    let still = LinkTree::moving(robot, to_tool.get(..common).unwrap_or_default());
    if !still.is_empty() {
        let names = listed(still.iter().map(|&j| robot.joints[j].name.as_str()));
        notes.push(format!("joints that carry both tool and table are held at zero: {names}"));
    }
    let letters = letters(source, robot, &sides, options)?;
    let reversed = reversed(source, &letters, options)?;
    let mut all = Vec::new();
    let mut last = [None; 2];
    for ((chain, carries), last) in sides.iter().zip(&mut last) {
        for &j in chain {
            let joint = &robot.joints[j];
            let Some(&letter) = letters.get(&j) else { continue };
            let machine_from_joint = tree.poses[tree.child[j]];
            let reversed = reversed.contains(&letter);
            // The joint of the file moves what it carries along its axis; on the side of the table the tool
            // then goes the other way.
            let sign = if reversed == (*carries == Carries::Tool) { -1.0 } else { 1.0 };
            let point = Point::from(machine_from_joint.translation);
            let far = reach(&[point]);
            if far > MAX_LENGTH_MM {
                let message = format!("joint {} is {far:.0} mm from the root", shown(&joint.name));
                return Err(source.at(&joint.place, message, format!("the limit is {MAX_LENGTH_MM} mm")));
            }
            all.push(UrdfAxis {
                letter,
                joint: j,
                carries: *carries,
                parent: *last,
                direction: machine_from_joint.vector(&joint.axis).normalize() * sign,
                point,
                travel: joint.travel.map(|[low, high]| if reversed { [-high, -low] } else { [low, high] }),
                reversed,
            });
            *last = Some(letter);
        }
    }
    all.sort_by_key(|a| LETTERS.find(a.letter));
    let renamed: Vec<String> = all
        .iter()
        .filter(|a| robot.joints[a.joint].name != a.letter.to_string())
        .map(|a| format!("{} is joint {}", a.letter, shown(&robot.joints[a.joint].name)))
        .collect();
    if !renamed.is_empty() {
        notes.push(format!("axes: {}", renamed.join(", ")));
    }
    let mut carrier: Vec<Option<char>> = vec![None; robot.links.len()];
    let mut loose = Vec::new();
    for &link in &tree.order {
        let Some(j) = tree.carrier[link] else { continue };
        carrier[link] = letters.get(&j).copied().or(carrier[tree.parent[j]]);
        if robot.joints[j].kind != UrdfJointKind::Fixed && !letters.contains_key(&j) && !still.contains(&j) {
            loose.push(robot.joints[j].name.as_str());
        }
    }
    if !loose.is_empty() {
        notes.push(format!("joints that are not axes between table and tool are held at zero: {}", listed(loose)));
    }
    Ok(Axes { all, carrier, last, notes })
}

/// Letter of each joint between table and tool.
fn letters(
    source: &UrdfSource<'_>,
    robot: &Robot,
    sides: &[(Vec<usize>, Carries); 2],
    options: &UrdfOptions,
) -> Result<BTreeMap<usize, char>, InputError> {
    let given = named(source, robot, options.axis_names.as_deref().unwrap_or_default())?;
    let chain: Vec<usize> = sides.iter().flat_map(|(chain, _)| chain.iter().copied()).collect();
    let name = |j: &usize| robot.joints[*j].name.as_str();
    let names = || listed(chain.iter().map(name));
    if chain.is_empty() {
        return Err(source.whole("no joint moves the tool against the workpiece", "name other links"));
    }
    if let Some(idle) = given.keys().find(|n| chain.iter().all(|j| name(j) != **n)) {
        let message = format!("--axis-names {}: the joint is not between table and tool", shown(idle));
        return Err(source.whole(message, format!("joints that do: {}", names())));
    }
    // Report first what is not a machine tool: axis letters would not help it.
    let slides = chain.iter().filter(|&&j| robot.joints[j].kind == UrdfJointKind::Prismatic).count();
    if slides < 3 || chain.len() > MAX_JOINTS {
        let message = format!(
            "between table and tool {slides} joints slide and {} turn ({}); a machine of the twin has three slides X, Y, Z and at most {MAX_JOINTS} \
             axes",
            chain.len() - slides,
            names()
        );
        let remedy = "robots are not supported; name other links with --tool-link and --table-link, or make joints \
                      that do not move fixed";
        return Err(source.whole(message, remedy));
    }
    let letter = |j: &usize| given.get(name(j)).copied().or_else(|| letter_of(name(j)));
    let without: Vec<usize> = chain.iter().copied().filter(|j| letter(j).is_none()).collect();
    if let [first, ..] = without[..] {
        let message = format!("no axis letter in the name of joint {}", listed(without.iter().map(name)));
        let remedy = format!(
            "give it by --axis-names {}=X; if a joint is not a programmed axis, such as the rotation of a spindle, \
             name the link before it",
            name(&first)
        );
        return Err(source.at(&robot.joints[first].place, message, remedy));
    }
    let mut all = BTreeMap::new();
    for j in &chain {
        let Some(letter) = letter(j) else { continue };
        let joint = &robot.joints[*j];
        if let Some((other, _)) = all.iter().find(|(_, l)| **l == letter) {
            let message = format!("joints {} and {} both are axis {letter}", shown(name(other)), shown(&joint.name));
            return Err(source.at(
                &joint.place,
                message,
                format!("give one a letter by --axis-names {}=...", joint.name),
            ));
        }
        check_kind(source, joint, letter)?;
        all.insert(*j, letter);
    }
    match "XYZ".chars().find(|c| all.values().all(|l| l != c)) {
        None => Ok(all),
        Some(missing) => {
            let message = format!("no joint between table and tool is axis {missing} ({})", names());
            Err(source.whole(message, format!("give its letter by --axis-names JOINT={missing}")))
        }
    }
}

fn check_kind(source: &UrdfSource<'_>, joint: &UrdfJoint, letter: char) -> Result<(), InputError> {
    let turns = joint.kind != UrdfJointKind::Prismatic;
    if turns == "ABC".contains(letter) {
        return Ok(());
    }
    let (is, wants) = if turns { ("turns", "slides") } else { ("slides", "turns") };
    let message = format!("joint {} {is}, and axis {letter} {wants}", shown(&joint.name));
    Err(source.at(&joint.place, message, format!("give it another letter by --axis-names {}=...", joint.name)))
}

/// Letters that the control counts against the file.
fn reversed(
    source: &UrdfSource<'_>,
    letters: &BTreeMap<usize, char>,
    options: &UrdfOptions,
) -> Result<BTreeSet<char>, InputError> {
    let text = options.reverse.as_deref().unwrap_or_default().to_ascii_uppercase();
    let mut all = BTreeSet::new();
    for c in text.chars().filter(|c| !c.is_whitespace() && *c != ',') {
        if letters.values().all(|l| *l != c) {
            let known: Vec<String> = letters.values().map(char::to_string).collect();
            let message = format!("--reverse {}: the machine has no such axis", shown(&c.to_string()));
            return Err(source.whole(message, format!("axes of the machine: {}", known.join(" "))));
        }
        all.insert(c);
    }
    Ok(all)
}

impl Axes {
    /// The error for a machine that its axes make invalid: it names the joint in the URDF file.
    pub(super) fn no_machine(&self, source: &UrdfSource<'_>, robot: &Robot, error: &InputError) -> InputError {
        let letter = error.key.strip_prefix("joint.").and_then(|rest| rest.chars().next());
        let joint = self.all.iter().find(|a| Some(a.letter) == letter).map(|a| &robot.joints[a.joint]);
        let remedy = match error.code {
            "machine-tool-on-axis" => {
                "if the joint is the rotation of the spindle itself, name the link before it as --tool-link; if the \
                 tool points another way, give --tool-direction"
            }
            "machine-parallel-rotary-axes" => "correct an axis, or name other links with --tool-link and --table-link",
            _ => "correct it in the file",
        };
        let message = format!("the axes do not make a machine: {}", error.message);
        joint.map_or_else(|| source.whole(&message, remedy), |j| source.at(&j.place, &message, remedy))
    }

    /// Reports which axes a program would find reversed.
    pub(super) fn warn_reversed_axes(&self, machine: &Machine, notes: &mut Vec<String>) {
        let along = |a: &UrdfAxis| match a.letter {
            'X' | 'A' => a.direction.x,
            'Y' | 'B' => a.direction.y,
            _ => a.direction.z,
        };
        let moved: Vec<&UrdfAxis> = self.all.iter().filter(|a| !a.held()).collect();
        let against: Vec<String> = moved.iter().filter(|a| along(a) < -0.5).map(|a| a.letter.to_string()).collect();
        if !against.is_empty() {
            // Those that count with their letter: what is reversed without need is not, and the others are.
            let with: Vec<String> =
                moved.iter().filter(|a| a.reversed != (along(a) < -0.5)).map(|a| a.letter.to_string()).collect();
            let remedy = match with.join(",").as_str() {
                "" => "leave --reverse out".to_owned(),
                names => format!("--reverse {names}"),
            };
            notes.push(format!(
                "a growing value takes the tool past the workpiece against the letter on {}, while programs count with it (ISO 841): if the \
                 control counts so, {remedy}",
                against.join(",")
            ));
        }
        let aside: Vec<String> = moved
            .iter()
            .filter(|a| !a.rotary() && along(a).abs() < 1.0 - SAME_DIRECTION)
            .map(|a| a.letter.to_string())
            .collect();
        if !aside.is_empty() {
            notes.push(format!(
                "{} does not run along its axis of the root link, whose frame is that of the machine: a fixed joint below a new root turns it",
                aside.join(", ")
            ));
        } else if against.is_empty() && machine.program_zero().is_none() {
            notes.push(
                "work offsets have no common point on table and axes: X, Y, Z do not run along the table's frame"
                    .into(),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_a_letter_or_none() {
        for (name, letter) in [
            ("X", 'X'),
            ("b", 'B'),
            ("x_axis", 'X'),
            ("joint-C", 'C'),
            ("axisA", 'A'),
            ("machine/z", 'Z'),
            ("slide.Y.1", 'Y'),
        ] {
            assert_eq!(letter_of(name), Some(letter), "{name}");
        }
        for name in ["joint_1", "x_to_y", "X1", "xaxis", "", "_", "axle", "q", "table"] {
            assert_eq!(letter_of(name), None, "{name}");
        }
    }
}
