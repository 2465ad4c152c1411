//! Negative controls: a gate that never turns red proves nothing. Each control breaks one thing, and the gate that it
//! names must notice.

use std::path::Path;

use cosplat_core::scene::Diagnostic;
use serde::Serialize;
use toml::de::DeTable;

use super::case::{Case, Factor, Level};
use super::read::{case, factors, set};
use super::result::{CaseResult, Judged};
use super::section::{Reading, Section};
use crate::exit::{Code, Error, Problem};
use crate::render::{Paint, problem_of};

/// A thing that is broken on purpose.
#[derive(Clone, Debug)]
pub(crate) struct Control {
    /// Short name.
    pub(crate) name: String,
    /// What is wrong, as a sentence.
    pub(crate) fault: String,
    /// The case as it should be, with as few runs as the gate needs.
    pub(crate) case: Case,
    /// Name of the gate that must notice.
    pub(crate) gate: String,
    /// What makes it wrong.
    pub(crate) set: Vec<(String, Level)>,
}

impl Control {
    /// The case with its fault.
    pub(crate) fn broken(&self) -> Case {
        let mut case = self.case.clone();
        case.name = format!("{} ({})", self.case.name, self.name);
        case.set.extend(self.set.iter().cloned());
        case
    }
}

/// Whether a gate noticed.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Noticed {
    /// Name of the control.
    pub(crate) name: String,
    /// What was wrong.
    pub(crate) fault: String,
    /// Case.
    pub(crate) case: String,
    /// The gate without the fault.
    pub(crate) sound: Judged,
    /// The gate with it.
    pub(crate) broken: Judged,
    /// Green without and red with the fault.
    pub(crate) passed: bool,
}

/// Compares the gate of a control in both runs; none where the case has no such gate.
pub(crate) fn judge(control: &Control, sound: &CaseResult, broken: &CaseResult) -> Option<Noticed> {
    let of = |result: &CaseResult| {
        result.gates.iter().find(|j| j.gate.name.as_deref() == Some(control.gate.as_str())).cloned()
    };
    let (sound, broken) = (of(sound)?, of(broken)?);
    Some(Noticed {
        name: control.name.clone(),
        fault: control.fault.clone(),
        case: control.case.name.clone(),
        passed: sound.passed == Some(true) && broken.passed == Some(false),
        sound,
        broken,
    })
}

/// Reads a list of controls.
///
/// # Errors
/// The file cannot be read, or every mistake in it and in the cases that it names.
pub(crate) fn read(file: &Path) -> Result<Vec<Control>, Error> {
    let text = std::fs::read_to_string(file).map_err(|e| {
        let problem = Problem::new(format!("Cannot read the controls `{}`", file.display())).at(file).because(e);
        Error::new(Code::Scene, problem)
    })?;
    let problems = |found: &[Diagnostic]| {
        let shown = file.display().to_string();
        let problems = found.iter().map(|d| problem_of(Paint::stderr(), &shown, &text, d)).collect();
        Error { code: Code::Scene, problems }
    };
    let (document, errors) = DeTable::parse_recoverable(&text);
    if !errors.is_empty() {
        let syntax = |e: &toml::de::Error| Diagnostic { span: e.span(), ..Diagnostic::error(e.message().trim()) };
        return Err(problems(&errors.iter().map(syntax).collect::<Vec<_>>()));
    }
    let reading = Reading::new(&text);
    let root = Section::new(&reading, document.get_ref(), 0..0, String::new());
    let _ = root.get("format");
    let items = root.need("control", "add `[[control]]` with a `case`, a `gate` and what is `set`");
    let items = items.map(|item| item.items()).unwrap_or_default();
    let read: Vec<_> = items.iter().filter_map(|item| item.table(|section| control(section, file))).collect();
    root.finish();
    let found = reading.into_found();
    if !found.is_empty() {
        return Err(problems(&found));
    }
    let mut controls = Vec::new();
    for one in read {
        controls.push(one?);
    }
    Ok(controls)
}

fn control(section: &Section<'_>, file: &Path) -> Option<Result<Control, Error>> {
    let help = "a control has `name`, `fault`, `case`, `gate` and `set`";
    let [name, fault, place, gate] = ["name", "fault", "case", "gate"].map(|key| section.need(key, help));
    let set = section.need("set", help).map(|item| set(&item)).unwrap_or_default();
    let fewer = section.get("vary").map(|item| factors(&item)).unwrap_or_default();
    let [name, fault, gate] = [name, fault, gate].map(|item| item.and_then(|item| item.text().map(str::to_owned)));
    let place = place?.clone();
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut case = match case(&folder.join(place.text()?)) {
        Ok(case) => case,
        Err(error) => return Some(Err(error)),
    };
    let gate = gate?;
    if case.gates.iter().all(|known| known.name.as_deref() != Some(gate.as_str())) {
        section.error(&format!("the case has no gate with the name `{gate}`"), None);
        return None;
    }
    narrow(&mut case, fewer);
    Some(Ok(Control { name: name?, fault: fault?, case, gate, set }))
}

/// Leaves fewer values of what a case varies; keys that it does not vary come first, so that its axis stays the axis.
fn narrow(case: &mut Case, fewer: Vec<Factor>) {
    for factor in fewer {
        match case.vary.iter_mut().find(|known| known.key == factor.key) {
            Some(known) => known.values = factor.values,
            None => case.vary.insert(0, factor),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const CASE: &str = "format = 1\nscene = \"oscillator\"\nsource = \"s\"\n[[quantity]]\nprobe = \"left.x\"\nexact = \"0\"\n[vary]\n\
                        \"clock.window\" = [0.02, 0.01]\n[[gate]]\nname = \"close\"\nerror = 1\nreason = \"a test\"\n";

    fn controls(text: &str) -> Result<Vec<Control>, Error> {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("c.study.toml"), CASE).unwrap();
        let file = place.path().join("controls.toml");
        fs::write(&file, text).unwrap();
        read(&file)
    }

    #[test]
    fn a_control_is_its_case_with_one_thing_broken() {
        let text = "format = 1\n[[control]]\nname = \"n\"\nfault = \"f\"\ncase = \"c.study.toml\"\ngate = \"close\"\n\
                    set = { \"run.break\" = \"stale-boundary\" }\nvary = { \"clock.window\" = [0.01] }\n";
        let found = controls(text).unwrap();
        assert_eq!((found[0].case.vary.len(), found[0].case.vary[0].values.len()), (1, 1));
        assert!(found[0].case.set.is_empty());
        assert_eq!(found[0].broken().set[0].0, "run.break");
    }

    #[test]
    fn a_gate_that_the_case_does_not_have_is_a_mistake() {
        let text =
            "[[control]]\nname = \"n\"\nfault = \"f\"\ncase = \"c.study.toml\"\ngate = \"near\"\nset = { a = 1 }\n";
        let error = controls(text).unwrap_err();
        assert!(error.problems[0].message.contains("no gate with the name `near`"), "{error:?}");
        assert!(controls("[[control]]\nname = \"n\"\n").is_err());
    }
}
