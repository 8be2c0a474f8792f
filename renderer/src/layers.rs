use glam::Vec3;
use render_cpu::{GBuffer, Layers as PointLayers, ShadeRequest};
use scene::Cancel;

/// The layers that pictures have beside their radiance, each by choice: a layer that is not requested costs neither time nor
/// memory.
///
/// ```
/// use renderer::{LayerSet, Renderer, Settings};
/// let mut scene = scene::builtin();
/// (scene.width, scene.height) = (32, 18);
/// let layers = LayerSet { depths: true, ..LayerSet::NONE };
/// let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings { layers, ..Settings::default() })?;
/// let layers = renderer.render()?.layers;
/// assert_eq!((layers.depths.len(), layers.normals.len()), (32 * 18, 0));
/// # Ok::<(), renderer::RenderError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerSet {
    /// [`Layers::unshadowed`]; on the CPU.
    pub unshadowed: bool,
    /// [`Layers::lights`]; on the CPU.
    pub lights: bool,
    /// [`Layers::normals`].
    pub normals: bool,
    /// [`Layers::depths`].
    pub depths: bool,
    /// [`Layers::objects`].
    pub objects: bool,
    /// [`Layers::lobes`] and [`Layers::products`]; on the CPU.
    pub counts: bool,
}

impl LayerSet {
    /// None of them.
    pub const NONE: Self =
        Self { unshadowed: false, lights: false, normals: false, depths: false, objects: false, counts: false };
    /// All of them.
    pub const ALL: Self =
        Self { unshadowed: true, lights: true, normals: true, depths: true, objects: true, counts: true };

    /// Whether one of the layers exists only on the CPU.
    #[must_use]
    pub const fn is_of_cpu(&self) -> bool {
        self.unshadowed || self.lights || self.counts
    }

    pub(crate) const fn request<'a>(&self, cancel: &'a Cancel) -> ShadeRequest<'a> {
        let Self { unshadowed, lights, counts, .. } = *self;
        ShadeRequest { unshadowed, lights, counts, cancel: Some(cancel) }
    }
}

/// The layers of a picture, pixel by pixel; those that the [`LayerSet`] leaves out are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Radiance without blockers.
    pub unshadowed: Vec<Vec3>,
    /// The radiance from each light.
    pub lights: Vec<Vec<Vec3>>,
    /// Unit shading normals, the mean of a pixel's rays.
    pub normals: Vec<Vec3>,
    /// Distance from the plane of the eye, of a panoramic camera from the eye; infinite if the pixel sees nothing.
    pub depths: Vec<f32>,
    /// The object that a pixel shows, as a place in [`objects`](crate::Renderer::objects): that of the pixel's first ray that meets
    /// anything. [`NO_OBJECT`](Self::NO_OBJECT) if no ray does.
    pub objects: Vec<u32>,
    /// Visibility lobes made.
    pub lobes: Vec<f32>,
    /// Lobe integrals evaluated.
    pub products: Vec<f32>,
}

impl Layers {
    /// The pixel shows no object.
    pub const NO_OBJECT: u32 = u32::MAX;

    /// The requested layers, from visible points and the results for each of them.
    pub(crate) fn new(g: &GBuffer, mut points: PointLayers, set: &LayerSet, lights: usize, background: Vec3) -> Self {
        let mut all = Self::default();
        if set.unshadowed {
            g.add_emission(&mut points.unshadowed);
            all.unshadowed = g.picture(&points.unshadowed, background);
        }
        if set.lights {
            let light = |l: usize| {
                let part: Vec<Vec3> = points.lights.iter().skip(l).step_by(lights).copied().collect();
                g.resolve(&part, Vec3::ZERO)
            };
            all.lights = (0..lights).map(light).collect();
        }
        if set.normals {
            let normals: Vec<Vec3> = g.points.receivers.iter().map(|r| r.normal).collect();
            all.normals = g.resolve(&normals, Vec3::ZERO);
        }
        if set.depths {
            all.depths = g.resolve(&g.depths, f32::INFINITY);
        }
        if set.objects {
            all.objects = vec![Self::NO_OBJECT; g.width as usize * g.height as usize];
            for (pixel, at) in g.pixels.iter().zip(&g.points.receivers).rev() {
                all.objects[*pixel as usize] = at.object;
            }
        }
        if set.counts {
            let numbers = |n: &[u32]| n.iter().map(|n| *n as f32).collect::<Vec<f32>>();
            all.lobes = g.resolve(&numbers(&points.lobes), 0.0);
            all.products = g.resolve(&numbers(&points.integrals), 0.0);
        }
        all
    }

    /// Appends the next rows.
    pub fn append(&mut self, next: &Self) {
        self.unshadowed.extend_from_slice(&next.unshadowed);
        self.lights.resize(next.lights.len(), Vec::new());
        self.lights.iter_mut().zip(&next.lights).for_each(|(all, next)| all.extend_from_slice(next));
        self.normals.extend_from_slice(&next.normals);
        self.depths.extend_from_slice(&next.depths);
        self.objects.extend_from_slice(&next.objects);
        self.lobes.extend_from_slice(&next.lobes);
        self.products.extend_from_slice(&next.products);
    }
}
