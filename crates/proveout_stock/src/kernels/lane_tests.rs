//! The kernels for many rays against those for one, and against themselves on other processors.
#![allow(clippy::print_stdout, reason = "the share of proven lanes is worth seeing")]

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_tool::{Profile, Segment};
use pulp::{Arch, WithSimd};

use crate::{
    Action, SweepItem, SweepMotion,
    field::batch::{Batch, Split},
    kernels::lane_ball::{BallOnLanes, BallOnRows, BallPath},
    kernels::lane_bits::{ROW, lanes_of, rows_with},
    kernels::lane_blocks::{BlockCenters, BodyOnBlocks, measure_pair, rays_of},
    kernels::lane_body::BodyOnLanes,
    kernels::lane_set::{BLOCKS, LANES, LaneStrip, Lanes, Maker, OLD, TAKEN, UNPROVEN, WIDE},
    kernels::meridian::Meridian,
    kernels::motion::{MotionPiece, SEARCH_ERROR, TURN_ERROR, ball_pieces, permuted, pieces},
    kernels::ray::{RayLine, TakenInterval},
    kernels::ray_ball::sweep_ball,
    kernels::ray_translate::sweep_translation,
    kernels::ray_turn::sweep_turning,
};

fn number(k: u32, salt: f64) -> f64 {
    ((f64::from(k) * 12.9898 + salt * 78.233).sin() * 43758.5453).fract()
}

fn line(from: [f64; 2], to: [f64; 2]) -> Segment {
    Segment::Line { from, to }
}

fn bull(r: f64, c: f64) -> Profile {
    Profile::new(vec![
        line([0.0, 0.0], [r - c, 0.0]),
        Segment::Arc { center: [r - c, c], radius: c, from: [r - c, 0.0], to: [r, c] },
        line([r, c], [r, 40.0]),
        line([r, 40.0], [0.0, 40.0]),
    ])
    .expect("convex")
}

fn flat(r: f64) -> Profile {
    Profile::new(vec![line([0.0, 0.0], [r, 0.0]), line([r, 0.0], [r, 40.0]), line([r, 40.0], [0.0, 40.0])])
        .expect("convex")
}

fn ball() -> Profile {
    Profile::new(vec![
        Segment::Arc { center: [0.0, 4.0], radius: 4.0, from: [0.0, 0.0], to: [4.0, 4.0] },
        line([4.0, 4.0], [4.0, 40.0]),
        line([4.0, 40.0], [0.0, 40.0]),
    ])
    .expect("convex")
}

/// Finishing: half a millimeter along x, nearly upright, turning by `turn`.
fn motion(k: u32, turn: f64) -> SweepMotion {
    let n = |salt: f64| number(k, salt);
    let axis = Vector::new(0.3 * n(1.0), 0.3 * n(2.0), 1.0).normalize();
    let to = (axis + Vector::new(n(3.0), n(4.0), n(5.0)) * turn).normalize();
    let tip = Point::new(n(6.0), n(7.0), -1.5 + 0.3 * n(8.0));
    let travel = Vector::new(0.5, 0.1 * n(9.0), 0.1 * n(10.0));
    SweepMotion { from: ToolPose { tip, axis }, to: ToolPose { tip: tip + travel, axis: to } }
}

/// Rays of set `a` near the tip with material below z = 0.
fn rays(k: u32, a: usize) -> Lanes {
    let mut lanes = Lanes::default();
    for r in 0..LANES {
        let n = |salt: f64| number(k * 64 + r as u32, salt);
        let (u, v) = if a == 2 {
            (5.0 * n(12.0), 5.0 * n(13.0))
        } else if a == 0 {
            (5.0 * n(12.0), -2.0 * n(13.0).abs())
        } else {
            (-2.0 * n(12.0).abs(), 5.0 * n(13.0))
        };
        let (lo, hi) = if a == 2 { (-20.0, 0.0) } else { (6.0 * n(14.0), 20.0) };
        lanes.push(&LaneStrip { ray: r as u8, u, v, lo, hi, lo_by: OLD, hi_by: OLD, lo_tau: 0.0, hi_tau: 0.0 });
    }
    lanes
}

fn bits(l: &Lanes) -> Vec<[u64; 5]> {
    let row = |k: usize| [l.state[k], l.from[k], l.to[k], l.from_tau[k], l.to_tau[k]].map(f64::to_bits);
    (0..l.len()).map(row).collect()
}

/// Both ways to call a kernel must give the same bits; the result of one.
fn both(lanes: &Lanes, call: impl Fn(&mut Lanes, bool)) -> Lanes {
    let (mut wide, mut single) = (lanes.clone(), lanes.clone());
    call(&mut wide, true);
    call(&mut single, false);
    assert_eq!(bits(&wide), bits(&single), "the instructions of the processor must not change a bit");
    wide
}

struct Count {
    proven: usize,
    unproven: usize,
    met: usize,
}

/// Compares the lanes with the searches, which bound the error by themselves.
fn compare(profile: &Profile, turn: f64, rounds: u32) -> Count {
    let body = Meridian::whole(profile);
    let mut count = Count { proven: 0, unproven: 0, met: 0 };
    let bound = 2.0 * (SEARCH_ERROR + TURN_ERROR);
    for k in 0..rounds {
        let a = (k % 3) as usize;
        let start = rays(k, a);
        for whole in pieces(&motion(k, turn), body.radius) {
            let piece: MotionPiece = permuted(&whole, a);
            let lanes = both(&start, |lanes, wide| {
                let range = [-100.0, 100.0];
                let call = BodyOnLanes { piece: &piece, range, body: &body, maker: Maker::whole(0), steps: 9, lanes };
                if wide {
                    Arch::new().dispatch(call)
                } else {
                    call.with_simd(pulp::Scalar::new())
                };
            });
            for r in 0..lanes.len() {
                let ray = RayLine { u: lanes.u[r], v: lanes.v[r], lo: lanes.lo[r], hi: lanes.hi[r] };
                let mut taken: Vec<TakenInterval> = Vec::new();
                if piece.turns() {
                    sweep_turning(&piece, &body, &ray, &mut taken);
                } else {
                    taken.extend(sweep_translation(&piece, &body, &ray));
                }
                count.met += usize::from(!taken.is_empty());
                if lanes.state[r] == UNPROVEN {
                    count.unproven += 1;
                    continue;
                }
                count.proven += 1;
                let from = taken.iter().map(|t| t.lo.s).fold(f64::INFINITY, f64::min).max(ray.lo);
                let to = taken.iter().map(|t| t.hi.s).fold(f64::NEG_INFINITY, f64::max).min(ray.hi);
                if lanes.state[r] == TAKEN {
                    let (lane_from, lane_to) = (lanes.from[r].max(ray.lo), lanes.to[r].min(ray.hi));
                    let slope = |s: f64, tau: f64| piece.sample(&body, ray.at(s), tau).fs.abs().max(0.02);
                    let off = ((lane_from - from).abs() * slope(lane_from, lanes.from_tau[r]))
                        .max((lane_to - to).abs() * slope(lane_to, lanes.to_tau[r]));
                    // A chord through a body of 2 mm radius or more that one misses is shallow: depth =
                    // length^2 / 16.
                    let shallow = taken.is_empty() && (lane_to - lane_from).powi(2) / 16.0 < bound;
                    assert!(off < bound || shallow, "{profile:?} {piece:?} {ray:?}: {lane_from} {lane_to}, {taken:?}");
                } else {
                    assert!(
                        taken.is_empty() || (to - from).powi(2) / 16.0 < bound || to - from < 50.0 * bound,
                        "missed {profile:?} {piece:?} {ray:?}: {taken:?}"
                    );
                }
            }
        }
    }
    count
}

#[test]
fn lanes_agree_with_the_searches_and_most_are_proven() {
    for (name, profile, least) in
        [("bull", bull(5.0, 3.0), 0.9), ("bull", bull(4.0, 0.5), 0.7), ("flat", flat(5.0), 0.3)]
    {
        for turn in [0.0, 0.002, 0.011] {
            let c = compare(&profile, turn, 90);
            let share = c.proven as f64 / (c.proven + c.unproven) as f64;
            println!("{name} turn {turn}: proven {share:.4}, {} met, {} lanes", c.met, c.proven + c.unproven);
            assert!(c.met > 500, "the rays must meet the body");
            assert!(share > least, "{name} turn {turn}: only {share} proven");
        }
    }
}

#[test]
fn the_ball_on_lanes_is_the_closed_form() {
    let profile = ball();
    let body = Meridian::split(&profile);
    let [z, radius] = body.ball.expect("a ball end");
    let mut met = 0;
    for k in 0..300 {
        let a = (k % 3) as usize;
        let mut motion = motion(k, 0.011);
        if k % 7 == 0 {
            motion.to.tip = motion.from.tip + motion.from.axis * 0.5;
            motion.to.axis = motion.from.axis;
        }
        let start = rays(k, a);
        for whole in ball_pieces(&motion, z) {
            let path = BallPath::new(&permuted(&whole, a), z, radius);
            let lanes = both(&start, |lanes, wide| {
                let call = BallOnLanes { path: &path, maker: Maker::whole(0), lanes };
                if wide { Arch::new().dispatch(call) } else { call.with_simd(pulp::Scalar::new()) }
            });
            for r in 0..lanes.len() {
                let ray = RayLine { u: lanes.u[r], v: lanes.v[r], lo: lanes.lo[r], hi: lanes.hi[r] };
                let one = sweep_ball(&path, &ray);
                assert_eq!(one.is_some(), lanes.state[r] == TAKEN);
                if let Some(t) = one {
                    met += 1;
                    // Only the order of rounding differs.
                    assert!((t.lo.s - lanes.from[r]).abs() < 1e-9 && (t.hi.s - lanes.to[r]).abs() < 1e-9);
                    assert!((t.lo.tau - lanes.from_tau[r]).abs() < 1e-6 && (t.hi.tau - lanes.to_tau[r]).abs() < 1e-6);
                }
            }
        }
    }
    assert!(met > 2000);
}

/// Rays of a tile, their blocks and rows: material that varies from ray to ray, and rays without any.
fn tile(k: u32) -> (Lanes, BlockCenters, [[f64; BLOCKS]; 2], [[f64; WIDE]; 2]) {
    let (u0, v0) = (5.0 * number(k, 21.0), 5.0 * number(k, 22.0));
    let columns: [f64; ROW] = std::array::from_fn(|i| u0 + 0.1 * i as f64);
    let rows: [f64; ROW] = std::array::from_fn(|j| v0 + 0.15 * j as f64);
    let mut lanes = Lanes::default();
    let mut blocks = [[f64::INFINITY; BLOCKS], [f64::NEG_INFINITY; BLOCKS]];
    let mut of_rows = [[f64::INFINITY; WIDE], [f64::NEG_INFINITY; WIDE]];
    for r in 0..LANES {
        let (i, j) = (r % ROW, r / ROW);
        let n = |salt: f64| number(k * 64 + r as u32, salt);
        let (mut lo, mut hi) = (-6.0 + n(23.0), 6.0 * n(24.0));
        if n(25.0) > 0.9 || hi <= lo {
            (lo, hi) = (f64::INFINITY, f64::NEG_INFINITY);
        }
        let (u, v) = (columns[i], rows[j]);
        lanes.push(&LaneStrip { ray: r as u8, u, v, lo, hi, lo_by: OLD, hi_by: OLD, lo_tau: 0.0, hi_tau: 0.0 });
        of_rows[0][j] = of_rows[0][j].min(lo);
        of_rows[1][j] = of_rows[1][j].max(hi);
    }
    let [lo, hi] = &mut blocks;
    (0..ROW / 2).for_each(|pair| measure_pair(&lanes, pair, lo, hi));
    for r in 0..LANES {
        let b = (0..BLOCKS).find(|b| rays_of(1 << b) >> r & 1 == 1).expect("each ray lies in a block");
        assert!(!lanes.holds(r) || blocks[0][b] <= lanes.lo[r] && blocks[1][b] >= lanes.hi[r]);
    }
    (lanes, BlockCenters::new(&columns, &rows), blocks, of_rows)
}

#[test]
fn a_block_is_two_by_two_rays() {
    let all = (0..BLOCKS).fold(0_u64, |all, b| {
        let rays = rays_of(1 << b);
        assert_eq!(rays.count_ones(), 4);
        assert_eq!(all & rays, 0, "no ray lies in two blocks");
        let first = rays.trailing_zeros() as usize;
        assert_eq!(rays, 0x303 << first);
        assert_eq!((first % ROW / 2, first / ROW / 2), (b % (ROW / 2), b / (ROW / 2)));
        all | rays
    });
    assert_eq!(all, u64::MAX);
    assert_eq!(rays_of(0b1000_0000_0000_0001), 0x303 | 0x303 << 54);
    for rows in 0..=u8::MAX {
        let lanes = lanes_of(rows);
        assert!((0..LANES).all(|r| (lanes >> r & 1 == 1) == (rows >> (r / ROW) & 1 == 1)));
        assert_eq!(rows_with(lanes), rows);
    }
    assert!((0..LANES).all(|r| rows_with(1 << r) == 1 << (r / ROW)));
}

/// A block or row that is cleared must hold no ray that the searches find the body on.
#[test]
fn blocks_and_rows_that_are_cleared_are_not_met() {
    let (mut cleared, mut met) = (0, 0);
    for (profile, is_ball) in [(ball(), true), (bull(5.0, 3.0), false), (flat(5.0), false)] {
        let body = if is_ball { Meridian::split(&profile) } else { Meridian::whole(&profile) };
        for k in 0..600 {
            let a = (k % 3) as usize;
            let turn = [0.0, 0.011, 0.05][(k / 3 % 3) as usize];
            let (lanes, places, [lo, hi], [row_lo, row_hi]) = tile(k);
            let mut row_v = [0.0; WIDE];
            (0..ROW).for_each(|j| row_v[j] = lanes.v[j * ROW]);
            let items = [item(&profile, motion(k, turn))];
            let bodies = [body.clone()];
            let everywhere = Aabb { min: Point::new(-1e3, -1e3, -1e3), max: Point::new(1e3, 1e3, 1e3) };
            let split = Split::of(&items[0], &body, &everywhere);
            let batch = Batch::new(&items, &[0], &[split], &bodies, &everywhere);
            for step in &batch.steps[a] {
                let rows =
                    |path| BallOnRows { path, u: [lanes.u[0], lanes.u[ROW - 1]], v: &row_v, lo: &row_lo, hi: &row_hi };
                let blocks = || BodyOnBlocks { step, body: &body, places: &places, lo: &lo, hi: &hi };
                let rays = |wide: bool| match (&step.ball, wide) {
                    (Some(path), true) => lanes_of(Arch::new().dispatch(rows(path))),
                    (Some(path), false) => lanes_of(rows(path).with_simd(pulp::Scalar::new())),
                    (None, true) => rays_of(Arch::new().dispatch(blocks())),
                    (None, false) => rays_of(blocks().with_simd(pulp::Scalar::new())),
                };
                let found = rays(true);
                assert_eq!(found, rays(false), "the instructions of the processor must not change a bit");
                met += found.count_ones();
                for r in (0..LANES).filter(|&r| found >> r & 1 == 0 && lanes.holds(r)) {
                    cleared += 1;
                    let ray = RayLine { u: lanes.u[r], v: lanes.v[r], lo: lanes.lo[r], hi: lanes.hi[r] };
                    let mut taken: Vec<TakenInterval> = Vec::new();
                    match &step.ball {
                        Some(path) => taken.extend(sweep_ball(path, &ray)),
                        None => sweep_turning(&step.piece, &body, &ray, &mut taken),
                    }
                    // The search may take what the body misses by the bound of a turn.
                    let long = taken.iter().map(|t| t.hi.s.min(ray.hi) - t.lo.s.max(ray.lo)).fold(0.0, f64::max);
                    assert!(long < 1e-2, "{step:?} {ray:?} {taken:?}");
                }
            }
        }
    }
    assert!(cleared > 20_000 && met > 10_000, "{cleared} {met}");
}

/// A box that is cleared holds no point of the body at any time; most boxes half a millimeter away or more
/// are cleared.
#[test]
fn boxes_that_are_cleared_are_not_met_at_any_time() {
    let everywhere = Aabb { min: Point::new(-1e3, -1e3, -1e3), max: Point::new(1e3, 1e3, 1e3) };
    let (mut cleared, mut close, mut kept, mut far) = (0, 0, 0, 0);
    for (profile, is_ball) in [(bull(5.0, 3.0), false), (flat(5.0), false), (ball(), true)] {
        let body = if is_ball { Meridian::split(&profile) } else { Meridian::whole(&profile) };
        for k in 0..3000 {
            let n = |salt: f64| number(k, salt);
            let turn = [0.0, 0.011, 0.05, 0.3][(k / 3 % 4) as usize];
            let items = [item(&profile, motion(k, turn))];
            let split = Split::of(&items[0], &body, &everywhere);
            let batch = Batch::new(&items, &[0], &[split], std::slice::from_ref(&body), &everywhere);
            let middle = [6.0 * n(31.0), 6.0 * n(32.0), 4.0 * n(33.0) - 1.0];
            let half = [34.0, 35.0, 36.0].map(|salt| 0.02 + 0.4 * n(salt).abs());
            let a = (k % 3) as usize;
            let side = |i: usize| {
                let i = (a + i) % 3;
                [middle[i] - half[i], middle[i] + half[i]]
            };
            let [s, u, v] = [side(0), side(1), side(2)];
            for step in batch.steps[a].iter().filter(|step| step.ball.is_none()) {
                let mut least = f64::INFINITY;
                for place in 0..27 {
                    let at = |x: [f64; 2], i: usize| 0.5 * (x[0] * (2 - i) as f64 + x[1] * i as f64);
                    let x = [at(s, place % 3), at(u, place / 3 % 3), at(v, place / 9)];
                    for t in 0..=24 {
                        least = least.min(step.piece.sample(&body, x, f64::from(t) / 24.0).f);
                    }
                }
                if step.clears(&body, s, u, v) {
                    assert!(least > 0.0, "{step:?} {s:?} {u:?} {v:?}: {least}");
                    (cleared, close) = (cleared + 1, close + usize::from(least < 0.05));
                } else {
                    (kept, far) = (kept + 1, far + usize::from(least > 0.5));
                }
            }
        }
    }
    println!("{cleared} boxes cleared, {close} of them nearly met, {kept} kept, {far} of them far away");
    assert!(cleared > 3000 && close > 50 && far * 5 < cleared, "{cleared} {close} {kept} {far}");
}

fn item(body: &Profile, motion: SweepMotion) -> SweepItem<'_> {
    SweepItem { id: 0, body, action: Action::Remove, motion }
}
