//! How far samples are behind what their partner says of them.
//!
//! Within a window a sample gives way at its own mass. In truth others hold it, so that at the start of the next window it
//! is said to be further on, by up to `v W` with the speed `v` and the window `W`, which takes it through thin cloth at
//! once. So it goes on from where contact left it instead, and makes up for the way within the window: no sample ever
//! jumps, and cloth that is in the way takes and gives the impulse of that as well.
//!
//! A sample of the mass `m` and a cloth of the mass `M` that rests on it then exchange as `u' = r u - (1-r) o/W`,
//! `o' = r (o + u W)` with the velocity `u`, the way `o` and `r = M/(M + m)`, whose eigenvalues are `r ± i √(r (1-r))`, of
//! modulus `√r`: it settles for any masses. To what holds it, such a sample is a spring of the stiffness `m/W²`. Under a
//! lasting force `F` it is overrun by `F W²/m`, and a body of the mass `B` at the speed `v` that nothing else holds up is
//! further on than its samples by at most `v W √(B/m)` before it is stopped. Where that is more than the distance at which
//! they touch, the body is through the cloth for so long; the cloth is on the right side of all its samples all the same.

use cosplat_core::boundary::{Vec3, dot, norm, scale, sub};
use cosplat_core::plugin::{StateError, StateReader, StateSink};

/// Where contact left each sample \[m\]; nothing of those that met no cloth.
pub(crate) type Left = Vec<Option<Vec3>>;

/// Ways of all samples back to where contact left them.
#[derive(Clone, Debug)]
pub(crate) struct Behind {
    /// At the start of the window \[m\].
    way: Vec<Vec3>,
    /// 1 / the window \[1/s\].
    rate: f64,
}

impl Behind {
    /// Of samples that are said to be at `said` at the start of a window of `length` \[s\].
    pub(crate) fn new(left: &[Option<Vec3>], said: &[Vec3], length: f64) -> Self {
        let from = |i: usize| left.get(i).copied().flatten();
        let way = |(i, &said): (usize, &Vec3)| from(i).map_or([0.0; 3], |x| sub(x, said));
        Self { way: said.iter().enumerate().map(way).collect(), rate: 1.0 / length }
    }

    /// Way of a sample \[m\] at `t` \[s\] from the start, and how fast it changes \[m/s\].
    pub(crate) fn at(&self, sample: u32, t: f64) -> [Vec3; 2] {
        let way = self.way[sample as usize];
        [scale(way, 1.0 - t * self.rate), scale(way, -self.rate)]
    }

    /// Speed at which a sample catches up \[m/s\].
    pub(crate) fn speed(&self, sample: u32) -> f64 {
        norm(self.way[sample as usize]) * self.rate
    }

    /// How much further a sample is in truth, against the impulse \[N s\] that it takes \[m\].
    pub(crate) fn overrun(&self, sample: u32, impulse: Vec3) -> f64 {
        let size = norm(impulse);
        if size > 0.0 { (dot(self.way[sample as usize], impulse) / size).max(0.0) } else { 0.0 }
    }
}

/// Writes them.
pub(crate) fn save(left: &[Option<Vec3>], sink: &mut dyn StateSink) {
    let known = || (0_u64..).zip(left).filter_map(|(i, x)| x.map(|x| (i, x)));
    sink.u64(known().count() as u64);
    for (i, x) in known() {
        sink.u64(i);
        sink.vec3(x);
    }
}

/// Reads them back, for so many samples.
pub(crate) fn restore(reader: &mut StateReader, samples: usize) -> Result<Left, StateError> {
    let mut left = vec![None; samples];
    for _ in 0..reader.u64()? {
        let (i, x) = (reader.u64()?, reader.vec3()?);
        let wrong = StateError::Count { what: "samples that met cloth", found: i, expected: samples as u64 };
        *left.get_mut(i as usize).ok_or(wrong)? = Some(x);
    }
    Ok(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_makes_up_for_its_way_in_a_window() {
        let behind = Behind::new(&[None, Some([0.0, 0.0, 1.0])], &[[5.0; 3], [0.0, 0.0, 0.5]], 0.1);
        let is = |a: Vec3, b: Vec3| assert!(norm(sub(a, b)) < 1e-15, "{a:?} {b:?}");
        behind.at(0, 0.03).into_iter().for_each(|v| is(v, [0.0; 3]));
        let [way, closing] = behind.at(1, 0.0);
        is(way, [0.0, 0.0, 0.5]);
        is(closing, [0.0, 0.0, -5.0]);
        is(behind.at(1, 0.1)[0], [0.0; 3]);
        // Cloth that pushes it up is overrun by the way; cloth on its other side is not.
        let overrun = |z: f64| behind.overrun(1, [0.0, 0.0, z]);
        is([behind.speed(1), overrun(2.0), overrun(-2.0)], [5.0, 0.5, 0.0]);
    }

    #[test]
    fn what_contact_left_comes_back_and_strange_samples_are_refused() {
        let left = vec![None, Some([0.1, 0.2, 0.3]), None];
        let mut bytes = Vec::new();
        save(&left, &mut bytes);
        assert_eq!(restore(&mut StateReader::new(&bytes), 3), Ok(left));
        assert!(restore(&mut StateReader::new(&bytes), 1).is_err());
    }
}
