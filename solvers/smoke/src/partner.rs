//! Partners over one window: what they show becomes solids, and what crossed becomes the answer.

use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Vec3, add, scale};
use cosplat_core::distance::Placed;
use cosplat_core::plan::InterfaceId;
use cosplat_core::plugin::{Inputs, InterfaceReport, PartnerInput, PartnerSetup, PluginError, Refusals};
use cosplat_core::scene::MotionRule;

use crate::model::{Face, Model, Partner};
use crate::proxy::Proxy;
use crate::solids::{Crossed, Filled, HEAVIEST, Kind, Sampled, Solids, inside, radius};

/// Samples of a partner farther apart than this many cells let the gas through.
const WIDEST: f64 = 1.5;

/// Masses over that of the gas in a cell of the samples of each partner, by row; empty for rigid ones.
pub(crate) type Masses = Vec<Vec<f64>>;

/// Reads what never changes about partners.
pub(crate) fn masses(model: &Model, setups: &[PartnerSetup]) -> Result<Masses, PluginError> {
    let gas = model.cell_mass();
    let one = |face: &Face| {
        if let Partner::Rigid(_) = face.partner {
            return Ok(Vec::new());
        }
        let statics = sound(face, setups)?;
        covering(face, statics, model.grid.h, "the gas on cells of", "`cell`")?;
        Ok(statics.mass_kg.iter().map(|m| (m / gas).min(HEAVIEST)).collect())
    };
    model.partners.iter().map(one).collect()
}

/// What never changes about the samples of a partner, each of which must have a mass.
pub(crate) fn sound<'a>(face: &Face, setups: &'a [PartnerSetup]) -> Result<&'a SampleStatics, PluginError> {
    let refuse = |what: String| Refusals::one("smoke", what);
    let Some(setup) = setups.iter().find(|s| s.interface == face.interface) else {
        return Err(refuse(format!("partners without samples (`{}`)", face.name)));
    };
    let statics = &setup.statics;
    if statics.mass_kg.iter().any(|m| m.is_nan() || *m <= 0.0) || statics.area_m2.iter().any(|a| !a.is_finite()) {
        return Err(refuse(format!("partners whose samples have no mass (`{}`)", face.name)));
    }
    Ok(statics)
}

/// Refuses samples of a surface through which `what`, that wide \[m\], would pass; `knob` is what can be made coarser.
pub(crate) fn covering(
    face: &Face,
    statics: &SampleStatics,
    width: f64,
    what: &str,
    knob: &str,
) -> Result<(), PluginError> {
    let mean = statics.area_m2.iter().sum::<f64>() / statics.len().max(1) as f64;
    if mean <= WIDEST * WIDEST * width * width {
        return Ok(());
    }
    let (apart, name, most) = (mean.sqrt(), &face.name, WIDEST * width);
    Err(Refusals::one(
        "smoke",
        format!(
            "samples {apart:.3} m apart, which {what} {width} m passes (`{name}`): give `{name}` a spacing of at most \
             {most:.3} m, or the smoke a coarser {knob}"
        ),
    ))
}

/// Stand-in of a rigid partner of that name.
pub(crate) fn proxy(name: &str, shown: &BoundaryState) -> Result<Proxy, PluginError> {
    let BoundaryState::Proxy(record) = shown else {
        return Err(PluginError::Unsupported(format!("`{name}` is rigid, but shows samples")));
    };
    Proxy::new(record).ok_or_else(|| PluginError::Physics(format!("the boundary of partner `{name}` is not finite")))
}

/// Places \[m\] and velocities \[m/s\] of a partner's samples over a step.
pub(crate) fn seen_samples(
    input: &PartnerInput,
    name: &str,
    count: usize,
) -> Result<(Vec<Vec3>, Vec<Vec3>), PluginError> {
    let shown = input.samples(name, count)?;
    let newest = match &input.next {
        Some(next) => {
            let later = PartnerInput { now: next.clone(), next: None, ..input.clone() };
            later.samples(name, count)?.clone()
        }
        None => shown.clone(),
    };
    Ok((0..count).map(|i| seen(input, i, newest.velocity[i])).unzip())
}

/// Where a sample is seen over a step: in its middle, or under the rule `hold` where it stays; and how fast it goes.
fn seen(input: &PartnerInput, i: usize, velocity: Vec3) -> (Vec3, Vec3) {
    let [c0, c1, c2, c3] = input.path(i);
    let t = 0.5 * input.length_s;
    let x = add(c0, scale(add(c1, scale(add(c2, scale(c3, t)), t)), t));
    let v = if input.rule == MotionRule::Hold {
        velocity
    } else {
        add(c1, scale(add(scale(c2, 2.0), scale(c3, 3.0 * t)), t))
    };
    (x, v)
}

/// All solids of a window.
pub(crate) fn hear(model: &Model, masses: &Masses, inputs: &Inputs) -> Result<Solids, PluginError> {
    let mut solids = Solids {
        filled: model.fixed.clone(),
        crossed: vec![Crossed::default(); model.partners.len()],
        ..Solids::default()
    };
    for (row, face) in model.partners.iter().enumerate() {
        let name = &face.name;
        let missing = || PluginError::Unsupported(format!("a step without the boundary of partner `{name}`"));
        let input = inputs.partner(face.interface).ok_or_else(missing)?;
        match &face.partner {
            Partner::Rigid(shape) => {
                let proxy = proxy(name, &input.now)?;
                let record = proxy.record;
                let placed = Placed::new(shape.clone(), record.position, record.orientation);
                let faces = inside(&model.grid, &placed, radius(shape).map(|r| (record.position, r)));
                let gas = model.cell_mass() * faces.len().max(1) as f64 / 3.0;
                let ratio = (record.mass * record.share / gas).min(HEAVIEST);
                solids.filled.push(Filled { kind: Kind::Rigid(Box::new(proxy)), faces, ratio, row: Some(row) });
            }
            Partner::Samples => {
                let ratio = masses.get(row).cloned().unwrap_or_default();
                let (x, v) = seen_samples(input, name, ratio.len())?;
                let taken = vec![[0.0; 3]; ratio.len()];
                solids.sampled.push(Sampled { x, v, ratio, row, taken });
            }
        }
    }
    Ok(solids)
}

/// Impulses on partners, and the own view of each interface.
pub(crate) fn answer(model: &Model, solids: &Solids) -> (Vec<(InterfaceId, Impulses)>, Vec<InterfaceReport>) {
    let (mut given, mut reports) = (Vec::new(), Vec::new());
    for (row, (face, crossed)) in model.partners.iter().zip(&solids.crossed).enumerate() {
        let impulses = match solids.sampled.iter().find(|s| s.row == row) {
            Some(set) => Impulses::Samples(set.taken.clone()),
            None => Impulses::Rigid(crossed.on_rigid),
        };
        given.push((face.interface, impulses));
        reports.push(crossed.report(face.interface));
    }
    (given, reports)
}
