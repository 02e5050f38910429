//! G words by their number.

use std::fmt;
use std::str::FromStr;

/// A G word: its number and its tenth. `GCode(68, 2)` is G68.2, and `GCode(81..=89, 0)` a pattern for G81 to
/// G89.
///
/// The words of the readers have constants, which are patterns too: [`G68_2`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct GCode(pub(crate) u32, pub(crate) u8);

/// Most digits of the number of a word in a control file.
const MOST_DIGITS: usize = 3;
/// Ten times the number of the highest word of a program.
const HIGHEST_TENTHS: f64 = 9999.0;
/// Ten times the number of a G word is nearer than this to a whole number.
const WHOLE: f64 = 1e-6;

impl GCode {
    /// The word of a value that follows the letter; none where no word has it.
    pub(crate) fn of(value: f64) -> Option<Self> {
        let tenths = (value * 10.0).round();
        let is_word = (value * 10.0 - tenths).abs() < WHOLE && (0.0..=HIGHEST_TENTHS).contains(&tenths);
        is_word.then(|| Self::from_tenths(tenths as u32))
    }

    /// The word of ten times this number.
    pub(crate) const fn from_tenths(tenths: u32) -> Self {
        Self(tenths / 10, (tenths % 10) as u8)
    }

    /// Ten times the number.
    pub(crate) const fn tenths(self) -> u32 {
        self.0.saturating_mul(10).saturating_add(self.1 as u32)
    }

    /// The number as variables of a control show it: 68.2.
    pub(crate) fn number(self) -> f64 {
        f64::from(self.tenths()) / 10.0
    }

    /// The word has no tenth.
    pub(crate) const fn is_whole(self) -> bool {
        self.1 == 0
    }
}

impl fmt::Display for GCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self(number, 0) => write!(f, "G{number}"),
            Self(number, tenth) => write!(f, "G{number}.{tenth}"),
        }
    }
}

/// A text that is no G word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotGCode;

impl FromStr for GCode {
    type Err = NotGCode;

    /// `G1`, `g01`, `G68.2`.
    fn from_str(text: &str) -> Result<Self, NotGCode> {
        let number = text.strip_prefix(['G', 'g']).ok_or(NotGCode)?;
        let (whole, tenth) = number.split_once('.').unwrap_or((number, "0"));
        let digits = |s: &str, most: usize| (1..=most).contains(&s.len()) && s.bytes().all(|b| b.is_ascii_digit());
        if !digits(whole, MOST_DIGITS) || !digits(tenth, 1) {
            return Err(NotGCode);
        }
        match (whole.parse(), tenth.parse()) {
            (Ok(whole), Ok(tenth)) => Ok(Self(whole, tenth)),
            _ => Err(NotGCode),
        }
    }
}

macro_rules! g_words {
    ($($word:ident($number:literal, $tenth:literal))*) => {
        $(pub(crate) const $word: GCode = GCode($number, $tenth);)*
        #[cfg(test)]
        const ALL: &[(&str, GCode)] = &[$((stringify!($word), $word)),*];
    };
}

g_words! {
    G0(0, 0) G1(1, 0) G2(2, 0) G2_3(2, 3) G2_4(2, 4) G3(3, 0) G3_2(3, 2) G3_3(3, 3) G3_4(3, 4) G4(4, 0) G5(5, 0)
    G5_1(5, 1) G5_2(5, 2) G5_3(5, 3) G6(6, 0) G6_1(6, 1) G6_2(6, 2) G7(7, 0) G7_1(7, 1) G8(8, 0) G9(9, 0)
    G10(10, 0) G10_6(10, 6) G11(11, 0) G12(12, 0) G12_1(12, 1) G13(13, 0) G13_1(13, 1) G15(15, 0) G16(16, 0)
    G17(17, 0) G17_1(17, 1) G18(18, 0) G18_1(18, 1) G19(19, 0) G19_1(19, 1) G20(20, 0) G21(21, 0) G22(22, 0)
    G23(23, 0) G25(25, 0) G26(26, 0) G27(27, 0) G27_1(27, 1) G28(28, 0) G28_1(28, 1) G29(29, 0) G30(30, 0)
    G30_1(30, 1) G31(31, 0) G33(33, 0) G33_1(33, 1) G35(35, 0) G36(36, 0) G37(37, 0) G38_2(38, 2) G38_3(38, 3)
    G38_4(38, 4) G38_5(38, 5) G40(40, 0) G40_1(40, 1) G41(41, 0) G41_1(41, 1) G41_2(41, 2) G42(42, 0) G42_1(42, 1)
    G42_2(42, 2) G43(43, 0) G43_1(43, 1) G43_2(43, 2) G43_4(43, 4) G43_5(43, 5) G43_6(43, 6) G44(44, 0) G47(47, 0)
    G49(49, 0) G50(50, 0) G50_1(50, 1) G50_2(50, 2) G51(51, 0) G51_1(51, 1) G51_2(51, 2) G52(52, 0) G53(53, 0)
    G53_1(53, 1) G53_6(53, 6) G54(54, 0) G54_1(54, 1) G54_2(54, 2) G54_4(54, 4) G55(55, 0) G56(56, 0) G57(57, 0)
    G58(58, 0) G59(59, 0) G60(60, 0) G61(61, 0) G61_1(61, 1) G62(62, 0) G63(63, 0) G64(64, 0) G65(65, 0) G66(66, 0)
    G66_1(66, 1) G67(67, 0) G68(68, 0) G68_2(68, 2) G68_3(68, 3) G68_4(68, 4) G69(69, 0) G69_1(69, 1) G70(70, 0)
    G71(71, 0) G71_1(71, 1) G71_2(71, 2) G72(72, 0) G73(73, 0) G74(74, 0) G75(75, 0) G75_1(75, 1) G75_3(75, 3)
    G76(76, 0) G77(77, 0) G80(80, 0) G81(81, 0) G82(82, 0) G83(83, 0) G84(84, 0) G84_2(84, 2) G84_3(84, 3)
    G85(85, 0) G86(86, 0) G87(87, 0) G88(88, 0) G88_1(88, 1) G89(89, 0) G90(90, 0) G90_1(90, 1) G91(91, 0)
    G91_1(91, 1) G92(92, 0) G92_1(92, 1) G92_2(92, 2) G92_3(92, 3) G93(93, 0) G94(94, 0) G95(95, 0) G96(96, 0)
    G97(97, 0) G98(98, 0) G99(99, 0) G100(100, 0) G101(101, 0) G102(102, 0) G103(103, 0) G107(107, 0) G113(113, 0)
    G136(136, 0) G141(141, 0) G143(143, 0) G150(150, 0) G154(154, 0) G174(174, 0) G184(184, 0) G187(187, 0)
    G234(234, 0) G253(253, 0) G254(254, 0) G255(255, 0) G266(266, 0) G267(267, 0) G268(268, 0) G269(269, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_the_word_of_its_name() {
        for (name, word) in ALL {
            assert_eq!(word.to_string(), name.replace('_', "."));
            assert_eq!(word.to_string().parse(), Ok(*word));
        }
        assert!(ALL.is_sorted_by(|(_, a), (_, b)| a < b), "in the order of their numbers");
    }

    #[test]
    fn a_word_has_one_spelling_however_it_is_written() {
        for (text, word) in [("G1", G1), ("g01", G1), ("G001", G1), ("G68.2", G68_2), ("g05.1", G5_1), ("G68.0", G68)] {
            assert_eq!(text.parse(), Ok(word), "{text}");
        }
        for text in ["", "G", "1", "M1", "G-1", "G+1", "G1.", "G.1", "G68.22", "G1000", "G1 ", "G1.x"] {
            assert_eq!(text.parse::<GCode>(), Err(NotGCode), "{text}");
        }
    }

    #[test]
    fn a_value_is_a_word_up_to_its_tenth() {
        assert_eq!([0.0, 1.0, 68.2, 999.9].map(GCode::of), [Some(G0), Some(G1), Some(G68_2), Some(GCode(999, 9))]);
        // Values that a program calculates are no exact tenths.
        assert_eq!(GCode::of(54.0 + 0.1 + 0.2 - 0.2), Some(G54_1));
        assert_eq!([-1.0, 1000.0, 68.25, f64::NAN, f64::INFINITY].map(GCode::of), [None; 5]);
    }

    #[test]
    fn tenths_go_both_ways_and_keep_the_order() {
        let words: Vec<GCode> = (0..10_000).map(GCode::from_tenths).collect();
        assert!(words.is_sorted_by(|a, b| a < b));
        assert!(
            (0u32..).zip(&words).all(|(tenths, word)| word.tenths() == tenths && word.is_whole() == (tenths % 10 == 0))
        );
        assert_eq!(G68_2.number().to_bits(), 68.2f64.to_bits());
        assert_eq!(GCode(u32::MAX, 9).tenths(), u32::MAX);
    }

    #[test]
    fn words_are_patterns() {
        let drills = |word| matches!(word, G73 | G74 | GCode(81..=89, 0));
        assert_eq!([G73, G81, G89, G80, GCode(84, 2)].map(drills), [true, true, true, false, false]);
    }
}
