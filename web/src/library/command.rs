//! The commands of JavaScript. Scenes, renderers and their items are numbers. Every choice is tagged from outside, since other forms keep
//! what they read in a second form first, and take more code.

use crate::library::given::{CameraGiven, EnvironmentGiven, MannerGiven, MeshGiven, SettingsGiven};
use crate::library::light::LightGiven;
use crate::library::mail::Span;
use crate::library::material::MaterialGiven;
use glam::Vec3;
use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) enum Command {
    /// An empty scene.
    NewScene,
    /// The scene that needs no file.
    Builtin,
    /// A scene of files, by their names.
    Load { path: String, clip: Option<String>, files: Vec<(String, Span)> },
    /// A renderer of a copy of a scene.
    NewRenderer { scene: u32, settings: SettingsGiven },
    /// Frees a scene or a renderer.
    Free { number: u32 },
    /// Radiance as a screen shows it, four bytes a pixel.
    Exposed { radiance: Span, size: [usize; 2], exposure: f32, tone: String },
    /// Something with a scene.
    Scene { number: u32, then: SceneCommand },
    /// Something with a renderer.
    Renderer { number: u32, then: RendererCommand },
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) enum SceneCommand {
    AddMesh {
        mesh: MeshGiven,
        manner: MannerGiven,
        material: Option<MaterialKey>,
    },
    AddSpheres {
        rows: Span,
        manner: MannerGiven,
        material: Option<MaterialKey>,
    },
    AddMaterial {
        material: MaterialGiven,
    },
    AddLight {
        light: LightGiven,
    },
    SetEnvironment {
        environment: Option<EnvironmentGiven>,
    },
    SetCamera {
        camera: CameraGiven,
    },
    SetSize {
        size: [u32; 2],
    },
    SetBackground {
        background: Vec3,
    },
    Validate,
    /// Lists of what is there.
    State,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) enum RendererCommand {
    Render {
        window: Option<[usize; 4]>,
        /// Whether JavaScript hears of its progress; so with those below.
        listens: bool,
    },
    Layers {
        names: Vec<String>,
        window: Option<[usize; 4]>,
        listens: bool,
    },
    /// The fraction of each pixel that shows a surface.
    Coverage {
        window: Option<[usize; 4]>,
    },
    /// The picture by Monte Carlo, with so many samples of each light for each camera ray.
    Reference {
        spp: u32,
        seed: u32,
        listens: bool,
    },
    Shade(Points),
    VisibleFraction {
        point: Vec3,
        normal: Vec3,
        light: i64,
    },
    Pick {
        pixel: [u32; 2],
    },
    Exposure,
    /// The lists of handles, and all else that is read without work.
    State,
    Light {
        light: i64,
    },
    Object {
        object: Key,
    },
    SetLight {
        light: i64,
        new: LightGiven,
    },
    ChangeLight {
        light: i64,
        changes: LightChanges,
    },
    AddLight {
        light: LightGiven,
    },
    RemoveLight {
        light: i64,
    },
    SetEnvironment {
        environment: Option<EnvironmentGiven>,
    },
    AddMesh {
        mesh: MeshGiven,
        manner: MannerGiven,
        material: Option<MaterialKey>,
    },
    AddSpheres {
        rows: Span,
        manner: MannerGiven,
        material: Option<MaterialKey>,
    },
    SetMesh {
        object: Key,
        mesh: MeshGiven,
    },
    RemoveObject {
        object: Key,
    },
    SetTransform {
        object: Key,
        matrix: [f32; 16],
    },
    SetVisible {
        object: Key,
        visible: bool,
    },
    SetVisibility {
        object: Key,
        visibility: Option<String>,
    },
    AddMaterial {
        material: MaterialGiven,
    },
    SetMaterial {
        material: i64,
        new: MaterialGiven,
    },
    SetObjectMaterial {
        object: Key,
        material: i64,
    },
    SetCamera {
        camera: CameraGiven,
    },
    SetSize {
        size: [u32; 2],
    },
    SetBackground {
        background: Vec3,
    },
    SetSettings {
        settings: SettingsGiven,
    },
    Seek {
        time: f32,
    },
}

/// An object by its number or its name.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) enum Key {
    Number(i64),
    Name(String),
}

/// A material of the scene, or one of its own.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) enum MaterialKey {
    Number(i64),
    Own(MaterialGiven),
}

/// The numbers of a light that change.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) struct LightChanges {
    pub(crate) center: Option<Vec3>,
    pub(crate) direction: Option<Vec3>,
    pub(crate) size: Option<f32>,
    pub(crate) radiance: Option<Vec3>,
}

/// Points of the caller's.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Points {
    pub(crate) points: Span,
    pub(crate) normals: Span,
    pub(crate) views: Option<Span>,
    pub(crate) faces: Option<Span>,
    pub(crate) material: Option<MaterialKey>,
    pub(crate) objects: Option<Objects>,
    /// Whether the parts of the lights, and the light without blockers, are wanted.
    pub(crate) layers: bool,
}

/// The object that all points are on, or a number for each, of which −1 is none.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) enum Objects {
    Each(Span),
    All(Key),
}
