//! What the control of a machine knows and a program refers to: reference points and kinematics, for the
//! reader.

use proveout_machine::{Joint, Machine};
use proveout_nc::{AXIS_LETTERS, AxisValues, Kinematics, ReferencePoints, Settings};

/// Settings of a reader with the data of the machine that runs the program.
pub fn with_machine(settings: Settings, machine: &Machine) -> Settings {
    let name = || machine.name.clone();
    let kinematics = machine.control.kinematics.map(|listed| Kinematics {
        machine: name(),
        tcp: listed.tcp,
        tilted_plane: listed.tilted_plane,
    });
    let (mut axes, mut endless) = (0, 0);
    let [mut first, mut second, mut tool_change] = [AxisValues::NONE; 3];
    for (index, letter) in AXIS_LETTERS.into_iter().enumerate() {
        let Some(joint) = machine.joint_for_letter(letter).and_then(|j| machine.joints.get(j)).filter(|j| !j.held)
        else {
            continue;
        };
        axes |= 1 << index;
        endless |= u16::from(joint.is_rotary() && joint.travel.is_none()) << index;
        let state = |values: &mut AxisValues, point: fn(&Joint) -> Option<f64>| {
            if let Some(value) = point(joint) {
                values.put(index, value);
            }
        };
        state(&mut first, Joint::first_reference);
        state(&mut second, Joint::second_reference);
        state(&mut tool_change, |joint| joint.tool_change);
    }
    Settings {
        reference_points: Some(ReferencePoints { machine: name(), axes, endless, first, second, tool_change }),
        kinematics,
        ..settings
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn every_axis_of_the_library_has_its_reference_points_within_travel() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
        let mut seen = 0;
        for entry in std::fs::read_dir(folder).expect("machines/") {
            let path = entry.expect("entry").path();
            if !path.is_dir() {
                continue;
            }
            let machine = Machine::read(&path).unwrap_or_else(|e| panic!("{e}"));
            let settings = with_machine(Settings::default(), &machine);
            let points = settings.reference_points.expect("points");
            assert!(settings.kinematics.is_some(), "{}", path.display());
            for (index, letter) in AXIS_LETTERS.into_iter().enumerate() {
                let joint = machine.joint_for_letter(letter).map(|j| &machine.joints[j]);
                assert_eq!(points.axes >> index & 1 == 1, joint.is_some(), "{} {letter}", path.display());
                let Some(joint) = joint else { continue };
                let first = points.first.get(index).expect("first reference point");
                let second = points.second.get(index).expect("second reference point");
                assert!(joint.travel_violation(first).is_none(), "{} {letter} {first}", path.display());
                assert!(joint.travel_violation(second).is_none(), "{} {letter} {second}", path.display());
                assert_eq!((first, second), (joint.home, joint.tool_change.unwrap_or(joint.home)));
                // The source of the number is given with it.
                let key = format!("joint.{}.{}", joint.name, if joint.is_rotary() { "home_deg" } else { "home_mm" });
                let all = format!("joint.{}.*", joint.name);
                let note = machine.trust.iter().find(|t| t.key == key || t.key == all);
                assert!(
                    note.is_some_and(|t| !t.note.is_empty()),
                    "{}: {key} has neither source nor reason",
                    path.display()
                );
                seen += 1;
            }
        }
        assert!(seen >= 70, "{seen} axes");
    }
}
