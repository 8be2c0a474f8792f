//! The same picture from CPU and GPU.

use crate::call::trial;
use crate::gbuffer::large_floor;
use brdf::{
    HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, ModifiedPhong, Neumann,
    Phong,
};
use glam::{Affine2, Vec2, Vec3};
use libtest_mimic::Trial;
use lighting::{EnclosedLight, Light, SphereLight, SpotLight, SunLight};
use lobe_core::{Receiver, Sphere};
use render_cpu::{CpuShader, GBuffer, World, blockers};
use render_gpu::{Gpu, GpuShader, Occlusion};
use scene::{
    Channel, Counts, Encoding, Frame, Mesh, Object, Proxy, Scene, Shade, ShadingPoints, Shape, Surface, Texture,
    TextureMap,
};
use shading::{Accuracy, Coverage, LightLobes, Unshadowed, Visibility};
use std::ops::ControlFlow;
use test_scenes::globe;
use visibility_mask::{LookAgain, MaskVisibility, Mixture, facet_coverage};
use visibility_shadowmap::{MapOptions, ReceiverBounds, ShadowMap, ShadowMapBlockers};
use visibility_spheres::SphereBlockers;

/// Largest and mean difference, relative to the picture's largest value.
const LARGEST: f32 = 1e-3;
const MEAN: f64 = 1e-5;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("parity_without_blockers", gpu, without_blockers),
        trial("parity_of_materials", gpu, of_materials),
        trial("parity_of_textures", gpu, of_textures),
        trial("parity_of_brushed_metal", gpu, of_brushed_metal),
        trial("parity_of_depths_and_tolerances", gpu, of_depths_and_tolerances),
        trial("parity_of_many_lights", gpu, of_many_lights),
        trial("parity_of_spots_and_suns", gpu, of_spots_and_suns),
        trial("parity_of_wide_lights", gpu, of_wide_lights),
        trial("parity_of_shadow_maps", gpu, of_shadow_maps),
        trial("parity_at_terminators_of_spheres", gpu, at_terminators_of_spheres),
        trial("maps_that_change_and_maps_that_stay", gpu, maps_that_change),
        trial("slices_change_nothing", gpu, slices_change_nothing),
        trial("two_runs_give_the_same_bits", gpu, two_runs_give_the_same_bits),
    ]
}

/// A scene, its visible points, and its blockers.
pub(crate) struct View {
    pub(crate) scene: Scene,
    pub(crate) points: ShadingPoints,
    pub(crate) spheres: SphereBlockers,
}

impl View {
    pub(crate) fn new(mut scene: Scene, width: u32, height: u32) -> Self {
        let GBuffer { points, materials, .. } = GBuffer::new(&World::new(&scene), width, height, 1);
        // Points with textures have materials of their own.
        scene.materials = materials;
        let set = blockers(&scene, &mut |_, _| ControlFlow::Continue(())).expect("exact spheres");
        let spheres = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
        let spheres = spheres.with_self_shadows(&set.self_shadows);
        Self { scene, points, spheres }
    }

    pub(crate) fn frame(&self, tolerance: f32, depth: u32) -> Frame<'_> {
        Frame::new(&self.scene.materials, &self.scene.lights, Accuracy { tolerance, depth })
    }

    /// Shadow maps of the meshes.
    pub(crate) fn maps(&self) -> ShadowMapBlockers {
        let mut all = Mesh::default();
        for object in &self.scene.objects {
            if let Shape::Mesh(mesh) = &object.shape {
                all.append(mesh);
            }
        }
        let receivers = ReceiverBounds::of(self.points.receivers.iter().map(|r| r.position));
        let options = MapOptions { resolution: 256, receivers, ..MapOptions::default() };
        let map = |l: &Light| {
            ShadowMap::fitted(&all.positions, &all.triangles, l.sphere().expect("a sphere"), &options).expect("a map")
        };
        let casters = self.scene.objects.iter().map(|o| matches!(o.shape, Shape::Mesh(_))).collect();
        ShadowMapBlockers::new(self.scene.lights.iter().map(map).collect()).with_casters(casters)
    }

    /// By the CPU, a few lights at once: all of them are queried then, as on a GPU.
    pub(crate) fn cpu(&self, visibility: impl Visibility, frame: &Frame<'_>) -> (Vec<Vec3>, Counts) {
        let mut sum = (vec![Vec3::ZERO; self.points.receivers.len()], Counts::default());
        let (mut out, mut shader) = (sum.0.clone(), CpuShader::new(visibility));
        for lights in frame.lights.chunks(7) {
            let stats = shader.shade(&self.points, &Frame { lights, ..*frame }, &mut out).expect("room for all lobes");
            sum.0.iter_mut().zip(&out).for_each(|(sum, out)| *sum += *out);
            sum.1 += stats.counts;
        }
        sum
    }

    pub(crate) fn gpu(&self, shader: &mut GpuShader, frame: &Frame<'_>) -> (Vec<Vec3>, Counts) {
        let mut out = vec![Vec3::NAN; self.points.receivers.len()];
        let stats = shader.shade(&self.points, frame, &mut out).expect("the GPU shades");
        (out, stats.counts)
    }

    /// With the spheres as blockers on both devices.
    pub(crate) fn compare_spheres(&self, gpu: &Gpu, name: &str, tolerance: f32, depth: u32) {
        let others = 1 + self.points.receivers.len() as u64 / 2000;
        self.compare_spheres_but(gpu, name, [tolerance, LARGEST], depth, others);
    }

    /// The same with another largest difference, and another number of points that change class.
    pub(crate) fn compare_spheres_but(
        &self,
        gpu: &Gpu,
        name: &str,
        [tolerance, most]: [f32; 2],
        depth: u32,
        others: u64,
    ) {
        let frame = self.frame(tolerance, depth);
        let want = self.cpu(MaskVisibility::new(self.spheres.clone()).look_again(LookAgain::Never), &frame);
        let occlusion = Occlusion { blockers: &[&self.spheres], any_hit: None };
        let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
        assert_same_but(name, &want, &self.gpu(&mut shader, &frame), most, others);
    }
}

/// Self-shadowing by facets for points whose object has a sphere, here the second of three objects, and for no others.
fn at_terminators_of_spheres(gpu: &Gpu) {
    let mut scene = large_floor(8.0);
    for (x, name) in [(-0.5, "globe"), (0.7, "bare globe")] {
        let globe = globe(14, Vec3::new(x, 0.3, 0.0), 0.5, true);
        scene.objects.push(Object::mesh(name, globe, 0, Proxy::Count(8)));
    }
    scene.lights[0].as_sphere_mut().expect("a sphere").sphere.radius = 1.2;
    let points = GBuffer::new(&World::new(&scene), 80, 60, 1).points;
    let sphere = |x: f32| Sphere { center: Vec3::new(x, 0.3, 0.0), radius: 0.47 };
    let spheres = SphereBlockers::new(&[sphere(-0.5), sphere(4.0)], &[1, 3], &[0.0, 0.3]);
    let cut = |object: u32| {
        let is_clipped =
            |at: &&Receiver| at.object == object && facet_coverage(at, &scene.lights[0].cone(at)) == Coverage::Partial;
        points.receivers.iter().filter(is_clipped).count()
    };
    let counts = [cut(1), cut(2)];
    assert!(counts.iter().all(|n| *n > 50), "{counts:?}");
    View { scene, points, spheres }.compare_spheres(gpu, "terminators of spheres", 0.003, 5);
}

/// Pictures agree to the stated differences, and so do the counts of each class, but for some points at a class's limit.
pub(crate) fn assert_same(name: &str, want: &(Vec<Vec3>, Counts), got: &(Vec<Vec3>, Counts)) {
    assert_same_but(name, want, got, LARGEST, 1 + want.0.len() as u64 / 2000);
}

/// The same with another largest difference, and another number of points that change class.
fn assert_same_but(name: &str, want: &(Vec<Vec3>, Counts), got: &(Vec<Vec3>, Counts), most: f32, others: u64) {
    let peak = want.0.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let (mut largest, mut sum, mut place) = (0.0_f32, 0.0, 0);
    for (i, (want, got)) in want.0.iter().zip(&got.0).enumerate() {
        assert!(got.is_finite(), "{name}: point {i} is {got}");
        let difference = (*got - *want).abs().max_element() / peak;
        sum += f64::from(difference);
        if difference > largest {
            (largest, place) = (difference, i);
        }
    }
    let mean = sum / want.0.len() as f64;
    let (w, g) = (want.1, got.1);
    println!(
        "{name}: largest {largest:.1e} (point {place}), mean {mean:.1e}; lit {} {}, dark {} {}, penumbra {} {}, integrals {} {}, pruned {} {}",
        w.lit_points,
        g.lit_points,
        w.dark_points,
        g.dark_points,
        w.penumbra_points,
        g.penumbra_points,
        w.integrals,
        g.integrals,
        w.pruned,
        g.pruned
    );
    assert!(peak > 0.0, "{name}: nothing is lit");
    assert!(largest <= most && mean <= MEAN, "{name}: largest {largest:.2e} at point {place}, mean {mean:.2e}");
    // Points whose coverage is within rounding of a limit may change their class.
    let apart = |a: u64, b: u64| assert!(a.abs_diff(b) <= others, "{name}: {w:?} {g:?}");
    apart(w.lit_points, g.lit_points);
    apart(w.dark_points, g.dark_points);
    apart(w.penumbra_points, g.penumbra_points);
    assert_eq!((w.integrals, w.pruned), (g.integrals, g.pruned), "{name}");
}

/// The built-in scene without its texture: points use the scene's own materials.
pub(crate) fn plain() -> Scene {
    Scene { surfaces: Vec::new(), ..scene::builtin() }
}

fn builtin() -> View {
    View::new(scene::builtin(), 96, 54)
}

/// One material a point, of every model.
fn of_textures(gpu: &Gpu) {
    let texel = |i: u32| [(40 + 7 * i % 215) as u8, (90 + i % 160) as u8, (i * 50 % 256) as u8, 255];
    let texture = Texture::new("texels", [32, 32], (0..32 * 32).map(texel).collect(), Encoding::Linear);
    let map = TextureMap { transform: Affine2::from_scale(Vec2::splat(5.0)), ..TextureMap::new(texture) };
    let channel = |index| Some(Channel { map: map.clone(), index });
    let surface = Surface {
        color: Some(map.clone()),
        specular: Some(map.clone()),
        exponent: channel(1),
        metallic: channel(2),
        roughness: channel(1),
        normal: Some((map.clone(), 0.3)),
        ..Surface::default()
    };
    let (kd, ks) = (Vec3::splat(0.7), Vec3::splat(0.3));
    let lobe = LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 1.0), 20.0, ks);
    let materials: [Material; 4] = [
        Lambert { albedo: kd }.into(),
        ModifiedPhong { kd, ks, exponent: 60.0 }.into(),
        Lafortune { diffuse: kd, lobes: vec![lobe] }.into(),
        MetallicRoughness::new(Vec3::ONE, 1.0, 1.0).expect("in range").into(),
    ];
    for material in materials {
        let mut scene = scene::builtin();
        let name = format!("textures on {}", material.name());
        scene.materials[0] = material;
        scene.surfaces = vec![surface.clone()];
        View::new(scene, 96, 54).compare_spheres(gpu, &name, 0.003, 5);
    }
}

/// Directions and strengths from a texture, on a floor and on spheres.
fn of_brushed_metal(gpu: &Gpu) {
    let texel = |i: u32| [(40 + 7 * i % 215) as u8, (90 + i % 160) as u8, (128 + i * 50 % 128) as u8, 255];
    let texture = Texture::new("grain", [32, 32], (0..32 * 32).map(texel).collect(), Encoding::Linear);
    let map = TextureMap { transform: Affine2::from_scale(Vec2::splat(0.3)), ..TextureMap::new(texture) };
    let metal = MetallicRoughness::new(Vec3::new(0.9, 0.7, 0.5), 0.8, 0.35).and_then(|m| m.with_anisotropy(0.8));
    let mut scene = scene::builtin();
    scene.materials.fill(metal.expect("in range").into());
    let surface = Surface { anisotropy: Some(map), anisotropy_turn: 0.4, follows_u: true, ..Surface::default() };
    scene.surfaces = vec![surface; scene.materials.len()];
    View::new(scene, 96, 54).compare_spheres(gpu, "brushed metal", 0.003, 5);
}

fn without_blockers(gpu: &Gpu) {
    let view = builtin();
    let frame = view.frame(0.003, 5);
    let want = view.cpu(Unshadowed, &frame);
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("a shader");
    assert_same("unshadowed", &want, &view.gpu(&mut shader, &frame));
}

/// The built-in scene with all objects of one model.
fn of_materials(gpu: &Gpu) {
    let kd = Vec3::new(0.5, 0.4, 0.3);
    let shiny = LafortuneLobe::diagonal(Vec3::new(-0.9, -0.8, 0.95), 30.0, Vec3::splat(0.3));
    let retro = LafortuneLobe::diagonal(Vec3::new(0.7, 0.7, 0.6), 6.0, Vec3::new(0.2, 0.1, 0.1));
    let [fine, broad] = [0.25, 0.6].map(|roughness| HalfVectorLobe::new(roughness, 0.4 * kd, Vec3::splat(0.4)));
    let varnish = MetallicRoughness::new(kd, 0.0, 0.6).and_then(|below| below.with_clearcoat(1.0, 0.2));
    // A kernel has the models that its frame's materials need.
    let lobes: [Material; 7] = [
        Phong { kd, ks: Vec3::splat(0.3), exponent: 40.0 }.into(),
        ModifiedPhong { kd, ks: Vec3::splat(0.4), exponent: 10.0 }.into(),
        ModifiedPhong { kd, ks: Vec3::splat(0.4), exponent: 800.0 }.into(),
        ModifiedPhong { kd, ks: Vec3::splat(0.4), exponent: 0.5 }.into(),
        Neumann { kd: Vec3::ZERO, ks: kd, exponent: 40.0 }.into(),
        HalfVector { diffuse: 0.2 * kd, lobes: vec![fine, broad] }.into(),
        Lafortune { diffuse: kd, lobes: vec![shiny, retro] }.into(),
    ];
    let metals: [Material; 2] = [
        MetallicRoughness::new(kd, 1.0, 0.4).expect("in range").into(),
        MetallicRoughness::new(kd, 0.0, 0.15).expect("in range").into(),
    ];
    let mut view = builtin();
    let places = view.scene.materials.len();
    let mut compare = |name: &str, materials: &[Material]| {
        // Each on each object once, and all in each frame, so that one kernel serves them.
        for first in 0..materials.len() {
            let turned = materials.iter().cycle().skip(first);
            view.scene.materials = turned.take(places.max(materials.len())).cloned().collect();
            view.compare_spheres(gpu, &format!("{name} {first}"), 0.003, 5);
        }
    };
    compare("lambert", &[Lambert { albedo: kd }.into()]);
    compare("lobes", &lobes);
    compare("metals", &metals);
    compare("varnish", &[varnish.expect("in range").into()]);
}

fn of_depths_and_tolerances(gpu: &Gpu) {
    let view = builtin();
    for (depth, tolerance) in [(3, 0.003), (4, 0.003), (6, 0.001), (3, 0.01), (4, 0.01), (5, 0.006), (6, 0.01)] {
        view.compare_spheres(gpu, &format!("depth {depth}, tolerance {tolerance}"), tolerance, depth);
    }
}

fn of_many_lights(gpu: &Gpu) {
    let mut view = builtin();
    for count in [1, 4, 16] {
        let light = |k: u32| {
            let turn = 2.4 * k as f32;
            let center = Vec3::new(4.0 * turn.cos(), 2.5 + 0.3 * k as f32, 2.0 + 3.0 * turn.sin());
            SphereLight::new(Sphere { center, radius: 0.1 + 0.05 * k as f32 }, Vec3::splat(20.0)).into()
        };
        view.scene.lights = (0..count).map(light).collect();
        view.compare_spheres(gpu, &format!("{count} lights"), 0.003, 5);
    }
}

/// Spots, suns and lamps, alone and beside sphere lights.
fn of_spots_and_suns(gpu: &Gpu) {
    let mut view = builtin();
    let lamp = |radius| Sphere { center: Vec3::new(1.5, 4.0, 2.0), radius };
    let world = Sphere { center: Vec3::Y, radius: 12.0 };
    let sphere: Light = SphereLight::new(lamp(0.4), Vec3::splat(20.0)).into();
    let light = SphereLight::with_intensity(lamp(0.2), Vec3::splat(60.0));
    let axis = Vec3::new(-0.4, -1.0, -0.5).normalize();
    let spot: Light = SpotLight { light, axis, cos: [0.95, 0.8], range: 7.0 }.into();
    let toward = Vec3::new(-0.5, 0.8, 0.4).normalize();
    let sun = |degrees| SunLight::new(toward, degrees, Vec3::new(2.0, 1.8, 1.5), world).into();
    // A spot next to the floor, which it does not light if it belongs to that object.
    let near = SphereLight::new(Sphere { center: Vec3::new(0.5, 0.3, 1.5), radius: 0.2 }, Vec3::splat(20.0));
    let inside = |object| EnclosedLight { light: Box::new(near.into()), object }.into();
    for (name, lights) in [
        ("a spot", vec![spot.clone()]),
        ("a sun", vec![sun(3.0)]),
        ("a lamp of object 0", vec![inside(0)]),
        ("a lamp of object 1", vec![inside(1)]),
        ("all", vec![sphere, spot, sun(0.3), inside(1)]),
    ] {
        view.scene.lights = lights;
        view.compare_spheres(gpu, name, 0.003, 5);
    }
}

/// Lights of 62° to 84°, low above a floor of all materials. Masks are deeper from 65° on, and once more from 79° on.
fn of_wide_lights(gpu: &Gpu) {
    let mut scene = large_floor(4.0);
    scene.materials = scene::builtin().materials;
    let mut points = GBuffer::new(&World::new(&scene), 64, 48, 1).points;
    let models = scene.materials.len() as u32;
    (0..).zip(&mut points.materials).for_each(|(k, material)| *material = k % models);
    let normal = points.receivers[0].face;
    let (u, v) = normal.any_orthonormal_pair();
    let radius = 4.0;
    let mote = |k: u32| {
        let [x, y, z] = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|step: f64| (f64::from(k) * step).fract() as f32);
        let aside = u * (3.0 * x - 1.5) + v * (3.0 * y - 1.5);
        Sphere { center: aside + normal * (0.005 + 0.01 * z), radius: 0.002 + 0.03 * z * z }
    };
    let motes: Vec<Sphere> = (0..60).map(mote).collect();
    let spheres = SphereBlockers::new(&motes, &vec![99; motes.len()], &[]);
    let mut view = View { scene, points, spheres };
    for (tolerance, depth) in [(0.003, 5), (0.01, 4)] {
        for height in [0.5, 0.02] {
            let sphere = Sphere { center: normal * (radius + height), radius };
            view.scene.lights = vec![SphereLight::new(sphere, Vec3::ONE).into()];
            let angles = view.points.receivers.iter().map(|at| (radius / at.position.distance(sphere.center)).asin());
            let [least, most] = angles.fold([9.0, 0.0_f32], |[a, b], x| [x.min(a), x.max(b)]).map(f32::to_degrees);
            assert!(most < 86.0 && (least < 65.0 || most > 79.0), "{least}° to {most}°");
            let name = format!("lights of {least:.0}° to {most:.0}°, tolerance {tolerance}");
            let frame = view.frame(tolerance, depth);
            let want = view.cpu(MaskVisibility::new(view.spheres.clone()).look_again(LookAgain::Never), &frame);
            let occlusion = Occlusion { blockers: &[&view.spheres], any_hit: None };
            let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
            // In the middle of the widest light one sample, which rounding decides, is 0.4 % of it. A light at the horizon, of
            // which 1e-5 is visible, decides whether a point is lit.
            let others = view.points.receivers.len() as u64 / 30;
            assert_same_but(&name, &want, &view.gpu(&mut shader, &frame), 5e-3, others);
        }
    }
}

/// The built-in scene's meshes by shadow maps, alone and with the spheres by sphere blockers.
fn of_shadow_maps(gpu: &Gpu) {
    let view = builtin();
    let maps = view.maps();
    for (tolerance, depth) in [(0.003, 5), (0.01, 4)] {
        let frame = view.frame(tolerance, depth);
        let want = view.cpu(MaskVisibility::new(maps.clone()).look_again(LookAgain::Never), &frame);
        let occlusion = Occlusion { blockers: &[&maps.pack()], any_hit: None };
        let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
        assert_same(&format!("maps, depth {depth}"), &want, &view.gpu(&mut shader, &frame));

        let mixture = Mixture::new(maps.clone(), view.spheres.clone());
        let want = view.cpu(MaskVisibility::new(mixture).look_again(LookAgain::Never), &frame);
        let both = Occlusion { blockers: &[&view.spheres, &maps.pack()], any_hit: None };
        shader.occlude(both).expect("room for them");
        assert_same(&format!("maps and spheres, depth {depth}"), &want, &view.gpu(&mut shader, &frame));
    }
}

/// A light moves and gets another map; the other light keeps its map.
fn maps_that_change(gpu: &Gpu) {
    let mut view = View::new(scene::builtin(), 48, 27);
    let before = view.maps();
    let mut shader = GpuShader::new(gpu, Occlusion::of(&[&before.pack()])).expect("a shader");
    let first = view.gpu(&mut shader, &view.frame(0.003, 5));
    view.scene.lights[1].as_sphere_mut().expect("a sphere").sphere.center.x += 0.4;
    let casters = view.scene.objects.iter().map(|o| matches!(o.shape, Shape::Mesh(_))).collect();
    let maps = vec![before.maps()[0].clone(), view.maps().maps()[1].clone()];
    let after = ShadowMapBlockers::new(maps).with_casters(casters);
    let frame = view.frame(0.003, 5);
    let occlusion = Occlusion { blockers: &[&after.pack()], any_hit: None };
    shader.occlude(occlusion).expect("room for it");
    let got = view.gpu(&mut shader, &frame);
    assert_same(
        "a map that changed",
        &view.cpu(MaskVisibility::new(after.clone()).look_again(LookAgain::Never), &frame),
        &got,
    );
    assert!(got != first && got == view.gpu(&mut GpuShader::new(gpu, occlusion).expect("a shader"), &frame));
}

fn slices_change_nothing(gpu: &Gpu) {
    let view = builtin();
    let frame = view.frame(0.003, 5);
    let occlusion = Occlusion { blockers: &[&view.spheres], any_hit: None };
    let shader = || GpuShader::new(gpu, occlusion).expect("a shader");
    let whole = view.gpu(&mut shader(), &frame);
    let sliced = view.gpu(&mut shader().with_slice(500), &frame);
    assert_eq!(whole, sliced);
}

fn two_runs_give_the_same_bits(gpu: &Gpu) {
    let view = builtin();
    let frame = view.frame(0.003, 5);
    let occlusion = Occlusion { blockers: &[&view.spheres], any_hit: None };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
    let first = view.gpu(&mut shader, &frame);
    assert_eq!(first, view.gpu(&mut shader, &frame), "the same shader");
    let mut other = GpuShader::new(gpu, occlusion).expect("a shader");
    assert_eq!(first, view.gpu(&mut other, &frame), "another one");
}
