//! Machines from URDF files: the motion of the machine is that of the description, and what is no machine is
//! refused.

mod bad;
mod geometry;
mod motion;
mod oracle;

use std::path::{Path, PathBuf};

use proveout_input::InputError;
use proveout_machine::{ImportedMachine, Machine, UrdfOptions, import_urdf};
use tempfile::TempDir;

/// A file of `tests/first-part`.
fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/first-part").join(name)
}

fn sample_text(name: &str) -> String {
    std::fs::read_to_string(sample(name)).expect("there")
}

/// Options with the two links.
fn between(tool: &str, table: &str) -> UrdfOptions {
    UrdfOptions { tool_link: Some(tool.into()), table_link: Some(table.into()), ..UrdfOptions::default() }
}

/// Those of `head.urdf`.
fn of_head() -> UrdfOptions {
    UrdfOptions {
        axis_names: Some("joint_1=X,joint_2=Y,joint_3=Z".into()),
        tool_direction: Some("-z".into()),
        ..between("nose", "table")
    }
}

/// A folder with a URDF file.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn import(&self, text: &str, options: &UrdfOptions) -> Result<ImportedMachine, InputError> {
        let file = self.path("robot.urdf");
        std::fs::write(&file, text).expect("written");
        import_urdf(&file, options)
    }

    /// The machine as it is read from the folder that the program writes.
    fn machine(&self, made: &ImportedMachine) -> Machine {
        let folder = self.path("machine");
        std::fs::create_dir_all(&folder).expect("made");
        std::fs::write(folder.join("machine.toml"), &made.text).expect("written");
        if let Some(model) = &made.model {
            std::fs::write(folder.join("model.glb"), model).expect("written");
        }
        Machine::read(&folder).unwrap_or_else(|e| panic!("{e}\n{}", made.text))
    }
}

/// Numbers between 0 and 1 of a linear congruential generator (Knuth's constants).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }
}
