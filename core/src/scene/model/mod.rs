//! The scene as data: what a checked scene file says, in SI units, with every default filled in.
//!
//! Nothing here reads text; `read` turns a TOML file into these types and collects every mistake on the way.

mod binding;
mod body;
mod camera;
mod coupling;
mod influence;
mod place;
mod region;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use binding::*;
pub use body::*;
pub use camera::*;
pub use coupling::*;
pub use influence::*;
pub use region::*;

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Short name, also the name of the run folder.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// Simulated time and exchange interval.
    pub clock: ClockSpec,
    /// Number of dimensions that move: full space, or a slab one spacing thick whose normal motion is zero.
    pub space: Space,
    /// Solver processes that the scene names explicitly, by name.
    pub solvers: BTreeMap<String, SolverSpec>,
    /// Things with a material.
    pub bodies: Vec<Body>,
    /// Things that never move or move as told and take no impulses: floors, walls, terrain.
    pub statics: Vec<StaticCollider>,
    /// What the user says about two bodies that may touch.
    pub pairs: Vec<PairSpec>,
    /// Potentials of two positions.
    pub links: Vec<Link>,
    /// Rigid joints.
    pub joints: Vec<Joint>,
    /// Outside influences.
    pub actions: Vec<Action>,
    /// Quantities written to CSV.
    pub probes: Vec<Probe>,
    /// What the run leaves behind beside its ledger.
    pub output: OutputSpec,
    /// How the run is carried out; never changes a result, except `break_with`, which exists to.
    pub run: RunSpec,
    /// Names of the published materials that the scene takes, in its order, whatever it changes of them.
    #[serde(default)]
    pub presets: Vec<String>,
}

/// `[clock]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockSpec {
    /// Simulated time \[s\].
    pub duration_s: f64,
    /// Largest coupling window \[s\]; the plan may take a smaller one and says why.
    pub window_s: Option<f64>,
    /// Whether the scene is refused where the plan would take a smaller window for an interface's sake.
    pub exact_window: bool,
    /// Output frames per simulated second; frame times are multiples of the window.
    pub frames_per_second: Option<f64>,
    /// Scheme of all contact interfaces.
    pub contact_scheme: Scheme,
    /// Scheme of all links.
    pub link_scheme: Scheme,
    /// How a partner moves inside a window.
    pub motion_rule: MotionRule,
}

/// How two sides of an interface take turns within a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Resolver (or first side) first, then the other with its fresh result.
    Serial,
    /// Both at once from the last window's results.
    Parallel,
    /// Links only: as serial, but the order swaps every window.
    Alternating,
    /// Links only, as impulses: one side half a window, the other all of it, then the first its other half.
    Centred,
}

/// How a partner's boundary moves between two exchanges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionRule {
    /// It stays where the newest record puts it.
    Hold,
    /// Straight line: between two records where both are known, else `x + v τ`.
    Linear,
    /// Cubic through positions and velocities of two records where both are known, else `x + v τ`.
    Hermite,
}

/// `[space]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Space {
    /// Three dimensions.
    Full,
    /// A 2-D slab: no motion along `normal`; `thickness_m` makes masses and forces those of that depth.
    Slab {
        /// Axis without motion: 0, 1 or 2.
        normal: usize,
        /// Depth \[m\].
        thickness_m: f64,
    },
}

/// `[solver.NAME]`: one process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolverSpec {
    /// Plugin to run; `None` means the plugin of the same name.
    pub plugin: Option<String>,
    /// Explicit command of a foreign plugin, program first.
    pub command: Option<Vec<String>>,
    /// Plugin parameters, checked against the plugin's own schema.
    pub params: serde_json::Map<String, serde_json::Value>,
}

/// `[output]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::struct_excessive_bools, reason = "each is a file that a scene may or may not want")]
pub struct OutputSpec {
    /// Write `trace.json` for Perfetto.
    pub trace: bool,
    /// Write one ledger row every this many windows (the last window is always written).
    pub ledger_every: u64,
    /// Draw a picture of each frame, and an animation of them.
    pub pictures: bool,
    /// Write each frame as a splat file.
    pub splats: bool,
    /// In which form.
    #[serde(default)]
    pub splat_form: SplatForm,
    /// Write the surface of each liquid as a mesh at each frame, and in which format.
    #[serde(default)]
    pub surfaces: Option<MeshForm>,
    /// Write a recording for the viewer.
    pub recording: bool,
    /// Make a film of the pictures.
    pub video: bool,
    /// Show the recording while the run goes on. Asked for with a run, never by a scene.
    pub live: bool,
    /// Write a report to be read in a browser.
    pub report: bool,
    /// Whether what the colour of Gaussians has of the direction they are seen from turns with them.
    #[serde(default = "yes")]
    pub turn_colours: bool,
    /// Who draws the pictures.
    pub renderer: RendererSpec,
    /// A fixed set of frames for another program.
    pub preset: Option<Preset>,
    /// Where pictures are taken from; `None` lets the launcher look at all that moves.
    pub camera: Option<CameraSpec>,
    /// What the Gaussians of bodies are tied to, by body, where the scene says so.
    #[serde(default)]
    pub bindings: BTreeMap<String, BodyBinding>,
}

/// In which form frames are written as splat files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SplatForm {
    /// Each frame with all bits, for any viewer.
    #[default]
    Ply,
    /// Each frame packed, for most viewers.
    Spz,
    /// The first frame as `.ply`, of the others what has changed since.
    Compact,
}

/// Format of meshes that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeshForm {
    /// Text, for every program.
    Obj,
    /// Binary.
    Ply,
}

/// Who draws the pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RendererSpec {
    /// The processor: the same bytes on every machine.
    #[default]
    Cpu,
    /// A graphics processor; the run fails where there is none.
    Gpu,
    /// A graphics processor where there is one in hardware.
    Auto,
}

/// A fixed set of frames for another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// What a video model is conditioned on: 49 frames of 720 × 480 pixels from the first to the last moment, and of each
    /// the flow to the next, the depth and which body is seen.
    VideoModel,
}

impl Preset {
    /// Frames, the first and the last included.
    pub fn frames(self) -> u32 {
        match self {
            Self::VideoModel => 49,
        }
    }

    /// Width and height \[px\].
    pub fn size_px(self) -> [u32; 2] {
        match self {
            Self::VideoModel => [720, 480],
        }
    }
}

impl OutputSpec {
    /// Whether anything needs frames.
    pub fn draws(&self) -> bool {
        self.pictures || self.splats || self.surfaces.is_some() || self.recording || self.live
    }
}

/// What summaries of runs from before [`OutputSpec::turn_colours`] did.
fn yes() -> bool {
    true
}

impl Default for OutputSpec {
    fn default() -> Self {
        Self {
            trace: true,
            ledger_every: 1,
            pictures: false,
            splats: false,
            splat_form: SplatForm::default(),
            surfaces: None,
            recording: false,
            video: false,
            live: false,
            report: true,
            turn_colours: true,
            renderer: RendererSpec::default(),
            preset: None,
            camera: None,
            bindings: BTreeMap::new(),
        }
    }
}

/// `[run]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunSpec {
    /// Threads for solvers of one level; `None` takes the machine's cores.
    pub threads: Option<usize>,
    /// A participant that has not joined and set up after this long ends the run \[s\].
    pub join_limit_s: f64,
    /// A participant silent for this long ends the run \[s\].
    pub silence_limit_s: f64,
    /// Make bodies rigid whose deformation cannot be seen.
    pub rigidify: bool,
    /// Breaks one thing on purpose, to see that the gates notice.
    pub break_with: Option<Break>,
}

/// Deliberate faults, for negative controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Break {
    /// Responders throw the impulses they receive away.
    DropReaction,
    /// Responders take a quarter more than they receive.
    StrongReaction,
    /// Rigid responders throw the moment of the impulses away that they receive.
    DropMoment,
    /// Everybody is shown partners as they were a step ago.
    StaleBoundary,
}

impl Break {
    /// Every fault with the name that a scene gives it.
    pub const ALL: [(&'static str, Self); 4] = [
        ("drop-reaction", Self::DropReaction),
        ("strong-reaction", Self::StrongReaction),
        ("drop-moment", Self::DropMoment),
        ("stale-boundary", Self::StaleBoundary),
    ];

    /// Whether it falsifies impulses, so that it does nothing where none cross.
    pub fn needs_impulses(self) -> bool {
        self != Self::StaleBoundary
    }
}
