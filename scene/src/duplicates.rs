use crate::{Object, Proxy, Shape};
use lobe_core::Sphere;
use std::collections::{HashMap, HashSet};

/// Finds equal spheres and equal meshes: two that lie in the same place are one surface and one blocker.
///
/// The first of several equal ones stands for all, if their objects are seen and block alike. Without that rule each would shadow
/// the surface of the other: a receiver lies on its own object's sphere and, because of rounding, inside the other's.
///
/// ```
/// use lobe_core::Sphere;
/// use scene::{Duplicates, Object};
/// let sphere = Sphere { radius: 1.0, ..Sphere::default() };
/// let object = Object::spheres("lamp", vec![sphere; 2], 0);
/// let mut duplicates = Duplicates::default();
/// assert!(duplicates.is_first(&object, &sphere));
/// assert!(!duplicates.is_first(&object, &sphere));
/// let quad = scene::Mesh::quad(glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y);
/// let objects = [1, 2].map(|_| Object::mesh("quad", quad.clone(), 0, scene::Proxy::None));
/// assert!(duplicates.is_first_mesh(&objects, 0));
/// assert!(!duplicates.is_first_mesh(&objects, 1));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Duplicates {
    known: HashSet<([u32; 4], bool, bool, Option<crate::Strategy>)>,
    /// Objects by their first vertex and the numbers of vertices and triangles.
    meshes: HashMap<([u32; 3], usize, usize), Vec<usize>>,
}

impl Duplicates {
    /// Forgets all spheres and meshes.
    pub fn clear(&mut self) {
        self.known.clear();
        self.meshes.clear();
    }

    /// Remembers the mesh of an object. Returns true if the object is no mesh, or if no earlier object with the same visibility
    /// and strategy had an equal mesh. Call it for all objects of one scene, in their order.
    pub fn is_first_mesh(&mut self, objects: &[Object], number: usize) -> bool {
        let object = &objects[number];
        let (first, vertices) = match &object.shape {
            Shape::Mesh(mesh) => (mesh.positions.first().copied(), mesh.positions.len()),
            Shape::Instances(all) => (Some(all.bounds().min), all.places().len()),
            Shape::Spheres(_) => return true,
        };
        let Some(first) = first else { return true };
        let key = ((first + 0.0).to_array().map(f32::to_bits), vertices, object.shape.triangle_count());
        let alike = self.meshes.entry(key).or_default();
        let is_duplicate = alike.iter().any(|other| {
            let other = &objects[*other];
            let same = match (&object.shape, &other.shape) {
                (Shape::Mesh(a), Shape::Mesh(b)) => (&a.positions, &a.triangles) == (&b.positions, &b.triangles),
                (Shape::Instances(a), Shape::Instances(b)) => a == b,
                _ => false,
            };
            let blocks =
                (other.visible, other.strategy, &other.proxy) == (object.visible, object.strategy, &object.proxy);
            blocks && same
        });
        if !is_duplicate {
            alike.push(number);
        }
        !is_duplicate
    }

    /// Remembers a sphere of an object; true when no equal one of an object that is seen and blocks like this one came before.
    pub fn is_first(&mut self, object: &Object, sphere: &Sphere) -> bool {
        let bits = [sphere.center.x, sphere.center.y, sphere.center.z, sphere.radius].map(|x| (x + 0.0).to_bits());
        self.known.insert((bits, object.visible, object.proxy == Proxy::None, object.strategy))
    }
}
