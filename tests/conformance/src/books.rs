//! Momentum: what changed against what explains it.

use cosplat_core::boundary::{Impulses, Wrench, norm, sub};
use cosplat_core::plugin::{Outputs, Report};

use crate::rule::Rule::{MomentumCloses, ReceivedIsGiven};
use crate::trial::{Trial, Verdict};
use crate::{Case, Make};

/// Largest momenta so far: Σ m|v|, and |L| and Σ m|v||x|.
#[derive(Clone, Copy, Default)]
struct Scale {
    linear: f64,
    angular: f64,
}

impl Scale {
    fn widen(&mut self, report: &Report) {
        let linear: f64 = report.bodies.iter().map(|b| b.gross_momentum).sum();
        let lever =
            |b: &cosplat_core::plugin::BodyState| b.gross_momentum * norm(b.position_m) + norm(b.momentum.angular);
        self.linear = self.linear.max(linear);
        self.angular = self.angular.max(report.bodies.iter().map(lever).sum());
    }
}

/// `open` over `scale`; an open rest without any scale is infinitely large.
fn relative(open: f64, scale: f64) -> f64 {
    if open == 0.0 { 0.0 } else { open / scale }
}

pub(crate) fn check(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let Ok((mut trial, setup)) = Trial::start(make, case) else { return };
    let mut scale = Scale::default();
    scale.widen(&setup.report);
    let mut before = momentum(&setup.report);
    for window in 0..case.windows.len() {
        let Ok(outputs) = trial.window(window) else { return };
        scale.widen(&outputs.report);
        let now = momentum(&outputs.report);
        // The linear part is closed with what crossed, the angular part with what the solver says it took: only there
        // the lever arm of an impulse spread over substeps is known.
        let mut open = now.minus(before).minus(outputs.report.external);
        for row in &outputs.report.interfaces {
            let crossed = crossed(case, window, row.interface, &outputs);
            let linear = crossed.unwrap_or(row.received.linear);
            open = open.minus(Wrench { linear, angular: row.received.angular });
            if let Some(crossed) = crossed {
                let off = norm(sub(crossed, row.received.linear));
                verdict.must(relative(off, scale.linear) <= case.closure_gate, ReceivedIsGiven, || {
                    format!("interface {} in window {window}: the report is {off:e} N s off", row.interface)
                });
            }
        }
        for (name, open, scale) in
            [("linear", norm(open.linear), scale.linear), ("angular", norm(open.angular), scale.angular)]
        {
            let closure = relative(open, scale);
            // Not `>`: a closure that is not a number must not pass.
            verdict.must(closure <= case.closure_gate, MomentumCloses, || {
                format!("{name} momentum in window {window}: {closure:e} of the largest, gate {:e}", case.closure_gate)
            });
        }
        before = now;
    }
}

fn momentum(report: &Report) -> Wrench {
    report.bodies.iter().fold(Wrench::default(), |sum, b| sum.plus(b.momentum))
}

/// Impulse on the own body that really crossed an interface \[N s\]; none for links whose sides compute it themselves.
fn crossed(case: &Case, window: usize, id: u16, outputs: &Outputs) -> Option<[f64; 3]> {
    let role = case.scene.interfaces.iter().find(|v| v.id == id)?.role;
    if role.takes_impulses() {
        let heard = case.windows[window].impulse(id).map(|i| i.impulses.total());
        return Some(heard.unwrap_or_default());
    }
    let given = outputs.impulses.iter().find(|(i, _)| *i == id).map(|(_, j)| Impulses::total(j));
    role.gives_impulses().then(|| given.unwrap_or_default().map(|v| -v))
}
