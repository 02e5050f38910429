//! A section of a stock as a drawing (SVG) and as a table (CSV).

use std::{fmt::Write, fs, path::Path};

use proveout_sim::measure::{Outlines, Section};

use crate::error::RecordError;

/// Room round the drawing, part of its longer edge.
const MARGIN: f64 = 0.05;
/// Least side of a section that the margin is a part of, mm.
const LEAST_SIDE_MM: f64 = 1e-3;

/// Coordinates to the right and upward of a section across an axis: x y, y z, x z.
fn plane(axis: char) -> [usize; 2] {
    match axis {
        'x' => [1, 2],
        'y' => [0, 2],
        _ => [0, 1],
    }
}

/// Draws a section at the size of the part (1 unit is 1 mm): material gray, the design as a red line.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_section_svg(path: &Path, section: &Section) -> Result<(), RecordError> {
    fs::write(path, svg(section)).map_err(RecordError::io(path))
}

/// Writes the points of a section: one row a point, with the body, the number of its outline and x, y, z in
/// mm.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_section_csv(path: &Path, section: &Section) -> Result<(), RecordError> {
    let mut text = String::from("body,outline,x_mm,y_mm,z_mm\n");
    for (name, body) in bodies(section) {
        for (k, line) in body.outlines.iter().enumerate() {
            for [x, y, z] in &line.points_mm {
                // A string takes everything.
                writeln!(text, "{name},{},{x},{y},{z}", k + 1).ok();
            }
        }
    }
    fs::write(path, text).map_err(RecordError::io(path))
}

fn bodies(section: &Section) -> impl Iterator<Item = (&'static str, &Outlines)> {
    std::iter::once(("stock", &section.stock)).chain(section.design.iter().map(|d| ("design", d)))
}

fn svg(section: &Section) -> String {
    let [u, v] = plane(section.axis);
    let points = bodies(section).flat_map(|(_, b)| &b.outlines).flat_map(|l| &l.points_mm);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        for (k, x) in [p[u], p[v]].into_iter().enumerate() {
            (low[k], high[k]) = (low[k].min(x), high[k].max(x));
        }
    }
    if low[0] > high[0] {
        (low, high) = ([0.0; 2], [1.0; 2]);
    }
    let margin = MARGIN * (high[0] - low[0]).max(high[1] - low[1]).max(LEAST_SIDE_MM);
    let (width, height) = (high[0] - low[0] + 2.0 * margin, high[1] - low[1] + 2.0 * margin);
    let names = ["X", "Y", "Z"];
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.3}mm\" height=\"{height:.3}mm\" \
         viewBox=\"{:.4} {:.4} {width:.4} {height:.4}\">\n\
         <title>Section {}={} mm, {} to the right, {} upward, material {:.3} mm²</title>\n",
        low[0] - margin,
        -high[1] - margin,
        section.axis,
        section.at_mm,
        names[u],
        names[v],
        section.stock.area_mm2
    );
    let styles = [("stock", "fill=\"#c3c9d0\" stroke=\"#3a4450\""), ("design", "fill=\"none\" stroke=\"#d03040\"")];
    for ((name, body), (_, style)) in bodies(section).zip(styles) {
        let mut path = String::new();
        for line in &body.outlines {
            for (k, p) in line.points_mm.iter().enumerate() {
                // Upward is down in SVG.
                write!(path, "{}{:.5} {:.5}", if k == 0 { "M" } else { "L" }, p[u], 0.0 - p[v]).ok();
            }
            path.push('Z');
        }
        writeln!(
            out,
            "<path id=\"{name}\" {style} stroke-width=\"1\" vector-effect=\"non-scaling-stroke\" fill-rule=\"evenodd\" d=\"{path}\"/>"
        )
        .ok();
    }
    out.push_str("</svg>\n");
    out
}

#[cfg(test)]
mod tests {
    use proveout_sim::measure::ClosedLine;

    use super::*;

    fn square(axis: char) -> Section {
        let points_mm = vec![[0.0, 1.0, 2.0], [4.0, 1.0, 2.0], [4.0, 3.0, 7.0], [0.0, 3.0, 7.0]];
        let line = ClosedLine { area_mm2: 8.0, length_mm: 12.0, points_mm };
        let stock = Outlines { area_mm2: 8.0, outlines: vec![line] };
        Section { axis, at_mm: 2.0, stock: stock.clone(), design: Some(stock) }
    }

    #[test]
    fn the_drawing_has_the_size_of_the_part_and_up_is_up() {
        let text = svg(&square('z'));
        assert!(
            text.contains("width=\"4.400mm\" height=\"2.400mm\" viewBox=\"-0.2000 -3.2000 4.4000 2.4000\""),
            "{text}"
        );
        assert_eq!(text.matches("M0.00000 -1.00000L4.00000 -1.00000L4.00000 -3.00000L0.00000 -3.00000Z").count(), 2);
        assert!(svg(&square('y')).contains("M0.00000 -2.00000L4.00000 -2.00000L4.00000 -7.00000"), "x and z");
        assert!(svg(&square('x')).contains("M1.00000 -2.00000"), "y and z");
    }

    #[test]
    fn the_table_has_a_row_for_each_point() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("s.csv");
        write_section_csv(&path, &square('z')).expect("written");
        let text = fs::read_to_string(&path).expect("there");
        assert_eq!(text.lines().count(), 1 + 8);
        assert!(text.contains("stock,1,4,3,7\n") && text.contains("design,1,0,1,2\n"), "{text}");
    }
}
