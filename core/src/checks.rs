//! Every check the protocol relies on, by name, so that a test can switch off one at a time and see that it is noticed.
//!
//! In a run the type parameter is [`AllChecks`], of zero size and always true: the compiler removes it. A check that
//! no simulation misses when it is gone protects nothing, or the simulation is too kind.

/// A check in one of the state machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Check {
    /// Frames of another run are refused.
    DataRun,
    /// Frames of an earlier incarnation of the run are refused.
    DataEpoch,
    /// A frame's sender is the one its stream belongs to.
    DataSender,
    /// A frame whose hash does not match is refused.
    DataHash,
    /// A chunk that is there already does not count again.
    DataOnce,
    /// Only messages near the present are kept.
    DataFence,
    /// A step waits for all it needs.
    AllNeeds,
    /// A step takes the message of exactly the index it needs.
    ExactIndex,
    /// A participant stays below the granted window.
    GrantLimit,
    /// A missing message is asked for again.
    AskAgain,
    /// Published messages are kept until settled.
    KeepUntilSettled,
    /// A finished window is reported until it is settled.
    RepeatDone,
    /// A greeting is repeated until it is answered.
    RepeatHello,
    /// Control messages of another run are refused.
    ControlRun,
    /// Control messages of an earlier incarnation are refused.
    ControlEpoch,
    /// Messages of another process under the same name are refused.
    ControlInstance,
    /// A report counts once.
    DoneOnce,
    /// Windows are settled in order.
    SettleInOrder,
    /// What one consumed is what the other produced.
    ConsumedIsProduced,
    /// The first window waits until every stream has been heard by every reader.
    WaitForProbes,
    /// The death of a process ends the run.
    NoticeDeath,
    /// Silence ends the run.
    NoticeSilence,
    /// A stop waits for the granted windows.
    StopAtEdge,
    /// A snapshot is taken at exactly the edge that was asked for.
    SaveAtEdge,
    /// What is stored is said again when it is asked for again.
    RepeatSaved,
    /// A checkpoint counts only when every participant has stored its part.
    CheckpointComplete,
    /// The next checkpoint begins only when the last one is recorded.
    RecordedBeforeNext,
    /// A snapshot is of the run, participant and window that is resumed.
    SnapshotFits,
    /// Who resumes publishes what was published before.
    RestoredMessages,
    /// Who resumes has the state that was settled before.
    RestoredState,
}

/// All of them.
pub const ALL: [Check; 30] = [
    Check::DataRun,
    Check::DataEpoch,
    Check::DataSender,
    Check::DataHash,
    Check::DataOnce,
    Check::DataFence,
    Check::AllNeeds,
    Check::ExactIndex,
    Check::GrantLimit,
    Check::AskAgain,
    Check::KeepUntilSettled,
    Check::RepeatDone,
    Check::RepeatHello,
    Check::ControlRun,
    Check::ControlEpoch,
    Check::ControlInstance,
    Check::DoneOnce,
    Check::SettleInOrder,
    Check::ConsumedIsProduced,
    Check::WaitForProbes,
    Check::NoticeDeath,
    Check::NoticeSilence,
    Check::StopAtEdge,
    Check::SaveAtEdge,
    Check::RepeatSaved,
    Check::CheckpointComplete,
    Check::RecordedBeforeNext,
    Check::SnapshotFits,
    Check::RestoredMessages,
    Check::RestoredState,
];

/// Which checks are made.
pub trait Checks {
    /// Whether this one is.
    fn on(&self, check: Check) -> bool;
}

/// All checks: what every run uses.
#[derive(Clone, Copy, Debug, Default)]
pub struct AllChecks;

impl Checks for AllChecks {
    fn on(&self, _check: Check) -> bool {
        true
    }
}

/// All checks but one: a hand-made protocol bug.
#[derive(Clone, Copy, Debug)]
pub struct Without(pub Check);

impl Checks for Without {
    fn on(&self, check: Check) -> bool {
        check != self.0
    }
}
