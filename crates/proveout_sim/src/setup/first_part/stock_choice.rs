//! Stock and design of a first part: what call and text say, what is proposed, and whether they have to do
//! with each other.

use std::{
    fs::File,
    io::Read as _,
    path::{Path, PathBuf},
};

use proveout_geom::{Aabb, Point, TriMesh, read_mesh};
use proveout_step::{DEFAULT_CHORD_UM, StepFiles, is_step};
use proveout_tool::LengthUnit;

use super::{
    Design, FirstPart, FirstPartError, Reasoned, StockForm, Tools, facts,
    interview::{self, Interview, PROPOSED},
    place::{self, Fit, Swept},
    refused,
};
use crate::prepare::{error::SimError, program_extent::ToolUse};

/// Scale of the six decimals that a length in inches is written with.
const SIX_DECIMALS: f64 = 1e6;

pub(super) fn design(call: &FirstPart) -> Result<Option<Design>, FirstPartError> {
    let Some(path) = &call.design else { return Ok(None) };
    let mesh = solid(path, &call.step_files)?;
    Ok(Some(Design { path: path.clone(), mesh, inch: false }))
}

/// Endings of solids that are no meshes.
const SOLIDS: [&str; 10] = ["p21", "iges", "igs", "x_t", "x_b", "sldprt", "ipt", "prt", "catpart", "f3d"];

/// A closed mesh from a file, or the solids of a STEP file; any other file is refused, with a remedy.
fn solid(path: &Path, step_files: &StepFiles) -> Result<TriMesh, FirstPartError> {
    if is_step(path) {
        return Ok(step_files.read(path, DEFAULT_CHORD_UM)?.mesh.clone());
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let mut head = [0; 12];
    let step = File::open(path).and_then(|mut f| f.read_exact(&mut head)).is_ok() && &head == b"ISO-10303-21";
    if step || SOLIDS.contains(&ending.as_str()) {
        if step {
            let message = format!("{} is a STEP file by its content, and has another ending", path.display());
            return Err(refused(message, "let its name end in .step or .stp"));
        }
        return Err(refused(
            format!("{} is a solid of a CAD system, which is not read", path.display()),
            "export the solid as STEP, or as STL from the CAD system, in millimeters and in the coordinates of the program, to a hundredth of a millimeter",
        ));
    }
    let mesh = read_mesh(path).map_err(|e| {
        refused(
            e.to_string(),
            "export it again as STL (binary or text), OBJ or glTF, in the coordinates of the program",
        )
    })?;
    mesh.check_solid().map_err(|source| SimError::Mesh { path: path.to_owned(), source })?;
    Ok(mesh)
}

/// Asks for the unit of a design that would fit if its numbers were inches.
pub(super) fn unit_of_design(
    design: Design,
    all_facts: &[facts::Facts],
    room: &Aabb,
    unit: Option<&(LengthUnit, String)>,
    interview: &mut Interview<'_, '_>,
) -> Result<Option<Design>, FirstPartError> {
    let mut room = *room;
    if let Some((stock, ..)) = all_facts.iter().find_map(|f| f.stock.clone()) {
        room = room.union(&form_of(&stock).aabb());
    }
    // It states its unit.
    if is_step(&design.path) {
        return Ok(Some(design));
    }
    let key = "design_unit";
    let given = interview.given(key);
    // Where nothing is cut, nothing shows the size of the part.
    if given.is_none() && room.is_empty() {
        return Ok(Some(design));
    }
    if given.is_none() && place::fit(&design.mesh.aabb(), &room) != Fit::InInch {
        return Ok(Some(design));
    }
    let answer = match given {
        Some(answer) => Some(answer),
        None => {
            let (size, cuts) = (design.mesh.aabb().size(), room.size());
            let word = unit
                .map_or_else(String::new, |(_, word)| format!(", and the program counts in inch by {word}"))
                .replace(", and the program counts in inch by G21", "");
            let text = format!(
                "Are the numbers of {} inches? Its box is {:.3} x {:.3} x {:.3}, that of the cuts {:.1} x {:.1} x {:.1} mm: 25.4 times \
                 as large{}. inch or mm",
                design.path.display(),
                size.x,
                size.y,
                size.z,
                cuts.x,
                cuts.y,
                cuts.z,
                if unit.is_some_and(|(u, _)| *u == LengthUnit::Inch) { word } else { String::new() }
            );
            interview.get(key, text, None)
        }
    };
    match answer.as_deref().map(LengthUnit::from_name) {
        None => Ok(None),
        Some(Some(unit)) => Ok(Some(Design { inch: unit == LengthUnit::Inch, ..design })),
        Some(None) => {
            Err(refused(format!("`{key}` = {:?} is not a unit", answer.unwrap_or_default()), "write inch or mm"))
        }
    }
}

/// Refuses a design that has nothing to do with stock and cuts.
pub(super) fn check_design(design: &Design, stock: &StockForm, room: &Aabb) -> Result<(), FirstPartError> {
    let mut own = design.mesh.aabb();
    if design.inch {
        own = Aabb { min: own.min * 25.4, max: own.max * 25.4 };
    }
    let place = room.union(&stock.aabb());
    if place::fit(&own, &place) == Fit::Fits {
        return Ok(());
    }
    let corner = |p: &Point| format!("{:.1}, {:.1}, {:.1}", p.x, p.y, p.z);
    let shift = place.center() - own.center();
    if let Some(what) = place::mistaken(&own, &place) {
        let (size, other) = (own.size(), place.size());
        return Err(refused(
            format!(
                "the design {} is {:.3} x {:.3} x {:.3} mm, stock and cuts {:.1} x {:.1} x {:.1} mm: its numbers look like {what}",
                design.path.display(),
                size.x,
                size.y,
                size.z,
                other.x,
                other.y,
                other.z
            )
            .replace("look like ten", "look ten")
            .replace("look like 25.4", "look 25.4"),
            "export it in millimeters: meshes have no unit",
        ));
    }
    Err(refused(
        format!(
            "the design {} lies from ({}) to ({}) mm, stock and cuts from ({}) to ({}) mm: they do not overlap",
            design.path.display(),
            corner(&own.min),
            corner(&own.max),
            corner(&place.min),
            corner(&place.max)
        ),
        format!(
            "export it with its origin in the zero of the program (a shift of {:.1}, {:.1}, {:.1} mm would align their centers), or state \
             its unit by the answer `design_unit`",
            shift.x, shift.y, shift.z
        ),
    ))
}

fn form_of(stock: &facts::Stock) -> StockForm {
    match stock {
        facts::Stock::Box { min, max } => StockForm::Box(Aabb { min: (*min).into(), max: (*max).into() }),
        facts::Stock::Cylinder { base, radius, height, along } => {
            StockForm::Cylinder { base: *base, radius: *radius, height: *height, along: *along }
        }
    }
}

/// What the programs cut.
pub(super) struct Cuts<'a> {
    pub(super) uses: &'a [&'a ToolUse],
    pub(super) tools: &'a Tools,
    /// No tool length is ever active.
    pub(super) untold: bool,
    /// Answers that decide where the cuts are, or how wide, are missing: nothing can be proposed.
    pub(super) guessed: bool,
    /// STEP files of the call.
    pub(super) step_files: &'a StepFiles,
}

/// The stock: as the call says, as the program says, or proposed and asked for.
pub(super) fn stock(
    all_facts: &[facts::Facts],
    &Cuts { uses, tools, untold, guessed, step_files }: &Cuts<'_>,
    design: Option<&Design>,
    interview: &mut Interview<'_, '_>,
) -> Result<Option<Reasoned<StockForm>>, FirstPartError> {
    let key = "stock";
    let of_text = all_facts.iter().find_map(|f| f.stock.clone());
    if let (Some((stock, line, word)), None) = (&of_text, interview.given(key)) {
        return Ok(Some(Reasoned {
            value: form_of(stock),
            reason: format!("{word} in line {line} of the program"),
            chosen: false,
        }));
    }
    let swept: Vec<Swept<'_>> = uses
        .iter()
        .map(|t| Swept {
            radius: tools.radius(&t.name),
            faces: tools.faces(&t.name),
            sideways: t.sideways,
            feed: t.feed,
            level: t.level,
            descents: &t.descents,
            tilted: t.tilted,
        })
        .collect();
    let mut proposed = if guessed { None } else { place::propose_stock(&swept) };
    if let Some((_, how)) = proposed.as_mut().filter(|_| untold) {
        how.push_str("; tool length compensation is never active (no G43), so heights are taken as tip heights");
    }
    if let (Some((stock, how)), Some(design)) = (&mut proposed, design) {
        let mut own = design.mesh.aabb();
        if design.inch {
            own = Aabb { min: own.min * 25.4, max: own.max * 25.4 };
        }
        // A design that lies elsewhere is reported, and is no reason for a stock of its size.
        if place::fit(&own, stock) == Fit::Fits {
            (*stock, *how) = place::stock_of_design(&own, &swept);
        }
    }
    // In the unit that the program counts in.
    let inch = all_facts.iter().find_map(|f| f.unit.as_ref()).is_some_and(|(unit, _)| *unit == LengthUnit::Inch);
    let (unit, ending) = if inch { (25.4, " inch") } else { (1.0, "") };
    let corners = |b: &Aabb| {
        let all = [b.min.x, b.min.y, b.min.z, b.max.x, b.max.y, b.max.z];
        // A length that was an inch figure is one again.
        let shown = |v: f64| if inch { (v / unit * SIX_DECIMALS).round() / SIX_DECIMALS } else { v };
        all.map(|v| proveout_tool::plain_number(shown(v))).join(",") + ending
    };
    let text = "What is the stock? Corners of a box as X0,Y0,Z0,X1,Y1,Z1 in mm from the zero of the program (with inch at the end: in inches), a \
                cylinder along Z as X,Y,Z0,DIAMETER,HEIGHT, a lying one as X0,Y,Z,DIAMETER,LENGTH along X (or X,Y0,Z along Y), a mesh file, or \
                proposed"
        .to_owned();
    // What is proposed is not known before the other answers are, and can be taken all the same.
    let text = if guessed { format!("{text}: the box that follows from the other answers") } else { text };
    let Some(answer) = interview.get(key, text, proposed.as_ref().map(|(b, _)| corners(b))) else { return Ok(None) };
    if answer == PROPOSED {
        let Some((stock, how)) = proposed else {
            return Err(refused("there is no stock to propose", "write its corners: X0,Y0,Z0,X1,Y1,Z1"));
        };
        return Ok(Some(Reasoned { value: StockForm::Box(stock), reason: format!("assumed: {how}"), chosen: true }));
    }
    let reason = "as the answer `stock` says".to_owned();
    if let Some([x0, y0, z0, x1, y1, z1]) = interview::numbers::<6>(&answer) {
        let b = Aabb {
            min: Point::new(x0.min(x1), y0.min(y1), z0.min(z1)),
            max: Point::new(x0.max(x1), y0.max(y1), z0.max(z1)),
        };
        if (0..3).all(|i| b.min[i] < b.max[i]) {
            return Ok(Some(Reasoned { value: StockForm::Box(b), reason, chosen: false }));
        }
        return Err(refused(format!("`{key}` = {answer:?} is an empty box"), "write two opposite corners"));
    }
    let (bar, along) = interview::along(&answer);
    if let Some([x, y, z, diameter, height]) = interview::numbers::<5>(bar)
        && diameter > 0.0
        && height > 0.0
    {
        let value = StockForm::Cylinder { base: [x, y, z], radius: 0.5 * diameter, height, along };
        return Ok(Some(Reasoned { value, reason, chosen: false }));
    }
    let path = PathBuf::from(&answer);
    if path.is_file() {
        let mesh = solid(&path, step_files)?;
        return Ok(Some(Reasoned { value: StockForm::Mesh(path, mesh.aabb()), reason, chosen: false }));
    }
    Err(refused(
        format!("`{key}` = {answer:?} is neither a stock nor a mesh file"),
        "write X0,Y0,Z0,X1,Y1,Z1, or X,Y,Z0,DIAMETER,HEIGHT, or X0,Y,Z,DIAMETER,LENGTH along X, or the path of a mesh, or proposed",
    ))
}

/// Cells across the longest edge of the stock.
const CELLS: f64 = 250.0;

/// Distance of the rays: a fraction of the stock, and of the smallest tool.
pub(super) fn resolution(stock: &Aabb, uses: &[&ToolUse], tools: &Tools) -> Reasoned<f64> {
    let smallest = uses.iter().map(|t| tools.radius(&t.name)).filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
    let coarse = stock.size().max() / CELLS;
    let cell = coarse.min(0.5 * smallest).max(stock.size().max() / 800.0).clamp(0.02, 2.0);
    let digits = 10_f64.powf(2.0 - cell.log10().floor() - 1.0);
    let value = (cell * digits).round() / digits;
    let reason = "assumed: a fraction of the stock and of the smallest tool; smaller is finer and takes longer".into();
    Reasoned { value, reason, chosen: true }
}
