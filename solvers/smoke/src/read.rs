//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::boundary::{Vec3, add, scale};
use cosplat_core::distance::{Placed, Shape};
use cosplat_core::plan::{BoundaryForm, LeftOut};
use cosplat_core::plugin::{Descriptor, PluginError, Refusals, SolverScene, ViewRole};
use cosplat_core::scene::{ActionKind, Body, Material, Pose};

use crate::fill::fill;
use crate::follow::{BLOCK, Part, Whole};
use crate::grid::{Grid, offset};
use crate::model::{During, Face, Model, Partner};
use crate::params::Params;
use crate::sides::sides;
use crate::solids::{Filled, HEAVIEST, Kind, inside};
use crate::step::{Scratch, begin};
use crate::store::Store;

/// Cells above which a domain is refused.
const MOST_CELLS: f64 = 3e7;
/// The seeds' substep \[s\], for which their viscosity, a share per step, is meant.
const SEED_STEP: f64 = 1e-3;
/// Share of smoke above which a cell belongs to the source of an inflow.
const SOURCE: f64 = 0.5;
/// Difference of density over that of air above which its effect on inertia, which is left out, matters.
const BOUSSINESQ: f64 = 0.2;

/// A model, its state at t = 0, working memory, and what was left out.
pub(crate) type Read = (Model, Store, Scratch, Vec<LeftOut>);

/// What a scene asks for, by either method.
pub(crate) struct Asked<'a> {
    pub(crate) body: &'a Body,
    pub(crate) params: Params,
    /// What cannot be done, so far.
    pub(crate) refusals: Refusals,
}

/// Reads what both methods read.
pub(crate) fn asked<'a>(scene: &'a SolverScene, descriptor: &Descriptor) -> Result<Asked<'a>, PluginError> {
    let mut refusals = Refusals::undeclared(descriptor, scene);
    let params = Params::read(scene)?;
    let [body] = scene.bodies.as_slice() else {
        refusals.push(format!("{} bodies in one process: one cloud has one gas around it", scene.bodies.len()));
        refusals.finish()?;
        return Err(Refusals::one("smoke", "a process without a body"));
    };
    if body.mass_kg.is_some() {
        refusals.push(format!("a mass beside the density of the material (body `{}`)", body.name));
    }
    Ok(Asked { body, params, refusals })
}

/// Reads a scene for the grid.
pub(crate) fn read(scene: &SolverScene, Asked { body, params, mut refusals }: Asked<'_>) -> Result<Read, PluginError> {
    let made = fill(scene, body).map_err(|why| refusals.push(why)).ok();
    let (grid, mut left_out) = match &made {
        Some((spacing, points, _)) => match domain(&params, body, *spacing, points) {
            Ok(grid) => (Some(grid), Vec::new()),
            Err(why) => {
                refusals.push(why);
                (None, Vec::new())
            }
        },
        None => (None, Vec::new()),
    };
    let (Some((spacing, points, volume)), Some(grid)) = (made, grid) else {
        refusals.finish()?;
        return Err(Refusals::one("smoke", "this body"));
    };
    let (warm, share) = gas(body, &params);
    let heavier = warm / params.air - 1.0;
    if heavier.abs() > BOUSSINESQ {
        left_out.push(LeftOut {
            what: format!("the inertia that `{}` lacks beside air", body.name),
            why: "its weight is that of its density, its inertia that of air (Boussinesq)".to_owned(),
            indicator: Some(heavier.abs()),
            limit: Some(BOUSSINESQ),
            saved: "a projection with one density".to_owned(),
        });
    }
    let start: Vec<Vec3> = points.iter().map(|&x| body.pose.apply(x)).collect();
    let winds = winds(scene);
    let all = winds.iter().fold([0.0; 3], |sum, w| add(sum, w.value));
    let mut model = Model {
        name: body.name.clone(),
        grid,
        sides: sides(params.open, all),
        params,
        // The share of the difference to its neighbours, one spacing away, that a particle loses in a step of the
        // seeds: diffusion by steps of that length, `ν = share d² / 6 Δt`.
        nu: params.viscosity + share * spacing * spacing / (6.0 * SEED_STEP),
        heavier,
        particle: [warm * volume, volume],
        start,
        fixed: Vec::new(),
        source: Vec::new(),
        part: Part::all(&grid),
        whole: Whole { grid, fixed: Vec::new(), source: Vec::new() },
        partners: partners(scene, &mut refusals, grid.h),
        gravity: gravity(scene),
        wind: winds,
        coupled: scene.is_coupled(&body.name),
        threads: scene.threads,
    };
    walls(scene, body, &mut model, &mut refusals);
    refusals.finish()?;
    let mut scratch = Scratch::new(&model.grid);
    let mut store = Store::new(&model.grid, scratch.pressures(), model.start.clone());
    settle(body, &mut model, &mut store);
    model.show(model.part);
    begin(&model, &mut store, &mut scratch);
    Ok((model, store, scratch, left_out))
}

/// Density of a body's smoke at its temperature \[kg/m³\], and its viscosity, a share per step.
pub(crate) fn gas(body: &Body, params: &Params) -> (f64, f64) {
    let (density, share) = match body.material {
        Material::Smoke { density_kg_m3, viscosity } => (density_kg_m3, viscosity),
        _ => (params.air, 0.0),
    };
    (density * params.ambient / params.temperature, share)
}

/// The grid of a body; `Err` in words.
fn domain(params: &Params, body: &Body, spacing: f64, points: &[Vec3]) -> Result<Grid, String> {
    let h = params.cell.unwrap_or(2.0 * spacing);
    let [low, high] = params.domain.unwrap_or_else(|| {
        let world = || points.iter().map(|&x| body.pose.apply(x));
        let low = world().fold([f64::INFINITY; 3], |m, x| [0, 1, 2].map(|k| m[k].min(x[k])));
        let high = world().fold([f64::NEG_INFINITY; 3], |m, x| [0, 1, 2].map(|k| m[k].max(x[k])));
        let size = [0, 1, 2].map(|k| high[k] - low[k] + spacing);
        [[0, 1, 2].map(|k| low[k] - size[k]), [0, 1, 2].map(|k| high[k] + size[k])]
    });
    // A hair less, so that a domain of whole blocks is not made larger by rounding.
    let block = BLOCK as f64;
    let blocks = [0, 1, 2].map(|k| ((high[k] - low[k]) / (block * h) - 1e-6).ceil().max(1.0));
    let cells = blocks.iter().map(|b| b * block).product::<f64>();
    if !(h > 0.0 && cells.is_finite() && cells <= MOST_CELLS) {
        return Err(format!(
            "a domain of {cells:.3e} cells of {h} m around body `{}`, more than {MOST_CELLS:.0e}; a coarser `cell` \
             helps",
            body.name
        ));
    }
    Ok(Grid::new(low, blocks.map(|b| b as usize * BLOCK), h))
}

pub(crate) fn partners(scene: &SolverScene, refusals: &mut Refusals, h: f64) -> Vec<Face> {
    let mut faces = Vec::new();
    for view in scene.interfaces.iter().filter(|v| v.role == ViewRole::ContactResolver) {
        let name = view.partner.clone();
        let partner = if view.partner_form == BoundaryForm::Proxy {
            let asset = scene.assets.get(&name).map(AsRef::as_ref);
            let Some(source) = &view.partner_source else {
                refusals.push(format!("rigid partners without a shape (`{name}`)"));
                continue;
            };
            match Shape::prepared(source, asset, true, h) {
                Ok(shape) => Partner::Rigid(shape),
                Err(why) => {
                    refusals.push(format!("`{name}` as a solid: {why}"));
                    continue;
                }
            }
        } else {
            Partner::Samples
        };
        faces.push(Face { interface: view.id, name, partner });
    }
    faces
}

fn during(scene: &SolverScene, body: &str, value: impl Fn(&ActionKind) -> Option<Vec3>) -> Vec<During> {
    let acts = scene.actions.iter().filter(|a| a.bodies.is_empty() || a.bodies.iter().any(|b| b == body));
    let one = |a: &cosplat_core::scene::Action| {
        let until = a.until_s.unwrap_or(f64::INFINITY);
        value(&a.kind).map(|value| During { value, from: a.from_s, until })
    };
    acts.filter_map(one).collect()
}

pub(crate) fn gravity(scene: &SolverScene) -> Vec<During> {
    let body = scene.bodies.first().map_or("", |b| b.name.as_str());
    during(scene, body, |kind| match kind {
        ActionKind::Gravity { acceleration_m_s2 } => Some(*acceleration_m_s2),
        _ => None,
    })
}

pub(crate) fn winds(scene: &SolverScene) -> Vec<During> {
    let body = scene.bodies.first().map_or("", |b| b.name.as_str());
    during(scene, body, |kind| match kind {
        ActionKind::Wind { velocity_m_s, .. } => Some(*velocity_m_s),
        _ => None,
    })
}

/// Static colliders that the body meets, and where they are; `h` \[m\] is how fine they have to be.
pub(crate) fn statics(scene: &SolverScene, body: &Body, h: f64, refusals: &mut Refusals) -> Vec<(Shape, Pose)> {
    let mut found = Vec::new();
    for wall in &scene.statics {
        let is_pair = |a: &str, b: &str| (a == body.name && b == wall.name) || (b == body.name && a == wall.name);
        if scene.pairs.iter().any(|p| is_pair(&p.a, &p.b) && !p.enabled) {
            continue;
        }
        if wall.motion.is_some() {
            refusals.push(format!("moving static colliders (`{}`)", wall.name));
        }
        let asset = scene.assets.get(&wall.name).map(AsRef::as_ref);
        match Shape::prepared(&wall.source, asset, false, h) {
            Ok(shape) => found.push((shape, wall.pose)),
            Err(why) => refusals.push(format!("`{}` as a solid: {why}", wall.name)),
        }
    }
    found
}

/// Static solids on the grid.
fn walls(scene: &SolverScene, body: &Body, model: &mut Model, refusals: &mut Refusals) {
    for (shape, pose) in statics(scene, body, model.grid.h, refusals) {
        let ball = crate::solids::radius(&shape).map(|r| (pose.position_m, r));
        let faces = inside(&model.grid, &Placed::at(shape, &pose), ball);
        model.whole.fixed.push(Filled { kind: Kind::Driven([0.0; 3]), faces, ratio: HEAVIEST, row: None });
    }
}

/// Puts the smoke and the velocities at t = 0 on the grid.
fn settle(body: &Body, model: &mut Model, store: &mut Store) {
    let grid = model.grid;
    let ambient = model.ambient(0.0);
    for (field, v) in store.u.iter_mut().zip(ambient) {
        field.fill(v);
    }
    let share = model.particle[1] / (grid.h * grid.h * grid.h);
    let count = model.start.len().max(1) as f64;
    let centre = scale(model.start.iter().fold([0.0; 3], |sum, &x| add(sum, x)), 1.0 / count);
    let mut filled = grid.faces();
    let mut carried = grid.faces();
    for &x in &model.start {
        for (at, weight) in grid.around(x, [0.5; 3]) {
            store.c[at] += weight * share;
        }
        let v = body.velocity.at(x, centre);
        for a in 0..3 {
            for (at, weight) in grid.around(x, offset(a)) {
                filled[a][at] += weight * share;
                carried[a][at] += weight * share * v[a];
            }
        }
    }
    for a in 0..3 {
        for ((u, filled), carried) in store.u[a].iter_mut().zip(&filled[a]).zip(&carried[a]) {
            *u += carried / filled.max(1.0);
        }
    }
    if model.params.rate > 0.0 {
        let cells =
            (0..grid.n[2]).flat_map(|z| (0..grid.n[1]).flat_map(move |y| (0..grid.n[0]).map(move |x| [x, y, z])));
        let cells = cells.map(|c| c.map(|i| i as isize));
        model.whole.source = cells.filter(|&cell| store.c[grid.at(cell)] > SOURCE).collect();
        if let Some(jet) = model.params.jet {
            let mut faces = Vec::new();
            for (a, filled) in filled.iter().enumerate() {
                crate::flux::visit(&grid, model.sides, a, |cell, at| {
                    if filled[at] > SOURCE {
                        faces.push((a, cell));
                    }
                });
            }
            model.whole.fixed.push(Filled { kind: Kind::Driven(jet), faces, ratio: HEAVIEST, row: None });
        }
    }
}
