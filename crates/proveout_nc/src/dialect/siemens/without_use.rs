//! Words of a block that nothing in it uses: they are refused by name, like a word without a
//! meaning.
//!
//! Each kind of block uses the words of its own motion. A Sinumerik would raise an alarm on other
//! words or silently ignore them, such as AR= with TRANS or I with G4. A program with such words is
//! not read as intended.

use super::modal::Interpolation;
use super::pending::{FrameWord, Pending};
use super::run_state::Interpreter;
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// What a block does with its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BlockUse {
    /// G25, G26
    Limits,
    /// G110 to G112
    Pole,
    Dwell,
    /// G74, G75
    FixedPoint,
    /// TRANS, ROT, SCALE, MIRROR, G58, G59
    Frame(FrameWord),
    /// POS[ ]=
    Positioning,
    /// SUPA, G53, G153
    Machine,
    /// G0, G1, G63
    Straight,
    /// G2, G3
    Arc,
    /// CT
    Tangent,
    /// CIP
    Through,
    /// G33, G331, G332
    Thread,
    /// BSPLINE, CSPLINE, ASPLINE
    Spline,
    /// POLY
    Polynomial,
    /// No motion at all.
    Still,
}

impl BlockUse {
    fn name(self) -> String {
        match self {
            Self::Limits => "G25 and G26 take axes and S, and".to_owned(),
            Self::Pole => "a pole (G110, G111, G112) takes its coordinates, and".to_owned(),
            Self::Dwell => "G4 takes F or S, and".to_owned(),
            Self::FixedPoint => "G74 and G75 take axes, and".to_owned(),
            Self::Frame(word) => format!("`{}` takes axes, and", word.name()),
            _ => String::new(),
        }
    }
}

impl Interpreter {
    fn kind_of(&self, p: &Pending) -> BlockUse {
        let center = p.center.iter().any(Option::is_some);
        let polar = p.polar_angle.is_some() || p.polar_radius.is_some();
        let moves = p.has_axis() || p.has_orientation() || center || p.opening.is_some() || p.angle.is_some() || polar;
        if p.limits.is_some() {
            return BlockUse::Limits;
        }
        if p.pole.is_some() {
            return BlockUse::Pole;
        }
        if let Some((word, _)) = p.frame {
            return BlockUse::Frame(word);
        }
        if p.dwell {
            return BlockUse::Dwell;
        }
        if p.fixed_point.is_some() {
            return BlockUse::FixedPoint;
        }
        if !moves {
            return BlockUse::Still;
        }
        if p.positioning {
            return BlockUse::Positioning;
        }
        if p.machine {
            return BlockUse::Machine;
        }
        if p.tapping_feed {
            return BlockUse::Straight;
        }
        match self.modal.interpolation {
            Interpolation::Rapid | Interpolation::Linear => BlockUse::Straight,
            Interpolation::Clockwise | Interpolation::CounterClockwise => BlockUse::Arc,
            Interpolation::Tangential => BlockUse::Tangent,
            Interpolation::Intermediate => BlockUse::Through,
            Interpolation::Thread | Interpolation::TapIn | Interpolation::TapOut => BlockUse::Thread,
            Interpolation::Spline(_) => BlockUse::Spline,
            Interpolation::Polynomial => BlockUse::Polynomial,
        }
    }

    /// The first word of a block that nothing in it uses.
    pub(super) fn without_use(&self, p: &Pending, span: Span) -> Result<(), Fault> {
        let kind = self.kind_of(p);
        let path = matches!(kind, BlockUse::Straight | BlockUse::Arc | BlockUse::Tangent | BlockUse::Through);
        let more_path = path || matches!(kind, BlockUse::Thread | BlockUse::Spline | BlockUse::Polynomial);
        let own_block = matches!(kind, BlockUse::Limits | BlockUse::Pole);
        let [u, v, _] = self.modal.plane_axes();
        let in_plane = p.axes[u].is_some() || p.axes[v].is_some();
        let turned = matches!(kind, BlockUse::Frame(FrameWord::Rot | FrameWord::ARot));
        // For each word: whether the block has it, its description, and whether this block uses it.
        let frame = p.frame.is_some() || p.offset.is_some() || p.tool_frame.is_some() || p.transformation.is_some();
        let words: [(bool, &str, bool); 27] = [
            (
                p.turns.is_some(),
                "TURN=, which belongs to G2, G3 and CIP",
                matches!(kind, BlockUse::Arc | BlockUse::Through),
            ),
            (
                p.intermediate.iter().any(Option::is_some),
                "I1=, J1= or K1=, which belongs to CIP",
                kind == BlockUse::Through,
            ),
            (
                p.radius.is_some(),
                "CR=, which belongs to G2 and G3",
                // A straight block and a spline report it themselves.
                matches!(kind, BlockUse::Arc | BlockUse::Straight | BlockUse::Spline | BlockUse::Thread),
            ),
            (p.plane_angle.is_some(), "RPL=, which belongs to ROT and AROT", turned),
            (
                p.opening.is_some(),
                "AR=, which belongs to G2 and G3",
                matches!(kind, BlockUse::Arc | BlockUse::Straight | BlockUse::Spline | BlockUse::Thread),
            ),
            (
                p.opening.is_some() && p.has_center() && in_plane,
                "the end point next to AR= and the center, which already give the end",
                kind != BlockUse::Arc,
            ),
            (
                p.has_center(),
                "I, J or K, which belong to G2 and G3",
                !matches!(
                    kind,
                    BlockUse::Dwell | BlockUse::Tangent | BlockUse::Through | BlockUse::Limits | BlockUse::Pole
                ),
            ),
            (
                p.has_orientation(),
                "the tool vector",
                more_path
                    || matches!(
                        kind,
                        BlockUse::Frame(_) | BlockUse::FixedPoint | BlockUse::Positioning | BlockUse::Machine
                    ),
            ),
            (p.chamfer.is_some(), "CHF=, which belongs to a motion", more_path),
            (p.chamfer_leg.is_some(), "CHR=, which belongs to a motion", more_path),
            (p.corner_radius.is_some(), "RND=, which belongs to a motion", more_path),
            (p.weight.is_some(), "PW=, which belongs to BSPLINE", more_path && kind != BlockUse::Polynomial),
            (p.interval.is_some(), "PL=, which belongs to BSPLINE and POLY", more_path),
            (
                p.block_feed.is_some(),
                "FB=, the feed of one motion",
                more_path && !(kind == BlockUse::Straight && self.modal.interpolation == Interpolation::Rapid),
            ),
            (
                p.measure.is_some() || p.measure_on.is_some(),
                "MEAS= or MEAW=, which belongs to a straight motion in feed",
                kind == BlockUse::Straight,
            ),
            (p.angle.is_some(), "ANG=, which belongs to a straight motion", path || kind == BlockUse::Machine),
            (
                p.polar_angle.is_some() || p.polar_radius.is_some(),
                "AP= or RP=, which belongs to a motion or a pole",
                more_path || kind == BlockUse::Pole,
            ),
            (
                kind == BlockUse::Pole && p.polar_angle.is_some() && p.has_axis(),
                "the coordinate next to AP= and RP=, which already give the pole",
                false,
            ),
            (p.polynomial.iter().any(Option::is_some), "PO, which belongs to POLY", more_path),
            (frame, "the frame or transformation", !own_block),
            (
                p.machine || p.positioning || p.fixed_point.is_some() || p.dwell,
                "the word of another motion",
                !own_block,
            ),
            (
                p.corner_feed.is_some() || p.feed_override.is_some() || p.compensation.is_some(),
                "FRC=, OVR= or the compensation",
                !own_block,
            ),
            (p.feed.is_some(), "F", !own_block),
            (p.speed.is_some(), "S", kind != BlockUse::Pole),
            (p.tool.is_some() || p.edge.is_some(), "T or D", !own_block),
            (!p.functions.is_empty(), "M", !own_block),
            (p.call.is_some() || p.numbered_call.is_some() || p.passes.is_some(), "the call", !own_block),
        ];
        let Some((_, word, _)) = words.into_iter().find(|(stands, _, taken)| *stands && !taken) else {
            return Ok(());
        };
        let kind = kind.name();
        let message = if kind.is_empty() {
            format!("no word in this block takes {word}")
        } else {
            format!("{kind} no word in this block takes {word}")
        };
        Err(Fault::new(codes::CONFLICT, span, message).help("remove it, or write the word that it belongs to"))
    }

    /// Refuses I, J or K in addition to that of the thread.
    pub(super) fn second_pitch(p: &Pending, axis: usize, span: Span) -> Result<(), Fault> {
        let Some(other) = (0..3).find(|&other| other != axis && p.center[other].is_some()) else { return Ok(()) };
        let letter = ['I', 'J', 'K'][other];
        Err(Fault::new(
            codes::CONFLICT,
            span,
            format!("`{letter}` is the pitch along another axis than that of the thread"),
        )
        .help(format!("write the pitch with {} alone", ['I', 'J', 'K'][axis])))
    }
}
