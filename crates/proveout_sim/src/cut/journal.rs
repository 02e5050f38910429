//! The journal of a run: what its sweeps did, so that a run that was stopped goes on where it was.
//!
//! A run is decided by its inputs. What takes its time over and over is the cutting, and that is written
//! down, call by call of the sweeps. A run that goes on plans its motion, follows its bodies and judges as
//! any other run does; only where it would cut, it takes what the journal says, until that ends. So
//! everything besides the stock is in the state in which it was because it was brought there in the same way,
//! and the run folder has the same bytes as that of a run that was never stopped.
//!
//! ```text
//!   a line of text   PROVEOUT-JOURNAL 2
//!   a line of JSON   what the run was begun with: version, choices of the call, inputs with their SHA-256
//!   records          length (4 bytes), begin of the SHA-256 of the content (8), content:
//!                      1   what is known of the run of depths under way (see [`DepthsTold`])
//!                     16   begin of the SHA-256 of the motion that was swept
//!                      .   what became of patches and stock, reports, depths (`SweepLog`)
//! ```
//!
//! A record is handed to the system in one piece when its sweeps are done: a process that is killed
//! leaves all records but the last one, and a record that is cut off is ignored. The last record is
//! not trusted but cut again: this detects a program that cuts differently from the one that began.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{BufRead, BufReader, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};

use proveout_stock::{Measure, SweepItem, SweepLog, SweepReplay, SweepReport};
use sha2::{Digest, Sha256};

use crate::{
    cut::cutting::Cutting,
    evidence::manifest::relative,
    prepare::{choice::Choice, prepared::Prepared},
};

pub use crate::cut::journal_error::JournalError;

/// First line.
const MAGIC: &str = "PROVEOUT-JOURNAL 2\n";
/// Longest second line, bytes.
const MOST_BEGUN: u64 = 64 << 20;
/// Bytes before the content of a record: its length and its digest.
const HEAD: usize = 12;
/// Largest journal: past it the run goes on without.
const MOST_BYTES: u64 = 16 << 30;
/// Largest record.
const MOST_RECORD: usize = 1 << 30;

/// Whether a record contains the memory of the run of depths; first byte of its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DepthsTold {
    /// It is that of the record before.
    Same = 0,
    /// It is in the record.
    Here = 1,
    /// It is another one, and not in the record, since it has grown larger than all that was
    /// written since it was last recorded: a run cannot go on after this record.
    Not = 2,
}

/// With what a run was begun: everything that decides its result, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Begun(Vec<(String, String)>);

impl Begun {
    /// Of a run that is ready, and the call that chose it.
    pub fn of(prepared: &Prepared, choice: &Choice) -> Self {
        let mut all = vec![
            ("the version".to_owned(), format!("proveout {}", env!("CARGO_PKG_VERSION"))),
            ("the program".to_owned(), prepared.program_name.clone()),
            ("--resolution-mm".to_owned(), given(choice.resolution_mm.as_ref())),
            ("--dynamics".to_owned(), given(choice.dynamics.as_ref())),
            ("--plant".to_owned(), given(choice.plant.as_ref())),
            ("--preview".to_owned(), choice.preview.to_string()),
            ("--stop-at".to_owned(), given(choice.stop_at.as_ref())),
            ("--orientation-maps".to_owned(), choice.free_axes.to_string()),
            ("--set".to_owned(), choice.set.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
            ("the overhang of tools".to_owned(), format!("{:?} {:?}", choice.clamped_out_mm, choice.least_overhang_mm)),
        ];
        let files = prepared.inputs.iter().map(|file| {
            let path = relative(&prepared.scene.folder, &file.path);
            (format!("the file of {}", file.role), format!("{path} with SHA-256 {}", file.sha256))
        });
        all.extend(files);
        Self(all)
    }

    /// The first difference from what a run was begun with.
    fn compared(&self, then: &Self) -> Result<(), JournalError> {
        let value = |of: &Self, name: &str| {
            of.0.iter().find(|(n, _)| n == name).map_or_else(|| "not there".to_owned(), |(_, v)| v.clone())
        };
        let names = self.0.iter().chain(&then.0).map(|(name, _)| name);
        for name in names {
            let [now, then] = [value(self, name), value(then, name)];
            if now != then {
                return Err(JournalError::Other { what: name.clone(), then, now });
            }
        }
        // Names that occur twice.
        if self.0 == then.0 {
            return Ok(());
        }
        let [then, now] = [then, self].map(|b| format!("{} entries", b.0.len()));
        Err(JournalError::Other { what: "the list of inputs".into(), then, now })
    }
}

fn given(value: Option<&impl std::fmt::Debug>) -> String {
    value.map_or_else(|| "not given".to_owned(), |v| format!("{v:?}"))
}

/// The journal of a run under way; locked against other runs.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Records from here to `until` are taken instead of cutting.
    at: u64,
    until: u64,
    /// End of the file.
    end: u64,
    /// Bytes of records since the memory of the depths was last recorded.
    since_told: u64,
    /// [`Depths::taken`](proveout_stock::Depths::taken) when it was last recorded.
    told: u64,
    fault: Option<JournalError>,
    given_up: Option<String>,
    /// Nothing is recorded; the file keeps other runs away.
    empty: bool,
}

impl Journal {
    /// Begins a journal; an older one goes.
    ///
    /// # Errors
    /// When another run uses it, or the system refuses.
    pub fn begin(path: &Path, begun: &Begun) -> Result<Self, JournalError> {
        let system = |source| JournalError::System { path: path.to_owned(), what: "made", source };
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let mut file = locked(options.map_err(system)?, path)?;
        let mut head = MAGIC.as_bytes().to_vec();
        head.extend(serde_json::to_vec(&begun.0).map_err(|e| system(e.into()))?);
        head.push(b'\n');
        file.set_len(0).and_then(|()| file.write_all(&head)).map_err(system)?;
        Ok(Self::at(path, file, head.len() as u64, head.len() as u64))
    }

    /// Goes on with a journal that was left.
    ///
    /// # Errors
    /// When there is none, it is of another run or in use, or the system refuses.
    pub fn go_on(path: &Path, begun: &Begun) -> Result<Self, JournalError> {
        let system = |source| JournalError::System { path: path.to_owned(), what: "read", source };
        if !path.is_file() {
            return Err(JournalError::Missing { path: path.to_owned() });
        }
        let file = OpenOptions::new().read(true).write(true).open(path).map_err(system)?;
        let file = locked(file, path)?;
        let mut input = BufReader::with_capacity(1 << 20, &file);
        let foreign = || JournalError::NoJournal { path: path.to_owned() };
        let mut magic = vec![0; MAGIC.len()];
        let mut line = Vec::new();
        let read = input.read_exact(&mut magic).is_ok()
            && magic == MAGIC.as_bytes()
            && input.by_ref().take(MOST_BEGUN).read_until(b'\n', &mut line).is_ok_and(|_| line.ends_with(b"\n"));
        if !read {
            return Err(foreign());
        }
        let then = serde_json::from_slice(&line).map_err(|_not_ours| foreign())?;
        begun.compared(&Begun(then))?;
        let first = (MAGIC.len() + line.len()) as u64;
        let (mut end, mut until) = (first, first);
        while let Some(content) = next_record(&mut input).map_err(system)? {
            end += (HEAD + content.len()) as u64;
            if content.first().is_some_and(|told| *told != DepthsTold::Not as u8) {
                until = end;
            }
        }
        drop(input);
        file.set_len(until).map_err(system)?;
        (&file).seek(SeekFrom::Start(until)).map_err(system)?;
        Ok(Self::at(path, file, first, until))
    }

    fn at(path: &Path, file: File, at: u64, until: u64) -> Self {
        let path = path.to_owned();
        Self { path, file, at, until, end: until, since_told: 0, told: 0, fault: None, given_up: None, empty: false }
    }

    /// The same without records: it only keeps other runs out of the folder.
    #[must_use]
    pub fn kept_empty(self) -> Self {
        Self { empty: true, ..self }
    }

    /// Bytes that are left to be taken instead of cutting.
    pub fn left(&self) -> u64 {
        self.until - self.at
    }

    /// What was found wrong while its records were taken; the result of the run is then none.
    pub(crate) fn take_fault(&mut self) -> Option<JournalError> {
        self.fault.take()
    }

    /// Why the journal was given up, where it was: the run is not spoiled, but could not go on.
    pub(crate) fn given_up(&self) -> Option<String> {
        self.given_up.clone()
    }

    /// Cuts, or takes what is written about it.
    pub(crate) fn sweep(
        &mut self,
        cutting: &mut Cutting<'_>,
        items: &[SweepItem<'_>],
        measures: &[Measure],
    ) -> Vec<SweepReport> {
        if self.empty || self.given_up.is_some() || self.fault.is_some() {
            return cutting.sweep(items, measures);
        }
        if self.at == self.until {
            let (content, reports) = self.cut(cutting, items, measures);
            match self.write(&content) {
                Ok(()) => self.count(&content, cutting),
                Err(why) => self.give_up(&why),
            }
            return reports;
        }
        let known = match self.read() {
            Ok(content) => content,
            Err(what) => return self.unfit(&what, cutting, items, measures),
        };
        self.at += (HEAD + known.len()) as u64;
        if known.get(1..17) != Some(&motion(items, measures)[..]) {
            return self.unfit("its motion differs", cutting, items, measures);
        }
        if self.at == self.until {
            let (content, reports) = self.cut(cutting, items, measures);
            if content != known {
                let what = "the version that wrote it cuts differently from this one".to_owned();
                self.fault = Some(JournalError::Unfit { path: self.path.clone(), what });
            }
            // Records are written after it from now on.
            if let Err(e) = self.file.seek(SeekFrom::Start(self.until)) {
                self.give_up(&e.to_string());
            }
            self.count(&content, cutting);
            return reports;
        }
        match replayed(&known, cutting) {
            Ok(reports) if reports.len() == items.len() => {
                self.count(&known, cutting);
                reports
            }
            Ok(_) => self.unfit("it reports on other sweeps", cutting, items, measures),
            Err(e) => self.unfit(&e.to_string(), cutting, items, measures),
        }
    }

    fn unfit(
        &mut self,
        what: &str,
        cutting: &mut Cutting<'_>,
        items: &[SweepItem<'_>],
        measures: &[Measure],
    ) -> Vec<SweepReport> {
        self.fault = Some(JournalError::Unfit { path: self.path.clone(), what: what.to_owned() });
        // The run ends after this stretch; its reports have to be there.
        cutting.sweep(items, measures)
    }

    /// Cuts, and gives the content of its record.
    fn cut(
        &self,
        cutting: &mut Cutting<'_>,
        items: &[SweepItem<'_>],
        measures: &[Measure],
    ) -> (Vec<u8>, Vec<SweepReport>) {
        let first = items.iter().map(|i| i.id).min().unwrap_or(0);
        let before: Vec<_> = cutting.patches.iter().map(|p| p.stock().before_sweep()).collect();
        let stock_before = cutting.stock.before_sweep();
        let reports = cutting.sweep(items, measures);
        let mut log = SweepLog::default();
        for (patch, before) in cutting.patches.iter().zip(before) {
            log.stock(patch.stock(), before, first);
        }
        log.stock(cutting.stock, stock_before, first);
        log.reports(&reports);
        let told = if cutting.depths.taken() == self.told {
            DepthsTold::Same
        } else if cutting.depths.bytes() <= self.since_told + log.len() {
            log.depths(cutting.depths);
            DepthsTold::Here
        } else {
            DepthsTold::Not
        };
        let mut content = vec![told as u8];
        content.extend(motion(items, measures));
        content.extend(log.into_bytes());
        (content, reports)
    }

    /// Counts the bytes of a record, and notes whether it contains the memory of the depths.
    fn count(&mut self, content: &[u8], cutting: &Cutting<'_>) {
        self.since_told += (HEAD + content.len()) as u64;
        if content.first() == Some(&(DepthsTold::Here as u8)) {
            (self.since_told, self.told) = (0, cutting.depths.taken());
        }
    }

    fn write(&mut self, content: &[u8]) -> Result<(), String> {
        let size = (HEAD + content.len()) as u64;
        if content.len() > MOST_RECORD || self.end + size > MOST_BYTES {
            return Err(format!("it exceeds {} GiB", MOST_BYTES >> 30));
        }
        let mut record = Vec::with_capacity(HEAD + content.len());
        record.extend((content.len() as u32).to_le_bytes());
        record.extend(&Sha256::digest(content)[..8]);
        record.extend(content);
        self.file.write_all(&record).map_err(|e| e.to_string())?;
        self.end += size;
        (self.at, self.until) = (self.end, self.end);
        Ok(())
    }

    fn read(&mut self) -> Result<Vec<u8>, String> {
        let place = self.file.seek(SeekFrom::Start(self.at));
        let record = place.and_then(|_| next_record(&mut self.file)).map_err(|e| format!("it cannot be read: {e}"))?;
        record.ok_or_else(|| "a record changed while it was read".to_owned())
    }

    /// The run goes on without: its room may be what the run needs.
    fn give_up(&mut self, why: &str) {
        self.given_up = Some(why.to_owned());
        self.file.set_len(0).and_then(|()| fs::remove_file(&self.path)).ok();
    }
}

/// Locks a file; where the system has no locks, no other process is kept away.
fn locked(file: File, path: &Path) -> Result<File, JournalError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(JournalError::InUse { path: path.to_owned() }),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// The content of the record that begins here; none where the file ends, in the middle of a record as well.
fn next_record(input: &mut impl Read) -> std::io::Result<Option<Vec<u8>>> {
    let mut head = Vec::with_capacity(HEAD);
    input.by_ref().take(HEAD as u64).read_to_end(&mut head)?;
    let Ok([a, b, c, d, digest @ ..]) = <[u8; HEAD]>::try_from(head) else { return Ok(None) };
    let length = u32::from_le_bytes([a, b, c, d]) as usize;
    if length > MOST_RECORD {
        return Ok(None);
    }
    let mut content = Vec::new();
    input.by_ref().take(length as u64).read_to_end(&mut content)?;
    let whole = content.len() == length && Sha256::digest(&content)[..8] == digest[..];
    Ok(whole.then_some(content))
}

/// Does to stock and patches what a record says.
fn replayed(content: &[u8], cutting: &mut Cutting<'_>) -> Result<Vec<SweepReport>, proveout_stock::StockFileError> {
    let mut log = SweepReplay::new(content.get(17..).unwrap_or_default());
    for patch in cutting.patches.iter_mut() {
        log.stock(patch.stock_mut())?;
    }
    log.stock(cutting.stock)?;
    let reports = log.reports()?;
    if content.first() == Some(&(DepthsTold::Here as u8)) {
        log.depths(cutting.depths)?;
    }
    Ok(reports)
}

/// Begin of the SHA-256 of the motion of some sweeps.
pub(crate) fn motion(items: &[SweepItem<'_>], measures: &[Measure]) -> [u8; 16] {
    let mut hash = Sha256::new();
    for (item, measure) in items.iter().zip(measures) {
        hash.update(item.id.to_le_bytes());
        let (kind, since) = match measure {
            Measure::No => (0, 0),
            Measure::Alone => (1, 0),
            Measure::Since(id) => (2, *id),
            Measure::Touch => (3, 0),
            Measure::Deepest(run) => (4, *run),
        };
        hash.update([item.action as u8, kind]);
        hash.update(since.to_le_bytes());
        for pose in [&item.motion.from, &item.motion.to] {
            for x in [pose.tip.x, pose.tip.y, pose.tip.z, pose.axis.x, pose.axis.y, pose.axis.z] {
                hash.update(x.to_bits().to_le_bytes());
            }
        }
    }
    let mut begin = [0; 16];
    begin.iter_mut().zip(hash.finalize()).for_each(|(to, from)| *to = from);
    begin
}
