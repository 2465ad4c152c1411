//! Tables of a case file while they are read: every mistake is kept with its place, and reading goes on.

use std::cell::RefCell;
use std::ops::Range;

use cosplat_core::scene::Diagnostic;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::hint::{list, near_miss};

/// A file that is read, and what is wrong with it so far.
#[derive(Debug)]
pub(super) struct Reading<'a> {
    pub(super) text: &'a str,
    found: RefCell<Vec<Diagnostic>>,
}

impl<'a> Reading<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, found: RefCell::default() }
    }

    /// Notes a mistake.
    pub(super) fn error(&self, span: Range<usize>, path: &str, message: String, help: Option<String>) {
        let found = Diagnostic { span: Some(span), path: path.to_owned(), help, ..Diagnostic::error(message) };
        self.found.borrow_mut().push(found);
    }

    /// All mistakes in the order of the file.
    pub(super) fn into_found(self) -> Vec<Diagnostic> {
        let mut found = self.found.into_inner();
        found.sort_by_key(|d| d.span.as_ref().map_or((usize::MAX, 0), |s| (s.start, s.end)));
        found
    }
}

/// A table of the file.
pub(super) struct Section<'a> {
    pub(super) reading: &'a Reading<'a>,
    table: &'a DeTable<'a>,
    pub(super) span: Range<usize>,
    path: String,
    known: RefCell<Vec<&'static str>>,
}

/// A value with its place.
#[derive(Clone)]
pub(super) struct Item<'a> {
    pub(super) reading: &'a Reading<'a>,
    pub(super) value: &'a Spanned<DeValue<'a>>,
    pub(super) path: String,
}

impl<'a> Section<'a> {
    pub(super) fn new(reading: &'a Reading<'a>, table: &'a DeTable<'a>, span: Range<usize>, path: String) -> Self {
        Self { reading, table, span, path, known: RefCell::default() }
    }

    /// The value of a key, if it is there.
    pub(super) fn get(&self, key: &'static str) -> Option<Item<'a>> {
        self.known.borrow_mut().push(key);
        let value = self.table.get(key)?;
        Some(Item { reading: self.reading, value, path: self.path_of(key) })
    }

    /// The value of a key that must be there; `help` says what to write.
    pub(super) fn need(&self, key: &'static str, help: &str) -> Option<Item<'a>> {
        let found = self.get(key);
        if found.is_none() && !self.has_misspelled(key) {
            self.error(&format!("key `{key}` is missing"), Some(help.to_owned()));
        }
        found
    }

    /// Keys that stand here although nothing reads them, because a mistake elsewhere hides what they are for.
    pub(super) fn allow(&self, keys: &[&'static str]) {
        self.known.borrow_mut().extend(keys);
    }

    /// A number greater than zero, if it is there.
    pub(super) fn positive(&self, key: &'static str) -> Option<f64> {
        let item = self.get(key)?;
        let number = item.number()?;
        if number > 0.0 {
            return Some(number);
        }
        item.error("must be greater than 0");
        None
    }

    /// Something is wrong with the table as a whole.
    pub(super) fn error(&self, message: &str, help: Option<String>) {
        let here = if self.path.is_empty() { String::new() } else { format!("`{}`: ", self.path) };
        self.reading.error(self.span.clone(), &self.path, format!("{here}{message}"), help);
    }

    /// Complains about keys that nothing has asked for.
    pub(super) fn finish(self) {
        let known = self.known.borrow().clone();
        for (key, _) in self.table.iter().filter(|(key, _)| !known.contains(&key.get_ref().as_ref())) {
            let name: &str = key.get_ref();
            let help = match near_miss(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("keys here: {}", list(known.iter().copied())),
            };
            self.reading.error(key.span(), &self.path_of(name), format!("unknown key `{name}`"), Some(help));
        }
    }

    /// Whether a key that nobody knows looks like this one.
    fn has_misspelled(&self, key: &'static str) -> bool {
        let known = self.known.borrow();
        let mut unknown = self.table.keys().map(|k| k.get_ref().as_ref()).filter(|k: &&str| !known.contains(k));
        unknown.any(|word| near_miss(word, [key]).is_some())
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }
}

impl<'a> Item<'a> {
    /// Something is wrong with the value; `what` goes on after its name.
    pub(super) fn error(&self, what: &str) {
        self.error_with(what, None);
    }

    /// The same, with what to do.
    pub(super) fn error_with(&self, what: &str, help: Option<String>) {
        self.reading.error(self.value.span(), &self.path, format!("`{}` {what}", self.path), help);
    }

    /// As it stands in the file.
    pub(super) fn raw(&self) -> &'a str {
        &self.reading.text[self.value.span()]
    }

    /// A string that is not empty.
    pub(super) fn text(&self) -> Option<&'a str> {
        let text = self.value.get_ref().as_str().filter(|text| !text.trim().is_empty());
        if text.is_none() {
            self.error("must be a string that is not empty");
        }
        text
    }

    /// A finite number.
    pub(super) fn number(&self) -> Option<f64> {
        let is_number = matches!(self.value.get_ref(), DeValue::Integer(_) | DeValue::Float(_));
        let number = self.raw().replace('_', "").parse::<f64>().ok().filter(|n| is_number && n.is_finite());
        if number.is_none() {
            self.error("must be a number");
        }
        number
    }

    /// Whether it is true.
    pub(super) fn flag(&self) -> bool {
        let DeValue::Boolean(flag) = self.value.get_ref() else {
            self.error("must be true or false");
            return false;
        };
        *flag
    }

    /// One of several words.
    pub(super) fn word<T: Copy>(&self, words: &[(&'static str, T)]) -> Option<T> {
        let text = self.text()?;
        let found = words.iter().find(|(word, _)| *word == text);
        if found.is_none() {
            let names = || words.iter().map(|(word, _)| *word);
            let help = match near_miss(text, names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it can be {}", list(names())),
            };
            self.error_with(&format!("cannot be `{text}`"), Some(help));
        }
        found.map(|(_, value)| *value)
    }

    /// The items of a list.
    pub(super) fn items(&self) -> Vec<Item<'a>> {
        let DeValue::Array(items) = self.value.get_ref() else {
            self.error("must be a list");
            return Vec::new();
        };
        let item = |(i, value)| Item { reading: self.reading, value, path: format!("{}[{i}]", self.path) };
        items.iter().enumerate().map(item).collect()
    }

    /// Reads a table, unknown keys included.
    pub(super) fn table<T>(&self, read: impl FnOnce(&Section<'a>) -> Option<T>) -> Option<T> {
        let DeValue::Table(table) = self.value.get_ref() else {
            self.error("must be a table");
            return None;
        };
        let section = Section::new(self.reading, table, self.value.span(), self.path.clone());
        let result = read(&section);
        section.finish();
        result
    }

    /// Values below dotted keys, in the order of the file: `clock.window` may be written as one quoted key, or as a
    /// key inside a key.
    pub(super) fn leaves(&self) -> Vec<Item<'a>> {
        let DeValue::Table(table) = self.value.get_ref() else {
            return vec![self.clone()];
        };
        let inner = |(key, value): (&Spanned<_>, &'a Spanned<DeValue<'a>>)| {
            let key: &std::borrow::Cow<'_, str> = key.get_ref();
            let path = if self.path.is_empty() { key.to_string() } else { format!("{}.{key}", self.path) };
            Item { reading: self.reading, value, path }.leaves()
        };
        let mut leaves: Vec<Item<'a>> = table.iter().flat_map(inner).collect();
        leaves.sort_by_key(|leaf| leaf.value.span().start);
        leaves
    }
}
