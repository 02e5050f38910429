//! Links as bodies of the machine.

use proveout_geom::{Aabb, Point, box_mesh, write_stl};
use proveout_machine::{Attachment, JointValues, Machine, MachineBody, import_urdf};

use crate::urdf::{Desk, between, of_head, sample};

/// Three slides on the tool, a table link with the given shapes, and one on Z.
fn mill(on_table: &str, on_z: &str) -> String {
    let slide = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"prismatic\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-0.2\" upper=\"0.2\" velocity=\"0.5\"/></joint>\n"
        )
    };
    format!(
        "<robot name=\"mill\"><link name=\"table\">{on_table}</link><link name=\"a\"/><link name=\"b\"/><link name=\"c\">{on_z}</link>\n{}{}{}</robot>",
        slide("X", "table", "a", "1 0 0"),
        slide("Y", "a", "b", "0 1 0"),
        slide("Z", "b", "c", "0 0 1")
    )
}

fn shape(origin: &str, geometry: &str) -> String {
    format!("<collision><origin {origin}/><geometry>{geometry}</geometry></collision>")
}

fn body<'m>(machine: &'m Machine, name: &str) -> &'m MachineBody {
    machine.bodies.iter().find(|b| b.name == name).unwrap_or_else(|| panic!("no body {name}"))
}

fn near(a: &Aabb, min: [f64; 3], max: [f64; 3], tolerance: f64) -> bool {
    (a.min - Point::from(min)).amax() < tolerance && (a.max - Point::from(max)).amax() < tolerance
}

#[test]
fn boxes_cylinders_and_spheres_stand_where_the_links_are() {
    let desk = Desk::new();
    let machine = desk.machine(&import_urdf(&sample("trunnion.urdf"), &between("spindle", "table")).expect("read"));
    assert_eq!(machine.bodies.len(), 8, "{:?}", machine.bodies.iter().map(|b| &b.name).collect::<Vec<_>>());
    for b in &machine.bodies {
        b.mesh.check_solid().unwrap_or_else(|e| panic!("{}: {e}", b.name));
        assert!(b.check);
    }
    let on = |name: &str| match body(&machine, name).attached_to {
        Attachment::Base => "base".to_owned(),
        Attachment::Joint(j) => machine.joints[j].name.clone(),
    };
    let links = ["bed", "bearings", "beam", "saddle", "headstock", "spindle", "cradle", "table"];
    assert_eq!(links.map(on), ["base", "base", "Y", "X", "Z", "Z", "A", "C"]);
    // The frame of the beam is at (0, 361, 1786) mm; the arms of the cradle about the axis at 1020 mm.
    assert!(near(&body(&machine, "beam").mesh.aabb(), [-740.0, 262.0, 1612.0], [740.0, 460.0, 1960.0], 1e-6));
    let cradle = body(&machine, "cradle").mesh.aabb();
    assert!(near(&cradle, [-382.0, -165.0, 685.0], [382.0, 165.0, 1130.0], 0.2), "{cradle:?}");
    let bed = body(&machine, "bed");
    let ball = bed.mesh.positions.iter().filter(|p| (*p - Point::new(550.0, 550.0, 500.0)).norm() < 15.2).count();
    assert!(ball > 2000, "the ball is a mesh of the model: {ball}");
    // A body moves as its link: the table turned by a quarter of A is upright, its face towards the
    // operator or away from him.
    let mut q = JointValues::ZERO;
    q[machine.joint("A").expect("A")] = -std::f64::consts::FRAC_PI_2;
    let at = machine.bodies.iter().position(|b| b.name == "table").expect("table");
    let face = machine.body_pose(at, &q).vector(&machine.table.normal);
    assert!((face.y + 1.0).abs() < 1e-12, "{face:?}");
    // 260 kg, its center half a meter over the frame of the headstock.
    let mass = body(&machine, "headstock").mass.expect("stated");
    assert!(mass.mass == 260.0 && (mass.center - Point::new(0.0, 10.0, 2300.0)).norm() < 1e-6 && !mass.estimated);
    assert!((mass.inertia[(0, 0)] - 22e6).abs() < 1.0, "kg mm2");
}

#[test]
fn what_is_drawn_counts_where_nothing_else_is_there() {
    let desk = Desk::new();
    let machine = desk.machine(&import_urdf(&sample("head.urdf"), &of_head()).expect("read"));
    assert!(near(&body(&machine, "cabinet").mesh.aabb(), [1050.0, 100.0, 0.0], [1350.0, 700.0, 1600.0], 1e-6));
    let both = shape("xyz=\"0 0 0\"", "<box size=\"1 1 1\"/>")
        + "<visual><geometry><sphere radius=\"3\"/></geometry></visual>";
    let machine = desk.machine(&desk.import(&mill(&both, ""), &between("c", "table")).expect("read"));
    assert!(near(&machine.bodies[0].mesh.aabb(), [-500.0; 3], [500.0; 3], 1e-6));
}

#[test]
fn oblique_boxes_keep_their_corners() {
    let desk = Desk::new();
    let text = mill("", &shape("xyz=\"0.1 0 0.3\" rpy=\"0 0 0.7853981633974483\"", "<box size=\"0.2 0.2 0.1\"/>"));
    let machine = desk.machine(&desk.import(&text, &between("c", "table")).expect("read"));
    let half = 100.0 * 2_f64.sqrt();
    let b = body(&machine, "c");
    // 32 bits of a meter.
    assert!(near(&b.mesh.aabb(), [100.0 - half, -half, 250.0], [100.0 + half, half, 350.0], 1e-3));
    b.mesh.check_solid().expect("closed");
    assert!((b.mesh.volume() - 200.0 * 200.0 * 100.0).abs() < 100.0);
}

#[test]
fn meshes_are_scaled_to_millimeters() {
    let desk = Desk::new();
    let block = box_mesh(&Aabb { min: Point::new(0.0, 10.0, 20.0), max: Point::new(100.0, 60.0, 40.0) });
    std::fs::create_dir_all(desk.path("pkg/meshes")).expect("made");
    write_stl(&desk.path("block.stl"), &block).expect("written");
    write_stl(&desk.path("pkg/meshes/block.STL"), &block).expect("written");
    let of =
        |file: &str, scale: &str| shape("xyz=\"0 0 1\"", &format!("<mesh filename=\"{file}\" scale=\"{scale}\"/>"));
    let aabb = |text: &str| {
        let machine = desk.machine(&desk.import(&mill("", text), &between("c", "table")).expect("read"));
        machine.bodies[0].mesh.check_solid().expect("closed, faces outward");
        machine.bodies[0].mesh.aabb()
    };
    let wanted = ([0.0, 10.0, 1020.0], [100.0, 60.0, 1040.0]);
    for file in ["block.stl", "package://pkg/meshes/block.STL", "./pkg/../block.stl"] {
        assert!(near(&aabb(&of(file, "0.001 0.001 0.001")), wanted.0, wanted.1, 1e-3), "{file}");
    }
    let absolute = format!("file://{}", desk.path("block.stl").display());
    assert!(near(&aabb(&of(&absolute, "0.001 0.001 0.001")), wanted.0, wanted.1, 1e-3));
    // Mirrored, and of its own scale along each axis.
    let turned = aabb(&of("block.stl", "-0.001 0.002 0.001"));
    assert!(near(&turned, [-100.0, 20.0, 1020.0], [0.0, 120.0, 1040.0], 1e-3), "{turned:?}");
    // Without a scale the file is in meters: 100 m is too far.
    let far = desk.import(&mill("", &of("block.stl", "1.1 1 1")), &between("c", "table")).expect_err("too far");
    assert!(far.message.contains("110000 mm") && far.remedy.contains("0.001 0.001 0.001"), "{far}");
    let lost = desk.import(&mill("", &of("package://other/block.stl", "1 1 1")), &between("c", "table"));
    let lost = lost.expect_err("not there");
    assert!(lost.message.contains("not found") && lost.remedy.contains("package") && lost.line == 1, "{lost}");
    let lost = desk.import(&mill("", &of("nowhere.stl", "1 1 1")), &between("c", "table")).expect_err("not there");
    assert!(lost.message.contains("nowhere.stl"), "{lost}");
    // Five triangles are announced, and none is there.
    std::fs::write(desk.path("broken.stl"), [&[0; 80][..], &[5, 0, 0, 0]].concat()).expect("written");
    let broken = desk.import(&mill("", &of("broken.stl", "1 1 1")), &between("c", "table")).expect_err("no mesh");
    assert!(broken.message.contains("broken.stl"), "{broken}");
}

#[test]
fn what_is_not_taken_is_reported() {
    let desk = Desk::new();
    let open = {
        let mut mesh = box_mesh(&Aabb { min: Point::origin(), max: Point::new(0.1, 0.1, 0.1) });
        mesh.triangles.pop();
        mesh
    };
    write_stl(&desk.path("open.stl"), &open).expect("written");
    let shapes = shape("xyz=\"0 0 0\"", "<mesh filename=\"arm.dae\"/>")
        + &shape("xyz=\"0 0 0\"", "<capsule radius=\"1\" length=\"2\"/>")
        + &shape("xyz=\"0 0 0\"", "<mesh filename=\"open.stl\"/>")
        + "<inertial><mass value=\"-3\"/></inertial>";
    let text = mill("", &shapes)
        .replace("name=\"c\"", "name=\"holder\"")
        .replace("link=\"c\"", "link=\"holder\"")
        .replace("</robot>", "<gazebo/><gazebo/><transmission/></robot>");
    let made = desk.import(&text, &between("holder", "table")).expect("read");
    let message = made.notes.join("\n");
    for word in [
        "\"arm.dae\" of link \"holder\" is not imported: save it as STL",
        "<capsule> of link \"holder\" is not imported",
        "hole",
        "mass of link \"holder\" is not imported",
        "body \"holder_link\"",
        "gazebo (2), transmission (1)",
    ] {
        assert!(message.contains(word), "{word:?} is not in:\n{message}");
    }
    let machine = desk.machine(&made);
    assert_eq!(machine.bodies[0].name, "holder_link");
    let bare = desk.import(&mill("", ""), &between("c", "table")).expect("read");
    assert!(bare.model.is_none() && bare.notes.join("\n").contains("no link has a supported shape"));
}
