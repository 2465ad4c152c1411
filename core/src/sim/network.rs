//! The simulated bus: what happens to a message between sender and receiver.

use super::Forgery;
use super::birth::RUN;
use super::faults::{flipped, forged_down, forged_frame, forged_up, idle_request};
use super::scenario::Trouble;
use super::world::{Delivery, World};
use crate::checks::Checks;
use crate::participant::Frame;
use crate::plan::ParticipantId;

impl<C: Checks + Copy> World<'_, C> {
    pub(super) fn send_up(&mut self, who: ParticipantId, bytes: Vec<u8>) {
        let bytes = self.lied(who, bytes);
        if self.random.once_in(self.scenario.faults.forge) {
            let how = Forgery::any(&mut self.random);
            if let Some(forged) = forged_up(&bytes, how) {
                self.post(1, Delivery::Up(who, forged));
            }
        }
        self.send(&bytes, move |b| Delivery::Up(who, b));
    }

    /// A liar says that it used another message than it did.
    pub(super) fn lied(&self, who: ParticipantId, bytes: Vec<u8>) -> Vec<u8> {
        if self.scenario.trouble != Trouble::Lie(who) || self.now_us < self.scenario.trouble_at_us {
            return bytes;
        }
        match crate::control::decode::<crate::control::Up>(&bytes) {
            Ok(mut envelope) => {
                if let crate::control::Up::Done(done) = &mut envelope.body {
                    done.consumed.iter_mut().for_each(|(_, _, hash)| *hash ^= 1);
                }
                crate::control::encode(&envelope)
            }
            Err(_) => bytes,
        }
    }

    pub(super) fn send_down(&mut self, who: ParticipantId, bytes: &[u8]) {
        if self.random.once_in(self.scenario.faults.forge) {
            let how = Forgery::any(&mut self.random);
            if let Some(forged) = forged_down(bytes, how) {
                self.post(1, Delivery::Down(who, forged));
            }
            let request = idle_request(RUN, self.epoch(), &mut self.random);
            self.post(1, Delivery::Resend(who, request));
        }
        self.send(bytes, move |b| Delivery::Down(who, b));
    }

    pub(super) fn send_data(&mut self, to: ParticipantId, frame: &Frame) {
        if self.random.once_in(self.scenario.faults.forge) {
            // A stranger sends many.
            for _ in 0..4 {
                let how = Forgery::any(&mut self.random);
                if let Some(forged) = forged_frame(frame, how, &mut self.random) {
                    self.post(1, Delivery::Data(to, forged));
                }
            }
        }
        let faults = self.scenario.faults;
        if self.random.once_in(faults.flip) {
            let flipped = flipped(frame, &mut self.random);
            self.post(20, Delivery::Data(to, Frame::new(flipped)));
            return;
        }
        let copies = 1 + u64::from(self.random.once_in(faults.duplicate));
        for _ in 0..copies {
            if !self.random.once_in(faults.loss) {
                let latency = self.latency();
                self.post(latency, Delivery::Data(to, frame.clone()));
            }
        }
    }

    pub(super) fn send(&mut self, bytes: &[u8], wrap: impl Fn(Vec<u8>) -> Delivery) {
        let faults = self.scenario.faults;
        let copies = 1 + u64::from(self.random.once_in(faults.duplicate));
        for _ in 0..copies {
            let lost = self.random.once_in(faults.loss);
            let bytes =
                if self.random.once_in(faults.flip) { flipped(bytes, &mut self.random) } else { bytes.to_vec() };
            if !lost {
                let latency = self.latency();
                self.post(latency, wrap(bytes));
            }
        }
    }

    pub(super) fn latency(&mut self) -> u64 {
        let late = if self.random.once_in(self.scenario.faults.delay) { self.random.below(20_000) } else { 0 };
        20 + self.random.below(100) + late
    }
}
