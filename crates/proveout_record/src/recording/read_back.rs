//! A recording read back: its entities, their rows and the values of plots. Tests compare them with the
//! run.

use std::{collections::BTreeMap, fs::File, io::BufReader, path::Path};

use rerun::{
    StoreKind,
    external::{re_log_encoding::DecoderApp, re_log_types::LogMsg},
    log::Chunk,
};

use crate::{error::RecordError, recording::sink::TIMELINE};

/// Seconds of a nanosecond.
const S_PER_NS: f64 = 1e-9;

/// What a recording has of one entity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedEntity {
    /// Rows over time; what is there for all times has none.
    pub rows: usize,
    /// Time (s, not a number for values of all times) and value of a signal, in the order of the recording.
    pub values: Vec<[f64; 2]>,
    /// Directions of arrows, those of all rows.
    pub arrows: Vec<[f32; 3]>,
    /// Positions of points, likewise.
    pub points: Vec<[f32; 3]>,
    /// Text of a page.
    pub text: Option<String>,
}

/// The entities of a recording by their paths, without its layout.
///
/// # Errors
/// [`RecordError::Io`] when the file cannot be read, [`RecordError::Recording`] when it is no recording.
pub fn read_recording(file: &Path) -> Result<BTreeMap<String, RecordedEntity>, RecordError> {
    let fault = |message: String| RecordError::Recording { target: file.display().to_string(), message, remedy: None };
    let reader = BufReader::new(File::open(file).map_err(RecordError::io(file))?);
    let mut all: BTreeMap<String, RecordedEntity> = BTreeMap::new();
    for message in DecoderApp::decode_eager(reader).map_err(|e| fault(e.to_string()))? {
        let message = message.map_err(|e| fault(e.to_string()))?;
        let LogMsg::ArrowMsg(store, arrow) = message else { continue };
        if store.kind() != StoreKind::Recording {
            continue;
        }
        let chunk = Chunk::from_arrow_msg(&arrow).map_err(|e| fault(e.to_string()))?;
        take(all.entry(chunk.entity_path().to_string()).or_default(), &chunk);
    }
    Ok(all)
}

fn take(entity: &mut RecordedEntity, chunk: &Chunk) {
    let times = chunk.timelines().get(&TIMELINE.into()).map(rerun::TimeColumn::times_raw);
    if !chunk.is_static() {
        entity.rows += chunk.num_rows();
    }
    let scalars = chunk.iter_slices::<f64>(rerun::Scalars::descriptor_scalars().component);
    for (row, values) in scalars.enumerate() {
        let time = times.and_then(|t| t.get(row)).map_or(f64::NAN, |t| *t as f64 * S_PER_NS);
        entity.values.extend(values.iter().map(|v| [time, *v]));
    }
    for arrows in chunk.iter_slices::<[f32; 3]>(rerun::Arrows3D::descriptor_vectors().component) {
        entity.arrows.extend_from_slice(arrows);
    }
    for points in chunk.iter_slices::<[f32; 3]>(rerun::Points3D::descriptor_positions().component) {
        entity.points.extend_from_slice(points);
    }
    for texts in chunk.iter_slices::<String>(rerun::TextDocument::descriptor_text().component) {
        entity.text = texts.first().map(|text| text.to_string()).or(entity.text.take());
    }
}
