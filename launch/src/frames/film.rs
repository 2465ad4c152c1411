//! A film of the pictures, made by `ffmpeg` where there is one.

use std::io::{self, Read as _};
use std::path::Path;
use std::process::{Command, Stdio};

use cosplat_core::plan::LeftOut;

use crate::folder::{PICTURES, VIDEO};

/// Last bytes of what `ffmpeg` says about a failure.
const WORDS: u64 = 2000;

/// Makes a film of the pictures of a run folder, or says why there is none.
pub(super) fn film(folder: &Path, pictures_per_second: f64) -> Result<(), LeftOut> {
    let made = encode(Path::new("ffmpeg"), folder, pictures_per_second);
    made.map_err(|why| {
        // What is there of it plays nowhere; there may be nothing.
        let _ = std::fs::remove_file(folder.join(VIDEO));
        LeftOut {
            what: format!("the film `{VIDEO}`"),
            why,
            indicator: None,
            limit: None,
            saved: "not measured".to_owned(),
        }
    })
}

/// The same pictures give the same bytes for one version of `ffmpeg`: one thread, and nothing about the encoder or the
/// time in the file. H.264 in 4:2:0, which plays everywhere, takes even sides only, so the picture is padded.
fn encode(ffmpeg: &Path, folder: &Path, pictures_per_second: f64) -> Result<(), String> {
    let mut command = Command::new(ffmpeg);
    command.args(["-nostdin", "-y", "-loglevel", "error", "-framerate", &pictures_per_second.to_string(), "-i"]);
    command.arg(folder.join(format!("{PICTURES}/frame_%04d.png")));
    command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset", "medium", "-crf", "18"]);
    command.args(["-pix_fmt", "yuv420p", "-threads", "1", "-x264-params", "threads=1:lookahead-threads=1"]);
    command.args(["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart"]);
    command.arg(folder.join(VIDEO)).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let failed = |e: &io::Error| match e.kind() {
        io::ErrorKind::NotFound => "there is no `ffmpeg` on the path; `cosplat doctor` says how to get it".to_owned(),
        _ => format!("`ffmpeg` does not work: {e}"),
    };
    let mut child = command.spawn().map_err(|e| failed(&e))?;
    let mut words = String::new();
    if let Some(stderr) = &mut child.stderr {
        // What cannot be read says nothing; how it ended does.
        let _ = stderr.take(WORDS).read_to_string(&mut words);
    }
    // The rest of what it says must not keep it from ending.
    drop(child.stderr.take());
    let status = child.wait().map_err(|e| failed(&e))?;
    if status.success() { Ok(()) } else { Err(format!("`ffmpeg` ends with {status}: {}", words.trim())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn pictures(count: usize) -> tempfile::TempDir {
        let place = tempfile::tempdir().unwrap();
        fs::create_dir(place.path().join(PICTURES)).unwrap();
        for number in 0..count {
            let gaussians = cosplat_viewer::Gaussians {
                positions: &[[0.05 * number as f32, 0.0, 0.0]],
                rotations: &[[1.0, 0.0, 0.0, 0.0]],
                log_scales: &[[-2.0; 3]],
                opacity_logits: &[3.0],
                sh_dc: &[[1.0, 0.0, -1.0]],
                sh_rest: &[],
                sh_degree: 0,
                antialiased: false,
            };
            let (eye, target, up) = ([0.0, -3.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
            let camera = cosplat_viewer::Camera { eye, target, up, fov_y_deg: 40.0, width: 65, height: 49 };
            let options = cosplat_viewer::Options::default();
            let picture = cosplat_viewer::render(&[gaussians], &camera.view().unwrap(), &options);
            let name = place.path().join(format!("{PICTURES}/frame_{number:04}.png"));
            cosplat_viewer::png::write(&name, &picture).unwrap();
        }
        place
    }

    #[test]
    fn the_same_pictures_give_the_same_film() {
        let places = [pictures(4), pictures(4)];
        for place in &places {
            match film(place.path(), 24.0) {
                Ok(()) => {}
                Err(left_out) if left_out.why.contains("no `ffmpeg`") => {
                    eprintln!("skipped: {}", left_out.why);
                    return;
                }
                Err(left_out) => panic!("{}", left_out.why),
            }
        }
        let [one, two] = places.map(|place| fs::read(place.path().join(VIDEO)).unwrap());
        assert_eq!(&one[4..8], b"ftyp");
        assert!(one == two, "{} and {} bytes", one.len(), two.len());
    }

    #[test]
    fn a_film_that_cannot_be_made_is_left_out_with_the_reason() {
        let place = pictures(1);
        let why = encode(Path::new("/no/such/ffmpeg"), place.path(), 24.0).unwrap_err();
        assert!(why.contains("no `ffmpeg` on the path"), "{why}");
        let why = encode(Path::new("false"), place.path(), 24.0).unwrap_err();
        assert!(why.contains("ends with exit status: 1"), "{why}");
    }
}
