//! Meshes as Gaussians that follow their vertices: one a vertex, or samples of the surface that its triangles hold.

use cosplat_core::boundary::Vec3;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::fabric::shaded;
use super::light::{Light, display_of_linear, linear_of_display};
use super::{Fabric, Sample, surfels};
use crate::bind::{BindError, Binding, Frame, Local, Particles, Triangles};
use crate::output::OutputFrame;
use crate::skin::{Limits, skin};
use crate::splats::{Splats, dc_of_colour};
use crate::stage::single;

/// A surfel of a triangle becomes at most this many times as long as it was.
const STRETCH: f64 = 4.0;
/// Particles this near to the vertices, in units of the mean edge, are the vertices.
const SAME: f64 = 1e-3;

/// A mesh as it is drawn.
#[derive(Clone, Debug)]
pub struct MeshSurfels {
    /// Vertices in the body's frame \[m\].
    rest_m: Vec<Vec3>,
    fabric: Fabric,
    /// What the triangles hold; without it there is one surfel a vertex.
    held: Option<Held>,
    /// Whether it is seen from one side only.
    is_closed: bool,
}

/// Gaussians that triangles hold.
#[derive(Clone, Debug)]
struct Held {
    /// In the body's frame.
    splats: Splats,
    binding: Binding,
    /// Samples of the surface that they are, which are lit; none of a capture, in whose colours its light is.
    samples: Vec<Sample>,
}

/// The vertices of a mesh during a run, in the world.
#[derive(Clone, Debug)]
pub struct Worn {
    /// At t = 0 \[m\].
    rest_m: Vec<Vec3>,
    /// Which particles they follow, and these at t = 0; without it the particles are the vertices.
    follows: Option<(Binding, Splats, Vec<[f32; 3]>)>,
}

impl MeshSurfels {
    /// One topological surfel a vertex (Li et al. 2025, `WonderPlay`). Vertices in the body's frame \[m\]; the inside of a
    /// closed mesh is not lit.
    ///
    /// # Errors
    /// Not as many colours as vertices, a triangle without a vertex, or a position that is not finite.
    pub fn on_vertices(vertices_m: Vec<Vec3>, fabric: Fabric, is_closed: bool) -> Result<MeshSurfels, BindError> {
        // All that can be wrong with a mesh is wrong with it at rest too.
        let mesh = MeshSurfels { rest_m: vertices_m, fabric, held: None, is_closed };
        mesh.drawn(&mesh.rest_m, &Light::default(), &OutputFrame::world())?;
        Ok(mesh)
    }

    /// Samples of the surface in the body's frame in place of vertices, each at fixed barycentric coordinates of the
    /// nearest triangle and a fixed distance from it.
    ///
    /// # Errors
    /// There is no triangle, or a position is not finite.
    pub fn on_triangles(self, samples: Vec<Sample>) -> Result<MeshSurfels, BindError> {
        self.hold(surfels(&samples), samples)
    }

    /// The Gaussians of a capture in place of vertices, in the body's frame \[m\], each at fixed barycentric coordinates of
    /// the nearest triangle and a fixed distance from it; their colours turn with it.
    ///
    /// # Errors
    /// There is no triangle, or a position is not finite.
    pub fn wearing(self, capture: Splats) -> Result<MeshSurfels, BindError> {
        self.hold(capture, Vec::new())
    }

    fn hold(self, splats: Splats, samples: Vec<Sample>) -> Result<MeshSurfels, BindError> {
        let binding = Binding::triangles(&splats, &single(&self.rest_m), &self.fabric.triangles)?;
        Ok(MeshSurfels { held: Some(Held { splats, binding, samples }), ..self })
    }

    /// Gaussians that are drawn.
    pub fn gaussians(&self) -> usize {
        self.held.as_ref().map_or(self.rest_m.len(), |held| held.splats.len())
    }

    /// Vertices in the body's frame \[m\].
    pub fn vertices_m(&self) -> &[Vec3] {
        &self.rest_m
    }

    /// Vertices in the world \[m\], the body at a pose.
    pub fn posed(&self, pose: &Frame) -> Vec<Vec3> {
        self.rest_m.iter().map(|v| pose.point(Vector3::from(*v)).into()).collect()
    }

    /// Ties the vertices to what a solver shows at t = 0 \[m\], the body at `pose`: particles that are the vertices, as
    /// those of cloth, or else any, of which each vertex follows so many affinely.
    ///
    /// # Errors
    /// There is no particle, or a position is not finite.
    pub fn worn(&self, pose: &Frame, particles_m: &[Vec3], neighbours: usize) -> Result<Worn, BindError> {
        let rest_m = self.posed(pose);
        let near = |(p, q): (&Vec3, &Vec3)| (Vector3::from(*p) - Vector3::from(*q)).norm() <= SAME * self.edge();
        if rest_m.len() == particles_m.len() && rest_m.iter().zip(particles_m).all(near) {
            return Ok(Worn { rest_m: particles_m.to_vec(), follows: None });
        }
        let vertices = Splats { positions: single(&rest_m), ..Splats::default() };
        let particles = single(particles_m);
        let binding = Binding::affine(&vertices, &particles, neighbours)?;
        Ok(Worn { rest_m, follows: Some((binding, vertices, particles)) })
    }

    /// The Gaussians with the vertices at these places in the world \[m\].
    ///
    /// # Errors
    /// Another number of vertices.
    pub fn drawn(&self, vertices_m: &[Vec3], light: &Light, frame: &OutputFrame) -> Result<Splats, BindError> {
        let share = |normal: &Vector3<f64>| {
            let cosine = normal.dot(&light.direction());
            light.share(if self.is_closed { cosine } else { cosine.abs() })
        };
        let Some(Held { splats: still, binding, samples }) = &self.held else {
            return shaded(vertices_m, &self.fabric, &share, frame);
        };
        let (rest, now) = (single(&self.rest_m), single(vertices_m));
        let particles = Particles { rest: &rest, now: &now, gradients: None };
        let local = binding.locals(still, &particles)?;
        let mut splats = Splats::default();
        skin(still, &*local, Limits { stretch: Some(STRETCH), ..Limits::default() }, &mut splats);
        let colours = samples.par_iter().enumerate().map(|(i, sample)| {
            // Its gradient takes the normal of the triangle to the normal.
            let Local { gradient, .. } = local(i);
            let normal = (gradient * Vector3::from(sample.normal.map(f64::from))).try_normalize(0.0);
            let share = share(&normal.filter(|n| n.iter().all(|c| c.is_finite())).unwrap_or_else(Vector3::z));
            sample.colour.map(|c| dc_of_colour(display_of_linear(linear_of_display(f64::from(c)) * share)))
        });
        if !samples.is_empty() {
            splats.sh_dc = colours.collect();
        }
        frame.from_world.apply(&mut splats, frame.axes);
        Ok(splats)
    }

    /// Mean length of the edges \[m\].
    fn edge(&self) -> f64 {
        let place = |i: u32| Vector3::from(self.rest_m[i as usize]);
        let edges = self.fabric.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let sum: f64 = edges.map(|(a, b)| (place(a) - place(b)).norm()).sum();
        sum / (3 * self.fabric.triangles.len()).max(1) as f64
    }
}

impl Worn {
    /// The vertices in the world \[m\], the particles at these places \[m\].
    ///
    /// # Errors
    /// Another number of particles than at t = 0.
    pub fn vertices(&self, particles_m: &[Vec3]) -> Result<Vec<Vec3>, BindError> {
        let Some((binding, vertices, rest)) = &self.follows else {
            let (bound, has) = (self.rest_m.len(), particles_m.len());
            let same = (bound == has).then(|| particles_m.to_vec());
            return same.ok_or(BindError::Length("particles", bound, has));
        };
        let now = single(particles_m);
        let particles = Particles { rest, now: &now, gradients: None };
        let local = binding.locals(vertices, &particles)?;
        let moved = |(i, v): (usize, &Vec3)| <Vec3>::from(Vector3::from(*v) + local(i).displacement);
        Ok(self.rest_m.par_iter().enumerate().map(moved).collect())
    }
}

/// Gives samples the colours of the vertices of their triangle, linear red, green, blue from 0 to 1, in between by
/// barycentric coordinates.
///
/// # Errors
/// There is no triangle, or a position is not finite.
pub fn colour_by_vertices(
    samples: &mut [Sample],
    vertices_m: &[Vec3],
    triangles: &[[u32; 3]],
    linear: &[[f32; 3]],
) -> Result<(), BindError> {
    if linear.len() != vertices_m.len() {
        return Err(BindError::Length("vertices", vertices_m.len(), linear.len()));
    }
    let places: Vec<[f32; 3]> = samples.iter().map(|s| s.position).collect();
    let bound = Triangles::new(&places, &single(vertices_m), triangles)?;
    for (i, sample) in samples.iter_mut().enumerate() {
        let (corners, shares) = bound.place(i);
        let mean = |k: usize| {
            let sum: f64 = corners.iter().zip(shares).map(|(c, s)| s * f64::from(linear[*c as usize][k])).sum();
            display_of_linear(sum) as f32
        };
        sample.colour = [0, 1, 2].map(mean);
    }
    Ok(())
}
