//! Where the zeros are: work offsets as seen from the first one, and the place of that on the table.

use proveout_geom::{Point, Vector};
use proveout_machine::Machine;
use proveout_nc::{Dialect, Location};

use super::{
    FirstPartError, Reasoned,
    interview::{self, Interview, PROPOSED},
    place, refused,
};
use crate::prepare::{program_extent::Reading, program_trace::SAME_MM};

/// Work offsets that the programs use, with the place of their zero in the workpiece frame.
pub(super) fn offsets(
    readings: &[Reading],
    dialects: &[Dialect],
    interview: &mut Interview<'_, '_>,
) -> Result<Vec<(String, [f64; 3], String)>, FirstPartError> {
    let mut words: Vec<(&str, Option<&Location>)> = Vec::new();
    for (reading, dialect) in readings.iter().zip(dialects) {
        // In force before the first word.
        let from_start = match dialect.family() {
            Dialect::Iso => Some("G54"),
            Dialect::Heidenhain => Some("PRESET0"),
            _ => None,
        };
        let zero_only = |w: &str| matches!(w, "G500" | "G53");
        let named = reading.offsets.iter().map(|(w, at)| (w.as_str(), Some(at))).filter(|(w, _)| !zero_only(w));
        let before = words.len();
        for (word, at) in named {
            if !words.iter().any(|(known, _)| *known == word) {
                words.push((word, at));
            }
        }
        let names_any = reading.offsets.iter().any(|(w, _)| !zero_only(w));
        // A TNC counts from the preset that is active when the program begins, as long as it calls none.
        if dialect.family() == Dialect::Heidenhain
            && names_any
            && let Some(at) = &reading.before_offsets
            && !words.iter().any(|(known, _)| *known == "PRESET0")
        {
            words.push(("PRESET0", Some(at)));
        }
        if let Some(word) = from_start
            && !names_any
            && !words[..before].iter().any(|(known, _)| *known == word)
        {
            words.push((word, None));
        }
    }
    // What is called, or in force from the start, and never moved in: a retract in machine coordinates is
    // read in it and counts from home.
    let moved_in = |word: &str| readings.iter().any(|r| r.moved_in.contains(word));
    let idle: Vec<&str> = words.iter().map(|(word, _)| *word).filter(|w| *w != "PRESET0" && !moved_in(w)).collect();
    if idle.len() < words.len() {
        words.retain(|(word, _)| !idle.contains(word));
    }
    let Some(&(first, at)) = words.first() else { return Ok(Vec::new()) };
    let reason = match at {
        Some(at) => {
            format!("the first work offset of the program, line {}: its zero is that of the workpiece", at.line)
        }
        None => "in force from the start: its zero is that of the workpiece".to_owned(),
    };
    let mut all = vec![(first.to_owned(), [0.0; 3], reason)];
    let placed = |key: &str, word: &str, answer: &str| {
        let answer = if answer == PROPOSED { "0,0,0" } else { answer };
        match interview::numbers::<3>(answer) {
            Some(shift) => Ok((word.to_owned(), shift, format!("{answer} from {first}, as the answer says"))),
            None => {
                Err(refused(format!("`{key}` = {answer:?} is not a place of {word}"), "write three numbers: 0,120,0"))
            }
        }
    };
    let mut open = Vec::new();
    for (word, at) in &words[1..] {
        let key = format!("offset.{word}");
        match interview.given(&key) {
            Some(answer) => all.push(placed(&key, word, &answer)?),
            None => open.push((*word, at.map_or_else(String::new, |at| format!(" (line {})", at.line)))),
        }
    }
    if let [(word, line)] = &open[..] {
        let key = format!("offset.{word}");
        let text = format!("Where is the zero of {}{line} as seen from that of {first}? X,Y,Z in mm", named(word));
        if let Some(answer) = interview.get(&key, text, Some("0,0,0".into())) {
            all.push(placed(&key, word, &answer)?);
        }
    } else if !open.is_empty() {
        let key = "offsets";
        let names: Vec<String> = open.iter().map(|(word, line)| format!("{}{line}", named(word))).collect();
        let text = format!(
            "Where are the zeros of {} as seen from that of {first}? Each with its name, X,Y,Z in mm, and semicolons between",
            names.join(", ")
        );
        let wanted: Vec<_> = open.iter().map(|(word, _)| ((*word).to_owned(), Some("0,0,0".to_owned()))).collect();
        let each = interview.get_each(key, text, &wanted).map_err(|e| {
            refused(format!("`{key}`: {e}"), "write each zero with its name: G55: 0,120,0; G56: 0,240,0")
        })?;
        for (word, answer) in each.iter().flatten() {
            all.push(placed(key, word, answer)?);
        }
    }
    for word in idle {
        if all.iter().any(|(known, ..)| known == word) {
            continue;
        }
        let key = format!("offset.{word}");
        all.push(match interview.given(&key) {
            Some(answer) => placed(&key, word, &answer)?,
            None => (word.to_owned(), [0.0; 3], format!("no motion uses it: the place of {first}")),
        });
    }
    Ok(all)
}

/// The mounting of a program that sets its zero itself (G10 L2, G92): where it says, and nothing is
/// left to choose. None where it sets none, where the call states a mounting, or where the place of
/// that zero depends on a work offset. `again` reads the program with a work offset.
pub(super) fn own_mount(
    machine: &Machine,
    first: &[Reading],
    interview: &mut Interview<'_, '_>,
    again: &dyn Fn(&str, [f64; 3]) -> Option<Reading>,
) -> Option<Reasoned<Vector>> {
    let [only] = first else { return None };
    let own = only.own_zero.as_ref().filter(|_| interview.ahead("mount").is_none())?;
    let word = if own.word == "G92" {
        only.offsets.first().map_or("G54", |(word, _)| word.as_str())
    } else {
        own.word.as_str()
    };
    let stays = again(word, own.base)?.own_zero?;
    if (0..3).any(|i| (stays.base[i] - own.base[i]).abs() > SAME_MM) {
        return None;
    }
    let how =
        if own.word == "G92" { "G92".to_owned() } else { format!("a value of {} that it writes (G10)", own.word) };
    Some(Reasoned {
        value: machine.program_zero()? - Point::origin() + Vector::from(own.base),
        reason: format!("as the program says, line {}: it puts its zero there itself, by {how}", own.at.line),
        chosen: false,
    })
}

/// A work offset as a question names it.
fn named(word: &str) -> String {
    match word {
        "PRESET0" => "PRESET0, the preset that is active before the program calls one,".into(),
        _ => word.into(),
    }
}

/// The mounting that the call states; asked for where the program turns the table under the part without
/// following it.
pub(super) fn stated_mount(
    machine: &Machine,
    indexed: Option<&Location>,
    turned: &[char],
    interview: &mut Interview<'_, '_>,
) -> Result<Option<Reasoned<Vector>>, FirstPartError> {
    let key = "mount";
    let table = machine.table.point;
    // A bar that lies along an axis that the program turns, turns about its own.
    let bar = interview.ahead("stock").and_then(|stock| {
        let (bar, along) = interview::along(stock);
        let [x, y, z, ..] = interview::numbers::<5>(bar)?;
        place::about_its_axis(machine, turned, [x, y, z], along)
    });
    let pivot = bar.or_else(|| place::pivot(machine, turned));
    let at = pivot.unwrap_or_else(|| table + Vector::z() * place::ABOVE_TABLE_MM);
    let on_table = [at.x, at.y, at.z].map(proveout_tool::plain_number).join(",");
    let where_it_is = match pivot {
        Some(_) if bar.is_some() => "so that the bar of the answer `stock` turns about its own axis".to_owned(),
        Some(_) => "where the axes that it turns meet".to_owned(),
        None => format!("over the middle of the table, {} mm above it", place::ABOVE_TABLE_MM),
    };
    let answer = match indexed {
        None => interview.given(key),
        Some(at) => {
            let text = format!(
                "Where on the table is the zero of the program? The program turns the table (line {}), so the place \
                 of its zero decides where the cuts are. X,Y,Z in mm from the zero of the table frame; the proposal \
                 lies {where_it_is}",
                at.line
            );
            interview.get(key, text, Some(on_table.clone()))
        }
    };
    let Some(answer) = answer else { return Ok(None) };
    let proposed = answer == PROPOSED;
    let answer = if proposed { on_table } else { answer };
    match interview::numbers::<3>(&answer) {
        Some(mount) => Ok(Some(Reasoned {
            value: Vector::from(mount),
            reason: if proposed { format!("assumed: {where_it_is}") } else { "as the answer `mount` says".into() },
            chosen: proposed,
        })),
        None => Err(refused(format!("`{key}` = {answer:?} is not a place"), "write three numbers: 0,0,150")),
    }
}
