use crate::{Attachment, JointKind, Machine, Platform};

/// A limit that the machine file does not state; the gate that needs it is unchecked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingLimit {
    /// Joint, or `None` for the spindle.
    pub joint: Option<usize>,
    /// Key that would state it, `travel_mm`.
    pub key: &'static str,
}

/// How much a remark weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RemarkSeverity {
    /// So it is meant, perhaps.
    Note,
    /// Something is missing or looks wrong.
    Warning,
}

/// Something about a machine that is not an error, yet that a user should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnosis {
    /// Stable name of the kind (`machine-missing-limit`).
    pub code: &'static str,
    /// How much it weighs.
    pub severity: RemarkSeverity,
    /// Line of the key in the machine file, of its table where the key is missing; 0 for a machine without a
    /// file.
    pub line: usize,
    /// Table or key that it is about, `joint.X.max_jerk_mm_s3`.
    pub key: String,
    /// What is so.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl std::fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { code, line, key, message, remedy, .. } = self;
        write!(f, "line {line}: {key}: {message}; {remedy} [{code}]")
    }
}

impl Machine {
    /// Limits that are not stated, in the order of the joints, the spindle last.
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

    /// The machine file that the lines of remarks belong to.
    pub fn file(&self) -> &std::path::Path {
        &self.places.file
    }

    fn remark(
        &self,
        severity: RemarkSeverity,
        code: &'static str,
        key: impl Into<String>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Diagnosis {
        let key = key.into();
        let line = self.places.line(&key);
        Diagnosis { code, severity, line, key, message: message.into(), remedy: remedy.into() }
    }

    /// What `proveout check` reports about a machine that could be read: missing limits, values that look
    /// like another unit, joints that cannot be reached or do nothing, model nodes without a body, numbers
    /// without a source, motion that the joints cannot make. Each has a line, key and remedy; they come in
    /// the order of the checks.
    pub fn diagnose(&self) -> Vec<Diagnosis> {
        let mut all = self.missing_limit_remarks();
        self.plausibility_remarks(&mut all);
        self.structure_remarks(&mut all);
        self.control_remarks(&mut all);
        self.source_remarks(&mut all);
        all
    }

    fn missing_limit_remarks(&self) -> Vec<Diagnosis> {
        let mut all = Vec::new();
        let mut missing = |table: &str, key: &str| {
            all.push(self.remark(
                RemarkSeverity::Warning,
                "machine-missing-limit",
                format!("{table}.{key}"),
                format!("{key} of {table} is not stated: the gate that needs it stays unchecked"),
                format!("add {key} to this table"),
            ));
        };
        for limit in self.missing_limits() {
            let table = limit.joint.map_or_else(|| "spindle".to_owned(), |j| format!("joint.{}", self.joints[j].name));
            missing(&table, limit.key);
        }
        for platform in &self.platforms {
            for leg in &platform.legs {
                let table = format!("platform.{}.leg.{}", platform.name, leg.name);
                let stated = [
                    ("travel_mm", leg.travel.is_some()),
                    ("max_velocity_mm_min", leg.max_velocity.is_some()),
                    ("max_acceleration_mm_s2", leg.max_acceleration.is_some()),
                    ("max_jerk_mm_s3", leg.max_jerk.is_some()),
                ];
                stated.iter().filter(|(_, stated)| !stated).for_each(|(key, _)| missing(&table, key));
            }
        }
        all
    }

    fn structure_remarks(&self, all: &mut Vec<Diagnosis>) {
        for node in &self.unused_nodes {
            all.push(self.remark(
                RemarkSeverity::Warning,
                "machine-model-node-unused",
                "model",
                format!("node {node:?} of the model has a mesh and belongs to no body, thus to no joint"),
                "bind it with a [[body]] that names the node and its joint, or remove it from the model",
            ));
        }
        let linear = self.linear_joints().len();
        if linear < 3 {
            let message = format!("{linear} linear joints cannot move the tip in all directions");
            let remedy = "add the missing slides, if the machine has them";
            all.push(self.remark(RemarkSeverity::Warning, "machine-few-linear-joints", "joint", message, remedy));
        } else if self.slide_volume() < FLAT_VOLUME {
            let names: Vec<&str> = self.linear_joints().iter().map(|&j| self.joints[j].name.as_str()).collect();
            let key = format!("joint.{}.direction", names.last().unwrap_or(&""));
            let message = format!("the slides {} lie in a plane at home: the tip cannot leave it", names.join(", "));
            let remedy = "correct a direction";
            all.push(self.remark(RemarkSeverity::Warning, "machine-flat-slides", key, message, remedy));
        }
        for joint in self.joints.iter().filter(|j| j.held) {
            all.push(self.remark(
                RemarkSeverity::Note,
                "machine-held-joint",
                format!("joint.{}", joint.name),
                format!("joint {} is held and does not take part in inverse kinematics", joint.name),
                "leave out held = true if programs move it and the pose determines it",
            ));
        }
        if !self.has_closed_form() {
            let names: Vec<&str> = self.rotary_joints().iter().map(|&j| self.joints[j].name.as_str()).collect();
            let key = format!("joint.{}", names.last().unwrap_or(&""));
            let message = format!(
                "the rotary joints {} leave the pose a choice: inverse kinematics is numerical",
                names.join(", ")
            );
            let remedy = "set held = true on those that the setup holds";
            all.push(self.remark(RemarkSeverity::Note, "machine-numerical-inverse", key, message, remedy));
        }
        for joint in self.joints.iter().filter(|j| !j.held) {
            let Some([low, high]) = joint.travel else { continue };
            let turns = (high - low) / std::f64::consts::TAU;
            if joint.is_rotary() && turns > 100.0 {
                // Some controls have no endless axes; such an axis is given a travel too long to be
                // reached.
                let key = format!("joint.{}.travel_deg", joint.name);
                let message = format!("{turns:.0} turns of travel");
                let remedy = "write endless = true if the joint has no end stops";
                all.push(self.remark(RemarkSeverity::Note, "machine-implausible-value", key, message, remedy));
            }
        }
        for (j, joint) in self.joints.iter().enumerate().filter(|(_, j)| !j.held) {
            let moves = self.bodies.iter().any(|b| self.moves(j, b.attached_to));
            if !self.bodies.is_empty() && !moves {
                let key = format!("joint.{}", joint.name);
                let message = format!(
                    "no body is attached to joint {}: pictures and collision checks do not show it",
                    joint.name
                );
                let remedy = "attach a [[body]] to it or to a joint beyond it";
                all.push(self.remark(RemarkSeverity::Warning, "machine-joint-without-body", key, message, remedy));
            }
        }
        for (p, platform) in self.platforms.iter().enumerate() {
            self.platform_remarks(all, p, platform);
        }
    }

    /// What programs cannot do for lack of data, or do without a check.
    fn control_remarks(&self, all: &mut Vec<Diagnosis>) {
        if self.control.kinematics.is_none() {
            let message = "the kinematics that programs may switch on are not stated: every one is taken";
            let remedy = "list them, for example kinematics = [\"tcp\", \"tilted-plane\"], or [] for none";
            all.push(self.remark(
                RemarkSeverity::Note,
                "machine-kinematics-not-stated",
                "control.kinematics",
                message,
                remedy,
            ));
        }
        for joint in self.joints.iter().filter(|j| !j.held && j.second_reference().is_none()) {
            let key = if joint.is_rotary() { "home_deg" } else { "home_mm" };
            let message = format!("joint {} states no reference point: G28 and G30 of it are refused", joint.name);
            let path = format!("joint.{}.{key}", joint.name);
            all.push(self.remark(
                RemarkSeverity::Note,
                "machine-no-reference-point",
                path,
                message,
                format!("add {key}"),
            ));
        }
    }

    /// Whether a joint moves the bodies of an attachment.
    fn moves(&self, joint: usize, attachment: Attachment) -> bool {
        let mut next = match attachment {
            Attachment::Joint(j) => Some(j),
            Attachment::Base => None,
        };
        // Chains have no loops; the count guards machines that were put together by hand.
        for _ in 0..=self.joints.len() {
            let Some(j) = next else { return false };
            if j == joint {
                return true;
            }
            next = self.joints.get(j).and_then(|j| j.parent);
        }
        false
    }

    /// Positions of a platform's joints within travel that its legs cannot take.
    fn platform_remarks(&self, all: &mut Vec<Diagnosis>, index: usize, platform: &Platform) {
        let ends = |j: usize| self.joints[j].travel.unwrap_or([self.joints[j].home; 2]);
        let mut seen = false;
        for heave in ends(platform.heave) {
            for tilt in ends(platform.tilt) {
                let mut q = self.home();
                (q[platform.heave], q[platform.tilt]) = (heave, tilt);
                let lengths = platform.leg_lengths(&q);
                for (k, leg) in platform.legs.iter().enumerate() {
                    let Some([low, high]) = leg.travel else { continue };
                    if seen || (low..=high).contains(&lengths[k]) {
                        continue;
                    }
                    seen = true;
                    let name = |j: usize| &self.joints[j].name;
                    let message = format!(
                        "{} {heave:.3} mm with {} {:.3} degrees would need {:.3} mm of leg {}: that corner of the travel is \
                         unreachable",
                        name(platform.heave),
                        name(platform.tilt),
                        tilt.to_degrees(),
                        lengths[k],
                        leg.name
                    );
                    let key = format!("platform.{}.leg.{}.travel_mm", platform.name, leg.name);
                    let remedy = "programs that go there are refused at the leg; narrow the joints' travel to hide it";
                    all.push(self.remark(RemarkSeverity::Note, "machine-platform-corner", key, message, remedy));
                }
                if platform.transmission(&q) < LEAST_TRANSMISSION {
                    let message = format!("platform {index} is near its singular pose at an end of the travel");
                    let key = format!("platform.{}", platform.name);
                    let remedy = "check radii and height, or narrow the travel";
                    all.push(self.remark(RemarkSeverity::Warning, "machine-platform-singular", key, message, remedy));
                }
            }
        }
    }

    /// Volume of the directions of the slides at home.
    fn slide_volume(&self) -> f64 {
        let jacobian = self.jacobian(&self.home(), 0.0);
        let mut columns = self.linear_joints().iter().map(|&j| jacobian.fixed_view::<3, 1>(0, j).into_owned());
        let (Some(a), Some(b), Some(c)) = (columns.next(), columns.next(), columns.next()) else { return 0.0 };
        if self.linear_joints().len() > 3 { 1.0 } else { a.cross(&b).dot(&c).abs() }
    }

    /// Values that are right as numbers and look like another unit.
    fn plausibility_remarks(&self, all: &mut Vec<Diagnosis>) {
        for joint in &self.joints {
            let mut doubt = |key: &str, message: String, remedy: &str| {
                let key = format!("joint.{}.{key}", joint.name);
                all.push(self.remark(RemarkSeverity::Warning, "machine-implausible-value", key, message, remedy));
            };
            let rotary = joint.is_rotary();
            if let Some([low, high]) = joint.travel {
                let range = high - low;
                if rotary && range <= RADIAN_RANGE_DEG.to_radians() {
                    let message = format!("the travel is {:.4} degrees in all", range.to_degrees());
                    doubt(
                        "travel_deg",
                        message,
                        "write degrees if these are radians; for a joint that does not move, write held = true",
                    );
                }
                if !rotary && !(1.0..=50_000.0).contains(&range) {
                    doubt("travel_mm", format!("the travel is {range} mm in all"), "write millimeters");
                }
            }
            let checks = if rotary { &ROTARY_CHECKS } else { &LINEAR_CHECKS };
            let values = [joint.max_velocity, joint.max_acceleration, joint.max_jerk, joint.rapid_velocity];
            for ((key, [low, high], factor, remedy), value) in checks.iter().zip(values) {
                let Some(value) = value.map(|v| v * factor) else { continue };
                if !(*low..=*high).contains(&value) {
                    let given = self.places.given(&format!("joint.{}", joint.name), key);
                    doubt(given, format!("{value} is unusual: {low} to {high} is usual"), remedy);
                }
            }
            if let (Some(v), Some(a)) = (joint.max_velocity, joint.max_acceleration)
                && !USUAL_RAMP_S.contains(&(v / a))
            {
                let key = if rotary { "max_acceleration_deg_s2" } else { "max_acceleration_mm_s2" };
                doubt(key, format!("the joint takes {} s to reach its velocity", v / a), "check both units");
            }
        }
    }

    fn source_remarks(&self, all: &mut Vec<Diagnosis>) {
        let noted = |table: &str| self.trust.iter().any(|t| t.key.starts_with(&format!("{table}.")));
        let mut tables: Vec<String> = ["spindle", "table", "control"].map(str::to_owned).into();
        tables.extend(self.joints.iter().map(|j| format!("joint.{}", j.name)));
        tables.extend(self.platforms.iter().map(|p| format!("platform.{}", p.name)));
        if !self.errors.is_zero() {
            tables.push("errors".to_owned());
        }
        if self.places.line("body_density") > 0 {
            tables.push("body_density".to_owned());
        }
        for table in tables.into_iter().filter(|t| !noted(t)) {
            let message = format!("no number of {table} has a note on where it comes from");
            let remedy = "add a source or chosen table next to the numbers";
            all.push(self.remark(RemarkSeverity::Warning, "machine-no-source", table, message, remedy));
        }
    }
}

/// A rotary travel of this or less (degrees) looks like radians: two turns are 12.6 rad, and no machine tool
/// swivels by less than 15 degrees.
const RADIAN_RANGE_DEG: f64 = 12.7;

/// Time in which an axis comes to its highest velocity, s: what is shorter or longer is a slip of a unit.
const USUAL_RAMP_S: std::ops::RangeInclusive<f64> = 1e-3..=60.0;

/// Volume of three unit directions below which slides count as lying in a plane: 0.06 degrees off.
const FLAT_VOLUME: f64 = 1e-3;

/// Transmission of a platform below which it counts as singular: a leg is then six degrees from carrying no
/// load.
const LEAST_TRANSMISSION: f64 = 0.1;

/// Key, usual range, factor from mm and radian to the key's unit, and what to check.
type Check = (&'static str, [f64; 2], f64, &'static str);

/// From slow gantries to linear-motor machines, with a factor of ten to spare.
const LINEAR_CHECKS: [Check; 4] = [
    ("max_velocity_mm_min", [100.0, 600_000.0], 60.0, "write mm/min: 30 m/min is 30_000"),
    ("max_acceleration_mm_s2", [20.0, 200_000.0], 1.0, "write mm/s²: 5 m/s² is 5_000"),
    ("max_jerk_mm_s3", [100.0, 20_000_000.0], 1.0, "write mm/s³: 100 m/s³ is 100_000"),
    ("rapid_velocity_mm_min", [100.0, 600_000.0], 60.0, "write mm/min: 30 m/min is 30_000"),
];

/// From dividing heads to torque tables, likewise; a turning spindle as C axis is at the upper end.
const ROTARY_CHECKS: [Check; 4] = [
    ("max_velocity_deg_s", [1.0, 50_000.0], 180.0 / std::f64::consts::PI, "write degrees per second: 10 rad/s is 573"),
    (
        "max_acceleration_deg_s2",
        [5.0, 200_000.0],
        180.0 / std::f64::consts::PI,
        "write degrees per s²: 10 rad/s² is 573",
    ),
    (
        "max_jerk_deg_s3",
        [50.0, 50_000_000.0],
        180.0 / std::f64::consts::PI,
        "write degrees per s³: 100 rad/s³ is 5_730",
    ),
    (
        "rapid_velocity_deg_s",
        [1.0, 50_000.0],
        180.0 / std::f64::consts::PI,
        "write degrees per second: 10 rad/s is 573",
    ),
];
