//! A small run without a controller: a real machine and tool, a path along a bulge and a tilted wall, the
//! stock really cut, and signals from differences of the joint positions. What the observers see is what the
//! engine would show them.

use std::{path::Path, sync::Arc};

use proveout_controller::{Event, MoveKind, Piece, Sample};
use proveout_geom::{Aabb, Point, Pose, ToolPose, TriMesh, Vector, box_mesh, rad};
use proveout_machine::{JointValues, Machine};
use proveout_sim::{
    MapPoint, Observer, SurfaceMap,
    finding::{self, Code, Finding},
    observer::{Batch, BlockRow, ClearanceProof, Outcome, SampleSignals, Setup},
    scene::Scene,
    verdict::{
        Axis, AxisUnit, Clearance, Deviation, Gate, GateVerdict, Inspected, MachineUsed, Path as PathFigures, Removal,
        State, Surface, Time, ToolUse, Verdict,
    },
};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_tool::ToolLibrary;

/// Cycle of the samples, s.
const CYCLE: f64 = 0.008;

/// What was shown to the observers, for comparison with what they wrote.
#[allow(dead_code, reason = "each user compares some of it")]
pub(crate) struct Shown {
    pub(crate) samples: Vec<Sample>,
    pub(crate) signals: Vec<SampleSignals>,
    pub(crate) blocks: Vec<BlockRow>,
    pub(crate) surface: SurfaceMap,
    pub(crate) joints: Vec<String>,
    pub(crate) verdict: Verdict,
}

/// One straight stretch of the path: where to (W, mm), tool axis (W), speed (mm/s), kind.
struct Leg {
    to: ToolPose,
    speed: f64,
    kind: MoveKind,
}

/// Rows over the top of the block with a bulge, then a wall cut with a tilted tool.
fn legs() -> Vec<Leg> {
    let axis =
        |tilt: f64, turn: f64| Vector::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()).normalize();
    let mut legs = Vec::new();
    let mut go = |x: f64, y: f64, z: f64, axis: Vector, speed: f64, kind| {
        legs.push(Leg { to: ToolPose { tip: Point::new(x, y, z), axis }, speed, kind });
    };
    go(-45.0, -30.0, 20.0, axis(0.0, 0.0), 400.0, MoveKind::Rapid);
    for row in 0..9 {
        let y = -32.0 + 8.0 * f64::from(row);
        for i in 0..=24 {
            let t = f64::from(i) / 24.0;
            let x = if row % 2 == 0 { -48.0 + 96.0 * t } else { 48.0 - 96.0 * t };
            let bulge = 8.0 * (-(x * x + y * y) / 500.0).exp();
            let kind = if row == 4 && i == 9 { MoveKind::Rapid } else { MoveKind::Feed };
            go(x, y, -10.0 + bulge, axis(0.25 * t, 0.0), 50.0, kind);
        }
    }
    go(0.0, -60.0, 20.0, axis(rad(35.0), -1.5), 400.0, MoveKind::Rapid);
    for i in 0..=60 {
        let turn = -2.6 + 2.2 * f64::from(i) / 60.0;
        let tip = Point::new(44.0 * turn.cos(), 44.0 * turn.sin(), -22.0);
        go(tip.x, tip.y, tip.z, axis(rad(35.0), turn), 30.0, MoveKind::Feed);
    }
    go(0.0, -60.0, 60.0, axis(0.0, 0.0), 400.0, MoveKind::Rapid);
    legs
}

/// Runs the path through the observers and ends the run.
pub(crate) fn run(observers: &mut [Box<dyn Observer>], folder: &Path, cell: f64, message: &str) -> Shown {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let scene = Scene::read(&root.join("scenes/cone-frustum")).expect("scene");
    let machine = Machine::read(&root.join("machines/spinner-u5-620")).expect("machine");
    let tools = ToolLibrary::read(&root.join("tools/cone-frustum.toml")).expect("tools");
    let bounds = Aabb { min: Point::new(-50.0, -40.0, -50.0), max: Point::new(50.0, 40.0, 0.0) };
    let initial = TriDexel::from_box(&bounds, cell, 1 << 32).expect("stock");
    let table_from_work = Pose::from_translation(Vector::new(0.0, 0.0, 140.0));
    let pot = box_mesh(&Aabb { min: Point::new(-30.0, -30.0, 0.0), max: Point::new(30.0, 30.0, 90.0) });
    let fixtures = vec![("clamping \"pot\"".to_owned(), pot)];
    let part = design();
    let setup = Setup {
        scene: &scene,
        program: "synthetic",
        program_lines: 120,
        made: None,
        sources: &std::collections::BTreeMap::new(),
        machine: &machine,
        tools: &tools,
        stock: &initial,
        patches: &[],
        part: Some(&part),
        fixtures: &fixtures,
        table_from_work,
        dynamics: proveout_controller::Dynamics::Planned,
        plant: proveout_controller::servo::Plant::NewtonEuler,
    };
    for o in observers.iter_mut() {
        o.begin(&setup, folder).expect("begin");
    }
    let mut stock = initial.clone();
    stock.take_changed_tiles();
    let joints = machine.joints.iter().map(|j| j.name.clone()).collect();
    let mut state = Position {
        time: 0.0,
        path: 0.0,
        q: machine.home(),
        pose: None,
        velocity: JointValues::ZERO,
        acceleration: JointValues::ZERO,
    };
    let mut shown = Shown {
        samples: Vec::new(),
        signals: Vec::new(),
        blocks: Vec::new(),
        surface: SurfaceMap::default(),
        joints,
        verdict: verdict(0.0, 0.0, message),
    };
    let legs = legs();
    let first = legs[0].to.transformed(&table_from_work);
    if let Ok(s) = machine.inverse_nearest(&first, tools.tools[1].gauge_length, &state.q) {
        state.q = s.q;
    }
    let half = 9 * 25;
    for (chunk_index, chunk) in legs.chunks(12).enumerate() {
        let block0 = chunk_index as u32 * 12;
        let mut batch = Chunk::default();
        for (k, leg) in chunk.iter().enumerate() {
            let block = block0 + k as u32;
            let tool = usize::from(block as usize <= half);
            if block == 0 || block as usize == half + 1 {
                state.time += 6.0;
                batch.events.push(Event::ToolChange { time: state.time, block, tool: Some(tool) });
                batch.events.push(Event::Message { time: state.time, block, text: message.into() });
            }
            step(&setup, &mut state, leg, block, tool, &mut stock, &mut batch);
        }
        if chunk_index == 9 {
            batch.findings.push(finding_of(&finding::RAPID_IN_MATERIAL, &state, message));
        }
        if chunk_index == 20 {
            let mut near = finding_of(&finding::NEAR_MISS, &state, "holder and clamping pot come nearer than wanted");
            (near.penetration_mm, near.clearance_mm, near.value, near.limit) = (None, Some(1.3), Some(1.3), Some(2.0));
            near.unit = Some("mm".into());
            batch.findings.push(near);
        }
        let changed = stock.take_changed_tiles();
        let seen = Batch {
            samples: &batch.samples,
            signals: &batch.signals,
            pieces: &batch.pieces,
            blocks: &batch.blocks,
            events: &batch.events,
            findings: &batch.findings,
            time: state.time,
            stock: &stock,
            changed_tiles: &changed,
            patches: &[],
            changed_in_patches: &[],
            loose: &[],
        };
        for o in observers.iter_mut() {
            o.batch(&setup, &seen).expect("batch");
        }
        shown.verdict.findings.append(&mut batch.findings);
        shown.samples.append(&mut batch.samples);
        shown.signals.append(&mut batch.signals);
        shown.blocks.append(&mut batch.blocks);
    }
    let findings = std::mem::take(&mut shown.verdict.findings);
    shown.verdict = verdict(state.time, initial.volume() - stock.volume(), message);
    shown.verdict.removal.cell_mm = cell;
    shown.verdict.removal.stock_left_mm3 = stock.volume();
    shown.verdict.findings = findings;
    shown.verdict.findings.push(finding_of(&finding::NOTE, &state, "COOLON has no effect in the twin"));
    shown.surface = measure(&stock);
    let shape = shown.surface.shape();
    let outcome = Outcome {
        verdict: &shown.verdict,
        stock: &stock,
        patches: &[],
        surface: &shape,
        proof: &ClearanceProof::default(),
        folder,
    };
    for o in observers.iter_mut() {
        shown.surface.point_bands().for_each(|band| o.surface_points(&setup, &band).expect("points"));
        shown.surface.mesh_parts().for_each(|part| o.surface_mesh(&setup, &shape, &part).expect("mesh"));
        o.end(&setup, &outcome).expect("end");
    }
    shown
}

struct Position {
    time: f64,
    path: f64,
    q: JointValues,
    pose: Option<ToolPose>,
    velocity: JointValues,
    acceleration: JointValues,
}

#[derive(Default)]
struct Chunk {
    samples: Vec<Sample>,
    signals: Vec<SampleSignals>,
    pieces: Vec<Piece>,
    blocks: Vec<BlockRow>,
    events: Vec<Event>,
    findings: Vec<Finding>,
}

fn step(
    setup: &Setup<'_>,
    state: &mut Position,
    leg: &Leg,
    block: u32,
    tool: usize,
    stock: &mut TriDexel,
    out: &mut Chunk,
) {
    let from = state.pose.unwrap_or(leg.to);
    let length = (leg.to.tip - from.tip).norm();
    let cycles = (length / leg.speed / CYCLE).ceil().max(1.0);
    let begin = state.time;
    let gauge = setup.tools.tools[tool].gauge_length;
    let mut removed = 0.0;
    let mut last = from;
    let mut last_q = state.q;
    let parts = 3.0_f64.min(cycles);
    for part in 0..parts as u32 {
        let to = from.interpolated(&leg.to, f64::from(part + 1) / parts);
        let item = |body| SweepItem { id: block, body, action: Action::Remove, motion: SweepMotion { from: last, to } };
        let items: Vec<SweepItem<'_>> = setup.tools.tools[tool].cutting().map(|b| item(&b.profile)).collect();
        let volume: f64 = stock.sweep(&items).iter().map(|r| r.volume_mm3).sum();
        removed += volume;
        let end = begin + cycles * CYCLE * f64::from(part + 1) / parts;
        let rate = volume / (cycles * CYCLE / parts);
        let start = state.time;
        while state.time + 0.5 * CYCLE < end {
            state.time += CYCLE;
            let t = ((state.time - begin) / (cycles * CYCLE)).min(1.0);
            let pose = from.interpolated(&leg.to, t).transformed(&setup.table_from_work);
            let q = match setup.machine.inverse_nearest(&pose, gauge, &state.q) {
                Ok(s) => s.q,
                Err(_) => state.q,
            };
            let velocity = (q - state.q) * (1.0 / CYCLE);
            let acceleration = (velocity - state.velocity) * (1.0 / CYCLE);
            let jerk = (acceleration - state.acceleration) * (1.0 / CYCLE);
            state.path += length / cycles;
            out.samples.push(Sample {
                time: state.time,
                block,
                path_length: state.path,
                commanded: q,
                velocity,
                acceleration,
                jerk,
                actual: q,
                pose,
                feed_programmed: if leg.kind == MoveKind::Feed { leg.speed } else { 0.0 },
                feed: leg.speed * (1.0 - 0.4 * (state.time * 0.7).sin().powi(8)),
                kind: leg.kind,
                drive: None,
            });
            let clearance = Some(40.0 + 25.0 * (state.time * 0.2).sin());
            out.signals.push(SampleSignals { removal_rate: rate, clearance, tool: Some(tool as u32) });
            (state.q, state.velocity, state.acceleration) = (q, velocity, acceleration);
        }
        let pose = [last, to].map(|p| p.transformed(&setup.table_from_work));
        out.pieces.push(Piece {
            time: [start, state.time],
            block,
            kind: leg.kind,
            joints: [last_q, state.q],
            pose,
            deviation: 1e-3,
            edge_deviation: 0.0,
            joint_deviation: JointValues::ZERO,
            finer: None,
        });
        (last, last_q) = (to, state.q);
    }
    out.blocks.push(BlockRow {
        block,
        file: Arc::from("synthetic.mpf"),
        line: block + 10,
        kind: leg.kind,
        tool: Some(tool as u32),
        start_time: begin,
        end_time: state.time,
        length,
        feed: (leg.kind == MoveKind::Feed).then_some(leg.speed),
        volume_mm3: removed,
        engagement_mm: removed.cbrt(),
        engagement: None,
    });
    state.pose = Some(leg.to);
}

/// Height that the rows aim at.
fn height(x: f64, y: f64) -> f64 {
    -10.0 + 8.0 * (-(x * x + y * y) / 500.0).exp()
}

/// The block with the bulge on top as a closed mesh.
fn design() -> TriMesh {
    let n = 40_u32;
    let mut mesh = TriMesh::default();
    let at = |i: u32, j: u32, z: Option<f64>| {
        let (x, y) = (-50.0 + 100.0 * f64::from(i) / f64::from(n), -40.0 + 80.0 * f64::from(j) / f64::from(n));
        Point::new(x, y, z.unwrap_or_else(|| height(x, y)))
    };
    let mut quad = |a: Point, b: Point, c: Point, d: Point| {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend([a, b, c, d]);
        mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    };
    let low = Some(-50.0);
    for i in 0..n {
        for j in 0..n {
            quad(at(i, j, None), at(i + 1, j, None), at(i + 1, j + 1, None), at(i, j + 1, None));
            quad(at(i, j, low), at(i, j + 1, low), at(i + 1, j + 1, low), at(i + 1, j, low));
        }
        quad(at(i, 0, low), at(i + 1, 0, low), at(i + 1, 0, None), at(i, 0, None));
        quad(at(i + 1, n, low), at(i, n, low), at(i, n, None), at(i + 1, n, None));
        quad(at(0, i + 1, low), at(0, i, low), at(0, i, None), at(0, i + 1, None));
        quad(at(n, i, low), at(n, i + 1, low), at(n, i + 1, None), at(n, i, None));
    }
    mesh.merge_equal_vertices()
}

/// Deviation in z from the bulge for what looks up; nothing for the rest.
fn measure(stock: &TriDexel) -> SurfaceMap {
    let surface = stock.surface();
    let deviation = |p: &Point, n: &Vector| (n.z > 0.3 && p.z > -14.0).then(|| 0.05 * (p.z - height(p.x, p.y)));
    let vertex_deviation =
        surface.mesh.positions.iter().zip(&surface.normals).map(|(p, n)| deviation(p, n).unwrap_or(f64::NAN)).collect();
    let point = |p: proveout_stock::SurfacePoint| {
        let n = p.normal.unwrap_or_else(Vector::z);
        MapPoint {
            position: p.point.coords.into(),
            normal: n.into(),
            deviation: deviation(&p.point, &n),
            scallop: None,
            scallop_geometric: None,
            made_by: p.made_by,
        }
    };
    let points = stock.surface_points().map(point).collect();
    SurfaceMap {
        mesh: surface.mesh,
        normals: surface.normals,
        vertex_deviation,
        points,
        cells_mm: stock.cells_mm(),
        patches: Vec::new(),
    }
}

fn finding_of(code: &Code, state: &Position, message: &str) -> Finding {
    let tip = state.pose.map(|p| p.tip);
    Finding {
        code: code.code.into(),
        family: code.family,
        severity: code.severity,
        file: Some("synthetic.mpf".into()),
        line: Some(118),
        block: Some(108),
        time_s: Some(state.time),
        axes: [("X", 0), ("Y", 1), ("Z", 2), ("B", 3), ("C", 4)]
            .map(|(n, i)| (n.to_owned(), if i > 2 { state.q[i].to_degrees() } else { state.q[i] }))
            .into(),
        bodies: vec!["cutter".into(), "stock".into()],
        point_mm: tip.map(|t| t.coords.into()),
        penetration_mm: Some(1.25),
        clearance_mm: None,
        value: None,
        limit: None,
        unit: None,
        area_mm2: None,
        volume_mm3: None,
        areas: None,
        repeats: 2,
        message: message.into(),
        tool: None,
        limit_source: code.limit_source,
    }
}

pub(crate) fn verdict(total: f64, removed: f64, message: &str) -> Verdict {
    let gate = |name: &str, state, reason: &str| GateVerdict {
        gate: Gate::named(name).expect("a gate"),
        state,
        reason: reason.into(),
    };
    let linear = |v: f64| Axis {
        unit: AxisUnit::Mm,
        min: -312.4,
        max: 208.113,
        max_velocity: v,
        max_acceleration: 4980.0,
        max_jerk: 49_000.0,
        velocity_utilisation: Some(v / 500.0),
        acceleration_utilisation: Some(0.996),
        jerk_utilisation: Some(0.98),
        reversals: 214,
        max_following_error: None,
        max_drive_force: None,
        drive_force_unit: None,
        drive_utilisation: None,
        max_drive_power_w: None,
        drive_energy_j: None,
    };
    let rotary = Axis { unit: AxisUnit::Deg, jerk_utilisation: None, ..linear(120.0) };
    Verdict {
        schema_version: 1,
        scene: "cone-frustum".into(),
        program: "synthetic".into(),
        machine: MachineUsed { name: "Spinner U5-620".into(), digest: "3f".repeat(32) },
        digests: ["machine", "program", "scene", "tools"].map(|n| (n.to_owned(), "3f".repeat(32))).into(),
        set: std::collections::BTreeMap::new(),
        verdict: State::Fail,
        gates: vec![
            gate("program", State::Pass, "292 blocks executed to the end"),
            gate("limits", State::Pass, "travel of 5 joints, spindle speed"),
            gate("process", State::Fail, "1 x process-rapid-in-material"),
            gate("collision", State::Pass, "holder and 12 machine bodies against stock, part and 1 fixture"),
            gate("near_miss", State::Fail, "1 x collision-near-miss"),
            gate("gouge", State::Pass, "0.8 million points"),
            gate("excess", State::Pass, "0.8 million points"),
            gate("surface", State::Unchecked, message),
        ],
        partial: None,
        findings: Vec::new(),
        time: Time {
            total_s: total,
            cutting_s: 0.72 * total,
            rapid_s: 0.08 * total,
            dwell_s: 0.02 * total,
            tool_change_s: 12.0,
            lower_bound_s: Some(0.91 * total),
            path_bound_s: Some(0.93 * total),
        },
        axes: [("X", linear(400.0)), ("Y", linear(310.0)), ("Z", linear(150.0)), ("B", rotary.clone()), ("C", rotary)]
            .map(|(n, a)| (n.to_owned(), a))
            .into(),
        path: PathFigures {
            blocks: 292,
            length_mm: 1380.0,
            max_chord_error_mm: Some(0.0005),
            max_contour_error_mm: Some(0.0042),
            max_axis_error_deg: Some(0.0131),
            min_feed_ratio: Some(0.61),
        },
        removal: Removal { moves: 2100, volume_mm3: removed, sweep_bound_mm: 1e-6, ..Removal::default() },
        deviation: Deviation {
            gouges: Some(0),
            gouge_volume_mm3: Some(0.0),
            excesses: Some(1),
            excess_volume_mm3: Some(0.4),
            threads: Some(0),
            thread_volume_mm3: Some(0.0),
            films: Some(0),
            film_volume_mm3: Some(0.0),
            film_max_mm: None,
            film_thickness_mm: Some(0.001),
            against: Some("mesh".into()),
            design_error_mm: Some(0.001),
            mesh_error_mm: Some(0.001),
            mesh_asked_mm: Some(0.002),
            tolerance_floor_mm: Some(0.0012),
            gouge_max_mm: Some(0.0312),
            excess_max_mm: Some(0.18),
            mean_mm: Some(0.0101),
            rms_mm: Some(0.021),
            gouge_area_mm2: Some(0.0),
            samples: Some(812_345),
            worst_point: Some([12.0, -3.5, -9.1]),
        },
        surface: Surface::default(),
        clearance: Clearance {
            min_mm: Some(1.3),
            pair: Some(["holder".into(), "clamping pot".into()]),
            time_s: Some(41.0),
            checks: 2100,
            ..Clearance::default()
        },
        tools: vec![
            ToolUse {
                number: 2,
                name: "BULL_D25_R2".into(),
                time_s: 0.6 * total,
                cut_time_s: 0.5 * total,
                length_mm: 900.0,
                volume_mm3: 0.8 * removed,
                min_overhang_mm: Some(42.0),
            },
            ToolUse {
                number: 1,
                name: "END_D20".into(),
                time_s: 0.4 * total,
                cut_time_s: 0.3 * total,
                length_mm: 480.0,
                volume_mm3: 0.2 * removed,
                min_overhang_mm: None,
            },
        ],
        inspection: vec![
            Inspected { name: "bulge height".into(), nominal_mm: -2.0, measured_mm: Some(-2.0004), tolerance_mm: 0.01 },
            Inspected { name: "wall".into(), nominal_mm: 31.0, measured_mm: Some(31.031), tolerance_mm: 0.02 },
            Inspected { name: "bore".into(), nominal_mm: 12.0, measured_mm: None, tolerance_mm: 0.02 },
        ],
        probing: Vec::new(),
    }
}
