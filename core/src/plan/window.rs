//! The coupling window: the largest that every active interface bears, and the term that binds it.

use super::Interface;
use crate::boundary::{Vec3, add, cross, dot, norm, sub};
use crate::scene::{Body, Lame, Material, Motion, Scene, VelocityField};
use crate::time::Clock;

/// Windows shorter than this cost more in exchange than they give; the plan refuses them \[s\].
pub const SHORTEST_WINDOW_S: f64 = 1e-5;
/// Window of a scene in which nothing binds it \[s\]: it only sets how often the ledger is written.
const UNBOUND_WINDOW_S: f64 = 0.01;
/// Part of a spacing that two bodies may approach each other in one window.
const APPROACH: f64 = 0.3;
/// A responder's elastic wave may cross this many spacings in one window.
const WAVE: f64 = 1.4;
/// Responders faster than this \[m/s\] are bounded by [`STIFF_WINDOW_S`] instead.
const STIFF_WAVE_SPEED_M_S: f64 = 50.0;
/// Window for stiff responders \[s\].
const STIFF_WINDOW_S: f64 = 1e-3;
/// Substeps of a resolver for which the stand-in of a rigid body is good.
const PROXY_SUBSTEPS: f64 = 20.0;
/// Part of `√(σ d / (ρ_f c_f²))` that a window of a liquid against a light responder may last.
///
/// Liquid and layer exchange as a leapfrog, stable up to `2/ω` with `ω² = 0.47 ρ_f c_f²/(σ d)` by sums over the lattice of
/// the liquid: 2.9 times that root. Liquid on both sides of a sheet makes it 2.1, and one compressed by a tenth 1.5: twice this.
/// Friction does not bind: what a window of it would throw past the liquid it stops.
const LIQUID: f64 = 0.75;
/// The same for a liquid of material points, of whose exchange nothing is derived.
const LIQUID_OF_POINTS: f64 = 0.5;

/// Part of `1/ω` that a window of cloth attached to a soft body may last, with `ω² = E d/m`.
///
/// A bond holds a vertex of the mass `m` to a sample, behind which a body of Young's modulus `E` and spacing `d` is a spring of
/// the stiffness `E d` that the cloth does not know of within a window. Their energy grows from `ω W` of about 1.2, 0.85 for a
/// vertex of a rim, which has half the mass: this is a quarter of that.
const BOND: f64 = 0.2;

/// A window this many times too long is one that was rounded when it was written down.
const FORGIVEN: f64 = 1.0 + 1e-3;

/// A bound on the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Longest window \[s\].
    pub seconds: f64,
    /// In words.
    pub why: String,
}

impl Term {
    fn new(seconds: f64, why: String) -> Self {
        Self { seconds, why }
    }

    fn is_too_short(&self) -> bool {
        self.seconds.is_nan() || self.seconds < SHORTEST_WINDOW_S
    }

    fn refusal(&self, help: &str) -> String {
        format!(
            "the coupling window would have to be {:.2e} s, below the limit of {SHORTEST_WINDOW_S:.0e} s ({}); {help}",
            self.seconds, self.why
        )
    }
}

/// Bounds from the bodies of one contact interface: `resolver` computes the force, `responder` takes impulses.
///
/// * approach: `W ≤ 0.3 d / |v_rel|`, d the coarser spacing;
/// * rigid responder: at most 20 substeps of the resolver's elastic wave, `W ≤ 20 d / c`: with Courant number 0.5 on a
///   grid of two spacings a substep is `d / c`;
/// * solid against a deformable responder: `W ≤ 1.4 d / c` for wave speed c ≤ 50 m/s, else 1 ms;
/// * smoke against anything: none but approach, as its solution has the responder's mass in it, and a gas is soft;
/// * liquid against anything that deforms: `W ≤ 0.75 √(σ d / (ρ_f c_f²))`, for `mpm-liquid` 0.5 of that root, σ the areal
///   mass of the responder's surface layer: density times spacing, or the areal density of cloth.
///
/// Where neither body has a spacing, only the bound that needs none is known.
pub fn contact_terms(name: &str, resolver: &Body, responder: &Body) -> Vec<Term> {
    let mut terms = Vec::new();
    let spacing = [resolver.spacing_m, responder.spacing_m].into_iter().flatten().reduce(f64::max);
    let approach = approach_m_s(resolver, responder);
    if let Some(d) = spacing.filter(|_| approach > 0.0) {
        let why = format!("`{name}`: 0.3 of the spacing {d} m at a relative speed of {approach:.3} m/s");
        terms.push(Term::new(APPROACH * d / approach, why));
    }
    let deforms = !matches!(responder.material, Material::Rigid { .. } | Material::PointMass);
    let stands_in = !deforms && responder.prescribed.is_none() && !is_liquid(&resolver.material);
    let wave = resolver.spacing_m.zip(resolver.wave_speed_m_s());
    if let Some((d, c)) = wave.filter(|_| stands_in) {
        let why = format!("`{name}`: 20 substeps of the elastic wave of `{}` ({c:.1} m/s)", resolver.name);
        terms.push(Term::new(PROXY_SUBSTEPS * d / c, why));
    }
    if !deforms || responder.prescribed.is_some() || matches!(resolver.material, Material::Smoke { .. }) {
        return terms;
    }
    if is_liquid(&resolver.material) {
        let layer = responder.spacing_m.or(spacing);
        let lagged = spacing.zip(layer);
        let bound = |(d, layer)| {
            let each = responder.materials().filter_map(|m| liquid_window_s(&resolver.material, m, d, layer));
            each.reduce(f64::min)
        };
        if let Some(seconds) = lagged.and_then(bound) {
            let why = format!("`{name}`: lagged exchange of a liquid with the surface layer of `{}`", responder.name);
            terms.push(Term::new(seconds, why));
        }
    } else if let Some(c) = responder.wave_speed_m_s() {
        if c > STIFF_WAVE_SPEED_M_S {
            let why = format!("`{name}`: stiff responder `{}` (wave speed {c:.0} m/s)", responder.name);
            terms.push(Term::new(STIFF_WINDOW_S, why));
        } else if let Some(d) = spacing {
            let why = format!("`{name}`: 1.4 spacings of the elastic wave of `{}` ({c:.1} m/s)", responder.name);
            terms.push(Term::new(WAVE * d / c, why));
        }
    }
    terms
}

/// Bound from the vertices of the cloth `holder` that parameters of its solver attach to `held`: `W ≤ 0.2 √(m/(E d))`, with
/// the mass `m` of a vertex, Young's modulus `E` and the spacing `d` of what they are attached to.
///
/// None where nothing is attached, where `held` has no stiffness, and where a spacing is not known.
pub fn bond_term(scene: &Scene, name: &str, holder: &Body, held: &Body) -> Option<Term> {
    let bonds = scene.solvers.get(&holder.solver)?.params.get("bonds")?.get(&holder.name)?.as_array()?;
    let Material::Cloth { areal_density_kg_m2, .. } = holder.material else { return None };
    let is_held = bonds.iter().any(|bond| bond.get("to").and_then(|to| to.as_str()) == Some(&held.name));
    let (apart, d) = holder.spacing_m.zip(held.spacing_m.filter(|_| held.prescribed.is_none() && is_held))?;
    let stiffest = held.materials().filter_map(Material::lame).map(Lame::youngs_modulus_pa).reduce(f64::max)?;
    let swing = (stiffest * d / (areal_density_kg_m2 * apart * apart)).sqrt();
    let why = format!("`{name}`: a fifth of 1/ω of bonds to `{}` (ω = {swing:.0} 1/s)", held.name);
    Some(Term::new(BOND / swing, why))
}

fn is_liquid(material: &Material) -> bool {
    matches!(material, Material::SphLiquid { .. } | Material::MpmLiquid { .. })
}

/// `0.75 √(σ d / (ρ_f c_f²))` \[s\]: the areal mass σ is that of the responder's outermost layer, one of its own spacings
/// thick.
fn liquid_window_s(liquid: &Material, responder: &Material, spacing_m: f64, layer_m: f64) -> Option<f64> {
    let areal = match responder {
        Material::Cloth { areal_density_kg_m2, .. } => *areal_density_kg_m2,
        other => other.density()? * layer_m,
    };
    let (rho, c) = (liquid.density()?, liquid.wave_speed_m_s()?);
    let share = if matches!(liquid, Material::MpmLiquid { .. }) { LIQUID_OF_POINTS } else { LIQUID };
    Some(share * (areal * spacing_m / (rho * c * c)).sqrt())
}

/// Largest relative speed of the centres of two bodies that the scene tells of \[m/s\].
fn approach_m_s(a: &Body, b: &Body) -> f64 {
    norm(sub(steady_m_s(a), steady_m_s(b))) + swing_m_s(a) + swing_m_s(b)
}

/// Velocity of a body's centre at t = 0, or its constant velocity if that is prescribed \[m/s\].
fn steady_m_s(body: &Body) -> Vec3 {
    match body.prescribed {
        Some(Motion::Twist { linear_m_s, .. }) => return linear_m_s,
        Some(Motion::Oscillation { .. }) => return [0.0; 3],
        None => {}
    }
    let from = |about_m: Vec3| sub(body.pose.position_m, about_m);
    match body.velocity {
        VelocityField::Twist { linear_m_s, .. } => linear_m_s,
        VelocityField::LinearMap { linear_m_s, gradient_1_s, about_m } => {
            add(linear_m_s, gradient_1_s.map(|row| dot(row, from(about_m))))
        }
        VelocityField::Rotation { angular_rad_s, about_m } => cross(angular_rad_s, from(about_m)),
    }
}

/// Largest speed of a prescribed oscillation, `2π f |a|` \[m/s\].
fn swing_m_s(body: &Body) -> f64 {
    match body.prescribed {
        Some(Motion::Oscillation { amplitude_m, frequency_hz }) => {
            std::f64::consts::TAU * frequency_hz * norm(amplitude_m)
        }
        _ => 0.0,
    }
}

/// The clock of a scene and the term that binds its window.
///
/// # Errors
/// In words, when no window of at least [`SHORTEST_WINDOW_S`] is bounded.
pub fn choose(scene: &Scene, interfaces: &[Interface]) -> Result<(Clock, String), String> {
    let body = |name: &str| scene.bodies.iter().find(|b| b.name == name);
    let contacts = interfaces.iter().filter(|i| i.kind == super::InterfaceKind::Contact);
    let pairs = contacts.filter_map(|i| Some((&i.name, body(&i.a.body)?, body(&i.b.body)?)));
    let terms = pairs.flat_map(|(name, a, b)| {
        let bonds = [(a, b), (b, a)].into_iter().filter_map(|(holder, held)| bond_term(scene, name, holder, held));
        contact_terms(name, a, b).into_iter().chain(bonds)
    });
    let contact = terms.reduce(shorter);
    let told = |seconds: f64, why: &str| Term::new(seconds, format!("`clock.{why}"));
    let window = scene.clock.window_s.map(|s| told(s, "window` of the scene"));
    let unbound = contact.is_none() && window.is_none();
    let unbound = unbound.then(|| {
        Term::new(UNBOUND_WINDOW_S, "nothing: no interface bounds it, the ledger is written this often".to_owned())
    });
    let frame =
        scene.clock.frames_per_second.map(|fps| told(1.0 / fps, "fps` of the scene: every frame ends a window"));
    let run = told(scene.clock.duration_s, "duration` of the scene: the run is one window");
    let scenes = [window, unbound, frame].into_iter().flatten().fold(run, shorter);
    if let Some(term) = contact.as_ref().filter(|t| t.is_too_short()) {
        let help = "a coarser spacing, a softer or heavier responder or a lower speed would help";
        return Err(term.refusal(help));
    }
    if scenes.is_too_short() {
        return Err(scenes.refusal("choose a longer one"));
    }
    let asked = scene.clock.window_s.filter(|_| scene.clock.exact_window);
    if let Some((window_s, term)) = asked.zip(contact.as_ref()).filter(|(asked, term)| *asked > FORGIVEN * term.seconds)
    {
        return Err(format!(
            "a coupling window of {window_s:.2e} s is {:.1} times what stays bounded, {:.2e} s ({}); choose a shorter \
             `clock.window`, or leave `clock.exact_window` away and let the plan choose",
            window_s / term.seconds,
            term.seconds,
            term.why
        ));
    }
    let bound = contact.into_iter().fold(scenes, shorter);
    Ok((clock(scene.clock.duration_s, scene.clock.frames_per_second, bound.seconds), bound.why))
}

/// The term that binds; the second of two equal ones.
fn shorter(one: Term, other: Term) -> Term {
    if one.seconds < other.seconds { one } else { other }
}

/// Windows of at most `longest_s` that tile frames exactly, or the duration where there are no frames.
///
/// With frames the last window may end after the duration, never before it.
fn clock(duration_s: f64, frames_per_second: Option<f64>, longest_s: f64) -> Clock {
    // Rounding must not turn an exact number of windows into one more: 1e-9 of a window is forgiven, and where there
    // are more than a million windows the few units in the last place that their number may be off.
    let ceil = |x: f64| (x - f64::max(1e-9, 1e-15 * x)).ceil().max(1.0);
    match frames_per_second {
        None => Clock::new(duration_s, ceil(duration_s / longest_s) as u64),
        Some(fps) => {
            let per_frame = ceil(1.0 / (fps * longest_s));
            let windows = ceil(duration_s * fps * per_frame);
            Clock::new(windows / (fps * per_frame), windows as u64)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_tile_the_duration() {
        let c = clock(1.0, None, 0.01);
        assert_eq!((c.windows, c.window_s()), (100, 0.01));
    }

    #[test]
    fn frame_times_are_multiples_of_the_window() {
        let c = clock(1.0, Some(24.0), 0.01);
        // 1/24 s needs five windows of at most 10 ms.
        assert_eq!(c.windows, 24 * 5);
        assert!((c.window_s() * 5.0 - 1.0 / 24.0).abs() < 1e-15, "one rounding of a frame time");
    }

    #[test]
    fn mud_on_a_light_car_needs_a_window_of_a_fluid_step() {
        let mud = Material::SphLiquid {
            density_kg_m3: 1000.0,
            stiffness_pa: 6e4,
            viscosity_pa_s: 0.1,
            surface_tension_n_m: 0.0,
        };
        let car = Material::Elastic {
            density_kg_m3: 30.0,
            youngs_modulus_pa: 2e6,
            poissons_ratio: 0.22,
            viscosity_pa_s: 0.0,
        };
        let c = mud.wave_speed_m_s().unwrap();
        let w = liquid_window_s(&mud, &car, 0.02, 0.02).unwrap();
        // By hand: 0.75 √(30·0.02·0.02 / (1000 c²)) = 0.75 · 0.02 √0.03 / c.
        assert!((w - 0.75 * 0.02 * 0.03f64.sqrt() / c).abs() < 1e-12);
        // A layer of half the mass swings √2 as fast.
        let finer = liquid_window_s(&mud, &car, 0.02, 0.01).unwrap();
        assert!((finer * 2f64.sqrt() / w - 1.0).abs() < 1e-12);
    }
}
