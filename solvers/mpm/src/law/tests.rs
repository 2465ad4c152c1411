//! The laws of solids against closed forms.

use super::*;

const STILL: Full<f64> = [[wide::f64x4::ZERO; 3]; 3];
const NONE: wide::f64x4 = wide::f64x4::ZERO;

/// Uniaxial stress by solving for the lateral stretch: returns the Kirchhoff stress along the axis.
fn uniaxial(law: &Law<f64>, log_strain: f64, steps: usize) -> f64 {
    let mut b = [all::<f64>(0.0); 6];
    for _ in 0..steps {
        let axial = (log_strain / steps as f64).exp() - 1.0;
        let (mut low, mut high) = (-0.9, 0.9);
        let mut next = b;
        for _ in 0..60 {
            let lateral = 0.5 * (low + high);
            let l = [[axial, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, lateral]].map(|r| r.map(all::<f64>));
            next = crate::math::congruence::<f64>(&l, &b);
            next = law.flow(&next, NONE, &Room::endless()).map_or(next, |new| new.b);
            if law.stress(&next, NONE, &STILL)[1].to_array()[0] > 0.0 { high = lateral } else { low = lateral }
        }
        b = next;
    }
    law.stress(&b, NONE, &STILL)[0].to_array()[0]
}

#[test]
fn yields_at_the_yield_stress_or_at_that_of_the_seed() {
    let lame = Lame::from_young_poisson(2e6, 0.22);
    let physical = uniaxial(&Law::elastoplastic(lame, 3e4, YieldNorm::Physical), 0.2, 20);
    let genesis = uniaxial(&Law::elastoplastic(lame, 3e4, YieldNorm::Genesis), 0.2, 20);
    // Algebra in f64: the plateau of perfect plasticity in Kirchhoff stress.
    assert!((physical / 3e4 - 1.0).abs() < 1e-9, "{physical}");
    assert!((genesis / 3e4 - 1.5_f64.sqrt()).abs() < 1e-9, "{genesis}");
}

#[test]
fn small_strains_obey_hooke() {
    let lame = Lame::from_young_poisson(2e6, 0.22);
    for law in [Law::<f64>::elastic(lame, 0.0), Law::elastoplastic(lame, 3e6, YieldNorm::Physical)] {
        let stress = uniaxial(&law, 1e-5, 1);
        // Second order in a strain of 1e-5.
        assert!((stress / (2e6 * 1e-5) - 1.0).abs() < 3e-5, "{stress}");
    }
}

#[test]
fn energy_is_the_work_of_the_stress() {
    // dψ = τ : d, for a rate d that commutes with nothing in particular.
    let lame = Lame::from_young_poisson(1e5, 0.3);
    let b = [0.2, -0.1, 0.05, 0.07, -0.03, 0.02];
    let d = [[0.3, 0.1, -0.2], [0.1, -0.4, 0.15], [-0.2, 0.15, 0.25]];
    for (law, past) in [
        (Law::<f64>::elastic(lame, 0.0), 0.0),
        (Law::elastoplastic(lame, 1e9, YieldNorm::Physical), 0.0),
        (Law::sand(lame, 30.0, 0.0, Cone::Shear), 0.0),
        (Law::snow(lame, cosplat_core::scene::SNOW), 0.9),
    ] {
        let at = |h: f64| {
            let moved = crate::math::congruence::<f64>(&d.map(|r| r.map(|v| all::<f64>(v * h))), &b.map(all::<f64>));
            law.energy(moved.map(|v| v.to_array()[0]), past)
        };
        let tau = law.stress(&b.map(all::<f64>), all::<f64>(past), &STILL).map(|v| v.to_array()[0]);
        let power = tau[0] * d[0][0]
            + tau[1] * d[1][1]
            + tau[2] * d[2][2]
            + 2.0 * (tau[3] * d[0][1] + tau[4] * d[0][2] + tau[5] * d[1][2]);
        let found = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!((found / power - 1.0).abs() < 1e-7, "{found} instead of {power}");
    }
}

#[test]
fn viscosity_of_a_solid_is_a_stress_of_its_own_that_takes_the_power_it_resists() {
    let law = Law::<f64>::elastic(Lame::from_young_poisson(1e5, 0.3), 7.0);
    let b = [0.2, -0.1, 0.05, 0.07, -0.03, 0.02].map(all::<f64>);
    let c = [[0.3, 0.1, -0.2], [0.1, -0.4, 0.15], [-0.2, 0.15, 0.25]];
    let lanes = c.map(|r| r.map(all::<f64>));
    let [moving, still] = [&lanes, &STILL].map(|c| law.stress(&b, NONE, c).map(|v| v.to_array()[0]));
    let t: Vec<f64> = moving.iter().zip(still).map(|(a, b)| a - b).collect();
    let power =
        t[0] * c[0][0] + t[1] * c[1][1] + t[2] * c[2][2] + 2.0 * (t[3] * c[0][1] + t[4] * c[0][2] + t[5] * c[1][2]);
    let heat = law.heat(&b, &lanes).unwrap().to_array()[0];
    // Sums in f64 of stresses of 1e4 Pa that nearly cancel.
    assert!(
        (power / heat - 1.0).abs() < 1e-9 && (t[0] + t[1] + t[2]).abs() < 1e-9 * power.abs().max(1.0),
        "{power} {heat}"
    );
    // 2 η J |dev D|²: J² = det(I + B).
    let mean = 0.05;
    let on: f64 = [0.3, -0.4, 0.25].iter().map(|d: &f64| (d - mean).powi(2)).sum();
    let square = on + 2.0 * (0.1_f64.powi(2) + 0.2_f64.powi(2) + 0.15_f64.powi(2));
    let j = (1.0 + det_minus_one::<f64>(&b).to_array()[0]).sqrt();
    assert!((heat / (14.0 * j * square) - 1.0).abs() < 1e-12, "{heat}");
    assert!((law.viscosity() - 7.0).abs() < 1e-15);
    assert!(Law::<f64>::elastic(Lame::from_young_poisson(1e5, 0.3), 0.0).heat(&b, &lanes).is_none());
}

/// Shear stress of a simple shear at that rate, over `time` in steps of `dt`, and the energy lost per volume.
fn sheared(law: &Law<f64>, rate: f64, time: f64, dt: f64) -> (f64, f64) {
    let (mut b, mut past, mut lost) = ([NONE; 6], NONE, 0.0);
    let l = [[NONE, NONE, all::<f64>(rate * dt)], [NONE; 3], [NONE; 3]];
    for _ in 0..(time / dt).round() as usize {
        b = crate::math::congruence::<f64>(&l, &b);
        if let Some(new) = law.flow(&b, past, &Room { dt, ..Room::endless() }) {
            (b, past, lost) = (new.b, new.past, lost + new.lost.to_array()[0]);
        }
    }
    (law.stress(&b, past, &STILL)[4].to_array()[0], lost)
}

#[test]
fn slow_and_fast_shear_is_that_of_herschel_and_bulkley() {
    let lame = Lame::from_young_poisson(1e6, 0.3);
    for (consistency, index) in [(0.0, 1.0), (40.0, 1.0), (300.0, 0.5), (90.0, 0.3)] {
        let law = Law::<f64>::viscoplastic(lame, [900.0, 0.0], (consistency, index), YieldNorm::Physical);
        for rate in [0.1_f64, 1.0, 30.0] {
            let (stress, lost) = sheared(&law, rate, 0.5 / rate, 1e-3 / rate);
            let wanted = 900.0 / 3.0_f64.sqrt() + consistency * rate.powf(index);
            // The stress turns with the material over one elastic strain, wanted over μ: first order in it.
            let elastic = wanted / lame.mu_pa;
            assert!((stress / wanted - 1.0).abs() < 2.0 * elastic, "{stress} of {wanted} at {rate} 1/s");
            // All work but that of the first elastic strain is lost, to the length of a step.
            assert!((lost / (wanted * (0.5 - 0.5 * elastic)) - 1.0).abs() < 1e-2, "{lost}");
            // A tenth of the step is the same flow: its rate is that of the end of the step, and here it does not change.
            let (fine, _) = sheared(&law, rate, 0.5 / rate, 1e-4 / rate);
            assert!((fine / stress - 1.0).abs() < 1e-5, "{fine} and {stress}");
        }
    }
}

#[test]
fn hardening_raises_and_softening_ends_the_yield_stress() {
    let lame = Lame::from_young_poisson(1e6, 0.3);
    let stress = |hardening: f64| {
        let law = Law::<f64>::viscoplastic(lame, [900.0, hardening], (0.0, 1.0), YieldNorm::Physical);
        sheared(&law, 1.0, 0.5, 1e-3).0
    };
    // The equivalent plastic strain of a simple shear γ is γ/√3: of all but the elastic part.
    let plastic = (0.5 - 900.0 / 3.0_f64.sqrt() / lame.mu_pa) / 3.0_f64.sqrt();
    let wanted = (900.0 + 2000.0 * plastic) / 3.0_f64.sqrt();
    // First order in the elastic strain, 0.2 %, as above.
    assert!((stress(2000.0) / wanted - 1.0).abs() < 5e-3, "{} of {wanted}", stress(2000.0));
    assert!(stress(-4000.0).abs() < 1e-9, "{}", stress(-4000.0));
}
