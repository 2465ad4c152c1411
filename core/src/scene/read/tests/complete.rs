//! One scene with every key, and the rules of single keys.

use super::*;
use crate::scene::presets::presets;

const EVERYTHING: &str = r#"
name = "everything"
clock = { duration = 2, window = 1e-3, fps = 24, contact_scheme = "parallel", link_scheme = "serial", motion_rule = "hermite" }
space = { slab = { normal = "y", thickness = 0.01 } }
output = { trace = true, ledger_every = 10 }
run = { threads = 2, silence_limit = 3, break = "drop-reaction" }

[solver.foreign]
command = ["python3", "x.py"]
params = { depth = 3, gain = 0.5, words = ["a", "b"], nested = { on = true } }

[[body]]
name = "toy"
material = { preset = "plushie", density = 60 }
splat = { file = "toy.ply", metres_per_unit = 0.5, up = "-y", min_opacity = 0.1, keep_box = [[0, 0, 0], [1, 1, 1]], fill = "none" }
position = [0, 0, 1]
rotation = { axis = [0, 0, 2], degrees = 90 }
velocity = [1, 0, 0]
angular_velocity = [0, 0, 1]
spacing = 0.02
color = [1, 0.5, 0]
binding = { kind = "mean", neighbours = 7 }

[[body.region]]
material = { preset = "plushie", density = 90 }
sphere = 0.05
position = [0, 0, 0.2]

[[body]]
name = "rock"
solver = "foreign"
material = "brown-rock"
mesh = "rock.obj"
mass = 12
velocity_field = { rotation = { angular_velocity = [0, 0, 3], about = [1, 0, 0] } }

[[body]]
name = "sheet"
material = "silk"
plane = [1, 2]
velocity_field = { linear_map = { gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] } }

[[body]]
name = "water"
material = { kind = "mpm-liquid", density = 1000, youngs_modulus = 1e7, poissons_ratio = 0.2 }
box = { size = [1, 1, 1] }

[[body]]
name = "heap"
material = { kind = "granular", density = 1600, youngs_modulus = 1e6, poissons_ratio = 0.2, friction_angle = 32 }
box = { size = [1, 1, 1] }

[[body]]
name = "drift"
material = { kind = "snow", density = 400, youngs_modulus = 1.4e5, poissons_ratio = 0.2, hardening = 5 }
box = { size = [1, 1, 1] }

[[body]]
name = "dust"
material = { kind = "smoke", density = 1.2 }
cloud = { count = 1000, size = [1, 1, 1] }

[[body]]
name = "ball"
material = { kind = "rigid", density = 500 }
sphere = 0.25
prescribed = { oscillation = { amplitude = [0, 0, 0.1], frequency = 2 } }

[[body]]
name = "pole"
material = "rigid"
mass = 3
cylinder = [0.1, 2.0]

[[body]]
name = "foam"
material = { kind = "viscoplastic", density = 60, youngs_modulus = 1e5, poissons_ratio = 0.3, yield_stress = 900, consistency = 20 }
box = { size = [1, 1, 1] }

[[static]]
name = "floor"
plane = "infinite"
wall = { static_friction = 0.6, kinetic_friction = 0.4 }
motion = { velocity = [0.1, 0, 0] }

[[static]]
name = "lid"
plane = { size = [4, 4] }
wall = "no-slip"

[[pair]]
a = "rock"
b = "toy"
contact = "genesis"
resolver = "mpm"

[[pair]]
a = "sheet"
b = "floor"
friction = 0.2
softness = 0.004
enabled = false

[[joint]]
name = "slider"
kind = "prismatic"
a = "ball"
b = "pole"
axis = [3, 0, 4]
stiffness = 10

[[action]]
kind = "gravity"
acceleration = [0, 0, -9.81]

[[action]]
kind = "wind"
velocity = [3, 0, 0]
bodies = ["sheet"]
from = 0.5
until = 1.5

[[action]]
kind = "acceleration-field"
field = { cylinder = { strength = 3, direction = [0, 0, -2], center = [0, 0, 0], radius = 0.5 } }

[[action]]
kind = "inflow"
bodies = ["pole"]
center = [0, 0, 1]
velocity = [0, 0, -2]
radius = 0.125

[[action]]
kind = "drain"
bodies = ["pole"]
center = [0, 0, -1]
size = [1, 1, 0.25]

[[action]]
kind = "point-force"
bodies = ["pole"]
force = [0, 1, 0]

[[action]]
kind = "impulse"
bodies = ["rock"]
impulse = [1, 0, 0]
at = [0, 0, 1]
from = 1

[[probe]]
name = "height"
quantity = "position"
body = "toy"

[[probe]]
name = "p1"
quantity = "pressure"
at = [0, 0, 0.1]
"#;

#[test]
fn every_key_is_read() {
    let (scene, warnings) = parse(EVERYTHING).unwrap_or_else(|d| panic!("{}", render("a", EVERYTHING, &d)));
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(scene.space, Space::Slab { normal: 1, thickness_m: 0.01 });
    assert_eq!(scene.run.break_with, Some(Break::DropReaction));
    assert_eq!(scene.solvers["foreign"].params["nested"]["on"], true);
    assert_eq!(
        scene.bodies.iter().map(|b| b.solver.as_str()).collect::<Vec<_>>(),
        ["mpm", "foreign", "pbd", "mpm", "mpm", "mpm", "smoke", "rigid", "rigid", "mpm"]
    );
    assert_eq!(scene.bodies[0].material.density(), Some(60.0));
    assert_eq!(scene.bodies[0].regions.len(), 1);
    assert_eq!(scene.bodies[0].regions[0].material.density(), Some(90.0));
    assert_eq!([[0.0, 0.0, 0.16], [0.0; 3]].map(|x| scene.bodies[0].material_at(x)), [1, 0]);
    let [x, y, z, w] = scene.bodies[0].pose.orientation;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert!(x == 0.0 && y == 0.0 && (z - half).abs() < 1e-15 && (w - half).abs() < 1e-15);
    // λ of E = 1e7 Pa and ν = 0.2.
    let Material::MpmLiquid { bulk_modulus_pa, viscosity_pa_s, .. } = scene.bodies[3].material else {
        panic!("a liquid")
    };
    assert!((bulk_modulus_pa / (1e7 / 3.6) - 1.0).abs() < 1e-15 && viscosity_pa_s == 0.0);
    let Material::Granular { friction_angle_deg, cohesion_pa, .. } = scene.bodies[4].material else { panic!("sand") };
    assert_eq!((friction_angle_deg, cohesion_pa), (32.0, 0.0), "dry without a cohesion");
    let Material::Snow { critical_compression, critical_stretch, hardening, .. } = scene.bodies[5].material else {
        panic!("snow")
    };
    assert_eq!((critical_compression, critical_stretch, hardening), (2.5e-2, 7.5e-3, 5.0));
    let Material::Viscoplastic { hardening_pa, consistency_pa_sn, flow_index, .. } = scene.bodies[9].material else {
        panic!("foam")
    };
    assert_eq!((hardening_pa, consistency_pa_sn, flow_index), (0.0, 20.0, 1.0));
    let frictions = |pair: &PairSpec| (pair.static_friction, pair.kinetic_friction);
    assert_eq!(frictions(&scene.pairs[0]), (3.0, 3.0), "from the rock's preset");
    assert_eq!((scene.pairs[1].kinetic_friction, scene.pairs[1].softness_m), (0.2, 0.004));
    assert_eq!(frictions(&scene.pair("toy", "floor")), (0.6, 0.4), "from the wall");
    assert_eq!(scene.joints.iter().map(|j| j.axis).collect::<Vec<_>>(), [[0.6, 0.0, 0.8]]);
    assert_eq!(scene.presets, ["plushie", "brown-rock", "silk"], "each once, in their order");
    assert_eq!(scene.actions.len(), 7);
    assert_eq!(scene.probes[1].at_m, Some([0.0, 0.0, 0.1]));
}

/// What a run folder keeps of a scene is the scene.
#[test]
fn a_scene_survives_json() {
    let (scene, _) = parse(EVERYTHING).expect("a good scene");
    let json = serde_json::to_string(&scene).expect("a scene is plain data");
    assert_eq!(serde_json::from_str::<Scene>(&json).expect("the same scene"), scene);
}

#[test]
fn every_preset_is_a_material() {
    for preset in presets() {
        for material in [format!("{:?}", preset.name), format!("{{ preset = {:?} }}", preset.name)] {
            let text = format!(
                "name = \"a\"\n[clock]\nduration = 1\n[[body]]\nname = \"b\"\nmaterial = {material}\nsphere = 1\n"
            );
            let (scene, warnings) = parse(&text).unwrap_or_else(|d| panic!("{}", render("a", &text, &d)));
            assert_eq!(scene.bodies[0].material, preset.material);
            assert_eq!(warnings.len(), usize::from(preset.name == "environment"), "{warnings:?}");
        }
    }
}

#[test]
fn rules_of_single_keys() {
    for (from, to, message) in [
        ("window = 1e-3", "window = 3", "`window` (3 s) is longer than `duration` (2 s)"),
        ("window = 1e-3", "window = 1e-15", "are too many windows"),
        ("duration = 2", "duration = 1e999", "must be a finite number"),
        ("normal = \"y\"", "normal = \"Y\"", "did you mean `y`?"),
        ("preset = \"plushie\", density = 60", "preset = \"plushie\", kind = \"elastic\"", "exclude each other"),
        ("density = 60", "density = -60", "must be greater than 0 kg/m³, but is -60 kg/m³"),
        ("axis = [0, 0, 2]", "axis = [0, 0, 0]", "has no direction"),
        ("velocity = [1, 0, 0]", "velocity = [1, 0]", "must have 3 numbers, but has 2"),
        ("velocity = [1, 0, 0]", "prescribed = {}", "`angular_velocity` and `prescribed` exclude each other"),
        ("velocity = [1, 0, 0]", "orientation = [0, 0, 0, 1]", "exclude each other"),
        ("color = [1, 0.5, 0]", "color = [1, 0.5, 2]", "must be between 0 and 1, but is 2"),
        ("up = \"-y\"", "up = \"y\"", "did you mean `+y`?"),
        ("fill = \"none\"", "fill = \"nothing\"", "`fill` cannot be `nothing`"),
        ("[[0, 0, 0], [1, 1, 1]]", "[[0, 0, 2], [1, 1, 1]]", "`keep_box` is empty"),
        ("plane = [1, 2]", "plane = \"infinite\"", "a body cannot be an infinite plane"),
        ("{ preset = \"plushie\", density = 90 }", "\"wonderplay-liquid\"", "it has no stiffness"),
        ("sphere = 0.05", "sphere = -1", "`sphere` must be greater than 0 m, but is -1"),
        ("sphere = 0.05", "plane = [1, 1]", "a region is a `box`, a `sphere` or a `cylinder`"),
        ("sphere = 0.05", "", "`body[0].region[0]`: one of these keys is missing"),
        ("count = 1000", "count = 0.5", "must be a whole number between 1 and"),
        ("count = 1000", "count = 999999999999999999999999999999999999999999999", "must be a whole number"),
        ("material = \"rigid\"\nmass = 3", "material = \"rigid\"", "`body[8].material`: key `density` is missing"),
        ("material = \"rigid\"", "material = \"point-mass\"", "a point mass is made of points"),
        ("kinetic_friction = 0.4", "kinetic_friction = 0.7", "is greater than `static_friction`"),
        ("b = \"toy\"", "b = \"rock\"", "cannot be a pair with itself"),
        ("a = \"sheet\"", "a = \"lid\"", "two static colliders never touch"),
        ("b = \"pole\"", "b = \"floor\"", "`floor` is a static collider"),
        ("kind = \"prismatic\"", "kind = \"fixed\"", "only a `prismatic` joint has an `axis`"),
        ("until = 1.5", "until = 0.5", "is not after `from`"),
        ("bodies = [\"pole\"]", "", "key `bodies` is missing"),
        ("velocity = [0, 0, -2]", "velocity = [0, 0, 0]", "nothing enters at rest"),
        ("radius = 0.125", "", "`radius`"),
        ("size = [1, 1, 0.25]", "size = [1, 0, 0.25]", "`size[1]` must be greater than 0 m"),
        ("kind = \"wind\"", "kind = \"winds\"", "did you mean `wind`?"),
        ("quantity = \"pressure\"", "quantity = \"force\"", "is measured with `body`, not `at`"),
        ("density = 60", "densiti = 60, preset = \"can\"", "duplicate key"),
        ("kind = \"smoke\", density = 1.2", "", "one of these keys is missing: `kind`, `preset`"),
        (
            "{ kind = \"smoke\", density = 1.2 }",
            "\"elastic\"",
            "keys `density`, `youngs_modulus`, `poissons_ratio` are missing",
        ),
        ("command = [\"python3\", \"x.py\"]", "command = []", "`command` is empty"),
        ("gain = 0.5", "gain = nan", "must be a finite number"),
        ("solver = \"foreign\"", "solver = \"viewer\"", "cosplat uses it itself"),
        ("[solver.foreign]", "[solver.recorder]", "cosplat uses it itself"),
        ("[[static]]\nname = \"floor\"", "[static]\nname = \"floor\"", "`[[static]]`"),
        ("name = \"dust\"", "name = \"floor\"", "the name `floor` is taken by"),
        ("name = \"dust\"", "name = \"0123456789012345678901234567890123456789012345678\"", "has 49 characters"),
        ("ledger_every = 10", "ledger_every = 0", "must be a whole number between 1 and"),
        ("trace = true", "trace = 1", "must be true or false, but is 1"),
        ("kind = \"mean\", neighbours", "kind = \"meen\", neighbours", "did you mean `mean`?"),
        (
            "kind = \"mean\", neighbours = 7",
            "kind = \"mean\", neighbours = 0",
            "must be a whole number between 1 and 64",
        ),
        ("kind = \"mean\", neighbours", "kind = \"particle\", neighbours", "has no other neighbours"),
        ("kind = \"mean\", neighbours", "kind = \"vertices\", neighbours", "a capture has no vertices"),
        ("kind = \"mean\", neighbours = 7", "kind = \"mean\", splat = \"s.ply\"", "only triangles hold the Gaussians"),
        ("mesh = \"rock.obj\"", "mesh = \"rock.obj\"\nbinding = \"affine\"", "a mesh has no Gaussians of its own"),
        ("plane = [1, 2]", "plane = [1, 2]\nbinding = \"vertices\"", "only a `splat` or a `mesh`"),
    ] {
        let text = EVERYTHING.replacen(from, to, 1);
        assert_ne!(text, EVERYTHING, "`{from}` is not in the scene");
        let shown = mistakes(&text);
        assert!(shown.contains(message), "{from} -> {to}:\n{shown}");
    }
}

#[test]
fn a_binding_has_its_usual_number_of_neighbours() {
    let (scene, _) = parse(EVERYTHING).unwrap();
    assert_eq!(scene.output.bindings["toy"].spec, BindingSpec { kind: BindingKind::Mean, neighbours: 7 });
    assert_eq!(scene.output.bindings.len(), 1);
    for (word, kind, neighbours) in
        [("affine", BindingKind::Affine, 12), ("mean", BindingKind::Mean, 10), ("particle", BindingKind::Particle, 1)]
    {
        let text = EVERYTHING.replace("{ kind = \"mean\", neighbours = 7 }", &format!("\"{word}\""));
        let (scene, _) = parse(&text).unwrap();
        assert_eq!(scene.output.bindings["toy"].spec, BindingSpec { kind, neighbours });
    }
}

#[test]
fn without_an_up_axis_the_format_decides() {
    let long = EVERYTHING.lines().find(|line| line.starts_with("splat = ")).unwrap();
    for (source, expected) in [
        ("splat = \"toy.ply\"", "format"),
        ("splat = { file = \"toy.ply\" }", "format"),
        ("splat = { file = \"toy.ply\", up = \"format\" }", "format"),
        ("splat = { file = \"toy.ply\", up = \"+z\" }", "+z"),
        ("mesh = \"toy.glb\"", "format"),
        ("mesh = { file = \"toy.glb\" }", "format"),
        ("mesh = { file = \"toy.glb\", up = \"-x\" }", "-x"),
    ] {
        // A mesh takes no binding of a capture.
        let text = EVERYTHING.replace("binding = { kind = \"mean\", neighbours = 7 }", "").replace(long, source);
        let (scene, _) = parse(&text).unwrap();
        let found = scene.bodies.iter().find_map(|body| match &body.source {
            Source::Splat { file, up, .. } | Source::Mesh { file, up, .. } if file.starts_with("toy") => {
                Some(up.as_str())
            }
            _ => None,
        });
        assert_eq!(found, Some(expected), "{source}");
    }
}

#[test]
fn empty_text_says_what_is_missing() {
    let shown = mistakes("");
    for message in ["key `name` is missing", "section `[clock]` is missing", "at least one `[[body]]`"] {
        assert!(shown.contains(message), "{shown}");
    }
}
