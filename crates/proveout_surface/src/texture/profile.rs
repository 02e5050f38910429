//! Profiles: filter, evaluation length, parameters.

use serde::Serialize;

use super::{DECIMALS, ProfileParameters, SettingClass, Standard, TextureError, UM_PER_MM, gaussian_mean};

/// What the values of a profile depend on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileSetting {
    /// Number and edition of the standard.
    pub standard: &'static str,
    /// Setting class of ISO 21920-3:2021.
    pub class: &'static str,
    /// Nesting index of the S-filter, mm.
    pub lambda_s_mm: f64,
    /// Nesting index of the L-filter, mm.
    pub lambda_c_mm: f64,
    /// Evaluation length, mm.
    pub evaluation_length_mm: f64,
    /// Sections in it.
    pub sections: usize,
    /// How the form was removed.
    pub form: &'static str,
    /// Rule for the ends of the filters.
    pub ends: &'static str,
    /// Spacing of the points, mm.
    pub step_mm: f64,
    /// What counts as an element of `RSm`.
    pub rsm: &'static str,
}

/// Heights over a line at equal steps, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    step: f64,
    heights: Vec<f64>,
}

/// A profile, filtered and not.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileEvaluation {
    /// What the filtered values depend on.
    pub setting: ProfileSetting,
    /// Values of the roughness profile.
    pub filtered: ProfileParameters,
    /// Values of the same stretch, only its mean taken off.
    pub unfiltered: ProfileParameters,
    /// The roughness profile over the evaluation length, mm.
    pub profile: Vec<f64>,
}

impl Profile {
    /// Heights (mm) at equal steps (mm).
    ///
    /// # Errors
    /// [`TextureError`] for fewer than two heights, a step that is no length, a height that is no number.
    pub fn new(step: f64, heights: Vec<f64>) -> Result<Self, TextureError> {
        if heights.len() < 2 {
            return Err(TextureError::Lattice { points: heights.len(), columns: heights.len(), rows: 1 });
        }
        if !(step.is_finite() && step > 0.0) {
            return Err(TextureError::Step(step));
        }
        if let Some(index) = heights.iter().position(|z| !z.is_finite()) {
            return Err(TextureError::Hole { index, value: heights[index] });
        }
        Ok(Self { step, heights })
    }

    /// Length that an evaluation of a class needs, mm: evaluation length and one cut-off on either side for
    /// the filter's ends.
    pub fn length_for(class: SettingClass) -> f64 {
        class.evaluation_length() + 2.0 * class.lambda_c()
    }

    /// Spacing, mm.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Heights, mm.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Length from the first to the last point, mm.
    pub fn length(&self) -> f64 {
        (self.heights.len() - 1) as f64 * self.step
    }

    /// Filters with the cut-offs of a class and evaluates the evaluation length in the middle.
    ///
    /// # Errors
    /// [`TextureError::TooCoarse`] when the spacing does not carry the class, [`TextureError::TooShort`] when
    /// evaluation length and filter ends do not fit.
    pub fn evaluate(&self, class: SettingClass, standard: Standard) -> Result<ProfileEvaluation, TextureError> {
        // A spacing given in decimals may lie a rounding error above the limit.
        if self.step > class.max_spacing() * (1.0 + DECIMALS) {
            return Err(TextureError::TooCoarse {
                step_um: self.step * UM_PER_MM,
                limit_um: class.max_spacing() * UM_PER_MM,
                class: class.name(),
            });
        }
        self.evaluate_with(class, standard, ProfileEnds::Data)
    }

    /// Whether there is one cut-off of data beyond each end of the evaluation length.
    pub(super) fn carries_ends(&self, class: SettingClass) -> bool {
        self.heights.len() > self.steps(class) + 2 * self.end_steps(class)
    }

    fn steps(&self, class: SettingClass) -> usize {
        (class.evaluation_length() / self.step).round() as usize
    }

    fn end_steps(&self, class: SettingClass) -> usize {
        (class.lambda_c() / self.step * (1.0 - DECIMALS)).floor() as usize
    }

    /// The spacing is the caller's business.
    pub(super) fn evaluate_with(
        &self,
        class: SettingClass,
        standard: Standard,
        ends: ProfileEnds,
    ) -> Result<ProfileEvaluation, TextureError> {
        let (steps, end_steps) = (self.steps(class), self.end_steps(class));
        let (fits, wanted_mm, what) = match ends {
            ProfileEnds::Data => (
                self.carries_ends(class),
                Self::length_for(class),
                "evaluation length and one cut-off on either side for the ends of the filter",
            ),
            ProfileEnds::Regression => (self.heights.len() > steps, class.evaluation_length(), "evaluation length"),
        };
        if !fits {
            return Err(TextureError::TooShort { length_mm: self.length(), wanted_mm, class: class.name(), what });
        }
        // What lies beyond both filters' reach of the evaluation length changes nothing.
        let reach = end_steps + 2 + (class.lambda_s() / self.step).ceil() as usize;
        let middle = (self.heights.len() - 1 - steps) / 2;
        let begin = middle.saturating_sub(reach);
        let heights = &self.heights[begin..(middle + steps + reach + 1).min(self.heights.len())];
        let smooth = gaussian_mean(heights, self.step, class.lambda_s());
        let mean_line = gaussian_mean(&smooth, self.step, class.lambda_c());
        let first = middle - begin;
        let stretch = first..=first + steps;
        let profile: Vec<f64> =
            smooth[stretch.clone()].iter().zip(&mean_line[stretch.clone()]).map(|(z, m)| z - m).collect();
        Ok(ProfileEvaluation {
            setting: ProfileSetting {
                standard: standard.edition(),
                class: class.name(),
                lambda_s_mm: class.lambda_s(),
                lambda_c_mm: class.lambda_c(),
                evaluation_length_mm: class.evaluation_length(),
                sections: SettingClass::SECTIONS,
                form: "distance to the design along its normal",
                ends: "one cut-off of data beyond each end",
                step_mm: self.step,
                rsm: "elements from 0.1 Rz height and 0.01 of a section width",
            },
            filtered: ProfileParameters::of(&profile, self.step, standard),
            unfiltered: centered(&heights[stretch], self.step, standard),
            profile,
        })
    }

    /// Parameters of all heights with their mean taken off, unfiltered.
    pub(super) fn unfiltered(&self, standard: Standard) -> ProfileParameters {
        centered(&self.heights, self.step, standard)
    }

    /// The profile without its least-squares line.
    #[must_use]
    pub fn leveled(&self) -> Self {
        let n = self.heights.len() as f64;
        let middle = 0.5 * (n - 1.0);
        let mean = self.heights.iter().sum::<f64>() / n;
        let (mut xz, mut xx) = (0.0, 0.0);
        for (i, z) in self.heights.iter().enumerate() {
            let x = i as f64 - middle;
            xz += x * (z - mean);
            xx += x * x;
        }
        let slope = xz / xx;
        let heights = self.heights.iter().enumerate().map(|(i, z)| z - mean - slope * (i as f64 - middle)).collect();
        Self { step: self.step, heights }
    }
}

/// What is needed beyond the ends of the evaluation length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProfileEnds {
    /// One cut-off of data.
    Data,
    /// Nothing need be there: the weights that lie on data are divided by their sum (ISO 16610-28, regression
    /// of order zero).
    Regression,
}

/// Parameters with the mean of the polygon taken off.
fn centered(raw: &[f64], step: f64, standard: Standard) -> ProfileParameters {
    let mean = raw.windows(2).map(|w| 0.5 * (w[0] + w[1])).sum::<f64>() / (raw.len() - 1) as f64;
    let centered: Vec<f64> = raw.iter().map(|z| z - mean).collect();
    ProfileParameters::of(&centered, step, standard)
}
