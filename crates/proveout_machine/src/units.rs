//! Factors from the units of files to those inside: mm, s, radian, N, N mm, kg.

/// Millimeters of a micrometer.
pub(crate) const MM_PER_UM: f64 = 1e-3;
/// Meters of a millimeter.
pub(crate) const M_PER_MM: f64 = 1e-3;
/// mm² of a m², as in kg m².
pub(crate) const MM2_PER_M2: f64 = 1e6;
/// kg/mm3 of a kg/m3.
pub(crate) const KG_MM3_PER_KG_M3: f64 = 1e-9;
/// N mm of an N m.
pub(crate) const N_MM_PER_N_M: f64 = 1e3;
/// N s/mm of an N s/m.
pub(crate) const N_S_MM_PER_N_S_M: f64 = 1e-3;
/// Seconds of a millisecond.
pub(crate) const S_PER_MS: f64 = 1e-3;
/// Milliseconds of a nanosecond.
pub(crate) const MS_PER_NS: f64 = 1e-6;
/// Radians of a microradian.
pub(crate) const RAD_PER_URAD: f64 = 1e-6;
