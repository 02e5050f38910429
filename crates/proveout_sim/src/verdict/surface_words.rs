//! What was evaluated of the surface, in words.

use crate::verdict::verdict_file::Surface;

/// What is said of them.
pub(crate) const FLAT: &str = "no kinematic height along the path; teeth not modeled";

/// Heights that differ by less are shown as one, micrometers: half of the last of four decimals.
pub(crate) const ONE_FIGURE_UM: f64 = 5e-5;

/// Least and largest values of the places that were evaluated, in words; none where there are none.
pub(crate) fn evaluated(surface: &Surface) -> Option<String> {
    let textures = &surface.textures;
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        (low <= high).then_some([low, high])
    };
    let profiles = || textures.iter().flat_map(|t| &t.profiles);
    let all = [
        ("Sa", range(&mut textures.iter().filter_map(|t| t.sa_um))),
        ("Ra", range(&mut profiles().filter_map(|p| p.ra_um).flatten())),
        ("Rz", range(&mut profiles().filter_map(|p| p.rz_um).flatten())),
    ];
    let words = all.iter().filter_map(|(name, range)| {
        let [low, high] = (*range)?;
        let one = format!("{name} {low:.4} um");
        Some(if high - low < ONE_FIGURE_UM { one } else { format!("{name} {low:.4} to {high:.4} um") })
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() {
        return None;
    }
    let flat = textures.iter().any(|t| t.is_flat);
    let flat = if flat { format!("; {FLAT}") } else { String::new() };
    let places = if textures.len() == 1 { "1 place".to_owned() } else { format!("{} places", textures.len()) };
    Some(format!("{} at {places}{flat}", words.join(", ")))
}
