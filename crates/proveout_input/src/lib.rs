//! Input files: text in TOML becomes a value, and what is wrong becomes one error with place and remedy.
//!
//! Data in: the path of a file, or its text. Data out: a value, or an [`InputError`] that names file, line,
//! column, key, value and remedy. A key ends in its unit (`_mm`, `_deg`, `_mm_min`), and a value has the unit
//! of its key; [`in_millimeters`] turns the lengths of a file in inch into mm. A file states its frames in
//! its keys: this crate knows none.
//!
//! * [`Document`] – a TOML text that is read into a type, with the position of every key.
//! * [`InputError`] – the one error of input files; [`read_input`] reads a file or gives this error.
//! * [`check_quantities`] – ranges of numbers, by the unit in which a key ends.
//! * [`migrate()`] – the text of a file with the names that its keys have today.
//! * [`read_regular_file`] – bytes of a file up to a limit; pipes and devices are refused.
//!
//! ```
//! use proveout_input::{Document, Step};
//!
//! #[derive(serde::Deserialize)]
//! #[serde(deny_unknown_fields)]
//! struct Block {
//!     height_mm: f64,
//! }
//! let file = std::path::Path::new("block.toml");
//! let document = Document::new(file, "height_mm = 20\n");
//! let block: Block = document.read()?;
//! assert_eq!(block.height_mm, 20.0);
//! // A fault that the caller finds later has a position as well.
//! let key = [Step::Key("height_mm")];
//! let fault = document.error("block-too-high", &key, "is above 10 mm", "take a lower block");
//! assert_eq!((fault.line, fault.key.as_str()), (1, "height_mm"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `document.rs` | [`Document`]: text, syntax tree, positions of keys |
//! | `document/` | refusal of surplus list members, the reader's errors by kind and in words |
//! | `input_error.rs` | [`InputError`] and its parts |
//! | `quantities.rs` | ranges by unit, as checks and as `minimum` and `maximum` of the JSON schemas |
//! | `inch.rs` | files that count in inch |
//! | `renamed_keys.rs` | keys that had another name before |
//! | `migrate.rs` | files with old keys become files with new ones |
//! | `regular_file.rs` | files of bounded size |
//! | `xml_attributes.rs` | the bound of attributes before XML is parsed |

mod document;
mod inch;
mod input_error;
mod migrate;
mod quantities;
mod regular_file;
mod renamed_keys;
mod xml_attributes;

pub use document::{Document, ExpectedType, Step, TomlFault, nearest};
pub use inch::{add_inches_to_schema, in_millimeters};
pub use input_error::{InputError, InputFault, read_input};
pub use migrate::{KeyChange, Migration, migrate};
pub use quantities::{MAX_LENGTH_MM, OutOfRange, add_ranges_to_schema, check_quantities, check_quantity, range_of};
pub use regular_file::{open_regular_file, read_regular_file, read_regular_text};
pub use renamed_keys::{InputFileKind, renamed_key};
pub use xml_attributes::element_with_more_attributes;
