//! `inspection.qif`: the measured features as results of the Quality Information Framework (QIF 3.0,
//! ANSI/DMSC and ISO 23952:2020), for programs that read measuring records.
//!
//! Each feature of a scene becomes a characteristic and a feature of the document:
//!
//! - **touch**: a linear coordinate along X, Y or Z, with its tolerance to both sides; a point with its
//!   nominal and its measured place, workpiece frame, mm
//! - **thickness**: a thickness, with its tolerance to both sides; no feature
//!
//! *What was checked.* Names, order and attributes of the elements of the document, below `Results` and of
//! the base types of characteristics, against `QIFDocument.xsd`, `QIFResults.xsd` and `Characteristics.xsd`
//! of QIF 3.0 (DMSC; files of the community's repository); those of point features against the types that
//! another program has generated from the schemas. A test checks each document against these orders, its
//! counts and its references with an XML reader. No document was validated with the whole schemas by a
//! program.
//!
//! A feature whose probe met no surface has its item and no measurement, and fails the whole. Identifiers of
//! the document are digests of what it says, so that the same run gives the same bytes.

use std::fmt::Write as _;

use proveout_sim::{
    digest::sha256,
    scene::{InspectFile, InspectKindFile, probe_direction},
    verdict::Inspected,
};

use crate::chart::escape;

/// Ids that a feature takes at most.
const IDS: usize = 10;

/// A number as XML Schema has it.
fn number(v: f64) -> String {
    format!("{v:.6}")
}

/// A name in one line, escaped.
fn name_of(text: &str) -> String {
    escape(&text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>())
}

/// A UUID (RFC 9562, version 8) of a text.
fn uuid(text: &str) -> String {
    let digest = sha256(text.as_bytes());
    let mut b = [0_u8; 16];
    b.iter_mut().zip(&digest).for_each(|(to, from)| *to = *from);
    b[6] = b[6] & 0x0f | 0x80;
    b[8] = b[8] & 0x3f | 0x80;
    let hex: String = b.iter().map(|v| format!("{v:02x}")).collect();
    format!("{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

/// What the scene says of a feature.
pub(crate) struct PlannedFeature {
    from: [f64; 3],
    /// Along which axis the probe goes, and whether up (1) or down (-1).
    axis: usize,
    sign: f64,
    thickness: bool,
}

impl From<&InspectFile> for PlannedFeature {
    fn from(file: &InspectFile) -> Self {
        let (axis, sign) = probe_direction(file.direction.get_ref()).unwrap_or((2, 1.0));
        Self { from: *file.from_mm.get_ref(), axis, sign, thickness: matches!(file.kind, InspectKindFile::Thickness) }
    }
}

/// One feature with what the scene says of it.
struct QifFeature<'a> {
    measured: &'a Inspected,
    thickness: bool,
    axis: usize,
    /// Where its surface should be.
    nominal: [f64; 3],
    /// Out of the material.
    normal: [f64; 3],
    /// First of its ids.
    id: usize,
}

impl<'a> QifFeature<'a> {
    fn of(measured: &'a Inspected, plan: &PlannedFeature, id: usize) -> Self {
        let axis = plan.axis;
        let mut nominal = plan.from;
        if !plan.thickness {
            nominal[axis] = measured.nominal_mm;
        }
        let mut normal = [0.0; 3];
        normal[axis] = -plan.sign;
        Self { measured, thickness: plan.thickness, axis, nominal, normal, id }
    }

    fn value(&self) -> Option<f64> {
        self.measured.measured_mm.filter(|v| v.is_finite())
    }

    fn passes(&self) -> bool {
        self.value().is_some_and(|v| (v - self.measured.nominal_mm).abs() <= self.measured.tolerance_mm)
    }

    fn characteristic(&self) -> &'static str {
        if self.thickness { "ThicknessCharacteristic" } else { "LinearCoordinateCharacteristic" }
    }
}

fn vector(v: [f64; 3]) -> String {
    v.map(number).join(" ")
}

/// A list with its count; none where it is empty, which the schema does not allow.
fn list(out: &mut String, tag: &str, parts: &[String]) {
    if !parts.is_empty() {
        let _ = writeln!(out, "<{tag} n=\"{}\">\n{}</{tag}>", parts.len(), parts.concat());
    }
}

/// The document. `plan` are the features of the scene in the order of `features`; `None` where there is
/// nothing to report.
pub(crate) fn inspection_qif(features: &[Inspected], plan: &[PlannedFeature], run: &str) -> Option<String> {
    if features.is_empty() || features.len() != plan.len() {
        return None;
    }
    let all: Vec<QifFeature<'_>> =
        features.iter().zip(plan).enumerate().map(|(i, (m, f))| QifFeature::of(m, f, 1 + i * IDS)).collect();
    let points: Vec<&QifFeature<'_>> = all.iter().filter(|o| !o.thickness).collect();
    let last = 1 + all.len() * IDS;
    let mut body = String::new();
    if !points.is_empty() {
        body += "<Features>\n";
        let definitions: Vec<String> =
            points.iter().map(|o| format!("<PointFeatureDefinition id=\"{}\"/>\n", o.id)).collect();
        list(&mut body, "FeatureDefinitions", &definitions);
        let nominals: Vec<String> = points
            .iter()
            .map(|o| {
                format!(
                    "<PointFeatureNominal id=\"{}\"><FeatureDefinitionId>{}</FeatureDefinitionId><Location>{}</Location><Normal>{}</Normal></PointFeatureNominal>\n",
                    o.id + 1,
                    o.id,
                    vector(o.nominal),
                    vector(o.normal)
                )
            })
            .collect();
        list(&mut body, "FeatureNominals", &nominals);
        let items: Vec<String> = points
            .iter()
            .map(|o| {
                format!(
                    "<PointFeatureItem id=\"{}\"><FeatureNominalId>{}</FeatureNominalId><FeatureName>{}</FeatureName><DeterminationMode><Checked>\
                     <CheckDetails><Measured/></CheckDetails></Checked></DeterminationMode></PointFeatureItem>\n",
                    o.id + 2,
                    o.id + 1,
                    name_of(&o.measured.name)
                )
            })
            .collect();
        list(&mut body, "FeatureItems", &items);
        body += "</Features>\n";
    }
    characteristics(&mut body, &all);
    let state = |pass: bool| if pass { "PASS" } else { "FAIL" };
    let mut results = String::new();
    let places: Vec<String> = points
        .iter()
        .filter_map(|o| {
            let mut place = o.nominal;
            place[o.axis] = o.value()?;
            Some(format!(
                "<PointFeatureMeasurement id=\"{}\"><FeatureItemId>{}</FeatureItemId><Location>{}</Location></PointFeatureMeasurement>\n",
                o.id + 6,
                o.id + 2,
                vector(place)
            ))
        })
        .collect();
    list(&mut results, "MeasuredFeatures", &places);
    let values: Vec<String> = all
        .iter()
        .filter_map(|o| {
            let (kind, value) = (o.characteristic(), o.value()?);
            let of_point = if o.thickness {
                String::new()
            } else {
                format!("<FeatureMeasurementIds n=\"1\"><Id>{}</Id></FeatureMeasurementIds>", o.id + 6)
            };
            let axes = if o.thickness {
                ""
            } else {
                "<TypeOfCoordinates><CoordinateEnum>CARTESIAN_3D</CoordinateEnum></TypeOfCoordinates>"
            };
            Some(format!(
                "<{kind}Measurement id=\"{}\"><Status><CharacteristicStatusEnum>{}</CharacteristicStatusEnum></Status><CharacteristicItemId>{}</CharacteristicItemId>\
                 {of_point}<Value>{}</Value>{axes}</{kind}Measurement>\n",
                o.id + 7,
                state(o.passes()),
                o.id + 5,
                number(value)
            ))
        })
        .collect();
    if !values.is_empty() {
        results += "<MeasuredCharacteristics>\n";
        list(&mut results, "CharacteristicMeasurements", &values);
        results += "</MeasuredCharacteristics>\n";
    }
    let whole = state(all.iter().all(QifFeature::passes));
    let ids = [uuid(&format!("document {run}\n{body}{results}")), uuid(&format!("results {run}\n{body}{results}"))];
    Some(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <QIFDocument xmlns=\"http://qifstandards.org/xsd/qif3\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"http://qifstandards.org/xsd/qif3 http://qifstandards.org/xsd/qif3/QIFApplications/QIFDocument.xsd\" versionQIF=\"3.0.0\" idMax=\"{last}\">\n\
         <QPId>{}</QPId>\n<Header><Application><Name>proveout</Name></Application></Header>\n\
         <FileUnits><PrimaryUnits>\n\
         <AngularUnit><SIUnitName>radian</SIUnitName><UnitName>radian</UnitName></AngularUnit>\n\
         <LinearUnit><SIUnitName>meter</SIUnitName><UnitName>mm</UnitName><UnitConversion><Factor>0.001</Factor></UnitConversion></LinearUnit>\n\
         </PrimaryUnits></FileUnits>\n{body}<Results>\n<MeasurementResultsSet n=\"1\">\n<MeasurementResults id=\"{last}\">\n\
         <ThisResultsInstanceQPId>{}</ThisResultsInstanceQPId>\n{results}\
         <InspectionStatus><InspectionStatusEnum>{whole}</InspectionStatusEnum></InspectionStatus>\n\
         </MeasurementResults>\n</MeasurementResultsSet>\n</Results>\n</QIFDocument>\n",
        ids[0], ids[1]
    ))
}

fn characteristics(body: &mut String, all: &[QifFeature<'_>]) {
    *body += "<Characteristics>\n";
    let definitions: Vec<String> = all
        .iter()
        .map(|o| {
            let (kind, t) = (o.characteristic(), number(o.measured.tolerance_mm));
            format!(
                "<{kind}Definition id=\"{}\"><Tolerance><MaxValue>{t}</MaxValue><MinValue>-{t}</MinValue><DefinedAsLimit>false</DefinedAsLimit></Tolerance></{kind}Definition>\n",
                o.id + 3
            )
        })
        .collect();
    list(body, "CharacteristicDefinitions", &definitions);
    let nominals: Vec<String> = all
        .iter()
        .map(|o| {
            let kind = o.characteristic();
            let along = if o.thickness {
                ""
            } else {
                [
                    "<Direction>XAXIS</Direction>",
                    "<Direction>YAXIS</Direction>",
                    "<Direction>ZAXIS</Direction>",
                ][o.axis]
            };
            format!(
                "<{kind}Nominal id=\"{}\"><CharacteristicDefinitionId>{}</CharacteristicDefinitionId><TargetValue>{}</TargetValue>{along}</{kind}Nominal>\n",
                o.id + 4,
                o.id + 3,
                number(o.measured.nominal_mm)
            )
        })
        .collect();
    list(body, "CharacteristicNominals", &nominals);
    let items: Vec<String> = all
        .iter()
        .map(|o| {
            let (kind, name) = (o.characteristic(), name_of(&o.measured.name));
            let of_point = if o.thickness {
                String::new()
            } else {
                format!("<FeatureItemIds n=\"1\"><Id>{}</Id></FeatureItemIds>", o.id + 2)
            };
            format!(
                "<{kind}Item id=\"{}\"><Name>{name}</Name>{of_point}<CharacteristicNominalId>{}</CharacteristicNominalId></{kind}Item>\n",
                o.id + 5,
                o.id + 4
            )
        })
        .collect();
    list(body, "CharacteristicItems", &items);
    *body += "</Characteristics>\n";
}

#[cfg(test)]
mod tests;
