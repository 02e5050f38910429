//! The cycles of a Sinumerik 840D sl: the arguments of each, in their order.
//!
//! After Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02) and *NC programming* (12/2019),
//! "Programming cycles externally"; which of them are from memory says the README.
//!
//! A unit follows the name of an argument, then what it is called where it is missing, then its value where
//! it is left out.

use super::values::Of;
use super::{CycleSpec, Given, Key, Parameter, Unit, Usual, Values};
use crate::channel::milling::Heights;
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// Numbers the arguments of a call.
const fn positions<const N: usize>(mut list: [Parameter; N]) -> [Parameter; N] {
    let mut at = 0;
    while at < N {
        list[at].key = Key::Position(at as u8 + 1);
        at += 1;
    }
    list
}

macro_rules! usual {
    () => {
        Usual::None
    };
    ($value:literal) => {
        Usual::Value($value)
    };
}

macro_rules! cycles {
    ($($cycle:ident = $title:literal ($($name:ident $unit:ident $($what:literal)? $(= $usual:literal)?),* $(,)?);)*) => {
        $(
            pub(crate) static $cycle: CycleSpec = CycleSpec {
                name: $title,
                parameters: &positions([$(Parameter {
                    key: Key::Position(0),
                    name: stringify!($name),
                    unit: Unit::$unit,
                    what: concat!($($what)?),
                    usual: usual!($($usual)?),
                    written: false,
                }),*]),
                assumed: None,
            };
        )*
        /// Every cycle.
        pub(crate) static ALL: &[&CycleSpec] = &[$(&$cycle),*];
    };
}

cycles! {
    CYCLE81 = "CYCLE81" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE81_WITH_DWELL = "CYCLE81" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number, GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE82 = "CYCLE82" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number, GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE83 = "CYCLE83" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        FDEP Length, FDPR Size, DAM Number = 0.0, DTB Number, DTS Number, FRF Number, VARI Number = 0.0, AXN Number,
        MDEP Size, VRT Length, DTD Number, DIS1 Length, GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE84 = "CYCLE84" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number, SDAC Number = 5.0, MPIT Number, PIT Length, POSS Number, SST Number, SST1 Number, AXN Number,
        PITA Number = 0.0, TECHNO Unread, VARI Number = 0.0, DAM Size = 0.0, VRT Length, PITM Unread, PTAB Unread,
        PTABA Unread, GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE840 = "CYCLE840" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number, SDR Number, SDAC Number, ENC Unread, MPIT Number, PIT Length);
    CYCLE85 = "CYCLE85" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number, FFR Feed, RFF Feed, GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE86 = "CYCLE86" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number, SDIR Number, RPA Length = 0.0, RPO Length = 0.0, RPAP Length = 0.0, POSS Number = 0.0,
        GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE87 = "CYCLE87" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        SDIR Number);
    CYCLE88 = "CYCLE88" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number, SDIR Number);
    CYCLE89 = "CYCLE89" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        DTB Number);
    HOLES1 = "HOLES1" (
        SPCA Number = 0.0, SPCO Number = 0.0, STA1 Number = 0.0, FDIS Number = 0.0, DBH Number = 0.0, NUM Number = 0.0);
    HOLES2 = "HOLES2" (
        CPA Number = 0.0, CPO Number = 0.0, RAD Number = 0.0, STA1 Number = 0.0, INDA Number = 0.0, NUM Number = 0.0);
    CYCLE801 = "CYCLE801" (
        SPCA Number = 0.0, SPCO Number = 0.0, STA Number = 0.0, DIS1 Number = 0.0, DIS2 Number = 0.0, NUM1 Number = 0.0,
        NUM2 Number = 0.0, VARI Number = 0.0);
    POCKET3 = "POCKET3" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth",
        LENG Length "pocket length", WID Length "pocket width", CRAD Size = 0.0, PA Length "center", PO Length "center",
        STA Number = 0.0, MID Size = 0.0, FAL Size = 0.0, FALD Size = 0.0, FFP1 Feed, FFD Feed, CDIR Number = 0.0,
        VARI Number = 1.0, MIDA Size = 0.0, AP1 Number = 0.0, AP2 Number = 0.0, AD Number = 0.0,
        RAD1 Length "radius of the helix (RAD1)", DP1 Length "depth of a turn (DP1)", UMODE Unread, FS Unread, ZFS Unread,
        GMODE Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    POCKET4 = "POCKET4" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth",
        PRAD Length "pocket radius", PA Length "center", PO Length "center", MID Size = 0.0, FAL Size = 0.0,
        FALD Size = 0.0, FFP1 Feed, FFD Feed, CDIR Number = 0.0, VARI Number = 1.0, MIDA Size = 0.0, AP1 Number = 0.0,
        AD Number = 0.0, RAD1 Length "radius of the helix (RAD1)", DP1 Length "depth of a turn (DP1)");
    CYCLE71 = "CYCLE71" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth",
        PA Length "starting point", PO Length "starting point", LENG Length "length", WID Length "width", STA Number = 0.0,
        MID Size = 0.0, MIDA Length "infeed width", FDP Size = 0.0, FALD Size = 0.0, FFP1 Feed, VARI Number = 1.0,
        FDP1 Size = 0.0);
    CYCLE61 = "CYCLE61" (
        RTP Length "retraction plane", Z0 Length "reference plane", SC Size = 0.0, Z1 Length "final depth",
        X0 Length "first corner", Y0 Length "first corner", X1 Length "second corner or length",
        Y1 Length "second corner or length", MID Size = 0.0, MIDA Length "infeed width", FALZ Size = 0.0, FFP1 Feed,
        VARI Number = 1.0, LIM Number = 0.0, DMODE Number = 0.0, AMODE Number = 0.0);
    SLOT1 = "SLOT1" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        NUM Number = 1.0, LENG Length "length", WID Length "width", CPA Length "center", CPO Length "center",
        RAD Size = 0.0, STA1 Number = 0.0, INDA Number = 0.0, FFD Feed, FFP1 Feed, MID Size = 0.0, CDIR Number = 0.0,
        FAL Size = 0.0, VARI Number = 0.0, MIDF Size = 0.0, FFP2 Feed, SSF Number, FALD Size = 0.0, STA2 Number);
    SLOT2 = "SLOT2" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        NUM Number = 1.0, AFSL Number = 0.0, WID Length "width", CPA Length "center", CPO Length "center", RAD Size = 0.0,
        STA1 Number = 0.0, INDA Number = 0.0, FFD Feed, FFP1 Feed, MID Size = 0.0, CDIR Number = 0.0, FAL Size = 0.0,
        VARI Number = 0.0, MIDF Size = 0.0, FFP2 Feed, SSF Number);
    LONGHOLE = "LONGHOLE" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        NUM Number = 1.0, LENG Length "length", CPA Length "center", CPO Length "center", RAD Size = 0.0,
        STA1 Number = 0.0, INDA Number = 0.0, FFD Feed, FFP1 Feed, MID Size = 0.0);
    CYCLE76 = "CYCLE76" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        LENG Length "spigot length", WID Length "spigot width", CRAD Size = 0.0, PA Length "center", PO Length "center",
        STA Number = 0.0, MID Size = 0.0, FAL Size = 0.0, FALD Size = 0.0, FFP1 Feed, FFD Feed, CDIR Number = 0.0,
        VARI Number = 1.0, AP1 Size = 0.0, AP2 Size = 0.0);
    CYCLE77 = "CYCLE77" (
        RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth", DPR Size = 0.0,
        PRAD Length "spigot diameter", PA Length "center", PO Length "center", MID Size = 0.0, FAL Size = 0.0,
        FALD Size = 0.0, FFP1 Feed, FFD Feed, CDIR Number = 0.0, VARI Number = 1.0, AP1 Size = 0.0);
    CYCLE72 = "CYCLE72" (
        KNAME Text, RTP Length "retraction plane", RFP Length "reference plane", SDIS Size = 0.0, DP Length "final depth",
        MID Size = 0.0, FAL Size = 0.0, FALD Size = 0.0, FFP1 Feed, FFD Feed, VARI Number = 1.0, RL Number = 41.0,
        AS1 Number, LP1 Size = 0.0, FF3 Feed, AS2 Number, LP2 Size = 0.0, UMODE Unread, FS Unread, ZFS Unread, GMODE Unread,
        DMODE Number = 0.0, AMODE Number = 0.0);
    CYCLE62 = "CYCLE62" (KNAME Text, TYPE Number = 0.0, LAB1 Text, LAB2 Text);
    CYCLE832 = "CYCLE832" (TOL Length, MODE Number, OTOL Number);
    CYCLE800 = "CYCLE800" (
        FR Number = 0.0, TC Text, ST Number = 0.0, MODE Number = 0.0, X0 Length = 0.0, Y0 Length = 0.0, Z0 Length = 0.0,
        A Number = 0.0, B Number = 0.0, C Number = 0.0, X1 Length = 0.0, Y1 Length = 0.0, Z1 Length = 0.0, DIR Number = 1.0);
}

/// Cycles that make one hole.
pub(crate) fn makes_a_hole(name: &str) -> bool {
    name.strip_prefix("CYCLE8").is_some_and(|rest| rest == "40" || matches!(rest.as_bytes(), [b'1'..=b'9']))
}

impl Values {
    /// The arguments of a call.
    pub(crate) fn of_call(
        spec: &'static CycleSpec,
        arguments: impl Iterator<Item = Option<Given>>,
        length: f64,
        span: Span,
    ) -> Self {
        let numbered = (1u8..=u8::MAX).zip(arguments);
        let given = numbered.filter_map(|(at, given)| Some((Key::Position(at), given?))).collect();
        Self { spec, given, length, lift: 0.0, span }
    }

    /// Position of an argument in the call, counted from 1.
    pub(crate) fn place(&self, name: &str) -> u8 {
        match name.of(self.spec) {
            Some(Parameter { key: Key::Position(at), .. }) => at,
            _ => 0,
        }
    }

    /// The text of an argument; none where it is empty.
    pub(crate) fn text(&self, name: &str) -> Option<&str> {
        match self.given(name) {
            Some(Given::Text(text)) if !text.trim().is_empty() => Some(text),
            _ => None,
        }
    }

    /// The first arguments, as numbers.
    pub(crate) fn all<const N: usize>(&self) -> Result<[f64; N], Fault> {
        let mut numbers = [0.0; N];
        for (slot, parameter) in numbers.iter_mut().zip(self.spec.parameters) {
            *slot = self.value(parameter.name)?;
        }
        Ok(numbers)
    }

    /// Refuses an argument that is set.
    pub(crate) fn refuse_set(&self, name: &str, what: &str) -> Result<(), Fault> {
        if self.value(name)? == 0.0 {
            return Ok(());
        }
        let message = format!("`{}` with {what} (argument {}) is not supported", self.name(), self.place(name));
        Err(self.fault(codes::UNSUPPORTED_WORD, message, "let the CAM system write the motions"))
    }

    /// The call has no arguments after those of its table.
    pub(crate) fn no_more(&self) -> Result<(), Fault> {
        let Some(at) = self.surplus() else { return Ok(()) };
        let message = format!("argument {at} of `{}` is not read", self.name());
        let help =
            "leave it out; those that the control's editor adds (GMODE, DMODE, AMODE and before) are not supported";
        Err(self.fault(codes::UNSUPPORTED_WORD, message, help))
    }

    /// DMODE: the plane that it names must be the active one.
    pub(crate) fn check_plane(&self, normal: usize) -> Result<(), Fault> {
        let plane = self.digit("DMODE", 1.0)?;
        if plane == 0.0 || plane == (3 - normal) as f64 {
            return Ok(());
        }
        let mode = self.value("DMODE")?;
        let message = format!("`{}` in another plane than the active one (DMODE {mode}) is not supported", self.name());
        Err(self.fault(codes::UNSUPPORTED_WORD, message, "choose the plane with G17, G18 or G19"))
    }

    /// GMODE and DMODE of a cycle for one hole (Operate): another reference of the depth or another plane is
    /// refused.
    pub(crate) fn check_modes(&self, normal: usize) -> Result<(), Fault> {
        let (geometry, ..) = (self.value("GMODE")?, self.value("DMODE")?, self.value("AMODE")?);
        if geometry != 0.0 {
            let message =
                format!("`{}` with GMODE {geometry} (another reference of the depth) is not supported", self.name());
            return Err(self.fault(codes::UNSUPPORTED_WORD, message, "give the depth of the tip, GMODE 0"));
        }
        self.check_plane(normal)
    }

    /// Dwell of a hole; in revolutions (below zero) where the tens of AMODE are 2.
    pub(crate) fn dwell(&self) -> Result<Option<f64>, Fault> {
        let (dwell, in_revolutions) = (self.get("DTB")?, self.digit("AMODE", 10.0)? == 2.0);
        Ok(if in_revolutions { dwell.map(|dwell| -dwell.abs()) } else { dwell })
    }

    /// Planes of a cycle for one hole. The depth is DP, or DPR below the reference plane; where both are
    /// written AMODE says which one counts: 1 DPR, 2 DP.
    pub(crate) fn heights_of_hole(&self) -> Result<Heights, Fault> {
        let mode = self.digit("AMODE", 1.0)?;
        let relative = if mode == 2.0 && self.given("DP").is_some() { 0.0 } else { self.value("DPR")? };
        if mode == 1.0
            && relative == 0.0
            && self.given("DPR").is_some()
            && let Some(depth) = "DP".of(self.spec)
        {
            return Err(self.missing(&depth));
        }
        self.heights_below(["RTP", "RFP", "SDIS", "DP"], relative)
    }

    /// Planes of a milling cycle. The depth is DP, or DPR below the reference plane where that is written.
    pub(crate) fn heights(&self) -> Result<Heights, Fault> {
        self.heights_below(["RTP", "RFP", "SDIS", "DP"], self.value("DPR")?)
    }

    /// The same where the units of AMODE say whether DP is relative (1) or absolute (0, 2).
    pub(crate) fn heights_by_mode(&self, planes: [&str; 4]) -> Result<Heights, Fault> {
        let relative = self.digit("AMODE", 1.0)? == 1.0;
        let below = if relative { self.get(planes[3])?.map_or(0.0, f64::abs) } else { 0.0 };
        self.heights_below(planes, below)
    }

    /// `below`: depth below the reference plane, without sign, away from the retraction plane; 0 where it is
    /// absolute.
    fn heights_below(&self, [retraction, reference, safety, depth]: [&str; 4], below: f64) -> Result<Heights, Fault> {
        let (second, surface) = (self.value(retraction)?, self.value(reference)?);
        let depth = match below {
            0.0 => self.value(depth)?,
            below => surface - below * if second >= surface { 1.0 } else { -1.0 },
        };
        let down = if depth < surface { -1.0 } else { 1.0 };
        if depth == surface || (second - surface) * down > 0.0 {
            let message = format!(
                "the planes of `{}` do not follow each other: retraction {second}, reference {surface}, depth {depth}",
                self.name()
            );
            let help = "the reference plane lies between the retraction plane and the final depth";
            return Err(self.fault(codes::ARGUMENTS, message, help));
        }
        Ok(Heights { clear: surface - down * self.value(safety)?, second, surface, depth, down })
    }

    /// Tens and units of VARI.
    pub(crate) fn variant(&self) -> Result<(u32, u32), Fault> {
        let vari = self.value("VARI")?;
        if vari.fract() == 0.0 && (0.0..100.0).contains(&vari) {
            return Ok((vari as u32 / 10, vari as u32 % 10));
        }
        Err(self.fault(codes::ARGUMENTS, format!("VARI of `{}` is {vari}", self.name()), "write 1 or 2, and tens"))
    }

    /// Units of VARI: 1 roughs, 2 finishes.
    pub(crate) fn finishes(&self, units: u32) -> Result<bool, Fault> {
        match units {
            1 => Ok(false),
            2 => Ok(true),
            other => {
                let message = format!("the units of VARI of `{}` are {other}", self.name());
                Err(self.fault(codes::ARGUMENTS, message, "1 roughs, 2 finishes"))
            }
        }
    }
}
