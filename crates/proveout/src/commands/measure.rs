use std::path::Path;

use proveout_record::{write_json, write_section_csv, write_section_svg};
use proveout_sim::measure::{Answers, Questions, measure as ask};

use super::{
    output_file::{check, put},
    roughness,
};
use crate::{args::MeasureArgs, failure::Failure};

/// Micrometers of a millimeter.
const UM_PER_MM: f64 = 1e3;

/// Measures a stock or a texture: lines on standard output, and a file where one is asked for. False where a
/// texture stays unchecked.
pub(crate) fn measure(args: &MeasureArgs) -> Result<bool, Failure> {
    match (&args.profile, &args.file) {
        (Some(profile), _) => roughness::measure(args, profile, true),
        (None, Some(file)) if roughness::is_texture(file) => roughness::measure(args, file, false),
        (None, Some(file)) => measure_stock(args, file).map(|()| true),
        (None, None) => Err(Failure::new("no input given").with_help("name a run folder or a file")),
    }
}

fn measure_stock(args: &MeasureArgs, stock: &Path) -> Result<(), Failure> {
    let texture = [
        ("--class", args.class.is_some()),
        ("--standard", args.standard.is_some()),
        ("--form", args.form.is_some()),
        ("--to-lay-deg", args.to_lay_deg.is_some()),
        ("--pitch-mm", args.pitch_mm.is_some()),
        ("--json", args.json),
    ];
    if let Some((option, _)) = texture.into_iter().find(|(_, given)| *given) {
        return Err(Failure::new(format!("{option} applies to textures, but {} is a stock", stock.display()))
            .with_help("omit it, or name a texture file (SDF, X3P, SMD)"));
    }
    let questions = Questions {
        stock: stock.to_path_buf(),
        design: args.design.clone(),
        section: args.section.as_deref().map(plane).transpose()?,
        distances: args.distance.iter().map(|t| numbers("--distance", t, "X,Y,Z")).collect::<Result<_, _>>()?,
        walls: args.wall.iter().map(|t| line(t)).collect::<Result<_, _>>()?,
    };
    if questions.section.is_none() && questions.distances.is_empty() && questions.walls.is_empty() {
        return Err(Failure::new("no measurement requested")
            .with_help("add --section z=12.5, --distance 10,0,5 or --wall 0,-3,-1,0,1,0"));
    }
    let ending = args.output.as_deref().map(|out| ending(out, questions.section.is_some())).transpose()?;
    args.output.as_deref().map_or(Ok(()), |out| check(out, args.force))?;
    let answers = ask(&questions).map_err(|e| Failure::from(&e))?;
    print(&answers);
    let (Some(out), Some(ending)) = (&args.output, ending) else { return Ok(()) };
    put(out, args.force, |out| {
        let written = match (ending, &answers.section) {
            (MeasureFormat::Svg, Some(section)) => write_section_svg(out, section),
            (MeasureFormat::Csv, Some(section)) => write_section_csv(out, section),
            _ => write_json(out, &answers),
        };
        written.map_err(Failure::new)
    })?;
    say!("written: {}", out.display());
    Ok(())
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum MeasureFormat {
    Svg,
    Csv,
    Json,
}

fn ending(out: &Path, with_section: bool) -> Result<MeasureFormat, Failure> {
    let ending = match out.extension().and_then(|e| e.to_str()) {
        Some("svg") => MeasureFormat::Svg,
        Some("csv") => MeasureFormat::Csv,
        Some("json") => MeasureFormat::Json,
        _ => {
            return Err(Failure::new(format!("--output {}: unknown file extension", out.display()))
                .with_help("use .json (everything), .svg or .csv (the section)"));
        }
    };
    if ending != MeasureFormat::Json && !with_section {
        return Err(Failure::new(format!("--output {}: only a section can be drawn", out.display()))
            .with_help("add --section z=12.5, or use the extension .json"));
    }
    Ok(ending)
}

/// `z=12.5` as axis and coordinate.
fn plane(text: &str) -> Result<(usize, f64), Failure> {
    let wrong = || {
        Failure::new(format!("--section {text} is not a plane"))
            .with_help("write x=, y= or z= and a number in mm, such as z=12.5")
    };
    let (axis, at) = text.split_once('=').ok_or_else(wrong)?;
    let axis = ["x", "y", "z"].iter().position(|name| axis.trim().eq_ignore_ascii_case(name)).ok_or_else(wrong)?;
    let at: f64 = at.trim().parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(wrong)?;
    Ok((axis, at))
}

fn numbers<const N: usize>(option: &str, text: &str, form: &str) -> Result<[f64; N], Failure> {
    let all: Vec<f64> =
        text.split(',').filter_map(|part| part.trim().parse().ok()).filter(|v: &f64| v.is_finite()).collect();
    let given = text.split(',').count();
    match <[f64; N]>::try_from(all) {
        Ok(numbers) if given == N => Ok(numbers),
        _ => Err(Failure::new(format!("{option} {text} is not {form}"))
            .with_help(format!("write {N} numbers in mm, separated by commas, without spaces"))),
    }
}

fn line(text: &str) -> Result<([f64; 3], [f64; 3]), Failure> {
    let [x, y, z, i, j, k] = numbers("--wall", text, "X,Y,Z,DX,DY,DZ")?;
    Ok(([x, y, z], [i, j, k]))
}

fn print(a: &Answers) {
    let [x, y, z] = a.cells_mm;
    say!(
        "{}: cells of {x} x {y} x {z} mm, swept surface within {:.2} µm on its rays",
        a.stock,
        UM_PER_MM * a.sweep_bound_mm
    );
    if let Some(s) = &a.section {
        let holes = s.stock.outlines.iter().filter(|o| o.area_mm2 < 0.0).count();
        let length: f64 = s.stock.outlines.iter().map(|o| o.length_mm).sum();
        let design = s.design.as_ref().map_or_else(String::new, |d| format!("; design {:.4} mm²", d.area_mm2));
        say!(
            "section {}={} mm: {:.4} mm²; outlines round material {}, round holes {holes}, {length:.4} mm long{design}",
            s.axis,
            s.at_mm,
            s.stock.area_mm2,
            s.stock.outlines.len() - holes
        );
    }
    let place = |p: &[f64; 3]| format!("X{:.4} Y{:.4} Z{:.4}", p[0], p[1], p[2]);
    for d in &a.distances {
        let design = match (d.design_distance_mm, d.deviation_mm) {
            (Some(from), Some(deviation)) => {
                format!("; design {from:.4} mm, the stock deviates by {deviation:+.4} mm there")
            }
            _ => String::new(),
        };
        let side = if d.distance_mm < 0.0 { "in material" } else { "outside" };
        say!(
            "distance of {}: {:.4} mm, {side}, to {}{design}",
            place(&d.place_mm),
            d.distance_mm,
            place(&d.nearest_mm)
        );
    }
    for w in &a.walls {
        let design = w.design_thickness_mm.map_or_else(String::new, |t| format!("; design {t:.4} mm"));
        let [i, j, k] = w.direction;
        match (w.thickness_mm, &w.faces_mm) {
            (Some(t), Some([from, to])) => {
                say!(
                    "wall from {} along {i},{j},{k}: {t:.4} mm, {} to {}{design}",
                    place(&w.from_mm),
                    place(from),
                    place(to)
                );
            }
            _ => say!("wall from {} along {i},{j},{k}: no material ahead{design}", place(&w.from_mm)),
        }
    }
}
