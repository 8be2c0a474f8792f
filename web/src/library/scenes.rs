use crate::library::command::{MaterialKey, SceneCommand};
use crate::library::fault::Fault;
use crate::library::given::CameraGiven;
use crate::library::mail::{Answer, Arrays};
use crate::library::material::MaterialGiven;
use brdf::Material;
use glam::Vec3;
use lighting::Light;
use scene::{Animation, Object, Scene, Surface};
use serde_json::{Value, json};
use session::lamp;

/// The size of a picture of a scene that states none, that of scene files.
const SIZE: [u32; 2] = [960, 540];
/// The reflectance of an object that states no material.
const GREY: f32 = 0.5;

/// A scene that JavaScript makes.
#[derive(Debug)]
pub(crate) struct SceneItem {
    pub(crate) scene: Scene,
    pub(crate) animation: Animation,
    warnings: Vec<String>,
    /// The material of objects that state none.
    usual: Option<usize>,
}

impl SceneItem {
    pub(crate) fn empty() -> Self {
        let [width, height] = SIZE;
        Self::of((Scene { width, height, ..Scene::default() }, Animation::default(), Vec::new()))
    }

    pub(crate) fn of((scene, animation, warnings): (Scene, Animation, Vec<String>)) -> Self {
        Self { scene, animation, warnings, usual: None }
    }

    pub(crate) fn follow(&mut self, command: SceneCommand, arrays: Arrays<'_>) -> Result<Answer, Fault> {
        let number = self.scene.objects.len();
        match command {
            SceneCommand::AddMesh { mesh, manner, material } => {
                let (mesh, removed) = mesh.mesh(arrays)?;
                let object = manner.mesh(mesh, number, arrays)?;
                let number = self.add(object, material, arrays)?;
                return Ok(Answer::of(json!({ "number": number, "removed": removed })));
            }
            SceneCommand::AddSpheres { rows, manner, material } => {
                let object = manner.spheres(rows, number, arrays)?;
                return Ok(Answer::of(json!({ "number": self.add(object, material, arrays)? })));
            }
            SceneCommand::AddMaterial { material } => {
                let (material, surface) = material.material(arrays)?;
                Scene::check_material(self.scene.materials.len(), &material, &surface)?;
                return Ok(Answer::of(json!({ "number": self.push(material, surface) })));
            }
            SceneCommand::AddLight { light } => {
                let (number, light) = (self.scene.lights.len(), light.light()?);
                Scene::check_light(number, &light)?;
                self.scene.lights.push(light);
                return Ok(Answer::of(json!({ "number": number })));
            }
            SceneCommand::SetEnvironment { environment } => {
                let bounds = self.scene.bounds();
                let environment = environment.map(|given| given.around(bounds, arrays)).transpose()?;
                self.scene.lights.retain(|light| !matches!(light, Light::Sky(_)));
                if let Some(environment) = &environment {
                    self.scene.lights.extend_from_slice(environment.lights());
                }
                self.scene.environment = environment;
            }
            SceneCommand::SetCamera { camera } => {
                let camera = camera.into();
                self.scene.check_camera(&camera)?;
                self.scene.camera = camera;
            }
            SceneCommand::SetSize { size: [width, height] } => {
                Scene::check_size(width, height)?;
                (self.scene.width, self.scene.height) = (width, height);
            }
            SceneCommand::SetBackground { background } => self.scene.background = background,
            SceneCommand::Validate => self.scene.validate()?,
            SceneCommand::State => return Ok(Answer::of(self.state())),
        }
        Ok(Answer::default())
    }

    fn state(&self) -> Value {
        let scene = &self.scene;
        json!({
            "size": [scene.width, scene.height],
            "camera": CameraGiven::from(scene.camera),
            "background": scene.background,
            "lights": scene.lights.iter().map(light_state).collect::<Vec<_>>(),
            "objects": scene.objects.iter().map(|object| &object.name).collect::<Vec<_>>(),
            "materials": scene.materials.iter().map(Material::name).collect::<Vec<_>>(),
            "triangles": scene.triangles(),
            "duration": self.animation.duration(),
            "warnings": self.warnings,
        })
    }

    /// Adds an object that the scene accepts; its number.
    fn add(&mut self, object: Object, material: Option<MaterialKey>, arrays: Arrays<'_>) -> Result<usize, Fault> {
        let before = (self.scene.materials.len(), self.scene.surfaces.len(), self.usual);
        let object = Object { material: self.material_number(material, arrays)?, ..object };
        if let Err(error) = self.scene.check_object(&object) {
            self.scene.materials.truncate(before.0);
            self.scene.surfaces.truncate(before.1);
            self.usual = before.2;
            return Err(error.into());
        }
        self.scene.objects.push(object);
        Ok(self.scene.objects.len() - 1)
    }

    /// The number of a material: one of the scene's, or a new one.
    fn material_number(&mut self, material: Option<MaterialKey>, arrays: Arrays<'_>) -> Result<usize, Fault> {
        let count = self.scene.materials.len();
        match material {
            Some(MaterialKey::Own(own)) => {
                let (material, surface) = own.material(arrays)?;
                Scene::check_material(count, &material, &surface)?;
                Ok(self.push(material, surface))
            }
            Some(MaterialKey::Number(number)) => {
                let place = usize::try_from(number).ok().filter(|place| *place < count);
                place.ok_or_else(|| Fault::range(format!("material {number} is not in the scene: there are {count}")))
            }
            None => Ok(match self.usual {
                Some(number) => number,
                None => {
                    let number = self.push(Material::lambert(Vec3::splat(GREY)), Surface::default());
                    *self.usual.insert(number)
                }
            }),
        }
    }

    fn push(&mut self, material: Material, surface: Surface) -> usize {
        let number = self.scene.materials.len();
        self.scene.materials.push(material);
        if !surface.is_plain() {
            self.scene.surfaces.resize(number, Surface::default());
            self.scene.surfaces.push(surface);
        }
        number
    }
}

/// The grey material of objects that state none, as a renderer adds it.
pub(crate) fn usual(own: Option<MaterialGiven>, arrays: Arrays<'_>) -> Result<(Material, Surface), Fault> {
    own.map_or_else(|| Ok((Material::lambert(Vec3::splat(GREY)), Surface::default())), |own| own.material(arrays))
}

/// A light as JavaScript reads it.
pub(crate) fn light_state(light: &Light) -> Value {
    json!({
        "kind": light.name(),
        "center": lamp::center(light),
        "direction": lamp::direction(light),
        "size": lamp::size(light),
        "radiance": light.full_radiance(),
    })
}
