//! The page over plain data: no loads from elsewhere, nothing unescaped, well-formed markup.

use proveout_geom::cylinder_mesh;
use proveout_sim::{
    finding::{Family, Finding, Severity},
    listing::Listing,
    verdict::{self, Axis, AxisUnit, Gate, GateVerdict, Inspected, MachineUsed, State, ToolUse, Verdict},
};

use super::gouge_excess_scale::{Scale, Scales};
use super::{
    blocks::LineNumbers,
    data::{JointSignals, Page, PartView, ProcessSignals, ProgramView},
    findings::FindingContext,
    operations::Operation,
    page::render,
    player::PlayerView,
};
use crate::picture::Picture;

/// Text that would be markup, a script end or a load if it went through unescaped.
pub(crate) const EVIL: &str =
    "</script><script>alert(1)</script><img src='http://evil.example/x' onerror=\"x\"> & {{ 7*7 }}";

pub(crate) fn finding(severity: Severity, code: &str, message: &str) -> Finding {
    Finding {
        code: code.into(),
        family: Family::Collision,
        severity,
        file: Some("axis/part.mpf".into()),
        line: Some(1204),
        block: Some(1198),
        time_s: Some(83.4),
        axes: [("X".to_owned(), 12.5), ("B".to_owned(), -30.0)].into(),
        bodies: vec!["holder".into(), "stock".into()],
        point_mm: Some([1.0, 2.0, 30.0]),
        penetration_mm: Some(0.41),
        clearance_mm: None,
        value: None,
        limit: None,
        unit: None,
        area_mm2: None,
        volume_mm3: None,
        areas: None,
        repeats: 3,
        message: message.into(),
        tool: None,
        limit_source: None,
    }
}

pub(crate) fn verdict(message: &str) -> Verdict {
    let axis = Axis {
        unit: AxisUnit::Mm,
        min: -120.0,
        max: 80.0,
        max_velocity: 500.0,
        max_acceleration: 4000.0,
        max_jerk: 50_000.0,
        velocity_utilisation: Some(1.0),
        acceleration_utilisation: Some(0.8),
        jerk_utilisation: None,
        reversals: 211,
        max_following_error: None,
        ..Axis::default()
    };
    Verdict {
        schema_version: 1,
        scene: message.into(),
        program: message.into(),
        machine: MachineUsed { name: message.into(), digest: "3f".repeat(32) },
        digests: [(message.to_owned(), "ab".repeat(32))].into(),
        set: [("control.path_tolerance_mm".to_owned(), message.to_owned())].into(),
        verdict: State::Fail,
        gates: vec![GateVerdict { gate: Gate::Collision, state: State::Fail, reason: message.into() }],
        partial: None,
        findings: vec![
            finding(Severity::Info, "program-note", message),
            finding(Severity::Error, "collision-holder-stock", message),
            finding(Severity::Error, message, message),
        ],
        time: verdict::Time {
            total_s: 100.0,
            cutting_s: 60.0,
            rapid_s: 20.0,
            dwell_s: 5.0,
            tool_change_s: 15.0,
            lower_bound_s: Some(95.0),
            path_bound_s: Some(97.0),
        },
        axes: [("X".to_owned(), axis)].into(),
        path: verdict::Path::default(),
        removal: verdict::Removal { volume_mm3: 4200.0, ..Default::default() },
        deviation: verdict::Deviation { gouge_max_mm: Some(0.004), excess_max_mm: Some(0.2), ..Default::default() },
        surface: verdict::Surface::default(),
        clearance: verdict::Clearance {
            min_mm: Some(0.5),
            pair: Some([message.into(), "table".into()]),
            time_s: Some(3.0),
            checks: 9,
            ..verdict::Clearance::default()
        },
        tools: vec![ToolUse { number: 4, name: message.into(), ..Default::default() }],
        inspection: vec![Inspected {
            name: message.into(),
            nominal_mm: 10.0,
            measured_mm: Some(10.002),
            tolerance_mm: 0.01,
        }],
        probing: Vec::new(),
    }
}

fn program(message: &str) -> ProgramView {
    let listing = Listing {
        file: "axis/part.mpf".into(),
        lines: 1300,
        shown: (1203..1206).map(|n| (n, format!("N{n} {message}"))).collect(),
    };
    let operation = Operation {
        text: message.into(),
        tool: Some(0),
        lines: Some([3, 90]),
        time_s: 70.0,
        feed_s: 60.0,
        feed_mm: 900.0,
        fed_s: 60.0,
        programmed_s: 45.0,
        ..Operation::default()
    };
    let explained = FindingContext { tool: message.into(), basis: message.into(), line: 1204 };
    ProgramView {
        numbers: LineNumbers { files: vec![("axis/part.mpf".into(), 0)] },
        listings: vec![listing],
        left_out: message.into(),
        operations: vec![operation],
        tools: vec![(4, message.into())],
        explained: vec![explained; 3],
        unchecked: vec![[message.into(), message.into()]],
        ..ProgramView::default()
    }
}

fn page(message: &str) -> String {
    let mut x =
        JointSignals { name: message.into(), unit: "mm", limits: [Some(500.0), None, None], ..Default::default() };
    let mut process = ProcessSignals { tool_changes: vec![(4.0, message.into())], ..Default::default() };
    for i in 0..500 {
        let t = f64::from(i) * 0.2;
        x.signals[0].push(t, t.sin() * 100.0);
        x.signals[1].push(t, t.cos() * 480.0);
        process.feed.push(t, 900.0);
    }
    let mut picture = Picture::creased(&cylinder_mesh(20.0, 0.0, 30.0, 48), 0.5);
    picture.values = vec![-0.25; picture.positions.len()];
    picture.pieces = vec![0; picture.positions.len()];
    let scale = Scale { shown: 0.05, most_points: 0.05, largest: 3.0, tolerance: 0.01 };
    let part = PartView {
        triangles: picture.triangles.len(),
        picture,
        scales: Some(Scales { gouge: scale, excess: scale }),
        cell: None,
        shares: vec![0.1, 0.8, 0.1],
        outside: [0.0, 0.01],
    };
    let v = verdict(message);
    let player = PlayerView {
        data: serde_json::json!({ "bodies": [{ "name": message }], "jumps": { "tools": [{ "text": message }] } }),
        motion: vec![1, 2, 3],
        meshes: vec![0; 4],
        stock: vec![0; 4],
        notes: vec![message.into()],
    };
    let page = Page {
        verdict: &v,
        machine: message,
        description: message,
        method: vec![("Cell".into(), message.into())],
        joints: &[x],
        process: &process,
        part: &part,
        textures: &[],
        contacts: &[],
        program: &program(message),
        player: Some(&player),
        axes: None,
    };
    render(&page).expect("the template fits its data")
}

#[test]
fn nothing_of_the_run_becomes_markup() {
    let text = page(EVIL);
    assert!(!text.contains("<script>alert") && !text.contains("<img"), "a value went through unescaped");
    assert_eq!(text.matches("</script>").count(), 12, "only the twelve scripts of the page end");
    assert!(text.contains("&lt;script&gt;alert(1)") && text.contains("{{ 7*7 }}"), "text is shown, not run");
}

#[test]
fn the_page_loads_nothing() {
    loads_nothing(&page("plain"));
}

pub(crate) fn loads_nothing(text: &str) {
    for needle in ["http://", "https://", "src=", "@import", "url(", "<link", "import(", "fetch("] {
        assert!(!text.contains(needle), "{needle} is in the page");
    }
}

#[test]
fn tags_close_in_order() {
    closes_in_order(&page("a < b & c"));
}

pub(crate) fn closes_in_order(text: &str) {
    let void = ["meta", "br", "img", "input", "hr"];
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        if rest.starts_with('!') {
            continue;
        }
        let end = rest.find('>').expect("a tag ends");
        let (tag, close) = rest[..end].strip_prefix('/').map_or((&rest[..end], false), |t| (t, true));
        let name = tag.split([' ', '\n', '/']).next().unwrap_or_default();
        assert!(name.chars().all(|c| c.is_ascii_alphanumeric()) && !name.is_empty(), "odd tag {tag:?}");
        if close {
            assert_eq!(open.pop(), Some(name), "before {}", &rest[..end.min(60)]);
        } else if !void.contains(&name) && !tag.ends_with('/') {
            open.push(name);
        }
        rest = &rest[end + 1..];
        if !close && (name == "script" || name == "style") {
            rest = &rest[rest.find(&format!("</{name}")).expect("raw text ends")..];
        }
    }
    assert!(open.is_empty(), "{open:?} stay open");
}

/// A joint that is simulated with its drive, saturated for half a second.
fn driven() -> (Verdict, JointSignals) {
    let mut x = JointSignals {
        name: "X".into(),
        unit: "mm",
        travel: Some([-150.0, 5000.0]),
        limits: [Some(500.0), Some(4000.0), None],
        effort: "force",
        force_unit: "N",
        force_limit: Some(2000.0),
        ..Default::default()
    };
    for i in 0..5000 {
        let t = f64::from(i) * 0.02;
        for (k, size) in [120.0, 480.0, 300.0, 2e4].into_iter().enumerate() {
            x.signals[k].push(t, size * t.sin());
        }
        let force = if (40.0..40.5).contains(&t) { 2000.0 } else { 900.0 * t.cos() };
        x.following.push(t, 0.01 * t.cos());
        x.force.push(t, force);
        x.power.push(t, 300.0 * t.sin());
        if force >= 2000.0 {
            x.saturated.push(t, 1.0);
        }
    }
    let mut v = verdict("plain");
    let axis = v.axes.get_mut("X").expect("X");
    (axis.max_following_error, axis.max_drive_force) = (Some(0.0123), Some(2000.0));
    (axis.drive_force_unit, axis.drive_utilisation) = (Some("N".into()), Some(1.0));
    (axis.max_drive_power_w, axis.drive_energy_j) = (Some(312.5), Some(4567.0));
    (v, x)
}

#[test]
fn drives_have_their_table_and_strips_and_saturation_is_marked() {
    let (v, x) = driven();
    let text = |v: &Verdict, joints: &[JointSignals]| {
        let (process, part) = (ProcessSignals::default(), PartView::default());
        let page = Page {
            verdict: v,
            machine: "m",
            description: "",
            method: Vec::new(),
            joints,
            process: &process,
            part: &part,
            textures: &[],
            contacts: &[],
            program: &ProgramView::default(),
            player: None,
            axes: None,
        };
        render(&page).expect("the template fits its data")
    };
    let page = text(&v, std::slice::from_ref(&x));
    for words in [
        "Following error, mm",
        "Drive force, N",
        "Drive power, W",
        "Position, mm",
        "Jerk, mm/s³",
        "12.3 µm",
        "2000 N",
        "100.0 %",
        "312.5 W",
        "4.567 kJ",
        "over-limit",
        "Red bars",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert_eq!(page.matches("class=\"saturated\"").count(), 1, "one stretch at the force limit");
    // Lower end of travel, both limits of speed, both of force; the upper end of travel and the acceleration
    // are far.
    assert_eq!(page.matches("class=\"limit\"").count(), 5);
    assert!(!page.contains("were not simulated"));
    // Without drives nothing is shown of them, and the page says so.
    let still = JointSignals { name: "X".into(), unit: "mm", ..Default::default() };
    let page = text(&verdict("plain"), &[still]);
    assert!(page.contains("Drives were not simulated") && !page.contains("Drive force") && !page.contains("Red bars"));
}

#[test]
fn every_jump_has_its_target() {
    let text = page("plain");
    for part in text.split("href=\"#").skip(1) {
        let target = part.split('"').next().expect("quoted");
        assert!(text.contains(&format!("id=\"{target}\"")), "{target}");
    }
    let errors = text.find("collision-holder-stock").expect("there");
    assert!(errors < text.find("program-note").expect("there"), "errors come first");
}
