//! The page over plain data: no loads from elsewhere, nothing unescaped, well-formed markup, every section
//! there.

use std::collections::BTreeMap;

use proveout_geom::{Aabb, Point, box_mesh};
use proveout_sim::{
    certificate::VelocityLimit,
    compare::{
        Agreement, ChangedLimit, Compared, Comparison, DemandRow, Difference, Expectation, Gain, GainAtLimit,
        JointPicture, Made, PartPicture, Pictures, ProgramFigures, ProgramPicture, Published, Role, Stretch,
        StretchAxis, Study, StudyCurve, StudyFigure, TimeGain, Variation, VariationKind, VariedGains, VariedTime,
    },
    verdict::{self, Axis, AxisUnit, Gate, GateVerdict, State},
};

use super::{
    JointTrace, Trace,
    drawings::{gain_drawing, ranges_drawing},
    page::render,
};
use crate::report::tests::{EVIL, closes_in_order, loads_nothing};

fn figures(text: &str, baseline: bool) -> ProgramFigures {
    let axis = StretchAxis {
        unit: "deg".into(),
        max_velocity: 80.0,
        max_acceleration: 600.0,
        max_jerk: 9000.0,
        reversals: 2,
        travel: 40.0,
        range: 30.0,
        demand_velocity: Some(103.9),
        demand_acceleration: None,
    };
    ProgramFigures {
        folder: "p".into(),
        verdict: State::Unchecked,
        gates: vec![GateVerdict { gate: Gate::Surface, state: State::Unchecked, reason: text.into() }],
        errors: 0,
        digests: BTreeMap::new(),
        made: (!baseline).then(|| Made {
            method: text.into(),
            source: text.into(),
            from: text.into(),
            center_shift_mm: Some(1e-5),
            figures: vec![StudyFigure { name: text.into(), unit: "deg".into(), value: 3.0 }],
            over_velocity: Vec::new(),
        }),
        time: verdict::Time { total_s: 80.0, cutting_s: 68.0, ..verdict::Time::default() },
        axes: BTreeMap::from([("A".to_owned(), Axis { unit: AxisUnit::Deg, ..Axis::default() })]),
        stretch: Some(Stretch {
            blocks: 10,
            time_s: 66.0,
            programmed_s: 60.0,
            axes: BTreeMap::from([("A".to_owned(), axis)]),
            rotary: None,
            straight_joints_tip_um: None,
            from_turning: None,
            depth: None,
        }),
        deviation: verdict::Deviation { excess_max_mm: Some(0.0157), ..verdict::Deviation::default() },
        surface: verdict::Surface { scallop_max_um: Some(15.7), ..verdict::Surface::default() },
        difference: (!baseline).then(|| Difference { samples: 8, rms_mm: Some(0.001), ..Difference::default() }),
        clearance: verdict::Clearance::default(),
    }
}

fn compared(text: &str) -> Compared {
    let names = [format!("{text} a"), format!("{text} b")];
    let gain = TimeGain {
        percent: Some(19.2),
        error_percent: Some(1.4),
        numerical_percent: Some(0.01),
        model_percent: Some(1.39),
        sign_holds: true,
        ..TimeGain::default()
    };
    let gains = Gain { cycle_time: gain.clone(), cutting_time: gain.clone(), stretch_time: gain, ..Gain::default() };
    let varied = VariedGains {
        stretch_time_percent: Some(18.0),
        stretch_time_change_percent: Some(-1.2),
        ..VariedGains::default()
    };
    let variation = |unchecked: Option<String>| Variation {
        name: text.into(),
        parameter: text.into(),
        kind: VariationKind::Model,
        acts: true,
        times: names.iter().map(|n| (n.clone(), VariedTime::default())).collect(),
        gains: if unchecked.is_some() { BTreeMap::new() } else { BTreeMap::from([(names[1].clone(), varied)]) },
        unchecked,
    };
    let comparison = Comparison {
        schema_version: 1,
        scene: text.into(),
        description: text.into(),
        experiment: text.into(),
        machine: text.into(),
        joint_limits: vec![ChangedLimit {
            machine: text.into(),
            joint: text.into(),
            quantity: "velocity".into(),
            unit: "deg/s".into(),
            of_machine: Some(360.0),
            of_scene: 62.4,
            source: text.into(),
        }],
        baseline: names[0].clone(),
        cells_mm: [0.2; 3],
        scene_cells: true,
        motion_only: false,
        order: names.to_vec(),
        verdict: State::Fail,
        programs: BTreeMap::from([(names[0].clone(), figures(text, true)), (names[1].clone(), figures(text, false))]),
        gains: BTreeMap::from([(names[1].clone(), gains)]),
        variations: vec![variation(None), variation(Some(text.into()))],
        own_limits: Some(variation(None)),
        choices: None,
        null_program: None,
        must_pass: None,
        published: vec![Published {
            name: text.into(),
            measured: text.into(),
            unit: "%".into(),
            published: 38.1,
            kind: proveout_sim::scene::PublishedKindFile::Paper,
            value: Some(41.5),
            band: Some([25.0, 55.0]),
            state: State::Pass,
            null_value: None,
            over_choices: None,
            over_draws: None,
            over_twin: None,
            agreement: Agreement::Agrees,
            decided_by: Some((text.into(), [30.0, 50.0])),
            not_comparable: None,
            headline: true,
            source: text.into(),
            remark: text.into(),
        }],
        expectations: vec![Expectation {
            name: text.into(),
            measured: text.into(),
            unit: "mm".into(),
            value: None,
            at_least: None,
            at_most: Some(0.001),
            state: State::Unchecked,
            reason: text.into(),
            source: text.into(),
        }],
        rules: BTreeMap::from(
            ["gain", "error", "stretch", "demand", "reversals", "scallop", "difference"]
                .map(|r| (r.to_owned(), text.to_owned())),
        ),
    };
    let curve = |name: &str, role, points: Vec<[f64; 2]>| StudyCurve {
        name: format!("{text} {name}"),
        role,
        axes: [text.into(), text.into()],
        units: ["mm".into(), "deg".into()],
        equal_scales: false,
        points,
    };
    let study = Study {
        curves: vec![
            curve("limit", Role::Limit, vec![[0.0, 10.0], [200.0, 90.0], [400.0, 400.0]]),
            curve("keys", Role::KeyPoints, vec![[150.0, 40.0]]),
            curve("marks", Role::Marks, vec![[100.0, 0.0], [285.0, 360.0]]),
        ],
        figures: vec![StudyFigure { name: text.into(), unit: "deg".into(), value: 20.4 }],
    };
    let rows: Vec<DemandRow> = (0..50)
        .map(|i| DemandRow {
            time_s: f64::from(i) * 0.03,
            position: f64::from(i),
            velocity: 30.0,
            acceleration: f64::NAN,
        })
        .collect();
    let program = |name: &String, studies: Vec<Study>| ProgramPicture {
        name: name.clone(),
        windows: Some([[0.0, 10.0]; 2]),
        demand: vec![rows.clone()],
        studies,
    };
    let mesh = box_mesh(&Aabb { min: Point::new(0.0, 0.0, 0.0), max: Point::new(1.0, 2.0, 3.0) });
    let values: Vec<f64> = (0..mesh.positions.len()).map(|i| i as f64 * 1e-3).collect();
    let pictures = Pictures {
        programs: vec![program(&names[0], Vec::new()), program(&names[1], vec![study])],
        joints: vec![JointPicture { name: "A".into(), unit: "deg", factor: 57.3, limits: [Some(90.0), None, None] }],
        part: Some(PartPicture {
            normals: Vec::new(),
            mesh,
            deviation: vec![values.clone(), values.clone()],
            difference: vec![Vec::new(), values],
            unrolled: (0..8).map(|i| [f64::from(i) * 10.0, f64::from(i % 3)]).collect(),
        }),
        plot_window_s: None,
    };
    Compared { comparison, pictures }
}

fn traces() -> Vec<Trace> {
    let mut joint = JointTrace::default();
    for i in 0..500 {
        for signal in &mut joint.signals {
            signal.push(f64::from(i) * 0.002, (f64::from(i) * 0.05).sin());
        }
    }
    vec![
        Trace { windows: [vec![joint.clone()], vec![joint.clone()]] },
        Trace { windows: [vec![joint.clone()], vec![joint]] },
    ]
}

fn page(text: &str) -> String {
    render(&compared(text), &traces()).expect("the template fits its data")
}

#[test]
fn nothing_of_a_comparison_becomes_markup() {
    let text = page(EVIL);
    assert!(!text.contains("<script>alert") && !text.contains("<img"), "a value went through unescaped");
    assert_eq!(text.matches("</script>").count(), 5, "only the five scripts of the page end");
    assert!(text.contains("&lt;script&gt;alert(1)") && text.contains("{{ 7*7 }}"), "text is shown, not run");
}

#[test]
fn the_page_stands_alone_and_its_tags_close() {
    let text = page("a < b & c");
    loads_nothing(&text);
    closes_in_order(&text);
    for part in text.split("href=\"#").skip(1) {
        let target = part.split('"').next().expect("quoted");
        assert!(text.contains(&format!("id=\"{target}\"")), "{target}");
    }
}

#[test]
fn every_section_has_its_numbers() {
    let text = page("plain");
    for needle in [
        "19.20 ± 1.40 %",
        "sign holds",
        "38.1 %",
        "41.5 %",
        "103.9",
        "15.7 µm",
        "data-layer=\"2\"",
        "data-cells=\"2\"",
        "62.4 deg&#x2f;s (machine 360)",
        "limits of the machine itself 18.00 %",
    ] {
        assert!(text.contains(needle), "{needle}");
    }
    assert!(text.contains(r#"class="circles""#) && text.contains(r#"class="triangles""#), "key points and marks");
    assert!(!text.contains("NaN"), "a missing number is shown as missing");
}

#[test]
fn a_comparison_without_part_and_method_has_a_page() {
    let mut bare = compared("plain");
    bare.pictures = Pictures { joints: bare.pictures.joints.clone(), ..Pictures::default() };
    bare.comparison.published.clear();
    bare.comparison.expectations.clear();
    bare.comparison.variations.clear();
    for p in bare.comparison.programs.values_mut() {
        (p.stretch, p.made, p.difference) = (None, None, None);
    }
    let text = render(&bare, &[]).expect("the template fits its data");
    closes_in_order(&text);
    assert!(!text.contains("part-mesh\"") && text.contains("no design surface"), "no viewer without a part");
}

/// Drawings show what is known, at its place, and escape text from the inputs.
#[test]
fn drawings_show_gains_over_limits_and_ranges_of_published_values() {
    let mut c = compared(EVIL).comparison;
    assert!(gain_drawing(&c).is_none(), "no limit binds");
    let row = |velocity_deg_s, is, saved_percent, saved_at_most_percent| GainAtLimit {
        joint: "A".into(),
        velocity_deg_s,
        is,
        saved_percent,
        saved_at_most_percent,
    };
    let name = c.order[1].clone();
    let made = c.programs.get_mut(&name).and_then(|p| p.made.as_mut()).expect("made");
    made.over_velocity = vec![
        row(360.0, VelocityLimit::OfMachine, 0.0, 0.0),
        row(104.0, VelocityLimit::OfOriginal, 0.0, 0.0),
        row(62.4, VelocityLimit::InForce, 16.4, 16.5),
        row(52.0, VelocityLimit::Tried, 18.0, 21.2),
    ];
    let text = gain_drawing(&c).expect("a drawing");
    closes_in_order(&text);
    assert!(!text.contains("<img") && !text.contains("<script"), "a value went through unescaped");
    assert!(!text.contains("NaN"), "{text}");
    for words in ["in force: 62.4", "needed by the program before: 104", "the machine's own: 360", "of A, deg/s"] {
        assert!(text.contains(&crate::chart::escape(words)), "{words}: {text}");
    }
    assert_eq!(text.matches("<circle").count(), 3, "the machine's own limit lies beyond the frame");
    // 41.5 of 38.1 percent, with a range over choices that reaches farther than the frame.
    let value = &mut c.published[0];
    (value.over_choices, value.over_twin) = (Some([30.0, 200.0]), Some([40.0, 42.0]));
    value.agreement = Agreement::Agrees;
    let text = ranges_drawing(&c).expect("a drawing");
    closes_in_order(&text);
    assert!(!text.contains("<img") && !text.contains("<script"), "a value went through unescaped");
    let dot = format!("cx=\"{:.1}\"", 270.0 + (732.0 - 270.0) * (41.5 / 38.1 + 0.5) / 3.0);
    assert!(text.contains(&dot) && text.contains("38.1 % published"), "{dot} {text}");
    assert!(!text.contains("NaN"), "{text}");
    let plain = ranges_drawing(&compared("plain").comparison).expect("a drawing");
    loads_nothing(&plain.replace("http://www.w3.org/2000/svg", ""));
    c.published.clear();
    assert!(ranges_drawing(&c).is_none());
}
