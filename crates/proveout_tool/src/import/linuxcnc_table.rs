//! Tool table of LinuxCNC: `T1 P1 D6.000 Z50.2 ;3 flute end mill`, one line per tool.
//!
//! Z is the length offset, here taken for the length to the gauge line; D the diameter. Lengths are in the
//! unit of the machine, which is in its INI file and not here. Words for lathes (I, J, Q) and offsets in
//! other axes have no place in a library and are reported.

use std::path::Path;

use proveout_input::InputError;

use super::{ImportCall, Imported, words};
use crate::draft::ToolDraft;

pub(super) fn read(file: &Path, text: &str, call: &ImportCall) -> Result<Imported, InputError> {
    let unit = call.stated_unit(file, "a LinuxCNC tool table")?;
    let mut imported = Imported { format: "LinuxCNC tool table", ..Imported::default() };
    for (at, line) in text.lines().enumerate() {
        let (code, remark) = line.split_once(';').unwrap_or((line, ""));
        if code.trim().is_empty() {
            continue;
        }
        let refused = |message: String| {
            InputError::file(file, message, "write T, P, D and Z with numbers: T1 P1 D6 Z50.2 ;end mill")
                .with_line(at + 1)
        };
        let mut draft: Option<ToolDraft> = None;
        let (mut diameter, mut length, mut other) = (None, None, Vec::new());
        for word in code.split_whitespace() {
            let letter = word.chars().next().unwrap_or(' ').to_ascii_uppercase();
            let number = word.get(letter.len_utf8()..).and_then(|n| n.parse::<f64>().ok()).filter(|n| n.is_finite());
            let Some(value) = number else { return Err(refused(format!("{word:?} is not a word of a tool table"))) };
            match letter {
                'T' if value >= 0.0 && value.fract() == 0.0 && value <= f64::from(u32::MAX) => {
                    draft = Some(ToolDraft::new(value as u32, format!("LinuxCNC, {}:{}", file.display(), at + 1)));
                }
                'P' => {}
                'D' => diameter = Some(value * unit),
                'Z' => length = Some(value * unit),
                'X' | 'Y' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W' | 'I' | 'J' | 'Q' if value == 0.0 => {}
                'X' | 'Y' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W' | 'I' | 'J' | 'Q' => other.push(word.to_owned()),
                _ => return Err(refused(format!("{word:?} is not a word of a tool table"))),
            }
        }
        let Some(mut draft) = draft else { return Err(refused("the line has no T with a whole number".into())) };
        if !call.selects(draft.number) {
            continue;
        }
        if !other.is_empty() {
            imported.notes.push(format!(
                "T{}: {} cannot be kept in a library and is left out",
                draft.number,
                other.join(" ")
            ));
        }
        if let Some(diameter) = diameter.filter(|d| *d != 0.0) {
            if diameter < 0.0 {
                return Err(refused(format!("the diameter of T{} is negative", draft.number)));
            }
            draft.put("diameter_mm", diameter);
        }
        match length {
            Some(z) if z > 0.0 => draft.gauge = Some(z),
            Some(z) if z < 0.0 => imported.notes.push(format!(
                "T{}: the length offset {z} mm is negative, so that it does not count from the gauge line and is left out",
                draft.number
            )),
            _ => {}
        }
        described(&mut draft, remark);
        imported.tools.push(draft);
    }
    if imported.tools.is_empty() && call.wanted.is_none() {
        return Err(InputError::file(file, "the table has no tool", "name another file"));
    }
    Ok(imported)
}

/// What a remark says of the tool.
pub(super) fn described(draft: &mut ToolDraft, remark: &str) {
    let remark = remark.trim();
    remark.clone_into(&mut draft.description);
    draft.flutes = words::flutes_of(remark);
    draft.center_cutting = words::center_cutting_of(remark);
    if let Some(("tap", why)) = words::kind_of(remark) {
        draft.become_tap(remark, None, why.map_or("", words::SubstituteBody::reason));
    } else if let Some((kind, why)) =
        words::kind_of(remark).filter(|(kind, _)| matches!(*kind, "flat" | "ball" | "drill" | "face_mill"))
    {
        draft.kind = Some(kind);
        if let Some(why) = why {
            draft.stand_in(why);
        }
    }
}
