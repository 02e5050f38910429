use serde::Serialize;

use super::{AREAL_FILTER, AREAL_STANDARD, Asked, Form, PITCH_SLACK, REGRESSION, Unchecked};
use crate::texture::{
    ArealParameters, Autocorrelation, DECIMALS, HeightMap, ProfileParameters, SettingClass, UM_PER_MM,
    gaussian_mean_of_map, lay, spacing,
};

/// A map wants this many points within a cut-off at least. Chosen: the Gaussian filter is then off its
/// equation by less than 1e-6.
const POINTS_IN_CUTOFF: f64 = 8.0;

/// Parameters of an area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ArealValues {
    /// Arithmetical mean height, um.
    pub sa_um: f64,
    /// Root mean square height, um.
    pub sq_um: f64,
    /// Maximum peak height, um.
    pub sp_um: f64,
    /// Maximum pit depth, um.
    pub sv_um: f64,
    /// Maximum height, um.
    pub sz_um: f64,
    /// Skewness.
    pub ssk: f64,
    /// Kurtosis.
    pub sku: f64,
    /// Root mean square gradient.
    pub sdq: f64,
    /// Developed interfacial area ratio, percent.
    pub sdr_percent: f64,
    /// Autocorrelation length, mm; null on a flat.
    pub sal_mm: Option<f64>,
    /// Texture aspect ratio; null where the marks are longer than the patch.
    pub str: Option<f64>,
    /// Texture direction, degrees from the x direction of the map: along the marks; null on a flat.
    pub std_deg: Option<f64>,
}

impl ArealValues {
    fn of(map: &HeightMap) -> Self {
        let p: ArealParameters = map.parameters();
        let (lengths, direction) = rayon::join(|| Autocorrelation::of(map), || lay(map));
        Self {
            sa_um: UM_PER_MM * p.sa,
            sq_um: UM_PER_MM * p.sq,
            sp_um: UM_PER_MM * p.sp,
            sv_um: UM_PER_MM * p.sv,
            sz_um: UM_PER_MM * p.sz,
            ssk: p.ssk,
            sku: p.sku,
            sdq: p.sdq,
            sdr_percent: 100.0 * p.sdr,
            sal_mm: lengths.sal,
            str: lengths.str,
            std_deg: direction.map(f64::to_degrees),
        }
    }
}

/// An area, filtered and not, with all that the values depend on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArealReport {
    /// Definitions of the parameters: number and edition.
    pub standard: &'static str,
    /// Filter: number, edition, kind.
    pub filter_standard: &'static str,
    /// Class whose cut-off is the L-filter.
    pub class: &'static str,
    /// Class that was asked for.
    pub class_asked: &'static str,
    /// Nesting index of the S-filter, um; null when it was left out.
    pub s_filter_um: Option<f64>,
    /// Why the S-filter was used or left out.
    pub s_filter: String,
    /// Nesting index of the L-filter, mm.
    pub l_filter_mm: f64,
    /// How the form was removed.
    pub form_removal: &'static str,
    /// Rule for the ends of the filters.
    pub end_rule: &'static str,
    /// Spacing along x and y, um.
    pub spacing_um: [f64; 2],
    /// Evaluation area along x and y, mm.
    pub evaluation_area_mm: [f64; 2],
    /// Points along x and y.
    pub points: [usize; 2],
    /// Direction of the lay, degrees from the x direction of the map, to half a degree; null on a flat.
    pub lay_deg: Option<f64>,
    /// Pitch of the marks across the lay, mm: the larger one of what was known and of `RSm` of the map's
    /// lines.
    pub pitch_mm: Option<f64>,
    /// Values of the filtered map; null when unchecked.
    pub filtered: Option<ArealValues>,
    /// Values of the map as it is, its mean and form taken off.
    pub unfiltered: ArealValues,
    /// Why there are no filtered values; empty when there are.
    pub unchecked: Vec<Unchecked>,
    /// What a reader should know in addition to the values.
    pub remarks: Vec<String>,
    /// The filtered map; none when unchecked.
    #[serde(skip)]
    pub roughness: Option<HeightMap>,
}

impl ArealReport {
    /// Evaluates a map. Never fails: what cannot be evaluated is in `unchecked`.
    pub fn of(map: &HeightMap, asked: &Asked) -> Self {
        let leveled = (asked.form == Form::Level).then(|| map.leveled());
        let map = leveled.as_ref().unwrap_or(map);
        let unfiltered = ArealValues::of(map);
        let (mut class, mut unchecked, mut remarks) = (asked.class, Vec::new(), Vec::new());
        let mut pitch = asked.pitch.filter(|p| p.is_finite() && *p > 0.0);
        let beyond = |pitch_mm: f64, next: Option<SettingClass>| Unchecked::PitchBeyondCutoff {
            pitch_mm,
            lambda_c_mm: asked.class.lambda_c(),
            class: asked.class.name(),
            next: next.map(SettingClass::name),
        };
        let found = loop {
            if let Some(known) = pitch.filter(|p| *p > class.lambda_c() * (1.0 + DECIMALS)) {
                let Some(next) = SettingClass::for_pitch(known) else {
                    unchecked = vec![beyond(known, None)];
                    break None;
                };
                class = next;
            }
            let filtered = match filter(map, class) {
                Ok(filtered) => filtered,
                Err(reason) => {
                    if class != asked.class {
                        unchecked.push(beyond(pitch.unwrap_or(asked.class.lambda_c()), Some(class)));
                    }
                    unchecked.push(reason);
                    break None;
                }
            };
            let values = ArealValues::of(&filtered);
            let seen = across(&filtered, values.std_deg, class.lambda_c());
            match seen.filter(|p| *p > class.lambda_c() * (1.0 + PITCH_SLACK)) {
                None => {
                    pitch = pitch.into_iter().chain(seen).reduce(f64::max);
                    break Some((filtered, values));
                }
                Some(seen) => {
                    pitch = Some(pitch.unwrap_or(0.0).max(seen));
                    let Some(next) = SettingClass::for_pitch(seen).filter(|n| *n > class) else {
                        unchecked = vec![beyond(seen, None)];
                        break None;
                    };
                    class = next;
                }
            }
        };
        if found.is_some() && class != asked.class {
            remarks.push(format!(
                "the pitch of {:.4} mm lies beyond lambda_c = {} mm of class {}, which was asked for: class {} is \
                 used",
                pitch.unwrap_or_default(),
                asked.class.lambda_c(),
                asked.class.name(),
                class.name()
            ));
        }
        if found.is_none() {
            class = asked.class;
        }
        let carried = carries_s(map, class);
        let s_filter = if found.is_none() {
            "nothing was filtered".to_owned()
        } else if carried {
            "used: the spacing carries it".to_owned()
        } else {
            remarks.push(format!(
                "points every {:.4} µm carry no profile parameters of class {}, which needs {} µm: take profiles of their own",
                UM_PER_MM * map.step_x().max(map.step_y()),
                class.name(),
                UM_PER_MM * class.max_spacing()
            ));
            format!("left out: {} µm are not carried by this spacing", UM_PER_MM * class.lambda_s())
        };
        let lay_deg = found.as_ref().map_or(unfiltered.std_deg, |(_, v)| v.std_deg);
        Self {
            standard: AREAL_STANDARD,
            filter_standard: AREAL_FILTER,
            class: class.name(),
            class_asked: asked.class.name(),
            s_filter_um: (found.is_some() && carried).then(|| UM_PER_MM * class.lambda_s()),
            s_filter,
            l_filter_mm: class.lambda_c(),
            form_removal: asked.form.of_map(),
            end_rule: if found.is_some() { REGRESSION } else { "nothing was filtered" },
            spacing_um: [UM_PER_MM * map.step_x(), UM_PER_MM * map.step_y()],
            evaluation_area_mm: map.size(),
            points: [map.columns(), map.rows()],
            lay_deg,
            pitch_mm: pitch,
            filtered: found.as_ref().map(|(_, values)| *values),
            unfiltered,
            unchecked,
            remarks,
            roughness: found.map(|(map, _)| map),
        }
    }
}

fn carries_s(map: &HeightMap, class: SettingClass) -> bool {
    map.step_x().max(map.step_y()) <= class.max_spacing() * (1.0 + DECIMALS)
}

/// S-filter where the spacing carries it, then L-filter.
fn filter(map: &HeightMap, class: SettingClass) -> Result<HeightMap, Unchecked> {
    let (cutoff, [x, y]) = (class.lambda_c(), map.size());
    if cutoff > x.min(y) * (1.0 + DECIMALS) {
        return Err(Unchecked::CutoffBeyondPatch { cutoff_mm: cutoff, class: class.name(), x_mm: x, y_mm: y });
    }
    let (coarse, fine) = (map.step_x().max(map.step_y()), map.step_x().min(map.step_y()));
    let limit = cutoff / POINTS_IN_CUTOFF;
    if coarse > limit * (1.0 + DECIMALS) {
        return Err(Unchecked::TooCoarse {
            spacing_um: UM_PER_MM * coarse,
            limit_um: UM_PER_MM * limit,
            class: class.name(),
        });
    }
    let finest = 0.05 * class.max_spacing();
    if fine < finest * (1.0 - DECIMALS) {
        return Err(Unchecked::TooFine {
            spacing_um: UM_PER_MM * fine,
            limit_um: UM_PER_MM * finest,
            class: class.name(),
        });
    }
    let smooth = if carries_s(map, class) { gaussian_mean_of_map(map, class.lambda_s()) } else { map.clone() };
    Ok(smooth.minus(&gaussian_mean_of_map(&smooth, cutoff)))
}

/// Pitch across the lay, mm: the median `RSm` of the lines along that direction of the map which crosses the
/// marks more squarely, times the sine of its angle to them. Where most lines have heights and no element,
/// the pitch is at least half of their length: that, if it lies beyond the cut-off.
fn across(map: &HeightMap, lay_deg: Option<f64>, cutoff: f64) -> Option<f64> {
    let (sin, cos) = lay_deg?.to_radians().sin_cos();
    let along_x = sin.abs() >= cos.abs();
    let (lines, step) = if along_x { (map.rows(), map.step_x()) } else { (map.columns(), map.step_y()) };
    let mut found = Vec::with_capacity(lines);
    for k in 0..lines {
        let line: Vec<f64> = if along_x {
            (0..map.columns()).map(|i| map.at(i, k)).collect()
        } else {
            (0..map.rows()).map(|j| map.at(k, j)).collect()
        };
        let mean = line.iter().sum::<f64>() / line.len() as f64;
        let line: Vec<f64> = line.iter().map(|z| z - mean).collect();
        let p = ProfileParameters::of(&line, step, crate::texture::Standard::Iso21920);
        if p.rt > spacing::FLAT {
            found.push(p.rsm.unwrap_or(f64::INFINITY));
        }
    }
    found.sort_by(f64::total_cmp);
    let median = found.get(found.len() / 2)?;
    let square = sin.abs().max(cos.abs());
    if median.is_finite() {
        return Some(median * square);
    }
    let half = 0.5 * map.size()[usize::from(!along_x)] * square;
    (half > cutoff * (1.0 + PITCH_SLACK)).then_some(half)
}
