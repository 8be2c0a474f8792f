//! Changes of a session written back into the scene file: the file gives the new scene, and keeps all that is not changed.

#![cfg(feature = "files")]
#![allow(clippy::unwrap_used, reason = "in tests")]

use glam::{Mat4, Quat, Vec3};
use lighting::Light;
use renderer::{Renderer, Settings};
use scene::{Camera, Projection, Strategy};
use session::{Editor, NewLight, Primitive, SaveError, Session, Snapshot, gloss, lamp, save};
use std::fs;
use std::path::{Path, PathBuf};

const TEXT: &str = r#"# A still life.

[image]
width = 64 # columns
height = 36

[camera]
eye = [0.0, 2.0, 6.0]       # the eye
target = [0.00, 0.50, 0.00]
fov = 35

# Materials

[materials.gloss]
model = "modified-phong"
kd = [0.30, 0.20, 0.10]
ks = 0.20
exponent = 40 # sharp

[materials.clay]
model = "lambert"
albedo = 0.50

# Objects

[[objects]]
name = "floor"
plane = { point = [0, 0, 0], normal = [0, 1, 0], size = 20 }
material = "clay"

[[objects]] # the box
name = "box"
box = { center = [0.0, 0.5, 0.0], size = [1, 1, 1] }
material = "gloss"
translate = [0.5, 0.0, 0.0] # to the right

[[objects]]
name = "ball"
sphere = { center = [-1.0, 0.5, 0.3], radius = 0.5 }

# Lights

[[lights]]
kind = "sphere"
center = [1.0, 4.0, 2.0] # above
radius = 0.5
flux = 300 # watts

[[lights]]
kind = "rectangle"
center = [-2.0, 3.0, 0.0]
u = [0.5, 0.0, 0.0]
v = [0.0, 0.0, -0.3]
radiance = [4.0, 5.0, 6.0]

[[lights]]
kind = "spheres"
spheres = [[0.0, 3.0, 1.0, 0.1], [0.5, 3.0, 1.0, 0.1]]
radiance = 20

[[lights]]
kind = "sun"
direction = [0.3, -1.0, -0.2]
angle = 2.0
irradiance = 1.5
"#;

struct Opened {
    editor: Editor,
    before: Snapshot,
}

fn open(path: &Path) -> Opened {
    let (scene, animation, warnings) = scene_files::load_animated(path).unwrap();
    // Lights that are added are all in one place.
    assert!(warnings.iter().all(|line| line.contains("partly on others")), "{warnings:?}");
    let session = Session::new(Renderer::new(scene, animation, Settings::default()).unwrap());
    drop(session.finished());
    let mut editor = Editor::new(session);
    editor.follow();
    Opened { before: editor.scene().clone(), editor }
}

/// Waits until pictures show all changes; none was refused.
fn settle(editor: &mut Editor) {
    drop(editor.session().finished());
    editor.follow();
    assert!(editor.is_finished());
    let errors = editor.take_errors();
    assert!(errors.is_empty(), "{errors:?}");
}

fn file(folder: &tempfile::TempDir, text: &str) -> PathBuf {
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    path
}

fn light(editor: &Editor, number: usize) -> (renderer::LightHandle, Light) {
    let item = &editor.scene().lights[number];
    (item.handle, item.light.clone())
}

#[test]
fn nothing_changed_leaves_the_file_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, TEXT);
    let Opened { editor, before } = open(&path);
    save(&path, &before, editor.scene()).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), TEXT);
}

/// A camera's projection with its number: changed, and exchanged for others.
#[test]
fn projections_are_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, TEXT);
    let Opened { mut editor, mut before } = open(&path);
    let kinds = [
        (Projection::Orthographic { height: 4.0 }, "projection = \"orthographic\"", "height = 4.0"),
        (Projection::Orthographic { height: 2.5 }, "projection = \"orthographic\"", "height = 2.5"),
        (Projection::Panoramic, "projection = \"panoramic\"", ""),
        (Projection::perspective(1.0), "projection = \"perspective\"", "fov = 57.29"),
    ];
    for (projection, name, number) in kinds {
        editor.set_camera(Camera { projection, ..editor.scene().camera });
        settle(&mut editor);
        before = save(&path, &before, editor.scene()).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(name) && text.contains(number), "{text}");
        let count = ["fov", "height ="].map(|key| text.matches(key).count());
        assert_eq!(count[0], usize::from(number.starts_with("fov")), "{text}");
        // The picture has a height, too.
        assert_eq!(count[1], 1 + usize::from(number.starts_with("height")), "{text}");
        assert!(text.contains("# the eye"), "{text}");
    }
}

/// Ambient light that objects hide is one environment, whose lights stand where the first of its tables does.
#[test]
fn lights_among_ambient_light_are_saved() {
    let folder = tempfile::tempdir().unwrap();
    let ambient = "[[lights]]\nkind = \"ambient\"\nradiance = 0.1\noccluded = true\n";
    let text = format!("{}\n{ambient}", TEXT.replace("# Lights\n", &format!("# Lights\n{ambient}")));
    let path = file(&folder, &text);
    let Opened { mut editor, before } = open(&path);
    let number = editor.scene().lights.iter().position(|item| matches!(item.light, Light::Sphere(_))).unwrap();
    assert_eq!(number, 6);
    let (handle, lamp) = light(&editor, number);
    editor.set_light(handle, lamp::shifted(&lamp, Vec3::Y));
    settle(&mut editor);
    save(&path, &before, editor.scene()).unwrap();
    let saved = fs::read_to_string(&path).unwrap();
    assert_eq!(saved, text.replace("center = [1.0, 4.0, 2.0]", "center = [1.0, 5.0, 2.0]"));
}

#[test]
fn every_change_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, TEXT);
    let Opened { mut editor, before } = open(&path);
    for number in 0..5 {
        let (handle, before) = light(&editor, number);
        let moved = lamp::shifted(&before, Vec3::new(0.25, 0.5, -0.125));
        let moved =
            if number == 2 || number == 3 { moved } else { lamp::resized(&moved, 1.5 * lamp::size(&before).unwrap()) };
        editor.set_light(handle, lamp::aimed(&moved, Vec3::new(0.1, -1.0, 0.3).normalize()));
    }
    let objects: Vec<_> = editor.scene().objects.iter().map(|item| (item.handle, item.bounds.center())).collect();
    editor.set_transform(objects[1].0, Mat4::from_translation(Vec3::new(0.0, 0.25, -0.5)));
    let (sphere, middle) = objects[2];
    let turn = Mat4::from_scale_rotation_translation(Vec3::splat(0.5), Quat::from_rotation_y(0.4), Vec3::X);
    editor.set_transform(sphere, Mat4::from_translation(middle) * turn * Mat4::from_translation(-middle));
    editor.set_strategy(objects[1].0, Some(Strategy::Rays));
    let materials = editor.scene().materials.clone();
    editor.set_material(materials[0].handle, gloss::with(&materials[0].material, 200.0));
    editor.set_material(materials[1].handle, gloss::with_color(&materials[1].material, Vec3::new(0.1, 0.2, 0.3)));
    editor.set_camera(Camera { eye: Vec3::new(1.0, 2.5, 5.0), ..editor.scene().camera });
    settle(&mut editor);
    save(&path, &before, editor.scene()).unwrap();

    let text = fs::read_to_string(&path).unwrap();
    println!("{text}");
    for kept in [
        "# A still life.",
        "width = 64 # columns",
        "# the eye",
        "target = [0.00, 0.50, 0.00]",
        "# Materials",
        "# sharp",
    ] {
        assert!(text.contains(kept), "{kept}");
    }
    for kept in ["[[objects]] # the box", "# to the right", "# above", "flux = 300 # watts", "kd = [0.30, 0.20, 0.10]"]
    {
        assert!(text.contains(kept), "{kept}");
    }
    let again = open(&path);
    let (want, got) = (editor.picture(), again.editor.picture());
    let most = want.radiance.iter().map(|pixel| pixel.max_element()).fold(0.0, f32::max);
    // To rounding, but for pixels at edges.
    let off = want.radiance.iter().zip(&got.radiance).filter(|(a, b)| (**a - **b).abs().max_element() > 1e-3 * most);
    assert!(off.count() <= 3);
    // Saved once more, it stays.
    save(&path, &again.before, again.editor.scene()).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn hidden_objects_and_dark_lights_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, TEXT);
    let Opened { mut editor, before } = open(&path);
    let (handle, lamp) = light(&editor, 1);
    editor.set_light(handle, lamp::with_radiance(&lamp, Vec3::ZERO));
    let sphere = editor.scene().objects[2].handle;
    editor.show(sphere, false, Some(Strategy::None));
    settle(&mut editor);
    let hidden = editor.scene().clone();
    save(&path, &before, &hidden).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("visible = false\nvisibility = \"none\""), "{text}");
    editor.undo();
    editor.undo();
    settle(&mut editor);
    save(&path, &hidden, editor.scene()).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), TEXT);
}

#[test]
fn a_file_that_cannot_hold_a_change_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, TEXT);
    let Opened { mut editor, before } = open(&path);
    // One of a list, which has one radiance.
    let (handle, lamp) = light(&editor, 3);
    editor.set_light(handle, lamp::with_radiance(&lamp, Vec3::splat(5.0)));
    settle(&mut editor);
    let error = save(&path, &before, editor.scene()).unwrap_err();
    assert!(matches!(error, SaveError::Change(_)), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), TEXT);
    // One that was changed meanwhile.
    fs::write(&path, TEXT.replace("[[lights]]\nkind = \"sun\"", "[[lights]]\nkind = \"ambient\"")).unwrap();
    assert!(save(&path, &before, editor.scene()).is_err());
    assert!(!folder.path().join("scene.toml.new").exists());
}

#[test]
fn lights_and_objects_that_come_and_go_are_saved() {
    let folder = tempfile::tempdir().unwrap();
    // The box emits: its lights follow those of the file. The sphere has no name.
    let text =
        TEXT.replace("exponent = 40 # sharp", "exponent = 40 # sharp\nemission = 2").replace("name = \"ball\"\n", "");
    let path = file(&folder, &text);
    let Opened { mut editor, before } = open(&path);
    let first = editor.picture().clone();
    let count = before.lights.len();
    assert!(count > 5, "the box shines by {count} lights");
    let around = editor.scene().bounds();
    for kind in NewLight::ALL {
        editor.add_light(kind.light(around, 0.5));
    }
    editor.add_object(Primitive::sphere_on(around).object("new sphere", 1));
    editor.add_object(Primitive::box_on(around).object("new box", 1));
    settle(&mut editor);
    let cube = editor.scene().objects.last().unwrap().clone();
    let middle = cube.bounds.center();
    let turn = Mat4::from_translation(middle + Vec3::X) * Mat4::from_rotation_y(0.4) * Mat4::from_translation(-middle);
    editor.set_transform(cube.handle, turn);
    let floor = editor.scene().objects[0].handle;
    editor.remove_object(floor);
    let (second, _) = light(&editor, 2);
    editor.remove_light(before.lights[0].handle);
    editor.remove_light(second);
    settle(&mut editor);
    let saved = save(&path, &before, editor.scene()).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    println!("{text}");
    for line in [
        "name = \"object 2\"",
        "spheres = [[0.5, 3.0, 1.0, 0.1]]",
        "kind = \"spot\"",
        "rotate = ",
        "sphere = { center = ",
    ] {
        assert!(text.contains(line), "{line}");
    }
    for line in ["# Objects\n", "# Lights\n", "[[objects]] # the box"] {
        assert!(text.contains(line), "{line}");
    }
    for line in ["name = \"floor\"", "flux = 300", "# above"] {
        assert!(!text.contains(line), "{line}");
    }
    let again = open(&path);
    assert_eq!(again.editor.scene().lights.len(), count + 3);
    let (want, got) = (editor.picture(), again.editor.picture());
    let most = want.radiance.iter().map(|pixel| pixel.max_element()).fold(0.0, f32::max);
    let off = want.radiance.iter().zip(&got.radiance).filter(|(a, b)| (**a - **b).abs().max_element() > 1e-3 * most);
    let off = off.count();
    assert!(off <= 6, "{off} pixels are others");

    // The session goes on from there: what was saved is taken back, and saved again.
    for _ in 0..11 {
        editor.undo();
    }
    settle(&mut editor);
    assert_eq!(editor.picture().radiance, first.radiance);
    save(&path, &saved, editor.scene()).unwrap();
    let last = open(&path);
    assert_eq!(last.editor.scene().lights.len(), count);
    let off = first.radiance.iter().zip(&last.editor.picture().radiance).filter(|(a, b)| **a != **b).count();
    // The order of objects and lights in the file is another one: sums round otherwise.
    assert!(
        off == 0
            || first
                .radiance
                .iter()
                .zip(&last.editor.picture().radiance)
                .all(|(a, b)| (*a - *b).abs().max_element() < 1e-3 * most)
    );
}

#[test]
fn an_object_without_keys_is_not_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, TEXT);
    let Opened { mut editor, before } = open(&path);
    let mesh = scene::Mesh::quad(Vec3::Y, Vec3::X, Vec3::Z);
    editor.add_object(scene::Object::mesh("sail", mesh, 0, scene::Proxy::None));
    settle(&mut editor);
    let error = save(&path, &before, editor.scene()).unwrap_err();
    assert_eq!(error.to_string(), "not saved: \"sail\" is new, and neither a sphere nor a box");
    assert_eq!(fs::read_to_string(&path).unwrap(), TEXT);
}

#[test]
fn objects_and_lights_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    // The sphere and a light are moved by keys; the box shines, and stands before both in the lists.
    let text = TEXT
        .replace("exponent = 40 # sharp", "exponent = 40 # sharp\nemission = 2")
        .replace("radius = 0.5 }\n", "radius = 0.5 }\nkeys = [{ time = 0 }, { time = 2, translate = [1, 0, 0] }]\n")
        .replace("flux = 300 # watts\n", "flux = 300\n[[lights]]\nkind = \"sphere\"\ncenter = [2, 3, 0]\nradius = 0.3\nradiance = 9\nkeys = [{ time = 0 }, { time = 2, translate = [0, 0, 2] }]\n");
    let path = file(&folder, &text);
    let Opened { mut editor, before } = open(&path);
    let seek = |editor: &mut Editor, time: f32| {
        editor.seek(time);
        editor.close_step();
        settle(editor);
        editor.picture().radiance.clone()
    };
    let [start, later] = [0.0, 1.5].map(|time| seek(&mut editor, time));
    assert_ne!(start, later);
    let handles = |editor: &Editor| {
        let scene = editor.scene();
        let lights: Vec<_> = scene.lights.iter().map(|item| (item.handle, item.is_animated)).collect();
        let objects: Vec<_> = scene.objects.iter().map(|item| (item.handle, item.transform)).collect();
        (lights, objects)
    };
    let floor = before.objects[0].handle;
    editor.set_transform(floor, Mat4::from_translation(Vec3::new(0.0, -0.25, 0.0)));
    editor.close_step();
    settle(&mut editor);
    let (known, lower) = (handles(&editor), editor.picture().radiance.clone());
    editor.remove_object(floor);
    editor.remove_object(before.objects[1].handle);
    editor.remove_light(before.lights[0].handle);
    assert_eq!((editor.scene().objects.len(), editor.scene().lights.len()), (1, known.0.len() - 1));
    settle(&mut editor);
    let rest = handles(&editor);
    assert_eq!((rest.0.len(), rest.1.len()), (5, 1), "the box has taken its six lights with it");
    assert!(rest.0[0].1 && editor.scene().objects[0].is_animated, "what the animation moves is still the same");
    // With fewer objects and lights the others move on as in a scene that never had these.
    let bare = seek(&mut editor, 0.75);
    assert_ne!(bare, seek(&mut editor, 0.0));
    for _ in 0..2 {
        editor.undo();
    }
    settle(&mut editor);
    let without = editor.picture().radiance.clone();
    for _ in 0..3 {
        editor.undo();
    }
    settle(&mut editor);
    assert_eq!(handles(&editor), known);
    assert_eq!(editor.picture().radiance, lower);
    for _ in 0..3 {
        editor.redo();
    }
    settle(&mut editor);
    assert_eq!((handles(&editor), &editor.picture().radiance), (rest, &without));
    for _ in 0..4 {
        editor.undo();
    }
    settle(&mut editor);
    assert_eq!(editor.picture().radiance, later, "the floor as well is where it stood");
    assert_eq!(seek(&mut editor, 0.0), start);
    // The animation's own stay, and patches of an environment.
    let sphere = editor.scene().objects[2].handle;
    let lamp = editor.scene().lights[1].handle;
    editor.remove_object(sphere);
    editor.remove_light(lamp);
    drop(editor.session().finished());
    editor.follow();
    let errors: Vec<String> = editor.take_errors().iter().map(ToString::to_string).collect();
    assert_eq!(errors, ["object \"ball\" is moved by the animation", "light 1 is moved by the animation"]);
    assert_eq!(editor.picture().radiance, start);
}

#[test]
fn a_still_light_between_those_that_move_as_one_stays() {
    let folder = tempfile::tempdir().unwrap();
    let list = "spheres = [[0.0, 3.0, 1.0, 0.1], [0.5, 3.0, 1.0, 0.1]]";
    let path = file(
        &folder,
        &TEXT.replace(list, &format!("{list}\nkeys = [{{ time = 0 }}, {{ time = 2, translate = [0, 0, 2] }}]")),
    );
    let (mut scene, mut animation, _) = scene_files::load_animated(&path).unwrap();
    let moves = |animation: &scene::Animation| (0..6).map(|light| animation.moves_light(light)).collect::<Vec<_>>();
    assert_eq!(moves(&animation), [false, false, true, true, false, false]);
    // Between the two, then before both.
    for place in [3, 0] {
        animation.insert_light(place);
        scene.lights.insert(place, scene.lights[0].clone());
    }
    assert_eq!(moves(&animation), [false, false, false, true, false, true]);
    let before: Vec<_> = scene.lights.iter().map(lamp::center).collect();
    animation.seek(1.0, &mut scene);
    for (number, (light, before)) in scene.lights.iter().zip(before).enumerate() {
        let step = if [3, 5].contains(&number) { Vec3::Z } else { Vec3::ZERO };
        assert_eq!(lamp::center(light), before.map(|center| center + step), "{number}");
    }
    for place in [0, 3] {
        animation.remove_light(place);
        scene.lights.remove(place);
    }
    animation.seek(0.0, &mut scene);
    assert_eq!(scene.lights, scene_files::load_animated(&path).unwrap().0.lights);
}
