//! Which bodies meet, who resolves, and which streams that takes.

use cosplat_core::plan::schedule::{Role, steps};
use cosplat_core::plan::{BoundaryForm, Content, InterfaceKind, Plan, build};
use cosplat_core::plugin::{InterfaceRole, ViewRole};
use cosplat_core::scene::{Material, Scheme};

use crate::cast::{
    LIQUID, RIGID, SAMPLES, attempt, body, elastic, four_kinds, joined, link, pair, planned, plugin, plugins, refused,
    run_with, scene,
};

/// Names of all interfaces, resolver or first side before the other.
fn names(plan: &Plan) -> Vec<&str> {
    plan.interfaces.iter().map(|i| i.name.as_str()).collect()
}

/// Every stream with its receivers, in words.
fn streams(plan: &Plan) -> Vec<String> {
    let names = |to: &[u16]| to.iter().map(|&t| plan.name_of(t)).collect::<Vec<&str>>().join(" ");
    plan.streams.iter().map(|s| format!("{} from {} to {}", s.key, plan.name_of(s.from), names(&s.to))).collect()
}

#[test]
fn the_softer_kind_resolves() {
    let plan = planned(&four_kinds());
    let wanted = ["cloud~mud", "cloud~toy", "cloud~rock", "mud~toy", "mud~rock", "toy~rock"];
    assert_eq!(names(&plan), wanted);
    let turned = {
        let mut scene = four_kinds();
        scene.bodies.reverse();
        planned(&scene)
    };
    let mut turned_names = names(&turned);
    turned_names.sort_unstable();
    let mut wanted = wanted.to_vec();
    wanted.sort_unstable();
    assert_eq!(turned_names, wanted, "the order in the scene decided");
}

#[test]
fn samples_take_the_impulses_of_a_sudden_resolver_at_once() {
    let mut plugins = plugins();
    plugins.values_mut().filter(|d| d.name == "smoke").for_each(|d| d.features.push("sudden-impulses".into()));
    let (plan, _) = build(&four_kinds(), &plugins, 4).expect("all of them meet");
    let sudden: Vec<_> = plan.interfaces.iter().filter(|i| i.at_once).map(|i| i.name.as_str()).collect();
    assert_eq!(sudden, ["cloud~mud", "cloud~toy"], "a rigid body moves smoothly under what is spread");
    for interface in &plan.interfaces {
        let needs = steps(&plan, interface.b.participant, 3).into_iter().flat_map(|s| s.needs);
        let mut taken = needs.filter(|n| Some(n.message.stream) == interface.impulses).map(|n| n.role);
        let role = if interface.at_once { Role::ImpulseAtStart } else { Role::ImpulseSpread };
        assert!(taken.next() == Some(role) && taken.next().is_none(), "{}", interface.name);
    }
}

#[test]
fn of_two_solids_the_softer_resolves_whatever_their_names() {
    for (a, b) in [("x", "y"), ("y", "x")] {
        let mut scene = scene([body("soft", a, elastic(1e4)), body("hard", b, elastic(1e6))]);
        run_with(&mut scene, "mpm", &["x", "y"]);
        assert_eq!(names(&planned(&scene)), ["soft~hard"]);
    }
}

#[test]
fn equal_bodies_are_ordered_by_the_names_of_their_solvers() {
    for [first, second] in [["x", "y"], ["y", "x"]] {
        let mut scene = scene([body("p", first, elastic(1e4)), body("q", second, elastic(1e4))]);
        run_with(&mut scene, "mpm", &["x", "y"]);
        assert_eq!(names(&planned(&scene)), [if first == "x" { "p~q" } else { "q~p" }]);
    }
}

#[test]
fn who_can_resolves_where_the_softer_cannot() {
    let mut scene = scene([body("mud", "rigid", LIQUID), body("toy", "mpm", elastic(1e4))]);
    assert_eq!(names(&planned(&scene)), ["toy~mud"]);
    // Two that only respond do not meet.
    run_with(&mut scene, "rigid", &["mpm"]);
    let plan = planned(&scene);
    assert!(plan.interfaces.is_empty() && plan.streams.is_empty());
    assert_eq!(plan.left_out[0].what, "contact `mud~toy`");
}

#[test]
fn the_scene_may_name_the_resolver() {
    let mut scene = scene([body("mud", "sph", LIQUID), body("toy", "mpm", elastic(1e4))]);
    scene.pairs = vec![pair("mud", "toy")];
    scene.pairs[0].resolver = Some("mpm".to_owned());
    assert_eq!(names(&planned(&scene)), ["toy~mud"]);
    scene.pairs[0] = pair("toy", "mud");
    scene.pairs[0].resolver = Some("sph".to_owned());
    assert_eq!(names(&planned(&scene)), ["mud~toy"]);
}

#[test]
fn a_resolver_that_cannot_or_is_neither_side_is_refused() {
    let mut scene = scene([body("mud", "sph", LIQUID), body("rock", "rigid", RIGID), body("toy", "mpm", elastic(1e4))]);
    scene.pairs = vec![pair("mud", "rock")];
    scene.pairs[0].resolver = Some("rigid".to_owned());
    let text = refused(&scene);
    assert!(text.contains("pair `mud~rock`: solver `rigid` cannot compute contact with `mud`"), "{text}");
    scene.pairs[0].resolver = Some("mpm".to_owned());
    let text = refused(&scene);
    assert!(text.contains("pair `mud~rock`: its resolver `mpm` is neither `sph` nor `rigid`"), "{text}");
}

#[test]
fn a_pair_that_the_scene_switches_off_is_left_out() {
    let mut scene = four_kinds();
    scene.pairs = vec![pair("rock", "mud")];
    scene.pairs[0].enabled = false;
    let plan = planned(&scene);
    assert_eq!(names(&plan), ["cloud~mud", "cloud~toy", "cloud~rock", "mud~toy", "toy~rock"]);
    assert!(plan.left_out.iter().any(|l| l.what == "contact `mud~rock`" && l.why.contains("switches")));
}

#[test]
fn a_pair_that_nobody_can_play_is_refused_where_the_scene_asks_for_it() {
    let mut scene = scene([body("x", "left", RIGID), body("y", "right", RIGID)]);
    run_with(&mut scene, "rigid", &["left", "right"]);
    let left_out = planned(&scene).left_out;
    assert!(left_out[0].why.contains("neither `left` nor `right` computes contact"), "{left_out:?}");
    scene.pairs = vec![pair("y", "x")];
    assert!(refused(&scene).contains("pair `x~y`"));
}

#[test]
fn bodies_of_one_solver_have_no_interface() {
    let mut scene = scene([body("x", "all", RIGID), body("y", "all", RIGID)]);
    scene.links = vec![link("inside", "x", "y")];
    let plan = planned(&scene);
    assert!(plan.interfaces.is_empty() && plan.streams.is_empty());
}

#[test]
fn links_of_the_same_two_bodies_are_one_interface() {
    let mut scene = joined(&["a", "b", "c"]);
    scene.links.push(link("second", "b", "a"));
    scene.links.push(link("third", "a", "b"));
    let plan = planned(&scene);
    assert_eq!(names(&plan), ["a~b", "b~c"]);
    assert_eq!([&plan.interfaces[0].links[..], &plan.interfaces[1].links[..]], [&[0, 2, 3][..], &[1]]);
}

#[test]
fn the_first_side_of_a_link_is_as_the_scene_says() {
    let mut scene = joined(&["a", "b"]);
    assert_eq!(names(&planned(&scene)), ["a~b"]);
    scene.links[0].first = Some("b".to_owned());
    assert_eq!(names(&planned(&scene)), ["b~a"]);
    // A later link of the same bodies may be the one that says so.
    scene.links[0].first = None;
    scene.links.push(cosplat_core::scene::Link { first: Some("b".to_owned()), ..link("second", "a", "b") });
    let plan = planned(&scene);
    assert_eq!((names(&plan), plan.name_of(plan.interfaces[0].a.participant)), (vec!["b~a"], "b"));
    scene.links.push(cosplat_core::scene::Link { first: Some("a".to_owned()), ..link("third", "a", "b") });
    let text = refused(&scene);
    assert!(text.contains("link `third`") && text.contains("link `second`"), "{text}");
}

#[test]
fn a_link_to_a_plugin_without_links_is_refused() {
    let mut scene = joined(&["a", "b"]);
    run_with(&mut scene, "rigid", &["b"]);
    assert!(refused(&scene).contains("link `a-b`: plugin `rigid` of body `b` takes no links to other solvers"));
}

#[test]
fn joined_bodies_that_touch_have_two_interfaces_of_two_names() {
    let mut scene = joined(&["a", "b"]);
    run_with(&mut scene, "all", &["a", "b"]);
    scene.clock.link_scheme = Scheme::Serial;
    let plan = planned(&scene);
    let found: Vec<(&str, InterfaceKind)> = plan.interfaces.iter().map(|i| (i.name.as_str(), i.kind)).collect();
    assert_eq!(found, [("a~b/link", InterfaceKind::Link), ("a~b", InterfaceKind::Contact)]);
}

#[test]
fn a_stream_has_all_its_readers_and_is_sent_once() {
    let plan = planned(&four_kinds());
    assert_eq!(
        streams(&plan),
        [
            "b/sph/mud from sph to smoke",
            "s/sph/mud from sph to smoke",
            "imp/smoke/sph/0 from smoke to sph",
            "b/mpm/toy from mpm to smoke sph",
            "s/mpm/toy from mpm to smoke sph",
            "imp/smoke/mpm/1 from smoke to mpm",
            "b/rigid/rock from rigid to smoke sph mpm",
            "imp/smoke/rigid/2 from smoke to rigid",
            "imp/sph/mpm/3 from sph to mpm",
            "imp/sph/rigid/4 from sph to rigid",
            "imp/mpm/rigid/5 from mpm to rigid",
        ]
    );
    let forms: Vec<BoundaryForm> = plan
        .streams
        .iter()
        .filter_map(|s| match s.content {
            Content::Impulses { form, .. } => Some(form),
            _ => None,
        })
        .collect();
    let single = BoundaryForm::SamplesF32 { normals: true };
    let proxy = BoundaryForm::Proxy;
    assert_eq!(forms, [single, single, proxy, single, proxy, proxy], "impulses have the form of their responder");
}

#[test]
fn links_exchange_boundaries_and_centred_links_impulses() {
    let mut scene = joined(&["a", "b"]);
    assert_eq!(streams(&planned(&scene)), ["b/b/b from b to a", "b/a/a from a to b"]);
    scene.clock.link_scheme = Scheme::Centred;
    let plan = planned(&scene);
    assert_eq!(streams(&plan), ["m/b/b from b to a", "imp/a/b/0 from a to b"]);
    assert!(plan.interfaces[0].carries_impulses() && plan.interfaces[0].from_a.is_none());
}

#[test]
fn each_side_sees_its_part_of_an_interface() {
    let mut scene = joined(&["a", "b"]);
    run_with(&mut scene, "all", &["a", "b"]);
    for (scheme, sides) in [
        (Scheme::Serial, [ViewRole::LinkSide, ViewRole::LinkSide]),
        (Scheme::Centred, [ViewRole::LinkResolver, ViewRole::LinkResponder]),
    ] {
        scene.clock.link_scheme = scheme;
        scene.pairs = vec![pair("b", "a")];
        scene.pairs[0].enabled = scheme == Scheme::Serial;
        let (_, parts) = attempt(&scene).expect("a plan");
        let roles = |i: usize| parts[i].interfaces.iter().map(|v| v.role).collect::<Vec<ViewRole>>();
        let contact = |role| (scheme == Scheme::Serial).then_some(role);
        let wanted = |side, role| [side].into_iter().chain(contact(role)).collect::<Vec<ViewRole>>();
        assert_eq!(roles(0), wanted(sides[0], ViewRole::ContactResolver));
        assert_eq!(roles(1), wanted(sides[1], ViewRole::ContactResponder));
        let view = &parts[1].interfaces[0];
        assert_eq!((view.own.as_str(), view.partner.as_str(), view.partner_form), ("b", "a", SAMPLES));
        assert_eq!((view.links.len(), view.pair.is_some()), (1, false));
    }
}

#[test]
fn more_interfaces_than_numbers_are_refused() {
    // 257 times 256 pairs are more than 16 bits can count.
    let one = (0..257).map(|i| body(&format!("p{i}"), "x", Material::PointMass));
    let other = (0..256).map(|i| body(&format!("q{i}"), "y", Material::PointMass));
    let mut scene = scene(one.chain(other));
    run_with(&mut scene, "all", &["x", "y"]);
    assert!(refused(&scene).contains("65535 are possible"));
}

#[test]
fn a_partner_that_cannot_respond_is_not_met() {
    let mut scene = scene([body("mud", "sph", LIQUID), body("wall", "mute", RIGID)]);
    let mut plugins = plugins();
    plugins.insert("mute".to_owned(), plugin("mute", BoundaryForm::Proxy, &[InterfaceRole::Link]));
    let (plan, _) = cosplat_core::plan::build(&scene, &plugins, 1).expect("a plan");
    assert!(plan.interfaces.is_empty());
    scene.pairs = vec![pair("mud", "wall")];
    assert!(cosplat_core::plan::build(&scene, &plugins, 1).is_err());
}
