//! `cosplat plugins`: what is found, and why a candidate is refused.

use cosplat_core::plugin::Descriptor;
use serde::Serialize;
use tokio::task::JoinSet;

use crate::cli::{Format, PluginsArgs};
use crate::exit::{Code, Error};
use crate::hint::count;
use crate::plugins::describe::{Refusal, describe};
use crate::plugins::discover::{Candidate, Places};
use crate::render::{Paint, json, print, printable, table};
use crate::supervise::signals::Signals;

/// A candidate and what became of it.
#[derive(Debug, Serialize)]
struct Found {
    name: String,
    place: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    descriptor: Option<Descriptor>,
    /// Why it is not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
}

/// Lists the plugins of this machine.
///
/// # Errors
/// The list cannot be printed.
pub(crate) async fn plugins(args: &PluginsArgs, signals: &mut Signals) -> Result<Code, Error> {
    let candidates = Places::of_this_program().all()?;
    let found = tokio::select! {
        found = ask_all(candidates) => found,
        _ = signals.next() => return Ok(Code::Interrupted),
    };
    match args.format {
        Format::Json => print(&json(&found)?)?,
        Format::Human => print(&human(&found, Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

/// Asks all candidates at once, because one that hangs takes seconds.
async fn ask_all(candidates: Vec<(Candidate, Option<String>)>) -> Vec<Found> {
    let mut asked = JoinSet::new();
    for (index, (candidate, hidden_by)) in candidates.iter().cloned().enumerate() {
        if hidden_by.is_none() {
            asked.spawn(async move { (index, describe(&candidate).await) });
        }
    }
    let mut answers: Vec<Option<Result<Descriptor, Refusal>>> = candidates.iter().map(|_| None).collect();
    while let Some(answer) = asked.join_next().await {
        if let Ok((index, answer)) = answer {
            answers[index] = Some(answer);
        }
    }
    let found = |((candidate, hidden_by), answer): ((Candidate, Option<String>), Option<_>)| {
        let hidden = hidden_by.map(|by| format!("hidden by {by}, which comes first"));
        let (descriptor, refused) = match answer {
            Some(Ok(descriptor)) => (Some(descriptor), hidden),
            Some(Err(refusal)) => (None, Some(Refusal::to_string(&refusal))),
            None => (None, hidden),
        };
        Found { place: candidate.place(), name: candidate.name, descriptor, refused }
    };
    candidates.into_iter().zip(answers).map(found).collect()
}

fn human(found: &[Found], paint: Paint) -> String {
    let usable: Vec<&Found> = found.iter().filter(|f| f.refused.is_none()).collect();
    let mut rows = vec![["plugin", "version", "materials", "found", ""].map(str::to_owned).to_vec()];
    for plugin in &usable {
        let Some(descriptor) = &plugin.descriptor else { continue };
        let materials = descriptor.materials.join(" ");
        let row = [&plugin.name, &descriptor.version, &materials, &plugin.place, &descriptor.summary];
        rows.push(row.map(|cell| printable(cell)).to_vec());
    }
    let table = table(paint, &rows);
    let refused: Vec<&Found> = found.iter().filter(|f| f.refused.is_some()).collect();
    if refused.is_empty() {
        return table;
    }
    let head = format!("\n{} not used:\n", count(refused.len(), "candidate", "candidates"));
    let lines = refused.iter().map(|Found { name, place, refused, .. }| {
        let why = refused.as_deref().unwrap_or_default();
        format!("  {} ({}): {}\n", paint.warn(&printable(name)), printable(place), printable(why))
    });
    [table, head].into_iter().chain(lines).collect()
}
