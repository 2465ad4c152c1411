//! Completeness, order, form and finiteness of answers.

use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Wrench};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Outputs, Report};

use crate::rule::Rule::{BindingTerm, DescribeAlways, FiniteAnswers, ShapeOfAnswers};
use crate::trial::{Trial, Verdict, bits};
use crate::{Case, Make};

/// Deviation from 1 allowed to the norm of a quaternion: rounding in single precision.
const UNIT: f64 = 1e-6;

pub(crate) fn check(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let Ok((mut trial, setup)) = Trial::start(make, case) else { return };
    let before = make().describe();
    verdict.must(bits(&trial.plugin.describe()) == bits(&before), DescribeAlways, || "set-up changes it".into());
    let coupled = coupled_bodies(case);
    let shown: Vec<&str> = setup.boundaries.iter().map(|b| b.body.as_str()).collect();
    verdict.must(shown == coupled, ShapeOfAnswers, || {
        format!("set-up shows {shown:?}, the bodies with interfaces are {coupled:?}")
    });
    let particles = setup.particles.len();
    verdict.must(particles == case.scene.bodies.len(), ShapeOfAnswers, || {
        format!("particle counts of {particles} bodies")
    });
    for b in &setup.boundaries {
        boundary(&b.body, &b.state, Some(&b.statics), before.boundary, verdict);
    }
    report(case, &setup.report, verdict);
    for window in 0..case.windows.len() {
        let Ok(outputs) = trial.window(window) else { return };
        let shown: Vec<&str> = outputs.boundaries.iter().map(|b| b.body.as_str()).collect();
        verdict.must(shown == coupled, ShapeOfAnswers, || {
            format!("window {window} shows {shown:?}, the bodies with interfaces are {coupled:?}")
        });
        for b in &outputs.boundaries {
            let statics = setup.boundaries.iter().find(|s| s.body == b.body).map(|s| &s.statics);
            boundary(&b.body, &b.state, statics, before.boundary, verdict);
        }
        report(case, &outputs.report, verdict);
        impulses(case, &outputs, verdict);
    }
}

/// Bodies with an interface, in scene order.
fn coupled_bodies(case: &Case) -> Vec<&str> {
    let names = case.scene.bodies.iter().map(|b| b.name.as_str());
    names.filter(|name| case.scene.interfaces.iter().any(|i| i.own == *name)).collect()
}

fn boundary(
    body: &str,
    state: &BoundaryState,
    statics: Option<&SampleStatics>,
    form: BoundaryForm,
    verdict: &mut Verdict,
) {
    match (state, form) {
        (BoundaryState::Proxy(_), BoundaryForm::Proxy) => {}
        (BoundaryState::Samples(s), BoundaryForm::SamplesF32 { normals } | BoundaryForm::SamplesF64 { normals }) => {
            let n = s.position.len();
            let with_normals = if normals { n } else { 0 };
            verdict.must(s.velocity.len() == n && s.normal.len() == with_normals, ShapeOfAnswers, || {
                format!("columns of `{body}` have {n}, {} and {} entries", s.velocity.len(), s.normal.len())
            });
            if let Some(c) = statics {
                let columns = [c.id.len(), c.area_m2.len(), c.volume_m3.len(), c.mass_kg.len()];
                verdict.must(columns.iter().all(|&l| l == n), ShapeOfAnswers, || {
                    format!("{n} samples of `{body}`, but constants for {columns:?}")
                });
            }
        }
        _ => verdict.add(ShapeOfAnswers, format!("`{body}` does not show the declared form {form:?}")),
    }
    verdict.must(finite_boundary(state), FiniteAnswers, || format!("boundary of `{body}`"));
}

/// Scripted bodies have infinite mass and inertia; everything else is a number.
fn finite_boundary(state: &BoundaryState) -> bool {
    match state {
        BoundaryState::Samples(s) => {
            s.position.iter().chain(&s.velocity).chain(&s.normal).flatten().all(|v| v.is_finite())
        }
        BoundaryState::Proxy(p) => {
            let scripted = p.mass.is_infinite() && p.mass > 0.0;
            let inertia = p.inertia.iter().all(|v| v.is_finite() || scripted && !v.is_nan());
            let turn = p.orientation.iter().map(|c| c * c).sum::<f64>();
            inertia
                && (p.mass.is_finite() || scripted)
                && (turn - 1.0).abs() < UNIT
                && p.share.is_finite()
                && [p.position, p.linear_velocity, p.angular_velocity, p.background_linear, p.background_angular]
                    .iter()
                    .flatten()
                    .all(|v| v.is_finite())
        }
    }
}

pub(crate) fn finite_wrench(w: &Wrench) -> bool {
    w.linear.iter().chain(&w.angular).all(|v| v.is_finite())
}

/// Whether every number of an answer is one.
pub(crate) fn finite_outputs(outputs: &Outputs) -> bool {
    let impulses = outputs.impulses.iter().all(|(_, j)| match j {
        Impulses::Samples(each) => each.iter().flatten().all(|v| v.is_finite()),
        Impulses::Rigid(w) => finite_wrench(w),
    });
    impulses && outputs.boundaries.iter().all(|b| finite_boundary(&b.state)) && finite_report(&outputs.report)
}

fn finite_report(r: &Report) -> bool {
    let bodies = r.bodies.iter().all(|b| {
        let vectors = [b.position_m, b.linear_velocity_m_s, b.angular_velocity_rad_s];
        let turn = b.orientation.iter().map(|c| c * c).sum::<f64>();
        vectors.iter().flatten().all(|v| v.is_finite())
            && finite_wrench(&b.momentum)
            && [b.mass_kg, b.gross_momentum, b.max_displacement_m].iter().all(|v| v.is_finite())
            && (turn - 1.0).abs() < UNIT
    });
    let interfaces = r
        .interfaces
        .iter()
        .all(|i| finite_wrench(&i.received) && [i.gross, i.work_j, i.residual].iter().all(|v| v.is_finite()));
    let energies = [r.energy.kinetic_j, r.energy.potential_j, r.energy.dissipated_j, r.supplied_j];
    let energy = energies.iter().all(|v| v.is_finite());
    bodies && interfaces && energy && finite_wrench(&r.external)
}

fn report(case: &Case, report: &Report, verdict: &mut Verdict) {
    let (found, expected) = (report.bodies.len(), case.scene.bodies.len());
    verdict.must(found == expected, ShapeOfAnswers, || format!("states of {found} bodies instead of {expected}"));
    for view in &case.scene.interfaces {
        let rows = report.interfaces.iter().filter(|i| i.interface == view.id).count();
        verdict.must(rows == 1, ShapeOfAnswers, || format!("{rows} reports of interface {} instead of 1", view.id));
    }
    verdict.must(report.substeps == 0 || !report.substep_bound_by.is_empty(), BindingTerm, || {
        format!("{} substeps, bound by nothing named", report.substeps)
    });
    verdict.must(finite_report(report), FiniteAnswers, || "the report".into());
}

fn impulses(case: &Case, outputs: &Outputs, verdict: &mut Verdict) {
    for view in case.scene.interfaces.iter().filter(|v| v.role.gives_impulses()) {
        let given: Vec<_> = outputs.impulses.iter().filter(|(id, _)| *id == view.id).collect();
        verdict.must(given.len() == 1, ShapeOfAnswers, || {
            format!("{} sets of impulses on interface {} instead of 1", given.len(), view.id)
        });
        let samples = case.partners.iter().find(|p| p.interface == view.id).map(|p| p.statics.len());
        if let (Some((_, Impulses::Samples(each))), Some(n)) = (given.first(), samples) {
            verdict.must(each.len() == n, ShapeOfAnswers, || {
                format!("{} impulses on the {n} samples of `{}`", each.len(), view.partner)
            });
        }
    }
    let known = |id| case.scene.interfaces.iter().any(|v| v.id == id && v.role.gives_impulses());
    for (id, _) in outputs.impulses.iter().filter(|(id, _)| !known(*id)) {
        verdict.add(ShapeOfAnswers, format!("impulses on interface {id}, where it gives none"));
    }
    verdict.must(finite_outputs(outputs), FiniteAnswers, || "boundaries, impulses or report".into());
}
