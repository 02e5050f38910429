//! A small scene of its own in a temporary folder, and the program started in it with limits of time and
//! memory.

use std::{
    fs,
    io::Read,
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use tempfile::TempDir;

/// Wall time after which a call counts as hung.
pub(crate) const HUNG: Duration = Duration::from_secs(120);
/// Address space that a call may take, KiB: what a run may announce, and what the process is made of besides.
const MEMORY_KIB: u64 = 8 << 20;

/// What a call gave.
#[derive(Debug)]
pub(crate) struct Told {
    pub(crate) status: ExitStatus,
    /// Standard output and standard error, one after the other.
    pub(crate) text: String,
    pub(crate) wall: Duration,
}

impl Told {
    /// Exit code; none where the process was killed by a signal.
    pub(crate) fn code(&self) -> Option<i32> {
        self.status.code()
    }
}

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// Starts the program; none where it was still running after `most`, and was killed. After `processor_s` of
/// processor time the system ends it with a signal.
pub(crate) fn proveout_within(folder: &Path, arguments: &[&str], most: Duration, processor_s: u64) -> Option<Told> {
    let begin = Instant::now();
    let mut call = if cfg!(unix) {
        let mut shell = Command::new("sh");
        shell.args([
            "-c",
            &format!("ulimit -v {MEMORY_KIB} && ulimit -t {processor_s} && exec \"$0\" \"$@\""),
            env!("CARGO_BIN_EXE_proveout"),
        ]);
        shell
    } else {
        Command::new(env!("CARGO_BIN_EXE_proveout"))
    };
    call.current_dir(folder).args(arguments).env("RUST_BACKTRACE", "0");
    let mut child = call.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let read = |mut from: Box<dyn Read + Send>| {
        thread::spawn(move || {
            let mut text = Vec::new();
            from.read_to_end(&mut text).ok();
            String::from_utf8_lossy(&text).into_owned()
        })
    };
    let out = read(Box::new(child.stdout.take().expect("piped")));
    let err = read(Box::new(child.stderr.take().expect("piped")));
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if begin.elapsed() > most {
            child.kill().ok();
            child.wait().ok();
            return None;
        }
        thread::sleep(Duration::from_millis(5));
    };
    let text = out.join().expect("read") + &err.join().expect("read");
    Some(Told { status, text, wall: begin.elapsed() })
}

/// The same, and it must end.
pub(crate) fn proveout(folder: &Path, arguments: &[&str]) -> Told {
    let output =
        proveout_within(folder, arguments, HUNG, HUNG.as_secs()).unwrap_or_else(|| panic!("{arguments:?} hangs"));
    assert!(!output.text.contains("panicked"), "{arguments:?}: {}", output.text);
    assert!(output.code().is_some(), "{arguments:?} was killed by a signal: {}", output.text);
    output
}

/// A folder with a small scene: a block of 40 x 40 x 20 mm, a machine and tools of its own.
pub(crate) struct Workshop(TempDir);

pub(crate) const PROGRAM: &str =
    "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z-2 F500\nX10\nG0 Z50\nM30\n";

impl Workshop {
    pub(crate) fn new() -> Self {
        let shop = Self(tempfile::tempdir().expect("temporary folder"));
        let copy = |from: &str, to: &str| {
            fs::copy(root().join(from), shop.path().join(to)).expect("a file of the tree");
        };
        fs::create_dir(shop.path().join("machine")).expect("made");
        copy("machines/spinner-u5-620/machine.toml", "machine/machine.toml");
        copy("tools/cone-frustum.toml", "tools.toml");
        shop.write("program.mpf", PROGRAM);
        shop.scene("");
        shop
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path().join(name), text).expect("written");
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Writes the scene with more lines after its own.
    pub(crate) fn scene(&self, more: &str) {
        self.write(
            "scene.toml",
            format!(
                "name = \"small\"\nmachine = \"machine\"\ntools = \"tools.toml\"\nresolution_mm = 1.0\n\n\
                 [stock]\nbox = {{ min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }}\n\n\
                 [mount]\ntranslation_mm = [0, 0, 140]\n\n[work_offsets.G54]\nZ_mm = 140\n\n\
                 [[program]]\nname = \"main\"\nfile = \"program.mpf\"\n\n{more}\n"
            ),
        );
    }

    /// Changes the text of a file.
    pub(crate) fn replace(&self, name: &str, from: &str, to: &str) {
        let text = self.read(name);
        assert!(text.contains(from), "{from:?} is not in {name}");
        self.write(name, text.replacen(from, to, 1));
    }

    pub(crate) fn call(&self, arguments: &[&str]) -> Told {
        proveout(self.path(), arguments)
    }

    pub(crate) fn run(&self) -> Told {
        self.call(&["run", ".", "--output", "result", "--rerun", "off", "--threads", "1"])
    }

    /// Runs and asserts that it is refused with exit code 2 and all of `words`, at once.
    pub(crate) fn refused(&self, words: &[&str]) -> Told {
        let output = self.run();
        assert_eq!(output.code(), Some(2), "{}", output.text);
        for word in words {
            assert!(output.text.contains(word), "{word:?} is not in:\n{}", output.text);
        }
        output
    }
}
