//! A control by its name or its file, with its parents.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use super::builtin::{self, text_of};
use super::error::ControlFileError;
use super::file::ControlFile;
use super::model::Control;
use super::place::{ControlText, nearest};
use super::resolve;

/// Most parents of a control: far more than anyone can follow.
const MOST_PARENTS: usize = 16;
/// Largest control file.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// One file of the chain.
struct ControlLayer {
    /// Name for messages; identifies the file.
    name: String,
    text: String,
    /// Folder of the file; none for a built-in one.
    folder: Option<PathBuf>,
    /// None for a built-in one, and for a text that is no file.
    path: Option<PathBuf>,
}

impl Control {
    /// A built-in control by its name, or a file by its path; relative paths begin at `folder`.
    ///
    /// # Errors
    /// The control is not there, or it or one of its parents is wrong.
    pub fn find(name: &str, folder: Option<&Path>) -> Result<Arc<Self>, Box<ControlFileError>> {
        link(name, folder).map_err(|message| missing(name, &message)).and_then(read)
    }

    /// A control from a text; `name` takes the place of the file in messages, and relative paths
    /// begin at `folder`.
    ///
    /// # Errors
    /// The text or one of its parents is wrong.
    pub fn from_text(name: &str, text: &str, folder: Option<&Path>) -> Result<Arc<Self>, Box<ControlFileError>> {
        read(ControlLayer {
            name: name.to_owned(),
            text: text.to_owned(),
            folder: folder.map(Path::to_path_buf),
            path: None,
        })
    }
}

fn missing(name: &str, message: &str) -> Box<ControlFileError> {
    Box::new(ControlFileError {
        code: "control-missing",
        file: name.to_owned(),
        line: 0,
        column: 0,
        key: "control".to_owned(),
        message: message.to_owned(),
        remedy: remedy(name),
    })
}

fn remedy(name: &str) -> String {
    let names: Vec<&str> = builtin::builtin_controls().collect();
    if is_path(name) { "check the path".to_owned() } else { nearest(name, &names) }
}

/// A name with an ending or a folder is a path.
fn is_path(name: &str) -> bool {
    name.ends_with(".toml") || name.contains(['/', '\\'])
}

/// The text of a control, or why there is none.
fn link(name: &str, folder: Option<&Path>) -> Result<ControlLayer, String> {
    if !is_path(name) {
        return match text_of(name) {
            Some(text) => {
                Ok(ControlLayer { name: format!("built-in {name}"), text: text.to_owned(), folder: None, path: None })
            }
            None => Err(format!("there is no built-in control {name:?}")),
        };
    }
    let path = folder.map_or_else(|| PathBuf::from(name), |folder| folder.join(name));
    match text_of_file(&path) {
        Ok(text) => {
            let folder = path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
            let folder = folder.map(Path::to_path_buf);
            Ok(ControlLayer { name: path.display().to_string(), text, folder, path: Some(path) })
        }
        Err(e) => Err(format!("the file {} cannot be read: {e}", path.display())),
    }
}

/// The text of a file that is one, and no pipe or device.
fn text_of_file(path: &Path) -> io::Result<String> {
    let about = fs::metadata(path)?;
    if !about.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"));
    }
    if about.len() > MAX_FILE_BYTES {
        let message = format!("it has {} bytes, and files of this kind may have {MAX_FILE_BYTES}", about.len());
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    fs::read_to_string(path)
}

/// Identifies a file, however its path is written.
fn identity(link: &ControlLayer) -> PathBuf {
    fs::canonicalize(&link.name).unwrap_or_else(|_| PathBuf::from(&link.name))
}

fn parse(link: &ControlLayer) -> Result<ControlFile, Box<ControlFileError>> {
    toml::from_str(&link.text).map_err(|e| ControlText::new(&link.name, &link.text).toml_error(&e))
}

/// Follows the parents, then applies the files from the oldest to the control itself.
fn read(first: ControlLayer) -> Result<Arc<Control>, Box<ControlFileError>> {
    let mut chain: Vec<(ControlLayer, ControlFile)> = Vec::new();
    let mut next = Some(first);
    while let Some(link) = next.take() {
        let file = parse(&link)?;
        if let Some(parent) = &file.inherits {
            let wrong = |code: &'static str, message: String, remedy: String| {
                ControlText::new(&link.name, &link.text).error(code, &["inherits"], message, remedy)
            };
            let found = self::link(parent, link.folder.as_deref())
                .map_err(|message| wrong("control-parent-missing", message, remedy(parent)))?;
            let own = identity(&found);
            let mut names: Vec<&str> = chain.iter().map(|(link, _)| link.name.as_str()).collect();
            names.push(&link.name);
            if own == identity(&link) || chain.iter().any(|(link, _)| identity(link) == own) {
                let message =
                    format!("the controls inherit from each other in a circle: {}, {}", names.join(", "), found.name);
                let remedy = "remove one `inherits`, and name the dialect there".to_owned();
                return Err(wrong("control-inheritance-circle", message, remedy));
            }
            if chain.len() >= MOST_PARENTS {
                let message = format!("the control has more than {MOST_PARENTS} parents");
                return Err(wrong(
                    "control-inheritance-circle",
                    message,
                    "inherit from one of them directly".to_owned(),
                ));
            }
            next = Some(found);
        }
        chain.push((link, file));
    }
    let mut control = Control::default();
    for (link, file) in chain.iter().rev() {
        let text = ControlText::new(&link.name, &link.text);
        resolve::apply(&mut control, file, &text, link.folder.as_deref())?;
    }
    control.files = chain.iter().filter_map(|(link, _)| link.path.clone()).collect();
    Ok(Arc::new(control))
}
