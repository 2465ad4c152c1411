//! What a plugin does not list is refused by name, everything at once.

use cosplat_core::scene::{
    Action, ActionKind, Joint, JointKind, Material, Motion, Probe, ProbeQuantity, Region, Scheme, Source, Space,
};

use crate::cast::{
    CLOTH, LIQUID, RIGID, SAMPLES, attempt, body, elastic, empty, floor, four_kinds, joined, link, pair, planned,
    plugin, plugins, refused, run_with, scene,
};
use cosplat_core::plan::build;

#[test]
fn participants_stand_in_the_order_of_their_names() {
    let plan = planned(&four_kinds());
    let names: Vec<(&str, &str)> = plan.participants.iter().map(|p| (p.name.as_str(), p.bodies[0].as_str())).collect();
    assert_eq!(names, [("mpm", "toy"), ("rigid", "rock"), ("smoke", "cloud"), ("sph", "mud")]);
    assert_eq!(plan.participant("smoke"), Some(2));
    assert_eq!(plan.name_of(3), "sph");
}

#[test]
fn a_solver_may_run_a_plugin_of_another_name() {
    let mut scene = scene([body("x", "left", RIGID), body("y", "left", RIGID)]);
    run_with(&mut scene, "rigid", &["left"]);
    let plan = planned(&scene);
    assert_eq!((plan.participants[0].name.as_str(), plan.participants[0].plugin.as_str()), ("left", "rigid"));
    assert_eq!(plan.participants[0].bodies, ["x", "y"]);
}

#[test]
fn everything_a_plugin_lacks_is_refused_at_once_and_by_name() {
    let mut scene = scene([body("thing", "bare", Material::PointMass), body("other", "bare", RIGID)]);
    scene.bodies[0].source = Source::Sphere { radius_m: 1.0 };
    scene.bodies[1].prescribed = Some(Motion::Twist { linear_m_s: [1.0, 0.0, 0.0], angular_rad_s: [0.0; 3] });
    scene.space = Space::Slab { normal: 2, thickness_m: 0.1 };
    scene.statics = vec![floor()];
    scene.pairs = vec![pair("floor", "thing")];
    scene.links = vec![link("spring", "thing", "other")];
    scene.joints = vec![Joint {
        name: "hinge".to_owned(),
        kind: JointKind::Ball,
        a: "thing".to_owned(),
        b: Some("other".to_owned()),
        anchor_m: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        stiffness: 0.0,
        damping: 0.0,
    }];
    let action = |kind| Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None };
    scene.actions = vec![
        action(ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -9.81] }),
        action(ActionKind::Impulse { impulse_n_s: [1.0, 0.0, 0.0], at_m: None }),
    ];
    scene.probes = vec![
        probe("push", ProbeQuantity::Strain, Some("thing")),
        probe("place", ProbeQuantity::Position, Some("thing")),
        probe("depth", ProbeQuantity::Pressure, None),
    ];
    let bare = cosplat_core::plugin::Descriptor {
        body_kinds: vec!["box".to_owned()],
        materials: vec!["rigid".to_owned()],
        features: Vec::new(),
        ..plugin("bare", SAMPLES, &[])
    };
    let refusals = build(&scene, &[("bare".to_owned(), bare)].into(), 1).expect_err("it lacks nearly everything");
    let found: Vec<String> = refusals.iter().map(|r| format!("{}: {}", r.what, r.why)).collect();
    let lacks = [
        ("body `thing`", "bodies from `sphere`"),
        ("body `thing`", "material `point-mass`"),
        ("pair `thing~floor`", "static colliders"),
        ("body `other`", "prescribed motion"),
        ("space", "two-dimensional slabs"),
        ("joint `hinge`", "joints"),
        ("link `spring`", "links inside the solver"),
        ("action `gravity`", "action `gravity`"),
        ("action `impulse`", "action `impulse`"),
        ("probe `push`", "probe `strain`"),
        ("probe `depth`", "no plugin of this scene measures `pressure`"),
    ];
    assert_eq!(found.len(), lacks.len(), "{found:#?}");
    for (found, (what, why)) in found.iter().zip(lacks) {
        assert!(
            found.starts_with(&format!("{what}: ")) && found.contains(why),
            "`{found}` is not about {what} and {why}"
        );
    }
    assert!(found[..10].iter().all(|f| f.contains("plugin `bare`")), "{found:#?}");
}

fn probe(name: &str, quantity: ProbeQuantity, body: Option<&str>) -> Probe {
    Probe {
        name: name.to_owned(),
        quantity,
        body: body.map(str::to_owned),
        at_m: body.is_none().then_some([0.0; 3]),
        along: None,
    }
}

#[test]
fn a_probe_at_a_point_is_answered_by_any_plugin_that_can() {
    let mut scene = four_kinds();
    scene.probes = vec![probe("depth", ProbeQuantity::Pressure, None)];
    assert!(refused(&scene).contains("probe `depth`"));
    let mut plugins = plugins();
    plugins.get_mut("sph").expect("it is there").probes = vec![ProbeQuantity::Pressure];
    let (_, parts) = build(&scene, &plugins, 1).expect("one plugin measures it");
    assert!(parts.iter().all(|p| p.probes.len() == 1), "whoever can answer does");
}

#[test]
fn a_missing_plugin_is_named_beside_what_others_lack() {
    let mut scene = four_kinds();
    scene.bodies[0].solver = "fog".to_owned();
    scene.bodies[2].source = Source::Sphere { radius_m: 1.0 };
    scene.pairs = vec![pair("cloud", "mud")];
    let text = refused(&scene);
    assert!(text.contains("solver `fog`: there is no plugin `fog`") && text.contains("body `toy`"), "{text}");
    assert_eq!(text.lines().count(), 2, "what the missing plugin might lack is not known:\n{text}");
}

#[test]
fn a_scene_without_bodies_is_refused() {
    assert!(refused(&empty()).contains("no body"));
}

#[test]
fn a_joint_between_two_solvers_is_refused() {
    let mut scene = scene([body("x", "left", RIGID), body("y", "right", RIGID)]);
    run_with(&mut scene, "rigid", &["left", "right"]);
    let joint = |name: &str, b: Option<&str>| Joint {
        name: name.to_owned(),
        kind: JointKind::Fixed,
        a: "x".to_owned(),
        b: b.map(str::to_owned),
        anchor_m: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        stiffness: 0.0,
        damping: 0.0,
    };
    scene.joints = vec![joint("to-the-world", None)];
    let (_, parts) = attempt(&scene).expect("a joint to the world is inside one solver");
    assert_eq!((parts[0].joints.len(), parts[1].joints.len()), (1, 0));
    scene.joints.push(joint("across", Some("y")));
    let text = refused(&scene);
    assert!(text.contains("joint `across`") && text.contains("`left` and `right`"), "{text}");
    assert!(!text.contains("to-the-world"), "{text}");
}

#[test]
fn a_contact_scheme_that_is_for_links_only_is_refused() {
    for scheme in [Scheme::Alternating, Scheme::Centred] {
        let mut scene = four_kinds();
        scene.clock.contact_scheme = scheme;
        assert!(refused(&scene).contains("contact scheme"), "{scheme:?}");
    }
}

#[test]
fn a_static_collider_that_a_plugin_cannot_take_is_left_out_unless_the_scene_asks_for_it() {
    let mut scene = scene([body("x", "left", RIGID), body("y", "rigid", RIGID)]);
    run_with(&mut scene, "blind", &["left"]);
    scene.statics = vec![floor()];
    let mut plugins = plugins();
    let blind = cosplat_core::plugin::Descriptor { features: Vec::new(), ..plugin("blind", SAMPLES, &[]) };
    plugins.insert("blind".to_owned(), blind);
    let (plan, parts) = build(&scene, &plugins, 1).expect("nothing was asked for");
    assert_eq!((parts[0].statics.len(), parts[1].statics.len()), (0, 1));
    let said: Vec<&str> = plan.left_out.iter().map(|l| l.what.as_str()).collect();
    assert!(said.contains(&"static collider `floor` for solver `left`"), "{said:?}");
    scene.pairs = vec![pair("x", "floor")];
    let refusals = build(&scene, &plugins, 1).expect_err("the scene asks for it");
    assert_eq!(refusals[0].what, "pair `x~floor`");
    scene.pairs[0].enabled = false;
    assert!(build(&scene, &plugins, 1).is_ok());
}

#[test]
fn regions_are_refused_by_name_where_a_plugin_has_none() {
    let mut scene = scene([body("y", "rigid", RIGID)]);
    let pose = scene.bodies[0].pose;
    scene.bodies[0].regions = vec![Region { material: RIGID, source: Source::Sphere { radius_m: 0.02 }, pose }];
    let mut plugins = plugins();
    let refusals = build(&scene, &plugins, 1).expect_err("it has no regions");
    assert_eq!((refusals.len(), refusals[0].what.as_str()), (1, "body `y`"));
    assert!(refusals[0].why.contains("regions of another material"), "{refusals:?}");
    if let Some(rigid) = plugins.get_mut("rigid") {
        rigid.features.push("regions".to_owned());
        rigid.materials = vec!["rigid".to_owned()];
    }
    assert!(build(&scene, &plugins, 1).is_ok());
    scene.bodies[0].regions[0].material = LIQUID;
    assert!(build(&scene, &plugins, 1).is_err(), "the material of a region is one of the plugin's");
}

#[test]
fn terrain_is_refused_by_name_where_a_plugin_takes_only_other_statics() {
    let mut scene = scene([body("y", "rigid", RIGID)]);
    scene.statics = vec![floor()];
    scene.statics[0].source =
        Source::HeightField { file: "hill.obj".to_owned(), metres_per_unit: 1.0, up: "+z".to_owned() };
    let mut plugins = plugins();
    let refusals = build(&scene, &plugins, 1).expect_err("its statics are others");
    assert_eq!((refusals.len(), refusals[0].what.as_str()), (1, "static `floor`"));
    if let Some(rigid) = plugins.get_mut("rigid") {
        rigid.features.push("height-fields".to_owned());
    }
    assert!(build(&scene, &plugins, 1).is_ok());
}

#[test]
fn each_solver_is_told_about_its_own_part_only() {
    let mut scene = joined(&["a", "b"]);
    scene.bodies.push(body("c", "a", RIGID));
    scene.bodies.push(body("d", "b", RIGID));
    scene.links.push(link("inside", "a", "c"));
    scene.links.push(cosplat_core::scene::Link { b: None, ..link("wall", "d", "d") });
    scene.pairs = vec![pair("a", "c"), pair("a", "b"), pair("floor", "b")];
    scene.pairs[1].enabled = false;
    scene.statics = vec![floor()];
    let gravity = |bodies: &[&str]| Action {
        kind: ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -9.81] },
        bodies: bodies.iter().map(|&b| b.to_owned()).collect(),
        from_s: 0.0,
        until_s: None,
    };
    scene.actions = vec![gravity(&[]), gravity(&["c"])];
    let (plan, parts) = attempt(&scene).expect("a plan");
    let names = |links: &[cosplat_core::scene::Link]| links.iter().map(|l| l.name.clone()).collect::<Vec<String>>();
    assert_eq!(parts.iter().map(|p| p.participant.as_str()).collect::<Vec<&str>>(), ["a", "b"]);
    assert_eq!((names(&parts[0].links), names(&parts[1].links)), (vec!["inside".to_owned()], vec!["wall".to_owned()]));
    assert_eq!((parts[0].pairs.len(), parts[1].pairs.len()), (1, 1));
    assert_eq!((parts[0].actions.len(), parts[1].actions.len()), (2, 1));
    assert_eq!((parts[0].bodies.len(), parts[1].bodies.len()), (2, 2));
    assert_eq!(names(&parts[0].interfaces[0].links), ["a-b"]);
    assert!(parts.iter().all(|p| p.clock == plan.clock));
}

#[test]
fn a_partner_that_fills_a_shape_shows_it_and_a_cloth_does_not() {
    let scene = scene([
        body("mud", "sph", LIQUID),
        body("toy", "mpm", elastic(1e4)),
        body("rock", "rigid", RIGID),
        body("sheet", "pbd", CLOTH),
    ]);
    let (_, parts) = attempt(&scene).expect("a plan");
    let mud = parts.iter().find(|p| p.participant == "sph").expect("the liquid's solver");
    let mut shown: Vec<_> = mud
        .interfaces
        .iter()
        .map(|v| (v.partner.as_str(), v.partner_source.is_some(), v.partner_pose.is_some()))
        .collect();
    shown.sort_unstable();
    assert_eq!(shown, [("rock", true, true), ("sheet", false, false), ("toy", true, true)]);
}

#[test]
fn a_solver_without_bodies_is_left_out() {
    let mut scene = four_kinds();
    run_with(&mut scene, "rigid", &["idle"]);
    let plan = planned(&scene);
    assert!(plan.left_out.iter().any(|l| l.what == "process `idle`" && l.indicator == Some(0.0)));
}
