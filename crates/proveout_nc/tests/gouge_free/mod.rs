//! The compensated path never enters its contour without a word: random contours in all languages, judged by
//! distances that share no code with the crate; and known contours one by one.
//!
//! 10,000 contours with `PROVEOUT_CASES=10000`, a hundredth by default. [`random::wild`] and
//! [`random::legal`] say which corners they visit, and the counts are printed with the shares of what was
//! taken and refused (`--nocapture`).

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test fails by panic, and prints its shares")]

mod known;
mod program;
mod random;
mod shape;

use std::collections::BTreeMap;

use proveout_nc::{Dialect, OvercutKind};

use program::{Contour, DIALECTS, Form, Read};
use random::{Random, Visits};
use shape::{Shape, distance};

/// What the crate calls a cut, mm ([`proveout_nc::OvercutKind`] is reported above 1e-3), and what the search
/// may be off.
const CUT_MM: f64 = 1e-3;
const SEARCH_MM: f64 = 1e-6;

fn cases() -> u64 {
    std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(100)
}

fn form(random: &mut Random, index: u64) -> Form {
    let dialect = DIALECTS[index as usize % DIALECTS.len()];
    let mut form = Form::plain(dialect);
    form.between = random.chance(0.3) && dialect != Dialect::Apt;
    form.ahead = random.chance(0.3);
    if dialect == Dialect::Siemens840d {
        form.intersection = random.chance(0.4);
        form.mirrored = random.chance(0.3);
    }
    if matches!(dialect, Dialect::Siemens840d | Dialect::Fanuc | Dialect::Haas | Dialect::Iso | Dialect::LinuxCnc) {
        // A LinuxCNC has no compensation in G19.
        let planes = if dialect == Dialect::LinuxCnc { [2, 2, 1, 1] } else { [2, 2, 1, 0] };
        form.normal = planes[random.below(4)];
    }
    form
}

/// Depth of a cut of a piece of the path into a block of the contour, by their lines.
type Cuts = BTreeMap<(u32, u32), f64>;

/// Cuts of the path into the contour: on the way, and of entry and exit.
fn cuts(contour: &[(u32, Shape)], path: &[(u32, Shape)], radius: f64) -> (Cuts, Cuts) {
    let mut found = (Cuts::new(), Cuts::new());
    for (index, (line, piece)) in path.iter().enumerate() {
        let outer = index == 0 || index + 1 == path.len();
        let cuts = if outer { &mut found.1 } else { &mut found.0 };
        for (wall_line, wall) in contour {
            let (near, _) = distance(piece, wall, 0.02 * radius, radius);
            if radius - near > CUT_MM - SEARCH_MM {
                let depth = cuts.entry((*line, *wall_line)).or_default();
                *depth = depth.max(radius - near);
            }
        }
    }
    found
}

/// The contour as the reader gives it without radii, without entry and exit.
fn walls(form: &Form, text: &str) -> Vec<(u32, Shape)> {
    let programmed = form.read(text, None).unwrap().pieces;
    programmed[1..programmed.len() - 1].to_vec()
}

/// Compares what was read with the search; the places that were reported.
fn judge(form: &Form, c: &Contour, text: &str, read: &Read) -> Vec<OvercutKind> {
    let walls = walls(form, text);
    let path = &read.pieces;
    let (on_the_way, outer) = cuts(&walls, path, c.radius);
    let block = |line: u32| walls.iter().position(|(wall, _)| *wall == line);
    let mut worst = [0.0f64; 2];
    for (line, overcut) in &read.overcuts {
        let place = (*line, overcut.contour_line);
        // The way off may run over the way on.
        let crosses = overcut.kind == OvercutKind::Overlap && !on_the_way.contains_key(&place);
        let aside = crosses || matches!(overcut.kind, OvercutKind::Entry | OvercutKind::Exit);
        let among = if aside { &outer } else { &on_the_way };
        let depth = among.get(&place).copied().unwrap_or(0.0);
        // Another piece of the same line may cut deeper and mean something else.
        assert!(overcut.depth <= depth + 2.0 * SEARCH_MM, "told {overcut:?} of line {line}, found {depth}\n{text}");
        worst[usize::from(aside)] = worst[usize::from(aside)].max(overcut.depth);
        if overcut.kind == OvercutKind::Narrow {
            let apart = block(*line).unwrap().abs_diff(block(overcut.contour_line).unwrap());
            assert!(
                apart > form.look_ahead(),
                "lines {line} and {} within the look-ahead\n{text}",
                overcut.contour_line
            );
        }
    }
    for (cuts, worst) in [&on_the_way, &outer].into_iter().zip(worst) {
        for ((line, wall), depth) in cuts {
            assert!(
                *depth <= CUT_MM + SEARCH_MM || *depth <= worst + SEARCH_MM,
                "line {line} cuts {depth} into line {wall} without a word\n{text}\n{read:?}"
            );
        }
    }
    // The path hangs together, stays on its side, and never turns back on a line.
    for pair in path.windows(2) {
        assert!(shape::far(pair[0].1.at(1.0), pair[1].1.at(0.0)) < 2e-6, "{text}");
    }
    let side = if c.left == form.mirrored { -1.0 } else { 1.0 };
    for (line, piece) in &path[1..path.len() - 1] {
        let Some((_, wall)) = walls.iter().find(|(wall, _)| wall == line) else { continue };
        let p = piece.at(0.5);
        let (s, near) = wall.nearest(p);
        let (q, heading) = (wall.at(s), wall.heading(s));
        // An equidistant of its block; the lines of a corner, which have the number of the block after it,
        // keep other distances.
        if s > 0.0 && s < 1.0 && (near - c.radius).abs() < 1e-6 && piece.length() > 1e-6 {
            let across = heading[0] * (p[1] - q[1]) - heading[1] * (p[0] - q[0]);
            assert!(
                side * across > 0.0,
                "radius {}: {piece:?} of line {line} on the other side\n{text}\n{read:?}",
                c.radius
            );
        }
    }
    read.overcuts.iter().map(|(_, overcut)| overcut.kind).collect()
}

/// Whether the tool touches every block along one part of it, and is kept off the rest by its neighbors only,
/// which it then touches inside: all corners have a place where the equidistants meet. By tool positions
/// next to points of the blocks. False as well where that is not easy to say: near a reversal.
fn surely_fits(form: &Form, c: &Contour, walls: &[(u32, Shape)]) -> bool {
    const POINTS: usize = 200;
    let offset = if c.left == form.mirrored { -c.radius } else { c.radius };
    let beside = |p: shape::Point, h: shape::Point| [p[0] - offset * h[1], p[1] + offset * h[0]];
    let near = |wall: usize, p: shape::Point| walls[wall].1.nearest(p);
    let cut = |p: shape::Point| (0..walls.len()).filter(|&w| near(w, p).1 < c.radius - 1e-5).collect::<Vec<_>>();
    for (k, (_, wall)) in walls.iter().enumerate() {
        if matches!(wall, Shape::Arc(_, r, _, sweep) if sweep * offset > 0.0 && *r < c.radius + 1e-4) {
            return false;
        }
        let center = |i: usize| {
            let s = i as f64 / POINTS as f64;
            beside(wall.at(s), wall.heading(s))
        };
        let by: Vec<Vec<usize>> = (0..=POINTS).map(|i| cut(center(i))).collect();
        let Some(first) = by.iter().position(Vec::is_empty) else { return false };
        let Some(last) = by.iter().rposition(Vec::is_empty) else { return false };
        let meets = |i: usize, other: usize| {
            let (p, other) = (center(i), &walls[other].1);
            let (s, _) = other.nearest(p);
            let (q, h) = (other.at(s), other.heading(s));
            (0.01..0.99).contains(&s) && offset * (h[0] * (p[1] - q[1]) - h[1] * (p[0] - q[0])) > 0.0
        };
        let before = by[..first].iter().all(|by| k > 0 && *by == [k - 1]) && (first == 0 || meets(first, k - 1));
        let behind = by[last + 1..].iter().all(|by| *by == [k + 1]) && (last == POINTS || meets(last, k + 1));
        if !before || !behind || last < first + 3 || by[first..=last].iter().any(|by| !by.is_empty()) {
            return false;
        }
        let Some((_, next)) = walls.get(k + 1) else { continue };
        let (s, t) = (wall.heading(1.0), next.heading(0.0));
        let turn = (s[0] * t[1] - s[1] * t[0]).atan2(s[0] * t[0] + s[1] * t[1]);
        if turn.abs() > 3.0 {
            return false;
        }
        if turn * offset < 0.0 {
            let around = (0..=20).map(|i| {
                let (sine, cosine) = (f64::from(i) / 20.0 * turn).sin_cos();
                beside(wall.at(1.0), [cosine * s[0] - sine * s[1], sine * s[0] + cosine * s[1]])
            });
            if around.into_iter().any(|p| !cut(p).is_empty()) {
                return false;
            }
        }
    }
    true
}

#[derive(Debug, Default)]
struct Shares {
    clean: u64,
    surely_fits: u64,
    reported: BTreeMap<&'static str, u64>,
    refused: BTreeMap<String, u64>,
}

#[test]
fn wild_contours_are_gouge_free_or_refused_or_reported() {
    let mut visits = Visits::new();
    let mut shares: BTreeMap<&'static str, Shares> = BTreeMap::new();
    for index in 0..cases() {
        let random = &mut Random::new(index);
        let form = form(random, index);
        let contour = random::wild(random, form.dialect != Dialect::Apt, &mut visits);
        if contour.blocks.is_empty() {
            continue;
        }
        let text = form.text(&contour);
        let share = shares.entry(form.dialect.name()).or_default();
        // Circles at outside corners, and an entry that is no block of the contour.
        let judged =
            matches!(form.dialect, Dialect::Siemens840d | Dialect::Heidenhain | Dialect::HeidenhainIso | Dialect::Apt);
        let fits = judged && !form.intersection && surely_fits(&form, &contour, &walls(&form, &text));
        share.surely_fits += u64::from(fits);
        match form.read(&text, Some(contour.radius)) {
            Ok(read) => {
                let verdict = judge(&form, &contour, &text, &read);
                let inner = verdict.iter().filter(|k| !matches!(k, OvercutKind::Entry | OvercutKind::Exit)).count();
                share.clean += u64::from(inner == 0);
                assert!(!fits || inner == 0, "told, though the tool fits: {verdict:?}\n{text}");
                for kind in verdict {
                    *share.reported.entry(kind.name()).or_default() += 1;
                }
            }
            Err(error) => {
                assert_eq!(error.code, "nc-compensation", "{error}\n{text}");
                assert!(!fits, "refused, though the tool fits: {error}\nradius {}\n{text}", contour.radius);
                assert!(error.line > 0 && error.help.is_some(), "{error:?}\n{text}");
                let words = ["does not fit into", "does not fit between", "does not fit: along", "entry move is"];
                let why =
                    words.iter().find(|w| error.message.contains(**w)).unwrap_or_else(|| panic!("{error}\n{text}"));
                *share.refused.entry((*why).to_owned()).or_default() += 1;
            }
        }
    }
    println!("{visits:#?}\n{shares:#?}");
    let sum = |of: fn(&Shares) -> u64| shares.values().map(of).sum::<u64>();
    let (clean, refused) = (sum(|s| s.clean), sum(|s| s.refused.values().sum()));
    println!("{clean} free of cuts, {refused} refused, of {}", cases());
    // Neither refusal nor words are the easy way out, and both are met.
    assert!(clean * 20 > cases() && refused * 10 > cases(), "{clean} clean, {refused} refused");
}

#[test]
fn contours_into_which_the_tool_fits_are_taken_without_a_word() {
    let mut visits = Visits::new();
    for index in 0..cases() {
        let random = &mut Random::new(index ^ 0x5eed_0000);
        let form = form(random, index);
        let contour = random::legal(random, &mut visits);
        let text = form.text(&contour);
        let read = form.read(&text, Some(contour.radius)).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let judged = judge(&form, &contour, &text, &read);
        assert!(judged.is_empty(), "{judged:?}\n{text}");
    }
    println!("{visits:#?}\n{} of {} taken", cases(), cases());
}
