//! Drives and masses in the machine file: units inside, what is optional, and every mistake with key and
//! remedy.

use std::path::Path;

use proveout_input::InputError;
use proveout_machine::{Encoder, Machine, VelocityGain};

/// A machine with one slide and one table; the places are filled with keys.
fn text(slide: &str, table: &str, body: &str) -> String {
    format!(
        "name = \"test\"\nup = [0, 0, 1]\n\n\
         [[joint]]\nname = \"X\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"base\"\ndirection = [1, 0, 0]\n{slide}\n\n\
         [[joint]]\nname = \"C\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"base\"\ndirection = [0, 0, 1]\n\
         point_mm = [0, 0, 0]\nsense = -1\nendless = true\n{table}\n\n\
         [spindle]\non = \"X\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 1\n\n\
         [table]\non = \"C\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\n\
         [control]\ncycle_time_ms = 1\nblock_time_ms = 0\ntool_change_time_s = 5\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.01\n\n\
         [[body]]\nname = \"slide\"\nrole = \"slide\"\nattached_to = \"X\"\ncheck = true\n{body}\n\
         [[body.box]]\nmin_mm = [0, 0, 0]\nmax_mm = [100, 200, 300]\n"
    )
}

fn read(text: &str) -> Result<Machine, InputError> {
    Machine::from_text(Path::new("machine.toml"), text)
}

fn drive(keys: &str) -> String {
    format!("[joint.drive]\nposition_gain_1_s = 50\n{keys}")
}

#[test]
fn numbers_come_in_the_units_inside() {
    let slide = drive(
        "velocity_gain_N_s_m = 60000\nintegral_time_ms = 12\nmax_force_N = 9000\nviscous_friction_N_s_m = 800\n\
         coulomb_friction_N = 150\nstatic_friction_N = 200\nstribeck_velocity_mm_min = 120\nbacklash_mm = 0.004\n\
         encoder = \"load\"\nelastic_frequency_hz = 50\nelastic_damping = 0.1\nmotor_mass_kg = 300\ncounterbalance_N = -20",
    );
    let table = drive(
        "velocity_bandwidth_hz = 20\nmax_torque_Nm = 250\ncoulomb_friction_Nm = 12\nbacklash_deg = 0.002\nencoder = \"motor\"\nmotor_inertia_kg_m2 = 0.5",
    );
    let machine = read(&text(&slide, &table, "mass = { density_kg_m3 = 7200 }")).unwrap_or_else(|e| panic!("{e}"));
    let x = machine.joints[0].drive.as_ref().expect("a drive");
    assert_eq!(x.velocity_gain, VelocityGain::Gain(60.0)); // N s/mm
    assert_eq!((x.max_force, x.coulomb_friction, x.static_friction), (Some(9000.0), 150.0, 200.0));
    assert_eq!((x.viscous_friction, x.stribeck_velocity, x.backlash), (0.8, 2.0, 0.004));
    assert_eq!((x.integral_time, x.motor_inertia, x.counterbalance), (Some(0.012), Some(300.0), -20.0));
    assert_eq!((x.encoder, x.elastic.expect("elastic").damping), (Encoder::Load, 0.1));
    let c = machine.joints[1].drive.as_ref().expect("a drive");
    assert_eq!(c.velocity_gain, VelocityGain::Bandwidth(20.0 * std::f64::consts::TAU));
    assert_eq!((c.max_force, c.coulomb_friction, c.static_friction), (Some(250e3), 12e3, 12e3)); // N mm
    assert!((c.backlash - 0.002_f64.to_radians()).abs() < 1e-18 && c.motor_inertia == Some(0.5e6));
    // 6 dm³ at 7.2 kg/dm³, evenly spread.
    let mass = machine.bodies[0].mass.expect("a mass");
    assert!((mass.mass - 43.2).abs() < 1e-12 && mass.estimated);
    assert!((mass.center.coords - proveout_geom::Vector::new(50.0, 100.0, 150.0)).norm() < 1e-9);
    assert!((mass.inertia[(0, 0)] - 43.2 / 12.0 * (200.0_f64.powi(2) + 300.0_f64.powi(2))).abs() < 1e-6);
}

#[test]
fn everything_is_optional() {
    let machine = read(&text("", "", "")).unwrap_or_else(|e| panic!("{e}"));
    assert!(machine.joints.iter().all(|j| j.drive.is_none()) && machine.bodies[0].mass.is_none());
    let machine = read(&text("", "", "").replace("up = [0, 0, 1]\n", "")).unwrap_or_else(|e| panic!("{e}"));
    assert!(machine.up.is_none());
    let least = drive("velocity_bandwidth_hz = 20");
    let machine = read(&text(&least, "", "mass = { mass_kg = 5 }")).unwrap_or_else(|e| panic!("{e}"));
    let x = machine.joints[0].drive.as_ref().expect("a drive");
    assert_eq!((x.max_force, x.integral_time, x.backlash, x.encoder), (None, None, 0.0, Encoder::Motor));
}

#[test]
fn a_body_without_a_mass_takes_the_density_of_its_role() {
    let rule = |rule: &str, body: &str| read(&format!("{}\n[body_density]\n{rule}\n", text("", "", body)));
    let mass = |machine: Result<Machine, InputError>| {
        machine.unwrap_or_else(|e| panic!("{e}")).bodies[0].mass.expect("a mass")
    };
    // 6 dm³; evenly spread as if the density stood with the body itself.
    let by_default = mass(rule("default_kg_m3 = 2500", ""));
    let own = mass(read(&text("", "", "mass = { density_kg_m3 = 2500 }")));
    assert!((by_default.mass - 15.0).abs() < 1e-12 && by_default == own);
    let by_role = mass(rule("default_kg_m3 = 2500\nroles_kg_m3 = { slide = 7000 }", ""));
    assert!((by_role.mass - 42.0).abs() < 1e-12 && by_role.estimated);
    let stated = mass(rule("default_kg_m3 = 2500\nroles_kg_m3 = { slide = 7000 }", "mass = { mass_kg = 5 }"));
    assert!((stated.mass - 5.0).abs() < 1e-12, "what a body states goes first");
    // The choice of the numbers is noted like all others.
    let noted = rule("default_kg_m3 = 2500\nchosen = { \"*\" = \"ribbed castings\" }", "").expect("readable");
    assert!(noted.trust.iter().any(|t| t.key == "body_density.*" && t.chosen));
    let silent = rule("default_kg_m3 = 2500", "").expect("readable");
    let has_no_source =
        |m: &Machine| m.diagnose().iter().any(|d| d.code == "machine-no-source" && d.key == "body_density");
    assert!(has_no_source(&silent) && !has_no_source(&noted));
}

#[test]
fn mistakes_are_reported_with_key_and_remedy() {
    let gain = "velocity_bandwidth_hz = 20\n";
    let on_slide = |keys: &str| text(&drive(keys), "", "");
    let on_table = |keys: &str| text("", &drive(keys), "");
    let cases = [
        (on_slide(""), "joint.X.drive.velocity_gain_N_s_m", "give velocity_gain_N_s_m or velocity_bandwidth_hz"),
        (on_slide("velocity_gain_N_s_m = 1\nvelocity_bandwidth_hz = 20"), "velocity_gain_N_s_m", "not both"),
        (on_slide(&format!("{gain}max_torque_Nm = 5")), "joint.X.drive.max_torque_Nm", "write max_force_N"),
        (on_table(&format!("{gain}max_force_N = 5")), "joint.C.drive.max_force_N", "write max_torque_Nm"),
        (on_table(&format!("{gain}counterbalance_N = 5")), "counterbalance_N", "leave it out"),
        (on_slide(&format!("{gain}coulomb_friction_N = -5")), "coulomb_friction_N", "correct the number"),
        (
            on_slide(&format!("{gain}coulomb_friction_N = 9\nstatic_friction_N = 5")),
            "static_friction_N",
            "at least the dry",
        ),
        (on_slide(&format!("{gain}static_friction_N = 5")), "stribeck_velocity_mm_min", "add stribeck_velocity_mm_min"),
        (on_slide(&format!("{gain}backlash_mm = 0.01")), "joint.X.drive.encoder", "encoder = \"motor\""),
        (on_slide(&format!("{gain}elastic_frequency_hz = 50")), "elastic_frequency_hz", "elastic_damping"),
        (
            on_slide(&format!("{gain}elastic_frequency_hz = 50\nelastic_damping = 0.1\nencoder = \"load\"")),
            "motor_mass_kg",
            "add motor_mass_kg",
        ),
        (on_slide(&format!("{gain}velocity_feed_forward = 1.5")), "velocity_feed_forward", "correct the number"),
        (on_slide(&format!("{gain}max_force_N = inf")), "max_force_N", "out of range"),
        (on_slide(&format!("{gain}integral_time_ms = nan")), "integral_time_ms", "out of range"),
        (on_slide("velocity_bandwidth_hz = 20\nposition_gain_1_ms = 3"), "position_gain_1_ms", "position_gain_1_s"),
        (
            on_slide(gain).replace("position_gain_1_s = 50", "position_gain_1_s = nan"),
            "position_gain_1_s",
            "out of range",
        ),
        (text("", "", "mass = {}"), "body.slide.mass", "give mass_kg or density_kg_m3"),
        (text("", "", "mass = { mass_kg = 0 }"), "mass_kg", "above zero"),
        (text("", "", "mass = { mass_kg = 5, center_mm = [0, 0, 0] }"), "center_mm", "together"),
        (
            text("", "", "mass = { mass_kg = 5, center_mm = [0, 0, 0], inertia_kg_m2 = [1, 1, 9, 0, 0, 0] }"),
            "inertia_kg_m2",
            "at most the sum of the other two",
        ),
        (text("", "", "").replace("up = [0, 0, 1]", "up = [0, 0, 2]"), "up", "[0.000000000, 0.000000000, 1.000000000]"),
    ];
    let rule = |rule: &str| format!("{}\n[body_density]\n{rule}\n", text("", "", ""));
    let rules = [
        (rule("default_kg_m3 = -1"), "body_density.default_kg_m3", "above zero"),
        (rule("default_kg_m3 = 1\nroles_kg_m3 = { slide = nan }"), "body_density.roles_kg_m3.slide", "out of range"),
        (
            rule("default_kg_m3 = 1\nroles_kg_m3 = { slied = 5 }"),
            "roles_kg_m3.slied",
            "name a role of this file: slide",
        ),
        (
            rule("default_kg_m3 = 1\nchosen = { mass = \"\" }"),
            "body_density.chosen.mass",
            "name a key of the same table",
        ),
    ];
    for (text, key, remedy) in cases.into_iter().chain(rules) {
        match read(&text) {
            Ok(_) => panic!("accepted: {key}"),
            Err(e) => {
                let message = e.to_string();
                assert!(message.contains(key) && message.contains(remedy), "{key}, {remedy}: {message}");
                assert!(message.starts_with("machine.toml:"), "{message}");
            }
        }
    }
}
