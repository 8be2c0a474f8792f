//! The memory that files may take, and images that are in memory already.

use scene::{Encoding, Mesh, Texture};
use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes of meshes and images that any scene may take, and how many more for each byte of its files: no small file takes 2 GB, or a
/// minute.
const FREE: u64 = 1_700_000_000;
const A_BYTE: u64 = 128;

/// Bytes of a triangle and of a vertex while a picture is made: hierarchies and silhouettes included, as measured on scenes of many
/// triangles and few vertices.
const TRIANGLE: u64 = 540;
const VERTEX: u64 = 60;
/// Bytes of a place of a shared mesh: its matrices and its parts of hierarchies.
const PLACE: u64 = 600;

/// How many lights by emission times triangles any scene may have, and how many more for each byte of its files: each light is searched for blockers.
const SEARCHED: u64 = 20_000_000;
const SEARCHED_A_BYTE: u64 = 20;

/// The halves of a hash, the number of bytes, and how they are decoded.
type Key = (u64, u64, usize, bool);

#[derive(Default)]
struct State {
    files: HashSet<PathBuf>,
    read: u64,
    used: u64,
    textures: HashMap<Key, Texture>,
}

/// The memory that one reading of files has taken, and may take.
#[derive(Default)]
pub(crate) struct Budget(Mutex<State>);

impl Budget {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A file was read, which counts once.
    pub(crate) fn has_read(&self, file: &Path, bytes: usize) {
        let mut state = self.state();
        if state.files.insert(file.to_owned()) {
            state.read += bytes as u64;
        }
    }

    /// Bytes that are left.
    fn left(state: &State) -> u64 {
        (FREE + A_BYTE * state.read).saturating_sub(state.used)
    }

    /// Takes bytes that stay, where there is room for these and for others that are needed meanwhile.
    ///
    /// # Errors
    /// A line where they do not fit.
    pub(crate) fn take(&self, bytes: u64, meanwhile: u64, what: &str) -> Result<(), String> {
        let mut state = self.state();
        let left = Self::left(&state);
        if bytes.saturating_add(meanwhile) > left {
            let wanted = (state.used.saturating_add(bytes).saturating_add(meanwhile)) as f64 / 1e9;
            let most = (state.used + left) as f64 / 1e9;
            return Err(format!(
                "{what}: the scene would take {wanted:.1} GB of memory: at most {most:.1} GB are taken for files of this size"
            ));
        }
        state.used += bytes;
        Ok(())
    }

    /// Takes the bytes of so many copies of a mesh.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    pub(crate) fn take_mesh(&self, mesh: &Mesh, copies: usize, name: &str) -> Result<(), String> {
        let (triangles, vertices) = (mesh.triangles.len() as u64, mesh.positions.len() as u64);
        let all = (copies as u64).saturating_mul(TRIANGLE * triangles + VERTEX * vertices);
        self.take(all, 0, &format!("\"{name}\" of {} triangles", (copies as u64).saturating_mul(triangles)))
    }

    /// Takes the bytes of places of a shared mesh.
    ///
    /// # Errors
    /// As [`take`](Self::take).
    pub(crate) fn take_places(&self, count: usize, name: &str) -> Result<(), String> {
        self.take(PLACE.saturating_mul(count as u64), 0, name)
    }

    /// How many more triangles a surface may become: a quarter of those that there is room for.
    pub(crate) fn triangles(&self) -> usize {
        (Self::left(&self.state()) / (4 * TRIANGLE)) as usize
    }

    /// The most lights by emission of a scene with a number of triangles.
    pub(crate) fn lights(&self, triangles: usize) -> usize {
        let all = SEARCHED + SEARCHED_A_BYTE * self.state().read;
        (all / triangles.max(1) as u64) as usize
    }

    /// Takes the bytes of what a surface has become, which [`triangles`](Self::triangles) has bounded.
    pub(crate) fn grow(&self, mesh: &Mesh, before: usize) {
        self.state().used += TRIANGLE * mesh.triangles.len().saturating_sub(before) as u64;
    }

    /// The bytes that are taken, to which [`back_to`](Self::back_to) goes.
    pub(crate) fn mark(&self) -> u64 {
        self.state().used
    }

    /// Gives back all that was taken since but images, as the same files are read again.
    pub(crate) fn back_to(&self, used: u64) {
        let mut state = self.state();
        let images: u64 = state.textures.values().map(|texture| texture.bytes() as u64).sum();
        state.used = used.max(images);
    }

    /// The image of these bytes, decoded once.
    ///
    /// # Errors
    /// Those of `decode`.
    pub(crate) fn texture(
        &self,
        name: &str,
        bytes: &[u8],
        encoding: Encoding,
        decode: impl FnOnce() -> Result<Texture, String>,
    ) -> Result<Texture, String> {
        let half = |salt: u8| {
            let mut hasher = DefaultHasher::new();
            (salt, bytes).hash(&mut hasher);
            hasher.finish()
        };
        let key = (half(0), half(1), bytes.len(), encoding == Encoding::Srgb);
        if let Some(known) = self.state().textures.get(&key) {
            return Ok(known.named(name));
        }
        let texture = decode()?;
        self.state().textures.insert(key, texture.clone());
        Ok(texture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_files_take_little_and_large_ones_more() {
        let budget = Budget::default();
        assert!(budget.take(FREE, 0, "a").is_ok());
        let refused = budget.take(1, 0, "b").expect_err("is full");
        assert!(refused.contains("b: the scene would take 1.7 GB"), "{refused}");
        let mark = budget.mark();
        budget.has_read(Path::new("a"), 1000);
        budget.has_read(Path::new("a"), 1000);
        assert!(budget.take(A_BYTE * 999, A_BYTE, "c").is_ok());
        assert!(budget.take(A_BYTE, 1, "d").is_err());
        budget.back_to(mark);
        assert!(budget.take(A_BYTE * 1000, 0, "e").is_ok() && budget.take(1, 0, "e").is_err());
        assert!(
            Budget::default()
                .take_mesh(&Mesh::quad(glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y), 1 << 22, "f")
                .is_err()
        );
    }

    #[test]
    fn equal_images_are_decoded_once() {
        let budget = Budget::default();
        let make = || Ok(Texture::new("one", [1, 1], vec![[9, 9, 9, 255]], Encoding::Srgb));
        let one = budget.texture("one", b"bytes", Encoding::Srgb, make).expect("an image");
        let two = budget.texture("two", b"bytes", Encoding::Srgb, || Err("again".to_owned())).expect("the same");
        assert!(one.is_same(&two) && two.name() == "two");
        assert!(budget.texture("two", b"bytes", Encoding::Linear, || Err("other".to_owned())).is_err());
    }
}
