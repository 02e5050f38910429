//! Scene, machine and tools are read in one place: the same fault has the same words in each of them, with
//! place, value, limit, remedy.

use std::fs;

use crate::hostile::workshop::Workshop;

const FILES: [&str; 3] = ["scene.toml", "machine/machine.toml", "tools.toml"];

/// What is wrong with a file, and what is reported of it but for the name of the file.
struct Fault {
    name: &'static str,
    /// Makes it in a file of the workshop.
    spoil: fn(&Workshop, &str),
    /// Lines that are reported, FILE for the file.
    expected: &'static [&'static str],
}

/// The text of a file with another first line; a description of its own makes way.
fn begin(shop: &Workshop, file: &str, line: &[u8]) {
    let text = shop.read(file);
    let rest: String = text.lines().filter(|l| !l.starts_with("description =")).map(|l| format!("{l}\n")).collect();
    shop.write(file, [line, b"\n", rest.as_bytes()].concat());
}

fn replaced(shop: &Workshop, file: &str, by: impl FnOnce(&std::path::Path)) {
    let path = shop.path().join(file);
    fs::remove_file(&path).expect("removed");
    by(&path);
}

const FAULTS: [Fault; 11] = [
    Fault {
        name: "typo",
        spoil: |shop, file| begin(shop, file, b"description2 = \"a part\""),
        expected: &[
            "error: `description2` is not a known key [input-unknown-key]",
            "  at FILE:1:1",
            "   | description2 = \"a part\"",
            "   | ^^^^^^^^^^^^",
            "  help: did you mean `description`?",
        ],
    },
    Fault {
        name: "wrong type",
        spoil: |shop, file| begin(shop, file, b"description = 7"),
        expected: &[
            "error: `description` = 7: must be text in quotes [input-wrong-type]",
            "  at FILE:1:15",
            "   | description = 7",
            "   |               ^",
            "  help: write it in quotes",
        ],
    },
    Fault {
        name: "syntax",
        spoil: |shop, file| begin(shop, file, b"description = = 7"),
        expected: &["error: the text is not TOML: ", "  at FILE:1:15", "  help: correct the text at this place"],
    },
    Fault {
        name: "twice",
        spoil: |shop, file| begin(shop, file, b"description = \"a\"\ndescription = \"b\""),
        expected: &[
            "error: the text is not TOML: duplicate key",
            "  at FILE:2:1",
            "  help: correct the text at this place",
        ],
    },
    Fault {
        name: "out of range",
        spoil: |shop, file| {
            let key =
                ["Z_mm = 140", "radius_mm = ", "diameter_mm = "][FILES.iter().position(|f| *f == file).expect("one")];
            let name = key.split(' ').next().expect("a key");
            shop.replace(file, key, &format!("{name} = 1e9 # "));
        },
        expected: &[
            "_mm` = 1e9: is out of range: -100000 to 100000 [input-out-of-range]",
            "_mm = 1e9",
            " ^^^",
            "  help: check the value and the unit of its key",
        ],
    },
    Fault {
        name: "a list too long",
        spoil: |shop, file| match file {
            "scene.toml" => shop.replace(file, "min_mm = [-20, -20, -20]", "min_mm = [-20, -20, -20, 7]"),
            "tools.toml" => {
                let text =
                    shop.read(file) + "\n[tool.residual]\nra_um = [0, 1, 2]\nrz_um = [0, 1]\nsource = \"a trial\"\n";
                shop.write(file, text);
            }
            _ => shop.replace(file, "normal = [0, 0, 1]", "normal = [0, 0, 1, 7]"),
        },
        expected: &["]: must be a list of ", " values [input-wrong-type]", "  help: write a list of "],
    },
    Fault {
        name: "not UTF-8",
        spoil: |shop, file| begin(shop, file, b"description = \"\xb5m\""),
        expected: &[
            "error: the text is not UTF-8: byte 0xb5 begins no character [input-unreadable]",
            "  at FILE:1:16",
            "  help: save the file as UTF-8",
        ],
    },
    Fault {
        name: "nothing in it",
        spoil: |shop, file| shop.write(file, ""),
        expected: &[
            "error: the file holds no key [input-empty]",
            "  at FILE:1:1",
            "  help: write a file that matches docs/schemas, or name another file",
        ],
    },
    Fault {
        name: "a folder",
        spoil: |shop, file| replaced(shop, file, |path| fs::create_dir(path).expect("made")),
        expected: &[
            "error: the file cannot be read: it is a folder, not a file [input-unreadable]",
            "  at FILE",
            "  help: name a file",
        ],
    },
    Fault {
        name: "a pipe",
        spoil: |shop, file| {
            replaced(shop, file, |path| {
                assert!(std::process::Command::new("mkfifo").arg(path).status().is_ok_and(|s| s.success()), "mkfifo");
            });
        },
        expected: &[
            "error: the file cannot be read: it is a pipe, a device or a socket, not a regular file [input-unreadable]",
            "  at FILE",
            "  help: save it as a file of its own and name that",
        ],
    },
    Fault {
        name: "too large",
        spoil: |shop, file| {
            let path = shop.path().join(file);
            fs::File::options().write(true).open(path).expect("open").set_len((16 << 20) + 1).expect("as long as that");
        },
        expected: &[
            "error: the file cannot be read: it has 16777217 bytes or more; files of this kind may have 16777216 [input-unreadable]",
            "  at FILE",
            "  help: leave out what does not belong to it",
        ],
    },
];

#[cfg(unix)]
#[test]
fn one_fault_has_the_same_words_in_scene_machine_and_tools() {
    for fault in FAULTS {
        let mut first: Option<String> = None;
        for file in FILES {
            let shop = Workshop::new();
            (fault.spoil)(&shop, file);
            let output = shop.refused(&[]);
            for line in fault.expected {
                let line = line.replace("FILE", &format!("./{file}"));
                assert!(output.text.contains(&line), "{} in {file}: {line:?} is not in:\n{}", fault.name, output.text);
            }
            // Key, value and line are those of the file; everything else is the same to the letter.
            if fault.expected.iter().any(|line| line.starts_with("error: ")) {
                let shown = |l: &&str| l.starts_with("error: ") || l.starts_with("  help: ");
                let words: Vec<&str> = output.text.lines().filter(shown).collect();
                let words = words.join("\n");
                assert_eq!(first.get_or_insert_with(|| words.clone()), &words, "{} in {file}", fault.name);
            }
        }
    }
}

/// Files that a call names besides: none of them is waited for.
#[cfg(unix)]
#[test]
fn no_pipe_is_waited_for_wherever_it_stands() {
    let pipe = |shop: &Workshop, name: &str| {
        let path = shop.path().join(name);
        fs::remove_file(&path).ok();
        assert!(std::process::Command::new("mkfifo").arg(path).status().is_ok_and(|s| s.success()), "mkfifo");
    };
    let stock = "box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }";
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    pipe(&shop, "pipe.toml");
    shop.scene("[control]\nfile = \"pipe.toml\"");
    shop.refused(&["pipe.toml", "not a regular file"]);
    shop.scene("");
    pipe(&shop, "pipe.dexel");
    shop.replace("scene.toml", stock, "from_run = \"pipe.dexel\"");
    shop.refused(&["pipe.dexel", "not a regular file"]);
    shop.scene("");
    shop.replace("scene.toml", stock, "mesh = \"pipe.dexel\"");
    shop.refused(&["pipe.dexel"]);
    shop.scene("");
    for name in ["pipe.sdf", "pipe.x3p", "pipe.smd", "pipe.csv"] {
        pipe(&shop, name);
    }
    let calls: [&[&str]; 8] = [
        &["measure", "pipe.dexel", "--section", "z=-1"],
        &["measure", "--profile", "pipe.smd"],
        &["measure", "pipe.sdf"],
        &["measure", "pipe.x3p"],
        &["check", "pipe.toml"],
        &["nc", "pipe.csv"],
        &["nc", "program.mpf", "--control", "pipe.toml"],
        &["sign", "result", "--key", "pipe.csv"],
    ];
    for call in calls {
        let output = shop.call(call);
        assert_eq!(output.code(), Some(2), "{call:?}: {}", output.text);
    }
    // In a run folder: the verdict, what a file of the manifest has become, what says where the scene is.
    pipe(&shop, "result/verdict.json");
    let output = shop.call(&["diff", "result", "result"]);
    assert_eq!(output.code(), Some(2), "{}", output.text);
    pipe(&shop, "result/run.json");
    let output = shop.call(&["verify", "result"]);
    assert_eq!(output.code(), Some(1), "{}", output.text);
    assert!(output.text.contains("verdict.json"), "{}", output.text);
    pipe(&shop, "result/manifest.sig");
    let output = shop.call(&["verify", "result", "--public-key", "pipe.csv"]);
    assert_eq!(output.code(), Some(2), "{}", output.text);
    pipe(&shop, "result/manifest.json");
    let output = shop.call(&["verify", "result"]);
    assert_eq!(output.code(), Some(2), "{}", output.text);
}
