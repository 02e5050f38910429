//! The tool axis at a contact.

use proveout_geom::Vector;

use super::{PathError, error::UNIT, place::PathPoint};

/// A travel that leaves the direction of the table by less than 30 degrees (the arc sine of this)
/// does not define a side of it: a line along the table that bends from one side to the other must
/// not turn the axis over.
const AGAINST: f64 = 0.5;
/// Cosine below which two given axes count as opposite: no great circle is between them.
const OPPOSITE: f64 = -1.0 + 1e-9;
/// Least way from the first point of a ruling to the second, part of it.
const NEXT_POINT: f64 = 1e-3;
/// Given axes beyond which the numbers are a mistake.
const MOST_AXES: f64 = 1e6;
/// Least way from a given axis to the next, part of the line.
const NEXT_AXIS: f64 = 1e-12;
/// Sine of the angle between normal and table's axis below which a fixed head has no direction.
const PARALLEL: f64 = 1e-9;
/// Sine of the angle between two given axes below which they count as one.
const SAME_AXIS: f64 = 1e-12;

/// A rule for the tool axis; angles in radian. f is the direction of travel, n the outward normal, k = n x f.
///
/// ```
/// use proveout_geom::Vector;
/// use proveout_blade::{ClosedSurface, Sine};
/// use proveout_path::{AxisRule, ParameterCurve, PathPoint};
///
/// let face = ClosedSurface::new(Sine::gentle());
/// let crest = ParameterCurve::straight([0.0, 20.0], [30.0, 20.0]).expect("two points");
/// let place = PathPoint::on(&face, &crest, 0.5); // normal +z, feed +x
/// let rule = AxisRule::LeadTilt { lead: 0.2, tilt: 0.0 }; // radian
/// let axis = rule.axis(&place, 0.5).expect("it has a direction everywhere");
/// assert!((axis - Vector::new(0.2_f64.sin(), 0.0, 0.2_f64.cos())).norm() < 1e-9);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum AxisRule {
    /// Along the normal.
    Normal,
    /// Turned from n towards f by `lead`, then towards k by `tilt`: `cos t (cos l n + sin l f) + sin t k`.
    LeadTilt {
        /// Towards the travel.
        lead: f64,
        /// Towards k.
        tilt: f64,
    },
    /// Inclined to n by `inclination`, in the direction that `tilt` turns from f towards k (Sturz angle and
    /// its direction): `cos i n + sin i (cos t f + sin t k)`.
    InclinationTilt {
        /// From the normal.
        inclination: f64,
        /// About the normal.
        tilt: f64,
    },
    /// A fixed head while a rotary table about `table` turns the part: the axis keeps the angle
    /// `head` to the plane across `table`, and in that plane the normal's direction turned by
    /// `lead` about `table` towards the travel: `sin h d + cos h (cos l p + sin l q)`, p the normal
    /// in that plane, q = d x p, or its opposite where the travel goes against it by more than 30
    /// degrees from the table's direction: along the table `lead` turns by the right hand about it,
    /// whichever way the travel goes.
    FixedHead {
        /// Unit vector of the table's axis.
        table: Vector,
        /// Angle of the head towards `table`.
        head: f64,
        /// In the plane across the table's axis, towards the travel.
        lead: f64,
    },
    /// Between unit vectors that are given at parts of the line's length, 0 to 1 ascending, on great circles.
    Interpolated(Vec<(f64, Vector)>),
    /// Along the ruling, by the two points at these parts of it, each offset along its own normal: of
    /// [`super::Flank`] alone, whose lines name their rulings.
    Ruling {
        /// 0 to 1, ascending; the cutter's tip lies beyond 0.
        points: [f64; 2],
    },
}

impl AxisRule {
    /// Checks the numbers.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn check(&self) -> Result<(), PathError> {
        let right = std::f64::consts::FRAC_PI_2;
        match self {
            Self::Normal => {}
            Self::LeadTilt { lead, tilt } => {
                PathError::within("the lead in radian", *lead, -right, right)?;
                PathError::within("the tilt in radian", *tilt, -right, right)?;
            }
            Self::InclinationTilt { inclination, tilt } => {
                PathError::within("the inclination in radian", *inclination, 0.0, right)?;
                PathError::within("the tilt in radian", *tilt, -4.0 * right, 4.0 * right)?;
            }
            Self::FixedHead { table, head, lead } => {
                PathError::within("the length of the table's axis", table.norm(), 1.0 - UNIT, 1.0 + UNIT)?;
                PathError::within("the head's angle in radian", *head, -right, right)?;
                PathError::within("the lead in radian", *lead, -right, right)?;
            }
            Self::Ruling { points } => {
                PathError::within("the first point of the ruling", points[0], 0.0, 0.999)?;
                PathError::within("the second point of the ruling", points[1], points[0] + NEXT_POINT, 1.0)?;
            }
            Self::Interpolated(keys) => {
                PathError::within("the number of given axes", keys.len() as f64, 1.0, MOST_AXES)?;
                for pair in keys.windows(2) {
                    PathError::within("the place of a given axis", pair[1].0, pair[0].0 + NEXT_AXIS, 1.0)?;
                    let opposite = pair[0].1.dot(&pair[1].1);
                    PathError::within("the cosine between neighboring given axes", opposite, OPPOSITE, 1.0 + UNIT)?;
                }
                for (part, axis) in keys {
                    PathError::within("the place of a given axis", *part, 0.0, 1.0)?;
                    PathError::within("the length of a given axis", axis.norm(), 1.0 - UNIT, 1.0 + UNIT)?;
                }
            }
        }
        Ok(())
    }

    /// The axis at a place; `part` is the part of the line's length up to it. None where the rule has no
    /// direction (a normal along the table's axis), and of [`Self::Ruling`], which needs more than a place.
    pub fn axis(&self, place: &PathPoint, part: f64) -> Option<Vector> {
        let PathPoint { normal: n, feed: f, across: k, .. } = place;
        match self {
            Self::Normal => Some(*n),
            Self::LeadTilt { lead, tilt } => Some((n * lead.cos() + f * lead.sin()) * tilt.cos() + k * tilt.sin()),
            Self::InclinationTilt { inclination, tilt } => {
                Some(n * inclination.cos() + (f * tilt.cos() + k * tilt.sin()) * inclination.sin())
            }
            Self::FixedHead { table, head, lead } => {
                let p = (n - table * n.dot(table)).try_normalize(PARALLEL)?;
                let q = table.cross(&p);
                let q = if q.dot(f) < -AGAINST { -q } else { q };
                Some(table * head.sin() + (p * lead.cos() + q * lead.sin()) * head.cos())
            }
            Self::Ruling { .. } => None,
            Self::Interpolated(keys) => {
                let next = keys.partition_point(|key| key.0 <= part);
                let (Some(from), Some(to)) = (keys.get(next.saturating_sub(1)), keys.get(next.min(keys.len() - 1)))
                else {
                    return None;
                };
                if to.0 <= from.0 {
                    return Some(from.1);
                }
                let t = (part - from.0) / (to.0 - from.0);
                let sine = from.1.cross(&to.1).norm();
                let angle = sine.atan2(from.1.dot(&to.1));
                if sine < SAME_AXIS {
                    return Some(from.1);
                }
                Some((from.1 * ((1.0 - t) * angle).sin() + to.1 * (t * angle).sin()) / sine)
            }
        }
    }
}
