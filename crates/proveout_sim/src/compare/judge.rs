//! Published values and criteria against what was measured.

use super::result::{Comparison, Expectation, ProgramFigures, Published};
use crate::{
    scene::{CompareFile, ExpectFile, FormFile, QuantityFile},
    verdict::State,
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

/// A value with its unit, or why there is none.
struct Found {
    value: Result<f64, String>,
    unit: String,
}

/// Published values beside ours.
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
            (Some(v), Some([low, high])) => passed(low <= v && v <= high),
            _ => State::Unchecked,
        };
        Published {
            name: p.name.clone(),
            measured: wanted.words(),
            unit: found.unit,
            published: p.value,
            value,
            band: p.band,
            state,
            source: p.source.clone(),
            remark: p.remark.clone(),
        }
    };
    file.published.iter().map(one).collect()
}

/// Criteria of the scene.
pub(crate) fn expectations(file: &CompareFile, all: &Comparison) -> Vec<Expectation> {
    file.expect.iter().map(|e| expectation(e, all)).collect()
}

fn passed(yes: bool) -> State {
    if yes { State::Pass } else { State::Fail }
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
        let gate = all.programs.get(&e.program).and_then(|p| p.gates.iter().find(|g| g.name == *name));
        match gate {
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
            let above = e.at_least.is_none_or(|low| value >= low);
            out.state = passed(above && e.at_most.is_none_or(|high| value <= high));
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
        let unit = "%".to_owned();
        let other = self.value(all, against);
        let value = match (own.value, other.value) {
            (Ok(own), Ok(other)) => {
                let percent = match self.form {
                    FormFile::Reduction => 100.0 * (1.0 - own / other),
                    FormFile::Rate => 100.0 * (other / own - 1.0),
                };
                if percent.is_finite() {
                    Ok(percent)
                } else {
                    Err(format!("{} is zero: it has no change in percent", self.quantity.words()))
                }
            }
            (Err(e), _) | (_, Err(e)) => Err(e),
        };
        Found { value, unit }
    }

    fn value(&self, all: &Comparison, name: &str) -> Found {
        use QuantityFile::*;
        let Some(program) = all.programs.get(name) else {
            return Found { value: Err(format!("{name} has not run")), unit: String::new() };
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
            CenterShift => (program.made.as_ref().and_then(|m| m.center_shift_mm), "mm"),
            Clearance => (program.clearance.min_mm, "mm"),
            Study => return self.study(program, name),
            DemandVelocity | DemandAcceleration | MaxVelocity | MaxAcceleration | MaxJerk | Reversals => {
                return self.of_joint(program, name);
            }
        };
        let value = value.ok_or_else(|| format!("{} of {name} is not known", self.quantity.words()));
        Found { value, unit: unit.into() }
    }

    fn study(&self, program: &ProgramFigures, name: &str) -> Found {
        let wanted = self.figure.unwrap_or_default();
        let figures = program.made.as_ref().map(|m| m.figures.as_slice()).unwrap_or_default();
        match figures.iter().find(|f| f.name == wanted) {
            Some(figure) => Found { value: Ok(figure.value), unit: figure.unit.clone() },
            None => {
                let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
                let value = Err(format!("{name} has no number {wanted:?}; it has: {}", names.join(", ")));
                Found { value, unit: String::new() }
            }
        }
    }

    fn of_joint(&self, program: &ProgramFigures, name: &str) -> Found {
        use QuantityFile::*;
        let wanted = self.axis.unwrap_or_default();
        let axis = program.stretch.as_ref().and_then(|s| s.axes.get(wanted));
        let Some(axis) = axis else {
            let why = if program.stretch.is_none() { "no cutting stretch" } else { "no such joint" };
            return Found { value: Err(format!("{name} has {why}: {wanted}")), unit: String::new() };
        };
        let (value, per) = match self.quantity {
            DemandVelocity => (axis.demand_velocity, "/s"),
            DemandAcceleration => (axis.demand_acceleration, "/s²"),
            MaxVelocity => (Some(axis.max_velocity), "/s"),
            MaxAcceleration => (Some(axis.max_acceleration), "/s²"),
            MaxJerk => (Some(axis.max_jerk), "/s³"),
            _ => (Some(axis.reversals as f64), ""),
        };
        let unit = if per.is_empty() { String::new() } else { format!("{}{per}", axis.unit) };
        let value = value.ok_or_else(|| format!("{} of {wanted} is not known for {name}", self.quantity.words()));
        Found { value, unit }
    }
}
