//! What a page shows of a comparison in addition to its numbers: curves and meshes, free of engine
//! state.

use proveout_controller::ReprogrammedRun;
use proveout_geom::{TriMesh, Vector};
use proveout_reschedule::{Curve, CurveKind, Figure};

use crate::observe::study::StudyFigure;

pub use crate::observe::study::{Role, Study, StudyCurve};

/// Pictures of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// The programs in the order of the scene.
    pub programs: Vec<ProgramPicture>,
    /// Joints of the baseline's machine, in machine order.
    pub joints: Vec<JointPicture>,
    /// The cut parts; none without a design.
    pub part: Option<PartPicture>,
    /// Stretch that plots over programmed time show closely, s since the begin of the cutting stretch.
    pub shown_s: Option<[f64; 2]>,
}

/// A joint and its limits; mm or degrees, seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointPicture {
    /// Name.
    pub name: String,
    /// `mm` or `deg`.
    pub unit: &'static str,
    /// From internal units (mm, radian) to `unit`.
    pub factor: f64,
    /// Velocity, acceleration, jerk, where the machine limits them.
    pub limits: [Option<f64>; 3],
}

/// Curves of one program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgramPicture {
    /// Name.
    pub name: String,
    /// Begin and end of the cutting stretch and of the part of it that is shown closely, s of the program.
    pub windows: Option<[[f64; 2]; 2]>,
    /// What the program asks of each joint at its programmed feed, a row a block.
    pub demand: Vec<Vec<DemandRow>>,
    /// What the method shows of its work, one for each run.
    pub studies: Vec<Study>,
}

/// Demand on a joint at the end of a block; mm or degrees, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DemandRow {
    /// Programmed time since the begin of the cutting stretch, s.
    pub time_s: f64,
    /// Position.
    pub position: f64,
    /// Velocity.
    pub velocity: f64,
    /// Acceleration; not a number at the end of a run.
    pub acceleration: f64,
}

/// The cut part of the baseline, with values of every program at its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartPicture {
    /// Surface of the baseline's cut part, workpiece frame, mm.
    pub mesh: TriMesh,
    /// Unit normals at its vertices.
    pub normals: Vec<Vector>,
    /// Deviation from the design at its vertices, mm, of every program in the order of the scene; not a
    /// number where nothing is judged.
    pub deviation: Vec<Vec<f64>>,
    /// Deviation less that of the baseline; empty for the baseline.
    pub difference: Vec<Vec<f64>>,
    /// Arc length on the section and height of the judged vertices, or lengths on the lines of their face,
    /// mm, not a number for the others; empty where the design is no blade.
    pub unrolled: Vec<[f64; 2]>,
}

/// What the method of a run shows.
pub(crate) fn study_of(run: &ReprogrammedRun) -> Study {
    let role = |kind: CurveKind| match kind {
        CurveKind::Limit => Role::Limit,
        CurveKind::Original => Role::Original,
        CurveKind::Polyline => Role::Polyline,
        CurveKind::Result => Role::Result,
        CurveKind::KeyPoints => Role::KeyPoints,
        CurveKind::Marks => Role::Marks,
    };
    let curve = |c: &Curve| StudyCurve {
        name: c.name.into(),
        role: role(c.kind),
        axes: c.axes.map(|a| a.name.into()),
        units: c.axes.map(|a| a.unit.into()),
        equal_scales: false,
        points: c.points.clone(),
    };
    let figure = |f: &Figure| StudyFigure { name: f.name.into(), unit: f.unit.into(), value: f.value };
    let curves = run.study.curves.iter().map(curve).chain(super::sphere::gauss_sphere(run));
    Study { curves: curves.collect(), figures: run.study.figures.iter().map(figure).collect() }
}
