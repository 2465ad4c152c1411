//! Which run a result belongs to: the program, the scene with its changes, and the files that it names.

use std::fs::File;
use std::io::{self, BufReader, Read as _};
use std::path::{Path, PathBuf};

use cosplat_core::scene::Scene;
use serde_json::Value;
use xxhash_rust::xxh3::Xxh3;

use crate::plugins::discover::Places;
use crate::scene_source::Source;

/// Hash of this program, taken once.
///
/// # Errors
/// The program cannot read its own file.
pub(crate) fn of_this_program() -> io::Result<u128> {
    let mut hash = Xxh3::new();
    add_file(&mut hash, &std::env::current_exe()?)?;
    Ok(hash.digest128())
}

/// Hash of a run: the same hash means the same result.
pub(crate) fn of_run(program: u128, source: &Source, scene: &Scene, overrides: &[String]) -> String {
    let mut hash = begun(program, source, overrides);
    let folder = source.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    for file in named_files(scene, folder) {
        hash.update(file.as_os_str().as_encoded_bytes());
        // What cannot be read makes the run fail, and failures of this kind are not kept.
        let _ = add_file(&mut hash, &file);
    }
    format!("{:032x}", hash.digest128())
}

/// Hash of a run whose scene cannot be read, so that no files are known that it names.
pub(crate) fn of_text(program: u128, source: &Source, overrides: &[String]) -> String {
    format!("{:032x}", begun(program, source, overrides).digest128())
}

fn begun(program: u128, source: &Source, overrides: &[String]) -> Xxh3 {
    let mut hash = Xxh3::new();
    hash.update(&program.to_le_bytes());
    for text in [source.text.as_str()].into_iter().chain(overrides.iter().map(String::as_str)) {
        hash.update(&(text.len() as u64).to_le_bytes());
        hash.update(text.as_bytes());
    }
    hash
}

fn add_file(hash: &mut Xxh3, path: &Path) -> io::Result<()> {
    let mut reader = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut part = vec![0; 1 << 20];
    loop {
        match reader.read(&mut part)? {
            0 => return Ok(()),
            read => hash.update(&part[..read]),
        }
    }
}

/// Captures, meshes and foreign solvers. Those of built-in scenes are inside the program.
fn named_files(scene: &Scene, folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    collect(&serde_json::to_value(scene).unwrap_or_default(), folder, &mut files);
    let places = Places::of_this_program();
    let plugins = scene.bodies.iter().map(|b| b.solver.as_str()).map(|name| {
        let named = scene.solvers.get(name).and_then(|s| s.plugin.as_deref());
        named.unwrap_or(name)
    });
    files.extend(plugins.filter_map(|name| places.find(name).ok()?.command.first().map(PathBuf::from)));
    // Built-in solvers are this program, which is in the hash already.
    let this = std::env::current_exe().ok();
    files.retain(|file| file.is_file() && Some(file) != this.as_ref());
    files.sort_unstable();
    files.dedup();
    files
}

/// Values of all keys `file`, and words of all commands.
fn collect(value: &Value, folder: &Path, files: &mut Vec<PathBuf>) {
    match value {
        Value::Object(table) => {
            for (key, value) in table {
                match (key.as_str(), value) {
                    ("file", Value::String(name)) => files.push(folder.join(name)),
                    ("command", Value::Array(words)) => {
                        files.extend(words.iter().filter_map(Value::as_str).map(|word| folder.join(word)));
                    }
                    _ => collect(value, folder, files),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| collect(item, folder, files)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Paint;
    use crate::scene_source::parse;

    const SCENE: &str = "clock = { duration = 1.0, window = 0.1 }\nname = \"x\"\n[[body]]\nname = \"b\"\nmaterial = \"plushie\"\n\
                         spacing = 0.1\nmesh = { file = \"b.obj\", metres_per_unit = 1.0 }\n";

    #[test]
    fn whatever_changes_a_run_changes_its_hash() {
        let place = tempfile::tempdir().unwrap();
        let mesh = place.path().join("b.obj");
        std::fs::write(&mesh, "v 0 0 0\n").unwrap();
        let file = place.path().join("x.toml");
        let source = Source { shown: "x".into(), file: Some(file), text: SCENE.into() };
        let (scene, _) = parse(&source, &[], Paint::off()).unwrap();
        let hash = |program, overrides: &[String]| of_run(program, &source, &scene, overrides);
        let first = hash(1, &[]);
        assert_eq!(hash(1, &[]), first);
        assert_ne!(hash(2, &[]), first);
        assert_ne!(hash(1, &["clock.window=0.05".into()]), first);
        std::fs::write(&mesh, "v 0 0 1\n").unwrap();
        assert_ne!(hash(1, &[]), first);
    }
}
