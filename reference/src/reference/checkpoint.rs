//! Interrupted references on disk.

use super::{Geometry, REPLICATES, Reference, ReferenceJob, Tally};
use crate::sobol::mix;
use core::fmt::Debug;
use glam::Vec3;
use lobe_core::Sphere;
use scene::{BlockerSet, Mesh, Proxy, Shape};
use std::io::{self, Read, Write};

const MAGIC: [u8; 8] = *b"lobesref";
const VERSION: u32 = 2;

/// Why a checkpoint could not be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// It could not be read.
    #[error("{0}")]
    Io(#[source] io::Error),
    /// It is no checkpoint, or one of another version.
    #[error("not a checkpoint of this version")]
    Format,
    /// It is cut short, or other bytes are in it than were written.
    #[error("the checkpoint is damaged")]
    Damaged,
    /// It belongs to another scene, size, seed or geometry.
    #[error("the checkpoint belongs to another scene, size, seed or geometry")]
    OtherJob,
}

impl From<io::Error> for CheckpointError {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::Damaged } else { Self::Io(error) }
    }
}

impl ReferenceJob<'_> {
    /// Identifies the job: equal for equal points, materials, lights, geometry and seed.
    fn fingerprint(&self) -> u64 {
        let kind = match self.geometry {
            Geometry::Spheres => 0,
            Geometry::Mesh => 1,
            Geometry::None => 2,
            Geometry::Mixed(_) => 3,
        };
        let mut hash = Fingerprint(mix(self.seed, kind));
        let scene = self.world.scene();
        hash.words([self.gbuffer.width, self.gbuffer.height, self.gbuffer.samples]);
        let points = &self.gbuffer.points;
        for (r, material) in points.receivers.iter().zip(&points.materials) {
            hash.numbers([r.position, r.normal, r.view].into_iter().flat_map(|v| v.to_array()));
            hash.words([r.object, *material]);
        }
        scene.lights.iter().for_each(|light| hash.text(light));
        if let Some(environment) = &scene.environment {
            hash.text(environment.map());
        }
        hash.text(&scene.materials);
        if !scene.surfaces.is_empty() {
            hash.text(&scene.surfaces);
        }
        if let Geometry::Mixed(objects) = self.geometry {
            hash.words(objects.iter().map(|solid| u32::from(*solid)));
        }
        if self.geometry.has_spheres() {
            hash.blockers(self.blockers);
        }
        if matches!(self.geometry, Geometry::Mesh | Geometry::Mixed(_)) {
            for object in &scene.objects {
                hash.words([object.visible, object.proxy != Proxy::None].map(u32::from));
                hash.shape(&object.shape);
            }
        }
        hash.0
    }
}

/// A hash of all that was put into it, in this order.
struct Fingerprint(u64);

impl Fingerprint {
    fn words(&mut self, words: impl IntoIterator<Item = u32>) {
        words.into_iter().for_each(|word| self.0 = mix(self.0, u64::from(word)));
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = f32>) {
        self.words(numbers.into_iter().map(f32::to_bits));
    }

    /// All that a value's `Debug` tells.
    fn text(&mut self, value: &impl Debug) {
        self.words(format!("{value:?}").bytes().map(u32::from));
    }

    fn blockers(&mut self, blockers: &BlockerSet) {
        for (s, object) in blockers.spheres.iter().zip(&blockers.objects) {
            self.sphere(s);
            self.words([*object]);
        }
        self.numbers(blockers.self_distances.iter().copied());
        let own = blockers.self_shadows.iter();
        self.numbers(own.flat_map(|s| [s.offset.x, s.offset.y, s.offset.z, s.radius, s.distance]));
    }

    fn sphere(&mut self, sphere: &Sphere) {
        self.numbers(sphere.center.to_array());
        self.numbers([sphere.radius]);
    }

    fn mesh(&mut self, mesh: &Mesh) {
        self.numbers(mesh.positions.iter().flat_map(|p| p.to_array()));
        self.words(mesh.triangles.iter().flatten().copied());
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Mesh(mesh) => self.mesh(mesh),
            Shape::Instances(instances) => {
                self.mesh(instances.mesh());
                self.numbers(instances.places().iter().flat_map(|m| m.to_cols_array()));
            }
            Shape::Spheres(spheres) => spheres.iter().for_each(|sphere| self.sphere(sphere)),
        }
    }
}

impl Reference<'_> {
    /// Writes all that [`restore`](Self::restore) needs, little-endian: 192 bytes a point, and their CRC-32 at the end.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn save(&self, to: impl Write) -> io::Result<()> {
        let mut to = Summed::new(to);
        to.write_all(&MAGIC)?;
        to.write_all(&VERSION.to_le_bytes())?;
        to.write_all(&self.job.fingerprint().to_le_bytes())?;
        to.write_all(&(self.tallies.len() as u64).to_le_bytes())?;
        for n in &self.done {
            to.write_all(&n.to_le_bytes())?;
        }
        let mut row = Vec::new();
        for tally in &self.tallies {
            row.clear();
            let values = tally.radiance.iter().chain(&tally.unshadowed).flat_map(|v| v.to_array());
            row.extend(values.flat_map(f32::to_le_bytes));
            to.write_all(&row)?;
        }
        let sum = to.sum.clone().finalize();
        to.inner.write_all(&sum.to_le_bytes())
    }

    /// Resumes from the output of [`save`](Self::save) for the same job; the result is the same as without interruption.
    ///
    /// # Errors
    /// When it cannot be read, is damaged or belongs to another job; nothing is changed then.
    pub fn restore(&mut self, from: impl Read) -> Result<(), CheckpointError> {
        let mut from = Summed::new(from);
        let mut magic = [0; 8];
        from.read_exact(&mut magic)?;
        if magic != MAGIC || read_word(&mut from)? != VERSION {
            return Err(CheckpointError::Format);
        }
        if read_long(&mut from)? != self.job.fingerprint() || read_long(&mut from)? != self.tallies.len() as u64 {
            return Err(CheckpointError::OtherJob);
        }
        let mut done = vec![0; self.done.len()];
        for n in &mut done {
            *n = read_word(&mut from)?;
        }
        let mut tallies = vec![Tally::default(); self.tallies.len()];
        let mut row = [0; 2 * REPLICATES as usize * 12];
        for tally in &mut tallies {
            from.read_exact(&mut row)?;
            for (v, bytes) in tally.radiance.iter_mut().chain(&mut tally.unshadowed).zip(row.chunks_exact(12)) {
                let x = |k: usize| f32::from_le_bytes(core::array::from_fn(|j| bytes[4 * k + j]));
                *v = Vec3::new(x(0), x(1), x(2));
            }
        }
        let sum = from.sum.clone().finalize();
        if read_word(&mut from)? != sum || from.read(&mut [0])? > 0 {
            return Err(CheckpointError::Damaged);
        }
        (self.done, self.tallies) = (done, tallies);
        Ok(())
    }
}

fn read_word(from: &mut impl Read) -> Result<u32, CheckpointError> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

fn read_long(from: &mut impl Read) -> Result<u64, CheckpointError> {
    let mut bytes = [0; 8];
    from.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

/// A stream, with the checksum of the bytes that went through it.
struct Summed<T> {
    inner: T,
    sum: crc32fast::Hasher,
}

impl<T> Summed<T> {
    fn new(inner: T) -> Self {
        Self { inner, sum: crc32fast::Hasher::new() }
    }
}

impl<T: Write> Write for Summed<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.sum.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<T: Read> Read for Summed<T> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.sum.update(&bytes[..count]);
        Ok(count)
    }
}
