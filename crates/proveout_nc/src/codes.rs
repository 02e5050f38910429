//! The registry of diagnostic codes.

/// A code with what it means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CodeInfo {
    /// The code, as in [`crate::Diagnostic::code`].
    pub code: &'static str,
    /// What is wrong, in one sentence.
    pub summary: &'static str,
    /// What to do about it.
    pub remedy: &'static str,
}

macro_rules! codes {
    ($($name:ident = $code:literal, $summary:literal, $remedy:literal;)*) => {
        $(#[doc = $summary] pub(crate) const $name: &str = $code;)*
        /// Every code that a diagnostic of this crate can carry, in alphabetical order.
        pub const CODES: &[CodeInfo] = &[$(CodeInfo { code: $code, summary: $summary, remedy: $remedy }),*];
    };
}

codes! {
    ARC_GEOMETRY = "nc-arc-geometry", "The words of an arc do not define a circle.",
        "Give the end point and either the center (I J K) or the radius, in the plane that is active.";
    ARC_RADIUS = "nc-arc-radius", "Start and end of an arc have different distances from its center.",
        "Correct the center or the end point, or program the point before the arc.";
    ARGUMENTS = "nc-arguments", "A call has too many, too few or wrong arguments.",
        "Compare the call with the definition of the cycle or subprogram.";
    ARITHMETIC = "nc-arithmetic", "A calculation has no result, such as a division by zero.",
        "Check the values of the expression.";
    BAD_VALUE = "nc-bad-value", "The value of a word is out of range.", "Use a value within the range of the word.";
    COMPENSATION = "nc-compensation", "The path of the tool center cannot be computed from the programmed contour.",
        "Use a tool that fits, give its radius, or write G40 before blocks that cannot be compensated.";
    CONFLICT = "nc-conflicting-words", "Two words of a block contradict each other.",
        "Write them in blocks of their own.";
    DIALECT = "nc-dialect", "The dialect of the program could not be determined from its file name and text.",
        "Name the dialect in the call.";
    FILE = "nc-file", "A program file could not be read.", "Check the path and the rights.";
    JUMP_TARGET = "nc-jump-target", "A jump names a label or block number that does not exist.",
        "Write the label, or jump in the other direction.";
    LOOP_LIMIT = "nc-loop-limit", "A loop ran more often than the limit allows.",
        "Check the condition of the loop: is its variable changed inside?";
    MISSING_VALUE = "nc-missing-value", "A word has no value.", "Write the value after the word.";
    NESTING_LIMIT = "nc-nesting-limit", "Calls or brackets are nested deeper than the limit allows.",
        "Check for a subprogram that calls itself.";
    NO_END = "nc-no-end", "A program has no end.",
        "Write M30 or M2 (M17, M99, END PGM, FINI) at its end.";
    NO_FEED = "nc-no-feed", "A feed motion has no feed rate.", "Program F before or in the block.";
    NO_MOTION = "nc-no-motion", "A program moves no axis.",
        "Check that the file holds the whole program and that its dialect is named.";
    NO_TOOL = "nc-no-tool", "The program changes the tool before it selects one.",
        "Program T in or before the block of the tool change.";
    NOT_RUN = "nc-not-run", "Text of the program is not run.",
        "Remove the text, or the end word before it; give each main program a file of its own.";
    ORIENTATION = "nc-orientation", "A programmed tool orientation cannot be used.",
        "Switch the five-axis transformation on, and give a vector with a length.";
    POSITION_UNKNOWN = "nc-position-unknown", "A motion needs a coordinate that the program has not set.",
        "Program X, Y and Z in the first block after machine coordinates, a tool change or a transformation.";
    PROBE = "nc-probe", "A probing motion cannot be made, or its result is not known.",
        "Begin clear of the part, let the motion end behind the surface, and read the result after the motion.";
    PROGRAM_ALARM = "nc-program-alarm", "The program itself raises an alarm.",
        "Find out which condition of the program is not met.";
    STRUCTURE = "nc-structure", "Opening and closing words of a control structure do not match.",
        "Write the missing word.";
    SUBPROGRAM = "nc-subprogram", "A called subprogram was not found.",
        "Put the subprogram into the folder of the program, or into the same file.";
    SYNTAX = "nc-syntax", "The text does not follow the grammar of the dialect.", "Correct the text at the place shown.";
    TYPE = "nc-type", "A value has the wrong type for its use.", "Use a value of the required type.";
    UNKNOWN_VARIABLE = "nc-unknown-variable", "A variable without a definition or a value is used.",
        "Define it with DEF, assign it first, or give its value with --variable or in the control file.";
    UNKNOWN_WORD = "nc-unknown-word", "A word that is unknown to the reader of this dialect.",
        "Correct the word; if the control knows it, remove it for the prove-out.";
    UNSUPPORTED_WORD = "nc-unsupported-word", "A word of the control that this reader does not support.",
        "Program the same motion with words of the coverage table.";
}

/// What a code means.
pub fn explain(code: &str) -> Option<&'static CodeInfo> {
    CODES.iter().find(|info| info.code == code)
}
