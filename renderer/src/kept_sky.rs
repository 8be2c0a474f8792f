use crate::Device;
use glam::Vec3;
use lighting::Environment;
use lobe_core::{BrdfLobe, Receiver};
#[cfg(feature = "gpu")]
use render_gpu::GpuSky;
use scene::{Frame, Object, Scene, Shape, Surface};
use shading::BrdfLobes;
use std::sync::Arc;
use visibility_mask::sky::{SkyResolution, SkyTable, SkyView};

/// The tables of the scene's environment, one for each resolution in use, kept from picture to picture: they follow the environment
/// alone, whatever moves before it.
#[derive(Debug, Default)]
pub struct KeptSky {
    of: Option<Arc<Environment>>,
    tables: Vec<SkyTable>,
    /// The table that a GPU used last, as it reads it.
    #[cfg(feature = "gpu")]
    packed: Option<GpuSky>,
    /// Tables that were made so far.
    made: u64,
}

/// An environment as it is summed at once: its tables, each of smaller steps than the one before, and which of the scene's lights they
/// stand for.
#[derive(Clone, Debug)]
pub struct SkyFrame<'a> {
    pub(crate) tables: Vec<&'a SkyTable>,
    pub(crate) replaced: Vec<bool>,
    /// The first table as a GPU reads it, on a GPU.
    #[cfg(feature = "gpu")]
    pub(crate) packed: Option<GpuSky>,
}

impl KeptSky {
    /// The sky of a scene for a frame's accuracy and materials. None without an environment, and where its patches are not all among the
    /// lights as they were made: then they are lights like others. A GPU has the first table alone.
    pub fn follow(&mut self, scene: &Scene, frame: &Frame<'_>, device: Device) -> Option<SkyFrame<'_>> {
        let environment = scene.environment.as_ref()?;
        let replaced = environment.patches_among(frame.lights)?;
        if !replaced.contains(&true) {
            return None;
        }
        if self.of.as_ref().is_none_or(|of| !Arc::ptr_eq(of, environment)) {
            self.of = Some(Arc::clone(environment));
            self.tables.clear();
            #[cfg(feature = "gpu")]
            {
                self.packed = None;
            }
        }
        let mut resolutions = resolutions(scene, frame);
        if device == Device::Gpu {
            resolutions.truncate(1);
        }
        for resolution in &resolutions {
            if self.table(*resolution).is_none() {
                let sky = environment.sky();
                self.tables.push(SkyTable::new(*resolution, sky.size().x, |v| sky.radiance(v)));
                self.made += 1;
            }
        }
        #[cfg(feature = "gpu")]
        if device == Device::Gpu {
            let first = *resolutions.first()?;
            if self.packed.as_ref().is_none_or(|packed| packed.resolution() != first) {
                self.packed = self.table(first).map(GpuSky::new);
            }
        }
        let tables = resolutions.into_iter().filter_map(|resolution| self.table(resolution)).collect();
        Some(SkyFrame {
            tables,
            replaced,
            #[cfg(feature = "gpu")]
            packed: self.packed.clone().filter(|_| device == Device::Gpu),
        })
    }

    fn table(&self, resolution: SkyResolution) -> Option<&SkyTable> {
        self.tables.iter().find(|table| table.meridians().resolution() == resolution)
    }

    /// Tables that were made so far.
    #[must_use]
    pub const fn made(&self) -> u64 {
        self.made
    }
}

/// The sine of the height of the eye over a surface from which tables are to resolve all lobes. From lower views the last table sums them by several directions
/// for each sample, which moves edges in reflections.
const LOW: f32 = 0.25;

/// Between copies of a mesh, from this number of triangles in all copies on, the sky is seen through openings of all sizes. For the same error of own radiance the
/// tolerance is this part of that elsewhere (measured: 2000 spheres).
const MANY: usize = 100_000;
const BETWEEN_COPIES: f32 = 0.6;

/// The resolution of a tolerance, a finer one for receivers that see little of the sky, and as many more as the narrowest lobes of the materials need.
fn resolutions(scene: &Scene, frame: &Frame<'_>) -> Vec<SkyResolution> {
    let are_many = |object: &Object| matches!(&object.shape, Shape::Instances(all) if all.triangle_count() >= MANY);
    let part = if scene.objects.iter().any(are_many) { BETWEEN_COPIES } else { 1.0 };
    let first = SkyResolution::of_tolerance(part * frame.accuracy.tolerance);
    let mut all: Vec<_> = core::iter::successors(Some(first), |last| last.finer()).collect();
    // A picture may make any roughness of it.
    let varies = |surface: &Surface| surface.roughness.is_some() || surface.exponent.is_some();
    if scene.surfaces.iter().any(varies) {
        return all;
    }
    // Lobes that no table resolves are not summed over one.
    let is_summed = |lobe: &BrdfLobe| all.last().is_some_and(|finest| SkyView::resolves(*finest, lobe));
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::new((1.0 - LOW * LOW).sqrt(), 0.0, LOW));
    let mut lobes = Vec::new();
    frame.materials.iter().for_each(|material| material.brdf_lobes(&at, &mut lobes));
    lobes.retain(is_summed);
    let is_enough = |table: &SkyResolution| lobes.iter().all(|lobe| SkyView::resolves_at(*table, lobe, Vec3::Z));
    let needed = all.iter().position(is_enough).map_or(all.len(), |place| place + 1);
    all.truncate(needed.max(1 + usize::from(first.for_little().is_some())));
    all
}
