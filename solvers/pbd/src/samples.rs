//! A partner that shows samples: which of them each vertex can meet, and where they are.
//!
//! A sample is a small plane: the surface of its particle, half a particle outwards along its normal. It moves as the
//! partner said, and by the impulses it has taken in this window at its own mass, so that a light body gives way.

use cosplat_core::boundary::{SampleStatics, Samples, Vec3, add, dot, scale, sub};
use cosplat_core::plugin::PartnerInput;

use crate::cells::Cells;

/// Width of a sample that has neither an area nor a volume \[m\].
const NO_WIDTH: f64 = 1e-3;

/// What never changes about a partner's samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Marks {
    /// Distance of the surface from the sample \[m\].
    radius: Vec<f64>,
    /// Width of the patch that it stands for \[m\].
    width: Vec<f64>,
    /// 1 / mass \[1/kg\].
    inverse: Vec<f64>,
    /// Greatest width \[m\].
    widest: f64,
}

impl Marks {
    /// From what a partner said; nothing where a sample has no mass.
    pub(crate) fn new(statics: &SampleStatics) -> Option<Self> {
        if !statics.mass_kg.iter().all(|m| m.is_finite() && *m > 0.0) {
            return None;
        }
        let radius: Vec<f64> = statics.volume_m3.iter().map(|&v| 0.5 * libm::cbrt(v.max(0.0))).collect();
        let width = |(&area, &radius): (&f64, &f64)| match area.max(0.0).sqrt().max(2.0 * radius) {
            none if none <= 0.0 => NO_WIDTH,
            width => width,
        };
        let width: Vec<f64> = statics.area_m2.iter().zip(&radius).map(width).collect();
        let inverse = statics.mass_kg.iter().map(|m| 1.0 / m).collect();
        let widest = width.iter().copied().fold(0.0, f64::max);
        Some(Self { radius, width, inverse, widest })
    }

    /// Mean width of the patches that samples stand for \[m\].
    pub(crate) fn mean_width(&self) -> f64 {
        self.width.iter().sum::<f64>() / self.width.len().max(1) as f64
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.radius.len()
    }
}

/// Samples of a partner over one window.
#[derive(Clone, Debug)]
pub(crate) struct Swarm<'a> {
    marks: &'a Marks,
    normal: &'a [Vec3],
    path: Vec<[Vec3; 4]>,
    /// Displacement and velocity by the impulses of this window \[m, m/s\].
    moved: Vec<[Vec3; 2]>,
    /// Position and velocity in this substep.
    now: Vec<[Vec3; 2]>,
    /// Impulses on the samples \[N s\].
    pub(crate) impulse: Vec<Vec3>,
    /// Samples that each vertex can meet in this window: where its list begins, and the lists.
    begin: Vec<u32>,
    near: Vec<u32>,
    /// Samples in any of the lists.
    active: Vec<u32>,
}

impl<'a> Swarm<'a> {
    /// Looks for the samples that each vertex, or point of a triangle, can meet; `reach` is how far it may move towards
    /// them \[m\].
    pub(crate) fn new(
        marks: &'a Marks,
        samples: &'a Samples,
        input: &PartnerInput,
        vertices: impl Iterator<Item = Option<Vec3>>,
        reach: f64,
    ) -> Self {
        let count = samples.position.len();
        let reach = reach + 2.0 * marks.widest;
        let fold = |f: fn(f64, f64) -> f64, start: f64| {
            [0, 1, 2].map(|k| samples.position.iter().map(|x| x[k]).fold(start, f))
        };
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        let inside = |x: &Vec3| (0..3).all(|k| x[k] > low[k] - reach && x[k] < high[k] + reach);
        // Sorted only once somebody is there.
        let mut cells = None;
        let (mut begin, mut near) = (vec![0], Vec::new());
        for x in vertices {
            if let Some(x) = x.filter(inside) {
                let cells = cells.get_or_insert_with(|| Cells::new(&samples.position, reach));
                cells.near(x, [reach; 3], |range| {
                    let close = |&&i: &&u32| {
                        let d = sub(samples.position[i as usize], x);
                        dot(d, d) < reach * reach
                    };
                    near.extend(cells.items()[range].iter().filter(close));
                });
            }
            begin.push(near.len() as u32);
        }
        let mut active = near.clone();
        active.sort_unstable();
        active.dedup();
        Self {
            marks,
            normal: &samples.normal,
            path: (0..count).map(|i| input.path(i)).collect(),
            moved: vec![[[0.0; 3]; 2]; count],
            now: vec![[[0.0; 3]; 2]; count],
            impulse: vec![[0.0; 3]; count],
            begin,
            near,
            active,
        }
    }

    /// Moves on to `t` \[s\] from the start of the window.
    pub(crate) fn at(&mut self, t: f64) {
        for &i in &self.active {
            let ([a, b, c, d], [moved, v]) = (self.path[i as usize], self.moved[i as usize]);
            let x = add(add(a, moved), scale(add(b, scale(add(c, scale(d, t)), t)), t));
            let u = add(v, add(b, scale(add(scale(c, 2.0), scale(d, 3.0 * t)), t)));
            self.now[i as usize] = [x, u];
        }
    }

    /// Moves the samples by what they have taken.
    pub(crate) fn drift(&mut self, h: f64) {
        for &i in &self.active {
            let [x, v] = &mut self.moved[i as usize];
            *x = add(*x, scale(*v, h));
        }
    }

    /// Whether a vertex can meet any sample at all.
    pub(crate) fn is_near(&self, vertex: usize) -> bool {
        self.begin[vertex] < self.begin[vertex + 1]
    }

    /// Nearest sample to vertex `vertex` at `x`: its number, gap to its surface \[m\] and normal.
    pub(crate) fn nearest(&self, vertex: usize, x: Vec3) -> Option<(u32, f64, Vec3)> {
        let list = &self.near[self.begin[vertex] as usize..self.begin[vertex + 1] as usize];
        let away = |i: u32| sub(x, self.now[i as usize][0]);
        let square = |i: u32| dot(away(i), away(i));
        let &nearest = list.iter().min_by(|&&a, &&b| square(a).total_cmp(&square(b)))?;
        let i = nearest as usize;
        let (n, d) = (self.normal[i], away(nearest));
        let height = dot(n, d);
        let (aside, width) = ((square(nearest) - height * height).max(0.0), self.marks.width[i]);
        // Beside the patch, or so far behind it that it is another side's.
        if aside > width * width || height < -width {
            return None;
        }
        Some((nearest, height - self.marks.radius[i], n))
    }

    /// Velocity of a sample \[m/s\].
    pub(crate) fn velocity(&self, sample: u32) -> Vec3 {
        self.now[sample as usize][1]
    }

    /// 1 / mass of a sample \[1/kg\].
    pub(crate) fn inverse(&self, sample: u32) -> f64 {
        self.marks.inverse[sample as usize]
    }

    /// Gives a sample an impulse \[N s\].
    pub(crate) fn take(&mut self, sample: u32, impulse: Vec3) {
        let i = sample as usize;
        let change = scale(impulse, self.marks.inverse[i]);
        self.now[i][1] = add(self.now[i][1], change);
        self.moved[i][1] = add(self.moved[i][1], change);
        self.impulse[i] = add(self.impulse[i], impulse);
    }
}
