//! No text makes the reader panic, and every finding points into the text.

use proptest::prelude::*;

use super::*;

fn survives(text: &str, overrides: &[String]) {
    let diagnostics = match parse_with(text, overrides) {
        Ok((_, warnings)) => warnings,
        Err(diagnostics) => {
            assert!(diagnostics.iter().any(|d| d.severity == Severity::Error), "refused without an error:\n{text}");
            diagnostics
        }
    };
    for diagnostic in &diagnostics {
        assert!(diagnostic.span.as_ref().is_none_or(|s| s.start <= s.end && s.end <= text.len()), "{diagnostic:?}");
    }
    render("a", text, &diagnostics);
}

#[test]
fn deep_and_long_texts_are_survived() {
    survives(&format!("a = {}", "[".repeat(100_000)), &[]);
    survives(&format!("a = {}", "{a=".repeat(100_000)), &[]);
    survives(&"a = ] ".repeat(20_000), &[]);
    survives(&"= 'x\n".repeat(20_000), &[]);
    survives(&"a.".repeat(100_000), &[]);
    survives(&format!("[{}]", vec!["a"; 10_000].join(".")), &[]);
    survives(&format!("{OSCILLATOR}\n[[probe]]\nname=[{}]", "1,".repeat(100_000)), &[]);
    survives(&OSCILLATOR.replace("[[1.0, 0.0, 0.0]]", &format!("[{}]", "['x'],".repeat(5_000))), &[]);
    survives(OSCILLATOR, &["a.".repeat(1000) + "=1", "body=".to_owned() + &"[".repeat(10_000), "=".to_owned()]);
}

#[test]
fn thousands_of_mistakes_are_counted_not_listed() {
    let text = OSCILLATOR.replace("[[1.0, 0.0, 0.0]]", &format!("[{}]", "['x'],".repeat(5_000)));
    assert!(mistakes(&text).contains("error: 4000 more findings are not shown"));
}

/// Replaces, removes or inserts a piece of the oscillator.
fn mutated() -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        "\\PC{0,6}",
        Just("\n".to_owned()),
        Just("nan".to_owned()),
        Just("-1e400".to_owned()),
        Just("[[body]]\n".to_owned()),
        Just("[[[".to_owned()),
        Just("{".to_owned()),
        Just("\"\"\"".to_owned()),
        Just("body.x = 1\n".to_owned()),
    ];
    let edit = (any::<prop::sample::Index>(), 0_usize..20, piece);
    prop::collection::vec(edit, 1..6).prop_map(|edits| {
        let mut text = OSCILLATOR.to_owned();
        for (at, removed, piece) in edits {
            let start = text.floor_char_boundary(at.index(text.len()));
            let end = text.floor_char_boundary((start + removed).min(text.len())).max(start);
            text.replace_range(start..end, &piece);
        }
        text
    })
}

/// Puts a value of some other type in the place of any value.
fn retyped() -> impl Strategy<Value = String> {
    let value =
        prop::sample::select(vec!["[]", "{}", "true", "1", "-0.0", "\"\"", "\"x\"", "inf", "[[]]", "1979-05-27"]);
    (any::<prop::sample::Index>(), value).prop_map(|(at, value)| {
        let mut lines: Vec<String> = OSCILLATOR.lines().map(str::to_owned).collect();
        let assigned: Vec<usize> = (0..lines.len()).filter(|i| lines[*i].contains(" = ")).collect();
        let line = &mut lines[assigned[at.index(assigned.len())]];
        let key = line.split(" = ").next().unwrap_or_default().to_owned();
        *line = format!("{key} = {value}");
        lines.join("\n")
    })
}

proptest! {
    #[test]
    fn arbitrary_text_never_panics(text in "\\PC{0,200}") {
        survives(&text, &[]);
    }

    #[test]
    fn arbitrary_toml_like_text_never_panics(text in "[a-c\\[\\]{}=\"'.,#\n 0-9-]{0,120}") {
        survives(&text, &[]);
    }

    #[test]
    fn a_mutated_scene_never_panics(text in mutated()) {
        survives(&text, &[]);
    }

    #[test]
    fn a_retyped_scene_never_panics(text in retyped()) {
        survives(&text, &[]);
    }

    #[test]
    fn an_arbitrary_override_never_panics(path in "[a-z.0-2-]{0,20}|body\\.[0-3]\\.[a-z]{1,8}", value in "\\PC{0,12}") {
        survives(OSCILLATOR, &[format!("{path}={value}")]);
    }
}
