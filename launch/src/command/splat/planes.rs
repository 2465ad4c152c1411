//! By-products of a picture, as files.

use std::path::{Path, PathBuf};

use clap::Args;
use cosplat_viewer::{Form, Layers, Plane, StoreError};

use super::put;
use crate::exit::{Code, Error, Problem};

/// What is written beside the picture.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct PlaneArgs {
    /// Also write how much of the background is hidden, as .npy or as .png of 16 bits
    #[arg(long, value_name = "FILE", conflicts_with = "orbit")]
    pub(crate) alpha: Option<PathBuf>,
    /// Also write depths along the optical axis, as .npy in units of the file or as .png in thousandths of one
    #[arg(long, value_name = "FILE", conflicts_with = "orbit")]
    pub(crate) depth: Option<PathBuf>,
    /// Also write normals in the axes of the file, as .npy or as .png from 0 for −1 to 65535 for 1
    #[arg(long, value_name = "FILE", conflicts_with = "orbit")]
    pub(crate) normal: Option<PathBuf>,
}

/// A by-product and its file.
pub(super) struct Wanted<'a> {
    plane: Plane,
    form: Form,
    pub(super) path: &'a Path,
}

impl<'a> Wanted<'a> {
    /// A by-product in the form of the file's ending.
    ///
    /// # Errors
    /// There is no such form.
    pub(super) fn new(plane: Plane, path: &'a Path) -> Result<Self, Error> {
        let form = Form::of(path, plane).map_err(|e| refused(path, &e))?;
        Ok(Self { plane, form, path })
    }

    /// Writes the file.
    ///
    /// # Errors
    /// There is no room.
    pub(super) fn write(&self, layers: &Layers) -> Result<(), Error> {
        put(self.path, &layers.encode(self.plane, self.form).map_err(|e| refused(self.path, &e))?)
    }
}

impl PlaneArgs {
    /// All that were asked for.
    ///
    /// # Errors
    /// The ending of a file says nothing.
    pub(super) fn wanted(&self) -> Result<Vec<Wanted<'_>>, Error> {
        let all = [(Plane::Alpha, &self.alpha), (Plane::Depth, &self.depth), (Plane::Normal, &self.normal)];
        all.into_iter().filter_map(|(plane, path)| path.as_deref().map(|path| Wanted::new(plane, path))).collect()
    }
}

fn refused(path: &Path, error: &StoreError) -> Error {
    let problem = Problem::new(format!("Cannot write `{}`", path.display())).at(path).because(error);
    Error::new(Code::Usage, problem.hint("give a file name with another ending"))
}
