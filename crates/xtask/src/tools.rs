//! Programs that are not part of the toolchain: one pinned version each, installed next to the build.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::{TaskError, workspace::cargo};

/// A program of the package registry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CargoTool {
    /// Package.
    pub(crate) package: &'static str,
    /// Executable.
    pub(crate) program: &'static str,
    /// Version that the configuration files here are written for.
    pub(crate) version: &'static str,
}

/// Spelling.
pub(crate) const TYPOS: CargoTool = CargoTool { package: "typos-cli", program: "typos", version: "1.52.0" };
/// Licenses, duplicate crates, sources, advisories.
pub(crate) const DENY: CargoTool = CargoTool { package: "cargo-deny", program: "cargo-deny", version: "0.20.2" };

/// The program: from the path where its version is the pinned one, else from `target/ci-tools`, where it is
/// installed when it is missing.
pub(crate) fn find(tool: &CargoTool, target: &Path) -> Result<PathBuf, TaskError> {
    let on_path = PathBuf::from(tool.program);
    if has_version(&on_path, tool) {
        return Ok(on_path);
    }
    let root = target.join("ci-tools");
    let program = root.join("bin").join(format!("{}{}", tool.program, std::env::consts::EXE_SUFFIX));
    if has_version(&program, tool) {
        return Ok(program);
    }
    println!("installing {} {} into {} (once)", tool.package, tool.version, root.display());
    let build = root.join("build");
    let status = Command::new(cargo())
        .args(["install", "--locked", "--force", "--version", tool.version, "--root"])
        .arg(&root)
        .arg("--target-dir")
        .arg(&build)
        .arg(tool.package)
        // They check texts for a second: a quick build is worth more than a quick program.
        .envs([
            ("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0"),
            ("CARGO_PROFILE_RELEASE_LTO", "off"),
            ("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "256"),
            ("CARGO_PROFILE_RELEASE_DEBUG", "false"),
        ])
        // Flags meant for this workspace are not meant for a foreign program.
        .env_remove("RUSTFLAGS")
        .status()
        .map_err(|e| TaskError(format!("cannot start cargo install: {e}")))?;
    // Hundreds of MB that are not needed again; if they cannot be removed, the check does not fail.
    let _ = std::fs::remove_dir_all(&build);
    if status.success() && has_version(&program, tool) {
        return Ok(program);
    }
    Err(TaskError(format!(
        "{} {} is missing and could not be installed. Without network, install it beforehand and put it on the path:\n  \
         cargo install --locked --version {} {}",
        tool.program, tool.version, tool.version, tool.package
    )))
}

fn has_version(program: &Path, tool: &CargoTool) -> bool {
    let Ok(output) = Command::new(program).arg("--version").output() else { return false };
    String::from_utf8_lossy(&output.stdout).split_whitespace().any(|word| word == tool.version)
}
