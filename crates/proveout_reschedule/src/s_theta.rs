//! S-theta plane re-scheduling with monotone rotary motion.
//!
//! Source: Li J., Song D., Li P., Zhang Q., Li J., Ma J. (2022), Piecewise decoupling tool orientation
//! re-scheduling for four-axis reciprocal toolpaths of blades based on S-theta plane with monotonicity
//! constraint, Machines 10, 953, doi:10.3390/machines10100953. Ball centers and layers: equation (1), section
//! 3.1. Limits: equation (2), corrected. Corners: equations (6) to (13), corrected. Key points: taut string
//! through the inset channel instead of the paper's search (it has no redundant key points and is monotone,
//! see [`super::taut_string`]).
//!
//! Ball centers and the inclination towards the table axis stay; the angle theta in the plane across the
//! table axis becomes a function of the arc length S with continuous second derivative, non-decreasing,
//! inside the channel, and flat where layers meet. Angles are counted on from layer to layer, so that theta
//! is the rotary axis but for sign and zero.

use std::f64::consts::TAU;

use proveout_geom::ToolPose;

use super::corner::{SmoothedPolyline, ThetaUnit};
use super::taut::{TautGate, taut_string};
use super::{
    BlockLayer, Channel, Curve, CurveKind, CuttingRun, Figure, Method, Quantity, RescheduleError, Rescheduled,
    SectionPath, Study, Surroundings, TurnChannel,
};

/// Rounding of a way along the path, mm.
const ROUNDING_MM: f64 = 1e-9;
/// A limit this little below the angle at the end has reached it, radian.
const REACHED: f64 = 1e-12;
/// Points of a layer nearer than this along the path are one, mm.
const SAME_MM: f64 = 1e-12;
/// By how much angles may leave the channel or fall by rounding, radian.
const ROUNDED: f64 = 1e-9;

/// Parameters of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct STheta {
    /// Clearance from both limits, radian: half angle of the tool's taper and safety.
    pub clearance: f64,
    /// Distance of key points from the limits with clearance, radian.
    pub inset: f64,
    /// Shortest flat at the start of a layer, mm.
    pub start_flat: f64,
    /// Flat at the end of a layer, part of the layer's length.
    pub end_flat: f64,
    /// Key points nearer than this are merged, mm.
    pub merge: f64,
    /// Unit of theta in the construction of corners.
    pub unit: ThetaUnit,
}

/// Values of the specification's section 5, none of them published but chosen: clearance 50 degrees, inset 3
/// degrees, flats 0.9 mm and 2 percent, key points 1.5 mm apart, theta in degrees.
pub const STHETA_DEFAULTS: STheta = STheta {
    clearance: 50.0 * TAU / 360.0,
    inset: 3.0 * TAU / 360.0,
    start_flat: 0.9,
    end_flat: 0.02,
    merge: 1.5,
    unit: ThetaUnit::Degree,
};

impl Default for STheta {
    fn default() -> Self {
        STHETA_DEFAULTS
    }
}

/// A plan for a whole path.
#[derive(Clone, Debug, PartialEq)]
pub struct ThetaPlan {
    /// Angle at each block, radian.
    pub angles: Vec<f64>,
    /// Layers with their curves.
    pub layers: Vec<(BlockLayer, SmoothedPolyline)>,
}

impl STheta {
    fn check(&self) -> Result<(), RescheduleError> {
        let angle = |v: f64, high: f64| v.is_finite() && (0.0..high).contains(&v);
        let length = |v: f64| v.is_finite() && v >= 0.0;
        let options = [
            ("clearance_deg", self.clearance.to_degrees(), angle(self.clearance, 0.25 * TAU)),
            ("inset_deg", self.inset.to_degrees(), self.inset > 0.0 && angle(self.inset, 0.125 * TAU)),
            ("start_flat_mm", self.start_flat, length(self.start_flat)),
            ("end_flat_percent", 100.0 * self.end_flat, (0.0..0.4).contains(&self.end_flat)),
            ("merge_mm", self.merge, length(self.merge)),
        ];
        let Some((key, value, _)) = options.into_iter().find(|(.., fits)| !fits) else { return Ok(()) };
        Err(RescheduleError::new(
            "reschedule-option",
            0,
            format!("{key} = {value:.6} of s-theta is outside of its range"),
            "clearance 0 to 90 degrees, inset above 0 to 45 degrees, flat at the end 0 to 40 percent, other lengths at least zero",
        ))
    }

    /// Angles of all blocks of a path in its channel, and the curves of the layers. Only arc lengths, layers,
    /// original angles and lines of the path are looked at.
    ///
    /// # Errors
    /// `reschedule-channel`: the channel is too narrow at some block.
    pub fn plan(&self, path: &SectionPath, channel: &Channel) -> Result<ThetaPlan, RescheduleError> {
        self.check()?;
        let mut angles = vec![0.0; path.len()];
        let (whole, parts): (Vec<BlockLayer>, Vec<BlockLayer>) =
            path.layers.iter().partition(|layer| layer.starts_at_base && layer.ends_at_base);
        let mut layers: Vec<(BlockLayer, SmoothedPolyline)> = Vec::with_capacity(path.layers.len());
        for layer in &whole {
            let ends = self.ends(path, channel, layer, None);
            layers.push((*layer, self.layer(path, channel, layer, ends)?));
        }
        for layer in &parts {
            let beside =
                if layer.starts_at_base { layers.iter().rfind(|(l, _)| whole.contains(l)) } else { layers.first() };
            let ends = self.ends(path, channel, layer, beside.filter(|_| !whole.is_empty()));
            layers.push((*layer, self.layer(path, channel, layer, ends)?));
        }
        layers.sort_by_key(|(layer, _)| layer.first);
        for (layer, curve) in &layers {
            let blocks = layer.first..=layer.last;
            for (angle, s) in angles[blocks.clone()].iter_mut().zip(&path.arc[blocks]) {
                *angle = curve.at(*s);
            }
        }
        Self::verify(path, channel, &angles)?;
        Ok(ThetaPlan { angles, layers })
    }

    /// Theta at an end of the path that is no base point: as near to the original as the inset channel
    /// allows.
    fn free_end(&self, path: &SectionPath, channel: &Channel, i: usize, at_least: f64) -> f64 {
        let (low, high) = (channel.lower[i] + self.inset, channel.upper[i] - self.inset);
        let wanted = path.axis_angle[i];
        // The original may be whole turns away.
        let wanted = wanted - TAU * ((wanted - 0.5 * (low + high)) / TAU).round();
        wanted.clamp(low, high).max(at_least.min(high))
    }

    /// Angle at a base point and length of the flat before it: the upper limit where that flat
    /// begins. After a concave side the limit is level there, so that this is the limit at the base
    /// point itself; where it still rises (a section without altered points) the flat must begin
    /// below it. The flat is halved until the lower limit leaves room.
    fn base(&self, path: &SectionPath, channel: &Channel, b: usize) -> (f64, f64) {
        let mut flat = self.end_flat * path.period;
        for _ in 0..30 {
            let i = path.arc.partition_point(|&s| s < path.arc[b] - flat).min(b);
            let theta = if i > 0 && path.arc[i] > path.arc[b] - flat {
                let part = (path.arc[b] - flat - path.arc[i - 1]) / (path.arc[i] - path.arc[i - 1]);
                channel.upper[i - 1] + (channel.upper[i] - channel.upper[i - 1]) * part
            } else {
                channel.upper[i]
            };
            if theta >= channel.lower[b] + self.inset {
                return (theta, flat.min(path.arc[b]));
            }
            flat *= 0.5;
        }
        (channel.upper[b], 0.0)
    }

    /// Angles at the ends of a layer. Ends of the path take the angle that the adjacent whole layer
    /// has at the same place.
    fn ends(
        &self,
        path: &SectionPath,
        channel: &Channel,
        layer: &BlockLayer,
        whole: Option<&(BlockLayer, SmoothedPolyline)>,
    ) -> [f64; 2] {
        let (a, b) = (layer.first, layer.last);
        let inside =
            |theta: &f64, i: usize| *theta <= channel.upper[i] - self.inset && *theta >= channel.lower[i] + self.inset;
        if layer.starts_at_base {
            let start = self.base(path, channel, a).0;
            if layer.ends_at_base {
                return [start, self.base(path, channel, b).0];
            }
            let like = whole.map(|(other, curve)| {
                let from = path.arc[other.first];
                start + curve.at(from + path.arc[b] - path.arc[a]) - curve.at(from)
            });
            let end = like.filter(|t| inside(t, b) && *t >= start);
            [start, end.unwrap_or_else(|| self.free_end(path, channel, b, start))]
        } else {
            if !layer.ends_at_base {
                let start = self.free_end(path, channel, a, f64::MIN);
                return [start, self.free_end(path, channel, b, start)];
            }
            let end = self.base(path, channel, b).0;
            let like = whole.map(|(other, curve)| {
                let to = path.arc[other.last];
                end + curve.at(to - (path.arc[b] - path.arc[a])) - curve.at(to)
            });
            let start = like.filter(|t| inside(t, a) && *t <= end);
            [start.unwrap_or_else(|| self.free_end(path, channel, a, f64::MIN).min(end)), end]
        }
    }

    /// What mends a layer that is shorter than its flats: the flats that are asked for, or the room that the
    /// channel leaves; nothing is advised that would not do.
    fn remedy_of_flats(
        &self,
        path: &SectionPath,
        channel: &Channel,
        layer: &BlockLayer,
        start_theta: f64,
        end_flat: f64,
    ) -> &'static str {
        let (a, b) = (layer.first, layer.last);
        let length = path.arc[b] - path.arc[a];
        // Where the upper limit, less an inset, has risen above the angle at the start.
        let risen = |inset: f64| {
            let i = (a..=b).find(|&i| channel.upper[i] - inset >= start_theta);
            i.map_or(length, |i| path.arc[i] - path.arc[a])
        };
        if risen(self.inset) < length && self.start_flat + end_flat >= length {
            "set shorter flats: start_flat_mm, end_flat_percent"
        } else if risen(0.0) + end_flat < length {
            "set a smaller inset_deg: the limit rises above the angle at the start too late for this one"
        } else {
            "the channel does not rise within this layer; the method smooth has no layers and takes such a section"
        }
    }

    fn layer(
        &self,
        path: &SectionPath,
        channel: &Channel,
        layer: &BlockLayer,
        [start_theta, end_theta]: [f64; 2],
    ) -> Result<SmoothedPolyline, RescheduleError> {
        let (a, b) = (layer.first, layer.last);
        let mut points = vec![[path.arc[a], start_theta]];
        // Flat at the start, until the inset upper limit has risen above the base vector.
        let mut inner_start = path.arc[a];
        if layer.starts_at_base {
            let risen = (a..=b).find(|&i| channel.upper[i] - self.inset >= start_theta).unwrap_or(b);
            // Nor may it run on where the lower limit has come up to the base vector.
            let low = (a + 1..=b).find(|&i| channel.lower[i] + self.inset > start_theta).map_or(b, |i| i - 1);
            let longest =
                (path.arc[low] - path.arc[a]).max(0.5 * (path.arc[a + 1] - path.arc[a])).min(0.25 * path.period);
            inner_start += self.start_flat.max(path.arc[risen] - path.arc[a]).min(longest);
            points.push([inner_start.min(path.arc[b]), start_theta]);
        }
        let end_flat = if layer.ends_at_base { self.base(path, channel, b).1 } else { 0.0 };
        let inner_end = path.arc[b] - end_flat;
        // The end of a path may be shorter than the flats of a layer: it is level.
        if inner_end <= inner_start + ROUNDING_MM {
            let level = if layer.starts_at_base { start_theta } else { end_theta };
            if !(layer.starts_at_base && layer.ends_at_base) {
                let points = vec![[path.arc[a], level], [path.arc[b], level]];
                return Ok(SmoothedPolyline::new(points, self.unit, path.period, |_, _| 0.0));
            }
            return Err(RescheduleError::new(
                "reschedule-layers",
                path.lines[a],
                format!(
                    "the layer of lines {} to {} is {:.3} mm long, and its flats take {:.3} mm at its start and {end_flat:.3} mm at its end",
                    path.lines[a],
                    path.lines[b],
                    path.arc[b] - path.arc[a],
                    inner_start - path.arc[a]
                ),
                self.remedy_of_flats(path, channel, layer, start_theta, end_flat),
            ));
        }
        let inside: Vec<usize> = (a..=b).filter(|&i| path.arc[i] > inner_start && path.arc[i] < inner_end).collect();
        let gates: Vec<TautGate> = inside
            .iter()
            .map(|&i| {
                let low = (channel.lower[i] + self.inset).min(end_theta);
                // Where the limit itself has reached the angle at the end nothing rises above it.
                let flat = layer.ends_at_base && channel.upper[i] >= end_theta - REACHED;
                let high = if flat { end_theta } else { channel.upper[i] - self.inset };
                // After the flat the limit may not have risen yet: a layer shorter than its flat.
                TautGate { s: path.arc[i], low, high: high.max(start_theta.min(channel.upper[i])) }
            })
            .collect();
        let string = taut_string([inner_start, start_theta], &gates, [inner_end, end_theta]).map_err(|gate| {
            let i = inside.get(gate).copied().unwrap_or(b);
            RescheduleError::new(
                "reschedule-channel",
                path.lines[i],
                format!(
                    "the channel of {:.2} degrees is narrower than twice the inset of {:.2} degrees",
                    channel.width(i).to_degrees(),
                    self.inset.to_degrees()
                ),
                "set a smaller inset or clearance",
            )
        })?;
        points.extend(self.merged(path, channel, layer, string));
        if layer.ends_at_base {
            points.push([path.arc[b], end_theta]);
        }
        points.dedup_by(|p, q| (p[0] - q[0]).abs() < SAME_MM);
        let room = self.room(path, channel, layer, &points);
        Ok(SmoothedPolyline::new(points, self.unit, path.period, |i, above| room[i][usize::from(above)]))
    }

    /// Removes key points nearer than [`STheta::merge`] to the previous one where the channel
    /// allows it.
    fn merged(&self, path: &SectionPath, channel: &Channel, layer: &BlockLayer, keys: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        let mut kept: Vec<[f64; 2]> = Vec::with_capacity(keys.len());
        for (i, key) in keys.iter().enumerate() {
            let inner = i > 0 && i + 1 < keys.len();
            if inner && let Some(&last) = kept.last() {
                let close = key[0] - last[0] < self.merge;
                if close && self.clear(path, channel, layer, last, keys[i + 1]) {
                    continue;
                }
            }
            kept.push(*key);
        }
        kept
    }

    /// A straight segment keeps half of the inset from both limits.
    fn clear(&self, path: &SectionPath, channel: &Channel, layer: &BlockLayer, a: [f64; 2], b: [f64; 2]) -> bool {
        let from = path.arc.partition_point(|&s| s <= a[0]).max(layer.first);
        let to = path.arc.partition_point(|&s| s < b[0]).min(layer.last);
        (from..to).all(|i| {
            let y = a[1] + (b[1] - a[1]) * (path.arc[i] - a[0]) / (b[0] - a[0]);
            y <= channel.upper[i] - 0.5 * self.inset && y >= channel.lower[i] + 0.5 * self.inset
        })
    }

    /// Smallest vertical distance of the polyline from the lower and the upper limit between the midpoints of
    /// the segments at each corner. Limits and polyline are straight between blocks and corners, so these
    /// places are enough.
    fn room(&self, path: &SectionPath, channel: &Channel, layer: &BlockLayer, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut room = vec![[f64::MAX; 2]; points.len()];
        let limit = |limits: &[f64], s: f64| {
            let k = path.arc.partition_point(|&x| x < s).clamp(layer.first + 1, layer.last.max(layer.first + 1));
            let (a, b) = (path.arc[k - 1], path.arc[k]);
            limits[k - 1] + (limits[k] - limits[k - 1]) * ((s - a) / (b - a)).clamp(0.0, 1.0)
        };
        let mut look = |corner: usize, s: f64, y: f64| {
            let gaps = [y - limit(&channel.lower, s), limit(&channel.upper, s) - y];
            for (room, gap) in room[corner].iter_mut().zip(gaps) {
                *room = room.min(gap.max(0.0));
            }
        };
        for k in 1..points.len() {
            let (a, b) = (points[k - 1], points[k]);
            let middle = 0.5 * (a[0] + b[0]);
            let at = |s: f64| a[1] + (b[1] - a[1]) * (s - a[0]) / (b[0] - a[0]);
            for (corner, s) in [(k - 1, a[0]), (k - 1, middle), (k, middle), (k, b[0])] {
                look(corner, s, at(s));
            }
            let from = path.arc.partition_point(|&s| s <= a[0]).max(layer.first);
            let to = path.arc.partition_point(|&s| s < b[0]).min(layer.last + 1);
            for i in from..to {
                let s = path.arc[i];
                look(if s < middle { k - 1 } else { k }, s, at(s));
            }
        }
        room
    }

    /// The result is what the method promises, or it is not handed out.
    fn verify(path: &SectionPath, channel: &Channel, angles: &[f64]) -> Result<(), RescheduleError> {
        for i in 0..path.len() {
            let passed = (angles[i] - channel.upper[i]).max(channel.lower[i] - angles[i]);
            let falls = i > 0 && angles[i] < angles[i - 1] - ROUNDED;
            if passed > ROUNDED || falls || !angles[i].is_finite() {
                let what = if falls { "falls" } else { "leaves the channel" };
                return Err(RescheduleError::new(
                    "reschedule-channel",
                    path.lines[i],
                    format!("the planned angle {what} by {:.4} degrees", passed.abs().to_degrees()),
                    "set a smaller inset or clearance",
                ));
            }
        }
        Ok(())
    }
}

impl Method for STheta {
    fn name(&self) -> &'static str {
        "s-theta"
    }

    fn source(&self) -> &'static str {
        "Li et al. 2022, doi:10.3390/machines10100953"
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        self.check()?;
        let path = SectionPath::new(run, around)?;
        let channel = Channel::tabulated(&path, self.clearance, 2.0 * self.inset)?;
        let ThetaPlan { angles, layers } = self.plan(&path, &channel)?;
        let mut study = study(&path, &channel, &angles);
        let string: Vec<[f64; 2]> = layers.iter().flat_map(|(_, curve)| curve.points.iter().copied()).collect();
        let mut keys = string.clone();
        keys.dedup();
        let bases = layers.iter().filter(|(layer, _)| layer.starts_at_base);
        let bases: Vec<[f64; 2]> = bases.map(|(layer, _)| [path.arc[layer.first], angles[layer.first]]).collect();
        study.figures.push(Figure { name: "layers", unit: "", value: layers.len() as f64 });
        study.figures.push(Figure { name: "key points", unit: "", value: keys.len() as f64 });
        study.curves.push(curve("taut string", CurveKind::Polyline, string));
        study.curves.push(curve("key points", CurveKind::KeyPoints, keys));
        study.curves.push(curve("base points", CurveKind::Marks, bases));
        Ok(rescheduled(run, &path, &channel, angles, study))
    }
}

/// The result of a method that turns the axes in the section.
pub(super) fn rescheduled(
    run: &CuttingRun,
    path: &SectionPath,
    channel: &Channel,
    angles: Vec<f64>,
    study: Study,
) -> Rescheduled {
    Rescheduled {
        poses: poses(run, path, &angles),
        stretch: path.stretch(),
        rotary: None,
        channel: Some(turns(path, channel, angles)),
        study,
    }
}

/// A curve of the S-theta plane from arc lengths, mm, and angles, radian.
pub(super) fn curve(name: &'static str, kind: CurveKind, points: impl IntoIterator<Item = [f64; 2]>) -> Curve {
    let axes = [
        Quantity { name: "path length of the ball center", unit: "mm" },
        Quantity { name: "tool axis angle in the section", unit: "deg" },
    ];
    Curve { name, kind, axes, points: points.into_iter().map(|[s, angle]| [s, angle.to_degrees()]).collect() }
}

/// Limits, original and new angle over arc length, and the margin.
pub(super) fn study(path: &SectionPath, channel: &Channel, angles: &[f64]) -> Study {
    let over = |name, kind, values: &[f64]| curve(name, kind, path.arc.iter().zip(values).map(|(s, v)| [*s, *v]));
    let narrowest = (0..path.len()).map(|i| channel.width(i)).fold(f64::MAX, f64::min);
    let figure = |name, unit, value| Figure { name, unit, value };
    Study {
        curves: vec![
            over("forward limit", CurveKind::Limit, &channel.upper),
            over("backward limit", CurveKind::Limit, &channel.lower),
            over("original", CurveKind::Original, &path.axis_angle),
            over("new", CurveKind::Result, angles),
        ],
        figures: vec![
            figure("narrowest channel", "deg", narrowest.to_degrees()),
            figure("smallest margin", "deg", channel.margin(angles).to_degrees()),
            figure("layer", "mm", path.period),
        ],
        ..Study::default()
    }
}

/// The channel as angles about the table axis.
fn turns(path: &SectionPath, channel: &Channel, angles: Vec<f64>) -> TurnChannel {
    let [u, v, axis] = path.basis;
    TurnChannel {
        axis: axis * u.cross(&v).dot(&axis).signum(),
        limits: channel.lower.iter().zip(&channel.upper).map(|(low, high)| [*low, *high]).collect(),
        angles,
    }
}

/// New poses: ball centers stay. Lead-in and lead-out take the axis of the path's end.
pub(super) fn poses(run: &CuttingRun, path: &SectionPath, angles: &[f64]) -> Vec<ToolPose> {
    let n = path.len();
    run.blocks
        .iter()
        .enumerate()
        .map(|(k, block)| {
            let i = k.saturating_sub(path.lead_in).min(n - 1);
            let axis = path.axis_at(i, angles[i]);
            let center = block.pose.tip + block.pose.axis * path.ball_radius;
            ToolPose { tip: center - axis * path.ball_radius, axis }
        })
        .collect()
}
