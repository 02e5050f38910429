//! Colors of the pictures: a diverging map for signed deviations and fixed colors for roles.

/// Least end of a color scale, mm: a part that is exact has a scale, too.
pub(crate) const LEAST_FLOOR_MM: f64 = 1e-6;
/// Part by which a value may be above a round number and still have it as its end: rounding.
const ROUNDING: f64 = 1e-9;

/// Color of sRGB with opacity, 0..=255 each.
pub type Rgba = [u8; 4];

/// Skin of the stock and of a part without deviations.
pub(crate) const STEEL: Rgba = [158, 164, 172, 255];
/// Deep gouge: the low end of the map.
const GOUGE: [u8; 3] = [178, 24, 43];
/// On the design.
const NEUTRAL: [u8; 3] = [226, 226, 222];
/// Much material left: the high end of the map.
const EXCESS: [u8; 3] = [33, 102, 172];

/// Signed deviation to color: red below the design (gouge), light gray on it, blue above it (material left).
///
/// The two ends have the same lightness and remain distinct for people who cannot distinguish red from
/// green. Between the three stops the color runs straight in the `OKLab` space (Ottosson 2020), in which
/// equal steps look equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviationMap {
    /// Deviation that gets the full color, to both sides, mm; larger values get the same color.
    pub range: f64,
}

impl DeviationMap {
    /// A map whose range is the next round number (1, 2 or 5 times a power of ten) above 99 percent of the
    /// absolute deviations, and at least `floor` (mm), so that single outliers do not wash out the picture.
    ///
    /// Values that are not finite are left out.
    pub fn of(deviations: &[f64], floor: f64) -> Self {
        let mut sizes: Vec<f64> = deviations.iter().map(|d| d.abs()).filter(|d| d.is_finite()).collect();
        let floor = if floor.is_finite() { floor.max(LEAST_FLOOR_MM) } else { LEAST_FLOOR_MM };
        if sizes.is_empty() {
            return Self { range: round_up(floor) };
        }
        let rank = (sizes.len() - 1) * 99 / 100;
        let (_, &mut wanted, _) = sizes.select_nth_unstable_by(rank, f64::total_cmp);
        Self { range: round_up(wanted.max(floor)) }
    }

    /// Position of a deviation on the map: 0 at `-range` or below, 0.5 at zero, 1 at `range` or above.
    pub fn position(&self, deviation: f64) -> f64 {
        (0.5 + 0.5 * deviation / self.range).clamp(0.0, 1.0)
    }

    /// Color of a deviation (mm); values that are not numbers get the color of plain steel.
    pub fn color(&self, deviation: f64) -> Rgba {
        if deviation.is_nan() { STEEL } else { Self::at(self.position(deviation)) }
    }

    /// Color at a position 0..=1 of the map.
    pub fn at(position: f64) -> Rgba {
        let t = position.clamp(0.0, 1.0) * 2.0;
        let (from, to, t) = if t <= 1.0 { (GOUGE, NEUTRAL, t) } else { (NEUTRAL, EXCESS, t - 1.0) };
        let (a, b) = (oklab_from_srgb(from), oklab_from_srgb(to));
        let mixed = [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t);
        let [r, g, b] = srgb_from_oklab(mixed);
        [r, g, b, 255]
    }
}

/// Ink of frames and letters.
pub(crate) const NEUTRAL_INK: [u8; 3] = [32, 34, 38];
/// Heights from the lowest to the highest; lightness rises all the way, so that the order shows without
/// color, too.
const HEIGHTS: [[u8; 3]; 5] = [[28, 20, 68], [32, 84, 140], [28, 146, 140], [126, 200, 92], [250, 232, 120]];

/// Color of a height at a share 0..=1 of the range, straight in `OKLab` between the stops.
pub(crate) fn height_color(share: f64) -> [u8; 3] {
    let t = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 } * (HEIGHTS.len() - 1) as f64;
    let k = (t.floor() as usize).min(HEIGHTS.len() - 2);
    let (a, b, t) = (oklab_from_srgb(HEIGHTS[k]), oklab_from_srgb(HEIGHTS[k + 1]), t - k as f64);
    srgb_from_oklab([0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t))
}

/// Smallest of 1, 2, 5 times a power of ten that is not below `value`.
fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let slack = 1.0 + ROUNDING;
    [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|r| r * slack >= value).unwrap_or(10.0 * power)
}

/// One sRGB channel (0..=255) to linear light (0..=1), IEC 61966-2-1.
pub(crate) fn linear_from_srgb(channel: u8) -> f64 {
    let c = f64::from(channel) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn srgb_from_linear(c: f64) -> u8 {
    let c = c.clamp(0.0, 1.0);
    let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0).round() as u8
}

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

// The four matrices of B. Ottosson, "A perceptual color space for image processing", 2020.
const LMS_FROM_LINEAR: [[f64; 3]; 3] = [
    [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
    [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
    [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
];
const LAB_FROM_ROOT: [[f64; 3]; 3] = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];
const ROOT_FROM_LAB: [[f64; 3]; 3] = [
    [1.0, 0.396_337_777_4, 0.215_803_757_3],
    [1.0, -0.105_561_345_8, -0.063_854_172_8],
    [1.0, -0.089_484_177_5, -1.291_485_548_0],
];
const LINEAR_FROM_LMS: [[f64; 3]; 3] = [
    [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
    [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
    [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701_0],
];

fn oklab_from_srgb(srgb: [u8; 3]) -> [f64; 3] {
    times(&LAB_FROM_ROOT, times(&LMS_FROM_LINEAR, srgb.map(linear_from_srgb)).map(f64::cbrt))
}

fn srgb_from_oklab(lab: [f64; 3]) -> [u8; 3] {
    times(&LINEAR_FROM_LMS, times(&ROOT_FROM_LAB, lab).map(|v| v * v * v)).map(srgb_from_linear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_are_met_and_signs_are_distinguished() {
        let map = DeviationMap { range: 0.02 };
        assert_eq!(map.color(-0.02)[..3], GOUGE);
        assert_eq!(map.color(-7.0)[..3], GOUGE);
        assert_eq!(map.color(0.0)[..3], NEUTRAL);
        assert_eq!(map.color(0.02)[..3], EXCESS);
        assert_eq!(map.color(f64::NAN), STEEL);
        assert!(map.color(-0.01)[0] > map.color(-0.01)[2], "gouge is red");
        assert!(map.color(0.01)[2] > map.color(0.01)[0], "excess is blue");
    }

    #[test]
    fn lightness_rises_to_the_middle_and_falls_after_it() {
        let light: Vec<f64> = (0..=64)
            .map(|i| {
                let [r, g, b, _] = DeviationMap::at(f64::from(i) / 64.0);
                oklab_from_srgb([r, g, b])[0]
            })
            .collect();
        let slack = 0.004; // one step of an 8-bit channel
        assert!(light[..=32].windows(2).all(|w| w[1] > w[0] - slack));
        assert!(light[32..].windows(2).all(|w| w[1] < w[0] + slack));
    }

    #[test]
    fn higher_is_lighter() {
        let light: Vec<f64> = (0..=64).map(|i| oklab_from_srgb(height_color(f64::from(i) / 64.0))[0]).collect();
        assert!(light.windows(2).all(|w| w[1] > w[0] - 0.002), "{light:?}");
        assert_eq!((height_color(0.0), height_color(1.0)), (HEIGHTS[0], HEIGHTS[4]));
        assert_eq!(height_color(f64::NAN), HEIGHTS[0]);
    }

    #[test]
    fn the_range_is_a_round_number_that_outliers_do_not_move() {
        let mut d: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1e-5).collect();
        assert_eq!(DeviationMap::of(&d, 0.0).range, 0.01);
        d.push(80.0);
        d.push(f64::NAN);
        assert_eq!(DeviationMap::of(&d, 0.0).range, 0.01);
        assert_eq!(DeviationMap::of(&[], 0.003).range, 0.005);
        assert_eq!(DeviationMap::of(&[0.02], 0.0).range, 0.02);
        assert!(DeviationMap::of(&[0.0], 0.0).range > 0.0);
    }
}
