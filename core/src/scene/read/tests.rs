//! Whole files, good and bad, and the text a user gets to see.

use super::*;
use crate::scene::diagnostic::render;
use crate::scene::material::Material;
use crate::scene::model::*;

mod arbitrary;
mod complete;
mod output;

/// Two masses, three springs, cut at the middle one.
pub(super) const OSCILLATOR: &str = r#"
format = 1
name = "oscillator"
title = "Two masses, three springs, cut at the middle one"

[clock]
duration = 1.0
window = 0.01

[solver.left]
plugin = "oscillator"

[solver.right]
plugin = "oscillator"

[[body]]
name = "mass-left"
solver = "left"
material = "point-mass"
points = [[1.0, 0.0, 0.0]]
mass = 1.0

[[body]]
name = "mass-right"
solver = "right"
material = "point-mass"
points = [[2.0, 0.0, 0.0]]
mass = 1.0

[[link]]
name = "middle"
a = "mass-left"
b = "mass-right"
stiffness = 157.9
rest = [-1, 0, 0]

[[link]]
name = "wall"
a = "mass-left"
stiffness = 39.5
"#;

/// The text shown for a file that must not be a scene.
pub(super) fn mistakes(text: &str) -> String {
    let diagnostics = parse(text).expect_err("this text has mistakes");
    render("scene.toml", text, &diagnostics)
}

/// The oscillator after overrides.
fn with(overrides: &[&str]) -> Parsed {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    parse_with(OSCILLATOR, &overrides)
}

fn first_message(parsed: Parsed) -> String {
    parsed.expect_err("this override is wrong").remove(0).message
}

#[test]
fn a_small_scene_is_read_with_its_defaults() {
    let (scene, warnings) = parse(OSCILLATOR).expect("a good scene");
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(scene.clock.link_scheme, Scheme::Alternating);
    assert_eq!(scene.clock.contact_scheme, Scheme::Serial);
    assert_eq!(scene.clock.motion_rule, MotionRule::Hold);
    assert_eq!(
        scene.run,
        RunSpec { threads: None, join_limit_s: 30.0, silence_limit_s: 10.0, rigidify: true, break_with: None }
    );
    assert_eq!(scene.solvers["left"].plugin.as_deref(), Some("oscillator"));
    assert_eq!(scene.bodies[1].material, Material::PointMass);
    let wall = Link {
        name: "wall".into(),
        a: "mass-left".into(),
        b: None,
        anchor_m: [0.0; 3],
        stiffness_n_m: 39.5,
        damping_n_s_m: 0.0,
        rest_m: [0.0; 3],
        first: None,
    };
    assert_eq!(scene.links[1], wall);
    assert!(scene.actions.is_empty());
}

const TEN_MISTAKES: &str = r#"name = "Bad Name"
[clock]
duration = -1.0
windw = 0.01
contact_scheme = "centred"
[[body]]
name = "bag"
material = { kind = "elastic", densty = 50, youngs_modulus = 1e4, poissons_ratio = 0.5 }
box = [1, 1, 1]
sphere = 0.5
[[body]]
name = "bag"
material = "plushy"
mass = "heavy"
points = [[0, 0, inf]]
orientation = [0, 0, 0, 0]
[[link]]
name = "rope"
a = "bagg"
stiffness = 1.0
"#;

#[test]
fn all_mistakes_of_a_file_are_shown_at_once() {
    let text = mistakes(TEN_MISTAKES);
    for (line, message) in [
        (1, "`Bad Name` cannot be a name"),
        (3, "`duration` must be greater than 0 s, but is -1 s"),
        (4, "`clock`: unknown key `windw`"),
        (5, "this scheme is for links only"),
        (8, "`body[0].material`: unknown key `densty`"),
        (8, "`poissons_ratio` must be greater than -1 and less than 0.5, but is 0.5"),
        (10, "`sphere` and `box` exclude each other"),
        (12, "the name `bag` is taken by `body[0]`"),
        (13, "there is no material named `plushy`"),
        (14, "`mass` must be a number, but is the string `heavy`"),
        (15, "`points[0][2]` must be a finite number, but is inf"),
        (16, "`orientation` is no rotation: its length is zero"),
        (19, "there is no body named `bagg`"),
    ] {
        let shown = text.split("\n\n").find(|block| block.contains(&format!("error: {message}")));
        let shown = shown.unwrap_or_else(|| panic!("no message `{message}` in\n{text}"));
        assert!(shown.contains(&format!("--> scene.toml:{line}:")), "not at line {line}:\n{shown}");
    }
    assert!(text.ends_with("\n13 errors\n"), "{text}");
}

#[test]
fn near_misses_are_suggested() {
    let text = mistakes(TEN_MISTAKES);
    for near in ["window", "density", "plushie", "bag"] {
        assert!(text.contains(&format!("help: did you mean `{near}`?")), "{near}:\n{text}");
    }
}

#[test]
fn a_finding_quotes_its_line() {
    let text = mistakes(&OSCILLATOR.replace("window", "windw"));
    let expected = "error: `clock`: unknown key `windw`\n --> scene.toml:8:1\n  |\n8 | windw = 0.01\n  | ^^^^^\n  \
                    = help: did you mean `window`?\n\n1 error\n";
    assert_eq!(text, expected);
}

#[test]
fn syntax_errors_are_all_shown_and_do_not_raise_others() {
    let text = OSCILLATOR.replace("duration = 1.0", "duration = ").replace("mass = 1.0", "mass = = 1.0");
    let shown = mistakes(&text);
    for line in [7, 21, 28] {
        assert!(shown.contains(&format!("scene.toml:{line}:")), "line {line}:\n{shown}");
    }
    assert!(!shown.contains("missing") && !shown.contains("unknown"), "{shown}");
}

#[test]
fn a_broken_section_header_does_not_blame_the_lines_below() {
    let shown = mistakes(&OSCILLATOR.replace("[solver.right]", "[solver.right"));
    assert!(shown.contains("scene.toml:13:") && shown.ends_with("\n1 error\n"), "{shown}");
}

#[test]
fn a_newer_format_is_the_only_complaint() {
    let shown = mistakes(&format!("{}\nnew_key = 3", "format = 7\nmodern = true"));
    assert!(
        shown.contains("format 7") && shown.contains("up to format 1") && shown.ends_with("\n1 error\n"),
        "{shown}"
    );
}

#[test]
fn overrides_reach_sections_members_and_parameters() {
    let (scene, _) = with(&[
        "clock.window=0.005",
        "clock.link_scheme=centred",
        "body.mass-left.mass=2",
        "body.1.velocity=[0, 1, 0]",
        "solver.left.params.tolerance=1e-9",
        "solver.left.params.steps=4",
        "run.threads=3",
    ])
    .expect("good overrides");
    assert_eq!(scene.clock.window_s, Some(0.005));
    assert_eq!(scene.clock.link_scheme, Scheme::Centred);
    assert_eq!(scene.bodies[0].mass_kg, Some(2.0));
    let still_turning = VelocityField::Twist { linear_m_s: [0.0, 1.0, 0.0], angular_rad_s: [0.0; 3] };
    assert_eq!(scene.bodies[1].velocity, still_turning);
    assert_eq!(scene.solvers["left"].params["tolerance"], 1e-9);
    assert_eq!(scene.solvers["left"].params["steps"], 4);
    assert_eq!(scene.run.threads, Some(3));
}

#[test]
fn a_bad_override_is_named() {
    for (assignment, message) in [
        ("clock.window", "there is no `=`"),
        (".=1", "is no path"),
        ("clock.window=-1", "`window` must be greater than 0 s"),
        ("clock.windw=1", "unknown key `windw`"),
        ("body.mass-middle.mass=1", "`body` has no member `mass-middle`"),
        ("body.7.mass=1", "`body` has no member `7`"),
        ("name.x=1", "`name` is a string"),
        ("clock.window=[1,", "the value cannot be read"),
        ("clock=3", "`clock` must be a table"),
    ] {
        let shown = first_message(with(&[assignment]));
        assert!(shown.contains(message), "{assignment}: {shown}");
        assert!(shown.contains(&format!("override `{assignment}`")), "{assignment}: {shown}");
    }
}

#[test]
fn a_solver_without_bodies_is_a_warning() {
    let text = format!("{OSCILLATOR}\n[solver.idle]\n");
    let (_, warnings) = parse(&text).expect("a good scene");
    assert_eq!(warnings.len(), 1);
    assert!(render("a", &text, &warnings).contains("warning: solver `idle` has no bodies"));
}

#[test]
fn a_solver_name_close_to_a_section_is_a_mistake() {
    let shown = mistakes(&OSCILLATOR.replace("solver = \"left\"", "solver = \"leftt\""));
    assert!(shown.contains("there is no solver named `leftt`") && shown.contains("did you mean `left`?"), "{shown}");
}

#[test]
fn a_height_field_is_ground_and_no_body() {
    let ground =
        format!("{OSCILLATOR}\n[[static]]\nname = \"hill\"\nheight_field = {{ file = \"hill.obj\", up = \"+y\" }}\n");
    let (scene, _) = parse(&ground).unwrap_or_else(|d| panic!("{}", render("a", &ground, &d)));
    let expected = Source::HeightField { file: "hill.obj".into(), metres_per_unit: 1.0, up: "+y".into() };
    assert_eq!(scene.statics[0].source, expected);
    let body = OSCILLATOR.replacen("points = [[1.0, 0.0, 0.0]]", "height_field = \"hill.obj\"", 1);
    let shown = mistakes(&body.replacen("\"point-mass\"", "{ kind = \"rigid\", density = 1.0 }", 1));
    assert!(shown.contains("a body cannot be a height field") && shown.contains("[[static]]"), "{shown}");
}

#[test]
fn an_element_without_a_name_has_no_unknown_keys_for_that() {
    let text = OSCILLATOR.replace("name = \"middle\"\n", "");
    let shown = mistakes(&text);
    assert!(shown.contains("key `name` is missing") && !shown.contains("unknown key"), "{shown}");
}
