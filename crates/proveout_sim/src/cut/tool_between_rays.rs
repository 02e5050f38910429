//! What the rays of the stock do not see of the tool, decided on the raw stock's form and the cuts
//! themselves.
//!
//! After a stretch is cut, every sweep that must not meet material and of which no ray said so is asked again
//! ([`BetweenRays`]): first all of them at once against the stock before the stretch (material only goes
//! away), then those that are in doubt one by one, each against the stock as it stood when it came. Cuts in
//! feed with the spindle on are taken into the true stock as they come; a motion in which the cutter must not
//! cut is taken in only where it was found to do so, so that a run of such motions is judged against the
//! stock before it.

use std::{collections::BTreeMap, sync::Arc};

use proveout_controller::Piece;
use proveout_geom::Aabb;
use proveout_stock::{BetweenFound, BetweenRays, Measure, SweepItem, SweepReport};
use proveout_tool::{Profile, Role, Tool};

use crate::{
    checks::descent,
    cut::tool_sweeps::{self, CuttingState, SweepPart, Sweeps, Swept},
    verdict::gate::Gate,
};

/// Work of a whole run after which nothing more is searched: distances.
const MOST_WORK: u64 = 150_000_000;
/// Places of one part of a tool that stay open, after which the part is not looked at any more.
const MOST_OPEN: u32 = 16;

/// Which gate a part of the tool belongs to.
fn gate_of(what: Swept) -> Gate {
    match what {
        Swept::Zone => Gate::NearMiss,
        Swept::Body(Role::Holder) => Gate::Collision,
        _ => Gate::Process,
    }
}

/// Where it is not known whether a part of a tool meets material.
#[derive(Clone, Copy, Debug)]
struct Open {
    what: Swept,
    block: u32,
    point: [f64; 3],
    size: f64,
    more: u32,
}

/// Looks between the rays, over a whole run.
#[derive(Debug)]
pub(crate) struct BetweenWatch {
    store: BetweenRays,
    open: BTreeMap<(Gate, usize, u8), Open>,
    /// Parts that have come off so far.
    gone: usize,
}

/// What the gates say of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct BetweenFacts {
    /// What is not known, by gate.
    pub(crate) left_out: BTreeMap<Gate, Vec<String>>,
}

fn number(what: Swept) -> u8 {
    match what {
        Swept::Body(Role::Cutting) => 0,
        Swept::Body(Role::Neck) => 1,
        Swept::Body(Role::Shank) => 2,
        Swept::Body(Role::Holder) => 3,
        Swept::Zone => 4,
        Swept::Core => 5,
        Swept::Entry => 6,
    }
}

impl BetweenWatch {
    pub(crate) fn new(store: BetweenRays) -> Self {
        Self { store, open: BTreeMap::new(), gone: 0 }
    }

    /// Boxes of the parts that were taken away so far.
    pub(crate) fn parts_are_gone(&mut self, bounds: &[Aabb]) {
        for b in bounds.get(self.gone..).unwrap_or(&[]) {
            self.store.part_is_gone(b);
        }
        self.gone = self.gone.max(bounds.len());
    }

    /// Looks at the sweeps of a stretch and writes into their reports what the rays have not seen; gives the
    /// numbers of those reports. `cell` is the longest edge of a cell of the stock, mm.
    pub(crate) fn look(
        &mut self,
        sweeps: &Sweeps<'_>,
        reports: &mut [SweepReport],
        pieces: &[Piece],
        states: &[CuttingState],
        [contact, cell]: [f64; 2],
    ) -> Vec<usize> {
        let barred = |k: usize| matches!(sweeps.measures[k], Measure::Since(_));
        let asks = |k: usize, report: &SweepReport| match sweeps.parts[k].what {
            Swept::Core => false,
            Swept::Body(Role::Cutting) if !barred(k) => false,
            _ => tool_sweeps::depth(report) <= contact,
        };
        let asked: Vec<usize> = (0..sweeps.items.len()).filter(|k| asks(*k, &reports[*k])).collect();
        let many: Vec<(&Profile, _)> = asked.iter().map(|k| (sweeps.items[*k].body, sweeps.items[*k].motion)).collect();
        let mut doubtful = vec![false; sweeps.items.len()];
        if self.store.work() < MOST_WORK {
            for (k, doubt) in asked.iter().zip(self.store.in_doubt(&many, contact)) {
                doubtful[*k] = doubt;
            }
        } else {
            asked.iter().for_each(|k| doubtful[*k] = true);
        }
        let mut found = Vec::new();
        let mut first = 0;
        while first < sweeps.parts.len() {
            let piece = sweeps.parts[first].piece;
            let next = first + sweeps.parts[first..].iter().take_while(|p| p.piece == piece).count();
            let at = (piece, pieces[piece].block, states[piece].tool.unwrap_or_default());
            let range = Range { items: &sweeps.items[first..next], parts: &sweeps.parts[first..next], at };
            self.look_at_piece(&range, first, reports, (&doubtful, &barred), [contact, cell], &mut found);
            first = next;
        }
        found
    }

    fn look_at_piece(
        &mut self,
        range: &Range<'_, '_>,
        first: usize,
        reports: &mut [SweepReport],
        (doubtful, barred): (&[bool], &dyn Fn(usize) -> bool),
        [contact, cell]: [f64; 2],
        found: &mut Vec<usize>,
    ) {
        let mut cut = false;
        for (i, (item, part)) in range.items.iter().zip(range.parts).enumerate() {
            let k = first + i;
            if part.what == Swept::Core {
                self.look_at_core(range, item, &mut reports[k], cell);
                continue;
            }
            let cuts = part.what == Swept::Body(Role::Cutting);
            if cuts && !barred(k) {
                if !cut {
                    self.cut(range);
                    cut = true;
                }
                continue;
            }
            let mut meets = tool_sweeps::depth(&reports[k]) > contact;
            if doubtful[k] {
                match self.decide(range, item, part.what, contact) {
                    BetweenFound::Clear => {}
                    BetweenFound::Material { point, depth_mm } => {
                        (reports[k].depth_mm, reports[k].first_point) = (Some(depth_mm), Some(point));
                        found.push(k);
                        meets = true;
                    }
                    BetweenFound::Open { point, size_mm } => {
                        self.leave_open(range, part.what, point.into(), size_mm);
                        meets = true;
                    }
                }
            }
            if cuts && meets && !cut {
                // The rest of the cutter is looked at as well: it is cut once its last body has been.
                cut = range.parts[i + 1..].iter().all(|p| p.what != Swept::Body(Role::Cutting));
                if cut {
                    self.cut(range);
                }
            }
        }
    }

    fn cut(&mut self, range: &Range<'_, '_>) {
        let bodies = range.parts.iter().zip(range.items).filter(|(p, _)| p.what == Swept::Body(Role::Cutting));
        let bodies: Vec<&SweepItem<'_>> = bodies.map(|(_, item)| item).collect();
        if let Some(first) = bodies.first() {
            self.store.cut(bodies.iter().map(|item| item.body), &first.motion);
        }
    }

    fn decide(&mut self, range: &Range<'_, '_>, item: &SweepItem<'_>, what: Swept, contact: f64) -> BetweenFound {
        let known = self.open.get(&(gate_of(what), range.at.2, number(what)));
        if known.is_some_and(|o| o.more >= MOST_OPEN) || self.store.work() >= MOST_WORK {
            return BetweenFound::Open { point: item.motion.from.tip, size_mm: item.body.max_radius() };
        }
        self.store.look(item.body, &item.motion, contact)
    }

    fn leave_open(&mut self, range: &Range<'_, '_>, what: Swept, point: [f64; 3], size: f64) {
        let (_, block, tool) = range.at;
        let open = self.open.entry((gate_of(what), tool, number(what)));
        open.and_modify(|o| {
            o.more += 1;
            o.size = o.size.max(size);
        })
        .or_insert(Open { what, block, point, size, more: 0 });
    }

    /// A core so thin that no ray need go through it: how far down its tip is in material is asked of the
    /// true stock.
    fn look_at_core(&mut self, range: &Range<'_, '_>, item: &SweepItem<'_>, report: &mut SweepReport, cell: f64) {
        let radius = item.body.max_radius();
        if descent::is_seen(radius, cell) {
            return;
        }
        let way = [item.motion.from, item.motion.to];
        let (down, aside) = descent::way_down(&way);
        let parts = ((way[1].tip - way[0].tip).norm() / STEP).ceil().clamp(1.0, 400.0);
        let mut inside = 0.0;
        for k in 0..parts as usize {
            let tip = way[0].interpolated(&way[1], (k as f64 + 0.5) / parts).tip;
            match self.store.is_material(&tip) {
                Some(true) => inside += 1.0,
                Some(false) => {}
                None => return self.leave_open(range, Swept::Core, tip.into(), cell),
            }
        }
        report.volume_mm3 = descent::volume(radius, aside, down * inside / parts);
        report.rays = report.rays.max(u64::from(inside > 0.0));
        report.first_point = report.first_point.or((inside > 0.0).then_some(way[1].tip));
    }

    /// What is left to say at the end.
    pub(crate) fn facts(&self, tools: &[Tool], places: &[Option<(Arc<str>, u32)>]) -> BetweenFacts {
        let mut facts = BetweenFacts::default();
        for ((gate, tool, _), open) in &self.open {
            let name = tools.get(*tool).map_or("a tool", |t| &t.name);
            let at = places.get(open.block as usize).and_then(Option::as_ref);
            let at = at.map_or_else(String::new, |(file, line)| format!(" ({file}:{line})"));
            let part = tool_sweeps::part_of_tool(open.what);
            let [x, y, z] = open.point;
            let more = if open.more > 0 { format!(", and {} more places", open.more) } else { String::new() };
            let why = if self.store.is_raw_known() {
                "the search for material between the rays was not finished"
            } else {
                "the stock left by the earlier run is known only on its rays: give that run a finer `resolution_mm`, or a `[[stock.patch]]` there"
            };
            facts.left_out.entry(*gate).or_default().push(format!(
                "{part} of {name} near X{x:.3} Y{y:.3} Z{z:.3}{at}, over {:.3} mm{more}: {why}",
                open.size
            ));
        }
        facts
    }
}

/// Step at which the way of a core is checked, mm.
const STEP: f64 = 0.05;

/// The sweeps of one piece: its number, block and tool.
struct Range<'r, 'p> {
    items: &'r [SweepItem<'p>],
    parts: &'r [SweepPart],
    at: (usize, u32, usize),
}
