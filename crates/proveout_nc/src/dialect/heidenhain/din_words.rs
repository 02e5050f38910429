//! Words of a DIN/ISO block that its statement does not use: they are refused by name.

use super::words::{Block, DinWords, Statement};
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// Words present in a block, by name, with their number.
pub(super) struct WordSet {
    names: [(&'static str, usize); 20],
    /// The G word that defines the block; it takes precedence over those of the path.
    special: Option<u32>,
    /// Number of the D word.
    function: Option<u32>,
}

const LABEL: usize = 7;
const FUNCTION: usize = 8;
const VALUES: usize = 9;
const TARGET: usize = 10;
const SETTINGS: usize = 11;
const TOOL: usize = 12;
const SPEED: usize = 13;
const DELTA: usize = 14;
const PROGRAM: usize = 15;
const POLAR: usize = 16;
const AXES: usize = 17;
const FEED: usize = 18;
const M: usize = 19;

const PATH: usize = 0;
const PLANE: usize = 1;
const SIDE: usize = 2;
const REFERENCE: usize = 3;
const UNIT: usize = 4;
const POLE: usize = 5;
const R: usize = 6;

/// The words of a block, before its statement takes them.
pub(super) fn present(raw: &DinWords, block: &Block) -> WordSet {
    let count = |codes: &[u32]| raw.g.iter().filter(|(g, _)| codes.contains(g)).count();
    let some = |there: bool| usize::from(there);
    let known: &[u32] = &[0, 1, 2, 3, 5, 6, 10, 11, 12, 13, 15, 16, 17, 18, 19, 29, 40, 41, 42, 50, 70, 71, 90, 91];
    let special = raw.g.iter().map(|(g, _)| *g).find(|g| !known.contains(g));
    WordSet {
        names: [
            ("the path function", count(&[0, 1, 2, 3, 5, 6, 10, 11, 12, 13, 15, 16])),
            ("the plane", count(&[17, 18, 19])),
            ("the compensation", count(&[40, 41, 42])),
            ("G90 or G91", count(&[90, 91])),
            ("G50, G70 or G71", count(&[50, 70, 71])),
            ("the pole", count(&[29]) + raw.din.pole.iter().flatten().count()),
            ("R", some(raw.din.radius.is_some())),
            ("L", some(raw.label.is_some())),
            ("D", some(raw.function.is_some())),
            ("P", raw.values.len()),
            ("the name after P", some(raw.target.is_some())),
            ("Q", raw.settings.len()),
            ("T", some(raw.tool.is_some())),
            ("S", some(raw.speed.is_some())),
            ("the delta value", raw.delta.iter().flatten().count()),
            ("%", some(raw.program.is_some())),
            ("H", some(raw.din.angle.is_some())),
            ("the axis", block.words.programmed.count_ones() as usize),
            ("F", some(block.words.feed.is_some())),
            ("M", block.words.functions.len()),
        ],
        special,
        function: raw.function.map(|(number, _)| number),
    }
}

/// How many words of each kind a statement takes.
fn takes(present: &WordSet, statement: &Statement) -> [usize; 20] {
    const ANY: usize = usize::MAX;
    let of = |list: &[(usize, usize)]| {
        let mut most = [0; 20];
        for &(at, number) in list {
            most[at] = number;
        }
        most
    };
    let function = present.names[FUNCTION].1 > 0;
    match statement {
        Statement::Begin { .. } | Statement::End => of(&[(PROGRAM, 1), (UNIT, ANY)]),
        Statement::CallProgram(_) => of(&[(PROGRAM, 1)]),
        // D00, D05 to D07 take one value and the others two.
        Statement::Assign(..) if function => {
            of(&[(FUNCTION, 1), (VALUES, if matches!(present.function, Some(0 | 5..=7)) { 1 } else { 2 })])
        }
        Statement::Branch(..) => {
            of(&[(FUNCTION, 1), (VALUES, if present.names[TARGET].1 > 0 { 2 } else { 3 }), (TARGET, 1)])
        }
        Statement::Error(_) => of(&[(FUNCTION, 1), (VALUES, 1)]),
        Statement::Note(_) if function => of(&[(FUNCTION, 1), (VALUES, ANY), (TARGET, 1)]),
        Statement::Assign(..) => of(&[]),
        Statement::CallLabel { .. } | Statement::Label(_) => of(&[(LABEL, 1)]),
        Statement::ToolCall(_) => of(&[(TOOL, 1), (SPEED, 1), (PLANE, 1), (FEED, 1), (DELTA, 3)]),
        Statement::Din(din) => {
            let path = [
                (PATH, 1),
                (SIDE, 1),
                (REFERENCE, 1),
                (PLANE, 1),
                // G29 is the pole by itself.
                (POLE, if din.pole_here { 1 } else { 3 }),
                (AXES, 9),
                (R, 1),
                (POLAR, 1),
                (FEED, 1),
                (M, ANY),
            ];
            let tool = [
                (TOOL, 1),
                (SPEED, 1),
                (DELTA, 3),
                (PATH, 1),
                (SIDE, 1),
                (REFERENCE, 1),
                (PLANE, 1),
                (FEED, 1),
                (M, ANY),
            ];
            let called = din.tool.as_ref().is_some_and(|call| call.tool.is_some() || call.speed.is_some());
            of(if called { &tool } else { &path })
        }
        _ => of(match present.special {
            Some(4 | 72) => &[(FEED, 1)],
            Some(24 | 25) => &[(R, 1), (FEED, 1)],
            Some(28) => &[(AXES, 3)],
            Some(30 | 31) => &[(AXES, 9), (PLANE, 1), (REFERENCE, 1)],
            Some(36) => &[(AXES, 9)],
            Some(38) => &[(M, ANY)],
            Some(39) => &[(TARGET, 1)],
            Some(51 | 99) => &[(TOOL, 1)],
            Some(53) => &[(VALUES, 1)],
            Some(54) => &[(AXES, 9), (REFERENCE, 1)],
            Some(62) => &[(TOOL, 1), (VALUES, 2)],
            Some(73) => &[(POLAR, 1), (REFERENCE, 1)],
            Some(79) => &[(M, ANY)],
            Some(80) => &[(AXES, 3)],
            Some(200..=299) => &[(SETTINGS, ANY)],
            _ => &[],
        }),
    }
}

/// Refuses the first word of a block that the statement does not take.
pub(super) fn all_used(present: &WordSet, statement: &Statement, span: Span) -> Result<(), Fault> {
    if let (Some(code), Some(number)) = (present.special, present.function) {
        let message = format!("D{number:02} cannot share a block with G{code:02}");
        return Err(Fault::new(codes::CONFLICT, span, message).help("write them in blocks of their own"));
    }
    let most = takes(present, statement);
    let left = present.names.iter().zip(most).find(|((_, number), most)| number > most);
    let Some(((name, number), most)) = left else { return Ok(()) };
    let message = if *number > 1 && most > 0 {
        format!("the block has {name} {number} times; at most {most} allowed")
    } else {
        format!("no word in this block uses {name}")
    };
    Err(Fault::new(codes::CONFLICT, span, message).help("write it in a block of its own, or remove it"))
}
