//! Feasible maps along a finishing pass over a blade with its platform: contacts a second from nothing and in
//! a walk.
#![allow(
    missing_docs,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a bench prints, and its setup fails by panic"
)]

use std::hint::black_box;

use proveout_blade::{Blade, BladeSpec, CamberSection, Platform};
use proveout_collision::{Obstacle, OrientationSettings, OrientationSpace, SurfaceContact};
use proveout_tool::{Cutter, HolderSection, Tool, ToolBuilder};

/// Contacts of the pass, and their distance, mm.
const CONTACTS: usize = 400;
const STEP_MM: f64 = 0.3;

fn tools() -> [Tool; 2] {
    let holder = || {
        [
            HolderSection { diameter: 20.0, top_diameter: 32.0, length: 40.0 },
            HolderSection { diameter: 63.0, top_diameter: 63.0, length: 20.0 },
        ]
    };
    let ball = ToolBuilder::new(1, "BALL_D8", Cutter::ball(8.0).unwrap(), 14.0, 130.0).shank(8.0).holder(holder());
    let bull = ToolBuilder::new(2, "BULL_D10_R1", Cutter::bull_nose(10.0, 1.0).unwrap(), 16.0, 130.0)
        .shank(10.0)
        .holder(holder());
    [ball.build().unwrap(), bull.build().unwrap()]
}

/// Processor time of this thread so far, s.
fn processor_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}

fn main() {
    let platform = Platform { fillet_radius: 10.0, margin: 14.0, thickness: 12.0 };
    let spec = BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist: 0.004, platform: Some(platform) };
    let blade = Blade::new(spec).unwrap();
    let contacts: Vec<SurfaceContact> = (0..CONTACTS)
        .map(|k| {
            let arc = STEP_MM * k as f64;
            let (at, ahead) = (blade.at(arc, 22.0), blade.at(arc + 0.01, 22.0));
            SurfaceContact { point: at.point, normal: at.normal, feed: ahead.point - at.point, curvatures: None }
        })
        .collect();
    for chord in [0.004, 0.0003] {
        let mesh = blade.mesh(chord);
        for tool in &tools() {
            for finest in [4.0_f64, 2.0, 1.0, 0.5] {
                let settings =
                    OrientationSettings { finest_cell: finest.to_radians(), ..OrientationSettings::default() };
                let obstacle = [Obstacle { name: "blade", mesh: &mesh, cut: true }];
                let space = OrientationSpace::new(tool, &obstacle, &settings).unwrap();
                let start = processor_s();
                let (mut shares, mut cells, mut looked) = ([0.0; 3], 0, [0, 0]);
                for contact in &contacts {
                    let map = black_box(space.map(contact).unwrap());
                    cells += map.cells().count();
                    looked[0] += map.looked();
                    for (sum, share) in shares.iter_mut().zip(map.shares()) {
                        *sum += share;
                    }
                }
                let cold = processor_s() - start;
                let start = processor_s();
                let mut walk = space.walk();
                for contact in &contacts {
                    looked[1] += black_box(walk.next(contact).unwrap()).looked();
                }
                let warm = processor_s() - start;
                // On all cores, each with its share of the pass.
                let cores = std::thread::available_parallelism().map_or(1, usize::from);
                let start = std::time::Instant::now();
                std::thread::scope(|scope| {
                    for part in contacts.chunks(CONTACTS.div_ceil(cores)) {
                        let space = &space;
                        scope.spawn(move || {
                            let mut walk = space.walk();
                            part.iter().for_each(|contact| drop(black_box(walk.next(contact).unwrap())));
                        });
                    }
                });
                let all = start.elapsed().as_secs_f64();
                let [free, _, unknown] = shares.map(|s| 100.0 * s / CONTACTS as f64);
                let n = CONTACTS as f64;
                println!(
                    "{:7} triangles, {:11}, {finest:3} deg: cold {:6.0}/s, walk {:6.0}/s ({:.2} times), {cores} cores {:6.0}/s; {:6.0} cells, looked at {:7.0} \
                     and {:7.0}, free {free:4.1} %, unknown {unknown:4.1} %",
                    mesh.triangles.len(),
                    tool.name,
                    n / cold,
                    n / warm,
                    cold / warm,
                    n / all,
                    cells as f64 / n,
                    looked[0] as f64 / n,
                    looked[1] as f64 / n,
                );
            }
        }
    }
}
