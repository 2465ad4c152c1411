//! Cases inside this program, so that its suites run where no sources are.

use std::fs;
use std::path::{Path, PathBuf};

use crate::exit::Error;

macro_rules! cases {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../../tests/verification/", $name)))),*]
    };
}

/// Files of `tests/verification` that the suites need: extreme settings, and the cases of the negative controls.
const FILES: &[(&str, &str)] = &cases![
    "ballistic.study.toml",
    "ballistic.toml",
    "bar-on-bar.toml",
    "bar-on-damper.toml",
    "bars-1.study.toml",
    "bars-10.study.toml",
    "bars-2.study.toml",
    "bead.ply",
    "bucket.obj",
    "budgets.study.toml",
    "catalogue.toml",
    "dam-break-front.csv",
    "dam-break-front.study.toml",
    "dam-break-front.toml",
    "draft-30.study.toml",
    "draft-50.study.toml",
    "draft-70.study.toml",
    "draft.toml",
    "elastic-column.study.toml",
    "elastic-column.toml",
    "free-flight.study.toml",
    "hanging-strip.study.toml",
    "hanging-strip.toml",
    "hertz-impact.csv",
    "hertz-impact.study.toml",
    "hertz-impact.toml",
    "impedance-1.study.toml",
    "impedance-10.study.toml",
    "impedance-2.study.toml",
    "ladder.obj",
    "ladder.study.toml",
    "ladder.toml",
    "liquid-at-rest.study.toml",
    "liquid-at-rest.toml",
    "mass-on-bar.study.toml",
    "mass-on-bar.toml",
    "negative-controls.toml",
    "oscillator.study.toml",
    "pendulum.study.toml",
    "pendulum.toml",
    "piston-heavy.study.toml",
    "piston-light.study.toml",
    "piston-map.study.toml",
    "piston.toml",
    "rolling-ball.study.toml",
    "rolling-ball.toml",
    "sheared-layer.study.toml",
    "sheared-layer.toml",
    "sliding-plate.study.toml",
    "sliding-plate.toml",
    "spinning-disc.study.toml",
    "spinning-disc.toml",
    "three-way.study.toml",
    "three-way.toml",
    "thrown-water.study.toml",
    "thrown-water.toml",
    "tumbling-top.csv",
    "tumbling-top.study.toml",
    "tumbling-top.toml",
    "turning-bead.study.toml",
    "turning-bead.toml",
    "two-material-column.study.toml",
    "two-material-column.toml",
    "vibrating-column.study.toml",
    "yielding-bar.study.toml",
    "yielding-bar.toml",
    "stability/added-mass.study.toml",
    "stability/block-and-ball.toml",
    "stability/bullet.study.toml",
    "stability/bullet.toml",
    "stability/cloth-compliance.study.toml",
    "stability/cloth-impact.study.toml",
    "stability/cloth-mass.study.toml",
    "stability/cloth-sweeps.study.toml",
    "stability/coincident-points.study.toml",
    "stability/courant.study.toml",
    "stability/creased-cloth.study.toml",
    "stability/creased.obj",
    "stability/density-ratio.study.toml",
    "stability/dust.toml",
    "stability/far-1-km.study.toml",
    "stability/far-100-km.study.toml",
    "stability/friction-3.study.toml",
    "stability/impact-100.study.toml",
    "stability/inside-out.study.toml",
    "stability/link-limits.study.toml",
    "stability/link-mass-ratio.study.toml",
    "stability/link-stiffness.study.toml",
    "stability/liquid-courant.study.toml",
    "stability/liquid-density-ratio.study.toml",
    "stability/liquid-incompressible.study.toml",
    "stability/liquid-of-points.study.toml",
    "stability/liquid-small-raft.study.toml",
    "stability/liquid-stiff.study.toml",
    "stability/liquid-viscosity.study.toml",
    "stability/mass-ratio.study.toml",
    "stability/no-gravity.study.toml",
    "stability/overlap.study.toml",
    "stability/plume.toml",
    "stability/points.study.toml",
    "stability/poisson.study.toml",
    "stability/reversal-oscillator.study.toml",
    "stability/reversal-top.study.toml",
    "stability/seed-ground.study.toml",
    "stability/sheet.toml",
    "stability/short-windows.study.toml",
    "stability/small-ball.study.toml",
    "stability/smoke-heat.study.toml",
    "stability/smoke-speed.study.toml",
    "stability/stack-mass.study.toml",
    "stability/stack-overlap.study.toml",
    "stability/stack-restitution.study.toml",
    "stability/stack.toml",
    "stability/steep-friction.study.toml",
    "stability/stiffness-ratio.study.toml",
    "stability/supersonic.study.toml",
    "stability/tank.toml",
    "stability/units-block.study.toml",
    "stability/units-plume.study.toml",
    "stability/units-shapes.study.toml",
    "stability/units-sheet.study.toml",
    "stability/units-stack.study.toml",
    "stability/units-tank.study.toml",
];

/// List of the negative controls.
pub(crate) const CONTROLS: &str = "negative-controls.toml";
/// Folder of the cases at the edge of what can be computed.
pub(crate) const STABILITY: &str = "stability";

/// Puts the cases of this program below the folder of a study.
///
/// # Errors
/// A file cannot be written.
pub(crate) fn unpack(out: &Path) -> Result<PathBuf, Error> {
    let place = out.join("cases");
    for (name, text) in FILES {
        let file = place.join(name);
        let folder = file.parent().unwrap_or(&place);
        fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, &e))?;
        fs::write(&file, text).map_err(|e| Error::io("write", &file, &e))?;
    }
    Ok(place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::control;
    use std::collections::BTreeSet;

    #[test]
    fn what_the_suites_need_is_in_the_program() {
        let place = tempfile::tempdir().unwrap();
        // Every case that a control names, with its scene.
        assert!(!control::read(&unpack(place.path()).unwrap().join(CONTROLS)).unwrap().is_empty());
        let root = Path::new(&std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests"))
            .join("../tests/verification");
        let mut there = BTreeSet::new();
        for entry in fs::read_dir(root.join(STABILITY)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|end| ["toml", "csv", "obj", "ply"].iter().any(|known| end == *known)) {
                there.insert(format!("{STABILITY}/{}", path.file_name().unwrap().to_string_lossy()));
            }
        }
        let inside = FILES.iter().map(|(name, _)| (*name).to_owned()).filter(|name| name.starts_with(STABILITY));
        assert_eq!(inside.collect::<BTreeSet<_>>(), there);
    }
}
