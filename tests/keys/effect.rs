//! What is left of a setup: verdict, motion, blocks, stock, made texts, comparison. Digests of the files are
//! not: they change with every byte.

use std::{
    collections::BTreeMap,
    fs,
    hash::{DefaultHasher, Hash, Hasher},
    path::Path,
    sync::{Arc, Mutex},
};

use proveout_sim::{
    Choice, Observer, Prepared, SimError,
    compare::{CompareChoice, Comparing, markdown},
    observer::{Batch, ObserverError, Outcome, Setup as Standing},
    planning, programs,
    run::{run, run_with_surface},
    scene::{Scene, StrategyFile},
    verdict::Verdict,
};

use crate::keys::setups::{Files, Setup};

/// A text that says everything, or why nothing was done.
pub(crate) type Left = Result<String, String>;

/// Writes the files into a folder of their own and does what the setup is for.
pub(crate) fn of(setup: Setup, files: &Files) -> Left {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap_or(folder.path())).map_err(|e| e.to_string())?;
        fs::write(path, bytes).map_err(|e| e.to_string())?;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    let left = pool.install(|| match setup {
        Setup::Plan => planned(folder.path()),
        Setup::Paths | Setup::Planes | Setup::Flank => paths(folder.path()),
        Setup::Remade
        | Setup::RemadeQuaternion
        | Setup::RemadePole
        | Setup::RemadeKeys
        | Setup::RemadeSmooth
        | Setup::RemadeStrip => remade(folder.path()),
        Setup::Compare => compared(folder.path()),
        Setup::Next => next(folder.path()),
        _ => prove(folder.path()),
    });
    // Blocks, findings and errors name the folder.
    let place = folder.path().display().to_string();
    left.map(|text| text.replace(&place, ".")).map_err(|e| e.to_string().replace(&place, "."))
}

fn prove(folder: &Path) -> Result<String, SimError> {
    let seen = Seen::default();
    let text = seen.text.clone();
    let prepared = Prepared::read(folder, &Choice::default())?;
    // What the host holds in addition to the stock differs from call to call.
    let announced = format!("announced {:?}\n", prepared.memory.stocks);
    let result = run(prepared, &mut [Box::new(seen)], folder)?;
    let message = text.lock().map_or_else(|_| String::new(), |t| t.clone());
    Ok(told_verdict(result.verdict) + &message + &announced)
}

/// Two setups one after the other: the second begins with what the first has left.
fn next(folder: &Path) -> Result<String, SimError> {
    Ok(prove(&folder.join("first"))? + &prove(folder)?)
}

fn told_verdict(verdict: Verdict) -> String {
    let verdict = Verdict { digests: BTreeMap::new(), ..verdict };
    serde_json::to_string_pretty(&verdict).unwrap_or_default()
}

fn planned(folder: &Path) -> Result<String, SimError> {
    let scene = Scene::read(folder)?;
    let prepared = Prepared::read(folder, &Choice::default())?;
    Ok(format!("{:?}", programs::helix(&scene, &prepared.machine, &prepared.tools)?))
}

fn paths(folder: &Path) -> Result<String, SimError> {
    let scene = Scene::read(folder)?;
    let prepared = Prepared::read(folder, &Choice::default())?;
    let mut text = String::new();
    for (strategy, name, _) in StrategyFile::ALL {
        if scene.file.plan.as_ref().is_some_and(|p| strategy.of(p).is_some()) {
            let made = planning::plan(&scene, &prepared.machine, &prepared.tools, strategy)?;
            text += &format!("{name}: {:?}\n", made.commands);
        }
    }
    Ok(text)
}

fn remade(folder: &Path) -> Result<String, SimError> {
    let choice = Choice { program: Some("made".into()), ..Choice::default() };
    let listing = |made: proveout_sim::MadeProgram| {
        let figures = made.runs.iter().flat_map(|run| &run.study.figures);
        figures.fold(made.text.clone(), |all, f| all + &format!("; {} {} {}\n", f.name, f.value, f.unit))
    };
    Ok(Prepared::read(folder, &choice)?.made.map_or_else(String::new, listing))
}

fn compared(folder: &Path) -> Result<String, SimError> {
    let mut comparing = Comparing::read(folder, &CompareChoice::default())?;
    comparing.vary(&|_, _| {})?;
    for name in comparing.order() {
        let Some(prepared) = comparing.take(&name) else { continue };
        let (result, surface) = run_with_surface(prepared, Vec::new(), folder)?;
        comparing.add(&name, result, &surface);
    }
    let windows: Vec<_> = comparing.order().iter().map(|name| comparing.windows(name)).collect();
    let Some(mut compared) = comparing.finish() else { return Ok(String::new()) };
    for program in compared.comparison.programs.values_mut() {
        program.digests.clear();
    }
    let message = serde_json::to_string_pretty(&compared.comparison).unwrap_or_default();
    Ok(message + &markdown(&compared.comparison) + &format!("{:?} {windows:?}", compared.pictures.programs))
}

/// Hashes the motion, reports blocks and events, and keeps the stock for a setup that comes after.
#[derive(Default)]
struct Seen {
    text: Arc<Mutex<String>>,
    motion: DefaultHasher,
}

impl Observer for Seen {
    fn name(&self) -> &'static str {
        "seen"
    }

    fn begin(&mut self, setup: &Standing<'_>, _: &Path) -> Result<(), ObserverError> {
        setup.program_lines.hash(&mut self.motion);
        // Recordings and pages show all fixtures, also those that nothing comes near.
        for (name, mesh) in setup.fixtures {
            name.hash(&mut self.motion);
            mesh.positions.iter().flat_map(|p| [p.x, p.y, p.z]).for_each(|v| v.to_bits().hash(&mut self.motion));
        }
        Ok(())
    }

    fn batch(&mut self, _: &Standing<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        let mut numbers = |values: &[f64]| values.iter().for_each(|v| v.to_bits().hash(&mut self.motion));
        for s in batch.samples {
            numbers(&[s.time, s.feed, s.feed_programmed, s.pose.tip.x, s.pose.tip.y, s.pose.tip.z]);
            numbers(s.pose.axis.as_slice());
            [s.commanded, s.velocity, s.acceleration, s.jerk, s.actual].iter().for_each(|q| numbers(&q.0));
            if let Some(drive) = &s.drive {
                numbers(&drive.force.0);
            }
        }
        for p in batch.pieces {
            numbers(&[p.time[0], p.time[1], p.pose[1].tip.x, p.pose[1].tip.y, p.pose[1].tip.z]);
        }
        if let Ok(mut text) = self.text.lock() {
            *text += &format!("{:?}\n{:?}\n", batch.blocks, batch.events);
        }
        Ok(())
    }

    fn end(&mut self, _: &Standing<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        let failed = |e: String| ObserverError { what: "stock".into(), message: e };
        let path = outcome.folder.join("stock.dexel");
        let mut file = fs::File::create(path).map_err(|e| failed(e.to_string()))?;
        outcome.stock.save(&mut file).map_err(|e| failed(e.to_string()))?;
        if let Ok(mut text) = self.text.lock() {
            let (motion, history) = (self.motion.finish(), outcome.stock.history_bytes());
            *text += &format!("motion {motion:x} history {history} patches {}\n", outcome.patches.len());
            for patch in outcome.patches {
                *text += &format!("{} {:?}\n", patch.name(), patch.stock().volume());
            }
        }
        Ok(())
    }
}
