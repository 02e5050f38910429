//! The lines of Lu, Yang and Zhao 2022 (doi:10.21203/rs.3.rs-1213345/v1) near the leading edge of the
//! substitute blade, on both machines of the paper, with the other kinds of path: what each asks of the
//! rotary joints, whatever its blocks are.
//!
//! ```text
//! cargo run -p proveout_path --example lu_lines
//! ```
//!
//! Contacts lie 0.05 mm apart (0.01 mm where a line turns round an edge) and the tool lies along the
//! normal. `deg/mm` is the largest rate of the joint that turns about the span (B of machine II, C of machine
//! I) for each mm of the contact's path, `range` its largest range on one line, `deg/s` its velocity at 500
//! mm/min, `feed` the lowest feed that 30 deg/s allow.

#![allow(clippy::print_stdout, reason = "a study prints its table")]

use std::error::Error;
use std::path::Path;

use proveout_blade::{ClosedSurface, Lu, ParametricSurface};
use proveout_geom::{Pose, Vector, rad};
use proveout_machine::Machine;
use proveout_path::{
    AxisRule, ConstantScallop, IsoParametric, IsoPlanar, Label, PathCutter, Pocket, QuasiCircle, Setting, Spacing,
    StepRule, Strategy, Task, Transverse,
};
use proveout_tool::Cutter;

type Fault = Box<dyn Error>;

/// A machine with the joint about the span, and the blade on its table: span along z for machine I, along y
/// for machine II.
fn machines() -> Result<Vec<(&'static str, Machine, Pose)>, Fault> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let upright = Pose::from_axis_angle(&Vector::y(), rad(-90.0));
    let lying = Pose::from_axis_angle(&Vector::z(), rad(90.0)) * Pose::from_axis_angle(&Vector::x(), rad(90.0));
    let mut all = Vec::new();
    for (name, joint, pose) in [("lu-hybrid-ii", "B", lying), ("lu-serial-i", "C", upright)] {
        let mut machine = Machine::read(&folder.join(name))?;
        // The travel of the library machines is chosen; the study is about the rotary joints.
        for j in &mut machine.joints {
            if !j.is_rotary() {
                j.travel = None;
            }
        }
        all.push((joint, machine, pose));
    }
    Ok(all)
}

fn row(name: &str, lu: &dyn ParametricSurface, strategy: &dyn Strategy) -> Result<(), Fault> {
    row_by(name, lu, strategy, 0.05)
}

/// `step`: distance of the contacts, mm.
fn row_by(name: &str, lu: &dyn ParametricSurface, strategy: &dyn Strategy, step: f64) -> Result<(), Fault> {
    let flutes = Cutter::ball(0.1)?.bodies(5.0)?;
    let cutter = PathCutter::new(flutes.into_iter().next().ok_or("a cutter has flutes")?);
    let rule = AxisRule::Normal;
    let task = Task { surface: lu, cutter: &cutter, rule: &rule, step: StepRule::Length(step), allowance: 0.0 };
    let lines = task.plan(strategy)?;
    print!("{name:<46} {:>5}", lines.len());
    for (joint, machine, pose) in machines()? {
        let (domain, feed) = (lu.domain(), 500.0 / 60.0);
        let setting = Setting { machine: &machine, table_from_surface: pose, tool_length: 0.0, domain, feed };
        let judged = setting.judge(&lines, &machine.home())?;
        let index = machine.joint(joint).ok_or("the machine has the joint")?;
        let demand = judged.joints.get(index).ok_or("every joint is judged")?;
        let rate = demand.rate.as_ref().map_or(0.0, |r| r.value.to_degrees());
        let range = judged.positions.iter().map(|q| {
            let most = q.iter().map(|q| q[index]).fold(f64::MIN, f64::max);
            most - q.iter().map(|q| q[index]).fold(f64::MAX, f64::min)
        });
        let range = range.fold(0.0, f64::max).to_degrees();
        print!(" | {rate:>9.3} {range:>8.2} {:>9.2} {:>8.3}", rate * 500.0 / 60.0, 30.0 / rate);
    }
    println!();
    Ok(())
}

fn iso(values: &[f64]) -> IsoParametric {
    let spacing = Spacing::At(values.to_vec());
    IsoParametric { label: Label::Length, range: [0.0, 1.0], along: [0.0, 1.0], spacing }
}

fn quasi(degrees: &[f64]) -> QuasiCircle {
    let spacing = Spacing::At(degrees.iter().map(|d| rad(*d)).collect());
    QuasiCircle { focus_inside: 0.0, trailing: 0.0, range: [0.0, rad(360.0)], along: [0.0, 1.0], spacing }
}

fn main() -> Result<(), Fault> {
    println!("{:<46} {:>5} | {:^37} | {:^37}", "", "", "machine II, B", "machine I, C");
    print!("{:<46} {:>5}", "lines", "count");
    for _ in 0..2 {
        print!(" | {:>9} {:>8} {:>9} {:>8}", "deg/mm", "range", "deg/s", "feed");
    }
    println!();
    let (twisted, straight) = (ClosedSurface::new(Lu::stand_in()), ClosedSurface::new(Lu::untwisted()));
    let suprema =
        |from: f64, step: f64, count: i32| (0..=count).map(|k| from + step * f64::from(k)).collect::<Vec<f64>>();
    row("iso-parametric u .505 .510 .515", &twisted, &iso(&[0.505, 0.510, 0.515]))?;
    row("quasi-circle 175 180 185 deg", &twisted, &quasi(&[175.0, 180.0, 185.0]))?;
    row("iso-parametric, all from .5034 to .5058", &twisted, &iso(&suprema(0.5034, 0.0001, 24)))?;
    row("quasi-circle, all from 182 to 186 deg", &twisted, &quasi(&suprema(182.0, 0.25, 16)))?;
    row("untwisted: iso-parametric u .505 .510 .515", &straight, &iso(&[0.505, 0.510, 0.515]))?;
    row("untwisted: quasi-circle 175 180 185 deg", &straight, &quasi(&[175.0, 180.0, 185.0]))?;
    // Planes along the span, across the mean chord (stagger 35 degrees); the second one cuts the leading
    // edge.
    let normal = Vector::new(0.0, rad(35.0).cos(), rad(35.0).sin());
    for (name, at) in [("iso-planar beside the edge, -13 mm", -13.0), ("iso-planar through the edge, -17 mm", -17.0)] {
        let (range, spacing) = ([at, at], Spacing::At(vec![at]));
        row_by(name, &twisted, &IsoPlanar { normal, range, round: [0.0, 1.0], along: [0.0, 1.0], spacing }, 0.01)?;
    }
    let spacing = Spacing::At(vec![0.25, 0.5, 0.75]);
    row_by(
        "transverse, half the section, v .25 .5 .75",
        &twisted,
        &Transverse { round: [0.25, 0.75], range: [0.0, 1.0], spacing, one_way: false },
        0.01,
    )?;
    let spacing = Spacing::At(vec![0.0, 0.1, 0.2]);
    row_by(
        "pocket round the edge, three rings",
        &twisted,
        &Pocket { round: [0.4, 0.6], along: [0.0, 1.0], spacing, outwards: false },
        0.01,
    )?;
    row(
        "constant scallop 1 um, D0.1, on the convex side",
        &twisted,
        &ConstantScallop { range: [0.3, 0.303], along: [0.0, 1.0], scallop: 1e-3 },
    )?;
    Ok(())
}
