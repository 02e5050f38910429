//! Watertight mesh of a blade.
//!
//! Rings of the same outline parameters at rising X are stitched into strips; every ring has its points at
//! the same camber positions and edge angles, so that caps are strips across the camber line: no
//! triangulation of a concave polygon is needed.

use std::f64::consts::FRAC_PI_2;

use proveout_geom::{Point, TriMesh};

use super::{
    LEAST_BEND,
    body::Blade,
    solid_mesh::{COARSEST_MM, FINEST_MM},
};

/// Smallest step of an arc, radian.
const LEAST_ARC: f64 = 1e-4;

/// One level of the mesh: height and offset of the outline.
#[derive(Clone, Copy)]
struct MeshLevel {
    x: f64,
    offset: f64,
    twisted: bool,
}

impl Blade {
    /// A closed mesh whose chords and facets stay within `chord_error` mm of the blade.
    ///
    /// Steps follow from the sagitta `h^2 / 8 r`: along the sides of the camber radius, around the edges of
    /// their radius, in the fillet of its radius, and along X of the saddle that twist makes of a strip
    /// (`twist h_x h / 4`).
    pub fn mesh(&self, chord_error: f64) -> TriMesh {
        let spec = self.spec();
        let tolerance = chord_error.clamp(FINEST_MM, COARSEST_MM);
        let largest = spec.platform.map_or(0.0, |p| p.margin);
        let section = &spec.section;
        // The sharpest curvature of the sides is below 1 / (camber radius - thickness) plus that of the
        // thickness law.
        let bend = section.camber_radius().min(section.chord) * 0.25;
        let side_step = (8.0 * tolerance * bend).sqrt();
        let sides = ((section.camber_radius() * section.camber_angle / side_step).ceil() as usize).clamp(16, 4000);
        let edge_radius = section.leading_radius.max(section.trailing_radius) + largest;
        let edges = arc_steps(edge_radius, tolerance, 2.0 * FRAC_PI_2);
        let levels = self.levels(tolerance, side_step);
        let mut mesh = TriMesh::default();
        let mut ring_size = 0;
        for level in &levels {
            let ring = self.ring(level, sides, edges);
            ring_size = ring.len();
            mesh.positions.extend(ring);
        }
        stitch(&mut mesh, levels.len(), ring_size);
        cap(&mut mesh, 0, sides, edges, true);
        cap(&mut mesh, (levels.len() - 1) * ring_size, sides, edges, false);
        mesh
    }

    fn levels(&self, tolerance: f64, side_step: f64) -> Vec<MeshLevel> {
        let spec = self.spec();
        let mut levels = Vec::new();
        if let Some(platform) = spec.platform {
            // The platform is not twisted: its rim is perpendicular to its faces.
            levels.push(MeshLevel { x: -platform.thickness, offset: platform.margin, twisted: false });
            levels.push(MeshLevel { x: 0.0, offset: platform.margin, twisted: false });
            let f = platform.fillet_radius;
            let steps = arc_steps(f, tolerance, FRAC_PI_2);
            for i in 0..steps {
                let (s, c) = (FRAC_PI_2 * i as f64 / steps as f64).sin_cos();
                levels.push(MeshLevel { x: f * (1.0 - c), offset: f * (1.0 - s), twisted: true });
            }
        }
        let start = self.airfoil_start();
        let reach = 0.6 * spec.section.chord + spec.section.thickness;
        let saddle = 4.0 * tolerance / (spec.twist.abs() * side_step).max(LEAST_BEND);
        let sagitta = (8.0 * tolerance / (spec.twist * spec.twist * reach).max(LEAST_BEND)).sqrt();
        let height = spec.length - start;
        let steps = ((height / saddle.min(sagitta).min(height)).ceil() as usize).clamp(1, 4000);
        for i in 0..=steps {
            levels.push(MeshLevel { x: start + height * i as f64 / steps as f64, offset: 0.0, twisted: true });
        }
        levels
    }

    /// Pressure side (`sides` + 1 points), trailing edge inside, suction side, leading edge inside;
    /// counter-clockwise.
    fn ring(&self, level: &MeshLevel, sides: usize, edges: usize) -> Vec<Point> {
        let section = &self.spec().section;
        let pairs: Vec<_> = (0..=sides).map(|i| section.pair(i as f64 / sides as f64, level.offset).1).collect();
        let inner = |trailing| {
            let points = section.edge_points(trailing, edges, level.offset);
            points.into_iter().skip(1).take(edges - 1)
        };
        let outline = pairs
            .iter()
            .map(|pair| pair[0])
            .chain(inner(true))
            .chain(pairs.iter().rev().map(|pair| pair[1]))
            .chain(inner(false));
        outline
            .map(|p| {
                if level.twisted {
                    self.raised(p.position, p.normal_angle, level.x).point
                } else {
                    Point::new(level.x, p.position[0], p.position[1])
                }
            })
            .collect()
    }
}

/// Steps of an arc of this angle with sagitta `r (1 - cos(a/2))` below the tolerance.
fn arc_steps(radius: f64, tolerance: f64, angle: f64) -> usize {
    let step = 2.0 * (1.0 - (tolerance / radius).min(1.0)).acos();
    ((angle / step.max(LEAST_ARC)).ceil() as usize).clamp(4, 4000)
}

fn stitch(mesh: &mut TriMesh, levels: usize, size: usize) {
    for level in 1..levels {
        let (below, above) = (((level - 1) * size) as u32, (level * size) as u32);
        for i in 0..size as u32 {
            let j = (i + 1) % size as u32;
            // Counter-clockwise about +X seen from +X, so outward is to the right of the run.
            mesh.triangles.push([below + i, below + j, above + j]);
            mesh.triangles.push([below + i, above + j, above + i]);
        }
    }
}

/// Closes a ring by strips between the two sides and fans at the edges.
fn cap(mesh: &mut TriMesh, first: usize, sides: usize, edges: usize, bottom: bool) {
    let size = 2 * (sides + 1) + 2 * (edges - 1);
    let lower = |i: usize| (first + i) as u32;
    let upper = |i: usize| (first + sides + 1 + (edges - 1) + (sides - i)) as u32;
    let mut add = |a: u32, b: u32, c: u32| mesh.triangles.push(if bottom { [a, c, b] } else { [a, b, c] });
    for i in 0..sides {
        add(lower(i), lower(i + 1), upper(i + 1));
        add(lower(i), upper(i + 1), upper(i));
    }
    // Trailing edge: from the pressure to the suction side around the end; leading edge likewise.
    let trailing: Vec<u32> = (sides..=sides + edges).map(|i| (first + i) as u32).collect();
    let leading: Vec<u32> = (2 * sides + edges..=size).map(|i| (first + i % size) as u32).collect();
    for arc in [trailing, leading] {
        for pair in arc.windows(2).skip(1) {
            add(arc[0], pair[0], pair[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BladeSpec, CamberSection, Platform};
    use super::*;

    fn blade(twist: f64, platform: bool) -> Blade {
        let platform = platform.then_some(Platform { fillet_radius: 10.0, margin: 18.0, thickness: 12.0 });
        Blade::new(BladeSpec { section: CamberSection::stand_in(), length: 40.0, twist, platform }).unwrap()
    }

    #[test]
    fn the_mesh_is_a_solid() {
        for (twist, platform) in [(0.0, false), (0.004, false), (0.0, true), (0.004, true)] {
            let mesh = blade(twist, platform).mesh(0.01);
            mesh.check_solid().unwrap_or_else(|e| panic!("{twist} {platform}: {e}"));
        }
    }

    #[test]
    fn the_volume_of_a_straight_blade_is_section_times_length() {
        // Area of the section by the shoelace formula over a fine outline: error below perimeter * sagitta =
        // 135 * 1e-6.
        let blade = blade(0.0, false);
        let n = 60_000;
        let points: Vec<_> = (0..n)
            .map(|i| blade.outline().at(blade.outline().perimeter() * f64::from(i) / f64::from(n)).position)
            .collect();
        let area: f64 =
            points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| 0.5 * (a[0] * b[1] - b[0] * a[1])).sum();
        let mesh = blade.mesh(0.001);
        // Chords cut off at most perimeter * chord error of the area.
        assert!((mesh.volume() - area * 40.0).abs() < 135.0 * 0.001 * 40.0, "{} {}", mesh.volume(), area * 40.0);
        assert!(mesh.volume() < area * 40.0 + 135.0 * 0.001 * 40.0);
    }

    #[test]
    fn facets_stay_within_the_chord_error() {
        let blade = blade(0.004, true);
        let tolerance = 0.002;
        let mesh = blade.mesh(tolerance);
        let outline = blade.outline();
        // Dense surface points of the airfoil as an independent measure: distance of facet centers from the
        // nearest one, along its normal.
        let mut worst: f64 = 0.0;
        for t in mesh.triangles.iter().step_by(97) {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].coords);
            let m = Point::from((a + b + c) / 3.0);
            if m.x < 10.5 || m.x > 39.5 {
                continue;
            }
            let distance = |arc: f64| (blade.at(arc, m.x).point - m).norm();
            let count = 2000;
            let mut best = (0..count)
                .map(|i| outline.perimeter() * f64::from(i) / f64::from(count))
                .min_by(|p, q| distance(*p).total_cmp(&distance(*q)))
                .unwrap();
            let mut step = 0.1;
            while step > 1e-6 {
                if distance(best + step) < distance(best) {
                    best += step;
                } else if distance(best - step) < distance(best) {
                    best -= step;
                } else {
                    step *= 0.5;
                }
            }
            worst = worst.max(distance(best));
        }
        assert!(worst > 0.0 && worst < tolerance, "{worst}");
    }
}
