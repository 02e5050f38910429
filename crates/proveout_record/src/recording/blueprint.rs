//! How a viewer opens the recording: views, their contents, cameras, time panel.

use proveout_geom::{Aabb, Vector};
use rerun::{
    RecordingStreamBuilder, StoreId, StoreKind,
    blueprint::{
        Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView, Tabs,
        TextDocumentView, TextLogView, TimePanel, TimeSeriesView, Vertical,
        components::{PanelState, PlayState},
    },
    external::{
        re_log_types::{BlueprintActivationCommand, LogMsg},
        re_sdk_types::blueprint::{
            archetypes::{Background, EyeControls3D, LineGrid3D, PlotLegend},
            components::BackgroundKind,
        },
    },
};

use crate::{
    error::RecordError,
    recording::{
        schedule::ScheduleViews,
        sink::{APPLICATION, Sink, TIMELINE},
    },
    report::rows::symbol,
    units::JointUnit,
};

/// A camera: its place and what it looks at, mm, in the frame of its view; Z is up.
struct Eye {
    /// Entity of the view's settings.
    view: String,
    position: [f32; 3],
    target: [f32; 3],
}

impl Eye {
    /// Looks at a box from the front right above, so that it fills the view.
    fn at(view: String, bounds: &Aabb) -> Self {
        let center = bounds.center();
        let reach = 0.5 * bounds.size().norm();
        let position = center + Vector::new(0.62, -0.9, 0.55).normalize() * (1.9 * reach);
        let single = |v: [f64; 3]| v.map(|v| v as f32);
        Self { view, position: single(position.into()), target: single(center.into()) }
    }
}

/// What the layout is about.
pub(crate) struct Layout<'a> {
    pub(crate) joints: &'a [JointUnit],
    /// Drives are simulated, and plotted with each axis.
    pub(crate) drives: bool,
    /// The viewer follows a run in progress; at a complete recording it is paused.
    pub(crate) live: bool,
    /// Machine at home, machine frame.
    pub(crate) machine: Aabb,
    /// Workpiece, its own frame.
    pub(crate) work: Aabb,
    /// A re-scheduled program has a page of its own.
    pub(crate) schedule: Option<&'a ScheduleViews>,
}

/// Sends the layout: machine and workpiece in three dimensions, plots of the process and of each axis,
/// findings as text, time panel on simulated time. A recording of a re-scheduled program opens at its
/// schedule, a viewer that is fed at the run.
///
/// The builder of views has no camera, background and grid; they are logged into the same blueprint store as
/// the entities `EyeControls3D`, `Background` and `LineGrid3D` of each view, which is where the viewer looks
/// for them.
pub(crate) fn send(sink: &Sink, layout: &Layout<'_>) -> Result<(), RecordError> {
    let Layout { joints, drives, live, machine, work, schedule } = layout;
    let machine_view: ContainerLike = Spatial3DView::new("Machine")
        .with_origin("/machine")
        .with_contents([
            "$origin/**",
            "- /machine/table/work/part/**",
            "- /machine/table/work/path/**",
            "- /machine/table/work/schedule/**",
        ])
        .into();
    let work_view: ContainerLike = Spatial3DView::new("Workpiece")
        .with_origin("/machine/table/work")
        .with_contents([
            "$origin/**",
            "- /machine/table/work/part/**",
            "- /machine/table/work/schedule/**",
            "+ /machine/tool/**",
            "+ /machine/table/fixtures/**",
            "+ /machine/table/loose/**",
        ])
        .into();
    let mut eyes = Vec::new();
    for (view, bounds) in [(&machine_view, machine), (&work_view, work)] {
        if let ContainerLike::View(view) = view
            && !bounds.is_empty()
        {
            eyes.push(Eye::at(view.blueprint_path().to_string(), bounds));
        }
    }
    let process = |name: &str, signals: &[&str]| -> ContainerLike {
        TimeSeriesView::new(name)
            .with_origin("/process")
            .with_contents(signals.iter().map(|s| format!("+ /process/{s}")))
            .into()
    };
    let mut plots: Vec<ContainerLike> = vec![
        Vertical::new([
            process("Feed", &["feed", "feed_programmed"]),
            process("Removal rate", &["removal"]),
            process("Clearance", &["clearance"]),
        ])
        .with_name("Process")
        .into(),
    ];
    let mut plain = Vec::new();
    plots.extend(joints.iter().map(|joint| axis_tab(joint, *drives, &mut plain)));
    let run: ContainerLike = Horizontal::new([
        Vertical::new([machine_view, work_view]).with_row_shares([1.0, 1.0]).into(),
        Vertical::new([
            Tabs::new(plots).into(),
            TextDocumentView::new("Block").with_origin("/program/block").into(),
            Tabs::new([
                TextLogView::new("Findings and messages").with_origin("/log").into(),
                TextDocumentView::new("About").with_origin("/about").into(),
            ])
            .into(),
        ])
        .with_row_shares([3.2, 0.5, 1.0])
        .into(),
    ])
    .with_column_shares([1.2, 1.0])
    .with_name("Run")
    .into();
    let root: ContainerLike = match schedule {
        None => run,
        Some(views) => {
            let page = schedule_page(views, work, &mut eyes);
            // A viewer opens at the first.
            Tabs::new(if *live { [run, page] } else { [page, run] }).into()
        }
    };
    let blueprint = Blueprint::new(root)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Collapsed))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
        .with_time_panel(
            TimePanel::new().with_state(PanelState::Collapsed).with_timeline(TIMELINE).with_play_state(if *live {
                PlayState::Following
            } else {
                PlayState::Paused
            }),
        );
    let messages = with_eyes(sink, &blueprint, &eyes, &plain)?;
    if let Some(first) = messages.first() {
        let command = BlueprintActivationCommand::make_active(first.store_id().clone());
        sink.stream.send_blueprint(messages, command);
    }
    Ok(())
}

/// Tool axes on their sphere and on the part; each joint within its channel, with velocity and acceleration;
/// what the method shows; the numbers.
fn schedule_page(views: &ScheduleViews, work: &Aabb, eyes: &mut Vec<Eye>) -> ContainerLike {
    let sphere: ContainerLike =
        Spatial3DView::new("Tool axes on a unit sphere, workpiece frame").with_origin("/schedule/sphere").into();
    let part: ContainerLike = Spatial3DView::new("Tool axes on the part: orange before, blue new")
        .with_origin("/machine/table/work")
        .with_contents([
            "+ /machine/table/work/part/**",
            "+ /machine/table/work/schedule/**",
            "+ /machine/table/fixtures/**",
        ])
        .into();
    if let ContainerLike::View(view) = &sphere {
        let [position, target] = [views.eye, views.target].map(|p| p.map(|v| v as f32));
        eyes.push(Eye { view: view.blueprint_path().to_string(), position, target });
    }
    if let ContainerLike::View(view) = &part
        && !work.is_empty()
    {
        eyes.push(Eye::at(view.blueprint_path().to_string(), work));
    }
    let joint = |(joint, channel): &(JointUnit, bool)| -> ContainerLike {
        let symbol = symbol(joint.unit);
        let strips = [
            ("in_channel", "about the middle of its channel", "", 1.5),
            ("position", "position", "", 1.0),
            ("velocity", "velocity at the programmed feed", "/s", 1.0),
            ("acceleration", "acceleration at the programmed feed", "/s²", 1.0),
        ];
        let strips = &strips[usize::from(!channel)..];
        let views = strips.iter().map(|(what, title, per, _)| -> ContainerLike {
            TimeSeriesView::new(format!("{} {title}, {symbol}{per}", joint.name))
                .with_origin("/")
                .with_contents([format!("+ /schedule/joints/{}/{what}/**", joint.name)])
                .into()
        });
        let shares: Vec<f32> = strips.iter().map(|s| s.3).collect();
        Vertical::new(views.collect::<Vec<_>>()).with_row_shares(shares).with_name(joint.name.as_str()).into()
    };
    let mut tabs: Vec<ContainerLike> = views.joints.iter().map(joint).collect();
    if !views.quantities.is_empty() {
        let plots: Vec<ContainerLike> = views
            .quantities
            .iter()
            .map(|[name, title]| {
                TimeSeriesView::new(title.as_str())
                    .with_origin("/")
                    .with_contents([format!("+ /schedule/method/{name}/**")])
                    .into()
            })
            .collect();
        tabs.push(Vertical::new(plots).with_name("Method").into());
    }
    let text: ContainerLike =
        TextDocumentView::new("What is shown, and the remaining gain").with_origin("/schedule/text").into();
    let right: Vec<ContainerLike> = if tabs.is_empty() { vec![text] } else { vec![Tabs::new(tabs).into(), text] };
    let shares: &[f32] = if right.len() > 1 { &[2.0, 1.0] } else { &[1.0] };
    Horizontal::new([
        Vertical::new([sphere, part]).into(),
        Vertical::new(right).with_row_shares(shares.to_vec()).into(),
    ])
    .with_column_shares([1.0, 1.5])
    .with_name("Schedule")
    .into()
}

/// The plots of one axis above each other, each with its own unit; the views that get no legend are added to
/// `plain`.
fn axis_tab(unit: &JointUnit, drives: bool, plain: &mut Vec<String>) -> ContainerLike {
    let length = symbol(unit.unit);
    let motion = ["position", "velocity", "acceleration", "jerk"].into_iter().zip(["", "/s", "/s²", "/s³"]);
    let mut strips: Vec<(&str, &str, String)> =
        motion.map(|(what, per)| (what, what, format!("{length}{per}"))).collect();
    if drives {
        let kind = if unit.rotary { "drive torque" } else { "drive force" };
        strips.push(("following error", "following_error", length.to_owned()));
        strips.push((kind, "force", unit.force_unit.to_owned()));
        strips.push(("drive power", "power", "W".to_owned()));
    }
    let views = strips.into_iter().map(|(name, what, symbol)| {
        let view: ContainerLike = TimeSeriesView::new(format!("{} {name}, {symbol}", unit.name))
            .with_origin("/")
            .with_contents([format!("+ /axes/{}/{what}/**", unit.name)])
            .into();
        if let ContainerLike::View(view) = &view {
            plain.push(view.blueprint_path().to_string());
        }
        view
    });
    let views: Vec<ContainerLike> = views.collect();
    Vertical::new(views).with_name(unit.name.as_str()).into()
}

/// The messages of a blueprint with the cameras of its views and without the legends of the `plain` ones.
fn with_eyes(sink: &Sink, blueprint: &Blueprint, eyes: &[Eye], plain: &[String]) -> Result<Vec<LogMsg>, RecordError> {
    let (stream, storage) =
        RecordingStreamBuilder::new(APPLICATION).enabled(true).memory().map_err(|e| sink.fault(e))?;
    let activation = BlueprintActivation { make_active: true, make_default: true };
    blueprint.send(&stream, activation).map_err(|e| sink.fault(e))?;
    let ours =
        |m: &LogMsg| m.store_id().kind() == StoreKind::Blueprint && !matches!(m, LogMsg::BlueprintActivationCommand(_));
    let mut messages: Vec<LogMsg> = storage.take().into_iter().filter(ours).collect();
    let Some(store) = messages.first().map(|m| m.store_id().clone()) else { return Ok(messages) };
    messages.extend(eye_messages(sink, &store, eyes, plain)?);
    Ok(messages)
}

fn eye_messages(sink: &Sink, store: &StoreId, eyes: &[Eye], plain: &[String]) -> Result<Vec<LogMsg>, RecordError> {
    let (stream, storage) =
        RecordingStreamBuilder::from_store_id(store).enabled(true).memory().map_err(|e| sink.fault(e))?;
    stream.set_time_sequence("blueprint", 0);
    for eye in eyes {
        let controls = EyeControls3D::new()
            .with_position(eye.position)
            .with_look_target(eye.target)
            .with_eye_up([0.0_f32, 0.0, 1.0]);
        let background = Background::new(BackgroundKind::SolidColor).with_color(rerun::Color::from_rgb(34, 38, 44));
        let grid = LineGrid3D::new().with_visible(false);
        for (name, what) in [
            ("EyeControls3D", &controls as &dyn rerun::AsComponents),
            ("Background", &background),
            ("LineGrid3D", &grid),
        ] {
            stream.log(format!("{}/{name}", eye.view), what).map_err(|e| sink.fault(e))?;
        }
    }
    for view in plain {
        // One line a plot, named in its title: a legend would cover it.
        let legend = PlotLegend::new().with_visible(false);
        stream.log(format!("{view}/PlotLegend"), &legend).map_err(|e| sink.fault(e))?;
    }
    // The store is announced already by the blueprint's own messages.
    Ok(storage.take().into_iter().filter(|m| matches!(m, LogMsg::ArrowMsg(..))).collect())
}

#[cfg(test)]
mod tests {
    use proveout_geom::Point;

    use super::*;

    /// The state of the playhead that the viewer receives.
    fn playhead(live: bool) -> String {
        let (stream, storage) = RecordingStreamBuilder::new(APPLICATION).enabled(true).memory().expect("memory");
        let sink = Sink::new(stream, "memory".into());
        let bounds = Aabb { min: Point::new(0.0, 0.0, 0.0), max: Point::new(9.0, 9.0, 9.0) };
        let layout = Layout { joints: &[], drives: false, live, machine: bounds, work: bounds, schedule: None };
        send(&sink, &layout).expect("sent");
        let of = |m: &LogMsg| match m {
            LogMsg::ArrowMsg(_, arrow) => {
                let schema = arrow.batch.schema();
                let at = schema.fields().iter().position(|f| f.name().ends_with("play_state"))?;
                let text = format!("{:?}", arrow.batch.column(at));
                Some(text.chars().rfind(char::is_ascii_digit).map(String::from).unwrap_or_default())
            }
            _ => None,
        };
        storage.take().iter().find_map(of).expect("a play state")
    }

    #[test]
    fn a_viewer_follows_a_run_that_goes_on_and_stands_at_a_file() {
        let state = |s: PlayState| (s as u8).to_string();
        assert_eq!([playhead(true), playhead(false)], [state(PlayState::Following), state(PlayState::Paused)]);
    }
}
