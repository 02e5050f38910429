use proveout_record::write_mesh;
use proveout_sim::{blade_mesh_of, scene::Scene};

use crate::{
    args::BladeArgs,
    commands::output_file::{check, put},
    failure::Failure,
};

/// Largest allowance, mm.
const MOST_ALLOWANCE_MM: f64 = 1e3;
/// Chord errors that are offered, mm: as a scene may state them.
const CHORD_ERROR_MM: std::ops::RangeInclusive<f64> = 1e-5..=1.0;

/// Writes the mesh of the blade of a scene.
pub(crate) fn blade(args: &BladeArgs) -> Result<(), Failure> {
    let ending = args.output.extension().map(|e| e.to_string_lossy().to_lowercase());
    if !matches!(ending.as_deref(), Some("stl" | "glb")) {
        return Err(Failure::new(format!("{}: the file extension is neither .stl nor .glb", args.output.display()))
            .with_help("use the extension .stl or .glb"));
    }
    check(&args.output, args.force)?;
    if !(0.0..=MOST_ALLOWANCE_MM).contains(&args.allowance_mm) {
        return Err(
            Failure::new(format!("--allowance-mm {} is out of range", args.allowance_mm)).with_help("use 0 to 1000 mm")
        );
    }
    if let Some(error) = args.chord_error_mm.filter(|e| !CHORD_ERROR_MM.contains(e)) {
        return Err(Failure::new(format!("--chord-error-mm {error} is out of range")).with_help("use 0.00001 to 1 mm"));
    }
    let scene = Scene::read(&args.scene).map_err(|e| Failure::from(&e.into()))?;
    let made = blade_mesh_of(&scene, args.allowance_mm, args.chord_error_mm).map_err(|e| Failure::from(&e))?;
    let note = format!(
        "allowance {} mm, chord error {:.6} mm as measured, {} mm asked",
        args.allowance_mm, made.measured, made.asked
    );
    put(&args.output, args.force, |beside| {
        write_mesh(beside, "blade", &note, &made.mesh).map_err(|e| {
            Failure::new(format!("{} cannot be written: {e}", args.output.display())).with_help("name another file")
        })
    })?;
    tell!("{}: {} triangles, {note}", args.output.display(), made.mesh.triangles.len());
    Ok(())
}
