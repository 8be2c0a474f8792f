//! Textures, vertex colours and emission at points.

use super::World;
use super::packet::SPHERE;
use brdf::Material;
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{DVec3, Mat2, Mat4, Vec2, Vec3};
use lobe_core::{Receiver, Sphere};
use scene::{Mesh, Scene, Shape, Surface, TextureMap, TexturePlace};

/// For each object whether its points have a look of their own; `None` if no object has such points.
pub(crate) fn varied(scene: &Scene) -> Option<Vec<bool>> {
    let has_colors = |shape: &Shape| shape.vertices().is_some_and(|mesh| !mesh.colors.is_empty());
    let differs = |o: &scene::Object| scene.surface(o.material).is_some() || has_colors(&o.shape);
    let varied: Vec<bool> = scene.objects.iter().map(differs).collect();
    varied.contains(&true).then_some(varied)
}

/// For each object the tangents of its vertices along the growing u of its normal map, of length 1 and less where triangles do not agree;
/// none for objects without such a map or without smooth normals, and nothing at all where no object has any. Those of instances are of the
/// shared mesh, in its own coordinates.
pub(super) fn tangents(scene: &Scene) -> Vec<Vec<Vec3>> {
    let of = |o: &scene::Object| {
        let surface = scene.surface(o.material)?;
        let (map, _) = surface.normal.as_ref().or(surface.clearcoat_normal.as_ref())?;
        let mesh = o.shape.vertices()?;
        let uvs = mesh.uv_sets.get(map.uv_set)?;
        (!mesh.normals.is_empty()).then(|| vertex_tangents(mesh, uvs, map.transform.matrix2))
    };
    let all: Vec<Vec<Vec3>> = scene.objects.iter().map(|o| of(o).unwrap_or_default()).collect();
    if all.iter().all(Vec::is_empty) { Vec::new() } else { all }
}

/// The tangents of a mesh's vertices along growing u of coordinates that a matrix transforms: means of the adjoining triangles' tangents,
/// weighted by their angles, of length 1 and less where triangles do not agree.
#[must_use]
pub fn vertex_tangents(mesh: &Mesh, uvs: &[Vec2], transform: Mat2) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::ZERO, 0.0); mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
        let [p, q, r] = triangle.map(|i| transform * uvs[i as usize]);
        let (e1, e2, d1, d2) = (b - a, c - a, q - p, r - p);
        // dP/du, but for a positive factor.
        let turn = f64::from(d1.perp_dot(d2));
        let tangent = ((e1 * f64::from(d2.y) - e2 * f64::from(d1.y)) * turn.signum()).try_normalize();
        let (Some(tangent), true) = (tangent, turn.is_normal()) else { continue };
        for k in 0..3 {
            let at = |i: usize| mesh.positions[triangle[(k + i) % 3] as usize].as_dvec3();
            let angle = (at(1) - at(0)).angle_between(at(2) - at(0)) as f32;
            if angle.is_finite() {
                let (sum, all) = &mut sums[triangle[k] as usize];
                *sum += angle * tangent.as_vec3();
                *all += angle;
            }
        }
    }
    sums.into_iter().map(|(sum, all)| sum / all.max(f32::MIN_POSITIVE)).collect()
}

/// The look of a single point.
pub(crate) struct Appearance {
    /// None where its object's is all there is.
    pub(crate) material: Option<Material>,
    pub(crate) emission: Vec3,
}

/// A point of a triangle or sphere, with the data for looking up its textures.
struct Patch<'a> {
    mesh: Option<&'a Mesh>,
    /// From the mesh's coordinates to the world, if these differ.
    matrix: Option<&'a Mat4>,
    /// The triangle's vertices.
    vertices: [u32; 3],
    /// The barycentric weights of the second and third vertex; of a sphere its coordinates in turns and half turns.
    weights: [f32; 2],
    /// The gradients of the weights over the surface.
    gradients: [Vec3; 2],
    /// Sides of the pixel on the surface.
    sides: [Vec3; 2],
}

impl World<'_> {
    /// The look of a point that a ray of the camera has `found`; turns the normal as the normal map says.
    /// `sides` are those of the pixel's part that the ray stands for, on the surface.
    pub(crate) fn appearance(&self, found: u32, sides: [Vec3; 2], at: &mut Receiver) -> Appearance {
        let object = &self.scene.objects[at.object as usize];
        let plain = Surface::default();
        let surface = self.scene.surface(object.material).unwrap_or(&plain);
        let patch = self.patch(found, sides, at);
        // Most textures use the first set of coordinates.
        let first = if surface.has_textures() { patch.place(0) } else { TexturePlace::default() };
        let place = |set: usize| if set == 0 { first } else { patch.place(set) };
        let color = patch.color();
        let own = &self.scene.materials[object.material];
        let mut emission = if surface.emits() { surface.emission(&place) } else { Vec3::ZERO };
        if surface.is_unlit {
            emission *= color.unwrap_or(Vec3::ONE);
        }
        let tangents = self.hierarchy.tangents.get(at.object as usize).map_or(&[][..], Vec::as_slice);
        // A clear coat has a map of its own, or none.
        let has_normals = surface.normal.is_some() || surface.clearcoat_normal.is_some();
        let of_clearcoat = match (surface.clearcoat_normal(&place), &surface.clearcoat_normal) {
            (Some(local), Some((map, _))) => patch.turned(at, map, tangents, local),
            _ => at.normal,
        };
        if let (Some(local), Some((map, _))) = (surface.normal(&place), &surface.normal) {
            at.normal = patch.turned(at, map, tangents, local);
        }
        let material = (color.is_some() || surface.varies()).then(|| {
            let mut factors = surface.factors(&place);
            factors.color *= color.unwrap_or(Vec3::ONE);
            let material = own.scaled(&factors);
            let along = surface.follows_u.then(|| along_grain(at, patch.changes(0), surface.grain(&place)));
            along.and_then(|along| material.turned(at.normal, along)).unwrap_or(material)
        });
        let coated =
            has_normals.then(|| material.as_ref().unwrap_or(own).with_clearcoat_normal(of_clearcoat)).flatten();
        let material = coated.or(material);
        if emission != Vec3::ZERO {
            emission *= material.as_ref().unwrap_or(own).lets_out(at);
        }
        Appearance { material, emission }
    }

    fn patch(&self, found: u32, sides: [Vec3; 2], at: &Receiver) -> Patch<'_> {
        if found & SPHERE != 0 {
            let sphere = self.hierarchy.spheres.primitives[(found & !SPHERE) as usize].sphere;
            let (weights, gradients) = on_sphere(sphere, at.position);
            return Patch { mesh: None, matrix: None, vertices: [0; 3], weights, gradients, sides };
        }
        let (object, index) = self.triangle_name(found);
        let (mesh, matrix, vertices) = match &self.scene.objects[object as usize].shape {
            Shape::Mesh(mesh) => (mesh, None, mesh.triangles[index as usize]),
            Shape::Instances(instances) => {
                let (matrix, vertices) = instances.triangle(index as usize);
                (&**instances.mesh(), Some(matrix), vertices)
            }
            Shape::Spheres(_) => unreachable!("triangles come from meshes"),
        };
        let [a, b, c] = self.corners((object, index)).unwrap_or_default().map(Vec3::as_dvec3);
        let (e1, e2, p) = (b - a, c - a, at.position.as_dvec3() - a);
        let n = e1.cross(e2);
        let inverse = 1.0 / n.length_squared();
        let gradients =
            if inverse.is_finite() { [e2.cross(n) * inverse, n.cross(e1) * inverse] } else { [DVec3::ZERO; 2] };
        let [u, v] = gradients.map(|g| g.dot(p).clamp(0.0, 1.0));
        let v = v.min(1.0 - u);
        Patch {
            mesh: Some(mesh),
            matrix,
            vertices,
            weights: [u as f32, v as f32],
            gradients: gradients.map(|g| g.as_vec3()),
            sides,
        }
    }
}

impl Patch<'_> {
    /// A vector of the mesh, turned to the world; its length stays.
    fn in_world(&self, vector: Vec3) -> Vec3 {
        self.matrix.map_or(vector, |matrix| matrix.transform_vector3(vector).normalize_or_zero() * vector.length())
    }

    /// Coordinates of the three vertices in a set.
    fn corners(&self, set: usize) -> Option<[Vec2; 3]> {
        let uvs = self.mesh?.uv_sets.get(set)?;
        Some(self.vertices.map(|i| uvs[i as usize]))
    }

    /// The gradients of u and v of a set over the surface.
    fn changes(&self, set: usize) -> [Vec3; 2] {
        let [g1, g2] = self.gradients;
        match (self.corners(set), self.mesh) {
            (Some([a, b, c]), _) => {
                let (b, c) = (b - a, c - a);
                [g1 * b.x + g2 * c.x, g1 * b.y + g2 * c.y]
            }
            (None, None) => [g1, g2],
            (None, Some(_)) => [Vec3::ZERO; 2],
        }
    }

    fn place(&self, set: usize) -> TexturePlace {
        let [s, t] = self.weights;
        let uv = match (self.corners(set), self.mesh) {
            (Some([a, b, c]), _) => a + (b - a) * s + (c - a) * t,
            (None, None) => Vec2::new(s, t),
            (None, Some(_)) => Vec2::ZERO,
        };
        let [u, v] = self.changes(set);
        TexturePlace { uv, footprint: self.sides.map(|side| Vec2::new(u.dot(side), v.dot(side))) }
    }

    /// The receiver's normal turned to one of a map.
    fn turned(&self, at: &Receiver, map: &TextureMap, tangents: &[Vec3], local: Vec3) -> Vec3 {
        let tangent = self.mix(tangents).map(|tangent| self.in_world(tangent));
        mapped_normal(at, self.changes(map.uv_set), map, tangent, local)
    }

    fn color(&self) -> Option<Vec3> {
        self.mix(&self.mesh?.colors)
    }

    /// The value of the vertices, interpolated at the point; `None` if they have none.
    fn mix(&self, of_vertices: &[Vec3]) -> Option<Vec3> {
        let [s, t] = self.weights;
        let value = |i: usize| of_vertices[self.vertices[i] as usize];
        (!of_vertices.is_empty()).then(|| value(0) * (1.0 - s - t) + value(1) * s + value(2) * t)
    }
}

/// Longitude in turns and, from the upper pole down, latitude in half turns, with their gradients.
fn on_sphere(sphere: Sphere, position: Vec3) -> ([f32; 2], [Vec3; 2]) {
    let d = position - sphere.center;
    let across = d.x.hypot(d.z).max(1e-6 * sphere.radius);
    let u = 0.5 + 0.5 * FRAC_1_PI * d.x.atan2(d.z);
    let v = (d.y / sphere.radius).clamp(-1.0, 1.0).acos() * FRAC_1_PI;
    let east = Vec3::new(d.z, 0.0, -d.x) / across;
    let north = Vec3::new(-d.x * d.y, across * across, -d.z * d.y) / (across * sphere.radius);
    ([u, v], [east / (2.0 * PI * across), -north / (PI * sphere.radius)])
}

/// The direction in the surface in which u grows and v does not; of any length.
fn along_u(at: &Receiver, [u, v]: [Vec3; 2]) -> Vec3 {
    v.cross(at.face) * u.cross(v).dot(at.face).signum()
}

/// A direction by its parts along growing u and against growing v, of any length.
fn along_grain(at: &Receiver, changes: [Vec3; 2], grain: Vec2) -> Vec3 {
    let to_u = along_u(at, changes);
    if grain == Vec2::X {
        return to_u;
    }
    let [u, v] = changes;
    let to_v = u.cross(at.face) * u.cross(v).dot(at.face).signum();
    to_u.normalize_or_zero() * grain.x + to_v.normalize_or_zero() * grain.y
}

/// The normal of a point turned to the `local` one of a normal map. `gradients` are those of the mesh's u and v over the surface, before the
/// map's transform; `tangent` is that of the [vertices](vertex_tangents), interpolated, where normals are smooth.
#[must_use]
pub fn mapped_normal(
    at: &Receiver,
    gradients: [Vec3; 2],
    map: &TextureMap,
    tangent: Option<Vec3>,
    local: Vec3,
) -> Vec3 {
    let ([x, y], m) = (gradients, map.transform.matrix2);
    turned(at, [x * m.x_axis.x + y * m.y_axis.x, x * m.x_axis.y + y * m.y_axis.y], tangent, local)
}

/// The normal of a point turned to one in the frame of texture coordinates, on the eye's side; by the tangent of its vertices where that is
/// near the triangle's own, which coordinates that are mirrored at a vertex leave it not.
fn turned(at: &Receiver, [u, v]: [Vec3; 2], of_vertices: Option<Vec3>, local: Vec3) -> Vec3 {
    let n = at.normal;
    // Along growing u and against growing v, in the surface.
    let turn = u.cross(v).dot(at.face);
    let (to_u, to_v) = (along_u(at, [u, v]), u.cross(at.face) * turn.signum());
    let own = to_u.normalize_or_zero();
    let to_u = of_vertices.filter(|t| t.dot(own) > 0.5 * t.length().max(0.5)).unwrap_or(own);
    let tangent = to_u - n * n.dot(to_u);
    let (Some(tangent), true) = (tangent.try_normalize(), turn.is_normal()) else { return n };
    let across = n.cross(tangent);
    let across = if across.dot(to_v) < 0.0 { -across } else { across };
    let Some(turned) = (tangent * local.x + across * local.y + n * local.z).try_normalize() else { return n };
    // A normal that looks away from the eye is brought to where it is seen at a grazing angle.
    let seen = turned.dot(at.view);
    if seen >= GRAZING { turned } else { (turned + at.view * (GRAZING - seen)).try_normalize().unwrap_or(n) }
}

/// Least cosine between a mapped normal and the view.
const GRAZING: f32 = 0.01;
