//! What the probing motions of a program find: a rehearsal of the run that stops at each of them.
//!
//! ```text
//!  reader ─► control ─► stock as it is there ─► ball of the stylus on its way ─► answer ─► reader goes on
//! ```
//!
//! A program that probes decides by what it has measured, so that no one can read it to its end without the
//! stock. The rehearsal answers one motion after the other and ends with the last of them. The answers are an
//! input of the run that follows, like a work offset: reader, planner and cutter then work as in any other
//! run, and so do shards, journals and partial runs.
//!
//! The way of the ball is that of the actual machine, with its geometric errors; the stock is that of the
//! moment, and fixtures are met too. Bodies of the machine are left to the check of collisions.

use proveout_controller::ProbeWay;
use proveout_geom::{BallWay, Point, Pose, TriMesh, Vector};
use proveout_nc::{Met, Touch, TouchList};

use crate::{
    cut::{engine::Engine, stages::Stages},
    prepare::{error::SimError, error::from_run_error, prepared::Prepared},
    run::motion_plan::{STRETCH_S, controller, opened, stretches},
    verdict::verdict_file::Probed,
};

/// The ball is off a surface that it left by this, mm: far below what any probe repeats, far above rounding.
const OFF_MM: f64 = 1e-6;
/// Probing motions of a program at most: one that never stops probing is ended with a message.
const MOST_TOUCHES: usize = 100_000;
/// The name of the stock in what was probed.
const STOCK: &str = "stock";

/// What is met by the ball, in the workpiece frame.
struct Targets {
    /// The surface of the stock, until it is cut again.
    stock: Option<TriMesh>,
    fixtures: Vec<(String, TriMesh)>,
}

/// A touch of one of them.
struct Hit {
    share: f64,
    name: String,
    point: Point,
    normal: Vector,
    bound: f64,
}

impl Targets {
    fn new(prepared: &Prepared) -> Self {
        let work_from_table = prepared.table_from_work.inverse();
        let moved = |mesh: &TriMesh| {
            let mut mesh = mesh.clone();
            mesh.positions.iter_mut().for_each(|p| *p = work_from_table.point(p));
            mesh
        };
        Self { stock: None, fixtures: prepared.fixtures.iter().map(|(n, m)| (n.clone(), moved(m))).collect() }
    }

    /// What the ball first meets on a straight way.
    fn first(&mut self, engine: &Engine<'_>, way: &BallWay) -> Option<Hit> {
        let surface = self.stock.get_or_insert_with(|| engine.stock().surface().mesh);
        let stock = engine.stock().stylus_touch(surface, way).map(|t| Hit {
            share: t.share,
            name: STOCK.to_owned(),
            point: t.point,
            normal: t.normal,
            bound: t.bound,
        });
        let fixtures = self.fixtures.iter().filter_map(|(name, mesh)| {
            let t = way.first_touch(mesh)?;
            let normal = (way.center(t.share) - t.point).try_normalize(0.0).unwrap_or_else(Vector::z);
            Some(Hit { share: t.share, name: name.clone(), point: t.point, normal, bound: 0.0 })
        });
        stock.into_iter().chain(fixtures).min_by(|a, b| a.share.total_cmp(&b.share))
    }

    fn comes_off(&mut self, engine: &Engine<'_>, way: &BallWay) -> Option<f64> {
        let surface = self.stock.get_or_insert_with(|| engine.stock().surface().mesh);
        way.comes_off(std::iter::once(&*surface).chain(self.fixtures.iter().map(|(_, mesh)| mesh)))
    }
}

/// Answers to all probing motions of a program, and what they have met.
///
/// # Errors
/// What the program, the control or the memory refuse on the way.
pub(crate) fn measure(mut prepared: Prepared) -> Result<(TouchList, Vec<Probed>), SimError> {
    let touches = prepared.nc_settings.touches.clone().unwrap_or_default();
    let (stock, patches) = prepared.stock.take()?;
    let prepared = prepared;
    let mut engine = Engine::new(&prepared, stock, patches, None)?;
    let mut control = controller(&prepared)?;
    let mut targets = Targets::new(&prepared);
    let mut stages = Stages::default();
    let mut probed = Vec::new();
    // Reads ahead of the control: there is no need to cut what follows the last probing motion.
    let mut scout = prepared.program()?;
    scout.by_ref().for_each(drop);
    while scout.waits_for_probe() {
        let chunk = control.next_chunk().map_err(|e| from_run_error(opened(&prepared, e)))?;
        let Some(chunk) = chunk else { break };
        for stretch in stretches(chunk, STRETCH_S) {
            if !engine.step(&stretch, &mut stages).changed_tiles.is_empty() {
                targets.stock = None;
            }
            engine.check_memory()?;
        }
        let Some(way) = control.take_asked() else { continue };
        if probed.len() >= MOST_TOUCHES {
            let at = &way.location;
            let message =
                format!("{}:{}: the program has probed {MOST_TOUCHES} times, which is the limit", at.file, at.line);
            return Err(SimError::StopAt { message, help: "end the loop that probes".to_owned() });
        }
        let (touch, what) = answer(&prepared, &engine, &mut targets, &way);
        touches.push(touch);
        probed.push(what);
        scout.by_ref().for_each(drop);
    }
    Ok((touches, probed))
}

/// What one probing motion finds.
fn answer(prepared: &Prepared, engine: &Engine<'_>, targets: &mut Targets, way: &ProbeWay) -> (Touch, Probed) {
    let tool = way.tool.and_then(|i| prepared.tools.tools.get(i));
    let mut what = Probed {
        file: way.location.file.to_string(),
        line: way.location.line,
        tool: tool.map(|t| t.name.clone()),
        ..Probed::default()
    };
    let Some(radius) = tool.and_then(|t| t.stylus) else { return (Touch::default(), what) };
    what.ball_diameter_mm = Some(2.0 * radius);
    let work_from_table: Pose = prepared.table_from_work.inverse();
    let centers: Vec<(f64, Point)> = way
        .poses
        .iter()
        .map(|(share, pose)| {
            let pose = pose.transformed(&work_from_table);
            (*share, pose.tip + pose.axis * radius)
        })
        .collect();
    let mut touch = Touch { met: Met::Nothing, at_start: false, ball_radius: radius };
    if let Some((_, last)) = centers.last() {
        what.center_mm = Some((*last).into());
    }
    for (k, pair) in centers.windows(2).enumerate() {
        let [(s0, from), (s1, to)] = [pair[0], pair[1]];
        let share = |part: f64| s0 + (s1 - s0) * part.min(1.0);
        if way.away {
            let ball = BallWay { from, to, radius: radius + OFF_MM };
            let Some(part) = targets.comes_off(engine, &ball) else {
                touch = Touch { met: Met::After(s0), at_start: k == 0, ball_radius: radius };
                what.center_mm = Some(from.into());
                break;
            };
            if part <= 1.0 {
                touch.met = Met::After(share(part));
                what.center_mm = Some(ball.center(part).into());
                break;
            }
            continue;
        }
        let ball = BallWay { from, to, radius };
        let Some(hit) = targets.first(engine, &ball) else { continue };
        touch = Touch { met: Met::After(share(hit.share)), at_start: k == 0 && hit.share <= 0.0, ball_radius: radius };
        what.met = Some(hit.name);
        what.center_mm = Some(ball.center(hit.share).into());
        what.point_mm = Some(hit.point.into());
        what.normal = Some(hit.normal.into());
        what.bound_mm = Some(hit.bound);
        break;
    }
    (touch, what)
}
