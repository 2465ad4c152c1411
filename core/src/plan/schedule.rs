//! What a participant does in a window: its steps, what each needs first and what each gives.
//!
//! All coupling schemes are data here. A step covers a span of ticks, waits for messages and ends with messages.
//! Nobody asks anybody for permission inside a window: a participant starts when what it needs is there.

use super::{Content, Interface, InterfaceId, ParticipantId, Plan, Stream, StreamId};
use crate::scene::Scheme;
use crate::time::{Span, TICKS_PER_WINDOW};

/// A message by stream and index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MessageId {
    /// Stream.
    pub stream: StreamId,
    /// Index on the stream.
    pub index: u64,
}

/// What a needed message is to the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The partner's boundary at the start of the step.
    PartnerNow,
    /// The partner's boundary at the end of the step.
    PartnerNext,
    /// Impulses to take over the whole step.
    ImpulseSpread,
    /// Impulses to take at once, at the start of the step.
    ImpulseAtStart,
    /// A body to draw; the step itself does not depend on it.
    Visual,
}

/// A message that must be there before a step starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// The message.
    pub message: MessageId,
    /// Interface it belongs to; visual states belong to none.
    pub interface: Option<InterfaceId>,
    /// What it is to the step.
    pub role: Role,
}

/// A stretch of a window that a solver covers in one go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepPlan {
    /// Ticks covered.
    pub span: Span,
    /// What must be there before.
    pub needs: Vec<Need>,
    /// What is published after.
    pub gives: Vec<MessageId>,
}

/// Steps of participant `who` in window `window`, in order; together they cover it.
pub fn steps(plan: &Plan, who: ParticipantId, window: u64) -> Vec<StepPlan> {
    let start = plan.clock.start_of(window);
    let end = start + TICKS_PER_WINDOW;
    let halved =
        plan.interfaces.iter().any(|i| i.scheme == Scheme::Centred && i.carries_impulses() && i.b.participant == who);
    let mut steps = if halved {
        let middle = start + TICKS_PER_WINDOW / 2;
        vec![empty_step(start, middle), empty_step(middle, end)]
    } else {
        vec![empty_step(start, end)]
    };
    let last = steps.len() - 1;
    for (id, interface) in plan.interfaces.iter().enumerate() {
        for (step, need) in needs(interface, id as InterfaceId, who, window) {
            steps[step.min(last)].needs.push(need);
        }
    }
    steps[last].needs.extend(visuals(plan, who, window));
    for (stream, declared) in plan.sent_by(who) {
        let (step, index) = match declared.content {
            Content::Statics { .. } => continue,
            Content::Visual { .. } if !plan.has_frame_at(window + 1) => continue,
            Content::Visual { .. } | Content::Boundary { .. } => (last, window + 1),
            Content::MidBoundary { .. } => (0, window),
            Content::Impulses { .. } => (last, window),
        };
        steps[step].gives.push(MessageId { stream, index });
    }
    steps
}

/// Messages that are published before the first window: the boundaries at t = 0 and the statics.
pub fn published_at_start(plan: &Plan, who: ParticipantId) -> Vec<MessageId> {
    published_before(plan, who, 0)
}

/// Messages that `who` publishes before `window` and that this window or a later one needs: statics, boundaries at its
/// start, impulses that arrive a window late, and the boundary where such impulses were taken.
pub fn published_before(plan: &Plan, who: ParticipantId, window: u64) -> Vec<MessageId> {
    let late = |i: &Interface| i.carries_impulses() && i.scheme == Scheme::Parallel;
    let of = |(stream, declared): (StreamId, &Stream)| {
        let last = window.checked_sub(1);
        let turned = plan.interfaces.iter().any(|i| late(i) && i.from_b == stream);
        let indices = match &declared.content {
            Content::Statics { .. } => [Some(0), None],
            Content::Boundary { .. } => [last.filter(|_| turned), Some(window)],
            Content::Impulses { interface, .. } => {
                [last.filter(|_| plan.interfaces.get(usize::from(*interface)).is_some_and(late)), None]
            }
            // A frame is drawn in the window that ends with it; only the one at t = 0 is drawn afterwards.
            Content::Visual { .. } => [(window == 0).then_some(0), None],
            Content::MidBoundary { .. } => [None, None],
        };
        indices.into_iter().flatten().map(move |index| MessageId { stream, index })
    };
    plan.sent_by(who).flat_map(of).collect()
}

/// Statics that must be there before the first window.
pub fn needed_at_start(plan: &Plan, who: ParticipantId) -> Vec<MessageId> {
    plan.read_by(who)
        .filter(|(_, s)| matches!(s.content, Content::Statics { .. }))
        .map(|(stream, _)| MessageId { stream, index: 0 })
        .collect()
}

fn empty_step(from: u64, to: u64) -> StepPlan {
    StepPlan { span: Span { from, to }, needs: Vec::new(), gives: Vec::new() }
}

/// What a recorder draws in a window: the frame at its end, and before the first window the start as well.
fn visuals(plan: &Plan, who: ParticipantId, window: u64) -> Vec<Need> {
    let edges = [(window == 0).then_some(0), plan.has_frame_at(window + 1).then_some(window + 1)];
    let streams: Vec<StreamId> =
        plan.read_by(who).filter(|(_, s)| matches!(s.content, Content::Visual { .. })).map(|(id, _)| id).collect();
    let need = |index, stream| Need { message: MessageId { stream, index }, interface: None, role: Role::Visual };
    edges.into_iter().flatten().flat_map(|index| streams.iter().map(move |&stream| need(index, stream))).collect()
}

/// Needs of `who` on one interface, with the number of the step that has them.
fn needs(interface: &Interface, id: InterfaceId, who: ParticipantId, window: u64) -> Vec<(usize, Need)> {
    let is_a = interface.a.participant == who;
    let is_b = interface.b.participant == who;
    let need = |stream: StreamId, index: u64, role: Role| Need {
        message: MessageId { stream, index },
        interface: Some(id),
        role,
    };
    if let Some(impulses) = interface.impulses {
        let taken = if interface.at_once { Role::ImpulseAtStart } else { Role::ImpulseSpread };
        return if is_a {
            vec![(0, need(interface.from_b, window, Role::PartnerNow))]
        } else if is_b {
            match (interface.scheme, window) {
                (Scheme::Centred, _) => vec![(1, need(impulses, window, Role::ImpulseAtStart))],
                (Scheme::Parallel, 0) => Vec::new(),
                (Scheme::Parallel, n) => vec![(0, need(impulses, n - 1, taken))],
                _ => vec![(0, need(impulses, window, taken))],
            }
        } else {
            Vec::new()
        };
    }
    if !is_a && !is_b {
        return Vec::new();
    }
    let partner = if is_a { interface.from_b } else { interface.from_a.unwrap_or(interface.from_b) };
    let mut found = vec![(0, need(partner, window, Role::PartnerNow))];
    if goes_second(interface.scheme, is_a, window) {
        found.push((0, need(partner, window + 1, Role::PartnerNext)));
    }
    found
}

/// Whether a side of a link waits for its partner's result of the same window.
fn goes_second(scheme: Scheme, is_a: bool, window: u64) -> bool {
    match scheme {
        Scheme::Serial => !is_a,
        Scheme::Alternating => is_a == (window % 2 == 1),
        Scheme::Parallel | Scheme::Centred => false,
    }
}
