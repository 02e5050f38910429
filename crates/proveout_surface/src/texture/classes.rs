//! Setting classes and editions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which definitions of profile parameters hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Standard {
    /// ISO 21920-2:2021: Ra, Rq, Rsk, Rku over the evaluation length; Rp, Rv, Rz as mean over its sections.
    #[default]
    Iso21920,
    /// ISO 4287:1997 with its amendment of 2009: Ra, Rq, Rsk, Rku as mean of the values of the sampling
    /// lengths.
    Iso4287,
}

impl Standard {
    /// Number and edition, as printed with each value.
    pub fn edition(self) -> &'static str {
        match self {
            Self::Iso21920 => "ISO 21920-2:2021",
            Self::Iso4287 => "ISO 4287:1997+A1:2009",
        }
    }

    /// Number and edition of the standard that cut-offs and lengths come from.
    pub fn class_edition(self) -> &'static str {
        match self {
            Self::Iso21920 => "ISO 21920-3:2021, table 1",
            Self::Iso4287 => "ISO 4288:1996 and ISO 3274:1996, five sampling lengths of one cut-off",
        }
    }

    /// How a tolerance is judged where the drawing says nothing else.
    pub fn tolerance_rule(self) -> &'static str {
        match self {
            Self::Iso21920 => "maximum tolerance acceptance rule (ISO 21920-3:2021)",
            Self::Iso4287 => "16 % rule (ISO 4288:1996)",
        }
    }
}

/// A setting class of ISO 21920-3:2021, table 1: cut-offs, section and evaluation lengths that belong
/// together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
pub enum SettingClass {
    /// `lambda_c` 0.08 mm.
    Sc1,
    /// `lambda_c` 0.25 mm.
    Sc2,
    /// `lambda_c` 0.8 mm.
    Sc3,
    /// `lambda_c` 2.5 mm.
    Sc4,
    /// `lambda_c` 8 mm.
    Sc5,
}

impl SettingClass {
    /// All of them, the finest first.
    pub const ALL: [Self; 5] = [Self::Sc1, Self::Sc2, Self::Sc3, Self::Sc4, Self::Sc5];

    /// Sections in the evaluation length, in every class.
    pub const SECTIONS: usize = 5;

    /// Name as in the standard.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sc1 => "Sc1",
            Self::Sc2 => "Sc2",
            Self::Sc3 => "Sc3",
            Self::Sc4 => "Sc4",
            Self::Sc5 => "Sc5",
        }
    }

    /// Nesting index of the S-filter, mm.
    pub fn lambda_s(self) -> f64 {
        match self {
            Self::Sc1 | Self::Sc2 | Self::Sc3 => 0.0025,
            Self::Sc4 => 0.008,
            Self::Sc5 => 0.025,
        }
    }

    /// Nesting index of the L-filter, which is also the length of a section, mm.
    pub fn lambda_c(self) -> f64 {
        match self {
            Self::Sc1 => 0.08,
            Self::Sc2 => 0.25,
            Self::Sc3 => 0.8,
            Self::Sc4 => 2.5,
            Self::Sc5 => 8.0,
        }
    }

    /// Largest spacing of points, mm.
    pub fn max_spacing(self) -> f64 {
        match self {
            Self::Sc1 | Self::Sc2 | Self::Sc3 => 0.0005,
            Self::Sc4 => 0.0015,
            Self::Sc5 => 0.005,
        }
    }

    /// Evaluation length, mm: five sections.
    pub fn evaluation_length(self) -> f64 {
        match self {
            Self::Sc1 => 0.4,
            Self::Sc2 => 1.25,
            Self::Sc3 => 4.0,
            Self::Sc4 => 12.5,
            Self::Sc5 => 40.0,
        }
    }

    /// The finest class that lets marks of this pitch (mm) pass, its cut-off not below them; none beyond 8
    /// mm.
    pub fn for_pitch(pitch: f64) -> Option<Self> {
        Self::ALL.into_iter().find(|class| pitch <= class.lambda_c())
    }
}
