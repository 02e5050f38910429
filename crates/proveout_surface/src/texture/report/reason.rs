use serde::{Serialize, Serializer, ser::SerializeStruct};

/// Why filtered values are missing. As JSON: `{"rule": "too-short", "text": "..."}`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unchecked {
    /// The marks lie farther apart than the cut-off, and the data do not carry the class that would let them
    /// pass.
    #[error(
        "a pitch of {pitch_mm:.4} mm lies beyond lambda_c = {lambda_c_mm} mm of class {class}; {}",
        next.map_or("no class goes farther: judge the unfiltered values".to_owned(), |n| format!("class {n} would let it pass"))
    )]
    PitchBeyondCutoff {
        /// Pitch of the marks, mm.
        pitch_mm: f64,
        /// Cut-off, mm.
        lambda_c_mm: f64,
        /// Class of the cut-off.
        class: &'static str,
        /// The class that was tried instead.
        next: Option<&'static str>,
    },
    /// The data are shorter than the evaluation length.
    #[error(
        "{length_mm:.4} mm are shorter than the evaluation length of class {class}, {wanted_mm} mm: give a longer profile{}",
        smaller.map_or(String::new(), |s| format!(", or ask for class {s}"))
    )]
    TooShort {
        /// Length at hand, mm.
        length_mm: f64,
        /// Length wanted, mm.
        wanted_mm: f64,
        /// Class.
        class: &'static str,
        /// Largest class whose evaluation length fits.
        smaller: Option<&'static str>,
    },
    /// The points lie too far apart.
    #[error("points every {spacing_um:.4} µm cannot carry class {class}, which needs {limit_um} µm or less")]
    TooCoarse {
        /// Spacing, um.
        spacing_um: f64,
        /// Largest one, um.
        limit_um: f64,
        /// Class.
        class: &'static str,
    },
    /// The points lie closer than what is filtered in reasonable time.
    #[error(
        "points every {spacing_um:.6} µm are closer than {limit_um} µm, the finest that is filtered for class {class}: thin them out"
    )]
    TooFine {
        /// Spacing, um.
        spacing_um: f64,
        /// Smallest one, um.
        limit_um: f64,
        /// Class.
        class: &'static str,
    },
    /// The L-filter is longer than the map.
    #[error(
        "the L-filter of {cutoff_mm} mm (class {class}) is longer than the patch of {x_mm:.4} x {y_mm:.4} mm: give a larger patch, or ask for a smaller class"
    )]
    CutoffBeyondPatch {
        /// Nesting index, mm.
        cutoff_mm: f64,
        /// Class that it belongs to.
        class: &'static str,
        /// Extent along x, mm.
        x_mm: f64,
        /// Extent along y, mm.
        y_mm: f64,
    },
}

impl Unchecked {
    /// The rule by name, for tables and gates.
    pub fn rule(&self) -> &'static str {
        match self {
            Self::PitchBeyondCutoff { .. } => "pitch-beyond-cutoff",
            Self::TooShort { .. } => "too-short",
            Self::TooCoarse { .. } => "spacing-too-coarse",
            Self::TooFine { .. } => "spacing-too-fine",
            Self::CutoffBeyondPatch { .. } => "cutoff-beyond-patch",
        }
    }
}

impl Serialize for Unchecked {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_struct("Unchecked", 2)?;
        out.serialize_field("rule", self.rule())?;
        out.serialize_field("text", &self.to_string())?;
        out.end()
    }
}
