//! What a text says of the control that it was written for, where neither call nor machine name
//! one.

use proveout_nc::{Dialect, ProgramText};

/// Lines that are read.
const LINES: usize = 400;

const FAGOR_8065: &str = "a Fagor 8060 or 8065";

/// Words of a block, without spaces, with the controls that have them and the builders of those.
const WORDS: [(&str, &str, &[&str]); 10] = [
    ("G61.1", "a Mazak or a Mitsubishi", &["mazak-eia", "mitsubishi-m800"]),
    ("G15H", "an Okuma", &["okuma-osp"]),
    ("G16H", "an Okuma", &["okuma-osp"]),
    ("VC1=", "an Okuma", &["okuma-osp"]),
    ("#RTCPON", FAGOR_8065, &[]),
    ("#CSON", FAGOR_8065, &[]),
    ("#ACSON", FAGOR_8065, &[]),
    ("#HSCON", FAGOR_8065, &[]),
    ("#TOOLORI", FAGOR_8065, &[]),
    ("#MSG[", FAGOR_8065, &[]),
];

/// Names in a comment.
const NAMES: [(&str, &str, &[&str]); 8] = [
    ("MAZAK", "a Mazak", &["mazak-eia"]),
    ("MITSUBISHI", "a Mitsubishi", &["mitsubishi-m800"]),
    ("OKUMA", "an Okuma", &["okuma-osp"]),
    ("SPEEDIO", "a Brother Speedio", &["brother-c00"]),
    ("BROTHER", "a Brother Speedio", &["brother-c00"]),
    ("HURCO", "a Hurco", &["hurco-isnc"]),
    ("FAGOR", "a Fagor", &["fagor-8055"]),
    ("HAAS", "a Haas", &["haas-ngc"]),
];

/// What the text says, and the option that has it read so; none where it says nothing of a control.
pub(crate) fn hint(text: &ProgramText, dialect: Dialect) -> Option<String> {
    if dialect.family() != Dialect::Iso || dialect == Dialect::LinuxCnc {
        return None;
    }
    let lines = || (1_usize..).zip(text.all().take(LINES).map(str::to_ascii_uppercase));
    let hint = |n: usize, word: &str, whose: &str, controls: &[&str]| {
        if controls.is_empty() {
            return format!(
                "{word} in line {n} points to {whose}, whose statements with # and $ are not read: post the program for a Fagor 8055 \
                 (--control fagor-8055) or a Fanuc"
            );
        }
        let options: Vec<String> = controls.iter().map(|c| format!("--control {c}")).collect();
        format!(
            "{word} in line {n} points to {whose}, and no control is named: {} reads the program that way",
            options.join(" or ")
        )
    };
    let of_word = lines().find_map(|(n, line)| {
        let code: String = without_comments(&line).split_whitespace().collect();
        let (word, whose, controls) = WORDS.iter().find(|(word, ..)| code.contains(word))?;
        Some(hint(n, word, whose, controls))
    });
    // `%BRIDA,MX,`: name, kind and rights, as a Fagor heads its files.
    let of_head = lines().find(|(_, line)| !line.trim().is_empty()).and_then(|(n, line)| {
        let code: String = line.split_whitespace().collect();
        let (name, rest) = code.strip_prefix('%')?.split_once(',')?;
        let fagor = !name.is_empty() && (rest.starts_with("MX") || rest.starts_with(",MX"));
        fagor.then(|| hint(n, "the head", "a Fagor", &["fagor-8055"]))
    });
    of_word.or(of_head).or_else(|| {
        lines().find_map(|(n, line)| {
            let comments: Vec<&str> = line.split('(').skip(1).filter_map(|c| c.split(')').next()).collect();
            let named =
                |word: &str| comments.iter().any(|c| c.split(|c: char| !c.is_alphanumeric()).any(|w| w == word));
            let (word, whose, controls) = NAMES.iter().find(|(word, ..)| named(word))?;
            Some(hint(n, word, whose, controls))
        })
    })
}

fn without_comments(line: &str) -> String {
    let mut depth = 0_usize;
    let mut out = String::new();
    for c in line.chars() {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            ';' => break,
            c if depth == 0 => out.push(c),
            _ => {}
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Option<String> {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = folder.path().join("part.nc");
        std::fs::write(&file, text).expect("written");
        hint(&ProgramText::open(file).expect("a text"), Dialect::Iso)
    }

    #[test]
    fn words_go_before_names_and_comments_are_no_words() {
        let text = of("%\nO1 (POST OF A HAAS)\nG90 G61.1 ,K90.\nM30\n").expect("a hint");
        assert!(
            text.starts_with("G61.1 in line 3") && text.contains("--control mazak-eia or --control mitsubishi-m800")
        );
        assert!(of("O1 (NOT G61.1)\nG0 X1.\n").is_none());
        assert!(of("O1 (HAASE AND SONS)\nG0 X1.\n").is_none());
        assert!(of("O1 (HAAS VF-2)\nG0 X1.\n").is_some_and(|t| t.contains("haas-ngc")));
        assert!(of("O1\nG15 H1\n").is_some_and(|t| t.contains("okuma-osp")));
        assert!(of("O1\nG0 X1.\n").is_none());
        assert!(
            of("%PIEZA,MX,\nG0 X1.\n").is_some_and(|t| t.contains("the head in line 1") && t.contains("fagor-8055"))
        );
        assert!(of("O1 (BROTHER S700)\nG0 X1.\n").is_some_and(|t| t.contains("brother-c00")));
    }
}
