//! Bodies as Gaussians: a capture that its particles deform, a surface that its pose carries, particles themselves.

use cosplat_core::boundary::Vec3;
use cosplat_core::visual::VisualState;
use cosplat_splat::bind::Frame;
use cosplat_splat::skin::Limits;
use cosplat_splat::stage::{Shown, Staged};
use cosplat_splat::surfel::{Fabric, Light, MeshSurfels, Sample, Worn, fabric, lit, lit_dots, puffs};
use cosplat_splat::{Axes, OutputFrame, Similarity, Splats};
use cosplat_viewer::Gaussians;
use nalgebra::Vector3;

use super::moment::{self, Item};

/// Standard deviations grow at most by this in a deformation: a particle that tore loose must not smear over the picture.
const STRETCH: f64 = 4.0;

/// A body that is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    /// Its name; that of a static collider for what never moves.
    pub(crate) name: String,
    /// Where the scene puts it.
    pub(crate) pose: Frame,
    /// What is seen of it.
    pub(crate) look: Look,
}

/// What is seen of a body.
#[derive(Clone, Debug)]
pub(crate) enum Look {
    /// A capture bound to particles.
    Capture(Box<Staged>),
    /// Samples of its surface, in its own frame.
    Surface(Vec<Sample>),
    /// A cloth whose vertices are its particles.
    Cloth(Cloth),
    /// A mesh whose Gaussians are tied to its vertices or triangles, and to how many particles each vertex is.
    Mesh(Box<MeshSurfels>, usize),
    /// Its particles: their spacing \[m\] and colour, linear RGB.
    Dots(f64, [f64; 3]),
    /// The same for smoke, which is seen through.
    Smoke(f64, [f64; 3]),
}

/// A cloth as it is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Cloth {
    /// Its vertices in its own frame \[m\], in the order in which its solver shows them.
    pub(crate) rest: Vec<Vec3>,
    /// What is between them.
    pub(crate) fabric: Fabric,
    /// Distance of the vertices \[m\] and colour, linear RGB, for a solver that shows other ones.
    pub(crate) dots: (f64, [f64; 3]),
}

impl Cloth {
    /// Whether these particles at t = 0 are its vertices: a solver may cut a plain sheet in its own way.
    fn is_of(&self, pose: &Frame, position: &[Vec3]) -> bool {
        let near = |(rest, now): (&Vec3, &Vec3)| {
            (pose.point(Vector3::from(*rest)) - Vector3::from(*now)).norm() < 0.5 * self.dots.0
        };
        self.rest.len() == position.len() && self.rest.iter().zip(position).all(near)
    }
}

impl Drawn {
    /// Gaussians that are drawn of it; 0 where that is known only during the run.
    pub(crate) fn gaussians(&self) -> u64 {
        match &self.look {
            Look::Capture(staged) => staged.splats.len() as u64,
            Look::Surface(samples) => samples.len() as u64,
            Look::Cloth(cloth) => cloth.rest.len() as u64,
            Look::Mesh(mesh, _) => mesh.gaussians() as u64,
            Look::Dots(..) | Look::Smoke(..) => 0,
        }
    }
}

/// A drawn body during the run.
pub(super) struct Player<'a> {
    body: &'a Drawn,
    frame: OutputFrame,
    /// Whether the colours of a capture turn with it.
    turns_colours: bool,
    light: Light,
    /// Of a capture: how it stood at the first frame.
    shown: Option<Shown<'a>>,
    /// Of a mesh: what its vertices follow since the first frame.
    worn: Option<Worn>,
    /// Of a cloth: whether its solver shows the vertices that were prepared.
    is_woven: bool,
    /// Its Gaussians now.
    pub(super) splats: Splats,
    /// Whether anything about them changed in the last frame.
    has_moved: bool,
    last: Option<VisualState>,
}

impl<'a> Player<'a> {
    pub(super) fn new(body: &'a Drawn, frame: OutputFrame, turns_colours: bool) -> Self {
        let light = Light::default();
        let splats = match &body.look {
            Look::Surface(samples) => lit(samples, &body.pose, &light, &frame),
            // A collider never hears of a state.
            Look::Mesh(mesh, _) => mesh.drawn(&mesh.posed(&body.pose), &light, &frame).unwrap_or_default(),
            Look::Capture(_) | Look::Cloth(_) | Look::Dots(..) | Look::Smoke(..) => Splats::default(),
        };
        Self {
            body,
            frame,
            turns_colours,
            light,
            shown: None,
            worn: None,
            is_woven: false,
            splats,
            has_moved: true,
            last: None,
        }
    }

    /// Name of the body.
    pub(super) fn name(&self) -> &str {
        &self.body.name
    }

    /// Whether no solver moves it.
    pub(super) fn is_still(&self) -> bool {
        self.last.is_none()
    }

    /// Follows a state.
    ///
    /// # Errors
    /// In words, when the state does not fit what was prepared.
    pub(super) fn follow(&mut self, state: &VisualState) -> Result<(), String> {
        self.has_moved = self.last.as_ref() != Some(state);
        if !self.has_moved {
            return Ok(());
        }
        let wrong = |what: String| format!("body `{}`: {what}", self.body.name);
        match (&self.body.look, state) {
            (Look::Capture(staged), VisualState::Particles { position, gradient }) => {
                if self.shown.is_none() {
                    let shown = staged.shown(&self.body.pose, &self.frame, Some(position));
                    self.shown = Some(shown.map_err(|e| wrong(e.to_string()))?);
                }
                let limits = Limits { stretch: Some(STRETCH), keep_colours: !self.turns_colours };
                let gradients = (!gradient.is_empty()).then_some(gradient.as_slice());
                let shown = self.shown.as_ref().ok_or_else(|| wrong("it is not staged".to_owned()))?;
                shown.deformed(position, gradients, limits, &mut self.splats).map_err(|e| wrong(e.to_string()))?;
            }
            (Look::Surface(samples), VisualState::Pose { position, orientation }) => {
                let pose = Frame::of_pose(*position, *orientation).map_err(|e| wrong(e.to_string()))?;
                self.splats = lit(samples, &pose, &self.light, &self.frame);
            }
            (Look::Cloth(cloth), VisualState::Particles { position, gradient }) => {
                if self.last.is_none() {
                    self.is_woven = cloth.is_of(&self.body.pose, position);
                }
                let (spacing, colour) = cloth.dots;
                let made = if self.is_woven {
                    fabric(position, &cloth.fabric, &self.light, &self.frame)
                } else {
                    lit_dots(position, gradient, spacing, colour, &self.light, &self.frame)
                };
                self.splats = made.map_err(|e| wrong(e.to_string()))?;
            }
            (Look::Mesh(mesh, neighbours), VisualState::Particles { position, .. }) => {
                if self.worn.is_none() {
                    let worn = mesh.worn(&self.body.pose, position, *neighbours);
                    self.worn = Some(worn.map_err(|e| wrong(e.to_string()))?);
                }
                let worn = self.worn.as_ref().ok_or_else(|| wrong("it is not staged".to_owned()))?;
                let vertices = worn.vertices(position).map_err(|e| wrong(e.to_string()))?;
                let made = mesh.drawn(&vertices, &self.light, &self.frame);
                self.splats = made.map_err(|e| wrong(e.to_string()))?;
            }
            (Look::Mesh(mesh, _), VisualState::Pose { position, orientation }) => {
                let pose = Frame::of_pose(*position, *orientation).map_err(|e| wrong(e.to_string()))?;
                let made = mesh.drawn(&mesh.posed(&pose), &self.light, &self.frame);
                self.splats = made.map_err(|e| wrong(e.to_string()))?;
            }
            (Look::Dots(spacing, colour), VisualState::Particles { position, gradient }) => {
                let made = lit_dots(position, gradient, *spacing, *colour, &self.light, &self.frame);
                self.splats = made.map_err(|e| wrong(e.to_string()))?;
            }
            (Look::Smoke(spacing, colour), VisualState::Particles { position, .. }) => {
                let made = puffs(position, *spacing, *colour, &self.frame);
                self.splats = made.map_err(|e| wrong(e.to_string()))?;
            }
            _ => return Err(wrong("its solver shows it in another form than was prepared".to_owned())),
        }
        self.last = Some(state.clone());
        Ok(())
    }

    /// What a recording is given of it at a frame, by entity: all of it at the first, then what has moved.
    pub(super) fn items(&self, is_first: bool) -> Vec<(String, Item)> {
        if !is_first && (self.is_still() || !self.has_moved) {
            return Vec::new();
        }
        let name = self.name();
        let (seen, felt) = (format!("world/{name}"), format!("world/boundary/{name}"));
        match (&self.body.look, &self.last) {
            (Look::Surface(samples), Some(VisualState::Pose { position, orientation })) => {
                let pose = || Item::Pose(*position, *orientation);
                let mut items = vec![(format!("{seen}/surface"), Item::Fixed(self.in_own_frame(samples)))];
                items.push((
                    format!("{felt}/samples"),
                    Item::FixedDots(moment::dots(samples.iter().map(|s| s.position))),
                ));
                items.truncate(if is_first { 2 } else { 0 });
                items.extend([(seen, pose()), (felt, pose())]);
                items
            }
            (_, None) => vec![(seen, Item::Fixed(self.in_world()))],
            (_, Some(VisualState::Particles { position, .. })) => {
                let points = moment::dots(position.iter().map(|p| p.map(|v| v as f32)));
                vec![(seen, Item::Moving(self.in_world())), (felt, Item::Dots(points))]
            }
            (_, Some(VisualState::Pose { .. })) => vec![(seen, Item::Moving(self.in_world()))],
        }
    }

    /// Its Gaussians now, in the world.
    fn in_world(&self) -> Splats {
        let mut splats = self.splats.clone();
        self.frame.from_world.inverse().apply(&mut splats, Axes::Scene);
        splats
    }

    /// Its surface in its own frame, in the light in which it stands at t = 0: a pose alone moves it in a recording.
    fn in_own_frame(&self, samples: &[Sample]) -> Splats {
        let mut splats = lit(samples, &self.body.pose, &self.light, &OutputFrame::world());
        Similarity::from(self.body.pose).inverse().apply(&mut splats, Axes::Scene);
        splats
    }
}

/// Gaussians as the viewer takes them.
pub(crate) fn borrowed(splats: &Splats) -> Gaussians<'_> {
    Gaussians {
        positions: &splats.positions,
        rotations: &splats.rotations,
        log_scales: &splats.log_scales,
        opacity_logits: &splats.opacity_logits,
        sh_dc: &splats.sh_dc,
        sh_rest: &splats.sh_rest,
        sh_degree: splats.sh_degree,
        antialiased: splats.antialiased,
    }
}
