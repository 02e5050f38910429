//! Stocks of other moments, poses and cells, and stocks in shares: files, what sweeps did, the way back,
//! re-gridding, patches.

pub(crate) mod clip;
pub(crate) mod codec;
pub(crate) mod depth_state;
pub(crate) mod file;
pub(crate) mod history;
pub(crate) mod patch;
pub(crate) mod regrid;
pub(crate) mod share;
pub(crate) mod sweep_log;
pub(crate) mod take_part;
