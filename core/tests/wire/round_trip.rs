//! What was sent is what arrives: bit for bit in double precision, half a unit in the last place in single.

use cosplat_core::boundary::{BoundaryState, Impulses, ProxyRecord, SampleStatics, Samples, Vec3, Wrench};
use cosplat_core::plan::{BoundaryForm, Content};
use cosplat_core::visual::VisualState;
use proptest::collection::vec;
use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
use proptest::prelude::*;

use crate::sample::{Value, decode, payload};

/// Any finite number, zeros of both signs and subnormal ones too.
pub(crate) fn finite() -> impl Strategy<Value = f64> + Clone {
    POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO
}

pub(crate) fn vectors(count: usize) -> impl Strategy<Value = Vec<Vec3>> {
    vec([finite(), finite(), finite()], count)
}

pub(crate) fn samples(normals: bool) -> impl Strategy<Value = Samples> {
    (0_usize..24).prop_flat_map(move |n| {
        let normal = vectors(if normals { n } else { 0 });
        (vectors(n), vectors(n), normal).prop_map(|(position, velocity, normal)| Samples { position, velocity, normal })
    })
}

fn proxy() -> impl Strategy<Value = ProxyRecord> {
    let scripted = prop_oneof![finite(), Just(f64::INFINITY)];
    (vec(finite(), 20), vec(scripted, 7)).prop_map(|(n, m)| ProxyRecord {
        position: [n[0], n[1], n[2]],
        orientation: [n[3], n[4], n[5], n[6]],
        linear_velocity: [n[7], n[8], n[9]],
        angular_velocity: [n[10], n[11], n[12]],
        mass: m[0],
        inertia: [m[1], m[2], m[3], m[4], m[5], m[6]],
        share: n[13],
        background_linear: [n[14], n[15], n[16]],
        background_angular: [n[17], n[18], n[19]],
    })
}

fn statics() -> impl Strategy<Value = SampleStatics> {
    (0_usize..24).prop_flat_map(|n| {
        (vec(any::<u64>(), n), vec(finite(), n), vec(finite(), n), vec(finite(), n))
            .prop_map(|(id, area_m2, volume_m3, mass_kg)| SampleStatics { id, area_m2, volume_m3, mass_kg })
    })
}

fn impulses() -> impl Strategy<Value = Impulses> {
    let each = (0_usize..24).prop_flat_map(vectors).prop_map(Impulses::Samples);
    let rigid = vectors(2).prop_map(|v| Impulses::Rigid(Wrench { linear: v[0], angular: v[1] }));
    prop_oneof![each, rigid]
}

/// Bits of every number of a value: `==` would take -0 for 0.
pub(crate) fn bits(value: &Value) -> Vec<u64> {
    let of = |lists: &[&[f64]]| lists.iter().flat_map(|l| l.iter().map(|v| v.to_bits())).collect::<Vec<u64>>();
    match value {
        Value::Statics(s) => [s.id.clone(), of(&[&s.area_m2, &s.volume_m3, &s.mass_kg])].concat(),
        Value::Boundary(BoundaryState::Samples(s)) => {
            of(&[s.position.as_flattened(), s.velocity.as_flattened(), s.normal.as_flattened()])
        }
        Value::Boundary(BoundaryState::Proxy(p)) => of(&[
            &p.position,
            &p.orientation,
            &p.linear_velocity,
            &p.angular_velocity,
            &[p.mass, p.share],
            &p.inertia,
            &p.background_linear,
            &p.background_angular,
        ]),
        Value::Impulses(Impulses::Samples(each)) => of(&[each.as_flattened()]),
        Value::Impulses(Impulses::Rigid(w)) => of(&[&w.linear, &w.angular]),
        Value::Visual(VisualState::Pose { position, orientation }) => of(&[position, orientation]),
        Value::Visual(VisualState::Particles { position, gradient }) => {
            let gradient = gradient.as_flattened().iter().map(|g| u64::from(g.to_bits()));
            of(&[position.as_flattened()]).into_iter().chain(gradient).collect()
        }
    }
}

fn survives_bitwise(content: &Content, value: &Value) -> Result<(), TestCaseError> {
    let (count, bytes) = payload(content, value);
    prop_assert_eq!(bytes.len(), cosplat_core::wire::payload_bytes(content, count));
    let found = decode(content, count, &bytes).map_err(|e| TestCaseError::fail(e.to_string()))?;
    prop_assert_eq!(&found, value);
    prop_assert_eq!(bits(&found), bits(value));
    Ok(())
}

/// Half the distance between single-precision numbers around `x`; that of the smallest below the normal range.
fn half_ulp(x: f64) -> f64 {
    let exponent = if x == 0.0 { -126.0 } else { x.abs().log2().floor().max(-126.0) };
    f64::exp2(exponent - 24.0)
}

/// Whether two sample sets agree as well as single precision relative to the first sample allows.
pub(crate) fn near(found: &BoundaryState, wanted: &BoundaryState) -> Result<(), String> {
    let (BoundaryState::Samples(found), BoundaryState::Samples(wanted)) = (found, wanted) else {
        return Err("not samples".to_owned());
    };
    let origin = wanted.position.first().copied().unwrap_or_default();
    let columns = [
        (&found.position, &wanted.position, origin),
        (&found.velocity, &wanted.velocity, [0.0; 3]),
        (&found.normal, &wanted.normal, [0.0; 3]),
    ];
    for (found, wanted, origin) in columns {
        if found.len() != wanted.len() {
            return Err(format!("{} instead of {} vectors", found.len(), wanted.len()));
        }
        for (f, w) in found.iter().zip(wanted) {
            for axis in 0..3 {
                let offset = w[axis] - origin[axis];
                // Half a single-precision unit of the offset, and the roundings of subtraction and sum in double
                // precision: each at most half a unit, that is 2⁻⁵³ of the largest number in it.
                let largest = w[axis].abs().max(origin[axis].abs()).max(offset.abs());
                let allowed = half_ulp(offset) + 4.0 * f64::EPSILON / 2.0 * largest;
                if (f[axis] - w[axis]).abs() > allowed {
                    return Err(format!("{} instead of {}, {allowed} is allowed", f[axis], w[axis]));
                }
            }
        }
    }
    Ok(())
}

fn boundary_of(form: BoundaryForm) -> Content {
    Content::Boundary { body: "body".to_owned(), form }
}

/// Numbers within the range of single precision, of all magnitudes.
fn moderate() -> impl Strategy<Value = f64> + Clone {
    let magnitude = (-1.0..1.0_f64, -45_i32..38).prop_map(|(m, e)| m * 10_f64.powi(e));
    prop_oneof![-1e3..1e3_f64, magnitude, Just(0.0)]
}

fn moderate_samples(normals: bool) -> impl Strategy<Value = Samples> {
    let vectors = |n: usize| vec([moderate(), moderate(), moderate()], n);
    (0_usize..24).prop_flat_map(move |n| {
        let normal = vectors(if normals { n } else { 0 });
        (vectors(n), vectors(n), normal).prop_map(|(position, velocity, normal)| Samples { position, velocity, normal })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn double_precision_samples_survive_bitwise(plain in samples(false), with_normals in samples(true)) {
        for (normals, samples) in [(false, plain), (true, with_normals)] {
            let content = boundary_of(BoundaryForm::SamplesF64 { normals });
            survives_bitwise(&content, &Value::Boundary(BoundaryState::Samples(samples)))?;
        }
    }

    #[test]
    fn proxies_survive_bitwise(record in proxy()) {
        survives_bitwise(&boundary_of(BoundaryForm::Proxy), &Value::Boundary(BoundaryState::Proxy(record)))?;
    }

    #[test]
    fn statics_survive_bitwise(statics in statics()) {
        survives_bitwise(&Content::Statics { body: "body".to_owned() }, &Value::Statics(statics))?;
    }

    #[test]
    fn impulses_survive_bitwise(impulses in impulses()) {
        let form = match impulses {
            Impulses::Rigid(_) => BoundaryForm::Proxy,
            Impulses::Samples(_) => BoundaryForm::SamplesF32 { normals: true },
        };
        survives_bitwise(&Content::Impulses { interface: 0, form }, &Value::Impulses(impulses))?;
    }

    #[test]
    fn single_precision_samples_are_off_by_half_a_unit_in_the_last_place(
        plain in moderate_samples(false),
        with_normals in moderate_samples(true),
    ) {
        for (normals, samples) in [(false, plain), (true, with_normals)] {
            let content = boundary_of(BoundaryForm::SamplesF32 { normals });
            let wanted = BoundaryState::Samples(samples);
            let (count, bytes) = payload(&content, &Value::Boundary(wanted.clone()));
            match decode(&content, count, &bytes) {
                Ok(Value::Boundary(found)) => prop_assert_eq!(near(&found, &wanted), Ok(())),
                other => prop_assert!(false, "{:?}", other),
            }
        }
    }

    #[test]
    fn single_precision_does_not_lose_detail_far_from_the_world_origin(
        far in [-1e9..1e9_f64, -1e9..1e9_f64, -1e9..1e9_f64],
        offsets in vec([-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64], 1..20),
    ) {
        let position: Vec<Vec3> = offsets.iter().map(|o| [far[0] + o[0], far[1] + o[1], far[2] + o[2]]).collect();
        let velocity = vec![[0.0; 3]; position.len()];
        let wanted = BoundaryState::Samples(Samples { position: position.clone(), velocity, normal: Vec::new() });
        let content = boundary_of(BoundaryForm::SamplesF32 { normals: false });
        let (count, bytes) = payload(&content, &Value::Boundary(wanted));
        let Ok(Value::Boundary(BoundaryState::Samples(found))) = decode(&content, count, &bytes) else {
            return Err(TestCaseError::fail("not samples"));
        };
        for (f, w) in found.position.as_flattened().iter().zip(position.as_flattened()) {
            // Offsets from the first sample are below 2 m, whose half unit is 2⁻²⁴ m; double precision at 10⁹ m
            // rounds by less than 2⁻²⁴ m = 6e-8 m once more, three times.
            prop_assert!((f - w).abs() <= 4.0 * f64::exp2(-24.0));
        }
    }
}
