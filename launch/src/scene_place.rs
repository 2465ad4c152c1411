//! Where in a scene file the thing stands that a plan refuses.
//!
//! A refusal names what it is about, as in ``body `left` ``; the reader of the scene knows no places any more. So the text
//! is searched for the section of that name.

use std::ops::Range;

use cosplat_core::plan::Refusal;
use cosplat_core::scene::Diagnostic;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::exit::Problem;
use crate::render::{self, Paint};
use crate::scene_source::Source;

/// A refusal as a problem that shows the line it is about, where there is one.
pub(crate) fn problem_of(paint: Paint, source: &Source, refusal: &Refusal) -> Problem {
    let found = Diagnostic {
        span: find(&source.text, &refusal.what),
        ..Diagnostic::error(format!("{}: {}", refusal.what, refusal.why))
    };
    render::problem_of(paint, &source.shown, &source.text, &found)
}

/// Bytes of the text at which ``kind `name` `` or `section` stands.
fn find(text: &str, what: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let root = document.get_ref();
    let Some((kind, name)) = what.split_once(" `") else {
        return root.get_key_value(what).map(|(key, _)| key.span());
    };
    let name = name.strip_suffix('`')?;
    match (kind, root.get(kind)?.get_ref()) {
        ("solver", DeValue::Table(solvers)) => solvers.get_key_value(name).map(|(key, _)| key.span()),
        ("pair", DeValue::Array(pairs)) => {
            let (a, b) = name.split_once('~')?;
            pairs.iter().find_map(|pair| {
                let ends = (text_of(pair, "a")?, text_of(pair, "b")?);
                let is_it = (ends.0.0, ends.1.0) == (a, b) || (ends.0.0, ends.1.0) == (b, a);
                is_it.then_some(ends.0.1)
            })
        }
        (_, DeValue::Array(items)) => {
            let key = if kind == "action" { "kind" } else { "name" };
            items.iter().find_map(|item| text_of(item, key).filter(|(text, _)| *text == name).map(|(_, span)| span))
        }
        _ => None,
    }
}

/// Text and place of a value of a table.
fn text_of<'a>(table: &'a Spanned<DeValue<'_>>, key: &str) -> Option<(&'a str, Range<usize>)> {
    let value = table.get_ref().as_table()?.get(key)?;
    Some((value.get_ref().as_str()?, value.span()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = r#"
[clock]
[solver.one]
[[body]]
name = "first"
[[body]]
name = "second"
[[pair]]
a = "first"
b = "second"
[[action]]
kind = "wind"
"#;

    fn found(what: &str) -> Option<(usize, &'static str)> {
        let span = find(SCENE, what)?;
        Some((SCENE[..span.start].matches('\n').count() + 1, &SCENE[span]))
    }

    #[test]
    fn things_are_found_by_kind_and_name() {
        assert_eq!(found("body `second`"), Some((7, "\"second\"")));
        assert_eq!(found("solver `one`"), Some((3, "one")));
        assert_eq!(found("pair `second~first`"), Some((9, "\"first\"")));
        assert_eq!(found("action `wind`"), Some((12, "\"wind\"")));
        assert_eq!(found("clock"), Some((2, "clock")));
    }

    #[test]
    fn what_stands_nowhere_is_not_found() {
        for what in ["body `third`", "body `first", "link `first`", "scene", "solvers `one`, `two`"] {
            assert_eq!(found(what), None, "{what}");
        }
    }
}
