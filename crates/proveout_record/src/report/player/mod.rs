//! The player of the page: blocks, joints, tool, machine and stock at every moment of the run, in few bytes.
//!
//! | file | what it holds |
//! |---|---|
//! | `bodies.rs` | meshes of machine, fixtures, tools, design; data of the kinematics |
//! | `knots.rs` | signals over time within a tolerance |
//! | `steps.rs` | the blocks, one a step |
//! | `stock_moments.rs` | the stock at moments of the run |

mod bodies;
mod knots;
mod steps;
mod stock_moments;

use std::collections::VecDeque;

use proveout_controller::Event;
use proveout_machine::JointValues;
use proveout_sim::{
    finding::Finding,
    observer::{Batch, Setup},
};
use serde_json::{Value, json};

use self::{
    bodies::{DetachedParts, PackedMeshes},
    knots::KnotSeries,
    steps::PlayedSteps,
    stock_moments::StockMoments,
};
use crate::{
    report::{
        blocks::{Blocks, LineNumbers},
        findings::{class, id},
        format::{compact, count, length},
        operations::Operation,
    },
    units::{JointUnit, PER_MINUTE},
};

/// First tolerance of joint positions, mm or degrees.
const JOINT_TOLERANCE: f64 = 0.02;
/// Steps in which joint positions are written, mm or degrees.
const JOINT_STEP: f64 = 1e-3;
/// First tolerance of the feed, mm/min, and its steps.
const FEED_TOLERANCE: f64 = 15.0;
const FEED_STEP: f64 = 1.0;
/// First tolerance of the load of a drive, percent of its limit, and its steps.
const LOAD_TOLERANCE: f64 = 2.0;
const LOAD_STEP: f64 = 0.5;
/// Most findings, tool changes and operations that can be jumped to.
const MOST_JUMPS: usize = 1000;
/// Longest text of a jump, characters.
const MOST_CHARS: usize = 90;

/// What the page needs to play the run.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlayerView {
    pub(crate) data: Value,
    /// Steps, then joints, feed and loads.
    pub(crate) motion: Vec<u8>,
    pub(crate) meshes: Vec<u8>,
    pub(crate) stock: Vec<u8>,
    pub(crate) notes: Vec<String>,
}

/// Gathers it while the run goes on.
#[derive(Debug)]
pub(crate) struct Player {
    units: Vec<JointUnit>,
    /// Highest force of each drive, where drives are simulated.
    forces: Vec<Option<f64>>,
    steps: PlayedSteps,
    joints: KnotSeries,
    feed: KnotSeries,
    loads: KnotSeries,
    /// Ends of blocks that are later than the samples so far.
    ends: VecDeque<(f64, JointValues)>,
    /// Time and index of each tool that comes into the spindle.
    changes: Vec<(f64, Option<usize>)>,
    used: Vec<bool>,
    loose: DetachedParts,
    stock: StockMoments,
    row: Vec<f64>,
}

impl Player {
    pub(crate) fn new(setup: &Setup<'_>) -> Self {
        let units = JointUnit::all(setup.machine);
        let joints = setup.machine.joints.len();
        let force = |(j, u): (&proveout_machine::Joint, &JointUnit)| {
            j.drive.as_ref().and_then(|d| d.max_force).filter(|f| *f > 0.0).map(|f| f * u.force_factor)
        };
        Self {
            forces: setup.machine.joints.iter().zip(&units).map(force).collect(),
            units,
            steps: PlayedSteps::default(),
            joints: KnotSeries::new(vec![JOINT_TOLERANCE; joints]),
            feed: KnotSeries::new(vec![FEED_TOLERANCE]),
            loads: KnotSeries::new(vec![LOAD_TOLERANCE; joints]),
            ends: VecDeque::new(),
            changes: Vec::new(),
            used: vec![false; setup.tools.tools.len()],
            loose: DetachedParts::default(),
            stock: StockMoments::new(setup),
            row: Vec::new(),
        }
    }

    pub(crate) fn take(&mut self, setup: &Setup<'_>, batch: &Batch<'_>, blocks: &Blocks) {
        self.steps.take(batch.blocks);
        for (k, piece) in batch.pieces.iter().enumerate() {
            if batch.pieces.get(k + 1).is_none_or(|next| next.block != piece.block) {
                self.ends.push_back((piece.time[1], piece.joints[1]));
            }
        }
        for sample in batch.samples {
            self.block_ends(sample.time);
            self.place(sample.time, &sample.actual, false);
            self.feed.push(sample.time, &[sample.feed * PER_MINUTE], false);
            if let Some(drive) = &sample.drive {
                self.row.clear();
                for (k, (unit, limit)) in self.units.iter().zip(&self.forces).enumerate() {
                    let share = limit.map_or(0.0, |l| 100.0 * (drive.force[k] * unit.force_factor).abs() / l);
                    self.row.push(share);
                }
                self.loads.push(sample.time, &self.row, false);
            }
        }
        for event in batch.events {
            if let Event::ToolChange { time, tool, .. } = event {
                self.changes.push((*time, *tool));
                if let Some(used) = tool.and_then(|t| self.used.get_mut(t)) {
                    *used = true;
                }
            }
        }
        self.loose.take(batch.loose);
        self.stock.take(setup, batch, blocks);
    }

    /// Ends of blocks up to a time: the joints are there exactly as they were.
    fn block_ends(&mut self, until: f64) {
        while let Some((time, joints)) = self.ends.pop_front_if(|(time, _)| *time <= until) {
            self.place(time, &joints, true);
        }
    }

    fn place(&mut self, time: f64, joints: &JointValues, exact: bool) {
        self.row.clear();
        self.row.extend(self.units.iter().enumerate().map(|(k, unit)| joints[k] * unit.factor));
        self.joints.push(time, &self.row, exact);
    }

    /// The data of the page; none where nothing has moved.
    pub(crate) fn finish(mut self, setup: &Setup<'_>, run: &PlayedRun<'_>) -> Option<PlayerView> {
        self.block_ends(f64::INFINITY);
        self.joints.finish();
        self.feed.finish();
        self.loads.finish();
        if self.steps.is_empty() || self.joints.len() < 2 {
            return None;
        }
        let mut motion = Vec::new();
        self.steps.pack(run.blocks, run.numbers, &mut motion);
        self.joints.pack(&vec![JOINT_STEP; self.units.len()], &mut motion);
        self.feed.pack(&[FEED_STEP], &mut motion);
        self.loads.pack(&vec![LOAD_STEP; self.units.len()], &mut motion);

        let mut meshes = PackedMeshes::default();
        let bodies = bodies::machine_bodies(setup.machine, &mut meshes);
        let fixtures = bodies::fixtures(setup, &mut meshes);
        let tools = bodies::tools(setup, &self.used, &mut meshes);
        let loose = self.loose.values(&mut meshes);
        let design = bodies::design(setup, &mut meshes);
        let notes = self.notes();
        let cell = self.stock.cell();
        let jumps = json!({
            "tools": self.tool_jumps(&tools),
            "operations": self.operation_jumps(run.operations),
            "findings": finding_jumps(run),
        });
        let moments = self.stock.pack();
        let data = json!({
            "kinematics": bodies::kinematics(setup, &self.units),
            "steps": { "joint": JOINT_STEP, "feed": FEED_STEP, "load": LOAD_STEP },
            "loads": self.loads.len() > 0,
            "stride": self.steps.stride(),
            "end": run.end,
            "bodies": bodies,
            "fixtures": fixtures,
            "tools": tools,
            "loose": loose,
            "design": design,
            "meshes": meshes.count,
            "changes": self.changes.iter().map(|(time, tool)| json!([time, tool])).collect::<Vec<_>>(),
            "jumps": jumps,
            "reach": bodies::reach(setup.machine),
            "cell": cell,
            "steel": bodies::steel(),
        });
        Some(PlayerView {
            data,
            motion,
            meshes: meshes.bytes,
            stock: moments.bytes,
            notes: [notes, vec![stock_note(moments.count, cell)]].concat(),
        })
    }

    fn notes(&self) -> Vec<String> {
        let joint = self.joints.bounds().into_iter().fold(0.0, f64::max);
        let feed = self.feed.bounds().into_iter().fold(0.0, f64::max);
        let mut notes = vec![if joint.is_finite() && feed.is_finite() {
            format!(
                "The player shows joint positions within {} mm or degrees of the samples of the run, at the ends of blocks as they were, and the feed within {} mm/min.",
                compact(joint),
                compact(feed)
            )
        } else {
            "The motion has more turns than the page can hold: positions between the moments that are kept are not exact.".to_owned()
        }];
        if self.steps.stride() > 1 {
            notes.push(format!("One step goes over {} blocks: there are too many for one each.", self.steps.stride()));
        }
        if self.loose.left_out > 0 {
            notes.push(format!("{} more parts that came off are not shown.", count(self.loose.left_out as u64)));
        }
        notes
    }

    fn tool_jumps(&self, tools: &[Value]) -> Vec<Value> {
        let name = |tool: &Option<usize>| {
            tool.and_then(|t| tools.get(t)?.get("name")?.as_str()).unwrap_or("spindle empty").to_owned()
        };
        self.changes
            .iter()
            .take(MOST_JUMPS)
            .map(|(time, tool)| json!({ "time": time, "text": short(&name(tool)) }))
            .collect()
    }

    fn operation_jumps(&self, operations: &[Operation]) -> Vec<Value> {
        let row = |(k, o): (usize, &Operation)| {
            let text = if o.text.is_empty() { format!("Operation {}", k + 1) } else { o.text.clone() };
            json!({ "time": self.steps.begin_of(o.block), "text": short(&text) })
        };
        operations.iter().enumerate().map(row).take(MOST_JUMPS).collect()
    }
}

/// The rest of the run that the player refers to.
pub(crate) struct PlayedRun<'a> {
    pub(crate) blocks: &'a Blocks,
    pub(crate) numbers: &'a LineNumbers,
    pub(crate) operations: &'a [Operation],
    pub(crate) findings: &'a [Finding],
    /// Cycle time, s.
    pub(crate) end: f64,
}

fn finding_jumps(run: &PlayedRun<'_>) -> Vec<Value> {
    let row = |(k, f): (usize, &Finding)| {
        let time = f.time_s.filter(|t| t.is_finite())?;
        let place = f.line.map_or_else(String::new, |line| format!("line {line}: "));
        Some(
            json!({ "time": time, "id": id(k), "class": class(f.severity), "text": short(&format!("{place}{}", f.message)) }),
        )
    };
    let mut all: Vec<Value> = run.findings.iter().enumerate().filter_map(row).take(MOST_JUMPS).collect();
    all.sort_by(|a, b| a["time"].as_f64().unwrap_or(0.0).total_cmp(&b["time"].as_f64().unwrap_or(0.0)));
    all
}

fn stock_note(moments: usize, cell: f64) -> String {
    format!(
        "The stock is kept at {} moments of the run, drawn from rays {} apart; what is thinner may be missing before the end.",
        count(moments as u64),
        length(cell)
    )
}

fn short(text: &str) -> String {
    match text.char_indices().nth(MOST_CHARS) {
        Some((at, _)) => format!("{}…", &text[..at]),
        None => text.to_owned(),
    }
}
