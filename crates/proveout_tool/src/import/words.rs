//! What words of the trade say about a tool: remarks of tool tables, comments of posts, in English and
//! German, and the most common ones in Polish, French, Italian and Spanish.

/// A body that stands for a tool whose kind the library lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubstituteBody {
    /// A cylinder for a tap without a pitch.
    Tap,
    /// A cylinder for a thread mill.
    ThreadMill,
    /// A cylinder for a reamer.
    Reamer,
    /// A cylinder for a boring tool.
    BoringTool,
    /// The ball of a probe.
    Probe,
    /// A disk for a slot mill.
    SlotMill,
}

impl SubstituteBody {
    /// Why the body is taken, for the tool file.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Tap => "a tap: a cylinder of its diameter is its envelope",
            Self::ThreadMill => "a thread mill: a cylinder of its diameter is its envelope",
            Self::Reamer => "a reamer: a cylinder of its diameter is its envelope",
            Self::BoringTool => "a boring tool: a cylinder of its diameter is its envelope",
            Self::Probe => "a probe: its ball",
            Self::SlotMill => "a slot mill: a disk of its flute length",
        }
    }

    /// Whether it is a tool for threads.
    pub fn cuts_threads(self) -> bool {
        matches!(self, Self::Tap | Self::ThreadMill)
    }
}

/// Kind of the library and the words that mean it, in search order: `ball nose end mill` is a ball,
/// `spot drill` is not a drill. The last member says where this kind replaces one that the library
/// lacks.
const KINDS: [(&[&str], &str, Option<SubstituteBody>); 17] = [
    (&["lollipop", "undercut ball"], "lollipop", None),
    (&["taper ball", "tapered ball", "conical ball", "tapered spherical", "tapered ballnosed"], "taper_ball", None),
    (&["ball", "kugel", "sphere", "spherical", "kulist", "spheriq", "hemispher", "sferic", "esferic"], "ball", None),
    (
        &["bull", "torus", "radius end", "toroid", "corner radius", "rundplatten", "tipradius", "tip radius"],
        "bull_nose",
        None,
    ),
    (&["spot", "center drill", "centre drill", "nc-anbohrer", "anbohrer", "zentrier", "nawiertak"], "chamfer", None),
    (
        &[
            "chamfer",
            "countersink",
            "counter sink",
            "v-bit",
            "vbit",
            "engrav",
            "fase",
            "senker",
            "deburr",
            "fazownik",
            "grawer",
            "svasatore",
            "avellanador",
        ],
        "chamfer",
        None,
    ),
    (
        &["face mill", "facemill", "shell mill", "facing", "planfr", "messerkopf", "glowica", "g\u{142}owica"],
        "face_mill",
        None,
    ),
    (&["thread mill", "gewindefr"], "flat", Some(SubstituteBody::ThreadMill)),
    (&["tap drill", "tapping drill"], "drill", None),
    // What British shops call an end mill that cuts to its center.
    (&["slot drill", "slotdrill"], "flat", None),
    (&["tap", "gewindeb", "gewinde m", "gwintownik", "taraud", "maschio", "macho"], "tap", Some(SubstituteBody::Tap)),
    (
        &["ream", "reib", "rozwiertak", "alesoir", "al\u{e9}soir", "alesatore", "escariador"],
        "flat",
        Some(SubstituteBody::Reamer),
    ),
    (&["boring", "bore", "ausdreh"], "flat", Some(SubstituteBody::BoringTool)),
    (&["drill", "bohrer", "wiertlo", "wiert\u{142}o", "foret", "broca", "punta"], "drill", None),
    (&["probe", "taster"], "ball", Some(SubstituteBody::Probe)),
    (&["slot", "saw", "nut"], "flat", Some(SubstituteBody::SlotMill)),
    (
        &[
            "flat",
            "end mill",
            "endmill",
            "em",
            "square",
            "schaftfr",
            "mill",
            "schrupp",
            "fr\u{e4}ser",
            "fraeser",
            "frez",
            "fraise",
            "fresa",
        ],
        "flat",
        None,
    ),
];

/// Kind of a tool by the words of a text, and what it stands for where it replaces one that the library
/// lacks.
pub fn kind_of(text: &str) -> Option<(&'static str, Option<SubstituteBody>)> {
    let text = text.to_lowercase().replace('_', " ");
    let has = |word: &&str| {
        text.match_indices(*word).any(|(at, _)| {
            let begins = !text[..at].chars().next_back().is_some_and(char::is_alphabetic) || word.len() > 5;
            let rest = &text[at + word.len()..];
            // `TAPER` is no tap, `EMULSION` no end mill.
            let ends = match *word {
                "tap" => !rest.starts_with("er"),
                "em" => !rest.starts_with(char::is_alphabetic),
                _ => true,
            };
            begins && ends
        })
    };
    KINDS.iter().find(|(words, ..)| words.iter().any(&has)).map(|&(_, kind, substitute)| (kind, substitute))
}

/// Words of tools whose edges do not reach their center, and of those whose edges do; a slot drill is an end
/// mill that cuts to its center.
const NOT_TO_CENTER: [&str; 5] =
    ["non center cut", "non centre cut", "noncenter cut", "not center cut", "ohne zentrumschnitt"];
const TO_CENTER: [&str; 7] =
    ["center cut", "centre cut", "centercut", "slot drill", "slotdrill", "zentrumschnitt", "zentrumsschneid"];

/// Whether the edges of a tool reach the center of its end, where the words say it.
pub fn center_cutting_of(text: &str) -> Option<bool> {
    let text = text.to_lowercase().replace(['-', '_'], " ");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let has = |words: &[&str]| words.iter().any(|w| text.contains(w));
    if has(&NOT_TO_CENTER) { Some(false) } else { has(&TO_CENTER).then_some(true) }
}

/// Teeth: `4FL`, `3 FLUTES`, `4Z`.
pub fn flutes_of(text: &str) -> Option<u32> {
    let upper = text.to_uppercase();
    let words: Vec<&str> = upper
        .split(|c: char| c.is_whitespace() || matches!(c, ',' | '-' | '(' | ')' | ';'))
        .filter(|w| !w.is_empty())
        .collect();
    let count = |w: &str| w.parse::<u32>().ok().filter(|n| (1..=40).contains(n));
    for (i, word) in words.iter().enumerate() {
        let unit = word.trim_start_matches(|c: char| c.is_ascii_digit());
        // `4Z` is the count of teeth, a Z alone the axis.
        if matches!(unit, "FL" | "FLT" | "FLUTE" | "FLUTES") || unit == "Z" && unit.len() < word.len() {
            let digits = &word[..word.len() - unit.len()];
            return count(digits).or_else(|| count(words.get(i.checked_sub(1)?)?));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_trade_have_their_kinds() {
        for (text, kind) in [
            ("flat end mill", Some("flat")),
            ("1/2 BALL NOSE END MILL", Some("ball")),
            ("bull nose end mill", Some("bull_nose")),
            ("SPOT DRILL 90", Some("chamfer")),
            ("10.5 DRILL", Some("drill")),
            ("spiralbohrer d=8", Some("drill")),
            ("Schaftfraeser D12", Some("flat")),
            ("Kugelfraeser", Some("ball")),
            ("FACE MILL 50MM", Some("face_mill")),
            ("M8 TAP", Some("tap")),
            ("1/2 EM CRB 4FL", Some("flat")),
            ("EMULSION ON", None),
            ("8MM SLOT DRILL", Some("flat")),
            ("GEWINDE_M8", Some("tap")),
            ("5 MM TAP DRILL", Some("drill")),
            ("FREZ TRZPIENIOWY", Some("flat")),
            ("TAPER=118DEG - ZMIN=-0.7 - DRILL", Some("drill")),
            ("something else", None),
            ("", None),
        ] {
            assert_eq!(kind_of(text).map(|(kind, _)| kind), kind, "{text}");
        }
        assert!(kind_of("tap right hand").and_then(|(_, why)| why).is_some());
    }

    #[test]
    fn edges_at_the_center_are_reported_or_not_known() {
        for (text, wanted) in [
            ("8MM SLOT DRILL", Some(true)),
            ("end mill, center-cutting", Some(true)),
            ("Square end mill CENTRE CUTTING 4FL", Some(true)),
            ("VHM-Fraeser mit Zentrumschnitt", Some(true)),
            ("non-center cutting", Some(false)),
            ("Non Centre-Cutting roughing head", Some(false)),
            ("Fraeser ohne Zentrumschnitt", Some(false)),
            ("CENTER DRILL", None),
            ("slot mill 20x3", None),
            ("flat end mill", None),
        ] {
            assert_eq!(center_cutting_of(text), wanted, "{text}");
        }
    }

    #[test]
    fn teeth_are_counted_where_they_are_given() {
        assert_eq!(flutes_of("1/2 4FL END MILL"), Some(4));
        assert_eq!(flutes_of("3 flute, 12 mm"), Some(3));
        assert_eq!(flutes_of("FLAT END MILL"), None);
        assert_eq!((flutes_of("FREZ FI16 4Z"), flutes_of("TOOL CALL 5 Z")), (Some(4), None));
        assert_eq!(flutes_of("99999999999 FL"), None);
    }
}
