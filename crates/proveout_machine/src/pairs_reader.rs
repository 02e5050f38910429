//! Reads `[[pairs]]`, and refuses rules that change nothing.

use proveout_input::{Document, Step::Item, Step::Key};

use crate::{
    Attachment, MachineBody, PairCare, PairRule, SpindleData, TOOL_PARTS, description::PairFile, reading::Checked,
};

/// Reads the rules; one that would change nothing is refused.
pub(crate) fn read_pairs(
    source: &Document<'_>,
    content: &[PairFile],
    bodies: &[MachineBody],
    spindle: &SpindleData,
) -> Checked<Vec<PairRule>> {
    let mut rules: Vec<PairRule> = Vec::new();
    for (i, pair) in content.iter().enumerate() {
        let at = |key| [Key("pairs"), Item(i), Key(key)];
        let fault = |key, message: String, remedy: &str| Err(source.error("machine-pair", &at(key), message, remedy));
        let [one, other] = &pair.bodies;
        let known = |name: &String| -> Checked<Attachment> {
            let body = bodies.iter().find(|b| b.name == *name);
            let part = TOOL_PARTS.contains(&name.as_str());
            match body {
                Some(_) if part => {
                    let message = format!("{name:?} is a body and the {name} of a tool");
                    Err(source.error("machine-pair", &at("bodies"), message, "give the body another name"))
                }
                Some(body) if !body.check => {
                    let message = format!("{name:?} is not checked at all: its `check` is false");
                    Err(source.error("machine-pair", &at("bodies"), message, "check the body, or leave the pair out"))
                }
                Some(body) => Ok(body.attached_to),
                None if part => Ok(spindle.attached_to),
                None => {
                    let names: Vec<&str> = bodies.iter().map(|b| b.name.as_str()).chain(TOOL_PARTS).collect();
                    let remedy = format!("write two of {}", names.join(", "));
                    Err(source.error("machine-pair", &at("bodies"), format!("there is no body {name:?}"), remedy))
                }
            }
        };
        let attached = [known(one)?, known(other)?];
        if attached[0] == attached[1] {
            let message =
                format!("{one:?} and {other:?} are attached to the same joint and never move against each other");
            return fault("bodies", message, "leave the pair out");
        }
        if rules.iter().any(|r| r.is_of(one, other)) {
            return fault("bodies", format!("{one:?} and {other:?} have a rule already"), "keep one of the two");
        }
        let reason = pair.reason.as_deref().unwrap_or_default().trim().to_owned();
        let care = match (pair.near_miss_mm, pair.check) {
            (Some(distance), None) if distance >= 0.0 && distance.is_finite() => PairCare::NearMiss(distance),
            (Some(distance), None) => {
                return fault("near_miss_mm", format!("{distance} mm is not a valid distance"), "write zero or more");
            }
            (None, Some(false)) if reason.is_empty() => {
                return fault("check", "two bodies are left unchecked without a reason".into(), "say why in `reason`");
            }
            (None, Some(false)) => PairCare::Unchecked,
            (None, Some(true)) => {
                return fault("check", "every pair is checked without a rule".into(), "leave the pair out");
            }
            (Some(_), Some(_)) => {
                return fault("check", "a distance, and whether they are checked".into(), "write one of the two");
            }
            (None, None) => {
                let remedy = "write near_miss_mm, or check = false with a reason";
                return fault("bodies", format!("no rule is given for {one:?} and {other:?}"), remedy);
            }
        };
        rules.push(PairRule { bodies: pair.bodies.clone(), care, reason });
    }
    Ok(rules)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::Machine;

    fn machine(pairs: &str) -> Result<Machine, String> {
        let body = |name: &str, on: &str, check: bool| {
            format!(
                "[[body]]\nname = {name:?}\nrole = \"part\"\nattached_to = {on:?}\ncheck = {check}\n\
                 box = [{{ min_mm = [0, 0, 0], max_mm = [1, 1, 1] }}]\n"
            )
        };
        let text = [
            "name = \"m\"\nspindle = { on = \"Z\", origin_mm = [0, 0, 0], direction = [0, 0, 1], start_time_s = 1 }\n\
             table = { on = \"base\", point_mm = [0, 0, 0], normal = [0, 0, 1] }\n\
             control = { cycle_time_ms = 1, block_time_ms = 0, tool_change_time_s = 5, rapid_mode = \"straight\", \
             default_tolerance_mm = 0.01 }\n[[joint]]\nname = \"Z\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"base\"\n\
             direction = [0, 0, 1]\n"
                .to_owned(),
            body("bed", "base", true),
            body("rail", "base", true),
            body("head", "Z", true),
            body("hose", "Z", false),
            pairs.to_owned(),
        ]
        .concat();
        Machine::from_text(Path::new("machine.toml"), &text).map_err(|e| e.to_string())
    }

    #[test]
    fn rules_are_read_as_they_stand() {
        let text = "[[pairs]]\nbodies = [\"head\", \"bed\"]\nnear_miss_mm = 5\n\
                    [[pairs]]\nbodies = [\"rail\", \"holder\"]\ncheck = false\nreason = \" a cover \"\n";
        let rules = machine(text).expect("rules").pairs;
        assert_eq!(rules[0].care, PairCare::NearMiss(5.0));
        assert!(rules[0].is_of("bed", "head") && !rules[0].is_of("bed", "rail") && !rules[0].is_of("bed", "bed"));
        assert_eq!((rules[1].care, rules[1].reason.as_str()), (PairCare::Unchecked, "a cover"));
    }

    #[test]
    fn a_rule_that_changes_nothing_is_refused() {
        let of = |bodies: &str, rest: &str| format!("[[pairs]]\nbodies = {bodies}\n{rest}\n");
        let two = r#"["head", "bed"]"#;
        let twice = of(two, "near_miss_mm = 2") + &of(r#"["bed", "head"]"#, "near_miss_mm = 3");
        for (text, word) in [
            (of(r#"["head", "bett"]"#, "near_miss_mm = 2"), "there is no body \"bett\""),
            (of(r#"["hose", "bed"]"#, "near_miss_mm = 2"), "not checked at all"),
            (of(r#"["rail", "bed"]"#, "near_miss_mm = 2"), "never move against each other"),
            (of(r#"["head", "holder"]"#, "near_miss_mm = 2"), "never move against each other"),
            (of(two, "near_miss_mm = -1"), "-1 mm is not a valid distance"),
            (of(two, "check = false"), "without a reason"),
            (of(two, "check = false\nreason = \"  \""), "without a reason"),
            (of(two, "check = true"), "without a rule"),
            (of(two, "check = false\nnear_miss_mm = 1\nreason = \"x\""), "a distance, and whether"),
            (of(two, "reason = \"x\""), "no rule is given"),
            (twice, "have a rule already"),
        ] {
            let said = machine(&text).expect_err(word);
            assert!(said.contains(word), "{word}: {said}");
        }
    }
}
