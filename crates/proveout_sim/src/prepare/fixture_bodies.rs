//! Meshes of fixtures that are given by their dimensions: closed boxes and cylinders that touch and do not
//! cross.

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh, cylinder_mesh, rad};

use crate::{
    prepare::fixtures::FIXTURE_SECTORS,
    scene::{FixtureFile, fixture::FixtureKindFile},
};

/// The mesh of a fixture of a kind, in the frame of its coordinates.
pub(crate) fn mesh(fixture: &FixtureFile, kind: FixtureKindFile) -> TriMesh {
    let at = Vector::from(fixture.at_mm.unwrap_or_default());
    let [x, y, z] = fixture.rotation_deg.unwrap_or_default().map(rad);
    body(fixture, kind).transformed(&Pose::from_rpy(at, x, y, z))
}

fn block(min: [f64; 3], max: [f64; 3]) -> TriMesh {
    box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) })
}

/// Drawn round its circle, so that the body is never smaller than it is.
fn round(diameter: f64, z: [f64; 2]) -> TriMesh {
    let outer = 0.5 * diameter / (std::f64::consts::PI / FIXTURE_SECTORS as f64).cos();
    cylinder_mesh(outer, z[0], z[1], FIXTURE_SECTORS)
}

fn joined(parts: impl IntoIterator<Item = TriMesh>) -> TriMesh {
    parts.into_iter().fold(TriMesh::default(), |mut all, part| {
        all.append(&part);
        all
    })
}

/// The body in its own frame.
fn body(fixture: &FixtureFile, kind: FixtureKindFile) -> TriMesh {
    let l = |key: &str| fixture.length_of(key);
    match kind {
        FixtureKindFile::Vise => {
            let (half, width) = (0.5 * l("opening_mm"), 0.5 * l("jaw_width_mm"));
            let outer = half + l("jaw_thickness_mm");
            let foot = -l("jaw_height_mm");
            joined([
                block([-width, half, foot], [width, outer, 0.0]),
                block([-width, -outer, foot], [width, -half, 0.0]),
                block([-width, -outer, foot - l("bed_height_mm")], [width, outer, foot]),
            ])
        }
        FixtureKindFile::Plate => {
            let (x, y) = (0.5 * l("length_mm"), 0.5 * l("width_mm"));
            block([-x, -y, -l("thickness_mm")], [x, y, 0.0])
        }
        FixtureKindFile::Chuck => {
            let disk = round(l("diameter_mm"), [-l("length_mm"), 0.0]);
            let (inner, outer) = (0.5 * l("grip_diameter_mm"), 0.5 * l("diameter_mm"));
            let (width, height) = (0.5 * l("jaw_width_mm"), l("jaw_height_mm"));
            let count = fixture.jaws.unwrap_or(0);
            let jaw = |k: u32| {
                let turn = Pose::from_axis_angle(&Vector::z(), std::f64::consts::TAU * f64::from(k) / f64::from(count));
                block([inner, -width, 0.0], [outer, width, height]).transformed(&turn)
            };
            joined(std::iter::once(disk).chain((0..count).map(jaw)))
        }
        FixtureKindFile::Tombstone => {
            let (side, base, foot) = (0.5 * l("side_mm"), 0.5 * l("base_side_mm"), l("base_thickness_mm"));
            joined([
                block([-base, -base, 0.0], [base, base, foot]),
                block([-side, -side, foot], [side, side, l("height_mm")]),
            ])
        }
        FixtureKindFile::ToeClamp => {
            let (reach, width, thick) = (l("reach_mm"), 0.5 * l("width_mm"), l("thickness_mm"));
            let (end, foot) = (l("length_mm") - reach, -l("height_mm"));
            // The stud is in the middle behind the toe, the post takes the last fifth of the bar.
            let stud = Pose::from_translation(Vector::new(0.5 * end, 0.0, 0.0));
            let post = 0.8 * end;
            joined([
                block([-reach, -width, 0.0], [end, width, thick]),
                round(l("stud_diameter_mm"), [foot, 0.0]).transformed(&stud),
                round(l("stud_diameter_mm"), [thick, thick + l("stud_height_mm")]).transformed(&stud),
                block([post, -width, foot], [end, width, 0.0]),
            ])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fixture(text: &str) -> FixtureFile {
        toml::from_str(text).unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    /// Seeded dimensions: every body is closed and has the volume and the box of its parts.
    #[test]
    fn bodies_of_all_kinds_are_closed_and_have_their_size() {
        let mut state = 0x1234_5678_u64;
        let mut draw = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let part = (state >> 40) as f64 / (1_u64 << 24) as f64;
            (1e3 * (low + (high - low) * part)).round() / 1e3
        };
        let circle = |d: f64| {
            let (n, outer) = (FIXTURE_SECTORS as f64, 0.5 * d / (std::f64::consts::PI / FIXTURE_SECTORS as f64).cos());
            0.5 * n * outer * outer * (std::f64::consts::TAU / n).sin()
        };
        for _ in 0..40 {
            let [a, b, c, d, e] = [0; 5].map(|_| draw(5.0, 90.0));
            let at = [draw(-50.0, 50.0), draw(-50.0, 50.0), draw(-50.0, 50.0)];
            let turn = draw(-180.0, 180.0);
            let jaws = 2 + (draw(0.0, 4.0) as u32);
            let rows = [
                (
                    FixtureKindFile::Vise,
                    format!(
                        "opening_mm = {a}\njaw_width_mm = {b}\njaw_height_mm = {c}\njaw_thickness_mm = {d}\nbed_height_mm = {e}\n"
                    ),
                    b * (2.0 * d * c + (a + 2.0 * d) * e),
                    -c - e,
                ),
                (
                    FixtureKindFile::Plate,
                    format!("length_mm = {a}\nwidth_mm = {b}\nthickness_mm = {c}\n"),
                    a * b * c,
                    -c,
                ),
                (
                    FixtureKindFile::Chuck,
                    format!(
                        "diameter_mm = {}\nlength_mm = {b}\ngrip_diameter_mm = {a}\njaws = {jaws}\njaw_width_mm = {c}\njaw_height_mm = {d}\n",
                        a + 2.0 * e
                    ),
                    circle(a + 2.0 * e) * b + f64::from(jaws) * e * c * d,
                    -b,
                ),
                (
                    FixtureKindFile::Tombstone,
                    format!(
                        "side_mm = {a}\nheight_mm = {}\nbase_side_mm = {}\nbase_thickness_mm = {b}\n",
                        b + c,
                        a + d
                    ),
                    (a + d) * (a + d) * b + a * a * c,
                    0.0,
                ),
                (
                    FixtureKindFile::ToeClamp,
                    format!(
                        "length_mm = {}\nwidth_mm = {}\nthickness_mm = {b}\nreach_mm = {a}\nheight_mm = {c}\nstud_diameter_mm = {d}\n\
                         stud_height_mm = {e}\n",
                        a + 100.0,
                        d + 5.0
                    ),
                    (a + 100.0) * (d + 5.0) * b + circle(d) * (c + e) + 20.0 * (d + 5.0) * c,
                    -c,
                ),
            ];
            for (kind, keys, volume, lowest) in rows {
                let text = format!(
                    "name = \"f\"\nkind = \"{}\"\nat_mm = {at:?}\nrotation_deg = [0, 0, {turn}]\n{keys}",
                    kind.word()
                );
                let found = mesh(&fixture(&text), kind);
                assert!(found.check_solid().is_ok(), "{text}: {:?}", found.check_solid());
                let is = found.volume();
                assert!((is - volume).abs() < 1e-6 * volume, "{text}: {is} against {volume}");
                let low = found.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
                assert!((low - at[2] - lowest).abs() < 1e-9, "{text}: {low}");
            }
        }
    }
}
