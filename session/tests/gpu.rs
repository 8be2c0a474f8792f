//! Pictures that stay on a GPU: ignored without an adapter.

use glam::{Mat4, Vec3};
use libtest_mimic::{Arguments, Trial};
use renderer::{Backend, Device, Gpu, Renderer, Settings};
use session::{Edit, Picture, Session};
use std::sync::Arc;

fn main() {
    let gpu = match Backend::open(Device::Gpu) {
        // As a window's: other threads use it at the same time.
        Ok(backend) => backend.gpu().map(|own| Gpu::from_device(own.device().clone(), own.queue().clone())),
        Err(_) => None,
    };
    let trial = |name: &str, test: fn(&Gpu)| {
        let own = gpu.clone();
        let run = move || {
            test(own.as_ref().ok_or("a GPU")?);
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(gpu.is_none())
    };
    let trials = vec![
        trial("pictures_stay_where_they_are_made", pictures_stay_where_they_are_made),
        trial("a_picture_is_whole_while_others_are_made", a_picture_is_whole_while_others_are_made),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}

/// A session on the CPU, whose settings may request this GPU.
fn session(gpu: &Gpu) -> Session {
    let mut scene = scene::builtin();
    (scene.width, scene.height) = (64, 36);
    let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings::default()).expect("a valid scene");
    renderer.use_gpu(Some(gpu.clone()));
    Session::new(renderer)
}

fn set_device(session: &Session, device: Device) {
    let settings = session.finished().scene.settings.clone();
    session.edit(Edit::Settings(Box::new(Settings { device, ..settings })));
}

fn move_light(session: &Session, by: Vec3) {
    let item = session.finished().scene.lights[0].clone();
    session.edit(Edit::Light(item.handle, item.light.moved(Mat4::from_translation(by)).into()));
}

fn difference(a: &Picture, b: &Picture) -> f32 {
    let [a, b] = [a, b].map(|picture| picture.pixels().expect("pixels"));
    assert_eq!((a.len(), b.len()), (64 * 36, 64 * 36));
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}

/// Pictures of the CPU are there as before; those of the GPU stay on it if that is requested, and come back where it is not. All show the
/// same.
fn pictures_stay_where_they_are_made(gpu: &Gpu) {
    let session = session(gpu);
    session.set_on_gpu(true);
    let of_cpu = session.finished();
    assert!(!of_cpu.is_on_gpu() && !of_cpu.is_empty() && of_cpu.radiance.len() == 64 * 36);
    set_device(&session, Device::Gpu);
    let staying = session.finished();
    assert_eq!(session.take_errors().len(), 0);
    assert!(staying.is_on_gpu() && !staying.is_empty() && staying.radiance.is_empty());
    assert_eq!(staying.size, [64, 36]);
    let of_device = staying.on_gpu.as_ref().expect("on the GPU");
    assert!(of_device.gpu().device() == gpu.device() && !of_device.is_read());
    assert!(difference(&of_cpu, &staying) < 1e-3 && of_device.is_read());
    session.set_on_gpu(false);
    move_light(&session, Vec3::X);
    let read = session.finished();
    assert!(!read.is_on_gpu() && difference(&of_cpu, &read) > 0.01);
    session.set_on_gpu(true);
    session.undo();
    assert!(difference(&staying, &session.finished()) < 1e-6);
}

/// A picture that is looked at keeps its pixels, however many come after it.
fn a_picture_is_whole_while_others_are_made(gpu: &Gpu) {
    let session = session(gpu);
    session.set_on_gpu(true);
    set_device(&session, Device::Gpu);
    let held = session.finished();
    let copy: Vec<Arc<Picture>> = (0..6)
        .map(|_| {
            move_light(&session, 0.3 * Vec3::X);
            session.close_step();
            session.finished()
        })
        .collect();
    assert!(copy.iter().all(|picture| difference(&held, picture) > 1e-3));
    for _ in 0..6 {
        session.undo();
    }
    assert!(session.finished().is_on_gpu());
    assert!(difference(&held, &session.finished()) < 1e-6);
    assert!(copy.windows(2).all(|pair| difference(&pair[0], &pair[1]) > 1e-3));
}
