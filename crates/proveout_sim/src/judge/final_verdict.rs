//! From the cut part and the facts of the loop to the verdict.

use proveout_collision::{BEARING_ROLES, Unchecked};
use std::collections::BTreeMap;

use proveout_controller::Summary;
use proveout_machine::{Attachment, Machine};
use proveout_stock::{Patch, TriDexel};

use crate::{
    cut::{engine::Facts, kept_motion::Swept},
    evidence::inputs::MeshRole,
    judge::{
        gouge_findings::{films_in_words, judge_areas, tell_films, tell_threads, threads_in_words},
        probe_inspection, scallop, scallop_limits,
        surface_gate::{self, Judgement},
        surface_survey::{self, Measured, Surveyed},
        text_not_run, texture, unstated,
    },
    observe::{
        surface_map::{PointBand, SurfaceShape},
        surface_texture::SurfaceTexture,
    },
    prepare::{error::SimError, prepared::Prepared},
    units::N_M_PER_N_MM,
    verdict::{
        finding::{self, Finding, Severity},
        gate::{Gate, PerGate},
        gates::{self, Coverage},
        log::FindingLog,
        partial_run::{self, Partial},
        verdict_file::{
            Axis, AxisUnit, Deviation, GateVerdict, Inspected, MachineUsed, PatchUsed, Path, Removal, SCHEMA_VERSION,
            Surface, Time, Verdict,
        },
    },
};

/// How what no ray goes through was decided.
const BETWEEN: &str = "edges and pins between the rays by the shape of the raw stock and the cuts themselves";

/// What is shown to the observers on the way.
pub(crate) enum Shown<'a> {
    Points(&'a PointBand<'a>),
    Texture(&'a SurfaceTexture),
}

/// Measures the part and judges the run; the points of its surface are shown on the way.
pub(crate) fn judge(
    prepared: &Prepared,
    (stock, patches): (&TriDexel, &[Patch]),
    facts: &Facts,
    summary: &Summary,
    partial: Option<Partial>,
    show: &mut dyn FnMut(Shown<'_>) -> Result<(), SimError>,
) -> Result<(Verdict, Surveyed), SimError> {
    let mut log = facts.log.clone();
    let finished = partial.as_ref().is_none_or(|p| p.stopped.is_none());
    let textured = partial.is_none();
    text_not_run::judge(prepared, &mut log);
    let kept = facts.motion.as_ref().and_then(|m| m.pieces());
    let swept = kept.map(|pieces| Swept::new(pieces, &prepared.tools));
    let scallop = textured.then(|| scallop::measure(prepared, facts, swept.as_ref(), stock, patches)).flatten();
    let heights = scallop.as_ref().and_then(|s| s.as_ref().ok()).and_then(scallop::Measured::map);
    let points = &mut |band: &PointBand<'_>| show(Shown::Points(band));
    let mut surveyed = surface_survey::survey(
        prepared,
        stock,
        patches,
        surface_survey::Known {
            swept: swept.as_ref(),
            ridges: heights.as_ref(),
            strokes: &facts.strokes,
            fallen: facts.fallen > 0.0,
            finished,
        },
        points,
    )?;
    let measured = surveyed.measured.take();
    if let Some(m) = &measured {
        judge_areas(prepared, facts, m, finished, &mut log);
        tell_threads(prepared, facts, m, &mut log);
        if finished {
            tell_films(facts, m, &mut log);
        }
    }
    let features = if finished { &prepared.scene.file.inspect[..] } else { &[] };
    let inspection = probe_inspection::inspect(features, stock, patches);
    for finding in probe_inspection::judge(&inspection) {
        log.push(finding);
    }
    let textures = if textured {
        texture::evaluate(prepared, facts, &mut |texture| show(Shown::Texture(texture)))?
    } else {
        Vec::new()
    };
    let mut surface = Surface { textures, ..Surface::default() };
    let of_surface: Vec<Judgement> = [scallop_limits::judge(prepared, facts, scallop.as_ref(), &mut surface, &mut log)]
        .into_iter()
        .flatten()
        .collect();
    let of_texture = if textured { texture::judge(prepared, &mut surface, &mut log) } else { Vec::new() };
    let of_surface = [of_surface, of_texture].concat();
    let known = Known {
        measured: measured.as_ref(),
        inspection: &inspection,
        of_surface: &of_surface,
        surface: &surface,
        log: &log,
    };
    let gates = judge_gates(prepared, facts, summary, &known, partial.as_ref());
    let verdict = Verdict {
        schema_version: SCHEMA_VERSION,
        scene: prepared.scene.file.name.clone(),
        program: prepared.program_name.clone(),
        machine: MachineUsed {
            name: prepared.machine.name.clone(),
            digest: prepared.digests.get("machine").cloned().unwrap_or_default(),
        },
        digests: prepared.digests.clone(),
        set: prepared.set.clone(),
        verdict: gates::overall(gates.iter().map(|g| g.state)),
        gates,
        partial,
        findings: log
            .all()
            .iter()
            .cloned()
            .map(|f| Finding { file: f.file.map(|n| prepared.shown_as(&n)), ..f })
            .collect(),
        time: Time {
            total_s: summary.total_s,
            cutting_s: summary.cutting_s,
            rapid_s: summary.rapid_s,
            dwell_s: summary.dwell_s,
            tool_change_s: summary.tool_change_s,
            lower_bound_s: summary.lower_bound_s,
            path_bound_s: summary.path_bound_s,
        },
        axes: axes(prepared, summary),
        path: Path {
            blocks: summary.blocks,
            length_mm: summary.length_mm,
            max_chord_error_mm: Some(summary.max_chord_error_mm),
            max_contour_error_mm: Some(summary.max_contour_error_mm),
            max_axis_error_deg: Some(summary.max_axis_error.to_degrees()),
            min_feed_ratio: summary.min_feed_ratio,
        },
        removal: Removal {
            moves: facts.pieces,
            volume_mm3: facts.removed,
            stock_left_mm3: facts.left,
            fallen_mm3: facts.fallen,
            sweep_bound_mm: stock.sweep_bound_mm(),
            cell_mm: stock.cell_mm(),
            cells_mm: stock.cells_mm(),
            regrid_bound_mm: stock.regrid_bound().map(|r| r.surface_mm),
            regrid_edge_bound_mm: stock.regrid_bound().map(|r| r.edge_mm),
            patches: patches_used(prepared, patches, &surveyed.shape),
        },
        deviation: measured.map_or_else(Deviation::default, |m| m.deviation),
        surface,
        clearance: facts.clearance.clone(),
        tools: facts.tools.clone(),
        inspection,
        probing: prepared.probed.clone(),
    };
    Ok((verdict, surveyed))
}

fn patches_used(prepared: &Prepared, patches: &[Patch], shape: &SurfaceShape) -> Vec<PatchUsed> {
    let asked = prepared.scene.file.stock.get_ref().patch.iter().map(|p| p.get_ref());
    asked
        .zip(patches)
        .zip(&shape.patches)
        .map(|((asked, patch), shown)| PatchUsed {
            name: asked.name.clone(),
            min_mm: asked.min_mm,
            max_mm: asked.max_mm,
            cells_mm: patch.stock().cells_mm(),
            sweep_bound_mm: patch.stock().sweep_bound_mm(),
            regrid_bound_mm: patch.stock().regrid_bound().map(|r| r.surface_mm),
            regrid_edge_bound_mm: patch.stock().regrid_bound().map(|r| r.edge_mm),
            points: shown.points,
        })
        .collect()
}

fn axes(prepared: &Prepared, summary: &Summary) -> BTreeMap<String, Axis> {
    let joints = prepared.machine.joints.iter().zip(&summary.joints);
    joints
        .map(|(joint, s)| {
            let rotary = joint.is_rotary();
            let scale = |v: f64| v * joint.kind.unit_factor();
            let axis = Axis {
                unit: if rotary { AxisUnit::Deg } else { AxisUnit::Mm },
                min: joint.kind.in_unit(s.min),
                max: joint.kind.in_unit(s.max),
                max_velocity: scale(s.max_velocity),
                max_acceleration: scale(s.max_acceleration),
                max_jerk: scale(s.max_jerk),
                velocity_utilisation: s.velocity_utilisation,
                acceleration_utilisation: s.acceleration_utilisation,
                jerk_utilisation: s.jerk_utilisation,
                reversals: s.reversals.into(),
                max_following_error: s.drive.map(|d| scale(d.max_following_error)),
                max_drive_force: s.drive.map(|d| d.max_force * if rotary { N_M_PER_N_MM } else { 1.0 }),
                drive_force_unit: s.drive.map(|_| if rotary { "Nm" } else { "N" }.into()),
                drive_utilisation: s.drive.and_then(|d| d.force_utilisation),
                max_drive_power_w: s.drive.map(|d| d.max_power),
                drive_energy_j: s.drive.map(|d| d.energy),
            };
            (joint.name.clone(), axis)
        })
        .collect()
}

/// Parts of the machine that its file does not describe, so that nothing could be checked against
/// them.
fn missing_bodies(machine: &Machine, checked_pairs: usize) -> Vec<String> {
    if machine.bodies.is_empty() {
        return vec!["the machine: its file has no bodies (`[[body]]`)".to_owned()];
    }
    let ends = [("table", &machine.work_chain), ("spindle", &machine.tool_chain)].map(|(name, chain)| {
        let end = chain.last().map_or(Attachment::Base, |j| Attachment::Joint(*j));
        let on = chain.last().map_or("base", |j| machine.joints[*j].name.as_str());
        let missing = machine.bodies.iter().all(|b| b.attached_to != end);
        missing.then(|| format!("the {name}: no body of the machine file moves with it (`attached_to = \"{on}\"`)"))
    });
    let mut missing: Vec<String> = ends.into_iter().flatten().collect();
    if checked_pairs == 0 && missing.is_empty() {
        missing.push(
            "collisions between bodies: no two bodies of the machine file move relative to each other".to_owned(),
        );
    }
    missing
}

/// What is said of the bodies that nothing sweeps through the stock.
fn against_stock(facts: &Facts, near_mm: f64) -> String {
    let near = &facts.stock_near;
    let mut text = String::new();
    if near.clear > 0 {
        let keep = if near.clear == 1 { "1 body keeps".to_owned() } else { format!("{} bodies keep", near.clear) };
        text += &format!(
            "; {keep} {near_mm} mm from the in-process stock throughout, with {:.3} mm around its rays counted as material",
            near.unseen_mm
        );
    }
    if near.followed > near.clear {
        let (n, come) = match near.followed - near.clear {
            1 => (1, "body comes"),
            n => (n, "bodies come"),
        };
        text += &format!("; {n} {come} nearer to it");
    }
    if !near.flush.is_empty() {
        let lie = if near.flush.len() == 1 { "lies" } else { "lie" };
        text += &format!(
            "; {} {lie} flush with the table face: there the lowest {:.3} mm of the stock are ignored, except near \
             anything that rises above the face",
            near.flush.join(", "),
            near.layer_mm
        );
    }
    if !near.fixed.is_empty() {
        text += &format!("; bodies that do not move relative to the stock may touch it: {}", near.fixed.join(", "));
    }
    text
}

/// The limit that was used, and what it is made of.
fn limit_in_words(word: &str, tolerance: f64, used: f64) -> String {
    if used <= tolerance {
        return format!("{word} limit {tolerance} mm");
    }
    let more = used - tolerance;
    format!("{word} limit {used:.4} mm: {tolerance} mm allowed plus {more:.4} mm resolution of design and cells")
}

/// A design that is known less well than the tolerance asks.
fn too_coarse(prepared: &Prepared, word: &str, tolerance: f64, deviation: &Deviation) -> Option<String> {
    let error = deviation.design_error_mm.filter(|e| *e > tolerance)?;
    if prepared.step_files.iter().any(|s| s.role == MeshRole::Part) {
        return Some(format!(
            "the mesh of the STEP file is accurate to {error:.5} mm as measured, and the tolerance of {word} is {tolerance} mm: ask for a finer one with `chord_um`"
        ));
    }
    Some(format!(
        "the design mesh is accurate to {error} mm (`chord_error_mm`), and the tolerance of {word} is {tolerance} mm: state the true largest distance of the mesh from the drawing, or export a finer mesh"
    ))
}

/// What no judgement of the surface has seen.
fn surface_coverage(prepared: &Prepared) -> Coverage {
    Coverage { checked: None, left_out: unstated::ideal(prepared).into_iter().collect() }
}

/// What was measured on the part, and everything that was found.
struct Known<'a> {
    measured: Option<&'a Measured>,
    inspection: &'a [Inspected],
    of_surface: &'a [Judgement],
    surface: &'a Surface,
    log: &'a FindingLog,
}

/// Pairs that are not checked for a reason, in words.
fn of_neighbors(facts: &Facts, why: Unchecked) -> String {
    let pairs = facts.clearance.unchecked.iter().filter(|u| u.cause == Some(why));
    pairs.map(|u| u.bodies.join(" against ")).collect::<Vec<_>>().join(", ")
}

fn judge_gates(
    prepared: &Prepared,
    facts: &Facts,
    summary: &Summary,
    known: &Known<'_>,
    partial: Option<&Partial>,
) -> Vec<GateVerdict> {
    let Known { measured, inspection, of_surface, surface, log } = *known;
    let tolerances = &prepared.scene.file.tolerances;
    let limits = {
        let left_out = summary.unlimited_joints.iter().map(|j| {
            let missing = [(j.velocity, "velocity"), (j.acceleration, "acceleration"), (j.jerk, "jerk")];
            let missing: Vec<&str> = missing.iter().filter(|(m, _)| *m).map(|(_, n)| *n).collect();
            format!("{} has no limit of {}", j.joint, missing.join(", "))
        });
        let no_travel = prepared.machine.joints.iter().filter(|j| j.travel.is_none() && !j.endless);
        let no_travel = no_travel.map(|j| format!("{} has no travel", j.name));
        let mut checked = "travel, velocity, acceleration and jerk of every joint; spindle speed".to_owned();
        let mut left_out: Vec<String> =
            left_out.chain(no_travel).chain(log.left_out(Gate::Limits).iter().cloned()).collect();
        if !prepared.machine.platforms.is_empty() {
            checked += "; length, velocity, acceleration and jerk of every leg, at the control samples";
        }
        if let Some(loads) = &summary.loads {
            checked += "; force of every drive, without workpiece, fixtures, tool and cutting";
            if !loads.estimated.is_empty() {
                checked += &format!(", with the mass distributed over the shape of {}", loads.estimated.join(", "));
            }
            let unlimited = loads.no_force_limit.iter().map(|j| format!("the drive of {j} has no force limit"));
            left_out.extend(unlimited);
            let unknown = loads.unknown.iter();
            left_out.extend(unknown.map(|(j, why)| format!("weight and coupling on the drive of {j}: {why}")));
        } else {
            checked += "; drives are not simulated: their force is not checked";
        }
        Coverage { checked: Some(checked), left_out }
    };
    let probes: usize =
        log.all().iter().filter(|f| f.code == finding::PROBED.code).map(|f| 1 + f.repeats as usize).sum();
    let process = Coverage {
        checked: Some(format!(
            "rapid in material, spindle, plunging of tools that are not center-cutting, {}and rubbing of neck and shank, on every \
             piece of motion; {BETWEEN}",
            if facts.strokes.is_empty() { "" } else { "pitch of taps, " }
        )),
        left_out: {
            let motions = if probes == 1 { "motion" } else { "motions" };
            let probes = (probes > 0).then(|| format!("{probes} probing {motions}: the probe result is not known"));
            let unknown = probes.into_iter().chain(log.left_out(Gate::Process).iter().cloned());
            unknown.chain(unstated::ideal(prepared)).collect()
        },
    };
    let holders = facts.tools_without_holder.iter().map(|name| format!("{name} has no holder in the library"));
    let mut collision = Coverage {
        checked: Some(format!(
            "holder against the in-process stock, on rays every {} mm; {BETWEEN}; {} pairs of bodies over {} pieces of motion",
            prepared.stock.cell_mm(),
            facts.checked_pairs,
            facts.clearance.checks
        )),
        left_out: holders.chain(log.left_out(Gate::Collision).iter().cloned()).collect(),
    };
    if !facts.excluded_bodies.is_empty() {
        let names = facts.excluded_bodies.join(", ");
        collision.left_out.push(format!("bodies that the machine file excludes: {names}"));
    }
    if !facts.across_platforms.is_empty() {
        let pairs = facts.across_platforms.join(", ");
        collision.left_out.push(format!("bodies on both sides of a tilting platform: {pairs}"));
    }
    let swallowed = of_neighbors(facts, Unchecked::Neighbors);
    if !swallowed.is_empty() {
        collision.left_out.push(format!(
            "neighbors in full contact at rest, without a bearing role in the machine file ({}): {swallowed}",
            BEARING_ROLES.join(", ")
        ));
    }
    collision.left_out.extend(facts.told.left_out.clone());
    collision.left_out.extend(facts.loose.clone());
    let near_mm = tolerances.near_miss_mm;
    collision.left_out.extend(facts.stock_near.behind_table.iter().map(|(name, depth)| {
        format!(
            "{name} against the table: it reaches {depth:.3} mm below the table face of the machine file (`table.point_mm`, `table.normal`), into the table unless that has a recess there"
        )
    }));
    if let Some(checked) = &mut collision.checked {
        checked.push_str(&against_stock(facts, near_mm));
        checked.push_str(facts.loose_known.as_deref().unwrap_or_default());
        let errors = prepared.machine.has_errors();
        checked.push_str(if errors { "; with room for the geometric errors of the machine" } else { "" });
        let bear = of_neighbors(facts, Unchecked::Guide);
        if !bear.is_empty() {
            *checked += &format!("; not checked, wholly inside their bearing: {bear}");
        }
        for remark in &facts.told.remarks {
            *checked += &format!("; {remark}");
        }
    }
    let mut kept = format!("bodies keep {near_mm} mm apart, and the holder from the in-process stock");
    if !facts.told.own_near_miss.is_empty() {
        kept += &format!("; as the machine file requires, {}", facts.told.own_near_miss.join(", "));
    }
    let mut near = Coverage { checked: Some(kept), left_out: collision.left_out.clone() };
    near.left_out.extend_from_slice(log.left_out(Gate::NearMiss));
    let missing = missing_bodies(&prepared.machine, facts.checked_pairs);
    for coverage in [&mut collision, &mut near] {
        coverage.left_out.extend(missing.clone());
        coverage.left_out.extend(unstated::ideal(prepared));
        unstated::leave_out(prepared, facts, coverage);
    }
    let shape = |gate: Gate, limit: f64| {
        let (word, excess) = (gate.name(), gate == Gate::Excess);
        let mut left_out = Vec::new();
        let mut checked = Vec::new();
        match measured {
            Some(m) => {
                let side = usize::from(excess);
                checked.push(format!(
                    "{} surface points, {}; {}",
                    m.deviation.samples.unwrap_or(0),
                    limit_in_words(word, limit, m.limits[side]),
                    m.extent
                ));
                checked.extend(m.between[side].checked.clone());
                left_out.extend(m.between[side].left_out.clone());
                left_out.extend(too_coarse(prepared, word, limit, &m.deviation));
                if excess && !m.films.is_empty() {
                    checked.push(format!("not counted: {}", films_in_words(m)));
                }
                if !excess && !m.threads.is_empty() {
                    checked.push(format!("not counted: {}", threads_in_words(prepared, facts, m)));
                }
                left_out.extend(m.left_out.clone());
                left_out.extend(m.unseen.clone().filter(|_| !excess));
            }
            // Features of the inspection plan are judged without one.
            None if prepared.scene.file.design.is_some() => {}
            None => left_out.push("the scene has no design part".to_owned()),
        }
        left_out.extend(unstated::ideal(prepared));
        if excess && !inspection.is_empty() {
            checked.push(format!("{} features of the inspection plan", inspection.len()));
        }
        Coverage { checked: (!checked.is_empty()).then(|| checked.join("; ")), left_out }
    };
    let program = Coverage {
        checked: Some(format!("executed to its end, {} blocks", summary.blocks)),
        left_out: {
            let cut_off = (!facts.ended).then(|| "the text ends without M30 or M2: it may be cut off".to_owned());
            let mut assumed: Vec<&str> = Vec::new();
            for finding in log.all().iter().filter(|f| f.code == finding::ASSUMED.code) {
                if !assumed.contains(&finding.message.as_str()) {
                    assumed.push(&finding.message);
                }
            }
            cut_off.into_iter().chain(assumed.into_iter().map(|what| format!("assumed: {what}"))).collect()
        },
    };
    let mut coverage = PerGate::<Coverage>::default();
    coverage[Gate::Program] = program;
    coverage[Gate::Limits] = limits;
    coverage[Gate::Process] = process;
    coverage[Gate::Collision] = collision;
    coverage[Gate::NearMiss] = near;
    coverage[Gate::Gouge] = shape(Gate::Gouge, tolerances.gouge_mm);
    coverage[Gate::Excess] = shape(Gate::Excess, tolerances.excess_mm);
    coverage[Gate::Surface] = surface_coverage(prepared);
    for gate in [Gate::Program, Gate::Gouge, Gate::Excess, Gate::Surface] {
        coverage[gate].left_out.extend_from_slice(log.left_out(gate));
    }
    if facts.pieces == 0 {
        for gate in [Gate::Limits, Gate::Process, Gate::Collision, Gate::NearMiss] {
            coverage[gate] = Coverage { checked: None, left_out: vec!["the program has no motion".into()] };
        }
    }
    text_not_run::leave_out(prepared, &mut coverage);
    partial_run::leave_out(partial, &mut coverage);
    debug_assert!(log.all().iter().all(|f| f.severity != Severity::Error || !f.message.is_empty()));
    let judged = |(gate, c): (Gate, &Coverage)| match gate {
        Gate::Surface if partial.is_none() => surface_gate::fold(of_surface, &c.left_out, surface),
        _ => gates::judge(gate, c, log),
    };
    let asked = |judged: GateVerdict| match prepared.scene.file.not_asked(judged.gate) {
        Some(why) => gates::not_asked(judged, why, surface),
        None => judged,
    };
    coverage.iter().map(judged).map(asked).collect()
}
