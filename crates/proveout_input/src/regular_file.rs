//! Input files are regular files of bounded size: a pipe would wait for a writer for ever, `/dev/zero` would
//! fill the memory.

use std::{
    fs::File,
    io::{Error, ErrorKind, Read},
    path::Path,
};

/// Opens a file to be read.
///
/// # Errors
/// What the system says; [`ErrorKind::IsADirectory`] and [`ErrorKind::InvalidInput`] where `path` is no
/// regular file (links are followed), before it is opened.
pub fn open_regular_file(path: &Path) -> Result<File, Error> {
    let about = std::fs::metadata(path)?;
    if about.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder, not a file"));
    }
    if !about.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is a pipe, a device or a socket, not a regular file"));
    }
    File::open(path)
}

/// Reads a file whole.
///
/// # Errors
/// As [`open_regular_file`], and [`ErrorKind::FileTooLarge`] where it has more than `limit` bytes, before
/// they are read.
pub fn read_regular_file(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    let file = open_regular_file(path)?;
    let length = file.metadata()?.len();
    let too_large = |bytes: u64| {
        Error::new(
            ErrorKind::FileTooLarge,
            format!("it has {bytes} bytes or more; files of this kind may have {limit}"),
        )
    };
    if length > limit {
        return Err(too_large(length));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    // System files (/proc) report a length of zero, and a log may grow while it is read.
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large(limit + 1)) } else { Ok(bytes) }
}

/// The same as text.
///
/// # Errors
/// As [`read_regular_file`], and [`ErrorKind::InvalidData`] with the first byte that is not UTF-8.
pub fn read_regular_text(path: &Path, limit: u64) -> Result<String, Error> {
    String::from_utf8(read_regular_file(path, limit)?).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        Error::new(ErrorKind::InvalidData, format!("it is not UTF-8 text: byte {at} begins no character"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_of_bounded_size_are_read() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("input");
        std::fs::write(&path, b"12345\xff").expect("written");
        assert_eq!(read_regular_file(&path, 6).expect("as long as the limit").len(), 6);
        assert_eq!(read_regular_file(&path, 5).expect_err("longer").kind(), ErrorKind::FileTooLarge);
        assert!(read_regular_text(&path, 6).expect_err("no text").to_string().contains("byte 5"));
        assert_eq!(read_regular_file(folder.path(), 6).expect_err("a folder").kind(), ErrorKind::IsADirectory);
        assert_eq!(read_regular_file(&folder.path().join("none"), 6).expect_err("none").kind(), ErrorKind::NotFound);
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_links_to_them_are_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/dev/zero", &link).expect("linked");
        for path in [Path::new("/dev/zero"), &link] {
            assert_eq!(read_regular_file(path, 1 << 20).expect_err("a device").kind(), ErrorKind::InvalidInput);
        }
    }
}
