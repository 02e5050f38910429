//! How scene, machine, tools, program and meshes of a run are read and checked, in this order.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use proveout_input::{InputError, read_input};
use proveout_nc::{Look, Op, ProgramText, Survey, TouchList};

use crate::{
    evidence::{
        digest,
        inputs::{Inputs, Noticed},
        manifest,
    },
    prepare::{
        choice::{Choice, StockChoice, calls_of_other_readings, choose_stock},
        control_file::control_of,
        error::SimError,
        fixtures::{self, fixture_meshes},
        memory::{Demand, MEMORY, Memory},
        part_mesh::part_mesh,
        part_on_table::PartOnTable,
        prepared::Prepared,
        preview::Wanted,
        program_extent, program_source, program_survey,
        program_text::{check_holds_text, program_entry, program_text},
        raw_stock, reader_settings, set_values,
        stop_at::StopAt,
        texture_plan::Plan,
        tools_and_holders::{check_start_tool, clamp_out, holder_zones},
    },
    run::probing,
    scene::{ProgramFile, Scene, joint_limits::limit_joints, mesh_unit, stock::resolution_fault},
};

impl Prepared {
    /// Reads a scene and all that it names.
    ///
    /// # Errors
    /// [`SimError`] with place and remedy for the first fault.
    pub fn read(scene_path: &Path, choice: &Choice) -> Result<Self, SimError> {
        Self::read_announced(scene_path, choice, &mut |_| ())
    }

    /// The same, telling what memory the run will take before the stock is made.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_announced(
        scene_path: &Path,
        choice: &Choice,
        announce: &mut dyn FnMut(&Memory),
    ) -> Result<Self, SimError> {
        let start = Instant::now();
        // On a stand-in for the stock nothing can be measured.
        let touches = (choice.stock != StockChoice::StandIn).then(TouchList::default);
        let prepared = Self::read_once(scene_path, choice, announce, touches)?;
        if !prepared.survey.waits_for_probe {
            return Ok(prepared);
        }
        let (touches, probed) = probing::measure(prepared)?;
        let prepared = Self::read_once(scene_path, choice, &mut |_| (), Some(touches))?;
        Ok(Self { probed, read_time: start.elapsed().as_secs_f64(), ..prepared })
    }

    /// The same with what is known of the probing motions; the program is read to the first one that is not.
    fn read_once(
        scene_path: &Path,
        choice: &Choice,
        announce: &mut dyn FnMut(&Memory),
        touches: Option<TouchList>,
    ) -> Result<Self, SimError> {
        let start = Instant::now();
        let mut scene = set_values::scene(scene_path, &choice.set)?;
        choose_stock(&mut scene, &choice.stock);
        if let Some(fault) = choice.resolution_mm.and_then(resolution_fault) {
            return Err(InputError::file(&scene.path, format!("the call's {fault}"), "give a length in mm").into());
        }
        let cells = choice.resolution_mm.map_or_else(|| scene.file.resolution_mm.get_ref().edges(), |c| [c; 3]);
        let (wanted, cells) = Wanted::of(choice, &mut scene, cells);
        let entry = program_entry(&scene, choice)?;
        set_values::check_used(&scene, entry, choice)?;
        let (program_name, program_path) = program_text(&scene, entry, choice)?;
        let machine_path = scene.resolve(entry.and_then(|e| e.machine.as_ref()).unwrap_or(&scene.file.machine));
        let tools_path = scene.resolve(&scene.file.tools);
        let mut machine = set_values::machine(&machine_path, &choice.set)?;
        let described = machine.clone();
        let changed_limits = limit_joints(&scene, &mut machine)?;
        let mut tools = set_values::tools(&tools_path, &choice.set)?;
        clamp_out(&mut tools, choice, &tools_path)?;
        check_start_tool(&scene, &tools)?;
        let machine_file = if machine_path.is_dir() { machine_path.join("machine.toml") } else { machine_path };
        let mut digests = BTreeMap::new();
        let mut inputs = Inputs::new(choice.step_files.clone());
        inputs.extend([
            ("scene".to_owned(), scene.path.clone()),
            ("machine".to_owned(), machine_file.clone()),
            ("tools".to_owned(), tools_path),
            ("program".to_owned(), program_path.clone()),
        ]);
        let model = model_of(&machine_file);
        if model.is_some() {
            mesh_unit::check_machine(&machine, &machine_file)?;
        }
        inputs.extend(model.map(|model| ("machine model".to_owned(), model)));

        let control = control_of(Some(&scene), &machine)?;
        inputs.extend(control.iter().flat_map(|c| c.files()).map(|file| (control_role(file, &scene), file.clone())));
        let (mut nc_settings, control_note) =
            Self::running_settings(&scene, entry, &tools, &machine, &program_path, choice.nc.is_some())?;
        choice.reading.unwrap_or_default().apply(&mut nc_settings);
        nc_settings.touches = touches;
        let other_readings = calls_of_other_readings(entry, choice);
        // All that the program names is there, before stock or motion take their time.
        let place = scene.path.display().to_string();
        check_holds_text(&program_path)?;
        let read = |look: &mut Look<'_>| Survey::of_file(&program_path, &nc_settings, look);
        let (mut survey, motions) =
            program_survey::survey(read, &nc_settings, &tools, &machine, &place, scene.file.start.tool)?;

        let mount = entry.and_then(|e| e.mount).unwrap_or(scene.file.mount);
        let table_from_work = mount.table_from_work();
        let (part_mesh, part_mesh_error) = part_mesh(&scene, &mut inputs)?.unzip();
        let part_mesh_error = part_mesh_error.flatten();
        fixtures::check_names(&scene, &machine)?;
        let fixtures = fixture_meshes(&scene, &table_from_work, &mut inputs)?;
        let texture = Plan::new(&scene, part_mesh.as_ref(), part_mesh_error, &tools)?;
        let lines = ProgramText::open(&program_path)?.lines() as u64;
        let demand = Demand {
            lines,
            motions,
            part: part_mesh.as_ref(),
            body_triangles: fixtures.iter().map(|(_, mesh)| mesh.triangles.len()).sum(),
            recorded: choice.recorded,
            textures: texture.as_ref().map_or(0, |t| t.memory(lines)),
        };
        let (stock, memory) = raw_stock::make(&scene, cells, MEMORY, &demand, &mut inputs, announce)?;
        if choice.stock != StockChoice::StandIn {
            mesh_unit::check_design(&scene, part_mesh.as_ref(), &stock.bounds())?;
            mesh_unit::check_fixtures(&scene, &fixtures, &stock.bounds(), &table_from_work)?;
        }
        // The survey has run the program: called texts are inputs as the main program is.
        for file in survey.files.iter().map(|name| PathBuf::from(&**name)).filter(|file| *file != program_path) {
            inputs.push(format!("subprogram {}", manifest::relative(&scene.folder, &file)), file);
        }
        let shown = survey.files.iter().map(|n| n.to_string()).chain([program_path.display().to_string()]);
        let shown = shown
            .map(|n| (manifest::relative(&scene.folder, Path::new(&n)), n))
            .map(|(to, n)| (n, Arc::from(to)))
            .collect();
        let mut input_files = Vec::new();
        let (inputs, Noticed { flat_meshes, step_files }) = inputs.into_parts();
        for (role, path) in inputs {
            let file = digest::of_input(&role, &path)?;
            digests.insert(role, file.sha256.clone());
            input_files.push(file);
        }

        let source = program_source::Source {
            scene: &scene,
            entry,
            program: (&program_name, &program_path),
            settings: &nc_settings,
            machine: &machine,
            tools: &tools,
            part_mesh: part_mesh.as_ref(),
            fixtures: &fixtures,
            table_from_work: &table_from_work,
        };
        let (made, part_on_table) = source.make(choice)?.unzip();
        let part_on_table = part_on_table.flatten();
        if let Some(made) = &made {
            digests.insert("made_program".to_owned(), digest::of_bytes(made.text.as_bytes()));
        }
        let source_nc_settings = nc_settings.clone();
        let nc_settings = match made {
            None => nc_settings,
            Some(_) => reader_settings::settings_of_made(nc_settings),
        };
        let program_lines = match &made {
            Some(made) => {
                let name = format!("{program_name}.mpf");
                let read = |look: &mut Look<'_>| Survey::of_text(&name, made.text.as_str(), &nc_settings, look);
                let original = std::mem::replace(
                    &mut survey,
                    program_survey::survey(read, &nc_settings, &tools, &machine, &place, scene.file.start.tool)?.0,
                );
                survey.not_run.extend(original.not_run);
                made.text.lines().count()
            }
            None => ProgramText::open(&program_path)?.lines(),
        };
        let dynamics = choice.dynamics.or(entry.and_then(|e| e.dynamics)).unwrap_or(scene.file.control.dynamics);
        let prepared = Self {
            program_name,
            program_path,
            program_lines: u32::try_from(program_lines).unwrap_or(u32::MAX),
            made,
            with_feeds: None,
            part_on_table,
            schedule: None,
            nc_settings,
            other_readings,
            source_nc_settings,
            control_note,
            machine,
            own_machine: (!changed_limits.is_empty()).then_some(described),
            changed_limits,
            holder_zones: holder_zones(&tools, scene.file.tolerances.near_miss_mm),
            tools,
            stock,
            memory,
            part_mesh,
            part_mesh_error,
            texture,
            fixtures,
            table_from_work,
            mount_assumed: mount.assumed,
            least_overhang_mm: choice.least_overhang_mm.clone(),
            free_axes: choice.free_axes,
            set: set_values::told(&choice.set),
            wanted,
            dynamics,
            plant: choice.plant.unwrap_or(scene.file.control.plant),
            digests,
            inputs: input_files,
            flat_meshes,
            step_files,
            shown,
            scene,
            survey,
            probed: Vec::new(),
            read_time: start.elapsed().as_secs_f64(),
        };
        if prepared.survey.waits_for_probe {
            return Ok(prepared);
        }
        check_line(&prepared)?;
        if choice.stock == StockChoice::OfScene && mesh_unit::is_stock_in_doubt(&prepared.scene) {
            mesh_unit::check_stock(
                &prepared.scene,
                &prepared.stock.bounds(),
                &program_extent::cuts_in_feed(&prepared),
            )?;
        }
        Ok(prepared)
    }

    /// Part and fixtures of a scene on the table, as re-scheduling sees them.
    ///
    /// # Errors
    /// A mesh that cannot be read or bounds no solid, numbers that make no blade.
    pub fn part_on_table(scene: &Scene, entry: Option<&ProgramFile>) -> Result<PartOnTable, SimError> {
        let table_from_work = entry.and_then(|e| e.mount).unwrap_or(scene.file.mount).table_from_work();
        let mut inputs = Inputs::default();
        let part = part_mesh(scene, &mut inputs)?.map(|(mesh, _)| mesh);
        let fixtures = fixture_meshes(scene, &table_from_work, &mut inputs)?;
        Ok(PartOnTable::new(scene, &table_from_work, part.as_ref(), &fixtures)?)
    }
}

/// The file with the shapes of a machine, where its `machine.toml` names one.
fn model_of(machine_file: &Path) -> Option<PathBuf> {
    let table: toml::Table = toml::from_str(&read_input(machine_file).ok()?).ok()?;
    Some(machine_file.with_file_name(table.get("model")?.as_str()?))
}

/// Role of a control file among the inputs of a run: its path from the scene, as scenes may name several.
fn control_role(file: &Path, scene: &Scene) -> String {
    let folder = scene.path.parent().unwrap_or(Path::new(""));
    format!("control {}", file.strip_prefix(folder).unwrap_or(file).display())
}

/// Refuses a line on which nothing moves, before anything is cut.
///
/// # Errors
/// [`SimError::StopAt`] with the next line that moves something.
pub(crate) fn check_line(prepared: &Prepared) -> Result<(), SimError> {
    let Some(StopAt::Line(line)) = prepared.wanted.stop_at else { return Ok(()) };
    let running = prepared.running_file();
    let mut next: Option<u32> = None;
    for command in prepared.program()? {
        let command = command?;
        let place = &command.location;
        if !is_motion(&command.op) || *prepared.shown_as(&place.file) != *running.display().to_string() {
            continue;
        }
        if place.line == line {
            return Ok(());
        }
        if place.line > line {
            next = Some(next.map_or(place.line, |n| n.min(place.line)));
        }
    }
    let message = format!("--stop-at {line}: no motion of this line of {} is run", running.display());
    let help = match next {
        Some(next) => format!("the next line with a motion is {next}"),
        None if line > prepared.program_lines => format!("the program has {} lines", prepared.program_lines),
        None => "no motion comes after it".to_owned(),
    };
    Err(SimError::StopAt { message, help })
}

fn is_motion(op: &Op) -> bool {
    matches!(
        op,
        Op::Rapid(_)
            | Op::Linear(_)
            | Op::Arc(_)
            | Op::Spline(_)
            | Op::Probe(_)
            | Op::Thread(_)
            | Op::Retract(_)
            | Op::Dwell(_)
    )
}
