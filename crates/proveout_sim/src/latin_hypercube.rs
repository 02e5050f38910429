//! Latin hypercubes: each range is cut into as many parts as there are draws, and each part is drawn from
//! once.

/// For each key its place in every draw, part of its range.
pub(crate) fn latin_hypercube(keys: usize, draws: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut state = seed;
    // Steele, Lea, Flood 2014: splitmix64.
    let mut random = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let one = |_| {
        let mut order: Vec<usize> = (0..draws).collect();
        for i in (1..draws).rev() {
            order.swap(i, ((i + 1) as f64 * random()) as usize);
        }
        order.into_iter().map(|place| (place as f64 + random()) / draws as f64).collect()
    };
    (0..keys).map(one).collect()
}
