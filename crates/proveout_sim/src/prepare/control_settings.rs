//! How the control of a scene is set up.

use proveout_controller::Settings as ControlSettings;
use proveout_geom::rad;
use proveout_nc::Dialect;

use crate::{prepare::prepared::Prepared, scene::Scene};

impl Prepared {
    /// Settings of the control as scene, machine and the language of the program say.
    pub fn control_settings(&self, dialect: Dialect) -> ControlSettings {
        ControlSettings { dynamics: self.dynamics, plant: self.plant, ..control_settings(&self.scene, dialect) }
    }

    /// How far the edges of a piece of motion may be from where the true motion has them, mm.
    pub(crate) fn piece_tolerance(&self) -> f64 {
        piece_tolerance(&self.scene)
    }
}

/// How the control of a scene is set up for programs of a language, with the planned set points as motion.
pub(crate) fn control_settings(scene: &Scene, dialect: Dialect) -> ControlSettings {
    let usual = ControlSettings::default();
    ControlSettings {
        piece_tolerance: piece_tolerance(scene),
        default_tolerance: scene.file.control.path_tolerance_mm,
        pole_cone: scene.file.control.pole_cone_deg.map(rad),
        max_time: scene.file.run_limits.max_time(),
        start_tool: scene.file.start.tool,
        length_active_after_change: length_active_after_change(dialect),
        length_in_machine_coordinates: length_in_machine_coordinates(dialect),
        ..usual
    }
}

fn piece_tolerance(scene: &Scene) -> f64 {
    let told = scene.file.control.piece_tolerance_mm.as_ref();
    told.map_or_else(|| ControlSettings::default().piece_tolerance, |t| *t.get_ref())
}

/// Whether the length of a new tool counts without a word of the program: G43 controls want theirs. 840D,
/// Klartext and its DIN/ISO form take the length with the tool, and CL data know nothing but the tip.
pub(crate) fn length_active_after_change(dialect: Dialect) -> bool {
    match dialect {
        Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => false,
        Dialect::Auto | Dialect::Siemens840d | Dialect::Heidenhain | Dialect::HeidenhainIso | Dialect::Apt => true,
    }
}

/// Whether the tool length counts in machine coordinates: on a TNC, "the tool length, however, is not
/// compensated" in blocks with M91 or M92 (HEIDENHAIN, *Klartext programming*, "Programming
/// machine-referenced coordinates").
pub(crate) fn length_in_machine_coordinates(dialect: Dialect) -> bool {
    !matches!(dialect, Dialect::Heidenhain | Dialect::HeidenhainIso)
}

#[cfg(test)]
mod tests {
    use proveout_nc::{Program, Settings as NcSettings};

    use super::*;

    /// The language is recognized from the text, as in a run without a dialect in the scene.
    fn dialect_of(name: &str, text: &str) -> Dialect {
        match Program::from_text(name, text, &NcSettings::default()) {
            Ok(program) => program.dialect(),
            Err(e) => panic!("{e}"),
        }
    }

    #[test]
    fn controls_that_want_g43_take_no_length_with_the_tool() {
        let iso = "%\nO1000\nG21 G90 G17\nT1 M6\nG0 G43 H1 Z50.\nM30\n%\n";
        assert!(!length_active_after_change(dialect_of("part.nc", iso)));
        assert!(!length_active_after_change(Dialect::LinuxCnc));
        let siemens = "N10 G17 G710\nN20 T=\"BALL\"\nN30 M6\nN40 G0 Z=50 D1\nN50 M30\n";
        assert!(length_active_after_change(dialect_of("part.mpf", siemens)));
        let heidenhain = "BEGIN PGM P MM\n1 TOOL CALL 1 Z S1000\n2 L Z+50 R0 FMAX\n3 M30\nEND PGM P MM\n";
        assert!(length_active_after_change(dialect_of("part.h", heidenhain)));
    }
}
