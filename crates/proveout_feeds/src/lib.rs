//! Cutting forces of milling from engagement, limits of tools, and the feeds that keep them.
//!
//! **Data in and out.** In: slices of the cutter in material with their velocities ([`SliceCut`]), a tool, a
//! [`Material`] and [`LimitsFile`]. Out: [`Loads`] (chip thickness, force, torque, power, deflection), the
//! largest feed under [`ToolLimits`], the feed of a block ([`feed_of_block`]). Lengths are mm, angles radian,
//! times seconds, forces N; other units are in the names. Angles are those of a tooth seen from the spindle:
//! 0 on the left of the feed, a quarter turn in front. No frame but that of the tool is known here.
//!
//! **Algorithm.** `force.rs` has the equations: mechanistic forces by slices and angles (Altintas 2012,
//! chapter 2) with the specific forces of Kienzle (1952).
//!
//! **Limits.** Quasi-static: neither chatter nor the paths of the teeth (trochoids) are known. Two regions of
//! engagement in one slice count as one, which makes forces larger. Drills and taps are no milling tools.
//!
//! ```
//! use std::path::Path;
//!
//! use proveout_feeds::{ForceModel, Material, SliceCut};
//! use proveout_tool::ToolLibrary;
//!
//! let tools = "[[tool]]\nnumber = 1\nname = \"F\"\nkind = \"flat\"\ndiameter_mm = 10\n\
//!              flute_length_mm = 20\ngauge_length_mm = 60\nflutes = 2\n";
//! let tools = ToolLibrary::from_text(Path::new("t.toml"), tools)?;
//! let steel = "name = \"C45\"\nsource = \"example\"\nconvention = \"chip-thickness\"\nkc11_n_mm2 = 1500\n\
//!              exponent = 0\nradial_ratio = 0.3\naxial_ratio = 0\nuncertainty_percent = 20\n";
//! let steel = Material::from_text(Path::new("m.toml"), steel)?;
//! let model = ForceModel::new(&tools.tools[0], steel, 1.0, None).expect("it has teeth");
//! // A slot 1 mm deep at 3000/min and 600 mm/min: 0.1 mm per tooth.
//! let range = Some([0.0, std::f64::consts::PI]);
//! let slot = SliceCut { height: [0.0, 1.0], range, around: false, feed_across: 10.0, feed_down: 0.0 };
//! let loads = model.loads(&[slot], 3000.0).expect("the spindle turns").at(1.0);
//! assert!((loads.chip_mm - 0.1).abs() < 1e-12);
//! assert!((loads.power_kw - 1500.0 * 1.0 * 10.0 * 600.0 / 60e6).abs() < 1e-6); // kc ap ae vf
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `material.rs` | cutting constants of a material |
//! | `cutter_edges.rs` | a cutter as elements of its edges |
//! | `force.rs` | forces, torque, power of one moment of a cut |
//! | `compliance.rs` | deflection of a stepped tool |
//! | `limits.rs` | limits of the tools, from a file |
//! | `solve.rs` | the largest feed under limits; the feed of a block |

mod compliance;
mod cutter_edges;
mod force;
mod limits;
mod material;
mod solve;

pub use compliance::Compliance;
pub use force::{CutLoads, ForceModel, Loads, SliceCut};
pub use limits::{FLUTED_PART, LimitsFile, ToolLimits};
pub use material::{Material, ThicknessConvention};
pub use solve::{Binds, BlockDemand, FeedMode, feed_of_block};
