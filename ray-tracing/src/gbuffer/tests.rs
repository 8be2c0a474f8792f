use super::view::{View, sub_pixels};
use super::*;
use crate::World;
use crate::world::Rays;
use fearless_simd::{Level, Simd};
use glam::{Vec2, Vec3};
use lobe_core::{Receiver, Sphere};
use scene::{Bounds, Camera, Mesh, Object, Projection, Proxy, Scene, Shape};
use test_scenes::{floor_and_sphere, globe, material};

#[test]
fn rays_are_the_camera_s() {
    let camera = Camera {
        eye: Vec3::new(1.0, 2.0, 3.0),
        target: Vec3::X,
        up: Vec3::Y,
        projection: Projection::perspective(0.7),
    };
    let rays = Rays::new(&camera, 640, 360, &Bounds::EMPTY);
    for (x, y) in [(0.5, 0.5), (320.0, 180.0), (639.5, 0.5), (17.25, 359.5)] {
        // Both are a handful of f32 operations on numbers near 1.
        assert!((rays.direction(x, y) - camera.direction(x, y, 640, 360)).length() < 1e-6);
    }
}

#[test]
fn one_sample_is_the_centre_and_many_are_balanced() {
    assert_eq!(sub_pixels(1), [Vec2::splat(0.5)]);
    for n in [2u32, 3, 4, 5, 16, 33, 64] {
        let points = sub_pixels(n);
        let mean = points.iter().sum::<Vec2>() / n as f32;
        assert!((mean - 0.5).abs().max_element() < 1e-6, "{n}: {mean}");
        assert!(points.iter().all(|p| p.min_element() > 0.0 && p.max_element() < 1.0));
    }
}

/// Positions lie on the surfaces to f32 rounding, normals face the viewer, pixels are in tile order.
#[test]
fn points_lie_on_surfaces() {
    let scene = floor_and_sphere();
    let world = World::new(&scene);
    let g = GBuffer::new(&world, 50, 30, 1);
    assert!(g.len() > 500 && g.len() < 1500, "{}", g.len());
    let (mut floor, mut sphere) = (0, 0);
    for r in &g.points.receivers {
        assert!(r.view.dot(r.normal) > 0.0 && r.view.dot(r.face) > 0.0);
        if r.object == 0 {
            floor += 1;
            assert!(r.position.y.abs() < 1e-7, "{}", r.position);
            assert_eq!(r.normal, Vec3::Y);
        } else {
            sphere += 1;
            let d = (r.position.as_dvec3() - glam::DVec3::Y).length();
            // Rounding of three coordinates up to 2: half of 1.2e-7 each.
            assert!((d - 0.5).abs() < 1.1e-7, "{d}");
        }
    }
    assert!(floor > 100 && sphere > 20, "{floor} {sphere}");
    let tile = |p: u32| (p / 50 / TILE, p % 50 / TILE);
    assert!(g.pixels.is_sorted_by_key(|p| tile(*p)));
}

#[test]
fn bands_make_up_the_picture() {
    let scene = floor_and_sphere();
    let world = World::new(&scene);
    let whole = GBuffer::new(&world, 40, 30, 2);
    let whole = whole.resolve(&whole.depths, 0.0);
    let bands = [0..16, 16..24, 24..24, 24..30].map(|rows| {
        let g = GBuffer::rows(&world, 40, 30, 2, rows);
        g.resolve(&g.depths, 0.0)
    });
    assert_eq!(bands.concat(), whole);
}

/// A grid of triangles in a plane has no cracks: every ray through it hits.
#[test]
fn shared_edges_have_no_cracks() {
    let n = 16u32;
    let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
    let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| Vec3::new(at(x), at(y), 0.0))).collect();
    let quads = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
    let triangles = quads.flat_map(|i| [[i, i + 1, i + n + 2], [i, i + n + 2, i + n + 1]]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    let grid = Object {
        name: "grid".into(),
        shape: Shape::Mesh(mesh),
        material: 0,
        proxy: Proxy::None,
        visible: true,
        strategy: None,
        terminator: scene::Terminator::Exact,
    };
    // Exactly in front: pixel centres and corners fall on edges and diagonals.
    let camera =
        Camera { eye: Vec3::Z * 4.0, target: Vec3::ZERO, up: Vec3::Y, projection: Projection::perspective(0.4) };
    let scene = Scene { camera, objects: vec![grid], materials: vec![material()], ..floor_and_sphere() };
    let world = World::new(&scene);
    for (size, samples) in [(255, 1), (256, 1), (128, 16)] {
        assert_eq!(GBuffer::new(&world, size, size, samples).len() as u32, size * size * samples);
    }
}

/// Nor has a closed surface of triangles smaller than pixels: no ray gets in. (A fixed margin of 1e-6 of a triangle
/// around each lets through some one in 200 000.)
#[test]
fn closed_surfaces_have_no_cracks() {
    let camera = Camera {
        eye: Vec3::new(0.3, 0.8, 4.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::perspective(0.45),
    };
    let objects = vec![Object::mesh("globe", globe(250, Vec3::ZERO, 1.0, false), 0, Proxy::None)];
    let scene = Scene { camera, objects, ..floor_and_sphere() };
    let g = GBuffer::new(&World::new(&scene), 600, 600, 4);
    assert!(g.len() > 1_000_000, "{}", g.len());
    let inside = g.points.receivers.iter().filter(|r| r.position.dot(r.view) < -0.02).count();
    assert_eq!(inside, 0);
}

/// Tiles of rays find the same points as single rays, to the bit: flat and smooth meshes, spheres, invisible objects, a view
/// from the middle of the scene. They may differ where a ray passes an edge within rounding: a few of 100 000.
#[test]
fn tiles_find_what_single_rays_find() {
    let mut scene = floor_and_sphere();
    let mut add = |mesh: Mesh, shift: Vec3, visible: bool| {
        let positions = mesh.positions.iter().map(|p| 0.8 * *p + shift).collect();
        let object = Object::mesh("globe", Mesh { positions, ..mesh }, 0, Proxy::Count(1));
        scene.objects.push(Object { visible, ..object });
    };
    add(globe(40, Vec3::ZERO, 1.0, true), Vec3::new(1.5, 0.7, 0.3), true);
    add(globe(9, Vec3::ZERO, 1.0, false), Vec3::new(-1.4, 0.3, 1.0), true);
    add(globe(9, Vec3::ZERO, 1.0, false), Vec3::new(0.0, 1.5, 4.0), false);
    let spheres = (0..40).map(|i| Sphere { center: Vec3::new(0.3 * i as f32 - 6.0, 0.1, -1.0), radius: 0.12 });
    scene.objects.push(Object::spheres("row", spheres.collect(), 0));
    let mut different = 0;
    let (far, inside) = (Vec3::new(0.0, 3.0, 8.0), Vec3::new(0.2, 0.6, 0.9));
    let orthographic = |height| Projection::Orthographic { height };
    let views = [
        (far, Projection::perspective(0.6)),
        (inside, Projection::perspective(2.6)),
        (Vec3::new(0.0, 90.0, 1.0), Projection::perspective(0.1)),
        (far, orthographic(4.0)),
        (Vec3::new(0.0, 3e4, 8e4), orthographic(4.0)),
        (inside, orthographic(2.5)),
        (Vec3::new(0.3, 2.6, 7.0), orthographic(57.3)),
        (far, Projection::Panoramic),
        (inside, Projection::Panoramic),
    ];
    for (eye, projection) in views {
        scene.camera = Camera { eye, projection, ..scene.camera };
        let world = World::new(&scene);
        let (width, height) = (203, 115);
        let g = GBuffer::new(&world, width, height, 3);
        let rays = world.rays(width, height);
        let mut of_view = 0;
        let mut points = g.points.receivers.iter().zip(&g.pixels).peekable();
        let pixels = (0..height.div_ceil(TILE)).flat_map(|ty| (0..width.div_ceil(TILE)).map(move |tx| (tx, ty)));
        let pixels =
            pixels.flat_map(|(tx, ty)| (0..TILE * TILE).map(move |i| (tx * TILE + i % TILE, ty * TILE + i / TILE)));
        for (x, y) in pixels.filter(|(x, y)| *x < width && *y < height) {
            let wanted = sub_pixels(3).into_iter().filter_map(|offset| {
                let at = Vec2::new(x as f32, y as f32) + offset;
                let (start, d) = (rays.start(at.x, at.y), rays.direction(at.x, at.y));
                let hit = world.hit(start, d)?;
                let are_parallel = matches!(projection, Projection::Orthographic { .. });
                let view = if are_parallel { -d } else { (start - hit.position).normalize() };
                let (position, normal, face) = (hit.position, hit.normal, hit.face_normal);
                Some(Receiver { position, normal, face, view, object: hit.object })
            });
            let found = core::iter::from_fn(|| points.next_if(|(_, pixel)| **pixel == y * width + x));
            let found: Vec<_> = found.map(|p| *p.0).collect();
            let wanted: Vec<_> = wanted.collect();
            of_view += u32::from(wanted != found);
        }
        println!("{projection:?} from {eye}: {of_view} of 23 345 pixels differ, {} points", g.len());
        different += of_view;
        let least = if projection == orthographic(57.3) { 100 } else { 1_000 };
        assert!(points.next().is_none() && g.len() > least, "{different}, {}", g.len());
    }
    assert!(different < 21, "{different} of 210 000 pixels");
}

/// Through a surface of an orthographic picture that is as high as two pixels, or seen from its middle, no ray passes.
#[test]
fn orthographic_and_panoramic_pictures_have_no_cracks() {
    let objects = vec![Object::mesh("globe", globe(250, Vec3::ZERO, 1.0, false), 0, Proxy::None)];
    let eye = Vec3::new(0.3, 0.8, 4.0);
    let mut scene = Scene { objects, ..floor_and_sphere() };
    for (eye, height) in [(eye, 1.2), (100.0 * eye, 1.2), (eye, 0.01)] {
        let projection = Projection::Orthographic { height };
        scene.camera = Camera { eye, target: Vec3::ZERO, up: Vec3::Y, projection };
        let g = GBuffer::new(&World::new(&scene), 500, 500, 2);
        assert_eq!(g.len(), 500_000, "{height}");
        assert_eq!(g.points.receivers.iter().filter(|r| r.position.dot(r.view) < -0.02).count(), 0);
    }
    for eye in [Vec3::ZERO, Vec3::new(0.5, -0.6, 0.1)] {
        scene.camera = Camera { eye, target: Vec3::X, up: Vec3::Y, projection: Projection::Panoramic };
        // Also where a tile reaches around the eye.
        for (width, height) in [(400, 200), (31, 7), (3, 1)] {
            assert_eq!(GBuffer::new(&World::new(&scene), width, height, 2).len() as u32, 2 * width * height);
        }
    }
}

/// A wall behind another one of the same size covers as many pixels, and their edges stay parallel; depths are those from the eye's plane.
#[test]
fn size_does_not_depend_on_distance_in_orthographic_pictures() {
    let wall = |z: f32, x: f32| {
        let corners = [(0.0, 0.0), (0.5, 0.0), (0.5, 1.5), (0.0, 1.5)].map(|(u, v)| Vec3::new(x + u, v - 0.75, z));
        let mesh = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
        Object::mesh("wall", mesh, 0, Proxy::None)
    };
    let camera = Camera {
        eye: Vec3::Z * 2.0,
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Orthographic { height: 2.0 },
    };
    // One of them is behind the eye.
    let objects = vec![wall(0.0, -1.0), wall(-500.0, 0.25), wall(2.5, -0.4)];
    let scene = Scene { camera, objects, materials: vec![material()], ..floor_and_sphere() };
    let (width, height) = (120, 80);
    let g = GBuffer::new(&World::new(&scene), width, height, 1);
    // 40 pixels a unit: 20 × 60 pixels each.
    for (object, depth, left) in [(0, 2.0, 20), (1, 502.0, 70)] {
        let seen =
            || g.points.receivers.iter().zip(&g.pixels).zip(&g.depths).filter(|((at, _), _)| at.object == object);
        assert_eq!(seen().count(), 1200);
        for ((at, pixel), is) in seen() {
            let (x, y) = (pixel % width, pixel / width);
            assert!((left..left + 20).contains(&x) && (10..70).contains(&y), "{x} {y}");
            let want = Vec3::new((x as f32 - 59.5) / 40.0, (39.5 - y as f32) / 40.0, 2.0 - depth);
            assert!((at.position - want).length() < 1e-4 && (is - depth).abs() < 1e-4, "{} {want}", at.position);
            assert_eq!(at.view, Vec3::Z);
        }
    }
    assert_eq!(g.len(), 2400, "what is behind the eye is not seen");
}

/// Positions in a panorama by longitude and latitude; depths are distances.
#[test]
fn a_panorama_shows_directions() {
    let sphere = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 2.0 };
    let projection = Projection::Panoramic;
    let camera = Camera { eye: sphere.center, target: sphere.center + Vec3::NEG_Z, up: Vec3::Y, projection };
    let objects = vec![Object::spheres("sphere", vec![sphere], 0)];
    let scene = Scene { camera, objects, materials: vec![material()], ..floor_and_sphere() };
    let (width, height) = (64, 32);
    let g = GBuffer::new(&World::new(&scene), width, height, 1);
    assert_eq!(g.len(), 2048);
    for ((at, pixel), depth) in g.points.receivers.iter().zip(&g.pixels).zip(&g.depths) {
        let longitude = ((pixel % width) as f32 + 0.5 - 32.0) * core::f32::consts::PI / 32.0;
        let latitude = (15.5 - (pixel / width) as f32) * core::f32::consts::PI / 32.0;
        let want = Vec3::new(longitude.sin() * latitude.cos(), latitude.sin(), -longitude.cos() * latitude.cos());
        assert!((at.position - sphere.center - 2.0 * want).length() < 1e-5, "{}", at.position);
        assert!((at.view + want).length() < 1e-5 && (depth - 2.0).abs() < 1e-5);
    }
}

/// The footprint of a pixel on a plane: by parallel rays it is as large near as far, and longer where the plane is steep.
#[test]
fn footprints_of_parallel_rays() {
    let projection = Projection::Orthographic { height: 3.0 };
    let camera = Camera { eye: Vec3::new(0.0, 0.0, 5.0), target: Vec3::ZERO, up: Vec3::Y, projection };
    let rays = Rays::new(&camera, 90, 60, &Bounds::EMPTY);
    for (slope, z) in [(0.0, 0.0), (1.0, 0.0), (1.0, -300.0), (-3.0, 0.0)] {
        let normal = Vec3::new(0.0, slope, 1.0).normalize();
        let start = rays.start(30.5, 20.5);
        let at = Receiver { view: Vec3::Z, ..Receiver::on_surface(start.with_z(z), normal, Vec3::Z) };
        let (right, down) = (rays.side(31.5, 20.5, &at), rays.side(30.5, 21.5, &at));
        assert!((right - Vec3::X * 0.05).length() < 1e-4, "{right}");
        // One pixel down the plane rises toward the eye by its slope.
        assert!((down - Vec3::new(0.0, -0.05, 0.05 * slope)).length() < 1e-4, "{down}");
    }
    // One that is seen from its edge has an end.
    let edge = Receiver { view: Vec3::Z, ..Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Z) };
    assert!(rays.side(30.5, 21.5, &edge).length() < 13.0);
}

/// The same points to the bit with all kinds of vector instructions.
#[test]
fn instructions_do_not_matter() {
    let mut scene = floor_and_sphere();
    scene.objects.push(Object::mesh("globe", globe(30, Vec3::ZERO, 1.0, true), 0, Proxy::None));
    let look = |world: &World<'_>, level: Level| {
        let mut view = View::new(world, [90, 70], 1, 0..90, 0..70);
        view.rays.level = level;
        let (found, ends) = view.trace();
        let mut g = GBuffer { width: 90, height: 70, samples: 1, ..GBuffer::default() };
        view.describe(&found, &ends, &mut g);
        g
    };
    let mut levels = vec![Level::baseline()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(Level::new().as_avx2().map(|avx2| avx2.level()));
    for projection in [scene.camera.projection, Projection::Orthographic { height: 3.0 }, Projection::Panoramic] {
        scene.camera.projection = projection;
        let world = World::new(&scene);
        let best = look(&world, Level::new());
        for level in &levels {
            let g = look(&world, *level);
            assert_eq!(
                (&g.points.receivers, &g.pixels, &g.depths),
                (&best.points.receivers, &best.pixels, &best.depths)
            );
        }
    }
}

#[test]
fn resolving_mixes_the_background_in() {
    let scene = floor_and_sphere();
    let g = GBuffer::new(&World::new(&scene), 20, 10, 16);
    let picture = g.resolve(&vec![1.0; g.len()], 0.0);
    let total: f32 = picture.iter().sum();
    assert!((total - g.len() as f32 / 16.0).abs() < 1e-3);
    assert!(picture.contains(&0.0) && picture.contains(&1.0));
    assert!(picture.iter().any(|v| *v > 0.0 && *v < 1.0));
}

#[test]
fn an_empty_world_has_no_points() {
    let scene = Scene { objects: Vec::new(), ..floor_and_sphere() };
    let g = GBuffer::new(&World::new(&scene), 9, 9, 1);
    assert!(g.is_empty());
    assert_eq!(g.resolve(&[], Vec3::ONE), vec![Vec3::ONE; 81]);
}

fn of_edges(world: &World<'_>, image: [u32; 2], count: u32, window: [core::ops::Range<u32>; 2]) -> GBuffer {
    GBuffer::sampled(world, image, PixelSamples::Edges(count), window, &scene::Cancel::new()).expect("points")
}

/// For each object its part of each pixel.
fn parts(g: &GBuffer, object: u32) -> Vec<f32> {
    let is_it: Vec<f32> = g.points.receivers.iter().map(|r| f32::from(u8::from(r.object == object))).collect();
    g.resolve(&is_it, 0.0)
}

/// Outlines are those of as many rays in all pixels, at the price of few more points than one ray has.
#[test]
fn edges_are_those_of_many_rays() {
    let scene = floor_and_sphere();
    let world = World::new(&scene);
    let (image, count) = ([150, 90], 8);
    let one = GBuffer::new(&world, image[0], image[1], 1);
    let many = GBuffer::new(&world, image[0], image[1], count);
    let edges = of_edges(&world, image, count, [0..image[0], 0..image[1]]);
    assert!(edges.len() > one.len() && 8 * edges.len() < 9 * one.len(), "{} {}", edges.len(), one.len());
    let tile = |p: u32| (p / image[0] / TILE, p % image[0] / TILE);
    assert!(edges.pixels.is_sorted_by_key(|p| tile(*p)));
    for object in 0..2 {
        let [one, many, got] = [&one, &many, &edges].map(|g| parts(g, object));
        let off = |a: &[f32]| a.iter().zip(&many).filter(|(a, b)| (**a - **b).abs() > 1e-6).count();
        assert!(off(&one) > 40, "{}", off(&one));
        assert!(off(&got) * 20 < off(&one), "{} of {}", off(&got), off(&one));
    }
    let mut centers = vec![None; (image[0] * image[1]) as usize];
    one.pixels.iter().zip(&one.points.receivers).for_each(|(p, at)| centers[*p as usize] = Some(*at));
    let mut first = 0;
    for pixels in edges.pixels.chunk_by(|a, b| a == b) {
        let rays = &edges.rays[first..first + pixels.len()];
        assert!(rays.iter().sum::<u32>() <= count && rays.iter().all(|n| *n > 0));
        if rays == [count] {
            let (center, at) = (centers[pixels[0] as usize].expect("a point"), edges.points.receivers[first]);
            assert!(center.position == at.position || center.position.distance(at.position) < 0.1);
        }
        first += pixels.len();
    }
}

/// Any window has the bits of the whole, where an outline runs along its border as well.
#[test]
fn edges_do_not_depend_on_the_window() {
    let scene = floor_and_sphere();
    let world = World::new(&scene);
    let image = [90, 70];
    let whole = of_edges(&world, image, 5, [0..90, 0..70]);
    let mut all: Vec<Vec<(Receiver, u32)>> = vec![Vec::new(); 90 * 70];
    for ((pixel, at), rays) in whole.pixels.iter().zip(&whole.points.receivers).zip(&whole.rays) {
        all[*pixel as usize].push((*at, *rays));
    }
    let mut borders = 0;
    // Some that end at tiles or hold nothing, and small ones all over the sphere.
    let small = (0..36).map(|k| (36 + k % 6 * 3, 26 + k / 6 * 3)).map(|(x, y)| (x..x + 3, y..y + 3));
    for (columns, rows) in [(0..90, 8..16), (30..47, 11..45), (3..3, 5..9)].into_iter().chain(small) {
        let part = of_edges(&world, image, 5, [columns.clone(), rows.clone()]);
        let mut got: Vec<Vec<(Receiver, u32)>> = vec![Vec::new(); columns.len() * rows.len()];
        for ((pixel, at), rays) in part.pixels.iter().zip(&part.points.receivers).zip(&part.rays) {
            got[*pixel as usize].push((*at, *rays));
        }
        for (y, line) in rows.clone().zip(0..) {
            for (x, k) in columns.clone().zip(0..) {
                let want = &all[(y * 90 + x) as usize];
                assert_eq!(&got[line * columns.len() + k], want, "{x} {y}");
                let is_border = x == columns.start || y == rows.start || x + 1 == columns.end || y + 1 == rows.end;
                borders += usize::from(is_border && want.len() > 1);
            }
        }
    }
    assert!(borders > 10, "{borders}");
    let stopped = scene::Cancel::new();
    stopped.cancel();
    let window = [0..90, 0..70];
    assert!(GBuffer::sampled(&world, image, PixelSamples::Edges(5), window, &stopped).is_none());
}

/// The sky behind an outline is as much of the pixel as its rays that meet nothing.
#[test]
fn skies_show_in_parts_of_pixels() {
    let sky = Vec3::new(0.5, 1.0, 2.0);
    let world = Sphere { center: Vec3::ZERO, radius: 9.0 };
    let map = lighting::EnvironmentMap::uniform(sky);
    // Ambient light shines and is not seen.
    let environment = lighting::Environment::with_ambient(Some(map), Vec3::ONE, 1, world);
    let scene = Scene { environment: Some(environment.into()), ..floor_and_sphere() };
    let world = World::new(&scene);
    let g = of_edges(&world, [60, 40], 8, [0..60, 0..40]);
    let picture = g.picture(&vec![Vec3::ZERO; g.len()], Vec3::ZERO);
    let seen = g.resolve(&vec![1.0; g.len()], 0.0);
    let mut partly = 0;
    for (pixel, seen) in picture.iter().zip(seen) {
        assert!((*pixel - sky * (1.0 - seen)).abs().max_element() < 1e-5, "{pixel} {seen}");
        partly += usize::from(seen > 0.0 && seen < 1.0);
    }
    assert!(partly > 20, "{partly}");
    let ambient = lighting::Environment::with_ambient(None, Vec3::ONE, 1, Sphere { center: Vec3::ZERO, radius: 9.0 });
    let scene = Scene { environment: Some(ambient.into()), ..floor_and_sphere() };
    let g = of_edges(&World::new(&scene), [60, 40], 8, [0..60, 0..40]);
    assert_eq!(g.picture(&vec![Vec3::ZERO; g.len()], sky)[0], sky);
}

/// One pixel of as many rays, of which its points stand for so many each.
fn pixel(samples: u32, rays: &[u32]) -> GBuffer {
    let points = if rays.is_empty() { samples as usize } else { rays.len() };
    GBuffer { width: 1, height: 1, samples, pixels: vec![0; points], rays: rays.to_vec(), ..GBuffer::default() }
}

#[test]
fn errors_of_any_radiance() {
    for size in [1e-30_f32, 1.0, 1e30] {
        let errors = [Vec3::splat(3.0 * size), Vec3::splat(4.0 * size)];
        // √(9 + 16)/2, and √((1·3)² + (3·4)²)/4 where the second stands for three of four rays.
        for (pixel, want) in [(pixel(2, &[]), 2.5), (pixel(4, &[1, 3]), 153.0_f32.sqrt() / 4.0)] {
            let error = pixel.resolve_errors(&errors)[0] / size;
            assert!((error - Vec3::splat(want)).length() < 1e-5, "{size}: {error}");
        }
    }
    assert_eq!(pixel(1, &[]).resolve_errors(&[Vec3::ZERO]), [Vec3::ZERO]);
}
