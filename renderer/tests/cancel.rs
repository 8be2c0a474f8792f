//! Requests to stop: pictures end soon, and the next picture is right.

use core::ops::ControlFlow;
use glam::{Mat4, Vec3};
use lighting::SphereLight;
use lobe_core::Sphere;
use renderer::{RenderError, Renderer, Settings};
use scene::{Animation, Cancel, Object, Proxy, Scene, Strategy};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use test_scenes::{floor_and_sphere, globe};

/// A scene that shades slowly: a mesh in penumbra under several wide lights.
fn slow(width: u32, height: u32) -> Scene {
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (width, height);
    let mesh = globe(60, Vec3::new(-0.8, 0.8, 0.4), 0.5, true);
    let inner = Sphere { center: Vec3::new(-0.8, 0.8, 0.4), radius: 0.48 };
    scene.objects.push(Object::mesh("globe", mesh, 0, Proxy::Spheres(vec![inner])));
    for k in 0..6 {
        let mut light = scene.lights[0].sphere().expect("a sphere");
        light.center.x += 0.3 * (k as f32 - 2.5);
        light.radius *= 2.0;
        scene.lights.push(SphereLight::new(light, Vec3::ONE).into());
    }
    scene
}

const STRATEGIES: [Option<Strategy>; 4] =
    [Some(Strategy::Silhouettes), Some(Strategy::Spheres), Some(Strategy::Rays), Some(Strategy::ShadowMap)];

fn renderer(scene: Scene, strategy: Option<Strategy>) -> Renderer {
    Renderer::new(scene, Animation::default(), Settings { strategy, ..Settings::default() }).expect("a scene")
}

/// Runs the tests one by one, since they measure time and share the threads.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Seconds of computing time of all threads of this process, if Linux reports them: other programs do not count.
fn computed() -> Option<Duration> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let texts = tasks.flatten().filter_map(|task| std::fs::read_to_string(task.path().join("schedstat")).ok());
    Some(Duration::from_nanos(texts.filter_map(|text| text.split(' ').next()?.parse::<u64>().ok()).sum()))
}

/// Cancels a picture after some time. Returns the time from the request to the end, and the most computing time of a thread of the
/// pool in it, if the request came before the picture was done.
fn stop_after(renderer: &mut Renderer, wait: Duration) -> Option<[Duration; 2]> {
    let cancel = Cancel::new();
    renderer.set_cancel(cancel.clone());
    let other = thread::spawn(move || {
        thread::sleep(wait);
        let before = computed();
        cancel.cancel();
        (Instant::now(), before)
    });
    let image = renderer.render();
    let (end, after) = (Instant::now(), computed());
    let (start, before) = other.join().expect("a request");
    let work = after.zip(before).map_or(Duration::ZERO, |(after, before)| after.saturating_sub(before));
    match image {
        Err(RenderError::Cancelled) => {
            Some([end.saturating_duration_since(start), work / rayon::current_num_threads() as u32])
        }
        Err(error) => panic!("{error}"),
        Ok(_) => None,
    }
}

#[test]
fn pictures_end_soon_and_the_next_one_is_right() {
    let _alone = alone();
    for strategy in STRATEGIES {
        let scene = slow(320, 180);
        let fresh = renderer(scene.clone(), strategy).render().expect("a picture");
        let mut edited = renderer(scene, strategy);
        // Stops during hierarchies, silhouettes and maps, each of which finishes one item.
        for wait in [0, 1, 3, 7, 15, 30] {
            stop_after(&mut edited, Duration::from_millis(wait));
        }
        // Prepares everything but the visible points and their shading.
        edited.set_cancel(Cancel::new());
        edited.warm_up(&mut |_| ControlFlow::Continue(())).expect("a scene");
        let mut delays = Vec::new();
        for wait in [1, 3, 7, 15, 30, 60] {
            let camera = edited.scene().camera;
            edited.set_camera(camera).expect("a camera");
            delays.extend(stop_after(&mut edited, Duration::from_millis(wait)));
        }
        edited.set_cancel(Cancel::new());
        let image = edited.render().expect("a picture");
        assert!(image.radiance == fresh.radiance, "{strategy:?}");
        assert!(!delays.is_empty(), "{strategy:?}: done before every request");
        // 5 ms on an idle machine. Here other programs may run, and tests are only partly optimised.
        let worst = |k: usize| delays.iter().map(|delay| delay[k]).max().expect("a delay");
        assert!(worst(0) < Duration::from_secs(1) && worst(1) < Duration::from_millis(20), "{strategy:?}: {delays:?}");
    }
}

#[test]
fn a_request_that_was_made_before_stops_everything() {
    let _alone = alone();
    let mut renderer = renderer(slow(64, 36), None);
    let cancel = Cancel::new();
    cancel.cancel();
    renderer.set_cancel(cancel);
    let before = renderer.upkeep();
    assert!(matches!(renderer.render(), Err(RenderError::Cancelled)));
    assert_eq!(renderer.upkeep(), before);
}

/// An edit between two pictures is not lost, whatever the request has stopped.
#[test]
fn edits_survive_a_request() {
    let _alone = alone();
    let mut edited = renderer(slow(160, 90), None);
    edited.render().expect("a picture");
    let object = edited.objects().nth(2).expect("the globe").0;
    for (k, wait) in [0, 1, 2, 5].into_iter().enumerate() {
        let shift = Mat4::from_translation(Vec3::X * 0.05 * (k + 1) as f32);
        edited.set_transform(object, shift).expect("a shift");
        stop_after(&mut edited, Duration::from_millis(wait));
    }
    edited.set_cancel(Cancel::new());
    let image = edited.render().expect("a picture");
    let fresh = renderer(edited.scene().clone(), None).render().expect("a picture");
    assert!(image.radiance == fresh.radiance);
}

/// The delay on this machine: `cargo test --release -p cosine-lobes-renderer --test cancel -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement, for an idle machine"]
fn report() {
    let _alone = alone();
    for strategy in STRATEGIES {
        let mut edited = renderer(slow(1280, 720), strategy);
        edited.render().expect("a picture");
        let light = edited.lights().next().map(|(handle, light)| (handle, light.clone())).expect("a light");
        let mut delays = Vec::new();
        for k in 0..60 {
            edited.set_light(light.0, light.1.clone()).expect("a light");
            delays.extend(stop_after(&mut edited, Duration::from_micros(500 + 900 * k)));
        }
        let show = |k: usize| {
            let mut all: Vec<f64> = delays.iter().map(|delay| 1e3 * delay[k].as_secs_f64()).collect();
            all.sort_unstable_by(f64::total_cmp);
            let at = |part: f64| all[((all.len() - 1) as f64 * part) as usize];
            format!("median {:.2} ms, 99 % {:.2} ms, most {:.2} ms", at(0.5), at(0.99), at(1.0))
        };
        println!("{strategy:?}: {} stopped; {}; computed by each thread: {}", delays.len(), show(0), show(1));
    }
}
