//! Cutting constants of a work material, from a file.

use std::path::Path;

use proveout_input::{Document, InputError, Step::Key, read_input};
use serde::Deserialize;

/// What the thickness in a table of specific cutting forces is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ThicknessConvention {
    /// The uncut chip thickness at each point of the edge: kc = kc1.1 h^-m (Kienzle 1952).
    ChipThickness,
    /// The feed per tooth of the cut, as tables of tool makers count it: kc = kc1.1 fz^-m over the whole
    /// revolution.
    FeedPerTooth,
}

/// Specific cutting forces of a material after Kienzle (1952), with an edge term after Altintas (2012,
/// chapter 2).
///
/// On an edge element of the chip width b with the chip thickness h, in mm and N:
///
/// ```text
/// tangential  F_t = kc1.1 h^(1 - m) b + K_te b        against the motion of the edge
/// normal      F_n = radial ratio * F_t                into the tool, across the edge
/// along       F_a = axial ratio * F_t                 along the edge's outline, up to the spindle
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name for people.
    pub name: String,
    /// Where the constants come from.
    pub source: String,
    /// What h is.
    pub convention: ThicknessConvention,
    /// Specific force at a thickness of 1 mm: kc1.1, N/mm².
    pub kc11: f64,
    /// Exponent m, 0 or more and below 1.
    pub exponent: f64,
    /// Tangential force of the edge for each mm of it: `K_te`, N/mm.
    pub edge_force: f64,
    /// Force across the edge over tangential force.
    pub radial_ratio: f64,
    /// Force along the edge over tangential force.
    pub axial_ratio: f64,
    /// Uncertainty of all forces, in percent either way.
    pub uncertainty_percent: f64,
}

/// The text form of [`Material`].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialFile {
    name: String,
    source: String,
    convention: ThicknessConvention,
    kc11_n_mm2: f64,
    exponent: f64,
    #[serde(default)]
    edge_force_n_mm: f64,
    radial_ratio: f64,
    axial_ratio: f64,
    uncertainty_percent: f64,
}

impl Material {
    /// Reads a file.
    ///
    /// # Errors
    /// The first fault with place and remedy: an unknown or missing key, a number out of its range.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::from_text(path, &read_input(path)?)
    }

    /// The same from a text; errors show `name`.
    ///
    /// ```
    /// use proveout_feeds::Material;
    ///
    /// let text = r#"
    /// name = "Steel of the test cut"
    /// source = "own dynamometer, 2024"
    /// convention = "chip-thickness"
    /// kc11_n_mm2 = 1500
    /// exponent = 0.25
    /// radial_ratio = 0.4
    /// axial_ratio = 0.1
    /// uncertainty_percent = 10
    /// "#;
    /// let steel = Material::from_text("steel.toml".as_ref(), text)?;
    /// // kc at 0.1 mm: 1500 * 0.1^-0.25 N/mm2.
    /// assert!((steel.specific_force(0.1) - 2667.4).abs() < 0.1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn from_text(name: &Path, text: &str) -> Result<Self, InputError> {
        let document = Document::new(name, text);
        let file: MaterialFile = document.read()?;
        let within = |key: &'static str, value: f64, [least, most]: [f64; 2]| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            let message = format!("must be from {least} to {most}");
            Err(document.error_with_value("material-range", &[Key(key)], message, "check the value and its unit"))
        };
        within("kc11_n_mm2", file.kc11_n_mm2, [1.0, 2e4])?;
        within("exponent", file.exponent, [0.0, 0.9])?;
        within("edge_force_n_mm", file.edge_force_n_mm, [0.0, 1e3])?;
        within("radial_ratio", file.radial_ratio, [0.0, 3.0])?;
        within("axial_ratio", file.axial_ratio, [-3.0, 3.0])?;
        within("uncertainty_percent", file.uncertainty_percent, [0.0, 100.0])?;
        if file.source.trim().is_empty() {
            let help = "name the test or the table, so that the forces can be judged";
            return Err(document.error_with_value("material-source", &[Key("source")], "is empty", help));
        }
        Ok(Self {
            name: file.name,
            source: file.source,
            convention: file.convention,
            kc11: file.kc11_n_mm2,
            exponent: file.exponent,
            edge_force: file.edge_force_n_mm,
            radial_ratio: file.radial_ratio,
            axial_ratio: file.axial_ratio,
            uncertainty_percent: file.uncertainty_percent,
        })
    }

    /// Specific cutting force at a thickness above zero, mm: kc, N/mm².
    pub fn specific_force(&self, thickness: f64) -> f64 {
        self.kc11 * thickness.powf(-self.exponent)
    }
}
