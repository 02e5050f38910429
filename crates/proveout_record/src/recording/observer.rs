mod limits;

use std::{collections::BTreeMap, path::Path};

use proveout_controller::{Dynamics, Event, MoveKind};
use proveout_machine::{Attachment, JointValues};
use proveout_sim::{
    Observer, SurfaceShape, SurfaceTexture,
    finding::{Finding, Severity},
    free_axes::FreeAxes,
    observer::{Batch, MeshPart, ObserverError, Outcome, PointBand, Setup},
    schedule::Schedule,
};
use proveout_stock::{Patch, TriDexel};
use proveout_tool::Tool;
use rerun::{EntityPath, RecordingStreamBuilder};

use crate::{
    color::{Rgba, STEEL},
    error::RecordError,
    in_process::{
        CREASE,
        frames::{FrameCollector, RecordingFrame},
        tiles::StockTiles,
        tool_pictures::tool_pictures,
    },
    part::{MAP_SIDE, MOST_MAPS, colors_of, range_floor},
    picture::Picture,
    recording::{
        about::{about, boxes},
        axis_caps::caps,
        block_text::BlockTexts,
        blueprint::{self, Layout},
        schedule::{self, ScheduleViews},
        signal_thinning::MotionThinner,
        sink::{APPLICATION, LogLevel, Sink, path},
        trace::{Trace, class_of},
        tracks::{MotionSource, MovedEntity, Signal},
    },
    report::{format::tool_name, rows::symbol},
    rerun_mode::{RECORDING_FILE, RerunMode},
    roughness_map::{ShownTexture, range_of},
    surface_picture::{ShownSurface, SurfacePicture},
    units::{JointUnit, PER_MINUTE},
};

/// Triangles of the first picture of a stock, about.
const STOCK_TRIANGLES: f64 = 150_000.0;
/// Most triangles of the surface at the end.
const SURFACE_TRIANGLES: usize = 400_000;
/// Rows of a column that are gathered before they are sent.
const CHUNK: usize = 4096;
/// Stretches of time in which the tip's path is shown piece by piece.
const PATH_BINS: usize = 24;
/// Places of findings that are marked.
const MARKS: usize = 300;
/// Least part of a program that counts as done: the expected end stays a number.
const LEAST_DONE: f64 = 1e-6;

/// Path in feed by the class of the feed that is reached, from all of it to less than a fifth.
const FEED_COLORS: [Rgba; 6] = [
    [64, 148, 232, 255],
    [70, 190, 190, 255],
    [110, 190, 90, 255],
    [230, 200, 60, 255],
    [240, 130, 50, 255],
    [226, 60, 60, 255],
];
const RAPID_COLOR: Rgba = [150, 150, 165, 255];
const FINDING_COLOR: Rgba = [230, 60, 70, 255];
const FIXTURE_COLOR: Rgba = [120, 128, 140, 255];
const LOOSE_COLOR: Rgba = [200, 120, 70, 255];
const PART_COLOR: Rgba = [110, 170, 130, 255];
/// Lines of plots: six hues of about the same lightness.
const LINES: [Rgba; 6] = [
    [222, 95, 95, 255],
    [98, 178, 106, 255],
    [90, 150, 230, 255],
    [222, 170, 70, 255],
    [176, 120, 210, 255],
    [80, 190, 195, 255],
];

/// Signals of a joint's motion.
const MOTION: [&str; 4] = ["position", "velocity", "acceleration", "jerk"];
/// Signals of a joint's drive.
const DRIVE: [&str; 3] = ["following_error", "force", "power"];

/// Writes `recording.rrd`, or sends the same to a viewer while the run goes on.
pub struct RerunObserver {
    mode: RerunMode,
    open: Option<OpenRecording>,
}

impl RerunObserver {
    /// An observer for a mode; with [`RerunMode::Off`] it does nothing.
    pub fn new(mode: RerunMode) -> Self {
        Self { mode, open: None }
    }
}

/// State of a recording.
struct OpenRecording {
    sink: Sink,
    live: bool,
    units: Vec<JointUnit>,
    thinner: MotionThinner,
    movers: Vec<MovedEntity>,
    /// Set points of each joint with three derivatives.
    joints: Vec<[Signal; 4]>,
    /// Following error, force and power of the drives; none where they are not simulated.
    drives: Vec<[Signal; 3]>,
    process: [Signal; 4],
    tool: Option<usize>,
    /// Of the stock, then of each patch.
    tiles: Vec<StockTiles>,
    patches: Vec<String>,
    frames: FrameCollector<Picture>,
    trace: Trace,
    /// Feed class at the newest sample that was compared with a piece of the path.
    class: usize,
    marks: Vec<([f64; 3], String)>,
    last_joints: Option<(f64, JointValues)>,
    surface: SurfacePicture,
    textures: Vec<ShownTexture>,
    axes: Vec<(f64, Picture, Vec<Rgba>)>,
    texts: BlockTexts,
    /// The layout is sent; that of a re-scheduled program waits for its schedule.
    laid_out: bool,
}

fn start(mode: &RerunMode, name: &str, folder: &Path) -> Result<Option<Sink>, RecordError> {
    let file = folder.join(RECORDING_FILE);
    let target = match mode {
        RerunMode::Off => return Ok(None),
        RerunMode::File => file.display().to_string(),
        RerunMode::Spawn => "a new viewer".to_owned(),
        RerunMode::Connect => format!("the viewer at {}", rerun::DEFAULT_CONNECT_URL),
    };
    // `enabled` so that an environment variable cannot switch the recording off in silence.
    let builder = RecordingStreamBuilder::new(APPLICATION).recording_name(name).enabled(true);
    let (stream, remedy) = match mode {
        RerunMode::Spawn => {
            let remedy =
                "install the viewer of the same minor version, `cargo install rerun-cli` or `pip install rerun-sdk`";
            (builder.spawn(), Some(remedy))
        }
        RerunMode::Connect => (builder.connect_grpc(), Some("start `rerun` first")),
        RerunMode::File | RerunMode::Off => (builder.save(&file), None),
    };
    match stream {
        Ok(stream) => Ok(Some(Sink::new(stream, target))),
        Err(e) => Err(RecordError::Recording { target, message: e.to_string(), remedy }),
    }
}

impl Observer for RerunObserver {
    fn name(&self) -> &'static str {
        "rerun"
    }

    fn begin(&mut self, setup: &Setup<'_>, folder: &Path) -> Result<(), ObserverError> {
        let name = format!("{} · {}", setup.program, setup.scene.file.name);
        let Some(sink) = start(&self.mode, &name, folder)? else { return Ok(()) };
        let open = OpenRecording::begin(sink, self.mode != RerunMode::File, setup)?;
        self.open = Some(open);
        Ok(())
    }

    fn shows_schedule(&self) -> bool {
        self.open.is_some()
    }

    fn schedule(&mut self, setup: &Setup<'_>, schedule: &Schedule) -> Result<(), ObserverError> {
        match &mut self.open {
            Some(open) => Ok(open.schedule(setup, schedule)?),
            None => Ok(()),
        }
    }

    fn batch(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        match &mut self.open {
            Some(open) => Ok(open.batch(setup, batch)?),
            None => Ok(()),
        }
    }

    fn surface_points(&mut self, setup: &Setup<'_>, band: &PointBand<'_>) -> Result<(), ObserverError> {
        self.open.iter_mut().for_each(|open| open.surface.points(setup, band));
        Ok(())
    }

    fn surface_mesh(
        &mut self,
        _setup: &Setup<'_>,
        shape: &SurfaceShape,
        part: &MeshPart<'_>,
    ) -> Result<(), ObserverError> {
        self.open.iter_mut().for_each(|open| open.surface.mesh(shape, part));
        Ok(())
    }

    fn surface_texture(&mut self, _setup: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        for open in self.open.iter_mut().filter(|open| texture.map.is_some() && open.textures.len() < MOST_MAPS) {
            open.textures.push(ShownTexture::of(texture, MAP_SIDE));
        }
        Ok(())
    }

    fn free_axes(&mut self, _setup: &Setup<'_>, axes: &FreeAxes) -> Result<(), ObserverError> {
        self.open.iter_mut().for_each(|open| open.axes = caps(axes));
        Ok(())
    }

    fn end(&mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        match self.open.take() {
            Some(open) => Ok(open.end(setup, outcome)?),
            None => Ok(()),
        }
    }
}

fn stock_path(group: u32, patches: &[String]) -> EntityPath {
    let name = StockTiles::name(group, patches);
    path(["machine", "table", "work", "stock"].into_iter().chain(name.iter().map(String::as_str)))
}

impl OpenRecording {
    fn begin(sink: Sink, live: bool, setup: &Setup<'_>) -> Result<Self, RecordError> {
        let machine = setup.machine;
        let units = JointUnit::all(machine);
        sink.z_up(path(["machine"]))?;
        sink.z_up(path(["machine", "table", "work"]))?;
        for body in &machine.bodies {
            let parent = match body.attached_to {
                Attachment::Base => "base".to_owned(),
                Attachment::Joint(j) => units.get(j).map_or_else(|| "base".into(), |u| format!("axis_{}", u.name)),
            };
            let picture = Picture::creased(&body.mesh, CREASE);
            sink.mesh(path(["machine", &parent, &body.name]), None, &picture, body.color, &[])?;
        }
        for (name, mesh) in setup.fixtures {
            let picture = Picture::creased(mesh, CREASE);
            sink.mesh(path(["machine", "table", "fixtures", name]), None, &picture, FIXTURE_COLOR, &[])?;
        }
        sink.pose(path(["machine", "table", "work"]), &setup.table_from_work)?;
        if let Some(part) = setup.part {
            let picture = Picture::creased(part, CREASE).reduced(SURFACE_TRIANGLES).0;
            sink.mesh(path(["machine", "table", "work", "part"]), None, &picture, PART_COLOR, &[])?;
        }
        let mut movers = vec![
            MovedEntity::new(&["machine", "table"], MotionSource::Table),
            MovedEntity::new(&["machine", "tool"], MotionSource::Tool),
        ];
        for (j, unit) in units.iter().enumerate() {
            if machine.bodies.iter().any(|b| b.attached_to == Attachment::Joint(j)) {
                movers.push(MovedEntity::new(&["machine", &format!("axis_{}", unit.name)], MotionSource::Joint(j)));
            }
        }
        let joints: Vec<[Signal; 4]> =
            units.iter().map(|u| MOTION.map(|s| Signal::new(["axes", &u.name, s]))).collect();
        for ((signals, unit), color) in joints.iter().zip(&units).zip(LINES.iter().cycle()) {
            for (signal, per) in signals.iter().zip(["", "/s", "/s²", "/s³"]) {
                let symbol = symbol(unit.unit);
                sink.signal_style(signal.path(), &format!("{} {symbol}{per}", unit.name), *color, false)?;
            }
        }
        let servo = setup.dynamics == Dynamics::Servo;
        let with_drives = units.iter().filter(|_| servo);
        let drives: Vec<[Signal; 3]> = with_drives.map(|u| DRIVE.map(|s| Signal::new(["axes", &u.name, s]))).collect();
        for ((signals, unit), color) in drives.iter().zip(&units).zip(LINES.iter().cycle()) {
            let symbol = symbol(unit.unit);
            for (signal, symbol) in signals.iter().zip([symbol, unit.force_unit, "W"]) {
                sink.signal_style(signal.path(), &format!("{} {symbol}", unit.name), *color, false)?;
            }
        }
        let process = ["feed", "feed_programmed", "removal", "clearance"].map(|s| Signal::new(["process", s, ""]));
        let names = ["feed reached, mm/min", "feed programmed, mm/min", "removal, mm³/s", "proved clearance, mm"];
        for ((signal, name), color) in process.iter().zip(names).zip([LINES[2], LINES[3], LINES[1], LINES[4]]) {
            sink.signal_style(signal.path(), name, color, name != names[0])?;
        }
        let tiles = StockTiles::all(setup.stock, setup.patches, STOCK_TRIANGLES);
        sink.document(path(["about"]), about(setup, &tiles))?;
        let mut open = Self {
            sink,
            live,
            units,
            thinner: MotionThinner::default(),
            movers,
            joints,
            drives,
            process,
            tool: None,
            tiles,
            patches: setup.patches.iter().map(|p| p.name().to_owned()).collect(),
            frames: FrameCollector::default(),
            trace: Trace::default(),
            class: 0,
            marks: Vec::new(),
            last_joints: None,
            surface: SurfacePicture::new(SURFACE_TRIANGLES),
            textures: Vec::new(),
            axes: Vec::new(),
            texts: BlockTexts::default(),
            laid_out: false,
        };
        if setup.made.is_none_or(|made| made.runs.is_empty()) {
            open.lay_out(setup, None)?;
        }
        open.stock_frame(0.0, true, setup.stock, setup.patches)?;
        Ok(open)
    }

    fn lay_out(&mut self, setup: &Setup<'_>, schedule: Option<&ScheduleViews>) -> Result<(), RecordError> {
        let (machine, work) = boxes(setup);
        let drives = setup.dynamics == Dynamics::Servo;
        let layout = Layout { joints: &self.units, drives, live: self.live, machine, work, schedule };
        self.laid_out = true;
        blueprint::send(&self.sink, &layout)
    }

    fn schedule(&mut self, setup: &Setup<'_>, schedule: &Schedule) -> Result<(), RecordError> {
        let views = schedule::send(&self.sink, setup, schedule)?;
        self.lay_out(setup, Some(&views))
    }

    fn batch(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), RecordError> {
        if !self.laid_out {
            self.lay_out(setup, None)?;
        }
        let clock = self.sink.clock();
        batch.pieces.iter().for_each(|piece| clock.push(piece.time[0], piece.block));
        self.texts.take(setup, batch.blocks);
        let work_from_table = setup.table_from_work.inverse();
        let mut samples = batch.samples.iter().peekable();
        for piece in batch.pieces {
            let [from, to] = piece.pose.map(|p| work_from_table.point(&p.tip));
            let middle = 0.5 * (piece.time[0] + piece.time[1]);
            while let Some(sample) = samples.next_if(|s| s.time <= middle) {
                self.class = class_of(sample.feed, sample.feed_programmed);
            }
            let class = if piece.kind == MoveKind::Feed { self.class } else { 0 };
            self.trace.push(piece.kind, class, piece.time, from, to);
        }
        // Samples and events in the order of time, since a tool change moves the tip frame.
        let mut events = batch.events.iter().peekable();
        for (i, sample) in batch.samples.iter().enumerate() {
            while let Some(event) = events.next_if(|e| e.time() <= sample.time) {
                self.event(setup, event)?;
            }
            if self.thinner.take(sample.time, &sample.actual) {
                self.place(setup, sample.time, &sample.actual);
            }
            self.last_joints = Some((sample.time, sample.actual));
            for (k, (signals, unit)) in self.joints.iter_mut().zip(&self.units).enumerate() {
                let values = [sample.commanded[k], sample.velocity[k], sample.acceleration[k], sample.jerk[k]];
                for (signal, value) in signals.iter_mut().zip(values) {
                    signal.push(sample.time, value * unit.factor);
                }
            }
            if let Some(drive) = &sample.drive {
                for (k, (signals, unit)) in self.drives.iter_mut().zip(&self.units).enumerate() {
                    let following = (sample.actual[k] - sample.commanded[k]) * unit.factor;
                    let values = [following, drive.force[k] * unit.force_factor, drive.power[k]];
                    for (signal, value) in signals.iter_mut().zip(values) {
                        signal.push(sample.time, value);
                    }
                }
            }
            let beside = batch.signals.get(i).copied().unwrap_or_default();
            let programmed = if sample.kind == MoveKind::Feed { sample.feed_programmed } else { 0.0 };
            let values = [sample.feed * PER_MINUTE, programmed * PER_MINUTE, beside.removal_rate];
            for (signal, value) in self.process.iter_mut().zip(values.into_iter().chain(beside.clearance)) {
                signal.push(sample.time, value);
            }
        }
        for event in events {
            self.event(setup, event)?;
        }
        for part in batch.loose {
            let entity = path(["machine", "table", "loose", &part.name]);
            let picture = Picture::creased(&part.mesh, CREASE).reduced(SURFACE_TRIANGLES).0;
            self.sink.mesh(entity.clone(), part.track.first().map(|row| row.0), &picture, LOOSE_COLOR, &[])?;
            self.sink.poses(entity, &part.track)?;
        }
        for finding in batch.findings {
            self.finding(finding, finding.time_s.unwrap_or(batch.time))?;
        }
        let changed = std::iter::once(batch.changed_tiles).chain(batch.changed_in_patches.iter().map(Vec::as_slice));
        self.tiles.iter_mut().zip(changed).for_each(|(tiles, changed)| tiles.mark(changed));
        if let Some(row) = batch.blocks.last() {
            // The program line gives a rough estimate of the remaining time; with subprograms and loops it
            // is worse.
            let done = f64::from(row.line) / f64::from(setup.program_lines.max(1));
            self.frames.expect(batch.time, batch.time / done.clamp(LEAST_DONE, 1.0));
        }
        let tool_change = batch.events.iter().any(|e| matches!(e, Event::ToolChange { .. }));
        if tool_change || self.frames.due(batch.time) {
            self.stock_frame(batch.time, tool_change, batch.stock, batch.patches)?;
        }
        self.send(CHUNK)
    }

    fn end(mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), RecordError> {
        let end = outcome.verdict.time.total_s.max(self.last_joints.map_or(0.0, |l| l.0));
        if let Some((time, joints)) = self.last_joints {
            self.place(setup, time, &joints);
        }
        let drives = self.drives.iter_mut().flatten();
        for signal in self.joints.iter_mut().flatten().chain(drives).chain(&mut self.process) {
            signal.finish();
        }
        self.limits(setup, end)?;
        self.send(1)?;
        let shown = std::mem::replace(&mut self.surface, SurfacePicture::new(SURFACE_TRIANGLES)).finish();
        // The measured surface takes the place of the tiles at the same moment.
        if shown.picture.triangles.is_empty() {
            self.stock_frame(end, true, outcome.stock, outcome.patches)?;
        } else {
            let groups = self.tiles.iter().flat_map(StockTiles::groups);
            let parts = groups.map(|group| (group, Picture::default())).collect();
            self.frames.push(RecordingFrame { time: end, keep: true, parts });
        }
        self.send_frames()?;
        self.send_path(end)?;
        // Findings of the judgement (gouge, excess, inspection) have no time: they belong to the end.
        for finding in outcome.verdict.findings.iter().filter(|f| f.time_s.is_none()) {
            self.finding(finding, end)?;
        }
        let verdict = format!("Verdict: {:?}", outcome.verdict.verdict).to_lowercase();
        self.sink.text(path(["log", "verdict"]), end, LogLevel::Info, &verdict)?;
        self.surface(setup, &shown, end)?;
        self.textures(end)?;
        for (time, picture, colors) in &self.axes {
            let entity = path(["machine", "table", "work", "free_axes"]);
            self.sink.mesh(entity, Some(*time), picture, STEEL, colors)?;
        }
        self.sink.finish()
    }

    /// Poses of all that moves.
    fn place(&mut self, setup: &Setup<'_>, time: f64, q: &JointValues) {
        let gauge = self.tool.and_then(|t| setup.tools.tools.get(t)).map_or(0.0, |t| t.gauge_length);
        for mover in &mut self.movers {
            mover.push(setup.machine, gauge, time, q);
        }
    }

    fn event(&mut self, setup: &Setup<'_>, event: &Event) -> Result<(), RecordError> {
        let time = event.time();
        let text = match event {
            Event::ToolChange { tool, .. } => {
                self.tool = *tool;
                let found = tool.and_then(|t| setup.tools.tools.get(t));
                self.show_tool(found, time)?;
                if let Some((_, joints)) = self.last_joints {
                    self.place(setup, time, &joints);
                }
                Some((
                    LogLevel::Info,
                    found.map_or_else(
                        || "tool change: spindle empty".into(),
                        |t| format!("tool change: {}", tool_name(t.number, &t.name)),
                    ),
                ))
            }
            Event::Message { text, .. } => Some((LogLevel::Info, format!("message: {text}"))),
            Event::Stop { optional, .. } => {
                Some((LogLevel::Info, if *optional { "optional stop".into() } else { "program stop".into() }))
            }
            Event::End { .. } => Some((LogLevel::Info, "end of program".into())),
            Event::Spindle { direction, speed_rpm, .. } => {
                Some((LogLevel::Debug, format!("spindle {direction:?} {speed_rpm} 1/min")))
            }
            _ => None,
        };
        match text {
            Some((level, text)) => self.sink.text(path(["log", "program"]), time, level, &text),
            None => Ok(()),
        }
    }

    fn show_tool(&self, tool: Option<&Tool>, time: f64) -> Result<(), RecordError> {
        for (name, color, picture) in tool_pictures(tool) {
            self.sink.mesh(path(["machine", "tool", name]), Some(time), &picture, color, &[])?;
        }
        Ok(())
    }

    fn finding(&mut self, finding: &Finding, time: f64) -> Result<(), RecordError> {
        let level = match finding.severity {
            Severity::Error => LogLevel::Error,
            Severity::Warning => LogLevel::Warn,
            Severity::Info => LogLevel::Info,
        };
        let place = finding.line.map_or_else(String::new, |l| format!("line {l}: "));
        let text = format!("{place}{} [{}]", finding.message, finding.code);
        self.sink.text(path(["log", "findings"]), time, level, &text)?;
        if let Some(point) = finding.point_mm.filter(|p| p.iter().all(|v| v.is_finite()))
            && self.marks.len() < MARKS
        {
            self.marks.push((point, format!("{place}{}", finding.code)));
            self.sink.marks(path(["machine", "table", "work", "findings"]), time, &self.marks, FINDING_COLOR)?;
        }
        Ok(())
    }

    fn stock_frame(&mut self, time: f64, keep: bool, stock: &TriDexel, patches: &[Patch]) -> Result<(), RecordError> {
        let stocks = std::iter::once(stock).chain(patches.iter().map(Patch::stock));
        let parts = self.tiles.iter_mut().zip(stocks).flat_map(|(tiles, stock)| tiles.take_changed(stock)).collect();
        self.frames.push(RecordingFrame { time, keep, parts });
        if self.live { self.send_frames() } else { Ok(()) }
    }

    fn send_frames(&mut self) -> Result<(), RecordError> {
        let mut rows: BTreeMap<u32, Vec<(f64, Picture)>> = BTreeMap::new();
        for frame in self.frames.drain() {
            for (group, picture) in frame.parts {
                rows.entry(group).or_default().push((frame.time, picture));
            }
        }
        for (group, rows) in rows {
            // A viewer that is fed may show what is now gone.
            if !self.live && rows.iter().all(|(_, picture)| picture.triangles.is_empty()) {
                continue;
            }
            self.sink.meshes(stock_path(group, &self.patches), &rows, STEEL)?;
        }
        Ok(())
    }

    fn send_path(&mut self, end: f64) -> Result<(), RecordError> {
        type Strips = Vec<(Vec<[f32; 3]>, Rgba)>;
        let mut bins: BTreeMap<(usize, bool), Strips> = BTreeMap::new();
        for (bin, strip) in std::mem::take(&mut self.trace).finish(end, PATH_BINS) {
            let points = strip.points.into_iter().map(|p| p.1).collect();
            let feed = strip.kind == MoveKind::Feed;
            let color = if feed { FEED_COLORS[strip.class.min(FEED_COLORS.len() - 1)] } else { RAPID_COLOR };
            bins.entry((bin, feed)).or_default().push((points, color));
        }
        for ((bin, feed), strips) in bins {
            let name = if feed { "feed" } else { "rapid" };
            let entity = path(["machine", "table", "work", "path", name, &format!("{bin:02}")]);
            self.sink.lines(entity, end * (bin + 1) as f64 / PATH_BINS as f64, &strips)?;
        }
        Ok(())
    }

    /// The measured surface, where the tiles of the stock have been.
    fn surface(&self, setup: &Setup<'_>, shown: &ShownSurface, end: f64) -> Result<(), RecordError> {
        if shown.picture.triangles.is_empty() {
            return Ok(());
        }
        let colors = colors_of(&shown.picture, shown.map(range_floor(setup)));
        self.sink.mesh(path(["machine", "table", "work", "surface"]), Some(end), &shown.picture, STEEL, &colors)?;
        Ok(())
    }

    /// Roughness maps on their places, colored by height on one scale.
    fn textures(&self, end: f64) -> Result<(), RecordError> {
        let range = range_of(&self.textures);
        for texture in &self.textures {
            let entity = path(["machine", "table", "work", "roughness", &texture.name]);
            self.sink.mesh(entity, Some(end), &texture.picture(), STEEL, &texture.colors(range))?;
        }
        if !self.textures.is_empty() {
            let text = format!(
                "roughness maps: height above the design from dark blue {:.4} um to yellow {:.4} um",
                range[0], range[1]
            );
            self.sink.text(path(["log", "roughness"]), end, LogLevel::Info, &text)?;
        }
        Ok(())
    }

    /// Sends the rows of everything that has at least `least` of them.
    fn send(&mut self, least: usize) -> Result<(), RecordError> {
        for mover in self.movers.iter_mut().filter(|m| m.rows.len() >= least || self.live) {
            mover.send(&self.sink)?;
        }
        let drives = self.drives.iter_mut().flatten();
        for signal in self.joints.iter_mut().flatten().chain(drives).chain(&mut self.process) {
            if signal.rows.len() >= least || self.live {
                signal.send(&self.sink)?;
            }
        }
        if self.texts.rows.len() >= least || self.live {
            self.sink.pages(path(["program", "block"]), &std::mem::take(&mut self.texts.rows))?;
        }
        Ok(())
    }
}
