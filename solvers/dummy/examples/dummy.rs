//! The smallest legal plugin that plays both parts of a contact: copy this file to start a solver of your own.
//!
//! A plugin is any program that speaks Cosplat's protocol. In Rust that is one trait and one call: implement
//! [`Plugin`], hand it to [`run_plugin`]; no other crate is needed. `cosplat` finds the program as
//! `cosplat-solver-NAME` on the `PATH`, or by `command` in a scene:
//!
//! ```toml
//! [solver.cloud]
//! command = ["./target/release/examples/dummy"]
//! params = { drag = 2.0 }                        # 1/s
//! ```
//!
//! The physics is a cloud of equal points in free flight. As the *responder* of a contact it takes impulses; as the
//! *resolver* it drags at its partner, point by point: `J = c m (v_own - v_partner) W`, at most what makes both
//! velocities equal, and takes `-J` itself. One substep a window is exact for that, so there is no loop over substeps; a
//! solver that has one calls `pulse.beat(done, of)` in it and returns [`PluginError::Aborted`] when told to.
//!
//! What to keep when you replace the physics:
//! * refuse by name what you cannot do; cover exactly the step you were given; no clock, no file, no random numbers;
//! * impulses that came (`inputs.impulses`) act, impulses you give go out *and* act on yourself with the other sign;
//! * report momentum and energy from your own state, never from what you were sent: the ledger compares the two;
//! * `save` writes all that `advance` depends on, in one order: its hash is how runs are compared.

use std::collections::BTreeMap;
use std::process::ExitCode;

use cosplat_bus::run_plugin;
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples, Vec3, Wrench};
use cosplat_core::boundary::{add, cross, dot, norm, scale, sub};
use cosplat_core::control::PROTOCOL;
use cosplat_core::plan::{BoundaryForm, InterfaceId};
use cosplat_core::plugin::{
    BodyState, BoundaryOutput, Descriptor, Energy, Inputs, InterfaceReport, InterfaceRole, Outputs, PartnerSetup,
    Plugin, PluginError, Pulse, Report, Saves, Setup, SetupBoundary, SolverScene, StateReader, StateSink, Step,
};
use cosplat_core::scene::{Body, Source, VelocityField};

/// JSON Schema of `params`: what a scene may set, checked before any process starts.
const PARAMS: &str = r#"{ "type": "object", "additionalProperties": false,
    "properties": { "drag": { "type": "number", "minimum": 0, "default": 1, "description": "rate c, 1/s" } } }"#;

/// Equal points in free flight. `x`, `v` and `dissipated_j` are the state, the rest comes from the scene.
#[derive(Default)]
struct Cloud {
    body: String,
    mass: f64,
    drag: f64,
    start: Vec<Vec3>,
    partner_mass: BTreeMap<InterfaceId, Vec<f64>>,
    resolves: Vec<InterfaceId>,
    x: Vec<Vec3>,
    v: Vec<Vec3>,
    dissipated_j: f64,
}

impl Plugin for Cloud {
    fn describe(&self) -> Descriptor {
        Descriptor {
            name: "dummy".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            summary: "Points in free flight that drag at their partner; the plugin to copy".into(),
            protocol: [PROTOCOL; 2],
            body_kinds: vec!["points".into(), "cloud".into()],
            materials: vec!["point-mass".into()],
            roles: vec![InterfaceRole::ResolveSamples, InterfaceRole::Respond],
            boundary: BoundaryForm::SamplesF32 { normals: false },
            features: Vec::new(),
            probes: Vec::new(),
            saves: Saves { bytes: true, deterministic: true },
            params_schema: PARAMS.parse().unwrap_or_default(),
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let [body] = &scene.bodies[..] else { return unsupported("more than one body in a process") };
        (self.x, self.v) = place(body)?;
        let Some(mass) = body.mass_kg.filter(|m| *m > 0.0) else { return unsupported("a body without `mass`") };
        self.body.clone_from(&body.name);
        self.mass = mass / self.x.len() as f64;
        self.drag = match scene.params.get("drag") {
            Some(rate) => rate.as_f64().unwrap_or(f64::NAN),
            None => 1.0,
        };
        self.resolves = scene.interfaces.iter().filter(|i| i.role.gives_impulses()).map(|i| i.id).collect();
        self.start.clone_from(&self.x);
        let n = self.x.len();
        let statics = SampleStatics {
            id: (0..n as u64).collect(),
            area_m2: vec![0.0; n],
            volume_m3: vec![0.0; n],
            mass_kg: vec![self.mass; n],
        };
        Ok(Setup {
            boundaries: vec![SetupBoundary { body: self.body.clone(), statics, state: self.boundary() }],
            report: self.report(Vec::new()),
            stable_dt: None,
            particles: vec![n as u64],
            left_out: Vec::new(),
        })
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        self.partner_mass = partners.iter().map(|p| (p.interface, p.statics.mass_kg.clone())).collect();
        let fits = |m: &Vec<f64>| m.len() == self.x.len() && m.iter().all(|m| *m > 0.0);
        let fit = self.resolves.iter().all(|id| self.partner_mass.get(id).is_some_and(fits));
        if fit { Ok(()) } else { unsupported("a partner that has not as many points, all with mass") }
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, _: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let mut given = Vec::new();
        let mut taken = Vec::new();
        for &id in &self.resolves {
            let Some(BoundaryState::Samples(partner)) = inputs.partner(id).map(|p| &p.now) else { continue };
            let pull = drag(&self.v, &partner.velocity, self.mass, &self.partner_mass[&id], self.drag * step.length_s);
            self.dissipated_j += pull.iter().map(|(_, lost_j)| lost_j).sum::<f64>();
            taken.push((id, true, pull.iter().map(|&(j, _)| scale(j, -1.0)).collect()));
            given.push((id, Impulses::Samples(pull.into_iter().map(|(j, _)| j).collect())));
        }
        for input in &inputs.impulses {
            let Impulses::Samples(each) = &input.impulses else { return unsupported("a wrench on points") };
            taken.push((input.interface, input.spread, each.clone()));
        }
        let interfaces = self.fly(step.length_s, &taken);
        if !self.x.iter().chain(&self.v).flatten().all(|c| c.is_finite()) {
            return Err(PluginError::Physics(format!("a point of `{}` is nowhere", self.body)));
        }
        let boundaries = vec![BoundaryOutput { body: self.body.clone(), state: self.boundary() }];
        Ok(Outputs { boundaries, impulses: given, report: self.report(interfaces) })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        sink.vec3s(&self.x);
        sink.vec3s(&self.v);
        sink.f64(self.dissipated_j);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(state);
        let (n, what) = (self.x.len(), "points");
        let (x, v, dissipated_j) = (reader.vec3s(what, n)?, reader.vec3s(what, n)?, reader.f64()?);
        reader.end()?;
        (self.x, self.v, self.dissipated_j) = (x, v, dissipated_j);
        Ok(())
    }
}

impl Cloud {
    /// Moves every point under the impulses taken: (interface, spread over the step or at once, one per point).
    fn fly(&mut self, length_s: f64, taken: &[(InterfaceId, bool, Vec<Vec3>)]) -> Vec<InterfaceReport> {
        let mut reports: Vec<_> =
            taken.iter().map(|t| InterfaceReport { interface: t.0, ..Default::default() }).collect();
        for (i, (x, v)) in self.x.iter_mut().zip(&mut self.v).enumerate() {
            for spread in [false, true] {
                let now = || taken.iter().zip(0..).filter(move |(t, _)| t.1 == spread);
                let sum = now().fold([0.0; 3], |sum, (t, _)| add(sum, t.2[i]));
                let mean = add(*v, scale(sum, 0.5 / self.mass));
                // Under a constant force the impulse acts, on average, at where the point would be halfway without it.
                let arm = if spread { add(*x, scale(*v, 0.5 * length_s)) } else { *x };
                for (t, r) in now() {
                    let own = Wrench { linear: t.2[i], angular: cross(arm, t.2[i]) };
                    reports[r].received = reports[r].received.plus(own);
                    reports[r].gross += norm(t.2[i]);
                    reports[r].work_j += dot(t.2[i], mean);
                }
                if spread {
                    *x = add(*x, scale(mean, length_s));
                }
                *v = add(*v, scale(sum, 1.0 / self.mass));
            }
        }
        reports
    }

    fn boundary(&self) -> BoundaryState {
        BoundaryState::Samples(Samples { position: self.x.clone(), velocity: self.v.clone(), normal: Vec::new() })
    }

    fn report(&self, interfaces: Vec<InterfaceReport>) -> Report {
        let points = || self.x.iter().zip(&self.v);
        let total = |f: &dyn Fn(Vec3, Vec3) -> Vec3| {
            scale(points().fold([0.0; 3], |sum, (&x, &v)| add(sum, f(x, v))), self.mass)
        };
        let (mass_kg, linear) = (self.mass * self.x.len() as f64, total(&|_, v| v));
        let body = BodyState {
            mass_kg,
            position_m: scale(total(&|x, _| x), 1.0 / mass_kg),
            orientation: [0.0, 0.0, 0.0, 1.0],
            linear_velocity_m_s: scale(linear, 1.0 / mass_kg),
            angular_velocity_rad_s: [0.0; 3],
            momentum: Wrench { linear, angular: total(&|x, v| cross(x, v)) },
            gross_momentum: self.v.iter().map(|&v| self.mass * norm(v)).sum(),
            max_displacement_m: self.x.iter().zip(&self.start).map(|(&x, &s)| norm(sub(x, s))).fold(0.0, f64::max),
        };
        let kinetic_j = self.v.iter().map(|&v| 0.5 * self.mass * dot(v, v)).sum();
        Report {
            substeps: 1,
            substep_bound_by: "none: exact".into(),
            bodies: vec![body],
            energy: Energy { kinetic_j, dissipated_j: self.dissipated_j, ..Default::default() },
            interfaces,
            ..Default::default()
        }
    }
}

/// Impulse on each partner point and the energy that the pair loses, for the drag rate times the step `cw`.
fn drag(own: &[Vec3], partner: &[Vec3], mass: f64, partner_mass: &[f64], cw: f64) -> Vec<(Vec3, f64)> {
    let pair = |((&a, &b), &other): ((&Vec3, &Vec3), &f64)| {
        let reduced = 1.0 / (1.0 / mass + 1.0 / other);
        let j = scale(sub(a, b), (cw * mass).min(reduced));
        (j, dot(j, sub(a, b)) - 0.5 * dot(j, j) / reduced)
    };
    own.iter().zip(partner).zip(partner_mass).map(pair).collect()
}

/// Positions and velocities of a body's points in the world.
fn place(body: &Body) -> Result<(Vec<Vec3>, Vec<Vec3>), PluginError> {
    let local: Vec<Vec3> = match &body.source {
        Source::Points { positions_m } => positions_m.clone(),
        Source::Cloud { count, size_m } => {
            let edge = (*count as f64).cbrt().ceil().max(1.0) as usize;
            let at = |i: usize, k: usize| ((i / edge.pow(k as u32) % edge) as f64 + 0.5) / edge as f64 - 0.5;
            (0..*count).map(|i| std::array::from_fn(|k| size_m[k] * at(i, k))).collect()
        }
        _ => return unsupported("a body that is neither `points` nor `cloud`"),
    };
    if local.is_empty() {
        return unsupported("a body without points");
    }
    // Rotation by the unit quaternion (q, w): p + 2 q × (q × p + w p).
    let [qx, qy, qz, w] = body.pose.orientation;
    let q = [qx, qy, qz];
    let turn = |p: Vec3| add(p, scale(cross(q, add(cross(q, p), scale(p, w))), 2.0));
    let x: Vec<Vec3> = local.into_iter().map(|p| add(body.pose.position_m, turn(p))).collect();
    let centre = scale(x.iter().fold([0.0; 3], |sum, &p| add(sum, p)), 1.0 / x.len() as f64);
    let velocity = |p: Vec3| match body.velocity {
        VelocityField::Twist { linear_m_s, angular_rad_s } => add(linear_m_s, cross(angular_rad_s, sub(p, centre))),
        VelocityField::Rotation { angular_rad_s, about_m } => cross(angular_rad_s, sub(p, about_m)),
        VelocityField::LinearMap { linear_m_s, gradient_1_s, about_m } => {
            add(linear_m_s, gradient_1_s.map(|row| dot(row, sub(p, about_m))))
        }
    };
    let v = x.iter().map(|&p| velocity(p)).collect();
    Ok((x, v))
}

fn unsupported<T>(what: &str) -> Result<T, PluginError> {
    Err(PluginError::Unsupported(format!("dummy cannot handle {what}")))
}

fn main() -> ExitCode {
    run_plugin(&mut Cloud::default())
}
