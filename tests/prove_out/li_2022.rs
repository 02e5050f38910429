//! The blade root of Li et al. 2022: original and re-scheduled programs on the same twin.

use std::path::Path;
use std::sync::{Arc, Mutex};

use proveout_sim::observer::{Batch, Observer, ObserverError, Outcome, Setup};
use proveout_sim::verdict::{State, Verdict};
use proveout_sim::{Choice, Prepared};
use proveout_tests::scene;

/// Distance of the rays, mm. Points of the cut surface are exact whatever it is; the judged box of 3 mm round a section of
/// 135 mm then has some hundred of them.
const CELL_MM: f64 = 1.0;

/// Keeps the deviation of every judged point that was cut.
struct Deviations(Arc<Mutex<Vec<f64>>>);

impl Observer for Deviations {
    fn name(&self) -> &'static str {
        "deviations"
    }

    fn begin(&mut self, _: &Setup<'_>, _: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _: &Setup<'_>, _: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn end(&mut self, _: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        let cut = outcome.surface.points.iter().filter(|p| p.made_by.is_some());
        let mut all = self.0.lock().map_err(|e| ObserverError { what: "deviations".into(), message: e.to_string() })?;
        all.extend(cut.filter_map(|p| p.deviation));
        Ok(())
    }
}

/// Verdict, mean and 95th percentile of what a program leaves on the judged surface, mm.
fn prove(program: &str) -> (Verdict, [f64; 2]) {
    let choice = Choice { program: Some(program.into()), resolution_mm: Some(CELL_MM), ..Choice::default() };
    let prepared = Prepared::read(&scene("li-2022-s-theta"), &choice).expect("the scene");
    let kept = Arc::new(Mutex::new(Vec::new()));
    let mut observers: Vec<Box<dyn Observer>> = vec![Box::new(Deviations(Arc::clone(&kept)))];
    let run = proveout_sim::run::run(prepared, &mut observers, Path::new(".")).expect("runs");
    let mut all = kept.lock().expect("one thread is left").clone();
    all.sort_by(f64::total_cmp);
    assert!(all.len() > 500, "{}", all.len());
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    (run.verdict, [mean, all[all.len() * 95 / 100]])
}

#[test]
fn new_axes_leave_the_surface_and_save_time() {
    let programs = ["original", "quaternion", "s-theta"];
    let runs = programs.map(prove);
    for (name, (verdict, left)) in programs.iter().zip(&runs) {
        println!("{name}: {:.2} s, left {:.2?} um", verdict.time.total_s, left.map(|v| v * 1e3));
        println!("{:?}", verdict.deviation);
        println!("{:?}", verdict.clearance);
        for (joint, axis) in &verdict.axes {
            println!("{joint}: {:.2} {:.1} rev {}", axis.max_velocity, axis.max_acceleration, axis.reversals);
        }
        for gate in ["program", "limits", "process", "collision", "near_miss", "gouge", "excess"] {
            let gate = verdict.gates.iter().find(|g| g.name == gate).expect("every gate is there");
            println!("  {gate:?}");
        }
        for f in verdict.findings.iter().take(10) {
            println!("{} {:?} {}", f.code, f.line, f.message);
        }
    }
}
