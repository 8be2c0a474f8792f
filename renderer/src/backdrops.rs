//! Backdrops: floors, walls and coves behind which nothing is seen and no light stands.

use core::cell::OnceCell;
use glam::{DVec3, Vec3};
use lighting::Light;
use lobe_core::Sphere;
use scene::{Bounds, Mesh, Scene, Shape};
use shading::LightLobes;

/// Meshes of more triangles are no backdrops: they would take long to compare.
const MOST_TRIANGLES: usize = 256;

/// Finds the meshes of a scene that cannot hide any light from any visible surface: all lights, all visible objects and the mesh itself are
/// on one side of the plane of each of its triangles. Leaving these out of the blockers changes no picture.
pub(crate) struct Backdrops<'s> {
    scene: &'s Scene,
    points: Option<Bounds>,
    /// The boxes of visible objects, where they are needed.
    boxes: OnceCell<Vec<Option<Bounds>>>,
}

impl<'s> Backdrops<'s> {
    /// `points`: a box around other points that are lit.
    pub(crate) const fn new(scene: &'s Scene, points: Option<Bounds>) -> Self {
        Self { scene, points, boxes: OnceCell::new() }
    }

    /// Whether an object is a backdrop.
    ///
    /// Cost: its triangles times lights, objects and its vertices; the first time, one look at each vertex of the scene.
    pub(crate) fn has(&self, object: usize) -> bool {
        let Shape::Mesh(mesh) = &self.scene.objects[object].shape else { return false };
        mesh.triangles.len() <= MOST_TRIANGLES
            && mesh.positions.len() <= 3 * MOST_TRIANGLES
            && mesh.triangles.iter().all(|&t| self.has_all_before(object, mesh, t))
    }

    fn has_all_before(&self, object: usize, mesh: &Mesh, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let Some(normal) = (b - a).as_dvec3().cross((c - a).as_dvec3()).try_normalize() else { return true };
        let size = self.scene.objects[object].shape.bounds().radius();
        let before =
            |normal: DVec3| {
                let plane = Plane { corner: a, normal, size };
                self.scene.lights.iter().all(|light| plane.has_light_before(light))
                    && self.points.is_none_or(|points| plane.has_box_before(&points))
                    && mesh.positions.iter().all(|p| plane.has_before(*p, 0.0))
                    && self.boxes().iter().enumerate().all(|(other, bounds)| {
                        bounds.is_none_or(|bounds| other == object || plane.has_box_before(&bounds))
                    })
            };
        before(normal) || before(-normal)
    }

    fn boxes(&self) -> &[Option<Bounds>] {
        self.boxes.get_or_init(|| {
            self.scene.objects.iter().map(|object| object.visible.then(|| object.shape.bounds())).collect()
        })
    }
}

/// The plane of a triangle, and the radius of its mesh.
struct Plane {
    corner: Vec3,
    normal: DVec3,
    size: f32,
}

impl Plane {
    /// Whether a point is before the plane, or behind it by no more than `slack` and the rounding of coordinates.
    fn has_before(&self, point: Vec3, slack: f32) -> bool {
        let rounding = 5e-7 * self.normal.abs().dot(point.abs().max(self.corner.abs()).as_dvec3());
        self.normal.dot(point.as_dvec3() - self.corner.as_dvec3()) >= -f64::from(slack) - rounding
    }

    /// A part of 1e-4 of the box or of the mesh, of the smaller one, may be behind: what stands on a floor touches it.
    fn has_box_before(&self, bounds: &Bounds) -> bool {
        if bounds.is_empty() {
            return true;
        }
        let behind = Vec3::select(self.normal.as_vec3().cmpgt(Vec3::ZERO), bounds.min, bounds.max);
        self.has_before(behind, 1e-4 * bounds.radius().min(self.size))
    }

    fn has_light_before(&self, light: &Light) -> bool {
        let has_sphere = |center: Vec3, radius: f32| {
            let deepest = center.as_dvec3() - self.normal * f64::from(radius);
            self.has_before(deepest.as_vec3(), 1e-5 * radius)
        };
        match light {
            Light::Flat(flat) => match flat.as_disc() {
                (_, None) => flat.corners().iter().all(|p| self.has_before(*p, 0.0)),
                (center, Some(radius)) => {
                    let across = self.normal.cross(flat.normal().as_dvec3()).length() as f32;
                    has_sphere(center, radius * across)
                }
            },
            Light::Tube(tube) => tube.ends.iter().all(|end| has_sphere(*end, tube.radius)),
            // A light at infinity is where the corner sees it.
            _ => {
                let Sphere { center, radius } = light.bounds_from(&Sphere { center: self.corner, radius: 0.0 });
                has_sphere(center, radius)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lighting::{FlatLight, SphereLight, SunLight};
    use scene::{Object, Proxy};

    fn scene() -> Scene {
        let mut scene = scene::builtin();
        scene.objects.truncate(1);
        scene.objects.push(Object::mesh("box", Mesh::cuboid(Vec3::Y * 0.5, Vec3::ONE), 0, Proxy::None));
        scene
    }

    fn lamp(y: f32) -> Light {
        SphereLight::new(Sphere { center: Vec3::new(1.0, y, 0.0), radius: 0.3 }, Vec3::ONE).into()
    }

    #[test]
    fn floors_are_backdrops_unless_something_is_behind() {
        let mut scene = scene();
        scene.lights = vec![lamp(3.0)];
        let is_backdrop = |scene: &Scene| [0, 1].map(|object| Backdrops::new(scene, None).has(object));
        assert_eq!(is_backdrop(&scene), [true, false]);
        // Lights behind or half sunk.
        for (y, want) in [(0.31, true), (0.29, false), (-3.0, false)] {
            scene.lights = vec![lamp(3.0), lamp(y)];
            assert_eq!(is_backdrop(&scene)[0], want, "{y}");
        }
        // All behind is all before.
        scene.lights = vec![lamp(-3.0)];
        scene.objects[1].shape = Shape::Mesh(Mesh::cuboid(Vec3::Y * -2.0, Vec3::ONE));
        assert_eq!(is_backdrop(&scene), [true, false]);
        scene.lights = vec![lamp(3.0)];
        assert_eq!(is_backdrop(&scene), [false, false]);
        // A receiver that is not seen needs no shadow.
        scene.objects[1].visible = false;
        assert!(is_backdrop(&scene)[0]);
    }

    #[test]
    fn a_table_over_a_wide_floor_blocks() {
        let sheet = |size: f32, y: f32| Shape::Mesh(Mesh::quad(Vec3::Y * y, Vec3::X * size, Vec3::NEG_Z * size));
        let mut scene = scene();
        scene.lights = vec![lamp(3.0)];
        for (size, y) in [(10.0, 1e-3), (1e4, 0.5), (1e6, 0.5)] {
            scene.objects[0].shape = sheet(size, 0.0);
            scene.objects[1].shape = sheet(0.5, y);
            assert_eq!([0, 1].map(|object| Backdrops::new(&scene, None).has(object)), [true, false], "{size} {y}");
        }
        // One that lies on the floor hides nothing.
        scene.objects[1].shape = sheet(0.5, 2e-5);
        assert!(Backdrops::new(&scene, None).has(1));
    }

    #[test]
    fn lights_are_where_they_are_seen() {
        let mut scene = scene();
        let world = Sphere { center: Vec3::Y * 50.0, radius: 3.0 };
        let sun = |y: f32| Light::from(SunLight::new(Vec3::new(1.0, y, 0.0).normalize(), 0.6, Vec3::ONE, world));
        for (y, want) in [(0.02, true), (0.005, false), (-0.02, false)] {
            scene.lights = vec![sun(y)];
            assert_eq!(Backdrops::new(&scene, None).has(0), want, "{y}");
        }
        let panel = FlatLight::rectangle(Vec3::Y * 0.1, Vec3::X, Vec3::Z, Vec3::ONE).expect("a panel");
        scene.lights = vec![panel.into()];
        assert!(Backdrops::new(&scene, None).has(0));
        scene.lights.clear();
        assert!(Backdrops::new(&scene, None).has(0));
    }
}
