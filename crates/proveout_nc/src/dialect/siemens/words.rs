//! Words of the 840D language that need no code of their own: read with a note, or refused with the remedy.

/// How a word is treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// Read, named in a note, without effect on the twin.
    Note,
    /// Read and not executed; another setting of the twin may make up for it: reported as an
    /// assumption.
    Assumed(&'static str),
    /// Known on the control and not executed here.
    Refused(&'static str),
    Unknown,
}

const PLAIN: &str = "program the path with G0, G1, G2, G3";
const FRAME: &str = "program the frame with TRANS, ROT, SCALE, MIRROR";
const ONE_CHANNEL: &str = "the twin runs one channel; remove the word";

/// Words without value and words with arguments.
pub(crate) fn classify_name(name: &str) -> Class {
    match name {
        // Feed profile, acceleration behavior, compressors: the controller of the twin has its own.
        "FNORM" | "FLIN" | "FCUB" | "FFWON" | "FFWOF" | "SOFT" | "BRISK" | "DRIVE" | "SOFTA" | "BRISKA" | "DRIVEA"
        | "COMPOF" | "COMPON" | "COMPCURV" | "COMPCAD" | "COMPSURF" | "DYNNORM" | "DYNPOS" | "DYNROUGH"
        | "DYNSEMIFIN" | "DYNFINISH" | "DYNPREC" | "OSOF" | "OSS" | "OSSE" | "OSD" | "OST" | "OSC" | "UPATH"
        | "SPATH" | "CPRECON" | "CPRECOF" | "RTLION" | "ORISON" | "ORISOF" => Class::Note,
        "RTLIOF" => Class::Assumed(
            "after RTLIOF each axis runs its rapids at its own speed; the twin runs them as the machine file says \
             (rapid_mode)",
        ),
        // Run-in of the control, displays, groups of the editor, preset axes of grouping.
        "STOPRE" | "STARTFIFO" | "STOPFIFO" | "FIFOCTRL" | "WALIMON" | "WALIMOF" | "DIAMOF" | "DISPLON" | "DISPLOF"
        | "SBLOF" | "SBLON" | "ACTBLOCNO" | "GROUP_BEGIN" | "GROUP_ADDEND" | "GROUP_END" | "WORKPIECE" | "FGROUP"
        | "SETMS" | "SPOF" | "PAROTOF" | "TCOFR" | "ROTOF" | "GETD" | "GET" | "RELEASE" | "SETAL" | "PTPOF" | "CP"
        | "LFOF" | "LFON" | "GEOAXRESET" | "PRESETONOF" | "NCCHECK" | "PREPRO" | "ORIPATHSOF" | "MEASOF" | "G290"
        | "SUPD" | "PROTD" | "WAITENC" => Class::Note,
        "INVCW" | "INVCCW" | "POLYPATH" | "CPT" => Class::Refused(PLAIN),
        "ROTS" | "AROTS" | "CROTS" | "TOFRAMEX" | "TOFRAMEY" | "TOROTX" | "TOROTY" | "PAROT" | "MEAFRAME"
        | "PRESETON" | "SETPAL" => Class::Refused(FRAME),
        "ORIRPY2" => Class::Refused("write ORIRPY or ORIEULER with its angles, or a tool vector A3= B3= C3="),
        "ORIPATH" | "ORIPATHS" | "ORIROTA" | "ORIROTR" | "ORIROTT" | "ORIROTC" | "ORIPLANE_POLY" | "ORICURVE"
        | "ORICONCW" | "ORICONCCW" | "ORICONIO" | "ORICONTO" | "ORIVIRT1" | "ORIVIRT2" => {
            Class::Refused("program the orientation with rotary axes or with A3= B3= C3= and ORIAXES or ORIVECT")
        }
        "TRANSMIT" | "TRACYL" | "TRAANG" | "TRACON" => Class::Refused("the twin knows TRAORI and TRAFOOF"),
        "WAITM" | "WAITMC" | "WAITE" | "WAITP" | "SETM" | "CLEARM" => Class::Note,
        "INIT" | "START" | "COUPON" | "COUPOF" | "COUPDEF" | "TRAILON" | "TRAILOF" | "LEADON" | "LEADOF" => {
            Class::Refused(ONE_CHANNEL)
        }
        "CYCLE83_EXT" | "CYCLE435" | "CYCLE495" => {
            Class::Refused("drilling cycles done here are CYCLE81 to CYCLE89 and CYCLE840")
        }
        "CYCLE73" | "CYCLE74" | "CYCLE75" | "CYCLE63" | "CYCLE64" => Class::Refused(
            "the path that the control clears a contour pocket on is not published; let the CAM system write the motions",
        ),
        "CYCLE90" | "CYCLE78" => Class::Refused("write the helix of the thread as G2 or G3 with TURN="),
        "POCKET1" | "POCKET2" => Class::Refused("write POCKET3 or POCKET4"),
        "CYCLE79" => {
            Class::Refused("its clearing between blank and polygon is not published; write the sides as G1 under G41")
        }
        "CYCLE60" | "CYCLE70" | "CYCLE802" | "CYCLE899" => {
            Class::Refused("let the CAM system write the motions of the milling cycle")
        }
        "MEAS" | "MEAW" | "MEASA" | "MEAWA" | "CYCLE971" | "CYCLE976" | "CYCLE977" | "CYCLE978" | "CYCLE979"
        | "CYCLE982" | "CYCLE996" | "CYCLE998" => {
            Class::Refused("this cycle is not measured here; measure with MEAS=1 in a G1 block")
        }
        "CUT3DC" | "CUT3DF" | "CUT3DFS" | "CUT3DFF" | "CUT3DCC" | "CUT3DCCD" => {
            Class::Refused("let the CAM system compensate the cutter, and use CUT2D")
        }
        "DIAMON" | "DIAM90" => Class::Refused("diameter programming belongs to turning; use DIAMOF"),
        "TCOABS" | "TCOFRX" | "TCOFRY" | "TCOFRZ" => Class::Refused("swivel the plane with CYCLE800"),
        "PTP" | "PTPG0" | "ORIRESET" => Class::Refused("program the rotary axes in G0 and G1 blocks"),
        "SETINT" | "CLRINT" | "ENABLE" | "DISABLE" | "CANCEL" | "EXECSTRING" | "PCALL" | "EXECTAB" => {
            Class::Refused("call the subprogram by its name")
        }
        "WRITE" | "DELETE" | "READ" | "ISFILE" | "FILEDATE" => {
            Class::Refused("the twin writes and reads no files of the control; remove the word")
        }
        "LIMS" | "CUTMOD" => Class::Refused("remove the word"),
        "DELAYFSTON" | "DELAYFSTOF" | "ADISPOSA" => Class::Note,
        _ => Class::Unknown,
    }
}

/// Words with `=` that are not variables.
pub(crate) fn classify_assignment(name: &str) -> Class {
    match name {
        // Dynamics of single axes and spindle positions: the twin takes dynamics from the machine.
        "ACC" | "ACCLIMA" | "VELOLIM" | "VELOLIMA" | "JERKLIM" | "JERKLIMA" | "FL" | "FGREF" | "SPOS" | "SPOSA"
        | "ADISPOS" | "STOLF" | "FXS" | "FXST" | "FXSW" | "FENDNORM" | "SCC" | "CUTMOD" | "FLIM" | "OVRRAP_NORM" => {
            Class::Note
        }
        "OVRA" | "OVRRAP" => Class::Refused("write the feed itself with F"),
        "FA" => Class::Note,
        "FZ" | "FD" | "FDA" | "FPR" => Class::Refused("write the feed with F and G94"),
        "DISR" | "DISCL" | "OFFN" => Class::Refused("use G40 and programmed approach motions"),
        "POSA" | "POSP" => Class::Refused("program the axis in a G0 or G1 block"),
        "LEAD" | "TILT" => Class::Refused(
            "both count from the normal of the surface (ORIPATH, A4= B4= C4=), which no program without it says; program A3= B3= C3=",
        ),
        "THETA" | "PSI" | "NUT" | "XH" | "YH" | "ZH" | "PHI" => {
            Class::Refused("program the orientation with rotary axes or with A3= B3= C3=")
        }
        "TCARR" => Class::Refused("swivel the plane with CYCLE800"),
        "MEASA" | "MEAWA" => Class::Refused("measure with MEAS=1 in a G1 block"),
        "ID" | "IDS" => Class::Refused("remove the synchronized action"),
        "SF" | "PO" => Class::Refused(PLAIN),
        "VC" | "SVC" => Class::Refused("write the spindle speed with S"),
        "LIMS" => Class::Refused("constant cutting speed belongs to turning"),
        _ => Class::Unknown,
    }
}

/// G words without effect on the twin.
pub(crate) fn is_noted_g(code: u32) -> bool {
    matches!(
        code,
        // Exact stop windows, corner behavior and approach of radius compensation that is off, Siemens mode.
        62 | 621 | 290 | 460 | 461 | 462 | 601 | 602 | 603 | 140..=143 | 340 | 341 | 347 | 348 | 810..=819
    )
}

/// The group of a G word, of those groups that the reader runs by; a block takes one word of each.
///
/// *Programming manual Fundamentals* (840D sl, 828D), tables, "G commands"; *Diagnostics manual*,
/// alarm 12060.
pub(crate) fn g_group(code: u32) -> Option<usize> {
    Some(match code {
        0..=3 | 33 | 331 | 332 => 0,
        17..=19 => 1,
        40..=42 => 2,
        54..=57 | 500 | 505..=599 => 3,
        60 | 64 | 641..=645 => 4,
        70 | 71 | 700 | 710 => 5,
        90 | 91 => 6,
        _ => return None,
    })
}

/// Remedy for a G word that the control knows and this reader does not execute.
pub(crate) fn refused_g(code: u32) -> Option<&'static str> {
    Some(match code {
        5 | 7 => "program the path with G1",
        34 | 35 | 335 | 336 => "program a thread of constant pitch with G33",
        96 | 961 | 962 | 971..=973 => "constant cutting speed belongs to turning; use G94 or G95 and S in 1/min",
        147 | 148 | 247 | 248 => "program the approach with G1, G2, G3",
        291 => "ISO mode is a dialect of its own; use G290",
        931 => "use G93 or G94",
        _ => return None,
    })
}
