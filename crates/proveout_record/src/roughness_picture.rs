//! A height map as a picture: colors, a bar with units, both axes in mm, the direction of the lay.
//!
//! ```text
//!   title                                   y up, x to the right, one scale for both
//!   +--------------------+  +-+ 1.2
//!   |                    |  | |             bar from the lowest to the highest height, um
//!   |        map         |  | | 0.0
//!   |                    |  +-+ um
//!   +--------------------+   /              the lay, as the marks run on the map
//!   0      1      2   mm   lay 63.5°
//! ```

use std::path::Path;

use proveout_surface::texture::HeightMap;

use crate::{
    canvas::{Canvas, width_of},
    color::{NEUTRAL_INK, height_color},
    error::RecordError,
    units::{MM_PER_UM, UM_PER_MM},
};

/// Points of the longer side of the map.
const MAP_POINTS: f64 = 720.0;
/// A shorter side is drawn no thinner than this.
const LEAST_POINTS: usize = 48;
const MARGIN: usize = 14;
const BAR_WIDTH: usize = 26;
/// Room to the right of the bar for its numbers.
const BAR_ROOM: usize = 110;
/// Room to the left of and below the map for the numbers of the axes.
const AXIS_ROOM: [usize; 2] = [84, 52];
const TITLE_ROOM: usize = 40;
/// Half of the line that shows the lay.
const LAY_HALF: f64 = 34.0;
/// Part of a step, or of the whole scale, that a mark may be past its end by: rounding.
const ROUNDING: f64 = 1e-9;

/// Round numbers within an interval, about `count` of them, with the decimals that they need.
fn ticks(low: f64, high: f64, count: f64) -> (Vec<f64>, usize) {
    let span = high - low;
    let power = 10_f64.powf((span / count).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| span / s <= count).unwrap_or(10.0 * power);
    if !(step.is_normal() && span.is_finite()) {
        return (vec![low], 3);
    }
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (low / step - ROUNDING).ceil();
    let values = (0..).map(|k| (first + f64::from(k)) * step).take_while(|v| *v <= high + ROUNDING * span).take(50);
    // No minus before zero.
    (values.map(|v| if v.abs() < ROUNDING * step { 0.0 } else { v }).collect(), decimals)
}

/// A height map as PNG. `lay` is the direction of the marks, rad from x; a title is drawn as it is.
///
/// # Errors
/// [`RecordError::Picture`] where the encoder refuses, which it does not for sizes like these.
pub fn height_map_png(map: &HeightMap, title: &str, lay: Option<f64>) -> Result<Vec<u8>, RecordError> {
    draw(map, title, lay).png()
}

/// Writes a height map as PNG.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_height_map_png(path: &Path, map: &HeightMap, title: &str, lay: Option<f64>) -> Result<(), RecordError> {
    std::fs::write(path, height_map_png(map, title, lay)?).map_err(RecordError::io(path))
}

fn draw(map: &HeightMap, title: &str, lay: Option<f64>) -> Canvas {
    let [sx, sy] = map.size();
    let scale = MAP_POINTS / sx.max(sy);
    let [w, h] = [sx, sy].map(|s| ((s * scale).round() as usize).max(LEAST_POINTS));
    let (left, top) = (MARGIN + AXIS_ROOM[0], MARGIN + TITLE_ROOM);
    let bar_left = left + w + 2 * MARGIN;
    let width = (bar_left + BAR_WIDTH + BAR_ROOM).max(left + width_of(title) + MARGIN);
    let bar_height = h.min(MAP_POINTS as usize).max(160);
    let height = top + h.max(bar_height + 2 * LAY_HALF as usize + 60) + AXIS_ROOM[1];
    let mut canvas = Canvas::new(width, height);
    let low = map.heights().iter().copied().fold(f64::INFINITY, f64::min);
    let high = map.heights().iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let share = |z: f64| if high > low { (z - low) / (high - low) } else { 0.5 };

    canvas.text([left, MARGIN], title);
    // A point of the picture shows the mean of the nodes that fall on it, or the nearest one.
    let range = |k: usize, points: usize, nodes: usize| {
        let at = |k: usize| (k as f64 / points as f64 * (nodes - 1) as f64 + 0.5).floor() as usize;
        at(k)..(at(k + 1)).max(at(k) + 1).min(nodes)
    };
    for v in 0..h {
        let rows = range(h - 1 - v, h, map.rows());
        for u in 0..w {
            let (mut sum, mut count) = (0.0, 0.0);
            for j in rows.clone() {
                for i in range(u, w, map.columns()) {
                    sum += map.at(i, j);
                    count += 1.0;
                }
            }
            canvas.dot((left + u) as isize, (top + v) as isize, height_color(share(sum / count)));
        }
    }
    canvas.frame([left, top], [w, h]);

    let (values, decimals) = ticks(0.0, sx, 6.0);
    for value in &values {
        let x = left + (value / sx * (w - 1) as f64).round() as usize;
        canvas.fill([x, top + h + 1], [1, 6], NEUTRAL_INK);
        let text = format!("{value:.decimals$}");
        canvas.text([x.saturating_sub(width_of(&text) / 2), top + h + 12], &text);
    }
    canvas.text([left + w - width_of("x mm"), top + h + 32], "x mm");
    let (values, decimals) = ticks(0.0, sy, 6.0);
    for value in &values {
        let y = top + h - 1 - (value / sy * (h - 1) as f64).round() as usize;
        canvas.fill([left - 7, y], [6, 1], NEUTRAL_INK);
        let text = format!("{value:.decimals$}");
        canvas.text([(left - 12).saturating_sub(width_of(&text)), y.saturating_sub(7)], &text);
    }
    canvas.text([left - 12 - width_of("y mm"), MARGIN + 12], "y mm");

    for v in 0..bar_height {
        let t = 1.0 - v as f64 / (bar_height - 1) as f64;
        canvas.fill([bar_left, top + v], [BAR_WIDTH, 1], height_color(t));
    }
    canvas.frame([bar_left, top], [BAR_WIDTH, bar_height]);
    let (values, decimals) = ticks(UM_PER_MM * low, UM_PER_MM * high, 8.0);
    for value in &values {
        let y = top + ((1.0 - share(MM_PER_UM * value)) * (bar_height - 1) as f64).round() as usize;
        canvas.fill([bar_left + BAR_WIDTH + 1, y], [6, 1], NEUTRAL_INK);
        canvas.text([bar_left + BAR_WIDTH + 11, y.saturating_sub(7)], &format!("{value:.decimals$}"));
    }
    canvas.text([bar_left, top - 24], "µm");

    let below = top + bar_height + 24;
    match lay {
        Some(angle) => {
            canvas.line([(bar_left + 40) as f64, below as f64 + LAY_HALF], LAY_HALF, angle);
            canvas.text([bar_left, below + 2 * LAY_HALF as usize + 10], &format!("lay {:.1}°", angle.to_degrees()));
        }
        None => canvas.text([bar_left, below], "no lay"),
    }
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> HeightMap {
        let heights =
            (0..columns * rows).map(|k| height((k % columns) as f64 * 0.01, (k / columns) as f64 * 0.01)).collect();
        HeightMap::new(columns, rows, 0.01, 0.01, heights).expect("a map")
    }

    fn decoded(bytes: &[u8]) -> (usize, usize, Vec<u8>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a picture");
        let mut colors = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut colors).expect("a frame");
        (info.width as usize, info.height as usize, colors)
    }

    #[test]
    fn a_map_is_drawn_upright_with_its_bar() {
        // High where x and y are large: the upper right corner.
        let bytes = height_map_png(&map(201, 101, |x, y| 0.001 * (x + 2.0 * y)), "ramp", Some(0.5)).expect("drawn");
        let (width, height, colors) = decoded(&bytes);
        let at = |x: usize, y: usize| {
            let k = 3 * (y * width + x);
            [colors[k], colors[k + 1], colors[k + 2]]
        };
        let (left, top) = (MARGIN + AXIS_ROOM[0], MARGIN + TITLE_ROOM);
        assert_eq!(at(left, top + 359), height_color(0.0), "lower left");
        assert_eq!(at(left + 719, top), height_color(1.0), "upper right");
        let bar = left + 720 + 2 * MARGIN + 3;
        assert_eq!((at(bar, top), at(bar, top + 359)), (height_color(1.0), height_color(0.0)));
        assert!(width > bar && height > top + 360);
        // Letters are there: ink in the row of the title and next to the bar.
        assert!((left..left + 60).any(|x| at(x, MARGIN + 4) == NEUTRAL_INK));
        assert!((top..top + 360).any(|y| at(bar + BAR_WIDTH + 10, y) == NEUTRAL_INK));
        assert_eq!(
            bytes,
            height_map_png(&map(201, 101, |x, y| 0.001 * (x + 2.0 * y)), "ramp", Some(0.5)).expect("drawn")
        );
    }

    #[test]
    fn the_line_of_the_lay_turns_with_it() {
        let ink = |lay: f64| {
            let canvas = draw(&map(21, 21, |x, _| x), "", Some(lay));
            let (x, y) =
                (MARGIN + AXIS_ROOM[0] + 720 + 2 * MARGIN + 40, MARGIN + TITLE_ROOM + 720 + 24 + LAY_HALF as usize);
            let at = |x: usize, y: usize| canvas.colors[3 * (y * canvas.width + x)] != 255;
            (at(x + 20, y), at(x, y - 20), at(x + 15, y - 15))
        };
        assert_eq!(ink(0.0), (true, false, false));
        assert_eq!(ink(std::f64::consts::FRAC_PI_2), (false, true, false));
        assert_eq!(ink(std::f64::consts::FRAC_PI_4), (false, false, true));
    }

    #[test]
    fn flat_maps_and_strips_are_drawn() {
        for (columns, rows) in [(2, 2), (2, 500), (900, 2), (1500, 700)] {
            let bytes = height_map_png(&map(columns, rows, |_, _| 0.25), "flat", None).expect("drawn");
            let (width, height, _) = decoded(&bytes);
            assert!(width < 2000 && height < 1200, "{width} x {height}");
        }
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 4.0, 6.0), (vec![0.0, 1.0, 2.0, 3.0, 4.0], 0));
        assert_eq!(ticks(-0.35, 0.22, 8.0).1, 1);
        assert!(ticks(-0.35, 0.22, 8.0).0.iter().all(|v| (-0.35..=0.22).contains(v)));
        assert_eq!(ticks(1.0, 1.0, 8.0).0, vec![1.0]);
    }
}
