//! Surfaces that are milled line by line: CYCLE71 and CYCLE61.
//!
//! The courses are those of [`super::milling`]; parameters and digits of CYCLE61 from memory.

use super::milling::share;
use super::run_state::Interpreter;
use crate::Feed;
use crate::channel::milling::{self, Heights, MAX_PASSES};
use crate::channel::shape::{Place, Point};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::Fault;

/// Least infeed, mm: their count stays finite.
const LEAST_INFEED_MM: f64 = 1e-9;

/// A surface that is milled line by line.
struct Surface {
    heights: Heights,
    corner: Point,
    sides: [f64; 2],
    turn: f64,
    infeed: f64,
    /// Largest distance between two lines, mm.
    greatest: f64,
    /// Overrun beyond the ends of a line, and of the last line.
    beyond: f64,
    over: f64,
    floor: f64,
    mill: Option<Feed>,
    /// Tens and units of VARI.
    variant: (u32, u32),
    radius: f64,
}

impl Interpreter {
    /// CYCLE71.
    pub(super) fn face(&mut self, v: &Values) -> Result<(), Fault> {
        v.no_more()?;
        let radius = self.need_radius(v)?;
        self.assume(
            "CYCLE71: FDP counts from the edge of the tool; in both directions the tool goes on outside the surface \
             at the feed FFP1; in one direction it comes back SDIS above the depth; every depth begins at the first \
             line",
        );
        let surface = Surface {
            heights: v.heights()?,
            corner: [v.value("PA")?, v.value("PO")?],
            sides: [v.value("LENG")?, v.value("WID")?],
            turn: v.value("STA")?,
            infeed: v.value("MID")?,
            greatest: v.above_zero("MIDA")?,
            beyond: v.value("FDP")?,
            over: v.value("FDP1")?,
            floor: v.value("FALD")?,
            mill: self.milling_feed(v, "FFP1")?,
            variant: v.variant()?,
            radius,
        };
        self.mill_surface(v, &surface)
    }

    /// CYCLE61: face milling of the editor of the control.
    pub(super) fn surface(&mut self, v: &Values) -> Result<(), Fault> {
        v.no_more()?;
        v.refuse_set("LIM", "limits of the surface")?;
        v.check_plane(self.modal.normal)?;
        let radius = self.need_radius(v)?;
        let corner = [v.value("X0")?, v.value("Y0")?];
        let mut sides = [v.value("X1")?, v.value("Y1")?];
        for (axis, unit) in [1000.0, 10_000.0].into_iter().enumerate() {
            // 1 is the other corner, 0 the length.
            if v.digit("AMODE", unit)? == 1.0 {
                sides[axis] -= corner[axis];
            }
        }
        if v.value("Z0")? != 0.0 && v.digit("AMODE", 1.0)? == 1.0 {
            let message = "`CYCLE61` with an incremental depth below a surface that is not at zero is not supported";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, "write Z1 as an absolute height (units of AMODE 0)"));
        }
        let percent = v.digit("AMODE", 10.0)? == 1.0;
        let width = v.above_zero("MIDA")?;
        self.assume(
            "CYCLE61: lengths where AMODE has 0 in its thousands and ten thousands, corners where it has 1; lines \
             reach SC beyond the surface; in both directions the tool goes on outside the surface at the feed; in one \
             direction it comes back SC above the depth",
        );
        let heights = v.heights_by_mode(["RTP", "Z0", "SC", "Z1"])?;
        let surface = Surface {
            heights,
            corner,
            sides,
            turn: 0.0,
            infeed: v.value("MID")?,
            greatest: if percent { v.raw("MIDA")?.unwrap_or(0.0).abs() / 100.0 * 2.0 * radius } else { width },
            beyond: (heights.clear - heights.surface).abs(),
            over: 0.0,
            floor: v.value("FALZ")?,
            mill: self.milling_feed(v, "FFP1")?,
            variant: v.variant()?,
            radius,
        };
        self.mill_surface(v, &surface)
    }

    fn mill_surface(&mut self, v: &Values, surface: &Surface) -> Result<(), Fault> {
        let span = v.span;
        let &Surface { heights: h, corner, sides, turn, infeed, greatest, beyond, over, floor, mill, radius, .. } =
            surface;
        if sides.contains(&0.0) {
            return Err(v.fault(
                codes::ARGUMENTS,
                format!("the surface of `{}` has no size", v.name()),
                "write its length and width; the signs say where the surface lies",
            ));
        }
        let place = Place::new(corner, turn);
        let (tens, units) = surface.variant;
        let finishing = v.finishes(units)?;
        if !(1..=4).contains(&tens) {
            let message = format!("the tens of VARI of `{}` are {tens}", v.name());
            return Err(v.fault(
                codes::ARGUMENTS,
                message,
                "1 to 4 set the axis, and whether cutting is in one or both directions",
            ));
        }
        if greatest > 2.0 * radius {
            let message =
                format!("the infeed width MIDA of `{}` is {greatest} mm and the tool cuts {}", v.name(), 2.0 * radius);
            return Err(v.fault(codes::ARGUMENTS, message, "write a smaller MIDA, or use a larger tool"));
        }
        // Along the lines and across them.
        let (along, across) = if tens % 2 == 1 { (0, 1) } else { (1, 0) };
        let to_and_fro = tens > 2;
        let (first, last) = (greatest - radius, sides[across].abs() + over - radius);
        let steps = if last > first { ((last - first) / greatest - milling::WHOLE).ceil() } else { 0.0 };
        let total = (h.depth - h.surface).abs();
        let rough = (total - floor).max(0.0);
        let infeeds = if finishing { 1.0 } else { rough / share(rough, infeed).max(LEAST_INFEED_MM) };
        if steps * infeeds >= MAX_PASSES as f64 || steps.is_nan() {
            let message = format!("`{}` would need more than {MAX_PASSES} lines", v.name());
            return Err(v.fault(codes::LOOP_LIMIT, message, "check LENG, WID, MID and MIDA"));
        }
        let depths = if finishing { vec![total] } else { milling::levels(rough, share(rough, infeed)) };
        let lines: Vec<f64> =
            (0..=steps as u32).map(|i| first + (last - first) * f64::from(i) / steps.max(1.0)).collect();
        let ends = [-(radius + beyond), sides[along].abs() + radius + beyond];
        let at = |line: f64, end: f64| -> Point {
            let mut p = [0.0; 2];
            p[along] = end * sides[along].signum();
            p[across] = line * sides[across].signum();
            place.at(p)
        };
        let height = |depth: f64| h.surface + h.down * depth;
        for depth in depths {
            self.come_over(at(lines[0], ends[0]), h.clear, span)?;
            self.mill_to(None, Some(height(depth)), None, span)?;
            let mut side = 0;
            for (i, &line) in lines.iter().enumerate() {
                if i > 0 && !to_and_fro {
                    self.mill_to(None, Some(height(depth) - h.down * (h.clear - h.surface).abs()), None, span)?;
                    self.mill_to(Some(at(line, ends[0])), None, None, span)?;
                    self.mill_to(None, Some(height(depth)), None, span)?;
                } else {
                    self.mill_to(Some(at(line, ends[side])), None, mill, span)?;
                }
                side = if to_and_fro { 1 - side } else { 1 };
                self.mill_to(Some(at(line, ends[side])), None, mill, span)?;
            }
            self.mill_to(None, Some(h.clear), None, span)?;
        }
        self.mill_to(None, Some(h.second), None, span)
    }
}
