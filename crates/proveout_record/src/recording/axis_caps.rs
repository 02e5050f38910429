//! Free tool axes in the recording: a cap of directions about each place that is shown.

use std::f64::consts::TAU;

use proveout_geom::Vector;
use proveout_sim::{
    AxisState,
    free_axes::{FreeAxes, FreePlace},
};

use crate::{
    color::Rgba,
    free_axes::evenly,
    picture::{Picture, single},
};

/// Maps in the recording, evenly along the program.
const RECORDED_MAPS: usize = 60;
/// Radius of the cap, mm.
const CAP_MM: f64 = 30.0;
/// Largest step along a ring of the cap, radian.
const CAP_STEP: f64 = 0.12;

/// The caps of axes of some places: time, mesh and its colors.
pub(crate) fn caps(axes: &FreeAxes) -> Vec<(f64, Picture, Vec<Rgba>)> {
    evenly(axes.places.len(), RECORDED_MAPS).map(|i| cap(&axes.places[i])).collect()
}

/// Directions of free (blue), blocked (red) and unknown (grey) axes on a sphere about the contact.
fn cap(place: &FreePlace) -> (f64, Picture, Vec<Rgba>) {
    let mut picture = Picture::default();
    let mut colors = Vec::new();
    for cell in place.map.cells() {
        let color: Rgba = match cell.state {
            AxisState::Free => [70, 130, 190, 255],
            AxisState::Blocked => [190, 60, 60, 255],
            AxisState::Unknown => [130, 130, 130, 255],
        };
        let [from, to] = cell.yaw;
        let steps = ((to - from).min(TAU) / CAP_STEP).ceil().max(1.0) as u32;
        for k in 0..steps {
            let yaw = |k: u32| from + (to - from) * f64::from(k) / f64::from(steps);
            let corners = [
                (cell.tilt[0], yaw(k)),
                (cell.tilt[1], yaw(k)),
                (cell.tilt[1], yaw(k + 1)),
                (cell.tilt[0], yaw(k + 1)),
            ];
            let first = picture.positions.len() as u32;
            for (tilt, yaw) in corners {
                let axis: Vector = place.map.axis(tilt, yaw);
                picture.positions.push(single(&(place.point.coords + axis * CAP_MM)));
                picture.normals.push(single(&axis));
                colors.push(color);
            }
            picture.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    (place.time_s, picture, colors)
}
