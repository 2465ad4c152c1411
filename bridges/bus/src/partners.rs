//! Who meets whom directly, and with what secret.

use cosplat_core::plan::{ParticipantId, Plan};

use crate::credentials::{RunFolder, new_password};
use crate::error::BusError;
use crate::ticket::{Door, Partner};

/// Participants that share a stream, the one that listens first; each pair once, in order.
fn pairs(plan: &Plan) -> Vec<(ParticipantId, ParticipantId)> {
    let ends = plan.streams.iter().flat_map(|s| s.to.iter().map(move |&to| (s.from.min(to), s.from.max(to))));
    let mut pairs: Vec<_> = ends.filter(|(first, second)| first != second).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Gives each two participants that share a stream an address and a password of their own, so that what one pair knows
/// opens no other door. Answers the partners of each participant, in plan order.
///
/// # Errors
/// [`BusError::Folder`], [`BusError::Random`].
pub fn introduce(plan: &Plan, folder: &RunFolder) -> Result<Vec<Vec<Partner>>, BusError> {
    let mut partners = vec![Vec::new(); plan.participants.len()];
    for pair in pairs(plan) {
        let (first, second) = pair;
        let (endpoint, password) = (folder.pair_endpoint(pair), new_password()?);
        let list = folder.write_pair(pair, plan.name_of(second), &password)?;
        let mut tell = |who: ParticipantId, of: ParticipantId, door: Door| {
            if let Some(known) = partners.get_mut(usize::from(who)) {
                known.push(Partner { name: plan.name_of(of).to_owned(), endpoint: endpoint.clone(), door });
            }
        };
        tell(first, second, Door::Open(list.display().to_string()));
        tell(second, first, Door::Enter(password));
    }
    Ok(partners)
}
