//! Parts that a program cuts off the stock, and where they go.
//!
//! After every stretch of motion that has cut, the twin looks whether the stock still hangs together. A part
//! that has come off is taken out, followed as a rigid body from the end of the piece that cut it last
//! (`fall`), and then
//!
//! * put back where it rests: it stays stock, and later motion of the table is compared with the
//!   pushes that it withstands;
//! * left out where it has fallen away: its material is no longer stock;
//! * left out where it comes to rest elsewhere, and the bodies that come near to that place are
//!   reported;
//! * put back where nothing is decided: the gates `collision` and `near_miss` are unchecked from then on.
//!
//! | file | holds |
//! |---|---|
//! | `world` | the data of a fall |
//! | `rapier_world` | the rigid body among its neighbors; the one file that knows Rapier |
//! | `pieces` | a body in convex pieces, with their error |
//! | `course` | motion of tool and table while a part falls |
//! | `fall` | from two simulations to what is decided |
//! | `neighbors` | part, fixtures, machine, tool and the rest of the stock as bodies |
//! | `lying` | places where parts lie, against what moves later |
//! | `wording` | the texts of findings |
//!
//! Rapier is the feature `rapier`. Without it (`no_rapier`) parts that come off are found and
//! reported, none is followed, and the gates are unchecked from then on.

mod course;
mod fall;
mod lying;
mod neighbors;
mod pieces;
#[cfg(feature = "rapier")]
mod rapier_world;
#[cfg(not(feature = "rapier"))]
#[path = "no_rapier.rs"]
mod rapier_world;
mod wording;
mod world;

use proveout_controller::Chunk;
use proveout_geom::{Aabb, Vector};
use proveout_machine::JointValues;
use proveout_stock::{Coherence, Patch, StockPart, SweepReport, TriDexel};

use self::{
    course::{Course, felt},
    fall::{Decision, End},
    lying::Lying,
};
use crate::{
    cut::tool_sweeps::CuttingState, observe::block_rows::LooseMotion, prepare::prepared::Prepared,
    units::KG_MM3_PER_KG_M3, verdict::finding::Finding,
};

/// Least volume of a part that is reported, mm³: below it lie crumbs of a few chips.
const LEAST_VOLUME: f64 = 1.0;
/// The same in edges of a cell: what is thinner may hang together between the rays.
const LEAST_CELLS: f64 = 4.0;
/// Parts that are followed in a run; what comes off after them is not.
const MOST_PARTS: usize = 24;
/// Columns of a stock that are checked at no extra cost. The check of a column takes about as long as
/// the cutting of a ray: in a larger stock it waits until as many rays were met as there are columns
/// beyond these.
const FREE_COLUMNS: u64 = 50_000;
/// A part that answers pushes of this much (mm/s²) is clamped: it may be cut. What rests by its weight and
/// friction alone may not.
const CLAMPED: f64 = 20_000.0;
/// Part of its volume that a loose part may lose and still count as not cut: rounding of the sums over its
/// cells.
const UNCUT: f64 = 1e-6;
/// Coordinates of planes of the stock that differ by less are the same, mm: rounding.
const SAME_MM: f64 = 1e-9;

/// The moment at which a part is free.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// The piece of motion that ends then.
    pub(crate) piece: Option<u32>,
    /// s.
    pub(crate) time: f64,
    /// Joint positions.
    pub(crate) joints: JointValues,
    /// Tool in the spindle.
    tool: Option<usize>,
}

/// A finding that wants its place in the program.
pub(crate) struct Told {
    pub(crate) finding: Finding,
    pub(crate) at: Moment,
}

/// What a part does in its place.
#[derive(Clone, Debug)]
enum State {
    /// Its fall is to be decided.
    Free { course: Course },
    /// It rests under what it felt then, and under pushes of so much, mm/s².
    Rests { felt: Vector, push: f64 },
    /// It is left in its place, and no one knows.
    Unknown,
    /// It is no longer stock.
    Gone,
}

#[derive(Clone, Debug)]
struct Loose {
    part: StockPart,
    at: Moment,
    state: State,
    /// Material next to it was removed, or a part next to it has gone.
    disturbed: bool,
    /// It was reported that it has come off.
    told: bool,
}

/// What the check of the parts works on.
pub(crate) struct Shop<'a> {
    pub(crate) prepared: &'a Prepared,
    pub(crate) stock: &'a mut TriDexel,
    pub(crate) patches: &'a mut [Patch],
    /// The last piece that was swept.
    pub(crate) last_piece: u32,
}

/// Parts seen so far, the largest apart.
pub(crate) struct LooseParts {
    least_volume: f64,
    coherence: Coherence,
    known: Vec<StockPart>,
    loose: Vec<Loose>,
    lying: Option<Lying>,
    /// What is not known of them, for the gates.
    unknown: Vec<String>,
    /// A part was taken out of the stock, if only to be looked at.
    has_taken: bool,
    motions: Vec<LooseMotion>,
    /// Rays that were met since the last look.
    met: u64,
}

impl LooseParts {
    /// The raw stock may consist of several parts: those are held.
    pub(crate) fn new(raw: &TriDexel) -> Self {
        let cell = LEAST_CELLS * raw.cell_mm();
        let mut loose = Self {
            least_volume: (cell * cell * cell).max(LEAST_VOLUME),
            coherence: Coherence::default(),
            known: Vec::new(),
            loose: Vec::new(),
            lying: None,
            unknown: Vec::new(),
            has_taken: false,
            motions: Vec::new(),
            met: 0,
        };
        loose.known = loose.apart(raw);
        loose
    }

    fn apart(&mut self, stock: &TriDexel) -> Vec<StockPart> {
        // Mostly nothing has come off, which costs little to know.
        if self.coherence.parts(stock) > 1 { stock.parts_apart(self.least_volume) } else { Vec::new() }
    }

    /// Goes on with the parts whose fall outlasted the motion that was known, before the stretch cuts.
    pub(crate) fn go_on(&mut self, shop: &mut Shop<'_>, chunk: &Chunk) -> Vec<Told> {
        self.followed(shop, chunk);
        self.decide(shop, false)
    }

    /// Watches what the cuts of a stretch do to the parts that rest.
    fn watch_cuts(&mut self, prepared: &Prepared, reports: &[SweepReport]) {
        let margin = prepared.stock.cell_mm() * 2.0;
        let cuts = || reports.iter().filter(|r| r.volume_mm3 > 0.0).filter_map(|r| r.region);
        for loose in self.loose.iter_mut().filter(|l| matches!(l.state, State::Rests { .. })) {
            let near = loose.part.bounds.expanded(margin);
            loose.disturbed |= cuts().any(|c| c.intersects(&near));
        }
    }

    /// Watches what the motion of the table does to the parts that rest.
    fn watch_table(&mut self, prepared: &Prepared, chunk: &Chunk) {
        for (k, loose) in self.loose.iter_mut().enumerate() {
            let State::Rests { felt: then, push } = loose.state else { continue };
            let place = prepared.table_from_work.point(&loose.part.center);
            let machine = &prepared.machine;
            let beyond = chunk.samples.iter().filter(|s| s.time >= loose.at.time).find(|s| {
                let now = felt(machine, &place, [&s.commanded, &s.velocity, &s.acceleration]);
                now.is_none_or(|now| (now - then).lp_norm(1) > push)
            });
            if let Some(sample) = beyond {
                self.unknown.push(wording::moved_by_table(k, push, sample.time));
                loose.state = State::Unknown;
            }
        }
    }

    /// Watches what a stretch does to the parts that rest or lie, before it is looked for new ones.
    pub(crate) fn watch(
        &mut self,
        prepared: &Prepared,
        chunk: &Chunk,
        states: &[CuttingState],
        reports: &[SweepReport],
    ) {
        self.met += reports.iter().map(|r| r.rays).sum::<u64>();
        self.watch_cuts(prepared, reports);
        if let Some(lying) = &mut self.lying {
            self.unknown.extend(lying.watch(prepared, chunk, states));
        }
    }

    /// Whether enough was cut for a look at a stock.
    pub(crate) fn is_due(&self, stock: &TriDexel) -> bool {
        let [nx, ny, _] = stock.counts();
        self.met + FREE_COLUMNS >= (nx * ny) as u64
    }

    /// A stretch has moved without a look after it.
    pub(crate) fn moved(&mut self, prepared: &Prepared, chunk: &Chunk) {
        self.watch_table(prepared, chunk);
    }

    /// Looks for parts that have come off in a stretch whose first piece has the id `first`, and
    /// follows them. `last`: the machine stops after it.
    pub(crate) fn look(
        &mut self,
        shop: &mut Shop<'_>,
        (chunk, first): (&Chunk, u32),
        states: &[CuttingState],
        last: bool,
    ) -> Vec<Told> {
        self.met = 0;
        let lying = self.lying.as_ref().map_or(0, Lying::len);
        let told = self.look_for_parts(shop, (chunk, first), states, last);
        self.watch_table(shop.prepared, chunk);
        if let Some(new) = self.lying.as_mut().filter(|l| l.len() > lying) {
            // A box that was not there before: what moved since its part began to fall.
            self.unknown.extend(new.watch(shop.prepared, chunk, states));
        }
        told
    }

    fn look_for_parts(
        &mut self,
        shop: &mut Shop<'_>,
        (chunk, first): (&Chunk, u32),
        states: &[CuttingState],
        last: bool,
    ) -> Vec<Told> {
        let before = std::mem::take(&mut self.known);
        self.known = self.apart(shop.stock);
        // A part only shrinks: it lies within the box in which it was seen.
        let fresh: Vec<StockPart> =
            self.known.iter().filter(|new| !before.iter().any(|old| within(new, old))).cloned().collect();
        let mut told = self.disturbed(chunk, states);
        for part in fresh {
            let at = moment(&part, chunk, first, states);
            let course = Course::default();
            self.loose.push(Loose { part, at, state: State::Free { course }, disturbed: false, told: false });
        }
        self.followed(shop, chunk);
        told.extend(self.decide(shop, last));
        told
    }

    /// Ends the run: the machine has stopped.
    pub(crate) fn finish(&mut self, shop: &mut Shop<'_>) -> Vec<Told> {
        self.decide(shop, true)
    }

    /// Parts that rest and were cut, or lost what held them.
    fn disturbed(&mut self, chunk: &Chunk, states: &[CuttingState]) -> Vec<Told> {
        let mut told = Vec::new();
        for (k, loose) in self.loose.iter_mut().enumerate() {
            let State::Rests { push, .. } = loose.state else { continue };
            if !std::mem::take(&mut loose.disturbed) {
                continue;
            }
            let Some(now) = self.known.iter().find(|new| within(new, &loose.part)) else {
                // Cut to chips, or to crumbs.
                loose.state = State::Gone;
                if push < CLAMPED {
                    told.push(Told { finding: wording::cut(k), at: loose.at });
                    self.unknown.push(wording::thrown(k));
                }
                continue;
            };
            let cut = now.volume_mm3 < loose.part.volume_mm3 * (1.0 - UNCUT);
            let at = ended(chunk, states, loose.at);
            if cut && push < CLAMPED {
                told.push(Told { finding: wording::cut(k), at });
                self.unknown.push(wording::thrown(k));
                loose.state = State::Unknown;
            } else {
                loose.state = State::Free { course: Course::default() };
                loose.at = at;
            }
            loose.part = now.clone();
        }
        told
    }

    /// Gives the motion of a stretch to the parts that may fall in it.
    fn followed(&mut self, shop: &Shop<'_>, chunk: &Chunk) {
        for loose in &mut self.loose {
            let place = shop.prepared.table_from_work.point(&loose.part.center);
            if let State::Free { course } = &mut loose.state {
                course.extend(&shop.prepared.machine, chunk, loose.at.time.max(course.end()), &place);
            }
        }
    }

    /// Follows all parts that are free.
    fn decide(&mut self, shop: &mut Shop<'_>, last: bool) -> Vec<Told> {
        let mut told = Vec::new();
        // A part that goes may have held another one; each round takes one away.
        for _ in 0..=MOST_PARTS {
            let before = self.gone();
            for k in 0..self.loose.len() {
                if let State::Free { course } = &self.loose[k].state {
                    let course = course.clone();
                    told.extend(self.decide_one(k, &course, shop, last));
                }
            }
            if self.gone() == before {
                break;
            }
        }
        told
    }

    /// Boxes of the parts that are no longer there.
    pub(crate) fn gone_bounds(&self) -> Vec<Aabb> {
        self.loose.iter().filter(|l| matches!(l.state, State::Gone)).map(|l| l.part.bounds).collect()
    }

    fn gone(&self) -> usize {
        self.loose.iter().filter(|l| matches!(l.state, State::Gone)).count()
    }

    fn decide_one(&mut self, k: usize, course: &Course, shop: &mut Shop<'_>, last: bool) -> Vec<Told> {
        let Loose { part, at, told, .. } = self.loose[k].clone();
        let cut_by = part.last_made_by.unwrap_or(shop.last_piece);
        let Some(taken) = shop.stock.take_part(&part, shop.last_piece, cut_by) else {
            self.loose[k].state = State::Gone;
            return Vec::new();
        };
        self.has_taken = true;
        let (seen, mesh) = if k < MOST_PARTS {
            neighbors::follow(shop, &taken, &at, course, last)
        } else {
            let why = format!("more than {MOST_PARTS} parts have come off");
            (Decision { end: End::Unknown(why), struck: Vec::new(), track: Vec::new() }, None)
        };
        let goes = matches!(seen.end, End::Left | End::Lies { .. });
        let end = seen.end.clone();
        if goes {
            for patch in shop.patches.iter_mut() {
                take_from_patch(patch.stock_mut(), taken.stock(), &part, [shop.last_piece, cut_by]);
            }
            let near = part.bounds.expanded(2.0 * shop.stock.cell_mm());
            self.known.retain(|p| !within(p, &part));
            for other in &mut self.loose {
                if matches!(other.state, State::Rests { .. }) && other.part.bounds.intersects(&near) {
                    (other.state, other.at) = (State::Free { course: Course::default() }, at);
                }
            }
        } else {
            shop.stock.put_back(taken);
        }
        self.loose[k].state = match &end {
            End::Unfinished => return Vec::new(),
            End::Rests { push } => {
                let place = shop.prepared.table_from_work.point(&part.center);
                let still = [&at.joints, &JointValues::ZERO, &JointValues::ZERO];
                let felt = felt(&shop.prepared.machine, &place, still).unwrap_or_else(Vector::zeros);
                match course.beyond(&felt, *push) {
                    None => State::Rests { felt, push: *push },
                    Some(time) => {
                        self.unknown.push(wording::moved_by_table(k, *push, time));
                        State::Unknown
                    }
                }
            }
            End::Unknown(why) => {
                self.unknown.push(wording::not_decided(k, why));
                State::Unknown
            }
            End::Left => State::Gone,
            End::Lies { within } => {
                let lying =
                    Lying::with(self.lying.take(), &shop.prepared.machine, (&wording::name(k), at.time), within);
                match lying {
                    Ok(lying) => self.lying = Some(lying),
                    Err(e) => self.unknown.push(wording::not_decided(k, &e.to_string())),
                }
                State::Gone
            }
        };
        if let Some(mesh) = mesh.filter(|_| !seen.track.is_empty()) {
            self.motions.push(LooseMotion { name: wording::name(k), mesh, track: seen.track, gone: goes });
        }
        self.loose[k].told = true;
        let mut out = Vec::new();
        if !told || goes {
            let mass = part.volume_mm3 * shop.prepared.scene.file.stock.get_ref().density() * KG_MM3_PER_KG_M3;
            out.push(Told { finding: wording::came_off(k, &part, mass, &end, &shop.prepared.table_from_work), at });
        }
        let work_from_table = shop.prepared.table_from_work.inverse();
        out.extend(seen.struck.iter().map(|s| Told { finding: wording::struck(k, s, &work_from_table), at }));
        out
    }

    /// Parts that have moved since the last call, for pictures.
    pub(crate) fn take_motions(&mut self) -> Vec<LooseMotion> {
        std::mem::take(&mut self.motions)
    }

    /// For the gates: what is not known.
    pub(crate) fn left_out(&self) -> Vec<String> {
        self.unknown.clone()
    }

    /// True once a part was taken out of the stock, if only to be looked at.
    pub(crate) fn has_taken(&self) -> bool {
        self.has_taken
    }

    /// For the gates: what is known of the parts that have come off; none while the stock hangs together.
    pub(crate) fn checked(&self) -> Option<String> {
        let rests = self.loose.iter().filter(|l| matches!(l.state, State::Rests { .. })).count();
        wording::checked(rests, self.gone())
    }
}

/// The part lies within the box of an earlier one.
fn within(new: &StockPart, old: &StockPart) -> bool {
    (0..3).all(|c| new.bounds.min[c] >= old.bounds.min[c] - SAME_MM && new.bounds.max[c] <= old.bounds.max[c] + SAME_MM)
}

/// When a part came off: at the end of the piece that made its last end, as far as it belongs to this
/// stretch; at its begin otherwise.
fn moment(part: &StockPart, chunk: &Chunk, first: u32, states: &[CuttingState]) -> Moment {
    let k = part.last_made_by.and_then(|id| id.checked_sub(first)).map_or(0, |k| k as usize);
    let tool = states.get(k).and_then(|s| s.tool);
    match chunk.pieces.get(k) {
        Some(piece) => Moment { piece: part.last_made_by, time: piece.time[1], joints: piece.joints[1], tool },
        None => ended(chunk, states, Moment { piece: None, time: 0.0, joints: JointValues::ZERO, tool }),
    }
}

/// The end of a stretch.
fn ended(chunk: &Chunk, states: &[CuttingState], before: Moment) -> Moment {
    let tool = states.last().map_or(before.tool, |s| s.tool);
    chunk.pieces.last().map_or(before, |p| Moment { piece: before.piece, time: p.time[1], joints: p.joints[1], tool })
}

/// Takes the parts of finer cells that lie within a part that has gone.
fn take_from_patch(patch: &mut TriDexel, gone: &TriDexel, part: &StockPart, [id, cut_by]: [u32; 2]) {
    let room = part.bounds.expanded(gone.cell_mm());
    for fine in patch.parts() {
        let inside = room.contains(&fine.bounds.min) && room.contains(&fine.bounds.max);
        if inside && fine.lies_in(gone) {
            // It leaves with the part.
            drop(patch.take_part(&fine, id, cut_by));
        }
    }
}
