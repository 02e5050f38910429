//! Keys that had another name before: one table, read by the errors of old keys and by [`crate::migrate()`].

/// The kind of an input file in TOML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputFileKind {
    /// A scene.
    Scene,
    /// A machine.
    Machine,
    /// A tool library.
    Tools,
    /// A control file.
    Control,
    /// A job of several setups.
    Job,
    /// A sweep.
    Sweep,
}

impl InputFileKind {
    /// The kind in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Machine => "machine",
            Self::Tools => "tool library",
            Self::Control => "control file",
            Self::Job => "job",
            Self::Sweep => "sweep",
        }
    }

    /// The kind of a file with these keys at its top; none where they are those of no such file.
    pub(crate) fn of_keys(keys: &[&str]) -> Option<Self> {
        let has = |word: &str| keys.contains(&word);
        let any = |words: &[&str]| words.iter().any(|word| has(word));
        if any(&["stock", "resolution_mm", "mount", "fixture", "work_offsets"]) || has("machine") && has("tools") {
            Some(Self::Scene)
        } else if any(&["dialect", "inherits", "words"]) {
            Some(Self::Control)
        } else if any(&["joint", "spindle"]) {
            Some(Self::Machine)
        } else if any(&["vary", "shards"]) {
            Some(Self::Sweep)
        } else if has("setup") {
            Some(Self::Job)
        } else if has("tool") {
            Some(Self::Tools)
        } else {
            None
        }
    }
}

/// Stands for any name in the path of a [`RenamedKey`].
pub(crate) const ANY: &str = "*";

/// A key with a new name.
pub(crate) struct RenamedKey {
    pub(crate) kind: InputFileKind,
    /// Tables above the key; a list of tables counts as one.
    pub(crate) tables: &'static [&'static str],
    pub(crate) old: &'static str,
    pub(crate) new: &'static str,
}

const fn renamed(
    kind: InputFileKind,
    tables: &'static [&'static str],
    old: &'static str,
    new: &'static str,
) -> RenamedKey {
    RenamedKey { kind, tables, old, new }
}

/// All keys with a new name.
pub(crate) const RENAMED: [RenamedKey; 14] = {
    use InputFileKind::{Scene, Tools};
    [
        renamed(Scene, &[], "limits", "run_limits"),
        renamed(Scene, &["mount"], "chosen", "assumed"),
        renamed(Scene, &["program", "mount"], "chosen", "assumed"),
        renamed(Scene, &["stock", "place"], "chosen", "assumed"),
        renamed(Scene, &["part"], "judged", "judged_box"),
        renamed(Scene, &["surface"], "phases", "random_phases"),
        renamed(Scene, &["compare"], "run_ends_s", "trimmed_ends_s"),
        renamed(Scene, &["compare"], "shown_s", "plot_window_s"),
        renamed(Scene, &["plan", ANY], "timed_by", "feed_reference"),
        renamed(Scene, &["plan", ANY], "below_mm", "beyond_end_mm"),
        renamed(Scene, &["program", "reschedule"], "cap_deg", "max_key_lean_deg"),
        renamed(Scene, &["program", "reschedule"], "measured_part", "measured_ratio"),
        renamed(Scene, &["program", "reschedule"], "time_given_up_percent", "max_time_loss_percent"),
        renamed(Tools, &["tool"], "gauge_length_is", "gauge_length_source"),
    ]
};

impl RenamedKey {
    /// The new name of a key of this name; lengths in inch keep their unit.
    fn new_name(&self, key: &str) -> Option<String> {
        if key == self.old {
            return Some(self.new.to_owned());
        }
        let (old, new) = (self.old.strip_suffix("_mm")?, self.new.strip_suffix("_mm")?);
        (key.strip_suffix("_inch")? == old).then(|| format!("{new}_inch"))
    }

    fn is_below(&self, tables: &[String]) -> bool {
        let same = |(own, there): (&&str, &String)| *own == ANY || *own == there;
        self.tables.len() == tables.len() && self.tables.iter().zip(tables).all(same)
    }

    /// The step of a dotted key that would be this key.
    fn place_in(&self, steps: &[&str]) -> Option<usize> {
        let mut at = 0;
        for table in self.tables {
            let step = steps.get(at)?;
            if *table != ANY && table != step {
                return None;
            }
            at += if *table == "program" { 2 } else { 1 };
        }
        Some(at)
    }
}

/// The new name of a key below these tables.
pub(crate) fn new_name(kind: InputFileKind, tables: &[String], key: &str) -> Option<String> {
    RENAMED.iter().filter(|r| r.kind == kind && r.is_below(tables)).find_map(|r| r.new_name(key))
}

/// The new name of an unknown key, of the names that are known where it is.
///
/// ```
/// assert_eq!(proveout_input::renamed_key("limits", &["name", "run_limits"]), Some("run_limits"));
/// assert_eq!(proveout_input::renamed_key("limits", &["name"]), None);
/// ```
pub fn renamed_key(key: &str, known: &[&str]) -> Option<&'static str> {
    RENAMED.iter().find(|r| r.old == key && known.contains(&r.new)).map(|r| r.new)
}

/// A dotted key of a scene, as `--set` and sweeps take it, with new names; none where nothing changes. The
/// name of a program follows `program`; keys of the tool library are below `tools`.
pub(crate) fn new_dotted_key(key: &str) -> Option<String> {
    let mut steps: Vec<&str> = key.split('.').collect();
    let in_library = steps.len() > 1 && steps[0] == "tools";
    for rename in &RENAMED {
        let at = match rename.kind {
            InputFileKind::Tools if in_library => steps.len().checked_sub(1),
            InputFileKind::Scene if !in_library => rename.place_in(&steps),
            _ => None,
        };
        if let Some(step) = at.and_then(|at| steps.get_mut(at)).filter(|step| **step == rename.old) {
            *step = rename.new;
            return Some(steps.join("."));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_new_name_is_an_old_one() {
        for a in &RENAMED {
            assert!(RENAMED.iter().all(|b| a.kind != b.kind || a.new != b.old), "{}", a.new);
            // A unit stays.
            let unit =
                |key: &str| key.rsplit('_').next().map(str::to_owned).filter(|u| ["mm", "deg", "s"].contains(&&**u));
            assert_eq!(unit(a.old), unit(a.new), "{}", a.old);
        }
    }

    #[test]
    fn dotted_keys_of_sweeps_and_choices_follow() {
        for (old, new) in [
            ("limits.blocks", Some("run_limits.blocks")),
            ("compare.run_ends_s", Some("compare.trimmed_ends_s")),
            ("program.a.reschedule.cap_deg", Some("program.a.reschedule.max_key_lean_deg")),
            ("program.0.mount.chosen", Some("program.0.mount.assumed")),
            ("plan.flank.below_mm", Some("plan.flank.beyond_end_mm")),
            ("tools.BALL.gauge_length_is", Some("tools.BALL.gauge_length_source")),
            ("program.limits.file", None),
            ("control.limits", None),
            ("machine.X.limits", None),
            ("resolution_mm", None),
            ("", None),
            ("program", None),
        ] {
            assert_eq!(new_dotted_key(old).as_deref(), new, "{old}");
        }
    }

    #[test]
    fn a_file_is_of_the_kind_that_its_keys_say() {
        let of = InputFileKind::of_keys;
        assert_eq!(of(&["name", "stock", "limits"]), Some(InputFileKind::Scene));
        assert_eq!(of(&["machine", "tools"]), Some(InputFileKind::Scene));
        assert_eq!(of(&["name", "joint", "control"]), Some(InputFileKind::Machine));
        assert_eq!(of(&["inherits", "limits"]), Some(InputFileKind::Control));
        assert_eq!(of(&["scene", "method", "vary"]), Some(InputFileKind::Sweep));
        assert_eq!(of(&["name", "setup"]), Some(InputFileKind::Job));
        assert_eq!(of(&["description", "tool"]), Some(InputFileKind::Tools));
        assert_eq!(of(&["run"]), None);
    }
}
