//! A table being read: keeps track of the keys that are known, and reports the others.

use std::cell::{Cell, RefCell};

use super::limits::Limits;
use super::node::{Origin, Table};
use super::report::{Report, listed, nearest, quoted, suggestion};
use super::value::At;

/// The keys of one table.
pub(super) struct Fields<'a> {
    table: &'a Table,
    pub(super) origin: &'a Origin,
    pub(super) path: String,
    pub(super) report: &'a Report,
    known: RefCell<Vec<&'static str>>,
    /// Groups of keys of which one must be there, but none is.
    missing: RefCell<Vec<Vec<&'static str>>>,
    help_for_missing: Cell<Option<&'static str>>,
    accepts_all: Cell<bool>,
}

impl<'a> Fields<'a> {
    /// Reads a table with `read`, then reports every key that `read` did not ask for.
    pub(super) fn read<T>(
        table: &'a Table,
        origin: &'a Origin,
        path: &str,
        report: &'a Report,
        read: impl FnOnce(&Self) -> T,
    ) -> T {
        let fields = Self {
            table,
            origin,
            path: path.to_owned(),
            report,
            known: RefCell::default(),
            missing: RefCell::default(),
            help_for_missing: Cell::default(),
            accepts_all: Cell::default(),
        };
        let result = read(&fields);
        fields.finish();
        result
    }

    /// The value of a key, if it is there.
    pub(super) fn get(&self, key: &'static str) -> Option<At<'a>> {
        self.known.borrow_mut().push(key);
        let entry = self.table.0.get(key)?;
        Some(At { node: &entry.node, path: self.path_of(key), report: self.report })
    }

    /// Whether the key is there.
    pub(super) fn has(&self, key: &'static str) -> bool {
        self.get(key).is_some()
    }

    /// The value of a key that must be there.
    pub(super) fn need(&self, key: &'static str) -> Option<At<'a>> {
        let value = self.get(key);
        if value.is_none() {
            self.missing.borrow_mut().push(vec![key]);
        }
        value
    }

    /// Reads a key that must be there.
    pub(super) fn must<T>(&self, key: &'static str, read: impl FnOnce(At<'a>) -> T) -> Option<T> {
        self.need(key).map(read)
    }

    /// Reads a key that may be there.
    pub(super) fn opt<T>(&self, key: &'static str, read: impl FnOnce(At<'a>) -> T) -> Option<T> {
        self.get(key).map(read)
    }

    /// Reads a key that has a default.
    pub(super) fn or<T>(&self, key: &'static str, default: T, read: impl FnOnce(At<'a>) -> T) -> T {
        self.get(key).map_or(default, read)
    }

    /// A number that must be there; NaN stands in, so that no comparison with it complains again.
    pub(super) fn num(&self, key: &'static str, limits: Limits) -> f64 {
        self.must(key, |at| at.num(limits)).unwrap_or(f64::NAN)
    }

    /// A number with a default.
    pub(super) fn num_or(&self, key: &'static str, default: f64, limits: Limits) -> f64 {
        self.or(key, default, |at| at.num(limits))
    }

    /// A vector that must be there.
    pub(super) fn vec3(&self, key: &'static str, limits: Limits) -> [f64; 3] {
        self.must(key, |at| at.numbers(limits)).unwrap_or_default()
    }

    /// A vector that is zero if it is not there.
    pub(super) fn vec3_or_zero(&self, key: &'static str, limits: Limits) -> [f64; 3] {
        self.or(key, [0.0; 3], |at| at.numbers(limits))
    }

    /// Reads each table of a list of tables; tables that cannot be read are reported and left out.
    pub(super) fn tables<T>(&self, key: &'static str, mut read: impl FnMut(&Fields<'a>) -> Option<T>) -> Vec<T> {
        let Some(list) = self.get(key) else { return Vec::new() };
        list.tables(key).iter().filter_map(|item| item.table(|fields| read(fields)).flatten()).collect()
    }

    /// Reads each entry of a table whose keys are names chosen by the user.
    pub(super) fn named(&self, key: &'static str, mut read: impl FnMut(&str, &Origin, &Fields<'a>)) {
        let Some(at) = self.get(key) else { return };
        let Some(table) = at.as_table() else { return };
        for (name, entry) in &table.0 {
            let item = At { node: &entry.node, path: format!("{}.{name}", at.path), report: self.report };
            item.table(|fields| read(name, &entry.key, fields));
        }
    }

    /// The one key of `keys` that is there; more or fewer are reported.
    pub(super) fn one_key(&self, keys: &[&'static str]) -> Option<(&'static str, At<'a>)> {
        let mut found = keys.iter().filter_map(|key| Some((*key, self.get(key)?)));
        let Some(first) = found.next() else {
            self.missing.borrow_mut().push(keys.to_vec());
            return None;
        };
        for (key, at) in found {
            at.error(format!("`{key}` and `{}` exclude each other", first.0), None);
        }
        Some(first)
    }

    /// Complains if both keys are there.
    pub(super) fn exclude(&self, key: &'static str, other: &'static str) {
        if let (Some(_), Some(at)) = (self.get(key), self.get(other)) {
            at.error(format!("`{other}` and `{key}` exclude each other"), None);
        }
    }

    /// What to say beside missing keys.
    pub(super) fn help_for_missing(&self, help: &'static str) {
        self.help_for_missing.set(Some(help));
    }

    /// Gives up on telling known keys from unknown ones.
    pub(super) fn accept_all_keys(&self) {
        self.accepts_all.set(true);
    }

    /// Something is wrong with the table as a whole.
    pub(super) fn error(&self, message: String, help: Option<String>) {
        self.report.error(self.origin, &self.path, message, help);
    }

    /// Something is missing in the table.
    pub(super) fn absence(&self, message: String, help: Option<String>) {
        self.report.absence(self.origin, &self.path, message, help);
    }

    /// Begin of a message about the table as a whole: its path, or nothing at the top.
    fn here(&self) -> String {
        if self.path.is_empty() { String::new() } else { format!("`{}`: ", self.path) }
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Reports unknown keys, and missing ones unless a misspelled key stands for them.
    fn finish(&self) {
        let mut known = self.known.borrow().clone();
        known.sort_unstable();
        known.dedup();
        let is_unknown = |key: &str| !self.accepts_all.get() && !known.contains(&key);
        let mut meant = Vec::new();
        for (key, entry) in self.table.0.iter().filter(|(key, _)| is_unknown(key)) {
            let message = format!("{}unknown key {}", self.here(), quoted(key));
            self.report.error(&entry.key, &self.path_of(key), message, suggestion(key, &known, "keys here:"));
            meant.extend(nearest(key, known.iter().copied()));
        }
        let mut missing = self.missing.borrow_mut();
        missing.retain(|keys| !keys.iter().any(|key| meant.contains(key)));
        self.report_missing_keys(&missing);
    }

    fn report_missing_keys(&self, missing: &[Vec<&'static str>]) {
        let help = || self.help_for_missing.get().map(str::to_owned);
        let single: Vec<&str> = missing.iter().filter(|keys| keys.len() == 1).flatten().copied().collect();
        match single.as_slice() {
            [] => {}
            [key] => self.absence(format!("{}key `{key}` is missing", self.here()), help()),
            keys => self.absence(format!("{}keys {} are missing", self.here(), listed(keys)), help()),
        }
        for keys in missing.iter().filter(|keys| keys.len() > 1) {
            self.absence(format!("{}one of these keys is missing: {}", self.here(), listed(keys)), help());
        }
    }
}
