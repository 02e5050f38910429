//! Words of a file with their meanings.

use std::collections::BTreeMap;

use super::error::Checked;
use super::family::ReaderFamily;
use super::file::{KinematicsWordFile, WordFile};
use super::model::Control;
use super::place::ControlText;
use super::words::{Builtin, ListedWord, Meaning, WordKey, word_key};
use crate::dialect::does_word;
use crate::g_code::{G65, G66, G67};
use crate::settings::Dialect;

/// Most words of one file.
const MOST_WORDS: usize = 10_000;
/// Most words that one word may expand to.
const MOST_BUILTIN: usize = 4;

/// Puts the words of a file into the table of the control.
pub(super) fn apply(control: &mut Control, words: &BTreeMap<String, WordFile>, text: &ControlText<'_>) -> Checked<()> {
    if words.len() > MOST_WORDS {
        let message = format!("the file lists {} words; the limit is {MOST_WORDS}", words.len());
        return Err(text.error("control-value", &["words"], message, "list fewer"));
    }
    let mut seen: BTreeMap<WordKey, &str> = BTreeMap::new();
    for (word, file) in words {
        let path = ["words", word.as_str()];
        let key = key(word, control.dialect, text)?;
        if let Some(other) = seen.insert(key.clone(), word) {
            let message = format!("{word} and {other} are the same word");
            return Err(text.error("control-contradiction", &path, message, "keep one"));
        }
        let meaning = meaning(word, file, control.dialect, text)?;
        let values = values(word, file, &meaning, control.dialect, text)?;
        control.words.put(&key, ListedWord { word: key.to_string(), meaning, values });
    }
    Ok(())
}

fn key(word: &str, dialect: Dialect, text: &ControlText<'_>) -> Checked<WordKey> {
    let key = word_key(word);
    let wanted = match ReaderFamily::of(dialect) {
        Some(ReaderFamily::Apt) => "a major word of APT, such as INSERT",
        Some(ReaderFamily::Siemens) => "an M or G word, or a name: M25, G187, CYCLE999",
        Some(ReaderFamily::Heidenhain | ReaderFamily::HeidenhainIso) => {
            "an M word, M25, or a cycle of the machine builder, CYCL392"
        }
        _ => "an M or G word: M25, G187, G38.2",
    };
    let fits = match (&key, ReaderFamily::of(dialect)) {
        (Some(WordKey::Name(_)), Some(ReaderFamily::Siemens | ReaderFamily::Apt)) => true,
        (Some(WordKey::Name(name)), Some(ReaderFamily::Heidenhain | ReaderFamily::HeidenhainIso)) => {
            builder_cycle(name)
        }
        (Some(WordKey::Name(_)) | None, _) | (Some(_), Some(ReaderFamily::Apt)) => false,
        (Some(WordKey::G(_)), Some(ReaderFamily::Heidenhain | ReaderFamily::HeidenhainIso)) => false,
        (Some(WordKey::G(code)), Some(ReaderFamily::Siemens)) => code.is_whole(),
        (Some(WordKey::G(_) | WordKey::M(_)), _) => true,
    };
    let flow = match &key {
        Some(WordKey::M(2 | 17 | 30 | 97 | 98 | 99 | 198)) => ReaderFamily::of(dialect) != Some(ReaderFamily::Apt),
        Some(WordKey::G(G65 | G66 | G67)) => matches!(ReaderFamily::of(dialect), Some(ReaderFamily::MacroB)),
        _ => false,
    };
    if flow {
        let message = format!("{word} ends or calls programs, and keeps its meaning");
        return Err(text.error("control-word", &["words", word], message, "remove it"));
    }
    match key {
        Some(key) if fits => Ok(key),
        _ => {
            let message = format!("{word:?} is not a word of the dialect {}", dialect.name());
            Err(text.error("control-word", &["words", word], message, format!("write {wanted}")))
        }
    }
}

/// `CYCL300` to `CYCL399`: cycles of the machine builder on a TNC.
fn builder_cycle(name: &str) -> bool {
    let number = name.strip_prefix("CYCL").unwrap_or_default();
    number.len() == 3 && number.starts_with('3') && number.bytes().all(|b| b.is_ascii_digit())
}

fn meaning(word: &str, file: &WordFile, dialect: Dialect, text: &ControlText<'_>) -> Checked<Meaning> {
    let texts = [
        ("does", file.does.as_ref()),
        ("call", file.call.as_ref()),
        ("macro", file.macro_call.as_ref()),
        ("offset", file.offset.as_ref()),
        ("offset_once", file.offset_once.as_ref()),
        ("message", file.message.as_ref()),
        ("note", file.note.as_ref()),
        ("ignore", file.ignore.as_ref()),
        ("refuse", file.refuse.as_ref()),
    ];
    let mut stated: Vec<&str> = texts.iter().filter(|(_, text)| text.is_some()).map(|(key, _)| *key).collect();
    if file.kinematics.is_some() {
        stated.push("kinematics");
    }
    if file.source.as_ref().is_some_and(|source| source.trim().is_empty()) {
        let path = ["words", word, "source"];
        return Err(text.error(
            "control-empty-text",
            &path,
            "the source is empty",
            "write where the meaning comes from",
        ));
    }
    let [key] = stated[..] else {
        let choices = "does, kinematics, call, macro, offset, offset_once, message, note, ignore or refuse";
        let message = match &stated[..] {
            [] => format!("{word} has no meaning"),
            several => format!("{word} has several meanings: {}", several.join(", ")),
        };
        return Err(text.error(
            "control-contradiction",
            &["words", word],
            message,
            format!("give it one of {choices}"),
        ));
    };
    let path = ["words", word, key];
    let effect = match ReaderFamily::of(dialect) {
        Some(ReaderFamily::Apt) => matches!(key, "note" | "ignore" | "message" | "refuse"),
        Some(ReaderFamily::Heidenhain | ReaderFamily::HeidenhainIso)
            if builder_cycle(&word.trim().to_ascii_uppercase()) =>
        {
            matches!(key, "note" | "ignore" | "message" | "refuse")
        }
        Some(ReaderFamily::Siemens) => !matches!(key, "macro" | "offset" | "offset_once"),
        Some(ReaderFamily::LinuxCnc) => !matches!(key, "offset" | "offset_once"),
        Some(ReaderFamily::Heidenhain | ReaderFamily::HeidenhainIso) => {
            !matches!(key, "macro" | "call" | "offset" | "offset_once")
        }
        _ => true,
    };
    if !effect {
        let message = format!("a word of the dialect {} cannot mean this", dialect.name());
        return Err(text.error("control-no-effect", &path, message, "give it another meaning"));
    }
    if let Some(kinematics) = file.kinematics {
        return Ok(match kinematics {
            KinematicsWordFile::TcpOn => Meaning::TcpOn,
            KinematicsWordFile::TcpOff => Meaning::TcpOff,
        });
    }
    let value = texts.into_iter().find_map(|(name, value)| value.filter(|_| name == key)).cloned().unwrap_or_default();
    if value.trim().is_empty() {
        let remedy = match key {
            "ignore" => "write why the word has no effect",
            "refuse" => "write what to do instead",
            _ => "write it",
        };
        return Err(text.error("control-empty-text", &path, "the text is empty", remedy));
    }
    Ok(match key {
        "does" => Meaning::Does(builtins(&value, dialect, &path, text)?),
        "call" => Meaning::Call(program(&value, dialect, &path, text)?),
        "macro" if dialect == Dialect::LinuxCnc => Meaning::Macro(o_name(&value, &path, text)?),
        "macro" => Meaning::Macro(program(&value, dialect, &path, text)?),
        "offset" => Meaning::Offset(letter(&value, &path, text)?),
        "offset_once" => Meaning::OffsetOnce(letter(&value, &path, text)?),
        "message" => Meaning::Message(value),
        "note" => Meaning::Note(value),
        "ignore" => Meaning::Ignore(value),
        _ => Meaning::Refuse(value),
    })
}

/// Words that the reader of the language executes without a control file, whatever the table says
/// of them.
fn builtins(value: &str, dialect: Dialect, path: &[&str], text: &ControlText<'_>) -> Checked<Vec<Builtin>> {
    let mut list = Vec::new();
    for word in value.split_whitespace() {
        let unknown = |what: &str| {
            let message = format!("{word:?} is not a function {what} the dialect {}", dialect.name());
            text.error(
                "control-unknown-function",
                path,
                message,
                "write words that the README's table lists as supported",
            )
        };
        let builtin = match word_key(word) {
            Some(WordKey::G(code)) => Builtin::G(code),
            Some(WordKey::M(code)) => Builtin::M(code),
            _ => return Err(unknown("of an M or G word in")),
        };
        if !does_word(dialect, builtin) {
            return Err(unknown("that is supported in"));
        }
        if list.contains(&builtin) {
            return Err(text.error("control-contradiction", path, format!("{word} is listed twice"), "keep one"));
        }
        list.push(builtin);
    }
    if list.len() > MOST_BUILTIN {
        let message = format!("one word replaces {} words; the limit is {MOST_BUILTIN}", list.len());
        return Err(text.error("control-value", path, message, "call a subprogram"));
    }
    Ok(list)
}

/// Number or name of a subprogram: `9001` of `O9001` where the language has numbers.
fn program(value: &str, dialect: Dialect, path: &[&str], text: &ControlText<'_>) -> Checked<String> {
    let name = value.trim();
    if !matches!(ReaderFamily::of(dialect), Some(ReaderFamily::MacroB | ReaderFamily::LinuxCnc)) {
        return Ok(name.to_owned());
    }
    let number = name.strip_prefix(['O', 'o']).unwrap_or(name).trim_start_matches('0');
    let good = !number.is_empty() && number.len() <= 8 && number.bytes().all(|b| b.is_ascii_digit());
    if good {
        return Ok(number.to_owned());
    }
    Err(text.error("control-value", path, format!("{value:?} is not a program number"), "write O9001"))
}

/// Name of an O word subprogram, as its label is kept: `<bore>`, `100`.
fn o_name(value: &str, path: &[&str], text: &ControlText<'_>) -> Checked<String> {
    let name = value.trim().to_ascii_lowercase();
    let bare = name.strip_prefix('o').filter(|rest| rest.starts_with('<')).unwrap_or(&name);
    let bare = bare.strip_prefix('<').and_then(|rest| rest.strip_suffix('>')).unwrap_or(bare);
    if !bare.is_empty() && bare.bytes().all(|b| b.is_ascii_digit()) && bare.len() <= 9 {
        let number = bare.trim_start_matches('0');
        return Ok(if number.is_empty() { "0" } else { number }.to_owned());
    }
    let good = bare.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-'));
    if good && !bare.is_empty() {
        return Ok(format!("<{bare}>"));
    }
    Err(text.error(
        "control-value",
        path,
        format!("{value:?} is not the name of an O word subprogram"),
        "write its name: \"bore\" for o<bore> sub",
    ))
}

/// The letter of a word with a number.
fn letter(value: &str, path: &[&str], text: &ControlText<'_>) -> Checked<u8> {
    match value.trim().to_ascii_uppercase().as_bytes() {
        [letter] if letter.is_ascii_uppercase() && !b"GMNO".contains(letter) => Ok(*letter),
        _ => {
            Err(text.error("control-value", path, format!("{value:?} is not a word letter"), "write one letter: \"H\""))
        }
    }
}

fn values(
    word: &str,
    file: &WordFile,
    meaning: &Meaning,
    dialect: Dialect,
    text: &ControlText<'_>,
) -> Checked<Vec<u8>> {
    let Some(letters) = &file.values else { return Ok(Vec::new()) };
    let path = ["words", word, "values"];
    let taken = matches!(meaning, Meaning::Message(_) | Meaning::Note(_) | Meaning::Ignore(_) | Meaning::Call(_))
        || dialect == Dialect::LinuxCnc && matches!(meaning, Meaning::Macro(_));
    if !taken || !matches!(ReaderFamily::of(dialect), Some(ReaderFamily::MacroB | ReaderFamily::LinuxCnc)) {
        let message = "letters that belong to the word have no effect here";
        return Err(text.error("control-no-effect", &path, message, "remove them"));
    }
    let letters = letters.trim().to_ascii_uppercase();
    let good = letters.bytes().all(|b| b.is_ascii_uppercase() && !b"GMN".contains(&b)) && !letters.is_empty();
    if !good {
        let message = format!("{letters:?} are not letters of words");
        return Err(text.error("control-value", &path, message, "write letters without G, M and N: \"PQ\""));
    }
    Ok(letters.bytes().collect())
}
