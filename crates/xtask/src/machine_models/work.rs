//! What carries the workpiece: trunnions, rotary tables, fixed tables. The clamping face is at the table
//! point of `machine.toml`, the bearings on the axes of the tilting joint.

use crate::machine_models::{
    numbers::KinematicNumbers,
    part::{MachinePart, Paint},
    solid::{SolidMesh, UnitAxis, block, cylinder, prism, slotted_disc, slotted_plate, tongue},
};

/// A cradle between two bearings with a rotary table in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trunnion<'a> {
    /// Joint or base that carries the bearings.
    pub(crate) on: &'a str,
    /// Joint of the cradle, about x or y.
    pub(crate) tilt: &'a str,
    /// Joint of the table.
    pub(crate) turn: &'a str,
    /// Radius of the table.
    pub(crate) radius: f64,
    /// Color of the cradle.
    pub(crate) accent: [u8; 3],
}

impl Trunnion<'_> {
    fn thickness(&self) -> f64 {
        (0.16 * self.radius).max(8.0)
    }

    /// Height of the rotary drive below the table.
    fn drive(&self) -> f64 {
        0.42 * self.radius
    }

    fn plate(&self) -> f64 {
        0.22 * self.radius
    }

    /// Half of the outer width along the tilt axis, bearings included.
    pub(crate) fn half_width(&self) -> f64 {
        1.12 * self.radius + 2.0 * self.arm() + 0.55 * self.radius
    }

    fn arm(&self) -> f64 {
        0.24 * self.radius
    }

    /// Height of the floor below the cradle that it clears at every angle.
    pub(crate) fn floor(&self, numbers: &KinematicNumbers) -> Result<f64, crate::TaskError> {
        let pivot = numbers.point(self.tilt)?[2];
        let face = numbers.table[2];
        let low = face - self.thickness() - self.drive() - self.plate();
        let corner = (pivot - low).hypot(0.66 * self.radius);
        let rim = self.radius.hypot((pivot - face).abs().max((pivot - face + self.thickness()).abs()));
        Ok(pivot - corner.max(rim) - 0.12 * self.radius)
    }

    /// Bearings, cradle, table.
    pub(crate) fn parts(&self, numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, crate::TaskError> {
        let pivot = numbers.point(self.tilt)?;
        let axis = numbers.direction(self.tilt)?;
        let about_y = axis[1].abs() > 0.5;
        let center = numbers.point(self.turn)?;
        let (r, face, floor) = (self.radius, numbers.table[2], self.floor(numbers)?);
        let height = pivot[2];
        let low = face - self.thickness() - self.drive() - self.plate();
        let (inner, outer) = (1.12 * r, 1.12 * r + self.arm());
        // Built for a tilt about x at y = 0, the table's middle at x = 0.
        let round = (0.42 * r).min((height - low).max(0.3 * r));
        let arm_plate = tongue(0.6 * r, low, height, round);
        let arms = [[-outer, -inner], [inner, outer]].map(|range| prism(UnitAxis::X, range, &arm_plate));
        let cradle = SolidMesh::all(arms)
            .and(block([-outer + 4.0, -0.62 * r, low], [outer - 4.0, 0.62 * r, low + self.plate()], 10.0))
            .and(cylinder([0.0, 0.0, low + 4.0], UnitAxis::Z.unit(), 0.62 * r, self.plate() + self.drive() - 8.0, 6.0));
        let journals =
            [-1.0, 1.0].map(|s| cylinder([s * (outer - 4.0), 0.0, height], [s, 0.0, 0.0], 0.7 * round, 0.3 * r, 3.0));
        let bearing = tongue(0.7 * r, floor - 2.0, height, 1.15 * round);
        let gap = (0.012 * r).max(2.0);
        let bearings = [[-outer - gap - 0.42 * r, -outer - gap], [outer + gap, outer + gap + 0.42 * r]]
            .map(|range| prism(UnitAxis::X, range, &bearing));
        let motor = cylinder([outer + gap + 0.41 * r, 0.0, height], UnitAxis::X.unit(), 0.8 * round, 0.3 * r, 8.0);
        let caps = [-1.0, 1.0]
            .map(|s| cylinder([s * (outer + gap + 0.41 * r), 0.0, height], [s, 0.0, 0.0], 0.95 * round, 0.06 * r, 3.0));
        // The tilt axis may be offset from the plane of the table's middle: its own y (or x) counts across.
        let place = |solid: SolidMesh| {
            if about_y {
                solid.quarter_turned().at([pivot[0], center[1], 0.0])
            } else {
                solid.at([center[0], pivot[1], 0.0])
            }
        };
        let hub = cylinder(
            [center[0], center[1], face - self.thickness() - self.drive() + 2.0],
            UnitAxis::Z.unit(),
            0.5 * r,
            self.drive(),
            2.0,
        );
        let disc = slotted_disc([numbers.table[0], numbers.table[1]], r, face, self.thickness(), 5);
        Ok(vec![
            MachinePart::new("bearings", "bearing", self.on, Paint::Frame, place(SolidMesh::all(bearings))),
            MachinePart::new("bearing_caps", "bearing", self.on, Paint::Steel, place(SolidMesh::all(caps))),
            MachinePart::new("swivel_motor", "motor", self.on, Paint::Dark, place(motor)),
            MachinePart::new("cradle", "cradle", self.tilt, Paint::Accent(self.accent), place(cradle)),
            MachinePart::new("journals", "bearing", self.tilt, Paint::Steel, place(SolidMesh::all(journals))),
            MachinePart::new("table", "table", self.turn, Paint::Steel, disc),
            MachinePart::new("table_hub", "table", self.turn, Paint::Dark, hub),
        ])
    }
}

/// A rotary table on a pedestal that rests on `floor`.
pub(crate) fn rotary_table(
    numbers: &KinematicNumbers,
    on: &str,
    radius: f64,
    floor: f64,
    accent: [u8; 3],
) -> Vec<MachinePart> {
    let [x, y, face] = numbers.table;
    let thickness = (0.2 * radius).max(10.0);
    let under = face - thickness;
    let pedestal = block(
        [x - 0.95 * radius, y - 0.95 * radius, floor - 2.0],
        [x + 0.95 * radius, y + 0.95 * radius, under - 24.0],
        14.0,
    )
    .and(cylinder([x, y, under - 30.0], UnitAxis::Z.unit(), 0.8 * radius, 27.0, 3.0))
    .and(cylinder(
        [x + 0.7 * radius, y - 0.2 * radius, 0.5 * (floor + under)],
        UnitAxis::X.unit(),
        0.22 * radius,
        0.6 * radius,
        6.0,
    ));
    vec![
        MachinePart::new(
            "table",
            "table",
            &numbers.table_on,
            Paint::Steel,
            slotted_disc([x, y], radius, face, thickness, 5),
        ),
        MachinePart::new("pedestal", "pedestal", on, Paint::Accent(accent), pedestal),
    ]
}

/// A fixed table with T-slots, standing on `floor`; `half` is its half size in x and y.
pub(crate) fn fixed_table(numbers: &KinematicNumbers, half: [f64; 2], floor: f64) -> Vec<MachinePart> {
    let [x, y, face] = numbers.table;
    let on = numbers.table_on.as_str();
    let under = face - (0.08 * half[0]).clamp(40.0, 120.0);
    let plate = slotted_plate([x - half[0], y - half[1], under], [x + half[0], y + half[1], face], 7);
    let foot = block(
        [x - half[0] + 30.0, y - half[1] + 30.0, floor - 2.0],
        [x + half[0] - 30.0, y + half[1] - 30.0, under + 2.0],
        10.0,
    );
    let ribs = (0..5).map(|k| {
        let at = y - half[1] + 60.0 + (2.0 * half[1] - 140.0) * f64::from(k) / 4.0;
        block([x - half[0] + 6.0, at, floor - 2.0], [x + half[0] - 6.0, at + 30.0, under + 2.0], 6.0)
    });
    vec![
        MachinePart::new("table", "table", on, Paint::Steel, plate),
        MachinePart::new("table_foot", "table", on, Paint::Frame, SolidMesh::all(ribs).and(foot)),
    ]
}
