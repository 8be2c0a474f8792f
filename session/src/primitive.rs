use core::fmt;
use glam::{Mat4, Vec3};
use lobe_core::Sphere;
use scene::{Bounds, Mesh, Object, Proxy, Shape};

/// Spheres that are fitted to a box for the strategy `spheres`, as to one of a scene file.
const SPHERES: usize = 64;

/// A simple object, which a scene file has as one key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// An exact sphere.
    Sphere(Sphere),
    /// A box along the axes: its middle, and its edges.
    Box {
        /// The middle.
        center: Vec3,
        /// The lengths of its edges, each above 0.
        size: Vec3,
    },
}

impl Primitive {
    /// A sphere that stands in the middle of the bottom of some bounds, a quarter as large as they are.
    #[must_use]
    pub fn sphere_on(around: Bounds) -> Self {
        let radius = 0.25 * reach(around);
        Self::Sphere(Sphere { center: on_bottom(around) + radius * Vec3::Y, radius })
    }

    /// A box that stands there, its edges half as long as the radius of the bounds.
    #[must_use]
    pub fn box_on(around: Bounds) -> Self {
        let size = Vec3::splat(0.5 * reach(around));
        Self::Box { center: on_bottom(around) + 0.5 * size * Vec3::Y, size }
    }

    /// The object as a scene file gives it, of the material of a number.
    ///
    /// ```
    /// use scene::{Bounds, glam::Vec3};
    /// use session::Primitive;
    /// let around = Bounds::EMPTY.with_point(Vec3::NEG_ONE).with_point(Vec3::ONE);
    /// let object = Primitive::box_on(around).object("box", 0);
    /// assert_eq!((object.shape.bounds().min.y, object.shape.triangle_count()), (-1.0, 12));
    /// ```
    #[must_use]
    pub fn object(self, name: impl Into<String>, material: usize) -> Object {
        match self {
            Self::Sphere(sphere) => Object::spheres(name, vec![sphere], material),
            Self::Box { center, size } => {
                Object::mesh(name, Mesh::cuboid(center, size), material, Proxy::Count(SPHERES))
            }
        }
    }

    /// The primitive that an object was before a matrix moved it; none of other objects. For a box to rounding.
    pub(crate) fn of(object: &Object, transform: Mat4) -> Option<Self> {
        let back = transform.inverse();
        match &object.shape {
            Shape::Spheres(spheres) => {
                let &[Sphere { center, radius }] = spheres.as_slice() else { return None };
                let scale = back.x_axis.truncate().length();
                Some(Self::Sphere(Sphere { center: back.transform_point3(center), radius: radius * scale }))
            }
            Shape::Mesh(mesh) if mesh.triangles.len() == 12 && mesh.positions.len() == 24 => {
                let corners: Vec<Vec3> = mesh.positions.iter().map(|p| back.transform_point3(*p)).collect();
                let bounds = corners.iter().fold(Bounds::EMPTY, |b, corner| b.with_point(*corner));
                let (center, size) = (bounds.center(), bounds.size());
                let near = 1e-5 * (size.max_element() + center.abs().max_element());
                let same = Mesh::cuboid(center, size);
                let is_same = same.positions.iter().zip(&corners).all(|(a, b)| a.distance(*b) <= near);
                (is_same && size.min_element() > 0.0).then_some(Self::Box { center, size })
            }
            _ => None,
        }
    }
}

impl fmt::Display for Primitive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sphere(_) => "sphere",
            Self::Box { .. } => "box",
        })
    }
}

/// The radius of bounds, above 0.
pub(crate) fn reach(around: Bounds) -> f32 {
    if around.is_empty() { 1.0 } else { around.radius().max(1e-3) }
}

fn on_bottom(around: Bounds) -> Vec3 {
    if around.is_empty() { Vec3::ZERO } else { around.center().with_y(around.min.y) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_moved_primitive_is_known_again() {
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
        let matrix = Mat4::from_scale_rotation_translation(Vec3::splat(1.5), turn, Vec3::new(3.0, -1.0, 2.0));
        let sphere = Primitive::Sphere(Sphere { center: Vec3::new(0.5, 1.0, -2.0), radius: 0.75 });
        let cuboid = Primitive::Box { center: Vec3::new(0.5, 1.0, -2.0), size: Vec3::new(1.0, 2.0, 3.0) };
        for own in [sphere, cuboid] {
            let mut object = own.object("it", 0);
            match &mut object.shape {
                Shape::Mesh(mesh) => mesh.transform(&matrix),
                Shape::Spheres(all) => {
                    all[0] = Sphere { center: matrix.transform_point3(all[0].center), radius: 1.5 * all[0].radius };
                }
                Shape::Instances(_) => {}
            }
            let numbers = |primitive| match primitive {
                Primitive::Sphere(Sphere { center, radius }) => [center, Vec3::splat(radius)],
                Primitive::Box { center, size } => [center, size],
            };
            let found = Primitive::of(&object, matrix).map(numbers).expect("a primitive");
            for (a, b) in found.into_iter().zip(numbers(own)) {
                assert!(a.distance(b) < 1e-5, "{own}: {a} {b}");
            }
        }
        let mut mesh = Mesh::cuboid(Vec3::ZERO, Vec3::ONE);
        mesh.positions[3].x += 0.01;
        assert_eq!(Primitive::of(&Object::mesh("bent", mesh, 0, Proxy::None), Mat4::IDENTITY), None);
    }
}
