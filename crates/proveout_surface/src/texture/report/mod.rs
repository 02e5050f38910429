//! One report for every output that prints texture: values, together with everything that they depend on.
//!
//! Two people with the same surface print different numbers if filter chain or rule of aggregation differ.
//! So a value is never given alone: a [`ProfileReport`] or [`ArealReport`] names standard and edition,
//! setting class, cut-offs, evaluation length, removal of the form, rule for the ends, spacing and
//! direction to the lay, and has the unfiltered values next to the filtered ones.
//!
//! ```
//! use proveout_surface::texture::{Asked, Profile, ProfileReport};
//! # let wave = |i: u16| 0.001 * (f64::from(i) * 0.0005 / 0.25 * std::f64::consts::TAU).sin();
//! # let heights: Vec<f64> = (0..=11_200).map(wave).collect();
//! let profile = Profile::new(0.0005, heights)?; // step and heights in mm, over the design
//! let report = ProfileReport::of(&profile, &Asked { to_lay: Some(90.0), ..Asked::default() });
//! match &report.filtered {
//!     Some(values) => println!("Ra {:.3} um, {}", values.ra_um, report.class),
//!     None => println!("unchecked: {}", report.unchecked[0]),
//! }
//! # Ok::<(), proveout_surface::texture::TextureError>(())
//! ```
//!
//! # What is checked
//!
//! Nothing is evaluated outside its standard. Where a rule is broken, `filtered` is none and `unchecked`
//! names the rule ([`Unchecked::rule`]). Unfiltered values are always there.
//!
//! - **`pitch-beyond-cutoff`**: the marks are farther apart than `lambda_c`, which would take them away: the
//!   next class is taken, and said to be; where the data do not carry it, unchecked
//! - **`too-short`**: evaluation length of the class does not fit
//! - **`spacing-too-coarse`**: points farther apart than the class allows
//! - **`spacing-too-fine`**: points so close that the filter would take minutes
//! - **`cutoff-beyond-patch`**: the L-filter of a map is longer than the map
//!
//! The pitch is the larger one of what the caller knows ([`Asked::pitch`], such as the step of the program)
//! and of `RSm` of the filtered profile: a long wave under fine marks is waviness and belongs to the filter,
//! marks beyond the cut-off do not.

mod areal;
mod profile;
mod reason;
mod wording;

use serde::{Deserialize, Serialize};

pub use areal::{ArealReport, ArealValues};
pub use profile::{ProfileReport, ProfileValues};
pub use reason::Unchecked;

use super::{HeightMap, Profile, SettingClass, Standard};

/// Filter of profiles.
const PROFILE_FILTER: &str = "ISO 16610-21:2011, Gaussian, cut at one cut-off";
/// Filter of areas.
const AREAL_FILTER: &str = "ISO 16610-61:2015, Gaussian, cut at one cut-off";
/// Definitions of areal parameters.
const AREAL_STANDARD: &str = "ISO 25178-2:2021";
/// Ends of the filters where the data end.
const REGRESSION: &str = "ISO 16610-28:2016, regression of order zero";
/// Ends of the filters where data go on.
const DATA_BEYOND: &str = "one cut-off of data beyond each end";
/// A measured pitch counts as beyond the cut-off from this share above it: `RSm` is a mean over few elements
/// whose ends the filter moves.
const PITCH_SLACK: f64 = 0.005;

/// How the form is removed before anything is filtered (F-operation).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Heights are distances to the design along its normals: nothing more is taken away.
    #[default]
    Design,
    /// Least-squares line of a profile, least-squares plane of a map.
    Level,
    /// Nothing is taken away.
    None,
}

impl Form {
    /// In words, for a profile.
    pub fn of_profile(self) -> &'static str {
        match self {
            Self::Design => "distance to the design along its normal",
            Self::Level => "least-squares line removed",
            Self::None => "not removed",
        }
    }

    /// In words, for a map.
    pub fn of_map(self) -> &'static str {
        match self {
            Self::Level => "least-squares plane removed",
            other => other.of_profile(),
        }
    }
}

/// What is asked of an evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Which definitions of profile parameters.
    pub standard: Standard,
    /// Setting class to begin with; its cut-off is that of maps, too. Sc3 is that of most milled surfaces
    /// (ISO 21920-3).
    pub class: SettingClass,
    /// How the form is removed.
    pub form: Form,
    /// Direction of a profile to the lay, degrees: 0 along the marks, 90 across them; none where it is not
    /// known.
    pub to_lay: Option<f64>,
    /// Pitch of the marks as far as the caller knows it, mm, such as the distance of passes.
    pub pitch: Option<f64>,
}

impl Default for Asked {
    fn default() -> Self {
        Self {
            standard: Standard::default(),
            class: SettingClass::Sc3,
            form: Form::default(),
            to_lay: None,
            pitch: None,
        }
    }
}

/// Everything about the texture of one place: its map and its profiles.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TextureReport {
    /// The map, where one was evaluated.
    pub area: Option<ArealReport>,
    /// Profiles, such as one along and one across the lay.
    pub profiles: Vec<ProfileReport>,
}

impl TextureReport {
    /// Of a map alone.
    pub fn of_map(map: &HeightMap, asked: &Asked) -> Self {
        Self { area: Some(ArealReport::of(map, asked)), profiles: Vec::new() }
    }

    /// Of one profile alone.
    pub fn of_profile(profile: &Profile, asked: &Asked) -> Self {
        Self { area: None, profiles: vec![ProfileReport::of(profile, asked)] }
    }

    /// All reasons why a filtered value is missing; empty when everything was evaluated.
    pub fn unchecked(&self) -> impl Iterator<Item = &Unchecked> {
        self.area.iter().flat_map(|a| &a.unchecked).chain(self.profiles.iter().flat_map(|p| &p.unchecked))
    }
}

impl std::fmt::Display for TextureReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(area) = &self.area {
            write!(f, "{area}")?;
        }
        self.profiles.iter().try_for_each(|p| write!(f, "{p}"))
    }
}

/// The next class above one.
fn next_class(class: SettingClass) -> Option<SettingClass> {
    SettingClass::ALL.into_iter().find(|c| *c > class)
}
