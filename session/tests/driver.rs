//! A session without a thread gives the pictures of one with, in steps that edits come between.

#![allow(clippy::unwrap_used, reason = "in tests")]

use core::pin::pin;
use core::task::{Context, Poll, Waker};
use glam::{Mat4, Vec3};
use renderer::{LayerSet, Renderer, Settings};
use scene::{Animation, Camera, Scene};
use session::{Driver, Edit, Session, Task};

fn scene() -> Scene {
    Scene { width: 93, height: 61, ..scene::builtin() }
}

fn renderer() -> Renderer {
    Renderer::new(scene(), Animation::default(), Settings::default()).unwrap()
}

fn edits(renderer: &Renderer) -> [Edit; 3] {
    let (light, lamp) = renderer.lights().next().unwrap();
    let moved = lamp.moved(Mat4::from_translation(Vec3::new(0.4, 0.2, -0.3)));
    let object = renderer.objects().last().unwrap().0;
    let camera = renderer.scene().camera;
    [
        Edit::Light(light, moved.into()),
        Edit::Transform(object, Mat4::from_translation(Vec3::Y * 0.3)),
        Edit::Camera(Camera { eye: camera.eye + Vec3::X * 0.2, ..camera }),
    ]
}

fn of_new(edits: &[Edit]) -> Vec<Vec3> {
    let mut renderer = renderer();
    edits.iter().for_each(|edit| drop(edit.clone().apply(&mut renderer).unwrap()));
    renderer.render().unwrap().radiance
}

fn run(driver: &mut Driver) -> usize {
    let mut steps = 1;
    while driver.step() {
        steps += 1;
    }
    steps
}

#[test]
fn steps_end_in_the_picture_of_a_new_renderer() {
    let renderer = renderer();
    let edits = edits(&renderer);
    let (session, mut driver) = Session::driven(renderer);
    // So that whole pictures come in strips.
    session.set_budget(1e-6);
    session.set_layers(LayerSet { normals: true, ..LayerSet::NONE });
    assert!(session.picture().radiance.is_empty(), "nothing is done before the first step");
    let steps = run(&mut driver);
    assert_eq!(steps, 1 + 61_usize.div_ceil(8), "a coarse picture, and the strips of the whole one");
    assert!(session.picture().radiance == of_new(&[]));
    assert_eq!(session.picture().layers.normals.len(), 93 * 61);
    for (count, edit) in edits.iter().enumerate() {
        session.edit(edit.clone());
        // In the middle of a picture.
        (0..4).for_each(|_| assert!(driver.step()));
        let coarse = session.picture();
        assert_eq!(
            (coarse.divisor, coarse.edits),
            (16, count as u64 + 1),
            "the first picture after an edit is a coarse one"
        );
        assert_eq!(coarse.size, [93_usize.div_ceil(16), 61_usize.div_ceil(16)]);
    }
    assert!(driver.step());
    run(&mut driver);
    let picture = session.picture();
    assert_eq!((picture.size, picture.divisor, picture.edits), ([93, 61], 1, 3));
    assert!(picture.radiance == of_new(&edits));
    assert!(session.finished().radiance == picture.radiance, "no wait for a thread that is not there");
    assert!(!driver.step() && session.take_errors().is_empty());
}

#[test]
fn hands_that_are_told_the_same_share_a_picture() {
    let all: Vec<_> = (0..3).map(|_| Session::driven(renderer())).collect();
    let (sessions, mut drivers): (Vec<Session>, Vec<Driver>) = all.into_iter().unzip();
    let edits = edits(&renderer());
    for edit in &edits {
        sessions.iter().for_each(|session| session.edit(edit.clone()));
    }
    let mut tasks: Vec<Task> = Vec::new();
    while let Some(task) = drivers[0].task(3) {
        let parts = drivers.iter_mut().enumerate().map(|(part, driver)| driver.shade(&task, part, 3));
        let parts = parts.collect::<Vec<_>>();
        for (part, image) in parts.iter().enumerate() {
            assert_eq!(image.as_ref().unwrap().radiance.len(), task.pixels(part, 3));
        }
        drivers[0].finish(parts);
        tasks.push(task);
    }
    assert!(tasks.len() > 1 && tasks[0].divisor == 4);
    assert!(sessions[0].picture().radiance == of_new(&edits));
    drivers[1].show_scene();
    let (a, b) = (sessions[0].picture(), sessions[1].picture());
    assert_eq!((a.edits, a.scene.camera), (b.edits, b.scene.camera));
    assert_eq!(a.scene.objects.last().unwrap().transform, b.scene.objects.last().unwrap().transform);
}

#[test]
fn another_hand_makes_a_picture_again_in_later_turns() {
    let (session, mut driver) = Session::driven(renderer());
    run(&mut driver);
    let before = session.picture();
    assert!(driver.task(1).is_none());
    driver.redraw();
    let (_, mut other) = Session::driven(renderer());
    while let Some(task) = driver.task(1) {
        let part = ready(other.shade_async(&task, 0, 1));
        driver.finish(vec![part]);
    }
    let after = session.picture();
    assert!(!std::sync::Arc::ptr_eq(&before, &after));
    assert!(after.radiance == before.radiance && after.edits == before.edits && after.divisor == 1);
}

/// The result of a future that a CPU makes ready at its first poll.
fn ready<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(done) => done,
        Poll::Pending => panic!("a CPU waits for nothing"),
    }
}

#[test]
fn a_reference_grows_in_steps_and_questions_are_answered() {
    let (session, mut driver) = Session::driven(renderer());
    session.set_reference(16);
    let probe = session.probe(46, 40, 16);
    assert!(driver.step());
    assert!(probe.try_recv().unwrap().unwrap().is_some());
    run(&mut driver);
    assert_eq!(session.reference().samples, 16);
}
