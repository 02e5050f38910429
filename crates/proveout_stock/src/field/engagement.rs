//! Where the cutter was engaged while an item took its material.
//!
//! Every removed interval has two ends on the skin of the material that went. For each of them the
//! time of the first touch is found: the smallest root of the body's function F along the motion. F
//! is convex in time while the axis does not turn, so Newton's method from the start approaches the
//! root from the left and never passes it; at a grazing touch, where the root is double, it takes
//! half of the way each time. The point is then seen from the cutter of that moment:
//!
//! ```text
//!    from the spindle, the feed goes up             from the side
//!
//!          90°  feed f                                w (to the spindle)
//!           .---.                                     |   |
//!         .'  |  '.         angle of a cutter that    |   |      height z of the touch above the tip
//!     0° (----+----) 180°   turns clockwise: 0° on    |   | _ _ _
//!     left '.   .' right    its left, 90° in front    |   |x     |  axial depth: highest less lowest
//!            '-'            (Altintas 2012, fig. 2.5) '---' _ _ _|
//! ```
//!
//! With f the direction of the feed across the axis w, and s = w x f pointing left, a point at the distance
//! vector p from the axis lies under the angle atan2(p . f, p . s). Material is entered at 0 and left at 180
//! degrees in a slot; 0 to 90 is up milling with half of the cutter, 90 to 180 climb milling. The skin
//! advances along its own normal n with -dF/dt = n . v, which is the chip thickness for the time from one
//! tooth to the next: for a feed `f_z` a tooth across the axis, this is `f_z` sin(angle) sin(slope of the
//! profile against the plane across the axis).
//!
//! Limits. The rays see the region of removal at their places only, so that depth and width come
//! out too small by less than a cell, and the ends of the range of angles by less than asin(cell /
//! radius). On the rear side of the axis, where only a cutter that goes down touches, points count
//! for depth, width and chip thickness, but not for the angles. A motion within 3 degrees of the
//! axis has no direction across it: width and angles stay empty. Two regions of engagement at once
//! are one range.

use crate::{
    field::slices::{SlicePlan, steps_of},
    kernels::meridian::Meridian,
    kernels::motion::MotionPiece,
    kernels::vec3::{V, add, along, dot, norm, scale, sub},
    sweep_item::SweepItem,
};

/// Engagement of the cutter in one motion; lengths in mm, angles in radian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Lowest and highest touch above the tip, along the axis.
    pub height: [f64; 2],
    /// Touches across feed and axis: farthest to the right (negative) and to the left of the axis, seen from
    /// the spindle along the feed. Low above high when the motion has no direction across the axis.
    pub across: [f64; 2],
    /// First and last angle under which material is met, 0 (left of the feed) over a quarter turn (in front)
    /// to pi (right): the sense of a spindle that turns clockwise. Low above high as `across`.
    pub angle: [f64; 2],
    /// Largest way of the skin along its own normal while the motion is made, where it touches, mm. Times the
    /// part of the duration from one tooth to the next it is the largest chip thickness.
    pub advance: f64,
}

const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Default for Contact {
    fn default() -> Self {
        Self { height: NONE, across: NONE, angle: NONE, advance: 0.0 }
    }
}

/// A point when the cutter first touches it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstTouch {
    /// Part of the motion that is over by then.
    pub(crate) tau: f64,
    pub(crate) height: f64,
    /// Across the feed, and the angle where it is in front.
    pub(crate) across: Option<(f64, Option<f64>)>,
    pub(crate) advance: f64,
}

impl FirstTouch {
    /// On the rear side, or by a motion along the axis.
    pub(crate) fn is_around(&self) -> bool {
        self.across.is_none_or(|(_, angle)| angle.is_none())
    }
}

impl Contact {
    /// Whether anything was touched.
    pub fn is_any(&self) -> bool {
        self.height[0] <= self.height[1]
    }

    /// Axial depth of the cut: length of cutter, along its axis, that touches.
    pub fn axial_depth(&self) -> f64 {
        (self.height[1] - self.height[0]).max(0.0)
    }

    /// Radial width of the cut across the feed; none where the motion has no direction across the axis.
    pub fn radial_width(&self) -> Option<f64> {
        (self.across[0] <= self.across[1]).then_some(self.across[1] - self.across[0])
    }

    /// Angles at which a tooth enters and leaves material, for a spindle that turns clockwise seen along the
    /// axis from the spindle, or counter-clockwise: 0 to pi is a slot, 0 to pi / 2 up milling, pi / 2 to pi
    /// climb milling.
    pub fn entry_and_exit(&self, clockwise: bool) -> Option<[f64; 2]> {
        let [first, last] = self.angle;
        let mirrored = [std::f64::consts::PI - last, std::f64::consts::PI - first];
        (first <= last).then_some(if clockwise { [first, last] } else { mirrored })
    }

    /// Both engagements as one.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self {
            height: join(self.height, other.height),
            across: join(self.across, other.across),
            angle: join(self.angle, other.angle),
            advance: self.advance.max(other.advance),
        }
    }

    pub(crate) fn add(&mut self, touch: FirstTouch) {
        let grow = |range: &mut [f64; 2], x: f64| *range = [range[0].min(x), range[1].max(x)];
        grow(&mut self.height, touch.height);
        if let Some((across, angle)) = touch.across {
            grow(&mut self.across, across);
            if let Some(angle) = angle {
                grow(&mut self.angle, angle);
            }
        }
        self.advance = self.advance.max(touch.advance);
    }
}

/// Distance from the skin at which a point counts as touched, mm: half a thousandth of a cell or less.
const TOUCHED: f64 = 2e-5;
/// Steps of Newton's method: a double root comes nearer by a factor of 4 each.
const STEPS: usize = 24;
/// Sine of the angle between feed and axis below which a motion is one along the axis: 3 degrees.
const ACROSS: f64 = 0.052;
/// Points less than this part of the radius to the rear of the axis are at its side.
const BESIDE: f64 = 0.01;

/// The motions of a pass, in the frame of the stock.
pub(crate) struct PassMotions {
    bodies: Vec<Option<Meridian>>,
    moves: Vec<(usize, MotionPiece)>,
    /// Whether contacts are asked for.
    pub(crate) contacts: bool,
    /// Into what engagement is sorted, and the steps of each item.
    slices: Option<(SlicePlan, Vec<u32>)>,
}

impl PassMotions {
    /// What is watched, where anything is; `index` gives the body of each item.
    pub(crate) fn watched(
        contacts: bool,
        plan: Option<SlicePlan>,
        items: &[SweepItem<'_>],
        index: &[usize],
    ) -> Option<Self> {
        let slices = plan.map(|plan| (plan, steps_of(&plan, items)));
        (contacts || slices.is_some()).then(|| Self { contacts, slices, ..Self::new(items, index) })
    }

    /// `index` gives the body of each item.
    pub(crate) fn new(items: &[SweepItem<'_>], index: &[usize]) -> Self {
        let mut bodies: Vec<Option<Meridian>> = Vec::new();
        let moves = items.iter().zip(index).map(|(item, &body)| {
            if bodies.len() <= body {
                bodies.resize(body + 1, None);
            }
            bodies[body].get_or_insert_with(|| Meridian::whole(item.body));
            let (from, to) = (&item.motion.from, &item.motion.to);
            let turn = to.axis - from.axis;
            let piece = MotionPiece {
                tip: from.tip.coords.into(),
                travel: (to.tip - from.tip).into(),
                axis: from.axis.into(),
                turn: turn.into(),
                angle2: turn.norm_squared(),
            };
            (body, piece)
        });
        let moves = moves.collect();
        Self { bodies, moves, contacts: true, slices: None }
    }

    /// Into what the engagement of an item is sorted, and its steps.
    pub(crate) fn slices_of(&self, item: u32) -> Option<(&SlicePlan, u32)> {
        let (plan, steps) = self.slices.as_ref()?;
        steps.get(item as usize).filter(|steps| **steps > 0).map(|steps| (plan, *steps))
    }

    /// The first touch of a point that an item took away.
    pub(crate) fn touch(&self, item: u32, x: V) -> FirstTouch {
        let none = FirstTouch { tau: f64::NAN, height: f64::NAN, across: None, advance: 0.0 };
        let Some((body, piece)) = self.moves.get(item as usize) else { return none };
        let Some(body) = self.bodies.get(*body).and_then(Option::as_ref) else { return none };
        let mut tau = 0.0;
        let mut sample = piece.sample(body, x, tau);
        for _ in 0..STEPS {
            if sample.f < TOUCHED || sample.ft >= 0.0 || tau >= 1.0 {
                break;
            }
            tau = (tau - sample.f / sample.ft).min(1.0);
            sample = piece.sample(body, x, tau);
        }
        let w = piece.axis_at(tau);
        let y = sub(x, piece.tip_at(tau));
        let height = dot(y, w);
        let p = along(y, w, -height);
        // Velocity of the point of the axis at that height, and its part across the axis.
        let v = add(piece.travel, scale(piece.turn, height));
        let feed = along(v, w, -dot(v, w));
        let (length, radius) = (norm(feed), norm(p));
        let across = (length > ACROSS * norm(v) && length > 0.0).then(|| {
            let f = scale(feed, 1.0 / length);
            let s = [w[1] * f[2] - w[2] * f[1], w[2] * f[0] - w[0] * f[2], w[0] * f[1] - w[1] * f[0]];
            let (front, left) = (dot(p, f), dot(p, s));
            (left, (front >= -BESIDE * radius && radius > TOUCHED).then(|| front.max(0.0).atan2(left)))
        });
        FirstTouch { tau, height, across, advance: (-sample.ft).max(0.0) }
    }
}
