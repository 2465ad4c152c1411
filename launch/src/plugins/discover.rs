//! Where plugins are found: inside this program, beside it, on `PATH`, or by a command in the scene.
//!
//! Earlier places win; a name that is hidden by an earlier place is listed with the place that hides it.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use super::built_in;
use crate::exit::{Code, Error, Problem};
use crate::hint::{list, near_miss};

/// Name of a plugin's executable before the plugin's own name.
const PREFIX: &str = "cosplat-solver-";

/// Where a plugin was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// Inside this program.
    BuiltIn,
    /// An executable beside this program or on `PATH`.
    File(PathBuf),
    /// A command in the scene.
    Scene,
}

/// Something that may be a plugin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Candidate {
    /// Name by which it was found.
    pub(crate) name: String,
    /// Where.
    pub(crate) origin: Origin,
    /// Command that starts it, program first.
    pub(crate) command: Vec<OsString>,
}

impl Candidate {
    fn built_in(name: &str) -> Result<Self, Error> {
        let this = std::env::current_exe().map_err(|e| {
            Error::new(Code::Environment, Problem::new("This program cannot find its own file").because(e))
        })?;
        let command = vec![this.into_os_string(), "solver".into(), name.into()];
        Ok(Self { name: name.to_owned(), origin: Origin::BuiltIn, command })
    }

    fn file(name: String, path: PathBuf) -> Self {
        Self { name, command: vec![path.clone().into_os_string()], origin: Origin::File(path) }
    }

    /// A command of the scene. A program with a `/` in it is taken from the folder of the scene file.
    pub(crate) fn of_scene(name: &str, words: &[String], folder: &Path) -> Self {
        let mut command: Vec<OsString> = words.iter().map(OsString::from).collect();
        if let Some(program) = command.first_mut()
            && program.to_string_lossy().contains('/')
        {
            *program = folder.join(&*program).into_os_string();
        }
        Self { name: name.to_owned(), origin: Origin::Scene, command }
    }

    /// Where it was found, for people.
    pub(crate) fn place(&self) -> String {
        match &self.origin {
            Origin::BuiltIn => "built in".into(),
            Origin::File(path) => path.display().to_string(),
            Origin::Scene => {
                let words: Vec<_> = self.command.iter().map(|w| w.to_string_lossy()).collect();
                format!("command `{}`", words.join(" "))
            }
        }
    }
}

/// An executable beside this program or on `PATH`.
pub(crate) fn on_path(name: &str) -> Option<PathBuf> {
    Places::of_this_program().executable(name)
}

/// Folders in which executables are looked for, in order.
#[derive(Clone, Debug)]
pub(crate) struct Places(Vec<PathBuf>);

impl Places {
    /// The folder of this program, then `PATH`.
    pub(crate) fn of_this_program() -> Self {
        let beside = std::env::current_exe().ok().and_then(|exe| exe.parent().map(Path::to_owned));
        let path = std::env::var_os("PATH").unwrap_or_default();
        // A relative entry would make what is started depend on where the user happens to be.
        Self(beside.into_iter().chain(std::env::split_paths(&path)).filter(|p| p.is_absolute()).collect())
    }

    /// An executable of that name.
    fn executable(&self, name: &str) -> Option<PathBuf> {
        self.0.iter().map(|folder| folder.join(name)).find(|p| is_executable(p))
    }

    /// The plugin of that name.
    ///
    /// # Errors
    /// There is none.
    pub(crate) fn find(&self, name: &str) -> Result<Candidate, Error> {
        if built_in::names().any(|n| n == name) {
            return Candidate::built_in(name);
        }
        if let Some(path) = self.executable(&format!("{PREFIX}{name}")) {
            return Ok(Candidate::file(name.to_owned(), path));
        }
        let files = self.files();
        let mut names: Vec<&str> = built_in::names().collect();
        names.extend(files.keys().map(String::as_str));
        names.sort_unstable();
        names.dedup();
        let problem = Problem::new(format!("There is no solver plugin `{name}`"))
            .because(format!("there are {}", list(names.iter().copied())))
            .because(format!("an executable `{PREFIX}{name}` was looked for beside this program and on `PATH`"));
        let problem = match near_miss(name, names.iter().copied()) {
            Some(near) => problem.hint(format!("did you mean `{near}`?")),
            None => {
                problem.hint(format!("install `{PREFIX}{name}`, or name another plugin with `--solver BODY=PLUGIN`"))
            }
        };
        Err(Error::new(Code::Environment, problem))
    }

    /// Everything that can be found by name, each with what hides it.
    ///
    /// # Errors
    /// This program cannot find its own file.
    pub(crate) fn all(&self) -> Result<Vec<(Candidate, Option<String>)>, Error> {
        let mut all = Vec::new();
        for name in built_in::names() {
            all.push((Candidate::built_in(name)?, None));
        }
        for (name, paths) in self.files() {
            let mut hidden_by = built_in::names().any(|n| n == name).then(|| "the built-in plugin".to_owned());
            for path in paths {
                let shown = path.display().to_string();
                all.push((Candidate::file(name.clone(), path), hidden_by.clone()));
                hidden_by.get_or_insert(shown);
            }
        }
        Ok(all)
    }

    /// Executables by plugin name, in the order of the folders.
    fn files(&self) -> BTreeMap<String, Vec<PathBuf>> {
        let mut found: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
        for folder in &self.0 {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let file_name = entry.file_name();
                let Some(name) = file_name.to_str().and_then(|f| f.strip_prefix(PREFIX)) else { continue };
                let paths = found.entry(name.to_owned()).or_default();
                // A folder may stand in PATH twice.
                if is_executable(&entry.path()) && !paths.contains(&entry.path()) {
                    paths.push(entry.path());
                }
            }
        }
        found.retain(|_, paths| !paths.is_empty());
        found
    }
}

fn is_executable(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(names: &[(&str, u32)]) -> tempfile::TempDir {
        let place = tempfile::tempdir().unwrap();
        for (name, mode) in names {
            let path = place.path().join(name);
            fs::write(&path, "").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(*mode)).unwrap();
        }
        place
    }

    #[test]
    fn executables_are_found_by_their_prefix() {
        let place = place(&[("cosplat-solver-mud", 0o755), ("cosplat-solver-text", 0o644), ("ls", 0o755)]);
        let places = Places(vec![place.path().to_owned()]);
        assert_eq!(places.find("mud").unwrap().place(), place.path().join("cosplat-solver-mud").display().to_string());
        assert!(places.find("text").is_err());
        let names: Vec<String> = places.all().unwrap().into_iter().map(|(c, _)| c.name).collect();
        assert_eq!(
            names,
            ["mpm", "mpm-f64", "oscillator", "pbd", "rigid", "rigid-lite", "shape-matching", "smoke", "sph", "mud"]
        );
    }

    #[test]
    fn earlier_places_hide_later_ones_and_it_is_said() {
        let first = place(&[("cosplat-solver-mud", 0o755)]);
        let second = place(&[("cosplat-solver-mud", 0o755), ("cosplat-solver-oscillator", 0o755)]);
        let places = Places(vec![first.path().to_owned(), second.path().to_owned(), first.path().to_owned()]);
        let hidden: Vec<_> = places.all().unwrap().into_iter().filter_map(|(c, by)| Some((c.name, by?))).collect();
        let by_first = first.path().join("cosplat-solver-mud").display().to_string();
        assert_eq!(hidden, [("mud".to_owned(), by_first), ("oscillator".to_owned(), "the built-in plugin".to_owned())]);
        assert_eq!(places.find("oscillator").unwrap().origin, Origin::BuiltIn);
    }

    #[test]
    fn a_missing_plugin_comes_with_a_near_miss() {
        let error = Places(Vec::new()).find("rigid_lite").unwrap_err();
        assert_eq!(error.code, Code::Environment);
        assert_eq!(error.problems[0].hint.as_deref(), Some("did you mean `rigid-lite`?"));
    }

    #[test]
    fn programs_of_a_scene_lie_beside_it_unless_they_are_bare_names() {
        let words = |program: &str| vec![program.to_owned(), "x.py".to_owned()];
        let program = |w: &str| Candidate::of_scene("a", &words(w), Path::new("/scenes")).command[0].clone();
        assert_eq!(program("./solver"), "/scenes/./solver");
        assert_eq!(program("/opt/solver"), "/opt/solver");
        assert_eq!(program("python3"), "python3");
    }
}
