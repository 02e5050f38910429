//! Gouges and material left between the rays of the stock, decided on the motion that was kept.
//!
//! ```text
//!   kept motion + cutters ──► swept pieces ──┬─► gouges deeper than allowed     (proveout_surface::overcuts)
//!   design mesh ─────────────────────────────┤
//!   raw stock in closed form ────────────────┴─► design never cleared           (proveout_surface::uncut)
//! ```
//!
//! Places where the rays have found a fault already are left to them. What cannot be decided is left out of
//! the gate, with place and size: motion that was not kept, a search that took too long, room in front of the
//! design that neither motion nor rays know.

use std::collections::HashSet;

use proveout_geom::{Aabb, Point};
use proveout_stock::TriDexel;
use proveout_surface::{
    Areas, Overcut, Seed, Uncut, Watcher, overcuts,
    topography::{PathPiece, SweptBodies},
    uncut,
};

use crate::{
    checks::thread_strokes::{Strokes, is_thread},
    cut::kept_motion::Swept,
    judge::design::Design,
    prepare::{memory::MOST_PIECES, raw_shape::RawShape},
};

/// Part of the allowed depth by which a gouge must be deeper to be found with certainty, and least length,
/// mm.
const GRAIN: f64 = 0.02;
const LEAST_GRAIN: f64 = 1e-4;
/// Boxes that the search for gouges looks at; some seconds.
const MOST_BOXES: usize = 3_000_000;
/// Blocks that have one worst place each are no larger, mm.
const LARGEST_BLOCK: f64 = 2.0;
/// Places along each edge of a block at which the volume of a gouge is counted, and blocks for which it is.
const COUNTED: usize = 10;
const MOST_COUNTED: usize = 400;

/// Places at which the rays have found something, in boxes of two cells.
#[derive(Debug, Default)]
pub(crate) struct Places {
    edge: f64,
    boxes: HashSet<[i64; 3]>,
}

impl Places {
    /// None yet.
    pub(crate) fn new(cell: f64) -> Self {
        Self { edge: 2.0 * cell, boxes: HashSet::new() }
    }

    fn key(&self, p: &Point) -> [i64; 3] {
        [p.x, p.y, p.z].map(|v| (v / self.edge).floor() as i64)
    }

    /// Adds one.
    pub(crate) fn add(&mut self, p: &Point) {
        self.boxes.insert(self.key(p));
    }

    /// Whether one lies within two cells.
    fn is_near(&self, p: &Point) -> bool {
        let [x, y, z] = self.key(p);
        !self.boxes.is_empty()
            && (0..27).any(|i| self.boxes.contains(&[x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]))
    }
}

/// What is reported to a gate.
#[derive(Clone, Debug, Default)]
pub(crate) struct Told {
    /// What was decided, in words.
    pub(crate) checked: Option<String>,
    /// What was not.
    pub(crate) left_out: Vec<String>,
}

/// What is known of the run.
pub(crate) struct Between<'a> {
    pub(crate) design: &'a Design<'a>,
    pub(crate) stock: &'a TriDexel,
    pub(crate) swept: Option<&'a Swept>,
    pub(crate) strokes: &'a Strokes,
    pub(crate) region: Option<Aabb>,
    /// Depth and height from which on a fault counts, mm.
    pub(crate) limits: [f64; 2],
    /// Gouges and excesses that the rays have found.
    pub(crate) known: &'a [Places; 2],
    /// The run went to its end.
    pub(crate) finished: bool,
}

fn place(p: &Point) -> String {
    format!("X{:.3} Y{:.3} Z{:.3}", p.x, p.y, p.z)
}

impl Between<'_> {
    fn bodies(&self, swept: &Swept, with_threads: bool) -> SweptBodies {
        let pieces: &[PathPiece] = swept.path.pieces();
        let without = |n: u32| !with_threads && self.strokes.contains_key(&n);
        SweptBodies::new(pieces, &swept.cutters, &self.stock.bounds(), &without)
    }

    /// Puts gouges into `missing`.
    pub(crate) fn gouges(&self, raw: Option<&RawShape>, missing: &mut Areas) -> Told {
        let Some((mesh, tree)) = self.design.solid() else { return Told::default() };
        let Some(swept) = self.swept else {
            let why = format!(
                "gouges between the rays, for example along edges: the run has more than {MOST_PIECES} pieces of motion, too many to keep"
            );
            return Told { checked: None, left_out: vec![why] };
        };
        let sweeps = self.bodies(swept, false);
        let mut bounds = overlap(&tree.bounds(), &self.stock.bounds());
        if let Some(region) = &self.region {
            bounds = overlap(&bounds, region);
        }
        let known = |p: &Point| self.known[0].is_near(p);
        let grain = (GRAIN * self.limits[0]).max(LEAST_GRAIN);
        let search = Overcut {
            mesh,
            tree,
            sweeps: &sweeps,
            bounds,
            allowed: self.limits[0],
            grain,
            block: self.stock.cell_mm().min(LARGEST_BLOCK),
            known: &known,
            most_boxes: MOST_BOXES,
        };
        let found = overcuts(&search);
        let worst = found.found.iter().filter(|w| {
            !is_thread(self.strokes, Some(w.made_by).filter(|m| *m != u32::MAX), [&w.point; 2], self.limits[0])
        });
        let worst: Vec<_> = worst.collect();
        for (k, w) in worst.iter().enumerate() {
            let volume = if k < MOST_COUNTED { self.gouged(&sweeps, tree, &w.point) } else { 0.0 };
            let seed = Seed {
                depth: w.depth,
                point: w.point,
                made_by: Some(w.made_by).filter(|m| *m != u32::MAX),
                cut_area: volume / w.depth,
                ..Seed::default()
            };
            missing.add(0, &seed);
        }
        // The worst places of neighboring blocks lie up to two cells apart.
        let reach = 2.0 * self.stock.cell_mm();
        for (k, a) in worst.iter().enumerate() {
            for b in worst[k + 1..].iter().take(MOST_COUNTED).filter(|b| (b.point - a.point).norm() <= reach) {
                missing.join(0, &a.point, &b.point);
            }
        }
        let mut told =
            Told { checked: Some("between the rays by the swept pieces of motion".to_owned()), left_out: Vec::new() };
        if raw.is_none()
            && let Some(checked) = &mut told.checked
        {
            *checked += "; the stock from before this run is known only on its rays";
        }
        if found.undecided > 0 {
            let at = found.at.as_ref().map_or_else(String::new, |p| format!(", for example at {}", place(p)));
            told.left_out.push(format!(
                "gouges between the rays not decided at {} places of {:.3} mm{at}",
                found.undecided, search.block
            ));
        }
        told
    }

    /// Volume of the design in the block round a place that was swept, mm³.
    fn gouged(&self, sweeps: &SweptBodies, design: &dyn proveout_surface::DesignSurface, at: &Point) -> f64 {
        let block = self.stock.cell_mm();
        let step = block / COUNTED as f64;
        let corner = |k: usize| at[k] - 0.5 * block + 0.5 * step;
        let mut count = 0_u32;
        for i in 0..COUNTED.pow(3) {
            let along = [i % COUNTED, i / COUNTED % COUNTED, i / COUNTED / COUNTED];
            let p = Point::from([0, 1, 2].map(|k| corner(k) + step * along[k] as f64));
            let swept = sweeps.last_to_reach(&p, 0.0).is_some();
            count += u32::from(swept && design.signed_distance(&p).is_some_and(|d| d < 0.0));
        }
        f64::from(count) * step.powi(3)
    }

    /// Puts material that was never cleared into `left`.
    pub(crate) fn excesses(
        &self,
        raw: Option<&RawShape>,
        watchers: &[Watcher<'_>],
        fallen: bool,
        film: f64,
        [missing, left]: [&mut Areas; 2],
    ) -> Told {
        let (Some((mesh, tree)), true) = (self.design.solid(), self.finished) else { return Told::default() };
        let sweeps = self.swept.map(|s| self.bodies(s, true));
        let known = |p: &Point| self.known[1].is_near(p);
        let outside = raw.map(|raw| move |p: &Point| raw.outside(p));
        let search = Uncut {
            mesh,
            tree,
            sweeps: sweeps.as_ref(),
            raw: outside.as_ref().map(|f| f as &(dyn Fn(&Point) -> f64 + Sync)),
            watchers,
            fallen,
            region: self.region,
            allowed: self.limits[1],
            missing: self.limits[0],
            film,
            known: &known,
        };
        let found = uncut(&search);
        for l in &found.left {
            left.add(0, &Seed { depth: l.depth, point: l.point, cut_area: l.area, ..Seed::default() });
        }
        for m in &found.missing {
            if !self.known[0].is_near(&m.point) {
                missing.add(0, &Seed { depth: m.depth, point: m.point, cut_area: m.area, ..Seed::default() });
            }
        }
        let mut told = Told {
            checked: Some("the space in front of the whole design was cleared".to_owned()),
            left_out: Vec::new(),
        };
        if found.unknown > 0.0 {
            let at = found.at.as_ref().map_or_else(String::new, |p| format!(", for example at {}", place(p)));
            told.left_out.push(format!(
                "excess in front of {:.3} mm2 of the design{at}: no ray is near, and the swept motion does not decide it",
                found.unknown
            ));
        }
        told
    }
}

fn overlap(a: &Aabb, b: &Aabb) -> Aabb {
    Aabb { min: a.min.sup(&b.min), max: a.max.inf(&b.max) }
}
