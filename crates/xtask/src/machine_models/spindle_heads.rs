//! What carries the tool: spindles, fork heads, 45-degree heads. Each ends at the gauge line: the spindle
//! nose's face is the gauge line of `machine.toml`.

use crate::machine_models::{
    numbers::KinematicNumbers,
    part::{MachinePart, Paint},
    solid::{SolidMesh, UnitAxis, V3, add, block, cylinder, prism, revolved, scaled, tongue},
};

/// Sizes of a spindle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spindle {
    /// Radius of the nose.
    pub(crate) nose: f64,
    /// Radius of the housing.
    pub(crate) housing: f64,
    /// Height of the housing's upper end above the gauge line.
    pub(crate) top: f64,
}

/// Nose with a taper bore, and the stepped housing above it, along the spindle direction of the machine.
pub(crate) fn spindle(numbers: &KinematicNumbers, size: Spindle) -> Vec<MachinePart> {
    let Spindle { nose, housing, top } = size;
    let (foot, axis, on) = (numbers.gauge, numbers.spindle_direction, numbers.spindle_on.as_str());
    let (flange, neck) = (0.6 * nose, (0.25 * top).max(1.5 * nose));
    let bore = 0.5 * nose;
    let nose_profile = [
        [0.0, 1.2 * nose],
        [0.6 * bore, 1.2 * nose],
        [bore, 0.0],
        [nose - 2.0, 0.0],
        [nose, 2.0],
        [nose, flange],
        [0.5 * (nose + housing), flange + 0.4 * (neck - flange)],
        [0.5 * (nose + housing), neck + 2.0],
        [0.0, neck + 2.0],
    ];
    let c = 0.06 * housing;
    let housing_profile =
        [[0.0, neck], [housing - c, neck], [housing, neck + c], [housing, top - c], [housing - c, top], [0.0, top]];
    vec![
        MachinePart::new("spindle_nose", "spindle_nose", on, Paint::Steel, revolved(foot, axis, &nose_profile)),
        MachinePart::new("spindle", "spindle", on, Paint::Dark, revolved(foot, axis, &housing_profile)),
    ]
}

/// A fork: two arms that hold the spindle between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fork<'a> {
    /// Joint that carries the arms.
    pub(crate) on: &'a str,
    /// Joint of the tilt, about x or y.
    pub(crate) tilt: &'a str,
    /// Color of the arms.
    pub(crate) accent: [u8; 3],
    /// The spindle.
    pub(crate) spindle: Spindle,
    /// Height of the fork's upper end above the gauge line.
    pub(crate) top: f64,
}

/// Arms, bridge and flange on one joint; spindle box with its pivots on the tilt joint.
pub(crate) fn fork(numbers: &KinematicNumbers, fork: Fork<'_>) -> Result<Vec<MachinePart>, crate::TaskError> {
    let pivot = numbers.point(fork.tilt)?;
    let about_y = numbers.direction(fork.tilt)?[1].abs() > 0.5;
    let Spindle { housing: r, .. } = fork.spindle;
    let half = r + 0.16 * r + 6.0;
    let arm = 0.55 * r;
    let reach = pivot[2] - numbers.gauge[2];
    let bridge = fork.top - (0.5 * r).max(40.0);
    // Built for a tilt about x through the origin, heights from the gauge line.
    let tongue_plate = tongue(1.25 * r, bridge + 10.0, reach, 0.95 * r);
    let arms = [-1.0, 1.0].map(|side| {
        let range = if side < 0.0 { [-half - arm, -half - 2.0] } else { [half + 2.0, half + arm] };
        prism(UnitAxis::X, range, &tongue_plate).and(cylinder(
            [side * (half + arm - 2.0), 0.0, reach],
            [side, 0.0, 0.0],
            0.6 * r,
            0.25 * r,
            6.0,
        ))
    });
    let width = half + arm;
    let yoke = SolidMesh::all(arms)
        .and(block([-width, -1.3 * r, bridge], [width, 1.3 * r, fork.top - 14.0], 12.0))
        .and(cylinder([0.0, 0.0, fork.top - 20.0], UnitAxis::Z.unit(), 1.25 * r, 20.0, 4.0));
    let pivots =
        [-1.0, 1.0].map(|side| cylinder([side * 0.6 * r, 0.0, reach], [side, 0.0, 0.0], 0.72 * r, half - 0.6 * r, 3.0));
    let place = |solid: SolidMesh| {
        let turned = if about_y { solid.quarter_turned() } else { solid };
        turned.at([pivot[0], pivot[1], numbers.gauge[2]])
    };
    let mut parts = spindle(numbers, fork.spindle);
    parts.push(MachinePart::new("fork", "head", fork.on, Paint::Accent(fork.accent), place(yoke)));
    parts.push(MachinePart::new("spindle_pivots", "bearing", fork.tilt, Paint::Casting, place(SolidMesh::all(pivots))));
    Ok(parts)
}

/// A head that turns about an axis at 45 degrees: lower half with the spindle on `tilt`, upper half below
/// the ram on `on`. The ram's lower end must be `top` above the gauge line and reach to y = `back`.
pub(crate) fn nutating(
    numbers: &KinematicNumbers,
    on: &str,
    tilt: &str,
    accent: [u8; 3],
    size: Spindle,
    top: f64,
) -> Result<Vec<MachinePart>, crate::TaskError> {
    let pivot = numbers.point(tilt)?;
    let axis = numbers.direction(tilt)?;
    let along = |d: f64| add(pivot, scaled(axis, d));
    // The joint face lies where it clears the spindle box on every turn.
    let face = 0.8 * (size.housing + size.top - pivot[2] + numbers.gauge[2]).max(1.3 * size.housing);
    let flange = 1.45 * size.housing;
    let lower = revolved(
        along(0.0),
        axis,
        &[
            [0.0, -0.2 * face],
            [0.75 * size.housing, -0.2 * face],
            [flange, 0.6 * face],
            [flange, face - 1.0],
            [0.0, face - 1.0],
        ],
    );
    let height = numbers.gauge[2] + top;
    let upper = revolved(
        along(0.0),
        axis,
        &[[0.0, face + 1.0], [flange, face + 1.0], [flange, 1.5 * face], [0.9 * flange, 1.9 * face], [0.0, 1.9 * face]],
    );
    let middle: V3 = along(1.5 * face);
    let neck = block(
        [pivot[0] - 0.9 * flange, middle[1] - 0.75 * flange, middle[2] - 0.1 * flange],
        [pivot[0] + 0.9 * flange, middle[1] + 0.75 * flange, height],
        20.0,
    );
    let mut parts = spindle(numbers, size);
    parts.push(MachinePart::new("head", "head", tilt, Paint::Accent(accent), lower));
    parts.push(MachinePart::new("head_joint", "head", on, Paint::Casting, upper.and(neck)));
    Ok(parts)
}
