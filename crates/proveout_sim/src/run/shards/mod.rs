//! One run on several machines: its stock in shards, its motion planned before.
//!
//! ```text
//!   plan     program ─► control ─► pieces of motion ──► motion.bin   what each stretch asks of the stock
//!                                  which tile comes to whom ► raw-stock.dexel of each shard
//!   shard k  motion.bin, raw-stock.dexel ─► cut ──────► cuts.bin     what became of each tile, by stretches
//!   merge    the run as ever; where it would cut, it takes what all shards say
//! ```
//!
//! The merged run plans its motion, follows bodies, looks for loose parts and judges as any other
//! run: there is one way to a verdict. So its folder has the bytes of a run that was never split,
//! for any number of shards. The merged run itself cuts a stretch that has to be cut in parts,
//! since a body comes near the stock within it. It also cuts everything after a part that came off
//! the stock, of which the shards do not know. Motion is planned twice in all, however many shards
//! there are.
//!
//! Rows of tiles of the stock and of its patches go to the shards by load: the heaviest first, to whoever has
//! least, where the load of a tile is the number of sweeps that come to it before anything is cut
//! ([`proveout_stock::TriDexel::share_rows`]). A shard needs motion and its own stock alone: no scene, no
//! machine, no mesh.
//!
//! *Limits.* Collision, judgement and the surface are not split, and plan and merge hold the whole stock.

mod cut;
mod motion;

pub use crate::cut::shard_cuts::{ShardCuts, ShardFacts};
pub use cut::{ShardCost, cut_shard};
pub use motion::{MOTION, MotionPlan, plan_motion, raw_files};

pub use crate::cut::shard_records::ShardError;
