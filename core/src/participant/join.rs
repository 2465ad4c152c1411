//! Joining a run: welcome, set-up, and the proof that every stream works.

use std::time::Duration;

use super::{Action, Answer, Fetch, Inbox, Joined, Outbox, Participant, Phase, outbox};
use crate::boundary::SampleStatics;
use crate::checkpoint::identity_of_part;
use crate::checks::Checks;
use crate::control::{AssetInfo, FailureKind, ReadyInfo, Up};
use crate::plan::schedule::{self, MessageId};
use crate::plan::{Content, ParticipantId, Plan, StreamId};
use crate::plugin::{PartnerSetup, PluginError, Setup, SolverScene};
use crate::wire::decode_statics;

impl<C: Checks> Participant<C> {
    pub(super) fn on_welcome(
        &mut self,
        id: ParticipantId,
        from: u64,
        [plan, scene]: [&str; 2],
        assets: Vec<AssetInfo>,
        now: Duration,
        out: &mut Vec<Action>,
    ) {
        let (Ok(plan), Ok(scene)) = (serde_json::from_str::<Plan>(plan), serde_json::from_str::<SolverScene>(scene))
        else {
            let message = "the welcome holds no plan that this version understands".to_owned();
            return self.fail(FailureKind::Bus, message, now, out);
        };
        let (run, epoch) = (self.identity.run, self.identity.epoch);
        self.joined = Some(Joined {
            id,
            identity: identity_of_part(&plan, &scene, &assets),
            from,
            snapshot: None,
            restored: None,
            inbox: Inbox::new(run, epoch, &plan, id),
            outbox: Outbox::new(run, epoch, id),
            plan,
            scene,
            ready: ReadyInfo::default(),
            connecting: false,
            connected: false,
        });
        self.fetch = Fetch::new(assets);
        self.phase = Phase::Fetching;
        out.push(Action::Declare);
        self.asked_at = now;
        self.fetch_more(out);
    }

    pub(super) fn on_set_up(
        &mut self,
        answer: Result<Answer<Setup>, PluginError>,
        now: Duration,
        out: &mut Vec<Action>,
    ) {
        let Some(joined) = self.joined.as_mut().filter(|_| self.phase == Phase::SettingUp) else { return };
        let answer = match answer {
            Ok(answer) => answer,
            Err(error) => return self.fail_plugin(&error, now, out),
        };
        if let Err(missing) = joined.publish_setup(answer) {
            return self.fail(FailureKind::Bus, missing, now, out);
        }
        let report = Up::Ready(Box::new(joined.ready.clone()));
        self.phase = Phase::Ready;
        self.say(report, now, out);
        self.try_connect(now, out);
    }

    /// Sends what shows that every stream works, and what partners need before the first window.
    pub(super) fn on_probe(&mut self, now: Duration, out: &mut Vec<Action>) {
        if self.phase != Phase::Ready && self.phase != Phase::Probing {
            return;
        }
        let first = self.phase == Phase::Ready;
        self.phase = Phase::Probing;
        let Some(joined) = &mut self.joined else { return };
        let streams: Vec<StreamId> = joined.plan.sent_by(joined.id).map(|(id, _)| id).collect();
        for stream in streams {
            let frame = joined.outbox.probe(&joined.plan, stream);
            out.push(Action::Publish(stream, frame));
        }
        // What got lost of it is asked for; only probes are repeated.
        let initial = if first { schedule::published_before(&joined.plan, joined.id, joined.from) } else { Vec::new() };
        for id in initial {
            out.extend(joined.outbox.frames(id).iter().map(|f| Action::Publish(id.stream, f.clone())));
        }
        self.report_probes(now, out);
    }

    /// Hands the partners' statics over once they are all there.
    pub(super) fn try_connect(&mut self, now: Duration, out: &mut Vec<Action>) {
        let Some(joined) = self.joined.as_mut().filter(|j| !j.connecting) else { return };
        if self.phase < Phase::Ready {
            return;
        }
        match joined.partner_setups() {
            Ok(Some(partners)) => {
                joined.connecting = true;
                out.push(Action::Connect(partners));
            }
            Ok(None) => {}
            Err(message) => self.fail(FailureKind::Bus, message, now, out),
        }
    }

    pub(super) fn on_connected(&mut self, answer: Result<(), PluginError>, now: Duration, out: &mut Vec<Action>) {
        match answer {
            Ok(()) => {
                let Some(joined) = &mut self.joined else { return };
                // Now it knows its partners and can be put where the run is resumed.
                if let Some(snapshot) = joined.snapshot.take() {
                    out.push(Action::Restore(snapshot.state));
                } else {
                    joined.connected = true;
                    self.report_probes(now, out);
                }
            }
            Err(error) => self.fail_plugin(&error, now, out),
        }
    }

    /// Tells the coordinator once every stream has been heard and the partners are known.
    pub(super) fn report_probes(&mut self, now: Duration, out: &mut Vec<Action>) {
        let Some(joined) = self.joined.as_ref().filter(|j| j.connected && j.inbox.all_heard()) else { return };
        if self.phase == Phase::Probing {
            let probed = Up::Probed { streams: joined.inbox.heard(), restored: joined.restored };
            self.say(probed, now, out);
        }
    }
}

impl Joined {
    /// Encodes the statics and the boundaries where the run begins, and fills in what `Ready` says.
    fn publish_setup(&mut self, answer: Answer<Setup>) -> Result<(), String> {
        let Answer { value: setup, state_hash, visuals } = answer;
        let mut produced = Vec::new();
        for id in schedule::published_before(&self.plan, self.id, self.from) {
            let stream = &self.plan.streams[usize::from(id.stream)];
            if let Some(snapshot) =
                self.snapshot.as_ref().filter(|_| !matches!(stream.content, Content::Statics { .. }))
            {
                let kept = snapshot.messages.iter().find(|m| (m.stream, m.index) == (id.stream, id.index));
                // What is missing is missed by the coordinator, which knows what there was.
                produced.extend(kept.map(|m| (id.stream, id.index, self.outbox.take_over(&self.plan, m))));
                continue;
            }
            if let Content::Visual { .. } = &stream.content {
                let content = self.outbox.visual(&self.plan, id, &visuals).map_err(|e| e.to_string())?;
                produced.push((id.stream, id.index, content));
                continue;
            }
            let (body, form) = match &stream.content {
                Content::Boundary { body, form } => (body, Some(*form)),
                Content::Statics { body } => (body, None),
                Content::MidBoundary { .. } | Content::Impulses { .. } | Content::Visual { .. } => continue,
            };
            let shown = setup.boundaries.iter().find(|b| &b.body == body);
            let shown = shown.ok_or_else(|| format!("the plugin showed no boundary of body `{body}` at set-up"))?;
            let content = match form {
                Some(form) if outbox::fits(form, &shown.state) => {
                    self.outbox.boundary(&self.plan, id, form, &shown.state)
                }
                Some(_) => return Err(format!("the boundary of body `{body}` has not the form the plugin declared")),
                None => self.outbox.statics(&self.plan, id, &shown.statics),
            };
            produced.push((id.stream, id.index, content));
        }
        self.ready = ReadyInfo {
            report: setup.report,
            stable_dt: setup.stable_dt,
            particles: setup.particles,
            left_out: setup.left_out,
            state_hash,
            produced,
        };
        Ok(())
    }

    /// Bodies that somebody draws.
    pub(super) fn shown_bodies(&self) -> Vec<String> {
        let drawn = |content: &Content| match content {
            Content::Visual { body, .. } => Some(body.clone()),
            _ => None,
        };
        self.plan.sent_by(self.id).filter_map(|(_, stream)| drawn(&stream.content)).collect()
    }

    /// What never changes about each partner, once all of it is there.
    fn partner_setups(&self) -> Result<Option<Vec<PartnerSetup>>, String> {
        let mut partners = Vec::new();
        for view in &self.scene.interfaces {
            let wanted = self
                .plan
                .read_by(self.id)
                .find(|(_, s)| matches!(&s.content, Content::Statics { body } if body == &view.partner));
            let statics = match wanted {
                None => SampleStatics::default(),
                Some((stream, declared)) => {
                    let Some(message) = self.inbox.message(MessageId { stream, index: 0 }) else { return Ok(None) };
                    decode_statics(message.count(), &message.chunks())
                        .map_err(|e| format!("`{}`: {e}", declared.key))?
                }
            };
            partners.push(PartnerSetup { interface: view.id, statics });
        }
        Ok(Some(partners))
    }
}
