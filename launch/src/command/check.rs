//! `cosplat check`: everything up to the plan, without running.

use cosplat_core::asset::ParticleCloud;
use cosplat_core::plan::{InterfaceKind, source_kind};
use cosplat_core::scene::{Material, Scheme};
use serde::Serialize;

use super::check_picture::draw;
use crate::cli::{CheckArgs, Format};
use crate::exit::{Code, Error, Problem};
use crate::folder::summary::{LeftOut, PresetNote};
use crate::hint::count;
use crate::prepare::{Prepared, prepare};
use crate::render::{Paint, json, print, printable, table, talk};
use crate::report::left_out_line;
use crate::scene_source;
use crate::supervise::signals::Signals;

/// What a run of the scene would do.
#[derive(Debug, Serialize)]
struct Check {
    status: &'static str,
    scene: String,
    title: String,
    simulated_s: f64,
    windows: u64,
    window_s: f64,
    window_bound_by: String,
    processes: Vec<Process>,
    bodies: Vec<Body>,
    /// What bodies from files become.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    filled: Vec<Filled>,
    interfaces: Vec<Interface>,
    /// Published materials that the scene takes, and how their numbers are read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    presets: Vec<PresetNote>,
    left_out: Vec<LeftOut>,
    warnings: Vec<Problem>,
}

#[derive(Debug, Serialize)]
struct Process {
    name: String,
    plugin: String,
    version: String,
    found: String,
    threads: usize,
}

#[derive(Debug, Serialize)]
struct Body {
    name: String,
    process: String,
    /// Its own, then those of its regions.
    material: String,
    source: &'static str,
    /// As given; absent where density and shape decide.
    #[serde(skip_serializing_if = "Option::is_none")]
    mass_kg: Option<f64>,
}

/// A body that was filled with particles.
#[derive(Debug, Serialize)]
struct Filled {
    body: String,
    particles: usize,
    spacing_m: f64,
    volume_m3: f64,
    /// As given, or density times volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    mass_kg: Option<f64>,
    /// How it came about: what was dropped and why, what was left apart, where it lies.
    notes: Vec<String>,
    /// What is kept, what is dropped, and a cut, where it was drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
}

#[derive(Debug, Serialize)]
struct Interface {
    name: String,
    kind: InterfaceKind,
    scheme: Scheme,
    a: String,
    b: String,
    /// Process that computes the force, where one does.
    #[serde(skip_serializing_if = "Option::is_none")]
    resolver: Option<String>,
}

/// Checks a scene and says what a run would do.
///
/// # Errors
/// Everything that is wrong with the scene.
pub(crate) async fn check(args: &CheckArgs, signals: &mut Signals) -> Result<Code, Error> {
    let source = scene_source::load(&args.scene)?;
    let prepared = tokio::select! {
        prepared = prepare(source, &args.changes, Paint::stderr()) => prepared?,
        _ = signals.next() => return Ok(Code::Interrupted),
    };
    for warning in &prepared.warnings {
        talk(warning.drawn.as_deref().unwrap_or(&warning.message));
    }
    let mut check = Check::of(&prepared);
    if let Some(folder) = &args.draw {
        for (body, picture) in draw(&prepared.scene, &prepared.source, folder)? {
            if let Some(filled) = check.filled.iter_mut().find(|f| f.body == body) {
                filled.picture = Some(picture);
            }
        }
    }
    match args.format {
        Format::Json => print(&json(&check)?)?,
        Format::Human => print(&check.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

impl Check {
    fn of(prepared: &Prepared) -> Self {
        let Prepared { scene, plan, plugins, warnings, geometry, .. } = prepared;
        let process = |p: &cosplat_core::plan::Participant| {
            let (candidate, descriptor) = plugins.get(&p.name)?;
            Some(Process {
                name: p.name.clone(),
                plugin: p.plugin.clone(),
                version: descriptor.version.clone(),
                found: candidate.place(),
                threads: p.threads,
            })
        };
        let body = |b: &cosplat_core::scene::Body| Body {
            name: b.name.clone(),
            process: b.solver.clone(),
            material: b.materials().map(Material::name).collect::<Vec<_>>().join(" + "),
            source: source_kind(&b.source),
            mass_kg: b.mass_kg,
        };
        let filled = |b: &cosplat_core::scene::Body| {
            let cloud = geometry.particles(&b.name)?;
            let volume_m3: f64 = cloud.volume_m3.iter().sum();
            let notes = geometry.notes.iter().filter(|(body, _)| *body == b.name);
            Some(Filled {
                body: b.name.clone(),
                particles: cloud.position_m.len(),
                spacing_m: cloud.spacing_m,
                volume_m3,
                mass_kg: b.mass_kg.or_else(|| mass(b, cloud)),
                notes: notes.map(|(_, words)| words.clone()).collect(),
                picture: None,
            })
        };
        let interface = |i: &cosplat_core::plan::Interface| Interface {
            name: i.name.clone(),
            kind: i.kind,
            scheme: i.scheme,
            a: i.a.body.clone(),
            b: i.b.body.clone(),
            resolver: i.carries_impulses().then(|| plan.name_of(i.a.participant).to_owned()),
        };
        Self {
            status: "ok",
            scene: scene.name.clone(),
            title: scene.title.clone(),
            simulated_s: plan.clock.seconds(plan.clock.start_of(plan.clock.windows)),
            windows: plan.clock.windows,
            window_s: plan.clock.window_s(),
            window_bound_by: plan.window_bound_by.clone(),
            processes: plan.participants.iter().filter_map(process).collect(),
            bodies: scene.bodies.iter().map(body).collect(),
            filled: scene.bodies.iter().filter_map(filled).collect(),
            interfaces: plan.interfaces.iter().map(interface).collect(),
            presets: PresetNote::of(scene),
            left_out: plan.left_out.iter().map(LeftOut::from).collect(),
            warnings: warnings.clone(),
        }
    }

    fn human(&self, paint: Paint) -> String {
        let windows = usize::try_from(self.windows).unwrap_or(usize::MAX);
        let mut parts = vec![format!(
            "{}: {}\n\n{} of {:.6} s for {} s, bound by {}\n",
            paint.bold(&self.scene),
            printable(&self.title),
            count(windows, "window", "windows"),
            self.window_s,
            self.simulated_s,
            self.window_bound_by
        )];
        let head = |cells: [&str; 5]| cells.map(str::to_owned).to_vec();
        let mut rows = vec![head(["process", "plugin", "version", "threads", "found"])];
        for p in &self.processes {
            rows.push(vec![
                p.name.clone(),
                p.plugin.clone(),
                p.version.clone(),
                p.threads.to_string(),
                p.found.clone(),
            ]);
        }
        parts.push(table(paint, &rows));
        let mut rows = vec![head(["body", "process", "material", "from", "mass"])];
        for b in &self.bodies {
            let mass = b.mass_kg.map_or_else(|| "by density".into(), |m| format!("{m} kg"));
            rows.push(vec![b.name.clone(), b.process.clone(), b.material.clone(), b.source.into(), mass]);
        }
        parts.push(table(paint, &rows));
        for f in &self.filled {
            let mass = f.mass_kg.map_or_else(String::new, |m| format!(", {m:.4} kg"));
            let head = format!(
                "{}: {} {} m apart, {:.4e} m³{mass}\n",
                printable(&f.body),
                count(f.particles, "particle", "particles"),
                f.spacing_m,
                f.volume_m3
            );
            let drawn = f.picture.iter().map(|p| {
                format!("  drawn in {}: kept, dropped in red, and a cut through the particles\n", printable(p))
            });
            let notes = f.notes.iter().map(|n| format!("  {}\n", printable(n)));
            parts.push([head].into_iter().chain(notes).chain(drawn).collect());
        }
        if self.interfaces.is_empty() {
            parts.push("no interfaces: no two processes exchange anything\n".into());
        } else {
            let mut rows = vec![head(["interface", "kind", "scheme", "resolver", ""])];
            for i in &self.interfaces {
                let resolver = i.resolver.clone().unwrap_or_else(|| "both sides".into());
                rows.push(vec![i.name.clone(), word(i.kind), word(i.scheme), resolver, String::new()]);
            }
            parts.push(table(paint, &rows));
        }
        if !self.presets.is_empty() {
            let lines = self.presets.iter().map(|p| format!("  {}\n", p.words()));
            parts.push(["published materials:\n".to_owned()].into_iter().chain(lines).collect());
        }
        if !self.left_out.is_empty() {
            let lines = self.left_out.iter().map(|l| format!("  {}\n", left_out_line(l)));
            parts.push(["left out:\n".to_owned()].into_iter().chain(lines).collect());
        }
        parts.join("\n")
    }
}

/// Mass by density of a body that was filled \[kg\].
fn mass(body: &cosplat_core::scene::Body, cloud: &ParticleCloud) -> Option<f64> {
    let density = |x| body.materials().nth(body.material_at(x)).and_then(Material::density);
    cloud.position_m.iter().zip(&cloud.volume_m3).map(|(&x, volume)| Some(density(x)? * volume)).sum()
}

/// A choice as a scene writes it.
fn word(value: impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}
