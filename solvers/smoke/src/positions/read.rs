//! From a solver's part of a scene to a [`Cloud`].

use cosplat_core::boundary::{Vec3, add, scale};
use cosplat_core::distance::{Placed, Shape};
use cosplat_core::plan::LeftOut;
use cosplat_core::plugin::{PluginError, Refusals, SolverScene};
use cosplat_core::scene::Body;

use super::cloud::{Cloud, Fixed};
use super::density::Pass;
use super::kernel::Kernel;
use super::near::Pairs;
use super::touch::{Solid, Walls};
use crate::fill::fill;
use crate::params::Params;
use crate::read::{Asked, gas, gravity, partners, statics, winds};

/// Parameters that only the grid has.
const OF_THE_GRID: [&str; 9] = [
    "cell",
    "kinematic_viscosity",
    "vorticity_confinement",
    "inflow_rate",
    "inflow_velocity",
    "still",
    "courant",
    "divergence",
    "max_iterations",
];

/// Reads the scene of one cloud.
pub(crate) fn read(
    scene: &SolverScene,
    Asked { body, params, mut refusals }: Asked<'_>,
) -> Result<(Cloud, Vec<LeftOut>), PluginError> {
    for key in OF_THE_GRID.iter().filter(|key| scene.params.contains_key(**key)) {
        refusals.push(format!("parameter `{key}` beside `method = \"positions\"`: it belongs to the grid"));
    }
    let made = fill(scene, body).map_err(|why| refusals.push(why)).ok();
    let Some((spacing, points, volume)) = made else {
        refusals.finish()?;
        return Err(Refusals::one("smoke", "this body"));
    };
    let (warm, viscosity) = gas(body, &params);
    let start: Vec<Vec3> = points.iter().map(|&x| body.pose.apply(x)).collect();
    let centre = scale(start.iter().fold([0.0; 3], |sum, &x| add(sum, x)), 1.0 / start.len().max(1) as f64);
    let v = start.iter().map(|&x| body.velocity.at(x, centre)).collect();
    let (kernel, walls) = (Kernel::new(spacing), walls(scene, body, &params, spacing, &mut refusals));
    let fixed = Fixed {
        name: body.name.clone(),
        params,
        kernel,
        spacing,
        mass: warm * volume,
        volume,
        heavier: 1.0 - params.air / warm,
        viscosity,
        rest: begun(&kernel, &start, walls.clone()),
        start: start.clone(),
        walls,
        partners: partners(scene, &mut refusals, spacing),
        gravity: gravity(scene),
        wind: winds(scene),
        coupled: scene.is_coupled(&body.name),
        threads: scene.threads,
    };
    refusals.finish()?;
    let left_out = LeftOut {
        what: format!("the air around `{}`: it does not flow, so that nothing is entrained", body.name),
        why: "`method = \"positions\"` has the particles of the smoke alone, as the second seed does".to_owned(),
        indicator: None,
        limit: None,
        saved: "a grid".to_owned(),
    };
    Ok((Cloud { fixed, x: start, v, beads: Vec::new(), pool: None }, vec![left_out]))
}

/// Densities over that at rest of particles at the start, at least one. Particles of a capture are no lattice: what is
/// crowded there would be thrown apart by the first substep.
fn begun(kernel: &Kernel, start: &[Vec3], solids: Vec<Solid>) -> Vec<f64> {
    let mut walls = Walls::new(solids);
    walls.find(kernel, start, false);
    let pairs = Pairs::new(start, kernel.reach, false);
    let (pass, mut densities) = (Pass { kernel, pairs: &pairs, walls: &walls, parallel: false }, Vec::new());
    pass.densities(start, &vec![[0.0; 3]; start.len()], 0.0, &mut densities);
    densities.into_iter().map(|d| d.max(1.0)).collect()
}

/// Static colliders, and the closed sides of a domain that is given.
fn walls(scene: &SolverScene, body: &Body, params: &Params, spacing: f64, refusals: &mut Refusals) -> Vec<Solid> {
    let fixed = |(shape, pose): (Shape, _)| Solid::Fixed(Placed::at(shape, &pose));
    let mut walls: Vec<_> = statics(scene, body, spacing, refusals).into_iter().map(fixed).collect();
    for (ends, inside) in params.domain.iter().flat_map(|[low, high]| [(low, 1.0), (high, -1.0)]) {
        let closed = (0..3).filter(|&k| !params.open[k][usize::from(inside < 0.0)]);
        walls.extend(closed.map(|k| Solid::Side(k, ends[k], inside)));
    }
    walls
}
