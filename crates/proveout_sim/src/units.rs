//! Factors between the units inside (mm, N mm, kg/mm3) and those of results and scenes.

/// Micrometers of a millimeter.
pub(crate) const UM_PER_MM: f64 = 1e3;
/// Millimeters of a micrometer.
pub(crate) const MM_PER_UM: f64 = 1e-3;
/// Millimeters of a meter.
pub(crate) const MM_PER_M: f64 = 1e3;
/// Meters of a millimeter.
pub(crate) const M_PER_MM: f64 = 1e-3;
/// N m of an N mm.
pub(crate) const N_M_PER_N_MM: f64 = 1e-3;
/// kg/mm3 of a kg/m3.
pub(crate) const KG_MM3_PER_KG_M3: f64 = 1e-9;
