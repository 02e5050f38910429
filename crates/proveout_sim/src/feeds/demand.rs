//! What the cut asks of the feed: loads of every sample, and the largest feed of every line.

use std::collections::BTreeMap;

use proveout_feeds::{Binds, BlockDemand, CutLoads, ForceModel, Loads, ToolLimits};
use rayon::prelude::*;

use crate::feeds::{
    program_feeds::KeptWhy,
    twin::{TwinBlock, TwinRun},
    window,
};

/// Sine of the angle between feed and axis below which a motion goes straight down: 3 degrees, as the stock
/// counts it.
const ACROSS: f64 = 0.052;
/// By how much of its length the way of the tip may differ from a block whose feed is the speed of the tip.
const OFF_TIP: f64 = 0.02;
/// The same for short blocks, mm.
const OFF_TIP_MM: f64 = 0.02;

/// A tool of the program with its limits; by place in the library.
#[derive(Debug)]
pub(crate) struct ToolRule {
    /// None: its teeth are not known, and no limit asks for them.
    pub(crate) model: Option<ForceModel>,
    /// Forces are known, not the chip alone.
    pub(crate) has_material: bool,
    /// None: the limits do not name it.
    pub(crate) limits: Option<ToolLimits>,
}

/// Loads of a sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SampleLoads {
    /// At the feed of the run.
    pub(crate) loads: Loads,
    /// Largest feed that keeps the limits, mm/s, and what sets it.
    pub(crate) limit: Option<(f64, Binds)>,
    /// A limit that is passed at any feed.
    pub(crate) no_feed: Option<Binds>,
    /// The worst load over its limit, and which.
    pub(crate) over: Option<(f64, Binds)>,
    pub(crate) chip_per_feed: f64,
    pub(crate) plunges: bool,
    pub(crate) at_rest: bool,
}

/// Loads of all samples of a run, in their order.
pub(crate) fn sample_loads(run: &TwinRun, rules: &BTreeMap<usize, ToolRule>) -> Vec<SampleLoads> {
    let of = |(sample, slices): (&_, &Vec<_>)| {
        let sample: &crate::EngagedSample = sample;
        let mut out = SampleLoads::default();
        let [across, down] = sample.feed_at(0.0);
        out.plunges = down > 0.0 && across < ACROSS * across.hypot(down);
        out.at_rest = sample.speed_rpm <= 0.0 || sample.speed_rpm.is_nan();
        let Some(rule) = rules.get(&sample.tool) else { return out };
        let Some(model) = &rule.model else { return out };
        let Some(cut): Option<CutLoads> = model.loads(&window::cuts(sample, slices), sample.speed_rpm) else {
            return out;
        };
        out.loads = cut.at(1.0);
        let speed = sample.tip_speed();
        if speed > 0.0 {
            out.chip_per_feed = out.loads.chip_mm / speed;
        }
        if let Some(limits) = &rule.limits {
            out.over = cut.over(1.0, limits);
            match cut.largest_scale(limits) {
                Ok(scale) => out.limit = scale.filter(|_| speed > 0.0).map(|(scale, binds)| (scale * speed, binds)),
                Err(binds) => out.no_feed = Some(binds),
            }
        }
        out
    };
    run.samples.par_iter().zip(&run.slices).map(of).collect()
}

/// What a line asks for, over all of its executions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LineDemand {
    pub(crate) demand: BlockDemand,
    pub(crate) tool: Option<usize>,
    pub(crate) kept: Option<KeptWhy>,
    pub(crate) no_feed: Option<Binds>,
}

/// The demands of the lines of the main program. `file` is its name in blocks.
pub(crate) fn lines(run: &TwinRun, loads: &[SampleLoads], file: &str) -> BTreeMap<u32, LineDemand> {
    let mut all: BTreeMap<u32, LineDemand> = BTreeMap::new();
    let mut line_of: BTreeMap<u32, u32> = BTreeMap::new();
    for block in run.blocks.iter().filter(|b| *b.row.file == *file) {
        let Some(feed) = block.row.feed else { continue };
        let line = all.entry(block.row.line).or_default();
        line_of.insert(block.row.block, block.row.line);
        line.demand.programmed = line.demand.programmed.max(feed);
        line.tool = block.row.tool.map(|t| t as usize);
        line.demand.engaged |= block.row.volume_mm3 > 0.0;
        if block.coupled {
            line.kept = line.kept.or(Some(KeptWhy::Cycle));
        } else if !feed_is_of_tip(block) {
            line.kept = line.kept.or(Some(KeptWhy::NotTheTip));
        }
    }
    for (sample, of_sample) in run.samples.iter().zip(loads) {
        let Some(line) = line_of.get(&sample.block).and_then(|line| all.get_mut(line)) else { continue };
        let demand = &mut line.demand;
        demand.engaged = true;
        demand.chip_per_feed = demand.chip_per_feed.max(of_sample.chip_per_feed);
        if let Some((feed, binds)) = of_sample.limit
            && demand.limit.is_none_or(|(least, _)| feed < least)
        {
            demand.limit = Some((feed, binds));
        }
        line.no_feed = line.no_feed.or(of_sample.no_feed);
        if of_sample.at_rest {
            line.kept = line.kept.or(Some(KeptWhy::SpindleAtRest));
        } else if of_sample.plunges {
            line.kept = line.kept.or(Some(KeptWhy::Plunge));
        }
    }
    all
}

/// Whether the feed of a block is the speed of the tip along its path.
fn feed_is_of_tip(block: &TwinBlock) -> bool {
    (block.tip_way - block.row.length).abs() <= OFF_TIP * block.row.length.abs() + OFF_TIP_MM
}
