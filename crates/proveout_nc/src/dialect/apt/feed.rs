//! Motions before the first feed.
//!
//! CL data often begins without `FEDRAT`: the post-processor or the control has a feed of its own
//! there. The text does not give its value, so such a motion comes without a feed, with a note,
//! unless the settings give one. A control refuses to run a feed motion without a feed.

use super::reader::AptReader;
use crate::Feed;

impl AptReader {
    /// Before a feed motion: takes the feed of the settings if the program has given none.
    pub(crate) fn need_feed(&mut self) {
        if self.technology.feed.is_some() {
            return;
        }
        let given = self.settings.default_feed_mm_per_min.filter(|feed| *feed > 0.0 && feed.is_finite());
        let fresh = !std::mem::replace(&mut self.own.noted_no_feed, true);
        match given {
            Some(feed) => {
                if fresh {
                    self.assume(format!(
                        "motions before the first FEDRAT run at {feed} mm/min, as --feed or the control file says"
                    ));
                }
                self.set_feed(Some(Feed::PerTime(feed / 60.0)));
                self.tell_feed();
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
