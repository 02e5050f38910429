//! Laws of the words of the 840D: writing does not matter, corners are tangential, polar is Cartesian.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use proveout_nc::{ArcMotion, Dialect, Op, Program, Settings, WorkOffset};

fn settings() -> Settings {
    let mut settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
    settings.work_offsets.insert("G54".to_owned(), WorkOffset { translation: [100.0, 200.0, 300.0], rotary: [0.0; 3] });
    for (name, value) in [("R1", 1.0), ("$P_TOOLR", 6.0)] {
        settings.variables.insert(name.to_owned(), value);
    }
    settings.subprogram_folders.push(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/siemens"));
    settings
}

fn ops(text: &str) -> Vec<Op> {
    Program::from_text("p.mpf", text, &settings())
        .unwrap()
        .map(|c| c.unwrap_or_else(|e| panic!("{e}\n{text}")).op)
        .collect()
}

/// Lower case outside of texts, with tabs for blanks and line numbers where there are none.
fn rewritten(text: &str) -> String {
    let mut out = String::new();
    for (at, line) in text.lines().enumerate() {
        let (code, _comment) = line.split_once(';').unwrap_or((line, ""));
        let mut quoted = false;
        let mut new = String::new();
        for c in code.chars() {
            quoted ^= c == '"';
            match c {
                ' ' if !quoted => new.push('\t'),
                c if !quoted => new.push(c.to_ascii_lowercase()),
                c => new.push(c),
            }
        }
        let bare = new.trim_start();
        let plain = !bare.is_empty() && !bare.starts_with(['/', '%', 'n', ':']);
        out.push_str(&if plain { format!("N{}  {bare} ; again\r\n", 10_000 + at) } else { new + "\r\n" });
    }
    out
}

#[test]
fn case_blanks_and_line_numbers_do_not_matter_for_any_word() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/siemens");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "mpf") {
            let text = fs::read_to_string(&path).unwrap();
            let (plain, other) = (ops(&text), ops(&rewritten(&text)));
            // Texts of notes show words as they were written.
            let shape = |ops: &[Op]| -> Vec<Op> {
                let upper = |op: &Op| match op {
                    Op::Note(note) => Op::Note(note.to_uppercase().replace('\t', " ").into()),
                    other => other.clone(),
                };
                ops.iter().map(upper).collect()
            };
            assert_eq!(shape(&plain), shape(&other), "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 15, "{count} programs");
}

/// Unit direction of an arc at a point of it.
fn tangent(arc: &ArcMotion, p: [f64; 2]) -> [f64; 2] {
    let r = [p[0] - arc.center_base[0], p[1] - arc.center_base[1]];
    let s = arc.normal_base[2] / r[0].hypot(r[1]);
    [-r[1] * s, r[0] * s]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(200), max_global_rejects: 100_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Lines with RND: every arc leaves the line before along its direction, enters the next along its, has
    /// the radius, and the path is shorter than the polygon by `2 r tan(a/2) - r a` at each corner that turns
    /// by a.
    #[test]
    fn roundings_are_tangential(points in prop::collection::vec((-100i32..100, -100i32..100), 3..8), radius in 0.1..3.0f64, modal in any::<bool>()) {
        let points: Vec<[f64; 2]> = points.iter().map(|&(x, y)| [f64::from(x), f64::from(y)]).collect();
        let direction = |a: [f64; 2], b: [f64; 2]| {
            let l = (b[0] - a[0]).hypot(b[1] - a[1]);
            ([(b[0] - a[0]) / l, (b[1] - a[1]) / l], l)
        };
        let (mut text, mut want) = (format!("G0 X{} Y{} Z0 F100\nG1\n", points[0][0], points[0][1]), 0.0);
        if modal {
            text.push_str(&format!("RNDM={radius}\n"));
        }
        let mut trims = vec![0.0; points.len()];
        for i in 1..points.len() {
            let (d, l) = direction(points[i - 1], points[i]);
            prop_assume!(l > 1.0);
            want += l;
            if i + 1 < points.len() {
                let (e, m) = direction(points[i], points[i + 1]);
                prop_assume!(m > 1.0);
                let turn = (d[0] * e[1] - d[1] * e[0]).abs().atan2(d[0] * e[0] + d[1] * e[1]);
                prop_assume!(turn < 3.0 && (turn > 1e-3 || turn == 0.0));
                trims[i] = radius * (0.5 * turn).tan();
                want -= 2.0 * trims[i] - radius * turn;
            }
            prop_assume!(trims[i - 1] + trims[i] < l - 1e-6);
            let word = if modal || i + 1 == points.len() { String::new() } else { format!(" RND={radius}") };
            text.push_str(&format!("X{} Y{}{word}\n", points[i][0], points[i][1]));
        }
        let (mut at, mut heading, mut length) = (points[0], None::<[f64; 2]>, 0.0);
        for op in ops(&text) {
            let (end, start_direction, end_direction, piece) = match &op {
                Op::Linear(m) => {
                    let end = [m.end_base.get(0).unwrap(), m.end_base.get(1).unwrap()];
                    let (d, l) = direction(at, end);
                    (end, d, d, l)
                }
                Op::Arc(a) => {
                    let end = [a.motion.end_base.get(0).unwrap(), a.motion.end_base.get(1).unwrap()];
                    prop_assert!((a.radius - radius).abs() < 1e-12);
                    (end, tangent(a, at), tangent(a, end), a.radius * a.sweep)
                }
                _ => continue,
            };
            if let Some(h) = heading {
                // Straight corners are none; all others are rounded.
                prop_assert!((h[0] - start_direction[0]).hypot(h[1] - start_direction[1]) < 1e-6, "{text}");
            }
            (at, heading) = (end, Some(end_direction));
            length += piece;
        }
        prop_assert!((length - want).abs() < 1e-6, "{length} {want} {text}");
    }

    /// The same at circles: line to circle, circle to circle, circle to line, in both senses.
    #[test]
    fn roundings_at_circles_are_tangential(
        ends in prop::array::uniform3(prop::array::uniform2(-30.0..30.0f64)), bend in prop::array::uniform2(-1.4..1.4f64), radius in 0.1..2.0f64,
    ) {
        let mut text = format!("RNDM={radius}\nG0 X-40 Y0 Z0 F100\nG1 X0 Y0\n");
        let mut at = [0.0, 0.0];
        for i in 0..2 {
            let chord = (ends[i][0] - at[0]).hypot(ends[i][1] - at[1]);
            prop_assume!(chord > 5.0 && bend[i].abs() > 0.2);
            let word = if bend[i] > 0.0 { "G3" } else { "G2" };
            text.push_str(&format!("{word} X{:.6} Y{:.6} CR={:.9}\n", ends[i][0], ends[i][1], 0.5 * chord / bend[i].abs().sin()));
            at = ends[i];
        }
        prop_assume!((ends[2][0] - at[0]).hypot(ends[2][1] - at[1]) > 5.0);
        text.push_str(&format!("G1 X{:.6} Y{:.6}\n", ends[2][0], ends[2][1]));
        let commands: Result<Vec<Op>, _> =
            Program::from_text("p.mpf", text.as_str(), &settings()).unwrap().map(|c| c.map(|c| c.op)).collect();
        let Ok(commands) = commands else {
            // Sharp corners between short blocks do not take every radius; the error says so.
            return Ok(());
        };
        let (mut at, mut heading, mut pieces) = ([f64::NAN; 2], None::<[f64; 2]>, 0);
        for op in commands {
            let (motion, arc) = match &op {
                Op::Rapid(m) | Op::Linear(m) => (m, None),
                Op::Arc(a) => (&a.motion, Some(a)),
                _ => continue,
            };
            let end = [motion.end_base.get(0).unwrap(), motion.end_base.get(1).unwrap()];
            let line = || {
                let l = (end[0] - at[0]).hypot(end[1] - at[1]);
                [(end[0] - at[0]) / l, (end[1] - at[1]) / l]
            };
            let (first, last) = arc.map_or_else(|| (line(), line()), |a| (tangent(a, at), tangent(a, end)));
            if let (Some(h), Op::Linear(_) | Op::Arc(_)) = (heading, &op) {
                // Six decimals of the ends and of CR on blocks of 5 mm and more turn tangents by less than
                // 1e-5.
                prop_assert!((h[0] - first[0]).hypot(h[1] - first[1]) < 1e-5, "{text}");
            }
            if let Some(a) = arc {
                // The sweep leads from where the block before ended to the end.
                let r = [at[0] - a.center_base[0], at[1] - a.center_base[1]];
                let (s, c) = (a.sweep * a.normal_base[2]).sin_cos();
                let reached = [a.center_base[0] + c * r[0] - s * r[1], a.center_base[1] + s * r[0] + c * r[1]];
                prop_assert!((reached[0] - end[0]).hypot(reached[1] - end[1]) < 1e-5, "{text}");
            }
            heading = if matches!(op, Op::Rapid(_)) { None } else { Some(last) };
            pieces += usize::from(arc.is_some_and(|a| (a.radius - radius).abs() < 1e-12));
            at = end;
        }
        prop_assert!(pieces == 3, "{pieces} roundings in {text}");
    }

    #[test]
    fn polar_points_are_cartesian_points(radius in 0.1..100.0f64, angle in -360.0..360.0f64, pole in prop::array::uniform2(-50.0..50.0f64), plane in 0..3usize) {
        let [u, v, w] = [["X", "Y", "Z"], ["Z", "X", "Y"], ["Y", "Z", "X"]][plane];
        let head = format!("G{} G0 X0 Y0 Z0 F100\n", 17 + plane);
        let polar = ops(&format!("{head}G111 {u}={} {v}={}\nG1 AP={angle} RP={radius} {w}=3\n", pole[0], pole[1]));
        let (s, c) = angle.to_radians().sin_cos();
        let plain = ops(&format!("{head}G1 {u}={} {v}={} {w}=3\n", pole[0] + radius * c, pole[1] + radius * s));
        let (Some(Op::Linear(a)), Some(Op::Linear(b))) = (polar.last(), plain.last()) else { panic!("no motions") };
        for i in 0..3 {
            prop_assert!((a.end_base.get(i).unwrap() - b.end_base.get(i).unwrap()).abs() < 1e-9);
        }
    }

    /// `CTRANS : CROT : CSCALE : CMIRROR` is TRANS, AROT, ASCALE, AMIRROR.
    #[test]
    fn frame_values_are_frame_words(shift in prop::array::uniform3(-99.0..99.0f64), turn in prop::array::uniform3(-180.0..180.0f64), scale in 0.2..4.0f64) {
        let [x, y, z] = shift;
        let [a, b, c] = turn;
        let values = ops(&format!(
            "DEF FRAME _T\n_T=CTRANS(X,{x},Y,{y},Z,{z}):CROT(X,{a},Y,{b},Z,{c})\n$P_PFRAME=_T:CSCALE(X,{scale},Y,{scale},Z,{scale}):CMIRROR(Y)\nG0 X1 Y2 Z3\n"
        ));
        let words = ops(&format!(
            "TRANS X{x} Y{y} Z{z}\nAROT X{a} Y{b} Z{c}\nASCALE X{scale} Y{scale} Z{scale}\nAMIRROR Y0\nG0 X1 Y2 Z3\n"
        ));
        let (Some(Op::Rapid(a)), Some(Op::Rapid(b))) = (values.last(), words.last()) else { panic!("no motions") };
        for i in 0..3 {
            prop_assert!((a.end_base.get(i).unwrap() - b.end_base.get(i).unwrap()).abs() < 1e-9);
        }
    }

    #[test]
    fn new_words_never_panic(picks in prop::collection::vec(0..SOUP.len(), 0..60)) {
        let text: String = picks.iter().map(|&i| SOUP[i]).collect();
        let mut settings = settings();
        settings.limits.max_loop_passes = 300;
        settings.limits.max_idle_passes = 50;
        let mut radii = proveout_nc::ToolRadii::default();
        radii.by_tool.insert(proveout_nc::ToolName::Number(1), 1.0);
        settings.compensation = proveout_nc::Compensation::ToolCenter(radii);
        if let Ok(program) = Program::from_text("p.mpf", text.as_str(), &settings) {
            for command in program {
                let Ok(command) = command else { break };
                if let Op::Rapid(m) | Op::Linear(m) = &command.op {
                    prop_assert!(m.end_base.iter().all(|(_, v)| v.is_finite()), "{text}");
                }
                if let Op::Arc(a) = &command.op {
                    prop_assert!(a.sweep > 0.0 && a.radius > 0.0 && a.center_base.iter().all(|v| v.is_finite()), "{text}");
                }
            }
        }
    }
}

const SOUP: &[&str] = &[
    "T1 M6 D1\nG0 X0 Y0 Z0 F100 S100\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "G41 ",
    "G42 ",
    "G40 ",
    "G451 ",
    "G450 ",
    "KONT ",
    "NORM ",
    "CUT2DF ",
    "G1 X10 ",
    "G1 Y10 ",
    "G0 X20 Y5 ",
    "G2 X=IC(5) Y=IC(5) CR=5 ",
    "G3 X=IC(-5) Y=IC(5) I-5 J0 ",
    "G3 I5 ",
    "Z=IC(-1) ",
    "D0 ",
    "D2 ",
    "RND=1 ",
    "CHF=0.5 ",
    "CHR=1 ",
    "RNDM=0.5 ",
    "RNDM=0 ",
    "FRC=50 ",
    "FRCM=20 ",
    "G110 X1 Y1 ",
    "G111 ",
    "G112 X1 ",
    "AP=30 ",
    "RP=5 ",
    "AP=IC(40) ",
    "G18 ",
    "G17 ",
    "MIRROR X0 ",
    "TRANS X5 ",
    "AROT Z30 ",
    "AROT X30 ",
    "SCALE X2 Y2 Z2 ",
    "SCALE X2 ",
    "G58 X1 ",
    "G59 Y1 ",
    "$P_PFRAME=CTRANS(X,1):CROT(Z,20) ",
    "DEF FRAME _F ",
    "_F=$P_PFRAME:CMIRROR(X) ",
    "$P_UIFR[1]=_F ",
    "G54 ",
    "R1=$P_EP[X] ",
    "R2=$P_UIFR[1,X,TR] ",
    "X=$P_GG[1] ",
    "G33 Z=IC(-2) K1 ",
    "G331 Z-1 K1 ",
    "G332 Z1 K-1 ",
    "G63 Z2 ",
    "CYCLE84(10,0,1,-5,,,5,6,,,100) ",
    "CYCLE840(10,0,1,-5) ",
    "CYCLE86(10,0,1,-5,,1,3,1,1,1) ",
    "CYCLE88(10,0,1,-5) ",
    "MCALL CYCLE89(10,0,1,-5) ",
    "MCALL ",
    "FB=50 ",
    "OVR=50 ",
    "POS[B]=20 ",
    "G25 X1 ",
    "GOTOC AB ",
    "GOTOS ",
    "SUPA X5 ",
    "TRAORI ",
    "TRAFOOF ",
    "A3=1 ",
    "B10 ",
    "M30 ",
    "G91 ",
    "G90 ",
    "G93 ",
    "G94 ",
    "CIP X=IC(5) Y=IC(1) I1=IC(2) J1=IC(3) K1=IC(0) ",
];

/// FRC= is the feed of a corner: without one it does nothing, and the reader says so.
#[test]
fn a_feed_of_a_corner_without_a_corner_is_reported() {
    let notes = |text: &str| {
        ops(text).into_iter().filter(|op| matches!(op, Op::Note(n) if n.starts_with("FRC= has no effect"))).count()
    };
    let part = |block: &str| format!("G17 G90 G94 G710\nG1 X0 Y0 F100\n{block}\nY20\nM30\n");
    assert_eq!(notes(&part("X20 FRC=50")), 1);
    assert_eq!(notes(&part("X20 RND=0 FRC=50")), 1);
    assert_eq!(notes(&part("FRC=50")), 1);
    assert_eq!(notes(&part("X20 RND=2 FRC=50")), 0);
    assert_eq!(notes(&part("RNDM=2 X20 FRC=50")), 0);
}

/// Words in backticks of the rows of the coverage table whose first cell starts so.
fn table_words(first_cells: &[&str]) -> Vec<String> {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let section = readme.split("## Coverage: Siemens 840D sl").nth(1).unwrap().split("\n## ").next().unwrap();
    let mut words = Vec::new();
    for row in section.lines().filter(|line| line.starts_with('|')) {
        let mut cells = row.trim_matches('|').splitn(2, '|');
        let (head, body) = (cells.next().unwrap_or("").trim(), cells.next().unwrap_or(""));
        if first_cells.contains(&head) {
            let quoted: Vec<&str> = body.split('`').skip(1).step_by(2).collect();
            words.extend(quoted.iter().flat_map(|q| q.split_whitespace()).map(str::to_owned));
        }
    }
    words
}

fn codes(line: &str) -> Vec<&'static str> {
    let text = format!("T1 M6 D1\nG0 X0 Y0 Z0 F100 S100\n{line}\n");
    proveout_nc::check_text("p.mpf", &text, &settings()).iter().map(|d| d.code).collect()
}

#[test]
fn words_of_the_table_that_are_refused_are_refused_by_name() {
    let mut count = 0;
    for word in table_words(&["**refused by name**"]) {
        let line = match word.as_str() {
            // Refused in a state or with arguments that the table names with them.
            "KONTC" | "KONTT" => format!("{word}\nG1 G41 X10"),
            "DISC=" => "DISC=50\nG1 G41 X10".to_owned(),
            "ID=" => "ID=1 EVERY $A_IN[1]==1 DO M5".to_owned(),
            "CYCLE81" => "CYCLE81(10,0,2,-5,,1,0,0)".to_owned(),
            "GMODE" | "DMODE" => continue,
            "CYCLE800" => "CYCLE800(0,\"T\",0,192,0,0,0,10,0,0,0,0,0,1)".to_owned(),
            "$AA_IM[X]" => "R1=$AA_IM[X]".to_owned(),
            "$MA_" | "$MC_" => format!("R1={word}NAME[1]"),
            "$" => "R1=$XY".to_owned(),
            word if word.ends_with('=') => format!("{word}1"),
            word => word.to_owned(),
        };
        let found = codes(&line);
        assert!(found.contains(&"nc-unsupported-word"), "{line}: {found:?}");
        count += 1;
    }
    assert!(count > 60, "{count} words");
}

#[test]
fn words_of_the_table_that_are_read_are_neither_unknown_nor_refused() {
    let rows = [
        "motion",
        "threads",
        "offsets, frames",
        "compensation",
        "five axes",
        "technology",
        "path",
        "cycles",
        "**a note** (`Op::Note`, named and without effect)",
        "control",
        "system variables",
    ];
    let (mut count, mut wrong) = (0, Vec::new());
    for word in table_words(&rows) {
        let line = match word.as_str() {
            // Parts of statements, tried in the case folders.
            "IF" | "ELSE" | "ENDIF" | "FOR" | "WHILE" | "REPEAT" | "UNTIL" | "LOOP" | "CASE" | "GOTO" | "GOTOF"
            | "GOTOB" | "GOTOS" | "LABEL" | "REPEATB" | "PROC" | "VAR" | "SAVE" | "L100" | "P3" | "CALL"
            | "\"NAME\"" | "EXTCALL" | "EXTERN" | "\"" | "Op::Note" | "TR" | "RT" | "P" | "R" => continue,
            "MSG" => "MSG(\"A\")".to_owned(),
            "SD=2" | "POLY" => word.clone(),
            "PW=" | "PL=" => format!("BSPLINE X1 {word}1"),
            "PO[X]=(..)" => "POLY PO[X]=(1,2)".to_owned(),
            "GOTOC" => "GOTOC AB".to_owned(),
            "T=\"" => "T=\"A\"".to_owned(),
            word if word.starts_with('$') => {
                format!("R1={}", word.replace("[n]", "[1,X,TR]").replace("$P_GG[1,X,TR]", "$P_GG[1]"))
                    .replace("$P_IFRAME", "$P_IFRAME[X,TR]")
                    .replace("$P_PFRAME", "$P_PFRAME[X,TR]")
                    .replace("$P_BFRAME", "$P_BFRAME[X,TR]")
                    .replace("$P_ACTFRAME", "$P_ACTFRAME[X,TR]")
                    .replace("FRAME[0]", "FRAME[0,X,TR]")
                    .replace("CHBFR[0]", "CHBFR[0,X,TR]")
            }
            word if word.ends_with("()") => format!("B={}", word.replace("()", "(1)")),
            word if word.ends_with('=') => format!("{word}1"),
            // Functions of frames.
            word if word.starts_with('C') && ["CTRANS", "CROT", "CSCALE", "CFINE"].contains(&word) => {
                format!("$P_PFRAME={word}(X,1)")
            }
            "CMIRROR" => "$P_PFRAME=CMIRROR(X)".to_owned(),
            "CRPL" => "$P_PFRAME=CRPL(0,5)".to_owned(),
            word if word.len() == 1 => format!("{word}1"),
            word => word.to_owned(),
        };
        // $P_TOOLR needs the radii of the tools, $AA_IM a rotary axis.
        if word == "$P_TOOLR" || word == "$P_DRYRUN" && line.is_empty() {
            continue;
        }
        let line = if word.starts_with("$AA_IM") { format!("G0 B0\n{line}") } else { line };
        let found = codes(&line);
        if found.iter().any(|c| matches!(*c, "nc-unknown-word" | "nc-unsupported-word" | "nc-unknown-variable")) {
            wrong.push(format!("{line}: {found:?}"));
        }
        count += 1;
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count > 150, "{count} words");
}
