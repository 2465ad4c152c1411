//! Frames as splat files: each whole, each packed, or the first whole and of the others what has changed.

use std::fs;
use std::path::{Path, PathBuf};

use cosplat_core::scene::SplatForm;
use cosplat_splat::format::{self, encode};
use cosplat_splat::sequence::{ENDING, First};
use cosplat_splat::{Axes, Splats};

use super::files::splats;

/// Files of one run.
pub(super) struct Sequence {
    folder: PathBuf,
    form: SplatForm,
    /// Of a compact sequence, since it was written.
    first: Option<First>,
}

impl Sequence {
    /// Below a run folder.
    pub(super) fn new(folder: &Path, form: SplatForm) -> Self {
        Self { folder: folder.to_owned(), form, first: None }
    }

    /// Writes a frame; its name below the run folder. A frame of a compact sequence that has other Gaussians than the
    /// first one, as where a liquid flows in, is written whole.
    pub(super) fn write(&mut self, number: u64, frame: &Splats) -> Result<String, String> {
        if self.form == SplatForm::Spz {
            let name = splats(number, "spz");
            format::write_file(&self.folder.join(&name), frame).map_err(|e| e.to_string())?;
            return Ok(name);
        }
        if self.form == SplatForm::Compact
            && let Some(first) = &self.first
            && let Some(bytes) = first.encode(&as_stored(frame))
        {
            let name = splats(number, ENDING);
            self.put(&name, &bytes)?;
            return Ok(name);
        }
        let name = splats(number, "ply");
        let bytes = encode(frame, Some("ply")).map_err(|e| e.to_string())?;
        self.put(&name, &bytes)?;
        if self.form == SplatForm::Compact && number == 0 {
            self.first = Some(First::new(as_stored(frame), &bytes));
        }
        Ok(name)
    }

    /// Names of the frames of earlier lives of the run; the first one is read again where later ones build on it.
    pub(super) fn take_over(&mut self, taken: u64) -> Result<Vec<String>, String> {
        if self.form == SplatForm::Compact && taken > 0 {
            let path = self.folder.join(splats(0, "ply"));
            let wrong = |e: &dyn std::fmt::Display| format!("cannot read `{}`: {e}", path.display());
            let bytes = fs::read(&path).map_err(|e| wrong(&e))?;
            let decoded = format::read(&bytes, Some("ply")).map_err(|e| wrong(&e))?;
            self.first = Some(First::new(as_stored(&decoded.splats), &bytes));
        }
        let ending = |number: u64| match self.form {
            SplatForm::Spz => "spz",
            SplatForm::Compact if self.folder.join(splats(number, ENDING)).is_file() => ENDING,
            SplatForm::Compact | SplatForm::Ply => "ply",
        };
        Ok((0..taken).map(|number| splats(number, ending(number))).collect())
    }

    fn put(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        let path = self.folder.join(name);
        fs::write(&path, bytes).map_err(|e| format!("cannot write `{}`: {e}", path.display()))
    }
}

/// With the axes that a `.ply` has.
fn as_stored(splats: &Splats) -> Splats {
    Splats { axes: Axes::Rdf, ..splats.clone().to_axes(Axes::Rdf) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(shift: f32) -> Splats {
        let n = 50;
        Splats {
            positions: (0..n).map(|i| [i as f32 + shift, 0.5, -shift]).collect(),
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
            log_scales: vec![[-4.0; 3]; n],
            opacity_logits: vec![3.0; n],
            sh_dc: vec![[0.25; 3]; n],
            axes: Axes::Rub,
            ..Splats::default()
        }
    }

    #[test]
    fn frames_come_back_in_each_form_and_a_resumed_run_goes_on_with_the_same_bytes() {
        for (form, endings) in
            [(SplatForm::Ply, ["ply"; 3]), (SplatForm::Spz, ["spz"; 3]), (SplatForm::Compact, ["ply", "cgs", "cgs"])]
        {
            let place = tempfile::tempdir().unwrap();
            fs::create_dir(place.path().join("splats")).unwrap();
            let mut sequence = Sequence::new(place.path(), form);
            let names: Vec<String> =
                (0..3_u8).map(|k| sequence.write(u64::from(k), &some(0.1 * f32::from(k))).unwrap()).collect();
            let wanted: Vec<String> = (0..3).map(|k| format!("splats/frame_000{k}.{}", endings[k])).collect();
            assert_eq!(names, wanted);
            let bytes = fs::read(place.path().join(&names[2])).unwrap();
            let mut resumed = Sequence::new(place.path(), form);
            assert_eq!(resumed.take_over(2).unwrap(), names[..2]);
            assert_eq!(resumed.write(2, &some(0.2)).unwrap(), names[2]);
            assert_eq!(fs::read(place.path().join(&names[2])).unwrap(), bytes, "{form:?}");
            if form == SplatForm::Compact {
                // Fewer Gaussians: a whole frame.
                let fewer = some(0.3).select(&[1, 2, 3]);
                assert_eq!(resumed.write(3, &fewer).unwrap(), "splats/frame_0003.ply");
                assert_eq!(resumed.take_over(4).unwrap()[3], "splats/frame_0003.ply");
                let file = fs::read(place.path().join(&names[0])).unwrap();
                let first = First::new(format::read(&file, Some("ply")).unwrap().splats, &file);
                assert_eq!(first.decode(&bytes).unwrap().positions, as_stored(&some(0.2)).positions);
            }
        }
    }
}
