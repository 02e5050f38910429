//! What is handed out of a row, and what is shown of it.

use super::super::super::{Curve, CurveKind, Figure, Quantity, Rescheduled, Study};
use super::freedom::Freedom;
use super::joints::Angles;
use super::local::peaks;
use super::{RowContext, RowSchedule, ScheduleOrigin};

/// Names of curves and figures of the turn and the tilt.
const SHOWN: [[&str; 5]; 2] = [
    [
        "joint next to the workpiece",
        "largest velocity of the joint next to the workpiece before",
        "largest velocity of the joint next to the workpiece",
        "largest acceleration of the joint next to the workpiece before",
        "largest acceleration of the joint next to the workpiece",
    ],
    [
        "joint next to the tool",
        "largest velocity of the joint next to the tool before",
        "largest velocity of the joint next to the tool",
        "largest acceleration of the joint next to the tool before",
        "largest acceleration of the joint next to the tool",
    ],
];

impl RowContext<'_> {
    pub(super) fn handed_out(&self, best: &RowSchedule, course: &[Angles], freedom: &Freedom<'_>) -> Rescheduled {
        let (poses, rotary) = self.poses(&best.angles);
        let mut study = Study::default();
        let length = Quantity { name: "path length of what stays", unit: "mm" };
        for (j, [joint, ..]) in SHOWN.iter().enumerate() {
            let axes = [length, Quantity { name: joint, unit: "deg" }];
            for (name, kind, angles) in
                [("original", CurveKind::Original, course), ("new", CurveKind::Result, best.angles.as_slice())]
            {
                let points = self.row.arc.iter().zip(angles).map(|(s, q)| [*s, q[j].to_degrees()]).collect();
                study.curves.push(Curve { name, kind, axes, points });
            }
        }
        let mut figure = |name, unit, value: f64| study.figures.push(Figure { name, unit, value });
        let both = [course, &best.angles].map(|angles| peaks(angles, self.least));
        for (j, [_, before_v, v, before_a, a]) in SHOWN.into_iter().enumerate() {
            figure(before_v, "deg/s", both[0][j][0].to_degrees());
            figure(v, "deg/s", both[1][j][0].to_degrees());
            figure(before_a, "deg/s2", both[0][j][1].to_degrees());
            figure(a, "deg/s2", both[1][j][1].to_degrees());
        }
        let turned = course.iter().zip(&best.angles).map(|(a, b)| {
            let [a, b] = [a, b].map(|q| self.joints.axis(*q));
            a.cross(&b).norm().atan2(a.dot(&b))
        });
        figure("largest turn from the program's own axis", "deg", turned.fold(0.0, f64::max).to_degrees());
        let leans = best.angles.iter().zip(&freedom.normals).filter_map(|(q, n)| {
            let (axis, normal) = (self.joints.axis(*q), (*n)?);
            Some(axis.cross(&normal).norm().atan2(axis.dot(&normal)))
        });
        let most = leans.fold(f64::NEG_INFINITY, f64::max);
        if most.is_finite() {
            figure("largest lean from the normal", "deg", most.to_degrees());
        }
        let axes = [course, &best.angles].map(|all| all.iter().map(|q| self.joints.axis(*q)).collect::<Vec<_>>());
        figure("the new schedule is one of this method", "", f64::from(u8::from(best.origin != ScheduleOrigin::Given)));
        figure("least time by the feed", "s", self.least.iter().sum());
        figure("time of the blocks", "s", best.time());
        study.figures.extend(self.row.rules.iter().flat_map(|rules| rules.figures([&axes[0], &axes[1]])));
        Rescheduled { poses, stretch: self.row.stretch.clone(), rotary, channel: None, study }
    }
}
