//! C frame: a fixed column at the rear of a table on cross slides, the head on the column.
//!
//! ```text
//!    head  ||==|column        front at the left; y to the right
//!          ||  |     |
//!          \/  |     |        * gauge line, z = 0 with all joints at zero
//!           *  |     |
//!   ==table====|     |        deck: top of the slide that carries table or trunnion
//!     saddle   |     |
//!   __bed______|_____|
//! ```

use crate::machine_models::{
    part::{MachinePart, Paint},
    solid::{SolidMesh, UnitAxis, block, cylinder, prism, rail_pair},
};

/// Sizes of a C frame; mm, with all joints at zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CFrame<'a> {
    /// Joints of table, saddle and head.
    pub(crate) on: [&'a str; 3],
    /// Their travel.
    pub(crate) travel: [[f64; 2]; 3],
    /// Half size of the slide table in x and y.
    pub(crate) half: [f64; 2],
    /// Top of the slide table.
    pub(crate) deck: f64,
    /// Half width of the head.
    pub(crate) head: f64,
    /// Lower end of the head above the gauge line.
    pub(crate) foot: f64,
    /// Color of saddle and head.
    pub(crate) accent: [u8; 3],
    /// True where the slide table's top is the clamping face, which another part makes.
    pub(crate) slotted: bool,
}

impl CFrame<'_> {
    pub(crate) fn parts(&self) -> Vec<MachinePart> {
        let Self {
            on: [on_table, on_saddle, on_head],
            travel: [x, y, z],
            half: [hx, hy],
            deck,
            head,
            foot,
            accent,
            ..
        } = *self;
        let thick = (0.12 * hx).max(24.0);
        let slide = (0.16 * hx).max(36.0);
        let under = deck - thick;
        let saddle_top = under - 18.0;
        let saddle_low = saddle_top - slide;
        let bed_top = saddle_low - 18.0;
        let bed_depth = (0.55 * hx).max(120.0);
        let reach_y = y[0].abs().max(y[1].abs());
        let saddle_x = (0.8 * hx).max(hx - 0.6 * x[1]);
        let column = (hy + reach_y + 40.0).max(1.2 * head);
        let head_height = 3.2 * head;
        let column_half = head + (0.5 * head).max(40.0);
        let column_top = z[1] + foot + head_height + 40.0;
        let column_back = column + (0.35 * (column_top - bed_top)).max(2.0 * head);
        let bed_half = saddle_x.max(column_half + 30.0);

        let bed = block([-bed_half, -hy - reach_y - 40.0, bed_top - bed_depth], [bed_half, column_back, bed_top], 14.0);
        let feet = [-0.8, 0.8].into_iter().flat_map(|fx| {
            [-hy - reach_y + 20.0, column_back - 80.0].map(|fy| {
                cylinder([fx * bed_half, fy, bed_top - bed_depth - 35.0], UnitAxis::Z.unit(), 38.0, 40.0, 6.0)
            })
        });
        let back_low = column_back;
        let back_high = column + 0.62 * (column_back - column);
        let side = [
            [column, bed_top - 2.0],
            [back_low, bed_top - 2.0],
            [back_low, bed_top + 60.0],
            [back_high, column_top],
            [column, column_top],
        ];
        let post = prism(UnitAxis::X, [-column_half, column_half], &side);
        let ribs = [[-column_half - 14.0, -column_half + 3.0], [column_half - 3.0, column_half + 14.0]]
            .into_iter()
            .flat_map(|range| {
                let step = (column_top - bed_top - 140.0) / 3.0;
                let (w, level) = (26.0, |k: f64| bed_top + 60.0 + k * step);
                let cross_ribs = (0..4).map(move |k| {
                    let h = level(f64::from(k));
                    let b = back_low + (back_high - back_low) * (h - bed_top) / (column_top - bed_top);
                    block([range[0], column + 10.0, h], [range[1], b - 8.0, h + w], 5.0)
                });
                let upright = block(
                    [range[0], column + 10.0, bed_top + 20.0],
                    [range[1], column + 10.0 + w, column_top - 20.0],
                    5.0,
                );
                cross_ribs.chain([upright]).collect::<Vec<_>>()
            });
        let z_low = z[0] + foot - 10.0;
        let z_high = z[1] + foot + head_height + 10.0;
        let z_rails = rail_pair([-14.0, column - 16.0, z_low], [14.0, column + 2.0, z_high], [0.75 * head, 0.0, 0.0]);
        let screw = cylinder([0.0, column - 12.0, z_low + 10.0], UnitAxis::Z.unit(), 8.0, z_high - z_low - 20.0, 1.0);
        let z_cover =
            block([-0.55 * head, column - 6.0, bed_top + 10.0], [0.55 * head, column + 2.0, z_low + 4.0], 2.0);
        let z_motor = block(
            [-0.3 * head, column + 10.0, column_top - 4.0],
            [0.3 * head, column + 10.0 + 0.6 * head, column_top + 0.9 * head],
            8.0,
        );
        let y_rails = rail_pair(
            [-18.0, -hy - reach_y - 20.0, bed_top - 2.0],
            [18.0, hy + reach_y + 20.0, bed_top + 13.0],
            [0.6 * saddle_x, 0.0, 0.0],
        );
        let mut parts = vec![
            MachinePart::new("bed", "bed", "base", Paint::Frame, bed),
            MachinePart::new("feet", "bed", "base", Paint::Dark, SolidMesh::all(feet)),
            MachinePart::new("column", "column", "base", Paint::Casting, post),
            MachinePart::new("column_ribs", "column", "base", Paint::Frame, SolidMesh::all(ribs)),
            MachinePart::new("z_rails", "guide", "base", Paint::Rail, z_rails.and(screw)),
            MachinePart::new("z_cover", "cover", "base", Paint::Bellows, z_cover),
            MachinePart::new("z_motor", "motor", "base", Paint::Dark, z_motor),
            MachinePart::new("y_rails", "guide", "base", Paint::Rail, y_rails),
        ];

        let y_blocks = [-1.0, 1.0].into_iter().flat_map(|u| {
            [-0.75, 0.75].map(|v| {
                let (cx, cy) = (u * 0.6 * saddle_x, v * hy);
                block([cx - 32.0, cy - 30.0, bed_top + 3.0], [cx + 32.0, cy + 30.0, saddle_low + 3.0], 4.0)
            })
        });
        let saddle = block([-saddle_x, -hy - 10.0, saddle_low], [saddle_x, hy + 10.0, saddle_top], 8.0);
        let x_rails = rail_pair(
            [-saddle_x + 8.0, -16.0, saddle_top - 2.0],
            [saddle_x - 8.0, 16.0, saddle_top + 12.0],
            [0.0, 0.6 * hy, 0.0],
        );
        parts.push(MachinePart::new("saddle", "saddle", on_saddle, Paint::Accent(accent), saddle));
        parts.push(MachinePart::new("y_carriages", "guide", on_saddle, Paint::Dark, SolidMesh::all(y_blocks)));
        parts.push(MachinePart::new("x_rails", "guide", on_saddle, Paint::Rail, x_rails));

        let x_blocks = [-1.0, 1.0].into_iter().flat_map(|u| {
            [-0.6, 0.6].map(|v| {
                let (cx, cy) = (u * 0.4 * hx, v * hy);
                block([cx - 34.0, cy - 28.0, saddle_top + 2.0], [cx + 34.0, cy + 28.0, under + 3.0], 4.0)
            })
        });
        parts.push(MachinePart::new("x_carriages", "guide", on_table, Paint::Dark, SolidMesh::all(x_blocks)));
        let covers = [[-hx - 0.06 * hx, -hx + 2.0], [hx - 2.0, hx + 0.06 * hx]]
            .map(|[a, b]| block([a, -0.8 * hy, under + 4.0], [b, 0.8 * hy, deck - 6.0], 3.0));
        parts.push(MachinePart::new("x_covers", "cover", on_table, Paint::Bellows, SolidMesh::all(covers)));
        if !self.slotted {
            let plate = block([-hx, -hy, under], [hx, hy, deck], 6.0);
            parts.push(MachinePart::new("slide_table", "table", on_table, Paint::Casting, plate));
        }

        // The head: a box whose lower front is cut away towards the spindle.
        let front = -1.15 * head;
        let outline = [
            [front, foot + 0.2 * head_height],
            [front + 0.35 * head, foot],
            [0.9 * head, foot],
            [column - 22.0, foot + 0.35 * head_height],
            [column - 22.0, foot + head_height],
            [front + 0.2 * head, foot + head_height],
            [front, foot + 0.92 * head_height],
        ];
        let body = prism(UnitAxis::X, [-head, head], &outline);
        let z_blocks = [-1.0, 1.0].into_iter().flat_map(|u| {
            [0.45, 0.9].map(|v| {
                let (cx, cz) = (u * 0.75 * head, foot + v * head_height);
                block([cx - 26.0, column - 26.0, cz - 34.0], [cx + 26.0, column - 4.0, cz + 20.0], 4.0)
            })
        });
        let motor = cylinder([0.0, 0.0, foot + head_height - 2.0], UnitAxis::Z.unit(), 0.62 * head, 1.1 * head, 10.0);
        parts.push(MachinePart::new("head", "headstock", on_head, Paint::Accent(accent), body));
        parts.push(MachinePart::new("z_carriages", "guide", on_head, Paint::Dark, SolidMesh::all(z_blocks)));
        parts.push(MachinePart::new("spindle_motor", "motor", on_head, Paint::Dark, motor));
        parts
    }
}
