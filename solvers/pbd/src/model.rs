//! What a scene becomes: cloths, interfaces, and what is left out.

use std::ops::Range;

use cosplat_core::boundary::Vec3;
use cosplat_core::plan::{InterfaceId, LeftOut};

use crate::bond::Bond;
use crate::contact::Surface;
use crate::sim::Sim;

/// One body.
#[derive(Clone, Debug)]
pub(crate) struct Cloth {
    pub(crate) name: String,
    /// Its vertices in memory.
    pub(crate) range: Range<usize>,
    /// Place in memory of each vertex, in the order of the source, counted from the first.
    pub(crate) places: Vec<u32>,
    /// Triangles, in the order of the source.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Whether partners see it.
    pub(crate) coupled: bool,
}

/// Part that this solver plays at an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Part {
    /// Takes impulses.
    Respond,
    /// Resolves contact with a rigid partner: its index.
    Proxy(usize),
    /// Resolves contact with samples.
    Samples(Surface),
}

/// An interface as this solver plays it.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    pub(crate) id: InterfaceId,
    pub(crate) body: usize,
    pub(crate) partner: String,
    pub(crate) part: Part,
}

/// A scene read.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) cloths: Vec<Cloth>,
    pub(crate) faces: Vec<Face>,
    pub(crate) bonds: Vec<Bond>,
    pub(crate) sim: Sim,
    /// Positions at t = 0, as in memory \[m\].
    pub(crate) start: Vec<Vec3>,
    pub(crate) left_out: Vec<LeftOut>,
    pub(crate) threads: usize,
}

impl Cloth {
    /// Vertices in memory, in the order of the source.
    pub(crate) fn order(&self) -> impl Iterator<Item = usize> {
        self.places.iter().map(|&place| self.range.start + place as usize)
    }
}
