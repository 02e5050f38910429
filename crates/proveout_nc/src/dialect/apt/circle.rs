//! Circles: `CIRCLE` and `MOVARC` before the point where they end, and `TLON,GOFWD` along a circle to a line.
//!
//! ```text
//!                 forward (INDIRV)
//!                ^                        The normal is (start - center) x forward: the arc runs
//!          start +--.                     counter-clockwise about it. The end lies on the ray from
//!                    `.      end          the center through the second point of the line.
//!       center +---------`--+----> line
//! ```

use std::f64::consts::TAU;

use super::reader::{AptReader, PendingCircle, arity};
use super::statement::{AptStatement, Bad, Item, LineRange, Token};
use crate::arc::{self, ArcFault, PlaneArc};
use crate::codes;
use crate::control::ArcTolerance;
use crate::frame;
use crate::source::Source;

/// Most full turns of one circle.
const MAX_TURNS: f64 = 1000.0;
/// Radius that rounding of points is an angle of at least, mm.
const LEAST_RADIUS_MM: f64 = 1e-6;

impl AptReader {
    /// CIRCLE/x,y,z,i,j,k[,r[,...]], MOVARC/x,y,z,i,j,k,r[,ANGLE,a]; the next point is the end. Without a
    /// radius (`CAMWorks`) it is that of the start.
    pub(crate) fn circle_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let leading = st.items.iter().take_while(|i| matches!(i.token, Token::Number(_))).count();
        if leading < 7 && (leading < 6 || st.major != "CIRCLE") {
            return Err(arity(st.head, &st.major, leading, "the center, the normal and the radius, seven values"));
        }
        let mut n = [0.0; 7];
        for (item, slot) in st.items.iter().zip(&mut n) {
            *slot = self.number(source, item)?;
        }
        let mut angle = None;
        let mut rest = st.items[leading..].iter();
        while let Some(item) = rest.next() {
            let word = Self::word(source, item);
            match (word.as_str(), st.major.as_str()) {
                ("ANGLE", "MOVARC") => {
                    let value = rest.next().ok_or_else(|| {
                        item.place.bad(codes::MISSING_VALUE, "ANGLE has no value", "write the angle in degrees")
                    })?;
                    let degrees = self.number(source, value)?;
                    if !(degrees > 0.0 && degrees <= 360.0 * MAX_TURNS) {
                        let message = format!("the angle of an arc must be above zero and is {degrees}");
                        return Err(value.place.bad(
                            codes::BAD_VALUE,
                            message,
                            "reverse the normal for the opposite direction",
                        ));
                    }
                    angle = Some(degrees.to_radians());
                }
                _ => {
                    let message = format!("`{word}` in {} is not supported", st.major);
                    return Err(item.place.bad(
                        codes::UNSUPPORTED_WORD,
                        message,
                        "give the center, the normal and the radius, and the end with GOTO",
                    ));
                }
            }
        }
        let Some(normal) = frame::unit([n[3], n[4], n[5]]) else {
            return Err(st.head.bad(
                codes::ARC_GEOMETRY,
                "the normal of the circle has no length",
                "give the axis of the circle",
            ));
        };
        if st.major == "CIRCLE" && (8..11).contains(&leading) {
            self.note(format!("CIRCLE has {leading} values: those after the radius have no effect"));
        }
        let clockwise = st.major == "CIRCLE" && self.own.facts.clockwise;
        if st.major == "CIRCLE"
            && let Some(text) = self.own.facts.sense_assumed.take()
        {
            self.assume(text);
        }
        let normal = if clockwise { normal.map(|v| 0.0 - v) } else { normal };
        self.own.circle = Some(PendingCircle {
            center: [n[0], n[1], n[2]].map(|v| v * self.own.unit),
            normal,
            radius: (leading > 6).then_some(n[6] * self.own.unit),
            angle,
            zero_at_one_point: leading > 7,
        });
        Ok(())
    }

    /// INDIRV/i,j,k and INDIRP/x,y,z: direction in which the circle starts.
    pub(crate) fn direction_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut n = [0.0; 3];
        let count = self.numbers(source, st, &mut n)?;
        if count != 3 {
            return Err(arity(st.head, &st.major, count, "three values"));
        }
        self.own.forward =
            Some(if st.major == "INDIRV" { n } else { frame::sub(n.map(|v| v * self.own.unit), self.here(st.head)?) });
        Ok(())
    }

    /// `TLON,GOFWD/ (CIRCLE/x,y,z,r),ON,[2,INTOF,](LINE/..,x,y,z)`, or with `(CYLNDR/x,y,z,i,j,k,r)` and a
    /// plane through the end point as the limit.
    pub(crate) fn along_circle(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut groups: Vec<(String, &[Item])> = Vec::new();
        for (at, item) in st.items.iter().enumerate() {
            if item.token == Token::Slash
                && at > 0
                && let Some(name) = st.items.get(at - 1).filter(|i| i.token == Token::Word)
            {
                let numbers = &st.items[at + 1..];
                let count = numbers.iter().take_while(|i| matches!(i.token, Token::Number(_))).count();
                groups.push((Self::word(source, name), &numbers[..count]));
            }
        }
        let values = |items: &[Item]| items.iter().map(|i| self.number(source, i)).collect::<Result<Vec<f64>, _>>();
        let wrong = |message: &str| {
            st.head.bad(
                codes::ARC_GEOMETRY,
                message,
                "write (CIRCLE/center, radius),ON,(LINE/center, end), or CIRCLE/ with seven values and GOTO",
            )
        };
        let Some((kind, circle)) = groups.first() else {
            return Err(wrong("TLON,GOFWD names no circle"));
        };
        let circle = values(circle)?;
        let (center, radius) = match (kind.as_str(), circle.as_slice()) {
            ("CIRCLE", &[x, y, z, r]) | ("CIRCLE" | "CYLNDR", &[x, y, z, _, _, _, r]) => ([x, y, z], r),
            _ => return Err(wrong("the circle of TLON,GOFWD has an unsupported form")),
        };
        let limit = groups[1..].iter().rev().find(|(kind, _)| matches!(kind.as_str(), "LINE" | "POINT"));
        let Some((_, limit)) = limit else { return Err(wrong("the circle of TLON,GOFWD has no end")) };
        let limit = values(limit)?;
        let through = match limit.as_slice() {
            &[_, _, _, x, y, z] | &[x, y, z] => [x, y, z],
            _ => return Err(wrong("the end of the circle is neither a line nor a point")),
        };
        let unit = self.own.unit;
        let (center, through, radius) = (center.map(|v| v * unit), through.map(|v| v * unit), radius * unit);
        let start = self.here(st.head)?;
        let Some(forward) = self.own.forward.take() else {
            return Err(st.head.bad(
                codes::ARC_GEOMETRY,
                "the direction of the circle is not known",
                "write INDIRV with the tangent at its start before it",
            ));
        };
        let normal = frame::unit(frame::cross(frame::sub(start, center), forward));
        let outward = frame::unit(frame::sub(through, center));
        let (Some(normal), Some(outward)) = (normal, outward) else {
            return Err(wrong("the tangent points to the center, or the end is the center"));
        };
        let end = frame::add_scaled(center, outward, radius);
        self.take_path_tool();
        // Six digits of the tangent leave a slightly tilted normal; along an axis it is exact.
        let normal = snapped(normal);
        self.go_circle(
            &PendingCircle { center, normal, radius: Some(radius), angle: None, zero_at_one_point: false },
            end,
            st.head,
        )
    }

    /// The arc from here to a point; a point off the plane makes it a helix.
    pub(crate) fn go_circle(
        &mut self,
        circle: &PendingCircle,
        end: [f64; 3],
        place: LineRange,
    ) -> Result<(), Box<Bad>> {
        if std::mem::take(&mut self.own.rapid) {
            return Err(place.bad(codes::CONFLICT, "RAPID before a circle", "write FEDRAT before a circle"));
        }
        if self.own.cycle_on {
            return Err(place.bad(codes::CONFLICT, "a circle within a cycle", "write CYCLE/OFF before it"));
        }
        self.need_feed();
        let start = self.here(place)?;
        let normal = snapped(circle.normal);
        let (u, v) = basis(normal);
        let flat =
            |p: [f64; 3]| [frame::dot(frame::sub(p, circle.center), u), frame::dot(frame::sub(p, circle.center), v)];
        let (a, b) = (flat(start), flat(end));
        let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
        let drop = frame::dot(normal, frame::sub(end, start));
        if circle.zero_at_one_point
            && circle.angle.is_none()
            && apart <= self.settings.arc_limit().absolute_mm
            && drop.abs() <= self.settings.arc_limit().absolute_mm
        {
            self.straight(end, false);
            return Ok(());
        }
        let measured = a[0].hypot(a[1]);
        let tolerance = self.settings.arc_limit();
        if let Some(radius) = circle.radius.filter(|r| (measured - r.abs()).abs() > tolerance.of(measured.max(r.abs())))
        {
            let message = format!(
                "the arc has the radius {radius:.4} mm and starts {measured:.4} mm from its center; the limit of the difference is {tolerance} mm"
            );
            return Err(place.bad(codes::ARC_RADIUS, message, "correct the circle, or program the point before it"));
        }
        let mut arc =
            arc::from_center(a, b, [0.0; 2], false, tolerance).map_err(|fault| arc_fault(fault, tolerance, place))?;
        if let Some(angle) = circle.angle {
            arc.sweep = turned(arc, angle).ok_or_else(|| {
                let message = format!(
                    "the arc turns by {:.4} degrees to its end and {:.4} are programmed",
                    arc.sweep.to_degrees(),
                    angle.to_degrees()
                );
                place.bad(codes::ARC_GEOMETRY, message, "correct the angle or the end point")
            })?;
        }
        // The center lies in the plane of the start.
        let height = frame::dot(normal, frame::sub(start, circle.center));
        let mut center = frame::add_scaled(circle.center, normal, height);
        center = frame::add_scaled(frame::add_scaled(center, u, arc.center[0]), v, arc.center[1]);
        let motion = self.motion(end);
        self.go_arc(motion, center, normal, &arc, place.span).map_err(|fault| place.with(fault))
    }
}

/// The sweep of an arc with a programmed angle: whole turns more than the short way, as far as rounding
/// allows.
fn turned(arc: PlaneArc, angle: f64) -> Option<f64> {
    // The angle has at least two decimals of a degree; short arcs with rounded points may differ by
    // more than that.
    let limit = 0.01_f64.to_radians() + 0.02 / arc.radius.max(LEAST_RADIUS_MM);
    let short = arc.sweep % TAU;
    let turns = ((angle - short) / TAU).round().max(0.0);
    let sweep = short + turns * TAU;
    ((sweep - angle).abs() <= limit && sweep > 0.0).then_some(sweep)
}

/// A direction along an axis, made exact where six digits mean it.
fn snapped(direction: [f64; 3]) -> [f64; 3] {
    for axis in 0..3 {
        if direction[axis].abs() > frame::SAME_DIRECTION {
            let mut exact = [0.0; 3];
            exact[axis] = direction[axis].signum();
            return exact;
        }
    }
    direction
}

/// Two directions that are right-handed with a normal; axes themselves where the normal is one.
fn basis(normal: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    for axis in 0..3 {
        if normal[axis].abs() == 1.0 {
            let mut u = [0.0; 3];
            u[(axis + 1) % 3] = 1.0;
            return (u, frame::cross(normal, u));
        }
    }
    // The axis that is farthest from the normal.
    let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let mut helper = [0.0; 3];
    helper[least] = 1.0;
    let u = frame::unit(frame::cross(helper, normal)).unwrap_or([1.0, 0.0, 0.0]);
    (u, frame::cross(normal, u))
}

fn arc_fault(fault: ArcFault, tolerance: ArcTolerance, place: LineRange) -> Box<Bad> {
    match fault {
        ArcFault::Radii(start, end) => place.bad(
            codes::ARC_RADIUS,
            format!("the arc has radius {start:.4} mm at its start and {end:.4} mm at its end; the limit of the difference is {tolerance} mm"),
            "correct the center or the end point",
        ),
        ArcFault::NoRadius | ArcFault::TooSmall(..) | ArcFault::SamePoint => place.bad(
            codes::ARC_GEOMETRY,
            "the center of the circle lies on its start or end",
            "correct the center, or write GOTO alone",
        ),
    }
}
