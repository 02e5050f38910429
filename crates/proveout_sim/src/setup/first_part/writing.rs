//! The files of a proposal: `scene.toml`, `tools.toml`, `README.md`. Every value that was not given
//! has its reason next to it, with the word `assumed`.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use proveout_geom::write_stl;
use proveout_nc::Dialect;
use proveout_step::is_step;
use proveout_tool::{library_text, plain_number as n, quoted};

use super::{
    FirstPartError, Plan, Proposal, Reasoned, StockForm, Tools, home_zero::FOLDER, refused, shown,
    workholding::Workholding,
};
use crate::{
    prepare::program_extent::{Reading, ToolUse},
    scene::{CylinderAxis, names},
};

/// Name of the tool library.
pub(super) const TOOLS: &str = "tools.toml";
/// A design whose numbers were inches, written in millimeters.
const DESIGN: &str = "design.stl";

/// The files by their names.
pub(super) fn files(plan: &Plan<'_>, lines: &[String]) -> Vec<(&'static str, String)> {
    let mut all = vec![("scene.toml", scene(plan))];
    if let Tools::Drafts(drafts) = &plan.tools {
        let heading = "Tools of the programs of scene.toml. Values that the program does not state are marked in `chosen`, with the reason:\n\
                       put in the numbers of your own tools before you trust a verdict about lengths, depths and holders.";
        all.push((TOOLS, library_text(heading, "Tools that the programs call", drafts)));
    }
    all.push(("README.md", readme(plan, lines)));
    all
}

/// Path from the new folder to a file of the call.
fn from_output(output: &Path, path: &Path) -> String {
    let Ok(to) = path.canonicalize() else { return path.display().to_string() };
    let parent = output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Some(name) = output.file_name() else { return to.display().to_string() };
    // A folder that is not there yet.
    let Ok(from) = parent.canonicalize().map(|p| p.join(name)) else { return to.display().to_string() };
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    // Nothing in common but the root: the whole path reads better.
    if shared <= 1 {
        return to.display().to_string();
    }
    let up = from.components().skip(shared).map(|_| "..".to_owned());
    let down = to.components().skip(shared).map(|c| c.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// A name of a scene or program, as files may have it.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let name: String = stem
        .chars()
        .map(|c| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '+') { c } else { '-' })
        .take(60)
        .collect();
    let name = name.trim_matches(['-', '.']).to_owned();
    if names::fault(&name).is_some() { "part".to_owned() } else { name }
}

fn vector(v: [f64; 3]) -> String {
    format!("[{}, {}, {}]", n(v[0]), n(v[1]), n(v[2]))
}

fn scene(plan: &Plan<'_>) -> String {
    let call = plan.call;
    let path = |p: &Path| quoted(&from_output(&call.output, p));
    let mut s = String::new();
    let mut put = |line: &str| {
        s.push_str(line);
        s.push('\n');
    };
    put(
        "# Made by `proveout new`. Values without a mark come from the program; the others say `assumed`, with the reason. Put in your own",
    );
    put("# numbers where it says so, then run the folder.");
    put("");
    put(&format!("name = {}", quoted(&name_of(&call.output))));
    let names: Vec<String> =
        call.programs.iter().map(|p| p.file_name().unwrap_or_default().to_string_lossy().into_owned()).collect();
    put(&format!("description = {}", quoted(&format!("{} on {}", names.join(", "), plan.machine.name))));
    if let Workholding::None(reason) = &plan.workholding {
        put("workholding = \"none\"");
        put(&format!("workholding_reason = {}", quoted(reason)));
    }
    if plan.design.is_none() {
        put("# Gouge and excess stay unchecked without a design; where there is none to ask, remove the #:");
        put("# design = \"none\"");
    }
    match &plan.home_zero {
        None => put(&format!("machine = {}", path(&call.machine))),
        Some(copy) => {
            put(&format!("# {}", copy.reason));
            put(&format!("machine = {}", quoted(FOLDER)));
        }
    }
    put(&match &plan.tools {
        Tools::Library(library) => format!("tools = {}", path(library)),
        Tools::Drafts(_) => format!("tools = {}", quoted(TOOLS)),
    });
    put(&format!("# {}", plan.resolution.reason));
    put(&format!("resolution_mm = {}", n(plan.resolution.value)));
    put("");
    put("[stock]");
    match &plan.stock.value {
        StockForm::Box(b) => {
            put(&format!(
                "box = {{ min_mm = {}, max_mm = {} }}",
                vector(b.min.coords.into()),
                vector(b.max.coords.into())
            ));
        }
        StockForm::Cylinder { base, radius, height, along } => put(&format!(
            "cylinder = {{ base_mm = {}, radius_mm = {}, height_mm = {}, along = \"{}\" }}",
            vector(*base),
            n(*radius),
            n(*height),
            CylinderAxis::name_of(*along)
        )),
        StockForm::Mesh(mesh, _) => put(&format!("mesh = {}", path(mesh))),
    }
    put(&format!("source = {}", quoted(&plan.stock.reason)));
    put("");
    put(&format!("# {}", plan.mount.reason));
    put("[mount]");
    put(&format!("translation_mm = {}", vector(plan.mount.value.into())));
    if plan.mount.chosen {
        put("# Findings that depend on it say so; remove the line once the position is that of your own setup.");
        put("assumed = true");
    }
    if let Some((number, reason)) = &plan.start_tool {
        put("");
        put(&format!("# {reason}"));
        put("[start]");
        put(&format!("tool = {number}"));
    }
    for (word, base, reason) in &plan.offsets {
        put("");
        put(&format!("# {reason}; follows from the mounting: positions of the axes with the tool's length taken off"));
        put(&format!(
            "[work_offsets.{}]",
            if word.contains('.') || word.contains(' ') { quoted(word) } else { word.clone() }
        ));
        put(&format!("X_mm = {}", n(base[0])));
        put(&format!("Y_mm = {}", n(base[1])));
        put(&format!("Z_mm = {}", n(base[2])));
    }
    if let Some(design) = &plan.design {
        put("");
        if design.inch {
            put(&format!(
                "# {} in millimeters: its numbers are inches, as the answer `design_unit` says",
                design.path.display()
            ));
        }
        put("[part]");
        put(&format!("mesh = {}", if design.inch { quoted(DESIGN) } else { path(&design.path) }));
        if is_step(&design.path) {
            put(
                "# The chord error of its mesh is measured; what is asked for, in micrometers, is 5 where it is not stated.",
            );
            put("# chord_um = 2");
        } else {
            put(
                "# Largest distance of the mesh from the true design, as the export from the CAD system had it. Not stated: the mesh itself is judged.",
            );
            put("# chord_error_mm = 0.01");
        }
    }
    match &plan.workholding {
        Workholding::Fixtures(texts, _) => {
            for text in texts {
                put("");
                text.text.lines().for_each(&mut put);
            }
        }
        Workholding::None(_) => {}
        Workholding::Unknown => {
            put("");
            put(
                "# What holds the part is not stated: collision and near_miss stay unchecked. Add it, in coordinates of the workpiece, or write",
            );
            put("# workholding = \"none\" and workholding_reason = \"...\" at the head of this file:");
            put("# [[fixture]]");
            put("# name = \"vise\"");
            put("# kind = \"vise\"");
            let (stock, grip) = (plan.stock.value.aabb(), 5.0);
            let at = stock.center();
            put(&format!("# at_mm = {}", vector([at.x, at.y, stock.min.z + grip])));
            put(&format!("# opening_mm = {}", n(stock.size().y)));
            put("# jaw_width_mm = 125");
            put("# jaw_height_mm = 40");
            put("# jaw_thickness_mm = 20");
            put("# bed_height_mm = 30");
        }
    }
    if let Some(control) = &plan.control {
        put("");
        put("[control]");
        let file = PathBuf::from(control);
        put(&format!("file = {}", if file.is_file() { path(&file) } else { quoted(control) }));
    }
    let mut taken = Vec::new();
    for (program, dialect) in call.programs.iter().zip(&plan.dialects) {
        let mut name = name_of(program);
        if taken.contains(&name) {
            name = format!("{name}-{}", taken.len() + 1);
        }
        put("");
        put("[[program]]");
        put(&format!("name = {}", quoted(&name)));
        put(&format!("file = {}", path(program)));
        if plan.control.is_none() && *dialect != Dialect::Auto {
            put(&format!("dialect = \"{}\"", dialect.name()));
        }
        taken.push(name);
    }
    s
}

fn readme(plan: &Plan<'_>, lines: &[String]) -> String {
    let mut s = format!(
        "# {}\n\nMade by `proveout new`; `proveout run` on this folder runs it, `proveout check` shows what is known before the run.\n\n## What was found\n\n```text\n",
        name_of(&plan.call.output)
    );
    for line in lines {
        let _ = writeln!(s, "{line}");
    }
    s += "```\n\n## What was assumed\n\n| value | assumed | why |\n|---|---|---|\n";
    let mut row = |what: &str, value: String, why: &str| {
        let _ = writeln!(s, "| {what} | {value} | {} |", why.replace('|', "/"));
    };
    row("cells of the stock", format!("{} mm", n(plan.resolution.value)), &plan.resolution.reason);
    if let Some(copy) = &plan.home_zero {
        row("machine", "zero at home".into(), &copy.reason);
    }
    if plan.stock.chosen {
        let b = plan.stock.value.aabb();
        row(
            "stock",
            format!("{} to {} mm", vector(b.min.coords.into()), vector(b.max.coords.into())),
            &plan.stock.reason,
        );
    }
    if plan.mount.chosen {
        row("mounting", format!("{} mm", vector(plan.mount.value.into())), &plan.mount.reason);
    }
    if let Tools::Drafts(drafts) = &plan.tools {
        for d in drafts {
            for (keys, reason) in &d.chosen {
                row(&format!("T{} {}", d.number, keys.join(", ")), String::from("see tools.toml"), reason);
            }
        }
    }
    for t in plan.machine.trust.iter().filter(|t| t.chosen && matches!(t.name.as_str(), "travel_mm" | "travel_deg")) {
        row(&format!("machine: {}", t.key), String::from("see machine.toml"), &t.note);
    }
    s += &format!("\nWorkholding: {}.", plan.workholding.words());
    if plan.design.is_none() {
        s += " No design is given: gouge and excess are not checked.";
    }
    s.push('\n');
    if !plan.notes.is_empty() {
        s += "\n## Notes\n\n";
        for note in &plan.notes {
            let _ = writeln!(s, "- {note}");
        }
    }
    s
}

/// Lines about tools, stock, mounting and offsets.
pub(super) fn told_of_setup(
    uses: &[&ToolUse],
    tools: &Tools,
    stock: &Reasoned<StockForm>,
    mount: &Reasoned<proveout_geom::Vector>,
    offsets: &[(String, [f64; 3], String)],
    readings: &[Reading],
    touch_off: f64,
) -> Vec<String> {
    let mut lines = Vec::new();
    for tool in uses {
        let own = match tools {
            Tools::Drafts(drafts) => drafts.iter().find(|d| {
                shown(&tool.name) == format!("T{}", d.number) || shown(&tool.name) == format!("\"{}\"", d.name)
            }),
            Tools::Library(_) => None,
        };
        let mut line = format!("tool {}", shown(&tool.name));
        if let Some(d) = own {
            let chosen: Vec<&str> = d.chosen.iter().flat_map(|(keys, _)| keys.iter().copied()).collect();
            let _ = write!(
                line,
                ": {} D{}, flutes {}, to the gauge line {} mm{}{}",
                d.kind.unwrap_or("flat"),
                n(d.diameter().unwrap_or(0.0)),
                n(d.flute_length.unwrap_or(0.0)),
                n(d.gauge.unwrap_or(0.0)),
                if d.source.is_empty() { String::new() } else { format!(" ({})", d.source) },
                if chosen.is_empty() { String::new() } else { format!("; assumed: {}", chosen.join(", ")) }
            );
        }
        lines.push(line);
        if tool.feeds > 0 && !tool.feed.is_empty() {
            let b = &tool.feed;
            lines.push(format!(
                "  tip in feed: X {:.2} to {:.2}, Y {:.2} to {:.2}, Z {:.2} to {:.2} mm; {} motions{}",
                b.min.x,
                b.max.x,
                b.min.y,
                b.max.y,
                b.min.z,
                b.max.z,
                tool.feeds,
                if tool.tilted { ", tilted" } else { "" }
            ));
        } else {
            lines.push("  never in feed".into());
        }
    }
    let b = stock.value.aabb();
    lines.push(format!(
        "stock: X {:.2} to {:.2}, Y {:.2} to {:.2}, Z {:.2} to {:.2} mm ({})",
        b.min.x, b.max.x, b.min.y, b.max.y, b.min.z, b.max.z, stock.reason
    ));
    lines.push(format!("zero of the program on the table: {} mm ({})", vector(mount.value.into()), mount.reason));
    for (word, base, reason) in offsets {
        lines.push(format!("work offset {word}: {} ({reason})", vector(*base)));
    }
    if touch_off != 0.0 {
        lines.push(format!("  tool length compensation is never active (no G43): the zero is assumed at the tip of the tool, {} mm below the gauge line", n(touch_off)));
    }
    let places: Vec<String> = readings
        .iter()
        .flat_map(|r| &r.machine_moves)
        .map(|m| format!("{} {}", m.letter, n(if "ABC".contains(m.letter) { m.value.to_degrees() } else { m.value })))
        .collect::<std::collections::BTreeSet<_>>()
        .into_iter()
        .take(12)
        .collect();
    if !places.is_empty() {
        lines.push(format!("positions of the machine (G53, SUPA, M91, reference points): {}", places.join(", ")));
    }
    lines
}

/// Puts the folder into its place when it is whole.
pub(super) fn write(proposal: &Proposal) -> Result<(), FirstPartError> {
    let output = &proposal.output;
    let failed = |e: &dyn std::fmt::Display| {
        refused(format!("{} cannot be written: {e}", output.display()), "name another folder with --output")
    };
    let name = output.file_name().ok_or_else(|| failed(&"it has no name"))?.to_string_lossy().into_owned();
    let beside = output.with_file_name(format!(".{name}.part-{}", std::process::id()));
    let put = || -> Result<(), FirstPartError> {
        if output.symlink_metadata().is_ok() {
            return Err(refused(format!("{} is there already", output.display()), "name another folder with --output"));
        }
        fs::create_dir_all(&beside).map_err(|e| failed(&e))?;
        for (file, text) in &proposal.files {
            fs::write(beside.join(file), text).map_err(|e| failed(&e))?;
        }
        if let Some(copy) = &proposal.machine {
            let folder = beside.join(FOLDER);
            fs::create_dir_all(&folder).map_err(|e| failed(&e))?;
            fs::write(folder.join("machine.toml"), &copy.text).map_err(|e| failed(&e))?;
            for file in &copy.beside {
                fs::copy(file, folder.join(file.file_name().unwrap_or_default())).map_err(|e| failed(&e))?;
            }
        }
        if let Some(mesh) = &proposal.design {
            write_stl(&beside.join(DESIGN), mesh).map_err(|e| failed(&e))?;
        }
        fs::rename(&beside, output).map_err(|e| failed(&e))
    };
    let done = put();
    if done.is_err() {
        fs::remove_dir_all(&beside).ok();
    }
    done
}
