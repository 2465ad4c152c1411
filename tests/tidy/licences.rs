//! May everything that is built be given away with this project?

use cargo_metadata::Package;

use crate::dependencies::graph;
use crate::spdx::satisfied;
use crate::tree::lines;

/// Licences that ask for no more than their text and a credit.
const ACCEPTED: [&str; 12] = [
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "CDLA-Permissive-2.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Zlib",
];

/// Exceptions that only add permissions.
const EXCEPTIONS: [&str; 1] = ["LLVM-exception"];

/// Packages under a licence that is accepted for them alone, and why.
const ALONE: [(&str, &str, &str); 2] = [
    ("indent", "MPL-2.0", "copyleft by file; used unmodified, behind `re_chunk_store` of rerun; named in NOTICE"),
    ("option-ext", "MPL-2.0", "copyleft by file; used unmodified, behind `shellexpand` of zenoh; named in NOTICE"),
];

/// Why a package may not be used, if so.
fn objection(name: &str, licence: Option<&str>) -> Option<String> {
    let Some(licence) = licence else {
        return Some("names no licence".to_owned());
    };
    let alone = |id: &str| ALONE.iter().any(|(package, own, _)| *package == name && *own == id);
    let accepts = |id: &str, exception: Option<&str>| {
        (ACCEPTED.contains(&id) || alone(id)) && exception.is_none_or(|e| EXCEPTIONS.contains(&e))
    };
    match satisfied(licence, &accepts) {
        Some(true) => None,
        Some(false) => Some(format!("is under `{licence}`")),
        None => Some(format!("has a licence field that is no SPDX expression: `{licence}`")),
    }
}

#[test]
fn every_package_has_an_accepted_licence() {
    let refused: Vec<String> = graph()
        .packages()
        .filter_map(|p: &Package| {
            Some(format!("`{}` {} {}", p.name, p.version, objection(&p.name, p.license.as_deref())?))
        })
        .collect();
    assert!(
        refused.is_empty(),
        "choose another package, or, if the licence asks for no more than its text and a credit, add it to \
         tests/tidy/licences.rs:{}",
        lines(&refused)
    );
}

#[test]
fn licences_accepted_for_one_package_are_still_needed() {
    for (name, licence, _) in ALONE {
        let used = graph().packages().any(|p| p.name.as_str() == name && p.license.as_deref() == Some(licence));
        assert!(used, "no package `{name}` under `{licence}` is used any more: remove it from tests/tidy/licences.rs");
    }
}

#[test]
fn a_licence_that_asks_for_more_is_refused() {
    assert_eq!(objection("a", Some("EPL-2.0 OR Apache-2.0")), None);
    assert_eq!(objection("option-ext", Some("MPL-2.0")), None);
    assert!(objection("a", Some("MPL-2.0")).is_some());
    assert!(objection("a", Some("GPL-3.0-only")).is_some());
    assert!(objection("a", Some("Apache-2.0 WITH Other-exception")).is_some());
    assert!(objection("a", Some("MIT ?? ISC")).is_some());
    assert!(objection("a", None).is_some());
}
