//! `[clock]`, `[space]`, `[output]` and `[run]`.

use std::collections::BTreeMap;

use super::camera::camera;
use super::fields::Fields;
use super::limits::{Limits, number};
use super::node::Value;
use super::value::At;
use crate::scene::model::{
    Break, ClockSpec, MeshForm, MotionRule, OutputSpec, Preset, RendererSpec, RunSpec, Scheme, Space, SplatForm,
};

const TIME: Limits = Limits::positive("s");
/// Windows of the longest run; more of them never end.
const MOST_WINDOWS: f64 = 1e12;
const DEFAULT_SILENCE_LIMIT_S: f64 = 10.0;
/// Time for all solvers to join and set up \[s\].
const DEFAULT_JOIN_LIMIT_S: f64 = 30.0;

/// Axes by name.
pub(super) const AXES: [(&str, usize); 3] = [("x", 0), ("y", 1), ("z", 2)];

/// Forms of splat files, by name.
const FORMS: [(&str, SplatForm); 3] =
    [("ply", SplatForm::Ply), ("spz", SplatForm::Spz), ("compact", SplatForm::Compact)];

/// Formats of meshes, by name.
const MESHES: [(&str, MeshForm); 2] = [("obj", MeshForm::Obj), ("ply", MeshForm::Ply)];

/// Who draws, by name.
const RENDERERS: [(&str, RendererSpec); 3] =
    [("cpu", RendererSpec::Cpu), ("gpu", RendererSpec::Gpu), ("auto", RendererSpec::Auto)];

/// `[clock]`.
pub(super) fn clock(root: &Fields<'_>) -> Option<ClockSpec> {
    let Some(at) = root.get("clock") else {
        let help = "add `[clock]` with `duration = 1.0` below it";
        root.absence("section `[clock]` is missing".to_owned(), Some(help.to_owned()));
        return None;
    };
    at.table(|fields| {
        let duration_s = fields.num("duration", TIME);
        ClockSpec {
            duration_s,
            window_s: fields.opt("window", |at| window(&at, duration_s)),
            exact_window: exact_window(fields),
            frames_per_second: fields.opt("fps", |at| at.num(Limits::positive("frames/s"))),
            contact_scheme: fields.or("contact_scheme", Scheme::Serial, |at| contact_scheme(&at)),
            link_scheme: fields
                .opt("link_scheme", |at| {
                    at.word(&[
                        ("alternating", Scheme::Alternating),
                        ("centred", Scheme::Centred),
                        ("serial", Scheme::Serial),
                        ("parallel", Scheme::Parallel),
                    ])
                })
                .flatten()
                .unwrap_or(Scheme::Alternating),
            motion_rule: fields
                .opt("motion_rule", |at| {
                    at.word(&[
                        ("hold", MotionRule::Hold),
                        ("linear", MotionRule::Linear),
                        ("hermite", MotionRule::Hermite),
                    ])
                })
                .flatten()
                .unwrap_or(MotionRule::Hold),
        }
    })
}

fn window(at: &At<'_>, duration_s: f64) -> f64 {
    let window_s = at.num(TIME);
    if window_s > duration_s {
        let message = format!("`window` ({} s) is longer than `duration` ({} s)", number(window_s), number(duration_s));
        at.error(message, None);
    } else if duration_s / window_s > MOST_WINDOWS {
        let message = format!("{} s in windows of {} s are too many windows", number(duration_s), number(window_s));
        at.error(message, None);
    }
    window_s
}

fn exact_window(fields: &Fields<'_>) -> bool {
    fields.or("exact_window", false, |at| {
        let exact = at.flag();
        if exact && !fields.has("window") {
            let help = "add `window`, for example `window = 0.001`".to_owned();
            at.error("there is no window that could be kept".to_owned(), Some(help));
        }
        exact
    })
}

fn contact_scheme(at: &At<'_>) -> Scheme {
    let scheme = at.word(&[
        ("serial", Some(Scheme::Serial)),
        ("parallel", Some(Scheme::Parallel)),
        ("alternating", None),
        ("centred", None),
    ]);
    if scheme == Some(None) {
        let help = "contacts take `serial` or `parallel`; set `link_scheme` for links";
        at.error("this scheme is for links only".to_owned(), Some(help.to_owned()));
    }
    scheme.flatten().unwrap_or(Scheme::Serial)
}

/// `[space]`.
pub(super) fn space(root: &Fields<'_>) -> Space {
    let slab = |at: At<'_>| {
        at.table(|fields| Space::Slab {
            normal: fields.must("normal", |at| at.word(&AXES)).flatten().unwrap_or(2),
            thickness_m: fields.num("thickness", Limits::positive("m")),
        })
    };
    root.opt("space", |at| at.table(|fields| fields.opt("slab", slab).flatten()))
        .flatten()
        .flatten()
        .unwrap_or(Space::Full)
}

/// `[output]`. A preset sets the frame rate of the clock where the scene does not.
pub(super) fn output(root: &Fields<'_>, clock: Option<&mut ClockSpec>) -> OutputSpec {
    // Frames are what a frame rate is for: where there is one, all that is made from them is the default.
    let has_rate = clock.as_ref().is_some_and(|c| c.frames_per_second.is_some());
    let plain = OutputSpec { pictures: has_rate, splats: has_rate, recording: has_rate, ..OutputSpec::default() };
    let read = |fields: &Fields<'_>| {
        let preset = fields.opt("preset", |at| preset(&at, clock)).flatten();
        let has_frames = has_rate || preset.is_some();
        let framed = |key: &'static str, default: bool| {
            fields.or(key, default, |at| {
                let wanted = at.flag();
                if wanted && !has_frames {
                    let help = "add `fps` to `[clock]`, for example `fps = 24`".to_owned();
                    at.error(format!("`{key}` needs frames, and the scene has no frame rate"), Some(help));
                }
                wanted && has_frames
            })
        };
        let video = framed("video", false);
        let (splats, splat_form) = splats(fields, has_frames, &framed);
        OutputSpec {
            trace: fields.or("trace", plain.trace, |at| at.flag()),
            ledger_every: fields.or("ledger_every", plain.ledger_every, |at| at.count(1..=1_000_000_000)),
            pictures: framed("pictures", has_frames),
            splats,
            splat_form,
            surfaces: surfaces(fields, has_frames),
            recording: framed("recording", has_frames),
            video: made_of_pictures(fields, "video", video, has_frames),
            live: false,
            report: fields.or("report", plain.report, |at| at.flag()),
            turn_colours: fields.or("turn_colours", plain.turn_colours, |at| at.flag()),
            renderer: fields.opt("renderer", |at| at.word(&RENDERERS)).flatten().unwrap_or_default(),
            preset: preset.filter(|_| made_of_pictures(fields, "preset", true, has_frames)),
            camera: fields.opt("camera", |at| at.table(|fields| camera(fields, preset))).flatten(),
            bindings: BTreeMap::new(),
        }
    };
    root.opt("output", |at| at.table(read)).flatten().unwrap_or_else(|| plain.clone())
}

/// Whether splat files are written, and in which form: `false`, `true`, or the name of a form.
fn splats(fields: &Fields<'_>, has_frames: bool, framed: &dyn Fn(&'static str, bool) -> bool) -> (bool, SplatForm) {
    let named = fields.get("splats").filter(|at| matches!(at.node.value, Value::Text(_)));
    let Some(at) = named else { return (framed("splats", has_frames), SplatForm::default()) };
    if !has_frames {
        let help = "add `fps` to `[clock]`, for example `fps = 24`".to_owned();
        at.error("`splats` needs frames, and the scene has no frame rate".to_owned(), Some(help));
    }
    (has_frames, at.word(&FORMS).unwrap_or_default())
}

/// Whether surfaces of liquids are written, and in which format: `false`, or the name of one.
fn surfaces(fields: &Fields<'_>, has_frames: bool) -> Option<MeshForm> {
    let at = fields.get("surfaces").filter(|at| !matches!(at.node.value, Value::Flag(false)))?;
    if !has_frames {
        let help = "add `fps` to `[clock]`, for example `fps = 24`".to_owned();
        at.error("`surfaces` needs frames, and the scene has no frame rate".to_owned(), Some(help));
    }
    at.word(&MESHES).filter(|_| has_frames)
}

/// A preset, for which the clock has to give as many frames as it needs.
fn preset(at: &At<'_>, clock: Option<&mut ClockSpec>) -> Option<Preset> {
    let preset = at.word(&[("video-model", Preset::VideoModel)])?;
    let clock = clock?;
    let steps = f64::from(preset.frames() - 1);
    let fps = *clock.frames_per_second.get_or_insert(steps / clock.duration_s);
    // Rounding of a rate that is given in decimals.
    if (fps * clock.duration_s - steps).abs() > 1e-6 * steps {
        let frames = preset.frames();
        let rate = number(steps / clock.duration_s);
        let message = format!("the preset needs {frames} frames, and the clock gives another number");
        at.error(
            message,
            Some(format!("leave `clock.fps` away, which makes it {rate}, or set `duration = {}`", number(steps / fps))),
        );
    }
    Some(preset)
}

/// Whether what is made of pictures can be: a scene that wants it and no pictures is mistaken.
fn made_of_pictures(fields: &Fields<'_>, key: &str, wanted: bool, has_pictures: bool) -> bool {
    let pictures = fields.get("pictures");
    let without = pictures.filter(|at| wanted && has_pictures && matches!(at.node.value, Value::Flag(false)));
    if let Some(at) = &without {
        let help = format!("leave `pictures` away, or leave `{key}` away");
        at.error(format!("`{key}` is made from pictures, and there are none"), Some(help));
    }
    wanted && without.is_none()
}

/// `[run]`.
pub(super) fn run(root: &Fields<'_>) -> RunSpec {
    let read = |fields: &Fields<'_>| RunSpec {
        threads: fields.opt("threads", |at| at.count(1..=4096) as usize),
        join_limit_s: fields.num_or("join_limit", DEFAULT_JOIN_LIMIT_S, TIME),
        silence_limit_s: fields.num_or("silence_limit", DEFAULT_SILENCE_LIMIT_S, TIME),
        rigidify: fields.or("rigidify", true, |at| at.flag()),
        break_with: fields.opt("break", |at| at.word(&Break::ALL)).flatten(),
    };
    let default = RunSpec {
        threads: None,
        join_limit_s: DEFAULT_JOIN_LIMIT_S,
        silence_limit_s: DEFAULT_SILENCE_LIMIT_S,
        rigidify: true,
        break_with: None,
    };
    root.opt("run", |at| at.table(read)).flatten().unwrap_or(default)
}
