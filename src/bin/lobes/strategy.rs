//! Which strategy each object's shadow takes, and the visibility that this makes.

use crate::args::Visibility;
use crate::device::{Backend, Shader};
use crate::failure::Failure;
use cosine_lobes::lighting::{Blockers, MaskVisibility, Mixture, PaperVisibility};
use cosine_lobes::lobe_core::paper::Tables;
use cosine_lobes::lobe_core::{Method, Unshadowed};
use cosine_lobes::render_cpu::{CpuShader, RayBlockers, SceneSilhouettes, SphereSource, SurfaceHits, World};
use cosine_lobes::scene::{BlockerSet, Object, Proxy, Scene, Shape, Strategy};
use cosine_lobes::visibility_shadowmap::{Bounds, MapError, MapOptions, ShadowMap, ShadowMapBlockers};
use cosine_lobes::visibility_silhouettes::SilhouetteBlockers;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;
use rayon::prelude::*;

/// The finest map that is taken unless asked for.
const FITTED: u32 = 2048;

/// One strategy for each object; [`Strategy::None`] for those that block nothing.
pub(crate) struct Plan {
    objects: Vec<Strategy>,
}

impl Plan {
    /// One strategy for all objects, or each object's own.
    pub(crate) fn new(word: Visibility, scene: &Scene) -> Self {
        let of = |o: &Object| {
            // Exact, unless spheres are there already.
            let usual = match (&o.proxy, &o.shape) {
                (Proxy::Count(_), Shape::Mesh(_)) => Strategy::Silhouettes,
                _ => Strategy::Spheres,
            };
            let strategy = word.strategy().or(o.strategy).unwrap_or(usual);
            let blocks = match strategy {
                Strategy::Spheres => o.proxy != Proxy::None,
                // The true geometry also of things that nobody gave a proxy.
                Strategy::ShadowMap | Strategy::Silhouettes | Strategy::Rays => o.visible || o.proxy != Proxy::None,
                Strategy::None => false,
            };
            if blocks { strategy } else { Strategy::None }
        };
        Self { objects: scene.objects.iter().map(of).collect() }
    }

    /// The strategy of an object.
    pub(crate) fn of(&self, object: usize) -> Strategy {
        self.objects[object]
    }

    /// Whether an object is by rays.
    pub(crate) fn traces(&self, object: u32) -> bool {
        self.of(object as usize) == Strategy::Rays
    }

    /// Whether an object is by rays on a GPU: meshes by silhouettes are, too.
    pub(crate) fn traces_on_gpu(&self, scene: &Scene, object: u32) -> bool {
        self.traces(object) || self.by_silhouettes(scene, object)
    }

    /// Whether any object takes this strategy.
    pub(crate) fn uses(&self, strategy: Strategy) -> bool {
        self.objects.contains(&strategy)
    }

    /// The spheres that an object blocks with: those of its proxy, or the balls that it is. Maps and silhouettes have triangles
    /// only, so the balls of an object by them are spheres.
    pub(crate) fn spheres(&self, scene: &Scene, object: usize) -> SphereSource {
        match (self.objects[object], &scene.objects[object].shape) {
            (Strategy::Spheres, _) => SphereSource::Proxy,
            (Strategy::ShadowMap | Strategy::Silhouettes, Shape::Spheres(_)) => SphereSource::Shape,
            _ => SphereSource::Nothing,
        }
    }

    /// For each object whether it blocks by its true surface, as rays and maps see it, and not by spheres.
    pub(crate) fn by_surfaces(&self, scene: &Scene) -> Vec<bool> {
        let by_surface =
            |o| self.objects[o] == Strategy::Rays || self.in_maps(scene, o) || self.by_silhouettes(scene, o as u32);
        (0..self.objects.len()).map(by_surface).collect()
    }

    /// Whether an object's triangles block by their silhouettes.
    pub(crate) fn by_silhouettes(&self, scene: &Scene, object: u32) -> bool {
        let o = object as usize;
        self.objects[o] == Strategy::Silhouettes && matches!(scene.objects[o].shape, Shape::Mesh(_))
    }

    /// Whether an object's triangles are in the shadow maps.
    fn in_maps(&self, scene: &Scene, object: usize) -> bool {
        self.objects[object] == Strategy::ShadowMap && matches!(scene.objects[object].shape, Shape::Mesh(_))
    }

    /// Whether there are any triangles for shadow maps.
    pub(crate) fn wants_maps(&self, scene: &Scene) -> bool {
        (0..self.objects.len()).any(|o| self.in_maps(scene, o))
    }

    /// Bytes that the maps of all lights take at most, where each is one picture and none is asked to be finer: 32 a texel,
    /// 8 of each of four layers.
    pub(crate) fn most_map_bytes(&self, scene: &Scene) -> u64 {
        if self.wants_maps(scene) { scene.lights.len() as u64 * u64::from(FITTED).pow(2) * 32 } else { 0 }
    }

    /// A map for each light, for receivers in `bounds`; `resolution` as asked for, else as each light requires and as has room
    /// in so many bytes of the device. What is said where that makes them coarser.
    pub(crate) fn maps(
        &self,
        scene: &Scene,
        receivers: Bounds,
        resolution: Option<u32>,
        room: u64,
    ) -> Result<(Vec<ShadowMap>, Option<String>), MapError> {
        let (mut positions, mut triangles) = (Vec::<Vec3>::new(), Vec::<[u32; 3]>::new());
        for (_, object) in scene.objects.iter().enumerate().filter(|(o, _)| self.in_maps(scene, *o)) {
            if let Shape::Mesh(mesh) = &object.shape {
                let first = positions.len() as u32;
                positions.extend_from_slice(&mesh.positions);
                triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first)));
            }
        }
        let options = MapOptions { receivers: Some(receivers), ..MapOptions::default() };
        let draw = |finest: u32| -> Result<Vec<ShadowMap>, MapError> {
            let map = |light| match resolution {
                Some(resolution) => {
                    ShadowMap::build(&positions, &triangles, light, &MapOptions { resolution, ..options })
                }
                None => ShadowMap::fitted(&positions, &triangles, light, &MapOptions { resolution: finest, ..options }),
            };
            scene.lights.par_iter().map(|l| map(l.ball)).collect()
        };
        let mut maps = draw(FITTED)?;
        // Which objects cast comes before them.
        let bytes = |maps: &[ShadowMap]| {
            maps.iter().map(ShadowMap::packed_bytes).sum::<u64>() + 4 * (1 + self.objects.len().div_ceil(32)) as u64
        };
        let finest = |maps: &[ShadowMap]| maps.iter().map(ShadowMap::resolution).max().unwrap_or(0);
        let (wanted, needed) = (finest(&maps), bytes(&maps));
        let mut most = wanted;
        // What is asked for is not changed: the device refuses it.
        while resolution.is_none() && bytes(&maps) > room && most > MapOptions::MIN_RESOLUTION {
            let share = (room as f64 / bytes(&maps) as f64).sqrt().min(0.95);
            most = ((f64::from(most) * share) as u32).max(MapOptions::MIN_RESOLUTION);
            maps = draw(most)?;
        }
        let megabytes = |bytes: u64| bytes.div_ceil(1_000_000);
        let coarser = (most < wanted).then(|| {
            let (needed, room) = (megabytes(needed), room / 1_000_000);
            format!(
                "shadow maps of {wanted}² texels take {needed} MB, the GPU has room for {room} MB: drawn with {}², so penumbrae are \
                 less exact",
                finest(&maps)
            )
        });
        Ok((maps, coarser))
    }
}

/// The spheres of the frames that follow each other, under one hierarchy.
#[derive(Default)]
pub(crate) struct KeptSpheres {
    blockers: Option<SphereBlockers>,
    objects: Vec<u32>,
}

impl KeptSpheres {
    /// Takes over the spheres of the next frame. The hierarchy is refitted as long as they are the same ones.
    pub(crate) fn update(&mut self, set: &BlockerSet) {
        let old = self.blockers.take().filter(|_| self.objects == set.objects);
        self.objects.clone_from(&set.objects);
        self.blockers = (!set.spheres.is_empty()).then(|| {
            let blockers = match old {
                Some(mut blockers) => {
                    blockers.update(&set.spheres);
                    blockers
                }
                None => SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances),
            };
            blockers.with_self_shadows(&set.self_shadows)
        });
    }

    /// What blocks, where there is anything.
    pub(crate) fn get(&self) -> Option<&SphereBlockers> {
        self.blockers.as_ref()
    }
}

/// What blocks light in one frame, by strategy.
pub(crate) struct Occlusion<'a> {
    plan: &'a Plan,
    world: &'a World<'a>,
    spheres: Option<&'a SphereBlockers>,
    maps: Option<ShadowMapBlockers>,
    silhouettes: Option<SilhouetteBlockers<'a, SurfaceHits<'a>>>,
    rays: Option<RayBlockers<'a>>,
}

impl<'a> Occlusion<'a> {
    /// Gathers what the plan asks for, for pictures of a tolerance, and leaves out what turned out empty.
    pub(crate) fn new(
        plan: &'a Plan,
        world: &'a World<'a>,
        spheres: Option<&'a SphereBlockers>,
        mut maps: Vec<ShadowMap>,
        silhouettes: &'a SceneSilhouettes,
        tolerance: f32,
    ) -> Self {
        maps.retain(|map| map.faces() > 0);
        let all = plan.objects.iter().all(|s| *s == Strategy::Rays);
        let rays = plan.uses(Strategy::Rays).then(|| match all {
            true => RayBlockers::new(world),
            false => RayBlockers::new(world).only(|o| plan.traces(o)),
        });
        let maps = (!maps.is_empty()).then(|| {
            let scene = world.scene();
            let casters = (0..scene.objects.len()).map(|o| plan.in_maps(scene, o));
            ShadowMapBlockers::new(maps).with_casters(casters.collect())
        });
        let meshes = silhouettes.meshes();
        let silhouettes = (!meshes.is_empty()).then(|| {
            let hits = SurfaceHits::new(world, |o| plan.by_silhouettes(world.scene(), o));
            SilhouetteBlockers::new(meshes, hits).with_tolerance(tolerance)
        });
        Self { plan, world, spheres, maps, silhouettes, rays }
    }

    /// Does the work with the shader that these blockers make by the paper's method, where its tables are given, or by
    /// moments. What is not there is not in the shader; mixtures of any kinds share one.
    pub(crate) fn shade<W: Work>(
        self,
        backend: &mut Backend,
        depth: u32,
        tables: Option<&Tables>,
        work: W,
    ) -> Result<W::Output, Failure> {
        if let Backend::Gpu(gpu) = backend {
            // What is exact by silhouettes is exact by rays, which a GPU has.
            let traces = self.rays.is_some() || self.silhouettes.is_some();
            let traced = traces.then(|| (self.world.scene(), self.plan));
            let method = tables.map_or(Method::Moments, Method::Paper);
            return work.with(gpu.occluded(method, self.spheres, self.maps.as_ref(), traced)?);
        }
        match (self.spheres, self.maps, self.silhouettes, self.rays) {
            (None, None, None, None) => {
                work.with(&mut CpuShader::with_method(Unshadowed, tables.map_or(Method::Moments, Method::Paper)))
            }
            (Some(spheres), None, None, None) => masked(spheres, depth, tables, work),
            (None, None, Some(silhouettes), None) => masked(silhouettes, depth, tables, work),
            (spheres, maps, silhouettes, rays) => {
                let triangles = Mixture::new(silhouettes, Mixture::new(maps, rays));
                masked(Mixture::new(spheres, triangles), depth, tables, work)
            }
        }
    }
}

/// Something to be done with a shader of whatever device and visibility.
pub(crate) trait Work {
    /// What comes of it.
    type Output;

    /// Does it.
    fn with<S: Shader>(self, shader: &mut S) -> Result<Self::Output, Failure>;
}

fn masked<B: Blockers, W: Work>(
    blockers: B,
    depth: u32,
    tables: Option<&Tables>,
    work: W,
) -> Result<W::Output, Failure> {
    match tables {
        None => work.with(&mut CpuShader::new(MaskVisibility::new(blockers, depth))),
        Some(tables) => {
            let visibility = PaperVisibility::new(blockers, depth, tables);
            work.with(&mut CpuShader::with_method(visibility, Method::Paper(tables)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_room_unless_their_resolution_is_asked_for() {
        let scene = cosine_lobes::scene::builtin();
        let plan = Plan::new(Visibility::ShadowMap, &scene);
        let receivers = Bounds { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 2.0, 3.0) };
        let bytes = |maps: &[ShadowMap]| maps.iter().map(ShadowMap::packed_bytes).sum::<u64>();
        let draw = |resolution, room| plan.maps(&scene, receivers, resolution, room).expect("maps");
        let (wanted, said) = draw(None, u64::MAX);
        assert_eq!((wanted.len(), said), (scene.lights.len(), None));
        for share in [2, 100] {
            let room = bytes(&wanted) / share;
            let (maps, said) = draw(None, room);
            assert!(bytes(&maps) <= room && 4 * bytes(&maps) > room, "{} of {room}", bytes(&maps));
            let finest = maps.iter().map(ShadowMap::resolution).max().expect("maps");
            assert!(said.as_ref().is_some_and(|said| said.contains(&format!("drawn with {finest}²"))), "{said:?}");
        }
        let (asked, said) = draw(Some(512), 1000);
        assert!(bytes(&asked) > 1000 && said.is_none() && asked.iter().all(|map| map.resolution() == 512));
    }
}
