//! Families of faults. Each case comes twice from the same numbers: with the fault, and clean.
//!
//! Every fault is known by construction: the overlap of a flat end mill with a block is a box, a disc or a
//! circular segment of stated size. A clean twin keeps at least 0.02 mm away, or moves only where it has cut
//! before.

use proveout_geom::TriMesh;

use crate::injection::{
    random::Random,
    shop::{Case, EndMill, Moves, Stock},
    solids::{convex_bar, grid_solid},
};

/// Number of families; case `n` is of family `n` modulo this.
pub(crate) const FAMILIES: usize = 16;

const ABOVE_MM: f64 = 20.0;
/// The smallest overlap of a fault, and the smallest room of a clean twin, mm; a touch up to 0.01 mm is no
/// cut.
const LEAST_MM: f64 = 0.025;

/// Case `number` with its fault, or clean.
pub(crate) fn case(number: usize, fault: bool) -> Case {
    let r = &mut Random::new(number as u64);
    match number % FAMILIES {
        0 => edge(r, fault, Edge::Rapid),
        1 => edge(r, fault, Edge::SpindleOff),
        2 => edge(r, fault, Edge::Shank),
        3 => edge(r, fault, Edge::Holder),
        4 => thin_tool(r, fault),
        5 => faced_then_rapid(r, fault),
        6 => slot_then_sideways(r, fault),
        7 => rib(r, fault, false),
        8 => rib(r, fault, true),
        9 => gouged_edge(r, fault),
        10 => uncut(r, fault, Hollow::Slot),
        11 => uncut(r, fault, Hollow::Pocket),
        12 => uncut(r, fault, Hollow::Cavity),
        13 => uncut(r, fault, Hollow::Chamfer),
        14 => clamp(r, fault),
        _ => thin_stock(r, fault),
    }
}

/// Half lengths and height of a block, mm.
fn block(r: &mut Random, height: f64) -> [f64; 3] {
    [r.between(9.0, 14.0), r.between(7.0, 11.0), height + r.between(0.0, 3.0)]
}

/// No turn as often as any.
fn turn(r: &mut Random) -> f64 {
    let angle = r.between(1.0, 89.0);
    if r.coin() { angle } else { 0.0 }
}

fn mill(diameter: f64) -> EndMill {
    EndMill { diameter, flutes: 20.0, shank: diameter, out_of_holder: 45.0 }
}

fn empty(family: &'static str, gates: &'static [&'static str], size_mm: f64, turn_deg: f64) -> Case {
    Case {
        family,
        gates,
        size_mm,
        stock: Stock::Block([10.0; 3]),
        design: None,
        turn_deg,
        tool: mill(10.0),
        clamp: None,
        moves: Moves::turned_by(turn_deg),
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Edge {
    Rapid,
    SpindleOff,
    Shank,
    Holder,
}

/// A part of the tool runs along the upper edge of the block and overlaps it by a strip of `width` x `depth`.
fn edge(r: &mut Random, fault: bool, kind: Edge) -> Case {
    let [x, y, height] = block(r, if kind == Edge::Holder { 45.0 } else { 14.0 });
    let (width, depth) = (r.log(LEAST_MM, 2.0), r.log(LEAST_MM, 2.0));
    let turn_deg = turn(r);
    let diameter = r.between(3.0, 12.0);
    let (above, room) = (r.coin(), r.log(LEAST_MM, 2.0));
    let (family, gates): (_, &[&str]) = match kind {
        Edge::Rapid => ("rapid along an edge", &["process"]),
        Edge::SpindleOff => ("standing spindle along an edge", &["process"]),
        Edge::Shank => ("shank along an edge", &["process"]),
        Edge::Holder => ("holder along an edge", &["collision"]),
    };
    let (tool, radius, up) = match kind {
        Edge::Rapid | Edge::SpindleOff => (mill(diameter), 0.5 * diameter, 0.0),
        Edge::Shank => (EndMill { diameter: 4.0, flutes: 8.0, shank: 14.0, out_of_holder: 45.0 }, 7.0, 8.0),
        Edge::Holder => (EndMill { out_of_holder: 42.0, ..mill(diameter) }, 20.0, 42.0),
    };
    let mut case =
        Case { stock: Stock::Block([x, y, height]), tool, ..empty(family, gates, width.min(depth), turn_deg) };
    let (side, z) = match (fault, above) {
        (true, _) => (y + radius - width, -depth),
        (false, true) => (y + radius - width, room),
        (false, false) => (y + radius + room, -depth),
    };
    let far = x + radius + 3.0;
    let spindle = if kind == Edge::SpindleOff { "M5" } else { "S3000 M3" };
    let go = if kind == Edge::Rapid { "G0" } else { "G1 F2000" };
    case.moves.words(spindle).plane("G0", -far, side).height("G0", ABOVE_MM);
    case.moves.height("G0", z - up).plane(go, far, side).height("G0", ABOVE_MM);
    case
}

/// A tool goes straight down into the block at rapid; clean, it has gone there in feed before.
fn thin_tool(r: &mut Random, fault: bool) -> Case {
    let [x, y, height] = block(r, 12.0);
    let (diameter, depth) = (r.log(0.3, 6.0), r.log(0.05, 5.0));
    let (at_x, at_y) = (r.between(-0.7, 0.7) * x, r.between(-0.6, 0.6) * y);
    let size = diameter.min(depth);
    let mut case = Case {
        stock: Stock::Block([x, y, height]),
        tool: EndMill { flutes: 12.0, ..mill(diameter) },
        ..empty("rapid down between the rays", &["process"], size, 0.0)
    };
    case.moves.words("S3000 M3").plane("G0", at_x, at_y).height("G0", ABOVE_MM);
    if !fault {
        case.moves.height("G1 F500", -depth).height("G0", ABOVE_MM);
    }
    case.moves.height("G0", -depth).height("G0", ABOVE_MM);
    case
}

/// The top is faced in feed; then the cutter runs back at rapid along the finished edge.
fn faced_then_rapid(r: &mut Random, fault: bool) -> Case {
    let [x, y, height] = block(r, 12.0);
    let (width, depth) = (r.log(LEAST_MM, 1.5), r.log(LEAST_MM, 1.5));
    let (faced, room, above) = (r.between(0.3, 2.0), r.log(LEAST_MM, 1.0), r.coin());
    let turn_deg = turn(r);
    let mut case = Case {
        stock: Stock::Block([x, y, height]),
        tool: mill(12.0),
        ..empty("rapid along a finished edge", &["process"], width.min(depth), turn_deg)
    };
    let far = x + 9.0;
    case.moves.words("S3000 M3").plane("G0", -far, -y).height("G0", ABOVE_MM).height("G0", -faced);
    for pass in 0..4 {
        let at = -y + f64::from(pass) * 2.0 * y / 3.0;
        let ends = if pass % 2 == 0 { [-far, far] } else { [far, -far] };
        case.moves.plane("G1 F3000", ends[0], at).plane("G1", ends[1], at);
    }
    let (side, z) = match (fault, above) {
        (true, _) => (y + 6.0 - width, -faced - depth),
        (false, true) => (y + 6.0 - width, -faced + room),
        (false, false) => (y + 6.0 + room, -faced - depth),
    };
    case.moves.height("G0", ABOVE_MM).plane("G0", -far, side).height("G0", z).plane("G0", far, side);
    case.moves.height("G0", ABOVE_MM);
    case
}

/// A slot is cut to the middle of the block; then the tool leaves it straight up, or goes into its wall at
/// rapid first.
fn slot_then_sideways(r: &mut Random, fault: bool) -> Case {
    let [x, y, height] = block(r, 12.0);
    let (width, depth) = (r.log(LEAST_MM, 1.5), r.between(0.5, 6.0));
    let turn_deg = turn(r);
    let mut case = Case {
        stock: Stock::Block([x, y, height]),
        tool: mill(8.0),
        ..empty("rapid into the wall of a slot", &["process"], width, turn_deg)
    };
    let far = x + 7.0;
    case.moves.words("S3000 M3").plane("G0", -far, 0.0).height("G0", ABOVE_MM).height("G0", -depth);
    case.moves.plane("G1 F2000", 0.0, 0.0);
    if fault {
        case.moves.plane("G0", 0.0, width);
    }
    case.moves.height("G0", ABOVE_MM);
    case
}

/// A raw part with a thin rib, or a thin pin, on its top; the cutter runs across it at rapid.
fn rib(r: &mut Random, fault: bool, pin: bool) -> Case {
    let [x, y, height] = block(r, 12.0);
    let (thick, tall) = (r.log(0.1, 3.0), r.between(2.0, 6.0));
    let (long, at_x, at_y) = (r.log(0.1, 3.0), r.between(-0.5, 0.5) * x, r.between(-0.4, 0.4) * y);
    let room = r.log(LEAST_MM, 2.0);
    let turn_deg = turn(r);
    let xs = if pin { vec![-x, at_x, at_x + long, x] } else { vec![-x, x] };
    let raised = usize::from(pin);
    let solid = grid_solid([&xs, &[-y, at_y, at_y + thick, y], &[-height, 0.0, tall]], |[i, j, k]| {
        k == 0 || (j == 1 && i == raised)
    });
    let (family, size) = if pin { ("rapid through a pin", thick.min(long)) } else { ("rapid through a rib", thick) };
    let mut case = Case { stock: Stock::Mesh(solid), ..empty(family, &["process"], size, turn_deg) };
    let (far, z) = (y + 8.0, if fault { 0.5 * tall } else { tall + room });
    case.moves.words("S3000 M3").plane("G0", at_x + 0.5 * long, -far).height("G0", ABOVE_MM);
    case.moves.height("G0", z).plane("G0", at_x + 0.5 * long, far).height("G0", ABOVE_MM);
    case
}

/// The raw block is the design; a cutter in feed takes a strip off one edge.
fn gouged_edge(r: &mut Random, fault: bool) -> Case {
    let [x, y, height] = block(r, 12.0);
    let (width, depth) = (r.log(0.03, 2.0), r.log(0.03, 2.0));
    let (long, room, above) = (r.log(0.4, 10.0), r.log(LEAST_MM, 1.0), r.coin());
    let turn_deg = turn(r);
    let mut case = Case {
        stock: Stock::Block([x, y, height]),
        design: Some(plain([x, y, height])),
        ..empty("gouge along an edge", &["gouge"], width.min(depth), turn_deg)
    };
    let (side, z) = match (fault, above) {
        (true, _) => (y + 5.0 - width, -depth),
        (false, true) => (y + 5.0 - width, room),
        (false, false) => (y + 5.0 + room, -depth),
    };
    let start = -0.5 * long;
    case.moves.words("S3000 M3").plane("G0", start, y + 9.0).height("G0", ABOVE_MM).height("G0", z);
    case.moves.plane("G1 F2000", start, side).plane("G1", start + long, side).plane("G1", start + long, y + 9.0);
    case.moves.height("G0", ABOVE_MM);
    case
}

fn plain([x, y, height]: [f64; 3]) -> TriMesh {
    grid_solid([&[-x, x], &[-y, y], &[-height, 0.0]], |_| true)
}

#[derive(Clone, Copy)]
enum Hollow {
    Slot,
    Pocket,
    Cavity,
    Chamfer,
}

/// The design has a hollow or a chamfer that no motion cuts; the clean design is the raw block.
fn uncut(r: &mut Random, fault: bool, kind: Hollow) -> Case {
    let [x, y, height] = block(r, 12.0);
    let (width, depth, long) = (r.log(0.08, 3.0), r.log(0.08, 3.0), r.log(0.08, 3.0));
    let (at_x, at_y, at_z) = (r.between(-0.6, 0.4) * x, r.between(-0.6, 0.4) * y, -r.between(4.0, 8.0));
    let turn_deg = turn(r);
    let (xs, ys) = ([-x, at_x, at_x + long, x], [-y, at_y, at_y + width, y]);
    let (family, size, hollow) = match kind {
        Hollow::Slot => (
            "slot left full",
            width.min(depth),
            grid_solid([&[-x, x], &ys, &[-height, -depth, 0.0]], |[_, j, k]| !(j == 1 && k == 1)),
        ),
        Hollow::Pocket => (
            "pocket left full",
            width.min(depth).min(long),
            grid_solid([&xs, &ys, &[-height, -depth, 0.0]], |i| i != [1, 1, 1]),
        ),
        Hollow::Cavity => (
            "cavity left full",
            width.min(depth).min(long),
            grid_solid([&xs, &ys, &[-height, at_z, at_z + depth, 0.0]], |i| i != [1, 1, 1]),
        ),
        Hollow::Chamfer => {
            let section = [[-y, -height], [y, -height], [y, -depth], [y - depth, 0.0], [-y, 0.0]];
            ("chamfer left sharp", depth / 2.0_f64.sqrt(), convex_bar(-x, x, &section))
        }
    };
    let design = if fault { hollow } else { plain([x, y, height]) };
    let mut case = Case {
        stock: Stock::Block([x, y, height]),
        design: Some(design),
        ..empty(family, &["excess"], size, turn_deg)
    };
    case.moves.words("S3000 M3").plane("G0", -x, 0.0).height("G0", ABOVE_MM).height("G0", 5.0);
    case.moves.plane("G1 F2000", x, 0.0).height("G0", ABOVE_MM);
    case
}

/// The cutter runs past a clamp next to the part, or into it.
fn clamp(r: &mut Random, fault: bool) -> Case {
    let [x, y, height] = block(r, 12.0);
    let (overlap, room) = (r.log(LEAST_MM, 3.0), r.log(LEAST_MM, 1.0));
    let (near, top) = (y + r.between(4.0, 8.0), r.between(2.0, 9.0));
    let mut case = Case {
        stock: Stock::Block([x, y, height]),
        clamp: Some([[-4.0, near, -height], [4.0, near + 12.0, top]]),
        ..empty("rapid into a clamp", &["collision"], overlap, 0.0)
    };
    let z = if fault { top - overlap } else { top + room };
    case.moves.words("S3000 M3").plane("G0", -x - 10.0, near + 6.0).height("G0", ABOVE_MM).height("G0", z);
    case.moves.plane("G0", x + 10.0, near + 6.0).height("G0", ABOVE_MM);
    case
}

/// A raw part that may be thinner than the cells.
fn thin_stock(r: &mut Random, fault: bool) -> Case {
    let (thick, tall) = (r.log(0.05, 3.0), r.log(0.3, 6.0));
    let room = r.log(LEAST_MM, 2.0);
    let size = thick.min(0.5 * tall);
    let mut case = Case {
        stock: Stock::Block([12.0, 0.5 * thick, tall]),
        ..empty("rapid through thin stock", &["process"], size, 0.0)
    };
    let z = if fault { -0.5 * tall } else { room };
    case.moves.words("S3000 M3").plane("G0", 0.0, -12.0).height("G0", ABOVE_MM).height("G0", z);
    case.moves.plane("G0", 0.0, 12.0).height("G0", ABOVE_MM);
    case
}
