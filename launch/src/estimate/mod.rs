//! How wrong a run is by its own measurements, what that means, and which knob lowers it at which cost.
//!
//! A verdict says that something is broken; an estimate says how much of a result is noise of the method. It ends no run.

mod budget;
mod solver;

use cosplat_core::scene::{Material, Scene, Source};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub(crate) use budget::EnergyBudget;

use crate::folder::summary::{Interface, Summary};

/// Part of the energy that moves in a run which an exchange may make or lose before it shows in a result.
const ENERGY: f64 = 0.01;
/// The same of a rise of the total: half as much, since twice of what was there at the start may have moved.
const RISE: f64 = 0.005;
/// Part of the impulses of a link by which its two sides may differ.
const IMPULSE: f64 = 0.05;

/// An estimate of an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Estimate {
    /// What is estimated.
    pub(crate) name: String,
    /// Process or interface.
    pub(crate) of: String,
    /// Its size: relative, unless the name says a unit.
    pub(crate) value: f64,
    /// Size above which it is worth a thought.
    pub(crate) usual: f64,
    /// Whether it is above.
    pub(crate) is_high: bool,
    /// What it means for this scene.
    pub(crate) meaning: String,
    /// What lowers it, at which cost.
    pub(crate) remedy: String,
}

/// Every estimate that the measurements of a run allow, by kind.
pub(crate) fn estimates(summary: &Summary) -> Vec<Estimate> {
    if summary.windows == 0 {
        return Vec::new();
    }
    let moved = moved_j(summary);
    let mut found: Vec<Estimate> = summary.interfaces.iter().filter_map(|i| work(i, moved)).collect();
    found.extend(summary.interfaces.iter().filter_map(impulse));
    found.extend(summary.interfaces.iter().filter_map(|i| link_place(i, summary)));
    found.extend(rise(summary, moved));
    found.extend(balance(summary, moved));
    for process in &summary.processes {
        let Some(counters) = summary.counters.get(&process.name) else { continue };
        found.extend(solver::estimates(process, counters));
    }
    found
}

/// Rigid bodies that are smaller than the distance of the particles they touch: these they can slip between.
pub(crate) fn resolutions(scene: &Scene, interfaces: &[Interface]) -> Vec<Estimate> {
    let body = |name: &str| scene.bodies.iter().find(|b| b.name == name);
    let of = |i: &Interface| {
        let (resolver, other) = (body(&i.a)?, body(&i.b)?);
        let (spacing, thickness) = (resolver.spacing_m?, thickness_m(&other.source)?);
        let is_rigid = matches!(other.material, Material::Rigid { .. });
        let value = spacing / thickness;
        let meaning = format!(
            "`{}` is {thickness} m thick, the particles of `{}` are {spacing} m apart: it can slip between them",
            other.name, resolver.name
        );
        let remedy = "refine the body's `spacing` to half that thickness; each halving costs eight times the particles and \
                      twice the substeps";
        (is_rigid && value > 1.0).then(|| estimate("spacing over thickness", &name(i), [value, 1.0], meaning, remedy))
    };
    interfaces.iter().filter(|i| i.kind == "contact").filter_map(of).collect()
}

/// How far beside its place a resolver saw its partner before it was told better: the difference between a stand-in and the
/// partner over a window, against the distance of the particles that touch it.
pub(crate) fn foresight(scene: &Scene, interfaces: &[Interface], window_s: f64) -> Vec<Estimate> {
    let of = |i: &Interface| {
        let spacing = scene.bodies.iter().find(|b| b.name == i.a)?.spacing_m?;
        let value = i.residual * window_s;
        let meaning = format!(
            "`{}` moved by up to {:.2e} m/s otherwise than `{}` foresaw: by the end of a window it was {value:.2e} m beside \
             the place where contact was computed, with particles {spacing} m apart",
            i.b, i.residual, i.a
        );
        let remedy = "halve `clock.window`: this halves it, for twice the exchanges; it is largest where the partner strikes \
                      something else in the same window";
        (i.residual > 0.0).then(|| estimate("foreseen place [m]", &name(i), [value, 0.5 * spacing], meaning, remedy))
    };
    interfaces.iter().filter(|i| i.kind == "contact").filter_map(of).collect()
}

/// Smallest extent of a body that is given by numbers \[m\].
fn thickness_m(source: &Source) -> Option<f64> {
    match *source {
        Source::Box { size_m } => Some(size_m.into_iter().fold(f64::INFINITY, f64::min)),
        Source::Sphere { radius_m } => Some(2.0 * radius_m),
        Source::Cylinder { radius_m, height_m } => Some(height_m.min(2.0 * radius_m)),
        _ => None,
    }
}

/// Part of the energy that moved below which a balance is closed: sums over many windows of numbers of 16 digits.
const ROUNDING: f64 = 1e-9;
/// Part of the energy of a scene at rest below which a change is noise.
const STILL: f64 = 1e-4;

/// Energy that changed its place \[J\]: the sum over processes of how far theirs went, but not less than what a scene at
/// rest may tremble.
fn moved_j(summary: &Summary) -> f64 {
    let own = summary.energy.iter().filter(|e| summary.processes.iter().any(|p| p.name == e.name));
    let range = |e: &crate::folder::summary::Energy| {
        let start = e.initial_j.unwrap_or(e.first_j);
        e.max_j.max(start) - e.min_j.min(start)
    };
    let whole = summary.energy.iter().find(|e| e.name == "total").map_or(0.0, |e| e.max_j.abs().max(e.min_j.abs()));
    own.map(range).sum::<f64>().max(STILL * whole)
}

fn estimate(name: &str, of: &str, [value, usual]: [f64; 2], meaning: String, remedy: &str) -> Estimate {
    // What is no number is never usual.
    let is_high = value.is_nan() || value > usual;
    Estimate { name: name.into(), of: of.into(), value, usual, is_high, meaning, remedy: remedy.into() }
}

fn percent(value: f64) -> String {
    format!("{:.2} %", 100.0 * value)
}

fn work(interface: &Interface, moved: f64) -> Option<Estimate> {
    if moved <= 0.0 {
        return None;
    }
    let value = interface.work_defect.abs() / moved;
    let is_contact = interface.kind == "contact";
    let did = match (interface.work_defect > 0.0, is_contact) {
        (true, _) => "made",
        (false, true) => "took, by impact and friction as well as by its error,",
        (false, false) => "took",
    };
    let meaning = format!(
        "the exchange {did} {:.2e} J, {} of the energy that moved in this run",
        interface.work_defect.abs(),
        percent(value)
    );
    let remedy = "halve `clock.window`: this halves it (serial, parallel) or quarters it (alternating, centred), for \
                  twice the exchanges";
    let mut found = estimate("work of the exchange", &name(interface), [value, ENERGY], meaning, remedy);
    // Contact may take energy; nothing may make it.
    found.is_high &= !is_contact || interface.work_defect.is_nan() || interface.work_defect > 0.0;
    Some(found)
}

fn impulse(interface: &Interface) -> Option<Estimate> {
    if interface.resolver.is_some() || interface.gross_impulse <= 0.0 {
        return None;
    }
    let value = interface.transfer_defect / interface.gross_impulse;
    let meaning = format!("the two sides of the link gave impulses that differ by {}", percent(value));
    let remedy = "halve `clock.window`, or take `clock.link_scheme = \"centred\"`, in which they do not differ, for a \
                  solver that covers a window in two halves";
    Some(estimate("impulse of the link", &name(interface), [value, IMPULSE], meaning, remedy))
}

/// How far a body on a link was beside where the other side took it to be, against how far the two moved.
fn link_place(interface: &Interface, summary: &Summary) -> Option<Estimate> {
    let own = summary.bodies.iter().filter(|b| [&interface.a, &interface.b].contains(&&b.name));
    let moved = own.map(|body| body.max_displacement_m).fold(0.0, f64::max);
    let value = interface.foreseen_m;
    let meaning = format!(
        "a side of the link took the other to be up to {value:.2e} m from where it was by the end of a window, {} of how \
         far they moved",
        percent(value / moved)
    );
    let remedy = "halve `clock.window`: this halves it, for twice the exchanges; in the result it shows to first order \
                  (serial, parallel) or to second (alternating, centred); `clock.motion_rule = \"linear\"` foresees a \
                  straight way";
    let is_link = interface.kind == "link" && value > 0.0 && moved > 0.0;
    is_link.then(|| {
        estimate("foreseen place of the link [m]", &name(interface), [value, IMPULSE * moved], meaning, remedy)
    })
}

fn name(interface: &Interface) -> String {
    format!("{}~{}", interface.a, interface.b)
}

fn rise(summary: &Summary, moved: f64) -> Option<Estimate> {
    let total = summary.energy.iter().find(|e| e.name == "total")?;
    if moved <= 0.0 {
        return None;
    }
    let start = total.initial_j.unwrap_or(total.first_j);
    let value = (total.max_unsupplied_j - start).max(0.0) / moved;
    let meaning = format!(
        "the total energy rose by {} of what moved above what was supplied from outside: a coupling that feeds the motion \
         does that, and errors of the solvers",
        percent(value)
    );
    let remedy = "halve `clock.window`, or take a serial scheme, which waits instead";
    Some(estimate("rise of the energy", "total", [value, RISE], meaning, remedy))
}

/// What was made and taken away again: no rise of the energy shows it.
fn balance(summary: &Summary, moved: f64) -> Option<Estimate> {
    let total = summary.energy.iter().find(|e| e.name == "total")?;
    let start = total.initial_j.unwrap_or(total.first_j);
    let value = (total.max_balance_j - start) / moved;
    if moved <= 0.0 || value <= ROUNDING {
        return None;
    }
    let meaning = format!(
        "energy and what was dissipated of it came to {} of what moved more than there was: something makes energy that \
         friction and viscosity take away, in the exchange or in a solver whose losses are estimates",
        percent(value)
    );
    let remedy = "halve `clock.window`: where the exchange makes it this halves it or better, for twice the exchanges";
    Some(estimate("balance of the energy", "total", [value, ENERGY], meaning, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::summary::{Body, Energy, Process};

    pub(super) fn summary() -> Summary {
        let text = r#"{"status":"ok","exit_code":0,"failure":null,"scene":"x","windows":3,"window_s":0.1,
            "window_bound_by":"x","simulated_s":0.3,"wall_s":1.0,"state_hash":null,"verdicts":[],"processes":[],
            "frames":null,"bodies":[],"interfaces":[],"energy":[],"counters":{},"left_out":[],"files":{}}"#;
        let mut summary: Summary = serde_json::from_str(text).unwrap();
        summary.processes = vec![Process { name: "left".into(), substeps: 100, ..Process::default() }];
        let energy = |name: &str, [start, least, most]: [f64; 3]| Energy {
            name: name.into(),
            initial_j: Some(start),
            min_j: least,
            max_j: most,
            max_unsupplied_j: most,
            ..Energy::default()
        };
        summary.energy = vec![energy("left", [1.0, 0.0, 2.0]), energy("total", [1.0, 0.9, 1.1])];
        summary
    }

    #[test]
    fn an_exchange_that_feeds_the_motion_is_high() {
        let mut summary = summary();
        let defect = |work_defect| Interface { a: "a".into(), b: "b".into(), work_defect, ..Interface::default() };
        let contact = Interface { kind: "contact".into(), ..defect(-0.5) };
        summary.interfaces = vec![defect(0.1), defect(-1e-6), contact];
        let found = estimates(&summary);
        // A tenth of a joule of the two that moved.
        summary.energy[1].max_balance_j = 1.4;
        let balance = estimates(&summary).into_iter().find(|e| e.name == "balance of the energy").unwrap();
        assert!((balance.value - 0.2).abs() < 1e-12 && balance.is_high, "{balance:?}");
        assert!((found[0].value - 0.05).abs() < 1e-12 && found[0].is_high, "{found:?}");
        assert!(!found[1].is_high && found[1].meaning.contains("took"), "{found:?}");
        assert!(!found[2].is_high && found[2].meaning.contains("friction"), "{found:?}");
        assert_eq!((found[3].name.as_str(), found[3].is_high), ("rise of the energy", true));
    }

    #[test]
    fn what_can_slip_between_particles_is_told() {
        let source = crate::scene_source::load("ball-on-block").unwrap();
        let high = |radius: &str| {
            let change = format!("body.ball.sphere={radius}");
            let (scene, _) = crate::scene_source::parse(&source, &[change], crate::render::Paint::off()).unwrap();
            let interface =
                Interface { a: "block".into(), b: "ball".into(), kind: "contact".into(), ..Interface::default() };
            resolutions(&scene, &[interface]).len()
        };
        assert_eq!([high("0.06"), high("0.005")], [0, 1]);
    }

    #[test]
    fn a_partner_that_moves_otherwise_than_foreseen_is_told_in_metres() {
        let source = crate::scene_source::load("ball-on-block").unwrap();
        let (scene, _) = crate::scene_source::parse(&source, &[], crate::render::Paint::off()).unwrap();
        let spacing = scene.bodies.iter().find(|b| b.name == "block").unwrap().spacing_m.unwrap();
        let seen = |residual| {
            let (a, b, kind) = ("block".into(), "ball".into(), "contact".into());
            foresight(&scene, &[Interface { a, b, kind, residual, ..Interface::default() }], 0.01)
        };
        assert_eq!(seen(0.0), []);
        let found = seen(60.0 * spacing);
        assert!(found[0].is_high && (found[0].value - 0.6 * spacing).abs() < 1e-12, "{found:?}");
        assert!(!seen(40.0 * spacing)[0].is_high);
    }

    #[test]
    fn a_link_that_is_foreseen_badly_is_told_in_metres() {
        let mut summary = summary();
        let body = |name: &str| Body { name: name.into(), max_displacement_m: 2.0, ..Body::default() };
        summary.bodies = vec![body("a"), body("b")];
        let link = |foreseen_m| Interface {
            a: "a".into(),
            b: "b".into(),
            kind: "link".into(),
            foreseen_m,
            ..Interface::default()
        };
        let high = |foreseen_m| link_place(&link(foreseen_m), &summary).map(|found| found.is_high);
        // A twentieth of two metres.
        assert_eq!([0.0, 0.09, 0.11].map(high), [None, Some(false), Some(true)]);
        assert_eq!(link_place(&Interface { kind: "contact".into(), ..link(1.0) }, &summary), None);
    }

    #[test]
    fn counters_of_solvers_become_estimates() {
        let mut summary = summary();
        let counters = [
            ("largest-compression-1e-6", 20_000),
            ("contact-unsettled", 1),
            ("stretch-clamps", 2),
            ("largest-stretch-left-1e-6", 5_000),
            ("largest-stretch-1e-6", 2_500_000),
            ("largest-overrun-1e-6-m", 10_000),
            ("largest-gap-of-a-joint-1e-9-m", 1),
            ("largest-divergence-1e-6", 100),
            ("largest-mean-crowding-1e-6", 200_000),
        ];
        let counters = counters.map(|(name, n)| (name.to_owned(), n)).into();
        summary.counters = [("left".to_owned(), counters)].into();
        let found = estimates(&summary);
        let high: Vec<(&str, bool)> = found.iter().map(|e| (e.name.as_str(), e.is_high)).collect();
        let expected = [
            ("rise of the energy", true),
            ("compression", true),
            ("unsettled contact", false),
            ("stretch left", false),
            ("strain guard [stretch]", true),
            ("stretch clamps", true),
            ("overrun [m]", true),
            ("gap of a joint [m]", false),
            ("divergence", false),
            ("crowding", true),
        ];
        assert_eq!(high, expected);
    }
}
