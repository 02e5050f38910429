//! `motion.bin` and the raw stock of each shard: what a run asks of its stock. A shard needs nothing else,
//! neither scene nor machine.
//!
//! ```text
//!   motion.bin   PROVEOUT-MOTION 2\n, 1 where engagement is watched, tools (4),
//!                and for each tool four lists of bodies:
//!                  core, cutting, others, widened holder: bodies (4), of each its segments (4):
//!                  0 and 4 reals, 1 and 7 reals
//!                then for each stretch with a tool in the spindle: pieces (4 bytes), and 113 bytes each:
//!                   0  number of the piece
//!                   4  tool
//!                   8  first piece of its barred run, 2^32 - 1 for none
//!                  12  first piece of its run of joined findings
//!                  16  1 where it goes down, 2 where its tool has just come
//!                  17  tip and axis at both ends, twelve reals
//!   jobs/0000k   raw-stock.dexel, raw-patch-0.dexel .. : the material of shard k
//! ```
//!
//! All numbers with the lowest byte first.

use std::{
    fs::File,
    io::{BufReader, BufWriter, Write},
    path::{Path, PathBuf},
};

use proveout_geom::{Point, ToolPose, Vector};
use proveout_stock::{SweepMotion, TriDexel};
use proveout_tool::{Profile, Role, Segment};

use crate::{
    cut::{
        shard_records::{ShardError, record, u32_at, u64_at},
        tool_sweeps::{Barring, Cutters, CuttingState, PieceCut, Sweeps, ToolBodies, states_of_pieces},
    },
    prepare::{
        error::{SimError, from_run_error},
        prepared::Prepared,
    },
    run::motion_plan::{STRETCH_S, controller, opened, stretches},
};

/// The motion of a run, in the folder of its sweep.
pub const MOTION: &str = "motion.bin";
/// Raw stock of a shard, in the folder of its job.
const RAW: &str = "raw-stock.dexel";

const MOTION_MAGIC: &[u8] = b"PROVEOUT-MOTION 2\n";
const PIECE: usize = 113;
/// Most pieces of a stretch of two seconds, and most bodies or segments of a list: what is more is no file of
/// ours.
const MOST_PIECES: u32 = 1 << 24;
const MOST_LISTED: u32 = 1 << 16;

/// Name of the raw material of a patch in the folder of a job.
pub(super) fn raw_patch(number: usize) -> String {
    format!("raw-patch-{number}.dexel")
}

/// The files of a shard, in the folder of its job: patches, last the stock.
pub fn raw_files(patches: usize) -> Vec<String> {
    (0..patches).map(raw_patch).chain([RAW.to_owned()]).collect()
}

/// What was planned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionPlan {
    /// Pieces of motion with a tool.
    pub pieces: u64,
    /// Tiles of stock and patches.
    pub tiles: u64,
    /// Patches.
    pub patches: usize,
    /// Sweeps that come to the tiles of the heaviest and of the lightest shard, before anything is cut.
    pub loads: [u64; 2],
}

/// Plans the motion of a run and shares the tiles of its stock out: the motion into `folder`, raw stock into
/// that of each job.
///
/// # Errors
/// [`SimError`] when program, control or stock refuse, or a file cannot be written.
pub fn plan_motion(
    mut prepared: Prepared,
    shards: u16,
    folder: &Path,
    job: impl Fn(u16) -> PathBuf,
) -> Result<MotionPlan, SimError> {
    let (mut stock, mut patches) = prepared.stock.take()?;
    let prepared = prepared;
    let cutters = Cutters::new(&prepared.tools.tools, &prepared.holder_zones, stock.cell_mm());
    let work_from_table = prepared.table_from_work.inverse();
    let fields = patches.iter().map(|p| p.stock().ray_tiles()).chain([stock.ray_tiles()]);
    let mut loads: Vec<Vec<u64>> = fields.map(|tiles| vec![0; tiles]).collect();
    let mut plan = MotionPlan {
        tiles: loads.iter().map(|l| l.len() as u64).sum(),
        patches: patches.len(),
        ..MotionPlan::default()
    };

    let mut out = BufWriter::new(File::create(folder.join(MOTION)).map_err(SimError::Folder)?);
    let head = (prepared.scene.file.engagement, &cutters);
    write_head(&mut out, head).map_err(SimError::Folder)?;
    let (mut barring, mut state, mut id) = (Barring::default(), CuttingState::IDLE, 0);
    let mut control = controller(&prepared)?;
    while let Some(chunk) = control.next_chunk().map_err(|e| from_run_error(opened(&prepared, e)))? {
        for stretch in stretches(chunk, STRETCH_S) {
            let states = states_of_pieces(&stretch, &mut state, |_| ());
            let mut cuts = Vec::with_capacity(stretch.pieces.len());
            for (piece, state) in stretch.pieces.iter().zip(&states) {
                let [from, to] = piece.pose.map(|p| p.transformed(&work_from_table));
                cuts.extend(barring.cut(id, piece, state, &prepared.tools.tools, SweepMotion { from, to }));
                id += 1;
            }
            if cuts.is_empty() {
                continue;
            }
            plan.pieces += cuts.len() as u64;
            write_stretch(&mut out, &cuts).map_err(SimError::Folder)?;
            let mut sweeps = Sweeps::default();
            cuts.iter().for_each(|cut| cutters.add(&mut sweeps, 0, cut));
            for (patch, loads) in patches.iter_mut().zip(&mut loads) {
                let near = patch.near(&sweeps.items);
                patch.stock_mut().add_loads(&near, loads);
            }
            if let Some(loads) = loads.last_mut() {
                stock.add_loads(&sweeps.items, loads);
            }
        }
    }
    out.flush().map_err(SimError::Folder)?;
    drop(out);
    let fields: Vec<&TriDexel> = patches.iter().map(|p| p.stock()).chain([&stock]).collect();
    let owners: Vec<Vec<u16>> = fields.iter().zip(&loads).map(|(f, l)| f.share_rows(l, shards)).collect();
    let load = |k: u16| {
        let all = loads.iter().zip(&owners).flat_map(|(l, o)| l.iter().zip(o));
        all.filter(|(_, owner)| **owner == k).map(|(load, _)| load).sum::<u64>()
    };
    plan.loads = [(0..shards).map(load).max().unwrap_or(0), (0..shards).map(load).min().unwrap_or(0)];
    for shard in 0..shards {
        let job = job(shard);
        std::fs::create_dir_all(&job).map_err(SimError::Folder)?;
        // Patches of an earlier plan.
        for left in (patches.len()..).map(|k| job.join(raw_patch(k))).take_while(|path| path.is_file()) {
            std::fs::remove_file(left).map_err(SimError::Folder)?;
        }
        for ((field, owners), name) in fields.iter().zip(&owners).zip(raw_files(patches.len())) {
            let path = job.join(name);
            let mut out = BufWriter::new(File::create(&path).map_err(SimError::Folder)?);
            let saved = field.share(owners, shard).save(&mut out);
            saved.map_err(|e| ShardError::new(&path, format!("cannot be written: {e}")))?;
            out.flush().map_err(SimError::Folder)?;
        }
    }
    Ok(plan)
}

fn write_stretch(out: &mut impl Write, cuts: &[PieceCut]) -> std::io::Result<()> {
    out.write_all(&(cuts.len() as u32).to_le_bytes())?;
    for cut in cuts {
        out.write_all(&cut.id.to_le_bytes())?;
        out.write_all(&(cut.tool as u32).to_le_bytes())?;
        out.write_all(&cut.since.unwrap_or(u32::MAX).to_le_bytes())?;
        out.write_all(&cut.joined.to_le_bytes())?;
        out.write_all(&[u8::from(cut.goes_down) | u8::from(cut.entered) << 1])?;
        for pose in [&cut.motion.from, &cut.motion.to] {
            for x in [pose.tip.x, pose.tip.y, pose.tip.z, pose.axis.x, pose.axis.y, pose.axis.z] {
                out.write_all(&x.to_bits().to_le_bytes())?;
            }
        }
    }
    Ok(())
}

fn write_head(out: &mut impl Write, (engagement, cutters): (bool, &Cutters)) -> std::io::Result<()> {
    out.write_all(MOTION_MAGIC)?;
    out.write_all(&[u8::from(engagement)])?;
    out.write_all(&(cutters.0.len() as u32).to_le_bytes())?;
    for tool in &cutters.0 {
        let of = |list: &[(Role, Profile)]| list.iter().map(|b| b.1.clone()).collect::<Vec<_>>();
        for list in [tool.core.clone(), of(&tool.cutting), of(&tool.others), tool.zones.clone()] {
            out.write_all(&(list.len() as u32).to_le_bytes())?;
            for body in &list {
                out.write_all(&(body.segments().len() as u32).to_le_bytes())?;
                for segment in body.segments() {
                    let (kind, reals) = match *segment {
                        Segment::Line { from, to } => (0, [from, to].concat()),
                        Segment::Arc { center, radius, from, to } => (1, [&center[..], &[radius], &from, &to].concat()),
                    };
                    out.write_all(&[kind])?;
                    for x in reals {
                        out.write_all(&x.to_bits().to_le_bytes())?;
                    }
                }
            }
        }
    }
    Ok(())
}

/// Reads the motion, stretch by stretch.
pub(super) struct MotionReader<'p> {
    path: &'p Path,
    input: BufReader<File>,
    pub(super) engagement: bool,
}

impl<'p> MotionReader<'p> {
    /// Opens the motion, and reads the bodies that run along it.
    pub(super) fn open(path: &'p Path) -> Result<(Self, Cutters), ShardError> {
        let fault = |e: std::io::Error| ShardError::new(path, format!("cannot be read: {e}"));
        let input = BufReader::with_capacity(1 << 20, File::open(path).map_err(fault)?);
        let mut reader = Self { path, input, engagement: false };
        if reader.read(MOTION_MAGIC.len()).is_none_or(|magic| magic != MOTION_MAGIC) {
            return Err(ShardError::new(path, "is not a motion file that this version can read"));
        }
        let bodies = reader.bodies().ok_or_else(|| ShardError::new(path, "its tools cannot be read"))?;
        Ok((reader, bodies))
    }

    fn read(&mut self, length: usize) -> Option<Vec<u8>> {
        record(&mut self.input, length).ok().flatten()
    }

    fn count(&mut self) -> Option<usize> {
        let count = u32_at(&self.read(4)?, 0);
        (count <= MOST_LISTED).then_some(count as usize)
    }

    fn bodies(&mut self) -> Option<Cutters> {
        self.engagement = self.read(1)?[0] != 0;
        let mut tools = Vec::new();
        for _ in 0..self.count()? {
            let mut lists: [Vec<Profile>; 4] = Default::default();
            for list in &mut lists {
                for _ in 0..self.count()? {
                    let segments = (0..self.count()?).map(|_| self.segment()).collect::<Option<Vec<_>>>()?;
                    list.push(Profile::new(segments).ok()?);
                }
            }
            let [core, cutting, others, zones] = lists;
            // Which part of the tool a body is decides what its finding says: the merged run
            // reports that.
            let of = |list: Vec<Profile>, role: Role| list.into_iter().map(|b| (role, b)).collect();
            let (cutting, others) = (of(cutting, Role::Cutting), of(others, Role::Holder));
            tools.push(ToolBodies { core, cutting, others, zones });
        }
        Some(Cutters(tools))
    }

    fn segment(&mut self) -> Option<Segment> {
        let kind = self.read(1)?[0];
        let bytes = self.read(8 * if kind == 0 { 4 } else { 7 })?;
        let x = |k: usize| f64::from_bits(u64_at(&bytes, 8 * k));
        match kind {
            0 => Some(Segment::Line { from: [x(0), x(1)], to: [x(2), x(3)] }),
            1 => Some(Segment::Arc { center: [x(0), x(1)], radius: x(2), from: [x(3), x(4)], to: [x(5), x(6)] }),
            _ => None,
        }
    }

    /// The pieces of the next stretch.
    pub(super) fn next(&mut self, tools: usize) -> Result<Option<Vec<PieceCut>>, ShardError> {
        let path = self.path;
        let fault = |message: String| ShardError::new(path, message);
        let read =
            |input: &mut BufReader<File>, n: usize| record(input, n).map_err(|e| fault(format!("cannot be read: {e}")));
        let Some(head) = read(&mut self.input, 4)? else { return Ok(None) };
        let count = u32_at(&head, 0);
        if count > MOST_PIECES {
            return Err(fault("a stretch has too many pieces".into()));
        }
        let length = count as usize * PIECE;
        let Some(bytes) = read(&mut self.input, length)? else {
            return Err(fault("it ends in the middle of a record".into()));
        };
        let pieces = bytes.chunks_exact(PIECE).map(|b| {
            let pose = |at: usize| {
                let x = |k: usize| f64::from_bits(u64_at(b, at + 8 * k));
                ToolPose { tip: Point::new(x(0), x(1), x(2)), axis: Vector::new(x(3), x(4), x(5)) }
            };
            let tool = u32_at(b, 4) as usize;
            if tool >= tools {
                return Err(fault("a tool that the library does not have".into()));
            }
            Ok(PieceCut {
                id: u32_at(b, 0),
                tool,
                since: Some(u32_at(b, 8)).filter(|s| *s != u32::MAX),
                joined: u32_at(b, 12),
                goes_down: b[16] & 1 != 0,
                entered: b[16] & 2 != 0,
                motion: SweepMotion { from: pose(17), to: pose(65) },
            })
        });
        pieces.collect::<Result<Vec<_>, _>>().map(Some)
    }
}
