//! What a tool axis does at a contact: gouge, strip, roughness; which inclinations will do; what is shown of
//! them.

use proveout_geom::{Point, Vector};
use proveout_path::PathCutter;

use super::{
    super::{ContactSurface, Curve, CurveKind, CuttingRun, Figure, Quantity, Study, Surroundings},
    BullNose, ContactFrame, CrossSection, FitResult, MultiScale, UM_PER_MM, critical,
    cross_section::CUTOFF,
    found, leaned,
};

/// Inclinations that are looked at, radian: below the first the face of the tool lies flat.
const LEAST: f64 = 0.5 * std::f64::consts::PI / 180.0;
const MOST: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// A relative curvature below this gouges, 1/mm: rounding.
const GOUGE: f64 = -1e-9;
/// How narrow a bracket about a root is, radian: a thousandth of a second of arc.
const ROOT: f64 = 5e-9;
/// Steps of a bisection over them.
const STEPS: usize = 30;
/// Number of places at which the paper measures; the expected count above the limit refers to it.
const PLACES: f64 = 90.0;
/// Rows farther apart than this many diameters of the cutter are not adjacent.
const BESIDE: f64 = 1.0;
/// How far before its begin the end of an empty interval lies, radian.
const BEFORE: f64 = 1e-9;

/// What an axis does at a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisEffect {
    /// Inclination to the normal, radian.
    pub lean: f64,
    /// Azimuth of the lean from the feed, radian.
    pub side: f64,
    /// Smallest relative curvature of cutter and surface, 1/mm.
    pub critical: f64,
    /// Width of the strip in the section across the feed, and that which the moving tool leaves, mm; none
    /// where the tool is narrower.
    pub strip: [Option<f64>; 2],
    /// Ra across the feed, mm; none without an adjacent row.
    pub roughness: Option<f64>,
    /// The same after a profile filter of 0.8 mm, mm.
    pub filtered: Option<f64>,
}

/// What the rules look at: smallest relative curvature (1/mm), width of the strip and Ra (mm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Measures([f64; 3]);

impl Measures {
    /// The mean of four by their weights.
    pub(in super::super) fn mean(all: [(Self, f64); 4]) -> Self {
        Self(std::array::from_fn(|k| all.iter().map(|(m, weight)| m.0[k] * weight).sum()))
    }
}

/// A contact with its rules.
pub(in super::super) struct Judge {
    pub(super) frame: ContactFrame,
    /// Smallest and largest inclination along the feed, radian; the first above the second where none will
    /// do.
    pub(super) limits: [f64; 2],
    method: MultiScale,
    tool: BullNose,
    section: CrossSection,
    /// Normal curvatures of the surface in the frame, positive as it is convex.
    form: [f64; 3],
    rows: bool,
}

impl Judge {
    /// Whose rules these are.
    pub(super) fn method(&self) -> &MultiScale {
        &self.method
    }

    pub(super) fn new(
        method: &MultiScale,
        tool: BullNose,
        surface: &dyn ContactSurface,
        frame: ContactFrame,
        distance: Option<f64>,
    ) -> Self {
        let curvatures = surface.contact(&frame.point).map(|c| c.curvatures);
        let section = CrossSection::new(surface, &frame, distance.unwrap_or(1.0), method.evaluation_length);
        let mut form = [0.0; 3];
        let mut gouge = Some(LEAST);
        if let Some([(large, _), (small, hollow)]) = curvatures {
            for (k, direction) in [(large, frame.axes[2].cross(&hollow)), (small, hollow)] {
                let (x, y) = (direction.dot(&frame.axes[0]), direction.dot(&frame.axes[1]));
                form[0] += k * x * x;
                form[1] += k * x * y;
                form[2] += k * y * y;
            }
            let gamma = hollow.cross(&frame.axes[0]).dot(&frame.axes[2]).atan2(hollow.dot(&frame.axes[0]));
            gouge = tool.least_lean([-small, -large], gamma);
        }
        let mut judge =
            Self { frame, limits: [0.0; 2], method: *method, tool, section, form, rows: distance.is_some() };
        judge.limits = gouge.map_or([MOST, LEAST], |g| judge.interval(g.max(LEAST)));
        judge
    }

    fn interval(&self, gouge: f64) -> [f64; 2] {
        let [narrow, wide] = self.method.strip;
        let width = |lean: f64| self.width(&leaned(lean, 0.0)).unwrap_or(f64::INFINITY);
        // The strip falls with the inclination.
        let low = crossing([gouge, MOST], |lean| width(lean) <= wide);
        let high = crossing([low, MOST], |lean| width(lean) < narrow);
        if self.method.roughness == 0.0 || !self.rows {
            return [low, high];
        }
        let rough = |lean: f64| self.section.roughness(&self.tool, &leaned(lean, 0.0)) - self.method.roughness;
        let at = [rough(low), rough(high)];
        if at[0] > 0.0 {
            let least = rough(LEAST);
            let up_to = if least > 0.0 { LEAST } else { root([LEAST, low], [least, at[0]], ROOT, rough) };
            return [low, up_to.min(low - BEFORE)];
        }
        [low, if at[1] > 0.0 { root([low, high], at, ROOT, rough) } else { high }]
    }

    fn width(&self, t: &Vector) -> Option<f64> {
        let [left, right] = self.tool.strip(t, &|y| self.section.height(y), self.method.strip_height)?;
        Some(left + right)
    }

    /// Inclination of an axis of the run, radian.
    pub(super) fn lean(&self, axis: &Vector) -> f64 {
        let t = self.frame.local(axis);
        t.x.hypot(t.y).atan2(t.z)
    }

    /// What the rules look at with an axis of the run; none where it leans below the face, the tool is
    /// narrower than the height of the strip, or the strip is past its limits by more than a part of them.
    pub(in super::super) fn measures(&self, axis: &Vector, far: f64) -> Option<Measures> {
        let t = self.frame.local(axis);
        if t.z <= 0.0 {
            return None;
        }
        let width = self.width(&t)?;
        let [narrow, wide] = self.method.strip;
        if width > wide * (1.0 + far) || width < narrow * (1.0 - far) {
            return None;
        }
        let ruled = self.rows && self.method.roughness > 0.0;
        let roughness = if ruled { self.section.roughness(&self.tool, &t) } else { 0.0 };
        Some(Measures([critical(self.tool.form(&t), self.form), width, roughness]))
    }

    /// How far an axis of the run is past a rule, as a part of its limit; zero or less where it keeps all.
    pub(super) fn excess(&self, axis: &Vector) -> f64 {
        self.measures(axis, f64::INFINITY).map_or(1.0, |m| self.excess_of(&m))
    }

    /// The same of what was measured.
    pub(in super::super) fn excess_of(&self, &Measures([gouge, width, roughness]): &Measures) -> f64 {
        if gouge < GOUGE {
            return 1.0 + gouge.abs();
        }
        let [narrow, wide] = self.method.strip;
        let excess = ((width - wide) / wide).max((narrow - width) / narrow);
        if self.rows && self.method.roughness > 0.0 {
            return excess.max((roughness - self.method.roughness) / self.method.roughness);
        }
        excess
    }

    /// Whether an axis of the run keeps all rules, their limits taken narrower by a part of them:
    /// [`Self::excess`] without what a rule that is broken makes needless.
    pub(in super::super) fn keeps(&self, axis: &Vector, margin: f64) -> bool {
        let t = self.frame.local(axis);
        let [narrow, wide] = self.method.strip;
        if t.z <= 0.0 || critical(self.tool.form(&t), self.form) < GOUGE {
            return false;
        }
        let Some(width) = self.width(&t) else { return false };
        if width > wide * (1.0 - margin) || width < narrow * (1.0 + margin) {
            return false;
        }
        let limit = self.method.roughness;
        !self.rows || limit == 0.0 || self.section.roughness(&self.tool, &t) <= limit * (1.0 - margin)
    }

    /// What an axis does, in the frame of the contact.
    pub(super) fn judged(&self, t: &Vector) -> AxisEffect {
        let height = |y: f64| self.section.height(y);
        let swept = self.tool.swept_strip(t, &height, self.method.strip_height);
        AxisEffect {
            lean: t.x.hypot(t.y).atan2(t.z),
            side: t.y.atan2(t.x),
            critical: critical(self.tool.form(t), self.form),
            strip: [self.width(t), swept.map(|[l, r]| l + r)],
            roughness: self.rows.then(|| self.section.roughness(&self.tool, t)),
            filtered: self.rows.then(|| self.section.filtered_roughness(&self.tool, t, CUTOFF)),
        }
    }
}

/// The smallest inclination from which on a rule that turns true once is true; the upper end where it never
/// is.
fn crossing([from, to]: [f64; 2], rule: impl Fn(f64) -> bool) -> f64 {
    if rule(from) {
        return from;
    }
    if !rule(to) {
        return to;
    }
    let (mut low, mut high) = (from, to);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if rule(middle) { high = middle } else { low = middle }
    }
    high
}

/// Where a function that rises through zero between two places, with its values there, has its root, from
/// below, within `close`: the Illinois rule.
pub(super) fn root([mut a, mut b]: [f64; 2], [mut fa, mut fb]: [f64; 2], close: f64, f: impl Fn(f64) -> f64) -> f64 {
    let mut kept = 0;
    for _ in 0..60 {
        if b - a < close {
            break;
        }
        // Within the bracket, so that a flat function ends as well.
        let c = ((a * fb - b * fa) / (fb - fa)).clamp(a + 0.25 * close, b - 0.25 * close);
        let fc = f(c);
        if fc > 0.0 {
            (b, fb) = (c, fc);
            fa *= if kept == 1 { 0.5 } else { 1.0 };
            kept = 1;
        } else {
            (a, fa) = (c, fc);
            fb *= if kept == -1 { 0.5 } else { 1.0 };
            kept = -1;
        }
    }
    a
}

/// Distance on the surface from each contact to the adjacent rows, the larger one of both sides,
/// mm; none where there is no row.
pub(super) fn row_distances(
    frames: &[ContactFrame],
    around: &Surroundings<'_>,
    cutter: &PathCutter,
) -> Vec<Option<f64>> {
    let far = BESIDE * 2.0 * cutter.profile().max_radius();
    let Some(middle) = frames.get(frames.len() / 2) else { return Vec::new() };
    let mut beside: [Option<(f64, &CuttingRun)>; 2] = [None; 2];
    for (_, run) in around.rows.iter().enumerate().filter(|(k, _)| *k != around.row) {
        // Tips are offset from their contacts by the same amount in neighboring rows.
        let near = run.blocks.iter().filter_map(|b| {
            let contact = around.surface?.contact(&b.pose.tip)?.point;
            let way = frames_local(middle, &contact);
            Some((way.norm(), way.y))
        });
        let Some((distance, y)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        let side = usize::from(y < 0.0);
        if distance < far && beside[side].is_none_or(|(least, _)| distance < least) {
            beside[side] = Some((distance, run));
        }
    }
    let rows: Vec<Vec<Point>> = beside
        .into_iter()
        .flatten()
        .map(|(_, run)| found(run, cutter, around).into_iter().flatten().map(|t| t.place.point).collect())
        .collect();
    frames
        .iter()
        .map(|f| rows.iter().filter_map(|row| nearest(row, f)).filter(|d| *d < far).max_by(f64::total_cmp))
        .collect()
}

fn frames_local(frame: &ContactFrame, p: &Point) -> Vector {
    frame.local(&(p - frame.point))
}

/// Distance of a contact from a row across the feed, mm.
fn nearest(row: &[Point], frame: &ContactFrame) -> Option<f64> {
    let to = |pair: &[Point]| {
        let way = pair[1] - pair[0];
        let square = way.norm_squared();
        let t = if square > 0.0 { ((frame.point - pair[0]).dot(&way) / square).clamp(0.0, 1.0) } else { 0.0 };
        frame.local(&(pair[0] + way * t - frame.point))
    };
    // Beyond the end of a row the way along the feed does not count.
    row.windows(2).map(to).min_by(|a, b| a.norm().total_cmp(&b.norm())).map(|way| way.y.hypot(way.z))
}

/// What the rules say of the axes of a row before and after, of the contacts that are judged.
pub(in super::super) fn ruled_figures(
    method: &MultiScale,
    judged: &[bool],
    [before, after]: [&[AxisEffect]; 2],
) -> Vec<Figure> {
    let inside = |of: fn(&AxisEffect) -> Option<f64>, all: &[AxisEffect]| -> Vec<f64> {
        all.iter().zip(judged).filter(|(_, judged)| **judged).filter_map(|(j, _)| of(j)).collect()
    };
    let most = |v: &[f64]| v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = |v: &[f64]| v.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let figure = |name, unit, value: f64| Figure { name, unit, value };
    let section: fn(&AxisEffect) -> Option<f64> = |j| j.strip[0];
    let swept: fn(&AxisEffect) -> Option<f64> = |j| j.strip[1];
    let mut figures = vec![
        figure("largest lean to a side", "deg", most(&inside(|j| Some(j.side.abs().to_degrees()), after))),
        figure("narrowest strip", "mm", least(&inside(section, after))),
        figure("widest strip", "mm", most(&inside(section, after))),
        figure("widest strip of the moving tool", "mm", most(&inside(swept, after))),
    ];
    type Named = (fn(&AxisEffect) -> Option<f64>, [&'static str; 4]);
    let of: [Named; 2] = [
        (
            |j| Some(UM_PER_MM * j.roughness?),
            [
                "largest Ra across the feed before",
                "largest Ra across the feed",
                "mean Ra across the feed before",
                "mean Ra across the feed",
            ],
        ),
        (
            |j| Some(UM_PER_MM * j.filtered?),
            [
                "largest Ra across the feed before, filtered at 0.8 mm",
                "largest Ra across the feed, filtered at 0.8 mm",
                "mean Ra across the feed before, filtered at 0.8 mm",
                "mean Ra across the feed, filtered at 0.8 mm",
            ],
        ),
    ];
    for (of, [most_before, most_after, mean_before, mean_after]) in of {
        let (old, new) = (inside(of, before), inside(of, after));
        if !new.is_empty() {
            figures.extend([
                figure(most_before, "um", most(&old)),
                figure(most_after, "um", most(&new)),
                figure(mean_before, "um", mean(&old)),
                figure(mean_after, "um", mean(&new)),
            ]);
        }
    }
    let rough: fn(&AxisEffect) -> Option<f64> = |j| j.roughness;
    let (old, new) = (inside(rough, before), inside(rough, after));
    if !new.is_empty() {
        let less = 100.0 * (1.0 - mean(&new) / mean(&old));
        figures.push(figure("mean Ra across the feed less than before", "%", less));
    }
    if let Some(measurement) = method.measurement.filter(|_| method.roughness > 0.0 && !new.is_empty()) {
        let places = |v: &[f64]| {
            let above: Vec<f64> = v.iter().map(|ra| measurement.above(*ra, method.roughness)).collect();
            // A count: whole places.
            (PLACES * mean(&above)).round()
        };
        figures.extend([
            figure("places of 90 measured above the limit before", "", places(&old)),
            figure("places of 90 measured above the limit", "", places(&new)),
        ]);
    }
    figures
}

/// Curves and figures of a row.
pub(super) fn study(
    method: &MultiScale,
    (arc, judges): (&[f64], &[Judge]),
    [before, after]: [&[AxisEffect]; 2],
    done: &FitResult,
) -> Study {
    let curve = |name, kind, quantity: Quantity, values: &mut dyn Iterator<Item = Option<f64>>| Curve {
        name,
        kind,
        axes: [Quantity { name: "path length of the contact", unit: "mm" }, quantity],
        points: arc.iter().zip(values).filter_map(|(s, v)| Some([*s, v?])).collect(),
    };
    let lean = Quantity { name: "inclination to the normal", unit: "deg" };
    let strip = Quantity { name: "width of the strip in its section", unit: "mm" };
    let rough = Quantity { name: "Ra across the feed", unit: "um" };
    let degrees = |j: &AxisEffect| Some(j.lean.to_degrees());
    let micro = |j: &AxisEffect| Some(UM_PER_MM * j.roughness?);
    let limit = |k: usize| judges.iter().map(move |j| Some(j.limits[k].to_degrees()));
    let figure = |name, unit, value: f64| Figure { name, unit, value };
    let fixed = done.fixed.iter().map(|&i| [arc[i], after[i].lean.to_degrees()]).collect();
    let section: fn(&AxisEffect) -> Option<f64> = |j| j.strip[0];
    let mut figures = vec![
        figure("fixed contacts", "", done.fixed.len() as f64),
        figure("coefficients of a curve", "", done.coefficients as f64),
        figure("rounds", "", done.rounds as f64),
        figure("contacts of the run-in, not judged", "", done.judged.iter().filter(|j| !**j).count() as f64),
    ];
    figures.extend(ruled_figures(method, &done.judged, [before, after]));
    Study {
        curves: vec![
            curve("least inclination", CurveKind::Limit, lean, &mut limit(0)),
            curve("largest inclination", CurveKind::Limit, lean, &mut limit(1)),
            curve("original", CurveKind::Original, lean, &mut before.iter().map(degrees)),
            curve("new", CurveKind::Result, lean, &mut after.iter().map(degrees)),
            Curve {
                name: "fixed contacts",
                kind: CurveKind::KeyPoints,
                axes: [Quantity { name: "path length of the contact", unit: "mm" }, lean],
                points: fixed,
            },
            curve("original", CurveKind::Original, strip, &mut before.iter().map(section)),
            curve("new", CurveKind::Result, strip, &mut after.iter().map(section)),
            curve("original", CurveKind::Original, rough, &mut before.iter().map(micro)),
            curve("new", CurveKind::Result, rough, &mut after.iter().map(micro)),
        ],
        figures,
        ..Study::default()
    }
}
