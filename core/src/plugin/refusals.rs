//! Refusing by name what a plugin cannot do: all of it at once, so that nobody mends a scene in ten attempts.

use std::fmt::Display;

use super::descriptor::{Descriptor, InterfaceRole};
use super::scene::{InterfaceView, OwnView, SolverScene, ViewRole};
use super::{BodyKind, PluginError, Points};
use crate::boundary::Vec3;
use crate::plan::{BoundaryForm, REGIONS, is_body_probe, source_kind};
use crate::scene::{Body, Material, Space};

/// Collects what a scene asks of a plugin that it cannot do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusals {
    plugin: String,
    what: Vec<String>,
}

impl Refusals {
    /// None yet, for the plugin of that name.
    pub fn new(plugin: &str) -> Self {
        Self { plugin: plugin.to_owned(), what: Vec::new() }
    }

    /// Everything in a scene that a plugin does not list in its descriptor.
    ///
    /// Not looked at: static colliders, which [`SolverScene::left_out_statics`] names, and contact between own bodies,
    /// for which there is no entry; a plugin that has none also calls [`Refusals::contacts`].
    pub fn undeclared(plugin: &Descriptor, scene: &SolverScene) -> Self {
        let mut all = Self::new(&plugin.name);
        let lacks = |feature: &str| !plugin.has_feature(feature);
        all.each((scene.space != Space::Full && lacks("slab")).then_some("slab"));
        scene.bodies.iter().for_each(|b| all.body(plugin, b));
        all.each(scene.joints.iter().filter(|_| lacks("joints")).map(|j| format!("joints (`{}`)", j.name)));
        all.each(scene.links.iter().filter(|_| lacks("links")).map(|l| format!("links (`{}`)", l.name)));
        let kinds = scene.actions.iter().map(|a| a.kind.name()).filter(|kind| lacks(kind));
        all.each(kinds.map(|kind| format!("actions of kind {kind}")));
        // A probe without a body is shown to every solver; those that cannot answer have nothing to say to it.
        let asked = scene.probes.iter().filter(|p| p.body.is_some() && !is_body_probe(p.quantity));
        let unknown = asked.filter(|p| !plugin.probes.contains(&p.quantity));
        all.each(unknown.map(|p| format!("probes of that kind (`{}`)", p.name)));
        scene.interfaces.iter().for_each(|v| all.role(plugin, v));
        let open = plugin.params_schema.get("additionalProperties") != Some(&false.into());
        let known = |key: &String| open || plugin.params_schema["properties"].get(key).is_some();
        all.each(scene.params.keys().filter(|key| !known(key)).map(|key| format!("parameters (`{key}`)")));
        all
    }

    /// Refuses contact between own bodies, pair by pair, for plugins that have none.
    pub fn contacts(&mut self, scene: &SolverScene) {
        let pairs = scene.pairs.iter().filter(|p| p.enabled);
        self.each(pairs.map(|p| format!("contact pairs (`{}` and `{}`)", p.a, p.b)));
    }

    /// The points of a body, or a refusal of a body that has none or no mass.
    pub fn points(&mut self, body: &Body) -> Option<Points> {
        let points = Points::new(body);
        self.each(points.is_none().then(|| format!("bodies without points or positive mass (body `{}`)", body.name)));
        points
    }

    /// The interfaces of a scene with the places of their own bodies, or refusals of those whose body is missing.
    pub fn views(&mut self, scene: &SolverScene) -> Vec<OwnView> {
        let mut views = Vec::new();
        for view in &scene.interfaces {
            match scene.bodies.iter().position(|b| b.name == view.own) {
                Some(own) => views.push(OwnView { id: view.id, own, partner: view.partner.clone() }),
                None => self.push(format!("interfaces of bodies it does not have (body `{}`)", view.own)),
            }
        }
        views
    }

    /// Velocity of the centre of mass \[m/s\] and angular velocity \[rad/s\] of a body that moves as one, or a refusal of a
    /// velocity that deforms it.
    pub fn twist(&mut self, body: &Body, centre: Vec3) -> [Vec3; 2] {
        let twist = body.velocity.twist(centre);
        self.each(twist.is_none().then(|| format!("velocity fields that deform (body `{}`)", body.name)));
        twist.unwrap_or_default()
    }

    /// Adds one thing, with its name in it.
    pub fn push(&mut self, what: impl Display) {
        self.what.push(what.to_string());
    }

    /// Ends with one error that lists all of them, or with nothing where there are none.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`].
    pub fn finish(self) -> Result<(), PluginError> {
        if self.what.is_empty() { Ok(()) } else { Err(Self::one(&self.plugin, self.what.join("; "))) }
    }

    /// The error for one thing that a plugin cannot do, for refusals after the set-up.
    pub fn one(plugin: &str, what: impl Display) -> PluginError {
        PluginError::Unsupported(format!("the {plugin} solver does not support: {what}"))
    }

    fn each(&mut self, all: impl IntoIterator<Item: Display>) {
        self.what.extend(all.into_iter().map(|what| what.to_string()));
    }

    fn body(&mut self, plugin: &Descriptor, body: &Body) {
        let (name, kind) = (&body.name, source_kind(&body.source));
        let lists = |known: &[BodyKind], wanted: &str| known.iter().any(|k| k == wanted);
        if !lists(&plugin.body_kinds, kind) {
            self.push(format!("bodies from {kind}, only from {} (body `{name}`)", plugin.body_kinds.join(", ")));
        }
        for material in body.materials().map(Material::name).filter(|m| !lists(&plugin.materials, m)) {
            self.push(format!("material {material} (body `{name}`)"));
        }
        if !body.regions.is_empty() && !plugin.has_feature(REGIONS) {
            self.push(format!("regions of another material (body `{name}`)"));
        }
        if body.prescribed.is_some() && !plugin.has_feature("prescribed") {
            self.push(format!("prescribed motion (body `{name}`)"));
        }
    }

    fn role(&mut self, plugin: &Descriptor, view: &InterfaceView) {
        let (wanted, what) = match (view.role, view.partner_form) {
            (ViewRole::ContactResolver, BoundaryForm::Proxy) => (InterfaceRole::ResolveProxy, "resolving contacts"),
            (ViewRole::ContactResolver, _) => (InterfaceRole::ResolveSamples, "resolving contacts"),
            (ViewRole::ContactResponder, _) => (InterfaceRole::Respond, "impulses from contacts"),
            (ViewRole::LinkSide | ViewRole::LinkResolver | ViewRole::LinkResponder, _) => {
                (InterfaceRole::Link, "links to other solvers")
            }
        };
        if !plugin.roles.contains(&wanted) {
            self.push(format!("{what} (`{}` and `{}`)", view.own, view.partner));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{descriptor, scene};
    use super::*;
    use crate::scene::{Action, ActionKind, ContactLaw, Material, Motion, PairSpec, Probe, ProbeQuantity, Source};

    fn message(refusals: Refusals) -> String {
        refusals.finish().map_or_else(|why| why.to_string(), |()| String::new())
    }

    #[test]
    fn what_is_declared_is_not_refused() {
        let mut scene = scene();
        scene.params.insert("drag".into(), 1.0.into());
        scene.probes.push(Probe {
            name: "where".into(),
            quantity: ProbeQuantity::Position,
            body: Some("cloud".into()),
            at_m: None,
            along: None,
        });
        assert_eq!(Refusals::undeclared(&descriptor(), &scene).finish(), Ok(()));
    }

    #[test]
    fn everything_that_is_not_declared_is_named_in_one_message() {
        let mut scene = scene();
        scene.space = Space::Slab { normal: 1, thickness_m: 0.1 };
        let body = &mut scene.bodies[0];
        body.source = Source::Sphere { radius_m: 1.0 };
        body.material = Material::Smoke { density_kg_m3: 1.0, viscosity: 0.0 };
        body.prescribed = Some(Motion::Oscillation { amplitude_m: [1.0; 3], frequency_hz: 1.0 });
        let kind = ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -1.0] };
        scene.actions.push(Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None });
        let quantity = ProbeQuantity::Strain;
        scene.probes.push(Probe {
            name: "stretch".into(),
            quantity,
            body: Some("cloud".into()),
            at_m: None,
            along: None,
        });
        scene.params.insert("iterations".into(), 4.into());
        scene.interfaces[0].role = ViewRole::LinkSide;
        scene.interfaces[1].partner_form = BoundaryForm::Proxy;
        let found = message(Refusals::undeclared(&descriptor(), &scene));
        for name in [
            "the tester solver does not support: slab; ",
            "bodies from sphere, only from cloud (body `cloud`)",
            "material smoke (body `cloud`)",
            "prescribed motion (body `cloud`)",
            "actions of kind gravity",
            "probes of that kind (`stretch`)",
            "parameters (`iterations`)",
            "links to other solvers (`cloud` and `mud`)",
            "resolving contacts (`cloud` and `box`)",
        ] {
            assert!(found.contains(name), "`{name}` is not in: {found}");
        }
    }

    #[test]
    fn a_body_without_points_is_refused() {
        let mut body = scene().bodies.remove(0);
        let mut refusals = Refusals::new("tester");
        assert_eq!(refusals.points(&body), Points::new(&body));
        assert_eq!(refusals.clone().finish(), Ok(()));
        body.mass_kg = None;
        assert_eq!(refusals.points(&body), None);
        assert!(message(refusals).contains("bodies without points or positive mass (body `cloud`)"));
    }

    #[test]
    fn contacts_are_refused_where_the_plugin_says_so() {
        let mut scene = scene();
        let pair = PairSpec {
            a: "cloud".into(),
            b: "floor".into(),
            static_friction: 0.5,
            kinetic_friction: 0.5,
            restitution: 0.0,
            softness_m: 0.002,
            contact: ContactLaw::Physical,
            resolver: None,
            enabled: true,
        };
        scene.pairs = vec![PairSpec { enabled: false, ..pair.clone() }, pair];
        let mut refusals = Refusals::undeclared(&descriptor(), &scene);
        refusals.contacts(&scene);
        refusals.push("more");
        assert_eq!(message(refusals), "the tester solver does not support: contact pairs (`cloud` and `floor`); more");
    }
}
