//! What all documents keep to, and how their lists are compared with the code.

use std::collections::BTreeSet;

use crate::markdown::{first_cells, links, literals, section};
use crate::tree::{files, lines, text};

pub(crate) const README: &str = "README.md";
pub(crate) const ARCHITECTURE: &str = "ARCHITECTURE.md";

/// What one list has and the other lacks, in words.
pub(crate) fn difference(documented: &BTreeSet<String>, there: &BTreeSet<String>, document: &str) -> Vec<String> {
    let missing = there.difference(documented).map(|x| format!("`{x}` is missing in {document}"));
    let gone = documented.difference(there).map(|x| format!("`{x}` stands in {document} and does not exist"));
    missing.chain(gone).collect()
}

/// First cells of the table in a section, without backticks.
pub(crate) fn listed(document: &str, heading: &str) -> BTreeSet<String> {
    let text = text(document);
    let part = section(&text, heading);
    let part = part.unwrap_or_else(|| panic!("{document} has no section `{heading}`"));
    first_cells(part).into_iter().map(|cell| cell.trim_matches('`').to_owned()).collect()
}

#[test]
fn lists_that_differ_are_noticed() {
    let set = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<BTreeSet<_>>();
    assert!(difference(&set(&["a"]), &set(&["a"]), "X").is_empty());
    let found = difference(&set(&["a", "b"]), &set(&["b", "c"]), "X");
    assert_eq!(found, ["`c` is missing in X", "`a` stands in X and does not exist"]);
}

/// Paths that a document names and that do not exist: literals that begin with a top folder, and links.
fn dead_paths(document: &str, there: &BTreeSet<String>) -> Vec<String> {
    let tops = ["core/", "solvers/", "bridges/", "viewer/", "launch/", "tests/"];
    let is_path = |word: &&str| tops.iter().any(|top| word.starts_with(top)) && !word.contains(['<', '*', ' ', '{']);
    let named = literals(document).into_iter().filter(is_path).chain(links(document));
    let dead = |path: &&str| {
        let path = path.split('#').next().unwrap_or_default();
        let folder = format!("{}/", path.trim_end_matches('/'));
        !(path.is_empty() || there.contains(path) || there.iter().any(|p| p.starts_with(&folder)))
    };
    named.filter(dead).map(str::to_owned).collect()
}

#[test]
fn paths_in_the_documents_exist() {
    let there: BTreeSet<String> = files().into_iter().collect();
    for document in [README, ARCHITECTURE, "CHANGELOG.md", "NOTICE"] {
        let dead = dead_paths(&text(document), &there);
        assert!(dead.is_empty(), "{document} names what is not there; bring it up to date:{}", lines(&dead));
    }
}

#[test]
fn a_path_that_does_not_exist_is_noticed() {
    let there = BTreeSet::from(["core/src/lib.rs".to_owned(), "README.md".to_owned()]);
    let text = "`core/src` `core/src/lib.rs` `core/` `core/gone` `core::time` `viewer/<x>` [a](README.md#b) [c](gone.md) \
                [d](https://x.y)";
    assert_eq!(dead_paths(text, &there), ["core/gone", "gone.md"]);
}
