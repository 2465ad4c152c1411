//! Makes the runs of a study: the first of each side by side, each repetition alone, because times are taken.

use std::collections::BTreeMap;
use std::path::PathBuf;

use tokio::sync::watch;
use tokio::task::JoinSet;

use super::conduct::{Conditions, News};
use super::outcome::Class;
use super::trial::{self, Order, Trial};
use crate::exit::{Code, Error, Problem};
use crate::supervise::signals::Signals;

/// A combination of what is varied that is to be run.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    /// Scene file or name of a built-in scene.
    pub(super) scene: String,
    /// Changes of the scene, as `--set` takes them.
    pub(super) overrides: Vec<String>,
    /// Holds the run folders of its repetitions.
    pub(super) folder: PathBuf,
    /// For people: its case, its place in it, and what is varied.
    pub(super) name: String,
}

/// The repetitions of every combination, in their order; none where the user has stopped it.
pub(super) async fn carry_out(
    wanted: &[Wanted],
    conditions: Conditions<'_>,
    signals: &mut Signals,
    tell: &mut impl FnMut(News),
) -> Result<Option<Vec<Vec<Trial>>>, Error> {
    // What several cases want is made once.
    let mut places = BTreeMap::new();
    let unique: Vec<&Wanted> = wanted
        .iter()
        .filter(|one| {
            let next = places.len();
            let mut is_new = false;
            places.entry(&one.folder).or_insert_with(|| {
                is_new = true;
                next
            });
            is_new
        })
        .collect();
    let all: Vec<usize> = (0..unique.len()).collect();
    let mut trials = vec![Vec::new(); unique.len()];
    for number in 1..=conditions.runs {
        let jobs = if number == 1 { conditions.jobs } else { 1 };
        // What has no result takes no time worth measuring.
        let is_worth_it = |trials: &Vec<Trial>| {
            trials.first().is_none_or(|first| matches!(first.class(), Class::Correct | Class::Degraded))
        };
        let chosen: Vec<usize> = all.iter().copied().filter(|&i| is_worth_it(&trials[i])).collect();
        let Some(made) = round(&unique, &chosen, number, jobs, signals, tell).await? else { return Ok(None) };
        for (i, trial) in made {
            trials[i].push(trial);
        }
    }
    Ok(Some(wanted.iter().map(|one| trials[places[&one.folder]].clone()).collect()))
}

/// One repetition of the chosen ones, so many at once.
async fn round(
    unique: &[&Wanted],
    chosen: &[usize],
    number: usize,
    jobs: usize,
    signals: &mut Signals,
    tell: &mut impl FnMut(News),
) -> Result<Option<BTreeMap<usize, Trial>>, Error> {
    let share = (jobs > 1).then(|| (super::conduct::cores() / jobs).max(1));
    let (stop, stopped) = watch::channel(0_u32);
    let mut waiting = chosen.iter().copied();
    let mut running = JoinSet::new();
    let mut made = BTreeMap::new();
    loop {
        while running.len() < jobs && *stop.borrow() == 0 {
            let Some(i) = waiting.next() else { break };
            let place = unique[i].folder.join(number.to_string());
            if number == 1 {
                tell(News::Begins(unique[i].name.clone()));
            }
            if let Some(kept) = Trial::kept(&place, jobs == 1) {
                tell(News::Ended(unique[i].name.clone(), kept.class(), true));
                made.insert(i, kept);
                continue;
            }
            let order = Order { scene: unique[i].scene.clone(), overrides: unique[i].overrides.clone(), place, share };
            let stopped = stopped.clone();
            running.spawn(async move { (i, trial::run(order, stopped).await) });
        }
        tokio::select! {
            ended = running.join_next() => match ended {
                None => break,
                Some(Ok((i, trial))) => {
                    if let Some(trial) = trial? {
                        tell(News::Ended(unique[i].name.clone(), trial.class(), false));
                        made.insert(i, trial);
                    }
                }
                Some(Err(error)) => {
                    let problem = Problem::new("A run of the study was lost").because(error);
                    return Err(Error::new(Code::Environment, problem));
                }
            },
            _ = signals.next() => stop.send_modify(|times| *times += 1),
        }
    }
    let was_stopped = *stop.borrow() > 0;
    Ok((!was_stopped).then_some(made))
}
