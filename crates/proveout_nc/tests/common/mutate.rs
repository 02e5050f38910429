//! Mutation of seed programs, and one run of a mutated program: used by the replay test, the runner of
//! minutes, and the cargo-fuzz targets. Deterministic: the same seed of numbers gives the same inputs.

use proveout_nc::{Dialect, Limits, Program, Settings, check_text, explain};

/// Folders of seeds with their dialects.
pub const DIALECTS: [(&str, Dialect); 8] = [
    ("siemens", Dialect::Siemens840d),
    ("iso", Dialect::Iso),
    ("fanuc", Dialect::Fanuc),
    ("haas", Dialect::Haas),
    ("linuxcnc", Dialect::LinuxCnc),
    ("heidenhain", Dialect::Heidenhain),
    ("heidenhain-iso", Dialect::HeidenhainIso),
    ("apt", Dialect::Apt),
];

/// Commands of one input: 500 passes of a text of a few kilobytes, a cycle gives up to some thousand motions
/// a pass.
pub const MAX_COMMANDS: usize = 20_000_000;

/// Numbers in a fixed order (Knuth's constants of MMIX).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize).checked_rem(n).unwrap_or(0)
    }
}

/// Small limits, so that loops end within milliseconds.
pub fn settings(dialect: Dialect) -> Settings {
    Settings {
        dialect,
        limits: Limits {
            max_call_depth: 8,
            max_loop_passes: 500,
            max_idle_passes: 100,
            max_blocks: 1_000_000,
            max_array_elements: 1000,
        },
        ..Settings::default()
    }
}

/// Runs a text: gives the number of its commands. Panics when a law is broken.
pub fn run(text: &str, dialect: Dialect) -> usize {
    let settings = settings(dialect);
    let mut commands = 0usize;
    if let Ok(program) = Program::from_text("fuzz", text, &settings) {
        for command in program {
            commands += 1;
            assert!(commands < MAX_COMMANDS, "{dialect:?} does not end:\n{text}");
            if let Err(fault) = command {
                assert!(explain(fault.code).is_some(), "{fault:?}");
                break;
            }
        }
    }
    for fault in check_text("fuzz", text, &settings) {
        assert!(explain(fault.code).is_some(), "{fault:?}");
        assert!(!fault.message.is_empty());
    }
    commands
}

/// Signs and words that reach into every reader.
const PIECES: [&str; 64] = [
    "\n",
    "\r\n",
    " ",
    "\t",
    ",",
    "/",
    "(",
    ")",
    "[",
    "]",
    "=",
    "$",
    "$$",
    "%",
    ";",
    "*",
    "#",
    "<",
    ">",
    "\"",
    "'",
    "-",
    ".",
    "+",
    "0",
    "1",
    "9999999999",
    "1e308",
    "-0",
    "0.0000001",
    "ü",
    "\u{fffd}",
    "\0",
    "X",
    "Y1",
    "Z-5",
    "G1 ",
    "G2 ",
    "G43.4 ",
    "G68.2 ",
    "G83 ",
    "M98 ",
    "O100 ",
    "N10 ",
    "IF ",
    "WHILE ",
    "END",
    "GOTO",
    "CALL ",
    "LBL 1\n",
    "Q1 ",
    "FN 9: ",
    "CYCL DEF ",
    "CIRCLE/",
    "CYCLE/",
    "MSYS/",
    "TRAORI ",
    "AROT ",
    "R1=",
    "I5 ",
    "J0 ",
    "F100 ",
    "L ",
    "CC ",
];

/// A changed seed: bytes, pieces, lines moved, doubled, taken away, numbers replaced, two seeds crossed.
pub fn mutate(seeds: &[String], random: &mut Random) -> String {
    let Some(seed) = seeds.get(random.below(seeds.len())) else { return String::new() };
    let mut bytes = seed.clone().into_bytes();
    for _ in 0..1 + random.below(6) {
        let at = random.below(bytes.len() + 1);
        match random.below(9) {
            0 => bytes.splice(at..at, PIECES[random.below(PIECES.len())].bytes()).for_each(drop),
            1 if at < bytes.len() => bytes[at] = random.below(256) as u8,
            2 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            3 => {
                let end = (at + random.below(24)).min(bytes.len());
                bytes.drain(at..end);
            }
            4 => {
                let end = (at + random.below(120)).min(bytes.len());
                let part = bytes[at..end].to_vec();
                let to = random.below(bytes.len() + 1);
                bytes.splice(to..to, part).for_each(drop);
            }
            5 => {
                let other = &seeds[random.below(seeds.len())].as_bytes();
                let from = random.below(other.len() + 1);
                let end = (from + random.below(200)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied()).for_each(drop);
            }
            6 => {
                // A number becomes another one.
                let from = (0..bytes.len()).map(|i| (at + i) % bytes.len()).find(|&i| bytes[i].is_ascii_digit());
                if let Some(from) = from {
                    let end = (from..bytes.len()).find(|&i| !bytes[i].is_ascii_digit()).unwrap_or(bytes.len());
                    let numbers =
                        ["0", "1", "2", "90", "180", "360", "0.001", "1000000", "4294967296", "99999999999999999999"];
                    bytes.splice(from..end, numbers[random.below(numbers.len())].bytes()).for_each(drop);
                }
            }
            7 => {
                let mut lines: Vec<Vec<u8>> = bytes.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
                let (a, b) = (random.below(lines.len()), random.below(lines.len()));
                lines.swap(a, b);
                bytes = lines.join(&b'\n');
            }
            _ => bytes.truncate(at),
        }
        bytes.truncate(20_000);
    }
    String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect())
}
