//! Partners that show samples: beads with a mass that particles bounce off without restitution.

use cosplat_core::boundary::{SampleStatics, Vec3, Wrench, add, cross, dot, norm, scale, sub};

use super::near::Cells;
use crate::solids::Crossed;

/// A particle that can meet a sample within a substep.
#[derive(Clone, Copy, Debug)]
struct Contact {
    particle: u32,
    sample: u32,
    /// Unit vector from the sample, and what is between them \[m\].
    away: Vec3,
    gap: f64,
}

/// Radius \[m\] and mass \[kg\] of each sample of a partner.
#[derive(Clone, Debug, Default)]
pub(crate) struct Beads {
    pub(crate) radius: Vec<f64>,
    pub(crate) mass: Vec<f64>,
}

impl Beads {
    /// Half the distance of samples that cover their area or fill their volume; those with neither are as large as the
    /// smoke's own particles.
    pub(crate) fn new(statics: &SampleStatics, spacing: f64) -> Self {
        let width = |i: usize| match (statics.area_m2[i], statics.volume_m3[i]) {
            (area, _) if area > 0.0 => area.sqrt(),
            (_, volume) if volume > 0.0 => volume.cbrt(),
            _ => spacing,
        };
        Self { radius: (0..statics.len()).map(|i| 0.5 * width(i)).collect(), mass: statics.mass_kg.clone() }
    }
}

/// A partner over a window: its samples stay where they are seen, with velocities that take what they are given.
#[derive(Clone, Debug)]
pub(crate) struct Meeting<'a> {
    beads: &'a Beads,
    x: Vec<Vec3>,
    v: Vec<Vec3>,
    cells: Cells,
    /// Half a spacing of the smoke \[m\].
    own: f64,
    /// How far beyond contact particles are looked at \[m\].
    ahead: f64,
    contacts: Vec<Contact>,
    /// Row of the interface, and the impulse on each sample so far \[N s\].
    pub(crate) row: usize,
    pub(crate) taken: Vec<Vec3>,
}

impl<'a> Meeting<'a> {
    /// Samples at `x` \[m\] with velocities `v` \[m/s\]; `own` is half a spacing of the smoke \[m\].
    pub(crate) fn new(beads: &'a Beads, x: Vec<Vec3>, v: Vec<Vec3>, own: f64, row: usize) -> Self {
        let (ahead, taken) = (own, vec![[0.0; 3]; x.len()]);
        let widest = beads.radius.iter().fold(0.0_f64, |m, r| m.max(*r));
        let cells = Cells::new(&x, widest + own + ahead);
        Self { beads, x, v, cells, own, ahead, contacts: Vec::new(), row, taken }
    }

    /// Largest speed of a sample \[m/s\].
    pub(crate) fn speed(&self) -> f64 {
        self.v.iter().fold(0.0, |most, &v| most.max(norm(v)))
    }

    /// Finds who can meet.
    pub(crate) fn find(&mut self, particles: &[Vec3]) {
        self.contacts.clear();
        for (i, &x) in particles.iter().enumerate() {
            self.cells.around(x, |j| {
                let apart = sub(x, self.x[j]);
                let distance = norm(apart);
                let gap = distance - self.beads.radius[j] - self.own;
                if gap < self.ahead && distance > 0.0 {
                    let (particle, sample) = (i as u32, j as u32);
                    self.contacts.push(Contact { particle, sample, away: scale(apart, 1.0 / distance), gap });
                }
            });
        }
    }

    /// Stops particles of that mass \[kg\] where they meet samples within `dt` \[s\].
    pub(crate) fn stop(&mut self, mass: f64, dt: f64, x: &[Vec3], v: &mut [Vec3], crossed: &mut [Crossed]) {
        for contact in &self.contacts {
            let (i, j) = (contact.particle as usize, contact.sample as usize);
            let short = -contact.gap.max(0.0) / dt - dot(contact.away, sub(v[i], self.v[j]));
            if short <= 0.0 {
                continue;
            }
            let size = short / (1.0 / mass + 1.0 / self.beads.mass[j]);
            let (impulse, before) = (scale(contact.away, size), v[i]);
            v[i] = add(before, scale(impulse, 1.0 / mass));
            self.v[j] = sub(self.v[j], scale(impulse, 1.0 / self.beads.mass[j]));
            self.taken[j] = sub(self.taken[j], impulse);
            let work = 0.5 * dot(impulse, add(before, v[i]));
            crossed[self.row].take(Wrench { linear: impulse, angular: cross(x[i], impulse) }, size, work);
        }
    }
}
