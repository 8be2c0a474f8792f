//! Requests to stop: pictures end soon, and the renderer is as good as before.

use glam::{Mat4, Vec3};
use lighting::SphereLight;
use lobe_core::Sphere;
use renderer::{RenderError, Renderer, Settings};
use scene::{Animation, Cancel, Object, Proxy, Scene, Strategy};
use std::thread;
use std::time::{Duration, Instant};
use test_scenes::{floor_and_ball, globe};

/// Dear pixels: a mesh in penumbra under several wide lights.
fn slow(width: u32, height: u32) -> Scene {
    let mut scene = floor_and_ball();
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

/// Cancels a picture after some time. The time from the request to the end, if it came before the picture was done.
fn stop_after(renderer: &mut Renderer, wait: Duration) -> Option<Duration> {
    let cancel = Cancel::new();
    renderer.set_cancel(cancel.clone());
    let other = thread::spawn(move || {
        thread::sleep(wait);
        cancel.cancel();
        Instant::now()
    });
    let image = renderer.render();
    let end = Instant::now();
    let asked = other.join().expect("a request");
    match image {
        Err(RenderError::Cancelled) => Some(end.saturating_duration_since(asked)),
        Err(error) => panic!("{error}"),
        Ok(_) => None,
    }
}

#[test]
fn pictures_end_soon_and_the_next_one_is_right() {
    for strategy in STRATEGIES {
        let scene = slow(320, 180);
        let fresh = renderer(scene.clone(), strategy).render().expect("a picture");
        let mut edited = renderer(scene, strategy);
        let mut delays = Vec::new();
        for wait in [0, 1, 3, 7, 15, 30, 60] {
            delays.extend(stop_after(&mut edited, Duration::from_millis(wait)));
        }
        edited.set_cancel(Cancel::new());
        let image = edited.render().expect("a picture");
        assert!(image.radiance == fresh.radiance, "{strategy:?}");
        assert!(!delays.is_empty(), "{strategy:?}: done before every request");
        // 5 ms on an idle machine; threads of others may come first here.
        let worst = delays.iter().max().expect("a delay");
        assert!(*worst < Duration::from_millis(500), "{strategy:?}: {delays:?}");
    }
}

#[test]
fn a_request_that_was_made_before_stops_everything() {
    let mut renderer = renderer(slow(64, 36), None);
    let cancel = Cancel::new();
    cancel.cancel();
    renderer.set_cancel(cancel);
    let before = renderer.upkeep();
    assert!(matches!(renderer.render(), Err(RenderError::Cancelled)));
    assert_eq!(renderer.upkeep(), before);
}

/// An edit in between is not lost, whatever the request has cut short.
#[test]
fn edits_survive_a_request() {
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
    for strategy in STRATEGIES {
        let mut edited = renderer(slow(1280, 720), strategy);
        edited.render().expect("a picture");
        let light = edited.lights().next().map(|(handle, light)| (handle, light.clone())).expect("a light");
        let mut delays = Vec::new();
        for k in 0..200 {
            edited.set_light(light.0, light.1.clone()).expect("a light");
            delays.extend(stop_after(&mut edited, Duration::from_micros(500 + 137 * k)));
        }
        delays.sort_unstable();
        let at = |share: f64| delays[((delays.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e3;
        println!(
            "{strategy:?}: {} stopped; median {:.2} ms, 99 % {:.2} ms, most {:.2} ms",
            delays.len(),
            at(0.5),
            at(0.99),
            at(1.0)
        );
    }
}
