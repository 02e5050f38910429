//! Random machines and numbers for the laws; the same ones in every run.

use std::path::Path;

use proveout_geom::Vector;
use proveout_machine::{JointValues, Machine};

/// `SplitMix64` (Steele, Lea and Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub(crate) fn unit(&mut self) -> Vector {
        loop {
            let v = Vector::from_fn(|_, _| self.range(-1.0, 1.0));
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }
}

/// Ends of a machine file that every machine needs.
pub(crate) fn rest(spindle: &str, table: &str, up: Vector) -> String {
    format!(
        "[spindle]\non = {spindle:?}\norigin_mm = [0, 0, 0]\ndirection = [{:?}, {:?}, {:?}]\nstart_time_s = 1\n\
         [table]\non = {table:?}\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [control]\ncycle_time_ms = 1\nblock_time_ms = 1\ntool_change_time_s = 5\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.01\n",
        up.x, up.y, up.z
    )
}

/// A machine with five joints in any order on either side, skew slides and skew rotary axes.
///
/// Kept away from degenerate builds: slides span at least a fifth of a cube, the angles between the first
/// rotary axis, the second one and the tool are 20 degrees or more from zero and from a half turn.
pub(crate) fn random_machine(random: &mut Random) -> Machine {
    let slides = loop {
        let s = [random.unit(), random.unit(), random.unit()];
        if s[0].cross(&s[1]).dot(&s[2]).abs() > 0.2 {
            break s;
        }
    };
    let apart = |a: &Vector, b: &Vector| a.cross(b).norm() > 0.34;
    let (axes, up) = loop {
        let (a, b, up) = (random.unit(), random.unit(), random.unit());
        // Either order along the chain may come out, so both axes must be able to tilt the tool.
        if apart(&a, &b) && apart(&b, &up) && apart(&a, &up) {
            break ([a, b], up);
        }
    };
    let mut order: Vec<usize> = (0..5).collect();
    for i in (1..5).rev() {
        order.swap(i, random.below(i + 1));
    }
    let tool_side = random.below(6);
    let mut text = "name = \"random\"\n".to_owned();
    let mut ends = ["base".to_owned(), "base".to_owned()];
    for (place, &kind) in order.iter().enumerate() {
        let side = usize::from(place >= tool_side);
        let carries = ["tool", "workpiece"][side];
        let name = ["X", "Y", "Z", "A", "C"][kind];
        let sense = if random.below(2) == 0 { 1 } else { -1 };
        let d = if kind < 3 { slides[kind] } else { axes[kind - 3] };
        text += &format!(
            "[[joint]]\nname = {name:?}\ncarries = {carries:?}\nparent = {:?}\nsense = {sense}\n\
             direction = [{:?}, {:?}, {:?}]\n",
            ends[side], d.x, d.y, d.z
        );
        if kind < 3 {
            text += "kind = \"linear\"\n";
        } else {
            let p: [f64; 3] = std::array::from_fn(|_| random.range(-300.0, 300.0));
            text += &format!("kind = \"rotary\"\npoint_mm = {p:?}\n");
        }
        ends[side] = name.to_owned();
    }
    text += &rest(&ends[0], &ends[1], up);
    Machine::from_text(Path::new("random.toml"), &text).expect("a random machine is right")
}

/// Slides within half a meter, turns within a turn.
pub(crate) fn random_joints(machine: &Machine, random: &mut Random) -> JointValues {
    let mut q = JointValues::ZERO;
    for (j, joint) in machine.joints.iter().enumerate() {
        q[j] = if joint.is_rotary() {
            random.range(-std::f64::consts::PI, std::f64::consts::PI)
        } else {
            random.range(-500.0, 500.0)
        };
    }
    q
}

/// A count, or the one of the environment variable `PROVEOUT_MACHINE_LAWS` times it: 10 for a long run.
pub(crate) fn count(usual: usize) -> usize {
    let factor = std::env::var("PROVEOUT_MACHINE_LAWS").ok().and_then(|t| t.parse::<usize>().ok());
    usual * factor.unwrap_or(1)
}
