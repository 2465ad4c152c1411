//! Sheet files: `NAME.sheet.toml` in, a [`Sheet`] or every mistake out.

use std::path::Path;

use cosplat_core::scene::Diagnostic;
use toml::de::DeTable;

use super::super::read::{factors, scene};
use super::super::section::{Reading, Section};
use super::{ENDING, Line, Sheet, lines};

/// Newest format of sheet files that can be read.
const FORMAT: f64 = 1.0;

/// Reads the text of a sheet file; scenes are looked for beside it.
///
/// # Errors
/// Every mistake in it, with its place.
pub(super) fn parse(file: &Path, text: &str) -> Result<Sheet, Vec<Diagnostic>> {
    let (document, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        let syntax = |e: &toml::de::Error| Diagnostic { span: e.span(), ..Diagnostic::error(e.message().trim()) };
        return Err(errors.iter().map(syntax).collect());
    }
    let reading = Reading::new(text);
    let sheet = {
        let root = Section::new(&reading, document.get_ref(), 0..0, String::new());
        let sheet = read(file, &root);
        root.finish();
        sheet
    };
    let found = reading.into_found();
    if found.is_empty() { Ok(sheet) } else { Err(found) }
}

fn read(file: &Path, root: &Section<'_>) -> Sheet {
    if let Some(item) = root.get("format")
        && item.number().is_some_and(|format| format > FORMAT)
    {
        item.error_with("is of a newer version of cosplat", Some(format!("this one reads up to format {FORMAT}")));
    }
    let name = file.file_name().map(|n| n.to_string_lossy().replace(ENDING, "")).unwrap_or_default();
    let wanted = root.need("scene", "name a built-in scene, or a scene file beside this one");
    let folder = file.parent().unwrap_or(Path::new(""));
    let text = |key| root.get(key).and_then(|item| item.text()).map(str::to_owned);
    Sheet {
        title: text("title").unwrap_or_else(|| name.clone()),
        name,
        scene: wanted.and_then(|item| scene(&item, folder)).unwrap_or_default(),
        at_s: root.positive("at"),
        striker: text("striker"),
        rows: axis(root, "rows"),
        columns: axis(root, "columns"),
    }
}

fn axis(root: &Section<'_>, name: &'static str) -> Vec<Line> {
    let Some(item) = root.need(name, "add a table of keys of the scene with a list of values each") else {
        return Vec::new();
    };
    lines(&factors(&item)).unwrap_or_else(|why| {
        item.error_with(&format!("has lists of different lengths: {why}"), None);
        Vec::new()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHEET: &str = r#"
format = 1
title = "Four swings"
scene = "oscillator"
at = 0.5
[rows]
"clock.window" = [0.02, 0.01]
[columns]
"clock.link_scheme" = ["serial", "parallel", "alternating"]
"#;

    #[test]
    fn a_sheet_is_read() {
        let sheet = parse(Path::new("a/swings.sheet.toml"), SHEET).unwrap();
        assert_eq!((sheet.name.as_str(), sheet.scene.as_str(), sheet.at_s), ("swings", "oscillator", Some(0.5)));
        assert_eq!((sheet.rows.len(), sheet.columns.len()), (2, 3));
        assert_eq!(sheet.columns[2].name(), "alternating");
    }

    #[test]
    fn every_mistake_of_a_sheet_is_shown() {
        let broken = SHEET
            .replace("oscillator", "oscilator")
            .replace("at = 0.5", "at = -1\nstryker = \"a\"")
            .replace("[columns]", "\"clock.duration\" = [1]\n[columns]");
        let found = parse(Path::new("x.sheet.toml"), &broken).unwrap_err();
        let said: Vec<String> = found.iter().map(|d| d.message.clone()).collect();
        for part in ["`scene` names no scene", "`at` must be greater", "unknown key `stryker`", "different lengths"] {
            assert!(said.iter().any(|line| line.contains(part)), "{part}: {said:?}");
        }
    }
}
