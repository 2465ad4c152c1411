//! Fetching prepared geometry from the coordinator, chunk by chunk, before the plugin is set up.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use super::{Action, Participant, Phase};
use crate::asset::Asset;
use crate::checks::Checks;
use crate::control::{ASSET_CHUNK_BYTES, AssetInfo, FailureKind, Up, asset_hash};

/// Chunks that are asked for and not there yet, at most.
const AT_ONCE: u32 = 8;

/// What is still to be fetched.
#[derive(Debug, Default)]
pub(super) struct Fetch {
    wanted: Vec<AssetInfo>,
    /// Number of the asset at hand.
    at: usize,
    /// Its chunks that are there.
    chunks: BTreeMap<u32, Vec<u8>>,
    /// First of its chunks that has not been asked for.
    next: u32,
    whole: BTreeMap<String, Arc<Asset>>,
}

impl Fetch {
    pub(super) fn new(wanted: Vec<AssetInfo>) -> Self {
        Self { wanted, ..Self::default() }
    }

    fn current(&self) -> Option<&AssetInfo> {
        self.wanted.get(self.at)
    }

    /// Chunks that should be asked for now and have not been.
    fn more(&mut self) -> Vec<u32> {
        let Some(chunks) = self.current().map(AssetInfo::chunks) else { return Vec::new() };
        let arrived = self.chunks.len() as u32;
        let until = chunks.min(arrived + AT_ONCE);
        let asked = self.next..until.max(self.next);
        self.next = asked.end;
        asked.collect()
    }

    /// Chunks that were asked for and are not there.
    fn missing(&self) -> Vec<u32> {
        (0..self.next).filter(|chunk| !self.chunks.contains_key(chunk)).collect()
    }

    /// Takes a chunk; true where it was of use.
    fn take(&mut self, asset: u16, chunk: u32, bytes: Vec<u8>) -> bool {
        let fits = self.current().is_some_and(|info| usize::from(asset) == self.at && info.chunk_fits(chunk, &bytes));
        fits && self.chunks.insert(chunk, bytes).is_none()
    }

    /// Puts the asset at hand together if all of it is there, and turns to the next.
    fn finish_one(&mut self) -> Result<(), String> {
        let Some(info) = self.current().cloned() else { return Ok(()) };
        if self.chunks.len() as u32 != info.chunks() {
            return Ok(());
        }
        let bytes = std::mem::take(&mut self.chunks).into_values().flatten().collect::<Vec<u8>>();
        let broken = |why: &str| format!("the geometry of `{}` arrived broken: {why}", info.name);
        if asset_hash(&bytes) != info.hash {
            return Err(broken("its hash does not match"));
        }
        let asset: Asset = postcard::from_bytes(&bytes).map_err(|e| broken(&e.to_string()))?;
        asset.check().map_err(|e| broken(&e.to_string()))?;
        self.whole.insert(info.name, Arc::new(asset));
        (self.at, self.next) = (self.at + 1, 0);
        Ok(())
    }
}

impl<C: Checks> Participant<C> {
    pub(super) fn on_chunk(&mut self, asset: u16, chunk: u32, bytes: Vec<u8>, now: Duration, out: &mut Vec<Action>) {
        if self.phase != Phase::Fetching || !self.fetch.take(asset, chunk, bytes) {
            return;
        }
        // More is on its way: it is too early to ask for it again.
        self.asked_at = now;
        match self.fetch.finish_one() {
            Ok(()) => self.fetch_more(out),
            Err(why) => self.fail(FailureKind::Bus, why, now, out),
        }
    }

    /// Asks for what comes next, or sets the plugin up when nothing is left.
    pub(super) fn fetch_more(&mut self, out: &mut Vec<Action>) {
        if self.fetch.current().is_none() {
            return self.load_or_set_up(out);
        }
        let more = self.fetch.more();
        self.request_chunks(more, out);
    }

    /// Asks again for what has not come.
    pub(super) fn fetch_again(&self, out: &mut Vec<Action>) {
        self.request_chunks(self.fetch.missing(), out);
    }

    fn request_chunks(&self, chunks: Vec<u32>, out: &mut Vec<Action>) {
        let asset = self.fetch.at as u16;
        out.extend(chunks.into_iter().map(|chunk| self.envelope(Up::Fetch { asset, chunk })));
    }

    pub(super) fn set_up(&mut self, out: &mut Vec<Action>) {
        self.phase = Phase::SettingUp;
        let assets = std::mem::take(&mut self.fetch.whole);
        let Some(joined) = &mut self.joined else { return };
        joined.scene.assets = assets;
        let shown = joined.shown_bodies();
        out.push(Action::SetUp(Box::new(joined.scene.clone()), shown));
    }
}

impl AssetInfo {
    /// Number of its chunks.
    pub fn chunks(&self) -> u32 {
        (self.bytes.div_ceil(ASSET_CHUNK_BYTES)) as u32
    }

    /// Whether a chunk of that number has the right length.
    fn chunk_fits(&self, chunk: u32, bytes: &[u8]) -> bool {
        let from = u64::from(chunk) * ASSET_CHUNK_BYTES;
        chunk < self.chunks() && bytes.len() as u64 == (self.bytes - from).min(ASSET_CHUNK_BYTES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asset::ParticleCloud;

    fn cloud(points: usize) -> Asset {
        let position_m: Vec<[f64; 3]> = (0..points).map(|i| [i as f64, 0.5, -0.25]).collect();
        Asset::Particles(ParticleCloud { spacing_m: 0.1, volume_m3: vec![1e-3; points], position_m })
    }

    fn packed(asset: &Asset) -> (AssetInfo, Vec<Vec<u8>>) {
        let bytes = postcard::to_stdvec(asset).unwrap();
        let chunks = bytes.chunks(ASSET_CHUNK_BYTES as usize).map(<[u8]>::to_vec).collect();
        (AssetInfo { name: "rock".into(), bytes: bytes.len() as u64, hash: asset_hash(&bytes) }, chunks)
    }

    #[test]
    fn an_asset_arrives_whole_from_chunks_in_any_order_and_twice() {
        let asset = cloud(100_000);
        let (info, chunks) = packed(&asset);
        assert!(chunks.len() > AT_ONCE as usize + 1, "more than are asked for at once");
        let mut fetch = Fetch::new(vec![info]);
        assert_eq!(fetch.more().len(), AT_ONCE as usize);
        for (i, chunk) in chunks.iter().enumerate().rev() {
            assert!(fetch.take(0, i as u32, chunk.clone()));
            assert!(!fetch.take(0, i as u32, chunk.clone()), "a chunk counts once");
            fetch.finish_one().unwrap();
        }
        assert_eq!(fetch.whole.get("rock").map(|a| (**a).clone()), Some(asset));
        assert!(fetch.current().is_none());
    }

    #[test]
    fn what_does_not_fit_is_not_taken_and_what_is_broken_is_said() {
        let (info, chunks) = packed(&cloud(2));
        let mut fetch = Fetch::new(vec![info]);
        fetch.more();
        assert_eq!(fetch.missing(), [0]);
        assert!(!fetch.take(1, 0, chunks[0].clone()) && !fetch.take(0, 1, chunks[0].clone()));
        assert!(!fetch.take(0, 0, chunks[0][1..].to_vec()));
        let mut broken = chunks[0].clone();
        *broken.last_mut().unwrap() ^= 1;
        assert!(fetch.take(0, 0, broken));
        let why = fetch.finish_one().unwrap_err();
        assert_eq!(why, "the geometry of `rock` arrived broken: its hash does not match");
    }
}
