//! Cycle 230: a flat surface in lines to and fro. Cycle 231: a ruled surface between four points, line by
//! line.
//!
//! ```text
//!   230   Q226 + Q219   <-----------      Q240 lines over the width, the first and the last on its edges;
//!                       ----------->      beyond the length by the radius of the tool at both ends
//!         Q226          <-----------
//!            Q225 - R           Q225 + Q218 + R
//!
//!   231       4 - - - - - - 3             line i of n runs from 1 + t (4 - 1) to 2 + t (3 - 2),
//!            /             /              t = i / (n - 1); at its end up by the tool diameter, back above
//!           1 ----------> 2               the start of the line, down, and over to the next one
//! ```
//!
//! Courses after HEIDENHAIN, *iTNC 530 Cycle programming* (670388), "Multipass milling: cycle 230", "Ruled
//! surface: cycle 231".

use crate::Feed;
use crate::channel::milling::Mills;
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::{Fault, Span};
use crate::dialect::heidenhain::interpreter::{Heidenhain, Interpreter};

/// Most lines of one cycle.
const MAX_LINES: f64 = 10_000.0;

/// Lines by Q240: for each, its position as a share of the way across.
fn lines(v: &Values, least: f64) -> Result<Vec<f64>, Fault> {
    let count = v.value(240)?;
    if count.fract() != 0.0 || !(least..=MAX_LINES).contains(&count) {
        let message = format!("Q240 of cycle {} takes a whole number from {least} to 10 000 and has {count}", v.name());
        return Err(v.fault(codes::BAD_VALUE, message, "write the number of lines"));
    }
    Ok((0..count as u32).map(|i| f64::from(i) / (count - 1.0).max(1.0)).collect())
}

impl Interpreter {
    /// Cycle 230.
    pub(super) fn multipass(&mut self, v: &Values, radius: f64) -> Result<(), Fault> {
        let span = v.span;
        let (u0, v0, top) = (v.value(225)?, v.value(226)?, v.value(227)?);
        let (length, width, clearance) = (v.value(218)?, v.value(219)?, v.value(200)?.abs());
        if length == 0.0 || !(length + width).is_finite() {
            let message = "Q218 of cycle 230 must not be zero";
            return Err(v.fault(codes::ARGUMENTS, message, "write the length of the surface"));
        }
        let least = if width == 0.0 { 1.0 } else { 2.0 };
        let lines = lines(v, least)?;
        let (down, mill, across) = (self.cycle_feed(v, 206)?, self.cycle_feed(v, 207)?, self.cycle_feed(v, 209)?);
        let beyond = radius * length.signum();
        let ends = [u0 - beyond, u0 + length + beyond];
        self.mill_to(Some([ends[0], v0]), None, None, span)?;
        self.mill_to(None, Some(top + clearance), None, span)?;
        self.mill_to(None, Some(top), down, span)?;
        let mut side = 0;
        for (i, share) in lines.into_iter().enumerate() {
            let line = v0 + share * width;
            if i > 0 {
                self.mill_to(Some([ends[side], line]), None, across, span)?;
            }
            side = 1 - side;
            self.mill_to(Some([ends[side], line]), None, mill, span)?;
        }
        self.mill_to(None, Some(top + clearance), None, span)
    }

    /// Cycle 231.
    pub(super) fn ruled_surface(&mut self, v: &Values, radius: f64) -> Result<(), Fault> {
        let span = v.span;
        let mut points = [[0.0; 3]; 4];
        for (i, point) in points.iter_mut().enumerate() {
            for (k, value) in point.iter_mut().enumerate() {
                *value = v.value(225 + 3 * i as u32 + k as u32)?;
            }
        }
        let [one, two, three, four] = points;
        let lines = lines(v, 2.0)?;
        let mill = self.cycle_feed(v, 207)?;
        let between =
            |a: [f64; 3], b: [f64; 3], t: f64| -> [f64; 3] { std::array::from_fn(|k| a[k] + t * (b[k] - a[k])) };
        let last = lines.len() - 1;
        for (i, share) in lines.into_iter().enumerate() {
            let (from, to) = (between(one, four, share), between(two, three, share));
            self.in_space(from, mill, span)?;
            self.in_space(to, mill, span)?;
            self.mill_to(None, Some(to[2] + 2.0 * radius), None, span)?;
            if i == last {
                break;
            }
            let above = (to[2] + 2.0 * radius).max(from[2]);
            self.mill_to(None, Some(above), None, span)?;
            self.mill_to(Some([from[0], from[1]]), None, None, span)?;
            self.mill_to(None, Some(from[2]), mill, span)?;
        }
        let highest = points.iter().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
        self.mill_to(None, Some(highest + 2.0 * radius), None, span)
    }

    /// Straight in three axes: first and second axis of the plane, and its normal.
    fn in_space(&mut self, to: [f64; 3], feed: Option<Feed>, span: Span) -> Result<(), Fault> {
        let axes = self.modal.plane_axes();
        let (mut end, mut programmed) = (self.position.work, 0);
        for (axis, value) in axes.into_iter().zip(to) {
            end.put(axis, value);
            programmed |= 1 << axis;
        }
        if axes.iter().all(|&axis| end.get(axis) == self.position.work.get(axis)) {
            return Ok(());
        }
        if let Some(feed) = feed {
            self.technology.feed = Some(feed);
        }
        Heidenhain::mill_line(self, end, programmed, feed.is_none(), span)
    }
}
