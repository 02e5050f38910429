//! The part of a scene as a closed form: a blade with its ends, or a face over a block; and its closed mesh.

use std::{path::PathBuf, sync::Arc};

use proveout_blade::{
    Backing, Blade, BladeSolid, CamberSide, ClosedSurface, Cui, Dong, Lu, ParametricSurface, Sine, SkinnedBlade,
    face_mesh, read_sections,
};
use proveout_geom::{Point, TriMesh, Vector, rad};
use proveout_input::{InputError, Step, Step::Key, read_input};
use proveout_surface::{ConeFlank, ConeFrustum, chord_error};

use crate::{
    prepare::error::SimError,
    scene::{BladeFile, BladeKindFile, ConeFrustumFile, Scene},
};

/// A closed form of the part.
#[derive(Debug)]
pub(crate) enum Shape {
    /// Circles on a camber line, on their platform.
    Camber(Box<Blade>),
    /// A blade between two ends.
    Ended(Box<BladeSolid>),
    /// A face with rims, the block below it, and the material left on it, mm.
    Face(Arc<dyn ParametricSurface>, Backing, f64),
}

/// The mesh of the blade of a scene.
#[derive(Clone, Debug)]
pub struct BladeMesh {
    /// Closed, frame of the scene's part, mm.
    pub mesh: TriMesh,
    /// Distance of its facets from the closed form as measured, mm.
    pub measured: f64,
    /// Chord error that was asked, mm.
    pub asked: f64,
}

/// Where a scene describes its blade.
const BLADE: [Step<'static>; 2] = [Key("part"), Key("blade")];

impl Shape {
    /// The blade or face of a scene with so much material left on it, mm.
    ///
    /// # Errors
    /// Numbers or sections that make none.
    pub(crate) fn of_scene(scene: &Scene, file: &BladeFile, allowance: f64) -> Result<Self, InputError> {
        let wrong = |message: String| scene.error_at(&BLADE, message, "correct [part.blade] or the allowance");
        let ended = |surface: Arc<dyn ParametricSurface>| {
            let (Some(root), Some(tip)) = (&file.root, &file.tip) else {
                return Err(wrong("the blade does not have two ends".into()));
            };
            let solid = BladeSolid::new(surface, [root.end(), tip.end()], allowance);
            solid.map(|s| Self::Ended(Box::new(s))).map_err(|e| wrong(e.to_string()))
        };
        let block = Backing::Plane { z: file.underside_mm.unwrap_or(0.0) };
        let face = |surface: Arc<dyn ParametricSurface>, backing| Ok(Self::Face(surface, backing, allowance));
        match file.kind {
            BladeKindFile::Camber => {
                file.blade(allowance).map(|b| Self::Camber(Box::new(b))).map_err(|e| wrong(e.to_string()))
            }
            BladeKindFile::Lu => ended(Arc::new(ClosedSurface::new(Lu::stand_in()))),
            BladeKindFile::LuUntwisted => ended(Arc::new(ClosedSurface::new(Lu::untwisted()))),
            BladeKindFile::Sine => face(Arc::new(ClosedSurface::new(Sine::published_ratio())), block),
            BladeKindFile::SineGentle => face(Arc::new(ClosedSurface::new(Sine::gentle())), block),
            BladeKindFile::Dong => face(Arc::new(ClosedSurface::new(Dong::stand_in())), block),
            BladeKindFile::Cui => {
                let form = Cui::stand_in();
                face(Arc::new(ClosedSurface::new(form)), Backing::Behind { depth: form.distance })
            }
            BladeKindFile::Sections => ended(Arc::new(skinned(scene)?)),
        }
    }

    /// The side that tools run along.
    pub(crate) fn surface(&self) -> Arc<dyn ParametricSurface> {
        match self {
            Self::Camber(blade) => Arc::new(CamberSide::new((**blade).clone())),
            Self::Ended(solid) => solid.surface().clone(),
            Self::Face(surface, ..) => surface.clone(),
        }
    }

    /// Its closed mesh within a chord error, mm, and how far it is off as measured; that of kind `camber` is
    /// not measured here.
    ///
    /// # Errors
    /// The chord error was not reached, or the mesh bounds no solid.
    pub(crate) fn mesh(&self, scene: &Scene, chord_error_mm: f64) -> Result<(TriMesh, Option<f64>), SimError> {
        let wrong = |message: String| scene.error_at(&BLADE, message, "correct [part.blade]");
        let made = match self {
            Self::Camber(blade) => (blade.mesh(chord_error_mm), None),
            Self::Ended(solid) => {
                let made = solid.mesh(chord_error_mm).map_err(|e| wrong(e.to_string()))?;
                (made.mesh, Some(made.measured))
            }
            Self::Face(surface, backing, allowance) => {
                let made = face_mesh(surface.as_ref(), *backing, *allowance, chord_error_mm);
                let made = made.map_err(|e| wrong(e.to_string()))?;
                (made.mesh, Some(made.measured))
            }
        };
        made.0.check_solid().map_err(|source| SimError::Mesh { path: scene.path.clone(), source })?;
        Ok(made)
    }
}

/// The file of sections, where the part has one.
pub(crate) fn sections_file(scene: &Scene) -> Option<PathBuf> {
    Some(scene.resolve(scene.file.part.as_ref()?.sections.as_ref()?))
}

fn skinned(scene: &Scene) -> Result<SkinnedBlade, InputError> {
    let path = sections_file(scene).unwrap_or_default();
    let text = read_input(&path)?;
    let sections = read_sections(&text).map_err(|e| {
        InputError::file(&path, e.message, "see the format of sections in docs/blades.md").with_line(e.line)
    })?;
    SkinnedBlade::new(&sections)
        .map_err(|e| InputError::file(&path, e.to_string(), "see the format of sections in docs/blades.md"))
}

/// The mesh of the blade of a scene with an allowance, mm, at a chord error, mm (the scene's where none is
/// given).
///
/// # Errors
/// The scene has no blade, or it is none.
pub fn blade_mesh_of(scene: &Scene, allowance: f64, chord_error_mm: Option<f64>) -> Result<BladeMesh, SimError> {
    let Some(file) = scene.file.part.as_ref().and_then(|p| p.blade) else {
        return Err(scene.error_at(&BLADE, "the scene has no blade", "describe it as [part.blade]").into());
    };
    let asked = chord_error_mm.unwrap_or(file.chord_error_mm);
    let shape = Shape::of_scene(scene, &file, allowance)?;
    let (mesh, measured) = shape.mesh(scene, asked)?;
    let measured = match &shape {
        Shape::Camber(blade) => chord_error(&mesh, &**blade),
        _ => measured,
    };
    let unknown = || scene.error_at(&BLADE, "the error of the mesh cannot be determined", "correct [part.blade]");
    Ok(BladeMesh { mesh, measured: measured.ok_or_else(unknown)?, asked })
}

/// The flank between its two distances from the apex, and its area: mean circumference times slant height.
pub(crate) fn flank(cone: &ConeFrustumFile) -> (ConeFlank, f64) {
    let (sine, cosine) = proveout_geom::sin_cos(rad(cone.half_angle_deg));
    let slope = sine / cosine;
    let axis = Vector::from(cone.axis).normalize();
    let frustum = ConeFrustum {
        base: Point::from(cone.apex_mm) + axis * cone.to_mm,
        axis: -axis,
        base_radius: cone.to_mm * slope,
        top_radius: cone.from_mm * slope,
        height: cone.to_mm - cone.from_mm,
    };
    let area = std::f64::consts::PI * (frustum.base_radius + frustum.top_radius) * frustum.height / cosine;
    (ConeFlank { frustum, end_margin: 0.0 }, area)
}
