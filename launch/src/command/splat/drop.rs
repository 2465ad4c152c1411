//! What filling is for: the same capture, filled in several ways, is dropped on the ground.

use std::sync::Arc;
use std::thread::available_parallelism;

use cosplat_core::asset::Asset;
use cosplat_core::boundary::Vec3;
use cosplat_core::plugin::{Inputs, Plugin, PluginError, SolverScene, Steady, Step};
use cosplat_core::scene::{
    Action, ActionKind, Body, Fill, Material, Pose, Source, Space, StaticCollider, VelocityField, Wall,
};
use cosplat_core::time::{Clock, Span};
use cosplat_core::visual::VisualState;
use cosplat_splat::bind::Frame;
use cosplat_splat::skin::Limits;
use cosplat_splat::stage::Staged;
use cosplat_splat::{OutputFrame, Splats};
use serde::Serialize;

/// Acceleration of free fall \[m/s²\].
const GRAVITY: f64 = 9.81;
/// Time in units of that until the ground is met: as long again, and half as much, to see what comes of it.
const TIMES: f64 = 2.5;
/// Moments at which shapes are measured.
pub(super) const MOMENTS: usize = 60;
/// Of them those of which Gaussians are kept: the start, the meeting, what follows.
pub(super) const SHOWN: [usize; 5] = [0, 24, 30, 42, 60];
const BODY: &str = "capture";
const POISSON: f64 = 0.3;
/// A Gaussian grows at most by this factor.
const STRETCH: f64 = 4.0;

/// How it is dropped.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Conditions {
    /// From its underside to the ground at t = 0 \[m\].
    pub(super) height_m: f64,
    /// Density of the material \[kg/m³\].
    pub(super) density_kg_m3: f64,
    /// Young's modulus \[Pa\].
    pub(super) youngs_modulus_pa: f64,
}

/// Shapes of one way over time; one number a moment in every list.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Fall {
    /// Simulated time \[s\].
    pub(super) time_s: Vec<f64>,
    /// Height of the centre of mass above the ground \[m\].
    pub(super) centre_m: Vec<f64>,
    /// From the lowest to the highest particle \[m\].
    pub(super) height_m: Vec<f64>,
    /// Root mean square distance of the mass from the vertical line through its centre \[m\].
    pub(super) width_m: Vec<f64>,
    /// Gaussians at the moments of [`SHOWN`], in metres.
    #[serde(skip)]
    pub(super) shown: Vec<Splats>,
}

/// Drops a body made of a capture on a plane to which nothing sticks, by the material point method in one process.
///
/// # Errors
/// In words, where the solver cannot take or keep it.
pub(super) fn drop(method: Fill, body: &Staged, conditions: &Conditions) -> Result<Fall, String> {
    let mut plugin = crate::plugins::built_in::make("mpm").ok_or("there is no solver `mpm`")?;
    let said = |e: PluginError| e.to_string();
    let scene = scene(method, body, conditions);
    plugin.setup(&scene).map_err(said)?;
    plugin.connect(&[]).map_err(said)?;
    let pose =
        Frame::of_pose(scene.bodies[0].pose.position_m, scene.bodies[0].pose.orientation).map_err(|e| e.to_string())?;
    let (initial, _) = particles(&*plugin)?;
    let shown = body.shown(&pose, &OutputFrame::world(), Some(&initial)).map_err(|e| e.to_string())?;
    let mut fall = Fall::default();
    for moment in 0..=MOMENTS {
        let (places, gradients) = particles(&*plugin)?;
        fall.measure(scene.clock.seconds(scene.clock.start_of(moment as u64)), &places, &body.cloud.volume_m3);
        if SHOWN.contains(&moment) {
            let mut splats = Splats::default();
            let gradients = (!gradients.is_empty()).then_some(gradients.as_slice());
            let limits = Limits { stretch: Some(STRETCH), ..Limits::default() };
            shown.deformed(&places, gradients, limits, &mut splats).map_err(|e| e.to_string())?;
            fall.shown.push(splats);
        }
        if moment < MOMENTS {
            let window = moment as u64;
            let span = Span { from: scene.clock.start_of(window), to: scene.clock.start_of(window + 1) };
            plugin.advance(&Step::new(&scene.clock, window, span), &Inputs::default(), &mut Steady).map_err(said)?;
        }
    }
    Ok(fall)
}

fn particles(plugin: &dyn Plugin) -> Result<(Vec<Vec3>, Vec<[f32; 9]>), String> {
    match plugin.visual(BODY) {
        Some(VisualState::Particles { position, gradient }) => Ok((position, gradient)),
        _ => Err("the solver shows no particles".to_owned()),
    }
}

fn scene(method: Fill, body: &Staged, conditions: &Conditions) -> SolverScene {
    let Conditions { height_m, density_kg_m3, youngs_modulus_pa } = *conditions;
    let free = (2.0 * height_m / GRAVITY).sqrt();
    let lowest = body.cloud.position_m.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
    let upright = [0.0, 0.0, 0.0, 1.0];
    let captured = Body {
        name: BODY.to_owned(),
        solver: "mpm".to_owned(),
        material: Material::Elastic { density_kg_m3, youngs_modulus_pa, poissons_ratio: POISSON, viscosity_pa_s: 0.0 },
        source: Source::Splat {
            file: BODY.to_owned(),
            metres_per_unit: 1.0,
            up: "+z".to_owned(),
            min_opacity: 0.0,
            keep_box: None,
            fill: method,
        },
        pose: Pose { position_m: [0.0, 0.0, height_m - lowest], orientation: upright },
        mass_kg: None,
        spacing_m: Some(body.cloud.spacing_m),
        velocity: VelocityField::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] },
        prescribed: None,
        regions: Vec::new(),
        color: None,
    };
    let ground = StaticCollider {
        name: "ground".to_owned(),
        source: Source::Plane { size_m: None },
        pose: Pose { position_m: [0.0; 3], orientation: upright },
        wall: Wall::Slip,
        motion: None,
        color: None,
    };
    let kind = ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -GRAVITY] };
    SolverScene {
        participant: "mpm".to_owned(),
        threads: available_parallelism().map_or(1, usize::from),
        clock: Clock::new(TIMES * free, MOMENTS as u64),
        space: Space::Full,
        bodies: vec![captured],
        statics: vec![ground],
        links: Vec::new(),
        joints: Vec::new(),
        actions: vec![Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None }],
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: Vec::new(),
        params: serde_json::Map::new(),
        assets: [(BODY.to_owned(), Arc::new(Asset::Particles(body.cloud.clone())))].into(),
    }
}

impl Fall {
    fn measure(&mut self, time_s: f64, places: &[Vec3], volumes: &[f64]) {
        let whole: f64 = volumes.iter().sum();
        let mean = |of: &dyn Fn(&Vec3) -> f64| {
            places.iter().zip(volumes).map(|(p, v)| v * of(p)).sum::<f64>() / whole.max(f64::MIN_POSITIVE)
        };
        let centre = [0, 1, 2].map(|k| mean(&|p| p[k]));
        let low = places.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
        let high = places.iter().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
        self.time_s.push(time_s);
        self.centre_m.push(centre[2]);
        self.height_m.push(high - low);
        self.width_m.push(mean(&|p| (p[0] - centre[0]).powi(2) + (p[1] - centre[1]).powi(2)).sqrt());
    }

    /// Its height at the end beside that at the start, and the smallest one: how far it is squashed and stays so.
    pub(super) fn squashed(&self) -> [f64; 2] {
        let first = self.height_m.first().copied().unwrap_or(f64::NAN);
        let least = self.height_m.iter().copied().fold(f64::INFINITY, f64::min);
        [least / first, self.height_m.last().copied().unwrap_or(f64::NAN) / first]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_splat::format::Decoded;
    use cosplat_splat::stage::Recipe;

    /// A sphere of 10 cm radius as its Gaussians are seen: on the surface alone.
    fn shell() -> Decoded {
        let n = 4000_u32;
        let place = |i: u32| {
            // Fibonacci's lattice: equal areas.
            let (z, angle) = (1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n), 2.399_963 * f64::from(i));
            let r = (1.0 - z * z).sqrt();
            [r * angle.cos(), r * angle.sin(), z].map(|v| (0.1 * v) as f32)
        };
        let n = n as usize;
        let splats = Splats {
            positions: (0..n as u32).map(place).collect(),
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
            log_scales: vec![[-5.5; 3]; n],
            opacity_logits: vec![4.0; n],
            sh_dc: vec![[0.0; 3]; n],
            ..Splats::default()
        };
        Decoded { splats, notes: Vec::new() }
    }

    #[test]
    fn a_hollow_shell_is_squashed_further_than_a_filled_one() {
        let conditions = Conditions { height_m: 0.1, density_kg_m3: 300.0, youngs_modulus_pa: 2e4 };
        let fall = |method| {
            let recipe = Recipe::new(1.0, [0.0, 0.0, 1.0], 0.0125);
            let recipe =
                Recipe { method, fill: cosplat_splat::fill::Settings { on_ground: false, ..recipe.fill }, ..recipe };
            drop(method, &Staged::new(shell(), &recipe).unwrap(), &conditions).unwrap()
        };
        let [filled, hollow] = [Fill::Winding, Fill::None].map(fall);
        for fall in [&filled, &hollow] {
            assert_eq!((fall.time_s.len(), fall.shown.len()), (MOMENTS + 1, SHOWN.len()));
            // Free fall by half of the way: h = g t²/2, to the first order of the solver's step, a part of 10⁻³ of it.
            let half = fall.time_s.iter().position(|t| GRAVITY * t * t / 2.0 > 0.05).unwrap();
            let fallen = fall.centre_m[0] - fall.centre_m[half];
            assert!((fallen / (GRAVITY * fall.time_s[half].powi(2) / 2.0) - 1.0).abs() < 0.02, "{fallen}");
        }
        let [[full, _], [empty, _]] = [filled.squashed(), hollow.squashed()];
        println!("squashed to {full:.3} filled and {empty:.3} hollow");
        assert!(empty < full && full < 1.0, "{empty} {full}");
    }
}
