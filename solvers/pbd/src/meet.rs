//! Contact and motion of one substep.

use cosplat_core::boundary::{Vec3, add, scale};
use cosplat_core::distance::Placed;

use crate::bond;
use crate::contact::{Others, earn, settle};
use crate::course::{Course, Desk};
use crate::cover::Cover;
use crate::near::{Speeds, radius};
use crate::pieces::Search;
use crate::regions::Regions;
use crate::scout::Scout;
use crate::sim::Sim;
use crate::sweep::each;

/// Most parts of a substep in which contact is looked at.
const MOST_PARTS: f64 = 16.0;

impl Sim {
    /// Contact and motion of a substep, and the work of what partners and actions gave in it, where the velocities at its
    /// start were `start` \[m/s\].
    pub(crate) fn touch_and_move(
        &mut self,
        course: &mut Course,
        desks: &mut [Desk],
        mut start: Vec<Vec3>,
        kicks: &[(&[Vec3], f64)],
        (t, h): (f64, f64),
    ) {
        let parts = self.parts(course, h);
        for i in 0..parts {
            let part = h / f64::from(parts);
            self.meet(course, desks, &start, (t + f64::from(i) * part, part));
            if i == 0 {
                let blocks = self.vertices.chunks(self.size).zip(start.chunks(self.size));
                let work: Vec<_> = blocks.zip(desks.iter_mut()).collect();
                each(self.setting.parallel, work, |b, ((vertices, start), desk)| {
                    let own = kicks.iter().map(|&(impulses, share)| (&impulses[b * self.size..], share));
                    desk.earn(vertices, start, own);
                });
            }
            self.drift(course, part);
            start.iter_mut().zip(&self.vertices).for_each(|(start, v)| *start = v.u);
        }
    }

    /// Parts of a substep in which contact is looked at: cloth moves less than its thickness relative to other cloth in
    /// each, and less than half of both thicknesses relative to samples, so that nothing passes unseen. Shorter substeps
    /// instead would make what a sweep leaves stiffer, and give it energy.
    fn parts(&self, course: &mut Course, h: f64) -> u32 {
        let thickness = self.setting.thickness;
        let mut wanted: f64 = 1.0;
        if !self.mesh.friction.is_empty() {
            wanted = h * self.speeds(course).own / thickness;
        }
        for swarm in &course.swarms {
            let closing = swarm.fastest.map_or(0.0, |theirs| self.fastest() + theirs);
            wanted = wanted.max(h * closing / swarm.thinnest(0.5 * thickness));
        }
        let wanted = wanted.ceil();
        course.books.too_fast += u64::from(wanted > MOST_PARTS);
        wanted.clamp(1.0, MOST_PARTS) as u32
    }

    /// Moves everything for `h` \[s\].
    fn drift(&mut self, course: &mut Course, h: f64) {
        let speeds = self.speeds(course);
        course.near.age(self, speeds, h);
        for vertex in &mut self.vertices {
            vertex.x = add(vertex.x, scale(vertex.u, h));
        }
        course.proxies.iter_mut().for_each(|p| p.drift(h));
        course.swarms.iter_mut().for_each(|s| s.drift(h));
    }

    /// Contact of one substep, or of a part of it, at whose start the velocities were `start` \[m/s\].
    fn meet(&mut self, course: &mut Course, desks: &mut [Desk], start: &[Vec3], (t, h): (f64, f64)) {
        let setting = &self.setting;
        course.proxies.iter_mut().for_each(|p| p.push(h));
        for (swarm, meeting) in course.swarms.iter_mut().zip(&course.meetings) {
            swarm.at(t);
            let cover = Cover::new(&self.mesh, &self.vertices, meeting.triangles.clone(), setting.parallel);
            swarm.look(&cover, [0.5 * setting.thickness, setting.shortest], setting.parallel);
        }
        let alone = setting.walls.is_empty() && course.proxies.is_empty() && course.swarms.is_empty();
        if alone && self.mesh.friction.is_empty() {
            return;
        }
        let placed: Vec<Placed> =
            course.proxies.iter().zip(&setting.partners).map(|(p, partner)| p.placed(&partner.shape)).collect();
        let speeds = self.speeds(course);
        let mut near = std::mem::take(&mut course.near);
        near.renew(self, &placed, speeds, h);
        let pairs = near.own.pairs(&self.pieces(), h);
        let scout = Scout { setting, course: &*course, placed: &placed, owner: &self.owner, h };
        let mut between = Vec::new();
        scout.spots(near.spots(), &self.vertices, &mut between);
        let mut busy = vec![false; self.vertices.len()];
        between.iter().flat_map(|t| t.place.parts()).for_each(|(i, _)| busy[i] = true);
        pairs.iter().flat_map(|p| p.ends).for_each(|i| busy[i as usize] = true);
        let work: Vec<_> = self.vertices.chunks_mut(self.size).zip(desks.iter_mut()).collect();
        each(setting.parallel, work, |b, (vertices, desk)| scout.block(b * self.size, vertices, desk, &busy));
        // Vertices last: what they touch then holds exactly, whatever is left of the turns before.
        let mut touches = between;
        touches.extend(desks.iter().flat_map(|d| d.touches.iter().copied()));
        course.near = near;
        course.books.touches += (touches.len() + pairs.len()) as u64;
        let mut bonds = std::mem::take(&mut course.bonds);
        let mut others = Others {
            proxies: &mut course.proxies,
            swarms: &mut course.swarms,
            on_own: &mut course.books.swarms,
            external: &mut course.books.held,
        };
        bond::begin(&mut bonds);
        let touched = touches.iter().flat_map(|t| t.place.parts()).map(|(i, _)| i);
        let shared = touched.chain(bonds.iter().map(|b| b.vertex as usize));
        let mut regions = Regions::new(pairs, &self.vertices, shared, h);
        for _ in 0..setting.turns {
            regions.solve(&mut self.vertices, setting.parallel, others.external);
            settle(&mut self.vertices, &self.owner, &mut touches, &mut others, h);
            bond::hold(&mut bonds, &mut self.vertices, &self.owner, &mut others, h);
        }
        regions.finish(&mut self.vertices, others.external);
        earn(&self.vertices, start, &self.owner, &touches, &mut others);
        bond::earn(&bonds, &self.vertices, start, &self.owner, &mut others);
        course.bonds = bonds;
    }

    /// All cloths as pieces that may touch.
    pub(crate) fn pieces(&self) -> Search<'_> {
        Search {
            mesh: &self.mesh,
            vertices: &self.vertices,
            reach: 0.0,
            thickness: self.setting.thickness,
            parallel: self.setting.parallel,
        }
    }

    /// How fast things move.
    fn speeds(&self, course: &Course) -> Speeds {
        Speeds::new(&self.vertices, &course.proxies, self.setting.partners.iter().map(|p| radius(&p.shape)))
    }
}
