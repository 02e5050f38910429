//! Random blocks of all modal groups beside what the interpreter of `LinuxCNC` makes of them.
//!
//! `rs274/blocks.txt.gz` holds programs and the canonical calls of `rs274` (`rs274/record.py` says how, and makes them anew). The
//! test needs no `LinuxCNC`. By default it runs a hundredth; `PROVEOUT_RS274_BLOCKS=all` runs all, a number that many programs of
//! a hundred, and `PROVEOUT_RS274_FILE` names another recording.
//!
//! * A block that `rs274` refuses must be refused.
//! * A block that it takes gives the same motions, in machine coordinates, with the same feed, spindle, coolant, dwells, stops and
//!   tool changes, or is refused: how often, each reason has its limit.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

#[path = "rs274/recording.rs"]
mod recording;
#[path = "rs274/states.rs"]
mod states;

use std::collections::BTreeMap;

use recording::{Recorded, Recording};
use states::{Event, Kind, ours, theirs};

/// Units of the last digit that `rs274` prints, mm, for values in inch.
const PRINTED_MM: f64 = 0.004;

/// Refusals of blocks that `rs274` takes: the beginning of the message, and how many of 10,000 blocks may have it.
const REFUSED_BY_NAME: &[(&str, f64)] = &[];

#[derive(Default)]
struct Found {
    blocks: usize,
    events: usize,
    refused_alike: usize,
    refused_by_name: BTreeMap<String, Vec<String>>,
    wrong: Vec<(String, String)>,
}

fn text_of(program: &[&Recorded]) -> String {
    program.iter().map(|block| format!("    {}\n", block.text)).collect()
}

fn compare(program: &[Recorded], found: &mut Found) {
    let kept: Vec<&Recorded> = program.iter().filter(|block| block.refusal.is_none()).collect();
    let lines: Vec<&str> = kept.iter().map(|block| block.text.as_str()).collect();
    let (mine, fault) = ours(&lines);
    let reached = fault.as_ref().map_or(kept.len(), |(at, _)| *at);
    found.blocks += reached;
    if let Some((at, message)) = &fault {
        let reason: String = message.clone();
        let text = format!("{}", text_of(&kept[..=*at]));
        found.refused_by_name.entry(reason).or_default().push(text);
    }
    let other = theirs(&kept[..reached]);
    let mut compensated = false;
    for at in 0..reached {
        compensated |= ["41", "42"].iter().any(|word| {
            let text = kept[at].text.to_ascii_uppercase().replace(' ', "");
            text.contains(&format!("G{word}"))
        });
        if compensated {
            break;
        }
        let (a, b) = (&mine[at], &other[at]);
        found.events += b.len();
        if let Some(what) = difference(a, b) {
            let text = format!("{what}\n{}    ours {}\n   rs274 {}\n   calls {}", text_of(&kept[..=at]), shown(a), shown(b), kept[at].calls.join(";"));
            found.wrong.push((what, text));
            break;
        }
    }
    // Each refused block behind those before it.
    for (at, block) in program.iter().enumerate() {
        let Some(message) = &block.refusal else { continue };
        let before: Vec<&Recorded> = program[..at].iter().filter(|b| b.refusal.is_none()).chain([block]).collect();
        if before.len() - 1 > reached {
            continue;
        }
        found.blocks += 1;
        let lines: Vec<&str> = before.iter().map(|block| block.text.as_str()).collect();
        match ours(&lines).1 {
            Some(_) => found.refused_alike += 1,
            None => {
                let what = format!("taken, and rs274 says: {}", message.split(':').next().unwrap_or(message));
                let text = format!("{what}\n{}", text_of(&before));
                found.wrong.push((what, text));
            }
        }
    }
}

fn shown(events: &[Event]) -> String {
    events.iter().map(|e| format!("{e:?}")).collect::<Vec<_>>().join("\n         ")
}

fn difference(a: &[Event], b: &[Event]) -> Option<String> {
    if a.len() != b.len() {
        return Some(format!("{} events instead of {}", a.len().min(9), b.len().min(9)));
    }
    for (a, b) in a.iter().zip(b) {
        let kinds = match (&a.kind, &b.kind) {
            (Kind::Dwell(x), Kind::Dwell(y)) => (x - y).abs() < 1e-4,
            (Kind::Arc { center: x, turns: n }, Kind::Arc { center: y, turns: m }) => {
                // The reader moves a center onto the bisector of rounded ends, by at most its tolerance.
                let near = x.iter().zip(y).all(|(x, y)| match (x, y) {
                    (Some(x), Some(y)) => (x - y).abs() <= 0.012,
                    _ => true,
                });
                near && n == m
            }
            (x, y) => x == y,
        };
        if !kinds {
            return Some(format!("another kind: {} instead of {}", a.kind.name(), b.kind.name()));
        }
        for axis in 0..6 {
            if let (Some(x), Some(y)) = (a.end[axis], b.end[axis])
                && (x - y).abs() > PRINTED_MM
            {
                return Some(format!("another end of {}", ["X", "Y", "Z", "A", "B", "C"][axis]));
            }
        }
        if let (Some(x), Some(y)) = (a.feed, b.feed)
            && (x - y).abs() > 1e-3 * y.abs().max(1.0)
        {
            return Some("another feed".to_owned());
        }
        if a.spindle != b.spindle {
            return Some("another spindle".to_owned());
        }
        if a.coolant != b.coolant {
            return Some("another coolant".to_owned());
        }
    }
    None
}

#[test]
fn blocks_are_read_as_linuxcnc_reads_them() {
    let recording = Recording::open();
    let part = std::env::var("PROVEOUT_RS274_BLOCKS").unwrap_or_default();
    let percent = if part == "all" { 100 } else { part.parse().unwrap_or(1_usize) };
    let mut found = Found::default();
    for (at, program) in recording.programs.iter().enumerate() {
        if (at * 37 + 11) % 100 < percent {
            compare(program, &mut found);
        }
    }
    let mut summary = format!(
        "{} blocks: {} motions and events agree, {} refusals agree\n",
        found.blocks, found.events, found.refused_alike
    );
    let show: usize = std::env::var("PROVEOUT_RS274_SHOW").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let mut by_kind: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (what, text) in &found.wrong {
        by_kind.entry(what).or_default().push(text);
    }
    let mut too_many = Vec::new();
    for (reason, texts) in &found.refused_by_name {
        let allowed = REFUSED_BY_NAME.iter().find(|(start, _)| reason.contains(start)).map_or(0.0, |(_, n)| *n);
        summary.push_str(&format!("refused by name, {} times: {reason}\n", texts.len()));
        let limit = (allowed * found.blocks as f64 / 10_000.0).ceil();
        if texts.len() as f64 > limit {
            too_many.push(format!("{} times, allowed {limit}: {reason}\n{}", texts.len(), texts[0]));
        }
    }
    println!("{summary}");
    let mut report = String::new();
    for (what, texts) in &by_kind {
        report.push_str(&format!("== {} times: {what}\n", texts.len()));
        for text in texts.iter().take(show) {
            report.push_str(text);
            report.push('\n');
        }
    }
    assert!(found.wrong.is_empty(), "{summary}{} differ:\n{report}", found.wrong.len());
    assert!(too_many.is_empty(), "{summary}refused too often:\n{}", too_many.join("\n"));
    assert!(found.blocks > 0, "{summary}");
}
