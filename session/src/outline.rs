use glam::{Vec2, Vec3};
use lighting::Light;
use lobe_core::{Receiver, Sphere};
use renderer::{LightMask, Renderer};
use scene::{Mesh, Shape, Strategy};
use shading::LightLobes;
use std::collections::HashMap;

/// Lines that are given for a light, at most.
const MOST: usize = 4096;
/// Lines around a sphere.
const AROUND: usize = 48;
/// Lines are cut so far before the point, as parts of the distance to the light.
const NEAREST: f32 = 1e-4;

/// A line on the outline of a blocker as a point sees it, cut to the window of a light's mask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Its ends in the scene.
    pub ends: [Vec3; 2],
    /// The same in the mask: parts of its width from the left and of its height from the top.
    pub places: [Vec2; 2],
}

/// The outlines before a light as a point sees them: edges between a face that it sees from outside and one from inside, edges with one
/// face, and the outline of all spheres that block, their own or those of meshes. Nearer than the light and above the horizon; objects that
/// block by shadow maps or rays have none.
///
/// # Cost
/// All triangles of the scene once.
pub(crate) fn outlines(renderer: &Renderer, at: &Receiver, light: &Light, mask: &LightMask) -> Vec<Outline> {
    let bounds = light.bounds();
    let far = (bounds.center - at.position).length() + bounds.radius;
    let view = View { at, mask, far: if light.world().is_some() { f32::INFINITY } else { far } };
    let (mut found, plan) = (Vec::new(), renderer.plan());
    for (place, object) in renderer.scene().objects.iter().enumerate() {
        if let Shape::Mesh(mesh) = &object.shape
            && plan.of(place) == Strategy::Silhouettes
        {
            view.mesh(mesh, &mut found);
        }
    }
    view.spheres(&renderer.blocker_spheres().spheres, &mut found);
    found.truncate(MOST);
    found
}

/// A light as a point sees it.
struct View<'a> {
    at: &'a Receiver,
    mask: &'a LightMask,
    /// The distance of its far end.
    far: f32,
}

/// An edge of triangles: their sides as the point sees them, and how many there are.
#[derive(Clone, Copy)]
struct Edge {
    ends: [Vec3; 2],
    sides: i32,
    count: i32,
}

impl View<'_> {
    /// A point as coordinates in the window, from −1 to 1, times its distance along the window's axis, and that distance.
    fn placed(&self, point: Vec3) -> Vec3 {
        let (square, from) = (&self.mask.square, point - self.at.position);
        let along = from.dot(square.axis);
        let flat = Vec2::new(from.dot(square.right), from.dot(square.up));
        ((flat - square.center * along) / square.half.max(Vec2::splat(f32::MIN_POSITIVE))).extend(along)
    }

    fn mesh(&self, mesh: &Mesh, found: &mut Vec<Outline>) {
        let placed: Vec<Vec3> = mesh.positions.iter().map(|point| self.placed(*point)).collect();
        let mut edges: HashMap<[[u32; 3]; 2], Edge> = HashMap::new();
        for triangle in &mesh.triangles {
            let corners = triangle.map(|corner| mesh.positions[corner as usize]);
            if is_outside(triangle.map(|corner| placed[corner as usize])) {
                continue;
            }
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let side = if normal.dot(self.at.position - corners[0]) > 0.0 { 1 } else { -1 };
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let ends = [corners[a], corners[b]];
                // Vertices that textures divide are one.
                let mut key = ends.map(|end| (end + Vec3::ZERO).to_array().map(f32::to_bits));
                key.sort_unstable();
                let edge = edges.entry(key).or_insert(Edge { ends, sides: 0, count: 0 });
                (edge.sides, edge.count) = (edge.sides + side, edge.count + 1);
            }
        }
        // Both sides, or one face alone.
        let bounds = |edge: &&Edge| edge.count == 1 || edge.sides.abs() < edge.count;
        let mut lines: Vec<Edge> = edges.values().filter(bounds).copied().collect();
        lines.sort_unstable_by_key(|edge| edge.ends.map(|end| end.to_array().map(f32::to_bits)));
        found.extend(lines.iter().filter_map(|edge| self.cut(edge.ends)));
    }

    /// The outline of spheres together: parts of a circle that another sphere hides or covers are none of it.
    fn spheres(&self, spheres: &[Sphere], found: &mut Vec<Outline>) {
        let toward = |sphere: &Sphere| sphere.center - self.at.position;
        // Not those around the point, nor that of the light itself.
        let is_before = |sphere: &&Sphere| (sphere.radius..0.999 * self.far).contains(&toward(sphere).length());
        let before: Vec<&Sphere> = spheres.iter().filter(is_before).collect();
        let mut lines = Vec::new();
        before.iter().for_each(|sphere| self.circle(toward(sphere), sphere.radius, &mut lines));
        let is_inside = |line: &Outline| {
            let direction = (0.5 * (line.ends[0] + line.ends[1]) - self.at.position).normalize();
            before.iter().any(|sphere| {
                let along = direction.dot(toward(sphere));
                // The line's own sphere is touched, but for the sagitta of its arc.
                along > 0.0 && toward(sphere).length_squared() - along * along < (0.99 * sphere.radius).powi(2)
            })
        };
        found.extend(lines.into_iter().filter(|line| !is_inside(line)));
    }

    /// The circle along which rays from the point touch a sphere.
    fn circle(&self, toward: Vec3, radius: f32, found: &mut Vec<Outline>) {
        let (square, length) = (toward.length_squared(), toward.length());
        let part = 1.0 - radius * radius / square;
        let (middle, reach) = (self.at.position + part * toward, radius * part.sqrt());
        let (u, v) = (toward / length).any_orthonormal_pair();
        let point = |k: usize| {
            let angle = std::f32::consts::TAU * (k % AROUND) as f32 / AROUND as f32;
            middle + reach * (angle.cos() * u + angle.sin() * v)
        };
        found.extend((0..AROUND).filter_map(|k| self.cut([point(k), point(k + 1)])));
    }

    /// The part of a line that is in the window, above the horizon and nearer than the light.
    fn cut(&self, ends: [Vec3; 2]) -> Option<Outline> {
        if ends.iter().all(|end| end.distance(self.at.position) >= self.far) {
            return None;
        }
        let placed = ends.map(|end| self.placed(end));
        let height = ends.map(|end| (end - self.at.position).dot(self.at.normal));
        let nearest = NEAREST * if self.far.is_finite() { self.far } else { 1.0 };
        let sides = |k: usize| {
            let Vec3 { x, y, z } = placed[k];
            [z - nearest, z - x, z + x, z - y, z + y, height[k]]
        };
        let (mut from, mut to) = (0.0_f32, 1.0_f32);
        for (a, b) in sides(0).into_iter().zip(sides(1)) {
            match (a >= 0.0, b >= 0.0) {
                (true, true) => {}
                (false, false) => return None,
                (false, true) => from = from.max(a / (a - b)),
                (true, false) => to = to.min(a / (a - b)),
            }
        }
        (from < to).then(|| {
            let at = |part: f32| ends[0].lerp(ends[1], part);
            let place = |part: f32| {
                let Vec3 { x, y, z } = placed[0].lerp(placed[1], part);
                0.5 * (Vec2::ONE + Vec2::new(x, -y) / z)
            };
            Outline { ends: [at(from), at(to)], places: [place(from), place(to)] }
        })
    }
}

/// Whether no part of a triangle is in the window.
fn is_outside(corners: [Vec3; 3]) -> bool {
    let all = |is_out: fn(Vec3) -> bool| corners.iter().all(|corner| is_out(*corner));
    all(|v| v.z <= 0.0) || all(|v| v.x > v.z) || all(|v| v.x < -v.z) || all(|v| v.y > v.z) || all(|v| v.y < -v.z)
}
