//! Stock and mounting that fit a program, as far as its motion shows.
//!
//! *Stock.* Where neither program nor call states it: the box of what the cutters reach in feed
//! while they move sideways, up to the highest of these motions or the program's zero, down to the
//! lowest. Where a tool goes down in rapid next to the box there is no material: the box is cut
//! back on the side that costs least. Sides that are not cut back get an allowance, since a cutter
//! inside a part does not reach its walls. Where all tools only go down, the zero is the top, or
//! the material begins 1 mm below where they begin in feed. A tool that only goes down makes holes:
//! they lie in the stock by twice their radius, which reaches down to where a point of 118 degrees
//! begins.
//!
//! *Mounting.* The middle of the stock lies over the middle of the table, its lower face 50 mm
//! above it, or where the travel of Z allows every tool to reach its cuts.

use proveout_geom::{Aabb, Point, Vector};
use proveout_machine::Machine;

use super::Reasoned;
use crate::{
    prepare::{
        program_extent::Reading,
        program_trace::{SAME_DIRECTION, SAME_MM},
    },
    units::UM_PER_MM,
};

/// Allowance of sides that no descent bounds, mm.
const ALLOWANCE_MM: f64 = 5.0;
/// Allowance above the highest cut where the zero of the program is not its top, mm.
const ABOVE_MM: f64 = 1.0;
/// Height of the stock's lower face above the table: a low vise, mm.
pub(crate) const ABOVE_TABLE_MM: f64 = 50.0;
/// A position that would lie beyond the travel is brought this far from its end, mm.
const BESIDE_LIMIT_MM: f64 = 1.0;
/// Coordinates of a proposal are rounded outward to these, mm.
const ROUND_MM: f64 = 0.5;
/// A tool that reaches into the box of the cuts by less goes down beside it, mm: rounding.
const ROUNDING_MM: f64 = 1e-9;
/// Shortest side of a box that can be a stock, mm.
const LEAST_SIDE_MM: f64 = 1e-3;
/// A position past the end of a travel by less is at it, mm or radian.
pub(crate) const PAST_TRAVEL: f64 = 1e-6;
/// What a mounting may still have to be moved after it was moved, mm: it is written in micrometers.
const LEFT_MM: f64 = 1e-3;
/// Keeps the size of a design against an empty room a number, mm.
const LEAST_ROOM_MM: f64 = 1e-9;

/// A place as it is written.
fn to_micrometers(v: f64) -> f64 {
    (v * UM_PER_MM).round() / UM_PER_MM
}

/// What one tool does, for the stock.
#[derive(Clone, Copy)]
pub(crate) struct Swept<'a> {
    pub(crate) radius: f64,
    /// It faces: it runs out over the edges of the stock by its radius.
    pub(crate) faces: bool,
    pub(crate) sideways: Aabb,
    pub(crate) feed: Aabb,
    /// Highest motion sideways that does not go down.
    pub(crate) level: Option<f64>,
    pub(crate) descents: &'a [Point],
    /// It leaves the z axis of the workpiece.
    pub(crate) tilted: bool,
}

/// Length of a drill's point of 118 degrees over the radius.
const DRILL_POINT: f64 = 0.6;

/// The stock of a part whose design is known: the box of the design, and above it what tools face off. `own`
/// is that box, mm.
pub(crate) fn stock_of_design(own: &Aabb, tools: &[Swept<'_>]) -> (Aabb, String) {
    let mut stock = *own;
    let over = |t: &&Swept<'_>| {
        !t.sideways.is_empty()
            && t.sideways.min.z > own.max.z - SAME_MM
            && (0..2).all(|i| t.sideways.min[i] - t.radius < own.max[i] && t.sideways.max[i] + t.radius > own.min[i])
    };
    let faced = tools.iter().filter(|t| !t.tilted).filter(over).map(|t| t.sideways.max.z).reduce(f64::max);
    let mut how = "the box of the design".to_owned();
    if let Some(highest) = faced {
        stock.max.z = highest + ABOVE_MM;
        how += &format!(", and {:.3} mm above it that are faced off", stock.max.z - own.max.z);
    }
    (stock, how)
}

/// The stock that follows from the motion; none without motion in feed.
pub(crate) fn propose_stock(tools: &[Swept<'_>]) -> Option<(Aabb, String)> {
    let swept = |t: &Swept<'_>| {
        let mut b = if t.sideways.is_empty() { t.feed } else { t.sideways };
        for i in 0..2 {
            let (middle, half) = (0.5 * (b.min[i] + b.max[i]), 0.5 * (b.max[i] - b.min[i]));
            let reach = if t.faces { (half - t.radius).max(0.5 * half) } else { half + t.radius };
            (b.min[i], b.max[i]) = (middle - reach, middle + reach);
        }
        b
    };
    let mut all = Aabb::empty();
    let sideways = tools.iter().any(|t| !t.sideways.is_empty());
    for tool in tools.iter().filter(|t| !t.feed.is_empty() && (!sideways || !t.sideways.is_empty())) {
        all = all.union(&swept(tool));
    }
    if all.is_empty() {
        return None;
    }
    let lowest = all.min.z;
    // Where tools only go down, they begin in air: the zero is the top where it lies between, else the
    // material begins below.
    let begin = tools.iter().filter(|t| !sideways && !t.feed.is_empty()).map(|t| t.feed.max.z).reduce(f64::min);
    // A ramp begins in air: where all that is level is below the zero, the zero is the top.
    let level = tools.iter().filter_map(|t| t.level).reduce(f64::max);
    let highest = match begin {
        Some(begin) if lowest < 0.0 && begin >= 0.0 => 0.0,
        Some(begin) => (begin - 2.0 * ABOVE_MM).max(lowest + ABOVE_MM),
        None => level.filter(|z| lowest < 0.0 && *z <= ABOVE_MM).unwrap_or(all.max.z),
    };
    let at_zero = lowest < 0.0 && highest <= ABOVE_MM && begin.is_none_or(|begin| begin >= 0.0);
    // What is faced at the zero was above it.
    let faced = tools.iter().any(|t| t.faces && !t.sideways.is_empty() && t.sideways.min.z > -SAME_MM);
    let top = match at_zero {
        true if faced => highest.max(0.0) + ABOVE_MM,
        true => highest.max(0.0),
        false => highest + ABOVE_MM,
    };
    let mut bottom = lowest - 1.0;
    // Sides: [axis][low, high].
    let mut cut_back = [[false; 2]; 2];
    let mut places = 0;
    // A tool that only goes down goes into its own holes, and a tilted one comes down from the
    // side.
    for tool in tools.iter().filter(|t| !t.tilted && (!sideways || !t.sideways.is_empty())) {
        for p in tool.descents.iter().filter(|p| p.z < top - SAME_MM) {
            let reach = |axis: usize| [p[axis] - tool.radius, p[axis] + tool.radius];
            let inside = (0..2).all(|axis| {
                reach(axis)[1] > all.min[axis] + ROUNDING_MM && reach(axis)[0] < all.max[axis] - ROUNDING_MM
            });
            // A drill that came down above its hole goes back into it.
            let own_hole = tool.sideways.is_empty()
                && tool
                    .descents
                    .iter()
                    .any(|q| q.z >= top - SAME_MM && (q.x - p.x).abs() < SAME_MM && (q.y - p.y).abs() < SAME_MM);
            if !inside || own_hole {
                continue;
            }
            // What is lost by moving a side past the tool.
            let sides = (0..2).flat_map(|axis| {
                [(axis, 0, reach(axis)[1] - all.min[axis]), (axis, 1, all.max[axis] - reach(axis)[0])]
            });
            let Some((axis, side, lost)) = sides.min_by(|a, b| a.2.total_cmp(&b.2)) else { continue };
            // A place in the middle of the part is a hole that was there before, and not its side.
            if lost > 0.4 * (all.max[axis] - all.min[axis]) {
                continue;
            }
            places += 1;
            cut_back[axis][side] = true;
            if side == 0 { all.min[axis] += lost } else { all.max[axis] -= lost }
        }
    }
    for (axis, cut_back) in cut_back.iter().enumerate() {
        let out = |side: usize| if cut_back[side] { 0.0 } else { ALLOWANCE_MM };
        all.min[axis] -= out(0);
        all.max[axis] += out(1);
        // Inward where tools come down next to the stock.
        let round =
            |v: f64, up: bool| if up { (v / ROUND_MM).ceil() * ROUND_MM } else { (v / ROUND_MM).floor() * ROUND_MM };
        all.min[axis] = round(all.min[axis], cut_back[0]);
        all.max[axis] = round(all.max[axis], !cut_back[1]);
    }
    for drill in tools.iter().filter(|t| sideways && t.sideways.is_empty() && !t.feed.is_empty() && !t.tilted) {
        for axis in 0..2 {
            let wall = 2.0 * drill.radius;
            let (low, high) = (drill.feed.min[axis] - wall, drill.feed.max[axis] + wall);
            all.min[axis] = all.min[axis].min((low / ROUND_MM).floor() * ROUND_MM);
            all.max[axis] = all.max[axis].max((high / ROUND_MM).ceil() * ROUND_MM);
        }
        bottom = bottom.min(drill.feed.min.z + DRILL_POINT * drill.radius);
    }
    // Where all tools are tilted, the sides they come from are unknown; the depth they reach is
    // known.
    for tool in tools.iter().filter(|t| t.tilted && t.sideways.is_empty() && !t.feed.is_empty()) {
        bottom = bottom.min(tool.feed.min.z - tool.radius);
    }
    (all.min.z, all.max.z) = ((bottom / ROUND_MM).floor() * ROUND_MM, top);
    let how = format!(
        "the space that the cutters reach in feed, {}, 1 mm below the lowest cut or to the end of the deepest hole{}",
        if at_zero && faced {
            "1 mm above the zero of the program, which is faced"
        } else if at_zero {
            "up to the zero of the program or the highest cut"
        } else if begin.is_some() {
            "up to 1 mm below where the tools start down in feed"
        } else {
            "1 mm above the highest cut"
        },
        match places {
            0 => format!(", {ALLOWANCE_MM} mm more on each side"),
            n => format!(", cut back where tools go down in rapid ({n} places), else {ALLOWANCE_MM} mm more"),
        }
    );
    (0..3).all(|i| all.max[i] - all.min[i] > LEAST_SIDE_MM).then_some((all, how))
}

/// What a tool needs of Z: gauge length and the heights of its tip above the zero of the workpiece.
pub(crate) struct Reach {
    pub(crate) gauge: f64,
    pub(crate) tip: [f64; 2],
}

/// Place of the workpiece frame on the table, and why.
pub(crate) fn propose_mount(machine: &Machine, stock: &Aabb, reaches: &[Reach]) -> (Vector, String) {
    let table = machine.table.point;
    let middle = stock.center();
    let wanted = table.z + ABOVE_TABLE_MM - stock.min.z;
    let place = |z: f64| Vector::new(table.x - middle.x, table.y - middle.y, z).map(to_micrometers);
    let usual = format!(
        "assumed: the middle of the stock over the middle of the table, its lower face {ABOVE_TABLE_MM} mm above it"
    );
    let range = machine.program_zero().zip(machine.joint_for_letter('Z')).and_then(|(zero, z)| {
        let [low, high] = machine.joints[z].travel?;
        let least = reaches.iter().map(|r| low + zero.z - r.gauge - r.tip[0]).fold(f64::NEG_INFINITY, f64::max);
        let most = reaches.iter().map(|r| high + zero.z - r.gauge - r.tip[1]).fold(f64::INFINITY, f64::min);
        Some([least, most])
    });
    match range {
        Some([least, most]) if wanted < least && least <= most => {
            let z = ((least + 10.0).min(most) / 10.0).ceil() * 10.0;
            let z = if z > most { least } else { z };
            let up = z + stock.min.z - table.z;
            (
                place(z),
                format!(
                    "assumed: the middle of the stock over the middle of the table; {up:.1} mm above it Z reaches every cut of every tool"
                ),
            )
        }
        Some([_, most]) if wanted > most && most + stock.min.z > table.z => (
            place(most.floor()),
            "assumed: the middle of the stock over the middle of the table, as high as Z can reach".into(),
        ),
        _ => (place(wanted), usual),
    }
}

/// Where the tilting axes of the table that a program turns meet the middle of the table: posts without tool
/// center point control count from there. None where none of them tilts it.
pub(crate) fn pivot(machine: &Machine, turned: &[char]) -> Option<Point> {
    let (point, normal) = (machine.table.point, machine.table.normal);
    let tilting = |&j: &usize| {
        let joint = &machine.joints[j];
        let named = turned.iter().any(|l| machine.joint_for_letter(*l) == Some(j));
        joint.is_rotary() && named && joint.direction.cross(&normal).norm() > 0.5
    };
    let joint = &machine.joints[*machine.work_chain.iter().find(|j| tilting(j))?];
    // The point of the line over the table that is nearest to the axis: both lines as p + t d.
    let (d, w) = (joint.direction, point - joint.point);
    let (b, e, f) = (normal.dot(&d), normal.dot(&w), d.dot(&w));
    let along = (b * f - e) / (1.0 - b * b);
    let at = point + normal * along;
    Some(at.map(to_micrometers))
}

/// The mounting that brings the axis of a bar into that of a rotary axis of the table that the program turns
/// and that lies along it, with its end in the plane of the table's middle; none where no such axis is there.
/// `base` is the middle of its end face.
pub(crate) fn about_its_axis(machine: &Machine, turned: &[char], base: [f64; 3], along: usize) -> Option<Point> {
    let joint = machine.work_chain.iter().map(|j| (*j, &machine.joints[*j])).find(|(j, joint)| {
        let named = turned.iter().any(|l| machine.joint_for_letter(*l) == Some(*j));
        joint.is_rotary() && named && joint.direction[along].abs() > 1.0 - SAME_DIRECTION
    });
    let (_, joint) = joint?;
    let mut at = joint.point - Vector::from(base);
    at[along] = machine.table.point[along] - base[along];
    Some(at.map(to_micrometers))
}

/// A mounting that was chosen, moved along X, Y and Z (those of `axes`) so that every position of the
/// programs lies in the travel, where the travel is long enough and all of it follows the mounting; else as
/// it is.
pub(crate) fn in_travel(
    machine: &Machine,
    mount: Reasoned<Vector>,
    axes: &str,
    follow: &dyn Fn(&Vector) -> Vec<Reading>,
) -> Reasoned<Vector> {
    // How far each axis is beyond its travel, with its sign.
    let beyond = |readings: &[Reading]| -> Option<Vector> {
        let mut shift = Vector::zeros();
        for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate().filter(|(_, l)| axes.contains(*l)) {
            let Some(j) = machine.joint_for_letter(letter) else { continue };
            let Some([least, most]) = machine.joints[j].travel else { continue };
            let range = readings.iter().filter_map(|r| r.joints.get(&j)).map(|[low, high]| [low.0, high.0]);
            let Some([low, high]) = range.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]) else { continue };
            if high - low > most - least {
                return None;
            }
            if low < least - PAST_TRAVEL {
                shift[i] = (least - low + BESIDE_LIMIT_MM).min(most - high);
            } else if high > most + PAST_TRAVEL {
                shift[i] = (most - high - BESIDE_LIMIT_MM).max(least - low);
            }
        }
        Some(shift)
    };
    let Some(shift) = beyond(&follow(&mount.value)).filter(|s| s.norm() > 0.0) else { return mount };
    let value = (mount.value + shift).map(to_micrometers);
    // Into the table nothing is moved; where tilted axes carry the part along, it may not help.
    let sinks = shift.z < 0.0;
    if sinks || beyond(&follow(&value)).is_none_or(|left| left.norm() > LEFT_MM) {
        return mount;
    }
    let moved: Vec<String> = ["X", "Y", "Z"]
        .iter()
        .zip(shift.iter())
        .filter(|(_, v)| **v != 0.0)
        .map(|(axis, v)| format!("{v:.1} mm along {axis}"))
        .collect();
    let reason = format!(
        "{}; moved by {}, so that every position of the program lies in the travel",
        mount.reason,
        moved.join(", ")
    );
    Reasoned { value, reason, ..mount }
}

/// Lowest and highest position of Z in motion of programs; none where no axis of this letter moves.
pub(crate) fn range_of_z(machine: &Machine, readings: &[Reading]) -> Option<[f64; 2]> {
    let z = machine.joint_for_letter('Z')?;
    let ranges = readings.iter().filter_map(|r| r.joints.get(&z)).map(|[low, high]| [low.0, high.0]);
    ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// How much a mount is lifted beyond what it needs, mm.
const ROOM_MM: f64 = 5.0;
/// Room for the motion between the ends that are followed, mm: a turn of some degrees far from the pivot asks
/// for a millimeter or two.
const BETWEEN_MM: f64 = 5.0;
/// Most times that a mount is shifted: on a table that tilts Z does not follow it in full.
const MOST_SHIFTS: usize = 4;

/// A mount at which Z stays within its travel in all motion, as long as a shift along Z achieves
/// it. `range` gives the range of Z at a mount.
pub(crate) fn lifted(
    machine: &Machine,
    mount: Reasoned<Vector>,
    range: &dyn Fn(&Vector) -> Option<[f64; 2]>,
) -> Reasoned<Vector> {
    let travel = machine.joint_for_letter('Z').and_then(|z| machine.joints[z].travel);
    let Some([least, most]) = travel else { return mount };
    let mut shifted = mount.value;
    for _ in 0..MOST_SHIFTS {
        let Some([low, high]) = range(&shifted) else { break };
        // Positions of the machine, as a retract to its upper end, stay where they are.
        if shifted != mount.value && high > most {
            break;
        }
        // The ends of motions are followed here, and not what lies between.
        let up = least + BETWEEN_MM - low;
        if up <= 0.0 {
            if shifted == mount.value {
                break;
            }
            let reason = format!(
                "{}; {:.0} mm higher, so that Z reaches every place of the program",
                mount.reason,
                shifted.z - mount.value.z
            );
            return Reasoned { value: shifted, reason, ..mount };
        }
        shifted.z = (shifted.z + up + ROOM_MM).ceil();
    }
    mount
}

/// How a design lies to what it is to be cut from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fit {
    /// As it is.
    Fits,
    /// It would 25.4 times larger: its numbers are inches.
    InInch,
    /// It lies elsewhere.
    Off,
}

/// Largest ratio of two sizes that count as those of the same part.
const SAME_SIZE: f64 = 3.0;

/// Compares the box of a design with the room of stock and cuts.
pub(crate) fn fit(design: &Aabb, room: &Aabb) -> Fit {
    let scaled = Aabb { min: design.min * 25.4, max: design.max * 25.4 };
    let like = |b: &Aabb| {
        let ratio = b.size().max() / room.size().max().max(LEAST_ROOM_MM);
        (1.0 / SAME_SIZE..=SAME_SIZE).contains(&ratio)
    };
    let meets = |b: &Aabb| b.expanded(1.0).intersects(room);
    // Above and below the part a tool is in air.
    let holds = |b: &Aabb| meets(b) && (0..2).all(|i| b.min[i] - 1.0 < room.min[i] && room.max[i] < b.max[i] + 1.0);
    let (own, other) = (design.size().max(), room.size().max());
    match (meets(design), like(design)) {
        (true, true) => Fit::Fits,
        _ if like(&scaled) && meets(&scaled) => Fit::InInch,
        // A hole in a large plate: no part is smaller than its cuts, and in inches it holds them.
        _ if own * 25.4 < LARGEST_TO_CUTS * other && holds(&scaled) => Fit::InInch,
        // No part is larger than what it is cut from, and none that a machine cuts has less than a
        // millimeter.
        (true, false) if own < SAME_SIZE * other && own >= LEAST_PART_MM => Fit::Fits,
        _ => Fit::Off,
    }
}

/// A design this many times larger than its cuts, if its numbers are read as inches, is not in inches:
/// it is in millimeters and a little smaller than its cuts.
const LARGEST_TO_CUTS: f64 = 5.0;
/// Largest edge below which no design is a part, mm.
const LEAST_PART_MM: f64 = 1.0;
/// Units that designs come in by mistake: factor to millimeters, and what its numbers are then.
const MISTAKEN: [(f64, &str); 4] = [
    (1000.0, "meters"),
    (10.0, "centimeters"),
    (0.1, "ten times too large"),
    (1.0 / 25.4, "25.4 times too large, converted from inches once too often"),
];

/// What the numbers of a design look like that is too small or too large for the room of its cuts; none where
/// no usual mistake explains it.
pub(crate) fn mistaken(design: &Aabb, room: &Aabb) -> Option<&'static str> {
    MISTAKEN.iter().find_map(|(factor, what)| {
        let scaled = Aabb { min: design.min * *factor, max: design.max * *factor };
        let ratio = scaled.size().max() / room.size().max().max(LEAST_ROOM_MM);
        ((1.0 / SAME_SIZE..=SAME_SIZE).contains(&ratio) && scaled.expanded(1.0).intersects(room)).then_some(*what)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
        Aabb { min: min.into(), max: max.into() }
    }

    #[test]
    fn the_stock_ends_where_tools_go_down_beside_it() {
        // Round a part of 100 x 60 mm with a cutter of 10 mm radius; it goes down at x = -25.
        let path = aabb([-25.0, -10.0, -8.0], [110.0, 70.0, -8.0]);
        let descents = [Point::new(-25.0, 0.0, -7.0)];
        let contour = Swept {
            radius: 10.0,
            faces: false,
            sideways: path,
            feed: path,
            level: Some(-8.0),
            descents: &descents,
            tilted: false,
        };
        let (stock, how) = propose_stock(&[contour]).expect("motion");
        assert_eq!((stock.min.x, stock.max.z, stock.min.z), (-15.0, 0.0, -9.0));
        assert!(how.contains("1 places"), "{how}");
        // The other sides: reach of the cutter and the allowance.
        assert_eq!((stock.max.x, stock.min.y, stock.max.y), (125.0, -25.0, 85.0));
        assert!(propose_stock(&[]).is_none());
        // A drill of 5 mm radius 30 mm deep at x = 120 and -20.
        let holes = aabb([-20.0, 10.0, -30.0], [120.0, 50.0, 2.0]);
        let drill = Swept {
            radius: 5.0,
            faces: false,
            sideways: Aabb::empty(),
            feed: holes,
            level: None,
            descents: &[],
            tilted: false,
        };
        let (stock, _) = propose_stock(&[contour, drill]).expect("motion");
        assert_eq!((stock.min.x, stock.max.x, stock.min.z, stock.max.z), (-30.0, 130.0, -27.0, 0.0));
    }

    #[test]
    fn a_table_that_is_tilted_is_counted_from_its_pivot() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/bc-trunnion");
        let machine = Machine::read(&folder).expect("library machine");
        // B lies 80 mm above the clamping surface, over its middle.
        assert_eq!(pivot(&machine, &['B', 'C']), Some(Point::new(0.0, 0.0, 80.0)));
        assert_eq!(pivot(&machine, &['C']), None, "turning about the normal has no height");
    }

    #[test]
    fn a_part_with_a_design_has_a_stock_of_its_size() {
        let own = aabb([-30.0, -20.0, -40.0], [30.0, 20.0, 0.0]);
        let mill = |sideways: Aabb| Swept {
            radius: 5.0,
            faces: false,
            sideways,
            feed: sideways,
            level: Some(sideways.max.z),
            descents: &[],
            tilted: false,
        };
        // The way in and out, and passes next to the part, are no material.
        for slot in [
            aabb([-40.0, 0.0, -5.0], [40.0, 0.0, -5.0]),
            aabb([-60.0, -50.0, -40.0], [60.0, 50.0, -5.0]),
            aabb([60.0, 60.0, 2.0], [90.0, 90.0, 2.0]),
        ] {
            assert_eq!(stock_of_design(&own, &[mill(slot)]), (own, "the box of the design".to_owned()));
        }
        // What is faced off lies above it.
        let face = mill(aabb([-40.0, -20.0, 0.0], [40.0, 20.0, 2.0]));
        let (stock, how) = stock_of_design(&own, &[mill(aabb([-40.0, 0.0, -5.0], [40.0, 0.0, -5.0])), face]);
        assert_eq!((stock.min, stock.max.z), (own.min, 3.0), "{how}");
    }

    #[test]
    fn a_ramp_tells_no_top_and_a_faced_zero_lies_below_it() {
        let box_of = |low: f64, high: f64| aabb([0.0, 0.0, low], [100.0, 60.0, high]);
        let mill = |low: f64, high: f64, level: f64, faces: bool, descents| Swept {
            radius: 5.0,
            faces,
            sideways: box_of(low, high),
            feed: box_of(low, high + 3.0),
            level: Some(level),
            descents,
            tilted: false,
        };
        let top = |tools: &[Swept<'_>]| propose_stock(tools).expect("motion").0.max.z;
        // A helix from 2 mm above the zero down to a floor at -12.
        assert_eq!(top(&[mill(-12.0, 2.0, -12.0, false, &[])]), 0.0);
        assert_eq!(top(&[mill(-12.0, 2.0, -12.0, false, &[]), mill(0.0, 0.0, 0.0, true, &[])]), 1.0);
        assert_eq!(top(&[mill(-12.0, 0.0, 0.0, false, &[])]), 0.0, "an end mill at the zero may run in air");
        // The zero at the bottom.
        assert_eq!(top(&[mill(1.0, 20.0, 12.0, false, &[])]), 21.0);
        // A drill that pecks in its hole says nothing of the sides.
        let holes = aabb([10.0, 10.0, -20.0], [90.0, 50.0, 2.0]);
        let pecks = [Point::new(10.0, 10.0, -6.0)];
        let drill = Swept { sideways: Aabb::empty(), feed: holes, level: None, ..mill(0.0, 0.0, 0.0, false, &pecks) };
        let (with, how) = propose_stock(&[mill(-12.0, 0.0, 0.0, false, &[]), drill]).expect("motion");
        assert!((with.min.x, with.min.y) == (-10.0, -10.0) && how.contains("5 mm more"), "{with:?} {how}");
        // Alone it begins in air, and a point at its R plane is no side.
        let at_r = [Point::new(10.0, 10.0, 2.0), Point::new(10.0, 10.0, -6.0), Point::new(90.0, 50.0, 2.0)];
        let (alone, _) = propose_stock(&[Swept { descents: &at_r, ..drill }]).expect("motion");
        assert_eq!((alone.max.z, alone.min.x, alone.max.y), (0.0, 0.0, 60.0));
        let low = Swept { feed: aabb([10.0, 10.0, -40.0], [90.0, 50.0, -8.0]), ..drill };
        assert_eq!(top(&[low]), -9.0, "a milled face below the zero");
    }

    #[test]
    fn inches_are_distinguished_from_a_part_that_is_elsewhere() {
        let room = aabb([0.0, 0.0, -20.0], [101.6, 76.2, 0.0]);
        assert_eq!(fit(&aabb([0.0, 0.0, -0.75], [4.0, 3.0, 0.0]), &room), Fit::InInch);
        assert_eq!(fit(&aabb([1.0, 1.0, -19.0], [100.0, 75.0, 0.0]), &room), Fit::Fits);
        assert_eq!(fit(&aabb([500.0, 0.0, -19.0], [600.0, 75.0, 0.0]), &room), Fit::Off);
        // A hole of 16 mm in a plate of 2 x 2 x 0.5 inch.
        let hole = aabb([17.0, 17.0, -15.0], [34.0, 34.0, 2.5]);
        assert_eq!(fit(&aabb([0.0, 0.0, -0.5], [2.0, 2.0, 0.0]), &hole), Fit::InInch);
        assert_eq!(fit(&aabb([0.0, 0.0, -12.7], [50.8, 50.8, 0.0]), &hole), Fit::Fits);
        // Meters, and ten times too large.
        for (factor, word) in [(1e-3, "meters"), (10.0, "ten times too large")] {
            let off = aabb([0.0, 0.0, -20.0 * factor], [100.0 * factor, 75.0 * factor, 0.0]);
            assert_eq!((fit(&off, &room), mistaken(&off, &room)), (Fit::Off, Some(word)));
        }
        // A small part of a large plate is no inch.
        assert_eq!(fit(&aabb([10.0, 10.0, -5.0], [30.0, 25.0, 0.0]), &room), Fit::Fits);
    }
}
