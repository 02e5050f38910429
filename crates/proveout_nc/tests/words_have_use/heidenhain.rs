//! Klartext and DIN/ISO of a TNC.

use proveout_nc::{Dialect, Settings};

use super::{Family, behind, no_word_is_dropped};

const BEFORE: &str = "0 BEGIN PGM T MM
1 TOOL CALL 1 Z S1000 F300
2 L X+0 Y+0 Z+10 R0 FMAX M3
3 CC X+10 Y+0
4 L X-5 Y+0 F200
5 L X+0 Y+0
";
const BEHIND: &str = "89 L X+33 Y+44 F222
90 L Z+11
91 CC X+35 Y+45
92 CP IPA+30 DR+
93 L IX+1 IY+1 IZ+1
99 END PGM T MM
";
const BLOCKS: [&str; 47] = [
    "L X+5 Y+1",
    "L X+5 Y+1 FMAX",
    "L Z-5 M91 FMAX",
    "LN X+5 Y+5 Z+5 NX+0 NY+0 NZ+1",
    "CC X+4 Y+3",
    "C X+20 Y+0 DR+",
    "CR X+10 Y+10 R+10 DR-",
    "CT X+5 Y+5",
    "LP PR+5 PA+30",
    "CP IPA+90 DR+",
    "CTP PR+5 PA+60",
    "RND R1",
    "CHF 1",
    "APPR LT X+20 Y+5 LEN2 RL",
    "M5",
    "STOP",
    "TOOL CALL 2 Z S500",
    "TOOL DEF 3",
    "TRANS DATUM AXIS X+5",
    "TRANS MIRROR AXIS X",
    "TRANS ROTATION ROT+10",
    "TRANS SCALE SCL1.5",
    "PLANE SPATIAL SPA+10 SPB+0 SPC+0 STAY",
    "PLANE EULER EULPR+5 EULNU+10 EULROT+0 STAY",
    "PLANE VECTOR BX+1 BY+0 BZ+0 NX+0 NY+0 NZ+1 STAY",
    "PLANE PROJECTED PROPR+10 PROMIN+5 STAY",
    "PLANE RELATIVE SPA+10 STAY",
    "PLANE AXIAL B+10 STAY",
    "PLANE RESET STAY",
    "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS",
    "FUNCTION RESET TCPM",
    "CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X+5",
    "CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X",
    "CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL 0.5",
    "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+10",
    "CYCL DEF 11.0 SCALE\nCYCL DEF 11.1 SCL 1.5",
    "CYCL DEF 26.0 SCALE\nCYCL DEF 26.1 X1.5 Y1.5 Z1.5",
    "CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.02",
    "CYCL DEF 19.0 PLANE\nCYCL DEF 19.1 A+10",
    "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0\nCYCL CALL M8",
    "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0\nCYCL CALL POS X+1 Y+2 Z+0",
    "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0\nPATTERN DEF POS1 (X+1 Y+2 Z+0)\nCYCL CALL PAT F500",
    "LBL 5",
    "LBL 7\nL IX+1\nLBL 0\nCALL LBL 7",
    "Q1 = 5",
    "FN 0: Q1 = +5",
    "CALL LBL 8 REP 1\nLBL 8\nCALL LBL 8 REP 1",
];
const WORDS: [&str; 47] = [
    "X+7", "Y+7", "Z+7", "A+7", "B+7", "C+7", "U+7", "IX+7", "IZ+7", "IB+7", "PR+7", "PA+7", "IPR+7", "IPA+7", "DR-",
    "DR+", "F77", "FMAX", "FAUTO", "RL", "RR", "R7", "R+7", "M8", "M91", "M99", "M128", "LEN7", "CCA45", "NX+0.6",
    "TX+0.6", "SPA+7", "SPB+7", "EULPR+7", "EULROT+7", "ROT+7", "BX+7", "MOVE", "TURN", "MB7", "DIST7", "SEQ-", "S777",
    "DL+0.7", "DR2+0.7", "REP2", "T0.07",
];

/// Words in force already, and those that repeat what the block says.
fn nothing_new(block: &str, word: &str) -> bool {
    let path = block.lines().last().unwrap_or_default();
    // Rapid traverse that a block without a path has no use for is reported once, with the block that has it.
    let twice = path.split_whitespace().any(|own| own == word);
    // A feed next to the words of a block that brings its own; FAUTO is the feed of TOOL CALL, which holds
    // where none follows.
    twice || word == "R0" || word == "FAUTO" && path.starts_with("CYCL CALL")
}

#[test]
fn no_word_of_klartext_is_dropped() {
    let settings = Settings { dialect: Dialect::Heidenhain, ..Settings::default() };
    no_word_is_dropped(&[Family {
        name: "klartext",
        settings,
        before: BEFORE,
        blocks: &BLOCKS[..46],
        words: &WORDS,
        behind: BEHIND,
        put: behind,
        says_nothing_new: nothing_new,
    }]);
}

const DIN_BEFORE: &str = "%T G71 *
N10 T1 G17 S1000 *
N20 G00 G40 G90 X+0 Y+0 Z+10 M3 *
N30 G01 X-5 Y+0 F200 *
N40 I+10 J+0 *
N50 G01 X+0 Y+0 *
";
const DIN_BEHIND: &str = "N900 X+10 Y-10 *
N905 G01 X+33 Y+44 Z+11 F222 *
N910 G13 H+30 *
N920 I+2 J+1 *
N925 G13 H+60 *
N930 G91 G01 X+1 Y+1 Z+1 *
N999999 %T G71 *
";
/// Path functions of polar coordinates, which stay in force: a block after them names its own.
const DIN_POLAR: [&str; 3] = ["G11 R+5 H+30", "G13 H+90", "G16 R+5 H+60"];
const DIN_BLOCKS: [&str; 25] = [
    "G01 X+5 Y+1",
    "G00 X+5 Y+1",
    "G02 X+20 Y+0",
    "G03 X+10 Y+10 R+10",
    "G06 X+5 Y+5",
    "G25 R1",
    "G24 R1",
    "I+4 J+3",
    "G29",
    "M5",
    "G38",
    "T2 G17 S500",
    "T2 G17 S500 M3",
    "G99 T3",
    "G54 X+5",
    "G28 X",
    "G73 H+10",
    "G72 F1.5",
    "G04 F0.5",
    "G62 T0.02",
    "G80 A+10",
    "G98 L5",
    "D00 Q1 P01 +5",
    "D01 Q1 P01 +5 P02 +3",
    "G91",
];
const DIN_WORDS: [&str; 33] = [
    "X+7",
    "Y+7",
    "Z+7",
    "A+7",
    "U+7",
    "I+7",
    "J+7",
    "K+7",
    "R+7",
    "H+7",
    "F77",
    "S777",
    "T7",
    "L5",
    "M8",
    "M99",
    "G41",
    "G90",
    "G91",
    "G17",
    "G29",
    "G70",
    "G50",
    "G36",
    "G79",
    "G04",
    "P01 +7",
    "P02 +7",
    "DL+0.7",
    "Q7=7",
    "D00 Q2 P01 +7",
    "G00",
    "%OTHER",
];

fn nothing_new_in_din(block: &str, word: &str) -> bool {
    let own = |w: &str| block.split_whitespace().any(|own| own == w);
    // G90 is in force, a path function that is in force is written again, and G17 is the plane.
    own(word) || word == "G17" || word == "G90" && block != "G91"
}

#[test]
fn no_word_of_din_iso_is_dropped() {
    let cartesian = DIN_BEHIND.replacen("N900 ", "N900 G01 ", 1);
    let family = |blocks, behind_the_block| Family {
        name: "din/iso",
        settings: Settings { dialect: Dialect::HeidenhainIso, ..Settings::default() },
        before: DIN_BEFORE,
        blocks,
        words: &DIN_WORDS,
        behind: behind_the_block,
        put: behind,
        says_nothing_new: nothing_new_in_din,
    };
    no_word_is_dropped(&[family(&DIN_BLOCKS[..], DIN_BEHIND), family(&DIN_POLAR[..], cartesian.as_str())]);
}
