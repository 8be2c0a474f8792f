use crate::RenderError;
use crate::backdrops::Backdrops;
use core::sync::atomic::{AtomicU64, Ordering};
use glam::Vec3;
use lighting::Light;
use lobe_core::Sphere;
use rayon::prelude::*;
use render_cpu::{Looks, Revision, SceneSilhouettes, SphereSource};
use scene::{Bounds, Cancel, Object, Proxy, Scene, Shape, Strategy};
use shading::LightLobes;
use visibility_shadowmap::{MapOptions, PackedMaps, ReceiverBounds, ShadowMap};

/// The finest resolution of a shadow map, unless another one is requested.
const FITTED: u32 = 2048;

/// One strategy for each object; [`Strategy::None`] for those that block nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    objects: Vec<Strategy>,
}

impl Plan {
    /// Uses `strategy` for all objects; without it each object's own strategy from the scene; without that silhouettes for meshes,
    /// and spheres for sphere objects and sphere sets. Everything blocks light, seen or not, except [`Strategy::None`] and, by
    /// [`Strategy::Spheres`], what has no spheres.
    ///
    /// A floor or wall without a strategy of its own is left out at moments when no visible surface and no light is behind it: it hides
    /// nothing then.
    #[must_use]
    pub fn new(strategy: Option<Strategy>, scene: &Scene) -> Self {
        Self::with_points(strategy, scene, None)
    }

    /// The same where points in a box are lit as well.
    pub(crate) fn with_points(strategy: Option<Strategy>, scene: &Scene, points: Option<Bounds>) -> Self {
        let backdrops = Backdrops::new(scene, points);
        Self::unless(strategy, scene, |object| backdrops.has(object))
    }

    /// The same, but a floor or wall with nothing behind it blocks, too: for a reference, whose rays find out what is hidden.
    #[must_use]
    pub fn with_backdrops(strategy: Option<Strategy>, scene: &Scene) -> Self {
        Self::unless(strategy, scene, |_| false)
    }

    fn unless(strategy: Option<Strategy>, scene: &Scene, is_backdrop: impl Fn(usize) -> bool) -> Self {
        let of = |(number, o): (usize, &Object)| {
            // Exact, unless the object already has spheres.
            let usual = match (&o.proxy, &o.shape) {
                (Proxy::Count(_) | Proxy::None, Shape::Mesh(_) | Shape::Instances(_)) => Strategy::Silhouettes,
                _ => Strategy::Spheres,
            };
            // Lights that stand for a curved emitter are inside of it: it must not hide them, whichever strategy others have.
            let is_inside =
                |light: &Light| matches!(light, Light::Enclosed(inside) if inside.object as usize == number);
            if o.strategy == Some(Strategy::None) && scene.lights.iter().any(is_inside) {
                return Strategy::None;
            }
            let blocks = match strategy.or(o.strategy) {
                None if usual == Strategy::Silhouettes => !is_backdrop(number),
                None | Some(Strategy::Spheres) => o.proxy != Proxy::None,
                Some(Strategy::None) => false,
                // Objects without a proxy block too, by their true geometry.
                Some(_) => true,
            };
            if blocks { strategy.or(o.strategy).unwrap_or(usual) } else { Strategy::None }
        };
        Self { objects: scene.objects.iter().enumerate().map(of).collect() }
    }

    /// The strategy of an object.
    #[must_use]
    pub fn of(&self, object: usize) -> Strategy {
        self.objects[object]
    }

    /// For each object whether shadow maps draw its triangles: the maps of all lights must show it.
    ///
    /// # Cost
    /// Visits every triangle of objects by shadow maps once for each light.
    #[must_use]
    pub fn casters(&self, scene: &Scene) -> Vec<bool> {
        let in_maps = |(o, object): (usize, &Object)| {
            let Shape::Mesh(mesh) = &object.shape else { return false };
            // A shadow map is seen from the centre of a sphere light.
            let shows = |light: &Light| {
                light.sphere().is_some_and(|sphere| ShadowMap::shows(&mesh.positions, &mesh.triangles, sphere))
            };
            self.objects[o] == Strategy::ShadowMap && scene.lights.iter().all(shows)
        };
        scene.objects.iter().enumerate().map(in_maps).collect()
    }

    /// The spheres by which an object blocks: those of its proxy or of its shape. Maps and silhouettes draw only triangles, so an
    /// object of spheres that uses them blocks by its own spheres.
    #[must_use]
    pub fn spheres(&self, scene: &Scene, object: usize) -> SphereSource {
        match (self.objects[object], &scene.objects[object].shape) {
            (Strategy::Spheres, _) => SphereSource::Proxy,
            (Strategy::ShadowMap | Strategy::Silhouettes, Shape::Spheres(_)) => SphereSource::Shape,
            _ => SphereSource::Nothing,
        }
    }

    /// For each object whether it blocks by its true surface, as rays and maps do, and not by a sphere set.
    #[must_use]
    pub fn by_surfaces(&self, scene: &Scene) -> Vec<bool> {
        let by_surface =
            |o| self.objects[o] == Strategy::Rays || self.is_mapped(scene, o) || self.by_silhouettes(scene, o as u32);
        (0..self.objects.len()).map(by_surface).collect()
    }

    /// The meshes that block by silhouettes, and those by shadow maps. Silhouettes replace shadow maps for meshes that a map does
    /// not show, and for receivers on mapped objects.
    #[must_use]
    pub fn silhouettes(&self, scene: &Scene) -> SceneSilhouettes {
        SceneSilhouettes::new(scene, |o| self.by_silhouettes(scene, o) || self.is_mapped(scene, o as usize))
    }

    /// Updates silhouettes to the scene. Returns how many meshes were prepared, and how many refitted.
    pub(crate) fn follow_silhouettes(
        &self,
        scene: &Scene,
        followed: (&[Revision], Looks),
        kept: &mut SceneSilhouettes,
        cancel: &Cancel,
    ) -> [usize; 2] {
        let blocks = |o| self.by_silhouettes(scene, o) || self.is_mapped(scene, o as usize);
        kept.update_until(scene, blocks, followed, cancel)
    }

    /// Whether an object's triangles block by their silhouettes.
    #[must_use]
    pub fn by_silhouettes(&self, scene: &Scene, object: u32) -> bool {
        let o = object as usize;
        self.objects[o] == Strategy::Silhouettes && scene.objects[o].shape.has_triangles()
    }

    /// Whether an object is a mesh with the strategy shadow map.
    fn is_mapped(&self, scene: &Scene, object: usize) -> bool {
        self.objects[object] == Strategy::ShadowMap && scene.objects[object].shape.has_triangles()
    }

    /// Whether any object is a mesh with the strategy shadow map.
    #[must_use]
    pub fn wants_maps(&self, scene: &Scene) -> bool {
        (0..self.objects.len()).any(|o| self.is_mapped(scene, o))
    }

    /// The most bytes that the maps of all lights take, if each is a single image and no finer one is requested: 32 a texel, 8 for
    /// each of four layers.
    #[must_use]
    pub fn most_map_bytes(&self, scene: &Scene) -> u64 {
        if self.wants_maps(scene) { scene.lights.len() as u64 * u64::from(FITTED).pow(2) * 32 } else { 0 }
    }

    /// Draws a shadow map for each light, for receivers in `bounds`. The resolution is `resolution`, or else as each light needs,
    /// as far as the maps fit `room` bytes. Returns the reduction too if they had to be made coarser. More than `room` is never kept,
    /// beside a map for each thread.
    ///
    /// # Errors
    /// [`RenderError::Map`]; [`RenderError::MapRoom`] where a requested resolution, or the coarsest one, does not fit.
    pub fn maps(
        &self,
        scene: &Scene,
        receivers: ReceiverBounds,
        resolution: Option<u32>,
        room: u64,
    ) -> Result<(Vec<ShadowMap>, Option<MapReduction>), RenderError> {
        self.maps_beside(scene, receivers, resolution, room, &|_| Ok(None))
    }

    /// The corners and triangles of all casters.
    fn cast_triangles(&self, scene: &Scene) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for (object, is_caster) in scene.objects.iter().zip(self.casters(scene)) {
            if let (Shape::Mesh(mesh), true) = (&object.shape, is_caster) {
                let first = positions.len() as u32;
                positions.extend_from_slice(&mesh.positions);
                triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first)));
            }
        }
        (positions, triangles)
    }

    /// The same, but `known` may return the existing map of a light; its error ends the work.
    pub(crate) fn maps_beside(
        &self,
        scene: &Scene,
        receivers: ReceiverBounds,
        resolution: Option<u32>,
        room: u64,
        known: &(dyn Fn(&Sphere) -> Result<Option<ShadowMap>, RenderError> + Sync),
    ) -> Result<(Vec<ShadowMap>, Option<MapReduction>), RenderError> {
        let (positions, triangles) = self.cast_triangles(scene);
        let options = MapOptions { receivers: Some(receivers), ..MapOptions::default() };
        // The lists of casting objects and of lights with maps come first.
        let before = PackedMaps::bytes_before_maps(self.objects.len(), scene.lights.len());
        // The maps, if they fit, the bytes that all of them take, and the finest resolution.
        let draw = |finest: u32| -> Result<(Option<Vec<ShadowMap>>, u64, u32), RenderError> {
            let taken = AtomicU64::new(before);
            let map = |light| -> Result<(Option<ShadowMap>, u32), RenderError> {
                let options = MapOptions { resolution: resolution.unwrap_or(finest), ..options };
                if resolution.is_some() && taken.load(Ordering::Relaxed) > room {
                    return Ok((None, options.resolution));
                }
                let draw = if resolution.is_some() { ShadowMap::build } else { ShadowMap::fitted };
                let map = match known(&light)?.filter(|_| finest == FITTED) {
                    Some(map) => map,
                    None => draw(&positions, &triangles, light, &options)?,
                };
                let (bytes, resolution) = (map.packed_bytes(), map.resolution());
                let fits = taken.fetch_add(bytes, Ordering::Relaxed) + bytes <= room;
                Ok((fits.then_some(map), resolution))
            };
            let drawn: Vec<_> =
                scene.lights.par_iter().map(|light| map(map_sphere(light))).collect::<Result<_, _>>()?;
            let finest = drawn.iter().map(|(_, resolution)| *resolution).max().unwrap_or(0);
            let maps = drawn.into_iter().map(|(map, _)| map).collect::<Option<Vec<_>>>();
            Ok((maps, taken.into_inner(), finest))
        };
        let (mut maps, needed, wanted) = draw(FITTED)?;
        let (mut bytes, mut most, mut drawn) = (needed, wanted, wanted);
        while resolution.is_none() && bytes > room && most > MapOptions::MIN_RESOLUTION {
            let share = (room as f64 / bytes as f64).sqrt().min(0.95);
            most = ((f64::from(most) * share) as u32).max(MapOptions::MIN_RESOLUTION);
            (maps, bytes, drawn) = draw(most)?;
        }
        let maps = maps.ok_or(RenderError::MapRoom { resolution: drawn, lights: scene.lights.len(), room })?;
        let coarser = (most < wanted).then_some(MapReduction { wanted, needed, room, drawn });
        Ok((maps, coarser))
    }
}

/// The sphere that a light's shadow map is drawn for. The map of a light that is not a sphere shows no object.
pub(crate) fn map_sphere(light: &Light) -> Sphere {
    light.sphere().unwrap_or_else(|| light.bounds())
}

/// Shadow maps whose resolution was reduced, since there is no room for the resolution that the lights need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapReduction {
    /// Texels a side of the finest map that was needed.
    pub wanted: u32,
    /// Bytes that those maps take.
    pub needed: u64,
    /// Bytes that there is room for.
    pub room: u64,
    /// Texels a side of the finest map that was drawn.
    pub drawn: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_room_unless_their_resolution_is_asked_for() {
        let scene = scene::builtin();
        let plan = Plan::new(Some(Strategy::ShadowMap), &scene);
        let receivers = ReceiverBounds { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 2.0, 3.0) };
        let bytes = |maps: &[ShadowMap]| maps.iter().map(ShadowMap::packed_bytes).sum::<u64>();
        let draw = |resolution, room| plan.maps(&scene, receivers, resolution, room).expect("maps");
        let (wanted, said) = draw(None, u64::MAX);
        assert_eq!((wanted.len(), said), (scene.lights.len(), None));
        for share in [2, 100] {
            let room = bytes(&wanted) / share;
            let (maps, said) = draw(None, room);
            assert!(bytes(&maps) <= room && 4 * bytes(&maps) > room, "{} of {room}", bytes(&maps));
            let finest = maps.iter().map(ShadowMap::resolution).max().expect("maps");
            assert!(said.is_some_and(|said| said.drawn == finest && said.room == room), "{said:?}");
        }
        let (asked, said) = draw(Some(512), bytes(&wanted));
        assert!(said.is_none() && asked.iter().all(|map| map.resolution() == 512));
        for (resolution, room) in [(Some(512), 1000), (None, 10)] {
            let refused = plan.maps(&scene, receivers, resolution, room);
            assert!(matches!(refused, Err(RenderError::MapRoom { .. })), "{refused:?}");
        }
    }
}
