//! Machines, tools and programs for the tests of the control.
#![allow(dead_code, reason = "every test file uses its part")]

use std::{convert::Infallible, path::Path, sync::Arc};

use proveout_controller::{Chunk, Controller, Settings, Summary};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{
    ArcMotion, AxisValues, Command, Feed, Location, Motion, Offset, Op, OrientationInterpolation, PathMode, Tcp,
    ToolAction, ToolName,
};
use proveout_tool::Tool;

/// X Y Z in the tool, B swivels and C turns the table; limits round numbers.
pub(crate) fn bc_machine() -> Machine {
    let linear = |name: &str, direction: &str, parent: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\n\
             direction = {direction}\ntravel_mm = [-500, 700]\nmax_velocity_mm_min = 24_000\n\
             rapid_velocity_mm_min = 24_000\nmax_acceleration_mm_s2 = 4_000\nmax_jerk_mm_s3 = 80_000\n\n"
        )
    };
    let rotary = |name: &str, direction: &str, point: &str, parent: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"{parent}\"\n\
             direction = {direction}\npoint_mm = {point}\nsense = -1\nendless = true\nmax_velocity_deg_s = 180\n\
             rapid_velocity_deg_s = 180\nmax_acceleration_deg_s2 = 720\nmax_jerk_deg_s3 = 14_400\n\n"
        )
    };
    let text = [
        "name = \"test BC\"\ndescription = \"for tests\"\n\n".to_owned(),
        linear("X", "[1, 0, 0]", "Y"),
        linear("Y", "[0, 1, 0]", "base"),
        linear("Z", "[0, 0, 1]", "X"),
        rotary("B", "[0, 1, 0]", "[0, 0, 60]", "base"),
        rotary("C", "[0, 0, 1]", "[5, -3, 0]", "B"),
        "[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nmax_speed_rpm = 12_000\nstart_time_s = 1.5\n\n\
         [table]\non = \"C\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\n\
         [control]\ncycle_time_ms = 2\nblock_time_ms = 0\ntool_change_time_s = 4\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.01\ndefault_orientation_tolerance_deg = 0.05\n"
            .to_owned(),
    ]
    .concat();
    match Machine::from_text(Path::new("test-bc/machine.toml"), &text) {
        Ok(machine) => machine,
        Err(e) => panic!("{e}"),
    }
}

pub(crate) fn tool(number: u32, gauge_length: f64) -> Tool {
    Tool {
        number,
        name: format!("T{number}"),
        description: String::new(),
        bodies: Vec::new(),
        gauge_length,
        flute_length: 20.0,
        flutes: None,
        center_cutting: None,
        is_tap: false,
        is_thread_mill: false,
        max_ramp_angle: None,
        dead_center: None,
        max_speed_rpm: None,
        left_handed: false,
        overall_length: None,
        has_holder: false,
        edges: None,
        thread: None,
        stylus: None,
        residual: None,
    }
}

/// A program under construction; every operation is a line of its own.
#[derive(Clone, Default)]
pub(crate) struct Program {
    pub(crate) commands: Vec<Command>,
}

pub(crate) fn axes(values: &[(char, f64)]) -> AxisValues {
    let mut out = AxisValues::NONE;
    for &(letter, value) in values {
        out.put(AxisValues::index(letter).expect("an axis letter"), value);
    }
    out
}

pub(crate) fn motion(values: &[(char, f64)]) -> Motion {
    let end = axes(values);
    let mut programmed = 0;
    for &(letter, _) in values {
        programmed |= 1 << AxisValues::index(letter).expect("an axis letter");
    }
    Motion {
        end,
        end_base: end,
        tool_axis: None,
        tool_axis_base: None,
        programmed,
        machine_coordinates: false,
        exact_stop: false,
        solution: proveout_nc::RotarySolution::Nearest,
    }
}

impl Program {
    pub(crate) fn op(mut self, op: Op) -> Self {
        let location = Location {
            file: Arc::from("test.nc"),
            line: self.commands.len() as u32 + 1,
            column: 1,
            length: 1,
            depth: 0,
        };
        self.commands.push(Command { location, op });
        self
    }

    pub(crate) fn g0(self, values: &[(char, f64)]) -> Self {
        self.op(Op::Rapid(motion(values)))
    }

    pub(crate) fn g1(self, values: &[(char, f64)]) -> Self {
        self.op(Op::Linear(motion(values)))
    }

    pub(crate) fn supa(self, values: &[(char, f64)]) -> Self {
        self.op(Op::Rapid(Motion { machine_coordinates: true, ..motion(values) }))
    }

    /// Counter-clockwise in the XY plane for `sweep` > 0, else clockwise.
    pub(crate) fn arc_xy(self, values: &[(char, f64)], center: [f64; 3], radius: f64, sweep: f64) -> Self {
        let normal = [0.0, 0.0, sweep.signum()];
        let motion = motion(values);
        self.op(Op::Arc(ArcMotion {
            motion,
            center,
            center_base: center,
            normal,
            normal_base: normal,
            radius,
            sweep: sweep.abs(),
        }))
    }

    pub(crate) fn g1_at_feed(self, values: &[(char, f64)], mm_s: f64) -> Self {
        self.feed(mm_s).g1(values)
    }

    pub(crate) fn feed(self, mm_s: f64) -> Self {
        self.op(Op::Feed(Feed::PerTime(mm_s)))
    }

    pub(crate) fn change(self, number: u32) -> Self {
        self.op(Op::Tool(ToolAction::Change(ToolName::Number(number))))
    }

    pub(crate) fn edge(self, edge: u32) -> Self {
        self.op(Op::Offset(Offset::ToolEdge { edge }))
    }

    pub(crate) fn tcp(self, on: bool) -> Self {
        self.op(Op::Tcp(Tcp { on, interpolation: OrientationInterpolation::Axes }))
    }

    pub(crate) fn tcp_great_circle(self) -> Self {
        self.op(Op::Tcp(Tcp { on: true, interpolation: OrientationInterpolation::GreatCircle }))
    }

    pub(crate) fn exact_stop(self) -> Self {
        self.op(Op::PathMode(PathMode::ExactStop))
    }

    pub(crate) fn continuous(self, tolerance: f64) -> Self {
        self.op(Op::PathMode(PathMode::Continuous { tolerance: Some(tolerance), orientation_tolerance: None }))
    }

    pub(crate) fn source(&self) -> impl Iterator<Item = Result<Command, Infallible>> + '_ {
        self.commands.iter().cloned().map(Ok)
    }
}

/// Everything a program gives, in one chunk, and the number of chunks.
pub(crate) struct Run {
    pub(crate) all: Chunk,
    pub(crate) chunks: usize,
    pub(crate) summary: Summary,
}

pub(crate) fn run_with(program: &Program, machine: &Machine, tools: &[Tool], settings: &Settings) -> Run {
    let mut controller = match Controller::new(program.source(), machine, tools, settings.clone()) {
        Ok(c) => c,
        Err(e) => panic!("{e}"),
    };
    let mut run = Run { all: Chunk::default(), chunks: 0, summary: Summary::default() };
    loop {
        match controller.next_chunk() {
            Ok(Some(chunk)) => {
                run.chunks += 1;
                run.all.pieces.extend(chunk.pieces);
                run.all.samples.extend(chunk.samples);
                run.all.events.extend(chunk.events);
                run.all.blocks.extend(chunk.blocks);
            }
            Ok(None) => break,
            Err(e) => panic!("{e}"),
        }
    }
    run.summary = controller.summary();
    run
}

pub(crate) fn run(program: &Program, machine: &Machine) -> Run {
    run_with(program, machine, &[tool(1, 120.0), tool(2, 87.5)], &Settings::default())
}

/// A small deterministic source of random numbers (xorshift64*, Vigna 2016).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// Calls `check` for every seed, spread over the cores; a failed assertion in one fails the test.
pub(crate) fn for_all(seeds: std::ops::Range<u64>, check: impl Fn(u64) + Sync) {
    let next = std::sync::atomic::AtomicU64::new(seeds.start);
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    if seed >= seeds.end {
                        break;
                    }
                    check(seed);
                }
            });
        }
    });
}

/// Worst use of the limits over all samples, of the planner's own derivatives and of differences of the set
/// points.
#[derive(Debug, Default)]
pub(crate) struct Use {
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    /// Differences of neighboring samples: mean velocity, acceleration, jerk over a cycle.
    pub(crate) differences: [f64; 3],
}

pub(crate) fn limit_use(run: &Run, machine: &Machine, cycle: f64) -> Use {
    let mut worst = Use::default();
    for (i, joint) in machine.joints.iter().enumerate() {
        let limits = [joint.max_velocity, joint.max_acceleration, joint.max_jerk].map(|l| l.unwrap_or(f64::INFINITY));
        for s in &run.all.samples {
            worst.velocity = worst.velocity.max(s.velocity[i].abs() / limits[0]);
            worst.acceleration = worst.acceleration.max(s.acceleration[i].abs() / limits[1]);
            worst.jerk = worst.jerk.max(s.jerk[i].abs() / limits[2]);
        }
        for pair in run.all.samples.windows(2) {
            if pair[1].time - pair[0].time > 1.5 * cycle {
                continue; // a standstill
            }
            let rate = |f: &dyn Fn(&JointValues) -> f64, a: &JointValues, b: &JointValues| (f(b) - f(a)).abs() / cycle;
            let at = |q: &JointValues| q[i];
            let (a, b) = (&pair[0], &pair[1]);
            let d = [
                rate(&at, &a.commanded, &b.commanded),
                rate(&at, &a.velocity, &b.velocity),
                rate(&at, &a.acceleration, &b.acceleration),
            ];
            for k in 0..3 {
                worst.differences[k] = worst.differences[k].max(d[k] / limits[k]);
            }
        }
    }
    worst
}
