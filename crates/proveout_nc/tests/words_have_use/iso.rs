//! ISO code: Fanuc, Haas, Mazak, Okuma.

use proveout_nc::{Control, Dialect, Settings};

use super::{Family, behind, no_word_is_dropped};

const BEFORE: &str = "G17 G90 G94 G40 G49 G80
T1 M6
D1 S1000 M3
G43 H1 G0 X0. Y0. Z10.
G1 X-5. F200.
X0.
";
const BEHIND: &str = "G1 X33. Y44. Z11. F222.
X34. Y50.
G41 X36. Y51.
G40 X37.
G91 X1. Y1. Z1.
M30
";
/// Blocks of every control here.
const COMMON: [&str; 29] = [
    "G1 X5. Y1.",
    "G0 X5. Y1.",
    "G2 X10. Y0. I5. J0.",
    "G3 X10. Y0. R8.",
    "G4 P500",
    "G28 Z0.",
    "G30 Z0.",
    "G53 G0 Z100.",
    "G54",
    "G55",
    "G41 D1",
    "G40",
    "G43 H2",
    "G49",
    "G52 X5.",
    "G92 X5.",
    "G81 X5. Y5. Z-5. R2. F100.",
    "G82 X5. Y5. Z-5. R2. P100 F100.",
    "G83 X5. Y5. Z-5. R2. Q2. F100.",
    "G73 X5. Y5. Z-9. R2. Q2. F100.",
    "G85 X5. Y5. Z-5. R2. F100.",
    "G80",
    "G17",
    "G61",
    "G64",
    "M5",
    "M0",
    "T2",
    "F77.",
];
const OF_FANUC: [&str; 8] = [
    "G68 X1. Y1. R10.",
    "G69",
    "G68.2 X0. Y0. Z0. I10. J0. K0.",
    "G54.1 P1",
    "G10 L2 P1 X5.",
    "G51.1 X5.",
    "G31 Z5. F100.",
    "G33 Z5. F1.",
];
const OF_HAAS: [&str; 6] =
    ["G68 X1. Y1. R10.", "G69", "G268 X1. Y0. Z0. I10. J0. K0.", "G154 P1", "G10 L2 P1 X5.", "G101 X5."];
/// Every letter, and what has more than one.
const WORDS: [&str; 30] = [
    "A7.", "B7.", "C7.", "D7", "E7.", "F79.", "H7", "I7.", "J7.", "K7", "L7", "M8", "O7", "P7", "Q7.", "R7.", "S777",
    "T7", "U7.", "V7.", "W7.", "X7.", "Y7.", "Z7.", ",R1.", ",C1.", "G91", "G9", "G60", "@7.",
];

fn nothing_new(block: &str, word: &str) -> bool {
    let letter = |text: &str| text.chars().next().unwrap_or(' ');
    // A second word of a letter is another case: it is refused.
    let twice =
        block.split_whitespace().any(|own| letter(own) == letter(word) && letter(own) != 'G' && letter(own) != 'M');
    // An exact stop in a block without a motion has none to act on; D in force counts with G41 and G42 alone.
    let stops = matches!(word, "G9" | "G60");
    twice || stops || word.starts_with('D') && block == "G40"
}

fn family<'a>(name: &'a str, control: &str, blocks: &'a [&'a str]) -> Family<'a> {
    let settings = Settings::of_control(Control::find(control, None).unwrap());
    Family {
        name,
        settings,
        before: BEFORE,
        blocks,
        words: &WORDS,
        behind: BEHIND,
        put: behind,
        says_nothing_new: nothing_new,
    }
}

#[test]
fn no_word_of_a_fanuc_a_haas_or_a_mazak_is_dropped() {
    let fanuc = [&COMMON[..], &OF_FANUC].concat();
    let haas = [&COMMON[..], &OF_HAAS].concat();
    no_word_is_dropped(&[
        family("fanuc-30i", "fanuc-30i", &fanuc),
        family("haas-ngc", "haas-ngc", &haas),
        family("mazak-eia", "mazak-eia", &fanuc),
    ]);
}

#[test]
fn no_word_of_the_plain_iso_readers_is_dropped() {
    let plain = |name, dialect| Family {
        settings: Settings { dialect, ..Settings::default() },
        ..family(name, "fanuc-30i", &COMMON)
    };
    no_word_is_dropped(&[plain("fanuc", Dialect::Fanuc), plain("haas", Dialect::Haas)]);
}

const OKUMA_BEFORE: &str = "G15 H1
G90 G17 G40 G80
T1 M6
D1 S1000 M3
G56 H1 G0 X0 Y0 Z10
G1 X-5 F200
X0
";
const OKUMA_BLOCKS: [&str; 12] = [
    "G1 X5 Y1",
    "G0 X5 Y1",
    "G2 X10 Y0 I5 J0",
    "G4 F2",
    "G15 H2",
    "G56 H2",
    "G41 D1",
    "G40",
    "M5",
    "T2",
    "F77",
    "VC1=5",
];

#[test]
fn no_word_of_an_okuma_is_dropped() {
    let okuma = Family { before: OKUMA_BEFORE, ..family("okuma-osp", "okuma-osp", &OKUMA_BLOCKS) };
    no_word_is_dropped(&[okuma]);
}
