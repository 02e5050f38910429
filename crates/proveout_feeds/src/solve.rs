//! The largest feed that keeps all limits, moment by moment and block by block.
//!
//! All loads grow with the feed, so that the largest scale of a moment is found by halving an interval. A
//! block has the least feed of its moments: a step of engagement within it lowers the feed from its
//! beginning.

use crate::{force::CutLoads, limits::ToolLimits};

/// Scales beyond this are no limit.
const MOST: f64 = 1e6;
/// Relative width at which the search ends.
const WIDTH: f64 = 1e-9;

/// What sets the feed of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Binds {
    /// The largest chip thickness.
    Chip,
    /// The largest force.
    Force,
    /// The largest torque.
    Torque,
    /// The power of the spindle motor.
    Power,
    /// The deflection of the tool.
    Deflection,
    /// `keep_surface`: marks of feed must not grow.
    Surface,
    /// `max_feed_mm_min`.
    MaxFeed,
    /// The feed of the program: no limit asks for less, and none allows to say how much more.
    Programmed,
    /// The new feed would differ by less than the dead band.
    DeadBand,
}

impl Binds {
    /// The word for it in reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Chip => "chip",
            Self::Force => "force",
            Self::Torque => "torque",
            Self::Power => "power",
            Self::Deflection => "deflection",
            Self::Surface => "surface",
            Self::MaxFeed => "max feed",
            Self::Programmed => "programmed feed",
            Self::DeadBand => "dead band",
        }
    }
}

impl CutLoads {
    /// By how much the worst load is at a scale over its limit: 1 is at the limit. None where no limit
    /// counts.
    pub fn over(&self, scale: f64, limits: &ToolLimits) -> Option<(f64, Binds)> {
        let loads = self.at(scale);
        let parts = [
            (limits.max_chip_mm.map(|most| loads.chip_mm / most), Binds::Chip),
            (limits.max_force_n.map(|most| loads.force_peak_n / most), Binds::Force),
            (limits.max_torque_nm.map(|most| loads.torque_peak_nm / most), Binds::Torque),
            (limits.max_power_kw.map(|most| loads.power_kw / most), Binds::Power),
            (limits.max_deflection_um.and_then(|most| Some(loads.deflection_um? / most)), Binds::Deflection),
        ];
        parts
            .into_iter()
            .filter_map(|(ratio, binds)| Some((ratio?, binds)))
            .reduce(|a, b| if b.0 > a.0 { b } else { a })
    }

    /// Largest scale of the feed that keeps the limits, and the limit that is met first; none where no limit
    /// is reached at any feed.
    ///
    /// # Errors
    /// The limit that is passed at the smallest feed: the edge force, or the run-out, is above it.
    pub fn largest_scale(&self, limits: &ToolLimits) -> Result<Option<(f64, Binds)>, Binds> {
        let over = |scale: f64| self.over(scale, limits).filter(|(ratio, _)| *ratio > 1.0);
        let Some((_, mut binds)) = over(MOST) else { return Ok(None) };
        let (mut low, mut high) = (1.0 / MOST, MOST);
        if let Some((_, binds)) = over(low) {
            return Err(binds);
        }
        while high / low - 1.0 > WIDTH {
            let middle = (low * high).sqrt();
            match over(middle) {
                Some((_, which)) => (high, binds) = (middle, which),
                None => low = middle,
            }
        }
        Ok(Some((low, binds)))
    }
}

/// What the feed of a block may be raised and lowered by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedMode {
    /// No feed changes.
    #[default]
    Analyse,
    /// Only blocks without material get a new feed.
    Air,
    /// By chip thickness, and blocks without material.
    Chip,
    /// By all limits, and blocks without material.
    Force,
    /// By the chip thickness that the program itself has, and blocks without material.
    Learned,
}

impl FeedMode {
    /// The limits that count.
    #[must_use]
    pub fn of(self, limits: &ToolLimits) -> ToolLimits {
        let none = ToolLimits { max_feed_mm_min: limits.max_feed_mm_min, ..ToolLimits::default() };
        match self {
            Self::Air => none,
            Self::Chip | Self::Learned => ToolLimits {
                max_chip_mm: limits.max_chip_mm,
                min_chip_mm: limits.min_chip_mm,
                keep_surface: limits.keep_surface,
                ..none
            },
            Self::Analyse | Self::Force => limits.clone(),
        }
    }
}

/// What a block asks for; feeds in mm/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BlockDemand {
    /// Feed of the program.
    pub programmed: f64,
    /// It takes material.
    pub engaged: bool,
    /// Largest feed that keeps the limits, and what sets it; none where no limit is reached.
    pub limit: Option<(f64, Binds)>,
    /// Largest chip thickness for each mm/s of feed, mm.
    pub chip_per_feed: f64,
}

/// The feed of a block and what sets it.
///
/// # Errors
/// The limit under which the chip would be thinner than `min_chip_mm`.
pub fn feed_of_block(
    demand: &BlockDemand,
    limits: &ToolLimits,
    mode: FeedMode,
    dead_band: f64,
) -> Result<(f64, Binds), Binds> {
    let programmed = demand.programmed;
    let highest = limits.max_feed_mm_min.map(|f| f / 60.0);
    let may_rise = mode != FeedMode::Analyse && (mode != FeedMode::Air || !demand.engaged);
    let top = match highest {
        Some(highest) if !may_rise => (programmed.min(highest), Binds::Programmed),
        Some(highest) => (highest, Binds::MaxFeed),
        None => (programmed, Binds::Programmed),
    };
    let top = match limits.keep_surface && demand.engaged && top.0 > programmed {
        true => (programmed, Binds::Surface),
        false => top,
    };
    if mode == FeedMode::Analyse || mode == FeedMode::Air && demand.engaged {
        let passed = demand.limit.filter(|(limit, _)| *limit < programmed);
        return Ok((programmed, passed.map_or(Binds::Programmed, |(_, binds)| binds)));
    }
    let (feed, binds) = match demand.limit {
        Some((limit, binds)) if limit < top.0 => (limit, binds),
        _ => top,
    };
    if let Some(least) = limits.min_chip_mm
        && demand.engaged
        && demand.chip_per_feed > 0.0
        && feed < programmed
        && feed * demand.chip_per_feed < least
    {
        return Err(binds);
    }
    let kept = demand.limit.is_none_or(|(limit, _)| programmed <= limit) && highest.is_none_or(|h| programmed <= h);
    if kept && (feed / programmed - 1.0).abs() < dead_band {
        return Ok((programmed, if feed == programmed { binds } else { Binds::DeadBand }));
    }
    Ok((feed, binds))
}
