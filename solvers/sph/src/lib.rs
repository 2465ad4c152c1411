//! Smoothed particle hydrodynamics (SPH): liquids against walls, rigid bodies and bodies that show samples. Pressure keeps
//! the volume (`pressure = "dfsph"`, see `incompressible`), or follows from the density (`"wcsph"`),
//! as it must beside partners that show samples; the default is the first where it can be (`params`), and is said.
//!
//! One weakly compressible substep:
//! 1. boundary particles of partners go where their solid is (`wall`, `partner`, `proxy`), densities follow from the
//!    velocities (`compress`), and boundary particles take pressure and velocity from the liquid around them (Adami et al. 2012);
//! 2. every particle sums the forces of its neighbours: pressure, viscosity, walls (`force`);
//! 3. boundary particles of partners sum what they did to the liquid: that is what crosses, with the other sign (`rub` says
//!    how much friction a light sample bears, and what it does);
//! 4. velocities change, and rigid stand-ins take their impulses: a symplectic step of first order;
//! 5. everything moves.
//!
//! Particles are physically sorted by cell (`grid`), and lists of neighbours (`near`) are kept until two may have come
//! closer by their skin. The places for which they were made are part of the state, so that a restored run has the same
//! lists. Work is shared out in chunks of fixed size, and every sum has a fixed order, so that the bytes do not depend on the number of threads.
//!
//! Every force acts along the line between two particles, so that linear and angular momentum are kept to rounding, and is
//! computed in double precision, four at a time (`lanes`): that makes the books exact. Rates of densities and the trials of
//! incompressible solutions, which need not balance, are summed in single precision (`single`). A sum over sixty neighbours is
//! bound by arithmetic, not by memory; it is compiled for each width of registers, with the same bytes in all.
//!
//! Density is a state that follows from continuity, with diffusion (δ-SPH); pressure is Tait's with exponent 7, or linear
//! (`state`), and never negative. Spray, a particle with few neighbours, forgets that it was rarefied. The kernel is
//! Wendland's C2 with a smoothing length of 1.2 spacings.
//!
//! A wall is continued below its surface by a lattice of boundary particles as deep as the kernel reaches (`shell`); a plane's
//! are made where the liquid is, a terrain's column by column. Where static solids overlap, one counts, those without slip
//! before others; where a rigid partner reaches into one, the partner (`overlap`). A partner that shows samples has one layer,
//! or two where its samples have volume and normals; samples farther apart than one and a half spacings are refused.
//!
//! Liquid enters and leaves through inflows and drains (`gates`).
//!
//! Spray that is thrown faster than sound is put aside (`aside`), up to a hundredth of a body, and counted.
//!
//! Viscosity is explicit, or implicit (`thick`) where it would bind the substep and no partner has friction. Surface
//! tension (`cohesion`) is left out where ρ g d²/σ > 10: it would hold not even one particle; elsewhere `dfsph` refuses it.
//!
//! A particle takes about 0.9 kB, and 1.4 kB where its pressure keeps the volume: 12 B of it for each of 56 neighbours, of which
//! a skin of lists adds some (`tests/memory.rs`). Boundary particles are beside that.
//!
//! Not here yet, and refused by name: moving static colliders, prescribed motion, impulses from others, bodies of different
//! spacing in one process, an incompressible liquid beside bodies that deform: however heavy one is, a sample of it is as
//! light as its layer, and is no unknown of the solution. A rough wall is one without slip; this is said in the plan.
//!
//! Known limits: pressures of single particles of an incompressible liquid scatter by some percent of the largest, their mean
//! does not; a lattice under pressure buckles, and its particles come to rest within seconds; particles under a
//! pressure p resist slow shear like a paste, by some 0.03 p, so that a viscous stress far below that is not felt (a close-packed
//! lattice buckles less and resists more); drops of few particles lock as
//! a solid does, and a lattice that is stretched to the half and the double takes more room; a gap that was left around a body
//! at the start stays and lifts it, and liquid that would start inside a soft capture or a cloth is not cut out; a box of 0.3 of
//! the water's density that is eight spacings wide floats 26 mm deep where Archimedes says 30, and 25 where pressures are solved
//! a hundred times more closely; walls that slip bear what lies within a quarter of a spacing of an edge at which a partner
//! ends; implicit viscosity lacks the pairs beyond walls that slip; one layer of samples holds a thin layer of liquid, not a
//! tank.

mod aside;
mod cohesion;
mod compress;
mod cut;
mod felt;
mod fill;
mod force;
mod frame;
mod gates;
mod grid;
mod incompressible;
mod kernel;
mod lanes;
mod liquids;
mod model;
mod near;
mod overlap;
mod pairs;
mod params;
mod partner;
mod plugin;
mod probe;
mod proxy;
mod read;
mod report;
mod rub;
mod shell;
mod sim;
mod single;
mod state;
mod store;
mod thick;
mod wall;

pub use plugin::Sph;
