//! The helper program `proveout-step`: where it is, and how it runs.
//!
//! It is called without a shell, with nothing on its input. It is ended when it takes too long, takes too
//! much memory, or writes too much.

use std::{
    ffi::OsString,
    io::Read,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use crate::step_error::StepError;

/// Variable of the environment that names the program.
pub const VARIABLE: &str = "PROVEOUT_STEP";
/// Its file name on the path.
const NAME: &str = "proveout-step";
/// Version of the files that it writes.
pub(crate) const PROTOCOL: u64 = 1;
/// Time between two looks at the running program.
const LOOK: Duration = Duration::from_millis(20);
/// Error output that is kept: its end.
const MOST_WORDS: usize = 1 << 14;
/// Characters of an error that are shown.
const SHOWN: usize = 400;
/// How long the end of the error output is waited for.
const LAST_WORDS: Duration = Duration::from_secs(1);
const MIB: u64 = 1 << 20;

/// The helper, with its limits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Helper {
    /// The program.
    pub program: PathBuf,
    /// Longest time of a file.
    pub time: Duration,
    /// Most memory, MiB.
    pub memory_mib: u64,
    /// Most bytes that it may write, MiB.
    pub output_mib: u64,
}

impl Helper {
    /// A program with the usual limits: ten minutes, 8 GiB of memory, 4 GiB of files.
    pub fn new(program: PathBuf) -> Self {
        Self { program, time: Duration::from_secs(600), memory_mib: 8192, output_mib: 4096 }
    }

    /// The program that [`VARIABLE`] names; without it, the one next to the running program or on the path.
    /// None where there is none.
    ///
    /// # Errors
    /// The variable names no file.
    pub fn find() -> Result<Option<Self>, String> {
        if let Some(named) = std::env::var_os(VARIABLE).filter(|v| !v.is_empty()) {
            let program = PathBuf::from(named);
            return if program.is_file() {
                Ok(Some(Self::new(program)))
            } else {
                Err(format!("{VARIABLE} names {}, which is no file", program.display()))
            };
        }
        let beside = std::env::current_exe().ok().and_then(|exe| exe.parent().map(Path::to_path_buf));
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders = beside.into_iter().chain(std::env::split_paths(&path));
        Ok(folders.map(|folder| folder.join(file_name())).find(|file| is_program(file)).map(Self::new))
    }

    /// What it says about itself: protocol and kernel.
    ///
    /// # Errors
    /// It cannot be started, or fails.
    pub fn version(&self) -> Result<String, String> {
        let folder = tempfile::tempdir().map_err(|e| format!("no temporary folder: {e}"))?;
        let answer = folder.path().join("version");
        let out = std::fs::File::create(&answer).map_err(|e| e.to_string())?;
        let short = Self { time: Duration::from_secs(30), ..self.clone() };
        short.call(&["--version".into()], folder.path(), Stdio::from(out)).map_err(|e| e.message())?;
        let bytes = proveout_input::read_regular_file(&answer, MOST_WORDS as u64).map_err(|e| e.to_string())?;
        Ok(last_line(&bytes))
    }

    /// Lets it read a file and write into a folder.
    ///
    /// # Errors
    /// [`StepError::Helper`]: it cannot be started, has passed a limit, refused the file, or failed.
    pub(crate) fn run(&self, file: &Path, chord_um: f64, out: &Path) -> Result<(), StepError> {
        let words: [OsString; 9] = [
            "--protocol".into(),
            PROTOCOL.to_string().into(),
            "--chord-um".into(),
            chord_um.to_string().into(),
            "--memory-mib".into(),
            self.memory_mib.to_string().into(),
            "--out".into(),
            out.into(),
            file.into(),
        ];
        self.call(&words, out, Stdio::null()).map_err(|end| StepError::Helper {
            path: file.into(),
            helper: self.program.clone(),
            message: end.message(),
            help: end.help(),
        })
    }

    fn call(&self, words: &[OsString], out: &Path, answer: Stdio) -> Result<(), End> {
        let mut command = Command::new(&self.program);
        command.args(words).stdin(Stdio::null()).stdout(answer).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|e| End::NotStarted(e.to_string()))?;
        let said = listen(&mut child);
        let ended = self.wait(&mut child, out);
        if ended.is_err() {
            // It may have ended by itself since.
            let _ = child.kill();
            let _ = child.wait();
        }
        let status = ended?;
        let words = said.recv_timeout(LAST_WORDS).unwrap_or_default();
        match status.code() {
            Some(0) => Ok(()),
            Some(2) => Err(End::Refused(last_line(&words))),
            _ => Err(End::Failed(status, last_line(&words))),
        }
    }

    fn wait(&self, child: &mut Child, out: &Path) -> Result<ExitStatus, End> {
        let start = Instant::now();
        loop {
            if let Some(status) = child.try_wait().map_err(|e| End::NotStarted(e.to_string()))? {
                return Ok(status);
            }
            if start.elapsed() > self.time {
                return Err(End::Time(self.time));
            }
            if resident(child.id()).is_some_and(|bytes| bytes > self.memory_mib * MIB) {
                return Err(End::Memory(self.memory_mib));
            }
            if written(out) > self.output_mib * MIB {
                return Err(End::Output(self.output_mib));
            }
            thread::sleep(LOOK);
        }
    }
}

/// How a call ended that gave no answer.
enum End {
    NotStarted(String),
    Time(Duration),
    Memory(u64),
    Output(u64),
    Refused(String),
    Failed(ExitStatus, String),
}

impl End {
    fn message(&self) -> String {
        match self {
            Self::NotStarted(why) => format!("it cannot be started: {why}"),
            Self::Time(limit) => format!("it took longer than {} s and was ended", limit.as_secs_f64()),
            Self::Memory(mib) => format!("it took more than {mib} MiB of memory and was ended"),
            Self::Output(mib) => format!("it wrote more than {mib} MiB and was ended"),
            Self::Refused(why) if why.is_empty() => "it refuses the file and gives no reason".into(),
            Self::Refused(why) => why.clone(),
            Self::Failed(status, said) if said.is_empty() => format!("it failed ({status}) and gives no reason"),
            Self::Failed(status, said) => format!("it failed ({status}): {said}"),
        }
    }

    fn help(&self) -> String {
        match self {
            Self::NotStarted(_) => {
                format!("set {VARIABLE} to a program, or install it: pip install \"proveout[step]\"")
            }
            Self::Time(_) | Self::Memory(_) | Self::Output(_) => {
                "ask for a larger `chord_um`, leave small details out, or export the solid as STL".into()
            }
            Self::Refused(_) | Self::Failed(..) => "export it again, or as STL from the CAD system".into(),
        }
    }
}

/// Collects the end of the error output, so that the program never waits for a reader.
fn listen(child: &mut Child) -> mpsc::Receiver<Vec<u8>> {
    let (send, receive) = mpsc::channel();
    let pipe = child.stderr.take();
    thread::spawn(move || {
        let Some(mut pipe) = pipe else { return };
        let (mut kept, mut buffer) = (Vec::new(), [0; 4096]);
        while let Ok(read @ 1..) = pipe.read(&mut buffer) {
            kept.extend_from_slice(buffer.get(..read).unwrap_or_default());
            let surplus = kept.len().saturating_sub(MOST_WORDS);
            kept.drain(..surplus);
        }
        // The caller may have left.
        let _ = send.send(kept);
    });
    receive
}

/// The last line with words, without control characters.
fn last_line(said: &[u8]) -> String {
    let text = String::from_utf8_lossy(said);
    let line = text.lines().rev().map(str::trim).find(|l| !l.is_empty()).unwrap_or_default();
    line.chars().filter(|c| !c.is_control()).take(SHOWN).collect()
}

/// Memory of a process, bytes, where the system shows it.
fn resident(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| kib * 1024)
}

/// Bytes of the files in a folder.
fn written(folder: &Path) -> u64 {
    let Ok(files) = std::fs::read_dir(folder) else { return 0 };
    files.filter_map(|f| f.ok()?.metadata().ok()).map(|m| m.len()).sum()
}

fn file_name() -> String {
    format!("{NAME}{}", std::env::consts::EXE_SUFFIX)
}

#[cfg(unix)]
fn is_program(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    file.metadata().is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_program(file: &Path) -> bool {
    file.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_words_are_one_clean_line() {
        assert_eq!(last_line(b"progress\n\x1b[31mit has no solid\x1b[0m  \n\n"), "[31mit has no solid[0m");
        assert_eq!(last_line(b""), "");
        assert_eq!(last_line("x".repeat(9000).as_bytes()).len(), SHOWN);
    }
}
