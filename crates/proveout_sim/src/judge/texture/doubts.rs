//! Where the teeth of a run differ from their description, and what is not described.

use std::collections::{BTreeMap, BTreeSet};

use proveout_controller::MoveKind;
use proveout_surface::topography::{
    Cut, CutterPiece, Lattice, Settings, check_chip, check_motion, heights_by_envelope,
};
use proveout_tool::Tool;

use super::evaluate::Work;
use crate::{scene::surface::SurfaceModelFile, verdict::verdict_file::ResidualUsed};

/// Nanoseconds of a second.
const NS_PER_S: f64 = 1e9;
/// The swept surface has to be lower than the cut by more, mm: rounding of an envelope.
const DEEPER_MM: f64 = 1e-6;

impl Work<'_> {
    /// Where teeth differ from their description: a stopped spindle, run-out above the chip,
    /// numbers that are none.
    pub(super) fn doubts(&mut self, lattice: &Lattice, cuts: &[Option<Cut>]) {
        if self.surface.model != SurfaceModelFile::Teeth {
            return;
        }
        let mut found = BTreeSet::new();
        let motions: BTreeSet<u32> = cuts.iter().flatten().map(|c| c.motion).collect();
        let pieces: Vec<CutterPiece> = motions.iter().map(|m| self.kept(*m).piece).collect();
        found.extend(check_motion(&pieces).err().map(|e| e.to_string()));
        let mut chips: BTreeMap<usize, (u64, f64)> = BTreeMap::new();
        for kept in motions.iter().map(|m| self.kept(*m)).filter(|k| k.kind == MoveKind::Feed) {
            let piece = &kept.piece;
            let Some(teeth) = self.tool(kept).and_then(|t| t.flutes) else { continue };
            let span = piece.time[1] - piece.time[0];
            let speed = (piece.tip[1] - piece.tip[0]).norm() / span;
            let chip = speed * std::f64::consts::TAU / (piece.azimuth_rate.abs() * f64::from(teeth));
            // By time: short pieces at ramps are few.
            let sum = chips.entry(kept.tool).or_insert((0, 0.0));
            if chip.is_finite() && span * NS_PER_S > sum.0 as f64 {
                *sum = ((span * NS_PER_S) as u64, chip);
            }
        }
        for (tool, (_, chip)) in chips {
            let described = self.prepared.tools.tools.get(tool);
            found.extend(described.and_then(|t| check_chip(t, chip).err()).map(|e| e.to_string()));
        }
        found.extend(self.standing_cut(lattice, cuts));
        self.used.unchecked.extend(found);
    }

    /// Whether a tool with a stopped spindle goes through the surface.
    fn standing_cut(&self, lattice: &Lattice, cuts: &[Option<Cut>]) -> Option<String> {
        let mut by_tool: BTreeMap<usize, Vec<CutterPiece>> = BTreeMap::new();
        for &i in &self.standing {
            let kept = self.kept(i);
            by_tool.entry(kept.tool).or_default().push(CutterPiece { motion: i, ..kept.piece });
        }
        let settings = Settings { max_height: self.surface.max_height_mm };
        for (tool, pieces) in by_tool {
            let described = self.prepared.tools.tools.get(tool)?;
            for body in described.cutting() {
                let swept = heights_by_envelope(lattice, &body.profile, &pieces, &settings).cuts;
                let deeper = |(s, c): (&Option<Cut>, &Option<Cut>)| {
                    let (s, limit) = (s.as_ref()?, c.as_ref().map_or(f64::INFINITY, |c| c.height));
                    (s.height < limit - DEEPER_MM).then_some(s.motion)
                };
                if let Some(motion) = swept.iter().zip(cuts).find_map(deeper) {
                    let block = self.kept(motion).block as usize;
                    let at = self.facts.places.get(block).and_then(Option::as_ref);
                    let at = at.map_or_else(String::new, |(file, line)| format!(" ({file}:{line})"));
                    let name = &described.name;
                    return Some(format!(
                        "teeth of {name} without spindle speed: it passes through the surface with the spindle stopped{at}"
                    ));
                }
            }
        }
        None
    }
}

/// What the tools state: from the least of one to the most of one; a tool that states nothing adds nothing,
/// and is named.
pub(super) fn residual<'t>(tools: impl Iterator<Item = &'t Tool>) -> ResidualUsed {
    let mut all: Option<ResidualUsed> = None;
    for tool in tools {
        let own = match &tool.residual {
            Some(r) => ResidualUsed {
                ra_um: r.ra_um,
                rz_um: r.rz_um,
                source: format!("{}: {}", tool.name, r.source),
                missing: Vec::new(),
            },
            None => ResidualUsed {
                source: format!("{} states none: unknown, not zero", tool.name),
                missing: vec![tool.name.clone()],
                ..ResidualUsed::default()
            },
        };
        all = Some(match all {
            None => own,
            Some(before) => {
                let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
                ResidualUsed {
                    ra_um: join(before.ra_um, own.ra_um),
                    rz_um: join(before.rz_um, own.rz_um),
                    source: format!("{}; {}", before.source, own.source),
                    missing: [before.missing, own.missing].concat(),
                }
            }
        });
    }
    all.unwrap_or_else(|| ResidualUsed { source: "no tool comes near".into(), ..ResidualUsed::default() })
}
