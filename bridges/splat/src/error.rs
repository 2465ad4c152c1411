//! What can be wrong with a splat file, said so that the user knows what to do.

use thiserror::Error;

/// Kind of a fault, for programs; the text of [`SplatError`] is for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The file could not be read or written.
    Io,
    /// The file is none of the known formats.
    UnknownFormat,
    /// The header contradicts itself or the format.
    Header,
    /// The file ends before what its header promises.
    Truncated,
    /// Compressed data does not unpack.
    Compression,
    /// The file asks for more memory than its size justifies.
    TooLarge,
    /// The format or one of its options is known but not read here.
    Unsupported,
    /// A value is not what it must be.
    Value,
}

/// A fault in a file: which file, where in it, what is wrong, and what to do.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{file}: {place}: {what}; {advice}")]
pub struct SplatError {
    /// Kind of the fault.
    pub fault: Fault,
    /// Name of the file, or `<memory>`.
    pub file: String,
    /// Place in the file: line, property, byte or stream.
    pub place: String,
    /// What is wrong there.
    pub what: String,
    /// What the user can do.
    pub advice: String,
}

impl SplatError {
    /// An error in data that has no name yet; [`Self::in_file`] gives it one.
    pub fn new(
        fault: Fault,
        place: impl Into<String>,
        what: impl Into<String>,
        advice: impl Into<String>,
    ) -> SplatError {
        let (place, what, advice) = (plain(place.into()), plain(what.into()), advice.into());
        SplatError { fault, file: "<memory>".to_owned(), place, what, advice }
    }

    /// The same error, in that file.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<String>) -> SplatError {
        self.file = file.into();
        self
    }

    /// Data that ends early.
    pub(crate) fn truncated(place: impl Into<String>, needs: u64, has: u64) -> SplatError {
        let what = format!("{needs} bytes are promised and {has} are there");
        SplatError::new(Fault::Truncated, place, what, "copy or download the file again")
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
