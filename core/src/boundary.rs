//! What a body shows to others and what crosses an interface: samples, proxies and impulses.

use serde::{Deserialize, Serialize};

/// Three components along the world axes.
pub type Vec3 = [f64; 3];

/// What never changes about the samples of a body. All columns have the same length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SampleStatics {
    /// Fixed identity of each sample.
    pub id: Vec<u64>,
    /// Area \[m²\]; 0 for samples inside a volume.
    pub area_m2: Vec<f64>,
    /// Volume \[m³\].
    pub volume_m3: Vec<f64>,
    /// Mass with which it resists who pushes it \[kg\]: its own, or more where what is behind it moves along. It must not be more
    /// than it resists with where all samples are pushed alike, or who computes the contact makes energy.
    pub mass_kg: Vec<f64>,
}

impl SampleStatics {
    /// `n` points that share a mass \[kg\] each and have neither area nor volume, numbered from 0.
    pub fn equal(n: usize, mass_each_kg: f64) -> Self {
        let nothing = vec![0.0; n];
        Self {
            id: (0..n as u64).collect(),
            area_m2: nothing.clone(),
            volume_m3: nothing,
            mass_kg: vec![mass_each_kg; n],
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }
}

/// Samples of a deformable body at one moment. `normal` is empty for sets without normals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Positions \[m\], world frame.
    pub position: Vec<Vec3>,
    /// Velocities \[m/s\], world frame.
    pub velocity: Vec<Vec3>,
    /// Outward unit normals, or nothing.
    pub normal: Vec<Vec3>,
}

/// Record of a rigid body from which a resolver makes its stand-in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxyRecord {
    /// Centre of mass \[m\].
    pub position: Vec3,
    /// Unit quaternion `[x, y, z, w]`.
    pub orientation: [f64; 4],
    /// Velocity of the centre of mass \[m/s\].
    pub linear_velocity: Vec3,
    /// Angular velocity, world axes \[rad/s\].
    pub angular_velocity: Vec3,
    /// Mass \[kg\]; infinite for a scripted body.
    pub mass: f64,
    /// Moments and products of inertia about the centre of mass, world axes: xx, yy, zz, xy, xz, yz \[kg m²\].
    pub inertia: [f64; 6],
    /// Part of the body that this resolver may count on: 1 / (number of resolvers that can reach it).
    pub share: f64,
    /// Background rate of the linear velocity \[m/s²\].
    pub background_linear: Vec3,
    /// Background rate of the angular velocity \[rad/s²\].
    pub background_angular: Vec3,
}

/// Boundary of one body at one moment.
#[derive(Clone, Debug, PartialEq)]
pub enum BoundaryState {
    /// A deformable body or a set of points.
    Samples(Samples),
    /// A rigid body.
    Proxy(ProxyRecord),
}

impl Samples {
    /// Whether every number is one.
    pub fn is_finite(&self) -> bool {
        self.position.iter().chain(&self.velocity).chain(&self.normal).flatten().all(|c| c.is_finite())
    }
}

impl BoundaryState {
    /// Points without normals.
    pub fn points(position: &[Vec3], velocity: &[Vec3]) -> Self {
        Self::Samples(Samples { position: position.into(), velocity: velocity.into(), normal: Vec::new() })
    }
}

/// Impulse of a window on one body of a partner.
#[derive(Clone, Debug, PartialEq)]
pub enum Impulses {
    /// One per sample \[N s\], in the order of the set.
    Samples(Vec<Vec3>),
    /// On a rigid body.
    Rigid(Wrench),
}

/// A linear and an angular quantity of a kind: impulse \[N s, N m s\] or momentum \[kg m/s, kg m²/s\].
///
/// Impulses on rigid bodies carry their angular part about the body's centre of mass at the start of the window;
/// ledger entries carry theirs about the world origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Linear part.
    pub linear: Vec3,
    /// Angular part.
    pub angular: Vec3,
}

impl Wrench {
    /// Sum.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { linear: add(self.linear, other.linear), angular: add(self.angular, other.angular) }
    }

    /// Difference.
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        self.plus(other.negated())
    }

    /// The same impulse with its moment taken about `new` instead of `old`.
    #[must_use]
    pub fn about(self, old: Vec3, new: Vec3) -> Self {
        Self { angular: add(self.angular, cross(sub(old, new), self.linear)), ..self }
    }

    /// Opposite.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { linear: scale(self.linear, -1.0), angular: scale(self.angular, -1.0) }
    }
}

impl Impulses {
    /// Sum over the samples in their order, so that sender and receiver get the same bits \[N s\].
    pub fn total(&self) -> Vec3 {
        self.sums().0
    }

    /// Sum of magnitudes \[N s\]: the scale against which a defect is judged.
    pub fn gross(&self) -> f64 {
        self.sums().1
    }

    /// Sum and sum of magnitudes \[N s\], in one pass.
    pub fn sums(&self) -> (Vec3, f64) {
        match self {
            Self::Samples(each) => each.iter().fold(([0.0; 3], 0.0), |(sum, gross), &j| (add(sum, j), gross + norm(j))),
            Self::Rigid(wrench) => (wrench.linear, norm(wrench.linear)),
        }
    }

    /// What the other side takes: the same impulses with the other sign.
    #[must_use]
    pub fn negated(&self) -> Self {
        match self {
            Self::Samples(each) => Self::Samples(each.iter().map(|&j| scale(j, -1.0)).collect()),
            Self::Rigid(wrench) => Self::Rigid(wrench.negated()),
        }
    }

    /// The same shape with every impulse zero.
    #[must_use]
    pub fn zeroed(&self) -> Self {
        match self {
            Self::Samples(each) => Self::Samples(vec![[0.0; 3]; each.len()]),
            Self::Rigid(_) => Self::Rigid(Wrench::default()),
        }
    }
}

/// `a + b`.
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `s a`.
pub fn scale(a: Vec3, s: f64) -> Vec3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `a × b`.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a · b`.
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `|a|`.
pub fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrench_keeps_its_moment_about_the_origin_when_its_centre_moves() {
        let wrench = Wrench { linear: [1.0, -2.0, 0.5], angular: [0.25, 4.0, -1.0] };
        let (old, new) = ([3.0, 0.5, -1.0], [-2.0, 8.0, 0.125]);
        let moment = |centre: Vec3, w: Wrench| add(cross(centre, w.linear), w.angular);
        // All numbers are short binary fractions: the sums are exact.
        let bits = |v: Vec3| v.map(f64::to_bits);
        assert_eq!(bits(moment(new, wrench.about(old, new))), bits(moment(old, wrench)));
    }

    #[test]
    fn equal_points_have_a_mass_and_nothing_else() {
        let three = SampleStatics::equal(3, 0.5);
        assert_eq!((three.len(), &three.id[..]), (3, &[0, 1, 2][..]));
        assert_eq!((three.mass_kg, three.area_m2, three.volume_m3), (vec![0.5; 3], vec![0.0; 3], vec![0.0; 3]));
        assert!(SampleStatics::equal(0, 0.5).is_empty());
    }

    #[test]
    fn action_and_reaction_cancel() {
        let samples = Impulses::Samples(vec![[1.0, -2.0, 0.5], [3.0, 0.0, 0.25]]);
        let rigid = Impulses::Rigid(Wrench { linear: [1.0, -2.0, 0.5], angular: [3.0, 0.0, 0.25] });
        for given in [samples, rigid] {
            let both = add(given.total(), given.negated().total());
            assert_eq!(both.map(f64::to_bits), [0; 3]);
            assert_eq!(given.negated().negated(), given);
        }
    }

    #[test]
    fn a_sample_is_finite_when_all_its_numbers_are() {
        let spoiled = |bad: f64, column: usize| {
            let mut columns = [[1.0, 2.0, 3.0]; 2];
            columns[column][1] = bad;
            let BoundaryState::Samples(samples) = BoundaryState::points(&columns[..1], &columns[1..]) else {
                panic!("not samples");
            };
            samples.is_finite()
        };
        assert!(spoiled(0.0, 0) && spoiled(0.0, 1));
        assert!(!spoiled(f64::NAN, 0) && !spoiled(f64::INFINITY, 1));
    }
}
