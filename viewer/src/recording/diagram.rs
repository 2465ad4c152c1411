//! Diagrams with two logarithmic axes as a recording: what a study draws on its page, for the rerun viewer.
//!
//! rerun has plots over time alone, so a diagram is a view of the plane: [`WIDTH`] by [`HEIGHT`] units, upwards is
//! negative, with a line and a label at round values. Each series is an entity of its own, which the viewer can hide, and
//! a point says what it is when pointed at. Tables stand beside them as text.

use std::path::Path;

use rerun::blueprint::components::{ContainerKind, PanelState, VisualBounds2D};
use rerun::components::Radius;
use rerun::external::re_sdk_types::blueprint::archetypes::{Background, TimePanelBlueprint, VisualBounds2D as Bounds};
use rerun::log::ChunkBatcherConfig;
use rerun::{
    Color, LineStrips2D, Points2D, RecordingStream, RecordingStreamBuilder, RecordingStreamResult, TextDocument,
    components, datatypes,
};

use super::layout::{application, begin, container, container_path, finish, view, view_path};
use super::{PATIENCE, RecordingError};

/// Size of a diagram in its own units.
const WIDTH: f64 = 160.0;
const HEIGHT: f64 = 100.0;
/// Colours of lines of the grid, and of what is written.
const GRID: [u8; 3] = [222, 222, 222];
const TEXT: [u8; 3] = [64, 64, 64];

/// Points of one kind.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name.
    pub name: String,
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// Whether its points are shown.
    pub marked: bool,
    /// Whether they are joined by a line.
    pub joined: bool,
    /// Place, and what is said when pointed at. What is not positive is left out.
    pub points: Vec<(f64, f64, String)>,
}

/// A diagram.
#[derive(Clone, Debug)]
pub struct Diagram {
    /// Diagrams of one group are shown beside each other.
    pub group: String,
    /// Title.
    pub title: String,
    /// Name and unit of each axis.
    pub axes: [String; 2],
    /// The points.
    pub series: Vec<Series>,
}

/// What is told in words and tables.
#[derive(Clone, Debug)]
pub struct Text {
    /// Shown beside the diagrams of this group.
    pub group: String,
    /// Title.
    pub title: String,
    /// Markdown.
    pub markdown: String,
}

/// Logarithms of the ends of an axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    from: f64,
    to: f64,
}

impl Axis {
    /// Around some values, with a margin; a decade where there is nothing.
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let ends = values.map(f64::log10).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let (from, to) = if ends.0 > ends.1 { (0.0, 1.0) } else { ends };
        let margin = (0.06 * (to - from)).max(0.2);
        Self { from: from - margin, to: to + margin }
    }

    fn share(self, logarithm: f64) -> f64 {
        (logarithm - self.from) / (self.to - self.from)
    }

    /// Round values on it: 1, 2 and 5 of each decade; powers of ten alone where there are many, and of these every other
    /// one and so on.
    fn ticks(self) -> Vec<f64> {
        let span = self.to - self.from;
        let every = (span / 10.0).ceil().max(1.0) as i32;
        let steps: &[f64] = if span < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decades = (self.from.floor() as i32..=self.to.ceil() as i32).filter(|d| d % every == 0);
        let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10.0_f64.powi(d)));
        all.filter(|v| (0.0..=1.0).contains(&self.share(v.log10()))).collect()
    }
}

/// A tick in words, such as `2e-3`.
fn tick(value: f64) -> String {
    let exponent = (value.log10() + 1e-9).floor();
    format!("{:.0}e{exponent}", value / 10.0_f64.powf(exponent))
}

/// Writes diagrams and texts into a file of their own; `run` is the identity by which the viewer merges recordings.
///
/// # Errors
/// The file cannot be written.
pub fn write_diagrams(
    path: &Path,
    name: &str,
    run: &str,
    diagrams: &[Diagram],
    texts: &[Text],
) -> Result<(), RecordingError> {
    let file = path.display().to_string();
    let made = RecordingStreamBuilder::new(application(name)).enabled(true);
    let made = made.recording_id(run).batcher_config(ChunkBatcherConfig::NEVER).save(path);
    let stream = made.map_err(|e| RecordingError::Create(file.clone(), e.to_string()))?;
    stream.set_log_time_enabled(false);
    stream.set_log_tick_enabled(false);
    let all = || {
        stream.send_recording_name(name)?;
        send_layout(&stream, name, run, diagrams, texts)?;
        for (i, diagram) in diagrams.iter().enumerate() {
            draw(&stream, &entity(i), diagram)?;
        }
        for (i, text) in texts.iter().enumerate() {
            stream.log_static(text_entity(i), &TextDocument::from_markdown(text.markdown.as_str()))?;
        }
        Ok(())
    };
    let failed = |e: String| RecordingError::Write(file.clone(), e);
    all().map_err(|e: rerun::RecordingStreamError| failed(e.to_string()))?;
    stream.flush_with_timeout(PATIENCE).map_err(|e| failed(e.to_string()))?;
    stream.disconnect();
    Ok(())
}

/// Entity above all of a diagram.
fn entity(number: usize) -> String {
    format!("diagram/{number}")
}

fn text_entity(number: usize) -> String {
    format!("text/{number}")
}

fn draw(stream: &RecordingStream, entity: &str, diagram: &Diagram) -> RecordingStreamResult<()> {
    let drawable = |p: &&(f64, f64, String)| [p.0, p.1].iter().all(|v| (1e-300..1e300).contains(v));
    let places = || diagram.series.iter().flat_map(|s| &s.points).filter(drawable);
    let [x, y] = [Axis::of(places().map(|p| p.0)), Axis::of(places().map(|p| p.1))];
    let at = |p: &(f64, f64, String)| [WIDTH * x.share(p.0.log10()), -HEIGHT * y.share(p.1.log10())];
    frame(stream, entity, [x, y], &diagram.axes)?;
    for (i, series) in diagram.series.iter().enumerate() {
        let points: Vec<&(f64, f64, String)> = series.points.iter().filter(drawable).collect();
        let places: Vec<[f64; 2]> = points.iter().map(|p| at(p)).collect();
        let path = format!("{entity}/{i} {}", series.name.replace('/', " "));
        if series.joined {
            let line = lines([places.clone()], series.colour, 1.0);
            stream.log_static(format!("{path}/line"), &line)?;
        }
        if series.marked {
            let said = points.iter().map(|p| p.2.as_str());
            stream.log_static(path, &marks(&places, series.colour, 5.0).with_labels(said).with_show_labels(false))?;
        }
    }
    Ok(())
}

/// The lines of the grid and what is written beside them.
fn frame(stream: &RecordingStream, entity: &str, [x, y]: [Axis; 2], names: &[String; 2]) -> RecordingStreamResult<()> {
    let mut strips = vec![vec![[0.0, 0.0], [WIDTH, 0.0], [WIDTH, -HEIGHT], [0.0, -HEIGHT], [0.0, 0.0]]];
    let (mut places, mut words) = (Vec::new(), Vec::new());
    for value in x.ticks() {
        let place = WIDTH * x.share(value.log10());
        strips.push(vec![[place, 0.0], [place, -HEIGHT]]);
        places.push([place, 4.0]);
        words.push(tick(value));
    }
    for value in y.ticks() {
        let place = -HEIGHT * y.share(value.log10());
        strips.push(vec![[0.0, place], [WIDTH, place]]);
        places.push([-6.0, place]);
        words.push(tick(value));
    }
    places.extend([[0.5 * WIDTH, 10.0], [0.0, -HEIGHT - 5.0]]);
    words.extend(names.iter().cloned());
    stream.log_static(format!("{entity}/grid"), &lines(strips, GRID, 0.5))?;
    let written = marks(&places, TEXT, 0.1).with_labels(words.iter().map(String::as_str)).with_show_labels(true);
    stream.log_static(format!("{entity}/axes"), &written)
}

fn lines(strips: impl IntoIterator<Item = Vec<[f64; 2]>>, [r, g, b]: [u8; 3], radius: f32) -> LineStrips2D {
    let strips = strips.into_iter().map(|strip| strip.into_iter().map(single).collect::<Vec<_>>());
    let (colour, radius) = (Color::from_rgb(r, g, b), Radius::new_ui_points(radius));
    LineStrips2D::new(strips).with_colors([colour]).with_radii([radius])
}

fn marks(places: &[[f64; 2]], [r, g, b]: [u8; 3], radius: f32) -> Points2D {
    let (colour, radius) = (Color::from_rgb(r, g, b), Radius::new_ui_points(radius));
    Points2D::new(places.iter().map(|&p| single(p))).with_colors([colour]).with_radii([radius])
}

fn single(place: [f64; 2]) -> [f32; 2] {
    place.map(|c| c as f32)
}

/// One tab a group, with its diagrams and texts beside each other.
fn send_layout(
    recording: &RecordingStream,
    name: &str,
    run: &str,
    diagrams: &[Diagram],
    texts: &[Text],
) -> RecordingStreamResult<()> {
    let (stream, storage) = begin(application(name), run)?;
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    let mut join = |group, path| match groups.iter_mut().find(|g| g.0 == group) {
        Some(known) => known.1.push(path),
        None => groups.push((group, vec![path])),
    };
    for (i, diagram) in diagrams.iter().enumerate() {
        let path = view_path(i as u128);
        view(&stream, &path, "2D", &diagram.title, &entity(i))?;
        let white = Background::new(rerun::blueprint::components::BackgroundKind::SolidColor);
        stream.log(format!("{path}/Background"), &white.with_color(Color::from_rgb(255, 255, 255)))?;
        let range = datatypes::Range2D {
            x_range: datatypes::Range1D([-14.0, WIDTH + 4.0]),
            y_range: datatypes::Range1D([-HEIGHT - 10.0, 14.0]),
        };
        stream.log(format!("{path}/VisualBounds2D"), &Bounds::new(VisualBounds2D(range)))?;
        join(diagram.group.as_str(), path);
    }
    for (i, text) in texts.iter().enumerate() {
        let path = view_path((diagrams.len() + i) as u128);
        view(&stream, &path, "TextDocument", &text.title, &text_entity(i))?;
        join(text.group.as_str(), path);
    }
    let mut tabs = Vec::new();
    for (i, (group, views)) in groups.iter().enumerate() {
        let path = container_path(1 + i as u128);
        let named = container(ContainerKind::Horizontal, views).with_display_name(components::Name((*group).into()));
        stream.log(path.as_str(), &named)?;
        tabs.push(path);
    }
    stream.log(container_path(0), &container(ContainerKind::Tabs, &tabs))?;
    finish(recording, &stream, &storage, &TimePanelBlueprint::new().with_state(PanelState::Hidden))
}
