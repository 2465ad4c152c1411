//! `[[gate]]` of a case file.

use super::case::{Claim, Factor, Gate, Level, Quantity};
use super::outcome::CLASSES;
use super::section::{Item, Section};
use crate::hint::{list, near_miss};

/// Every `[[gate]]`.
pub(super) fn gates(root: &Section<'_>, quantities: &[Quantity], vary: &[Factor]) -> Vec<Gate> {
    let Some(item) = root.get("gate") else { return Vec::new() };
    item.items().iter().filter_map(|item| item.table(|section| gate(section, quantities, vary))).collect()
}

fn gate(section: &Section<'_>, quantities: &[Quantity], vary: &[Factor]) -> Option<Gate> {
    let name = section.get("name").and_then(|item| item.text().map(str::to_owned));
    let place = section.get("where").map(|item| place(&item, vary)).unwrap_or_default();
    let quantity = section.get("quantity").and_then(|item| {
        let name = item.text()?;
        if quantities.iter().all(|q| q.name != name) {
            let names = quantities.iter().map(|q| q.name.as_str());
            item.error_with("is none of the quantities of this case", Some(format!("there are {}", list(names))));
        }
        Some(name.to_owned())
    });
    let explained = section.get("explained").and_then(|item| item.text().map(str::to_owned));
    let reason = section.need("reason", "say why this must hold: the order of the scheme, a published figure");
    let claims = [section.get("order"), section.get("decay"), section.get("error"), section.get("outcome")];
    let claim = match claims.each_ref().map(Option::as_ref) {
        [Some(order), None, None, None] => Claim::Order(range(order, vary, &place, "the order")?),
        [None, Some(decay), None, None] => Claim::Decay(range(decay, vary, &place, "the factor per unit")?),
        [None, None, Some(_), None] => Claim::Error(section.positive("error")?),
        [None, None, None, Some(outcome)] => Claim::Outcome(outcome.word(&CLASSES)?),
        _ => {
            let help = "write `order = [1.9, 2.1]`, `decay = [0.98, 0.99]`, `error = 0.02` or `outcome = \"refused\"`";
            section.error("must claim one thing", Some(help.into()));
            return None;
        }
    };
    Some(Gate { name, r#where: place, quantity, claim, reason: reason?.text()?.to_owned(), explained })
}

/// The least and the most of something that is fitted along the axis.
fn range(item: &Item<'_>, vary: &[Factor], place: &[(String, String)], what: &str) -> Option<[f64; 2]> {
    let numbers: Vec<f64> = item.items().iter().filter_map(Item::number).collect();
    let axis = vary.last().filter(|f| f.values.iter().filter(|v| v.number().is_some()).count() > 1);
    if axis.is_none_or(|axis| place.iter().any(|(key, _)| *key == axis.key)) {
        item.error("needs several numbers of the last key of `[vary]`, and no fixed value of it in `where`");
    }
    match numbers.as_slice() {
        [least, most] if least <= most => Some([*least, *most]),
        _ => {
            item.error(&format!("must be the smallest and the largest value of {what} that pass, as in [1.9, 2.1]"));
            None
        }
    }
}

/// The runs that a gate is about.
fn place(item: &Item<'_>, vary: &[Factor]) -> Vec<(String, String)> {
    let top = Item { path: String::new(), ..item.clone() };
    let mut found = Vec::new();
    for leaf in top.leaves() {
        let level = Level::of(leaf.raw());
        match vary.iter().find(|factor| factor.key == leaf.path) {
            None => {
                let keys = || vary.iter().map(|factor| factor.key.as_str());
                let help = match near_miss(&leaf.path, keys()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("varied are {}", list(keys())),
                };
                leaf.error_with("is not varied", Some(help));
            }
            Some(factor) if !factor.values.iter().any(|value| value.shown == level.shown) => {
                let values = factor.values.iter().map(|value| value.shown.as_str());
                leaf.error_with(&format!("is never {}", level.shown), Some(format!("its values are {}", list(values))));
            }
            Some(_) => found.push((leaf.path.clone(), level.shown)),
        }
    }
    found
}
