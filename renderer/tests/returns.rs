//! Questions between an edit and the next picture, and objects that come back.

use brdf::{Brdf, Material, Model};
use glam::{Mat4, Vec3};
use lighting::{SphereLight, emissive_mesh};
use lobe_core::{BrdfLobe, Receiver, Sphere};
use renderer::{EditError, LayerSet, Method, RenderError, Renderer, Settings, Window};
use scene::{Animation, Camera, Mesh, Object, Proxy, Scene, Shape, Strategy, Surface};
use shading::BrdfLobes;
use std::sync::Arc;

/// A floor, a box over it and a lamp, seen from above or from below the floor.
fn stage(eye: f32) -> Scene {
    let lamp = Sphere { center: Vec3::new(1.0, 4.0, 1.0), radius: 0.4 };
    Scene {
        width: 48,
        height: 32,
        camera: Camera { eye: Vec3::new(0.0, eye, 6.0), target: Vec3::new(0.0, 0.4 * eye, 0.0), ..Camera::default() },
        materials: [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE].map(|color| Material::lambert(0.8 * color)).to_vec(),
        objects: vec![
            Object::mesh("floor", Mesh::quad(Vec3::ZERO, Vec3::X * 4.0, Vec3::NEG_Z * 4.0), 0, Proxy::None),
            Object::mesh("box", Mesh::cuboid(Vec3::new(-0.8, 0.6, 0.0), Vec3::splat(0.8)), 1, Proxy::None),
        ],
        lights: vec![SphereLight::new(lamp, Vec3::splat(10.0)).into()],
        ..Scene::default()
    }
}

fn renderer(scene: Scene) -> Renderer {
    Renderer::new(scene, Animation::default(), Settings::default()).expect("a scene")
}

fn check_same(edited: &mut Renderer, what: &str) {
    let fresh = renderer(edited.scene().clone()).render().expect("a picture");
    assert!(edited.render().expect("a picture").radiance == fresh.radiance, "{what}");
}

type Question = fn(&mut Renderer);

/// Questions that bring the renderer up to date.
const QUESTIONS: [(&str, Question); 6] = [
    ("pick", |r| _ = r.pick(10, 10)),
    ("exposure", |r| _ = r.exposure()),
    ("with_world", |r| r.with_world(|_| ())),
    ("unshadowed", |r| drop(r.unshadowed(1, 1))),
    ("coverage", |r| drop(r.coverage(&Window::whole(48, 32)).expect("a window"))),
    ("render_apart", |r| drop(r.render_apart(&Window::whole(48, 32), LayerSet::NONE, 1).expect("a picture"))),
];

/// A floor that nothing was behind blocks light as soon as something is.
#[test]
fn questions_after_an_edit_leave_the_picture() {
    for (name, ask) in QUESTIONS {
        let mut edited = renderer(stage(-1.5));
        edited.render().expect("a picture");
        let object = edited.objects().nth(1).expect("the box").0;
        edited.set_transform(object, Mat4::from_translation(Vec3::NEG_Y * 2.0)).expect("a move");
        ask(&mut edited);
        check_same(&mut edited, name);
        assert_ne!(edited.plan().of(0), Strategy::None, "{name}");
    }
}

#[test]
fn shadow_maps_follow_strategies_whatever_is_asked() {
    for strategy in [Some(Strategy::None), Some(Strategy::Rays), None] {
        for (name, ask) in QUESTIONS {
            let mut scene = stage(2.5);
            scene.objects.iter_mut().for_each(|object| object.strategy = Some(Strategy::ShadowMap));
            let mut edited = renderer(scene);
            edited.render().expect("a picture");
            let object = edited.objects().nth(1).expect("the box").0;
            edited.set_object_strategy(object, strategy).expect("a strategy");
            ask(&mut edited);
            check_same(&mut edited, name);
        }
    }
}

#[test]
fn windows_outside_the_picture_are_refused() {
    let mut renderer = renderer(stage(2.5));
    let whole = Window::whole(48, 32);
    let beyond = Window { columns: 40..60, ..whole.clone() };
    let other = Window { image: [96, 64], ..whole };
    for window in [beyond, other] {
        let refused = renderer.coverage(&window);
        assert!(matches!(refused, Err(RenderError::Setting { name: "window", .. })), "{refused:?}");
    }
}

/// Its number may be another one by then.
#[test]
fn objects_come_back_with_their_material() {
    let mut edited = renderer(stage(2.5));
    let materials: Vec<_> = edited.materials().map(|(handle, _)| handle).collect();
    let object = edited.objects().nth(1).expect("the box").0;
    edited.set_object_material(object, materials[2]).expect("a material");
    let taken = edited.take_object(object).expect("the box");
    edited.remove_material(materials[1]).expect("the material");
    edited.put_object(&taken).expect("the box");
    assert_eq!(edited.scene().materials[edited.scene().objects[1].material], Material::lambert(0.8 * Vec3::Z));
    check_same(&mut edited, "renumbered");
    let taken = edited.take_object(object).expect("the box");
    edited.remove_material(materials[2]).expect("the material");
    let before = edited.scene().clone();
    let refused = edited.put_object(&taken);
    assert!(matches!(refused, Err(RenderError::Edit(EditError::NoMaterial(_)))), "{refused:?}");
    assert!(*edited.scene() == before);
}

/// A panel that shines, and the light that stands for it.
fn with_panel() -> Scene {
    let mut scene = stage(2.5);
    let panel = Mesh::quad(Vec3::Y * 2.0, Vec3::X * 0.5, Vec3::Z * 0.5);
    let radiance = Vec3::splat(2.0);
    scene.surfaces = vec![Surface::default(); 3];
    scene.surfaces[2].emission = radiance;
    scene.lights.extend(emissive_mesh(&panel.positions, &panel.triangles, radiance).expect("a panel").lights);
    scene.objects.push(Object::mesh("panel", panel, 2, Proxy::None));
    scene
}

#[test]
fn objects_whose_lights_are_refused_stay_away() {
    let mut edited = renderer(with_panel());
    let panel = edited.objects().nth(2).expect("the panel").0;
    let taken = edited.take_object(panel).expect("the panel");
    assert_eq!((taken.lights().count(), edited.scene().lights.len()), (1, 1));
    edited.set_settings(Settings { method: Method::Paper, ..Settings::default() }).expect("settings");
    let before = edited.scene().clone();
    assert!(matches!(edited.put_object(&taken), Err(RenderError::PaperLight(..))));
    assert!(*edited.scene() == before);
    edited.set_settings(Settings::default()).expect("settings");
    edited.put_object(&taken).expect("the panel");
    check_same(&mut edited, "back");
    assert_eq!(edited.scene().lights.len(), 2);
}

/// An object that came to a light leaves without it.
#[test]
fn objects_leave_with_the_lights_that_are_named() {
    let mut edited = renderer(with_panel());
    let panel = edited.objects().nth(2).expect("the panel").0;
    let taken = edited.take_object_and(panel, &[]).expect("the panel");
    assert_eq!((taken.lights().count(), edited.scene().lights.len()), (0, 2));
    edited.put_object(&taken).expect("the panel");
    let lamp = edited.lights().nth(1).expect("its light").0;
    let taken = edited.take_object_and(panel, &[lamp]).expect("the panel");
    assert_eq!((taken.lights().collect::<Vec<_>>(), edited.scene().lights.len()), (vec![lamp], 1));
    assert!(matches!(edited.take_object_and(panel, &[lamp]), Err(RenderError::Edit(EditError::NoObject(_)))));
}

/// A diffuse model without textures.
#[derive(Debug)]
struct Plain;

impl BrdfLobes for Plain {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        Material::lambert(Vec3::ONE).brdf_lobes(at, out);
    }
}

impl Brdf for Plain {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        Material::lambert(Vec3::ONE).eval(at, v)
    }
}

impl Model for Plain {
    fn name(&self) -> &'static str {
        "plain"
    }

    fn lobe_count(&self) -> usize {
        1
    }
}

#[test]
fn vertex_colours_need_a_model_that_takes_them() {
    let mut scene = stage(2.5);
    if let Shape::Mesh(mesh) = &mut scene.objects[1].shape {
        mesh.colors = vec![Vec3::ONE; mesh.positions.len()];
    }
    let plain = Material::Custom(Arc::new(Plain));
    scene.materials.push(plain.clone());
    let mut edited = renderer(scene);
    let before = edited.scene().clone();
    let materials: Vec<_> = edited.materials().map(|(handle, _)| handle).collect();
    let object = edited.objects().nth(1).expect("the box").0;
    for refused in [
        edited.set_object_material(object, materials[4]),
        edited.set_material(materials[1], plain.clone(), Surface::default()),
    ] {
        assert!(matches!(&refused, Err(RenderError::Scene(e)) if e.to_string().contains("`plain`")), "{refused:?}");
    }
    assert!(*edited.scene() == before);
    edited.set_material(materials[2], plain, Surface::default()).expect("a material of no object");
    check_same(&mut edited, "as it was");
}
