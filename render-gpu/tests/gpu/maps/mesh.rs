//! Meshes, their maps and points on them.

use glam::Vec3;
use lobe_core::oracle::Random;
use lobe_core::{Cone, Receiver, Sphere};
use visibility_shadowmap::{MapOptions, ShadowMap};

/// Triangles, smooth normals, and the object of each triangle.
#[derive(Clone, Debug, Default)]
pub(super) struct Mesh {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    objects: Vec<u32>,
}

/// Object 0 is a bumpy sphere or a fence; floors are object 1.
pub(super) const SOLID: u32 = 0;
pub(super) const FLOOR: u32 = 1;

impl Mesh {
    pub(super) fn floor(self, height: f32, size: f32) -> Self {
        let corner = |x: f32, z: f32| Vec3::new(x * size, height, z * size);
        self.quad([corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)], FLOOR)
    }

    fn quad(mut self, corners: [Vec3; 4], object: u32) -> Self {
        let first = self.positions.len() as u32;
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        self.positions.extend(corners);
        self.normals.extend([normal; 4]);
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        self.objects.extend([object; 2]);
        self
    }

    fn cuboid(mut self, low: Vec3, high: Vec3) -> Self {
        let corner = |k: usize| Vec3::select(glam::BVec3::new(k & 1 == 1, k & 2 == 2, k & 4 == 4), high, low);
        for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            self = self.quad(face.map(corner), SOLID);
        }
        self
    }

    /// Thin pickets.
    pub(super) fn fence() -> Self {
        (0..21_u8).fold(Self::default(), |mesh, k| {
            let x = -1.0 + 0.1 * f32::from(k);
            mesh.cuboid(Vec3::new(x - 0.025, 0.0, -0.01), Vec3::new(x + 0.025, 1.0, 0.01))
        })
    }

    /// A sphere with bumps, smooth normals.
    pub(super) fn bumpy(center: Vec3, radius: f32) -> Self {
        let n = 24;
        let mut mesh = Self::default();
        for j in 0..=n {
            for i in 0..2 * n {
                let step = std::f32::consts::PI / n as f32;
                let (polar, around) = (step * j as f32, step * i as f32);
                let (sin, cos) = polar.sin_cos();
                let direction = Vec3::new(sin * around.cos(), cos, sin * around.sin());
                let bump = 1.0 + 0.1 * sin * (6.0 * polar).sin() * (5.0 * around).cos();
                mesh.positions.push(center + direction * radius * bump);
            }
        }
        for j in 0..n {
            for i in 0..2 * n {
                let at = |i: u32, j: u32| j * 2 * n + i % (2 * n);
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        mesh.objects = vec![SOLID; mesh.triangles.len()];
        mesh.normals = vec![Vec3::ZERO; mesh.positions.len()];
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            for v in t {
                mesh.normals[*v as usize] += (b - a).cross(c - a);
            }
        }
        mesh.normals.iter_mut().for_each(|n| *n = n.normalize_or(Vec3::Y));
        mesh
    }

    /// A sphere, walls and a floor all around the origin.
    pub(super) fn room() -> Self {
        let mut mesh = Self::bumpy(Vec3::new(1.2, -0.4, 0.5), 0.4).floor(-2.0, 3.0);
        for (low, high) in [([-1.5, -0.6, -0.3], [-1.2, 0.5, 0.4]), ([-0.2, 0.9, -0.5], [0.5, 1.1, 0.4])] {
            mesh = mesh.cuboid(low.into(), high.into());
        }
        mesh = mesh.cuboid(Vec3::new(-0.5, -0.7, 1.1), Vec3::new(0.6, -0.2, 1.4));
        mesh.cuboid(Vec3::new(-0.4, -0.3, -1.6), Vec3::new(0.3, 0.4, -1.3))
    }

    pub(super) fn moved(mut self, by: Vec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p += by);
        self
    }

    pub(super) fn map(&self, light: Sphere, resolution: u32, layers: u32) -> ShadowMap {
        let options = MapOptions { resolution, layers, receivers: None };
        ShadowMap::build(&self.positions, &self.triangles, light, &options).expect("a good mesh")
    }

    /// Points on the triangles, and one in four in the air around them, that see a part of the light above their horizon.
    pub(super) fn receivers(&self, random: &mut Random, light: Sphere, count: usize) -> Vec<Receiver> {
        let mut out = Vec::with_capacity(count);
        while out.len() < count {
            let k = random.bits() as usize % self.triangles.len();
            let corners = self.triangles[k].map(|v| v as usize);
            let [a, b, c] = corners.map(|v| self.positions[v]);
            let (mut s, mut t) = (random.uniform() as f32, random.uniform() as f32);
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            let weights = [1.0 - s - t, s, t];
            let mut position = a * weights[0] + b * weights[1] + c * weights[2];
            let normal: Vec3 = corners.iter().zip(weights).map(|(v, w)| self.normals[*v] * w).sum();
            let (mut normal, mut face) = (normal.normalize(), (b - a).cross(c - a).normalize());
            if face.dot(normal) < 0.0 {
                face = -face;
            }
            let flat = face.dot(normal) > 0.9999;
            if random.bits().is_multiple_of(4) {
                position += 0.7 * random.uniform() as f32 * random.axis().as_vec3();
                normal = random.axis().as_vec3();
                face = normal;
            } else if flat {
                face = normal;
            }
            let cone = Cone::of_sphere(position, light);
            if cone.one_minus_cos < 0.5 && normal.dot(cone.axis) > -0.9 * cone.sin_sq().sqrt() {
                out.push(Receiver { position, normal, face, view: normal, object: self.objects[k] });
            }
        }
        out
    }
}
