//! Files with keys of before get the names that keys have today.

use std::{fs, path::Path};

use proveout_sim::{InputError, Migration, SimError, migrate, read_input};

use super::output_file;
use crate::{FAIL, PASS, WRONG, args::MigrateArgs, failure::Failure};

/// Renames old keys; the exit code. Nothing is written where one of the files cannot be read.
pub(crate) fn migrate_files(args: &MigrateArgs) -> Result<u8, Failure> {
    if let Some(output) = &args.output {
        if args.files.len() != 1 {
            return Err(Failure::new(format!("--output takes one file, but the call names {}", args.files.len()))
                .with_help("migrate them one by one, or in place without --output"));
        }
        output_file::check(output, args.force)?;
    }
    let read = |path: &Path| -> Result<Migration, InputError> { migrate(path, &read_input(path)?) };
    let all: Vec<_> = args.files.iter().map(|path| (path, read(path))).collect();
    let mut wrong = false;
    for (path, result) in &all {
        match result {
            Ok(done) => {
                for change in &done.changes {
                    say!("{}:{}: {} -> {}", path.display(), change.line, change.old, change.new);
                }
            }
            Err(fault) => {
                wrong = true;
                tell!("{}", Failure::from(&SimError::from(fault.clone())).to_string().trim_end());
            }
        }
    }
    if wrong {
        return Ok(WRONG);
    }
    let done: Vec<_> = all.into_iter().filter_map(|(path, result)| Some((path, result.ok()?))).collect();
    let keys: usize = done.iter().map(|(_, done)| done.changes.len()).sum();
    let changed = done.iter().filter(|(_, done)| !done.changes.is_empty()).count();
    for (path, done) in &done {
        if let Some(output) = args.output.as_deref().filter(|_| !args.check) {
            output_file::put_bytes(output, args.force, &done.text)?;
        } else if !args.check && !done.changes.is_empty() {
            replace(path, &done.text)?;
        }
    }
    let word = if args.check { "to rename" } else { "renamed" };
    let plural = |n: usize| if n == 1 { "" } else { "s" };
    let files = done.len();
    say!("{keys} key{} {word}, in {changed} of {files} file{}", plural(keys), plural(files));
    Ok(if args.check && keys > 0 { FAIL } else { PASS })
}

/// Replaces the text of a file, which keeps its permissions.
fn replace(path: &Path, text: &str) -> Result<(), Failure> {
    output_file::put(path, true, |beside| {
        fs::write(beside, text).and_then(|()| fs::set_permissions(beside, fs::metadata(path)?.permissions())).map_err(
            |e| {
                Failure::new(format!("{} cannot be written: {e}", path.display()))
                    .with_help("check the rights of its folder")
            },
        )
    })
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    const OLD: &str = "resolution_mm = 1\r\n[limits] # of a run\r\nblocks = 9\r\n";
    const NEW: &str = "resolution_mm = 1\r\n[run_limits] # of a run\r\nblocks = 9\r\n";

    fn call(files: &[&PathBuf], check: bool, output: Option<&PathBuf>, force: bool) -> Result<u8, String> {
        let files = files.iter().copied().cloned().collect();
        let args = MigrateArgs { files, check, output: output.cloned(), force };
        migrate_files(&args).map_err(|e| e.to_string())
    }

    #[test]
    fn files_are_rewritten_in_place_once() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let [scene, tools] = ["scene.toml", "tools.toml"].map(|name| folder.path().join(name));
        fs::write(&scene, OLD).expect("written");
        fs::write(&tools, "[[tool]]\nnumber = 1").expect("written");
        let text = |path: &PathBuf| fs::read_to_string(path).expect("text");
        let time = |path: &PathBuf| fs::metadata(path).and_then(|m| m.modified()).expect("a time");
        let before = time(&tools);

        assert_eq!(call(&[&scene, &tools], true, None, false), Ok(FAIL));
        assert_eq!(text(&scene), OLD, "a check writes nothing");
        assert_eq!(call(&[&tools], true, None, false), Ok(PASS));
        assert_eq!(call(&[&scene, &tools], false, None, false), Ok(PASS));
        assert_eq!(text(&scene), NEW);
        assert_eq!((text(&tools).as_str(), time(&tools)), ("[[tool]]\nnumber = 1", before), "it is not written");
        let after = time(&scene);
        assert_eq!(call(&[&scene, &tools], true, None, false), Ok(PASS));
        assert_eq!(call(&[&scene], false, None, false), Ok(PASS));
        assert_eq!(time(&scene), after, "a second call writes nothing");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "no file is left over");
    }

    #[test]
    fn another_file_is_overwritten_by_force_alone() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let [scene, new] = ["scene.toml", "new.toml"].map(|name| folder.path().join(name));
        fs::write(&scene, OLD).expect("written");
        assert_eq!(call(&[&scene], false, Some(&new), false), Ok(PASS));
        let text = |path: &PathBuf| fs::read_to_string(path).expect("text");
        assert_eq!((text(&scene).as_str(), text(&new).as_str()), (OLD, NEW));
        assert!(call(&[&scene], false, Some(&new), false).is_err_and(|e| e.contains("already exists")));
        assert_eq!(call(&[&new], false, Some(&scene), true), Ok(PASS), "nothing to rename: the same text");
        assert_eq!(text(&scene), NEW);
        assert!(call(&[&scene, &new], false, Some(&new), true).is_err_and(|e| e.contains("takes one file")));
    }

    #[test]
    fn the_files_of_the_repository_have_no_old_key() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut open: Vec<PathBuf> = ["scenes", "machines", "tools", "controls", "tests"].map(|n| root.join(n)).into();
        let mut read = 0;
        while let Some(at) = open.pop() {
            for path in fs::read_dir(&at).expect("a folder").map(|e| e.expect("an entry").path()) {
                if path.is_dir() {
                    open.push(path);
                } else if path.extension().is_some_and(|e| e == "toml")
                    && let Ok(done) = migrate(&path, &fs::read_to_string(&path).expect("text"))
                {
                    read += 1;
                    assert!(done.changes.is_empty(), "{}: {:?}", path.display(), done.changes);
                }
            }
        }
        assert!(read > 60, "{read}");
    }

    #[test]
    fn one_file_that_cannot_be_read_keeps_all_as_they_are() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let [scene, other] = ["scene.toml", "other.toml"].map(|name| folder.path().join(name));
        fs::write(&scene, OLD).expect("written");
        // A picture, Latin 1, no TOML, no file of ours, none at all.
        for bytes in [&b"\x89PNG\r\n\x1a\n\0\0"[..], b"name = \"\xe4\"", b"G1 X3", b"a = 1", b""] {
            fs::write(&other, bytes).expect("written");
            assert_eq!(call(&[&scene, &other], false, None, false), Ok(WRONG));
            assert_eq!(fs::read(&other).expect("bytes"), bytes);
        }
        fs::File::create(&other).and_then(|f| f.set_len((16 << 20) + 1)).expect("a large file");
        for missing in [&other, &folder.path().join("nowhere.toml"), &folder.path().to_owned()] {
            assert_eq!(call(&[&scene, missing], false, None, false), Ok(WRONG));
        }
        assert_eq!(fs::read_to_string(&scene).expect("text"), OLD);
    }
}
