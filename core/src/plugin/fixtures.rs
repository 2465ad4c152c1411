//! A plugin and its part of a scene, for the tests of this module.

use super::{Descriptor, InterfaceRole, InterfaceView, SolverScene, ViewRole};
use crate::plan::{BoundaryForm, InterfaceId};
use crate::scene::{Body, Material, MotionRule, Pose, Source, Space, VelocityField};
use crate::time::Clock;

/// Takes clouds of point masses, resolves contact with samples and has one parameter.
pub(super) fn descriptor() -> Descriptor {
    Descriptor {
        body_kinds: vec!["cloud".into()],
        materials: vec!["point-mass".into()],
        roles: vec![InterfaceRole::ResolveSamples, InterfaceRole::Respond],
        params_schema: serde_json::json!({ "properties": { "drag": {} }, "additionalProperties": false }),
        ..Descriptor::new("tester", "1", "a plugin of the tests")
    }
}

/// A cloud that gives impulses to a partner and takes some from another.
pub(super) fn scene() -> SolverScene {
    let body = Body {
        name: "cloud".into(),
        solver: "tester".into(),
        material: Material::PointMass,
        source: Source::Cloud { count: 2, size_m: [1.0; 3] },
        pose: Pose { position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] },
        mass_kg: Some(1.0),
        spacing_m: None,
        velocity: VelocityField::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] },
        prescribed: None,
        regions: Vec::new(),
        color: None,
    };
    let view = |id: InterfaceId, role, partner: &str| InterfaceView {
        id,
        role,
        own: "cloud".into(),
        partner: partner.into(),
        partner_form: BoundaryForm::SamplesF64 { normals: false },
        partner_source: None,
        partner_pose: None,
        rule: MotionRule::Hold,
        pair: None,
        links: Vec::new(),
    };
    SolverScene {
        participant: "tester".into(),
        threads: 1,
        clock: Clock::new(1.0, 1),
        space: Space::Full,
        bodies: vec![body],
        statics: Vec::new(),
        links: Vec::new(),
        joints: Vec::new(),
        actions: Vec::new(),
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: vec![view(0, ViewRole::ContactResponder, "mud"), view(1, ViewRole::ContactResolver, "box")],
        params: serde_json::Map::new(),
        assets: std::collections::BTreeMap::new(),
    }
}
