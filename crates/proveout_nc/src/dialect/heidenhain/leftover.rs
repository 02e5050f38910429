//! Classifies the text that was not run: programs, labels that nothing calls, branches, text after
//! the end of the program.

use super::run_state::{Interpreter, Loaded, label_key};
use super::words::{Block, Label, Statement, Value};
use super::{din, parser, text};
use crate::channel::coverage::{Flow, Layout, LineRole, LineStretch};
use crate::not_run::{NotRun, NotRunKind};
use crate::source::{Mark, Source};

impl Interpreter {
    /// Whether a block with code comes before this one.
    pub(crate) fn follows_code(&self, loaded: &Loaded, at: Mark) -> bool {
        let mut buffer = String::new();
        let mut block = Block::default();
        let mut here = Mark::START;
        while here.offset < at.offset {
            let Some(found) = text::block(&loaded.source, here, &mut buffer) else { return false };
            if parse(loaded.index.din, found.text, &mut block) && block.statement != Statement::Empty {
                return true;
            }
            here = found.next;
        }
        false
    }
}

pub(super) fn not_run(channel: &Interpreter) -> Vec<NotRun> {
    let mut found = Vec::new();
    for loaded in channel.loaded() {
        let plan = FileOutline::of(loaded);
        let layout = Layout {
            source: &loaded.source,
            parts: plan.parts,
            regions: plan.regions,
            role: &|_, at| plan.roles.get(at.line as usize).copied().unwrap_or_default(),
        };
        found.extend(channel.coverage.not_run(loaded.file, &layout));
    }
    found
}

fn parse(din: bool, text: &str, block: &mut Block) -> bool {
    if din { din::parse(text, block).is_ok() } else { parser::parse(text, block).is_ok() }
}

/// Structure of a file. Blocks can take several lines, so the whole text is read once.
struct FileOutline {
    parts: Vec<LineStretch>,
    regions: Vec<LineStretch>,
    /// By line, from 1.
    roles: Vec<LineRole>,
}

impl FileOutline {
    fn of(loaded: &Loaded) -> Self {
        let source: &Source = &loaded.source;
        let named = named_labels(loaded);
        let mut plan = Self { parts: Vec::new(), regions: Vec::new(), roles: vec![LineRole::default()] };
        let (mut block, mut buffer, mut at) = (Block::default(), String::new(), Mark::START);
        let mut program: Option<(u32, String)> = None;
        let mut label: Option<(u32, String)> = None;
        while let Some(found) = text::block(source, at, &mut buffer) {
            let (mut role, next) = (LineRole::default(), found.next);
            if parse(loaded.index.din, found.text, &mut block) {
                role = role_of(&block);
                match &block.statement {
                    Statement::Begin { .. } => {
                        plan.close(&mut program, at.line);
                        program = Some((at.line, found.text.trim().to_owned()));
                    }
                    Statement::Label(Label::Number(Value::Number(0.0))) => {
                        if let Some((first, name)) = label.take() {
                            let kind = NotRunKind::Subprogram(name);
                            plan.regions.push(LineStretch { lines: [first, next.line], kind });
                        }
                    }
                    Statement::Label(found) => {
                        let key = key_of(found);
                        if key.as_ref().is_none_or(|key| named.as_ref().is_none_or(|n| n.contains(key))) {
                            role.flow = Flow::Target;
                        }
                        let shown = key.unwrap_or_default();
                        label.get_or_insert((at.line, format!("LBL {}", shown.trim_start_matches('"'))));
                    }
                    _ => {}
                }
            } else {
                role.code = !found.text.trim().is_empty();
            }
            plan.roles.push(role);
            plan.roles.resize(next.line as usize, LineRole { flow: Flow::On, ..role });
            at = next;
        }
        plan.close(&mut program, at.line);
        plan
    }

    fn close(&mut self, program: &mut Option<(u32, String)>, end: u32) {
        if let Some((first, text)) = program.take() {
            // `0 BEGIN PGM NAME MM`, `%NAME G71 *`
            let mut words = text.split_whitespace().skip_while(|w| w.bytes().all(|b| b.is_ascii_digit()));
            let name = match words.next() {
                Some(word) if word.starts_with('%') => Some(word.trim_start_matches('%')),
                _ => words.nth(1),
            };
            let kind = NotRunKind::Program(name.unwrap_or("without a name").to_owned());
            self.parts.push(LineStretch { lines: [first, end], kind });
        }
    }
}

fn key_of(label: &Label) -> Option<String> {
    match label {
        Label::Number(Value::Number(number)) => Some(label_key(*number)),
        Label::Name(name) => Some(format!("\"{}", name.to_ascii_uppercase())),
        _ => None,
    }
}

/// Labels that a block calls or jumps to; none when a target is computed, because it can then be
/// any label.
fn named_labels(loaded: &Loaded) -> Option<Vec<String>> {
    let mut named = Vec::new();
    if loaded.index.labels.is_empty() {
        return Some(named);
    }
    let (mut block, mut buffer, mut at) = (Block::default(), String::new(), Mark::START);
    while let Some(found) = text::block(&loaded.source, at, &mut buffer) {
        if parse(loaded.index.din, found.text, &mut block)
            && let Statement::CallLabel { label, .. } | Statement::Goto(label) | Statement::Branch(_, label) =
                &block.statement
        {
            named.push(key_of(label)?);
        }
        at = found.next;
    }
    Some(named)
}

fn role_of(block: &Block) -> LineRole {
    let words = &block.words;
    let ends = words.functions.iter().all(|m| matches!(m.code, 2 | 30));
    let (code, moves) = match &block.statement {
        Statement::Empty | Statement::Begin { .. } | Statement::End | Statement::Note(_) | Statement::Label(_) => {
            (false, false)
        }
        Statement::Path(super::words::PathFunction::Nothing) | Statement::Stop => {
            (!ends || words.functions.is_empty(), false)
        }
        Statement::Path(_) => (true, true),
        Statement::Din(din) => {
            let moves = words.programmed != 0 || din.radius.is_some() || din.angle.is_some();
            let calls = words.functions.iter().any(|m| matches!(m.code, 89 | 99));
            (moves || calls || !ends || words.functions.is_empty(), moves || calls)
        }
        Statement::CycleCall
        | Statement::CycleCallPos
        | Statement::CycleCallPattern
        | Statement::CallLabel { .. }
        | Statement::CallProgram(_)
        | Statement::CallProgramText(_)
        | Statement::CallSelected => (true, true),
        _ => (true, false),
    };
    LineRole { code, moves, flow: Flow::On }
}
