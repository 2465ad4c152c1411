//! Energy of a sheet that is held at its rim, alone and under a ball that falls on it.

mod common;

use common::{Run, cloth, pair, record};
use cosplat_conformance::parts;
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, add, dot, scale};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{ActionKind, Material, MotionRule, Source};

const G: f64 = 9.81;
/// Mass of the ball \[kg\].
const BALL: f64 = 0.4;
/// Weight of the sheet \[N\], 0.5 kg/m² of 0.64 m².
const WEIGHT: f64 = 0.32 * G;
/// Windows and substeps \[s\].
const WINDOW: f64 = 0.002;
const SUBSTEP: f64 = 2.5e-4;

/// The sheet at a height of 0.4 m, with so many pins along each side.
fn sheet(pins: usize, own: bool) -> SolverScene {
    let mut material = cloth(1e-3, 1e4);
    if let Material::Cloth { areal_density_kg_m2, .. } = &mut material {
        *areal_density_kg_m2 = 0.5;
    }
    let mut body = parts::body("cloth", material, Source::Plane { size_m: Some([0.8; 2]) }, [0.0, 0.0, 0.4]);
    body.spacing_m = Some(0.02);
    let mut scene = parts::solver_scene("pbd", vec![body], 250, WINDOW);
    scene.actions = vec![parts::gravity()];
    let at: Vec<f64> = (0..=pins).map(|i| 0.8 * i as f64 / pins as f64 - 0.4).collect();
    let all = at.iter().flat_map(|&x| at.iter().map(move |&y| [x, y, 0.4_f64]));
    let rim: Vec<[f64; 3]> = all.filter(|p| p[0].abs().max(p[1].abs()) > 0.39).collect();
    scene.params.insert("thickness_m".into(), 0.002.into());
    scene.params.insert("max_substep_s".into(), SUBSTEP.into());
    scene.params.insert("self_collision".into(), own.into());
    scene.params.insert("pins".into(), serde_json::json!({ "cloth": rim }));
    scene
}

/// The books of the sheet: what its energy, what is dissipated and what was given differ by at most \[J\], how far what
/// is dissipated has fallen below what it was \[J\], and its last value \[J\].
#[derive(Debug)]
struct Books {
    start: f64,
    given: f64,
    open: f64,
    highest: f64,
    fallen: f64,
    last: f64,
}

impl Books {
    fn new(run: &Run) -> Self {
        let start = run.setup.report.energy;
        Self { start: start.kinetic_j + start.potential_j, given: 0.0, open: 0.0, highest: 0.0, fallen: 0.0, last: 0.0 }
    }

    /// Notes a window; the energy of the sheet \[J\].
    fn note(&mut self, report: &cosplat_core::plugin::Report) -> f64 {
        self.given += report.interfaces.iter().map(|i| i.work_j).sum::<f64>() + report.supplied_j;
        let (energy, taken) = (report.energy.kinetic_j + report.energy.potential_j, report.energy.dissipated_j);
        self.open = self.open.max((energy + taken - self.given - self.start).abs());
        self.highest = self.highest.max(taken);
        self.fallen = self.fallen.max(self.highest - taken);
        self.last = taken;
        energy
    }

    /// Checks them, for a sheet whose mean vertical speed stays below `fastest` \[m/s\].
    fn check(&self, fastest: f64) {
        println!("{self:?}");
        // The work of gravity is counted at the mean velocity of a substep, and moves with the last: over all substeps
        // the difference is half of one times the power at the end.
        assert!(self.open < 0.5 * SUBSTEP * WEIGHT * fastest, "{self:?}");
        // What is stored is what a substep from rest feels; a wave of frequency ω turns a share of order ωh of its
        // energy to and fro, and the waves that hold most, of 5 Hz, have ωh = 0.01.
        assert!(self.last > 0.0 && self.fallen < 0.01 * self.highest, "{self:?}");
    }
}

#[test]
fn a_pinned_sheet_that_swings_only_loses_energy() {
    for pins in [4, 40] {
        let mut run = Run::new(sheet(pins, false));
        let mut books = Books::new(&run);
        for _ in 0..250 {
            books.note(&run.step().report);
        }
        // It falls by less than 0.1 m.
        books.check((2.0 * G * 0.1_f64).sqrt());
    }
}

#[test]
fn a_sheet_in_the_wind_gains_no_more_than_the_wind_gives() {
    let mut scene = sheet(4, false);
    let wind = ActionKind::Wind { velocity_m_s: [1.0, 0.0, 6.0], air_density_kg_m3: 1.2, drag_coefficient: 1.1 };
    scene.actions.push(parts::action(wind, 0.0, Some(0.2)));
    let mut run = Run::new(scene);
    let mut books = Books::new(&run);
    for _ in 0..250 {
        books.note(&run.step().report);
    }
    println!("{} J supplied", books.given);
    // The dynamic pressure, 24 N/m², is five times the weight of the sheet, 4.9 N/m², and lifts it by centimetres.
    assert!(books.given > 0.05, "{}", books.given);
    books.check((2.0 * G * 0.1_f64).sqrt());
}

#[test]
fn a_ball_that_a_sheet_throws_back_gets_no_energy_from_nowhere() {
    let mut scene = sheet(4, true);
    let mut view = parts::view(1, ViewRole::ContactResolver, "cloth", "ball", Vec::new());
    (view.partner_form, view.pair) = (BoundaryForm::Proxy, Some(pair("cloth", "ball", 0.3)));
    view.partner_source = Some(Source::Sphere { radius_m: 0.07 });
    scene.interfaces = vec![view];
    let mut run = Run::new(scene);
    run.plugin.connect(&[PartnerSetup { interface: 1, statics: SampleStatics::default() }]).expect("a partner");
    // It has fallen by 0.24 m.
    let speed = (2.0 * G * 0.24_f64).sqrt();
    let mut ball = record([0.05, 0.03, 0.51], [0.0, 0.0, -speed], BALL, 0.4 * BALL * 0.07 * 0.07);
    ball.background_linear = [0.0, 0.0, -G];
    let of_ball = |v: [f64; 3], z: f64| BALL * (0.5 * dot(v, v) + G * z);
    let mut books = Books::new(&run);
    let start = books.start + of_ball(ball.linear_velocity, ball.position[2]);
    let (mut lowest, mut deepest) = (start, 1.0_f64);
    for _ in 0..150 {
        let now = BoundaryState::Proxy(ball);
        let partner = PartnerInput { interface: 1, rule: MotionRule::Hold, now, next: None, length_s: WINDOW };
        let out = run.step_with(&Inputs { partners: vec![partner], impulses: Vec::new() }).expect("a step");
        let Impulses::Rigid(wrench) = &out.impulses[0].1 else { panic!("a wrench") };
        ball.linear_velocity = add(ball.linear_velocity, scale(wrench.linear, 1.0 / BALL));
        ball.linear_velocity[2] -= G * WINDOW;
        ball.position = add(ball.position, scale(ball.linear_velocity, WINDOW));
        let all = books.note(&out.report) + of_ball(ball.linear_velocity, ball.position[2]);
        assert!(all < start * (1.0 + 1e-3), "{all} {start}");
        (lowest, deepest) = (lowest.min(all), deepest.min(ball.position[2]));
    }
    println!("{start} J, at least {lowest} J, lowest point {deepest} m, then {:?} m/s", ball.linear_velocity);
    // It was stopped far below the rim, and flies up again.
    assert!(deepest < 0.35 && ball.linear_velocity[2] > 1.0, "{deepest} {ball:?}");
    books.check(speed);
}
