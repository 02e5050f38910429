//! Machines of the kind that many shops have: travel and table of a maker's type on the structures of this library.

use crate::{
    Failure,
    machine_models::{
        c_frame::CFrame,
        gantry::Gantry,
        heads::{Fork, Spindle, fork, spindle},
        library::travels,
        numbers::Numbers,
        part::Part,
        work::{Trunnion, rotary_table},
    },
};

/// A gantry over a trunnion between two bearings on the bed.
fn over_trunnion(numbers: &Numbers, tilt: &str, radius: f64, accent: [u8; 3]) -> Result<Vec<Part>, Failure> {
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

pub(crate) fn umc_750(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
    over_trunnion(numbers, "B", 250.0, [150, 44, 40])
}

pub(crate) fn dmu_50(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
    over_trunnion(numbers, "B", 315.0, [70, 78, 90])
}

pub(crate) fn dmu_65(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
    over_trunnion(numbers, "A", 325.0, [70, 78, 90])
}

pub(crate) fn hermle_c42(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
    over_trunnion(numbers, "A", 315.0, [38, 104, 120])
}

pub(crate) fn variaxis(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
    over_trunnion(numbers, "A", 300.0, [176, 100, 36])
}

pub(crate) fn mikron_hpm(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
    over_trunnion(numbers, "B", 315.0, [52, 84, 140])
}

/// A mill with a two-axis rotary table on its table.
pub(crate) fn vf_2(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
    let accent = [150, 44, 40];
    let trunnion = Trunnion { on: "X", tilt: "A", turn: "C", radius: 80.0, accent };
    let frame = CFrame {
        on: ["X", "Y", "Z"],
        travel: travels(numbers, ["X", "Y", "Z"])?,
        half: [457.0, 178.0],
        deck: trunnion.floor(numbers)?,
        head: 150.0,
        foot: 210.0,
        accent,
        slotted: false,
    };
    let mut parts = frame.parts();
    parts.extend(spindle(numbers, Spindle { nose: 45.0, housing: 82.0, top: 212.0 }));
    parts.extend(trunnion.parts(numbers)?);
    Ok(parts)
}

/// A mill with a swivel head and a rotary table in its table.
pub(crate) fn hurco_vmx42(numbers: &Numbers) -> Result<Vec<Part>, Failure> {
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
