use std::path::Path;

use proveout_record::{write_height_map_png, write_json};
use proveout_surface::texture::{
    ArealReport, Asked, Form, SettingClass, Standard, TextureReport,
    file::{self, Measured, SdfForm, TextureFileError, read_measured},
};
use serde::Serialize;

use crate::{
    args::{ClassArg, FormArg, MeasureArgs, StandardArg},
    failure::Failure,
};

/// Everything about one file, as `--json` and `--output X.json` give it.
#[derive(Serialize)]
struct TextureAnswer<'a> {
    file: String,
    format: &'static str,
    remarks: &'a [String],
    #[serde(flatten)]
    report: &'a TextureReport,
}

/// Whether a path names a file of texture: by its ending, else by its first bytes.
pub(crate) fn is_texture(path: &Path) -> bool {
    file::is_texture(path)
}

/// Parameters of a profile or a height map; false where something stays unchecked.
pub(crate) fn measure(args: &MeasureArgs, path: &Path, as_profile: bool) -> Result<bool, Failure> {
    let of_stock = [
        ("--section", args.section.is_some()),
        ("--distance", !args.distance.is_empty()),
        ("--wall", !args.wall.is_empty()),
        ("--design", args.design.is_some()),
    ];
    if let Some((option, _)) = of_stock.into_iter().find(|(_, given)| *given) {
        return Err(Failure::new(format!("{option} applies to a stock, but {} is a texture", path.display()))
            .with_help("omit it, or name a run folder"));
    }
    let asked = asked(args)?;
    let read = read_measured(path).map_err(|e| of_file(&e))?;
    let report = match &read.measured {
        Measured::Profile(profile) => TextureReport::of_profile(profile, &asked),
        Measured::Map(map) if as_profile => {
            return Err(Failure::new(format!(
                "the file contains a map of {} x {} points, not a profile",
                map.columns(),
                map.rows()
            ))
            .at(path.display(), 0, 0, 0, "")
            .with_help("omit --profile: `proveout measure FILE` evaluates the map"));
        }
        Measured::Map(_) if asked.to_lay.is_some() => {
            return Err(Failure::new("--to-lay-deg applies to a profile; the lay of a map is found from its data")
                .at(path.display(), 0, 0, 0, "")
                .with_help("omit it"));
        }
        Measured::Map(_) if args.standard.is_some() => {
            return Err(Failure::new(
                "--standard selects the definitions of profile parameters; maps are evaluated by ISO 25178-2",
            )
            .at(path.display(), 0, 0, 0, "")
            .with_help("omit it"));
        }
        Measured::Map(map) => TextureReport::of_map(map, &asked),
    };
    let answer = TextureAnswer {
        file: path.display().to_string(),
        format: read.format,
        remarks: &read.remarks,
        report: &report,
    };
    let ending = args.output.as_deref().map(|out| TextureFormat::of(out, &read.measured)).transpose()?;
    if args.json {
        let text = serde_json::to_string_pretty(&answer).map_err(Failure::new)?;
        say!("{text}");
    } else {
        say!("{}: {}", answer.file, answer.format);
        for remark in &read.remarks {
            say!("  remark: {remark}");
        }
        say!("{}", report.to_string().trim_end());
    }
    if let (Some(out), Some(ending)) = (&args.output, ending) {
        super::output_file::put(out, args.force, |beside| write(beside, ending, &answer, &read.measured))?;
        if !args.json {
            say!("written: {}", out.display());
        }
    }
    Ok(report.unchecked().next().is_none())
}

fn asked(args: &MeasureArgs) -> Result<Asked, Failure> {
    if let Some(angle) = args.to_lay_deg.filter(|a| !a.is_finite()) {
        return Err(
            Failure::new(format!("--to-lay-deg {angle} is not a finite angle")).with_help("give degrees, such as 90")
        );
    }
    if let Some(pitch) = args.pitch_mm.filter(|p| !(p.is_finite() && *p > 0.0)) {
        return Err(
            Failure::new(format!("--pitch-mm {pitch} must be above zero")).with_help("give a length above 0 mm")
        );
    }
    Ok(Asked {
        standard: match args.standard {
            None | Some(StandardArg::Iso21920) => Standard::Iso21920,
            Some(StandardArg::Iso4287) => Standard::Iso4287,
        },
        class: match args.class {
            Some(ClassArg::Sc1) => SettingClass::Sc1,
            Some(ClassArg::Sc2) => SettingClass::Sc2,
            None | Some(ClassArg::Sc3) => SettingClass::Sc3,
            Some(ClassArg::Sc4) => SettingClass::Sc4,
            Some(ClassArg::Sc5) => SettingClass::Sc5,
        },
        form: match args.form {
            None | Some(FormArg::Level) => Form::Level,
            Some(FormArg::None) => Form::None,
        },
        to_lay: args.to_lay_deg,
        pitch: args.pitch_mm,
    })
}

fn of_file(e: &TextureFileError) -> Failure {
    // Lines of heights are short and of no help; the place is.
    Failure::new(e).at(e.path.display(), e.line, 1, 1, "").with_help(&e.help)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum TextureFormat {
    Json,
    Png,
    Sdf,
    X3p,
}

impl TextureFormat {
    fn of(out: &Path, measured: &Measured) -> Result<Self, Failure> {
        let ending = match out.extension().and_then(|e| e.to_str()) {
            Some("json") => Self::Json,
            Some("png") => Self::Png,
            Some("sdf") => Self::Sdf,
            Some("x3p") => Self::X3p,
            _ => {
                return Err(Failure::new(format!("--output {}: unknown file extension for a texture", out.display()))
                    .with_help("use .json (everything), .png (picture of a map), .sdf or .x3p (the heights)"));
            }
        };
        if ending == Self::Png && matches!(measured, Measured::Profile(_)) {
            return Err(Failure::new(format!("--output {}: only a map can be drawn", out.display()))
                .with_help("use the extension .json"));
        }
        Ok(ending)
    }
}

fn write(out: &Path, ending: TextureFormat, answer: &TextureAnswer<'_>, measured: &Measured) -> Result<(), Failure> {
    match (ending, measured) {
        (TextureFormat::Json, _) => write_json(out, answer).map_err(Failure::new),
        (TextureFormat::Sdf, Measured::Map(map)) => file::write_sdf(out, map, SdfForm::Binary).map_err(|e| of_file(&e)),
        (TextureFormat::Sdf, Measured::Profile(profile)) => {
            file::write_sdf(out, profile, SdfForm::Binary).map_err(|e| of_file(&e))
        }
        (TextureFormat::X3p, Measured::Map(map)) => file::write_x3p(out, map).map_err(|e| of_file(&e)),
        (TextureFormat::X3p, Measured::Profile(profile)) => file::write_x3p(out, profile).map_err(|e| of_file(&e)),
        (TextureFormat::Png, Measured::Profile(_)) => Ok(()),
        (TextureFormat::Png, Measured::Map(map)) => {
            let area: Option<&ArealReport> = answer.report.area.as_ref();
            let (shown, title) = match area {
                Some(a) => match (&a.roughness, &a.filtered) {
                    (Some(roughness), Some(v)) => {
                        (roughness, format!("Sa {:.3} µm, L-filter {} mm", v.sa_um, a.l_filter_mm))
                    }
                    _ => (map, format!("unfiltered, Sa {:.3} µm", a.unfiltered.sa_um)),
                },
                None => (map, String::new()),
            };
            let lay = area.and_then(|a| a.lay_deg).map(f64::to_radians);
            write_height_map_png(out, shown, &title, lay).map_err(Failure::new)
        }
    }
}
