//! A rigid partner on the other side of the bus: its interface, its record, and what it does with impulses.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::{BoundaryState, Impulses, ProxyRecord, add, norm, scale};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, InterfaceView, Outputs, PartnerInput, SolverScene, ViewRole};
use cosplat_core::scene::{ContactLaw, MotionRule, PairSpec, Source};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// An interface of a body of the solver with the rock.
pub(crate) fn view(role: ViewRole, own: &str, friction: f64) -> InterfaceView {
    InterfaceView {
        id: 0,
        role,
        own: own.into(),
        partner: "rock".into(),
        partner_form: BoundaryForm::Proxy,
        partner_source: None,
        partner_pose: None,
        rule: MotionRule::Linear,
        pair: Some(PairSpec {
            a: own.into(),
            b: "rock".into(),
            static_friction: friction,
            kinetic_friction: friction,
            restitution: 0.0,
            softness_m: 0.002,
            contact: ContactLaw::Physical,
            resolver: None,
            enabled: true,
        }),
        links: Vec::new(),
    }
}

/// Lets that body meet a rock of that shape.
pub(crate) fn with_rock(scene: &mut SolverScene, own: &str, shape: &Source, friction: f64) {
    let view = view(ViewRole::ContactResolver, own, friction);
    scene.interfaces.push(InterfaceView { partner_source: Some(shape.clone()), ..view });
}

/// A free rigid ball-like body: isotropic inertia.
pub(crate) struct Rock {
    pub(crate) record: ProxyRecord,
    pub(crate) gravity: [f64; 3],
}

impl Rock {
    pub(crate) fn new(mass: f64, inertia: f64, position: [f64; 3], velocity: [f64; 3], gravity: [f64; 3]) -> Self {
        let record = ProxyRecord {
            position,
            orientation: super::UPRIGHT,
            linear_velocity: velocity,
            angular_velocity: [0.0; 3],
            mass,
            inertia: [inertia, inertia, inertia, 0.0, 0.0, 0.0],
            share: 1.0,
            background_linear: gravity,
            background_angular: [0.0; 3],
        };
        Self { record, gravity }
    }

    pub(crate) fn inputs(&self, length_s: f64) -> Inputs {
        let now = BoundaryState::Proxy(self.record);
        let partner = PartnerInput { interface: 0, rule: MotionRule::Linear, now, next: None, length_s };
        Inputs { partners: vec![partner], impulses: Vec::new() }
    }

    /// Takes the impulse of a window of that length, then moves.
    pub(crate) fn take(&mut self, outputs: &Outputs, length_s: f64) {
        let Impulses::Rigid(j) = &outputs.impulses[0].1 else { panic!("a rigid impulse") };
        let r = &mut self.record;
        let gained = add(scale(j.linear, 1.0 / r.mass), scale(self.gravity, length_s));
        r.linear_velocity = add(r.linear_velocity, gained);
        r.angular_velocity = add(r.angular_velocity, scale(j.angular, 1.0 / r.inertia[0]));
        r.position = add(r.position, scale(r.linear_velocity, length_s));
        let [x, y, z, w] = r.orientation;
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(scale(r.angular_velocity, length_s)));
        let q = turn * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        r.orientation = [q.i, q.j, q.k, q.w];
    }
}

/// Source of a body whose triangles were prepared.
pub(crate) fn mesh_source() -> Source {
    Source::Mesh { file: "rock.obj".into(), metres_per_unit: 1.0, up: "+z".into() }
}

/// An octahedron of that radius about `center`, each face cut into 4^`times` triangles and pushed out to the ball.
pub(crate) fn ball(center: [f64; 3], radius: f64, times: usize) -> TriangleMesh {
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    for k in 0..3 {
        for sign in [1.0, -1.0] {
            vertices.push([0, 1, 2].map(|i| if i == k { sign * radius } else { 0.0 }));
        }
    }
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..times {
        let mut known = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32, vertices: &mut Vec<[f64; 3]>| {
            *known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = add(vertices[a as usize], vertices[b as usize]);
                vertices.push(scale(sum, radius / norm(sum)));
                vertices.len() as u32 - 1
            })
        };
        let cut = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) = (middle(a, b, &mut vertices), middle(b, c, &mut vertices), middle(c, a, &mut vertices));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    TriangleMesh { vertices_m: vertices.into_iter().map(|v| add(v, center)).collect(), triangles }
}

/// A box of twelve triangles about `center`.
pub(crate) fn brick(center: [f64; 3], size: [f64; 3]) -> TriangleMesh {
    let corner = |i: usize| [0, 1, 2].map(|k| center[k] + if i >> k & 1 == 1 { 0.5 } else { -0.5 } * size[k]);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriangleMesh {
        vertices_m: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}
