//! Small contents of every kind and form, and the frames around them.

use cosplat_core::boundary::{BoundaryState, Impulses, ProxyRecord, SampleStatics, Samples, Vec3, Wrench};
use cosplat_core::participant::Frame;
use cosplat_core::plan::{BoundaryForm, Content};
use cosplat_core::visual::{VisualForm, VisualState};
use cosplat_core::wire::{self, HEADER_BYTES, Origin};

/// Run of all fixtures.
pub(crate) const RUN: [u8; 16] = *b"golden fixtures.";

/// All forms of a boundary, with the words by which fixtures are named.
pub(crate) const FORMS: [(BoundaryForm, &str); 5] = [
    (BoundaryForm::SamplesF32 { normals: false }, "f32"),
    (BoundaryForm::SamplesF32 { normals: true }, "f32-normals"),
    (BoundaryForm::SamplesF64 { normals: false }, "f64"),
    (BoundaryForm::SamplesF64 { normals: true }, "f64-normals"),
    (BoundaryForm::Proxy, "proxy"),
];

/// A payload of any kind.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Statics(SampleStatics),
    Boundary(BoundaryState),
    Impulses(Impulses),
    Visual(VisualState),
}

/// Three vectors of numbers that single precision cannot hold, far from the origin.
fn vectors(from: f64) -> Vec<Vec3> {
    (0..3).map(|i| [from + 0.1 * f64::from(i), -from - 1.0 / 3.0, from * 1e-3 + 1e-9 * f64::from(i)]).collect()
}

/// A boundary of that form.
pub(crate) fn boundary(form: BoundaryForm) -> BoundaryState {
    let (BoundaryForm::SamplesF32 { normals } | BoundaryForm::SamplesF64 { normals }) = form else {
        return BoundaryState::Proxy(ProxyRecord {
            position: [0.1, 0.2, 0.3],
            orientation: [0.0, 0.6, 0.0, 0.8],
            linear_velocity: [-1.0, 1e-300, -0.0],
            angular_velocity: [1e300, 2.0, 3.0],
            mass: f64::INFINITY,
            inertia: [f64::INFINITY, f64::INFINITY, f64::INFINITY, 0.0, -0.25, 0.5],
            share: 0.5,
            background_linear: [0.0, 0.0, -9.81],
            background_angular: [0.01, 0.02, 0.03],
        });
    };
    let normal = if normals { vec![[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]] } else { Vec::new() };
    BoundaryState::Samples(Samples { position: vectors(100.0), velocity: vectors(-3.0), normal })
}

/// Every content, with its name and what its messages hold.
pub(crate) fn contents() -> Vec<(String, Content, Value)> {
    let body = || "body".to_owned();
    let statics = SampleStatics {
        id: vec![7, u64::MAX, 9],
        area_m2: vec![0.5, 0.0, 0.125],
        volume_m3: vec![0.1, 0.2, 0.3],
        mass_kg: vec![1.0, 2.0, 1e-9],
    };
    let mut all = vec![("statics".to_owned(), Content::Statics { body: body() }, Value::Statics(statics))];
    for (form, word) in FORMS {
        let state = Value::Boundary(boundary(form));
        all.push((format!("boundary-{word}"), Content::Boundary { body: body(), form }, state.clone()));
        all.push((format!("mid-boundary-{word}"), Content::MidBoundary { body: body(), form }, state));
        let impulses = match form {
            BoundaryForm::Proxy => {
                Impulses::Rigid(Wrench { linear: [0.1, -0.2, 1e-12], angular: [3.0, f64::MIN_POSITIVE, -0.0] })
            }
            _ => Impulses::Samples(vectors(0.7)),
        };
        all.push((format!("impulses-{word}"), Content::Impulses { interface: 3, form }, Value::Impulses(impulses)));
    }
    for (form, word, state) in visuals() {
        all.push((format!("visual-{word}"), Content::Visual { body: body(), form }, Value::Visual(state)));
    }
    all
}

/// Visual states of all forms. Their positions differ from the first by what single precision holds exactly.
fn visuals() -> [(VisualForm, &'static str, VisualState); 3] {
    let position = vec![[100.1, -0.3, 1e-9], [100.1 + 0.5, -0.3 - 2.0, 1e-9 + 0.25]];
    let gradient = vec![[1.0, 0.1, -0.2, 0.3, 1.1, 0.0, -0.0, 1e-30, 0.9], [1e30; 9]];
    let pose = VisualState::Pose { position: [0.1, 0.2, 0.3], orientation: [0.0, 0.6, 0.0, 0.8] };
    [
        (VisualForm::Pose, "pose", pose),
        (
            VisualForm::Particles { gradients: false },
            "points",
            VisualState::Particles { position: position.clone(), gradient: Vec::new() },
        ),
        (VisualForm::Particles { gradients: true }, "gradients", VisualState::Particles { position, gradient }),
    ]
}

/// Count and chunks of a value.
pub(crate) fn encode(content: &Content, value: &Value) -> (u32, Vec<Vec<u8>>) {
    match (content, value) {
        (Content::Statics { .. }, Value::Statics(statics)) => wire::encode_statics(statics),
        (Content::Boundary { form, .. } | Content::MidBoundary { form, .. }, Value::Boundary(state)) => {
            wire::encode_boundary(*form, state)
        }
        (Content::Impulses { .. }, Value::Impulses(impulses)) => wire::encode_impulses(impulses),
        (Content::Visual { .. }, Value::Visual(state)) => wire::encode_visual(state),
        _ => panic!("{value:?} is not what {content:?} holds"),
    }
}

/// Value of a payload, in two chunks whose border lies inside of an element: that must make no difference.
pub(crate) fn decode(content: &Content, count: usize, payload: &[u8]) -> Result<Value, wire::PayloadError> {
    let (head, tail) = payload.split_at(payload.len() / 3);
    let payload = &[head, tail];
    match content {
        Content::Statics { .. } => wire::decode_statics(count, payload).map(Value::Statics),
        Content::Boundary { form, .. } | Content::MidBoundary { form, .. } => {
            wire::decode_boundary(*form, count, payload).map(Value::Boundary)
        }
        Content::Impulses { form, .. } => wire::decode_impulses(*form, count, payload).map(Value::Impulses),
        Content::Visual { form, .. } => wire::decode_visual(*form, count, payload).map(Value::Visual),
    }
}

/// Count and payload of a value, without room for a header.
pub(crate) fn payload(content: &Content, value: &Value) -> (usize, Vec<u8>) {
    let (count, chunks) = encode(content, value);
    (count as usize, chunks.iter().flat_map(|chunk| &chunk[HEADER_BYTES..]).copied().collect())
}

/// Where the messages of the fixtures come from.
pub(crate) fn origin(content: &Content) -> Origin {
    Origin { run: RUN, epoch: 2, sender: 5, stream: 11, schema: wire::schema_hash(content), index: 1_000_000_007 }
}

/// The one frame of a small message.
pub(crate) fn frame(content: &Content, value: &Value) -> Frame {
    let (count, chunks) = encode(content, value);
    let (frames, _) = wire::frames(&origin(content), count, chunks, &mut 41);
    let [frame] = frames.try_into().expect("a small message is one frame");
    frame
}
