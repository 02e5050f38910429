//! Gantry: a beam on two walls or columns, a saddle on its front, a ram in the saddle.
//!
//! ```text
//!   from the front                     from the right (front at the left)
//!
//!        ____|ram|____                     |ram|saddle|beam|
//!   ____|___saddle___|____   s0 + height   |   |      |    |
//!  |_______beam___________|  s0            |___|______|____|___
//!  |wall|    |ram|    |wall|                head      |  wall  |
//!  |    |    head     |    |                 *        |        |   * gauge line, z = 0 with all joints at 0
//!  |____|_____bed_____|____|  floor        ___________bed______|
//! ```

use crate::machine_models::{
    part::{MachinePart, Paint},
    solid::{SolidMesh, UnitAxis, block, cylinder, prism, rail_pair},
};

/// Sizes of a gantry; mm, with all joints at zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gantry<'a> {
    /// Joints or base that carry beam, saddle and ram.
    pub(crate) on: [&'a str; 3],
    /// Travel of saddle (x), beam (y) and ram (z).
    pub(crate) travel: [[f64; 2]; 3],
    /// Half width of the ram.
    pub(crate) ram: f64,
    /// Lower end of the ram above the gauge line.
    pub(crate) foot: f64,
    /// Top of the bed.
    pub(crate) floor: f64,
    /// Half of the clear width between the walls at least, and half of the bed's length at least.
    pub(crate) clear: [f64; 2],
    /// Color of saddle and walls' covers.
    pub(crate) accent: [u8; 3],
}

impl Gantry<'_> {
    pub(crate) fn parts(&self) -> Vec<MachinePart> {
        let Self { on: [on_beam, on_saddle, on_ram], travel: [x, y, z], ram, foot, floor, clear, accent } = *self;
        let stroke = z[1] - z[0];
        let height = (0.45 * stroke).max(3.2 * ram);
        let low = z[1] + foot + 20.0;
        let high = low + height;
        let length = stroke + height + 60.0;
        let saddle_half = ram + (0.7 * ram).max(50.0);
        let depth = (0.5 * ram).max(50.0);
        let (front, back) = (ram + 20.0, ram + 20.0 + depth);
        let beam_front = back + 20.0;
        let beam_back = beam_front + (0.4 * height).max(1.6 * ram);
        let inside = (saddle_half + x[0].abs().max(x[1].abs()) + 50.0).max(clear[0] + 20.0);
        let wall = (0.13 * inside).max(90.0);
        let outside = inside + wall;
        let (y0, y1) = (y[0] + beam_front - 60.0, y[1] + beam_back + 60.0);
        let wall_top = low - 24.0;
        let bed_depth = (0.12 * inside).max(120.0);
        let bed_front = (-clear[1] - 40.0).min(y0);
        let bed_back = (clear[1] + 40.0).max(y1);

        // Walls lean back at the front and rest on the bed's full length.
        let lean = 0.25 * (wall_top - floor);
        let foot_front = (y0 - lean).max(bed_front);
        let outline = [
            [foot_front, floor - bed_depth],
            [y1, floor - bed_depth],
            [y1, wall_top],
            [y0, wall_top],
            [y0, wall_top - 0.25 * (wall_top - floor)],
            [foot_front, floor + 0.15 * (wall_top - floor)],
        ];
        let walls = [[-outside, -inside], [inside, outside]].map(|range| prism(UnitAxis::X, range, &outline));
        let ribs = (0..4).flat_map(|k| {
            let at = y0 + 30.0 + (y1 - y0 - 90.0) * f64::from(k) / 3.0;
            [[-outside - 22.0, -outside + 5.0], [outside - 5.0, outside + 22.0]]
                .map(|[a, b]| block([a, at, floor - bed_depth + 10.0], [b, at + 30.0, wall_top - 30.0], 6.0))
        });
        let bands = [[-outside - 22.0, -outside + 5.0], [outside - 5.0, outside + 22.0]]
            .map(|[a, b]| block([a, y0 + 10.0, wall_top - 60.0], [b, y1 - 10.0, wall_top - 10.0], 8.0));
        let bed = block([-inside - 2.0, bed_front, floor - bed_depth], [inside + 2.0, bed_back, floor], 16.0);
        let rear_wall = block(
            [-inside - 3.0, y1 - 60.0, floor - bed_depth + 12.0],
            [inside + 3.0, y1 - 12.0, floor + 0.55 * (wall_top - floor)],
            10.0,
        );
        let feet = [-0.8, 0.8].into_iter().flat_map(|fx| {
            [bed_front + 60.0, 0.5 * (bed_front + bed_back), bed_back - 60.0]
                .map(|fy| cylinder([fx * inside, fy, floor - bed_depth - 40.0], UnitAxis::Z.unit(), 45.0, 45.0, 6.0))
        });
        let tops = [[-outside + 0.25 * wall, -outside + 0.6 * wall], [outside - 0.6 * wall, outside - 0.25 * wall]];
        let y_rails = tops.map(|[a, b]| block([a, y0 + 5.0, wall_top - 2.0], [b, y1 - 5.0, wall_top + 16.0], 3.0));
        let mut parts = vec![
            MachinePart::new("bed", "bed", "base", Paint::Frame, bed),
            MachinePart::new("left_wall", "column", "base", Paint::Casting, walls[0].clone()),
            MachinePart::new("right_wall", "column", "base", Paint::Casting, walls[1].clone()),
            MachinePart::new(
                "ribs",
                "column",
                "base",
                Paint::Frame,
                SolidMesh::all(ribs).and(SolidMesh::all(bands)).and(SolidMesh::all(feet)),
            ),
        ];

        // The beam with its end carriages, ribs at the rear and rails in front.
        let beam = block([-outside, beam_front, low], [outside, beam_back, high], 18.0);
        let beam_ribs = (0..7).map(|k| {
            let at = -outside + 40.0 + (2.0 * outside - 110.0) * f64::from(k) / 6.0;
            block([at, beam_back - 5.0, low + 20.0], [at + 30.0, beam_back + 40.0, high - 20.0], 6.0)
        });
        let flanges = [low + 10.0, high - 50.0]
            .map(|h| block([-outside + 10.0, beam_back - 5.0, h], [outside - 10.0, beam_back + 32.0, h + 40.0], 6.0));
        let x_rails = rail_pair(
            [-inside - 10.0, beam_front - 18.0, 0.5 * (low + high) - 14.0],
            [inside + 10.0, beam_front + 2.0, 0.5 * (low + high) + 14.0],
            [0.0, 0.0, 0.36 * height],
        );
        let cover = block(
            [-inside - 6.0, beam_front - 8.0, low + 0.26 * height],
            [inside + 6.0, beam_front + 2.0, high - 0.26 * height],
            2.0,
        );
        parts.push(MachinePart::new("beam", "beam", on_beam, Paint::Casting, beam));
        parts.push(MachinePart::new(
            "beam_ribs",
            "beam",
            on_beam,
            Paint::Frame,
            SolidMesh::all(beam_ribs).and(SolidMesh::all(flanges)),
        ));
        parts.push(MachinePart::new("x_rails", "guide", on_beam, Paint::Rail, x_rails));
        parts.push(MachinePart::new("x_bellows", "cover", on_beam, Paint::Bellows, cover));
        if on_beam != "base" {
            // Below a fixed portal the table passes through.
            parts.push(MachinePart::new("rear_wall", "column", "base", Paint::Casting, rear_wall));
        }
        if on_beam == "base" {
            let pads =
                tops.map(|[a, b]| block([a - 15.0, beam_front, wall_top - 4.0], [b + 15.0, beam_back, low + 4.0], 3.0));
            parts.push(MachinePart::new("portal_pads", "column", "base", Paint::Frame, SolidMesh::all(pads)));
        } else {
            let carriages = tops.map(|[a, b]| {
                block([a - 18.0, beam_front - 10.0, wall_top + 4.0], [b + 18.0, beam_back + 10.0, low + 4.0], 5.0)
            });
            parts.push(MachinePart::new("y_rails", "guide", "base", Paint::Rail, SolidMesh::all(y_rails)));
            parts.push(MachinePart::new("y_carriages", "guide", on_beam, Paint::Dark, SolidMesh::all(carriages)));
        }

        // The saddle clasps the ram.
        let cheek = ram + 6.0;
        let clasp = [
            [-saddle_half, back],
            [-saddle_half, front - 0.7 * ram],
            [-cheek, front - 0.7 * ram],
            [-cheek, front],
            [cheek, front],
            [cheek, front - 0.7 * ram],
            [saddle_half, front - 0.7 * ram],
            [saddle_half, back],
        ];
        let saddle = prism(UnitAxis::Z, [low + 6.0, high - 6.0], &clasp);
        let blocks = [-1.0, 1.0].into_iter().flat_map(|u| {
            [-0.36, 0.36].map(|v| {
                let (cx, cz) = (u * 0.7 * saddle_half, 0.5 * (low + high) + v * height);
                block([cx - 28.0, back - 4.0, cz - 24.0], [cx + 28.0, beam_front - 1.0, cz + 24.0], 4.0)
            })
        });
        parts.push(MachinePart::new("saddle", "saddle", on_saddle, Paint::Accent(accent), saddle));
        parts.push(MachinePart::new("x_carriages", "guide", on_saddle, Paint::Dark, SolidMesh::all(blocks)));

        // The ram with its rails at the back and the drive on top.
        let body = block([-ram, -ram, foot], [ram, ram, foot + length], 14.0);
        let z_rails = rail_pair(
            [-12.0, ram - 2.0, foot + 30.0],
            [12.0, ram + 17.0, foot + length - 30.0],
            [0.62 * ram, 0.0, 0.0],
        );
        let drive = cylinder([0.0, 0.0, foot + length - 2.0], UnitAxis::Z.unit(), 0.5 * ram, 0.9 * ram, 8.0);
        parts.push(MachinePart::new("ram", "ram", on_ram, Paint::Casting, body));
        parts.push(MachinePart::new("z_rails", "guide", on_ram, Paint::Rail, z_rails));
        parts.push(MachinePart::new("z_drive", "motor", on_ram, Paint::Dark, drive));
        parts
    }
}
