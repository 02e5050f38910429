//! The player as a reader uses it: steps, plays, jumps, cuts the part open and measures.

use std::{io::Write, path::Path, time::Instant};

use proveout_machine::{JointValues, Machine};

use super::{Browser, SCENE, keep, looked, run, run_with};

const STATE: &str = "proveoutPage.player.state()";

fn opened(b: &mut Browser, page: &Path) {
    b.open(page);
    b.wait("document.documentElement.dataset.player === 'ready'");
    b.settle();
}

fn time(b: &mut Browser) -> f64 {
    b.number(&format!("{STATE}.time"))
}

/// The line that the listing shows as that of the moment.
fn playing(b: &mut Browser) -> String {
    b.settle();
    b.text("document.querySelector('#listing .playing')?.textContent || ''")
}

#[test]
fn the_run_is_stepped_played_and_jumped_through() {
    let (_folder, result) = run(6);
    let page = result.join("report.html");
    let Some(mut b) = looked("the player in a browser") else { return };
    b.window(1280, 900, false);
    let begin = Instant::now();
    opened(&mut b, &page);
    let open_s = begin.elapsed().as_secs_f64();
    // It opens at the part as judged.
    assert_eq!(b.value(&format!("{STATE}.final")), true);
    assert_eq!(b.number("proveoutPage.view.state().parts"), 1.0);
    let steps = b.number("proveoutPage.player.steps");
    assert!(steps > 40.0, "{steps}");

    // Single blocks from the begin: listing, bodies and stock follow.
    b.value("proveoutPage.player.ready().then(() => proveoutPage.player.go(0))");
    b.settle();
    assert!(b.number("proveoutPage.view.state().parts") > 1.0, "tiles of the stock");
    assert!(b.number("proveoutPage.view.state().bodies") > 3.0, "bodies of the machine");
    let mut lines = Vec::new();
    let mut last = -1.0;
    for _ in 0..12 {
        b.click("[data-on]");
        let now = time(&mut b);
        assert!(now >= last, "{now} after {last}");
        last = now;
        lines.push(playing(&mut b));
    }
    assert!(lines.windows(2).all(|w| w[0] != w[1]), "{lines:?}");
    assert!(lines.iter().any(|l| l.contains("X-10. Y0. Z20.")), "{lines:?}");
    for back in (0..11).rev() {
        b.click("[data-back]");
        assert_eq!(playing(&mut b), lines[back], "back to block {back}");
    }
    // The joints at the end of a block are those of its text.
    b.value("document.querySelector('#listing').scrollTop = 0");
    b.value("(() => { const f = document.querySelector('#player [data-line]'); f.value = 12; })()");
    b.click("[data-line-go]");
    let words = b.text("document.querySelector('#player .now').innerText");
    assert!(playing(&mut b).contains("X60."), "{}", playing(&mut b));
    assert!(words.contains("60.000") && words.contains("END_D10") && words.contains("of 1500"), "{words}");

    // Keys do the same.
    b.value("document.activeElement.blur()");
    let before = time(&mut b);
    b.key(".");
    assert!(time(&mut b) > before);
    b.key(",");
    assert_eq!(time(&mut b), before);
    b.key("]");
    assert!(time(&mut b) > before);
    assert!(b.text("document.getElementById('said').textContent").starts_with("Finding at"));

    // Jumps to the second tool: it is the one that is drawn.
    let tool = "(() => { const j = document.querySelector('[data-jump]'); const o = [...j.querySelectorAll('optgroup[label=Tools] option')][1]; j.value = o.value; j.dispatchEvent(new Event('change')); return o.textContent; })()";
    assert!(b.text(tool).contains("END_D6"));
    b.click("[data-on]");
    assert!(b.text("document.querySelector('#player .now').innerText").contains("END_D6"));
    // A finding leads to its moment.
    b.click("#findings [data-fold=open]");
    let moment = b.number("Number(document.querySelector('[data-moment]').dataset.moment)");
    b.click("[data-moment]");
    assert!((time(&mut b) - moment).abs() < 1e-6);

    // Plays at 500 times to the end, at 1 to an error.
    b.value("proveoutPage.player.go(0)");
    b.value("document.querySelector('[data-speed]').value = '500'");
    b.click("[data-play]");
    b.wait(&format!("{STATE}.final && !{STATE}.playing"));
    b.value("proveoutPage.player.go(0)");
    b.value("document.querySelector('[data-halt]').checked = true");
    b.click("[data-play]");
    b.wait(&format!("!{STATE}.playing"));
    let stopped = time(&mut b);
    let first = b.number("Math.min(...[...document.querySelectorAll('#findings .error [data-moment]')].map((e) => Number(e.dataset.moment)))");
    assert!((stopped - first).abs() < 1e-3, "stopped at {stopped}, first error at {first}");
    b.value("document.querySelector('[data-speed]').value = '1'");
    b.click("[data-play]");
    b.wait(&format!("{STATE}.time > {stopped}"));
    b.click("[data-play]");
    assert_eq!(b.value(&format!("{STATE}.playing")), false);

    // Colors by tool, of the stock of the moment too.
    for way in ["tool", "operation", "feed"] {
        b.value(&format!("(() => {{ const s = document.querySelector('[data-colors]'); s.value = {way:?}; s.dispatchEvent(new Event('change')); }})()"));
        b.settle();
        assert!(b.number("document.querySelectorAll('.tag-key li').length") > 0.0, "{way}");
        assert_eq!(b.value("proveoutPage.view.state().tagged"), true);
    }
    keep(&mut b, "player-1280");
    assert!(b.errors.is_empty(), "{:#?}", b.errors);
    for (width, dark) in [(700, false), (420, true)] {
        b.window(width, 900, dark);
        opened(&mut b, &page);
        b.click("[data-back]");
        b.wait("proveoutPage.view.state().parts > 1");
        b.value("document.getElementById('player').scrollIntoView()");
        let wide = b.number("document.documentElement.scrollWidth");
        assert!(wide <= f64::from(width), "{wide} points at {width}");
        keep(&mut b, &format!("player-{width}"));
    }
    let frame = b.number("(() => { const t = performance.now(); for (let k = 0; k < 3; k++) proveoutPage.view.drawNow(); return (performance.now() - t) / 3; })()");
    assert!(b.errors.is_empty(), "{:#?}", b.errors);
    writeln!(std::io::stdout(), "player: {steps} steps, opened in {open_s:.2} s, {frame:.0} ms a frame").ok();
}

/// A plane that cuts the part, its handle, and a distance that is known.
#[test]
fn the_part_is_cut_open_and_measured() {
    let (_folder, result) = run(2);
    let Some(mut b) = looked("section and distance in a browser") else { return };
    b.window(1280, 900, false);
    opened(&mut b, &result.join("report.html"));
    b.click("[data-view=front]");
    // The middle of the front face, and of the section at X 50: the face is in the material.
    b.click("[data-section]");
    assert_eq!(b.text("proveoutPage.view.state().section.axis"), "X");
    b.click("[data-view=right]");
    b.click_at("#part-view canvas", [0.0, 0.06]);
    let said = b.text("document.getElementById('said').textContent");
    assert!(said.contains("on the plane of the section") && said.contains("X 50.00"), "{said}");
    // The handle moves the plane along its normal.
    b.click("[data-view=front]");
    b.drag(".section-handle", [60.0, 0.0]);
    let moved = b.number("proveoutPage.view.state().section.at");
    assert!(moved > 55.0 && moved < 90.0, "{moved}");
    b.click("[data-section-turn]");
    assert_eq!(b.number("proveoutPage.view.state().section.side"), -1.0);
    b.value("(() => { const s = document.querySelector('[data-section-axis]'); s.value = '2'; s.dispatchEvent(new Event('change')); })()");
    assert_eq!(b.text("proveoutPage.view.state().section.axis"), "Z");
    keep(&mut b, "section");
    b.click("[data-section]");
    assert_eq!(b.value("proveoutPage.view.state().section"), serde_json::Value::Null);

    // Two places on the front face, whose distance along X the two clicks know.
    b.click("[data-measure]");
    b.click_at("#part-view canvas", [-0.1, 0.03]);
    b.click_at("#part-view canvas", [0.1, 0.03]);
    let result = b.value("proveoutPage.player.measured()");
    let number = |key: &str, k: usize| result[key][k].as_f64().expect("a number");
    let way: Vec<f64> = (0..3).map(|k| number("to", k) - number("from", k)).collect();
    let length = result["length"].as_f64().expect("a length");
    assert!((length - way.iter().map(|w| w * w).sum::<f64>().sqrt()).abs() < 1e-9);
    assert!(way[0] > 10.0 && way[2].abs() < 1.0, "{way:?}");
    // Both lie on the face at Y 0, within the error that is said.
    let error = result["error"].as_f64().expect("an error");
    assert!(error > 0.0 && error < 10.0 && way[1].abs() <= error, "{way:?} within {error}");
    assert!(number("from", 1).abs() <= 0.5 * error);
    let said = b.text("document.getElementById('said').textContent");
    assert!(said.starts_with("Distance ") && said.contains("within"), "{said}");
    assert!(b.number("proveoutPage.view.state().measured") > 0.0);
    b.value("document.activeElement.blur()");
    b.key("Escape");
    assert_eq!(b.number("proveoutPage.view.state().measured"), 0.0);
    assert!(b.errors.is_empty(), "{:#?}", b.errors);
}

/// The page's poses of table and spindle are those of the machine, at every joint of a five-axis machine.
#[test]
fn joints_and_poses_are_those_of_the_machine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let folder = root.join("machines/dmu-65-type");
    let machine = Machine::read(&folder).expect("a machine");
    let scene = SCENE.replace("MACHINE", &folder.display().to_string());
    let program = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54\nS5000 M3\nG0 X10. Y20. Z150. A10. C30.\nG1 X40. Y-5. Z120. A-25. C-140. F900\nG0 Z200. A0. C0.\nM30\n%\n";
    let (_folder, result) = run_with(&scene, program);
    let Some(mut b) = looked("poses of a five-axis machine in a browser") else { return };
    opened(&mut b, &result.join("report.html"));
    let end = b.number(&format!("{STATE}.end"));
    let mut moved = vec![0.0_f64; machine.joints.len()];
    for k in 0..=40 {
        let at = b.value(&format!("proveoutPage.player.at({})", end * f64::from(k) / 40.0));
        let mut q = JointValues::ZERO;
        for (j, joint) in machine.joints.iter().enumerate() {
            let value = at["q"][j].as_f64().expect("a position");
            moved[j] = moved[j].max(value.abs());
            q[j] = if joint.is_rotary() { value.to_radians() } else { value };
        }
        for (name, pose) in [("table", machine.machine_from_table(&q)), ("spindle", machine.machine_from_spindle(&q))] {
            for i in 0..12 {
                let own = if i % 4 == 3 { pose.translation[i / 4] } else { pose.rotation[(i / 4, i % 4)] };
                let value = at[name][i].as_f64().expect("a number");
                assert!((value - own).abs() < 1e-9, "{name} {i}: {value} instead of {own}");
            }
        }
        for (j, _) in machine.joints.iter().enumerate() {
            let pose = machine.attachment_pose(proveout_machine::Attachment::Joint(j), &q);
            for i in 0..3 {
                let value = at["joints"][j][4 * i + 3].as_f64().expect("a number");
                assert!((value - pose.translation[i]).abs() < 1e-9, "joint {j}");
            }
        }
    }
    assert!(moved.iter().all(|m| *m > 5.0), "every joint has moved: {moved:?}");
    assert!(b.errors.is_empty(), "{:#?}", b.errors);
}
