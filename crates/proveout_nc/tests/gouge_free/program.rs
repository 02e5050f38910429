//! Contours as programs of all languages, and what the reader makes of them.

use std::f64::consts::TAU;
use std::fmt::Write;

use proveout_nc::{Compensation, Diagnostic, Dialect, Op, Overcut, Program, Settings, ToolName, ToolRadii};

use crate::gouge_free::shape::{Point, Shape, far};

/// One block of a contour.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Block {
    Line(Point),
    /// End, center, counter-clockwise.
    Arc(Point, Point, bool),
}

impl Block {
    pub(crate) fn end(&self) -> Point {
        match self {
            Self::Line(end) | Self::Arc(end, ..) => *end,
        }
    }
}

/// A contour with its tool, entry and exit.
#[derive(Clone, Debug)]
pub(crate) struct Contour {
    pub(crate) from: Point,
    pub(crate) start: Point,
    pub(crate) blocks: Vec<Block>,
    pub(crate) to: Point,
    pub(crate) left: bool,
    pub(crate) radius: f64,
    /// Digits after the decimal point.
    pub(crate) digits: usize,
}

/// How a contour is written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    pub(crate) dialect: Dialect,
    /// Normal of the working plane: 2 for G17, 1 for G18, 0 for G19.
    pub(crate) normal: usize,
    /// Siemens: G451.
    pub(crate) intersection: bool,
    /// Siemens: mirrored in the first axis of the plane.
    pub(crate) mirrored: bool,
    /// Siemens: CDON; Heidenhain: M120 LA 3.
    pub(crate) ahead: bool,
    /// Motions along the tool axis and dwells between the blocks.
    pub(crate) between: bool,
}

pub(crate) const DIALECTS: [Dialect; 8] = [
    Dialect::Siemens840d,
    Dialect::Fanuc,
    Dialect::Haas,
    Dialect::Iso,
    Dialect::LinuxCnc,
    Dialect::Heidenhain,
    Dialect::HeidenhainIso,
    Dialect::Apt,
];

impl Form {
    pub(crate) fn plain(dialect: Dialect) -> Self {
        Self { dialect, normal: 2, intersection: false, mirrored: false, ahead: false, between: false }
    }

    /// Blocks that the control looks ahead, as the README says.
    pub(crate) fn look_ahead(&self) -> usize {
        match self.dialect {
            Dialect::Siemens840d | Dialect::Heidenhain if self.ahead => 3,
            Dialect::Fanuc | Dialect::Haas | Dialect::Iso => 2,
            _ => 1,
        }
    }

    pub(crate) fn text(&self, c: &Contour) -> String {
        match self.dialect {
            Dialect::Heidenhain => self.klartext(c),
            Dialect::HeidenhainIso => self.din(c),
            Dialect::Apt => self.apt(c),
            _ => self.iso(c),
        }
    }

    fn iso(&self, c: &Contour) -> String {
        let letters = ["X", "Y", "Z"];
        let (u, v, w) = (letters[(self.normal + 1) % 3], letters[(self.normal + 2) % 3], letters[self.normal]);
        let centers = ["I", "J", "K"];
        let (i, j) = (centers[(self.normal + 1) % 3], centers[(self.normal + 2) % 3]);
        let d = c.digits;
        let siemens = self.dialect == Dialect::Siemens840d;
        let plane = 19 - self.normal;
        let side = if c.left { 41 } else { 42 };
        let (mut text, to) = (String::new(), |p: Point| format!("{u}{:.d$} {v}{:.d$}", p[0], p[1]));
        if siemens {
            let words = [if self.intersection { "G451" } else { "G450" }, if self.ahead { "CDON" } else { "CDOF" }];
            writeln!(text, "G{plane} G90 G710 G40 G94 F1000 {} {}\nT1 M6 D1", words[0], words[1]).unwrap();
            if self.mirrored {
                writeln!(text, "MIRROR {u}0").unwrap();
            }
        } else {
            writeln!(text, "G{plane} G21 G90 G40 G94 F1000").unwrap();
        }
        writeln!(text, "G0 {} {w}5.", to(c.from)).unwrap();
        let word = match self.dialect {
            Dialect::Siemens840d => format!("G{side}"),
            Dialect::LinuxCnc => format!("G{side}.1 D{:.9}", 2.0 * c.radius),
            _ => format!("G{side} D1"),
        };
        writeln!(text, "{word} G1 {}", to(c.start)).unwrap();
        let mut at = c.start;
        for (index, block) in c.blocks.iter().enumerate() {
            match block {
                Block::Line(end) => writeln!(text, "G1 {}", to(*end)).unwrap(),
                Block::Arc(end, center, ccw) => {
                    let way = [center[0] - at[0], center[1] - at[1]];
                    let g = if *ccw { 3 } else { 2 };
                    writeln!(text, "G{g} {} {i}{:.d$} {j}{:.d$}", to(*end), way[0], way[1]).unwrap();
                }
            }
            if self.between && index % 3 == 1 {
                // The height stays the same in the end: blocks of one wall are not to differ by their height.
                writeln!(text, "G1 {w}6.\nG4 {}\nG1 {w}5.", if siemens { "F0.5" } else { "P500" }).unwrap();
            }
            at = block.end();
        }
        writeln!(text, "G40 G1 {}\nM30", to(c.to)).unwrap();
        text
    }

    fn klartext(&self, c: &Contour) -> String {
        let d = c.digits;
        let to = |p: Point| format!("X{:+.d$} Y{:+.d$}", p[0], p[1]);
        let mut text = String::from("BEGIN PGM A MM\nTOOL CALL 1 Z S1000\n");
        writeln!(text, "L {} Z+5 R0 FMAX", to(c.from)).unwrap();
        let ahead = if self.ahead { " M120 LA3" } else { "" };
        writeln!(text, "L {} {} F1000{ahead}", to(c.start), if c.left { "RL" } else { "RR" }).unwrap();
        for (index, block) in c.blocks.iter().enumerate() {
            match block {
                Block::Line(end) => writeln!(text, "L {}", to(*end)).unwrap(),
                Block::Arc(end, center, ccw) => {
                    writeln!(text, "CC {}\nC {} DR{}", to(*center), to(*end), if *ccw { "+" } else { "-" }).unwrap();
                }
            }
            if self.between && index % 3 == 1 {
                text.push_str("L Z+6\nL Z+5\n");
            }
        }
        writeln!(text, "L {} R0\nEND PGM A MM", to(c.to)).unwrap();
        text
    }

    fn din(&self, c: &Contour) -> String {
        let d = c.digits;
        let to = |p: Point| format!("X{:+.d$} Y{:+.d$}", p[0], p[1]);
        let mut text = String::from("%A G71 *\nN10 T1 G17 S1000 *\n");
        writeln!(text, "N20 G00 G40 G90 {} Z+5 *", to(c.from)).unwrap();
        writeln!(text, "N30 G01 {} {} F1000 *", if c.left { "G41" } else { "G42" }, to(c.start)).unwrap();
        for (index, block) in c.blocks.iter().enumerate() {
            match block {
                Block::Line(end) => writeln!(text, "N40 G01 {} *", to(*end)).unwrap(),
                Block::Arc(end, center, ccw) => {
                    writeln!(text, "N50 I{:+.d$} J{:+.d$} *", center[0], center[1]).unwrap();
                    writeln!(text, "N60 {} {} *", if *ccw { "G03" } else { "G02" }, to(*end)).unwrap();
                }
            }
            if self.between && index % 3 == 1 {
                text.push_str("N70 G01 Z+6 *\nN80 G01 Z+5 *\n");
            }
        }
        writeln!(text, "N90 G01 G40 {} *\nN99999999 %A G71 *", to(c.to)).unwrap();
        text
    }

    fn apt(&self, c: &Contour) -> String {
        let d = c.digits;
        let to = |p: Point| format!("GOTO/{:.d$},{:.d$},5", p[0], p[1]);
        let mut text = String::from("PARTNO A\nUNITS/MM\nLOADTL/1\nFEDRAT/1000,MMPM\n");
        writeln!(text, "{}\nCUTCOM/{}\n{}", to(c.from), if c.left { "LEFT" } else { "RIGHT" }, to(c.start)).unwrap();
        let mut at = c.start;
        for block in &c.blocks {
            if let Block::Arc(_, m, ccw) = block {
                let sense = if *ccw { 1 } else { -1 };
                writeln!(text, "CIRCLE/{:.d$},{:.d$},5,0,0,{sense},{:.d$}", m[0], m[1], far(at, *m)).unwrap();
            }
            at = block.end();
            writeln!(text, "{}", to(at)).unwrap();
        }
        writeln!(text, "CUTCOM/OFF\n{}\nFINI", to(c.to)).unwrap();
        text
    }

    pub(crate) fn settings(&self, radius: Option<f64>) -> Settings {
        let compensation = radius.map_or(Compensation::Programmed, |radius| {
            let mut radii = ToolRadii::default();
            radii.by_tool.insert(ToolName::Number(1), radius);
            radii.by_offset.insert(1, radius);
            Compensation::ToolCenter(radii)
        });
        Settings { dialect: self.dialect, compensation, ..Settings::default() }
    }

    /// What the reader makes of a text; with a radius, the path of the tool center.
    pub(crate) fn read(&self, text: &str, radius: Option<f64>) -> Result<Read, Diagnostic> {
        let (u, v) = ((self.normal + 1) % 3, (self.normal + 2) % 3);
        let mut read = Read::default();
        let mut at: Option<Point> = None;
        for command in Program::from_text("contour", text, &self.settings(radius)).unwrap() {
            let command = command?;
            let (motion, arc) = match &command.op {
                Op::Rapid(m) | Op::Linear(m) => (m, None),
                Op::Arc(a) => (&a.motion, Some(a)),
                Op::Overcut(overcut) => {
                    read.overcuts.push((command.location.line, overcut.clone()));
                    continue;
                }
                _ => continue,
            };
            let (Some(x), Some(y)) = (motion.end_base.get(u), motion.end_base.get(v)) else { continue };
            if let Some(from) = at {
                let shape = match arc {
                    Some(a) => {
                        let center = [a.center_base[u], a.center_base[v]];
                        let start = (from[1] - center[1]).atan2(from[0] - center[0]);
                        // Seen along the normal, also in a left-handed frame of the plane.
                        let shape = Shape::Arc(center, a.radius, start, a.sweep * a.normal_base[self.normal]);
                        let off = (far(from, center) - a.radius).abs();
                        // Points within 1e-6 are one.
                        assert!(off < 1e-6 || radius.is_none(), "start {off} beside its circle, {radius:?}: {text}");
                        let off = far(shape.at(1.0), [x, y]);
                        assert!(off < 2e-6 || radius.is_none(), "end {off} beside its arc, {radius:?}: {text}");
                        // A circle may begin a little before its start, where a corner is nearly tangent.
                        assert!(a.sweep <= TAU + 0.1 && a.sweep >= 0.0, "{text}");
                        Some(shape)
                    }
                    None => (far(from, [x, y]) > 1e-12).then_some(Shape::Line(from, [x, y])),
                };
                if let Some(shape) = shape {
                    read.pieces.push((command.location.line, shape));
                }
            }
            at = Some([x, y]);
        }
        Ok(read)
    }
}

/// Motions in the plane with their lines, and what was reported about cuts into the contour.
#[derive(Clone, Debug, Default)]
pub(crate) struct Read {
    pub(crate) pieces: Vec<(u32, Shape)>,
    pub(crate) overcuts: Vec<(u32, Overcut)>,
}
