//! Surfaces with textures, vertex colours and emission: what the visible points make of them.

use brdf::{Brdf, Lafortune, LafortuneLobe, Material, MetallicRoughness, ModifiedPhong};
use core::sync::atomic::AtomicBool;
use glam::{Affine2, Mat2, Mat3, Vec2, Vec3};
use lighting::SphereLight;
use lobe_core::Sphere;
use ray_tracing::{GBuffer, World};
use reference::{Geometry, Reference, ReferenceJob};
use render_cpu::CpuShader;
use scene::{
    BlockerSet, Camera, Channel, Encoding, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, Shape, Surface,
    Texture, TextureMap,
};
use shading::Accuracy;
use visibility_mask::MaskVisibility;
use visibility_rays::RayBlockers;

/// A square floor of half edge 4, seen at an angle.
fn floor(material: Material, surface: Surface) -> Scene {
    let mesh = Mesh::quad(Vec3::ZERO, Vec3::X * 4.0, Vec3::NEG_Z * 4.0);
    Scene {
        camera: Camera {
            eye: Vec3::new(0.5, 2.0, 6.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::perspective(0.7),
        },
        width: 96,
        height: 64,
        materials: vec![material],
        surfaces: vec![surface],
        objects: vec![Object::mesh("floor", mesh, 0, Proxy::None)],
        lights: vec![
            SphereLight::new(Sphere { center: Vec3::new(1.0, 4.0, -1.0), radius: 0.5 }, Vec3::splat(20.0)).into(),
        ],
        ..Scene::default()
    }
}

fn sphere(center: Vec3, radius: f32) -> Object {
    Object::spheres("sphere", vec![Sphere { center, radius }], 0)
}

fn flat(texel: [u8; 4], encoding: Encoding) -> TextureMap {
    TextureMap::new(Texture::new("flat", [1, 1], vec![texel], encoding))
}

/// Squares of two greys.
fn checker(squares: u32) -> Texture {
    let texel = |i: u32| if (i / 64 / (64 / squares) + i % 64 / (64 / squares)).is_multiple_of(2) { 230 } else { 20 };
    let texels = (0..64 * 64).map(|i| [texel(i), texel(i), texel(i), 255]).collect();
    Texture::new("checker", [64, 64], texels, Encoding::Linear)
}

fn shade(scene: &Scene, g: &GBuffer) -> Vec<Vec3> {
    let world = World::new(scene);
    let frame = Frame::new(&g.materials, &scene.lights, Accuracy::new(0.003));
    let mut out = vec![Vec3::ZERO; g.len()];
    let mut shader = CpuShader::new(MaskVisibility::new(RayBlockers::new(&world)));
    shader.shade(&g.points, &frame, &mut out).expect("lobes have room");
    g.add_emission(&mut out);
    out
}

fn picture(scene: &Scene) -> Vec<Vec3> {
    shade(scene, &GBuffer::new(&World::new(scene), scene.width, scene.height, 1))
}

#[test]
fn a_texture_of_one_texel_is_the_plain_material() {
    let half = |x: u8| f32::from(x) / 255.0;
    let color = Vec3::new(half(200), half(100), half(50));
    let surface = Surface {
        color: Some(flat([200, 100, 50, 255], Encoding::Linear)),
        specular: Some(flat([255, 90, 30, 255], Encoding::Linear)),
        coat: Some(Channel { map: flat([0, 77, 128, 51], Encoding::Linear), index: 3 }),
        metallic: Some(Channel { map: flat([0, 77, 128, 255], Encoding::Linear), index: 2 }),
        roughness: Some(Channel { map: flat([0, 77, 128, 255], Encoding::Linear), index: 1 }),
        ..Surface::default()
    };
    let metal = |base, metallic, roughness| MetallicRoughness::new(base, metallic, roughness).expect("in range");
    let specular = Vec3::new(1.0, half(90), half(30));
    let coated = |f0, f90| metal(color, half(128), half(77)).with_coat(f0, f90).expect("in range");
    let gloss = |kd, ks, exponent| ModifiedPhong { kd, ks, exponent };
    let cases: [(Material, Material); 3] = [
        (Material::lambert(Vec3::ONE), Material::lambert(color)),
        (gloss(Vec3::ONE, Vec3::splat(0.3), 30.0).into(), gloss(color, 0.3 * specular, 30.0).into()),
        (metal(Vec3::ONE, 1.0, 1.0).into(), coated(0.04 * specular * half(51), half(51)).into()),
    ];
    for (textured, plain) in cases {
        let mut scene = floor(textured, surface.clone());
        scene.objects.push(sphere(Vec3::new(0.3, 0.6, 0.4), 0.6));
        let got = picture(&scene);
        scene.materials = vec![plain];
        scene.surfaces.clear();
        let want = picture(&scene);
        assert_eq!(got.len(), want.len());
        for (a, b) in got.iter().zip(&want) {
            assert!((*a - *b).abs().max_element() <= 1e-5 * b.max_element().max(0.1), "{a} {b}");
        }
    }
}

/// Against many rays a pixel of the texture as it is, filtered by one ray: the mean of the footprint.
#[test]
fn one_ray_sees_the_mean_of_its_pixel() {
    let map = TextureMap { transform: Affine2::from_scale(Vec2::splat(3.0)), ..TextureMap::new(checker(8)) };
    let scene = floor(Material::lambert(Vec3::ONE), Surface { color: Some(map), ..Surface::default() });
    let world = World::new(&scene);
    let picture = |samples| {
        let g = GBuffer::new(&world, scene.width, scene.height, samples);
        let albedo = |i: &u32| match &g.materials[*i as usize] {
            Material::Lambert(m) => m.albedo,
            _ => Vec3::NAN,
        };
        let values: Vec<Vec3> = g.points.materials.iter().map(albedo).collect();
        g.resolve(&values, Vec3::ZERO)
    };
    let (one, many) = (picture(1), picture(256));
    let inside: Vec<usize> = (0..one.len()).filter(|i| many[*i].x > 0.06).collect();
    let (mut sum, mut square) = (0.0, 0.0);
    for i in &inside {
        let d = f64::from(one[*i].x - many[*i].x);
        (sum, square) = (sum + d, square + d * d);
    }
    let n = inside.len() as f64;
    let (mean, rms) = (sum / n, (square / n).sqrt());
    println!("mean difference {mean:.4}, root mean square {rms:.4} of a contrast of 0.82");
    assert!(mean.abs() < 0.01 && rms < 0.1, "{mean} {rms}");
}

#[test]
fn windows_and_bands_have_the_same_points() {
    let surface = Surface { color: Some(TextureMap::new(checker(16))), ..Surface::default() };
    let mut scene = floor(Material::lambert(Vec3::ONE), surface);
    scene.materials.push(Material::lambert(Vec3::splat(0.3)));
    scene.objects.push(Object { material: 1, ..sphere(Vec3::new(0.3, 0.6, 0.4), 0.6) });
    let world = World::new(&scene);
    let whole = GBuffer::new(&world, 96, 64, 2);
    let all = shade(&scene, &whole);
    for (columns, rows) in [(0..96, 0..24), (0..96, 24..64), (13..71, 9..50)] {
        let part = GBuffer::window(&world, 96, 64, 2, columns.clone(), rows.clone());
        let values = part.resolve(&shade(&scene, &part), Vec3::ZERO);
        let want = whole.resolve(&all, Vec3::ZERO);
        for (y, row) in rows.clone().enumerate() {
            for (x, column) in columns.clone().enumerate() {
                let (a, b) = (values[y * columns.len() + x], want[(row * 96 + column) as usize]);
                assert_eq!(a, b, "{column} {row}");
            }
        }
    }
}

#[test]
fn normal_maps_turn_normals_in_the_frame_of_their_coordinates() {
    // 128 is 1/255 more than nothing.
    let level = [128, 128, 255, 255];
    // 45° along u.
    let along_u = [218, 128, 218, 255];
    let look = |texel, transform: Mat2, scale: f32, turned: bool| {
        let map = TextureMap { transform: Affine2::from_mat2(transform), ..flat(texel, Encoding::Linear) };
        let surface = Surface { normal: Some((map, scale)), ..Surface::default() };
        let mut scene = floor(Material::lambert(Vec3::ONE), surface);
        if turned {
            // The mesh wound the other way: the same surface, seen from its back.
            let Shape::Mesh(mesh) = &mut scene.objects[0].shape else { unreachable!() };
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let g = GBuffer::new(&World::new(&scene), 96, 64, 1);
        g.points.receivers[g.len() / 2]
    };
    let (one, near) = (Mat2::IDENTITY, |a: Vec3, b: Vec3| (a - b).length() < 0.012);
    let flat = look(level, one, 1.0, false);
    assert!(near(flat.normal, Vec3::Y), "{}", flat.normal);
    // The floor's u grows along x, its v along z.
    let leaning = Vec3::new(1.0, 1.0, 0.0).normalize();
    assert!(near(look(along_u, one, 1.0, false).normal, leaning), "{}", look(along_u, one, 1.0, false).normal);
    assert!(near(look(along_u, one, 1.0, true).normal, leaning));
    assert!(near(look(along_u, one, 0.0, false).normal, Vec3::Y));
    // Mirrored coordinates lean the other way, turned ones across.
    let mirrored = Mat2::from_diagonal(Vec2::new(-1.0, 1.0));
    assert!(near(look(along_u, mirrored, 1.0, false).normal, Vec3::new(-1.0, 1.0, 0.0).normalize()));
    let quarter = look(along_u, Mat2::from_angle(-core::f32::consts::FRAC_PI_2), 1.0, false).normal;
    assert!(quarter.x.abs() < 0.012 && (quarter.z.abs() - leaning.x).abs() < 0.012, "{quarter}");
    // Green leans against growing v, up in the image; less of it toward the viewer.
    assert!(near(look([128, 38, 218, 255], one, 1.0, false).normal, Vec3::new(0.0, 1.0, 1.0).normalize()));
    for texel in [[0, 0, 0, 0], [127, 127, 127, 0], [255, 255, 0, 0], [0, 0, 255, 255]] {
        for (transform, scale) in [(Mat2::ZERO, 1.0), (one, 1e30), (one, f32::MAX), (Mat2::from_diagonal(Vec2::X), 1.0)]
        {
            let at = look(texel, transform, scale, false);
            assert!(
                (at.normal.length() - 1.0).abs() < 1e-3 && at.normal.dot(at.view) > 0.0,
                "{texel:?}: {}",
                at.normal
            );
        }
    }
}

/// On a sphere of coarse triangles a constant lean along u turns as smoothly as the normals do.
#[test]
fn tangents_are_smooth_where_normals_are() {
    let (rings, sides) = (8u32, 12u32);
    let mut mesh = Mesh { uv_sets: vec![Vec::new()], ..Mesh::default() };
    for i in 0..=rings {
        for k in 0..=sides {
            let (u, v) = (k as f32 / sides as f32, i as f32 / rings as f32);
            // Away from the poles, the seam behind.
            let ((s, c), (x, z)) = ((0.6 + 1.9 * v).sin_cos(), (core::f32::consts::TAU * (u + 0.5)).sin_cos());
            mesh.positions.push(Vec3::new(s * x, c, s * z));
            mesh.normals.push(Vec3::new(s * x, c, s * z));
            mesh.uv_sets[0].push(Vec2::new(u, v));
        }
    }
    for i in 0..rings {
        for k in 0..sides {
            let a = i * (sides + 1) + k;
            mesh.triangles.extend([[a, a + sides + 1, a + 1], [a + 1, a + sides + 1, a + sides + 2]]);
        }
    }
    let leaning = TextureMap { ..flat([190, 128, 230, 255], Encoding::Linear) };
    let surface = Surface { normal: Some((leaning, 1.0)), ..Surface::default() };
    let mut scene = floor(Material::lambert(Vec3::ONE), surface);
    scene.objects = vec![Object::mesh("sphere", mesh, 0, Proxy::None)];
    (scene.width, scene.height) = (240, 160);
    let g = GBuffer::new(&World::new(&scene), 240, 160, 1);
    let mut bare = scene.clone();
    bare.surfaces.clear();
    let plain = GBuffer::new(&World::new(&bare), 240, 160, 1);
    let mut worst = 0.0_f32;
    for i in 1..g.len() {
        let near = g.pixels[i] == g.pixels[i - 1] + 1;
        let [a, b] = [&g.points.receivers[i - 1], &g.points.receivers[i]];
        let [p, q] = [&plain.points.receivers[i - 1], &plain.points.receivers[i]];
        // Where nothing is bent back toward the eye.
        let seen = [a, b].iter().all(|at| at.normal.dot(at.view) > 0.1);
        // Not from one side of the sphere to the other, and not at the seam.
        if near && seen && p.normal.distance(q.normal) < 0.2 && a.position.z > 0.0 {
            let step = a.normal.distance(b.normal) - p.normal.distance(q.normal);
            worst = worst.max(step);
        }
    }
    // Without the vertices, by triangles alone: 0.2.
    println!("largest step beyond that of the normals: {worst:.4}");
    assert!(worst < 0.05, "{worst}");
}

/// A highlight longer along u than across: turned with the coordinates, whatever the normal's own frame.
#[test]
fn anisotropic_lobes_follow_the_texture() {
    let matrix = Mat3::from_diagonal(Vec3::new(-1.0, -0.6, 0.9));
    let brushed = Lafortune { diffuse: Vec3::ZERO, lobes: vec![LafortuneLobe::new(matrix, 20.0, Vec3::ONE)] };
    let look = |degrees: f32| {
        let mut scene = floor(brushed.clone().into(), Surface { follows_u: true, ..Surface::default() });
        let Shape::Mesh(mesh) = &mut scene.objects[0].shape else { unreachable!() };
        let turn = Mat2::from_angle(degrees.to_radians());
        mesh.uv_sets[0].iter_mut().for_each(|uv| *uv = turn * *uv);
        let g = GBuffer::new(&World::new(&scene), 96, 64, 1);
        let i = g.len() / 2;
        (g.points.receivers[i], g.materials[g.points.materials[i] as usize].clone())
    };
    for degrees in [0.0_f32, 30.0, 90.0, 200.0] {
        let (at, material) = look(degrees);
        // The floor's u grows along x, its v along z: turned coordinates grow along this.
        let (s, c) = degrees.to_radians().sin_cos();
        let want = Material::from(brushed.turned(at.normal, Vec3::new(c, 0.0, -s)));
        for v in [Vec3::new(0.1, 0.9, -0.4), Vec3::new(0.5, 0.6, -0.3), Vec3::new(-0.4, 0.7, -0.5)] {
            let v = v.normalize();
            let (a, b) = (material.eval(&at, v), want.eval(&at, v));
            assert!((a - b).abs().max_element() < 1e-4 * b.max_element().max(0.01), "{degrees}: {a} {b}");
        }
    }
}

/// Brushed metal turns with its coordinates, by its own turn, and by its map.
#[test]
fn grain_follows_the_texture() {
    let metal = MetallicRoughness::new(Vec3::ONE, 1.0, 0.3).and_then(|m| m.with_anisotropy(0.8));
    let metal = Material::from(metal.expect("in range"));
    let look = |surface: Surface| {
        let scene = floor(metal.clone(), surface);
        let g = GBuffer::new(&World::new(&scene), 96, 64, 1);
        let i = g.len() / 2;
        (g.points.receivers[i], g.materials[g.points.materials[i] as usize].clone())
    };
    // The floor's u grows along x, its v along z: against growing v is −z.
    let map = || Some(flat([128, 255, 255, 255], Encoding::Linear));
    let plain = || Surface { follows_u: true, ..Surface::default() };
    for (surface, along) in [
        (plain(), Vec3::X),
        (Surface { anisotropy_turn: 0.5, ..plain() }, Vec3::new(0.5_f32.cos(), 0.0, -0.5_f32.sin())),
        // A byte has no 0 in its middle.
        (Surface { anisotropy: map(), ..plain() }, Vec3::new(1.0 / 255.0, 0.0, -1.0)),
    ] {
        let (at, got) = look(surface);
        let want = metal.turned(at.normal, along).expect("a grain");
        for v in [Vec3::new(0.1, 0.9, -0.4), Vec3::new(0.5, 0.6, -0.3), Vec3::new(-0.4, 0.7, -0.5)] {
            let v = v.normalize();
            let (a, b) = (got.eval(&at, v).x, want.eval(&at, v).x);
            assert!((a - b).abs() < 0.05 * b.max(0.01), "{along}: {a} {b}");
        }
    }
}

/// A clear coat keeps the mesh's normal below a normal map, unless it has a map of its own; and emission is below it.
#[test]
fn clear_coats_have_normals_of_their_own() {
    let tilted = || Some((flat([200, 128, 220, 255], Encoding::Linear), 1.0));
    let varnish = MetallicRoughness::new(Vec3::splat(0.5), 0.0, 0.5).and_then(|m| m.with_clearcoat(1.0, 0.3));
    let varnish = Material::from(varnish.expect("in range"));
    let look = |material: &Material, surface: Surface| {
        let scene = floor(material.clone(), surface);
        let g = GBuffer::new(&World::new(&scene), 96, 64, 1);
        let i = g.len() / 2;
        let number = g.points.materials[i] as usize;
        (g.points.receivers[i], g.materials[number].clone(), g.emission.get(i).copied())
    };
    let bent = look(&varnish, Surface { normal: tilted(), ..Surface::default() });
    assert!(bent.0.normal.distance(Vec3::Y) > 0.2, "{}", bent.0.normal);
    assert_eq!(Some(bent.1), varnish.with_clearcoat_normal(Vec3::Y));
    // The same map for both: as without a word.
    let both = look(&varnish, Surface { normal: tilted(), clearcoat_normal: tilted(), ..Surface::default() });
    assert_eq!(Some(both.1), varnish.with_clearcoat_normal(both.0.normal));
    // A map of the coat alone.
    let (at, alone, _) = look(&varnish, Surface { clearcoat_normal: tilted(), ..Surface::default() });
    assert_eq!((at.normal, Some(alone)), (Vec3::Y, varnish.with_clearcoat_normal(bent.0.normal)));
    // Materials without a coat are left alone.
    let matte = Material::lambert(Vec3::ONE);
    assert_eq!(look(&matte, Surface { normal: tilted(), ..Surface::default() }).1, matte);
    let glow = || Surface { emission: Vec3::ONE, ..Surface::default() };
    let (at, _, emission) = look(&varnish, glow());
    assert_eq!(emission, Some(Vec3::splat(varnish.lets_out(&at))));
    assert_eq!(look(&matte, glow()).2, Some(Vec3::ONE));
}

#[test]
fn colours_of_vertices_are_factors() {
    let mut scene = floor(Material::lambert(Vec3::splat(0.5)), Surface::default());
    scene.surfaces.clear();
    let Shape::Mesh(mesh) = &mut scene.objects[0].shape else { unreachable!() };
    // Red grows along x from 0 to 1.
    mesh.colors = mesh.positions.iter().map(|p| Vec3::new((p.x + 4.0) / 8.0, 1.0, 0.25)).collect();
    let g = GBuffer::new(&World::new(&scene), 96, 64, 1);
    for (at, number) in g.points.receivers.iter().zip(&g.points.materials) {
        let want = Material::lambert(0.5 * Vec3::new((at.position.x + 4.0) / 8.0, 1.0, 0.25));
        let (Material::Lambert(a), Material::Lambert(b)) = (&g.materials[*number as usize], &want) else { panic!() };
        assert!((a.albedo - b.albedo).length() < 1e-5, "{a:?} {b:?}");
    }
}

#[test]
fn emission_is_added_to_what_is_reflected() {
    let glow = Surface {
        emission: Vec3::new(2.0, 4.0, 8.0),
        emission_map: Some(flat([255, 127, 0, 255], Encoding::Linear)),
        ..Surface::default()
    };
    let (with, without) = (
        picture(&floor(Material::lambert(Vec3::splat(0.4)), glow.clone())),
        picture(&floor(Material::lambert(Vec3::splat(0.4)), Surface::default())),
    );
    let own = Vec3::new(2.0, 4.0 * 127.0 / 255.0, 0.0);
    for (a, b) in with.iter().zip(&without) {
        assert!((*a - *b - own).abs().max_element() < 1e-5, "{a} {b}");
    }
    let plain = GBuffer::new(&World::new(&floor(Material::lambert(Vec3::ONE), Surface::default())), 96, 64, 1);
    assert!(plain.emission.is_empty());
}

/// Lobes against Monte Carlo, with everything at once.
#[test]
fn textured_surfaces_are_as_accurate_as_plain_ones() {
    let bumps: Vec<[u8; 4]> =
        (0..64u32 * 64).map(|i| [(96 + i % 64) as u8, (128 + (i / 64) % 32) as u8, 230, 255]).collect();
    let bumps = TextureMap::new(Texture::new("bumps", [64, 64], bumps, Encoding::Linear));
    let ramp: Vec<[u8; 4]> = (0..256u32).map(|i| [0, (80 + i / 2) as u8, (i % 2 * 255) as u8, 255]).collect();
    let ramp = TextureMap::new(Texture::new("ramp", [16, 16], ramp, Encoding::Linear));
    let surface = Surface {
        color: Some(TextureMap::new(checker(8))),
        metallic: Some(Channel { map: ramp.clone(), index: 2 }),
        roughness: Some(Channel { map: ramp, index: 1 }),
        normal: Some((bumps, 0.5)),
        ..Surface::default()
    };
    let mut scene = floor(MetallicRoughness::new(Vec3::ONE, 1.0, 1.0).expect("in range").into(), surface);
    scene.objects.push(sphere(Vec3::new(0.3, 0.9, 0.4), 0.5));
    let world = World::new(&scene);
    let g = GBuffer::new(&world, 96, 64, 1);
    let got = shade(&scene, &g);
    let blockers = BlockerSet::default();
    let job = ReferenceJob { world: &world, gbuffer: &g, blockers: &blockers, geometry: Geometry::Mesh, seed: 3 };
    let mut reference = Reference::new(job);
    reference.advance(4096, &AtomicBool::new(false), &|_| {});
    let truth = reference.estimate();
    let (mut sum, mut count) = (0.0, 0);
    for (i, radiance) in got.iter().enumerate() {
        let (all, shadowed) = (truth.unshadowed[i].element_sum(), truth.radiance[i].element_sum());
        if all > 0.0 && shadowed > 0.01 * all && shadowed < 0.99 * all {
            sum += f64::from((radiance.element_sum() - shadowed).abs() / all);
            count += 1;
        }
    }
    let mean = sum / f64::from(count);
    println!("{count} points in penumbra, mean error {:.3} %", 100.0 * mean);
    assert!(count > 100 && mean < 0.005, "{mean}");
}

/// Edges of texels that are shown as squares are as smooth as those of many camera rays.
#[test]
fn squares_have_smooth_edges() {
    let texels =
        (0..16).map(|i| if (i / 4 + i % 4_u32).is_multiple_of(2) { [240, 240, 240, 255] } else { [20, 20, 20, 255] });
    let texture = Texture::new("squares", [4, 4], texels.collect(), Encoding::Linear);
    let turned = Affine2::from_angle(0.4);
    let map = TextureMap { transform: turned, is_pixelated: true, ..TextureMap::new(texture) };
    let white = ModifiedPhong { kd: Vec3::splat(0.9), ks: Vec3::ZERO, exponent: 1.0 };
    let scene = floor(white.into(), Surface { color: Some(map), ..Surface::default() });
    let world = World::new(&scene);
    let of = |samples| {
        let g = GBuffer::new(&world, scene.width, scene.height, samples);
        g.picture(&shade(&scene, &g), Vec3::ZERO)
    };
    let (one, many) = (of(1), of(256));
    let most = many.iter().map(|pixel| pixel.x).fold(0.0, f32::max);
    let floor_pixels = many.iter().zip(&one).filter(|(_, one)| **one != Vec3::ZERO);
    let errors: Vec<f32> = floor_pixels.map(|(many, one)| (many.x - one.x).abs() / most).collect();
    let mean = errors.iter().sum::<f32>() / errors.len() as f32;
    let mut sorted = errors.clone();
    sorted.sort_by(f32::total_cmp);
    let high = sorted[errors.len() * 99 / 100];
    println!("mean {mean}, 99 % {high}");
    assert!(mean < 0.003 && high < 0.04, "{mean} {high}");
}
