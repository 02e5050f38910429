//! Items made ready for a pass: the steps of their motion in the coordinates of each ray set.

use proveout_geom::Aabb;
use pulp::Arch;

use crate::{
    field::engagement::PassMotions,
    field::span::EndMark,
    kernels::lane_ball::BallPath,
    kernels::meridian::{Meridian, TOUCH},
    kernels::motion::{self, MotionPiece, SEARCH_ERROR, TURN_ERROR},
    kernels::ray::{RayLine, swept_normal},
    kernels::sweep_step::SweepStep,
    kernels::vec3::{V, norm},
    sweep_item::SweepItem,
};

/// An item made ready.
pub(crate) struct ReadyItem {
    pub body: usize,
    pub id: u32,
    pub removes: bool,
    /// What it takes up is wanted, to measure its depth.
    pub measured: bool,
    /// Box of the motion, mm.
    pub region: Aabb,
    /// Its steps, in [`Batch::steps`].
    pub steps: std::ops::Range<usize>,
}

/// A part of a program that one pass carries out.
pub(crate) struct Batch<'a> {
    pub ready: Vec<ReadyItem>,
    pub steps: [Vec<SweepStep>; 3],
    pub bodies: &'a [Meridian],
    /// The instructions of this processor.
    pub arch: Arch,
    /// The motions again, when engagement is asked for.
    pub moves: Option<PassMotions>,
}

/// What one item is made of, and the bound of its error, mm.
pub(crate) struct Split {
    steps: Vec<(MotionPiece, bool, Aabb)>,
    region: Aabb,
    pub bound: f64,
}

impl Split {
    pub(crate) fn of(item: &SweepItem<'_>, body: &Meridian, bounds: &Aabb) -> Self {
        let mut steps = Vec::new();
        let mut region = Aabb::empty();
        let mut bound = SEARCH_ERROR + 2.0 * TOUCH;
        if motion::stays_outside(&item.motion, body, bounds) {
            return Self { steps, region, bound };
        }
        if let Some([z, _]) = body.ball {
            for piece in motion::ball_pieces(&item.motion, z) {
                let area = motion::ball_box(&piece, body);
                region = region.union(&area);
                steps.push((piece, true, area));
            }
        }
        if body.has_rest {
            for piece in motion::pieces(&item.motion, body.radius) {
                // Smaller as the body is, so that its flat faces lie on the box.
                let area = motion::swept_box(&piece, body, bounds).expanded(-TOUCH);
                if area.is_empty() {
                    continue;
                }
                region = region.union(&area);
                steps.push((piece, false, area));
            }
        }
        if steps.iter().any(|s| s.0.turns()) {
            // The chord of the axis lags the uniform turn.
            let lag = steps.iter().filter(|s| !s.1).map(|s| s.0.lag(body.reach)).fold(0.0, f64::max);
            bound += TURN_ERROR + lag;
        }
        Self { steps, region, bound }
    }
}

impl<'a> Batch<'a> {
    /// `bounds`: box of the stock; what moves outside of it is not worked out.
    pub(crate) fn new(
        items: &[SweepItem<'_>],
        index: &[usize],
        split: &[Split],
        bodies: &'a [Meridian],
        bounds: &Aabb,
    ) -> Self {
        let mut ready = Vec::with_capacity(items.len());
        let mut steps: [Vec<SweepStep>; 3] = [Vec::new(), Vec::new(), Vec::new()];
        for (k, ((item, &body), split)) in items.iter().zip(index).zip(split).enumerate() {
            let first = steps[0].len();
            let meets = (0..3).all(|i| split.region.min[i] < bounds.max[i] && split.region.max[i] > bounds.min[i]);
            for (a, list) in steps.iter_mut().enumerate().filter(|_| meets) {
                for (piece, ball, area) in &split.steps {
                    let piece = motion::permuted(piece, a);
                    let axes = [a, (a + 1) % 3, (a + 2) % 3];
                    let ball = bodies[body].ball.filter(|_| *ball).map(|[z, r]| BallPath::new(&piece, z, r));
                    let (low, high) = (axes.map(|i| area.min[i]), axes.map(|i| area.max[i]));
                    list.push(SweepStep::new(piece, ball, [low, high], k as u32, &bodies[body]));
                }
            }
            ready.push(ReadyItem {
                body,
                id: item.id,
                removes: item.action == crate::Action::Remove,
                measured: false,
                region: split.region,
                steps: first..steps[0].len(),
            });
        }
        Self { ready, steps, bodies, arch: Arch::new(), moves: None }
    }

    /// Mark of an end of the material at `s` on a ray of set `a`, which a step made at the time `tau`; `sign`
    /// 1: with the upper end of its interval.
    pub(crate) fn mark(&self, a: usize, by: f64, [s, u, v]: V, tau: f64, sign: f64) -> EndMark {
        let Some(step) = self.steps[a].get(by as usize) else { return EndMark::NONE };
        let ready = &self.ready[step.item as usize];
        let n = if let Some(path) = &step.ball {
            let n = [0, 1, 2].map(|i| [s, u, v][i] - (path.start[i] + tau * path.way[i]));
            let length = norm(n);
            n.map(|x| x / length)
        } else {
            let body = &self.bodies[ready.body];
            let sample = step.piece.sample(body, [s, u, v], tau);
            let way = norm(step.piece.travel) + step.piece.angle2.sqrt() * body.reach;
            let ray = RayLine { u, v, lo: f64::NEG_INFINITY, hi: f64::INFINITY };
            swept_normal(&step.piece, body, &ray, (s, tau), sign, &sample, way)
        };
        // The material's outward normal is against the body's.
        let mut world = [0.0; 3];
        for i in 0..3 {
            world[(a + i) % 3] = -n[i];
        }
        EndMark::new(ready.id, world)
    }
}
