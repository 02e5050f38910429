//! A helper that leaves prepared files: a cylinder with exact points, whose chord error has a closed form.

use std::{
    f64::consts::TAU,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    time::Duration,
};

use proveout_geom::{Point, TriMesh, cylinder_mesh};
use proveout_step::{Helper, StepError, StepFiles, StepMesh};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

/// Radius and height of the cylinder, mm.
pub(crate) const RADIUS: f64 = 10.0;
pub(crate) const HEIGHT: f64 = 20.0;
/// Chord error that the tests ask for, um.
pub(crate) const ASKED_UM: f64 = 50.0;

/// A cylinder of three faces: what a kernel would leave.
pub(crate) struct Fake {
    pub(crate) head: serde_json::Value,
    pub(crate) mesh: Vec<u8>,
    pub(crate) samples: Vec<u8>,
    /// STEP text with three faces.
    pub(crate) text: String,
    /// Lines of the script before the files are copied.
    pub(crate) script: String,
}

/// Triangles of bottom, top and side, in this order.
fn by_face(mesh: &TriMesh) -> [Vec<[u32; 3]>; 3] {
    let mut faces = [const { Vec::new() }; 3];
    for (k, t) in mesh.triangles.iter().enumerate() {
        let z = mesh.corners(k).map(|p| p.z);
        let flat = z.iter().all(|v| *v == z[0]);
        faces[if !flat { 2 } else { usize::from(z[0] > 0.0) }].push(*t);
    }
    faces
}

/// The point of the exact cylinder next to a place on its mesh.
fn on_side(p: &Point) -> Point {
    let scale = RADIUS / p.x.hypot(p.y);
    Point::new(p.x * scale, p.y * scale, p.z)
}

fn bytes_of(points: &[Point]) -> Vec<u8> {
    points.iter().flat_map(|p| p.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>()).collect()
}

impl Fake {
    pub(crate) fn new(sectors: usize) -> Self {
        let mesh = cylinder_mesh(RADIUS, 0.0, HEIGHT, sectors);
        let faces = by_face(&mesh);
        let mut samples = Vec::new();
        for (face, triangles) in faces.iter().enumerate() {
            for t in triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
                let ends = [(a, b), (b, c), (c, a)].map(|(p, q)| middle_of(&p, &q));
                let four = [middle, ends[0], ends[1], ends[2]];
                samples.extend(four.map(|p| if face == 2 { on_side(&p) } else { p }));
            }
        }
        // The rims, between their nodes.
        let rim = |z: f64| {
            (0..sectors).map(move |k| {
                let (sin, cos) = ((k as f64 + 0.5) * TAU / sectors as f64).sin_cos();
                Point::new(RADIUS * cos, RADIUS * sin, z)
            })
        };
        let edges: Vec<Point> = rim(0.0).chain(rim(HEIGHT)).collect();
        let counts = [faces[0].len(), faces[1].len(), faces[2].len()];
        let all: Vec<[u32; 3]> = faces.concat();
        let owners = (0..3_u32).flat_map(|f| vec![f; counts[f as usize]]);
        let mut bin = bytes_of(&mesh.positions);
        bin.extend(all.iter().flatten().flat_map(|i| i.to_le_bytes()));
        bin.extend(owners.flat_map(u32::to_le_bytes));
        let samples_bin = [bytes_of(&samples), bytes_of(&edges)].concat();
        let text = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n\
                    #1=MANIFOLD_SOLID_BREP('rod',#2);\n#2=CLOSED_SHELL('',(#3,#4,#5));\n\
                    #3=ADVANCED_FACE('foot',(#18),#32,.F.);\n#4=ADVANCED_FACE('top',(#18),#32,.T.);\n\
                    #5=ADVANCED_FACE('side',(#18),#32,.T.);\n\
                    #90=(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#91)) REPRESENTATION_CONTEXT('',''));\n\
                    #91=(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));\nENDSEC;\nEND-ISO-10303-21;\n"
            .to_owned();
        let head = serde_json::json!({
            "protocol": 1, "kernel": "fake 1.0", "sha256": "", "units": ["millimetre"], "loose": [],
            "solids": [{ "faces": [0, 3], "volume_mm3": TAU / 2.0 * RADIUS * RADIUS * HEIGHT, "edge_samples": edges.len() }],
            "faces": [
                { "entity": 0, "tri": [0, counts[0]] },
                { "entity": 1, "tri": [counts[0], counts[1]] },
                { "entity": 2, "tri": [counts[0] + counts[1], counts[2]] },
            ],
            "vertices": mesh.positions.len(), "triangles": all.len(),
        });
        Self { head, mesh: bin, samples: samples_bin, text, script: String::new() }
    }

    /// Writes STEP file, answer and helper into a folder.
    pub(crate) fn install(&self) -> Shop {
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = |name: &str| folder.path().join(name);
        let mut head = self.head.clone();
        if head["sha256"] == "" {
            let digest: String = Sha256::digest(self.text.as_bytes()).iter().map(|b| format!("{b:02x}")).collect();
            head["sha256"] = digest.into();
        }
        std::fs::create_dir(at("answer")).expect("made");
        std::fs::write(at("answer/mesh.json"), head.to_string()).expect("written");
        std::fs::write(at("answer/mesh.bin"), &self.mesh).expect("written");
        std::fs::write(at("answer/samples.bin"), &self.samples).expect("written");
        std::fs::write(at("rod.step"), &self.text).expect("written");
        let script = format!(
            "#!/bin/sh\necho \"$@\" >> '{calls}'\n{}\ncp '{answer}'/* \"$8\"\n",
            self.script,
            calls = at("calls").display(),
            answer = at("answer").display()
        );
        std::fs::write(at("helper"), script).expect("written");
        std::fs::set_permissions(at("helper"), std::fs::Permissions::from_mode(0o755)).expect("executable");
        Shop { step: at("rod.step"), helper: at("helper"), folder }
    }

    pub(crate) fn read(&self) -> Result<StepMesh, StepError> {
        self.install().read()
    }

    /// The refusal, with its remedy.
    pub(crate) fn refused(&self) -> String {
        match self.read() {
            Ok(_) => panic!("accepted"),
            Err(e) => format!("{e}; {}", e.help()),
        }
    }
}

fn middle_of(a: &Point, b: &Point) -> Point {
    Point::from((a.coords + b.coords) / 2.0)
}

/// A folder with a STEP file and a helper.
pub(crate) struct Shop {
    pub(crate) folder: TempDir,
    pub(crate) step: PathBuf,
    pub(crate) helper: PathBuf,
}

impl Shop {
    /// Limits that a test can wait for.
    pub(crate) fn helper(&self) -> Helper {
        Helper { time: Duration::from_secs(20), ..Helper::new(self.helper.clone()) }
    }

    pub(crate) fn files(&self) -> StepFiles {
        StepFiles::with_helper(self.helper())
    }

    pub(crate) fn read(&self) -> Result<StepMesh, StepError> {
        self.files().read(&self.step, ASKED_UM).map(|m| (*m).clone())
    }

    /// How often the helper was called.
    pub(crate) fn calls(&self) -> Vec<String> {
        let calls = std::fs::read_to_string(self.folder.path().join("calls")).unwrap_or_default();
        calls.lines().map(str::to_owned).collect()
    }
}

/// The file as a path that tests show.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}
