//! Decoding what a step needs.

use super::moment::Handed;
use super::{Joined, fault};
use crate::boundary::{BoundaryState, Impulses, Vec3};
#[cfg(doc)]
use crate::control::Done;
use crate::plan::schedule::{MessageId, Need, Role, StepPlan};
use crate::plan::{Content, InterfaceId, Plan, StreamId};
use crate::plugin::{ImpulseInput, Inputs, PartnerInput};
use crate::visual::{VisualFrame, VisualState};
use crate::wire::{decode_boundary, decode_impulses, decode_visual};

/// What a step is given, and what [`Done`] says of it.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) inputs: Inputs,
    /// Frames to draw before the step.
    pub(super) frames: Vec<VisualFrame>,
    /// Messages used: stream, index, content hash.
    pub(super) consumed: Vec<(StreamId, u64, u64)>,
    /// Impulses given to the solver: interface, sum and sum of magnitudes \[N s\].
    pub(super) applied: Vec<(InterfaceId, Vec3, f64)>,
    /// The same, until their moment is known.
    pub(super) handed: Vec<Handed>,
}

/// Decodes what a step needs.
pub(super) fn gather(
    joined: &Joined,
    step: &StepPlan,
    window: u64,
    found: &[(Need, Option<MessageId>)],
) -> Result<Gathered, String> {
    let mut gathered = Gathered::default();
    let length_s = joined.plan.clock.seconds(step.span.ticks());
    for (need, id) in found {
        let Some((id, message)) = id.and_then(|id| joined.inbox.message(id).map(|m| (id, m))) else { continue };
        let stream = &joined.plan.streams[usize::from(id.stream)];
        let explain = |e| format!("message {} on `{}` in window {window}: {e}", id.index, stream.key);
        gathered.consumed.push((id.stream, id.index, message.content().unwrap_or_default()));
        let payload = message.chunks();
        match (&stream.content, need.interface) {
            (Content::Boundary { form, .. } | Content::MidBoundary { form, .. }, Some(interface)) => {
                let state = decode_boundary(*form, message.count(), &payload).map_err(explain)?;
                let state = fault::of_boundary(joined.plan.break_with, state, length_s);
                gathered.add_partner(joined, interface, need.role, state, length_s);
            }
            (Content::Impulses { form, .. }, Some(interface)) => {
                let impulses = decode_impulses(*form, message.count(), &payload).map_err(explain)?;
                let impulses = about_present_centre(joined, interface, id.index, window, impulses);
                let (total, gross) = impulses.sums();
                gathered.applied.push((interface, total, gross));
                gathered.handed.push(Handed::new(interface, id.index, &impulses));
                gathered.inputs.impulses.push(ImpulseInput {
                    interface,
                    impulses: fault::of_impulses(joined.plan.break_with, impulses),
                    spread: need.role == Role::ImpulseSpread,
                });
            }
            (Content::Visual { body, form }, _) => {
                let state = decode_visual(*form, message.count(), &payload).map_err(explain)?;
                gathered.add_visual(&joined.plan, id.index, body, state);
            }
            _ => {}
        }
    }
    Ok(gathered)
}

impl Gathered {
    fn add_partner(
        &mut self,
        joined: &Joined,
        interface: InterfaceId,
        role: Role,
        state: BoundaryState,
        length_s: f64,
    ) {
        let known = self.inputs.partners.iter_mut().find(|p| p.interface == interface);
        match (known, role) {
            (Some(partner), Role::PartnerNext) => partner.next = Some(state),
            _ => self.inputs.partners.push(PartnerInput {
                interface,
                rule: joined.plan.interfaces[usize::from(interface)].rule,
                now: state,
                next: None,
                length_s,
            }),
        }
    }

    /// Needs come frame by frame, so a body of the same moment belongs to the last frame.
    fn add_visual(&mut self, plan: &Plan, edge: u64, body: &str, state: VisualState) {
        let number = edge / plan.recorder.map_or(1, |r| r.windows_per_frame);
        let body = (body.to_owned(), state);
        if let Some(frame) = self.frames.last_mut().filter(|f| f.number == number) {
            frame.bodies.push(body);
        } else {
            let time_s = plan.clock.seconds(plan.clock.start_of(edge));
            self.frames.push(VisualFrame { number, time_s, bodies: vec![body] });
        }
    }
}

/// Impulses on a rigid body carry their moment about its centre where the resolver saw it. In the parallel scheme that
/// is one window ago: the moment is moved to the centre at the start of this window, or angular momentum would be lost.
fn about_present_centre(joined: &Joined, interface: u16, made_in: u64, window: u64, impulses: Impulses) -> Impulses {
    let Impulses::Rigid(wrench) = impulses else { return impulses };
    let shown = joined.plan.interfaces[usize::from(interface)].from_b;
    let centre = |index| joined.outbox.centre(MessageId { stream: shown, index });
    match (centre(made_in), centre(window)) {
        (Some(then), Some(now)) if made_in != window => Impulses::Rigid(wrench.about(then, now)),
        _ => Impulses::Rigid(wrench),
    }
}
