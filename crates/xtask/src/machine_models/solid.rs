//! Closed solids from a few numbers: blocks with chamfered edges, prisms, bodies of revolution. Lengths in
//! mm, faces outward. Solids that are put together keep their own shells and may run into each other.

use std::f64::consts::{PI, TAU};

/// A point or direction.
pub(crate) type V3 = [f64; 3];

pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scaled(a: V3, f: f64) -> V3 {
    a.map(|v| v * f)
}

fn sub(a: V3, b: V3) -> V3 {
    add(a, scaled(b, -1.0))
}

pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// One axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnitAxis {
    X,
    Y,
    Z,
}

impl UnitAxis {
    /// Unit vector.
    pub(crate) fn unit(self) -> V3 {
        let mut v = [0.0; 3];
        v[self as usize] = 1.0;
        v
    }

    /// Place of the outline point (a, b) at `t` along the axis: (y, z) along x, (z, x) along y, (x, y) along
    /// z.
    fn place(self, [a, b]: [f64; 2], t: f64) -> V3 {
        match self {
            Self::X => [t, a, b],
            Self::Y => [b, t, a],
            Self::Z => [a, b, t],
        }
    }
}

/// Facets of a full circle. They touch it from outside, so no body is smaller than the real one: the
/// corners of a spindle nose of 100 mm protrude by 0.05 mm, those of a table of 600 mm by 0.29 mm.
const SECTORS: usize = 72;

/// Radius of the corners of a polygon that touches a circle from outside, `half` being half the angle of a
/// facet.
fn outer(radius: f64, half: f64) -> f64 {
    // A model keeps four decimals in single precision, which must not bring a facet inside.
    radius / half.cos() + 1e-4
}

/// Triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SolidMesh {
    pub(crate) points: Vec<V3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl SolidMesh {
    /// The same with another solid; shells stay apart.
    #[must_use]
    pub(crate) fn and(mut self, other: Self) -> Self {
        let base = self.points.len() as u32;
        self.points.extend(other.points);
        self.triangles.extend(other.triangles.into_iter().map(|t| t.map(|i| i + base)));
        self
    }

    /// All of them together.
    pub(crate) fn all(parts: impl IntoIterator<Item = Self>) -> Self {
        parts.into_iter().fold(Self::default(), Self::and)
    }

    /// Moved.
    #[must_use]
    pub(crate) fn at(mut self, by: V3) -> Self {
        for p in &mut self.points {
            *p = add(*p, by);
        }
        self
    }

    /// Turned by a quarter about z: x becomes y.
    #[must_use]
    pub(crate) fn quarter_turned(mut self) -> Self {
        for p in &mut self.points {
            *p = [-p[1], p[0], p[2]];
        }
        self
    }

    /// With y and z exchanged by a turn about x: z becomes y, y becomes -z.
    #[must_use]
    pub(crate) fn laid_back(mut self) -> Self {
        for p in &mut self.points {
            *p = [p[0], p[2], -p[1]];
        }
        self
    }

    /// Adds a plane convex face, turned so that it looks away from `inside`.
    fn face(&mut self, corners: &[u32], inside: V3) {
        let p = |k: usize| self.points[corners[k] as usize];
        let normal = cross(sub(p(1), p(0)), sub(p(2), p(0)));
        let outward = dot(normal, sub(p(0), inside)) > 0.0;
        for k in 1..corners.len() - 1 {
            let [a, b, c] = [corners[0], corners[k], corners[k + 1]];
            self.triangles.push(if outward { [a, b, c] } else { [a, c, b] });
        }
    }
}

/// A box with all edges chamfered by `chamfer`, at most a fifth of the smallest side.
pub(crate) fn block(min: V3, max: V3, chamfer: f64) -> SolidMesh {
    let side = (0..3).map(|k| max[k] - min[k]).fold(f64::INFINITY, f64::min);
    let c = chamfer.min(0.2 * side);
    let center = scaled(add(min, max), 0.5);
    let mut solid = SolidMesh::default();
    // Vertex 3 * corner + axis: the corner moved inward along the two other axes, thus on the face across
    // `axis`.
    for corner in 0..8 {
        for axis in 0..3 {
            let place = |k: usize| {
                let high = corner >> k & 1 == 1;
                let inward = if k == axis { 0.0 } else { c };
                if high { max[k] - inward } else { min[k] + inward }
            };
            solid.points.push([place(0), place(1), place(2)]);
        }
    }
    let vertex = |corner: usize, axis: usize| (3 * corner + axis) as u32;
    for axis in 0..3 {
        let (b, d) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in 0..2 {
            let corner = |i: usize, j: usize| side << axis | i << b | j << d;
            let around = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            solid.face(&around.map(|k| vertex(k, axis)), center);
        }
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let [low, high] = [0, 1].map(|s| s << axis | i << b | j << d);
            solid.face(&[vertex(low, b), vertex(high, b), vertex(high, d), vertex(low, d)], center);
        }
    }
    for corner in 0..8 {
        solid.face(&[0, 1, 2].map(|axis| vertex(corner, axis)), center);
    }
    solid
}

/// A simple outline, counter-clockwise, drawn out along an axis; it may be concave.
pub(crate) fn prism(along: UnitAxis, range: [f64; 2], outline: &[[f64; 2]]) -> SolidMesh {
    let n = outline.len() as u32;
    let mut solid = SolidMesh::default();
    for t in range {
        solid.points.extend(outline.iter().map(|&c| along.place(c, t)));
    }
    for k in 0..n {
        let next = (k + 1) % n;
        solid.triangles.extend([[k, next, n + next], [k, n + next, n + k]]);
    }
    for [a, b, c] in ears(outline) {
        solid.triangles.extend([[a, c, b], [n + a, n + b, n + c]]);
    }
    solid
}

/// Triangles of a simple counter-clockwise polygon, by cutting ears.
fn ears(outline: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let mut triangles = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&k| {
            let [i, j, l] = [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
            let [a, b, c] = [outline[i], outline[j], outline[l]];
            turn(a, b, c) > 0.0
                && left.iter().filter(|&&m| m != i && m != j && m != l).all(|&m| {
                    let p = outline[m];
                    turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0
                })
        });
        let Some(k) = ear else { break };
        triangles.push([left[(k + n - 1) % n], left[k], left[(k + 1) % n]].map(|i| i as u32));
        left.remove(k);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c].map(|i| i as u32));
    }
    triangles
}

/// Two unit vectors that make a right-handed frame with a unit vector.
fn across(axis: V3) -> [V3; 2] {
    let start = if axis[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = sub(start, scaled(axis, dot(start, axis)));
    let u = scaled(u, 1.0 / dot(u, u).sqrt());
    [u, cross(axis, u)]
}

/// Profile `[radius, height]` turned about the line through `foot` along `axis`; it runs from the line to the
/// line, upward on the outside.
pub(crate) fn revolved(foot: V3, axis: V3, profile: &[[f64; 2]]) -> SolidMesh {
    let [u, v] = across(axis);
    let mut solid = SolidMesh::default();
    let [Some(first), Some(last)] = [profile.first(), profile.last()] else { return solid };
    let inner = &profile[1..profile.len() - 1];
    let on_line = |h: f64| add(foot, scaled(axis, h));
    solid.points.push(on_line(first[1]));
    for &[r, h] in inner {
        let r = outer(r, PI / SECTORS as f64);
        solid.points.extend((0..SECTORS).map(|k| {
            let (s, c) = (TAU * k as f64 / SECTORS as f64).sin_cos();
            add(on_line(h), add(scaled(u, r * c), scaled(v, r * s)))
        }));
    }
    solid.points.push(on_line(last[1]));
    let (n, rings) = (SECTORS as u32, inner.len() as u32);
    let top = solid.points.len() as u32 - 1;
    let at = |ring: u32, k: u32| 1 + ring * n + k % n;
    for k in 0..n {
        solid.triangles.push([0, at(0, k + 1), at(0, k)]);
        for ring in 0..rings - 1 {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            solid.triangles.extend([[a, b, c], [a, c, d]]);
        }
        solid.triangles.push([top, at(rings - 1, k), at(rings - 1, k + 1)]);
    }
    solid
}

/// A cylinder with chamfered ends.
pub(crate) fn cylinder(foot: V3, axis: V3, radius: f64, height: f64, chamfer: f64) -> SolidMesh {
    let c = chamfer.min(0.3 * height).min(0.5 * radius).max(0.1);
    let profile =
        [[0.0, 0.0], [radius - c, 0.0], [radius, c], [radius, height - c], [radius - c, height], [0.0, height]];
    revolved(foot, axis, &profile)
}

/// Outline of a plate: from `width` at `base` to a round end of `radius` about (0, `center`),
/// counter-clockwise in the plane (across, up). The base may be above or below the round end.
pub(crate) fn tongue(half_width: f64, base: f64, center: f64, radius: f64) -> Vec<[f64; 2]> {
    const ARC: usize = 12;
    let side = if center > base { 1.0 } else { -1.0 };
    let mut outline = vec![[-half_width, base], [half_width, base]];
    if side < 0.0 {
        outline.reverse();
    }
    outline.extend((0..=ARC).map(|k| {
        let (s, c) = (PI * k as f64 / ARC as f64).sin_cos();
        let radius = outer(radius, 0.5 * PI / ARC as f64);
        [side * radius * c, center + side * radius * s]
    }));
    outline
}

/// A round plate with straight T-slot grooves along x: face at `face`, from `face - thickness` upward.
pub(crate) fn slotted_disc(center: [f64; 2], radius: f64, face: f64, thickness: f64, slots: usize) -> SolidMesh {
    let [cx, cy] = center;
    let depth = 0.5 * thickness;
    let width = (0.06 * radius).min(18.0);
    let pitch = 2.0 * radius / (slots as f64 + 1.0);
    let mut solid = cylinder([cx, cy, face - thickness], UnitAxis::Z.unit(), radius - 1.0, thickness - depth, 4.0);
    let mut low = -radius;
    for k in 0..=slots {
        let high = if k == slots { radius } else { pitch * (k as f64 + 1.0) - radius - 0.5 * width };
        let mut outline = Vec::new();
        let arc = |from: f64, to: f64, outline: &mut Vec<[f64; 2]>| {
            // Equal angles; the outline closes on itself where the two sides meet, so that no two points fall
            // together.
            let [first, last] = [from, to].map(|y| (y / radius).clamp(-1.0, 1.0).asin());
            let radius = outer(radius, (last - first) / 16.0);
            let [first, last] = [from, to].map(|y| (y / radius).clamp(-1.0, 1.0).asin());
            for i in 0..=8 {
                let (y, x) = (first + (last - first) * f64::from(i) / 8.0).sin_cos();
                outline.push([radius * x, radius * y]);
            }
        };
        arc(low.max(-radius + 0.2), high.min(radius - 0.2), &mut outline);
        let mirrored: Vec<[f64; 2]> = outline.iter().rev().map(|&[x, y]| [-x, y]).collect();
        outline.extend(mirrored);
        let outline: Vec<[f64; 2]> = outline.iter().map(|&[x, y]| [cx + x, cy + y]).collect();
        solid = solid.and(prism(UnitAxis::Z, [face - depth - 1.0, face], &outline));
        low = high + width;
    }
    solid
}

/// A rectangular plate with T-slot grooves along x; its face is `max[2]`.
pub(crate) fn slotted_plate(min: V3, max: V3, slots: usize) -> SolidMesh {
    let depth = 0.4 * (max[2] - min[2]);
    let width = 18.0;
    let pitch = (max[1] - min[1]) / (slots as f64 + 1.0);
    let mut solid = block(min, [max[0], max[1], max[2] - depth], 5.0);
    let mut low = min[1];
    for k in 0..=slots {
        let high = if k == slots { max[1] } else { min[1] + pitch * (k as f64 + 1.0) - 0.5 * width };
        solid = solid.and(block([min[0], low, max[2] - depth - 6.0], [max[0], high, max[2]], 1.5));
        low = high + width;
    }
    solid
}

/// Two rails of `width` x `height` along an axis, at `offset` to both sides of `middle`.
///
/// `from` and `to` are opposite corners of the space that one rail at offset zero takes.
pub(crate) fn rail_pair(from: V3, to: V3, offset: V3) -> SolidMesh {
    let one = |sign: f64| block(add(from, scaled(offset, sign)), add(to, scaled(offset, sign)), 2.0);
    one(-1.0).and(one(1.0))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Signed volume; each directed edge once and its opposite once.
    fn volume(solid: &SolidMesh) -> f64 {
        let mut edges = BTreeMap::new();
        let mut volume = 0.0;
        for t in &solid.triangles {
            let [a, b, c] = t.map(|i| solid.points[i as usize]);
            volume += dot(a, cross(b, c)) / 6.0;
            for (i, j) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                assert!(edges.insert((i, j), ()).is_none(), "edge {i} {j} twice");
            }
        }
        assert!(edges.keys().all(|(i, j)| edges.contains_key(&(*j, *i))), "open edge");
        volume
    }

    #[test]
    fn a_block_is_its_box_less_the_chamfers() {
        let (a, b, c, s) = (10.0, 20.0, 30.0, 1.0);
        // Each edge loses a triangular prism of s²/2 between the corners; each corner a cube less its inner
        // tetrahedra: the corner cut by the plane through the three chamfer ends leaves s³/6 of the cube of
        // side s.
        let edges = 4.0 * 0.5 * s * s * ((a - 2.0 * s) + (b - 2.0 * s) + (c - 2.0 * s));
        let corners = 8.0 * (s * s * s) * (1.0 - 1.0 / 6.0);
        let solid = block([-3.0, 4.0, 5.0], [7.0, 24.0, 35.0], s);
        assert!((volume(&solid) - (a * b * c - edges - corners)).abs() < 1e-9, "{}", volume(&solid));
    }

    #[test]
    fn a_concave_prism_has_the_area_of_its_outline() {
        let outline =
            [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [6.0, 10.0], [6.0, 3.0], [4.0, 3.0], [4.0, 10.0], [0.0, 10.0]];
        for along in [UnitAxis::X, UnitAxis::Y, UnitAxis::Z] {
            assert!((volume(&prism(along, [-1.0, 4.0], &outline)) - 5.0 * 86.0).abs() < 1e-9);
        }
        for (base, center) in [(0.0, 50.0), (50.0, 0.0)] {
            let outline = tongue(20.0, base, center, 12.0);
            assert!(volume(&prism(UnitAxis::X, [0.0, 1.0], &outline)) > 0.5 * 50.0 * (40.0 + 24.0));
        }
    }

    #[test]
    fn a_turned_profile_stands_about_any_line() {
        let s = 0.5_f64.sqrt();
        // Area of the polygon that touches the circle of radius 5 from outside, and the circle itself.
        let radius = outer(5.0, PI / SECTORS as f64);
        let polygon = 0.5 * SECTORS as f64 * (TAU / SECTORS as f64).sin() * radius * radius;
        assert!(polygon > PI * 25.0 && polygon < PI * 25.0 * 1.001, "{polygon}");
        for axis in [[0.0, 0.0, 1.0], [0.0, s, s], [-1.0, 0.0, 0.0]] {
            let solid = revolved([1.0, 2.0, 3.0], axis, &[[0.0, 0.0], [5.0, 0.0], [5.0, 8.0], [0.0, 8.0]]);
            assert!((volume(&solid) - polygon * 8.0).abs() < 1e-9);
            let heights: Vec<f64> = solid.points.iter().map(|p| dot(sub(*p, [1.0, 2.0, 3.0]), axis)).collect();
            assert!(heights.iter().all(|h| (-1e-9..8.0 + 1e-9).contains(h)));
        }
        assert!(volume(&cylinder([0.0; 3], [0.0, 1.0, 0.0], 5.0, 8.0, 1.0)) < polygon * 8.0);
    }

    #[test]
    fn slotted_faces_have_grooves_and_the_stated_height() {
        for solid in [
            slotted_disc([5.0, 0.0], 250.0, -140.0, 40.0, 5),
            slotted_plate([-400.0, -200.0, -180.0], [400.0, 200.0, -140.0], 5),
        ] {
            assert!(volume(&solid) > 0.0);
            let top = solid.points.iter().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
            assert_eq!(top, -140.0);
            // No part of the face lies on the line of the middle slot.
            let on_face = solid.points.iter().filter(|p| p[2] == -140.0);
            assert!(on_face.clone().count() > 20 && on_face.clone().all(|p| p[1].abs() > 3.0));
        }
    }

    #[test]
    fn quarter_turns_keep_solids_right_side_out() {
        let solid = block([1.0, 2.0, 3.0], [4.0, 6.0, 8.0], 0.5);
        for turned in [solid.clone().quarter_turned(), solid.clone().laid_back()] {
            assert!((volume(&turned) - volume(&solid)).abs() < 1e-9);
        }
    }
}
