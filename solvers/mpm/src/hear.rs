//! What is heard of partners at the start of a step.

use cosplat_core::boundary::{BoundaryState, Impulses, norm, sub};
use cosplat_core::plugin::{Inputs, PluginError};

use crate::kick::{Kick, Kicks};
use crate::plugin::{Run, refused};
use crate::proxy::Proxy;
use crate::real::Real;
use crate::swarm::Swarm;

/// Speed by which each partner differs from what its stand-in foresaw \[m/s\].
pub(crate) struct Residuals {
    /// Rigid partners.
    pub(crate) proxies: Vec<f64>,
    /// Partners that show samples.
    pub(crate) swarms: Vec<f64>,
}

impl<R: Real> Run<R> {
    /// Stand-ins of all rigid partners, in the order of the partners.
    pub(crate) fn proxies(&self, inputs: &Inputs) -> Result<Vec<Proxy>, PluginError> {
        let mut proxies = Vec::new();
        for (index, partner) in self.sim.setting.partners.iter().enumerate() {
            let record = self.model.faces.iter().filter(|f| f.partner == Some(index)).find_map(|f| {
                let input = inputs.partner(f.id)?;
                if let BoundaryState::Proxy(record) = &input.now { Some(record) } else { None }
            });
            let record = record.ok_or_else(|| refused(&format!("a step without the record of `{}`", partner.name)))?;
            if !Proxy::is_sound(record) {
                return Err(PluginError::Physics(format!("the record of `{}` is not finite", partner.name)));
            }
            proxies.push(Proxy::new(index, record, self.model.names.len()));
        }
        Ok(proxies)
    }

    /// Speed by which each partner differs from what its stand-in foresaw.
    pub(crate) fn residuals(&self, proxies: &[Proxy]) -> Vec<f64> {
        let differs = |p: &Proxy| {
            let (v, _) = p.twist();
            self.foreseen[p.partner].map_or(0.0, |[before, _]| norm(sub(v, before)))
        };
        proxies.iter().map(differs).collect()
    }

    pub(crate) fn kicks(&self, inputs: &Inputs) -> Result<Kicks, PluginError> {
        let mut kicks = Vec::new();
        for input in &inputs.impulses {
            let face = self.model.faces.iter().position(|f| f.id == input.interface && f.role.takes_impulses());
            let index = face.ok_or_else(|| refused(&format!("impulses at interface {}", input.interface)))?;
            let surface = &self.model.shown[self.model.faces[index].body].surface;
            let Impulses::Samples(wanted) = &input.impulses else {
                return Err(refused("a rigid impulse on particles"));
            };
            if wanted.len() != surface.len() {
                return Err(refused(&format!("{} impulses on {} samples", wanted.len(), surface.len())));
            }
            if wanted.iter().flatten().any(|j| !j.is_finite()) {
                return Err(PluginError::Physics(format!("impulses at interface {} are not finite", input.interface)));
            }
            let ids = surface.iter().map(|mark| mark.id).collect();
            kicks.push(Kick::new(index, ids, wanted.clone(), input.spread));
        }
        Ok(Kicks(kicks))
    }

    /// Stand-ins of all partners that show samples, and by how much these differ from what was foreseen.
    pub(crate) fn swarms(&self, inputs: &Inputs, length: f64) -> Result<(Vec<Swarm>, Vec<f64>), PluginError> {
        let (mut swarms, mut residuals) = (Vec::new(), Vec::new());
        for (k, (cloud, felt)) in self.sim.setting.clouds.iter().zip(&self.felt).enumerate() {
            let input = self.model.faces.iter().filter(|f| f.cloud == Some(k)).find_map(|f| inputs.partner(f.id));
            let input = input.ok_or_else(|| refused(&format!("a step without the samples of `{}`", cloud.name)))?;
            let shown = input.samples(&cloud.name, cloud.marks.len())?;
            swarms.push(Swarm::new(cloud, shown, felt, length));
            residuals.push(felt.residual(shown));
        }
        Ok((swarms, residuals))
    }
}
