//! Frames of a compact sequence: a later one is read with the first one, which lies beside it.

use std::path::Path;

use cosplat_splat::format::{self, Decoded};
use cosplat_splat::sequence::First;

use super::refused;
use crate::exit::{Code, Error, Problem};

/// Name of the file of the first frame.
const FIRST: &str = "frame_0000.ply";

/// What to call the format.
pub(super) const NAME: &str = "cgs";

/// Decodes a later frame with the first one beside it.
///
/// # Errors
/// There is no first frame beside it, or one of both is damaged, or they do not belong together.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<Decoded, Error> {
    let beside = path.with_file_name(FIRST);
    let file = std::fs::read(&beside).map_err(|e| {
        let problem = Problem::new(format!("Cannot read `{}`", beside.display())).at(&beside).because(e);
        let hint = format!("`{}` says what changed since the first frame: keep both in one folder", path.display());
        Error::new(Code::Scene, problem.hint(hint))
    })?;
    let Decoded { splats, notes } = format::read(&file, Some("ply")).map_err(|e| refused(&beside, e))?;
    let splats = First::new(splats, &file).decode(bytes).map_err(|e| refused(path, e))?;
    Ok(Decoded { splats, notes })
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;
    use cosplat_splat::Splats;
    use cosplat_splat::format::encode;

    #[test]
    fn a_later_frame_is_read_with_the_first_one_beside_it() {
        let place = tempfile::tempdir().unwrap();
        let [path, beside] = ["frame_0007.cgs", FIRST].map(|name| place.path().join(name));
        let n = 20;
        let splats = Splats {
            positions: (0..n).map(|i| [i as f32, 0.0, 1.0]).collect(),
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
            log_scales: vec![[-4.0; 3]; n],
            opacity_logits: vec![3.0; n],
            sh_dc: vec![[0.0; 3]; n],
            ..Splats::default()
        };
        let file = encode(&splats, Some("ply")).unwrap();
        let mut now = splats.clone();
        now.positions[3] = [0.5, 0.25, -1.0];
        std::fs::write(&path, First::new(splats, &file).encode(&now).unwrap()).unwrap();
        let lonely = read(&path).map(|_| ()).unwrap_err();
        assert!(lonely.problems[0].hint.as_deref().is_some_and(|h| h.contains("one folder")));
        std::fs::write(&beside, &file).unwrap();
        let found = read(&path).unwrap();
        assert_eq!((found.format, found.decoded.splats.positions), (NAME, now.positions.clone()));
        std::fs::write(&beside, encode(&now, Some("ply")).unwrap()).unwrap();
        assert_eq!(read(&path).map(|_| ()).unwrap_err().code, Code::Scene, "of another sequence");
    }
}
