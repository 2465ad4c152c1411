//! How the viewer shows a recording when it is opened: the scene on the left, curves on the right.
//!
//! The messages are made here, because the builder of the rerun crate knows no camera and makes random names.

use rerun::blueprint::components::{
    AutoLayout, AutoViews, BackgroundKind, ContainerKind, IncludedContent, PanelState, QueryExpression, RootContainer,
    RowShare, TimelineName, ViewClass,
};
use rerun::coordinates::SignedAxis3;
use rerun::external::re_log_types::{BlueprintActivationCommand, LogMsg};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, PlotLegend, TimePanelBlueprint,
    ViewBlueprint, ViewContents, ViewportBlueprint,
};
use rerun::external::uuid::Uuid;
use rerun::sink::MemorySinkStorage;
use rerun::{
    ApplicationId, Color, RecordingStream, RecordingStreamBuilder, RecordingStreamResult, components, datatypes,
};

use super::{TIME, WORLD};
use crate::camera::Camera;

/// A plot of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Curves<'a> {
    /// Entity above its curves, such as `curves/closure`; a curve is `curves/closure/left`.
    pub path: &'a str,
    /// Title, with the unit.
    pub title: &'a str,
}

/// What the viewer shows first.
#[derive(Clone, Copy, Debug)]
pub struct Layout<'a> {
    /// Name of the scene. Layouts are kept by scene in the viewer.
    pub scene: &'a str,
    /// Identity of the run; recordings of one identity are merged in the viewer.
    pub run: &'a str,
    /// Upwards in the scene; the axis next to it is taken.
    pub up: [f64; 3],
    /// Where the picture is taken from; the viewer finds its own place without one.
    pub camera: Option<&'a Camera>,
    /// Colour behind everything, in display values.
    pub background: [f32; 3],
    /// Plots, from the top.
    pub curves: &'a [Curves<'a>],
}

/// A layout in the making, and where its messages gather.
pub(super) fn begin(
    application: ApplicationId,
    run: &str,
) -> RecordingStreamResult<(RecordingStream, MemorySinkStorage)> {
    let (stream, storage) = RecordingStreamBuilder::new(application)
        .enabled(true)
        .recording_id(format!("{run} layout"))
        .blueprint()
        .memory()?;
    stream.set_log_time_enabled(false);
    stream.set_log_tick_enabled(false);
    stream.set_time_sequence("blueprint", 0);
    Ok((stream, storage))
}

/// Says that container 0 is all there is, hides what a reader does not need, and makes the layout the active one.
pub(super) fn finish(
    recording: &RecordingStream,
    stream: &RecordingStream,
    storage: &MemorySinkStorage,
    time_panel: &TimePanelBlueprint,
) -> RecordingStreamResult<()> {
    let viewport = ViewportBlueprint::new()
        .with_root_container(RootContainer(container_id(0).into()))
        .with_auto_layout(AutoLayout(false.into()))
        .with_auto_views(AutoViews(false.into()));
    stream.log("viewport", &viewport)?;
    for panel in ["blueprint_panel", "selection_panel"] {
        stream.log(panel, &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
    }
    stream.log("time_panel", time_panel)?;
    let messages = storage.take();
    if let Some(store) = messages.iter().map(LogMsg::store_id).next().cloned() {
        recording.send_blueprint(messages, BlueprintActivationCommand::make_active(store));
    }
    Ok(())
}

impl Layout<'_> {
    /// Name under which the viewer keeps the layout; only letters, digits, `-` and `_` are allowed in it.
    pub(super) fn application(&self) -> ApplicationId {
        application(self.scene)
    }

    /// The signed axis nearest to `up`.
    pub(super) fn up_axis(&self) -> SignedAxis3 {
        let [x, y, z] = self.up.map(f64::abs);
        let (axis, value) = if x > y && x > z {
            ([SignedAxis3::NEGATIVE_X, SignedAxis3::POSITIVE_X], self.up[0])
        } else if y > z {
            ([SignedAxis3::NEGATIVE_Y, SignedAxis3::POSITIVE_Y], self.up[1])
        } else {
            ([SignedAxis3::NEGATIVE_Z, SignedAxis3::POSITIVE_Z], self.up[2])
        };
        axis[usize::from(value >= 0.0)]
    }

    /// Puts the layout into a recording and makes it the active one.
    pub(super) fn send(&self, recording: &RecordingStream) -> RecordingStreamResult<()> {
        let (stream, storage) = begin(self.application(), self.run)?;
        self.scene_view(&stream)?;
        let mut parts = vec![view_path(0)];
        if !self.curves.is_empty() {
            self.plots(&stream)?;
            parts.push(container_path(1));
        }
        let root = container(ContainerKind::Horizontal, &parts).with_col_shares([3.0, 2.0].iter().map(|&s| share(s)));
        stream.log(container_path(0), &root)?;
        let time = TimePanelBlueprint::new().with_state(PanelState::Collapsed).with_timeline(TimelineName(TIME.into()));
        finish(recording, &stream, &storage, &time)
    }

    fn scene_view(&self, stream: &RecordingStream) -> RecordingStreamResult<()> {
        let path = view_path(0);
        view(stream, &path, "3D", self.scene, WORLD)?;
        let [r, g, b] = self.background.map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8);
        let background = Background::new(BackgroundKind::SolidColor).with_color(Color::from_rgb(r, g, b));
        stream.log(format!("{path}/Background"), &background)?;
        stream.log(format!("{path}/LineGrid3D"), &LineGrid3D::new().with_visible(false))?;
        if let Some(camera) = self.camera {
            let [eye, target, up] = [camera.eye, camera.target, camera.up].map(|v| v.map(|c| c as f32));
            let controls = EyeControls3D::new().with_position(eye).with_look_target(target).with_eye_up(up);
            stream.log(format!("{path}/EyeControls3D"), &controls)?;
        }
        Ok(())
    }

    fn plots(&self, stream: &RecordingStream) -> RecordingStreamResult<()> {
        let mut parts = Vec::new();
        for (i, curves) in self.curves.iter().enumerate() {
            let path = view_path(1 + i as u128);
            view(stream, &path, "TimeSeries", curves.title, curves.path)?;
            stream.log(format!("{path}/PlotLegend"), &PlotLegend::new().with_visible(true))?;
            parts.push(path);
        }
        let shares = parts.iter().map(|_| RowShare(1.0.into()));
        stream.log(container_path(1), &container(ContainerKind::Vertical, &parts).with_row_shares(shares))
    }
}

/// Name under which the viewer keeps a layout.
pub(super) fn application(name: &str) -> ApplicationId {
    let kept = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    ApplicationId::new_or_unknown(format!("cosplat-{}", name.chars().map(kept).collect::<String>()))
}

pub(super) fn view(
    stream: &RecordingStream,
    path: &str,
    class: &str,
    title: &str,
    origin: &str,
) -> RecordingStreamResult<()> {
    let contents = ViewContents::new([QueryExpression("$origin/**".into())]);
    stream.log(format!("{path}/ViewContents"), &contents)?;
    let view = ViewBlueprint::new(ViewClass(class.into()))
        .with_display_name(components::Name(title.into()))
        .with_space_origin(format!("/{origin}"));
    stream.log(path, &view)
}

pub(super) fn container(kind: ContainerKind, parts: &[String]) -> ContainerBlueprint {
    let contents = parts.iter().map(|path| IncludedContent(datatypes::EntityPath::from(path.as_str())));
    ContainerBlueprint::new(kind).with_contents(contents)
}

fn share(share: f32) -> rerun::blueprint::components::ColumnShare {
    rerun::blueprint::components::ColumnShare(share.into())
}

/// Number of the first container and of the first view. Identities are numbers, so that two runs of one scene have the
/// same layout. The viewer keeps containers and views in one tree: with a number in common a container would be found
/// inside itself.
const FIRST: [u128; 2] = [1, 1 << 32];

pub(super) fn container_id(number: u128) -> Uuid {
    Uuid::from_u128(FIRST[0] + number)
}

pub(super) fn container_path(number: u128) -> String {
    format!("container/{}", container_id(number))
}

pub(super) fn view_path(number: u128) -> String {
    format!("view/{}", Uuid::from_u128(FIRST[1] + number))
}
