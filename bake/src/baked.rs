//! Results of baking: their files and their report.

use crate::images::Map;
use crate::{BakeError, Subdivision};
use pictures::{ImageFileError, Output};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The result of baking.
#[derive(Clone, Debug, Default)]
pub struct Baked {
    /// The binary glTF file.
    pub glb: Vec<u8>,
    /// Maps of irradiance, page by page: of all lights with [`Form::Lightmap`](crate::Form::Lightmap), and of each light if these are requested.
    pub maps: Vec<Map>,
    /// Width and height of each page.
    pub pages: Vec<[u32; 2]>,
    /// Texels that lie on a surface.
    pub texels: u64,
    /// Vertices that have light.
    pub vertices: u64,
    /// Surfaces that light is baked to.
    pub surfaces: usize,
    /// The number by which colours of vertices are darker than the light, 1 or more.
    pub scale: f32,
    /// Of triangles that were divided: how near their light is.
    pub subdivision: Option<Subdivision>,
}

impl Baked {
    /// The files of all maps, each with the end of its name, as of [`beside`]: OpenEXR, and PNG as well for those of all lights.
    ///
    /// # Errors
    /// [`BakeError::Image`].
    pub fn map_files(&self) -> Result<Vec<(String, Vec<u8>)>, BakeError> {
        let mut all = Vec::new();
        for map in &self.maps {
            all.push((format!("{}.exr", map.name), map.exr()?));
            if !map.is_single {
                all.push((format!("{}.png", map.name), map.linear_png()?));
            }
        }
        Ok(all)
    }

    /// Writes [files of maps](Self::map_files) beside `output`, then the binary glTF file as `file`. Returns the paths of the maps. All of the
    /// maps can be written, or none is.
    ///
    /// # Errors
    /// [`ImageFileError`].
    pub fn write(
        &self,
        file: Output,
        output: &Path,
        maps: &[(String, Vec<u8>)],
    ) -> Result<Vec<PathBuf>, ImageFileError> {
        let paths: Vec<PathBuf> = maps.iter().map(|(ending, _)| beside(output, ending)).collect();
        let opened = paths.iter().map(Output::create).collect::<Result<Vec<_>, _>>()?;
        for (map, (_, bytes)) in opened.into_iter().zip(maps) {
            map.write(bytes)?;
        }
        file.write(&self.glb)?;
        Ok(paths)
    }

    /// The report of a bake whose maps have these paths: the object that `lobes bake --json` prints and that Python returns.
    #[must_use]
    pub fn report(&self, files: &[PathBuf]) -> Value {
        let map = |map: &Map| json!({"name": map.name, "white": map.white, "cut_texels": map.cut_texels()});
        json!({
            "surfaces": self.surfaces,
            "pages": self.pages,
            "texels": self.texels,
            "vertices": self.vertices,
            "maps": self.maps.iter().map(map).collect::<Vec<_>>(),
            "files": files,
            "bytes": self.glb.len(),
            "scale": self.scale,
            "subdivision": self.subdivision.map(|made| json!({
                "triangles": made.triangles,
                "mean_error": made.mean_error,
                "beyond": made.beyond,
                "is_cut": made.is_cut,
            })),
        })
    }
}

/// The name of a file beside the baked one.
///
/// ```
/// let map = bake::beside("rooms/baked.glb".as_ref(), "lightmap0.exr");
/// assert_eq!(map, std::path::Path::new("rooms/baked.lightmap0.exr"));
/// ```
#[must_use]
pub fn beside(baked: &Path, ending: &str) -> PathBuf {
    let mut name = baked.file_stem().unwrap_or_default().to_owned();
    name.push(format!(".{ending}"));
    baked.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Maps stand beside the file, which is written last; where a map cannot be written, none is.
    #[test]
    fn maps_are_written_beside_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("room.glb");
        let baked = Baked { glb: b"glb".to_vec(), ..Baked::default() };
        let maps = [("a.exr".to_owned(), b"one".to_vec()), ("b.exr".to_owned(), b"two".to_vec())];
        let write = || baked.write(Output::create(&path).expect("a file"), &path, &maps);
        let written = write().expect("paths");
        assert_eq!(written, ["room.a.exr", "room.b.exr"].map(|name| folder.path().join(name)));
        let bytes = |path: &Path| std::fs::read(path).expect("bytes");
        assert_eq!([&written[0], &written[1], &path].map(|path| bytes(path)), [&b"one"[..], b"two", b"glb"]);

        [&written[0], &written[1], &path].iter().for_each(|path| std::fs::remove_file(path).expect("a file"));
        std::fs::create_dir(&written[1]).expect("a folder");
        assert!(write().is_err());
        assert!(!written[0].exists() && !path.exists());
    }

    #[test]
    fn reports_have_all_figures() {
        let values = vec![Vec3::ONE, Vec3::splat(3.0)];
        let map = Map { white: 2.0, ..Map::whole("lightmap0".to_owned(), [2, 1], values) };
        let subdivision = Subdivision { triangles: 8, mean_error: 0.25, beyond: 0.5, is_cut: true };
        let baked = Baked {
            glb: vec![0; 5],
            maps: vec![map],
            pages: vec![[2, 1]],
            texels: 2,
            vertices: 3,
            surfaces: 4,
            scale: 1.5,
            subdivision: Some(subdivision),
        };
        let expected = json!({
            "surfaces": 4, "pages": [[2, 1]], "texels": 2, "vertices": 3, "bytes": 5, "scale": 1.5,
            "maps": [{"name": "lightmap0", "white": 2.0, "cut_texels": 1}],
            "files": ["room.lightmap0.exr"],
            "subdivision": {"triangles": 8, "mean_error": 0.25, "beyond": 0.5, "is_cut": true},
        });
        assert_eq!(baked.report(&["room.lightmap0.exr".into()]), expected);
        assert_eq!(Baked { subdivision: None, ..baked }.report(&[])["subdivision"], Value::Null);
    }
}
