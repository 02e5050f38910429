//! Machines of the kind that many shops have: travel and table of a maker's type on the structures of this
//! library.

use crate::{
    TaskError,
    machine_models::{
        c_frame::CFrame,
        gantry::Gantry,
        library::travels,
        numbers::KinematicNumbers,
        part::{MachinePart, Paint},
        solid::{UnitAxis, block, cylinder},
        spindle_heads::{Fork, Spindle, fork, spindle},
        work::{Trunnion, rotary_table},
    },
};

/// A gantry over a trunnion between two bearings on the bed.
pub(crate) fn over_trunnion(
    numbers: &KinematicNumbers,
    tilt: &str,
    radius: f64,
    accent: [u8; 3],
) -> Result<Vec<MachinePart>, TaskError> {
    let trunnion = Trunnion { on: "base", tilt, turn: "C", radius, accent };
    let (across, along) = (1.4 * radius, trunnion.half_width() + 110.0);
    let frame = Gantry {
        on: ["Y", "X", "Z"],
        travel: travels(numbers, ["X", "Y", "Z"])?,
        ram: 120.0,
        foot: 300.0,
        floor: trunnion.floor(numbers)?,
        clear: if tilt == "A" { [along, across] } else { [across, along] },
        accent,
    };
    let mut parts = frame.parts();
    parts.extend(spindle(numbers, Spindle { nose: 48.0, housing: 86.0, top: 302.0 }));
    parts.extend(trunnion.parts(numbers)?);
    Ok(parts)
}

pub(crate) fn umc_750(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    over_trunnion(numbers, "B", 250.0, [150, 44, 40])
}

pub(crate) fn dmu_50(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    over_trunnion(numbers, "B", 315.0, [70, 78, 90])
}

pub(crate) fn dmu_65(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    over_trunnion(numbers, "A", 325.0, [70, 78, 90])
}

pub(crate) fn hermle_c42(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    over_trunnion(numbers, "A", 315.0, [38, 104, 120])
}

pub(crate) fn variaxis(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    over_trunnion(numbers, "A", 300.0, [176, 100, 36])
}

pub(crate) fn mikron_hpm(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    over_trunnion(numbers, "B", 315.0, [52, 84, 140])
}

/// A mill whose table carries a trunnion; `half` is half the size of its table, `head` of its spindle head.
pub(crate) fn mill_with_trunnion(
    numbers: &KinematicNumbers,
    trunnion: Trunnion<'_>,
    half: [f64; 2],
    head: f64,
    size: Spindle,
) -> Result<Vec<MachinePart>, TaskError> {
    let (deck, accent) = (trunnion.floor(numbers)?, trunnion.accent);
    let travel = travels(numbers, ["X", "Y", "Z"])?;
    let frame = CFrame { on: ["X", "Y", "Z"], travel, half, deck, head, foot: size.top - 2.0, accent, slotted: false };
    let mut parts = frame.parts();
    parts.extend(spindle(numbers, size));
    parts.extend(trunnion.parts(numbers)?);
    Ok(parts)
}

/// A mill with a two-axis rotary table on its table.
pub(crate) fn vf_2(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let trunnion = Trunnion { on: "X", tilt: "A", turn: "C", radius: 80.0, accent: [150, 44, 40] };
    let size = Spindle { nose: 45.0, housing: 82.0, top: 212.0 };
    mill_with_trunnion(numbers, trunnion, [457.0, 178.0], 150.0, size)
}

/// A mill with a swivel head and a rotary table in its table.
pub(crate) fn hurco_vmx42(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [44, 96, 60];
    let deck = -110.0;
    let frame = CFrame {
        on: ["X", "Y", "Z"],
        travel: travels(numbers, ["X", "Y", "Z"])?,
        half: [635.0, 305.0],
        deck,
        head: 190.0,
        foot: 470.0,
        accent,
        slotted: false,
    };
    let size = Spindle { nose: 45.0, housing: 82.0, top: 360.0 };
    let mut parts = frame.parts();
    parts.extend(fork(numbers, Fork { on: "Z", tilt: "B", accent, spindle: size, top: 470.0 })?);
    parts.extend(rotary_table(numbers, "X", 305.0, deck, accent));
    Ok(parts)
}

/// A bench mill with a rotary table at the left end of its table, whose axis lies along x.
pub(crate) fn smithy_1240(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [40, 84, 128];
    let [face, y, height] = numbers.table;
    let size = Spindle { nose: 35.0, housing: 62.0, top: 172.0 };
    let deck = height - 127.0;
    let frame = CFrame {
        on: ["X", "Y", "Z"],
        travel: travels(numbers, ["X", "Y", "Z"])?,
        half: [508.0, 152.0],
        deck,
        head: 110.0,
        foot: size.top - 2.0,
        accent,
        slotted: false,
    };
    let mut parts = frame.parts();
    parts.extend(spindle(numbers, size));
    let on_axis = |from: f64, radius: f64, length: f64| {
        cylinder([face - from, y, height], UnitAxis::X.unit(), radius, length, 2.0)
    };
    let housing = block([face - 160.0, y - 95.0, deck - 2.0], [face - 18.0, y + 95.0, height + 95.0], 10.0);
    parts.push(MachinePart::new("rotary_housing", "housing", "X", Paint::Accent(accent), housing));
    parts.push(MachinePart::new("rotary_motor", "motor", "X", Paint::Dark, on_axis(240.0, 45.0, 84.0)));
    parts.push(MachinePart::new("table", "table", "A", Paint::Steel, on_axis(14.0, 80.0, 14.0)));
    parts.push(MachinePart::new("table_hub", "table", "A", Paint::Dark, on_axis(60.0, 45.0, 48.0)));
    Ok(parts)
}
