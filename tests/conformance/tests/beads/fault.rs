//! The ways in which beads can cheat.

/// Ways to break the contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// None.
    Honest,
    /// A name that no scene can write.
    ShoutsItsName,
    /// Describes itself otherwise after set-up.
    ChangesItsMind,
    /// Fails where there is nothing to do.
    HatesEmptyScenes,
    /// Stops showing one of its bodies.
    HidesABody,
    /// Reports an energy that is no number.
    LosesItsEnergy,
    /// Does not say what bounds its substep.
    BoundByNothing,
    /// Set-up keeps the state of the run before.
    RemembersTheLastRun,
    /// A step depends on what the state does not hold.
    KeepsSecrets,
    /// Restores to single precision.
    RestoresRoughly,
    /// Accepts a state that ends early.
    TakesHalfAState,
    /// A refused state has changed it already.
    RestoresBeforeItChecks,
    /// Saves the state at t = 0.
    SavesTheBeginning,
    /// Adds up in another way for each number of threads.
    CountsThreads,
    /// Adds up impulses in the order of arrival.
    AddsAsItHears,
    /// Computes with NaN.
    LetsNanThrough,
    /// Takes NaN for zero.
    ThrowsNanAway,
    /// Does not hear the word to stop.
    NeverStops,
    /// Announces fewer substeps than it takes.
    BeatsBackwards,
    /// Throws impulses away.
    DropsImpulses,
    /// Reports more than it took.
    ReportsOtherImpulses,
    /// Gives a quarter more than it takes itself.
    GivesTooMuch,
    /// Does not book its weight.
    ForgetsGravity,
    /// Books no angular impulse.
    ForgetsLeverArms,
    /// Plays scenes with joints as if they had none.
    AcceptsJoints,
    /// Does not say what it lacks.
    RefusesWithoutNames,
}
