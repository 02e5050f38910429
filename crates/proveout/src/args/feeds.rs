//! Options of `feeds`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Which feeds may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FeedModeArg {
    /// None: print what sets the feed of each block
    Analyse,
    /// Those of blocks that take no material
    Air,
    /// By chip thickness, and as `air`
    Chip,
    /// By all limits, and as `air`
    Force,
    /// By the chip thickness that the program has in 95 of 100 samples, and as `air`
    Learned,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    proveout feeds tests/feeds --program step --mode analyse --limits tests/feeds/limits.toml\n  \
    proveout feeds tests/feeds --program step --limits tests/feeds/limits.toml --output step-new.nc\n\n\
    Only F words change. The twin runs every new program; where joints, corners or the block cycle pace a block, its feed stays. \
    docs/feeds.md shows the file of limits and what is assumed.")]
pub(crate) struct FeedsArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Program of the scene (default: the first)
    #[arg(long, value_name = "NAME")]
    pub(crate) program: Option<String>,
    /// Program text in place of the one in the scene
    #[arg(long, value_name = "FILE")]
    pub(crate) nc: Option<PathBuf>,
    /// Limits of the tools, and the materials that they cut
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// Which feeds may change
    #[arg(long, value_enum, default_value = "force")]
    pub(crate) mode: FeedModeArg,
    /// Leave feeds that would change by less than this, percent
    #[arg(long, value_name = "PERCENT", default_value = "5")]
    pub(crate) dead_band: f64,
    /// Program to write, in the language of the original; each --mode but `analyse` needs it
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Write every block in feed as JSON: feeds, times, loads, and what sets the feed
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Write engagement and loads along the path as a Parquet table, by slices of the cutter
    #[arg(long, value_name = "FILE")]
    pub(crate) engagement: Option<PathBuf>,
    /// Cell size of the stock in place of the one in the scene, mm
    #[arg(long, value_name = "MM")]
    pub(crate) resolution_mm: Option<f64>,
    /// Number of worker threads (default: one per processor); the result is the same for any number
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Overwrite existing files
    #[arg(long)]
    pub(crate) force: bool,
}
