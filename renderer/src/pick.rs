//! Queries of single points: the surface that a pixel shows, and the visible fraction of a light.

use crate::bands::Bands;
use crate::kept_maps::MapRequest;
use crate::render::check_window;
use crate::{
    Backend, EditError, FrameBlockers, KeptSky, LightHandle, LightMask, MaterialHandle, Method, ObjectHandle,
    RenderError, Renderer, Shader, ShaderTask,
};
use brdf::Material;
use core::ops::{ControlFlow, Range};
use glam::Vec3;
use lighting::Light;
use lobe_core::{BrdfLobe, Receiver};
use paper::Tables;
use pictures::Window;
use render_cpu::{CpuShader, GBuffer, ShadeRequest, World};
use scene::{Frame, Scene, Shade, ShadingPoints};
use shading::{Accuracy, BrdfLobes, LightId, LightLobes, Unshadowed};
use visibility_shadowmap::ReceiverBounds;

/// The surface that a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The object that the pixel shows.
    pub object: ObjectHandle,
    /// The light whose surface it is, if any.
    pub light: Option<LightHandle>,
    /// The object's material.
    pub material: MaterialHandle,
    /// The point that is shaded: position, normals, direction toward the eye.
    pub receiver: Receiver,
    /// Distance from the eye, in units of the scene; of an orthographic camera from the plane through the eye.
    pub distance: f32,
}

/// Rows of pixels whose camera rays are held at once.
const COVERAGE_ROWS: usize = 64;

/// A point is on a light if it is within this fraction of the light's radius.
const ON_LIGHT: f32 = 1e-3;

impl Renderer {
    /// The surface at the centre of a pixel: the same point, bit for bit, as in a picture with one ray a pixel. `None` if the
    /// camera sees nothing there, and outside the picture.
    ///
    /// The point belongs to a light if it is on that light's surface (to a thousandth of its radius), or if the light's surface is
    /// the object. Lights that no object shows cannot be seen or picked.
    ///
    /// ```
    /// use renderer::{Renderer, Settings};
    /// let mut scene = scene::builtin();
    /// (scene.width, scene.height) = (64, 36);
    /// let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
    /// let pick = renderer.pick(32, 34).expect("the floor");
    /// assert!(pick.light.is_none() && pick.receiver.normal.y > 0.9);
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Cost
    /// One ray, once the hierarchy is updated to the last edit.
    pub fn pick(&mut self, x: u32, y: u32) -> Option<Pick> {
        let found = self.point_of(x, y)?;
        let receiver = *found.points.receivers.first()?;
        let object = receiver.object as usize;
        let light = light_at(&self.scene.lights, &receiver);
        Some(Pick {
            object: ObjectHandle(self.rows.revisions()[object].object),
            light: light.map(|light| LightHandle(self.light_handles.at(light))),
            material: MaterialHandle(self.material_handles.at(self.scene.objects[object].material)),
            receiver,
            distance: self.scene.camera.distance(receiver.position),
        })
    }

    /// The visible point in the middle of a pixel, if there is one; `None` outside the picture.
    fn point_of(&mut self, x: u32, y: u32) -> Option<GBuffer> {
        let (width, height) = (self.scene.width, self.scene.height);
        if x >= width || y >= height {
            return None;
        }
        let hierarchy = self.follow_hierarchy();
        let world = World::with_hierarchy(&self.scene, hierarchy);
        Some(GBuffer::window(&world, width, height, 1, x..x + 1, y..y + 1))
    }

    /// The lobes of reflectance of the surface in the middle of a pixel as the camera sees it, textures included: `f_r·(n·v)` as a sum of
    /// lobes, below the horizon of [`pick`](Self::pick)'s normal to be taken as 0. Empty where the camera meets nothing there, and outside
    /// the picture.
    ///
    /// # Cost
    /// One ray, once the hierarchy is updated to the last edit.
    #[must_use]
    pub fn reflectance(&mut self, x: u32, y: u32) -> Vec<BrdfLobe> {
        let Some(found) = self.point_of(x, y) else { return Vec::new() };
        let mut lobes = Vec::new();
        let first = found.points.receivers.first().zip(found.points.materials.first());
        if let Some((at, material)) = first.and_then(|(at, number)| Some((at, found.materials.get(*number as usize)?)))
        {
            material.brdf_lobes(at, &mut lobes);
        }
        lobes
    }

    /// The fraction of each pixel of a window that shows a surface, row by row: the rest shows the background.
    ///
    /// ```
    /// use renderer::{Renderer, Settings};
    /// let mut scene = scene::builtin();
    /// (scene.width, scene.height) = (64, 36);
    /// let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
    /// let coverage = renderer.coverage(&pictures::Window::whole(64, 36))?;
    /// assert!(coverage.len() == 64 * 36 && coverage.iter().all(|part| (0.0..=1.0).contains(part)));
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Cost
    /// The camera rays of the window, once the hierarchy is updated to the last edit.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`]; [`RenderError::Setting`] for a window that is no part of the picture.
    pub fn coverage(&mut self, window: &Window) -> Result<Vec<f32>, RenderError> {
        check_window(window, &self.scene)?;
        let (samples, cancel) = (self.settings.samples, self.cancel.clone());
        let hierarchy = self.follow_hierarchy();
        let world = World::with_hierarchy(&self.scene, hierarchy);
        let mut all = Vec::with_capacity(window.pixels());
        for band in window.parts([window.image[0].max(1), COVERAGE_ROWS]) {
            let range = |side: &Range<usize>| side.start as u32..side.end as u32;
            let (part, image) = ([range(&band.columns), range(&band.rows)], band.image.map(|side| side as u32));
            let g = GBuffer::sampled(&world, image, samples, part, &cancel).ok_or(RenderError::Cancelled)?;
            let ones = vec![1.0; g.len()];
            all.extend(g.resolve(&ones, 0.0).iter().map(|part| part.min(1.0)));
        }
        Ok(all)
    }

    /// The radiance that the surface in the middle of a pixel would have of each light if nothing blocked it, in the order of the lights;
    /// empty where the camera meets nothing there, and outside the picture.
    ///
    /// # Cost
    /// One point under all lights, on the CPU.
    #[must_use]
    pub fn unshadowed(&mut self, x: u32, y: u32) -> Vec<Vec3> {
        let Some(found) = self.point_of(x, y) else { return Vec::new() };
        let accuracy = self.chosen.unwrap_or(self.settings.accuracy);
        let frame = Frame { materials: &found.materials, lights: &self.scene.lights, accuracy, threshold: 0.0 };
        let request = ShadeRequest { lights: true, ..ShadeRequest::default() };
        let mut radiance = vec![Vec3::ZERO; found.len()];
        let (_, layers) = CpuShader::new(Unshadowed).shade_with(&found.points, &frame, &mut radiance, &request);
        layers.lights
    }

    /// The visible fraction of a light for a white diffuse surface at a point, by the scene's own strategies and accuracy:
    ///
    /// ```text
    /// ∫ L (n·v) V dv / ∫ L (n·v) dv
    /// ```
    ///
    /// over the light, per channel (the channels differ only if the light shows an image); 0 if the surface gets nothing of the
    /// light even without blockers. [`Receiver::on_surface`] makes points that are on no object.
    ///
    /// # Cost
    /// Shades one point under all lights, and gathers the blockers: meant for single points.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the light is not in the scene; those of [`render`](Self::render).
    pub fn visible_fraction(&mut self, at: &Receiver, light: LightHandle) -> Result<Vec3, RenderError> {
        let light = self.light_handles.place(light.0).ok_or(EditError::NoLight(light))?;
        self.blockers_at(at.position, |blockers, scene, accuracy| {
            let materials = &[Material::lambert(Vec3::ONE)];
            let frame = Frame { materials, lights: &scene.lights, accuracy, threshold: 0.0 };
            blockers.shade(&mut Backend::Cpu, Method::Moments, None, Fraction { at, light, frame })
        })
    }

    /// The mask of a light as a point sees it, by the scene's own strategies: one fine mask of the whole light, of the depth that the
    /// accuracy takes.
    ///
    /// # Cost
    /// As [`visible_fraction`](Self::visible_fraction).
    ///
    /// # Errors
    /// As [`visible_fraction`](Self::visible_fraction).
    pub fn light_mask(&mut self, at: &Receiver, light: LightHandle) -> Result<LightMask, RenderError> {
        let light = self.light_handles.place(light.0).ok_or(EditError::NoLight(light))?;
        self.blockers_at(at.position, |blockers, scene, accuracy| {
            let light = (LightId(light as u32), &scene.lights[light]);
            Ok(LightMask::new(blockers, at, light, accuracy))
        })
    }

    /// Does something with all that blocks light before a point.
    fn blockers_at<R>(
        &mut self,
        at: Vec3,
        work: impl FnOnce(FrameBlockers<'_>, &Scene, Accuracy) -> Result<R, RenderError>,
    ) -> Result<R, RenderError> {
        self.blockers_around(core::iter::once(at), |around| work(around.blockers, around.scene, around.accuracy))
    }

    /// Does something with all that blocks light before some points.
    pub(crate) fn blockers_around<R>(
        &mut self,
        points: impl Iterator<Item = Vec3>,
        work: impl FnOnce(Around<'_>) -> Result<R, RenderError>,
    ) -> Result<R, RenderError> {
        self.prepare(&mut |_| ControlFlow::Continue(()))?;
        let hierarchy = self.follow(&mut crate::FrameClocks::default())?;
        let world = World::with_hierarchy(&self.scene, hierarchy);
        let mut maps = Vec::new();
        if self.plan.wants_maps(&self.scene) {
            let whole = [Window::whole(self.scene.width as usize, self.scene.height as usize)];
            let parts = if self.settings.keep_points { &whole[..] } else { &[] };
            let seen = Bands::new(&world, &self.settings, parts, &mut self.kept.points, &self.cancel).bounds()?;
            let (resolution, room) = (self.settings.map_resolution, self.backend.room_for_maps());
            if let Some(around) = points.fold(seen, |bounds, point| Some(bounds_with(bounds, point))) {
                maps = if seen == Some(around) {
                    let request = MapRequest { receivers: around, resolution, room };
                    self.kept.maps.update(&self.plan, &self.scene, request, &self.cancel)?.0
                } else {
                    self.plan.maps(&self.scene, around, resolution, room)?.0
                };
            }
        }
        let accuracy = self.chosen.unwrap_or(self.settings.accuracy);
        let (plan, spheres) = (&self.plan, self.spheres.get());
        let blockers = FrameBlockers::new(plan, &world, spheres, maps, &self.silhouettes, accuracy);
        let blockers = blockers.with(&self.custom.0, &self.settings);
        let (sky, backend, tables) = (&mut self.sky, &mut self.backend, self.tables.as_ref());
        work(Around { blockers, scene: &self.scene, accuracy, sky, backend, tables })
    }
}

/// All that blocks light before some points, and all else that shades them.
pub(crate) struct Around<'a> {
    pub(crate) blockers: FrameBlockers<'a>,
    pub(crate) scene: &'a Scene,
    pub(crate) accuracy: Accuracy,
    pub(crate) sky: &'a mut KeptSky,
    pub(crate) backend: &'a mut Backend,
    pub(crate) tables: Option<&'a Tables>,
}

/// The smallest box that contains `bounds` and a point.
fn bounds_with(bounds: Option<ReceiverBounds>, point: Vec3) -> ReceiverBounds {
    let ReceiverBounds { min, max } = bounds.unwrap_or(ReceiverBounds { min: point, max: point });
    ReceiverBounds { min: min.min(point), max: max.max(point) }
}

/// The nearest of the lights whose surface contains a point, or whose surface is its object.
fn light_at(lights: &[Light], at: &Receiver) -> Option<usize> {
    let distance = |light: &Light| {
        let distance = light.distance_to(at.position)?;
        let stands_for_it = matches!(light, Light::Enclosed(inside) if inside.object == at.object);
        (stands_for_it || distance <= ON_LIGHT * light.bounds().radius).then_some(distance)
    };
    let all = lights.iter().enumerate().filter_map(|(number, light)| Some((number, distance(light)?)));
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(number, _)| number)
}

/// Computes the visible fraction of one light at a point.
struct Fraction<'a> {
    at: &'a Receiver,
    light: usize,
    frame: Frame<'a>,
}

impl ShaderTask for Fraction<'_> {
    type Output = Vec3;

    async fn with<S: Shader>(self, shader: &mut S) -> Result<Vec3, RenderError> {
        let points = ShadingPoints { receivers: vec![*self.at], materials: vec![0], ..ShadingPoints::default() };
        let request = ShadeRequest { lights: true, ..ShadeRequest::default() };
        let (_, layers) = shader.shade_with(&points, &self.frame, &mut [Vec3::ZERO], &request).await?;
        let alone = Frame { lights: &self.frame.lights[self.light..=self.light], ..self.frame };
        let mut whole = [Vec3::ZERO];
        CpuShader::new(Unshadowed).shade(&points, &alone, &mut whole)?;
        let part = layers.lights[self.light];
        let share = |k: usize| if whole[0][k] > 0.0 { (part[k] / whole[0][k]).clamp(0.0, 1.0) } else { 0.0 };
        Ok(Vec3::from_array(core::array::from_fn(share)))
    }
}
