//! The scallop against `[tolerances] scallop_um`, of the whole surface and of regions.
//!
//! The 95th percentile of the heights of ridges, by length, is judged among the ridges that have
//! one bound: with `e` how far it may be off (by the design's own error, and the deviation of the
//! pieces of motion from the path), more than the limit plus `e` fails, up to the limit less `e`
//! passes, and between the two it is undecided.

use proveout_surface::scallop::{Heights, Ridge, by_patch, heights};

use crate::{
    cut::engine::Facts,
    judge::{
        scallop::{Known, Measured, PATCH_MM, blocks},
        surface_gate::Judgement,
    },
    prepare::prepared::Prepared,
    scene::tolerance::{Limit, SurfaceKey, Tolerances},
    units::UM_PER_MM,
    verdict::{
        finding,
        log::FindingLog,
        scallop_figures::{Scallop, ScallopHeights, ScallopRegion},
        verdict_file::{State, Surface},
    },
};

const KEY: SurfaceKey = SurfaceKey::Scallop;
/// Part of the ridges that may be unknown.
const UNKNOWN: f64 = 0.01;

/// Judges what was measured, and fills in what the verdict says of it.
pub(crate) fn judge(
    prepared: &Prepared,
    facts: &Facts,
    measured: Option<&Result<Measured, String>>,
    surface: &mut Surface,
    log: &mut FindingLog,
) -> Option<Judgement> {
    let tolerances = &prepared.scene.file.tolerances;
    let limits = tolerances.limits(KEY);
    let narrowest = limits.iter().map(|l| l.um).reduce(f64::min)?;
    let judgement = |state, reason: String| Some(Judgement { key: KEY.word(), state, reason });
    let measured = match measured? {
        Ok(measured) => measured,
        Err(reason) => return judgement(State::Unchecked, reason.clone()),
    };
    let Some(mut figures) = measured.figures(facts, narrowest) else {
        let lost = match measured.found.not_followed {
            0 => "passes closer than two cells have none between the rays",
            _ => "the motion that made them is not known",
        };
        let reason = format!("no ridge between two passes was found on the judged surface: {lost}");
        return judgement(State::Unchecked, reason);
    };
    let all = figures.all.clone();
    (surface.scallop_max_um, surface.scallop_mean_um, surface.scallop_p95_um) =
        (Some(all.max_um), Some(all.mean_um), Some(all.p95_um));
    let mut groups: Vec<Group<'_>> =
        limits.iter().map(|limit| Group::new(tolerances, *limit, measured, &figures, limits.len() > 1)).collect();
    // Regions may cover all that is judged.
    groups.retain(|g| g.heights.is_some() || g.limit.region.is_some());
    if limits.iter().any(|l| l.region.is_some()) {
        figures.regions = groups.iter().map(Group::figures).collect();
    }
    surface.scallop = Some(figures);
    let judged: Vec<(State, String)> = groups.iter().map(|group| group.judge(facts, log)).collect();
    let states = judged.iter().map(|t| t.0);
    let state = if states.clone().any(|s| s == State::Fail) {
        State::Fail
    } else if states.clone().any(|s| s == State::Unchecked) {
        State::Unchecked
    } else {
        State::Pass
    };
    let decide = judged.iter().filter(|t| t.0 == state).chain(judged.iter().filter(|t| t.0 != state));
    let text = decide.map(|t| t.1.as_str()).collect::<Vec<_>>().join("; ");
    if state != State::Pass {
        return judgement(state, text);
    }
    // A pass must have seen all of it.
    let lost = measured.found.not_followed as f64;
    if lost > UNKNOWN * (lost + all.places as f64) {
        let reason = format!("{text}; {lost} more places lie on surfaces that no motion of this run has swept");
        return judgement(State::Unchecked, reason);
    }
    if measured.found.narrow > UNKNOWN * all.length_mm {
        let reason = format!(
            "{text}; {:.1} mm of ridges are closer to their neighbor than two cells, where others may be missed: use finer cells \
             or a [[stock.patch]]",
            measured.found.narrow
        );
        return judgement(State::Unchecked, reason);
    }
    judgement(state, text)
}

/// The ridges that have one bound.
struct Group<'a> {
    name: Option<&'a str>,
    limit: Limit,
    ridges: Vec<Ridge>,
    heights: Option<Heights>,
    known: Known,
    /// Words on the geometric heights; once for all.
    difference: String,
    /// There are others.
    among: bool,
}

impl<'a> Group<'a> {
    fn new(tolerances: &'a Tolerances, limit: Limit, measured: &Measured, figures: &Scallop, among: bool) -> Self {
        let own = measured.found.ridges.iter().zip(&measured.bounds);
        let own = own.filter(|(r, _)| tolerances.limit(KEY, &r.point) == Some(limit));
        let (ridges, bounds): (Vec<Ridge>, Vec<f64>) = own.map(|(r, b)| (*r, *b)).unzip();
        let known = Known::of(ridges.iter().zip(&bounds).map(|(r, b)| (r.height, *b, r.weight)));
        let difference = match (figures.geometric_mean_um, figures.difference_p95_um) {
            (Some(mean), Some(apart)) if !among => {
                format!("; the geometry of the contacts gives {mean:.3} um, within {apart:.3} um")
            }
            (None, _) if ridges.iter().any(|r| r.on_flat) => {
                "; the cutter touches with a flat, so that no contact gives a height or a distance of the passes"
                    .to_owned()
            }
            _ => String::new(),
        };
        Self {
            name: tolerances.region_name(&limit),
            limit,
            heights: heights(&ridges),
            ridges,
            known,
            difference,
            among,
        }
    }

    fn figures(&self) -> ScallopRegion {
        ScallopRegion {
            name: self.name.map(str::to_owned),
            limit_um: self.limit.um,
            heights: self.heights.as_ref().map(ScallopHeights::from),
        }
    }

    fn judge(&self, facts: &Facts, log: &mut FindingLog) -> (State, String) {
        let begin = match self.name {
            Some(name) => format!("region {name:?}: "),
            None if self.among => "elsewhere: ".into(),
            None => String::new(),
        };
        let Some(of) = self.heights.as_ref().map(ScallopHeights::from) else {
            return (State::Unchecked, format!("{begin}no ridge between two passes was found there"));
        };
        let (bound, limit, difference) = (UM_PER_MM * self.known.p95, self.limit.um, &self.difference);
        let patches = by_patch(&self.ridges, PATCH_MM);
        let worst = patches.first().map(|p| (&self.ridges[p.heights.highest], UM_PER_MM * p.heights.p95));
        let place = worst.map_or_else(String::new, |(ridge, p95)| {
            let made = blocks(facts, ridge);
            let made = if made.is_empty() { String::new() } else { format!(", cut by {}", made.join(" and ")) };
            let [x, y, z]: [f64; 3] = ridge.point.coords.into();
            format!("; worst in the patch at X{x:.3} Y{y:.3} Z{z:.3} with {p95:.3} um{made}")
        });
        let text = format!(
            "{begin}95th percentile {:.3} um (known to {bound:.3} um) at {} places on {:.1} mm of ridges, mean {:.3} um, allowed {limit} \
             um{difference}{place}",
            of.p95_um, of.places, of.length_mm, of.mean_um
        );
        if of.p95_um - bound > limit {
            log.push(self.finding(facts, &of, &text, worst.map(|w| w.0)));
            return (State::Fail, text);
        }
        if of.p95_um + bound > limit {
            let help = "a design with a smaller chord error, or a smaller path tolerance, decides it";
            return (State::Unchecked, format!("{text}; the limit lies within the error: {help}"));
        }
        (State::Pass, text)
    }

    fn finding(&self, facts: &Facts, of: &ScallopHeights, text: &str, highest: Option<&Ridge>) -> finding::Finding {
        let mut f = FindingLog::of(&finding::SCALLOP, format!("scallop: {text}"));
        (f.value, f.limit, f.unit) = (Some(of.p95_um), Some(self.limit.um), Some("um".into()));
        f.point_mm = highest.map(|r| r.point.coords.into());
        let piece = highest.map(|r| r.pieces[1] as usize);
        f.block = piece.and_then(|p| facts.block_of_piece.get(p)).copied();
        if let Some((file, line)) = f.block.and_then(|b| facts.places.get(b as usize)).and_then(Option::as_ref) {
            (f.file, f.line) = (Some(file.to_string()), Some(*line));
        }
        f
    }
}
