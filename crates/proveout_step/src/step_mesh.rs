//! A STEP file as a closed mesh: the answer of the helper, compared with the text of the file.
//!
//! **Chord error.** Where the surface over a triangle is quadratic in its parameters, its distance from the
//! plane of the triangle is `4 (m12 l1 l2 + m23 l2 l3 + m31 l3 l1)`, with the barycentric coordinates `l` and
//! the distances `m` in the middles of the edges. The middle of the triangle has `4/9 (m12 + m23 + m31)`.
//! With all four at most 1 in size, the largest value inside is 16/15, for `m = (1, 1, 1/4)`: there the
//! middle has exactly 1. So 16/15 of the largest measured distance bounds the error of such surfaces.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::RangeInclusive,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

use proveout_geom::{Point, TriMesh};
use proveout_input::read_regular_file;
use sha2::{Digest, Sha256};

use crate::{
    answer::{Answer, SAMPLES, SolidHead},
    distance::{BoundedPoint, largest_distance},
    helper::{Helper, VARIABLE},
    step_error::StepError,
    text::{StepFace, StepText},
};

/// Chord error that is asked for where a scene states none, um: a tenth of the tolerances that are usual for
/// a finished face.
pub const DEFAULT_CHORD_UM: f64 = 5.0;
/// Chord errors that may be asked for, um: finer ones make millions of triangles, coarser ones no shape.
pub const CHORD_UM: RangeInclusive<f64> = 0.1..=1000.0;
/// Largest error of a quadratic surface over a triangle, as a part of the largest of its four measured ones.
pub const QUADRATIC: f64 = 16.0 / 15.0;
/// Largest file.
const MAX_FILE_BYTES: u64 = 1 << 29;
/// Relative error of the kernel's volumes, with a reserve of ten to what it is asked for.
const VOLUME_ERROR: f64 = 1e-6;
/// Faces that an error names.
const NAMED: usize = 5;
const UM_PER_MM: f64 = 1000.0;

/// A STEP file as a closed mesh.
#[derive(Clone, Debug)]
pub struct StepMesh {
    /// All solids, mm, in the coordinates of the file; each is closed, and they share no vertex.
    pub mesh: TriMesh,
    /// What the text says.
    pub text: StepText,
    /// The kernel, with its version.
    pub kernel: String,
    /// Chord error that was asked for, um.
    pub asked_um: f64,
    /// Largest measured distance of an exact point from the mesh, um.
    pub measured_um: f64,
    /// Where it was measured, mm.
    pub worst: Point,
    /// Exact points that were measured.
    pub samples: usize,
    /// Solids, each as often as it is placed.
    pub solids: usize,
    /// Volume of the exact surfaces, mm³.
    pub exact_volume_mm3: f64,
    /// Faces that belong to no solid, and are left out.
    pub loose: Vec<StepFace>,
}

impl StepMesh {
    /// Largest distance of the mesh from the exact surfaces, mm: [`QUADRATIC`] of the measured one.
    pub fn chord_error_mm(&self) -> f64 {
        QUADRATIC * self.measured_um / UM_PER_MM
    }

    /// Whether the mesh is finer than what was asked for.
    pub fn is_as_asked(&self) -> bool {
        self.measured_um <= self.asked_um
    }
}

/// Whether the name of a file is that of a STEP file.
pub fn is_step(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    matches!(ending.as_deref(), Some("step" | "stp"))
}

/// By SHA-256 of the file and the bits of the chord error.
type Meshes = BTreeMap<(String, u64), Arc<StepMesh>>;

/// The STEP files that one command has read. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct StepFiles {
    helper: Option<Helper>,
    read: Arc<Mutex<Meshes>>,
}

impl StepFiles {
    /// With a helper instead of the one that is installed.
    pub fn with_helper(helper: Helper) -> Self {
        Self { helper: Some(helper), ..Self::default() }
    }

    /// Reads a STEP file, once for the same bytes and chord error.
    ///
    /// # Errors
    /// [`StepError`] with its remedy.
    pub fn read(&self, path: &Path, chord_um: f64) -> Result<Arc<StepMesh>, StepError> {
        let bytes =
            read_regular_file(path, MAX_FILE_BYTES).map_err(|source| StepError::Open { path: path.into(), source })?;
        let sha256: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        let key = (sha256, chord_um.to_bits());
        // Others wait here, and find it read.
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = read.get(&key) {
            return Ok(known.clone());
        }
        let text = StepText::read(path, &bytes)?;
        drop(bytes);
        let made = Arc::new(self.convert(path, text, &key.0, chord_um)?);
        read.insert(key, made.clone());
        Ok(made)
    }

    fn convert(&self, path: &Path, text: StepText, sha256: &str, chord_um: f64) -> Result<StepMesh, StepError> {
        let none = |message: String| StepError::NoHelper { path: path.into(), message };
        let helper = match &self.helper {
            Some(helper) => helper.clone(),
            None => Helper::find().map_err(none)?.ok_or_else(|| {
                none(format!(
                    "a STEP file is read by the program proveout-step, which is neither on the path nor named by {VARIABLE}"
                ))
            })?,
        };
        let folder = tempfile::Builder::new()
            .prefix("proveout-step-")
            .tempdir()
            .map_err(|e| none(format!("no temporary folder for proveout-step: {e}")))?;
        helper.run(path, chord_um, folder.path())?;
        let wrong = |message| StepError::Answer { path: path.into(), helper: helper.program.clone(), message };
        let answer = Answer::read(folder.path()).map_err(wrong)?;
        if answer.head.sha256 != sha256 {
            return Err(wrong(format!(
                "it is about a file with SHA-256 {}, this one has {sha256}",
                answer.head.sha256
            )));
        }
        check_unit(&answer, &text).map_err(wrong)?;
        let loose = check_counts(&answer, &text).map_err(|message| StepError::Lost { path: path.into(), message })?;
        solids(path, answer, text, chord_um, loose)
    }
}

/// The kernel counts in the unit of the text.
fn check_unit(answer: &Answer, text: &StepText) -> Result<(), String> {
    let units = &answer.head.units;
    if units.iter().any(|u| u.eq_ignore_ascii_case(&text.unit.name)) && units.len() == 1 {
        return Ok(());
    }
    Err(format!("it counts in {:?}, the file in {:?}", units.join(", "), text.unit.name))
}

/// Every face and solid of the text is in the answer; gives the faces that are in no solid.
fn check_counts(answer: &Answer, text: &StepText) -> Result<Vec<StepFace>, String> {
    let known = |entity: i64| usize::try_from(entity).ok().filter(|e| *e < text.faces.len());
    let in_solids: Option<BTreeSet<usize>> = answer.head.faces.iter().map(|f| known(f.entity)).collect();
    let loose: Option<BTreeSet<usize>> = answer.head.loose.iter().map(|e| known(*e)).collect();
    let (Some(in_solids), Some(loose)) = (in_solids, loose) else {
        return Err(format!(
            "{} has made a face that is none of the {} of the file",
            answer.head.kernel,
            text.faces.len()
        ));
    };
    let lost: Vec<&StepFace> = (0..text.faces.len())
        .filter(|face| !in_solids.contains(face) && !loose.contains(face))
        .filter_map(|face| text.faces.get(face))
        .collect();
    if !lost.is_empty() {
        let names: Vec<String> = lost.iter().take(NAMED).map(|f| f.shown()).collect();
        let more = if lost.len() > NAMED { ", ..." } else { "" };
        return Err(format!(
            "{} has lost {} of its {} faces: {}{more}",
            answer.head.kernel,
            lost.len(),
            text.faces.len(),
            names.join(", ")
        ));
    }
    // A solid that is placed twice has the same faces twice.
    let of_solid = |s: &SolidHead| -> Vec<i64> {
        let mut faces: Vec<i64> =
            answer.head.faces.iter().skip(s.faces[0]).take(s.faces[1]).map(|f| f.entity).collect();
        faces.sort_unstable();
        faces
    };
    let distinct: BTreeSet<Vec<i64>> = answer.head.solids.iter().map(of_solid).collect();
    if distinct.len() != text.solids.len() {
        let names: Vec<String> = text.solids.iter().take(NAMED).map(StepFace::shown).collect();
        let (count, ending) = (text.solids.len(), if text.solids.len() == 1 { "" } else { "s" });
        return Err(format!(
            "the file has {count} solid{ending} ({}), {} has read {}",
            names.join(", "),
            answer.head.kernel,
            distinct.len()
        ));
    }
    let of_no_solid = loose.difference(&in_solids);
    Ok(of_no_solid.filter_map(|face| text.faces.get(*face)).cloned().collect())
}

/// The solids, each closed, of its volume, and with its chord error measured.
fn solids(
    path: &Path,
    answer: Answer,
    text: StepText,
    asked_um: f64,
    loose: Vec<StepFace>,
) -> Result<StepMesh, StepError> {
    let Answer { head, positions, triangles, samples } = answer;
    let mut mesh = TriMesh::default();
    let mut worst = (0.0, Point::origin());
    let mut exact_volume_mm3 = 0.0;
    let mut edges = samples.get(SAMPLES * triangles.len()..).unwrap_or_default();
    for (number, solid) in head.solids.iter().enumerate() {
        let name = || format!("solid {} of {}", number + 1, head.solids.len());
        let faces = head.faces.iter().skip(solid.faces[0]).take(solid.faces[1]);
        let (first, count) = faces.fold((usize::MAX, 0), |(first, all), f| (first.min(f.tri[0]), all + f.tri[1]));
        let own = triangles.get(first..first + count).unwrap_or_default();
        let (of_edges, rest) = edges.split_at_checked(solid.edge_samples).unwrap_or_default();
        edges = rest;
        let part = merged(&positions, own);
        part.check_solid().map_err(|source| StepError::OpenSolid { path: path.into(), solid: name(), source })?;
        let corners = |t: &[u32; 3]| t.map(|i| positions[i as usize]);
        let of_triangles = own.iter().zip(samples.chunks_exact(SAMPLES).skip(first));
        let points = of_triangles
            .flat_map(|(t, points)| points.iter().map(move |p| BoundedPoint::of_triangle(*p, &corners(t))))
            .chain(of_edges.iter().map(|p| BoundedPoint::unbounded(*p)))
            .collect();
        let measured = largest_distance(&part, points).unwrap_or(worst);
        let allowed_mm3 = QUADRATIC * measured.0 * area(&part) + VOLUME_ERROR * solid.volume_mm3.abs();
        let mesh_mm3 = part.volume();
        let off_mm3 = (mesh_mm3 - solid.volume_mm3).abs();
        if off_mm3 > allowed_mm3 || off_mm3.is_nan() {
            let (path, exact_mm3) = (path.into(), solid.volume_mm3);
            return Err(StepError::Volume { path, solid: name(), mesh_mm3, exact_mm3, allowed_mm3 });
        }
        if measured.0 > worst.0 {
            worst = measured;
        }
        exact_volume_mm3 += solid.volume_mm3;
        mesh.append(&part);
    }
    Ok(StepMesh {
        mesh,
        text,
        kernel: head.kernel,
        asked_um,
        measured_um: UM_PER_MM * worst.0,
        worst: worst.1,
        samples: samples.len(),
        solids: head.solids.len(),
        exact_volume_mm3,
        loose,
    })
}

/// Triangles with their own vertices, equal ones joined.
fn merged(positions: &[Point], triangles: &[[u32; 3]]) -> TriMesh {
    let corners = triangles.iter().flatten().map(|i| positions[*i as usize]).collect();
    let count = triangles.len() as u32;
    let own = TriMesh { positions: corners, triangles: (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect() };
    own.merge_equal_vertices()
}

fn area(mesh: &TriMesh) -> f64 {
    (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_normal(t).norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The factor against a search over quadratic surfaces and places.
    #[test]
    fn sixteen_fifteenths_bounds_every_quadratic_surface() {
        const STEPS: i32 = 24;
        let grid = || (-STEPS..=STEPS).map(|k| f64::from(k) / f64::from(STEPS));
        let mut most = 0.0_f64;
        for (a, b, c) in grid().flat_map(|a| grid().flat_map(move |b| grid().map(move |c| (a, b, c)))) {
            let middle = 4.0 / 9.0 * (a + b + c);
            let largest = [a, b, c, middle].into_iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if largest == 0.0 {
                continue;
            }
            for i in 0..=30 {
                for k in 0..=30 - i {
                    let (u, v) = (f64::from(i) / 30.0, f64::from(k) / 30.0);
                    let w = 1.0 - u - v;
                    most = most.max((4.0 * (a * u * v + b * v * w + c * w * u)).abs() / largest);
                }
            }
        }
        // The best place is at (4, 4, 7) / 15, which the grid of thirtieths has.
        assert!(most <= QUADRATIC + 1e-12 && most > QUADRATIC - 1e-9, "{most}");
    }

    #[test]
    fn endings_are_those_of_step_files() {
        for (name, step) in [("a.step", true), ("a.STP", true), ("a.stl", false), ("step", false), ("a.p21", false)] {
            assert_eq!(is_step(Path::new(name)), step, "{name}");
        }
    }
}
