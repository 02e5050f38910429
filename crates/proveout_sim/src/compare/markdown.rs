//! A comparison as a section of a Markdown page; every number in it comes from the comparison.

use std::fmt::Write;

use super::{
    BOUNDS, GAP,
    result::{Comparison, Depth, Gain, GainAtLimit, Made, ProgramFigures, Published, Variation},
    uncertainty::{TimeGain, VariationKind},
};
use crate::{
    compare::certificate::VelocityLimit, scene::PublishedKindFile, units::UM_PER_MM, verdict::verdict_file::State,
};

/// Sizes of numbers that are written without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-4..1e7;

/// Section of a comparison: gain with error, published values, criteria, joints, cut part, variations, rules.
pub fn markdown(c: &Comparison) -> String {
    let mut out = String::new();
    put(&mut out, format_args!("## {}\n\n", c.scene));
    for text in [&c.experiment, &c.description].into_iter().filter(|t| !t.is_empty()) {
        put(&mut out, format_args!("{}.\n\n", cell(text.trim_end_matches('.'))));
    }
    put(
        &mut out,
        format_args!(
            "Machine: {}. Baseline: `{}`. Verdict of the comparison: **{}**.\n\n",
            cell(&c.machine),
            c.baseline,
            word(c.verdict)
        ),
    );
    if let Some(names) = &c.must_pass {
        let names: Vec<String> = names.iter().map(|n| format!("`{}`", cell(n))).collect();
        if names.is_empty() {
            out.push_str("Published values and criteria decide; the verdicts of the programs do not.\n\n");
        } else {
            put(&mut out, format_args!("These programs must pass: {}.\n\n", names.join(", ")));
        }
    }
    if let Some(same) = c.same_texts_in_words() {
        put(&mut out, format_args!("Programs with byte-identical text: {}.\n\n", cell(&same)));
    }
    limits(&mut out, c);
    times(&mut out, c);
    gaps(&mut out, c);
    published(&mut out, c);
    expectations(&mut out, c);
    joints(&mut out, c);
    depths(&mut out, c);
    part(&mut out, c);
    variations(&mut out, c);
    out.push_str("### Rules\n\n");
    for (name, rule) in &c.rules {
        put(&mut out, format_args!("- *{name}*: {rule}.\n"));
    }
    out
}

fn put(out: &mut String, text: std::fmt::Arguments<'_>) {
    out.write_fmt(text).unwrap_or_default(); // a string takes everything
}

/// Programs in the order of the scene.
fn programs(c: &Comparison) -> impl Iterator<Item = (&String, &ProgramFigures)> {
    c.order.iter().filter_map(|name| c.programs.get_key_value(name))
}

fn gains(c: &Comparison) -> impl Iterator<Item = (&String, &Gain)> {
    c.order.iter().filter_map(|name| c.gains.get_key_value(name))
}

fn limits(out: &mut String, c: &Comparison) {
    if c.joint_limits.is_empty() {
        return;
    }
    out.push_str("### Limits of joints that the scene sets for all programs\n\n");
    out.push_str(
        "| machine | joint | limit | of the machine | of the scene | unit | source |\n|---|---|---|---|---|---|---|\n",
    );
    for l in &c.joint_limits {
        let own = l.of_machine.map_or_else(|| "none".to_owned(), |v| v.to_string());
        let (machine, joint, source) = (cell(&l.machine), cell(&l.joint), cell(&l.source));
        put(
            out,
            format_args!("| {machine} | {joint} | {} | {own} | {} | {} | {source} |\n", l.quantity, l.of_scene, l.unit),
        );
    }
    let own: Vec<String> =
        c.order.iter().filter_map(|name| Some(format!("`{name}` {:.2}", c.at_own_limits(name)?))).collect();
    if !own.is_empty() {
        let own = own.join(", ");
        put(
            out,
            format_args!("\nWith the limits of the machine itself the cutting stretch saves, in percent: {own}.\n"),
        );
    }
    out.push('\n');
}

fn times(out: &mut String, c: &Comparison) {
    out.push_str("### Cycle time\n\n");
    out.push_str(
        "| program | verdict | whole program, s | lower bound for any control, s | in feed, s | cutting stretch, s \
         |\n",
    );
    out.push_str("|---|---|---|---|---|---|\n");
    for (name, p) in programs(c) {
        put(
            out,
            format_args!(
                "| {} | {} | {:.3} | {} | {:.3} | {} |\n",
                cell(name),
                word(p.verdict),
                p.time.total_s,
                fixed(p.time.lower_bound_s, 3),
                p.time.cutting_s,
                fixed(p.stretch.as_ref().map(|s| s.time_s), 3)
            ),
        );
    }
    put(out, format_args!("\nTime saved against `{}`, percent, with its error:\n\n", c.baseline));
    out.push_str(
        "| program | whole program | in feed | cutting stretch | as rate, stretch | sign holds in all variations |\n",
    );
    out.push_str("|---|---|---|---|---|---|\n");
    for (name, g) in gains(c) {
        put(
            out,
            format_args!(
                "| {} | {} | {} | {} | {} | {} |\n",
                cell(name),
                with_error(&g.cycle_time),
                with_error(&g.cutting_time),
                with_error(&g.stretch_time),
                fixed(g.stretch_time.rate_percent, 2),
                if g.stretch_time.sign_holds { "yes" } else { "no" }
            ),
        );
    }
    out.push('\n');
}

/// Time, bound and gap of the programs that were made, and what they gain over the limits of their joints.
fn gaps(out: &mut String, c: &Comparison) {
    let figure = |made: &Made, name: &str| made.figures.iter().find(|f| f.name == name).map(|f| f.value);
    let made: Vec<(&String, &Made)> = programs(c).filter_map(|(name, p)| Some((name, p.made.as_ref()?))).collect();
    let about = ["in the channel", "of axes as near to those before", "at these feeds"];
    let found = |made: &Made| BOUNDS.iter().zip(about).find_map(|(name, about)| Some((figure(made, name)?, about)));
    let bound: Vec<_> = made.iter().filter_map(|(name, made)| Some((name, made, found(made)?))).collect();
    if bound.is_empty() {
        return;
    }
    out.push_str(
        "### Gap to the bound\n\nFor the first stretch that the method replanned, under the limits in force.\n\n",
    );
    out.push_str(
        "| program | made from | method | its time, s | lower bound, s | bound over schedules | remaining gain at \
         most, % |\n",
    );
    out.push_str("|---|---|---|---|---|---|---|\n");
    for (name, made, (below, about)) in bound {
        let [time, left] = GAP.map(|name| figure(made, name));
        put(
            out,
            format_args!(
                "| {} | {} | {} | {} | {} | {about} | {} |\n",
                cell(name),
                cell(&made.from),
                cell(&made.method),
                fixed(time, 3),
                fixed(Some(below), 3),
                fixed(left, 2)
            ),
        );
    }
    out.push('\n');
    // Leave out a joint whose limits gain nothing anywhere.
    let has_gain =
        |rows: &[&GainAtLimit]| rows.iter().any(|r| r.saved_percent.abs() >= 0.05 || r.saved_at_most_percent >= 0.05);
    let mut lines = Vec::new();
    for (name, made) in made {
        let mut joints: Vec<&str> = made.over_velocity.iter().map(|r| r.joint.as_str()).collect();
        joints.dedup();
        for joint in joints {
            let rows: Vec<&GainAtLimit> = made.over_velocity.iter().filter(|r| r.joint == joint).collect();
            if has_gain(&rows) {
                let cells: Vec<String> = rows.iter().map(|row| at_limit(row)).collect();
                lines.push(format!("| {} | {} | {joint} | {} |\n", cell(name), cell(&made.from), cells.join("; ")));
            }
        }
    }
    if !lines.is_empty() {
        out.push_str(
            "Time saved on that stretch, in percent, for limits of one joint's velocity (only feed and this \
                      limit act); in brackets what the best ",
        );
        out.push_str("schedule of the channel would save:\n\n| program | made from | joint | at a limit in deg/s |\n|---|---|---|---|\n");
        lines.iter().for_each(|line| out.push_str(line));
        out.push('\n');
    }
}

fn at_limit(row: &GainAtLimit) -> String {
    let is = match row.is {
        VelocityLimit::Tried => "",
        VelocityLimit::OfOriginal => ", what the program before needs",
        VelocityLimit::InForce => ", in force",
        VelocityLimit::OfMachine => ", the machine's own",
    };
    let percent = |v: f64| fixed(Some(v), 1);
    let (saved, most) = (percent(row.saved_percent), percent(row.saved_at_most_percent));
    format!("{:.1}{is}: {saved} ({most})", row.velocity_deg_s)
}

/// Head of the table of headlines, for the first page of the experiments.
pub const HEADLINES: &str = "\
| experiment | headline | published | where | here | over what is open | null program | decided by | verdict |
|---|---|---|---|---|---|---|---|---|
";

/// Rows of the headlines of a comparison under [`HEADLINES`]; `link` leads to its section.
pub fn headlines(c: &Comparison, link: &str) -> String {
    let mut out = String::new();
    for p in c.published.iter().filter(|p| p.headline && p.kind != PublishedKindFile::OwnCount) {
        let [published, here, open, null, decided] = values(p);
        put(
            &mut out,
            format_args!(
                "| [{}]({link}) | {} | {published} | {} | {here} | {open} | {null} | {decided} | {} |\n",
                c.scene,
                cell(&p.name),
                cell(&p.source),
                judged(p),
            ),
        );
    }
    out
}

/// Published value, ours, its range over what is open, that of the null program, and the choice that moves it
/// most.
fn values(p: &Published) -> [String; 5] {
    let (unit, digits) = (&p.unit, digits(p.published));
    let ranges = [p.over_choices, p.over_draws, p.over_twin];
    let hull = ranges.into_iter().flatten().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let range = |[low, high]: [f64; 2]| format!("{} to {}", fixed(Some(low), digits), fixed(Some(high), digits));
    [
        format!("{}{} {unit}", p.kind.label(), p.published),
        format!("{} {unit}", fixed(p.value, digits)),
        hull.map_or_else(|| "nothing acts".to_owned(), range),
        p.null_value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$} {unit}")),
        p.decided_by.as_ref().map_or_else(|| "-".to_owned(), |(name, r)| format!("{}: {}", cell(name), range(*r))),
    ]
}

fn judged(p: &Published) -> String {
    match &p.not_comparable {
        Some(why) => format!("{}: {}", p.agreement.words(), cell(why)),
        None => p.agreement.words().to_owned(),
    }
}

fn published(out: &mut String, c: &Comparison) {
    if c.published.is_empty() {
        return;
    }
    let (own, stated): (Vec<&Published>, Vec<&Published>) =
        c.published.iter().partition(|p| p.kind == PublishedKindFile::OwnCount);
    rows(out, c, ("### Published values and ours", "published"), &stated);
    rows(out, c, ("### Second count and ours", "second count by other code"), &own);
    choices(out, c);
}

fn rows(out: &mut String, c: &Comparison, (title, theirs): (&str, &str), all: &[&Published]) {
    if all.is_empty() {
        return;
    }
    put(out, format_args!("{title}\n\n| what | measured here as | {theirs} | here |"));
    let mut columns = 4;
    let mut head = |out: &mut String, words: &str| {
        put(out, format_args!(" {words} |"));
        columns += 1;
    };
    let (open, null) = (c.choices.is_some(), c.null_program.as_deref());
    if let Some(name) = null {
        head(out, &format!("null program `{}`", cell(name)));
    }
    if open {
        ["over the choices alone", "over the draws", "over the twin", "decided by"]
            .iter()
            .for_each(|words| head(out, words));
    }
    ["band", "verdict", "source", "remark"].iter().for_each(|words| head(out, words));
    put(out, format_args!("\n|{}\n", "---|".repeat(columns)));
    for p in all {
        let digits = digits(p.published);
        let [published, here, _, of_null, decided] = values(p);
        put(
            out,
            format_args!(
                "| {} | {} | {} | {here} |",
                cell(&p.name),
                cell(&p.measured),
                if p.kind == PublishedKindFile::OwnCount {
                    published.trim_start_matches(p.kind.label())
                } else {
                    &published
                }
            ),
        );
        if null.is_some() {
            put(out, format_args!(" {of_null} |"));
        }
        if open {
            let range = |r: Option<[f64; 2]>| {
                r.map_or_else(|| "cannot act".to_owned(), |[low, high]| format!("{low:.digits$} to {high:.digits$}"))
            };
            for r in [p.over_choices, p.over_draws, p.over_twin] {
                put(out, format_args!(" {} |", range(r)));
            }
            put(out, format_args!(" {decided} |"));
        }
        let band = p.band.map_or_else(|| "none".to_owned(), |[low, high]| format!("{low} to {high}"));
        put(out, format_args!(" {band} | {} | {} | {} |\n", judged(p), cell(&p.source), cell(&p.remark)));
    }
    out.push('\n');
}

/// Decimals: as many as distinguish the published value from others.
fn digits(published: f64) -> usize {
    if published.abs() < 2.0 { 3 } else { 1 }
}

fn choices(out: &mut String, c: &Comparison) {
    let Some(open) = &c.choices else { return };
    out.push_str("### Choices\n\nEach alone at the ends of its range; then all at once in ");
    put(out, format_args!("{} draws of a Latin hypercube", open.draws));
    if open.refused > 0 {
        put(out, format_args!(", {} of which were refused: {}", open.refused, cell(&open.reasons.join("; "))));
    }
    out.push_str(".\n\n| choice | key | tried | source | why | changes |\n|---|---|---|---|---|---|\n");
    for choice in &open.choices {
        let digits = |name: &str| c.published.iter().find(|p| p.name == name).map_or(1, |p| digits(p.published));
        let change = |(name, [low, high]): (&String, &[f64; 2])| {
            let digits = digits(name);
            format!("{} {low:.digits$} to {high:.digits$}", cell(name))
        };
        let mut acts: Vec<String> = choice.acts_on.iter().map(change).collect();
        if acts.is_empty() {
            acts.push("nothing".to_owned());
        }
        if !choice.refused.is_empty() {
            acts.push(format!("a value was refused: {}", cell(&choice.refused)));
        }
        put(
            out,
            format_args!(
                "| {} | `{}` | {} | {} | {} | {} |\n",
                cell(&choice.name),
                cell(&choice.key),
                choice.tried.join(", "),
                choice.source,
                cell(&choice.reason),
                acts.join("; ")
            ),
        );
    }
    out.push('\n');
}

fn expectations(out: &mut String, c: &Comparison) {
    if c.expectations.is_empty() {
        return;
    }
    out.push_str(
        "### Criteria\n\n| what must hold | measured as | value | bound | judgement |\n|---|---|---|---|---|\n",
    );
    for e in &c.expectations {
        let bound = match (e.at_least, e.at_most) {
            (Some(low), Some(high)) => format!("{low} to {high} {}", e.unit),
            (Some(low), None) => format!("at least {low} {}", e.unit),
            (None, Some(high)) => format!("at most {high} {}", e.unit),
            (None, None) => "pass".to_owned(),
        };
        let value = e.value.map_or_else(String::new, |v| format!("{} {}", significant(v), e.unit));
        let reason =
            if e.reason.is_empty() || e.state == State::Pass { String::new() } else { format!(": {}", e.reason) };
        put(
            out,
            format_args!(
                "| {} | {} | {} | {} | {}{} |\n",
                cell(&e.name),
                cell(&e.measured),
                value.trim_end(),
                bound.trim_end(),
                word(e.state),
                cell(&reason)
            ),
        );
    }
    out.push('\n');
}

fn joints(out: &mut String, c: &Comparison) {
    if programs(c).all(|(_, p)| p.stretch.is_none()) {
        return;
    }
    out.push_str("### Joints over the cutting stretch\n\n");
    out.push_str("Demand is what the program asks for at its programmed feed; reached are the set points under the limits of the machine.\n\n");
    out.push_str("| joint | program | demand velocity | demand acceleration | velocity reached | acceleration reached | jerk reached | reversals |\n");
    out.push_str("|---|---|---|---|---|---|---|---|\n");
    let joints = programs(c).find_map(|(_, p)| p.stretch.as_ref()).map(|s| s.axes.keys()).into_iter().flatten();
    for joint in joints {
        for (name, p) in programs(c) {
            let Some(axis) = p.stretch.as_ref().and_then(|s| s.axes.get(joint)) else { continue };
            let known = |v: Option<f64>| v.map_or_else(|| "not known".to_owned(), significant);
            put(
                out,
                format_args!(
                    "| {joint}, {} | {} | {} | {} | {} | {} | {} | {} |\n",
                    axis.unit,
                    cell(name),
                    known(axis.demand_velocity),
                    known(axis.demand_acceleration),
                    significant(axis.max_velocity),
                    significant(axis.max_acceleration),
                    significant(axis.max_jerk),
                    axis.reversals
                ),
            );
        }
    }
    out.push('\n');
}

fn depths(out: &mut String, c: &Comparison) {
    if programs(c).all(|(_, p)| p.stretch.as_ref().is_none_or(|s| s.depth.is_none())) {
        return;
    }
    out.push_str("### Depth of the cut\n\n");
    out.push_str("| program | places | mean, µm | deviation along a line, µm | least, µm | largest, µm | motion from turning, mm/mm |\n");
    out.push_str("|---|---|---|---|---|---|---|\n");
    for (name, p) in programs(c) {
        let stretch = p.stretch.as_ref();
        let depth = stretch.and_then(|s| s.depth.as_ref());
        let places = depth.map_or_else(|| "not known".to_owned(), |d| d.places.to_string());
        let [mean, deviation, least, most] =
            [|d: &Depth| d.mean_um, |d: &Depth| d.deviation_um, |d: &Depth| d.least_um, |d: &Depth| d.most_um]
                .map(|of| fixed(depth.map(of), 2));
        let turning = fixed(stretch.and_then(|s| s.from_turning), 3);
        put(out, format_args!("| {} | {places} | {mean} | {deviation} | {least} | {most} | {turning} |\n", cell(name)));
    }
    out.push('\n');
}

fn part(out: &mut String, c: &Comparison) {
    out.push_str("### Cut part\n\n");
    out.push_str("| program | gouge, µm | excess, µm | mean deviation, µm | scallop largest, µm | scallop mean, µm | difference to the baseline, rms, µm | largest, µm | least clearance, mm |\n");
    out.push_str("|---|---|---|---|---|---|---|---|---|\n");
    for (name, p) in programs(c) {
        let um = |v: Option<f64>| fixed(v.map(|v| UM_PER_MM * v), 2);
        let d = p.difference.as_ref();
        let largest = d.and_then(|d| d.min_mm.zip(d.max_mm)).map(|(low, high)| low.abs().max(high.abs()));
        put(
            out,
            format_args!(
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
                cell(name),
                um(p.deviation.gouge_max_mm),
                um(p.deviation.excess_max_mm),
                um(p.deviation.mean_mm),
                fixed(p.surface.scallop_max_um, 2),
                fixed(p.surface.scallop_mean_um, 2),
                if d.is_some() { um(d.and_then(|d| d.rms_mm)) } else { "-".into() },
                if d.is_some() { um(largest) } else { "-".into() },
                fixed(p.clearance.min_mm, 2)
            ),
        );
    }
    out.push('\n');
}

fn variations(out: &mut String, c: &Comparison) {
    if c.variations.is_empty() {
        return;
    }
    out.push_str("### Variations of the twin\n\nGain in the time of the cutting stretch, percent, and its change from the nominal twin.\n\n");
    out.push_str("| variation | kind |");
    let names: Vec<&String> = gains(c).map(|(name, _)| name).collect();
    for name in &names {
        put(out, format_args!(" {} | change |", cell(name)));
    }
    out.push_str("\n|---|---|");
    out.push_str(&"---|---|".repeat(names.len()));
    out.push('\n');
    for v in c.variations.iter().filter(|v| v.acts || v.unchecked.is_some()) {
        put(out, format_args!("| {} | {} |", cell(&v.name), kind(v)));
        for name in &names {
            match v.gains.get(*name) {
                Some(g) => put(
                    out,
                    format_args!(
                        " {} | {} |",
                        fixed(g.stretch_time_percent, 3),
                        g.stretch_time_change_percent.map_or_else(|| "not known".into(), |p| format!("{p:+.4}"))
                    ),
                ),
                None => put(out, format_args!(" unchecked: {} | |", cell(v.unchecked.as_deref().unwrap_or_default()))),
            }
        }
        out.push('\n');
    }
    let idle: Vec<String> =
        c.variations.iter().filter(|v| !v.acts && v.unchecked.is_none()).map(|v| cell(&v.name)).collect();
    if !idle.is_empty() {
        put(out, format_args!("\nNot counted, since they change no time of a cutting stretch: {}.\n", idle.join(", ")));
    }
    out.push('\n');
}

fn kind(v: &Variation) -> &'static str {
    match v.kind {
        VariationKind::Numerical => "numerical",
        VariationKind::Model => "model",
    }
}

/// A gain with its error; one whose error reaches zero shows nothing.
fn with_error(g: &TimeGain) -> String {
    match (g.percent, g.error_percent) {
        (Some(p), Some(e)) if p.abs() <= e => format!("{p:.2} ± {e:.2}, no gain shown"),
        (Some(p), Some(e)) => format!("{p:.2} ± {e:.2}"),
        (p, _) => fixed(p, 2),
    }
}

fn fixed(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(
        || "not known".to_owned(),
        |v| format!("{:.digits$}", if v.abs() < 0.5 * 0.1_f64.powi(digits as i32) { 0.0 } else { v }),
    )
}

/// Four significant digits; zero as such.
fn significant(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return format!("{value:.0}");
    }
    if !PLAIN.contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = (3 - size.log10().floor() as i32).clamp(0, 8) as usize;
    format!("{value:.digits$}")
}

fn word(state: State) -> &'static str {
    state.word()
}

/// Text that stays in its cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_stays_in_its_cell() {
        assert_eq!(cell("a|b\nc<d"), "a\\|b c&lt;d");
    }

    #[test]
    fn numbers_have_four_digits() {
        let all = [0.0, 1234.56, 12.3456, 0.012_345_6, -4.0e8, 1e-9].map(significant);
        assert_eq!(all, ["0", "1235", "12.35", "0.01235", "-4.00e8", "1.00e-9"]);
    }
}
