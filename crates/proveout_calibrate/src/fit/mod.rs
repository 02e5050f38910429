//! Estimators: bounded least squares with a rank test, one file a group of parameters.

pub(crate) mod friction;
pub(crate) mod law;
pub(crate) mod least_squares;
pub(crate) mod limits;
pub(crate) mod moves;
pub(crate) mod servo;
