//! One interval of material and what made its ends.

use proveout_geom::Vector;

/// Id of an end that no motion has made.
pub(crate) const INITIAL: u32 = u32::MAX;
/// Intervals of material or overlap shorter than this (mm) are none: they come from rounding and from the
/// 1e-7 mm by which bodies are taken smaller, and are far below the promised bound.
pub(crate) const SLIVER: f64 = 2e-7;

/// Interval of material on a ray, with the mark of what made each end: 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MaterialSpan {
    /// Lower end, mm.
    pub lo: f64,
    /// Upper end, mm.
    pub hi: f64,
    pub lo_mark: EndMark,
    pub hi_mark: EndMark,
}

/// One end of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpanEnd {
    /// Height on the ray, mm.
    pub s: f64,
    pub mark: EndMark,
}

impl MaterialSpan {
    /// Lower and upper end.
    pub(crate) fn ends(&self) -> [SpanEnd; 2] {
        [SpanEnd { s: self.lo, mark: self.lo_mark }, SpanEnd { s: self.hi, mark: self.hi_mark }]
    }

    pub(crate) fn from_ends(lo: SpanEnd, hi: SpanEnd) -> Self {
        Self { lo: lo.s, hi: hi.s, lo_mark: lo.mark, hi_mark: hi.mark }
    }
}

/// What made an end: the id of a sweep item and the outward normal of the material there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EndMark {
    pub id: u32,
    normal: u32,
}

/// Largest value of one octahedral coordinate.
const FULL: f64 = 32767.0;

impl EndMark {
    /// Of an end that nothing is known of.
    pub(crate) const NONE: Self = Self { id: INITIAL, normal: 0 };

    /// Packs a unit normal into two 16-bit octahedral coordinates (Meyer et al. 2010, "On Floating-Point
    /// Normal Vectors"); the error is below 7e-5 rad.
    pub(crate) fn new(id: u32, n: [f64; 3]) -> Self {
        let sum = n[0].abs() + n[1].abs() + n[2].abs();
        if !(sum > 0.0 && sum.is_finite()) {
            return Self { id, normal: 0 };
        }
        let (mut x, mut y) = (n[0] / sum, n[1] / sum);
        if n[2] < 0.0 {
            (x, y) = ((1.0 - y.abs()) * 1_f64.copysign(x), (1.0 - x.abs()) * 1_f64.copysign(y));
        }
        let pack = |v: f64| (v * FULL + 0.5_f64.copysign(v)) as i16 as u16;
        Self { id, normal: u32::from(pack(x)) | u32::from(pack(y)) << 16 }
    }

    /// From an id and the packed normal that [`Self::code`] gave.
    pub(crate) fn from_code(id: u32, code: u32) -> Self {
        Self { id, normal: code }
    }

    /// The packed normal.
    pub(crate) fn code(self) -> u32 {
        self.normal
    }

    pub(crate) fn normal(self) -> Vector {
        let unpack = |v: u32| f64::from(v as u16 as i16) / FULL;
        let (x, y) = (unpack(self.normal), unpack(self.normal >> 16));
        let z = 1.0 - x.abs() - y.abs();
        let (x, y) =
            if z < 0.0 { ((1.0 - y.abs()) * 1_f64.copysign(x), (1.0 - x.abs()) * 1_f64.copysign(y)) } else { (x, y) };
        Vector::new(x, y, z).normalize()
    }

    pub(crate) fn made_by(self) -> Option<u32> {
        (self.id != INITIAL).then_some(self.id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_normals_are_close_and_axes_are_exact() {
        for k in 0..5000 {
            let f = f64::from(k);
            let n = Vector::new((f * 0.37).sin(), (f * 0.91).cos(), (f * 0.17).sin()).normalize();
            let back = EndMark::new(1, n.into()).normal();
            assert!(n.cross(&back).norm() < 7e-5 && n.dot(&back) > 0.0);
        }
        for n in [Vector::x(), -Vector::x(), Vector::y(), -Vector::y(), Vector::z(), -Vector::z()] {
            assert_eq!(EndMark::new(1, n.into()).normal(), n);
        }
    }

    #[test]
    fn a_span_stays_small() {
        assert_eq!(size_of::<MaterialSpan>(), 32);
    }
}
