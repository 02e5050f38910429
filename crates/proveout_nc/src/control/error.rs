/// A control file that cannot be used: place, value and remedy of the one mistake.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {key}: {message}; {remedy} [{code}]")]
pub struct ControlFileError {
    /// Stable name of the kind of mistake (`control-unknown-function`).
    pub code: &'static str,
    /// The file, as given by the caller; `built-in NAME` for one that comes with the program.
    pub file: String,
    /// Line, from 1; 0 where the file could not be read at all.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Path of the key, `words.M25.does`.
    pub key: String,
    /// What is wrong, with the value.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

/// What a part of a file says, or what is wrong with it.
pub(super) type Checked<T> = Result<T, Box<ControlFileError>>;
