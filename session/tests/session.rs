//! Edits at any time give the pictures of new renderers, are seen soon, and can be taken back.

#![allow(clippy::unwrap_used, reason = "in tests")]

use core::time::Duration;
use glam::{Mat4, Quat, Vec2, Vec3};
use renderer::{LightHandle, MaskSample, RenderError, Renderer, Settings};
use scene::{Animation, Scene};
use session::{Edit, Picture, Session};
use shading::Accuracy;
use std::sync::Arc;
use std::thread;

fn scene(width: u32, height: u32) -> Scene {
    Scene { width, height, ..scene::builtin() }
}

fn renderer(scene: Scene) -> Renderer {
    Renderer::new(scene, Animation::default(), Settings::default()).unwrap()
}

fn of_new(scene: Scene) -> Vec<Vec3> {
    renderer(scene).render().unwrap().radiance
}

/// Somewhere else along a circle.
fn turned(scene: &Scene, light: usize, step: usize) -> lighting::Light {
    scene.lights[light].moved(Mat4::from_quat(Quat::from_rotation_y(0.02 * step as f32)))
}

fn first_light(renderer: &Renderer) -> LightHandle {
    renderer.lights().next().unwrap().0
}

#[test]
fn the_picture_in_the_end_is_that_of_a_new_renderer() {
    let mut scene = scene(96, 54);
    let renderer = renderer(scene.clone());
    let (light, object) = (first_light(&renderer), renderer.objects().last().unwrap().0);
    let session = Session::new(renderer);
    assert_eq!(session.finished().radiance, of_new(scene.clone()));
    let matrix = Mat4::from_translation(Vec3::new(0.1, 0.2, -0.1));
    let camera = scene::Camera { eye: scene.camera.eye + Vec3::X * 0.3, ..scene.camera };
    session.edit(Edit::Light(light, turned(&scene, 0, 9).into()));
    session.edit(Edit::Transform(object, matrix));
    session.edit(Edit::Camera(camera));
    session.edit(Edit::Size(80, 50));
    let picture = session.finished();
    scene.lights[0] = turned(&scene, 0, 9);
    (scene.camera, scene.width, scene.height) = (camera, 80, 50);
    let mut want = self::renderer(scene);
    let object = want.objects().last().unwrap().0;
    want.set_transform(object, matrix).unwrap();
    assert_eq!((picture.size, picture.edits, picture.divisor), ([80, 50], 4, 1));
    assert!(picture.radiance == want.render().unwrap().radiance);
    assert!(session.take_errors().is_empty());
}

#[test]
fn steps_are_taken_back_and_made_again() {
    let scene = scene(64, 36);
    let renderer = renderer(scene.clone());
    let (light, object) = (first_light(&renderer), renderer.objects().last().unwrap().0);
    let session = Session::new(renderer);
    let before = session.finished();
    // A drag is one step, until it is closed.
    (1..9).for_each(|step| session.edit(Edit::Light(light, turned(&scene, 0, step).into())));
    session.close_step();
    let dragged = session.finished();
    session.edit(Edit::Light(light, turned(&scene, 0, 30).into()));
    session.edit(Edit::Transform(object, Mat4::from_translation(Vec3::Y * 0.3)));
    let after = session.finished();
    let step = |go: fn(&Session)| -> Arc<Picture> {
        go(&session);
        session.finished()
    };
    step(Session::undo);
    assert!(step(Session::undo).radiance == dragged.radiance);
    assert!(step(Session::undo).radiance == before.radiance);
    // There is nothing more to take back.
    assert!(step(Session::undo).radiance == before.radiance);
    step(Session::redo);
    step(Session::redo);
    assert!(step(Session::redo).radiance == after.radiance);
    assert!(step(Session::redo).radiance == after.radiance && after.radiance != dragged.radiance);
}

#[test]
fn refused_edits_change_nothing_and_are_said() {
    let scene = scene(48, 27);
    let renderer = renderer(scene.clone());
    let light = first_light(&renderer);
    let session = Session::new(renderer);
    let before = session.finished();
    session.edit(Edit::Light(light, scene.lights[0].moved(Mat4::from_translation(Vec3::splat(f32::NAN))).into()));
    session.edit(Edit::Size(0, 10));
    let after = session.finished();
    assert!(after.edits == 2 && after.radiance == before.radiance);
    let errors = session.take_errors();
    assert!(matches!(&errors[..], [RenderError::Scene(_), RenderError::Scene(_)]), "{errors:?}");
    session.undo();
    assert!(session.finished().radiance == before.radiance && session.take_errors().is_empty());
}

/// While a light is dragged pictures appear, no hierarchy is built, and no visible point is found anew.
#[test]
fn a_dragged_light_is_seen_while_it_moves() {
    let scene = scene(640, 360);
    let renderer = renderer(scene.clone());
    let light = first_light(&renderer);
    let session = Session::new(renderer);
    let before = session.finished();
    let mut latencies: Vec<f64> = Vec::new();
    let (mut seen, mut last_step) = (0, 0);
    // Longer on a busy machine.
    while last_step < 60 || latencies.len() < 6 && last_step < 600 {
        last_step += 1;
        let step = last_step;
        session.edit(Edit::Light(light, turned(&scene, 0, step).into()));
        thread::sleep(Duration::from_millis(16));
        let picture = session.picture();
        if picture.edits != seen && picture.latency > 0.0 {
            latencies.push(picture.latency);
            seen = picture.edits;
        }
    }
    latencies.sort_by(f64::total_cmp);
    let after = session.finished();
    let late = latencies.get(latencies.len() * 95 / 100).copied().unwrap_or(f64::INFINITY);
    println!("{} pictures of {last_step} edits, 95 % within {:.1} ms", latencies.len(), 1e3 * late);
    assert!(latencies.len() > 5, "{} pictures of {last_step} edits", latencies.len());
    let (upkeep, first) = (after.upkeep, before.upkeep);
    assert_eq!(upkeep.hierarchy_builds + upkeep.hierarchy_refits, first.hierarchy_builds + first.hierarchy_refits);
    assert_eq!(upkeep.silhouette_builds + upkeep.silhouette_refits, first.silhouette_builds + first.silhouette_refits);
    let mut last = scene;
    last.lights[0] = turned(&last, 0, last_step);
    assert!(after.divisor == 1 && after.radiance == of_new(last));
}

/// A lamp moves among others, and sums may be seen; the pictures that follow have the bits of a new renderer.
#[test]
fn a_light_among_others_ends_in_the_picture_of_a_new_renderer() {
    let mut scene = scene(120, 68);
    (1..7).for_each(|turn| scene.lights.push(turned(&scene, 0, 40 * turn)));
    let renderer = renderer(scene.clone());
    let light = first_light(&renderer);
    let session = Session::new(renderer);
    // Any picture takes longer.
    session.set_budget(1e-5);
    drop(session.finished());
    let mut sums = 0;
    for step in 1..=20 {
        session.edit(Edit::Light(light, turned(&scene, 0, step).into()));
        while session.picture().edits < step as u64 {
            thread::yield_now();
        }
        let picture = session.picture();
        sums += usize::from(picture.is_sum);
        assert!(!(picture.is_sum && picture.is_whole()));
    }
    println!("{sums} sums of 20 pictures");
    let mut last = scene;
    last.lights[0] = turned(&last, 0, 20);
    let after = session.finished();
    assert!(after.is_whole() && after.radiance == of_new(last.clone()));
    // Another change, and nothing is kept.
    let camera = scene::Camera { eye: last.camera.eye + Vec3::X * 0.3, ..last.camera };
    session.edit(Edit::Camera(camera));
    session.edit(Edit::Light(light, turned(&last, 0, 3).into()));
    last.lights[0] = turned(&last, 0, 3);
    last.camera = camera;
    assert!(session.finished().radiance == of_new(last) && session.take_errors().is_empty());
}

/// A session of much work ends at once.
#[test]
fn a_session_ends_at_once() {
    let session = Session::new(
        Renderer::new(
            scene(1920, 1080),
            Animation::default(),
            Settings { accuracy: Accuracy::new(0.001), samples: 16.into(), ..Settings::default() },
        )
        .unwrap(),
    );
    thread::sleep(Duration::from_millis(50));
    let watch = scene::Stopwatch::start();
    drop(session);
    let seconds = watch.seconds();
    println!("ended after {:.1} ms", 1e3 * seconds);
    assert!(seconds < 2.0, "{seconds} s");
}

/// The parts of the lights are the pixel, and the reference is near it.
#[test]
fn a_pixel_is_taken_apart() {
    let scene = scene(64, 36);
    let mut direct = renderer(scene);
    let image = direct.render().unwrap();
    let session = Session::new(direct);
    let before = session.finished();
    let mut penumbrae = 0;
    for (x, y) in [(20, 30), (32, 30), (40, 28), (26, 24), (50, 33)] {
        let Some(probe) = session.probe(x, y, 2048).recv().unwrap().unwrap() else { continue };
        let pixel = image.radiance[(y * 64 + x) as usize];
        assert_eq!(probe.radiance, pixel);
        let sum: Vec3 = probe.lights.iter().map(|part| part.radiance).sum();
        assert!((sum - pixel).abs().max_element() <= 1e-5 * pixel.max_element() + 1e-6, "{sum} {pixel}");
        let [want, error] = probe.reference;
        let allowed = 5.0 * error.max_element() + 0.01 * want.max_element() + 1e-4;
        assert!((want - sum).abs().max_element() <= allowed, "{x} {y}: {want} {sum}");
        penumbrae += probe.lights.iter().filter(|part| part.visible.x > 0.0 && part.visible.x < 1.0).count();
    }
    println!("{penumbrae} in penumbra");
    assert!(session.probe(0, 0, 8).recv().unwrap().unwrap().is_none_or(|probe| probe.radiance.is_finite()));
    // Questions leave the picture as it is.
    assert!(session.finished().radiance == before.radiance);
}

/// A pixel of a floor under a blocker and a lamp, taken apart.
fn under(blocker: scene::Object) -> session::LightPart {
    let floor = [(-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let floor = scene::Mesh { positions: floor.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Default::default() };
    let lamp = lobe_core::Sphere { center: Vec3::new(0.0, 3.0, 0.0), radius: 1.0 };
    let camera = scene::Camera { eye: Vec3::new(0.0, 0.6, 2.0), target: Vec3::ZERO, ..scene::Camera::default() };
    let scene = Scene {
        width: 32,
        height: 32,
        camera,
        objects: vec![blocker, scene::Object::mesh("floor", floor, 0, scene::Proxy::None)],
        materials: vec![brdf::Material::lambert(Vec3::ONE)],
        lights: vec![lighting::SphereLight::new(lamp, Vec3::splat(10.0)).into()],
        ..Scene::default()
    };
    let mut probe = Session::new(renderer(scene)).probe(16, 16, 8).recv().unwrap().unwrap().unwrap();
    assert!(probe.pick.receiver.position.length() < 0.2, "{}", probe.pick.receiver.position);
    probe.lights.remove(0)
}

/// Whether a line lies between light and shadow.
fn divides(part: &session::LightPart, outline: &session::Outline) -> bool {
    let mask = part.mask.as_ref().unwrap();
    let sample = |place: Vec2| {
        let [column, row] = (place * Vec2::new(mask.size[0] as f32, mask.size[1] as f32)).to_array();
        mask.sample(mask.direction(column, row))
    };
    let middle = 0.5 * (outline.places[0] + outline.places[1]);
    let across = 0.02 * (outline.places[1] - outline.places[0]).perp().normalize();
    let sides = [sample(middle + across), sample(middle - across)];
    sides.contains(&MaskSample::Blocked) && sides.contains(&MaskSample::Lit)
}

/// A square has four sides, and the line between its triangles is none; of two spheres the parts of their circles outside each other are.
#[test]
fn outlines_are_those_of_the_mask() {
    let corners = [(-0.1, -0.14), (0.12, -0.14), (0.12, 0.1), (-0.1, 0.1)].map(|(x, z)| Vec3::new(x, 1.0, z));
    let square =
        scene::Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..Default::default() };
    let square = scene::Object::mesh("square", square, 0, scene::Proxy::None);
    let part = under(scene::Object { strategy: Some(scene::Strategy::Silhouettes), ..square });
    assert_eq!(part.outlines.len(), 4);
    for outline in &part.outlines {
        let is_corner = |end: &Vec3| corners.iter().any(|corner| corner.distance(*end) < 1e-5);
        assert!(outline.ends.iter().all(is_corner) && divides(&part, outline), "{outline:?}");
    }
    let sphere = |x: f32, radius: f32| lobe_core::Sphere { center: Vec3::new(x, 1.0, 0.0), radius };
    let part = under(scene::Object::spheres("spheres", vec![sphere(-0.06, 0.1), sphere(0.07, 0.08)], 0));
    let count = part.outlines.len();
    let dividing = part.outlines.iter().filter(|outline| divides(&part, outline)).count();
    println!("{count} lines, {dividing} of them between light and shadow");
    assert!((50..90).contains(&count) && 10 * dividing > 9 * count, "{dividing} of {count}");
}

/// A thread that panics while its picture is waited for: the newest picture there is comes at once.
#[test]
fn a_thread_that_ends_keeps_no_one_waiting() {
    let session = Session::new(renderer(scene(48, 27)));
    let before = session.finished();
    let answer = session.change(|_: &mut Renderer| {
        thread::sleep(Duration::from_millis(200));
        panic!("on purpose");
    });
    let after = session.finished();
    assert!(answer.recv().is_err() && Arc::ptr_eq(&before, &after));
}
