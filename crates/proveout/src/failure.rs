use std::fmt::Display;

/// An error for people: place, message, line of text, remedy. Ends the program with exit code 2.
#[derive(Debug, Default)]
pub(crate) struct Failure {
    pub(crate) message: String,
    /// `file:line:column` or a file.
    pub(crate) place: Option<String>,
    pub(crate) source_line: Option<String>,
    /// Column of the fault in `source_line`, from 1, and its length.
    pub(crate) mark: Option<(usize, usize)>,
    pub(crate) help: Option<String>,
}

impl Failure {
    pub(crate) fn new(message: impl Display) -> Self {
        Self { message: message.to_string(), ..Self::default() }
    }

    pub(crate) fn with_help(mut self, help: impl Display) -> Self {
        self.help = Some(help.to_string()).filter(|h| !h.is_empty());
        self
    }

    pub(crate) fn at(mut self, file: impl Display, line: usize, column: usize, length: usize, text: &str) -> Self {
        self.place = Some(if line == 0 { file.to_string() } else { format!("{file}:{line}:{column}") });
        if !text.is_empty() && column > 0 {
            self.source_line = Some(text.replace('\t', " "));
            self.mark = Some((column, length.max(1)));
        }
        self
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "error: {}", self.message)?;
        if let Some(place) = &self.place {
            writeln!(f, "  at {place}")?;
        }
        if let (Some(line), Some((column, length))) = (&self.source_line, self.mark) {
            let shown: String = line.chars().take(160).collect();
            writeln!(f, "   | {shown}")?;
            if column <= 160 {
                writeln!(f, "   | {}{}", " ".repeat(column - 1), "^".repeat(length.min(161 - column)))?;
            }
        }
        if let Some(help) = &self.help {
            writeln!(f, "  help: {help}")?;
        }
        Ok(())
    }
}
