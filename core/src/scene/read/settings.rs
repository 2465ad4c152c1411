//! `[clock]`, `[space]`, `[output]` and `[run]`.

use super::camera::camera;
use super::fields::Fields;
use super::limits::{Limits, number};
use super::node::Value;
use super::value::At;
use crate::scene::model::{Break, ClockSpec, MotionRule, OutputSpec, RunSpec, Scheme, Space};

const TIME: Limits = Limits::positive("s");
/// Windows of the longest run; more of them never end.
const MOST_WINDOWS: f64 = 1e12;
const DEFAULT_SILENCE_LIMIT_S: f64 = 10.0;
/// Time for all solvers to join and set up \[s\].
const DEFAULT_JOIN_LIMIT_S: f64 = 30.0;

/// Axes by name.
pub(super) const AXES: [(&str, usize); 3] = [("x", 0), ("y", 1), ("z", 2)];

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

/// `[output]`.
pub(super) fn output(root: &Fields<'_>, clock: Option<&ClockSpec>) -> OutputSpec {
    // Frames are what a frame rate is for: where there is one, all that is made from them is the default.
    let has_frames = clock.is_some_and(|c| c.frames_per_second.is_some());
    let framed = |fields: &Fields<'_>, key: &'static str, default: bool| {
        fields.or(key, default, |at| {
            let wanted = at.flag();
            if wanted && !has_frames {
                let help = "add `fps` to `[clock]`, for example `fps = 24`".to_owned();
                at.error(format!("`{key}` needs frames, and the scene has no frame rate"), Some(help));
            }
            wanted && has_frames
        })
    };
    let plain = OutputSpec { pictures: has_frames, splats: has_frames, recording: has_frames, ..OutputSpec::default() };
    let read = |fields: &Fields<'_>| OutputSpec {
        trace: fields.or("trace", plain.trace, |at| at.flag()),
        ledger_every: fields.or("ledger_every", plain.ledger_every, |at| at.count(1..=1_000_000_000)),
        pictures: framed(fields, "pictures", has_frames),
        splats: framed(fields, "splats", has_frames),
        recording: framed(fields, "recording", has_frames),
        video: video(fields, framed(fields, "video", false), has_frames),
        live: false,
        report: fields.or("report", plain.report, |at| at.flag()),
        camera: fields.opt("camera", |at| at.table(camera)).flatten(),
    };
    root.opt("output", |at| at.table(read)).flatten().unwrap_or_else(|| plain.clone())
}

/// A film is made from pictures.
fn video(fields: &Fields<'_>, wanted: bool, has_pictures: bool) -> bool {
    let pictures = fields.get("pictures");
    let without = pictures.filter(|at| wanted && has_pictures && matches!(at.node.value, Value::Flag(false)));
    if let Some(at) = &without {
        let help = "leave `pictures` away, or set `video = false`".to_owned();
        at.error("`video` is made from pictures, and there are none".to_owned(), Some(help));
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
