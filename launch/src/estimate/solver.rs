//! What solvers counted of their own errors.

use std::collections::BTreeMap;

use super::{Estimate, estimate, percent};
use crate::folder::summary::Process;

/// Compression of a weakly compressible liquid: the square of a Mach number of a tenth (Monaghan 1994).
const COMPRESSION: f64 = 0.01;
/// Share of substeps in which contact may be left before it is settled: all, because what is left is solved in the next
/// substep. Where it spoils the exchange, its work shows it.
const UNSETTLED: f64 = 1.0;
/// Part of its length by which a thread may be off beyond its compliance: woven cloth gives some hundredths before its
/// threads are straight, so that a hundredth is not seen.
const STRETCH: f64 = 0.01;
/// How deep bodies may be inside each other \[m\]: what published stacks of rigid bodies are allowed.
const OVERLAP_M: f64 = 5e-3;
/// Stretch beyond which two neighbours of a solid are a cell of its grid apart, with two particles along a cell: it may
/// tear there, whatever its material is.
const STRETCHED: f64 = 2.0;
/// What a projection may leave of divergence, times a cell, over the largest speed: what a volume changes by in the time in
/// which smoke crosses a cell.
const DIVERGENCE: f64 = 1e-3;
/// Mean crowding of particles that keep their density: distances of neighbours are off by a third of it.
const CROWDING: f64 = 0.05;
/// How far a joint may be open \[m\]: as far as contact may set a body aside.
const GAP_M: f64 = ASIDE_M;
/// How far contact may set a rigid body aside in a substep \[m\]: the error that rapier allows itself.
const ASIDE_M: f64 = 1e-3;

/// What the counters of a process tell.
pub(super) fn estimates(process: &Process, counters: &BTreeMap<String, u64>) -> Vec<Estimate> {
    let counted = |name: &str| counters.get(name).copied().unwrap_or_default() as f64;
    let of = process.name.as_str();
    let found = [
        compression(of, 1e-6 * counted("largest-compression-1e-6")),
        unsettled(of, counted("contact-unsettled"), process.substeps as f64),
        stretch(of, 1e-6 * counted("largest-stretch-left-1e-6")),
        strain(of, 1e-6 * counted("largest-stretch-1e-6")),
        clamps(of, counted("stretch-clamps")),
        overlap(of, 1e-6 * counted("largest-overlap-1e-6-m")),
        aside(of, 1e-9 * counted("largest-correction-1e-9-m")),
        overrun(of, 1e-6 * counted("largest-overrun-1e-6-m")),
        gap(of, 1e-9 * counted("largest-gap-of-a-joint-1e-9-m")),
        gap(of, 1e-6 * counted("largest-gap-of-a-bond-1e-6-m")),
        divergence(of, 1e-6 * counted("largest-divergence-1e-6")),
        crowding(of, 1e-6 * counted("largest-mean-crowding-1e-6")),
    ];
    found.into_iter().flatten().collect()
}

fn compression(of: &str, value: f64) -> Option<Estimate> {
    let meaning =
        format!("the liquid is compressed by up to {}: volumes and levels are off by as much", percent(value));
    let remedy = "raise the material's `stiffness`: four times the stiffness quarters it, for twice the substeps";
    (value > 0.0).then(|| estimate("compression", of, [value, COMPRESSION], meaning, remedy))
}

fn unsettled(of: &str, times: f64, substeps: f64) -> Option<Estimate> {
    if times == 0.0 || substeps == 0.0 {
        return None;
    }
    let value = times / substeps;
    let meaning = format!("contact was left before it was settled in {} of the substeps", percent(value));
    let remedy = "shorten `max_substep_s` of the solver: shorter substeps leave less to settle, for more of them";
    Some(estimate("unsettled contact", of, [value, UNSETTLED], meaning, remedy))
}

fn stretch(of: &str, value: f64) -> Option<Estimate> {
    let meaning = format!(
        "threads were left up to {} longer or shorter than they are made to be: the cloth is that much softer than its material",
        percent(value)
    );
    let remedy = "halve `max_substep_s` of the solver: this quarters it, for twice the substeps; more `iterations` lower it \
                  more slowly; published relaxation factors leave what they leave";
    (value > 0.0).then(|| estimate("stretch left", of, [value, STRETCH], meaning, remedy))
}

fn strain(of: &str, value: f64) -> Option<Estimate> {
    let meaning = format!(
        "a particle of a solid is stretched to at most {value:.3} times its length: at {STRETCHED} its neighbours are a cell of \
         the grid away and the body can tear numerically, at ten times it is taken out and counted"
    );
    let remedy = "where the stretch is real, halve the body's `spacing` and leave `grid_spacing_m` of the solver as it is: \
                  neighbours stay in reach twice as far, for eight times the particles and the same substeps";
    (value > 0.0).then(|| estimate("strain guard [stretch]", of, [value, STRETCHED], meaning, remedy))
}

fn gap(of: &str, value: f64) -> Option<Estimate> {
    let meaning =
        format!("a joint or a bond was open by up to {value:.2e} m: its two sides are beside each other by that");
    let remedy = "halve the longest substep of the solver (`substep_s`, `max_substep_s`): this quarters it, for twice the \
                  substeps";
    (value > 0.0).then(|| estimate("gap of a joint [m]", of, [value, GAP_M], meaning, remedy))
}

fn divergence(of: &str, value: f64) -> Option<Estimate> {
    let meaning = format!(
        "the gas was left with {} of a volume too much or too little in the time in which it crosses a cell",
        percent(value)
    );
    let remedy = "lower `divergence` of the solver: each tenth of it costs two or three cycles more in each substep";
    (value > 0.0).then(|| estimate("divergence", of, [value, DIVERGENCE], meaning, remedy))
}

fn crowding(of: &str, value: f64) -> Option<Estimate> {
    let meaning = format!("particles were denser by {} than they should be, on the mean of all", percent(value));
    let remedy =
        "raise `density_iterations` of the solver: twice as many leave about half, for twice the time of a substep";
    (value > 0.0).then(|| estimate("crowding", of, [value, CROWDING], meaning, remedy))
}

fn clamps(of: &str, times: f64) -> Option<Estimate> {
    let meaning =
        format!("{times} times a particle was stretched beyond what its material law bears and was held there");
    let remedy =
        "refine the body's `spacing`, or soften what strikes it; each refinement costs eight times the particles";
    (times > 0.0).then(|| estimate("stretch clamps", of, [times, 0.0], meaning, remedy))
}

fn overlap(of: &str, value: f64) -> Option<Estimate> {
    let meaning = format!("a body was {value:.2e} m inside another, or inside a wall");
    let remedy = "shorten `max_substep_s` of the solver, in proportion to the depth, for as many more substeps; a body that \
                  begins inside another must be moved";
    (value > OVERLAP_M).then(|| estimate("overlap [m]", of, [value, OVERLAP_M], meaning, remedy))
}

fn aside(of: &str, value: f64) -> Option<Estimate> {
    let meaning = format!("contact set a body aside by {value:.2e} m in one substep: it was that deep in another");
    let remedy = "shorten `substep_s` of the solver, in proportion to the depth, for as many more substeps";
    (value > ASIDE_M).then(|| estimate("set aside [m]", of, [value, ASIDE_M], meaning, remedy))
}

fn overrun(of: &str, value: f64) -> Option<Estimate> {
    let meaning = format!(
        "a soft partner was {value:.2e} m further on than cloth that holds it back: where that is more than the cloth's thickness, \
         it looks through for so long"
    );
    let remedy = "shorten `clock.window`: half of it halves what a fast partner overruns, and quarters what one that presses does";
    (value > OVERLAP_M).then(|| estimate("overrun [m]", of, [value, OVERLAP_M], meaning, remedy))
}
