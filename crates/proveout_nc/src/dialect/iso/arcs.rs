//! G2 and G3: centers (I J K), radius (R), helices, several turns (P of `LinuxCNC`).

use std::f64::consts::TAU;

use super::interpreter::Interpreter;
use super::pending::Pending;
use crate::arc;
use crate::channel::arc_fault;
use crate::codes;
use crate::control::Centers;
use crate::diagnostic::{Fault, Span};

const CENTER: [u8; 3] = *b"IJK";

impl Interpreter {
    pub(crate) fn arc(&mut self, p: &mut Pending, clockwise: bool, span: Span) -> Result<(), Fault> {
        let start = self.start_point("the arc", span)?;
        let [u, v, w] = self.modal.plane_axes();
        let turns = if self.own.flavor.is_linuxcnc() { p.take(b'P') } else { None };
        let radius = self.length_of(p, b'R');
        let mut center = start;
        let mut has_center = false;
        let absolute = self.modal.absolute_centers;
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
            has_center = true;
            center[axis] = if absolute { value } else { start[axis] + value };
        }
        let (end, programmed) = self.targets(p, span)?;
        let end_point = end.xyz().unwrap_or(start);
        let flat = |q: [f64; 3]| [q[u], q[v]];
        let tolerance = self.settings.arc_tolerance;
        let result = match radius {
            Some(_) if has_center => {
                return Err(Fault::new(codes::CONFLICT, span, "R stands with a center").help("keep one"));
            }
            Some(radius) => arc::from_radius(flat(start), flat(end_point), radius, clockwise, tolerance),
            None if has_center && self.settings.control.centers == Centers::Unsigned && !absolute => {
                let from = flat(start);
                let to_center = [center[u] - start[u], center[v] - start[v]];
                arc::in_quadrant(from, flat(end_point), to_center, clockwise, tolerance)
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
            None if has_center => arc::from_center(flat(start), flat(end_point), flat(center), clockwise, tolerance),
            None => {
                return Err(Fault::new(codes::ARC_GEOMETRY, span, "the arc has no center and no radius")
                    .help("write I J K or R"));
            }
        };
        let mut arc = result.map_err(|fault| arc_fault(fault, tolerance, "program a full circle with I J K", span))?;
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
        self.surface_speed(end.get(0), span)?;
        self.need_feed(0b111, span)?;
        let exact_stop = p.g(super::words::Group::ExactStop).is_some();
        let motion = self.complete(end, programmed, exact_stop, span)?;
        let mut normal = [0.0; 3];
        normal[w] = if clockwise { -1.0 } else { 1.0 };
        self.go_arc(motion, center, normal, &arc, span)
    }
}
