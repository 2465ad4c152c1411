//! Bodies of one process share its substep, which the fastest wave binds: a stiff body drags the soft ones.
//!
//! A process whose solver has `split_by_stiffness` is cut into classes of wave speeds before anything is planned; the
//! bodies of other classes are then partners, and each process takes the substeps that its own bodies need. Without it a
//! scene is told what a stiff body costs the others.

use std::cmp::Ordering;

use cosplat_core::plan::plugin_of;
use cosplat_core::scene::{Scene, SolverSpec};
use serde_json::Value;

use crate::exit::Problem;

/// Parameter of a solver: largest ratio of wave speeds within one process.
const PARAM: &str = "split_by_stiffness";
/// Solvers whose bodies share a substep that a wave binds, and that compute contact with each other.
const SOLVERS: [&str; 2] = ["mpm", "mpm-f64"];
/// Substeps over those that the softest body needs from which on a scene is told.
const DRAGS: f64 = 4.0;

/// Splits processes as the scene asks, and says which stiff bodies drag others.
pub(crate) fn split(scene: &mut Scene) -> Vec<Problem> {
    let mut processes: Vec<String> = scene.bodies.iter().map(|b| b.solver.clone()).collect();
    processes.sort_unstable();
    processes.dedup();
    processes.retain(|process| SOLVERS.contains(&plugin_of(scene, process)));
    let mut told = Vec::new();
    for process in processes {
        let params = scene.solvers.get(&process).map(|s| &s.params);
        let limit = params.and_then(|p| p.get(PARAM)).and_then(Value::as_f64).filter(|limit| *limit >= 1.0);
        match limit {
            Some(limit) => cut(scene, &process, limit),
            None => told.extend(dragged(scene, &process)),
        }
    }
    told
}

/// Bodies of a process with their wave speeds \[m/s\], the slowest first.
fn waves(scene: &Scene, process: &str) -> Vec<(usize, f64)> {
    let own = scene.bodies.iter().enumerate().filter(|(_, b)| b.solver == process);
    let mut waves: Vec<(usize, f64)> = own.filter_map(|(i, b)| Some((i, b.wave_speed_m_s()?))).collect();
    waves.sort_by(|a, b| a.1.partial_cmp(&b.1).unwrap_or(Ordering::Equal));
    waves
}

/// Gives each class of wave speeds but the slowest a process of its own. Bodies that are bonded stay together.
fn cut(scene: &mut Scene, process: &str, limit: f64) {
    let waves = waves(scene, process);
    let (mut class, mut slowest) = (vec![0; scene.bodies.len()], f64::INFINITY);
    let mut classes = 0;
    for &(body, speed) in &waves {
        // A speed of nothing has no ratio: it is a class of its own.
        if slowest.is_infinite() || speed > limit * slowest {
            (classes, slowest) = (classes + 1, speed);
        }
        class[body] = classes - 1;
    }
    for _ in 0..classes {
        for [a, b] in bonded(scene, process) {
            let least = class[a].min(class[b]);
            (class[a], class[b]) = (least, least);
        }
    }
    for k in 1..classes {
        let name = free_name(scene, process);
        let members: Vec<usize> = waves.iter().map(|w| w.0).filter(|&i| class[i] == k).collect();
        if members.is_empty() {
            continue;
        }
        let plugin = Some(plugin_of(scene, process).to_owned());
        let spec = scene.solvers.get(process).cloned();
        let (command, params) = spec.map(|s| (s.command, s.params)).unwrap_or_default();
        scene.solvers.insert(name.clone(), SolverSpec { plugin, command, params });
        for i in members {
            scene.bodies[i].solver.clone_from(&name);
        }
    }
}

/// Pairs of bodies that stick together in a process, by their places in the scene.
fn bonded(scene: &Scene, process: &str) -> Vec<[usize; 2]> {
    let params = scene.solvers.get(process).map(|s| &s.params);
    let pairs = params.and_then(|p| p.get("bonded")).and_then(Value::as_array);
    let place = |name: Option<&Value>| scene.bodies.iter().position(|b| name.and_then(Value::as_str) == Some(&b.name));
    let pair = |pair: &Value| Some([place(pair.get(0))?, place(pair.get(1))?]);
    pairs.into_iter().flatten().filter_map(pair).collect()
}

/// A name for another process of that kind.
fn free_name(scene: &Scene, process: &str) -> String {
    let taken = |name: &str| scene.solvers.contains_key(name) || scene.bodies.iter().any(|b| b.solver == name);
    let mut number = 2;
    while taken(&format!("{process}-{number}")) {
        number += 1;
    }
    format!("{process}-{number}")
}

/// What the stiffest body of a process costs the others.
fn dragged(scene: &Scene, process: &str) -> Option<Problem> {
    let waves = waves(scene, process);
    let (&(soft, slow), &(stiff, fast)) = (waves.first()?, waves.last()?);
    let times = fast / slow;
    let [soft, stiff] = [soft, stiff].map(|i| &scene.bodies[i].name);
    if !(times.is_finite() && times >= DRAGS) {
        return None;
    }
    let what = format!("process `{process}` takes {times:.0} times the substeps that `{soft}` needs");
    let why =
        format!("they share the substep of the fastest wave: {fast:.0} m/s in `{stiff}`, {slow:.0} m/s in `{soft}`");
    let help = format!("`solver.{process}.params.{PARAM} = {DRAGS}` gives stiff bodies a process of their own");
    Some(Problem::new(format!("`{stiff}` drags `{soft}`: {what}")).because(why).hint(help))
}

#[cfg(test)]
mod tests {
    use cosplat_core::scene::read::parse;

    use super::*;

    const SCENE: &str = r#"
format = 1
name = "classes"
title = "Three blocks"
[clock]
duration = 1
[[body]]
name = "jelly"
material = { kind = "elastic", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
solver = "mpm"
box = [0.1, 0.1, 0.1]
[[body]]
name = "rubber"
material = { kind = "elastic", density = 1000, youngs_modulus = 9e5, poissons_ratio = 0.3 }
solver = "mpm"
box = [0.1, 0.1, 0.1]
position = [0, 0, 1]
[[body]]
name = "plate"
material = { kind = "elastic", density = 1000, youngs_modulus = 6.4e6, poissons_ratio = 0.3 }
solver = "mpm"
box = [0.1, 0.1, 0.1]
position = [0, 0, 2]
"#;

    fn processes(params: &str) -> (Vec<String>, Vec<Problem>) {
        let (mut scene, _) = parse(&format!("{SCENE}\n[solver.mpm.params]\n{params}")).expect("a scene");
        let told = split(&mut scene);
        (scene.bodies.into_iter().map(|b| b.solver).collect(), told)
    }

    #[test]
    fn classes_of_stiffness_get_processes_of_their_own_when_asked_for() {
        // Wave speeds are as 1 : 3 : 8.
        let (solvers, told) = processes("split_by_stiffness = 4");
        assert_eq!((solvers, told.len()), (vec!["mpm".into(), "mpm".into(), "mpm-2".to_owned()], 0));
        assert_eq!(processes("split_by_stiffness = 2").0, ["mpm", "mpm-2", "mpm-3"]);
        assert_eq!(processes("split_by_stiffness = 10").0, ["mpm"; 3]);
        let bonded = "split_by_stiffness = 2\nbonded = [[\"plate\", \"jelly\"]]";
        assert_eq!(processes(bonded).0, ["mpm", "mpm-2", "mpm"], "what is bonded stays together");
    }

    #[test]
    fn a_scene_is_told_what_a_stiff_body_costs() {
        let (solvers, told) = processes("");
        assert_eq!(solvers, ["mpm"; 3]);
        let words = format!("{told:?}");
        assert!(words.contains("`plate` drags `jelly`") && words.contains("8 times the substeps"), "{words}");
    }
}
