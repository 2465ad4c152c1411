//! What a seed stands for: who couples with whom, how, and what goes wrong.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use super::faults::Faults;
use super::random::Random;
use super::toy;
use crate::asset::{Asset, ParticleCloud};
use crate::plan::{self, ParticipantId, Plan};
use crate::plugin::SolverScene;
use crate::scene::read;

/// A blow that the run must answer with a named outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// None: the run must finish.
    None,
    /// A process is killed.
    Kill(ParticipantId),
    /// A process stops for ever.
    Freeze(ParticipantId),
    /// A process stops for a while, shorter than the limit: the run must finish.
    Pause(ParticipantId),
    /// The user stops the run.
    Stop,
    /// A participant computes with something else than it was sent, and says so.
    Lie(ParticipantId),
    /// A second process joins under a taken name: it must be refused and the run finish.
    Double(ParticipantId),
    /// Some processes are killed, the coordinator's perhaps among them; all are started again and go on from the newest
    /// checkpoint, perhaps to be killed again.
    Crash,
    /// The user stops the run and resumes it.
    Interrupt,
    /// All processes are killed, and the snapshot of one participant is spoiled before they are started again.
    Rot(ParticipantId),
}

impl Trouble {
    /// Whether the run has more than one life.
    pub(super) fn resumes(self) -> bool {
        matches!(self, Self::Crash | Self::Interrupt | Self::Rot(_))
    }
}

/// A run to simulate.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Where it comes from.
    pub seed: u64,
    /// Who couples with whom.
    pub plan: Plan,
    /// Parts of the scene.
    pub scenes: Vec<SolverScene>,
    /// What the bus does.
    pub faults: Faults,
    /// What happens beside.
    pub trouble: Trouble,
    /// When it happens \[µs\].
    pub trouble_at_us: u64,
    /// Windows between checkpoints.
    pub checkpoint_every: Option<u64>,
}

/// Windows of an ordinary scenario.
const WINDOWS: u64 = 200;

impl Scenario {
    /// The scenario of a seed.
    pub fn from_seed(seed: u64) -> Self {
        let mut random = Random::new(seed);
        // Large messages, cut into chunks, are rare because they are slow.
        let large = random.once_in(25);
        let (windows, samples) = if large { (12, 12_000) } else { (WINDOWS, 1 + random.below(3)) };
        let (plan, scenes) = loop {
            // A random choice of turns can have a circle, which the plan refuses: draw again.
            if let Some(made) = draw(&mut random, windows, samples) {
                break made;
            }
        };
        let participants = plan.participants.len() as u64;
        let who = random.below(participants) as ParticipantId;
        let trouble = match random.below(20) {
            0..=2 => Trouble::Kill(who),
            3 => Trouble::Freeze(who),
            4 => Trouble::Pause(who),
            5..=6 => Trouble::Stop,
            7 => Trouble::Lie(who),
            8 => Trouble::Double(who),
            9..=12 => Trouble::Crash,
            13 => Trouble::Interrupt,
            14..=16 => Trouble::Rot(who),
            _ => Trouble::None,
        };
        let mut rate = |choices: [u64; 4]| choices[random.below(4) as usize];
        let faults = Faults {
            loss: rate([0, 300, 60, 20]),
            duplicate: rate([0, 100, 20, 5]),
            delay: rate([0, 100, 20, 5]),
            flip: rate([0, 300, 100, 40]),
            forge: rate([0, 100, 30, 10]),
            disk: 0,
        };
        let trouble_at_us = 5_000 + random.below(200_000);
        let every = [1, 4, 15, 50][random.below(4) as usize];
        // A run that is resumed or stopped makes checkpoints; so do some others, to which it must make no difference.
        let saves = trouble.resumes() || trouble == Trouble::Stop || every == 4;
        let checkpoint_every = Some(every).filter(|_| saves);
        // What is to be resumed or spoiled should mostly be there.
        let later = match trouble {
            Trouble::Rot(_) => 50_000,
            Trouble::Crash => 25_000,
            _ => 0,
        };
        let trouble_at_us = trouble_at_us + later;
        let faults = Faults { disk: [0, 0, 30, 5][random.below(4) as usize], ..faults };
        Self { seed, plan, scenes, faults, trouble, trouble_at_us, checkpoint_every }
    }

    /// The same without faults, trouble and checkpoints.
    #[must_use]
    pub fn calm(&self) -> Self {
        Self { faults: Faults::default(), trouble: Trouble::None, checkpoint_every: None, ..self.clone() }
    }
}

fn cloud(points: usize) -> Asset {
    let position_m = (0..points).map(|i| [i as f64, points as f64, 0.5]).collect();
    Asset::Particles(ParticleCloud { spacing_m: 1.0, position_m, volume_m3: vec![1.0; points] })
}

/// Draws 3 to 5 solvers, contacts among some pairs, links among others.
fn draw(random: &mut Random, windows: u64, samples: u64) -> Option<(Plan, Vec<SolverScene>)> {
    let solvers = 3 + random.below(3);
    let contact = ["serial", "parallel"][random.below(2) as usize];
    let link = ["serial", "parallel", "alternating", "centred"][random.below(4) as usize];
    let rule = ["hold", "linear", "hermite"][random.below(3) as usize];
    let mut text = format!(
        "format = 1\nname = \"sim\"\ntitle = \"a simulated bus\"\n[clock]\nduration = 1.0\nwindow = {}\n\
         contact_scheme = \"{contact}\"\nlink_scheme = \"{link}\"\nmotion_rule = \"{rule}\"\n",
        1.0 / windows as f64
    );
    if random.once_in(2) {
        // Frames, drawn by a recorder.
        let every = 1 + random.below(4);
        let _ = writeln!(text, "fps = {}\n[output]\nsplats = false", windows as f64 / every as f64);
    }
    for i in 0..solvers {
        let plugin = if random.once_in(3) { toy::RIGID } else { "toy" };
        let _ = writeln!(text, "[solver.p{i}]\nplugin = \"{plugin}\"");
    }
    for i in 0..solvers {
        let _ = writeln!(
            text,
            "[[body]]\nname = \"b{i}\"\nsolver = \"p{i}\"\nmaterial = \"point-mass\"\nmass = 1.0\n\
             cloud = {{ count = {samples}, size = [1.0, 1.0, 1.0] }}"
        );
    }
    for i in 0..solvers {
        for j in i + 1..solvers {
            // A link needs no contact beside it; the others mostly touch, and some solvers stand alone.
            match random.below(4) {
                0 => {
                    let _ =
                        writeln!(text, "[[link]]\nname = \"l{i}-{j}\"\na = \"b{i}\"\nb = \"b{j}\"\nstiffness = 1.0");
                    let _ = writeln!(text, "[[pair]]\na = \"b{i}\"\nb = \"b{j}\"\nenabled = false");
                }
                1 => {
                    let _ = writeln!(text, "[[pair]]\na = \"b{i}\"\nb = \"b{j}\"\nenabled = false");
                }
                _ => {}
            }
        }
    }
    let scene = read::parse(&text).ok()?.0;
    let descriptors = [toy::descriptor(), toy::rigid_descriptor()].map(|d| (d.name.clone(), d));
    let descriptors = BTreeMap::from(descriptors);
    let (plan, mut scenes) = plan::build(&scene, &descriptors, 2).ok()?;
    for scene in &mut scenes {
        for i in 0..random.below(3) {
            // With large messages come assets of several chunks.
            let points = 1 + random.below(2 * samples) as usize;
            scene.assets.insert(format!("asset{i}"), Arc::new(cloud(points)));
        }
    }
    Some((plan, scenes))
}
