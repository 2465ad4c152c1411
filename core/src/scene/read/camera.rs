//! `[output.camera]`: where pictures are taken from, and how the camera moves.

use super::fields::Fields;
use super::limits::{Limits, number};
use super::node::Value;
use super::value::At;
use crate::scene::model::{CameraSpec, CameraStop, CameraTravel, Preset};

/// Largest angle of an orbit \[°\]: a hundred turns.
const MOST_DEG: f64 = 36_000.0;

/// `[output.camera]`.
pub(super) fn camera(fields: &Fields<'_>, preset: Option<Preset>) -> CameraSpec {
    let unit = Limits::between(0.0, 1.0, "");
    let (eye_m, target_m, travel) = place(fields);
    CameraSpec {
        eye_m,
        target_m,
        up: fields.or("up", [0.0, 0.0, 1.0], |at| at.numbers(Limits::any(""))),
        field_of_view_deg: fields.num_or("field_of_view", 40.0, Limits::between(1.0, 170.0, "°")),
        size_px: size(fields, preset),
        background: fields.or("background", [1.0; 3], |at| at.numbers(unit)),
        travel,
    }
}

/// Width and height; a preset has its own.
fn size(fields: &Fields<'_>, preset: Option<Preset>) -> [u32; 2] {
    let own = preset.map_or([960, 540], Preset::size_px);
    fields.or("size", own, |at| {
        let size = at.numbers(Limits::between(16.0, 8192.0, "px")).map(|n| n as u32);
        if preset.is_some() && size != own {
            let [width, height] = own;
            let help = "leave `size` away".to_owned();
            at.error(format!("pictures of this preset have {width} × {height} pixels"), Some(help));
        }
        size
    })
}

/// Where it stands and looks at first, and how that changes.
fn place(fields: &Fields<'_>) -> ([f64; 3], [f64; 3], CameraTravel) {
    if let Some(at) = fields.get("path") {
        for other in ["orbit", "eye", "target"] {
            fields.exclude("path", other);
        }
        let stops = path(&at);
        let (eye, target) = stops.first().map_or_else(Default::default, |s| (s.eye_m, s.target_m));
        return (eye, target, CameraTravel::Path { stops });
    }
    let degrees = |at: At<'_>| at.table(|f| f.num("degrees", Limits::between(-MOST_DEG, MOST_DEG, "°")));
    let orbit = fields.opt("orbit", degrees).flatten();
    let travel = orbit.map_or(CameraTravel::Still, |degrees| CameraTravel::Orbit { degrees });
    (fields.vec3("eye", Limits::any("m")), fields.vec3("target", Limits::any("m")), travel)
}

/// The stops of a path, each later than the one before.
fn path(at: &At<'_>) -> Vec<CameraStop> {
    let items = at.items();
    let read = |fields: &Fields<'_>| CameraStop {
        time_s: fields.num("time", Limits::not_negative("s")),
        eye_m: fields.vec3("eye", Limits::any("m")),
        target_m: fields.vec3("target", Limits::any("m")),
    };
    let mut stops: Vec<CameraStop> = Vec::new();
    for item in &items {
        let Some(stop) = item.table(read) else { continue };
        if let Some(before) = stops.last().filter(|before| stop.time_s <= before.time_s) {
            let (now, before) = (number(stop.time_s), number(before.time_s));
            let help = "give the stops in the order in which the camera passes them".to_owned();
            item.error(format!("the camera is here at {now} s, but only at {before} s at the stop before"), Some(help));
        }
        stops.push(stop);
    }
    let is_list = matches!(at.node.value, Value::List(_));
    if is_list && items.len() < 2 {
        let help = "give two stops or more, or `eye` and `target` alone for a camera that stands still".to_owned();
        at.error(format!("a path needs at least two stops, but has {}", items.len()), Some(help));
    }
    stops
}
