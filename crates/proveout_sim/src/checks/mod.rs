//! The checks of a run: each is one file, with its finding codes, its gate, its limits, its wording and its
//! state.
//!
//! A check implements [`Check`]. The engine ([`Engine`](crate::cut::engine::Engine)) cuts and
//! follows a stretch of motion, and then shows it to the checks in the order of the list [`CheckList::new`].
//! A check sees
//!
//! | when | what | method |
//! |---|---|---|
//! | a stretch is cut | [`StretchView`]: motion, sweeps, hits, events | `stretch` |
//! | a motion block ends | [`BlockEnd`]: what it removed, its tool | `block` |
//! | the run ends | [`RunEnd`]: tools used, final figures of breaches | `finish` |
//!
//! and writes findings, and what it did not decide, into the [`FindingLog`].
//!
//! **Order.** The log keeps the order in which findings come, and joins repeats. For each stretch it is
//!
//! 1. parts of the stock that have come off and move on (engine);
//! 2. a note where the history of the stock grows too large (engine);
//! 3. `stretch` of every check, in the order of the list;
//! 4. parts that have come off in this stretch (engine);
//! 5. `block` of every check, for each block that ends in the stretch.
//!
//! At the end of the run the parts that have come off come first, then `finish` of every check. Words that a
//! check leaves out are in the reason of its gate in the order of the list.
//!
//! **A new check** is one file here with its `mod`, and one line in the list. Its code is a row of
//! [`CODES`](crate::verdict::finding::CODES), which names the gate, and has a page in `docs/findings`. A
//! check of one part of the tool against the stock is a [`ContactCheck`](tool_contact::ContactCheck) and a
//! line in the list of `tool_in_material.rs`, since the findings of these come in the order of the sweeps.
//!
//! | check | findings |
//! |---|---|
//! | `flat_meshes.rs` | `setup-mesh-flat` |
//! | `step_files.rs` | `setup-step-read`, `setup-step-coarse` |
//! | `stock_at_rest.rs` | `collision-stock-at-rest` |
//! | `plunge.rs` | `process-plunge` |
//! | `tool_in_material.rs` | asks the next three, sweep by sweep |
//! | `cutter_in_material.rs` | `process-rapid-in-material`, `-spindle-off`, `-spindle-wrong-way` |
//! | `neck_and_shank.rs` | `process-neck-rubs`, `process-shank-rubs` |
//! | `holder_near_stock.rs` | `collision-holder-stock`, `collision-near-miss` |
//! | `no_tool.rs` | `process-no-tool` |
//! | `body_hits.rs` | `collision-bodies`, `collision-near-miss` |
//! | `stock_hits.rs` | `collision-stock-body`, `collision-near-miss` |
//! | `control_events.rs` | what the control reports: `program-stopped`, `limits-unreachable` and others |
//! | `joint_limits.rs` | `limits-overtravel`, `-planned-motion`, `-drive-saturated`, `-spindle-speed` |
//! | `contour_overcut.rs` | `geometry-overcut`, `geometry-contour-touched` |
//! | `leg_limits.rs` | `limits-overtravel` and `limits-planned-motion` of the legs of a platform |
//! | `tap_pitch.rs` | `process-tap-pitch` |
//!
//! | shared by checks | what it does |
//! |---|---|
//! | `assumed_values.rs` | values that nobody has measured, in words |
//! | `block_slope.rs` | the slope of a block as programmed |
//! | `check.rs` | what a check is, and what it sees |
//! | `descent.rs` | going down with a tool without edges at its center |
//! | `engagement.rs` | engagement of the cutter in a block |
//! | `thread_strokes.rs` | what taps cut outside of the core holes of the design |
//! | `tool_contact.rs` | a part of the tool in material |

pub(crate) mod check;
pub(crate) mod engagement;
pub(crate) mod thread_strokes;

mod assumed_values;
mod block_slope;
mod body_hits;
mod contour_overcut;
mod control_events;
mod cutter_in_material;
pub(crate) mod descent;
mod flat_meshes;
mod holder_near_stock;
mod joint_limits;
mod leg_limits;
mod neck_and_shank;
mod no_tool;
mod plunge;
mod step_files;
mod stock_at_rest;
mod stock_hits;
mod tap_pitch;
mod tool_contact;
mod tool_in_material;

use check::{BlockEnd, Check, RunEnd, StretchView};

use crate::{cut::stock_bodies::AtRest, verdict::log::FindingLog};

/// The checks of a run, in the order in which they run.
pub(crate) struct CheckList(Vec<Box<dyn Check>>);

impl CheckList {
    /// `at_rest`: overlaps of the raw stock with what moves as one with it.
    pub(crate) fn new(at_rest: Vec<AtRest>) -> Self {
        Self(vec![
            Box::new(flat_meshes::FlatMeshes::default()),
            Box::new(step_files::StepInputs::default()),
            Box::new(stock_at_rest::StockAtRest::new(at_rest)),
            Box::new(plunge::Plunge::default()),
            Box::new(tool_in_material::ToolInMaterial::default()),
            Box::new(no_tool::NoTool),
            Box::new(body_hits::BodyHits::default()),
            Box::new(stock_hits::StockHits::default()),
            Box::new(control_events::ControlEvents),
            Box::new(leg_limits::LegLimits),
            Box::new(tap_pitch::TapPitch),
        ])
    }

    /// See [`Check::stretch`].
    pub(crate) fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        self.0.iter_mut().for_each(|check| check.stretch(view, log));
    }

    /// See [`Check::block`].
    pub(crate) fn block(&mut self, end: &BlockEnd<'_>, log: &mut FindingLog) {
        self.0.iter_mut().for_each(|check| check.block(end, log));
    }

    /// See [`Check::finish`].
    pub(crate) fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        self.0.iter_mut().for_each(|check| check.finish(end, log));
    }
}
