//! What is computed although an indicator may say that it could be left out, and why.

use serde::Serialize;

/// Something that is not left out.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Kept {
    /// What.
    pub(crate) what: &'static str,
    /// By what it is usually decided.
    pub(crate) indicator: &'static str,
    /// Why it stays.
    pub(crate) why: &'static str,
}

/// All that no scene can leave out, or that needs no run to leave it out.
pub(crate) fn kept() -> &'static [Kept] {
    &[
        Kept {
            what: "Bodies at rest are computed",
            indicator: "speed below 0.05 m/s for half a second",
            why: "a body that is put to sleep loses the momentum that it still has without an impulse, and the verdict \
                  on closure would be right to call that an error",
        },
        Kept {
            what: "Pairs that are far from each other exchange in every window",
            indicator: "distance of their boxes over relative speed times window",
            why: "both sides would have to know it before the window; what a pair that never met costs in a whole run is \
                  the row `pair-…` of this table",
        },
        Kept {
            what: "No window is repeated until both sides agree",
            indicator: "added mass over mass, ρ c A Δt / m",
            why: "no scheme here iterates; stand-ins bear a hundred times the mass, and what the explicit schemes leave is \
                  an estimate of every run",
        },
        Kept {
            what: "Free bodies turn with their gyroscopic term",
            indicator: "difference of the moments of inertia",
            why: "the rotation is integrated as a whole, and costs the same for a ball",
        },
        Kept {
            what: "Flow, depth and masks (`output.preset`), a viewer (`--live`), closed environments (`cosplat splat densify`)",
            indicator: "whether somebody asks",
            why: "left out unless asked for. A preset has frames at times of its own, which are edges of windows, so that no \
                  run is the same but for it; a viewer changes no byte",
        },
    ]
}
