//! Surface texture: parameters, filters and setting classes of profiles (ISO 21920, ISO 4287) and of areas
//! (ISO 25178).
//!
//! Data in: heights over a lattice, mm, the form already removed (heights are distances to the design
//! surface along its normals). Data out: parameters, mm for heights, together with everything that they
//! depend on ([`ProfileSetting`], [`ArealSetting`]): standard, setting class, nesting indices, evaluation
//! length, rule for the ends, spacing.
//!
//! * [`Profile`] – heights at equal steps; [`Profile::evaluate`] filters and cuts out the evaluation length;
//!   [`ProfileParameters`].
//! * [`HeightMap`] – heights over a rectangle; [`HeightMap::evaluate`], [`ArealParameters`]; [`lay`] finds
//!   the direction of the marks, [`Autocorrelation`] their lengths.
//! * [`gaussian_mean`] – the linear Gaussian filter of ISO 16610-21 and -61.
//! * [`SettingClass`] – Sc1 to Sc5 of ISO 21920-3:2021, table 1.
//! * [`TextureReport`] – what outputs print: values, all that they depend on, and by name what could not be
//!   evaluated.
//! * [`dong`] – the analytic profile of passes of a bull-nose tool.
//! * [`mod@file`] – SMD, SDF and X3P files.
//! * [`cusp`] – closed forms of the rows of arcs that a path with a constant step leaves.
//!
//! # The chain
//!
//! ```text
//!   heights over the design      S-filter            L-filter
//!   (form removed: F)   ──────►  lambda_s  ──────►   lambda_c  ──────►  parameters
//!                                low-pass            high-pass
//!         └────────────────────────────────────────────────────────►  unfiltered values, printed beside them
//! ```
//!
//! Limits: the S-filter is left out, and said to be, where the spacing is too coarse for its cut-off (a map
//! at 5 um cannot carry 2.5 um); maps must be complete, a lattice with holes is refused.

mod areal;
mod autocorrelation;
mod classes;
pub mod cusp;
pub mod dong;
pub mod file;
mod gaussian;
mod height_map;
mod profile;
pub mod report;
mod roughness_parameters;
mod spacing;

pub use areal::{ArealEvaluation, ArealParameters, ArealSetting};
pub use autocorrelation::{Autocorrelation, lay};
pub use classes::{SettingClass, Standard};
pub use gaussian::{gaussian_mean, gaussian_mean_of_map};
pub use height_map::{HeightMap, TextureError};
pub use profile::{Profile, ProfileEvaluation, ProfileSetting};
pub use report::{ArealReport, ArealValues, Asked, Form, ProfileReport, ProfileValues, TextureReport, Unchecked};
pub use roughness_parameters::ProfileParameters;

/// Micrometers in a millimeter.
const UM_PER_MM: f64 = 1e3;
/// Part by which lengths and spacings given in decimals may miss a limit: rounding.
const DECIMALS: f64 = 1e-9;
