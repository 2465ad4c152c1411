//! Does the ledger notice? Reports made by hand, exact ones and ones with a single thing wrong.

#![expect(clippy::float_cmp, reason = "a defect is exactly zero, or it is one")]

use std::collections::BTreeMap;

use cosplat_core::boundary::Wrench;
use cosplat_core::control::{Done, Moment, ReadyInfo};
use cosplat_core::ledger::{Ledger, WindowRecord};
use cosplat_core::plan::{BoundaryForm, Content, Plan, build};
use cosplat_core::plugin::{BodyState, Descriptor, Energy, InterfaceReport, InterfaceRole, Report, Saves, SolverScene};
use cosplat_core::scene::read;

type Vec3 = [f64; 3];

const J: Vec3 = [0.1, -0.2, 0.3];

/// A spring of 8 N/m between two bodies, at rest when they are 1 m apart.
const SPRING: &str = "[[link]]\nname = 'spring'\na = 'right'\nb = 'left'\nstiffness = 8.0\nrest = [1.0, 0.0, 0.0]\n";

fn descriptor(roles: &[InterfaceRole]) -> Descriptor {
    Descriptor {
        name: "made".to_owned(),
        version: "1".to_owned(),
        summary: "made by hand".to_owned(),
        protocol: [1, 1],
        body_kinds: vec!["points".to_owned()],
        materials: vec!["point-mass".to_owned()],
        roles: roles.to_vec(),
        boundary: BoundaryForm::SamplesF64 { normals: false },
        visual: None,
        features: Vec::new(),
        probes: Vec::new(),
        saves: Saves { bytes: true, deterministic: true },
        params_schema: serde_json::json!({}),
    }
}

/// Two bodies of 2 kg in the solvers `left` and `right`, which touch or, with a link, are joined.
fn plan(scheme: &str, link: &str) -> (Plan, Vec<SolverScene>) {
    use InterfaceRole::{Link, ResolveSamples, Respond};
    let roles: &[InterfaceRole] = if link.is_empty() { &[ResolveSamples, Respond] } else { &[Link] };
    let key = if link.is_empty() { "contact_scheme" } else { "link_scheme" };
    let body = |name: &str| {
        format!(
            "[[body]]\nname = '{name}'\nsolver = '{name}'\nmaterial = 'point-mass'\nmass = 2.0\npoints = [[0, 0, 0]]\n"
        )
    };
    let text = format!(
        "name = 'ledger'\n[clock]\nduration = 1.0\nwindow = 0.25\n{key} = '{scheme}'\n\
         [solver.left]\nplugin = 'made'\n[solver.right]\nplugin = 'made'\n{}{}{link}",
        body("left"),
        body("right")
    );
    let (scene, _) = read::parse(&text).expect("the text is a scene");
    build(&scene, &BTreeMap::from([("made".to_owned(), descriptor(roles))]), 1).expect("a plan")
}

/// State of the one body of a solver: 2 kg with that momentum at that place.
fn body(momentum: Vec3, position_m: Vec3) -> BodyState {
    let size = momentum.iter().map(|p| p * p).sum::<f64>().sqrt();
    let [x, y, z] = position_m;
    let [p, q, r] = momentum;
    BodyState {
        mass_kg: 2.0,
        position_m,
        momentum: Wrench { linear: momentum, angular: [y * r - z * q, z * p - x * r, x * q - y * p] },
        gross_momentum: size,
        ..BodyState::default()
    }
}

fn report(body: BodyState) -> Report {
    Report { bodies: vec![body], ..Report::default() }
}

fn open(plan: &Plan, scenes: &[SolverScene], states: &[BodyState; 2]) -> Ledger {
    let ready = states.map(|state| ReadyInfo { report: report(state), ..ReadyInfo::default() });
    Ledger::open(plan, scenes, &[&ready[0], &ready[1]])
}

fn done(body: BodyState) -> Done {
    Done { report: report(body), ..Done::default() }
}

fn size(j: Vec3) -> f64 {
    j.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// A first window in which `left` pushes `right` by [`J`], both being at the origin: changes where nothing is wrong.
fn push(change: impl FnOnce(&mut [Done; 2])) -> WindowRecord {
    let (plan, scenes) = plan("serial", "");
    let start = [body([1.0, 0.0, 0.0], [0.0; 3]), body([0.0; 3], [0.0; 3])];
    let mut ledger = open(&plan, &scenes, &start);
    let mut dones = [done(body([1.0 - J[0], -J[1], -J[2]], [0.0; 3])), done(body(J, [0.0; 3]))];
    dones[0].sent = vec![(0, J, size(J))];
    dones[1].applied = vec![(0, J, size(J))];
    change(&mut dones);
    ledger.record(&plan, 0, 7, &dones)
}

#[test]
fn an_exact_transfer_has_no_defect() {
    let record = push(|_| {});
    let interface = &record.interfaces[0];
    assert_eq!((interface.given, interface.received, interface.gross), (J, J, size(J)));
    assert_eq!(interface.transfer_defect, 0.0);
    // 1 − 0.1 is rounded once, by at most half a unit of 1.
    assert!(record.solvers.iter().all(|s| s.closure <= f64::EPSILON), "{:?}", record.solvers);
    assert!(record.solvers.iter().all(|s| s.angular_closure == 0.0));
    assert_eq!((record.window, record.end_s, record.state_hash), (0, 0.25, 7));
    assert_eq!(record.solvers[1].momentum, J);
}

#[test]
fn an_impulse_changed_by_one_unit_in_the_last_place_shows() {
    for (axis, j) in J.into_iter().enumerate() {
        let record = push(|dones| dones[1].applied[0].1[axis] = j.next_up());
        let defect = j.next_up() - j;
        assert_eq!(record.interfaces[0].transfer_defect, defect, "the difference of neighbours is exact");
    }
}

#[test]
fn an_impulse_that_was_never_applied_shows() {
    let record = push(|dones| dones[1].applied.clear());
    assert_eq!(record.interfaces[0].transfer_defect, size(J));
}

#[test]
fn closure_catches_a_reaction_that_was_listed_and_dropped() {
    let record = push(|dones| dones[1].report.bodies[0] = body([0.0; 3], [0.0; 3]));
    assert_eq!(record.interfaces[0].transfer_defect, 0.0, "the hosts agree");
    assert!(record.solvers[0].closure <= f64::EPSILON);
    // Relative to the largest Σ m|v| of the run: 1 kg m/s at the start.
    assert!((record.solvers[1].closure - size(J)).abs() <= f64::EPSILON, "{}", record.solvers[1].closure);
    assert!(record.solvers[1].closure > 1e-2);
}

#[test]
fn closure_catches_a_resolver_that_keeps_what_it_gave() {
    let record = push(|dones| dones[0].report.bodies[0] = body([1.0, 0.0, 0.0], [0.0; 3]));
    assert!(record.solvers[0].closure > 1e-2 && record.solvers[1].closure <= f64::EPSILON);
}

#[test]
fn an_impulse_from_outside_explains_a_change() {
    let outside = Wrench { linear: [0.0, 0.0, -5.0], angular: [0.25, 0.0, 0.0] };
    let change = |explained: bool| {
        push(|dones| {
            let state = &mut dones[1].report.bodies[0].momentum;
            *state = state.plus(outside);
            if explained {
                dones[1].report.external = outside;
            }
        })
    };
    let closures = |record: WindowRecord| (record.solvers[1].closure, record.solvers[1].angular_closure);
    let (linear, angular) = closures(change(true));
    // Sums with numbers of about 5 are rounded to half a unit there.
    assert!(linear <= 5.0 * f64::EPSILON && angular == 0.0, "{linear} {angular}");
    let (linear, angular) = closures(change(false));
    assert!(linear > 1.0 && angular > 0.5, "{linear} {angular}");
}

#[test]
fn parallel_impulses_arrive_one_window_later() {
    let (plan, scenes) = plan("parallel", "");
    let at = [0.0; 3];
    let impulses: [Vec3; 4] = [J, [0.5, 0.0, 0.0], [0.0; 3], [-0.25, 0.0, 1.0]];
    for lagging in [true, false] {
        let mut ledger = open(&plan, &scenes, &[body([4.0, 0.0, 0.0], at), body([0.0; 3], at)]);
        let (mut left, mut right): (Vec3, Vec3) = ([4.0, 0.0, 0.0], [0.0; 3]);
        for (window, sent) in impulses.into_iter().enumerate() {
            let applied = match (lagging, window) {
                (true, 0) => None,
                (true, w) => Some(impulses[w - 1]),
                (false, _) => Some(sent),
            };
            for axis in 0..3 {
                left[axis] -= sent[axis];
                right[axis] += applied.map_or(0.0, |j| j[axis]);
            }
            let mut dones = [done(body(left, at)), done(body(right, at))];
            dones[0].sent = vec![(0, sent, size(sent))];
            dones[1].applied = applied.map(|j| (0, j, size(j))).into_iter().collect();
            let record = ledger.record(&plan, window as u64, 0, &dones);
            assert_eq!(record.interfaces[0].transfer_defect == 0.0, lagging, "window {window}");
            // A few roundings of numbers of about 4, over the largest gross momentum of about 4.
            assert!(record.solvers.iter().all(|s| s.closure <= 4.0 * f64::EPSILON), "window {window}");
        }
    }
}

#[test]
fn angular_closure_compares_the_state_with_what_the_solver_received() {
    let place = [0.0, 2.0, 0.0];
    let spin = body(J, place).momentum;
    let told = |received: Wrench| {
        push(|dones| {
            dones[1].report.bodies[0] = body(J, place);
            let seen = InterfaceReport { interface: 0, received, gross: size(J), ..InterfaceReport::default() };
            dones[1].report.interfaces = vec![seen];
        })
        .solvers[1]
            .clone()
    };
    let right = told(spin);
    assert!(right.angular_closure == 0.0 && right.closure <= f64::EPSILON);
    let silent = told(Wrench { angular: [0.0; 3], ..spin });
    // The scale is Σ m|v| |x| + |L| of the run: both 2 |J| and |L| here, with |L| = 2 √(Jx² + Jz²).
    let l = 2.0 * (J[0] * J[0] + J[2] * J[2]).sqrt();
    let wanted = l / (2.0 * size(J) + l);
    assert!((silent.angular_closure - wanted).abs() <= 4.0 * f64::EPSILON, "{}", silent.angular_closure);
    assert!(silent.angular_closure > 1e-2 && silent.closure <= f64::EPSILON);
    // What crossed is counted from the hosts' lists: a wrong linear word of the solver changes nothing.
    assert!(told(Wrench { linear: [9.0; 3], ..spin }).closure <= f64::EPSILON);
}

#[test]
fn the_scale_is_the_largest_of_the_run() {
    let (plan, scenes) = plan("serial", "");
    let mut ledger = open(&plan, &scenes, &[body([8.0, 0.0, 0.0], [0.0; 3]), body([0.0; 3], [0.0; 3])]);
    let slow = || [done(body([2.0, 0.0, 0.0], [0.0; 3])), done(body([0.0; 3], [0.0; 3]))];
    let mut stopped = slow();
    stopped[0].report.external.linear = [-6.0, 0.0, 0.0];
    assert_eq!(ledger.record(&plan, 0, 0, &stopped).solvers[0].closure, 0.0);
    let mut nudged = slow();
    nudged[0].report.bodies[0] = body([1.0, 0.0, 0.0], [0.0; 3]);
    assert_eq!(ledger.record(&plan, 1, 0, &nudged).solvers[0].closure, 1.0 / 8.0);
}

#[test]
fn a_defect_with_nothing_to_compare_it_with_is_infinite_and_a_lost_number_stays_lost() {
    let (plan, scenes) = plan("serial", "");
    let still = || body([0.0; 3], [0.0; 3]);
    let mut ledger = open(&plan, &scenes, &[still(), still()]);
    let quiet = ledger.record(&plan, 0, 0, &[done(still()), done(still())]);
    assert!(quiet.solvers.iter().all(|s| s.closure == 0.0 && s.angular_closure == 0.0));
    let mut listed = done(still());
    listed.applied = vec![(0, J, size(J))];
    let record = ledger.record(&plan, 1, 0, &[done(still()), listed]);
    assert_eq!((record.solvers[0].closure, record.solvers[1].closure), (0.0, f64::INFINITY));
    let mut lost = still();
    lost.momentum.linear[1] = f64::NAN;
    let record = ledger.record(&plan, 2, 0, &[done(still()), done(lost)]);
    assert!(record.solvers[1].closure.is_nan(), "NaN passes no gate");
}

/// A window of the joined bodies: from one place of `right` to another, with these works and impulses of the spring.
fn stretch(from_m: f64, to_m: f64, work_j: [f64; 2], impulse: [Vec3; 2]) -> WindowRecord {
    let (plan, scenes) = plan("serial", SPRING);
    let at = |x: f64| body([0.0; 3], [x, 0.0, 0.0]);
    let mut ledger = open(&plan, &scenes, &[at(0.0), at(from_m)]);
    let sides = [(at(0.0), 0), (at(to_m), 1)].map(|(mut state, side)| {
        state.momentum = Wrench { linear: impulse[side], angular: [0.0; 3] };
        let received = state.momentum;
        let seen =
            InterfaceReport { interface: 0, received, gross: size(impulse[side]), work_j: work_j[side], residual: 0.0 };
        let mut done = done(state);
        done.report.interfaces = vec![seen];
        done.report.energy = Energy { kinetic_j: 0.5, potential_j: 0.25, dissipated_j: 3.0 };
        done
    });
    ledger.record(&plan, 0, 0, &sides)
}

#[test]
fn the_energy_of_a_link_is_that_of_its_spring_between_the_true_places() {
    let none = [[0.0; 3]; 2];
    // ½ · 8 N/m · (3 m − 1 m)² = 16 J.
    let record = stretch(1.0, 3.0, [-16.0, 0.0], none);
    assert_eq!(record.interfaces[0].stored_j, 16.0);
    assert_eq!(record.interfaces[0].work_defect, 0.0, "the work on the bodies is what the spring lost");
    // Two solvers with 0.75 J each; what is dissipated is gone.
    assert_eq!(record.total_energy_j, 1.5 + 16.0);
    // From 4 J to 1 J, but the bodies felt only 2 J.
    let record = stretch(0.0, 1.5, [1.5, 0.5], none);
    assert_eq!((record.interfaces[0].stored_j, record.interfaces[0].work_defect), (1.0, -1.0));
}

#[test]
fn the_defect_of_a_link_is_what_its_sides_disagree_about() {
    let record = stretch(1.0, 1.0, [0.0; 2], [J, J.map(|v| -v)]);
    assert_eq!(record.interfaces[0].transfer_defect, 0.0);
    assert!(record.solvers.iter().all(|s| s.closure == 0.0), "the sides explain their own states");
    let record = stretch(1.0, 1.0, [0.0; 2], [J, [-J[0], -J[1], 0.0]]);
    assert_eq!(record.interfaces[0].transfer_defect, J[2]);
    assert_eq!(record.interfaces[0].gross, size(J));
    assert!(record.solvers.iter().all(|s| s.closure == 0.0));
}

/// A window in which a moment crosses, or two where it takes two; `moment` is what the responder's host says, `words`
/// what the resolver and the responder book.
fn turn(scheme: &str, rigid: bool, moment: Moment, words: [Vec3; 2]) -> WindowRecord {
    let (mut plan, scenes) = plan(scheme, "");
    let shown = usize::from(plan.interfaces[0].from_b);
    if let (true, Content::Boundary { form, .. }) = (rigid, &mut plan.streams[shown].content) {
        *form = BoundaryForm::Proxy;
    }
    let still = || body([0.0; 3], [0.0; 3]);
    let mut ledger = open(&plan, &scenes, &[body([1.0, 0.0, 0.0], [0.0, 2.0, 0.0]), still()]);
    let seen = |angular| {
        let received = Wrench { linear: [0.0; 3], angular };
        vec![InterfaceReport { interface: 0, received, ..InterfaceReport::default() }]
    };
    let windows = if scheme == "parallel" { 2 } else { 1 };
    let window = |w: u64| {
        let mut dones = [done(still()), done(still())];
        if w == 0 {
            dones[0].report.interfaces = seen(words[0]);
        }
        if w + 1 == windows {
            dones[1].report.interfaces = seen(words[1]);
            dones[1].moments = vec![moment];
        }
        ledger.record(&plan, w, 0, &dones)
    };
    (0..windows).map(window).last().expect("there are windows")
}

#[test]
fn a_moment_that_crossed_and_is_not_in_the_books_shows() {
    let crossed: Vec3 = [0.0, 0.0, 0.5];
    let moment = Moment { interface: 0, given: crossed, applied: crossed, ..Moment::default() };
    // Scale: Σ m|v| |x| + |L| of the start, 2 + 2 kg m²/s.
    for (scheme, rigid) in [("serial", false), ("serial", true), ("parallel", false), ("parallel", true)] {
        let turned = |words| {
            let record = turn(scheme, rigid, moment, words);
            let [a, b] = [0, 1].map(|i: usize| record.solvers[i].moment_closure);
            (a, b, record.interfaces[0].moment_defect)
        };
        assert_eq!(turned([[0.0, 0.0, -0.5], crossed]), (0.0, 0.0, 0.0), "{scheme}");
        assert_eq!(turned([[0.0, 0.0, -0.5], [0.0; 3]]), (0.0, 0.125, 0.0), "{scheme}: the responder dropped it");
        // A wrench has room for every moment; impulses on samples act where the samples are.
        let kept = if rigid { (0.125, 0.0, 0.0) } else { (0.0, 0.0, 0.5) };
        assert_eq!(turned([[0.0; 3], crossed]), kept, "{scheme}: the resolver never lost it");
        let (a, _, defect) = turned([[f64::NAN; 3], crossed]);
        assert!(if rigid { a } else { defect }.is_nan(), "{scheme}: a lost number stays lost");
    }
}

#[test]
fn the_way_within_the_window_excuses_as_much_as_it_explains() {
    let moment = Moment {
        interface: 0,
        given: [0.0, 0.0, 0.5],
        given_reach: 0.125,
        applied: [0.0, 0.0, 0.75],
        applied_reach: 0.25,
    };
    let record = turn("serial", false, moment, [[0.0, 0.0, -0.375], [0.0, 0.0, 1.25]]);
    assert_eq!(record.solvers.iter().map(|s| s.moment_closure).collect::<Vec<_>>(), [0.0, 0.25 / 4.0]);
    // Between the two places of the samples; the resolver's word is within reach.
    assert_eq!(record.interfaces[0].moment_defect, 0.25);
}
