//! Programs side by side: the published experiment at coarse cells.

use std::{fs, path::Path};

use proveout_sim::{
    SimError,
    compare::{CompareChoice, Compared, Comparing, VariationKind, markdown},
    run::run_with_surface,
    verdict::State,
};
use proveout_tests::{root, scene};

/// Distance of the rays, mm: a turn of the pass is 1 mm wide, and the points on the rays are exact.
const CELL_MM: f64 = 0.5;

/// The scene of the experiment with its paths made absolute.
struct Experiment {
    folder: tempfile::TempDir,
}

impl Experiment {
    /// `change` edits the text of the scene.
    fn new(change: impl Fn(&str) -> String) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let source = scene("li-2022-s-theta");
        let text = fs::read_to_string(source.join("scene.toml")).expect("readable");
        let (machine, tools) = (root().join("machines/starrag-lx-451"), root().join("tools/li-2022.toml"));
        let text = text
            .replace("\"../../machines/starrag-lx-451\"", &format!("{machine:?}"))
            .replace("\"../../tools/li-2022.toml\"", &format!("{tools:?}"));
        // The A axis rules the time, as in the paper, whatever the scene sets.
        let limits = "[control.joint_limits.A]\nmax_velocity_deg_s = 90\nmax_acceleration_deg_s2 = 600\n\
                      max_jerk_deg_s3 = 12_000\nsource = \"test\"\n\n[tolerances]";
        let text = match text.split_once("[control.joint_limits.A]") {
            Some((head, rest)) => format!("{head}{limits}{}", rest.split_once("[tolerances]").expect("tolerances").1),
            None => text.replace("[tolerances]", limits),
        };
        // Dozens of other plans and methods, which their own tests look at.
        let (head, rest) = text.split_once("[[compare.choice]]").expect("choices");
        let text =
            format!("{head}[[compare.published]]{}", rest.split_once("[[compare.published]]").expect("published").1);
        fs::write(folder.path().join("scene.toml"), change(&text)).expect("written");
        fs::copy(source.join("original.mpf"), folder.path().join("original.mpf")).expect("copied");
        Self { folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn compare(&self, baseline: Option<&str>, threads: usize) -> Result<Compared, SimError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let choice = CompareChoice {
            baseline: baseline.map(str::to_owned),
            resolution_mm: Some(CELL_MM),
            ..CompareChoice::default()
        };
        pool.install(|| {
            let mut comparing = Comparing::read(self.path(), &choice)?;
            comparing.vary(&|_, _| {})?;
            for name in comparing.order() {
                let prepared = comparing.take(&name).expect("taken once");
                let (result, surface) = run_with_surface(prepared, Vec::new(), Path::new("."))?;
                comparing.add(&name, result, &surface);
            }
            Ok(comparing.finish().expect("every program was run"))
        })
    }
}

/// The first turns of the pass only: the comparison of two turns takes a third of the time and asks the same
/// questions.
fn shorter(folder: &Path) {
    let program = folder.join("original.mpf");
    let lines: Vec<String> = fs::read_to_string(&program).expect("readable").lines().map(str::to_owned).collect();
    let motion = |l: &str| l.starts_with('X') || l.starts_with("G1 X");
    let first = lines.iter().position(|l| motion(l)).expect("motion");
    let last = lines.iter().rposition(|l| motion(l)).expect("motion");
    // Two and a half turns of 370 blocks and the approach; the retract moves along the normal of another
    // place, so it is left out: the program ends on the blade and TRAFOOF follows.
    let kept = lines.iter().take(first + 930).chain(lines.iter().skip(last + 1)).cloned().collect::<Vec<_>>();
    fs::write(&program, kept.join("\n") + "\n").expect("written");
}

#[test]
#[ignore = "nightly, 140 s"]
fn the_experiment_is_compared_with_an_error_and_the_same_bytes_at_any_thread_count() {
    let experiment = Experiment::new(|text| {
        // Whole turns lie side by side between the second and the third.
        text.replace("min_mm = [13.5, -200, -200]", "min_mm = [13.2, -200, -200]")
            .replace("max_mm = [16.5, 200, 200]", "max_mm = [13.6, 200, 200]")
            .replace("plot_window_s = [22, 34]", "plot_window_s = [5, 15]")
    });
    shorter(experiment.path());
    let compared = experiment.compare(None, 2).expect("runs");
    let c = &compared.comparison;
    assert_eq!(c.order, ["original", "quaternion", "s-theta"]);
    assert_eq!(c.baseline, "original");

    // Times of the motion without stock are those of the whole prove-outs.
    let proposed = &c.gains["s-theta"];
    let whole = 100.0 * (1.0 - c.programs["s-theta"].time.total_s / c.programs["original"].time.total_s);
    assert_eq!(proposed.cycle_time_percent, Some(whole));
    assert_eq!(proposed.cycle_time_percent, proposed.cycle_time.percent);

    // The gain: above zero whatever is varied; errors are finite and the computation is a small part of them.
    let gain = &proposed.stretch_time;
    let (percent, error) = (gain.percent.expect("a gain"), gain.error_percent.expect("varied"));
    assert!(gain.sign_holds && percent > 0.0, "{gain:?}");
    assert!(error.is_finite() && error > 0.0 && gain.numerical_percent.expect("varied") < 0.5 * percent, "{gain:?}");
    assert!(gain.smallest_percent.expect("varied") <= percent && percent <= gain.largest_percent.expect("varied"));
    for variation in &c.variations {
        assert!(variation.unchecked.is_none(), "the machine has limits and drives: {variation:?}");
        assert_eq!(variation.times.len(), 3);
    }
    assert!(c.variations.iter().any(|v| v.kind == VariationKind::Numerical));
    // Motion pieces are cut from a plan that is made before them.
    let pieces = c.variations.iter().find(|v| v.parameter == "motion pieces").expect("varied");
    assert_eq!(pieces.gains["s-theta"].stretch_time_change_percent, Some(0.0));

    // The limits that the scene sets are next to the machine's own, and the gain without them next to the
    // gain.
    let limits: Vec<_> = c.joint_limits.iter().map(|l| (l.joint.as_str(), l.of_machine, l.of_scene)).collect();
    assert_eq!(limits, [("A", Some(360.0), 90.0), ("A", Some(4500.0), 600.0), ("A", Some(90_000.0), 12_000.0)]);
    let own = c.own_limits.as_ref().expect("the scene sets limits");
    assert!(own.unchecked.is_none() && own.times.len() == 3, "{own:?}");
    let free = c.at_own_limits("s-theta").expect("a gain");
    assert!(free > 0.0 && free < 0.5 * percent, "most of the gain comes from the limit of A: {free} of {percent}");

    // Table 2 of the paper and ours.
    for axis in ["A", "Y", "Z"] {
        for kind in ["velocity", "acceleration"] {
            let name = format!("{axis}, {kind}");
            let row = c.published.iter().find(|p| p.name == name).expect("published");
            assert!(row.value.expect("measured") > 0.0, "{row:?}");
            assert_eq!(row.unit, "%");
        }
    }
    let expect = |name: &str| c.expectations.iter().find(|e| e.name == name).expect("a criterion");
    for name in ["the rotary axis never reverses", "the tool axis stays in its channel", "ball centers stay"] {
        assert_eq!(expect(name).state, State::Pass, "{:?}", expect(name));
    }
    let stretch = |program: &str| c.programs[program].stretch.as_ref().expect("it cuts");
    assert!(stretch("original").axes["A"].reversals >= 4, "two a turn");
    assert_eq!(stretch("original").blocks, stretch("s-theta").blocks, "the same blocks count");
    assert!((stretch("original").programmed_s - stretch("s-theta").programmed_s).abs() < 1e-3, "of the same time");

    // Scallop of a ball of 8 mm at 1 mm pitch: 15.6 micrometers, and up to 5 more by chords of 0.5 mm round
    // the edges.
    let height = 1e3 * (8.0 - 63.75_f64.sqrt());
    for (name, program) in &c.programs {
        let largest = program.surface.scallop_max_um.expect("judged and cut");
        assert!(largest > 0.8 * height && largest < height + 5.0, "{name}: {largest}");
        let difference = program.difference.as_ref();
        assert_eq!(difference.is_none(), *name == c.baseline);
        assert!(
            difference.is_none_or(|d| d.samples > 100 && d.rms_mm.expect("samples") < 0.005),
            "{name}: {difference:?}"
        );
    }
    assert!(compared.pictures.part.is_some());
    let study = &compared.pictures.programs[2].studies[0];
    assert!(study.curves.iter().any(|c| c.name == "forward limit" && !c.points.is_empty()));

    let text = markdown(c);
    assert!(text.contains(&format!("{percent:.2} ± {error:.2}")) && text.contains("A, velocity"), "{text}");
    assert!(
        text.contains(&format!("`s-theta` {free:.2}")) && text.contains("| A | velocity | 360 | 90 | deg/s |"),
        "{text}"
    );

    let bytes = |compared: &Compared| serde_json::to_string_pretty(&compared.comparison).expect("JSON");
    assert_eq!(bytes(&compared), bytes(&experiment.compare(None, 1).expect("runs")));
}

#[test]
fn a_comparison_that_cannot_be_made_is_refused_with_its_reason() {
    let refused = |experiment: &Experiment, baseline: Option<&str>| {
        experiment.compare(baseline, 2).expect_err("refused").to_string()
    };
    let whole = Experiment::new(str::to_owned);
    let error = refused(&whole, Some("unheard-of"));
    assert!(error.contains("unheard-of"), "{error}");

    let alone = Experiment::new(|text| {
        let (head, _) = text.split_once("[[program]]\nname = \"quaternion\"").expect("programs");
        head.to_owned()
    });
    let error = refused(&alone, None);
    assert!(error.contains("1 program") && error.contains("nothing to compare"), "{error}");

    let broken = Experiment::new(str::to_owned);
    fs::write(broken.path().join("original.mpf"), "N10 G0 X0 FROB7\nM30\n").expect("written");
    let error = refused(&broken, None);
    assert!(error.contains("FROB7"), "{error}");
}
