//! Limits of the tools, from a file.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use proveout_input::{Document, InputError, Step::Key, nearest, read_input};
use proveout_tool::ToolLibrary;
use serde::Deserialize;

use crate::{compliance::Compliance, force::ForceModel, material::Material};

/// Newtons per square millimeter in a gigapascal.
const N_MM2_PER_GPA: f64 = 1e3;
/// Part of its diameter that a fluted length counts with where the file says nothing (Kops and Vo 1990).
pub const FLUTED_PART: f64 = 0.8;

/// What a tool may do. None: no limit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolLimits {
    /// Largest uncut chip thickness, mm.
    pub max_chip_mm: Option<f64>,
    /// The largest chip of a block must not fall below this, mm.
    pub min_chip_mm: Option<f64>,
    /// Largest force across the axis, N.
    pub max_force_n: Option<f64>,
    /// Largest torque, N m.
    pub max_torque_nm: Option<f64>,
    /// Largest mean power of the spindle motor, kW.
    pub max_power_kw: Option<f64>,
    /// Largest deflection of the tip, micrometers.
    pub max_deflection_um: Option<f64>,
    /// Highest feed, mm/min. Without it feeds are never raised.
    pub max_feed_mm_min: Option<f64>,
    /// Feeds are never raised, since marks of feed grow with them.
    pub keep_surface: bool,
}

impl ToolLimits {
    /// Whether a limit asks for cutting forces.
    pub fn asks_forces(&self) -> bool {
        let limits = [self.max_force_n, self.max_torque_nm, self.max_power_kw, self.max_deflection_um];
        limits.iter().any(Option::is_some)
    }
}

/// A file of limits.
#[derive(Clone, Debug)]
pub struct LimitsFile {
    file: PathBuf,
    text: String,
    parts: FileParts,
    /// Materials by the path that names them.
    materials: BTreeMap<String, Material>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileParts {
    material: Option<String>,
    spindle_efficiency: Option<f64>,
    #[serde(default)]
    tool: BTreeMap<String, ToolPart>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ToolPart {
    material: Option<String>,
    max_chip_mm: Option<f64>,
    min_chip_mm: Option<f64>,
    max_force_n: Option<f64>,
    max_torque_nm: Option<f64>,
    max_power_kw: Option<f64>,
    max_deflection_um: Option<f64>,
    max_feed_mm_min: Option<f64>,
    #[serde(default)]
    keep_surface: bool,
    youngs_modulus_gpa: Option<f64>,
    fluted_diameter_part: Option<f64>,
}

impl LimitsFile {
    /// Reads a file, and the materials that it names (paths from its folder).
    ///
    /// # Errors
    /// The first fault with place and remedy.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::from_text(path, read_input(path)?)
    }

    /// The same from a text; `path` names it, and gives the folder of the materials.
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn from_text(path: &Path, text: String) -> Result<Self, InputError> {
        let document = Document::new(path, &text);
        let parts: FileParts = document.read()?;
        let above_zero = |at: &[proveout_input::Step<'_>], value: Option<f64>, most: f64| match value {
            Some(v) if !(v > 0.0 && v <= most) => {
                let message = format!("must be above 0 and at most {most}");
                Err(document.error_with_value("limits-range", at, message, "leave the key out for no limit"))
            }
            _ => Ok(()),
        };
        above_zero(&[Key("spindle_efficiency")], parts.spindle_efficiency, 1.0)?;
        let mut materials = BTreeMap::new();
        let mut named: Vec<(Vec<proveout_input::Step<'_>>, &String)> = Vec::new();
        named.extend(parts.material.iter().map(|m| (vec![Key("material")], m)));
        for (name, t) in &parts.tool {
            let key = |k: &'static str| [Key("tool"), Key(name), Key(k)];
            for (k, value, most) in [
                ("max_chip_mm", t.max_chip_mm, 1e2),
                ("min_chip_mm", t.min_chip_mm, 1e2),
                ("max_force_n", t.max_force_n, 1e6),
                ("max_torque_nm", t.max_torque_nm, 1e5),
                ("max_power_kw", t.max_power_kw, 1e3),
                ("max_deflection_um", t.max_deflection_um, 1e4),
                ("max_feed_mm_min", t.max_feed_mm_min, 1e6),
                ("youngs_modulus_gpa", t.youngs_modulus_gpa, 2e3),
                ("fluted_diameter_part", t.fluted_diameter_part, 1.0),
            ] {
                above_zero(&key(k), value, most)?;
            }
            if let (Some(least), Some(most)) = (t.min_chip_mm, t.max_chip_mm)
                && least >= most
            {
                let message = format!("is not below max_chip_mm = {most}: no feed meets both");
                let help = "lower min_chip_mm, or leave it out";
                return Err(document.error_with_value("limits-no-feed", &key("min_chip_mm"), message, help));
            }
            if t.max_deflection_um.is_some() && t.youngs_modulus_gpa.is_none() {
                let message = "needs youngs_modulus_gpa of the shank";
                let help = "write youngs_modulus_gpa = 600 for carbide, 210 for steel, or the maker's value";
                return Err(document.error_with_value("limits-modulus", &key("max_deflection_um"), message, help));
            }
            named.extend(t.material.iter().map(|m| (key("material").to_vec(), m)));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        for (at, name) in named {
            if !materials.contains_key(name) {
                let material = Material::read(&folder.join(name)).map_err(|e| match e.line {
                    // The file itself: the key that names it is the place to look at.
                    0 => document.error_with_value("limits-material", &at, e.message.clone(), e.remedy.clone()),
                    _ => e,
                })?;
                materials.insert(name.clone(), material);
            }
        }
        Ok(Self { file: path.to_owned(), parts, materials, text })
    }

    /// Refuses names that no tool of the library has.
    ///
    /// # Errors
    /// The first such name, with the nearest one.
    pub fn check_names(&self, tools: &ToolLibrary) -> Result<(), InputError> {
        let known: Vec<&str> = tools.tools.iter().map(|t| t.name.as_str()).collect();
        let Some(name) = self.parts.tool.keys().find(|n| !known.contains(&n.as_str())) else { return Ok(()) };
        let help = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean {near:?}?"),
            None => format!("tools of the library: {}", known.join(", ")),
        };
        let path = [Key("tool"), Key(name)];
        Err(self.document().error("limits-unknown-tool", &path, "is no tool of the library", help))
    }

    fn document(&self) -> Document<'_> {
        Document::new(&self.file, &self.text)
    }

    /// Limits of a tool; none where the file does not name it.
    pub fn of(&self, tool: &str) -> Option<ToolLimits> {
        let t = self.parts.tool.get(tool)?;
        Some(ToolLimits {
            max_chip_mm: t.max_chip_mm,
            min_chip_mm: t.min_chip_mm,
            max_force_n: t.max_force_n,
            max_torque_nm: t.max_torque_nm,
            max_power_kw: t.max_power_kw,
            max_deflection_um: t.max_deflection_um,
            max_feed_mm_min: t.max_feed_mm_min,
            keep_surface: t.keep_surface,
        })
    }

    /// The material that a tool cuts.
    pub fn material_of(&self, tool: &str) -> Option<&Material> {
        let own = self.parts.tool.get(tool).and_then(|t| t.material.as_ref());
        own.or(self.parts.material.as_ref()).and_then(|name| self.materials.get(name))
    }

    /// The force model of a tool; none where no material is given.
    ///
    /// # Errors
    /// A tool with limits of force and no material, or without teeth.
    pub fn model_of(&self, tool: &proveout_tool::Tool) -> Result<Option<ForceModel>, InputError> {
        let limits = self.of(&tool.name).unwrap_or_default();
        let path = [Key("tool"), Key(&tool.name)];
        let refuse = |code, message: String, help: &str| Err(self.document().error(code, &path, message, help));
        if tool.flutes.is_none_or(|n| n == 0) {
            let asked = limits.asks_forces() || limits.max_chip_mm.is_some() || limits.min_chip_mm.is_some();
            return match asked {
                true => refuse(
                    "limits-no-teeth",
                    "the library states no teeth of this tool, so that it has no feed per tooth".into(),
                    "write `flutes` into the tool library, or leave out the limits of chip and force",
                ),
                false => Ok(None),
            };
        }
        let Some(material) = self.material_of(&tool.name) else {
            return match limits.asks_forces() {
                true => refuse(
                    "limits-no-material",
                    "has limits of force, and no material is named".into(),
                    "write material = \"FILE\" at the top of the limits, or into this table",
                ),
                false => Ok(None),
            };
        };
        if limits.max_power_kw.is_some() && self.parts.spindle_efficiency.is_none() {
            return refuse(
                "limits-efficiency",
                "has max_power_kw, and the file has no spindle_efficiency".into(),
                "write spindle_efficiency = 0.8, or the value of the spindle's maker, at the top of the limits",
            );
        }
        let part = self.parts.tool.get(&tool.name);
        let stiffness = part.and_then(|t| Some((t.youngs_modulus_gpa?, t.fluted_diameter_part.unwrap_or(FLUTED_PART))));
        let compliance = stiffness.and_then(|(gpa, part)| Compliance::of_tool(tool, gpa * N_MM2_PER_GPA, part));
        Ok(ForceModel::new(tool, material.clone(), self.parts.spindle_efficiency.unwrap_or(1.0), compliance))
    }

    /// What the limits rest on and the file does not state, in words.
    pub fn assumed(&self) -> Vec<String> {
        let mut all = Vec::new();
        if self.parts.spindle_efficiency.is_none() && !self.materials.is_empty() {
            all.push("power is that of the cut: the limits state no spindle_efficiency".to_owned());
        }
        for (name, t) in &self.parts.tool {
            if t.youngs_modulus_gpa.is_some() && t.fluted_diameter_part.is_none() {
                all.push(format!(
                    "{name}: its fluted length counts with {FLUTED_PART} of the diameter (Kops and Vo 1990)"
                ));
            }
        }
        all
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The materials, with the names of their files.
    pub fn materials(&self) -> impl Iterator<Item = (&str, &Material)> {
        self.materials.iter().map(|(name, m)| (name.as_str(), m))
    }
}
