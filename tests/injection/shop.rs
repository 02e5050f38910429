//! A block on a plate under a three-axis mill: scene, tools and program of one case, and its run.

use std::{fmt::Write as _, fs, path::Path};

use proveout_geom::{Pose, TriMesh, Vector, write_stl};
use proveout_sim::{
    Choice,
    verdict::{State, Verdict},
};
use proveout_tests::{prove, root};

/// Top of the machine's table is Z0; the zero point of the part lies so far above it, mm.
const ZERO_ABOVE_TABLE_MM: f64 = 150.0;
/// Deviation of the cut part from the design that the scenes allow, mm.
pub(crate) const TOLERANCE_MM: f64 = 0.01;

/// Raw material.
pub(crate) enum Stock {
    /// Half lengths along X and Y, and height below Z0, mm.
    Block([f64; 3]),
    /// A closed mesh.
    Mesh(TriMesh),
}

/// What a flat end mill looks like, mm.
#[derive(Clone, Copy)]
pub(crate) struct EndMill {
    pub(crate) diameter: f64,
    pub(crate) flutes: f64,
    pub(crate) shank: f64,
    /// From the tip to the holder of 40 mm diameter.
    pub(crate) out_of_holder: f64,
}

/// One scene with one program.
pub(crate) struct Case {
    pub(crate) family: &'static str,
    /// The gates that must not pass when there is a fault.
    pub(crate) gates: &'static [&'static str],
    /// Smallest dimension of what must be found, mm.
    pub(crate) size_mm: f64,
    pub(crate) stock: Stock,
    pub(crate) design: Option<TriMesh>,
    /// Turn of stock, design and path about Z, degrees.
    pub(crate) turn_deg: f64,
    pub(crate) tool: EndMill,
    /// A block that the setup holds next to the plate: corners, mm.
    pub(crate) clamp: Option<[[f64; 3]; 2]>,
    /// Moves between tool change and end.
    pub(crate) moves: Moves,
}

/// Words of a program, its X and Y in the frame of the part before it is turned.
#[derive(Default)]
pub(crate) struct Moves {
    turn: f64,
    text: String,
}

impl Moves {
    pub(crate) fn turned_by(degrees: f64) -> Self {
        Self { turn: degrees.to_radians(), text: String::new() }
    }

    pub(crate) fn words(&mut self, words: &str) -> &mut Self {
        self.text += words;
        self.text.push('\n');
        self
    }

    /// A move with both coordinates of the plane.
    pub(crate) fn plane(&mut self, word: &str, x: f64, y: f64) -> &mut Self {
        let (s, c) = self.turn.sin_cos();
        writeln!(self.text, "{word} X{:.6} Y{:.6}", c * x - s * y, s * x + c * y).ok();
        self
    }

    pub(crate) fn height(&mut self, word: &str, z: f64) -> &mut Self {
        writeln!(self.text, "{word} Z{z:.6}").ok();
        self
    }
}

/// What a run said.
pub(crate) enum Answer {
    /// The scene was refused.
    Refused(String),
    Verdict(Box<Verdict>),
}

impl Answer {
    /// State and reason of a gate; none where the scene was refused.
    pub(crate) fn gate(&self, name: &str) -> Option<(State, &str)> {
        match self {
            Self::Refused(_) => None,
            Self::Verdict(v) => v.gates.iter().find(|g| g.gate.name() == name).map(|g| (g.state, g.reason.as_str())),
        }
    }
}

/// Writes the case to a folder and runs it with cells of `cell_mm`.
pub(crate) fn run(case: &Case, cell_mm: f64, folder: &Path) -> Answer {
    write(case, cell_mm, folder).expect("the folder takes files");
    match prove(folder, &Choice::default(), 1) {
        Ok(run) => Answer::Verdict(Box::new(run.verdict)),
        Err(e) => Answer::Refused(e.to_string()),
    }
}

fn write(case: &Case, cell_mm: f64, folder: &Path) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    let turned = |mesh: &TriMesh| {
        let angle = case.turn_deg.to_radians();
        mesh.transformed(&Pose::from_axis_angle(&Vector::z(), angle))
    };
    let mesh = |name: &str, mesh: &TriMesh| write_stl(&folder.join(name), &turned(mesh)).map_err(std::io::Error::other);
    let (stock, half, bottom) = match &case.stock {
        Stock::Block([x, y, h]) if case.turn_deg == 0.0 => {
            (format!("box = {{ min_mm = [{}, {}, {}], max_mm = [{x}, {y}, 0] }}", -x, -y, -h), [*x, *y], -h)
        }
        Stock::Block([x, y, h]) => {
            let b = proveout_geom::Aabb { min: [-x, -y, -h].into(), max: [*x, *y, 0.0].into() };
            mesh("stock.stl", &proveout_geom::box_mesh(&b))?;
            ("mesh = \"stock.stl\"".to_owned(), [*x, *y], -h)
        }
        Stock::Mesh(m) => {
            mesh("stock.stl", m)?;
            let b = m.aabb();
            ("mesh = \"stock.stl\"".to_owned(), [b.max.x, b.max.y], b.min.z)
        }
    };
    let side = 0.4 * half[0].min(half[1]);
    let part = if let Some(d) = &case.design {
        mesh("part.stl", d)?;
        "[part]\nmesh = \"part.stl\"\n"
    } else {
        ""
    };
    let tolerances = if case.design.is_some() {
        format!("gouge_mm = {TOLERANCE_MM}\nexcess_mm = {TOLERANCE_MM}\n")
    } else {
        String::new()
    };
    let clamp = case.clamp.map_or_else(String::new, |[min, max]| {
        format!("[[fixture]]\nname = \"clamp\"\nbox = {{ min_mm = {min:?}, max_mm = {max:?} }}\n")
    });
    let scene = format!(
        "name = \"case\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = {cell_mm}\n[stock]\n{stock}\n{part}\
         [mount]\ntranslation_mm = [0, 0, {ZERO_ABOVE_TABLE_MM}]\n[work_offsets.G54]\nZ_mm = {ZERO_ABOVE_TABLE_MM}\n\
         [[fixture]]\nname = \"plate\"\nbox = {{ min_mm = [{}, {}, {}], max_mm = [{side}, {side}, {bottom}] }}\n{clamp}\
         [control]\ndynamics = \"planned\"\n[tolerances]\nnear_miss_mm = 0\n{tolerances}\
         [[program]]\nname = \"p\"\nfile = \"p.mpf\"\ndialect = \"siemens-840d\"\n",
        root().join("machines/three-axis-mill"),
        -side,
        -side,
        -ZERO_ABOVE_TABLE_MM,
    );
    fs::write(folder.join("scene.toml"), scene)?;
    let EndMill { diameter, flutes, shank, out_of_holder } = case.tool;
    let tools = format!(
        "[[tool]]\nnumber = 1\nname = \"T1\"\nkind = \"flat\"\ndiameter_mm = {diameter}\nflute_length_mm = {flutes}\n\
         shank_diameter_mm = {shank}\noverall_length_mm = {}\ngauge_length_mm = {}\nflutes = 2\ncenter_cutting = true\n\
         source = \"made for this test\"\n[tool.holder]\nname = \"H\"\nsections = [{{ diameter_mm = 40, length_mm = 50 }}]\n",
        out_of_holder + 20.0,
        out_of_holder + 50.0,
    );
    fs::write(folder.join("tools.toml"), tools)?;
    let program = format!("G17 G54 G90 G94 G710 G60\nT=\"T1\"\nM6\nD1\n{}G0 Z60\nM5\nM30\n", case.moves.text);
    fs::write(folder.join("p.mpf"), program)
}
