//! Boundary particles near the liquid: where they are, what the liquid sees there, and what it does to them.
//!
//! Pressure and velocity are extrapolated from the liquid (Adami, Hu and Adams 2012, eqs. 23 and 27), without the
//! wall's own acceleration, which would make the motion of a light body depend on its own last acceleration. A liquid
//! never pulls at a wall. Their mirrored velocity, `v_w - (⟨v⟩ - v_w)`, is taken times depth over the mean height of what was
//! averaged, so that a flow that is linear in the height has no speed at the surface (as Morris, Fox and Zhu 1997, §3.4, do
//! pair by pair). At a static wall that slips they have the mean velocity along it, and that towards it mirrored: liquid
//! beside it would else lack the pairs beyond the wall, and shear more easily.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, cross, dot, norm, scale, sub};
use cosplat_core::distance::SignedDistance;
use fearless_simd::{Level, Simd, dispatch, f64x4, prelude::*};

use crate::force::drag;
use crate::grid::{Grid, Sorted};
use crate::lanes::{Four, LANES, Pack, accumulate, gather, groups, total, zero, zeros};
use crate::liquids::{Liquids, Means};
use crate::model::{Face, Model, Solid};
use crate::near::{CHUNK, Lists, for_chunks};
use crate::overlap::once;
use crate::partner::Partners;
use crate::shell::below_plane;
use crate::store::Store;

/// Mean height of the liquid near a boundary particle that is believed, in spacings, and largest factor of its velocity.
const LOWEST: f64 = 0.25;
const STEEPEST: f64 = 4.0;

/// Share of the viscosity with which boundary particles of a static wall that slips rub. A mean over a kernel adds as much
/// of the velocity's curvature again as lies between the pairs: by sums over the lattice, with 0.49 of the viscosity liquid
/// beside such a wall resists shear along it as it does elsewhere; without them it has the 0.83 of it in the first row.
const SLIDING: f64 = 0.49;

/// A boundary particle as one body sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Face, and place among the solid's particles or samples.
    pub(crate) face: u32,
    pub(crate) index: u32,
    /// Position \[m\], velocity \[m/s\], volume \[m³\] and depth below its surface \[m\].
    pub(crate) x: Vec3,
    pub(crate) v: Vec3,
    pub(crate) volume: f64,
    pub(crate) depth: f64,
    /// Outward normal of a static solid that slips and into which a partner reaches; else nothing.
    normal: Vec3,
    /// Impulse on the liquid \[N s\], the part of it that is friction \[N s\] and its work \[J\] in the last substep.
    pub(crate) impulse: Vec3,
    pub(crate) rubbed: Vec3,
    pub(crate) work: f64,
}

/// What walls do to a liquid particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pressed {
    /// Forces of static walls and of partners \[N\], and the part of both that is viscous.
    pub(crate) statics: Vec3,
    pub(crate) partners: Vec3,
    pub(crate) rubbed: Vec3,
    /// Power lost to the viscosity \[W\].
    pub(crate) lost: f64,
}

/// All that are near.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    /// The particles.
    pub(crate) pieces: Vec<Piece>,
    /// The same with the pressure and the velocity that viscosity sees, and with their own velocity; then nobody.
    pub(crate) seen: Vec<Pack>,
    moving: Vec<Pack>,
    /// The latter, but with the liquid's velocity along static walls that slip; empty where no partner reaches into one.
    sliding: Vec<Pack>,
    /// Viscosity at each \[Pa s\], 0 where the liquid slips along a partner; and whether it belongs to a partner, as 1.
    pub(crate) rubs: Vec<[f64; 2]>,
    /// Implicit viscosity at each \[Pa s\], and how much more a mirrored velocity makes of the own one's share.
    pub(crate) grip: Vec<[f64; 2]>,
    /// Liquid particles near each.
    pub(crate) lists: Lists,
    /// Boundary particles near each liquid particle: ends and numbers.
    first: Vec<u32>,
    near: Vec<u32>,
}

impl Walls {
    /// Boundary particles near a liquid particle.
    #[inline]
    pub(crate) fn near(&self, i: usize) -> &[u32] {
        &self.near[self.first[i] as usize..self.first[i + 1] as usize]
    }

    /// Finds all that were closer than `reach` to the liquid when everything was where lists are made.
    pub(crate) fn find(
        &mut self,
        model: &Model,
        store: &Store,
        (grid, sorted): (&Grid, &Sorted),
        partners: &Partners,
        reach: f64,
        parallel: bool,
    ) {
        let x = store.listed.those();
        let mut places = store.listed.partners.iter();
        let (mut all, mut rigid) = (Vec::new(), Vec::new());
        for (f, face) in model.faces.iter().enumerate() {
            let mut add = |index: usize, x: Vec3, volume: f64, depth: f64| {
                if !grid.occupied(x, reach) {
                    return;
                }
                let (zero, face) = ([0.0; 3], f as u32);
                let index = index as u32;
                let (normal, impulse, rubbed) = (zero, zero, zero);
                let made = Piece { face, index, x, v: zero, volume, depth, normal, impulse, rubbed, work: 0.0 };
                all.push(made);
            };
            match &model.solids[face.solid] {
                Solid::Plane(frame, shape) => {
                    let own = store.id.iter().zip(x).filter(|(id, _)| model.body[**id as usize] == face.body as u32);
                    let local = own.map(|(_, &x)| frame.into_local(x));
                    for (x, volume, depth) in below_plane(shape, local, reach, model.spacing) {
                        let x = frame.out(x);
                        if !model.taken(x, face.solid) {
                            add(0, x, volume, depth);
                        }
                    }
                }
                Solid::Fixed(pieces) => pieces.iter().for_each(|&(x, volume, depth)| add(0, x, volume, depth)),
                Solid::Rigid(_, pieces) => {
                    if partners.proxy(face.solid).is_some() {
                        let each = pieces.iter().enumerate().zip(&mut places);
                        each.for_each(|((i, &(_, volume, depth)), &x)| {
                            rigid.push((face.body, x, volume));
                            add(i, x, volume, depth);
                        });
                    }
                }
                Solid::Sampled(_) => {
                    let Some(samples) = partners.samples(face.solid) else { continue };
                    let each = samples.pieces().zip(&mut places);
                    each.for_each(|((i, _, volume, depth), &x)| add(i, x, volume, depth));
                }
            }
        }
        let entered = once(model, &rigid, &mut all);
        let search = |b: usize, list: &mut Vec<u32>| {
            let body = model.faces[all[b].face as usize].body as u32;
            let end = list.len();
            grid.list(sorted, all[b].x, reach, u32::MAX, list);
            if model.liquids.len() > 1 {
                let of_body = |i: u32| model.body[store.id[i as usize] as usize] == body;
                let own: Vec<u32> = list.drain(end..).filter(|&i| of_body(i)).collect();
                list.extend(own);
            }
        };
        let mut found = Lists::default();
        found.make(all.len(), (LANES, store.len()), parallel, &search);
        let row = |b: usize| found.chunks()[b / CHUNK].row(b % CHUNK);
        let kept: Vec<usize> = (0..all.len()).filter(|&b| !row(b).is_empty()).collect();
        self.pieces = kept.iter().map(|&b| all[b]).collect();
        for piece in &mut self.pieces {
            let face = &model.faces[piece.face as usize];
            let slides = face.slips && entered[piece.face as usize];
            let known = model.statics.iter().find(|s| slides && s.0 == face.solid);
            piece.normal = known.map_or([0.0; 3], |(_, placed)| placed.distance(piece.x).1);
        }
        self.lists.make(kept.len(), (LANES, store.len()), parallel, &|k, list| list.extend_from_slice(row(kept[k])));
        (self.first, self.near) = self.lists.transposed(kept.len(), store.len());
        let rubs = self.pieces.iter().map(|piece| {
            let face = &model.faces[piece.face as usize];
            [friction(model, face), f64::from(u8::from(face.interface.is_some()))]
        });
        self.rubs = rubs.chain([[0.0; 2]]).collect();
        self.grip = vec![[0.0; 2]; kept.len() + 1];
        self.seen = vec![Pack::default(); kept.len() + 1];
        self.moving = self.seen.clone();
        let slides = self.pieces.iter().any(|piece| dot(piece.normal, piece.normal) > 0.0);
        self.sliding = if slides { self.seen.clone() } else { Vec::new() };
    }

    /// Puts each where its solid is, with its velocity.
    pub(crate) fn place(&mut self, model: &Model, partners: &Partners) {
        for piece in &mut self.pieces {
            let solid = model.faces[piece.face as usize].solid;
            match &model.solids[solid] {
                Solid::Plane(..) | Solid::Fixed(_) => {}
                Solid::Rigid(_, pieces) => {
                    let Some(proxy) = partners.proxy(solid) else { continue };
                    piece.x = proxy.frame.out(pieces[piece.index as usize].0);
                    piece.v = proxy.at(piece.x);
                }
                Solid::Sampled(_) => {
                    let Some(samples) = partners.samples(solid) else { continue };
                    (piece.x, piece.v) = samples.at(piece.index as usize);
                }
            }
        }
        self.refresh(model, partners);
    }

    /// Takes the velocities of rigid partners anew, after their impulses.
    pub(crate) fn refresh(&mut self, model: &Model, partners: &Partners) {
        for (piece, pack) in self.pieces.iter_mut().zip(&mut self.moving) {
            if let Some(proxy) = partners.proxy(model.faces[piece.face as usize].solid) {
                piece.v = proxy.at(piece.x);
            }
            *pack = Pack { x: piece.x, volume: piece.volume, v: piece.v, pressure: 0.0 };
        }
    }

    /// Whether some belong to static walls that slip and into which partners reach.
    pub(crate) fn slides(&self) -> bool {
        !self.sliding.is_empty()
    }

    /// Takes the liquid's mean velocity along static walls that slip for theirs, where partners reach into them.
    ///
    /// Beyond such a wall is a mirror image of the liquid. Along a wall that goes on, its velocity does not count: what comes
    /// nearer on one side goes away on the other. Where a wall ends at something that moves, as at a piston, it does.
    pub(crate) fn slide(&mut self, liquids: &Liquids<'_>) {
        let Self { pieces, lists, moving, sliding, .. } = self;
        let count = pieces.len();
        let mut nothing = vec![(); lists.chunks().len()];
        for_chunks(liquids.parallel, &mut sliding[..count], &mut nothing, &|c, sliding, ()| {
            for (k, sliding) in sliding.iter_mut().enumerate() {
                let (own, normal) = (moving[c * CHUNK + k], pieces[c * CHUNK + k].normal);
                *sliding = own;
                if dot(normal, normal) > 0.0 {
                    let near = lists.chunks()[c].row(k);
                    let Means { sum, velocity, .. } =
                        dispatch!(Level::new(), simd => liquids.means(simd, &own, [0.0; 3], near));
                    let mean = scale(velocity, 1.0 / sum.max(f64::MIN_POSITIVE));
                    sliding.v = sub(mean, scale(normal, dot(mean, normal)));
                }
            }
        });
    }

    /// Extrapolates pressure and velocity from the liquid.
    pub(crate) fn extrapolate(&mut self, liquids: &Liquids<'_>) {
        let model = liquids.model;
        let Self { pieces, lists, seen, grip, .. } = self;
        let count = pieces.len();
        let mut grips: Vec<&mut [[f64; 2]]> = grip[..count].chunks_mut(CHUNK).collect();
        for_chunks(liquids.parallel, &mut seen[..count], &mut grips, &|c, seen, grip| {
            for (k, seen) in seen.iter_mut().enumerate() {
                let piece = &pieces[c * CHUNK + k];
                let face = &model.faces[piece.face as usize];
                let g = scale(liquids.gravity[face.body], model.liquids[face.body].rho);
                let own = Pack { x: piece.x, volume: piece.volume, v: [0.0; 3], pressure: 0.0 };
                let near = lists.chunks()[c].row(k);
                let Means { sum, pressure, velocity, way } =
                    dispatch!(Level::new(), simd => liquids.means(simd, &own, g, near));
                let one = if sum > 0.0 { 1.0 / sum } else { 0.0 };
                // Beside a flat surface the mean way to the liquid is along its normal.
                let height = (norm(way) * one - piece.depth).max(LOWEST * model.spacing);
                let times = (piece.depth / height).min(STEEPEST);
                let mean = scale(velocity, one);
                let v = if face.slips {
                    let along = dot(mean, way) / dot(way, way).max(f64::MIN_POSITIVE);
                    sub(mean, scale(way, along * (1.0 + times)))
                } else {
                    sub(scale(piece.v, 1.0 + times), scale(mean, times))
                };
                let more = if face.slips { 0.0 } else { 1.0 + times };
                grip[k] = [more * model.liquids[face.body].thickness, more];
                *seen = Pack { v, pressure: (pressure * one).max(0.0), ..own };
            }
        });
    }

    /// What walls do to a liquid particle near the boundary particles `near`.
    ///
    /// Each force acts along the line between the two, so that moments balance.
    #[inline(always)]
    pub(crate) fn press<S: Simd>(&self, simd: S, model: &Model, own: &Pack, near: &[u32]) -> Pressed {
        let (mut all, mut partners, mut rubbed) = (zeros(simd), zeros(simd), zeros(simd));
        let mut lost = zero(simd);
        for b in groups(near) {
            let others = Four::new(simd, own, &self.seen, b);
            let rubs = {
                let rub = |k: usize| self.rubs[b[k] as usize];
                [rub(0), rub(1), rub(2), rub(3)]
            };
            let viscosity = f64x4::load_array(simd, [rubs[0][0], rubs[1][0], rubs[2][0], rubs[3][0]]);
            let slope = model.kernel.slopes(others.r) * (others.volume * own.volume);
            let shear = drag(&model.kernel, viscosity, others.approach(), others.square);
            let along = slope * (shear - own.pressure - others.pressure);
            let of_partner = f64x4::load_array(simd, [rubs[0][1], rubs[1][1], rubs[2][1], rubs[3][1]]);
            accumulate(&mut all, &others.apart, along);
            accumulate(&mut partners, &others.apart, along * of_partner);
            if rubs.iter().any(|r| r[0] > 0.0) {
                let rub = slope * shear;
                accumulate(&mut rubbed, &others.apart, rub);
                lost -= rub * Four::new(simd, own, &self.moving, b).approach();
            }
        }
        let (all, partners) = (gather(all), gather(partners));
        Pressed { statics: sub(all, partners), partners, rubbed: gather(rubbed), lost: total(lost) }
    }

    /// Implicit viscosities at four, times how much more a particle's own velocity, mirrored at the surface, makes of it.
    #[inline(always)]
    pub(crate) fn grips<S: Simd>(&self, simd: S, b: &[u32; LANES]) -> f64x4<S> {
        let of = |k: usize| self.grip[b[k] as usize][0];
        f64x4::load_array(simd, [of(0), of(1), of(2), of(3)])
    }

    /// Boundary particles press no longer, but rub.
    pub(crate) fn let_go(&mut self) {
        self.seen.iter_mut().for_each(|seen| seen.pressure = 0.0);
    }

    /// The packs of boundary particles with their own velocities; the last one is nobody.
    pub(crate) fn packs(&self) -> &[Pack] {
        &self.moving
    }

    /// The same, with the liquid's velocity along static walls that slip.
    pub(crate) fn sliding(&self) -> &[Pack] {
        if self.sliding.is_empty() { &self.moving } else { &self.sliding }
    }

    /// Liquid particles near each boundary particle.
    pub(crate) fn lists(&self) -> &Lists {
        &self.lists
    }

    /// Whether a boundary particle belongs to a partner.
    pub(crate) fn of_partner(&self, piece: usize) -> bool {
        self.rubs[piece][1] > 0.5
    }

    /// Impulses of partners in one substep on the liquid, whose particles have those accelerations \[m/s²\].
    pub(crate) fn impulses(&mut self, liquids: &Liquids<'_>, acceleration: &[Vec3], dt: f64) {
        let Self { pieces, lists, seen, rubs, .. } = self;
        let mut nothing = vec![(); lists.chunks().len()];
        for_chunks(liquids.parallel, pieces, &mut nothing, &|c, pieces, ()| {
            for (k, piece) in pieces.iter_mut().enumerate() {
                let (own, [viscosity, partner]) = (&seen[c * CHUNK + k], rubs[c * CHUNK + k]);
                if partner > 0.5 {
                    let (near, liquid) = (lists.chunks()[c].row(k), (acceleration, dt));
                    dispatch!(Level::new(), simd => liquids.push(simd, piece, own, viscosity, near, liquid));
                }
            }
        });
    }
}

/// Viscosity with which the boundary particles of a face rub, where nothing eases it \[Pa s\].
pub(crate) fn friction(model: &Model, face: &Face) -> f64 {
    let share = match (face.slips, face.interface) {
        (true, Some(_)) => 0.0,
        (true, None) => SLIDING,
        (false, _) => 1.0,
    };
    share * model.liquids[face.body].viscosity
}

/// Impulse on a solid and its moment about `centre`, of one boundary particle.
pub(crate) fn reaction(piece: &Piece, centre: Vec3) -> (Vec3, Vec3) {
    let impulse = scale(piece.impulse, -1.0);
    (impulse, cross(sub(piece.x, centre), impulse))
}

/// Size of an impulse \[N s\].
pub(crate) fn size(piece: &Piece) -> f64 {
    norm(piece.impulse)
}
