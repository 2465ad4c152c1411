//! Prepared geometry on its way to participants: encoded once, cut into chunks, sent when asked for.

use super::{Action, Coordinator, Failure, Phase};
use crate::checks::Checks;
use crate::control::{ASSET_CHUNK_BYTES, AssetInfo, Down, asset_hash};
use crate::plan::ParticipantId;
use crate::plugin::SolverScene;

/// What one participant may fetch.
#[derive(Debug, Default)]
pub(super) struct Shipment {
    pub(super) infos: Vec<AssetInfo>,
    bytes: Vec<Vec<u8>>,
}

impl Shipment {
    /// Takes the assets out of a scene: from here on they travel on their own.
    pub(super) fn unload(scene: &mut SolverScene) -> Self {
        let mut shipment = Self::default();
        for (name, asset) in std::mem::take(&mut scene.assets) {
            // Lists of numbers always have a form in bytes; an empty one would be refused by the participant.
            let bytes = postcard::to_stdvec(&*asset).unwrap_or_default();
            shipment.infos.push(AssetInfo { name, bytes: bytes.len() as u64, hash: asset_hash(&bytes) });
            shipment.bytes.push(bytes);
        }
        shipment
    }

    fn chunk(&self, asset: u16, chunk: u32) -> Option<Vec<u8>> {
        self.bytes.get(usize::from(asset))?.chunks(ASSET_CHUNK_BYTES as usize).nth(chunk as usize).map(<[u8]>::to_vec)
    }
}

impl<C: Checks> Coordinator<C> {
    pub(super) fn on_fetch(&mut self, who: ParticipantId, asset: u16, chunk: u32, out: &mut Vec<Action>) {
        if self.phase != Phase::Joining {
            return;
        }
        let Some(bytes) = self.shipments.get(usize::from(who)).and_then(|s| s.chunk(asset, chunk)) else {
            let message = format!("it asked for chunk {chunk} of geometry {asset}, which there is not");
            let who = self.plan.name_of(who).to_owned();
            return self.fail(Failure::Protocol { who, window: 0, message }, out);
        };
        out.push(self.send(who, Down::Chunk { asset, chunk, bytes }));
    }
}
