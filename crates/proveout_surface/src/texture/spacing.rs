//! Mean spacing of profile elements, `RSm`, by segmentation at the mean line.
//!
//! A hill or dale counts when it leaves the mean line by a tenth of Rz and is at least a hundredth of a
//! section wide (the usual discrimination). Those that do not count belong to what is around them; neighbors
//! of one kind are one. Between a hill and a dale that count, the profile crosses the line once, or several
//! times where small ones lie between: the middle of the first and the last of these crossings is taken.
//! Elements are measured between crossings two apart, those that rise and those that fall alike, so that a
//! profile read backwards gives the same value (the text of ISO 4287 leaves this open; ISO 16610-45:2025 asks
//! for it).

/// Share of Rz that a hill or dale must reach.
const HEIGHT_SHARE: f64 = 0.1;
/// Share of a section that it must be wide.
const WIDTH_SHARE: f64 = 0.01;
/// A profile with less Rz is flat, mm: a tenth of a nanometer, ten times what a height may be off where
/// cutters turn, has no pitch.
pub(super) const FLAT: f64 = 1e-7;

struct Feature {
    hill: bool,
    from: f64,
    to: f64,
}

/// `RSm`, mm; none where no element lies in the profile, or where it is flat to rounding.
pub(super) fn mean_spacing(z: &[f64], step: f64, rz: f64, section: f64) -> Option<f64> {
    if rz <= FLAT {
        return None;
    }
    let crossings = crossings(&features(z, step, HEIGHT_SHARE * rz, WIDTH_SHARE * section));
    let elements = crossings.len().checked_sub(2)?;
    (elements > 0).then(|| (0..elements).map(|i| crossings[i + 2] - crossings[i]).sum::<f64>() / elements as f64)
}

/// Hills and dales that count, merged where neighbors are of one kind.
fn features(z: &[f64], step: f64, min_height: f64, min_width: f64) -> Vec<Feature> {
    let mut found: Vec<Feature> = Vec::new();
    let last = z.len() - 1;
    let mut begin = 0.0;
    let mut extreme = 0.0_f64;
    for i in 0..=last {
        extreme = extreme.max(z[i].abs());
        let ends = i == last || (z[i] >= 0.0) != (z[i + 1] >= 0.0);
        if !ends {
            continue;
        }
        let to = if i == last { last as f64 } else { i as f64 + z[i] / (z[i] - z[i + 1]) };
        // What the ends of the profile cut off may be narrower than it is.
        let wide = (to - begin) * step >= min_width || begin == 0.0 || i == last;
        if extreme >= min_height && wide {
            let hill = z[i] >= 0.0;
            match found.last_mut() {
                Some(before) if before.hill == hill => before.to = to * step,
                _ => found.push(Feature { hill, from: begin * step, to: to * step }),
            }
        }
        begin = to;
        extreme = 0.0;
    }
    found
}

fn crossings(features: &[Feature]) -> Vec<f64> {
    features.windows(2).map(|w| 0.5 * (w[0].to + w[1].from)).collect()
}
