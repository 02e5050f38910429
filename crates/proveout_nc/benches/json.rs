//! JSON lines a second, one core, from commands that lie in memory.

use std::io;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use proveout_nc::{Command, Dialect, JsonWriter, Program, Settings};

const BLOCKS: u64 = 20_000;

/// Straight motions of three axes, which a shift has moved or not; five axes; helical arcs.
fn programs() -> [(&'static str, String); 4] {
    let motions = |head: &str, block: &dyn Fn(u64) -> String| {
        let mut text = String::from(head);
        (0..BLOCKS).for_each(|i| text.push_str(&block(i)));
        text
    };
    let straight = |i: u64| {
        let (x, y, z) = (i % 977, i % 1009, i % 83);
        format!("X{x}.{:03} Y-{y}.{:03} Z.{z:03}\n", y % 1000, x % 1000)
    };
    let five_axes = |i: u64| format!("{} B{}.5 C{}.125\n", straight(i).trim_end(), i % 90, i % 360);
    let arc = |i: u64| {
        let (code, x, center) = if i.is_multiple_of(2) { (2, 10, 5) } else { (3, 0, -5) };
        format!("G{code} X{x} Y0 Z.{:03} I{center} J0\n", i % 83)
    };
    let start = "G0 X0 Y0 Z0 B0 C0\nG1 F1000\n";
    [
        ("straight", motions(start, &straight)),
        ("straight_shifted", motions(&format!("TRANS X10.5 Y20.123\n{start}"), &straight)),
        ("five_axes", motions(start, &five_axes)),
        ("arcs", motions(&format!("TRANS X10.5 Y20.123\n{start}"), &arc)),
    ]
}

fn write(c: &mut Criterion) {
    let mut group = c.benchmark_group("json");
    let settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
    for (name, text) in programs() {
        let commands: Vec<Command> =
            Program::from_text("motions", text, &settings).into_iter().flatten().filter_map(Result::ok).collect();
        group.throughput(Throughput::Elements(commands.len() as u64)).sample_size(20);
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut writer = JsonWriter::new();
                commands.iter().try_for_each(|command| writer.write(command, &mut io::sink()))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, write);
criterion_main!(benches);
