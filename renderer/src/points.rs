//! Light at points of the caller's.

use crate::{LayerSet, RenderError, Renderer, Shader, ShaderTask};
use brdf::Material;
use glam::Vec3;
use lobe_core::{NO_OBJECT, Receiver};
use render_cpu::{Layers as PointLayers, ShadeRequest};
use scene::{Frame, ShadingPoints};

/// The light that points reflect toward their views, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointLight {
    /// Radiance, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec<Vec3>,
    /// The same without blockers; empty unless [`LayerSet::unshadowed`].
    pub unshadowed: Vec<Vec3>,
    /// The part of each light; empty unless [`LayerSet::lights`].
    pub lights: Vec<Vec<Vec3>>,
}

impl Renderer {
    /// The radiance that points reflect, by the scene's lights, its blockers and the settings of pictures: at a picture's own points the
    /// same bits as the picture, without what they emit.
    ///
    /// `materials` are those that the points' numbers mean; none stands for the scene's. A surface of albedo 1 has the radiance E/π, E its
    /// irradiance. A receiver's object is its place in [`objects`](Self::objects), which keeps an object's own spheres from blackening it;
    /// [`Receiver::on_surface`] makes points that are on no object. Of `layers` those of lights are used.
    ///
    /// ```
    /// use lobe_core::Receiver;
    /// use renderer::{LayerSet, Renderer, Settings, glam::Vec3};
    /// use scene::ShadingPoints;
    /// let mut renderer = Renderer::new(scene::builtin(), scene::Animation::default(), Settings::default())?;
    /// let receivers = (0..9).map(|i| Receiver::on_surface(Vec3::X * i as f32, Vec3::Y, Vec3::Y)).collect();
    /// let points = ShadingPoints { receivers, materials: vec![0; 9], ..ShadingPoints::default() };
    /// let white = [brdf::Material::lambert(Vec3::ONE)];
    /// let light = renderer.shade_points(points, Some(&white), LayerSet::NONE)?;
    /// assert_eq!(light.radiance.len(), 9);
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Cost
    /// That of as many pixels, without their rays, and 0.1 µs a point to put them in order: neighbours in space are shaded together,
    /// whatever their order is.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for points that are not finite, directions that are not unit vectors, and numbers of materials or objects
    /// that do not exist; those of [`render`](Self::render).
    pub fn shade_points(
        &mut self,
        mut points: ShadingPoints,
        materials: Option<&[Material]>,
        layers: LayerSet,
    ) -> Result<PointLight, RenderError> {
        let materials_count = materials.map_or(self.scene.materials.len(), <[Material]>::len);
        check(&points, materials_count, self.scene.objects.len())?;
        let order = points.make_coherent();
        let (cancel, threshold, method) = (self.cancel.clone(), self.settings.threshold, self.settings.method);
        let positions: Vec<Vec3> = points.receivers.iter().map(|at| at.position).collect();
        self.lights_points(&positions);
        let count = order.len();
        let (radiance, layers, lights) = self.blockers_around(positions.into_iter(), |around| {
            let lights = &around.scene.lights;
            let materials = materials.unwrap_or(&around.scene.materials);
            let frame = Frame { materials, lights, accuracy: around.accuracy, threshold };
            let request = LayerSet { counts: false, ..layers }.request(&cancel);
            let blockers = around.blockers.under(around.sky, &frame, around.backend, method);
            let shading = Shading { points: &points, frame, request };
            let (radiance, layers) = blockers.shade(around.backend, method, around.tables, shading)?;
            Ok((radiance, layers, lights.len()))
        })?;
        let place = |values: &mut dyn Iterator<Item = Vec3>| {
            let mut all = vec![Vec3::ZERO; count];
            order.iter().zip(values).for_each(|(place, value)| all[*place as usize] = value);
            all
        };
        let PointLayers { unshadowed, lights: parts, .. } = layers;
        let of_light = |light: usize| place(&mut parts.iter().skip(light).step_by(lights.max(1)).copied());
        Ok(PointLight {
            radiance: place(&mut radiance.into_iter()),
            unshadowed: if unshadowed.is_empty() { unshadowed } else { place(&mut unshadowed.into_iter()) },
            lights: if parts.is_empty() { Vec::new() } else { (0..lights).map(of_light).collect() },
        })
    }
}

/// Checks everything that shading relies on.
fn check(points: &ShadingPoints, materials: usize, objects: usize) -> Result<(), RenderError> {
    let (count, numbers) = (points.receivers.len(), points.materials.len());
    if count != numbers {
        let value = format!("{count} receivers with {numbers} numbers of materials");
        return Err(RenderError::Setting { name: "list of points", value, expected: "one number of a material each" });
    }
    let is_unit = |v: Vec3| (v.length() - 1.0).abs() <= 1e-3;
    let is_place = |at: &Receiver| at.object == NO_OBJECT || (at.object as usize) < objects;
    for (at, material) in points.receivers.iter().zip(&points.materials) {
        let expected = match () {
            () if !at.position.is_finite() => "finite coordinates",
            () if !(is_unit(at.normal) && is_unit(at.face) && is_unit(at.view)) => "unit vectors",
            () if !is_place(at) => "an object of the scene, or none",
            () if *material as usize >= materials => "a material that exists",
            () => continue,
        };
        return Err(RenderError::Setting { name: "point", value: format!("{at:?} of material {material}"), expected });
    }
    Ok(())
}

/// Shades points.
pub(crate) struct Shading<'a> {
    pub(crate) points: &'a ShadingPoints,
    pub(crate) frame: Frame<'a>,
    pub(crate) request: ShadeRequest<'a>,
}

impl ShaderTask for Shading<'_> {
    type Output = (Vec<Vec3>, PointLayers);

    async fn with<S: Shader>(self, shader: &mut S) -> Result<Self::Output, RenderError> {
        let mut radiance = vec![Vec3::ZERO; self.points.receivers.len()];
        let (_, layers) = shader.shade_with(self.points, &self.frame, &mut radiance, &self.request).await?;
        Ok((radiance, layers))
    }
}
