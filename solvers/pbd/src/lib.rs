//! Cloth by extended position-based dynamics (XPBD) in small substeps, in double precision.
//!
//! One substep of length `h`:
//! 1. outside influences and partners' impulses change velocities (air: `air`);
//! 2. edges (`stretch`) and hinges (`bend`) are solved once each, Gauss–Seidel by blocks of vertices (`vertex`), four at a time
//!    (`lanes`);
//! 3. vertices, and points of edges and faces that come nearer (`search`), meet walls and stand-ins of rigid partners
//!    (`proxy`), samples of soft partners meet what of the cloth is nearest to them (`samples`, `cover`), its rim keeps out
//!    from between neighbouring samples (`seam`), and cloth meets cloth (`own`, `watch`, `couple`, `pieces`, `tiles`, `pair`,
//!    `regions`), with Coulomb friction (`contact`);
//! 4. positions move by `h u`.
//!
//! Corrections of positions are kept as impulses `m Δx/h` at the positions where the substep began, and no velocity is
//! ever a difference of positions. Linear and angular momentum therefore close to rounding, and every impulse of a wall,
//! a pin or a partner is known exactly. Double precision is needed as well: with `h = 1e-4 s` a step changes positions by
//! `g h² = 1e-7 m`, which is lost in a single-precision coordinate of 1 m.
//!
//! **Compliance.** In mode `physical` compliances are those of the material, at rest and for any substep, up to the
//! error of a single sweep: a link that carries `n` others is softer by `n g h²`, a compliance of about `h²/m` a link,
//! and a hinge softer by about `h²/(m l²)`. Less than that cannot be told from zero; halving `max_substep_s` quarters
//! it. Mode `genesis` scales corrections by the published relaxation factors instead, at the published 1 ms and 4
//! iterations: stiffness then depends on both.
//!
//! **Stability.** Along an edge and about a hinge the solve is implicit for any stiffness. Across an edge it is explicit,
//! the price of exact angular momentum: a thread of spacing `l` under tension `T` needs `h < √(m l/T)`, 3 ms for a metre of
//! hanging silk. Vertices and partners also move at most 0.3 of the shortest edge in a substep, except in mode `genesis`,
//! where a shorter substep would be a stiffer cloth.
//!
//! **Bodies** are planes with a size (a sheet of squares with alternating diagonals) and triangle meshes, open or not.
//! A vertex has the mass of a third of its triangles. Vertices near `params.pins` are fixed to the world. Partners and
//! pictures get the vertices in the order of the source: of a sheet row by row, x running fastest.
//!
//! **Contact** keeps surfaces half a thickness apart from solids, and middle surfaces of cloth a whole one. In a substep
//! cloth moves less than its thickness relative to other cloth; where it is faster, contact is looked at in up to 16
//! parts of it, and substeps in which that is not enough are counted in the report. What is nearer than twice the
//! thickness at rest is left alone. Samples of soft partners are beads, each of which stays on the side of the cloth on which
//! it came near (`side`), so that cloth lies on leaves, which have no inside; their normals are not used. What a partner
//! overruns of cloth within a window, samples make up for in the next (`behind`); how far it was is in the report.
//! Self-collision costs a quarter as much as all the rest where cloth hangs, and twice as much where it is crumpled;
//! `self_collision = false` leaves it out by name.
//!
//! **Energy** that is stored is half of each constraint times the force that a substep would give at rest, so that what is
//! dissipated is what sweeps, contact and damping take. It is an estimate in mode `genesis`, and where a substep is
//! shortened by speed.
//!
//! **Held vertices** are named by points of the world at t = 0: `params.pins` are fixed, `params.pulls` move with a given
//! velocity until a given time, which is work of the world, and `params.bonds` attach vertices to a rigid partner or to
//! the samples of a soft one (`bond`), with the reactions in the impulses that cross.
//!
//! Not here yet: tearing, moving walls, restitution, the `genesis` contact law, links and joints.

mod air;
mod behind;
mod bend;
mod bond;
mod cells;
mod closest;
mod contact;
mod couple;
mod course;
mod cover;
mod lanes;
mod list;
mod meet;
mod model;
mod near;
mod own;
mod pair;
mod params;
mod pieces;
mod place;
mod plugin;
mod probe;
mod proxy;
mod pull;
mod read;
mod read_held;
mod read_partners;
mod regions;
mod report;
mod rim;
mod samples;
mod scout;
mod seam;
mod search;
mod sheet;
mod shown;
mod side;
mod sim;
mod stored;
mod stretch;
mod sweep;
mod tally;
mod tiles;
mod vertex;
mod watch;

pub use plugin::Pbd;
