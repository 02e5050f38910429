//! The report as a reader uses it: the program runs a scene with a hundred findings, Chromium opens the page,
//! and every control of it is clicked. Without Chromium the tests pass and say by name that no one has
//! looked. `PROVEOUT_PAGES=FOLDER` keeps pictures of the page.

#![cfg(unix)]

mod browser;
mod player;

use std::{
    env, fs,
    io::Write,
    path::{Path, PathBuf},
    process::Command,
};

use browser::Browser;
use tempfile::TempDir;

const SCENE: &str = r#"
name = "page"
description = "A plate with errors in its program"
machine = "MACHINE"
tools = "tools.toml"
resolution_mm = 1

[stock.box]
min_mm = [0, 0, -20]
max_mm = [100, 80, 0]

[part]
mesh = "plate.stl"

[mount]
translation_mm = [0, 0, 100]

[work_offsets.G54]
Z_mm = 100

[[fixture]]
name = "stop"
box = { min_mm = [-40, 20, 60], max_mm = [-1, 60, 110] }

[[inspect]]
name = "top face"
from_mm = [50, 3, 30]
direction = "-z"
nominal_mm = -2
tolerance_mm = 0.05

[[program]]
name = "plate"
file = "plate.nc"
"#;

const TOOLS: &str = r#"
[[tool]]
number = 1
name = "END_D10"
kind = "flat"
diameter_mm = 10
flute_length_mm = 12
shank_diameter_mm = 10
gauge_length_mm = 70
flutes = 3
center_cutting = true
holder = { sections = [{ diameter_mm = 40, length_mm = 40 }] }

[[tool]]
number = 2
name = "END_D6"
kind = "flat"
diameter_mm = 6
flute_length_mm = 10
shank_diameter_mm = 6
gauge_length_mm = 60
flutes = 3
center_cutting = true
holder = { sections = [{ diameter_mm = 30, length_mm = 36 }] }
"#;

/// Rows over a plate; every row ends in a rapid through the material of the next one, some rows are too deep,
/// and there is one that leaves the travel.
fn program(rows: u32) -> String {
    let mut text = String::from(
        "%\nO100 (PLATE)\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS5000 M3\n(ROUGH)\nG0 X-10. Y0. Z20.\n",
    );
    for k in 0..rows {
        let y = 80.0 * f64::from(k) / f64::from(rows);
        let z = if k % 9 == 4 { -4.5 } else { -2.0 };
        text += &format!("G0 Z5.\nX-8. Y{y:.2}\nG1 Z{z} F400\nX60. F1500\nG4 P1.2\nG0 X92.\nG4 P1.2\nG0 Z5.\n");
    }
    text += "T2 M6\nG43 H2\nS8000 M3\n(GROOVE)\nG0 X20. Y10. Z5.\nG1 Z-16. F200\nX80. F600\nG0 Z5.\nG0 X2000.\nG0 X0.\nM0\nM5\nM30\n%\n";
    text
}

/// A box as ASCII STL.
fn plate() -> String {
    let (low, high) = ([0.0, 0.0, -20.0], [100.0, 80.0, -2.0]);
    let corner = |k: usize| [0, 1, 2].map(|a| if k >> a & 1 == 1 { high[a] } else { low[a] });
    let faces = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    let mut text = String::from("solid plate\n");
    for face in faces {
        text += "facet normal 0 0 0\nouter loop\n";
        for k in face {
            let [x, y, z] = corner(k);
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid plate\n"
}

fn run(rows: u32) -> (TempDir, PathBuf) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let machine = root.join("machines/three-axis-mill").display().to_string();
    let (folder, result, printed) = ran(&SCENE.replace("MACHINE", &machine), &program(rows));
    assert!(printed.contains("finding at"), "{printed}");
    assert!(rows < 20 || printed.contains("further findings are counted"), "{printed}");
    (folder, result)
}

/// Another scene and program, with findings or without.
fn run_with(scene: &str, program: &str) -> (TempDir, PathBuf) {
    let (folder, result, _) = ran(scene, program);
    (folder, result)
}

/// The folder, the result and what was printed.
fn ran(scene: &str, program: &str) -> (TempDir, PathBuf, String) {
    let folder = tempfile::tempdir().expect("temporary folder");
    for (name, text) in [
        ("scene.toml", scene.to_owned()),
        ("tools.toml", TOOLS.to_owned()),
        ("plate.nc", program.to_owned()),
        ("plate.stl", plate()),
    ] {
        fs::write(folder.path().join(name), text).expect("written");
    }
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder.path())
        .args(["run", ".", "--output", "result", "--rerun", "off"])
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 1 | 3)), "{printed}");
    let result = folder.path().join("result");
    (folder, result, printed)
}

/// A browser, or a line that says that no one has looked.
fn looked(what: &str) -> Option<Browser> {
    let browser = Browser::start();
    if browser.is_none() {
        // Past the capture of the test harness, so that the line is seen.
        writeln!(std::io::stdout(), "\nLEFT OUT: {what}: no Chromium on the path, and PROVEOUT_CHROMIUM names none")
            .ok();
    }
    browser
}

/// Keeps a picture of the page where pictures are asked for.
fn keep(browser: &mut Browser, name: &str) {
    if let Ok(folder) = env::var("PROVEOUT_PAGES") {
        fs::write(Path::new(&folder).join(format!("{name}.b64")), browser.picture()).expect("written");
    }
}

#[test]
fn a_page_of_a_hundred_findings_is_read_and_every_control_works() {
    let (_folder, result) = run(48);
    let verdict: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(result.join("verdict.json")).expect("a verdict")).expect("JSON");
    let findings = verdict["findings"].as_array().expect("findings");
    assert!(findings.len() >= 80, "{} findings", findings.len());
    let inspection = fs::read_to_string(result.join("inspection.csv")).expect("an inspection table");
    assert!(inspection.starts_with("feature,nominal_mm") && inspection.contains("top face,-2.000000,0.050000,"));
    let page = result.join("report.html");
    let size = fs::metadata(&page).expect("a page").len();
    assert!(size < 1_500_000, "the page has {size} bytes");
    let Some(mut b) = looked("the report in a browser") else { return };

    b.window(1280, 900, false);
    b.open(&page);
    b.wait("document.documentElement.dataset.bench === 'ready'");
    b.settle();
    // A page of a hundred findings was 39,820 points high.
    let height = b.number("document.documentElement.scrollHeight");
    assert!(height < 5500.0, "the page is {height} points high");
    keep(&mut b, "1280");

    findings_fold_and_filter(&mut b);
    tables_sort_and_filter(&mut b);
    the_view_turns_and_colors(&mut b);
    program_and_part_belong_together(&mut b);
    every_control_can_be_clicked(&mut b);

    for (width, dark, name) in [
        (1280, true, "1280-dark"),
        (700, false, "700"),
        (700, true, "700-dark"),
        (420, false, "420"),
        (420, true, "420-dark"),
        (400, false, "400"),
    ] {
        b.window(width, 900, dark);
        b.open(&page);
        b.wait("document.documentElement.dataset.bench === 'ready'");
        let wide = b.number("document.documentElement.scrollWidth");
        assert!(wide <= f64::from(width), "{wide} points at {width}");
        keep(&mut b, name);
    }
    b.value("document.querySelectorAll('#findings details').forEach((d, k) => { d.open = k < 3; })");
    b.settle();
    b.window(1280, 900, false);
    keep(&mut b, "findings");
    let paper = b.print();
    assert!(paper.len() > 20_000, "{} characters of paper", paper.len());
    assert!(b.errors.is_empty(), "{:#?}", b.errors);
    writeln!(std::io::stdout(), "{} findings: {height} points high, {} KB", findings.len(), size / 1000).ok();
}

/// Groups and causes open and close, all at once and one by one, and a text picks some.
fn findings_fold_and_filter(b: &mut Browser) {
    let open = "document.querySelectorAll('#findings details[open]').length";
    let all = b.number("document.querySelectorAll('#findings details').length");
    assert!(b.number(open) < all);
    b.click("#findings [data-fold=open]");
    assert_eq!(b.number(open), all);
    b.click("#findings [data-fold=close]");
    assert_eq!(b.number(open), 0.0);
    b.click("#findings .group > summary");
    assert_eq!(b.number(open), 1.0);
    b.click("#findings .group[open] .cause > summary");
    assert_eq!(b.number(open), 2.0);
    let seen = "[...document.querySelectorAll('#findings .cause')].filter((e) => !e.hidden).length";
    let causes = b.number(seen);
    b.click("#findings [data-filters]");
    b.write("holder");
    let some = b.number(seen);
    assert!(some > 0.0 && some < causes, "{some} of {causes}");
    b.value("(() => { const f = document.querySelector('#findings [data-filters]'); f.value = ''; f.dispatchEvent(new Event('input')); })()");
    assert_eq!(b.number(seen), causes);
    // Each has what explains it.
    b.click("#findings [data-fold=open]");
    assert!(b.number("document.querySelectorAll('.cause .program .here-line').length") > 3.0);
    assert!(b.number("document.querySelectorAll('.cause img').length") > 1.0);
    let words = b.text("document.querySelector('#findings').innerText");
    for word in ["sim_time", "END_D10", "chosen", "Show the place on the part"] {
        assert!(words.contains(word), "{word} is not in {words}");
    }
}

/// Every column of every table puts its rows in another order, and back.
fn tables_sort_and_filter(b: &mut Browser) {
    let tables = b.number("document.querySelectorAll('table.sorts').length") as usize;
    assert!(tables > 3);
    let first =
        "[...document.querySelector('#findings .all table.sorts').tBodies[0].rows].map((r) => r.cells[2].textContent)";
    let before = b.value(first);
    let head = "#findings .all table.sorts th:nth-child(3) .sort";
    b.click(head);
    let up = b.value(first);
    b.click(head);
    let down = b.value(first);
    let reversed: Vec<_> = up.as_array().expect("times").iter().rev().cloned().collect();
    assert_eq!(before, up, "findings come in order of time");
    assert_eq!(down[0], reversed[0]);
    assert_eq!(
        b.text("document.querySelector('#findings .all table.sorts th:nth-child(3)').getAttribute('aria-sort')"),
        "descending"
    );
    let rows =
        "[...document.querySelector('#findings .all table.sorts').tBodies[0].rows].filter((r) => !r.hidden).length";
    let all = b.number(rows);
    b.click("#findings .all .filter");
    b.write("line 13");
    assert!(b.number(rows) < all);
}

/// Buttons, keys, mouse and wheel move the view; colors and scales change.
fn the_view_turns_and_colors(b: &mut Browser) {
    let state = "JSON.stringify(proveoutPage.view.state())";
    let mut last = b.text(state);
    let mut changed = |b: &mut Browser, what: &str| {
        let now = b.text(state);
        assert_ne!(now, last, "{what} changes nothing");
        last = now;
    };
    for view in ["top", "front", "right", "iso"] {
        b.click(&format!("[data-view={view}]"));
        changed(b, view);
    }
    b.click("[data-toggle]");
    changed(b, "deviation colors");
    b.click("[data-toggle]");
    changed(b, "deviation colors");
    b.drag("#part-view canvas", [80.0, 30.0]);
    changed(b, "a drag");
    b.wheel("#part-view canvas", -200.0);
    changed(b, "the wheel");
    b.value("document.querySelector('#part-view canvas').focus()");
    for key in ["ArrowLeft", "ArrowUp", "+", "-", "Home"] {
        b.key(key);
        changed(b, key);
    }
    b.click("[data-path]");
    changed(b, "the tool path");
    b.click("[data-path]");
    changed(b, "the tool path");
    // Each side has a scale of its own.
    let range = "proveoutPage.view.state().range";
    let set = |b: &mut Browser, name: &str, value: &str, event: &str| {
        b.value(&format!(
            "(() => {{ const f = document.getElementById('scales').elements[{name:?}]; f.value = {value:?}; f.dispatchEvent(new Event({event:?}, {{ bubbles: true }})); }})()"
        ));
        b.settle();
    };
    set(b, "gouge", "0.125", "input");
    changed(b, "the scale of the gouge");
    assert_eq!(b.value(range)[0], 0.125);
    assert!(b.text("document.querySelector('[data-low]').textContent").contains("0.125 mm gouge"));
    // 99 percent of the points may reach as far as all of them.
    for to in ["tolerance", "largest", "tolerance", "points", "shown"] {
        set(b, "to", to, "change");
        changed(b, to);
    }
    let scales = b.value("proveoutPage.view.data.scales");
    assert!(scales[0][2].as_f64() > scales[0][3].as_f64(), "a gouge above its tolerance: {scales}");
}

/// A click on the part names the line that cut it, a click on a line shows its path, a finding leads to its
/// place.
fn program_and_part_belong_together(b: &mut Browser) {
    b.click("[data-view=top]");
    b.click_at("#part-view canvas", [-0.1, 0.05]);
    let said = b.text("document.getElementById('said').textContent");
    assert!(said.contains("cut by plate.nc, line ") && said.contains("from the design"), "{said}");
    let chosen = b.number("proveoutPage.state().chosen");
    assert!(chosen > 0.0, "stretches of its path are drawn");
    let line = b.text("document.querySelector('#listing .chosen').textContent");
    assert!(line.contains('X'), "{line}");
    // The raw skin has no line.
    b.click("[data-view=front]");
    b.click_at("#part-view canvas", [0.0, 0.02]);
    let said = b.text("document.getElementById('said').textContent");
    assert!(said.contains("skin of the raw stock") || said.contains("cut by"), "{said}");
    // The first row that cuts: line 12 of the program.
    b.value("document.getElementById('listing').scrollTop = 0");
    b.settle();
    b.click("#row-12");
    assert!(b.number("proveoutPage.view.state().chosen") > 0.0, "line 12 has a path");
    assert!(b.text("document.getElementById('said').textContent").contains("its path is drawn"));
    b.value("document.getElementById('listing').focus()");
    b.key("ArrowDown");
    assert!(b.text("document.getElementById('said').textContent").contains("line 13"));
    // A finding leads to place and line, and marks hidden by walls are not drawn.
    b.click("#findings [data-fold=open]");
    let before = b.text("JSON.stringify(proveoutPage.view.state())");
    b.click("#findings .links [data-mark]");
    b.settle();
    assert_ne!(b.text("JSON.stringify(proveoutPage.view.state())"), before);
    assert_eq!(b.number("document.querySelectorAll('.mark.chosen').length"), 1.0);
    b.value("(() => { const v = proveoutPage.view; v.lookAt([50, 40, -20]); })()");
    for _ in 0..30 {
        b.value("document.querySelector('#part-view canvas').focus()");
        b.key("ArrowDown");
    }
    let behind = b.number("proveoutPage.view.state().behind");
    assert!(behind > 5.0, "from below {behind} marks are hidden");
    b.click("[data-view=top]");
    assert!(b.number("proveoutPage.view.state().behind") < behind);
}

/// Buttons, links, fields and folds, whatever the page has: none of them fails.
fn every_control_can_be_clicked(b: &mut Browser) {
    let count = b.number(
        "(() => { let n = 0; document.querySelectorAll('button, summary, a[href^=\"#\"], select, input, canvas, [role=option]').forEach((e) => { e.click(); n += 1; \
         }); return n; })()",
    );
    assert!(count > 60.0, "{count} controls");
    b.settle();
    assert!(b.errors.is_empty(), "{:#?}", b.errors);
}

#[test]
fn the_setup_sheet_shows_what_stands_on_the_machine() {
    let (_folder, result) = run(2);
    let page = result.join("setup.html");
    let text = fs::read_to_string(&page).expect("a setup sheet");
    for words in [
        "G54",
        "END_D10",
        "END_D6",
        "stop",
        "Tool T2 END_D6",
        "Stop (M0)",
        "100.00 × 80.00 × 20.00 mm",
        "data:image/png",
    ] {
        assert!(text.contains(words), "{words}");
    }
    assert!(text.len() < 400_000, "{} bytes", text.len());
    let Some(mut b) = looked("the setup sheet in a browser") else { return };
    for (width, dark) in [(1280, false), (400, true)] {
        b.window(width, 900, dark);
        b.open(&page);
        assert!(b.number("document.documentElement.scrollWidth") <= f64::from(width), "at {width}");
        assert!(b.value("[...document.images].every((i) => i.naturalWidth > 0)") == true);
        keep(&mut b, &format!("setup-{width}"));
    }
    assert!(b.errors.is_empty(), "{:#?}", b.errors);
}
