//! Names of scenes, programs and patches become names of files and folders: checked once, where they are
//! read.

/// Longest name, bytes: file systems take 255, and endings are added.
const LONGEST: usize = 100;

/// Why a name cannot be one; none where it can.
pub(crate) fn fault(name: &str) -> Option<String> {
    let shown = name.chars().take(40).collect::<String>().escape_debug().to_string();
    let steers = |c: char| {
        c.is_control()
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{61c}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if name.trim().is_empty() || name.trim() != name {
        return Some(format!("the name \"{shown}\" is empty or has blanks at an end"));
    }
    if name.len() > LONGEST {
        return Some(format!("the name \"{shown}...\" has {} bytes; the limit is {LONGEST}", name.len()));
    }
    if name.starts_with(['.', '-']) {
        return Some(format!("the name \"{shown}\" begins with a point or a dash"));
    }
    let forbidden = |c: char| steers(c) || matches!(c, '/' | '\\' | ':' | '*' | '?' | '"' | '<' | '>' | '|');
    name.chars().find(|c| forbidden(*c)).map(|c| {
        format!("the name \"{shown}\" has the character {}, which is not allowed in file names", c.escape_debug())
    })
}

/// What to do about it.
pub(crate) const REMEDY: &str = "write letters, digits, blanks and - _ . + inside; folders are chosen with --output";

#[cfg(test)]
mod tests {
    use super::fault;

    #[test]
    fn names_choose_no_paths() {
        for bad in [
            "",
            " a",
            "../out/x",
            "/tmp/x",
            "..",
            ".hidden",
            "-rf",
            "a\\b",
            "a\nb",
            "a\u{1b}[2J",
            "a\u{202e}b",
            "c:x",
            &"x".repeat(101),
        ] {
            assert!(fault(bad).is_some(), "{bad:?}");
        }
        for good in ["axis-cross", "Li 2022, S-theta", "\u{dc}bung 3", "a+b_c.2", "x (old)"] {
            assert_eq!(fault(good), None, "{good}");
        }
    }
}
