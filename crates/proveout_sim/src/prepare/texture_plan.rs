//! The places of `[surface]`: patches and profiles, checked against the design.

use std::sync::Arc;

use proveout_blade::FOOT_ERROR_MM;
use proveout_geom::{Point, TriMesh, Vector};
use proveout_input::Step::Key;
use proveout_surface::{
    DesignMesh, DesignSurface,
    texture::{Profile, SettingClass},
};
use proveout_tool::ToolLibrary;

use crate::{
    prepare::{
        error::SimError,
        part_shape::{Shape, flank},
        texture_places::{Ground, Place, Refused},
    },
    scene::{ProfileDirectionFile, Scene, SurfaceFile, surface::Middle},
    units::MM_PER_UM,
};

/// Bytes of a node while a patch is evaluated: point, normal, contact, heights of maps and filters.
const NODE_BYTES: u64 = 320;

/// What is asked for at a place.
#[derive(Clone, Debug)]
pub(crate) enum Wanted {
    /// A map with so many steps of so many mm, and profiles through its middle.
    Map { steps: [usize; 2], step: f64, profiles: bool },
    /// A profile to the lay, or along the place's own direction.
    Profile(Option<ProfileDirectionFile>),
}

#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) name: String,
    pub(crate) place: Place,
    pub(crate) wanted: Wanted,
}

/// The places of a scene, checked against its design.
pub(crate) struct Plan {
    pub(crate) ground: Ground,
    pub(crate) entries: Vec<Entry>,
    pub(crate) class: SettingClass,
    /// Error of the design, mm.
    pub(crate) chord_error: f64,
}

impl std::fmt::Debug for Plan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Plan").field("entries", &self.entries).finish_non_exhaustive()
    }
}

impl Plan {
    /// The places of a scene; none without `[surface]`.
    ///
    /// # Errors
    /// A place off the design or over its edge, by name.
    pub(crate) fn new(
        scene: &Scene,
        part_mesh: Option<&TriMesh>,
        part_mesh_error: Option<f64>,
        tools: &ToolLibrary,
    ) -> Result<Option<Self>, SimError> {
        let Some(surface) = &scene.file.surface else { return Ok(None) };
        for spanned in &surface.phase {
            if let Some(name) = &spanned.get_ref().tool
                && !tools.tools.iter().any(|t| t.name == *name)
            {
                let names: Vec<&str> = tools.tools.iter().map(|t| t.name.as_str()).collect();
                let message = format!("the library has no tool {name:?}");
                return Err(scene
                    .fault(spanned.span().start, message, format!("write one of {}", names.join(", ")))
                    .into());
            }
        }
        let (ground, chord_error) = ground(scene, part_mesh, part_mesh_error)?;
        let mut plan =
            Self { ground, entries: Vec::new(), class: surface.class.unwrap_or(SettingClass::Sc3), chord_error };
        for spanned in &surface.patch {
            let patch = spanned.get_ref();
            let (size, step_um) = (patch.size_mm.unwrap_or(surface.size_mm), patch.step_um.unwrap_or(surface.step_um));
            let offset = spanned.span().start;
            plan.add_patch(scene, surface, offset, patch.name.clone(), (&patch.middle(), patch.along), size, step_um)?;
        }
        for spanned in &surface.grid {
            let grid = spanned.get_ref();
            let [us, vs] = grid.middles();
            for (j, v) in vs.iter().enumerate() {
                for (i, u) in us.iter().enumerate() {
                    let name = format!("{}-{}-{}", grid.name, j + 1, i + 1);
                    let between = |r: &Option<[f64; 2]>, t: f64| r.map(|[a, b]| a + (b - a) * t);
                    let (arc, x) = (between(&grid.arc_mm, *u), between(&grid.x_mm, *v));
                    let at = grid.corner_mm.map(|c| {
                        let side = |s: &Option<[f64; 3]>, t: f64| Vector::from(s.unwrap_or_default()) * t;
                        (Vector::from(c) + side(&grid.u_mm, *u) + side(&grid.v_mm, *v)).into()
                    });
                    let middle = Middle { at: &at, arc, x, normal: &None };
                    let along = grid.u_mm;
                    let offset = spanned.span().start;
                    plan.add_patch(scene, surface, offset, name, (&middle, along), surface.size_mm, surface.step_um)?;
                }
            }
        }
        for spanned in &surface.profile {
            let profile = spanned.get_ref();
            let (name, offset) = (profile.name.clone(), spanned.span().start);
            let place = plan.ground.place(&profile.middle(), profile.along);
            let place = place.map_err(|(m, help)| scene.fault(offset, format!("profile {name:?}: {m}"), help))?;
            plan.entries.push(Entry { name, place, wanted: Wanted::Profile(profile.direction) });
        }
        Ok(Some(plan))
    }

    #[expect(clippy::too_many_arguments, reason = "place and size of a patch come from two tables")]
    fn add_patch(
        &mut self,
        scene: &Scene,
        surface: &SurfaceFile,
        offset: usize,
        name: String,
        (middle, along): (&Middle<'_>, Option<[f64; 3]>),
        size: [f64; 2],
        step_um: f64,
    ) -> Result<(), SimError> {
        let fault = |(m, help): Refused| scene.fault(offset, format!("patch {name:?}: {m}"), help);
        let place = self.ground.place(middle, along).map_err(&fault)?;
        let step = MM_PER_UM * step_um;
        let steps = size.map(|s| (s / step).round().max(2.0) as usize);
        place.check(&self.ground, steps, [step, step]).map_err(&fault)?;
        self.entries.push(Entry { name, place, wanted: Wanted::Map { steps, step, profiles: surface.profiles } });
        Ok(())
    }

    /// Balls round all places, with the longest profile that may be taken there.
    pub(crate) fn areas(&self) -> Vec<Area> {
        let longest = 0.5 * Profile::length_for(next_class(self.class).unwrap_or(self.class));
        let radius = |wanted: &Wanted| match wanted {
            Wanted::Map { steps, step, profiles } => {
                let half = 0.5 * step * (steps[0] as f64).hypot(steps[1] as f64);
                if *profiles { half.max(longest) } else { half }
            }
            Wanted::Profile(_) => longest,
        };
        self.entries.iter().map(|e| Area { middle: e.place.middle, radius: radius(&e.wanted) }).collect()
    }

    /// Memory that pieces and the largest patch take, bytes.
    pub(crate) fn memory(&self, lines: u64) -> u64 {
        let nodes = |e: &Entry| match e.wanted {
            Wanted::Map { steps, .. } => ((steps[0] + 1) * (steps[1] + 1)) as u64,
            Wanted::Profile(_) => 0,
        };
        // A line is cut into several pieces where it bends or changes its speed.
        let pieces = lines.saturating_mul(16).clamp(20_000, MOST_PIECES as u64);
        self.entries.iter().map(nodes).max().unwrap_or(0).max(60_000) * NODE_BYTES + pieces * PIECE_BYTES
    }
}

/// The class above one.
pub(crate) fn next_class(class: SettingClass) -> Option<SettingClass> {
    SettingClass::ALL.into_iter().find(|c| *c > class)
}

/// What the places lie on, and its error, mm.
fn ground(scene: &Scene, part_mesh: Option<&TriMesh>, part_mesh_error: Option<f64>) -> Result<(Ground, f64), SimError> {
    let Some(part) = &scene.file.part else { return Ok((Ground::None, 0.0)) };
    if let Some(cone) = &part.cone_frustum {
        let design: Arc<dyn DesignSurface + Send> = Arc::new(flank(cone).0);
        return Ok((Ground::Design(design), 0.0));
    }
    if let Some(blade) = &part.blade {
        if blade.kind.has_ends()
            && let Shape::Ended(solid) = Shape::of_scene(scene, blade, 0.0)?
        {
            return Ok((Ground::Design(Arc::new(*solid)), FOOT_ERROR_MM));
        }
        let help = "correct [part.blade]";
        let blade = blade.blade(0.0).map_err(|e| scene.error_at(&[Key("part"), Key("blade")], e.to_string(), help))?;
        return Ok((Ground::Blade(Box::new(blade)), 0.0));
    }
    let Some(mesh) = part_mesh else { return Ok((Ground::None, 0.0)) };
    let tree =
        DesignMesh::new(mesh).map_err(|e| scene.error_at(&[Key("part")], format!("[part]: {e}"), "mend the mesh"))?;
    Ok((Ground::Design(Arc::new(tree)), part_mesh_error.unwrap_or(part.chord_error_mm)))
}

/// A ball round everything that is asked for at a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Area {
    pub(crate) middle: Point,
    pub(crate) radius: f64,
}

/// Pieces that are kept at most.
pub(crate) const MOST_PIECES: usize = 1_000_000;

/// Bytes of a kept piece with its places in the lists of patches.
pub(crate) const PIECE_BYTES: u64 = 256;
