//! Texts of findings about parts that have come off.

use proveout_geom::Pose;
use proveout_stock::StockPart;

use super::fall::{End, Struck};
use crate::{
    units::M_PER_MM,
    verdict::{
        finding::{self, Finding},
        log::FindingLog,
    },
};

/// Name of a part, counted from 1 in the order in which they came off.
pub(super) fn name(k: usize) -> String {
    format!("loose part {}", k + 1)
}

/// A part that has come off, and where it goes.
pub(super) fn came_off(k: usize, part: &StockPart, mass: f64, end: &End, table_from_work: &Pose) -> Finding {
    let size = part.bounds.size();
    let goes = match end {
        End::Rests { push } => {
            let push = push * M_PER_MM;
            format!(
                "they stay at rest, also under a push of {push:.1} m/s2 in any direction, and remain part of the \
                     stock"
            )
        }
        End::Left => "they fall off and are removed from the stock".to_owned(),
        End::Lies { within } => {
            // No "-0".
            let p = table_from_work.inverse().point(&within.center()).coords.map(|x| x.round() + 0.0);
            format!(
                "they fall, come to rest about X {:.0} Y {:.0} Z {:.0} and are removed from the stock",
                p.x, p.y, p.z
            )
        }
        End::Unknown(why) => {
            format!("where they fall is unknown ({why}), so the twin leaves them in place")
        }
        End::Unfinished => "they still fall".to_owned(),
    };
    let message = format!(
        "{:.1} mm3 ({:.3} kg) are no longer connected to the rest of the stock: {:.1} x {:.1} x {:.1} mm; {goes}",
        part.volume_mm3, mass, size.x, size.y, size.z
    );
    let mut f = FindingLog::of(&finding::LOOSE_PART, message);
    f.bodies = vec!["stock".into(), name(k)];
    f.point_mm = Some(part.center.coords.into());
    (f.value, f.unit) = (Some(part.volume_mm3), Some("mm3".into()));
    f
}

/// Something that a part hit on its way. Speeds are given to two figures and times to a hundredth
/// of a second: the assumptions are worth no more.
pub(super) fn struck(k: usize, hit: &Struck, work_from_table: &Pose) -> Finding {
    let speed = two_figures(hit.speed);
    let p = work_from_table.point(&hit.point).coords.map(f64::round);
    let message = format!("{} hits {} at {speed} mm/s, {:.2} s", name(k), hit.body, hit.time);
    let mut f = FindingLog::of(&finding::LOOSE_PART_HITS, message);
    f.bodies = vec![name(k), hit.body.clone()];
    f.point_mm = Some([p.x, p.y, p.z]);
    (f.value, f.unit) = (Some(speed), Some("mm/s".into()));
    f
}

fn two_figures(x: f64) -> f64 {
    let unit = 10_f64.powi(x.max(1.0).log10().floor() as i32 - 1).max(1.0);
    (x / unit).round() * unit
}

/// The cutter cuts a part that nothing clamps.
pub(super) fn cut(k: usize) -> Finding {
    let name = name(k);
    let message = format!("the cutter cuts {name}, which nothing clamps: the cutter can catch and throw it");
    let mut f = FindingLog::of(&finding::LOOSE_PART_CUT, message);
    f.bodies = vec![name];
    f
}

/// For the gates.
pub(super) fn thrown(k: usize) -> String {
    format!("where {} goes when the cutter throws it (process-loose-part-cut)", name(k))
}

/// For the gates.
pub(super) fn not_decided(k: usize, why: &str) -> String {
    format!("where {}, cut off the stock, goes (process-loose-part): {why}", name(k))
}

/// For the gates.
pub(super) fn moved_by_table(k: usize, push: f64, time: f64) -> String {
    format!(
        "where {}, cut off the stock, goes (process-loose-part): it stays at rest under pushes of up to {:.1} m/s2, \
         but at {time:.2} s the table tilts or accelerates it more",
        name(k),
        push * M_PER_MM
    )
}

/// For the gates.
pub(super) fn came_near(name: &str, body: &str, time: f64) -> String {
    format!(
        "{body} against {name}, cut off the stock (process-loose-part): at {time:.2} s the body reaches the place of \
         that part"
    )
}

/// For the gates.
pub(super) fn checked(rests: usize, gone: usize) -> Option<String> {
    let count = |n: usize| if n == 1 { "1 part".to_owned() } else { format!("{n} parts") };
    let parts = match (rests, gone) {
        (0, 0) => return None,
        (r, 0) => format!("{} that came off the stock, at rest in its place", count(r)),
        (0, g) => format!("without {} that fell off the stock", count(g)),
        (r, g) => {
            format!("{} that came off the stock, at rest in its place, and without {} that fell", count(r), count(g))
        }
    };
    Some(format!("; {parts} (process-loose-part)"))
}

#[cfg(test)]
mod tests {
    use super::two_figures;

    #[test]
    fn speeds_have_two_figures() {
        let cases = [(1358.2, 1400.0), (627.1, 630.0), (51.4, 51.0), (99.7, 100.0), (3.2, 3.0), (0.4, 0.0)];
        for (x, want) in cases {
            assert!((two_figures(x) - want).abs() < 1e-9, "{x}");
        }
    }
}
