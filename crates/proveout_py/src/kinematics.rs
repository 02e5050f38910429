//! Joints and tool poses of a machine, in numpy; mm and degrees.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use proveout_geom::{Point, ToolPose, Vector, rad};
use proveout_machine::{Joint, JointValues, KinematicsError, Machine};
use proveout_sim::SimError;
use pyo3::prelude::*;

use crate::{
    arrays::{frozen, frozen_row, frozen_rows, rows},
    errors::{raised, wrong},
};

/// Columns of poses: tip in mm and unit axis, table frame K.
const POSE: [&str; 6] = ["x_mm", "y_mm", "z_mm", "i", "j", "k"];
/// Most branches of a pose.
const BRANCHES: usize = 2;
/// A tool axis may miss the length one by this much, five digits; it is then normalized. As in tables of the
/// command line.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-5;

/// Branches of poses: joints (n, 2, m), counts (n,), singular (n, 2), distance of the axis in degrees (n,).
type Found = (Py<PyArray3<f64>>, Py<PyArray1<u32>>, Py<PyArray2<bool>>, Py<PyArray1<f64>>);
/// Continuous joints (n, m), branches (n,), notes.
type Followed = (Py<PyArray2<f64>>, Py<PyArray1<i32>>, Vec<String>);

/// The kinematics of a machine.
#[pyclass(frozen, name = "Kinematics", module = "proveout._proveout")]
pub(crate) struct PyKinematics(Machine);

impl PyKinematics {
    fn columns(&self) -> Vec<String> {
        self.0.joints.iter().map(|j| format!("{}_{}", j.name, j.kind.unit())).collect()
    }

    fn values(&self, row: &[f64]) -> JointValues {
        let mut q = self.0.home();
        for (k, (value, joint)) in row.iter().zip(&self.0.joints).enumerate() {
            q[k] = if joint.is_rotary() { rad(*value) } else { *value };
        }
        q
    }

    /// In units of people, without a negative zero.
    fn shown(&self, q: &JointValues) -> impl Iterator<Item = f64> {
        let value = |(k, joint): (usize, &Joint)| joint.kind.in_unit(q[k]) + 0.0;
        self.0.joints.iter().enumerate().map(value).collect::<Vec<_>>().into_iter()
    }

    fn poses(&self, py: Python<'_>, poses: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<ToolPose>> {
        let rows = rows(py, poses, &POSE)?;
        let pose = |(row, n): (usize, &Vec<f64>)| {
            let axis = Vector::new(n[3], n[4], n[5]);
            let length = axis.norm();
            if (length - 1.0).abs() > AXIS_LENGTH_TOLERANCE {
                let message = format!("row {row}: the axis (i, j, k) has length {length}");
                return Err(wrong(py, message, "give a unit vector from the tip to the holder"));
            }
            Ok(ToolPose { tip: Point::new(n[0], n[1], n[2]), axis: axis / length })
        };
        rows.iter().enumerate().map(pose).collect()
    }
}

fn length(py: Python<'_>, tool_length_mm: f64) -> PyResult<f64> {
    if tool_length_mm >= 0.0 && tool_length_mm.is_finite() {
        return Ok(tool_length_mm);
    }
    let remedy = "give the distance from the tip to the gauge line, mm, zero or more";
    Err(wrong(py, format!("tool_length_mm = {tool_length_mm} is not a valid length"), remedy))
}

#[pymethods]
impl PyKinematics {
    #[new]
    fn new(py: Python<'_>, machine: PathBuf) -> PyResult<Self> {
        let machine = py.detach(|| Machine::read(&machine));
        machine.map(Self).map_err(|e| raised(py, &SimError::from(e).into()))
    }

    /// Name of the machine.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Names of the joints with their units, `X_mm`, `A_deg`: the columns of joint positions.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.columns()
    }

    /// Joint positions at home.
    #[getter]
    fn home(&self, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        frozen_row(py, self.shown(&self.0.home()).collect())
    }

    /// Tool poses (n, 6) of joint positions (n, m).
    fn forward(
        &self,
        py: Python<'_>,
        joints: PyReadonlyArray2<'_, f64>,
        tool_length_mm: f64,
    ) -> PyResult<Py<PyArray2<f64>>> {
        let length = length(py, tool_length_mm)?;
        let names = self.columns();
        let given = rows(py, &joints, &names.iter().map(String::as_str).collect::<Vec<_>>())?;
        let poses = py.detach(|| {
            let pose = |row: &Vec<f64>| self.0.forward(&self.values(row), length);
            let numbers = |p: ToolPose| [p.tip.x, p.tip.y, p.tip.z, p.axis.x, p.axis.y, p.axis.z].map(|v| v + 0.0);
            given.iter().map(pose).flat_map(numbers).collect()
        });
        frozen_rows(py, poses, POSE.len())
    }

    /// All branches of tool poses (n, 6); nan in the place of a branch that is not there.
    fn inverse(&self, py: Python<'_>, poses: PyReadonlyArray2<'_, f64>, tool_length_mm: f64) -> PyResult<Found> {
        let length = length(py, tool_length_mm)?;
        let (poses, width) = (self.poses(py, &poses)?, self.0.joints.len());
        let (mut joints, mut counts, mut singular, mut errors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        py.detach(|| {
            for pose in &poses {
                let found = self.0.inverse(pose, length);
                for k in 0..BRANCHES {
                    match found.get(k) {
                        Some(branch) => joints.extend(self.shown(&branch.q)),
                        None => joints.extend(std::iter::repeat_n(f64::NAN, width)),
                    }
                    singular.push(found.get(k).is_some_and(|b| b.singular));
                }
                counts.push(u32::try_from(found.len()).unwrap_or_default());
                errors.push(found.axis_error.to_degrees());
            }
        });
        Ok((
            frozen(py, joints, (poses.len(), BRANCHES, width))?,
            frozen_row(py, counts)?,
            frozen_rows(py, singular, BRANCHES)?,
            frozen_row(py, errors)?,
        ))
    }

    /// Joint positions of tool poses (n, 6), each continuous with the one before, the first with `start` or
    /// home.
    fn follow(
        &self,
        py: Python<'_>,
        poses: PyReadonlyArray2<'_, f64>,
        tool_length_mm: f64,
        start: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Followed> {
        let length = length(py, tool_length_mm)?;
        let poses = self.poses(py, &poses)?;
        let names = self.columns();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let start = start.map(|s| rows(py, &s, &names)).transpose()?;
        let mut before = start.iter().flatten().next().map_or_else(|| self.0.home(), |row| self.values(row));
        let (mut joints, mut branches, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        py.detach(|| {
            for pose in &poses {
                let (q, branch, note) = match self.0.inverse_nearest(pose, length, &before) {
                    Ok(s) if s.singular => (Some(s.q), Some(s.branch), "singular".to_owned()),
                    Ok(s) => (Some(s.q), Some(s.branch), String::new()),
                    Err(ref e @ KinematicsError::OverTravel { ref solution, .. }) => {
                        (Some(solution.q), Some(solution.branch), e.to_string())
                    }
                    Err(e) => (None, None, e.to_string()),
                };
                match q {
                    Some(q) => {
                        joints.extend(self.shown(&q));
                        before = q;
                    }
                    None => joints.extend(std::iter::repeat_n(f64::NAN, self.0.joints.len())),
                }
                branches.push(branch.and_then(|b| i32::try_from(b).ok()).unwrap_or(-1));
                notes.push(note);
            }
        });
        Ok((frozen_rows(py, joints, self.0.joints.len())?, frozen_row(py, branches)?, notes))
    }

    fn __repr__(&self) -> String {
        format!("Kinematics({:?}: {})", self.0.name, self.columns().join(", "))
    }
}
