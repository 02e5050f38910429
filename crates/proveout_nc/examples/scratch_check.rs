//! scratch
#![allow(clippy::print_stdout)]
use proveout_nc::{Dialect, Settings, Survey};
fn main() {
    let mut dialect = Dialect::Auto;
    for path in std::env::args().skip(1) {
        if let Some(name) = path.strip_prefix("--") { dialect = Dialect::from_name(name).unwrap(); continue; }
        let s = Survey::of_file(&path, &Settings { dialect, ..Settings::default() }, &mut |_| None);
        println!("=== {path}: {:?} {} commands, {} motions, ended {} sub {}", s.dialect, s.commands, s.motions, s.ended, s.subprogram);
        for f in s.faults.iter().take(30) { println!("  {}:{} [{}] {}", f.line, f.column, f.code, f.message); }
        if s.more_faults > 0 { println!("  and {} more", s.more_faults); }
        for f in s.defects() { println!("  DEFECT {}:{} [{}] {}", f.line, f.column, f.code, f.message); }
        for n in &s.not_run { println!("  {:?} {n}", n.weight()); }
    }
}
