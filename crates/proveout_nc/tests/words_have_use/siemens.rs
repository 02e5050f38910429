//! Sinumerik 840D.

use proveout_nc::{Dialect, Settings};

use super::{Family, behind, no_word_is_dropped};

const BEFORE: &str = "G17 G54 G90 G710 G94
T1 D1
M6
S1000 M3
G0 X0 Y0 Z10
G1 X-5 F200
X0
";
const BEHIND: &str = "G1 X33 Y44 Z11 F222
X34 Y50
AP=30 RP=60
G91 X1 Y1 Z1
M30
";
const BLOCKS: [&str; 44] = [
    "G1 X5 Y1",
    "G0 X5 Y1",
    "G2 X10 Y0 I5 J0",
    "G3 X10 Y0 CR=8",
    "G2 X10 Y0 AR=120",
    "G2 I5 J0 AR=120",
    "CIP X10 Y0 I1=5 J1=5",
    "CT X5 Y5",
    "G33 Z-5 K1",
    "G331 Z-5 K1",
    "G332 Z5 K1",
    "G0 SUPA Z100",
    "G4 F2",
    "G4 S3",
    "TRANS X10",
    "ATRANS Y10",
    "ROT Z10",
    "ROT RPL=10",
    "SCALE X1.5",
    "MIRROR X0",
    "G58 X10",
    "G111 X3 Y4",
    "G111 AP=10 RP=20",
    "G1 AP=20 RP=10",
    "G25 X10",
    "G26 S2000",
    "G74 Z1=0",
    "G75 X1=0",
    "POS[X]=5",
    "CYCLE81(20,0,2,-5)",
    "MCALL CYCLE81(20,0,2,-5)",
    "CYCLE832(0.02,1,1)",
    "T2",
    "D2",
    "M5",
    "F77",
    "TRAORI",
    "TRAFOOF",
    "R1=5",
    "G55",
    "G41",
    "G641 ADIS=0.5",
    "MSG(\"A\")",
    "CFC",
];
const WORDS: [&str; 49] = [
    "X7",
    "Y7",
    "Z7",
    "A7",
    "B7",
    "C7",
    "U7",
    "I7",
    "J7",
    "K7",
    "I=AC(7)",
    "CR=7",
    "MEAS=1",
    "AR=77",
    "TURN=1",
    "RPL=7",
    "ANG=7",
    "CHF=1",
    "CHR=1",
    "RND=1",
    "FRC=77",
    "FB=78",
    "F79",
    "S777",
    "T7",
    "D3",
    "M8",
    "H7",
    "P3",
    "L7",
    "I1=7",
    "J1=7",
    "A3=0.6",
    "C2=7",
    "AP=7",
    "RP=7",
    "PW=2",
    "PL=2",
    "PO[X]=(7,1)",
    "FP=2",
    "X1=7",
    "S2=7",
    "OVR=50",
    "G91",
    "G60",
    "SUPA",
    "SPOS=7",
    "TRANS",
    "POS[Y]=7",
];

fn nothing_new(block: &str, word: &str) -> bool {
    // G55 and the others end no motion, so that SUPA next to them has none to act on.
    let still = |block: &str| !block.contains(['X', 'Y', 'Z']) || block.starts_with(['C', 'M']);
    word == "SUPA" && (still(block) || block.contains("SUPA"))
}

#[test]
fn no_word_of_a_sinumerik_is_dropped() {
    let settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
    no_word_is_dropped(&[Family {
        name: "siemens",
        settings,
        before: BEFORE,
        blocks: &BLOCKS,
        words: &WORDS,
        behind: BEHIND,
        put: behind,
        says_nothing_new: nothing_new,
    }]);
}
