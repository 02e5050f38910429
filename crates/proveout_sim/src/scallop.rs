//! The scallop of the cut part against `[tolerances] scallop_um`.
//!
//! Ridges between passes are found on the cut stock and measured on the motion that cut it (`proveout_surface::scallop`). The 95th
//! percentile of their heights, by length, is judged: with `e` the error that is left (chord error of the design, deviation of the pieces of
//! motion from the path), more than the limit plus `e` fails, up to the limit less `e` passes, and between nobody can tell.

use proveout_geom::{Aabb, Point};
use proveout_stock::{Patch, TriDexel};
use proveout_surface::scallop::{
    CutterContact, Ridge, RidgeSettings, Ridges, by_pass, by_patch, heights, histogram, ridges,
};
use proveout_tool::Profile;

use crate::{
    design::{Neighbors, design},
    engine::Facts,
    finding,
    kept_motion::{MOST_PIECES, Swept},
    log::FindingLog,
    prepare::Prepared,
    scallop_figures::{Scallop, ScallopBar, ScallopHeights, ScallopPass, ScallopPatch},
    surface_gate::Judgement,
    verdict::{State, Surface},
};

/// Places on ridges that are measured at most; of more every second, third, ... is taken.
const MOST_PLACES: usize = 60_000;
/// Edge of the cubes that stand for patches, mm.
const PATCH_MM: f64 = 4.0;
/// Patches and passes that the verdict lists.
const PATCHES_TOLD: usize = 20;
const PASSES_TOLD: usize = 50;
/// Part of the ridges that may be unknown.
const UNKNOWN: f64 = 0.01;
/// Every so manyth ridge at most tells the width of its strip: it takes longer than the ridge itself.
const WIDTHS: usize = 200;

const KEY: &str = "scallop_um";

/// The ridges of a part.
pub(crate) struct Measured {
    found: Ridges,
    cutters: Vec<Vec<Profile>>,
    /// Bound of the heights, mm.
    bound: f64,
}

/// Measures the scallop where the scene sets a tolerance for it: a reason where it cannot be measured.
pub(crate) fn measure(
    prepared: &Prepared,
    facts: &Facts,
    swept: Option<&Swept>,
    stock: &TriDexel,
    patches: &[Patch],
) -> Option<Result<Measured, String>> {
    prepared.scene.file.tolerances.scallop_um?;
    let kept = facts.motion.as_ref().and_then(|m| m.pieces()).zip(swept);
    let Some((pieces, Swept { path, cutters })) = kept else {
        return Some(Err(format!("the motion has more than {MOST_PIECES} pieces, which are not kept")));
    };
    let Some(design) = design(prepared) else { return Some(Err("the scene has no design part".into())) };
    let windows: Vec<Aabb> = patches.iter().map(|p| *p.window()).collect();
    let region = prepared.scene.file.part.as_ref().and_then(|p| p.judged).map(|b| b.aabb());
    let stocks = std::iter::once((None, stock)).chain(patches.iter().enumerate().map(|(k, p)| (Some(k), p.stock())));
    let mut found = Ridges::default();
    for (patch, rays) in stocks {
        let settings = RidgeSettings {
            reach: design.reach,
            region,
            window: patch.map(|k: usize| windows[k]),
            finer: &windows[..patch.unwrap_or(windows.len())],
            most: MOST_PLACES,
        };
        let own = ridges(rays, path, cutters, design.surface.as_ref(), &settings);
        found.ridges.extend(own.ridges);
        found.not_followed += own.not_followed;
        found.narrow += own.narrow;
        found.largest_check = found.largest_check.max(own.largest_check);
    }
    let deviation = |n: u32| pieces.get(n as usize).map_or(0.0, |p| f64::from(p.deviation));
    let motion = found.ridges.iter().flat_map(|r| r.pieces).map(deviation).fold(0.0, f64::max);
    Some(Ok(Measured { found, cutters: cutters.clone(), bound: design.floor + motion }))
}

impl Measured {
    /// Heights for the map of the surface, mm: about every point the mean of the ridges beside it.
    pub(crate) fn map(&self) -> Option<Neighbors> {
        let spacing = self.found.ridges.iter().filter_map(|r| r.spacing).fold(0.0, f64::max);
        let mut near = (spacing > 0.0).then(|| Neighbors::new(spacing))?;
        self.found.ridges.iter().for_each(|r| near.add(&r.point, r.height));
        Some(near)
    }

    fn figures(&self, facts: &Facts, limit_um: f64) -> Option<Scallop> {
        let ridges = &self.found.ridges;
        let all = heights(ridges)?;
        let patches = by_patch(ridges, PATCH_MM);
        let mut passes = by_pass(ridges);
        let (patch_count, pass_count) = (patches.len() as u64, passes.len() as u64);
        if passes.len() > PASSES_TOLD {
            passes.sort_by(|a, b| b.heights.p95.total_cmp(&a.heights.p95));
            passes.truncate(PASSES_TOLD);
        }
        let both: Vec<(f64, f64, f64)> =
            ridges.iter().filter_map(|r| r.geometric.map(|g| (g, r.height - g, r.weight))).collect();
        let length: f64 = both.iter().map(|b| b.2).sum();
        let mean = |of: fn(&(f64, f64, f64)) -> f64| {
            (length > 0.0).then(|| 1e3 * both.iter().map(|b| b.2 * of(b)).sum::<f64>() / length)
        };
        let spacings = || ridges.iter().filter_map(|r| r.spacing.map(|s| (s, r.weight)));
        let of_spacings: f64 = spacings().map(|s| s.1).sum();
        let [strip, swept] = self.widths(1e-3 * limit_um);
        let bars = histogram(ridges);
        let bar = |(k, length_mm): (usize, &f64)| {
            let [from_um, to_um] = [k, k + 1].map(|k| 1e3 * (bars.from + k as f64 * bars.width));
            ScallopBar { from_um, to_um, length_mm: *length_mm }
        };
        Some(Scallop {
            bound_um: 1e3 * self.bound,
            all: ScallopHeights::from(&all),
            geometric_mean_um: mean(|b| b.0),
            difference_mean_um: mean(|b| b.1),
            difference_p95_um: percentile(both.iter().map(|b| (b.1.abs(), b.2))).map(|v| 1e3 * v),
            spacing_mean_mm: (of_spacings > 0.0).then(|| spacings().map(|s| s.0 * s.1).sum::<f64>() / of_spacings),
            spacing_max_mm: spacings().map(|s| s.0).reduce(f64::max),
            strip_width_min_mm: strip,
            swept_width_min_mm: swept,
            histogram: bars.lengths.iter().enumerate().map(bar).collect(),
            patches: patches
                .iter()
                .take(PATCHES_TOLD)
                .map(|p| {
                    let highest = &ridges[p.heights.highest];
                    ScallopPatch {
                        middle_mm: p.middle.coords.into(),
                        highest_mm: highest.point.coords.into(),
                        blocks: blocks(facts, highest),
                        heights: ScallopHeights::from(&p.heights),
                    }
                })
                .collect(),
            passes: passes
                .iter()
                .map(|p| ScallopPass {
                    begins: place(facts, p.first_piece).unwrap_or_default(),
                    heights: ScallopHeights::from(&p.heights),
                })
                .collect(),
            patch_count,
            pass_count,
        })
    }

    /// Smallest width of the strips up to a height above a plane: of the standing and of the moving cutter.
    fn widths(&self, height: f64) -> [Option<f64>; 2] {
        let stride = self.found.ridges.len().div_ceil(WIDTHS).max(1);
        let mut least = [None, None];
        for side in self.found.ridges.iter().step_by(stride).filter_map(|r| r.sides).flatten() {
            let bodies = self.cutters.get(side.cutter as usize).map_or(&[][..], Vec::as_slice);
            let contacts = bodies.iter().filter_map(|b| CutterContact::new(b, side.axis, side.normal, side.feed));
            for contact in contacts {
                let widths = [contact.section_width(height), contact.swept_width(height)];
                for (least, width) in least.iter_mut().zip(widths) {
                    let width = width.map(|[left, right]| left + right);
                    *least = match (*least, width) {
                        (Some(a), Some(b)) => Some(f64::min(a, b)),
                        (a, b) => a.or(b),
                    };
                }
            }
        }
        least
    }
}

/// The smallest value that 95 percent of the weight do not pass.
fn percentile(values: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let mut all: Vec<(f64, f64)> = values.collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = all.iter().map(|a| a.1).sum();
    let mut passed = 0.0;
    let found = all.iter().find(|a| {
        passed += a.1;
        passed >= 0.95 * total
    });
    found.or(all.last()).map(|a| a.0)
}

/// File and line of the block of a piece.
fn place(facts: &Facts, piece: u32) -> Option<String> {
    let block = facts.block_of_piece.get(piece as usize)?;
    let (file, line) = facts.places.get(*block as usize)?.as_ref()?;
    Some(format!("{file}:{line}"))
}

/// The blocks on both sides of a ridge, the earlier one first.
fn blocks(facts: &Facts, ridge: &Ridge) -> Vec<String> {
    let mut out: Vec<String> = ridge.pieces.into_iter().filter_map(|p| place(facts, p)).collect();
    out.dedup();
    out
}

/// Judges what was measured, and fills in what the verdict says of it.
pub(crate) fn judge(
    prepared: &Prepared,
    facts: &Facts,
    measured: Option<&Result<Measured, String>>,
    surface: &mut Surface,
    log: &mut FindingLog,
) -> Option<Judgement> {
    let limit = prepared.scene.file.tolerances.scallop_um?;
    let unchecked = |reason: String| Some(Judgement { key: KEY, state: State::Unchecked, reason });
    let measured = match measured? {
        Ok(measured) => measured,
        Err(reason) => return unchecked(reason.clone()),
    };
    let Some(figures) = measured.figures(facts, limit) else {
        let lost = match measured.found.not_followed {
            0 => "passes that lie nearer than two cells have none between the rays",
            _ => "the motion that made them is not known",
        };
        return unchecked(format!("no ridge between two passes was found on the judged surface: {lost}"));
    };
    let all = figures.all.clone();
    (surface.scallop_max_um, surface.scallop_mean_um, surface.scallop_p95_um) =
        (Some(all.max_um), Some(all.mean_um), Some(all.p95_um));
    let worst = figures.patches.first().cloned().unwrap_or_default();
    let bound = figures.bound_um;
    let difference = match (figures.geometric_mean_um, figures.difference_p95_um) {
        (Some(mean), Some(apart)) => format!("; the geometry of the contacts gives {mean:.3} um, within {apart:.3} um"),
        _ => String::new(),
    };
    let [x, y, z] = worst.highest_mm;
    let made = if worst.blocks.is_empty() { String::new() } else { format!(", cut by {}", worst.blocks.join(" and ")) };
    let told = format!(
        "95th percentile {:.3} um (known to {bound:.3} um) at {} places on {:.1} mm of ridges, mean {:.3} um, allowed {limit} \
         um{difference}; worst in the patch at X{x:.3} Y{y:.3} Z{z:.3} with {:.3} um{made}",
        all.p95_um, all.places, all.length_mm, all.mean_um, worst.heights.p95_um
    );
    let length = all.length_mm;
    surface.scallop = Some(figures);
    let state = if all.p95_um - bound > limit {
        State::Fail
    } else if all.p95_um + bound > limit {
        let help = "a design with a smaller chord error, or a smaller path tolerance, decides it";
        return unchecked(format!("{told}; the limit lies within the error: {help}"));
    } else {
        State::Pass
    };
    if state == State::Fail {
        let mut f = FindingLog::of(&finding::SCALLOP, format!("scallop: {told}"));
        (f.value, f.limit, f.unit) = (Some(all.p95_um), Some(limit), Some("um".into()));
        f.point_mm = Some(worst.highest_mm);
        let highest = measured.found.ridges.iter().find(|r| <[f64; 3]>::from(r.point.coords) == worst.highest_mm);
        let piece = highest.map(|r| r.pieces[1] as usize);
        f.block = piece.and_then(|p| facts.block_of_piece.get(p)).copied();
        if let Some((file, line)) = f.block.and_then(|b| facts.places.get(b as usize)).and_then(Option::as_ref) {
            (f.file, f.line) = (Some(file.to_string()), Some(*line));
        }
        log.push(f);
        return Some(Judgement { key: KEY, state, reason: told });
    }
    // A pass must have seen all of it.
    let lost = measured.found.not_followed as f64;
    if lost > UNKNOWN * (lost + all.places as f64) {
        return unchecked(format!("{told}; {lost} more places lie on surfaces that no motion of this run has swept"));
    }
    if measured.found.narrow > UNKNOWN * length {
        return unchecked(format!(
            "{told}; {:.1} mm of ridges lie nearer to their neighbor than two cells, where others may be missed: take finer cells \
             or a [[stock.patch]]",
            measured.found.narrow
        ));
    }
    Some(Judgement { key: KEY, state, reason: told })
}

/// The scallop about some points, mm.
pub(crate) fn at(map: Option<&Neighbors>, places: &[Point]) -> Vec<Option<f64>> {
    map.map_or_else(
        || vec![None; places.len()],
        |m| m.at(places).into_iter().map(|v| v.is_finite().then_some(v)).collect(),
    )
}
