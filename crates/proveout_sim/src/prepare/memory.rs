//! The memory that a run will need, announced before the stock is made.
//!
//! ```text
//!    MiB |                                      .--. pictures
//!        |                              .------'|  |__ writing
//!        |          motion, tables      | points|  |
//!        |      .-----------------------'- - - -|- | - announced
//!        |  ____| stock, patches, what the process holds already
//!        +----------------------------------------------> time
//! ```
//!
//! The largest of the stages counts, on top of what lasts: what the process holds already (machine, meshes,
//! the program itself), the stock with its patches, and the list of blocks. Points and meshes of the surface
//! pass in bands, so that the surface costs four bytes a point, a band, and the pictures, which are bounded.
//!
//! How many intervals of material a ray will hold is not known before the program has run. Counted
//! are those of the raw stock and [`GROWTH`] more, as a mean over all rays, or those of the design
//! and a quarter more where it has many (fins, ribs); a scene may give a better number
//! (`[stock] intervals_per_ray`). The run keeps the stock within what was announced
//! ([`crate::SimError::Memory`]). The constants are the sizes of what is held, rounded up;
//! `run.json` has the announced and the largest resident memory of every run.
//!
//! The history of a stock grows with what is removed, which is not known either: it is announced with the
//! most that it may take.

use std::fs;

use proveout_geom::TriMesh;
use proveout_nc::{Command, Motion, Op};

/// Intervals of material that a ray may gain, as a mean over all rays.
pub(crate) const GROWTH: f64 = 0.35;
/// Memory that the history of the stock may take, bytes.
pub(crate) const HISTORY_MEMORY: u64 = 2 << 30;
/// Bytes by which a stock may pass what it was announced with: small ones are not worth a word.
pub(crate) const ALLOWANCE: u64 = 12 << 20;
/// Bytes of a ray in addition to its intervals: its share of its tile and of the boxes over it (one
/// byte), and who emptied it.
const RAY: f64 = 10.0;
/// Bytes of an interval, with the room to grow that a tile keeps.
const INTERVAL: f64 = 34.0;
/// Bytes of a ray while the separate parts of the stock are found.
const PARTS: f64 = 28.0;
/// Bytes of an end of material that stay until the mesh has its colors.
const END: f64 = 4.0;
/// Bytes of an end of material in `stock.dexel`, whose sets are encoded before they are written.
const SAVED: f64 = 9.0;
/// Bytes of a triangle of a picture, and most of them: in the glTF files, on the page, in the recording.
const TRIANGLE: f64 = 40.0;
const GLB_TRIANGLES: f64 = 2e6;
const PAGE_TRIANGLES: f64 = 3e5;
const RECORDED_TRIANGLES: f64 = 4e5;
/// Bytes of a triangle of the design with its tree.
const PART_TRIANGLE: f64 = 400.0;
/// Bytes of a line of the program: its place, and the pieces of its motion.
const LINE: f64 = 64.0;

/// Pieces of a straight motion with its corner, and of any other (cone frustum: 10.4, blade root: 5.7): as
/// many are kept where there is a design.
const PIECES_OF_STRAIGHT: f64 = 2.0;
const PIECES_OF_CURVED: f64 = 12.0;

const MIB: f64 = (1 << 20) as f64;
/// Bodies for the collision check with their trees and, for neighbors, the skins that are checked (some 20
/// MiB for a machine of the tree), look-ahead of the control, a stretch of motion on its way, tables with
/// their buffers: for a few lines, and for as many as a stretch holds.
const MOTION: [f64; 2] = [28.0 * MIB, 82.0 * MIB];
/// Page, tables and glTF files while they are written; the same with a recording; likewise.
const FOLDER: [f64; 2] = [8.0 * MIB, 24.0 * MIB];
const RECORDING: [f64; 2] = [34.0 * MIB, 44.0 * MIB];
/// Lines from which on a stretch and its buffers are full.
const FULL: f64 = 2000.0;
/// A band of rays with all that is found on it.
const BAND: f64 = 30.0 * MIB;
/// Bytes of a band for each ray of the stock, where it is smaller than that.
const BAND_RAY: f64 = 900.0;
/// Bytes of a ray along x in the band of a face across it: bands follow one another along x, so
/// that such a face is one band as a whole, its mesh with the picture's open cells (1,429 x 1,429
/// rays: 212 bytes each in addition to everything else; 2,000 x 2,000: 234).
const FACE_RAY: f64 = 250.0;
/// A triangle of a fixture in the collision check: its corners, and two nodes of a tree with boxes along its
/// wall, bytes.
const BODY_TRIANGLE: f64 = 450.0;
/// What a process holds, where the host does not report it.
const PROCESS: u64 = 40 << 20;

/// What the observers of a run hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Recorded {
    /// There are none.
    Nothing,
    /// The files of a run folder.
    #[default]
    Folder,
    /// The same and a recording.
    Recording,
}

/// What a run needs in addition to its stock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Demand<'a> {
    /// Lines of the program.
    pub(crate) lines: u64,
    /// Its motions as they run.
    pub(crate) motions: Motions,
    /// The design, where it is a mesh.
    pub(crate) part: Option<&'a TriMesh>,
    /// Triangles of the fixtures.
    pub(crate) body_triangles: usize,
    pub(crate) recorded: Recorded,
    /// Motion near the patches of `[surface]` and the largest of them, bytes.
    pub(crate) textures: u64,
}

/// What a run will hold, announced before the stock is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// The stock first, then each patch by its name, bytes.
    pub stocks: Vec<(String, u64)>,
    /// The rest: what the process holds already, and the largest of the stages on top of the stock.
    pub rest: u64,
    /// How far the history of the stock may grow, where it is kept.
    pub history: u64,
    /// Allowed for all together, bytes.
    pub limit: u64,
}

impl Memory {
    /// All together, bytes.
    pub fn total(&self) -> u64 {
        self.working().saturating_add(self.history)
    }

    /// The same without the history, which is given up where it grows too large.
    pub(crate) fn working(&self) -> u64 {
        self.of_stocks().saturating_add(self.rest)
    }

    /// Stock and patches, bytes.
    pub(crate) fn of_stocks(&self) -> u64 {
        self.stocks.iter().fold(0, |sum: u64, s| sum.saturating_add(s.1))
    }
}

/// Bytes of a stock of some rays.
pub(crate) fn of_stock(rays: f64, intervals: f64) -> f64 {
    rays * (RAY + INTERVAL * intervals)
}

/// Bytes of the largest stage on top of what lasts; `rays` of the stock and of each patch, and those of the
/// stock that run `along_x`.
pub(crate) fn of_stages(rays: &[f64], along_x: f64, intervals: f64, demand: &Demand<'_>) -> f64 {
    let all: f64 = rays.iter().sum();
    let ends = 2.0 * intervals * all;
    let triangles = 4.0 * all;
    let full = (demand.lines as f64 / FULL).min(1.0);
    let held = |[few, many]: [f64; 2]| few + (many - few) * full;
    let (triangles_shown, writers) = match demand.recorded {
        Recorded::Nothing => (0.0, 0.0),
        Recorded::Folder => (GLB_TRIANGLES.min(triangles) + PAGE_TRIANGLES.min(triangles), held(FOLDER)),
        Recorded::Recording => {
            let shown = GLB_TRIANGLES.min(triangles) + PAGE_TRIANGLES.min(triangles);
            (shown + 2.0 * RECORDED_TRIANGLES.min(triangles), held(RECORDING))
        }
    };
    let pictures = TRIANGLE * triangles_shown;
    let band = BAND.min(BAND_RAY * all);
    let surface = END * ends + band + PART_TRIANGLE * demand.part.map_or(0.0, |m| m.triangles.len() as f64);
    let meshes = END * ends + band.max(FACE_RAY * along_x) + pictures;
    let written = pictures + if demand.recorded == Recorded::Nothing { 0.0 } else { SAVED * ends };
    let parts = PARTS * rays.first().copied().unwrap_or(0.0);
    let Motions { straight, curved } = demand.motions;
    let pieces = PIECES_OF_STRAIGHT * straight as f64 + PIECES_OF_CURVED * curved as f64;
    let kept = demand.part.map_or(0.0, |_| PIECE * pieces.min(MOST_PIECES as f64));
    LINE * demand.lines as f64
        + kept
        + demand.textures as f64
        + BODY_TRIANGLE * demand.body_triangles as f64
        + held(MOTION)
        + writers
        + [surface, meshes, written, parts].into_iter().fold(0.0, f64::max)
}

/// What the process holds now, bytes.
pub(crate) fn resident() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"));
    let kib = line.and_then(|l| l.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    kib.map_or(PROCESS, |k| k << 10)
}

/// Motions of a program, as they run: loops and subprograms each time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Motions {
    /// Straight, of linear axes alone.
    pub(crate) straight: u64,
    /// All others: arcs, curves, turns of rotary axes.
    pub(crate) curved: u64,
}

impl Motions {
    pub(crate) fn count(&mut self, command: &Command) {
        let straight = |m: &Motion| m.tool_axis.is_none() && m.programmed & !0b111 == 0;
        match &command.op {
            Op::Rapid(m) | Op::Linear(m) if straight(m) => self.straight += 1,
            Op::Rapid(_) | Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_) | Op::Thread(_) => {
                self.curved += 1
            }
            _ => {}
        }
    }
}

/// Memory that a run may take, bytes.
pub const MEMORY: u64 = 4 << 30;

/// Pieces that are kept at most: 256 MB, which are announced by the lines of the program.
pub(crate) const MOST_PIECES: usize = 1_000_000;

/// Bytes of a piece that is kept, and of the same made ready for the search.
pub(crate) const PIECE: f64 = 256.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_of_anything_is_announced_with_more() {
        let demand = |lines, recorded| Demand { lines, recorded, ..Demand::default() };
        let base = of_stages(&[1e6], 1e4, 1.3, &demand(1000, Recorded::Folder));
        for more in [
            of_stages(&[2e6], 1e4, 1.3, &demand(1000, Recorded::Folder)),
            of_stages(&[1e6, 1e6], 1e4, 1.3, &demand(1000, Recorded::Folder)),
            of_stages(&[1e6], 1e4, 2.6, &demand(1000, Recorded::Folder)),
            of_stages(&[1e6], 1e4, 1.3, &demand(100_000, Recorded::Folder)),
            of_stages(&[1e6], 1e4, 1.3, &demand(1000, Recorded::Recording)),
            of_stages(&[1e6], 1e6, 1.3, &demand(1000, Recorded::Folder)),
            of_stages(&[1e6], 1e4, 1.3, &Demand { body_triangles: 100, ..demand(1000, Recorded::Folder) }),
        ] {
            assert!(more > base, "{more} {base}");
        }
        assert!(of_stages(&[1e6], 1e4, 1.3, &demand(1000, Recorded::Nothing)) < base);
        assert!(of_stock(1e6, 2.0) > of_stock(1e6, 1.0));
        // The pictures are bounded: a hundred times the rays are not a hundred times the pictures.
        let large = of_stages(&[1e8], 1e4, 1.3, &demand(1000, Recorded::Folder));
        assert!(large < 1e8 * (SAVED * 2.6 + PARTS) + 300.0 * MIB, "{large}");
    }

    #[test]
    fn a_process_holds_something() {
        assert!(resident() > 1 << 20);
    }
}
