//! What keeps a STEP file from being read, with its remedy.

use std::path::PathBuf;

use proveout_geom::MeshError;
use thiserror::Error;

/// Why there is no mesh of a STEP file.
#[derive(Debug, Error)]
pub enum StepError {
    /// The file is missing, too large, or may not be read.
    #[error("cannot open {path}: {source}")]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is no STEP file, or one that is not read.
    #[error("{path}{}: {message}", line.map_or_else(String::new, |l| format!(":{l}")))]
    Text {
        /// The file.
        path: PathBuf,
        /// Line of the text, from 1, where one is at fault.
        line: Option<usize>,
        /// What is wrong.
        message: String,
        /// What to do.
        help: String,
    },
    /// No helper is installed, or the variable names none.
    #[error("{path}: {message}")]
    NoHelper {
        /// The STEP file.
        path: PathBuf,
        /// What is missing.
        message: String,
    },
    /// The helper has refused the file, failed, or passed a limit.
    #[error("{path}: {helper}: {message}")]
    Helper {
        /// The STEP file.
        path: PathBuf,
        /// The program.
        helper: PathBuf,
        /// What it said, or how it ended.
        message: String,
        /// What to do.
        help: String,
    },
    /// What the helper wrote contradicts the file or itself.
    #[error("{path}: the answer of {helper} is not used: {message}")]
    Answer {
        /// The STEP file.
        path: PathBuf,
        /// The program.
        helper: PathBuf,
        /// The contradiction.
        message: String,
    },
    /// Faces or solids of the file are not in what the kernel read.
    #[error("{path}: {message}")]
    Lost {
        /// The STEP file.
        path: PathBuf,
        /// Which.
        message: String,
    },
    /// A solid whose mesh is not closed.
    #[error("{path}: {solid}: {source}")]
    OpenSolid {
        /// The STEP file.
        path: PathBuf,
        /// Which solid.
        solid: String,
        /// The defect.
        source: MeshError,
    },
    /// A solid whose mesh encloses another volume than its surfaces.
    #[error(
        "{path}: {solid}: its mesh encloses {mesh_mm3:.3} mm3, its surfaces {exact_mm3:.3} mm3; the chord error explains {allowed_mm3:.3} mm3"
    )]
    Volume {
        /// The STEP file.
        path: PathBuf,
        /// Which solid.
        solid: String,
        /// Volume of the mesh, mm³.
        mesh_mm3: f64,
        /// Volume by the kernel, mm³.
        exact_mm3: f64,
        /// Area times chord error, mm³.
        allowed_mm3: f64,
    },
}

impl StepError {
    /// What to do.
    pub fn help(&self) -> String {
        match self {
            Self::Open { .. } => "correct the path, or put the file there".into(),
            Self::Text { help, .. } | Self::Helper { help, .. } => help.clone(),
            Self::NoHelper { .. } => {
                "install it: pip install \"proveout[step]\" (or set PROVEOUT_STEP to the program), or export the solid as STL".into()
            }
            Self::Answer { .. } => "install the helper of this version: pip install --upgrade \"proveout[step]\"".into(),
            Self::Lost { .. } => {
                "the part would be smaller than the file says: export it again, or as STL from the CAD system".into()
            }
            Self::OpenSolid { .. } | Self::Volume { .. } => {
                "mend the solid in the CAD system and export it again, or ask for another `chord_um`".into()
            }
        }
    }
}
