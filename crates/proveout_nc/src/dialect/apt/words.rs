//! What is done with each major word that is not a motion.

/// How a word is treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MajorWordClass {
    /// The reader executes it.
    Done,
    /// Reported in a note, without effect on motion, removal or time.
    Note,
    /// Refused, with the remedy.
    Refused(&'static str),
    Unknown,
}

/// Words that are executed.
pub(crate) const DONE: [&str; 43] = [
    "AUXFUN",
    "CIRCLE",
    "COOLNT",
    "CSYS",
    "CUTCOM",
    "CYCLE",
    "DELAY",
    "END",
    "FEDRAT",
    "FINI",
    "FROM",
    "GODLTA",
    "GOHOME",
    "GOTO",
    "HOME",
    "INDIRP",
    "INDIRV",
    "INSERT",
    "LOAD",
    "LOADTL",
    "MOVARC",
    "MSYS",
    "MULTAX",
    "OPSTOP",
    "ORIGIN",
    "PARTNO",
    "PPFUN",
    "PPRINT",
    "PPWORD",
    "PREFUN",
    "RAPID",
    "SELCTL",
    "SELECT",
    "SELECTL",
    "SPINDL",
    "STOP",
    "TLAXIS",
    "TLON,GOFWD",
    "TOOL PATH",
    "TRANS",
    "TRNTYP",
    "UNIT",
    "UNITS",
];

/// Words without effect on what the twin computes.
pub(crate) const NOTES: [&str; 54] = [
    "ARCSLP",
    "AUTOPS",
    "CAMERA",
    "CHECK",
    "CLAMP",
    "CLEARP",
    "CLRSRF",
    "CUTTER",
    "DISPLAY",
    "DISPLY",
    "DNTCUT",
    "END-OF-PATH",
    "HEAD",
    "INTOL",
    "ISN",
    "LEADER",
    "LETTER",
    "LIMIT",
    "LINTOL",
    "LPRINT",
    "MACHIN",
    "MAXDPM",
    "MAXVEL",
    "MODE",
    "NOPOST",
    "OFSTNO",
    "OPSKIP",
    "OPTYPE",
    "OUTOL",
    "OUTTOL",
    "PAINT",
    "PARTID",
    "PIVOTZ",
    "PLABEL",
    "PLOT",
    "PPTOL",
    "PRINT",
    "PSIS",
    "REMARK",
    "REWIND",
    "SEQNO",
    "SET",
    "SLOWDN",
    "SMOOTH",
    "SWITCH",
    "TITLES",
    "TLDATA",
    "TMARK",
    "TOLER",
    "TOOL",
    "TOOLNO",
    "TPRINT",
    "UNLOAD",
    "VERIFY",
];

const POINTS: &str = "write the path as GOTO points (linearized output of the CAM system)";
const SOURCE: &str = "this is APT source: run it through the APT processor and give its CL data";
const ROTARY: &str = "give the tool axis as a vector with GOTO, so that it holds for every machine";

/// Words that move the tool or change the meaning of coordinates in a way that the twin does not
/// follow.
pub(crate) const REFUSED: [(&str, &str); 51] = [
    ("ARCDAT", POINTS),
    ("CALL", SOURCE),
    ("CONTRL", SOURCE),
    ("COPY", SOURCE),
    ("COUPLE", "tap with CYCLE/TAP"),
    ("DEFCOPY", SOURCE),
    ("DO", SOURCE),
    ("FILLET", POINTS),
    ("GO", SOURCE),
    ("GOBACK", SOURCE),
    ("GOCLER", "write the clearance point with RAPID and GOTO"),
    ("GODOWN", SOURCE),
    ("GOFWD", SOURCE),
    ("GOLFT", SOURCE),
    ("GORGT", SOURCE),
    ("GOUP", SOURCE),
    ("GROUP", SOURCE),
    ("IF", SOURCE),
    ("INCLUD", "put the text of the file into the program"),
    ("INDEX", SOURCE),
    ("INSTOOL", "write LOADTL"),
    ("JUMPTO", SOURCE),
    ("LOOPND", SOURCE),
    ("LOOPST", SOURCE),
    ("MACRO", SOURCE),
    ("MCHFIN", ROTARY),
    ("MCHTOL", POINTS),
    ("MIRROR", "mirror the path in the CAM system"),
    ("MOVE", "write GOTO"),
    ("NURBS", POINTS),
    ("PITCH", "tap with CYCLE/TAP"),
    ("POSITN", "write the point with RAPID and GOTO"),
    ("PROBE", "remove the measuring cycle for the prove-out"),
    ("RETRCT", "write the retract point with RAPID and GOTO"),
    ("ROTABL", ROTARY),
    ("ROTATE", ROTARY),
    ("ROTHED", ROTARY),
    ("SAFPOS", "write the point with RAPID and GOTO"),
    ("SPLINE", POINTS),
    ("SYN", "write the words in full"),
    ("SYNEX", "write the words in full"),
    ("TERMAC", SOURCE),
    ("THREAD", "tap with CYCLE/TAP"),
    ("TILT", ROTARY),
    ("TLLFT", SOURCE),
    ("TLON", SOURCE),
    ("TLRGT", SOURCE),
    ("TRACUT", "output the points in one coordinate system"),
    ("TURRET", "change tools with LOADTL"),
    ("UNTIL", SOURCE),
    ("WHILE", SOURCE),
];

/// What is done with a major word.
pub(crate) fn classify(major: &str) -> MajorWordClass {
    // The words of a path come first: they make up nearly all of a file.
    if matches!(major, "GOTO" | "FEDRAT" | "RAPID") || DONE.binary_search(&major).is_ok() {
        return MajorWordClass::Done;
    }
    // CAMWorks writes lengths of the tool with words of its own: CSI_SET_FLUTE_LENGTH.
    if NOTES.binary_search(&major).is_ok() || major.starts_with("CSI_SET_") {
        return MajorWordClass::Note;
    }
    match REFUSED.binary_search_by_key(&major, |(word, _)| word) {
        Ok(at) => MajorWordClass::Refused(REFUSED[at].1),
        Err(_) => MajorWordClass::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_the_readme_is_true() {
        let readme = include_str!("../../../README.md");
        let (_, section) = readme.split_once("## Coverage: APT CL").unwrap_or_default();
        let (section, _) = section.split_once("\n## ").unwrap_or_default();
        let row = |title: &str| section.lines().find(|l| l.starts_with(&format!("| **{title}**"))).unwrap_or_default();
        let words = |text: &'static str| {
            let quoted = text.split('`').skip(1).step_by(2).filter(|q| !q.contains(['/', ':', ',']));
            quoted.flat_map(str::split_whitespace).collect::<Vec<_>>()
        };
        let noted = words(row("a note"));
        assert!(noted.len() > 15, "{noted:?}");
        for word in noted.into_iter().filter(|w| *w != "INSERT") {
            assert_eq!(classify(word), MajorWordClass::Note, "{word}");
        }
        // Words of single statements that are executed otherwise.
        let minors = [
            "INSERT", "PPWORD", "PPFUN", "CSYS", "TRNTYP", "ORIGIN", "SPINDL", "SFM", "SMM", "ORIENT", "CYCLE",
            "CSINK", "THRU", "MANUAL",
        ];
        let refused = words(row("refused by name"));
        assert!(refused.len() > 15, "{refused:?}");
        for word in refused.into_iter().filter(|w| !minors.contains(w)) {
            assert!(matches!(classify(word), MajorWordClass::Refused(_)), "{word}");
        }
        for word in [
            "GOTO", "FROM", "RAPID", "FEDRAT", "LOADTL", "SPINDL", "COOLNT", "CIRCLE", "CYCLE", "MULTAX", "UNITS",
            "PPRINT", "GODLTA",
        ] {
            assert_eq!(classify(word), MajorWordClass::Done);
            assert!(section.contains(word), "{word}");
        }
    }

    #[test]
    fn the_lists_are_sorted_and_apart() {
        let refused: Vec<&str> = REFUSED.iter().map(|(word, _)| *word).collect();
        for list in [&DONE[..], &NOTES[..], &refused[..]] {
            assert!(list.windows(2).all(|pair| pair[0] < pair[1]), "{list:?}");
        }
        assert!(NOTES.iter().all(|word| !DONE.contains(word) && !refused.contains(word)));
    }
}
