//! Threads: what a tap cuts outside of its core hole, and sizes of threads as people write them.
//!
//! Dimensions of the basic profile of ISO 68-1: a triangle of 60 degrees and height H = sqrt(3)/2 P, of which
//! the inner thread keeps 5/8 H between its outer and its core diameter. Coarse pitches are those of ISO 261.

use crate::ShapeError;
use crate::cutter::refuse;

/// Radial depth of an inner thread over its pitch: 5/8 of sqrt(3)/2.
const DEPTH_OVER_PITCH: f64 = 0.625 * 0.866_025_403_784_438_6;
/// One inch, mm.
const INCH_MM: f64 = 25.4;
/// Largest pitch over diameter that is accepted from a text: a larger number is the length of a screw.
const COARSEST: f64 = 0.35;
/// Largest number of an inch thread by number, and its coarsest pitch, threads an inch.
const MOST_NUMBERED: f64 = 12.0;
const COARSEST_NUMBERED: f64 = 24.0;
/// Threads an inch that are believed.
const THREADS_PER_INCH: std::ops::RangeInclusive<f64> = 4.0..=120.0;
/// Nominal diameters that differ by less are one, mm: rounding.
const SAME_DIAMETER_MM: f64 = 1e-9;

/// Nominal diameter and coarse pitch, mm (ISO 261, all choices that have a coarse pitch). The only table of
/// it: readers of programs use it too.
const COARSE: [(f64, f64); 40] = [
    (1.0, 0.25),
    (1.1, 0.25),
    (1.2, 0.25),
    (1.4, 0.3),
    (1.6, 0.35),
    (1.8, 0.35),
    (2.0, 0.4),
    (2.2, 0.45),
    (2.5, 0.45),
    (3.0, 0.5),
    (3.5, 0.6),
    (4.0, 0.7),
    (4.5, 0.75),
    (5.0, 0.8),
    (6.0, 1.0),
    (7.0, 1.0),
    (8.0, 1.25),
    (9.0, 1.25),
    (10.0, 1.5),
    (11.0, 1.5),
    (12.0, 1.75),
    (14.0, 2.0),
    (16.0, 2.0),
    (18.0, 2.5),
    (20.0, 2.5),
    (22.0, 2.5),
    (24.0, 3.0),
    (27.0, 3.0),
    (30.0, 3.5),
    (33.0, 3.5),
    (36.0, 4.0),
    (39.0, 4.0),
    (42.0, 4.5),
    (45.0, 4.5),
    (48.0, 5.0),
    (52.0, 5.0),
    (56.0, 5.5),
    (60.0, 5.5),
    (64.0, 6.0),
    (68.0, 6.0),
];

/// The coarse pitch of a metric thread of this nominal diameter, mm (ISO 261); none where the standard has no
/// coarse pitch for it.
pub fn coarse_pitch(diameter: f64) -> Option<f64> {
    COARSE.into_iter().find(|(d, _)| (d - diameter).abs() < SAME_DIAMETER_MM).map(|(_, pitch)| pitch)
}

/// The thread that a tap cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thread {
    /// Pitch, mm.
    pub pitch: f64,
    /// Radius at the root of the inner thread: half of the nominal diameter, mm.
    pub outer_radius: f64,
    /// Radius of the hole that the thread is cut into, mm.
    pub core_radius: f64,
}

impl Thread {
    /// A thread of a nominal diameter and a pitch, mm.
    ///
    /// # Errors
    /// A pitch that is not above zero, or that leaves no core.
    pub fn new(diameter: f64, pitch: f64) -> Result<Self, ShapeError> {
        if !(pitch.is_finite() && pitch > 0.0) {
            return refuse("pitch_mm", pitch, "must be above 0");
        }
        let outer_radius = 0.5 * diameter;
        let core_radius = outer_radius - DEPTH_OVER_PITCH * pitch;
        if core_radius <= 0.0 {
            let most = outer_radius / DEPTH_OVER_PITCH;
            return refuse("pitch_mm", pitch, format!("leaves no core of the thread: it must be below {most:.3} mm"));
        }
        Ok(Self { pitch, outer_radius, core_radius })
    }
}

/// A thread as a text names it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreadSize {
    /// Nominal diameter, mm.
    pub diameter: f64,
    /// Pitch, mm.
    pub pitch: f64,
    /// Whether the text names the pitch; otherwise it is the coarse one of ISO 261, which a size without a
    /// pitch means.
    pub pitch_told: bool,
}

/// The thread that a text names: `M8`, `M8X1.25`, `M8 x 1`, `M8-1.25`, `10-32`, `#8-32`, `1/4-20 UNC`; none
/// where there is no such size.
///
/// ```
/// use proveout_tool::{Thread, thread_of};
///
/// let size = thread_of("M8 TAP").expect("a metric size");
/// assert_eq!((size.diameter, size.pitch, size.pitch_told), (8.0, 1.25, false)); // mm
/// let thread = Thread::new(size.diameter, size.pitch)?;
/// // ISO 68-1: the minor diameter is 8 - 5/8 sqrt(3) 1.25 mm.
/// let minor = 8.0 - 0.625 * 3_f64.sqrt() * 1.25;
/// assert!((2.0 * thread.core_radius - minor).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn thread_of(text: &str) -> Option<ThreadSize> {
    let upper = text.to_uppercase().replace('\u{d7}', "X");
    let between = |c: char| c.is_whitespace() || matches!(c, '|' | ',' | ';' | '(' | ')' | '{' | '}' | '=' | '_' | '"');
    let words: Vec<&str> = upper.split(between).filter(|w| !w.is_empty()).collect();
    (0..words.len()).find_map(|i| metric(words[i], &words[i + 1..]).or_else(|| inch(words[i])))
}

fn metric(word: &str, next: &[&str]) -> Option<ThreadSize> {
    let (diameter, rest) = leading_number(word.strip_prefix('M')?)?;
    let believed = |pitch: f64| (pitch > 0.0 && pitch <= COARSEST * diameter).then_some(pitch);
    let pitch_of = |text: &str| {
        let (pitch, rest) = leading_number(text)?;
        // `M8-6H`: a class of tolerance.
        (!rest.starts_with(['H', 'G'])).then_some(pitch)
    };
    let named = match (rest.strip_prefix(['X', '-']), next) {
        (Some(""), [pitch, ..]) => pitch_of(pitch),
        (Some(pitch), _) => pitch_of(pitch),
        (None, ["X", pitch, ..]) if rest.is_empty() => pitch_of(pitch),
        (None, [pitch, ..]) if rest.is_empty() => pitch.strip_prefix('X').and_then(pitch_of),
        (None, _) if !rest.is_empty() => return None,
        (None, _) => None,
    };
    match named {
        Some(pitch) => Some(ThreadSize { diameter, pitch: believed(pitch)?, pitch_told: true }),
        None => Some(ThreadSize { diameter, pitch: coarse_pitch(diameter)?, pitch_told: false }),
    }
}

fn inch(word: &str) -> Option<ThreadSize> {
    let (size, pitch) = word.trim_start_matches('#').rsplit_once('-')?;
    let (per_inch, rest) = leading_number(pitch)?;
    // `03-0086` is the number of an article.
    if [size, pitch].iter().any(|text| text.len() > 1 && text.starts_with('0')) {
        return None;
    }
    let series = rest.is_empty() || rest.starts_with("UN") || rest.starts_with("TAP");
    if !series || !THREADS_PER_INCH.contains(&per_inch) {
        return None;
    }
    let diameter = if size.chars().all(|c| c.is_ascii_digit()) && !size.is_empty() {
        let number: f64 = size.parse().ok()?;
        let numbered = number <= MOST_NUMBERED && per_inch >= COARSEST_NUMBERED;
        (if numbered { 0.060 + 0.013 * number } else { return None }) * INCH_MM
    } else {
        inches(size)? * INCH_MM
    };
    let pitch = INCH_MM / per_inch;
    (diameter > 0.0 && pitch <= COARSEST * diameter).then_some(ThreadSize { diameter, pitch, pitch_told: true })
}

/// `1/4`, `1-1/2`, `.250`.
fn inches(text: &str) -> Option<f64> {
    let (whole, part) = text.split_once('-').unwrap_or(("0", text));
    let whole: f64 = whole.parse().ok().filter(|w: &f64| w.fract() == 0.0 && (0.0..=8.0).contains(w))?;
    let part = match part.split_once('/') {
        Some((n, d)) => {
            let [n, d]: [f64; 2] = [n.parse().ok()?, d.parse().ok()?];
            (n > 0.0 && d > n).then_some(n / d)?
        }
        None => part.parse().ok().filter(|p| (0.0..8.0).contains(p))?,
    };
    Some(whole + part)
}

/// A leading number and the text after it.
fn leading_number(text: &str) -> Option<(f64, &str)> {
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let number: f64 = text[..end].parse().ok()?;
    number.is_finite().then_some((number, &text[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_read_as_shops_write_them() {
        let cases = [
            ("M8 TAP", Some((8.0, 1.25, false))),
            ("M8X1.25 TAP", Some((8.0, 1.25, true))),
            ("T7 M6X1.0 TAP", Some((6.0, 1.0, true))),
            ("tap M10 x 1", Some((10.0, 1.0, true))),
            ("M10 X1 tap", Some((10.0, 1.0, true))),
            ("M8-1.25-6H", Some((8.0, 1.25, true))),
            ("M8-6H TAP", Some((8.0, 1.25, false))),
            ("GEWINDE_M8", Some((8.0, 1.25, false))),
            ("M8\u{d7}1", Some((8.0, 1.0, true))),
            ("10-32 TAP", Some((4.826, 25.4 / 32.0, true))),
            ("#8-32", Some((0.164 * 25.4, 25.4 / 32.0, true))),
            ("1/4-20UNC", Some((6.35, 1.27, true))),
            ("1-1/2-12 TAP", Some((38.1, 25.4 / 12.0, true))),
            (".250-20 TAP", Some((6.35, 1.27, true))),
            ("M8X20 SCREW", None),
            ("M9 TAP", Some((9.0, 1.25, false))),
            ("M11", Some((11.0, 1.5, false))),
            ("M60", Some((60.0, 5.5, false))),
            ("M2.5", Some((2.5, 0.45, false))),
            ("M13 TAP", None),
            ("M0X1", None),
            ("M1e9X1", None),
            ("1-8", None),
            ("03-0086", None),
            ("M", None),
            ("TAP 8MM", None),
            ("", None),
        ];
        for (text, wanted) in cases {
            let found = thread_of(text);
            match (found, wanted) {
                (None, None) => {}
                (Some(t), Some((d, p, told))) => {
                    assert!((t.diameter - d).abs() < 1e-9 && (t.pitch - p).abs() < 1e-9, "{text}: {t:?}");
                    assert_eq!(t.pitch_told, told, "{text}");
                }
                _ => panic!("{text}: {found:?}"),
            }
        }
    }

    #[test]
    fn a_thread_has_the_core_of_iso_68() {
        let m8 = Thread::new(8.0, 1.25).expect("a thread");
        assert!((2.0 * m8.core_radius - 6.646_835).abs() < 1e-6, "{m8:?}");
        for (pitch, word) in [(0.0, "above 0"), (f64::NAN, "above 0"), (8.0, "no core")] {
            let error = Thread::new(8.0, pitch).expect_err("no thread");
            assert!(error.to_string().contains(word), "{pitch}: {error}");
        }
    }
}
