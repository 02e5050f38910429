//! Machines of their own build: the blade center between centers, the desktop mill, the grinder with a fixed
//! tool; and slides that only one machine has.

use crate::{
    TaskError,
    machine_models::{
        gantry::Gantry,
        numbers::KinematicNumbers,
        part::{MachinePart, Paint},
        solid::{
            SolidMesh, UnitAxis, block, cylinder, prism, rail_pair, revolved, slotted_disc, slotted_plate, tongue,
        },
        spindle_heads::{Spindle, spindle},
        work::Trunnion,
    },
};

/// The slotted top of a slide table.
pub(crate) fn slide_table(numbers: &KinematicNumbers, half: [f64; 2], thickness: f64) -> MachinePart {
    let [x, y, face] = numbers.table;
    let plate = slotted_plate([x - half[0], y - half[1], face - thickness], [x + half[0], y + half[1], face], 5);
    MachinePart::new("table", "table", &numbers.table_on, Paint::Steel, plate)
}

/// A slide along Y on the bed, 74 mm high with its rails; its top is `deck`.
pub(crate) fn y_slide(numbers: &KinematicNumbers, deck: f64, half: [f64; 2]) -> Result<Vec<MachinePart>, TaskError> {
    let travel = numbers.travel("Y")?;
    let reach = half[1] + travel[0].abs().max(travel[1].abs());
    let floor = deck - 74.0;
    let rails =
        rail_pair([-16.0, -reach + 20.0, floor - 2.0], [16.0, reach - 20.0, floor + 14.0], [0.6 * half[0], 0.0, 0.0]);
    let blocks = [-1.0, 1.0].into_iter().flat_map(|u| {
        [-0.7, 0.7].map(|v| {
            let (cx, cy) = (u * 0.6 * half[0], v * half[1]);
            block([cx - 30.0, cy - 28.0, floor + 4.0], [cx + 30.0, cy + 28.0, floor + 26.0], 4.0)
        })
    });
    let plate = block([-half[0], -half[1], floor + 24.0], [half[0], half[1], deck], 6.0);
    let bellows = [[-reach + 24.0, -half[1] + 2.0], [half[1] - 2.0, reach - 24.0]]
        .map(|[a, b]| block([-0.4 * half[0], a, floor + 3.0], [0.4 * half[0], b, floor + 34.0], 4.0));
    Ok(vec![
        MachinePart::new("y_rails", "guide", "base", Paint::Rail, rails),
        MachinePart::new("y_bellows", "cover", "base", Paint::Bellows, SolidMesh::all(bellows)),
        MachinePart::new("y_slide", "slide", "Y", Paint::Casting, plate),
        MachinePart::new("y_carriages", "guide", "Y", Paint::Dark, SolidMesh::all(blocks)),
    ])
}

/// Blade center: headstock and tailstock on a bed along x, a traveling column at the rear.
pub(crate) fn starrag(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [150, 40, 44];
    let [x, y, z] = ["X", "Y", "Z"].map(|n| numbers.travel(n));
    let (_, y, z) = (x?, y?, z?);
    let pivot = numbers.point("B")?;
    let size = Spindle { nose: 42.0, housing: 76.0, top: 330.0 };
    let centers = 2805.0; // mm between centers, Li et al. 2022, Table 1
    let swing = 325.0; // half of the swing of 650 mm of the same table
    let floor = -swing - 40.0;

    // Bed: a low front part under the blade, a higher rear part under the column.
    let rear = y[1] + 620.0;
    let step = 420.0;
    let outline = [
        [-420.0, floor - 330.0],
        [rear + 640.0, floor - 330.0],
        [rear + 640.0, floor + 90.0],
        [step + 40.0, floor + 90.0],
        [step, floor + 40.0],
        [step, floor],
        [-420.0, floor],
    ];
    let left = -620.0;
    let right = centers + 720.0;
    let bed = prism(UnitAxis::X, [left, right], &outline);
    let ribs = (0..9).map(|k| {
        let at = left + 60.0 + (right - left - 160.0) * f64::from(k) / 8.0;
        block([at, -440.0, floor - 320.0], [at + 40.0, -415.0, floor - 16.0], 6.0)
    });
    let x_rails = rail_pair(
        [left + 40.0, rear + 300.0 - 22.0, floor + 88.0],
        [right - 40.0, rear + 300.0 + 22.0, floor + 112.0],
        [0.0, 220.0, 0.0],
    );
    let chips = block([-40.0, -300.0, floor - 2.0], [centers + 40.0, 300.0, floor + 8.0], 3.0);
    let mut parts = vec![
        MachinePart::new("bed", "bed", "base", Paint::Frame, bed),
        MachinePart::new("bed_ribs", "bed", "base", Paint::Casting, SolidMesh::all(ribs)),
        MachinePart::new("chip_channel", "cover", "base", Paint::Bellows, chips),
        MachinePart::new("x_rails", "guide", "base", Paint::Rail, x_rails),
    ];

    // Headstock with the A axis, tailstock with its center.
    let stock = |a: f64, b: f64| prism(UnitAxis::X, [a, b], &tongue(240.0, floor - 2.0, 0.0, 190.0));
    let a_motor = cylinder([-520.0, 0.0, 0.0], [-1.0, 0.0, 0.0], 120.0, 90.0, 12.0);
    parts.push(MachinePart::new("headstock", "headstock", "base", Paint::Accent(accent), stock(-522.0, -92.0)));
    parts.push(MachinePart::new("a_drive", "motor", "base", Paint::Dark, a_motor));
    let tail = stock(centers + 190.0, centers + 520.0).and(cylinder(
        [centers + 192.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        70.0,
        110.0,
        6.0,
    ));
    let center =
        revolved([centers, 0.0, 0.0], [1.0, 0.0, 0.0], &[[0.0, 0.0], [28.0, 48.0], [28.0, 100.0], [0.0, 100.0]]);
    parts.push(MachinePart::new("tailstock", "tailstock", "base", Paint::Accent(accent), tail));
    parts.push(MachinePart::new("center", "tailstock", "base", Paint::Steel, center));
    let face = [[0.0, -90.0], [150.0, -90.0], [150.0, -40.0], [130.0, -34.0], [130.0, -4.0], [126.0, 0.0], [0.0, 0.0]];
    let plate = revolved([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], &face);
    let jaws = [0.0, 1.0, 2.0, 3.0].map(|k: f64| {
        let (s, c) = (k * 90.0_f64 + 45.0).to_radians().sin_cos();
        cylinder([-30.0, 80.0 * c, 80.0 * s], [1.0, 0.0, 0.0], 14.0, 29.5, 2.0)
    });
    parts.push(MachinePart::new("face_plate", "table", "A", Paint::Steel, plate));
    parts.push(MachinePart::new("face_plate_bolts", "table", "A", Paint::Dark, SolidMesh::all(jaws)));

    // Column on the rear bed; the slide climbs its front, and the ram goes through both.
    let front = rear + 30.0;
    let top = z[1] + pivot[2] + 420.0;
    let foot = floor + 130.0;
    let side =
        [[front, foot], [front + 540.0, foot], [front + 540.0, foot + 160.0], [front + 380.0, top], [front, top]];
    // The ram goes through a window between the legs.
    let window = [z[0] + pivot[2] - 170.0, z[1] + pivot[2] + 170.0];
    let tower = SolidMesh::all([
        prism(UnitAxis::X, [-430.0, -170.0], &side),
        prism(UnitAxis::X, [170.0, 430.0], &side),
        block([-174.0, front + 4.0, foot + 4.0], [174.0, front + 420.0, window[0]], 10.0),
        block([-174.0, front + 4.0, window[1]], [174.0, front + 370.0, top - 4.0], 10.0),
    ]);
    let tower_ribs = [[-446.0, -426.0], [426.0, 446.0]].into_iter().flat_map(|[a, b]| {
        (0..4).map(move |k| {
            let h = foot + 120.0 + (top - foot - 260.0) * f64::from(k) / 3.0;
            block([a, front + 20.0, h], [b, front + 360.0, h + 40.0], 6.0)
        })
    });
    let x_blocks = [-1.0, 1.0].into_iter().flat_map(|u| {
        [-1.0, 1.0].map(|v| {
            block(
                [u * 330.0 - 70.0, rear + 300.0 + v * 220.0 - 50.0, floor + 98.0],
                [u * 330.0 + 70.0, rear + 300.0 + v * 220.0 + 50.0, foot + 4.0],
                6.0,
            )
        })
    });
    let z_rails =
        rail_pair([-20.0, front - 20.0, z[0] + pivot[2] - 330.0], [20.0, front + 2.0, top - 20.0], [330.0, 0.0, 0.0]);
    parts.push(MachinePart::new("column", "column", "X", Paint::Casting, tower));
    parts.push(MachinePart::new("column_ribs", "column", "X", Paint::Frame, SolidMesh::all(tower_ribs)));
    parts.push(MachinePart::new("x_carriages", "guide", "X", Paint::Dark, SolidMesh::all(x_blocks)));
    parts.push(MachinePart::new("z_rails", "guide", "X", Paint::Rail, z_rails));

    // The slide clasps the ram; both are at the height of the pivot.
    let h = pivot[2];
    let ram = 130.0;
    let slide_front = front - 300.0;
    let ring = |lo: f64, hi: f64, wide: f64| block([-wide, slide_front, h + lo], [wide, front - 22.0, h + hi], 14.0);
    let slide = SolidMesh::all([
        ring(ram + 8.0, 300.0, 400.0),
        ring(-300.0, -ram - 8.0, 400.0),
        block([-400.0, slide_front, h - ram - 40.0], [-ram - 8.0, front - 22.0, h + ram + 40.0], 6.0),
        block([ram + 8.0, slide_front, h - ram - 40.0], [400.0, front - 22.0, h + ram + 40.0], 6.0),
    ]);
    let z_blocks = [-1.0, 1.0].into_iter().flat_map(|u| {
        [-220.0, 220.0].map(|v| {
            block([u * 330.0 - 40.0, front - 26.0, h + v - 60.0], [u * 330.0 + 40.0, front - 3.0, h + v + 60.0], 4.0)
        })
    });
    parts.push(MachinePart::new("slide", "saddle", "Z", Paint::Accent(accent), slide));
    parts.push(MachinePart::new("z_carriages", "guide", "Z", Paint::Dark, SolidMesh::all(z_blocks)));

    // Ram along y with the B axis in its middle; its front is at a distance from the spindle plane.
    let gap = 150.0;
    let ram_back = front + 200.0;
    let ram_body = block([-ram, gap, h - ram], [ram, ram_back, h + ram], 14.0);
    let y_rails =
        rail_pair([-ram - 6.0, gap + 40.0, h - 14.0], [-ram + 2.0, ram_back - 10.0, h + 14.0], [0.0, 0.0, 70.0]).and(
            rail_pair([ram - 2.0, gap + 40.0, h - 14.0], [ram + 6.0, ram_back - 10.0, h + 14.0], [0.0, 0.0, 70.0]),
        );
    let collar = cylinder([0.0, gap + 2.0, h], [0.0, -1.0, 0.0], 0.95 * ram, 30.0, 4.0);
    parts.push(MachinePart::new("ram", "ram", "Y", Paint::Casting, ram_body.and(collar)));
    parts.push(MachinePart::new("y_rails", "guide", "Y", Paint::Rail, y_rails));

    // Swivel head: disc on the ram, box round the spindle.
    let disc = cylinder([0.0, gap - 30.0, h], [0.0, -1.0, 0.0], 0.95 * ram, 30.0, 4.0);
    let cradle = block([-100.0, -96.0, numbers.gauge[2] + 110.0], [100.0, gap - 56.0, numbers.gauge[2] + 300.0], 20.0);
    parts.push(MachinePart::new("head", "head", "B", Paint::Accent(accent), disc.and(cradle)));
    parts.extend(spindle(numbers, size));
    Ok(parts)
}

/// Desktop mill with a horizontal spindle along z; y is up in the room.
pub(crate) fn pocket_nc(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [34, 110, 150];
    let face = numbers.table[1];
    let gauge = numbers.gauge[2];

    // Room: y up. Base plate below everything, a tower on the left for the table, rails on the right for the
    // spindle.
    let floor = -190.0;
    let base = block([-175.0, floor - 16.0, -110.0], [175.0, floor, 300.0], 6.0);
    let tower = block([-175.0, floor - 2.0, -110.0], [-128.0, 160.0, 40.0], 6.0);
    let tower_foot = prism(UnitAxis::X, [-160.0, -143.0], &[[floor - 2.0, 38.0], [-20.0, 38.0], [floor - 2.0, 160.0]]);
    let bridge = block([-175.0, floor - 2.0, 150.0], [175.0, floor + 40.0, 300.0], 6.0);
    let x_rails = rail_pair([-170.0, floor + 38.0, 219.0], [170.0, floor + 50.0, 231.0], [0.0, 0.0, 50.0]);
    let y_rails = rail_pair([-130.0, floor + 10.0, -41.0], [-118.0, 155.0, -29.0], [0.0, 0.0, 45.0]);
    let mut parts = vec![
        MachinePart::new("bed", "bed", "base", Paint::Frame, base.and(tower).and(bridge)),
        MachinePart::new("gusset", "bed", "base", Paint::Casting, tower_foot),
        MachinePart::new("x_rails", "guide", "base", Paint::Rail, x_rails),
        MachinePart::new("y_rails", "guide", "base", Paint::Rail, y_rails),
    ];

    // Spindle side: cross slide, upright, spindle slide, spindle.
    let saddle = block([-60.0, floor + 52.0, 158.0], [60.0, floor + 72.0, 292.0], 4.0)
        .and(block([-54.0, floor + 70.0, 160.0], [54.0, -70.0, 290.0], 10.0))
        .and(block([-58.0, -82.0, 130.0], [58.0, -62.0, 292.0], 4.0));
    let z_rails = rail_pair([-6.0, -64.0, 134.0], [6.0, -52.0, 288.0], [42.0, 0.0, 0.0]);
    parts.push(MachinePart::new("saddle", "saddle", "X", Paint::Accent(accent), saddle));
    parts.push(MachinePart::new("z_rails", "guide", "X", Paint::Rail, z_rails));
    let carrier = block([-55.0, -50.0, gauge + 48.0], [55.0, -34.0, gauge + 150.0], 4.0).and(block(
        [-42.0, -36.0, gauge + 50.0],
        [42.0, 38.0, gauge + 130.0],
        8.0,
    ));
    parts.push(MachinePart::new("spindle_slide", "headstock", "Z", Paint::Casting, carrier));
    parts.extend(spindle(numbers, Spindle { nose: 14.0, housing: 27.0, top: 170.0 }));

    // Table side: console on the tower, arm about A, table about B.
    let console = block([-116.0, -46.0, -84.0], [-98.0, 46.0, 10.0], 4.0).and(cylinder(
        [-100.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        36.0,
        24.0,
        3.0,
    ));
    let y_blocks = [-1.0, 1.0].map(|v| block([-126.0, 22.0 * v - 14.0, -90.0], [-114.0, 22.0 * v + 14.0, 20.0], 2.0));
    parts.push(MachinePart::new("console", "bearing", "Y", Paint::Accent(accent), console));
    parts.push(MachinePart::new("y_carriages", "guide", "Y", Paint::Dark, SolidMesh::all(y_blocks)));
    let low = face - 62.0;
    let arm = cylinder([-75.0, 0.0, 0.0], [1.0, 0.0, 0.0], 34.0, 18.0, 3.0)
        .and(block([-68.0, low, -26.0], [-58.0, 18.0, 26.0], 3.0))
        .and(block([-68.0, low, -30.0], [44.0, low + 12.0, 30.0], 3.0))
        .and(cylinder([0.0, low + 10.0, 0.0], [0.0, 1.0, 0.0], 34.0, 30.0, 3.0));
    parts.push(MachinePart::new("arm", "cradle", "A", Paint::Casting, arm));
    let disc = slotted_disc([0.0, 0.0], 44.0, face, 14.0, 3).laid_back();
    // Laid back, z of the disc is y of the machine.
    let hub = cylinder([0.0, face - 24.0, 0.0], [0.0, 1.0, 0.0], 28.0, 12.0, 1.0);
    parts.push(MachinePart::new("table", "table", "B", Paint::Steel, disc));
    parts.push(MachinePart::new("table_hub", "table", "B", Paint::Dark, hub));
    Ok(parts)
}

/// Belt grinder: the tool hangs still on a portal, the blade comes to it on X, Y, Z, B, C.
pub(crate) fn lu_serial(numbers: &KinematicNumbers) -> Result<Vec<MachinePart>, TaskError> {
    let accent = [46, 84, 120];
    let trunnion = Trunnion { on: "Z", tilt: "B", turn: "C", radius: 120.0, accent };
    let [x, y, z] = ["X", "Y", "Z"].map(|n| numbers.travel(n));
    let (x, y, z) = (x?, y?, z?);
    let under = trunnion.floor(numbers)?;
    let console = under - 40.0;
    // The post stays 120 mm deep in its sleeve at the highest Z; the sleeve ends below the console at the
    // lowest.
    let sleeve_top = console + z[0] - 12.0;
    let post_low = sleeve_top - 120.0 - z[1];
    let y_top = post_low + z[0] - 20.0;
    let half = [210.0, trunnion.half_width() + 20.0];
    let y_deck = y_top;
    let x_deck = y_deck - 74.0;
    let floor = x_deck - 74.0;
    let portal = Gantry {
        on: ["base", "base", "base"],
        travel: [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
        ram: 90.0,
        foot: 240.0,
        floor,
        clear: [half[0] + x[1].abs().max(x[0].abs()) + 60.0, half[1] + y[1].abs().max(y[0].abs()) + 60.0],
        accent,
    };
    let mut parts: Vec<MachinePart> = portal
        .parts()
        .into_iter()
        .filter(|p| !["z_rails", "x_rails", "x_bellows", "x_carriages"].contains(&p.name.as_str()))
        .collect();
    parts.extend(spindle(numbers, Spindle { nose: 34.0, housing: 58.0, top: 242.0 }));

    // Cross slides with the sleeve on top, post and console below the trunnion.
    let reach_x = half[0] + x[0].abs().max(x[1].abs());
    let rails_x = rail_pair([-reach_x, -16.0, floor - 2.0], [reach_x, 16.0, floor + 14.0], [0.0, 0.6 * half[1], 0.0]);
    let reach_y = half[1] + y[0].abs().max(y[1].abs());
    let plate_x = block([-half[0], -reach_y, floor + 24.0], [half[0], reach_y, x_deck], 8.0);
    let rails_y = rail_pair(
        [-16.0, -reach_y + 10.0, x_deck - 2.0],
        [16.0, reach_y - 10.0, x_deck + 14.0],
        [0.6 * half[0], 0.0, 0.0],
    );
    let blocks_x = [-1.0, 1.0].into_iter().flat_map(|u| {
        [-1.0, 1.0].map(|v| {
            block(
                [u * 0.7 * half[0] - 34.0, v * 0.6 * half[1] - 30.0, floor + 4.0],
                [u * 0.7 * half[0] + 34.0, v * 0.6 * half[1] + 30.0, floor + 26.0],
                4.0,
            )
        })
    });
    let blocks_y = [-1.0, 1.0].into_iter().flat_map(|u| {
        [-1.0, 1.0].map(|v| {
            block(
                [u * 0.6 * half[0] - 30.0, v * 0.7 * half[1] - 34.0, x_deck + 4.0],
                [u * 0.6 * half[0] + 30.0, v * 0.7 * half[1] + 34.0, x_deck + 26.0],
                4.0,
            )
        })
    });
    let sleeve = block([-half[0], -half[1], x_deck + 24.0], [half[0], half[1], y_deck], 8.0)
        .and(block([-150.0, -150.0, y_deck - 2.0], [150.0, 150.0, y_deck + 120.0], 16.0))
        .and(cylinder([0.0, 0.0, y_deck + 100.0], UnitAxis::Z.unit(), 118.0, sleeve_top - y_deck - 100.0, 6.0));
    let post = cylinder([0.0, 0.0, post_low], UnitAxis::Z.unit(), 84.0, console - post_low + 4.0, 4.0);
    let plate = block([-0.8 * half[0], -half[1], console], [0.8 * half[0], half[1], under], 8.0);
    parts.extend([
        MachinePart::new("x_rails", "guide", "base", Paint::Rail, rails_x),
        MachinePart::new("x_slide", "slide", "X", Paint::Casting, plate_x),
        MachinePart::new("x_carriages", "guide", "X", Paint::Dark, SolidMesh::all(blocks_x)),
        MachinePart::new("y_rails", "guide", "X", Paint::Rail, rails_y),
        MachinePart::new("y_slide", "slide", "Y", Paint::Accent(accent), sleeve),
        MachinePart::new("y_carriages", "guide", "Y", Paint::Dark, SolidMesh::all(blocks_y)),
        MachinePart::new("post", "guide", "Z", Paint::Rail, post),
        MachinePart::new("console", "slide", "Z", Paint::Casting, plate),
    ]);
    parts.extend(trunnion.parts(numbers)?);
    Ok(parts)
}
