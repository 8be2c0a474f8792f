//! Cameras, environments, objects and settings as JavaScript describes them.

use crate::library::fault::Fault;
use crate::library::mail::{Arrays, Span};
use glam::{Mat4, UVec2, Vec2, Vec3};
use lighting::{Environment, EnvironmentMap};
use lobe_core::Sphere;
use renderer::{Method, PixelSamples, Settings};
use scene::{Bounds, Camera, Mesh, Object, Projection, Proxy, Strategy};
use serde::{Deserialize, Serialize};
use shading::Accuracy;
use std::sync::Arc;

/// Camera rays of a pixel that an outline crosses, where settings name no number.
const EDGE_SAMPLES: u32 = 8;

/// A camera; its field of view is the full vertical one, in degrees. Perspective cameras have one, and orthographic ones a height.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct CameraGiven {
    eye: Vec3,
    target: Vec3,
    up: Vec3,
    projection: ProjectionGiven,
    fov: Option<f32>,
    height: Option<f32>,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
enum ProjectionGiven {
    Perspective,
    Orthographic,
    Panoramic,
}

impl From<CameraGiven> for Camera {
    fn from(CameraGiven { eye, target, up, projection, fov, height }: CameraGiven) -> Self {
        // One without its number is refused as one of NaN.
        let projection = match projection {
            ProjectionGiven::Perspective => Projection::perspective(fov.unwrap_or(f32::NAN).to_radians()),
            ProjectionGiven::Orthographic => Projection::Orthographic { height: height.unwrap_or(f32::NAN) },
            ProjectionGiven::Panoramic => Projection::Panoramic,
        };
        Self { eye, target, up, projection }
    }
}

impl From<Camera> for CameraGiven {
    fn from(Camera { eye, target, up, projection }: Camera) -> Self {
        let (projection, fov, height) = match projection {
            Projection::Perspective { vertical_fov } => {
                (ProjectionGiven::Perspective, Some(vertical_fov.to_degrees()), None)
            }
            Projection::Orthographic { height } => (ProjectionGiven::Orthographic, None, Some(height)),
            Projection::Panoramic => (ProjectionGiven::Panoramic, None, None),
        };
        Self { eye, target, up, projection, fov, height }
    }
}

/// Light from all around: one radiance, or an image in latitude and longitude, the top row first.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct EnvironmentGiven {
    radiance: Option<Vec3>,
    image: Option<ImageGiven>,
    /// More of it from everywhere, which is not seen behind objects.
    ambient: Vec3,
    strength: Vec3,
    up: Vec3,
    turn: f32,
    patches: u32,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct ImageGiven {
    width: u32,
    height: u32,
    data: Span,
}

impl EnvironmentGiven {
    /// The environment around a scene of these bounds.
    pub(crate) fn around(self, bounds: Bounds, arrays: Arrays<'_>) -> Result<Arc<Environment>, Fault> {
        let world = bounds.world();
        let map = match self.image {
            Some(ImageGiven { width, height, data }) => {
                Some(EnvironmentMap::new(UVec2::new(width, height), arrays.list(data)?)?)
            }
            None => self.radiance.map(EnvironmentMap::uniform),
        };
        let map = map.map(|map| map.scaled(self.strength).turned(self.up, self.turn));
        Ok(Arc::new(Environment::with_ambient(map, self.ambient, self.patches, world)))
    }
}

/// The arrays of a mesh, whose lengths JavaScript has checked against each other.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) struct MeshGiven {
    positions: Span,
    indices: Span,
    normals: Option<Span>,
    uvs: Option<Span>,
    colors: Option<Span>,
    smooth: bool,
}

impl MeshGiven {
    /// The mesh, and the number of its triangles without an area, which are left out.
    pub(crate) fn mesh(self, arrays: Arrays<'_>) -> Result<(Mesh, usize), Fault> {
        let mut mesh = Mesh {
            positions: arrays.list(self.positions)?,
            triangles: arrays.list(self.indices)?,
            normals: self.normals.map_or_else(|| Ok(Vec::new()), |normals| directions("normals", normals, arrays))?,
            colors: arrays.optional(self.colors)?,
            uv_sets: self.uvs.map(|uvs| arrays.list::<Vec2>(uvs)).transpose()?.into_iter().collect(),
        };
        // Before anything follows the numbers of vertices.
        mesh.validate()?;
        let removed = mesh.remove_degenerate();
        if self.smooth {
            mesh.smooth_normals();
        }
        Ok((mesh, removed))
    }
}

/// Everything of an object but its shape.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct MannerGiven {
    name: Option<String>,
    visible: bool,
    visibility: Option<String>,
    spheres: ProxyGiven,
}

/// The spheres by which a mesh blocks light in the strategy `spheres`: how many are fitted, or rows of x, y, z and radius.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
enum ProxyGiven {
    Count(usize),
    Rows(Span),
}

impl MannerGiven {
    /// A mesh as the object of a number.
    pub(crate) fn mesh(self, mesh: Mesh, number: usize, arrays: Arrays<'_>) -> Result<Object, Fault> {
        let proxy = match self.spheres {
            ProxyGiven::Count(0) => Proxy::None,
            ProxyGiven::Count(count) => Proxy::Count(count),
            ProxyGiven::Rows(rows) => Proxy::Spheres(spheres(rows, arrays)?),
        };
        let (name, strategy) = (self.named(number), strategy(self.visibility.as_deref())?);
        Ok(Object { visible: self.visible, strategy, ..Object::mesh(name, mesh, 0, proxy) })
    }

    /// Exact spheres as the object of a number.
    pub(crate) fn spheres(self, rows: Span, number: usize, arrays: Arrays<'_>) -> Result<Object, Fault> {
        let (name, strategy) = (self.named(number), strategy(self.visibility.as_deref())?);
        Ok(Object { visible: self.visible, strategy, ..Object::spheres(name, spheres(rows, arrays)?, 0) })
    }

    fn named(&self, number: usize) -> String {
        self.name.clone().unwrap_or_else(|| format!("object {number}"))
    }
}

fn spheres(rows: Span, arrays: Arrays<'_>) -> Result<Vec<Sphere>, Fault> {
    let sphere = |(number, [x, y, z, radius]): (usize, [f32; 4])| {
        let sphere = Sphere { center: Vec3::new(x, y, z), radius };
        sphere.validate().map_err(|fault| Fault::range(format!("spheres[{number}]: {fault}")))?;
        Ok(sphere)
    };
    arrays.list::<[f32; 4]>(rows)?.into_iter().enumerate().map(sphere).collect()
}

/// Vectors of any length but 0, as unit vectors.
pub(crate) fn directions(name: &str, span: Span, arrays: Arrays<'_>) -> Result<Vec<Vec3>, Fault> {
    let mut all = arrays.list::<Vec3>(span)?;
    for (i, v) in all.iter_mut().enumerate() {
        let unit = v.try_normalize();
        *v = unit.ok_or_else(|| Fault::range(format!("{name}[{i}] is {v}: expected a direction")))?;
    }
    Ok(all)
}

/// A strategy by its name; none for the usual one.
pub(crate) fn strategy(name: Option<&str>) -> Result<Option<Strategy>, Fault> {
    let Some(name) = name else { return Ok(None) };
    let known: Vec<&str> = Strategy::ALL.iter().map(|strategy| strategy.name()).collect();
    let wrong = || Fault::range(format!("visibility is \"{name}\": expected one of {}", known.join(", ")));
    Strategy::named(name).map(Some).ok_or_else(wrong)
}

/// The matrix that moves an object, column by column.
pub(crate) fn matrix(columns: &[f32; 16]) -> Result<Mat4, Fault> {
    let matrix = Mat4::from_cols_array(columns);
    match matrix.row(3).to_array() {
        [0.0, 0.0, 0.0, 1.0] => Ok(matrix),
        last => Err(Fault::range(format!("matrix has the last row {last:?}: expected [0, 0, 0, 1]"))),
    }
}

/// The settings of a renderer, all of them.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SettingsGiven {
    tolerance: f32,
    depth: Option<u32>,
    visibility: Option<String>,
    method: String,
    samples: Option<u32>,
    own_radiance: bool,
    interpolate: bool,
    threshold: f32,
    map_resolution: Option<u32>,
    keep_points: bool,
}

impl SettingsGiven {
    pub(crate) fn settings(&self) -> Result<Settings, Fault> {
        let methods = [("moments", Method::Moments), ("lobes", Method::Lobes), ("paper", Method::Paper)];
        let method = methods.iter().find(|(name, _)| *name == self.method).map(|(_, method)| *method);
        let wrong = || Fault::range(format!("method is \"{}\": expected one of moments, lobes, paper", self.method));
        let requested = Accuracy::new(self.tolerance);
        let settings = Settings {
            strategy: strategy(self.visibility.as_deref().filter(|name| *name != "scene"))?,
            method: method.ok_or_else(wrong)?,
            accuracy: self.depth.map_or(requested, |depth| requested.with_depth(depth)),
            own_radiance: self.own_radiance,
            interpolate: self.interpolate,
            threshold: self.threshold,
            samples: self.samples.map_or(PixelSamples::Edges(EDGE_SAMPLES), PixelSamples::Uniform),
            map_resolution: self.map_resolution,
            keep_points: self.keep_points,
            ..Settings::default()
        };
        settings.validate()?;
        Ok(settings)
    }
}
