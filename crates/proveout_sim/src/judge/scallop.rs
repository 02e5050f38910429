//! The scallop of the cut part: ridges between passes are found on the cut stock and measured on
//! the motion that cut it (`proveout_surface::scallop`). `scallop_limits` compares them with
//! `[tolerances] scallop_um`.

use proveout_geom::{Aabb, Point};
use proveout_stock::{Patch, TriDexel};
use proveout_surface::scallop::{
    CutterContact, Ridge, RidgeSettings, Ridges, by_pass, by_patch, heights, histogram, ridges,
};
use proveout_tool::Profile;

use crate::{
    cut::{engine::Facts, kept_motion::Swept},
    judge::design::{Neighbors, design},
    prepare::{memory::MOST_PIECES, prepared::Prepared},
    scene::tolerance::SurfaceKey,
    units::{MM_PER_UM, UM_PER_MM},
    verdict::scallop_figures::{Scallop, ScallopBar, ScallopHeights, ScallopPass, ScallopPatch},
};

/// Places on ridges that are measured at most; of more every second, third, ... is taken.
const MOST_PLACES: usize = 60_000;
/// Edge of the cubes that represent patches, mm.
pub(crate) const PATCH_MM: f64 = 4.0;
/// Patches and passes that the verdict lists.
const PATCHES_TOLD: usize = 20;
const PASSES_TOLD: usize = 50;
/// Most ridges whose strip width is measured: the width takes longer than the ridge itself.
const WIDTHS: usize = 200;

/// The ridges of a part.
pub(crate) struct Measured {
    pub(crate) found: Ridges,
    cutters: Vec<Vec<Profile>>,
    /// Bound of the height of each ridge, mm: of the design, and of the two pieces of motion on its
    /// sides.
    pub(crate) bounds: Vec<f64>,
}

/// Heights of ridges by place, mm.
pub(crate) struct RidgeMap {
    measured: Neighbors,
    /// Those that the geometry of the contacts gives.
    geometric: Neighbors,
}

/// Measures the scallop where the scene sets a tolerance for it: a reason where it cannot be measured.
pub(crate) fn measure(
    prepared: &Prepared,
    facts: &Facts,
    swept: Option<&Swept>,
    stock: &TriDexel,
    patches: &[Patch],
) -> Option<Result<Measured, String>> {
    if !prepared.scene.file.tolerances.asks(SurfaceKey::Scallop) {
        return None;
    }
    let kept = facts.motion.as_ref().and_then(|m| m.pieces()).zip(swept);
    let Some((pieces, Swept { path, cutters })) = kept else {
        return Some(Err(format!("the motion has more than {MOST_PIECES} pieces, which are not kept")));
    };
    let Some(design) = design(prepared) else { return Some(Err("the scene has no design part".into())) };
    let windows: Vec<Aabb> = patches.iter().map(|p| *p.window()).collect();
    let region = prepared.scene.file.part.as_ref().and_then(|p| p.judged_box).map(|b| b.aabb());
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
    let bound = |r: &Ridge| design.floor + r.pieces.into_iter().map(deviation).fold(0.0, f64::max);
    let bounds = found.ridges.iter().map(bound).collect();
    Some(Ok(Measured { found, cutters: cutters.clone(), bounds }))
}

impl Measured {
    /// Heights for the map of the surface: at each point the mean of the ridges near it.
    pub(crate) fn map(&self) -> Option<RidgeMap> {
        let spacing = self.found.ridges.iter().filter_map(|r| r.spacing).fold(0.0, f64::max);
        if spacing <= 0.0 {
            return None;
        }
        let [mut measured, mut geometric] = [0, 1].map(|_| Neighbors::new(spacing));
        for r in &self.found.ridges {
            measured.add(&r.point, r.height);
            if let Some(height) = r.geometric {
                geometric.add(&r.point, height);
            }
        }
        Some(RidgeMap { measured, geometric })
    }

    /// `limit_um`: up to which height strips are measured.
    pub(crate) fn figures(&self, facts: &Facts, limit_um: f64) -> Option<Scallop> {
        let ridges = &self.found.ridges;
        let all = heights(ridges)?;
        let known = Known::of(ridges.iter().zip(&self.bounds).map(|(r, b)| (r.height, *b, r.weight)));
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
            (length > 0.0).then(|| UM_PER_MM * both.iter().map(|b| b.2 * of(b)).sum::<f64>() / length)
        };
        let spacings = || ridges.iter().filter_map(|r| r.spacing.map(|s| (s, r.weight)));
        let of_spacings: f64 = spacings().map(|s| s.1).sum();
        let [strip, swept] = self.widths(MM_PER_UM * limit_um);
        let bars = histogram(ridges);
        let bar = |(k, length_mm): (usize, &f64)| {
            let [from_um, to_um] = [k, k + 1].map(|k| UM_PER_MM * (bars.from + k as f64 * bars.width));
            ScallopBar { from_um, to_um, length_mm: *length_mm }
        };
        Some(Scallop {
            bound_um: UM_PER_MM * self.bounds.iter().copied().fold(0.0, f64::max),
            mean_bound_um: UM_PER_MM * known.mean,
            p95_bound_um: UM_PER_MM * known.p95,
            all: ScallopHeights::from(&all),
            geometric_mean_um: mean(|b| b.0),
            difference_mean_um: mean(|b| b.1),
            difference_p95_um: percentile(both.iter().map(|b| (b.1.abs(), b.2))).map(|v| UM_PER_MM * v),
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
            regions: Vec::new(),
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

    /// Smallest width of the strips up to a height above the design: of the standing and of the moving
    /// cutter.
    fn widths(&self, height: f64) -> [Option<f64>; 2] {
        let stride = self.found.ridges.len().div_ceil(WIDTHS).max(1);
        let mut least = [None, None];
        let sided =
            self.found.ridges.iter().step_by(stride).filter_map(|r| Some((r.sides?, r.curvature.unwrap_or(0.0))));
        for (side, curvature) in sided.flat_map(|(sides, curvature)| sides.map(|side| (side, curvature))) {
            let bodies = self.cutters.get(side.cutter as usize).map_or(&[][..], Vec::as_slice);
            let contacts = bodies.iter().filter_map(|b| CutterContact::new(b, side.axis, side.normal, side.feed));
            for contact in contacts {
                let widths =
                    [contact.section_width_over(height, curvature), contact.swept_width_over(height, curvature)];
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

/// How well mean and 95th percentile are known, mm.
///
/// Where each height is off by its own bound at most, both lie between those of the heights less and more by
/// their bounds: each of the two rises when any height does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Known {
    pub(crate) mean: f64,
    pub(crate) p95: f64,
}

impl Known {
    /// From heights with their bounds and weights.
    pub(crate) fn of(heights: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Self {
        let (sum, weight) =
            heights.clone().fold((0.0, 0.0), |(s, w), (_, bound, weight)| (s + bound * weight, w + weight));
        let at = |side: f64| percentile(heights.clone().map(|(height, bound, weight)| (height + side * bound, weight)));
        let p95 = match (at(-1.0), at(0.0), at(1.0)) {
            (Some(low), Some(middle), Some(high)) => (middle - low).max(high - middle),
            _ => 0.0,
        };
        Self { mean: if weight > 0.0 { sum / weight } else { 0.0 }, p95 }
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
pub(crate) fn place(facts: &Facts, piece: u32) -> Option<String> {
    let block = facts.block_of_piece.get(piece as usize)?;
    let (file, line) = facts.places.get(*block as usize)?.as_ref()?;
    Some(format!("{file}:{line}"))
}

/// The blocks on both sides of a ridge, the earlier one first.
pub(crate) fn blocks(facts: &Facts, ridge: &Ridge) -> Vec<String> {
    let mut out: Vec<String> = ridge.pieces.into_iter().filter_map(|p| place(facts, p)).collect();
    out.dedup();
    out
}

impl RidgeMap {
    /// Measured and geometric heights about some points, mm.
    pub(crate) fn at(&self, places: &[Point]) -> Vec<[Option<f64>; 2]> {
        let finite = |v: f64| v.is_finite().then_some(v);
        let both = self.measured.at(places).into_iter().zip(self.geometric.at(places));
        both.map(|(m, g)| [finite(m), finite(g)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_is_known_better_than_its_worst_height() {
        // A hundred heights of 10 to 19.9, all known to 0.1 but one of the low ones, which is known to 5.
        let heights = (0..100).map(|k| (10.0 + 0.1 * f64::from(k), if k == 3 { 5.0 } else { 0.1 }, 1.0));
        let known = Known::of(heights);
        assert!((known.mean - 0.149).abs() < 1e-12, "{known:?}");
        // Shifted up, that one stays below the 95th: both percentiles move by the 0.1 of their own.
        assert!((known.p95 - 0.1).abs() < 1e-9, "{known:?}");
        // Known to 50 it may pass all others, and the percentile moves by one height more.
        let heights = (0..100).map(|k| (10.0 + 0.1 * f64::from(k), if k == 3 { 50.0 } else { 0.1 }, 1.0));
        assert!((Known::of(heights).p95 - 0.2).abs() < 1e-9);
        assert_eq!(Known::of(std::iter::empty()), Known::default());
    }
}
