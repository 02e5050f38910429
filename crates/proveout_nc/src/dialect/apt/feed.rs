//! Motions before the first feed.
//!
//! CL data often begins without `FEDRAT`: the post-processor or the control has a feed of its own there. What it is stands
//! nowhere in the text, so that such a motion comes without a feed, with a note, unless the settings give one. A control refuses to
//! run a motion in feed without a feed.

use super::reader::AptReader;
use crate::Feed;

impl AptReader {
    /// Before a motion in feed: takes the feed of the settings where the program has given none.
    pub(crate) fn need_feed(&mut self) {
        if self.feed.is_some() {
            return;
        }
        let fresh = !std::mem::replace(&mut self.noted_no_feed, true);
        match self.default_feed {
            Some(feed) => {
                if fresh {
                    self.assume(format!(
                        "motions before the first FEDRAT run at the feed of the settings, {} mm/min",
                        feed * 60.0
                    ));
                }
                let feed = Feed::PerTime(feed);
                self.feed = Some(feed);
                self.tell_feed(feed);
            }
            None if fresh => {
                self.note(
                    "no feed yet: motions before the first FEDRAT have none; write FEDRAT, or give a default feed",
                );
            }
            None => {}
        }
    }
}
