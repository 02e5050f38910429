//! High-level blocks of a Fagor as those of macro B, line by line: what other controls take as a comment is a
//! statement here.
//!
//! | Fagor 8055, 8025 | read as |
//! |---|---|
//! | `(P0=10,P1=P0*2)`, `P1=K10` | `#1=10 #2=#1*2` |
//! | `XP1`, `X P1` | `X#2` |
//! | `(IF P1 LT 3 GOTO N30)`, `(GOTO N30)` | `IF[#2 LT 3]GOTO30`, `GOTO30` |
//! | `(SUB 5)`, `G22 N5` ... `(RET)`, `G24` | `O5` ... `M99` |
//! | `(CALL 5)`, `G20 N5.2` | `M98P5`, `M98P5L2` |
//! | `(PCALL 5,P0=3)`, `G21 N5.1 P0=K3` | `G65P5A3` |
//! | `(RPT N50,N60)N3`, `G25 N50.60.3` | `RPT 50 60 3` |
//! | `G36 R3`, `G39 R2` in a block | `,R3`, `,C2` |
//!
//! Parameters P0 to P25 are local, as `#1` to `#26` are; the others keep their number. Lines
//! without these words stay as they are. Statements of this language that are not in the table are
//! refused at their line. After Fagor, *CNC 8055 M programming manual*, "Program control
//! statements" and "Subroutines"; the words of the 8025 (G20 to G25, K before constants) from
//! memory.

/// Begins a comment that replaces a statement that is not read.
pub(super) const UNREAD: &str = "!FAGOR ";

/// Statements with side effects on the path or the flow, which no comment may hide.
const STATEMENTS: [&str; 18] = [
    "IF", "GOTO", "RPT", "CALL", "PCALL", "MCALL", "MDOFF", "SUB", "RET", "PROBE", "ERROR", "EXEC", "REPOS", "DIGIT",
    "TRACE", "NEXIT", "MEXEC", "OPEN",
];
/// Letters of G65 that fill #1 and up; none where no letter does.
const ARGUMENTS: &[u8; 26] = b"ABCIJKDEF-H-M---QRSTUVWXYZ";

/// The text with its lines as those of macro B; as many lines as before.
pub(crate) fn translated(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (at, line) in text.split('\n').enumerate() {
        if at > 0 {
            out.push('\n');
        }
        match translated_line(line) {
            Some(line) => out.push_str(&line),
            None => out.push_str(line),
        }
    }
    out
}

fn translated_line(line: &str) -> Option<String> {
    // Plain blocks have none of these.
    if !line.bytes().any(|b| matches!(b, b'(' | b'P' | b'p' | b'T'))
        && !["G20", "G21", "G22", "G23", "G24", "G25", "G36", "G39"].iter().any(|word| line.contains(word))
    {
        return None;
    }
    let mut out = String::new();
    let mut rest = line;
    while let Some(open) = rest.find('(') {
        let (before, inside) = rest.split_at(open);
        let Some(close) = matching(inside) else { break };
        out.push_str(&words(before));
        let behind = inside.get(close + 1..).unwrap_or_default();
        let (statement, used) = statement(inside.get(1..close).unwrap_or_default(), behind);
        match statement {
            Some(text) => out.push_str(&text),
            None => out.push_str(inside.get(..=close).unwrap_or_default()),
        }
        rest = behind.get(used..).unwrap_or_default();
    }
    out.push_str(&words(rest));
    Some(out)
}

/// The bracket that closes the first one.
fn matching(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'(' => depth += 1,
            b')' => {
                depth = depth.checked_sub(1)?;
                if depth == 0 {
                    return Some(at);
                }
            }
            _ => {}
        }
    }
    None
}

/// A statement as text of macro B, and how many bytes after its bracket belong to it; none for a
/// comment.
fn statement(inside: &str, behind: &str) -> (Option<String>, usize) {
    let text = inside.trim().to_ascii_uppercase();
    let word: String = text.chars().take_while(char::is_ascii_alphabetic).collect();
    let tail = text.get(word.len()..).unwrap_or_default().trim();
    let unread = || (Some(format!("({UNREAD}{})", text.replace(['(', ')'], " "))), 0);
    if word == "P" && assignments(&text).is_some() {
        return (assignments(&text), 0);
    }
    if !STATEMENTS.contains(&word.as_str()) {
        return (None, 0);
    }
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let found = match word.as_str() {
        "GOTO" => tail.strip_prefix('N').and_then(number).map(|n| format!("GOTO{n}")),
        "IF" => conditional(tail),
        "SUB" => number(tail).map(|n| format!("O{n}")),
        "RET" if tail.is_empty() => Some("M99".to_owned()),
        "CALL" => number(tail).map(|n| format!("M98P{n}")),
        "PCALL" => {
            let (first, values) = tail.split_once(',').unwrap_or((tail, ""));
            number(first).and_then(|n| Some(format!("G65P{n}{}", arguments(values)?)))
        }
        "RPT" => {
            let blanks = behind.len() - behind.trim_start().len();
            let digits = behind
                .trim_start()
                .strip_prefix(['N', 'n'])
                .map_or(0, |rest| rest.bytes().take_while(u8::is_ascii_digit).count());
            let times = behind.trim_start().get(1..1 + digits).and_then(number).unwrap_or(1);
            let used = if digits > 0 { blanks + 1 + digits } else { 0 };
            let block = |text: &str| text.trim().strip_prefix('N').and_then(number);
            return match tail.split_once(',').and_then(|(a, b)| Some((block(a)?, block(b)?))) {
                Some((first, last)) => (Some(format!("RPT {first} {last} {times}")), used),
                None => unread(),
            };
        }
        _ => None,
    };
    found.map_or_else(unread, |text| (Some(text), 0))
}

/// `P1 LT 3 GOTO N30`, `P1 LT 3 P2=5`
fn conditional(text: &str) -> Option<String> {
    if text.contains(" ELSE ") {
        return None;
    }
    if let Some((condition, target)) = text.rsplit_once("GOTO") {
        let number: u32 = target.trim().strip_prefix('N')?.trim().parse().ok()?;
        return Some(format!("IF[{}]GOTO{number}", expression(condition.trim())));
    }
    // The action begins at the last parameter that `=` follows.
    let equals = text.rfind('=')?;
    let start = text.get(..equals)?.rfind('P')?;
    let (condition, action) = text.split_at(start);
    let (target, value) = action.split_once('=')?;
    Some(format!("IF[{}]THEN {}={}", expression(condition.trim()), expression(target.trim()), expression(value.trim())))
}

/// `P0=10,P1=P0*2`
fn assignments(text: &str) -> Option<String> {
    let mut out = String::new();
    for part in split(text) {
        let (target, value) = part.split_once('=')?;
        let number: u32 = target.trim().strip_prefix('P')?.trim().parse().ok()?;
        out.push_str(&format!("#{}={} ", parameter(number), expression(value.trim())));
    }
    (!out.is_empty()).then(|| out.trim_end().to_owned())
}

/// Parts between commas outside of brackets.
fn split(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0_i32, 0, Vec::new());
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'(' => depth += 1,
            b')' => depth -= 1,
            b',' if depth == 0 => {
                parts.push(text.get(start..at).unwrap_or_default());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text.get(start..).unwrap_or_default());
    parts
}

/// `A5,P1=3` as words of G65.
fn arguments(text: &str) -> Option<String> {
    let mut out = String::new();
    for part in split(text).into_iter().map(str::trim).filter(|part| !part.is_empty()) {
        let (index, value) = match part.split_once('=') {
            Some((target, value)) => (target.trim().strip_prefix('P')?.trim().parse::<usize>().ok()?, value),
            None => (usize::from(part.bytes().next()?.checked_sub(b'A')?), part.get(1..)?),
        };
        let letter = *ARGUMENTS.get(index).filter(|letter| letter.is_ascii_alphabetic())?;
        out.push_str(&format!("{}[{}]", char::from(letter), expression(value.trim().trim_start_matches('K'))));
    }
    Some(out)
}

fn parameter(number: u32) -> u32 {
    if number <= 25 { number + 1 } else { number }
}

/// Brackets as `[ ]`, parameters as `#`, a function of one parameter in brackets.
fn expression(text: &str) -> String {
    const FUNCTIONS: [&str; 8] = ["SIN", "COS", "TAN", "ASIN", "ACOS", "SQRT", "ABS", "FIX"];
    let mut out = String::new();
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let rest = text.get(at..).unwrap_or_default();
        if byte == b'P' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit) {
            let digits: String = rest.chars().skip(1).take_while(char::is_ascii_digit).collect();
            out.push_str(&format!("#{}", parameter(digits.parse().unwrap_or(u32::MAX - 1))));
            at += 1 + digits.len();
            continue;
        }
        if let Some(name) = FUNCTIONS.into_iter().find(|name| rest.starts_with(name)) {
            out.push_str(name);
            at += name.len();
            let behind = rest.get(name.len()..).unwrap_or_default();
            let operand = behind.trim_start();
            let length = operand.bytes().take_while(|b| b.is_ascii_digit() || matches!(b, b'P' | b'.')).count();
            if length > 0 {
                out.push_str(&format!("[{}]", expression(operand.get(..length).unwrap_or_default())));
                at += behind.len() - operand.len() + length;
            }
            continue;
        }
        match byte {
            b'(' => out.push('['),
            b')' => out.push(']'),
            _ => out.push(rest.chars().next().unwrap_or(' ')),
        }
        at += rest.chars().next().map_or(1, char::len_utf8);
    }
    out
}

/// Words of a block outside of brackets: `XP1`, `P1=K5`, `G20 N5.2`, `G36 R3`.
fn words(text: &str) -> String {
    // A comment after `;`.
    let (code, comment) = text.find(';').map_or((text, ""), |at| text.split_at(at));
    let mut upper = code.to_ascii_uppercase();
    if let Some(call) = old_call(&upper) {
        return call + comment;
    }
    for (word, short) in [("G36", ",R"), ("G39", ",C")] {
        if let Some((before, behind)) = upper.split_once(word)
            && let Some(size) = behind.trim_start().strip_prefix('R')
        {
            upper = format!("{before}{short}{}", size.trim_start());
        }
    }
    if let Some(both) = tool_and_offset(&upper) {
        upper = both;
    }
    if !upper.contains('P') {
        return upper + comment;
    }
    let mut out = String::new();
    let bytes = upper.as_bytes();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let rest = upper.get(at..).unwrap_or_default();
        let digits: String = rest.chars().skip(1).take_while(char::is_ascii_digit).collect();
        if byte == b'P' && !digits.is_empty() {
            let number = parameter(digits.parse().unwrap_or(u32::MAX - 1));
            let behind = rest.get(1 + digits.len()..).unwrap_or_default();
            // A value of the 8025: `P1=K10`, `P1=P2F1K3` with F1 to F4 as + - * /.
            if let Some(value) = behind.trim_start().strip_prefix('=') {
                let value: String =
                    value.split([' ', '\t', '\r']).find(|v| !v.is_empty()).unwrap_or_default().to_owned();
                let used = behind.find(&value).unwrap_or(0) + value.len();
                let old =
                    value.replace("F1", "+").replace("F2", "-").replace("F3", "*").replace("F4", "/").replace('K', "");
                out.push_str(&format!("#{number}={} ", expression(&old)));
                at += 1 + digits.len() + used;
                continue;
            }
            out.push_str(&format!("#{number}"));
            at += 1 + digits.len();
            continue;
        }
        out.push(rest.chars().next().unwrap_or(' '));
        at += rest.chars().next().map_or(1, char::len_utf8);
    }
    out + comment
}

/// `T1.2` of an 8025: tool 1 with offset 2.
fn tool_and_offset(text: &str) -> Option<String> {
    let at = text.find('T')?;
    let (before, rest) = text.split_at(at);
    let tool: String = rest.chars().skip(1).take_while(char::is_ascii_digit).collect();
    let behind = rest.get(1 + tool.len()..)?.strip_prefix('.')?;
    let offset: String = behind.chars().take_while(char::is_ascii_digit).collect();
    if tool.is_empty() || offset.is_empty() || text.contains('D') {
        return None;
    }
    Some(format!("{before}T{tool} D{offset}{}", behind.get(offset.len()..)?))
}

/// G20 to G25 of an 8025, alone in their block.
fn old_call(text: &str) -> Option<String> {
    let body = text.trim();
    let (number, body) = match body.strip_prefix('N') {
        Some(rest) => {
            let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
            (format!("N{digits} "), rest.get(digits.len()..)?.trim_start())
        }
        None => (String::new(), body),
    };
    if body == "G24" {
        return Some(format!("{number}M99"));
    }
    let (word, rest) = (body.get(..3)?, body.get(3..)?.trim_start().strip_prefix('N')?);
    let (place, values) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    let parts: Vec<u32> = place.split('.').map(str::parse).collect::<Result<_, _>>().ok()?;
    let text = match (word, parts.as_slice()) {
        ("G20", [program]) => format!("M98P{program}"),
        ("G20", [program, times]) => format!("M98P{program}L{times}"),
        ("G21", [program]) => {
            format!("G65P{program}{}", arguments(&values.split_whitespace().collect::<Vec<_>>().join(","))?)
        }
        ("G21", [program, times]) => {
            format!("G65P{program}L{times}{}", arguments(&values.split_whitespace().collect::<Vec<_>>().join(","))?)
        }
        ("G22" | "G23", [program]) => return Some(format!("O{program}")),
        ("G25", [target]) => format!("GOTO{target}"),
        ("G25", [first, last]) => format!("RPT {first} {last} 1"),
        ("G25", [first, last, times]) => format!("RPT {first} {last} {times}"),
        _ => return None,
    };
    Some(number + &text)
}

#[cfg(test)]
mod tests {
    use super::translated;

    #[test]
    fn statements_become_those_of_macro_b() {
        for (fagor, macro_b) in [
            ("(P0=10,P1=P0*2)", "#1=10 #2=#1*2"),
            ("(P100=SIN P1+(P2-3))", "#100=SIN[#2]+[#3-3]"),
            ("N30 (IF P1 LT 3 GOTO N30)", "N30 IF[#2 LT 3]GOTO30"),
            ("(IF P1 EQ 3 P2=5)", "IF[#2 EQ 3]THEN #3=5"),
            ("(RPT N50,N60)N3", "RPT 50 60 3"),
            ("(SUB 1)", "O1"),
            ("(RET)", "M99"),
            ("(CALL 1)", "M98P1"),
            ("(PCALL 7,P0=3,B4)", "G65P7A[3]B[4]"),
            ("N100 G1 XP0 Y-P30 F100 ; to P0", "N100 G1 X#1 Y-#30 F100 ; to P0"),
            ("N40 P1=P1F1K1", "N40 #2=#2+1 "),
            ("N30 G20 N1.2", "N30 M98P1L2"),
            ("(P1=SIN 30*4)", "#2=SIN[30]*4"),
            ("N15 T1.2 M6", "N15 T1 D2 M6"),
            ("N60 G25 N20.30.2", "N60 RPT 20 30 2"),
            ("N70 G1 G36 R3 Y50", "N70 G1 ,R3 Y50"),
            ("(tool 5 of the part)", "(tool 5 of the part)"),
            ("(MSG \"PART\")", "(MSG \"PART\")"),
            ("(MCALL 5)", "(!FAGOR MCALL 5)"),
            ("N10 G0 X10 Y10", "N10 G0 X10 Y10"),
        ] {
            assert_eq!(translated(fagor), macro_b, "{fagor}");
        }
    }

    #[test]
    fn no_text_makes_it_fail() {
        for text in ["(", "(P=)", "(IF)", "(RPT N1)", "P", "G25 N", "XPé", "(P1=é(", "G36", "(PCALL ,)", "N G24", "()"]
        {
            assert_eq!(translated(text).matches('\n').count(), 0);
        }
    }
}
