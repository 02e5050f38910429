//! A tap does not go forward by its pitch in a revolution ([`TAP_PITCH`], gate `process`).
//!
//! A tap pulls itself into its thread: where the feed leads it by another way, its flanks cut the thread
//! away, or it breaks. What it goes forward in a revolution is the feed of the block over the speed of the
//! spindle. A path that is coupled to the spindle has no room for another pitch but that of rounding: 1
//! percent is 0.12 of a pitch over a thread of one and a half diameters in a coarse size (chosen). A feed in
//! time needs a chuck that gives way, and is often programmed a little slower: 10 percent (chosen).

use proveout_controller::BlockRecord;
use proveout_tool::{Tool, ToolLibrary};

use crate::{
    checks::check::{BlockEnd, Check, RunEnd},
    verdict::{
        finding::{Finding, TAP_PITCH},
        gate::Gate,
        log::FindingLog,
        verdict_file::ToolUse,
    },
};

/// Largest difference from the pitch, as a part of it, of a path that is coupled to the spindle.
const COUPLED: f64 = 0.01;
/// The same of a feed in time.
const IN_TIME: f64 = 0.1;

/// See the module.
#[derive(Debug)]
pub(crate) struct TapPitch;

impl Check for TapPitch {
    fn block(&mut self, end: &BlockEnd<'_>, log: &mut FindingLog) {
        let tool = end.sum.tool.and_then(|t| end.prepared.tools.tools.get(t));
        if let Some(finding) = tool.and_then(|tool| finding(tool, end.block, end.sum.cut_rpm)) {
            log.push(finding);
        }
    }

    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        for words in unknown(&end.prepared.tools, end.tools) {
            log.leave_out(Gate::Process, words);
        }
    }
}

/// What is not checked of taps that have cut, since the library gives them no pitch.
fn unknown(tools: &ToolLibrary, used: &[ToolUse]) -> Vec<String> {
    let bare = |tool: &&Tool| tool.is_tap && tool.thread.is_none();
    let has_cut = |tool: &&Tool| used.iter().any(|u| u.name == tool.name && u.volume_mm3 > 0.0);
    let words = |tool: &Tool| {
        format!("whether the feed of {} matches its pitch: the tool library gives no `pitch_mm` for it", tool.name)
    };
    tools.tools.iter().filter(bare).filter(has_cut).map(words).collect()
}

/// The finding of a block in which a tap has cut with the spindle at `speed_rpm`; none where its way fits its
/// pitch, or it is no tap.
fn finding(tool: &Tool, block: &BlockRecord, speed_rpm: f64) -> Option<Finding> {
    let pitch = tool.thread?.pitch;
    if speed_rpm <= 0.0 || block.feed <= 0.0 {
        return None;
    }
    let way = block.feed * 60.0 / speed_rpm;
    let (most, how) = if block.coupled {
        (COUPLED, "coupled to the spindle")
    } else {
        (IN_TIME, "by feed per minute, as in a floating holder")
    };
    if (way - pitch).abs() <= most * pitch {
        return None;
    }
    let message = format!(
        "{} has a pitch of {pitch:.3} mm and feeds {way:.3} mm per revolution ({:.0} mm/min at {speed_rpm:.0} 1/min, {how}): {:.1} percent off, {:.0} percent allowed",
        tool.name,
        block.feed * 60.0,
        (way / pitch - 1.0) * 100.0,
        most * 100.0
    );
    let mut f = FindingLog::of(&TAP_PITCH, message);
    f.bodies = vec![tool.name.clone()];
    (f.block, f.time_s) = (Some(block.index), Some(block.start_time));
    (f.value, f.limit, f.unit) = (Some(way), Some(pitch), Some("mm".into()));
    Some(f)
}
