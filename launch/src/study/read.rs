//! Case files: `NAME.study.toml` in, a [`Case`] or every mistake out.

use std::path::Path;

use cosplat_core::scene::Diagnostic;
use toml::de::{DeTable, DeValue};

use super::case::{Case, Comparison, Factor, Invariant, Kind, Level, Measure, Quantity, Reference, Twin};
use super::formula::Formula;
use super::read_gate::gates;
use super::section::{Item, Reading, Section};
use super::table::{self, Part};
use crate::exit::{Code, Error, Problem};
use crate::hint::{list, near_miss};
use crate::render::{Paint, problem_of};
use crate::scene_source::built_in_names;

/// How the name of a case file ends.
pub(crate) const ENDING: &str = ".study.toml";
/// Newest format of case files that can be read.
const FORMAT: f64 = 1.0;

/// Reads a case file.
///
/// # Errors
/// The file cannot be read, or every mistake in it.
pub(crate) fn case(file: &Path) -> Result<Case, Error> {
    let text = std::fs::read_to_string(file).map_err(|e| {
        let problem = Problem::new(format!("Cannot read the case `{}`", file.display())).at(file).because(e);
        Error::new(Code::Scene, problem.hint(format!("give a file `NAME{ENDING}`, a scene, or a folder of cases")))
    })?;
    parse(file, &text).map_err(|found| {
        let shown = file.display().to_string();
        let problem = |d: &Diagnostic| problem_of(Paint::stderr(), &shown, &text, d);
        Error { code: Code::Scene, problems: found.iter().map(problem).collect() }
    })
}

fn parse(file: &Path, text: &str) -> Result<Case, Vec<Diagnostic>> {
    let (document, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        let syntax = |e: &toml::de::Error| Diagnostic { span: e.span(), ..Diagnostic::error(e.message().trim()) };
        return Err(errors.iter().map(syntax).collect());
    }
    let reading = Reading::new(text);
    let case = {
        let root = Section::new(&reading, document.get_ref(), 0..0, String::new());
        let case = read(file, &root);
        root.finish();
        case
    };
    let found = reading.into_found();
    if found.is_empty() { Ok(case) } else { Err(found) }
}

fn read(file: &Path, root: &Section<'_>) -> Case {
    if let Some(item) = root.get("format")
        && item.number().is_some_and(|format| format > FORMAT)
    {
        item.error_with("is of a newer version of cosplat", Some(format!("this one reads up to format {FORMAT}")));
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    let name = file.file_name().map(|n| n.to_string_lossy().replace(ENDING, "")).unwrap_or_default();
    let scene = root.need("scene", "name a built-in scene, or a scene file beside this one");
    let scene = scene.and_then(|item| self::scene(&item, folder)).unwrap_or_default();
    let quantities = quantities(root, folder);
    let vary = vary(root);
    Case {
        twin: twin(root, &scene, &quantities, folder),
        title: root.get("title").and_then(|i| i.text()).map_or_else(|| name.clone(), str::to_owned),
        name,
        scene,
        source: root
            .need("source", "say where the reference is from")
            .and_then(|i| i.text())
            .unwrap_or_default()
            .into(),
        gates: gates(root, &quantities, &vary),
        quantities,
        slow: root.get("slow").is_some_and(|item| item.flag()),
        set: root.get("set").map(|item| set(&item)).unwrap_or_default(),
        vary,
    }
}

/// The scene that each run is compared with, where a quantity asks for one.
fn twin(root: &Section<'_>, scene: &str, quantities: &[Quantity], folder: &Path) -> Option<Twin> {
    let is_asked = |q: &Quantity| matches!(&q.kind, Kind::Probe(c) if matches!(c.reference, Reference::Twin(_)));
    let Some(item) = root.get("twin") else {
        if quantities.iter().any(is_asked) {
            root.error("a quantity has a `twin`, but there is no table `[twin]`", Some(TWIN.to_owned()));
        }
        return None;
    };
    item.table(|section| {
        let other = section.get("scene").and_then(|item| self::scene(&item, folder));
        Some(Twin {
            scene: other.unwrap_or_else(|| scene.to_owned()),
            set: section.get("set").map(|item| set(&item)).unwrap_or_default(),
            time: section.positive("time").unwrap_or(1.0),
        })
    })
}

/// Values that every run has.
pub(super) fn set(item: &Item<'_>) -> Vec<(String, Level)> {
    if !matches!(item.value.get_ref(), DeValue::Table(_)) {
        item.error("must be a table of keys of the scene with a value of each");
        return Vec::new();
    }
    let top = Item { path: String::new(), ..item.clone() };
    top.leaves().iter().map(|leaf| (leaf.path.clone(), Level::of(leaf.raw()))).collect()
}

/// The scene as `cosplat run` takes it.
pub(super) fn scene(item: &Item<'_>, folder: &Path) -> Option<String> {
    let wanted = item.text()?;
    if built_in_names().any(|name| name == wanted) {
        return Some(wanted.to_owned());
    }
    let path = folder.join(wanted);
    if path.is_file() {
        return Some(path.display().to_string());
    }
    let help = match near_miss(wanted, built_in_names()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("paths are relative to this file; built-in scenes are {}", list(built_in_names())),
    };
    item.error_with(&format!("names no scene: there is no `{}`", path.display()), Some(help));
    None
}

fn quantities(root: &Section<'_>, folder: &Path) -> Vec<Quantity> {
    let Some(item) = root.need("quantity", "add `[[quantity]]` with a `probe` and an `exact` formula below it") else {
        return Vec::new();
    };
    item.items().iter().filter_map(|item| item.table(|section| quantity(section, folder))).collect()
}

/// What belongs into `[twin]`.
const TWIN: &str = "it may have a `scene` (without it: that of the case, without what it sets), a `set`, and a `time` that its times are multiplied by";
/// Keys of a quantity that has a reference.
const COMPARED: [&str; 9] = ["exact", "table", "between", "twin", "measure", "scale", "spread", "from", "until"];

fn quantity(section: &Section<'_>, folder: &Path) -> Option<Quantity> {
    let (probe, invariant) = (section.get("probe"), section.get("invariant"));
    match (probe, invariant) {
        (Some(probe), None) => {
            let kind = Kind::Probe(Box::new(comparison(section, folder)?));
            Some(Quantity { name: probe.text()?.to_owned(), kind })
        }
        (None, Some(invariant)) => {
            let scale = section.positive("scale");
            let energy = Invariant::Energy { scale };
            let rise = Invariant::EnergyRise { scale };
            let words = [
                ("energy", energy),
                ("energy-rise", rise),
                ("momentum", Invariant::Momentum),
                ("picture", Invariant::Picture),
            ];
            let kind = invariant.word(&words)?;
            Some(Quantity { name: invariant.text()?.to_owned(), kind: Kind::Invariant(kind) })
        }
        (Some(_), Some(two)) => {
            section.allow(&COMPARED);
            two.error("and `probe` exclude each other");
            None
        }
        (None, None) => {
            section.allow(&COMPARED);
            let help = "write `probe = \"COLUMN\"` or `invariant = \"energy\"`";
            section.error("says not what is measured", Some(help.into()));
            None
        }
    }
}

fn comparison(section: &Section<'_>, folder: &Path) -> Option<Comparison> {
    let references = ["exact", "table", "between", "twin"].map(|key| section.get(key));
    let measures = [
        ("l2", Measure::L2),
        ("max", Measure::Max),
        ("final", Measure::Final),
        ("mean", Measure::Mean),
        ("period", Measure::Period),
    ];
    let measure = section.get("measure").and_then(|item| item.word(&measures)).unwrap_or(Measure::L2);
    let mut scale = section.positive("scale");
    let spread = section.positive("spread").unwrap_or(0.0);
    let from_s = section.get("from").and_then(|item| item.number()).unwrap_or(0.0);
    let until_s = section.positive("until").unwrap_or(f64::INFINITY);
    let reference = match references.each_ref().map(Option::as_ref) {
        [Some(item), None, None, None] => Reference::Exact(formula(item)?),
        [None, Some(item), None, None] => Reference::Table(item.table(|section| reference_table(section, folder))?),
        [None, None, Some(item), None] => {
            let [least, most] = bounds(item)?;
            scale.get_or_insert(most - least);
            Reference::Between([least, most])
        }
        [None, None, None, Some(_)] => Reference::Twin(section.positive("twin")?),
        [None, None, None, None] => {
            let help = "write `exact = \"FORMULA OF t\"`, `table = { file = …, time = …, value = … }`, `between = [LEAST, MOST]` \
                        or `twin = 1`";
            section.error("has no reference", Some(help.into()));
            return None;
        }
        many => {
            if let Some(item) = many.iter().flatten().next() {
                item.error("is one reference too many: `exact`, `table`, `between` and `twin` exclude each other");
            }
            return None;
        }
    };
    Some(Comparison { reference, measure, scale, from_s, until_s, spread })
}

/// The ends of an interval.
fn bounds(item: &Item<'_>) -> Option<[f64; 2]> {
    let numbers: Vec<f64> = item.items().iter().filter_map(Item::number).collect();
    match numbers.as_slice() {
        [least, most] if least < most => Some([*least, *most]),
        _ => {
            item.error("must be the smallest and the largest value that is right, as in [0, 0.5]");
            None
        }
    }
}

fn formula(item: &Item<'_>) -> Option<Formula> {
    let found = Formula::parse(item.text()?);
    if let Err(mistake) = &found {
        item.error(&format!("is no formula: at character {}, {}", mistake.at + 1, mistake.why));
    }
    found.ok()
}

/// Time \[s\] and value of a table beside the case file.
fn reference_table(section: &Section<'_>, folder: &Path) -> Option<Vec<(f64, f64)>> {
    let help = "write `{ file = \"x.csv\", time = \"t\", value = \"u\" }`";
    let keys = ["file", "time", "value"].map(|key| section.need(key, help));
    let [file, time, value] = keys.map(|key| key.and_then(|item| item.text().map(|text| (item.clone(), text))));
    let ((file, name), time, value) = (file?, time?, value?);
    table::read(&folder.join(name), time.1, value.1)
        .map_err(|(part, why, help)| match part {
            Part::File => file.error_with(&why, help),
            Part::Time => time.0.error_with(&why, help),
            Part::Value => value.0.error_with(&why, help),
        })
        .ok()
}

fn vary(root: &Section<'_>) -> Vec<Factor> {
    let Some(item) = root.get("vary") else { return Vec::new() };
    factors(&item)
}

/// Keys of the scene with the values of each.
pub(super) fn factors(item: &Item<'_>) -> Vec<Factor> {
    if !matches!(item.value.get_ref(), DeValue::Table(_)) {
        item.error("must be a table of keys of the scene with the values of each");
        return Vec::new();
    }
    let top = Item { path: String::new(), ..item.clone() };
    let factor = |leaf: &Item<'_>| {
        let values: Vec<Level> = leaf.items().iter().map(|value| Level::of(value.raw())).collect();
        if values.is_empty() {
            leaf.error("must be a list with at least one value");
        }
        Factor { key: leaf.path.clone(), values }
    };
    top.leaves().iter().map(factor).collect()
}

#[cfg(test)]
mod tests {
    use super::super::case::Claim;
    use super::*;

    const CASE: &str = r#"
format = 1
title = "Two masses"
scene = "oscillator"
source = "a paper"
[[quantity]]
probe = "left.x"
exact = "cos(2*PI*t)"
measure = "max"
[[quantity]]
invariant = "energy"
[vary]
clock.link_scheme = ["serial", "parallel"]
"clock.window" = [0.02, 1e-2]
[[gate]]
where = { "clock.link_scheme" = "serial" }
order = [0.9, 1.1]
reason = "first order"
[[gate]]
where = { "clock.window" = 0.01 }
quantity = "energy"
error = 1e-9
reason = "exact flow"
"#;

    fn mistakes(text: &str) -> Vec<(usize, String)> {
        let found = parse(Path::new("x.study.toml"), text).unwrap_err();
        found
            .into_iter()
            .map(|d| (text[..d.span.unwrap().start].matches('\n').count() + 1, d.message + &d.help.unwrap_or_default()))
            .collect()
    }

    #[test]
    fn a_case_is_read() {
        let case = parse(Path::new("a/x.study.toml"), CASE).unwrap();
        assert_eq!((case.name.as_str(), case.scene.as_str(), case.vary.len()), ("x", "oscillator", 2));
        assert_eq!(case.vary.last().unwrap().key, "clock.window");
        assert_eq!(case.vary.last().unwrap().values[1].shown, "0.01");
        assert_eq!(case.gates[0].claim, Claim::Order([0.9, 1.1]));
        assert_eq!(case.gates[1].r#where, [("clock.window".to_owned(), "0.01".to_owned())]);
        assert!(matches!(case.quantities[1].kind, Kind::Invariant(Invariant::Energy { scale: None })));
    }

    #[test]
    fn a_twin_is_the_scene_of_the_case_without_what_it_sets() {
        let with = |twin: &str| {
            CASE.replace("exact = \"cos(2*PI*t)\"", "twin = 1000").replace("[vary]", &format!("{twin}\n[vary]"))
        };
        let case =
            parse(Path::new("x.study.toml"), &with("[set]\n\"clock.duration\" = 9\n[twin]\ntime = 1e3")).unwrap();
        let Kind::Probe(comparison) = &case.quantities[0].kind else { panic!("{case:?}") };
        assert!(matches!(comparison.reference, Reference::Twin(factor) if (factor - 1000.0).abs() < 1e-9));
        let twin = case.beside().unwrap();
        assert_eq!((twin.scene.as_str(), twin.set.len(), &twin.vary), ("oscillator", 0, &case.vary));
        assert!(mistakes(&with("")).iter().any(|(_, m)| m.contains("no table `[twin]`")));
    }

    #[test]
    fn every_mistake_is_shown_with_its_line() {
        let broken = CASE
            .replace("scene = \"oscillator\"", "scene = \"oscilator\"")
            .replace("cos(2*PI*t)", "cos(2*PI*x)")
            .replace("measure = \"max\"", "mesure = \"max\"")
            .replace("\"clock.window\" = 0.01", "\"clock.windw\" = 0.01")
            .replace("reason = \"first order\"\n", "")
            .replace("[1e-9]", "");
        let found = mistakes(&broken);
        let expected = [(4, "oscillator"), (8, "`x` is unknown"), (9, "did you mean `measure`?")];
        for (line, text) in expected {
            assert!(
                found.iter().any(|(at, message)| *at == line && message.contains(text)),
                "{line} {text}: {found:?}"
            );
        }
        assert!(found.iter().any(|(_, m)| m.contains("`reason` is missing")), "{found:?}");
        assert!(found.iter().any(|(_, m)| m.contains("is not varied") && m.contains("clock.window")), "{found:?}");
    }

    #[test]
    fn what_is_no_toml_is_said_once() {
        assert_eq!(mistakes("scene = \n[[quantity]]\n").len(), 1);
    }
}
