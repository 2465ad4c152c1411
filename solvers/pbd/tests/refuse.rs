//! What is missing or wrong is refused by name, all of it at once.

mod common;

use common::{cloth, floor, pair};
use cosplat_conformance::parts;
use cosplat_core::plugin::{Plugin, PluginError};
use cosplat_core::scene::{Source, Wall};
use cosplat_pbd::Pbd;

#[test]
fn everything_that_is_wrong_is_named_in_one_message() {
    let endless = parts::body("endless", cloth(0.0, 0.0), Source::Plane { size_m: None }, [0.0; 3]);
    let sheet = parts::body("sheet", cloth(0.0, 0.0), Source::Plane { size_m: Some([0.1; 2]) }, [0.0; 3]);
    let file = Source::Mesh { file: "flag.obj".into(), metres_per_unit: 1.0, up: "+z".into() };
    let mut scene =
        parts::solver_scene("pbd", vec![endless, sheet, parts::body("flag", cloth(0.0, 0.0), file, [0.0; 3])], 1, 0.01);
    scene.statics = vec![floor(Wall::Slip)];
    scene.pairs = vec![cosplat_core::scene::PairSpec { restitution: 0.5, ..pair("sheet", "floor", 0.1) }];
    scene.params.insert("pins".into(), serde_json::json!({ "sheet": [[1.0, 2.0, 3.0]], "curtain": [] }));
    let Err(PluginError::Unsupported(why)) = Pbd::default().setup(&scene) else { panic!("accepted") };
    for name in ["`endless`", "body `flag`", "a pin of `sheet`", "`curtain`", "restitution (`sheet` and `floor`)"] {
        assert!(why.contains(name), "{name} is not in: {why}");
    }
    for (key, value) in [
        ("mode", serde_json::json!("fast")),
        ("max_substep_s", 0.0.into()),
        ("iterations", 0.into()),
        ("thickness_m", (-1.0).into()),
        ("pins", serde_json::json!([[0.0, 0.0]])),
        ("elasticity", 1.into()),
    ] {
        scene.params = [(key.to_owned(), value)].into_iter().collect();
        let why = Pbd::default().setup(&scene).expect_err("a wrong parameter").to_string();
        assert!(why.contains(key), "{key}: {why}");
    }
}
