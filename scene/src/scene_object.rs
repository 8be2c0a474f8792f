//! The objects of a scene file.

use crate::load::{self, Context, Part, share_out};
use crate::scene_file::{DEFAULT_SPHERES, Materials};
use crate::toml_reader::{Table, Value};
use crate::{Mesh, Object, Proxy, SceneError, Shape, Strategy};
use glam::{Mat4, Quat, Vec3};
use lobe_core::Sphere;
use std::collections::HashMap;
use std::path::Path;

/// What an object is before it is placed.
enum Geometry {
    Spheres(Vec<Sphere>),
    Flat(Mesh),
    Solid(Vec<Part>),
}

/// Reads one of `[[objects]]`: several objects where a glTF file has several parts.
pub(crate) fn read_object(
    mut t: Table<'_>,
    index: usize,
    path: &Path,
    materials: &mut Materials,
    context: &mut Context,
) -> Result<Vec<Object>, SceneError> {
    let name = t.get("name").map_or(Ok(format!("object {index}")), |v| v.string().map(str::to_owned))?;
    let normals = t.get("normals");
    let kind = normals.map_or(Ok("file"), |v| v.string())?;
    if !["file", "face", "smooth"].contains(&kind) {
        let place = normals.map_or_else(|| t.error(""), |v| v.error("expected \"file\", \"face\" or \"smooth\""));
        return Err(place);
    }
    let (shape, value) = t.one_of(&["quad", "plane", "box", "sphere", "spheres", "mesh"])?;
    let geometry = geometry(shape, value, path, context)?;
    let material = match t.get("material") {
        None => None,
        Some(v) => {
            let wanted = v.string()?;
            Some(*materials.names.get(wanted).ok_or_else(|| v.error(format!("there is no [materials.{wanted}]")))?)
        }
    };
    let visible = t.get("visible").map_or(Ok(true), |v| v.boolean())?;
    let strategy = t.get("visibility").map(read_strategy).transpose()?;
    let (matrix, place) = transform(&mut t)?;
    let proxy = t.get("proxy").map(|v| read_proxy(v, path)).transpose()?;
    t.finish()?;

    // A uniform scale, where there is one: all that spheres can follow.
    let move_balls = |balls: &[Sphere]| -> Result<Vec<Sphere>, SceneError> {
        let scales = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|a| a.truncate().length());
        let skew = [(0, 1), (1, 2), (2, 0)]
            .iter()
            .any(|&(i, j)| matrix.col(i).truncate().dot(matrix.col(j).truncate()).abs() > 1e-4 * scales[i] * scales[j]);
        let uneven = scales.iter().any(|s| (s - scales[0]).abs() > 1e-4 * scales[0]);
        if let (true, Some(place)) = (skew || uneven, place) {
            return Err(place.error("spheres can only be scaled uniformly"));
        }
        let moved = |b: &Sphere| Sphere { center: matrix.transform_point3(b.center), radius: b.radius * scales[0] };
        Ok(balls.iter().map(moved).collect())
    };
    let proxy = match proxy {
        Some(Proxy::Spheres(balls)) => Some(Proxy::Spheres(move_balls(&balls)?)),
        other => other,
    };

    match geometry {
        Geometry::Spheres(balls) => {
            let balls = move_balls(&balls)?;
            let proxy = match proxy {
                Some(Proxy::Count(_)) => return Err(value.error("exact spheres need no built proxy")),
                other => other.unwrap_or_else(|| Proxy::Spheres(balls.clone())),
            };
            let material = material.unwrap_or_else(|| materials.fallback());
            Ok(vec![Object { name, shape: Shape::Spheres(balls), material, proxy, visible, strategy }])
        }
        Geometry::Flat(mut mesh) => {
            mesh.transform(&matrix);
            mesh.remove_degenerate();
            mesh.validate().map_err(|e| value.error(e))?;
            let material = material.unwrap_or_else(|| materials.fallback());
            let proxy = proxy.unwrap_or(Proxy::None);
            Ok(vec![Object { name, shape: Shape::Mesh(mesh), material, proxy, visible, strategy }])
        }
        Geometry::Solid(parts) => {
            let mut placed = Vec::new();
            for mut part in parts {
                match kind {
                    "face" => part.mesh.normals.clear(),
                    "file" if !part.mesh.normals.is_empty() || shape == "box" => {}
                    _ => part.mesh.smooth_normals(),
                }
                part.mesh.transform(&matrix);
                part.mesh.remove_degenerate();
                if !part.mesh.triangles.is_empty() {
                    part.mesh.validate().map_err(|e| value.error(e))?;
                    placed.push(part);
                }
            }
            if placed.is_empty() {
                return Err(value.error("mesh has no triangles once it is placed"));
            }
            let single = placed.len() == 1;
            let counts = match &proxy {
                Some(Proxy::Count(n)) => share_out(*n, &placed),
                None => share_out(DEFAULT_SPHERES, &placed),
                Some(_) => vec![0; placed.len()],
            };
            if !single && matches!(proxy, Some(Proxy::Spheres(_) | Proxy::File(_))) {
                return Err(value.error(format!(
                    "a mesh of {} parts takes no single sphere set: expected \"none\" or a number of spheres",
                    placed.len()
                )));
            }
            let mut own: HashMap<usize, usize> = HashMap::new();
            let mut out = Vec::new();
            for (part, count) in placed.into_iter().zip(counts) {
                let material = match (material, part.material) {
                    (Some(index), _) => index,
                    (None, Some((key, m))) => *own.entry(key).or_insert_with(|| materials.push(m)),
                    (None, None) => materials.fallback(),
                };
                let proxy = match &proxy {
                    Some(Proxy::Count(_)) | None => Proxy::Count(count),
                    Some(other) => other.clone(),
                };
                let name = if single { name.clone() } else { format!("{name}/{}", part.name) };
                out.push(Object { name, shape: Shape::Mesh(part.mesh), material, proxy, visible, strategy });
            }
            Ok(out)
        }
    }
}

fn geometry(shape: &str, value: Value<'_>, path: &Path, context: &mut Context) -> Result<Geometry, SceneError> {
    if shape == "spheres" {
        return Ok(Geometry::Spheres(value.spheres()?));
    }
    if shape == "mesh" {
        let file = path.with_file_name("").join(value.string()?);
        return load::mesh_parts(&file, context).map(Geometry::Solid).map_err(|e| value.error(e));
    }
    let mut t = value.table()?;
    let geometry = match shape {
        "quad" => {
            let center = t.require("center")?.vec3()?;
            let (u, v) = (t.require("u")?, t.require("v")?);
            let (u, place) = (u.nonzero_vec3()?, v);
            let v = v.nonzero_vec3()?;
            if u.normalize().cross(v.normalize()).length() < 1e-6 {
                return Err(place.error("u and v are parallel"));
            }
            Geometry::Flat(Mesh::quad(center, u, v))
        }
        "plane" => {
            let point = t.require("point")?.vec3()?;
            let normal = t.require("normal")?.nonzero_vec3()?.normalize();
            let half = 0.5 * t.get("size").map_or(Ok(100.0), |v| v.positive())?;
            let (u, v) = lobe_core::orthonormal_basis(normal);
            Geometry::Flat(Mesh::quad(point, u * half, v * half))
        }
        "box" => {
            let center = t.require("center")?.vec3()?;
            let size = t.require("size")?;
            let edges = size.vec3()?;
            if edges.min_element() <= 0.0 {
                return Err(size.error("all edges must be greater than 0"));
            }
            let mesh = Mesh::cuboid(center, edges);
            Geometry::Solid(vec![Part { name: "box".to_owned(), mesh, material: None }])
        }
        _ => {
            let center = t.require("center")?.vec3()?;
            Geometry::Spheres(vec![Sphere { center, radius: t.require("radius")?.positive()? }])
        }
    };
    t.finish()?;
    Ok(geometry)
}

/// The object's matrix, and the key to blame when it doesn't suit the shape.
fn transform<'s>(t: &mut Table<'s>) -> Result<(Mat4, Option<Value<'s>>), SceneError> {
    let (scale, rotate, translate, matrix) = (t.get("scale"), t.get("rotate"), t.get("translate"), t.get("matrix"));
    if let Some(m) = matrix {
        if scale.or(rotate).or(translate).is_some() {
            return Err(m.error("either a matrix or scale, rotate and translate, not both"));
        }
        return Ok((m.mat4()?, Some(m)));
    }
    let s = match scale {
        None => Vec3::ONE,
        Some(v) => {
            let s = v.number().map(Vec3::splat).or_else(|_| v.vec3())?;
            if s.abs().min_element() > 0.0 { s } else { return Err(v.error("a scale must not be 0")) }
        }
    };
    let r = match rotate {
        None => Quat::IDENTITY,
        Some(v) => {
            let mut t = v.table()?;
            let axis = t.require("axis")?.nonzero_vec3()?.normalize();
            let degrees = t.require("degrees")?.number()?;
            t.finish()?;
            Quat::from_axis_angle(axis, degrees.to_radians())
        }
    };
    let m = translate.map_or(Ok(Vec3::ZERO), |v| v.vec3())?;
    Ok((Mat4::from_scale_rotation_translation(s, r, m), scale))
}

fn read_strategy(value: Value<'_>) -> Result<Strategy, SceneError> {
    let name = value.string()?;
    Strategy::named(name).ok_or_else(|| {
        value.error(format!("unknown strategy \"{name}\": expected \"spheres\", \"shadow-map\", \"rays\" or \"none\""))
    })
}

fn read_proxy(value: Value<'_>, path: &Path) -> Result<Proxy, SceneError> {
    let what = "expected \"none\", { spheres = N }, { file = \"set.json\" } or { explicit = [[x, y, z, radius], …] }";
    if value.is_string() {
        return if value.string()? == "none" { Ok(Proxy::None) } else { Err(value.error(what)) };
    }
    let mut t = value.table().map_err(|_| value.error(what))?;
    let proxy = match t.one_of(&["spheres", "file", "explicit"])? {
        ("spheres", v) => Proxy::Count(v.whole(1, 100_000)? as usize),
        ("file", v) => {
            let file = path.with_file_name("").join(v.string()?);
            if !file.is_file() {
                return Err(v.error(format!("there is no file {}", file.display())));
            }
            Proxy::File(file)
        }
        (_, v) => Proxy::Spheres(v.spheres()?),
    };
    t.finish()?;
    Ok(proxy)
}
