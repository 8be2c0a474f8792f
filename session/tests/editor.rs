//! An editor is ahead of the pictures and never off them; layers and the reference come beside them.

#![allow(clippy::unwrap_used, reason = "in tests")]

use core::time::Duration;
use glam::{Mat4, Vec3};
use renderer::{LayerSet, Renderer, Settings};
use scene::{Animation, Mesh, Object, Proxy, Scene, Stopwatch, Strategy, Surface};
use session::{Edit, Editor, Session, Truth, lamp};
use std::sync::mpsc;
use std::thread;

fn session() -> Session {
    let scene = Scene { width: 64, height: 36, ..scene::builtin() };
    Session::new(Renderer::new(scene, Animation::default(), Settings::default()).unwrap())
}

fn editor() -> Editor {
    let session = session();
    drop(session.finished());
    let mut editor = Editor::new(session);
    editor.follow();
    editor
}

fn settle(editor: &mut Editor) {
    drop(editor.session().finished());
    editor.follow();
}

/// An object that comes to a light and goes again leaves it, whatever it emits.
#[test]
fn additions_are_taken_back_alone() {
    let mut scene = scene::builtin();
    let panel = Mesh::quad(Vec3::Y * 2.0, Vec3::X, Vec3::Z);
    scene.surfaces = vec![Surface { emission: Vec3::ONE, ..Surface::default() }];
    scene.lights = lighting::emissive_mesh(&panel.positions, &panel.triangles, Vec3::ONE).unwrap().lights;
    let mut renderer = Renderer::new(scene.clone(), Animation::default(), Settings::default()).unwrap();
    let object = Object::mesh("panel", panel, 0, Proxy::None);
    let undo = Edit::AddObject(Box::new(object)).apply(&mut renderer).unwrap();
    let with = renderer.scene().clone();
    let redo = undo.apply(&mut renderer).unwrap();
    assert!(*renderer.scene() == scene);
    let undo = redo.apply(&mut renderer).unwrap();
    assert!(*renderer.scene() == with);
    undo.apply(&mut renderer).unwrap();
    assert!(*renderer.scene() == scene);
}

#[test]
fn changes_are_seen_at_once_and_stay_as_pictures_show_them() {
    let mut editor = editor();
    let (item, object) = (editor.scene().lights[0].clone(), editor.scene().objects[2].clone());
    let moved = lamp::shifted(&item.light, Vec3::X);
    editor.set_light(item.handle, moved.clone());
    editor.set_transform(object.handle, Mat4::from_translation(Vec3::Y));
    assert!(editor.is_waiting() && !editor.is_finished());
    assert_eq!(editor.scene().lights[0].light, moved);
    let ahead = editor.object(object.handle).unwrap().bounds;
    settle(&mut editor);
    assert!(editor.is_finished());
    assert_eq!((editor.scene().lights[0].light.clone(), editor.scene().steps), (moved, [2, 0]));
    let bounds = editor.object(object.handle).unwrap().bounds;
    assert!((bounds.min - ahead.min).length() < 1e-5 && (bounds.min - object.bounds.min - Vec3::Y).length() < 1e-5);
    // A refused change is gone with the next picture.
    let refused = lamp::with_radiance(&item.light, Vec3::splat(-1.0));
    editor.set_light(item.handle, refused.clone());
    assert_eq!(editor.scene().lights[0].light, refused);
    settle(&mut editor);
    assert_ne!(editor.scene().lights[0].light, refused);
    assert_eq!(editor.take_errors().len(), 1);
}

#[test]
fn several_edits_are_one_step_or_none() {
    let mut editor = editor();
    let before = editor.picture().clone();
    let knot = editor.scene().objects[2].handle;
    editor.show(knot, false, Some(Strategy::None));
    settle(&mut editor);
    assert!(editor.scene().steps == [1, 0] && editor.picture().radiance != before.radiance);
    editor.undo();
    settle(&mut editor);
    assert!(editor.picture().radiance == before.radiance);
    let object = editor.object(knot).unwrap();
    assert!(object.visible && object.strategy.is_none());
    // The second one is refused: the first is taken back.
    let flat = Edit::Transform(knot, Mat4::from_scale(Vec3::ZERO));
    editor.session().edit(Edit::All(vec![Edit::Visible(knot, false), flat]));
    settle(&mut editor);
    assert!(editor.picture().radiance == before.radiance && editor.take_errors().len() == 1);
}

#[test]
fn layers_come_with_pictures_and_are_no_step() {
    let mut editor = editor();
    assert!(editor.picture().layers.normals.is_empty());
    editor.session().set_layers(LayerSet { normals: true, unshadowed: true, ..LayerSet::NONE });
    let watch = Stopwatch::start();
    while editor.picture().layers.normals.is_empty() && watch.seconds() < 60.0 {
        thread::sleep(Duration::from_millis(2));
        editor.follow();
    }
    let (layers, steps) = (&editor.picture().layers, editor.scene().steps);
    assert!(!layers.normals.is_empty() && !layers.unshadowed.is_empty() && steps == [0, 0]);
    // Settings that change keep them.
    editor.set_settings(Settings { layers: LayerSet::NONE, ..editor.scene().settings.clone() });
    settle(&mut editor);
    assert_eq!(editor.picture().layers.normals.len(), 64 * 36);
}

/// Grows until it has so many samples.
fn grown(session: &Session, samples: u32, seen: u64) -> Truth {
    let watch = Stopwatch::start();
    loop {
        let truth = session.reference();
        if truth.edits >= seen && truth.samples >= samples {
            return (*truth).clone();
        }
        assert!(watch.seconds() < 120.0, "{} samples", truth.samples);
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn the_reference_converges_to_the_picture_and_follows_edits() {
    let session = session();
    let (tell, told) = mpsc::channel();
    session.set_listener(move || {
        let _ = tell.send(());
    });
    let off = |truth: &Truth| {
        let picture = session.finished();
        assert_eq!(truth.size, picture.size);
        let sum = |v: Vec3| f64::from(v.element_sum());
        let all: f64 = picture.radiance.iter().map(|v| sum(*v)).sum();
        picture.radiance.iter().zip(&truth.radiance).map(|(a, b)| sum((*a - *b).abs())).sum::<f64>() / all
    };
    session.set_reference(512);
    let (few, many) = (grown(&session, 8, 0), grown(&session, 512, 0));
    println!("off by {:.4} and {:.4}", off(&few), off(&many));
    assert!(off(&many) < 0.01 && off(&many) <= off(&few));
    assert!(
        many.unshadowed.iter().zip(&many.radiance).all(|(u, r)| (*u - *r).min_element() > -1e-3 * (1.0 + u.length()))
    );
    // Another accuracy leaves it as it is; another light does not.
    let settings = Settings { accuracy: shading::Accuracy::new(0.02), ..Settings::default() };
    session.edit(Edit::Settings(Box::new(settings)));
    assert!(session.finished().seen <= session.reference().edits);
    let scene = session.finished().scene.clone();
    let light = lamp::shifted(&scene.lights[0].light, 2.0 * Vec3::X);
    session.edit(Edit::Light(scene.lights[0].handle, Box::new(light)));
    let picture = session.finished();
    assert_eq!(picture.seen, picture.edits);
    let again = grown(&session, 256, picture.seen);
    assert!(off(&again) < 0.02, "{}", off(&again));
    assert!(told.try_iter().count() > 3);
}

#[test]
fn spheres_that_block_follow_their_object() {
    let mut editor = editor();
    let spheres = |editor: &Editor| {
        let set = editor.session().query(|renderer| renderer.blocker_spheres().clone()).recv().unwrap();
        let own = set.objects.iter().zip(set.spheres).filter(|(object, _)| **object == 2);
        own.map(|(_, sphere)| sphere.center).collect::<Vec<_>>()
    };
    let (before, knot) = (spheres(&editor), editor.scene().objects[2].clone());
    assert!(before.len() > 10, "{}", before.len());
    assert!(before.iter().all(|center| knot.bounds.union(knot.bounds.with_point(*center)) == knot.bounds));
    editor.set_transform(knot.handle, Mat4::from_translation(Vec3::Y));
    settle(&mut editor);
    let after = spheres(&editor);
    assert!(before.iter().zip(&after).all(|(a, b)| (*b - *a - Vec3::Y).length() < 1e-5));
    editor.set_strategy(knot.handle, Some(Strategy::Silhouettes));
    settle(&mut editor);
    assert_eq!(spheres(&editor), []);
}
