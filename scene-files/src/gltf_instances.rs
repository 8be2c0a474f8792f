//! Copies of a node's mesh (EXT_mesh_gpu_instancing).

use crate::gltf_buffers::Buffers;
use crate::gltf_mesh::Shapes;
use glam::{Mat3, Mat4, Quat, Vec3};
use gltf::json::accessor::Type;
use gltf::json::{Index, Value};
use scene::{MAX_COORDINATE, Mesh};

/// The matrices of a node's instances to the node: `T · R · S`, each part one a row of its accessor or none. Attributes of other names
/// are for programs.
pub(crate) fn read_instances(buffers: &Buffers<'_>, attributes: &Value) -> Result<Vec<Mat4>, String> {
    let fault = |name: &str, e: String| format!("instances: {name}: {e}");
    let rows = |name: &str, kind: Type| -> Result<Option<Vec<f32>>, String> {
        let Some(value) = attributes.get(name) else { return Ok(None) };
        let number = value.as_u64().and_then(|n| u32::try_from(n).ok());
        let index = Index::new(number.ok_or_else(|| fault(name, "expected the number of an accessor".to_owned()))?);
        let values = buffers.floats(index, kind).map_err(|e| fault(name, e))?;
        match values.iter().all(|x| x.abs() <= MAX_COORDINATE) {
            true => Ok(Some(values)),
            false => Err(fault(name, "numbers must lie within ±1e9".to_owned())),
        }
    };
    let translations = rows("TRANSLATION", Type::Vec3)?;
    let rotations = rows("ROTATION", Type::Vec4)?;
    let scales = rows("SCALE", Type::Vec3)?;
    let counts = [translations.as_ref().map(|v| v.len() / 3), rotations.as_ref().map(|v| v.len() / 4)];
    let counts = [counts[0], counts[1], scales.as_ref().map(|v| v.len() / 3)];
    let Some(count) = counts.into_iter().flatten().max() else { return Ok(vec![Mat4::IDENTITY]) };
    if counts.into_iter().flatten().any(|n| n != count) {
        return Err(format!("instances: their accessors have different counts: one has {count}"));
    }
    let vector = |values: &Option<Vec<f32>>, i: usize, rest: Vec3| {
        values.as_ref().map_or(rest, |values| Vec3::from_slice(&values[3 * i..]))
    };
    let matrix = |i: usize| {
        let turn = rotations.as_ref().map_or(Quat::IDENTITY, |values| Quat::from_slice(&values[4 * i..]));
        let turn = if turn.length() > 1e-10 { turn.normalize() } else { Quat::IDENTITY };
        Mat4::from_scale_rotation_translation(vector(&scales, i, Vec3::ONE), turn, vector(&translations, i, Vec3::ZERO))
    };
    Ok((0..count).map(matrix).collect())
}

/// Lines about the attributes of instances that may mean something and are not read, and about instances without a place.
pub(crate) fn attribute_notes(attributes: &Value) -> Vec<String> {
    let is_read = |name: &str| ["TRANSLATION", "ROTATION", "SCALE"].contains(&name);
    let names = || attributes.as_object().into_iter().flatten().map(|(name, _)| name.as_str());
    // A program's own, but for colours, which some viewers show.
    let is_unread = |name: &&str| !is_read(name) && (!name.starts_with('_') || name.starts_with("_COLOR"));
    let unread = names().filter(is_unread).map(|name| format!("{name} of instances is not read"));
    let placeless = (!names().any(is_read)).then(|| "instances without a place are one".to_owned());
    unread.chain(placeless).collect()
}

/// The shapes at the place of each instance, as one.
pub(crate) fn expanded(shapes: &Shapes, instances: &[Mat4]) -> Shapes {
    let empty = || vec![Vec::new(); shapes.morphs.positions.len()];
    let mut all = Shapes {
        mesh: Mesh::default(),
        alphas: Vec::new(),
        morphs: shapes.morphs.with(empty(), empty()),
        is_morphed: shapes.is_morphed,
        broken: shapes.broken,
    };
    for instance in instances {
        let mut mesh = shapes.mesh.clone();
        mesh.transform(instance);
        all.mesh.append(&mesh);
        all.alphas.extend(&shapes.alphas);
        let linear = Mat3::from_mat4(*instance);
        let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
        let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
        for (to, from) in all.morphs.positions.iter_mut().zip(&shapes.morphs.positions) {
            to.extend(from.iter().map(|d| linear * *d));
        }
        // A normal that has moved keeps its direction if its move is as much longer as the normal would be.
        for (to, from) in all.morphs.normals.iter_mut().zip(&shapes.morphs.normals) {
            let length = |n: &Vec3| (cofactors * *n).length().max(f32::MIN_POSITIVE);
            to.extend(from.iter().zip(&shapes.mesh.normals).map(|(d, n)| cofactors * *d / length(n)));
        }
    }
    all
}
