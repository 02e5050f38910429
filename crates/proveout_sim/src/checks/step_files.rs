//! STEP files of the scene ([`STEP_READ`](crate::verdict::finding::STEP_READ),
//! [`STEP_COARSE`](crate::verdict::finding::STEP_COARSE)).
//!
//! Each file is reported once, at the begin of the run: kernel, counts, and the chord error that was
//! measured. One above what was asked for is a warning. The chord error of the design is in the floor of its
//! tolerances. That of stock and fixtures is compared with the distances that decide about touches. Where it
//! exceeds them, the gate of the collision stays unchecked: the true body may reach as far out of its mesh.

use crate::{
    checks::check::{Check, RunEnd, StretchView},
    evidence::inputs::{MeshRole, StepInput, shown},
    prepare::prepared::Prepared,
    verdict::{
        finding::{Finding, STEP_COARSE, STEP_READ},
        gate::Gate,
        log::FindingLog,
    },
};

/// Faces without a solid that a finding names.
const NAMED: usize = 5;

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct StepInputs {
    is_reported: bool,
}

impl StepInputs {
    fn report(&mut self, prepared: &Prepared, log: &mut FindingLog) {
        if std::mem::replace(&mut self.is_reported, true) {
            return;
        }
        for input in &prepared.step_files {
            log.push(read(input));
            if !input.mesh.is_as_asked() {
                log.push(coarse(input));
            }
        }
    }
}

impl Check for StepInputs {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        self.report(view.prepared, log);
    }

    /// A program without motion has no stretch.
    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        self.report(end.prepared, log);
        let tolerances = &end.prepared.scene.file.tolerances;
        for input in &end.prepared.step_files {
            let (key, allowed) = match input.role {
                MeshRole::Part => continue,
                MeshRole::Stock => ("contact_mm", tolerances.contact_mm),
                MeshRole::Fixture(_) => ("near_miss_mm", tolerances.near_miss_mm),
            };
            let error = input.mesh.chord_error_mm();
            if error > allowed {
                log.leave_out(
                    Gate::Collision,
                    format!(
                        "{} is known to {error:.4} mm only, more than {key} = {allowed} mm: give it a smaller `chord_um`",
                        input.role
                    ),
                );
            }
        }
    }
}

fn read(input: &StepInput) -> Finding {
    let StepInput { role, path, is_assumed, mesh } = input;
    let count = |n: usize, one: &str| format!("{n} {one}{}", if n == 1 { "" } else { "s" });
    let asked = if *is_assumed { ", assumed: state `chord_um`" } else { "" };
    let loose: Vec<String> = mesh.loose.iter().take(NAMED).map(|f| format!("#{} {:?}", f.id, f.name)).collect();
    let left_out = if loose.is_empty() {
        String::new()
    } else {
        let more = if mesh.loose.len() > NAMED { ", ..." } else { "" };
        let faces = count(mesh.loose.len(), "face");
        format!("; {faces} outside of the solids left out: {}{more}", loose.join(", "))
    };
    let message = format!(
        "{role}: {} ({}, {}) by {}: {}, {}, {}, {:.3} mm3; chord error {:.2} um measured at ({:.3}, {:.3}, {:.3}) among {} points, {:.2} um taken ({} um asked{asked}){left_out}",
        shown(path),
        mesh.text.schema,
        mesh.text.unit.name,
        mesh.kernel,
        count(mesh.solids, "solid"),
        count(mesh.text.faces.len(), "face"),
        count(mesh.mesh.triangles.len(), "triangle"),
        mesh.exact_volume_mm3,
        mesh.measured_um,
        mesh.worst.x,
        mesh.worst.y,
        mesh.worst.z,
        mesh.samples,
        1000.0 * mesh.chord_error_mm(),
        mesh.asked_um,
    );
    let mut finding = FindingLog::of(&STEP_READ, message);
    finding.bodies = vec![role.body().to_owned()];
    (finding.value, finding.limit, finding.unit) = (Some(mesh.measured_um), Some(mesh.asked_um), Some("um".into()));
    finding
}

fn coarse(input: &StepInput) -> Finding {
    let StepInput { role, path, mesh, .. } = input;
    let message = format!(
        "{role}: the mesh of {} is {:.2} um off its surface at ({:.3}, {:.3}, {:.3}), and {} um were asked: the measured value counts",
        shown(path),
        mesh.measured_um,
        mesh.worst.x,
        mesh.worst.y,
        mesh.worst.z,
        mesh.asked_um
    );
    let mut finding = FindingLog::of(&STEP_COARSE, message);
    finding.bodies = vec![role.body().to_owned()];
    (finding.value, finding.limit, finding.unit) = (Some(mesh.measured_um), Some(mesh.asked_um), Some("um".into()));
    finding
}
