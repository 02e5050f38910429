//! Operations by the names that a CAM system or a programmer gave them in comments.
//!
//! Two habits are known. A post may mark every operation: `(OPER: ROUGH)`, `; OPERATION 7`, `* - JOB: 1
//! ROUGH`, `TOOL PATH/ROUGH,TOOL,MILL_10`. Where a text has such marks, they alone count. Others write the
//! name as a comment of its own line before the motions of the operation: `(ROUGH SLOT)`. A comment of its
//! own line is then a head where at least [`LEAST_MOTIONS`] blocks with coordinates follow it before the next
//! one; remarks between blocks, descriptions of tools and separators are none.

/// Fewest blocks with coordinates in an operation: a remark has fewer after it.
const LEAST_MOTIONS: usize = 2;
/// Longest name, characters.
const MOST_CHARS: usize = 60;
/// Most heads of a text.
const MOST_HEADS: usize = 10_000;

/// Words that mark an operation at the start of a comment, upper case, with what may follow them.
const MARKS: [&str; 9] =
    ["OPERATION NAME", "OPERATION", "OPER", "TOOLPATH NAME", "TOOLPATH", "WORKSTEP", "JOB", "TOOL PATH", "OP"];

/// Where an operation begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OperationHead {
    /// Line of its comment, from 1.
    pub line: u32,
    /// Its name.
    pub name: String,
}

/// The heads of a program text, in order.
///
/// ```
/// use proveout_nc::operation_heads;
///
/// let text = "T1 M6\n(ROUGH SLOT)\nG0 X0\nG1 X9 F100\n(FINISH SLOT)\nG0 X0\nG1 X9\nM30\n";
/// let heads = operation_heads(text.lines()).into_iter();
/// let heads: Vec<(u32, String)> = heads.map(|h| (h.line, h.name)).collect();
/// assert_eq!(heads, [(2, "ROUGH SLOT".to_owned()), (5, "FINISH SLOT".to_owned())]);
/// ```
pub fn operation_heads<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<OperationHead> {
    let (mut marked, mut plain): (Vec<OperationHead>, Vec<OperationHead>) = (Vec::new(), Vec::new());
    // Motions since the last plain head, and whether a block was seen at all.
    let (mut motions, mut began) = (0, false);
    for (text, line) in lines.zip(1_u32..) {
        let Some(comment) = comment_alone(text) else {
            if let Some(name) = apt_path(text) {
                marked.push(OperationHead { line, name });
            }
            let code = text.split(['(', ';']).next().unwrap_or_default();
            began |= code.bytes().any(|b| b.is_ascii_digit());
            motions += usize::from(has_coordinate(code));
            continue;
        };
        if let Some(name) = marked_name(&comment) {
            marked.push(OperationHead { line, name });
        } else if began && is_name(&comment) {
            if motions < LEAST_MOTIONS {
                plain.pop();
            }
            plain.push(OperationHead { line, name: comment });
            motions = 0;
        }
        if marked.len().max(plain.len()) >= MOST_HEADS {
            break;
        }
    }
    if motions < LEAST_MOTIONS {
        plain.pop();
    }
    let mut heads = if marked.is_empty() { plain } else { marked };
    for head in &mut heads {
        head.name = head.name.chars().take(MOST_CHARS).collect();
    }
    heads
}

/// The text of a line that is a comment and nothing else but a block number.
fn comment_alone(line: &str) -> Option<String> {
    let mut rest = line.trim();
    let digits = rest.strip_prefix(['N', 'n']).unwrap_or(rest);
    let behind = digits.trim_start_matches(|c: char| c.is_ascii_digit());
    if behind.len() < digits.len() {
        rest = behind.trim_start();
    }
    let inner = if let Some(text) = rest.strip_prefix('(') {
        text.strip_suffix(')')?
    } else if let Some(text) = rest.strip_prefix(';') {
        text
    } else if let Some(text) = rest.strip_prefix('*') {
        text
    } else if let Some(text) = rest.strip_prefix("PPRINT") {
        text.trim_start_matches(['/', ' '])
    } else {
        rest.strip_prefix("$$")?
    };
    if inner.contains('(') {
        return None;
    }
    let text = inner.trim_matches(|c: char| c.is_whitespace() || "-*=_#~+".contains(c));
    (!text.is_empty()).then(|| text.to_owned())
}

/// `TOOL PATH/ROUGH,TOOL,MILL_10` of NX.
fn apt_path(line: &str) -> Option<String> {
    let name = line.trim().strip_prefix("TOOL PATH/")?.split(',').next()?.trim();
    (!name.is_empty()).then(|| name.to_owned())
}

/// The name behind a mark: `OPER: ROUGH`, `OPERATION 7`, `JOB: 1 ROUGH`.
fn marked_name(comment: &str) -> Option<String> {
    let upper = comment.to_ascii_uppercase();
    let mark = MARKS.iter().find(|mark| upper.starts_with(**mark))?;
    let rest = comment.get(mark.len()..)?;
    let parted = rest.trim_start().starts_with([':', '=']);
    let name = rest.trim_start().trim_start_matches([':', '=', '-', ' ']).trim();
    let number = rest.starts_with(' ') && name.starts_with(|c: char| c.is_ascii_digit());
    if name.is_empty() || !parted && !number {
        return None;
    }
    // A bare number says no more than the mark.
    Some(if name.bytes().all(|b| b.is_ascii_digit()) { comment.trim().to_owned() } else { name.to_owned() })
}

/// Words of people, and no description of a tool, a value or a date.
fn is_name(comment: &str) -> bool {
    const NO_NAMES: [&str; 9] = ["TOOL", "DATE", "TIME", "FILE", "PROGRAM", "MATERIAL", "STOCK", "WARNING", "NOTE"];
    let upper = comment.to_ascii_uppercase();
    let first = upper.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    let letters = upper.chars().filter(|c| c.is_alphabetic()).count();
    let numbered = |letter: char| {
        first.strip_prefix(letter).is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
    };
    letters >= 3
        && !upper.contains('=')
        && !NO_NAMES.contains(&first)
        && !['T', 'D', 'H', 'G', 'M'].into_iter().any(numbered)
}

/// A block with the word of a linear axis, of any language.
fn has_coordinate(code: &str) -> bool {
    let bytes = code.as_bytes();
    let axis = |at: usize| {
        let before = at == 0 || !bytes[at - 1].is_ascii_alphabetic();
        let behind = bytes.get(at + 1).is_some_and(|b| b.is_ascii_digit() || b" +-.=#[".contains(b));
        before && behind && matches!(bytes[at].to_ascii_uppercase(), b'X' | b'Y' | b'Z')
    };
    (0..bytes.len()).any(axis) || code.trim_start().starts_with("GOTO/")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heads(text: &str) -> Vec<(u32, String)> {
        operation_heads(text.lines()).into_iter().map(|head| (head.line, head.name)).collect()
    }

    fn named(list: &[(u32, &str)]) -> Vec<(u32, String)> {
        list.iter().map(|(line, name)| (*line, (*name).to_owned())).collect()
    }

    #[test]
    fn marks_go_before_other_comments() {
        let text = "T1 M6\n(OPER: ROUGH)\nG0 X0\nG1 X9\n(slowly here)\nG1 X1\nX2\n; OPERATION 7\nG1 X3\n* - JOB: 3 FINISH\nX4\n";
        assert_eq!(heads(text), named(&[(2, "ROUGH"), (8, "OPERATION 7"), (10, "3 FINISH")]));
        assert_eq!(
            heads("TOOL PATH/ROUGH,TOOL,MILL_10\nGOTO/1,2,3\nTOOL PATH/FINISH,TOOL,B6\nGOTO/1,2,4\n"),
            named(&[(1, "ROUGH"), (3, "FINISH")])
        );
    }

    #[test]
    fn a_comment_before_motions_is_a_name_and_a_remark_is_none() {
        let text = "%\nO1 (PART)\n(T1 10MM FLAT ENDMILL)\nG21\nT1 M6\n(ROUGH SLOT)\nG0 X0.\nG1 X9.\n(FINISH SLOT)\nG0 X0.\nG1 X9.\nM30\n";
        assert_eq!(heads(text), named(&[(6, "ROUGH SLOT"), (9, "FINISH SLOT")]));
        let remarks = "G21\n(first corner)\nG1 X1\n(second corner)\nG1 X2\n(third corner)\nG1 X3\n";
        assert_eq!(heads(remarks), []);
        assert_eq!(heads("G21\n(D=10. CR=0.)\nG1 X1\nX2\n(-----)\nX3\nX4\n"), []);
        assert_eq!(heads("G21 (ROUGH)\nG1 X1\nX2\n"), [], "a comment behind a block");
    }

    #[test]
    fn random_bytes_have_heads_or_none() {
        let mut state = 7_u64;
        for _ in 0..2000 {
            let text: String = (0..120)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    b"(;*)-NX1 :=OPER\nTJ"[(state >> 33) as usize % 18] as char
                })
                .collect();
            let heads = operation_heads(text.lines());
            assert!(heads.windows(2).all(|pair| pair[0].line < pair[1].line), "{text}");
        }
    }
}
