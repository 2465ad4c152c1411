//! What the simulated bus does to messages.

use std::sync::Arc;

use super::random::Random;
use crate::control::{self, Down, Envelope, FailureKind, PROTOCOL, Resend, Up};
use crate::participant::Frame;
use crate::wire::{HEADER_BYTES, Header};
use xxhash_rust::xxh3::xxh3_64;

/// How often each fault happens: once in so many messages, 0 for never.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// The message is lost.
    pub loss: u64,
    /// It arrives twice.
    pub duplicate: u64,
    /// It is late by up to 20 ms, so that others overtake it.
    pub delay: u64,
    /// A bit of it flips.
    pub flip: u64,
    /// A message that does not belong arrives before it.
    pub forge: u64,
    /// A snapshot or a checkpoint cannot be stored.
    pub disk: u64,
}

/// What does not belong about a forged message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forgery {
    /// It is of another run.
    Run,
    /// It is of an earlier incarnation.
    Epoch,
    /// It is from another participant (data) or another process of the same name (control).
    Sender,
    /// It belongs to a window far ahead.
    Future,
}

impl Forgery {
    /// One of them.
    pub fn any(random: &mut Random) -> Self {
        [Self::Run, Self::Epoch, Self::Sender, Self::Future][random.below(4) as usize]
    }
}

/// A frame like `frame`, valid in itself, with another payload, that does not belong.
pub(super) fn forged_frame(frame: &Frame, how: Forgery, random: &mut Random) -> Option<Frame> {
    let header = Header::read(frame).ok()?;
    let mut bytes = frame.as_ref().clone();
    // Another payload of the same shape: a finite number in place of the first one.
    if let Some(slot) = bytes.get_mut(HEADER_BYTES..HEADER_BYTES + 8) {
        slot.copy_from_slice(&(random.below(1000) as f64 * 1e-3).to_le_bytes());
    }
    let chunk_hash = xxh3_64(&bytes[HEADER_BYTES..]);
    let content = if header.chunks == 1 { xxh3_64(&chunk_hash.to_ne_bytes()) } else { header.content };
    let mut forged = Header { content, ..header };
    match how {
        Forgery::Run => forged.run[0] ^= 0xff,
        Forgery::Epoch => forged.epoch = forged.epoch.wrapping_sub(1),
        Forgery::Sender => forged.sender = forged.sender.wrapping_add(1),
        Forgery::Future => forged.index += 100 + random.below(1 << 20),
    }
    bytes[..HEADER_BYTES].copy_from_slice(bytemuck::bytes_of(&forged.sealed(chunk_hash)));
    Some(Arc::new(bytes))
}

/// A message to a participant that would end its run if it were believed.
pub(super) fn forged_down(bytes: &[u8], how: Forgery) -> Option<Vec<u8>> {
    let mut envelope = control::decode::<Down>(bytes).ok()?;
    envelope.body = Down::Abort { reason: "forged".to_owned() };
    spoil(&mut envelope, how)
}

/// A message to the coordinator that would end the run if it were believed.
pub(super) fn forged_up(bytes: &[u8], how: Forgery) -> Option<Vec<u8>> {
    let mut envelope = control::decode::<Up>(bytes).ok()?;
    if matches!(envelope.body, Up::Hello { .. }) {
        return None;
    }
    envelope.body = Up::Failed { kind: FailureKind::Physics, message: "forged".to_owned() };
    spoil(&mut envelope, how)
}

fn spoil<M: serde::Serialize>(envelope: &mut Envelope<M>, how: Forgery) -> Option<Vec<u8>> {
    match how {
        Forgery::Run => envelope.run[0] ^= 0xff,
        Forgery::Epoch => envelope.epoch = envelope.epoch.wrapping_sub(1),
        Forgery::Sender => envelope.instance ^= 1,
        Forgery::Future => return None,
    }
    Some(control::encode(envelope))
}

/// A request that nobody made, for something that never was.
pub(super) fn idle_request(run: [u8; 16], epoch: u32, random: &mut Random) -> Vec<u8> {
    let body = Resend { stream: random.below(64) as u16, index: random.below(1 << 20) };
    control::encode(&Envelope { protocol: PROTOCOL, run, epoch, instance: 0, body })
}

/// The same bytes with one bit changed.
pub(super) fn flipped(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if !bytes.is_empty() {
        let at = random.below(bytes.len() as u64) as usize;
        bytes[at] ^= 1 << random.below(8);
    }
    bytes
}
