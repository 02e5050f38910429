//! Look-ahead: the fastest time law over a path whose cells limit speed, acceleration and jerk along the
//! path.
//!
//! The path is cut into cells; within a cell the limits V, A and J of the path parameter are constants that
//! were derived from the joints (see `limits.rs`), so that a law which keeps them keeps every joint limit.
//! What remains is one dimension:
//!
//! ```text
//!  v |      ______                       V of the cells (stairs)
//!    |     |  __  |______________        f: forward chain, may rise by ramps, may fall at once
//!    |     | /f \w|  ______      |       w: backward chain, the mirror image
//!    | ____|/    \|_/      \     |       law: min(f, w), the peak where f meets w cut by a seven-phase move
//!    |/                     \____|
//!    +----------------------------> s
//! ```
//!
//! 1. *Forward chain*, from left to right. From an anchor (cell border, speed, zero acceleration) the hardest
//!    acceleration (`max_speed_after`) is followed as long as it keeps below every V; rates are the smallest
//!    of the cells passed.
//!    From the first cell whose V it would pass, the lowest V since is the speed at which the ramp must end;
//!    the next anchor is the end of the cell where a ramp with zero final acceleration gets there. A cell
//!    with other rates may close the ramp before it begins, if that gives the higher speed after it. Where V
//!    falls, the chain falls at once.
//! 2. *Backward chain*: the same from right to left.
//! 3. *Join*. Anchors of f with f <= w and anchors of w with w <= f are the nodes of the law. A crossing of f
//!    and w lies between a node of f and a node of w; the ramps there are replaced by ramp, cruise and ramp.
//!    If the ramps do not fit, the higher of the two nodes is given up.
//!
//! f passes from above w to below it only where both are on the same V (f falls only onto V, and w
//! rises only from V), so nodes shared by both chains split the law into independent parts. There
//! it does not matter how much path the look-ahead knows, and a run without stops can be planned
//! window by window with the same result.
//!
//! The cost is linear in the number of cells: each is visited a bounded number of times by every pass.
//!
//! Limits of the method: acceleration is zero at anchors, so that a long stair of closely spaced V costs some
//! time, and a ramp takes the smallest rates of the cells that it passes. What that costs, `retime.rs` takes
//! back.

use crate::{
    jerk_ramp::{Rates, max_speed_after, peak_speed, ramp_distance, reach},
    profile::{Cursor, Law},
};

/// Limits along the path parameter within one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedCell {
    /// Length along the path parameter, above zero.
    pub(crate) length: f64,
    /// Highest speed V; finite.
    pub(crate) speed: f64,
    /// A and J.
    pub(crate) rates: Rates,
}

/// Two speeds (relative) that count as equal where the chains are compared: far above rounding, far below any
/// effect.
const SAME: f64 = 1e-9;
/// Speeds that differ by no more than this are equal near a standstill, where no part of them is.
const REST: f64 = 1e-12;

/// A stretch of a chain: ramp from `v[0]` at border `from`, then constant `v[1]` up to border `to`.
#[derive(Clone, Copy, Debug)]
struct ChainLeg {
    from: usize,
    to: usize,
    v: [f64; 2],
    rates: Rates,
}

/// Forward chain over `cells`; `s` are the borders measured in the direction of the walk.
fn chain(cells: impl Fn(usize) -> SpeedCell, s: &dyn Fn(usize) -> f64, n: usize, v_start: f64) -> Vec<ChainLeg> {
    let mut legs: Vec<ChainLeg> = Vec::new();
    let (mut from, mut v, mut rates) = (0_usize, v_start, Rates::FREE);
    // Lowest V since the hardest acceleration could pass one: the speed at which the ramp under way must end.
    let mut ceiling = f64::INFINITY;
    let mut k = 0;
    while k < n {
        let cell = cells(k);
        if k == from {
            v = v.min(cell.speed);
            rates = Rates::FREE;
            ceiling = f64::INFINITY;
        }
        let (d0, d1) = (s(k) - s(from), s(k + 1) - s(from));
        let joint = rates.min(cell.rates);
        if k > from {
            let at_border = reach(v, d0, rates);
            let close_before = at_border >= cell.speed
                || (rates != cell.rates
                    && reach(at_border.min(cell.speed), cell.length, cell.rates).min(cell.speed)
                        > reach(v, d1, joint).min(cell.speed) * (1.0 + SAME));
            if close_before {
                legs.push(ChainLeg { from, to: k, v: [v, at_border], rates });
                from = k;
                v = at_border;
                continue;
            }
        }
        rates = joint;
        if ceiling.is_finite() || max_speed_after(v, d1, rates) > cell.speed {
            ceiling = ceiling.min(cell.speed);
            if reach(v, d1, rates) >= ceiling {
                legs.push(ChainLeg { from, to: k + 1, v: [v, ceiling], rates });
                from = k + 1;
                v = ceiling;
            }
        }
        k += 1;
    }
    if from < n {
        let end = reach(v, s(n) - s(from), rates);
        legs.push(ChainLeg { from, to: n, v: [v, end], rates });
    }
    legs
}

/// Speed of a chain's leg at a distance after its anchor: on the ramp or on the plateau.
fn leg_speed(leg: &ChainLeg, distance: f64) -> f64 {
    let d = ramp_distance(leg.v[0], leg.v[1], leg.rates);
    if distance >= d {
        return leg.v[1];
    }
    // The first half of the ramp is `max_speed_after`; the second half is its point reflection in time.
    // Its speed is found by bisection in time over the phases.
    let mut law = Law::default();
    law.push_move([0.0, d], [leg.v[0], leg.v[1], leg.v[1]], leg.rates, leg.rates);
    let mut cursor = Cursor::default();
    let t = law.time_at(distance, &mut cursor);
    law.at(t, &mut cursor).v
}

/// A point of the law with zero acceleration at a cell border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedNode {
    /// Border: 0 is the start of the first cell.
    pub(crate) border: usize,
    /// Speed.
    pub(crate) speed: f64,
    /// True if both chains share this node: the path after it does not affect the path before it,
    /// nor the reverse.
    pub(crate) shared: bool,
    leg_out: Option<usize>,
    leg_in: Option<usize>,
}

impl SpeedNode {
    /// Standstill at the end of the last of `cells` cells.
    pub(crate) fn end(cells: usize) -> Self {
        Self { border: cells, speed: 0.0, shared: true, leg_out: None, leg_in: None }
    }
}

/// Ramp, cruise and ramp between two nodes.
#[derive(Clone, Copy, Debug)]
struct NodeLink {
    ceiling: f64,
    up: Rates,
    down: Rates,
}

/// A planned stretch.
#[derive(Clone, Debug, Default)]
pub(crate) struct SpeedPlan {
    nodes: Vec<SpeedNode>,
    links: Vec<NodeLink>,
}

impl SpeedPlan {
    /// Plans from speed `v_start` at the start of the first cell to speed `v_end` at the end of the last,
    /// both with zero acceleration. `borders` has one entry more than `cells`.
    pub(crate) fn new(cells: &[SpeedCell], borders: &[f64], [v_start, v_end]: [f64; 2]) -> Self {
        let n = cells.len();
        if n == 0 {
            return Self::default();
        }
        let forward = chain(|k| cells[k], &|k| borders[k], n, v_start);
        let mirrored = chain(|k| cells[n - 1 - k], &|k| borders[n] - borders[n - k], n, v_end);
        // The mirrored legs in the sense of travel: plateau at v[0] from `from`, then ramp down to v[1] at
        // `to`.
        let backward: Vec<ChainLeg> = mirrored
            .iter()
            .rev()
            .map(|l| ChainLeg { from: n - l.to, to: n - l.from, v: [l.v[1], l.v[0]], rates: l.rates })
            .collect();
        let nodes = nodes(&forward, &backward, borders, [v_start, v_end]);
        join(&nodes, &forward, &backward, borders)
    }

    /// Last node that splits the plan into independent parts, at or before `border`, and not the first node.
    pub(crate) fn split_before(&self, border: usize) -> Option<SpeedNode> {
        self.nodes.iter().skip(1).rev().find(|n| n.shared && n.border <= border).copied()
    }

    /// The time law up to `border`, which must be that of a node; s counts from the start of the first cell.
    pub(crate) fn law(&self, borders: &[f64], border: usize) -> Law {
        let mut law = Law::default();
        for (pair, link) in self.nodes.windows(2).zip(&self.links) {
            if pair[1].border > border {
                break;
            }
            let s = [borders[pair[0].border], borders[pair[1].border]];
            let (v0, v1) = (pair[0].speed, pair[1].speed);
            let peak = peak_speed(v0, v1, s[1] - s[0], link.ceiling, link.up, link.down);
            law.push_move(s, [v0, peak, v1], link.up, link.down);
        }
        law
    }
}

/// Nodes of min(f, w), in the order of the path.
fn nodes(forward: &[ChainLeg], backward: &[ChainLeg], borders: &[f64], [v_start, v_end]: [f64; 2]) -> Vec<SpeedNode> {
    let last = borders.len() - 1;
    let mut nodes: Vec<SpeedNode> = Vec::with_capacity(forward.len() + backward.len());
    let (mut i, mut k) = (0, 0); // leg of f that leaves, leg of w that arrives behind, the border under view
    let mut border = 0;
    loop {
        while i + 1 < forward.len() && forward[i + 1].from <= border {
            i += 1;
        }
        while k + 1 < backward.len() && backward[k].to <= border {
            k += 1;
        }
        let (f, w) = (&forward[i], &backward[k]);
        let on_f = f.from == border;
        // w has an anchor at its low ends: at the end of each leg, which is where the next leg begins.
        let on_w = w.from == border && border > 0;
        let f_speed = if border == last { v_end } else { leg_speed(f, borders[border] - borders[f.from]) };
        // Mirror image: distance past the anchor at the end of the leg.
        let w_speed = if border == last {
            v_end
        } else {
            let mirrored = ChainLeg { v: [w.v[1], w.v[0]], ..*w };
            let ahead = leg_speed(&mirrored, borders[w.to] - borders[border]);
            // At a border between two legs of w, the lower of both sides is the speed of w.
            if on_w && k > 0 { ahead.min(backward[k - 1].v[1]) } else { ahead }
        };
        let first = border == 0;
        let f_low = f_speed <= w_speed * (1.0 + SAME) + REST;
        let w_low = w_speed <= f_speed * (1.0 + SAME) + REST;
        if first || border == last || (on_f && f_low) || (on_w && w_low) {
            let speed = if first { v_start } else { f_speed.min(w_speed) };
            let takes_f = first || (on_f && f_low);
            let takes_w = border == last || (on_w && w_low);
            nodes.push(SpeedNode {
                border,
                speed,
                shared: first || border == last || (on_f && on_w && f_low && w_low),
                leg_out: takes_f.then_some(i),
                leg_in: takes_w.then(|| if border == last { backward.len() - 1 } else { k.saturating_sub(1) }),
            });
        }
        if border == last {
            return nodes;
        }
        let next_f = forward.get(i + 1).map_or(last, |l| l.from);
        let next_w = if w.to > border { w.to } else { last };
        border = next_f.min(next_w).max(border + 1);
    }
}

/// Connects the nodes; gives up the higher of two nodes whose ramps do not fit between them.
fn join(nodes: &[SpeedNode], forward: &[ChainLeg], backward: &[ChainLeg], borders: &[f64]) -> SpeedPlan {
    let mut kept: Vec<SpeedNode> = Vec::with_capacity(nodes.len());
    let mut links: Vec<NodeLink> = Vec::with_capacity(nodes.len());
    let mut iter = nodes.iter().copied();
    let Some(first) = iter.next() else { return SpeedPlan::default() };
    kept.push(first);
    let mut extra = NodeLink { ceiling: f64::INFINITY, up: Rates::FREE, down: Rates::FREE };
    let rest: Vec<SpeedNode> = iter.collect();
    let mut r = 0;
    while r < rest.len() {
        let (left, right) = (kept[kept.len() - 1], rest[r]);
        let link = merge(direct_link(&left, &right, forward, backward), extra);
        let distance = (borders[right.border] - borders[left.border]) * (1.0 + SAME);
        let fits = if left.speed <= right.speed {
            ramp_distance(left.speed, right.speed, link.up) <= distance
        } else {
            ramp_distance(right.speed, left.speed, link.down) <= distance
        };
        if fits || (left.shared && right.shared) {
            kept.push(right);
            links.push(link);
            extra = NodeLink { ceiling: f64::INFINITY, up: Rates::FREE, down: Rates::FREE };
            r += 1;
        } else if left.speed <= right.speed && !right.shared {
            extra = NodeLink { ceiling: link.ceiling.min(right.speed), up: link.up, down: link.down };
            r += 1;
        } else if !left.shared && kept.len() > 1 {
            kept.pop();
            let before = links.pop().unwrap_or(link);
            extra = NodeLink {
                ceiling: link.ceiling.min(left.speed),
                up: link.up.min(before.up),
                down: link.down.min(before.down),
            };
        } else {
            // Only rounding leads here: the ramp is compressed by a few parts in 1e9.
            kept.push(right);
            links.push(link);
            extra = NodeLink { ceiling: f64::INFINITY, up: Rates::FREE, down: Rates::FREE };
            r += 1;
        }
    }
    SpeedPlan { nodes: kept, links }
}

fn merge(a: NodeLink, b: NodeLink) -> NodeLink {
    NodeLink { ceiling: a.ceiling.min(b.ceiling), up: a.up.min(b.up), down: a.down.min(b.down) }
}

/// The link between two neighboring nodes, from the legs that leave the left one and arrive at the right one.
fn direct_link(left: &SpeedNode, right: &SpeedNode, forward: &[ChainLeg], backward: &[ChainLeg]) -> NodeLink {
    let up = left.leg_out.map(|i| &forward[i]);
    let down = right.leg_in.map(|k| &backward[k]);
    let floor = left.speed.max(right.speed);
    match (up, down) {
        (Some(f), Some(w)) => NodeLink { ceiling: f.v[1].min(w.v[0]).max(floor), up: f.rates, down: w.rates },
        (Some(f), None) => NodeLink { ceiling: f.v[1].max(floor), up: f.rates, down: f.rates },
        (None, Some(w)) => NodeLink { ceiling: w.v[0].max(floor), up: w.rates, down: w.rates },
        (None, None) => NodeLink { ceiling: floor, up: Rates::FREE, down: Rates::FREE },
    }
}
