//! A run is made, its certificates hold; each forgery is refused.

use std::fs;
use std::path::Path;

use proveout_geom::{Aabb, Point, box_mesh};
use proveout_record::{RerunMode, observers};

use super::*;

mod planes;

const PROGRAM: &str = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 M3\nG0 X-20. Y10.\nZ5.\nG1 Z-2. F600\nX60. Y12.\n\
                       A20. C60.\nX30. Z3.\nA-15. C-90.\nG0 Z60.\nM5\nM30\n%\n";

/// Writes a scene with a post next to the block on a five-axis machine, and proves it out into a folder.
fn made(folder: &Path) -> (Value, Prepared, Vec<ClearanceClaim>, Vec<JointSample>) {
    let root = crate::workspace_root();
    let tools = "[[tool]]\nnumber = 1\nname = \"T1\"\nkind = \"ball\"\ndiameter_mm = 10\nflute_length_mm = 25\nshank_diameter_mm = 10\n\
                 gauge_length_mm = 80\ncenter_cutting = true\nholder = { sections = [{ diameter_mm = 40, length_mm = 40 }] }\n";
    let scene = format!(
        "name = \"bench\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 2\n[stock.box]\nmin_mm = [0, 0, -20]\n\
         max_mm = [60, 20, 0]\n[mount]\ntranslation_mm = [0, 0, 150]\n[work_offsets.G54]\nZ_mm = 150\n\
         [[fixture]]\nname = \"post\"\nbox = {{ min_mm = [70, -40, -100], max_mm = [90, -20, 10] }}\n\
         [[program]]\nname = \"bench\"\nfile = \"program.nc\"\n",
        root.join("machines/ac-trunnion-620")
    );
    for (name, text) in [("tools.toml", tools), ("scene.toml", &scene), ("program.nc", PROGRAM)] {
        fs::write(folder.join(name), text).expect("written");
    }
    let read = || Prepared::read(&folder.join("scene.toml"), &Choice::default()).unwrap_or_else(|e| panic!("{e}"));
    let out = folder.join("run");
    fs::create_dir(&out).expect("a folder");
    let mut watchers = observers(&RerunMode::Off).expect("observers");
    proveout_sim::run::run(read(), &mut watchers, &out).unwrap_or_else(|e| panic!("{e}"));
    drop(watchers);
    let verdict = serde_json::from_str(&fs::read_to_string(out.join("verdict.json")).expect("text")).expect("JSON");
    let setup = read();
    let spans = table::spans(&out.join("clearance.parquet"), &setup.machine).expect("spans");
    let samples = table::samples(&out.join("signals.parquet"), &setup.machine).expect("samples");
    (verdict, setup, spans, samples)
}

fn refused(what: &str, result: Result<String, TaskError>) {
    match result {
        Err(TaskError(text)) => println!("{what}: {text}"),
        Ok(text) => panic!("{what} is not refused: {text}"),
    }
}

/// A straight span in two parts with its time and its claims: each has half of the way, and what the joints
/// may leave it by.
fn halves(span: &ClearanceClaim) -> [ClearanceClaim; 2] {
    let [from, to] = span.straight.expect("straight");
    let middle = (from + to) * 0.5;
    let off = from.zip_map(to, f64::min) - span.low;
    [[from, middle], [middle, to]].map(|ends| ClearanceClaim {
        low: ends[0].zip_map(ends[1], f64::min) - off,
        high: ends[0].zip_map(ends[1], f64::max) + off,
        straight: Some(ends),
        ..span.clone()
    })
}

#[test]
fn what_a_run_says_holds_and_forgeries_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let (verdict, mut setup, spans, samples) = made(folder.path());
    let said =
        run(&folder.path().join("run"), &folder.path().join("scene.toml")).unwrap_or_else(|TaskError(e)| panic!("{e}"));
    println!("{said}");
    assert!(said.contains("listed as unchecked") && spans.len() > 100, "{said}");

    // Of each body the pair that came nearest, and the spans of the moment at which that was measured: D less
    // the motion is the least distance, but for the error. At the place that was measured the true distance
    // of hull or box is no more than it and the motion, so that 0.05 mm more are a lie.
    let least = |s: &ClearanceClaim| s.distance - s.motion;
    let nearest = |name: &str| {
        let stated = list(&verdict["clearance"]["pairs"]).iter().filter_map(|p| {
            let (min, error, time) = (p["min_mm"].as_f64()?, p["error_mm"].as_f64()?, p["time_s"].as_f64()?);
            let pair = pair_of(p)?;
            ((pair.0 == name || pair.1 == name) && min > 0.0 && error < 0.02).then_some((min, time, pair))
        });
        let (_, time, pair) = stated.min_by(|x, y| x.0.total_cmp(&y.0)).expect("a pair");
        let at =
            |s: &ClearanceClaim| ordered(&s.bodies[0], &s.bodies[1]) == pair && s.time[0] <= time && time <= s.time[1];
        (0..spans.len()).filter(|&k| at(&spans[k])).collect::<Vec<_>>()
    };
    for name in ["post", "holder of T1", "cutter of T1"] {
        let at = nearest(name);
        for raised in [0.05, 1.0, 100.0] {
            let mut forged = spans.clone();
            at.iter().for_each(|&k| forged[k].distance += raised);
            refused(&format!("{name}: a distance raised by {raised} mm"), check(&verdict, &setup, &forged, &samples));
        }
        let mut forged = spans.clone();
        at.iter().rev().for_each(|&k| drop(forged.remove(k)));
        refused(&format!("{name}: a span removed"), check(&verdict, &setup, &forged, &samples));
        let half = 0.5 * (spans[at[0]].time[1] - spans[at[0]].time[0]);
        for by in [[0.0, -half], [half, 0.0], [half, half], [-half, -half]] {
            let mut forged = spans.clone();
            forged[at[0]].time = [forged[at[0]].time[0] + by[0], forged[at[0]].time[1] + by[1]];
            refused(&format!("{name}: times moved by {by:?} s"), check(&verdict, &setup, &forged, &samples));
        }
    }
    // A checked pair is reported as unchecked.
    let mut claim = verdict.clone();
    let of_post = |p: &Value| p["bodies"].to_string().contains("holder of T1\",\"post");
    claim["clearance"]["pairs"].as_array_mut().expect("pairs").retain(|p| !of_post(p));
    claim["clearance"]["unchecked"] = serde_json::json!([{ "bodies": ["holder of T1", "post"], "reason": "none" }]);
    for gate in claim["gates"].as_array_mut().expect("gates") {
        gate["state"] = "pass".into();
    }
    let mut forged = spans.clone();
    forged.retain(|s| ordered(&s.bodies[0], &s.bodies[1]) != ordered("holder of T1", "post"));
    refused("a pair listed as unchecked", check(&claim, &setup, &forged, &samples));

    // Parts of one piece of the motion have its time in common: cut in two it holds as well, but without one
    // of them it has no gap in time, only along the way.
    let way = |s: &ClearanceClaim| s.straight.as_ref().map_or(0.0, |[from, to]| (*to - *from).max_abs());
    let far = |&a: &usize, &b: &usize| way(&spans[a]).total_cmp(&way(&spans[b]));
    let k = (0..spans.len()).filter(|&k| least(&spans[k]) > 1.0).max_by(far).expect("a straight span");
    assert!(way(&spans[k]) > 0.01, "{}", way(&spans[k]));
    let mut forged = spans.clone();
    forged.splice(k..=k, halves(&spans[k]));
    check(&verdict, &setup, &forged, &samples).unwrap_or_else(|TaskError(e)| panic!("{e}"));
    forged.remove(k + 1);
    refused("a part of a piece removed", check(&verdict, &setup, &forged, &samples));

    // A row whose points move along parabolas, reported as one of straight lines: it claims too little
    // motion. Its distance is that of the parabolas.
    let rotary: Vec<usize> = (0..setup.machine.joints.len()).filter(|&j| setup.machine.joints[j].is_rotary()).collect();
    let turned = |s: &ClearanceClaim| -> f64 {
        s.straight.as_ref().map_or(0.0, |[from, to]| rotary.iter().map(|&j| (to[j] - from[j]).abs()).sum())
    };
    let curved = |k: &usize| spans[*k].curved && least(&spans[*k]) > 1.0;
    let k = (0..spans.len()).filter(curved).max_by(|&a, &b| turned(&spans[a]).total_cmp(&turned(&spans[b])));
    let k = k.expect("a row of parabolas");
    let mut forged = spans.clone();
    forged[k].curved = false;
    refused("parabolas stated as straight lines", check(&verdict, &setup, &forged, &samples));
    let mut forged = spans.clone();
    forged[k].distance += 2e3;
    refused("parabolas: a distance raised by 2000 mm", check(&verdict, &setup, &forged, &samples));

    // A row that holds at every turn of the table: with a distance that no turn has, with another joint that
    // may be anywhere, with one that does not carry either body alone about a fixed line.
    let (b, c) = (setup.machine.joint("A").expect("A"), setup.machine.joint("C").expect("C"));
    let at_every_turn = |s: &&ClearanceClaim| s.without_ends().eq([c]) && least(s) > 1.0;
    assert!(spans.iter().filter(at_every_turn).count() > 5, "no row holds at every turn");
    let k = spans.iter().position(|s| at_every_turn(&s)).expect("a row");
    for raised in [2e3, 1e6] {
        let mut forged = spans.clone();
        forged[k].distance += raised;
        refused(&format!("every turn: a distance raised by {raised} mm"), check(&verdict, &setup, &forged, &samples));
    }
    let endless =
        |forged: &mut ClearanceClaim, j: usize| (forged.low[j], forged.high[j]) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut forged = spans.clone();
    endless(&mut forged[k], b);
    refused("every turn of two joints", check(&verdict, &setup, &forged, &samples));
    let mut forged = spans.clone();
    (forged[k].low[c], forged[k].high[c]) = (-10.0, 10.0);
    endless(&mut forged[k], b);
    refused("every turn of a joint that does not carry it alone", check(&verdict, &setup, &forged, &samples));
    let slide = setup.machine.joint("X").expect("X");
    let mut forged = spans.clone();
    (forged[k].low[c], forged[k].high[c]) = (-10.0, 10.0);
    endless(&mut forged[k], slide);
    refused("any place of a slide", check(&verdict, &setup, &forged, &samples));

    let k = (0..spans.len())
        .filter(|&k| least(&spans[k]) > 1.0)
        .max_by(|&x, &y| spans[x].motion.total_cmp(&spans[y].motion));
    let mut forged = spans.clone();
    forged[k.expect("a span")].motion = 0.0;
    refused("a motion of nothing", check(&verdict, &setup, &forged, &samples));

    // Numbers that are none.
    let straight =
        (0..spans.len()).find(|&k| least(&spans[k]) > 1.0 && spans[k].straight.is_some()).expect("a straight span");
    let spoiled: [fn(&mut ClearanceClaim, f64); 4] = [
        |s, x| s.distance = x,
        |s, x| s.motion = x,
        |s, x| s.low[0] = x.min(s.low[0]),
        |s, x| s.straight.iter_mut().flatten().for_each(|q| q[0] = x),
    ];
    for (which, spoil) in spoiled.into_iter().enumerate() {
        for x in [f64::NAN, f64::INFINITY, -1e300] {
            let mut forged = spans.clone();
            spoil(&mut forged[straight], x);
            // Without ends downward nothing is left out, and a lower distance claims less.
            let honest = forged[straight].low == spans[straight].low && which == 2 || which == 0 && x < 0.0;
            if !honest {
                refused(&format!("number {which} stated as {x}"), check(&verdict, &setup, &forged, &samples));
            }
        }
    }

    let mut forged = spans.clone();
    forged.retain(|s| !s.bodies.iter().any(|b| b == "post"));
    refused("a body left out", check(&verdict, &setup, &forged, &samples));

    let mut claim = verdict.clone();
    let pairs = claim["clearance"]["pairs"].as_array_mut().expect("pairs");
    let of_post = pairs.iter_mut().find(|p| of_post(p)).expect("a pair");
    of_post["proved_mm"] = (of_post["proved_mm"].as_f64().expect("number") + 0.01).into();
    refused("a claim of the verdict", check(&claim, &setup, &spans, &samples));

    // The certificates are those of a smaller post than the real one.
    let (min, max) = (Point::new(69.0, -41.0, 50.0), Point::new(91.0, -19.0, 161.0));
    let post = setup.fixtures.iter_mut().find(|(name, _)| name == "post").expect("the post");
    post.1 = box_mesh(&Aabb { min, max });
    refused("a body shrunk", check(&verdict, &setup, &spans, &samples));

    // The scene is another one than that of the run.
    let scene = folder.path().join("scene.toml");
    let text = fs::read_to_string(&scene).expect("scene").replace("[90, -20, 10]", "[89, -20, 10]");
    fs::write(&scene, text).expect("written");
    refused("another scene", run(&folder.path().join("run"), &scene));
}

/// The run in `PROVEOUT_RUN` of the scene in `PROVEOUT_SCENE` holds: `cargo xtask verify-clearance` without a
/// build of its own.
#[test]
fn a_run_that_is_named_holds() {
    let (Ok(folder), Ok(scene)) = (std::env::var("PROVEOUT_RUN"), std::env::var("PROVEOUT_SCENE")) else { return };
    println!("{}", run(Path::new(&folder), Path::new(&scene)).unwrap_or_else(|TaskError(e)| panic!("{e}")));
}
