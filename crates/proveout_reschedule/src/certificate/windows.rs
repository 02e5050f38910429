//! The best row of windows of feed and travel.
//!
//! A travel of joint k up from gate c to gate d proves `(low_d - high_c) / V`, a part of d less a part of c.
//! So the best row of windows that follow each other is found gate by gate, with the best open window of each
//! kind:
//!
//! ```text
//!   B_i   windows up to gate i, none open            F_i   the last one a window of feed, still open
//!   U_i   a travel open: max over c <= i of B_c - high_c / V (up), B_c + low_c / V (down)
//!
//!   B_i = max(F_i - seam_i, U_i-1 + low_i / V, B_i-1)          F_i = max(F_i-1 + least, B_i - seam_i)
//! ```
//!
//! B_i-1 represents a window of feed so short that its seams take all of it. This is the optimum
//! over all rows of windows and all joints; without seams and for one joint it is that of the
//! linear program (its dual has an optimum of zeros and ones, which is such a row).

use super::{Proof, ScheduleSearch};

/// Where a state comes from: gate at which the last window began, and what it is.
#[derive(Clone, Copy)]
enum LastWindow {
    Feed(usize),
    Travel { joint: usize, up: bool, from: usize },
}

impl ScheduleSearch<'_> {
    /// The best windows of feed and of travel of these joints.
    pub(super) fn travels(&self, joints: &[usize], [from, to]: [usize; 2]) -> Vec<Proof> {
        let all = &self.schedules.joints;
        let least = &self.schedules.least;
        // Of each joint and sense the best open travel, with its first gate.
        let mut open = vec![[(f64::NEG_INFINITY, from); 2]; joints.len()];
        let mut last = vec![LastWindow::Feed(from); to - from + 1];
        let mut closed = 0.0_f64;
        let mut feed = (f64::NEG_INFINITY, from);
        for i in from..=to {
            if i > from {
                feed.0 += least[i - 1];
                last[i - from] = LastWindow::Feed(i - 1);
                if feed.0 - self.seam(i) > closed {
                    (closed, last[i - from]) = (feed.0 - self.seam(i), LastWindow::Feed(feed.1));
                }
                for (slot, &joint) in joints.iter().enumerate() {
                    let [low, high] = all[joint].gates[i];
                    let velocity = all[joint].limits.velocity;
                    for (up, reach) in [(true, low), (false, -high)] {
                        let (value, begin) = open[slot][usize::from(up)];
                        let total = value + reach / velocity;
                        if total > closed {
                            (closed, last[i - from]) = (total, LastWindow::Travel { joint, up, from: begin });
                        }
                    }
                }
            }
            if closed - self.seam(i) > feed.0 {
                feed = (closed - self.seam(i), i);
            }
            for (slot, &joint) in joints.iter().enumerate() {
                let [low, high] = all[joint].gates[i];
                let velocity = all[joint].limits.velocity;
                for (up, leave) in [(true, -high), (false, low)] {
                    let value = closed + leave / velocity;
                    if value > open[slot][usize::from(up)].0 {
                        open[slot][usize::from(up)] = (value, i);
                    }
                }
            }
        }
        let mut proofs: Vec<Proof> = Vec::new();
        let mut at = to;
        while at > from {
            let begin = match last[at - from] {
                LastWindow::Feed(begin) => {
                    // Two windows of feed side by side prove no less as one.
                    let end = match proofs.last() {
                        Some(Proof::Feed { gates: [_, end] }) => {
                            let end = *end;
                            proofs.pop();
                            end
                        }
                        _ => at,
                    };
                    proofs.push(Proof::Feed { gates: [begin, end] });
                    begin
                }
                LastWindow::Travel { joint, up, from } => {
                    proofs.push(Proof::Travel { joint, gates: [from, at], up });
                    from
                }
            };
            at = begin;
        }
        proofs.reverse();
        proofs
    }
}
