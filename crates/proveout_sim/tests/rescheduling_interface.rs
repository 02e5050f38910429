//! What a re-scheduling method gets in addition to the poses: contacts with normals and curvatures, free
//! poses, times, the machine. The method here leans the tool from the surface normal towards the feed as far
//! as it stays free, and asks for all of it.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::path::Path;
use std::sync::Mutex;

use proveout_controller::Reprogramming;
use proveout_geom::ToolPose;
use proveout_machine::{KinematicsError, Machine};
use proveout_nc::{Command, Offset, Op, Program, ToolName};
use proveout_reschedule::{CuttingRun, Method, RescheduleError, Rescheduled, Study, Surroundings};
use proveout_sim::Prepared;
use proveout_sim::scene::Scene;
use proveout_tool::{ToolId, ToolLibrary};

#[derive(Default)]
struct LeanFromNormal {
    /// Distance of the ball center from the contact and the larger curvature, for each block on the airfoil.
    seen: Mutex<Vec<[f64; 2]>>,
}

impl Method for LeanFromNormal {
    fn name(&self) -> &'static str {
        "lean-from-normal"
    }

    fn source(&self) -> &'static str {
        "a test"
    }

    fn needs_region(&self) -> bool {
        true
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        let (surface, region) = (around.surface.unwrap(), around.region.unwrap());
        let (ball, machine) = (around.cutter.ball_radius().unwrap(), around.machine.unwrap());
        let mut q = machine.home();
        let mut poses: Vec<ToolPose> = Vec::new();
        for (i, block) in run.blocks.iter().enumerate() {
            assert_eq!(block.time.is_some(), i > 0);
            let center = block.pose.tip + block.pose.axis * ball;
            let contact = surface.contact(&center).unwrap();
            self.seen.lock().unwrap().push([(center - contact.point).norm(), contact.curvatures[0].0]);
            let behind = run.blocks[i.saturating_sub(1)].pose;
            let feed = center - (behind.tip + behind.axis * ball);
            let feed = (feed - contact.normal * feed.dot(&contact.normal)).try_normalize(1e-9);
            let leaned = |degrees: f64| {
                let (s, c) = degrees.to_radians().sin_cos();
                let axis = feed.map_or(contact.normal, |f| contact.normal * c + f * s);
                ToolPose { tip: center - axis * ball, axis }
            };
            let free = [70.0, 35.0, 0.0].into_iter().map(leaned).find(|p| region.clearance(p) > 0.5);
            let pose = free.unwrap_or(block.pose);
            // Leaned that far the head is low: travel of slides is judged when a program runs.
            q = match machine.inverse_nearest(&pose, 190.0, &q) {
                Ok(solution) => solution.q,
                Err(KinematicsError::OverTravel { rotary: false, solution, .. }) => solution.q,
                Err(e) => panic!("{e}"),
            };
            poses.push(pose);
        }
        Ok(Rescheduled { stretch: 0..poses.len(), poses, rotary: None, channel: None, study: Study::default() })
    }
}

#[test]
fn a_method_receives_contacts_curvatures_free_poses_times_and_the_machine() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/li-2022-s-theta");
    let scene = Scene::read(&folder).unwrap();
    let machine = Machine::read(&scene.resolve(&scene.file.machine)).unwrap();
    let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools)).unwrap();
    let settings = Prepared::reader_settings(&scene, None).unwrap();
    let part = Prepared::part_on_table(&scene, None).unwrap();
    let tool = |name: &ToolName| match name {
        ToolName::Name(n) => tools.find(&ToolId::Name(n.clone())),
        _ => None,
    };
    let cutter = |name: &ToolName| Some(tool(name)?.cutting().next()?.profile.clone());
    let region = |name: &ToolName| part.region(tool(name)?).unwrap();
    let method = LeanFromNormal::default();
    let work = Reprogramming {
        machine: &machine,
        method: &method,
        cutter: &cutter,
        tip_tolerance: None,
        length: &|_| None,
        surface: part.surface(),
        region: &region,
        times: None,
    };
    let commands: Vec<Command> =
        Program::open(folder.join("original.mpf"), &settings).unwrap().collect::<Result<_, _>>().unwrap();
    // A tool that is called as longer than it is has its tip elsewhere.
    let mut longer = commands.clone();
    let delta = Op::Offset(Offset::ToolDelta { length: 0.1, radius: 0.0, corner_radius: 0.0 });
    longer.insert(1, Command { op: delta, ..commands[1].clone() });
    let refused = work.apply(longer).unwrap_err();
    assert!(refused.code == "reschedule-path" && refused.message.contains("delta value"), "{refused}");
    assert_eq!(refused.location.unwrap().line, commands[1].location.line);

    let made = work.apply(commands).unwrap();
    let seen = method.seen.lock().unwrap();
    let run = &made.runs[0];
    assert_eq!(seen.len(), run.before.len());
    // The ball of 8 mm touches all along the pass; the last block retracts by 10 mm. Ends have four decimals.
    let on_surface = &seen[..seen.len() - 1];
    assert!(on_surface.iter().all(|[distance, _]| (distance - 8.0).abs() < 1e-3));
    assert!((seen[seen.len() - 1][0] - 18.0).abs() < 0.01, "{:?}", seen[seen.len() - 1]);
    // Edges of 1.6 and 1.2 mm, twisted a little, and a pressure side that is concave along the section.
    let sharpest = on_surface.iter().map(|[_, k]| *k).fold(0.0, f64::max);
    assert!((sharpest - 1.0 / 1.2).abs() < 0.01, "{sharpest}");
    assert!(on_surface.iter().any(|[_, k]| *k < 1e-3), "the larger curvature of a hollow is that along the blade");
    // On a slender blade next to a platform the tool leans far in most places, and no chosen pose touches.
    let angle = |p: &ToolPose, before: &ToolPose| p.angle_to(before).to_degrees();
    assert!(run.after.iter().zip(&run.before).any(|(a, b)| angle(a, b) > 30.0));
    let tool = tool(&ToolName::Name("BALL_D16".into())).unwrap();
    let region = part.region(tool).unwrap().unwrap();
    for pose in run.after.iter().step_by(50) {
        assert!(region.clearance(pose) > 0.5);
        // A hand's breadth towards the blade the shank is in it.
        let plunged = ToolPose { tip: pose.tip - pose.axis * 100.0, axis: pose.axis };
        assert!(region.clearance(&plunged) <= 0.0);
    }
}
