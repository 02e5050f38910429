//! Words of PLANE, FUNCTION and TRANS blocks.

use super::lexer::{Lexer, refused, unknown};
use super::words::{Coordinate, Plane, PlaneKind, Positioning, Reference, Statement, Tcpm, TiltChoice};
use crate::diagnostic::{Fault, twice};

pub(crate) fn plane(x: &mut Lexer<'_>, start: usize) -> Result<Plane, Fault> {
    x.blanks();
    let word = x.letters();
    let kind = match word.as_str() {
        "SPATIAL" => PlaneKind::Spatial,
        "PROJECTED" => PlaneKind::Projected,
        "EULER" => PlaneKind::Euler,
        "VECTOR" => PlaneKind::Vector,
        "POINTS" => PlaneKind::Points,
        "RELATIVE" | "RELATIV" => PlaneKind::Relative,
        "AXIAL" => PlaneKind::Axial,
        "RESET" => PlaneKind::Reset,
        _ => return Err(unknown(&format!("PLANE {word}"), x.span_from(start))),
    };
    let mut plane = Plane {
        kind,
        angles: Vec::new(),
        positioning: None,
        distance: None,
        retract: None,
        feed: None,
        choice: None,
        options: Vec::new(),
    };
    loop {
        x.blanks();
        if x.s.at_end() {
            return Ok(plane);
        }
        plane_word(x, &mut plane)?;
    }
}

fn plane_word(x: &mut Lexer<'_>, plane: &mut Plane) -> Result<(), Fault> {
    let start = x.pos();
    for (word, positioning) in [("MOVE", Positioning::Move), ("TURN", Positioning::Turn), ("STAY", Positioning::Stay)] {
        if x.word(word) {
            if plane.positioning.replace(positioning).is_some() {
                return Err(twice(word, x.span_from(start)));
            }
            return Ok(());
        }
    }
    for (word, choice) in [
        ("SEQ+", TiltChoice::Positive),
        ("SEQ-", TiltChoice::Negative),
        ("SYM+", TiltChoice::Upper),
        ("SYM-", TiltChoice::Lower),
    ] {
        if x.prefix(word) {
            plane.choice = Some(choice);
            return Ok(());
        }
    }
    for word in ["TABLE ROT", "COORD ROT", "AUTOMATIC"] {
        if x.prefix(word) {
            plane.options.push(word.to_owned());
            return Ok(());
        }
    }
    if x.prefix("DIST") || x.prefix("ABST") {
        if plane.distance.replace(x.need(start)?).is_some() {
            return Err(twice("DIST", x.span_from(start)));
        }
        return Ok(());
    }
    if x.prefix("MB") {
        let way = if x.word("MAX") { (None, true) } else { (Some(x.need(start)?), false) };
        if plane.retract.replace(way).is_some() {
            return Err(twice("MB", x.span_from(start)));
        }
        return Ok(());
    }
    if x.peek() == b'F' {
        x.s.bump();
        if plane.feed.replace(x.feed(start)?).is_some() {
            return Err(twice("F", x.span_from(start)));
        }
        return Ok(());
    }
    const NAMES: [&str; 30] = [
        "PROPR", "PROMIN", "PROMAX", "PROROT", "ROT", "EULPR", "EULNU", "EULNUT", "EULROT", "SPA", "SPB", "SPC", "BX",
        "BY", "BZ", "NX", "NY", "NZ", "P1X", "P1Y", "P1Z", "P2X", "P2Y", "P2Z", "P3X", "P3Y", "P3Z", "A", "B", "C",
    ];
    // Longest name first, so that EULNUT is not read as EULNU.
    if let Some(name) = NAMES.iter().filter(|name| x.at(name)).max_by_key(|name| name.len()) {
        x.set_pos(start + name.len());
        let value = x.need(start)?;
        let name = if *name == "EULNUT" { "EULNU" } else { name };
        super::takes::plane_angle(plane, name, x.span_from(start))?;
        plane.angles.push((name.to_owned(), value));
        return Ok(());
    }
    Err(x.unexpected())
}

/// `FUNCTION TCPM ...`, `FUNCTION RESET TCPM`, `FUNCTION MODE MILL` and the like.
pub(crate) fn function(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    if x.word("RESET") {
        if x.word("TCPM") {
            x.finish()?;
            return Ok(Statement::ResetTcpm);
        }
        return Ok(Statement::Note(format!("FUNCTION RESET {}", x.rest())));
    }
    if x.word("TCPM") {
        return tcpm(x);
    }
    let word = {
        x.blanks();
        x.letters()
    };
    match word.as_str() {
        "MODE" => {
            if x.word("TURN") || x.word("GRIND") {
                x.rest();
                return Err(refused(
                    "FUNCTION MODE TURN",
                    x.span_from(start),
                    "milling programs are read: FUNCTION MODE MILL",
                ));
            }
            let rest = x.rest();
            let words = rest.to_ascii_uppercase();
            if words.contains("KINEMATICS") || words.split_whitespace().next() == Some("SET") {
                return Err(refused(
                    &format!("FUNCTION MODE {rest}"),
                    x.span_from(start),
                    "it switches to another kinematics of the control, and the twin has that of the machine file: \
                     write FUNCTION MODE MILL",
                ));
            }
            Ok(Statement::Note(format!("FUNCTION MODE {rest}")))
        }
        "FEED" => {
            let rest = x.rest();
            if rest.to_ascii_uppercase().contains("RESET") {
                return Ok(Statement::Note("FUNCTION FEED RESET".to_owned()));
            }
            Err(refused("FUNCTION FEED", x.span_from(start), "a feed that pulses is not simulated: remove the block"))
        }
        "PARAXCOMP" | "PARAXMODE" => {
            x.rest();
            Err(refused(&format!("FUNCTION {word}"), x.span_from(start), "program the principal axes"))
        }
        "DWELL" => {
            x.rest();
            Err(refused("FUNCTION DWELL", x.span_from(start), "write the dwell with CYCL DEF 9"))
        }
        "S" | "COUNT" | "FILE" | "DCM" | "LIFTOFF" | "TURNDATA" | "CORRDATA" | "MAXFEED" | "PROG" => {
            let rest = x.rest();
            Ok(Statement::Note(format!("FUNCTION {word} {rest}").trim_end().to_owned()))
        }
        _ => Err(unknown(&format!("FUNCTION {word}"), x.span_from(start))),
    }
}

fn tcpm(x: &mut Lexer<'_>) -> Result<Statement, Fault> {
    let mut tcpm = Tcpm::default();
    loop {
        x.blanks();
        if x.s.at_end() {
            return Ok(Statement::Tcpm(tcpm));
        }
        let start = x.pos();
        if x.word("AXIS") {
            if x.word("SPAT") {
                tcpm.spatial = true;
            } else if !x.word("POS") {
                return Err(x.unexpected());
            }
        } else if x.word("PATHCTRL") {
            if x.word("VECTOR") {
                tcpm.vector = true;
            } else if !x.word("AXIS") {
                return Err(x.unexpected());
            }
        } else if x.word("REFPNT") {
            if x.word("TIP-TIP") {
                tcpm.options.push("REFPNT TIP-TIP".to_owned());
            } else {
                x.rest();
                return Err(refused("REFPNT", x.span_from(start), "the tool tip is read as reference: REFPNT TIP-TIP"));
            }
        } else if x.peek() == b'F' {
            x.s.bump();
            if x.word("TCP") {
                tcpm.options.push("F TCP".to_owned());
            } else if x.word("CONT") {
                tcpm.options.push("F CONT".to_owned());
            } else {
                x.feed(start)?;
                tcpm.options.push(x.s.slice(start).to_owned());
            }
        } else {
            return Err(x.unexpected());
        }
    }
}

pub(crate) fn trans(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    x.blanks();
    let word = x.letters();
    match word.as_str() {
        "DATUM" => {
            if x.word("RESET") {
                x.finish()?;
                return Ok(Statement::Datum(false));
            }
            if x.word("TABLE") {
                x.rest();
                return Err(refused("TRANS DATUM TABLE", x.span_from(start), "write the values with TRANS DATUM AXIS"));
            }
            x.word("AXIS");
            Ok(Statement::Datum(true))
        }
        "MIRROR" => {
            if x.word("RESET") {
                x.finish()?;
                return Ok(Statement::TransMirror(false));
            }
            x.word("AXIS");
            Ok(Statement::TransMirror(true))
        }
        "ROTATION" => {
            if x.word("RESET") {
                x.finish()?;
                return Ok(Statement::TransRotation(None));
            }
            let at = x.pos();
            let reference = if x.prefix("IROT") {
                Reference::Incremental
            } else if x.prefix("ROT") {
                Reference::Absolute
            } else {
                return Err(x.unexpected());
            };
            let value = x.need(at)?;
            x.finish()?;
            Ok(Statement::TransRotation(Some(Coordinate { value, reference })))
        }
        "SCALE" => {
            if x.word("RESET") {
                x.finish()?;
                return Ok(Statement::TransScale(None));
            }
            let at = x.pos();
            if !x.prefix("SCL") {
                return Err(x.unexpected());
            }
            let value = x.need(at)?;
            x.finish()?;
            Ok(Statement::TransScale(Some(value)))
        }
        _ => Err(unknown(&format!("TRANS {word}"), x.span_from(start))),
    }
}
