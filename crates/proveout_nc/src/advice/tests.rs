use super::whole_text::{end, frame, tool_radius};
use super::{Advice, AdviceCall};
use crate::control::Control;
use crate::settings::{Dialect, Settings};

fn advice(text: &str) -> Advice {
    let call = AdviceCall { settings: Settings::default(), inherits: None, complete: &|settings| settings };
    Advice::of_text("part.nc", text, &call).unwrap_or_else(|_| panic!("no program: {text}"))
}

#[test]
fn a_text_that_is_read_needs_nothing() {
    let advice = advice("G21 G90 G54\nG0 X0. Y0. Z5.\nM30\n");
    assert!(advice.needs_nothing() && advice.reads());
    assert_eq!(advice.to_string(), "");
}

#[test]
fn a_statement_has_its_reason_its_count_and_its_place() {
    let advice = advice("G21 G90 G54\nG0 X0. Y0. Z5.\nG1 Z-1.\nX5. F240.\nM30\n");
    let feed = advice.statements.iter().find(|s| s.key == "feed.missing_mm_min").expect("a feed");
    assert_eq!((feed.value.as_str(), feed.count, feed.first.1), ("240", 1, 3));
    assert_eq!(feed.line, "G1 Z-1.");
    assert!(feed.why.contains("240 mm/min"), "{}", feed.why);
    let file = advice.control_file();
    assert!(
        file.contains("[assumed]\n\"feed.missing_mm_min\" = ") || file.contains("\"feed.missing_mm_min\" = "),
        "{file}"
    );
}

#[test]
fn a_written_file_leaves_its_text_unconfirmed() {
    let text = "G21 G90 G54\nG0 X0. Y0. Z5.\nG1 Z-1.\nX5. F240.\nM30\n";
    let file = advice(text).control_file().to_owned();
    let control = Control::from_text("written.toml", &file, None).expect("a control file");
    assert_eq!(control.dialect(), Dialect::Iso);
    let settings = Settings::of_control(control);
    let commands = crate::Program::from_text("part.nc", text, &settings).expect("read");
    let assumed: Vec<String> = commands
        .filter_map(|command| match command.expect("a command").op {
            crate::Op::Note(note) => note.assumption().map(str::to_owned),
            _ => None,
        })
        .collect();
    assert!(
        assumed.iter().any(|text| text.contains("`feed.missing_mm_min`") && text.contains("not confirmed")),
        "{assumed:?}"
    );
    // Confirmed: the table goes, and with it these assumptions.
    let confirmed = file.split("\n[assumed]\n").next().unwrap_or_default();
    let control = Control::from_text("written.toml", confirmed, None).expect("a control file");
    assert!(control.assumed().is_empty());
}

#[test]
fn a_child_that_states_a_key_ends_the_assumption_of_its_parent() {
    let folder = std::env::temp_dir().join(format!("proveout-advice-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    std::fs::write(
        folder.join("guess.toml"),
        "dialect = \"fanuc\"\nfeed = { missing = \"value\", missing_mm_min = 100 }\narcs.centers = \"absolute\"\n\
         [assumed]\n\"feed.missing_mm_min\" = \"first F\"\n\"arcs.centers\" = \"they close\"\n",
    )
    .expect("written");
    let control = |text: &str| Control::from_text("mill.toml", text, Some(&folder)).map_err(|e| e.to_string());
    let child =
        control("inherits = \"guess.toml\"\nfeed = { missing = \"value\", missing_mm_min = 200 }\n").expect("read");
    assert_eq!(child.assumed().keys().collect::<Vec<_>>(), ["arcs.centers"]);
    let wrong =
        control("dialect = \"fanuc\"\n[assumed]\n\"arcs.centers\" = \"they close\"\n").expect_err("no such key");
    assert!(wrong.contains("the file has no key arcs.centers"), "{wrong}");
    let empty = control("dialect = \"fanuc\"\narcs.centers = \"absolute\"\n[assumed]\n\"arcs.centers\" = \" \"\n");
    assert!(empty.expect_err("no reason").contains("the reason is empty"));
    std::fs::remove_dir_all(&folder).ok();
}

#[test]
fn a_wrong_arc_among_good_ones_stays_wrong() {
    let text = "G21 G90 G54\nG0 X10. Y0. Z5.\nG1 Z-1. F200.\nG3 X0. Y10. I-10. J0.\nG3 X-10. Y0. I0. J-12.\nG1 X-20. Y0.\nM30\n";
    let advice = advice(text);
    assert!(!advice.reads() && advice.statements.is_empty(), "{advice}");
    assert_eq!(advice.left[0].code, "nc-arc-radius");
}

#[test]
fn ends_frames_and_tools_are_read_from_the_text() {
    let fault = |text: &str, code: &'static str, line: u32| crate::Diagnostic {
        code,
        message: String::new(),
        file: "part.nc".into(),
        line,
        column: 1,
        length: 0,
        help: None,
        source_line: text.lines().nth(line as usize - 1).unwrap_or_default().into(),
        about: None,
    };
    for (text, ended) in [
        ("G0 X1\nG1 Z-1\nM5\n", true),
        ("G0 X1\nG1 Z-1\nG0 Z5\n%\n", true),
        ("G0 X1\nG1 Z-1\nG53 G0 Z0\n", true),
        ("G0 X1\nG1 Z-1\nX5\n", false),
        ("G0 X1\nM50\nG1 Z-1\n", false),
        ("G0 X1\nG1 Z-1 (M5)\n", false),
    ] {
        let line = text.lines().count() as u32;
        assert_eq!(end(&fault(text, "nc-no-end", line), &[text.to_owned()]).is_some(), ended, "{text}");
    }
    let text = "Shop listing of today\nO1\nG0 X1\nM30\n";
    let found = frame(&fault(text, "nc-syntax", 1), &[text.to_owned()]).expect("a head");
    assert_eq!((found.0, found.1.as_str()), ("program.header", "[\"Shop listing of today\"]"));
    let text = "O1\nG0 X1\nWRONG WORD\nM30\n";
    assert_eq!(frame(&fault(text, "nc-syntax", 3), &[text.to_owned()]), None);
    assert_eq!(tool_radius(&["(T1 D=10. CR=0.)\nG0 X1\n(D=10.)".to_owned()]), Some(5.0));
    assert_eq!(tool_radius(&["(T1 D=10.)\n(T2 D=8.)".to_owned()]), None);
}
