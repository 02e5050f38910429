//! The G words of each control: their modal group, what is only noted, what is refused.
//!
//! Codes are ten times the number of the word: `G38.2` is 382.
//!
//! Sources: Fanuc, *Series 30i operator's manual* (B-64484EN), list of G codes; Haas, *Mill operator's
//! manual, NGC*, G codes; `LinuxCNC`, *G-code reference*, modal groups.

use super::flavor::Flavor;
use crate::control::Control;

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
pub(crate) fn class(flavor: Flavor, assumed: bool, control: &Control, code: u32) -> GWordClass {
    match code {
        // A Fagor: absolute centers, pole, cycles of its own.
        60 | 930 if control.depth_in_i => GWordClass::Known(Group::OneShot),
        690 | 870 | 880 if control.depth_in_i => GWordClass::Known(Group::Cycle),
        700 | 710 if assumed || flavor.is_linuxcnc() && control.name.is_empty() => GWordClass::Known(Group::Units),
        611 if assumed || flavor == Flavor::Fanuc && control.name.is_empty() => GWordClass::Known(Group::PathMode),
        _ => classify(flavor, code),
    }
}

/// The class of a G word.
pub(crate) fn classify(flavor: Flavor, code: u32) -> GWordClass {
    let common = match code {
        0 | 10 | 20 | 30 => Some(Group::Motion),
        40 | 100 | 280 | 300 | 520 | 530 | 920 => Some(Group::OneShot),
        170 | 180 | 190 => Some(Group::Plane),
        200 | 210 => Some(Group::Units),
        400 | 410 | 420 => Some(Group::CutterComp),
        430 | 490 => Some(Group::ToolLength),
        540 | 550 | 560 | 570 | 580 | 590 => Some(Group::WorkOffset),
        610 | 640 => Some(Group::PathMode),
        730 | 740 | 800..=870 | 880 | 890 if code.is_multiple_of(10) => Some(cycle_group(flavor)),
        900 | 910 => Some(Group::Distance),
        930 | 940 | 950 => Some(Group::FeedMode),
        960 | 970 => Some(Group::SpindleMode),
        980 | 990 => Some(Group::Return),
        _ => None,
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

/// On a `LinuxCNC` the cycles and G80 are in the group of G0 and G1.
fn cycle_group(flavor: Flavor) -> Group {
    if flavor.is_linuxcnc() { Group::Motion } else { Group::Cycle }
}

/// Words of turning on the controls that speak this language.
pub(super) const TURNING: &str = "it is a turning cycle, which the twin does not support";
const ARC: &str = "program the path with G1, G2 and G3";
const MANUAL_RETRACT: &str = "the operator retracts by hand in this cycle; use G85, G86 or G89";
const POST_PLANE: &str = "give the plane with Euler angles (G68.2 X Y Z I J K) or turn the axes in the program";

fn fanuc(code: u32) -> GWordClass {
    match code {
        90 => GWordClass::Known(Group::ExactStop),
        50 | 51 | 310 | 531 | 536 | 650 | 921 => GWordClass::Known(Group::OneShot),
        330 => GWordClass::Known(Group::Motion),
        150 | 160 => GWordClass::Known(Group::Polar),
        434 | 435 | 440 => GWordClass::Known(Group::ToolLength),
        501 | 511 => GWordClass::Known(Group::Mirror),
        541 => GWordClass::Known(Group::WorkOffset),
        620 | 630 => GWordClass::Known(Group::PathMode),
        660 | 670 => GWordClass::Known(Group::Macro),
        680 | 682 | 690 => GWordClass::Known(Group::Rotation),
        760 => GWordClass::Known(Group::Cycle),
        80 | 110 | 131 | 220 | 230 | 250 | 260 | 401 | 500 | 502 | 691 | 1130 => GWordClass::Note,
        431 => GWordClass::Refused("program five axes with G43.4 or G43.5, three with G43"),
        684 | 683 => GWordClass::Refused(POST_PLANE),
        61 | 62 => GWordClass::Refused(ARC),
        24 | 34 | 23 | 33 | 32 => GWordClass::Refused(ARC),
        71 | 121 | 271 | 70 | 120 => GWordClass::Refused("unroll the path in the CAM system"),
        700 | 710 | 720 | 750 => GWordClass::Refused(TURNING),
        411 | 421 | 412 | 422 => GWordClass::Refused("let the CAM system compensate the cutter, and use G40"),
        270 | 600 => GWordClass::Known(Group::OneShot),
        290 => GWordClass::Refused("program the motion with G53 or in work coordinates"),
        510 => GWordClass::Known(Group::Scaling),
        512 | 544 | 436 => GWordClass::Refused("remove the function for the prove-out"),
        661 => GWordClass::Refused("call the macro with G65"),
        106 | 751 | 753 => GWordClass::Refused("remove the function for the prove-out"),
        542 => GWordClass::Refused(
            "the offset that turns with the table is data of the control: use G68.2, or give each position its own offset (G55)",
        ),
        842 | 843 => GWordClass::Refused("write M29 S and G84 or G74"),
        880 => GWordClass::Refused(MANUAL_RETRACT),
        _ => GWordClass::Unknown,
    }
}

fn haas(code: u32) -> GWordClass {
    match code {
        90 => GWordClass::Known(Group::ExactStop),
        310 | 650 => GWordClass::Known(Group::OneShot),
        440 | 2340 => GWordClass::Known(Group::ToolLength),
        680 | 690 | 2680 | 2690 => GWordClass::Known(Group::Rotation),
        2530 => GWordClass::Known(Group::OneShot),
        760 | 770 => GWordClass::Known(Group::Cycle),
        1000 | 1010 => GWordClass::Known(Group::Mirror),
        1540 => GWordClass::Known(Group::WorkOffset),
        1100..=1290 if code.is_multiple_of(10) => GWordClass::Known(Group::WorkOffset),
        2540 | 2550 => GWordClass::Known(Group::DynamicOffset),
        500 | 510 => GWordClass::Known(Group::Scaling),
        1030 => GWordClass::Note,
        1870 => GWordClass::Known(Group::PathMode),
        120 | 130 => GWordClass::Known(Group::OneShot),
        1500 | 470 => GWordClass::Refused("program the pocket or text with G1, G2 and G3"),
        290 => GWordClass::Refused("program the motion with G53 or in work coordinates"),
        350 | 360 | 370 | 1360 => {
            GWordClass::Refused("measured values are not known to the twin; write the offset with G10")
        }
        600 => GWordClass::Refused("program the approach from one side with G0"),
        700 | 710 => GWordClass::Known(Group::OneShot),
        720 => GWordClass::Refused(
            "the manual does not say whether the first hole is at the current tool position: program the holes with X \
             and Y",
        ),
        870 | 880 => GWordClass::Refused(MANUAL_RETRACT),
        1020 => GWordClass::Refused("remove the output to the serial port"),
        1070 => GWordClass::Refused("unroll the path in the CAM system"),
        1410 | 1430 => GWordClass::Refused("let the CAM system compensate the cutter; use G234 for the tool length"),
        1740 | 1840 => GWordClass::Refused("tap along the axis of the plane with G84 or G74"),
        2660 | 2670 => GWordClass::Refused("turn the axes in the program and use G254"),
        _ => GWordClass::Unknown,
    }
}

fn linuxcnc(code: u32) -> GWordClass {
    match code {
        50 | 51 | 330 | 331 | 382..=385 => GWordClass::Known(Group::Motion),
        921..=923 | 281 | 301 => GWordClass::Known(Group::OneShot),
        171 | 181 | 191 => GWordClass::Refused("use G17, G18 or G19"),
        411 | 421 => GWordClass::Known(Group::CutterComp),
        431 | 432 => GWordClass::Known(Group::ToolLength),
        591..=593 => GWordClass::Known(Group::WorkOffset),
        611 => GWordClass::Known(Group::PathMode),
        901 | 911 => GWordClass::Known(Group::ArcDistance),
        80 => GWordClass::Note,
        70 => GWordClass::Refused("diameter programming belongs to turning"),
        52 | 53 => GWordClass::Known(Group::Motion),
        700 | 760 | 710..=722 | 842 | 881 => GWordClass::Refused(TURNING),
        870 | 880 => GWordClass::Refused("the control does not do this cycle; use G85, G86 or G89"),
        960 | 970 => GWordClass::Known(Group::SpindleMode),
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
