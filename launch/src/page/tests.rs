//! A report of a made-up run.

use std::collections::BTreeMap;

use super::{Chart, Line, Picture, Report, html};
use crate::folder::summary::{Body, Energy, Frames, Interface, LeftOut, PresetNote, Process, Status, Summary};
use crate::verdict::Verdict;

pub(super) fn summary() -> Summary {
    let process = |name: &str, compute_s: f64, wait_s: f64| Process {
        name: name.into(),
        solver: "mpm".into(),
        threads: 2,
        cpu_s: Some(2.0 * compute_s),
        compute_s,
        wait_s,
        transfer_s: 0.31,
        substeps: 48_000,
        substep_bound_by: "speed of sound in jelly".into(),
        peak_rss_mib: None,
    };
    let body = Body { name: "plant".into(), solver: "soft".into(), gaussians: 113_648, ..Body::default() };
    let interface = Interface { a: "plant".into(), b: "ball".into(), kind: "contact".into(), ..Interface::default() };
    let left_out = LeftOut {
        what: "statue at 30 windows".into(),
        why: "nothing comes near it".into(),
        indicator: Some(0.82),
        limit: Some(0.1),
        saved: "1 process".into(),
    };
    Summary {
        status: Status::VerdictFailed,
        exit_code: 3,
        failure: None,
        scene: "ball <b>on</b> plant & co".into(),
        windows: 1200,
        window_s: 1.0 / 960.0,
        window_bound_by: "stiffness of the contact".into(),
        simulated_s: 1.25,
        wall_s: 14.2,
        state_hash: Some("00ff".repeat(8)),
        verdicts: vec![
            Verdict::new("transfer-defect", "plant~ball", 0.0, 0.0),
            Verdict::new("closure-window", "soft", 3.2e-7, 1e-6),
            Verdict::new("closure-run", "rigid", f64::NAN, 1e-9),
        ],
        processes: vec![process("soft", 11.3, 0.9), process("rigid", 0.2, 12.1)],
        frames: Some(Frames { taken: 60, draw_s: 4.2, ..Frames::default() }),
        bodies: vec![body],
        interfaces: vec![interface],
        energy: vec![Energy { name: "total".into(), initial_j: None, final_j: 1.5e-3, ..Energy::default() }],
        counters: BTreeMap::from([("soft".into(), BTreeMap::from([("velocity clamps".into(), 12_345)]))]),
        estimates: Vec::new(),
        energy_budget: None,
        presets: vec![PresetNote { name: "mud".into(), note: "as 100 Pa s".into(), ..PresetNote::default() }],
        left_out: vec![left_out],
        files: BTreeMap::from([("ledger".into(), "ledger.csv".into())]),
    }
}

/// The report of `summary`, given to `then`.
fn with_report<T>(summary: &Summary, then: impl FnOnce(&Report<'_>) -> T) -> T {
    let wave = |rate: f64| (0..1200).map(|i| f64::from(i) / 960.0).map(|t| (t, (rate * t).sin())).collect::<Vec<_>>();
    let closure =
        |scale: f64| wave(40.0).into_iter().map(|(t, v)| (t, scale * (1.1 + v) * v.abs().max(0.01))).collect();
    let line = |name, gate, points| Line { name, gate, points };
    let ledger = [
        Chart {
            title: "Closure of each solver",
            unit: "1",
            logarithmic: true,
            note: "Change of momentum that no impulse explains.",
            lines: vec![line("soft", Some(1e-6), closure(3e-8)), line("rigid", Some(1e-12), closure(2e-16))],
        },
        Chart {
            title: "Transfer defect of each interface",
            unit: "N s",
            logarithmic: true,
            note: "",
            lines: vec![line("plant~ball", None, wave(1.0).into_iter().map(|(t, _)| (t, 0.0)).collect())],
        },
        Chart {
            title: "Energy",
            unit: "J",
            logarithmic: false,
            note: "",
            lines: vec![line("kinetic", None, wave(3.0)), line("potential", None, wave(5.0))],
        },
    ];
    let probe =
        Chart { title: "tip & <i>", unit: "m", logarithmic: false, note: "", lines: vec![line("x", None, wave(9.0))] };
    let (pixels, command) = (b"\x89PNG".as_slice(), ["cosplat", "run", "it's here.toml"].map(String::from));
    let pictures = ["t = 0 s", "t = 0.4 s", "t = 0.8 s", "t = 1.25 s"].map(|caption| Picture { caption, png: pixels });
    then(&Report {
        summary,
        description: "A ball falls onto a captured plant.",
        pictures: &pictures,
        preview: Some(Picture { caption: "All pictures", png: pixels }),
        ledger: &ledger,
        probes: &[probe],
        command: &command,
        versions: &[("cosplat".into(), "0.1.0".into())],
    })
}

/// Every tag that is opened is closed, in order.
pub(super) fn assert_well_formed(page: &str) {
    let mut open = Vec::new();
    let mut rest = page;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').unwrap();
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap();
        let is_void = ["!DOCTYPE", "meta", "img"].contains(&name) || tag.ends_with('/');
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "before {}", &rest[..rest.len().min(80)]);
        } else if !is_void {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn a_report_holds_what_was_given() {
    let page = with_report(&summary(), html);
    let held = [
        "verdict failed",
        "1\u{202f}200",
        "exactly 0",
        "not a number",
        "32.00 %",
        "nothing comes near it",
        "113\u{202f}648",
        "velocity clamps",
        "A ball falls onto a captured plant.",
        "t = 0 s",
        "t = 0.8 s",
        "t = 1.25 s",
        "Closure of each solver [1]",
        "gate 1 × 10⁻¹²",
        "Every value is exactly 0.",
        "cosplat run 'it's here.toml'".replace("it's", r"it'\''s").as_str(),
        "00ff00ff",
        "data:image/png;base64,iVBORw==",
        "ledger.csv",
        "drawing 4.200 s",
        "as 100 Pa s",
    ]
    .map(String::from);
    for text in held {
        assert!(page.contains(&text), "{text}");
    }
    // Of four pictures the first, the middle and the last.
    assert!(!page.contains("t = 0.4 s"));
    assert_eq!(page.matches("<strong class=\"good\">passed</strong>").count(), 2);
    assert_eq!(page.matches("<strong class=\"bad\">failed</strong>").count(), 1);
}

#[test]
fn a_report_is_well_formed_and_needs_nothing_else() {
    let page = with_report(&summary(), html);
    assert_well_formed(&page);
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    for word in ["http", "<script", "<link", "@import", "url("] {
        assert!(!outside.contains(word), "{word}");
    }
}

#[test]
fn texts_of_scenes_and_plugins_are_escaped() {
    let page = with_report(&summary(), html);
    assert!(!page.contains("<b>") && page.contains("ball &lt;b&gt;on&lt;/b&gt; plant &amp; co"));
    assert!(!page.contains("<i>") && page.contains("tip &amp; &lt;i&gt;"));
}

#[test]
fn the_same_report_gives_the_same_bytes() {
    assert_eq!(with_report(&summary(), html), with_report(&summary(), html));
}

#[test]
fn a_run_that_failed_at_once_has_a_report() {
    let failed = Summary {
        status: Status::Failed,
        failure: Some("solver `soft` has died".into()),
        state_hash: None,
        verdicts: Vec::new(),
        processes: Vec::new(),
        frames: None,
        bodies: Vec::new(),
        interfaces: Vec::new(),
        energy: Vec::new(),
        counters: BTreeMap::new(),
        estimates: Vec::new(),
        left_out: Vec::new(),
        files: BTreeMap::new(),
        windows: 0,
        simulated_s: 0.0,
        wall_s: 0.0,
        ..summary()
    };
    let page = html(&Report {
        summary: &failed,
        description: "",
        pictures: &[],
        preview: None,
        ledger: &[],
        probes: &[],
        command: &[],
        versions: &[],
    });
    assert_well_formed(&page);
    assert!(page.contains("solver `soft` has died") && page.contains("nothing could be judged"));
}
