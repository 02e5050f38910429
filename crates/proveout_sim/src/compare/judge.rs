//! Published values and criteria against what was measured.

use super::{
    agreement::agreement,
    result::{Agreement, Comparison, Depth, Expectation, ProgramFigures, Published},
};
use crate::{
    scene::{CompareFile, ExpectFile, FormFile, QuantityFile, compare::ROTARY},
    verdict::verdict_file::State,
};

/// What is asked for.
struct Wanted<'a> {
    program: &'a str,
    against: Option<&'a str>,
    quantity: QuantityFile,
    axis: Option<&'a str>,
    figure: Option<&'a str>,
    form: FormFile,
}

/// A value with its unit, or why there is none, and how far it may be off.
struct Found {
    value: Result<f64, String>,
    unit: String,
    error: f64,
}

impl Found {
    fn exact(value: Result<f64, String>, unit: impl Into<String>) -> Self {
        Self { value, unit: unit.into(), error: 0.0 }
    }
}

/// Whether a value keeps its bounds; undecided where a bound lies within its error.
fn within(value: f64, error: f64, [low, high]: [Option<f64>; 2]) -> State {
    let [low, high] = [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)];
    if value - error >= low && value + error <= high {
        State::Pass
    } else if value + error < low || value - error > high || error == 0.0 {
        State::Fail
    } else {
        State::Unchecked
    }
}

/// Published values compared with ours.
pub(crate) fn published(file: &CompareFile, all: &Comparison) -> Vec<Published> {
    let one = |p: &crate::scene::PublishedFile| {
        let wanted = Wanted {
            program: &p.program,
            against: p.against.as_deref(),
            quantity: p.quantity,
            axis: p.axis.as_deref(),
            figure: p.figure.as_deref(),
            form: p.form,
        };
        let found = wanted.find(all);
        let value = found.value.ok();
        let state = match (value, p.band) {
            (Some(v), Some(band)) => within(v, found.error, band.map(Some)),
            _ => State::Unchecked,
        };
        let mut row = Published {
            name: p.name.clone(),
            measured: wanted.words(),
            unit: found.unit,
            published: p.value,
            kind: p.kind,
            value,
            band: p.band,
            state,
            null_value: null(&wanted, all),
            over_choices: None,
            over_draws: None,
            over_twin: None,
            agreement: Agreement::NotComparable,
            decided_by: None,
            not_comparable: p.not_comparable.clone(),
            headline: p.headline,
            source: p.source.clone(),
            remark: p.remark.clone(),
        };
        row.agreement = agreement(&row);
        row
    };
    file.published.iter().map(one).collect()
}

/// The same quantity of the null program, against the same one.
fn null(wanted: &Wanted<'_>, all: &Comparison) -> Option<f64> {
    let program = all.null_program.as_deref().filter(|name| *name != wanted.program)?;
    if wanted.against == Some(program) {
        return None;
    }
    Wanted { program, ..*wanted }.find(all).value.ok()
}

/// Criteria of the scene.
pub(crate) fn expectations(file: &CompareFile, all: &Comparison) -> Vec<Expectation> {
    file.expect.iter().map(|e| expectation(e, all)).collect()
}

fn expectation(e: &ExpectFile, all: &Comparison) -> Expectation {
    let mut out = Expectation {
        name: e.name.clone(),
        measured: String::new(),
        unit: String::new(),
        value: None,
        at_least: e.at_least,
        at_most: e.at_most,
        state: State::Unchecked,
        reason: String::new(),
        source: e.source.clone(),
    };
    if let Some(name) = &e.gate {
        out.measured = format!("gate {name} of {}", e.program);
        let gate = all.programs.get(&e.program).and_then(|p| p.gates.iter().find(|g| g.gate.name() == name));
        match gate {
            // A criterion asks what the scene does not: it is open.
            Some(gate) if gate.state == State::NotAsked => out.reason = format!("not asked: {}", gate.reason),
            Some(gate) => (out.state, out.reason) = (gate.state, gate.reason.clone()),
            None => out.reason = "the program has not run".into(),
        }
        return out;
    }
    let Some(quantity) = e.quantity else { return out };
    let wanted = Wanted {
        program: &e.program,
        against: e.against.as_deref(),
        quantity,
        axis: e.axis.as_deref(),
        figure: e.figure.as_deref(),
        form: e.form,
    };
    let found = wanted.find(all);
    (out.measured, out.unit) = (wanted.words(), found.unit);
    match found.value {
        Ok(value) => {
            out.value = Some(value);
            out.state = within(value, found.error, [e.at_least, e.at_most]);
            if out.state == State::Unchecked {
                out.reason = format!("its error of {:.3} {} includes a bound", found.error, out.unit);
            }
        }
        Err(reason) => out.reason = reason,
    }
    out
}

impl Wanted<'_> {
    fn words(&self) -> String {
        let what = match (self.axis, self.figure) {
            (Some(axis), _) => format!("{} of {axis}", self.quantity.words()),
            (None, Some(figure)) => figure.to_owned(),
            (None, None) => self.quantity.words().to_owned(),
        };
        match (self.against, self.form) {
            (None, _) => format!("{what}, {}", self.program),
            (Some(against), FormFile::Reduction) => format!("{what}: {} less than {against}", self.program),
            (Some(against), FormFile::Rate) => format!("{what}: rate of {} above {against}", self.program),
        }
    }

    fn find(&self, all: &Comparison) -> Found {
        let own = self.value(all, self.program);
        let Some(against) = self.against else { return own };
        let other = self.value(all, against);
        // Of a quotient of two values, each off by its error.
        let error = match (&own.value, &other.value) {
            (Ok(a), Ok(b)) if own.error + other.error > 0.0 => {
                let (a, b) = if self.form == FormFile::Rate { (b, a) } else { (a, b) };
                100.0 * (own.error.max(other.error) / b.abs() + (a / (b * b)).abs() * own.error.max(other.error))
            }
            _ => 0.0,
        };
        let value = match (own.value, other.value) {
            (Ok(own), Ok(other)) => {
                let percent = match self.form {
                    FormFile::Reduction => 100.0 * (1.0 - own / other),
                    FormFile::Rate => 100.0 * (other / own - 1.0),
                };
                if percent.is_finite() {
                    Ok(percent)
                } else {
                    Err(format!("{} is zero: its change in percent is undefined", self.quantity.words()))
                }
            }
            (Err(e), _) | (_, Err(e)) => Err(e),
        };
        Found { value, unit: "%".into(), error }
    }

    fn value(&self, all: &Comparison, name: &str) -> Found {
        use QuantityFile::*;
        let Some(program) = all.programs.get(name) else {
            return Found::exact(Err(format!("{name} has not run")), "");
        };
        let (value, unit) = match self.quantity {
            CycleTime => (Some(program.time.total_s), "s"),
            CuttingTime => (Some(program.time.cutting_s), "s"),
            StretchTime => (program.stretch.as_ref().map(|s| s.time_s), "s"),
            SmallestGain => (all.gains.get(name).and_then(|g| g.stretch_time.smallest_percent), "%"),
            Gouge => (program.deviation.gouge_max_mm, "mm"),
            Excess => (program.deviation.excess_max_mm, "mm"),
            ScallopMax => (program.surface.scallop_max_um, "µm"),
            ScallopMean => (program.surface.scallop_mean_um, "µm"),
            ScallopP95 => (program.surface.scallop_p95_um, "µm"),
            CenterShift => (program.made.as_ref().and_then(|m| m.center_shift_mm), "mm"),
            Clearance => (program.clearance.min_mm.map(|m| m - program.clearance.error_mm.unwrap_or(0.0)), "mm"),
            Study => return self.study(program, name),
            StraightJointsTip => (program.stretch.as_ref().and_then(|s| s.straight_joints_tip_um), "µm"),
            FromTurning => (program.stretch.as_ref().and_then(|s| s.from_turning), "mm/mm"),
            DepthMean | DepthDeviation | DepthLeast | DepthMost => {
                let depth = program.stretch.as_ref().and_then(|s| s.depth.as_ref());
                let of = |d: &Depth| match self.quantity {
                    DepthMean => d.mean_um,
                    DepthDeviation => d.deviation_um,
                    DepthLeast => d.least_um,
                    _ => d.most_um,
                };
                (depth.map(of), "µm")
            }
            Travel | Range | DemandVelocity | DemandAcceleration | MaxVelocity | MaxAcceleration | MaxJerk
            | Reversals => {
                return self.of_joint(program, name);
            }
        };
        let value = value.ok_or_else(|| format!("{} of {name} is not known", self.quantity.words()));
        let error = match self.quantity {
            ScallopMax => program.surface.scallop.as_ref().map_or(0.0, |s| s.bound_um),
            ScallopMean => program.surface.scallop.as_ref().map_or(0.0, |s| s.mean_bound_um),
            ScallopP95 => program.surface.scallop.as_ref().map_or(0.0, |s| s.p95_bound_um),
            _ => 0.0,
        };
        Found { value, unit: unit.into(), error }
    }

    fn study(&self, program: &ProgramFigures, name: &str) -> Found {
        let wanted = self.figure.unwrap_or_default();
        let figures = program.made.as_ref().map(|m| m.figures.as_slice()).unwrap_or_default();
        match figures.iter().find(|f| f.name == wanted) {
            Some(figure) => Found::exact(Ok(figure.value), figure.unit.clone()),
            None => {
                let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
                let value = Err(format!("{name} has no number {wanted:?}; it has: {}", names.join(", ")));
                Found::exact(value, "")
            }
        }
    }

    fn of_joint(&self, program: &ProgramFigures, name: &str) -> Found {
        use QuantityFile::*;
        let wanted = self.axis.unwrap_or_default();
        if wanted == ROTARY {
            let together = program.stretch.as_ref().and_then(|s| s.rotary.as_ref());
            let (value, unit) = match self.quantity {
                DemandVelocity => (together.and_then(|r| r.velocity), "deg/s"),
                _ => (together.and_then(|r| r.acceleration), "deg/s²"),
            };
            return Found::exact(value.ok_or_else(|| format!("the rotary demand of {name} is not known")), unit);
        }
        let axis = program.stretch.as_ref().and_then(|s| s.axes.get(wanted));
        let Some(axis) = axis else {
            let why = if program.stretch.is_none() { "no cutting stretch" } else { "no such joint" };
            return Found::exact(Err(format!("{name} has {why}: {wanted}")), "");
        };
        let (value, per) = match self.quantity {
            DemandVelocity => (axis.demand_velocity, "/s"),
            DemandAcceleration => (axis.demand_acceleration, "/s²"),
            MaxVelocity => (Some(axis.max_velocity), "/s"),
            MaxAcceleration => (Some(axis.max_acceleration), "/s²"),
            MaxJerk => (Some(axis.max_jerk), "/s³"),
            Travel => return Found::exact(Ok(axis.travel), axis.unit.clone()),
            Range => return Found::exact(Ok(axis.range), axis.unit.clone()),
            _ => (Some(axis.reversals as f64), ""),
        };
        let unit = if per.is_empty() { String::new() } else { format!("{}{per}", axis.unit) };
        let value = value.ok_or_else(|| format!("{} of {wanted} is not known for {name}", self.quantity.words()));
        Found::exact(value, unit)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proveout_input::Document;

    use super::*;
    use crate::{
        compare::result::{Made, Stretch, StretchAxis},
        observe::study::StudyFigure,
        verdict::gate::Gate,
        verdict::verdict_file::{Clearance, Deviation, GateVerdict, Surface, Time},
    };

    fn program(time: f64, acceleration: Option<f64>) -> ProgramFigures {
        let axis = StretchAxis {
            unit: "deg".into(),
            max_velocity: 90.0,
            max_acceleration: 600.0,
            max_jerk: 12_000.0,
            reversals: 2,
            travel: 30.0,
            range: 20.0,
            demand_velocity: Some(100.0),
            demand_acceleration: acceleration,
        };
        let gate = |gate: Gate, state| GateVerdict { gate, state, reason: format!("{gate} by test") };
        ProgramFigures {
            folder: "p".into(),
            verdict: State::Unchecked,
            gates: vec![gate(Gate::Gouge, State::Pass), gate(Gate::Collision, State::Unchecked)],
            errors: 0,
            digests: BTreeMap::new(),
            made: Some(Made {
                method: "m".into(),
                source: String::new(),
                from: "a".into(),
                center_shift_mm: None,
                figures: vec![StudyFigure { name: "smallest margin".into(), unit: "deg".into(), value: 0.25 }],
                over_velocity: Vec::new(),
            }),
            time: Time { total_s: time + 10.0, cutting_s: time, ..Time::default() },
            axes: BTreeMap::new(),
            stretch: Some(Stretch {
                blocks: 1,
                time_s: time,
                programmed_s: time,
                axes: BTreeMap::from([("A".to_owned(), axis)]),
                rotary: None,
                straight_joints_tip_um: None,
                from_turning: None,
                depth: None,
            }),
            deviation: Deviation::default(),
            surface: Surface::default(),
            difference: None,
            clearance: Clearance::default(),
        }
    }

    fn comparison() -> Comparison {
        let programs =
            [("a", program(80.0, Some(4000.0))), ("b", program(64.0, Some(1000.0))), ("c", program(0.0, None))];
        Comparison {
            schema_version: 1,
            scene: String::new(),
            description: String::new(),
            experiment: String::new(),
            machine: String::new(),
            joint_limits: Vec::new(),
            baseline: "a".into(),
            cells_mm: [0.0; 3],
            scene_cells: true,
            motion_only: false,
            order: Vec::new(),
            verdict: State::Unchecked,
            programs: programs.map(|(name, p)| (name.to_owned(), p)).into(),
            gains: BTreeMap::new(),
            variations: Vec::new(),
            own_limits: None,
            choices: None,
            null_program: None,
            must_pass: None,
            published: Vec::new(),
            expectations: Vec::new(),
            rules: BTreeMap::new(),
        }
    }

    fn file(text: &str) -> CompareFile {
        Document::new(std::path::Path::new("scene.toml"), text).read().expect("a section")
    }

    #[test]
    fn time_saved_and_rate_are_two_readings_and_a_band_decides() {
        let text = r#"
            [[published]]
            name = "saved"
            program = "b"
            against = "a"
            quantity = "stretch-time"
            value = 24.5
            band = [15, 35]
            source = "s"
            [[published]]
            name = "rate"
            program = "b"
            against = "a"
            quantity = "stretch-time"
            form = "rate"
            value = 24.5
            band = [15, 24.9]
            source = "s"
            [[published]]
            name = "acceleration"
            program = "b"
            against = "a"
            quantity = "demand-acceleration"
            axis = "A"
            value = 72.9
            source = "s"
            [[published]]
            name = "not known"
            program = "c"
            against = "a"
            quantity = "demand-acceleration"
            axis = "A"
            value = 72.9
            band = [0, 100]
            source = "s"
        "#;
        let rows = published(&file(text), &comparison());
        let seen: Vec<_> = rows.iter().map(|p| (p.value, p.state)).collect();
        let close = |v: Option<f64>, wanted: f64| v.is_some_and(|v| (v - wanted).abs() < 1e-9);
        assert!(close(seen[0].0, 20.0) && seen[0].1 == State::Pass, "{rows:?}");
        assert!(close(seen[1].0, 25.0) && seen[1].1 == State::Fail, "{rows:?}");
        assert!(close(seen[2].0, 75.0) && seen[2].1 == State::Unchecked, "no band, no judgement: {rows:?}");
        assert_eq!(seen[3], (None, State::Unchecked), "a value that is not known is never reproduced");
    }

    #[test]
    fn a_bound_within_the_error_of_a_scallop_is_unchecked() {
        let text = "[[expect]]\nname = \"scallop\"\nprogram = \"b\"\nagainst = \"a\"\nquantity = \"scallop-p95\"\nat_least = -5\nat_most = 5\n";
        let judged = |p95: f64, bound_um: f64| {
            let mut all = comparison();
            for (name, value) in [("a", 10.0), ("b", p95)] {
                let surface = Surface {
                    scallop_p95_um: Some(value),
                    scallop: Some(crate::verdict::verdict_file::Scallop {
                        p95_bound_um: bound_um,
                        ..Default::default()
                    }),
                    ..Surface::default()
                };
                all.programs.get_mut(name).expect("a program").surface = surface;
            }
            let mut rows = expectations(&file(text), &all);
            rows.remove(0)
        };
        // 7 percent more, each known to 0.1 of 10 micrometers: 1 + 1.07 percent.
        assert_eq!(judged(10.7, 0.0).state, State::Fail);
        assert_eq!(judged(10.7, 0.05).state, State::Fail);
        let open = judged(10.7, 0.1);
        assert_eq!(open.state, State::Unchecked, "{open:?}");
        assert!(open.reason.starts_with("its error of 2.070 %"), "{}", open.reason);
        assert_eq!(judged(10.4, 0.1).state, State::Unchecked, "nor is it kept for sure");
        assert_eq!(judged(10.2, 0.1).state, State::Pass);
    }

    #[test]
    fn a_missed_band_fails_the_comparison_and_a_value_without_one_does_not() {
        let verdict = |value: f64, band: &str| {
            let text = format!(
                "[[published]]\nname = \"saved\"\nprogram = \"b\"\nagainst = \"a\"\nquantity = \"demand-acceleration\"\naxis = \"A\"\n\
                 value = 50\n{band}\nsource = \"s\"\n"
            );
            let mut all = comparison();
            for p in all.programs.values_mut() {
                p.verdict = State::Pass;
            }
            let demand = |p: &mut ProgramFigures, v: Option<f64>| {
                let axis = p.stretch.as_mut().and_then(|s| s.axes.get_mut("A")).expect("A");
                axis.demand_acceleration = v;
            };
            demand(all.programs.get_mut("b").expect("b"), Some(value).filter(|v| v.is_finite()));
            all.published = published(&file(&text), &all);
            crate::compare::finish::overall(&all, None)
        };
        assert_eq!(verdict(2000.0, "band = [40, 60]"), State::Pass, "half of 4000");
        assert_eq!(verdict(3000.0, "band = [40, 60]"), State::Fail, "a quarter");
        assert_eq!(verdict(3000.0, ""), State::Pass, "shown, not judged");
        assert_eq!(verdict(f64::NAN, "band = [40, 60]"), State::Unchecked, "no value: not reproduced, not refuted");
    }

    #[test]
    fn criteria_are_judged_and_what_is_not_known_is_unchecked() {
        let text = r#"
            [[expect]]
            name = "gate passes"
            program = "b"
            gate = "gouge"
            [[expect]]
            name = "gate unchecked"
            program = "b"
            gate = "collision"
            [[expect]]
            name = "too many"
            program = "b"
            quantity = "reversals"
            axis = "A"
            at_most = 1
            [[expect]]
            name = "at the bound"
            program = "b"
            quantity = "study"
            figure = "smallest margin"
            at_least = 0.25
            [[expect]]
            name = "no such number"
            program = "b"
            quantity = "study"
            figure = "largest margin"
            at_least = 0
            [[expect]]
            name = "no such joint"
            program = "b"
            quantity = "max-jerk"
            axis = "C"
            at_most = 1e9
            [[expect]]
            name = "no scallop"
            program = "b"
            against = "a"
            quantity = "scallop-max"
            at_most = 5
            [[expect]]
            name = "division by zero"
            program = "a"
            against = "c"
            quantity = "stretch-time"
            at_least = 0
        "#;
        use State::{Fail, Pass, Unchecked};
        let rows = expectations(&file(text), &comparison());
        let states: Vec<State> = rows.iter().map(|e| e.state).collect();
        assert_eq!(states, [Pass, Unchecked, Fail, Pass, Unchecked, Unchecked, Unchecked, Unchecked], "{rows:?}");
        for row in rows.iter().filter(|e| e.state == Unchecked) {
            assert!(!row.reason.is_empty(), "{row:?}");
        }
        assert!(rows[4].reason.contains("smallest margin"), "what there is: {}", rows[4].reason);
    }
}
