//! Formulas of ten thousand terms without a bracket: every language, every operator.

use crate::hostile::workshop::{Workshop, proveout};

const TERMS: usize = 10_000;

/// Language, ending, the text before the formula and after it, and its operators with an operand.
type Language = (&'static str, &'static str, &'static str, &'static [(&'static str, &'static str)]);

const LANGUAGES: [Language; 6] = [
    (
        "siemens-840d",
        "R1=",
        "\nG0 X=R1\nM30\n",
        &[
            ("+", "1"),
            ("-", "1"),
            ("*", "1"),
            ("/", "1"),
            (" DIV ", "1"),
            (" MOD ", "7"),
            (" B_AND ", "1"),
            (" B_OR ", "1"),
            (" B_XOR ", "1"),
            (" AND ", "1"),
            (" OR ", "1"),
            (" XOR ", "1"),
            ("==", "1"),
            ("<>", "1"),
            ("<=", "1"),
            (">=", "1"),
            ("<", "1"),
            (">", "1"),
            ("<<", "1"),
        ],
    ),
    ("siemens-840d", "$P_UIFR[1]=", "\nG54 G0 X0\nM30\n", &[(":", "CTRANS(X,1)")]),
    (
        "fanuc",
        "O1\n#1=",
        "\nG0 X#1\nM30\n",
        &[
            ("+", "1"),
            ("-", "1"),
            ("*", "1"),
            ("/", "1"),
            (" MOD ", "7"),
            (" AND ", "1"),
            (" OR ", "1"),
            (" XOR ", "1"),
            (" EQ ", "1"),
            (" NE ", "1"),
            (" GT ", "1"),
            (" GE ", "1"),
            (" LT ", "1"),
            (" LE ", "1"),
        ],
    ),
    (
        "linuxcnc",
        "#1=[",
        "]\nG0 X#1\nM2\n",
        &[
            ("+", "1"),
            ("-", "1"),
            ("*", "1"),
            ("/", "1"),
            ("**", "1"),
            (" MOD ", "7"),
            (" AND ", "1"),
            (" OR ", "1"),
            (" XOR ", "1"),
            (" EQ ", "1"),
            (" GT ", "1"),
        ],
    ),
    (
        "heidenhain",
        "BEGIN PGM A MM\nQ1 = ",
        "\nL X+Q1 R0 FMAX\nEND PGM A MM\n",
        &[(" + ", "1"), (" - ", "1"), (" * ", "1"), (" / ", "1"), (" % ", "7"), (" ^ ", "1")],
    ),
    ("heidenhain", "BEGIN PGM A MM\nQS1 = ", "\nL X+1 R0 FMAX\nEND PGM A MM\n", &[(" || ", "\"a\"")]),
];

#[test]
fn chains_of_every_operator_end_in_every_language() {
    let shop = Workshop::new();
    for (dialect, before, behind, operators) in LANGUAGES {
        for (operator, operand) in operators {
            let chain = vec![*operand; TERMS].join(operator);
            shop.write("chain.txt", format!("{before}{chain}{behind}"));
            let output = proveout(shop.path(), &["nc", "chain.txt", "--dialect", dialect]);
            assert!(matches!(output.code(), Some(0 | 2)), "{dialect} {operator}: {:?}", output.status);
            if *operator == "+" || *operator == " + " {
                assert_eq!(output.code(), Some(0), "{dialect}: {}", output.text);
                assert!(output.text.contains("10000"), "{dialect}: the sum is not there");
            }
        }
    }
}

#[test]
fn signs_brackets_and_functions_count_as_depth() {
    let shop = Workshop::new();
    let deep = [
        ("siemens-840d", "R1=", "-", "1", "", "\nM30\n"),
        ("siemens-840d", "R1=", "(", "1", ")", "\nM30\n"),
        ("siemens-840d", "R1=", "SIN(", "1", ")", "\nM30\n"),
        ("siemens-840d", "R1=", "R[", "1", "]", "\nM30\n"),
        ("siemens-840d", "R1=", "NOT ", "1", "", "\nM30\n"),
        ("fanuc", "#1=", "[", "1", "]", "\nM30\n"),
        ("fanuc", "#1=", "#[", "1", "]", "\nM30\n"),
        ("fanuc", "#1=", "SIN[", "1", "]", "\nM30\n"),
        ("fanuc", "#1=", "#", "1", "", "\nM30\n"),
        ("linuxcnc", "#1=[", "-", "1", "", "]\nM2\n"),
        ("heidenhain", "BEGIN PGM A MM\nQ1 = ", "SIN ", "1", "", "\nEND PGM A MM\n"),
        ("heidenhain", "BEGIN PGM A MM\nQ1 = ", "(", "1", ")", "\nEND PGM A MM\n"),
        ("heidenhain", "BEGIN PGM A MM\nQ1 = ", "-", "1", "", "\nEND PGM A MM\n"),
    ];
    for (dialect, before, open, inner, close, behind) in deep {
        shop.write("deep.txt", format!("{before}{}{inner}{}{behind}", open.repeat(TERMS), close.repeat(TERMS)));
        let output = proveout(shop.path(), &["nc", "deep.txt", "--dialect", dialect]);
        assert_eq!(output.code(), Some(2), "{dialect} {open}: {}", output.text);
    }
}
