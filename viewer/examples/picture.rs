//! Draws a splat file: `cargo run --release --example picture -- FILE OUT.png EYE TARGET UP FOV WIDTH HEIGHT`, points
//! as `x,y,z` in the axes of the file. Prints how long it took.

use std::path::Path;
use std::time::Instant;

use cosplat_splat::format::read_file;
use cosplat_viewer::{Camera, Gaussians, Options, png, render};

fn point(text: &str) -> Result<[f64; 3], Box<dyn std::error::Error>> {
    let values: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    values.try_into().map_err(|_| format!("`{text}` is not x,y,z").into())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, out, eye, target, up, fov, width, height] = &arguments[..] else {
        return Err("needs FILE OUT.png EYE TARGET UP FOV WIDTH HEIGHT".into());
    };
    let start = Instant::now();
    let decoded = read_file(Path::new(file))?;
    println!("{} Gaussians decoded in {:.1} ms", decoded.splats.len(), start.elapsed().as_secs_f64() * 1e3);
    for note in &decoded.notes {
        println!("note: {note}");
    }
    let s = &decoded.splats;
    let gaussians = Gaussians {
        positions: &s.positions,
        rotations: &s.rotations,
        log_scales: &s.log_scales,
        opacity_logits: &s.opacity_logits,
        sh_dc: &s.sh_dc,
        sh_rest: &s.sh_rest,
        sh_degree: s.sh_degree,
        antialiased: s.antialiased,
    };
    gaussians.check()?;
    let (eye, target, up) = (point(eye)?, point(target)?, point(up)?);
    let camera = Camera { eye, target, up, fov_y_deg: fov.parse()?, width: width.parse()?, height: height.parse()? };
    let view = camera.view()?;
    let mut times: Vec<f64> = Vec::new();
    let mut picture = None;
    for _ in 0..5 {
        let start = Instant::now();
        picture = Some(render(&[gaussians], &view, &Options::default()));
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    println!("drawn in {:.1} ms (best of 5), {:.1} ms (median)", times[0], times[2]);
    if let Some(picture) = picture {
        png::write(Path::new(out), &picture)?;
    }
    Ok(())
}
