//! Scenes and plugins made by hand.

use std::collections::BTreeMap;

use cosplat_core::plan::{BoundaryForm, Plan, Refusal, build};
use cosplat_core::plugin::{Descriptor, InterfaceRole, Saves, SolverScene};
use cosplat_core::scene::{Body, ContactLaw, Link, Material, PairSpec, Scene, Source, StaticCollider, Wall, read};

pub(crate) const SAMPLES: BoundaryForm = BoundaryForm::SamplesF64 { normals: false };

/// A second in windows of 0.01 s, with nothing in it.
pub(crate) fn empty() -> Scene {
    let text = "name = 'made'\n[clock]\nduration = 1.0\nwindow = 0.01\n\
                [[body]]\nname = 'b'\nsolver = 's'\nmaterial = 'point-mass'\nmass = 1.0\npoints = [[0, 0, 0]]\n";
    let (mut scene, _) = read::parse(text).expect("the text is a scene");
    scene.bodies.clear();
    scene
}

/// A body of 1 kg at the origin without spacing.
pub(crate) fn body(name: &str, solver: &str, material: Material) -> Body {
    use cosplat_core::scene::{Pose, VelocityField};
    Body {
        name: name.to_owned(),
        solver: solver.to_owned(),
        material,
        source: Source::Box { size_m: [0.1; 3] },
        pose: Pose { position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] },
        mass_kg: Some(1.0),
        spacing_m: None,
        velocity: VelocityField::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] },
        prescribed: None,
        regions: Vec::new(),
        color: None,
    }
}

/// A scene of these bodies.
pub(crate) fn scene(bodies: impl IntoIterator<Item = Body>) -> Scene {
    Scene { bodies: bodies.into_iter().collect(), ..empty() }
}

pub(crate) const RIGID: Material = Material::Rigid { density_kg_m3: 1000.0, friction: 0.5 };
pub(crate) const LIQUID: Material =
    Material::SphLiquid { density_kg_m3: 1000.0, stiffness_pa: 6e4, viscosity_pa_s: 0.1, surface_tension_n_m: 0.0 };
pub(crate) const SMOKE: Material = Material::Smoke { density_kg_m3: 1.2, viscosity: 0.1 };
pub(crate) const CLOTH: Material = Material::Cloth {
    areal_density_kg_m2: 0.2,
    static_friction: 0.5,
    kinetic_friction: 0.3,
    stretch_compliance_m_n: 1e-7,
    bending_compliance_rad_n: 1e-5,
    stretch_relaxation: 1.0,
    bending_relaxation: 1.0,
};

/// An elastic solid of 1000 kg/m³.
pub(crate) fn elastic(youngs_modulus_pa: f64) -> Material {
    Material::Elastic { density_kg_m3: 1000.0, youngs_modulus_pa, poissons_ratio: 0.0, viscosity_pa_s: 0.0 }
}

/// A spring of 1 N/m between two bodies.
pub(crate) fn link(name: &str, a: &str, b: &str) -> Link {
    Link {
        name: name.to_owned(),
        a: a.to_owned(),
        b: Some(b.to_owned()),
        anchor_m: [0.0; 3],
        stiffness_n_m: 1.0,
        damping_n_s_m: 0.0,
        rest_m: [0.0; 3],
        first: None,
    }
}

/// What the scene says about a pair.
pub(crate) fn pair(a: &str, b: &str) -> PairSpec {
    PairSpec {
        a: a.to_owned(),
        b: b.to_owned(),
        static_friction: 0.5,
        kinetic_friction: 0.5,
        restitution: 0.0,
        softness_m: 0.002,
        contact: ContactLaw::Physical,
        resolver: None,
        enabled: true,
    }
}

pub(crate) fn floor() -> StaticCollider {
    StaticCollider {
        name: "floor".to_owned(),
        source: Source::Plane { size_m: None },
        pose: body("b", "s", RIGID).pose,
        wall: Wall::NoSlip,
        motion: None,
        color: None,
    }
}

/// A plugin that takes every body and plays these parts.
pub(crate) fn plugin(name: &str, boundary: BoundaryForm, roles: &[InterfaceRole]) -> Descriptor {
    let words = |all: &[&str]| all.iter().map(|&w| w.to_owned()).collect::<Vec<String>>();
    Descriptor {
        name: name.to_owned(),
        version: "1".to_owned(),
        summary: "made by hand".to_owned(),
        protocol: [1, 1],
        body_kinds: words(&["box", "points"]),
        materials: words(&["point-mass", "rigid", "elastic", "sph-liquid", "cloth", "smoke", "mpm-liquid", "granular"]),
        roles: roles.to_vec(),
        boundary,
        visual: None,
        features: words(&["links", "joints", "statics", "prescribed", "slab", "gravity"]),
        probes: Vec::new(),
        saves: Saves { bytes: true, deterministic: true },
        params_schema: serde_json::json!({}),
    }
}

/// Plugins by name: `smoke`, `sph`, `pbd` and `mpm` compute contact with everything, `rigid` only responds, `spring`
/// and `oscillator` take links and impulses, `all` takes everything.
pub(crate) fn plugins() -> BTreeMap<String, Descriptor> {
    use InterfaceRole::{Link, ResolveProxy, ResolveSamples, Respond};
    let full = [ResolveProxy, ResolveSamples, Respond];
    let single = BoundaryForm::SamplesF32 { normals: true };
    let all = [
        plugin("smoke", single, &full),
        plugin("sph", single, &full),
        plugin("pbd", single, &full),
        plugin("mpm", single, &full),
        plugin("rigid", BoundaryForm::Proxy, &[Respond]),
        plugin("spring", SAMPLES, &[Respond, Link]),
        plugin("oscillator", SAMPLES, &[Respond, Link]),
        plugin("all", SAMPLES, &[ResolveProxy, ResolveSamples, Respond, Link]),
    ];
    all.into_iter().map(|d| (d.name.clone(), d)).collect()
}

/// Lets these solvers run that plugin.
pub(crate) fn run_with(scene: &mut Scene, plugin: &str, solvers: &[&str]) {
    for solver in solvers {
        let spec = cosplat_core::scene::SolverSpec {
            plugin: Some(plugin.to_owned()),
            command: None,
            params: serde_json::Map::new(),
        };
        scene.solvers.insert((*solver).to_owned(), spec);
    }
}

/// The plan on four cores, or every refusal.
pub(crate) fn attempt(scene: &Scene) -> Result<(Plan, Vec<SolverScene>), Vec<Refusal>> {
    build(scene, &plugins(), 4)
}

pub(crate) fn planned(scene: &Scene) -> Plan {
    match attempt(scene) {
        Ok((plan, _)) => plan,
        Err(refusals) => panic!("the plan was refused: {}", sentences(&refusals)),
    }
}

/// Refusals as people read them, one a line.
pub(crate) fn refused(scene: &Scene) -> String {
    match attempt(scene) {
        Ok((plan, _)) => panic!("a plan was made: {:?}", plan.interfaces),
        Err(refusals) => sentences(&refusals),
    }
}

fn sentences(refusals: &[Refusal]) -> String {
    refusals.iter().map(ToString::to_string).collect::<Vec<String>>().join("\n")
}

/// Bodies of different solvers in a row, each joined to the next by a link: `a`, `b`, `c` … in the solvers `a`, `b` …
pub(crate) fn joined(names: &[&str]) -> Scene {
    let mut scene = scene(names.iter().map(|n| body(n, n, RIGID)));
    scene.links = names.windows(2).map(|two| link(&format!("{}-{}", two[0], two[1]), two[0], two[1])).collect();
    run_with(&mut scene, "spring", names);
    scene
}

/// Smoke, liquid, a solid and a rigid body, each in a solver of its own and all able to meet.
pub(crate) fn four_kinds() -> Scene {
    scene([
        body("cloud", "smoke", SMOKE),
        body("mud", "sph", LIQUID),
        body("toy", "mpm", elastic(1e4)),
        body("rock", "rigid", RIGID),
    ])
}
