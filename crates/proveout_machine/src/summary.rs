//! A machine in one line, for lists.

use crate::{Joint, Machine, Trust};

impl Machine {
    /// Chains from the base outward, travel, and where it is from: `X Y table, Z tool; X 760, Y 460, Z 510
    /// mm; travel chosen`.
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
            (true, true) => "travel in part chosen".to_owned(),
            (true, false) => "travel chosen".to_owned(),
            (false, true) => format!("travel from {}", self.travel_sources().join(", ")),
            (false, false) => "travel without a source".to_owned(),
        };
        format!("{}; {}; {trust}", sides.join(", "), travel.join(", "))
    }

    /// Why a travel is to be doubted, as the end of a sentence; empty where it is published.
    pub fn doubt_of_travel(&self, joint: &Joint) -> &'static str {
        if self.travel_is_chosen(joint) == Some(true) {
            " (this travel is chosen in the machine file, not published)"
        } else {
            ""
        }
    }

    /// Whether the travel of a joint was chosen (`Some(true)`), has a source (`Some(false)`), or neither is
    /// said.
    pub fn travel_is_chosen(&self, joint: &Joint) -> Option<bool> {
        self.travel_note(joint).map(|t| t.chosen)
    }

    fn travel_note(&self, joint: &Joint) -> Option<&Trust> {
        let own = ["travel_mm", "travel_deg", "endless"].map(|key| format!("joint.{}.{key}", joint.name));
        let all = format!("joint.{}.*", joint.name);
        self.trust.iter().find(|t| own.contains(&t.key)).or_else(|| self.trust.iter().find(|t| t.key == all))
    }

    /// Where the travel of the joints is from, each source once and as short as it can be named.
    fn travel_sources(&self) -> Vec<&str> {
        let mut all = Vec::new();
        for note in self.joints.iter().filter_map(|j| self.travel_note(j)).filter(|t| !t.chosen) {
            let name = short_source(&note.note);
            if !all.contains(&name) {
                all.push(name);
            }
        }
        all
    }
}

/// A source without its page, and without the value that it gives: `length 600 mm: Li et al. 2022, Table 1`
/// is `Li et al. 2022`.
fn short_source(note: &str) -> &str {
    let source = match note.split_once(": ") {
        Some((value, rest)) if value.starts_with("length ") => rest,
        _ => note,
    };
    source.split([',', ':', ';', '(']).next().unwrap_or(source).trim()
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
        let source = |name: &str| read(name).in_one_line().rsplit("; ").next().map(str::to_owned);
        assert_eq!(source("starrag-lx-451").as_deref(), Some("travel from Li et al. 2022"));
        assert_eq!(source("linuxcnc-xyzac-trt").as_deref(), Some("travel from LinuxCNC"));
        assert!(spinner.contains("B C table") && spinner.contains("tool; ") && spinner.contains('\u{b0}'), "{spinner}");
    }
}
