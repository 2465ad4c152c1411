//! Is the repository in order?
//!
//! Everything here reads files and the dependency graph; nothing is run. Each rule is a test whose name is the rule, and
//! whose message says what to do. Each scanner is tested on a small text that breaks its rule, because a scanner that
//! finds nothing looks the same as a tidy repository.

mod architecture;
mod code;
mod dependencies;
mod documents;
mod licences;
mod markdown;
mod readme;
mod sources;
mod spdx;
mod tree;
mod workspace;
