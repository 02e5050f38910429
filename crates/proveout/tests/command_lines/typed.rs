//! What replaces the words in capitals when a command of a page is typed in the sandbox.

use super::pages::Shown;

/// Value of a word in capitals, by subcommand, option before it (empty: a positional argument) and word.
const VALUES: &[(&str, &str, &str, &str)] = &[
    ("run", "", "SCENE", "part"),
    ("run", "--program", "NAME", "main"),
    ("run", "--nc", "FILE", "stand-in.mpf"),
    ("run", "--orientation-maps", "PLACES", "5"),
    ("calibrate", "", "SCENE", "mill"),
    ("calibrate", "--trace", "FILE", "air.csv"),
    ("compare", "", "SCENE", "part"),
    ("compare", "--baseline", "NAME", "other"),
    ("check", "", "PATH...", "part"),
    ("check", "", "FOLDER", "machines/starrag-lx-451"),
    ("check", "", "NAME", "starrag-lx-451"),
    ("check", "", "MACHINE", "machines/three-axis-mill"),
    ("check", "--picture", "FILE", "machine.png"),
    ("migrate", "", "FILE...", "shop.toml"),
    ("migrate", "", "SCENE", "before"),
    ("job", "", "JOB", "tests/job"),
    ("sweep", "", "SWEEP", "tests/sweep"),
    ("completions", "", "SHELL", "zsh"),
    ("completions", "--output", "FILE", "out/proveout.sh"),
    ("manual", "", "DIR", "out/manual"),
    ("run", "--set", "KEY=VALUE", "tolerances.near_miss_mm=1"),
    ("new", "", "PROGRAM", "tests/first-part/plate.nc"),
    ("new", "", "PROGRAM...", "tests/first-part/plate.nc"),
    ("new", "--machine", "NAME", "three-axis-mill"),
    ("new", "--output", "DIR", "out-of-the-table"),
    ("tools", "", "FILE", "tests/first-part/shop.csv"),
    ("tools", "--output", "FILE", "made-tools.toml"),
    ("machine", "", "FILE", "tests/first-part/bench.ini"),
    ("machine", "--output", "DIR", "made-machine"),
    ("machine", "--table-axes", "XY", "XY"),
    ("machine", "--reverse", "Y,C", "Y,C"),
    ("nc", "", "PROGRAM", "part/main.mpf"),
    ("nc --dialect", "", "PROGRAM", "part/fanuc.nc"),
    ("nc", "--post", "DIALECT", "fanuc"),
    ("blade", "", "SCENE", "scenes/li-2022-s-theta"),
    ("blade", "--output", "FILE", "blade.stl"),
    ("plan", "", "SCENE", "scenes/li-2022-s-theta"),
    ("plan", "--output", "FILE", "helix.apt"),
    ("reschedule", "", "SCENE", "scenes/li-2022-s-theta"),
    ("reschedule", "--program", "NAME", "original"),
    ("reschedule", "--method", "METHOD", "s-theta"),
    ("reschedule", "--output", "FILE", "made.mpf"),
    ("feeds", "", "SCENE", "tests/feeds"),
    ("feeds", "--limits", "FILE", "tests/feeds/limits.toml"),
    ("feeds", "--output", "FILE", "step-other.nc"),
    ("kinematics", "", "MACHINE", "machines/starrag-lx-451"),
    ("kinematics", "", "FOLDER", "machines/starrag-lx-451"),
    ("measure", "", "RUN", "out/part-main"),
    ("measure", "", "FILE", "patch.sdf"),
    ("measure", "--profile", "FILE", "gauge.smd"),
    ("measure", "--distance", "X,Y,Z", "10,0,5"),
    ("measure", "--wall", "X,Y,Z,DX,DY,DZ", "0,-30,-1,0,1,0"),
    ("diff", "", "RUN_A", "out/part-main"),
    ("diff", "", "RUN_B", "out/part-other"),
    ("verify", "", "RUN", "out/part-main"),
    ("verify", "--public-key", "FILE", "public.pem"),
    ("sign", "", "RUN", "out/part-main"),
    ("sign", "--key", "FILE", "key.pem"),
    ("view", "", "RUN", "out/part-main"),
];

/// A command as it is typed: words after the program's name, and the file on its standard input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Typed {
    /// Pages that show it.
    pub(crate) places: Vec<String>,
    /// Words after `proveout`.
    pub(crate) words: Vec<String>,
    /// File at standard input.
    pub(crate) input: Option<String>,
}

impl Typed {
    /// The command in one line.
    pub(crate) fn line(&self) -> String {
        let input = self.input.as_ref().map_or_else(String::new, |f| format!(" < {f}"));
        format!("proveout {}{input}", self.words.join(" "))
    }

    /// A name for a file.
    pub(crate) fn name(&self) -> String {
        let mut name = String::new();
        for c in self.line().trim_start_matches("proveout ").chars() {
            if c.is_ascii_alphanumeric() || matches!(c, '.' | '=') {
                name.push(c);
            } else if !name.ends_with('_') {
                name.push(if c == '-' { '-' } else { '_' });
            }
        }
        name.trim_matches('_').chars().take(120).collect()
    }

    /// A command that a page shows; its words in capitals get their values.
    pub(crate) fn new(shown: &Shown) -> Result<Self, String> {
        let words = shown.of_product().unwrap_or_default();
        let subcommand = match words.first().map_or("", String::as_str) {
            // The program is one in that dialect.
            "nc" if words.iter().any(|w| w == "--dialect") => "nc --dialect",
            other => other,
        };
        let (mut out, mut input, mut option) = (Vec::new(), None, "");
        let mut rest = words.iter();
        while let Some(word) = rest.next() {
            match word.as_str() {
                "<" => input = rest.next().cloned(),
                // Standard output is compared, wherever the shell sends it.
                ">" | "|" => {
                    rest.by_ref().for_each(drop);
                }
                _ => {
                    out.push(filled(subcommand, option, word).map_err(|w| {
                        format!("{}: `{}` has {w}: give it a value in VALUES of typed.rs", shown.place, words.join(" "))
                    })?);
                    option = if word.starts_with("--") { word } else { "" };
                }
            }
        }
        Ok(Self { places: vec![shown.place.clone()], words: out, input })
    }
}

/// The word with the values of its capitals.
fn filled(subcommand: &str, option: &str, word: &str) -> Result<String, String> {
    let bare = |c: char| c.is_ascii_uppercase() || c == '_';
    let parts: Vec<&str> = word.split('/').collect();
    // `X,Y,Z` and `PATH...` are one word; otherwise a part of a path is.
    let whole = word.trim_end_matches("...").split(',').all(|p| !p.is_empty() && p.chars().all(bare));
    let value = |part: &str| {
        VALUES.iter().find(|(s, o, w, _)| *s == subcommand && *o == option && *w == part).map(|(.., v)| (*v).to_owned())
    };
    if whole {
        return value(word).ok_or_else(|| word.to_owned());
    }
    let part = |p: &&str| {
        if p.chars().all(bare) && !p.is_empty() { value(p).ok_or_else(|| (*p).to_owned()) } else { Ok((*p).to_owned()) }
    };
    Ok(parts.iter().map(part).collect::<Result<Vec<_>, _>>()?.join("/"))
}

/// Commands that can be typed, each once, in the order in which one leaves what the next one reads: scenes
/// that are made, then runs, but for those of planned programs.
pub(crate) fn typed(shown: &[Shown]) -> Result<Vec<Typed>, String> {
    let mut all: Vec<Typed> = Vec::new();
    for one in shown.iter().filter(|s| s.can_be_typed()) {
        let typed = Typed::new(one)?;
        match all.iter_mut().find(|t| (&t.words, &t.input) == (&typed.words, &typed.input)) {
            Some(known) => known.places.extend(typed.places),
            None => all.push(typed),
        }
    }
    let after = |t: &Typed, option: &str| t.words.iter().skip_while(|w| *w != option).nth(1).cloned();
    let planned: Vec<String> = all
        .iter()
        .filter(|t| t.words.first().is_some_and(|w| w == "plan"))
        .filter_map(|t| after(t, "--output"))
        .collect();
    let rank = |t: &Typed| match t.words.first().map(String::as_str) {
        // What a plan writes is run when it is there.
        // What a scene is made of comes before it runs.
        Some("new" | "tools" | "machine") => 0,
        Some("run") if after(t, "--nc").is_some_and(|nc| planned.contains(&nc)) => 4,
        Some("run") => 1,
        Some("sweep") if t.words.get(1).is_some_and(|w| w == "plan") => 0,
        Some("sweep") if t.words.get(1).is_some_and(|w| w == "run") => 1,
        Some("compare") => 2,
        _ => 3,
    };
    all.sort_by_key(|t| (rank(t), t.line()));
    Ok(all)
}
