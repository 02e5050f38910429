//! English style of comments, messages and pages: few turns of phrase that a reader must decode, short
//! sentences, comments that fit the page.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{TaskError, files};

/// Turns to write in another way, a line each: their forms, and what to write instead; `..` holds up to three
/// words.
const TURNS: &str = include_str!("turns.txt");
/// Most uses of one turn in 10,000 words of comments, of messages and of pages, each.
const TURNS_IN_10_000_WORDS: f64 = 2.0;
/// Most words of a sentence on a page, on average.
const MEAN_SENTENCE_WORDS: f64 = 17.0;
/// Columns of a comment line.
const COMMENT_COLUMNS: usize = 110;
/// Places that a failure names, for each fault.
const PLACES: usize = 20;

/// A text with the line where it begins.
type Text = (usize, String);
/// Texts of one kind, with their files.
type Texts = Vec<(PathBuf, Text)>;

/// Fails with the worst places of every turn that is used too often, of long sentences and of long comment
/// lines.
pub(crate) fn check(root: &Path) -> Result<String, TaskError> {
    let [mut comments, mut of_tests, mut messages, mut pages] = [const { Texts::new() }; 4];
    for path in text_files(root)? {
        let text = files::get(&root.join(&path))?;
        let named = |texts: Vec<Text>| texts.into_iter().map(|t| (path.clone(), t)).collect::<Texts>();
        if path.extension().is_some_and(|e| e == "md") {
            pages.extend(named(text.lines().enumerate().map(|(k, line)| (k + 1, line.to_owned())).collect()));
        } else {
            let production = if is_production(&path) { without_tests(&text) } else { "" };
            let (of_comments, of_messages) = comments_and_strings(production);
            comments.extend(named(of_comments));
            messages.extend(named(of_messages));
            // Strings of tests are inputs and wrong on purpose.
            let (tests, _) = comments_and_strings(&text[production.len()..]);
            let before = production.matches('\n').count();
            of_tests.extend(named(tests.into_iter().map(|(line, text)| (before + line, text)).collect()));
        }
    }
    let mut faults = Vec::new();
    let kinds = [("comments", &comments), ("comments of tests", &of_tests), ("messages", &messages), ("pages", &pages)];
    let shares = kinds.map(|(kind, texts)| format!("{kind} {:.1}", turns(kind, texts, &mut faults)));
    let mean = long_sentences(&pages, &mut faults);
    comments.extend(of_tests);
    long_lines(&comments, &mut faults);
    if faults.is_empty() {
        let shares = shares.join(", ");
        Ok(format!("most of a turn in 10,000 words: {shares}; {mean:.1} words a sentence; no long comment lines"))
    } else {
        Err(TaskError(faults.join("\n")))
    }
}

/// The largest number of uses of one turn in 10,000 words.
fn turns(kind: &str, texts: &Texts, faults: &mut Vec<String>) -> f64 {
    let lines: Vec<Vec<String>> = texts.iter().map(|(_, (_, text))| words(text)).collect();
    let total = lines.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let mut most = 0.0_f64;
    for (name, better) in TURNS.lines().filter_map(|line| line.split_once(" = ")) {
        let forms: Vec<Vec<&str>> = name.split(", ").map(|form| form.split(' ').collect()).collect();
        let uses =
            |line: &Vec<String>| (0..line.len()).filter(|&k| forms.iter().any(|f| begins(&line[k..], f))).count();
        let places: Vec<usize> = lines.iter().enumerate().flat_map(|(k, line)| vec![k; uses(line)]).collect();
        let share = 1e4 * places.len() as f64 / total;
        most = most.max(share);
        if share > TURNS_IN_10_000_WORDS {
            let limit = TURNS_IN_10_000_WORDS;
            faults
                .push(format!("{kind}: `{name}` {share:.1} times in 10,000 words, at most {limit}; better: {better}"));
            faults.extend(places.iter().take(PLACES).map(|&k| place(&texts[k])));
        }
    }
    most
}

/// Whether a line begins with the words of a turn.
fn begins(line: &[String], turn: &[&str]) -> bool {
    match turn {
        [] => true,
        ["..", rest @ ..] => (0..=3).any(|gap| line.get(gap..).is_some_and(|line| begins(line, rest))),
        [first, rest @ ..] => line.first().is_some_and(|word| word == first) && begins(&line[1..], rest),
    }
}

/// Words in lower case; an identifier is one word.
fn words(text: &str) -> Vec<String> {
    let is_mark = |c: char| !(c.is_alphanumeric() || c == '_');
    text.split(is_mark).filter(|w| !w.is_empty()).map(str::to_lowercase).collect()
}

/// Mean words of a sentence on the pages.
fn long_sentences(pages: &Texts, faults: &mut Vec<String>) -> f64 {
    let mut all = Vec::new();
    for lines in pages.chunk_by(|a, b| a.0 == b.0) {
        let numbered: Vec<(usize, &str)> = lines.iter().map(|(_, (line, text))| (*line, text.as_str())).collect();
        all.extend(sentences(&numbered).into_iter().map(|sentence| (lines[0].0.clone(), sentence)));
    }
    let length = |text: &str| words(text).len();
    let mean = all.iter().map(|(_, (_, text))| length(text)).sum::<usize>() as f64 / all.len().max(1) as f64;
    if mean > MEAN_SENTENCE_WORDS {
        faults.push(format!("pages: {mean:.1} words a sentence, at most {MEAN_SENTENCE_WORDS}; split the longest:"));
        all.sort_by_key(|(_, (_, text))| std::cmp::Reverse(length(text)));
        faults.extend(all.iter().take(PLACES).map(place));
    }
    mean
}

/// Sentences of a page, without code, tables and headings; code between backticks is one word.
fn sentences(lines: &[(usize, &str)]) -> Vec<Text> {
    let mut out: Vec<Text> = Vec::new();
    let (mut open, mut fenced) = (false, false);
    for &(number, line) in lines {
        let line = line.trim();
        let fence = line.starts_with("```");
        fenced ^= fence;
        if fenced || fence || line.is_empty() || line.starts_with(['|', '#', '<']) {
            open = false;
            continue;
        }
        let item = line
            .strip_prefix(['-', '*'])
            .or_else(|| line.trim_start_matches(|c: char| c.is_ascii_digit()).strip_prefix('.'));
        open &= item.is_none_or(|rest| !rest.starts_with(' '));
        let plain: String =
            line.split('`').enumerate().map(|(k, part)| if k % 2 == 0 { part } else { "code" }).collect();
        for word in plain.split_whitespace() {
            match out.last_mut() {
                Some((_, sentence)) if open => *sentence += &format!(" {word}"),
                _ => out.push((number, word.to_owned())),
            }
            open = !word.trim_end_matches(['"', ')', '*']).ends_with(['.', '!', '?', ':']);
        }
    }
    out.retain(|(_, sentence)| words(sentence).len() > 2);
    out
}

/// Comment lines with too many columns, the longest first.
fn long_lines(comments: &Texts, faults: &mut Vec<String>) {
    let columns = |text: &(PathBuf, Text)| text.1.1.chars().count();
    let mut long: Vec<&(PathBuf, Text)> = comments.iter().filter(|text| columns(text) > COMMENT_COLUMNS).collect();
    if !long.is_empty() {
        faults.push(format!("{} comment lines over {COMMENT_COLUMNS} columns; wrap the longest:", long.len()));
        long.sort_by_key(|text| std::cmp::Reverse(columns(text)));
        faults.extend(long.iter().take(PLACES).map(|text| place(text)));
    }
}

fn place((path, (line, text)): &(PathBuf, Text)) -> String {
    format!("  {}:{line}: {}", path.display(), text.trim())
}

/// Rust files and pages below the root, sorted; without hidden folders and builds.
pub(crate) fn text_files(root: &Path) -> Result<Vec<PathBuf>, TaskError> {
    let (mut folders, mut out) = (vec![root.to_path_buf()], Vec::new());
    while let Some(folder) = folders.pop() {
        let fault = |e: std::io::Error| TaskError(format!("{}: {e}", folder.display()));
        for entry in fs::read_dir(&folder).map_err(fault)? {
            let path = entry.map_err(fault)?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() && !name.starts_with('.') && name != "target" {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs" || e == "md") {
                out.extend(path.strip_prefix(root).map(Path::to_path_buf));
            }
        }
    }
    out.sort();
    Ok(out)
}

/// Whether a Rust file is part of the product, and no test.
pub(super) fn is_production(path: &Path) -> bool {
    let parts: Vec<String> = path.iter().map(|p| p.to_string_lossy().into_owned()).collect();
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_test = name == "tests" || name.ends_with("_test") || name.ends_with("_tests");
    parts.iter().any(|p| p == "src")
        && !is_test
        && !parts.iter().any(|p| p == "tests" || p == "benches" || p == "examples")
}

/// A Rust file up to its module of tests.
pub(super) fn without_tests(text: &str) -> &str {
    let starts = text.match_indices("#[cfg(").map(|(at, _)| at);
    let is_tests = |at: &usize| {
        let rest = &text[at + "#[cfg(".len()..];
        let after = rest.split_once(']').map_or("", |(_, after)| after).trim_start();
        rest.trim_start_matches("all(").starts_with("test")
            && after.starts_with("mod ")
            && after.lines().next().is_some_and(|line| line.ends_with('{'))
    };
    starts.into_iter().find(is_tests).map_or(text, |at| &text[..at])
}

/// Comment lines, whole, and string literals of a Rust file.
fn comments_and_strings(text: &str) -> (Vec<Text>, Vec<Text>) {
    let (mut comments, mut strings) = (Vec::new(), Vec::new());
    let (mut rest, mut line) = (text, 1);
    let mut before = ' ';
    while let Some(first) = rest.chars().next() {
        let hashes = rest[first.len_utf8()..].chars().take_while(|&c| c == '#').count();
        let is_raw = first == 'r' && !(before.is_alphanumeric() || before == '_') || first == 'r' && before == 'b';
        let used = if rest.starts_with("//") {
            let end = rest.find('\n').unwrap_or(rest.len());
            let at = text.len() - rest.len();
            let begin = text[..at].rfind('\n').map_or(0, |k| k + 1);
            if text[begin..at].trim().is_empty() {
                comments.push((line, text[begin..at + end].to_owned()));
            }
            end
        } else if is_raw && rest[1 + hashes..].starts_with('"') {
            let close = format!("\"{}", "#".repeat(hashes));
            let inside = &rest[2 + hashes..];
            let end = inside.find(&close).unwrap_or(inside.len());
            strings.push((line, inside[..end].to_owned()));
            (2 + hashes + end + close.len()).min(rest.len())
        } else if first == '"' {
            let end = end_of_literal(rest, '"');
            strings.push((line, rest[1..end].trim_end_matches('"').replace("\\n", " ")));
            end
        } else if first == '\'' && (rest[1..].starts_with('\\') || rest[1..].chars().nth(1) == Some('\'')) {
            end_of_literal(rest, '\'')
        } else {
            first.len_utf8()
        };
        line += rest[..used].matches('\n').count();
        before = rest[..used].chars().next_back().unwrap_or(' ');
        rest = &rest[used..];
    }
    (comments, strings)
}

/// Bytes of a literal from its first to its last mark, with escapes.
fn end_of_literal(text: &str, mark: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            c if c == mark => return at + 1,
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str) -> Texts {
        text.lines().enumerate().map(|(k, line)| (PathBuf::from("p.md"), (k + 1, line.to_owned()))).collect()
    }

    #[test]
    fn a_turn_is_found_with_words_between_and_named_with_its_place() {
        let mut faults = Vec::new();
        let share = turns("pages", &at("plain words\nIt is Held, as it was, against the limit."), &mut faults);
        assert!((share - 1e4 / 11.0).abs() < 1e-9, "{share}");
        assert!(faults[0].contains("held .. against") && faults[1].contains("p.md:2: It is"), "{faults:?}");
        let mut none = Vec::new();
        assert!(turns("pages", &at("let told_all = stands_in; withheld against"), &mut none) < 1e-9 && none.is_empty());
    }

    #[test]
    fn sentences_end_at_marks_items_and_paragraphs() {
        let text = "# Head of it\nOne two `a b c`. Three four five\nsix:\n- seven eight nine\n- ten eleven twelve\n\n| a | b |\n```\ncode of no sentence.\n```\nThe last one here";
        let lines: Vec<(usize, &str)> = text.lines().enumerate().map(|(k, line)| (k + 1, line)).collect();
        let found: Vec<String> = sentences(&lines).into_iter().map(|s| s.1).collect();
        let expected =
            ["One two code.", "Three four five six:", "- seven eight nine", "- ten eleven twelve", "The last one here"];
        assert_eq!(found, expected);
    }

    #[test]
    fn comments_and_strings_are_found_whatever_surrounds_them() {
        let text = "/// One.\nlet a = '\"'; // no line of its own\nlet s: &'static str = \"a \\\" // b\";\n    // Two.\nlet r = r#\"raw \"text\"\"#;\nlet c = '\\'';\n";
        let (comments, strings) = comments_and_strings(text);
        assert_eq!(comments, [(1, "/// One.".to_owned()), (4, "    // Two.".to_owned())]);
        assert_eq!(strings, [(3, "a \\\" // b".to_owned()), (5, "raw \"text\"".to_owned())]);
    }

    #[test]
    fn tests_do_not_count() {
        assert_eq!(without_tests("a\n#[cfg(test)]\nmod tests {\n// b\n}"), "a\n");
        assert_eq!(without_tests("#[cfg(test)]\nmod tests;\nb"), "#[cfg(test)]\nmod tests;\nb");
        assert!(is_production(Path::new("crates/a/src/b.rs")) && !is_production(Path::new("crates/a/src/b/tests.rs")));
        assert!(!is_production(Path::new("crates/a/tests/b.rs")));
    }

    #[test]
    fn long_comment_lines_are_counted_and_the_longest_named_first() {
        let long = |n: usize| (PathBuf::from("a.rs"), (n, "x".repeat(COMMENT_COLUMNS + n)));
        let mut faults = Vec::new();
        long_lines(&vec![long(0)], &mut faults);
        assert!(faults.is_empty(), "{faults:?}");
        long_lines(&(0..=2).map(long).collect(), &mut faults);
        assert!(faults[0].starts_with("2 comment lines over 110 columns"), "{}", faults[0]);
        assert!(faults[1].contains("a.rs:2:") && faults[2].contains("a.rs:1:"), "{faults:?}");
    }
}
