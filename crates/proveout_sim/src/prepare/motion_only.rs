//! Motion of a program without stock: times, extremes of the joints, and what the program asks of them.
//!
//! *Cutting stretch.* A run is a sequence of blocks in feed without rapid motion or tool change between them.
//! From each run the blocks within `trimmed_ends_s` of programmed time from both ends are left out: approach,
//! run-up and retract. Programmed time is length over programmed feed, so that programs of the same structure
//! keep the same blocks.
//!
//! *Extremes* are those of the set points at the control samples that belong to the blocks of the stretch. A
//! joint reverses where it turns back by more than a dead band; the reversal belongs to the block in which it
//! turns.
//!
//! *Demand* is what the program asks of a joint at its programmed feed, whatever the joint can do: with
//! positions `q_i` at the ends of the blocks and programmed times `t_i`, `v_i = (q_i - q_(i-1)) / t_i` and
//! `a_i = 2 (v_(i+1) - v_i) / (t_i + t_(i+1))`. The steps are the blocks of the program. The acceleration of
//! a path with corners grows with a finer step, so that only programs of equal steps can be compared.
//!
//! *Tip with the joints led straight* is what a control without tool center point control makes of the
//! blocks: the tip's largest distance from the chord of its places at both ends of a block, the joints being
//! mixed linearly between them.
//!
//! *Motion that comes from turning* (concomitant motion of Lu et al. 2022): the rotary joints turn
//! by dr over a block; with the tip held where it is on the table the linear joints must move by
//! `-J_lin^-1 J_rot dr`. Its length over that of the tip's chord says how many mm the slides move
//! for each mm of the path, in addition to the path itself. The derivatives are those in the middle
//! of the block.

use std::collections::BTreeMap;

use proveout_controller::{
    BlockKind, BlockRecord, Chunk, Controller, Dynamics, Event, LimitKind, MoveKind, Settings as ControlSettings,
    Summary,
};
use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{Joint, JointKind, JointValues, MAX_JOINTS, Machine};
use proveout_nc::{Command, Diagnostic, Op, PathMode, Program, Settings as NcSettings};
use proveout_tool::{Tool, ToolLibrary};

use crate::{
    prepare::{
        control_settings::control_settings,
        depth_gauge::{Deep, DepthGauge},
        error::{SimError, from_run_error},
        prepared::Prepared,
        program_survey::known_offset,
        reader_settings::settings_of_made,
    },
    scene::Scene,
};

/// Places between two blocks at which the tip is computed with the joints led straight.
const BETWEEN: usize = 40;
/// Part of a programmed time that sums of it may differ by: rounding.
const ROUNDING: f64 = 1e-9;

/// Motion back over less than this is no reversal, mm and radian: numbers of a text, not motions that a drive
/// shows.
const DEAD_BAND: (f64, f64) = (1e-3, 1e-6);

/// A program on its machine, without a stock.
#[derive(Clone, Debug)]
pub(crate) struct MotionCase {
    pub(crate) machine: Machine,
    /// The machine with its own limits, where the scene sets others.
    pub(crate) own_machine: Option<Machine>,
    pub(crate) settings: ControlSettings,
    /// Factor of the path tolerances that the program sets.
    pub(crate) tolerance_factor: f64,
    source: Source,
    nc: NcSettings,
    tools: ToolLibrary,
    scene: String,
    /// What depths are measured from; none where depths are not asked for.
    gauge: Option<DepthGauge>,
}

/// Where the words of a program are.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Text { name: String, text: String },
    File(std::path::PathBuf),
}

impl Source {
    pub(crate) fn program(&self, settings: &NcSettings) -> Result<Program, SimError> {
        Ok(match self {
            Self::Text { name, text } => Program::from_text(name, text.as_str(), settings)?,
            Self::File(path) => Program::open(path, settings)?,
        })
    }
}

/// A block in feed.
#[derive(Clone, Debug)]
pub(crate) struct FeedBlock {
    /// Number of the run that it belongs to.
    pub(crate) run: u32,
    /// Begin and end, s.
    pub(crate) time: [f64; 2],
    /// Time by the programmed feed, s.
    pub(crate) programmed: f64,
    /// Length of the programmed path, mm.
    pub(crate) length: f64,
    /// Positions at its end.
    pub(crate) end: JointValues,
    /// Tip at its end, table frame.
    pub(crate) tip: Point,
    /// Center of the ball at its end in the table frame, where the tool is a ball.
    pub(crate) center: Option<Point>,
    pub(crate) high: [JointValues; 3],
    /// Number of the block.
    pub(crate) index: u32,
    /// How deep the ball cut, piece by piece; empty where depths are not asked for or the tool is
    /// no ball.
    pub(crate) deep: Vec<Deep>,
}

/// Where a joint turns.
#[derive(Clone, Copy, Debug, Default)]
struct Turning {
    /// Direction of motion; 0 before it is known.
    direction: i8,
    /// Lowest and highest position since the last turn, and the block of each.
    low: (f64, u32),
    high: (f64, u32),
    begun: bool,
}

impl Turning {
    /// Takes a position; gives the block in which the joint has turned, once it has moved back by more than
    /// the band.
    fn position(&mut self, q: f64, block: u32, band: f64) -> Option<u32> {
        if !self.begun {
            *self = Self { direction: 0, low: (q, block), high: (q, block), begun: true };
            return None;
        }
        if q <= self.low.0 {
            self.low = (q, block);
        }
        if q >= self.high.0 {
            self.high = (q, block);
        }
        let back = if self.high.0 - q > band { -1 } else { i8::from(q - self.low.0 > band) };
        if back == 0 || back == self.direction {
            // Same direction as before: the extreme already passed can no longer be a turning
            // point.
            match self.direction {
                1 => self.low = (q, block),
                -1 => self.high = (q, block),
                _ => {}
            }
            return None;
        }
        let turned = if back < 0 { self.high.1 } else { self.low.1 };
        let known = self.direction != 0;
        *self = Self { direction: back, low: (q, block), high: (q, block), begun: true };
        known.then_some(turned)
    }
}

/// Motion of a whole program.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub(crate) summary: Summary,
    pub(crate) blocks: Vec<FeedBlock>,
    /// The same blocks along the programmed path; their extremes are those of the set points.
    pub(crate) programmed: Vec<FeedBlock>,
    /// Joints that a block sends past their travel.
    pub(crate) over_travels: Vec<OverTravel>,
    /// Reversals of each joint by block; blocks without one are not there.
    pub(crate) reversals: BTreeMap<u32, [u32; MAX_JOINTS]>,
}

/// A joint that a block sends past its travel, mm or radian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OverTravel {
    /// Number of the block, as [`FeedBlock::index`].
    pub(crate) block: u32,
    pub(crate) joint: usize,
    pub(crate) value: f64,
    pub(crate) limit: f64,
}

/// Extremes of a joint over the cutting stretch, mm or radian and s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Extremes {
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) reversals: u32,
}

/// Demand of the program at the end of a block of the cutting stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DemandPoint {
    /// Programmed time since the begin of the stretch, s.
    pub(crate) time: f64,
    pub(crate) position: JointValues,
    pub(crate) velocity: JointValues,
    /// None at the last block of a run.
    pub(crate) acceleration: Option<JointValues>,
}

impl MotionCase {
    pub(crate) fn new(prepared: &Prepared) -> Result<Self, SimError> {
        let dialect = prepared.program()?.dialect();
        let source = match &prepared.made {
            Some(made) => Source::Text { name: made.file.clone(), text: made.text.clone() },
            None => Source::File(prepared.program_path.clone()),
        };
        Ok(Self {
            machine: prepared.machine.clone(),
            own_machine: prepared.own_machine.clone(),
            settings: prepared.control_settings(dialect),
            tolerance_factor: 1.0,
            source,
            nc: prepared.nc_settings.clone(),
            tools: prepared.tools.clone(),
            scene: prepared.scene.path.display().to_string(),
            gauge: DepthGauge::of_scene(&prepared.scene),
        })
    }

    /// The program that a prepared one is re-scheduled from, on the same machine.
    pub(crate) fn of_source(prepared: &Prepared) -> Result<Self, SimError> {
        let planned = prepared.made.as_ref().and_then(|made| made.planned.as_ref());
        let (source, nc) = match planned {
            Some(text) => {
                let nc = settings_of_made(prepared.source_nc_settings.clone());
                (Source::Text { name: "planned.mpf".into(), text: text.clone() }, nc)
            }
            None => (Source::File(prepared.program_path.clone()), prepared.source_nc_settings.clone()),
        };
        let settings = prepared.control_settings(source.program(&nc)?.dialect());
        Ok(Self { settings, source, nc, ..Self::new(prepared)? })
    }

    /// A program on a machine of a scene, by the planned set points.
    pub(crate) fn planned(
        scene: &Scene,
        machine: &Machine,
        tools: &ToolLibrary,
        nc: &NcSettings,
        source: Source,
    ) -> Result<Self, SimError> {
        let dialect = source.program(nc)?.dialect();
        Ok(Self {
            machine: machine.clone(),
            own_machine: None,
            settings: control_settings(scene, dialect),
            tolerance_factor: 1.0,
            source,
            nc: nc.clone(),
            tools: tools.clone(),
            scene: scene.path.display().to_string(),
            gauge: None,
        })
    }

    /// Another program on another machine of the same scene.
    pub(crate) fn with(&self, machine: Machine, settings: ControlSettings, source: Source, nc: NcSettings) -> Self {
        Self { machine, own_machine: None, settings, source, nc, ..self.clone() }
    }

    /// The same with depths from the part of another scene.
    pub(crate) fn measured_on(self, scene: &Scene) -> Self {
        Self { gauge: DepthGauge::of_scene(scene), ..self }
    }

    /// The same without depths: for times alone.
    pub(crate) fn unmeasured(self) -> Self {
        Self { gauge: None, ..self }
    }

    /// How the reader is set.
    pub(crate) fn nc(&self) -> &NcSettings {
        &self.nc
    }

    /// Tools that the programs call.
    pub(crate) fn tools(&self) -> &ToolLibrary {
        &self.tools
    }

    /// By the planned set points, without depths.
    pub(crate) fn planned_only(self) -> Self {
        let settings = ControlSettings { dynamics: Dynamics::Planned, ..self.settings };
        Self { settings, gauge: None, ..self }
    }

    /// Runs the program.
    ///
    /// # Errors
    /// What keeps the program from being executed.
    pub(crate) fn run(&self) -> Result<Motion, SimError> {
        self.of(self.source.program(&self.nc)?)
    }

    /// Runs commands in place of the program's.
    ///
    /// # Errors
    /// What keeps them from being executed.
    pub(crate) fn of_commands(&self, commands: Vec<Command>) -> Result<Motion, SimError> {
        self.of(commands.into_iter().map(Ok))
    }

    fn of(&self, program: impl Iterator<Item = Result<Command, Diagnostic>>) -> Result<Motion, SimError> {
        let commands = program.map(|command| command.and_then(|c| known_offset(self.scaled(c), &self.nc, &self.scene)));
        let mut controller = Controller::new(commands, &self.machine, &self.tools.tools, self.settings.clone())?;
        let band = |j: &Joint| if j.kind == JointKind::Rotary { DEAD_BAND.1 } else { DEAD_BAND.0 };
        let bands = self.machine.joints.iter().map(band).collect();
        let gauge = self.gauge.as_ref();
        let mut record = Record { tools: &self.tools.tools, gauge, bands, ..Record::default() };
        while let Some(chunk) = controller.next_chunk().map_err(from_run_error)? {
            record.take(&chunk);
        }
        let Record { blocks, programmed, over_travels, reversals, .. } = record;
        Ok(Motion { summary: controller.summary(), blocks, programmed, over_travels, reversals })
    }

    fn scaled(&self, mut command: Command) -> Command {
        if let Op::PathMode(PathMode::Continuous { tolerance, orientation_tolerance }) = &mut command.op {
            for value in [tolerance, orientation_tolerance].into_iter().flatten() {
                *value *= self.tolerance_factor;
            }
        }
        command
    }
}

/// What is known of a block before it has ended.
#[derive(Clone, Debug, Default)]
struct Open {
    end: Option<(JointValues, ToolPose)>,
    high: [JointValues; 3],
    deep: Vec<Deep>,
}

#[derive(Default)]
struct Record<'a> {
    tools: &'a [Tool],
    gauge: Option<&'a DepthGauge>,
    open: BTreeMap<u32, Open>,
    /// Radius of the ball in the spindle, by the block that brought it.
    balls: BTreeMap<u32, Option<f64>>,
    run: u32,
    in_run: bool,
    blocks: Vec<FeedBlock>,
    programmed: Vec<FeedBlock>,
    over_travels: Vec<OverTravel>,
    bands: Vec<f64>,
    turning: [Turning; MAX_JOINTS],
    reversals: BTreeMap<u32, [u32; MAX_JOINTS]>,
}

impl Record<'_> {
    fn take(&mut self, chunk: &Chunk) {
        for event in &chunk.events {
            if let Event::ToolChange { block, tool, .. } = event {
                let tool = tool.and_then(|t| self.tools.get(t));
                let ball = tool.and_then(|t| t.cutting().next()).and_then(|body| body.profile.ball_radius());
                self.balls.insert(*block, ball);
            }
            if let Event::Limit { block, joint: Some(joint), value, limit, kind: LimitKind::Travel, .. } = *event {
                self.over_travels.push(OverTravel { block, joint, value, limit });
            }
        }
        for piece in chunk.pieces.iter().filter(|p| p.kind == MoveKind::Feed) {
            let ball = self.balls.range(..=piece.block).next_back().and_then(|(_, ball)| *ball);
            let open = self.open.entry(piece.block).or_default();
            let [from, to] = &piece.pose;
            open.end = Some((piece.joints[1], *to));
            if let (Some(gauge), Some(radius)) = (self.gauge, ball) {
                let depth = gauge.depth(&(to.tip + to.axis * radius), radius);
                open.deep.push(Deep { way: (to.tip - from.tip).norm(), depth });
            }
        }
        for sample in &chunk.samples {
            if sample.kind != MoveKind::Feed {
                // What lies between two runs is no reversal of either.
                self.turning = <[Turning; MAX_JOINTS]>::default();
                continue;
            }
            for (joint, (turning, band)) in self.turning.iter_mut().zip(&self.bands).enumerate() {
                if let Some(block) = turning.position(sample.commanded[joint], sample.block, *band) {
                    self.reversals.entry(block).or_default()[joint] += 1;
                }
            }
            let open = self.open.entry(sample.block).or_default();
            let values = [&sample.velocity, &sample.acceleration, &sample.jerk];
            for (high, value) in open.high.iter_mut().zip(values) {
                *high = high.zip_map(*value, |m, v| m.max(v.abs()));
            }
        }
        for block in &chunk.blocks {
            self.ended(block);
        }
    }

    fn ended(&mut self, block: &BlockRecord) {
        let open = self.open.remove(&block.index).unwrap_or_default();
        match block.kind {
            BlockKind::Move(MoveKind::Feed) => {
                if !self.in_run {
                    (self.in_run, self.run) = (true, self.run + 1);
                }
                let ball = self.balls.range(..=block.index).next_back().and_then(|(_, ball)| *ball);
                let of = |(end, pose): (JointValues, ToolPose), deep: Vec<Deep>| FeedBlock {
                    run: self.run,
                    time: [block.start_time, block.end_time],
                    programmed: if block.feed > 0.0 { block.programmed_length / block.feed } else { 0.0 },
                    length: block.programmed_length,
                    end,
                    tip: pose.tip,
                    center: ball.map(|radius| pose.tip + pose.axis * radius),
                    high: open.high,
                    index: block.index,
                    deep,
                };
                self.programmed.extend(block.programmed_end.map(|end| of(end, Vec::new())));
                self.blocks.extend(open.end.map(|end| of(end, open.deep)));
            }
            BlockKind::Move(_) | BlockKind::ToolChange => self.in_run = false,
            BlockKind::Dwell | BlockKind::Action => {}
        }
    }
}

impl Motion {
    /// The programmed path itself, at the planned times: what a control makes of it has no part in what a
    /// program asks for.
    pub(crate) fn along_program(&self) -> Self {
        let Self { summary, programmed, over_travels, reversals, .. } = self.clone();
        Self { summary, blocks: programmed, programmed: Vec::new(), over_travels, reversals }
    }

    /// Ranges of blocks that belong to the cutting stretch, one for each run that has any.
    pub(crate) fn stretch(&self, ends: f64) -> Vec<std::ops::Range<usize>> {
        let mut out = Vec::new();
        let mut first = 0;
        for run in self.blocks.chunk_by(|a, b| a.run == b.run) {
            let total: f64 = run.iter().map(|b| b.programmed).sum();
            // Sums of the same terms in the same order: a little slack keeps blocks that end exactly at the
            // border.
            let slack = ROUNDING * total;
            let mut from = 0.0;
            let mut inside = first..first;
            for (i, block) in run.iter().enumerate() {
                let to = from + block.programmed;
                if from >= ends - slack && to <= total - ends + slack {
                    if inside.is_empty() {
                        inside.start = first + i;
                    }
                    inside.end = first + i + 1;
                }
                from = to;
            }
            if !inside.is_empty() {
                out.push(inside);
            }
            first += run.len();
        }
        out
    }

    /// Time that the stretch takes, s.
    pub(crate) fn stretch_time(&self, stretch: &[std::ops::Range<usize>]) -> f64 {
        let blocks = |r: &std::ops::Range<usize>| self.blocks.get(r.clone()).unwrap_or_default().iter();
        stretch.iter().flat_map(blocks).map(|b| b.time[1] - b.time[0]).sum()
    }

    /// Extremes of every joint over the stretch.
    pub(crate) fn extremes(&self, stretch: &[std::ops::Range<usize>]) -> Vec<Extremes> {
        let mut all = vec![Extremes::default(); self.summary.joints.len()];
        for range in stretch {
            for block in self.blocks.get(range.clone()).unwrap_or_default() {
                for (joint, e) in all.iter_mut().enumerate() {
                    e.velocity = e.velocity.max(block.high[0][joint]);
                    e.acceleration = e.acceleration.max(block.high[1][joint]);
                    e.jerk = e.jerk.max(block.high[2][joint]);
                    e.reversals += self.reversals.get(&block.index).map_or(0, |r| r[joint]);
                }
            }
        }
        all
    }

    /// What the program asks of the joints over the stretch.
    pub(crate) fn demand(&self, stretch: &[std::ops::Range<usize>]) -> Vec<DemandPoint> {
        let mut out: Vec<DemandPoint> = Vec::new();
        let mut time = 0.0;
        for range in stretch {
            let begin = out.len();
            let mut step_before = 0.0;
            for i in range.clone() {
                let Some(block) = self.blocks.get(i) else { continue };
                time += block.programmed;
                let before = i.checked_sub(1).and_then(|k| self.blocks.get(k)).filter(|b| b.run == block.run);
                let (Some(before), true) = (before, block.programmed > 0.0) else { continue };
                let step = block.programmed;
                let velocity = block.end.zip_map(before.end, |b, a| (b - a) / step);
                if let Some(last) = out.get_mut(begin..).and_then(<[DemandPoint]>::last_mut) {
                    let span = 0.5 * (step_before + step);
                    last.acceleration = Some(velocity.zip_map(last.velocity, |b, a| (b - a) / span));
                }
                step_before = step;
                out.push(DemandPoint { time, position: block.end, velocity, acceleration: None });
            }
        }
        out
    }

    /// Pairs of neighboring blocks of the stretch.
    fn pairs<'a>(
        &'a self,
        stretch: &'a [std::ops::Range<usize>],
    ) -> impl Iterator<Item = (&'a FeedBlock, &'a FeedBlock)> {
        let places = stretch.iter().flat_map(Clone::clone);
        let pair = |i: usize| Some((self.blocks.get(i.checked_sub(1)?)?, self.blocks.get(i)?));
        places.filter_map(pair).filter(|(a, b)| a.run == b.run)
    }

    /// Sum of the steps of each joint over the stretch, mm or radian.
    pub(crate) fn travel(&self, stretch: &[std::ops::Range<usize>]) -> JointValues {
        self.pairs(stretch).fold(JointValues::ZERO, |sum, (a, b)| {
            let step = b.end.zip_map(a.end, |b, a| (b - a).abs());
            sum.zip_map(step, |s, d| s + d)
        })
    }

    /// Largest range of each joint within a range of the stretch, mm or radian.
    pub(crate) fn range(&self, stretch: &[std::ops::Range<usize>]) -> JointValues {
        let mut widest = JointValues::ZERO;
        for range in stretch {
            let blocks = self.blocks.get(range.clone()).unwrap_or_default();
            let Some(first) = blocks.first() else { continue };
            let (mut low, mut high) = (first.end, first.end);
            for block in blocks {
                low = low.zip_map(block.end, f64::min);
                high = high.zip_map(block.end, f64::max);
            }
            widest = widest.zip_map(high - low, f64::max);
        }
        widest
    }

    /// Largest motion of the linear joints that comes from turning, for each mm of the tip's path,
    /// mm/mm. None where it is undefined: not exactly three linear joints, or no rotary joint.
    pub(crate) fn motion_from_turning(&self, machine: &Machine, stretch: &[std::ops::Range<usize>]) -> Option<f64> {
        let of = |rotary: bool| move |j: &usize| machine.joints[*j].is_rotary() == rotary && !machine.joints[*j].held;
        let joints = 0..machine.joints.len();
        let slides: [usize; 3] = joints.clone().filter(of(false)).collect::<Vec<_>>().try_into().ok()?;
        let turns: Vec<usize> = joints.filter(of(true)).collect();
        if turns.is_empty() {
            return None;
        }
        let one = |(a, b): (&FeedBlock, &FeedBlock)| {
            let way = (b.tip - a.tip).norm();
            if way == 0.0 {
                return None;
            }
            let middle = a.end.zip_map(b.end, |a, b| 0.5 * (a + b));
            let length = |block: &FeedBlock| (machine.forward(&block.end, 0.0).tip - block.tip).norm();
            let jacobian = machine.jacobian(&middle, length(b));
            let column = |j: usize| jacobian.fixed_view::<3, 1>(0, j).into_owned();
            let moved = turns.iter().fold(Vector::zeros(), |sum, &j| sum + column(j) * (b.end[j] - a.end[j]));
            let slide = nalgebra::Matrix3::from_columns(&slides.map(column));
            Some(slide.try_inverse().map(|inverse| (inverse * moved).norm() / way))
        };
        self.pairs(stretch).filter_map(one).collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max)
    }

    /// Largest distance of the tip from its chord where the joints run straight from block to block, mm; none
    /// without a block.
    pub(crate) fn straight_joints(&self, machine: &Machine, stretch: &[std::ops::Range<usize>]) -> Option<f64> {
        let worst = |(a, b): (&FeedBlock, &FeedBlock)| {
            let length = |block: &FeedBlock| (machine.forward(&block.end, 0.0).tip - block.tip).norm();
            let (chord, long) = (b.tip - a.tip, length(b));
            let off = |k: usize| {
                let part = k as f64 / BETWEEN as f64;
                let q = a.end.zip_map(b.end, |a, b| a + (b - a) * part);
                let from = machine.forward(&q, long).tip - a.tip;
                let along = if chord.norm() > 0.0 { from.dot(&chord) / chord.norm_squared() } else { 0.0 };
                (from - chord * along.clamp(0.0, 1.0)).norm()
            };
            (1..BETWEEN).map(off).fold(0.0, f64::max)
        };
        self.pairs(stretch).map(worst).reduce(f64::max)
    }

    /// Largest distance of ball centers at the ends of blocks, mm; none where a tool is no ball or the
    /// programs differ in structure.
    pub(crate) fn center_shift(&self, other: &Self) -> Option<f64> {
        let same = self.blocks.len() == other.blocks.len() && !self.blocks.is_empty();
        let pairs = self.blocks.iter().zip(&other.blocks);
        let shifts: Option<Vec<f64>> =
            pairs.map(|(a, b)| a.center.zip(b.center).map(|(a, b)| (a - b).norm())).collect();
        shifts.filter(|_| same).map(|s| s.into_iter().fold(0.0, f64::max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(run: u32, programmed: f64, position: f64) -> FeedBlock {
        let mut end = JointValues::ZERO;
        end[0] = position;
        FeedBlock {
            run,
            time: [0.0, 2.0 * programmed],
            programmed,
            length: programmed,
            end,
            tip: Point::origin(),
            center: None,
            high: [JointValues::ZERO; 3],
            index: 0,
            deep: Vec::new(),
        }
    }

    fn motion(blocks: Vec<FeedBlock>) -> Motion {
        Motion {
            summary: Summary::default(),
            blocks,
            programmed: Vec::new(),
            over_travels: Vec::new(),
            reversals: BTreeMap::new(),
        }
    }

    #[test]
    fn the_ends_of_every_run_are_left_out() {
        let all = (0..10).map(|i| block(1, 0.1, f64::from(i))).chain((0..3).map(|i| block(2, 0.1, f64::from(i))));
        let motion = motion(all.collect());
        assert_eq!(motion.stretch(0.0), [0..10, 10..13]);
        assert_eq!(motion.stretch(0.2).as_slice(), std::slice::from_ref(&(2..8)));
        assert!((motion.stretch_time(&motion.stretch(0.2)) - 1.2).abs() < 1e-12, "six blocks of twice their time");
        assert_eq!(motion.stretch(0.5), []);
    }

    #[test]
    fn the_demand_of_a_parabola_is_its_acceleration() {
        // q = 3 t^2 with unequal steps: second differences of a parabola are exact.
        let mut t = 0.0;
        let blocks = (0..20).map(|i| {
            let step = 0.1 + 0.03 * f64::from(i % 4);
            t += step;
            block(1, step, 3.0 * t * t)
        });
        let motion = motion(blocks.collect());
        let demand = motion.demand(&motion.stretch(0.0));
        assert_eq!(demand.len(), 19, "the first block comes from an unknown place");
        for point in &demand[..18] {
            assert!((point.acceleration.expect("inner")[0] - 6.0).abs() < 1e-9);
        }
        assert_eq!(demand[18].acceleration, None);
    }

    #[test]
    fn a_joint_reverses_where_it_turns_back_by_more_than_the_band() {
        let turns = |positions: &[f64], band: f64| -> Vec<u32> {
            let mut turning = Turning::default();
            (0..).zip(positions).filter_map(|(block, q)| turning.position(*q, block, band)).collect()
        };
        // Up to 3 at place 3, down to -1 at place 7, up, and down again from the last place of a plateau.
        let path = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, -1.0, 0.0, 5.0, 5.0, 5.0, 4.0];
        assert_eq!(turns(&path, 0.5), [3, 7, 11]);
        assert_eq!(turns(&path, 1.5), [3, 7], "the last way back is shorter than the band");
        assert!(turns(&path, 10.0).is_empty());
        // Noise on a way up is no reversal; without a band it is.
        let noisy: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01 + if i % 2 == 0 { 0.02 } else { 0.0 }).collect();
        assert!(turns(&noisy, 0.05).is_empty());
        assert!(turns(&noisy, 0.0).len() > 90);
        // A slow way back counts when it adds up.
        let slow: Vec<f64> =
            (0..100).map(|i| if i < 50 { f64::from(i) } else { 49.0 - 0.01 * f64::from(i - 49) }).collect();
        assert_eq!(turns(&slow, 0.1), [49]);
    }
}
