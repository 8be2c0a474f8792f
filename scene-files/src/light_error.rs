//! Faults of lights that a scene file is not refused for, but what is made of it.

use crate::files::{Source as Files, extension};
use crate::toml_reader::{Source, Table};
use scene::SceneError;
use std::path::Path;
use toml::de::DeTable;

/// The kinds of lights that are spheres.
const SPHERES: [&str; 4] = ["sphere", "point", "spot", "spheres"];

/// An error about the first light of a file that is no sphere: with its line where the file is a scene file that has it in a `[[lights]]`,
/// else with the file alone.
///
/// ```no_run
/// let error = scene_files::other_light_error("room.toml", "this method is for sphere lights");
/// println!("{error}"); // room.toml:12:8: kind: this method is for sphere lights
/// ```
pub fn other_light_error(path: impl AsRef<Path>, message: &str) -> SceneError {
    let path = path.as_ref();
    at_its_line(path, message).unwrap_or_else(|| SceneError::file(path, message))
}

fn at_its_line(path: &Path, message: &str) -> Option<SceneError> {
    if extension(path) != "toml" {
        return None;
    }
    let text = Files::default().read_text(path).ok()?;
    let root = DeTable::parse(&text).ok()?;
    let mut root = Table::new(Source { path, text: &text }, 0, "scene", root.get_ref());
    let lights = root.get("lights")?.elements("[[lights]]").ok()?;
    let mut kinds = lights.into_iter().filter_map(|light| light.table().ok()?.get("kind"));
    let other = kinds.find(|kind| kind.string().is_ok_and(|kind| !SPHERES.contains(&kind)))?;
    Some(other.error(message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_that_of_the_light() {
        let folder = tempfile::tempdir().expect("a folder");
        let told = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).expect("room");
            let error = other_light_error(&path, "no sphere").to_string();
            error.strip_prefix(&path.display().to_string()).map(ToOwned::to_owned)
        };
        let lamp = "[[lights]]\nkind = \"spot\"\n[[lights]]\nkind = \"tube\"\n[[lights]]\nkind = \"sun\"\n";
        assert_eq!(told("a.toml", lamp).as_deref(), Some(":4:8: kind: no sphere"));
        // The light is an object's.
        assert_eq!(told("b.toml", "[[lights]]\nkind = \"point\"\n").as_deref(), Some(": no sphere"));
        assert_eq!(told("c.gltf", "{}").as_deref(), Some(": no sphere"));
    }
}
