//! Drawings of a comparison, one file each: the gain of a program over the velocity limit of a joint, and
//! published values next to ours with their ranges. All values are in `compare.json`. The drawings carry
//! their styles, so that any page can show them.

use std::{collections::BTreeMap, fs, path::Path};

use proveout_sim::{
    certificate::VelocityLimit,
    compare::{Agreement, Comparison, GainAtLimit, Published},
};

use crate::{
    chart::{escape, put, ticks},
    error::RecordError,
    report::format::{compact, fixed},
};

/// Name of the drawing of the gain.
const GAIN_DRAWING: &str = "gain-over-limit.svg";
/// Name of the drawing of published values.
const RANGES_DRAWING: &str = "published-ranges.svg";

const WIDTH: f64 = 900.0;
const INK: &str = "#24292f";
const FAINT: &str = "#d5d9de";
const SOFT: &str = "#6b7480";
const LIMIT: &str = "#b3303a";
/// Lines of programs: hues that differ in lightness too.
const PROGRAMS: [&str; 5] = ["#1f6fb5", "#c2571a", "#2f8f4e", "#8a4fb0", "#7a6a1a"];
/// The largest ratio to a published value that is drawn at its place; what goes beyond ends in an arrow.
const MOST: f64 = 2.5;
const LEAST: f64 = -0.5;

/// Writes the drawings that there is something to draw for.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub(super) fn write_drawings(folder: &Path, comparison: &Comparison) -> Result<(), RecordError> {
    for (name, drawing) in [(GAIN_DRAWING, gain_drawing(comparison)), (RANGES_DRAWING, ranges_drawing(comparison))] {
        if let Some(text) = drawing {
            let path = folder.join(name);
            fs::write(&path, text).map_err(RecordError::io(&path))?;
        }
    }
    Ok(())
}

fn begin(height: f64, title: &str) -> String {
    let title = escape(title);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" width=\"{WIDTH}\" height=\"{height:.0}\" font-family=\"sans-serif\" \
         font-size=\"12\" fill=\"{INK}\">\n<title>{title}</title>\n<rect width=\"{WIDTH}\" height=\"{height:.0}\" fill=\"#ffffff\"/>\n"
    )
}

fn text(out: &mut String, [x, y]: [f64; 2], anchor: &str, fill: &str, words: &str) {
    put!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{fill}\">{}</text>\n", escape(words));
}

/// Text of a limit, which may lie over lines.
fn label(out: &mut String, [x, y]: [f64; 2], anchor: &str, words: &str) {
    put!(
        out,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{LIMIT}\" stroke=\"#ffffff\" stroke-width=\"4\" paint-order=\"stroke\">{}</text>\n",
        escape(words)
    );
}

fn line(out: &mut String, [x1, y1, x2, y2]: [f64; 4], stroke: &str, more: &str) {
    put!(out, "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"{stroke}\" fill=\"none\" {more}/>\n");
}

/// A program with what it saves at the limits of a joint.
type Gains<'a> = (&'a String, Vec<&'a GainAtLimit>);

/// Time that programs save over the velocity limit of a joint, by feed and this limit alone; none where no
/// limit binds anything.
pub(super) fn gain_drawing(c: &Comparison) -> Option<String> {
    // One panel for each joint and original program: only schedules of the same program can be compared.
    let mut panels: BTreeMap<(String, String), Vec<Gains<'_>>> = BTreeMap::new();
    for name in &c.order {
        let Some(made) = c.programs.get(name).and_then(|p| p.made.as_ref()) else { continue };
        let mut joints: BTreeMap<&String, Vec<&GainAtLimit>> = BTreeMap::new();
        made.over_velocity.iter().for_each(|row| joints.entry(&row.joint).or_default().push(row));
        for (joint, rows) in joints {
            panels.entry((joint.clone(), made.from.clone())).or_default().push((name, rows));
        }
    }
    panels.retain(|_, programs| {
        let most = |r: &&GainAtLimit| r.saved_percent.abs().max(r.saved_at_most_percent.abs());
        programs.iter().any(|(_, rows)| rows.iter().map(most).fold(0.0, f64::max) > 0.005)
    });
    if panels.is_empty() {
        return None;
    }
    let heights: Vec<f64> = panels.values().map(|programs| 312.0 + 18.0 * programs.len() as f64).collect();
    let mut out = begin(
        heights.iter().sum::<f64>() + 8.0,
        &format!("{}: time saved over the velocity limit of a joint", c.scene),
    );
    let mut top = 0.0;
    for (((joint, from), programs), height) in panels.iter().zip(heights) {
        panel(&mut out, (joint, from), programs, top);
        top += height;
    }
    out.push_str("</svg>\n");
    Some(out)
}

fn panel(out: &mut String, (joint, from): (&str, &str), programs: &[Gains<'_>], top: f64) {
    let (left, right) = (64.0, WIDTH - 24.0);
    let (high, base) = (top + 44.0, top + 256.0);
    let rows = || programs.iter().flat_map(|(_, rows)| rows.iter().copied());
    // The machine's own limit may lie far to the right of all that happens.
    let needed = rows().filter(|r| r.is != VelocityLimit::OfMachine).map(|r| r.velocity_deg_s).fold(0.0, f64::max);
    let x_most = 1.12 * needed;
    let saved = || rows().flat_map(|r| [r.saved_percent, r.saved_at_most_percent]);
    let (y_least, y_most) = (saved().fold(0.0, f64::min), 1.08 * saved().fold(1.0, f64::max));
    let y_least = if y_least < -0.005 { 1.15 * y_least } else { 0.0 };
    let x = |v: f64| left + (right - left) * v / x_most;
    let y = |v: f64| base - (base - high) * (v - y_least) / (y_most - y_least);
    put!(
        out,
        "<text x=\"{left}\" y=\"{:.1}\" font-size=\"14\" font-weight=\"bold\">Time saved against {} over the velocity limit of {}, percent</text>\n",
        top + 22.0,
        escape(from),
        escape(joint)
    );
    text(out, [left, top + 38.0], "start", SOFT, "of the replanned stretch, by feed and this limit alone");
    for v in ticks(y_least, y_most, 6) {
        line(out, [left, y(v), right, y(v)], FAINT, "");
        text(out, [left - 6.0, y(v) + 4.0], "end", INK, &compact(v));
    }
    for v in ticks(0.0, x_most, 9) {
        line(out, [x(v), high, x(v), base], FAINT, "");
        text(out, [x(v), base + 16.0], "middle", INK, &compact(v));
    }
    text(out, [0.5 * (left + right), base + 33.0], "middle", INK, &format!("velocity limit of {joint}, deg/s"));
    line(out, [left, base, right, base], SOFT, "");
    // Limits: where they come from is the same for all programs of the panel but for what each program before
    // needs, which is one.
    let mut told = Vec::new();
    for (is, words, dash) in [
        (VelocityLimit::InForce, "in force", ""),
        (VelocityLimit::OfOriginal, "needed by the program before", "stroke-dasharray=\"2 4\""),
        (VelocityLimit::OfMachine, "the machine's own", "stroke-dasharray=\"8 4\""),
    ] {
        let Some(row) = rows().find(|r| r.is == is) else { continue };
        let words = format!("{words}: {}", compact(row.velocity_deg_s));
        if row.velocity_deg_s <= x_most {
            told.push((row.velocity_deg_s, words, dash));
        } else {
            label(out, [right - 4.0, high + 14.0], "end", &format!("{words} \u{2192}"));
        }
    }
    told.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (k, (v, words, dash)) in told.iter().enumerate() {
        line(out, [x(*v), high, x(*v), base], LIMIT, &format!("stroke-width=\"1.5\" {dash}"));
        let anchor = if x(*v) > right - 190.0 { "end" } else { "start" };
        let shift = if anchor == "end" { -5.0 } else { 5.0 };
        label(out, [x(*v) + shift, high + 30.0 + 16.0 * k as f64], anchor, words);
    }
    // Schedules of one channel have one bound.
    let best =
        |rows: &[&GainAtLimit]| rows.iter().map(|r| [r.velocity_deg_s, r.saved_at_most_percent]).collect::<Vec<_>>();
    let near = |a: &[[f64; 2]], b: &[[f64; 2]]| {
        a.len() == b.len() && a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 0.05)
    };
    let shared = programs.len() > 1 && programs.windows(2).all(|p| near(&best(&p[0].1), &best(&p[1].1)));
    for (k, (name, rows)) in programs.iter().enumerate() {
        let color = PROGRAMS[k % PROGRAMS.len()];
        let bound = if shared { SOFT } else { color };
        let way = |of: fn(&GainAtLimit) -> f64| {
            let mut points: Vec<[f64; 2]> =
                rows.iter().filter(|r| r.velocity_deg_s <= x_most).map(|r| [r.velocity_deg_s, of(r)]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut d = String::new();
            for (i, p) in points.iter().enumerate() {
                put!(d, "{}{:.1} {:.1}", if i == 0 { 'M' } else { 'L' }, x(p[0]), y(p[1]));
            }
            // Nothing is gained where the limit is above what the program before needs.
            if let Some(last) = points.last() {
                put!(d, "L{:.1} {:.1}", right, y(last[1]));
            }
            (d, points)
        };
        let (best, _) = way(|r| r.saved_at_most_percent);
        put!(
            out,
            "<path d=\"{best}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\" opacity=\"0.75\"/>\n"
        );
        let (own, points) = way(|r| r.saved_percent);
        put!(out, "<path d=\"{own}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2.4\"/>\n");
        for p in points {
            put!(out, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{color}\"/>\n", x(p[0]), y(p[1]));
        }
        let at = base + 54.0 + 18.0 * k as f64;
        line(out, [left, at - 4.0, left + 34.0, at - 4.0], color, "stroke-width=\"2.4\"");
        text(out, [left + 42.0, at], "start", INK, name);
        if !shared || k == 0 {
            let dashed = left + 320.0;
            line(
                out,
                [dashed, at - 4.0, dashed + 34.0, at - 4.0],
                bound,
                "stroke-width=\"1.5\" stroke-dasharray=\"6 4\"",
            );
            text(out, [dashed + 42.0, at], "start", INK, "at most, by the best schedule of its channel");
        }
    }
}

/// Published values next to ours, as fractions of the published ones, with the effect of choices, draws and
/// twin on ours; `None` without a published value.
pub(super) fn ranges_drawing(c: &Comparison) -> Option<String> {
    let rows: Vec<&Published> = c.published.iter().filter(|p| p.published != 0.0 && p.value.is_some()).collect();
    if rows.is_empty() {
        return None;
    }
    let (left, right) = (270.0, WIDTH - 168.0);
    let (high, step) = (98.0, 34.0);
    let base = high + step * rows.len() as f64;
    let mut out = begin(base + 46.0, &format!("{}: published values and ours", c.scene));
    let x = |v: f64| left + (right - left) * (v.clamp(LEAST, MOST) - LEAST) / (MOST - LEAST);
    put!(
        out,
        "<text x=\"16\" y=\"22\" font-size=\"14\" font-weight=\"bold\">{}: ours as a part of the published value</text>\n",
        escape(&c.scene)
    );
    legend(&mut out, c.choices.as_ref().map_or(0, |open| open.draws));
    for v in ticks(LEAST, MOST, 7) {
        line(&mut out, [x(v), high, x(v), base], FAINT, "");
        text(&mut out, [x(v), base + 16.0], "middle", INK, &compact(v));
    }
    text(&mut out, [0.5 * (left + right), base + 34.0], "middle", INK, "value over published value");
    line(&mut out, [x(0.0), high, x(0.0), base], SOFT, "");
    line(&mut out, [x(1.0), high, x(1.0), base], LIMIT, "stroke-width=\"1.8\"");
    for (k, row) in rows.iter().enumerate() {
        let middle = high + step * (k as f64 + 0.5);
        if k % 2 == 1 {
            put!(
                out,
                "<rect x=\"8\" y=\"{:.1}\" width=\"{:.1}\" height=\"{step}\" fill=\"#000000\" opacity=\"0.035\"/>\n",
                middle - 0.5 * step,
                WIDTH - 16.0
            );
        }
        range_row(&mut out, row, middle, [left, right], &x);
    }
    out.push_str("</svg>\n");
    Some(out)
}

/// How ranges are drawn: color, half of the height, offset from the middle of the row.
const RANGES: [(&str, &str, f64, f64); 3] =
    [("#9bb8d6", "draws", 5.5, 0.0), ("#1f6fb5", "choices", 2.5, 0.0), ("#c2571a", "twin", 1.8, 9.0)];

fn legend(out: &mut String, draws: u64) {
    let y = 50.0;
    let mut at = 16.0;
    let names = [
        ("over the choices, each alone", 1),
        ("over draws of all choices at once", 0),
        ("over what is uncertain in the twin", 2),
    ];
    for (name, k) in names {
        if k == 0 && draws == 0 {
            continue;
        }
        let (color, _, half, _) = RANGES[k];
        let height = 2.0 * half;
        put!(out, "<rect x=\"{at}\" y=\"{:.1}\" width=\"30\" height=\"{height}\" fill=\"{color}\"/>\n", y - 4.0 - half);
        let words = if k == 0 { format!("over {draws} draws of all choices at once") } else { name.to_owned() };
        text(out, [at + 37.0, y], "start", INK, &words);
        at += 270.0;
    }
    let y = 72.0;
    line(out, [31.0, y - 12.0, 31.0, y + 4.0], LIMIT, "stroke-width=\"1.8\"");
    text(out, [53.0, y], "start", INK, "published, or second count");
    let kinds = [Agreement::Agrees, Agreement::Compatible, Agreement::NotReproduced, Agreement::NotComparable];
    for (found, at) in kinds.into_iter().zip([220.0, 340.0, 470.0, 620.0]) {
        dot(out, [at, y - 4.0], found);
        text(out, [at + 12.0, y], "start", INK, found.words());
    }
}

fn dot(out: &mut String, [x, y]: [f64; 2], found: Agreement) {
    let shape = match found {
        Agreement::Agrees => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\" fill=\"#2f8f4e\""),
        Agreement::Compatible => {
            format!("<path d=\"M{x:.1} {:.1}l7 7l-7 7l-7 -7z\" fill=\"#e0a31a\"", y - 7.0)
        }
        Agreement::NotReproduced => {
            format!("<path d=\"M{:.1} {:.1}h11v11h-11z\" fill=\"#c8323c\"", x - 5.5, y - 5.5)
        }
        Agreement::NotComparable => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\" fill=\"#ffffff\""),
    };
    put!(out, "{shape} stroke=\"{INK}\" stroke-width=\"1\"/>\n");
}

fn range_row(out: &mut String, row: &Published, middle: f64, [left, right]: [f64; 2], x: &impl Fn(f64) -> f64) {
    let part = |v: f64| v / row.published;
    // Long names take two lines.
    let (name, more) = halves(&row.name);
    if more.is_empty() {
        text(out, [left - 14.0, middle + 4.0], "end", INK, &name);
    } else {
        text(out, [left - 14.0, middle - 3.0], "end", INK, &name);
        text(out, [left - 14.0, middle + 11.0], "end", INK, &more);
    }
    let ranges = [row.over_draws, row.over_choices, row.over_twin];
    for ((color, _, half, down), range) in RANGES.into_iter().zip(ranges) {
        let Some([a, b]) = range else { continue };
        let (from, to) = (part(a).min(part(b)), part(a).max(part(b)));
        let (x1, x2) = (x(from), x(to));
        put!(
            out,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{color}\"/>\n",
            x1.min(x2 - 1.5),
            middle + down - half,
            (x2 - x1).max(1.5),
            2.0 * half
        );
        for (beyond, at, sign) in [(from < LEAST, left, -1.0), (to > MOST, right, 1.0)] {
            if beyond {
                put!(
                    out,
                    "<path d=\"M{at:.1} {:.1}l{:.1} {:.1}l{:.1} {:.1}z\" fill=\"{color}\"/>\n",
                    middle + down - half - 2.0,
                    8.0 * sign,
                    half + 2.0,
                    -8.0 * sign,
                    half + 2.0
                );
            }
        }
    }
    let Some(value) = row.value else { return };
    dot(out, [x(part(value)), middle], row.agreement);
    let unit = crate::report::rows::symbol(&row.unit);
    text(out, [right + 16.0, middle - 3.0], "start", INK, &format!("{} {unit}", digits(value)));
    text(out, [right + 16.0, middle + 11.0], "start", LIMIT, &format!("{} {unit} published", compact(row.published)));
}

fn digits(value: f64) -> String {
    match value.abs() {
        v if v >= 100.0 => fixed(value, 1),
        v if v >= 1.0 => fixed(value, 2),
        _ => fixed(value, 3),
    }
}

/// A name in one line or two.
fn halves(name: &str) -> (String, String) {
    const LONGEST: usize = 40;
    if name.chars().count() <= LONGEST {
        return (name.to_owned(), String::new());
    }
    let half = name.len() / 2;
    let at = name.match_indices(' ').map(|m| m.0).min_by_key(|at| at.abs_diff(half));
    at.map_or_else(|| (name.to_owned(), String::new()), |at| (name[..at].to_owned(), name[at + 1..].to_owned()))
}
