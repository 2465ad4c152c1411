//! The runs of a study: every combination of the values that are varied, the last one fastest.

use super::case::{Factor, Level};

/// Values that a run is started with.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Settings {
    /// Key and value, in the order of the factors.
    pub(crate) values: Vec<(String, Level)>,
}

impl Settings {
    /// As changes for `cosplat run --set`.
    pub(crate) fn overrides(&self) -> Vec<String> {
        self.values.iter().map(|(key, level)| format!("{key}={}", level.toml)).collect()
    }

    /// All but the axis: runs with the same belong to one order fit.
    pub(crate) fn group(&self) -> String {
        named(&self.values[..self.values.len().saturating_sub(1)])
    }

    /// All values, for people.
    pub(crate) fn name(&self) -> String {
        named(&self.values)
    }

    /// Value of the axis, where it is a number.
    pub(crate) fn axis(&self) -> Option<f64> {
        self.values.last().and_then(|(_, level)| level.number())
    }
}

fn named(values: &[(String, Level)]) -> String {
    values.iter().map(|(key, level)| format!("{key}={}", level.shown)).collect::<Vec<_>>().join(" ")
}

/// Every combination.
pub(crate) fn settings(vary: &[Factor]) -> Vec<Settings> {
    let mut all = vec![Settings { values: Vec::new() }];
    for factor in vary {
        let longer = |known: &Settings| {
            let known = known.values.clone();
            factor.values.iter().map(move |level| {
                let mut values = known.clone();
                values.push((factor.key.clone(), level.clone()));
                Settings { values }
            })
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(key: &str, values: &[&str]) -> Factor {
        Factor { key: key.into(), values: values.iter().map(|v| Level::of(v)).collect() }
    }

    #[test]
    fn every_combination_is_run_with_the_axis_fastest() {
        let all = settings(&[
            factor("clock.link_scheme", &["\"serial\"", "parallel"]),
            factor("clock.window", &["1e-2", "0.005"]),
        ]);
        let names: Vec<String> = all.iter().map(Settings::name).collect();
        assert_eq!(names[0], "clock.link_scheme=serial clock.window=0.01");
        assert_eq!(names[3], "clock.link_scheme=parallel clock.window=0.005");
        assert_eq!((all[1].group(), all[1].axis()), ("clock.link_scheme=serial".into(), Some(0.005)));
        assert_eq!(all[0].overrides(), ["clock.link_scheme=\"serial\"", "clock.window=1e-2"]);
        assert_eq!(settings(&[]).len(), 1);
    }
}
