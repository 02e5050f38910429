//! What goes to a terminal: lines of text without anything that would steer it.
//!
//! Names, comments and lines of programs come from others. An escape sequence in one could clear the screen,
//! set the clipboard or the title (ECMA-48; OSC of xterm), and marks of direction (Unicode, UAX 9) could show
//! a line in another order than it is read.

/// Text with control characters shown as their pictures; line feeds stay, tabs become blanks.
pub(crate) fn plain(text: &str) -> String {
    let picture = |c: char| match c {
        '\n' => '\n',
        '\t' => ' ',
        '\u{7f}' => '\u{2421}',
        c if c < ' ' => char::from_u32(0x2400 + c as u32).unwrap_or(' '),
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    };
    text.chars().map(picture).collect()
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn nothing_steers_the_terminal() {
        let text = plain("N10 \u{1b}]0;title\u{7}\u{1b}[2J\r\u{9b}31m \u{202e}abc\u{2066}\nN20\tX1");
        assert_eq!(text, "N10 \u{241b}]0;title\u{2407}\u{241b}[2J\u{240d}\u{fffd}31m \u{fffd}abc\u{fffd}\nN20 X1");
    }
}
