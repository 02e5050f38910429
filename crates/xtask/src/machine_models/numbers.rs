//! The numbers of a `machine.toml` that a model must agree with.

use std::path::Path;

use toml::{Table, Value};

use crate::{TaskError, machine_models::solid::V3};

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct JointNumbers {
    pub(crate) name: String,
    pub(crate) parent: String,
    /// Point on the axis of a rotary joint.
    pub(crate) point: Option<V3>,
    pub(crate) direction: V3,
    /// Travel in mm of a linear joint.
    pub(crate) travel: Option<[f64; 2]>,
    /// True where it moves the workpiece, against its axis.
    pub(crate) workpiece: bool,
}

/// Kinematic numbers of a machine, mm, with all joints at zero.
#[derive(Clone, Debug)]
pub(crate) struct KinematicNumbers {
    pub(crate) name: String,
    pub(crate) joints: Vec<JointNumbers>,
    /// Joint that carries the spindle, or base.
    pub(crate) spindle_on: String,
    /// Middle of the gauge line.
    pub(crate) gauge: V3,
    /// From the tool into the spindle.
    pub(crate) spindle_direction: V3,
    /// Joint that carries the table, or base.
    pub(crate) table_on: String,
    /// Middle of the clamping surface.
    pub(crate) table: V3,
}

impl KinematicNumbers {
    /// Reads them from the text of a `machine.toml`.
    pub(crate) fn read(path: &Path, text: &str) -> Result<Self, TaskError> {
        let wrong = |what: &str| TaskError(format!("{}: {what}", path.display()));
        let content: Table = text.parse().map_err(|e| wrong(&format!("{e}")))?;
        let list = content.get("joint").and_then(Value::as_array).ok_or_else(|| wrong("no [[joint]]"))?;
        let mut joints = Vec::new();
        for joint in list {
            let word = |key: &str| joint.get(key).and_then(Value::as_str).map(str::to_owned);
            joints.push(JointNumbers {
                name: word("name").ok_or_else(|| wrong("a joint without name"))?,
                parent: word("parent").ok_or_else(|| wrong("a joint without parent"))?,
                point: joint.get("point_mm").and_then(vector),
                direction: joint.get("direction").and_then(vector).ok_or_else(|| wrong("a joint without direction"))?,
                travel: joint.get("travel_mm").and_then(vector),
                workpiece: word("carries").as_deref() == Some("workpiece"),
            });
        }
        let place = |table: &str, key: &str| content.get(table).and_then(|t| t.get(key));
        let point = |table: &str, key: &str| {
            place(table, key).and_then(vector).ok_or_else(|| wrong(&format!("no {key} in [{table}]")))
        };
        let on = |table: &str| {
            let name = place(table, "on").and_then(Value::as_str).map(str::to_owned);
            name.ok_or_else(|| wrong(&format!("no `on` in [{table}]")))
        };
        Ok(Self {
            name: content.get("name").and_then(Value::as_str).unwrap_or_default().to_owned(),
            joints,
            spindle_on: on("spindle")?,
            gauge: point("spindle", "origin_mm")?,
            spindle_direction: point("spindle", "direction")?,
            table_on: on("table")?,
            table: point("table", "point_mm")?,
        })
    }

    fn joint(&self, name: &str) -> Result<&JointNumbers, TaskError> {
        let found = self.joints.iter().find(|j| j.name == name);
        found.ok_or_else(|| TaskError(format!("{}: the model needs a joint {name}", self.name)))
    }

    /// Travel of a slide.
    pub(crate) fn travel(&self, name: &str) -> Result<[f64; 2], TaskError> {
        let travel = self.joint(name)?.travel;
        travel.ok_or_else(|| TaskError(format!("{}: the model needs travel_mm of joint {name}", self.name)))
    }

    /// Point on a rotary axis.
    pub(crate) fn point(&self, name: &str) -> Result<V3, TaskError> {
        let point = self.joint(name)?.point;
        point.ok_or_else(|| TaskError(format!("{}: the model needs point_mm of joint {name}", self.name)))
    }

    /// Direction of a joint.
    pub(crate) fn direction(&self, name: &str) -> Result<V3, TaskError> {
        Ok(self.joint(name)?.direction)
    }
}

fn vector<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let list = value.as_array()?;
    let number = |v: &Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64));
    let all: Option<Vec<f64>> = list.iter().map(number).collect();
    all?.try_into().ok()
}
