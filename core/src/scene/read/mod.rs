//! Scene files: TOML in, a [`Scene`] or every mistake out.
//!
//! Each section has a file here that reads it. Reading never stops at a mistake: the value is reported, a stand-in
//! takes its place, and the scene is thrown away in the end.
//!
//! ```
//! use cosplat_core::scene::{read, render};
//!
//! let text = r#"
//! format = 1                           # newest format of the file; may be left out
//! name = "drop"                        # also the name of the run folder
//! clock = { duration = 1.0, window = 0.002 }
//!
//! [[body]]
//! name = "toy"
//! material = { preset = "plushie", density = 60 }
//! box = [0.1, 0.1, 0.2]                # edge lengths [m]; or splat, mesh, sphere, cylinder, plane, points, cloud
//! position = [0, 0, 1]
//!
//! [[static]]
//! name = "floor"
//! plane = "infinite"
//!
//! [[action]]
//! kind = "gravity"
//! acceleration = [0, 0, -9.81]
//! "#;
//! let (scene, warnings) = read::parse(text).map_err(|found| render("drop.toml", text, &found))?;
//! assert_eq!((scene.bodies[0].solver.as_str(), warnings.len()), ("mpm", 0));
//! # Ok::<(), String>(())
//! ```

mod action;
mod binding;
mod body;
mod camera;
mod fields;
mod limits;
mod link;
mod material;
mod motion;
mod names;
mod node;
mod overrides;
mod pair;
mod probe;
mod region;
mod report;
mod settings;
mod solver;
mod source;
#[cfg(test)]
mod tests;
mod value;

use toml::de::DeTable;

use fields::Fields;
use node::{Origin, Table};
use report::Report;

use super::diagnostic::{Diagnostic, Severity};
use super::model::{ClockSpec, MotionRule, Scene, Scheme};

/// Newest format of scene files that can be read.
pub const FORMAT: u64 = 1;

/// A scene with its warnings, or the errors and warnings of a file that is none.
pub type Parsed = Result<(Scene, Vec<Diagnostic>), Vec<Diagnostic>>;

/// Reads the text of a scene file.
///
/// # Errors
/// Every mistake of the text, in its order.
pub fn parse(text: &str) -> Parsed {
    parse_with(text, &[])
}

/// Reads the text of a scene file after replacing values in it.
///
/// An override is `path=value`, as in `clock.window=0.005`, `body.left.mass=2` or `action.0.from=1`. Members of a list
/// of tables go by their name or their index; the value is TOML, a plain word counts as a string.
///
/// # Errors
/// Every mistake of the text and the overrides.
pub fn parse_with(text: &str, overrides: &[String]) -> Parsed {
    let (document, errors) = DeTable::parse_recoverable(text);
    let syntax: Vec<Diagnostic> = errors.iter().take(report::MOST_FINDINGS).map(syntax_error).collect();
    let report = Report::default();
    let mut table = Table::from_file(document.get_ref());
    overrides::apply(&mut table, overrides, &report);

    let origin = Origin::File(0..0);
    let scene = Fields::read(&table, &origin, "", &report, read_scene);
    names::check(&report);
    let diagnostics = report.into_diagnostics(text, syntax);
    match scene {
        Some(scene) if diagnostics.iter().all(|d| d.severity == Severity::Warning) => Ok((scene, diagnostics)),
        _ => Err(diagnostics),
    }
}

fn syntax_error(error: &toml::de::Error) -> Diagnostic {
    Diagnostic { span: error.span(), ..Diagnostic::error(error.message().trim().to_owned()) }
}

fn read_scene(root: &Fields<'_>) -> Option<Scene> {
    if !is_known_format(root) {
        root.accept_all_keys();
        return None;
    }
    let name = root.must("name", |at| at.name()).unwrap_or_default();
    let mut clock = settings::clock(root);
    let mut output = settings::output(root, clock.as_mut());
    let bodies = root.tables("body", |fields| {
        let (body, binding) = body::body(fields)?;
        output.bindings.extend(binding.map(|binding| (body.name.clone(), binding)));
        Some(body)
    });
    let duration_s = clock.as_ref().map_or(f64::NAN, |clock| clock.duration_s);
    let mut scene = Scene {
        title: root.opt("title", |at| at.text()).unwrap_or_else(|| name.clone()),
        name,
        clock: clock.unwrap_or(STAND_IN_CLOCK),
        space: settings::space(root),
        solvers: solver::solvers(root),
        bodies,
        statics: root.tables("static", body::static_collider),
        pairs: Vec::new(),
        links: root.tables("link", link::link),
        joints: root.tables("joint", link::joint),
        actions: root.tables("action", |fields| action::action(fields, duration_s)),
        probes: root.tables("probe", probe::probe),
        output,
        run: settings::run(root),
        presets: Vec::new(),
    };
    scene.pairs = pair::pairs(root, &scene);
    scene.presets = root.report.presets.take();
    check_whole(root, &scene);
    Some(scene)
}

/// Takes the place of a clock that could not be read.
const STAND_IN_CLOCK: ClockSpec = ClockSpec {
    duration_s: f64::NAN,
    window_s: None,
    exact_window: false,
    frames_per_second: None,
    contact_scheme: Scheme::Serial,
    link_scheme: Scheme::Alternating,
    motion_rule: MotionRule::Hold,
};

fn is_known_format(root: &Fields<'_>) -> bool {
    let Some(at) = root.get("format") else { return true };
    let format = at.count(1..=1_000_000_000);
    if format <= FORMAT {
        return true;
    }
    let message = format!("this scene has format {format}, but this version of cosplat reads up to format {FORMAT}");
    at.error(message, Some("update cosplat, or write the scene in the older format".to_owned()));
    false
}

/// What only shows when all sections are known.
fn check_whole(root: &Fields<'_>, scene: &Scene) {
    if !root.has("body") {
        root.absence("a scene needs at least one `[[body]]`".to_owned(), None);
    }
    let sections: Vec<&str> = scene.solvers.keys().map(String::as_str).collect();
    body::check_solver_names(root, &sections);
    if !root.report.has_errors() {
        warn_of_idle_solvers(root, scene);
    }
}

fn warn_of_idle_solvers(root: &Fields<'_>, scene: &Scene) {
    root.named("solver", |name, origin, fields| {
        fields.accept_all_keys();
        if scene.bodies.iter().all(|body| body.solver != name) {
            let message = format!("solver `{name}` has no bodies, so it is not started");
            root.report.warning(origin, &fields.path, message, None);
        }
    });
}
