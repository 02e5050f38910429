//! Closed meshes of blades and of faces with rims, at a chord error that is measured.
//!
//! A facet of sides `h_u`, `h_v` lies within `(h_u^2 L + 2 h_u h_v M + h_v^2 N) / 8` of a surface with the
//! second fundamental form L, M, N (in the parameters). Columns and rows are spread so that each part stays
//! below its share everywhere, then the distance is measured on every facet, and all steps are shortened
//! until it holds.

use std::f64::consts::FRAC_PI_2;

use proveout_geom::{Point, TriMesh, Vector};

use super::{
    LEAST_BEND, flat,
    solid::{BladeSolid, Plate, SolidError, Trim, normal_changes},
    surface::{Local, ParametricSurface},
};

/// Places along u and v at which the second fundamental form is asked.
const ASKED: [usize; 2] = [1440, 24];
/// Share of the chord error for the parts along u, along v, and across.
const SHARE: [f64; 3] = [0.4, 0.3, 0.3];
/// Chord errors that are taken: below, files outgrow any memory.
pub(super) const FINEST_MM: f64 = 1e-5;
pub(super) const COARSEST_MM: f64 = 1.0;
/// Times that the steps are shortened.
const ROUNDS: usize = 6;
/// Steps along the centers of a fillet's ball.
const FOLLOWED: usize = 4;
/// Places of a facet as parts of its corners where its distance is measured.
const MEASURED: [[f64; 3]; 4] = [[1.0 / 3.0; 3], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];
/// Part of the determinant by the first derivatives below which that by the second ones is not used: there is
/// no minimum nearby.
const LEAST_DETERMINANT: f64 = 1e-3;
/// Sine between directions below which there is nothing between them.
const NO_ANGLE: f64 = 1e-12;

/// A mesh and how far it lies from the closed form.
#[derive(Clone, Debug)]
pub struct MeasuredMesh {
    /// The closed mesh.
    pub mesh: TriMesh,
    /// Largest distance of its curved facets from the closed form, mm, measured at middles of facets and
    /// edges.
    pub measured: f64,
}

/// Why there is no mesh.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum MeshingError {
    /// The ends.
    #[error(transparent)]
    Ends(#[from] SolidError),
    /// The chord error.
    #[error("a chord error of {asked_mm} mm is not offered; give 0.00001 to 1 mm")]
    ChordError {
        /// What was asked, mm.
        asked_mm: f64,
    },
    /// The steps were shortened and the distance stayed.
    #[error("the chord error of {asked_mm} mm was not reached, {measured_mm} mm is left; ask for a larger one")]
    NotReached {
        /// What was asked, mm.
        asked_mm: f64,
        /// What was measured, mm.
        measured_mm: f64,
    },
    /// A plane face has an outline that crosses itself.
    #[error("the flat end at X = {x_mm} mm has an outline that crosses itself")]
    Flat {
        /// Where it lies, mm.
        x_mm: f64,
    },
}

/// Steps that keep every part below its share: places from 0 to 1, from steps allowed at equal places.
fn spread(steps: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0];
    for pair in steps.windows(2) {
        // The shorter of both, so that a sharp place is not stepped over.
        sum.push(sum[sum.len() - 1] + 1.0 / pair[0].min(pair[1]) / (steps.len() - 1) as f64);
    }
    let whole = sum[sum.len() - 1];
    let count = (whole.ceil() as usize).max(2);
    let at = |k: usize| {
        let wanted = whole * k as f64 / count as f64;
        let j = sum.partition_point(|s| *s <= wanted).clamp(1, sum.len() - 1);
        (j as f64 - 1.0 + (wanted - sum[j - 1]) / (sum[j] - sum[j - 1])) / (steps.len() - 1) as f64
    };
    (0..=count).map(|k| if k == count { 1.0 } else { at(k) }).collect()
}

/// Magnitudes of L, M, N at a place, of the surface moved outward by a distance too.
fn form(at: &Local, moved: f64) -> [f64; 3] {
    let [l, m, n] = at.second.each_ref().map(|d| d.dot(&at.normal).abs());
    // The second form of a parallel surface: II + d III, III that of the changes of the normal.
    let [u, v] = normal_changes(at);
    [l + moved * u.norm_squared(), m + moved * u.dot(&v).abs(), n + moved * v.norm_squared()]
}

/// Parameters of columns (from 0 to 1 of u) and of rows (from 0 to 1 of v).
fn grid(surface: &dyn ParametricSurface, moved: f64, error: f64) -> [Vec<f64>; 2] {
    let domain = surface.domain();
    let wide = [domain.u[1] - domain.u[0], domain.v[1] - domain.v[0]];
    let mut columns = vec![f64::MAX; ASKED[0] + 1];
    let mut rows = vec![f64::MAX; ASKED[1] + 1];
    let mut across = vec![0.0_f64; ASKED[0] + 1];
    for (i, column) in columns.iter_mut().enumerate() {
        for (j, row) in rows.iter_mut().enumerate() {
            let [a, b] = [i as f64 / ASKED[0] as f64, j as f64 / ASKED[1] as f64];
            let at = surface.local(domain.u[0] + wide[0] * a, domain.v[0] + wide[1] * b);
            let [l, m, n] = form(&at, moved);
            let step = |form: f64, share: f64, wide: f64| (8.0 * share * error / form.max(LEAST_BEND)).sqrt() / wide;
            *column = column.min(step(l, SHARE[0], wide[0]));
            *row = row.min(step(n, SHARE[1], wide[1]));
            across[i] = across[i].max(m * wide[0] * wide[1]);
        }
    }
    let steps = |s: &[f64], most: f64| s.iter().map(|s| s.min(most)).collect::<Vec<_>>();
    let rows = spread(&steps(&rows, 0.25));
    let longest = rows.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
    // What the saddle leaves: h_u h_v M / 4.
    let limit =
        across.iter().zip(&columns).map(|(m, c)| (4.0 * SHARE[2] * error / (m * longest).max(LEAST_BEND)).min(*c));
    let columns = spread(&steps(&limit.collect::<Vec<_>>(), 0.05));
    [columns, rows]
}

/// Distance of a place from a surface moved outward, from parameters nearby: the foot by a few steps of
/// Newton's method (of Gauss's where the distance has no minimum nearby).
fn near_distance(surface: &dyn ParametricSurface, p: &Point, start: [f64; 2], moved: f64) -> f64 {
    let [mut u, mut v] = start;
    for _ in 0..4 {
        let at = surface.local(u, v);
        let f = at.point - p;
        let [su, sv] = &at.first;
        let g = [f.dot(su), f.dot(sv)];
        let gauss = [su.norm_squared(), su.dot(sv), sv.norm_squared()];
        let full: [f64; 3] = std::array::from_fn(|k| gauss[k] + f.dot(&at.second[k]));
        let of = |[a, b, c]: [f64; 3]| a * c - b * b;
        let least = full[0] > 0.0 && of(full) > LEAST_DETERMINANT * of(gauss);
        let [a, b, c] = if least { full } else { gauss };
        let det = of([a, b, c]);
        u -= (c * g[0] - b * g[1]) / det;
        v -= (a * g[1] - b * g[0]) / det;
    }
    let at = surface.local(u, v);
    ((p - at.point).dot(&at.normal).abs() - moved).abs()
}

/// Joins two rows of `size` columns, closed or not; the first lies before the second along v, columns run
/// counter-clockwise seen from outside's left.
fn strip(mesh: &mut TriMesh, low: u32, high: u32, size: u32, closed: bool, outward: bool) {
    for i in 0..if closed { size } else { size - 1 } {
        let j = (i + 1) % size;
        let quad = [low + i, low + j, high + j, high + i];
        for t in [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]] {
            mesh.triangles.push(if outward { t } else { [t[0], t[2], t[1]] });
        }
    }
}

impl BladeSolid {
    /// A closed mesh within a chord error, mm, as measured.
    ///
    /// # Errors
    /// The chord error is out of its range or was not reached.
    pub fn mesh(&self, chord_error: f64) -> Result<MeasuredMesh, MeshingError> {
        if !(FINEST_MM..=COARSEST_MM).contains(&chord_error) {
            return Err(MeshingError::ChordError { asked_mm: chord_error });
        }
        let mut error = 0.9 * chord_error;
        let mut left = f64::INFINITY;
        for _ in 0..ROUNDS {
            let made = self.mesh_once(error)?;
            left = made.measured;
            if left <= 0.95 * chord_error {
                return Ok(made);
            }
            error *= (0.8 * chord_error / left).clamp(0.2, 0.8);
        }
        Err(MeshingError::NotReached { asked_mm: chord_error, measured_mm: left })
    }

    fn mesh_once(&self, error: f64) -> Result<MeasuredMesh, MeshingError> {
        let surface = self.surface().as_ref();
        let domain = surface.domain();
        let largest = self.fillet(0).max(self.fillet(1)).max(self.allowance());
        let [columns, rows] = grid(surface, largest, error);
        let us: Vec<f64> =
            columns[..columns.len() - 1].iter().map(|a| domain.u[0] + (domain.u[1] - domain.u[0]) * a).collect();
        let size = us.len() as u32;
        let trims: Vec<[Trim; 2]> =
            us.iter().map(|u| Ok([self.trim(0, *u)?, self.trim(1, *u)?])).collect::<Result<_, SolidError>>()?;
        let mut mesh = TriMesh::default();
        let mut measured = 0.0_f64;
        self.fillet_rows(&mut mesh, &trims, 0, error);
        let first = mesh.positions.len() as u32 / size;
        let v_at = |i: usize, b: f64| trims[i][0].v + (trims[i][1].v - trims[i][0].v) * b;
        for b in &rows {
            for (i, u) in us.iter().enumerate() {
                let at = surface.local(*u, v_at(i, *b));
                mesh.positions.push(at.point + at.normal * self.allowance());
            }
        }
        self.fillet_rows(&mut mesh, &trims, 1, error);
        let all = mesh.positions.len() as u32 / size;
        let ccw = flat::polygon_area(&self.feet[0]) > 0.0;
        for row in 1..all {
            strip(&mut mesh, (row - 1) * size, row * size, size, true, ccw);
        }
        // How far the facets of the airfoil lie off, and those of the fillets.
        let place = |mesh: &TriMesh, row: u32, i: u32| mesh.positions[(row * size + i % size) as usize].coords;
        let period = domain.u[1] - domain.u[0];
        let of_airfoil = |row: u32| row >= first && row + 1 < first + rows.len() as u32;
        for row in 0..all - 1 {
            let airfoil = of_airfoil(row);
            let above_is_alike =
                row + 2 < all && of_airfoil(row + 1) == airfoil && (row + 1 >= first) == (row >= first);
            for i in 0..size {
                for (second, corners) in [[(0, 0), (0, 1), (1, 1)], [(0, 0), (1, 1), (1, 0)]].into_iter().enumerate() {
                    let places = corners.map(|(r, c)| place(&mesh, row + r, i + c));
                    for (k, parts) in MEASURED.into_iter().enumerate() {
                        // Edges are measured once: the diagonal with the first facet, the side with that of
                        // the facet before, the upper edge with the row above.
                        let elsewhere = [false, true, above_is_alike, i > 0][k];
                        if second == 1 && elsewhere {
                            continue;
                        }
                        let mix = |of: [f64; 3]| of[0] * parts[0] + of[1] * parts[1] + of[2] * parts[2];
                        let p = Point::from(places[0] * parts[0] + places[1] * parts[1] + places[2] * parts[2]);
                        let u = mix(corners
                            .map(|(_, c)| us[((i + c) % size) as usize] + if i + c == size { period } else { 0.0 }));
                        let far = if airfoil {
                            let v =
                                mix(corners
                                    .map(|(r, c)| v_at(((i + c) % size) as usize, rows[(row + r - first) as usize])));
                            near_distance(surface, &p, [u, v], self.allowance())
                        } else {
                            let end = usize::from(row >= first);
                            let v = mix(corners.map(|(_, c)| trims[((i + c) % size) as usize][end].v));
                            self.fillet_distance(end, [u, v], &p)
                        };
                        measured = if far.is_nan() { f64::INFINITY } else { measured.max(far) };
                    }
                }
            }
        }
        self.close_end(&mut mesh, 0, 0, size, ccw)?;
        self.close_end(&mut mesh, 1, (all - 1) * size, size, ccw)?;
        Ok(MeasuredMesh { mesh, measured })
    }

    /// Rows of a fillet without the one that it shares with the airfoil: from the platform at the first end,
    /// towards it at the second.
    fn fillet_rows(&self, mesh: &mut TriMesh, trims: &[[Trim; 2]], end: usize, error: f64) {
        let radius = self.fillet(end) - self.allowance();
        if self.ends()[end].plate.is_none() {
            return;
        }
        let step = 2.0 * (1.0 - (0.5 * error / radius).min(1.0)).acos();
        let steps = ((FRAC_PI_2 * 1.2 / step).ceil() as usize).clamp(3, 4000);
        let toward = Vector::x() * -Self::sense(end);
        for k in 0..steps {
            let part = if end == 0 { k } else { steps - 1 - k } as f64 / steps as f64;
            for trim in trims {
                let trim = &trim[end];
                mesh.positions.push(trim.center + turned(&toward, &-trim.at.normal, part) * radius);
            }
        }
    }

    /// Distance of a place from the fillet near (u, v): from the center of the ball abreast of it. Each step
    /// follows the tangent of the centers, `c' = C_u + C_v v'` with `C = S + f n` and `v' = -C_ux / C_vx`,
    /// which keeps the ball on the platform. What a step leaves counts squared: the distance from the centers
    /// is least there.
    fn fillet_distance(&self, end: usize, start: [f64; 2], p: &Point) -> f64 {
        let radius = self.fillet(end);
        let wanted = self.ends()[end].x + Self::sense(end) * radius;
        let surface = self.surface();
        let [mut u, mut v] = start;
        let mut center = Point::origin();
        for _ in 0..FOLLOWED {
            let at = surface.local(u, v);
            let [nu, nv] = normal_changes(&at);
            let (along, up) = (at.first[0] + nu * radius, at.first[1] + nv * radius);
            let here = at.point + at.normal * radius;
            let rise = (wanted - here.x) / up.x;
            center = here + up * rise;
            let tangent = along - up * (along.x / up.x);
            let size = tangent.norm_squared();
            let step = if size > 0.0 { (p - center).dot(&tangent) / size } else { 0.0 };
            u += step;
            v += rise - step * along.x / up.x;
        }
        ((p - center).norm() - (radius - self.allowance())).abs()
    }

    /// A flat end, or the platform with all of its faces.
    fn close_end(&self, mesh: &mut TriMesh, end: usize, first: u32, size: u32, ccw: bool) -> Result<(), MeshingError> {
        let x_mm = self.ends()[end].x;
        let ring: Vec<u32> = (first..first + size).collect();
        let turned: Vec<u32> = ring.iter().rev().copied().collect();
        let (left, right) = if ccw { (ring, turned) } else { (turned, ring) };
        let flat = || MeshingError::Flat { x_mm };
        let Some(plate) = self.ends()[end].plate else {
            // The flat end closes the solid: its face looks away from the blade.
            let all = flat::triangles(&places(mesh), &left, &[]).ok_or_else(flat)?;
            mesh.triangles.extend(all.into_iter().map(|[a, b, c]| if end == 1 { [a, b, c] } else { [a, c, b] }));
            return Ok(());
        };
        let face = x_mm + Self::sense(end) * self.allowance();
        let corners = block_corners(mesh, &plate, face, x_mm - Self::sense(end) * plate.thickness);
        let all = flat::triangles(&places(mesh), &corners[0], &right).ok_or_else(flat)?;
        let mut add = |t: [u32; 3], up: bool| mesh.triangles.push(if up { t } else { [t[0], t[2], t[1]] });
        let up = end == 0;
        all.into_iter().for_each(|t| add(t, up));
        let [face, back] = corners;
        for k in 0..4 {
            let j = (k + 1) % 4;
            add([face[k], back[k], back[j]], up);
            add([face[k], back[j], face[j]], up);
        }
        add([back[0], back[2], back[1]], up);
        add([back[0], back[3], back[2]], up);
        Ok(())
    }
}

/// Corners of both faces of a block, counter-clockwise seen from +X.
fn block_corners(mesh: &mut TriMesh, plate: &Plate, face: f64, back: f64) -> [[u32; 4]; 2] {
    let ([y0, y1], [z0, z1]) = (plate.y, plate.z);
    [face, back].map(|x| {
        [[y0, z0], [y1, z0], [y1, z1], [y0, z1]].map(|[y, z]| {
            mesh.positions.push(Point::new(x, y, z));
            mesh.positions.len() as u32 - 1
        })
    })
}

fn places(mesh: &TriMesh) -> Vec<[f64; 2]> {
    mesh.positions.iter().map(|p| [p.y, p.z]).collect()
}

/// A direction between two at right angles or not, by parts of their angle.
fn turned(from: &Vector, to: &Vector, part: f64) -> Vector {
    let angle = from.dot(to).clamp(-1.0, 1.0).acos();
    let sine = angle.sin();
    if sine < NO_ANGLE {
        return *from;
    }
    from * (((1.0 - part) * angle).sin() / sine) + to * ((part * angle).sin() / sine)
}

/// How a face with rims is closed to a mesh: by a back at a depth below it, along one direction or towards
/// the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backing {
    /// A plane of constant z, mm.
    Plane {
        /// Below the face, mm.
        z: f64,
    },
    /// A back at this depth below the face, along its normal at w = 0 of each row, mm: for ruled faces.
    Behind {
        /// mm.
        depth: f64,
    },
}

/// A block whose upper face is a surface with rims.
///
/// # Errors
/// The chord error is out of its range or was not reached.
pub fn face_mesh(
    surface: &dyn ParametricSurface,
    backing: Backing,
    allowance: f64,
    chord_error: f64,
) -> Result<MeasuredMesh, MeshingError> {
    if !(FINEST_MM..=COARSEST_MM).contains(&chord_error) {
        return Err(MeshingError::ChordError { asked_mm: chord_error });
    }
    let domain = surface.domain();
    let (mut error, mut left) = (0.9 * chord_error, f64::INFINITY);
    for _ in 0..ROUNDS {
        let [columns, rows] = grid(surface, allowance, error);
        let u = |a: f64| domain.u[0] + (domain.u[1] - domain.u[0]) * a;
        let v = |b: f64| domain.v[0] + (domain.v[1] - domain.v[0]) * b;
        let size = columns.len() as u32;
        let mut mesh = TriMesh::default();
        for b in &rows {
            for a in &columns {
                let at = surface.local(u(*a), v(*b));
                mesh.positions.push(at.point + at.normal * allowance);
            }
        }
        let face = mesh.positions.len() as u32;
        for b in &rows {
            let behind = surface.local(0.5 * (domain.u[0] + domain.u[1]), v(*b)).normal;
            for a in &columns {
                let at = surface.local(u(*a), v(*b)).point;
                mesh.positions.push(match backing {
                    Backing::Plane { z } => Point::new(at.x, at.y, z),
                    Backing::Behind { depth } => at - behind * depth,
                });
            }
        }
        let count = rows.len() as u32;
        for row in 1..count {
            strip(&mut mesh, (row - 1) * size, row * size, size, false, true);
            strip(&mut mesh, face + (row - 1) * size, face + row * size, size, false, false);
        }
        let mut wall = |a: u32, b: u32| {
            // a to b along the rim with the face on the left.
            mesh.triangles.push([b, a, face + a]);
            mesh.triangles.push([b, face + a, face + b]);
        };
        for i in 1..size {
            wall(i - 1, i);
            wall((count - 1) * size + i, (count - 1) * size + i - 1);
        }
        for j in 1..count {
            wall(j * size - 1, (j + 1) * size - 1);
            wall(j * size, (j - 1) * size);
        }
        let mut measured = 0.0_f64;
        for j in 1..rows.len() {
            for i in 1..columns.len() {
                for [s, t] in [[0.5, 0.5], [0.5, 0.0], [0.0, 0.5], [0.5, 1.0], [1.0, 0.5]] {
                    let at = |a: usize, b: usize| mesh.positions[b * columns.len() + a].coords;
                    // On the diagonal of the first corner, and on the four sides.
                    let low = at(i - 1, j - 1) * (1.0 - s) + at(i, j - 1) * s;
                    let high = at(i - 1, j) * (1.0 - s) + at(i, j) * s;
                    let p = if s == 0.5 && t == 0.5 {
                        (at(i - 1, j - 1) + at(i, j)) * 0.5
                    } else {
                        low * (1.0 - t) + high * t
                    };
                    let start =
                        [u(columns[i - 1] * (1.0 - s) + columns[i] * s), v(rows[j - 1] * (1.0 - t) + rows[j] * t)];
                    measured = measured.max(near_distance(surface, &Point::from(p), start, allowance));
                }
            }
        }
        left = measured;
        if left <= 0.95 * chord_error {
            return Ok(MeasuredMesh { mesh, measured });
        }
        error *= (0.8 * chord_error / left).clamp(0.2, 0.8);
    }
    Err(MeshingError::NotReached { asked_mm: chord_error, measured_mm: left })
}
