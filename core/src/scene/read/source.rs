//! Shape of a body or static collider: exactly one of the source keys, in a short form or as a table.

use super::fields::Fields;
use super::limits::Limits;
use super::node::Value;
use super::value::At;
use crate::scene::model::{Fill, Source};

const LENGTH: Limits = Limits::positive("m");
const POSITION: Limits = Limits::any("m");

const KEYS: [&str; 9] = ["splat", "mesh", "height_field", "box", "sphere", "cylinder", "plane", "points", "cloud"];

const UPS: [(&str, &str); 7] = [
    ("+x", "+x"),
    ("-x", "-x"),
    ("+y", "+y"),
    ("-y", "-y"),
    ("+z", "+z"),
    ("-z", "-z"),
    (Source::UP_OF_FORMAT, Source::UP_OF_FORMAT),
];

const FILLS: [(&str, Fill); 3] =
    [("winding", Fill::Winding), ("physgaussian", Fill::Physgaussian), ("none", Fill::None)];

/// Reads the one source of a body or static collider.
pub(super) fn source(fields: &Fields<'_>) -> Option<Source> {
    let (key, at) = fields.one_key(&KEYS)?;
    match key {
        "splat" => splat(&at),
        "mesh" => mesh(&at).map(|(file, metres_per_unit, up)| Source::Mesh { file, metres_per_unit, up }),
        "height_field" => {
            mesh(&at).map(|(file, metres_per_unit, up)| Source::HeightField { file, metres_per_unit, up })
        }
        "box" => short_or_table(&at, |at| at.numbers(LENGTH), "size").map(|size_m| Source::Box { size_m }),
        "sphere" => short_or_table(&at, |at| at.num(LENGTH), "radius").map(|radius_m| Source::Sphere { radius_m }),
        "cylinder" => cylinder(&at),
        "plane" => plane(&at),
        "points" => points(&at),
        _ => at.table(cloud),
    }
}

/// A value as itself or as the only key of a table.
fn short_or_table<T>(at: &At<'_>, read: impl Fn(&At<'_>) -> T, key: &'static str) -> Option<T> {
    match at.node.value {
        Value::Table(_) => at.table(|fields| fields.must(key, |at| read(&at))).flatten(),
        _ => Some(read(at)),
    }
}

fn metres_per_unit(fields: &Fields<'_>) -> f64 {
    fields.num_or("metres_per_unit", 1.0, LENGTH)
}

fn up(fields: &Fields<'_>) -> String {
    fields.opt("up", |at| at.word(&UPS)).flatten().unwrap_or(Source::UP_OF_FORMAT).to_owned()
}

fn file(fields: &Fields<'_>) -> String {
    fields.must("file", |at| at.text()).unwrap_or_default()
}

fn splat(at: &At<'_>) -> Option<Source> {
    if let Value::Text(_) = at.node.value {
        let (file, up, fill) = (at.text(), Source::UP_OF_FORMAT.to_owned(), Fill::default());
        return Some(Source::Splat { file, metres_per_unit: 1.0, up, min_opacity: 0.0, keep_box: None, fill });
    }
    at.table(|fields| Source::Splat {
        file: file(fields),
        metres_per_unit: metres_per_unit(fields),
        up: up(fields),
        min_opacity: fields.num_or("min_opacity", 0.0, Limits::between(0.0, 1.0, "")),
        keep_box: fields.opt("keep_box", |at| keep_box(&at)),
        fill: fields.opt("fill", |at| at.word(&FILLS)).flatten().unwrap_or_default(),
    })
}

fn keep_box(at: &At<'_>) -> [[f64; 3]; 2] {
    let [low, high] = at.rows(POSITION);
    // Not written as `low >= high`: a corner that could not be read is NaN and complained about already.
    if low.iter().zip(&high).any(|(low, high)| low > high) {
        at.error("`keep_box` is empty: its first corner must be the lower one in x, y and z".to_owned(), None);
    }
    [low, high]
}

/// File, length of its unit \[m\] and up axis of a triangle mesh.
fn mesh(at: &At<'_>) -> Option<(String, f64, String)> {
    if let Value::Text(_) = at.node.value {
        return Some((at.text(), 1.0, Source::UP_OF_FORMAT.to_owned()));
    }
    at.table(|fields| (file(fields), metres_per_unit(fields), up(fields)))
}

fn cylinder(at: &At<'_>) -> Option<Source> {
    if let Value::List(_) = at.node.value {
        let [radius_m, height_m] = at.numbers(LENGTH);
        return Some(Source::Cylinder { radius_m, height_m });
    }
    at.table(|fields| Source::Cylinder {
        radius_m: fields.num("radius", LENGTH),
        height_m: fields.num("height", LENGTH),
    })
}

fn plane(at: &At<'_>) -> Option<Source> {
    match &at.node.value {
        Value::Text(text) if text == "infinite" => Some(Source::Plane { size_m: None }),
        Value::List(_) => Some(Source::Plane { size_m: Some(at.numbers(LENGTH)) }),
        Value::Table(_) => at.table(|fields| Source::Plane { size_m: fields.opt("size", |at| at.numbers(LENGTH)) }),
        _ => {
            at.must_be("\"infinite\", a size such as [2.0, 2.0], or a table", None);
            None
        }
    }
}

fn points(at: &At<'_>) -> Option<Source> {
    let positions_m = short_or_table(at, |at| at.vectors(POSITION), "positions")?;
    if positions_m.is_empty() && matches!(&at.node.value, Value::List(_)) {
        at.error("`points` is empty".to_owned(), None);
    }
    Some(Source::Points { positions_m })
}

fn cloud(fields: &Fields<'_>) -> Source {
    Source::Cloud {
        count: fields.must("count", |at| at.count(1..=1_000_000_000)).unwrap_or(1) as usize,
        size_m: fields.vec3("size", LENGTH),
    }
}
