//! From kept motion to heights, parameters and doubts, place by place.

use std::collections::BTreeMap;

use proveout_surface::{
    texture::{ArealReport, Asked, HeightMap, Profile, ProfileReport, SettingClass, Unchecked},
    topography::{Cut, CutterPiece, Edge, Lattice, Settings, edges_of, heights_by_edges, heights_by_envelope},
};
use proveout_tool::Tool;

use super::{
    analytic::{self, Across},
    doubts::residual,
};
use crate::{
    cut::{
        engine::Facts,
        texture_motion::{Kept, PASSED_MM, Tracks},
    },
    observe::surface_texture::{Maker, SurfaceTexture, TextureMap, TextureProfile},
    prepare::{
        error::SimError,
        prepared::Prepared,
        texture_places::Place,
        texture_plan::{Entry, MOST_PIECES, Plan, Wanted, next_class},
    },
    scene::{ProfileDirectionFile, SurfaceFile, surface::SurfaceModelFile},
    units::UM_PER_MM,
    verdict::verdict_file::{BlockShare, PhaseSpread, ProfileUsed, TextureUsed},
};

/// Side and spacing of the map on which the lay round a single profile is found, mm.
const LAY_SIDE: f64 = 4.0;
const LAY_STEP: f64 = 0.04;
/// Most blocks that are reported for a place.
const TOLD_BLOCKS: usize = 3;

/// Receives each place when it is done.
pub(crate) type ShowTexture<'a> = dyn FnMut(&SurfaceTexture) -> Result<(), SimError> + 'a;

/// Evaluates all places of a scene, in their order.
pub(crate) fn evaluate(
    prepared: &Prepared,
    facts: &Facts,
    show: &mut ShowTexture<'_>,
) -> Result<Vec<TextureUsed>, SimError> {
    let (Some(plan), Some(tracks), Some(surface)) =
        (&prepared.texture, &facts.tracks, prepared.scene.file.surface.as_ref())
    else {
        return Ok(Vec::new());
    };
    let mut all = Vec::with_capacity(plan.entries.len());
    for (area, entry) in plan.entries.iter().enumerate() {
        let mut work = Work::new(prepared, facts, plan, tracks, surface, entry, area);
        let texture = work.run();
        all.push(work.used);
        show(&texture)?;
    }
    Ok(all)
}

/// Cuts of a lattice; motions are indices of kept pieces, edges those of the tool's.
type Cuts = Vec<Option<Cut>>;

/// One place under way.
pub(super) struct Work<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) facts: &'a Facts,
    plan: &'a Plan,
    tracks: &'a Tracks,
    pub(super) surface: &'a SurfaceFile,
    entry: &'a Entry,
    /// Tools that come near, with their kept pieces in order of time, and their edges.
    tools: Vec<(usize, Vec<u32>, Vec<Edge>)>,
    /// Pieces of tools with a stopped spindle.
    pub(super) standing: Vec<u32>,
    repeats: u32,
    pub(super) used: TextureUsed,
}

impl<'a> Work<'a> {
    fn new(
        prepared: &'a Prepared,
        facts: &'a Facts,
        plan: &'a Plan,
        tracks: &'a Tracks,
        surface: &'a SurfaceFile,
        entry: &'a Entry,
        area: usize,
    ) -> Self {
        let teeth = surface.model == SurfaceModelFile::Teeth;
        let mut by_tool: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        let mut standing = Vec::new();
        for &i in &tracks.of_area[area] {
            let kept = &tracks.pieces[i as usize];
            if teeth && kept.piece.azimuth_rate == 0.0 {
                standing.push(i);
            } else {
                by_tool.entry(kept.tool).or_default().push(i);
            }
        }
        let place = &entry.place;
        let mut used = TextureUsed {
            name: entry.name.clone(),
            at_mm: place.middle.coords.into(),
            normal: place.normal.into(),
            model: if teeth { "teeth" } else { "envelope" }.into(),
            design_error_um: UM_PER_MM * plan.chord_error,
            ..TextureUsed::default()
        };
        if tracks.lost {
            used.unchecked.push(format!("more than {} pieces of motion come near the patches", MOST_PIECES));
        }
        let mut tools = Vec::new();
        let mut unknown_phase = false;
        for (tool, pieces) in by_tool {
            let Some(described) = prepared.tools.tools.get(tool) else { continue };
            used.tools.push(described.name.clone());
            let mut edges = Vec::new();
            if teeth {
                match edges_of(described) {
                    Ok(found) => edges = found,
                    Err(e) => used.unchecked.push(e.to_string()),
                }
                let passages = || tracks.passages.iter().flatten().filter(|p| p.tool == tool);
                unknown_phase |= passages().next().is_none();
                for p in passages().filter(|p| p.distance > PASSED_MM) {
                    let message = format!(
                        "in feed, {} comes no closer than {:.4} mm to the place of its spindle phase",
                        described.name, p.distance
                    );
                    used.unchecked.push(message);
                }
            }
            tools.push((tool, pieces, edges));
        }
        used.residual = residual(tools.iter().filter_map(|t| prepared.tools.tools.get(t.0)));
        used.nodes_in_table = surface.save_nodes && matches!(entry.wanted, Wanted::Map { .. });
        let repeats = if teeth && unknown_phase { surface.random_phases } else { 1 };
        Self { prepared, facts, plan, tracks, surface, entry, tools, standing, repeats, used }
    }

    pub(super) fn tool(&self, kept: &Kept) -> Option<&'a Tool> {
        self.prepared.tools.tools.get(kept.tool)
    }

    pub(super) fn kept(&self, motion: u32) -> &'a Kept {
        &self.tracks.pieces[motion as usize]
    }

    /// The angle that is added to the azimuth of a kept piece: of its known phase, or a random one of this
    /// repetition.
    fn offset(&self, kept: &Kept, repeat: u32) -> f64 {
        let known = self.tracks.passages.iter().flatten().filter(|p| p.tool == kept.tool);
        let (mut held, mut first) = (None::<(u32, f64)>, None::<(u32, f64)>);
        for p in known {
            if p.block <= kept.block && held.is_none_or(|h| h.0 <= p.block) {
                held = Some((p.block, p.offset));
            }
            if first.is_none_or(|f| p.block < f.0) {
                first = Some((p.block, p.offset));
            }
        }
        held.or(first).map_or_else(|| random_angle(self.surface.seed, kept.tool as u64, repeat), |p| p.1)
    }

    /// The lowest cuts of all tools at the nodes of a lattice.
    fn cuts(&self, lattice: &Lattice, repeat: u32) -> Cuts {
        let settings = Settings { max_height: self.surface.max_height_mm };
        let mut lowest: Cuts = vec![None; lattice.points().len()];
        for (tool, pieces, edges) in &self.tools {
            let Some(described) = self.prepared.tools.tools.get(*tool) else { continue };
            let motion: Vec<CutterPiece> = pieces
                .iter()
                .map(|&i| {
                    let kept = self.kept(i);
                    let azimuth = kept.piece.azimuth + self.offset(kept, repeat);
                    CutterPiece { azimuth, motion: i, ..kept.piece }
                })
                .collect();
            if self.surface.model == SurfaceModelFile::Teeth {
                if !edges.is_empty() {
                    lower(&mut lowest, heights_by_edges(lattice, edges, &motion, &settings).cuts);
                }
                continue;
            }
            for body in described.cutting() {
                lower(&mut lowest, heights_by_envelope(lattice, &body.profile, &motion, &settings).cuts);
            }
        }
        lowest
    }

    fn run(&mut self) -> SurfaceTexture {
        let texture = SurfaceTexture { name: self.entry.name.clone(), map: None, profiles: Vec::new() };
        match self.entry.wanted {
            Wanted::Map { steps, step, profiles } => {
                self.used.size_mm = Some([steps[0] as f64 * step, steps[1] as f64 * step]);
                self.used.step_um = Some(UM_PER_MM * step);
                match self.entry.place.lattice(&self.plan.ground, steps, [step, step]) {
                    Ok(lattice) => self.map(texture, &lattice, step, profiles),
                    Err((message, _)) => {
                        self.used.unchecked.push(message);
                        texture
                    }
                }
            }
            Wanted::Profile(direction) => self.lone_profile(texture, direction),
        }
    }

    /// A map with its parameters, and the profiles through its middle.
    fn map(&mut self, mut texture: SurfaceTexture, lattice: &Lattice, step: f64, profiles: bool) -> SurfaceTexture {
        let cuts = self.cuts(lattice, 0);
        let heights: Vec<f64> = cuts.iter().map(|c| c.map_or(f64::NAN, |c| c.height)).collect();
        let makers: Vec<Option<Maker>> = cuts.iter().map(|c| c.as_ref().map(|c| self.maker(c))).collect();
        self.used.nodes = heights.len() as u64;
        self.used.uncut = heights.iter().filter(|z| z.is_nan()).count() as u64;
        self.used.blocks = self.blocks(&makers);
        self.doubts(lattice, &cuts);
        self.toothless(&cuts);
        let area = HeightMap::new(lattice.columns(), lattice.rows(), step, step, heights.clone()).ok();
        let asked = self.asked(None);
        let report = area.as_ref().map(|map| ArealReport::of(map, &asked));
        let mut lay_deg = None;
        if let (Some(report), Some(map)) = (&report, &area) {
            lay_deg = report.lay_deg;
            let mut of_phases = vec![[report.unfiltered.sa_um, report.unfiltered.sz_um]];
            for repeat in 1..self.repeats {
                let again = self.cuts(lattice, repeat).iter().map(|c| c.map_or(f64::NAN, |c| c.height)).collect();
                let again = HeightMap::new(map.columns(), map.rows(), step, step, again);
                of_phases.extend(again.map(|m| m.parameters()).map(|p| [UM_PER_MM * p.sa, UM_PER_MM * p.sz]));
            }
            self.used.sa_um = Some(report.unfiltered.sa_um);
            self.used.sq_um = Some(report.unfiltered.sq_um);
            self.used.sz_um = Some(report.unfiltered.sz_um);
            if self.repeats > 1 {
                let spread = self.used.phases.get_or_insert_with(PhaseSpread::default);
                spread.repeats = of_phases.len() as u32;
                spread.sa_um = range(of_phases.iter().map(|p| p[0]));
                spread.sz_um = range(of_phases.iter().map(|p| p[1]));
            }
            self.used.area = serde_json::to_value(report).ok();
        }
        if self.used.uncut > 0 {
            self.used.unchecked.push(format!(
                "{} of {} nodes are not cut to within {} mm above the design",
                self.used.uncut, self.used.nodes, self.surface.max_height_mm
            ));
        }
        if profiles && area.is_some() {
            for direction in [ProfileDirectionFile::Across, ProfileDirectionFile::Along] {
                let turned = self.to_lay(&self.entry.place, lay_deg, direction);
                texture.profiles.extend(self.profile(&turned, Some(direction), None));
            }
        }
        texture.map = Some(TextureMap {
            columns: lattice.columns(),
            rows: lattice.rows(),
            step_mm: [step, step],
            points: lattice.points().to_vec(),
            normals: lattice.normals().to_vec(),
            heights,
            makers,
            lay_deg,
        });
        texture
    }

    /// A profile whose lay is found on a small map round it.
    fn lone_profile(&mut self, mut texture: SurfaceTexture, direction: Option<ProfileDirectionFile>) -> SurfaceTexture {
        let steps = (LAY_SIDE / LAY_STEP).round() as usize;
        let around = self.entry.place.lattice(&self.plan.ground, [steps, steps], [LAY_STEP, LAY_STEP]);
        let lay_deg = around.ok().and_then(|lattice| {
            let heights = self.cuts(&lattice, 0).iter().map(|c| c.map_or(f64::NAN, |c| c.height)).collect();
            let map = HeightMap::new(steps + 1, steps + 1, LAY_STEP, LAY_STEP, heights).ok()?;
            proveout_surface::texture::lay(&map).map(f64::to_degrees)
        });
        let place = match direction {
            Some(direction) => {
                if lay_deg.is_none() {
                    self.used.remarks.push(
                        "no marks are found around it: the profile runs along X projected onto the surface".into(),
                    );
                }
                self.to_lay(&self.entry.place, lay_deg, direction)
            }
            None => self.entry.place.clone(),
        };
        texture.profiles.extend(self.profile(&place, direction, lay_deg));
        texture
    }

    /// A place with its columns turned along the profile.
    fn to_lay(&self, place: &Place, lay_deg: Option<f64>, direction: ProfileDirectionFile) -> Place {
        let lay = lay_deg.unwrap_or(0.0);
        place.turned(match direction {
            ProfileDirectionFile::Along => lay.to_radians(),
            ProfileDirectionFile::Across => (lay + 90.0).to_radians(),
        })
    }

    fn asked(&self, to_lay: Option<f64>) -> Asked {
        Asked { standard: self.surface.standard, class: self.plan.class, to_lay, ..Asked::default() }
    }

    /// A profile along the columns of a place; with the next class, and its length, where the marks ask for
    /// it.
    fn profile(
        &mut self,
        place: &Place,
        direction: Option<ProfileDirectionFile>,
        lay_deg: Option<f64>,
    ) -> Option<TextureProfile> {
        let (word, to_lay) = match direction {
            Some(ProfileDirectionFile::Across) => ("across the lay", Some(90.0)),
            Some(ProfileDirectionFile::Along) => ("along the lay", Some(0.0)),
            None => ("along its own direction", lay_deg),
        };
        let mut asked = self.asked(to_lay);
        let mut remark = None;
        let (lattice, step, cuts, report) = loop {
            let step = asked.class.max_spacing();
            let taken = self.line(place, asked.class, step).and_then(|(lattice, cuts)| {
                let report = self.report(&cuts, step, &asked)?;
                Ok((lattice, cuts, report))
            });
            let (lattice, cuts, report) = match taken {
                Ok(taken) => taken,
                Err(why) => {
                    let class = asked.class.name();
                    let also = remark.map_or_else(String::new, |r| format!("; {r}"));
                    self.open(direction, format!("profile {word}, class {class}: {why}{also}"));
                    return None;
                }
            };
            let next = report.unchecked.iter().find_map(|u| match u {
                Unchecked::PitchBeyondCutoff { next: Some(next), .. } => {
                    SettingClass::ALL.into_iter().find(|c| c.name() == *next && *c > asked.class)
                }
                _ => None,
            });
            match next.filter(|_| report.filtered.is_none()) {
                Some(next) if Some(next) == next_class(self.plan.class) => {
                    remark = report.unchecked.first().map(ToString::to_string);
                    asked.class = next;
                }
                _ => break (lattice, step, cuts, report),
            }
        };
        let values = |r: &ProfileReport| r.filtered.as_ref().map(|v| [v.ra_um, v.rz_um]);
        let mut of_phases: Vec<[f64; 2]> = values(&report).into_iter().collect();
        for repeat in 1..self.repeats {
            let again = self.cuts(&lattice, repeat);
            of_phases.extend(self.report(&again, step, &asked).ok().as_ref().and_then(values));
        }
        if of_phases.len() < self.repeats as usize {
            let why: Vec<String> = report.unchecked.iter().map(ToString::to_string).collect();
            let why = if why.is_empty() { "not at every spindle phase".to_owned() } else { why.join("; ") };
            self.open(direction, format!("profile {word}: {why}"));
        }
        self.used.remarks.extend(remark.map(|r| format!("profile {word}: {r}; it was used")));
        if self.used.blocks.is_empty() {
            let makers: Vec<Option<Maker>> = cuts.iter().map(|c| c.as_ref().map(|c| self.maker(c))).collect();
            self.used.blocks = self.blocks(&makers);
            self.doubts(&lattice, &cuts);
            self.toothless(&cuts);
        }
        let mut analytic = None;
        if direction == Some(ProfileDirectionFile::Across) {
            let teeth = self.surface.model == SurfaceModelFile::Teeth;
            let across = Across { lattice: &lattice, step, cuts: &cuts, teeth };
            match analytic::beside(&across, &self.prepared.tools.tools, |cut| self.kept(cut.motion)) {
                Ok(found) => analytic = Some(found),
                Err(why) => self.used.remarks.push(format!("profile {word}: no analytic value to compare with: {why}")),
            }
        }
        let ranges = (!of_phases.is_empty()).then(|| [0, 1].map(|k| range(of_phases.iter().map(|p| p[k]))));
        let along = place.along;
        self.used.profiles.push(ProfileUsed {
            direction: word.into(),
            along: along.into(),
            ra_um: ranges.map(|r| r[0]),
            rz_um: ranges.map(|r| r[1]),
            analytic,
            report: serde_json::to_value(&report).unwrap_or_default(),
        });
        Some(TextureProfile {
            direction: word,
            step_mm: step,
            heights: cuts.iter().map(|c| c.map_or(f64::NAN, |c| c.height)).collect(),
            ra_rz_um: values(&report),
            class: report.class.to_owned(),
            roughness: report.roughness,
        })
    }

    /// What a profile leaves open. Drawings ask for the direction across the lay, where the values
    /// are largest (ISO 21920-1). In addition to it a profile along the lay is for information.
    fn open(&mut self, direction: Option<ProfileDirectionFile>, what: String) {
        let beside = matches!(self.entry.wanted, Wanted::Map { .. }) && direction == Some(ProfileDirectionFile::Along);
        if beside { self.used.remarks.push(what) } else { self.used.unchecked.push(what) }
    }

    /// Points of a profile of a class, and what cuts them.
    fn line(&self, place: &Place, class: SettingClass, step: f64) -> Result<(Lattice, Cuts), String> {
        // One step more on either side, so that rounding takes nothing off the length.
        let steps = (Profile::length_for(class) / step).round() as usize + 2;
        let lattice = place.lattice(&self.plan.ground, [steps, 0], [step, step]).map_err(|(message, _)| message)?;
        let cuts = self.cuts(&lattice, 0);
        Ok((lattice, cuts))
    }

    fn report(&self, cuts: &[Option<Cut>], step: f64, asked: &Asked) -> Result<ProfileReport, String> {
        let uncut = cuts.iter().filter(|c| c.is_none()).count();
        if uncut > 0 {
            let (all, height) = (cuts.len(), self.surface.max_height_mm);
            return Err(format!("{uncut} of {all} points are not cut to within {height} mm above the design"));
        }
        let heights = cuts.iter().flatten().map(|c| c.height).collect();
        let profile = Profile::new(step, heights).map_err(|e| e.to_string())?;
        Ok(ProfileReport::of(&profile, asked))
    }

    fn maker(&self, cut: &Cut) -> Maker {
        let kept = self.kept(cut.motion);
        let edges = self.tools.iter().find(|t| t.0 == kept.tool).map_or(0, |t| t.2.len());
        let teeth = self.tool(kept).and_then(|t| t.flutes).unwrap_or(1).max(1) as usize;
        // Each tooth has as many arcs.
        let arcs = (edges / teeth).max(1);
        Maker { block: kept.block, tool: kept.tool as u32, tooth: cut.edge.map(|e| (e / arcs) as u32) }
    }

    /// The blocks that made most of it.
    fn blocks(&self, makers: &[Option<Maker>]) -> Vec<BlockShare> {
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        for maker in makers.iter().flatten() {
            *counts.entry(maker.block).or_default() += 1;
        }
        let mut counts: Vec<(u32, usize)> = counts.into_iter().collect();
        counts.sort_by_key(|(block, count)| (std::cmp::Reverse(*count), *block));
        let share = |(block, count): (u32, usize)| {
            let place = self.facts.places.get(block as usize).and_then(Option::as_ref);
            BlockShare {
                block,
                file: place.map(|p| p.0.to_string()),
                line: place.map(|p| p.1),
                percent: 100.0 * count as f64 / makers.len() as f64,
            }
        };
        counts.into_iter().take(TOLD_BLOCKS).map(share).collect()
    }
}

/// Keeps the lower of two cuts at each node.
fn lower(lowest: &mut [Option<Cut>], cuts: Cuts) {
    for (low, new) in lowest.iter_mut().zip(cuts) {
        if new.is_some_and(|n| low.is_none_or(|l| n.height < l.height)) {
            *low = new;
        }
    }
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// An angle from 0 to a whole turn, the same for the same seed, tool and repetition (`SplitMix64`: Steele,
/// Lea, Flood 2014).
fn random_angle(seed: u32, tool: u64, repeat: u32) -> f64 {
    let mut z = (u64::from(seed) << 32 ^ u64::from(repeat) << 8 ^ tool).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1_u64 << 53) as f64 * std::f64::consts::TAU
}
