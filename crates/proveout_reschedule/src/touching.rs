//! Where the cutter of a block touches the part: the contact point of a pose, found on the surface that is
//! cut.

use proveout_geom::{Point, ToolPose, Vector};
use proveout_path::{PathCutter, PathPoint};

use super::{CuttingBlock, CuttingRun, RescheduleError, Surroundings};

/// Steps that the contact is looked for in, and how near it must come, mm.
const CONTACT_STEPS: usize = 60;
const CONTACT: f64 = 1e-7;
/// How far a program's last digits may lead beyond a rim, mm.
const ROUNDED: f64 = 1e-3;

/// Where a cutter in a pose is from touching the surface, and the contact: of a ball by its center, which no
/// axis moves.
pub(super) struct TouchOffset {
    pub(super) place: PathPoint,
    /// From the tip that touches to the tip of the program.
    pub(super) off: Vector,
}

pub(super) fn place(point: Point, normal: Vector) -> PathPoint {
    let helper = if normal.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
    let feed = (helper - normal * helper.dot(&normal)).normalize();
    PathPoint {
        t: 0.0,
        uv: [0.0; 2],
        point,
        normal,
        feed,
        across: normal.cross(&feed),
        speed: 1.0,
        path_curvature: 0.0,
        form: [0.0; 3],
    }
}

/// Where each block of a run touches.
///
/// # Errors
/// The first block of which that is not known.
pub(super) fn contacts(
    run: &CuttingRun,
    cutter: &PathCutter,
    around: &Surroundings<'_>,
) -> Result<Vec<TouchOffset>, RescheduleError> {
    let of = |block: &CuttingBlock| {
        touching(&block.pose, cutter, around).ok_or_else(|| {
            let message = "where the tool touches is not known: it is not a ball, and no surface of the part is near";
            let help = "describe the blade of the scene under [part.blade], or use a ball end mill";
            RescheduleError::new("reschedule-tool", block.line, message, help)
        })
    };
    run.blocks.iter().map(of).collect()
}

pub(super) fn touching(pose: &ToolPose, cutter: &PathCutter, around: &Surroundings<'_>) -> Option<TouchOffset> {
    if let Some(radius) = cutter.ball_radius() {
        let center = pose.tip + pose.axis * radius;
        return Some(TouchOffset { place: place(center, pose.axis), off: Vector::zeros() });
    }
    let surface = around.surface?;
    let (mut near, mut last) = (pose.tip, None);
    for _ in 0..CONTACT_STEPS {
        // The tip may be beyond a rim that the contact is inside of.
        let contact = surface.nearest(&near)?;
        let place = place(contact.point, contact.normal);
        let off = pose.tip - cutter.touch(&place, &pose.axis, 0.0, None).pose.tip;
        let along = off - contact.normal * off.dot(&contact.normal);
        // At a rim the last digits of the program may lie beyond it: the contact then stays where it is.
        let at_rim = last.is_some_and(|p: Point| (p - contact.point).norm() < CONTACT) && along.norm() < ROUNDED;
        if along.norm() < CONTACT || at_rim {
            return Some(TouchOffset { place, off });
        }
        last = Some(contact.point);
        near = contact.point + along;
    }
    None
}
