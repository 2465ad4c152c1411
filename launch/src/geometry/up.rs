//! Which way is up in a file: what the scene states, or else what the format's convention says, and that it was taken.

use cosplat_core::scene::Source;

/// Up of a format without a convention: that of scenes.
const OF_SCENES: &str = "+z";

/// The up axis of a file as scenes name it, and a sentence about it where the scene does not state one.
pub(super) fn stated_or<'a>(stated: &'a str, convention: Option<&'a str>, format: &str) -> (&'a str, Option<String>) {
    if stated != Source::UP_OF_FORMAT {
        return (stated, None);
    }
    let (up, why) = match convention {
        Some(up) => (up, format!("the convention of {format} files")),
        None => (OF_SCENES, format!("because {format} files have no convention")),
    };
    (up, Some(format!("its up axis is taken as {up}, {why}; state `up` where it is another")))
}

/// Direction of an axis as scenes name it.
pub(crate) fn axis(name: &str) -> [f64; 3] {
    let sign = if name.starts_with('-') { -1.0 } else { 1.0 };
    match name.as_bytes().last() {
        Some(b'x') => [sign, 0.0, 0.0],
        Some(b'y') => [0.0, sign, 0.0],
        _ => [0.0, 0.0, sign],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_scene_does_not_state_is_taken_from_the_format_and_said() {
        assert_eq!(stated_or("-x", Some("+y"), "spz"), ("-x", None));
        for (convention, format, up, part) in [
            (Some("-y"), "ply", "-y", "taken as -y, the convention of ply files"),
            (Some("+y"), "glb", "+y", "taken as +y, the convention of glb files"),
            (None, "obj", "+z", "taken as +z, because obj files have no convention"),
        ] {
            let (found, sentence) = stated_or("format", convention, format);
            assert_eq!(found, up);
            assert!(sentence.is_some_and(|s| s.contains(part) && s.contains("`up`")), "{format}");
        }
    }
}
