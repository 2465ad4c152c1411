//! Bodies as Gaussians: a capture that its particles deform, a surface that its pose carries, particles themselves.

use cosplat_core::visual::VisualState;
use cosplat_splat::bind::Frame;
use cosplat_splat::skin::Limits;
use cosplat_splat::stage::{Shown, Staged};
use cosplat_splat::surfel::{Light, Sample, dots, lit};
use cosplat_splat::{OutputFrame, Splats};

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
    /// Its particles: their spacing \[m\] and colour, linear RGB.
    Dots(f64, [f64; 3]),
}

impl Drawn {
    /// Gaussians that are drawn of it; 0 where that is known only during the run.
    pub(crate) fn gaussians(&self) -> u64 {
        match &self.look {
            Look::Capture(staged) => staged.splats.len() as u64,
            Look::Surface(samples) => samples.len() as u64,
            Look::Dots(..) => 0,
        }
    }
}

/// A drawn body during the run.
pub(super) struct Player<'a> {
    body: &'a Drawn,
    frame: OutputFrame,
    light: Light,
    /// Of a capture: how it stood at the first frame.
    shown: Option<Shown<'a>>,
    /// Its Gaussians now.
    pub(super) splats: Splats,
    /// Whether anything about them changed in the last frame.
    pub(super) has_moved: bool,
    last: Option<VisualState>,
}

impl<'a> Player<'a> {
    pub(super) fn new(body: &'a Drawn, frame: OutputFrame) -> Self {
        let light = Light::default();
        let splats = match &body.look {
            Look::Surface(samples) => lit(samples, &body.pose, &light, &frame),
            Look::Capture(_) | Look::Dots(..) => Splats::default(),
        };
        Self { body, frame, light, shown: None, splats, has_moved: true, last: None }
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
                let limits = Limits { stretch: Some(STRETCH) };
                let gradients = (!gradient.is_empty()).then_some(gradient.as_slice());
                let shown = self.shown.as_ref().ok_or_else(|| wrong("it is not staged".to_owned()))?;
                shown.deformed(position, gradients, limits, &mut self.splats).map_err(|e| wrong(e.to_string()))?;
            }
            (Look::Surface(samples), VisualState::Pose { position, orientation }) => {
                let pose = Frame::of_pose(*position, *orientation).map_err(|e| wrong(e.to_string()))?;
                self.splats = lit(samples, &pose, &self.light, &self.frame);
            }
            (Look::Dots(spacing, colour), VisualState::Particles { position, gradient }) => {
                let made = dots(position, gradient, *spacing, *colour, &self.frame);
                self.splats = made.map_err(|e| wrong(e.to_string()))?;
            }
            _ => return Err(wrong("its solver shows it in another form than was prepared".to_owned())),
        }
        self.last = Some(state.clone());
        Ok(())
    }
}
