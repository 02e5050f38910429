//! Axes that are zero at home.
//!
//! Most controls read zero where the machine is referenced: `G53 Z0`, `SUPA Z0` and `M91` send Z there. A
//! file whose axes read the place of the gauge line over the table says so with one key, `zero = "home"`, and
//! its numbers stay as they are:
//!
//! ```text
//!   q = value of the file,  h = home of the joint,  q' = q - h        what control and programs count
//! ```
//!
//! With all joints at q' = 0 the slides are at home, so everything that a slide carries is described where
//! it is then: moved by the sum of `sense h direction` over the slides below it. A turn about a line that
//! is moved with it is the same turn, whatever it carries: T(s) R T(-s), so the machine moves as before.
//! All of it is then moved back by the part of the table, which leaves places on the table, including the
//! mounting of a setup, unchanged.

use proveout_geom::Vector;

use crate::{Attachment, Machine};

impl Machine {
    /// The machine with X, Y and Z zero at home; the places of the table stay.
    ///
    /// # Errors
    /// What keeps it from being one: a slide among X, Y and Z without a stated home, a platform, or geometric
    /// errors, which count positions.
    pub(crate) fn zero_at_home(mut self) -> Result<Self, String> {
        if !self.platforms.is_empty() {
            return Err("a platform moves the tool: its joints have no zero of their own".into());
        }
        if self.errors != crate::GeometricErrors::default() {
            return Err("geometric errors count positions of the file".into());
        }
        let slides: Vec<usize> = ['X', 'Y', 'Z'].into_iter().filter_map(|l| self.joint_for_letter(l)).collect();
        let slides: Vec<usize> = slides.into_iter().filter(|&j| !self.joints[j].is_rotary()).collect();
        if let Some(&j) = slides.iter().find(|&&j| !self.joints[j].home_stated) {
            return Err(format!("joint {} has no home_mm", self.joints[j].name));
        }
        // A joint may be listed before the one that carries it.
        let own = |j: usize| {
            let joint = &self.joints[j];
            if slides.contains(&j) { joint.direction * (joint.sense * joint.home) } else { Vector::zeros() }
        };
        let below = |mut at: Option<usize>| {
            let mut sum = Vector::zeros();
            while let Some(j) = at {
                sum += own(j);
                at = self.joints[j].parent;
            }
            sum
        };
        let of = |attached: Attachment| match attached {
            Attachment::Base => Vector::zeros(),
            Attachment::Joint(j) => below(Some(j)),
        };
        let table = of(self.table.attached_to);
        let moved: Vec<Vector> = self.joints.iter().map(|j| below(j.parent) - table).collect();
        let spindle = of(self.spindle.attached_to) - table;
        let bodies: Vec<Vector> = self.bodies.iter().map(|b| of(b.attached_to) - table).collect();
        for (joint, shift) in self.joints.iter_mut().zip(&moved) {
            if joint.is_rotary() {
                joint.point += shift;
            }
        }
        self.spindle.gauge_pose.translation += spindle;
        for (body, shift) in self.bodies.iter_mut().zip(&bodies) {
            body.mesh.positions.iter_mut().for_each(|p| *p += shift);
            if let Some(mass) = &mut body.mass {
                mass.center += shift;
            }
        }
        for j in slides {
            let joint = &mut self.joints[j];
            let home = joint.home;
            joint.travel = joint.travel.map(|t| t.map(|v| v - home));
            joint.tool_change = joint.tool_change.map(|v| v - home);
            joint.home = 0.0;
            let change = &mut self.control.tool_change_position[j];
            *change = change.map(|v| v - home);
        }
        Ok(self.recompiled())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::JointValues;

    fn library(name: &str) -> (std::path::PathBuf, String) {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name).join("machine.toml");
        let text = std::fs::read_to_string(&file).expect("there");
        (file, text)
    }

    fn at_home(name: &str) -> (Machine, Machine) {
        let (file, text) = library(name);
        let before = Machine::from_text(&file, &text).expect("library machine");
        let after = Machine::from_text(&file, &format!("zero = \"home\"\n{text}")).expect("zero at home");
        (before, after)
    }

    /// Tip, table, bodies and points of every machine of the library stay where they were when positions
    /// count from home.
    #[test]
    fn nothing_moves_but_the_numbers() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
        let mut seen = 0;
        for entry in std::fs::read_dir(folder).expect("the library") {
            let path = entry.expect("an entry").path();
            let Ok(text) = std::fs::read_to_string(path.join("machine.toml")) else { continue };
            let before = Machine::read(&path).expect("library machine");
            let file = path.join("machine.toml");
            let Ok(after) = Machine::from_text(&file, &format!("zero = \"home\"\n{text}")) else {
                assert!(
                    !before.platforms.is_empty()
                        || ['X', 'Y', 'Z']
                            .iter()
                            .filter_map(|l| before.joint_for_letter(*l))
                            .any(|j| !before.joints[j].home_stated),
                    "{} is refused",
                    path.display()
                );
                continue;
            };
            seen += 1;
            let slides: Vec<usize> = ['X', 'Y', 'Z']
                .iter()
                .filter_map(|l| before.joint_for_letter(*l))
                .filter(|&j| !before.joints[j].is_rotary())
                .collect();
            let mut state = 0x1234_5678_9abc_def1_u64;
            for _ in 0..20 {
                let mut q = JointValues::ZERO;
                for (j, joint) in before.joints.iter().enumerate() {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    let share = (state >> 33) as f64 / f64::from(1_u32 << 31);
                    let [low, high] = joint.travel.unwrap_or([-3.0, 3.0]);
                    q[j] = low + (high - low) * share;
                }
                let mut from_home = q;
                for &j in &slides {
                    from_home[j] -= before.joints[j].home;
                }
                let [a, b] = [before.forward(&q, 80.0), after.forward(&from_home, 80.0)];
                // Sums of lengths of some meters in double precision.
                assert!(
                    (a.tip - b.tip).norm() < 1e-8 && (a.axis - b.axis).norm() < 1e-12,
                    "{}: {a:?} {b:?}",
                    path.display()
                );
                // Bodies as seen from the table.
                for i in 0..before.bodies.len() {
                    let seen = |m: &Machine, q: &JointValues| {
                        let p = m.bodies[i].mesh.positions[0];
                        m.machine_from_table(q).inverse().point(&m.body_pose(i, q).point(&p))
                    };
                    let apart = (seen(&before, &q) - seen(&after, &from_home)).norm();
                    assert!(apart < 1e-8, "{}: {} is {apart} mm off", path.display(), before.bodies[i].name);
                }
            }
            assert_eq!(before.table.point, after.table.point, "{}: a setup stays where it is", path.display());
            for &j in &slides {
                assert_eq!(after.joints[j].home, 0.0);
                if let (Some([a, b]), Some([c, d])) = (before.joints[j].travel, after.joints[j].travel) {
                    assert!(((b - a) - (d - c)).abs() < 1e-9);
                }
            }
        }
        assert!(seen >= 20, "{seen} machines");
    }

    #[test]
    fn the_gantry_is_that_of_the_library_with_its_zero_at_home() {
        let (_, after) = at_home("bc-trunnion");
        let (file, text) = library("bc-trunnion-home-zero");
        let named = Machine::from_text(&file, &text).expect("library machine");
        for (own, other) in after.joints.iter().zip(&named.joints) {
            assert_eq!(
                (own.travel, own.home, own.tool_change),
                (other.travel, other.home, other.tool_change),
                "{}",
                own.name
            );
        }
        assert_eq!(after.spindle.gauge_pose.translation, named.spindle.gauge_pose.translation);
        assert_eq!(after.program_zero(), named.program_zero());
    }

    #[test]
    fn what_has_no_home_is_refused_by_name() {
        let (file, text) = library("three-axis-mill");
        let without = text.replacen("home_mm", "#home_mm", 1);
        let fault = Machine::from_text(&file, &format!("zero = \"home\"\n{without}")).expect_err("refused").to_string();
        assert!(fault.contains("has no home_mm") && fault.contains(":1:"), "{fault}");
    }
}
