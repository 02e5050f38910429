//! The controls that speak ISO 6983, and how a text is assigned to one of them.

use crate::g_code::*;
use crate::settings::Dialect;
use crate::source::{Mark, Source};

/// A control of the ISO family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flavor {
    /// Fanuc Series 30i/31i/0i, macro B.
    Fanuc,
    /// Haas NGC.
    Haas,
    /// `LinuxCNC`, RS274/NGC.
    LinuxCnc,
}

impl Flavor {
    /// Name for messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Fanuc => "Fanuc",
            Self::Haas => "Haas",
            Self::LinuxCnc => "LinuxCNC",
        }
    }

    pub(crate) fn is_linuxcnc(self) -> bool {
        self == Self::LinuxCnc
    }
}

/// A flavor, and whether something in the call or the text says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FlavorChoice {
    pub(crate) flavor: Flavor,
    pub(crate) certain: bool,
}

/// Bytes of the text that are looked at for words of one control only.
const LOOKED_AT: usize = 4 << 20;

/// The flavor of a dialect; for [`Dialect::Iso`] the first word that only one control knows
/// decides, Fanuc where there is none.
pub(crate) fn tell(dialect: Dialect, source: &Source) -> FlavorChoice {
    match dialect {
        Dialect::Haas => FlavorChoice { flavor: Flavor::Haas, certain: true },
        Dialect::LinuxCnc => FlavorChoice { flavor: Flavor::LinuxCnc, certain: true },
        Dialect::Fanuc => FlavorChoice { flavor: Flavor::Fanuc, certain: true },
        _ => {
            if source.name.to_ascii_lowercase().ends_with(".ngc") {
                return FlavorChoice { flavor: Flavor::LinuxCnc, certain: true };
            }
            match from_text(source) {
                Some(flavor) => FlavorChoice { flavor, certain: true },
                None => FlavorChoice { flavor: Flavor::Fanuc, certain: false },
            }
        }
    }
}

fn from_text(source: &Source) -> Option<Flavor> {
    let mut at = Mark::START;
    while let Some((line, next)) = source.line(at) {
        if at.offset > LOOKED_AT {
            break;
        }
        if let Some(flavor) = from_line(line.as_bytes()) {
            return Some(flavor);
        }
        at = next;
    }
    None
}

/// Marks of one line outside of its comments.
fn from_line(line: &[u8]) -> Option<Flavor> {
    let mut at = 0;
    let (mut g64, mut p_word, mut g5, mut q_word) = (false, None, false, false);
    // G70 and G71 with a radius and a number of holes.
    let (mut bolt, mut i_word, mut l_word) = (false, false, false);
    let first = line.iter().position(|b| !b.is_ascii_whitespace())?;
    while let Some(&byte) = line.get(at) {
        match byte.to_ascii_uppercase() {
            b'(' => at += line.get(at..)?.iter().position(|&b| b == b')').unwrap_or(line.len()),
            b';' => break,
            b'#' if line.get(at + 1) == Some(&b'<') => return Some(Flavor::LinuxCnc),
            b'O' if at == first && is_o_word(line.get(at + 1..)?) => return Some(Flavor::LinuxCnc),
            b'O' if at == first && is_named_head(line.get(at + 1..)?) => return Some(Flavor::Haas),
            letter @ (b'G' | b'M') => {
                let (number, length) = number(line.get(at + 1..)?);
                if let Some((code, tenth)) = number {
                    match letter {
                        b'G' => match g_mark(GCode(code, tenth)) {
                            Some(flavor) => return Some(flavor),
                            None if GCode(code, tenth) == G64 => g64 = true,
                            None if matches!(GCode(code, tenth), G5 | G5_1) => g5 = true,
                            None if matches!(GCode(code, tenth), G70 | G71) => bolt = true,
                            None => {}
                        },
                        _ if (code, tenth) == (97, 0) => return Some(Flavor::Haas),
                        _ if (code, tenth) == (29, 0) => return Some(Flavor::Fanuc),
                        _ => {}
                    }
                }
                at += length;
            }
            b'P' => p_word = Some(number(line.get(at + 1..)?).0.map_or(0, |(whole, _)| whole)),
            b'Q' => q_word = true,
            b'I' => i_word = true,
            b'L' => l_word = true,
            _ => {}
        }
        at += 1;
    }
    if bolt && i_word && l_word {
        return Some(Flavor::Haas);
    }
    if g64 && p_word.is_some() {
        return Some(Flavor::LinuxCnc);
    }
    let high_speed = p_word.is_some_and(|p| p >= 1000);
    (g5 && (high_speed || q_word && p_word.is_none())).then_some(Flavor::Fanuc)
}

/// `100 sub`, `<name> call`, `[#1] while`: a label followed by a word.
fn is_o_word(rest: &[u8]) -> bool {
    let rest = String::from_utf8_lossy(rest).to_ascii_uppercase();
    let rest = rest.trim_start();
    if rest.starts_with('<') {
        return true;
    }
    let tail = rest.trim_start_matches(|c: char| c.is_ascii_digit() || c.is_whitespace());
    const WORDS: [&str; 12] =
        ["SUB", "ENDSUB", "CALL", "IF", "ELSE", "ENDIF", "WHILE", "ENDWHILE", "DO", "REPEAT", "ENDREPEAT", "RETURN"];
    tail.len() < rest.len() && WORDS.iter().any(|word| tail.starts_with(word))
}

/// The head of a program with a name of letters, followed by nothing but a comment.
fn is_named_head(rest: &[u8]) -> bool {
    let name = rest.iter().take_while(|b| b.is_ascii_alphanumeric() || b"_-.".contains(b)).count();
    let behind = rest.get(name..).unwrap_or_default().trim_ascii_start();
    rest.first().is_some_and(u8::is_ascii_alphabetic) && matches!(behind.first(), None | Some(b'(' | b';'))
}

/// The number after a letter, whole and tenths, and how many bytes it takes.
fn number(rest: &[u8]) -> (Option<(u32, u8)>, usize) {
    let blanks = rest.iter().take_while(|b| **b == b' ').count();
    let (mut value, mut digits, mut at) = (0u32, 0, blanks);
    while let Some(digit) = rest.get(at).filter(|b| b.is_ascii_digit()) {
        value = value.saturating_mul(10).saturating_add(u32::from(digit - b'0'));
        digits += 1;
        at += 1;
    }
    let mut tenth = 0;
    if rest.get(at) == Some(&b'.')
        && let Some(digit) = rest.get(at + 1).filter(|b| b.is_ascii_digit())
    {
        tenth = digit - b'0';
        at += 2;
    }
    ((digits > 0).then_some((value, tenth)), at)
}

/// G words that one control only knows.
fn g_mark(code: GCode) -> Option<Flavor> {
    Some(match code {
        G5_2 | G5_3 | G33_1 | GCode(38, 2..=5) | GCode(59, 1..=3) | G90_1 | G91_1 | G92_2 | G92_3 => Flavor::LinuxCnc,
        G103 | GCode(110..=129, 0) => Flavor::Haas,
        G154 | G187 | G234 | G253 | G254 | G255 | G268 | G269 => Flavor::Haas,
        G43_4 | G43_5 | G50_1 | G51_1 | G53_1 | G53_6 | G54_1 | G66 | G67 | GCode(68, 2..=4) => Flavor::Fanuc,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flavor(text: &str) -> FlavorChoice {
        tell(Dialect::Iso, &Source::new("a.nc", text.to_owned()))
    }

    #[test]
    fn words_of_one_control_tell_it() {
        for (text, want) in [
            ("G0 X0\no100 sub\n", Flavor::LinuxCnc),
            ("#<depth> = 5\n", Flavor::LinuxCnc),
            ("G21 G64 P0.01\n", Flavor::LinuxCnc),
            ("O<bore> CALL [1]\n", Flavor::LinuxCnc),
            ("G0 G154 P3 X0\n", Flavor::Haas),
            ("M97 P100\n", Flavor::Haas),
            ("%\nOPART-7 (BASE)\nG0 X0\n", Flavor::Haas),
            ("g254\n", Flavor::Haas),
            ("G71 I5. J15. K10. L3\n", Flavor::Haas),
            ("G68.2 X0 Y0 Z0 I0 J45. K0\n", Flavor::Fanuc),
            ("G05.1 Q1\n", Flavor::Fanuc),
            ("G05 P10000\n", Flavor::Fanuc),
            ("G43.4 H1\n", Flavor::Fanuc),
        ] {
            assert_eq!(flavor(text), FlavorChoice { flavor: want, certain: true }, "{text}");
        }
    }

    #[test]
    fn a_text_that_all_controls_read_is_fanuc_without_certainty() {
        let text = "OF THIS PART 3\n%\nO1000 (G154 G254 o100 sub)\nG0 G64 X0\nG1 X1 F100 ; G234\nO2000\nM30\n";
        assert_eq!(flavor(text), FlavorChoice { flavor: Flavor::Fanuc, certain: false });
    }
}
