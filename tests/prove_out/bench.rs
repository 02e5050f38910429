//! Small scenes on machines of the library, written for one test each.

use std::fs;

use proveout_sim::{
    Choice, SimError,
    finding::Finding,
    run::RunResult,
    scene::Dynamics,
    verdict::{GateVerdict, State},
};
use proveout_tests::{prove, root};

/// Statement of a scene without fixtures.
const WORKHOLDING: &str = "workholding = \"none\"\nworkholding_reason = \"not part of this test\"\n";

/// A block on a machine and one program.
pub(crate) struct Bench {
    /// Name of a machine of the library.
    pub(crate) machine: &'static str,
    /// Text at the end of the machine's file.
    pub(crate) machine_extra: String,
    /// Tool library; empty: that of the axis cross.
    pub(crate) tools: String,
    pub(crate) resolution_mm: f64,
    /// Smallest and largest coordinates of the block, mm.
    pub(crate) block: [[f64; 3]; 2],
    /// Height of the workpiece frame over the table frame, mm; G54 is there as well.
    pub(crate) height_mm: f64,
    pub(crate) program: String,
    pub(crate) file: &'static str,
    /// Text at the end of the scene.
    pub(crate) extra: String,
}

impl Default for Bench {
    fn default() -> Self {
        Self {
            machine: "three-axis-mill",
            machine_extra: String::new(),
            tools: String::new(),
            resolution_mm: 0.25,
            block: [[0.0, 0.0, -20.0], [60.0, 20.0, 0.0]],
            height_mm: 150.0,
            program: String::new(),
            file: "program.nc",
            extra: String::new(),
        }
    }
}

impl Bench {
    pub(crate) fn run(&self, dynamics: Dynamics) -> Result<RunResult, SimError> {
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = |name: &str| folder.path().join(name);
        let mut machine = root().join("machines").join(self.machine);
        if !self.machine_extra.is_empty() {
            let text = fs::read_to_string(machine.join("machine.toml")).expect("readable") + &self.machine_extra;
            let own = at("machine");
            fs::create_dir(&own).expect("a folder");
            fs::write(own.join("machine.toml"), text).expect("written");
            fs::copy(machine.join("model.glb"), own.join("model.glb")).expect("copied");
            machine = own;
        }
        let tools = if self.tools.is_empty() { root().join("tools/axis-cross.toml") } else { at("tools.toml") };
        fs::write(at("tools.toml"), &self.tools).expect("written");
        let [min, max] = self.block;
        let height = self.height_mm;
        let workholding = if self.extra.contains("[[fixture]]") { "" } else { WORKHOLDING };
        let scene = format!(
            "name = \"bench\"\n{workholding}machine = {machine:?}\ntools = {tools:?}\nresolution_mm = {}\n\
             [stock.box]\nmin_mm = {min:?}\nmax_mm = {max:?}\n[mount]\ntranslation_mm = [0, 0, {height}]\n\
             [work_offsets.G54]\nZ_mm = {height}\n[[program]]\nname = \"bench\"\nfile = {:?}\n{}",
            self.resolution_mm, self.file, self.extra,
        );
        fs::write(at("scene.toml"), scene).expect("written");
        fs::write(at(self.file), &self.program).expect("written");
        prove(folder.path(), &Choice { dynamics: Some(dynamics), ..Choice::default() }, 2)
    }

    /// The same with the set points of the control; a run that cannot be made fails the test.
    pub(crate) fn planned(&self) -> RunResult {
        self.run(Dynamics::Planned).unwrap_or_else(|e| panic!("{e}\n{}", self.program))
    }
}

pub(crate) fn gate<'r>(run: &'r RunResult, name: &str) -> &'r GateVerdict {
    run.verdict.gates.iter().find(|g| g.gate.name() == name).expect("a gate")
}

pub(crate) fn state(run: &RunResult, name: &str) -> State {
    gate(run, name).state
}

pub(crate) fn findings<'r>(run: &'r RunResult, code: &str) -> Vec<&'r Finding> {
    run.verdict.findings.iter().filter(|f| f.code == code).collect()
}

/// Line of a program, from 1, on which a text comes first.
pub(crate) fn line_of(program: &str, text: &str) -> u32 {
    program.lines().position(|l| l.contains(text)).map_or(0, |k| k as u32 + 1)
}

/// A flat end mill that cuts at its center, with a holder, 80 mm from the tip to the gauge line.
pub(crate) fn end_mill(number: u32, diameter: f64, more: &str) -> String {
    format!(
        "[[tool]]\nnumber = {number}\nname = \"T{number}\"\nkind = \"flat\"\ndiameter_mm = {diameter:?}\n\
         flute_length_mm = 25\nshank_diameter_mm = {diameter:?}\ngauge_length_mm = 80\n{more}\n\
         holder = {{ sections = [{{ diameter_mm = 40, length_mm = 40 }}] }}\n"
    )
}

/// A program that changes to tool 1, with its length, spindle on.
pub(crate) fn fanuc(body: &str) -> String {
    format!("%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 M3\n{body}\nG49\nG53 G0 Z610.\nM5\nM30\n%\n")
}
