//! The part across the feed at a contact, and the roughness that adjacent rows leave there.
//!
//! ```text
//!        N
//!        |    y_-1        y_0 = 0       y_1      contacts of the rows, d apart on the surface
//!   _____|_____.____________.____________.____   height of the surface over y, in the plane of N and
//!                                                y = N x feed
//!
//!   Z_i = min_m shadow_m(y_i) - height(y_i)      shadow: the section that a cutter leaves as it moves along
//!                                                the feed
//!   Ra  = mean |Z_i - line|                      (16), about the least-squares line, over the evaluation
//!                                                length
//! ```
//!
//! Each row's cutter leans as the one at the middle does, each from its own normal. Marks of single teeth
//! along the feed (0.07 um with the paper's data) are left out. Beyond a rim of the surface its last
//! curvature goes on.

use proveout_geom::{Point, Vector};

use super::{
    super::{ContactPoint, ContactSurface},
    bull_nose::{BullNose, Rim, Shadow},
};

/// Spacing of heights, mm, and how far they reach beyond half of the evaluation length and one row.
const NODE: f64 = 0.25;
const REACH: f64 = 2.0;
/// Steps in which the surface is met along N.
const STEPS: usize = 30;
/// Where the surface is looked for at a rim along the feed, mm.
const BESIDE: [f64; 5] = [0.0, 0.02, -0.02, 0.1, -0.1];
/// How near to a place over y the boundary of a shadow is followed, mm: its tangent takes the rest, to 1e-11
/// mm.
const NEAR_Y: f64 = 1e-5;
/// Width of the Gaussian filter, `sqrt(ln 2 / pi)`, and how far its window reaches, as a part of the cutoff:
/// beyond, a ten-millionth of the weight is left.
const ALPHA: f64 = 0.469_718_639_349_825_66;
const FILTER_REACH: f64 = 1.0;
/// Cutoff of the profile filter for Ra from 0.1 to 2 um (ISO 21920-3), mm.
pub(super) const CUTOFF: f64 = 0.8;
/// Spacing of the points of a profile, mm.
const POINT: f64 = 0.02;
/// A feed whose part across the normal is shorter than this has no direction.
const ALONG_NORMAL: f64 = 1e-9;
/// Step over y by which the slope of heights is taken, mm.
const SLOPE_STEP: f64 = 1e-3;
/// Step of the height at which the surface is met, mm.
const MET_MM: f64 = 1e-9;
/// Least change of y with the slope of a rim, mm/radian: a turn stays finite.
const LEAST_RATE: f64 = 1e-6;

/// The frame of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactFrame {
    /// The contact.
    pub point: Point,
    /// Feed, normal x feed, normal: unit vectors.
    pub axes: [Vector; 3],
}

impl ContactFrame {
    /// Frame of a contact from its normal and a direction of feed that need not be tangent; none if
    /// the feed is along the normal.
    pub fn new(point: Point, normal: Vector, feed: Vector) -> Option<Self> {
        let feed = (feed - normal * feed.dot(&normal)).try_normalize(ALONG_NORMAL)?;
        Some(Self { point, axes: [feed, normal.cross(&feed), normal] })
    }

    /// A direction in this frame.
    pub fn local(&self, v: &Vector) -> Vector {
        Vector::new(v.dot(&self.axes[0]), v.dot(&self.axes[1]), v.dot(&self.axes[2]))
    }

    /// A direction of this frame in that of the run.
    pub fn global(&self, v: &Vector) -> Vector {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }
}

/// Tool axis in the frame of a contact with an inclination to the normal and an azimuth of the lean from the
/// feed, radian ((2) with (1)).
pub fn leaned(inclination: f64, azimuth: f64) -> Vector {
    let (s, c) = inclination.sin_cos();
    Vector::new(s * azimuth.cos(), s * azimuth.sin(), c)
}

/// Contact of a row in the section: its place and its frame, in the frame of the middle one.
#[derive(Clone, Copy, Debug)]
struct RowContact {
    y: f64,
    at: Vector,
    frame: [Vector; 3],
}

/// The section with the contacts of the rows in it.
#[derive(Clone, Debug)]
pub struct CrossSection {
    heights: Vec<f64>,
    rows: Vec<RowContact>,
    length: f64,
}

impl CrossSection {
    /// The section at a contact, with rows `distance` mm apart on the surface over the evaluation length
    /// (mm).
    pub fn new(surface: &dyn ContactSurface, frame: &ContactFrame, distance: f64, length: f64) -> Self {
        let half = 0.5 * length + distance + REACH;
        let count = (half / NODE).ceil() as usize;
        let mut heights = vec![0.0; 2 * count + 1];
        for side in [1, -1] {
            let mut from = 0.0;
            for k in 1..=count as i64 {
                let y = NODE * (side * k) as f64;
                let index = |k: i64| (count as i64 + side * k) as usize;
                let z = met(surface, frame, y, from).unwrap_or_else(|| {
                    // The parabola of the last three goes on.
                    let behind = |j: i64| heights.get(index(k - j)).copied().unwrap_or(0.0);
                    if k >= 3 { 3.0 * behind(1) - 3.0 * behind(2) + behind(3) } else { behind(1) }
                });
                heights[index(k)] = z;
                from = z;
            }
        }
        let mut section = Self { heights, rows: Vec::new(), length };
        section.rows.push(section.contact(surface, frame, 0.0));
        for side in [1.0, -1.0] {
            let (mut y, mut z) = (0.0_f64, 0.0_f64);
            while y.abs() < 0.5 * (length + distance) + FILTER_REACH * CUTOFF {
                // So far along y that the way on the surface is the distance.
                let mut step = distance;
                for _ in 0..20 {
                    let rise = section.height(y + side * step) - z;
                    step *= distance / step.hypot(rise);
                }
                y += side * step;
                z = section.height(y);
                let contact = section.contact(surface, frame, y);
                section.rows.push(contact);
            }
        }
        section.rows.sort_by(|a, b| a.y.total_cmp(&b.y));
        section
    }

    /// Height over y, by a cubic through the four nearest nodes; beyond the last ones theirs goes on.
    pub fn height(&self, y: f64) -> f64 {
        let middle = (self.heights.len() / 2) as f64;
        let place = (y / NODE + middle).max(0.0);
        let first = (place.floor() as usize).saturating_sub(1).min(self.heights.len().saturating_sub(4));
        let Some(&[a, b, c, d]) = self.heights.get(first..first + 4) else { return 0.0 };
        let t = place - first as f64 - 1.0;
        a * (-t * (t - 1.0) * (t - 2.0) / 6.0)
            + b * ((t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0)
            + c * (-(t + 1.0) * t * (t - 2.0) / 2.0)
            + d * ((t + 1.0) * t * (t - 1.0) / 6.0)
    }

    fn contact(&self, surface: &dyn ContactSurface, frame: &ContactFrame, y: f64) -> RowContact {
        let z = self.height(y);
        let slope = (self.height(y + SLOPE_STEP) - self.height(y - SLOPE_STEP)) / (2.0 * SLOPE_STEP);
        let flat = Vector::new(0.0, -slope, 1.0).normalize();
        let place = frame.point + frame.axes[1] * y + frame.axes[2] * z;
        let normal = reached(surface, frame, &place).map_or(flat, |c| frame.local(&c.normal));
        // The middle one is the frame itself, to the last bit.
        let axes = ContactFrame::new(Point::origin(), normal, Vector::x()).filter(|_| y != 0.0);
        let axes = axes.map_or([Vector::x(), Vector::y(), Vector::z()], |f| f.axes);
        RowContact { y, at: Vector::new(0.0, y, z), frame: axes }
    }

    /// Ra of the section that rows with this cutter leave, mm; `t` is the tool axis in the frame of the
    /// middle contact.
    pub fn roughness(&self, tool: &BullNose, t: &Vector) -> f64 {
        mean_deviation(&self.profile(tool, t, 0.0))
    }

    /// The same after the profile filter of ISO 16610-21 with its cutoff (nesting index), mm: form
    /// and waviness are the Gaussian mean line, whose window reaches beyond the evaluation length
    /// (ISO 21920-2: Ra is that of the filtered profile).
    pub fn filtered_roughness(&self, tool: &BullNose, t: &Vector, cutoff: f64) -> f64 {
        let reach = FILTER_REACH * cutoff;
        let profile = self.profile(tool, t, reach);
        let within = |p: &&[f64; 2]| p[0].abs() <= 0.5 * self.length;
        let rest = profile.iter().filter(within).map(|at| (at[1] - mean_line(&profile, at[0], cutoff)).abs());
        rest.sum::<f64>() / profile.iter().filter(within).count().max(1) as f64
    }

    /// Heights over the surface of what rows leave, `[y, z]`, over the evaluation length and so far beyond
    /// both its ends, mm.
    fn profile(&self, tool: &BullNose, t: &Vector, beyond: f64) -> Vec<[f64; 2]> {
        let shadow = |r: &RowContact| {
            let axis = r.frame[0] * t.x + r.frame[1] * t.y + r.frame[2] * t.z;
            tool.shadow(&r.at, &r.frame[2], &axis)
        };
        let shadows: Vec<Shadow> = self.rows.iter().map(shadow).collect();
        let mut rims: Vec<Rim> =
            shadows.iter().zip(&self.rows).map(|(s, r)| s.at(-r.frame[2].y.atan2(r.frame[2].z))).collect();
        let length = self.length + 2.0 * beyond;
        let count = (length / POINT).round().max(2.0) as usize;
        let mut profile = Vec::with_capacity(count);
        let mut near = 0;
        for i in 0..count {
            let y = length * ((i as f64 + 0.5) / count as f64 - 0.5);
            while near + 1 < self.rows.len() && (self.rows[near + 1].y - y).abs() < (self.rows[near].y - y).abs() {
                near += 1;
            }
            let among = near.saturating_sub(1)..(near + 2).min(self.rows.len());
            let lowest = among.map(|m| shadow_height(&shadows[m], y, &mut rims[m])).fold(f64::INFINITY, f64::min);
            profile.push([y, lowest - self.height(y)]);
        }
        profile
    }
}

/// The Gaussian mean line of a profile at a place (ISO 16610-21): weights `exp(-pi (y / (alpha cutoff))^2)`
/// that let half of a wave of the cutoff through.
pub fn mean_line(profile: &[[f64; 2]], y: f64, cutoff: f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for [at, z] in profile.iter().filter(|p| (p[0] - y).abs() <= FILTER_REACH * cutoff) {
        let part = (at - y) / (ALPHA * cutoff);
        let weight = (-std::f64::consts::PI * part * part).exp();
        (sum, weights) = (sum + weight * z, weights + weight);
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// The contact at a place, or a little along the feed where the place is beyond a rim there: the surface lies
/// along the feed, so that it is as high to the second order.
fn reached(surface: &dyn ContactSurface, frame: &ContactFrame, p: &Point) -> Option<ContactPoint> {
    BESIDE.into_iter().find_map(|way| surface.contact(&(p + frame.axes[0] * way)))
}

/// Height along N at which the surface is met at y; none beyond a rim.
fn met(surface: &dyn ContactSurface, frame: &ContactFrame, y: f64, from: f64) -> Option<f64> {
    let [_, across, normal] = &frame.axes;
    let mut z = from;
    for _ in 0..STEPS {
        let p = frame.point + across * y + normal * z;
        let contact = reached(surface, frame, &p)?;
        let upright = contact.normal.dot(normal);
        if upright < 0.1 {
            return None;
        }
        let step = (contact.point - p).dot(&contact.normal) / upright;
        z += step;
        if step.abs() < MET_MM {
            return Some(z);
        }
    }
    None
}

/// Height of the shadow of a row's cutter over y: Newton's method on the slope of its boundary, from the
/// place before on.
fn shadow_height(shadow: &Shadow, y: f64, at: &mut Rim) -> f64 {
    for _ in 0..20 {
        let off = y - at.y;
        if off.abs() < NEAR_Y {
            break;
        }
        // The boundary of a convex shadow runs one way.
        let turn = (off / at.rate.max(LEAST_RATE)).clamp(-0.3, 0.3);
        *at = shadow.at((at.slope + turn).clamp(-1.5, 1.5));
    }
    at.z + (y - at.y) * at.rise
}

/// Mean distance of points from their least-squares line.
pub fn mean_deviation(profile: &[[f64; 2]]) -> f64 {
    let n = profile.len() as f64;
    let mean = |k: usize| profile.iter().map(|p| p[k]).sum::<f64>() / n;
    let (y, z) = (mean(0), mean(1));
    let (mut mixed, mut square) = (0.0, 0.0);
    for p in profile {
        mixed += (p[0] - y) * (p[1] - z);
        square += (p[0] - y) * (p[0] - y);
    }
    let slope = if square > 0.0 { mixed / square } else { 0.0 };
    profile.iter().map(|p| (p[1] - z - slope * (p[0] - y)).abs()).sum::<f64>() / n
}
