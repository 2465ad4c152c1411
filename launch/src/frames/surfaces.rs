//! Surfaces of liquids as meshes: one file a frame and body, in the world \[m\].

use std::path::PathBuf;

use cosplat_core::plan::LeftOut;
use cosplat_core::scene::{Material, MeshForm, Scene};
use cosplat_core::visual::{VisualFrame, VisualState};
use cosplat_mesh::encode;
use cosplat_splat::liquid_surface;

use crate::folder::SURFACES;

/// A liquid by the name of its body, and the spacing of its particles \[m\].
pub(crate) type Liquid = (String, f64);

/// The liquids of a scene.
pub(crate) fn liquids(scene: &Scene) -> Vec<Liquid> {
    let is_liquid = |material: &Material| matches!(material, Material::SphLiquid { .. } | Material::MpmLiquid { .. });
    let bodies = scene.bodies.iter().filter(|body| is_liquid(&body.material));
    bodies.filter_map(|body| Some((body.name.clone(), body.spacing_m?))).collect()
}

/// Files of one run.
pub(super) struct Surfaces {
    folder: PathBuf,
    ending: &'static str,
    liquids: Vec<Liquid>,
}

impl Surfaces {
    /// Below a run folder.
    pub(super) fn new(folder: PathBuf, form: MeshForm, liquids: Vec<Liquid>) -> Self {
        let ending = match form {
            MeshForm::Obj => "obj",
            MeshForm::Ply => "ply",
        };
        Self { folder, ending, liquids }
    }

    /// Writes the surface of each liquid at a frame; the names of the files below the run folder.
    ///
    /// # Errors
    /// In words, which file cannot be written.
    pub(super) fn write(&self, frame: &VisualFrame) -> Result<Vec<String>, String> {
        let mut names = Vec::new();
        for (body, spacing_m) in &self.liquids {
            let state = frame.bodies.iter().find(|(name, _)| name == body);
            let Some((_, VisualState::Particles { position, .. })) = state else { continue };
            let name = self.name(body, frame.number);
            let path = self.folder.join(&name);
            let bytes = encode(&liquid_surface(position, *spacing_m), Some(self.ending)).map_err(|e| e.to_string())?;
            std::fs::write(&path, bytes).map_err(|e| format!("cannot write `{}`: {e}", path.display()))?;
            names.push(name);
        }
        Ok(names)
    }

    /// Names of the files of earlier lives of the run.
    pub(super) fn of_earlier(&self, taken: u64) -> Vec<String> {
        let of = |number: u64| self.liquids.iter().map(move |(body, _)| self.name(body, number));
        (0..taken).flat_map(of).filter(|name| self.folder.join(name).is_file()).collect()
    }

    /// What cannot be made of a scene without a liquid.
    pub(super) fn left_out(&self) -> Option<LeftOut> {
        self.liquids.is_empty().then(|| LeftOut {
            what: "surfaces of liquids".to_owned(),
            why: "`output.surfaces` asks for them, and no body with a spacing is a liquid".to_owned(),
            indicator: None,
            limit: None,
            saved: "nothing".to_owned(),
        })
    }

    fn name(&self, body: &str, number: u64) -> String {
        format!("{SURFACES}/{body}_{number:04}.{}", self.ending)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Paint;
    use crate::scene_source::{load, parse};

    #[test]
    fn liquids_are_written_and_nothing_else_is() {
        let (scene, _) = parse(&load("mudslide").unwrap(), &[], Paint::off()).unwrap();
        let known = liquids(&scene);
        assert_eq!(known, [("mud".to_owned(), 0.0523)]);
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join(SURFACES)).unwrap();
        let surfaces = Surfaces::new(place.path().to_owned(), MeshForm::Obj, known);
        let state = |position: Vec<[f64; 3]>| VisualState::Particles { position, gradient: Vec::new() };
        let bodies = vec![("mud".to_owned(), state(vec![[0.0; 3]])), ("car".to_owned(), state(vec![[1.0; 3]]))];
        let frame = VisualFrame { number: 3, time_s: 0.125, bodies };
        assert_eq!(surfaces.write(&frame).unwrap(), ["surfaces/mud_0003.obj"]);
        let text = std::fs::read_to_string(place.path().join("surfaces/mud_0003.obj")).unwrap();
        assert!(text.lines().filter(|line| line.starts_with("f ")).count() > 20, "{text}");
        assert_eq!(surfaces.of_earlier(5), ["surfaces/mud_0003.obj"]);
        assert!(surfaces.left_out().is_none());
        assert!(Surfaces::new(place.path().to_owned(), MeshForm::Ply, Vec::new()).left_out().is_some());
    }
}
