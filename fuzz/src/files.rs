//! Targets for the files that the program reads.

use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Geometry, Reference, ReferenceJob};
use cosine_lobes::scene::{self, BlockerSet, SCHEMA_EXAMPLE, Scene, Surface, Wrap};
use cosine_lobes::sphere_sets::{BoundSet, BuildOptions, SphereSet};
use cosine_lobes::{Comparison, ExrLayer, ExrPart, Output, merge_exr, read_exr, read_exr_layer, read_stamp, write_exr};
use glam::{Vec2, Vec3};
use std::cell::RefCell;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

/// Writes the input to a file of that name and hands its path on.
fn with_file(name: &str, data: &[u8], work: impl FnOnce(&Path)) {
    thread_local! {
        static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
    }
    FOLDER.with_borrow_mut(|folder| {
        let memory = Path::new("/dev/shm");
        let new = || if memory.is_dir() { TempDir::new_in(memory) } else { TempDir::new() };
        let folder = folder.get_or_insert_with(|| new().expect("a folder for inputs"));
        let file = folder.path().join(name);
        fs::write(&file, data).expect("room for the input");
        work(&file);
    });
}

/// A file either loads as a valid scene, at all of its moments, or is refused in one line.
fn load(name: &str, data: &[u8]) {
    with_file(name, data, |file| match scene::load_animated(file) {
        Ok((mut scene, animation, warnings)) => {
            assert!(warnings.iter().all(|w| !w.is_empty() && !w.contains('\n')), "{warnings:?}");
            animation.validate().unwrap_or_else(|e| panic!("an animation that can be sought: {e}"));
            for time in [0.0, 0.5 * animation.duration(), animation.duration(), f32::NAN, -1.0, f32::INFINITY] {
                animation.seek(time, &mut scene);
                scene.validate().unwrap_or_else(|e| panic!("valid before, at {time}: {e}"));
            }
        }
        Err(error) => {
            let message = error.to_string();
            assert!(!message.is_empty() && !message.contains('\n'), "{message:?}");
        }
    });
}

pub(crate) fn obj(data: &[u8]) {
    load("m.obj", data);
}

pub(crate) fn ply(data: &[u8]) {
    load("m.ply", data);
}

pub(crate) fn gltf(data: &[u8]) {
    load("m.gltf", data);
}

pub(crate) fn glb(data: &[u8]) {
    load("m.glb", data);
}

pub(crate) fn scene_file(data: &[u8]) {
    load("m.toml", data);
}

pub(crate) fn scene_seeds() -> Vec<Vec<u8>> {
    // Meshes are missing here.
    let without = |text: &str| text.replace("mesh = ", "sphere = { center = [0, 1, 0], radius = 0.5 } # ");
    vec![SCHEMA_EXAMPLE.into(), without(SCHEMA_EXAMPLE).into()]
}

/// An image on a quad and, cut out along its alpha, on another: refused in one line, or values in [0, 1] at all places.
pub(crate) fn image(data: &[u8]) {
    // Data of unknown format counts as TGA with this ending, because TGA has no mark of its own.
    with_file("p.tga", data, |file| {
        let quad = "[[objects]]\nquad = { center = [0, 0, 0], u = [1, 0, 0], v = [0, 1, 0] }\nmaterial = ";
        let map = "color_map = { file = \"p.tga\", scale = 1.5 }";
        let text = format!(
            "[materials.a]\nmodel = \"lambert\"\n{map}\nnormal_map = \"p.tga\"\n\
             [materials.b]\nmodel = \"lambert\"\n{map}\nalpha_cutoff = 0.5\n{quad}\"a\"\n{quad}\"b\"\n"
        );
        let path = file.with_file_name("p.toml");
        fs::write(&path, text).expect("room for the scene");
        match scene::load(&path) {
            Ok(scene) => {
                for (_, texture) in scene.surfaces.iter().flat_map(Surface::textures) {
                    for (i, wrap) in (0..).zip([Wrap::Repeat, Wrap::Mirror, Wrap::Clamp]) {
                        let at = Vec2::new(-0.3, 1.7) * i as f32;
                        for side in [0.0, 0.01, 0.3, 50.0] {
                            let value = texture.sample(at, [Vec2::X * side, Vec2::splat(side)], [wrap; 2], i == 1);
                            assert!(value.iter().all(|x| (0.0..=1.0001).contains(x)), "{value:?}");
                        }
                    }
                }
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    });
}

pub(crate) fn image_seeds() -> Vec<Vec<u8>> {
    use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};
    let texel = |x: u32, y: u32| Rgba([(40 * x) as u8, (70 * y) as u8, 90, (x * y * 30) as u8]);
    let colors = DynamicImage::from(RgbaImage::from_fn(5, 4, texel));
    let kinds = [
        (colors.clone(), ImageFormat::Png),
        (colors.to_luma16().into(), ImageFormat::Png),
        (colors.to_rgb8().into(), ImageFormat::Jpeg),
        (colors.to_rgb8().into(), ImageFormat::Bmp),
        (colors, ImageFormat::Tga),
    ];
    let bytes = |(image, format): (DynamicImage, ImageFormat)| {
        let mut out = std::io::Cursor::new(Vec::new());
        image.write_to(&mut out, format).expect("an image");
        out.into_inner()
    };
    kinds.map(bytes).into()
}

/// A material library of a mesh, beside the image `i`.
pub(crate) fn mtl(data: &[u8]) {
    thread_local! {
        static IMAGE: Vec<u8> = image_seeds().swap_remove(3);
    }
    with_file("m.mtl", data, |file| {
        let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nusemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 3/1 2/1 1/1\n";
        let path = file.with_file_name("m.obj");
        fs::write(&path, obj).expect("room for the mesh");
        IMAGE.with(|image| fs::write(file.with_file_name("i"), image)).expect("room for the image");
        match scene::load(&path) {
            Ok(scene) => scene.validate().expect("valid before"),
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    });
}

pub(crate) fn mtl_seeds() -> Vec<Vec<u8>> {
    let text = "newmtl a\nKd 0.5 0.4 0.3\nKs 0.2 0.2 0.2\nNs 50\nillum 2\nmap_Kd -s 2 2 1 -o 0.5 0 -clamp on no such.png\n\
        newmtl b\nKd 1\nPr 0.4\nPm 1\nKe 1 2 3\nnorm -bm 0.5 none.png\nd 0.5\nKd spectral file.rfl\n";
    let images = "newmtl a\nKs 1 1 1\nmap_Ks i\nmap_Ns -imfchan g i\nbump -bm 2 -clamp on i\nmap_d -s 3 2 -o 0.1 i\n\
        newmtl b\nTr 0.2\nmap_d -imfchan l i\nnorm i\nmap_Pr i\nmap_Bump -imfchan r i\n";
    vec![text.into(), images.into()]
}

pub(crate) fn sphere_set(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    match SphereSet::from_json(text) {
        Ok(set) => {
            assert!(set.spheres.iter().all(|s| s.center.is_finite() && s.radius.is_finite()), "{set:?}");
            let again = SphereSet::from_json(&set.to_json()).expect("what was written");
            assert_eq!(set, again);
        }
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
    if let Ok(set) = BoundSet::from_json(text) {
        BoundSet::from_json(&set.to_json()).expect("what was written");
    }
}

pub(crate) fn sphere_set_seeds() -> Vec<Vec<u8>> {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let set = SphereSet::build(&corners, &triangles, &BuildOptions::draft(3)).expect("a tetrahedron");
    vec![set.to_json().into()]
}

pub(crate) fn exr(data: &[u8]) {
    with_file("p.exr", data, |file| {
        if let Ok(picture) = read_exr(file) {
            Comparison::of(&picture, &picture).expect("the same size");
        }
        for name in ["unshadowed", "", "beauty"] {
            drop(read_exr_layer(file, name));
        }
        if let Ok(part) = ExrPart::read(file) {
            assert!(part.channels.iter().all(|(_, c)| c.len() == part.window.size().iter().product::<usize>()));
        }
        drop(merge_exr(&[file.to_owned(), file.to_owned()]));
        drop(merge_exr(&[file.to_owned()]));
        drop(read_stamp(file));
    });
}

pub(crate) fn exr_seeds() -> Vec<Vec<u8>> {
    let folder = TempDir::new().expect("a folder for seeds");
    let file = folder.path().join("p.exr");
    let values: Vec<Vec3> = (0..20).map(|k| Vec3::splat(k as f32)).collect();
    let layers = [ExrLayer::color("beauty", &values), ExrLayer::color("unshadowed", &values)];
    [None, Some("0.1.0 0123456789abcdef")]
        .map(|stamp| {
            let output = Output::create(&file).expect("a file").stamped(stamp);
            write_exr(output, 5, 4, &layers).expect("room for a picture");
            fs::read(&file).expect("what was written")
        })
        .into()
}

/// A few points of a small scene.
fn with_reference(work: impl FnOnce(&mut Reference<'_>)) {
    let mut scene = Scene { width: 4, height: 2, ..scene::builtin() };
    scene.objects.truncate(1);
    let world = World::new(&scene);
    let gbuffer = GBuffer::new(&world, scene.width, scene.height, 1);
    let blockers = BlockerSet::default();
    let job = ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 1 };
    work(&mut Reference::new(job));
}

pub(crate) fn checkpoint(data: &[u8]) {
    thread_local! {
        static SAVED: Vec<Vec<u8>> = checkpoint_seeds();
    }
    with_reference(|reference| {
        if reference.restore(data).is_ok() {
            let estimate = reference.estimate();
            assert!(estimate.radiance.iter().chain(&estimate.std_error).all(|v| v.is_finite()));
            // A checksum of 32 bits does not let a changed one through by chance.
            assert!(SAVED.with(|all| all.iter().any(|one| one == data)), "a checkpoint that nobody saved");
        }
    });
}

pub(crate) fn checkpoint_seeds() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for samples in [0, 8, 64] {
        with_reference(|reference| {
            reference.advance(samples, &AtomicBool::new(false), &|_| {});
            let mut bytes = Vec::new();
            reference.save(&mut bytes).expect("room in memory");
            all.push(bytes);
        });
    }
    all
}
