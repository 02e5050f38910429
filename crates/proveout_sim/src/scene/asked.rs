//! What a scene states of what it does not have: workholding, a design, gates that it does not ask.
//!
//! A gate may be left out of the question only where no tolerance and no design asks it; a statement that
//! contradicts the rest of the scene is refused by name.

use proveout_input::nearest;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::{
    scene::{SceneFile, tolerance::SurfaceKey},
    verdict::gate::Gate,
};

/// There is none, and the scene says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NoneFile {
    /// There is none.
    None,
}

/// Which gates are asked.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GatesFile {
    /// Gates that are not asked: `surface` where the scene has no tolerance of the surface (also when this is
    /// left out; with an empty list the gate stays unchecked), `gouge` and `excess` with `design = "none"`. A
    /// gate that a tolerance or a design asks is refused here.
    #[schemars(with = "Option<Vec<String>>")]
    pub not_asked: Option<Vec<Spanned<String>>>,
}

impl SceneFile {
    /// Why a gate is not asked; none where it is.
    pub(crate) fn not_asked(&self, gate: Gate) -> Option<String> {
        let listed =
            || self.gates.not_asked.as_ref().is_none_or(|list| list.iter().any(|g| g.get_ref() == gate.name()));
        match gate {
            Gate::Surface if self.asks_surface() => None,
            Gate::Surface => listed().then(|| {
                let keys = SurfaceKey::ALL.map(SurfaceKey::word).join(", ");
                format!("the scene has no tolerance of the surface ({keys})")
            }),
            Gate::Gouge => self.design.map(|_| "the scene states design = \"none\"".to_owned()),
            Gate::Excess if self.inspect.is_empty() => {
                self.design.map(|_| "the scene states design = \"none\"".to_owned())
            }
            _ => None,
        }
    }

    pub(crate) fn asks_surface(&self) -> bool {
        SurfaceKey::ALL.into_iter().any(|key| self.tolerances.asks(key))
    }

    /// What holds the part, in words; none where the scene says nothing of it.
    pub fn workholding_in_words(&self) -> Option<String> {
        if self.workholding.is_some() {
            let reason = self.workholding_reason.as_deref().unwrap_or_default().trim();
            return Some(format!("none, as the scene states: {reason}"));
        }
        let names: Vec<&str> = self.fixture.iter().map(|f| f.name.as_str()).collect();
        (!names.is_empty()).then(|| names.join(", "))
    }
}

/// What is wrong with these statements: offset in the text of the scene, message and help.
pub(crate) fn fault(text: &str, file: &SceneFile) -> Option<(usize, String, String)> {
    let at = |key: &str| {
        text.lines()
            .scan(0, |at, line| {
                let here = *at;
                *at += line.len() + 1;
                Some((here, line))
            })
            .find(|(_, line)| {
                line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='))
            })
            .map_or(0, |(at, _)| at)
    };
    let refused = |at: usize, message: &str, help: &str| Some((at, message.to_owned(), help.to_owned()));
    let reason = file.workholding_reason.as_deref().map(str::trim);
    match (file.workholding, reason) {
        (None, Some(_)) => {
            let message = "workholding_reason is given, but not workholding = \"none\"";
            return refused(at("workholding_reason"), message, "add workholding = \"none\", or remove the reason");
        }
        (Some(_), None | Some("")) => {
            let message = "workholding = \"none\" has no reason";
            let help = "add workholding_reason = \"...\" in the next line: gate, report and setup sheet show it";
            return refused(at("workholding"), message, help);
        }
        (Some(_), Some(_)) if !file.fixture.is_empty() => {
            let message = format!("workholding = \"none\", and the scene has {} [[fixture]]", file.fixture.len());
            return refused(at("workholding"), &message, "remove one of the two");
        }
        _ => {}
    }
    if file.design.is_some() {
        if file.part.is_some() {
            return refused(
                at("design"),
                "design = \"none\", and the scene has a design as [part]",
                "remove one of the two",
            );
        }
        let table: Option<toml::Table> = toml::from_str(text).ok();
        let stated = |key: &str| table.as_ref().and_then(|t| t.get("tolerances")?.get(key)).is_some();
        if let Some(key) = ["gouge_mm", "excess_mm"].into_iter().find(|key| stated(key)) {
            let message = format!("{key} is a tolerance of the design, but the scene states design = \"none\"");
            return refused(at(key), &message, "give the design as [part], or remove the tolerance");
        }
    }
    file.gates.not_asked.iter().flatten().find_map(|gate| {
        let (name, at) = (gate.get_ref().as_str(), gate.span().start);
        let (message, help) = match Gate::named(name) {
            Some(Gate::Surface) => {
                let key = SurfaceKey::ALL.into_iter().find(|key| file.tolerances.asks(*key))?;
                (
                    format!("the gate surface is asked: the scene has the tolerance {}", key.word()),
                    "remove the tolerance, or the gate from not_asked".to_owned(),
                )
            }
            Some(Gate::Gouge | Gate::Excess) if file.part.is_some() => (
                format!("the gate {name} is asked: the scene has a design as [part]"),
                "remove it from not_asked".to_owned(),
            ),
            Some(Gate::Gouge | Gate::Excess) if file.design.is_none() => (
                format!("the gate {name} needs a statement about the design"),
                "write design = \"none\" at the head of the scene: gouge and excess are then not asked".to_owned(),
            ),
            Some(Gate::Excess) if !file.inspect.is_empty() => (
                "the gate excess is asked: the scene has features under [[inspect]]".to_owned(),
                "remove it from not_asked".to_owned(),
            ),
            Some(Gate::Gouge | Gate::Excess) => return None,
            Some(_) => (
                format!("the gate {name} is asked in every scene"),
                "only surface, gouge and excess are allowed in not_asked".to_owned(),
            ),
            None => {
                let near = nearest(name, Gate::NAMES).map_or_else(String::new, |n| format!("; did you mean {n}?"));
                (format!("{name:?} is not a gate{near}"), "write surface, gouge or excess".to_owned())
            }
        };
        Some((at, message, help))
    })
}

#[cfg(test)]
mod tests {
    use crate::{scene::Scene, verdict::gate::Gate};

    fn scene(head: &str, more: &str) -> Result<Scene, String> {
        let text = format!(
            "name = \"part\"\n{head}machine = \"m\"\ntools = \"t\"\nresolution_mm = 1\n[stock]\nbox = {{ min_mm = [0, 0, 0], max_mm = [9, 9, 9] }}\n\
             {more}[[program]]\nname = \"a\"\nfile = \"a.nc\"\n"
        );
        Scene::of_text("scene.toml".into(), &text).map_err(|e| e.to_string())
    }

    const REASON: &str = "workholding_reason = \"glued\"\n";
    const FIXTURE: &str = "[[fixture]]\nname = \"jaw\"\nbox = { min_mm = [0, 0, -9], max_mm = [9, 9, 0] }\n";

    #[test]
    fn statements_are_read_and_decide_which_gates_are_asked() {
        let plain = scene("", "").expect("reads").file;
        assert!(plain.not_asked(Gate::Surface).is_some() && plain.not_asked(Gate::Gouge).is_none());
        assert_eq!(plain.workholding_in_words(), None);
        let asked = scene("", "[gates]\nnot_asked = []\n").expect("reads").file;
        assert!(asked.not_asked(Gate::Surface).is_none());
        let tolerance = scene("", "[tolerances]\nra_um = 1.6\n").expect("reads").file;
        assert!(tolerance.not_asked(Gate::Surface).is_none());
        let none = scene(&format!("design = \"none\"\nworkholding = \"none\"\n{REASON}"), "").expect("reads").file;
        assert!([Gate::Gouge, Gate::Excess, Gate::Surface].into_iter().all(|gate| none.not_asked(gate).is_some()));
        assert_eq!(none.workholding_in_words().as_deref(), Some("none, as the scene states: glued"));
        let inspected = "[[inspect]]\nname = \"h\"\nnominal_mm = 1\ntolerance_mm = 0.1\nkind = \"plane\"\n";
        if let Ok(scene) = scene("design = \"none\"\n", inspected) {
            assert!(scene.file.not_asked(Gate::Excess).is_none() && scene.file.not_asked(Gate::Gouge).is_some());
        }
    }

    #[test]
    fn a_statement_against_the_rest_of_the_scene_is_refused_by_name_and_place() {
        let part = "[part]\nmesh = \"p.stl\"\n";
        for (head, more, words, line) in [
            ("workholding = \"none\"\n", "", "has no reason", 2),
            ("workholding = \"none\"\nworkholding_reason = \" \"\n", "", "has no reason", 2),
            (REASON, "", "workholding_reason is given, but not", 2),
            ("workholding = \"none\"\nworkholding_reason = \"r\"\n", FIXTURE, "has 1 [[fixture]]", 2),
            ("design = \"none\"\n", part, "has a design", 2),
            ("design = \"none\"\n", "[tolerances]\ngouge_mm = 0.1\n", "gouge_mm is a tolerance", 9),
            ("design = \"none\"\n", "[tolerances]\nexcess_mm = 0.1\n", "excess_mm is a tolerance", 9),
            ("", "[tolerances]\nra_um = 1\n[gates]\nnot_asked = [\"surface\"]\n", "tolerance ra_um", 10),
            ("", "[tolerances]\nrz_um = 1\n[gates]\nnot_asked = [\"surface\"]\n", "tolerance rz_um", 10),
            ("", "[gates]\nnot_asked = [\"gouge\"]\n", "needs a statement about the design", 8),
            ("", &format!("{part}[gates]\nnot_asked = [\"excess\"]\n"), "has a design as [part]", 10),
            ("", "[gates]\nnot_asked = [\"collision\"]\n", "is asked in every scene", 8),
            ("", "[gates]\nnot_asked = [\"program\"]\n", "is asked in every scene", 8),
            ("", "[gates]\nnot_asked = [\"surfaces\"]\n", "did you mean surface?", 8),
            ("workholding = \"vise\"\n", "", "none", 2),
        ] {
            let error = scene(head, more).expect_err(words);
            assert!(error.contains(words) && error.contains(&format!("scene.toml:{line}:")), "{words}: {error}");
        }
    }
}
