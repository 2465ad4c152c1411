//! A cloth trough filled with water: the shape of a sheet under hydrostatic pressure, the classical lintearia.
//!
//! A weightless sheet that cannot be stretched hangs between two supports at one height, `W` apart, filled to the
//! supports. Pressure acts across it, so its tension `T` is the same everywhere and its curvature is `ρ g depth / T`: the
//! same equation as that of a bent rod (an elastica; Jacob Bernoulli 1692). With a length of `1.1 W` and `W` = 1 m the
//! integral gives what stands below; `2 T sin θ = ρ g A` holds to the digits printed.

mod common;

use common::{Run, cloth, pair};
use cosplat_conformance::parts;
use cosplat_core::boundary::{Impulses, add, cross, norm, scale, sub};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, ViewRole};
use cosplat_core::scene::Source;

/// Sag \[m\], water in a section \[m²\], and force on both supports for a metre of width, `ρ g A` \[N/m\].
const SAG: f64 = 0.205_06;
const WATER: f64 = 0.133_83;
const REACTION: f64 = 1000.0 * 9.81 * WATER;

const LENGTH: f64 = 1.1;
/// Squares along the sheet and across it.
const SQUARES: [usize; 2] = [44, 3];
const WIDTH: f64 = LENGTH * SQUARES[1] as f64 / SQUARES[0] as f64;
const WINDOW: f64 = 2e-3;

/// Impulse of the water above the sheet, at least so deep \[m\], on each vertex in a window \[N s\].
fn pressure(x: &[[f64; 3]], least: f64) -> Vec<[f64; 3]> {
    let row = SQUARES[0] + 1;
    let mut all = vec![[0.0; 3]; x.len()];
    for (i, j) in (0..SQUARES[1]).flat_map(|j| (0..SQUARES[0]).map(move |i| (i, j))) {
        let [a, b, c, d] = [j * row + i, j * row + i + 1, (j + 1) * row + i + 1, (j + 1) * row + i];
        // Across its diagonals a square is flat: half their cross product is its area, upwards.
        let area = scale(cross(sub(x[c], x[a]), sub(x[d], x[b])), 0.5);
        let depth = -0.25 * [a, b, c, d].iter().map(|&k| x[k][2]).sum::<f64>();
        let push = scale(area, -0.25 * WINDOW * 1000.0 * 9.81 * depth.max(least));
        for k in [a, b, c, d] {
            all[k] = add(all[k], push);
        }
    }
    all
}

#[test]
fn a_trough_of_water_hangs_as_an_elastica() {
    let source = Source::Plane { size_m: Some([LENGTH, WIDTH]) };
    let mut body = parts::body("trough", cloth(0.0, 1e6), source, [0.0; 3]);
    body.spacing_m = Some(LENGTH / SQUARES[0] as f64);
    // A sweep leaves a compliance of about h²/m a link: with ten of them, and 2 kg/m², the sheet is 0.1 % longer. Nothing
    // but the water pulls at it, so that its mass has no part in the shape.
    body.mass_kg = Some(2.0 * LENGTH * WIDTH);
    let windows = 1200;
    let mut scene = parts::solver_scene("pbd", vec![body], windows, WINDOW);
    // The supports move together in the first half second, and the sheet bows under its water.
    let rows = (0..=SQUARES[1]).map(|j| WIDTH * (j as f64 / SQUARES[1] as f64 - 0.5));
    let pull = |side: f64| {
        let at = rows.clone().map(move |y| [side * 0.5 * LENGTH, y, 0.0]);
        at.map(move |at| serde_json::json!({ "at": at, "velocity": [-side * 0.1, 0.0, 0.0], "until": 0.5 }))
    };
    let pulls: Vec<_> = pull(-1.0).chain(pull(1.0)).collect();
    scene.params.insert("pulls".into(), serde_json::json!({ "trough": pulls }));
    scene.params.insert("self_collision".into(), false.into());
    scene.params.insert("max_substep_s".into(), 1e-4.into());
    scene.params.insert("iterations".into(), 10.into());
    scene.params.insert("damping_1_s".into(), 10.0.into());
    let mut view = parts::view(1, ViewRole::ContactResponder, "trough", "water", Vec::new());
    view.partner_form = BoundaryForm::SamplesF64 { normals: true };
    view.pair = Some(pair("trough", "water", 0.0));
    scene.interfaces = vec![view];
    let mut run = Run::new(scene);
    let (mut carried, mut seen) = (0.0, 0.0);
    for window in 0..windows {
        // In the first 0.8 s everything is under at least 3 cm of water, which says which way is down.
        let each = pressure(&run.vertices("trough"), if window < 400 { 0.03 } else { 0.0 });
        let given: f64 = each.iter().map(|j| j[2]).sum();
        let inputs = Inputs { partners: Vec::new(), impulses: vec![parts::spread(1, Impulses::Samples(each))] };
        let out = run.step_with(&inputs).expect("a step");
        if window >= windows - 100 {
            carried += out.report.external.linear[2];
            seen += WINDOW;
            assert!(given < 0.0);
        }
    }
    let x = run.vertices("trough");
    let middle = &x[SQUARES[0] + 1..2 * (SQUARES[0] + 1)];
    let sag = -middle.iter().map(|x| x[2]).fold(0.0, f64::min);
    let water: f64 = middle.windows(2).map(|p| -0.5 * (p[0][2] + p[1][2]) * (p[1][0] - p[0][0])).sum();
    let length: f64 = middle.windows(2).map(|p| norm(sub(p[1], p[0]))).sum();
    let reaction = carried / seen / WIDTH;
    println!("sag {sag:.5} m, water {water:.5} m², reaction {reaction:.1} N/m, length {length:.5} m");
    // The published gates: 3 % of sag and reaction, 1 % of the water.
    assert!((sag / SAG - 1.0).abs() < 0.03, "{sag}");
    assert!((reaction / REACTION - 1.0).abs() < 0.03, "{reaction}");
    assert!((water / WATER - 1.0).abs() < 0.01, "{water}");
    assert!(run.defect[0] < 1e-12 * run.gross.max(1.0), "{:?}", run.defect);
}
