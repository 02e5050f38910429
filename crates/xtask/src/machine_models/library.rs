//! The machines of `machines/`, put together from structures, heads and tables.

use crate::{
    TaskError,
    machine_models::{
        c_frame::CFrame,
        gantry::Gantry,
        home_zero, hybrid, kinds,
        numbers::KinematicNumbers,
        part::MachinePart,
        singles,
        spindle_heads::{Fork, Spindle, fork, nutating, spindle},
        work::{Trunnion, fixed_table, rotary_table},
    },
};

/// Makes the parts of one machine.
pub(crate) type Build = fn(&KinematicNumbers) -> Result<Vec<MachinePart>, TaskError>;

/// Folder and maker of each machine.
pub(crate) const LIBRARY: &[(&str, Build)] = &[
    ("bc-head-table-grinder", grinder),
    ("bc-head-table-home-zero", |numbers| home_zero::parts(numbers, grinder)),
    ("bc-trunnion", bc_trunnion),
    ("bc-trunnion-home-zero", |numbers| home_zero::parts(numbers, bc_trunnion)),
    ("dmu-50-type", kinds::dmu_50),
    ("dmu-65-type", kinds::dmu_65),
    ("fork-head-gantry", fork_head_gantry),
    ("fork-head-home-zero", |numbers| home_zero::parts(numbers, fork_head_gantry)),
    ("haas-umc-750", |numbers| home_zero::parts(numbers, kinds::umc_750)),
    ("haas-vf-2-tr160", |numbers| home_zero::parts(numbers, kinds::vf_2)),
    ("hermle-c42-type", kinds::hermle_c42),
    ("hurco-vmx42-sr-type", kinds::hurco_vmx42),
    ("jdgr200t", jdgr200t),
    ("linuxcnc-bridge-mill", bridge_mill),
    ("linuxcnc-xyzac-trt", xyzac_trt),
    ("lu-hybrid-ii", hybrid::lu_hybrid),
    ("lu-serial-i", singles::lu_serial),
    ("ma-ac-trunnion", ma_ac_trunnion),
    ("mikron-hpm-800u-type", kinds::mikron_hpm),
    ("nutating-head-45", nutating_head),
    ("pocket-nc-v2", singles::pocket_nc),
    ("smithy-1240-4axis", |numbers| home_zero::parts(numbers, kinds::smithy_1240)),
    ("starrag-lx-451", singles::starrag),
    ("three-axis-mill", three_axis),
    ("variaxis-i600-type", kinds::variaxis),
];

pub(crate) fn travels(numbers: &KinematicNumbers, joints: [&str; 3]) -> Result<[[f64; 2]; 3], TaskError> {
    let [a, b, c] = joints.map(|name| numbers.travel(name));
    Ok([a?, b?, c?])
}

fn grinder(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [46, 104, 86];
    let size = Spindle { nose: 32.0, housing: 55.0, top: 235.0 };
    let head = Fork { on: "Z", tilt: "B", accent, spindle: size, top: 330.0 };
    let frame = Gantry {
        on: ["Y", "X", "Z"],
        travel: travels(numbers, ["X", "Y", "Z"])?,
        ram: 95.0,
        foot: 330.0,
        floor: -260.0,
        clear: [330.0, 330.0],
        accent,
    };
    let mut parts = frame.parts();
    parts.extend(fork(numbers, head)?);
    parts.extend(rotary_table(numbers, "base", 200.0, -260.0, accent));
    Ok(parts)
}

fn bc_trunnion(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    kinds::over_trunnion(numbers, "B", 300.0, [38, 92, 140])
}

fn jdgr200t(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [58, 96, 128];
    let trunnion = Trunnion { on: "Y", tilt: "B", turn: "C", radius: 110.0, accent };
    let deck = trunnion.floor(numbers)?;
    let frame = Gantry {
        on: ["base", "X", "Z"],
        travel: [numbers.travel("X")?, [0.0, 0.0], numbers.travel("Z")?],
        ram: 70.0,
        foot: 190.0,
        floor: deck - 74.0,
        clear: [220.0, 420.0],
        accent,
    };
    let mut parts = frame.parts();
    parts.extend(spindle(numbers, Spindle { nose: 26.0, housing: 48.0, top: 192.0 }));
    parts.extend(singles::y_slide(numbers, deck, [190.0, trunnion.half_width() + 24.0])?);
    parts.extend(trunnion.parts(numbers)?);
    Ok(parts)
}

fn ma_ac_trunnion(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let trunnion = Trunnion { on: "X", tilt: "A", turn: "C", radius: 160.0, accent: [140, 62, 48] };
    let half = [trunnion.half_width() + 30.0, 190.0];
    kinds::mill_with_trunnion(numbers, trunnion, half, 110.0, Spindle { nose: 40.0, housing: 70.0, top: 172.0 })
}

fn xyzac_trt(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let trunnion = Trunnion { on: "X", tilt: "A", turn: "C", radius: 100.0, accent: [176, 128, 36] };
    let half = [trunnion.half_width() + 20.0, 150.0];
    kinds::mill_with_trunnion(numbers, trunnion, half, 70.0, Spindle { nose: 24.0, housing: 42.0, top: 112.0 })
}

fn three_axis(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let frame = CFrame {
        on: ["X", "Y", "Z"],
        travel: travels(numbers, ["X", "Y", "Z"])?,
        half: [450.0, 230.0],
        deck: numbers.table[2],
        head: 150.0,
        foot: 210.0,
        accent: [56, 110, 96],
        slotted: true,
    };
    let mut parts = frame.parts();
    parts.extend(spindle(numbers, Spindle { nose: 45.0, housing: 82.0, top: 212.0 }));
    parts.push(singles::slide_table(numbers, frame.half, (0.12 * frame.half[0]).max(24.0)));
    Ok(parts)
}

fn nutating_head(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [92, 62, 122];
    let size = Spindle { nose: 42.0, housing: 72.0, top: 300.0 };
    let frame = Gantry {
        on: ["Y", "X", "Z"],
        travel: travels(numbers, ["X", "Y", "Z"])?,
        ram: 135.0,
        foot: 520.0,
        floor: -320.0,
        clear: [430.0, 460.0],
        accent,
    };
    let mut parts = frame.parts();
    parts.extend(nutating(numbers, "Z", "B", accent, size, 522.0)?);
    parts.extend(rotary_table(numbers, "base", 320.0, -320.0, accent));
    Ok(parts)
}

/// A gantry with a fork head over a table of this half size that stands on the floor.
fn fork_over_table(
    numbers: &KinematicNumbers,
    head: Fork<'_>,
    ram: f64,
    floor: f64,
    clear: [f64; 2],
    table: [f64; 2],
) -> Result<Vec<MachinePart>, TaskError> {
    let (foot, accent) = (head.top, head.accent);
    let travel = travels(numbers, ["X", "Y", "Z"])?;
    let mut parts = Gantry { on: ["Y", "X", "Z"], travel, ram, foot, floor, clear, accent }.parts();
    parts.extend(fork(numbers, head)?);
    parts.extend(fixed_table(numbers, table, floor));
    Ok(parts)
}

fn fork_head_gantry(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let size = Spindle { nose: 55.0, housing: 105.0, top: 400.0 };
    let head = Fork { on: "C", tilt: "A", accent: [38, 92, 140], spindle: size, top: 540.0 };
    fork_over_table(numbers, head, 210.0, -260.0, [1080.0, 1620.0], [1000.0, 1500.0])
}

fn bridge_mill(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let size = Spindle { nose: 45.0, housing: 80.0, top: 350.0 };
    let head = Fork { on: "C", tilt: "B", accent: [176, 128, 36], spindle: size, top: 470.0 };
    fork_over_table(numbers, head, 140.0, -780.0, [560.0, 600.0], [500.0, 500.0])
}
