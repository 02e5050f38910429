use crate::{JointKind, Machine};

/// A limit that the machine file does not state; the gate that needs it is unchecked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingLimit {
    /// Joint, or `None` for the spindle.
    pub joint: Option<usize>,
    /// Key that would state it, `travel_mm`.
    pub key: &'static str,
}

/// Something about a machine that is not an error, yet that a user should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnosis {
    /// Stable name of the kind (`machine-missing-limit`).
    pub code: &'static str,
    /// Table or key that it is about, `joint.X.max_jerk_mm_s3`.
    pub key: String,
    /// What is so.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl Machine {
    /// Limits that nobody has stated, in the order of the joints, the spindle last.
    pub fn missing_limits(&self) -> Vec<MissingLimit> {
        let mut all = Vec::new();
        for (j, joint) in self.joints.iter().enumerate() {
            let keys = match joint.kind {
                JointKind::Linear => ["travel_mm", "max_velocity_mm_min", "max_acceleration_mm_s2", "max_jerk_mm_s3"],
                JointKind::Rotary => ["travel_deg", "max_velocity_deg_s", "max_acceleration_deg_s2", "max_jerk_deg_s3"],
            };
            let stated = [
                joint.travel.is_some() || joint.endless,
                joint.max_velocity.is_some(),
                joint.max_acceleration.is_some(),
                joint.max_jerk.is_some(),
            ];
            let missing = keys.into_iter().zip(stated).filter(|(_, stated)| !stated && !joint.held);
            all.extend(missing.map(|(key, _)| MissingLimit { joint: Some(j), key }));
        }
        if self.spindle.max_speed_rpm.is_none() {
            all.push(MissingLimit { joint: None, key: "max_speed_rpm" });
        }
        all
    }

    /// What `proveout check` tells about a machine that could be read: missing limits, numbers without a note on their
    /// source, model nodes without a body, motion that the joints cannot make.
    pub fn diagnose(&self) -> Vec<Diagnosis> {
        let mut all = Vec::new();
        for missing in self.missing_limits() {
            let table =
                missing.joint.map_or_else(|| "spindle".to_owned(), |j| format!("joint.{}", self.joints[j].name));
            all.push(Diagnosis {
                code: "machine-missing-limit",
                key: format!("{table}.{}", missing.key),
                message: format!("{} of {table} is not stated: the gate that needs it stays unchecked", missing.key),
                remedy: format!("add {} to this table", missing.key),
            });
        }
        for node in &self.unused_nodes {
            all.push(Diagnosis {
                code: "machine-model-node-unused",
                key: "model".to_owned(),
                message: format!("node {node:?} of the model has a mesh and belongs to no body"),
                remedy: "bind it with a [[body]] that names the node, or take it out of the model".to_owned(),
            });
        }
        if self.linear_joints().len() < 3 {
            all.push(Diagnosis {
                code: "machine-few-linear-joints",
                key: "joint".to_owned(),
                message: format!("{} linear joints cannot bring the tip everywhere", self.linear_joints().len()),
                remedy: "add the missing slides, if the machine has them".to_owned(),
            });
        }
        for joint in self.joints.iter().filter(|j| j.held) {
            all.push(Diagnosis {
                code: "machine-held-joint",
                key: format!("joint.{}", joint.name),
                message: format!("joint {} is held and does not take part in inverse kinematics", joint.name),
                remedy: "leave out held = true if programs move it and the pose determines it".to_owned(),
            });
        }
        let noted = |table: &str| self.trust.iter().any(|t| t.key.starts_with(&format!("{table}.")));
        let mut tables: Vec<String> = ["spindle", "table", "control"].map(str::to_owned).into();
        tables.extend(self.joints.iter().map(|j| format!("joint.{}", j.name)));
        for table in tables.into_iter().filter(|t| !noted(t)) {
            all.push(Diagnosis {
                code: "machine-no-source",
                message: format!("no number of {table} has a note on where it comes from"),
                remedy: "add a source or chosen table beside the numbers".to_owned(),
                key: table,
            });
        }
        all
    }
}
