//! What the control reports while it runs the program, in the order of its events.
//!
//! | event | finding | gate |
//! |---|---|---|
//! | a limit of joint, drive or spindle | [`joint_limits`] | `limits` |
//! | a pose without joint positions | [`UNREACHABLE`] | `limits` |
//! | a tool axis that leaves its great circle | [`OFF_CIRCLE`], [`POLE_CROSSED`] | `limits` |
//! | a place where the compensated path enters its contour | [`contour_overcut`] | `gouge` |
//! | the program cannot go on | [`STOPPED`] | `program` |
//! | a probing motion whose result is not known | [`PROBED`] | none; `process` leaves it out |
//! | a probing motion while the spindle turns | [`PROBE_SPINDLE`] | `process` |
//! | a word without effect | [`NOTE`] | none |
//! | a word with an assumed meaning | [`ASSUMED`] | none; `program` leaves it out |

use proveout_controller::Event;
use proveout_machine::Machine;
use proveout_nc::Contact;

use crate::{
    checks::{
        check::{Check, StretchView},
        contour_overcut, joint_limits,
    },
    verdict::{
        finding::{ASSUMED, Finding, NOTE, OFF_CIRCLE, POLE_CROSSED, PROBE_SPINDLE, PROBED, STOPPED, UNREACHABLE},
        log::FindingLog,
    },
};

/// See the module.
#[derive(Debug)]
pub(crate) struct ControlEvents;

impl Check for ControlEvents {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        let chunk = view.chunk;
        for event in &chunk.events {
            if let Event::Overcut { time, location, overcut, .. } = event {
                log.push(contour_overcut::finding(*time, location, overcut));
                continue;
            }
            let Some(mut f) = finding(event, &view.prepared.machine) else { continue };
            (f.block, f.time_s) = (Some(event.block()), Some(event.time()));
            if let Some(sample) = chunk.samples.iter().find(|s| s.time >= event.time()) {
                f.axes = view.axes(&sample.commanded);
            }
            log.push(f);
        }
    }
}

/// What an event of the control says; none where it is no finding. A place where the compensated
/// path enters its own contour has its own words ([`contour_overcut`]), since it is reported only at the
/// end of the compensated stretch.
fn finding(event: &Event, machine: &Machine) -> Option<Finding> {
    Some(match event {
        Event::Limit { joint, value, limit, kind, .. } => {
            return joint_limits::finding(machine, *joint, [*value, *limit], *kind);
        }
        Event::UnreachablePose { reason, .. } => {
            FindingLog::of(&UNREACHABLE, format!("the programmed tool pose cannot be reached: {reason}"))
        }
        Event::LeavesCircle { angle, at_flank, in_cone, reason, .. } => {
            let code = if *in_cone { &POLE_CROSSED } else { &OFF_CIRCLE };
            let angle = angle.to_degrees();
            let message = format!(
                "{reason}: the tool axis leaves the programmed great circle by {angle:.6} degrees, {at_flank:.6} mm at the flank"
            );
            let mut f = FindingLog::of(code, message);
            (f.value, f.unit) = (Some(angle), Some("deg".into()));
            f
        }
        Event::Ended { location, reason, .. } => {
            let mut f = FindingLog::of(&STOPPED, reason.clone());
            (f.file, f.line) = (Some(location.file.to_string()), Some(location.line));
            f
        }
        Event::Probe { contact: Contact::Touched | Contact::Missed, spindle_turns, .. } => {
            if !spindle_turns {
                return None;
            }
            FindingLog::of(&PROBE_SPINDLE, "the spindle turns while the probe measures: write M5 before it".into())
        }
        Event::Probe { .. } => {
            FindingLog::of(&PROBED, "the probing motion is run to its end: the probe result is not known".into())
        }
        Event::Note { text, .. } => match text.assumption() {
            Some(assumed) => FindingLog::of(&ASSUMED, assumed.to_owned()),
            None => FindingLog::of(&NOTE, text.as_str().to_owned()),
        },
        _ => return None,
    })
}
