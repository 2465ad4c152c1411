//! Are Gaussians drawn that follow the vertices and triangles of meshes, and does a compact sequence give them back?

mod support;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use support::Program;

/// A sheet of n × n vertices in z = 0, 0.2 m wide, red on one side and blue on the other, as `.obj` with colours.
fn sheet(n: usize) -> String {
    let mut out = String::new();
    for i in 0..n * n {
        let [x, y] = [i % n, i / n].map(|k| 0.2 * k as f64 / (n - 1) as f64 - 0.1);
        let red = (i % n) as f64 / (n - 1) as f64;
        let _ = writeln!(out, "v {x} {y} 0 {red} 0 {}", 1.0 - red);
    }
    for j in 1..n {
        for i in 1..n {
            let [a, b] = [(j - 1) * n + i, j * n + i];
            let _ = writeln!(out, "f {a} {} {}\nf {a} {} {b}", a + 1, b + 1, b + 1);
        }
    }
    out
}

/// Five Gaussians on that sheet, as `.ply` in its frame.
fn worn() -> String {
    let names = "x y z opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 f_dc_0 f_dc_1 f_dc_2";
    let mut out = "ply\nformat ascii 1.0\nelement vertex 5\n".to_owned();
    for name in names.split(' ') {
        let _ = writeln!(out, "property float {name}");
    }
    out += "end_header\n";
    for i in 0..5 {
        let _ = writeln!(out, "{} 0.03 0.001 4 -5 -5 -7 1 0 0 0 1 0 0", 0.04 * f64::from(i) - 0.08);
    }
    out
}

fn scene(sheet: &Path, worn: &Path) -> String {
    let assets = Path::new(&std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests")).join("scenes/assets");
    format!(
        r#"
format = 1
name = "bindings"
clock = {{ duration = 0.1, window = 0.002, fps = 20 }}
output = {{ splats = "compact", pictures = false, recording = false, report = false }}

[[body]]
name = "duck"
material = {{ kind = "elastic", density = 600, youngs_modulus = 1e5, poissons_ratio = 0.3 }}
mesh = {{ file = "{duck}", up = "+z" }}
spacing = 0.02
angular_velocity = [0, 0, 5]
binding = "vertices"
color = [0.8, 0.55, 0.05]

[[body]]
name = "rock"
solver = "rigid"
material = "rigid"
mesh = {{ file = "{rock}", metres_per_unit = 0.06, up = "+z" }}
mass = 4
position = [1, 0, 0]
binding = {{ kind = "triangles" }}

[[body]]
name = "cloth"
material = "silk"
mesh = {{ file = "{sheet}", up = "+z" }}
position = [-1, 0, 0]
binding = "vertices"

[[body]]
name = "shirt"
material = "silk"
mesh = {{ file = "{sheet}", up = "+z" }}
position = [-2, 0, 0]
binding = {{ kind = "triangles", splat = "{worn}" }}

[[action]]
kind = "gravity"
acceleration = [0, 0, -9.81]
"#,
        duck = assets.join("duck.obj").display(),
        rock = assets.join("chrono_rock1.obj").display(),
        sheet = sheet.display(),
        worn = worn.display()
    )
}

/// Vertices of a mesh as its file lists them.
fn vertices(name: &str) -> usize {
    let path =
        Path::new(&std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests")).join("scenes/assets").join(name);
    let text = std::fs::read_to_string(path).expect("it is shipped");
    text.lines().filter(|line| line.starts_with("v ")).count()
}

fn info(file: &Path) -> Value {
    let output =
        Command::new(env!("CARGO_BIN_EXE_cosplat")).args(["splat", "info", "--format", "json"]).arg(file).output();
    let output = output.expect("cosplat starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn meshes_are_drawn_by_their_vertices_and_triangles_and_written_compactly() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let file = place.path().join("sheet.obj");
    std::fs::write(&file, sheet(11)).expect("a file");
    let capture = place.path().join("worn.ply");
    std::fs::write(&capture, worn()).expect("a file");
    let run = Program::run(&scene(&file, &capture), &["--quiet"]).finish().expect_code(0);
    let splats = run.folder.join("splats");
    let mut names: Vec<String> = std::fs::read_dir(&splats)
        .expect("splats are written")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["frame_0000.ply", "frame_0001.cgs", "frame_0002.cgs"]);
    let [first, last] = ["frame_0000.ply", "frame_0002.cgs"].map(|name| info(&splats.join(name)));
    // One a vertex of the duck, none of which are welded, and of the cloth; the shirt has five, the rock about 6000.
    let count = first["gaussians"].as_u64().expect("a number") as usize;
    let rock = count - vertices("duck.obj") - 121 - 5;
    assert!((4000..9000).contains(&rock), "{rock}");
    assert_eq!(last["gaussians"].as_u64(), first["gaussians"].as_u64());
    let whole = place.path().join("last.ply");
    let mut convert = Command::new(env!("CARGO_BIN_EXE_cosplat"));
    convert.args(["splat", "convert"]).arg(splats.join("frame_0002.cgs")).arg(&whole);
    assert!(convert.output().expect("cosplat starts").status.success());
    let [packed, full] =
        [splats.join("frame_0002.cgs"), whole].map(|p| std::fs::metadata(p).expect("it is there").len());
    println!("{count} Gaussians that all move: {packed} bytes of {full}");
    assert!(packed < full / 2);
    // Everything falls freely for 0.1 s: by g t² / 2 = 49 mm, to the first order of the solvers' steps.
    let lowest = |info: &Value| info["extent"]["low"][2].as_f64().expect("a number");
    let fallen = lowest(&first) - lowest(&last);
    assert!((fallen - 0.049).abs() < 0.003, "{fallen}");
}
