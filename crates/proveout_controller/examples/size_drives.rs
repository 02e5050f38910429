//! Drives for machines without published drive data: `size_drives [--write] machines/NAME ...` prints the
//! `[joint.drive]` tables that the rule of `servo::size_drives` gives; `--write` puts them into
//! `machine.toml`, in the place of those that are there.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program prints")]

use std::{path::Path, process::ExitCode};

use proveout_controller::{dynamics::RigidTree, servo::size_drives};
use proveout_machine::Machine;

/// The file with the drive of joint `name` replaced, or added after the joint's other tables.
fn with_drive(text: &str, name: &str, table: &str) -> Option<String> {
    let mut lines: Vec<&str> = text.lines().collect();
    let begin = (0..lines.len())
        .find(|&i| lines[i] == "[[joint]]" && lines.get(i + 1).is_some_and(|l| *l == format!("name = \"{name}\"")))?;
    let is_end = |l: &&str| l.starts_with('[') && !l.starts_with("[joint.") || l.starts_with("# ");
    let end = begin + 1 + lines[begin + 1..].iter().position(is_end)?;
    let own = lines[begin..end].iter().position(|l| *l == "[joint.drive]").map(|i| begin + i);
    let (from, to) = match own {
        Some(from) => (from, from + lines[from..end].iter().position(|l| l.is_empty()).unwrap_or(end - from)),
        None => (end, end),
    };
    let mut new: Vec<&str> = table.lines().collect();
    if own.is_none() {
        new.push("");
    }
    lines.splice(from..to, new);
    Some(lines.join("\n") + "\n")
}

fn work(folder: &Path, write: bool) -> Result<(), String> {
    let file = folder.join("machine.toml");
    let machine = Machine::read(&file).map_err(|e| e.to_string())?;
    println!("# {}", machine.name);
    for (j, joint) in machine.joints.iter().enumerate() {
        let on = |b: &&proveout_machine::MachineBody| b.attached_to == proveout_machine::Attachment::Joint(j);
        let mass = 0.0 + machine.bodies.iter().filter(on).filter_map(|b| b.mass).map(|m| m.mass).sum::<f64>();
        println!("#   bodies on {}: {mass:.1} kg", joint.name);
    }
    for (_, reason) in &RigidTree::new(&machine).report().unknown {
        println!("#   loads are not known: {reason}");
    }
    let drives = size_drives(&machine)?;
    let mut text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    for drive in &drives {
        let name = &machine.joints[drive.joint].name;
        let (kg, newton) = if drive.rotary { ("kg m2", "Nm") } else { ("kg", "N") };
        println!("# {name}: moves {:.4} {kg}, needs {:.4} {newton}\n{}", drive.moved, drive.need, drive.toml());
        text = with_drive(&text, name, &drive.toml())
            .ok_or_else(|| format!("{}: joint {name} not found", file.display()))?;
    }
    if write {
        std::fs::write(&file, text).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    Ok(())
}

fn main() -> ExitCode {
    let mut folders: Vec<String> = std::env::args().skip(1).collect();
    let write = folders.iter().any(|f| f == "--write");
    folders.retain(|f| f != "--write");
    let mut code = ExitCode::SUCCESS;
    for folder in &folders {
        if let Err(message) = work(Path::new(folder), write) {
            eprintln!("{message}");
            code = ExitCode::FAILURE;
        }
    }
    code
}
