//! What the places say of `ra_um` and `rz_um`, and the summary of all of them.
//!
//! A profile has Ra between two bounds: the smallest and largest over the spindle phases, less and more by
//! what the design's own error can do (twice its size: each height is off by it at most, and so is the mean
//! line), and more by the residual that the tools state. It passes when the upper bound keeps the tolerance,
//! fails when the lower one does not, and is not decided between. An envelope has no teeth: it may fail, and
//! passes only where its tools state what the rest adds, with the marks of teeth on top (`toothless`).

use super::toothless::{PARABOLA_RA, missing};
use crate::{
    judge::surface_gate::Judgement,
    prepare::prepared::Prepared,
    scene::tolerance::{Limit, SurfaceKey, Tolerances},
    verdict::{
        finding,
        log::FindingLog,
        surface_words::ONE_FIGURE_UM,
        verdict_file::{Spread, State, Surface, TextureUsed},
    },
};

/// Most reasons that a judgement gives; the verdict has all of them.
const TOLD: usize = 3;

/// Judges the tolerances that the scene sets, and sums the places up.
pub(crate) fn judge(prepared: &Prepared, surface: &mut Surface, log: &mut FindingLog) -> Vec<Judgement> {
    sum_up(surface);
    let tolerances = &prepared.scene.file.tolerances;
    let asked = [(SurfaceKey::Ra, "Ra"), (SurfaceKey::Rz, "Rz")].into_iter().filter(|(key, _)| tolerances.asks(*key));
    asked.map(|(key, name)| one(key, name, tolerances, &surface.textures, log)).collect()
}

/// The profile of a tolerance: direction, bounds of its value, and what is allowed there, µm.
struct Bounds<'a> {
    of: &'a TextureUsed,
    direction: &'a str,
    low: f64,
    high: f64,
    /// Part of `high` that marks of teeth may add to an envelope.
    teeth: f64,
    limit: f64,
    region: Option<&'a str>,
}

fn bounds<'a>(key: SurfaceKey, tolerances: &'a Tolerances, textures: &'a [TextureUsed]) -> Vec<Bounds<'a>> {
    textures
        .iter()
        .flat_map(|t| t.profiles.iter().map(move |p| (t, p)))
        .filter_map(|(t, p)| {
            let limit = tolerances.limit(key, &t.at_mm.into())?;
            let ra = key == SurfaceKey::Ra;
            let [low, high] = if ra { p.ra_um } else { p.rz_um }?;
            let residual = if ra { t.residual.ra_um } else { t.residual.rz_um };
            let off = 2.0 * t.design_error_um;
            let teeth = t.teeth_rz_um.unwrap_or(0.0) * if ra { PARABOLA_RA } else { 1.0 };
            Some(Bounds {
                of: t,
                direction: &p.direction,
                low: (low + residual[0] - off).max(0.0),
                high: high + residual[1] + off + teeth,
                teeth,
                limit: limit.um,
                region: tolerances.region_name(&limit),
            })
        })
        .collect()
}

impl Bounds<'_> {
    /// What is allowed, with the region that says so.
    fn allowed(&self) -> String {
        let region = self.region.map_or_else(String::new, |r| format!(" in region {r:?}"));
        format!("{} um{region}", self.limit)
    }
}

fn place(t: &TextureUsed) -> String {
    let [x, y, z] = t.at_mm;
    let line = t.blocks.first().and_then(|b| Some(format!(", {}:{}", b.file.as_ref()?, b.line?)));
    format!("{} at X{x:.3} Y{y:.3} Z{z:.3}{}", t.name, line.unwrap_or_default())
}

fn figures(b: &Bounds<'_>) -> String {
    if b.high - b.low < ONE_FIGURE_UM {
        format!("{:.4} um", b.high)
    } else {
        format!("{:.4} to {:.4} um", b.low, b.high)
    }
}

fn one(
    key: SurfaceKey,
    name: &str,
    tolerances: &Tolerances,
    textures: &[TextureUsed],
    log: &mut FindingLog,
) -> Judgement {
    let all = bounds(key, tolerances, textures);
    let key_word = key.word();
    let above: Vec<&Bounds<'_>> = all.iter().filter(|b| b.low > b.limit).collect();
    for b in &above {
        let message = format!("{name} {} {}: {}; allowed are {}", place(b.of), b.direction, figures(b), b.allowed());
        let mut f = FindingLog::of(&finding::ROUGHNESS, message);
        (f.value, f.limit, f.unit) = (Some(b.low), Some(b.limit), Some("um".into()));
        f.point_mm = Some(b.of.at_mm);
        if let Some(made) = b.of.blocks.first() {
            (f.block, f.file, f.line) = (Some(made.block), made.file.clone(), made.line);
        }
        log.push(f);
    }
    // With bounds of regions the one that is nearest to its own, or most above it.
    let worst = all.iter().reduce(|a, b| if b.high / b.limit > a.high / a.limit { b } else { a });
    let mut limits: Vec<String> = all.iter().map(Bounds::allowed).collect();
    limits.dedup();
    let limits = limits.join(", ");
    let worst = worst.map(|b| format!("worst {} {}: {}", place(b.of), b.direction, figures(b)));
    if !above.is_empty() {
        let worst = worst.unwrap_or_default();
        let reason = format!("{} of {} profiles above {limits}; {worst}", above.len(), all.len());
        return Judgement { key: key_word, state: State::Fail, reason };
    }
    let mut open: Vec<String> = all
        .iter()
        .filter(|b| b.high > b.limit)
        .map(|b| {
            let why = if b.of.design_error_um > 0.0 && b.high - 4.0 * b.of.design_error_um <= b.limit {
                format!("the design is coarser than the tolerance (its own error is {} um)", b.of.design_error_um)
            } else if b.teeth > 0.0 && b.high - b.teeth <= b.limit {
                format!("marks of the teeth along the path, which an envelope does not show, may add {:.4} um", b.teeth)
            } else {
                "it depends on the spindle phase and the residual".to_owned()
            };
            format!("{} {}: {} against {}: {why}", place(b.of), b.direction, figures(b), b.allowed())
        })
        .collect();
    let asked = || textures.iter().filter(move |t| tolerances.limit(key, &t.at_mm.into()).is_some());
    let toothless = asked().filter(|t| !t.profiles.is_empty());
    let toothless: Vec<String> = toothless.filter_map(|t| Some(format!("{}: {}", t.name, missing(t)?))).collect();
    open = [toothless, open].concat();
    open.extend(asked().flat_map(|t| t.unchecked.iter().map(move |u| format!("{}: {u}", t.name))));
    if all.is_empty() && open.is_empty() {
        open.push("no patch or profile under [surface] was evaluated".into());
    }
    open.extend(unseen_regions(key, tolerances, textures));
    if open.is_empty() {
        let mut silent: Vec<&str> = asked().flat_map(|t| t.residual.missing.iter().map(String::as_str)).collect();
        silent.sort_unstable();
        silent.dedup();
        let alone = if silent.is_empty() {
            String::new()
        } else {
            format!(
                "; of the motion alone: vibration, ploughing and tear are left out, since {} does not state them \
                 ([tool.residual])",
                silent.join(", ")
            )
        };
        let reason = format!("{} profiles at most {limits}; {}{alone}", all.len(), worst.unwrap_or_default());
        return Judgement { key: key_word, state: State::Pass, reason };
    }
    let more = open.len().saturating_sub(TOLD);
    let mut reasons: Vec<String> = open.into_iter().take(TOLD).collect();
    if more > 0 {
        reasons.push(format!("{more} more reasons in `surface.textures`"));
    }
    Judgement { key: key_word, state: State::Unchecked, reason: reasons.join("; ") }
}

/// Regions with a bound in which no place was asked for.
fn unseen_regions(key: SurfaceKey, tolerances: &Tolerances, textures: &[TextureUsed]) -> Vec<String> {
    let seen: Vec<Limit> = textures.iter().filter_map(|t| tolerances.limit(key, &t.at_mm.into())).collect();
    let open = tolerances.limits(key).into_iter().filter(|l| l.region.is_some() && !seen.contains(l));
    open.filter_map(|l| {
        Some(format!("region {:?} has no patch or profile under [surface]", tolerances.region_name(&l)?))
    })
    .collect()
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
