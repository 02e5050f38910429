//! Every code of a diagnostic has its page in `docs/diagnostics`, and the example of the page raises it.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use proveout_nc::{CODES, Compensation, Dialect, Settings, ToolRadii, check, check_text};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics")
}

/// Text of the first fenced block of a page, and its dialect.
fn example(page: &str) -> Option<(Dialect, String)> {
    let (_, rest) = page.split_once("\n```")?;
    let (dialect, rest) = rest.split_once('\n')?;
    let (text, _) = rest.split_once("```")?;
    Some((Dialect::from_name(dialect)?, text.to_owned()))
}

#[test]
fn each_code_has_its_page_and_no_page_is_left_over() {
    let codes: BTreeSet<String> = CODES.iter().map(|info| info.code.to_owned()).collect();
    let pages: BTreeSet<String> = fs::read_dir(folder())
        .unwrap()
        .filter_map(|entry| entry.unwrap().path().file_stem().map(|s| s.to_string_lossy().into_owned()))
        .filter(|name| name != "README")
        .collect();
    assert_eq!(codes, pages);
    let index = fs::read_to_string(folder().join("README.md")).unwrap();
    for info in CODES {
        let row = format!("| [`{0}`]({0}.md) | {1} |", info.code, info.summary);
        assert!(index.contains(&row), "docs/diagnostics/README.md has no row\n{row}");
        let page = fs::read_to_string(folder().join(format!("{}.md", info.code))).unwrap();
        assert!(page.starts_with(&format!("# {}\n\n{}\n", info.code, info.summary)), "{}", info.code);
        for part in ["## Example", "## What to do"] {
            assert!(page.contains(part), "{} has no part {part}", info.code);
        }
    }
    assert_eq!(index.matches("](nc-").count(), CODES.len());
}

#[test]
fn the_example_of_each_page_raises_its_code() {
    for info in CODES {
        let page = fs::read_to_string(folder().join(format!("{}.md", info.code))).unwrap();
        if info.code == "nc-file" {
            // A path, not a text.
            assert_eq!(check("no/such/file.mpf", &Settings::default())[0].code, info.code);
            continue;
        }
        let (dialect, text) = example(&page).unwrap_or_else(|| panic!("{} has no example", info.code));
        let mut settings = Settings { dialect, ..Settings::default() };
        if info.code == "nc-compensation" {
            settings.compensation = Compensation::ToolCenter(ToolRadii::default());
        }
        let faults = check_text("example.txt", &text, &settings);
        assert!(faults.iter().any(|f| f.code == info.code), "{}: {faults:?}", info.code);
        assert!(faults.iter().all(|f| f.code == info.code), "{}: {faults:?}", info.code);
    }
}
