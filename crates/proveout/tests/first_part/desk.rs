//! A folder of a user, calls of the program in it, and their output.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
};

use serde_json::Value;
use tempfile::TempDir;

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// A folder of a user with programs of `tests/first-part`.
pub(crate) struct Desk(pub(crate) TempDir);

impl Desk {
    pub(crate) fn new(programs: &[&str]) -> Self {
        let desk = Self(tempfile::tempdir().expect("temporary folder"));
        for name in programs {
            fs::copy(root().join("tests/first-part").join(name), desk.path(name)).expect("copied");
        }
        std::os::unix::fs::symlink(root().join("machines"), desk.path("machines")).expect("a link");
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("written");
    }

    pub(crate) fn call(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.0.path())
            .args(line.split_whitespace())
            .stdin(Stdio::null())
            .output()
            .expect("the program starts")
    }

    /// The call did its work; what it printed.
    pub(crate) fn done(&self, line: &str) -> String {
        let output = self.call(line);
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(0), "{line}\n{text}");
        text
    }

    /// The call is refused with these words, and nothing is made.
    pub(crate) fn refused(&self, line: &str, words: &[&str]) -> String {
        let before = self.names();
        let output = self.call(line);
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{line}\n{text}");
        for word in words {
            assert!(text.contains(word), "{word:?} is not in:\n{text}");
        }
        assert_eq!(text.matches("error: ").count(), 1, "one clear answer:\n{text}");
        assert_eq!(self.names(), before, "nothing is written");
        text
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .expect("readable")
            .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// Runs a scene; its verdict.
    pub(crate) fn verdict(&self, scene: &str) -> Value {
        let output = self.call(&format!("run {scene} --rerun off --output out/{scene}"));
        assert!(matches!(output.status.code(), Some(0 | 1 | 3)), "{}", printed(&output));
        let text = fs::read_to_string(self.path(&format!("out/{scene}/verdict.json"))).expect("written");
        serde_json::from_str(&text).expect("JSON")
    }
}

pub(crate) fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

/// State of a gate, and why.
pub(crate) fn gate(verdict: &Value, name: &str) -> (String, String) {
    let gates = verdict["gates"].as_array().expect("gates");
    let gate = gates.iter().find(|g| g["name"] == name).unwrap_or_else(|| panic!("no gate {name}"));
    (gate["state"].as_str().unwrap_or_default().to_owned(), gate["reason"].as_str().unwrap_or_default().to_owned())
}

/// A gate that nothing keeps open but workholding and lengths of tools, which are not stated.
pub(crate) fn open_by_setup_alone(verdict: &Value, name: &str) {
    let (state, reason) = gate(verdict, name);
    let alone = ["no workholding in the scene", "assumed: the holder"]
        .iter()
        .any(|w| reason.contains(&format!("not checked: {w}")));
    assert!(state == "unchecked" && alone, "{name}: {state}: {reason}");
}

/// Nothing that the setup would cause: no overtravel, no collision, no rapid in material; material was cut.
pub(crate) fn believable(verdict: &Value) {
    let errors: Vec<String> = verdict["findings"]
        .as_array()
        .expect("findings")
        .iter()
        .filter(|f| f["severity"] == "error")
        .map(|f| format!("{}: {} {}", f["code"], f["line"], f["message"]))
        .collect();
    assert!(errors.is_empty(), "{}", errors.join("\n"));
    assert!(verdict["removal"]["volume_mm3"].as_f64().expect("a volume") > 100.0, "{}", verdict["removal"]);
    assert_eq!(gate(verdict, "limits").0, "pass", "{:?}", gate(verdict, "limits"));
}
