//! Particle-substeps a second of a block of 100 000 particles, eight a cell: elastic in free flight, plastic, on a floor and
//! below a rock of triangles; sand, snow and liquid on a floor.
//!
//! What bounds it (two cores of an AVX2 machine at about 3 GHz, 30 GB/s together):
//! - memory: a substep reads and writes 108 B of each particle twice, once to the tile (read) and once from it (read
//!   and write), about 300 B: 30 GB/s / 300 B = 100 M/s. The tiles (8 KiB) stay in the first-level cache. A capture adds
//!   36 B of deformation gradient, read and written: 370 B, 80 M/s.
//! - arithmetic: about 110 four-lane operations each way for the transfers, 150 for stress, strain and weights of four
//!   particles, which is 260 a particle; at two a cycle 130 cycles, so 23 M/s a core, 46 M/s on two.
//! - contact: a place reads and changes 27 nodes in double precision each pass, about 0.1 µs, on one thread. The floor
//!   below this block has 2116 places: 15 passes take 3 ms, where the particles take 5 ms on one thread.
//!
//! Run with `cargo bench -p cosplat-mpm`.

#![expect(clippy::unwrap_used, reason = "a benchmark may stop")]

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use cosplat_core::asset::{Asset, ParticleCloud, TriangleMesh};
use cosplat_core::boundary::{BoundaryState, ProxyRecord, add, norm, scale};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, InterfaceView, PartnerInput, Plugin, SolverScene, Steady, Step, ViewRole};
use cosplat_core::scene::{
    Action, ActionKind, Body, ContactLaw, Fill, Material, MotionRule, PairSpec, Pose, SNOW, Source, Space,
    StaticCollider, VelocityField, Wall,
};
use cosplat_core::time::{Clock, Span};
use cosplat_mpm::{Mpm, Real};

/// Edge of the block and distance of its particles \[m\].
const EDGE: f64 = 46.0 / 128.0;
const SPACING: f64 = 1.0 / 128.0;
const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// A flying and turning cube of 46³ particles, or of 100³.
fn scene(material: Material, threads: usize, edge: f64) -> SolverScene {
    let spin = VelocityField::Twist { linear_m_s: [0.3, 0.1, 0.0], angular_rad_s: [0.0, 1.0, 2.0] };
    let body = Body {
        name: "block".into(),
        solver: "mpm".into(),
        material,
        source: Source::Box { size_m: [edge; 3] },
        pose: Pose { position_m: [0.1, 0.2, 0.3], orientation: UPRIGHT },
        mass_kg: None,
        spacing_m: Some(SPACING),
        velocity: spin,
        prescribed: None,
        regions: Vec::new(),
        color: None,
    };
    let kind = ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -9.81] };
    SolverScene {
        participant: "mpm".into(),
        threads,
        clock: Clock { tick_s: 5e-4, windows: 1000 },
        space: Space::Full,
        bodies: vec![body],
        statics: Vec::new(),
        links: Vec::new(),
        joints: Vec::new(),
        actions: vec![Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None }],
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: Vec::new(),
        params: serde_json::Map::new(),
        assets: std::collections::BTreeMap::new(),
    }
}

/// The block at rest on a floor, as a capture that carries total deformation gradients when `carry`.
fn resting(material: Material, threads: usize, carry: bool) -> SolverScene {
    let mut scene = scene(material, threads, EDGE);
    let block = &mut scene.bodies[0];
    block.velocity = VelocityField::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] };
    block.pose.position_m = [0.0, 0.0, 0.5 * EDGE];
    scene.statics.push(StaticCollider {
        name: "floor".into(),
        source: Source::Plane { size_m: None },
        pose: Pose { position_m: [0.0; 3], orientation: UPRIGHT },
        wall: Wall::Friction { static_friction: 0.5, kinetic_friction: 0.5 },
        motion: None,
        color: None,
    });
    if carry {
        let n = 46;
        let at = |i: usize| ((i as f64 + 0.5) / n as f64 - 0.5) * EDGE;
        let position_m: Vec<[f64; 3]> = (0..n * n * n).map(|i| [i / (n * n), i / n % n, i % n].map(at)).collect();
        let volume_m3 = vec![SPACING.powi(3); position_m.len()];
        let cloud = ParticleCloud { spacing_m: SPACING, position_m, volume_m3 };
        scene.assets.insert("block".into(), Arc::new(Asset::Particles(cloud)));
        block.source = Source::Splat {
            file: "block.ply".into(),
            metres_per_unit: 1.0,
            up: "+z".into(),
            min_opacity: 0.0,
            keep_box: None,
            fill: Fill::default(),
        };
    }
    scene
}

/// An octahedron of that radius, each face cut into 4^`times` triangles and pushed out to a ball.
fn ball(radius: f64, times: usize) -> TriangleMesh {
    let mut vertices_m: Vec<[f64; 3]> = Vec::new();
    for k in 0..3 {
        for sign in [1.0, -1.0] {
            vertices_m.push([0, 1, 2].map(|i| if i == k { sign * radius } else { 0.0 }));
        }
    }
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..times {
        let mut known = BTreeMap::new();
        let mut middle = |a: u32, b: u32, vertices: &mut Vec<[f64; 3]>| {
            *known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = add(vertices[a as usize], vertices[b as usize]);
                vertices.push(scale(sum, radius / norm(sum)));
                vertices.len() as u32 - 1
            })
        };
        let cut = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) =
                (middle(a, b, &mut vertices_m), middle(b, c, &mut vertices_m), middle(c, a, &mut vertices_m));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    TriangleMesh { vertices_m, triangles }
}

/// A rock of 2048 triangles that presses on the block from above, and what is heard of it.
fn with_rock(mut scene: SolverScene) -> (SolverScene, Inputs) {
    let radius = 0.06;
    scene.assets.insert("rock".into(), Arc::new(Asset::Mesh(ball(radius, 4))));
    scene.interfaces.push(InterfaceView {
        id: 0,
        role: ViewRole::ContactResolver,
        own: "block".into(),
        partner: "rock".into(),
        partner_form: BoundaryForm::Proxy,
        partner_source: Some(Source::Mesh { file: "rock.obj".into(), metres_per_unit: 1.0, up: "+z".into() }),
        partner_pose: None,
        rule: MotionRule::Linear,
        pair: Some(PairSpec {
            a: "block".into(),
            b: "rock".into(),
            static_friction: 0.5,
            kinetic_friction: 0.5,
            restitution: 0.0,
            softness_m: 0.0,
            contact: ContactLaw::Physical,
            resolver: None,
            enabled: true,
        }),
        links: Vec::new(),
    });
    let record = ProxyRecord {
        position: [0.01, 0.02, EDGE + radius - 0.01],
        orientation: UPRIGHT,
        linear_velocity: [0.0, 0.0, -1.0],
        angular_velocity: [0.0; 3],
        mass: 0.5,
        inertia: [7e-4, 7e-4, 7e-4, 0.0, 0.0, 0.0],
        share: 1.0,
        background_linear: [0.0, 0.0, -9.81],
        background_angular: [0.0; 3],
    };
    let now = BoundaryState::Proxy(record);
    let partner = PartnerInput { interface: 0, rule: MotionRule::Linear, now, next: None, length_s: 1e-3 };
    (scene, Inputs { partners: vec![partner], impulses: Vec::new() })
}

fn measure<R: Real>(name: &str, (scene, inputs): &(SolverScene, Inputs)) {
    let mut plugin = Mpm::<R>::default();
    let begin = Instant::now();
    let setup = plugin.setup(scene).unwrap();
    let (threads, particles, set_up) = (scene.threads, setup.particles[0], begin.elapsed().as_secs_f64());
    let (mut rates, mut places, mut passes) = (Vec::new(), 0, 0);
    for window in 0..8 {
        let span = Span { from: scene.clock.start_of(window), to: scene.clock.start_of(window + 1) };
        let start = Instant::now();
        let out = plugin.advance(&Step::new(&scene.clock, window, span), inputs, &mut Steady).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        places = out.report.counters["contact-places"] / out.report.substeps;
        passes = out.report.counters["contact-passes"] / out.report.substeps;
        rates.push((particles * out.report.substeps) as f64 / seconds * 1e-6);
    }
    rates.sort_by(f64::total_cmp);
    let mut bytes = Vec::new();
    plugin.save(&mut bytes);
    println!(
        "{name:28} {threads} threads {particles:7} particles {:3} B each: {:6.2} M/s ({:.2} to {:.2}), {places:4} places, {passes} passes, \
         set up in {set_up:.2} s",
        bytes.len() as u64 / particles,
        rates[rates.len() / 2],
        rates[0],
        rates[rates.len() - 1],
    );
}

fn main() {
    let elastic =
        Material::Elastic { density_kg_m3: 30.0, youngs_modulus_pa: 2e6, poissons_ratio: 0.22, viscosity_pa_s: 0.0 };
    let plastic = |yield_stress_pa| Material::Elastoplastic {
        density_kg_m3: 30.0,
        youngs_modulus_pa: 2e6,
        poissons_ratio: 0.22,
        yield_stress_pa,
    };
    let (density_kg_m3, poissons_ratio) = (1600.0, 0.2);
    let sand = Material::Granular {
        density_kg_m3,
        youngs_modulus_pa: 1e6,
        poissons_ratio,
        friction_angle_deg: 30.0,
        cohesion_pa: 0.0,
    };
    let [critical_compression, critical_stretch, hardening] = SNOW;
    let snow = Material::Snow {
        density_kg_m3: 400.0,
        youngs_modulus_pa: 1.4e5,
        poissons_ratio,
        critical_compression,
        critical_stretch,
        hardening,
    };
    let liquid = |viscosity_pa_s| Material::MpmLiquid { density_kg_m3: 1000.0, bulk_modulus_pa: 4e5, viscosity_pa_s };
    let alone = |scene| (scene, Inputs::default());
    for threads in [1, 2] {
        measure::<f32>("elastic f32", &alone(scene(elastic, threads, EDGE)));
        measure::<f32>("elastoplastic f32", &alone(scene(plastic(3e4), threads, EDGE)));
        measure::<f32>("elastoplastic, flows", &alone(scene(plastic(1.0), threads, EDGE)));
        measure::<f64>("elastic f64", &alone(scene(elastic, threads, EDGE)));
        measure::<f32>("on a floor", &alone(resting(elastic, threads, false)));
        measure::<f32>("on a floor, a capture", &alone(resting(elastic, threads, true)));
        measure::<f32>("on a floor, below a rock", &with_rock(resting(elastic, threads, false)));
        measure::<f32>("sand, collapses", &alone(resting(sand, threads, false)));
        measure::<f32>("snow, on a floor", &alone(resting(snow, threads, false)));
        measure::<f32>("liquid, collapses", &alone(resting(liquid(0.0), threads, false)));
        measure::<f32>("liquid with viscosity", &alone(resting(liquid(1.0), threads, false)));
    }
    measure::<f32>("elastic f32", &alone(scene(elastic, 2, 100.0 / 128.0)));
}
