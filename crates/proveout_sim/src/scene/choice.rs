//! What a published experiment leaves open: keys of a scene, limits of a machine, options of a method, each
//! with the range that it might have as well.
//!
//! A key is named by its tables with points between them; an entry of a list by its `name`, or by
//! its number from 0: `program.quaternion.reschedule.keys`,
//! `control.joint_limits.A.max_velocity_deg_s`, `plan.helix.lead_deg`. Limits of the machine are
//! under `machine`, by joint: `machine.A.max_acceleration_deg_s2`. So are the gains of position
//! loops, `machine.A.position_gain_1_s`, those of a platform's legs under its name.

use proveout_geom::rad;
use proveout_machine::{Joint, Machine};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::scene::SceneFile;

/// A choice and the values that it might have as well.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChoiceFile {
    /// What it is, in words.
    pub name: String,
    /// The key: tables and names with points between them; limits of the machine as `machine.JOINT.KEY`.
    pub key: String,
    /// From where to where it might lie, in the unit of the key. Either this or `values`.
    pub range: Option<[f64; 2]>,
    /// The values that it might have, for whole numbers and words.
    pub values: Option<Vec<ChoiceValueFile>>,
    /// Who says so.
    pub source: ChoiceSourceFile,
    /// Why this range, and where it is published.
    pub reason: String,
}

/// A value of a choice.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "write a number, a word, or true or false")]
pub enum ChoiceValueFile {
    /// A switch.
    Switch(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A word.
    Word(String),
}

/// Who says where a choice lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ChoiceSourceFile {
    /// The paper, with the range that it leaves.
    Published,
    /// No source: a number that had to be chosen.
    Chosen,
    /// It follows from published numbers.
    Inferred,
}

impl ChoiceSourceFile {
    /// The word used in a scene.
    pub fn word(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Chosen => "chosen",
            Self::Inferred => "inferred",
        }
    }
}

/// Tables of a scene in which a choice may lie: all others decide what is cut, not how the programs move.
const TABLES: [&str; 5] = ["control", "machine", "part", "plan", "program"];

impl ChoiceFile {
    /// What is wrong with it, and what to write.
    pub(crate) fn fault(&self, file: &SceneFile) -> Option<(String, String)> {
        let name = &self.name;
        let steps: Vec<&str> = self.key.split('.').collect();
        if steps.len() < 2 || steps.iter().any(|s| s.is_empty()) || !TABLES.contains(&steps[0]) {
            let message = format!("the key of the choice {name:?} does not affect the motion: {:?}", self.key);
            return Some((message, format!("name a key under {}", TABLES.join(", "))));
        }
        let ends = self.range.unwrap_or([0.0, 1.0]);
        let empty = ends[0] >= ends[1] || ends.iter().any(|v| !v.is_finite());
        let none = self.values.as_ref().is_some_and(|v| v.len() < 2 || v.iter().any(ChoiceValueFile::is_no_number));
        if self.range.is_some() == self.values.is_some() || empty || none {
            let message = format!("the choice {name:?} needs exactly one range");
            return Some((message, "give either range = [low, high], or two or more values".to_owned()));
        }
        if self.reason.trim().is_empty() {
            return Some((format!("the choice {name:?} has no reason"), "say why this range".to_owned()));
        }
        let unplanned = file.program.iter().find(|p| p.file.is_some() && p.planned.is_none());
        if let Some(program) = unplanned.filter(|_| self.plans()) {
            let message = format!(
                "the choice {name:?} changes a plan, but the scene does not state which plan writes {:?}",
                program.name
            );
            return Some((message, "give `planned` in its [[program]], the name of the table under [plan]".to_owned()));
        }
        if let ["machine", joint, limit] = steps[..] {
            let known = limit == GAIN || LIMITS.iter().any(|(key, ..)| *key == limit);
            let help =
                format!("write machine.JOINT.KEY with one of {}, {GAIN}", LIMITS.map(|(key, ..)| key).join(", "));
            return (joint.is_empty() || !known).then(|| (format!("the choice {name:?} names no limit"), help));
        }
        (steps[0] == "machine")
            .then(|| (format!("the choice {name:?} names no joint and limit"), "write machine.JOINT.KEY".to_owned()))
    }

    /// Whether programs have to be planned again.
    pub(crate) fn plans(&self) -> bool {
        self.key.starts_with("plan.") || self.key.starts_with("part.")
    }

    /// The values that are tried one at a time.
    pub(crate) fn ends(&self) -> Vec<ChoiceValueFile> {
        match (&self.range, &self.values) {
            (Some(ends), _) => ends.iter().map(|v| ChoiceValueFile::Number(*v)).collect(),
            (_, values) => values.clone().unwrap_or_default(),
        }
    }

    /// The value at a part of the range, 0 to below 1.
    pub(crate) fn at(&self, part: f64) -> Option<ChoiceValueFile> {
        match (&self.range, &self.values) {
            (Some([low, high]), _) => Some(ChoiceValueFile::Number(low + (high - low) * part)),
            (_, Some(values)) => values.get((part * values.len() as f64) as usize).cloned(),
            _ => None,
        }
    }
}

impl ChoiceValueFile {
    fn is_no_number(&self) -> bool {
        matches!(self, Self::Number(v) if !v.is_finite())
    }

    /// The words used in a table.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Switch(v) => v.to_string(),
            Self::Whole(v) => v.to_string(),
            Self::Number(v) => format!("{v:.6}").trim_end_matches('0').trim_end_matches('.').to_owned(),
            Self::Word(v) => v.clone(),
        }
    }

    /// To the last digit.
    pub fn exact(&self) -> String {
        match self {
            Self::Number(v) => v.to_string(),
            _ => self.words(),
        }
    }

    /// As JSON.
    pub fn json(&self) -> serde_json::Value {
        match self {
            Self::Switch(v) => (*v).into(),
            Self::Whole(v) => (*v).into(),
            Self::Number(v) => (*v).into(),
            Self::Word(v) => v.as_str().into(),
        }
    }

    /// From JSON; none where it is no single value.
    pub fn of_json(value: &serde_json::Value) -> Option<Self> {
        Some(match value {
            serde_json::Value::Bool(v) => Self::Switch(*v),
            serde_json::Value::Number(n) => {
                n.as_i64().map_or_else(|| n.as_f64().map(Self::Number), |v| Some(Self::Whole(v)))?
            }
            serde_json::Value::String(v) => Self::Word(v.clone()),
            _ => return None,
        })
    }

    fn value(&self) -> Value {
        match self {
            Self::Switch(v) => Value::Boolean(*v),
            Self::Whole(v) => Value::Integer(*v),
            Self::Number(v) => Value::Float(*v),
            Self::Word(v) => Value::String(v.clone()),
        }
    }
}

/// The text of a scene with other values; keys of the machine are left out.
///
/// # Errors
/// A key that leads nowhere.
pub(crate) fn with_values(text: &str, values: &[(&str, ChoiceValueFile)]) -> Result<String, String> {
    let table: Table = text.parse().map_err(|e: toml::de::Error| e.message().to_owned())?;
    let mut whole = Value::Table(table);
    for (key, value) in values.iter().filter(|(key, _)| !key.starts_with("machine.")) {
        put(&mut whole, key, value).ok_or_else(|| format!("the scene has no key {key}"))?;
    }
    toml::to_string(&whole).map_err(|e| e.to_string())
}

/// Puts a value at a key; none where the key leads nowhere.
pub(crate) fn put(whole: &mut Value, key: &str, value: &ChoiceValueFile) -> Option<()> {
    let (parents, last) = key.rsplit_once('.').map_or((None, key), |(parents, last)| (Some(parents), last));
    let mut at = whole;
    for step in parents.iter().flat_map(|parents| parents.split('.')) {
        // A table that the scene leaves out is made; what does not belong into it is refused when the scene
        // is read.
        if let Value::Table(table) = at {
            table.entry(step).or_insert_with(|| Value::Table(Table::new()));
        }
        at = entry(at, step)?;
    }
    match at {
        Value::Table(table) => {
            table.insert(last.to_owned(), value.value());
        }
        Value::Array(_) => *entry(at, last)? = value.value(),
        _ => return None,
    }
    Some(())
}

/// A table, or an entry of a list by its name or its number.
fn entry<'a>(at: &'a mut Value, step: &str) -> Option<&'a mut Value> {
    match at {
        Value::Table(table) => table.get_mut(step),
        Value::Array(list) => {
            let named = |v: &Value| v.get("name").and_then(Value::as_str) == Some(step);
            let place = list.iter().position(named).or_else(|| step.parse().ok())?;
            list.get_mut(place)
        }
        _ => None,
    }
}

/// Gain of a position loop, 1/s; of a platform by its name, for its three legs.
const GAIN: &str = "position_gain_1_s";

type Limit = fn(&mut Joint) -> &mut Option<f64>;

/// Keys of limits, whether they are for a rotary joint, and where they act.
const LIMITS: [(&str, bool, Limit); 6] = [
    ("max_velocity_deg_s", true, |j| &mut j.max_velocity),
    ("max_acceleration_deg_s2", true, |j| &mut j.max_acceleration),
    ("max_jerk_deg_s3", true, |j| &mut j.max_jerk),
    ("max_velocity_mm_min", false, |j| &mut j.max_velocity),
    ("max_acceleration_mm_s2", false, |j| &mut j.max_acceleration),
    ("max_jerk_mm_s3", false, |j| &mut j.max_jerk),
];

/// Gives a machine the limits among the values.
///
/// # Errors
/// A joint that the machine does not have, or a limit for the other kind of joint, or one that is no number
/// above zero.
pub(crate) fn limit_machine(machine: &mut Machine, values: &[(&str, ChoiceValueFile)]) -> Result<(), String> {
    for (key, value) in values {
        let Some((joint, limit)) = key.strip_prefix("machine.").and_then(|rest| rest.split_once('.')) else { continue };
        let number = match value {
            ChoiceValueFile::Whole(v) => *v as f64,
            ChoiceValueFile::Number(v) => *v,
            _ => f64::NAN,
        };
        if limit == GAIN {
            set_gain(machine, joint, number)
                .ok_or_else(|| format!("{} has no {key} = {}", machine.name, value.words()))?;
            continue;
        }
        let known = LIMITS.iter().find(|(name, ..)| *name == limit);
        let (Some(index), Some((name, rotary, of))) = (machine.joint(joint), known) else {
            return Err(format!("{} has no {key}", machine.name));
        };
        let joint = &mut machine.joints[index];
        if joint.is_rotary() != *rotary || !(number > 0.0 && number.is_finite()) {
            return Err(format!("{key} = {} is not a limit of {}", value.words(), joint.name));
        }
        let unit = if *rotary {
            rad(1.0)
        } else if name.ends_with("_min") {
            1.0 / 60.0
        } else {
            1.0
        };
        *of(joint) = Some(number * unit);
    }
    Ok(())
}

/// Gives the drive of a joint, or those of a platform's legs, another gain; none where there is no such
/// drive, or it is no gain.
fn set_gain(machine: &mut Machine, name: &str, gain: f64) -> Option<()> {
    if !(gain > 0.0 && gain.is_finite()) {
        return None;
    }
    if let Some(platform) = machine.platforms.iter_mut().find(|p| p.name == name) {
        for leg in &mut platform.legs {
            leg.drive.as_mut()?.position_gain = gain;
        }
        return Some(());
    }
    let joint = machine.joint(name)?;
    machine.joints[joint].drive.as_mut()?.position_gain = gain;
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_leads_by_names_and_numbers_and_nowhere_else() {
        let text = "[control.joint_limits.A]\nmax_velocity_deg_s = 62.4\n[[program]]\nname = \"a\"\n[[program]]\nname = \"b\"\n\
                    reschedule = { method = \"quaternion\", from = \"a\", keys = 15 }\n[mount]\ntranslation_mm = [1, 2, 3]\n";
        let new = |key: &str, value| with_values(text, &[(key, value)]);
        let put = |key: &str, value| new(key, value).expect(key);
        assert!(put("control.joint_limits.A.max_velocity_deg_s", ChoiceValueFile::Number(50.0)).contains("= 50.0"));
        assert!(put("program.b.reschedule.keys", ChoiceValueFile::Whole(9)).contains("keys = 9"));
        assert!(put("program.1.reschedule.inset_deg", ChoiceValueFile::Number(2.5)).contains("inset_deg = 2.5"));
        assert!(put("mount.translation_mm.2", ChoiceValueFile::Number(7.0)).contains("7.0"));
        for wrong in ["mount.translation_mm.3", "program.c.reschedule.keys", "program.7.name"] {
            assert!(new(wrong, ChoiceValueFile::Whole(1)).is_err(), "{wrong}");
        }
        let same = put("machine.A.max_velocity_deg_s", ChoiceValueFile::Number(1.0));
        assert_eq!(same.parse::<Table>().expect("toml"), text.parse::<Table>().expect("toml"), "not of the scene");
    }

    #[test]
    fn limits_of_the_machine_are_set_in_their_unit() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/starrag-lx-451");
        let mut machine = Machine::read(&folder).expect("library machine");
        let set = |machine: &mut Machine, key: &str, v| limit_machine(machine, &[(key, ChoiceValueFile::Number(v))]);
        set(&mut machine, "machine.A.max_velocity_deg_s", 90.0).expect("a limit");
        set(&mut machine, "machine.X.max_velocity_mm_min", 600.0).expect("a limit");
        let of = |name: &str| machine.joints[machine.joint(name).expect("a joint")].max_velocity.expect("a limit");
        assert!((of("A") - std::f64::consts::FRAC_PI_2).abs() < 1e-12 && (of("X") - 10.0).abs() < 1e-12);
        set(&mut machine, "machine.A.position_gain_1_s", 40.0).expect("a gain");
        let a = machine.joint("A").expect("a joint");
        assert_eq!(machine.joints[a].drive.as_ref().map(|d| d.position_gain), Some(40.0));
        for (key, v) in [
            ("machine.Q.max_velocity_deg_s", 9.0),
            ("machine.A.max_velocity_mm_min", 9.0),
            ("machine.A.max_jerk_deg_s3", -1.0),
            ("machine.A.max_jerk_deg_s3", f64::NAN),
            ("machine.Q.position_gain_1_s", 9.0),
            ("machine.A.position_gain_1_s", 0.0),
        ] {
            assert!(set(&mut machine, key, v).is_err(), "{key} {v}");
        }
    }

    #[test]
    fn a_range_is_met_from_end_to_end_and_values_each() {
        let choice = |text: &str| -> ChoiceFile {
            toml::from_str(&format!("name = \"n\"\nkey = \"control.k\"\nsource = \"chosen\"\nreason = \"r\"\n{text}"))
                .expect("one")
        };
        let range = choice("range = [2, 4]");
        assert_eq!(range.ends(), [ChoiceValueFile::Number(2.0), ChoiceValueFile::Number(4.0)]);
        assert_eq!(range.at(0.25), Some(ChoiceValueFile::Number(2.5)));
        let values = choice("values = [9, 15, \"all\"]");
        let at: Vec<_> = [0.0, 0.34, 0.99].iter().map(|p| values.at(*p).expect("one").words()).collect();
        assert_eq!(at, ["9", "15", "all"]);
    }
}
