//! Reports as lines of text.

use std::fmt::{Display, Formatter, Result};

use super::{ArealReport, ArealValues, ProfileReport, ProfileValues, Unchecked};

fn or_none(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "none".to_owned(), |v| format!("{v:.decimals$}"))
}

fn reasons(f: &mut Formatter<'_>, unchecked: &[Unchecked], remarks: &[String]) -> Result {
    for reason in unchecked {
        writeln!(f, "  unchecked [{}]: {reason}", reason.rule())?;
    }
    for remark in remarks {
        writeln!(f, "  remark: {remark}")?;
    }
    Ok(())
}

/// One row of a table: name, filtered, unfiltered, unit.
fn row(f: &mut Formatter<'_>, name: &str, filtered: Option<String>, unfiltered: &str, unit: &str) -> Result {
    let filtered = filtered.unwrap_or_else(|| "unchecked".to_owned());
    writeln!(f, "{}", format!("  {name:<4} {filtered:>12} {unfiltered:>12} {unit}").trim_end())
}

type Row<V> = (&'static str, fn(&V) -> String, &'static str);

fn table<V>(f: &mut Formatter<'_>, rows: &[Row<V>], filtered: Option<&V>, unfiltered: &V) -> Result {
    writeln!(f, "       {:>12} {:>12}", "filtered", "unfiltered")?;
    for (name, value, unit) in rows {
        row(f, name, filtered.map(value), &value(unfiltered), unit)?;
    }
    Ok(())
}

impl Display for ProfileReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "profile: {}; class {} of {}", self.standard, self.class, self.class_standard)?;
        writeln!(
            f,
            "  lambda_s {} µm, lambda_c {} mm, evaluation length {} mm in {} sections; {}",
            self.lambda_s_um, self.lambda_c_mm, self.evaluation_length_mm, self.sections, self.filter_standard
        )?;
        writeln!(f, "  form: {}; ends: {}", self.form_removal, self.end_rule)?;
        let angle = self.direction_to_lay_deg.map_or_else(String::new, |d| format!(" ({d:.1} degrees)"));
        writeln!(
            f,
            "  points every {:.4} µm over {:.4} mm; direction to the lay: {}{angle}; pitch {} mm; unfiltered over {:.4} mm",
            self.spacing_um,
            self.length_mm,
            self.direction_to_lay,
            or_none(self.pitch_mm, 4),
            self.unfiltered_length_mm
        )?;
        let rows: &[Row<ProfileValues>] = &[
            ("Ra", |v| format!("{:.4}", v.ra_um), "µm"),
            ("Rq", |v| format!("{:.4}", v.rq_um), "µm"),
            ("Rp", |v| format!("{:.4}", v.rp_um), "µm"),
            ("Rv", |v| format!("{:.4}", v.rv_um), "µm"),
            ("Rz", |v| format!("{:.4}", v.rz_um), "µm"),
            ("Rt", |v| format!("{:.4}", v.rt_um), "µm"),
            ("Rsk", |v| format!("{:.4}", v.rsk), ""),
            ("Rku", |v| format!("{:.4}", v.rku), ""),
            ("RSm", |v| or_none(v.rsm_mm, 4), "mm"),
        ];
        table(f, rows, self.filtered.as_ref(), &self.unfiltered)?;
        reasons(f, &self.unchecked, &self.remarks)
    }
}

impl Display for ArealReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let ([x, y], [dx, dy], [nx, ny]) = (self.evaluation_area_mm, self.spacing_um, self.points);
        writeln!(f, "area: {}; {}", self.standard, self.filter_standard)?;
        writeln!(
            f,
            "  S-filter {}; L-filter {} mm (lambda_c of class {})",
            self.s_filter_um.map_or_else(|| self.s_filter.clone(), |s| format!("{s} µm")),
            self.l_filter_mm,
            self.class
        )?;
        writeln!(f, "  form: {}; ends: {}", self.form_removal, self.end_rule)?;
        writeln!(
            f,
            "  {nx} x {ny} points every {dx:.4} x {dy:.4} µm over {x:.4} x {y:.4} mm; lay {} degrees from x; pitch {} mm",
            or_none(self.lay_deg, 1),
            or_none(self.pitch_mm, 4)
        )?;
        let rows: &[Row<ArealValues>] = &[
            ("Sa", |v| format!("{:.4}", v.sa_um), "µm"),
            ("Sq", |v| format!("{:.4}", v.sq_um), "µm"),
            ("Sp", |v| format!("{:.4}", v.sp_um), "µm"),
            ("Sv", |v| format!("{:.4}", v.sv_um), "µm"),
            ("Sz", |v| format!("{:.4}", v.sz_um), "µm"),
            ("Ssk", |v| format!("{:.4}", v.ssk), ""),
            ("Sku", |v| format!("{:.4}", v.sku), ""),
            ("Sdq", |v| format!("{:.6}", v.sdq), ""),
            ("Sdr", |v| format!("{:.6}", v.sdr_percent), "percent"),
            ("Sal", |v| or_none(v.sal_mm, 4), "mm"),
            ("Str", |v| or_none(v.str, 4), ""),
            ("Std", |v| or_none(v.std_deg, 1), "degrees"),
        ];
        table(f, rows, self.filtered.as_ref(), &self.unfiltered)?;
        reasons(f, &self.unchecked, &self.remarks)
    }
}
