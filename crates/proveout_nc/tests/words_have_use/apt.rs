//! APT CL data.

use proveout_nc::{Dialect, Settings};

use super::{Family, no_word_is_dropped};

const BEFORE: &str = "PARTNO/T
UNITS/MM
LOADTL/1
SPINDL/1000,RPM,CLW
RAPID
GOTO/0,0,10
FEDRAT/200,MMPM
GOTO/-5,0,10
GOTO/0,0,10
";
const BEHIND: &str = "GOTO/33,44,10
CYCLE/DRILL,DEPTH,5,MMPM,50,CLEAR,2
GOTO/1,2,3
CYCLE/OFF
GODLTA/1,1,1
FINI
";
const BLOCKS: [&str; 30] = [
    "GOTO/5,1,10",
    "GODLTA/1,2,3",
    "FROM/5,1,10",
    "GOHOME",
    "RAPID",
    "FEDRAT/77,MMPM",
    "SPINDL/500,RPM,CLW",
    "SPINDL/OFF",
    "COOLNT/ON",
    "LOADTL/2",
    "SELCTL/2",
    "DELAY/2",
    "STOP",
    "OPSTOP",
    "CUTCOM/LEFT",
    "MULTAX/ON",
    "TLAXIS/0,0.6,0.8",
    "UNITS/INCHES",
    "TRANS/1,2,3",
    "ORIGIN/0,0,0",
    "MSYS/0,0,0,1,0,0,0,1,0",
    "CIRCLE/5,0,10,0,0,1,5\nGOTO/10,0,10",
    "MOVARC/5,0,10,0,0,1,5,ANGLE,180\nGOTO/10,0,10",
    "CYCLE/DRILL,DEPTH,5,MMPM,100,CLEAR,3\nGOTO/5,5,0",
    "CYCLE/DEEP,DEPTH,5,INCR,2,MMPM,100,CLEAR,3\nGOTO/5,5,0",
    "CYCLE/TAP,DEPTH,5,PITCH,1,CLEAR,3\nGOTO/5,5,0",
    "CYCLE/OFF",
    "AUXFUN/8",
    "PREFUN/55",
    "PPRINT/A",
];
const WORDS: [&str; 24] = [
    "7",
    "0.5",
    "FOO",
    "LEFT",
    "MMPM",
    "IPM",
    "RPM",
    "CCLW",
    "OFF",
    "ON",
    "MAXRPM",
    "REV",
    "RANGE",
    "FLOOD",
    "XYPLAN",
    "ADJUST",
    "LENGTH",
    "STEP,1",
    "PITCH,2",
    "DWELL,3",
    "SUBPECK,1",
    "RAPTO,4",
    "RTRCTO,9",
    "TIMES,2",
];

/// An item after the others of the first line.
fn put(block: &str, word: &str) -> String {
    let (first, rest) = block.split_once('\n').map_or((block, ""), |(first, rest)| (first, rest));
    let sign = if first.contains('/') { ',' } else { '/' };
    format!("{first}{sign}{word}\n{rest}")
}

fn nothing_new(block: &str, word: &str) -> bool {
    // Words that say what holds: the spindle counts in revolutions a minute, coolant ON is flood, a tool has
    // its own offset.
    let first = block.lines().next().unwrap_or_default();
    first.contains(word)
        || matches!(
            (first.split('/').next(), word),
            (Some("SPINDL"), "RPM" | "OFF" | "ON") | (Some("COOLNT"), "ON" | "FLOOD")
        )
        || first.starts_with("CUTCOM") && word == "XYPLAN"
}

#[test]
fn no_word_of_cl_data_is_dropped() {
    let settings = Settings { dialect: Dialect::Apt, ..Settings::default() };
    no_word_is_dropped(&[Family {
        name: "apt",
        settings,
        before: BEFORE,
        blocks: &BLOCKS,
        words: &WORDS,
        behind: BEHIND,
        put,
        says_nothing_new: nothing_new,
    }]);
}
