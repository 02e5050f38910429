//! One change for each key.

use toml::{Table, Value};

use crate::keys::setups::{Files, Setup};

/// A key, where it acts, and what is changed: file, path in it, and the new value as TOML; an empty value
/// takes the key out.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) key: &'static str,
    pub(crate) setup: Setup,
    pub(crate) edits: &'static [(&'static str, &'static str, &'static str)],
}

impl Case {
    /// The files of the setup with the change in them.
    pub(crate) fn files(&self) -> Files {
        let mut files = self.setup.files();
        for (name, path, value) in self.edits {
            let name = match *name {
                "machine" => "machine/machine.toml",
                "tools" => "tools.toml",
                "scene" => "scene.toml",
                "first" => "first/scene.toml",
                other => other,
            };
            let text = String::from_utf8(files[name].clone()).expect("text");
            let table: Table = text.parse().unwrap_or_else(|e| panic!("{}: {e}", self.key));
            let mut whole = Value::Table(table);
            set(&mut whole, path, value, self.key);
            let text = toml::to_string(&whole).expect("text");
            files.insert(name.to_owned(), text.into_bytes());
        }
        files
    }
}

fn set(whole: &mut Value, path: &str, value: &str, key: &str) {
    let (parents, last) = path.rsplit_once('.').map_or(("", path), |(p, l)| (p, l));
    let mut at = whole;
    for step in parents.split('.').filter(|s| !s.is_empty()) {
        let next = match at {
            Value::Array(list) => step.parse::<usize>().ok().and_then(|k| list.get_mut(k)),
            Value::Table(table) => Some(table.entry(step).or_insert_with(|| Value::Table(Table::new()))),
            _ => None,
        };
        at = next.unwrap_or_else(|| panic!("{key}: no {step} in {path}"));
    }
    let new = || {
        let parsed: Table = format!("v = {value}").parse().unwrap_or_else(|e| panic!("{key}: {e}"));
        parsed["v"].clone()
    };
    match at {
        Value::Table(table) if value.is_empty() => {
            assert!(table.remove(last).is_some(), "{key}: there is no {path} to take out");
        }
        Value::Table(table) => {
            let new = new();
            assert_ne!(table.get(last), Some(&new), "{key}: {path} is {value} already");
            table.insert(last.to_owned(), new);
        }
        Value::Array(list) => {
            let k: usize = last.parse().unwrap_or_else(|e| panic!("{key}: {e}"));
            list[k] = new();
        }
        _ => panic!("{key}: {path} leads nowhere"),
    }
}

/// Keys that only describe, each with the reason why nothing else changes.
pub(crate) const DESCRIBING: &[(&str, &str)] = &[
    ("scene/.description", "words for people; they stand in the comparison's page"),
    ("scene/StockFile.source", "where the numbers of the stock come from, for people"),
    ("scene/Mount.assumed", "nobody told the place: findings about what stands on the table say so, in words"),
    ("scene/FixtureFile.source", "where the numbers of the fixture come from, for people"),
    ("scene/JointLimitFile.source", "where the limits come from, for people"),
    ("machine/.name", "the machine's name for people: error texts, recordings and reports carry it"),
    ("machine/.description", "words for people"),
    ("machine/JointFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/JointFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/PlatformFile.name", "names the platform in error texts and in `proveout check`"),
    ("machine/PlatformFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/PlatformFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/LegFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/LegFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/ErrorsFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/ErrorsFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/ErrorTableFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/ErrorTableFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/SpindleFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/SpindleFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/TableFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/TableFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/MachineControlFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/MachineControlFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/DensityFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/DensityFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/BodyFile.source", "note on the origin of numbers, for `proveout check`"),
    ("machine/BodyFile.chosen", "note on chosen numbers, for `proveout check`"),
    ("machine/BodyFile.color", "color in recordings and pictures"),
    ("tools/.description", "words for people"),
    ("tools/ToolEntry.description", "words for people"),
    ("tools/ToolEntry.source", "catalogue reference, for people"),
    ("tools/ChosenEntry.reason", "why a number was chosen, for people"),
    ("tools/HolderEntry.name", "the holder's name, for people"),
];

macro_rules! cases {
    ($($key:literal, $setup:ident, $([$file:literal, $path:literal, $value:literal]),+;)*) => {
        pub(crate) const CASES: &[Case] =
            &[$(Case { key: $key, setup: Setup::$setup, edits: &[$(($file, $path, $value)),+] }),*];
    };
}

cases! {
    "scene/.name", Mill, ["scene", "name", "\"another\""];
    "scene/.machine", Mill, ["scene", "machine", "\"second\""];
    "scene/.tools", Mill, ["scene", "tools", "\"other-tools.toml\""];
    "scene/.resolution_mm", Mill, ["scene", "resolution_mm", "[0.5, 0.5, 0.25]"];
    "scene/.stock", Mill, ["scene", "stock", "{ box = { min_mm = [-15, -10, -9], max_mm = [15, 10, 0] } }"];
    "scene/.mount", Mill, ["scene", "mount", "{ translation_mm = [0, 0, 41] }"];
    "scene/.part", Part, ["scene", "part", ""];
    "scene/.fixture", Mill, ["scene", "fixture", "[]"];
    "scene/.work_offsets", Mill, ["scene", "work_offsets", "{ G54 = { Z_mm = 39.5 } }"];
    "scene/.control", Mill, ["scene", "control", "{ dynamics = \"ideal\" }"];
    "scene/.tolerances", Mill, ["scene", "tolerances", "{ near_miss_mm = 0.25 }"];
    "scene/.program", Mill, ["scene", "program.0.name", "\"renamed\""];
    "scene/.inspect", Mill, ["scene", "inspect", "[]"];
    "scene/.plan", Plan, ["scene", "plan", ""];
    "scene/.compare", Compare, ["scene", "compare", ""];
    "scene/.engagement", Mill, ["scene", "engagement", "false"];
    "scene/StockFile.box", Mill, ["scene", "stock.box", "{ min_mm = [-14, -10, -10], max_mm = [15, 10, 0] }"];
    "scene/StockFile.cylinder", Cone, ["scene", "stock.cylinder", "{ base_mm = [0, 0, -10], radius_mm = 13, height_mm = 10 }"];
    "scene/StockFile.chord_um", Mesh, ["scene", "stock.chord_um", "2"];
    "scene/StockFile.mesh", Mesh, ["scene", "stock.mesh", "\"other.stl\""];
    "scene/StockFile.repair", Mesh, ["scene", "stock.repair", "false"];
    "scene/StockFile.mesh_unit", Mesh, ["scene", "stock.mesh_unit", "\"cm\""];
    "scene/StockFile.blade_allowance_mm", Blade, ["scene", "stock.blade_allowance_mm", "0.7"];
    "scene/StockFile.from_run", Next, ["scene", "stock.from_run", "\"nowhere\""];
    "scene/StockFile.place", Next, ["scene", "stock.place.translation_mm", "[0, 0, -0.5]"];
    "scene/StockFile.at_time_s", Next, ["scene", "stock.at_time_s", "1.0"];
    "scene/StockFile.history", Next, ["first", "stock.history", "false"];
    "scene/StockFile.intervals_per_ray", Mill, ["scene", "stock.intervals_per_ray", "3.5"];
    "scene/StockFile.density_kg_m3", Loose, ["scene", "stock.density_kg_m3", "2700"];
    "scene/StockFile.patch", Part, ["scene", "stock.patch", "[]"];
    "scene/BoxFile.min_mm", Mill, ["scene", "stock.box.min_mm", "[-15, -10, -9.5]"];
    "scene/BoxFile.max_mm", Mill, ["scene", "stock.box.max_mm", "[15, 10, 0.5]"];
    "scene/CylinderFile.base_mm", Cone, ["scene", "stock.cylinder.base_mm", "[0, 0, -10.5]"];
    "scene/CylinderFile.radius_mm", Cone, ["scene", "stock.cylinder.radius_mm", "11"];
    "scene/CylinderFile.height_mm", Cone, ["scene", "stock.cylinder.height_mm", "11"];
    "scene/CylinderFile.along", Cone, ["scene", "stock.cylinder.along", "\"x\""];
    "scene/Mount.translation_mm", Mill, ["scene", "mount.translation_mm", "[0, 1, 40]"];
    "scene/Mount.rotation_deg", Mill, ["scene", "mount.rotation_deg", "[0, 0, 90]"];
    "scene/PatchFile.name", Part, ["scene", "stock.patch.0.name", "\"finer\""];
    "scene/PatchFile.min_mm", Part, ["scene", "stock.patch.0.min_mm", "[-7, -3, -4]"];
    "scene/PatchFile.max_mm", Part, ["scene", "stock.patch.0.max_mm", "[3, 3, 1]"];
    "scene/PatchFile.cell_mm", Part, ["scene", "stock.patch.0.cell_mm", "0.125"];
    "scene/PartFile.mesh", Part, ["scene", "part.mesh", "\"other.stl\""];
    "scene/PartFile.chord_error_mm", Part, ["scene", "part.chord_error_mm", "0.02"];
    "scene/PartFile.chord_um", Part, ["scene", "part.chord_um", "2"];
    "scene/PartFile.mesh_unit", Part, ["scene", "part.mesh_unit", "\"inch\""];
    "scene/PartFile.judged_box", Part, ["scene", "part.judged_box", ""];
    "scene/PartFile.cone_frustum", Cone, ["scene", "part", ""];
    "scene/PartFile.blade", Blade, ["scene", "part", ""];
    "scene/ConeFrustumFile.apex_mm", Cone, ["scene", "part.cone_frustum.apex_mm", "[0, 0, 30.5]"];
    "scene/ConeFrustumFile.axis", Cone, ["scene", "part.cone_frustum.axis", "[0.02, 0, -1]"];
    "scene/ConeFrustumFile.half_angle_deg", Cone, ["scene", "part.cone_frustum.half_angle_deg", "19"];
    "scene/ConeFrustumFile.from_mm", Cone, ["scene", "part.cone_frustum.from_mm", "32"];
    "scene/ConeFrustumFile.to_mm", Cone, ["scene", "part.cone_frustum.to_mm", "35"];
    "scene/ConeFrustumFile.reach_mm", Cone, ["scene", "part.cone_frustum.reach_mm", "1"];
    "scene/PartFile.sections", Sections, ["scene", "part.sections", "\"other.csv\""];
    "scene/BladeFile.kind", EndedBlade, ["scene", "part.blade.kind", "\"lu-untwisted\""];
    "scene/BladeFile.root", EndedBlade, ["scene", "part.blade.root", ""];
    "scene/BladeFile.tip", EndedBlade, ["scene", "part.blade.tip", ""];
    "scene/BladeFile.underside_mm", Face, ["scene", "part.blade.underside_mm", "-6"];
    "scene/EndFile.x_mm", EndedBlade, ["scene", "part.blade.tip.x_mm", "90"];
    "scene/EndFile.platform", EndedBlade, ["scene", "part.blade.root.platform", ""];
    "scene/EndPlatformFile.fillet_radius_mm", EndedBlade, ["scene", "part.blade.root.platform.fillet_radius_mm", "5"];
    "scene/EndPlatformFile.thickness_mm", EndedBlade, ["scene", "part.blade.root.platform.thickness_mm", "12"];
    "scene/EndPlatformFile.y_mm", EndedBlade, ["scene", "part.blade.root.platform.y_mm", "[-40, 40]"];
    "scene/EndPlatformFile.z_mm", EndedBlade, ["scene", "part.blade.root.platform.z_mm", "[-40, 40]"];
    "scene/BladeFile.chord_mm", Blade, ["scene", "part.blade.chord_mm", "61"];
    "scene/BladeFile.camber_angle_deg", Blade, ["scene", "part.blade.camber_angle_deg", "58"];
    "scene/BladeFile.thickness_mm", Blade, ["scene", "part.blade.thickness_mm", "9"];
    "scene/BladeFile.leading_radius_mm", Blade, ["scene", "part.blade.leading_radius_mm", "1.8"];
    "scene/BladeFile.trailing_radius_mm", Blade, ["scene", "part.blade.trailing_radius_mm", "1.4"];
    "scene/BladeFile.length_mm", Blade, ["scene", "part.blade.length_mm", "30"];
    "scene/BladeFile.twist_deg_per_mm", Blade, ["scene", "part.blade.twist_deg_per_mm", "0.3"];
    "scene/BladeFile.platform", Blade, ["scene", "part.blade.platform", ""];
    "scene/BladeFile.chord_error_mm", Blade, ["scene", "part.blade.chord_error_mm", "0.1"];
    "scene/PlatformFile.fillet_radius_mm", Blade, ["scene", "part.blade.platform.fillet_radius_mm", "8"];
    "scene/PlatformFile.margin_mm", Blade, ["scene", "part.blade.platform.margin_mm", "16"];
    "scene/PlatformFile.thickness_mm", Blade, ["scene", "part.blade.platform.thickness_mm", "14"];
    "scene/.workholding", Bare, ["scene", "workholding", ""];
    "scene/.workholding_reason", Bare, ["scene", "workholding_reason", "\"in wax\""];
    "scene/.design", Bare, ["scene", "design", ""];
    "scene/.gates", Bare, ["scene", "gates", "{ not_asked = [] }"];
    "scene/GatesFile.not_asked", Bare, ["scene", "gates.not_asked", "[]"];
    "scene/FixtureFile.chord_um", Held, ["scene", "fixture.2.chord_um", "2"];
    "scene/FixtureFile.kind", Held, ["scene", "fixture.2.kind", "\"vise\""];
    "scene/FixtureFile.at_mm", Held, ["scene", "fixture.2.at_mm", "[101, 0, -30]"];
    "scene/FixtureFile.rotation_deg", Held, ["scene", "fixture.2.rotation_deg", "[0, 0, 10]"];
    "scene/FixtureFile.opening_mm", Held, ["scene", "fixture.1.opening_mm", "22"];
    "scene/FixtureFile.jaw_width_mm", Held, ["scene", "fixture.1.jaw_width_mm", "41"];
    "scene/FixtureFile.jaw_height_mm", Held, ["scene", "fixture.1.jaw_height_mm", "16"];
    "scene/FixtureFile.jaw_thickness_mm", Held, ["scene", "fixture.1.jaw_thickness_mm", "9"];
    "scene/FixtureFile.bed_height_mm", Held, ["scene", "fixture.1.bed_height_mm", "13"];
    "scene/FixtureFile.length_mm", Held, ["scene", "fixture.2.length_mm", "61"];
    "scene/FixtureFile.width_mm", Held, ["scene", "fixture.2.width_mm", "51"];
    "scene/FixtureFile.thickness_mm", Held, ["scene", "fixture.2.thickness_mm", "6"];
    "scene/FixtureFile.diameter_mm", Held, ["scene", "fixture.3.diameter_mm", "62"];
    "scene/FixtureFile.grip_diameter_mm", Held, ["scene", "fixture.3.grip_diameter_mm", "21"];
    "scene/FixtureFile.jaws", Held, ["scene", "fixture.3.jaws", "4"];
    "scene/FixtureFile.side_mm", Held, ["scene", "fixture.4.side_mm", "31"];
    "scene/FixtureFile.height_mm", Held, ["scene", "fixture.4.height_mm", "51"];
    "scene/FixtureFile.base_side_mm", Held, ["scene", "fixture.4.base_side_mm", "52"];
    "scene/FixtureFile.base_thickness_mm", Held, ["scene", "fixture.4.base_thickness_mm", "11"];
    "scene/FixtureFile.reach_mm", Held, ["scene", "fixture.5.reach_mm", "6"];
    "scene/FixtureFile.stud_diameter_mm", Held, ["scene", "fixture.5.stud_diameter_mm", "7"];
    "scene/FixtureFile.stud_height_mm", Held, ["scene", "fixture.5.stud_height_mm", "8"];
    "scene/ProgramFile.block_skip", Held, ["scene", "program.0.block_skip", "\"on\""];
    "scene/ProgramFile.optional_stop", Held, ["scene", "program.0.optional_stop", "\"on\""];
    "tools/ToolEntry.gauge_length_source", Mill, ["tools", "tool.0.gauge_length_source", "\"prescribed\""];
    "scene/FixtureFile.name", Mill, ["scene", "fixture.0.name", "\"jaw\""];
    "scene/FixtureFile.mesh", Part, ["scene", "fixture.2.mesh", "\"jaw2.stl\""];
    "scene/FixtureFile.mesh_unit", Part, ["scene", "fixture.2.mesh_unit", "\"inch\""];
    "scene/FixtureFile.box", Mill, ["scene", "fixture.0.box.max_mm", "[25, 10, 5]"];
    "scene/FixtureFile.cylinder", Part, ["scene", "fixture.1.cylinder.radius_mm", "3.5"];
    "scene/FixtureFile.frame", Mill, ["scene", "fixture.0.frame", "\"table\""];
    "scene/OffsetFile.X_mm", Mill, ["scene", "work_offsets.G54.X_mm", "1"];
    "scene/OffsetFile.Y_mm", Mill, ["scene", "work_offsets.G54.Y_mm", "1"];
    "scene/OffsetFile.Z_mm", Mill, ["scene", "work_offsets.G54.Z_mm", "40.5"];
    "scene/OffsetFile.A_deg", Hybrid, ["scene", "work_offsets.G54.A_deg", "1"];
    "scene/OffsetFile.B_deg", Five, ["scene", "work_offsets.G54.B_deg", "1"];
    "scene/OffsetFile.C_deg", Five, ["scene", "work_offsets.G54.C_deg", "1"];
    "scene/ControlFile.file", Mill, ["scene", "control.file", "\"okuma-osp\""];
    "scene/.unit", Mill, ["scene", "unit", "\"inch\""];
    "tools/.unit", Mill, ["tools", "unit", "\"inch\""];
    "scene/.start", Mill, ["scene", "start", "{ tool = 99 }"];
    "scene/StartFile.tool", Mill, ["scene", "start.tool", "99"];
    "scene/ControlFile.dynamics", Mill, ["scene", "control.dynamics", "\"ideal\""];
    "scene/ControlFile.plant", MillRapier, ["scene", "control.plant", "\"newton-euler\""];
    "scene/ControlFile.path_tolerance_mm", Mill, ["scene", "control.path_tolerance_mm", "0.01"];
    "scene/ControlFile.piece_tolerance_mm", Five, ["scene", "control.piece_tolerance_mm", "0.01"];
    "scene/ControlFile.pole_cone_deg", Five, ["scene", "control.pole_cone_deg", "0"];
    "scene/ControlFile.joint_limits", Mill, ["scene", "control.joint_limits", "{}"];
    "scene/JointLimitFile.max_velocity_mm_min", Mill, ["scene", "control.joint_limits.X.max_velocity_mm_min", "1200"];
    "scene/JointLimitFile.max_acceleration_mm_s2", Mill, ["scene", "control.joint_limits.X.max_acceleration_mm_s2", "500"];
    "scene/JointLimitFile.max_jerk_mm_s3", Mill, ["scene", "control.joint_limits.X.max_jerk_mm_s3", "9000"];
    "scene/JointLimitFile.max_velocity_deg_s", Five, ["scene", "control.joint_limits.C.max_velocity_deg_s", "20"];
    "scene/JointLimitFile.max_acceleration_deg_s2", Five, ["scene", "control.joint_limits.C.max_acceleration_deg_s2", "100"];
    "scene/JointLimitFile.max_jerk_deg_s3", Five, ["scene", "control.joint_limits.C.max_jerk_deg_s3", "900"];
    "scene/.run_limits", Mill, ["scene", "run_limits", "{ simulated_time_s = 2 }"];
    "scene/RunLimitsFile.simulated_time_s", Mill, ["scene", "run_limits.simulated_time_s", "1"];
    "scene/RunLimitsFile.blocks", Mill, ["scene", "run_limits.blocks", "2"];
    "scene/Tolerances.gouge_mm", Part, ["scene", "tolerances.gouge_mm", "0.06"];
    "scene/Tolerances.excess_mm", Part, ["scene", "tolerances.excess_mm", "0.06"];
    "scene/Tolerances.near_miss_mm", Mill, ["scene", "tolerances.near_miss_mm", "4"];
    "scene/Tolerances.contact_mm", Mill, ["scene", "tolerances.contact_mm", "0.5"];
    "scene/.surface", Surface, ["scene", "surface", ""];
    "scene/SurfaceFile.model", Surface, ["scene", "surface.model", "\"teeth\""];
    "scene/SurfaceFile.size_mm", Surface, ["scene", "surface.size_mm", "[0.6, 0.5]"];
    "scene/SurfaceFile.step_um", Surface, ["scene", "surface.step_um", "40"];
    "scene/SurfaceFile.max_height_mm", Surface, ["scene", "surface.max_height_mm", "0.4"];
    "scene/SurfaceFile.standard", Surface, ["scene", "surface.standard", "\"iso4287\""];
    "scene/SurfaceFile.class", Surface, ["scene", "surface.class", "\"Sc1\""];
    "scene/SurfaceFile.profiles", Surface, ["scene", "surface.profiles", "false"];
    "scene/SurfaceFile.random_phases", SurfaceTeeth, ["scene", "surface.random_phases", "3"];
    "scene/SurfaceFile.seed", SurfaceTeeth, ["scene", "surface.seed", "2"];
    "scene/SurfaceFile.save_nodes", Surface, ["scene", "surface.save_nodes", "false"];
    "scene/SurfaceFile.patch", Surface, ["scene", "surface.patch", "[]"];
    "scene/SurfaceFile.grid", Surface, ["scene", "surface.grid", "[]"];
    "scene/SurfaceFile.profile", Surface, ["scene", "surface.profile", "[]"];
    "scene/SurfaceFile.phase", SurfacePhase, ["scene", "surface.phase", "[]"];
    "scene/SurfacePatchFile.name", Surface, ["scene", "surface.patch.0.name", "\"other\""];
    "scene/SurfacePatchFile.at_mm", Surface, ["scene", "surface.patch.0.at_mm", "[-5, 0.05, -1]"];
    "scene/SurfacePatchFile.arc_mm", SurfaceBlade, ["scene", "surface.patch.0.arc_mm", "21"];
    "scene/SurfacePatchFile.x_mm", SurfaceBlade, ["scene", "surface.patch.0.x_mm", "18"];
    "scene/SurfacePatchFile.normal", Surface, ["scene", "surface.patch.1.normal", "[0, 0.1, 1]"];
    "scene/SurfacePatchFile.along", Surface, ["scene", "surface.patch.0.along", "[1, 0.4, 0]"];
    "scene/SurfacePatchFile.size_mm", Surface, ["scene", "surface.patch.0.size_mm", "[0.5, 0.4]"];
    "scene/SurfacePatchFile.step_um", Surface, ["scene", "surface.patch.0.step_um", "20"];
    "scene/SurfaceGridFile.name", Surface, ["scene", "surface.grid.0.name", "\"other\""];
    "scene/SurfaceGridFile.count", Surface, ["scene", "surface.grid.0.count", "[1, 1]"];
    "scene/SurfaceGridFile.spacing_mm", Surface, ["scene", "surface.grid.1.spacing_mm", "[0.5, 1]"];
    "scene/SurfaceGridFile.arc_mm", SurfaceBlade, ["scene", "surface.grid.0.arc_mm", "[15, 24]"];
    "scene/SurfaceGridFile.x_mm", SurfaceBlade, ["scene", "surface.grid.0.x_mm", "[14, 19]"];
    "scene/SurfaceGridFile.corner_mm", Surface, ["scene", "surface.grid.0.corner_mm", "[-8, 0.05, -1]"];
    "scene/SurfaceGridFile.u_mm", Surface, ["scene", "surface.grid.0.u_mm", "[2.5, 0, 0]"];
    "scene/SurfaceGridFile.v_mm", Surface, ["scene", "surface.grid.0.v_mm", "[0, 0.2, 0]"];
    "scene/SurfaceProfileFile.name", Surface, ["scene", "surface.profile.0.name", "\"other\""];
    "scene/SurfaceProfileFile.at_mm", Surface, ["scene", "surface.profile.0.at_mm", "[-2, 0.05, -1]"];
    "scene/SurfaceProfileFile.arc_mm", SurfaceBlade, ["scene", "surface.profile.0.arc_mm", "23"];
    "scene/SurfaceProfileFile.x_mm", SurfaceBlade, ["scene", "surface.profile.0.x_mm", "16.5"];
    "scene/SurfaceProfileFile.normal", Surface, ["scene", "surface.profile.1.normal", "[0, 0.01, 1]"];
    "scene/SurfaceProfileFile.direction", Surface, ["scene", "surface.profile.0.direction", "\"across\""];
    "scene/SurfaceProfileFile.along", Surface, ["scene", "surface.profile.1.along", "[1, 0.01, 0]"];
    "scene/SpindlePhaseFile.at_mm", SurfacePhase, ["scene", "surface.phase.0.at_mm", "[-14.8, 0, -1]"];
    "scene/SpindlePhaseFile.tooth_deg", SurfacePhase, ["scene", "surface.phase.0.tooth_deg", "60"];
    "scene/SpindlePhaseFile.tool", SurfacePhase, ["scene", "surface.phase.0.tool", "\"OTHER\""];
    "scene/Tolerances.scallop_um", Surface, ["scene", "tolerances.scallop_um", "5"];
    "scene/Tolerances.ra_um", Surface, ["scene", "tolerances.ra_um", "1"];
    "scene/Tolerances.rz_um", Surface, ["scene", "tolerances.rz_um", "4"];
    "scene/Tolerances.region", Surface, ["scene", "tolerances.region", "[{ name = \"land\", min_mm = [-50, -50, -50], max_mm = [50, 50, 50], ra_um = 0.01 }]"];
    "scene/ToleranceRegionFile.name", Surface, ["scene", "tolerances.region.0.name", "\"other\""];
    "scene/ToleranceRegionFile.min_mm", Surface, ["scene", "tolerances.region.0.min_mm", "[20, -50, -50]"];
    "scene/ToleranceRegionFile.max_mm", Surface, ["scene", "tolerances.region.0.max_mm", "[-40, 50, 50]"];
    "scene/ToleranceRegionFile.scallop_um", Surface, ["scene", "tolerances.region.0.scallop_um", "0.01"];
    "scene/ToleranceRegionFile.ra_um", Surface, ["scene", "tolerances.region.0.ra_um", "0.01"];
    "scene/ToleranceRegionFile.rz_um", Surface, ["scene", "tolerances.region.0.rz_um", "0.01"];
    "tools/ToolEntry.edges", SurfaceTeeth, ["tools", "tool.0.edges", ""];
    "tools/EdgesEntry.helix_deg", SurfacePhase, ["tools", "tool.0.edges.helix_deg", "10"];
    "tools/EdgesEntry.radial_run_out_mm", SurfacePhase, ["tools", "tool.0.edges.radial_run_out_mm", "[0, 0.005]"];
    "tools/EdgesEntry.axial_run_out_mm", SurfacePhase, ["tools", "tool.0.edges.axial_run_out_mm", "[0, 0.003]"];
    "tools/EdgesEntry.round_insert", SurfaceInsert, ["tools", "tool.0.edges.round_insert", ""];
    "tools/EdgesEntry.radial_rake_deg", SurfacePhase, ["tools", "tool.0.edges.radial_rake_deg", "8"];
    "tools/EdgesEntry.rake_about", SurfaceInsert, ["tools", "tool.0.edges.rake_about", "\"nose\""];
    "tools/RoundInsertEntry.nose_circle_diameter_mm", SurfaceInsert, ["tools", "tool.0.edges.round_insert.nose_circle_diameter_mm", "3.999"];
    "tools/RoundInsertEntry.insert_radius_mm", SurfaceInsert, ["tools", "tool.0.edges.round_insert.insert_radius_mm", "1.1"];
    "tools/ToolEntry.residual", Surface, ["tools", "tool.0.residual", ""];
    "tools/ResidualEntry.ra_um", Surface, ["tools", "tool.0.residual.ra_um", "[0.1, 0.3]"];
    "tools/ResidualEntry.rz_um", Surface, ["tools", "tool.0.residual.rz_um", "[0.3, 0.6]"];
    "tools/ResidualEntry.source", Surface, ["tools", "tool.0.residual.source", "\"paper\""];
    "scene/ProgramFile.name", Mill, ["scene", "program.0.name", "\"other\""];
    "scene/ProgramFile.file", Next, ["scene", "program.0.file", "\"main.nc\""];
    "scene/ProgramFile.planned", Plan, ["scene", "program.0.planned", "\"row\""];
    "scene/ProgramFile.planned_axis", Plan, ["scene", "program.0.planned_axis", "{ rule = \"lead-tilt\", lead_deg = 5, tilt_deg = 0 }"];
    "scene/ProgramFile.reschedule", Remade, ["scene", "program.2.reschedule.method", "\"quaternion\""];
    "scene/ProgramFile.dialect", Mill, ["scene", "program.0.dialect", "\"heidenhain\""];
    "scene/ProgramFile.machine", Mill, ["scene", "program.0.machine", "\"second\""];
    "scene/ProgramFile.work_offsets", Mill, ["scene", "program.0.work_offsets", "{ G54 = { Z_mm = 41 } }"];
    "scene/ProgramFile.mount", Mill, ["scene", "program.0.mount", "{ translation_mm = [0, 0, 41] }"];
    "scene/ProgramFile.dynamics", Mill, ["scene", "program.0.dynamics", "\"ideal\""];
    "scene/RescheduleFile.method", Remade, ["scene", "program.2.reschedule.method", "\"quaternion\""];
    "scene/RescheduleFile.from", Remade, ["scene", "program.2.reschedule.from", "\"second\""];
    "scene/RescheduleFile.clearance_deg", Remade, ["scene", "program.2.reschedule.clearance_deg", "8"];
    "scene/RescheduleFile.inset_deg", Remade, ["scene", "program.2.reschedule.inset_deg", "8"];
    "scene/RescheduleFile.start_flat_mm", Remade, ["scene", "program.2.reschedule.start_flat_mm", "4"];
    "scene/RescheduleFile.end_flat_percent", Remade, ["scene", "program.2.reschedule.end_flat_percent", "8"];
    "scene/RescheduleFile.merge_mm", Remade, ["scene", "program.2.reschedule.merge_mm", "60"];
    "scene/RescheduleFile.theta_unit", Remade, ["scene", "program.2.reschedule.theta_unit", "\"radian\""];
    "scene/RescheduleFile.channel", RemadeSmooth, ["scene", "program.2.reschedule.channel", "\"tool\""];
    "scene/RescheduleFile.lean_max_deg", RemadeSmooth, ["scene", "program.2.reschedule.lean_max_deg", "95"];
    "scene/RescheduleFile.monotone", RemadeSmooth, ["scene", "program.2.reschedule.monotone", "false"];
    "scene/RescheduleFile.max_time_loss_percent", RemadeSmooth, ["scene", "program.2.reschedule.max_time_loss_percent", "12"];
    "scene/RescheduleFile.turn_max_deg", RemadeSmooth, ["scene", "program.2.reschedule.turn_max_deg", "5"];
    "scene/RescheduleFile.ends", RemadeSmooth, ["scene", "program.2.reschedule.ends", "\"free\""];
    "scene/RescheduleFile.criterion", RemadeKeys, ["scene", "program.2.reschedule.criterion", "\"true-minimum\""];
    "scene/RescheduleFile.key_axes", RemadeKeys, ["scene", "program.2.reschedule.key_axes", "\"search\""];
    "scene/RescheduleFile.keys", RemadeQuaternion, ["scene", "program.2.reschedule.keys", "9"];
    "scene/RescheduleFile.max_key_lean_deg", RemadeKeys, ["scene", "program.2.reschedule.max_key_lean_deg", "4"];
    "scene/RescheduleFile.window_mm", RemadeKeys, ["scene", "program.2.reschedule.window_mm", "1"];
    "scene/RescheduleFile.strip_min_mm", RemadeStrip, ["scene", "program.2.reschedule.strip_min_mm", "3"];
    "scene/RescheduleFile.strip_max_mm", RemadeStrip, ["scene", "program.2.reschedule.strip_max_mm", "3.1"];
    "scene/RescheduleFile.strip_height_mm", RemadeStrip, ["scene", "program.2.reschedule.strip_height_mm", "0.105"];
    "scene/RescheduleFile.ra_um", RemadeStrip, ["scene", "program.2.reschedule.ra_um", "1.5"];
    "scene/RescheduleFile.evaluation_length_mm", RemadeStrip, ["scene", "program.2.reschedule.evaluation_length_mm", "2.5"];
    "scene/RescheduleFile.run_in_mm", RemadeStrip, ["scene", "program.2.reschedule.run_in_mm", "10"];
    "scene/RescheduleFile.margin_deg", RemadeStrip, ["scene", "program.2.reschedule.margin_deg", "0.4"];
    "scene/RescheduleFile.coefficients", RemadeStrip, ["scene", "program.2.reschedule.coefficients", "15"];
    "scene/RescheduleFile.measured_ratio", RemadeStrip, ["scene", "program.2.reschedule.measured_ratio", "0.6"];
    "scene/RescheduleFile.measured_spread", RemadeStrip, ["scene", "program.2.reschedule.measured_spread", "0.05"];
    "scene/RescheduleFile.cone_deg", RemadePole, ["scene", "program.2.reschedule.cone_deg", "25"];
    "scene/RescheduleFile.rate_deg_mm", RemadePole, ["scene", "program.2.reschedule.rate_deg_mm", "9"];
    "scene/RescheduleFile.junction", RemadePole, ["scene", "program.2.reschedule.junction", "\"off\""];
    "scene/InspectFile.name", Mill, ["scene", "inspect.0.name", "\"ground\""];
    "scene/InspectFile.kind", Mill, ["scene", "inspect.0.kind", "\"thickness\""];
    "scene/InspectFile.from_mm", Mill, ["scene", "inspect.0.from_mm", "[-5.25, 8.25, 5]"];
    "scene/InspectFile.direction", Mill, ["scene", "inspect.0.direction", "\"+x\""];
    "scene/InspectFile.nominal_mm", Mill, ["scene", "inspect.0.nominal_mm", "-3"];
    "scene/InspectFile.tolerance_mm", Mill, ["scene", "inspect.0.tolerance_mm", "0.02"];
    "scene/PlanFile.helix", Plan, ["scene", "plan.helix.pitch_mm", "0.7"];
    "scene/PlanFile.transverse", Paths, ["scene", "plan.transverse.one_way", "false"];
    "scene/PlanFile.iso-parametric", Paths, ["scene", "plan.iso-parametric", ""];
    "scene/PlanFile.iso-planar", Paths, ["scene", "plan.iso-planar", ""];
    "scene/PlanFile.pocket", Paths, ["scene", "plan.pocket", ""];
    "scene/PlanFile.constant-scallop", Paths, ["scene", "plan.constant-scallop", ""];
    "scene/PlanFile.quasi-circle", Paths, ["scene", "plan.quasi-circle", ""];
    "scene/PlanFile.row", Paths, ["scene", "plan.row", ""];
    "scene/PlanFile.point-roughing", Paths, ["scene", "plan.point-roughing", ""];
    "scene/PlanFile.flank", Flank, ["scene", "plan.flank", ""];
    "scene/PathFile.tool", Paths, ["scene", "plan.row.tool", "\"nobody\""];
    "scene/PathFile.spindle_rpm", Paths, ["scene", "plan.row.spindle_rpm", "7000"];
    "scene/PathFile.feed_mm_min", Paths, ["scene", "plan.row.feed_mm_min", "900"];
    "scene/PathFile.feed_reference", Paths, ["scene", "plan.row.feed_reference", "\"chord\""];
    "scene/PathFile.machine", Paths, ["scene", "plan.row.machine", "\"second\""];
    "scene/PathFile.posted", Paths, ["scene", "plan.row.posted", "\"joints\""];
    "scene/PathFile.work_offset", Paths, ["scene", "plan.row.work_offset", "\"G55\""];
    "scene/PathFile.tolerance_mm", Paths, ["scene", "plan.row.tolerance_mm", "0.02"];
    "scene/PathFile.axis", Paths, ["scene", "plan.transverse.axis", "{ rule = \"lead-tilt\", lead_deg = 5 }"];
    "scene/PathFile.lift_mm", Paths, ["scene", "plan.row.lift_mm", "3"];
    "scene/PathFile.clearance_mm", Paths, ["scene", "plan.row.clearance_mm", "12"];
    "scene/PathFile.allowance_mm", Paths, ["scene", "plan.row.allowance_mm", "0.1"];
    "scene/PathFile.chord_error_mm", Paths, ["scene", "plan.transverse.chord_error_mm", "0.005"];
    "scene/PathFile.longest_step_mm", Paths, ["scene", "plan.transverse.longest_step_mm", "0.5"];
    "scene/PathFile.step_mm", Paths, ["scene", "plan.pocket.step_mm", "1.5"];
    "scene/PathFile.scallop_mm", Paths, ["scene", "plan.constant-scallop.scallop_mm", "0.02"];
    "scene/PathFile.lines", Paths, ["scene", "plan.iso-parametric.lines", "[0.3, 0.32]"];
    "scene/PathFile.lines_deg", Paths, ["scene", "plan.quasi-circle.lines_deg", "[87]"];
    "scene/PathFile.lines_mm", Paths, ["scene", "plan.iso-planar.lines_mm", "[1]"];
    "scene/PathFile.lines_apart_mm", Planes, ["scene", "plan.iso-planar.lines_apart_mm", "0.6"];
    "scene/PathFile.across", Paths, ["scene", "plan.transverse.across", "[0.2, 0.35]"];
    "scene/PathFile.across_deg", Paths, ["scene", "plan.quasi-circle.across_deg", "[80, 90]"];
    "scene/PathFile.across_mm", Paths, ["scene", "plan.iso-planar.across_mm", "[0, 3]"];
    "scene/PathFile.along", Paths, ["scene", "plan.row.along", "[0.2, 0.7]"];
    "scene/PathFile.parameter", Paths, ["scene", "plan.row.parameter", "\"polar-angle\""];
    "scene/PathFile.focus_inside", Paths, ["scene", "plan.quasi-circle.focus_inside", "0.05"];
    "scene/PathFile.trailing", Paths, ["scene", "plan.quasi-circle.trailing", "0.5"];
    "scene/PathFile.normal", Paths, ["scene", "plan.iso-planar.normal", "[0, 1, 0.1]"];
    "scene/PathFile.at", Paths, ["scene", "plan.row.at", "0.31"];
    "scene/PathFile.from_allowance_mm", Paths, ["scene", "plan.point-roughing.from_allowance_mm", "0.5"];
    "scene/PathFile.depth_mm", Paths, ["scene", "plan.point-roughing.depth_mm", "0.1"];
    "scene/PathFile.start", Paths, ["scene", "plan.point-roughing.start", "0.4"];
    "scene/PathFile.one_way", Paths, ["scene", "plan.transverse.one_way", "false"];
    "scene/PathFile.outwards", Paths, ["scene", "plan.pocket.outwards", "false"];
    "scene/PathFile.rulings", Flank, ["scene", "plan.flank.rulings", "\"across\""];
    "scene/PathFile.beyond_end_mm", Flank, ["scene", "plan.flank.beyond_end_mm", "2"];
    "scene/PathFile.flank_error_mm", Flank, ["scene", "plan.flank.flank_error_mm", "1e-7"];
    "scene/GivenAxisFile.part", Paths, ["scene", "plan.row.axis.axes.0.part", "0.2"];
    "scene/GivenAxisFile.direction", Paths, ["scene", "plan.row.axis.axes.0.direction", "[0.15, -0.9, -0.4]"];
    "scene/HelixFile.tool", Plan, ["scene", "plan.helix.tool", "\"nobody\""];
    "scene/HelixFile.spindle_rpm", Plan, ["scene", "plan.helix.spindle_rpm", "7000"];
    "scene/HelixFile.feed_mm_min", Plan, ["scene", "plan.helix.feed_mm_min", "900"];
    "scene/HelixFile.work_offset", Plan, ["scene", "plan.helix.work_offset", "\"G55\""];
    "scene/HelixFile.allowance_mm", Plan, ["scene", "plan.helix.allowance_mm", "0.1"];
    "scene/HelixFile.head_tilt_deg", Plan, ["scene", "plan.helix.head_tilt_deg", "6"];
    "scene/HelixFile.lead_deg", Plan, ["scene", "plan.helix.lead_deg", "14"];
    "scene/HelixFile.from_x_mm", Plan, ["scene", "plan.helix.from_x_mm", "12.2"];
    "scene/HelixFile.to_x_mm", Plan, ["scene", "plan.helix.to_x_mm", "13.7"];
    "scene/HelixFile.pitch_mm", Plan, ["scene", "plan.helix.pitch_mm", "0.8"];
    "scene/HelixFile.step_mm", Plan, ["scene", "plan.helix.step_mm", "5"];
    "scene/HelixFile.start", Plan, ["scene", "plan.helix.start", "0.4"];
    "scene/HelixFile.clearance_mm", Plan, ["scene", "plan.helix.clearance_mm", "11"];
    "scene/HelixFile.tolerance_mm", Plan, ["scene", "plan.helix.tolerance_mm", "0.02"];
    "scene/CompareFile.baseline", Compare, ["scene", "compare.baseline", "\"other\""];
    "scene/CompareFile.experiment", Compare, ["scene", "compare.experiment", "\"other words\""];
    "scene/CompareFile.trimmed_ends_s", Compare, ["scene", "compare.trimmed_ends_s", "0.3"];
    "scene/CompareFile.plot_window_s", Compare, ["scene", "compare.plot_window_s", "[0.35, 0.5]"];
    "scene/CompareFile.must_pass", Compare, ["scene", "compare.must_pass", "[\"main\"]"];
    "scene/CompareFile.motion_only", Compare, ["scene", "compare.motion_only", "true"];
    "scene/CompareFile.null_program", Compare, ["scene", "compare.null_program", "\"main\""];
    "scene/CompareFile.choice", Compare, ["scene", "compare.choice", "[]"];
    "scene/CompareFile.draws", Compare, ["scene", "compare.draws", "3"];
    "scene/ChoiceFile.name", Compare, ["scene", "compare.choice.0.name", "\"another\""];
    "scene/ChoiceFile.key", Compare, ["scene", "compare.choice.0.key", "\"machine.X.max_acceleration_mm_s2\""];
    "scene/ChoiceFile.range", Compare, ["scene", "compare.choice.0.range", "[400, 900]"];
    "scene/ChoiceFile.values", Compare, ["scene", "compare.choice.1.values", "[0.01, 0.2]"];
    "scene/ChoiceFile.source", Compare, ["scene", "compare.choice.0.source", "\"inferred\""];
    "scene/ChoiceFile.reason", Compare, ["scene", "compare.choice.0.reason", "\"other words\""];
    "scene/CompareFile.published", Compare, ["scene", "compare.published", "[]"];
    "scene/CompareFile.expect", Compare, ["scene", "compare.expect", "[]"];
    "scene/PublishedFile.name", Compare, ["scene", "compare.published.0.name", "\"another\""];
    "scene/PublishedFile.program", Compare, ["scene", "compare.published.0.program", "\"main\""];
    "scene/PublishedFile.against", Compare, ["scene", "compare.published.0.against", ""];
    "scene/PublishedFile.quantity", Compare, ["scene", "compare.published.0.quantity", "\"max-velocity\""];
    "scene/PublishedFile.axis", Compare, ["scene", "compare.published.0.axis", "\"Y\""];
    "scene/PublishedFile.figure", Compare, ["scene", "compare.published.0.figure", "\"smallest margin\""];
    "scene/PublishedFile.form", Compare, ["scene", "compare.published.1.form", "\"reduction\""];
    "scene/PublishedFile.value", Compare, ["scene", "compare.published.0.value", "11"];
    "scene/PublishedFile.band", Compare, ["scene", "compare.published.0.band", "[4, 16]"];
    "scene/PublishedFile.source", Compare, ["scene", "compare.published.0.source", "\"another\""];
    "scene/PublishedFile.kind", Compare, ["scene", "compare.published.0.kind", "\"own-count\""];
    "scene/PublishedFile.remark", Compare, ["scene", "compare.published.0.remark", "\"other words\""];
    "scene/PublishedFile.headline", Compare, ["scene", "compare.published.0.headline", "true"];
    "scene/PublishedFile.not_comparable", Compare, ["scene", "compare.published.0.not_comparable", "\"not defined\""];
    "scene/ExpectFile.name", Compare, ["scene", "compare.expect.0.name", "\"another\""];
    "scene/ExpectFile.program", Compare, ["scene", "compare.expect.0.program", "\"main\""];
    "scene/ExpectFile.against", Compare, ["scene", "compare.expect.2.against", ""];
    "scene/ExpectFile.quantity", Compare, ["scene", "compare.expect.0.quantity", "\"max-velocity\""];
    "scene/ExpectFile.axis", Compare, ["scene", "compare.expect.0.axis", "\"Y\""];
    "scene/ExpectFile.figure", Compare, ["scene", "compare.expect.0.figure", "\"smallest margin\""];
    "scene/ExpectFile.form", Compare, ["scene", "compare.expect.2.form", "\"reduction\""];
    "scene/ExpectFile.at_least", Compare, ["scene", "compare.expect.0.at_least", "1000"];
    "scene/ExpectFile.at_most", Compare, ["scene", "compare.expect.0.at_most", "8"];
    "scene/ExpectFile.gate", Compare, ["scene", "compare.expect.1.gate", "\"surface\""];
    "scene/ExpectFile.source", Compare, ["scene", "compare.expect.0.source", "\"another\""];

    "machine/.up", MillServo, ["machine", "up", "[0, 1, 0]"];
    "machine/.zero", Mill, ["machine", "zero", "\"home\""];
    "machine/.model", Model, ["machine", "model", "\"nowhere.glb\""];
    "machine/.joint", Mill, ["machine", "joint.0.travel_mm", "[-15, 100]"];
    "machine/.platform", Hybrid, ["machine", "platform", "[]"];
    "machine/.errors", MillErrors, ["machine", "errors", ""];
    "machine/.spindle", Mill, ["machine", "spindle.max_speed_rpm", "3000"];
    "machine/.table", Mill, ["machine", "table.point_mm", "[0, 0, 32]"];
    "machine/.control", Mill, ["machine", "control.tool_change_time_s", "0.2"];
    "machine/.body_density", MillServo, ["machine", "body_density", ""];
    "machine/.body", Mill, ["machine", "body.2.check", "false"];
    "machine/JointFile.name", Mill, ["machine", "joint.0.name", "\"U\""];
    "machine/JointFile.kind", Mill, ["machine", "joint.0.kind", "\"rotary\""];
    "machine/JointFile.carries", Mill, ["machine", "joint.0.carries", "\"tool\""];
    "machine/JointFile.parent", Mill, ["machine", "joint.1.parent", "\"base\""];
    "machine/JointFile.direction", Mill, ["machine", "joint.0.direction", "[0.6, 0, 0.8]"];
    "machine/JointFile.point_mm", Five, ["machine", "joint.3.point_mm", "[0, 0, 25]"];
    "machine/JointFile.sense", Mill, ["machine", "joint.0.sense", "1"];
    "machine/JointFile.travel_mm", Mill, ["machine", "joint.0.travel_mm", "[-10, 200]"];
    "machine/JointFile.travel_deg", Five, ["machine", "joint.3.travel_deg", "[-30, 8]"];
    "machine/JointFile.endless", Five, ["machine", "joint.4.endless", "false"];
    "machine/JointFile.held", Five, ["machine", "joint.4.held", "true"];
    "machine/JointFile.max_velocity_mm_min", Mill, ["machine", "joint.1.max_velocity_mm_min", "1000"];
    "machine/JointFile.max_velocity_deg_s", Five, ["machine", "joint.3.max_velocity_deg_s", "20"];
    "machine/JointFile.max_velocity_rev_min", FiveServo, ["machine", "joint.4.max_velocity_rev_min", "3"];
    "machine/JointFile.max_acceleration_mm_s2", Mill, ["machine", "joint.1.max_acceleration_mm_s2", "500"];
    "machine/JointFile.max_acceleration_deg_s2", Five, ["machine", "joint.3.max_acceleration_deg_s2", "100"];
    "machine/JointFile.max_jerk_mm_s3", Mill, ["machine", "joint.1.max_jerk_mm_s3", "9000"];
    "machine/JointFile.max_jerk_deg_s3", Five, ["machine", "joint.3.max_jerk_deg_s3", "900"];
    "machine/JointFile.rapid_velocity_mm_min", Mill, ["machine", "joint.0.rapid_velocity_mm_min", "5000"];
    "machine/JointFile.rapid_velocity_deg_s", Five, ["machine", "joint.3.rapid_velocity_deg_s", "20"];
    "machine/JointFile.rapid_velocity_rev_min", Five, ["machine", "joint.4.rapid_velocity_rev_min", "3"];
    "machine/JointFile.home_mm", Mill, ["machine", "joint.0.home_mm", "30"];
    "machine/JointFile.home_deg", Five, ["machine", "joint.3.home_deg", "2"];
    "machine/JointFile.tool_change_mm", Mill, ["machine", "joint.0.tool_change_mm", "35"];
    "machine/JointFile.tool_change_deg", Five, ["machine", "joint.3.tool_change_deg", "6"];
    "machine/JointFile.moving_mass_kg", MillServo, ["machine", "joint.1.moving_mass_kg", "150"];
    "machine/JointFile.moving_inertia_kg_m2", FiveServo, ["machine", "joint.3.moving_inertia_kg_m2", "3"];
    "machine/JointFile.drive", MillServo, ["machine", "joint.0.drive", ""];
    "machine/DriveFile.position_gain_1_s", MillServo, ["machine", "joint.0.drive.position_gain_1_s", "50"];
    "machine/DriveFile.velocity_gain_N_s_m", MillServo, ["machine", "joint.0.drive.velocity_gain_N_s_m", "28_000"];
    "machine/DriveFile.velocity_gain_Nm_s_rad", FiveServo, ["machine", "joint.3.drive.velocity_gain_Nm_s_rad", "800"];
    "machine/DriveFile.velocity_bandwidth_hz", MillServo, ["machine", "joint.1.drive.velocity_bandwidth_hz", "45"];
    "machine/DriveFile.integral_time_ms", MillServo, ["machine", "joint.0.drive.integral_time_ms", "12"];
    "machine/DriveFile.velocity_feed_forward", MillServo, ["machine", "joint.0.drive.velocity_feed_forward", "0.5"];
    "machine/DriveFile.acceleration_feed_forward", MillServo, ["machine", "joint.0.drive.acceleration_feed_forward", "0.5"];
    "machine/DriveFile.max_force_N", MillServo, ["machine", "joint.0.drive.max_force_N", "100"];
    "machine/DriveFile.max_torque_Nm", FiveServo, ["machine", "joint.3.drive.max_torque_Nm", "20"];
    "machine/DriveFile.viscous_friction_N_s_m", MillServo, ["machine", "joint.0.drive.viscous_friction_N_s_m", "300"];
    "machine/DriveFile.viscous_friction_Nm_s_rad", FiveServo, ["machine", "joint.3.drive.viscous_friction_Nm_s_rad", "9"];
    "machine/DriveFile.coulomb_friction_N", MillServo, ["machine", "joint.0.drive.coulomb_friction_N", "40"];
    "machine/DriveFile.coulomb_friction_Nm", FiveServo, ["machine", "joint.3.drive.coulomb_friction_Nm", "4"];
    "machine/DriveFile.static_friction_N", MillServo, ["machine", "joint.0.drive.static_friction_N", "80"];
    "machine/DriveFile.static_friction_Nm", FiveServo, ["machine", "joint.3.drive.static_friction_Nm", "9"];
    "machine/DriveFile.stribeck_velocity_mm_min", MillServo, ["machine", "joint.0.drive.stribeck_velocity_mm_min", "600"];
    "machine/DriveFile.stribeck_velocity_deg_s", FiveServo, ["machine", "joint.3.drive.stribeck_velocity_deg_s", "9"];
    "machine/DriveFile.backlash_mm", MillServo, ["machine", "joint.0.drive.backlash_mm", "0.01"];
    "machine/DriveFile.backlash_deg", FiveServo, ["machine", "joint.3.drive.backlash_deg", "0.01"];
    "machine/DriveFile.encoder", MillServo, ["machine", "joint.0.drive.encoder", "\"motor\""];
    "machine/DriveFile.elastic_frequency_hz", MillServo, ["machine", "joint.0.drive.elastic_frequency_hz", "80"];
    "machine/DriveFile.elastic_damping", MillServo, ["machine", "joint.0.drive.elastic_damping", "0.2"];
    "machine/DriveFile.motor_mass_kg", MillServo, ["machine", "joint.0.drive.motor_mass_kg", "90"];
    "machine/DriveFile.motor_inertia_kg_m2", FiveServo, ["machine", "joint.3.drive.motor_inertia_kg_m2", "0.9"];
    "machine/DriveFile.counterbalance_N", MillServo, ["machine", "joint.2.drive.counterbalance_N", "800"];
    "machine/PlatformFile.kind", Hybrid, ["machine", "platform.0.kind", "\"hexapod\""];
    "machine/PlatformFile.heave", Hybrid, ["machine", "platform.0.heave", "\"X\""];
    "machine/PlatformFile.tilt", Hybrid, ["machine", "platform.0.tilt", "\"B\""];
    "machine/PlatformFile.fixed_radius_mm", Hybrid, ["machine", "platform.0.fixed_radius_mm", "800"];
    "machine/PlatformFile.moving_radius_mm", Hybrid, ["machine", "platform.0.moving_radius_mm", "170"];
    "machine/PlatformFile.height_mm", Hybrid, ["machine", "platform.0.height_mm", "250"];
    "machine/PlatformFile.leg_1_direction", Hybrid, ["machine", "platform.0.leg_1_direction", "[0, -1, 0]"];
    "machine/PlatformFile.leg", Hybrid, ["machine", "platform.0.leg.0.travel_mm", "[400, 640]"];
    "machine/LegFile.moving_mass_kg", HybridServo, ["machine", "platform.0.leg.0.moving_mass_kg", "20"];
    "machine/LegFile.drive", HybridServo, ["machine", "platform.0.leg.0.drive.position_gain_1_s", "30"];
    "machine/LegFile.name", Hybrid, ["machine", "platform.0.leg.0.name", "\"L2\""];
    "machine/LegFile.travel_mm", Hybrid, ["machine", "platform.0.leg.1.travel_mm", "[400, 640]"];
    "machine/LegFile.max_velocity_mm_min", Hybrid, ["machine", "platform.0.leg.0.max_velocity_mm_min", "60"];
    "machine/LegFile.max_acceleration_mm_s2", Hybrid, ["machine", "platform.0.leg.0.max_acceleration_mm_s2", "5"];
    "machine/LegFile.max_jerk_mm_s3", Hybrid, ["machine", "platform.0.leg.0.max_jerk_mm_s3", "50"];
    "machine/ErrorsFile.constant", MillErrors, ["machine", "errors.constant.EZ0S_um", "30"];
    "machine/ErrorsFile.table", MillErrors, ["machine", "errors.table", "[]"];
    "machine/ErrorTableFile.joint", MillErrors, ["machine", "errors.table.0.joint", "\"Q\""];
    "machine/ErrorTableFile.at_mm", MillErrors, ["machine", "errors.table.0.at_mm", "[-20, 0, 40]"];
    "machine/ErrorTableFile.at_deg", FiveErrors, ["machine", "errors.table.0.at_deg", "[0, 10]"];
    "machine/ErrorTableFile.reference_mm", MillErrors, ["machine", "errors.table.0.reference_mm", "[0, 200, 0]"];
    "machine/ErrorTableFile.values", MillErrors, ["machine", "errors.table.0.values.EZX_um", "[0, 9, 20]"];
    "machine/SpindleFile.on", Mill, ["machine", "spindle.on", "\"X\""];
    "machine/SpindleFile.origin_mm", Mill, ["machine", "spindle.origin_mm", "[0, 0, 1]"];
    "machine/SpindleFile.direction", Mill, ["machine", "spindle.direction", "[0, 0.6, 0.8]"];
    "machine/SpindleFile.max_speed_rpm", Mill, ["machine", "spindle.max_speed_rpm", "3500"];
    "machine/SpindleFile.start_time_s", Mill, ["machine", "spindle.start_time_s", "2"];
    "machine/TableFile.on", Mill, ["machine", "table.on", "\"X\""];
    "machine/TableFile.point_mm", Mill, ["machine", "table.point_mm", "[0, 0, 31]"];
    "machine/TableFile.normal", Mill, ["machine", "table.normal", "[0, 0, -1]"];
    "machine/MachineControlFile.cycle_time_ms", Mill, ["machine", "control.cycle_time_ms", "8"];
    "machine/MachineControlFile.file", Mill, ["machine", "control.file", "\"okuma-osp\""];
    "machine/MachineControlFile.block_time_ms", Mill, ["machine", "control.block_time_ms", "60"];
    "machine/MachineControlFile.tool_change_time_s", Mill, ["machine", "control.tool_change_time_s", "0.4"];
    "machine/MachineControlFile.rapid_mode", Mill, ["machine", "control.rapid_mode", "\"independent\""];
    "machine/MachineControlFile.kinematics", Five, ["machine", "control.kinematics", "[\"tilted-plane\"]"];
    "machine/MachineControlFile.default_tolerance_mm", MillServo, ["machine", "control.default_tolerance_mm", "0.2"];
    "machine/MachineControlFile.default_orientation_tolerance_deg", Five, ["machine", "control.default_orientation_tolerance_deg", "0.01"];
    "machine/MachineControlFile.pole_cone_deg", Five, ["machine", "control.pole_cone_deg", "0"];
    "machine/DensityFile.default_kg_m3", MillServo, ["machine", "body_density.default_kg_m3", "3500"];
    "machine/DensityFile.roles_kg_m3", MillServo, ["machine", "body_density.roles_kg_m3.table", "9000"];
    "machine/.pairs", Mill, ["machine", "pairs", "[{ bodies = [\"bed\", \"head\"], near_miss_mm = 900 }]"];
    "machine/PairFile.bodies", Mill, ["machine", "pairs", "[{ bodies = [\"bed\", \"holder\"], near_miss_mm = 900 }]"];
    "machine/PairFile.near_miss_mm", Mill, ["machine", "pairs", "[{ bodies = [\"bed\", \"head\"], near_miss_mm = 2 }]"];
    "machine/PairFile.check", Mill, ["machine", "pairs", "[{ bodies = [\"bed\", \"head\"], check = false, reason = \"far\" }]"];
    "machine/PairFile.reason", Mill, ["machine", "pairs", "[{ bodies = [\"bed\", \"head\"], near_miss_mm = 3, reason = \"far\" }]"];
    "machine/BodyFile.name", Mill, ["machine", "body.1.name", "\"plate\""];
    "machine/BodyFile.role", MillServo, ["machine", "body.6.role", "\"table\""];
    "machine/BodyFile.attached_to", Mill, ["machine", "body.2.attached_to", "\"base\""];
    "machine/BodyFile.check", Mill, ["machine", "body.1.check", "false"];
    "machine/BodyFile.mass", MillServo, ["machine", "body.3.mass", ""];
    "machine/BodyFile.node", Model, ["machine", "body.7.node", "\"nowhere\""];
    "machine/BodyFile.box", MillServo, ["machine", "body.1.box", "[{ min_mm = [-60, -60, -40], max_mm = [60, 60, 20] }]"];
    "machine/BodyFile.cylinder", MillServo, ["machine", "body.6.cylinder", "[{ from_mm = [0, 0, 220], to_mm = [0, 0, 260], radius_mm = 30 }]"];
    "machine/BodyFile.prism", MillServo, ["machine", "body.2.prism", "[{ along = \"z\", range_mm = [-30, 200], outline_mm = [[-60, -60], [60, -60], [60, 60]] }]"];
    "machine/MassFile.mass_kg", MillServo, ["machine", "body.3.mass.mass_kg", "40"];
    "machine/MassFile.density_kg_m3", MillServo, ["machine", "body.2.mass.density_kg_m3", "2500"];
    "machine/MassFile.center_mm", FiveServo, ["machine", "body.1.mass.center_mm", "[10, 0, -20]"];
    "machine/MassFile.inertia_kg_m2", FiveServo, ["machine", "body.1.mass.inertia_kg_m2", "[1, 1, 1, 0, 0, 0]"];
    "machine/BoxFile.min_mm", MillServo, ["machine", "body.1.box.0.min_mm", "[-90, -60, -40]"];
    "machine/BoxFile.max_mm", MillServo, ["machine", "body.1.box.0.max_mm", "[90, 60, 0]"];
    "machine/CylinderFile.from_mm", MillServo, ["machine", "body.6.cylinder.0.from_mm", "[0, 0, 190]"];
    "machine/CylinderFile.to_mm", MillServo, ["machine", "body.6.cylinder.0.to_mm", "[0, 0, 290]"];
    "machine/CylinderFile.radius_mm", MillServo, ["machine", "body.6.cylinder.0.radius_mm", "50"];
    "machine/CylinderFile.end_radius_mm", MillServo, ["machine", "body.6.cylinder.0.end_radius_mm", "50"];
    "machine/PrismFile.along", Model, ["machine", "body.8.prism.0.along", "\"x\""];
    "machine/PrismFile.range_mm", MillServo, ["machine", "body.2.prism.0.range_mm", "[60, 260]"];
    "machine/PrismFile.outline_mm", MillServo, ["machine", "body.2.prism.0.outline_mm", "[[-60, -60], [60, -60], [60, 80], [-60, 80]]"];

    "tools/.tool", Mill, ["tools", "tool", "[]"];
    "tools/ToolEntry.number", Mill, ["tools", "tool.0.number", "2"];
    "tools/ToolEntry.name", Mill, ["tools", "tool.0.name", "\"END\""];
    "tools/ToolEntry.kind", Ball, ["tools", "tool.0.kind", "\"flat\""];
    "tools/ToolEntry.diameter_mm", Ball, ["tools", "tool.0.diameter_mm", "5"];
    "tools/ToolEntry.corner_radius_mm", BullNose, ["tools", "tool.0.corner_radius_mm", "1.5"];
    "tools/ToolEntry.corner_center_radius_mm", Apt, ["tools", "tool.0.corner_center_radius_mm", "1.95"];
    "tools/ToolEntry.corner_center_height_mm", Apt, ["tools", "tool.0.corner_center_height_mm", "1.1"];
    "tools/ToolEntry.lower_angle_deg", Apt, ["tools", "tool.0.lower_angle_deg", "6"];
    "tools/ToolEntry.upper_angle_deg", Apt, ["tools", "tool.0.upper_angle_deg", "7"];
    "tools/ToolEntry.cutter_height_mm", Apt, ["tools", "tool.0.cutter_height_mm", "1.9"];
    "tools/ToolEntry.point_angle_deg", Drill, ["tools", "tool.0.point_angle_deg", "90"];
    "tools/ToolEntry.tip_diameter_mm", TaperBall, ["tools", "tool.0.tip_diameter_mm", "2"];
    "tools/ToolEntry.tip_diameter_mm", Chamfer, ["tools", "tool.0.tip_diameter_mm", "2"];
    "tools/ToolEntry.tip_radius_mm", Barrel, ["tools", "tool.0.tip_radius_mm", "1.5"];
    "tools/ToolEntry.side_radius_mm", Oval, ["tools", "tool.0.side_radius_mm", "25"];
    "tools/ToolEntry.lens_radius_mm", Lens, ["tools", "tool.0.lens_radius_mm", "10"];
    "tools/ToolEntry.half_angle_deg", TaperBall, ["tools", "tool.0.half_angle_deg", "20"];
    "tools/ToolEntry.entering_angle_deg", FaceMill, ["tools", "tool.0.entering_angle_deg", "60"];
    "tools/ToolEntry.pitch_mm", Tap, ["tools", "tool.0.pitch_mm", "0.5"];
    "tools/ToolEntry.thread_mill", Part, ["tools", "tool.0.thread_mill", "true"];
    "tools/ToolEntry.segments", Profile, ["tools", "tool.0.segments", "[{ to_mm = [3, 1] }, { to_mm = [3, 12] }]"];
    "tools/ToolEntry.flute_length_mm", DrumWheel, ["tools", "tool.0.flute_length_mm", "1.5"];
    "tools/ToolEntry.neck_diameter_mm", Short, ["tools", "tool.0.neck_diameter_mm", "6.5"];
    "tools/ToolEntry.neck_length_mm", Short, ["tools", "tool.0.neck_length_mm", "2"];
    "tools/ToolEntry.transition_length_mm", Short, ["tools", "tool.0.transition_length_mm", "2"];
    "tools/ToolEntry.shank_diameter_mm", Short, ["tools", "tool.0.shank_diameter_mm", "8"];
    "tools/ToolEntry.overall_length_mm", Mill, ["tools", "tool.0.overall_length_mm", "20"];
    "tools/ToolEntry.gauge_length_mm", Mill, ["tools", "tool.0.gauge_length_mm", "85"];
    "tools/ToolEntry.flutes", Mill, ["tools", "tool.0.flutes", "4"];
    "tools/ToolEntry.center_cutting", HollowUnstated, ["tools", "tool.0.center_cutting", "true"];
    "tools/ToolEntry.dead_center_diameter_mm", Hollow, ["tools", "tool.0.dead_center_diameter_mm", "0.2"];
    "tools/ToolEntry.max_ramp_angle_deg", Hollow, ["tools", "tool.0.max_ramp_angle_deg", "10"];
    "tools/ToolEntry.max_speed_rpm", Mill, ["tools", "tool.0.max_speed_rpm", "3000"];
    "tools/ToolEntry.hand", Mill, ["tools", "tool.0.hand", "\"left\""];
    "tools/ToolEntry.holder", Mill, ["tools", "tool.0.holder", ""];
    "tools/ToolEntry.chosen", Mill, ["tools", "tool.0.chosen", "[{ keys = [\"hand\"], reason = \"not there\" }]"];
    "tools/SegmentEntry.to_mm", Profile, ["tools", "tool.0.segments.0.to_mm", "[1.5, 0]"];
    "tools/SegmentEntry.center_mm", Profile, ["tools", "tool.0.segments.1.center_mm", ""];
    "tools/HolderEntry.sections", Short, ["tools", "tool.0.holder.sections", "[{ diameter_mm = 20, length_mm = 60 }]"];
    "tools/SectionEntry.diameter_mm", Short, ["tools", "tool.0.holder.sections.0.diameter_mm", "22"];
    "tools/SectionEntry.top_diameter_mm", Short, ["tools", "tool.0.holder.sections.0.top_diameter_mm", "28"];
    "tools/SectionEntry.length_mm", Short, ["tools", "tool.0.holder.sections.0.length_mm", "3"];
    "tools/ChosenEntry.keys", Mill, ["tools", "tool.0.chosen.0.keys", "[\"hand\"]"];
}
