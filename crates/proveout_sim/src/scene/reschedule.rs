//! Programs that are made from others: the method and its options, in scenes and on the command line.

mod options;
mod words;

use std::f64::consts::TAU;

use proveout_reschedule::{
    ChannelKind, Criterion, Junction, Measurement, Method, MinAngularAcceleration, MultiScale, Quaternion, RowEnds,
    STheta, SearchedInset, Singularity, Smooth, SmoothRows, ThetaUnit,
};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::units::MM_PER_UM;

pub use self::words::{ChannelFile, InsetFile, InsetWordFile, KeyAxesFile, MethodFile};

/// A program that is made from another one.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RescheduleFile {
    /// The method.
    pub method: MethodFile,
    /// Name of the program that it starts from.
    pub from: String,
    /// `s-theta`, `smooth`: clearance from both limits, degrees. `quaternion`: of the channel that is shown;
    /// it changes no axis.
    pub clearance_deg: Option<f64>,
    /// `s-theta`: distance of key points from the limits, degrees; or `search` for the one with the least
    /// peak of acceleration at the programmed feed.
    pub inset_deg: Option<InsetFile>,
    /// `s-theta`: shortest flat at the start of a layer, mm.
    pub start_flat_mm: Option<f64>,
    /// `s-theta`: flat at the end of a layer, percent of the layer's length.
    pub end_flat_percent: Option<f64>,
    /// `s-theta`: key points nearer than this are merged, mm.
    pub merge_mm: Option<f64>,
    /// `s-theta`: unit of theta in the construction of corners.
    pub theta_unit: Option<ThetaUnit>,
    /// `quaternion`: key blocks of a layer.
    pub keys: Option<usize>,
    /// `singularity`: blocks whose axis is nearer to the table's axis than this are looked at, degrees.
    pub cone_deg: Option<f64>,
    /// `singularity`: they are changed where the table turns by more than this for a mm of contact path,
    /// degrees.
    pub rate_deg_mm: Option<f64>,
    /// `singularity`: how the ends of a changed stretch are smoothed.
    pub junction: Option<Junction>,
    /// `min-angular-acceleration`: largest lean of key axes from the table's axis, degrees.
    pub max_key_lean_deg: Option<f64>,
    /// `min-angular-acceleration`: half of the window at a key, mm.
    pub window_mm: Option<f64>,
    /// `min-angular-acceleration`: what the axes between keys are the least of.
    pub criterion: Option<Criterion>,
    /// `min-angular-acceleration`: where the axes of the keys come from.
    pub key_axes: Option<KeyAxesFile>,
    /// `multi-scale`, `smooth` of rows: narrowest strip, mm.
    pub strip_min_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: widest strip, mm.
    pub strip_max_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: height over the surface at which a strip is measured, mm.
    pub strip_height_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: largest Ra across the feed, um; 0 for no limit.
    pub ra_um: Option<f64>,
    /// `multi-scale`, `smooth` of rows: evaluation length of Ra, mm.
    pub evaluation_length_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: way at both ends of a row that is not judged while its first and last
    /// axis stay, mm.
    pub run_in_mm: Option<f64>,
    /// `multi-scale`: how far inside of its interval a contact is fixed, degrees.
    pub margin_deg: Option<f64>,
    /// `multi-scale`: coefficients of a rotary curve at the start.
    pub coefficients: Option<usize>,
    /// `multi-scale`, `smooth` of rows: what a measurement is taken to read of the computed Ra, as
    /// a part of it; with it the study reports how many of 90 places are expected above `ra_um`.
    pub measured_ratio: Option<f64>,
    /// `multi-scale`, `smooth` of rows: standard deviation of what is read, as a part of it; 0 when left out.
    pub measured_spread: Option<f64>,
    /// `smooth`: where the limits of the axis come from.
    pub channel: Option<ChannelFile>,
    /// `smooth`: largest lean of the tool axis from the normal in the channel of the tool and of rows,
    /// degrees.
    pub lean_max_deg: Option<f64>,
    /// `smooth`: the rotary axis does not turn back.
    pub monotone: Option<bool>,
    /// `smooth`: time of the control that is given up for a lower peak of acceleration, percent; 0.1 when
    /// left out.
    pub max_time_loss_percent: Option<f64>,
    /// `smooth` of rows: largest turn of the tool axis from the program's own, degrees.
    pub turn_max_deg: Option<f64>,
    /// `smooth` of rows: whether the axes at both ends of a row stay.
    pub ends: Option<RowEnds>,
}

impl RescheduleFile {
    /// A method with its published or default parameters.
    pub fn plain(method: MethodFile, from: &str) -> Self {
        Self { method, from: from.to_owned(), ..Self::default() }
    }

    /// Rules of a bull-nose.
    fn multi_scale(&self) -> MultiScale {
        let defaults = MultiScale::default();
        let [narrow, wide] = defaults.strip;
        MultiScale {
            strip: [self.strip_min_mm.unwrap_or(narrow), self.strip_max_mm.unwrap_or(wide)],
            strip_height: self.strip_height_mm.unwrap_or(defaults.strip_height),
            roughness: self.ra_um.map_or(defaults.roughness, |um| MM_PER_UM * um),
            evaluation_length: self.evaluation_length_mm.unwrap_or(defaults.evaluation_length),
            run_in: self.run_in_mm.unwrap_or(defaults.run_in),
            margin: self.margin_deg.map_or(defaults.margin, |d| d * TAU / 360.0),
            coefficients: self.coefficients.unwrap_or(defaults.coefficients),
            measurement: self
                .measured_ratio
                .map(|part| Measurement { part, spread: self.measured_spread.unwrap_or(0.0) }),
        }
    }

    /// The method with its parameters.
    pub fn method(&self) -> Box<dyn Method> {
        let defaults = STheta::default();
        let clearance = self.clearance_deg.map_or(defaults.clearance, |d| d * TAU / 360.0);
        match self.method {
            MethodFile::STheta => {
                let method = STheta {
                    clearance,
                    inset: match self.inset_deg {
                        Some(InsetFile::Degrees(degrees)) => degrees * TAU / 360.0,
                        Some(InsetFile::Word(InsetWordFile::Search)) | None => defaults.inset,
                    },
                    unit: self.theta_unit.unwrap_or_default(),
                    start_flat: self.start_flat_mm.unwrap_or(defaults.start_flat),
                    end_flat: self.end_flat_percent.map_or(defaults.end_flat, |p| p / 100.0),
                    merge: self.merge_mm.unwrap_or(defaults.merge),
                };
                match self.inset_deg {
                    Some(InsetFile::Word(InsetWordFile::Search)) => Box::new(SearchedInset(method)),
                    _ => Box::new(method),
                }
            }
            MethodFile::Quaternion => {
                Box::new(Quaternion { keys: self.keys.unwrap_or(Quaternion::default().keys), clearance })
            }
            MethodFile::MinAngularAcceleration => {
                let defaults = MinAngularAcceleration::default();
                Box::new(MinAngularAcceleration {
                    cap: self.max_key_lean_deg.map_or(defaults.cap, |d| d * TAU / 360.0),
                    window: self.window_mm.unwrap_or(defaults.window),
                    criterion: self.criterion.unwrap_or(defaults.criterion),
                    search: self.key_axes.map_or(defaults.search, |k| k == KeyAxesFile::Search),
                })
            }
            MethodFile::MultiScale => Box::new(self.multi_scale()),
            MethodFile::Smooth if self.channel == Some(ChannelFile::Rows) => {
                let defaults = SmoothRows::default();
                Box::new(SmoothRows {
                    lean_max: self.lean_max_deg.map_or(defaults.lean_max, |d| d * TAU / 360.0),
                    turn_max: self.turn_max_deg.map(|d| d * TAU / 360.0),
                    ends: self.ends.unwrap_or(defaults.ends),
                    rules: self.multi_scale(),
                })
            }
            MethodFile::Smooth => {
                let defaults = Smooth::default();
                Box::new(Smooth {
                    channel: match self.channel {
                        None => defaults.channel,
                        Some(ChannelFile::Clearance | ChannelFile::Rows) => ChannelKind::Clearance,
                        Some(ChannelFile::Tool) => ChannelKind::Tool,
                    },
                    clearance,
                    lean_max: self.lean_max_deg.map_or(defaults.lean_max, |d| d * TAU / 360.0),
                    monotone: self.monotone.unwrap_or(defaults.monotone),
                    given_up: self.max_time_loss_percent.map_or(defaults.given_up, |p| 0.01 * p),
                })
            }
            MethodFile::Singularity => {
                let defaults = Singularity::default();
                Box::new(Singularity {
                    cone: self.cone_deg.map_or(defaults.cone, |d| d * TAU / 360.0),
                    rate: self.rate_deg_mm.map_or(defaults.rate, |d| d * TAU / 360.0),
                    junction: self.junction.unwrap_or(defaults.junction),
                })
            }
        }
    }
}
