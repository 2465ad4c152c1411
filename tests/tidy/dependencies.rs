//! Who may use what, in the graph as it is resolved, not as it is declared.

use std::collections::{BTreeMap, BTreeSet};
use std::env;
use std::process::Command;
use std::sync::OnceLock;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Node, Package, PackageId};

use crate::tree::{lines, root};

/// What must never be built before `cosplat-core`, so that an edit of a solver waits for none of it.
const HEAVY_FOR_CORE: [&str; 5] = ["zenoh", "tokio", "wgpu", "rerun", "rapier3d"];
/// The same for solver libraries, which may use a field library of their own.
const HEAVY_FOR_SOLVERS: [&str; 4] = ["zenoh", "tokio", "wgpu", "rerun"];
/// Below `solvers/` but no solver library: the example of a foreign plugin is a program and speaks on the bus.
const NO_SOLVER_LIBRARY: [&str; 1] = ["cosplat-dummy"];
/// Packages that one crate alone may name, so that they can be replaced in one place.
const SOLE_USERS: [(&str, &str); 4] =
    [("zenoh", "cosplat-bus"), ("rerun", "cosplat-viewer"), ("wgpu", "cosplat-viewer"), ("rapier3d", "cosplat-rigid")];

/// Packages that a crate of ours names and that are there in other versions too: which ones, and why that stays.
const DUPLICATES: [(&str, &[&str], &str); 3] = [
    ("base64", &["0.22", "0.23"], "0.22 comes with zenoh and arrow, 0.23 with `re_auth` of rerun"),
    (
        "getrandom",
        &["0.2", "0.3", "0.4"],
        "0.2 comes with `flume` and 0.3 with `ahash`, both of zenoh, 0.4 with `tempfile` and `uuid`; ours is one of them",
    ),
    ("schemars", &["0.9", "1"], "0.9 is an option of `serde_with` in zenoh and is never compiled"),
];

/// The resolved packages of this machine's kind.
pub(crate) struct Graph {
    metadata: Metadata,
}

/// The graph, asked for once.
pub(crate) fn graph() -> &'static Graph {
    static GRAPH: OnceLock<Graph> = OnceLock::new();
    GRAPH.get_or_init(|| {
        let mut command = MetadataCommand::new();
        command.current_dir(root()).other_options(vec![
            "--locked".to_owned(),
            "--offline".to_owned(),
            "--filter-platform".to_owned(),
            host(),
        ]);
        let metadata = command.exec().unwrap_or_else(|error| panic!("`cargo metadata --locked` failed: {error}"));
        Graph { metadata }
    })
}

/// Kind of this machine, as cargo names it: packages for others need not be there.
fn host() -> String {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let answer = Command::new(cargo).arg("-vV").output().expect("`cargo -vV` runs where `cargo test` does");
    let text = String::from_utf8_lossy(&answer.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.expect("`cargo -vV` names its host").to_owned()
}

impl Graph {
    /// The workspace and everything cargo gives.
    pub(crate) fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// Crates of this project.
    pub(crate) fn members(&self) -> Vec<&Package> {
        self.metadata.workspace_packages()
    }

    fn nodes(&self) -> &[Node] {
        &self.metadata.resolve.as_ref().expect("`cargo metadata` resolves").nodes
    }

    fn node(&self, id: &PackageId) -> &Node {
        self.nodes().iter().find(|n| n.id == *id).expect("every package of the graph has a node")
    }

    fn package(&self, id: &PackageId) -> &Package {
        &self.metadata[id]
    }

    /// Every package that is used, ours included.
    pub(crate) fn packages(&self) -> impl Iterator<Item = &Package> {
        self.nodes().iter().map(|node| self.package(&node.id))
    }

    fn member(&self, name: &str) -> &Package {
        let found = self.members().into_iter().find(|p| p.name.as_str() == name);
        found.unwrap_or_else(|| panic!("there is no crate `{name}`: bring tests/tidy/dependencies.rs up to date"))
    }

    /// Shortest way by which one of `wanted` gets into what is built before `from`, as names.
    fn way_to(&self, from: &Package, wanted: &[&str]) -> Option<Vec<String>> {
        let mut seen = BTreeSet::from([from.id.clone()]);
        let mut ways = vec![vec![from.id.clone()]];
        while !ways.is_empty() {
            let mut longer = Vec::new();
            for way in &ways {
                for id in built_before(self.node(way.last()?)) {
                    let step: Vec<PackageId> = way.iter().chain([id]).cloned().collect();
                    if wanted.contains(&self.package(id).name.as_str()) {
                        return Some(step.iter().map(|id| self.package(id).name.to_string()).collect());
                    }
                    if seen.insert(id.clone()) {
                        longer.push(step);
                    }
                }
            }
            ways = longer;
        }
        None
    }
}

/// Dependencies that are built before a package: normal ones and those of its build script, not those of its tests.
fn built_before(node: &Node) -> impl Iterator<Item = &PackageId> {
    let counts = |kind: DependencyKind| matches!(kind, DependencyKind::Normal | DependencyKind::Build);
    node.deps.iter().filter(move |d| d.dep_kinds.iter().any(|k| counts(k.kind))).map(|d| &d.pkg)
}

fn assert_light(crate_: &Package, heavy: &[&str]) {
    if let Some(way) = graph().way_to(crate_, heavy) {
        panic!(
            "`{}` must be built without `{}`, but it comes in by {}: move what needs it to `bridges/`, `viewer/` or \
             `launch/`, see \"Who may use what\" in ARCHITECTURE.md",
            crate_.name,
            way.last().map_or("", String::as_str),
            way.join(" -> ")
        );
    }
}

/// How far from the core a crate stands, by its folder: it may use what stands nearer, and nothing beside it.
fn distance(folder: &str, name: &str) -> u8 {
    match folder.split('/').next() {
        Some("core") => 0,
        Some("solvers") if NO_SOLVER_LIBRARY.contains(&name) => 2,
        Some("solvers" | "bridges") => 1,
        Some("viewer") => 2,
        Some("launch") => 3,
        _ => 4,
    }
}

#[test]
fn crates_of_this_project_use_each_other_in_one_direction() {
    let folder = |p: &Package| {
        let inside = p.manifest_path.as_std_path().strip_prefix(root()).expect("members lie in the workspace");
        inside.to_string_lossy().into_owned()
    };
    let far = |p: &Package| distance(&folder(p), &p.name);
    let members = graph().members();
    for user in &members {
        let used = built_before(graph().node(&user.id)).filter_map(|id| members.iter().find(|m| m.id == *id));
        for used in used {
            assert!(
                far(used) < far(user),
                "`{}` must not use `{}`: arrows point from `launch` to `bridges` and `solvers`, and from there to `core`; \
                 what two of them need belongs into `core`",
                user.name,
                used.name
            );
        }
    }
    assert!(distance("solvers/a", "a") == distance("bridges/b", "b"), "neither may use the other");
}

#[test]
fn heavy_packages_stay_out_of_core() {
    assert_light(graph().member("cosplat-core"), &HEAVY_FOR_CORE);
}

#[test]
fn heavy_packages_stay_out_of_solver_libraries() {
    let below = root().join("solvers");
    let solvers: Vec<&Package> =
        graph().members().into_iter().filter(|p| p.manifest_path.as_std_path().starts_with(&below)).collect();
    assert!(solvers.len() > NO_SOLVER_LIBRARY.len(), "no solver library is found below `solvers/`");
    for solver in solvers.into_iter().filter(|p| !NO_SOLVER_LIBRARY.contains(&p.name.as_str())) {
        assert_light(solver, &HEAVY_FOR_SOLVERS);
    }
}

#[test]
fn the_bus_stays_out_of_splats_and_pictures() {
    for name in ["cosplat-splat", "cosplat-mesh"] {
        assert_light(graph().member(name), &["zenoh", "tokio", "rerun"]);
    }
    // rerun brings tokio, and the viewer is who may use rerun.
    assert_light(graph().member("cosplat-viewer"), &["zenoh"]);
}

#[test]
fn a_heavy_package_is_found_however_deep_it_lies() {
    let way = graph().way_to(graph().member("cosplat"), &["zenoh-buffers"]).expect("the program has a bus");
    assert_eq!(way.first().map(String::as_str), Some("cosplat"));
    assert!(way.contains(&"cosplat-bus".to_owned()) && way.contains(&"zenoh".to_owned()), "{way:?}");
}

#[test]
fn a_replaceable_package_is_named_by_one_crate_alone() {
    for (package, owner) in SOLE_USERS {
        let names_it = |p: &&Package| p.dependencies.iter().any(|d| d.name == package);
        let users: Vec<&str> = graph().members().into_iter().filter(names_it).map(|p| p.name.as_str()).collect();
        assert_eq!(
            users,
            [owner],
            "only `{owner}` may name `{package}` in its Cargo.toml; others use what `{owner}` offers"
        );
    }
}

#[test]
fn versions_that_we_name_are_there_once_or_for_a_reason() {
    let ours: BTreeSet<&str> = graph().members().iter().map(|p| p.name.as_str()).collect();
    let named: BTreeSet<&str> =
        graph().members().iter().flat_map(|p| &p.dependencies).map(|d| d.name.as_str()).collect();
    let mut versions: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for package in graph().packages().filter(|p| named.contains(p.name.as_str()) && !ours.contains(p.name.as_str())) {
        let version = compatible(package.version.major, package.version.minor);
        versions.entry(package.name.as_str()).or_default().insert(version);
    }
    let doubled = |list: &BTreeSet<String>| list.len() > 1;
    let found: BTreeMap<&str, Vec<&str>> = versions
        .iter()
        .filter(|(_, list)| doubled(list))
        .map(|(name, list)| (*name, list.iter().map(String::as_str).collect()))
        .collect();
    let known: BTreeMap<&str, Vec<&str>> = DUPLICATES.iter().map(|(name, list, _)| (*name, list.to_vec())).collect();
    let wrong: Vec<String> = found
        .iter()
        .filter(|(name, list)| known.get(*name) != Some(list))
        .map(|(name, list)| format!("`{name}` is there as {}", list.join(", ")))
        .chain(
            known.keys().filter(|n| !found.contains_key(*n)).map(|n| format!("`{n}` is there once, as it should be")),
        )
        .collect();
    assert!(
        wrong.is_empty(),
        "ask in Cargo.toml for the version that the others use (`cargo tree -i NAME@VERSION` shows them), or bring the \
         list in tests/tidy/dependencies.rs up to date with the reason:{}",
        lines(&wrong)
    );
}

/// What cargo takes for one version: the first number that is not zero, and those before it.
fn compatible(major: u64, minor: u64) -> String {
    if major > 0 { major.to_string() } else { format!("0.{minor}") }
}
