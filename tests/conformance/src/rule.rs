//! The rules, and why each matters.

use std::fmt;

/// A rule of the plugin contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// The descriptor is complete and legal.
    DescriptorSane,
    /// The descriptor survives JSON.
    DescriptorJson,
    /// `describe` needs no set-up and never changes.
    DescribeAlways,
    /// The scene of the case can be played.
    ScenePlays,
    /// A scene without bodies works.
    EmptyScene,
    /// Boundaries, impulses, body states and interface reports are complete, in order and of the declared form.
    ShapeOfAnswers,
    /// Every number of an answer is finite.
    FiniteAnswers,
    /// The term that binds the substep is named.
    BindingTerm,
    /// Set-up gives the same answer each time.
    SetupRepeats,
    /// The same step from the same state gives the same bits.
    StepRepeats,
    /// A state holds all that a step depends on.
    StateComplete,
    /// Restoring what was just saved changes nothing.
    RestoreIsIdentity,
    /// A damaged state is refused and leaves the plugin as it was.
    DamagedStateRefused,
    /// The saved state follows the motion.
    StateMoves,
    /// The number of threads changes nothing.
    ThreadsDoNotMatter,
    /// The order of inputs changes nothing.
    OrderDoesNotMatter,
    /// Input that is not finite is an error of physics, said aloud.
    NonFiniteInput,
    /// A plugin that beats stops when told to.
    AbortHonoured,
    /// Beats count up to what they announce.
    BeatsCount,
    /// Change of momentum is explained by what came from outside and through interfaces.
    MomentumCloses,
    /// What a report says crossed an interface is what did.
    ReceivedIsGiven,
    /// What is not supported is refused at set-up, by name.
    UnsupportedNamed,
}

impl Rule {
    /// What goes wrong in a run when the rule is broken.
    pub fn why(self) -> &'static str {
        match self {
            Self::DescriptorSane => "the plan is made from descriptors alone; a wrong one starts runs that cannot work",
            Self::DescriptorJson => "`--describe` prints JSON, and whoever reads it must see the same plugin",
            Self::DescribeAlways => "the plan is made before any set-up and must hold after it",
            Self::ScenePlays => "the case was written for this plugin",
            Self::EmptyScene => "a solver may be left without bodies, and must not bring the others down",
            Self::ShapeOfAnswers => "partners match samples, impulses and bodies by position in these lists",
            Self::FiniteAnswers => "one NaN crosses every interface within a few windows and names nobody",
            Self::BindingTerm => "nobody can speed up or trust a substep without knowing what bounds it",
            Self::SetupRepeats => "a restarted process must be the same solver",
            Self::StepRepeats => "implicit coupling and rollback repeat windows; runs are compared by hash",
            Self::StateComplete => "a checkpoint is restored into a new process; what is not in it is lost",
            Self::RestoreIsIdentity => "iterations of a window would drift apart by being repeated",
            Self::DamagedStateRefused => "a torn checkpoint must end in an error, not in another simulation",
            Self::StateMoves => "the hash of the state is the only witness that two runs agree",
            Self::ThreadsDoNotMatter => "results must not depend on the machine or its load",
            Self::OrderDoesNotMatter => "messages arrive in any order",
            Self::NonFiniteInput => "the partner that sent it must be named in the window in which it did",
            Self::AbortHonoured => "a run that ends must end now, not after a long step",
            Self::BeatsCount => "progress and the detection of frozen solvers rest on beats",
            Self::MomentumCloses => "a force that nobody accounts for is a wrong force, whoever computed it",
            Self::ReceivedIsGiven => "an impulse that arrives changed breaks the momentum of the whole system",
            Self::UnsupportedNamed => "a feature ignored in silence gives a wrong result that looks right",
        }
    }
}

/// A rule broken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Case in which it happened.
    pub case: String,
    /// The rule.
    pub rule: Rule,
    /// What was seen.
    pub found: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:?}: {} ({})", self.case, self.rule, self.found, self.rule.why())
    }
}
