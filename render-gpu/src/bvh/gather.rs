//! The primitives of a scene that rays may meet.

use super::primitive::{BLOCKS, BLOCKS_ALIKE, FLAT, GpuPrimitive, SPHERE, ShadowCasting, VISIBLE, bounds};
use crate::GpuError;
use glam::Vec3;
use scene::{Duplicates, Scene, Shape};

/// The primitives of a scene.
pub(super) struct Gathered {
    /// In units of the hierarchy.
    pub(super) primitives: Vec<GpuPrimitive>,
    /// For each primitive its number within its object.
    pub(super) names: Vec<u32>,
    /// Nine numbers (three normals) for each triangle that has normals.
    pub(super) normals: Vec<f32>,
    pub(super) scale: f32,
}

/// The triangles with an area and the spheres with a radius of all objects that are seen or block; equal meshes and spheres are
/// listed once. Without any, the list holds one placeholder that is neither seen nor blocks, since a hierarchy has at least one
/// node.
pub(super) fn gather(scene: &Scene, casting: &[ShadowCasting]) -> Result<Gathered, GpuError> {
    let (needed, allowed) = (scene.objects.len() as u64, u64::from(BLOCKS_ALIKE));
    if needed > allowed {
        return Err(GpuError::Limits { what: "the number of objects", needed, allowed });
    }
    let mut all = Gathered { primitives: vec![], names: vec![], normals: vec![], scale: 1.0 };
    let mut duplicates = Duplicates::default();
    for (number, object) in scene.objects.iter().enumerate() {
        if object.is_met() {
            let blocks = match casting.get(number).copied() {
                Some(ShadowCasting::All) => BLOCKS,
                Some(ShadowCasting::Alike) => BLOCKS_ALIKE,
                None if casting.is_empty() => BLOCKS,
                Some(ShadowCasting::None) | None => 0,
            };
            add(&mut all, &mut duplicates, number as u32, scene, blocks);
        }
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for p in &all.primitives {
        let [from, to] = bounds(p);
        (low, high) = (low.min(from), high.max(to));
    }
    if all.primitives.is_empty() {
        all.primitives.push(GpuPrimitive { corners: FLAT, ..GpuPrimitive::default() });
        all.names.push(0);
        return Ok(all);
    }
    let far = low.abs().max(high.abs()).max_element();
    all.scale = hierarchy_scale((high - low).length().max(far));
    for p in &mut all.primitives {
        [&mut p.a, &mut p.b, &mut p.c].into_iter().flatten().for_each(|x| *x *= all.scale);
    }
    Ok(all)
}

fn add(all: &mut Gathered, duplicates: &mut Duplicates, number: u32, scene: &Scene, blocks: u32) {
    let object = &scene.objects[number as usize];
    let material = object.material as u32;
    let seen = if object.visible { VISIBLE } else { 0 };
    match &object.shape {
        // Instances are copied: a GPU has one hierarchy.
        shape @ (Shape::Mesh(_) | Shape::Instances(_)) => {
            let is_first = duplicates.is_first_mesh(&scene.objects, number as usize);
            let Some(mesh) = shape.mesh().filter(|_| is_first) else { return };
            for (index, corners) in mesh.triangles.iter().enumerate() {
                let [a, b, c] = corners.map(|i| mesh.positions[i as usize]);
                if (b - a).cross(c - a) == Vec3::ZERO {
                    continue;
                }
                let mut first = FLAT;
                if !mesh.normals.is_empty() {
                    first = all.normals.len() as u32;
                    all.normals.extend(corners.iter().flat_map(|i| mesh.normals[*i as usize].to_array()));
                }
                all.names.push(index as u32);
                all.primitives.push(GpuPrimitive {
                    a: a.into(),
                    object: number | seen | blocks,
                    b: b.into(),
                    material,
                    c: c.into(),
                    corners: first,
                });
            }
        }
        Shape::Spheres(spheres) => {
            for (index, sphere) in spheres.iter().enumerate().filter(|(_, sphere)| sphere.radius > 0.0) {
                if !duplicates.is_first(object, sphere) {
                    continue;
                }
                all.names.push(index as u32);
                all.primitives.push(GpuPrimitive {
                    a: sphere.center.into(),
                    object: number | seen | blocks | SPHERE,
                    b: [sphere.radius, scene.casting(sphere).radius, 0.0],
                    material,
                    c: [0.0; 3],
                    corners: FLAT,
                });
            }
        }
    }
}

/// The power of two that brings coordinates up to `size` to about a million: products of three of them stay far from the
/// ends of f32.
fn hierarchy_scale(size: f32) -> f32 {
    let exponent = (20.0 - size.log2().floor()).clamp(-100.0, 60.0);
    f32::from_bits(((127.0 + exponent) as u32) << 23)
}
