use serde::Serialize;

use super::{Asked, DATA_BEYOND, Form, PITCH_SLACK, PROFILE_FILTER, REGRESSION, Unchecked, next_class};
use crate::texture::{
    DECIMALS, Profile, ProfileEvaluation, ProfileParameters, SettingClass, UM_PER_MM, profile::ProfileEnds, spacing,
};

/// Points closer than this share of the largest spacing of the class are not filtered: the work grows with
/// the square of their number (some 10^10 products at this limit).
const FINEST: f64 = 0.05;

/// Parameters of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProfileValues {
    /// Arithmetic mean height, um.
    pub ra_um: f64,
    /// Root mean square height, um.
    pub rq_um: f64,
    /// Mean peak height of the sections, um.
    pub rp_um: f64,
    /// Mean pit depth of the sections, um.
    pub rv_um: f64,
    /// Maximum height, mean of the sections, um.
    pub rz_um: f64,
    /// Total height over the evaluation length, um.
    pub rt_um: f64,
    /// Skewness.
    pub rsk: f64,
    /// Kurtosis.
    pub rku: f64,
    /// Mean spacing of the elements, mm; null where there is no element.
    pub rsm_mm: Option<f64>,
}

impl From<&ProfileParameters> for ProfileValues {
    fn from(p: &ProfileParameters) -> Self {
        Self {
            ra_um: UM_PER_MM * p.ra,
            rq_um: UM_PER_MM * p.rq,
            rp_um: UM_PER_MM * p.rp,
            rv_um: UM_PER_MM * p.rv,
            rz_um: UM_PER_MM * p.rz,
            rt_um: UM_PER_MM * p.rt,
            rsk: p.rsk,
            rku: p.rku,
            rsm_mm: p.rsm,
        }
    }
}

/// A profile, filtered and not, with all that the values depend on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileReport {
    /// Definitions of the parameters: number and edition.
    pub standard: &'static str,
    /// Where the class comes from: number and edition.
    pub class_standard: &'static str,
    /// Filter: number, edition, kind.
    pub filter_standard: &'static str,
    /// Rule for tolerances that this standard takes by default.
    pub tolerance_rule: &'static str,
    /// Setting class of the filtered values.
    pub class: &'static str,
    /// Setting class that was asked for.
    pub class_asked: &'static str,
    /// Nesting index of the S-filter, um.
    pub lambda_s_um: f64,
    /// Nesting index of the L-filter, mm.
    pub lambda_c_mm: f64,
    /// Evaluation length, mm.
    pub evaluation_length_mm: f64,
    /// Sections in it.
    pub sections: usize,
    /// Largest spacing that the class allows, um.
    pub spacing_limit_um: f64,
    /// Spacing of the points, um.
    pub spacing_um: f64,
    /// Length of the data, mm.
    pub length_mm: f64,
    /// How the form was removed.
    pub form_removal: &'static str,
    /// Rule for the ends of the filter.
    pub end_rule: &'static str,
    /// What counts as an element of `RSm`.
    pub rsm_rule: &'static str,
    /// Direction to the lay, degrees: 0 along, 90 across; null where it is not known.
    pub direction_to_lay_deg: Option<f64>,
    /// The same in words.
    pub direction_to_lay: &'static str,
    /// Pitch that decided on the class, mm: the larger one of what was known and of `RSm`.
    pub pitch_mm: Option<f64>,
    /// Values of the roughness profile; null when unchecked.
    pub filtered: Option<ProfileValues>,
    /// Values of the same stretch (of all data when unchecked) with its mean taken off, and its form.
    pub unfiltered: ProfileValues,
    /// Length that the unfiltered values are taken over, mm.
    pub unfiltered_length_mm: f64,
    /// Why there are no filtered values; empty when there are.
    pub unchecked: Vec<Unchecked>,
    /// What a reader should know in addition to the values.
    pub remarks: Vec<String>,
    /// The roughness profile over the evaluation length, mm; empty when unchecked.
    #[serde(skip)]
    pub roughness: Vec<f64>,
}

/// Direction to the lay in words.
fn direction(degrees: Option<f64>) -> &'static str {
    match degrees.map(|d| d.rem_euclid(180.0)) {
        None => "not known",
        Some(d) if (80.0..=100.0).contains(&d) => "across the lay",
        Some(d) if !(10.0..=170.0).contains(&d) => "along the lay",
        Some(_) => "oblique to the lay",
    }
}

impl ProfileReport {
    /// Evaluates a profile. Never fails: what cannot be evaluated is in `unchecked`.
    pub fn of(profile: &Profile, asked: &Asked) -> Self {
        let profile = match asked.form {
            Form::Level => &profile.leveled(),
            Form::Design | Form::None => profile,
        };
        let (mut class, mut unchecked, mut remarks) = (asked.class, Vec::new(), Vec::new());
        let mut pitch = asked.pitch.filter(|p| p.is_finite() && *p > 0.0);
        let found = loop {
            if let Some(beyond) = pitch.filter(|p| *p > class.lambda_c() * (1.0 + DECIMALS)) {
                let Some(next) = SettingClass::for_pitch(beyond) else {
                    unchecked = vec![beyond_cutoff(beyond, asked.class, None)];
                    break None;
                };
                class = next;
            }
            let evaluated = match evaluate(profile, class, asked) {
                Ok(evaluated) => evaluated,
                Err(reason) => {
                    let mut reason = reason;
                    if class != asked.class {
                        let beyond = pitch.unwrap_or(asked.class.lambda_c());
                        unchecked.push(beyond_cutoff(beyond, asked.class, Some(class)));
                        // A smaller class would filter the marks away.
                        if let Unchecked::TooShort { smaller, .. } = &mut reason {
                            *smaller = None;
                        }
                    }
                    unchecked.push(reason);
                    break None;
                }
            };
            let rsm = evaluated.filtered.rsm;
            let limit = class.lambda_c() * (1.0 + PITCH_SLACK);
            // Less than one element, though there are heights: at least half of the evaluation length between
            // crossings.
            let unmeasured = rsm.is_none() && evaluated.filtered.rt > spacing::FLAT;
            if !unmeasured && rsm.is_none_or(|p| p <= limit) {
                pitch = pitch.into_iter().chain(rsm).reduce(f64::max);
                break Some(evaluated);
            }
            let seen = rsm.unwrap_or(0.5 * class.evaluation_length());
            let Some(next) = SettingClass::for_pitch(seen).or_else(|| next_class(class)).filter(|n| *n > class) else {
                unchecked.push(beyond_cutoff(seen, class, None));
                pitch = Some(pitch.unwrap_or(0.0).max(seen));
                break None;
            };
            pitch = Some(pitch.unwrap_or(0.0).max(seen));
            class = next;
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
        Self::assemble(profile, asked, class, pitch, found, unchecked, remarks)
    }

    fn assemble(
        profile: &Profile,
        asked: &Asked,
        class: SettingClass,
        pitch: Option<f64>,
        found: Option<ProfileEvaluation>,
        unchecked: Vec<Unchecked>,
        mut remarks: Vec<String>,
    ) -> Self {
        let (unfiltered, over) = match &found {
            Some(e) => (e.unfiltered, class.evaluation_length()),
            None => (profile.unfiltered(asked.standard), profile.length()),
        };
        // The filtered profile has its pitch below the cut-off; what is longer in the unfiltered one is no
        // mark.
        if found.is_some() && pitch.is_some_and(|p| p <= class.lambda_c() * (1.0 + PITCH_SLACK)) {
            let long = match unfiltered.rsm {
                Some(p) if p > class.lambda_c() * (1.0 + PITCH_SLACK) => Some(format!("elements of {p:.4} mm")),
                Some(_) => None,
                None => Some("no whole element in its length".to_owned()),
            };
            remarks.extend(long.map(|l| {
                format!("the unfiltered profile has {l}: wavelengths above lambda_c are removed as waviness")
            }));
        }
        let end_rule = match &found {
            Some(e) => e.setting.ends,
            None => "nothing was filtered",
        };
        Self {
            standard: asked.standard.edition(),
            class_standard: asked.standard.class_edition(),
            filter_standard: PROFILE_FILTER,
            tolerance_rule: asked.standard.tolerance_rule(),
            class: class.name(),
            class_asked: asked.class.name(),
            lambda_s_um: UM_PER_MM * class.lambda_s(),
            lambda_c_mm: class.lambda_c(),
            evaluation_length_mm: class.evaluation_length(),
            sections: SettingClass::SECTIONS,
            spacing_limit_um: UM_PER_MM * class.max_spacing(),
            spacing_um: UM_PER_MM * profile.step(),
            length_mm: profile.length(),
            form_removal: asked.form.of_profile(),
            end_rule,
            rsm_rule: "elements from 0.1 Rz high and 0.01 of a section wide, rising and falling crossings alike",
            direction_to_lay_deg: asked.to_lay,
            direction_to_lay: direction(asked.to_lay),
            pitch_mm: pitch,
            filtered: found.as_ref().map(|e| (&e.filtered).into()),
            unfiltered: (&unfiltered).into(),
            unfiltered_length_mm: over,
            unchecked,
            remarks,
            roughness: found.map_or_else(Vec::new, |e| e.profile),
        }
    }
}

fn beyond_cutoff(pitch: f64, class: SettingClass, next: Option<SettingClass>) -> Unchecked {
    Unchecked::PitchBeyondCutoff {
        pitch_mm: pitch,
        lambda_c_mm: class.lambda_c(),
        class: class.name(),
        next: next.map(SettingClass::name),
    }
}

/// With data beyond the ends where there are any, else by regression.
fn evaluate(profile: &Profile, class: SettingClass, asked: &Asked) -> Result<ProfileEvaluation, Unchecked> {
    let (spacing, class_name) = (profile.step(), class.name());
    if spacing > class.max_spacing() * (1.0 + DECIMALS) {
        return Err(Unchecked::TooCoarse {
            spacing_um: UM_PER_MM * spacing,
            limit_um: UM_PER_MM * class.max_spacing(),
            class: class_name,
        });
    }
    let finest = FINEST * class.max_spacing();
    if spacing < finest * (1.0 - DECIMALS) {
        return Err(Unchecked::TooFine {
            spacing_um: UM_PER_MM * spacing,
            limit_um: UM_PER_MM * finest,
            class: class_name,
        });
    }
    let too_short = |_| Unchecked::TooShort {
        length_mm: profile.length(),
        wanted_mm: class.evaluation_length(),
        class: class_name,
        smaller: SettingClass::ALL
            .into_iter()
            .rfind(|c| c.evaluation_length() <= profile.length() * (1.0 + DECIMALS) && *c < class)
            .map(SettingClass::name),
    };
    let ends = if profile.carries_ends(class) { ProfileEnds::Data } else { ProfileEnds::Regression };
    let mut found = profile.evaluate_with(class, asked.standard, ends).map_err(too_short)?;
    found.setting.ends = match ends {
        ProfileEnds::Data => DATA_BEYOND,
        ProfileEnds::Regression => REGRESSION,
    };
    Ok(found)
}
