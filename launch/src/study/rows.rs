//! `study.csv`: one line a run.

use std::collections::BTreeMap;

use super::result::{CaseResult, Row};

/// Columns that every line has, behind the name of the case.
const COLUMNS: [&str; 25] = [
    "version",
    "machine",
    "outcome",
    "exit_code",
    "error",
    "error_coupling",
    "error_solver",
    "wall_s",
    "wall_spread",
    "runs",
    "beside_others",
    "simulated_s",
    "core_s",
    "compute_s",
    "wait_s",
    "transfer_s",
    "window_s",
    "substeps",
    "energy_drift",
    "momentum_defect",
    "complaints",
    "state_hash",
    "folder",
    "cached",
    "why",
];

/// All runs of all cases. Columns of what was varied stand first, those of single quantities (`error:NAME`) last; a
/// line leaves those of other cases empty.
pub(crate) fn csv(cases: &[CaseResult], version: &str, machine: &str) -> String {
    let unique = |names: Vec<String>| {
        let mut kept: Vec<String> = Vec::new();
        for name in names {
            if !kept.contains(&name) {
                kept.push(name);
            }
        }
        kept
    };
    let keys = unique(cases.iter().flat_map(|c| c.vary.iter().map(|f| f.key.clone())).collect());
    let errors = unique(cases.iter().flat_map(|c| c.quantities.iter().map(|q| format!("error:{}", q.name))).collect());
    let mut out = csv::Writer::from_writer(Vec::new());
    let head = ["case"].into_iter().chain(keys.iter().map(String::as_str));
    let head = head.chain(COLUMNS).chain(errors.iter().map(String::as_str));
    // Writing to memory cannot fail.
    let _ = out.write_record(head);
    for case in cases {
        for row in &case.rows {
            let mut cells = cells(row);
            cells.insert("version".into(), version.to_owned());
            cells.insert("machine".into(), machine.to_owned());
            cells.extend(row.settings.iter().cloned());
            let quantities = case.quantities.iter().zip(&row.errors);
            cells.extend(quantities.map(|(q, error)| (format!("error:{}", q.name), number(*error))));
            let named = |name: &str| cells.get(name).cloned().unwrap_or_default();
            let line = [case.name.clone()].into_iter().chain(keys.iter().map(|k| named(k)));
            let _ = out.write_record(line.chain(COLUMNS.map(named)).chain(errors.iter().map(|e| named(e))));
        }
    }
    String::from_utf8(out.into_inner().unwrap_or_default()).unwrap_or_default()
}

fn number(value: Option<f64>) -> String {
    value.map(|v| format!("{v:e}")).unwrap_or_default()
}

fn cells(row: &Row) -> BTreeMap<String, String> {
    let cost = row.cost.as_ref();
    let text = |value: Option<String>| value.unwrap_or_default();
    let cells = [
        ("outcome", row.outcome.map_or("", super::outcome::Class::word).to_owned()),
        ("exit_code", row.exit_code.to_string()),
        ("error", number(row.error)),
        ("error_coupling", number(row.error_coupling)),
        ("error_solver", number(row.error_solver)),
        ("wall_s", number(cost.map(|c| c.wall_s))),
        ("wall_spread", number(cost.map(|c| c.wall_spread))),
        ("runs", text(cost.map(|c| c.runs.to_string()))),
        ("beside_others", text(cost.map(|c| c.beside_others.to_string()))),
        ("simulated_s", number(cost.map(|c| c.simulated_s))),
        ("core_s", number(cost.and_then(|c| c.core_s))),
        ("compute_s", number(cost.map(|c| c.sum(|p| p.compute_s)))),
        ("wait_s", number(cost.map(|c| c.sum(|p| p.wait_s)))),
        ("transfer_s", number(cost.map(|c| c.sum(|p| p.transfer_s)))),
        ("window_s", number(row.window_s)),
        ("substeps", text(row.substeps.map(|n| n.to_string()))),
        ("energy_drift", number(row.energy_drift)),
        ("momentum_defect", number(row.momentum_defect)),
        ("complaints", row.complaints.to_string()),
        ("state_hash", text(row.state_hash.clone())),
        ("folder", row.folder.clone()),
        ("cached", row.cached.to_string()),
        ("why", text(row.why.clone())),
    ];
    cells.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
