//! Does the map show the land?

use std::collections::BTreeSet;
use std::mem::offset_of;

use cosplat_core::coordinator::Limits;
use cosplat_core::plan::{BoundaryForm, Content};
use cosplat_core::scene::Scheme;
use cosplat_core::wire::{CHUNK_BYTES, HEADER_BYTES, Header, schema_text};

use crate::documents::{ARCHITECTURE, difference, listed};
use crate::markdown::{literals, rows, section};
use crate::tree::{lines, text, with_extension};

#[test]
fn the_architecture_is_read_in_ten_minutes() {
    let length = text(ARCHITECTURE).lines().count();
    assert!(length <= 250, "{ARCHITECTURE} has {length} lines; a map of more than 250 is not read, so shorten it");
}

/// Names that a document writes like code, as `Type`, `function` or `module::function`, and that no source holds.
fn dead_names(document: &str, words: &BTreeSet<&str>) -> Vec<String> {
    let is_name = |literal: &&str| literal.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == ':');
    let last = |literal: &str| literal.rsplit(':').next().unwrap_or_default().to_owned();
    literals(document).into_iter().filter(is_name).map(last).filter(|name| !words.contains(name.as_str())).collect()
}

#[test]
fn names_of_the_code_in_the_architecture_exist() {
    let sources: Vec<String> =
        with_extension("rs").iter().filter(|path| !path.starts_with("tests/tidy/")).map(|path| text(path)).collect();
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words: BTreeSet<&str> = sources.iter().flat_map(|s| s.split(|c| !is_word(c))).collect();
    let dead = dead_names(&text(ARCHITECTURE), &words);
    assert!(dead.is_empty(), "{ARCHITECTURE} names what is called otherwise or gone:{}", lines(&dead));
}

#[test]
fn a_name_that_is_gone_is_noticed() {
    let words = BTreeSet::from(["advance", "Plan"]);
    let text = "`Plan` `Plugin::advance` `plan::build` `not code` `b/<p>` `gone`\n```\nskipped `here`\n```\n";
    assert_eq!(dead_names(text, &words), ["build", "gone"]);
}

#[test]
fn the_header_table_is_the_header() {
    let fields = [
        ("magic", offset_of!(Header, magic)),
        ("version", offset_of!(Header, version)),
        ("kind", offset_of!(Header, kind)),
        ("run", offset_of!(Header, run)),
        ("schema", offset_of!(Header, schema)),
        ("epoch", offset_of!(Header, epoch)),
        ("sender", offset_of!(Header, sender)),
        ("stream", offset_of!(Header, stream)),
        ("index", offset_of!(Header, index)),
        ("iteration", offset_of!(Header, iteration)),
        ("count", offset_of!(Header, count)),
        ("seq", offset_of!(Header, seq)),
        ("chunk", offset_of!(Header, chunk)),
        ("chunks", offset_of!(Header, chunks)),
        ("length", offset_of!(Header, length)),
        ("content", offset_of!(Header, content)),
        ("hash", offset_of!(Header, hash)),
    ];
    let ends = fields.iter().skip(1).map(|(_, offset)| *offset).chain([HEADER_BYTES]);
    let real: Vec<[String; 3]> = fields
        .iter()
        .zip(ends)
        .map(|((name, offset), end)| [offset.to_string(), (end - offset).to_string(), format!("`{name}`")])
        .collect();
    let text = text(ARCHITECTURE);
    let part = section(&text, "Data frame").expect("ARCHITECTURE.md has a section `Data frame`");
    let written: Vec<[String; 3]> =
        rows(part).into_iter().filter_map(|row| row.get(..3)?.to_vec().try_into().ok()).collect();
    assert_eq!(written, real, "the table in ARCHITECTURE.md (left) must be what core/src/wire/header.rs says (right)");
}

#[test]
fn every_payload_layout_stands_in_the_architecture() {
    let architecture = text(ARCHITECTURE);
    let body = String::new;
    let boundary = |form| Content::Boundary { body: body(), form };
    let impulses = |form| Content::Impulses { interface: 0, form };
    let samples =
        [false, true].map(|normals| [BoundaryForm::SamplesF32 { normals }, BoundaryForm::SamplesF64 { normals }]);
    let mut contents: Vec<Content> = samples.into_iter().flatten().map(boundary).collect();
    contents.extend([Content::Statics { body: body() }, boundary(BoundaryForm::Proxy), impulses(BoundaryForm::Proxy)]);
    contents.push(impulses(BoundaryForm::SamplesF64 { normals: false }));
    for content in contents {
        let layout = schema_text(&content);
        assert!(architecture.contains(layout), "{ARCHITECTURE} must show the layout `{layout}`");
    }
}

#[test]
fn every_coupling_scheme_stands_in_the_architecture() {
    let name = |scheme: Scheme| match scheme {
        Scheme::Serial => "serial",
        Scheme::Parallel => "parallel",
        Scheme::Alternating => "alternating",
        Scheme::Centred => "centred",
    };
    let there = [Scheme::Serial, Scheme::Parallel, Scheme::Alternating, Scheme::Centred].map(name).map(str::to_owned);
    let found = difference(&listed(ARCHITECTURE, "Coupling schemes"), &there.into(), ARCHITECTURE);
    assert!(found.is_empty(), "the table has one row per scheme:{}", lines(&found));
}

#[test]
fn numbers_of_the_protocol_in_the_architecture_are_those_of_the_code() {
    let architecture = text(ARCHITECTURE);
    for phrase in [
        format!("{HEADER_BYTES} bytes"),
        format!("{} KiB", CHUNK_BYTES / 1024),
        format!("`Limits::ahead` = {}", Limits::default().ahead),
    ] {
        assert!(architecture.contains(&phrase), "{ARCHITECTURE} must say \"{phrase}\", as the code does");
    }
}
