//! Plain data to a Rerun recording: meshes, poses, signals, lines, text.

use proveout_geom::Pose;
use rerun::{EntityPath, RecordingStream, TimeColumn, components::InterpolationMode};

use crate::{color::Rgba, error::RecordError, picture::Picture, units::UM_PER_MM};

/// The timeline of every recording: simulated time as a duration.
pub(crate) const TIMELINE: &str = "sim_time";
/// The timeline of the program: number of the executed block, as in `blocks.parquet`. Lines repeat in loops
/// and subprograms, and would be no clock; file and line of each block are on the entity `/program/block`.
pub(crate) const BLOCK_TIMELINE: &str = "nc_block";
/// The timeline of what lies along a path: its way in micrometers, a whole number.
pub(crate) const WAY_TIMELINE: &str = "path_um";
/// Application of every recording; blueprints bind to it.
pub(crate) const APPLICATION: &str = "proveout";
/// Nanoseconds of a second.
const NS_PER_S: f64 = 1e9;

/// A recording that is being written.
pub(crate) struct Sink {
    pub(crate) stream: RecordingStream,
    pub(crate) target: String,
    clock: BlockClock,
}

/// When the blocks of the run begin, as far as they are known.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockClock {
    /// Time (s) and number, rising.
    begins: Vec<(f64, u32)>,
}

impl BlockClock {
    /// The next piece of motion: its begin and its block.
    pub(crate) fn push(&mut self, time: f64, block: u32) {
        if self.begins.last().is_none_or(|(before, last)| *last < block && *before <= time) && time.is_finite() {
            self.begins.push((time, block));
        }
    }

    /// The block that runs at a time; the first one before all.
    fn at(&self, time: f64) -> i64 {
        let n = self.begins.partition_point(|(begin, _)| *begin <= time);
        self.begins.get(n.saturating_sub(1)).map_or(0, |(_, block)| i64::from(*block))
    }
}

/// Level of a line of the text log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LogLevel {
    Error,
    Warn,
    Info,
    Debug,
}

/// Position of something along a path: time in the program that runs, s, and path length, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathPosition {
    pub(crate) time: f64,
    pub(crate) way: f64,
}

/// How a line of a plot looks.
pub(crate) struct LineStyle {
    pub(crate) name: String,
    pub(crate) color: Rgba,
    pub(crate) width: f32,
}

/// Arrows of one color: begins and directions, mm.
pub(crate) struct Arrows {
    pub(crate) from: Vec<[f32; 3]>,
    pub(crate) along: Vec<[f32; 3]>,
    pub(crate) color: Rgba,
}

/// Strips of one color and width, in points of the screen.
pub(crate) type Strips = (Vec<Vec<[f32; 3]>>, Rgba, f32);

/// Path of an entity from its parts, whatever characters they have.
pub(crate) fn path<'a>(parts: impl IntoIterator<Item = &'a str>) -> EntityPath {
    EntityPath::new(parts.into_iter().map(rerun::EntityPathPart::new).collect())
}

fn nanoseconds(time: f64) -> i64 {
    (time * NS_PER_S).round() as i64
}

fn times(list: impl IntoIterator<Item = f64>) -> TimeColumn {
    TimeColumn::new_duration_nanos(TIMELINE, list.into_iter().map(nanoseconds))
}

fn both_times(places: &[PathPosition]) -> [TimeColumn; 2] {
    let ways = places.iter().map(|p| (p.way * UM_PER_MM).round() as i64);
    [times(places.iter().map(|p| p.time)), TimeColumn::new_sequence(WAY_TIMELINE, ways)]
}

fn rgb(color: Rgba) -> rerun::Color {
    rerun::Color::from_rgb(color[0], color[1], color[2])
}

impl Sink {
    pub(crate) fn new(stream: RecordingStream, target: String) -> Self {
        stream.set_log_tick_enabled(false);
        stream.set_log_time_enabled(false);
        Self { stream, target, clock: BlockClock::default() }
    }

    /// Takes the blocks of a stretch, before anything of it is logged.
    pub(crate) fn clock(&mut self) -> &mut BlockClock {
        &mut self.clock
    }

    /// Columns of simulated time, and of the block that runs then.
    fn times(&self, list: impl IntoIterator<Item = f64>) -> [TimeColumn; 2] {
        let list: Vec<f64> = list.into_iter().collect();
        let blocks: Vec<i64> = list.iter().map(|t| self.clock.at(*t)).collect();
        [times(list), TimeColumn::new_sequence(BLOCK_TIMELINE, blocks)]
    }

    pub(crate) fn fault(&self, message: impl std::fmt::Display) -> RecordError {
        RecordError::Recording { target: self.target.clone(), message: message.to_string(), remedy: None }
    }

    /// Logs at a time, or for all times.
    fn log(&self, path: EntityPath, time: Option<f64>, what: &impl rerun::AsComponents) -> Result<(), RecordError> {
        let done = match time {
            None => self.stream.log_static(path, what),
            Some(t) => {
                self.stream.set_time(TIMELINE, rerun::TimeCell::from_duration_nanos(nanoseconds(t)));
                self.stream.set_time(BLOCK_TIMELINE, rerun::TimeCell::from_sequence(self.clock.at(t)));
                self.stream.log(path, what)
            }
        };
        done.map_err(|e| self.fault(e))
    }

    /// Frame of the numbers below `path`: right-handed, Z up.
    pub(crate) fn z_up(&self, path: EntityPath) -> Result<(), RecordError> {
        self.log(path, None, &rerun::ViewCoordinates::RIGHT_HAND_Z_UP())
    }

    /// A mesh of one color, or with `colors` a vertex. Without triangles the entity becomes empty at that
    /// time.
    pub(crate) fn mesh(
        &self,
        path: EntityPath,
        time: Option<f64>,
        picture: &Picture,
        plain: Rgba,
        colors: &[Rgba],
    ) -> Result<(), RecordError> {
        if picture.triangles.is_empty() {
            return self.log(path, time, &rerun::Mesh3D::clear_fields());
        }
        let color = |c: &Rgba| rerun::Color::from_unmultiplied_rgba(c[0], c[1], c[2], c[3]);
        let mut mesh = rerun::Mesh3D::new(picture.positions.iter().copied())
            .with_vertex_normals(picture.normals.iter().copied())
            .with_triangle_indices(
                picture.triangles.iter().map(|t| rerun::TriangleIndices(rerun::datatypes::UVec3D(*t))),
            );
        mesh = if colors.is_empty() {
            mesh.with_albedo_factor(color(&plain).0)
        } else {
            mesh.with_vertex_colors(colors.iter().map(color))
        };
        self.log(path, time, &mesh)
    }

    /// Meshes of one entity over time, each in the place of the one before; one without triangles leaves the
    /// entity empty. All of them are one piece of the recording: a piece costs as much as a thousand
    /// triangles.
    pub(crate) fn meshes(&self, path: EntityPath, rows: &[(f64, Picture)], plain: Rgba) -> Result<(), RecordError> {
        let shown = || rows.iter().map(|(_, picture)| picture);
        let lengths = |of: fn(&Picture) -> usize| -> Vec<usize> {
            shown().map(|p| if p.triangles.is_empty() { 0 } else { of(p) }).collect()
        };
        let full = || shown().filter(|p| !p.triangles.is_empty());
        let color = rerun::Color::from_unmultiplied_rgba(plain[0], plain[1], plain[2], plain[3]);
        let indices = full().flat_map(|p| &p.triangles).map(|t| rerun::TriangleIndices(rerun::datatypes::UVec3D(*t)));
        let all = rerun::Mesh3D::new(full().flat_map(|p| p.positions.iter().copied()))
            .with_vertex_normals(full().flat_map(|p| p.normals.iter().copied()))
            .with_triangle_indices(indices)
            .with_many_albedo_factor(full().map(|_| color.0));
        let parts = [
            (all.vertex_positions, lengths(|p| p.positions.len())),
            (all.vertex_normals, lengths(|p| p.normals.len())),
            (all.triangle_indices, lengths(|p| p.triangles.len())),
            (all.albedo_factor, lengths(|_| 1)),
        ];
        let columns = parts
            .into_iter()
            .filter_map(|(part, lengths)| part.map(|part| part.partitioned(lengths)))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|e| self.fault(e))?;
        self.stream.send_columns(path, self.times(rows.iter().map(|r| r.0)), columns).map_err(|e| self.fault(e))
    }

    /// A pose for all times.
    pub(crate) fn pose(&self, path: EntityPath, pose: &Pose) -> Result<(), RecordError> {
        let (t, q) = parts(pose);
        let what = rerun::Transform3D::new().with_translation(t).with_quaternion(rerun::Quaternion::from_xyzw(q));
        self.log(path, None, &what)
    }

    /// Poses over time.
    pub(crate) fn poses(&self, path: EntityPath, rows: &[(f64, Pose)]) -> Result<(), RecordError> {
        if rows.is_empty() {
            return Ok(());
        }
        let columns = rerun::Transform3D::update_fields()
            .with_many_translation(rows.iter().map(|(_, p)| rerun::components::Translation3D::from(parts(p).0)))
            .with_many_quaternion(
                rows.iter().map(|(_, p)| rerun::components::RotationQuat(rerun::Quaternion::from_xyzw(parts(p).1))),
            )
            .columns_of_unit_batches()
            .map_err(|e| self.fault(e))?;
        let times = self.times(rows.iter().map(|r| r.0));
        self.stream.send_columns(path, times, columns).map_err(|e| self.fault(e))
    }

    /// Name and color of the line of a signal in plots; `steps` for a signal that holds its value until the
    /// next one.
    pub(crate) fn signal_style(
        &self,
        path: EntityPath,
        name: &str,
        color: Rgba,
        steps: bool,
    ) -> Result<(), RecordError> {
        let style = rerun::SeriesLines::new()
            .with_names([name])
            .with_widths([1.5_f32])
            // The default mean over a pixel would hide the peaks that were kept.
            .with_aggregation_policy(rerun::components::AggregationPolicy::MinMax)
            .with_interpolation_mode(if steps { InterpolationMode::StepAfter } else { InterpolationMode::Linear })
            .with_colors([rerun::Color::from_rgb(color[0], color[1], color[2])]);
        self.log(path, None, &style)
    }

    /// Values over time.
    pub(crate) fn signal(&self, path: EntityPath, rows: &[(f64, f64)]) -> Result<(), RecordError> {
        if rows.is_empty() {
            return Ok(());
        }
        let columns =
            rerun::Scalars::new(rows.iter().map(|r| r.1)).columns_of_unit_batches().map_err(|e| self.fault(e))?;
        let times = self.times(rows.iter().map(|r| r.0));
        self.stream.send_columns(path, times, columns).map_err(|e| self.fault(e))
    }

    /// Name, color and width of a line in plots.
    pub(crate) fn line_style(&self, path: EntityPath, style: &LineStyle) -> Result<(), RecordError> {
        let what = rerun::SeriesLines::new()
            .with_names([style.name.as_str()])
            .with_widths([style.width])
            .with_aggregation_policy(rerun::components::AggregationPolicy::MinMax)
            .with_colors([rgb(style.color)]);
        self.log(path, None, &what)
    }

    /// Name and color of points in plots.
    pub(crate) fn dots_style(&self, path: EntityPath, name: &str, color: Rgba) -> Result<(), RecordError> {
        let what = rerun::SeriesPoints::new().with_names([name]).with_marker_sizes([3.5_f32]).with_colors([rgb(color)]);
        self.log(path, None, &what)
    }

    /// Values along a path.
    pub(crate) fn values(&self, path: EntityPath, rows: &[(PathPosition, f64)]) -> Result<(), RecordError> {
        if rows.is_empty() {
            return Ok(());
        }
        let columns =
            rerun::Scalars::new(rows.iter().map(|r| r.1)).columns_of_unit_batches().map_err(|e| self.fault(e))?;
        let places: Vec<PathPosition> = rows.iter().map(|r| r.0).collect();
        self.stream.send_columns(path, both_times(&places), columns).map_err(|e| self.fault(e))
    }

    /// A point that moves along a path.
    pub(crate) fn moving_point(
        &self,
        path: EntityPath,
        rows: &[(PathPosition, [f32; 3])],
        color: Rgba,
    ) -> Result<(), RecordError> {
        if rows.is_empty() {
            return Ok(());
        }
        let look =
            rerun::Points3D::update_fields().with_colors([rgb(color)]).with_radii([rerun::Radius::new_ui_points(6.0)]);
        self.log(path.clone(), None, &look)?;
        let columns = rerun::Points3D::update_fields()
            .with_positions(rows.iter().map(|r| r.1))
            .columns_of_unit_batches()
            .map_err(|e| self.fault(e))?;
        let places: Vec<PathPosition> = rows.iter().map(|r| r.0).collect();
        self.stream.send_columns(path, both_times(&places), columns).map_err(|e| self.fault(e))
    }

    /// Lines for all times.
    pub(crate) fn static_lines(&self, path: EntityPath, groups: &[Strips]) -> Result<(), RecordError> {
        let each = || groups.iter().flat_map(|(strips, color, width)| strips.iter().map(move |s| (s, *color, *width)));
        let what = rerun::LineStrips3D::new(each().map(|(strip, ..)| strip.iter().copied()))
            .with_colors(each().map(|(_, color, _)| rgb(color)))
            .with_radii(each().map(|(.., width)| rerun::Radius::new_ui_points(0.5 * width)));
        self.log(path, None, &what)
    }

    /// Places with text, for all times.
    pub(crate) fn labels(
        &self,
        path: EntityPath,
        points: &[([f64; 3], String)],
        color: Rgba,
    ) -> Result<(), RecordError> {
        let what = rerun::Points3D::new(points.iter().map(|(p, _)| p.map(|v| v as f32)))
            .with_labels(points.iter().map(|(_, l)| l.as_str()))
            .with_show_labels(true)
            .with_colors([rgb(color)])
            .with_radii([rerun::Radius::new_ui_points(2.5)]);
        self.log(path, None, &what)
    }

    /// A solid ball about the origin, for all times.
    pub(crate) fn ball(&self, path: EntityPath, radius: f32, color: Rgba) -> Result<(), RecordError> {
        let what = rerun::Ellipsoids3D::from_radii([radius])
            .with_colors([rgb(color)])
            .with_fill_mode(rerun::components::FillMode::Solid);
        self.log(path, None, &what)
    }

    /// Arrows for all times.
    pub(crate) fn arrows(&self, path: EntityPath, arrows: &Arrows) -> Result<(), RecordError> {
        let what = rerun::Arrows3D::from_vectors(arrows.along.iter().copied())
            .with_origins(arrows.from.iter().copied())
            .with_colors([rgb(arrows.color)])
            .with_radii([rerun::Radius::new_ui_points(0.8)]);
        self.log(path, None, &what)
    }

    /// Lines, each with its color.
    pub(crate) fn lines(
        &self,
        path: EntityPath,
        time: f64,
        strips: &[(Vec<[f32; 3]>, Rgba)],
    ) -> Result<(), RecordError> {
        let what = rerun::LineStrips3D::new(strips.iter().map(|(points, _)| points.iter().copied()))
            .with_colors(strips.iter().map(|(_, c)| rerun::Color::from_rgb(c[0], c[1], c[2])))
            .with_radii([rerun::Radius::new_ui_points(0.75)]);
        self.log(path, Some(time), &what)
    }

    /// Marked points with their labels.
    pub(crate) fn marks(
        &self,
        path: EntityPath,
        time: f64,
        points: &[([f64; 3], String)],
        color: Rgba,
    ) -> Result<(), RecordError> {
        let what = rerun::Points3D::new(points.iter().map(|(p, _)| p.map(|v| v as f32)))
            .with_labels(points.iter().map(|(_, l)| l.as_str()))
            .with_show_labels(false)
            .with_colors([rerun::Color::from_rgb(color[0], color[1], color[2])])
            .with_radii([rerun::Radius::new_ui_points(5.0)]);
        self.log(path, Some(time), &what)
    }

    /// A line of the text log.
    pub(crate) fn text(&self, path: EntityPath, time: f64, level: LogLevel, text: &str) -> Result<(), RecordError> {
        let level = match level {
            LogLevel::Error => rerun::TextLogLevel::ERROR,
            LogLevel::Warn => rerun::TextLogLevel::WARN,
            LogLevel::Info => rerun::TextLogLevel::INFO,
            LogLevel::Debug => rerun::TextLogLevel::DEBUG,
        };
        self.log(path, Some(time), &rerun::TextLog::new(text).with_level(level))
    }

    /// A page of Markdown for all times.
    pub(crate) fn document(&self, path: EntityPath, text: String) -> Result<(), RecordError> {
        self.log(path, None, &rerun::TextDocument::from_markdown(text))
    }

    /// Pages of plain text over time.
    pub(crate) fn pages(&self, path: EntityPath, rows: &[(f64, String)]) -> Result<(), RecordError> {
        if rows.is_empty() {
            return Ok(());
        }
        let columns = rerun::TextDocument::update_fields()
            .with_many_text(rows.iter().map(|(_, text)| text.as_str()))
            .columns_of_unit_batches()
            .map_err(|e| self.fault(e))?;
        let times = self.times(rows.iter().map(|r| r.0));
        self.stream.send_columns(path, times, columns).map_err(|e| self.fault(e))
    }

    /// Waits until all is written.
    pub(crate) fn finish(self) -> Result<(), RecordError> {
        let flushed = self.stream.flush_blocking().map_err(|e| self.fault(e));
        self.stream.finalize_deferred_sinks();
        flushed
    }
}

/// Translation (mm) and quaternion x y z w, single precision.
fn parts(pose: &Pose) -> ([f32; 3], [f32; 4]) {
    let isometry = pose.to_isometry();
    let t = isometry.translation.vector;
    let q = isometry.rotation.coords;
    ([t.x as f32, t.y as f32, t.z as f32], [q.x as f32, q.y as f32, q.z as f32, q.w as f32])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_in_the_block_that_began_last() {
        let mut clock = BlockClock::default();
        assert_eq!(clock.at(3.0), 0);
        for (time, block) in [(1.0, 0), (1.5, 0), (2.0, 1), (2.0, 2), (1.9, 3), (f64::NAN, 4), (4.0, 7), (5.0, 6)] {
            clock.push(time, block);
        }
        let at = [0.0, 1.99, 2.0, 3.9, 4.0, 99.0].map(|t| clock.at(t));
        assert_eq!(at, [0, 0, 2, 2, 7, 7]);
    }
}
