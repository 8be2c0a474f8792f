//! The surfaces at the hits of rays, eight at once.

use super::World;
use super::camera_rays::{Row, SIDE};
use super::packet::{NOTHING, SPHERE};
use fearless_simd::{Level, dispatch};
use glam::Vec3;
use lobe_core::Receiver;
use obvhs::ray::Ray;
use scene::Shape;

type DVec3x8 = [[f64; SIDE]; 3];

/// Eight rays of a camera that have met something.
#[derive(Debug, Default)]
pub(crate) struct RayHits {
    /// The primitive that each has met, or [`NOTHING`].
    pub(crate) found: [u32; SIDE],
    pub(crate) starts: [Row; 3],
    pub(crate) directions: [Row; 3],
}

/// The triangles that eight rays have met.
#[derive(Default)]
struct Met {
    corner: [DVec3x8; 3],
    /// Of the corners; unused for triangles that are not smooth.
    normals: [DVec3x8; 3],
    smooth: [bool; SIDE],
    objects: [u32; SIDE],
}

/// The same as `DVec3`'s of the same names, lane by lane.
#[inline(always)]
fn dot(a: &DVec3x8, b: &DVec3x8, l: usize) -> f64 {
    a[0][l] * b[0][l] + a[1][l] * b[1][l] + a[2][l] * b[2][l]
}

#[inline(always)]
fn cross(a: &DVec3x8, b: &DVec3x8, l: usize) -> [f64; 3] {
    [
        a[1][l] * b[2][l] - b[1][l] * a[2][l],
        a[2][l] * b[0][l] - b[2][l] * a[0][l],
        a[0][l] * b[1][l] - b[0][l] * a[1][l],
    ]
}

#[inline(always)]
fn set(to: &mut DVec3x8, l: usize, v: [f64; 3]) {
    (to[0][l], to[1][l], to[2][l]) = (v[0], v[1], v[2]);
}

#[inline(always)]
fn normalize_or_zero(v: &mut DVec3x8, l: usize) {
    let inverse = 1.0 / dot(v, v, l).sqrt();
    let usable = (inverse > 0.0) & (inverse < f64::INFINITY);
    for v in v.iter_mut() {
        v[l] = if usable { v[l] * inverse } else { 0.0 };
    }
}

impl World<'_> {
    /// Writes the receivers for as many of the eight rays as `out` is long, as near to the surface as an f32 point can be: in
    /// f64 from barycentric coordinates or on the sphere, then rounded. Normals are on the rays' side.
    pub(crate) fn surfaces(&self, level: Level, are_parallel: bool, rays: &RayHits, out: &mut [Receiver]) {
        dispatch!(level, _simd => self.surfaces_simd(are_parallel, rays, out));
    }

    /// Where a ray meets a sphere, the normal there, and the sphere's object.
    fn sphere_surface(&self, number: u32, start: Vec3, direction: Vec3) -> (Vec3, Vec3, u32) {
        let sphere = &self.hierarchy.spheres.primitives[number as usize];
        let t = sphere.intersect(&Ray::new_inf(start.into(), direction.into()));
        let (position, normal) = sphere.surface(start, direction, t);
        (position, normal, sphere.object)
    }

    /// The triangles that rays have met.
    #[inline(always)]
    fn met(&self, rays: &RayHits) -> Met {
        let mut met = Met::default();
        let Met { corner, normals, smooth, objects } = &mut met;
        for (l, number) in rays.found.iter().enumerate() {
            if number & SPHERE != 0 {
                continue;
            }
            let (object, index) = self.triangle_name(*number);
            objects[l] = object;
            match &self.scene.objects[object as usize].shape {
                Shape::Mesh(mesh) => {
                    let vertices = mesh.triangles[index as usize];
                    smooth[l] = !mesh.normals.is_empty();
                    for (k, i) in vertices.into_iter().enumerate() {
                        set(&mut corner[k], l, mesh.positions[i as usize].as_dvec3().to_array());
                        if smooth[l] {
                            set(&mut normals[k], l, mesh.normals[i as usize].as_dvec3().to_array());
                        }
                    }
                }
                Shape::Instances(instances) => {
                    let (matrix, vertices) = instances.triangle(index as usize);
                    let positions = instances.corners(index as usize);
                    smooth[l] = !instances.mesh().normals.is_empty();
                    for k in 0..3 {
                        set(&mut corner[k], l, positions[k].as_dvec3().to_array());
                        if smooth[l] {
                            set(&mut normals[k], l, instances.normal(matrix, vertices[k]).as_dvec3().to_array());
                        }
                    }
                }
                Shape::Spheres(_) => unreachable!("triangles come from meshes"),
            }
        }
        met
    }

    #[inline(always)]
    fn surfaces_simd(&self, are_parallel: bool, rays: &RayHits, out: &mut [Receiver]) {
        let Met { corner, normals, smooth, objects } = self.met(rays);
        let (mut position, mut normal, mut face) = ([[0.0f32; SIDE]; 3], [[0.0f32; SIDE]; 3], [[0.0f32; SIDE]; 3]);
        let (mut d, mut e1, mut e2, mut s): (DVec3x8, DVec3x8, DVec3x8, DVec3x8) = Default::default();
        let (mut n, mut p): (DVec3x8, DVec3x8) = Default::default();
        let mut shading = DVec3x8::default();
        for l in 0..SIDE {
            for k in 0..3 {
                d[k][l] = f64::from(rays.directions[k][l]);
                e1[k][l] = corner[1][k][l] - corner[0][k][l];
                e2[k][l] = corner[2][k][l] - corner[0][k][l];
                s[k][l] = f64::from(rays.starts[k][l]) - corner[0][k][l];
            }
            set(&mut p, l, cross(&d, &e2, l));
            let inverse = 1.0 / dot(&e1, &p, l);
            let u = (dot(&s, &p, l) * inverse).clamp(0.0, 1.0);
            set(&mut p, l, cross(&s, &e1, l));
            let v = (dot(&d, &p, l) * inverse).max(0.0).min(1.0 - u);
            set(&mut n, l, cross(&e1, &e2, l));
            normalize_or_zero(&mut n, l);
            let turn = if dot(&n, &d, l) > 0.0 { -1.0 } else { 1.0 };
            for k in 0..3 {
                n[k][l] *= turn;
                position[k][l] = (corner[0][k][l] + e1[k][l] * u + e2[k][l] * v) as f32;
                let [a, b, c] = [normals[0][k][l], normals[1][k][l], normals[2][k][l]];
                shading[k][l] = a * (1.0 - u - v) + b * u + c * v;
            }
            normalize_or_zero(&mut shading, l);
            // On the side of the face that is seen; a normal that still looks away is no use to a viewer.
            let turn = if dot(&shading, &n, l) < 0.0 { -1.0 } else { 1.0 };
            for shading in &mut shading {
                shading[l] *= turn;
            }
            let usable = smooth[l] & (dot(&shading, &d, l) < 0.0);
            for k in 0..3 {
                face[k][l] = n[k][l] as f32;
                normal[k][l] = if usable { shading[k][l] as f32 } else { face[k][l] };
            }
            for v in [&mut normal, &mut face] {
                let inverse = 1.0 / (v[0][l] * v[0][l] + v[1][l] * v[1][l] + v[2][l] * v[2][l]).sqrt();
                v.iter_mut().for_each(|v| v[l] *= inverse);
            }
        }
        let at = |v: &[Row; 3], l: usize| Vec3::new(v[0][l], v[1][l], v[2][l]);
        for (l, out) in out.iter_mut().enumerate() {
            let number = rays.found[l];
            let (start, direction) = (at(&rays.starts, l), at(&rays.directions, l));
            let (mut position, mut normal, mut face) = (at(&position, l), at(&normal, l), at(&face, l));
            let mut object = objects[l];
            if number & SPHERE != 0 && number != NOTHING {
                (position, normal, object) = self.sphere_surface(number & !SPHERE, start, direction);
                face = normal;
            }
            // The view is from the rounded position, not the ray's, so that it is consistent with shading; all views are alike where
            // rays are parallel.
            let toward = if are_parallel { None } else { (start - position).try_normalize() };
            let view = toward.unwrap_or(-direction);
            *out = Receiver { position, normal, face, view, object };
        }
    }
}
