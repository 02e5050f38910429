//! A machine as a picture: its bodies at home, the axes as arrows with their letters, and a list of what
//! moves how far.
//!
//! ```text
//!   name
//!   +------------------------+   X  tool       -381 to 381 mm
//!   |   bodies, each in its  |   A  workpiece  -120 to 30 deg
//!   |   color, seen from the |   ...
//!   |   right front          |   [] bed        [] column
//!   +------------------------+
//! ```
//!
//! An arrow of a slide points along the motion of what it carries for a growing value; an arc about a
//! rotary axis shows the same. A table that turns against its programmed value (ISO 841) is therefore drawn
//! so. The tripod is in the middle of the clamping surface, the ring on the gauge line.

use proveout_geom::{Aabb, Point, Vector};
use proveout_machine::{Attachment, Carries, Joint, Machine};

use crate::{
    canvas::{Canvas, width_of},
    color::NEUTRAL_INK,
    error::RecordError,
    projection::Projection,
};

/// Points of the view, and of the whole picture.
const VIEW: [usize; 2] = [820, 760];
const SIZE: [usize; 2] = [1300, 830];
const MARGIN: usize = 16;
const TITLE: usize = 34;
const LINE: usize = 22;
/// Direction to the viewer: at the right in front, above.
const BACK: [f64; 3] = [0.62, -1.0, 0.62];
/// Length of an arrow, and radius of an arc, as a share of the machine's diagonal.
const ARROW: f64 = 0.11;
const BACKGROUND: [u8; 3] = [250, 250, 250];
/// Shorter products of directions and ways (mm) have no direction.
const SHORTEST: f64 = 1e-9;

/// A machine at home as PNG.
///
/// # Errors
/// [`RecordError::Picture`] where the machine has no bodies, or the encoder refuses.
pub fn machine_png(machine: &Machine) -> Result<Vec<u8>, RecordError> {
    draw(machine)?.png()
}

fn draw(machine: &Machine) -> Result<Canvas, RecordError> {
    let home = machine.home();
    let mut room = Aabb::empty();
    let mut of_joint = vec![Aabb::empty(); machine.joints.len()];
    let mut meshes = Vec::new();
    for (i, body) in machine.bodies.iter().enumerate() {
        let mesh = body.mesh.transformed(&machine.body_pose(i, &home));
        let own = mesh.aabb();
        if own.is_empty() || !own.min.iter().chain(own.max.iter()).all(|v| v.is_finite()) {
            continue;
        }
        room = room.union(&own);
        if let Attachment::Joint(j) = body.attached_to {
            of_joint[j] = of_joint[j].union(&own);
        }
        meshes.push((mesh, [body.color[0], body.color[1], body.color[2]]));
    }
    if room.is_empty() {
        let message = format!("{} has no bodies to draw: give it [[body]] tables or a model", machine.name);
        return Err(RecordError::Picture { message });
    }
    let view = Projection::fitting(&room, &Vector::from(BACK), &machine.up.unwrap_or_else(Vector::z), VIEW);
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]);
    canvas.text([MARGIN, MARGIN], &cut(&machine.name, SIZE[0] - 2 * MARGIN));
    let at = [MARGIN, MARGIN + TITLE];
    canvas.fill(at, VIEW, BACKGROUND);
    let mut pen = Pen { canvas: &mut canvas, at, depth: vec![f64::NEG_INFINITY; VIEW[0] * VIEW[1]], view: &view };
    for (mesh, color) in &meshes {
        for t in 0..mesh.triangles.len() {
            pen.triangle(mesh.corners(t), *color);
        }
    }
    let length = ARROW * room.size().norm();
    let table = machine.machine_from_table(&home);
    let middle = table.point(&machine.table.point);
    for (k, color) in [(0, [200, 30, 30]), (1, [0, 120, 60]), (2, [20, 70, 200])] {
        let mut way = Vector::zeros();
        way[k] = 0.35 * length;
        pen.line(middle, middle + table.vector(&way), color, 1);
    }
    let gauge = Point::from(machine.machine_from_spindle(&home).translation);
    pen.ring(gauge);
    let poses = machine.joint_poses(&home);
    for (j, joint) in machine.joints.iter().enumerate() {
        let (pose, color) = (&poses[j], color_of(joint));
        let direction = pose.vector(&joint.direction);
        let sense = joint.sense;
        if joint.is_rotary() {
            pen.arc(&pose.point(&joint.point), &(direction * sense), 0.6 * length, color, &joint.name);
        } else {
            let from = if of_joint[j].is_empty() { gauge } else { of_joint[j].center() };
            pen.arrow(from, from + direction * (sense * length), color, &joint.name);
        }
    }
    canvas.frame(at, VIEW);
    list(machine, &mut canvas);
    Ok(canvas)
}

/// Colors of the letters: X and A, Y and B, Z and C, others.
fn color_of(joint: &Joint) -> [u8; 3] {
    match joint.name.chars().next() {
        Some('X' | 'A' | 'U') => [200, 30, 30],
        Some('Y' | 'B' | 'V') => [0, 120, 60],
        Some('Z' | 'C' | 'W') => [20, 70, 200],
        _ => [150, 60, 160],
    }
}

/// Joints with their travel, and bodies with their colors, next to the view.
fn list(machine: &Machine, canvas: &mut Canvas) {
    let left = MARGIN + VIEW[0] + 24;
    let wide = SIZE[0] - left - MARGIN;
    let mut y = MARGIN + TITLE;
    for joint in &machine.joints {
        let unit = joint.kind.unit();
        let side = if joint.carries == Carries::Tool { "tool" } else { "work" };
        let range = match joint.travel {
            _ if joint.held => "held".to_owned(),
            Some([low, high]) => {
                format!("{:.0} to {:.0} {unit}", joint.kind.in_unit(low), joint.kind.in_unit(high))
            }
            None if joint.endless => "endless".to_owned(),
            None => "no travel stated".to_owned(),
        };
        let trust = if machine.travel_is_chosen(joint) == Some(true) { ", chosen" } else { "" };
        canvas.fill([left, y], [14, 14], color_of(joint));
        canvas.text([left + 24, y], &cut(&format!("{} {side} {range}{trust}", joint.name), wide - 24));
        y += LINE;
    }
    y += LINE;
    for body in &machine.bodies {
        if y + LINE > SIZE[1] - MARGIN {
            canvas.text([left, y], "...");
            break;
        }
        canvas.fill([left, y], [14, 14], [body.color[0], body.color[1], body.color[2]]);
        let on = match body.attached_to {
            Attachment::Joint(j) => machine.joints[j].name.as_str(),
            Attachment::Base => "base",
        };
        canvas.text([left + 24, y], &cut(&format!("{} ({on})", body.name), wide - 24));
        y += LINE;
    }
}

/// A text that fits into so many points.
fn cut(text: &str, points: usize) -> String {
    let letter = width_of("n");
    let most = points / letter;
    if text.chars().count() <= most {
        text.to_owned()
    } else {
        text.chars().take(most.saturating_sub(3)).collect::<String>() + "..."
    }
}

/// Draws into the view.
struct Pen<'a> {
    canvas: &'a mut Canvas,
    at: [usize; 2],
    depth: Vec<f64>,
    view: &'a Projection,
}

impl Pen<'_> {
    fn triangle(&mut self, corners: [Point; 3], color: [u8; 3]) {
        self.view.triangle(corners, |[x, y], depth, shade| {
            let nearest = &mut self.depth[y * VIEW[0] + x];
            if depth > *nearest {
                *nearest = depth;
                let color = color.map(|v| (f64::from(v) * shade).round() as u8);
                self.canvas.dot((self.at[0] + x) as isize, (self.at[1] + y) as isize, color);
            }
        });
    }

    fn dot(&mut self, x: f64, y: f64, color: [u8; 3]) {
        if x >= 0.0 && y >= 0.0 && x < VIEW[0] as f64 && y < VIEW[1] as f64 {
            self.canvas.dot((self.at[0] + x as usize) as isize, (self.at[1] + y as usize) as isize, color);
        }
    }

    /// A straight line over everything, `half` points to each side.
    fn line(&mut self, from: Point, to: Point, color: [u8; 3], half: i32) {
        let ([x0, y0, _], [x1, y1, _]) = (self.view.place(&from), self.view.place(&to));
        let steps = (2.0 * (x1 - x0).abs().max((y1 - y0).abs())).ceil().clamp(1.0, 8000.0) as usize;
        for k in 0..=steps {
            let t = k as f64 / steps as f64;
            let (x, y) = (x0 + (x1 - x0) * t, y0 + (y1 - y0) * t);
            for u in -half..=half {
                for v in -half..=half {
                    self.dot(x + f64::from(u), y + f64::from(v), color);
                }
            }
        }
    }

    fn arrow(&mut self, from: Point, to: Point, color: [u8; 3], name: &str) {
        self.line(from, to, color, 2);
        self.head(from, to, color);
        self.name(&to, name);
    }

    /// Two strokes back from the tip, in the plane of the picture.
    fn head(&mut self, from: Point, to: Point, color: [u8; 3]) {
        let way = to - from;
        let side = way.cross(&self.view.back).try_normalize(SHORTEST).unwrap_or(self.view.right) * (0.12 * way.norm());
        for s in [-1.0, 1.0] {
            self.line(to, to - way * 0.25 + side * s, color, 2);
        }
    }

    /// The axis through a point, and three quarters of a turn about it.
    fn arc(&mut self, middle: &Point, about: &Vector, radius: f64, color: [u8; 3], name: &str) {
        self.line(middle - about * (1.6 * radius), middle + about * (1.6 * radius), color, 0);
        let seed = if about.z.abs() < 0.9 { Vector::z() } else { Vector::x() };
        let Some(u) = seed.cross(about).try_normalize(SHORTEST) else { return };
        let v = about.cross(&u);
        let at = |k: u32| {
            let angle = f64::from(k) * 0.75 * std::f64::consts::TAU / 48.0;
            middle + u * (radius * angle.cos()) + v * (radius * angle.sin())
        };
        for k in 0..48 {
            self.line(at(k), at(k + 1), color, 1);
        }
        self.head(at(47) + (at(47) - at(48)) * 6.0, at(48), color);
        self.name(&(middle + about * (1.6 * radius)), name);
    }

    /// A ring about a point.
    fn ring(&mut self, middle: Point) {
        let [x, y, _] = self.view.place(&middle);
        for k in 0..120 {
            let (sin, cos) = (f64::from(k) / 120.0 * std::f64::consts::TAU).sin_cos();
            for r in [6.0, 7.0] {
                self.dot(x + r * cos, y + r * sin, NEUTRAL_INK);
            }
        }
    }

    /// A name next to a place, on white.
    fn name(&mut self, place: &Point, name: &str) {
        let [x, y, _] = self.view.place(place);
        let (wide, high) = (width_of(name) as f64, 14.0);
        let x = (x + 8.0).clamp(4.0, (VIEW[0] as f64 - wide - 8.0).max(4.0));
        let y = (y - 18.0).clamp(4.0, VIEW[1] as f64 - high - 8.0);
        let corner = [self.at[0] + x as usize, self.at[1] + y as usize];
        self.canvas.fill([corner[0] - 3, corner[1] - 3], [wide as usize + 4, high as usize + 6], [255; 3]);
        self.canvas.text(corner, name);
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn machine(name: &str) -> Machine {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name);
        Machine::read(&folder).unwrap_or_else(|e| panic!("{e}"))
    }

    fn count(canvas: &Canvas, color: [u8; 3]) -> usize {
        canvas.colors.chunks(3).filter(|c| *c == color).count()
    }

    #[test]
    fn every_axis_is_drawn_in_its_color_over_the_bodies() {
        let canvas = draw(&machine("bc-trunnion")).expect("a picture");
        assert_eq!((canvas.width, canvas.height), (SIZE[0], SIZE[1]));
        // Arrow, arc and swatch of X; of Y and B; of Z and C.
        for color in [[200, 30, 30], [0, 120, 60], [20, 70, 200]] {
            assert!(count(&canvas, color) > 400, "{color:?}: {}", count(&canvas, color));
        }
        // The view is filled by a good part with bodies.
        assert!(count(&canvas, BACKGROUND) < VIEW[0] * VIEW[1] * 3 / 4);
    }

    /// What is nearer hides what is farther away: the picture does not depend on the order of the bodies.
    #[test]
    fn the_order_of_the_bodies_does_not_matter() {
        let one = machine("three-axis-mill");
        let mut other = one.clone();
        other.bodies.reverse();
        let view = |m: &Machine| {
            let canvas = draw(m).expect("a picture");
            let row = 3 * canvas.width;
            let part = |y: usize| canvas.colors[y * row..][..3 * (MARGIN + VIEW[0])].to_vec();
            (0..canvas.height).flat_map(part).collect::<Vec<u8>>()
        };
        let different = view(&one).chunks(3).zip(view(&other).chunks(3)).filter(|(a, b)| a != b).count();
        assert!(different < 200, "{different} points of faces in one plane");
    }

    #[test]
    fn a_machine_without_bodies_is_reported() {
        let mut bare = machine("three-axis-mill");
        bare.bodies.clear();
        assert!(machine_png(&bare).is_err_and(|e| e.to_string().contains("no bodies to draw")));
    }

    #[test]
    fn a_long_name_is_cut() {
        assert_eq!(cut("abcdef", 1000), "abcdef");
        assert!(cut(&"n".repeat(400), 120).ends_with("..."));
    }
}
