use super::*;
use crate::renamed_keys::{ANY, RENAMED};

fn migrated(text: &str) -> Migration {
    migrate(Path::new("old.toml"), text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn refused(text: &str) -> String {
    match migrate(Path::new("old.toml"), text) {
        Ok(done) => panic!("accepted: {done:?}"),
        Err(e) => e.to_string(),
    }
}

/// A file of the kind that holds nothing else.
fn head(kind: InputFileKind) -> &'static str {
    match kind {
        InputFileKind::Scene => "resolution_mm = 1 # cells\r\n",
        _ => "",
    }
}

#[test]
fn every_key_is_renamed_in_all_forms_and_only_once() {
    for rename in &RENAMED {
        let name = |table: &&'static str| if *table == ANY { "flank" } else { *table };
        let tables: Vec<&str> = rename.tables.iter().map(name).collect();
        let path = tables.join(".");
        let inline =
            |key: &str| tables.iter().rev().fold(format!("{key} = 1"), |inner, t| format!("{t} = {{ {inner} }}"));
        let dotted = |key: &str| tables.iter().copied().chain([key]).collect::<Vec<_>>().join(".");
        let forms = |key: &str| {
            let mut all = vec![
                format!("{}{} = 1 # why\n", head(rename.kind), dotted(key)),
                format!("{}{}\n", head(rename.kind), inline(key)),
                format!("{}[{}]\n  a.b = 1\n", head(rename.kind), dotted(key)),
                format!("{}[ \"{}\" ]\n", head(rename.kind), dotted(key).replace('.', "\" . \"")),
            ];
            if !tables.is_empty() {
                all.push(format!("{}# {key}\n[{path}]\n\t'{key}'  =  1\n", head(rename.kind)));
                all.push(format!("{}[[{path}]]\nb = \"{key}\"\n{key}=[1,\n2]\n", head(rename.kind)));
            }
            all
        };
        for (old, new) in forms(rename.old).iter().zip(&forms(rename.new)) {
            let done = migrated(old);
            // Comments and values hold the name still.
            let same = |text: &str| text.replace(&format!("# {}", rename.old), &format!("# {}", rename.new));
            let same =
                |text: &str| same(text).replace(&format!("\"{}\"\n", rename.old), &format!("\"{}\"\n", rename.new));
            assert_eq!(same(&done.text), *new, "{old}");
            assert_eq!((done.kind, done.changes.len()), (rename.kind, 1), "{old}");
            assert_eq!((&done.changes[0].old, &done.changes[0].new), (&dotted(rename.old), &dotted(rename.new)));
            let again = migrated(&done.text);
            assert!(again.changes.is_empty() && again.text == done.text, "{old}");
        }
    }
}

#[test]
fn comments_order_and_line_ends_stay() {
    let old = "\u{feff}# Of a shop: limits, chosen\r\nname = \"limits\"\r\nresolution_mm = 0.5\t# chosen\r\n\r\n\
               [mount] # chosen\r\nchosen   = true   # nobody has measured it\r\ntranslation_mm = [0,\r\n 0, 0]\r\n\
               [limits]\r\nblocks = 1_000\r\n[compare]\r\nnote = '''\r\n[limits]\r\nshown_s = 1'''\r\nshown_s = [1, 2]\r\n\
               [[compare.choice]]\r\nkey = \"program.a.reschedule.cap_deg\" # limits.blocks\r\n[[compare.choice]]\r\n\
               key = 'limits.blocks'\r\n[[program]]\r\nname = \"cap_deg\"\r\nreschedule = { cap_deg = 4, method = \"x\" }\r\n\
               [control.limits]\r\nchosen = 1";
    let new = old
        .replace("\r\nchosen   =", "\r\nassumed   =")
        .replace("\r\n[limits]\r\nblocks", "\r\n[run_limits]\r\nblocks")
        .replace("\r\nshown_s = [", "\r\nplot_window_s = [")
        .replace("\"program.a.reschedule.cap_deg\"", "\"program.a.reschedule.max_key_lean_deg\"")
        .replace("'limits.blocks'", "'run_limits.blocks'")
        .replace("{ cap_deg = 4", "{ max_key_lean_deg = 4");
    let done = migrated(old);
    assert_eq!(done.text, new);
    let lines: Vec<(usize, &str)> = done.changes.iter().map(|c| (c.line, c.new.as_str())).collect();
    assert_eq!(
        lines,
        [
            (6, "mount.assumed"),
            (9, "run_limits"),
            (15, "compare.plot_window_s"),
            (17, "\"program.a.reschedule.max_key_lean_deg\""),
            (19, "'run_limits.blocks'"),
            (22, "program.reschedule.max_key_lean_deg"),
        ]
    );
    assert_eq!(migrated(&new).text, new);
}

#[test]
fn a_key_is_renamed_each_time_that_it_is_written() {
    let done = migrated("resolution_mm = 1\nlimits.blocks = 3\nlimits.simulated_time_s = 4\n");
    assert_eq!(done.text, "resolution_mm = 1\nrun_limits.blocks = 3\nrun_limits.simulated_time_s = 4\n");
    assert_eq!(done.changes.len(), 2);
    let done = migrated("[[tool]]\ngauge_length_is = \"measured\"\n[[tool]]\ngauge_length_is = \"prescribed\"\n");
    assert_eq!(done.changes.iter().map(|c| c.line).collect::<Vec<_>>(), [2, 4]);
}

#[test]
fn lengths_in_inch_keep_their_unit() {
    let done = migrated("unit = \"inch\"\nresolution_inch = 1\nstock = 1\n[plan.flank]\nbelow_inch = 0.1\n");
    assert!(done.text.ends_with("beyond_end_inch = 0.1\n"), "{}", done.text);
}

#[test]
fn the_same_words_of_other_files_and_tables_stay() {
    for text in [
        "inherits = \"fanuc-30i\"\n[limits]\ncall_depth = 3\n",
        "[[joint]]\nname = \"X\"\n[joint.chosen]\n\"*\" = \"usual\"\n",
        "[[tool]]\nnumber = 1\nchosen = [{ keys = [\"flutes\"], reason = \"usual\" }]\n",
        "name = \"a\"\n[[setup]]\nname = \"limits\"\n",
        "scene = \"a\"\n[[vary]]\nkey = \"machine.X.limits\"\n",
        "resolution_mm = 1\n[surface.phase]\nphases = 1\n[tolerances]\njudged = 1\n",
    ] {
        let done = migrated(text);
        assert!(done.changes.is_empty() && done.text == text, "{done:?}");
    }
    let escaped = migrated("resolution_mm = 1\n[mount]\n\"ch\\u006fsen\" = true\n");
    assert_eq!(escaped.text, "resolution_mm = 1\n[mount]\nassumed = true\n");
    let sweep = migrated("scene = \"a\"\n[[vary]]\nkey = \"limits.blocks\"\nvalues = [\"limits.blocks\"]\n");
    assert_eq!(sweep.text, "scene = \"a\"\n[[vary]]\nkey = \"run_limits.blocks\"\nvalues = [\"limits.blocks\"]\n");
}

#[test]
fn what_is_no_such_file_is_refused() {
    for (text, words) in [
        ("", "is no scene, machine, tool library"),
        ("a = 1\n", "is no scene, machine, tool library"),
        ("stock = = 1\n", "old.toml:1:9: the text is not TOML"),
        ("\0\u{1}\u{7f}", "the text is not TOML"),
        ("G1 X3\n", "the text is not TOML"),
        ("stock = 1\n[limits]\n[run_limits]\n", "by its old name and by its new one"),
        (
            "stock = 1\nmount = { chosen = true, assumed = true }\n",
            "by its old name and by its new one; remove one of them",
        ),
    ] {
        let error = refused(text);
        assert!(error.contains(words), "{text:?}: {error}");
    }
    // Deeper than any file, and long.
    let deep = format!("stock = {}1{}\n", "[".repeat(100_000), "]".repeat(100_000));
    assert!(refused(&deep).contains("the text is not TOML"));
    let deep = format!("stock = 1\n{}limits = 1\n", "a.".repeat(100_000));
    assert!(refused(&deep).contains("the text is not TOML"));
    let long = format!("stock = 1\n{}", "[[program]]\nmount.chosen = true # chosen\n".repeat(20_000));
    let done = migrated(&long);
    assert_eq!((done.changes.len(), done.changes[19_999].line), (20_000, 40_001));
}

/// Any bytes that are text, cut and mixed: an answer, and the answer is TOML.
#[test]
fn no_text_leads_to_a_panic() {
    let seed = "stock = 1\n[mount]\n\"chosen\" = true\n[plan.flank] # a\ntimed_by = 'x'\n[limits]\na.b = { limits.chosen = [1, {}] }\n";
    let pieces: Vec<char> = seed.chars().chain("\u{feff}\r\\\"'''{}[]=.,#é\0".chars()).collect();
    let mut state = 12_345_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize
    };
    for _ in 0..3_000 {
        let mut text: Vec<char> = seed.chars().collect();
        for _ in 0..1 + next() % 4 {
            let at = next() % text.len();
            match next() % 3 {
                0 => text[at] = pieces[next() % pieces.len()],
                1 => text.insert(at, pieces[next() % pieces.len()]),
                _ => text.truncate(at.max(1)),
            }
        }
        let text: String = text.into_iter().collect();
        if let Ok(done) = migrate(Path::new("f"), &text) {
            assert!(DeTable::parse(&done.text).is_ok(), "{text:?}");
            assert!(migrated(&done.text).changes.is_empty(), "{text:?}");
        }
    }
}
