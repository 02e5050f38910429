//! The compensated tool does not fit between two parts of its contour ([`OVERCUT`], gate `gouge`), or cuts
//! the contour while leading in or out ([`CONTOUR_TOUCHED`], a warning).
//!
//! The reader finds these places when it computes the compensated path (G41, G42), and says what each is
//! worth.

use proveout_nc::{Location, Overcut, OvercutWeight};

use crate::verdict::{
    finding::{CONTOUR_TOUCHED, Finding, NOTE, OVERCUT},
    log::FindingLog,
};

/// A place where the compensated path enters its own contour. The reader reports it at the end of
/// the compensated stretch, so its line is that of the reader and not that of the block under way.
pub(crate) fn finding(time: f64, location: &Location, overcut: &Overcut) -> Finding {
    let code = match overcut.kind.weight() {
        OvercutWeight::Error => &OVERCUT,
        OvercutWeight::Warning => &CONTOUR_TOUCHED,
        OvercutWeight::Info => &NOTE,
    };
    let mut f = FindingLog::of(code, overcut.to_string());
    (f.file, f.line) = (Some(location.file.to_string()), Some(location.line));
    f.time_s = Some(time);
    f.penetration_mm = Some(overcut.depth);
    f
}
