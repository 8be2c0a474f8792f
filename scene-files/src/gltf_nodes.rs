//! The nodes of a glTF document: their tree, the ones that the scene shows, their cameras.

use crate::gltf_extensions::Extensions;
use glam::{DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use gltf::json::{Index, Node, Root};
use scene::motion::{Bone, Clock, FineLocal, Local, Skeleton, node_camera};
use scene::{Camera, MAX_COORDINATE, Projection};

/// All nodes, at rest.
pub(crate) fn skeleton(root: &Root) -> Result<Skeleton, String> {
    let n = root.nodes.len();
    let mut parents = vec![None; n];
    for (i, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(Index::value) {
            let slot = parents.get_mut(child).ok_or_else(|| format!("node {i}: there is no node {child}"))?;
            if slot.replace(i).is_some() {
                return Err(format!("node {child} has two parents: nodes must form a tree"));
            }
        }
    }
    let mut bones = Vec::with_capacity(n);
    for (node, parent) in root.nodes.iter().zip(&parents) {
        let local = local(node);
        bones.push(Bone {
            parent: *parent,
            fine: local.fine(),
            local,
            rest: Mat4::NAN,
            scale: None,
            rotation: None,
            translation: None,
            weights: None,
            rest_weights: rest_weights(root, node)?,
        });
    }
    let mut order = Vec::with_capacity(n);
    let mut open: Vec<usize> = (0..n).filter(|&i| parents[i].is_none()).collect();
    while let Some(i) = open.pop() {
        let local = bones[i].local(0.0);
        let world = parents[i].map_or(local, |p| bones[p].rest * local);
        if !world.is_finite() {
            return Err(format!("node {i}: the transform is not finite in single precision"));
        }
        bones[i].rest = world;
        order.push(i);
        open.extend(root.nodes[i].children.iter().flatten().map(Index::value));
    }
    // Each node has at most one parent here, so a node that no root reaches hangs on a cycle.
    if order.len() < n {
        let lost = bones.iter().position(|b| b.rest.is_nan()).unwrap_or(0);
        return Err(format!("node cycle at node {lost}"));
    }
    Ok(Skeleton {
        bones,
        order,
        origin: DVec3::ZERO,
        is_fine: false,
        clock: Clock { first: 0.0, last: 0.0, repeats: true },
    })
}

/// Lines about transforms that the format does not allow: how they are taken.
pub(crate) fn transform_notes(root: &Root) -> Vec<String> {
    let count = |is: &dyn Fn(&Node, [f32; 16]) -> bool| {
        root.nodes.iter().filter(|node| node.matrix.is_some_and(|matrix| is(node, matrix))).count()
    };
    let both = count(&|node, _| node.translation.is_some() || node.rotation.is_some() || node.scale.is_some());
    let uneven = count(&|_, m| [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0]);
    let lines = [
        (both, "nodes have a matrix beside a translation, rotation or scale: the matrix alone counts"),
        (uneven, "nodes have a matrix whose last row is not 0 0 0 1: it is taken as that"),
    ];
    lines.into_iter().filter(|(count, _)| *count > 0).map(|(count, line)| format!("{count} {line}")).collect()
}

fn local(node: &Node) -> Local {
    if let Some(m) = &node.matrix {
        let mut m = Mat4::from_cols_array(m);
        // Affine: the last row is (0, 0, 0, 1).
        (m.x_axis.w, m.y_axis.w, m.z_axis.w, m.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
        return Local::Matrix(m);
    }
    let q = Quat::from_array(node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |r| r.0));
    let rotation = if q.length() > 1e-10 { q.normalize() } else { Quat::IDENTITY };
    let scale = Vec3::from_array(node.scale.unwrap_or([1.0; 3]));
    Local::Parts { scale, rotation, translation: Vec3::from_array(node.translation.unwrap_or([0.0; 3])) }
}

/// The transforms of all nodes as the JSON spells them; none for nodes that spell none.
pub(crate) fn fine_locals(json: &[u8]) -> Option<Vec<Option<FineLocal>>> {
    let value: gltf::json::Value = gltf::json::deserialize::from_slice(json).ok()?;
    let numbers = |node: &gltf::json::Value, key: &str| -> Option<Vec<f64>> {
        node.get(key)?.as_array()?.iter().map(gltf::json::Value::as_f64).collect()
    };
    let local = |node: &gltf::json::Value| {
        if let Some(m) = numbers(node, "matrix") {
            let mut m = DMat4::from_cols_array(m.as_slice().try_into().ok()?);
            (m.x_axis.w, m.y_axis.w, m.z_axis.w, m.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
            return Some(FineLocal::Matrix(m));
        }
        let vector = |key, rest| numbers(node, key).map_or(Some(rest), |v| Some(DVec3::from_array(v.try_into().ok()?)));
        let rotation = match numbers(node, "rotation") {
            None => DQuat::IDENTITY,
            Some(q) => DQuat::from_array(q.try_into().ok()?),
        };
        let rotation = if rotation.length() > 1e-10 { rotation.normalize() } else { DQuat::IDENTITY };
        let (scale, translation) = (vector("scale", DVec3::ONE)?, vector("translation", DVec3::ZERO)?);
        Some(FineLocal::Parts { scale, rotation, translation })
    };
    Some(value.get("nodes")?.as_array()?.iter().map(local).collect())
}

/// The morph weights of a node: its own, else its mesh's, else zeros, one for each target of its first primitive.
fn rest_weights(root: &Root, node: &Node) -> Result<Vec<f32>, String> {
    // A mesh that does not exist is refused where it is drawn.
    let Some((m, mesh)) = node.mesh.and_then(|m| Some((m.value(), root.meshes.get(m.value())?))) else {
        return Ok(Vec::new());
    };
    let targets = mesh.primitives.first().and_then(|p| p.targets.as_ref()).map_or(0, Vec::len);
    let weights = node.weights.as_ref().or(mesh.weights.as_ref());
    match weights {
        None => Ok(vec![0.0; targets]),
        Some(w) if w.len() != targets => Err(format!("mesh {m}: {} morph weights for {targets} targets", w.len())),
        Some(w) if w.iter().any(|w| w.is_nan() || w.abs() > MAX_COORDINATE) => {
            Err(format!("mesh {m}: morph weights must lie within ±1e9"))
        }
        Some(w) => Ok(w.clone()),
    }
}

/// Nodes of the default scene, of the first one where none is named, or all where there is no scene; in document order. With each whether
/// it is visible: neither it nor a node above it says that it is not.
pub(crate) fn shown_nodes(root: &Root, extensions: &Extensions) -> Result<Vec<(usize, bool)>, String> {
    let n = root.nodes.len();
    let scene = match root.scene {
        Some(index) => {
            let i = index.value();
            Some(root.scenes.get(i).ok_or_else(|| format!("there is no scene {i}"))?)
        }
        None => root.scenes.first(),
    };
    let mut open: Vec<(usize, bool)> = match scene {
        Some(scene) => scene.nodes.iter().map(|node| (node.value(), true)).collect(),
        None => {
            let mut is_child = vec![false; n];
            let children = root.nodes.iter().flat_map(|node| node.children.iter().flatten());
            children.for_each(|child| is_child[child.value()] = true);
            (0..n).filter(|&i| !is_child[i]).map(|i| (i, true)).collect()
        }
    };
    let mut shown: Vec<Option<bool>> = vec![None; n];
    while let Some((i, is_visible)) = open.pop() {
        let slot = shown.get_mut(i).ok_or_else(|| format!("the scene names node {i}, which does not exist"))?;
        if slot.is_none() {
            let is_visible = is_visible && !extensions.hides(i);
            *slot = Some(is_visible);
            open.extend(root.nodes[i].children.iter().flatten().map(|child| (child.value(), is_visible)));
        }
    }
    Ok(shown.into_iter().enumerate().filter_map(|(i, shown)| Some((i, shown?))).collect())
}

/// A camera at a node with that world matrix, if it is of a known kind. The picture's own sides decide its width.
pub(crate) fn read_camera(root: &Root, index: usize, world: &Mat4) -> Result<Option<Camera>, String> {
    let camera = root.cameras.get(index).ok_or_else(|| format!("there is no camera {index}"))?;
    let projection = match (&camera.perspective, &camera.orthographic) {
        (Some(p), _) => {
            let planes_fit = p.znear > 0.0 && p.zfar.is_none_or(|far| far > p.znear);
            if !planes_fit || p.aspect_ratio.is_some_and(|a| a.is_nan() || a <= 0.0) {
                return Err(format!("camera {index}: planes and aspect ratio must be positive, and far beyond near"));
            }
            Projection::perspective(p.yfov)
        }
        (None, Some(o)) => {
            if !(o.xmag > 0.0 && o.ymag > 0.0 && o.znear >= 0.0 && o.zfar > o.znear) {
                return Err(format!("camera {index}: xmag and ymag must be positive, and zfar beyond znear"));
            }
            // Half of the picture.
            Projection::Orthographic { height: 2.0 * o.ymag }
        }
        (None, None) => return Ok(None),
    };
    let camera = node_camera(world, projection);
    camera.validate().map_err(|e| format!("camera {index}: {e}"))?;
    Ok(Some(camera))
}
