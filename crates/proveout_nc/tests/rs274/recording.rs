//! Reads a recording of `record.py`.

use std::io::Read;
use std::path::PathBuf;

/// A block with the canonical calls of `rs274`, or its refusal.
pub(crate) struct Recorded {
    pub(crate) text: String,
    pub(crate) calls: Vec<String>,
    pub(crate) refusal: Option<String>,
}

pub(crate) struct Recording {
    pub(crate) programs: Vec<Vec<Recorded>>,
}

impl Recording {
    /// The recording of the repository, or the one that `PROVEOUT_RS274_FILE` names.
    pub(crate) fn open() -> Self {
        let own = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/rs274/blocks.txt.gz");
        let path = std::env::var_os("PROVEOUT_RS274_FILE").map_or(own, PathBuf::from);
        let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut text = String::new();
        flate2::read::GzDecoder::new(&bytes[..]).read_to_string(&mut text).unwrap();
        let mut programs: Vec<Vec<Recorded>> = Vec::new();
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if line == "=" {
                programs.push(Vec::new());
                continue;
            }
            let behind = lines.next().unwrap().trim_start_matches('\t');
            let recorded = match line.strip_prefix('!') {
                Some(block) => Recorded { text: block.to_owned(), calls: Vec::new(), refusal: Some(behind.to_owned()) },
                None => Recorded {
                    text: line.to_owned(),
                    calls: behind.split(';').filter(|c| !c.is_empty()).map(str::to_owned).collect(),
                    refusal: None,
                },
            };
            programs.last_mut().unwrap().push(recorded);
        }
        Self { programs }
    }
}
