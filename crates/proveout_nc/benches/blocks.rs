//! Blocks a second of the readers on plain motion blocks, one core.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use proveout_nc::{Program, Settings};

const BLOCKS: u64 = 100_000;

fn plain_blocks() -> String {
    let mut text = String::from("N1 G0 X0 Y0 Z0\nN2 G1 F1000\n");
    for i in 0..BLOCKS {
        let (x, y, z) = (i % 977, i % 1009, i % 83);
        text.push_str(&format!("N{} X{}.{:03} Y-{}.{:03} Z.{z:03}\n", i + 10, x, y % 1000, y, x % 1000));
    }
    text
}

fn read(c: &mut Criterion) {
    let text = plain_blocks();
    let settings = Settings::default();
    let mut group = c.benchmark_group("read");
    group.throughput(Throughput::Elements(BLOCKS)).sample_size(20);
    group.bench_function("siemens", |b| {
        b.iter(|| Program::from_text("plain.mpf", text.clone(), &settings).map(|p| p.filter(Result::is_ok).count()));
    });
    group.finish();
}

criterion_group!(benches, read);
criterion_main!(benches);
