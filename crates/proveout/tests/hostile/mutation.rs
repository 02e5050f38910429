//! Thousands of spoiled inputs: scenes, machines, tools, programs of all languages, meshes and stock files.
//!
//! Every one ends with an exit code of the program, within 20 s of a processor, within the memory that a call
//! may take, and without a panic. A run that announces a stock of more than a hundred MiB (a block that a
//! spoiled number has made a hundred meters long has six million rays) has work to do, and a minute.
//! `PROVEOUT_MUTATIONS` sets how many (20,000 for a whole run, a four-hundredth of it by default),
//! `PROVEOUT_MUTATION_SEED` the seed; an input that failed is kept below the target folder and named with its
//! seed.
//!
//! ```text
//! PROVEOUT_MUTATIONS=20000 cargo test -p proveout --test cli hostile:: -- mutation --nocapture
//! ```

#![expect(clippy::print_stderr, reason = "a failing input is named with its seed, and a long run tells what it did")]

use std::{collections::BTreeMap, fs, path::Path, time::Duration};

use crate::hostile::workshop::{PROGRAM, Workshop, proveout_within};

/// Time of a processor that a call may take, s.
const MOST_S: u64 = 20;
/// The same for a run with a stock of this size and more, MiB.
const MOST_LARGE_S: u64 = 60;
const LARGE_MIB: f64 = 100.0;
/// Wall time after which a call counts as hung that waits for something: tests share the processors with
/// others.
const MOST: Duration = Duration::from_secs(240);
/// Calls that are named as the slowest.
const SLOWEST: usize = 5;

/// `SplitMix64` (Steele, Lea, Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// Numbers that have broken programs before: powers, borders of the types, and what is none.
const NUMBERS: [&str; 24] = [
    "0",
    "-0",
    "-1",
    "1",
    "1e-300",
    "1e-9",
    "0.1",
    "999",
    "1e5",
    "1e6",
    "1e9",
    "1e18",
    "1e300",
    "-1e300",
    "2147483647",
    "-2147483648",
    "4294967295",
    "18446744073709551616",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "00001",
    ".",
];

/// Words that have broken programs before, of all languages and formats.
const WORDS: [&str; 26] = [
    "(",
    "((((((((",
    "[",
    "#",
    "-",
    "\"",
    "'",
    "TURN=999",
    "G2",
    "G64",
    "TRAORI",
    "AROT Z30",
    "LOOP",
    "GOTOB A",
    "R1=",
    "\u{1b}[2J",
    "\u{202e}",
    "\r",
    "\0",
    "=",
    "[[program]]",
    "{",
    "}",
    "/dev/zero",
    "..",
    "\u{fffd}",
];

/// Changes one to four places of a file.
fn spoiled(seed: &[u8], binary: bool, random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.below(bytes.len());
        match random.below(if binary { 5 } else { 10 }) {
            0 => bytes[at] = random.next() as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes.truncate(at),
            3 => {
                let end = (at + random.below(64)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            4 if binary => {
                let value = *random.of(&[0_u32, 1, 2, 0x7f80_0000, 0x7fff_ffff, 0x8000_0000, u32::MAX]);
                let end = (at + 4).min(bytes.len());
                bytes.splice(at..end, value.to_le_bytes());
            }
            4 => {
                let end = (at + random.below(200)).min(bytes.len());
                bytes.drain(at..end);
            }
            // A number of the text, for a number of the list.
            5..=7 => {
                let digits = |b: &u8| b.is_ascii_digit() || *b == b'.';
                let Some(from) = bytes[at..].iter().position(digits).map(|k| at + k) else { continue };
                let to = bytes[from..].iter().position(|b| !digits(b)).map_or(bytes.len(), |k| from + k);
                bytes.splice(from..to, random.of(&NUMBERS).bytes());
            }
            8 => {
                bytes.splice(at..at, random.of(&WORDS).bytes());
            }
            // A line for a line.
            _ => {
                let text = String::from_utf8_lossy(&bytes).into_owned();
                let mut lines: Vec<&str> = text.split('\n').collect();
                let (a, b) = (random.below(lines.len()), random.below(lines.len()));
                match random.below(3) {
                    0 => lines.swap(a, b),
                    1 => {
                        lines.remove(a);
                    }
                    _ => lines.insert(a, lines[b]),
                }
                bytes = lines.join("\n").into_bytes();
            }
        }
    }
    bytes
}

/// A tetrahedron in the three formats.
fn meshes() -> Vec<(&'static str, Vec<u8>)> {
    let points = [[0.0_f32, 0.0, -20.0], [20.0, 0.0, -20.0], [0.0, 20.0, -20.0], [0.0, 0.0, 0.0]];
    let faces = [[0_u8, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mut stl = vec![b' '; 80];
    stl.extend(4_u32.to_le_bytes());
    let mut ascii = String::from("solid t\n");
    let mut obj: String = points.iter().map(|p| format!("v {} {} {}\n", p[0], p[1], p[2])).collect();
    for face in faces {
        stl.extend([0; 12]);
        ascii += "facet normal 0 0 0\nouter loop\n";
        for corner in face {
            let p = points[usize::from(corner)];
            p.iter().for_each(|x| stl.extend(x.to_le_bytes()));
            ascii += &format!("vertex {} {} {}\n", p[0], p[1], p[2]);
        }
        ascii += "endloop\nendfacet\n";
        stl.extend([0; 2]);
        obj += &format!("f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1);
    }
    ascii += "endsolid t\n";
    let mut bin = Vec::new();
    points.iter().flatten().for_each(|x| bin.extend((x * 1e-3).to_le_bytes()));
    bin.extend(faces.iter().flatten());
    let mut json =
        br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"a","children":[1]},
        {"mesh":0,"translation":[0,0,0],"rotation":[0,0,0,1],"scale":[1,1,1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
        {"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
        "buffers":[{"byteLength":60}]}"#
            .to_vec();
    while !json.len().is_multiple_of(4) {
        json.push(b' ');
    }
    let mut glb = b"glTF".to_vec();
    for n in [2, 28 + json.len() + bin.len(), json.len()] {
        glb.extend((n as u32).to_le_bytes());
    }
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    vec![("part.stl", stl), ("text.stl", ascii.into_bytes()), ("part.obj", obj.into_bytes()), ("part.glb", glb)]
}

/// Programs of the languages, with loops, formulas, arcs, subprograms and frames.
const PROGRAMS: [(&str, &str); 6] = [
    ("program.mpf", PROGRAM),
    (
        "rich.mpf",
        "G17 G54 G90 G94 G710 G64\nT=\"END_D20\"\nM6\nR1=1+2*3 R2=SIN(30)\nG0 X0 Y0 Z50 S1000 M3 D1\nCYCLE832(0.01,1,1)\nTRANS X1\n\
         AROT Z10\nFOR R3=1 TO 3\nG1 X=R3 Y=R2 F500\nENDFOR\nG1 X15 Y5\nG2 X5 Y-5 I-5 J-5\nG3 X0 Y0 CR=10\nROT\nMSG(\"a\"<<R1)\nG4 F1\nG0 Z50\nM30\n",
    ),
    (
        "a.nc",
        "O1\nG17G21G54G90G94\nT1M6\n#1=[1+2]*3\nG0X0Y0\nG43H1Z50.S1000M3\nWHILE[#1GT0]DO1\n#1=#1-1\nG1X#1F500.\nEND1\nG81X1.Y1.Z-1.R5.\nG80\n\
         G68X0Y0R10.\nG1X15.Y5.\nG2X5.Y-5.I-5.J-5.\nG69\nM98P2L2\nM30\nO2\nG91\nG1X1.\nG90\nM99\n",
    ),
    (
        "a.ngc",
        "o100 sub\n#<d>=[#1/2]\ng1 z[5-#<d>] f200\no100 endsub\ng21 g90 g64 p0.01 g54\nt1 m6 g43\ng0 x0 y0 z50 s1000 m3\no100 call [6]\n\
         o103 repeat [3]\ng91 x1\no103 endrepeat\ng90\ng1 x0 y0 f200\ng2 x5 y5 i5 j0\nm2\n",
    ),
    (
        "a.h",
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+50 R0 FMAX M3\nQ1 = 3 * ( 1 + 2 )\nLBL 1\nL IX+Q1 F500\nCALL LBL 1 REP 2\n\
         CC X+0 Y+0\nL X+5 Y+0 F500\nC X+0 Y+5 DR+\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+1\nM30\nEND PGM A MM\n",
    ),
    (
        "a.apt",
        "PARTNO A\nUNITS/MM\nLOADTL/1\nSPINDL/1000,RPM,CLW\nRAPID\nGOTO/0,0,50\nFEDRAT/500,MMPM\nGOTO/0,0,5,0,0,1\nGOTO/10,0,5\nFINI\n",
    ),
];

/// The stock that a run announces, MiB.
fn announced_mib(text: &str) -> f64 {
    text.split("memory: stock ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok()).unwrap_or(0.0)
}

/// A seed: name of the file, its bytes, whether it is binary, and the call.
struct Seed {
    name: String,
    bytes: Vec<u8>,
    binary: bool,
    call: Vec<String>,
}

fn seeds(shop: &Workshop) -> Vec<Seed> {
    let words = |call: &str| call.split(' ').map(str::to_owned).collect::<Vec<_>>();
    let run = "run . --output result --rerun off --threads 1";
    let mut all = Vec::new();
    let mut put = |name: &str, bytes: &[u8], binary: bool, call: &str| {
        all.push(Seed { name: name.to_owned(), bytes: bytes.to_vec(), binary, call: words(call) });
    };
    for name in ["scene.toml", "machine/machine.toml", "tools.toml"] {
        let text = shop.read(name);
        put(name, text.as_bytes(), false, run);
        put(name, text.as_bytes(), false, &format!("{run} --dynamics servo"));
    }
    for (name, text) in PROGRAMS {
        shop.write(name, text);
        put(name, text.as_bytes(), false, &format!("run . --nc {name} --output result --rerun off --threads 1"));
        put(name, text.as_bytes(), false, &format!("nc {name} --post siemens-840d"));
        put(name, text.as_bytes(), false, &format!("check {name}"));
    }
    for (name, bytes) in meshes() {
        shop.write(name, &bytes);
        let scene = format!("mesh-{name}.toml");
        let text = shop.read("scene.toml")
            + &format!("[part]\nmesh = \"{name}\"\n[[fixture]]\nname = \"f\"\nmesh = \"{name}\"\nmesh_unit = \"mm\"\n");
        shop.write(&scene, text);
        put(
            name,
            &bytes,
            name != "text.stl" && name != "part.obj",
            &format!("run {scene} --output result --rerun off --threads 1"),
        );
    }
    let first = shop
        .call(&words("run . --output first --rerun off --threads 1").iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(first.code(), Some(3), "{}", first.text);
    fs::copy(shop.path().join("first/stock.dexel"), shop.path().join("stock.dexel")).expect("copied");
    let stock = fs::read(shop.path().join("stock.dexel")).expect("read");
    let text = shop
        .read("scene.toml")
        .replace("box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }", "from_run = \"stock.dexel\"");
    shop.write("second.toml", text);
    put("stock.dexel", &stock, true, "run second.toml --output result --rerun off --threads 1");
    put("stock.dexel", &stock, true, "measure stock.dexel --section z=-1");
    let manifest = shop.read("first/manifest.json");
    put("first/manifest.json", manifest.as_bytes(), false, "verify first");
    all
}

pub(crate) fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(otherwise)
}

fn keep(seed: &Seed, bytes: &[u8], number: u64) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("hostile-{number:x}"));
    fs::create_dir_all(&folder).expect("made");
    let file = folder.join(seed.name.replace('/', "-"));
    fs::write(&file, bytes).expect("written");
    fs::write(folder.join("call"), seed.call.join(" ")).expect("written");
    file.display().to_string()
}

#[test]
fn mutation_of_every_input_ends_well() {
    let shop = Workshop::new();
    let seeds = seeds(&shop);
    // Unspoiled, each is read: what is refused for another reason would test nothing.
    let refused: Vec<String> = seeds
        .iter()
        .map(|seed| shop.call(&seed.call.iter().map(String::as_str).collect::<Vec<_>>()))
        .filter(|output| output.code() == Some(2))
        .map(|output| output.text)
        .collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
    let count = number("PROVEOUT_MUTATIONS", 50);
    let begin = number("PROVEOUT_MUTATION_SEED", 21);
    let (mut faults, mut codes, mut slowest, mut large) = (Vec::new(), BTreeMap::<i32, u64>::new(), Vec::new(), 0);
    for k in 0..count {
        // Each input has its own seed, so that one alone can be made again.
        let number = begin.wrapping_mul(1 << 32).wrapping_add(k);
        let mut random = Random(number);
        let seed = &seeds[k as usize % seeds.len()];
        let bytes = spoiled(&seed.bytes, seed.binary, &mut random);
        shop.write(&seed.name, &bytes);
        let call: Vec<&str> = seed.call.iter().map(String::as_str).collect();
        let mut output = proveout_within(shop.path(), &call, MOST, MOST_S);
        if output.as_ref().is_some_and(|output| output.code().is_none() && announced_mib(&output.text) >= LARGE_MIB) {
            large += 1;
            output = proveout_within(shop.path(), &call, MOST, MOST_LARGE_S);
        }
        let fault = match output {
            None => Some("hangs".to_owned()),
            Some(output) => {
                slowest.push((output.wall, number, seed.call.join(" ")));
                slowest.sort_by_key(|call| std::cmp::Reverse(call.0));
                slowest.truncate(SLOWEST);
                *codes.entry(output.code().unwrap_or(-1)).or_default() += 1;
                let good = matches!(output.code(), Some(0..=3)) && !output.text.contains("panicked");
                (!good).then(|| format!("{:?}: {}", output.status, output.text.chars().take(600).collect::<String>()))
            }
        };
        if let Some(fault) = fault {
            let file = keep(seed, &bytes, number);
            eprintln!("{number:#x} {}: {fault}\n  kept: {file}", seed.call.join(" "));
            faults.push(file);
        }
        shop.write(&seed.name, &seed.bytes);
    }
    eprintln!(
        "{count} inputs from seed {begin}: exit codes {codes:?}; {large} with a large stock; slowest, wall time:"
    );
    for (wall, number, call) in slowest {
        eprintln!("  {wall:.1?} {number:#x} {call}");
    }
    assert!(faults.is_empty(), "{} of {count} inputs end badly: {faults:#?}", faults.len());
}
