//! How much room the tool axis has where a program cuts the part: the free axes at places along its motion.
//!
//! At some hundred places of the motion in feed at which a ball end touches the design, all axes up
//! to a tilt are classified as free, blocked or unknown, with proof (`proveout_collision`'s
//! orientation maps): neck, shank and holder keep the clearance of the scene from part and
//! fixtures, and the cutter goes no deeper into the part than its gouge allowance. *Room* is the
//! angle by which the axis of the program may be tilted to any side so that it stays free.
//!
//! ```text
//!        free  .-------.   room: the angle to the nearest axis that is not free
//!             /   x---->|          x  axis of the program
//!             \         \ ___
//!    blocked   '-----------'      seen from above the contact, normal in the middle, feed to the right
//! ```
//!
//! It is advice: no gate depends on it. *Limits.* The machine and its spindle are not looked at,
//! nothing is said between the places, and the cutter must have a ball end; other tools are named.
//! A place counts as touched when the ball is no farther off the design than the excess that the
//! scene allows.

use std::collections::BTreeMap;

use proveout_collision::{Obstacle, OrientationSettings, OrientationSpace, SurfaceContact};
use proveout_geom::{TriMesh, Vector};
use rayon::prelude::*;

use crate::{
    cut::{engine::Facts, kept_motion::KeptPiece},
    prepare::prepared::Prepared,
};

pub use crate::observe::free_axes_map::{FreeAxes, FreePlace};

/// Most places of a run.
pub const MOST_PLACES: usize = 2_000;
/// Finest cells of the maps, radian.
const FINEST: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// So many places of the motion are tried for each that is asked for: most motion may be off the part.
const TRIED: usize = 16;
/// Places that one thread takes in a row.
const IN_A_ROW: usize = 16;
/// Shorter vectors have no direction, mm; of axes and normals, without a unit.
const SHORTEST: f64 = 1e-9;

/// A place of the motion: piece, and where along it.
#[derive(Clone, Copy)]
struct Spot {
    piece: usize,
    part: f64,
}

impl KeptPiece {
    fn way(&self) -> f64 {
        (self.motion.to.tip - self.motion.from.tip).norm()
    }
}

/// Looks at up to `count` places of a run, evenly along the motion in feed that touches the design.
pub(crate) fn look(prepared: &Prepared, facts: &Facts, count: usize) -> FreeAxes {
    let tolerances = &prepared.scene.file.tolerances;
    let settings = OrientationSettings {
        finest_cell: FINEST,
        clearance: tolerances.near_miss_mm,
        gouge: tolerances.gouge_mm,
        ..OrientationSettings::default()
    };
    let mut found = FreeAxes { settings, touch_mm: tolerances.excess_mm, places: Vec::new(), unchecked: Vec::new() };
    let Some(part) = &prepared.part_mesh else {
        found.unchecked.push("the design is not a mesh: give `[part] mesh` or `[part.blade]`".into());
        return found;
    };
    let Some(pieces) = facts.motion.as_ref().and_then(|m| m.pieces()) else {
        found.unchecked.push("the motion has more pieces than are kept".into());
        return found;
    };
    let work_from_table = prepared.table_from_work.inverse();
    let in_work = |mesh: &TriMesh| TriMesh {
        positions: mesh.positions.iter().map(|p| work_from_table.point(p)).collect(),
        ..mesh.clone()
    };
    let fixtures: Vec<(&str, TriMesh)> = prepared.fixtures.iter().map(|(n, m)| (n.as_str(), in_work(m))).collect();
    let mut spaces: BTreeMap<u32, OrientationSpace> = BTreeMap::new();
    let used: std::collections::BTreeSet<u32> = pieces.iter().filter(|p| p.feed).map(|p| p.tool).collect();
    for index in used {
        let Some(tool) = prepared.tools.tools.get(index as usize) else { continue };
        let design = Obstacle { name: "design", mesh: part, cut: true };
        let others = fixtures.iter().map(|(name, mesh)| Obstacle { name, mesh, cut: false });
        let solids: Vec<Obstacle<'_>> = std::iter::once(design).chain(others).collect();
        match OrientationSpace::new(tool, &solids, &settings) {
            Ok(space) if space.ball_radius().is_some() => {
                spaces.insert(index, space);
            }
            Ok(_) => found.unchecked.push(format!("{}: its end is not a ball", tool.name)),
            Err(e) => found.unchecked.push(format!("{}: {e}", tool.name)),
        }
    }
    let touching: Vec<(Spot, SurfaceContact, Vector)> = spots(pieces, count.min(MOST_PLACES) * TRIED)
        .into_par_iter()
        .filter_map(|spot| {
            let piece = &pieces[spot.piece];
            let (contact, axis) = contact(spaces.get(&piece.tool)?, piece, spot.part, tolerances.excess_mm)?;
            Some((spot, contact, axis))
        })
        .collect();
    let places = evenly(touching.len(), count.min(MOST_PLACES));
    let chunks: Vec<Vec<Result<FreePlace, String>>> = places
        .par_chunks(IN_A_ROW)
        .map(|chunk| {
            let mut walks = BTreeMap::new();
            let at = |&i: &usize| {
                let (spot, contact, axis) = &touching[i];
                let piece = &pieces[spot.piece];
                let tool = &prepared.tools.tools[piece.tool as usize].name;
                let walk = walks.entry(piece.tool).or_insert_with(|| spaces[&piece.tool].walk());
                let map = walk.next(contact).map_err(|e| format!("{tool}: {e}"))?;
                let block = facts.block_of_piece.get(spot.piece);
                Ok(FreePlace {
                    time_s: piece.time[0] + (piece.time[1] - piece.time[0]) * spot.part,
                    line: block.and_then(|b| facts.places.get(*b as usize)).cloned().flatten(),
                    tool: tool.clone(),
                    point: contact.point,
                    axis: *axis,
                    room: map.room(axis),
                    map,
                })
            };
            chunk.iter().map(at).collect()
        })
        .collect();
    for place in chunks.into_iter().flatten() {
        match place {
            Ok(place) => found.places.push(place),
            Err(fault) if !found.unchecked.contains(&fault) => found.unchecked.push(fault),
            Err(_) => {}
        }
    }
    if found.places.is_empty() && found.unchecked.is_empty() {
        found
            .unchecked
            .push(format!("no ball end comes within {} mm of the design (`excess_mm`) in feed", tolerances.excess_mm));
    }
    found
}

/// Places evenly along the way in feed.
fn spots(pieces: &[KeptPiece], count: usize) -> Vec<Spot> {
    let whole: f64 = pieces.iter().filter(|p| p.feed).map(KeptPiece::way).sum();
    let step = whole / count.max(1) as f64;
    if step.is_nan() || step <= 0.0 {
        return Vec::new();
    }
    let (mut out, mut next, mut gone) = (Vec::with_capacity(count), 0.5 * step, 0.0);
    for (index, piece) in pieces.iter().enumerate().filter(|(_, p)| p.feed) {
        let way = piece.way();
        while next <= gone + way && out.len() < count && way > 0.0 {
            out.push(Spot { piece: index, part: (next - gone) / way });
            next += step;
        }
        gone += way;
    }
    out
}

/// The contact of a ball with the design where it touches it, and the axis.
fn contact(space: &OrientationSpace, piece: &KeptPiece, part: f64, reach: f64) -> Option<(SurfaceContact, Vector)> {
    let radius = space.ball_radius()?;
    let [from, to] = [piece.motion.from, piece.motion.to];
    let axis = (from.axis * (1.0 - part) + to.axis * part).try_normalize(SHORTEST)?;
    let tip = from.tip + (to.tip - from.tip) * part;
    let center = tip + axis * radius;
    let nearest = space.nearest_on_part(&center, radius + reach)?;
    let normal = (center - nearest).try_normalize(SHORTEST)?;
    let feed = to.tip - from.tip;
    // Straight into the surface there is no direction along it: yaw then counts from any.
    let along = feed - normal * feed.dot(&normal);
    let feed = if along.norm() > SHORTEST { along } else { normal.cross(&axis) };
    let feed = if feed.norm() > SHORTEST { feed } else { normal.cross(&any_across(&normal)) };
    Some((SurfaceContact { point: center - normal * radius, normal, feed, curvatures: None }, axis))
}

fn any_across(n: &Vector) -> Vector {
    if n.x.abs() < 0.7 { Vector::x() } else { Vector::y() }
}

/// `count` of `of` numbers, evenly, the first and the last with them.
fn evenly(of: usize, count: usize) -> Vec<usize> {
    if of <= count {
        return (0..of).collect();
    }
    (0..count).map(|k| if count > 1 { k * (of - 1) / (count - 1) } else { of / 2 }).collect()
}
