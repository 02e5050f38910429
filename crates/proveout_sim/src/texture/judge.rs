//! What the places say of `ra_um` and `rz_um`, and the summary of all of them.
//!
//! A profile has Ra between two bounds: the smallest and largest over the spindle phases, less and more by what the design's own error can do
//! (twice its size: each height is off by it at most, and so is the mean line), and more by the residual that the tools state. It passes when the
//! upper bound keeps the tolerance, fails when the lower one does not, and is not decided between.

use crate::{
    finding,
    log::FindingLog,
    prepare::Prepared,
    surface_gate::Judgement,
    verdict::{Spread, State, Surface, TextureUsed},
};

/// Reasons that a judgement tells; the verdict has all of them.
const TOLD: usize = 3;

/// Judges the tolerances that the scene sets, and sums the places up.
pub(crate) fn judge(prepared: &Prepared, surface: &mut Surface, log: &mut FindingLog) -> Vec<Judgement> {
    sum_up(surface);
    let tolerances = &prepared.scene.file.tolerances;
    let asked = [("ra_um", "Ra", tolerances.ra_um), ("rz_um", "Rz", tolerances.rz_um)];
    asked
        .into_iter()
        .enumerate()
        .filter_map(|(k, (key, name, limit))| Some(one(k, key, name, limit?, &surface.textures, log)))
        .collect()
}

/// The profile of a tolerance: direction, and bounds of its value, µm.
struct Bounds<'a> {
    of: &'a TextureUsed,
    direction: &'a str,
    low: f64,
    high: f64,
}

fn bounds(k: usize, textures: &[TextureUsed]) -> Vec<Bounds<'_>> {
    textures
        .iter()
        .flat_map(|t| t.profiles.iter().map(move |p| (t, p)))
        .filter_map(|(t, p)| {
            let [low, high] = if k == 0 { p.ra_um } else { p.rz_um }?;
            let residual = if k == 0 { t.residual.ra_um } else { t.residual.rz_um };
            let off = 2.0 * t.design_error_um;
            Some(Bounds {
                of: t,
                direction: &p.direction,
                low: (low + residual[0] - off).max(0.0),
                high: high + residual[1] + off,
            })
        })
        .collect()
}

fn place(t: &TextureUsed) -> String {
    let [x, y, z] = t.at_mm;
    let line = t.blocks.first().and_then(|b| Some(format!(", {}:{}", b.file.as_ref()?, b.line?)));
    format!("{} at X{x:.3} Y{y:.3} Z{z:.3}{}", t.name, line.unwrap_or_default())
}

fn figures(b: &Bounds<'_>) -> String {
    if b.high - b.low < 5e-5 { format!("{:.4} um", b.high) } else { format!("{:.4} to {:.4} um", b.low, b.high) }
}

fn one(
    k: usize,
    key: &'static str,
    name: &str,
    limit: f64,
    textures: &[TextureUsed],
    log: &mut FindingLog,
) -> Judgement {
    let all = bounds(k, textures);
    let above: Vec<&Bounds<'_>> = all.iter().filter(|b| b.low > limit).collect();
    for b in &above {
        let message = format!("{name} {} {}: {}; allowed are {limit} um", place(b.of), b.direction, figures(b));
        let mut f = FindingLog::of(&finding::ROUGHNESS, message);
        (f.value, f.limit, f.unit) = (Some(b.low), Some(limit), Some("um".into()));
        f.point_mm = Some(b.of.at_mm);
        if let Some(made) = b.of.blocks.first() {
            (f.block, f.file, f.line) = (Some(made.block), made.file.clone(), made.line);
        }
        log.push(f);
    }
    let worst = all.iter().reduce(|a, b| if b.high > a.high { b } else { a });
    let worst = worst.map(|b| format!("worst {} {}: {}", place(b.of), b.direction, figures(b)));
    if !above.is_empty() {
        let worst = worst.unwrap_or_default();
        let reason = format!("{} of {} profiles above {limit} um; {worst}", above.len(), all.len());
        return Judgement { key, state: State::Fail, reason };
    }
    let mut open: Vec<String> = all
        .iter()
        .filter(|b| b.high > limit)
        .map(|b| {
            let why = if b.of.design_error_um > 0.0 && b.high - 4.0 * b.of.design_error_um <= limit {
                format!("the design is coarser than the tolerance (its own error is {} um)", b.of.design_error_um)
            } else {
                "its spindle phase and its residual decide".to_owned()
            };
            format!("{} {}: {} against {limit} um: {why}", place(b.of), b.direction, figures(b))
        })
        .collect();
    open.extend(textures.iter().flat_map(|t| t.unchecked.iter().map(move |u| format!("{}: {u}", t.name))));
    if all.is_empty() && open.is_empty() {
        open.push("no patch or profile under [surface] was evaluated".into());
    }
    if open.is_empty() {
        let reason = format!("{} profiles at most {limit} um; {}", all.len(), worst.unwrap_or_default());
        return Judgement { key, state: State::Pass, reason };
    }
    let more = open.len().saturating_sub(TOLD);
    let mut told: Vec<String> = open.into_iter().take(TOLD).collect();
    if more > 0 {
        told.push(format!("{more} more reasons in `surface.textures`"));
    }
    Judgement { key, state: State::Unchecked, reason: told.join("; ") }
}

/// Smallest, mean and largest over the places.
fn sum_up(surface: &mut Surface) {
    if surface.textures.is_empty() {
        return;
    }
    let spread = |values: Vec<f64>| {
        let count = values.len() as f64;
        (count > 0.0).then(|| Spread {
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            mean: values.iter().sum::<f64>() / count,
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    };
    let textures = &surface.textures;
    let profiles = || textures.iter().flat_map(|t| &t.profiles);
    surface.patches = Some(textures.iter().filter(|t| t.size_mm.is_some()).count() as u64);
    surface.ra_um = spread(profiles().filter_map(|p| p.ra_um).map(|r| r[1]).collect());
    surface.rz_um = spread(profiles().filter_map(|p| p.rz_um).map(|r| r[1]).collect());
    surface.sa_um = spread(textures.iter().filter_map(|t| t.sa_um).collect());
    surface.sz_um = spread(textures.iter().filter_map(|t| t.sz_um).collect());
    let of = |key: &str| -> Vec<String> {
        let mut found: Vec<String> = profiles()
            .filter_map(|p| Some(p.report.get(key)?.as_str().map_or_else(|| p.report[key].to_string(), str::to_owned)))
            .collect();
        found.sort();
        found.dedup();
        found
    };
    let mut text = "form removed by distance to the design; Sa and Sz of the kinematic surface, unfiltered".to_owned();
    if profiles().next().is_some() {
        text += &format!(
            "; Ra and Rz by {}, class {}, lambda_s {} um, lambda_c {} mm",
            of("standard").join(" and "),
            of("class").join(" and "),
            of("lambda_s_um").join(" and "),
            of("lambda_c_mm").join(" and ")
        );
    }
    surface.filter = Some(text);
}
