//! Files beside a mesh that it names.

use std::fs;
use std::io::Read;
use std::path::{Component, Path};

/// Where the files lie that a mesh names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside<'a> {
    /// There are none.
    Nothing,
    /// In this folder or in one below it; nothing outside is opened.
    Folder(&'a Path),
}

impl<'a> Beside<'a> {
    /// Where a file itself lies.
    pub fn of(file: &'a Path) -> Beside<'a> {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        Beside::Folder(folder.unwrap_or(Path::new(".")))
    }

    /// The first `length` bytes of a file, named by a relative URI with forward slashes.
    pub(super) fn read(self, uri: &str, length: u64) -> Result<Vec<u8>, String> {
        let Beside::Folder(folder) = self else {
            return Err(format!("it names the file `{uri}`, and there are no files beside it"));
        };
        let name = unescape(uri).filter(|name| is_below(name));
        let name = name.ok_or_else(|| format!("`{uri}` is no path to a file beside or below it"))?;
        let cannot = |error: std::io::Error| format!("cannot read `{name}`: {error}");
        let path = folder.join(&name).canonicalize().map_err(cannot)?;
        // A link may point elsewhere although its name does not.
        if !path.starts_with(folder.canonicalize().map_err(cannot)?) {
            return Err(format!("`{uri}` is a link to a file elsewhere"));
        }
        let about = fs::metadata(&path).map_err(cannot)?;
        if !about.is_file() || about.len() < length {
            return Err(format!("`{uri}` is no file of at least {length} bytes, but has {}", about.len()));
        }
        let mut bytes = Vec::new();
        fs::File::open(&path).and_then(|file| file.take(length).read_to_end(&mut bytes)).map_err(cannot)?;
        Ok(bytes)
    }
}

/// Whether a path leads nowhere but downwards, on every system.
fn is_below(name: &str) -> bool {
    let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    !name.is_empty() && !name.contains([':', '\\', '\0']) && Path::new(name).components().all(is_plain)
}

/// A URI with `%20` and its like replaced; nothing if that gives no text.
fn unescape(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let digits = [rest.next()?, rest.next()?];
            out.push(u8::from_str_radix(str::from_utf8(&digits).ok()?, 16).ok()?);
        } else {
            out.push(byte);
        }
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_paths_downwards_are_followed() {
        for good in ["a.bin", "./a.bin", "parts/a%20b.bin", "..a/b"] {
            assert!(unescape(good).is_some_and(|name| is_below(&name)), "{good}");
        }
        let bad = [
            "",
            "/etc/passwd",
            "../a",
            "a/../../b",
            "%2e%2e/a",
            "a/%2E%2e/b",
            "C:a",
            "file:///a",
            "..\\a",
            "a%00b",
            "%",
            "%zz",
            "%ff",
        ];
        for bad in bad {
            assert!(!unescape(bad).is_some_and(|name| is_below(&name)), "{bad}");
        }
    }
}
