//! What can be wrong with a mesh, said so that the user knows what to do.

use thiserror::Error;

/// Kind of a fault, for programs; the text of [`MeshError`] is for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The file could not be read.
    Io,
    /// The file is none of the known formats.
    UnknownFormat,
    /// The header contradicts itself or the format.
    Header,
    /// The file ends before what it promises.
    Truncated,
    /// The file asks for more memory or time than its size justifies.
    TooLarge,
    /// The format or one of its options is known but not read here.
    Unsupported,
    /// The file has no surface in it.
    Empty,
    /// A line or a value does not say what its keyword promises.
    Syntax,
    /// A face names a vertex that is not there.
    Index,
    /// A number is not finite or not what it must be.
    Value,
    /// The surface encloses no volume, and one is asked for.
    Open,
    /// What is asked for has too many points, or none.
    Spacing,
}

/// A fault: in which file, where, what is wrong, and what to do.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{file}: {place}: {what}; {advice}")]
pub struct MeshError {
    /// Kind of the fault.
    pub fault: Fault,
    /// Name of the file, or `<memory>`.
    pub file: String,
    /// Place: a line, row, triangle, accessor, or `whole mesh`.
    pub place: String,
    /// What is wrong there.
    pub what: String,
    /// What the user can do.
    pub advice: String,
}

impl MeshError {
    /// An error in data that has no name yet; [`Self::in_file`] gives it one.
    pub fn new(
        fault: Fault,
        place: impl Into<String>,
        what: impl Into<String>,
        advice: impl Into<String>,
    ) -> MeshError {
        let (place, what, advice) = (plain(place.into()), plain(what.into()), advice.into());
        MeshError { fault, file: "<memory>".to_owned(), place, what, advice }
    }

    /// An error about the mesh as a whole.
    pub(crate) fn whole(fault: Fault, what: impl Into<String>, advice: impl Into<String>) -> MeshError {
        MeshError::new(fault, "whole mesh", what, advice)
    }

    /// The same error, in that file.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<String>) -> MeshError {
        self.file = file.into();
        self
    }
}

/// Words for one line of a terminal, also where they quote a file: no control characters, and no more than a few lines.
fn plain(text: String) -> String {
    const MOST: usize = 240;
    if text.len() <= MOST && !text.contains(char::is_control) {
        return text;
    }
    let shown = text.chars().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c });
    let more = if text.chars().nth(MOST).is_some() { "..." } else { "" };
    shown.take(MOST).chain(more.chars()).collect()
}
