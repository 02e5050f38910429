//! The G words of each control: their modal group, what is only noted, what is refused.
//!
//! Sources: Fanuc, *Series 30i operator's manual* (B-64484EN), list of G codes; Haas, *Mill operator's
//! manual, NGC*, G codes; `LinuxCNC`, *G-code reference*, modal groups.

use super::flavor::Flavor;
use crate::control::Control;
use crate::cycle::iso::{self, CycleSet};
use crate::g_code::*;

/// Words of one group exclude each other in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    /// Acts in its block only.
    OneShot,
    /// G9: goes with everything.
    ExactStop,
    Motion,
    Cycle,
    Plane,
    Distance,
    ArcDistance,
    FeedMode,
    Units,
    CutterComp,
    ToolLength,
    Return,
    WorkOffset,
    PathMode,
    SpindleMode,
    Polar,
    Rotation,
    Mirror,
    Scaling,
    Macro,
    DynamicOffset,
}

/// What the reader does with a G word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GWordClass {
    Known(Group),
    /// Named in a note, without effect.
    Note,
    /// With the remedy.
    Refused(&'static str),
    Unknown,
}

/// The class of a G word; `assumed`: nothing shows that the control is this one. There G70 and G71
/// are the unit of lengths, as on most controls that are no Fanuc, Haas or `LinuxCNC`. G61.1 is a
/// word of the path where no control file is named: of the controls that speak this language only a
/// Fanuc has none. A `LinuxCNC` that no control file names may be a Mach3, whose words of its own
/// are these.
pub(crate) fn class(flavor: Flavor, assumed: bool, control: &Control, code: GCode) -> GWordClass {
    match code {
        // A Fagor: absolute centers, pole, cycles of its own.
        G6 | G93 if control.depth_in_i => GWordClass::Known(Group::OneShot),
        _ if control.depth_in_i && iso::FAGOR.spec(code).is_some() => GWordClass::Known(Group::Cycle),
        G70 | G71 if assumed || flavor.is_linuxcnc() && control.is_open() => GWordClass::Known(Group::Units),
        G61_1 if assumed || flavor == Flavor::Fanuc && control.is_open() => GWordClass::Known(Group::PathMode),
        _ => classify(flavor, code),
    }
}

/// The class of a G word.
pub(crate) fn classify(flavor: Flavor, code: GCode) -> GWordClass {
    let common = match code {
        G0 | G1 | G2 | G3 => Some(Group::Motion),
        G4 | G10 | G28 | G30 | G52 | G53 | G92 => Some(Group::OneShot),
        G17 | G18 | G19 => Some(Group::Plane),
        G20 | G21 => Some(Group::Units),
        G40 | G41 | G42 => Some(Group::CutterComp),
        G43 | G49 => Some(Group::ToolLength),
        G54 | G55 | G56 | G57 | G58 | G59 => Some(Group::WorkOffset),
        G61 | G64 => Some(Group::PathMode),
        G80 => Some(cycle_group(flavor)),
        G90 | G91 => Some(Group::Distance),
        G93 | G94 | G95 => Some(Group::FeedMode),
        G96 | G97 => Some(Group::SpindleMode),
        G98 | G99 => Some(Group::Return),
        _ => cycles(flavor).spec(code).map(|_| cycle_group(flavor)),
    };
    let own = match flavor {
        Flavor::Fanuc => fanuc(code),
        Flavor::Haas => haas(code),
        Flavor::LinuxCnc => linuxcnc(code),
    };
    match (own, common) {
        (GWordClass::Unknown, Some(group)) => GWordClass::Known(group),
        (own, _) => own,
    }
}

/// The cycles of a flavor.
fn cycles(flavor: Flavor) -> &'static CycleSet {
    match flavor {
        Flavor::Fanuc => &iso::FANUC,
        Flavor::Haas => &iso::HAAS,
        Flavor::LinuxCnc => &iso::LINUXCNC,
    }
}

/// The cycles of a control.
pub(super) fn cycles_of(flavor: Flavor, control: &Control) -> &'static CycleSet {
    match flavor {
        _ if control.depth_in_i => &iso::FAGOR,
        Flavor::Fanuc if control.stated_returns => &iso::OKUMA,
        Flavor::LinuxCnc if control.mach3_words => &iso::MACH3,
        _ => cycles(flavor),
    }
}

/// On a `LinuxCNC` the cycles and G80 are in the group of G0 and G1.
fn cycle_group(flavor: Flavor) -> Group {
    if flavor.is_linuxcnc() { Group::Motion } else { Group::Cycle }
}

/// Words of turning on the controls that speak this language.
pub(super) const TURNING: &str = "it is a turning cycle, which the twin does not support";
const ARC: &str = "program the path with G1, G2 and G3";
const MANUAL_RETRACT: &str = "the operator retracts by hand in this cycle; use G85, G86 or G89";
const POST_PLANE: &str = "give the plane with Euler angles (G68.2 X Y Z I J K) or turn the axes in the program";

fn fanuc(code: GCode) -> GWordClass {
    match code {
        G9 => GWordClass::Known(Group::ExactStop),
        G5 | G5_1 | G31 | G53_1 | G53_6 | G65 | G92_1 => GWordClass::Known(Group::OneShot),
        G33 => GWordClass::Known(Group::Motion),
        G15 | G16 => GWordClass::Known(Group::Polar),
        G43_4 | G43_5 | G44 => GWordClass::Known(Group::ToolLength),
        G50_1 | G51_1 => GWordClass::Known(Group::Mirror),
        G54_1 => GWordClass::Known(Group::WorkOffset),
        G62 | G63 => GWordClass::Known(Group::PathMode),
        G66 | G67 => GWordClass::Known(Group::Macro),
        G68 | G68_2 | G69 => GWordClass::Known(Group::Rotation),
        G8 | G11 | G13_1 | G22 | G23 | G25 | G26 | G40_1 | G50 | G50_2 | G69_1 | G113 => GWordClass::Note,
        G43_1 => GWordClass::Refused("program five axes with G43.4 or G43.5, three with G43"),
        G68_4 | G68_3 => GWordClass::Refused(POST_PLANE),
        G6_1 | G6_2 => GWordClass::Refused(ARC),
        G2_4 | G3_4 | G2_3 | G3_3 | G3_2 => GWordClass::Refused(ARC),
        G7_1 | G12_1 | G27_1 | G7 | G12 => GWordClass::Refused("unroll the path in the CAM system"),
        G70 | G71 | G72 | G75 => GWordClass::Refused(TURNING),
        G41_1 | G42_1 | G41_2 | G42_2 => GWordClass::Refused("let the CAM system compensate the cutter, and use G40"),
        G27 | G60 => GWordClass::Known(Group::OneShot),
        G29 => GWordClass::Refused("program the motion with G53 or in work coordinates"),
        G51 => GWordClass::Known(Group::Scaling),
        G51_2 | G54_4 | G43_6 => GWordClass::Refused("remove the function for the prove-out"),
        G66_1 => GWordClass::Refused("call the macro with G65"),
        G10_6 | G75_1 | G75_3 => GWordClass::Refused("remove the function for the prove-out"),
        G54_2 => GWordClass::Refused(
            "the offset that turns with the table is data of the control: use G68.2, or give each position its own offset (G55)",
        ),
        G84_2 | G84_3 => GWordClass::Refused("write M29 S and G84 or G74"),
        G88 => GWordClass::Refused(MANUAL_RETRACT),
        _ => GWordClass::Unknown,
    }
}

fn haas(code: GCode) -> GWordClass {
    match code {
        G9 => GWordClass::Known(Group::ExactStop),
        G31 | G65 => GWordClass::Known(Group::OneShot),
        G44 | G234 => GWordClass::Known(Group::ToolLength),
        G68 | G69 | G268 | G269 => GWordClass::Known(Group::Rotation),
        G253 => GWordClass::Known(Group::OneShot),
        G100 | G101 => GWordClass::Known(Group::Mirror),
        G154 => GWordClass::Known(Group::WorkOffset),
        GCode(110..=129, 0) => GWordClass::Known(Group::WorkOffset),
        G254 | G255 => GWordClass::Known(Group::DynamicOffset),
        G50 | G51 => GWordClass::Known(Group::Scaling),
        G103 => GWordClass::Note,
        G187 => GWordClass::Known(Group::PathMode),
        G12 | G13 => GWordClass::Known(Group::OneShot),
        G150 | G47 => GWordClass::Refused("program the pocket or text with G1, G2 and G3"),
        G29 => GWordClass::Refused("program the motion with G53 or in work coordinates"),
        G35 | G36 | G37 | G136 => {
            GWordClass::Refused("measured values are not known to the twin; write the offset with G10")
        }
        G60 => GWordClass::Refused("program the approach from one side with G0"),
        G70 | G71 => GWordClass::Known(Group::OneShot),
        G72 => GWordClass::Refused(
            "the manual does not say whether the first hole is at the current tool position: program the holes with X \
             and Y",
        ),
        G87 | G88 => GWordClass::Refused(MANUAL_RETRACT),
        G102 => GWordClass::Refused("remove the output to the serial port"),
        G107 => GWordClass::Refused("unroll the path in the CAM system"),
        G141 | G143 => GWordClass::Refused("let the CAM system compensate the cutter; use G234 for the tool length"),
        G174 | G184 => GWordClass::Refused("tap along the axis of the plane with G84 or G74"),
        G266 | G267 => GWordClass::Refused("turn the axes in the program and use G254"),
        _ => GWordClass::Unknown,
    }
}

fn linuxcnc(code: GCode) -> GWordClass {
    match code {
        G5 | G5_1 | G33 | G33_1 | GCode(38, 2..=5) => GWordClass::Known(Group::Motion),
        GCode(92, 1..=3) | G28_1 | G30_1 => GWordClass::Known(Group::OneShot),
        G17_1 | G18_1 | G19_1 => GWordClass::Refused("use G17, G18 or G19"),
        G41_1 | G42_1 => GWordClass::Known(Group::CutterComp),
        G43_1 | G43_2 => GWordClass::Known(Group::ToolLength),
        GCode(59, 1..=3) => GWordClass::Known(Group::WorkOffset),
        G61_1 => GWordClass::Known(Group::PathMode),
        G90_1 | G91_1 => GWordClass::Known(Group::ArcDistance),
        G8 => GWordClass::Note,
        G7 => GWordClass::Refused("diameter programming belongs to turning"),
        G5_2 | G5_3 => GWordClass::Known(Group::Motion),
        G70 | GCode(71, _) | GCode(72, 0..=2) | G76 | G84_2 | G88_1 => GWordClass::Refused(TURNING),
        G87 | G88 => GWordClass::Refused("the control does not do this cycle; use G85, G86 or G89"),
        G96 | G97 => GWordClass::Known(Group::SpindleMode),
        _ => GWordClass::Unknown,
    }
}

/// M words that exclude each other in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Stop,
    Spindle,
    ToolChange,
    CoolantOn,
    CoolantOff,
    Override,
    Orient,
    Call,
    Rigid,
    /// State of the interpreter of `LinuxCNC`.
    State,
    /// Function of the machine builder or without effect on the twin.
    Note,
    /// Switches the kinematics of the control.
    Kinematics,
    /// Analog output of `LinuxCNC`, one of which may switch the kinematics.
    AnalogOutput,
    Refused(&'static str),
}

/// The class of an M word.
pub(crate) fn function(flavor: Flavor, code: u32) -> Function {
    match code {
        0 | 1 | 2 | 30 => Function::Stop,
        3..=5 => Function::Spindle,
        6 => Function::ToolChange,
        7 | 8 => Function::CoolantOn,
        9 => Function::CoolantOff,
        19 => Function::Orient,
        29 if flavor == Flavor::Fanuc => Function::Rigid,
        48 | 49 if flavor != Flavor::Haas => Function::Override,
        60 if flavor.is_linuxcnc() => Function::Stop,
        61 | 70 | 72 if flavor.is_linuxcnc() => Function::State,
        66 if flavor.is_linuxcnc() => Function::Refused("the input is not known to the twin; remove the block"),
        71 | 73 if flavor.is_linuxcnc() => Function::Refused("use M70 and M72"),
        67 | 68 if flavor.is_linuxcnc() => Function::AnalogOutput,
        // M428 to M430: `LinuxCNC`, *Switchable kinematics*, and the configurations that come with it; M128,
        // M129: those before it, TCPM of a Hurco and of a TNC. On a Haas M121 to M128 set an output for the
        // user.
        129 | 428..=430 => Function::Kinematics,
        128 if flavor != Flavor::Haas => Function::Kinematics,
        97 if flavor == Flavor::Haas => Function::Call,
        96 | 109 if flavor == Flavor::Haas => Function::Refused("the input is not known to the twin; remove the block"),
        95 if flavor == Flavor::Haas => Function::Refused("remove the waiting time, or program it with G4"),
        98 | 99 => Function::Call,
        198 if flavor != Flavor::LinuxCnc => Function::Call,
        _ => Function::Note,
    }
}
