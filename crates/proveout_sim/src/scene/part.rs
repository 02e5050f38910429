//! Design part of a scene: a mesh, or a surface with a closed form.

use std::path::{Path, PathBuf};

use proveout_geom::Vector;
use proveout_input::{InputError, Step, Step::Key};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::scene::{
    BladeFile, BoxFile,
    mesh_unit::MeshUnitFile,
    place::offset_of,
    step_file::{self, NamedMesh, is_step_file},
};

/// Chord errors of a blade's mesh that are taken, mm: finer ones make too many triangles, coarser ones no
/// shape.
const CHORD_ERROR_MM: std::ops::RangeInclusive<f64> = 1e-5..=1.0;
/// Shorter vectors are no direction.
const SHORTEST: f64 = 1e-9;

/// Design part: a mesh, or a surface with a closed form.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    /// Watertight mesh file in the workpiece frame, mm, or a STEP file.
    #[schemars(with = "Option<PathBuf>")]
    pub mesh: Option<Spanned<PathBuf>>,
    /// Unit of the numbers of `mesh`, which is converted to millimeters: `mm`, `cm`, `m` or `inch`.
    /// Millimeters when left out; a design that cannot be cut from the stock is refused then. Say `mm` where
    /// the size is meant.
    pub mesh_unit: Option<MeshUnitFile>,
    /// Of a STEP file: largest distance of its mesh from the exact surfaces that is asked for, micrometers;
    /// 5 when left out, which is reported as assumed. The distance that is measured counts.
    pub chord_um: Option<f64>,
    /// Largest distance of the mesh from the true design, mm: deviations below it are not judged.
    #[serde(default)]
    pub chord_error_mm: f64,
    /// Lateral face of a circular cone frustum.
    pub cone_frustum: Option<ConeFrustumFile>,
    /// Blade on a platform, or a face with a closed form.
    pub blade: Option<BladeFile>,
    /// File of the sections of a blade of kind `sections`, CSV; see docs/blades.md.
    pub sections: Option<PathBuf>,
    /// Only surface points in this box are judged, workpiece frame; everywhere when left out.
    pub judged_box: Option<BoxFile>,
}

impl PartFile {
    /// Its mesh, where it has one.
    pub(crate) fn named_mesh(&self) -> Option<NamedMesh<'_>> {
        let (unit, chord_um) = (self.mesh_unit, self.chord_um);
        self.mesh.as_ref().map(|file| NamedMesh { file, unit, chord_um })
    }
}

/// Lateral face of a circular cone frustum; only surface points on it are judged.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConeFrustumFile {
    /// Apex, mm.
    pub apex_mm: [f64; 3],
    /// Direction from the apex into the cone.
    pub axis: [f64; 3],
    /// Half apex angle, degrees.
    pub half_angle_deg: f64,
    /// The face is judged between these distances from the apex along the axis, mm.
    pub from_mm: f64,
    /// See `from_mm`.
    pub to_mm: f64,
    /// Points farther than this from the cone belong to another face, mm.
    pub reach_mm: f64,
}

/// One form, with numbers that make sense.
///
/// # Errors
/// The first fault.
pub(crate) fn check(path: &Path, text: &str, part: &PartFile) -> Result<(), InputError> {
    let at_key = |keys: &[Step<'_>], message: &str, help: &str| {
        let keys: Vec<Step<'_>> = [Key("part")].into_iter().chain(keys.iter().copied()).collect();
        Err(InputError::at(path, text, offset_of(text, &keys), message, help))
    };
    let fault = |message: &str, help: &str| at_key(&[], message, help);
    let forms = [part.mesh.is_some(), part.cone_frustum.is_some(), part.blade.is_some()];
    if forms.into_iter().filter(|given| *given).count() != 1 {
        return fault("the part needs exactly one form", "give one of `mesh`, `cone_frustum`, `blade`");
    }
    if part.mesh_unit.is_some() && part.mesh.is_none() {
        return fault("`mesh_unit` belongs to `mesh`", "leave it out, or give `mesh`");
    }
    if let Some((key, message, help)) = step_file::fault(part.mesh.as_ref(), part.mesh_unit, part.chord_um) {
        return at_key(&[Key(key)], &message, &help);
    }
    if is_step_file(part.mesh.as_ref()) && part.chord_error_mm != 0.0 {
        return at_key(
            &[Key("chord_error_mm")],
            "the chord error of a STEP file is measured: `chord_error_mm` has no effect on it",
            "leave it out; `chord_um` asks for a finer mesh",
        );
    }
    if let Some(b) = part.judged_box
        && !(0..3).all(|i| b.min_mm[i] < b.max_mm[i])
    {
        return at_key(&[Key("judged_box")], "the judged box is empty", "min_mm must be below max_mm");
    }
    match &part.blade {
        Some(blade) => {
            if let Some((message, help)) = blade.fault(part.sections.is_some()) {
                return at_key(&[Key("blade")], &message, &help);
            }
        }
        None if part.sections.is_some() => {
            return at_key(
                &[Key("sections")],
                "`sections` belongs to a blade",
                "give [part.blade] with kind = \"sections\"",
            );
        }
        None => {}
    }
    if part.blade.is_some_and(|b| !CHORD_ERROR_MM.contains(&b.chord_error_mm)) {
        return at_key(
            &[Key("blade"), Key("chord_error_mm")],
            "chord_error_mm of the blade is out of range",
            "give 0.00001 to 1 mm",
        );
    }
    if part.chord_error_mm.is_nan() || part.chord_error_mm < 0.0 {
        return fault("chord_error_mm must not be negative", "give the largest distance of the mesh from the design");
    }
    if let Some(c) = part.cone_frustum
        && !(c.half_angle_deg > 0.0
            && c.half_angle_deg < 90.0
            && 0.0 <= c.from_mm
            && c.from_mm < c.to_mm
            && c.reach_mm > 0.0
            && Vector::from(c.axis).norm() > SHORTEST)
    {
        return fault(
            "the cone frustum is not valid",
            "half_angle_deg between 0 and 90, 0 <= from_mm < to_mm, reach_mm above 0, axis with a length",
        );
    }
    Ok(())
}
