//! The memory that a run announces before it starts, held to what the program has taken at most.
//!
//! One small scene by default. With `PROVEOUT_MEMORY=1` a table of scenes from small to large, in the release
//! profile (some minutes and up to 1.5 GiB); with `PROVEOUT_MEMORY=all` also a million moves on 300 x 300 mm
//! at 0.1 mm.

#![allow(clippy::print_stdout, reason = "the table is what is asked for")]

use std::{
    env,
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// The announced memory is at most so many times the largest resident one, and never less than it.
const MOST: f64 = 1.5;

const TOOLS: &str = "[[tool]]\nnumber = 1\nname = \"B6\"\nkind = \"ball\"\ndiameter_mm = 6.0\nflute_length_mm = 25.0\n\
                     shank_diameter_mm = 6.0\noverall_length_mm = 140.0\ngauge_length_mm = 140.0\nflutes = 2\n";

/// A block, its cells, the moves of a wavy raster over its top, and what is written.
struct Case {
    name: &'static str,
    size: [f64; 3],
    cell: f64,
    moves: usize,
    design: bool,
    recording: bool,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

impl Case {
    fn write(&self, folder: &Path) {
        let [x, y, z] = self.size;
        let part = if self.design { "[part]\nmesh = \"part.obj\"\n" } else { "" };
        let scene = format!(
            "name = \"memory\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = {}\n[stock]\n\
             box = {{ min_mm = [0, 0, 0], max_mm = [{x}, {y}, {z}] }}\n{part}[mount]\ntranslation_mm = [{}, {}, 40]\n\
             [work_offsets.G54]\nX_mm = {}\nY_mm = {}\nZ_mm = 40\n[tolerances]\ngouge_mm = 0.5\nexcess_mm = 0.8\n\
             [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n",
            root().join("machines/three-axis-mill"),
            self.cell,
            -0.5 * x,
            -0.5 * y,
            -0.5 * x,
            -0.5 * y,
        );
        let mut program = format!(
            "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z{:.3}\nS8000 M3\nG0 X-10. Y-10.\nG0 Z{:.3}\n",
            z + 40.0,
            z - 1.0
        );
        let rows = ((y + 8.0) / 3.0) as usize + 1;
        let in_row = (self.moves / rows).max(1);
        for row in 0..rows {
            let forth = row % 2 == 0;
            let at = |t: f64| if forth { -8.0 + (x + 16.0) * t } else { x + 8.0 - (x + 16.0) * t };
            writeln!(program, "G1 X{:.4} Y{:.4} F6000.", at(0.0), -4.0 + 3.0 * row as f64).expect("a text");
            for k in 1..=in_row {
                let along = at(k as f64 / in_row as f64);
                let height = z - 1.0 + 0.2 * (0.7 * along + row as f64).sin();
                writeln!(program, "X{along:.4} Z{height:.4}").expect("a text");
            }
        }
        program += &format!("G0 Z{:.3}\nM5\nM30\n", z + 40.0);
        let (mut obj, top) = (String::new(), z - 1.0);
        for k in 0..8 {
            let at = |bit: usize, high: f64| if k >> bit & 1 == 1 { high } else { 0.0 };
            writeln!(obj, "v {} {} {}", at(0, x), at(1, y), at(2, top)).expect("a text");
        }
        for f in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
            writeln!(obj, "f {f}").expect("a text");
        }
        for (name, text) in [("scene.toml", &scene), ("main.nc", &program), ("part.obj", &obj)] {
            fs::write(folder.join(name), text).expect("written");
        }
        fs::write(folder.join("tools.toml"), TOOLS).expect("written");
    }

    /// Announced memory, largest resident memory, stock at the end, MiB; none where the host does not say.
    fn measured(&self) -> Option<[f64; 3]> {
        let folder = tempfile::tempdir().expect("temporary folder");
        self.write(folder.path());
        let rerun = if self.recording { "file" } else { "off" };
        let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(folder.path())
            .args(["run", ".", "--output", "result", "--rerun", rerun, "--threads", "2"])
            .output()
            .expect("the program starts");
        let printed = String::from_utf8_lossy(&output.stderr);
        let text = fs::read_to_string(folder.path().join("result/run.json"));
        let text = text.unwrap_or_else(|e| panic!("{}: no run folder ({e})\n{printed}", self.name));
        let info: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let announced = info["announced_mib"].as_f64().expect("a run of its own is announced");
        // What is announced before the start is what the file has.
        assert!(printed.contains(&format!("total {announced:.0} of 4096 MiB allowed")), "{printed}");
        Some([announced, info["peak_rss_mib"].as_f64()?, info["stock_mib"]["stock"].as_f64()?])
    }
}

#[test]
fn what_is_announced_is_never_below_the_peak_and_not_far_above_it() {
    let small =
        |recording| Case { name: "small", size: [40.0, 40.0, 18.0], cell: 0.5, moves: 200, design: true, recording };
    let mut cases = vec![small(false)];
    let wanted = env::var("PROVEOUT_MEMORY").unwrap_or_default();
    if !wanted.is_empty() {
        let case = |name, size, cell, moves, design| Case { name, size, cell, moves, design, recording: false };
        cases.extend([
            small(true),
            case("coarse, long program", [300.0, 300.0, 10.0], 2.0, 100_000, true),
            case("plate", [100.0, 100.0, 10.0], 0.2, 10_000, true),
            case("fine plate", [100.0, 100.0, 10.0], 0.1, 10_000, true),
            case("fine plate, no design", [100.0, 100.0, 10.0], 0.1, 10_000, false),
            case("cube", [100.0, 100.0, 100.0], 0.2, 10_000, true),
            case("fine cube", [100.0, 100.0, 100.0], 0.05, 3000, true),
        ]);
    }
    if wanted == "all" {
        cases.push(Case {
            name: "large plate, a million moves",
            size: [300.0, 300.0, 10.0],
            cell: 0.1,
            moves: 1_000_000,
            design: true,
            recording: false,
        });
    }
    let mut failed = Vec::new();
    println!("{:<30} {:>10} {:>10} {:>7} {:>10}", "scene", "announced", "peak", "ratio", "stock, MiB");
    for case in &cases {
        let Some([announced, peak, stock]) = case.measured() else {
            println!("{:<30} left out: the host does not tell the memory of a process", case.name);
            continue;
        };
        let ratio = announced / peak;
        println!("{:<30} {announced:>10.0} {peak:>10.0} {ratio:>7.2} {stock:>10.1}", case.name);
        if !(1.0..=MOST).contains(&ratio) {
            failed.push(format!("{}: {announced:.0} MiB announced, {peak:.0} MiB taken", case.name));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
