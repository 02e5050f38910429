//! Going down into material with a tool that has no edges at the center of its end.
//!
//! Round the axis such an end has a region that no edge sweeps. Where the tool goes down, a stub of material
//! stays under it:
//!
//! ```text
//!       |  .  |              |   |  .  |   |
//!       |  .  |              | / |  .  |   |     a ramp leaves a stub as high as the way down
//!     __|__.__|__            |/__|__.__|___|     while the region stays over a place; the edges
//!    |  |_____|  |          /       |_|          that follow take it away. Straight down it
//!    |    |_|    |                               grows until the body of the tool rests on it.
//! ```
//!
//! How wide the region is and how far it is set back is not stated, except as the steepest ramp
//! that the maker allows (`max_ramp_angle_deg`). What the twin sees is whether a thin core round
//! the axis, at the height of the tip, goes down into material: by the volume that it meets, over
//! the area that it goes over. Then
//!
//! * the way down of the block is held to that angle, or, where none is stated, to 45 degrees: no ramp is
//!   steeper (chosen);
//! * the way down while the axis has not left a circle of the cutter's radius R about its place is held to
//!   what the angle gives over 3 R. So far goes a ramp to and fro that turns within R of a place: in to the
//!   turn and back, R + 2 R. A helix narrower than the tool's own center goes farther, and leaves a pillar
//!   however slowly it goes down.
//!
//! The radius of the region is a key of the tool (`dead_center_diameter_mm`). With it the way down while the
//! region covers one place is held to what the angle gives over 4.5 of its radii: in to a turn and back.
//! Without it the region is taken for as wide as half of the cutter's radius: a helix that keeps it over one
//! place and goes down farther is not known to be allowed.
//!
//! A flatter way of a tool without a stated angle, and any way down of a flat end of which it is
//! not stated whether it cuts at its center, is not known to be allowed: the gate is then
//! unchecked.

use std::collections::VecDeque;

use proveout_controller::Piece;
use proveout_geom::{Point, ToolPose};
use proveout_stock::SweepReport;
use proveout_tool::{Profile, ProfileError, Segment, Tool};

/// Radius of the core in cells of the stock: some seven rays go through it.
const CORE_CELLS: f64 = 1.5;
/// Largest radius of the core as a part of that of the cutter.
const CORE_PART: f64 = 0.5;
/// Ways that are steeper than this are no ramps, radian.
const STEEPEST_RAMP: f64 = std::f64::consts::FRAC_PI_4;
/// A ramp may be steeper than the stated angle by this, radian: degrees of a text with three digits.
const THREE_DIGITS: f64 = 1e-5;
/// Most parts of one piece of a motion at whose ends the material below is noted.
const MOST_PARTS: f64 = 1e4;

/// The core of a tool that has to be watched, for a stock of these cells (mm); none of a tool that cuts at
/// its center.
pub(crate) fn core(tool: &Tool, cell: f64) -> Option<Profile> {
    if tool.cuts_at_center() == Some(true) {
        return None;
    }
    let radius = (CORE_CELLS * cell).min(CORE_PART * cutter_radius(tool));
    disc(radius).ok()
}

/// Whether rays of a stock of these cells (mm) go through a core of some radius, mm.
pub(crate) fn is_seen(radius: f64, cell: f64) -> bool {
    radius >= 0.999 * CORE_CELLS * cell
}

/// What a core meets, by the measure of the rays, where it goes a way down in material and another across,
/// mm.
pub(crate) fn volume(radius: f64, aside: f64, down: f64) -> f64 {
    area(radius, aside) * down / SETS
}

/// What a core goes over.
fn area(radius: f64, aside: f64) -> f64 {
    2.0 * radius * aside + std::f64::consts::PI * radius * radius
}

fn disc(r: f64) -> Result<Profile, ProfileError> {
    // As thin as it is wide, so that rays across meet it as well.
    let line = |from, to| Segment::Line { from, to };
    Profile::new(vec![line([0.0, 0.0], [r, 0.0]), line([r, 0.0], [r, r]), line([r, r], [0.0, r])])
}

fn cutter_radius(tool: &Tool) -> f64 {
    tool.cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max)
}

/// Step across the axis in which a long piece is followed, in radii of the region without edges.
const STEP: f64 = 0.1;
/// Places of the axis nearer than this, in radii of the region without edges, count as one.
const NEAR: f64 = 0.1;
/// Steps in which the middle of places is found.
const MIDDLES: usize = 48;
/// Sets of rays of a stock.
const SETS: f64 = 3.0;
/// Longest way of a ramp within the cutter's radius of a place, in radii.
const TO_AND_FRO: f64 = 3.0;

/// Way along the tool's own axis towards the material, and across it, mm.
pub(crate) fn way_down([from, to]: &[ToolPose; 2]) -> (f64, f64) {
    let (way, axis) = (to.tip - from.tip, (from.axis + to.axis).normalize());
    let along = way.dot(&axis);
    (-along, (way - axis * along).norm())
}

/// Radii of the region without edges that a ramp goes while it covers a place: in to a turn and back, and the
/// steps of the watch.
const IN_AND_BACK: f64 = 4.5;
/// Radius of the region without edges where no key gives it, as a part of the cutter's radius.
const USUAL_DEAD_CENTER: f64 = 0.5;
/// Most of a way down that the rounding of a corner of the path adds to a block, mm.
const ROUNDED: f64 = 0.1;

/// How a tool goes down into material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Descent {
    /// Of the block so far, radian against the plane across the axis.
    pub(crate) angle: f64,
    /// The steeper of this angle and that of the block before, which has gone down a part of the pillar,
    /// radian.
    pub(crate) steepest: f64,
    /// Ways of the block down and aside so far, mm.
    pub(crate) way: [f64; 2],
    /// Way down while the region without edges covers one place, mm.
    pub(crate) pillar: f64,
    /// Way down while the axis has not left a circle of the cutter's radius, mm.
    pub(crate) stub: f64,
}

/// What a descent of a tool means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Judgement {
    /// Not allowed; the limit of the angle, radian, and of the stub, mm.
    Fault {
        angle: f64,
        stub: f64,
    },
    /// Not known to be allowed.
    Unknown,
    Allowed,
}

impl Descent {
    /// The same for a block that has not ended yet: part of the way down may come from the rounding of its
    /// first corner. The block is judged again with its programmed slope when it ends.
    pub(crate) fn without_rounding(self) -> Self {
        let [down, aside] = self.way;
        let angle = (down - ROUNDED).max(0.0).atan2(aside).min(self.angle);
        if aside > 0.0 { Self { angle, ..self } } else { self }
    }

    /// The same with the slope of the block as it is programmed, radian, where the path is steeper by no more
    /// than the rounding of its corners makes it.
    pub(crate) fn with_slope(self, slope: Option<f64>) -> Self {
        let [down, aside] = self.way;
        match slope {
            Some(slope) if slope > 0.0 && self.angle > slope && down - aside * slope.tan() <= ROUNDED => {
                Self { angle: slope, steepest: if self.steepest > self.angle { self.steepest } else { slope }, ..self }
            }
            _ => self,
        }
    }

    /// What the tool's own data say; `contact` is what counts as touching, mm.
    pub(crate) fn judged(&self, tool: &Tool, contact: f64) -> Judgement {
        let angle = tool.max_ramp_angle.unwrap_or(STEEPEST_RAMP);
        let flat = self.angle <= angle + THREE_DIGITS;
        let stub = match tool.dead_center {
            Some(radius) => IN_AND_BACK * radius * angle.tan() + contact,
            None => TO_AND_FRO * cutter_radius(tool) * angle.tan() + contact,
        };
        let within = flat && if tool.dead_center.is_some() { self.pillar <= stub } else { self.stub <= stub };
        let usual = IN_AND_BACK * USUAL_DEAD_CENTER * cutter_radius(tool) * self.steepest.tan() + contact;
        match tool.cuts_at_center() {
            Some(true) => Judgement::Allowed,
            None => Judgement::Unknown,
            Some(false) if !within => Judgement::Fault { angle, stub },
            Some(false) if tool.max_ramp_angle.is_none() => Judgement::Unknown,
            Some(false) if tool.dead_center.is_none() && self.pillar > usual => Judgement::Unknown,
            Some(false) => Judgement::Allowed,
        }
    }
}

/// Follows the tools that have to be watched.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlungeWatch {
    tool: Option<usize>,
    block: u32,
    /// Ways of the block in material, mm; what is less than touching is carried into the next block.
    down: f64,
    aside: f64,
    /// Angle of the last block that went down, radian.
    angle_before: f64,
    /// Way down in material with this tool, mm, and the places where it stood at less.
    sunk: f64,
    places: VecDeque<(Point, f64)>,
    /// The axis while the region without edges covers one place: places that lie apart, and what was sunk
    /// when it came there.
    covered: VecDeque<(Point, f64)>,
}

impl PlungeWatch {
    /// Takes a piece of motion, and what the core has met on it; its tool poses are those of any one frame.
    pub(crate) fn follow(
        &mut self,
        (index, tool): (usize, &Tool),
        piece: &Piece,
        met: Option<&SweepReport>,
        core: &Profile,
        contact: f64,
    ) -> Option<Descent> {
        if self.tool != Some(index) {
            *self = Self { tool: Some(index), block: piece.block, ..Self::default() };
        }
        if self.block != piece.block {
            if self.down > contact {
                self.angle_before = self.down.atan2(self.aside);
                (self.down, self.aside) = (0.0, 0.0);
            }
            self.block = piece.block;
        }
        let [from, to] = &piece.pose;
        let radius = cutter_radius(tool);
        let (down, aside) = way_down(&piece.pose);
        let Some(met) = met.filter(|r| r.rays > 0 && down > 0.0) else {
            self.leave_places(to, radius);
            return None;
        };
        let r = core.max_radius();
        let area = area(r, aside);
        // A layer that is thinner than a cell is seen by the rays along the axis alone, and volumes are means
        // over three sets of rays.
        let in_material = (SETS * met.volume_mm3 / area).min(down);
        let region = tool.dead_center.unwrap_or(USUAL_DEAD_CENTER * radius);
        let parts = (aside / (STEP * region)).ceil().clamp(1.0, MOST_PARTS);
        let (mut stub, mut pillar) = (0.0_f64, 0.0_f64);
        for k in 0..parts as usize {
            self.places.push_back((from.interpolated(to, k as f64 / parts).tip, self.sunk));
            let at = from.interpolated(to, k as f64 / parts);
            let pillar_from = self.cover(&at, region);
            self.sunk += in_material / parts;
            pillar = pillar.max(self.sunk - pillar_from);
            self.leave_places(&from.interpolated(to, (k + 1) as f64 / parts), radius);
            stub = stub.max(self.sunk - self.places.front().map_or(self.sunk, |(_, sunk)| *sunk));
        }
        self.down += in_material;
        self.aside += aside * in_material / down;
        let angle = self.down.atan2(self.aside);
        (self.down > contact || stub > contact).then(|| Descent {
            angle,
            steepest: angle.max(self.angle_before),
            way: [self.down, self.aside],
            pillar,
            stub,
        })
    }

    /// Takes a place of the axis, and gives what was sunk when the region of this radius came over a place
    /// that it still covers.
    fn cover(&mut self, at: &ToolPose, radius: f64) -> f64 {
        let across = |p: &Point, q: &Point| {
            let off = p - q;
            (off - at.axis * off.dot(&at.axis)).norm()
        };
        if !self.covered.iter().any(|(p, _)| across(p, &at.tip) < NEAR * radius) {
            self.covered.push_back((at.tip, self.sunk));
        }
        while self.covered.len() > 1 && farthest_from_middle(&self.covered, across) > radius {
            self.covered.pop_front();
        }
        self.covered.front().map_or(self.sunk, |(_, sunk)| *sunk)
    }

    /// Forgets the places up to the last one that is farther across the axis than the radius.
    fn leave_places(&mut self, to: &ToolPose, radius: f64) {
        let left = self.places.iter().rposition(|(p, _)| {
            let off = p - to.tip;
            (off - to.axis * off.dot(&to.axis)).norm() > radius
        });
        if let Some(last) = left {
            self.places.drain(..=last);
        }
    }
}

/// Radius of the least circle round places, across the axis: its middle goes to the farthest place by less
/// and less (Badoiu and Clarkson, *Smaller core-sets for balls*, 2003).
fn farthest_from_middle(places: &VecDeque<(Point, f64)>, across: impl Fn(&Point, &Point) -> f64) -> f64 {
    let Some(mut middle) = places.front().map(|(p, _)| *p) else { return 0.0 };
    let mut least = f64::INFINITY;
    for k in 1..=MIDDLES {
        let far = places.iter().map(|(p, _)| (across(p, &middle), p)).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((distance, p)) = far else { break };
        least = least.min(distance);
        middle += (p - middle) / (k + 1) as f64;
    }
    least
}

#[cfg(test)]
mod tests {
    use proveout_controller::MoveKind;
    use proveout_geom::{Vector, rad};
    use proveout_machine::JointValues;
    use proveout_tool::{Cutter, ToolBuilder};

    use super::*;

    const CONTACT: f64 = 0.01;

    fn tool(ramp_deg: Option<f64>) -> Tool {
        let builder =
            ToolBuilder::new(1, "HEAD", Cutter::flat(20.0).expect("cutter"), 10.0, 80.0).center_cutting(false);
        let builder = match ramp_deg {
            Some(angle) => builder.max_ramp_angle(rad(angle)),
            None => builder,
        };
        builder.build().expect("tool")
    }

    /// Worst judgement along tips in solid material, a block each or all in one.
    fn along(tool: &Tool, tips: &[[f64; 3]], one_block: bool) -> (Judgement, f64, f64) {
        let core = core(tool, 0.2).expect("it is watched");
        let (mut watch, mut worst) = (PlungeWatch::default(), (Judgement::Allowed, 0.0_f64, 0.0_f64));
        for (k, w) in tips.windows(2).enumerate() {
            let at = |p: [f64; 3]| ToolPose { tip: Point::from(p), axis: Vector::z() };
            let piece = Piece {
                time: [0.0, 1.0],
                block: if one_block { 0 } else { k as u32 },
                kind: MoveKind::Feed,
                joints: [JointValues::ZERO; 2],
                pose: [at(w[0]), at(w[1])],
                deviation: 0.0,
                edge_deviation: 0.0,
                joint_deviation: JointValues::ZERO,
                finer: None,
            };
            let (down, aside) = way_down(&piece.pose);
            let r = core.max_radius();
            // What a core meets in the layer that the way down adds.
            let volume = down.max(0.0) * (2.0 * r * aside + std::f64::consts::PI * r * r);
            let met = SweepReport { volume_mm3: volume, rays: 7, ..SweepReport::default() };
            let Some(descent) = watch.follow((0, tool), &piece, Some(&met), &core, CONTACT) else { continue };
            let judged = descent.judged(tool, CONTACT);
            if judged != Judgement::Allowed && !matches!(worst.0, Judgement::Fault { .. }) {
                worst.0 = judged;
            }
            (worst.1, worst.2) = (worst.1.max(descent.angle.to_degrees()), worst.2.max(descent.stub));
        }
        worst
    }

    fn line(to: [f64; 3], n: usize) -> Vec<[f64; 3]> {
        (0..=n).map(|k| to.map(|x| x * k as f64 / n as f64)).collect()
    }

    fn helix(radius: f64, pitch: f64, turns: f64) -> Vec<[f64; 3]> {
        let n = (turns * 36.0) as usize;
        let at = |k: usize| {
            let a = k as f64 / 36.0 * std::f64::consts::TAU;
            [radius * a.cos(), radius * a.sin(), -pitch * k as f64 / 36.0]
        };
        (0..=n).map(at).collect()
    }

    fn is_fault(j: Judgement) -> bool {
        matches!(j, Judgement::Fault { .. })
    }

    #[test]
    fn straight_down_is_a_fault_in_one_piece_or_a_thousand_blocks() {
        for n in [1, 10, 1000] {
            for ramp in [None, Some(3.0)] {
                let (judged, angle, stub) = along(&tool(ramp), &line([0.0, 0.0, -3.0], n), n != 10);
                assert!(is_fault(judged), "{n}");
                assert!((angle - 90.0).abs() < 1e-9 && (stub - 3.0).abs() < 1e-9, "{angle} {stub}");
            }
        }
    }

    #[test]
    fn ramps_are_held_to_the_stated_angle_and_unknown_without_one() {
        let ramp = |degrees: f64, n| line([60.0, 0.0, -60.0 * rad(degrees).tan()], n);
        for n in [1, 200] {
            assert_eq!(along(&tool(Some(3.0)), &ramp(2.9, n), true).0, Judgement::Allowed);
            assert!(is_fault(along(&tool(Some(3.0)), &ramp(3.1, n), true).0));
            assert_eq!(along(&tool(None), &ramp(2.9, n), true).0, Judgement::Unknown);
            assert!(is_fault(along(&tool(None), &ramp(50.0, n), true).0));
        }
        // To and fro: where it turns, the axis stays near a place for the way there and back.
        let mut fro: Vec<[f64; 3]> = Vec::new();
        for pass in 0..6 {
            let z = -60.0 * rad(2.9).tan();
            let mut leg = line([60.0, 0.0, z], 60);
            if pass % 2 == 1 {
                leg.iter_mut().for_each(|p| p[0] = 60.0 - p[0]);
            }
            leg.iter_mut().for_each(|p| p[2] += z * f64::from(pass));
            fro.extend(leg);
        }
        let (judged, _, stub) = along(&tool(Some(3.0)), &fro, false);
        assert_eq!(judged, Judgement::Allowed, "{stub}");
        assert!(stub > 15.0 * rad(2.9).tan(), "{stub}");
    }

    #[test]
    fn a_wide_helix_is_a_ramp_and_a_narrow_one_leaves_a_pillar() {
        let pitch = |radius: f64, degrees: f64| std::f64::consts::TAU * radius * rad(degrees).tan();
        assert_eq!(along(&tool(Some(3.0)), &helix(9.0, pitch(9.0, 2.0), 3.0), true).0, Judgement::Allowed);
        assert!(is_fault(along(&tool(Some(3.0)), &helix(9.0, pitch(9.0, 4.0), 3.0), true).0));
        // Two millimeters round: over any place for all of its way.
        let (judged, angle, stub) = along(&tool(Some(3.0)), &helix(2.0, pitch(2.0, 2.0), 8.0), true);
        assert!(is_fault(judged) && angle < 2.1 && stub > 3.0, "{angle} {stub}");
    }

    #[test]
    fn a_helix_that_keeps_the_region_without_edges_over_its_middle_leaves_a_pillar() {
        let pitch = |radius: f64, degrees: f64| std::f64::consts::TAU * radius * rad(degrees).tan();
        let of = |dead: Option<f64>, radius: f64, turns: f64| {
            let plain = tool(Some(10.0));
            let head = Tool { dead_center: dead, ..plain };
            along(&head, &helix(radius, pitch(radius, 6.0), turns), true).0
        };
        for dead in [1.0, 2.5, 4.0] {
            for radius in [0.5, 0.8, 1.3, 2.0, 5.0, 8.0] {
                let judged = of(Some(dead), dead * radius, 6.0);
                // Six turns at 6 degrees are 4 radii of the helix, and the ramp of 10 degrees leaves 0.7
                // radii of the region.
                let covers = radius < 1.0;
                assert_eq!(is_fault(judged), covers, "{dead} {radius}: {judged:?}");
            }
        }
        // Without the key, a helix about its own middle is open, and a wide one a ramp.
        assert_eq!(of(None, 3.0, 2.0), Judgement::Unknown);
        assert_eq!(of(None, 7.0, 2.0), Judgement::Allowed);
    }

    #[test]
    fn the_angle_is_that_of_the_block_where_the_path_is_rounded() {
        let measured = Descent { angle: 0.05, steepest: 0.05, way: [0.1, 2.0], pillar: 0.1, stub: 0.1 };
        let slope = 0.045_f64;
        assert_eq!(measured.with_slope(Some(slope)).angle, slope);
        assert_eq!(measured.with_slope(None).angle, 0.05);
        // A way down that no rounding explains stays as it is measured.
        let steep = Descent { angle: 1.0, steepest: 1.0, way: [3.0, 2.0], pillar: 0.1, stub: 0.1 };
        assert_eq!(steep.with_slope(Some(slope)).angle, 1.0);
    }

    #[test]
    fn nothing_is_said_of_air_of_touching_and_of_tools_that_cut_at_their_center() {
        let head = tool(None);
        let core = core(&head, 0.2).expect("it is watched");
        let at = |z: f64| ToolPose { tip: Point::new(0.0, 0.0, z), axis: Vector::z() };
        let piece = Piece {
            time: [0.0, 1.0],
            block: 0,
            kind: MoveKind::Feed,
            joints: [JointValues::ZERO; 2],
            pose: [at(5.0), at(-3.0)],
            deviation: 0.0,
            edge_deviation: 0.0,
            joint_deviation: JointValues::ZERO,
            finer: None,
        };
        let mut watch = PlungeWatch::default();
        assert_eq!(watch.follow((0, &head), &piece, None, &core, CONTACT), None);
        assert_eq!(watch.follow((0, &head), &piece, Some(&SweepReport::default()), &core, CONTACT), None);
        // A floor that is touched: a film of 0.3 micrometers.
        let r = core.max_radius();
        let film = SweepReport { volume_mm3: 3e-4 * std::f64::consts::PI * r * r, rays: 4, ..SweepReport::default() };
        assert_eq!(watch.follow((0, &head), &piece, Some(&film), &core, CONTACT), None);
        let ball = ToolBuilder::new(2, "BALL", Cutter::ball(8.0).expect("ball"), 10.0, 80.0).build().expect("tool");
        assert!(super::core(&ball, 0.2).is_none(), "its edges meet at the tip");
        let drill =
            ToolBuilder::new(3, "DRILL", Cutter::drill(8.0, 118.0).expect("drill"), 10.0, 80.0).build().expect("tool");
        assert!(super::core(&drill, 0.2).is_none());
        let flat = ToolBuilder::new(4, "FLAT", Cutter::flat(8.0).expect("flat"), 10.0, 80.0);
        let unknown = flat.clone().build().expect("tool");
        assert!(super::core(&unknown, 0.2).is_some());
        assert_eq!(
            Descent { angle: 0.1, steepest: 0.1, way: [0.0; 2], pillar: 0.0, stub: 0.2 }.judged(&unknown, CONTACT),
            Judgement::Unknown
        );
        assert!(super::core(&flat.center_cutting(true).build().expect("tool"), 0.2).is_none());
    }
}
