//! Options of the commands about what runs have left, and of those that install: measure, diff, view, verify,
//! sign, completions, manual.

use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Shell to complete for
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
    /// Output file, such as `/etc/bash_completion.d/proveout`
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ManualArgs {
    /// Output folder, such as /usr/local/share/man/man1
    #[arg(value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Overwrite existing pages
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("what").required(true).args(["file", "profile"]))]
#[command(after_help = "Examples:\n  \
    proveout measure out/part-main --section z=-12.5 --output section.svg\n  \
    proveout measure out/part-main --section x=0 --design part.stl --output section.json\n  \
    proveout measure out/part-main --distance 10,0,5 --distance 10,0,-5\n  \
    proveout measure out/part-main/stock.dexel --wall 0,-3,-1,0,1,0 --design part.stl\n  \
    proveout measure --profile gauge.smd --class Sc2 --to-lay-deg 90\n  \
    proveout measure --profile gauge.smd --standard iso4287 --json\n  \
    proveout measure patch.sdf --output patch.png\n\n\
    Stock: coordinates are in the workpiece frame, mm. Between rays the surface is that of the stock's mesh; on a face of \
    curvature radius r its error is about cell²/8r. A distance inside material is negative.\n\
    Texture: if the pitch of the marks exceeds the cut-off of the class, use the next class. A parameter that the data cannot \
    support is unchecked, with the reason, and the exit code is 3.")]
pub(crate) struct MeasureArgs {
    /// Run folder, stock file (.dexel) from it, or texture file: height map or profile (SDF, X3P, SMD)
    #[arg(value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
    /// Cut a section with a plane normal to an axis, such as z=12.5 (mm)
    #[arg(long, value_name = "AXIS=MM", allow_hyphen_values = true)]
    pub(crate) section: Option<String>,
    /// Measure the distance from a point to the surface, mm; may be repeated
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) distance: Vec<String>,
    /// Measure the thickness of the first wall that a ray from a point along a direction hits; may be
    /// repeated
    #[arg(long, value_name = "X,Y,Z,DX,DY,DZ", allow_hyphen_values = true)]
    pub(crate) wall: Vec<String>,
    /// Measure this design as well: a closed mesh in the workpiece frame, mm (STL, OBJ, glTF)
    #[arg(long, value_name = "MESH")]
    pub(crate) design: Option<PathBuf>,
    /// Profile file (SMD, SDF, X3P): compute the parameters of ISO 21920-2 or ISO 4287
    #[arg(long, value_name = "FILE")]
    pub(crate) profile: Option<PathBuf>,
    /// Setting class of the texture, Sc1 to Sc5 (default: Sc3); its cut-off is the L-filter of height maps
    #[arg(long, value_enum)]
    pub(crate) class: Option<ClassArg>,
    /// Definitions of the profile parameters (default: iso21920)
    #[arg(long, value_enum)]
    pub(crate) standard: Option<StandardArg>,
    /// Form removal of the texture (default: level)
    #[arg(long, value_enum)]
    pub(crate) form: Option<FormArg>,
    /// Angle between profile and lay, degrees: 0 along the marks, 90 across them (default: unknown)
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub(crate) to_lay_deg: Option<f64>,
    /// Pitch of the marks, mm (default: found from the data)
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub(crate) pitch_mm: Option<f64>,
    /// Print the texture as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Result file: .json for everything; .svg or .csv for the section; .png, .sdf or .x3p for the texture
    #[arg(long, value_name = "FILE", alias = "out")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ClassArg {
    /// Cut-off 0.08 mm
    #[value(name = "Sc1", alias = "sc1")]
    Sc1,
    /// Cut-off 0.25 mm
    #[value(name = "Sc2", alias = "sc2")]
    Sc2,
    /// Cut-off 0.8 mm
    #[value(name = "Sc3", alias = "sc3")]
    Sc3,
    /// Cut-off 2.5 mm
    #[value(name = "Sc4", alias = "sc4")]
    Sc4,
    /// Cut-off 8 mm
    #[value(name = "Sc5", alias = "sc5")]
    Sc5,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum StandardArg {
    /// ISO 21920-2:2021: Ra, Rq, Rsk, Rku over the evaluation length
    Iso21920,
    /// ISO 4287:1997+A1:2009: Ra, Rq, Rsk, Rku as mean of the sampling lengths
    Iso4287,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormArg {
    /// Subtract the least-squares line of a profile, the least-squares plane of a map
    Level,
    /// Subtract nothing
    None,
}

#[derive(Debug, Args)]
pub(crate) struct DiffArgs {
    /// Older run folder
    pub(crate) run_a: PathBuf,
    /// Newer run folder
    pub(crate) run_b: PathBuf,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code: 0 nothing is wrong, what is missing is named; 2 something is there and cannot be used."
)]
pub(crate) struct DoctorArgs {
    /// Print JSON: a list of name, state (ok, missing, wrong), found, remedy
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// Run folder
    pub(crate) run: PathBuf,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code: 0 nothing has changed since the run; 1 a file of the run folder has changed, or the signature is \
                        not valid; 3 the folder is unchanged, but an input has changed or cannot be found."
)]
pub(crate) struct VerifyArgs {
    /// Run folder, or the folder of a comparison
    pub(crate) run: PathBuf,
    /// Folder of the scene, or its scene.toml (default: from the manifest)
    #[arg(long, value_name = "SCENE")]
    pub(crate) scene: Option<PathBuf>,
    /// Ed25519 public key (PEM) of the expected signer; the manifest must carry its signature
    #[arg(long, value_name = "FILE")]
    pub(crate) public_key: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct SignArgs {
    /// Run folder, or the folder of a comparison
    pub(crate) run: PathBuf,
    /// Ed25519 private key (PEM), as created by `openssl genpkey -algorithm ed25519`
    #[arg(long, value_name = "FILE")]
    pub(crate) key: PathBuf,
}
