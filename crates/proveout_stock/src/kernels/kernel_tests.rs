//! The kernels against each other: the closed form and the translation must agree with the general sweep.

use proveout_geom::{Point, ToolPose, Vector};
use proveout_tool::{Profile, Segment};

use crate::{
    SweepMotion,
    kernels::lane_ball::BallPath,
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

fn ball() -> Profile {
    Profile::new(vec![Segment::Arc { center: [0.0, 3.0], radius: 3.0, from: [0.0, 0.0], to: [0.0, 6.0] }])
        .expect("a ball is convex")
}

fn bull() -> Profile {
    Profile::new(vec![
        line([0.0, 0.0], [2.0, 0.0]),
        Segment::Arc { center: [2.0, 2.0], radius: 2.0, from: [2.0, 0.0], to: [4.0, 2.0] },
        line([4.0, 2.0], [4.0, 15.0]),
        line([4.0, 15.0], [0.0, 15.0]),
    ])
    .expect("convex")
}

fn case(k: u32, turn: f64) -> (SweepMotion, RayLine) {
    let n = |salt: f64| number(k, salt);
    let axis = Vector::new(n(1.0), n(2.0), 1.0).normalize();
    let to = (axis + Vector::new(n(3.0), n(4.0), n(5.0)) * turn).normalize();
    let tip = Point::new(n(6.0), n(7.0), n(8.0));
    let travel = Vector::new(n(9.0), n(10.0), n(11.0)) * 4.0;
    let motion = SweepMotion { from: ToolPose { tip, axis }, to: ToolPose { tip: tip + travel, axis: to } };
    (motion, RayLine { u: 4.0 * n(12.0), v: 4.0 * n(13.0), lo: -30.0, hi: 30.0 })
}

/// Two ends at most as far apart as the bound, longer where the ray grazes.
fn agree(a: &[TakenInterval], b: &[TakenInterval], bound: f64, what: &str) {
    let hull = |t: &[TakenInterval]| {
        t.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), t| (t.lo.s.min(lo), t.hi.s.max(hi)))
    };
    let (a_hull, b_hull) = (hull(a), hull(b));
    if a.is_empty() || b.is_empty() {
        let other = if a.is_empty() { b_hull } else { a_hull };
        // A chord that one misses is shallow: on these bodies of at least 2 mm radius depth is length^2 / 16
        // or more.
        assert!(
            a.is_empty() == b.is_empty() || (other.1 - other.0).powi(2) / 16.0 < 4.0 * bound,
            "{what}: {a:?} {b:?}"
        );
        return;
    }
    // At 1 degree to the surface the bound of 0.4 micrometers is 0.02 mm long.
    assert!((a_hull.0 - b_hull.0).abs() < 0.02 && (a_hull.1 - b_hull.1).abs() < 0.02, "{what}: {a_hull:?} {b_hull:?}");
}

#[test]
fn the_closed_form_of_the_ball_agrees_with_both_searches() {
    let (profile, bound) = (ball(), SEARCH_ERROR + TURN_ERROR);
    let (split, whole) = (Meridian::split(&profile), Meridian::whole(&profile));
    let [z, radius] = split.ball.expect("a ball is a ball");
    let mut met = 0;
    for k in 0..3000 {
        let turn = if k % 2 == 0 { 0.0 } else { 0.02 };
        let (motion, ray) = case(k, turn);
        let closed: Vec<TakenInterval> = ball_pieces(&motion, z)
            .iter()
            .filter_map(|p| sweep_ball(&BallPath::new(&permuted(p, 0), z, radius), &ray))
            .collect();
        let mut general = Vec::new();
        for p in pieces(&motion, whole.radius) {
            if turn == 0.0 {
                general.extend(sweep_translation(&permuted(&p, 0), &whole, &ray));
            }
            sweep_turning(&permuted(&p, 0), &whole, &ray, &mut general);
        }
        met += usize::from(!closed.is_empty());
        agree(&closed, &general, bound, "ball");
        if let ([a], [b, ..]) = (&closed[..], &general[..])
            && turn == 0.0
        {
            // The search ends on the skin: exact to second order in time, and in its own bound.
            assert!((a.hi.s - b.hi.s).abs() <= 1e-3_f64.max(2.0 * SEARCH_ERROR), "{a:?} {b:?}");
            assert!(a.hi.s - b.hi.s > -1e-6, "nothing outside of the swept ball is removed");
        }
    }
    assert!(met > 800);
}

#[test]
fn translation_is_the_limit_of_a_small_turn() {
    let whole = Meridian::whole(&bull());
    let mut met = 0;
    for k in 0..3000 {
        let (motion, ray) = case(k, 0.0);
        let straight: Vec<MotionPiece> = pieces(&motion, whole.radius);
        assert_eq!(straight.len(), 1);
        let exact: Vec<TakenInterval> =
            sweep_translation(&permuted(&straight[0], 0), &whole, &ray).into_iter().collect();
        let mut general = Vec::new();
        sweep_turning(&permuted(&straight[0], 0), &whole, &ray, &mut general);
        agree(&exact, &general, SEARCH_ERROR + TURN_ERROR, "no turn");
        let (turning, _) = case(k, 1e-9);
        let mut turned = Vec::new();
        for p in pieces(&turning, whole.radius) {
            sweep_turning(&permuted(&p, 0), &whole, &ray, &mut turned);
        }
        agree(&exact, &turned, SEARCH_ERROR + TURN_ERROR, "small turn");
        met += usize::from(!exact.is_empty());
    }
    assert!(met > 800);
}
