//! The cycles of a Heidenhain TNC: which Q parameters each takes, and what these are.
//!
//! After HEIDENHAIN, *TNC 640 Programming of machining cycles* (34059x); 210 to 215, 230 and 231 after *iTNC
//! 530 cycles*. The first list of a cycle are the parameters that the control writes into its definition: a
//! milling cycle without one of them is refused there. The second list are those that may be left out.

use super::{CycleSpec, Key, Parameter, Unit, Usual};
use Unit::{Feed, Length, Number};

/// A Q parameter of cycles.
pub(crate) const fn parameter(number: u32) -> Parameter {
    let (unit, name, usual) = match number {
        200 => (Length, "set-up clearance", None),
        201 => (Length, "depth", None),
        202 => (Length, "infeed", Some(0.0)),
        203 => (Length, "surface", Some(0.0)),
        204 => (Length, "second set-up clearance", Some(0.0)),
        205 => (Length, "least infeed", Some(0.0)),
        206 => (Feed, "feed of the infeed", None),
        207 => (Feed, "feed of milling", None),
        208 => (Feed, "feed of retraction", None),
        209 => (Feed, "feed across", None),
        210 => (Number, "dwell at the top", Some(0.0)),
        211 => (Number, "dwell at the depth", Some(0.0)),
        212 => (Length, "decrement of the infeed", Some(0.0)),
        213 => (Number, "chip breaks before a retraction", Some(0.0)),
        214 => (Number, "direction off the wall", Some(0.0)),
        215 => (Number, "machining operation", Some(0.0)),
        216 => (Length, "center in the first axis", None),
        217 => (Length, "center in the second axis", None),
        218 => (Length, "first side", None),
        219 => (Length, "second side", None),
        220 => (Length, "corner radius", Some(0.0)),
        221 => (Length, "allowance in the first axis", Some(0.0)),
        222 => (Length, "diameter of the blank", None),
        223 => (Length, "diameter", None),
        224 => (Number, "angle of rotation", Some(0.0)),
        225 => (Length, "start in the first axis", None),
        226 => (Length, "start in the second axis", None),
        227 => (Length, "start in the third axis", None),
        228..=236 => (Length, "coordinate of a corner", None),
        237 => (Length, "spacing in the first axis", None),
        238 => (Length, "spacing in the second axis", None),
        239 => (Length, "pitch", None),
        240 => (Number, "number of lines", None),
        241 => (Number, "number of holes", None),
        242 => (Number, "number of columns", None),
        243 => (Number, "number of rows", None),
        244 => (Length, "diameter of the pitch circle", None),
        245 => (Number, "starting angle", None),
        246 => (Number, "stopping angle", Some(360.0)),
        247 => (Number, "stepping angle", Some(0.0)),
        248 => (Number, "opening angle", None),
        249 => (Length, "depth of the counterbore", None),
        250 => (Length, "thickness of the material", None),
        251 => (Length, "displacement of the bar", None),
        252 => (Length, "height of the edge", None),
        253 => (Feed, "feed of positioning", None),
        254 => (Feed, "feed of countersinking", None),
        255 => (Number, "dwell in the counterbore", Some(0.0)),
        256 => (Length, "retraction of chip breaking", Some(0.2)),
        257 => (Length, "depth of chip breaking", Some(0.0)),
        258 => (Length, "stop above the first depth", Some(0.2)),
        259 => (Length, "stop above the last depth", Some(0.2)),
        301 => (Number, "height between the holes", Some(1.0)),
        334 => (Length, "pitch of the helix", None),
        335 => (Length, "nominal diameter", None),
        336 => (Number, "angle of the spindle", Some(0.0)),
        338 => (Length, "infeed of finishing", Some(0.0)),
        339 => (Number, "row of the preset table", None),
        342 => (Length, "diameter roughed before", Some(0.0)),
        350 => (Number, "direction of milling", Some(1.0)),
        351 => (Number, "climb or up-cut", Some(1.0)),
        355 => (Number, "threads in a step", None),
        356 => (Length, "depth of the hole", None),
        357 => (Length, "clearance to the side", None),
        358 => (Length, "depth of the countersink", Some(0.0)),
        359 => (Length, "offset of the countersink", Some(0.0)),
        360 => (Number, "countersink after the thread", Some(0.0)),
        365 => (Number, "way between the holes", Some(0.0)),
        366 => (Number, "plunging", Some(0.0)),
        367 => (Number, "position of the tool", Some(0.0)),
        368 => (Length, "allowance of the wall", Some(0.0)),
        369 => (Length, "allowance of the base", Some(0.0)),
        370 => (Number, "overlap factor", Some(1.0)),
        374 => (Number, "angle of the slot", None),
        375 => (Length, "diameter of the pitch circle", None),
        376 => (Number, "starting angle", None),
        377 => (Number, "number of slots", None),
        378 => (Number, "stepping angle", None),
        379 => (Length, "deepened start", Some(0.0)),
        385 => (Feed, "feed of finishing", None),
        386 => (Length, "end in the third axis", None),
        389 => (Number, "strategy", Some(0.0)),
        424 => (Length, "first side of the blank", None),
        425 => (Length, "second side of the blank", None),
        426 => (Number, "direction of the spindle", Some(5.0)),
        427 => (Number, "speed in and out", Some(0.0)),
        428 => (Number, "speed of drilling", Some(0.0)),
        437 => (Number, "approach", Some(0.0)),
        439 => (Number, "reference of the feed", Some(3.0)),
        _ => (Number, "", Some(0.0)),
    };
    let usual = match usual {
        Some(value) => Usual::Value(value),
        None => Usual::None,
    };
    Parameter { key: Key::Q(number), name, unit, what: "", usual, written: false }
}

const fn parameters<const N: usize>(numbers: [u32; N], needed: usize) -> [Parameter; N] {
    let mut list = [parameter(0); N];
    let mut at = 0;
    while at < N {
        list[at] = parameter(numbers[at]);
        list[at].written = at < needed;
        at += 1;
    }
    list
}

const HELIX: &str = "the helix begins at the set-up clearance and ends with a full circle at the depth; leads are half circles; \
                     without Q370 a hole that is roughed before (Q342) is made by one helix";
const THREAD: &str = "the tool comes onto the thread and leaves it on half circles that rise by half a pitch; all turns (Q355=1) run \
                      between the depth and the surface";
const LEADS: &str = "the tool comes onto the thread and leaves it on half circles that rise or fall by half a pitch; countersinking \
                     runs the way of the thread, with Q254 from the middle on";
const WALL: &str = "the wall is finished from the center, or from outside the stud, on arcs of the tool radius, with equal infeeds \
                    Q202";
const SLOT: &str = "the slot is cleared by rings of one tool radius and a plunge to and fro at 3 degrees";
const LINES: &str = "the tool center runs along both edges of the width (Q226 and Q226 + Q219), and goes beyond the length by its \
                     radius";
const RULED: &str = "the middle of the tool runs along the surface; the ways to the first point, down to a line and over to the next \
                     one are in Q207";
const FACE: &str = "passes lie symmetrically over the width Q219; rounded inserts (R2) do not lower the overlap; in the working plane \
                    the tool moves to the first pass at rapid rate";
const FACE_233: &str = "without Q367 the surface begins at the tool, to the sides of the signs of Q218 and Q219; passes lie \
                        symmetrically over its width; the tool goes back to the first pass Q200 above the depth";
const RINGS: &str = "rings from the inside out, joined by straight lines; plunging with Q366 at 3 degrees (ANGLE of the tool table is \
                     not read); leads of at most the tool radius";
const STUD: &str = "revolutions from the blank inwards, joined by straight lines; the tool plunges to the right of the blank (Q437=0) \
                    and comes onto each depth on a half circle";

macro_rules! cycles {
    ($($cycle:ident = $title:literal [$($needed:literal),*] [$($may:literal),*] $($assumed:ident)?;)*) => {
        $(
            pub(crate) static $cycle: CycleSpec = CycleSpec {
                name: $title,
                parameters: &parameters([$($needed,)* $($may,)*], [0u32, $($needed),*].len() - 1),
                assumed: [$(Some($assumed),)? None][0],
            };
        )*
        /// Every cycle.
        pub(crate) static ALL: &[&CycleSpec] = &[$(&$cycle),*];
    };
}

cycles! {
    C1 = "1" [] [200, 201, 202, 211, 206];
    C2 = "2" [] [200, 201, 211, 206];
    C4 = "4" [] [200, 201, 202, 206, 207, 351, 218, 219, 220];
    C5 = "5" [] [200, 201, 202, 206, 207, 351, 223];
    C17 = "17" [] [200, 201, 239];
    C200 = "200" [] [200, 201, 206, 202, 210, 203, 204, 211];
    C201 = "201" [] [200, 201, 206, 211, 208, 203, 204];
    C202 = "202" [] [200, 201, 206, 211, 208, 203, 204, 214, 336];
    C203 = "203" [] [200, 201, 206, 202, 210, 203, 204, 212, 213, 205, 211, 208, 256];
    C204 = "204" [] [200, 249, 250, 251, 252, 253, 254, 255, 203, 204, 214, 336];
    C205 = "205" [] [200, 201, 206, 202, 203, 204, 212, 205, 258, 259, 257, 256, 211, 379, 253, 208];
    C206 = "206" [] [200, 201, 206, 211, 203, 204];
    C207 = "207" [] [200, 201, 239, 203, 204];
    C208 = "208" [200, 201, 206, 334, 203, 204, 335] [342, 351, 370, 439] HELIX;
    C209 = "209" [] [200, 201, 239, 203, 204, 257, 256];
    C210 = "210" [200, 201, 207, 202, 215, 203, 204, 216, 217, 218, 219, 224] [206, 338] SLOT;
    C211 = "211" [200, 201, 207, 202, 215, 203, 204, 216, 217, 244, 219, 245, 248] [206, 338] SLOT;
    C212 = "212" [200, 201, 206, 202, 207, 203, 204, 216, 217, 218, 219] [220, 221] WALL;
    C213 = "213" [200, 201, 206, 202, 207, 203, 204, 216, 217, 218, 219] [220, 221] WALL;
    C214 = "214" [200, 201, 206, 202, 207, 203, 204, 216, 217, 222, 223] [] WALL;
    C215 = "215" [200, 201, 206, 202, 207, 203, 204, 216, 217, 222, 223] [] WALL;
    C220 = "220" [] [216, 217, 244, 245, 246, 247, 241, 200, 203, 204, 301, 365];
    C221 = "221" [] [225, 226, 237, 238, 242, 243, 224, 200, 203, 204, 301];
    C230 = "230" [225, 226, 227, 218, 219, 240, 206, 207, 209, 200] [] LINES;
    C231 = "231" [225, 226, 227, 228, 229, 230, 231, 232, 233, 234, 235, 236, 240, 207] [] RULED;
    C232 = "232" [389, 225, 226, 227, 386, 218, 219, 202, 369, 370, 207, 385, 253, 200, 357, 204] [] FACE;
    C233 = "233" [215, 389, 350, 218, 219, 227, 386, 369, 202, 370, 207, 385, 253, 357, 200, 204] [367] FACE_233;
    C240 = "240" [] [200, 201, 206, 211, 203, 204];
    C241 = "241" [] [200, 201, 206, 211, 203, 204, 379, 253, 208, 426, 427, 428, 429, 430];
    C247 = "247" [] [339];
    C251 = "251" [215, 218, 219, 220, 368, 224, 367, 207, 351, 201, 202, 369, 206, 338, 200, 203, 204, 370, 366] [385, 439] RINGS;
    C252 = "252" [215, 223, 368, 207, 351, 201, 202, 369, 206, 338, 200, 203, 204, 370, 366] [385, 439] RINGS;
    C253 = "253" [215, 218, 219, 368, 374, 367, 207, 351, 201, 202, 369, 206, 338, 200, 203, 204, 366] [385, 439] RINGS;
    C254 = "254" [215, 219, 368, 375, 367, 216, 217, 376, 248, 378, 377, 207, 351, 201, 202, 369, 206, 338, 200, 203, 204, 366]
        [385, 439] RINGS;
    C256 = "256" [218, 424, 219, 425, 220, 368, 224, 367, 207, 351, 201, 202, 206, 200, 203, 204, 370] [215, 369, 385, 437, 439]
        STUD;
    C257 = "257" [223, 222, 368, 207, 351, 201, 202, 206, 200, 203, 204, 370] [215, 369, 376, 385, 439] STUD;
    C262 = "262" [335, 239, 201, 355, 253, 351, 200, 203, 204, 207] [439] THREAD;
    C263 = "263" [335, 239, 201, 356, 253, 351, 200, 357, 358, 359, 203, 204, 254, 207] [439] LEADS;
    C264 = "264" [335, 239, 201, 356, 253, 351, 202, 258, 257, 256, 358, 359, 200, 203, 204, 206, 207] [439] LEADS;
    C265 = "265" [335, 239, 201, 253, 358, 359, 360, 200, 203, 204, 254, 207] [439] LEADS;
}

/// The cycle of this number that is defined with Q parameters.
pub(crate) fn spec(number: u32) -> Option<&'static CycleSpec> {
    let name = number.to_string();
    ALL.iter().copied().find(|spec| spec.name == name)
}

/// Parameters of a cycle that must be zero, with what to do instead.
pub(crate) fn zeros(cycle: &str) -> &'static [(u32, &'static str)] {
    const SIDE_WALL: &str = "a side wall limits the surface: mill a pocket or a stud";
    match cycle {
        "233" => &[(347, SIDE_WALL), (348, SIDE_WALL), (349, SIDE_WALL)],
        "263" => &[(356, "countersink the hole with a cycle of its own, and write Q356=0")],
        "264" => &[
            (257, "write Q257=0: the tool comes out between the infeeds"),
            (358, "countersink with a cycle of its own, and write Q358=0"),
        ],
        _ => &[],
    }
}
