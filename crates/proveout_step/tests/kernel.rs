//! The real helper, where it is installed: `PROVEOUT_STEP` names it, `PROVEOUT_STEP_FILES` a folder that
//! `python/tests/step_files.py` has written, with what each file must give.

use std::path::PathBuf;

use proveout_step::{StepFiles, StepMesh, VARIABLE};

#[derive(serde::Deserialize)]
struct Expected {
    file: String,
    /// Volume by a closed form, mm³, where there is one.
    volume_mm3: Option<f64>,
    /// Words of the refusal, where the file must be refused.
    refused: Option<String>,
}

/// A line past the capture of the harness.
fn tell(line: &str) {
    use std::io::Write as _;
    writeln!(std::io::stdout(), "{line}").ok();
}

/// Every file is closed with its volume, or refused by what is wrong with it. Prints the table of
/// `docs/step.md`.
#[test]
fn files_of_the_kernel_are_closed_or_refused_by_name() {
    let folder = std::env::var_os("PROVEOUT_STEP_FILES").map(PathBuf::from);
    let (Some(folder), Some(_)) = (folder, std::env::var_os(VARIABLE)) else {
        tell("\nLEFT OUT: STEP files by Open CASCADE: PROVEOUT_STEP and PROVEOUT_STEP_FILES name none");
        return;
    };
    let list = std::fs::read(folder.join("expected.json")).expect("the list of the files");
    let list: Vec<Expected> = serde_json::from_slice(&list).expect("a list");
    assert!(list.len() >= 20, "{} files", list.len());
    let files = StepFiles::default();
    for Expected { file, volume_mm3, refused } in list {
        let read = |chord_um: f64| files.read(&folder.join(&file), chord_um);
        let (found, finer) = match (read(10.0), refused) {
            (Ok(_), Some(words)) => panic!("{file}: accepted, where it says {words:?}"),
            (Err(e), Some(words)) => {
                assert!(e.to_string().contains(&words), "{file}: {e}");
                let place = folder.display().to_string() + "/";
                tell(&format!("| `{file}` | refused: {} |", e.to_string().replace(&place, "")));
                continue;
            }
            (Err(e), None) => panic!("{file}: {e}"),
            (Ok(found), None) => (found, read(2.0).unwrap_or_else(|e| panic!("{file}: {e}"))),
        };
        for mesh in [&found, &finer] {
            mesh.mesh.check_solid().unwrap_or_else(|e| panic!("{file}: {e}"));
            // The mesher misses what is asked by some factor on splines, and Proveout says so.
            assert!(mesh.measured_um < 10.0 * mesh.asked_um, "{file}: {} um", mesh.measured_um);
        }
        if let Some(volume) = volume_mm3 {
            // Integration over the faces is asked for 1e-7 of the volume.
            assert!((found.exact_volume_mm3 / volume - 1.0).abs() < 1e-5, "{file}: {}", found.exact_volume_mm3);
        }
        let ppm = |mesh: &StepMesh| 1e6 * (mesh.mesh.volume() / mesh.exact_volume_mm3 - 1.0);
        tell(&format!(
            "| `{file}` | {} | {} | {} / {} | {:.2} / {:.2} | {:.1} | {:.1} / {:.1} |",
            found.text.faces.len(),
            found.solids,
            found.mesh.triangles.len(),
            finer.mesh.triangles.len(),
            found.measured_um,
            finer.measured_um,
            found.exact_volume_mm3,
            ppm(&found),
            ppm(&finer)
        ));
    }
}
