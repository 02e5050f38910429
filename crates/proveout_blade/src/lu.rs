//! The compressor blade used to test the polar-angle parameters of Lu, Yang & Zhao 2022
//! (doi:10.21203/rs.3.rs-1213345/v1). The paper gives no blade; this is the substitute defined in its
//! specification.
//!
//! ```text
//!   xi    = cos(w) / 2
//!   eta   = m (1 - 4 xi^2) + (tau / 2) sin w (1 - 0.35 cos w)
//!   m     = 0.14 - 0.09 v        tau     = 0.10 - 0.04 v
//!   chord = 40 (1 - 0.25 v) mm   stagger = 20 + 30 v degrees   span = 100 mm
//! ```
//!
//! u is w (radian): 0 at the trailing edge, pi at the leading edge, the suction side between them. v is the
//! part of the span. The span runs along +X, the section lies in Y (chord) and Z and turns with the stagger
//! about X.

use std::f64::consts::TAU;

use proveout_geom::rad;

use super::{
    closed_form::{ClosedForm, ClosedSurface},
    scalar::Scalar,
    section::GAUSS,
    surface::{Domain, ParametricSurface},
};

/// Panels in which the length of a section is summed.
const PANELS: usize = 256;

/// A law that is linear along the span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlongSpan {
    /// At v = 0.
    pub root: f64,
    /// Added up to v = 1.
    pub rise: f64,
}

impl AlongSpan {
    fn at<T: Scalar>(self, v: T) -> T {
        v.times(self.rise).plus(self.root)
    }
}

/// The formula of the blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lu {
    /// mm.
    pub span: f64,
    /// mm.
    pub chord: AlongSpan,
    /// Height of the camber line, part of the chord.
    pub camber: AlongSpan,
    /// `tau`, part of the chord.
    pub thickness: AlongSpan,
    /// Radian.
    pub stagger: AlongSpan,
}

impl Lu {
    /// The twisted substitute.
    pub fn stand_in() -> Self {
        Self {
            span: 100.0,
            chord: AlongSpan { root: 40.0, rise: -10.0 },
            camber: AlongSpan { root: 0.14, rise: -0.09 },
            thickness: AlongSpan { root: 0.10, rise: -0.04 },
            stagger: AlongSpan { root: rad(20.0), rise: rad(30.0) },
        }
    }

    /// The same with the stagger of its root everywhere.
    pub fn untwisted() -> Self {
        Self { stagger: AlongSpan { root: rad(20.0), rise: 0.0 }, ..Self::stand_in() }
    }

    /// The point in the unit chord: xi and eta.
    pub fn section<T: Scalar>(&self, w: T, v: T) -> [T; 2] {
        let (s, c) = w.sin_cos();
        let half = self.thickness.at(v).times(0.5) * s * (T::of(1.0) - c.times(0.35));
        // 1 - 4 xi^2 = sin^2 w.
        [c.times(0.5), self.camber.at(v) * s * s + half]
    }
}

impl ClosedForm for Lu {
    fn domain(&self) -> Domain {
        Domain { u: [0.0, TAU], v: [0.0, 1.0], u_closed: true }
    }

    fn place<T: Scalar>(&self, w: T, v: T) -> [T; 3] {
        let [xi, eta] = self.section(w, v);
        let (s, c) = self.stagger.at(v).sin_cos();
        let chord = self.chord.at(v);
        [v.times(self.span), chord * (xi * c - eta * s), chord * (xi * s + eta * c)]
    }
}

/// Lengths along a section, so that its chord-length parameter can be asked.
#[derive(Clone, Debug)]
pub struct SectionLength {
    v: f64,
    /// Length at the ends of the panels, mm.
    ends: Vec<f64>,
}

impl ClosedSurface<Lu> {
    /// Lengths along the section at v.
    pub fn section_length(&self, v: f64) -> SectionLength {
        let width = TAU / PANELS as f64;
        let mut ends = vec![0.0];
        let mut sum = 0.0;
        for k in 0..PANELS {
            sum += self.length(v, k as f64 * width, width);
            ends.push(sum);
        }
        SectionLength { v, ends }
    }

    /// The angle w at which the section has run through a part of its length from the trailing edge over the
    /// suction side: the cumulative chord-length parameter of infinitely many points.
    pub fn angle_at_part(&self, lengths: &SectionLength, part: f64) -> f64 {
        let (width, whole) = (TAU / PANELS as f64, lengths.ends[PANELS]);
        let wanted = part.clamp(0.0, 1.0) * whole;
        let panel = lengths.ends.partition_point(|&end| end <= wanted).clamp(1, PANELS) - 1;
        let from = panel as f64 * width;
        let mut w = from + width * (wanted - lengths.ends[panel]) / (lengths.ends[panel + 1] - lengths.ends[panel]);
        // Newton on a length that is smooth and nearly linear within a panel.
        for _ in 0..4 {
            let length = lengths.ends[panel] + self.length(lengths.v, from, w - from);
            w += (wanted - length) / self.local(w, lengths.v).first[0].norm();
        }
        w
    }

    fn length(&self, v: f64, from: f64, width: f64) -> f64 {
        GAUSS.iter().map(|(x, g)| 0.5 * width * g * self.local(from + 0.5 * width * (1.0 + x), v).first[0].norm()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_leading_edge_drifts_as_its_specification_says() {
        let blade = ClosedSurface::new(Lu::stand_in());
        for (v, part) in [(0.0, 0.5168), (1.0, 0.5042)] {
            let lengths = blade.section_length(v);
            let w = blade.angle_at_part(&lengths, part);
            // Four decimals of 87 and 62 mm, at an edge where dw/ds is at most 0.37 and 0.8 radian/mm.
            assert!((w - std::f64::consts::PI).abs() < 0.003, "{v} {w}");
        }
    }

    /// Angle of the normal against the span axis along a line, and the largest rate for each mm: beta of
    /// machine II.
    fn turning(blade: &ClosedSurface<Lu>, line: impl Fn(f64) -> f64) -> (f64, f64) {
        let steps = 4000;
        let (mut angles, mut rate) = (Vec::new(), 0.0_f64);
        let mut last: Option<(proveout_geom::Point, f64)> = None;
        for k in 0..=steps {
            let v = f64::from(k) / f64::from(steps);
            let at = blade.local(line(v), v);
            let mut beta = at.normal.z.atan2(at.normal.y);
            if let Some((p, b)) = last {
                beta = proveout_geom::wrap_near(beta, b);
                rate = rate.max((beta - b).abs() / (at.point - p).norm());
            }
            angles.push(beta);
            last = Some((at.point, beta));
        }
        let most = angles.iter().copied().fold(f64::MIN, f64::max);
        let least = angles.iter().copied().fold(f64::MAX, f64::min);
        ((most - least).to_degrees(), rate.to_degrees())
    }

    #[test]
    fn lines_of_constant_length_turn_as_an_independent_count_has_it() {
        let blade = ClosedSurface::new(Lu::stand_in());
        let line = |part: f64| turning(&blade, |v| blade.angle_at_part(&blade.section_length(v), part));
        let found = [0.505, 0.510, 0.515].map(line);
        let range = found.iter().map(|f| f.0).fold(0.0, f64::max);
        let rate = found.iter().map(|f| f.1).fold(0.0, f64::max);
        assert!((range - 142.62).abs() < 0.5 && (rate - 4.124).abs() < 0.02, "{found:?}");
        let straight = ClosedSurface::new(Lu::untwisted());
        let line = |part: f64| turning(&straight, |v| straight.angle_at_part(&straight.section_length(v), part));
        let rate = [0.505, 0.510, 0.515].map(line).iter().map(|f| f.1).fold(0.0, f64::max);
        assert!((rate - 3.839).abs() < 0.02, "{rate}");
    }
}
