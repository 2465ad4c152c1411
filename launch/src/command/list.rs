//! `cosplat list`: the scenes inside this program.

use clap::Args;
use cosplat_core::scene::{Body, ClockSpec, Source};
use serde::Serialize;

use crate::cli::Format;
use crate::exit::{Code, Error};
use crate::render::{Paint, json, print, printable, table};
use crate::scene_source::{DEFAULT, built_in_names, load, parse};

/// `cosplat list`.
#[derive(Clone, Debug, Args)]
pub(crate) struct ListArgs {
    /// Form of the list on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// What can be said about a scene without running it or asking plugins.
#[derive(Debug, Serialize)]
struct Listed {
    name: String,
    title: String,
    /// Whether it is run where no scene is named.
    is_default: bool,
    duration_s: f64,
    /// Windows, at least; absent where the plan decides alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    windows: Option<u64>,
    /// Processes with bodies.
    solvers: Vec<String>,
    bodies: usize,
    /// Particles, about; absent where a file decides.
    #[serde(skip_serializing_if = "Option::is_none")]
    particles: Option<u64>,
}

/// Lists the built-in scenes.
///
/// # Errors
/// The list cannot be printed.
pub(crate) fn list(args: &ListArgs) -> Result<Code, Error> {
    let listed = built_in_names().map(Listed::of).collect::<Result<Vec<_>, Error>>()?;
    match args.format {
        Format::Json => print(&json(&listed)?)?,
        Format::Human => print(&human(&listed, Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

impl Listed {
    fn of(name: &str) -> Result<Self, Error> {
        let (scene, _) = parse(&load(name)?, &[], Paint::stderr())?;
        let mut solvers: Vec<String> = scene.bodies.iter().map(|b| b.solver.clone()).collect();
        solvers.sort_unstable();
        solvers.dedup();
        Ok(Self {
            is_default: name == DEFAULT,
            duration_s: scene.clock.duration_s,
            windows: windows(&scene.clock),
            solvers,
            bodies: scene.bodies.len(),
            particles: scene.bodies.iter().map(particles).sum(),
            name: scene.name,
            title: scene.title,
        })
    }
}

/// The plan may take shorter windows than a scene asks for, never longer ones.
fn windows(clock: &ClockSpec) -> Option<u64> {
    clock.window_s.map(|window_s| (clock.duration_s / window_s).round().max(1.0) as u64)
}

/// Particles of a body of that spacing; a rigid body and one without a spacing have none.
fn particles(body: &Body) -> Option<u64> {
    let fill = |volume_m3: f64| body.spacing_m.map_or(0, |spacing_m| (volume_m3 / spacing_m.powi(3)).round() as u64);
    Some(match &body.source {
        Source::Points { positions_m } => positions_m.len() as u64,
        Source::Cloud { count, .. } => *count as u64,
        Source::Box { size_m } => fill(size_m.iter().product()),
        Source::Sphere { radius_m } => fill(4.0 / 3.0 * std::f64::consts::PI * radius_m.powi(3)),
        Source::Cylinder { radius_m, height_m } => fill(std::f64::consts::PI * radius_m * radius_m * height_m),
        Source::Splat { .. } | Source::Mesh { .. } if body.spacing_m.is_some() => return None,
        Source::Splat { .. } | Source::Mesh { .. } | Source::HeightField { .. } | Source::Plane { .. } => 0,
    })
}

fn human(listed: &[Listed], paint: Paint) -> String {
    let mut rows = vec![["scene", "seconds", "windows", "particles", "solvers", ""].map(str::to_owned).to_vec()];
    for scene in listed {
        let windows = scene.windows.map_or_else(|| "by the plan".to_owned(), |n| n.to_string());
        let particles = scene.particles.map_or_else(|| "by the file".to_owned(), |n| n.to_string());
        let default = if scene.is_default { "; the default" } else { "" };
        let title = format!("{}{default}", printable(&scene.title));
        let seconds = scene.duration_s.to_string();
        rows.push(vec![scene.name.clone(), seconds, windows, particles, scene.solvers.join(" "), title]);
    }
    let hint = "run one with `cosplat run SCENE`, look at its plan with `cosplat check SCENE`\n";
    format!("{}\n{hint}", table(paint, &rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_listed_with_what_is_known() {
        let listed: Vec<Listed> = built_in_names().map(|name| Listed::of(name).unwrap()).collect();
        assert_eq!(listed.iter().filter(|scene| scene.is_default).count(), 1);
        let find = |name: &str| listed.iter().find(|scene| scene.name == name).unwrap();
        let oscillator = find("oscillator");
        assert_eq!((oscillator.windows, oscillator.particles, oscillator.bodies), (Some(100), Some(2), 2));
        // 0.3 × 0.3 × 0.2 m in cells of 2 cm.
        assert_eq!(find("ball-on-block").particles, Some(2250));
        assert_eq!(find("plant-and-rock").particles, None);
        let text = human(&listed, Paint::off());
        assert!(listed.iter().all(|scene| text.contains(&scene.title)), "{text}");
    }
}
