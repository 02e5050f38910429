//! A machine in one line, for lists.

use crate::{Joint, Machine};

impl Machine {
    /// Chains from the base outward, travel, and whether it is published: `X Y table, Z tool; X 760, Y 460, Z 510 mm; travel chosen`.
    pub fn in_one_line(&self) -> String {
        let chain =
            |joints: &[usize]| joints.iter().map(|&j| self.joints[j].name.as_str()).collect::<Vec<_>>().join(" ");
        let (work, tool) = (chain(&self.work_chain), chain(&self.tool_chain));
        let sides: Vec<String> = [(work, "table"), (tool, "tool")]
            .into_iter()
            .filter(|(joints, _)| !joints.is_empty())
            .map(|(joints, side)| format!("{joints} {side}"))
            .collect();
        let travel: Vec<String> = self.joints.iter().map(travel).collect();
        let joints = || self.joints.iter().map(|j| self.travel_is_chosen(j));
        let trust = match (joints().any(|c| c == Some(true)), joints().any(|c| c == Some(false))) {
            (true, true) => "travel in part chosen",
            (true, false) => "travel chosen",
            (false, true) => "travel published",
            (false, false) => "travel without a source",
        };
        format!("{}; {}; {trust}", sides.join(", "), travel.join(", "))
    }

    /// Whether the travel of a joint was chosen (`Some(true)`), has a source (`Some(false)`), or neither is said.
    pub fn travel_is_chosen(&self, joint: &Joint) -> Option<bool> {
        let own = ["travel_mm", "travel_deg", "endless"].map(|key| format!("joint.{}.{key}", joint.name));
        let all = format!("joint.{}.*", joint.name);
        let noted =
            self.trust.iter().find(|t| own.contains(&t.key)).or_else(|| self.trust.iter().find(|t| t.key == all));
        noted.map(|t| t.chosen)
    }
}

fn travel(joint: &Joint) -> String {
    match joint.travel {
        _ if joint.held => format!("{} held", joint.name),
        _ if joint.endless => format!("{} endless", joint.name),
        Some([low, high]) => {
            let [low, high] = [low, high].map(|v| joint.kind.in_unit(v));
            if joint.is_rotary() {
                format!("{} {low:.0} to {high:.0}\u{b0}", joint.name)
            } else {
                format!("{} {:.0}", joint.name, high - low)
            }
        }
        None => format!("{} not stated", joint.name),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn lines_tell_chains_travel_and_trust() {
        let read = |name: &str| {
            Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name))
                .expect("library machine")
        };
        assert_eq!(read("three-axis-mill").in_one_line(), "Y X table, Z tool; Y 460, X 760, Z 510; travel chosen");
        let spinner = read("spinner-u5-620").in_one_line();
        assert!(spinner.contains("B C table") && spinner.contains("tool; ") && spinner.contains('\u{b0}'), "{spinner}");
    }
}
