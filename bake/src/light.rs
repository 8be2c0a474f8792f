//! The light that falls on points.

use core::f32::consts::PI;
use glam::Vec3;
use lobe_core::Receiver;
use renderer::{LayerSet, RenderError, Renderer};
use scene::{Scene, ShadingPoints};

/// Points that are shaded at once.
const POINTS: usize = 1 << 20;

/// Lights that have one map: one, or all patches of a sky.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LightGroup {
    pub(crate) name: String,
    pub(crate) lights: Vec<usize>,
}

/// The lights of a scene, each with a name; those of its sky that are patches of it as one.
pub(crate) fn light_groups(scene: &Scene) -> Vec<LightGroup> {
    let patches = scene.environment.as_ref().and_then(|sky| sky.patches_among(&scene.lights));
    let is_patch = |light: usize| patches.as_ref().is_some_and(|patches| patches[light]);
    let (sky, single): (Vec<usize>, Vec<usize>) = (0..scene.lights.len()).partition(|light| is_patch(*light));
    let single =
        single.into_iter().enumerate().map(|(k, light)| LightGroup { name: format!("light{k}"), lights: vec![light] });
    let mut groups: Vec<LightGroup> = single.collect();
    if !sky.is_empty() {
        groups.push(LightGroup { name: "sky".to_owned(), lights: sky });
    }
    groups
}

/// Irradiance of points: of all lights first, then of each group if these are requested.
pub(crate) struct Irradiance {
    groups: Vec<LightGroup>,
    layers: LayerSet,
}

impl Irradiance {
    pub(crate) fn new(scene: &Scene, per_light: bool) -> Self {
        let groups = if per_light { light_groups(scene) } else { Vec::new() };
        Self { groups, layers: LayerSet { lights: per_light, ..LayerSet::NONE } }
    }

    /// The groups that have lists of their own.
    pub(crate) fn groups(&self) -> &[LightGroup] {
        &self.groups
    }

    /// Lists of irradiance in W·m⁻² per channel, one value a point: `E = π L` of the radiance `L` that a white Lambertian surface
    /// reflects.
    pub(crate) fn of(&self, renderer: &mut Renderer, receivers: &[Receiver]) -> Result<Vec<Vec<Vec3>>, RenderError> {
        let white = [brdf::Material::lambert(Vec3::ONE)];
        let mut all = vec![Vec::with_capacity(receivers.len()); 1 + self.groups.len()];
        for chunk in receivers.chunks(POINTS) {
            let points = ShadingPoints {
                receivers: chunk.to_vec(),
                materials: vec![0; chunk.len()],
                ..ShadingPoints::default()
            };
            let light = renderer.shade_points(points, Some(&white), self.layers)?;
            all[0].extend(light.radiance.iter().map(|radiance| *radiance * PI));
            for (list, group) in all[1..].iter_mut().zip(&self.groups) {
                let of = |point: usize| group.lights.iter().map(|l| light.lights[*l][point]).sum::<Vec3>() * PI;
                list.extend((0..chunk.len()).map(of));
            }
        }
        Ok(all)
    }

    /// Shows the renderer the box of all points, so that what blocks is the same for all of them.
    pub(crate) fn begin(&self, renderer: &mut Renderer, points: impl Iterator<Item = Vec3>) -> Result<(), RenderError> {
        let ends = points.fold(None, |ends: Option<[Vec3; 2]>, p| {
            Some(ends.map_or([p; 2], |[low, high]| [low.min(p), high.max(p)]))
        });
        let corners = ends.into_iter().flatten().map(|p| Receiver::on_surface(p, Vec3::Y, Vec3::Y));
        self.of(renderer, &corners.collect::<Vec<_>>()).map(|_| ())
    }
}
