//! Everything between a scene and a run: reading, changes, plugins, plan.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::thread::available_parallelism;

use cosplat_core::plan::{BoundaryForm, Plan, Refusal, build, plugin_of};
use cosplat_core::plugin::{Descriptor, SolverScene};
use cosplat_core::scene::{Scene, SolverSpec};

use crate::cli::SceneArgs;
use crate::exit::{Code, Error, Problem};
use crate::folder::record::PluginRecord;
use crate::geometry::{self, Geometry};
use crate::hint::{list, near_miss};
use crate::plugins::describe::describe;
use crate::plugins::discover::{Candidate, Places};
use crate::render::Paint;
use crate::rigidify::{self, Decisions, Estimate, rigidify};
use crate::scene_place;
use crate::scene_source::{self, Source};
use crate::stiffness;

/// A scene that can run.
pub(crate) struct Prepared {
    /// Where the scene is from.
    pub(crate) source: Source,
    /// The scene with all changes.
    pub(crate) scene: Scene,
    /// What is allowed but odd about it.
    pub(crate) warnings: Vec<Problem>,
    /// What each process runs, by its name.
    pub(crate) plugins: Plugins,
    /// Who runs, what couples, when.
    pub(crate) plan: Plan,
    /// Each participant's part of the scene, in plan order.
    pub(crate) scenes: Vec<SolverScene>,
    /// Bodies that stay deformable, and why.
    pub(crate) kept: Vec<Estimate>,
    /// What was made of its files and shapes.
    pub(crate) geometry: Geometry,
}

impl Prepared {
    /// Command of each participant, in plan order, program first.
    pub(crate) fn commands(&self) -> Vec<Vec<OsString>> {
        self.per_participant(|candidate, _| candidate.command.clone())
    }

    /// Form in which each participant shows its bodies, in plan order.
    pub(crate) fn forms(&self) -> Vec<BoundaryForm> {
        self.per_participant(|_, descriptor| descriptor.boundary)
    }

    fn per_participant<T>(&self, of: impl Fn(&Candidate, &Descriptor) -> T) -> Vec<T> {
        // The plan was built from these plugins, so none is missing.
        let plugins = self.plan.participants.iter().filter_map(|p| self.plugins.get(&p.name));
        plugins.map(|(candidate, descriptor)| of(candidate, descriptor)).collect()
    }

    /// The plugins for the record of the run.
    pub(crate) fn plugin_records(&self) -> Vec<PluginRecord> {
        let record = |(process, (candidate, descriptor)): (&String, &(Candidate, Descriptor))| PluginRecord {
            process: process.clone(),
            name: descriptor.name.clone(),
            version: descriptor.version.clone(),
            command: candidate.command.iter().map(|w| w.to_string_lossy().into_owned()).collect(),
        };
        self.plugins.iter().map(record).collect()
    }
}

/// Changes and plans a scene.
///
/// # Errors
/// Everything that is wrong with it, as far as it can be told at once.
pub(crate) async fn prepare(source: Source, changes: &SceneArgs, paint: Paint) -> Result<Prepared, Error> {
    let (mut scene, mut warnings) = scene_source::parse(&source, &changes.set, paint)?;
    for (key, plugin) in &changes.solver {
        swap_plugin(&mut scene, key, plugin)?;
    }
    if let Some(threads) = changes.threads {
        scene.run.threads = Some(usize::from(threads));
    }
    if changes.live {
        show_live(&mut scene)?;
    }
    let folder = source.file.as_deref().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
    let folder = std::path::absolute(&folder).unwrap_or(folder);
    let Decisions { left_out, mut kept } = rigidify(&mut scene, |body| geometry::extent(body, &source));
    warnings.extend(stiffness::split(&mut scene));
    let plugins = find_plugins(&scene, &folder).await?;
    let cores = available_parallelism().map_or(1, usize::from);
    let refused = |refusals: Vec<Refusal>| {
        let problem = |refusal| scene_place::problem_of(paint, &source, refusal);
        Error { code: Code::Scene, problems: refusals.iter().map(problem).collect() }
    };
    let (mut plan, mut scenes) = build(&scene, &descriptors(&plugins)?, cores).map_err(refused)?;
    let visual = |process: &str| plugins.get(process).and_then(|(_, descriptor)| descriptor.visual);
    let geometry = Geometry::load(&scene, &source, visual).map_err(refused)?;
    geometry.hand_out(&mut scenes);
    plan.left_out.extend(left_out);
    kept.extend(rigidify::of_captures(&scene, |body| geometry.extent(body, &source)));
    Ok(Prepared { source, scene, warnings, plugins, plan, scenes, kept, geometry })
}

/// Lets frames be shown while the run goes on.
fn show_live(scene: &mut Scene) -> Result<(), Error> {
    if scene.clock.frames_per_second.is_none() {
        let problem = Problem::new(format!("Scene `{}` has no frames to show", scene.name));
        let problem = problem.because("frames are taken at the rate `clock.fps`, which it does not set");
        return Err(Error::new(Code::Usage, problem.hint("add `--set clock.fps=24`")));
    }
    scene.output.live = true;
    Ok(())
}

/// What each process runs, by its name.
type Plugins = BTreeMap<String, (Candidate, Descriptor)>;

/// Finds and asks the plugins of all processes that have bodies, and reports all that cannot be used.
async fn find_plugins(scene: &Scene, folder: &Path) -> Result<Plugins, Error> {
    let places = Places::of_this_program();
    let mut plugins = Plugins::new();
    let mut failed: Vec<Problem> = Vec::new();
    let mut processes: Vec<&str> = scene.bodies.iter().map(|b| b.solver.as_str()).collect();
    processes.sort_unstable();
    processes.dedup();
    for process in processes {
        let plugin = plugin_of(scene, process);
        let candidate = match scene.solvers.get(process).and_then(|s| s.command.as_deref()) {
            Some(words) => Candidate::of_scene(plugin, words, folder),
            None => match places.find(plugin) {
                Ok(candidate) => candidate,
                Err(error) => {
                    failed.extend(error.problems);
                    continue;
                }
            },
        };
        // Many processes may run the same plugin; one answer is enough.
        let known = plugins.values().find(|(c, _)| *c == candidate).map(|(_, descriptor)| descriptor.clone());
        let answer = match known {
            Some(descriptor) => Ok(descriptor),
            None => describe(&candidate).await,
        };
        match answer {
            Ok(descriptor) => drop(plugins.insert(process.to_owned(), (candidate, descriptor))),
            Err(refusal) => failed.extend(refusal.into_error(&candidate).problems),
        }
    }
    failed.dedup();
    if failed.is_empty() { Ok(plugins) } else { Err(Error { code: Code::Environment, problems: failed }) }
}

/// Descriptors by the name of their plugin.
///
/// # Errors
/// Two processes start what they call the same plugin, and it is not.
fn descriptors(plugins: &Plugins) -> Result<BTreeMap<String, Descriptor>, Error> {
    let mut by_name: BTreeMap<String, (&Candidate, &Descriptor)> = BTreeMap::new();
    for (candidate, descriptor) in plugins.values() {
        let (known, first) = by_name.entry(candidate.name.clone()).or_insert((candidate, descriptor));
        if *first != descriptor {
            let problem = Problem::new(format!("Two processes run different plugins as `{}`", candidate.name))
                .because(known.place())
                .because(candidate.place())
                .hint("give one of them another name with `plugin = \"…\"` in its `[solver.NAME]`");
            return Err(Error::new(Code::Scene, problem));
        }
    }
    Ok(by_name.into_iter().map(|(name, (_, descriptor))| (name, descriptor.clone())).collect())
}

/// Gives other plugins to what goes by `key`: a body, a material, a process, or a plugin, in this order.
fn swap_plugin(scene: &mut Scene, key: &str, plugin: &str) -> Result<(), Error> {
    let selected: Vec<bool> = {
        let by_name = |n: &str| scene.bodies.iter().any(|b| b.name == n);
        let by_material = |n: &str| scene.bodies.iter().any(|b| b.material.name() == n);
        let by_process = |n: &str| scene.bodies.iter().any(|b| b.solver == n);
        let chosen: Box<dyn Fn(&cosplat_core::scene::Body) -> bool> = if by_name(key) {
            Box::new(|b| b.name == key)
        } else if by_material(key) {
            Box::new(|b| b.material.name() == key)
        } else if by_process(key) {
            Box::new(|b| b.solver == key)
        } else {
            Box::new(|b| plugin_of(scene, &b.solver) == key)
        };
        scene.bodies.iter().map(chosen).collect()
    };
    if !selected.contains(&true) {
        return Err(nothing_selected(scene, key, plugin));
    }
    let mut processes: Vec<String> =
        scene.bodies.iter().zip(&selected).filter(|(_, s)| **s).map(|(b, _)| b.solver.clone()).collect();
    processes.sort();
    processes.dedup();
    for process in processes {
        let is_whole = scene.bodies.iter().zip(&selected).all(|(b, s)| *s || b.solver != process);
        if is_whole && let Some(spec) = scene.solvers.get_mut(&process) {
            spec.plugin = Some(plugin.to_owned());
            spec.command = None;
            continue;
        }
        let moved = new_process(scene, &process, plugin);
        for (body, selected) in scene.bodies.iter_mut().zip(&selected) {
            if *selected && body.solver == process {
                body.solver.clone_from(&moved);
            }
        }
    }
    Ok(())
}

/// Process for bodies that leave theirs: the one named after the plugin, or a new one if that name means another.
fn new_process(scene: &mut Scene, old: &str, plugin: &str) -> String {
    if plugin_of(scene, plugin) == plugin {
        return plugin.to_owned();
    }
    let name = format!("{old}-{plugin}");
    let spec = SolverSpec { plugin: Some(plugin.to_owned()), command: None, params: serde_json::Map::new() };
    scene.solvers.insert(name.clone(), spec);
    name
}

fn nothing_selected(scene: &Scene, key: &str, plugin: &str) -> Error {
    let mut names: Vec<&str> = Vec::new();
    for body in &scene.bodies {
        names.extend([body.name.as_str(), body.material.name(), &body.solver, plugin_of(scene, &body.solver)]);
    }
    names.sort_unstable();
    names.dedup();
    let problem = Problem::new(format!("`--solver {key}={plugin}` selects nothing in scene `{}`", scene.name))
        .because(format!("bodies, materials, processes and plugins of the scene are {}", list(names.iter().copied())));
    let problem = match near_miss(key, names.iter().copied()) {
        Some(near) => problem.hint(format!("did you mean `--solver {near}={plugin}`?")),
        None => problem.hint("name a body, a material, a process or a plugin of the scene"),
    };
    Error::new(Code::Usage, problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swapped(scene: &str, key: &str) -> Scene {
        let source = scene_source::load(scene).unwrap();
        let (mut scene, _) = scene_source::parse(&source, &[], Paint::off()).unwrap();
        swap_plugin(&mut scene, key, "mine").unwrap();
        scene
    }

    fn plugins(scene: &Scene) -> Vec<(&str, &str)> {
        scene.bodies.iter().map(|b| (b.solver.as_str(), plugin_of(scene, &b.solver))).collect()
    }

    #[test]
    fn a_body_alone_in_its_process_keeps_the_process() {
        assert_eq!(plugins(&swapped("oscillator", "left")), [("left", "mine"), ("right", "oscillator")]);
    }

    #[test]
    fn a_material_and_a_plugin_select_all_their_bodies() {
        let both = [("left", "mine"), ("right", "mine")];
        assert_eq!(plugins(&swapped("oscillator", "point-mass")), both);
        assert_eq!(plugins(&swapped("oscillator", "oscillator")), both);
    }

    #[test]
    fn a_body_among_others_moves_to_a_process_of_the_plugin() {
        assert_eq!(plugins(&swapped("two-tops", "top")), [("mine", "mine"), ("rigid-lite", "rigid-lite")]);
        assert_eq!(plugins(&swapped("two-tops", "rigid")), [("mine", "mine"), ("mine", "mine")]);
    }

    #[test]
    fn a_name_that_selects_nothing_is_a_usage_error_with_a_near_miss() {
        let source = scene_source::load("oscillator").unwrap();
        let (mut scene, _) = scene_source::parse(&source, &[], Paint::off()).unwrap();
        let error = swap_plugin(&mut scene, "lef", "mine").unwrap_err();
        assert_eq!(error.code, Code::Usage);
        assert_eq!(error.problems[0].hint.as_deref(), Some("did you mean `--solver left=mine`?"));
    }
}
