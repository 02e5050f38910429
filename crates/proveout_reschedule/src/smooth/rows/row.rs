//! The blocks of a row and what stays of them: ball centers, or contacts of other cutters.

use std::ops::Range;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_path::PathCutter;
use proveout_tool::Profile;

use super::super::super::multi_scale::{BullNose, MultiScale, RowRules};
use super::super::super::touching::{TouchOffset, contacts};
use super::super::super::{CuttingRun, RescheduleError, Surroundings};
use super::SmoothRows;

/// Shortest row, blocks.
const SHORTEST: usize = 5;
/// Contacts that are nearer than this to each other while the tool moves ten times as far are those of a
/// lift, mm.
const LIFTED: f64 = 1e-2;
/// How far below a cutter's top its radius is looked at, part of its height.
const BELOW_TOP: f64 = 1e-6;
/// By how much a wheel is narrower there than at its widest place, part of its radius.
const NARROWER: f64 = 1e-6;

/// A row.
pub(super) struct RowBlocks {
    cutter: PathCutter,
    touching: Vec<TouchOffset>,
    /// The blocks along the surface; lifts before and after them keep to the ends.
    pub(super) stretch: Range<usize>,
    /// Way along the points that stay, mm.
    pub(super) arc: Vec<f64>,
    /// Rules of a bull-nose.
    pub(super) rules: Option<RowRules>,
}

impl RowBlocks {
    pub(super) fn new(
        method: &SmoothRows,
        run: &CuttingRun,
        around: &Surroundings<'_>,
    ) -> Result<Self, RescheduleError> {
        let cutter = PathCutter::new(around.cutter.clone());
        if cutter.ball_radius().is_none() && BullNose::of(around.cutter).is_some() && !narrows(around.cutter) {
            let mut rules = method.rules.rules(run, around, &cutter)?;
            let (stretch, arc) = (rules.stretch.clone(), rules.arc.clone());
            let touching = std::mem::take(&mut rules.contacts);
            return Ok(Self { cutter, touching, stretch, arc, rules: Some(rules) });
        }
        let all = contacts(run, &cutter, around)?;
        let stretch = stretch(&all, run, around, cutter.ball_radius());
        let line = |i: usize| run.blocks.get(i).map_or(0, |b| b.line);
        if stretch.len() < SHORTEST {
            let message = format!("the row has only {} blocks", stretch.len());
            let help = "give a row of five blocks or more";
            return Err(RescheduleError::new("reschedule-layers", line(0), message, help));
        }
        let mut arc = vec![0.0];
        for i in stretch.start + 1..stretch.end {
            arc.push(arc[arc.len() - 1] + (all[i].place.point - all[i - 1].place.point).norm());
        }
        Ok(Self { cutter, touching: all, stretch, arc, rules: None })
    }

    /// Radius of a ball end.
    pub(super) fn ball(&self) -> Option<f64> {
        self.cutter.ball_radius()
    }

    /// Line of a block of the row.
    pub(super) fn line(&self, run: &CuttingRun, i: usize) -> u32 {
        run.blocks.get(self.stretch.start + i).map_or(0, |b| b.line)
    }

    /// The points that stay.
    pub(super) fn points(&self) -> Vec<Point> {
        self.touching[self.stretch.clone()].iter().map(|t| t.place.point).collect()
    }

    /// Normals of the surface at the blocks of the row; none where it is not known or no row of a ball is on
    /// it.
    pub(super) fn normals(&self, around: &Surroundings<'_>) -> Vec<Option<Vector>> {
        let own = &self.touching[self.stretch.clone()];
        match self.ball() {
            None if self.rules.is_some() => own.iter().map(|t| Some(t.place.normal)).collect(),
            // A wheel or a barrel leans by about a right angle from the normal.
            None => vec![None; own.len()],
            Some(_) => {
                own.iter().map(|t| around.surface.and_then(|s| s.contact(&t.place.point)).map(|c| c.normal)).collect()
            }
        }
    }

    /// The pose of a block of the run with an axis.
    pub(super) fn pose(&self, i: usize, axis: &Vector) -> ToolPose {
        let at = &self.touching[i];
        match self.ball() {
            Some(radius) => ToolPose { tip: at.place.point - axis * radius, axis: *axis },
            None => ToolPose { tip: self.cutter.touch(&at.place, axis, 0.0, None).pose.tip + at.off, axis: *axis },
        }
    }

    /// What the method of Dong et al. 2023 makes of a row with its rules.
    pub(super) fn by_strip_and_roughness(
        &self,
        method: &MultiScale,
        run: &CuttingRun,
        around: &Surroundings<'_>,
    ) -> Option<Vec<ToolPose>> {
        let rules = self.rules.as_ref()?;
        method.by_rules(run, around, &self.cutter, (rules, &self.touching)).ok().map(|(poses, _)| poses)
    }

    /// Programmed times of the blocks of the row after its first, s.
    ///
    /// # Errors
    /// `reschedule-path`: a block without a feed.
    pub(super) fn times(&self, run: &CuttingRun) -> Result<Vec<f64>, RescheduleError> {
        let own = run.blocks[self.stretch.clone()].iter().skip(1);
        own.map(|b| {
            b.time.filter(|t| t.is_finite() && *t > 0.0).ok_or_else(|| {
                let message = "the program gives this block no feed, so its time is not known";
                let help = "program a feed before it; without tool center point control one by inverse time (G93)";
                RescheduleError::new("reschedule-path", b.line, message, help)
            })
        })
        .collect()
    }
}

/// Whether a cutter narrows again above its widest place: a wheel, which cuts with its rim, where a mill goes
/// on.
fn narrows(cutter: &Profile) -> bool {
    let top = cutter.z_max() - BELOW_TOP * (cutter.z_max() - cutter.z_min());
    cutter.radius_at(top).is_some_and(|r| r < cutter.max_radius() * (1.0 - NARROWER))
}

/// The blocks along the surface: without those at both ends whose contact stays while the tool is lifted.
fn stretch(all: &[TouchOffset], run: &CuttingRun, around: &Surroundings<'_>, ball: Option<f64>) -> Range<usize> {
    let contact = |i: usize| match ball {
        Some(_) => around.surface.and_then(|s| s.nearest(&all[i].place.point)).map(|c| c.point),
        None => Some(all[i].place.point),
    };
    let is_lift = |i: usize| {
        let Some((a, b)) = contact(i).zip(contact(i + 1)) else { return false };
        let moved = match ball {
            Some(_) => (all[i + 1].place.point - all[i].place.point).norm(),
            None => (run.blocks[i + 1].pose.tip - run.blocks[i].pose.tip).norm(),
        };
        (b - a).norm() < LIFTED && moved > 10.0 * (b - a).norm()
    };
    let last = all.len().saturating_sub(1);
    let start = (0..last).find(|&i| !is_lift(i)).unwrap_or(0);
    let end = (start..last).rfind(|&i| !is_lift(i)).map_or(last, |i| i + 1);
    start..(end + 1).min(all.len())
}
