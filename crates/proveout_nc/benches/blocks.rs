//! Blocks a second of the readers on plain motion blocks, one core.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use proveout_nc::{Dialect, Program, Settings};

const BLOCKS: u64 = 100_000;

/// Three coordinates a block, as CAM systems write them.
fn plain_blocks(dialect: Dialect) -> String {
    let mut text = String::from(match dialect {
        Dialect::Heidenhain => "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 L X+0 Y+0 Z+0 FMAX\n3 L X+1 F1000\n",
        Dialect::HeidenhainIso => "%A G71 *\nN1 T1 G17 S1000 *\nN2 G0 X+0 Y+0 Z+0 *\nN3 G1 X+1 F1000 *\n",
        Dialect::Apt => "UNITS/MM\nFEDRAT/1000,MMPM\n",
        _ => "N1 G0 X0 Y0 Z0\nN2 G1 F1000.\n",
    });
    for i in 0..BLOCKS {
        let (x, y, z) = (i % 977, i % 1009, i % 83);
        let n = i + 10;
        let (u, v) = (y % 1000, x % 1000);
        text.push_str(&match dialect {
            Dialect::Heidenhain => format!("{n} L X+{x}.{u:03} Y-{y}.{v:03} Z+0.{z:03}\n"),
            Dialect::HeidenhainIso => format!("N{n} X+{x}.{u:03} Y-{y}.{v:03} Z+0.{z:03} *\n"),
            Dialect::Apt => format!("GOTO/{x}.{u:03},-{y}.{v:03},0.{z:03}\n"),
            _ => format!("N{n} X{x}.{u:03} Y-{y}.{v:03} Z.{z:03}\n"),
        });
    }
    text
}

fn read(c: &mut Criterion) {
    let mut group = c.benchmark_group("read");
    group.throughput(Throughput::Elements(BLOCKS)).sample_size(20);
    for (_, dialect) in Dialect::NAMES {
        let text = plain_blocks(dialect);
        let settings = Settings { dialect, ..Settings::default() };
        group.bench_function(dialect.name(), |b| {
            b.iter(|| Program::from_text("plain", text.clone(), &settings).map(|p| p.filter(Result::is_ok).count()));
        });
    }
    group.finish();
}

criterion_group!(benches, read);
criterion_main!(benches);
