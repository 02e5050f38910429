//! What `proveout plan` makes, as written in a scene: one table a strategy.

use std::path::PathBuf;

use proveout_geom::{Vector, rad};
use proveout_path::{
    AxisRule, ConstantScallop, Flank, HelicalPass, IsoParametric, IsoPlanar, Label, OneWay, Pocket, PointRoughing,
    QuasiCircle, Row, Rulings, Spacing, StepRule, Strategy, Transverse,
};
use schemars::JsonSchema;
use serde::Deserialize;

/// Shorter vectors are no direction.
const SHORTEST: f64 = 1e-12;
/// Part of a distance between lines that one more would have to cover: rounding adds no line.
const ROUNDING: f64 = 1e-9;

/// What `proveout plan` makes: one table a strategy.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PlanFile {
    /// A ball end mill on a helix round the blade.
    pub helix: Option<HelixFile>,
    /// Lines round the sections, to and fro.
    pub transverse: Option<PathFile>,
    /// Lines along the blade at constant parts of the section's length.
    pub iso_parametric: Option<PathFile>,
    /// Lines in parallel planes.
    pub iso_planar: Option<PathFile>,
    /// Rings inside each other in the parameter plane.
    pub pocket: Option<PathFile>,
    /// Lines along the blade, each next to the one before at the distance that the scallop allows
    /// at every place.
    pub constant_scallop: Option<PathFile>,
    /// Lines along the blade at constant polar angles of Lu et al. 2022, which never cross an edge.
    pub quasi_circle: Option<PathFile>,
    /// One row along the blade.
    pub row: Option<PathFile>,
    /// A blade from solid: lines round the sections in layers.
    pub point_roughing: Option<PathFile>,
    /// A ruled side in one pass with the flank of the cutter.
    pub flank: Option<PathFile>,
}

/// Strategies that are planned by contacts; [`HelixFile`] is separate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrategyFile {
    /// `transverse`
    Transverse,
    /// `iso-parametric`
    IsoParametric,
    /// `iso-planar`
    IsoPlanar,
    /// `pocket`
    Pocket,
    /// `constant-scallop`
    ConstantScallop,
    /// `quasi-circle`
    QuasiCircle,
    /// `row`
    Row,
    /// `point-roughing`
    PointRoughing,
    /// `flank`
    Flank,
}

/// Name and meaning of `helix`, on the command line.
pub const HELIX: (&str, &str) = ("helix", "A ball end mill on a helix round the blade");

impl StrategyFile {
    /// Every strategy with its name, in scenes and on the command line, and its meaning.
    pub const ALL: [(Self, &'static str, &'static str); 9] = [
        (Self::Transverse, "transverse", "Lines round the sections"),
        (Self::IsoParametric, "iso-parametric", "Lines along the blade at constant fractions of the section's length"),
        (Self::IsoPlanar, "iso-planar", "Lines in parallel planes"),
        (Self::Pocket, "pocket", "Nested rings"),
        (Self::ConstantScallop, "constant-scallop", "Lines along the blade, spaced by the scallop height everywhere"),
        (
            Self::QuasiCircle,
            "quasi-circle",
            "Lines along the blade at constant polar angles, which never cross an edge",
        ),
        (Self::Row, "row", "One row along the blade"),
        (Self::PointRoughing, "point-roughing", "Layers that cut a blade from solid"),
        (Self::Flank, "flank", "A ruled side in one pass with the flank of the cutter"),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(s, ..)| *s == self).map_or("", |(_, name, _)| name)
    }

    /// The one of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, n, _)| *n == name).map(|(s, ..)| *s)
    }

    /// Its table in a scene, to be changed.
    pub(crate) fn of_mut(self, plan: &mut PlanFile) -> Option<&mut PathFile> {
        let table = match self {
            Self::Transverse => &mut plan.transverse,
            Self::IsoParametric => &mut plan.iso_parametric,
            Self::IsoPlanar => &mut plan.iso_planar,
            Self::Pocket => &mut plan.pocket,
            Self::ConstantScallop => &mut plan.constant_scallop,
            Self::QuasiCircle => &mut plan.quasi_circle,
            Self::Row => &mut plan.row,
            Self::PointRoughing => &mut plan.point_roughing,
            Self::Flank => &mut plan.flank,
        };
        table.as_mut()
    }

    /// Its table in a scene.
    pub fn of(self, plan: &PlanFile) -> Option<&PathFile> {
        let table = match self {
            Self::Transverse => &plan.transverse,
            Self::IsoParametric => &plan.iso_parametric,
            Self::IsoPlanar => &plan.iso_planar,
            Self::Pocket => &plan.pocket,
            Self::ConstantScallop => &plan.constant_scallop,
            Self::QuasiCircle => &plan.quasi_circle,
            Self::Row => &plan.row,
            Self::PointRoughing => &plan.point_roughing,
            Self::Flank => &plan.flank,
        };
        table.as_ref()
    }

    /// Keys that it reads in addition to those of every strategy.
    fn reads(self) -> &'static [&'static str] {
        match self {
            Self::Transverse => &["scallop_mm", "lines", "across", "along", "one_way"],
            Self::IsoParametric => &["scallop_mm", "lines", "across", "along", "parameter", "one_way"],
            Self::IsoPlanar => {
                &["scallop_mm", "lines_mm", "lines_apart_mm", "across_mm", "across", "along", "normal", "one_way"]
            }
            Self::Pocket => &["scallop_mm", "lines", "across", "along", "outwards"],
            Self::ConstantScallop => &["scallop_mm", "across", "along"],
            Self::QuasiCircle => {
                &["scallop_mm", "lines_deg", "across_deg", "along", "focus_inside", "trailing", "one_way"]
            }
            Self::Row => &["at", "along", "parameter", "trailing", "focus_inside"],
            Self::PointRoughing => &["scallop_mm", "lines", "along", "from_allowance_mm", "depth_mm", "start"],
            Self::Flank => &["across", "along", "rulings", "beyond_end_mm", "flank_error_mm"],
        }
    }
}

/// What is constant along a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ParameterFile {
    /// Part of the section's length: the chord-length parameter.
    Length,
    /// The surface's own parameter, as part of its range.
    Surface,
    /// The polar angle of Lu et al. 2022, parts of a turn; of `row` alone.
    PolarAngle,
}

/// Which lines of a side are straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RulingsFile {
    /// Those along the blade; the path goes round.
    Along,
    /// Those across the face; the path goes along.
    Across,
}

/// Orientation of the tool axis. f is the travel, n the outward normal, k = n x f.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, tag = "rule", rename_all = "kebab-case")]
pub enum AxisFile {
    /// Along the normal.
    Normal {},
    /// From the normal towards the travel, then towards k.
    LeadTilt {
        /// Degrees.
        #[serde(default)]
        lead_deg: f64,
        /// Degrees.
        #[serde(default)]
        tilt_deg: f64,
    },
    /// Inclined to the normal, in a direction that is turned from the travel towards k.
    InclinationTilt {
        /// Degrees.
        inclination_deg: f64,
        /// Degrees.
        #[serde(default)]
        tilt_deg: f64,
    },
    /// The head does not move, a rotary table turns the part.
    FixedHead {
        /// Direction of the table's axis, workpiece frame.
        table: [f64; 3],
        /// Angle of the tool axis towards `table`, from the plane across it, degrees.
        #[serde(default)]
        head_deg: f64,
        /// In the plane across `table`, from the normal towards the travel, degrees.
        #[serde(default)]
        lead_deg: f64,
    },
    /// On great circles between given axes.
    Interpolated {
        /// The axes.
        axes: Vec<GivenAxisFile>,
    },
    /// Along the ruling by two of its points; of `flank` alone.
    Ruling {
        /// Parts of the ruling, from the side of the cutter's tip; a quarter and three quarters when left
        /// out.
        #[serde(default = "quarters")]
        points: [f64; 2],
    },
}

fn quarters() -> [f64; 2] {
    [0.25, 0.75]
}

/// A tool axis at a place of a line.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenAxisFile {
    /// Part of the line's length, 0 to 1.
    pub part: f64,
    /// Direction from the tip to the holder, workpiece frame; any length.
    pub direction: [f64; 3],
}

/// What a planned program holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PostedFile {
    /// Tool vectors under tool center point control.
    ToolCenterPoint,
    /// Positions of the axes.
    Joints,
}

/// What the feed of a planned program holds for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeedReferenceFile {
    /// The way of the contact along its line.
    #[default]
    Arc,
    /// The chord from contact to contact.
    Chord,
}

/// A path over the blade by contacts. Keys that a strategy does not read are refused.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PathFile {
    /// Name of the tool in the tool library.
    pub tool: String,
    /// Spindle speed, 1/min.
    pub spindle_rpm: f64,
    /// Feed of the contact, mm/min; written as inverse time, so that it does not depend on the tool axis.
    pub feed_mm_min: f64,
    /// What that feed holds for: the way along the line (when left out), or the chord from contact to
    /// contact.
    #[serde(default)]
    pub feed_reference: FeedReferenceFile,
    /// Machine that the program is for, where it is not the scene's.
    pub machine: Option<PathBuf>,
    /// What the program holds; when left out, tool vectors where the control of the machine has tool center
    /// point control.
    pub posted: Option<PostedFile>,
    /// Word of the work offset.
    pub work_offset: String,
    /// Path tolerance that the program asks the control for, mm.
    pub tolerance_mm: f64,
    /// Orientation of the tool axis.
    pub axis: AxisFile,
    /// Way along the normal at feed before and after a line, mm.
    pub lift_mm: f64,
    /// Distance of rapids from the outermost point of the blade, mm: on a cylinder round a closed blade, on a
    /// plane over a face.
    pub clearance_mm: f64,
    /// Material left on the blade, mm.
    #[serde(default)]
    pub allowance_mm: f64,
    /// Largest distance between the surface and what the straight motion between two blocks leaves, mm.
    /// Either this or `step_mm`.
    pub chord_error_mm: Option<f64>,
    /// With `chord_error_mm`: longest step, mm; 5 when left out.
    pub longest_step_mm: Option<f64>,
    /// Equal steps along every line, no longer than this, mm.
    pub step_mm: Option<f64>,
    /// Height that ridges between lines may have, mm. Either this or the lines.
    pub scallop_mm: Option<f64>,
    /// The lines by their parameter: part of the section (`iso-parametric`), of the blade's length
    /// (`transverse`, `point-roughing`), of the field (`pocket`).
    pub lines: Option<Vec<f64>>,
    /// The lines by their polar angle, degrees: 0 the trailing edge, 180 the leading edge, the convex side
    /// between them.
    pub lines_deg: Option<Vec<f64>>,
    /// The planes by their distance from the origin along `normal`, mm.
    pub lines_mm: Option<Vec<f64>>,
    /// Planes at equal distances from one end of `across_mm` to the other, no farther apart than this, mm.
    pub lines_apart_mm: Option<f64>,
    /// From where to where across the blade, parts of the section; all round when left out.
    pub across: Option<[f64; 2]>,
    /// From which polar angle to which, degrees.
    pub across_deg: Option<[f64; 2]>,
    /// From which plane to which, mm.
    pub across_mm: Option<[f64; 2]>,
    /// From where to where along the blade, parts of its length; all of it when left out.
    pub along: Option<[f64; 2]>,
    /// What is constant along a line; `length` when left out.
    pub parameter: Option<ParameterFile>,
    /// How far the branch points lie inside of the edges, parts of the chord; 0, as published, when left out.
    pub focus_inside: Option<f64>,
    /// Part of the section's parameter near which the trailing edge lies at the first section; 0 when left
    /// out.
    pub trailing: Option<f64>,
    /// Normal of the planes, workpiece frame; any length.
    pub normal: Option<[f64; 3]>,
    /// Place of the row by its parameter.
    pub at: Option<f64>,
    /// Allowance of the outermost layer, mm; the innermost one has `allowance_mm`.
    pub from_allowance_mm: Option<f64>,
    /// Largest difference between two layers, mm.
    pub depth_mm: Option<f64>,
    /// Where a line begins and ends round the section, part of its parameter; 0 when left out.
    pub start: Option<f64>,
    /// All lines in the same direction, which leaves the blade after each; to and fro when left out.
    pub one_way: Option<bool>,
    /// Rings from the middle outwards.
    pub outwards: Option<bool>,
    /// Which lines of the side are straight; the tip of the cutter lies beyond the first end of `along` or
    /// `across`.
    pub rulings: Option<RulingsFile>,
    /// How far the straight side of the cutter reaches beyond that end, mm; 0 when left out.
    pub beyond_end_mm: Option<f64>,
    /// How far the flank may cut into the side or stay off it, mm.
    pub flank_error_mm: Option<f64>,
}

/// Longest step by chord error where a scene states none, mm: a block of a CAM system's usual length.
const LONGEST_STEP_MM: f64 = 5.0;
/// Most distances that `lines_apart_mm` may make.
const MOST_LINES: f64 = 100_000.0;

impl PathFile {
    /// Keys given in addition to those of every strategy.
    fn given(&self) -> Vec<&'static str> {
        let all = [
            ("scallop_mm", self.scallop_mm.is_some()),
            ("lines", self.lines.is_some()),
            ("lines_deg", self.lines_deg.is_some()),
            ("lines_mm", self.lines_mm.is_some()),
            ("lines_apart_mm", self.lines_apart_mm.is_some()),
            ("across", self.across.is_some()),
            ("across_deg", self.across_deg.is_some()),
            ("across_mm", self.across_mm.is_some()),
            ("along", self.along.is_some()),
            ("parameter", self.parameter.is_some()),
            ("focus_inside", self.focus_inside.is_some()),
            ("trailing", self.trailing.is_some()),
            ("normal", self.normal.is_some()),
            ("at", self.at.is_some()),
            ("from_allowance_mm", self.from_allowance_mm.is_some()),
            ("depth_mm", self.depth_mm.is_some()),
            ("start", self.start.is_some()),
            ("one_way", self.one_way.is_some()),
            ("outwards", self.outwards.is_some()),
            ("rulings", self.rulings.is_some()),
            ("beyond_end_mm", self.beyond_end_mm.is_some()),
            ("flank_error_mm", self.flank_error_mm.is_some()),
        ];
        all.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
    }

    /// The rule of the tool axis.
    pub fn axis_rule(&self) -> AxisRule {
        let unit = |v: [f64; 3]| Vector::from(v).try_normalize(SHORTEST).unwrap_or_else(Vector::zeros);
        match &self.axis {
            AxisFile::Normal {} => AxisRule::Normal,
            AxisFile::LeadTilt { lead_deg, tilt_deg } => {
                AxisRule::LeadTilt { lead: rad(*lead_deg), tilt: rad(*tilt_deg) }
            }
            AxisFile::InclinationTilt { inclination_deg, tilt_deg } => {
                AxisRule::InclinationTilt { inclination: rad(*inclination_deg), tilt: rad(*tilt_deg) }
            }
            AxisFile::FixedHead { table, head_deg, lead_deg } => {
                AxisRule::FixedHead { table: unit(*table), head: rad(*head_deg), lead: rad(*lead_deg) }
            }
            AxisFile::Interpolated { axes } => {
                AxisRule::Interpolated(axes.iter().map(|a| (a.part, unit(a.direction))).collect())
            }
            AxisFile::Ruling { points } => AxisRule::Ruling { points: *points },
        }
    }

    /// The step along lines.
    ///
    /// # Errors
    /// What is missing or given twice, and what to write.
    pub fn step_rule(&self) -> Result<StepRule, (String, String)> {
        match (self.chord_error_mm, self.step_mm, self.longest_step_mm) {
            (Some(error), None, longest) => Ok(StepRule::Chord { error, longest: longest.unwrap_or(LONGEST_STEP_MM) }),
            (None, Some(step), None) => Ok(StepRule::Length(step)),
            (None, Some(_), Some(_)) => {
                Err(("longest_step_mm belongs to chord_error_mm".into(), "leave it out when step_mm is given".into()))
            }
            _ => Err((
                "the step along the lines must be given exactly once".into(),
                "give either chord_error_mm or step_mm".into(),
            )),
        }
    }

    fn spacing(&self, lines: Option<&Vec<f64>>, key: &str, factor: f64) -> Result<Spacing, (String, String)> {
        match (self.scallop_mm, lines) {
            (Some(scallop), None) => Ok(Spacing::Scallop(scallop)),
            (None, Some(lines)) => Ok(Spacing::At(lines.iter().map(|l| l * factor).collect())),
            _ => Err((
                "the distance of the lines must be given exactly once".into(),
                format!("give either scallop_mm or {key}"),
            )),
        }
    }

    /// Planes at equal distances, mm, where these are asked for.
    fn lines_apart(&self) -> Result<Option<Vec<f64>>, (String, String)> {
        let Some(apart) = self.lines_apart_mm else { return Ok(None) };
        let Some([from, to]) = self.across_mm else {
            return Err((
                "lines_apart_mm needs `across_mm`".into(),
                "add `across_mm`: the first plane and the last".into(),
            ));
        };
        let count = ((to - from).abs() / apart - ROUNDING).ceil().max(0.0);
        if !(apart > 0.0 && (1.0..=MOST_LINES).contains(&count)) {
            let message = format!("lines_apart_mm = {apart} between {from} and {to} mm makes {count} distances");
            return Err((
                message,
                format!("give two planes, and a distance that makes 1 to {MOST_LINES} between them"),
            ));
        }
        Ok(Some((0..=count as usize).map(|i| from + (to - from) * i as f64 / count).collect()))
    }

    fn label(&self, allowed: &[ParameterFile]) -> Result<Label, (String, String)> {
        let parameter = self.parameter.unwrap_or(ParameterFile::Length);
        if !allowed.contains(&parameter) {
            return Err((
                "parameter = \"polar-angle\" belongs to row".into(),
                "plan quasi-circle for more than one row".into(),
            ));
        }
        if parameter != ParameterFile::PolarAngle && (self.trailing.is_some() || self.focus_inside.is_some()) {
            let message = "trailing and focus_inside belong to parameter = \"polar-angle\"";
            return Err((message.into(), "leave them out".into()));
        }
        Ok(match parameter {
            ParameterFile::Length => Label::Length,
            ParameterFile::Surface => Label::Surface,
            ParameterFile::PolarAngle => Label::PolarAngle { focus_inside: self.focus_inside.unwrap_or(0.0) },
        })
    }

    /// The strategy with its options.
    ///
    /// # Errors
    /// A key that the strategy does not read, or one that is missing, and what to write.
    pub fn strategy(&self, strategy: StrategyFile) -> Result<Box<dyn Strategy>, (String, String)> {
        let reads = strategy.reads();
        if let Some(key) = self.given().into_iter().find(|key| !reads.contains(key)) {
            let message = format!("{} does not read `{key}`", strategy.name());
            return Err((message, format!("leave it out; it reads {}", reads.join(", "))));
        }
        let ruled = matches!(self.axis, AxisFile::Ruling { .. });
        if ruled != (strategy == StrategyFile::Flank) {
            let message = "rule = \"ruling\" is for flank only".to_owned();
            return Err((message, "write another rule, or plan flank".to_owned()));
        }
        let missing = |key: &str| (format!("{} needs `{key}`", strategy.name()), format!("add `{key}`"));
        let across = self.across.unwrap_or([0.0, 1.0]);
        let along = self.along.unwrap_or([0.0, 1.0]);
        let lines = || self.spacing(self.lines.as_ref(), "lines", 1.0);
        let planned: Box<dyn Strategy> = match strategy {
            StrategyFile::Transverse => Box::new(Transverse {
                round: across,
                range: along,
                spacing: lines()?,
                one_way: self.one_way.unwrap_or(false),
            }),
            StrategyFile::IsoParametric => Box::new(IsoParametric {
                label: self.label(&[ParameterFile::Length, ParameterFile::Surface])?,
                range: across,
                along,
                spacing: lines()?,
            }),
            StrategyFile::IsoPlanar => {
                let normal = Vector::from(self.normal.ok_or_else(|| missing("normal"))?);
                let normal = normal.try_normalize(SHORTEST);
                let normal =
                    normal.ok_or_else(|| ("the planes' normal has no length".into(), "give a direction".to_owned()))?;
                let apart = self.lines_apart()?;
                let lines = match (&apart, &self.lines_mm) {
                    (Some(_), Some(_)) => {
                        let message = "the distance of the lines is given twice".to_owned();
                        return Err((message, "give either lines_apart_mm or lines_mm".to_owned()));
                    }
                    (apart, own) => apart.as_ref().or(own.as_ref()),
                };
                let spacing = self.spacing(lines, "lines_mm, or lines_apart_mm", 1.0)?;
                let range = match (&spacing, self.across_mm) {
                    (Spacing::At(_), Some(_)) if apart.is_some() => [0.0; 2],
                    (Spacing::At(_), None) => [0.0; 2],
                    (Spacing::At(_), Some(_)) => {
                        return Err((
                            "across_mm belongs to scallop_mm and lines_apart_mm".into(),
                            "leave it out when lines_mm is given".into(),
                        ));
                    }
                    (Spacing::Scallop(_), range) => range.ok_or_else(|| missing("across_mm"))?,
                };
                Box::new(IsoPlanar { normal, range, round: across, along, spacing })
            }
            StrategyFile::Pocket => {
                Box::new(Pocket { round: across, along, spacing: lines()?, outwards: self.outwards.unwrap_or(false) })
            }
            StrategyFile::ConstantScallop => {
                let scallop = self.scallop_mm.ok_or_else(|| missing("scallop_mm"))?;
                Box::new(ConstantScallop { range: across, along, scallop })
            }
            StrategyFile::QuasiCircle => {
                let spacing = self.spacing(self.lines_deg.as_ref(), "lines_deg", rad(1.0))?;
                if matches!(spacing, Spacing::At(_)) && self.across_deg.is_some() {
                    return Err((
                        "across_deg belongs to scallop_mm".into(),
                        "leave it out when lines_deg is given".into(),
                    ));
                }
                Box::new(QuasiCircle {
                    focus_inside: self.focus_inside.unwrap_or(0.0),
                    trailing: self.trailing.unwrap_or(0.0),
                    range: self.across_deg.unwrap_or([0.0, 360.0]).map(rad),
                    along,
                    spacing,
                })
            }
            StrategyFile::Row => Box::new(Row {
                label: self.label(&[ParameterFile::Length, ParameterFile::Surface, ParameterFile::PolarAngle])?,
                at: self.at.ok_or_else(|| missing("at"))?,
                trailing: self.trailing.unwrap_or(0.0),
                along,
            }),
            StrategyFile::PointRoughing => Box::new(PointRoughing {
                from_allowance: self.from_allowance_mm.ok_or_else(|| missing("from_allowance_mm"))?,
                to_allowance: self.allowance_mm,
                depth: self.depth_mm.ok_or_else(|| missing("depth_mm"))?,
                range: along,
                start: self.start.unwrap_or(0.0),
                spacing: lines()?,
            }),
            StrategyFile::Flank => Box::new(Flank {
                rulings: match self.rulings.ok_or_else(|| missing("rulings"))? {
                    RulingsFile::Along => Rulings::Along,
                    RulingsFile::Across => Rulings::Across,
                },
                round: across,
                along,
                below: self.beyond_end_mm.unwrap_or(0.0),
                limit: self.flank_error_mm.ok_or_else(|| missing("flank_error_mm"))?,
            }),
        };
        // Lines round the sections have a way of their own to go to and fro.
        let turned = self.one_way == Some(true) && strategy != StrategyFile::Transverse;
        Ok(if turned { Box::new(OneWay(planned)) } else { planned })
    }
}

/// A pass of a ball end mill round the blade, as `proveout plan --strategy helix` writes it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HelixFile {
    /// Name of the ball end mill in the tool library.
    pub tool: String,
    /// Spindle speed, 1/min.
    pub spindle_rpm: f64,
    /// Feed of the ball center, mm/min; written as inverse time, so that it does not depend on the tool axis.
    pub feed_mm_min: f64,
    /// Word of the work offset.
    pub work_offset: String,
    /// Material left on the blade, mm.
    #[serde(default)]
    pub allowance_mm: f64,
    /// Inclination of the tool axis towards +X, degrees.
    pub head_tilt_deg: f64,
    /// Lean of the tool axis from the outward normal towards the travel, degrees.
    pub lead_deg: f64,
    /// X of the first contact, mm.
    pub from_x_mm: f64,
    /// X of the last contact, mm.
    pub to_x_mm: f64,
    /// Advance for each turn, mm.
    pub pitch_mm: f64,
    /// Distance of the points on the path of the ball center, mm.
    pub step_mm: f64,
    /// Where on the section the pass begins, part of its perimeter from the leading end of the pressure side.
    pub start: f64,
    /// Distance of approach and retract from the blade along its normal, mm.
    pub clearance_mm: f64,
    /// Path tolerance that the program asks the control for (CYCLE832), mm.
    pub tolerance_mm: f64,
}

impl HelixFile {
    /// The pass for a ball of this radius, mm.
    pub fn pass(&self, ball_radius: f64) -> HelicalPass {
        HelicalPass {
            ball_radius,
            allowance: self.allowance_mm,
            head_tilt: rad(self.head_tilt_deg),
            lead: rad(self.lead_deg),
            from_x: self.from_x_mm,
            to_x: self.to_x_mm,
            pitch: self.pitch_mm,
            step: self.step_mm,
            start: self.start,
        }
    }
}
