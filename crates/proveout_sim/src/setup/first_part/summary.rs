//! The proposal for programs that read without a fault: the figures that the README of the scene
//! gives in words.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Plan, StockForm, Tools};

/// A scene as it is proposed. Lengths are mm; the stock lies in the frame of the workpiece, the mount in that
/// of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Programs with the language that each was read in.
    pub programs: Vec<ProgramTold>,
    /// Name of the machine.
    pub machine: String,
    /// The scene gets a copy of the machine that counts from home.
    pub machine_from_home: bool,
    /// Stock.
    pub stock: StockTold,
    /// Place of the zero of the workpiece on the table.
    pub mount_mm: [f64; 3],
    /// Why it is there.
    pub mount_reason: String,
    /// What holds the part, in words.
    pub workholding: String,
    /// Work offsets in base coordinates by their words, mm.
    pub work_offsets_mm: BTreeMap<String, [f64; 3]>,
    /// Tools; none where the library of the call is taken as it is.
    pub tools: Vec<ToolTold>,
    /// Distance of the rays.
    pub resolution_mm: f64,
    /// Notes to the reader.
    pub notes: Vec<String>,
}

/// A program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ProgramTold {
    /// Its path, as the call names it.
    pub file: String,
    /// Its language.
    pub dialect: String,
}

/// The stock.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StockTold {
    /// `box`, `cylinder` or `mesh`.
    pub kind: &'static str,
    /// Lowest corner of its box.
    pub min_mm: [f64; 3],
    /// Highest corner of its box.
    pub max_mm: [f64; 3],
    /// Where it comes from; begins with `chosen` where it was not given.
    pub reason: String,
}

/// A tool.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ToolTold {
    /// Place in the tool table.
    pub number: u32,
    /// Name.
    pub name: String,
    /// Shape, as the library writes it.
    pub kind: Option<&'static str>,
    /// Diameter of the flutes.
    pub diameter_mm: Option<f64>,
    /// From the tip to the gauge line.
    pub gauge_length_mm: Option<f64>,
    /// Where the numbers come from.
    pub source: String,
}

impl Summary {
    pub(crate) fn of(plan: &Plan<'_>) -> Self {
        let bounds = plan.stock.value.aabb();
        let programs = plan.call.programs.iter().zip(&plan.dialects);
        let drafts = match &plan.tools {
            Tools::Drafts(drafts) => drafts.as_slice(),
            Tools::Library(_) => &[],
        };
        Self {
            programs: programs
                .map(|(file, dialect)| ProgramTold {
                    file: file.display().to_string(),
                    dialect: dialect.name().to_owned(),
                })
                .collect(),
            machine: plan.machine.name.clone(),
            machine_from_home: plan.home_zero.is_some(),
            stock: StockTold {
                kind: match &plan.stock.value {
                    StockForm::Box(_) => "box",
                    StockForm::Cylinder { .. } => "cylinder",
                    StockForm::Mesh(..) => "mesh",
                },
                min_mm: bounds.min.coords.into(),
                max_mm: bounds.max.coords.into(),
                reason: plan.stock.reason.clone(),
            },
            mount_mm: plan.mount.value.into(),
            mount_reason: plan.mount.reason.clone(),
            workholding: plan.workholding.words(),
            work_offsets_mm: plan.offsets.iter().map(|(word, base, _)| (word.clone(), *base)).collect(),
            tools: drafts
                .iter()
                .map(|d| ToolTold {
                    number: d.number,
                    name: d.name.clone(),
                    kind: d.kind,
                    diameter_mm: d.diameter(),
                    gauge_length_mm: d.gauge,
                    source: d.source.clone(),
                })
                .collect(),
            resolution_mm: plan.resolution.value,
            notes: plan.notes.clone(),
        }
    }
}
