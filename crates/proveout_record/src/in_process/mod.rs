//! What changes while a run goes on, at a bounded number of moments: the stock tile by tile, the tool in the
//! spindle. The recording and the player of the report show it.

pub(crate) mod frames;
pub(crate) mod tiles;
pub(crate) mod tool_pictures;

/// Angle above which an edge of a body is drawn sharp, radian.
pub(crate) const CREASE: f64 = 0.6;
