//! Where a key of a scene is in its text: every fault of a value is reported at that place.

use std::path::Path;

use proveout_input::{Document, InputError, Step, Step::Item, Step::Key, read_input};

use crate::scene::{ProgramFile, Scene};

/// Byte at which the value of a key begins; of a table its name. Where the key is not there, that of the
/// deepest table that leads to it.
pub(crate) fn offset_of(text: &str, path: &[Step<'_>]) -> usize {
    Document::new(Path::new(""), text).span(path).start
}

impl Scene {
    /// A fault of the value at a path of keys, with its line and column; of a value that the call has set the
    /// file alone.
    pub(crate) fn error_at(
        &self,
        path: &[Step<'_>],
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        let error = InputError::file(&self.path, message, help);
        match read_input(&self.path) {
            Ok(text) if !self.values_set => {
                let span = Document::new(&self.path, &text).span(path);
                error.with_span(&text, &span)
            }
            _ => error,
        }
    }

    /// A fault of a key of a program of the scene.
    pub(crate) fn error_of_program(
        &self,
        program: &ProgramFile,
        key: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        let index = self.file.program.iter().position(|p| std::ptr::eq(p, program) || p.name == program.name);
        self.error_at(&[Key("program"), Item(index.unwrap_or(0)), Key(key)], message, help)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_found_where_it_stands_and_not_where_its_word_stands() {
        let text = "# gouge_mm, [start], tool\nname = \"gouge_mm\"\n[tolerances]\nexcess_mm = 1\ngouge_mm = -0.1\n\
                    [[program]]\nname = \"a\"\n[[program]]\nname = \"b\"\nfile = \"a\"\n[start]\ntool = 3\n";
        let line = |path: &[Step<'_>]| {
            let before = &text[..offset_of(text, path)];
            let start = before.rfind('\n').map_or(0, |i| i + 1);
            (before.matches('\n').count() + 1, before.len() - start + 1)
        };
        assert_eq!(line(&[Key("tolerances"), Key("gouge_mm")]), (5, 12));
        assert_eq!(line(&[Key("program"), Item(1), Key("name")]), (9, 8));
        assert_eq!(line(&[Key("start"), Key("tool")]), (12, 8));
        // A key that is not there: the table that would hold it.
        assert_eq!(line(&[Key("tolerances"), Key("contact_mm")]), (3, 2));
        assert_eq!(line(&[Key("program"), Item(1), Key("dialect")]).0, 8);
        assert_eq!(line(&[Key("nowhere")]), (1, 1));
    }
}
