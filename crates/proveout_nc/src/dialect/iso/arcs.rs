//! G2 and G3: centers (I J K), radius (R), helices, several turns (P of `LinuxCNC`).

use std::f64::consts::TAU;

use super::flavor::Flavor;
use super::pending::Pending;
use super::run_state::Interpreter;
use crate::AxisValues;
use crate::arc::{self, ArcFault, PlaneArc};
use crate::channel::{arc_fault, differ_by_little};
use crate::codes;
use crate::control::{ArcTolerance, Centers};
use crate::diagnostic::{Fault, Span};
use crate::g_code::G6;

const CENTER: [u8; 3] = *b"IJK";
/// Difference of the radii that a `LinuxCNC` takes whatever the radius, mm or inch
/// (`CENTER_ARC_RADIUS_TOLERANCE_MM`, `_INCH`).
const SPIRAL_MM: f64 = 0.02 * std::f64::consts::SQRT_2;
const SPIRAL_INCH: f64 = 0.002 * std::f64::consts::SQRT_2;
/// How much shorter than half of the chord a radius R may be there (`RADIUS_TOLERANCE_MM`, and as much in
/// inch).
const SHORT_RADIUS_MM: f64 = 0.001_27;
/// Above it, up to a hundred times as much, this part of the larger radius (`SPIRAL_RELATIVE_TOLERANCE`).
const SPIRAL_RELATIVE: f64 = 1e-3;

impl Interpreter {
    pub(crate) fn arc(&mut self, p: &mut Pending, clockwise: bool, span: Span) -> Result<(), Fault> {
        if self.is_fagor_polar(p, true) {
            return self.fagor_polar_arc(p, clockwise, span);
        }
        let [u, v, w] = self.modal.plane_axes();
        let start = self.arc_start("the arc", [u, v, w], span)?;
        let turns = if self.own.flavor.is_linuxcnc() { p.take(b'P') } else { None };
        let radius = self.length_of(p, b'R');
        let mut center = start;
        let mut words = [None; 3];
        let once = self.settings.control.depth_in_i && p.g(super::words::Group::OneShot) == Some(G6);
        let absolute = self.modal.absolute_centers || once;
        for (axis, letter) in CENTER.into_iter().enumerate() {
            let Some(value) = self.length_of(p, letter) else { continue };
            if axis == w {
                if value != 0.0 && !absolute {
                    let message = format!("`{}` does not lie in the working plane G{}", char::from(letter), 19 - w);
                    return Err(
                        Fault::new(codes::ARC_GEOMETRY, span, message).help("choose the plane with G17, G18 or G19")
                    );
                }
                continue;
            }
            words[axis] = Some(value);
            center[axis] = if absolute { value } else { start[axis] + value };
        }
        let has_center = words.iter().any(Option::is_some);
        let (end, programmed) = self.targets(p, span)?;
        let flat = |q: [f64; 3]| [q[u], q[v]];
        let to = [end.get(u).unwrap_or(start[u]), end.get(v).unwrap_or(start[v])];
        let tolerance = self.settings.arc_limit();
        let result = match radius {
            // A Fanuc takes R and leaves I, J and K out of account.
            Some(radius) if has_center && self.own.flavor == Flavor::Fanuc => {
                self.note("I, J and K have no effect together with R: the control uses R");
                center = start;
                arc::from_radius(flat(start), to, radius, clockwise, tolerance)
            }
            Some(_) if has_center => {
                return Err(Fault::new(codes::CONFLICT, span, "R together with a center").help("keep one"));
            }
            Some(radius) => {
                let tolerance = if self.is_rs274() { ArcTolerance::absolute(SHORT_RADIUS_MM) } else { tolerance };
                arc::from_radius(flat(start), to, radius, clockwise, tolerance)
            }
            None if has_center && self.settings.control.centers == Centers::Unsigned && !absolute => {
                let from = flat(start);
                let to_center = [center[u] - start[u], center[v] - start[v]];
                arc::in_quadrant(from, to, to_center, clockwise, tolerance)
                    .map_err(|count| {
                        let message = format!(
                            "{count} centers fit I and J without signs, as the control \"{}\" reads them",
                            self.settings.control.name
                        );
                        Fault::new(codes::ARC_GEOMETRY, span, message)
                            .help("check I and J; the arc must stay within a quadrant")
                    })
                    .map(Ok)?
            }
            None if has_center => {
                let found = arc::from_center(flat(start), to, flat(center), clockwise, tolerance);
                self.as_a_spiral(found, flat(start), to, flat(center), clockwise)
            }
            None if self.own.flavor == Flavor::Fanuc && !self.own.assumed && programmed != 0 => {
                return self.arc_without_center(end, programmed, p, span);
            }
            None => {
                return Err(Fault::new(codes::ARC_GEOMETRY, span, "the arc has no center and no radius")
                    .help("write I J K or R, or G1 where a straight motion is meant"));
            }
        };
        let result = result.map_err(|fault| match fault {
            ArcFault::Radii(..) if !absolute => {
                let fitting = other_reading(flat(start), to, [words[u], words[v]], tolerance.absolute_mm);
                // Radii that differ by little are rounding, and no other reading of I and J.
                let fitting = fitting.filter(|_| !differ_by_little(&fault));
                (fault, fitting.map(|reading| reading.text([CENTER[u], CENTER[v]], self.own.flavor)))
            }
            _ => (fault, None),
        });
        let result = result.map_err(|(fault, reading)| {
            let fault = arc_fault(fault, tolerance, "program a full circle with I J K", span);
            if let Some(reading) = reading { fault.help(reading) } else { fault }
        });
        let mut arc = result?;
        if let Some(turns) = turns {
            if turns.fract() != 0.0 || !(1.0..=9999.0).contains(&turns) {
                return Err(Fault::new(
                    codes::BAD_VALUE,
                    span,
                    format!("P of an arc is the number of turns and is {turns}"),
                )
                .help("write a whole number above zero"));
            }
            arc.sweep += TAU * (turns - 1.0);
        }
        center[u] = arc.center[0];
        center[v] = arc.center[1];
        center[w] = start[w];
        self.surface_speed(end.get(0));
        self.need_feed(0b111, span)?;
        let exact_stop = p.g(super::words::Group::ExactStop).is_some();
        let motion = self.complete(end, programmed, exact_stop, span)?;
        let mut normal = [0.0; 3];
        normal[w] = if clockwise { -1.0 } else { 1.0 };
        self.go_arc(motion, center, normal, &arc, span)
    }

    /// A `LinuxCNC` takes radii that differ more, and runs a spiral about the programmed center
    /// (`arc_data_ijk` of its interpreter). Its center is not moved onto the bisector where that is more than
    /// rounding.
    fn as_a_spiral(
        &self,
        found: Result<PlaneArc, ArcFault>,
        start: [f64; 2],
        end: [f64; 2],
        center: [f64; 2],
        clockwise: bool,
    ) -> Result<PlaneArc, ArcFault> {
        if !self.own.flavor.is_linuxcnc() {
            return found;
        }
        let kept = |radius| Ok(PlaneArc { center, radius, sweep: arc::sweep(start, end, center, clockwise) });
        match found {
            Ok(arc) => {
                let moved = (arc.center[0] - center[0]).hypot(arc.center[1] - center[1]);
                if moved > self.settings.arc_limit().absolute_mm {
                    kept((start[0] - center[0]).hypot(start[1] - center[1]))
                } else {
                    found
                }
            }
            Err(ArcFault::Radii(first, last)) if self.settings.arc_tolerance.is_none() => {
                let apart = (first - last).abs();
                let limit = if self.modal.inch == Some(true) { 25.4 * SPIRAL_INCH } else { SPIRAL_MM };
                let relative = apart <= SPIRAL_RELATIVE * first.max(last) && apart <= 100.0 * limit;
                if relative || apart <= limit { kept(first) } else { found }
            }
            Err(_) => found,
        }
    }

    /// G2 and G3 without I J K and R on a Fanuc: a straight motion, or an alarm (*Operator's manual*,
    /// "Circular interpolation": bit 5 of parameter 3403).
    fn arc_without_center(
        &mut self,
        end: AxisValues,
        programmed: u16,
        p: &mut Pending,
        span: Span,
    ) -> Result<(), Fault> {
        self.assume(
            "G2 and G3 without I J K and R run straight; where bit 5 of parameter 3403 is set they are an alarm",
        );
        self.surface_speed(end.get(0));
        self.need_feed(programmed, span)?;
        let motion = self.complete(end, programmed, p.g(super::words::Group::ExactStop).is_some(), span)?;
        self.go(motion, false);
        Ok(())
    }
}

/// What the words of a center that does not fit would mean on another control.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CenterReading {
    Absolute,
    /// With these signs.
    Unsigned([f64; 2]),
}

impl CenterReading {
    fn text(self, letters: [u8; 2], flavor: Flavor) -> String {
        let [a, b] = letters.map(char::from);
        match self {
            Self::Absolute if flavor.is_linuxcnc() => {
                format!("{a} and {b} fit exactly as absolute centers: write G90.1, or increments from the start")
            }
            Self::Absolute => format!(
                "{a} and {b} fit exactly as absolute centers: read them so with a file for --control, inherits = \"fanuc-0i\" and \
                 arcs.centers = \"absolute\", or post the program with increments from the start"
            ),
            Self::Unsigned(_) => format!(
                "{a} and {b} fit with other signs: read them so with a file for --control, inherits = \"fanuc-0i\" and arcs.centers = \
                 \"unsigned\", or post the program with signed increments from the start"
            ),
        }
    }
}

/// The reading under which start and end have the same distance from the center, where only one has.
fn other_reading(start: [f64; 2], end: [f64; 2], words: [Option<f64>; 2], tolerance: f64) -> Option<CenterReading> {
    let fits = |center: [f64; 2]| {
        let radius = |q: [f64; 2]| (q[0] - center[0]).hypot(q[1] - center[1]);
        (radius(start) - radius(end)).abs() <= tolerance && radius(start) > tolerance
    };
    let [a, b] = words;
    if let (Some(a), Some(b)) = (a, b)
        && fits([a, b])
    {
        return Some(CenterReading::Absolute);
    }
    let (a, b) = (a.unwrap_or(0.0).abs(), b.unwrap_or(0.0).abs());
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let mut fitting = signs.into_iter().filter(|s| fits([start[0] + s[0] * a, start[1] + s[1] * b]));
    fitting.next().map(CenterReading::Unsigned)
}
