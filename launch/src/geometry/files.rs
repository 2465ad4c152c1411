//! Files that a scene names: beside its own file; for built-in scenes inside this program, or those that `--set` names.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use crate::scene_source::Source;

/// Assets inside this program, by the name that built-in scenes use.
const BUILT_IN: &[(&str, &[u8])] = &[
    ("assets/plant.v4.spz", include_bytes!("../../scenes/assets/plant.v4.spz")),
    ("assets/chrono_rock1.obj", include_bytes!("../../scenes/assets/chrono_rock1.obj")),
    ("assets/brown-rock.obj", include_bytes!("../../scenes/assets/brown-rock.obj")),
    ("assets/can.obj", include_bytes!("../../scenes/assets/can.obj")),
    ("assets/car.obj", include_bytes!("../../scenes/assets/car.obj")),
    ("assets/duck.obj", include_bytes!("../../scenes/assets/duck.obj")),
    ("assets/gray-rock.obj", include_bytes!("../../scenes/assets/gray-rock.obj")),
    ("assets/gully.obj", include_bytes!("../../scenes/assets/gully.obj")),
    ("assets/log.obj", include_bytes!("../../scenes/assets/log.obj")),
    ("assets/lunch-bag.obj", include_bytes!("../../scenes/assets/lunch-bag.obj")),
    ("assets/plushie.obj", include_bytes!("../../scenes/assets/plushie.obj")),
    ("assets/sand-castle.obj", include_bytes!("../../scenes/assets/sand-castle.obj")),
];

/// Largest file that is read: larger captures do not fit into memory with what is made of them.
const LARGEST_BYTES: u64 = 4 << 30;

/// Content of a file that a scene names, and where it was found.
pub(super) fn read(scene: &Source, name: &str) -> Result<(Cow<'static, [u8]>, PathBuf), String> {
    let (path, origin) = if let Some(file) = &scene.file {
        (file.parent().unwrap_or(Path::new("")).join(name), "paths are relative to the scene's file")
    } else if let Some((_, bytes)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
        return Ok((Cow::Borrowed(*bytes), PathBuf::from(name)));
    } else {
        (PathBuf::from(name), "it is not inside this program, and paths given by `--set` are relative to this folder")
    };
    let shown = path.display();
    let about = fs::metadata(&path).map_err(|e| format!("cannot read `{shown}`: {e}; {origin}"))?;
    if !about.is_file() || about.len() > LARGEST_BYTES {
        let bytes = about.len();
        return Err(format!("cannot read `{shown}`: it is no file of at most {LARGEST_BYTES} bytes, but has {bytes}"));
    }
    let bytes = fs::read(&path).map_err(|e| format!("cannot read `{shown}`: {e}"))?;
    Ok((Cow::Owned(bytes), path))
}
