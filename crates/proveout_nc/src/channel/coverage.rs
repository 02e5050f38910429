//! Which lines of its files a program has run, and what the others are.
//!
//! A reader marks every line that it takes; one bit a line costs nothing compared with reading it.
//! After the run the lines without a mark are gone through once. The place of such a line says what
//! it is:
//!
//! ```text
//!   part       a program, subprogram or text outside of the tape  never entered: the whole part was not run
//!   region     a subprogram inside of a part (o sub, LBL)         never entered: subprogram not called
//!   end        after the block that ended the run                 not run, until a possible target of a jump
//!   else                                                          a branch that was not taken
//! ```
//!
//! A jump can lead to a line with a label that some jump names, and to the line after the closing
//! word of a structure that was opened before the end.

use std::sync::Arc;

use crate::not_run::{NotRun, NotRunKind};
use crate::source::{Mark, Source};

/// Lines of a file, one bit each.
#[derive(Clone, Debug, Default)]
pub(crate) struct LineSet(Vec<u64>);

impl LineSet {
    pub(crate) fn mark(&mut self, line: u32) {
        let word = line as usize / 64;
        if word >= self.0.len() {
            self.0.resize(word + 1 + self.0.len() / 2, 0);
        }
        self.0[word] |= 1 << (line % 64);
    }

    pub(crate) fn has(&self, line: u32) -> bool {
        self.0.get(line as usize / 64).is_some_and(|word| word >> (line % 64) & 1 == 1)
    }
}

/// What the files of a program have run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coverage {
    files: Vec<LineSet>,
    /// File and first line after the block that ended the run, at each level of the call stack.
    ends: Vec<(usize, u32)>,
}

impl Coverage {
    /// The lines from one up to, not including, another were taken.
    pub(crate) fn mark(&mut self, file: usize, from: u32, to: u32) {
        if file >= self.files.len() {
            self.files.resize(file + 1, LineSet::default());
        }
        for line in from..to {
            self.files[file].mark(line);
        }
    }

    /// The program ended; the level would have gone on at this line.
    pub(crate) fn end(&mut self, file: usize, next: u32) {
        self.ends.push((file, next));
    }

    /// The text of a file that was not run.
    pub(crate) fn not_run(&self, file: usize, layout: &Layout<'_>) -> Vec<NotRun> {
        let none = LineSet::default();
        let ran = self.files.get(file).unwrap_or(&none);
        let ends: Vec<u32> = self.ends.iter().filter(|(f, _)| *f == file).map(|(_, line)| *line).collect();
        layout.search(ran, &ends)
    }
}

/// A stretch of lines with a name.
#[derive(Clone, Debug)]
pub(crate) struct LineStretch {
    /// First line, and the line after the last.
    pub(crate) lines: [u32; 2],
    /// What it is when it is not entered.
    pub(crate) kind: NotRunKind,
}

impl LineStretch {
    fn holds(&self, line: u32) -> bool {
        (self.lines[0]..self.lines[1]).contains(&line)
    }

    fn entered(&self, ran: &LineSet) -> bool {
        (self.lines[0]..self.lines[1]).any(|line| ran.has(line))
    }
}

/// What a line does to the flow of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Flow {
    #[default]
    On,
    /// Opens a structure that another line closes.
    Opens,
    /// Closes one, or is a further branch of it.
    Closes,
    Between,
    /// A jump names it.
    Target,
}

/// What a line without a mark is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LineRole {
    /// It holds something that a control would execute.
    pub(crate) code: bool,
    /// It moves an axis.
    pub(crate) moves: bool,
    pub(crate) flow: Flow,
}

/// How a file is built.
pub(crate) struct Layout<'a> {
    pub(crate) source: &'a Source,
    /// Programs and subprograms of the file; in order, none in another.
    pub(crate) parts: Vec<LineStretch>,
    /// Subprograms inside of the parts.
    pub(crate) regions: Vec<LineStretch>,
    /// Returns what a line is.
    pub(crate) role: &'a dyn Fn(&str, Mark) -> LineRole,
}

impl Layout<'_> {
    fn search(&self, ran: &LineSet, ends: &[u32]) -> Vec<NotRun> {
        let mut found: Vec<NotRun> = Vec::new();
        let not_entered = |list: &[LineStretch]| -> Vec<LineStretch> {
            list.iter().filter(|stretch| !stretch.entered(ran)).cloned().collect()
        };
        let (mut parts, mut regions) = (None, None);
        let (mut behind, mut depth, mut open) = (false, 0u32, false);
        let mut at = Mark::START;
        while let Some((line, next)) = self.source.line(at) {
            let here = at;
            at = next;
            if ran.has(here.line) {
                (behind, depth, open) = (false, 0, false);
                continue;
            }
            if ends.contains(&here.line) {
                (behind, depth) = (true, 0);
            }
            let role = (self.role)(line, here);
            match role.flow {
                Flow::Opens => depth += 1,
                Flow::Closes | Flow::Between if depth == 0 => behind = false,
                Flow::Closes => depth -= 1,
                Flow::Target => behind = false,
                Flow::On | Flow::Between => {}
            }
            if !role.code {
                continue;
            }
            let parts = parts.get_or_insert_with(|| not_entered(&self.parts));
            let regions = regions.get_or_insert_with(|| not_entered(&self.regions));
            let of =
                |list: &[LineStretch]| list.iter().find(|stretch| stretch.holds(here.line)).map(|s| s.kind.clone());
            let kind = of(parts).or_else(|| of(regions)).unwrap_or(if behind {
                NotRunKind::BehindEnd
            } else {
                NotRunKind::Branch
            });
            match found.last_mut().filter(|last| open && last.kind == kind) {
                Some(last) => {
                    last.lines[1] = here.line;
                    last.moves |= role.moves;
                }
                None => {
                    let file = Arc::clone(&self.source.name);
                    let text = line.to_owned();
                    found.push(NotRun { file, lines: [here.line; 2], kind, moves: role.moves, text });
                    open = true;
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `{` opens, `}` closes, `|` between, `:` a target; other letters are code, `m` moves, `.` is empty.
    fn role(line: &str, _: Mark) -> LineRole {
        let flow = match line {
            "{" => Flow::Opens,
            "}" => Flow::Closes,
            "|" => Flow::Between,
            ":" => Flow::Target,
            _ => Flow::On,
        };
        LineRole { code: line.chars().all(char::is_alphabetic), moves: line == "m", flow }
    }

    /// `+` in front of a line: it was run; `!`: it was run and ended the program.
    fn found(text: &str, parts: &[[u32; 2]], regions: &[[u32; 2]]) -> String {
        let mut coverage = Coverage::default();
        let mut plain = String::new();
        for (line, number) in text.split(' ').zip(1..) {
            if line.starts_with(['+', '!']) {
                coverage.mark(0, number, number + 1);
            }
            if line.starts_with('!') {
                coverage.end(0, number + 1);
            }
            plain.push_str(line.trim_start_matches(['+', '!']));
            plain.push('\n');
        }
        let source = Source::new("t", plain);
        let stretches = |list: &[[u32; 2]], program: bool| -> Vec<LineStretch> {
            let kind = |name: String| if program { NotRunKind::Program(name) } else { NotRunKind::Subprogram(name) };
            list.iter().zip(1..).map(|(&lines, i)| LineStretch { lines, kind: kind(format!("{i}")) }).collect()
        };
        let layout =
            Layout { source: &source, parts: stretches(parts, true), regions: stretches(regions, false), role: &role };
        let list = coverage.not_run(0, &layout).into_iter().map(|n| {
            let kind = match n.kind {
                NotRunKind::BehindEnd => "end".to_owned(),
                NotRunKind::Program(name) => format!("program {name}"),
                NotRunKind::Subprogram(name) => format!("sub {name}"),
                NotRunKind::Branch => "branch".to_owned(),
                NotRunKind::MissingSubprogram(name) => format!("missing {name}"),
                NotRunKind::Outside => "outside".to_owned(),
            };
            format!("{}-{} {kind}{}", n.lines[0], n.lines[1], if n.moves { " moves" } else { "" })
        });
        list.collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn each_line_without_a_mark_is_reported_once_with_its_reason() {
        assert_eq!(found("+m +m !x", &[[1, 4]], &[]), "");
        assert_eq!(found("+m !x . a m .", &[[1, 7]], &[]), "4-5 end moves");
        assert_eq!(found("+m a m +m !x", &[[1, 6]], &[]), "2-3 branch moves");
        assert_eq!(found("+m !x a : m m", &[[1, 7]], &[]), "3-3 end, 5-6 branch moves");
        assert_eq!(found("+{ !x m } m", &[[1, 6]], &[]), "3-3 end moves, 5-5 branch moves");
        assert_eq!(found("+{ !x | m } m", &[[1, 7]], &[]), "4-6 branch moves");
        assert_eq!(found("+m !x { m } m", &[[1, 7]], &[]), "4-6 end moves", "a structure that nothing enters");
        assert_eq!(found("+m !x a m +a m", &[[1, 3], [3, 5], [5, 7]], &[]), "3-4 program 2 moves, 6-6 branch moves");
        assert_eq!(found("+m !x a m a", &[[1, 6]], &[[4, 6]]), "3-3 end, 4-5 sub 1 moves");
    }

    #[test]
    fn every_line_with_code_has_a_mark_or_is_reported() {
        // All texts of five lines over the alphabet of `role`.
        let alphabet = ["a", "m", "+a", "!a", ".", "{", "}", ":"];
        let mut picks = [0usize; 5];
        for n in 0..alphabet.len().pow(5) {
            let mut rest = n;
            for pick in &mut picks {
                *pick = rest % alphabet.len();
                rest /= alphabet.len();
            }
            let lines: Vec<&str> = picks.iter().map(|&p| alphabet[p]).collect();
            let matches = found(&lines.join(" "), &[[1, 6]], &[]);
            for (line, number) in lines.iter().zip(1..) {
                let ranges = matches.split(", ").filter(|t| !t.is_empty()).map(|t| {
                    let (a, b) = t.split(' ').next().unwrap().split_once('-').unwrap();
                    (a.parse::<i32>().unwrap(), b.parse::<i32>().unwrap())
                });
                let times = ranges.filter(|(a, b)| (*a..=*b).contains(&number)).count();
                match *line {
                    "a" | "m" => assert_eq!(times, 1, "{lines:?} {matches}"),
                    "+a" | "!a" => assert_eq!(times, 0, "{lines:?} {matches}"),
                    _ => {}
                }
            }
        }
    }
}
