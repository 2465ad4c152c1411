//! A plugin whose state depends on every bit it has ever been given, and on nothing else.

use xxhash_rust::xxh3::xxh3_64;

use crate::asset::Asset;
use crate::boundary::{BoundaryState, Impulses, ProxyRecord, SampleStatics, Samples, Vec3, Wrench};
use crate::control::PROTOCOL;
use crate::plan::{BoundaryForm, InterfaceId};
use crate::plugin::{
    BodyState, BoundaryOutput, Descriptor, Inputs, InterfaceRole, Outputs, PartnerSetup, Plugin, PluginError, Pulse,
    Report, Saves, Setup, SetupBoundary, SolverScene, StateReader, StateSink, Step,
};
use crate::scene::Source;
use crate::visual::{VisualForm, VisualFrame, VisualState};

/// The plugin.
#[derive(Clone, Debug, Default)]
pub(super) struct Toy {
    rigid: bool,
    bodies: Vec<(String, usize)>,
    gives: Vec<(InterfaceId, usize)>,
    partner_sizes: Vec<(InterfaceId, usize)>,
    state: Vec<u64>,
    drawn: Vec<(u64, u64)>,
}

/// Name of the plugin that shows its bodies as rigid.
pub(super) const RIGID: &str = "rigid-toy";

/// Descriptor of the toy.
pub(super) fn descriptor() -> Descriptor {
    Descriptor {
        name: "toy".to_owned(),
        version: "1".to_owned(),
        summary: "mixes bits".to_owned(),
        protocol: [PROTOCOL; 2],
        body_kinds: vec!["cloud".to_owned()],
        materials: vec!["point-mass".to_owned()],
        roles: vec![
            InterfaceRole::ResolveSamples,
            InterfaceRole::ResolveProxy,
            InterfaceRole::Respond,
            InterfaceRole::Link,
        ],
        boundary: BoundaryForm::SamplesF64 { normals: false },
        visual: Some(VisualForm::Particles { gradients: false }),
        features: Vec::new(),
        probes: Vec::new(),
        saves: Saves { bytes: true, deterministic: true },
        params_schema: serde_json::json!({}),
    }
}

/// Descriptor of a toy that shows its bodies as rigid.
pub(super) fn rigid_descriptor() -> Descriptor {
    Descriptor { name: RIGID.to_owned(), boundary: BoundaryForm::Proxy, ..descriptor() }
}

impl Toy {
    /// A toy of that plugin.
    pub(super) fn of(plugin: &str) -> Self {
        Self { rigid: plugin == RIGID, ..Self::default() }
    }

    /// A number in [0, 1) from a state and a place.
    fn number(&self, body: usize, place: usize) -> f64 {
        let mixed = xxh3_64(bytemuck::cast_slice(&[self.state[body], place as u64]));
        (mixed >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vectors(&self, body: usize, count: usize, shift: usize) -> Vec<Vec3> {
        // One number a sample would do; three hashes a sample make large messages slow.
        (0..count).map(|i| [self.number(body, shift + i % 64), i as f64, shift as f64]).collect()
    }

    fn boundary(&self, body: usize) -> BoundaryState {
        let count = self.bodies[body].1;
        if self.rigid {
            let any = |from: usize| [0, 1, 2].map(|i| self.number(body, from + i));
            return BoundaryState::Proxy(ProxyRecord {
                position: any(0),
                orientation: [0.0, 0.0, 0.0, 1.0],
                linear_velocity: any(3),
                angular_velocity: any(6),
                mass: 1.0,
                inertia: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
                share: 1.0,
                background_linear: [0.0; 3],
                background_angular: [0.0; 3],
            });
        }
        BoundaryState::Samples(Samples {
            position: self.vectors(body, count, 0),
            velocity: self.vectors(body, count, 64),
            normal: Vec::new(),
        })
    }

    fn mix(&mut self, bytes: &[u8]) {
        for (i, state) in self.state.iter_mut().enumerate() {
            *state = xxh3_64(bytemuck::cast_slice(&[*state, i as u64, xxh3_64(bytes)]));
        }
    }

    /// Frames it was given since the last time it was asked: number, and a hash of what they show.
    pub(super) fn take_drawn(&mut self) -> Vec<(u64, u64)> {
        std::mem::take(&mut self.drawn)
    }

    /// Numbers that follow from the state, so that the ledger has something to compare.
    fn report(&self) -> Report {
        let body = |i: usize| BodyState {
            position_m: [self.number(i, 1), self.number(i, 2), 0.0],
            momentum: Wrench { linear: [self.number(i, 3); 3], angular: [self.number(i, 4); 3] },
            gross_momentum: self.number(i, 5),
            ..BodyState::default()
        };
        Report { bodies: (0..self.bodies.len()).map(body).collect(), ..Report::default() }
    }
}

impl Plugin for Toy {
    fn describe(&self) -> Descriptor {
        descriptor()
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        for body in &scene.bodies {
            let Source::Cloud { count, .. } = body.source else {
                return Err(PluginError::Unsupported(format!("body `{}` is no cloud", body.name)));
            };
            self.bodies.push((body.name.clone(), count));
            self.state.push(xxh3_64(body.name.as_bytes()));
        }
        for (name, asset) in &scene.assets {
            self.mix(name.as_bytes());
            if let Asset::Particles(cloud) = &**asset {
                self.mix(bytemuck::cast_slice(&cloud.position_m));
            }
        }
        self.gives = scene.interfaces.iter().filter(|v| v.role.gives_impulses()).map(|v| (v.id, 0)).collect();
        let boundaries = (0..self.bodies.len()).map(|i| SetupBoundary {
            body: self.bodies[i].0.clone(),
            statics: SampleStatics {
                id: vec![0; self.bodies[i].1],
                area_m2: vec![0.0; self.bodies[i].1],
                volume_m3: vec![0.0; self.bodies[i].1],
                mass_kg: vec![1.0; self.bodies[i].1],
            },
            state: self.boundary(i),
        });
        Ok(Setup {
            boundaries: boundaries.collect(),
            report: self.report(),
            stable_dt: None,
            particles: self.bodies.iter().map(|b| b.1 as u64).collect(),
            left_out: Vec::new(),
        })
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        self.partner_sizes = partners.iter().map(|p| (p.interface, p.statics.len())).collect();
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, _pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        self.mix(&step.window.to_le_bytes());
        self.mix(&step.span.from.to_le_bytes());
        for partner in &inputs.partners {
            for state in [Some(&partner.now), partner.next.as_ref()].into_iter().flatten() {
                match state {
                    BoundaryState::Samples(s) => {
                        self.mix(bytemuck::cast_slice(&s.position));
                        self.mix(bytemuck::cast_slice(&s.velocity));
                    }
                    BoundaryState::Proxy(p) => {
                        self.mix(bytemuck::cast_slice(&[p.position, p.linear_velocity, p.angular_velocity]));
                    }
                }
            }
        }
        for impulse in &inputs.impulses {
            match &impulse.impulses {
                Impulses::Samples(each) => self.mix(bytemuck::cast_slice(each)),
                Impulses::Rigid(wrench) => self.mix(bytemuck::cast_slice(&[wrench.linear, wrench.angular])),
            }
        }
        let size = |id: InterfaceId| {
            let known = self.partner_sizes.iter().find(|(i, n)| *i == id && *n > 0).map(|(_, n)| *n);
            known.or_else(|| match &inputs.partner(id)?.now {
                BoundaryState::Samples(s) => Some(s.position.len()),
                BoundaryState::Proxy(_) => None,
            })
        };
        let impulses = self.gives.iter().map(|&(id, _)| {
            let shift = 128 + 64 * usize::from(id);
            if let Some(BoundaryState::Proxy(_)) = inputs.partner(id).map(|p| &p.now) {
                let any = |from: usize| [0, 1, 2].map(|i| self.number(0, shift + from + i));
                return (id, Impulses::Rigid(Wrench { linear: any(0), angular: any(3) }));
            }
            (id, Impulses::Samples(self.vectors(0, size(id).unwrap_or(1), shift)))
        });
        Ok(Outputs {
            impulses: impulses.collect(),
            boundaries: (0..self.bodies.len())
                .map(|i| BoundaryOutput { body: self.bodies[i].0.clone(), state: self.boundary(i) })
                .collect(),
            report: self.report(),
        })
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let at = self.bodies.iter().position(|(name, _)| name == body)?;
        Some(VisualState::Particles { position: self.vectors(at, self.bodies[at].1, 0), gradient: Vec::new() })
    }

    fn record(&mut self, frame: &VisualFrame, _pulse: &mut dyn Pulse) -> Result<(), PluginError> {
        let mut mixed = vec![frame.number];
        for (name, state) in &frame.bodies {
            mixed.push(xxh3_64(name.as_bytes()));
            if let VisualState::Particles { position, .. } = state {
                mixed.push(xxh3_64(bytemuck::cast_slice(position)));
            }
        }
        self.drawn.push((frame.number, xxh3_64(bytemuck::cast_slice(&mixed))));
        Ok(())
    }

    fn save(&self, sink: &mut dyn StateSink) {
        self.state.iter().for_each(|&s| sink.u64(s));
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(state);
        let read: Result<Vec<u64>, _> = self.state.iter().map(|_| reader.u64()).collect();
        let read = read?;
        reader.end()?;
        self.state = read;
        Ok(())
    }
}
